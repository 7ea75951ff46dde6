!> Switches by all integrators, against closed forms: a mass and a wheel that their drivers let go, an arm that catches a mass, a
!> slide that is coupled to another, a rod that breaks at a place and at a force, a chain that breaks, a clutch, a spring that
!> engages, a force that is toggled, a beam that its support lets go, an arm that is locked; analyses behind; what is refused.
!> Usage, in tests/: test_switches RESULT_FILE
program test_switches
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_commands_run, only: run_deck
   use limber_output_history_reader, only: history_reader_type
   use runs, only: numbers, run_text, channel
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   character(*), parameter :: nl = new_line('a')
   character(*), parameter :: integrators(4) = [character(10) :: 'ADAMS', 'RADAU', 'ALPHA', 'CONSERVING']
   real(wp), parameter :: g = 9.81_wp, pi = acos(-1.0_wp)
   character(256) :: results
   character(4) :: tolerance
   integer :: i, k

   call get_command_argument(1, results)
   do i = 1, size(integrators)
      do k = 1, 2
         tolerance = merge('1e-6', '1e-9', k == 1)
         call check_release(trim(integrators(i)))
         call check_coasting(trim(integrators(i)))
         call check_catch(trim(integrators(i)))
         call check_instant(trim(integrators(i)), 1)
         call check_instant(trim(integrators(i)), 2)
         call check_coupling(trim(integrators(i)))
         call check_break(trim(integrators(i)))
         call check_chain(trim(integrators(i)))
         call check_clutch(trim(integrators(i)))
         call check_spring(trim(integrators(i)))
         call check_toggle(trim(integrators(i)))
         call check_beam(trim(integrators(i)))
         call check_lock(trim(integrators(i)))
      end do
   end do
   tolerance = '1e-6'
   call check_latch()
   call check_statics()
   call check_states()
   call check_refusals()
   call finish()

