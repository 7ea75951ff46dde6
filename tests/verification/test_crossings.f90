!> Laws of the motion that steps could jump over: a quarter car over a bump far away, whose numbers an integrator with events has
!> made (Dormand and Prince, order 8, the breaks met); a narrow pulse in place, in closed form; pulses of a road, and
!> friction whose law nearly jumps (the same integrator); a ball on a hard floor, in closed form; what sticks where a law jumps; and
!> hills of place, steep or on the move, by their energies; narrow forces of relative place beside heavy bodies, in closed form.
!> Usage, in tests/: test_crossings RESULT_FILE
program test_crossings
   use, intrinsic :: ieee_exceptions, only: ieee_all, ieee_get_halting_mode, ieee_set_halting_mode
   use, intrinsic :: ieee_exceptions, only: ieee_get_halting_mode, ieee_divide_by_zero
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_commands_run, only: run_deck
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_changed, run_text, change_deck, channel
   use testing, only: check, check_close, finish
   implicit none

   character(256) :: results
   character(24), parameter :: integrators(4) = [character(24) :: 'INTEGRATOR=ADAMS', 'INTEGRATOR=RADAU', 'INTEGRATOR=ALPHA', &
      & 'INTEGRATOR=CONSERVING']
   integer :: i

   call get_command_argument(1, results)
   do i = 1, size(integrators)
      call check_bump(integrators(i), '1e-3', 0.2_wp)
      call check_bump(integrators(i), '1e-6', 3.0e-3_wp)
      call check_pulse(integrators(i))
      call check_spike(integrators(i))
      call check_roads(integrators(i), '1e-4', 20.0e-4_wp)
      call check_roads(integrators(i), '1e-6', merge(20.0e-6_wp, 150.0e-6_wp, i <= 2))
      call check_sticking(integrators(i))
      call check_passed(integrators(i), 'tol = 1e-4')
      call check_passed(integrators(i), 'tol = 1e-6')
      call check_turning_back(integrators(i))
      call check_grazed(integrators(i), '1e-6', 1.0e-7_wp, 1.0e-3_wp)
   end do
   call check_grazed('INTEGRATOR=RADAU', '1e-4', 1.0e-9_wp, 1.0e-4_wp)
   call check_grazed('INTEGRATOR=RADAU', '1e-8', 1.0e-9_wp, 1.0e-5_wp)
   call check_grazed('INTEGRATOR=RADAU', '1e-10', 1.0e-9_wp, 1.0e-6_wp)
   call check_grazed('INTEGRATOR=ADAMS', '1e-6', 1.0e-8_wp, 1.0e-5_wp)
   call check_grazed('INTEGRATOR=ADAMS', '1e-10', 1.0e-9_wp, 1.0e-6_wp)
   do i = 1, size(integrators)
      call check_relative(integrators(i), '2e-3', '1')
      call check_relative(integrators(i), '2e-3', '1e3')
      call check_relative(integrators(i), '2e-3', '1e9')
      call check_relative(integrators(i), '3e-4', '1e9')
   end do
   call check_no_slope('RADAU')
   call check_no_slope('ALPHA')
   call check_peak()
   call check_round_off()
   call check_drag()
   call check_layer('INTEGRATOR=ADAMS', '1e-4', 40.0e-4_wp)
   call check_layer('INTEGRATOR=ADAMS', '1e-6', 40.0e-6_wp)
   call check_layer('INTEGRATOR=ADAMS', '1e-8', 40.0e-8_wp)
   call check_layer('INTEGRATOR=RADAU', '1e-6', 40.0e-6_wp)
   call check_layer('INTEGRATOR=ALPHA', '1e-4', 300.0e-4_wp)
   call check_layer('INTEGRATOR=CONSERVING', '1e-4', 300.0e-4_wp)
   call check_floor('INTEGRATOR=CONSERVING', '1e-3', 40.0e-3_wp)
   call check_floor('INTEGRATOR=CONSERVING', '1e-4', 40.0e-4_wp)
   call check_floor('INTEGRATOR=CONSERVING', '1e-6', 40.0e-6_wp)
   call check_floor('INTEGRATOR=RADAU', '1e-6', 200.0e-6_wp)
   do i = 1, 3
      call check_moving_hill(integrators(i), '1e-6', 3.0e-5_wp)
   end do
   call check_moving_hill('INTEGRATOR=ADAMS', '1e-9', 1.0e-6_wp)
   do i = 1, 2
      call check_steep_hills(integrators(i), '1e-4', 2.0e-2_wp)
      call check_steep_hills(integrators(i), '1e-6', 5.0e-4_wp)
      call check_steep_hills(integrators(i), '1e-8', 1.0e-5_wp)
      call check_steep_hills(integrators(i), '1e-10', 1.0e-6_wp)
   end do
   do i = 1, size(integrators)
      call check_wire(integrators(i), '1e-6', merge(1.0e-4_wp, 1.0e-3_wp, i <= 2))
   end do
   call check_wire('INTEGRATOR=RADAU', '1e-10', 1.0e-8_wp)
   call check_barrier('INCREMENTS=1')
   call check_barrier('INCREMENTS=3')
   call check_barrier('INCREMENTS=5')
   call check_bump('INTEGRATOR=RADAU', '1e-10', 1.0e-6_wp)
   call check_bump('INTEGRATOR=ADAMS', '1e-10', 1.0e-6_wp)
   call finish()

