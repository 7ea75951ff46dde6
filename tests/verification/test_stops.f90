!> One-sided stops, *STOP, by all integrators, against closed forms: a mass between two buffers, the loss of Hunt and Crossley, a
!> rope
!> that goes slack, a pendulum with limits of its angle, a ball on the ground, a pin in a bush, a wall that turns.
!> Usage, in tests/: test_stops RESULT_FILE
program test_stops
   use limber_base_kinds, only: wp
   use limber_output_history_reader, only: history_reader_type
   use runs, only: numbers, run_text, channel
   use limber_base_error, only: error_type
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   character(*), parameter :: nl = new_line('a')
   character(*), parameter :: integrators(4) = [character(10) :: 'ADAMS', 'RADAU', 'ALPHA', 'CONSERVING']
   character(256) :: results
   integer :: i

   call get_command_argument(1, results)
   do i = 1, size(integrators)
      call check_buffers(trim(integrators(i)))
      call check_loss(trim(integrators(i)))
      call check_rope(trim(integrators(i)))
      call check_limits(trim(integrators(i)))
      call check_bounces(trim(integrators(i)))
      call check_bush(trim(integrators(i)))
      call check_wall(trim(integrators(i)))
   end do
   call check_sign()
   call check_rebounds()
   call check_refused(', AXIS=0.2, JOINT=rail, MOST=1', 'a joint has its own axis')
   call check_refused(', JOINT=rail, MOST=1, EXPONENT=0.5', 'infinitely stiff')
   call finish()

