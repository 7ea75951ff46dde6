!> Points that are moved along exact beams: drivers, couplers and the coordinates of such joints against closed forms, and a girder
!> that is pulled at the point against the equation of beams. Usage, in tests/: test_along_beam RESULT_FILE
program test_along_beam
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_output_history_reader, only: history_reader_type
   use runs, only: channel, run_text
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   character(*), parameter :: nl = new_line('a')
   !> Bar that hardly bends, a quarter of a circle of radius one, and a bead of 0.1 kg on it at the arc 0.1, with the speed one
   character(*), parameter :: arch = '*MATERIAL, NAME=stuff, YOUNG=2.1e9, DENSITY=7850'//nl// &
      & '*SECTION, NAME=s, SHAPE=CIRCLE, DIAMETER=0.1'//nl// &
      & '*BEAM, NAME=arch, MATERIAL=stuff, SECTION=s, LENGTH=pi/2, CURVATURE=1'//nl// &
      & '*JOINT, NAME=wall, TYPE=WELD, TURN=0'//nl//' arch.start, ground.origin'//nl
   character(*), parameter :: place = '*POINT MASS, NAME=bead, MASS=0.1, X=sin(0.1), Y=1-cos(0.1)'
   character(*), parameter :: wire = '*JOINT, NAME=wire, TYPE=SLIDING'//nl//' bead, arch.start'//nl
   character(*), parameter :: drive = '*DRIVER, NAME=drive, TYPE=DISPLACEMENT, JOINT=wire'//nl//' 0.1 + t**3/3'//nl
   character(*), parameter :: integrators(4) = [character(10) :: 'ADAMS', 'RADAU', 'ALPHA', 'CONSERVING']
   character(256) :: results

   call get_command_argument(1, results)
   call check_free()
   call check_driven()
   call check_inverse()
   call check_coupler()
   call check_girder('40000', -8.19590826e-3_wp, 1932.12975_wp)
   call check_girder('-40000', -9.69612316e-3_wp, 2300.95254_wp)
   call check_modes()
   call finish()

