!> Output of the expression compiler. Constants, slots and operations one after the other. Operations on constants are carried out
!> at once, so that one without a value is reported where it stands. Floor: deck.
module limber_deck_emitter
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use limber_base_kinds, only: wp
   use limber_deck_origin, only: origin_type, part_of
   use limber_deck_cursor, only: cursor_type
   use limber_deck_expression, only: expression_type, slot_type, max_stack, is_binary
   use limber_deck_operations, only: unary_value, binary_value, unary_complaint, binary_complaint, op_table, op_constant, op_slot, &
      & op_divide
   implicit none
   private
   public :: emitter_type, push_constant, push_slot, push_table, push_expression, emit, fail

   character(*), parameter :: no_value = 'this expression has no value: '

   !> A program in the making, with the text that it is made of
   type, extends(cursor_type) :: emitter_type
      !> Where the text stands
      type(origin_type) :: origin
      !> What may occur beside numbers and parameters
      logical :: time = .false., quantities = .false.
      !> Names that stand for themselves, such as x and v of a spring
      character(8), allocatable :: variables(:)
      !> Program so far; `count` operations, `constants` constants, `slots` slots
      integer, allocatable :: codes(:), operands(:)
      real(wp), allocatable :: values(:)
      !> Whether a value is a parameter, or made of one
      logical, allocatable :: named(:)
      !> Tables that occur, one behind the other
      real(wp), allocatable :: tables(:)
      type(slot_type), allocatable :: slots(:)
      integer :: count = 0, value_count = 0
      !> Nesting of the parser, and stack that the program needs here
      integer :: depth = 0, stack = 0
      !> Set by the first error; `silent` if its cause has been reported elsewhere
      logical :: failed = .false., silent = .false.
      character(:), allocatable :: message, label, about
      type(origin_type) :: where
   end type emitter_type

contains

   !> Applies a table to what is on top of the stack.
   subroutine push_table(c, data)
      class(emitter_type), intent(inout) :: c
      !> As limber_deck_tables packs it
      real(wp), intent(in) :: data(:)
      if (c%failed) return
      if (.not. allocated(c%tables)) allocate (c%tables(0))
      c%count = c%count + 1
      c%codes(c%count) = op_table
      c%operands(c%count) = size(c%tables) + 1
      c%tables = [c%tables, data]
   end subroutine push_table

   !> Adds a compiled expression, as if its text stood here.
   subroutine push_expression(c, expression, at, last)
      class(emitter_type), intent(inout) :: c
      type(expression_type), intent(in) :: expression
      !> Columns of its name
      integer, intent(in) :: at, last
      !> Operations of a program at most: named expressions of named expressions grow as powers of two
      integer, parameter :: most = 20000
      logical :: named
      integer :: i
      if (c%count + size(expression%codes) > most) then
         call fail(c, at, last, 'the expression has more than 20000 operations', 'write it with fewer named expressions')
         return
      end if
      call reserve(c, size(expression%codes))
      do i = 1, size(expression%codes)
         select case (expression%codes(i))
         case (op_constant)
            named = .false.
            if (allocated(expression%named)) named = expression%named(expression%operands(i))
            call push_constant(c, expression%constants(expression%operands(i)), at, named)
         case (op_slot)
            associate (slot => expression%slots(expression%operands(i)))
               call push_slot(c, slot%name, slot%argument, at, last)
            end associate
         case (op_table)
            associate (first => expression%operands(i))
               call push_table(c, expression%tables(first:))
            end associate
         case default
            call emit(c, expression%codes(i), at, last)
         end select
         if (c%failed) return
      end do
   end subroutine push_expression

   !> Makes room for more operations and constants.
   subroutine reserve(c, more)
      class(emitter_type), intent(inout) :: c
      integer, intent(in) :: more
      integer, allocatable :: codes(:), operands(:)
      real(wp), allocatable :: values(:)
      logical, allocatable :: named(:)
      integer :: n
      n = size(c%codes) + more
      allocate (codes(n), operands(n), values(n), named(n))
      codes(:c%count) = c%codes(:c%count)
      operands(:c%count) = c%operands(:c%count)
      values(:c%value_count) = c%values(:c%value_count)
      named(:c%value_count) = c%named(:c%value_count)
      call move_alloc(codes, c%codes)
      call move_alloc(operands, c%operands)
      call move_alloc(values, c%values)
      call move_alloc(named, c%named)
   end subroutine reserve

   !> Adds a constant.
   subroutine push_constant(c, value, at, named)
      class(emitter_type), intent(inout) :: c
      real(wp), intent(in) :: value
      !> Column to complain at
      integer, intent(in) :: at
      !> Whether it is a parameter; false if not given
      logical, intent(in), optional :: named
      c%value_count = c%value_count + 1
      c%values(c%value_count) = value
      c%named(c%value_count) = .false.
      if (present(named)) c%named(c%value_count) = named
      call push(c, op_constant, c%value_count, at)
   end subroutine push_constant

   !> Adds the time or a quantity; one that occurs already shares its slot.
   subroutine push_slot(c, name, argument, at, last)
      class(emitter_type), intent(inout) :: c
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
      class(emitter_type), intent(inout) :: c
      integer, intent(in) :: code, operand, at
      c%count = c%count + 1
      c%codes(c%count) = code
      c%operands(c%count) = operand
      c%stack = c%stack + 1
      if (c%stack > max_stack) call fail(c, at, at, 'the expression is too deep', 'split it with *PARAMETER')
   end subroutine push

   !> Adds an operation, or carries it out at once if its operands are constants.
   subroutine emit(c, code, at, last)
      class(emitter_type), intent(inout) :: c
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
            if (.not. abs(c%values(c%value_count)) > 0.0_wp) call fail(c, at, last, no_value//'division by zero')
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
      if (len(complaint) == 0 .and. .not. ieee_is_finite(u)) complaint = 'the result is too large a number'
      if (len(complaint) > 0) then
         call fail(c, at, last, no_value//complaint)
         return
      end if
      c%count = c%count - operands + 1
      c%value_count = c%value_count - operands + 1
      c%named(c%value_count) = any(c%named(c%value_count:c%value_count + operands - 1))
      c%values(c%value_count) = u
      c%operands(c%count) = c%value_count
   end subroutine emit

   !> Notes the first error.
   subroutine fail(c, first, last, message, label)
      class(emitter_type), intent(inout) :: c
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

end module limber_deck_emitter
