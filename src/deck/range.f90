!> Bounds of an expression by interval arithmetic. Bounds of its values by interval arithmetic, whether one formula holds
!> throughout, and whether it is defined throughout. Samples miss what comes and goes between them, bounds do not. They can be too
!> wide where a slot occurs several times, and get exact as the interval shrinks. What overflows on the way is infinite, so that its
!> inverse is zero; what is no number then may be any. Floor: deck. Source: Moore, Interval Analysis, 1966; doc/theory, eq. (5.43).
module limber_deck_range
   use limber_base_kinds, only: wp
   use limber_deck_expression, only: expression_type, max_stack, is_binary
   use limber_deck_operations, only: unary_value, binary_value, op_constant, op_slot, op_table, op_negate, op_add, op_subtract, &
      & op_multiply, op_divide, op_power, op_sqrt, op_sin, op_cos, op_tan, op_asin, op_acos, op_log, op_log10, op_cosh, op_abs, &
      & op_atan2, op_min, op_max, op_step, op_smoothstep, op_cycloidal, op_poly345
   use limber_deck_tables, only: table_range
   implicit none
   private
   public :: range_type, law_range, law_range_over

   !> Bounds of the values in an interval
   type :: range_type
      real(wp) :: low = 0.0_wp, high = 0.0_wp
      !> Whether min, max, abs, step, smoothstep and tables keep their formula
      logical :: whole = .true.
      !> Whether the value is defined and finite throughout, as far as the bounds tell
      logical :: defined = .true.
   end type range_type

   real(wp), parameter :: pi = acos(-1.0_wp), unbounded = huge(1.0_wp)

