!> Contacts as laws of springs: balls that fall onto stops whose law is one of the length of a spring, and pass its end in a step if
!> that misses the stop. Values of an integrator with events (scipy 1.10, DOP853, RTOL=1e-12); and a body that rests on the jump of
!> a law from the start.
!> Usage, in tests/: test_contacts RESULT_FILE
program test_contacts
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_text, channel
   use testing, only: check, check_close, finish
   implicit none

   character(*), parameter :: newline = new_line('a')
   character(*), parameter :: integrators(4) = [character(10) :: 'ADAMS', 'RADAU', 'ALPHA', 'CONSERVING']
   character(256) :: results
   integer :: i

   call get_command_argument(1, results)
   do i = 1, size(integrators)
      call check_ball('-1e5*max(0, 0.1 - (x + 1))', [-1.49323489_wp, -0.14592424_wp, 0.9781866_wp])
      call check_ball('-5e4*(abs(0.1 - (x + 1)) + 0.1 - (x + 1))', [-1.49323489_wp, -0.14592424_wp, 0.9781866_wp])
      call check_ball('stop(x + 1)', [-1.49323489_wp, -0.14592424_wp, 0.9781866_wp])
      call check_ball('-step(0.1 - (x + 1))*(1e5*(0.1 - (x + 1)) - 50*v)', [-1.3005987_wp, -0.34037018_wp, 0.63986039_wp])
      call check_ball('80*v*step(0.1 - (x + 1))', [0.1908254_wp, -1.37011724_wp, 0.00343281_wp])
   end do
   do i = 1, size(integrators)
      if (integrators(i) == 'ADAMS') call check_resting('9.82', '1e-4', 1.0e-5_wp)
      call check_resting('12', '1e-6', 1.0e-6_wp)
   end do
   do i = 1, 3
      call check_balls('0.003', '1e7', [-2.26532128_wp, -9.74003694_wp])
      call check_balls('0.0095', '1e9', [8.72289972_wp, -4.88988961_wp])
   end do
   call check_detents()
   call check_lever()
   call check_beside()
   do i = 1, size(integrators)
      call check_begun('0.3', '5*step(y(b) - 0.3)')
      call check_begun('7.1', '5*step(y(b) - 7.1)')
   end do
   ! What flies by says nothing about the errors of a body that it is not connected with
   do i = 1, 2
      call check_resting('12', '1e-3', 1.0e-3_wp, '*POINT MASS, NAME=fast, MASS=1, X=3, VX=100'//newline, '5')
      call check_resting('9.82', '1e-3', 1.0e-2_wp, '*POINT MASS, NAME=fast, MASS=1, X=3, VX=100'//newline, '5')
      call check_resting('12', '1e-3', 1.0e-3_wp, '*POINT MASS, NAME=falls, MASS=1, X=0.1'//newline, '5')
   end do
   call finish()

contains

   !> Place of a ball that falls on a stop beside its way, and height of one that falls on it straight, after 0.8 s.
   subroutine check_ball(law, expected)
      character(*), intent(in) :: law
      !> x and y of the first, y of the second
      real(wp), intent(in) :: expected(3)
      real(wp), parameter :: most = 1.0e-4_wp
      character(*), parameter :: table = '*TABLE, NAME=stop, INTERPOLATION=LINEAR'//newline//' 0, -1e4'//newline//' 0.1, 0'// &
         & newline//' 100, 0'//newline
      real(wp), allocatable :: places(:, :)
      call run_scene(table//'*GROUND'//newline//' a, 0.05, 0'//newline//'*POINT MASS, NAME=b, MASS=1, Y=1'//newline// &
         & '*SPRING, NAME=s, LENGTH=1'//newline//' b, ground.a, '//law//newline//'*POINT MASS, NAME=c, MASS=1, X=0.05, Y=1'// &
         & newline//'*SPRING, NAME=u, LENGTH=1'//newline//' c, ground.a, '//law//newline, '0.8', '1e-6', ' x = x(b), y = y(b),'// &
         & ' z = y(c)', places)
      if (.not. allocated(places)) return
      call check_close(maxval(abs(places(size(places, 1), :) - expected)), 0.0_wp, most, trim(integrators(i))//': a ball on '//law)
   end subroutine check_ball

   !> A body that a force carries as long as it is not above its place of start: it stays there, or is told to stick.
   subroutine check_resting(force, tolerance, most, other, end)
      character(*), intent(in) :: force, tolerance
      !> [m]
      real(wp), intent(in) :: most
      !> Another body, and the end of the run [s]
      character(*), intent(in), optional :: other, end
      real(wp), allocatable :: places(:, :)
      character(:), allocatable :: beside, last
      beside = ''
      last = '2'
      if (present(other)) beside = other
      if (present(end)) last = end
      call run_scene('*POINT MASS, NAME=b, MASS=1, Y=0.3'//newline//'*FORCE, NAME=s, POINT=b'//newline//' 0, '//force// &
         & '*step(0.3 - y(b))'//newline//beside, last, tolerance, ' x = x(b), y = y(b), z = y(b)', places)
      if (.not. allocated(places)) return
      call check_close(maxval(abs(places(:, 2) - 0.3_wp)), 0.0_wp, most, trim(integrators(i))//': a body at rest on '//force)
   end subroutine check_resting

   !> Velocity of a ball that has met another one beside its centre, in a contact that is one step long: a law of both places.
   subroutine check_balls(aside, stiffness, expected)
      character(*), intent(in) :: aside, stiffness
      real(wp), intent(in) :: expected(2)
      character(*), parameter :: tolerances(2) = [character(4) :: '1e-4', '1e-6']
      real(wp), allocatable :: values(:, :)
      integer :: k
      do k = 1, 2
         call run_scene('*POINT MASS, NAME=a, MASS=1, X=-5, VX=10'//newline//'*POINT MASS, NAME=b, MASS=1, X=5, Y='//aside// &
            & ', VX=-10'//newline//'*SPRING, NAME=c'//newline//' a, b, -'//stiffness// &
            & '*max(0, 0.01 - sqrt((x(a) - x(b))**2 + (y(a) - y(b))**2))'//newline, '1', tolerances(k), &
            & ' x = vx(a), y = vy(a) + 9.81*t, z = y(b)', values)
         if (.not. allocated(values)) cycle
         call check_close(maxval(abs(values(size(values, 1), :2) - expected)), 0.0_wp, merge(0.04_wp, 2.0e-3_wp, k == 1), &
            & trim(integrators(i))//', '//tolerances(k)//': balls that meet '//aside//' aside')
      end do
   end subroutine check_balls

   !> Spin of a rotor behind 430 detents, each a thousandth of a second apart and a torque of the angle alone: by the energy.
   subroutine check_detents()
      real(wp), parameter :: expected = 20.9999849_wp
      character(*), parameter :: chosen(5) = [character(10) :: 'ADAMS', 'ADAMS', 'RADAU', 'ALPHA', 'CONSERVING']
      character(*), parameter :: tolerances(5) = [character(4) :: '1e-4', '1e-6', '1e-5', '1e-6', '1e-4']
      real(wp), parameter :: most(5) = [0.4_wp, 0.03_wp, 0.06_wp, 0.05_wp, 1.0e-4_wp]
      real(wp), allocatable :: values(:, :)
      integer :: k
      do k = 1, 5
         i = findloc(integrators, chosen(k), dim=1)
         call run_scene('*RIGID BODY, NAME=r, MASS=1, INERTIA=0.01, SPIN=30'//newline//'*JOINT, NAME=h, TYPE=REVOLUTE'//newline// &
            & ' r.origin, ground.origin'//newline//'*TORQUE, NAME=d, BODY=r'//newline// &
            & ' -300*max(0, cos(100*angle(r)) - 0.99)'//newline, '1', trim(tolerances(k)), ' x = spin(r), y = t, z = t', values)
         if (allocated(values)) call check_close(values(size(values, 1), 1), expected, most(k), trim(chosen(k))//' at '// &
            & tolerances(k)//': a rotor with detents')
      end do
   end subroutine check_detents

   !> A mass on a spring beside a pendulum that nothing connects with it and that is a thousand times as large: closed form.
   subroutine check_beside()
      real(wp), parameter :: omega = 1.0e3_wp, end = 0.05_wp
      real(wp), parameter :: expected = 3/omega*sin(omega*end) - 9.81_wp/omega**2*(1 - cos(omega*end))
      real(wp), parameter :: most(4) = [4.0e-6_wp, 3.0e-8_wp, 6.0e-5_wp, 6.0e-5_wp]
      real(wp), allocatable :: values(:, :)
      do i = 1, 4
         call run_scene('*RIGID BODY, NAME=large, MASS=1e6, INERTIA=1e8, CENTRE X=5'//newline//'*JOINT, NAME=j, TYPE=REVOLUTE'// &
            & newline//' large.origin, ground.origin'//newline//'*POINT MASS, NAME=s, MASS=1e-6, X=0.001, VY=3'//newline// &
            & '*SPRING, NAME=k, STIFFNESS=1'//newline//' s, ground.origin'//newline, '0.05', '1e-4', ' x = x(s), y = y(s), z = t', &
            & values)
         if (allocated(values)) call check_close(values(size(values, 1), 2), expected, most(i), trim(integrators(i))// &
            & ': a mass on a spring beside a large pendulum')
      end do
   end subroutine check_beside

   !> Angle and spin of a sprung lever that a crank hits once in each of four turns.
   subroutine check_lever()
      character(*), parameter :: scene = '*RIGID BODY, NAME=a, MASS=1, INERTIA=0.01'//newline//' e, 0.1, 0'//newline// &
         & '*JOINT, NAME=ja, TYPE=REVOLUTE'//newline//' a.origin, ground.origin'//newline// &
         & '*DRIVER, NAME=d, TYPE=ANGLE, BODY=a'//newline//' 60*t'//newline// &
         & '*RIGID BODY, NAME=l, MASS=0.2, INERTIA=0.001, X=0.2'//newline//' p, -0.098, 0'//newline//'*GROUND'//newline// &
         & ' g, 0.2, 0'//newline//'*JOINT, NAME=jl, TYPE=REVOLUTE'//newline//' l.origin, ground.g'//newline// &
         & '*SPRING, NAME=r, TYPE=ROTATIONAL, STIFFNESS=2, DAMPING=0.01'//newline//' ground.g, l.origin'//newline// &
         & '*SPRING, NAME=c, LENGTH=0.004'//newline//' a.e, l.p, 1e5*min(0, x)'//newline
      real(wp), parameter :: expected(2) = [-0.00895521_wp, -0.1236222_wp]
      character(*), parameter :: tolerances(2) = [character(4) :: '1e-4', '1e-6']
      real(wp), parameter :: most(2) = [0.03_wp, 0.004_wp]
      real(wp), allocatable :: values(:, :)
      integer :: k
      do i = 1, 4
         do k = 1, 2
            call run_scene(scene, '0.4', tolerances(k), ' x = angle(l), y = spin(l), z = t', values)
            if (allocated(values)) call check_close(maxval(abs(values(size(values, 1), :2) - expected)/[0.057_wp, 1.8_wp]), &
               & 0.0_wp, most(k), trim(integrators(i))//' at '//tolerances(k)//': a lever that is hit')
         end do
      end do
   end subroutine check_lever
   !> A body that starts right where a law jumps, and leaves for the side where that is nothing: it falls freely.
   subroutine check_begun(place, law)
      !> Height of the start and of the jump; law of the force
      character(*), intent(in) :: place, law
      real(wp), allocatable :: places(:, :)
      call run_scene('*POINT MASS, NAME=b, MASS=1, Y='//place//newline//'*FORCE, NAME=s, POINT=b'//newline//' 0, '//law//newline, &
         & '2', '1e-6', ' x = x(b), y = y(b) - '//place//', z = y(b)', places)
      call check(allocated(places), trim(integrators(i))//': falls from '//law)
      if (.not. allocated(places)) return
      call check_close(places(size(places, 1), 2), -0.5_wp*9.81_wp*2.0_wp**2, 2.0e-5_wp, trim(integrators(i))//': falls from '//law)
   end subroutine check_begun

   !> The three channels of a scene (samples, 3); not allocated if it is told that something sticks.
   subroutine run_scene(scene, end, tolerance, channels, values)
      character(*), intent(in) :: scene, end, tolerance, channels
      real(wp), allocatable, intent(out) :: values(:, :)
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp), allocatable :: x(:)
      call run_text('*GRAVITY'//newline//scene//'*DYNAMICS, END='//end//', OUTPUTS=50, TOLERANCE='//tolerance//', INTEGRATOR='// &
         & trim(integrators(i))//newline//'*OUTPUT'//newline//channels//newline, trim(results), report, error)
      if (allocated(error)) then
         call check(index(error%message, 'jumps to and fro') > 0, trim(integrators(i))//': '//error%message)
         return
      end if
      call reader%open(trim(results), error)
      x = channel(reader, 'x')
      allocate (values(size(x), 3))
      values(:, 1) = x
      values(:, 2) = channel(reader, 'y')
      values(:, 3) = channel(reader, 'z')
      call reader%close()
   end subroutine run_scene

end program test_contacts
