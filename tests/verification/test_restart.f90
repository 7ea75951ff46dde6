!> Runs that are interrupted again and again and go on have the bits of those that are not: all channels and the statistics, with
!> every integrator, and with all that a run remembers: folded positions, breaks, errors, envelopes, axial coordinates at rest.
program test_restart
   use limber_base_kinds, only: wp, long
   use limber_base_error, only: error_type, status_interrupted
   use limber_analysis_guard, only: request_type
   use limber_analysis_run, only: run_deck
   use limber_base_text, only: as_text
   use limber_output_history_reader, only: history_reader_type
   use runs, only: change_deck
   use testing, only: check, check_no_error, finish
   implicit none
   character(*), parameter :: integrators(*) = [character(10) :: 'ADAMS', 'RADAU', 'ALPHA', 'CONSERVING']
   character(512) :: argument

   call get_command_argument(1, argument)
   call test_all(trim(argument))
   call finish()

contains

   subroutine test_all(results)
      character(*), intent(in) :: results
      character(80) :: old(2), new(2)
      character(21) :: chosen
      integer :: i
      do i = 1, size(integrators)
         chosen = 'INTEGRATOR='//integrators(i)
         old(1) = 'turns = 2'
         new(1) = 'turns = 0.2'
         old(2) = 'TOLERANCE=1e-8, OUTPUTS=838'
         new(2) = 'TOLERANCE=1e-5, OUTPUTS=83, '//chosen
         call compare('slider_crank_full', results, old, new, 61_long)
         old(1) = 'END=0.03, TOLERANCE=1e-8'
         new(1) = 'END=0.03, TOLERANCE=1e-5'
         old(2) = 'OUTPUTS=300, INTEGRATOR=ADAMS'
         new(2) = 'OUTPUTS=60, '//chosen
         call compare('andrews_squeezer', results, old, new, 17_long)
         old(1) = 'N = 40'
         new(1) = 'N = 4'
         old(2) = 'END=20, OUTPUTS=1000, TOLERANCE=1e-7'
         new(2) = 'END=2, OUTPUTS=100, TOLERANCE=1e-5, '//chosen
         call compare('four_bar_chain', results, old, new, 13_long)
         old(1) = 'N = 100'
         new(1) = 'N = 12'
         old(2) = 'OUTPUTS=100, FIXED STEP=1e-3, INTEGRATOR=ADAMS'
         new(2) = 'OUTPUTS=50, TOLERANCE=1e-4, '//chosen
         call compare('chain_rigid', results, old, new, 9_long)
      end do
   end subroutine test_all

   !> Runs a deck with texts exchanged whole, and in pieces of some steps.
   subroutine compare(name, results, old, new, steps)
      character(*), intent(in) :: name, results, old(:), new(:)
      integer(long), intent(in) :: steps
      type(request_type) :: request
      type(error_type), allocatable :: error
      type(history_reader_type) :: whole, pieces
      character(:), allocatable :: report, deck, other, title
      integer :: i
      deck = results//'.inp'
      other = results//'.pieces.h5'
      title = name//', '//trim(new(size(new)))
      call change_deck('../input/'//name//'.inp', deck, old, new)
      call run_deck(deck, results, .true., .true., report, error)
      call check_no_error(error, title)
      request%stop_after = steps
      call run_deck(deck, other, .true., .true., report, error, request=request)
      request%restart = .true.
      do i = 1, 1000
         if (.not. allocated(error)) exit
         if (error%status /= status_interrupted) exit
         deallocate (error)
         call run_deck(deck, other, .false., .true., report, error, request=request)
      end do
      call check_no_error(error, title//': in pieces')
      call check(i > 3, title//': goes on '//as_text(i - 1)//' times')
      call whole%open(results, error)
      call check_no_error(error, title)
      call pieces%open(other, error)
      call check_no_error(error, title)
      if (allocated(error)) return
      call check(pieces%complete, title//': complete')
      call compare_samples(whole, pieces, title)
      call whole%close()
      call pieces%close()
   end subroutine compare

   subroutine compare_samples(whole, pieces, title)
      type(history_reader_type), intent(in) :: whole, pieces
      character(*), intent(in) :: title
      character(*), parameter :: numbers(*) = [character(20) :: 'steps', 'rejected_steps', 'right_hand_sides', 'jacobians', &
         & 'factorisations', 'highest_order', 'samples', 'position_residual', 'energy_imbalance']
      type(error_type), allocatable :: error
      real(wp), allocatable :: a(:, :), b(:, :)
      real(wp) :: x, y
      integer :: i
      call check(whole%samples == pieces%samples, title//': samples '//as_text(pieces%samples)//' of '//as_text(whole%samples))
      if (whole%samples /= pieces%samples) return
      do i = 1, size(whole%channels)
         call whole%read_channel(whole%channels(i)%name, a, error)
         call pieces%read_channel(whole%channels(i)%name, b, error)
         call check(.not. any(abs(a - b) > 0.0_wp), title//': '//whole%channels(i)%name//' off by '//as_text(maxval(abs(a - b)), 3))
      end do
      do i = 1, size(numbers)
         call whole%read_statistic(trim(numbers(i)), x, error)
         call pieces%read_statistic(trim(numbers(i)), y, error)
         call check(.not. abs(x - y) > 0.0_wp, title//': '//trim(numbers(i))//' '//as_text(y, 8)//' for '//as_text(x, 8))
      end do
   end subroutine compare_samples

end program test_restart
