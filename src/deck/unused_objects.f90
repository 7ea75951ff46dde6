!> Objects of a deck that nothing uses: materials, sections, tables, curves, controls, switches and named expressions. Those of
!> files that the deck includes are left out: such a file may hold what several decks use. Floor: deck.
module limber_deck_unused_objects
   use limber_base_names, only: name_index_type
   use limber_base_text, only: lowercase
   use limber_deck_content, only: deck_type, block_type
   use limber_deck_cursor, only: letters, digits
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_keywords, only: contains_value
   use limber_deck_origin, only: origin_type
   implicit none
   private
   public :: warn_of_unused

   !> Keywords of objects that do nothing by themselves
   character(*), parameter :: kinds = 'MATERIAL|SECTION|TABLE|CURVE|CONTROL|SWITCH'

contains

   !> Warns of each object whose name stands nowhere else in the deck.
   subroutine warn_of_unused(deck, diagnostics)
      type(deck_type), intent(in) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      type(name_index_type) :: names
      logical, allocatable :: used(:)
      integer :: i, k, m
      ! First their names, then the words of the deck; then the objects again, in the same order
      do i = 1, size(deck%blocks)
         if (is_object(deck%blocks(i))) call enter(deck%blocks(i)%name())
         if (deck%blocks(i)%keyword /= 'EXPRESSION') cycle
         do k = 1, size(deck%blocks(i)%lines)
            do m = 1, deck%blocks(i)%lines(k)%count()
               call enter(deck%blocks(i)%lines(k)%fields(m)%name)
            end do
         end do
      end do
      if (names%count == 0) return
      allocate (used(names%count), source=.false.)
      do i = 1, size(deck%blocks)
         call look(deck%blocks(i))
      end do
      do i = 1, size(deck%blocks)
         if (is_object(deck%blocks(i))) call tell(deck%blocks(i)%name(), deck%blocks(i)%origin_of('NAME'), &
            & lowercase(deck%blocks(i)%keyword))
         if (deck%blocks(i)%keyword /= 'EXPRESSION') cycle
         do k = 1, size(deck%blocks(i)%lines)
            do m = 1, deck%blocks(i)%lines(k)%count()
               associate (field => deck%blocks(i)%lines(k)%fields(m))
                  if (field%name /= '') call tell(field%name, field%origin, 'expression')
               end associate
            end do
         end do
      end do

   contains

      !> Adds a name; one of several kinds is one name here.
      subroutine enter(name)
         character(*), intent(in) :: name
         if (name == '') return
         if (names%find(name) == 0) call names%add(name, names%count + 1)
      end subroutine enter

      !> Marks all names in the options and data lines of a block, its own aside.
      subroutine look(block)
         type(block_type), intent(in) :: block
         integer :: n, j
         do n = 1, size(block%options)
            if (block%options(n)%given .and. block%options(n)%name /= 'NAME') call mark(block%options(n)%text)
         end do
         do n = 1, size(block%lines)
            if (.not. allocated(block%lines(n)%fields)) cycle
            do j = 1, size(block%lines(n)%fields)
               call mark(block%lines(n)%fields(j)%text)
            end do
         end do
      end subroutine look

      !> Marks all names in a text. A name may have a minus in it, and a minus may stand between two names.
      subroutine mark(written)
         character(*), intent(in) :: written
         character(*), parameter :: within = letters//digits//'_-'
         character(:), allocatable :: text
         integer :: first, last, from, to, found
         text = lowercase(written)
         first = 1
         do while (first <= len(text))
            last = first + verify(text(first:)//' ', within) - 2
            do from = first, last
               if (from > first) then
                  if (text(from - 1:from - 1) /= '-') cycle
               end if
               do to = from, last
                  if (to < last) then
                     if (text(to + 1:to + 1) /= '-') cycle
                  end if
                  found = names%find(text(from:to))
                  if (found > 0) used(found) = .true.
               end do
            end do
            first = max(first, last + 1) + merge(1, 0, last < first)
         end do
      end subroutine mark

      !> Warns of a name that is not marked.
      subroutine tell(name, origin, kind)
         character(*), intent(in) :: name, kind
         type(origin_type), intent(in) :: origin
         if (used(names%find(name)) .or. origin%file /= 1 .or. origin%turn > 0) return
         call diagnostics%warn(origin, kind//" '"//name//"' is not used", &
            & 'leave it out, or check the names where it was to be used')
      end subroutine tell

   end subroutine warn_of_unused

   !> Whether a block defines such an object.
   pure logical function is_object(block)
      type(block_type), intent(in) :: block
      is_object = contains_value(kinds, block%keyword)
      if (is_object) is_object = block%name() /= ''
   end function is_object

end module limber_deck_unused_objects