contains

   !> The range of a law, an expression whose only slot is the time, for t in [a, b].
   pure function law_range(law, a, b) result(range)
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: a, b
      type(range_type) :: range
      range = law_range_over(law, [a], [b])
   end function law_range

   !> The range of a law while each of its slots is within an interval.
   pure function law_range_over(law, low, high) result(range)
      type(expression_type), intent(in) :: law
      !> Ends of the intervals (slots)
      real(wp), intent(in) :: low(:), high(:)
      type(range_type) :: range
      type(range_type) :: stack(max_stack)
      logical :: whole, defined
      integer :: i, top
      top = 0
      whole = .true.
      defined = .true.
      do i = 1, size(law%codes)
         if (law%codes(i) == op_constant) then
            top = top + 1
            stack(top) = range_type(law%constants(law%operands(i)), law%constants(law%operands(i)))
         else if (law%codes(i) == op_slot) then
            top = top + 1
            stack(top) = range_type(low(law%operands(i)), high(law%operands(i)))
         else if (law%codes(i) == op_table) then
            stack(top)%whole = .true.
            call table_range(law%tables(law%operands(i):), stack(top)%low, stack(top)%high, stack(top)%whole)
         else if (is_binary(law%codes(i))) then
            top = top - 1
            stack(top) = binary_range(law%codes(i), stack(top), stack(top + 1))
         else
            stack(top) = unary_range(law%codes(i), stack(top))
         end if
         whole = whole .and. stack(top)%whole
         defined = defined .and. stack(top)%defined
      end do
      range = range_type(stack(1)%low, stack(1)%high, whole, defined)
      if (.not. (range%low >= -unbounded .and. range%high <= unbounded)) range = nowhere(whole)
   end function law_range_over

   !> All numbers: a value is not defined or not bounded somewhere.
   pure type(range_type) function nowhere(whole)
      logical, intent(in) :: whole
      nowhere = range_type(-unbounded, unbounded, whole, .false.)
   end function nowhere

   !> The interval that holds some numbers; all, if one of these is none.
   pure type(range_type) function hull(numbers)
      real(wp), intent(in) :: numbers(:)
      hull = nowhere(.true.)
      if (all(abs(numbers) >= 0.0_wp)) hull = range_type(minval(numbers), maxval(numbers))
   end function hull

   !> f(u).
   pure function unary_range(code, u) result(f)
      integer, intent(in) :: code
      type(range_type), intent(in) :: u
      type(range_type) :: f
      real(wp) :: ends(2)
      f = range_type()
      select case (code)
      case (op_sqrt); if (u%low < 0.0_wp) f = nowhere(.true.)
      case (op_log, op_log10); if (u%low <= 0.0_wp) f = nowhere(.true.)
      case (op_asin, op_acos); if (u%low < -1.0_wp .or. u%high > 1.0_wp) f = nowhere(.true.)
      case (op_tan); if (holds(u, 0.5_wp*pi, pi)) f = nowhere(.true.)
      end select
      if (.not. f%defined) return
      ends = [unary_value(code, u%low), unary_value(code, u%high)]
      f = hull(ends)
      if (.not. f%defined) return
      select case (code)
      case (op_sin, op_cos)
         if (holds(u, merge(0.5_wp*pi, 0.0_wp, code == op_sin), 2*pi)) f%high = 1.0_wp
         if (holds(u, merge(-0.5_wp*pi, pi, code == op_sin), 2*pi)) f%low = -1.0_wp
      case (op_cosh); if (u%low < 0.0_wp .and. u%high > 0.0_wp) f%low = 1.0_wp
      case (op_abs)
         f%whole = u%low >= 0.0_wp .or. u%high <= 0.0_wp
         if (.not. f%whole) f%low = 0.0_wp
      case (op_step); f%whole = u%low >= 0.0_wp .or. u%high < 0.0_wp
      case (op_smoothstep, op_poly345, op_cycloidal)
         f%whole = u%high < 0.0_wp .or. u%low >= 1.0_wp .or. (u%low >= 0.0_wp .and. u%high < 1.0_wp)
      end select
   end function unary_range

   !> Whether an interval holds one of the numbers first + k*period.
   pure logical function holds(u, first, period)
      type(range_type), intent(in) :: u
      real(wp), intent(in) :: first, period
      holds = .true.
      if (u%high - u%low >= period .or. max(abs(u%low), abs(u%high)) > 1.0e15_wp*period) return
      holds = floor((u%high - first)/period, kind(1_8)) >= ceiling((u%low - first)/period, kind(1_8))
   end function holds

   !> f(u, v).
   pure function binary_range(code, u, v) result(f)
      integer, intent(in) :: code
      type(range_type), intent(in) :: u, v
      type(range_type) :: f
      real(wp) :: corners(4)
      f = range_type()
      select case (code)
      case (op_add); f = hull([u%low + v%low, u%high + v%high])
      case (op_subtract); f = hull([u%low - v%high, u%high - v%low])
      case (op_multiply, op_divide)
         if (code == op_divide .and. v%low <= 0.0_wp .and. v%high >= 0.0_wp) then
            f = nowhere(.true.)
            return
         end if
         corners = [binary_value(code, u%low, v%low), binary_value(code, u%low, v%high), binary_value(code, u%high, v%low), &
            & binary_value(code, u%high, v%high)]
         f = hull(corners)
      case (op_power); f = power_range(u, v)
      case (op_min); f = range_type(min(u%low, v%low), min(u%high, v%high), u%high <= v%low .or. v%high <= u%low)
      case (op_max); f = range_type(max(u%low, v%low), max(u%high, v%high), u%high <= v%low .or. v%high <= u%low)
      case default
         ! atan2: jumps where u changes its sign while v is negative
         if (v%low < 0.0_wp .and. u%low < 0.0_wp .and. u%high >= 0.0_wp) then
            f = range_type(-pi, pi, .false.)
            return
         end if
         corners = [atan2(u%low, v%low), atan2(u%low, v%high), atan2(u%high, v%low), atan2(u%high, v%high)]
         f = hull(corners)
      end select
   end function binary_range

   !> u**v.
   pure function power_range(u, v) result(f)
      type(range_type), intent(in) :: u, v
      type(range_type) :: f
      real(wp) :: corners(4)
      logical :: constant
      constant = .not. v%high > v%low
      if (u%low <= 0.0_wp .and. .not. (constant .and. v%low >= 0.0_wp .and. (u%low >= 0.0_wp .or. is_whole(v%low)))) then
         ! A power that is not whole, of what may be negative; or the inverse of what may be zero
         if (.not. (constant .and. is_whole(v%low) .and. u%high < 0.0_wp)) then
            f = nowhere(.true.)
            return
         end if
      end if
      corners = [binary_value(op_power, u%low, v%low), binary_value(op_power, u%low, v%high), &
         & binary_value(op_power, u%high, v%low), binary_value(op_power, u%high, v%high)]
      f = hull(corners)
      if (f%defined .and. constant .and. u%low < 0.0_wp .and. u%high > 0.0_wp) f%low = min(f%low, 0.0_wp)
   end function power_range

   pure logical function is_whole(x)
      real(wp), intent(in) :: x
      is_whole = .not. abs(x - anint(x)) > 0.0_wp
   end function is_whole

end module limber_deck_range
