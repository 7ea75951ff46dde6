!> Compiler of expressions by recursive descent. Recursive descent, constants folded on the way, so that a constant that is not
!> defined is reported where it stands. Floor: deck.
!>
!>     expression: term {+|- term}        term: factor {*|/ factor}
!>     factor: -|+ factor | power         power: primary [** factor]
!>     primary: number [deg] | name | name(expression, ...) | (expression)
module limber_deck_compile
   use, intrinsic :: ieee_exceptions, only: ieee_status_type, ieee_get_status, ieee_set_status, ieee_set_halting_mode, ieee_all
   use limber_base_kinds, only: wp
   use limber_base_text, only: lowercase, nearest_name, as_text
   use limber_deck_origin, only: origin_type
   use limber_deck_lexer, only: blanks, is_point
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_parameters, only: parameter_list_type, name_length
   use limber_deck_expression, only: expression_type
   use limber_deck_cursor, only: skip_blanks, peek, next_word, next_number, read_number, letters, digits
   use limber_deck_quantity_names, only: quantity_names
   use limber_deck_emitter, only: emitter_type, push_constant, push_slot, push_table, push_expression, emit, fail
   use limber_deck_operations, only: function_names, function_arity, first_function, op_negate, op_add, op_subtract, &
      & op_multiply, op_divide, op_power
   implicit none
   private
   public :: compile, looks_like_operand, is_reserved

   !> Deepest nesting of parentheses, signs and exponents
   integer, parameter :: max_depth = 50
   real(wp), parameter :: pi = 3.14159265358979323846_wp
   !> Unit that may stand behind a number: 90 deg
   character(*), parameter :: degrees = 'deg'

