!> One-sided stops, *STOP, by all integrators, against closed forms: a mass between two buffers, the loss of Hunt and Crossley, a
!> rope
!> that goes slack, a pendulum with limits of its angle.
!> Usage, in tests/: test_stops RESULT_FILE
program test_stops
   use limber_base_kinds, only: wp
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_text, channel
   use limber_base_error, only: error_type
   use testing, only: check_close, check_no_error, finish
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
   end do
   call finish()

contains

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
