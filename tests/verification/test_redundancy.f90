!> Redundant constraints and folds against solutions with one degree of freedom: the parallelogram with five cranks, which moves
!> like one pendulum, its joint forces against those of a free body; and the slider-crank of equal lengths, which passes
!> a position where branches meet at every half turn; three cranks that are driven through folds. Usage, in tests/: test_redundancy RESULT_FILE
program test_redundancy
   use limber_base_kinds, only: wp
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_changed, channel
   use testing, only: check, check_close, finish
   implicit none
   real(wp), parameter :: pi = acos(-1.0_wp), g = 9.81_wp
   character(256) :: results

   call get_command_argument(1, results)
   call check_cranks('ADAMS', '1e-10', 1.0e-8_wp)
   call check_cranks('RADAU', '1e-7', 1.0e-4_wp)
   call check_cranks('CONSERVING', '1e-6', 1.0e-2_wp)
   call check_equal('ADAMS', '1e-10', 1.0e-6_wp)
   call check_equal('RADAU', '1e-9', 1.0e-5_wp)
   call check_equal('ALPHA', '1e-5', 1.0_wp)
   ! Not every tolerance: where an evaluation falls on the fold itself ADAMS warns, which is luck
   call check_gravity('ADAMS', '3e-11')
   call check_driven()
   call finish()

