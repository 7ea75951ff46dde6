!> Operations and functions of expressions. Their names, their values, where they are not defined, and their first and second
!> derivatives. Floor: deck.
module limber_deck_operations
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_positive_inf
   use limber_base_kinds, only: wp
   implicit none
   private
   public :: branch_of, jet_type, unary_value, binary_value, unary_jet, binary_jet, unary_complaint, binary_complaint, &
      & function_names, function_arity, first_function, function_meanings
   public :: op_table, op_constant, op_slot, op_negate, op_add, op_subtract, op_multiply, op_divide, op_power
   public :: op_sqrt, op_sin, op_cos, op_tan, op_asin, op_acos, op_log, op_log10, op_cosh, op_abs, op_atan2, op_min, op_max, &
      & op_step, op_smoothstep, op_cycloidal, op_poly345

   !> Codes of a postfix program; the functions follow in the order of `function_names`
   integer, parameter :: op_constant = 1, op_slot = 2, op_negate = 3, op_add = 4, op_subtract = 5, &
      & op_multiply = 6, op_divide = 7, op_power = 8
   !> A table of one argument: behind all functions
   integer, parameter :: op_table = 1000
   !> Code of the first function
   integer, parameter :: first_function = 9
   integer, parameter :: op_sqrt = 9, op_sin = 10, op_cos = 11, op_tan = 12, op_asin = 13, op_acos = 14, &
      & op_atan = 15, op_sinh = 16, op_cosh = 17, op_tanh = 18, op_exp = 19, op_log = 20, op_log10 = 21, &
      & op_abs = 22, op_atan2 = 23, op_min = 24, op_max = 25, op_step = 26, op_smoothstep = 27, &
      & op_cycloidal = 28, op_poly345 = 29

   !> Names of the functions
   character(10), parameter :: function_names(*) = [character(10) :: 'sqrt', 'sin', 'cos', 'tan', 'asin', 'acos', &
      & 'atan', 'sinh', 'cosh', 'tanh', 'exp', 'log', 'log10', 'abs', 'atan2', 'min', 'max', 'step', 'smoothstep', &
      & 'cycloidal', 'poly345']
   !> Numbers of their arguments; -2: two or more
   integer, parameter :: function_arity(*) = [1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 2, -2, -2, 1, 1, 1, 1]
   !> What is worth saying about them
   character(*), parameter :: function_meanings = 'angles in rad; log is the natural logarithm; ' &
      & //'atan2(y, x); min and max of two or more; step(x) is 0 below x = 0 and 1 from there on, ' &
      & //'so that step(t - 1) acts at t = 1 already, in the equilibrium of a *STATICS that ends there too; ' &
      & //'smoothstep(x) rises from 0 at x = 0 to 1 at x = 1 with continuous second derivative; poly345(x) is the same, ' &
      & //'the 3-4-5 polynomial; cycloidal(x) does so as x - sin(2 pi x)/(2 pi)'

   real(wp), parameter :: two_pi = 2*acos(-1.0_wp)

   !> A value with its first and second derivative with respect to time
   type :: jet_type
      real(wp) :: value = 0.0_wp, first = 0.0_wp, second = 0.0_wp
   end type jet_type

   !> Numbers beyond which the inverse is nothing and derivatives may overflow
   real(wp), parameter :: endless = 1.0e280_wp

