!> First deflections in balance with springs as stiff as the beams, and far stiffer ones: of a beam in space against the equation
!> of the beam, of two beams on hinges against *STATICS, and of rotating ones by how they go on. Bodies that their joints bend start
!> in the shape of least energy: a shaft and its bearing out of line, a bar that is too short, a leaf spring on a lifted driver.
!> Usage, in tests/: test_first_deflections RESULT_FILE
program test_first_deflections
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: newline, as_text
   use limber_output_history_reader, only: history_reader_type
   use runs, only: channel, run_changed, run_text
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   character(*), parameter :: steel = '*MATERIAL, NAME=steel, YOUNG=2.1e11, DENSITY=7850'//newline// &
      & '*SECTION, NAME=s, SHAPE=CIRCLE, DIAMETER=0.03'//newline//'*JOINT, NAME=wall, TYPE=WELD'//newline// &
      & ' shaft.start, ground.origin'//newline
   character(*), parameter :: shown = newline//'*OUTPUT'//newline//' axial_force(shaft.middle), y(shaft.middle),'// &
      & ' potential_energy(system), force_y(wall)'//newline
   character(256) :: results
   type(history_reader_type) :: reader

   call get_command_argument(1, results)
   call check_free_beam()
   call check_statics()
   call check_rotating()
   call check_hanging()
   call check_shaft('')
   call check_shaft(', GEOMETRIC=K_G, SUPPORT=CLAMPED-FREE, BENDING MODES=4, CORRECTIONS=YES')
   call check_shaft(', SEGMENTS=2')
   call check_bar()
   call check_lifted()
   call check_rope()
   call check_rates()
   call finish()

