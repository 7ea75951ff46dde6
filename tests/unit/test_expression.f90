!> Expressions of a deck: values, precedence, derivatives against finite differences, errors with columns.
program test_expression
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_deck_compile, only: compile
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_expression, only: expression_type
   use limber_deck_operations, only: jet_type
   use limber_deck_origin, only: origin_type
   use limber_deck_parameters, only: parameter_list_type, parameter_type
   use limber_deck_difference_terms, only: size_of_terms
   use testing, only: check, check_close, check_text, finish
   implicit none
   type(parameter_list_type) :: parameters
   call parameters%define(parameter_type(name='a', value=3.0_wp))
   call parameters%define(parameter_type(name='long_name_2', value=-0.5_wp))
   call parameters%define(parameter_type(name='broken', valid=.false.))
   call test_values()
   call test_functions()
   call test_derivatives()
   call test_special_derivatives()
   call test_bends()
   call test_slots()
   call test_errors()
   call test_depth()
   call finish()

contains

   subroutine test_values()
      call value('1', 1.0_wp)
      call value('1.', 1.0_wp)
      call value('.5', 0.5_wp)
      call value('1e3', 1000.0_wp)
      call value('1.5D-3', 1.5e-3_wp)
      call value('2E+2', 200.0_wp)
      call value('2e11', 2.0e11_wp)
      call value('12345678901234567890', 12345678901234567890.0_wp)
      call value('0.1', 0.1_wp)
      call value('0e-400', 0.0_wp)
      call value('1 + 2*3', 7.0_wp)
      call value('(1 + 2)*3', 9.0_wp)
      call value('10 - 4 - 3', 3.0_wp)
      call value('24/4/3', 2.0_wp)
      call value('2**3**2', 512.0_wp)
      call value('(2**3)**2', 64.0_wp)
      call value('2 ** 3', 8.0_wp)
      call value('-2**2', -4.0_wp)
      call value('(-2)**2', 4.0_wp)
      call value('(-2)**3', -8.0_wp)
      call value('2**-1', 0.5_wp)
      call value('2**-2**2', 2.0_wp**(-4))
      call value('-2*-3', 6.0_wp)
      call value('3*-2', -6.0_wp)
      call value('- -+1', 1.0_wp)
      call value('1/3', 1.0_wp/3.0_wp)
      call value('4**0.5', 2.0_wp)
      call value('0**0', 1.0_wp)
      call value('a*A', 9.0_wp)
      call value('1-long_name_2', 1.5_wp)
      call value('2*PI', 6.283185307179586_wp)
      call value(achar(9)//'1'//achar(9)//'+ 2', 3.0_wp)
   end subroutine test_values

   subroutine test_functions()
      call value('sqrt(2)', sqrt(2.0_wp))
      call value('SIN(1)', sin(1.0_wp))
      call value('cos (1)', cos(1.0_wp))
      call value('tan(1)', tan(1.0_wp))
      call value('asin(0.5)', asin(0.5_wp))
      call value('acos(0.5)', acos(0.5_wp))
      call value('atan(2)', atan(2.0_wp))
      call value('sinh(1)', sinh(1.0_wp))
      call value('cosh(1)', cosh(1.0_wp))
      call value('tanh(1)', tanh(1.0_wp))
      call value('exp(1)', exp(1.0_wp))
      call value('log(2)', log(2.0_wp))
      call value('log10(1000)', 3.0_wp)
      call value('abs(-2)', 2.0_wp)
      call value('atan2(1, -1)', atan2(1.0_wp, -1.0_wp))
      call value('min(3, 1, 2)', 1.0_wp)
      call value('max(3, 1, 5, 2)', 5.0_wp)
      call value('max(1, min(2, a))', 2.0_wp)
      call value('step(-1e-300)', 0.0_wp)
      call value('step(0)', 1.0_wp)
      call value('step(2)', 1.0_wp)
      call value('smoothstep(-1)', 0.0_wp)
      call value('smoothstep(0.5)', 0.5_wp)
      call value('smoothstep(0.25)', 0.103515625_wp)
      call value('smoothstep(1)', 1.0_wp)
      call value('smoothstep(3)', 1.0_wp)
      call value('poly345(0.25)', 0.103515625_wp)
      call value('cycloidal(-1)', 0.0_wp)
      call value('cycloidal(0.5)', 0.5_wp)
      call value('cycloidal(0.25)', 0.25_wp - 1/(8*atan(1.0_wp)))
      call value('cycloidal(2)', 1.0_wp)
   end subroutine test_functions

   !> A constant expression has a value, and is folded into one number.
   subroutine value(text, expected)
      character(*), intent(in) :: text
      real(wp), intent(in) :: expected
      type(expression_type) :: expression
      type(diagnostics_type) :: diagnostics
      logical :: ok
      call compile(text, origin_type(1, 1, 1, len(text)), parameters, expression, ok, diagnostics)
      call check(ok .and. diagnostics%count == 0, 'compiles: '//text)
      if (.not. ok) return
      call check(expression%is_constant() .and. size(expression%codes) == 1, 'is folded: '//text)
      call check_close(expression%constant_value(), expected, 4*spacing(abs(expected)), text)
   end subroutine value

   subroutine test_derivatives()
      call derivatives('t', 0.7_wp)
      call derivatives('3 - t', 0.7_wp)
      call derivatives('a*t + long_name_2', 0.7_wp)
      call derivatives('t*t*t', -0.7_wp)
      call derivatives('t**3', -0.7_wp)
      call derivatives('t**2.5', 0.7_wp)
      call derivatives('t**-2', -0.7_wp)
      call derivatives('t**t', 0.7_wp)
      call derivatives('a**t', 0.7_wp)
      call derivatives('1/t', 0.7_wp)
      call derivatives('sin(t)/(1 + t**2)', 0.7_wp)
      call derivatives('(t + 1)/(t - 2)', 0.7_wp)
      call derivatives('sqrt(t)', 0.7_wp)
      call derivatives('sin(2*t)', 0.7_wp)
      call derivatives('cos(t**2)', 0.7_wp)
      call derivatives('tan(t/2)', 0.7_wp)
      call derivatives('asin(t/2)', 0.7_wp)
      call derivatives('acos(t/2)', 0.7_wp)
      call derivatives('atan(2*t)', 0.7_wp)
      call derivatives('sinh(t)', 0.7_wp)
      call derivatives('cosh(2*t)', 0.7_wp)
      call derivatives('tanh(2*t)', 0.7_wp)
      call derivatives('exp(-t**2)', 0.7_wp)
      call derivatives('log(1 + t)', 0.7_wp)
      call derivatives('log10(t)', 0.7_wp)
      call derivatives('abs(t - 1)*t', 0.7_wp)
      call derivatives('atan2(sin(t), 2*cos(t))', 0.7_wp)
      call derivatives('min(t**2, t, 5)', 0.7_wp)
      call derivatives('max(t**2, t, -5)', 0.7_wp)
      call derivatives('-(150*t + 0.1*sin(3*t)**2)', 0.7_wp)
      call derivatives('t**2*step(t - 0.5) + t*step(0.5 - t)', 0.7_wp)
      call derivatives('t**2*step(t - 0.8) + t*step(0.8 - t)', 0.7_wp)
      call derivatives('smoothstep(t)', 0.7_wp)
      call derivatives('smoothstep(2*t**2)', 0.3_wp)
      call derivatives('smoothstep(2*t)', 0.7_wp)
      call derivatives('poly345(t)', 0.7_wp)
      call derivatives('cycloidal(t)', 0.7_wp)
      call derivatives('cycloidal(2*t**2)', 0.3_wp)
      call derivatives('cycloidal(2*t)', 0.7_wp)
      call derivatives('smoothstep(-t)', 0.7_wp)
   end subroutine test_derivatives

   !> Value and derivatives against the plain value and central differences of it.
   subroutine derivatives(text, t)
      character(*), intent(in) :: text
      real(wp), intent(in) :: t
      real(wp), parameter :: h = 1.0e-4_wp
      type(expression_type) :: expression
      type(diagnostics_type) :: diagnostics
      type(jet_type) :: jet
      real(wp) :: before, here, behind, scale
      logical :: ok
      call compile(text, origin_type(1, 1, 1, len(text)), parameters, expression, ok, diagnostics, time=.true.)
      call check(ok, 'compiles: '//text)
      if (.not. ok) return
      jet = expression%evaluate_jet(t)
      before = expression%evaluate([t - h])
      here = expression%evaluate([t])
      behind = expression%evaluate([t + h])
      scale = max(1.0_wp, abs(here))
      call check_close(jet%value, here, 0.0_wp, 'value of '//text)
      call check_close(jet%first, (behind - before)/(2*h), 1.0e-6_wp*scale, 'first derivative of '//text)
      call check_close(jet%second, (behind - 2*here + before)/h**2, 1.0e-5_wp*scale, 'second derivative of '//text)
   end subroutine derivatives

   !> Powers where the rule would divide zero by zero.
   subroutine test_special_derivatives()
      call derivatives('t**1', 0.0_wp)
      call derivatives('t**2', 0.0_wp)
      call derivatives('t**0', 0.0_wp)
      call derivatives('(t - 1)**3', 1.0_wp)
      call derivatives('0*t', 0.0_wp)
   end subroutine test_special_derivatives

   !> Where a law has a bend in time, all its functions have the derivatives of what follows: sums of them agree.
   subroutine test_bends()
      call bend('max(t - 2, 0)', 0.0_wp, 1.0_wp, 0.0_wp)
      call bend('max(0, t - 2)', 0.0_wp, 1.0_wp, 0.0_wp)
      call bend('max(2 - t, 0)', 0.0_wp, 0.0_wp, 0.0_wp)
      call bend('min(t, 2)', 2.0_wp, 0.0_wp, 0.0_wp)
      call bend('min(2, t)', 2.0_wp, 0.0_wp, 0.0_wp)
      call bend('min(t, 2) + max(t - 2, 0)', 2.0_wp, 1.0_wp, 0.0_wp)
      call bend('abs(t - 2)', 0.0_wp, 1.0_wp, 0.0_wp)
      call bend('abs(2 - t)', 0.0_wp, 1.0_wp, 0.0_wp)
      call bend('max((t - 2)**2, 0)', 0.0_wp, 0.0_wp, 2.0_wp)
      call bend('min(0, (t - 2)**2)', 0.0_wp, 0.0_wp, 0.0_wp)
      call bend('(1 - step(t - 2))*t**2 + step(t - 2)*(4 + 3*(t - 2))', 4.0_wp, 3.0_wp, 0.0_wp)
      call bend('smoothstep(t - 2)', 0.0_wp, 0.0_wp, 0.0_wp)
      call bend('cycloidal(t - 2)', 0.0_wp, 0.0_wp, 0.0_wp)
      call bend('smoothstep(t - 1)', 1.0_wp, 0.0_wp, 0.0_wp)
   end subroutine test_bends

   !> Value and derivatives at t = 2.
   subroutine bend(text, value, first, second)
      character(*), intent(in) :: text
      real(wp), intent(in) :: value, first, second
      type(expression_type) :: expression
      type(diagnostics_type) :: diagnostics
      type(jet_type) :: jet
      logical :: ok
      call compile(text, origin_type(1, 1, 1, len(text)), parameters, expression, ok, diagnostics, time=.true.)
      call check(ok, 'compiles: '//text)
      if (.not. ok) return
      jet = expression%evaluate_jet(2.0_wp)
      call check_close(jet%value, value, 0.0_wp, 'value at the bend of '//text)
      call check_close(jet%first, first, 0.0_wp, 'first derivative at the bend of '//text)
      call check_close(jet%second, second, 0.0_wp, 'second derivative at the bend of '//text)
   end subroutine bend

   subroutine test_slots()
      type(expression_type) :: expression
      type(diagnostics_type) :: diagnostics
      character(*), parameter :: text = 'X(slider-1) - 2*x( Slider-1 ) + y(rod.mid-point)*t'
      logical :: ok
      call compile(text, origin_type(2, 5, 10, 9 + len(text)), parameters, expression, ok, diagnostics, &
         & time=.true., quantities=.true.)
      call check(ok, 'quantities compile')
      call check(size(expression%slots) == 3, 'each slot once')
      call check_text(expression%slots(1)%name//'('//expression%slots(1)%argument//')', 'x(slider-1)', 'first slot')
      call check_text(expression%slots(2)%name//'('//expression%slots(2)%argument//')', 'y(rod.mid-point)', 'second slot')
      call check_text(expression%slots(3)%name//'('//expression%slots(3)%argument//')', 't()', 'third slot')
      call check(expression%slots(2)%origin%first == 42 .and. expression%slots(2)%origin%last == 57, 'origin of a slot')
      call check(expression%slots(2)%origin%file == 2 .and. expression%slots(2)%origin%line == 5, 'line of a slot')
      call check_close(expression%evaluate([5.0_wp, 7.0_wp, 11.0_wp]), 72.0_wp, 0.0_wp, 'value of quantities')
      call check_close(size_of_terms(expression, [5.0_wp, -7.0_wp, 11.0_wp]), 92.0_wp, 0.0_wp, 'terms of quantities')
      call check_terms('x(a) - y(b)', 12.0_wp)
      call check_terms('-(x(a) - y(b))/2 + abs(x(a) - 6)', 17.0_wp)
      call check_terms('max(x(a), y(b)) - sqrt(4)*3', 13.0_wp)
      call check_terms('(x(a) - y(b))**2', 4.0_wp)
   end subroutine test_slots

   !> Magnitudes of what is added up, for x = 5 and y = 7.
   subroutine check_terms(text, expected)
      character(*), intent(in) :: text
      real(wp), intent(in) :: expected
      type(expression_type) :: expression
      type(diagnostics_type) :: diagnostics
      logical :: ok
      call compile(text, origin_type(2, 5, 10, 9 + len(text)), parameters, expression, ok, diagnostics, time=.true., &
         & quantities=.true.)
      call check(ok, text)
      call check_close(size_of_terms(expression, [5.0_wp, 7.0_wp]), expected, 0.0_wp, 'terms of '//text)
   end subroutine check_terms

   subroutine test_errors()
      call fails('', 1, 1, 'a number is missing')
      call fails('1 +', 4, 4, 'the expression ends too early')
      call fails('1 + * 2', 5, 5, "'*' cannot stand here")
      call fails('2^3', 2, 2, "'^' is not an operator")
      call fails('(1 + 2', 1, 1, 'this parenthesis is never closed')
      call fails('1 + 2)', 6, 6, 'this parenthesis closes nothing')
      call fails('sin(1', 4, 4, 'this parenthesis is never closed')
      call fails('sin()', 5, 5, "')' cannot stand here")
      call fails('1 + 10mm', 5, 8, "'10mm' is not a number")
      call fails('.', 1, 1, "'.' is not a number")
      call fails('1e', 1, 2, "'1e' is not a number")
      call fails('2*1e999', 3, 7, "'1e999' is too large a number")
      call fails('1e99999999999999', 1, 16, "'1e99999999999999' is too large a number")
      call fails('2*frequency', 3, 11, "there is no parameter 'frequency'")
      call fails('2*frequency(1)', 3, 11, "there is no function 'frequency'")
      call fails('1 + t', 5, 5, 'the time t has no meaning here')
      call fails('1 + 2/(3 - a)', 6, 6, 'this expression has no value: division by zero')
      call fails('sqrt(2 - a)', 1, 4, 'this expression has no value: the root of a negative number')
      call fails('1 + log(0)', 5, 7, 'this expression has no value: the logarithm of a number that is not positive')
      call fails('acos(a)', 1, 4, 'this expression has no value: the argument is outside -1 to 1')
      call fails('atan2(0, 0)', 1, 5, 'this expression has no value: atan2(0, 0) has no value')
      call fails('1e200*1e200', 6, 6, 'this expression has no value: the result is too large a number')
      call fails('exp(1e3)', 1, 3, 'this expression has no value: the result is too large a number')
      call fails('(2 - a)**0.5', 8, 9, 'this expression has no value: a negative number to a power that is not whole')
      call fails('1e-400', 1, 6, "'1e-400' is too small a number")
      call fails('1 2', 3, 3, "'2' cannot stand here")
      call fails('1 ? 2', 3, 3, "'?' cannot stand here")
      call fails('broken + 1', 0, 0, '')
   end subroutine test_errors

   !> An expression is refused with one message at given columns; with none if the message is empty.
   subroutine fails(text, first, last, message)
      character(*), intent(in) :: text, message
      integer, intent(in) :: first, last
      type(expression_type) :: expression
      type(diagnostics_type) :: diagnostics
      logical :: ok
      call compile(text, origin_type(1, 3, 101, 100 + len(text)), parameters, expression, ok, diagnostics)
      call check(.not. ok, 'is refused: '//text)
      call check(diagnostics%kept == merge(0, 1, message == ''), 'number of errors: '//text)
      call check(diagnostics%count == 1, 'counts as an error: '//text)
      if (diagnostics%kept == 0) return
      call check_text(diagnostics%items(1)%message, message, text)
      associate (origin => diagnostics%items(1)%origin)
         call check_text(as_text(origin%first - 100)//'-'//as_text(origin%last - 100), as_text(first)//'-'//as_text(last), &
            & 'columns: '//text)
      end associate
   end subroutine fails

   !> Nesting that is allowed, nesting that is not, and long chains that need no depth.
   subroutine test_depth()
      call value(repeat('(', 50)//'1'//repeat(')', 50), 1.0_wp)
      call value('1'//repeat('+1', 2000), 2001.0_wp)
      call fails(repeat('(', 51)//'1'//repeat(')', 51), 52, 52, 'the expression is nested more than 50 deep')
      call fails(repeat('-', 4000)//'1', 52, 52, 'the expression is nested more than 50 deep')
      call fails('1'//repeat('**1', 1000), 154, 154, 'the expression is nested more than 50 deep')
      call derivatives('t'//repeat('+t', 1000), 0.5_wp)
      call deep_stack()
   end subroutine test_depth

   !> A stack that is deeper than the evaluation has: refused, never overrun.
   subroutine deep_stack()
      type(expression_type) :: expression
      type(diagnostics_type) :: diagnostics
      character(:), allocatable :: text
      logical :: ok
      text = repeat('t+t*t**(', 24)//'t'//repeat(')', 24)
      call compile(text, origin_type(1, 1, 1, len(text)), parameters, expression, ok, diagnostics, time=.true.)
      call check(.not. ok .and. diagnostics%count == 1, 'a deep stack is refused')
      if (diagnostics%count == 1) call check_text(diagnostics%items(1)%message, 'the expression is too deep', 'its message')
   end subroutine deep_stack

end program test_expression