contains

   !> f(u).
   elemental real(wp) function unary_value(code, u) result(f)
      !> Code of an operation of one argument
      integer, intent(in) :: code
      real(wp), intent(in) :: u
      select case (code)
      case (op_negate); f = -u
      case (op_sqrt); f = sqrt(u)
      case (op_sin); f = sin(u)
      case (op_cos); f = cos(u)
      case (op_tan); f = tan(u)
      case (op_asin); f = asin(u)
      case (op_acos); f = acos(u)
      case (op_atan); f = atan(u)
      case (op_sinh); f = sinh(u)
      case (op_cosh); f = cosh(u)
      case (op_tanh); f = tanh(u)
      case (op_exp); f = exp(u)
      case (op_log); f = log(u)
      case (op_log10); f = log10(u)
      case (op_step); f = merge(1.0_wp, 0.0_wp, u >= 0.0_wp)
      case (op_smoothstep, op_poly345); f = smoothstep(u)
      case (op_cycloidal); f = cycloidal(u)
      case default; f = abs(u)
      end select
   end function unary_value

   !> f(u, v).
   elemental real(wp) function binary_value(code, u, v) result(f)
      !> Code of an operation of two arguments
      integer, intent(in) :: code
      real(wp), intent(in) :: u, v
      select case (code)
      case (op_add); f = u + v
      case (op_subtract); f = u - v
      case (op_multiply); f = u*v
      case (op_divide); f = u/v
      case (op_power); f = power(u, v)
      case (op_atan2); f = atan2(u, v)
      case (op_min); f = min(u, v)
      case default; f = max(u, v)
      end select
   end function binary_value

   !> 0 below 0, 1 above 1, and between the polynomial that joins them with continuous first and second derivatives.
   elemental real(wp) function smoothstep(u) result(f)
      real(wp), intent(in) :: u
      real(wp) :: x
      x = min(max(u, 0.0_wp), 1.0_wp)
      f = x**3*(10 + x*(6*x - 15))
   end function smoothstep

   !> 0 below 0, 1 above 1, and between the cycloid that joins them with continuous first and second derivatives.
   elemental real(wp) function cycloidal(u) result(f)
      real(wp), intent(in) :: u
      real(wp) :: x
      x = min(max(u, 0.0_wp), 1.0_wp)
      f = x - sin(two_pi*x)/two_pi
   end function cycloidal

   !> u**v; whole exponents take negative bases too.
   elemental real(wp) function power(u, v) result(f)
      real(wp), intent(in) :: u, v
      if (is_whole(v)) then
         f = u**nint(v)
      else
         f = u**v
      end if
   end function power

   elemental logical function is_whole(v)
      real(wp), intent(in) :: v
      is_whole = abs(v) < 1.0e6_wp
      if (is_whole) is_whole = .not. abs(v - anint(v)) > 0.0_wp
   end function is_whole

   !> f(u(t)) with its derivatives: f' = f_u u', f'' = f_uu u'^2 + f_u u''.
   elemental function unary_jet(code, u) result(f)
      integer, intent(in) :: code
      type(jet_type), intent(in) :: u
      type(jet_type) :: f
      real(wp) :: f_u, f_uu
      if (code == op_abs) then
         f = u
         if (is_below(u, jet_type())) f = jet_type(-u%value, -u%first, -u%second)
         return
      else if (code == op_sqrt .and. abs(u%value) <= 0.0_wp) then
         f = power_at_zero(u, 0.5_wp)
         return
      end if
      f%value = unary_value(code, u%value)
      call unary_derivatives(code, u%value, f%value, f_u, f_uu)
      ! Where it is flat to the last digit, what it depends on may have overflowed
      if (.not. abs(f_u) > 0.0_wp .and. any(code == [op_exp, op_tanh, op_atan])) return
      f%first = f_u*u%first
      f%second = f_uu*u%first**2 + f_u*u%second
   end function unary_jet

   !> First and second derivative of f at x, where its value is y.
   elemental subroutine unary_derivatives(code, x, y, f_u, f_uu)
      integer, intent(in) :: code
      real(wp), intent(in) :: x, y
      real(wp), intent(out) :: f_u, f_uu
      f_uu = 0.0_wp
      select case (code)
      case (op_negate); f_u = -1.0_wp
      case (op_sqrt); f_u = 0.5_wp/y; f_uu = -0.25_wp/(x*y)
      case (op_sin); f_u = cos(x); f_uu = -y
      case (op_cos); f_u = -sin(x); f_uu = -y
      case (op_tan); f_u = 1.0_wp + y**2; f_uu = 2.0_wp*y*f_u
      case (op_asin); f_u = 1.0_wp/sqrt(1.0_wp - x**2); f_uu = x*f_u**3
      case (op_acos); f_u = -1.0_wp/sqrt(1.0_wp - x**2); f_uu = x*f_u**3
      case (op_atan); f_u = 1.0_wp/(1.0_wp + x**2); f_uu = -2.0_wp*x*f_u**2
      case (op_sinh); f_u = cosh(x); f_uu = y
      case (op_cosh); f_u = sinh(x); f_uu = y
      case (op_tanh); f_u = 1.0_wp - y**2; f_uu = -2.0_wp*y*f_u
      case (op_exp); f_u = y; f_uu = y
      case (op_log); f_u = 1.0_wp/x; f_uu = -f_u**2
      case (op_log10); f_u = 1.0_wp/(x*log(10.0_wp)); f_uu = -f_u/x
      case (op_cycloidal)
         f_u = 0.0_wp
         if (x > 0.0_wp .and. x < 1.0_wp) then
            f_u = 1 - cos(two_pi*x)
            f_uu = two_pi*sin(two_pi*x)
         end if
      case (op_smoothstep, op_poly345)
         f_u = 0.0_wp
         if (x > 0.0_wp .and. x < 1.0_wp) then
            f_u = 30*x**2*(1 - x)**2
            f_uu = 60*x*(1 - x)*(1 - 2*x)
         end if
      case default; f_u = 0.0_wp
      end select
   end subroutine unary_derivatives

   !> f(u(t), v(t)) with its derivatives.
   elemental function binary_jet(code, u, v) result(f)
      integer, intent(in) :: code
      type(jet_type), intent(in) :: u, v
      type(jet_type) :: f
      real(wp) :: square, w
      f%value = binary_value(code, u%value, v%value)
      select case (code)
      case (op_add)
         f%first = u%first + v%first
         f%second = u%second + v%second
      case (op_subtract)
         f%first = u%first - v%first
         f%second = u%second - v%second
      case (op_multiply)
         f%first = times(u%first, v%value) + times(u%value, v%first)
         f%second = times(u%second, v%value) + 2.0_wp*times(u%first, v%first) + times(u%value, v%second)
      case (op_divide)
         ! Nothing over what has overflowed, or will in a derivative
         if (abs(v%value) > endless .and. abs(u%value) < sqrt(endless)) return
         f%first = (u%first - f%value*v%first)/v%value
         f%second = (u%second - 2.0_wp*f%first*v%first - f%value*v%second)/v%value
      case (op_power)
         f = power_jet(u, v)
      case (op_atan2)
         square = u%value**2 + v%value**2
         w = u%first*v%value - u%value*v%first
         f%first = w/square
         f%second = (u%second*v%value - u%value*v%second)/square &
            & - 2.0_wp*w*(u%value*u%first + v%value*v%first)/square**2
      case (op_min)
         f = v
         if (is_below(u, v)) f = u
      case default
         f = u
         if (is_below(u, v)) f = v
      end select
   end function binary_jet

   !> A product in which nothing times infinity is nothing: the derivative of x sqrt(|x|) at 0.
   elemental real(wp) function times(a, b)
      real(wp), intent(in) :: a, b
      if (abs(a) <= 0.0_wp .or. abs(b) <= 0.0_wp) then
         times = 0.0_wp
      else
         times = a*b
      end if
   end function times

   !> Whether u < v at this instant or, where they are equal, right after it: a bend in time has the derivatives of what
   !> follows, in every function of a law.
   elemental logical function is_below(u, v)
      type(jet_type), intent(in) :: u, v
      if (abs(u%value - v%value) > 0.0_wp) then
         is_below = u%value < v%value
      else if (abs(u%first - v%first) > 0.0_wp) then
         is_below = u%first < v%first
      else
         is_below = u%second < v%second
      end if
   end function is_below

   !> Which of the formulas of an operation holds at (u, v), 0 or more; -1 of an operation that has but one.
   elemental integer function branch_of(code, u, v) result(branch)
      integer, intent(in) :: code
      !> Arguments; of an operation with one argument, v is not used
      type(jet_type), intent(in) :: u, v
      select case (code)
      case (op_abs); branch = merge(1, 0, is_below(u, jet_type()))
      case (op_min, op_max); branch = merge(1, 0, is_below(u, v))
      case (op_step); branch = merge(1, 0, u%value >= 0.0_wp)
         ! It jumps where u changes its sign while v is negative
      case (op_atan2); branch = merge(1, 0, u%value < 0.0_wp .and. v%value < 0.0_wp)
      case (op_smoothstep, op_poly345, op_cycloidal); branch = merge(1, 0, u%value >= 0.0_wp) + merge(1, 0, u%value >= 1.0_wp)
      case default; branch = -1
      end select
   end function branch_of

   !> u**v: by the power rule if v does not change, otherwise as exp(v log u), where f_u and
   !> f_uu are the derivatives of v log u.
   elemental function power_jet(u, v) result(f)
      type(jet_type), intent(in) :: u, v
      type(jet_type) :: f, logarithm
      real(wp) :: c, f_u, f_uu
      c = v%value
      f%value = power(u%value, c)
      if (abs(u%value) > endless .and. abs(f%value) < 1/sqrt(endless)) return
      if (abs(v%first) > 0.0_wp .or. abs(v%second) > 0.0_wp) then
         logarithm = unary_jet(op_log, u)
         f_u = v%first*logarithm%value + c*logarithm%first
         f_uu = v%second*logarithm%value + 2.0_wp*v%first*logarithm%first + c*logarithm%second
         f%first = f%value*f_u
         f%second = f%value*(f_u**2 + f_uu)
      else if (abs(u%value) <= 0.0_wp .and. c > 0.0_wp .and. c < 2.0_wp .and. .not. is_whole(c)) then
         f = power_at_zero(u, c)
      else
         f_u = 0.0_wp
         f_uu = 0.0_wp
         if (abs(c) > 0.0_wp) f_u = c*power(u%value, c - 1.0_wp)
         if (abs(c*(c - 1.0_wp)) > 0.0_wp) f_uu = c*(c - 1.0_wp)*power(u%value, c - 2.0_wp)
         f%first = times(f_u, u%first)
         f%second = times(f_uu, u%first**2) + times(f_u, u%second)
      end if
   end function power_jet

   !> u**c right behind u = 0, for c below 2 and not whole: infinite derivatives, if u grows from there; the root of a square is a
   !> magnitude.
   elemental function power_at_zero(u, c) result(f)
      type(jet_type), intent(in) :: u
      real(wp), intent(in) :: c
      type(jet_type) :: f
      real(wp) :: infinite
      infinite = ieee_value(c, ieee_positive_inf)
      if (abs(u%first) > 0.0_wp) then
         if (c < 1.0_wp) f%first = infinite
         f%second = infinite
      else if (abs(u%second) > 0.0_wp) then
         if (c < 0.5_wp) f%first = infinite
         if (abs(c - 0.5_wp) <= 0.0_wp) f%first = sqrt(0.5_wp*max(0.0_wp, u%second))
         if (c < 1.0_wp .and. abs(c - 0.5_wp) > 0.0_wp) f%second = infinite
      end if
   end function power_at_zero

   !> Why f(u) is not defined; empty if it is.
   pure function unary_complaint(code, u) result(text)
      integer, intent(in) :: code
      real(wp), intent(in) :: u
      character(:), allocatable :: text
      text = ''
      select case (code)
      case (op_sqrt); if (u < 0.0_wp) text = 'the root of a negative number'
      case (op_log, op_log10); if (u <= 0.0_wp) text = 'the logarithm of a number that is not positive'
      case (op_asin, op_acos); if (abs(u) > 1.0_wp) text = 'the argument is outside -1 to 1'
      end select
   end function unary_complaint

   !> Why f(u, v) is not defined; empty if it is.
   pure function binary_complaint(code, u, v) result(text)
      integer, intent(in) :: code
      real(wp), intent(in) :: u, v
      character(:), allocatable :: text
      text = ''
      select case (code)
      case (op_divide)
         if (.not. abs(v) > 0.0_wp) text = 'division by zero'
      case (op_power)
         if (u < 0.0_wp .and. .not. is_whole(v)) text = 'a negative number to a power that is not whole'
         if (.not. abs(u) > 0.0_wp .and. v < 0.0_wp) text = 'zero to a negative power'
      case (op_atan2)
         if (.not. (abs(u) > 0.0_wp .or. abs(v) > 0.0_wp)) text = 'atan2(0, 0) has no value'
      end select
   end function binary_complaint

end module limber_deck_operations
