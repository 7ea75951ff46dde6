!> One mistake makes one error: each line of models/mistakes.txt puts one into models/mistakes.inp, and says which error it makes
!> and how its remedy begins; so does models/mistakes_frame.txt, of frames. Usage, in tests/: test_mistakes
program test_mistakes
   use limber_base_error, only: error_type
   use limber_base_text, only: newline
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_reader, only: read_deck_text
   use limber_scene_first_scene, only: build_scene
   use limber_scene_scene, only: scene_type
   use testing, only: check, finish
   implicit none
   character(:), allocatable :: deck

   call check_mistakes('models/mistakes_frame')
   call check_mistakes('models/mistakes')
   call check_warnings()
   deallocate (deck)
   call finish()

contains

   !> All lines of a list.
   subroutine check_mistakes(name)
      !> Of the deck and the list, without their endings
      character(*), intent(in) :: name
      character(:), allocatable :: mistakes
      integer :: first, last
      deck = contents(name//'.inp')
      mistakes = contents(name//'.txt')
      call check(count_of(answer(deck), 'error: ') == 0, 'the deck without a mistake: '//name)
      first = 1
      do while (first <= len(mistakes))
         last = first + index(mistakes(first:), newline) - 2
         if (mistakes(first:first) /= '#') call check_mistake(mistakes(first:last))
         first = last + 2
      end do
   end subroutine check_mistakes

   !> A line of the list.
   subroutine check_mistake(line)
      character(*), intent(in) :: line
      character(:), allocatable :: rest, old, new, message, remedy, text
      rest = line//' |'
      call cut(rest, old)
      call cut(rest, new)
      call cut(rest, message)
      call cut(rest, remedy)
      call check(count_of(deck, old) > 0, "'"//old//"' stands in the deck")
      text = answer(replaced(deck, old, new))
      call check(count_of(text, 'error: ') == 1, 'one error for '//line//newline//text)
      call check(index(text, 'error: '//message//newline) > 0, 'the error for '//line//newline//text)
      call check(index(text, '^ '//remedy) > 0 .or. len(remedy) == 0, 'the remedy for '//line//newline//text)
   end subroutine check_mistake

   !> Numbers that are possible, but hardly meant.
   subroutine check_warnings()
      call check(index(answer(replaced(deck, 'LENGTH=l', 'LENGTH=l, ANGLE=90')), 'ANGLE=90 is 14.3 turns: angles are in radians') &
         & > 0, 'degrees in place of radians')
      call check(index(answer(replaced(deck, 'LENGTH=l', 'LENGTH=l, ANGLE=90 deg')), 'radians') == 0, 'degrees as such')
      call check(index(answer(replaced(deck, '*GROUND', '*GRAVITY, Y=-9.81'//newline//'*UNITS, LENGTH=mm'//newline//'*GROUND')), &
         & 'gravity of 9.81 mm/s^2 is 0.001 times that of the earth') > 0, 'gravity in other units')
      call check(index(answer(replaced(deck, '*GROUND', '*GRAVITY'//newline//'*UNITS, LENGTH=furlong'//newline//'*GROUND')), &
         & 'error: gravity is not known in units of furlong and s') > 0, 'gravity in unknown units')
   end subroutine check_warnings

   !> Errors and warnings of a deck.
   function answer(deck) result(text)
      character(*), intent(in) :: deck
      character(:), allocatable :: text
      type(scene_type) :: scene
      type(diagnostics_type) :: diagnostics
      type(error_type), allocatable :: error
      call read_deck_text('mistakes.inp', deck, scene%deck, diagnostics)
      call build_scene(scene, diagnostics, error)
      text = scene%warnings//newline
   end function answer

   !> Takes the part before ' |' from the front of a text; '\n' in it is a line feed.
   subroutine cut(rest, part)
      character(:), allocatable, intent(inout) :: rest
      character(:), allocatable, intent(out) :: part
      integer :: bar
      bar = index(rest, ' |')
      part = replaced(rest(:bar - 1), '\n', newline)
      rest = rest(min(bar + 3, len(rest) + 1):)
   end subroutine cut

   !> A text with the first of some parts replaced; of '\n' all.
   recursive function replaced(text, old, new) result(other)
      character(*), intent(in) :: text, old, new
      character(:), allocatable :: other
      integer :: at
      at = index(text, old)
      other = text
      if (at == 0 .or. len(old) == 0) return
      other = text(:at - 1)//new//text(at + len(old):)
      if (old == '\n') other = text(:at - 1)//new//replaced(text(at + len(old):), old, new)
   end function replaced

   integer function count_of(text, part)
      character(*), intent(in) :: text, part
      integer :: from, at
      count_of = 0
      from = 1
      do
         at = index(text(from:), part)
         if (at == 0) return
         count_of = count_of + 1
         from = from + at + len(part) - 1
      end do
   end function count_of

   function contents(path) result(text)
      character(*), intent(in) :: path
      character(:), allocatable :: text
      integer :: unit, length
      inquire (file=path, size=length)
      allocate (character(max(0, length)) :: text)
      open (newunit=unit, file=path, access='stream', action='read', status='old')
      read (unit) text
      close (unit)
   end function contents

end program test_mistakes