contains

   !> A ball of 1 kg falls by 1 m on ground of 1e6 d^1.5 (1 + 0.3 d') N: references integrated from event to event, 3e-10. ALPHA and
   !> CONSERVING, which are of order two, show the first contact alone.
   subroutine check_bounces(integrator)
      character(*), intent(in) :: integrator
      real(wp), parameter :: contacts(4) = [0.4515236409857308_wp, 0.9252468843797986_wp, 1.2486387498833103_wp, &
         & 1.495010671728497_wp]
      real(wp), parameter :: releases(4) = [0.46215093067268026_wp, 0.936801840231651_wp, 1.2609730679242661_wp, &
         & 1.5080113715626062_wp]
      real(wp), parameter :: speeds(4) = [2.2714856529334173_wp, 1.529560041841389_wp, 1.147954446659753_wp, 0.9143602021909363_wp]
      real(wp), parameter :: depths(4) = [0.01129838526610008_wp, 0.0073375440512194155_wp, 0.005609432544792974_wp, &
         & 0.0045987703900701215_wp]
      type(history_reader_type) :: reader
      real(wp), allocatable :: t(:), speed(:), y(:), which(:)
      real(wp) :: allowed
      integer :: k
      allowed = merge(1.0e-6_wp, 2.0e-3_wp, integrator == 'ADAMS' .or. integrator == 'RADAU')
      call run_scene(integrator, '*GRAVITY, X=0, Y=-9.81'//nl//'*POINT MASS, NAME=b, MASS=1, Y=1'//nl// &
         & '*STOP, NAME=s, AXIS=90 deg, LEAST=0, STIFFNESS=1e6, EXPONENT=1.5, DAMPING=0.3'//nl//' b, ground.origin'//nl// &
         & '*EVENT, NAME=contact, DIRECTION=DOWN'//nl//' y(b)'//nl//'*EVENT, NAME=release, DIRECTION=UP'//nl//' y(b)'//nl// &
         & '*EVENT, NAME=lowest, DIRECTION=UP'//nl//' vy(b)'//nl, '1.6', ' y(b), vy(b)')
      call open_results(reader)
      t = numbers(reader, '/events/time')
      which = numbers(reader, '/events/event')
      speed = numbers(reader, '/events/channels/vy_b')
      y = numbers(reader, '/events/channels/y_b')
      call check(size(t) == 12, integrator//': contacts, deepest places and releases')
      do k = 1, merge(4, 1, integrator == 'ADAMS' .or. integrator == 'RADAU')
         if (3*k > size(t)) exit
         call check(all(nint(which(3*k - 2:3*k)) == [1, 3, 2]), integrator//': their order')
         call check_close(t(3*k - 2), contacts(k), allowed, integrator//': contact of the ball')
         call check_close(y(3*k - 1), -depths(k), allowed*depths(k), integrator//': depth of the ball')
         call check_close(t(3*k), releases(k), allowed, integrator//': release of the ball')
         call check_close(speed(3*k), speeds(k), 10*allowed, integrator//': rebound of the ball')
      end do
      call reader%close()
   end subroutine check_bounces

   !> A pin in a bush with a clearance of 1 mm and 1e7 d^1.5 (1 + 2 d') N: references integrated from event to event, 5e-12.
   subroutine check_bush(integrator)
      character(*), intent(in) :: integrator
      real(wp), parameter :: contacts(8) = [0.00912710655948078_wp, 0.022150368352088463_wp, 0.05197351483570641_wp, &
         & 0.07824059973297848_wp, 0.20107060100358543_wp, 0.23974875088973588_wp, 0.277494546049337_wp, 0.3143977778971002_wp]
      real(wp), allocatable :: t(:), x(:), y(:)
      type(history_reader_type) :: reader
      integer :: k
      if (integrator == 'ALPHA' .or. integrator == 'CONSERVING') return
      call run_scene(integrator, '*GRAVITY, X=0, Y=-9.81'//nl//'*POINT MASS, NAME=pin, MASS=0.5, VX=0.1'//nl// &
         & '*STOP, NAME=bush, MOST=1e-3, STIFFNESS=1e7, EXPONENT=1.5, DAMPING=2'//nl//' pin, ground.origin'//nl// &
         & '*EVENT, NAME=contact, DIRECTION=UP'//nl//' sqrt(x(pin)**2 + y(pin)**2) - 1e-3'//nl, '0.4', ' x(pin), y(pin)')
      call open_results(reader)
      t = numbers(reader, '/events/time')
      call check(size(t) == 8, integrator//': contacts of the pin')
      do k = 1, min(8, size(t))
         call check_close(t(k), contacts(k), 1.0e-6_wp, integrator//': contact of the pin')
      end do
      call reader%close()
      x = values('x_pin')
      y = values('y_pin')
      call check_close(x(size(x)), 0.0002462525987090276_wp, 1.0e-7_wp, integrator//': x of the pin')
      call check_close(y(size(y)), -0.0010537192777685161_wp, 1.0e-7_wp, integrator//': y of the pin')
   end subroutine check_bush

   !> A mass between the walls of a carriage that turns: it is pressed against the outer wall of a table at 5 rad/s, m w^2 (r + d)
   !> = k d.
   subroutine check_wall(integrator)
      character(*), intent(in) :: integrator
      real(wp), allocatable :: u(:), force(:)
      real(wp) :: depth
      if (integrator == 'CONSERVING' .or. integrator == 'ALPHA') return
      depth = 2*25*0.5_wp/(1.0e4_wp - 2*25)
      call run_scene(integrator, '*RIGID BODY, NAME=table, MASS=1, INERTIA=1'//nl//'*JOINT, NAME=hub, TYPE=REVOLUTE'//nl// &
         & ' table.origin, ground.origin'//nl//'*DRIVER, NAME=motor, TYPE=ANGLE, BODY=table'//nl//' 5*t'//nl// &
         & '*PARAMETER'//nl//' place = 0.5 + 2*25*0.5/(1e4 - 2*25)'//nl// &
         & '*POINT MASS, NAME=b, MASS=2, X=place*cos(0.4), Y=place*sin(0.4), VX=-5*place*sin(0.4), VY=5*place*cos(0.4)'//nl// &
         & '*JOINT, NAME=slot, TYPE=POINT ON LINE, ANGLE=0.4'//nl//' b, table.origin'//nl// &
         & '*STOP, NAME=wall, AXIS=0.4, MOST=0.5, STIFFNESS=1e4'//nl//' b, table.origin'//nl, '2', &
         & ' displacement(slot), tension(wall)')
      u = values('displacement_slot')
      force = values('tension_wall')
      call check_close(u(size(u)), 0.5_wp + depth, 1.0e-7_wp, integrator//': place beside a wall that turns')
      call check_close(force(size(force)), 1.0e4_wp*depth, 1.0e-2_wp, integrator//': force of the wall')
   end subroutine check_wall

   !> A bar rests on a limit of its joint: the stop pushes the first body up. The other order of bodies: the first is the ground.
   subroutine check_sign()
      real(wp), allocatable :: angle(:), torque(:)
      integer :: i
      do i = 1, 2
         call run_scene('RADAU', '*GRAVITY, X=0, Y=-9.81'//nl//'*RIGID BODY, NAME=bar, MASS=2, INERTIA=0.1, CENTRE X=0.25'//nl// &
            & '*JOINT, NAME=pin, TYPE=REVOLUTE'//nl// &
            & merge(' bar.origin, ground.origin', ' ground.origin, bar.origin', i == 1)//nl// &
            & '*STOP, NAME=s, JOINT=pin, STIFFNESS=1e6, DAMPING=50, '//trim(merge('LEAST=-0.1', 'MOST=0.1  ', i == 1))//nl, &
            & '9', ' angle(bar), torque(s)')
         angle = values('angle_bar')
         torque = values('torque_s')
         call check_close(torque(size(torque)), 2*9.81_wp*0.25_wp*cos(angle(size(angle)))*merge(1, -1, i == 1), 1.0e-4_wp, &
            & 'torque of a stop on its first body')
      end do
   end subroutine check_sign

   !> The speed behind an undamped stop is that before it, whatever the steps: by RADAU at 1e-7, errors of 607 tolerances where the
   !> stop lay in the middle of a step.
   subroutine check_rebounds()
      real(wp), allocatable :: v(:)
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      character(8) :: speed
      integer :: i
      do i = 1, 30
         write (speed, '(f8.4)') 2.2881_wp + 0.0137_wp*(i - 1)
         call run_text('*POINT MASS, NAME=m, MASS=0.6, X=0.6, VX=-'//trim(adjustl(speed))//nl//'*STOP, NAME=s, LEAST=0.4,'// &
            & ' STIFFNESS=3000'//nl//' m, ground.origin'//nl// &
            & '*DYNAMICS, END=2, OUTPUTS=20, TOLERANCE=1e-7, INTEGRATOR=RADAU'//nl//'*OUTPUT'//nl//' vx(m)'// &
            & nl, trim(results), report, error)
         call check_no_error(error, 'rebound')
         v = values('vx_m')
         call check_close(v(size(v)), 2.2881_wp + 0.0137_wp*(i - 1), 1.0e-6_wp, 'speed behind an undamped stop')
      end do
   end subroutine check_rebounds

   !> Checks that a stop is refused, with a text.
   subroutine check_refused(options, text)
      character(*), intent(in) :: options, text
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call run_text('*POINT MASS, NAME=b, MASS=2'//nl//'*JOINT, NAME=rail, TYPE=POINT ON LINE'//nl//' b, ground'//nl// &
         & '*STOP, NAME=s, STIFFNESS=1'//options//nl//'*DYNAMICS, END=1'//nl//'*OUTPUT'//nl//' x(b)'// &
         & nl, trim(results), report, error)
      call check(allocated(error), text)
      if (allocated(error)) call check(index(error%message, text) > 0, text//': '//error%message)
   end subroutine check_refused

   !> Opens the results of the last run.
   subroutine open_results(reader)
      type(history_reader_type), intent(out) :: reader
      type(error_type), allocatable :: error
      call reader%open(trim(results), error)
      call check_no_error(error, 'results')
   end subroutine open_results

   !> A mass of 2 kg at 3 m/s between buffers at 0.2 and 1.5 m: sines of half a period at each.
   subroutine check_buffers(integrator)
      character(*), intent(in) :: integrator
      real(wp), parameter :: speed = 3.0_wp, least = 0.2_wp, most = 1.5_wp, stiffness = 2.0e4_wp, mass = 2.0_wp
      real(wp), allocatable :: t(:), x(:)
      real(wp) :: omega, period, s, touch, cross
      integer :: k
      call run_scene(integrator, '*POINT MASS, NAME=b, MASS=2, X=0.2, VX=3'//nl//'*JOINT, NAME=rail, TYPE=POINT ON LINE'//nl// &
         & ' b, ground'//nl//'*STOP, NAME=s, JOINT=rail, LEAST=0.2, MOST=1.5, STIFFNESS=2e4'//nl, '2', ' x(b), clock = t')
      t = values('clock')
      x = values('x_b')
      omega = sqrt(stiffness/mass)
      touch = acos(-1.0_wp)/omega
      cross = (most - least)/speed
      period = 2*(touch + cross)
      do k = 1, size(t)
         s = modulo(t(k), period)
         if (s < cross) then
            s = least + speed*s
         else if (s < cross + touch) then
            s = most + speed/omega*sin(omega*(s - cross))
         else if (s < 2*cross + touch) then
            s = most - speed*(s - cross - touch)
         else
            s = least - speed/omega*sin(omega*(s - 2*cross - touch))
         end if
         call check_close(x(k), s, bound(integrator), integrator//': between buffers')
      end do
   end subroutine check_buffers

   !> Rebound by the law k d (1 + c d'): u - ln(1 + c u)/c is the same before and behind, u the speed into the stop.
   subroutine check_loss(integrator)
      character(*), intent(in) :: integrator
      real(wp), parameter :: c = 0.3_wp, speed = 2.0_wp
      real(wp), allocatable :: v(:)
      real(wp) :: u, wanted
      integer :: k
      call run_scene(integrator, '*POINT MASS, NAME=b, MASS=1, X=1, VX=-2'//nl//'*STOP, NAME=s, LEAST=0.5, STIFFNESS=1e4, '// &
         & 'DAMPING=0.3'//nl//' b, ground.origin'//nl, '1', ' vx(b), work(system)')
      v = values('vx_b')
      wanted = speed - log(1 + c*speed)/c
      u = -speed
      do k = 1, 50
         u = u - (u - log(1 + c*u)/c - wanted)*(1 + c*u)/(c*u)
      end do
      call check_close(v(size(v)), -u, bound(integrator), integrator//': speed behind a stop that damps')
      v = values('work_system')
      call check_close(v(size(v)), 0.5_wp*(u**2 - speed**2), 2*bound(integrator), integrator//': energy lost in it')
   end subroutine check_loss

   !> A mass falls from 0.4 m below the ground into a rope of 1 m: free fall, half a period about its rest, and up again.
   subroutine check_rope(integrator)
      character(*), intent(in) :: integrator
      real(wp), parameter :: g = 10.0_wp, omega = 20.0_wp, start = 0.4_wp, length = 1.0_wp
      real(wp), allocatable :: t(:), y(:)
      real(wp) :: fall, speed, rest, half, s
      integer :: k
      call run_scene(integrator, '*POINT MASS, NAME=b, MASS=1, Y=-0.4'//nl//'*GRAVITY, Y=-10'//nl// &
         & '*STOP, NAME=s, MOST=1, STIFFNESS=400'//nl//' b, ground.origin'//nl, '0.85', ' y(b), clock = t')
      t = values('clock')
      y = values('y_b')
      fall = sqrt(2*(length - start)/g)
      speed = g*fall
      ! About the rest: -g/omega^2 cos + v/omega sin, back at the free length
      rest = length + g/omega**2
      half = (acos(-1.0_wp) + 2*atan2(g, speed*omega))/omega
      do k = 1, size(t)
         if (t(k) < fall) then
            s = start + 0.5_wp*g*t(k)**2
         else if (t(k) < fall + half) then
            s = rest - g/omega**2*cos(omega*(t(k) - fall)) + speed/omega*sin(omega*(t(k) - fall))
         else
            s = length - speed*(t(k) - fall - half) + 0.5_wp*g*(t(k) - fall - half)**2
         end if
         call check_close(y(k), -s, bound(integrator), integrator//': a rope that goes slack')
      end do
   end subroutine check_rope

   !> A pendulum thrown against a limit of its angle comes back through its lowest place with the speed that it had.
   subroutine check_limits(integrator)
      character(*), intent(in) :: integrator
      real(wp), allocatable :: angle(:), spin(:), energy(:)
      integer :: k
      call run_scene(integrator, '*GRAVITY, Y=-9.81'//nl//'*RIGID BODY, NAME=r, MASS=1, INERTIA=0.02, CENTRE X=0.5, '// &
         & 'ANGLE=-pi/2, SPIN=3'//nl//'*JOINT, NAME=p, TYPE=REVOLUTE'//nl//' r, ground'//nl// &
         & '*STOP, NAME=s, JOINT=p, LEAST=-2, MOST=-1.2, STIFFNESS=5e3'//nl, '3', &
         & ' angle(r), spin(r), e=kinetic_energy(system)+potential_energy(system)')
      angle = values('angle_r')
      spin = values('spin_r')
      energy = values('e')
      do k = 1, size(angle)
         call check_close(energy(k), energy(1), bound(integrator), integrator//': energy between limits of an angle')
         if (angle(k) > -2.0_wp .and. angle(k) < -1.2_wp) call check_close(spin(k)**2, 9 - 2*9.81_wp*0.5_wp/0.27_wp* &
            & (1 + sin(angle(k))), 20*bound(integrator), integrator//': speed between limits of an angle')
      end do
   end subroutine check_limits

   !> Error that an integrator may have here at its tolerance.
   pure real(wp) function bound(integrator)
      character(*), intent(in) :: integrator
      bound = merge(1.0e-4_wp, 2.0e-6_wp, integrator == 'ALPHA' .or. integrator == 'CONSERVING')
   end function bound

   !> Runs a scene with one integrator; `values` reads its channels.
   subroutine run_scene(integrator, scene, end, output)
      character(*), intent(in) :: integrator, scene, end, output
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call run_text(scene//'*DYNAMICS, END='//end//', OUTPUTS=50, TOLERANCE=1e-8, INTEGRATOR='//integrator//nl//'*OUTPUT'//nl// &
         & output//nl, trim(results), report, error)
      call check_no_error(error, integrator)
   end subroutine run_scene

   !> A channel of the last run.
   function values(name)
      character(*), intent(in) :: name
      real(wp), allocatable :: values(:)
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      call reader%open(trim(results), error)
      call check_no_error(error, name)
      allocate (values, source=channel(reader, name))
      call reader%close()
   end function values

end program test_stops
