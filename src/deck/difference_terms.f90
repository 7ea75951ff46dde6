!> Terms of channels that are differences. Beside them a difference may be no more than the errors of its terms. Floor: deck.
!> Source: doc/theory, eq. (5.42).
module limber_deck_difference_terms
   use limber_base_kinds, only: wp
   use limber_deck_expression, only: expression_type, max_stack, is_binary
   use limber_deck_operations, only: unary_value, binary_value, op_constant, op_slot, op_table, op_negate, op_abs, op_add, &
      & op_subtract, op_multiply, op_divide
   use limber_deck_tables, only: table_value
   implicit none
   private
   public :: size_of_terms

contains

   !> The value of an expression with its sums and differences those of magnitudes; functions are taken at their values.
   pure real(wp) function size_of_terms(expression, slots) result(size_of)
      type(expression_type), intent(in) :: expression
      !> Values, in the order of its slots
      real(wp), intent(in) :: slots(:)
      real(wp) :: value(max_stack), terms(max_stack), point(0:2)
      integer :: i, top
      top = 0
      value(1) = 0.0_wp
      terms(1) = 0.0_wp
      do i = 1, size(expression%codes)
         associate (code => expression%codes(i), operand => expression%operands(i))
            if (code == op_constant .or. code == op_slot) then
               top = top + 1
               if (code == op_constant) value(top) = expression%constants(operand)
               if (code == op_slot) value(top) = slots(operand)
               terms(top) = abs(value(top))
            else if (code == op_table) then
               point = table_value(expression%tables(operand:), value(top))
               value(top) = point(0)
               terms(top) = abs(value(top))
            else if (is_binary(code)) then
               top = top - 1
               call join(code, value(top), terms(top), value(top + 1), terms(top + 1))
            else
               value(top) = unary_value(code, value(top))
               if (code /= op_negate .and. code /= op_abs) terms(top) = abs(value(top))
            end if
         end associate
      end do
      size_of = terms(1)
   end function size_of_terms

   !> One operation of two values.
   pure subroutine join(code, value, terms, other, others)
      integer, intent(in) :: code
      !> The first, which becomes the result
      real(wp), intent(inout) :: value, terms
      !> The second
      real(wp), intent(in) :: other, others
      value = binary_value(code, value, other)
      select case (code)
      case (op_add, op_subtract); terms = terms + others
      case (op_multiply); terms = terms*others
      case (op_divide); terms = terms/max(abs(other), tiny(other))
      case default; terms = abs(value)
      end select
   end subroutine join

end module limber_deck_difference_terms
