!> Turns of driven and free wheels, and what depends on them: a nut on a screw, a law of an angle, by each integrator, with steps
!> of fixed length, and position by position. All is known in closed form.
!> Usage, in tests/: test_turns RESULT_FILE
program test_turns
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: newline
   use limber_commands_run, only: run_deck
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_changed, run_text, change_deck, channel
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   character(256) :: results
   character(64) :: integrator(4) = [character(64) :: 'ADAMS', 'RADAU', 'ALPHA', 'CONSERVING']
   integer :: i

   call get_command_argument(1, results)
   do i = 1, size(integrator)
      call check_turns('INTEGRATOR=ADAMS', 'INTEGRATOR='//integrator(i))
      ! More than half a turn in a step: the speed says which turn it is
      if (i < 4) call check_turns('INTEGRATOR=ADAMS', 'FIXED STEP=0.0125, INTEGRATOR='//integrator(i))
   end do
   call check_alone()
   call check_refusal()
   do i = 1, size(integrator)
      call check_estimate('INTEGRATOR='//integrator(i))
   end do
   call check_drivers()
   call check_pair()
   call check_torque()
   call check_snap()
   call check_rolled()
   call check_rolled_frame()
   call check_driven_beam()
   call check_gap()
   call finish()

contains

   !> Turns are those of the driver's law in all channels, springs and laws of a scene, at a start far from the guess, behind a gap
   !> of time, and in *STATICS, by each analysis.
   subroutine check_drivers()
      character(100) :: first(5), second(5)
      character(8) :: target(2) = [character(8) :: 'JOINT=l', 'BODY=a']
      integer :: k, side
      first = [character(100) :: '*DYNAMICS, INTEGRATOR=ADAMS, END=1, OUTPUTS=2', '*DYNAMICS, INTEGRATOR=RADAU, END=1, OUTPUTS=2', &
         & '*DYNAMICS, INTEGRATOR=CONSERVING, END=1, OUTPUTS=2', '*KINEMATICS, END=1, OUTPUTS=2', '*STATICS, INCREMENTS=1']
      second = [character(100) :: '*DYNAMICS, INTEGRATOR=ADAMS, START=2, END=3, OUTPUTS=2', &
         & '*DYNAMICS, INTEGRATOR=RADAU, START=2, END=3, OUTPUTS=2', &
         & '*DYNAMICS, INTEGRATOR=CONSERVING, START=2, END=3, OUTPUTS=2', '*KINEMATICS, START=2, END=3, OUTPUTS=2', &
         & '*DYNAMICS, START=2, END=3, OUTPUTS=2']
      do side = 1, 2
         do k = 1, 5
            call check_driver(trim(target(side)), first(k), second(k), '1.5*t**2', [0.0_wp, 0.0_wp, 1.5_wp], .false.)
            call check_driver(trim(target(side)), first(k), second(k), '6 + t', [6.0_wp, 1.0_wp, 0.0_wp], side == 2)
            call check_driver(trim(target(side)), first(k), second(k), '10*pi*t', [0.0_wp, 10*acos(-1.0_wp), 0.0_wp], .false.)
         end do
         ! Not from zero
         call check_driver(trim(target(side)), '*STATICS, INCREMENTS=1, PERIOD=2', second(1), '1.5*t**2 - 9', &
            & [-9.0_wp, 0.0_wp, 1.5_wp], side == 2)
      end do
   end subroutine check_drivers

   !> One of them; the law is a polynomial.
   subroutine check_driver(target, first, second, law, factors, is_guess)
      character(*), intent(in) :: target, first, second, law
      real(wp), intent(in) :: factors(3)
      !> Whether the coupler begins with the angle at the start: then its other wheel stands at zero there
      logical, intent(in) :: is_guess
      character(100), parameter :: old(4) = [character(100) :: 'JOINT=l', '1.5*t**2', '*DYNAMICS, END=1, OUTPUTS=2', &
         & '*DYNAMICS, START=2, END=3, OUTPUTS=2']
      character(100) :: new(4)
      character(:), allocatable :: label
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: t(:), angle(:)
      integer :: k
      new = [character(100) :: target, law, first, second]
      label = 'DRIVER '//target//', '//law//', '//trim(first)//' '//trim(second)
      call run_changed('verification/driven_turns.inp', trim(results), old, new, reader)
      call reader%read_time(t, error)
      allocate (angle, source=factors(1) + factors(2)*t + factors(3)*t**2)
      do k = 1, 6
         call compare(reader, 'a'//achar(iachar('0') + k), angle, label)
      end do
      angle = -0.5_wp*angle
      if (is_guess) angle = angle + 0.5_wp*factors(1)
      do k = 1, 5
         call compare(reader, 'b'//achar(iachar('0') + k), angle, label)
      end do
      call reader%close()
   end subroutine check_driver

   subroutine compare(reader, name, expected, label)
      type(history_reader_type), intent(in) :: reader
      character(*), intent(in) :: name, label
      real(wp), intent(in) :: expected(:)
      call check(size(channel(reader, name)) == size(expected), label//': samples')
      call check_close(maxval(abs(channel(reader, name) - expected)), 0.0_wp, 1.0e-6_wp, label//': '//name)
   end subroutine compare

   !> A driven joint between two bodies that both count: the one on the ground keeps the turns that the deck gives it.
   subroutine check_pair()
      character(*), parameter :: law(3) = [character(3) :: '6', '20', '-9']
      real(wp), parameter :: value(3) = [6.0_wp, 20.0_wp, -9.0_wp]
      type(history_reader_type) :: reader
      real(wp) :: apart
      integer :: k
      do k = 1, size(law)
         call run_changed('verification/driven_pair.inp', trim(results), ['LAW'], [law(k)], reader)
         apart = maxval(abs([channel(reader, 'b') - channel(reader, 'a'), channel(reader, 'j'), -channel(reader, 's')] - value(k)))
         call check_close(apart, 0.0_wp, 1.0e-6_wp, 'a driven joint of two bodies, '//law(k))
         call check_close(maxval(abs([channel(reader, 'a'), channel(reader, 'l')])), 0.0_wp, 0.1_wp, &
            & 'the body on the ground, '//law(k))
         call reader%close()
      end do
   end subroutine check_pair

   !> Runs a deck that the text of it gives, and opens its history.
   subroutine run_here(text, label, reader)
      character(*), intent(in) :: text, label
      type(history_reader_type), intent(out) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call run_text(text, trim(results), report, error)
      call check_no_error(error, label)
      if (allocated(error)) error stop 1
      call reader%open(trim(results), error)
      call check_no_error(error, label//': results')
   end subroutine run_here

   !> Compares a channel with what it is to be, sample by sample.
   subroutine check_channel(reader, name, expected, label)
      type(history_reader_type), intent(in) :: reader
      character(*), intent(in) :: name, label
      real(wp), intent(in) :: expected(:)
      call check_close(maxval(abs(channel(reader, name) - expected)), 0.0_wp, 1.0e-6_wp, label//': '//name)
   end subroutine check_channel

   !> One equilibrium winds a spring of 0.5 by 40/0.5 = 80 rad, and a motion begins there.
   subroutine check_torque()
      type(history_reader_type) :: reader
      character(*), parameter :: label = 'a torque that winds a spring at once'
      call run_here('*RIGID BODY, NAME=b, MASS=1, INERTIA=0.1'//newline//'*JOINT, NAME=j, TYPE=REVOLUTE'//newline// &
         & ' b, ground.origin'//newline//'*SPRING, NAME=s, TYPE=ROTATIONAL, STIFFNESS=0.5'//newline//' ground.origin, b'// &
         & newline//'*TORQUE, NAME=t, BODY=b'//newline//' 40'//newline//'*STATICS, PERIOD=0, RAMP=NO'//newline// &
         & '*DYNAMICS, END=1, OUTPUTS=2'//newline//'*OUTPUT'//newline//' a = angle(b), j = joint_angle(j), e = elongation(s)' &
         & //newline, label, reader)
      call check_channel(reader, 'a', spread(80.0_wp, 1, 4), label)
      call check_channel(reader, 'j', spread(80.0_wp, 1, 4), label)
      call check_channel(reader, 'e', spread(80.0_wp, 1, 4), label)
      call reader%close()
   end subroutine check_torque

   !> A pendulum on a spring snaps over and winds it by a turn: k phi + m g l sin(phi) = M, with the same phi in all channels.
   subroutine check_snap()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: t(:), phi(:)
      character(*), parameter :: label = 'a pendulum that snaps over'
      call run_here('*RIGID BODY, NAME=b, MASS=1, INERTIA=0.1, CENTRE X=1, ANGLE=-pi/2'//newline// &
         & '*JOINT, NAME=j, TYPE=REVOLUTE'//newline//' b, ground.origin'//newline//'*GRAVITY'//newline// &
         & '*SPRING, NAME=s, TYPE=ROTATIONAL, STIFFNESS=0.5, ANGLE=-pi/2'//newline//' ground.origin, b'//newline// &
         & '*TORQUE, NAME=t, BODY=b'//newline//' 12*min(t, 1)'//newline//'*STATICS, RAMP=NO'//newline// &
         & '*DYNAMICS, START=1, END=2, OUTPUTS=2'//newline// &
         & '*OUTPUT'//newline//' a = angle(b) + pi/2, j = joint_angle(j) + pi/2, e = elongation(s)'//newline, label, reader)
      call reader%read_time(t, error)
      phi = channel(reader, 'a')
      call check_channel(reader, 'j', phi, label)
      call check_channel(reader, 'e', phi, label)
      call check_close(maxval(abs(0.5_wp*phi + 9.81_wp*sin(phi) - 12*min(t, 1.0_wp))), 0.0_wp, 1.0e-5_wp, label//': balance')
      call check(phi(size(phi)) > 2*acos(-1.0_wp), label//': it has gone over')
      call reader%close()
   end subroutine check_snap

   !> A body that is welded to the end of a beam, which a couple rolls up to two turns before the first state.
   subroutine check_rolled()
      type(history_reader_type) :: reader
      character(*), parameter :: start(2) = [character(9) :: 'STATIC', 'FOLLOWING'], segments(2) = ['1', '4'], &
         & turn(2) = [character(8) :: ', TURN=0', '']
      real(wp), parameter :: two_turns = 4*acos(-1.0_wp)
      character(80) :: label
      integer :: i, k
      do i = 1, 2
         do k = 1, 2
            label = 'a beam rolled up at the start, '//trim(start(i))//', SEGMENTS='//segments(k)//turn(i)
            call run_here('*MATERIAL, NAME=a, YOUNG=1, DENSITY=1'//newline// &
               & '*SECTION, NAME=s, SHAPE=GENERAL, AREA=1e4, INERTIA=1'//newline// &
               & '*BEAM, NAME=b, MATERIAL=a, SECTION=s, LENGTH=10, SEGMENTS='//segments(k)//newline// &
               & '*RIGID BODY, NAME=c, MASS=1, INERTIA=0.1, X=10'//newline//'*JOINT, NAME=w, TYPE=WELD, TURN=0'//newline// &
               & ' b.start, ground.origin'//newline//'*JOINT, NAME=j, TYPE=WELD'//trim(turn(i))//newline//' c, b.end'//newline// &
               & '*TORQUE, NAME=t, POINT=b.end'//newline//' 4*pi/10'//newline//'*ASSEMBLY, INITIAL DEFLECTIONS='//trim(start(i)) &
               & //newline//'*DYNAMICS, END=1e-3, OUTPUTS=2'//newline//'*OUTPUT'//newline//' a = angle(c), j = joint_angle(j)' &
               & //newline, trim(label), reader)
            call check_channel(reader, 'a', spread(two_turns, 1, 3), trim(label))
            call check_channel(reader, 'j', spread(0.0_wp, 1, 3), trim(label))
            call reader%close()
         end do
      end do
   end subroutine check_rolled

   !> A cantilever of two members of a large frame, whatever their direction, which a couple rolls up to 1.2 turns: its rotation is
   !> M s/(E I), in *STATICS and in a motion that begins there.
   subroutine check_rolled_frame()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(*), parameter :: member(2) = [' 2, 2, 3', ' 2, 3, 2'], increments(2) = ['20', '1 ']
      real(wp), parameter :: turns = 2.4_wp*acos(-1.0_wp)
      real(wp), allocatable :: t(:)
      character(80) :: label
      integer :: i, k
      do i = 1, 2
         do k = 1, 2
            label = 'a frame rolled up, member'//member(i)//', INCREMENTS='//trim(increments(k))
            call run_here('*MATERIAL, NAME=a, YOUNG=1, DENSITY=1'//newline// &
               & '*SECTION, NAME=s, SHAPE=GENERAL, AREA=1e4, INERTIA=1'//newline// &
               & '*FRAME, NAME=b, MATERIAL=a, SECTION=s, LARGE=YES'//newline//'*NODE'//newline//' 1, 0, 0, start'//newline// &
               & ' 2, 5, 0, middle'//newline//' 3, 10, 0, end'//newline//'*ELEMENT'//newline//' 1, 1, 2'//newline//member(i)// &
               & newline//'*JOINT, NAME=w, TYPE=WELD, TURN=0'//newline//' b.start, ground.origin'//newline// &
               & '*TORQUE, NAME=t, POINT=b.end'//newline//' 2*pi*1.2/10*min(t, 1)'//newline// &
               & '*STATICS, RAMP=NO, INCREMENTS='//trim(increments(k))//newline// &
               & '*DYNAMICS, START=1, END=1.01, OUTPUTS=2'//newline//'*OUTPUT'//newline// &
               & ' m = rotation(b.middle), e = rotation(b.end)'//newline, trim(label), reader)
            call reader%read_time(t, error)
            call check_channel(reader, 'm', 0.5_wp*turns*min(t, 1.0_wp), trim(label))
            call check_channel(reader, 'e', turns*min(t, 1.0_wp), trim(label))
            call reader%close()
            deallocate (t)
         end do
      end do
   end subroutine check_rolled_frame

   !> A beam that a driver turns by 20 t, and that a couple 2 t and a spring of 0.05 at its end bend: E I/L theta = 2 t - 0.05
   !> (20 t + theta). The spring counts the turns of both.
   subroutine check_driven_beam()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: t(:)
      character(*), parameter :: label = 'a driven beam that is rolled up'
      call run_here('*MATERIAL, NAME=a, YOUNG=100, DENSITY=1'//newline// &
         & '*SECTION, NAME=s, SHAPE=GENERAL, AREA=1, INERTIA=0.01'//newline// &
         & '*BEAM, NAME=b, MATERIAL=a, SECTION=s, LENGTH=10, SUPPORT=CLAMPED-FREE'//newline// &
         & '*RIGID BODY, NAME=c, MASS=1, INERTIA=0.1, X=10'//newline// &
         & '*JOINT, NAME=w, TYPE=REVOLUTE'//newline//' b.start, ground.origin'//newline// &
         & '*DRIVER, NAME=d, TYPE=ANGLE, BODY=b'//newline//' 20*t'//newline//'*JOINT, NAME=j, TYPE=WELD'//newline// &
         & ' b.end, c'//newline//'*SPRING, NAME=k, TYPE=ROTATIONAL, STIFFNESS=0.05'//newline//' ground.origin, b.end'//newline// &
         & '*TORQUE, NAME=t, POINT=b.end'//newline//' 2*t'//newline//'*STATICS, RAMP=NO, INCREMENTS=20'//newline// &
         & '*OUTPUT'//newline//' a = angle(b), r = rotation(b.end), c = angle(c), j = joint_angle(j), k = elongation(k)'// &
         & newline, label, reader)
      call reader%read_time(t, error)
      call check_channel(reader, 'a', 20*t, label)
      call check_channel(reader, 'r', 20*t/3, label)
      call check_channel(reader, 'c', 80*t/3, label)
      call check_channel(reader, 'j', 0*t, label)
      call check_channel(reader, 'k', 80*t/3, label)
      call reader%close()
   end subroutine check_driven_beam

   !> A crank of 0.5 m that a driver turns draws a slotted wheel about a pin beside its own along, behind a gap of time too: angles
   !> differ by less than half a turn, and are the same after each half one.
   subroutine check_gap()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: t(:)
      character(*), parameter :: label = 'a wheel that is drawn along in a gap of time'
      call run_here('*GROUND'//newline//' pin, 0.1, 0'//newline//'*RIGID BODY, NAME=a, MASS=1, INERTIA=0.1'//newline// &
         & ' tip, 0.5, 0'//newline//'*RIGID BODY, NAME=c, MASS=1, INERTIA=0.1, X=0.1'//newline// &
         & '*JOINT, NAME=ja, TYPE=REVOLUTE'//newline//' a, ground.origin'//newline// &
         & '*JOINT, NAME=jc, TYPE=REVOLUTE'//newline//' c, ground.pin'//newline// &
         & '*JOINT, NAME=l, TYPE=POINT ON LINE'//newline//' a.tip, c'//newline//'*DRIVER, NAME=d, TYPE=ANGLE, BODY=a'//newline// &
         & ' 2*pi*t'//newline//'*KINEMATICS, END=1, OUTPUTS=2'//newline//'*KINEMATICS, START=4.5, END=5, OUTPUTS=1'//newline// &
         & '*OUTPUT'//newline//' c = angle(c), j = joint_angle(jc)'//newline, label, reader)
      call reader%read_time(t, error)
      call check_channel(reader, 'c', 2*acos(-1.0_wp)*t, label)
      call check_channel(reader, 'j', 2*acos(-1.0_wp)*t, label)
      call reader%close()
   end subroutine check_gap

   !> A wheel that winds a spring by more than three turns, angle 20 sin t: the runs for the estimate of its error begin where the
   !> run itself has begun, not three turns further on.
   subroutine check_estimate(new)
      character(*), intent(in) :: new
      type(history_reader_type) :: reader
      real(wp), allocatable :: angle(:), estimated(:)
      real(wp) :: largest
      integer :: k
      call run_changed('verification/wound_spring.inp', trim(results), [character(16) :: 'INTEGRATOR=ADAMS'], [trim(new)], reader)
      allocate (angle, source=channel(reader, 'angle_wheel'))
      allocate (estimated, source=channel(reader, reader%estimates(1)%name))
      call reader%close()
      largest = maxval(abs(angle - [(20*sin(0.1_wp*k), k=0, 15)]))
      print '(2a,2es10.2)', trim(new), ' wound spring: error, estimate', largest, maxval(estimated)
      call check_close(largest, 0.0_wp, 0.02_wp, trim(new)//': a wheel on a spring')
      call check(maxval(estimated) < 10*largest, trim(new)//': the estimate counts no turns')
   end subroutine check_estimate

   !> All that turns, and what it draws along.
   subroutine check_turns(old, new)
      character(*), intent(in) :: old, new
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: t(:), turns(:), joint(:), nut(:), bob(:), flywheel(:)
      real(wp), parameter :: pi = acos(-1.0_wp)
      integer :: k
      call run_changed('verification/turns.inp', trim(results), [old], [new], reader)
      call reader%read_time(t, error)
      allocate (turns, source=channel(reader, 'turns'))
      allocate (joint, source=channel(reader, 'joint'))
      allocate (nut, source=channel(reader, 'nut'))
      allocate (bob, source=channel(reader, 'bob'))
      allocate (flywheel, source=channel(reader, 'flywheel'))
      do k = 1, size(t)
         call check_close(turns(k), 50*t(k), 1.0e-9_wp, trim(new)//': turns')
         call check_close(joint(k), 100*pi*t(k), 1.0e-8_wp, trim(new)//': angle of a joint')
         call check_close(nut(k), 0.1_wp*pi*t(k), 1.0e-9_wp, trim(new)//': nut')
         ! (x' + 10)^2 x = 100 (pitch w t): what lags behind by 2/10 of a second, less what was so at the start
         call check_close(bob(k), 0.1_wp*pi*(t(k) - 0.2_wp + (0.2_wp + t(k))*exp(-10*t(k))), 2.0e-3_wp, trim(new)//': bob')
         call check_close(flywheel(k), t(k)**2, 1.0e-2_wp*(1 + t(k)**2), trim(new)//': flywheel')
      end do
      call reader%close()
   end subroutine check_turns

   !> The wheel alone has no unknowns: nothing limits a step of ADAMS but its turns; and the same position by position.
   subroutine check_alone()
      character(*), parameter :: deck = 'verification/driven_wheel.inp'
      type(history_reader_type) :: reader
      real(wp), allocatable :: turns(:)
      call run_changed(deck, trim(results), ['END=10'], ['END=10'], reader)
      allocate (turns, source=channel(reader, 'turns'))
      call check_close(turns(size(turns)), 500.0_wp, 1.0e-9_wp, 'a wheel alone')
      call reader%close()
      deallocate (turns)
      call run_changed(deck, trim(results), [character(30) :: '*DYNAMICS', ', INTEGRATOR=ADAMS'], [character(30) :: '*KINEMATICS', &
         & ', OUTPUTS=3'], reader)
      allocate (turns, source=channel(reader, 'turns'))
      call check_close(turns(size(turns)), 500.0_wp, 1.0e-9_wp, 'a wheel position by position')
      call reader%close()
   end subroutine check_alone

   !> A step in which CONSERVING could not tell the turns.
   subroutine check_refusal()
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call change_deck('verification/turns.inp', trim(results)//'.inp', ['INTEGRATOR=ADAMS'], &
         & ['FIXED STEP=0.0125, INTEGRATOR=CONSERVING'])
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
      call check(allocated(error), 'CONSERVING refuses a step of more than half a turn')
      if (.not. allocated(error)) return
      call check(index(error%message, "turns body 'wheel' by") > 0 .and. index(error%message, 'use a step') > 0, &
         & 'body and remedy in: '//error%message)
   end subroutine check_refusal

end program test_turns
