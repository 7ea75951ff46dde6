!> Controls by all integrators, against closed forms and independent solutions: integrator, lags, transfer function, state space,
!> PID with limits, saturation, dead zone, hysteresis, limited rate, hold; a filter that drives a mass, a pendulum under a PID, a
!> rotor under a sampled PID with and without delay; what samples cost; events, further analyses; what is refused.
!> Usage, in tests/: test_controls RESULT_FILE
program test_controls
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_text, channel, check_warning, read_columns
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   character(*), parameter :: nl = new_line('a')
   character(*), parameter :: integrators(4) = [character(10) :: 'ADAMS', 'RADAU', 'ALPHA', 'CONSERVING']
   !> A mass that takes no part
   character(*), parameter :: aside = '*POINT MASS, NAME=p, MASS=1'//nl
   !> Inertia and friction of the rotor, time between its samples, gains
   real(wp), parameter :: j = 0.02_wp, c = 0.05_wp, period = 0.01_wp, kp = 2.0_wp, ki = 3.0_wp, kd = 0.12_wp
   character(*), parameter :: rotor = '*RIGID BODY, NAME=rotor, MASS=1, INERTIA=0.02'//nl//'*JOINT, NAME=pin, TYPE=REVOLUTE'//nl// &
      & ' rotor.origin, ground.origin'//nl//'*FRICTION, NAME=loss, JOINT=pin, COEFFICIENT=0.05'//nl// &
      & '*TORQUE, NAME=motor, BODY=rotor'//nl//' output(pid)'//nl
   character(256) :: results
   character(4) :: tolerance
   integer :: i, k

   call get_command_argument(1, results)
   do i = 1, size(integrators)
      do k = 1, 2
         tolerance = merge('1e-6', '1e-9', k == 1)
         call check_lags(trim(integrators(i)))
         call check_spaces(trim(integrators(i)))
         call check_limits(trim(integrators(i)))
         call check_filter(trim(integrators(i)))
         call check_pendulum(trim(integrators(i)))
         call check_rotor(trim(integrators(i)))
         call check_hold(trim(integrators(i)))
         call check_hysteresis(trim(integrators(i)))
      end do
   end do
   tolerance = '1e-6'
   call check_cost()
   call check_events()
   call check_analyses()
   call check_weight()
   call check_estimate()
   call check_refusals()
   call finish()

