!> Whole numbers within names, as in bar<i>. `bar<i>`, `bar<i - 1>.end` with the index of a *REPEAT or any parameter. Floor: deck.
module limber_deck_template
   use limber_base_kinds, only: wp, long
   use limber_base_text, only: as_text
   use limber_deck_origin, only: part_of
   use limber_deck_lexer, only: part_type, trimmed
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_parameters, only: parameter_list_type
   use limber_deck_expression, only: expression_type
   use limber_deck_compile, only: compile
   implicit none
   private
   public :: fill_in

contains

   !> Replaces each <expression> in a text by its value.
   subroutine fill_in(part, parameters, ok, diagnostics)
      !> Its origin stays that of what was written
      type(part_type), intent(inout) :: part
      type(parameter_list_type), intent(in) :: parameters
      !> False if an expression is in error
      logical, intent(out) :: ok
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: filled
      type(part_type) :: inner
      integer :: first, open, close
      ok = .true.
      if (index(part%text, '<') == 0) return
      filled = ''
      first = 1
      do
         open = index(part%text(first:), '<') + first - 1
         if (open < first) exit
         close = index(part%text(open:), '>') + open - 1
         if (close < open) then
            call diagnostics%add(part_of(part%origin, open, open), "a '>' is missing behind '<'", &
               & 'write bar<i>, or bar<i - 1>.end')
            ok = .false.
            return
         end if
         inner = trimmed(part%text, part%origin, open + 1, close - 1)
         filled = filled//part%text(first:open - 1)//whole_number(inner, parameters, ok, diagnostics)
         if (.not. ok) return
         first = close + 1
      end do
      part%text = filled//part%text(first:)
   end subroutine fill_in

   !> The value of an expression as text.
   function whole_number(part, parameters, ok, diagnostics) result(text)
      type(part_type), intent(in) :: part
      type(parameter_list_type), intent(in) :: parameters
      logical, intent(out) :: ok
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: text
      type(expression_type) :: expression
      real(wp) :: value
      text = ''
      call compile(part%text, part%origin, parameters, expression, ok, diagnostics)
      if (.not. ok) return
      value = expression%constant_value()
      ok = abs(value - anint(value)) <= 0.0_wp .and. abs(value) <= real(huge(1), wp)
      if (ok) then
         text = as_text(nint(value, long))
      else
         call diagnostics%add(part%origin, 'a number in a name must be a whole one, not '//as_text(value))
      end if
   end function whole_number

end module limber_deck_template
