!> Runs that are interrupted again and again and go on have the bits of those that are not: all that is in the file of results, with
!> every integrator. One that was killed before its first checkpoint begins anew, if it is the same deck.
program test_restart
   use hdf5, only: hid_t
   use limber_base_error, only: error_type, status_deck, status_interrupted
   use limber_base_files, only: remove_file
   use limber_base_kinds, only: long
   use limber_scene_interruption, only: request_type
   use limber_commands_run, only: run_deck
   use limber_output_checkpoint, only: checkpoint_name
   use limber_output_hdf5, only: reopen_file, close_file, write_attribute
   use pieces, only: compare_pieces, compare_files
   use runs, only: change_deck
   use testing, only: check, check_no_error, finish
   implicit none
   character(*), parameter :: integrators(*) = [character(10) :: 'ADAMS', 'RADAU', 'ALPHA', 'CONSERVING']
   character(512) :: argument

   call get_command_argument(1, argument)
   call test_all(trim(argument))
   call test_anew(trim(argument))
   call finish()

contains

   subroutine test_all(results)
      character(*), intent(in) :: results
      character(21) :: chosen
      integer :: i
      do i = 1, size(integrators)
         chosen = 'INTEGRATOR='//integrators(i)
         call compare_pieces('slider_crank_exact', results, 7, 'turns = 2', 'turns = 0.2', 'TOLERANCE=1e-8, OUTPUTS=838', &
            & 'TOLERANCE=1e-5, OUTPUTS=83, '//chosen)
         call compare_pieces('andrews_squeezer', results, 7, 'END=0.03, TOLERANCE=1e-8', 'END=0.03, TOLERANCE=1e-5', &
            & 'OUTPUTS=300, INTEGRATOR=ADAMS', 'OUTPUTS=60, '//chosen)
         call compare_pieces('four_bar_chain', results, 7, 'N = 40', 'N = 4', 'END=20, OUTPUTS=1000, TOLERANCE=1e-7', &
            & 'END=2, OUTPUTS=100, TOLERANCE=1e-5, '//chosen)
         call compare_pieces('chain_rigid', results, 7, 'N = 100', 'N = 12', 'OUTPUTS=100, FIXED STEP=1e-3, INTEGRATOR=ADAMS', &
            & 'OUTPUTS=50, TOLERANCE=1e-4, '//chosen)
         call compare_pieces('chain_flexible', results, 7, 'N = 100', 'N = 6', &
            & 'END=1, OUTPUTS=100, FIXED STEP=1e-3, INTEGRATOR=ALPHA', 'END=0.05, OUTPUTS=50, TOLERANCE=1e-4, '//chosen)
      end do
   end subroutine test_all

   !> Samples without a checkpoint: of a run that had written none yet, and of one whose checkpoint was lost.
   subroutine test_anew(results)
      character(*), intent(in) :: results
      type(request_type) :: request
      type(error_type), allocatable :: error
      character(:), allocatable :: report, deck, other
      integer(hid_t) :: file
      deck = results//'.inp'
      other = results//'.anew.h5'
      call change_deck('../input/pendulum.inp', deck, ['*DYNAMICS'], ['*DYNAMICS'])
      call run_deck(deck, results, .true., .true., report, error)
      call check_no_error(error, 'anew: whole')
      request%stop_after = 20_long
      call run_deck(deck, other, .true., .true., report, error, request=request)
      call check_status(error, status_interrupted, 'it goes on from there with --restart', 'anew: interrupted')
      call remove_file(checkpoint_name(other))
      request%stop_after = huge(1_long)
      request%restart = .true.
      call run_deck(deck, other, .true., .true., report, error, request=request)
      call check_status(error, status_deck, 'samples of a run that did not finish, but there is no ', 'anew: lost')
      call reopen_file(other, file, error)
      call write_attribute(file, '/run', 'checkpoints', 0, error)
      call close_file(other, file, error)
      call change_deck('../input/pendulum.inp', deck, ['*DYNAMICS, '], ['*DYNAMICS, MAXIMUM STEPS=1000000, '])
      call run_deck(deck, other, .false., .true., report, error, request=request)
      call check_status(error, status_deck, 'is of a run of another deck', 'anew: another deck')
      call change_deck('../input/pendulum.inp', deck, ['*DYNAMICS'], ['*DYNAMICS'])
      call run_deck(deck, other, .false., .true., report, error, request=request)
      call check_no_error(error, 'anew')
      call check(index(report, 'had written no checkpoint yet: begun anew') > 0, 'anew: '//report)
      call compare_files(results, other, 'anew')
   end subroutine test_anew

   subroutine check_status(error, status, text, name)
      type(error_type), allocatable, intent(in) :: error
      integer, intent(in) :: status
      character(*), intent(in) :: text, name
      call check(allocated(error), name//': error')
      if (.not. allocated(error)) return
      call check(error%status == status, name//': status')
      call check(index(error%message, text) > 0, name//': '//error%message)
   end subroutine check_status

end program test_restart
