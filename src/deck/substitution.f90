!> Substitution in compiled expressions. What an expression depends on is replaced by other expressions, as if their text stood
!> there. Floor: deck.
module limber_deck_substitution
   use limber_deck_emitter, only: emitter_type, push_expression
   use limber_deck_expression, only: expression_type
   use limber_deck_operations, only: op_slot
   use limber_deck_origin, only: origin_type
   implicit none
   private
   public :: replacement_type, replace_slots, slot_alone

   !> What takes the place of a slot; none if its program is not allocated
   type :: replacement_type
      type(expression_type) :: by
   end type replacement_type

contains

   !> An expression with slots replaced. A result that is too long, or a constant part of it without a value, is a complaint.
   subroutine replace_slots(expression, replacements, origin, replaced, complaint)
      type(expression_type), intent(in) :: expression
      !> For each slot of it (slots)
      type(replacement_type), intent(in) :: replacements(:)
      !> Place of the expression in the deck
      type(origin_type), intent(in) :: origin
      type(expression_type), intent(out) :: replaced
      !> Empty if all is well
      character(:), allocatable, intent(out) :: complaint
      type(emitter_type) :: c
      type(expression_type) :: piece
      integer :: i, k, columns
      c%text = ''
      c%origin = origin
      allocate (c%codes(1), c%operands(1), c%values(1), c%slots(0), c%named(1))
      columns = max(1, origin%last - origin%first + 1)
      do i = 1, size(expression%codes)
         if (expression%codes(i) == op_slot) then
            k = expression%operands(i)
            if (allocated(replacements(k)%by%codes)) then
               call push_expression(c, replacements(k)%by, 1, columns)
               cycle
            end if
         end if
         call take_operation(expression, i, piece)
         call push_expression(c, piece, 1, columns)
      end do
      complaint = ''
      if (c%failed) complaint = c%message
      if (c%failed) return
      allocate (replaced%codes, source=c%codes(:c%count))
      allocate (replaced%operands, source=c%operands(:c%count))
      allocate (replaced%constants, source=c%values(:c%value_count))
      if (any(c%named(:c%value_count))) allocate (replaced%named, source=c%named(:c%value_count))
      call move_alloc(c%slots, replaced%slots)
      if (allocated(c%tables)) call move_alloc(c%tables, replaced%tables)
      call keep_origins(expression, replaced)
      do k = 1, size(replacements)
         if (allocated(replacements(k)%by%codes)) call keep_origins(replacements(k)%by, replaced)
      end do
   end subroutine replace_slots

   !> The one operation of a program, as a program: on what is on top of the stack.
   subroutine take_operation(expression, i, piece)
      type(expression_type), intent(in) :: expression
      !> Its number
      integer, intent(in) :: i
      type(expression_type), intent(out) :: piece
      allocate (piece%codes(1), source=expression%codes(i))
      allocate (piece%operands(1), source=expression%operands(i))
      allocate (piece%constants, source=expression%constants)
      if (allocated(expression%named)) allocate (piece%named, source=expression%named)
      if (allocated(expression%tables)) allocate (piece%tables, source=expression%tables)
      allocate (piece%slots, source=expression%slots)
   end subroutine take_operation

   !> Slots that an expression has from another one stand where they stood in that.
   subroutine keep_origins(from, to)
      type(expression_type), intent(in) :: from
      type(expression_type), intent(inout) :: to
      integer :: i, k
      do i = 1, size(to%slots)
         do k = 1, size(from%slots)
            if (from%slots(k)%name == to%slots(i)%name .and. from%slots(k)%argument == to%slots(i)%argument) &
               & to%slots(i)%origin = from%slots(k)%origin
         end do
      end do
   end subroutine keep_origins

   !> The expression that is a slot and nothing else.
   function slot_alone(name, argument, origin) result(expression)
      !> As in `slot_type`
      character(*), intent(in) :: name, argument
      type(origin_type), intent(in) :: origin
      type(expression_type) :: expression
      allocate (expression%codes(1), source=op_slot)
      allocate (expression%operands(1), source=1)
      allocate (expression%constants(0))
      allocate (expression%slots(1))
      expression%slots(1)%name = name
      expression%slots(1)%argument = argument
      expression%slots(1)%origin = origin
   end function slot_alone

end module limber_deck_substitution