contains

   !> Error of times that an integrator is allowed: 10 times the tolerance; of order two, the error of a result.
   real(wp) function bound(integrator)
      character(*), intent(in) :: integrator
      real(wp) :: value
      read (tolerance, *) value
      bound = 10*value
      if (integrator == 'ALPHA' .or. integrator == 'CONSERVING') bound = 1.0e-6_wp*(value/1.0e-9_wp)**(2.0_wp/3.0_wp)
   end function bound

   !> A mass that two drivers move along a parabola; at x = 1 they let it go, and it flies.
   subroutine check_release(integrator)
      character(*), intent(in) :: integrator
      type(history_reader_type) :: reader
      real(wp), allocatable :: t(:), x(:), y(:), w(:), e(:), since(:)
      call run_scene('*GRAVITY'//nl//'*SWITCH, NAME=hold'//nl//'*POINT MASS, NAME=b, MASS=2'//nl// &
         & '*DRIVER, NAME=dx, TYPE=X, POINT=b, ACTIVE=hold'//nl//' 2*t'//nl// &
         & '*DRIVER, NAME=dy, TYPE=Y, POINT=b, ACTIVE=hold'//nl//' t**2'//nl// &
         & '*EVENT, NAME=let-go, DIRECTION=UP, ACTION=SWITCH, SWITCH=hold, TO=OFF'//nl//' x(b) - 1'//nl, integrator, &
         & 'END=1, OUTPUTS=10', &
         & ' x(b), y(b), force(dy), w = work(system), e = kinetic_energy(system) + potential_energy(system)', reader)
      t = numbers(reader, '/events/time')
      call check(size(t) == 1, integrator//': let go once')
      call check_close(t(1), 0.5_wp, bound(integrator), integrator//': time of the release')
      t = [(0.1_wp*k, k=0, 10)]
      since = max(0.0_wp, t - 0.5_wp)
      x = channel(reader, 'x_b')
      y = channel(reader, 'y_b')
      call check_close(maxval(abs(x - 2*t)), 0.0_wp, 20*bound(integrator), integrator//': x of the flight')
      call check_close(maxval(abs(y - merge(t**2, 0.25_wp + since - 0.5_wp*g*since**2, t < 0.5_wp))), 0.0_wp, &
         & 20*bound(integrator), integrator//': y of the flight')
      y = channel(reader, 'force_dy')
      call check_close(y(4), 2*(2 + g), 1.0e-6_wp, integrator//': force of the driver before')
      call check(.not. any(abs(y(7:)) > 0.0_wp), integrator//': no force of the driver behind')
      w = channel(reader, 'w')
      e = channel(reader, 'e')
      call check_close(maxval(abs(e - e(1) - w)), 0.0_wp, 1.0e-9_wp, integrator//': balance of energy')
      call reader%close()
   end subroutine check_release

   !> A wheel that a driver spins up to 60 rad/s and lets go: it coasts, and its turns are counted on.
   subroutine check_coasting(integrator)
      character(*), intent(in) :: integrator
      type(history_reader_type) :: reader
      real(wp), allocatable :: t(:), angle(:)
      call run_scene('*SWITCH, NAME=free, STATE=OFF'//nl//'*RIGID BODY, NAME=wheel, MASS=2, INERTIA=0.3'//nl// &
         & '*JOINT, NAME=hub, TYPE=REVOLUTE'//nl//' wheel.origin, ground.origin'//nl// &
         & '*DRIVER, NAME=motor, TYPE=ANGLE, BODY=wheel, INACTIVE=free'//nl//' 30*t**2'//nl// &
         & '*EVENT, NAME=fast, ACTION=SWITCH, SWITCH=free'//nl//' spin(wheel) - 60'//nl, integrator, 'END=2, OUTPUTS=4', &
         & ' angle(wheel), torque(motor)', reader)
      t = numbers(reader, '/events/time')
      call check(size(t) == 1, integrator//': let go once')
      call check_close(t(1), 1.0_wp, bound(integrator), integrator//': time of the full speed')
      angle = channel(reader, 'angle_wheel')
      call check_close(angle(4), 60.0_wp, 100*bound(integrator), integrator//': angle with its turns')
      call check_close(angle(5), 90.0_wp, 100*bound(integrator), integrator//': angle at the end')
      call reader%close()
   end subroutine check_coasting

   !> An arm falls from the horizontal, and its tip catches a mass that another joint has held: momentum about the pivot, energy
   !> lost, height of the swing of both.
   subroutine check_catch(integrator)
      character(*), intent(in) :: integrator
      real(wp), parameter :: m = 2.0_wp, c = 0.5_wp, caught = 0.8_wp
      real(wp), parameter :: j = 0.2_wp + m*c**2, both = j + caught
      type(history_reader_type) :: reader
      real(wp), allocatable :: values(:)
      real(wp) :: fast, slow, height
      fast = sqrt(2*m*g*c/j)
      slow = fast*j/both
      height = 0.5_wp*both*slow**2/g/(m*c + caught)
      call run_scene('*GRAVITY'//nl//'*GROUND'//nl//' hook, 0, -1'//nl//'*SWITCH, NAME=latch, STATE=OFF'//nl// &
         & '*RIGID BODY, NAME=arm, MASS=2, INERTIA=0.2, CENTRE X=0.5'//nl//' tip, 1, 0'//nl// &
         & '*POINT MASS, NAME=bob, MASS=0.8, Y=-1'//nl//'*JOINT, NAME=hinge, TYPE=REVOLUTE'//nl// &
         & ' arm.origin, ground.origin'//nl//'*JOINT, NAME=rest, TYPE=REVOLUTE, INACTIVE=latch'//nl//' bob, ground.hook'//nl// &
         & '*JOINT, NAME=grip, TYPE=REVOLUTE, ACTIVE=latch'//nl//' bob, arm.tip'//nl// &
         & '*EVENT, NAME=catch, ACTION=SWITCH, SWITCH=latch'//nl//' angle(arm) + pi/2'//nl// &
         & '*EVENT, NAME=top, DIRECTION=UP, ACTION=STOP, AFTER=0.1'//nl//' spin(arm)'//nl, integrator, 'END=3, OUTPUTS=300', &
         & ' angle(arm), spin(arm), w = work(system), e = kinetic_energy(system) + potential_energy(system)', reader)
      values = numbers(reader, '/events/turned')
      call check(all(nint(values) == [1, 0]), integrator//': one turn of a switch')
      values = numbers(reader, '/events/channels/spin_arm')
      call check_close(values(1), -fast, 20*bound(integrator), integrator//': speed at the catch')
      values = numbers(reader, '/events/energy')
      call check_close(values(1), 0.5_wp*(both*slow**2 - j*fast**2), 20*bound(integrator), integrator//': energy lost')
      values = numbers(reader, '/events/channels/angle_arm')
      call check_close(values(2), -0.5_wp*pi - acos(1 - height), 20*bound(integrator), integrator//': height of the swing')
      values = channel(reader, 'e') - channel(reader, 'w')
      call check_close(maxval(abs(values - values(1))), 0.0_wp, merge(1.0e-3_wp, 30*bound(integrator), integrator == 'ALPHA'), &
         & integrator//': balance of energy')
      call reader%close()
   end subroutine check_catch

   !> The same with two switches, which two events turn at one instant, in either order: the arm is not stopped by the stand.
   subroutine check_instant(integrator, order)
      character(*), intent(in) :: integrator
      integer, intent(in) :: order
      character(*), parameter :: catch = '*EVENT, NAME=catch, ACTION=SWITCH, SWITCH=latch'//nl//' angle(arm) + pi/2'//nl
      character(*), parameter :: lift = '*EVENT, NAME=lift, ACTION=SWITCH, SWITCH=rest, TO=OFF'//nl//' angle(arm) + pi/2'//nl
      real(wp), parameter :: j = 0.7_wp, caught = 0.8_wp
      type(history_reader_type) :: reader
      real(wp), allocatable :: values(:)
      character(:), allocatable :: events
      events = catch//lift
      if (order == 2) events = lift//catch
      call run_scene('*GRAVITY'//nl//'*GROUND'//nl//' hook, 0, -1'//nl//'*SWITCH, NAME=latch, STATE=OFF'//nl// &
         & '*SWITCH, NAME=rest'//nl//'*RIGID BODY, NAME=arm, MASS=2, INERTIA=0.2, CENTRE X=0.5'//nl//' tip, 1, 0'//nl// &
         & '*POINT MASS, NAME=bob, MASS=0.8, Y=-1'//nl//'*JOINT, NAME=hinge, TYPE=REVOLUTE'//nl// &
         & ' arm.origin, ground.origin'//nl//'*JOINT, NAME=stand, TYPE=REVOLUTE, ACTIVE=rest'//nl//' bob, ground.hook'//nl// &
         & '*JOINT, NAME=grip, TYPE=REVOLUTE, ACTIVE=latch'//nl//' bob, arm.tip'//nl//events, integrator, 'END=1, OUTPUTS=10', &
         & ' angle(arm)', reader)
      values = numbers(reader, '/events/turned')
      call check(size(values) == 2 .and. nint(sum(values)) == 0, integrator//': two turns at one instant')
      values = numbers(reader, '/events/energy')
      call check_close(sum(values), -g*caught/(j + caught), 20*bound(integrator), integrator//': energy lost at one instant')
      call reader%close()
   end subroutine check_instant

   !> A slide of 2 kg and 3 m/s meets one of 1 kg at rest, and a weld joins them, two of whose equations are redundant then.
   subroutine check_coupling(integrator)
      character(*), intent(in) :: integrator
      type(history_reader_type) :: reader
      real(wp), allocatable :: values(:)
      call run_scene('*SWITCH, NAME=joined, STATE=OFF'//nl// &
         & '*RIGID BODY, NAME=a, MASS=2, INERTIA=0.1, VX=3'//nl//' front, 0.2, 0'//nl// &
         & '*RIGID BODY, NAME=b, MASS=1, INERTIA=0.1, X=1.4'//nl//' back, -0.2, 0'//nl// &
         & '*JOINT, NAME=rail-a, TYPE=TRANSLATIONAL'//nl//' a, ground.origin'//nl// &
         & '*JOINT, NAME=rail-b, TYPE=TRANSLATIONAL'//nl//' b, ground.origin'//nl// &
         & '*JOINT, NAME=coupling, TYPE=WELD, TURN=0, ACTIVE=joined'//nl//' a.front, b.back'//nl// &
         & '*EVENT, NAME=touch, ACTION=SWITCH, SWITCH=joined, DIRECTION=UP'//nl//' x(a.front) - x(b.back)'//nl, integrator, &
         & 'END=2, OUTPUTS=4', ' x(a), vx(b), y(b)', reader)
      values = numbers(reader, '/events/time')
      call check(size(values) == 1, integrator//': joined once')
      call check_close(values(1), 1.0_wp/3, bound(integrator), integrator//': time of the touch')
      values = numbers(reader, '/events/energy')
      call check_close(values(1), -0.5_wp*2/3*9, 20*bound(integrator), integrator//': energy lost in the coupling')
      values = channel(reader, 'x_a')
      call check_close(values(5), 1 + 2*(5.0_wp/3), 20*bound(integrator), integrator//': way of both')
      values = channel(reader, 'vx_b')
      call check_close(values(5), 2.0_wp, 20*bound(integrator), integrator//': speed of both')
      call reader%close()
   end subroutine check_coupling

   !> A pendulum of 1 m from 1 rad whose rod breaks below the pin, and one whose rod breaks at 1.5 times the weight: flight then.
   subroutine check_break(integrator)
      character(*), intent(in) :: integrator
      character(*), parameter :: scene = '*GRAVITY'//nl//'*SWITCH, NAME=whole'//nl// &
         & '*POINT MASS, NAME=p, MASS=1.5, X=sin(1), Y=-cos(1)'//nl//'*JOINT, NAME=rod, TYPE=ROD, ACTIVE=whole'//nl// &
         & ' p, ground.origin'//nl//'*EVENT, NAME=crack, ACTION=SWITCH, SWITCH=whole, TO=OFF'//nl
      type(history_reader_type) :: reader
      real(wp), allocatable :: t(:), x(:), y(:)
      real(wp) :: speed, since, angle
      call run_scene(scene//' x(p)'//nl, integrator, 'END=1, OUTPUTS=10', ' x(p), y(p), force_y(rod)', reader)
      speed = sqrt(2*g*(1 - cos(1.0_wp)))
      t = numbers(reader, '/events/time')
      since = 1 - t(1)
      x = channel(reader, 'x_p')
      y = channel(reader, 'y_p')
      call check(size(t) == 1, integrator//': one break')
      call check_close(x(11), -speed*since, 20*bound(integrator), integrator//': x behind the break')
      call check_close(y(11), -1 - 0.5_wp*g*since**2, 20*bound(integrator), integrator//': y behind the break')
      y = channel(reader, 'force_y_rod')
      call check(abs(y(1)) > 1.0_wp .and. .not. abs(y(11)) > 0.0_wp, integrator//': force of the rod before and behind')
      call reader%close()
      ! T = m v^2 + m g cos = 1.5 m g
      call run_scene(scene//' vx(p)**2 + vy(p)**2 - 9.81*y(p) - 1.5*9.81'//nl, integrator, 'END=1, OUTPUTS=10', ' x(p), vx(p)', &
         & reader)
      angle = acos((1.5_wp + 2*cos(1.0_wp))/3)
      speed = sqrt(2*g*(cos(angle) - cos(1.0_wp)))
      x = numbers(reader, '/events/channels/x_p')
      call check_close(x(1), sin(angle), 20*bound(integrator), integrator//': place of the break by force')
      x = channel(reader, 'vx_p')
      call check_close(x(11), -speed*cos(angle), 20*bound(integrator), integrator//': speed behind it')
      call reader%close()
   end subroutine check_break

   !> A chain of twelve bars that falls breaks in its middle at a sample: the mass centre of the loose half has the acceleration of
   !> gravity, and the energy stays.
   subroutine check_chain(integrator)
      character(*), intent(in) :: integrator
      type(history_reader_type) :: reader
      real(wp), allocatable :: y(:), e(:)
      call run_scene('*GRAVITY'//nl//'*SWITCH, NAME=whole'//nl//'*REPEAT, COUNT=12, INDEX=i'//nl// &
         & '*RIGID BODY, NAME=bar<i>, MASS=1, INERTIA=1/12, CENTRE X=0.5, X=i - 1'//nl//' middle, 0.5, 0'//nl//' end, 1, 0'//nl// &
         & '*END REPEAT'//nl//'*JOINT, NAME=pin1, TYPE=REVOLUTE'//nl//' bar1.origin, ground.origin'//nl// &
         & '*REPEAT, COUNT=5, INDEX=i, FROM=2'//nl//'*JOINT, NAME=pin<i>, TYPE=REVOLUTE'//nl//' bar<i>.origin, bar<i - 1>.end'// &
         & nl//'*END REPEAT'//nl//'*JOINT, NAME=pin7, TYPE=REVOLUTE, ACTIVE=whole'//nl//' bar7.origin, bar6.end'//nl// &
         & '*REPEAT, COUNT=5, INDEX=i, FROM=8'//nl//'*JOINT, NAME=pin<i>, TYPE=REVOLUTE'//nl//' bar<i>.origin, bar<i - 1>.end'// &
         & nl//'*END REPEAT'//nl//'*EVENT, NAME=crack, ACTION=SWITCH, SWITCH=whole, TO=OFF'//nl//' t - 0.2'//nl, integrator, &
         & 'END=0.6, OUTPUTS=6', ' c = (y(bar7.middle) + y(bar8.middle) + y(bar9.middle) + y(bar10.middle) + '// &
         & 'y(bar11.middle) + y(bar12.middle))/6'//nl//' e = kinetic_energy(system) + potential_energy(system)', reader)
      y = channel(reader, 'c')
      call check_close(maxval(abs(y(5:) - 2*y(4:6) + y(3:5) + 0.01_wp*g)), 0.0_wp, 20*bound(integrator), integrator// &
         & ': fall of the loose half')
      e = channel(reader, 'e')
      call check_close(maxval(abs(e - e(1))), 0.0_wp, merge(1.0e-3_wp, 100*bound(integrator), integrator == 'ALPHA'), &
         & integrator//': energy of the chain')
      call reader%close()
   end subroutine check_chain

   !> A clutch of two wheels, a coupler that begins to act at whatever angles they have: moment of momentum, energy lost.
   subroutine check_clutch(integrator)
      character(*), intent(in) :: integrator
      type(history_reader_type) :: reader
      real(wp), allocatable :: values(:)
      call run_scene('*SWITCH, NAME=clutch, STATE=OFF'//nl//'*GROUND'//nl//' right, 1, 0'//nl// &
         & '*RIGID BODY, NAME=a, MASS=1, INERTIA=0.3, SPIN=20'//nl//'*RIGID BODY, NAME=b, MASS=1, INERTIA=0.2, X=1'//nl// &
         & '*JOINT, NAME=ja, TYPE=REVOLUTE'//nl//' a, ground.origin'//nl//'*JOINT, NAME=jb, TYPE=REVOLUTE'//nl// &
         & ' b, ground.right'//nl//'*COUPLER, NAME=shaft, ACTIVE=clutch'//nl//' 1, joint_angle, ja'//nl//' -1, joint_angle, jb'// &
         & nl//'*EVENT, NAME=engage, ACTION=SWITCH, SWITCH=clutch'//nl//' angle(a) - 9'//nl, integrator, 'END=1, OUTPUTS=10', &
         & ' spin(a), angle(a), angle(b)', reader)
      values = numbers(reader, '/events/energy')
      call check_close(values(1), -0.5_wp*0.3_wp*0.2_wp/0.5_wp*400, 400*bound(integrator), integrator//': loss of the clutch')
      values = channel(reader, 'spin_a')
      call check_close(values(11), 12.0_wp, 20*bound(integrator), integrator//': speed of both wheels')
      values = channel(reader, 'angle_a') - channel(reader, 'angle_b')
      call check_close(values(11), 9.0_wp, 20*bound(integrator), integrator//': their angles keep their difference')
      call reader%close()
   end subroutine check_clutch

   !> A mass of 2 kg at 1 m/s: at x = 1 a spring of 50 N/m engages without tension, or with that of 0.5 m.
   subroutine check_spring(integrator)
      character(*), intent(in) :: integrator
      type(history_reader_type) :: reader
      real(wp), allocatable :: values(:)
      character(*), parameter :: scene = '*SWITCH, NAME=on, STATE=OFF'//nl//'*POINT MASS, NAME=p, MASS=2, VX=1'//nl// &
         & '*EVENT, NAME=engage, DIRECTION=UP, ACTION=SWITCH, SWITCH=on'//nl//' x(p) - 1'//nl//'*SPRING, NAME=s, STIFFNESS=50'// &
         & ', ACTIVE=on, LENGTH='
      call run_scene(scene//'1'//nl//' p, ground.origin'//nl, integrator, 'END=1.7, OUTPUTS=17', ' x(p), tension(s), '// &
         & 'elongation(s)', reader)
      values = channel(reader, 'x_p')
      call check_close(values(18), 1 + 0.2_wp*sin(5*0.7_wp), 20*bound(integrator), integrator//': swing on the spring')
      values = channel(reader, 'tension_s')
      call check_close(values(18), 10*sin(5*0.7_wp), 1000*bound(integrator), integrator//': its tension')
      call check(.not. any(abs(values(:10)) > 0.0_wp), integrator//': no tension before')
      values = channel(reader, 'elongation_s')
      call check_close(values(6), -0.5_wp, 20*bound(integrator), integrator//': elongation before')
      values = numbers(reader, '/events/energy')
      call check_close(values(1), 0.0_wp, 20*bound(integrator), integrator//': no energy at the engagement')
      call reader%close()
      call run_scene(scene//'0.5'//nl//' p, ground.origin'//nl, integrator, 'END=1.3, OUTPUTS=13', ' x(p), w = work(system)', &
         & reader)
      values = channel(reader, 'x_p')
      call check_close(values(14), 0.5_wp + 0.5_wp*cos(1.5_wp) + 0.2_wp*sin(1.5_wp), 20*bound(integrator), integrator// &
         & ': swing on the tight spring')
      values = numbers(reader, '/events/energy')
      call check_close(values(1), 25*0.25_wp, 100*bound(integrator), integrator//': energy of the tight spring')
      values = channel(reader, 'w')
      call check_close(values(14), 25*0.25_wp, 100*bound(integrator), integrator//': it is counted as work')
      call reader%close()
   end subroutine check_spring

   !> A force of 6 N on 2 kg from x = 1 to x = 3, and again from x = 5 on, by one event that toggles it; a torque by its second
   !> crossing.
   subroutine check_toggle(integrator)
      character(*), intent(in) :: integrator
      type(history_reader_type) :: reader
      real(wp), allocatable :: t(:), x(:), turned(:)
      real(wp) :: t1, t2, v
      call run_scene('*SWITCH, NAME=on, STATE=OFF'//nl//'*SWITCH, NAME=late, STATE=OFF'//nl// &
         & '*POINT MASS, NAME=p, MASS=2, VX=2'//nl//'*FORCE, NAME=push, POINT=p, ACTIVE=on'//nl//' 6, 0'//nl// &
         & '*RIGID BODY, NAME=wheel, MASS=1, INERTIA=0.5'//nl//'*TORQUE, NAME=turn, BODY=wheel, ACTIVE=late'//nl//' 4'//nl// &
         & '*EVENT, NAME=gate, ACTION=SWITCH, SWITCH=on, TO=TOGGLE'//nl//' (x(p) - 1)*(x(p) - 3)*(x(p) - 5)'//nl// &
         & '*EVENT, NAME=second, ACTION=SWITCH, SWITCH=late, NUMBER=2'//nl//' (x(p) - 1)*(x(p) - 3)'//nl, integrator, &
         & 'END=2, OUTPUTS=20', ' x(p), spin(wheel)', reader)
      ! x = 1 at 0.5; 3 t^2/2 + 2 t = 2
      t1 = 0.5_wp + (sqrt(16.0_wp) - 2)/3
      v = 4.0_wp
      t2 = t1 + 2/v
      t = numbers(reader, '/events/time')
      turned = numbers(reader, '/events/turned')
      call check(size(t) == 5, integrator//': five events')
      call check(nint(sum(turned(:2))) == 1 .and. nint(product(turned(:2))) == 0, integrator//': on')
      call check(nint(sum(turned(3:4))) == 0 .and. nint(product(turned(3:4))) == -1, integrator//': off, and the other on')
      call check_close(t(4), t1, bound(integrator), integrator//': end of the push')
      call check_close(t(5), t2, 2*bound(integrator), integrator//': second push')
      x = channel(reader, 'x_p')
      call check_close(x(21), 5 + v*(2 - t2) + 1.5_wp*(2 - t2)**2, 40*bound(integrator), integrator//': way')
      x = channel(reader, 'spin_wheel')
      call check_close(x(21), 8*(2 - t1), 40*bound(integrator), integrator//': the second crossing turns the other switch')
      call reader%close()
   end subroutine check_toggle

   !> A cantilever of two modes whose tip a guide holds 0.1 mm below its axis: let go, its modes swing with their shares 12/b^4 of
   !> the deflection by a force at the tip, and their frequencies b^2 sqrt(E I/(rho A l^4)).
   subroutine check_beam(integrator)
      character(*), intent(in) :: integrator
      real(wp), parameter :: b(2) = [1.875104068711961_wp, 4.694091132974175_wp], held = 1.0e-4_wp
      type(history_reader_type) :: reader
      real(wp), allocatable :: y(:)
      real(wp) :: omega(2)
      omega = b**2*sqrt(200.0e9_wp*0.01_wp**2/12/7850)
      call run_scene('*MATERIAL, NAME=steel, YOUNG=200e9, DENSITY=7850'//nl// &
         & '*SECTION, NAME=square, SHAPE=RECTANGLE, WIDTH=0.01, HEIGHT=0.01'//nl//'*GROUND'//nl//' below, 0, -1e-4'//nl// &
         & '*SWITCH, NAME=held'//nl//'*BEAM, NAME=rod, MATERIAL=steel, SECTION=square, LENGTH=1, SUPPORT=CLAMPED-FREE, '// &
         & 'BENDING MODES=2, ELEMENTS=200'//nl// &
         & '*JOINT, NAME=root, TYPE=WELD'//nl//' rod.start, ground.origin'//nl// &
         & '*JOINT, NAME=guide, TYPE=POINT ON LINE, ACTIVE=held'//nl//' rod.end, ground.below'//nl// &
         & '*EVENT, NAME=let-go, ACTION=SWITCH, SWITCH=held, TO=OFF'//nl//' t - 0.01'//nl, integrator, 'END=0.1, OUTPUTS=10', &
         & ' y(rod.end)', reader)
      y = channel(reader, 'y_rod_end')
      call check_close(y(2), -held, 1.0e-12_wp, integrator//': held')
      call check_close(y(11), -held*sum(cos(0.09_wp*omega)/b**4)/sum(1/b**4), held*(1.0e-4_wp + omega(1)*bound(integrator)), &
         & integrator//': swing of the beam')
      call reader%close()
   end subroutine check_beam

   !> An arm that falls is locked by its tip, where its hinge leaves one of the new equations nothing to do: all energy is lost.
   subroutine check_lock(integrator)
      character(*), intent(in) :: integrator
      type(history_reader_type) :: reader
      real(wp), allocatable :: values(:)
      call run_scene('*GRAVITY'//nl//'*GROUND'//nl//' hook, 0, -1'//nl//'*SWITCH, NAME=latch, STATE=OFF'//nl// &
         & '*RIGID BODY, NAME=arm, MASS=2, INERTIA=0.2, CENTRE X=0.5'//nl//' tip, 1, 0'//nl// &
         & '*JOINT, NAME=hinge, TYPE=REVOLUTE'//nl//' arm.origin, ground.origin'//nl// &
         & '*JOINT, NAME=lock, TYPE=REVOLUTE, ACTIVE=latch'//nl//' arm.tip, ground.hook'//nl// &
         & '*EVENT, NAME=catch, ACTION=SWITCH, SWITCH=latch'//nl//' angle(arm) + pi/2'//nl// &
         & '*EVENT, NAME=open, ACTION=SWITCH, SWITCH=latch, TO=OFF'//nl//' t - 1.5'//nl, integrator, 'END=2, OUTPUTS=20', &
         & ' angle(arm), spin(arm)', reader)
      values = numbers(reader, '/events/energy')
      call check(size(values) == 2, integrator//': locked and opened')
      call check_close(values(1), -g, 20*bound(integrator), integrator//': energy lost at the lock')
      values = channel(reader, 'angle_arm')
      call check_close(values(21), -0.5_wp*pi, 1.0e-9_wp, integrator//': at rest for good')
      values = channel(reader, 'spin_arm')
      call check_close(maxval(abs(values(11:))), 0.0_wp, 1.0e-9_wp, integrator//': without speed')
      call reader%close()
   end subroutine check_lock

   !> input/latch.inp: energy of the catch, and where the ball is at the end.
   subroutine check_latch()
      real(wp), parameter :: j = 4.0_wp/3, ball = 0.5_wp, up = 0.7_wp
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp), allocatable :: values(:), t(:)
      real(wp) :: caught, thrown, since
      call run_deck('../input/latch.inp', trim(results), .true., .true., report, error)
      call check_no_error(error, 'latch')
      call reader%open(trim(results), error)
      call check_no_error(error, 'latch')
      caught = sqrt(4*g/j)*j/(j + ball)
      thrown = sqrt(caught**2 - 2*g*(2 + ball)*(1 - cos(up))/(j + ball))
      values = numbers(reader, '/events/energy')
      call check_close(sum(values), 0.5_wp*(j + ball)*caught**2 - 2*g, 1.0e-7_wp, 'latch: energy of the catch')
      t = numbers(reader, '/events/time')
      since = 1.2_wp - t(3)
      values = channel(reader, 'x_ball')
      call check_close(values(121), -sin(up) - thrown*cos(up)*since, 1.0e-7_wp, 'latch: x of the ball')
      values = channel(reader, 'y_ball')
      call check_close(values(121), -cos(up) + thrown*sin(up)*since - 0.5_wp*g*since**2, 1.0e-7_wp, 'latch: y of the ball')
      call reader%close()
   end subroutine check_latch

   !> A second spring acts since an event of the motion: the equilibrium that follows has both.
   subroutine check_statics()
      type(history_reader_type) :: reader
      real(wp), allocatable :: x(:)
      call run_scene('*SWITCH, NAME=on, STATE=OFF'//nl//'*POINT MASS, NAME=p, MASS=2, X=1'//nl// &
         & '*FORCE, NAME=f, POINT=p'//nl//' 30, 0'//nl//'*GROUND'//nl//' left, -1, 0'//nl// &
         & '*SPRING, NAME=one, STIFFNESS=100, LENGTH=2'//nl//' p, ground.left'//nl// &
         & '*SPRING, NAME=two, STIFFNESS=200, LENGTH=2, ACTIVE=on'//nl//' p, ground.left'//nl// &
         & '*JOINT, NAME=rail, TYPE=POINT ON LINE'//nl//' p, ground.origin'//nl// &
         & '*EVENT, NAME=engage, ACTION=SWITCH, SWITCH=on'//nl//' t - 0.5'//nl, 'RADAU', 'END=1, OUTPUTS=2'//nl// &
         & '*STATICS, RAMP=NO', ' x(p)', reader)
      x = channel(reader, 'x_p')
      call check_close(x(size(x)), 1.1_wp, 1.0e-9_wp, 'equilibrium with the state of the switch')
      call reader%close()
   end subroutine check_statics

   !> What is off at the start has no part in the first position, and mobility.
   subroutine check_states()
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call run_text('*SWITCH, NAME=off, STATE=OFF'//nl//'*RIGID BODY, NAME=b, MASS=1, INERTIA=1, ANGLE=0.3'//nl// &
         & '*JOINT, NAME=j, TYPE=WELD, TURN=0, ACTIVE=off'//nl//' b, ground.origin'//nl// &
         & '*DRIVER, NAME=d, TYPE=ANGLE, BODY=b, ACTIVE=off'//nl//' 1'//nl//'*DYNAMICS, END=1, OUTPUTS=2'//nl//'*OUTPUT'//nl// &
         & ' angle(b)'//nl, trim(results), report, error)
      call check_no_error(error, 'states at the start')
      call check(index(report, '3 rates, 0 constraint equations: 3 degrees of freedom') > 0, 'what is off has no equations')
   end subroutine check_states

   !> What cannot be: a joint that misses its position, switches without an end, comparisons of runs.
   subroutine check_refusals()
      character(*), parameter :: body = '*SWITCH, NAME=s, STATE=OFF'//nl//'*POINT MASS, NAME=p, MASS=1, VX=1'//nl
      call check_refused(body//'*JOINT, NAME=pin, TYPE=REVOLUTE, ACTIVE=s'//nl//' p, ground.origin'//nl// &
         & '*EVENT, NAME=e, ACTION=SWITCH, SWITCH=s'//nl//' x(p) - 0.5'//nl//'*DYNAMICS, END=1'//nl, &
         & "joint 'pin' does not close at t = 0.5")
      call check_refused('*SWITCH, NAME=s, STATE=OFF'//nl//'*RIGID BODY, NAME=p, MASS=1, INERTIA=1, SPIN=4'//nl// &
         & '*JOINT, NAME=weld, TYPE=WELD, TURN=0, ACTIVE=s'//nl//' p, ground.origin'//nl// &
         & '*EVENT, NAME=e, ACTION=SWITCH, SWITCH=s'//nl//' angle(p) - pi'//nl//'*DYNAMICS, END=2'//nl, &
         & "joint 'weld' does not close at t = 0.785398")
      call check_refused(body//'*FORCE, NAME=f, POINT=p, ACTIVE=s'//nl//' -1, 0'//nl//'*FORCE, NAME=h, POINT=p, INACTIVE=s'//nl// &
         & ' 1, 0'//nl//'*EVENT, NAME=e, ACTION=SWITCH, SWITCH=s, TO=TOGGLE'//nl//' vx(p) - 1.5'//nl//'*DYNAMICS, END=1'//nl, &
         & "switch 's' is turned again and again at t = 0.5")
      call check_refused(body//'*EVENT, NAME=e, ACTION=SWITCH, SWITCH=s'//nl//' x(p) - 0.5'//nl//'*DYNAMICS, END=1'//nl// &
         & '*ACCURACY, ESTIMATE=YES'//nl, 'runs that turn it at different times')
   end subroutine check_refusals

   !> Checks that a deck is refused, with a text.
   subroutine check_refused(blocks, text)
      character(*), intent(in) :: blocks, text
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call run_text(blocks//'*OUTPUT'//nl//' x(p)'//nl, trim(results), report, error)
      call check(allocated(error), text)
      if (allocated(error)) call check(index(error%message, text) > 0, text//': '//error%message)
   end subroutine check_refused

   !> Runs a scene, and opens its results.
   subroutine run_scene(scene, integrator, options, output, reader)
      !> Blocks; options of *DYNAMICS; lines of *OUTPUT
      character(*), intent(in) :: scene, integrator, options, output
      type(history_reader_type), intent(out) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call run_text(scene//'*DYNAMICS, INTEGRATOR='//integrator//', TOLERANCE='//tolerance//', '//options//nl//'*OUTPUT'//nl// &
         & output//nl, trim(results), report, error)
      call check_no_error(error, integrator//', '//tolerance//', '//output)
      call reader%open(trim(results), error)
      call check_no_error(error, 'results')
   end subroutine run_scene

end program test_switches