contains

   !> Compiles an expression; the first error in it is added to the diagnostics. An overflow of a constant is
   !> such an error: it neither halts nor leaves a floating-point flag.
   subroutine compile(text, origin, parameters, expression, ok, diagnostics, time, quantities, variables)
      !> Text without blanks around, and where it stands
      character(*), intent(in) :: text
      type(origin_type), intent(in) :: origin
      !> The parameters that are defined so far
      type(parameter_list_type), intent(in) :: parameters
      !> The program; of use only if `ok`
      type(expression_type), intent(out) :: expression
      logical, intent(out) :: ok
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Whether the time `t` and quantities such as x(slider) may occur (default: no)
      logical, intent(in), optional :: time, quantities
      !> Names that may occur as slots, before parameters of the same name (default: none)
      character(*), intent(in), optional :: variables(:)
      type(emitter_type) :: c
      type(ieee_status_type) :: floating
      c%text = lowercase(text)
      c%origin = origin
      if (present(time)) c%time = time
      if (present(quantities)) c%quantities = quantities
      if (present(variables)) then
         allocate (c%variables(size(variables)))
         c%variables = variables
      else
         allocate (c%variables(0))
      end if
      allocate (c%codes(len(text) + 1), c%operands(len(text) + 1), c%values(len(text) + 1), c%slots(0), &
         & c%named(len(text) + 1))
      call ieee_get_status(floating)
      call ieee_set_halting_mode(ieee_all, .false.)
      call parse_expression(c, parameters)
      call ieee_set_status(floating)
      call skip_blanks(c)
      if (.not. c%failed .and. c%at <= len(text)) call complain_rest(c)
      ok = .not. c%failed
      ! Where names have been filled in, columns of the text are not those of the line
      if (len(text) /= origin%last - origin%first + 1) then
         c%where = origin
         c%slots%origin = origin
      end if
      if (ok) then
         ! By statements: gfortran 12 reads unset bounds in an allocation by assignment
         allocate (expression%codes, source=c%codes(:c%count))
         allocate (expression%operands, source=c%operands(:c%count))
         allocate (expression%constants, source=c%values(:c%value_count))
         if (any(c%named(:c%value_count))) allocate (expression%named, source=c%named(:c%value_count))
         call move_alloc(c%slots, expression%slots)
         if (allocated(c%tables)) call move_alloc(c%tables, expression%tables)
      else if (c%silent) then
         call diagnostics%follow()
      else
         if (allocated(c%about)) then
            call diagnostics%add(c%where, c%message, c%label, about=c%about)
         else
            call diagnostics%add(c%where, c%message, c%label)
         end if
      end if
   end subroutine compile

   !> Whether a text behind asterisks begins with an operand, and goes on as an expression or a list would. Tells a power written
   !> with a blank from a comment.
   recursive logical function looks_like_operand(text, before, parameters) result(looks)
      !> Behind the asterisks; of the line before them, where parameters may be defined too
      character(*), intent(in) :: text, before
      type(parameter_list_type), intent(in) :: parameters
      type(emitter_type) :: c
      character(:), allocatable :: word
      looks = .false.
      c%text = lowercase(text)
      call skip_blanks(c)
      c%at = c%at + max(verify(text(c%at:)//'x', '+-') - 1, 0)
      if (c%at > len(text)) return
      word = next_word(c)
      if (scan(c%text(c%at:c%at), digits//'.') > 0) then
         word = next_number(c)
         c%at = c%at + len(word)
         looks = scan(word, digits) > 0
      else if (len(word) > 0) then
         c%at = c%at + len(word)
         looks = is_reserved(word) .or. parameters%find(word) > 0 .or. index(lowercase(before), word//'=') > 0
         if (.not. looks) looks = any(quantity_names == word) .and. peek(c) == '('
      end if
      if (peek(c) == '(') then
         looks = looks .or. len(word) == 0 .and. looks_like_operand(text(c%at + 1:), before, parameters)
         c%at = c%at + index(c%text(c%at:)//')', ')')
      end if
      call skip_blanks(c)
      if (c%at <= len(text)) looks = looks .and. scan(c%text(c%at:c%at), '+-*/,)') > 0
   end function looks_like_operand

   !> Whether a name has a meaning in expressions already: the time, pi or a function.
   pure logical function is_reserved(name)
      character(*), intent(in) :: name
      is_reserved = lowercase(name) == 't' .or. lowercase(name) == 'pi' .or. any(function_names == lowercase(name))
   end function is_reserved

   recursive subroutine parse_expression(c, parameters)
      type(emitter_type), intent(inout) :: c
      type(parameter_list_type), intent(in) :: parameters
      integer :: at, code
      call parse_term(c, parameters)
      do
         call skip_blanks(c)
         if (c%failed .or. scan(peek(c), '+-') == 0) exit
         at = c%at
         code = merge(op_add, op_subtract, peek(c) == '+')
         c%at = at + 1
         call parse_term(c, parameters)
         call emit(c, code, at, at)
      end do
   end subroutine parse_expression

   recursive subroutine parse_term(c, parameters)
      type(emitter_type), intent(inout) :: c
      type(parameter_list_type), intent(in) :: parameters
      integer :: at, code
      call parse_factor(c, parameters)
      do
         call skip_blanks(c)
         if (c%failed .or. scan(peek(c), '*/') == 0) exit
         at = c%at
         code = merge(op_multiply, op_divide, peek(c) == '*')
         c%at = at + 1
         call parse_factor(c, parameters)
         call emit(c, code, at, at)
      end do
   end subroutine parse_term

   recursive subroutine parse_factor(c, parameters)
      type(emitter_type), intent(inout) :: c
      type(parameter_list_type), intent(in) :: parameters
      integer :: at
      call skip_blanks(c)
      if (c%failed) return
      at = c%at
      c%depth = c%depth + 1
      if (c%depth > max_depth + 1) then
         call fail(c, at, at, 'the expression is nested more than '//as_text(max_depth)//' deep', &
            & 'split it with *PARAMETER')
      else if (peek(c) == '-' .or. peek(c) == '+') then
         c%at = at + 1
         call parse_factor(c, parameters)
         if (c%text(at:at) == '-') call emit(c, op_negate, at, at)
      else
         call parse_primary(c, parameters)
         call skip_blanks(c)
         at = c%at
         if (.not. c%failed .and. peek(c, 2) == '**') then
            c%at = at + 2
            call parse_factor(c, parameters)
            call emit(c, op_power, at, at + 1)
         end if
      end if
      c%depth = c%depth - 1
   end subroutine parse_factor

   recursive subroutine parse_primary(c, parameters)
      type(emitter_type), intent(inout) :: c
      type(parameter_list_type), intent(in) :: parameters
      integer :: at
      at = c%at
      if (scan(peek(c), digits//'.') > 0) then
         call parse_number(c)
      else if (scan(peek(c), letters) > 0) then
         call parse_name(c, parameters)
      else if (peek(c) == '(') then
         c%at = at + 1
         call parse_expression(c, parameters)
         call skip_blanks(c)
         if (c%failed) return
         if (peek(c) == ')') then
            c%at = c%at + 1
         else if (c%at > len(c%text)) then
            call fail(c, at, at, "this parenthesis is never closed", "')' is missing")
         else
            call complain_rest(c)
         end if
      else if (len(c%text) == 0) then
         call fail(c, 1, 1, 'a number is missing', 'write a number or an expression here')
      else if (at > len(c%text)) then
         call fail(c, at, at, 'the expression ends too early', 'a number is missing here')
      else
         call fail(c, at, at, "'"//peek(c)//"' cannot stand here", 'a number is missing here')
      end if
   end subroutine parse_primary

   subroutine parse_number(c)
      type(emitter_type), intent(inout) :: c
      character(:), allocatable :: number
      real(wp) :: value
      integer :: at, last, status
      at = c%at
      number = next_number(c)
      c%at = at + len(number)
      last = c%at - 1
      if (scan(peek(c), letters) > 0 .and. next_word(c) /= degrees) then
         last = last + len(next_word(c))
         call fail(c, at, last, "'"//c%text(at:last)//"' is not a number", &
            & 'digits such as 1.5e-3; no unit but deg is written, a product needs *')
         return
      end if
      call read_number(number, value, status)
      call skip_blanks(c)
      if (next_word(c) == degrees) then
         c%at = c%at + len(degrees)
         value = value*pi/180
      end if
      select case (status)
      case (0); call push_constant(c, value, at)
      case (1); call fail(c, at, last, "'"//number//"' is not a number")
      case (3); call fail(c, at, last, "'"//number//"' is too small a number", 'the smallest is about 2.3e-308')
      case default; call fail(c, at, last, "'"//number//"' is too large a number", 'the largest is about 1.8e308')
      end select
   end subroutine parse_number

   recursive subroutine parse_name(c, parameters)
      type(emitter_type), intent(inout) :: c
      type(parameter_list_type), intent(in) :: parameters
      character(:), allocatable :: word
      integer :: at, last, found
      logical :: called
      word = next_word(c)
      at = c%at
      last = at + len(word) - 1
      c%at = last + 1
      call skip_blanks(c)
      called = peek(c) == '('
      found = parameters%find(word)
      if (any(function_names == word)) then
         call parse_function(c, parameters, word, at, last)
      else if (called .and. parameters%find_table(word) > 0) then
         call parse_table(c, parameters, parameters%find_table(word), word, at, last)
      else if (called .and. c%quantities .and. word /= 't' .and. word /= 'pi') then
         call parse_quantity(c, word, at)
      else if (called) then
         call complain_call(c, word, at, last, found > 0 .or. word == 't' .or. word == 'pi')
      else if (word == 'pi') then
         call push_constant(c, pi, at)
      else if (any(c%variables == word)) then
         call push_slot(c, word, '', at, at)
      else if (word == 't' .and. c%time) then
         call push_slot(c, word, '', at, at)
      else if (word == 't') then
         call fail(c, at, last, 'the time t has no meaning here', without_time(c%variables))
      else if (found == 0) then
         call complain_name(c, parameters, word, at, last)
      else if (.not. parameters%items(found)%valid) then
         c%failed = .true.
         c%silent = .true.
      else if (allocated(parameters%items(found)%law)) then
         call parse_named(c, parameters%items(found)%law, word, at, last)
      else
         call push_constant(c, parameters%items(found)%value, at, named=.true.)
      end if
   end subroutine parse_name

   !> The name of an expression stands for its text. Where the time or quantities have no meaning, it may not depend on them.
   subroutine parse_named(c, law, word, at, last)
      type(emitter_type), intent(inout) :: c
      type(expression_type), intent(in) :: law
      !> Name of the expression, and the columns of its name
      character(*), intent(in) :: word
      integer, intent(in) :: at, last
      character(:), allocatable :: label
      integer :: i
      label = without_time(c%variables)
      if (c%time) label = 'this may depend on the time alone'
      do i = 1, size(law%slots)
         if (law%slots(i)%argument == '' .and. .not. c%time) then
            call fail(c, at, last, "the expression '"//word//"' depends on the time, which has no meaning here", label)
         else if (law%slots(i)%argument /= '' .and. .not. c%quantities) then
            call fail(c, at, last, "the expression '"//word//"' depends on "//law%slots(i)%name//'('//law%slots(i)%argument// &
               & '), which has no meaning here', label)
         end if
      end do
      call push_expression(c, law, at, last)
   end subroutine parse_named

   recursive subroutine parse_function(c, parameters, word, at, last)
      type(emitter_type), intent(inout) :: c
      type(parameter_list_type), intent(in) :: parameters
      !> Name of the function and the columns of its name
      character(*), intent(in) :: word
      integer, intent(in) :: at, last
      character(:), allocatable :: wanted
      integer :: which, arguments, opened
      do which = 1, size(function_names)
         if (function_names(which) == word) exit
      end do
      if (peek(c) /= '(') then
         call fail(c, at, last, 'the function '//word//' needs its argument in parentheses', 'write '//word//'(...)')
         return
      end if
      opened = c%at
      arguments = 0
      do
         c%at = c%at + 1
         call parse_expression(c, parameters)
         call skip_blanks(c)
         if (c%failed) return
         arguments = arguments + 1
         if (arguments > 1 .and. function_arity(which) < 0) call emit(c, first_function + which - 1, at, last)
         if (peek(c) /= ',') exit
      end do
      if (c%at > len(c%text)) then
         call fail(c, opened, opened, 'this parenthesis is never closed', "')' is missing")
      else if (peek(c) /= ')') then
         call complain_rest(c)
      else if (arguments /= function_arity(which) .and. .not. (function_arity(which) < 0 .and. arguments > 1)) then
         wanted = 'two or more'
         if (function_arity(which) > 0) wanted = counted(function_arity(which))
         call fail(c, at, last, 'the function '//word//' does not take '//counted(arguments), 'it takes '//wanted)
      else
         c%at = c%at + 1
         if (function_arity(which) > 0) call emit(c, first_function + which - 1, at, last)
      end if
   end subroutine parse_function

   !> name(expression) of a table.
   recursive subroutine parse_table(c, parameters, which, word, at, last)
      type(emitter_type), intent(inout) :: c
      type(parameter_list_type), intent(in) :: parameters
      !> Index of the table, its name, and the columns of its name
      integer, intent(in) :: which
      character(*), intent(in) :: word
      integer, intent(in) :: at, last
      integer :: opened
      opened = c%at
      c%at = c%at + 1
      call parse_expression(c, parameters)
      call skip_blanks(c)
      if (c%failed) return
      if (c%at > len(c%text)) then
         call fail(c, opened, opened, 'this parenthesis is never closed', "')' is missing")
      else if (peek(c) == ',') then
         call fail(c, at, last, 'the table '//word//' takes 1 argument')
      else if (peek(c) /= ')') then
         call complain_rest(c)
      else
         c%at = c%at + 1
         call push_table(c, parameters%tables(which)%data)
      end if
   end subroutine parse_table

   !> '1 argument', '2 arguments'.
   pure function counted(arguments) result(text)
      integer, intent(in) :: arguments
      character(:), allocatable :: text
      text = as_text(arguments)//' argument'
      if (arguments /= 1) text = text//'s'
   end function counted

   !> quantity(object) or quantity(object.point).
   subroutine parse_quantity(c, word, at)
      type(emitter_type), intent(inout) :: c
      character(*), intent(in) :: word
      integer, intent(in) :: at
      character(:), allocatable :: argument
      integer :: first, last, close
      close = index(c%text(c%at:), ')')
      if (close == 0) then
         call fail(c, c%at, c%at, 'this parenthesis is never closed', "')' is missing")
         return
      end if
      close = c%at + close - 1
      first = c%at + 1
      last = close - 1
      do while (first <= last)
         if (scan(c%text(first:first), blanks) == 0) exit
         first = first + 1
      end do
      do while (last >= first)
         if (scan(c%text(last:last), blanks) == 0) exit
         last = last - 1
      end do
      argument = c%text(first:last)
      if (len(argument) == 0) then
         call fail(c, at, close, 'the quantity '//word//' of what?', 'write '//word//'(object) or '//word//'(object.point)')
      else if (index(argument, '(') > 0) then
         call fail(c, at, close, "'"//word//"(...)' is of a name, not of a quantity", 'give that a name as a channel of'// &
            & ' *OUTPUT, name = '//argument//'), and in a *SCALAR write '//word//'(name)')
      else if (.not. is_point(argument)) then
         call fail(c, at, close, "'"//word//"' is no function, and '"//argument//"' no object", 'a quantity is written '// &
            & word//'(object) or '//word//'(object.point); functions: '//listed(function_names))
      else
         c%at = close + 1
         call push_slot(c, word, argument, at, close)
      end if
   end subroutine parse_quantity

   !> Reports what stands where an operator or the end is expected.
   subroutine complain_rest(c)
      type(emitter_type), intent(inout) :: c
      integer :: last
      select case (peek(c))
      case (')')
         call fail(c, c%at, c%at, 'this parenthesis closes nothing', "no '(' belongs to it")
      case ('^')
         call fail(c, c%at, c%at, "'^' is not an operator", 'a power is written **')
      case ('=')
         call fail(c, c%at, c%at, "'=' cannot stand here", 'an expression has no =')
      case (',')
         call fail(c, c%at, c%at, "',' cannot stand here", 'only the arguments of a function are separated by commas')
      case default
         last = c%at + max(1, len(next_word(c))) - 1
         call fail(c, c%at, last, "'"//c%text(c%at:last)//"' cannot stand here", 'an operator + - * / ** is missing')
      end select
   end subroutine complain_rest

   subroutine complain_call(c, word, at, last, is_number)
      type(emitter_type), intent(inout) :: c
      character(*), intent(in) :: word
      integer, intent(in) :: at, last
      !> Whether the name means a number
      logical, intent(in) :: is_number
      integer :: near
      near = nearest_name(word, function_names)
      if (is_number) then
         call fail(c, at, last, "'"//word//"' is a number, not a function", 'a product needs *')
      else if (near > 0) then
         call fail(c, at, last, "there is no function '"//word//"'", "did you mean '"//trim(function_names(near))//"'?")
      else
         call fail(c, at, last, "there is no function '"//word//"'", 'valid: '//listed(function_names))
      end if
      c%about = word
   end subroutine complain_call

   subroutine complain_name(c, parameters, word, at, last)
      type(emitter_type), intent(inout) :: c
      type(parameter_list_type), intent(in) :: parameters
      character(*), intent(in) :: word
      integer, intent(in) :: at, last
      character(name_length) :: names(parameters%count + 1)
      integer :: near
      names(1) = 'pi'
      if (parameters%count > 0) names(2:) = parameters%items(:parameters%count)%name
      near = nearest_name(word, names)
      if (near > 0) then
         call fail(c, at, last, "there is no parameter '"//word//"'", "did you mean '"//trim(names(near))//"'?")
      else if (c%quantities) then
         call fail(c, at, last, "there is no parameter '"//word//"'", 'a quantity is written with its object: x('//word//')')
      else
         call fail(c, at, last, "there is no parameter '"//word//"'", 'define it before with *PARAMETER')
      end if
      c%about = word
   end subroutine complain_name

   !> Names separated by commas.
   pure function listed(names) result(text)
      character(*), intent(in) :: names(:)
      character(:), allocatable :: text
      integer :: i
      text = ''
      do i = 1, size(names)
         if (i > 1) text = text//', '
         text = text//trim(names(i))
      end do
   end function listed

   !> What may stand where the time may not.
   pure function without_time(variables) result(label)
      !> Names that have a meaning there
      character(*), intent(in) :: variables(:)
      character(:), allocatable :: label
      label = 'this number must be a constant'
      if (size(variables) == 0) return
      label = 'this may be an expression of '//trim(variables(1))
      if (variables(1) == 's') label = label//'; the third number of the line is the factor, which may depend on t'
   end function without_time

end module limber_deck_compile
