!> Every joint and every driver in a small scene, by all four integrators: constraints do no work, what drivers put in is what the
!> energy changes by, and all integrators come to the same place. Usage, in tests/: test_joints RESULT_FILE
program test_joints
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_base_text, only: newline
   use limber_commands_run, only: run_deck
   use limber_output_history_reader, only: history_reader_type
   use runs, only: channel
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   character(*), parameter :: nl = newline
   character(*), parameter :: arm = '*RIGID BODY, NAME=arm, MASS=2, INERTIA=0.05, CENTRE X=0.3'//nl//' tip, 0.6, 0.1'//nl// &
      & '*JOINT, NAME=hinge, TYPE=REVOLUTE'//nl//' arm.origin, ground.origin'//nl
   character(*), parameter :: block = '*RIGID BODY, NAME=block, MASS=1.5, INERTIA=0.02, CENTRE Y=0.1, '// &
      & 'X=0.7, Y=0.2, ANGLE=0.4'//nl//' rim, 0.2, 0.1'//nl
   character(*), parameter :: motor = '*DRIVER, NAME=motor, TYPE=ANGLE, BODY=arm'//nl//' 0.7*sin(4*t)'//nl
   !> A law of the angle, whose work CONSERVING has to round-off, as that of the joints; that of a law of the time it has to its
   !> tolerance only
   character(*), parameter :: spin = '*TORQUE, NAME=spin, BODY=block'//nl//' 0.3*cos(5*angle(block))'//nl
   character(*), parameter :: beam = '*MATERIAL, NAME=soft, YOUNG=2e8, DENSITY=1000'//nl// &
      & '*SECTION, NAME=flat, SHAPE=RECTANGLE, WIDTH=0.02, HEIGHT=0.02'//nl//'*BEAM, NAME=beam, MATERIAL=soft, SECTION=flat, '// &
      & 'LENGTH=1, ELEMENTS=12, BENDING MODES=2, AXIAL MODES=1, GEOMETRIC=LINEAR'//nl// &
      & '*JOINT, NAME=hinge, TYPE=REVOLUTE'//nl//' beam.start, ground.origin'//nl
   character(*), parameter :: hand = '*RIGID BODY, NAME=hand, MASS=0.6, INERTIA=0.02, X=0.9, Y=0.4, CENTRE X=0.1'//nl// &
      & ' tip, 0.2, 0'//nl//'*RIGID BODY, NAME=slide, MASS=0.5, INERTIA=0.01, X=1.1, Y=0.4'//nl// &
      & '*JOINT, NAME=pin, TYPE=REVOLUTE'//nl//' block.origin, arm.tip'//nl//'*JOINT, NAME=wrist, TYPE=REVOLUTE'//nl// &
      & ' hand.origin, block.rim'//nl
   character(256) :: results

   call get_command_argument(1, results)
   call compare('translational', arm//block//motor//spin//'*JOINT, NAME=j, TYPE=TRANSLATIONAL, ANGLE=0.3'//nl// &
      & ' block.origin, arm.tip'//nl//'*SPRING, NAME=s, STIFFNESS=40, LENGTH=0.2'//nl//' block.rim, arm.origin'//nl)
   call compare('weld', arm//block//spin//'*JOINT, NAME=j, TYPE=WELD'//nl//' block.origin, arm.tip'//nl)
   call compare('rod', arm//block//motor//'*JOINT, NAME=j, TYPE=ROD'//nl//' block.rim, arm.tip'//nl)
   call compare('point on line', arm//block//motor//'*JOINT, NAME=j, TYPE=POINT ON LINE, ANGLE=0.3'//nl// &
      & ' block.rim, arm.tip'//nl//'*SPRING, NAME=s, STIFFNESS=40, LENGTH=0.2'//nl//' block.rim, arm.origin'//nl)
   call compare('curve, y of x', arm//block//motor//'*CURVE, NAME=c'//nl//' 0.1 + 0.3*x**2'//nl// &
      & '*JOINT, NAME=j, TYPE=POINT ON CURVE, CURVE=c'//nl//' block.rim, arm.tip'//nl// &
      & '*SPRING, NAME=s, STIFFNESS=60, LENGTH=0.1'//nl//' block.rim, arm.tip'//nl)
   call compare('curve, closed spline', arm//block//'*CURVE, NAME=c, CLOSED=YES'//nl//' 0.3, 0'//nl//' 0.2, 0.2'//nl// &
      & ' 0, 0.25'//nl//' -0.2, 0.2'//nl//' -0.3, 0'//nl//' -0.2, -0.2'//nl//' 0, -0.25'//nl//' 0.2, -0.2'//nl// &
      & '*JOINT, NAME=j, TYPE=POINT ON CURVE, CURVE=c'//nl//' arm.tip, block.origin'//nl, 3.0e-7_wp)
   call compare('gear on an arm', arm//block//spin//'*JOINT, NAME=pin, TYPE=REVOLUTE'//nl//' block.origin, arm.tip'//nl// &
      & '*JOINT, NAME=j, TYPE=GEAR, FIRST RADIUS=0.4, SECOND RADIUS=0.2'//nl//' ground.origin, block.origin'//nl)
   call compare('inner gear on an arm', arm//block//motor//'*JOINT, NAME=pin, TYPE=REVOLUTE'//nl//' block.origin, arm.tip'//nl// &
      & '*JOINT, NAME=j, TYPE=GEAR, FIRST RADIUS=0.2, SECOND RADIUS=0.8, INTERNAL'//nl//' block.origin, ground.origin'//nl)
   call compare('belt on an arm', arm//block//spin//'*JOINT, NAME=pin, TYPE=REVOLUTE'//nl//' block.origin, arm.tip'//nl// &
      & '*JOINT, NAME=j, TYPE=BELT, FIRST RADIUS=0.1, SECOND RADIUS=0.2'//nl//' block.origin, ground.origin'//nl)
   call compare('rack on an arm', arm//block//spin//'*RIGID BODY, NAME=slide, MASS=0.5, INERTIA=0.01, Y=0.3'//nl// &
      & '*JOINT, NAME=g, TYPE=TRANSLATIONAL, ANGLE=0.2'//nl//' slide.origin, arm.origin'//nl// &
      & '*JOINT, NAME=pin, TYPE=REVOLUTE'//nl//' block.origin, arm.tip'//nl// &
      & '*JOINT, NAME=j, TYPE=RACK, RADIUS=0.1'//nl//' block.origin, slide.origin'//nl)
   call compare('sliding along a beam', beam//block//'*JOINT, NAME=j, TYPE=SLIDING'//nl//' block.rim, beam'//nl// &
      & '*SPRING, NAME=s, STIFFNESS=60, LENGTH=0.1'//nl//' block.rim, beam.middle'//nl, 2.0e-7_wp)
   call check_sliding_mass()
   call compare('welded beam', beam//block//'*JOINT, NAME=j, TYPE=WELD'//nl//' block.origin, beam.end'//nl)
   call compare('guide on a beam', beam//block//'*JOINT, NAME=j, TYPE=TRANSLATIONAL'//nl//' block.origin, beam.end'//nl// &
      & '*SPRING, NAME=s, STIFFNESS=60, LENGTH=0.1'//nl//' block.rim, beam.middle'//nl)
   call compare('coupled angles', arm//block//spin//'*JOINT, NAME=pin, TYPE=REVOLUTE'//nl//' block.origin, arm.tip'//nl// &
      & '*COUPLER, NAME=j'//nl//' 1.5, angle, arm'//nl//' -0.4, joint_angle, pin'//nl)
   call compare('driven coupler', arm//block//spin//'*JOINT, NAME=pin, TYPE=TRANSLATIONAL'//nl//' block.origin, arm.tip'//nl// &
      & '*COUPLER, NAME=j'//nl//' 0.2, angle, arm'//nl//' 1, displacement, pin'//nl//' 0.15 + 0.1*sin(3*t), value'//nl)
   call compare('coupler of four', arm//block//spin//hand//'*JOINT, NAME=guide, TYPE=TRANSLATIONAL, ANGLE=0.5'//nl// &
      & ' slide.origin, hand.tip'//nl//'*SPRING, NAME=s, STIFFNESS=60, LENGTH=0.1'//nl//' slide.origin, hand.origin'//nl// &
      & '*COUPLER, NAME=j'//nl//' 1, joint_angle, pin'//nl//' -0.7, joint_angle, wrist'//nl//' 0.3, angle, arm'//nl// &
      & ' 2, displacement, guide'//nl)
   call compare('driven coupler of four', arm//block//spin//hand//'*JOINT, NAME=guide, TYPE=WELD'//nl// &
      & ' slide.origin, hand.tip'//nl//'*COUPLER, NAME=j'//nl//' 1, joint_angle, pin'//nl//' -0.7, joint_angle, wrist'//nl// &
      & ' 0.8 + 0.3*sin(5*t), value'//nl)
   call compare('sliders on one body', arm//block//spin//'*RIGID BODY, NAME=slide, MASS=0.5, INERTIA=0.01, Y=0.3'//nl// &
      & '*JOINT, NAME=guide, TYPE=TRANSLATIONAL, ANGLE=0.2'//nl//' slide.origin, arm.tip'//nl// &
      & '*JOINT, NAME=other, TYPE=TRANSLATIONAL, ANGLE=1.2'//nl//' block.origin, arm.tip'//nl// &
      & '*COUPLER, NAME=j'//nl//' 1, displacement, guide'//nl//' -1.4, displacement, other'//nl)
   call compare('coupler on a beam', beam//block//spin//'*RIGID BODY, NAME=slide, MASS=0.5, INERTIA=0.01, Y=0.3'//nl// &
      & '*JOINT, NAME=guide, TYPE=TRANSLATIONAL, ANGLE=0.2'//nl//' slide.origin, beam.middle'//nl// &
      & '*JOINT, NAME=other, TYPE=TRANSLATIONAL, ANGLE=1.2'//nl//' block.origin, beam.end'//nl// &
      & '*COUPLER, NAME=j'//nl//' 1, displacement, guide'//nl//' -1.4, displacement, other'//nl//' 0.1, angle, beam'//nl)
   call compare('driven joint angle', arm//block//motor//'*JOINT, NAME=pin, TYPE=REVOLUTE'//nl//' block.origin, arm.tip'//nl// &
      & '*DRIVER, NAME=j, TYPE=ANGLE, JOINT=pin, LEVEL=ACCELERATION, INITIAL VELOCITY=1'//nl//' 20*sin(9*t)'//nl)
   call compare('driven distance', arm//block//spin//'*DRIVER, NAME=j, TYPE=DISTANCE, POINT=block.rim, TO=arm.tip'//nl// &
      & ' 0.4 + 0.1*cos(6*t)'//nl)
   call compare('driven displacement', arm//block//spin//'*JOINT, NAME=pin, TYPE=TRANSLATIONAL, ANGLE=0.3'//nl// &
      & ' block.origin, arm.tip'//nl//'*DRIVER, NAME=j, TYPE=DISPLACEMENT, JOINT=pin, LEVEL=VELOCITY'//nl//' sin(6*t)'//nl)
   call compare('driven point', arm//block//'*JOINT, NAME=pin, TYPE=REVOLUTE'//nl//' block.origin, arm.tip'//nl// &
      & '*DRIVER, NAME=j, TYPE=X, POINT=block.origin'//nl//' 0.6 - 0.03*sin(3*t)'//nl// &
      & '*DRIVER, NAME=k, TYPE=Y, POINT=block.rim, LEVEL=VELOCITY, INITIAL=0.2'//nl//' 0.1*cos(3*t)'//nl)
   call check_weld()
   call finish()

contains

   !> A welded body as a free body: force and moment of the weld from its accelerations.
   subroutine check_weld()
      integer, parameter :: n = 13
      real(wp), parameter :: mass = 1.5_wp, inertia = 0.02_wp, gravity = 9.81_wp
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp) :: a(2, n), rim(2, n), centre(2, n), d(2, n), c(2, n), force(2, n), turning(n)
      integer :: unit
      open (newunit=unit, file=trim(results)//'.inp', action='write', status='replace')
      write (unit, '(a)') '*HEADING'//nl//' weld'//nl//'*GRAVITY'//nl//arm//block//spin//motor// &
         & '*JOINT, NAME=j, TYPE=WELD'//nl//' block.origin, arm.tip'//nl//'*DYNAMICS, END=0.6, OUTPUTS=12, TOLERANCE=1e-10'//nl// &
         & '*OUTPUT'//nl//' fx = force_x(j), fy = force_y(j), m = moment(j), t1 = 0.3*cos(5*angle(block))'//nl// &
         & ' ax = ax(block), ay = ay(block), rx = ax(block.rim), ry = ay(block.rim)'//nl// &
         & ' cx = ax(block.centre), cy = ay(block.centre)'//nl// &
         & ' dx = x(block.rim) - x(block), dy = y(block.rim) - y(block)'//nl// &
         & ' ex = x(block.centre) - x(block), ey = y(block.centre) - y(block)'
      close (unit)
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
      call check_no_error(error, 'weld')
      if (allocated(error)) return
      call reader%open(trim(results), error)
      a(1, :) = channel(reader, 'ax')
      a(2, :) = channel(reader, 'ay')
      rim(1, :) = channel(reader, 'rx')
      rim(2, :) = channel(reader, 'ry')
      centre(1, :) = channel(reader, 'cx')
      centre(2, :) = channel(reader, 'cy')
      d(1, :) = channel(reader, 'dx')
      d(2, :) = channel(reader, 'dy')
      c(1, :) = channel(reader, 'ex')
      c(2, :) = channel(reader, 'ey')
      turning = (d(1, :)*(rim(2, :) - a(2, :)) - d(2, :)*(rim(1, :) - a(1, :)))/(d(1, :)**2 + d(2, :)**2)
      force = mass*centre
      force(2, :) = force(2, :) + mass*gravity
      call check_close(maxval(abs(channel(reader, 'fx') - force(1, :))), 0.0_wp, 1.0e-10_wp, 'weld: force along x')
      call check_close(maxval(abs(channel(reader, 'fy') - force(2, :))), 0.0_wp, 1.0e-10_wp, 'weld: force along y')
      ! about the centre of mass: inertia times acceleration is moment + applied torque - c x force
      call check_close(maxval(abs(channel(reader, 'm') + channel(reader, 't1') - (c(1, :)*force(2, :) - c(2, :)*force(1, :)) &
         & - inertia*turning)), 0.0_wp, 1.0e-10_wp, 'weld: moment')
      call check(maxval(abs(channel(reader, 'm'))) > 1.0_wp, 'weld: there is one')
      call reader%close()
   end subroutine check_weld

   !> A scene by all integrators.
   subroutine compare(name, scene, rough)
      character(*), intent(in) :: name, scene
      !> How exact the balance of the energy is where a curve or a beam has kinks in its third derivative
      real(wp), intent(in), optional :: rough
      real(wp) :: first(4), other(4), exact
      exact = 1.0e-9_wp
      if (present(rough)) exact = rough
      call run(name, scene, 'ADAMS', '1e-11', exact, first)
      call run(name, scene, 'RADAU', '1e-10', exact, other)
      call check_close(maxval(abs(other - first)), 0.0_wp, 1.0e-6_wp, name//': RADAU comes to the same place')
      call run(name, scene, 'ALPHA', '1e-6', 3.0e-4_wp, other)
      call check_close(maxval(abs(other - first)), 0.0_wp, 1.0e-3_wp, name//': ALPHA comes to the same place')
      call run(name, scene, 'CONSERVING', '1e-6', 1.0e-11_wp, other)
      call check_close(maxval(abs(other - first)), 0.0_wp, 1.0e-2_wp, name//': CONSERVING comes to the same place')
   end subroutine compare

   !> Runs a scene; the balance of its energy; where it comes to.
   subroutine run(name, scene, integrator, tolerance, exact, place)
      character(*), intent(in) :: name, scene, integrator, tolerance
      real(wp), intent(in) :: exact
      real(wp), intent(out) :: place(4)
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report, carrier
      real(wp), allocatable :: energy(:), kinetic(:), values(:)
      character(7), parameter :: names(4) = [character(7) :: 'x', 'y', 'turn', 'carrier']
      integer :: unit, i
      carrier = 'arm'
      if (index(scene, 'NAME=beam') > 0) carrier = 'beam'
      open (newunit=unit, file=trim(results)//'.inp', action='write', status='replace')
      write (unit, '(a)') '*HEADING'//nl//' '//name//nl//'*GRAVITY'//nl//scene//'*DYNAMICS, END=0.6, OUTPUTS=12, '// &
         & 'MAXIMUM STEP=1e-3, INTEGRATOR='//integrator//', TOLERANCE='//tolerance//nl//'*OUTPUT'//nl// &
         & ' x = x(block), y = y(block), turn = angle(block), carrier = angle('//carrier//')'//nl// &
         & ' kinetic = kinetic_energy(system), energy = kinetic_energy(system) + potential_energy(system) - work(system)'
      close (unit)
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
      call check_no_error(error, name//' by '//integrator)
      place = 0.0_wp
      if (allocated(error)) return
      call reader%open(trim(results), error)
      allocate (energy, source=channel(reader, 'energy'))
      allocate (kinetic, source=channel(reader, 'kinetic'))
      print '(a,a12,a,es9.1,a,es9.1)', name//repeat(' ', max(1, 24 - len(name))), integrator, ': energy less work', &
         & maxval(abs(energy - energy(1))), ' of', maxval(kinetic)
      call check(maxval(kinetic) > 0.1_wp, name//': it moves')
      call check_close(maxval(abs(energy - energy(1)))/maxval(kinetic), 0.0_wp, exact, &
         & name//' by '//integrator//': energy less work')
      do i = 1, 4
         values = channel(reader, trim(names(i)))
         place(i) = values(size(values))
      end do
      call reader%close()
   end subroutine run

   !> A mass that slides along a beam is where the beam's own points are when it passes them, also beside a node that a force has
   !> put in. Before, the nodes were taken to be at equal distances: 2e-4 off, and jumps that no step of RADAU could pass at 1e-8.
   subroutine check_sliding_mass()
      character(1), parameter :: points(4) = ['a', 'b', 'c', 'd']
      integer, parameter :: passes(4) = [19, 29, 46, 88]
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp), allocatable :: mass(:), place(:)
      integer :: i
      call run_deck('verification/sliding_mass.inp', trim(results), .true., .true., report, error)
      call check_no_error(error, 'sliding mass')
      call reader%open(trim(results), error)
      call check_no_error(error, 'sliding mass')
      mass = channel(reader, 'y_ball')
      do i = 1, size(points)
         place = channel(reader, 'y_bar_'//points(i))
         call check(abs(mass(passes(i)) - place(passes(i))) <= 1.0e-8_wp*abs(place(passes(i))), 'sliding mass at point '//points(i))
      end do
      call reader%close()
   end subroutine check_sliding_mass

end program test_joints
