!> No false alarms: what is right against a closed form is not warned of, neither where much more energy passes through a scene than
!> it holds, nor at rest, nor where functions follow at rest; and what is wrong still is. Usage, in tests/: test_alarms RESULT_FILE
program test_alarms
   use, intrinsic :: ieee_arithmetic, only: ieee_invalid, ieee_get_halting_mode, ieee_set_halting_mode
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text, newline
   use limber_commands_run, only: run_deck
   use limber_output_history_reader, only: history_reader_type
   use runs, only: channel
   use testing, only: check, check_no_error, finish
   implicit none
   character(*), parameter :: oscillator = '*POINT MASS, NAME=mass, MASS=1, X=1'//newline// &
      & '*SPRING, NAME=s, STIFFNESS=100, LENGTH=1'
   character(*), parameter :: ends = ' ground.origin, mass'//newline
   character(*), parameter :: beam = '*MATERIAL, NAME=stuff, YOUNG=1e6, DENSITY=1'//newline// &
      & '*SECTION, NAME=bar, SHAPE=GENERAL, AREA=1, INERTIA=1e-6'//newline// &
      & '*BEAM, NAME=beam, MATERIAL=stuff, SECTION=bar, LENGTH=1, SUPPORT=FREE-FREE, CORRECTIONS=YES, GEOMETRIC=LINEAR'// &
      & newline//'*JOINT, NAME=root, TYPE=WELD'//newline//' beam.start, ground.origin'//newline
   character(*), parameter :: lost = 'the energy balance is off by'
   character(256) :: results

   call get_command_argument(1, results)
   call test_forced('RADAU, TOLERANCE=1e-3')
   call test_forced('ALPHA, TOLERANCE=1e-5')
   call test_rest()
   call test_loss()
   call test_corrections()
   call test_wheels()
   call test_ends()
   call test_scalar()
   call test_still()
   call test_turning()
   call test_orbits()
   call test_braked()
   call test_guided()
   call finish()

