!> Steps of RADAU are bound to what moves: they go over vibrations that are hardly excited, and follow those that are, or that
!> become the motion. References: ADAMS, which shares nothing with it but the equations; a mass on a spring. Usage, in tests/:
!> test_steps RESULT_FILE
program test_steps
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_output_history_reader, only: history_reader_type
   use runs, only: channel, run_text
   use testing, only: check, check_no_error, finish
   implicit none
   character(*), parameter :: nl = new_line('a')
   !> The default beam of steel on a hinge, let go from level: its fastest vibrations, at some thousand rad/s, move it by less than
   !> a millionth of its length
   character(*), parameter :: arm = '*MATERIAL, NAME=steel, YOUNG=200e9, DENSITY=7870'//nl// &
      & '*SECTION, NAME=round, SHAPE=CIRCLE, DIAMETER=0.1'//nl//'*BEAM, NAME=arm, MATERIAL=steel, SECTION=round, LENGTH=10'//nl// &
      & '*JOINT, NAME=hinge, TYPE=REVOLUTE'//nl//' arm.start, ground.origin'//nl//'*GRAVITY'//nl
   !> A light and a heavy body fall as a pendulum of rods, beside a spring
   character(*), parameter :: rods = '*POINT MASS, NAME=p, MASS=1e-4, X=1'//nl//'*POINT MASS, NAME=q, MASS=10, X=2'//nl// &
      & '*JOINT, NAME=s, TYPE=ROD'//nl//' p, ground.origin'//nl//'*JOINT, NAME=r, TYPE=ROD'//nl//' p, q'//nl// &
      & '*POINT MASS, NAME=z, MASS=1e-4, X=-1'//nl//'*SPRING, NAME=c, STIFFNESS=1e4, LENGTH=1'//nl//' z, ground.origin'//nl
   character(256) :: results

   call get_command_argument(1, results)
   call check_arm()
   call check_speeds()
   call check_spring()
   call check_relaxed()
   call check_damped_beam()
   call check_tension('springs, 0.1 g', springs('1e-4'), '1e-4', 3.0e-4_wp)
   call check_tension('springs, 0.3 g', springs('3e-4'), '1e-3', 5.0e-4_wp)
   call check_tension('rods', rods, '1e-6', 3.0e-4_wp)
   call finish()

