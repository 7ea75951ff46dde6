!> Errors that add up turn by turn: a free flywheel keeps its speed over a thousand turns; two four-bars that pass their folds at
!> loose tolerances end where they should, or the run says that they do not. These are a pendulum: with the uprights' angle p,
!> (3/3 + 2) p'' = -(3/2 + 2) g cos(p), integrated here by steps of order 4; any END is a number like others.
!> Usage, in tests/: test_phase RESULT_FILE
program test_phase
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_commands_run, only: run_deck
   use limber_output_history_reader, only: history_reader_type
   use runs, only: change_deck, channel
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   character(*), parameter :: integrators(3) = [character(5) :: 'ADAMS', 'RADAU', 'ALPHA']
   character(*), parameter :: tolerances(3) = ['1e-3', '1e-4', '1e-6']
   character(512) :: argument
   real(wp) :: angle
   integer :: i, j

   call get_command_argument(1, argument)
   call check_flywheel(trim(argument), 'SPIN=10', 'END=600')
   call check_flywheel(trim(argument), 'SPIN=-40', 'END=600')
   call check_flywheel(trim(argument), 'SPIN=1e-5', 'END=1e8')
   angle = pendulum(20.0_wp)
   do i = 1, size(integrators)
      do j = 1, size(tolerances)
         call check_folds(trim(argument), integrators(i), tolerances(j))
      end do
   end do
   call finish()

contains

   !> Speed and angle at the end.
   subroutine check_flywheel(results, given_spin, given_end)
      character(*), intent(in) :: results, given_spin, given_end
      character(:), allocatable :: report
      real(wp), allocatable :: first(:), second(:)
      character(20) :: from(2), to(2)
      real(wp) :: spin, duration
      read (given_spin(6:), *) spin
      read (given_end(5:), *) duration
      from(1) = 'SPIN=10'
      from(2) = 'END=600'
      to(1) = given_spin
      to(2) = given_end
      call run_it('verification/flywheel.inp', results, from, to, 'angle', 'spin', report, first, second)
      call check_close(second(size(second)), spin, 1.0e-5_wp*abs(spin), given_spin//': speed')
      call check_close(first(size(first)), spin*duration, 1.0e-5_wp*abs(spin)*duration, given_spin//': angle')
      call check(index(report, 'warning') == 0, given_spin//': '//report)
   end subroutine check_flywheel

   !> Where the uprights end, or a warning.
   subroutine check_folds(results, integrator, tolerance)
      character(*), intent(in) :: results, integrator, tolerance
      character(:), allocatable :: report, label
      real(wp), allocatable :: x(:), y(:)
      character(40) :: to(2)
      real(wp) :: off
      to(1) = 'N = 2'
      to(2) = 'TOLERANCE='//tolerance//', INTEGRATOR='//integrator
      call run_it('../input/four_bar_chain.inp', results, [character(40) :: 'N = 40', 'TOLERANCE=1e-7'], to, 'x_b0', 'y_b0', &
         & report, x, y)
      off = norm2([x(size(x)) - cos(angle), y(size(y)) - sin(angle)])
      label = integrator//' at '//tolerance//': '
      if (index(report, 'errors of the energy have added up over') > 0) then
         call check(index(report, 'use TOLERANCE=') > 0, label//'remedy')
         call check(tolerance /= '1e-6', label//'no alarm')
      else
         call check_close(off, 0.0_wp, 0.05_wp, label//'the end, as nothing is said')
      end if
   end subroutine check_folds

   !> Angle of the uprights by Runge and Kutta's method.
   real(wp) function pendulum(duration) result(p)
      real(wp), intent(in) :: duration
      integer, parameter :: steps = 200000
      real(wp) :: s(2), k(2, 4), h
      integer :: n
      h = duration/steps
      s = [0.5_wp*acos(-1.0_wp), -1.0_wp]
      do n = 1, steps
         k(:, 1) = slope(s)
         k(:, 2) = slope(s + 0.5_wp*h*k(:, 1))
         k(:, 3) = slope(s + 0.5_wp*h*k(:, 2))
         k(:, 4) = slope(s + h*k(:, 3))
         s = s + h/6*(k(:, 1) + 2*k(:, 2) + 2*k(:, 3) + k(:, 4))
      end do
      p = s(1)
   end function pendulum

   !> Rates of its angle and its spin.
   pure function slope(state) result(rate)
      real(wp), intent(in) :: state(2)
      real(wp) :: rate(2)
      real(wp), parameter :: factor = 3.5_wp*9.81_wp/3
      rate = [state(2), -factor*cos(state(1))]
   end function slope

   !> Runs a deck with texts exchanged.
   subroutine run_it(deck, results, old, new, first_name, second_name, report, first, second)
      character(*), intent(in) :: deck, results, old(:), new(:), first_name, second_name
      character(:), allocatable, intent(out) :: report
      real(wp), allocatable, intent(out) :: first(:), second(:)
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      call change_deck(deck, results//'.inp', old, new)
      call run_deck(results//'.inp', results, .true., .true., report, error)
      call check_no_error(error, deck)
      call reader%open(results, error)
      call check_no_error(error, deck//': results')
      first = channel(reader, first_name)
      second = channel(reader, second_name)
      call reader%close()
   end subroutine run_it

end program test_phase
