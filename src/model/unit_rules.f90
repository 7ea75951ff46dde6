!> Units of expressions. The dimensions of the variables pass through the operations of an expression; the result is a text.
!> Floor: model.
module limber_model_unit_rules
   use limber_base_text, only: as_text
   use limber_deck_expression, only: expression_type, is_binary
   use limber_deck_operations, only: op_constant, op_slot, op_negate, op_add, op_subtract, op_multiply, op_divide, op_sqrt, &
      & op_abs, op_min, op_max
   use limber_model_model, only: units_type, dimension_type
   implicit none
   private
   public :: expression_units, unit_text

   !> Exponents of length, time and mass: an unknown dimension, and energy
   integer, parameter :: unknown = huge(1), energy(3) = [2, -2, 1]

   !> Dimension of an intermediate value of an expression
   type, extends(dimension_type) :: number_type
      !> True for a number without unit; true for a sum with such a number
      logical :: plain = .false., shifted = .false.
   end type number_type

contains

   !> Dimension of an expression and text of its unit. 'unknown' if dimensions do not fit together, or after multiplication by a
   !> parameter, which may have any dimension.
   subroutine expression_units(expression, slots, units, found, text)
      type(expression_type), intent(in) :: expression
      !> Dimensions of the variables (slots)
      type(dimension_type), intent(in) :: slots(:)
      type(units_type), intent(in) :: units
      type(dimension_type), intent(out) :: found
      character(:), allocatable, intent(out) :: text
      integer :: i
      found = dimension_of(expression, slots)
      ! A result with the dimension of an energy is a moment if a variable is a moment, and none is an angle or an energy
      found%moment = all(found%exponents == energy) .and. any(slots%moment) .and. all(slots%turns == 0) .and. &
         & .not. any([(all(slots(i)%exponents == energy) .and. .not. slots(i)%moment, i=1, size(slots))])
      if (found%open .or. any(found%exponents == unknown)) then
         text = 'unknown'
      else if (found%turns == 1 .and. all(found%exponents([1, 3]) == 0)) then
         text = 'rad'//power(units%time, found%exponents(2))
         if (found%exponents(2) == -1) text = 'rad/'//units%time
         if (found%exponents(2) < -1) text = 'rad/'//units%time//'^'//as_text(-found%exponents(2))
      else
         text = unit_text(found%exponents, units, found%moment)
      end if
   end subroutine expression_units

   !> Runs the postfix program of an expression on dimensions. A plain number takes the dimension of the other term in a sum. The
   !> product of such a sum and another plain number has an unknown dimension. Parameters are open: they may have any dimension.
   pure function dimension_of(expression, slots) result(dimension)
      type(expression_type), intent(in) :: expression
      type(dimension_type), intent(in) :: slots(:)
      type(dimension_type) :: dimension
      type(number_type) :: stack(128)
      integer :: i, top
      top = 0
      do i = 1, size(expression%codes)
         associate (code => expression%codes(i), operand => expression%operands(i))
            if (code == op_constant) then
               top = top + 1
               stack(top) = number_type(plain=.true.)
               if (allocated(expression%named)) stack(top)%open = expression%named(operand)
            else if (code == op_slot) then
               top = top + 1
               stack(top) = number_type()
               stack(top)%dimension_type = slots(operand)
            else if (is_binary(code)) then
               top = top - 1
               stack(top) = combined(code, stack(top), stack(top + 1))
            else if (code /= op_negate .and. code /= op_abs) then
               stack(top) = changed(code, stack(top))
            end if
         end associate
      end do
      dimension = stack(1)%dimension_type
   end function dimension_of

   !> Dimension of the result of a function of one argument.
   pure type(number_type) function changed(code, a) result(c)
      integer, intent(in) :: code
      type(number_type), intent(in) :: a
      c = number_type()
      if (a%open) then
         c%open = code == op_sqrt
      else if (any(a%exponents /= 0)) then
         c%exponents = unknown
      end if
   end function changed

   !> Dimension of the result of an operation with two operands.
   pure type(number_type) function combined(code, a, b) result(c)
      integer, intent(in) :: code
      type(number_type), intent(in) :: a, b
      c = number_type()
      c%plain = a%plain .and. b%plain
      select case (code)
      case (op_multiply, op_divide)
         c%shifted = a%shifted .or. b%shifted
         c%open = a%open .or. b%open
         if (c%open) return
         c%exponents = unknown
         if (any(a%exponents == unknown) .or. any(b%exponents == unknown)) return
         if (((a%plain .and. b%shifted) .or. (b%plain .and. a%shifted)) .and. any(abs(a%exponents) + abs(b%exponents) > 0)) return
         c%exponents = a%exponents + merge(b%exponents, -b%exponents, code == op_multiply)
         c%turns = a%turns + merge(b%turns, -b%turns, code == op_multiply)
      case (op_add, op_subtract, op_min, op_max)
         c%shifted = a%shifted .or. b%shifted .or. (a%plain .neqv. b%plain)
         c%open = a%open .and. b%open
         c%turns = max(a%turns, b%turns)
         c%exponents = unknown
         if (a%open .or. a%plain) then
            c%exponents = b%exponents
            if (b%open) c%exponents = a%exponents
         else if (b%open .or. b%plain .or. all(a%exponents == b%exponents)) then
            c%exponents = a%exponents
         end if
      case default
         c%open = a%open .or. b%open
         c%exponents = merge(0, unknown, all(a%exponents == 0) .and. all(b%exponents == 0))
      end select
   end function combined

   !> Text of a dimension in the deck's units: 'm', 'm/s', 'N', '1'.
   pure function unit_text(dimension, units, is_moment) result(text)
      !> Exponents of length, time and mass
      integer, intent(in) :: dimension(3)
      type(units_type), intent(in) :: units
      !> True: the dimension of an energy means a moment; default false
      logical, intent(in), optional :: is_moment
      character(:), allocatable :: text
      text = named(dimension, units%length//' '//units%mass//' '//units%time)
      if (present(is_moment)) then
         if (is_moment .and. all(dimension == energy)) text = named([1, -2, 1], units%length//' '//units%mass//' '//units%time) &
            & //' '//units%length
         if (text(1:min(1, len(text))) == ' ') text = ''
      end if
      if (text /= '') return
      text = power(units%mass, dimension(3))//power(units%length, dimension(1))//power(units%time, dimension(2))
      if (text == '') then
         text = '1'
      else
         text = text(2:)
      end if
   end function unit_text

   !> Units with their own names: of force, energy, stress, power; empty for others.
   pure function named(dimension, system) result(text)
      integer, intent(in) :: dimension(3)
      !> Units of length, mass and time
      character(*), intent(in) :: system
      character(:), allocatable :: text
      integer :: which
      integer, parameter :: known(3, 4) = reshape([1, -2, 1, 2, -2, 1, -1, -2, 1, 2, -3, 1], [3, 4])
      character(*), parameter :: names(4, 2) = reshape([character(3) :: 'N', 'J', 'Pa', 'W', 'N', 'mJ', 'MPa', 'mW'], [4, 2])
      text = ''
      do which = 1, size(known, 2)
         if (any(dimension /= known(:, which))) cycle
         if (system == 'm kg s') text = trim(names(which, 1))
         if (system == 'mm t s') text = trim(names(which, 2))
      end do
   end function named

   !> A unit with its exponent, after a blank; empty for exponent 0.
   pure function power(unit, exponent) result(text)
      character(*), intent(in) :: unit
      integer, intent(in) :: exponent
      character(:), allocatable :: text
      text = ''
      if (exponent /= 0) text = ' '//unit
      if (exponent /= 0 .and. exponent /= 1) text = text//'^'//as_text(exponent)
   end function power

end module limber_model_unit_rules
