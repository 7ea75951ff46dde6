!> What a digit costs, on a pendulum (analytic), on Andrews' squeezer (published) and on the spin-up of a beam (converged): the
!> slope of log error over log tolerance, the order of fixed steps, and the constraints after 10,000 steps.
!> Usage, in tests/: test_orders RESULT_FILE
program test_orders
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_changed, channel
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   !> A scene, and what is compared of it
   type :: scene_type
      character(40) :: deck = ''
      !> Integrator, tolerance and number of samples as the deck writes them
      character(20) :: tolerance = '', outputs = ''
      character(20) :: channel = ''
      !> Value of the channel at the end; of the spin-up all samples of a converged run instead
      real(wp), allocatable :: values(:)
   end type scene_type

   type(scene_type) :: pendulum, squeezer, beam, plain
   character(256) :: results

   call get_command_argument(1, results)
   pendulum = scene_type('verification/pendulum.inp', 'TOLERANCE=1e-6', 'OUTPUTS=10', 'x_rod_bob')
   allocate (pendulum%values(1))
   pendulum%values = 0.27508746257611686_wp
   squeezer = scene_type('../input/andrews_squeezer.inp', 'TOLERANCE=1e-8', 'OUTPUTS=300', 'beta')
   allocate (squeezer%values(1))
   squeezer%values = 15.810771195153707_wp
   beam = scene_type('../input/spin_up.inp', 'TOLERANCE=1e-8', 'OUTPUTS=1000', 'u2_tip')
   call converge(beam)
   ! Without stretch, whose fast vibrations take some of the order at steps as long as these
   plain = scene_type('verification/spin_up_plain.inp', 'TOLERANCE=1e-8', 'OUTPUTS=1000', 'u2_tip')
   call converge(plain)

   call check_slope(pendulum, 'ADAMS')
   call check_slope(pendulum, 'RADAU')
   call check_slope(squeezer, 'ADAMS')
   call check_slope(squeezer, 'RADAU')
   call check_slope(beam, 'ADAMS')
   call check_slope(beam, 'RADAU')

   call check_order(pendulum, 'ALPHA', [1.0e-2_wp, 5.0e-3_wp, 2.5e-3_wp], 1.9_wp, 2.1_wp)
   call check_order(squeezer, 'ALPHA', [3.0e-5_wp, 1.5e-5_wp, 7.5e-6_wp], 1.9_wp, 2.1_wp)
   call check_order(beam, 'ALPHA', [4.0e-2_wp, 2.0e-2_wp, 1.0e-2_wp], 1.9_wp, 2.1_wp)
   call check_order(pendulum, 'CONSERVING', [1.0e-2_wp, 5.0e-3_wp, 2.5e-3_wp], 1.9_wp, 2.1_wp)
   call check_order(squeezer, 'CONSERVING', [3.0e-5_wp, 1.5e-5_wp, 7.5e-6_wp], 1.9_wp, 2.1_wp)
   call check_order(beam, 'CONSERVING', [4.0e-2_wp, 2.0e-2_wp, 1.0e-2_wp], 1.9_wp, 2.1_wp)
   call check_order(pendulum, 'RADAU', [8.0e-2_wp, 4.0e-2_wp, 2.0e-2_wp], 4.8_wp, 5.2_wp)
   call check_order(squeezer, 'RADAU', [8.0e-5_wp, 5.6e-5_wp, 4.0e-5_wp], 4.7_wp, 5.3_wp)
   call check_order(plain, 'RADAU', [8.0e-2_wp, 4.0e-2_wp, 2.0e-2_wp], 4.7_wp, 5.3_wp)

   call check_drift('ADAMS')
   call check_drift('RADAU')
   call check_drift('ALPHA')
   call check_drift('CONSERVING')
   deallocate (pendulum%values, squeezer%values, beam%values, plain%values)
   call finish()

