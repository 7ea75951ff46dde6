!> Times of events, *EVENT, by all integrators: flight with drag and a pendulum (references integrated from event to event, 1e-13),
!> several at once, a start at zero, a touch without a crossing, a scalar that rests at zero, an event that ends an analysis.
!> Usage, in tests/: test_event_times RESULT_FILE
program test_event_times
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_output_history_reader, only: history_reader_type
   use runs, only: numbers, run_text, channel, check_warning
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   character(*), parameter :: nl = new_line('a')
   character(*), parameter :: integrators(4) = [character(10) :: 'ADAMS', 'RADAU', 'ALPHA', 'CONSERVING']
   character(256) :: results
   integer :: i

   call get_command_argument(1, results)
   do i = 1, size(integrators)
      call check_flight(trim(integrators(i)), '1e-6')
      call check_flight(trim(integrators(i)), '1e-9')
      call check_pendulum(trim(integrators(i)))
      call check_several(trim(integrators(i)))
      call check_steps(trim(integrators(i)))
      call check_driven(trim(integrators(i)))
      call check_slow(trim(integrators(i)))
   end do
   call check_touch()
   call check_rest()
   call check_errors()
   call finish()

contains

   !> Error of times that an integrator is allowed: 10 times the tolerance; of order two, the error of a result.
   pure real(wp) function bound(integrator, tolerance)
      character(*), intent(in) :: integrator
      real(wp), intent(in) :: tolerance
      bound = 10*tolerance
      if (integrator == 'ALPHA' .or. integrator == 'CONSERVING') bound = 1.0e-6_wp*(tolerance/1.0e-9_wp)**(2.0_wp/3.0_wp)
   end function bound

   !> A mass on a spring turns back 1e-6 m beyond the place of an event: each passage counts once, though the scalar is slower there
   !> than its round-off. With x = 1 + cos(20 t)/2 there are 63 passages in 10 s; the second one ends the run.
   subroutine check_slow(integrator)
      character(*), intent(in) :: integrator
      character(*), parameter :: scene = '*POINT MASS, NAME=b, MASS=1, X=1.5'//nl//'*JOINT, NAME=l, TYPE=POINT ON LINE'//nl// &
         & ' b, ground.origin'//nl//'*SPRING, NAME=s, STIFFNESS=400, LENGTH=1'//nl//' ground.origin, b'//nl
      type(history_reader_type) :: reader
      real(wp), allocatable :: t(:)
      real(wp) :: phase
      ! (1 - cos(phase))/2 = 1e-6
      phase = acos(1 - 2.0e-6_wp)
      call run_scene(scene//'*EVENT, NAME=z'//nl//' x(b) - 1.5 + 1e-6'//nl, &
         & 'END=10, OUTPUTS=10, TOLERANCE=1e-8, INTEGRATOR='//integrator, ' x(b)', reader)
      t = numbers(reader, '/events/time')
      print '(2a,i4)', 'slow passages, ', integrator, size(t)
      call check(size(t) == 63, integrator//': slow passages count once')
      call reader%close()
      call run_scene(scene//'*EVENT, NAME=z, ACTION=STOP, NUMBER=2'//nl//' x(b) - 1.5 + 1e-6'//nl, &
         & 'END=10, OUTPUTS=10, TOLERANCE=1e-8, INTEGRATOR='//integrator, ' x(b)', reader)
      t = numbers(reader, '/events/time')
      call check(size(t) == 2, integrator//': the second slow passage ends the run')
      call check_close(t(size(t)), (8*atan(1.0_wp) - phase)/20, 1.0e-4_wp, integrator//': time of the second slow passage')
      call reader%close()
   end subroutine check_slow

   !> A ball thrown at 40 m/s and 0.6 rad with drag 0.01 v^2: its apex, and x = 50 m, where the run ends.
   subroutine check_flight(integrator, tolerance)
      character(*), intent(in) :: integrator, tolerance
      type(history_reader_type) :: reader
      real(wp), allocatable :: t(:), y(:), clock(:)
      real(wp) :: allowed
      read (tolerance, *) allowed
      allowed = bound(integrator, allowed)
      call run_scene('*POINT MASS, NAME=p, MASS=1, VX=40*cos(0.6), VY=40*sin(0.6)'//nl//'*GRAVITY, X=0, Y=-9.81'//nl// &
         & '*FORCE, NAME=drag, POINT=p'//nl//' -0.01*sqrt(vx(p)**2 + vy(p)**2)*vx(p), -0.01*sqrt(vx(p)**2 + vy(p)**2)*vy(p)'//nl// &
         & '*EVENT, NAME=apex, DIRECTION=DOWN'//nl//' vy(p)'//nl//'*EVENT, NAME=far, ACTION=STOP'//nl//' x(p) - 50'//nl// &
         & '*EVENT, NAME=later, AFTER=3'//nl//' y(p) - 10'//nl//'*EVENT, NAME=up, DIRECTION=UP'//nl//' vy(p)'//nl, &
         & 'END=10, OUTPUTS=100, TOLERANCE='//tolerance//', INTEGRATOR='//integrator, ' y(p), clock = t', reader)
      t = numbers(reader, '/events/time')
      call check(size(t) == 2, integrator//': two events of four are met')
      call check_close(t(1), 1.7416975562607955_wp, allowed, integrator//', '//tolerance//': time of the apex')
      call check_close(t(2), 2.0283050292288314_wp, allowed, integrator//', '//tolerance//': time of x = 50')
      y = numbers(reader, '/events/channels/y_p')
      call check_close(y(1), 17.55062745355307_wp, 50*allowed, integrator//': height of the apex')
      call check_close(y(2), 17.155239631283045_wp, 50*allowed, integrator//': height there')
      clock = channel(reader, 'clock')
      call check_close(clock(size(clock)), t(2), 1.0e-15_wp, integrator//': the last sample is at the event')
      call check(size(clock) == 22, integrator//': samples up to the event')
      call reader%close()
   end subroutine check_flight

   !> A pendulum of 1 m that starts from 1 rad passes -0.3 rad: elliptic functions.
   subroutine check_pendulum(integrator)
      character(*), intent(in) :: integrator
      type(history_reader_type) :: reader
      real(wp), allocatable :: t(:), direction(:)
      call run_scene('*GRAVITY, X=0, Y=-9.81'//nl//'*POINT MASS, NAME=p, MASS=1, X=sin(1), Y=-cos(1)'//nl// &
         & '*JOINT, NAME=rod, TYPE=ROD'//nl//' p, ground.origin'//nl//'*EVENT, NAME=passage, ACTION=STOP, NUMBER=3'//nl// &
         & ' x(p) + sin(0.3)'//nl, 'END=10, OUTPUTS=7, TOLERANCE=1e-9, INTEGRATOR='//integrator, ' x(p)', reader)
      t = numbers(reader, '/events/time')
      direction = numbers(reader, '/events/direction')
      call check(size(t) == 3, integrator//': three passages')
      call check_close(t(1), 0.6363753987162233_wp, bound(integrator, 1.0e-9_wp), integrator//': first passage')
      call check_close(t(2), 1.5027622018424656_wp, bound(integrator, 1.0e-9_wp), integrator//': second passage')
      call check_close(t(3), 2.775512999274912_wp, bound(integrator, 1.0e-9_wp), integrator//': third passage')
      call check(all(nint(direction) == [-1, 1, -1]), integrator//': down, up, down')
      call reader%close()
   end subroutine check_pendulum

   !> Two masses pass one line at the same instant; another scalar is zero at the start, which is no crossing.
   subroutine check_several(integrator)
      character(*), intent(in) :: integrator
      type(history_reader_type) :: reader
      real(wp), allocatable :: t(:), which(:)
      call run_scene('*POINT MASS, NAME=a, MASS=1, VX=2'//nl//'*POINT MASS, NAME=b, MASS=3, X=3, Y=1, VX=-1'//nl// &
         & '*EVENT, NAME=one'//nl//' x(a) - 1'//nl//'*EVENT, NAME=two'//nl//' x(b) - 2.5'//nl//'*EVENT, NAME=begin'//nl// &
         & ' x(a)'//nl//'*EVENT, NAME=meet'//nl//' x(b) - x(a)'//nl//'*EVENT, NAME=clock'//nl//' t - 0.75'//nl, &
         & 'END=2, OUTPUTS=3, INTEGRATOR='//integrator, ' x(a)', reader)
      t = numbers(reader, '/events/time')
      which = numbers(reader, '/events/event')
      call check(size(t) == 4, integrator//': four events')
      call check_close(t(1), 0.5_wp, 1.0e-9_wp, integrator//': the first of two at once')
      call check_close(t(2), 0.5_wp, 1.0e-9_wp, integrator//': the second of two at once')
      call check(sum(nint(which(:2))) == 3, integrator//': both are noted')
      call check_close(t(3), 0.75_wp, 1.0e-12_wp, integrator//': an event of time')
      call check_close(t(4), 1.0_wp, 1.0e-9_wp, integrator//': they meet')
      call check_warning(reader, '', integrator)
      call reader%close()
   end subroutine check_several

   !> A mass falls by 1 m; there the analysis ends, and the next one goes on from that state to its own end.
   subroutine check_steps(integrator)
      character(*), intent(in) :: integrator
      type(history_reader_type) :: reader
      real(wp), allocatable :: t(:), y(:)
      type(error_type), allocatable :: error
      real(wp) :: fall
      fall = sqrt(2/9.81_wp)
      call run_scene('*GRAVITY, X=0, Y=-9.81'//nl//'*POINT MASS, NAME=p, MASS=1'//nl//'*EVENT, NAME=down, ACTION=END STEP'//nl// &
         & ' y(p) + 1'//nl//'*DYNAMICS, END=2, OUTPUTS=10, INTEGRATOR='//integrator//nl, 'END=3, OUTPUTS=4, INTEGRATOR='// &
         & integrator, ' y(p)', reader)
      call reader%read_time(t, error)
      call check_no_error(error, integrator)
      y = channel(reader, 'y_p')
      call check(size(t) == 4 + 5, integrator//': samples of both analyses')
      call check_close(t(4), fall, 1.0e-7_wp, integrator//': the first ends at the event')
      call check_close(t(5), fall, 1.0e-7_wp, integrator//': the second begins there')
      call check_close(t(9), 3.0_wp, 1.0e-12_wp, integrator//': and goes on to its end')
      call check_close(y(9), -0.5_wp*9.81_wp*9, 1.0e-4_wp, integrator//': with that state')
      call reader%close()
   end subroutine check_steps

   !> A crank turned at 100 pi rad/s: its pin passes the line x = 0 every hundredth of a second, over 50 turns; the slider of the
   !> mechanism turns back as often.
   subroutine check_driven(integrator)
      character(*), intent(in) :: integrator
      type(history_reader_type) :: reader
      real(wp), allocatable :: t(:)
      integer :: k
      call run_scene('*RIGID BODY, NAME=crank, MASS=1, INERTIA=0.01'//nl//' pin, 0.1, 0'//nl// &
         & '*JOINT, NAME=hub, TYPE=REVOLUTE'//nl//' crank.origin, ground.origin'//nl// &
         & '*DRIVER, NAME=motor, TYPE=ANGLE, BODY=crank'//nl//' 100*pi*t'//nl// &
         & '*EVENT, NAME=passage, DIRECTION=DOWN'//nl//' x(crank.pin)'//nl, 'END=1, OUTPUTS=1, INTEGRATOR='//integrator, &
         & ' angle(crank)', reader)
      t = numbers(reader, '/events/time')
      call check(size(t) == 50, integrator//': 50 passages')
      do k = 1, size(t)
         call check_close(t(k), 0.005_wp + 0.02_wp*(k - 1), 1.0e-8_wp, integrator//': passage of the pin')
      end do
      call reader%close()
   end subroutine check_driven

   !> A ball thrown up to 1 m touches that height: no crossing, or two at once, and told; at 0.9 m there are two.
   subroutine check_touch()
      type(history_reader_type) :: reader
      real(wp), allocatable :: t(:)
      call run_scene('*GRAVITY, X=0, Y=-9.81'//nl//'*POINT MASS, NAME=p, MASS=1, VY=sqrt(2*9.81)'//nl//'*EVENT, NAME=top'//nl// &
         & ' y(p) - 1 - 1e-15'//nl//'*EVENT, NAME=below'//nl//' y(p) - 0.9'//nl, &
         & 'END=1, OUTPUTS=3, INTEGRATOR=RADAU', ' y(p)', reader)
      t = numbers(reader, '/events/time')
      call check(size(t) == 2, 'two passages below the top')
      call check_warning(reader, "event 'top' touches zero", 'touch')
      call reader%close()
   end subroutine check_touch

   !> A scalar that rests at zero is told, costs no more than some looks, and the others are met.
   subroutine check_rest()
      type(history_reader_type) :: reader
      real(wp), allocatable :: t(:)
      call run_scene('*POINT MASS, NAME=p, MASS=1, VX=1'//nl//'*EVENT, NAME=height'//nl//' y(p)'//nl//'*EVENT, NAME=half'//nl// &
         & ' x(p) - 0.5'//nl, 'END=1, OUTPUTS=3, INTEGRATOR=RADAU', ' x(p)', reader)
      t = numbers(reader, '/events/time')
      call check(size(t) == 1, 'the other event is met')
      call check_close(t(1), 0.5_wp, 1.0e-12_wp, 'beside one at rest')
      call reader%close()
   end subroutine check_rest

   !> What cannot be: a constant scalar, an event without a motion, an end at an event of a run whose errors are estimated.
   subroutine check_errors()
      call check_refused('*EVENT, NAME=e'//nl//' 2*3'//nl//'*DYNAMICS, END=1'//nl, 'never crosses zero')
      call check_refused('*EVENT, NAME=e'//nl//' x(p)'//nl//'*STATICS'//nl, 'has no *DYNAMICS')
      call check_refused('*EVENT, NAME=e, ACTION=STOP'//nl//' x(p)'//nl//'*DYNAMICS, END=1'//nl//'*ACCURACY, ESTIMATE=YES'//nl, &
         & 'runs that end at different times')
      call check_refused('*EVENT, NAME=e'//nl//' ax(p)'//nl//'*DYNAMICS, END=1'//nl, "an event cannot depend on 'ax'")
      call check_refused('*EVENT, NAME=e'//nl//' x(p)'//nl//'*EVENT, NAME=e'//nl//' y(p)'//nl//'*DYNAMICS, END=1'//nl, "'e'")
   end subroutine check_errors

   !> Checks that a deck is refused, with a text.
   subroutine check_refused(blocks, text)
      character(*), intent(in) :: blocks, text
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call run_text('*POINT MASS, NAME=p, MASS=1'//nl//blocks//'*OUTPUT'//nl//' x(p)'//nl, trim(results), report, error)
      call check(allocated(error), text)
      if (allocated(error)) call check(index(error%message, text) > 0, text//': '//error%message)
   end subroutine check_refused

   !> Runs a scene, and opens its results.
   subroutine run_scene(scene, options, output, reader)
      !> Blocks; options of *DYNAMICS; lines of *OUTPUT
      character(*), intent(in) :: scene, options, output
      type(history_reader_type), intent(out) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call run_text(scene//'*DYNAMICS, '//options//nl//'*OUTPUT'//nl//output//nl, trim(results), report, error)
      call check_no_error(error, options)
      call reader%open(trim(results), error)
      call check_no_error(error, 'results')
   end subroutine run_scene

end program test_event_times
