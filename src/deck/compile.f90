!> Compiles the text of an expression into a postfix program: recursive descent, constants folded on the
!> way, so that a constant that is not defined is reported where it stands. Floor: deck.
!>
!>     expression: term {+|- term}        term: factor {*|/ factor}
!>     factor: -|+ factor | power         power: primary [** factor]
!>     primary: number | name | name(expression, ...) | (expression)
module limber_deck_compile
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use, intrinsic :: ieee_exceptions, only: ieee_all, ieee_set_flag
   use limber_base_kinds, only: wp
   use limber_base_text, only: lowercase, nearest_name, as_text
   use limber_deck_origin, only: origin_type, part_of
   use limber_deck_lexer, only: blanks, is_point, name_characters
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_parameters, only: parameter_list_type, name_length
   use limber_deck_expression, only: expression_type, slot_type, max_stack, is_binary
   use limber_deck_operations, only: unary_value, binary_value, unary_complaint, binary_complaint, &
      & function_names, function_arity, first_function, op_constant, op_slot, op_negate, op_add, op_subtract, &
      & op_multiply, op_divide, op_power
   implicit none
   private
   public :: compile, looks_like_expression, is_reserved

   !> Deepest nesting of parentheses, signs and exponents
   integer, parameter :: max_depth = 50
   character(*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyz_', digits = '0123456789'
   real(wp), parameter :: pi = 3.14159265358979323846_wp

   !> The state of one compilation
   type :: compiler_type
      !> Text in lower case, the column that is read next, and where the text stands
      character(:), allocatable :: text
      integer :: at = 1
      type(origin_type) :: origin
      !> What may occur beside numbers and parameters
      logical :: time = .false., quantities = .false.
      !> Program so far; `count` operations, `constants` constants, `slots` slots
      integer, allocatable :: codes(:), operands(:)
      real(wp), allocatable :: values(:)
      type(slot_type), allocatable :: slots(:)
      integer :: count = 0, value_count = 0
      !> Nesting of the parser, and stack that the program needs here
      integer :: depth = 0, stack = 0
      !> Set by the first error; `silent` if its cause has been reported elsewhere
      logical :: failed = .false., silent = .false.
      character(:), allocatable :: message, label, about
      type(origin_type) :: where
   end type compiler_type

contains

   !> Compiles an expression; the first error in it is added to the diagnostics.
   subroutine compile(text, origin, parameters, expression, ok, diagnostics, time, quantities)
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
      type(compiler_type) :: c
      c%text = lowercase(text)
      c%origin = origin
      if (present(time)) c%time = time
      if (present(quantities)) c%quantities = quantities
      allocate (c%codes(len(text) + 1), c%operands(len(text) + 1), c%values(len(text) + 1), c%slots(0))
      call parse_expression(c, parameters)
      call skip_blanks(c)
      if (.not. c%failed .and. c%at <= len(text)) call complain_rest(c)
      ok = .not. c%failed
      if (ok) then
         expression%codes = c%codes(:c%count)
         expression%operands = c%operands(:c%count)
         expression%constants = c%values(:c%value_count)
         call move_alloc(c%slots, expression%slots)
      else if (.not. c%silent) then
         if (allocated(c%about)) then
            call diagnostics%add(c%where, c%message, c%label, about=c%about)
         else
            call diagnostics%add(c%where, c%message, c%label)
         end if
      end if
   end subroutine compile

   !> Whether a text could continue an expression: made only of numbers, operators, parentheses and names
   !> that mean a number. Tells a power written with blanks from a comment.
   logical function looks_like_expression(text, parameters)
      character(*), intent(in) :: text
      type(parameter_list_type), intent(in) :: parameters
      type(compiler_type) :: c
      character(:), allocatable :: word
      c%text = lowercase(text)
      looks_like_expression = .false.
      call skip_blanks(c)
      if (c%at > len(text)) return
      do while (c%at <= len(text))
         if (scan(c%text(c%at:c%at), digits//'+-*/().,') > 0) then
            c%at = c%at + 1
         else
            word = next_word(c)
            if (len(word) == 0) return
            c%at = c%at + len(word)
            if (.not. (is_reserved(word) .or. parameters%find(word) > 0)) return
         end if
         call skip_blanks(c)
      end do
      looks_like_expression = .true.
   end function looks_like_expression

   !> Whether a name has a meaning in expressions already: the time, pi or a function.
   pure logical function is_reserved(name)
      character(*), intent(in) :: name
      is_reserved = lowercase(name) == 't' .or. lowercase(name) == 'pi' .or. any(function_names == lowercase(name))
   end function is_reserved

   recursive subroutine parse_expression(c, parameters)
      type(compiler_type), intent(inout) :: c
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
      type(compiler_type), intent(inout) :: c
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
      type(compiler_type), intent(inout) :: c
      type(parameter_list_type), intent(in) :: parameters
      integer :: at
      call skip_blanks(c)
      if (c%failed) return
      at = c%at
      c%depth = c%depth + 1
      if (c%depth > max_depth) then
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
      type(compiler_type), intent(inout) :: c
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
      type(compiler_type), intent(inout) :: c
      character(:), allocatable :: number
      character(16) :: form
      real(wp) :: value
      integer :: at, last, mark, status
      at = c%at
      last = at + span(c%text(at:), digits) - 1
      if (last < len(c%text)) then
         if (c%text(last + 1:last + 1) == '.') last = last + 1 + span(c%text(last + 2:), digits)
      end if
      number = c%text(at:last)
      mark = 0
      if (last < len(c%text)) then
         if (scan(c%text(last + 1:last + 1), 'ed') > 0) mark = last + 2
      end if
      if (mark > 0 .and. mark <= len(c%text)) then
         if (scan(c%text(mark:mark), '+-') > 0) mark = mark + 1
      end if
      if (mark > 0) then
         if (span(c%text(mark:), digits) > 0) then
            last = mark + span(c%text(mark:), digits) - 1
            number = c%text(at:last)
         end if
      end if
      c%at = last + 1
      if (scan(peek(c), letters) > 0) then
         last = last + len(next_word(c))
         call fail(c, at, last, "'"//c%text(at:last)//"' is not a number", &
            & 'digits such as 1.5e-3; units are not written, a product needs *')
         return
      end if
      write (form, '("(f",i0,".0)")') len(number)
      read (number, form, iostat=status) value
      if (verify(number, '.') == 0) status = 1
      if (status == 0 .and. .not. ieee_is_finite(value)) status = -1
      if (status < 0 .or. status > 0 .and. mark > 0) then
         call fail(c, at, last, "'"//number//"' is too large a number", 'the largest is about 1.8e308')
      else if (status > 0) then
         call fail(c, at, last, "'"//number//"' is not a number")
      else
         call push_constant(c, value, at)
      end if
   end subroutine parse_number

   recursive subroutine parse_name(c, parameters)
      type(compiler_type), intent(inout) :: c
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
      else if (called .and. c%quantities .and. word /= 't' .and. word /= 'pi') then
         call parse_quantity(c, word, at)
      else if (called) then
         call complain_call(c, word, at, last, found > 0 .or. word == 't' .or. word == 'pi')
      else if (word == 'pi') then
         call push_constant(c, pi, at)
      else if (word == 't' .and. c%time) then
         call push_slot(c, word, '', at, at)
      else if (word == 't') then
         call fail(c, at, last, 'the time t has no meaning here', 'this number must be a constant')
      else if (found == 0) then
         call complain_name(c, parameters, word, at, last)
      else if (.not. parameters%items(found)%valid) then
         c%failed = .true.
         c%silent = .true.
      else
         call push_constant(c, parameters%items(found)%value, at)
      end if
   end subroutine parse_name

   recursive subroutine parse_function(c, parameters, word, at, last)
      type(compiler_type), intent(inout) :: c
      type(parameter_list_type), intent(in) :: parameters
      !> Name of the function and the columns of its name
      character(*), intent(in) :: word
      integer, intent(in) :: at, last
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
         call fail(c, at, last, 'the function '//word//' does not take '//counted(arguments), &
            & 'it takes '//trim(merge('two or more', counted(abs(function_arity(which)))//repeat(' ', 0), &
            & function_arity(which) < 0)))
      else
         c%at = c%at + 1
         if (function_arity(which) > 0) call emit(c, first_function + which - 1, at, last)
      end if
   end subroutine parse_function

   !> '1 argument', '2 arguments'; always 11 letters or more.
   pure function counted(arguments) result(text)
      integer, intent(in) :: arguments
      character(11) :: text
      write (text, '(i0,a)') min(arguments, 9), ' argument'
      if (arguments /= 1) text(11:) = 's'
   end function counted

   !> quantity(object) or quantity(object.point).
   subroutine parse_quantity(c, word, at)
      type(compiler_type), intent(inout) :: c
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
      else if (.not. is_point(argument)) then
         call fail(c, first, last, "'"//argument//"' is not the name of an object or a point", &
            & 'write '//word//'(object) or '//word//'(object.point)')
      else
         c%at = close + 1
         call push_slot(c, word, argument, at, close)
      end if
   end subroutine parse_quantity

   subroutine push_constant(c, value, at)
      type(compiler_type), intent(inout) :: c
      real(wp), intent(in) :: value
      !> Column to complain at
      integer, intent(in) :: at
      c%value_count = c%value_count + 1
      c%values(c%value_count) = value
      call push(c, op_constant, c%value_count, at)
   end subroutine push_constant

   subroutine push_slot(c, name, argument, at, last)
      type(compiler_type), intent(inout) :: c
      character(*), intent(in) :: name, argument
      integer, intent(in) :: at, last
      type(slot_type), allocatable :: longer(:)
      integer :: i
      do i = 1, size(c%slots)
         if (c%slots(i)%name == name .and. c%slots(i)%argument == argument) exit
      end do
      if (i > size(c%slots)) then
         allocate (longer(i))
         longer(:i - 1) = c%slots
         longer(i)%name = name
         longer(i)%argument = argument
         longer(i)%origin = part_of(c%origin, at, last)
         call move_alloc(longer, c%slots)
      end if
      call push(c, op_slot, i, at)
   end subroutine push_slot

   subroutine push(c, code, operand, at)
      type(compiler_type), intent(inout) :: c
      integer, intent(in) :: code, operand, at
      c%count = c%count + 1
      c%codes(c%count) = code
      c%operands(c%count) = operand
      c%stack = c%stack + 1
      if (c%stack > max_stack) call fail(c, at, at, 'the expression is too deep', 'split it with *PARAMETER')
   end subroutine push

   !> Adds an operation, or carries it out at once if its operands are constants.
   subroutine emit(c, code, at, last)
      type(compiler_type), intent(inout) :: c
      !> Operation, and the columns of its symbol or name
      integer, intent(in) :: code, at, last
      character(:), allocatable :: complaint
      real(wp) :: u, v
      integer :: operands
      if (c%failed) return
      operands = merge(2, 1, is_binary(code))
      c%stack = c%stack - operands + 1
      if (.not. all(c%codes(c%count - operands + 1:c%count) == op_constant)) then
         c%count = c%count + 1
         c%codes(c%count) = code
         c%operands(c%count) = 0
         if (c%codes(c%count - 1) == op_constant .and. code == op_divide) then
            if (.not. abs(c%values(c%value_count)) > 0.0_wp) call fail(c, at, last, 'division by zero')
         end if
         return
      end if
      u = c%values(c%value_count - operands + 1)
      v = c%values(c%value_count)
      if (operands == 2) then
         complaint = binary_complaint(code, u, v)
         if (len(complaint) == 0) u = binary_value(code, u, v)
      else
         complaint = unary_complaint(code, u)
         if (len(complaint) == 0) u = unary_value(code, u)
      end if
      if (len(complaint) == 0 .and. .not. ieee_is_finite(u)) then
         complaint = 'the result is too large a number'
         call ieee_set_flag(ieee_all, .false.)
      end if
      if (len(complaint) > 0) then
         call fail(c, at, last, 'this expression has no value: '//complaint)
         return
      end if
      c%count = c%count - operands + 1
      c%value_count = c%value_count - operands + 1
      c%values(c%value_count) = u
      c%operands(c%count) = c%value_count
   end subroutine emit

   !> Reports what stands where an operator or the end is expected.
   subroutine complain_rest(c)
      type(compiler_type), intent(inout) :: c
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
      type(compiler_type), intent(inout) :: c
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
   end subroutine complain_call

   subroutine complain_name(c, parameters, word, at, last)
      type(compiler_type), intent(inout) :: c
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
      else
         call fail(c, at, last, "there is no parameter '"//word//"'", 'define it before with *PARAMETER')
      end if
      c%about = word
   end subroutine complain_name

   subroutine fail(c, first, last, message, label)
      type(compiler_type), intent(inout) :: c
      !> Columns within the text
      integer, intent(in) :: first, last
      character(*), intent(in) :: message
      character(*), intent(in), optional :: label
      if (c%failed) return
      c%failed = .true.
      c%message = message
      c%label = ''
      if (present(label)) c%label = label
      c%where = part_of(c%origin, first, last)
   end subroutine fail

   pure subroutine skip_blanks(c)
      type(compiler_type), intent(inout) :: c
      do while (c%at <= len(c%text))
         if (scan(c%text(c%at:c%at), blanks) == 0) exit
         c%at = c%at + 1
      end do
   end subroutine skip_blanks

   !> The next character, or two; blank behind the end.
   pure function peek(c, count) result(next)
      type(compiler_type), intent(in) :: c
      integer, intent(in), optional :: count
      character(:), allocatable :: next
      integer :: n
      n = 1
      if (present(count)) n = count
      next = repeat(' ', n)
      if (c%at + n - 1 <= len(c%text)) next = c%text(c%at:c%at + n - 1)
   end function peek

   !> The word of letters, digits and underscores that begins here; may be empty.
   pure function next_word(c) result(word)
      type(compiler_type), intent(in) :: c
      character(:), allocatable :: word
      word = ''
      if (c%at <= len(c%text)) word = c%text(c%at:c%at + span(c%text(c%at:), letters//digits) - 1)
   end function next_word

   !> Number of characters at the beginning of a text that belong to a set.
   pure integer function span(text, set)
      character(*), intent(in) :: text, set
      span = verify(text, set) - 1
      if (span < 0) span = len(text)
   end function span

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

end module limber_deck_compile