contains

   !> Takes what two integrators agree upon.
   subroutine converge(scene)
      type(scene_type), intent(inout) :: scene
      real(wp), allocatable :: other(:)
      allocate (scene%values(1))
      call solve(scene, 'RADAU', '1e-12', '', other)
      deallocate (scene%values)
      call solve(scene, 'ADAMS', '1e-12', '', scene%values)
      call check_close(maxval(abs(other - scene%values)), 0.0_wp, 1.0e-10_wp, trim(scene%deck)//': two integrators agree')
      deallocate (other)
   end subroutine converge

   !> All samples of a scene's channel. Without a number for the step it is the integrator's own.
   subroutine solve(scene, integrator, tolerance, step, values)
      type(scene_type), intent(in) :: scene
      character(*), intent(in) :: integrator, tolerance, step
      real(wp), allocatable, intent(out) :: values(:)
      type(history_reader_type) :: reader
      character(80) :: new(3)
      new = [character(80) :: 'INTEGRATOR='//integrator, 'TOLERANCE='//tolerance, 'OUTPUTS=20']
      if (step /= '') new(3) = trim(new(3))//', FIXED STEP='//step
      call run_changed(trim(scene%deck), trim(results), [character(20) :: 'INTEGRATOR=ADAMS', scene%tolerance, scene%outputs], &
         & new, reader)
      allocate (values, source=channel(reader, trim(scene%channel)))
      call reader%close()
   end subroutine solve

   !> Error of a run: at the end, or the greatest of all samples.
   real(wp) function error_of(scene, values)
      type(scene_type), intent(in) :: scene
      real(wp), intent(in) :: values(:)
      if (size(scene%values) == 1) then
         error_of = abs(values(size(values)) - scene%values(1))
      else
         error_of = maxval(abs(values - scene%values))
      end if
   end function error_of

   !> Slope of the error over tolerances from 1e-4 to 1e-10.
   subroutine check_slope(scene, integrator)
      type(scene_type), intent(in) :: scene
      character(*), intent(in) :: integrator
      integer, parameter :: count = 7
      real(wp) :: tolerance(count), error(count)
      real(wp), allocatable :: values(:)
      integer :: i
      do i = 1, count
         tolerance(i) = 10.0_wp**(-3 - i)
         call solve(scene, integrator, as_text(tolerance(i), 3), '', values)
         error(i) = error_of(scene, values)
         deallocate (values)
      end do
      print '(4a,7es9.1,a,f6.2)', trim(scene%deck), ', ', integrator, ', TOLERANCE 1e-4 to 1e-10:', error, '  slope', &
         & slope(tolerance, error)
      call check(slope(tolerance, error) >= 0.7_wp .and. slope(tolerance, error) <= 1.3_wp, &
         & trim(scene%deck)//', '//integrator//': slope '//as_text(slope(tolerance, error), 3))
   end subroutine check_slope

   !> Order of fixed steps.
   subroutine check_order(scene, integrator, step, least, most)
      type(scene_type), intent(in) :: scene
      character(*), intent(in) :: integrator
      real(wp), intent(in) :: step(:), least, most
      real(wp) :: error(size(step))
      real(wp), allocatable :: values(:)
      integer :: i
      do i = 1, size(step)
         call solve(scene, integrator, '1e-10', as_text(step(i), 6), values)
         error(i) = error_of(scene, values)
         deallocate (values)
      end do
      print '(4a,3es9.1,a,f6.2)', trim(scene%deck), ', ', integrator, ', fixed steps:', error, '  order', slope(step, error)
      call check(slope(step, error) >= least .and. slope(step, error) <= most, &
         & trim(scene%deck)//', '//integrator//': order '//as_text(slope(step, error), 4))
   end subroutine check_order

   !> Least-squares slope of log y over log x.
   pure real(wp) function slope(x, y)
      real(wp), intent(in) :: x(:), y(:)
      real(wp) :: u(size(x)), v(size(x))
      u = log(x) - sum(log(x))/size(x)
      v = log(y) - sum(log(y))/size(y)
      slope = dot_product(u, v)/dot_product(u, u)
   end function slope

   !> Constraints of the squeezer's closed loops after 10,000 steps.
   subroutine check_drift(integrator)
      character(*), intent(in) :: integrator
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(40) :: new(2)
      real(wp) :: steps, residual
      new = [character(40) :: 'INTEGRATOR='//integrator, 'OUTPUTS=20, MAXIMUM STEP=2.99e-6']
      call run_changed(trim(squeezer%deck), trim(results), [character(20) :: 'INTEGRATOR=ADAMS', squeezer%outputs], new, reader)
      call reader%read_statistic('steps', steps, error)
      call check_no_error(error, 'steps')
      call check(steps >= 10000, integrator//': steps '//as_text(steps))
      call reader%read_statistic('position_residual', residual, error)
      call check_no_error(error, 'residual')
      print '(2a,f8.0,a,es9.1,a)', integrator, ', squeezer:', steps, ' steps, position residual', residual, ' m'
      ! The scene is 0.1 m large
      call check_close(residual, 0.0_wp, 1.0e-14_wp, integrator//': position residual after 10,000 steps')
      call reader%close()
   end subroutine check_drift

end program test_orders
