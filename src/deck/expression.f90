!> Expression as a postfix program on a small stack. Made once by `limber_deck_compile`, evaluated in every step without allocation.
!> Floor: deck.
module limber_deck_expression
   use limber_base_kinds, only: wp, long
   use limber_deck_origin, only: origin_type
   use limber_deck_tables, only: table_value, table_segment
   use limber_deck_operations, only: jet_type, unary_value, binary_value, unary_jet, binary_jet, &
      & branch_of, function_arity, first_function, op_constant, op_slot, op_negate, op_divide, op_power, op_table
   implicit none
   private
   public :: expression_type, slot_type, max_stack, is_binary

   !> Deepest stack of a program; the compiler refuses what needs more
   integer, parameter :: max_stack = 64

   !> Something that an expression depends on: the time `t`, or a quantity of an object
   type :: slot_type
      !> 't', or the quantity: 'x' of x(slider)
      character(:), allocatable :: name
      !> Empty for the time, otherwise the object or object.point in lower case: 'slider'
      character(:), allocatable :: argument
      !> Where it is first used
      type(origin_type) :: origin
   end type slot_type

   !> A compiled expression
   type :: expression_type
      !> Operations in postfix order
      integer, allocatable :: codes(:)
      !> Of a constant or a slot: its index; of a table: where it begins in `tables`; otherwise unused
      integer, allocatable :: operands(:)
      !> Constants, parameters included
      real(wp), allocatable :: constants(:)
      !> Whether a constant is a parameter, or made of one (constants); unallocated: none is
      logical, allocatable :: named(:)
      !> The tables that occur in it, one behind the other; unallocated if there are none
      real(wp), allocatable :: tables(:)
      !> What it depends on, each once
      type(slot_type), allocatable :: slots(:)
   contains
      procedure :: evaluate
      procedure :: evaluate_jet
      procedure :: evaluate_along
      procedure :: branches
      procedure :: branches_along
      procedure :: may_bend
      procedure :: is_constant
      procedure :: constant_value
   end type expression_type

contains

   !> The value of an expression; NaN or infinite where it is not defined.
   pure real(wp) function evaluate(self, slot_values) result(value)
      class(expression_type), intent(in) :: self
      !> Value of each slot, in the order of `slots`
      real(wp), intent(in) :: slot_values(:)
      real(wp) :: stack(max_stack), point(0:2)
      integer :: i, top
      top = 0
      stack(1) = 0.0_wp
      do i = 1, size(self%codes)
         if (self%codes(i) == op_constant) then
            top = top + 1
            stack(top) = self%constants(self%operands(i))
         else if (self%codes(i) == op_slot) then
            top = top + 1
            stack(top) = slot_values(self%operands(i))
         else if (self%codes(i) == op_table) then
            point = table_value(self%tables(self%operands(i):), stack(top))
            stack(top) = point(0)
         else if (is_binary(self%codes(i))) then
            top = top - 1
            stack(top) = binary_value(self%codes(i), stack(top), stack(top + 1))
         else
            stack(top) = unary_value(self%codes(i), stack(top))
         end if
      end do
      value = stack(1)
   end function evaluate

   !> The value and its first and second derivative with respect to time of an expression whose only
   !> slot is the time.
   pure function evaluate_jet(self, t) result(jet)
      class(expression_type), intent(in) :: self
      !> Time [s]
      real(wp), intent(in) :: t
      type(jet_type) :: jet
      integer(long) :: taken
      call walk(self, [jet_type(t, 1.0_wp, 0.0_wp)], jet, taken)
   end function evaluate_jet

   !> The value and its first and second derivative along a line in the space of the slots.
   pure function evaluate_along(self, line) result(jet)
      class(expression_type), intent(in) :: self
      !> Value of each slot and its derivatives along the line, in the order of `slots`
      type(jet_type), intent(in) :: line(:)
      type(jet_type) :: jet
      integer(long) :: taken
      call walk(self, line, jet, taken)
   end function evaluate_along

   !> A number for the branches that min, max, abs, step, smoothstep and atan2 take at a time, right after it where it is a bend:
   !> while it does not change the expression is smooth. -1 if there is nothing to choose.
   pure integer(long) function branches(self, t)
      class(expression_type), intent(in) :: self
      !> Time [s]
      real(wp), intent(in) :: t
      type(jet_type) :: jet
      call walk(self, [jet_type(t, 1.0_wp, 0.0_wp)], jet, branches)
   end function branches

   !> The same number along a line in the space of the slots.
   pure integer(long) function branches_along(self, line) result(branches)
      class(expression_type), intent(in) :: self
      !> Value of each slot and its derivatives along the line, in the order of `slots`
      type(jet_type), intent(in) :: line(:)
      type(jet_type) :: jet
      call walk(self, line, jet, branches)
   end function branches_along

   !> Whether it is more than a polynomial: only then can it change much in a short part of what it depends on, or be made of
   !> several formulas.
   pure logical function may_bend(self)
      class(expression_type), intent(in) :: self
      may_bend = any(self%codes > op_power) .or. any(self%codes == op_divide)
   end function may_bend

   !> All of these.
   pure subroutine walk(self, line, jet, branches)
      class(expression_type), intent(in) :: self
      type(jet_type), intent(in) :: line(:)
      type(jet_type), intent(out) :: jet
      integer(long), intent(out) :: branches
      integer(long), parameter :: most = 2_long**48
      type(jet_type) :: stack(max_stack), u
      real(wp) :: point(0:2)
      integer :: i, top, branch, segment
      top = 0
      branches = -1
      do i = 1, size(self%codes)
         branch = -1
         if (self%codes(i) == op_constant) then
            top = top + 1
            stack(top) = jet_type(self%constants(self%operands(i)), 0.0_wp, 0.0_wp)
         else if (self%codes(i) == op_slot) then
            top = top + 1
            stack(top) = line(self%operands(i))
         else if (self%codes(i) == op_table) then
            u = stack(top)
            point = table_value(self%tables(self%operands(i):), u%value)
            stack(top) = jet_type(point(0), point(1)*u%first, point(2)*u%first**2 + point(1)*u%second)
            segment = table_segment(self%tables(self%operands(i):), u%value)
            branches = modulo(4099*max(0_long, branches) + segment, most)
         else if (is_binary(self%codes(i))) then
            top = top - 1
            branch = branch_of(self%codes(i), stack(top), stack(top + 1))
            stack(top) = binary_jet(self%codes(i), stack(top), stack(top + 1))
         else
            branch = branch_of(self%codes(i), stack(top), stack(top))
            stack(top) = unary_jet(self%codes(i), stack(top))
         end if
         if (branch >= 0) branches = modulo(3*max(0_long, branches) + branch, most)
      end do
      jet = stack(1)
   end subroutine walk

   !> Whether an expression depends on nothing; so does none, as that of a parameter whose number is all that is left of it.
   pure logical function is_constant(self)
      class(expression_type), intent(in) :: self
      is_constant = .true.
      if (allocated(self%slots)) is_constant = size(self%slots) == 0
   end function is_constant

   !> The value of an expression that depends on nothing.
   pure real(wp) function constant_value(self) result(value)
      class(expression_type), intent(in) :: self
      real(wp) :: no_slots(0)
      value = self%evaluate(no_slots)
   end function constant_value

   !> Whether an operation takes two values from the stack.
   elemental logical function is_binary(code)
      integer, intent(in) :: code
      if (code == op_table) then
         is_binary = .false.
      else if (code >= first_function) then
         is_binary = function_arity(code - first_function + 1) /= 1
      else
         is_binary = code > op_negate
      end if
   end function is_binary

end module limber_deck_expression