contains

   !> Error of values of about 1 that an integrator is allowed.
   real(wp) function bound(integrator)
      character(*), intent(in) :: integrator
      real(wp) :: value
      read (tolerance, *) value
      bound = 20*value
      if (integrator == 'ALPHA' .or. integrator == 'CONSERVING') bound = 2.0e-4_wp*(value/1.0e-6_wp)**(2.0_wp/3.0_wp)
   end function bound

   !> Compares a channel with values at its samples.
   subroutine compare(reader, name, expected, allowed, what)
      type(history_reader_type), intent(in) :: reader
      character(*), intent(in) :: name, what
      real(wp), intent(in) :: expected(:), allowed
      real(wp) :: values(size(expected))
      values = channel(reader, name)
      call check_close(maxval(abs(values - expected)), 0.0_wp, allowed, what//', '//tolerance//': '//name)
   end subroutine compare

   !> Integrator, lags of first and second order, one behind the other, from first values.
   subroutine check_lags(integrator)
      character(*), intent(in) :: integrator
      real(wp), parameter :: omega = 20.0_wp, zeta = 0.3_wp, damped = omega*sqrt(1 - zeta**2)
      type(history_reader_type) :: reader
      real(wp) :: t(51)
      integer :: n
      call run_scene(aside//'*CONTROL, NAME=area, TYPE=INTEGRATOR, GAIN=2, INITIAL=0.5'//nl//' cos(3*t)'//nl// &
         & '*CONTROL, NAME=lag, TYPE=LAG, GAIN=3, TIME CONSTANT=0.2, INITIAL=1'//nl//' 1'//nl// &
         & '*CONTROL, NAME=second, TYPE=SECOND ORDER, FREQUENCY=20, DAMPING=0.3'//nl//' 1'//nl// &
         & '*CONTROL, NAME=chain, TYPE=LAG, TIME CONSTANT=0.5'//nl//' output(lag)'//nl, integrator, 'END=1, OUTPUTS=50', &
         & ' output(area), output(lag), output(second), state(second.x2), output(chain), twice = 2*output(lag) + t', reader)
      t = [(0.02_wp*n, n=0, 50)]
      call compare(reader, 'output_area', 0.5_wp + 2*sin(3*t)/3, bound(integrator), integrator)
      call compare(reader, 'output_lag', 3 - 2*exp(-5*t), 3*bound(integrator), integrator)
      call compare(reader, 'output_second', 1 - exp(-zeta*omega*t)*(cos(damped*t) + zeta*omega/damped*sin(damped*t)), &
         & bound(integrator), integrator)
      call compare(reader, 'state_second_x2', exp(-zeta*omega*t)*omega**2/damped*sin(damped*t), 40*bound(integrator), integrator)
      ! 3 (1 - e^-2t) and the lag of -2 e^-5t
      call compare(reader, 'output_chain', 3*(1 - exp(-2*t)) - 2*2*(exp(-5*t) - exp(-2*t))/(2 - 5), bound(integrator), integrator)
      call compare(reader, 'twice', 6 - 4*exp(-5*t) + t, 6*bound(integrator), integrator)
      call check_warning(reader, '', integrator//': lags')
      call reader%close()
   end subroutine check_lags

   !> A transfer function that follows its input at once, and a state space of two states and two inputs.
   subroutine check_spaces(integrator)
      character(*), intent(in) :: integrator
      type(history_reader_type) :: reader
      real(wp) :: t(51)
      integer :: n
      call run_scene(aside//'*CONTROL, NAME=tf, TYPE=TRANSFER FUNCTION'//nl//' 1'//nl//' 4, 6, 2'//nl//' 2, 10, 12'//nl// &
         & '*CONTROL, NAME=ss, TYPE=STATE SPACE'//nl//' t, 1'//nl//' 0, 1, 0, 0'//nl//' 0, 0, 1, -1'//nl//' 1, 0, 0, 0.5'//nl, &
         & integrator, 'END=2, OUTPUTS=50', ' output(tf), output(ss), state(ss.x2)', reader)
      t = [(0.04_wp*n, n=0, 50)]
      call compare(reader, 'output_tf', 1/6.0_wp - 1.5_wp*exp(-2*t) + 10*exp(-3*t)/3, 4*bound(integrator), integrator)
      call compare(reader, 'output_ss', t**3/6 - t**2/2 + 0.5_wp, bound(integrator), integrator)
      call compare(reader, 'state_ss_x2', t**2/2 - t, bound(integrator), integrator)
      call reader%close()
   end subroutine check_spaces

   !> A PI whose integral goes back where its output is at a limit, from rest and from beyond the limit; saturation and dead zone;
   !> a limited rate.
   subroutine check_limits(integrator)
      character(*), intent(in) :: integrator
      type(history_reader_type) :: reader
      real(wp) :: t(41), wave(41)
      integer :: n
      call run_scene(aside//'*CONTROL, NAME=pi, TYPE=PID, KP=1, KI=2, MOST=1.5'//nl//' 1'//nl// &
         & '*CONTROL, NAME=flat, TYPE=SATURATION, GAIN=3, LEAST=-1, MOST=2'//nl//' sin(2*t)'//nl// &
         & '*CONTROL, NAME=dead, TYPE=DEAD ZONE, GAIN=2, LEAST=-0.5, MOST=0.25'//nl//' sin(2*t)'//nl// &
         & '*CONTROL, NAME=slow, TYPE=RATE LIMIT, TIME CONSTANT=0.1, LEAST=-1, MOST=2'//nl//' 1'//nl// &
         & '*CONTROL, NAME=twice, TYPE=SATURATION, MOST=0.5'//nl//' output(dead) + output(slow)'//nl, &
         & integrator, 'END=4, OUTPUTS=40', &
         & ' output(pi), state(pi.x1), output(flat), output(dead), output(slow), output(twice)', reader)
      t = [(0.1_wp*n, n=0, 40)]
      wave = sin(2*t)
      ! At the limit from t = 1/4: x1' = 2 + (1.5 - 1 - x1)/0.5
      call compare(reader, 'state_pi_x1', merge(2*t, 1.5_wp - exp(-2*(t - 0.25_wp)), t < 0.25_wp), 2*bound(integrator), integrator)
      call compare(reader, 'output_pi', min(1 + 2*t, 1.5_wp), 2*bound(integrator), integrator)
      call compare(reader, 'output_flat', min(max(3*wave, -1.0_wp), 2.0_wp), 1.0e-14_wp, integrator)
      call compare(reader, 'output_dead', 2*(max(wave - 0.25_wp, 0.0_wp) + min(wave + 0.5_wp, 0.0_wp)), 1.0e-14_wp, integrator)
      call compare(reader, 'output_slow', merge(2*t, 1 - 0.2_wp*exp(-10*(t - 0.4_wp)), t < 0.4_wp), 2*bound(integrator), integrator)
      call compare(reader, 'output_twice', min(0.5_wp, channel(reader, 'output_dead') + channel(reader, 'output_slow')), &
         & 1.0e-14_wp, integrator)
      call reader%close()
   end subroutine check_limits

   !> The output of a lag of second order is the force on a damped mass; the balance of energy is that of the force.
   subroutine check_filter(integrator)
      character(*), intent(in) :: integrator
      type(history_reader_type) :: reader
      real(wp) :: table(4, 51), allowed
      real(wp), allocatable :: energy(:)
      call read_columns('reference/control_filter.csv', table)
      call run_scene('*POINT MASS, NAME=m, MASS=2'//nl//'*CONTROL, NAME=filter, TYPE=TRANSFER FUNCTION'//nl//' 1'//nl// &
         & ' 400'//nl//' 1, 12, 400'//nl//'*FORCE, NAME=push, POINT=m'//nl//' output(filter) - 4*vx(m), 0'//nl, integrator, &
         & 'END=2, OUTPUTS=50', &
         & ' x(m), vx(m), output(filter), w = work(system), e = kinetic_energy(system), momentum_x(system)', reader)
      ! The values have nine digits
      allowed = bound(integrator) + 1.0e-8_wp
      call compare(reader, 'output_filter', table(2, :), allowed, integrator)
      call compare(reader, 'x_m', table(3, :), allowed, integrator)
      call compare(reader, 'vx_m', table(4, :), allowed, integrator)
      call compare(reader, 'momentum_x_system', 2*channel(reader, 'vx_m'), 1.0e-14_wp, integrator)
      energy = channel(reader, 'e') - channel(reader, 'w')
      call check_close(maxval(abs(energy)), 0.0_wp, bound(integrator), integrator//', '//tolerance//': balance of the filter')
      call check_close(maxval(abs(channel(reader, 'e') - channel(reader, 'vx_m')**2)), 0.0_wp, 1.0e-14_wp, &
         & integrator//': energy of the mass alone')
      call reader%close()
   end subroutine check_filter

   !> A rod under gravity and a PID with a lag of its derivative, from rest.
   subroutine check_pendulum(integrator)
      character(*), intent(in) :: integrator
      type(history_reader_type) :: reader
      real(wp) :: table(4, 76), allowed
      call read_columns('reference/control_pendulum.csv', table)
      call run_scene('*GRAVITY'//nl//'*RIGID BODY, NAME=rod, MASS=1, INERTIA=0.6**2/12, CENTRE X=0.3, ANGLE=-pi/2'//nl// &
         & '*JOINT, NAME=pin, TYPE=REVOLUTE'//nl//' rod.origin, ground.origin'//nl// &
         & '*FRICTION, NAME=loss, JOINT=pin, COEFFICIENT=0.02'//nl// &
         & '*CONTROL, NAME=pid, TYPE=PID, KP=12, KI=15, KD=2, FILTER=0.02'//nl//' 0.5 - angle(rod)'//nl// &
         & '*TORQUE, NAME=motor, BODY=rod'//nl//' output(pid)'//nl, integrator, 'END=3, OUTPUTS=75', &
         & ' angle(rod), spin(rod), output(pid)', reader)
      allowed = 3*bound(integrator) + 1.0e-8_wp
      call compare(reader, 'angle_rod', table(2, :), allowed, integrator)
      call compare(reader, 'spin_rod', table(3, :), 10*allowed, integrator)
      call compare(reader, 'output_pid', table(4, :), 100*allowed, integrator)
      call reader%close()
   end subroutine check_pendulum

   !> A rotor under a sampled PID: without delay, with a part of a sample, with a whole one; with limits. Against its exact motion,
   !> and that against an independent solution.
   subroutine check_rotor(integrator)
      character(*), intent(in) :: integrator
      real(wp), parameter :: delays(4) = [0.0_wp, 0.004_wp, 0.01_wp, 0.0_wp]
      character(*), parameter :: options(4) = [character(32) :: '', ', DELAY=0.004', ', DELAY=0.01', ', LEAST=-0.3, MOST=0.8']
      type(history_reader_type) :: reader
      real(wp) :: angle(0:100), spin(0:100), u(0:100), table(4, 51), allowed
      integer :: n, m
      do n = 1, size(delays)
         call find_rotor(delays(n), merge(0.8_wp, huge(1.0_wp), n == 4), merge(-0.3_wp, -huge(1.0_wp), n == 4), angle, spin, u)
         if (delays(n) > 0.004_wp .or. n == 1) then
            call read_columns('reference/control_pid_'//trim(merge('sampled', 'delayed', n == 1))//'.csv', table)
            call check_close(maxval(abs(table(2, :) - [(angle(m), m=0, 100, 2)])), 0.0_wp, 1.0e-8_wp, 'exact angle')
            call check_close(maxval(abs(table(4, :) - [(u(m), m=0, 100, 2)])), 0.0_wp, 1.0e-8_wp, 'exact output')
         end if
         call run_scene('*CONTROL, NAME=pid, TYPE=PID, KP=2, KI=3, KD=0.12, PERIOD=0.01'//trim(options(n))//nl// &
            & ' 1 - angle(rotor)'//nl//rotor, integrator, 'END=1, OUTPUTS=100', ' angle(rotor), spin(rotor), state(pid.x2)', reader)
         allowed = 2*bound(integrator)
         ! Between samples the torque is constant, and the motion soon is what the stages take it for
         if (integrator == 'RADAU') allowed = 1.0e-9_wp
         call compare(reader, 'angle_rotor', angle, allowed, integrator//trim(options(n)))
         call compare(reader, 'spin_rotor', spin, 20*allowed, integrator//trim(options(n)))
         call compare(reader, 'state_pid_x2', u, 5*allowed, integrator//trim(options(n)))
         call reader%close()
      end do
   end subroutine check_rotor

   !> The rotor exactly, at its samples: angle, spin, and the output that follows from each.
   subroutine find_rotor(delay, most, least, angle, spin, u)
      real(wp), intent(in) :: delay, most, least
      real(wp), intent(out) :: angle(0:), spin(0:), u(0:)
      real(wp) :: e, last, sum, now, wanted, place, speed
      integer :: n
      place = 0.0_wp
      speed = 0.0_wp
      sum = 0.0_wp
      last = 1.0_wp
      now = 0.0_wp
      do n = 0, ubound(angle, 1)
         angle(n) = place
         spin(n) = speed
         e = 1 - place
         wanted = kp*e + sum + ki*period*e + kd*(e - last)/period
         if (.not. ((wanted > most .and. e > 0.0_wp) .or. (wanted < least .and. e < 0.0_wp))) sum = sum + ki*period*e
         u(n) = min(max(kp*e + sum + kd*(e - last)/period, least), most)
         last = e
         call go_on(delay, now, place, speed)
         now = u(n)
         call go_on(period - delay, now, place, speed)
      end do
   end subroutine find_rotor

   !> The rotor under a constant torque.
   subroutine go_on(h, torque, place, speed)
      real(wp), intent(in) :: h, torque
      real(wp), intent(inout) :: place, speed
      real(wp) :: left
      left = exp(-c*h/j)
      place = place + torque/c*h + (speed - torque/c)*j/c*(1 - left)
      speed = torque/c + (speed - torque/c)*left
   end subroutine go_on

   !> Samples of a wave, held, before and behind the first one, with limits and a delay; the integral of what is held.
   subroutine check_hold(integrator)
      character(*), intent(in) :: integrator
      type(history_reader_type) :: reader
      real(wp) :: held(40), late(40), sum(40), at
      integer :: n, m
      call run_scene(aside//'*CONTROL, NAME=hold, TYPE=HOLD, PERIOD=0.25, GAIN=2, MOST=1.5, INITIAL=-3'//nl//' sin(t)'//nl// &
         & '*CONTROL, NAME=late, TYPE=HOLD, PERIOD=0.25, DELAY=0.125, INITIAL=-3'//nl//' sin(t)'//nl// &
         & '*CONTROL, NAME=sum, TYPE=INTEGRATOR'//nl//' output(hold)'//nl, integrator, 'START=0.05, END=2, OUTPUTS=39', &
         & ' output(hold), output(late), output(sum)', reader)
      do n = 1, 40
         at = 0.05_wp*n
         m = (n + 1)/5
         held(n) = min(2*sin(0.25_wp*(n/5)), 1.5_wp)
         if (n < 5) held(n) = -3
         late(n) = sin(0.25_wp*int((at - 0.125_wp)/0.25_wp + 1.0e-9_wp))
         if (at < 0.374_wp) late(n) = -3
         sum(n) = -3*(min(at, 0.25_wp) - 0.05_wp)
         do m = 1, n/5
            sum(n) = sum(n) + min(2*sin(0.25_wp*m), 1.5_wp)*(min(at, 0.25_wp*(m + 1)) - 0.25_wp*m)
         end do
      end do
      call compare(reader, 'output_hold', held, 1.0e-12_wp, integrator)
      call compare(reader, 'output_late', late, 1.0e-12_wp, integrator)
      call compare(reader, 'output_sum', sum, bound(integrator), integrator)
      call reader%close()
   end subroutine check_hold

   !> A heater that turns on and off by what a lag of its output is, against the times in closed form; one that starts between its
   !> limits, and one that starts beyond.
   subroutine check_hysteresis(integrator)
      character(*), intent(in) :: integrator
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: t(:)
      real(wp) :: at
      integer :: n
      call run_scene(aside//'*CONTROL, NAME=room, TYPE=LAG, TIME CONSTANT=2'//nl//' 3*output(heater)'//nl// &
         & '*CONTROL, NAME=heater, TYPE=HYSTERESIS, LEAST=-1.2, MOST=-0.8'//nl//' -output(room)'//nl// &
         & '*CONTROL, NAME=between, TYPE=HYSTERESIS, LEAST=-1, MOST=9, GAIN=4, INITIAL=4'//nl//' t'//nl// &
         & '*CONTROL, NAME=beyond, TYPE=HYSTERESIS, LEAST=-1, MOST=2, GAIN=-4'//nl//' 3 - 2*t'//nl, integrator, &
         & 'END=8, OUTPUTS=40', ' output(room), output(heater), output(between), output(beyond)', reader)
      call reader%read_numbers('/events/time', t, error)
      call check_no_error(error, integrator//': turns')
      call check(size(t) == 13, integrator//': number of turns')
      ! Off at 1.2 from 0, and then from 0.8; on at 0.8; in between 'beyond' turns off at t = 2
      t = pack(t, abs(t - 2) > 1.0e-2_wp)
      call check(size(t) == 12, integrator//': number of turns of the heater')
      at = 2*log(3/1.8_wp)
      do n = 1, size(t)
         call check_close(t(n), at, 5*bound(integrator), integrator//', '//tolerance//': time of a turn')
         at = at + 2*log(merge(1.2_wp/0.8_wp, 2.2_wp/1.8_wp, modulo(n, 2) == 1))
      end do
      call check(.not. any(abs(channel(reader, 'output_between') - 4) > 1.0e-12_wp), integrator//': starts between')
      t = channel(reader, 'output_beyond')
      call check(.not. any(abs(t(:9) + 4) > 1.0e-12_wp) .and. .not. any(abs(t(12:)) > 1.0e-12_wp), integrator//': starts beyond')
      call reader%close()
   end subroutine check_hysteresis

   !> A PID that is sampled at 1 kHz for 10 s costs at most 3 evaluations a sample more than a continuous one.
   subroutine check_cost()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp) :: count(2)
      integer :: n
      do n = 1, 2
         call run_scene('*CONTROL, NAME=pid, TYPE=PID, KP=2, KI=3, KD=0.12, '//trim(merge('FILTER=0.01 ', 'PERIOD=0.001', n == 1)) &
            & //nl//' 1 - angle(rotor)'//nl//rotor, 'ADAMS', 'END=10, OUTPUTS=100', ' angle(rotor)', reader)
         call reader%read_statistic('right_hand_sides', count(n), error)
         call check_no_error(error, 'evaluations')
         call reader%close()
      end do
      call check(count(2) - count(1) <= 3*10001, 'evaluations of a sampled control')
   end subroutine check_cost

   !> An event at a value of an output.
   subroutine check_events()
      type(history_reader_type) :: reader
      real(wp), allocatable :: t(:)
      type(error_type), allocatable :: error
      call run_scene(aside//'*CONTROL, NAME=lag, TYPE=LAG, TIME CONSTANT=0.5'//nl//' 1'//nl// &
         & '*EVENT, NAME=half, ACTION=STOP'//nl//' output(lag) - 0.5'//nl, 'RADAU', 'END=2', ' output(lag)', reader)
      call reader%read_numbers('/events/time', t, error)
      call check_no_error(error, 'events of outputs')
      call check(size(t) == 1, 'one event of an output')
      call check_close(t(1), 0.5_wp*log(2.0_wp), 1.0e-6_wp, 'time of the event of an output')
      call reader%close()
   end subroutine check_events

   !> States go on in a second analysis, also from rest; a sample at the border of two analyses is taken once.
   subroutine check_analyses()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp), allocatable :: values(:)
      call run_text(aside//'*CONTROL, NAME=area, TYPE=INTEGRATOR'//nl//' 1'//nl// &
         & '*CONTROL, NAME=sampled, TYPE=PID, KI=1, PERIOD=0.5'//nl//' 1'//nl// &
         & '*FORCE, NAME=f, POINT=p'//nl//' 1, 0'//nl//'*DYNAMICS, END=1, OUTPUTS=4'//nl// &
         & '*DYNAMICS, END=2, OUTPUTS=4, VELOCITIES=REST'//nl//'*OUTPUT'//nl//' output(area), output(sampled), vx(p)'//nl, &
         & trim(results), report, error)
      call check_no_error(error, 'two analyses')
      call reader%open(trim(results), error)
      values = channel(reader, 'output_area')
      call check_close(maxval(abs(values - [0.0_wp, 0.25_wp, 0.5_wp, 0.75_wp, 1.0_wp, 1.0_wp, 1.25_wp, 1.5_wp, 1.75_wp, 2.0_wp])), &
         & 0.0_wp, 1.0e-9_wp, 'a state in two analyses')
      values = channel(reader, 'output_sampled')
      call check_close(maxval(abs(values - 0.5_wp*[1, 1, 2, 2, 3, 3, 3, 4, 4, 5])), 0.0_wp, 1.0e-14_wp, 'samples in two analyses')
      values = channel(reader, 'vx_p')
      call check_close(values(10), 1.0_wp, 1.0e-9_wp, 'velocities from rest')
      call reader%close()
   end subroutine check_analyses

   !> States have no weight, no momentum, no energy and no part in the size of the scene, however large they are.
   subroutine check_weight()
      type(history_reader_type) :: reader
      real(wp), allocatable :: values(:)
      integer :: n
      do n = 1, size(integrators)
         call run_scene('*GRAVITY'//nl//'*POINT MASS, NAME=p, MASS=1, Y=0.1, VX=0.2'//nl// &
            & '*SPRING, NAME=s, STIFFNESS=50'//nl//' p, ground.origin'//nl// &
            & '*CONTROL, NAME=large, TYPE=INTEGRATOR, GAIN=1e8, SCALE=1e6'//nl//' x(p)'//nl// &
            & '*CONTROL, NAME=still, TYPE=INTEGRATOR'//nl//' 0'//nl, trim(integrators(n)), 'END=1, OUTPUTS=10', &
            & ' output(still), output(large), e = kinetic_energy(system) + potential_energy(system), momentum_x(system), vx(p)', &
            & reader)
         values = channel(reader, 'output_still')
         call check(.not. any(abs(values) > 0.0_wp), trim(integrators(n))//': a state does not fall')
         values = channel(reader, 'e')
         call check_close(maxval(abs(values - values(1))), 0.0_wp, merge(1.0e-3_wp, 1.0e-5_wp, integrators(n) == 'ALPHA'), &
            & trim(integrators(n))//': energy beside a large state')
         call compare(reader, 'momentum_x_system', channel(reader, 'vx_p'), 1.0e-15_wp, trim(integrators(n)))
         call check_warning(reader, '', trim(integrators(n))//': large state')
         call reader%close()
      end do
   end subroutine check_weight

   !> Errors are estimated with controls, too.
   subroutine check_estimate()
      type(history_reader_type) :: reader
      real(wp), allocatable :: values(:)
      call run_scene('*ACCURACY, ESTIMATE=YES'//nl//'*CONTROL, NAME=pid, TYPE=PID, KP=2, KI=3, KD=0.12, FILTER=0.01'//nl// &
         & ' 1 - angle(rotor)'//nl//rotor, 'ADAMS', 'END=1, OUTPUTS=20', ' angle(rotor), output(pid)', reader)
      values = channel(reader, reader%estimates(2)%name)
      call check(maxval(values) > 0.0_wp .and. maxval(values) < 1.0e-3_wp, 'estimate of an output')
      call reader%close()
   end subroutine check_estimate

   subroutine check_refusals()
      call check_refused(aside//'*CONTROL, NAME=wild, TYPE=HOLD, PERIOD=0.1'//nl//' sqrt(0.45 - t)'//nl//'*DYNAMICS, END=1'//nl, &
         & "the input of control 'wild' has no value at t = 0.5")
      call check_refused(aside//'*CONTROL, NAME=lag, TYPE=LAG, TIME CONSTANT=1'//nl//' x(p)'//nl//'*MODES'//nl, &
         & '*MODES knows no states of controls')
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

end program test_controls
