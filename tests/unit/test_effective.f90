!> Effective decks run again: that of each deck is accepted, without a word on options that have no effect, and says the same. So is
!> one that gives all defaults, as those of earlier versions do. Usage: test_effective <deck> ...
program test_effective
   use limber_base_error, only: error_type
   use limber_deck_content, only: deck_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_effective, only: effective_deck
   use limber_deck_reader, only: read_deck, read_deck_text
   use limber_scene_first_scene, only: build_scene
   use limber_scene_scene, only: scene_type
   use testing, only: check, check_text, finish
   implicit none
   character(1000) :: path
   integer :: i

   do i = 1, command_argument_count()
      call get_command_argument(i, path)
      call check_deck(trim(path))
   end do
   call finish()

contains

   !> The effective deck of one deck.
   subroutine check_deck(path)
      character(*), intent(in) :: path
      type(scene_type) :: first, again
      type(diagnostics_type) :: diagnostics
      type(error_type), allocatable :: error
      character(:), allocatable :: text
      call read_deck(path, first%deck, diagnostics)
      call build_scene(first, diagnostics, error)
      call check(.not. allocated(error), path//' is accepted')
      if (allocated(error)) return
      text = effective_deck(first%deck)
      call check_again(text, again)
      ! What is given is looked at: an option that means something beside a given one is there from now on
      text = effective_deck(again%deck)
      call check_again(text, again)
      call check_text(effective_deck(again%deck), text, 'the effective deck of the effective deck of '//path)
      call check(index(again%warnings, 'means nothing') == 0 .and. index(again%warnings, 'mean nothing') == 0, &
         & 'no option of the effective deck of '//path//' is idle: '//again%warnings)
      call check_defaults(path, first%deck)
   end subroutine check_deck

   !> Reads and builds an effective deck.
   subroutine check_again(text, scene)
      character(*), intent(in) :: text
      type(scene_type), intent(out) :: scene
      type(diagnostics_type) :: diagnostics
      type(error_type), allocatable :: error
      call read_deck_text('effective.inp', text, scene%deck, diagnostics)
      call build_scene(scene, diagnostics, error)
      call check(.not. allocated(error), 'an effective deck is accepted: '//scene%warnings)
   end subroutine check_again

   !> A deck that gives all defaults is read without an error.
   subroutine check_defaults(path, deck)
      character(*), intent(in) :: path
      type(deck_type), intent(in) :: deck
      type(deck_type) :: full, again
      type(diagnostics_type) :: diagnostics
      integer :: k, m
      full = deck
      do k = 1, size(full%blocks)
         do m = 1, size(full%blocks(k)%options)
            full%blocks(k)%options(m)%given = full%blocks(k)%options(m)%has_value
         end do
      end do
      call read_deck_text('full.inp', effective_deck(full), again, diagnostics)
      call check(diagnostics%count == 0, path//' with all defaults: '//diagnostics%render(again%source))
   end subroutine check_defaults

end program test_effective