contains

   !> A part of the steps that its fastest vibrations would ask for, and an error of the size of the tolerance.
   subroutine check_arm()
      character(*), parameter :: output = '*OUTPUT'//nl//' x = x(arm.end), w = deflection(arm.middle)'//nl
      real(wp), allocatable :: x(:, :), w(:, :)
      real(wp) :: steps
      call run_scene('arm', arm//'*DYNAMICS, END=1, OUTPUTS=50, TOLERANCE=1e-9, INTEGRATOR=ADAMS'//nl//output)
      call take(1, x, w)
      call run_scene('arm', arm//'*DYNAMICS, END=1, OUTPUTS=50, TOLERANCE=1e-6, INTEGRATOR=RADAU'//nl//output, steps)
      call take(2, x, w)
      print '(a, f8.0, 2es10.2)', 'arm: steps, errors', steps, maxval(abs(x(:, 2) - x(:, 1)))/10, &
         & maxval(abs(w(:, 2) - w(:, 1)))/maxval(abs(w(:, 1)))
      call check(steps < 5000, 'a vibration that is hardly excited does not bind the steps')
      call check(maxval(abs(x(:, 2) - x(:, 1))) <= 1.0e-6_wp, 'the arm moves as with ADAMS')
      call check(maxval(abs(w(:, 2) - w(:, 1))) <= 1.0e-5_wp*maxval(abs(w(:, 1))), 'the arm bends as with ADAMS')
   end subroutine check_arm

   !> Where a channel is a speed, the rates of fast vibrations count: the error is still one of the size of the tolerance.
   subroutine check_speeds()
      character(*), parameter :: output = '*OUTPUT'//nl//' x = vx(arm.end), w = spin(arm)'//nl
      real(wp), allocatable :: x(:, :), w(:, :)
      call run_scene('speeds', arm//'*DYNAMICS, END=0.2, OUTPUTS=50, TOLERANCE=1e-9, INTEGRATOR=ADAMS'//nl//output)
      call take(1, x, w)
      call run_scene('speeds', arm//'*DYNAMICS, END=0.2, OUTPUTS=50, TOLERANCE=1e-5, INTEGRATOR=RADAU'//nl//output)
      call take(2, x, w)
      print '(a, 2es10.2)', 'speeds: errors', maxval(abs(x(:, 2) - x(:, 1)))/maxval(abs(x(:, 1))), &
         & maxval(abs(w(:, 2) - w(:, 1)))/maxval(abs(w(:, 1)))
      call check(maxval(abs(x(:, 2) - x(:, 1))) <= 1.0e-5_wp*maxval(abs(x(:, 1))), 'the speed of the tip')
      call check(maxval(abs(w(:, 2) - w(:, 1))) <= 1.0e-4_wp*maxval(abs(w(:, 1))), 'the spin of the section at the hinge')
   end subroutine check_speeds

   !> A mass on a stiff spring that is struck: x = 1 + sin(1000 t)/100 over 16 periods.
   subroutine check_spring()
      real(wp), allocatable :: x(:, :), w(:, :)
      real(wp) :: off
      integer :: i
      call run_scene('spring', '*POINT MASS, NAME=bob, MASS=1, X=1, VX=10'//nl// &
         & '*SPRING, NAME=spring, STIFFNESS=1e6, LENGTH=1'//nl//' ground.origin, bob'//nl// &
         & '*DYNAMICS, END=0.1, OUTPUTS=50, TOLERANCE=1e-6, INTEGRATOR=RADAU'//nl//'*OUTPUT'//nl//' x = x(bob), w = y(bob)'//nl)
      call take(1, x, w)
      off = maxval(abs(x(:, 1) - [(1 + 0.01_wp*sin(2.0_wp*i), i=0, 50)]))
      print '(a, es10.2)', 'spring: error', off
      call check(off <= 2.0e-5_wp, 'a vibration that is excited is followed')
   end subroutine check_spring

   !> A mass behind a stiff damper, and a push that comes at once: the pull of both is the push before the first step has ended,
   !> while the motion is slow. Samples within that step show it.
   subroutine check_relaxed()
      real(wp), parameter :: stiffness = 4.0e7_wp, damping = 2.0e6_wp, jump = 0.098_wp
      real(wp), allocatable :: x(:, :), w(:, :)
      real(wp) :: fast, slow, t, off, pull
      integer :: i
      call run_scene('relaxed', '*POINT MASS, NAME=bob, MASS=1, X=1'//nl// &
         & '*SPRING, NAME=spring, STIFFNESS=4e7, DAMPING=2e6, LENGTH=1'//nl//' ground.origin, bob'//nl// &
         & '*FORCE, NAME=push, POINT=bob'//nl//' step(t - 0.098), 0'//nl// &
         & '*DYNAMICS, END=0.5, OUTPUTS=50, INTEGRATOR=RADAU'//nl//'*OUTPUT'//nl//' x = tension(spring), w = x(bob) - 1'//nl)
      call take(1, x, w)
      fast = 0.5_wp*damping + sqrt(0.25_wp*damping**2 - stiffness)
      slow = stiffness/fast
      off = 0.0_wp
      do i = 0, 50
         t = max(0.0_wp, 0.01_wp*i - jump)
         ! k u + c u' of u = (1 + (slow exp(-fast t) - fast exp(-slow t))/(fast - slow))/k
         pull = 1 + (slow*exp(-fast*t) - fast*exp(-slow*t))/(fast - slow) &
            & + damping/stiffness*fast*slow*(exp(-slow*t) - exp(-fast*t))/(fast - slow)
         off = max(off, abs(x(i + 1, 1) - pull))
      end do
      print '(a, es10.2)', 'relaxed: error', off
      call check(off <= 0.5_wp, 'the pull of a damper right behind a jump of the load')
   end subroutine check_relaxed

   !> The same of a damped beam whose vibrations all creep but the slowest ones: moment and shear force behind short pulses.
   subroutine check_damped_beam()
      character(*), parameter :: beam = '*MATERIAL, NAME=stuff, YOUNG=1e6, DENSITY=1'//nl// &
         & '*SECTION, NAME=bar, SHAPE=GENERAL, AREA=1, INERTIA=1e-6'//nl// &
         & '*BEAM, NAME=bar, MATERIAL=stuff, SECTION=bar, LENGTH=1, FUNCTIONS=28'//nl// &
         & '*JOINT, NAME=wall, TYPE=WELD, TURN=0'//nl//' bar.start, ground.origin'//nl//'*FORCE, NAME=f, POINT=bar.middle'//nl// &
         & ' 0, 1e-3*(step(t-0.1)*step(0.11-t) + step(t-0.3)*step(0.31-t))'//nl//'*DAMPING, BODY=bar, RAYLEIGH BETA=1e-2'//nl
      character(*), parameter :: output = '*OUTPUT'//nl//' x = bending_moment(bar.start), w = shear_force(bar.middle)'//nl
      real(wp), allocatable :: x(:, :), w(:, :)
      call run_scene('beam', beam// &
         & '*DYNAMICS, END=0.4, OUTPUTS=50, TOLERANCE=1e-8, MAXIMUM STEP=2e-4, INTEGRATOR=RADAU'//nl//output)
      call take(1, x, w)
      call run_scene('beam', beam//'*DYNAMICS, END=0.4, OUTPUTS=50, INTEGRATOR=RADAU'//nl//output)
      call take(2, x, w)
      print '(a, 2es10.2)', 'damped beam: errors', maxval(abs(x(:, 2) - x(:, 1)))/maxval(abs(x(:, 1))), &
         & maxval(abs(w(:, 2) - w(:, 1)))/maxval(abs(w(:, 1)))
      call check(maxval(abs(x(:, 2) - x(:, 1))) <= 3.0e-3_wp*maxval(abs(x(:, 1))), 'the moment of a damped beam behind pulses')
      call check(maxval(abs(w(:, 2) - w(:, 1))) <= 1.0e-2_wp*maxval(abs(w(:, 1))), 'the shear force of a damped beam behind pulses')
   end subroutine check_damped_beam

   !> The same on springs, of a mass of the light body [kg].
   function springs(mass) result(text)
      character(*), intent(in) :: mass
      character(:), allocatable :: text
      text = '*POINT MASS, NAME=p, MASS='//mass//', X=1'//nl//'*POINT MASS, NAME=q, MASS=10, X=2'//nl// &
         & '*SPRING, NAME=s, STIFFNESS=1e4, LENGTH=1'//nl//' p, ground.origin'//nl// &
         & '*SPRING, NAME=r, STIFFNESS=1e4, LENGTH=1'//nl//' p, q'//nl
   end function springs

   !> The light body vibrates fast across springs or rods as long as they pull. Where the pendulum turns back they let go: where it
   !> goes then depends on its speed.
   subroutine check_tension(name, scene, tolerance, allowed)
      character(*), intent(in) :: name, scene, tolerance
      !> Error of the place of the light body [m]
      real(wp), intent(in) :: allowed
      character(*), parameter :: dynamics = '*GRAVITY'//nl//'*DYNAMICS, END=2, OUTPUTS=50, INTEGRATOR=', &
         & output = nl//'*OUTPUT'//nl//' x = y(q), w = y(p)'//nl
      real(wp), allocatable :: x(:, :), w(:, :)
      call run_scene(name, scene//dynamics//'ADAMS, TOLERANCE=1e-10'//output)
      call take(1, x, w)
      call run_scene(name, scene//dynamics//'RADAU, TOLERANCE='//tolerance//output)
      call take(2, x, w)
      print '(2a, 2es10.2)', name, ': errors', maxval(abs(x(:, 2) - x(:, 1))), maxval(abs(w(:, 2) - w(:, 1)))
      call check(maxval(abs(w(:, 2) - w(:, 1))) <= allowed, name//': the light body')
      call check(maxval(abs(x(:, 2) - x(:, 1))) <= 0.1_wp*allowed, name//': the heavy body')
   end subroutine check_tension

   !> The channels x and w of the last run into a column of two tables.
   subroutine take(column, x, w)
      integer, intent(in) :: column
      !> (51, 2)
      real(wp), allocatable, intent(inout) :: x(:, :), w(:, :)
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      if (.not. allocated(x)) allocate (x(51, 2), w(51, 2))
      call reader%open(trim(results), error)
      call check_no_error(error, 'results')
      x(:, column) = channel(reader, 'x')
      w(:, column) = channel(reader, 'w')
      call reader%close()
   end subroutine take

   !> Runs a scene; its number of steps.
   subroutine run_scene(name, text, steps)
      character(*), intent(in) :: name, text
      real(wp), intent(out), optional :: steps
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call run_text(text, trim(results), report, error)
      call check_no_error(error, name)
      if (allocated(error)) error stop 1
      if (.not. present(steps)) return
      call reader%open(trim(results), error)
      call check_no_error(error, name)
      call reader%read_statistic('steps', steps, error)
      call check_no_error(error, name//': steps')
      call reader%close()
   end subroutine run_scene

end program test_steps
