!> Place of a piece of a deck: file, line, column. Every record, option and field keeps its origin, so that an error found much
!> later, also by the model builder, can show the line and a caret. Floor: deck.
module limber_deck_origin
   implicit none
   private
   public :: origin_type, part_of, after

   !> A stretch of one line of one file; columns count bytes from 1
   type :: origin_type
      !> Index into the files of the source; 0: nowhere in particular
      integer :: file = 0
      !> Line number; 0: the file as a whole
      integer :: line = 0
      !> First and last column; the last may lie one behind the end of the line ("missing here")
      integer :: first = 1, last = 1
      !> Index into the turns of *REPEAT of the source; 0: outside of any
      integer :: turn = 0
   end type origin_type

contains

   !> The stretch from the i-th to the j-th character of the text that stands at an origin.
   elemental function part_of(whole, i, j) result(part)
      !> Origin of the text
      type(origin_type), intent(in) :: whole
      !> Characters of the text, counted from 1
      integer, intent(in) :: i, j
      type(origin_type) :: part
      part = origin_type(whole%file, whole%line, whole%first + i - 1, whole%first + max(i, j) - 1, whole%turn)
   end function part_of

   !> The one column behind an origin: where something is missing.
   elemental function after(whole) result(part)
      type(origin_type), intent(in) :: whole
      type(origin_type) :: part
      part = origin_type(whole%file, whole%line, whole%last + 1, whole%last + 1, whole%turn)
   end function after

end module limber_deck_origin