contains

   !> A force F at the end of a free beam gives it (4 F/m) there; bent by this and by the inertia, the end is F L^3/(30 EI) off the
   !> tangent at the other end; by a torque T it turns by T L/(2 EI).
   subroutine check_free_beam()
      real(wp), parameter :: stiffness(4) = [1.0_wp, 60.0_wp, 6.0e3_wp, 6.0e6_wp], ei = 2.0_wp
      real(wp) :: value(2), force, k
      character(40) :: old(1), new(1)
      integer :: i
      do i = 1, size(stiffness)
         k = stiffness(i)
         old(1) = 'shift = 0'
         new(1) = 'shift = '//as_text(k)
         call run_changed('verification/sprung_beam.inp', trim(results), old, new, reader)
         force = 1.0e-3_wp*k/(1 + k/(30*ei))
         value = channel(reader, 'tip')
         call check_close(value(1), force/(30*ei), 3.0e-4_wp*force/(30*ei), 'deflection of a free beam, stiffness '//as_text(k))
         value = channel(reader, 'pull')
         call check_close(value(1), force, 3.0e-4_wp*force, 'pull of its spring, stiffness '//as_text(k))
         call reader%close()
         old(1) = 'turn = 0'
         new(1) = 'turn = '//as_text(k)
         call run_changed('verification/sprung_beam.inp', trim(results), old, new, reader)
         force = 1.0e-3_wp*k/(1 + k/(2*ei))
         value = channel(reader, 'slope')
         call check_close(abs(value(1)), force/(2*ei), 3.0e-3_wp*force/(2*ei), 'slope of a free beam, stiffness '//as_text(k))
         value = channel(reader, 'torque')
         call check_close(abs(value(1)), force, 3.0e-3_wp*force, 'torque of its spring, stiffness '//as_text(k))
         call reader%close()
      end do
   end subroutine check_free_beam

   !> In frames that are placed where they balance, deflections are those of *STATICS. Without stretch, for which the joints, closed
   !> undeformed, would give way.
   subroutine check_statics()
      character(*), parameter :: deck = 'verification/sprung_arm.inp'
      character(7), parameter :: names(4) = [character(7) :: 'first', 'second', 'middle', 'tip']
      character(120) :: old(4), new(4)
      real(wp), allocatable :: values(:)
      real(wp) :: rest(4)
      integer :: i
      old(:2) = [character(120) :: '*OUTPUT', 'AXIAL MODES=1, GEOMETRIC=K_G']
      new(:2) = [character(120) :: '*STATICS, RAMP=YES'//nl_output(), 'AXIAL MODES=0, GEOMETRIC=LINEAR']
      call run_changed(deck, trim(results), old(:2), new(:2), reader)
      do i = 1, 4
         values = channel(reader, trim(names(i)))
         rest(i) = values(size(values))
      end do
      call reader%close()
      print '(a,4f12.6)', 'statics ', rest
      old = [character(120) :: '*OUTPUT', 'AXIAL MODES=1, GEOMETRIC=K_G', 'first = 0', 'second = 0']
      new = [character(120) :: '*ASSEMBLY, INITIAL DEFLECTIONS=STATIC'//newline//'*DYNAMICS, END=1, OUTPUTS=20'//nl_output(), &
         & 'AXIAL MODES=0, GEOMETRIC=LINEAR', 'first = '//as_text(rest(1)), 'second = '//as_text(rest(2))]
      call run_changed(deck, trim(results), old, new, reader)
      do i = 1, 4
         values = channel(reader, trim(names(i)))
         print '(2a,es9.1)', names(i), ' off by', values(1) - rest(i)
         call check_close(values(1), rest(i), 1.0e-9_wp, trim(names(i))//' as in statics')
         call check_close(maxval(abs(values - rest(i))), 0.0_wp, 1.0e-5_wp, trim(names(i))//' stays there')
      end do
      call check(abs(rest(3)) > 5.0e-3_wp .and. abs(rest(4)) > 3.0e-3_wp, 'there are deflections')
      call reader%close()
   end subroutine check_statics

   !> Away from equilibrium and with speed deflections rest at first: their second derivatives are nought beside those from zero.
   subroutine check_rotating()
      real(wp) :: rest(3), free(3)
      call start_of('STATIC', rest)
      call start_of('ZERO', free)
      print '(a,3es10.2)', 'second derivatives from balance', rest, 'from zero', free
      call check(all(abs(rest) <= 1.0e-4_wp*maxval(abs(free))), 'deflections in balance begin at rest')
   end subroutine check_rotating

   !> Second derivatives of three deflections at the start.
   subroutine start_of(word, second)
      character(*), intent(in) :: word
      real(wp), intent(out) :: second(3)
      character(7), parameter :: names(3) = [character(7) :: 'middle', 'stretch', 'tip']
      real(wp), parameter :: h = 2.0e-5_wp
      character(160) :: old(4), new(4)
      real(wp) :: f(6)
      integer :: i
      old = [character(160) :: '*OUTPUT', 'first = 0', 'second = 0', 'spin = 0']
      new = [character(160) :: '*ASSEMBLY, INITIAL DEFLECTIONS='//word//newline// &
         & '*DYNAMICS, END=1e-4, OUTPUTS=5, INTEGRATOR=ADAMS, TOLERANCE=1e-12'//nl_output(), 'first = 0.5', 'second = -0.3', &
         & 'spin = 1.5']
      call run_changed('verification/sprung_arm.inp', trim(results), old, new, reader)
      do i = 1, 3
         f = channel(reader, trim(names(i)))
         second(i) = (2*f(1) - 5*f(2) + 4*f(3) - f(4))/h**2
      end do
      call reader%close()
   end subroutine start_of

   !> A load that hangs on a rod below the tip of an arm goes with it where the arm sags, and stays there: of all models, also where
   !> a driver holds the arm. The tip of a slender cantilever moves by (M + 3/8 m) g cos(0.6) L^3/(3 EI) across, and more by the
   !> thrust (M + 0.3 m) g sin(0.6) beside Euler's pi^2 EI/(4 L^2).
   subroutine check_hanging()
      character(*), parameter :: section = ', MATERIAL=steel, SECTION=bar', place = ', ANGLE=0.6'
      character(*), parameter :: nodes = newline//'*NODE'//newline//' 1, 0, 0, start'//newline//' 2, 1, 0'//newline// &
         & ' 3, 2, 0, end'//newline//'*ELEMENT'//newline//' 1, 1, 2'//newline//' 2, 2, 3'//newline
      character(*), parameter :: weld = '*JOINT, NAME=foot, TYPE=WELD'//newline//' arm.start, base'//newline
      real(wp), parameter :: pi = acos(-1.0_wp), g = 9.80665_wp, m = 24.96_wp, ei = 2.0e11_wp*0.04_wp**4/12
      real(wp), parameter :: sag = (50 + 0.375_wp*m)*g*cos(0.6_wp)*8/(3*ei), thrust = (50 + 0.3_wp*m)*g*sin(0.6_wp), &
         & buckling = pi**2*ei/16
      character(200) :: arms(4)
      character(:), allocatable :: report
      type(error_type), allocatable :: error
      real(wp), allocatable :: x(:), y(:), across(:)
      integer :: i
      arms = [character(200) :: '*BEAM, NAME=arm, LENGTH=2'//section//place//newline, '*BEAM, NAME=arm, LENGTH=2'//section// &
         & place//', GEOMETRIC=K_G, SUPPORT=CLAMPED-FREE'//newline, '*FRAME, NAME=arm'//section//place, '*FRAME, NAME=arm'// &
         & section//place//', LARGE=YES']
      do i = 1, size(arms)
         if (i > 2) arms(i) = trim(arms(i))//nodes
         call run_text('*MATERIAL, NAME=steel, YOUNG=2e11, DENSITY=7800'//newline// &
            & '*SECTION, NAME=bar, SHAPE=RECTANGLE, WIDTH=0.04, HEIGHT=0.04'//newline// &
            & '*RIGID BODY, NAME=base, MASS=1, INERTIA=1'//newline//trim(arms(i))//newline// &
            & '*POINT MASS, NAME=load, MASS=50, X=2*cos(0.6), Y=2*sin(0.6) - 0.7'//newline// &
            & '*JOINT, NAME=pin, TYPE=REVOLUTE'//newline//' base, ground.origin'//newline//weld// &
            & '*DRIVER, NAME=motor, TYPE=ANGLE, BODY=base'//newline//' 0'//newline//'*JOINT, NAME=rope, TYPE=ROD'//newline// &
            & ' load, arm.end'//newline//'*GRAVITY'//newline//'*ASSEMBLY, INITIAL DEFLECTIONS=STATIC'//newline// &
            & '*DYNAMICS, END=1, OUTPUTS=20'//newline//'*OUTPUT'//newline//' x = x(load) - x(arm.end), y = y(arm.end) - y(load)'// &
            & newline//' across = (2*sin(0.6) - y(arm.end))*cos(0.6) + (x(arm.end) - 2*cos(0.6))*sin(0.6)'//newline, &
            & trim(results), report, error)
         call check_no_error(error, arms(i))
         if (allocated(error)) return
         call reader%open(trim(results), error)
         x = channel(reader, 'x')
         y = channel(reader, 'y')
         across = channel(reader, 'across')
         call check(maxval(abs(x)) < 1.0e-6_wp .and. maxval(abs(y - 0.7_wp)) < 1.0e-6_wp, 'a load hangs still: '//arms(i))
         call check_close(maxval(abs(across)), sag/(1 - thrust/buckling), 2.0e-3_wp*sag, 'and the arm sags: '//arms(i))
         call reader%close()
      end do
   end subroutine check_hanging

   !> A shaft clamped at one end whose bearing at the other is d out of line: a force of 3 E I d/L^3 holds it there, and at rest.
   subroutine check_shaft(model)
      !> Options of the beam
      character(*), intent(in) :: model
      real(wp), parameter :: d = 2.0e-3_wp, ei = 2.1e11_wp*acos(-1.0_wp)*0.03_wp**4/64
      character(:), allocatable :: told
      real(wp), allocatable :: values(:)
      call run_shaft('*BEAM, NAME=shaft, MATERIAL=steel, SECTION=s, LENGTH=1'//model//newline//'*GROUND'//newline// &
         & ' low, 1, -2e-3'//newline//'*JOINT, NAME=bearing, TYPE=POINT ON LINE'//newline//' shaft.end, ground.low'//newline// &
         & '*DYNAMICS, END=0.05, OUTPUTS=50', told)
      call check(index(told, "'shaft") > 0 .and. index(told, 'bent') > 0, 'a bearing out of line is told'//model//': '//told)
      values = channel(reader, 'force_y_wall')
      call check_close(maxval(abs(values)), 3*ei*d, 1.0e-3_wp*3*ei*d, 'force of a bearing out of line'//model)
      call check_close(minval(abs(values)), 3*ei*d, 1.0e-3_wp*3*ei*d, 'and it stays'//model)
      values = channel(reader, 'y_shaft_middle')
      call check_close(values(1), -0.3125_wp*d, 1.0e-3_wp*d, 'shape of a shaft with a bearing out of line'//model)
      values = channel(reader, 'potential_energy_system')
      call check_close(values(1), 1.5_wp*ei*d**2, 1.0e-3_wp*1.5_wp*ei*d**2, 'its energy'//model)
      call reader%close()
   end subroutine check_shaft

   !> A bar between welds that stand 1e-4 of its length too far apart is pulled by 1e-4 E A.
   subroutine check_bar()
      real(wp), parameter :: pull = 1.0e-4_wp*2.1e11_wp*acos(-1.0_wp)*0.03_wp**2/4
      character(:), allocatable :: told
      real(wp), allocatable :: values(:)
      call run_shaft('*BEAM, NAME=shaft, MATERIAL=steel, SECTION=s, LENGTH=1'//newline//'*GROUND'//newline// &
         & ' low, 1.0001, 0'//newline//'*JOINT, NAME=bearing, TYPE=WELD'//newline//' shaft.end, ground.low'//newline// &
         & '*DYNAMICS, END=0.01, OUTPUTS=10', told)
      values = channel(reader, 'axial_force_shaft_middle')
      call check_close(maxval(values), pull, 1.0e-3_wp*pull, 'pull of a bar that is too short')
      call check_close(minval(values), pull, 1.0e-3_wp*pull, 'and it stays')
      call reader%close()
   end subroutine check_bar

   !> A driver holds the end of a shaft aside and lifts it at a steady speed: shape and rates are those of 3 E I y/L^3 from the
   !> start, and nothing vibrates. Deflections cannot be in balance with an inertia that nobody knows: refused with the cause.
   subroutine check_lifted()
      real(wp), parameter :: ei = 2.1e11_wp*acos(-1.0_wp)*0.03_wp**4/64, speed = 0.02_wp
      character(*), parameter :: lifted = '*BEAM, NAME=shaft, MATERIAL=steel, SECTION=s, LENGTH=1'//newline// &
         & '*DRIVER, NAME=bearing, TYPE=Y, POINT=shaft.end'//newline//' 2e-3 + 0.02*t'//newline
      character(:), allocatable :: told
      type(error_type), allocatable :: error
      real(wp), allocatable :: values(:)
      real(wp) :: force
      integer :: i
      call run_shaft(lifted//'*DYNAMICS, END=0.05, OUTPUTS=50', told)
      values = channel(reader, 'force_y_wall')
      do i = 1, size(values)
         force = 3*ei*(2.0e-3_wp + speed*0.05_wp*(i - 1)/(size(values) - 1))
         call check_close(abs(values(i)), force, 0.02_wp*force, 'force of a driver that lifts, sample '//as_text(i))
      end do
      call reader%close()
      call run_text(steel//lifted//'*ASSEMBLY, INITIAL DEFLECTIONS=STATIC'//newline//'*DYNAMICS, END=0.05, OUTPUTS=50'//shown, &
         & trim(results), told, error)
      call check(allocated(error), 'a shaft that goes on to be bent has no balance at the start')
      if (allocated(error)) call check(index(error%message, 'without deflections') > 0, 'it is said why: '//error%message)
   end subroutine check_lifted

   !> A thin rope of 2.3 m between points 2 m apart is a catenary, at rest by *STATICS and from the start of a motion: sag and pull.
   subroutine check_rope()
      character(*), parameter :: rope = '*MATERIAL, NAME=soft, YOUNG=1e8, DENSITY=1000'//newline// &
         & '*SECTION, NAME=s, SHAPE=CIRCLE, DIAMETER=0.002'//newline// &
         & '*BEAM, NAME=rope, MATERIAL=soft, SECTION=s, LENGTH=2.3, FUNCTIONS=20'//newline//'*GROUND'//newline//' far, 2, 0'// &
         & newline//'*JOINT, NAME=left, TYPE=REVOLUTE'//newline//' rope.start, ground.origin'//newline// &
         & '*JOINT, NAME=right, TYPE=REVOLUTE'//newline//' rope.end, ground.far'//newline//'*GRAVITY'//newline
      character(*), parameter :: asked = '*OUTPUT'//newline//' y(rope.middle), force_x(left), force_y(left)'//newline
      character(60), parameter :: analyses(2) = [character(60) :: '*STATICS, INCREMENTS=2', &
         & '*ASSEMBLY, INITIAL DEFLECTIONS=STATIC'//newline//'*DYNAMICS, END=0.1']
      real(wp), parameter :: weight = 1000*9.81_wp*acos(-1.0_wp)*0.002_wp**2/4
      type(error_type), allocatable :: error
      character(:), allocatable :: told
      real(wp), allocatable :: values(:)
      real(wp) :: a
      integer :: i
      ! Parameter of the catenary, 2 a sinh(1/a) = 2.3, by Newton's method
      a = 1.0_wp
      do i = 1, 50
         a = a - (2*a*sinh(1/a) - 2.3_wp)/(2*sinh(1/a) - 2*cosh(1/a)/a)
      end do
      do i = 1, 2
         call run_text(rope//trim(analyses(i))//newline//asked, trim(results), told, error)
         call check_no_error(error, 'a rope')
         if (allocated(error)) return
         call check(index(told, 'starts bent') > 0 .and. index(told, 'CURVATURE') > 0, 'a rope is told of: '//told)
         call reader%open(trim(results), error)
         values = channel(reader, 'y_rope_middle')
         call check_close(values(size(values)), a - a*cosh(1/a), 2.0e-3_wp, 'sag of a rope, '//analyses(i))
         values = channel(reader, 'force_x_left')
         call check_close(values(size(values))/weight, -a, 0.02_wp*a, 'pull of a rope, '//analyses(i))
         values = channel(reader, 'force_y_left')
         call check_close(values(size(values))/weight, 1.15_wp, 1.0e-5_wp, 'half of the weight of a rope, '//analyses(i))
         call reader%close()
      end do
   end subroutine check_rope

   !> A heavy arm that a driver turns slowly out of 45 degrees: its tip sags by C cos(45 deg + t), C = rho A g L^4/(8 E I), and goes
   !> on to do so from the start. At rest it vibrates, which is told where the arm is quicker.
   subroutine check_rates()
      real(wp), parameter :: sag = 9.81_wp*7850/(8*2.1e11_wp*0.03_wp**2/16), rate = sag*sqrt(0.5_wp), dt = 1.0e-5_wp
      character(*), parameter :: scene = '*MATERIAL, NAME=steel, YOUNG=2.1e11, DENSITY=7850'//newline// &
         & '*SECTION, NAME=s, SHAPE=CIRCLE, DIAMETER=0.03'//newline//'*BEAM, NAME=arm, MATERIAL=steel, SECTION=s, LENGTH=1, '// &
         & 'ANGLE=pi/4'
      character(50), parameter :: models(3) = [character(50) :: '', ', GEOMETRIC=LINEAR, SUPPORT=CLAMPED-FREE', '']
      type(error_type), allocatable :: error
      character(:), allocatable :: told
      real(wp), allocatable :: values(:)
      integer :: i
      do i = 1, 3
         call run_text(scene//trim(models(i))//newline//'*JOINT, NAME=hinge, TYPE=REVOLUTE'//newline// &
            & ' arm.start, ground.origin'//newline//'*DRIVER, NAME=motor, TYPE=ANGLE, JOINT=hinge'//newline//' pi/4 + '// &
            & trim(merge('t   ', '20*t', i < 3))//newline//'*GRAVITY'//newline//'*ASSEMBLY, INITIAL DEFLECTIONS='// &
            & trim(merge('FOLLOWING', 'STATIC   ', i < 3))//newline// &
            & '*DYNAMICS, END=2e-5, OUTPUTS=2'//newline//'*OUTPUT'//newline//' u2(arm.end)'//newline, trim(results), told, error)
         call check_no_error(error, 'an arm that turns')
         if (allocated(error)) return
         call check((index(told, 'INITIAL DEFLECTIONS=FOLLOWING') > 0) .eqv. i == 3, 'vibrations that begin are told: '//told)
         if (i == 3) return
         call reader%open(trim(results), error)
         values = channel(reader, 'u2_arm_end')
         call check_close((values(2) - values(1))/dt, rate, 0.02_wp*rate, 'rate of the tip of an arm that turns'//models(i))
         call reader%close()
      end do
   end subroutine check_rates

   !> Runs a scene with a steel shaft that is clamped at its start, and opens the results in `reader`.
   subroutine run_shaft(scene, told)
      character(*), intent(in) :: scene
      character(:), allocatable, intent(out) :: told
      type(error_type), allocatable :: error
      call run_text(steel//scene//shown, trim(results), told, error)
      call check_no_error(error, scene)
      if (allocated(error)) error stop 1
      call reader%open(trim(results), error)
      call check_no_error(error, scene)
   end subroutine run_shaft

   !> The keyword that the blocks are put before.
   function nl_output() result(text)
      character(:), allocatable :: text
      text = newline//'*OUTPUT'
   end function nl_output

end program test_first_deflections