contains

   !> A force on a light body by its place relative to another, however heavy: 10 sqrt(pi) of work in a time of w/12.
   subroutine check_relative(integrator, w, mass)
      !> Width of the force, mass of the other body
      character(*), intent(in) :: integrator, w, mass
      character(1), parameter :: nl = new_line('a')
      real(wp), parameter :: expected = sqrt(144 + 20*sqrt(acos(-1.0_wp))) - 2
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp), allocatable :: speed(:)
      call run_text('*POINT MASS, NAME=m, MASS=1, X=-5, VX=10'//nl//'*POINT MASS, NAME=n, MASS='//mass//', X=3, VX=-2'//nl// &
         & '*FORCE, NAME=f, POINT=m'//nl//' 10/'//w//'*exp(-((x(m) - x(n))/'//w//')**2), 0'//nl// &
         & '*DYNAMICS, END=2, OUTPUTS=2, '//trim(integrator)//nl//'*OUTPUT'//nl//' vx(m)'//nl, trim(results), report, error)
      call check(.not. allocated(error), 'a force of relative place runs')
      if (allocated(error)) return
      call reader%open(trim(results), error)
      speed = channel(reader, 'vx_m')
      call reader%close()
      call check_close(speed(3), expected, 3.0e-4_wp, 'force of width '//w//' beside a mass of '//mass//', '//integrator)
   end subroutine check_relative

   !> A law without a derivative where the motion begins: what is told is the law.
   subroutine check_no_slope(integrator)
      character(*), intent(in) :: integrator
      character(1), parameter :: nl = new_line('a')
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      logical :: halting
      ! A build that stops at the first infinity stops here
      call ieee_get_halting_mode(ieee_divide_by_zero, halting)
      if (halting) return
      call run_text('*POINT MASS, NAME=m, MASS=1, VX=1'//nl//'*FORCE, NAME=f, POINT=m'//nl// &
         & ' acos(cos(10*x(m))) - pi/2, 0'//nl//'*DYNAMICS, END=4, INTEGRATOR='//integrator//nl//'*OUTPUT'//nl//' vx(m)'//nl, &
         & trim(results), report, error)
      call check(allocated(error), 'a law without a derivative at the start, '//integrator)
      if (allocated(error)) call check(index(error%message, "the law of 'f' on body 'm' has no derivative there by x(m)") > 0, &
         & 'a law without a derivative is named: '//error%message)
   end subroutine check_no_slope

   !> A mass thrown up by 1/2 that a force along x pushes in the last d of its way, 2 sqrt(2 d) long, to twice its speed: both ways
   !> through the law lie next to each other, and the coordinate moves by next to nothing between them.
   subroutine check_grazed(integrator, tolerance, d, most)
      character(*), intent(in) :: integrator, tolerance
      !> Height above the law, and the error of the speed
      real(wp), intent(in) :: d, most
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      character(400) :: text
      character(24) :: force, height
      real(wp), allocatable :: v(:)
      integer :: asked
      write (force, '(es24.16)') 1/(2*sqrt(2*d))
      write (height, '(es24.16)') 0.5_wp - d
      do asked = 0, 1
         text = '*GRAVITY, Y=-1'//new_line('a')//'*POINT MASS, NAME=p, MASS=1, VX=1, VY=1'//new_line('a')// &
            & '*FORCE, NAME=f, POINT=p'//new_line('a')//trim(adjustl(force))//'*step(y(p) - '//trim(adjustl(height))//'), 0'// &
            & new_line('a')//'*DYNAMICS, END=2, OUTPUTS=10, TOLERANCE='//tolerance//', '//trim(integrator)//new_line('a')// &
            & '*OUTPUT'//new_line('a')//' vx = vx(p)'//trim(merge(', w = work(system)', '                  ', asked == 1))
         call run_text(trim(text)//new_line('a'), trim(results), report, error)
         call check(.not. allocated(error), 'grazed: '//trim(text))
         if (allocated(error)) cycle
         call reader%open(trim(results), error)
         v = channel(reader, 'vx')
         call check_close(v(size(v)), 2.0_wp, most, 'grazed: '//trim(text))
         call reader%close()
      end do
   end subroutine check_grazed

   !> Heights of wheel and body 50 ms behind the beginning of the bump.
   subroutine check_bump(integrator, tolerance, most)
      character(*), intent(in) :: integrator, tolerance
      !> Relative error
      real(wp), intent(in) :: most
      type(history_reader_type) :: reader
      real(wp), allocatable :: wheel(:), body(:)
      call run_changed('verification/bump.inp', trim(results), [character(24) :: 'INTEGRATOR=ADAMS', 'tol = 1e-6'], &
         & pair(integrator, 'tol = '//tolerance), reader)
      allocate (wheel, source=channel(reader, 'wheel'))
      allocate (body, source=channel(reader, 'body'))
      call check_close(wheel(size(wheel)), -0.00076379812997251_wp, most*0.00076_wp, trim(integrator)//' '//tolerance//': wheel')
      call check_close(body(size(body)), 0.00035354048007024_wp, most*0.00035_wp, trim(integrator)//' '//tolerance//': body')
      call reader%close()
   end subroutine check_bump

   !> Heights 40 and 90 ms behind pulses of a road in four shapes, which move the wheel by less than a thousandth of its speed times
   !> the time: errors relative to the peak.
   subroutine check_roads(integrator, tolerance, most)
      character(*), intent(in) :: integrator, tolerance
      !> Relative error
      real(wp), intent(in) :: most
      character(*), parameter :: shapes(4) = [character(90) :: 'road(x(wheel))', &
         & 'high*max(0, 1 - abs(x(wheel) - at - wide/2)/(wide/2))', &
         & 'high*sin(pi*(x(wheel) - at)/wide)**2*step(x(wheel) - at)*step(at + wide - x(wheel))', &
         & 'high*exp(-((x(wheel) - at - wide/2)/(wide/4))**2)']
      real(wp), parameter :: peaks(4) = [0.007873931258_wp, 0.007873931258_wp, 0.007900091938_wp, 0.007005005857_wp]
      real(wp), parameter :: wheels(2, 4) = reshape([-0.001636477143_wp, 0.001165763806_wp, -0.001636477143_wp, 0.001165763806_wp, &
         & -0.001647526115_wp, 0.001169031144_wp, -0.001461675800_wp, 0.001036491776_wp], [2, 4])
      real(wp), parameter :: bodies(2, 4) = reshape([0.001129056668_wp, 0.000959039988_wp, 0.001129056668_wp, 0.000959039988_wp, &
         & 0.001129666513_wp, 0.000959064061_wp, 0.001001227137_wp, 0.000849952183_wp], [2, 4])
      type(history_reader_type) :: reader
      real(wp), allocatable :: wheel(:), body(:)
      character(90) :: old(3), new(3)
      integer :: k
      old = [character(90) :: 'INTEGRATOR=ADAMS', 'tol = 1e-6', 'road(x(wheel))']
      do k = 1, size(shapes)
         new(1) = integrator
         new(2) = 'tol = '//tolerance
         new(3) = shapes(k)
         call run_changed('verification/road.inp', trim(results), old, new, reader)
         if (allocated(wheel)) deallocate (wheel, body)
         allocate (wheel, source=channel(reader, 'wheel'))
         allocate (body, source=channel(reader, 'body'))
         call check_close(maxval(wheel), peaks(k), most*peaks(k), trim(integrator)//' '//tolerance//': peak of '//shapes(k))
         call check_close(maxval(abs(wheel([2006, 2011]) - wheels(:, k))), 0.0_wp, most*peaks(k), trim(integrator)//' '// &
            & tolerance//': wheel behind '//shapes(k))
         call check_close(maxval(abs(body([2006, 2011]) - bodies(:, k))), 0.0_wp, most*peaks(k), trim(integrator)//' '// &
            & tolerance//': body behind '//shapes(k))
         call reader%close()
      end do
   end subroutine check_roads

   !> Its speed across is the integral of the pulse over the time, which passes at 20 a second: F d sqrt(pi)/v.
   subroutine check_pulse(integrator)
      character(*), intent(in) :: integrator
      type(history_reader_type) :: reader
      real(wp), allocatable :: speed(:)
      call run_changed('verification/pulse_in_place.inp', trim(results), ['INTEGRATOR=ADAMS'], [integrator], reader)
      allocate (speed, source=channel(reader, 'vy_bob'))
      call check_close(speed(size(speed)), sqrt(acos(-1.0_wp)), 1.0e-2_wp, trim(integrator)//': pulse in place')
      call reader%close()
   end subroutine check_pulse

   !> Its speed across is the area of the spike over the speed, 0.5/20; what is at rest costs no steps (MAXIMUM STEPS).
   subroutine check_spike(integrator)
      character(*), intent(in) :: integrator
      type(history_reader_type) :: reader
      real(wp), allocatable :: speed(:)
      call run_changed('verification/spike.inp', trim(results), ['INTEGRATOR=ADAMS'], [integrator], reader)
      allocate (speed, source=channel(reader, 'vy_bob'))
      call check_close(speed(size(speed)), 0.025_wp, 1.0e-4_wp, trim(integrator)//': spike of a table in place')
      call reader%close()
   end subroutine check_spike

   !> A step that was done again up to a time was cut before it, and again at that time, to where it had been cut: a hill that moves
   !> was passed twice. The end of its rise was taken for nothing, which is 2e-4 of the speed.
   subroutine check_moving_hill(integrator, tolerance, most)
      character(*), intent(in) :: integrator, tolerance
      !> Relative error
      real(wp), intent(in) :: most
      type(history_reader_type) :: reader
      real(wp), allocatable :: speed(:)
      real(wp) :: exact
      exact = 3 + sqrt(7.0_wp**2 + 20)
      call run_changed('verification/moving_hill.inp', trim(results), [character(24) :: 'INTEGRATOR=ADAMS', 'tol = 1e-6'], &
         & pair(integrator, 'tol = '//tolerance), reader)
      allocate (speed, source=channel(reader, 'vx_bob'))
      call check_close(speed(size(speed)), exact, most*exact, trim(integrator)//' '//tolerance//': a hill that moves')
      call reader%close()
   end subroutine check_moving_hill

   !> Energies of what bounces off steep hills, and the speed of what does: a step that left a hill, or passed it, had not seen it;
   !> up to 34 times the energy came out of it. With cosh, which overflows away from the hill, it was not there.
   subroutine check_steep_hills(integrator, tolerance, most)
      character(*), intent(in) :: integrator, tolerance
      !> Relative error
      real(wp), intent(in) :: most
      character(*), parameter :: laws(2) = [character(30) :: '20*exp(-(x(bob)/w)**2)/w', '20/cosh(x(bob)/w)**2/w']
      type(history_reader_type) :: reader
      real(wp), allocatable :: bob(:), disc(:), left(:)
      character(30) :: new(3)
      logical :: halting(5)
      integer :: k
      ! cosh overflows here on purpose
      call ieee_get_halting_mode(ieee_all, halting)
      call ieee_set_halting_mode(ieee_all, .false.)
      new(1) = integrator
      new(2) = 'tol = '//tolerance
      do k = 1, size(laws)
         new(3) = laws(k)
         call run_changed('verification/steep_hill.inp', trim(results), [character(30) :: 'INTEGRATOR=ADAMS', 'tol = 1e-6', &
            & laws(1)], new, reader)
         if (allocated(bob)) deallocate (bob, disc, left)
         allocate (bob, source=channel(reader, 'bob'))
         allocate (disc, source=channel(reader, 'disc'))
         allocate (left, source=channel(reader, 'left'))
         call check_close(bob(size(bob)), 1.0_wp, most, trim(integrator)//' '//tolerance//': energy behind '//laws(k))
         call check_close(disc(size(disc)), 0.545_wp, most, trim(integrator)//' '//tolerance//': energy of a disc')
         call check_close(left(size(left)), -1.0_wp, most, trim(integrator)//' '//tolerance//': masses that meet')
         call reader%close()
      end do
      call ieee_set_halting_mode(ieee_all, halting)
   end subroutine check_steep_hills

   !> The speed of a bead that a hill of its wire has sent back, and its place: steps jumped over hills of a curve. The time on the
   !> flank is an integral over the energy: from x = 5 - w sqrt(ln(0.981/0.5)) back to x = 4, to each side, by ds/v with
   !> v**2 = 1 - 2 g y; its substitution u**2 = distance from the turning point makes it smooth.
   subroutine check_wire(integrator, tolerance, most)
      character(*), intent(in) :: integrator, tolerance
      !> Error
      real(wp), intent(in) :: most
      real(wp), parameter :: g = 9.81_wp, high = 0.1_wp, w = 0.01_wp
      integer, parameter :: parts = 20000
      type(history_reader_type) :: reader
      real(wp), allocatable :: x(:), v(:)
      real(wp) :: turn, u, most_u, place, slope, time
      integer :: k
      turn = 5 - w*sqrt(log(2*g*high))
      most_u = sqrt(turn - 4)
      time = 0.0_wp
      do k = 1, parts
         u = (k - 0.5_wp)*most_u/parts
         place = (turn - u**2 - 5)/w
         slope = -2*high*place/w*exp(-place**2)
         time = time + 2*u*sqrt((1 + slope**2)/(1 - 2*g*high*exp(-place**2)))*most_u/parts
      end do
      call run_changed('verification/wire_hill.inp', trim(results), [character(24) :: 'INTEGRATOR=ADAMS', 'tol = 1e-6'], &
         & pair(integrator, 'tol = '//tolerance), reader)
      allocate (x, source=channel(reader, 'x_bead'))
      allocate (v, source=channel(reader, 'vx_bead'))
      call check_close(v(size(v)), -1.0_wp, most, trim(integrator)//' '//tolerance//': speed behind a hill of a wire')
      call check_close(x(size(x)), 4 - (20 - 4 - 2*time), 10*most, trim(integrator)//' '//tolerance//': place behind it')
      call reader%close()
   end subroutine check_wire

   !> A place before the barrier, x = 2 - 3 exp(-((x - 1)/w)**2), that increments jumped over.
   subroutine check_barrier(increments)
      character(*), intent(in) :: increments
      type(history_reader_type) :: reader
      real(wp), allocatable :: x(:)
      real(wp) :: exact
      integer :: k
      exact = 1.0_wp
      do k = 1, 20
         exact = 1 - 0.001_wp*sqrt(log(3/(2 - exact)))
      end do
      call run_changed('verification/barrier.inp', trim(results), ['INCREMENTS=5'], [increments], reader)
      allocate (x, source=channel(reader, 'x_bob'))
      call check_close(x(size(x)), exact, 1.0e-8_wp, increments//': before a barrier')
      call reader%close()
   end subroutine check_barrier

   !> Two texts of one length: gfortran 12 makes too short a constructor of them.
   pure function pair(first, second) result(texts)
      character(*), intent(in) :: first, second
      character(24) :: texts(2)
      texts(1) = first
      texts(2) = second
   end function pair

   !> Angle after 10 s of swings: each turning point passes the layer in which friction changes its sign.
   subroutine check_layer(integrator, tolerance, most)
      character(*), intent(in) :: integrator, tolerance
      !> Error [rad]
      real(wp), intent(in) :: most
      type(history_reader_type) :: reader
      real(wp), allocatable :: angle(:)
      call run_changed('verification/layer.inp', trim(results), [character(24) :: 'INTEGRATOR=ADAMS', 'tol = 1e-6'], &
         & pair(integrator, 'tol = '//tolerance), reader)
      allocate (angle, source=channel(reader, 'angle'))
      call check_close(angle(51), -1.171549728061_wp, most, trim(integrator)//' '//tolerance//': friction in a pin, 5 s')
      call check_close(angle(101), -1.496642375379_wp, most, trim(integrator)//' '//tolerance//': friction in a pin, 10 s')
      call reader%close()
   end subroutine check_layer

   !> Heights of a ball that bounces: flights, and contacts that are parts of a vibration about its place at rest.
   subroutine check_floor(integrator, tolerance, most)
      character(*), intent(in) :: integrator, tolerance
      !> Error relative to the first height
      real(wp), intent(in) :: most
      real(wp), parameter :: g = 9.81_wp, high = 28.0_wp, k = 1.4e9_wp
      type(history_reader_type) :: reader
      real(wp), allocatable :: y(:)
      real(wp) :: fall, speed, omega, sag, touch, since, exact(0:54)
      integer :: j
      call run_changed('verification/hard_floor.inp', trim(results), [character(24) :: 'INTEGRATOR=ADAMS', 'tol = 1e-4'], &
         & pair(integrator, 'tol = '//tolerance), reader)
      allocate (y, source=channel(reader, 'y'))
      omega = sqrt(k)
      fall = sqrt(2*high/g)
      speed = g*fall
      sag = g/k
      touch = 2*(acos(-1.0_wp) - atan2(speed/omega, sag))/omega
      do j = 0, 54
         since = modulo(0.5_wp*j + fall, 2*fall + touch)
         exact(j) = speed*since - 0.5_wp*g*since**2
         since = since - 2*fall
         if (since > 0.0_wp) exact(j) = -sag + sag*cos(omega*since) - speed/omega*sin(omega*since)
      end do
      call check_close(maxval(abs(y - exact)), 0.0_wp, most*high, trim(integrator)//' '//tolerance//': bounces')
      call reader%close()
   end subroutine check_floor

   !> Forces that have come up at 24 places, one by one; the torque of the driver is J alpha + 24 f r sin(angle). Where the crank
   !> stood before a place by round-off, behind its crossing, ADAMS took it for a body that sticks.
   subroutine check_passed(integrator, tolerance)
      character(*), intent(in) :: integrator, tolerance
      type(history_reader_type) :: reader
      real(wp), allocatable :: torque(:)
      real(wp) :: angle
      call run_changed('verification/passed_places.inp', trim(results), [character(24) :: 'INTEGRATOR=ADAMS', 'tol = 1e-6'], &
         & pair(integrator, tolerance), reader)
      allocate (torque, source=channel(reader, 'torque_motor'))
      angle = 0.842_wp - 2.26_wp*0.3_wp + 6.78_wp/3.9_wp**2*(cos(3.9_wp*0.3_wp) - 1)
      call check_close(torque(size(torque)), -0.0163_wp*6.78_wp*cos(3.9_wp*0.3_wp) + 24*1.79_wp*0.266_wp*sin(angle), 1.0e-9_wp, &
         & trim(integrator)//' '//tolerance//': places that are passed')
      call reader%close()
   end subroutine check_passed

   !> Heights behind the peak of a bump, at which a step that is done again is to end: by round-off it ended next to it, and nothing
   !> was left for the next one, which was taken for a step that has shrunk to nothing. Made by an integrator with events (DOP853).
   subroutine check_peak()
      type(history_reader_type) :: reader
      real(wp), allocatable :: wheel(:), top(:)
      call run_changed('verification/peaks.inp', trim(results), ['INTEGRATOR=ADAMS'], ['INTEGRATOR=ADAMS'], reader)
      allocate (wheel, source=channel(reader, 'y_wheel'))
      allocate (top, source=channel(reader, 'y_top'))
      call check_close(wheel(size(wheel)), 0.28361294_wp, 3.0e-8_wp, 'wheel behind the peak of a bump')
      call check_close(top(size(top)), 0.73542755_wp, 3.0e-8_wp, 'mass above it')
      call reader%close()
   end subroutine check_peak

   !> At a tolerance near round-off, corrections of Newton's method that no longer shrink are round-off: RADAU halved its step to
   !> nothing there. The energy is that of the start and the work.
   subroutine check_round_off()
      type(history_reader_type) :: reader
      real(wp), allocatable :: energy(:)
      call run_changed('verification/round_off.inp', trim(results), ['OUTPUTS=4'], ['OUTPUTS=4'], reader)
      allocate (energy, source=channel(reader, 'kinetic_energy_system') + channel(reader, 'potential_energy_system') - &
         & channel(reader, 'work_system'))
      call check_close(energy(size(energy)), energy(1), 1.0e-9_wp, 'energy at a tolerance near round-off')
      call reader%close()
   end subroutine check_round_off

   !> What round-off leaves of the velocities where a driver turns back is no impact.
   subroutine check_turning_back(integrator)
      character(*), intent(in) :: integrator
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call change_deck('verification/turning_back.inp', trim(results)//'.inp', ['INTEGRATOR=ADAMS'], [integrator])
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
      call check(.not. allocated(error), trim(integrator)//': the crank that turns back runs')
      if (.not. allocated(error)) call check(index(report, 'velocities jump') == 0, trim(integrator)//': no impact in: '//report)
   end subroutine check_turning_back

   !> A brake that does not know what to do at rest.
   subroutine check_sticking(integrator)
      character(*), intent(in) :: integrator
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call change_deck('verification/pulse_in_place.inp', trim(results)//'.inp', [character(24) :: 'brake = 1e-3', &
         & 'INTEGRATOR=ADAMS'], [character(24) :: 'brake = 0.05', integrator])
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
      call check(allocated(error), trim(integrator)//': a brake that jumps is refused where the disc sticks')
      if (.not. allocated(error)) return
      call check(index(error%message, "the law of 'brake' on body 'disc' jumps to and fro at t = 2") > 0 .and. &
         & index(error%message, 'tanh(v/eps)') > 0, 'law, body, time and remedy in: '//error%message)
   end subroutine check_sticking

   !> A law that bends at the very start, in two components, where all is at rest: it is no reason to start again and again.
   subroutine check_drag()
      type(history_reader_type) :: reader
      real(wp), allocatable :: sun(:), arm(:)
      integer :: i
      call run_changed('verification/slanted_drag.inp', trim(results), [character(1) ::], [character(1) ::], reader)
      allocate (sun, source=channel(reader, 'sun'))
      allocate (arm, source=channel(reader, 'arm'))
      call reader%close()
      call run_changed('verification/slanted_drag.inp', trim(results), [character(24) :: 'TOLERANCE=1e-6', 'INTEGRATOR=ADAMS'], &
         & [character(24) :: 'TOLERANCE=1e-9', 'INTEGRATOR=RADAU'], reader)
      call check_close(maxval(abs(sun - channel(reader, 'sun'))), 0.0_wp, 1.0e-4_wp, 'a gear that is braked: sun')
      call check_close(maxval(abs(arm - channel(reader, 'arm'))), 0.0_wp, 1.0e-4_wp, 'a gear that is braked: arm')
      call reader%close()
      do i = 1, size(integrators)
         call run_changed('verification/rest_start.inp', trim(results), [character(24) :: 'INTEGRATOR=CONSERVING'], &
            & [trim(integrators(i))], reader)
         arm = channel(reader, 'angle_crank')
         call reader%close()
         call check_close(arm(size(arm)), -2.538_wp + 0.5_wp*11.4_wp*0.262_wp, 1.0e-9_wp, 'a crank with stops, set in motion')
      end do
   end subroutine check_drag

end program test_crossings
