!> The decks of mechanisms in input/ against closed forms of their geometry, free bodies, and equations of motion in minimal
!> coordinates that are integrated here. Usage, in tests/: test_mechanisms RESULT_FILE
program test_mechanisms
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_commands_run, only: run_deck
   use limber_output_history_reader, only: history_reader_type
   use runs, only: channel, run_text
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   real(wp), parameter :: pi = acos(-1.0_wp), gravity = 9.81_wp
   character(256) :: results
   type(history_reader_type) :: reader

   call get_command_argument(1, results)
   call check_pendulum()
   call check_double_pendulum()
   call check_four_bar()
   call check_quick_return()
   call check_cam()
   call check_gear_train()
   call check_belt_drive()
   call check_moving_mass()
   call check_flat()
   call check_near_dead_centre(1.0_wp)
   call check_near_dead_centre(-1.0_wp)
   call finish()

contains

   !> Runs a deck of input/ as it is.
   subroutine run(name)
      character(*), intent(in) :: name
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call run_deck('../input/'//name//'.inp', trim(results), .true., .true., report, error)
      call check_no_error(error, name)
      if (allocated(error)) error stop 1
      call reader%open(trim(results), error)
      call check_no_error(error, name//': results')
   end subroutine run

   !> A channel against values at all samples.
   subroutine compare(name, expected, tolerance, what)
      character(*), intent(in) :: name, what
      real(wp), intent(in) :: expected(:), tolerance
      real(wp) :: values(size(expected))
      values = channel(reader, name)
      print '(3a,es9.1)', what, repeat(' ', max(1, 60 - len(what))), 'off by', maxval(abs(values - expected))
      call check_close(maxval(abs(values - expected)), 0.0_wp, tolerance, what)
   end subroutine compare

   !> The energy less the work does not change.
   subroutine compare_energy(what, n, unit, tolerance)
      character(*), intent(in) :: what
      !> Number of samples
      integer, intent(in) :: n
      !> What it is compared with; how exactly
      real(wp), intent(in) :: unit, tolerance
      real(wp) :: energy(n)
      energy = channel(reader, 'energy')
      call compare('energy', spread(energy(1), 1, n), tolerance*unit, what//': energy less work')
   end subroutine compare_energy

   !> Elliptic functions, and the tension of the rod.
   subroutine check_pendulum()
      integer, parameter :: n = 201
      real(wp) :: x(n), y(n)
      call run('pendulum')
      x = channel(reader, 'x')
      y = channel(reader, 'y')
      call check_close(x(n), 0.27508746257611686_wp, 1.0e-9_wp, 'pendulum: x at the end')
      call check_close(y(n), -0.961419205099125_wp, 1.0e-9_wp, 'pendulum: y at the end')
      call compare('pull_x', 3*gravity*y*x, 1.0e-8_wp, 'pendulum: pull of the rod along x')
      call compare('pull_y', 3*gravity*y*y, 1.0e-8_wp, 'pendulum: pull of the rod along y')
      call reader%close()
   end subroutine check_pendulum

   !> Lagrange's equations in the two angles, by the classical method of Runge and Kutta; reactions from the accelerations.
   subroutine check_double_pendulum()
      integer, parameter :: n = 61, parts = 400
      real(wp), parameter :: m = 2.0_wp
      real(wp) :: state(4, n), upper(n), a(4, n), f(2, n)
      integer :: i, k
      call run('double_pendulum')
      state(:, 1) = [0.0_wp, 0.5_wp, 0.0_wp, 0.0_wp]
      do i = 2, n
         state(:, i) = state(:, i - 1)
         do k = 1, parts
            call advance(state(:, i), 3.0_wp/(n - 1)/parts)
         end do
      end do
      upper = channel(reader, 'upper')
      call compare('upper', state(1, :), 1.0e-7_wp, 'double pendulum: angle of the upper bar')
      call compare('bend', state(2, :) - state(1, :), 1.0e-7_wp, 'double pendulum: angle between the bars')
      call compare('bend_rate', state(4, :) - state(3, :), 1.0e-6_wp, 'double pendulum: its rate')
      a(1, :) = channel(reader, 'ax_upper')
      a(2, :) = channel(reader, 'ay_upper')
      a(3, :) = channel(reader, 'ax_lower')
      a(4, :) = channel(reader, 'ay_lower')
      call compare('pivot_x', m*(a(1, :) + a(3, :)), 1.0e-10_wp, 'double pendulum: force of the pivot along x')
      call compare('pivot_y', m*(a(2, :) + a(4, :) + 2*gravity), 1.0e-10_wp, 'double pendulum: force of the pivot along y')
      f(1, :) = m*a(3, :)
      f(2, :) = m*(a(4, :) + gravity)
      call compare('elbow_1', cos(upper)*f(1, :) + sin(upper)*f(2, :), 1.0e-10_wp, 'double pendulum: elbow along the upper bar')
      call compare('elbow_2', cos(upper)*f(2, :) - sin(upper)*f(1, :), 1.0e-10_wp, 'double pendulum: elbow across the upper bar')
      call compare_energy('double pendulum', n, 10.0_wp, 1.0e-9_wp)
      call reader%close()
   end subroutine check_double_pendulum

   !> A step of the double pendulum: both angles from the x axis, both spins.
   pure subroutine advance(state, h)
      real(wp), intent(inout) :: state(4)
      real(wp), intent(in) :: h
      real(wp) :: k(4, 4)
      k(:, 1) = slope(state)
      k(:, 2) = slope(state + h/2*k(:, 1))
      k(:, 3) = slope(state + h/2*k(:, 2))
      k(:, 4) = slope(state + h*k(:, 3))
      state = state + h/6*(k(:, 1) + 2*k(:, 2) + 2*k(:, 3) + k(:, 4))
   end subroutine advance

   !> 4/3 a'' + 1/2 cos(b-a) b'' = 1/2 sin(b-a) b'^2 - 3/2 g/l cos a, and
   !> 1/3 b'' + 1/2 cos(b-a) a'' = -1/2 sin(b-a) a'^2 - 1/2 g/l cos b.
   pure function slope(state) result(rate)
      real(wp), intent(in) :: state(4)
      real(wp), parameter :: length = 0.5_wp
      real(wp) :: rate(4), c, s, f(2), determinant
      c = 0.5_wp*cos(state(2) - state(1))
      s = 0.5_wp*sin(state(2) - state(1))
      f(1) = s*state(4)**2 - 1.5_wp*gravity/length*cos(state(1))
      f(2) = -s*state(3)**2 - 0.5_wp*gravity/length*cos(state(2))
      determinant = 4.0_wp/9 - c**2
      rate = [state(3), state(4), (f(1)/3 - c*f(2))/determinant, (4*f(2)/3 - c*f(1))/determinant]
   end function slope

   !> Circles about both shafts; the coupler without mass pulls along itself.
   subroutine check_four_bar()
      integer, parameter :: n = 201
      real(wp), parameter :: crank = 0.1_wp, coupler = 0.25_wp, rocker = 0.2_wp, base = 0.3_wp
      real(wp) :: theta(n), time(n), pin(2, n), gap(2, n), reach(n), along(n), across(n), tip(2, n), spin(n), torque(n)
      integer :: i
      call run('four_bar')
      time = [(real(i, wp)/(n - 1), i=0, n - 1)]
      theta = channel(reader, 'crank')
      call compare('crank', merge(20*(time - 0.1_wp), 4*ramp(5*time), time > 0.2_wp), 1.0e-13_wp*20, &
         & 'four-bar: integral of the cycloidal step')
      pin(1, :) = crank*cos(theta)
      pin(2, :) = crank*sin(theta)
      gap(1, :) = base - pin(1, :)
      gap(2, :) = -pin(2, :)
      reach = sqrt(gap(1, :)**2 + gap(2, :)**2)
      along = (coupler**2 - rocker**2 + reach**2)/(2*reach)
      across = sqrt(coupler**2 - along**2)
      tip(1, :) = pin(1, :) + (along*gap(1, :) - across*gap(2, :))/reach
      tip(2, :) = pin(2, :) + (along*gap(2, :) + across*gap(1, :))/reach
      call compare('rocker', atan2(tip(2, :), tip(1, :) - base), 1.0e-12_wp, 'four-bar: angle of the rocker')
      call compare('coupler', atan2(tip(2, :) - pin(2, :), tip(1, :) - pin(1, :)), 1.0e-12_wp, 'four-bar: angle of the coupler')
      call compare('pin_2', spread(0.0_wp, 1, n), 1.0e-10_wp, 'four-bar: no force across the coupler')
      call check(maxval(abs(channel(reader, 'pin_1'))) > 10.0_wp, 'four-bar: but along it')
      spin = channel(reader, 'crank_spin')
      torque = channel(reader, 'torque')
      call compare('power', torque*spin, 1.0e-11_wp*maxval(abs(torque*spin)), 'four-bar: power of the motor')
      call compare_energy('four-bar', n, 1.7_wp, 1.0e-9_wp)
      call reader%close()
   end subroutine check_four_bar

   !> Integral of x - sin(2 pi x)/(2 pi).
   elemental real(wp) function ramp(x)
      real(wp), intent(in) :: x
      ramp = x**2/2 - (1 - cos(2*pi*x))/(2*pi)**2
   end function ramp

   !> Geometry of the pin, the rocker and the link; the ram as a free body.
   subroutine check_quick_return()
      integer, parameter :: n = 201
      real(wp), parameter :: crank = 0.1_wp, distance = 0.25_wp, rocker = 0.5_wp, link = 0.15_wp, height = 0.48_wp
      real(wp) :: theta(n), psi(n), a(n), pin(n)
      call run('quick_return')
      theta = channel(reader, 'crank')
      psi = atan2(distance + crank*sin(theta), crank*cos(theta))
      call compare('rocker', psi, 1.0e-12_wp, 'quick return: angle of the rocker')
      call compare('along_slot', sqrt(crank**2 + distance**2 + 2*crank*distance*sin(theta)), 1.0e-13_wp, &
         & 'quick return: place of the pin in the slot')
      call compare('ram', rocker*cos(psi) - sqrt(link**2 - (height - rocker*sin(psi))**2), 1.0e-12_wp, &
         & 'quick return: place of the ram')
      a = channel(reader, 'ram_ax')
      call compare('pin_x', -10*a, 1.0e-8_wp, 'quick return: the pin pushes the ram')
      pin = channel(reader, 'pin_y')
      call compare('guide_y', pin + 10*gravity, 1.0e-8_wp, 'quick return: the guide carries the ram')
      call compare('guide_moment', spread(0.0_wp, 1, n), 1.0e-8_wp, 'quick return: without a moment')
      call compare('slot_along', spread(0.0_wp, 1, n), 1.0e-10_wp, 'quick return: no force along the slot')
      call check(maxval(abs(channel(reader, 'slot_across'))) > 10.0_wp, 'quick return: but across it')
      call compare_energy('quick return', n, 27.0_wp, 1.0e-9_wp)
      call reader%close()
   end subroutine check_quick_return

   !> The lift that the profile was made from; the follower as a free body; power.
   subroutine check_cam()
      integer, parameter :: n = 111
      real(wp), parameter :: speed = 10.0_wp, mass = 0.2_wp
      real(wp) :: theta(n), lift(0:2, n), push(n)
      integer :: i
      call run('cam')
      theta = [(2*pi*i/(n - 1), i=0, n - 1)]
      do i = 1, n
         lift(:, i) = profile(theta(i))
      end do
      call compare('lift', lift(0, :), 2.0e-9_wp, 'cam: lift')
      call compare('speed', speed*lift(1, :), 1.0e-6_wp*0.1_wp, 'cam: speed of the follower')
      call compare('acceleration', speed**2*lift(2, :), 2.0e-3_wp, 'cam: its acceleration')
      push = mass*(gravity + channel(reader, 'acceleration'))
      call compare('push', push, 1.0e-10_wp, 'cam: force on the follower')
      call compare('torque', push*lift(1, :), 1.0e-6_wp, 'cam: torque on the shaft')
      call compare_energy('cam', n, 0.05_wp, 1.0e-7_wp)
      call reader%close()
   end subroutine check_cam

   !> Radius of the profile that meets the follower at an angle of the cam, with two derivatives: rise, dwell, return, dwell.
   pure function profile(theta) result(r)
      real(wp), intent(in) :: theta
      real(wp), parameter :: rise = 2*pi/3, base = 0.03_wp, stroke = 0.01_wp
      real(wp) :: r(0:2), x, along
      along = modulo(theta, 2*pi)
      r = [base, 0.0_wp, 0.0_wp]
      if (along < rise) then
         x = along/rise
         r = r + stroke*[x - sin(2*pi*x)/(2*pi), (1 - cos(2*pi*x))/rise, 2*pi*sin(2*pi*x)/rise**2]
      else if (along < rise + pi/3) then
         r(0) = base + stroke
      else if (along < 2*rise + pi/3) then
         x = (along - rise - pi/3)/rise
         r(0) = base + stroke
         r = r - stroke*[x - sin(2*pi*x)/(2*pi), (1 - cos(2*pi*x))/rise, 2*pi*sin(2*pi*x)/rise**2]
      end if
   end function profile

   !> Willis' ratio, and the sun as a free body.
   subroutine check_gear_train()
      integer, parameter :: n = 41
      real(wp), parameter :: ratio = 0.3_wp, planet_ratio = -2.5_wp
      real(wp) :: t(n), sun(n), motor(n), teeth(n)
      real(wp) :: inertia
      integer :: i
      call run('gear_train')
      t = [(2.0_wp*i/(n - 1), i=0, n - 1)]
      sun = 5*t + 5*t**3
      call compare('sun', sun, 1.0e-12_wp, 'gears: integral of the acceleration')
      call compare('arm', ratio*sun, 1.0e-11_wp, 'gears: ratio of arm and sun')
      call compare('planet', planet_ratio*ratio*sun, 1.0e-11_wp, 'gears: ratio of planet and sun')
      inertia = 5.0e-4_wp + ratio**2*(4.0e-4_wp + 0.4_wp*0.05_wp**2 + planet_ratio**2*8.0e-5_wp)
      motor = inertia*30*t + ratio*4
      call compare('motor', motor, 1.0e-10_wp, 'gears: torque of the motor')
      call compare('power', motor*(5 + 15*t**2), 1.0e-8_wp, 'gears: its power')
      teeth = 5.0e-4_wp*30*t - motor
      call compare('tooth_moment', teeth, 1.0e-10_wp, 'gears: moment of the teeth on the sun')
      ! the teeth push across the line of centres, with the radius of the sun as lever
      call compare('tooth_x', -teeth/0.03_wp*sin(ratio*sun), 1.0e-8_wp, 'gears: force of the teeth along x')
      call compare('tooth_y', teeth/0.03_wp*cos(ratio*sun), 1.0e-8_wp, 'gears: force of the teeth along y')
      call compare_energy('gears', n, 10.0_wp, 1.0e-9_wp)
      call reader%close()
   end subroutine check_gear_train

   !> Inertia seen from the first wheel; each belt's moment.
   subroutine check_belt_drive()
      integer, parameter :: n = 31
      real(wp), parameter :: torque = 0.05_wp, inertia(3) = [2.0e-3_wp, 0.06_wp, 0.01_wp]
      real(wp) :: t(n), angle(n), push
      integer :: i
      call run('belt_drive')
      t = [(3.0_wp*i/(n - 1), i=0, n - 1)]
      push = torque/(inertia(1) + (inertia(2) + inertia(3))/9)
      angle = push*t**2/2
      call compare('first', angle, 1.0e-8_wp, 'belts: angle of the first wheel')
      call compare('second', angle/3, 1.0e-8_wp, 'belts: of the second')
      call compare('third', -angle/3, 1.0e-8_wp, 'belts: of the third')
      call compare('belt_moment', spread(inertia(1)*push - torque, 1, n), 1.0e-12_wp, 'belts: moment on the first wheel')
      call compare('crossed_moment', spread(-inertia(3)*push/3, 1, n), 1.0e-12_wp, 'belts: crossed one, on the second')
      call compare_energy('belts', n, 1.0_wp, 1.0e-9_wp)
      call reader%close()
   end subroutine check_belt_drive

   !> The same sum of sines, with the mass in its place: q_n'' + w_n^2 q_n = -m phi_n (g + w''), by Runge and Kutta.
   subroutine check_moving_mass()
      integer, parameter :: n = 51, modes = 4, parts = 400
      real(wp), parameter :: length = 10.0_wp, mass = 40.0_wp, speed = 12.0_wp
      real(wp) :: state(2*modes), middle(n), wagon(n), contact(n), h
      integer :: i, k
      call run('moving_mass_on_beam')
      state = 0.0_wp
      h = length/speed/(n - 1)/parts
      middle(1) = 0.0_wp
      wagon(1) = 0.0_wp
      contact(1) = mass*gravity
      do i = 2, n
         do k = 1, parts
            call cross_over(state, ((i - 2)*parts + k - 1)*h, h)
         end do
         middle(i) = sum(sines(0.5_wp*length, 0)*state(:modes))
         wagon(i) = sum(sines((i - 1)*parts*h*speed, 0)*state(:modes))
         contact(i) = mass*(gravity + lift(state, (i - 1)*parts*h))
      end do
      print '(a,f9.5)', 'moving mass: deflection of the middle, largest', maxval(abs(middle))
      call compare('middle', middle, 2.0e-4_wp*maxval(abs(middle)), 'moving mass: deflection of the middle')
      call compare('wagon', wagon, 3.0e-4_wp*maxval(abs(middle)), 'moving mass: path of the mass')
      call compare('contact', contact, 5.0e-3_wp*mass*gravity, 'moving mass: force on the mass')
      call compare_energy('moving mass', n, 2900.0_wp, 1.0e-9_wp)
      call reader%close()
   end subroutine check_moving_mass

   !> Modes of a simply supported beam, mass-normalised, or a derivative of them.
   pure function sines(x, order) result(phi)
      real(wp), intent(in) :: x
      integer, intent(in) :: order
      real(wp), parameter :: length = 10.0_wp, mass = 7850*0.05_wp**2
      real(wp) :: phi(4), k
      integer :: i
      do i = 1, 4
         k = i*pi/length
         select case (order)
         case (0); phi(i) = sin(k*x)
         case (1); phi(i) = k*cos(k*x)
         case default; phi(i) = -k**2*sin(k*x)
         end select
      end do
      phi = phi*sqrt(2/(mass*length))
   end function sines

   pure subroutine cross_over(state, t, h)
      real(wp), intent(inout) :: state(8)
      real(wp), intent(in) :: t, h
      real(wp) :: k(8, 4)
      k(:, 1) = sway(state, t)
      k(:, 2) = sway(state + h/2*k(:, 1), t + h/2)
      k(:, 3) = sway(state + h/2*k(:, 2), t + h/2)
      k(:, 4) = sway(state + h*k(:, 3), t + h)
      state = state + h/6*(k(:, 1) + 2*k(:, 2) + 2*k(:, 3) + k(:, 4))
   end subroutine cross_over

   pure function sway(state, t) result(rate)
      real(wp), intent(in) :: state(8), t
      real(wp), parameter :: mass = 40.0_wp, speed = 12.0_wp
      real(wp) :: rate(8)
      rate(:4) = state(5:)
      rate(5:) = -squares()*state(:4) - mass*sines(speed*t, 0)*(gravity + lift(state, t))
   end function sway

   !> Vertical acceleration of the mass.
   pure real(wp) function lift(state, t)
      real(wp), intent(in) :: state(8), t
      real(wp), parameter :: mass = 40.0_wp, speed = 12.0_wp
      real(wp) :: phi(4), rest
      phi = sines(speed*t, 0)
      rest = sum(phi*(-squares()*state(:4))) + 2*speed*sum(sines(speed*t, 1)*state(5:)) &
         & + speed**2*sum(sines(speed*t, 2)*state(:4))
      lift = (rest - mass*gravity*sum(phi**2))/(1 + mass*sum(phi**2))
   end function lift

   !> Squared frequencies.
   pure function squares() result(omega2)
      real(wp), parameter :: length = 10.0_wp, stiffness = 2.1e11_wp*0.05_wp**4/12, mass = 7850*0.05_wp**2
      real(wp) :: omega2(4)
      integer :: i
      omega2 = [((i*pi/length)**4*stiffness/mass, i=1, 4)]
   end function squares

   !> A parallelogram whose crank is driven round: samples fall on the positions in which it lies flat, where its joints have no
   !> grip on the rocker. The driver bears the weights of the three bodies, of mass 1 and cranks of 0.5: 4.905 cos(angle).
   subroutine check_flat()
      character(*), parameter :: nl = new_line('a')
      integer, parameter :: n = 100
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp) :: angle(0:n)
      integer :: i
      angle = [(0.5_wp*pi + 2*pi*i/n, i=0, n)]
      call run_text('*GROUND'//nl//' d, 1, 0'//nl// &
         & '*RIGID BODY, NAME=crank, MASS=1, INERTIA=0.1'//nl//' e, 0.5, 0'//nl// &
         & '*RIGID BODY, NAME=coupler, MASS=1, INERTIA=0.1, X=0, Y=0.5'//nl//' e, 1, 0'//nl// &
         & '*RIGID BODY, NAME=rocker, MASS=1, INERTIA=0.1, X=1, ANGLE=90 deg'//nl//' e, 0.5, 0'//nl// &
         & '*JOINT, NAME=a, TYPE=REVOLUTE'//nl//' crank, ground.origin'//nl//'*JOINT, NAME=b, TYPE=REVOLUTE'//nl// &
         & ' coupler, crank.e'//nl//'*JOINT, NAME=x, TYPE=REVOLUTE'//nl//' coupler.e, rocker.e'//nl// &
         & '*JOINT, NAME=y, TYPE=REVOLUTE'//nl//' rocker, ground.d'//nl//'*DRIVER, NAME=motor, TYPE=ANGLE, BODY=crank'//nl// &
         & ' pi/2 + pi*t'//nl//'*GRAVITY'//nl//'*DYNAMICS, END=2, OUTPUTS=100, INTEGRATOR=RADAU'//nl//'*OUTPUT'//nl// &
         & ' rocker = angle(rocker), torque = torque(motor)'//nl, trim(results), report, error)
      call check_no_error(error, 'flat parallelogram')
      if (allocated(error)) return
      call check(index(report, 'at t = 0.5 ') > 0 .and. index(report, 'lose their grip') > 0, &
         & 'flat parallelogram, samples without grip are told: '//report)
      call reader%open(trim(results), error)
      call compare('rocker', angle, 1.0e-5_wp, 'flat parallelogram: angle of the rocker')
      call compare('torque', 0.5_wp*gravity*cos(angle), 2.0e-2_wp, 'flat parallelogram: torque')
      call reader%close()
   end subroutine check_flat

   !> A crank that turns past a dead centre of its four-bar, which it misses by a thousandth: the joints could be closed on the
   !> other side of the line from the crank's pin to the rocker's pivot as well. The rocker's angle is that of this line and the
   !> cosine rule.
   subroutine check_near_dead_centre(side)
      !> Sign of the side on which it starts
      real(wp), intent(in) :: side
      character(*), parameter :: nl = new_line('a')
      character(4), parameter :: tolerances(2) = ['1e-5', '1e-6']
      real(wp), parameter :: crank = 0.25_wp, coupler = 1.12_wp, rocker = 0.501_wp, base = 0.87_wp
      integer, parameter :: n = 12
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp) :: angle(0:n), pin(2), tip(2), length
      integer :: i
      do i = 0, n
         pin = crank*[cos(1.5_wp - 3.0_wp*i/n), sin(1.5_wp - 3.0_wp*i/n)] - [base, 0.0_wp]
         length = norm2(pin)
         angle(i) = atan2(pin(2), pin(1)) + side*acos((rocker**2 + length**2 - coupler**2)/(2*rocker*length))
      end do
      do i = 1, n
         angle(i) = angle(i) - 2*pi*nint((angle(i) - angle(i - 1))/(2*pi))
      end do
      pin = crank*[cos(1.5_wp), sin(1.5_wp)]
      tip = [base, 0.0_wp] + rocker*[cos(angle(0)), sin(angle(0))]
      do i = 1, size(tolerances)
         call run_text('*GROUND'//nl//' d, 0.87, 0'//nl//'*RIGID BODY, NAME=crank, MASS=1, INERTIA=0.1, ANGLE=1.5'//nl// &
            & ' e, 0.25, 0'//nl//'*RIGID BODY, NAME=coupler, MASS=1, INERTIA=0.1, X='//as_text(pin(1), 16)//', Y='// &
            & as_text(pin(2), 16)//', ANGLE='//as_text(atan2(tip(2) - pin(2), tip(1) - pin(1)), 16)//nl//' e, 1.12, 0'//nl// &
            & '*RIGID BODY, NAME=rocker, MASS=1, INERTIA=0.1, X=0.87, ANGLE='//as_text(angle(0), 16)//nl//' e, 0.501, 0'//nl// &
            & '*JOINT, NAME=a, TYPE=REVOLUTE'//nl//' crank, ground.origin'//nl//'*JOINT, NAME=b, TYPE=REVOLUTE'//nl// &
            & ' coupler, crank.e'//nl//'*JOINT, NAME=x, TYPE=REVOLUTE'//nl//' coupler.e, rocker.e'//nl// &
            & '*JOINT, NAME=y, TYPE=REVOLUTE'//nl//' rocker, ground.d'//nl//'*DRIVER, NAME=motor, TYPE=ANGLE, BODY=crank'//nl// &
            & ' 1.5 - 10*t'//nl//'*GRAVITY'//nl//'*DYNAMICS, END=0.3, OUTPUTS=12, INTEGRATOR=CONSERVING, TOLERANCE='// &
            & tolerances(i)//nl//'*OUTPUT'//nl//' rocker = angle(rocker)'//nl, trim(results), report, error)
         call check_no_error(error, 'near a dead centre')
         if (allocated(error)) return
         call reader%open(trim(results), error)
         call compare('rocker', angle, 1.0e-9_wp, 'past a dead centre at '//tolerances(i)//': angle of the rocker')
         call reader%close()
      end do
   end subroutine check_near_dead_centre

end program test_mechanisms