contains

   !> A mass on a strong damper takes up 50 times the energy that it holds in each second. Once its start is forgotten it moves by
   !> the imaginary part of F e^(i w t)/(k - m w^2 + i c w).
   subroutine test_forced(integrator)
      character(*), intent(in) :: integrator
      real(wp), parameter :: w = 5.0_wp, end = 200.0_wp
      complex(wp) :: amplitude
      real(wp) :: truth
      amplitude = 10.0_wp/cmplx(100.0_wp - w**2, 100.0_wp*w, wp)
      truth = aimag(amplitude*cmplx(cos(w*end), sin(w*end), wp))
      call judge('forced, '//integrator, oscillator//', DAMPING=100'//newline//ends//'*FORCE, NAME=f, POINT=mass'//newline// &
         & ' 10*sin(5*t), 0'//newline//'*DYNAMICS, END=200, OUTPUTS=200, INTEGRATOR='//integrator//newline//'*OUTPUT'//newline// &
         & ' x = x(mass) - 1', truth, 2.0e-3_wp*abs(amplitude), '')
   end subroutine test_forced

   !> Nothing moves: a driver that holds a body, a mass that hangs on its spring, a mass behind an analysis at rest.
   subroutine test_rest()
      character(*), parameter :: weight = '*GRAVITY, Y=-9.81'//newline
      character(*), parameter :: hanging = '*POINT MASS, NAME=mass, MASS=1, Y=-1'//newline// &
         & '*SPRING, NAME=s, STIFFNESS=100, DAMPING=2, LENGTH=1 - 0.0981'//newline//ends
      character(10), parameter :: names(4) = [character(10) :: 'ADAMS', 'RADAU', 'ALPHA', 'CONSERVING']
      character(:), allocatable :: tail
      integer :: i
      tail = ''
      do i = 1, size(names)
         tail = '*DYNAMICS, END=10, OUTPUTS=10, INTEGRATOR='//trim(names(i))//newline//'*OUTPUT'//newline
         call judge('held, '//names(i), weight//'*RIGID BODY, NAME=mass, MASS=1, INERTIA=1'//newline//' hang, 0, 1'//newline// &
            & '*JOINT, NAME=pin, TYPE=REVOLUTE'//newline//' mass.hang, ground.origin'//newline// &
            & '*DRIVER, NAME=d, TYPE=ANGLE, BODY=mass'//newline//' 0.3'//newline//tail//' angle(mass)', 0.3_wp, 1.0e-9_wp, '')
         call judge('hanging, '//names(i), weight//hanging//tail//' y(mass)', -1.0_wp, 1.0e-7_wp, '')
         call judge('behind statics, '//names(i), weight//hanging//'*STATICS'//newline//tail//' y(mass)', -1.0_wp, 1.0e-6_wp, '')
      end do
   end subroutine test_rest

   !> Orbits about a centre, from the apocentre at a distance of one, against Kepler's equation: errors that are small beside the
   !> energy of a close passage are not small beside that of the orbit.
   subroutine test_orbits()
      character(*), parameter :: radau = 'RADAU, TOLERANCE=1e-6', mean = '% of what it is in the mean'
      call test_orbit(0.8_wp, 'AUTO, TOLERANCE=1e-6', 3.0e-4_wp, '')
      call test_orbit(0.5_wp, 'AUTO, TOLERANCE=1e-6', 2.0e-3_wp, '')
      call test_orbit(0.8_wp, 'CONSERVING, TOLERANCE=1e-5', 2.0e-3_wp, '')
      call test_orbit(0.1_wp, radau, 3.0e-4_wp, '')
      call test_orbit(0.02_wp, radau, 3.0e-3_wp, '')
      call test_orbit(0.1_wp, 'AUTO, TOLERANCE=1e-4', 1.5_wp, mean)
      call test_orbit(0.05_wp, 'ALPHA, TOLERANCE=1e-6', 1.0_wp, mean)
      call test_orbit(0.02_wp, 'CONSERVING, TOLERANCE=1e-6', 1.0_wp, mean)
      call test_orbit(0.02_wp, 'ALPHA, TOLERANCE=1e-6', 1.5_wp, mean)
   end subroutine test_orbits

   !> One of them, with the speed at the apocentre: x = a (e - cos E), E - e sin E = pi + n t, and the energy -1/(2a).
   subroutine test_orbit(speed, integrator, error, warning)
      real(wp), intent(in) :: speed, error
      character(*), intent(in) :: integrator, warning
      real(wp), parameter :: end = 6.0_wp
      real(wp) :: axis, eccentricity, mean, angle
      integer :: round
      axis = 1/(2 - speed**2)
      eccentricity = 1 - speed**2
      mean = modulo(acos(-1.0_wp) + end/axis**1.5_wp, 2*acos(-1.0_wp))
      angle = acos(-1.0_wp)
      do round = 1, 50
         angle = angle - (angle - eccentricity*sin(angle) - mean)/(1 - eccentricity*cos(angle))
      end do
      call judge('orbit from '//as_text(speed, 2)//', '//integrator, '*POINT MASS, NAME=a, MASS=1, X=1, VY='//as_text(speed, 2)// &
         & newline//'*FORCE, NAME=f, POINT=a'//newline//' -x(a)/(x(a)**2+y(a)**2)**1.5, -y(a)/(x(a)**2+y(a)**2)**1.5'//newline// &
         & '*DYNAMICS, END=6, OUTPUTS=50, INTEGRATOR='//integrator//newline//'*OUTPUT'//newline//' x(a)', &
         & axis*(eccentricity - cos(angle)), error, warning)
   end subroutine test_orbit

   !> What is braked from a high speed has a short fast passage as well, and nothing is lost: x = v/c (1 - exp(-c t)).
   subroutine test_braked()
      character(10), parameter :: names(4) = [character(10) :: 'ADAMS', 'RADAU', 'ALPHA', 'CONSERVING']
      integer :: i
      do i = 1, size(names)
         call judge('braked, '//names(i), '*POINT MASS, NAME=a, MASS=1, VX=10'//newline//'*FORCE, NAME=f, POINT=a'//newline// &
            & ' -5*vx(a), 0'//newline//'*DYNAMICS, END=0.8, OUTPUTS=200, TOLERANCE=1e-4, INTEGRATOR='//trim(names(i))//newline// &
            & '*OUTPUT'//newline//' x(a)', 2*(1 - exp(-4.0_wp)), 2.0e-2_wp, '')
      end do
   end subroutine test_braked

   !> A slider-crank whose slider stays on the x axis: the end of the rod has y = 0, whatever vibrations ALPHA steps over, which
   !> accelerations feel.
   subroutine test_guided()
      call judge('guided, ALPHA', '*MATERIAL, NAME=stuff, YOUNG=1.33e9, DENSITY=1200'//newline// &
         & '*SECTION, NAME=tube, SHAPE=TUBE, DIAMETER=22e-3, THICKNESS=2.2e-3'//newline// &
         & '*RIGID BODY, NAME=crank, MASS=1.59, INERTIA=3.1e-3, CENTRE X=0.0525, ANGLE=90 deg'//newline// &
         & ' tip, 0.14, 0'//newline// &
         & '*BEAM, NAME=rod, MATERIAL=stuff, SECTION=tube, LENGTH=0.762, STRAIN FUNCTIONS=1, Y=0.14, ANGLE=-asin(0.14/0.762)'// &
         & newline//'*POINT MASS, NAME=slider, MASS=1.34, X=sqrt(0.762**2 - 0.14**2)'//newline// &
         & '*JOINT, NAME=bearing, TYPE=REVOLUTE'//newline//' crank.origin, ground.origin'//newline// &
         & '*JOINT, NAME=pin, TYPE=REVOLUTE'//newline//' rod.start, crank.tip'//newline// &
         & '*JOINT, NAME=guide, TYPE=POINT ON LINE'//newline//' slider, ground.origin'//newline// &
         & '*JOINT, NAME=end, TYPE=REVOLUTE'//newline//' rod.end, slider'//newline//'*GRAVITY'//newline// &
         & '*SPRING, NAME=s, STIFFNESS=2690, LENGTH=0.459'//newline//' slider, crank.tip'//newline// &
         & '*DYNAMICS, END=0.12, OUTPUTS=20, TOLERANCE=1e-3, INTEGRATOR=ALPHA'//newline//'*OUTPUT'//newline// &
         & ' y(rod.end), x(slider), ay(crank.tip)', 0.0_wp, 1.0e-12_wp, "channel 'ay_crank_tip' may err")
   end subroutine test_guided

   !> A beam that hangs on a torque of next to nothing: nothing moves, and ADAMS still takes the steps of the fastest vibration.
   subroutine test_still()
      character(*), parameter :: rod = '*MATERIAL, NAME=stuff, YOUNG=7e10, DENSITY=2700'//newline// &
         & '*SECTION, NAME=bar, SHAPE=CIRCLE, DIAMETER=13e-3'//newline//'*BEAM, NAME=rod, MATERIAL=stuff, SECTION=bar, '// &
         & 'LENGTH=0.381, ANGLE=-1.35'//newline//'*JOINT, NAME=pin, TYPE=REVOLUTE'//newline//' rod.start, ground.origin'// &
         & newline//'*TORQUE, NAME=w, BODY=rod'//newline//' -0.261*(angle(rod) + 1.35 + 1e-11)'//newline
      call judge('still, ADAMS', rod//'*DYNAMICS, END=3e-2, OUTPUTS=20, INTEGRATOR=ADAMS'//newline//'*OUTPUT'//newline// &
         & ' angle(rod)', -1.35_wp, 1.0e-6_wp, 'ADAMS is bound to steps of')
      call judge('still, AUTO', rod//'*DYNAMICS, END=3e-2, OUTPUTS=20'//newline//'*OUTPUT'//newline//' angle(rod)', -1.35_wp, &
         & 1.0e-6_wp, '')
   end subroutine test_still

   !> A driver that turns a body on a spring by half turns and more in an increment of a static analysis: its end is where the law
   !> says, and the spring has the length of that.
   subroutine test_turning()
      character(8), parameter :: laws(4) = [character(8) :: 'pi*t', '0.9*pi*t', '3*pi*t', '20*pi*t']
      real(wp), parameter :: turned(4) = acos(-1.0_wp)*[1.0_wp, 0.9_wp, 3.0_wp, 20.0_wp]
      character(*), parameter :: arm = '*RIGID BODY, NAME=arm, MASS=1, INERTIA=0.01'//newline//' tip, 1, 0'//newline// &
         & '*JOINT, NAME=pin, TYPE=REVOLUTE'//newline//' arm.origin, ground.origin'//newline//'*GROUND'//newline//' hook, 1, 1'// &
         & newline//'*SPRING, NAME=s, STIFFNESS=1'//newline//' arm.tip, ground.hook'//newline
      integer :: i, increments
      do i = 1, size(laws)
         do increments = 1, 10, 9
            call judge('turned by '//trim(laws(i)), arm//'*DRIVER, NAME=d, TYPE=ANGLE, BODY=arm'//newline//' '//laws(i)//newline// &
               & '*STATICS, INCREMENTS='//as_text(increments)//newline//'*OUTPUT'//newline//' tension(s)', &
               & sqrt((cos(turned(i)) - 1)**2 + (sin(turned(i)) - 1)**2), 1.0e-9_wp, '')
            call judge('angle of '//trim(laws(i)), arm//'*DRIVER, NAME=d, TYPE=ANGLE, BODY=arm'//newline//' '//laws(i)//newline// &
               & '*STATICS, INCREMENTS='//as_text(increments)//newline//'*OUTPUT'//newline//' joint_angle(pin)', turned(i), &
               & 1.0e-9_wp, '')
         end do
      end do
   end subroutine test_turning

   !> A vibration that the integrator damps away: the mass should go on by 0.1 cos 10 t. By itself, beside a damper that does
   !> nothing, and behind another analysis.
   subroutine test_loss()
      character(*), parameter :: still = 'FIXED STEP=0.2, SPECTRAL RADIUS=0, END=20, OUTPUTS=100'//newline//'*OUTPUT'//newline// &
         & ' x = x(mass) - 1'
      character(*), parameter :: moved = '*POINT MASS, NAME=mass, MASS=1, X=1.1'//newline// &
         & '*SPRING, NAME=s, STIFFNESS=100, LENGTH=1'
      character(*), parameter :: idle = '*POINT MASS, NAME=other, MASS=1, Y=1'//newline// &
         & '*SPRING, NAME=r, STIFFNESS=1, DAMPING=1, LENGTH=1'//newline//' ground.origin, other'//newline
      call judge('damped away', moved//newline//ends//'*DYNAMICS, INTEGRATOR=ALPHA, '//still, 0.0_wp, 1.0e-3_wp, lost)
      call judge('with a damper', moved//newline//ends//idle//'*DYNAMICS, INTEGRATOR=ALPHA, '//still, 0.0_wp, 1.0e-3_wp, lost)
      call judge('behind statics', oscillator//newline//ends//'*FORCE, NAME=f, POINT=mass'//newline//' 10*step(1 - t), 0'// &
         & newline//'*STATICS, PERIOD=1'//newline//'*DYNAMICS, INTEGRATOR=ALPHA, '//still, 0.0_wp, 1.0e-3_wp, lost)
   end subroutine test_loss

   !> Corrections of free functions follow a slow force at rest, with few elements as well: F L^3/(3 E I).
   subroutine test_corrections()
      call judge('free functions with corrections', beam//'*FORCE, NAME=tip, POINT=beam.end'//newline// &
         & ' 0, 0.03*smoothstep(t/15)'//newline//'*DYNAMICS, END=20, OUTPUTS=20, TOLERANCE=1e-6, INTEGRATOR=RADAU'//newline// &
         & '*OUTPUT'//newline//' y(beam.end)', 0.01_wp, 3.0e-5_wp, '')
   end subroutine test_corrections

   !> Wheels turn each other; what does not hold their centres is warned of, for then they part.
   subroutine test_wheels()
      character(*), parameter :: first = '*RIGID BODY, NAME=a, MASS=1, INERTIA=0.04, SPIN=10'//newline// &
         & '*JOINT, NAME=pin, TYPE=REVOLUTE'//newline//' a.origin, ground.origin'//newline//'*GROUND'//newline//' post, 0.3, 0'// &
         & newline//'*RIGID BODY, NAME=b, MASS=1, INERTIA=0.01, X=0.3, SPIN='
      character(*), parameter :: pinned = '*JOINT, NAME=pin2, TYPE=REVOLUTE'//newline//' b.origin, ground.post'//newline
      character(*), parameter :: gear = '-20'//newline//'*JOINT, NAME=mesh, TYPE=GEAR, FIRST RADIUS=0.2, SECOND RADIUS=0.1'// &
         & newline//' a.origin, b.origin'//newline
      character(*), parameter :: belt = '20'//newline//'*JOINT, NAME=mesh, TYPE=BELT, FIRST RADIUS=0.2, SECOND RADIUS=0.1'// &
         & newline//' a.origin, b.origin'//newline
      character(*), parameter :: rack = '*RIGID BODY, NAME=a, MASS=1, INERTIA=0.04, SPIN=10, VX=-2, Y=0.2'//newline// &
         & '*JOINT, NAME=mesh, TYPE=RACK, RADIUS=0.2'//newline//' a.origin, ground.origin'//newline
      character(*), parameter :: held = '*JOINT, NAME=height, TYPE=POINT ON LINE'//newline//' a.origin, ground.bar'//newline// &
         & '*GROUND'//newline//' bar, 0, 0.2'//newline
      character(*), parameter :: run = '*GRAVITY'//newline//'*DYNAMICS, END=0.5, OUTPUTS=10'//newline//'*OUTPUT'//newline// &
         & ' spin(a)'//newline
      character(*), parameter :: loose = "nothing holds the centres of joint 'mesh'"
      call judge('gears that are held', first//gear//pinned//run, 10.0_wp, 1.0e-4_wp, '')
      call judge('a gear that is not held', first//gear//run, 0.0_wp, 100.0_wp, loose)
      call judge('a belt that is held', first//belt//pinned//run, 10.0_wp, 1.0e-4_wp, '')
      call judge('a belt that is not held', first//belt//run, 0.0_wp, 100.0_wp, loose)
      call judge('a pinion that is held', rack//held//run, 10.0_wp, 1.0e-4_wp, '')
      call judge('a pinion that is not held', rack//run, 0.0_wp, 100.0_wp, loose)
   end subroutine test_wheels

   !> The root of a negative number, which is not to stop a program that stops at such.
   subroutine test_scalar()
      logical :: halts
      call ieee_get_halting_mode(ieee_invalid, halts)
      call ieee_set_halting_mode(ieee_invalid, .false.)
      call judge('a scalar without value', oscillator//newline//ends//'*DYNAMICS, END=1'//newline//'*OUTPUT'//newline// &
         & ' x = x(mass)'//newline//'*SCALAR'//newline//' bad = sqrt(-last(x))', 1.0_wp, 1.0e-9_wp, "scalar 'bad' has no value")
      call ieee_set_halting_mode(ieee_invalid, halts)
   end subroutine test_scalar

   !> A mass that slides along a beam, with nothing that bends it: told of once it is behind the end, not before; of both ends, of
   !> exact beams and of those with modes.
   subroutine test_ends()
      character(*), parameter :: told = 'slides past the end of beam'
      call slide('', '1', '0.75', 0.95_wp, '')
      call slide('', '1', '2', 2.2_wp, told)
      call slide('', '-1', '1', -0.8_wp, told)
      call slide(', MODES=4', '1', '0.75', 0.95_wp, '')
      call slide(', MODES=4', '1', '2', 2.2_wp, told)
      call slide(', MODES=4', '-1', '1', -0.8_wp, told)
   end subroutine test_ends

   !> From 0.2 with a speed up to an end of the time.
   subroutine slide(model, speed, end, truth, told)
      !> Option of the beam; speed and time; what is told
      character(*), intent(in) :: model, speed, end, told
      real(wp), intent(in) :: truth
      call judge('slide'//model//' to '//end//' at '//speed, '*MATERIAL, NAME=stuff, YOUNG=1e6, DENSITY=1'//newline// &
         & '*SECTION, NAME=bar, SHAPE=GENERAL, AREA=1, INERTIA=1e-4'//newline//'*BEAM, NAME=beam, MATERIAL=stuff, SECTION=bar, '// &
         & 'LENGTH=1'//model//newline//'*JOINT, NAME=wall, TYPE=WELD'//newline//' beam.start, ground.origin'//newline// &
         & '*POINT MASS, NAME=mass, MASS=0.1, X=0.2, VX='//speed//newline//'*JOINT, NAME=along, TYPE=SLIDING'//newline// &
         & ' mass, beam.start'//newline//'*DYNAMICS, END='//end//', OUTPUTS=20'//newline//'*OUTPUT'//newline//' x(mass)', truth, &
         & 1.0e-6_wp, told)
   end subroutine slide

   !> Runs a deck, compares the last sample of its channel with the truth, and looks for a warning.
   subroutine judge(name, deck, truth, error, warning)
      character(*), intent(in) :: name, deck
      !> What is true, and the error that it may have
      real(wp), intent(in) :: truth, error
      !> Part of the warning; empty: there is none
      character(*), intent(in) :: warning
      type(history_reader_type) :: reader
      type(error_type), allocatable :: failure
      real(wp), allocatable :: values(:)
      character(:), allocatable :: report, text
      integer :: unit
      open (newunit=unit, file=trim(results)//'.inp', action='write', status='replace')
      write (unit, '(a)') '*HEADING', ' '//name, deck
      close (unit)
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, failure)
      call check_no_error(failure, name)
      if (allocated(failure)) return
      call reader%open(trim(results), failure)
      call check_no_error(failure, name//': results')
      allocate (values, source=channel(reader, reader%channels(1)%name))
      print '(a,2es12.4)', name//': last value, truth', values(size(values)), truth
      call check(abs(values(size(values)) - truth) <= error, name//': '//as_text(values(size(values)), 6)//' for '// &
         & as_text(truth, 6))
      call reader%read_text('/run/warnings', text, failure)
      call check_no_error(failure, name//': warnings')
      if (warning == '') call check(text == '', name//' has no warning, but: '//text)
      if (warning /= '') call check(index(text, warning) > 0, name//' is warned of: '//text)
      call reader%close()
   end subroutine judge

end program test_alarms
