!> Redundant constraints and folds against solutions with one degree of freedom: the parallelogram with five cranks, which moves
!> like one pendulum, its joint forces against those of a free body; and the slider-crank of equal lengths, which passes
!> a position where branches meet at every half turn; three cranks that are driven through folds; beams whose stretch between
!> joints decides on reactions. Usage, in tests/: test_redundancy RESULT_FILE
program test_redundancy
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_output_history_reader, only: history_reader_type
   use bars, only: nl
   use runs, only: run_changed, run_text, channel
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   real(wp), parameter :: pi = acos(-1.0_wp), g = 9.81_wp
   character(256) :: results
   !> Results of `run_bar`, and what it said
   type(history_reader_type) :: bar
   character(:), allocatable :: told

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
   call check_column('b.i, ground.i', '')
   call check_column('b.i, q.i', '*RIGID BODY, NAME=q, MASS=1, INERTIA=1'//nl//' i, 0, 0.8'//nl// &
      & '*JOINT, NAME=w, TYPE=WELD'//nl//' q.origin, ground.origin'//nl)
   call check_strut()
   call check_told()
   call finish()

contains

   !> A column on two pins, one of them within it, under its weight W and a force on its free end: the lower pin carries half of
   !> the weight between them, the other one all else, whether it stands on the ground or on what is welded to it.
   subroutine check_column(pin, more)
      !> The points of the upper pin, and blocks for it
      character(*), intent(in) :: pin, more
      real(wp), parameter :: weight = 7800*0.05_wp**2*9.81_wp
      real(wp), allocatable :: lower(:), upper(:)
      integer :: n
      call run_bar(more//'*GRAVITY'//nl//'*GROUND'//nl//' i, 0, 0.8'//nl//'*BEAM, NAME=b, MATERIAL=m, SECTION=s, LENGTH=2, '// &
         & 'ANGLE=pi/2'//nl//' i, 0.8'//nl//'*JOINT, NAME=low, TYPE=REVOLUTE'//nl//' b.start, ground.origin'//nl// &
         & '*JOINT, NAME=up, TYPE=REVOLUTE'//nl//' '//pin//nl//'*FORCE, NAME=f, POINT=b.end'//nl//' 0, -1000'//nl// &
         & '*STATICS'//nl//'*OUTPUT'//nl//' force_y(low), force_y(up)'//nl)
      allocate (lower, source=channel(bar, 'force_y_low'))
      allocate (upper, source=channel(bar, 'force_y_up'))
      call bar%close()
      n = size(lower)
      call check_close(lower(n), 0.4_wp*weight, 1.0e-4_wp*weight, 'a column on two pins: the lower one, '//pin)
      call check_close(upper(n), 1.6_wp*weight + 1000, 1.0e-4_wp*weight, 'a column on two pins: the upper one, '//pin)
   end subroutine check_column

   !> A beam on pins at its ends and a rod d at a = 0.8 of 2 m, under a force F there: with the stiffness K of the beam for that
   !> place, along and across, the rod pushes by -(d K^-1 F)/(d K^-1 d).
   subroutine check_strut()
      real(wp), parameter :: ea = 2.0e11_wp*0.05_wp**2, ei = 2.0e11_wp*0.05_wp**4/12, a = 0.8_wp, b = 1.2_wp
      real(wp), parameter :: stiffness(2) = [ea/a + ea/b, 6*ei/(a*b)**2], force(2) = [300.0_wp, -100.0_wp]
      real(wp), parameter :: rod(2) = [0.8_wp, -0.6_wp]
      real(wp), allocatable :: x(:), y(:)
      real(wp) :: push, left
      integer :: n
      call run_bar('*GROUND'//nl//' e, 2, 0'//nl//' top, 0, 0.6'//nl//'*BEAM, NAME=b, MATERIAL=m, SECTION=s, LENGTH=2'//nl// &
         & ' i, 0.8'//nl//'*JOINT, NAME=first, TYPE=REVOLUTE'//nl//' b.start, ground.origin'//nl// &
         & '*JOINT, NAME=second, TYPE=REVOLUTE'//nl//' b.end, ground.e'//nl//'*JOINT, NAME=rod, TYPE=ROD'//nl// &
         & ' b.i, ground.top'//nl//'*FORCE, NAME=f, POINT=b.i'//nl//' 300, -100'//nl//'*STATICS'//nl//'*OUTPUT'//nl// &
         & ' force_x(first), force_y(first), force_x(second)'//nl)
      push = -sum(rod*force/stiffness)/sum(rod**2/stiffness)
      ! What the pins at the start gets of the force along the beam
      left = -(force(1) + push*rod(1))*b/(a + b)
      allocate (x, source=channel(bar, 'force_x_first'))
      allocate (y, source=channel(bar, 'force_x_second'))
      call bar%close()
      n = size(x)
      print '(a,4es14.6)', 'strut: ', x(n), left, y(n), -(force(1) + push*rod(1)) - left
      call check_close(x(n)/left, 1.0_wp, 1.0e-3_wp, 'a beam and a rod: the first pin')
      call check_close(y(n)/(-(force(1) + push*rod(1)) - left), 1.0_wp, 1.0e-3_wp, 'a beam and a rod: the second pin')
   end subroutine check_strut

   !> The column in modes, which do not follow how its parts stretch: told, and right with the remedy that is told.
   subroutine check_told()
      character(*), parameter :: column = '*GRAVITY'//nl//'*GROUND'//nl//' i, 0, 0.8'//nl//'*JOINT, NAME=low, TYPE=REVOLUTE'//nl// &
         & ' b.start, ground.origin'//nl//'*JOINT, NAME=up, TYPE=REVOLUTE'//nl//' b.i, ground.i'//nl//'*STATICS'//nl// &
         & '*OUTPUT'//nl//' force_y(low)'//nl
      character(*), parameter :: words = 'do not follow how it stretches between them'
      real(wp), parameter :: weight = 7800*0.05_wp**2*9.81_wp
      real(wp), allocatable :: lower(:)
      call run_bar('*BEAM, NAME=b, MATERIAL=m, SECTION=s, LENGTH=2, ANGLE=pi/2, GEOMETRIC=K_G'//nl//' i, 0.8'//nl//column)
      call bar%close()
      call check(index(told, words) > 0, 'parts of a column in modes: '//told)
      call run_bar('*BEAM, NAME=b, MATERIAL=m, SECTION=s, LENGTH=2, ANGLE=pi/2, GEOMETRIC=K_G, CORRECTIONS=YES'//nl// &
         & ' i, 0.8'//nl//column)
      allocate (lower, source=channel(bar, 'force_y_low'))
      call bar%close()
      call check(index(told, words) == 0, 'parts of a column with corrections: '//told)
      call check_close(lower(size(lower)), 0.4_wp*weight, 1.0e-4_wp*weight, 'a column with corrections')
   end subroutine check_told

   !> Runs a deck with a steel bar of 50 mm by 50 mm; results in `bar`, what it says in `told`.
   subroutine run_bar(scene)
      character(*), intent(in) :: scene
      type(error_type), allocatable :: error
      call run_text('*MATERIAL, NAME=m, YOUNG=2e11, DENSITY=7800'//nl// &
         & '*SECTION, NAME=s, SHAPE=RECTANGLE, WIDTH=0.05, HEIGHT=0.05'//nl//scene, trim(results), told, error)
      call check_no_error(error, scene)
      if (allocated(error)) error stop 1
      call bar%open(trim(results), error)
      call check_no_error(error, scene)
   end subroutine run_bar

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