contains

   !> Motion of the five cranks, reactions of the coupler. (17/3) theta'' = -(13/2) g cos theta: five cranks of inertia 1/3 and
   !> moment 1/2, a coupler of 4 that does not turn.
   subroutine check_cranks(integrator, tolerance, allowed)
      character(*), intent(in) :: integrator, tolerance
      real(wp), intent(in) :: allowed
      type(history_reader_type) :: reader
      real(wp), allocatable :: angle(:), pull_x(:), pull_y(:), ax(:), ay(:), energy(:)
      character(40) :: old(4), new(4)
      real(wp) :: theta, rate, largest
      integer :: i
      old = [character(40) :: 'INTEGRATOR=ADAMS', 'TOLERANCE=1e-8', 'END=10', 'OUTPUTS=200']
      new(1) = 'INTEGRATOR='//integrator
      new(2) = 'TOLERANCE='//tolerance
      new(3:4) = [character(40) :: 'END=5', 'OUTPUTS=100']
      call run_changed('../input/parallelogram_five_cranks.inp', trim(results), old, new, reader)
      allocate (angle, source=channel(reader, 'angle_crank1'))
      allocate (pull_x, source=channel(reader, 'pull_x'))
      allocate (pull_y, source=channel(reader, 'pull_y'))
      allocate (ax, source=channel(reader, 'ax'))
      allocate (ay, source=channel(reader, 'ay'))
      allocate (energy, source=channel(reader, 'energy'))
      call reader%close()
      theta = pi/3
      rate = 0.0_wp
      largest = 0.0_wp
      do i = 2, size(angle)
         call swing(6.5_wp*g/(17.0_wp/3), 0.05_wp, theta, rate)
         largest = max(largest, abs(angle(i) - theta))
      end do
      print '(2a,3es10.2)', integrator, ' five cranks: angle, forces, energy', largest, maxval(abs(pull_x + 4*ax)), &
         & maxval(abs(energy - energy(1)))
      call check_close(largest, 0.0_wp, allowed, integrator//': five cranks swing like one pendulum')
      call check(minval(angle) < -pi, integrator//': they pass the folded positions')
      call check_close(maxval(abs(pull_x + 4*ax)), 0.0_wp, 1.0e-6_wp, integrator//': forces of all pins along x')
      call check_close(maxval(abs(pull_y + 4*(ay + g))), 0.0_wp, 1.0e-6_wp, integrator//': forces of all pins along y')
   end subroutine check_cranks

   !> theta'' = -k cos theta over a time, by Runge and Kutta's method with steps that leave no error.
   subroutine swing(k, time, theta, rate)
      real(wp), intent(in) :: k, time
      real(wp), intent(inout) :: theta, rate
      integer, parameter :: steps = 200
      real(wp) :: h, a(4)
      integer :: i
      h = time/steps
      do i = 1, steps
         a(1) = -k*cos(theta)
         a(2) = -k*cos(theta + 0.5_wp*h*rate)
         a(3) = -k*cos(theta + 0.5_wp*h*rate + 0.25_wp*h**2*a(1))
         a(4) = -k*cos(theta + h*rate + 0.5_wp*h**2*a(2))
         theta = theta + h*rate + h**2/6*(a(1) + a(2) + a(3))
         rate = rate + h/6*(a(1) + 2*a(2) + 2*a(3) + a(4))
      end do
   end subroutine swing

   !> Ten revolutions on the regular branch: the rod at minus the angle of the crank, and back where it was after each period.
   subroutine check_equal(integrator, tolerance, allowed)
      character(*), intent(in) :: integrator, tolerance
      real(wp), intent(in) :: allowed
      type(history_reader_type) :: reader
      real(wp), allocatable :: crank(:), rod(:), x(:)
      character(40) :: old(2), new(2)
      integer :: i
      old = [character(40) :: 'INTEGRATOR=ADAMS', 'TOLERANCE=1e-10']
      new(1) = 'INTEGRATOR='//integrator
      new(2) = 'TOLERANCE='//tolerance
      call run_changed('../input/slider_crank_equal.inp', trim(results), old, new, reader)
      allocate (crank, source=channel(reader, 'crank_angle'))
      allocate (rod, source=channel(reader, 'rod_angle'))
      allocate (x, source=channel(reader, 'slider_x'))
      call reader%close()
      print '(2a,2es10.2)', integrator, ' equal lengths: branch, angle after ten turns', maxval(abs(crank + rod)), &
         & crank(201) - crank(1) - 20*pi
      call check_close(maxval(abs(crank + rod)), 0.0_wp, 1.0e-10_wp, integrator//': the regular branch')
      call check_close(maxval(abs(x - 2*cos(crank))), 0.0_wp, 1.0e-10_wp, integrator//': its slider')
      do i = 1, 10
         call check_close(crank(1 + 20*i), crank(1) + 2*pi*i, allowed, integrator//': one more revolution')
      end do
   end subroutine check_equal

   !> The same under gravity, let go at 45 degrees.
   subroutine check_gravity(integrator, tolerance)
      character(*), intent(in) :: integrator, tolerance
      type(history_reader_type) :: reader
      real(wp), allocatable :: crank(:)
      character(40) :: old(6), new(6)
      old = [character(40) :: 'INTEGRATOR=ADAMS', 'TOLERANCE=1e-10', 'END=10*period', 'OUTPUTS=200', &
         & 'speed = 1/sqrt(1 + 9*sin(start)**2)', '*JOINT, NAME=axle']
      new(1) = 'INTEGRATOR='//integrator
      new(2) = 'TOLERANCE='//tolerance
      new(3:5) = [character(40) :: 'END=5', 'OUTPUTS=5', 'speed = 0']
      new(6) = '*GRAVITY'//achar(10)//'*JOINT, NAME=axle'
      call run_changed('../input/slider_crank_equal.inp', trim(results), old, new, reader)
      allocate (crank, source=channel(reader, 'crank_angle'))
      call reader%close()
      call check_close(crank(2), -1.052201686495913_wp, 1.0e-8_wp, 'gravity: one second')
      call check_close(crank(3), -3.700578611873318_wp, 1.0e-8_wp, 'gravity: two seconds')
      call check_close(crank(6), 0.7759381447715665_wp, 1.0e-8_wp, 'gravity: five seconds')
   end subroutine check_gravity

   !> A parallelogram with one crank more than needed, which CONSERVING drives past folds: its coupler does not turn, the torque is
   !> that of all inertia, and reactions are those of ADAMS.
   subroutine check_driven()
      type(history_reader_type) :: reader
      real(wp), allocatable :: spin(:), torque(:), force(:)
      real(wp), parameter :: inertia = 0.004_wp + 0.5_wp*0.0068_wp + 0.05_wp + 2.8_wp*0.005_wp + 0.02_wp + 1.2_wp*0.0125_wp &
         & + 1.2_wp*0.09_wp
      integer :: i
      call run_changed('verification/driven_fold.inp', trim(results), [character(1) ::], [character(1) ::], reader)
      allocate (spin, source=channel(reader, 'spin_coupler'))
      allocate (torque, source=channel(reader, 'torque_motor'))
      allocate (force, source=channel(reader, 'force_x_pin'))
      call reader%close()
      print '(a,2es10.2)', 'CONSERVING driven folds: spin, torque', maxval(abs(spin)), &
         & maxval(abs(torque - inertia*23*cos(4.3_wp*[(0.03_wp*i, i=0, 20)])))
      call check_close(maxval(abs(spin)), 0.0_wp, 1.0e-10_wp, 'the coupler of driven cranks does not turn')
      do i = 0, 20
         call check_close(torque(i + 1), inertia*23*cos(4.3_wp*0.03_wp*i), 1.0e-7_wp, 'torque of driven cranks')
      end do
      call run_changed('verification/driven_fold.inp', trim(results), [character(40) :: 'INTEGRATOR=CONSERVING', '1e-5'], &
         & [character(40) :: 'INTEGRATOR=ADAMS', '1e-9'], reader)
      call check_close(maxval(abs(channel(reader, 'force_x_pin') - force)), 0.0_wp, 1.0e-3_wp, 'reactions beside a fold')
      force = channel(reader, 'force_x_pin')
      call reader%close()
      call run_changed('verification/driven_fold.inp', trim(results), [character(40) :: 'INTEGRATOR=CONSERVING', '1e-5'], &
         & [character(40) :: 'INTEGRATOR=ADAMS', '1e-10'], reader)
      force = force - channel(reader, 'force_x_pin')
      call check_close(force(7), 0.0_wp, 1.0e-8_wp, 'reactions behind a fold do not depend on round-off')
      call reader%close()
   end subroutine check_driven

end program test_redundancy
