!> What the deck's grammar cannot know: every deck tests/models/bad_<name>.inp is refused, or warned of, with exactly the text
!> of bad_<name>.txt. Usage, in tests/: test_model
program test_model
   use limber_base_error, only: error_type, status_deck
   use limber_base_text, only: newline
   use limber_scene_first_scene, only: read_scene
   use limber_scene_scene, only: scene_type
   use testing, only: check, check_text, finish
   implicit none
   integer :: i
   character(*), parameter :: refused(*) = [character(32) :: 'cannot_assemble', 'channels', 'contradiction', 'cost', &
      & 'dead_centre', 'dead_rod', 'driven_against_joint', 'driven_point_mass', 'driven_twice', 'end_before_start', 'frame', &
      & 'joint_to_itself', 'joints', 'loads', 'motion', 'no_body', 'no_branch', 'no_output', 'origin_outside', 'point_names', &
      & 'point_off_beam', 'points', 'section', 'section_missing', 'segments', 'along', 'spread_loads', 'too_many_bending_modes', &
      & 'too_many_modes', 'turns_apart', 'welds', 'large_frame', 'moved_whole', 'held_rod', 'switches', 'controls', &
      & 'undriven_redundant']
   character(*), parameter :: warned(*) = [character(32) :: 'warn_exact_options', 'warn_no_tension', &
      & 'warn_redundant_coupler', 'warn_redundant_joint', 'warn_redundant_beam', 'warn_singular', 'warn_ramp', 'warn_ramp_load', &
      & 'warn_springs', 'warn_idle', 'warn_idle_model', 'warn_unused', 'warn_kept']

   do i = 1, size(refused)
      call check_refused(trim(refused(i)))
   end do
   do i = 1, size(warned)
      call check_warned(trim(warned(i)))
   end do
   call finish()

contains

   subroutine check_refused(name)
      character(*), intent(in) :: name
      type(scene_type) :: scene
      type(error_type), allocatable :: error
      call read_scene('models/bad_'//name//'.inp', scene, error)
      call check(allocated(error), name//' is refused')
      if (.not. allocated(error)) return
      call check(error%status == status_deck, name//' has the status of a deck error')
      call check_text(error%message//newline, contents('models/bad_'//name//'.txt'), name)
   end subroutine check_refused

   subroutine check_warned(name)
      character(*), intent(in) :: name
      type(scene_type) :: scene
      type(error_type), allocatable :: error
      call read_scene('models/bad_'//name//'.inp', scene, error)
      call check(.not. allocated(error), name//' is accepted')
      if (.not. allocated(error)) call check_text(scene%warnings, contents('models/bad_'//name//'.txt'), name)
   end subroutine check_warned

   function contents(path) result(text)
      character(*), intent(in) :: path
      character(:), allocatable :: text
      integer :: unit, status, length
      logical :: exists
      inquire (file=path, exist=exists, size=length)
      allocate (character(max(0, length)) :: text)
      if (.not. exists) return
      open (newunit=unit, file=path, access='stream', action='read', iostat=status)
      read (unit, iostat=status) text
      close (unit)
   end function contents

end program test_model