contains

   !> Runs a deck without a warning.
   subroutine run(text, reader, told)
      character(*), intent(in) :: text
      type(history_reader_type), intent(out) :: reader
      !> What a warning tells, '' if it does not matter, as of vibrations of the arch; absent: there is none
      character(*), intent(in), optional :: told
      character(:), allocatable :: report
      type(error_type), allocatable :: error
      call run_text(text, trim(results), report, error)
      call check_no_error(error, text)
      if (allocated(error)) error stop 1
      if (present(told)) then
         call check(index(report, told) > 0, told)
      else
         call check(index(report, 'warning') == 0, 'no warning: '//report)
      end if
      call reader%open(trim(results), error)
      call check_no_error(error, 'results')
   end subroutine run

   !> A channel against what it is expected to be.
   subroutine compare(reader, name, expected, allowed, what)
      type(history_reader_type), intent(in) :: reader
      character(*), intent(in) :: name, what
      real(wp), intent(in) :: expected(:), allowed
      real(wp), allocatable :: values(:)
      allocate (values, source=channel(reader, name))
      call check(size(values) == size(expected), what//': samples of '//name)
      if (size(values) == size(expected)) call check_close(maxval(abs(values - expected)), 0.0_wp, allowed, what//': '//name)
   end subroutine compare

   !> Times of a run of `count` intervals.
   pure function times(end, count) result(t)
      real(wp), intent(in) :: end
      integer, intent(in) :: count
      real(wp) :: t(0:count)
      integer :: i
      t = [(end*i/count, i=0, count)]
   end function times

   !> A bead without friction keeps its speed along the wire; its place counts from the point that the joint names.
   subroutine check_free()
      type(history_reader_type) :: reader
      character(80) :: name
      real(wp) :: t(0:14)
      integer :: i
      t = times(1.4_wp, 14)
      do i = 1, size(integrators)
         name = trim(integrators(i))
         call run(arch//place//', VX=cos(0.1), VY=sin(0.1)'//nl//wire// &
            & '*DYNAMICS, END=1.4, OUTPUTS=14, TOLERANCE=1e-6, INTEGRATOR='//trim(name)//nl//'*OUTPUT'//nl// &
            & ' s = displacement(wire), v = sliding_speed(wire)'//nl, reader, '')
         call compare(reader, 's', 0.1_wp + t, 1.0e-4_wp, 'bead, '//name)
         call compare(reader, 'v', 1 + 0*t, 2.0e-4_wp, 'bead, '//name)
         call reader%close()
      end do
      call run(arch//place//', VX=cos(0.1), VY=sin(0.1)'//nl//'*JOINT, NAME=wire, TYPE=SLIDING'//nl//' bead, arch.end'//nl// &
         & '*DYNAMICS, END=1.4, OUTPUTS=14'//nl//'*OUTPUT'//nl//' s = displacement(wire)'//nl, reader)
      call compare(reader, 's', 0.1_wp + t - 0.5_wp*acos(-1.0_wp), 1.0e-4_wp, 'bead, from the end')
      call reader%close()
   end subroutine check_free

   !> A bead whose arc is 0.1 + t^3/3: its driver pushes by m s'' = 0.2 t along the wire, which holds it by m s'^2 = 0.1 t^4 across.
   subroutine check_driven()
      type(history_reader_type) :: reader
      character(*), parameter :: options(*) = [character(5) :: '', 'NO']
      character(80) :: name
      real(wp) :: t(0:15)
      real(wp), allocatable :: x(:), y(:)
      integer :: i, k
      t = times(1.5_wp, 15)
      do i = 1, size(integrators)
         do k = 1, size(options)
            name = trim(integrators(i))
            if (k == 2) name = trim(name)//nl//'*ASSEMBLY, ELIMINATION=NO'
            call run(arch//place//nl//wire//drive//'*DYNAMICS, END=1.5, OUTPUTS=15, TOLERANCE=1e-6, INTEGRATOR='//trim(name)//nl// &
               & '*OUTPUT'//nl//' s = displacement(wire), v = sliding_speed(wire), x = x(bead), push = force(drive), '// &
               & 'fx = force_x(wire), fy = force_y(wire), power = power(drive)'//nl, reader, '')
            call compare(reader, 's', 0.1_wp + t**3/3, 1.0e-9_wp, 'driven, '//name)
            call compare(reader, 'v', t**2, 1.0e-7_wp, 'driven, '//name)
            call compare(reader, 'x', sin(0.1_wp + t**3/3), 1.0e-4_wp, 'driven, '//name)
            ! Forces of the others have vibrations of the stiff arch, as those of a bead that nothing drives
            if (integrators(i) == 'RADAU') then
               call compare(reader, 'push', 0.2_wp*t, 1.0e-3_wp, 'driven, '//name)
               call compare(reader, 'power', 0.2_wp*t**3, 2.0e-3_wp, 'driven, '//name)
               allocate (x, source=channel(reader, 'fx'))
               allocate (y, source=channel(reader, 'fy'))
               call check_close(maxval(abs(sqrt(x**2 + y**2) - 0.1_wp*t**4)), 0.0_wp, 4.0e-3_wp, 'force of the wire, '//name)
               deallocate (x, y)
            end if
            call reader%close()
         end do
      end do
   end subroutine check_driven

   !> The same motion by inverse dynamics.
   subroutine check_inverse()
      type(history_reader_type) :: reader
      real(wp) :: t(0:15)
      t = times(1.5_wp, 15)
      call run(arch//place//nl//wire//drive//'*INVERSE DYNAMICS, END=1.5, OUTPUTS=15'//nl//'*OUTPUT'//nl// &
         & ' s = displacement(wire), push = force(drive)'//nl, reader)
      call compare(reader, 's', 0.1_wp + t**3/3, 1.0e-9_wp, 'inverse dynamics')
      call compare(reader, 'push', 0.2_wp*t, 1.0e-5_wp, 'inverse dynamics')
      call reader%close()
   end subroutine check_inverse

   !> A drum of radius 0.2 and inertia 0.004 pulls the bead along the wire with a torque of 0.02: s'' = 0.1/(0.1 + 0.1).
   subroutine check_coupler()
      type(history_reader_type) :: reader
      character(80) :: name
      real(wp) :: t(0:20)
      integer :: i
      t = times(2.0_wp, 20)
      do i = 1, size(integrators)
         name = trim(integrators(i))
         call run(arch//place//nl//wire//'*RIGID BODY, NAME=drum, MASS=1, INERTIA=0.004'//nl//'*JOINT, NAME=axle, TYPE=REVOLUTE'// &
            & nl//' drum.origin, ground.origin'//nl//'*COUPLER, NAME=rope'//nl//' 1, displacement, wire'//nl// &
            & ' -0.2, angle, drum'//nl//'*TORQUE, NAME=motor, BODY=drum'//nl//' 0.02'//nl// &
            & '*DYNAMICS, END=2, OUTPUTS=20, TOLERANCE=1e-6, INTEGRATOR='//trim(name)//nl//'*OUTPUT'//nl// &
            & ' s = displacement(wire), turn = angle(drum), pull = coupling(rope)'//nl, reader, '')
         call compare(reader, 's', 0.1_wp + 0.25_wp*t**2, 1.0e-4_wp, 'coupler, '//name)
         call compare(reader, 'turn', 1.25_wp*t**2, 5.0e-4_wp, 'coupler, '//name)
         if (name == 'RADAU') call compare(reader, 'pull', 0.05_wp + 0*t, 1.0e-3_wp, 'coupler, '//name)
         call reader%close()
      end do
   end subroutine check_coupler

   !> A girder of 6 m under its weight, a trolley of 30 kg held at 3.5 m and pulled along the girder: the axial force between the
   !> pin and the trolley; deflection and moment of the middle by E I y'''' - N y'' = -w, integrated elsewhere to 1e-10.
   subroutine check_girder(pull, deflection, moment)
      character(*), intent(in) :: pull
      real(wp), intent(in) :: deflection, moment
      type(history_reader_type) :: reader
      real(wp) :: force
      read (pull, *) force
      call run('*GRAVITY'//nl//'*MATERIAL, NAME=steel, YOUNG=2.1e11, DENSITY=7850'//nl// &
         & '*SECTION, NAME=s, SHAPE=RECTANGLE, WIDTH=0.05, HEIGHT=0.1'//nl// &
         & '*BEAM, NAME=girder, MATERIAL=steel, SECTION=s, LENGTH=6'//nl//' a, 0.5'//nl//' b, 3.45'//nl//' c, 3.55'//nl// &
         & '*GROUND'//nl//' right, 6, 0'//nl//'*JOINT, NAME=left, TYPE=REVOLUTE'//nl//' girder.start, ground.origin'//nl// &
         & '*JOINT, NAME=right, TYPE=POINT ON LINE'//nl//' girder.end, ground.right'//nl// &
         & '*POINT MASS, NAME=trolley, MASS=30, X=3.5'//nl//'*JOINT, NAME=slide, TYPE=SLIDING'//nl//' trolley, girder.start'//nl// &
         & '*DRIVER, NAME=drive, TYPE=DISPLACEMENT, JOINT=slide'//nl//' 3.5'//nl//'*FORCE, NAME=pull, POINT=trolley'//nl// &
         & ' '//pull//', 0'//nl//'*STATICS'//nl//'*OUTPUT'//nl//' y = y(girder.middle), m = bending_moment(girder.middle), '// &
         & 'a = axial_force(girder.a), b = axial_force(girder.b), c = axial_force(girder.c), left = force_x(left), '// &
         & 'drive = force(drive)'//nl, reader)
      call check_close(last(reader, 'y')/deflection, 1.0_wp, 2.0e-4_wp, 'deflection of a girder pulled by '//pull)
      call check_close(last(reader, 'm')/moment, 1.0_wp, 2.0e-4_wp, 'its moment')
      call check_close(last(reader, 'a')/force, 1.0_wp, 5.0e-4_wp, 'axial force beside the pin')
      call check_close(last(reader, 'b')/force, 1.0_wp, 5.0e-4_wp, 'axial force before the trolley')
      call check_close(last(reader, 'c')/force, 0.0_wp, 5.0e-4_wp, 'axial force behind the trolley')
      call check_close(last(reader, 'left')/force, -1.0_wp, 1.0e-9_wp, 'force of the pin')
      call check_close(last(reader, 'drive')/force, -1.0_wp, 5.0e-4_wp, 'force of the driver')
      call reader%close()
   end subroutine check_girder

   !> A beam with modes on two pins, a trolley that is driven along it: its coordinate, and that axial forces lack the drive.
   subroutine check_modes()
      type(history_reader_type) :: reader
      real(wp) :: t(0:10)
      t = times(1.0_wp, 10)
      call run('*GRAVITY'//nl//'*MATERIAL, NAME=stuff, YOUNG=2.1e11, DENSITY=7850'//nl// &
         & '*SECTION, NAME=s, SHAPE=RECTANGLE, WIDTH=0.05, HEIGHT=0.1'//nl// &
         & '*BEAM, NAME=girder, MATERIAL=stuff, SECTION=s, LENGTH=6, GEOMETRIC=LINEAR, MODES=4'//nl// &
         & '*GROUND'//nl//' right, 6, 0'//nl//'*JOINT, NAME=left, TYPE=REVOLUTE'//nl//' girder.start, ground.origin'//nl// &
         & '*JOINT, NAME=right, TYPE=POINT ON LINE'//nl//' girder.end, ground.right'//nl// &
         & '*POINT MASS, NAME=trolley, MASS=30, X=1'//nl//'*JOINT, NAME=slide, TYPE=SLIDING'//nl//' trolley, girder.end'//nl// &
         & '*DRIVER, NAME=drive, TYPE=DISPLACEMENT, JOINT=slide'//nl//' -5 + t**2'//nl//'*DYNAMICS, END=1, OUTPUTS=10'//nl// &
         & '*OUTPUT'//nl//' s = displacement(slide), v = sliding_speed(slide), push = force(drive)'//nl, reader, &
         & "axial forces of 'girder' lack")
      call compare(reader, 's', -5 + t**2, 1.0e-8_wp, 'along modes')
      call compare(reader, 'v', 2*t, 1.0e-6_wp, 'along modes')
      call reader%close()
   end subroutine check_modes

   real(wp) function last(reader, name)
      type(history_reader_type), intent(in) :: reader
      character(*), intent(in) :: name
      real(wp), allocatable :: values(:)
      allocate (values, source=channel(reader, name))
      last = values(size(values))
   end function last

end program test_along_beam
