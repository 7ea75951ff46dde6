!> Axes that a deck speaks of are those of the body that it names, not of a member or piece that stands for it: joints, bushings,
!> drivers, joint forces and angles of bodies on a sloping member of a frame, in either order of points, with LARGE=NO and YES, and
!> of beams in segments; all against closed forms of a frame that is all but rigid. Usage, in tests/: test_frame_axes RESULT_FILE
program test_frame_axes
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use limber_output_history_reader, only: history_reader_type
   use runs, only: channel, run_text
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   character(*), parameter :: nl = new_line('a')
   real(wp), parameter :: gravity = 9.81_wp
   character(256) :: results
   integer :: order

   call get_command_argument(1, results)
   do order = 1, 2
      call check_frame('NO ', order)
      call check_frame('YES', order)
   end do
   call check_segments('', .false.)
   call check_segments(', SUPPORT=CLAMPED-FREE', .true.)
   call check_moved()
   call finish()

contains

   !> A frame at an angle of 0.3 whose first member is drawn from right to left, the second at a slope of 0.9273, with a body on
   !> that one for each kind of joint.
   subroutine check_frame(large, order)
      !> YES or NO; 1: the frame is named second in each joint, 2: first
      character(*), intent(in) :: large
      integer, intent(in) :: order
      real(wp), parameter :: tilt = 0.3_wp, corner(2) = [0.2_wp, 0.1_wp], own = 0.2_wp, turn = 0.5_wp, axes = 0.6_wp, &
         & stiffness(2) = [1.0e4_wp, 2.0e4_wp], guessed = 0.05_wp
      type(history_reader_type) :: reader
      character(:), allocatable :: name, place
      real(wp) :: p(2), at(2), along(2), angle, weight(2)
      p = corner + turned([1.3_wp, 0.4_wp], tilt)
      place = ', X='//as_text(p(1), 17)//', Y='//as_text(p(2), 17)//', ANGLE=0.2'//nl
      angle = merge(tilt, own, order == 1) + turn
      along = merge(1, -1, order == 1)*[cos(angle), sin(angle)]
      at = p + guessed*along
      call run_scene('*MATERIAL, NAME=m, YOUNG=2e16, DENSITY=7800'//nl//'*SECTION, NAME=s, SHAPE=RECTANGLE, WIDTH=0.04, '// &
         & 'HEIGHT=0.03'//nl//'*FRAME, NAME=f, MATERIAL=m, SECTION=s, X=0.2, Y=0.1, ANGLE=0.3, LARGE='//trim(large)//nl// &
         & ' p, 2, 0.5'//nl//'*NODE'//nl//' 1, 0, 0, foot'//nl//' 2, 1, 0, knee'//nl//' 3, 1.6, 0.8, tip'//nl// &
         & '*ELEMENT'//nl//' 1, 2, 1'//nl//' 2, 2, 3'//nl// &
         & '*GROUND'//nl//' corner, 0.2, 0.1'//nl//' centre, '//as_text(p(1), 17)//', '//as_text(p(2), 17)//nl// &
         & '*JOINT, NAME=wall, TYPE=WELD'//nl//pair('f.foot', 'ground.corner', 3 - order)// &
         & '*RIGID BODY, NAME=a, MASS=10, INERTIA=1'//place//'*JOINT, NAME=weld, TYPE=WELD'//nl//pair('a.origin', 'f.p', order)// &
         & '*RIGID BODY, NAME=b, MASS=1, INERTIA=1, X='//as_text(at(1), 17)//', Y='//as_text(at(2), 17)//', ANGLE=0.2'//nl// &
         & '*JOINT, NAME=guide, TYPE=TRANSLATIONAL, ANGLE=0.5'//nl//pair('b.origin', 'f.p', order)// &
         & '*DRIVER, NAME=push, TYPE=DISPLACEMENT, JOINT=guide, LEVEL=VELOCITY'//nl//' 0.1'//nl// &
         & '*RIGID BODY, NAME=c, MASS=1, INERTIA=1'//place//'*JOINT, NAME=pivot, TYPE=REVOLUTE'//nl//' c, ground.centre'//nl// &
         & '*JOINT, NAME=mesh, TYPE=RACK, RADIUS=0.1, ANGLE=-0.4'//nl//pair('c.origin', 'f.tip', order)// &
         & '*RIGID BODY, NAME=d, MASS=5, INERTIA=1'//place//'*BUSHING, NAME=mount, STIFFNESS X=1e4, STIFFNESS Y=2e4, '// &
         & 'STIFFNESS ROTATION=1e8, AXES=0.6, ANGLE='//trim(merge('-0.1', '0.1 ', order == 1))//nl// &
         & pair('d.origin', 'f.p', order)// &
         & '*GRAVITY'//nl//'*STATICS, INCREMENTS=1, RAMP=YES'//nl//'*OUTPUT'//nl// &
         & ' af = angle(f), aa = angle(a), ab = angle(b), ac = angle(c), turn = joint_angle(weld)'//nl// &
         & ' w1 = force_1(weld), w2 = force_2(weld), v1 = force_1(wall), v2 = force_2(wall)'//nl// &
         & ' xb = x(b), yb = y(b), slide = displacement(guide), xd = x(d), yd = y(d)'//nl, reader)
      name = 'LARGE='//trim(large)//', order'//as_text(order)//': '
      call expect(reader, 'af', tilt, 1.0e-6_wp, name)
      call expect(reader, 'aa', own, 1.0e-6_wp, name)
      call expect(reader, 'ab', own, 1.0e-6_wp, name)
      call expect(reader, 'ac', own, 1.0e-4_wp, name)
      call expect(reader, 'turn', merge(own - tilt, tilt - own, order == 1), 1.0e-6_wp, name)
      ! What carries 10 kg, on the body or on the frame, in the axes of the other
      weight = merge(1, -1, order == 1)*turned([0.0_wp, 10*gravity], -merge(tilt, own, order == 1))
      call expect(reader, 'w1', weight(1), 1.0e-3_wp, name)
      call expect(reader, 'w2', weight(2), 1.0e-3_wp, name)
      ! The wall carries all but c: 16 kg and the frame of 2 m
      weight = [0.0_wp, (16 + 2*7800*0.0012_wp)*gravity]
      if (order == 1) weight = turned(-weight, -tilt)
      call expect(reader, 'v1', weight(1), 1.0e-2_wp, name)
      call expect(reader, 'v2', weight(2), 1.0e-2_wp, name)
      at = p + (guessed + 0.1_wp)*along
      call expect(reader, 'slide', guessed + 0.1_wp, 1.0e-9_wp, name)
      call expect(reader, 'xb', at(1), 1.0e-5_wp, name)
      call expect(reader, 'yb', at(2), 1.0e-5_wp, name)
      angle = merge(tilt, own, order == 1) + axes
      at = p + turned(turned([0.0_wp, -5*gravity], -angle)/stiffness, angle)
      call expect(reader, 'xd', at(1), 1.0e-5_wp, name)
      call expect(reader, 'yd', at(2), 1.0e-5_wp, name)
      call reader%close()
   end subroutine check_frame

   !> A data line of two points, in either order.
   function pair(first, second, order) result(line)
      character(*), intent(in) :: first, second
      integer, intent(in) :: order
      character(:), allocatable :: line
      line = ' '//first//', '//second//nl
      if (order == 2) line = ' '//second//', '//first//nl
   end function pair

   !> A cantilever in four pieces that a weight of 20 kg bends far: the frame of the beam, whose angle is told, is that of its
   !> joint.
   subroutine check_segments(option, clamped)
      character(*), intent(in) :: option
      !> Whether its frame is the section at the start, else the chord
      logical, intent(in) :: clamped
      type(history_reader_type) :: reader
      real(wp), allocatable :: x(:), y(:)
      real(wp) :: angle
      call run_scene('*MATERIAL, NAME=m, YOUNG=2e11, DENSITY=7800'//nl//'*SECTION, NAME=s, SHAPE=RECTANGLE, WIDTH=0.04, '// &
         & 'HEIGHT=0.01'//nl//'*BEAM, NAME=b, MATERIAL=m, SECTION=s, LENGTH=1.5, SEGMENTS=4'//option//nl// &
         & '*JOINT, NAME=wall, TYPE=WELD'//nl//' b.start, ground.origin'//nl// &
         & '*POINT MASS, NAME=load, MASS=20, X=1.5'//nl//'*JOINT, NAME=pin, TYPE=REVOLUTE'//nl//' load, b.end'//nl// &
         & '*GRAVITY'//nl//'*STATICS, INCREMENTS=5'//nl//'*OUTPUT'//nl//' x = x(b.end), y = y(b.end), a = angle(b)'//nl// &
         & ' f1 = force_1(pin), f2 = force_2(pin)'//nl, reader)
      allocate (x, source=channel(reader, 'x'))
      allocate (y, source=channel(reader, 'y'))
      angle = 0.0_wp
      if (.not. clamped) angle = atan2(y(size(y)), x(size(x)))
      call check(clamped .or. angle < -0.2_wp, 'segments'//option//': the chord has turned')
      call expect(reader, 'a', angle, 1.0e-9_wp, 'segments'//option//': ')
      call expect(reader, 'f1', 20*gravity*sin(angle), 1.0e-6_wp, 'segments'//option//': ')
      call expect(reader, 'f2', 20*gravity*cos(angle), 1.0e-6_wp, 'segments'//option//': ')
      call reader%close()
   end subroutine check_segments

   !> A beam in segments whose frame is the section at its start can be moved: it turns as a whole.
   subroutine check_moved()
      type(history_reader_type) :: reader
      call run_scene('*MATERIAL, NAME=m, YOUNG=2e11, DENSITY=7800'//nl//'*SECTION, NAME=s, SHAPE=RECTANGLE, WIDTH=0.04, '// &
         & 'HEIGHT=0.01'//nl//'*BEAM, NAME=b, MATERIAL=m, SECTION=s, LENGTH=1.5, SEGMENTS=3, SUPPORT=CLAMPED-FREE'//nl// &
         & '*FORCE, NAME=push, POINT=b.end, FOLLOWER=YES'//nl//' 0, 1e-3*t'//nl// &
         & '*MOTION, NAME=motor, BODY=b'//nl//' 0.1*t, 0.2*t, 0.7*t'//nl//'*STATICS, INCREMENTS=2'//nl// &
         & '*OUTPUT'//nl//' x = x(b.end), y = y(b.end), m = torque(motor_angle)'//nl, reader)
      call expect(reader, 'x', 0.1_wp + 1.5_wp*cos(0.7_wp), 1.0e-5_wp, 'moved: ')
      call expect(reader, 'y', 0.2_wp + 1.5_wp*sin(0.7_wp), 1.0e-5_wp, 'moved: ')
      call expect(reader, 'm', -1.5e-3_wp, 1.0e-7_wp, 'moved: ')
      call reader%close()
   end subroutine check_moved

   !> The last value of a channel.
   subroutine expect(reader, name, value, tolerance, scene)
      type(history_reader_type), intent(inout) :: reader
      character(*), intent(in) :: name, scene
      real(wp), intent(in) :: value, tolerance
      real(wp), allocatable :: values(:)
      allocate (values, source=channel(reader, name))
      call check_close(values(size(values)), value, tolerance, scene//name)
   end subroutine expect

   !> Runs a deck without a warning.
   subroutine run_scene(text, reader)
      character(*), intent(in) :: text
      type(history_reader_type), intent(out) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call run_text(text, trim(results), report, error)
      call check_no_error(error, text)
      if (allocated(error)) error stop 1
      call check(index(report, 'warning') == 0, report)
      call reader%open(trim(results), error)
      call check_no_error(error, text)
   end subroutine run_scene

   !> A vector turned by an angle.
   pure function turned(vector, angle)
      real(wp), intent(in) :: vector(2), angle
      real(wp) :: turned(2)
      turned = cos(angle)*vector + sin(angle)*[-vector(2), vector(1)]
   end function turned

end program test_frame_axes
