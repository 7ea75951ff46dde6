!> Exact beams against closed forms: large deflections, buckling, follower loads, steady rotation, tension, internal forces, and a
!> falling soft beam whose energy stays. Usage, in tests/: test_exact RESULT_FILE
program test_exact
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_commands_run, only: run_deck
   use limber_output_history_reader, only: history_reader_type
   use bars, only: nl, wall, pin, roller, guide
   use runs, only: change_deck, channel, run_changed
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   real(wp), parameter :: pi = acos(-1.0_wp)
   character(256) :: results

   call get_command_argument(1, results)
   call check_elastica()
   call check_circle()
   call check_deck()
   call check_follower()
   call check_euler()
   call check_beck()
   call check_rotation()
   call check_tension()
   call check_forces()
   call check_fall()
   call check_sliding()
   call check_coupler()
   call check_watch()
   call check_supports()
   call check_pieces()
   call check_damping()
   call finish()

contains

   !> Runs the bar in a scene; its last sample of a channel.
   subroutine run_bar(functions, scene, reader, coarse, section)
      character(*), intent(in) :: functions, scene
      type(history_reader_type), intent(out) :: reader
      !> Whether it has too few functions, on purpose
      logical, intent(in), optional :: coarse
      !> What the section has in place of its second moment
      character(*), intent(in), optional :: section
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      character(2000) :: new(3)
      logical :: quiet
      new(1) = functions
      new(2) = scene
      new(3) = 'INERTIA=1e-6'
      if (present(section)) new(3) = section
      call change_deck('verification/exact_bar.inp', trim(results)//'.inp', [character(38) :: &
         & 'FUNCTIONS=8, STRAIN FUNCTIONS=0', '** scene', 'INERTIA=1e-6'], new)
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
      call check_no_error(error, scene)
      if (allocated(error)) return
      quiet = index(report, 'warning') == 0
      if (present(coarse)) quiet = quiet .or. (coarse .and. index(report, 'too few functions') > 0)
      call check(quiet, scene//': no warning: '//report)
      call reader%open(trim(results), error)
      call check_no_error(error, scene//': results')
   end subroutine run_bar

   !> Last sample of a channel.
   real(wp) function last(reader, name)
      type(history_reader_type), intent(inout) :: reader
      character(*), intent(in) :: name
      real(wp), allocatable :: values(:)
      allocate (values, source=channel(reader, name))
      last = values(size(values))
   end function last

   !> Twice Euler's load: x/L = 2 E/K - 1, y/L = 2 k/K with the modulus k = 0.95963... of K(k) = pi/sqrt(2).
   subroutine check_elastica()
      type(history_reader_type) :: reader
      real(wp) :: k, first, second
      call modulus(pi/sqrt(2.0_wp), k, first, second)
      call run_bar('FUNCTIONS=8, STRAIN FUNCTIONS=0', wall//'*FORCE, NAME=load, POINT=bar.end'//nl//' -2*t*pi**2/4, 0'//nl// &
         & '*STATICS, INCREMENTS=20'//nl, reader)
      call check_close(last(reader, 'x'), 2*second/first - 1, 1.0e-6_wp, 'x of the elastica')
      call check_close(abs(last(reader, 'y')), 2*k/first, 1.0e-6_wp, 'y of the elastica')
      call reader%close()
   end subroutine check_elastica

   !> Modulus of a complete elliptic integral of the first kind, by bisection, and both integrals, by the arithmetic-geometric mean.
   subroutine modulus(wanted, k, first, second)
      real(wp), intent(in) :: wanted
      real(wp), intent(out) :: k, first, second
      real(wp) :: low, high, a, b, c, sum
      integer :: i, j
      low = 0.0_wp
      high = 1.0_wp - 1.0e-12_wp
      do i = 1, 60
         k = 0.5_wp*(low + high)
         a = 1.0_wp
         b = sqrt(1 - k**2)
         sum = 0.5_wp*k**2
         do j = 0, 7
            c = 0.5_wp*(a - b)
            sum = sum + 2.0_wp**j*c**2
            first = 0.5_wp*(a + b)
            b = sqrt(a*b)
            a = first
         end do
         first = pi/(2*a)
         second = first*(1 - sum)
         if (first < wanted) low = k
         if (first >= wanted) high = k
      end do
   end subroutine modulus

   !> A couple at the tip rolls the bar up: half a circle, a whole one, two of them.
   subroutine check_circle()
      type(history_reader_type) :: reader
      character(2), parameter :: turns(3) = ['1 ', '2 ', '4 ']
      real(wp), parameter :: y(3) = [2/pi, 0.0_wp, 0.0_wp]
      integer :: i
      do i = 1, 3
         call run_bar('FUNCTIONS=6, STRAIN FUNCTIONS=0', wall//'*TORQUE, NAME=load, POINT=bar.end'//nl//' '//trim(turns(i))// &
            & '*pi*t'//nl//'*STATICS, INCREMENTS=5'//nl, reader)
         call check_close(last(reader, 'x'), 0.0_wp, 1.0e-9_wp, 'x of the circle')
         call check_close(last(reader, 'y'), y(i), 1.0e-9_wp, 'y of the circle')
         call check_close(last(reader, 'turn'), pi*2.0_wp**(i - 1), 1.0e-9_wp, 'rotation of the tip')
         call reader%close()
      end do
   end subroutine check_circle

   !> The deck of input: a full circle of radius L/(2 pi), with the moment 2 pi E I/L.
   subroutine check_deck()
      type(history_reader_type) :: reader
      call run_changed('../input/rolled_up.inp', trim(results), [character(1) ::], [character(1) ::], reader)
      call check_close(last(reader, 'x_tip'), 0.0_wp, 1.0e-9_wp, 'x of the tip rolled up')
      call check_close(last(reader, 'y_tip'), 0.0_wp, 1.0e-9_wp, 'y of the tip rolled up')
      call check_close(last(reader, 'turn'), 2*pi, 1.0e-9_wp, 'a full turn')
      call check_close(last(reader, 'moment'), 2*pi, 1.0e-9_wp, 'the moment in the middle')
      call reader%close()
   end subroutine check_deck

   !> A follower force across the tip, P L^2/(E I) = 30: from E I theta'' = -P cos(theta - theta(L)), by quadrature to 1e-12.
   !> Functions that meet the condition of the tip, eq. (2.34), err 7.6e-5 with 10 and 8e-6 with 12; without it 10 erred less than
   !> 2e-5.
   subroutine check_follower()
      type(history_reader_type) :: reader
      call run_bar('FUNCTIONS=12, STRAIN FUNCTIONS=0', wall//'*FORCE, NAME=load, POINT=bar.end, FOLLOWER=YES'//nl// &
         & ' 0, 30*t'//nl//'*STATICS, INCREMENTS=30'//nl, reader)
      call check_close(last(reader, 'x'), 0.47614123713_wp, 2.0e-5_wp, 'x under a follower force')
      call check_close(last(reader, 'y'), -0.20169084011_wp, 2.0e-5_wp, 'y under a follower force')
      call reader%close()
   end subroutine check_follower

   !> Euler's four loads, where the analysis stops: tan x = x of the clamped and pinned one.
   subroutine check_euler()
      type(history_reader_type) :: reader
      real(wp), allocatable :: time(:)
      type(error_type), allocatable :: error
      character(300) :: hold(4)
      real(wp), parameter :: load(4) = [pi**2/4, pi**2, 20.190728556426630_wp, 4*pi**2]
      character(24) :: number
      integer :: i
      hold = [character(300) :: wall, pin//roller, wall//roller, wall//guide]
      do i = 1, 4
         write (number, '(es23.16)') 1.02_wp*load(i)
         call run_bar('FUNCTIONS=8, STRAIN FUNCTIONS=0', trim(hold(i))//nl//'*FORCE, NAME=load, POINT=bar.end'//nl//' -'// &
            & trim(adjustl(number))//'*t, 0'//nl//'*STATICS, INCREMENTS=10, INSTABILITY=STOP'//nl, reader)
         call reader%read_time(time, error)
         call check_close(1.02_wp*time(size(time)), 1.0_wp, 1.0e-6_wp, "one of Euler's loads")
         call reader%close()
         deallocate (time)
      end do
   end subroutine check_euler

   !> Flutter of Beck's column at 20.05095. Functions that meet eq. (2.34) err 1.7e-4 with 6 and 2.7e-5 with 8 (below 5e-5 with 6
   !> without).
   subroutine check_beck()
      type(history_reader_type) :: reader
      real(wp), allocatable :: time(:)
      type(error_type), allocatable :: error
      call run_bar('FUNCTIONS=8, STRAIN FUNCTIONS=0', wall//'*FORCE, NAME=load, POINT=bar.end, FOLLOWER=YES'//nl// &
         & ' -21*t, 0'//nl//'*STATICS, INCREMENTS=10, INSTABILITY=STOP'//nl, reader)
      call reader%read_time(time, error)
      call check_close(21*time(size(time))/20.05095_wp, 1.0_wp, 5.0e-5_wp, "Beck's column")
      call reader%close()
      ! Leipholz's: a load along all of it that follows; by polynomials of degree 27
      call run_bar('FUNCTIONS=8, STRAIN FUNCTIONS=0', wall//'*DISTRIBUTED LOAD, NAME=load, BODY=bar, FOLLOWER=YES'//nl// &
         & ' -42, 0, t'//nl//'*STATICS, INCREMENTS=10, INSTABILITY=STOP'//nl, reader)
      deallocate (time)
      call reader%read_time(time, error)
      call check_close(42*time(size(time))/40.0537365_wp, 1.0_wp, 1.0e-5_wp, "Leipholz's column")
      call reader%close()
   end subroutine check_beck

   !> First frequency of a rotating cantilever in its plane: the square of that across the plane (polynomials of degree 27) less the
   !> speed's. Hub radius 0, 1 and 5, at 11 times the first frequency too.
   subroutine check_rotation()
      type(history_reader_type) :: reader
      real(wp), parameter :: speed(3) = [1.0_wp, 4.0_wp, 12.0_wp], flap(3) = [3.6816468140_wp, 5.5850014209_wp, 13.1701504875_wp]
      integer, parameter :: radius(8) = [0, 1, 1, 1, 5, 5, 5, 5]
      character(11), parameter :: fast(8) = [character(11) :: '38.67616795', '4', '12', '38.67616795', '1', '4', '12', &
         & '38.67616795']
      real(wp), parameter :: across(8) = [39.7623648885_wp, 7.4750477889_wp, 19.7215419341_wp, 61.5481171700_wp, &
         & 4.6241726521_wp, 12.3819027400_wp, 35.2082045573_wp, 111.8371186555_wp]
      real(wp), parameter :: omega(8) = [38.67616795_wp, 4.0_wp, 12.0_wp, 38.67616795_wp, 1.0_wp, 4.0_wp, 12.0_wp, 38.67616795_wp]
      real(wp), parameter :: tolerance(3) = 1.0e-6_wp
      character(2), parameter :: text(3) = ['1 ', '4 ', '12']
      real(wp), allocatable :: frequency(:)
      type(error_type), allocatable :: error
      integer :: i
      do i = 1, 3
         call run_bar('FUNCTIONS=8, STRAIN FUNCTIONS=0', pin//'*DRIVER, NAME=hub, TYPE=ANGLE, BODY=bar'//nl//' 0'//nl// &
            & '*STATICS, ROTATION='//trim(text(i))//', INCREMENTS=5'//nl//'*MODES, NAME=modes, NUMBER=2'//nl, reader)
         call reader%read_numbers('/modes/modes/frequency', frequency, error)
         call check_no_error(error, 'frequencies')
         if (allocated(error)) cycle
         call check_close(frequency(1)/sqrt(flap(i)**2 - speed(i)**2), 1.0_wp, tolerance(i), 'frequency of a rotating cantilever')
         call reader%close()
      end do
      do i = 1, size(radius)
         call run_bar('FUNCTIONS=12, STRAIN FUNCTIONS=0', pin//'*DRIVER, NAME=hub, TYPE=ANGLE, BODY=bar'//nl//' 0'//nl// &
            & '*STATICS, ROTATION='//trim(fast(i))//', CENTRE X=-'//achar(48 + radius(i))//', INCREMENTS=5'//nl// &
            & '*MODES, NAME=modes, NUMBER=2'//nl, reader, .true.)
         call reader%read_numbers('/modes/modes/frequency', frequency, error)
         call check_no_error(error, 'frequencies')
         if (allocated(error)) cycle
         call check_close(frequency(1)/sqrt(across(i)**2 - omega(i)**2), 1.0_wp, 1.0e-4_wp, 'rotating on a hub')
         call reader%close()
      end do
   end subroutine check_rotation

   !> First frequency of a pinned bar under the tension T = 1000: pi sqrt(T + pi^2).
   subroutine check_tension()
      type(history_reader_type) :: reader
      real(wp), allocatable :: frequency(:)
      type(error_type), allocatable :: error
      call run_bar('FUNCTIONS=4, STRAIN FUNCTIONS=0', pin//roller//'*FORCE, NAME=load, POINT=bar.end'//nl//' 1000*t, 0'//nl// &
         & '*STATICS, INCREMENTS=2'//nl//'*MODES, NAME=modes, NUMBER=1'//nl, reader, .true.)
      call reader%read_numbers('/modes/modes/frequency', frequency, error)
      call check_no_error(error, 'frequency')
      call reader%close()
      if (allocated(error)) return
      call check_close(frequency(1)/(pi*sqrt(1000 + pi**2)), 1.0_wp, 1.0e-7_wp, 'frequency under tension')
   end subroutine check_tension

   !> Internal forces of a bar that is bent to half a circle by a force at its tip are those of the force: N, V and M in the middle
   !> follow from the place and rotation there, the moment at the wall is the reaction.
   subroutine check_forces()
      type(history_reader_type) :: reader
      real(wp) :: turn, arm(2)
      real(wp), parameter :: force(2) = [-4.0_wp, 3.0_wp]
      call run_bar('FUNCTIONS=10, STRAIN FUNCTIONS=1', wall//'*FORCE, NAME=load, POINT=bar.end'//nl//' -4*t, 3*t'//nl// &
         & '*STATICS, INCREMENTS=10'//nl//'*OUTPUT'//nl//' n = axial_force(bar.middle), v = shear_force(bar.middle), '// &
         & 'm = bending_moment(bar.middle), foot = bending_moment(bar.start), held = moment(wall), '// &
         & 'turned = rotation(bar.middle), x_middle = x(bar.middle)'//nl, reader)
      turn = last(reader, 'turned')
      arm = [last(reader, 'x') - last(reader, 'x_middle'), last(reader, 'y') - last(reader, 'y_middle')]
      call check(turn > 0.5_wp, 'the bar bends much')
      call check_close(last(reader, 'n'), cos(turn)*force(1) + sin(turn)*force(2), 1.0e-8_wp, 'axial force')
      call check_close(last(reader, 'v'), cos(turn)*force(2) - sin(turn)*force(1), 1.0e-8_wp, 'shear force')
      call check_close(last(reader, 'm'), arm(1)*force(2) - arm(2)*force(1), 1.0e-8_wp, 'bending moment')
      call check_close(abs(last(reader, 'foot')), abs(last(reader, 'held')), 1.0e-8_wp, 'moment at the wall')
      call reader%close()
   end subroutine check_forces

   !> A soft pendulum falls as a rope does: energy stays, by three integrators, and they agree.
   subroutine check_fall()
      type(history_reader_type) :: reader
      character(5), parameter :: integrators(3) = ['ADAMS', 'RADAU', 'ALPHA']
      real(wp), parameter :: tolerance(3) = [1.0e-8_wp, 1.0e-7_wp, 1.0e-5_wp], agreed(3) = [0.0_wp, 1.0e-6_wp, 5.0e-4_wp]
      character(4), parameter :: text(3) = ['1e-9', '1e-7', '1e-6']
      real(wp), allocatable :: energy(:)
      real(wp) :: tip(2)
      integer :: i
      tip = 0.0_wp
      do i = 1, 3
         call run_bar('FUNCTIONS=4, STRAIN FUNCTIONS=1', pin//'*GRAVITY, Y=-100'//nl//'*DYNAMICS, INTEGRATOR='//integrators(i)// &
            & ', END=0.25, TOLERANCE='//text(i)//', OUTPUTS=50'//nl//'*OUTPUT'//nl// &
            & ' energy = kinetic_energy(system) + potential_energy(system)'//nl, reader, .true.)
         allocate (energy, source=channel(reader, 'energy'))
         call check(maxval(abs(energy)) <= 50*tolerance(i), 'the energy of a falling beam stays')
         if (i == 1) tip = [last(reader, 'x'), last(reader, 'y')]
         call check_close(last(reader, 'x'), tip(1), agreed(i), 'x of the tip, '//integrators(i))
         call check_close(last(reader, 'y'), tip(2), agreed(i), 'y of the tip, '//integrators(i))
         call reader%close()
         deallocate (energy)
      end do
   end subroutine check_fall

   !> A point that slides without friction along a cantilever, at a given x = 0.6, pressed down by 2.1 E I/L^2: elastica with a
   !> force normal to the axis at its end, integrated to 1e-11 elsewhere. Behind the point the bar is straight and free of forces.
   subroutine check_sliding()
      type(history_reader_type) :: reader
      call run_bar('FUNCTIONS=16, STRAIN FUNCTIONS=0', wall//'*POINT MASS, NAME=bead, MASS=1, X=0.6'//nl// &
         & '*JOINT, NAME=slide, TYPE=SLIDING'//nl//' bead.origin, bar.end'//nl//'*DRIVER, NAME=place, TYPE=X, POINT=bead.origin'// &
         & nl//' 0.6'//nl//'*FORCE, NAME=load, POINT=bead.origin'//nl//' 0, -2.1*t'//nl//'*STATICS, INCREMENTS=5'//nl// &
         & '*OUTPUT'//nl//' low = y(bead), push = force_x(slide), foot = bending_moment(bar.start), '// &
         & 'middle = bending_moment(bar.middle), tip = bending_moment(bar.end), v = shear_force(bar.middle)'//nl, reader)
      call check_close(last(reader, 'low'), -0.197675029_wp, 1.0e-4_wp, 'place of a point that slides')
      call check_close(last(reader, 'push'), 1.087882_wp, 1.0e-3_wp, 'force of a point that slides')
      call check_close(last(reader, 'foot'), -1.475047_wp, 1.0e-3_wp, 'moment at the wall')
      call check_close(last(reader, 'middle'), -54.47596673_wp*0.006_wp, 1.0e-3_wp, 'moment before the point')
      call check_close(last(reader, 'tip'), 0.0_wp, 1.0e-12_wp, 'moment behind the point')
      call check_close(last(reader, 'x') - 0.9212443_wp, 0.0_wp, 1.0e-4_wp, 'x of the end')
      call check_close(last(reader, 'y') + 0.3640921_wp, 0.0_wp, 1.0e-4_wp, 'y of the end')
      call reader%close()
   end subroutine check_sliding

   !> A coupler of two wheels on a cantilever, (first) + 2 (second) = const, a torque of 0.2 on the second: its couples on the
   !> sections are 0.1 at the end and 0.2 in the middle.
   subroutine check_coupler()
      type(history_reader_type) :: reader
      call run_bar('FUNCTIONS=4, STRAIN FUNCTIONS=0', wall//'*RIGID BODY, NAME=first, MASS=1, INERTIA=1, X=1'//nl// &
         & '*RIGID BODY, NAME=second, MASS=1, INERTIA=1, X=0.5'//nl//'*JOINT, NAME=one, TYPE=REVOLUTE'//nl// &
         & ' first.origin, bar.end'//nl//'*JOINT, NAME=two, TYPE=REVOLUTE'//nl//' second.origin, bar.middle'//nl// &
         & '*COUPLER, NAME=mesh'//nl//' 1, joint_angle, one'//nl//' 2, joint_angle, two'//nl//'*TORQUE, NAME=motor, BODY=second'// &
         & nl//' 0.2*t'//nl//'*SPRING, NAME=grip, TYPE=ROTATIONAL, STIFFNESS=1'//nl//' first.origin, ground.origin'//nl// &
         & '*STATICS, INCREMENTS=2'//nl//'*OUTPUT'//nl//' foot = bending_moment(bar.start), '// &
         & 'tip = bending_moment(bar.end)'//nl, reader)
      call check_close(last(reader, 'foot'), 0.3_wp, 1.0e-8_wp, 'couples of a coupler on two sections')
      call check_close(last(reader, 'tip'), 0.1_wp, 1.0e-8_wp, 'couple of a coupler at the end')
      ! EI theta' = 0.3 up to the middle, 0.1 behind it
      call check_close(last(reader, 'turn'), 0.2_wp, 1.0e-8_wp, 'rotation of the end')
      call reader%close()
   end subroutine check_coupler

   !> Three frequencies with the default functions, whatever holds or loads the ends, against the equations of beams: cantilever
   !> (cos x cosh x = -1), with a guide (tan x = -tanh x), a slot, two walls, a spring of 30 E I/L^3, and a bar on pins.
   subroutine check_supports()
      character(*), parameter :: spring = '*BUSHING, NAME=spring, STIFFNESS Y=30'//nl//' bar.end, ground.far'//nl
      character(*), parameter :: across = '*JOINT, NAME=guide, TYPE=TRANSLATIONAL, TURN=0, ANGLE=90 deg'//nl// &
         & ' bar.end, ground.far'//nl
      character(*), parameter :: force = '*FORCE, NAME=load, POINT=bar.end'//nl//' 0, 0'//nl
      character(*), parameter :: couple = '*TORQUE, NAME=twist, POINT=bar.end'//nl//' 0'//nl
      real(wp), parameter :: free(3) = [1.8751040687120_wp, 4.6940911329742_wp, 7.8547574382376_wp]
      real(wp), parameter :: slot(3) = [3.9266023120479_wp, 7.0685827456287_wp, 10.210176122813_wp]
      call check_frequencies(wall//force, free, 'a force at a free end')
      call check_frequencies(wall//couple, free, 'a couple at a free end')
      call check_frequencies(wall//across, [2.3650203724314_wp, 5.4978039190008_wp, 8.6393798286997_wp], 'a guide across')
      call check_frequencies(wall//roller, slot, 'a slot')
      call check_frequencies(wall//roller//couple, slot, 'a couple at a slot')
      call check_frequencies(wall//guide, [4.7300407448627_wp, 7.8532046240958_wp, 10.995607838002_wp], 'a guide along')
      call check_frequencies(wall//spring, [3.1676545031673_wp, 5.0011192191883_wp, 7.9189612236963_wp], 'a spring')
      call check_frequencies(pin//roller//couple, pi*[1, 2, 3], 'a couple at a pin')
   end subroutine check_supports

   !> A cantilever in pieces under a force and a couple in its middle, within the second piece: F a^2 (3 L - a)/6 + C a (L - a/2) at
   !> the tip, in units of E I; with shear F a/(kappa G A) more, kappa G A = 0.8 E A/2.6.
   subroutine check_pieces()
      type(history_reader_type) :: reader
      character(*), parameter :: loads = '*FORCE, NAME=load, POINT=bar.middle'//nl//' 0, 1e-3*t'//nl//'*TORQUE, NAME=twist, '// &
         & 'POINT=bar.middle'//nl//' 2e-4*t'//nl//'*STATICS'//nl
      real(wp), parameter :: tip = 1.0e-3_wp*0.25_wp*2.5_wp/6 + 2.0e-4_wp*0.5_wp*0.75_wp
      call run_bar('SEGMENTS=3, FUNCTIONS=4', wall//loads, reader)
      call check_close(last(reader, 'y')/tip, 1.0_wp, 1.0e-7_wp, 'loads on a piece')
      call reader%close()
      call run_bar('SEGMENTS=3, FUNCTIONS=4, SHEAR=YES', wall//loads, reader, .false., 'INERTIA=1e-6, SHEAR FACTOR=0.8')
      call check_close(last(reader, 'y')/(tip + 0.5e-3_wp*2.6_wp/0.8e6_wp), 1.0_wp, 1.0e-7_wp, 'shear of pieces')
      call reader%close()
   end subroutine check_pieces

   !> Damping ratios of a cantilever and of a bar on pins: as given, alpha/(2 omega), beta omega/2.
   subroutine check_damping()
      real(wp), parameter :: free(2) = [1.8751040687120_wp, 4.6940911329742_wp]**2, pinned(2) = [pi, 2*pi]**2
      call check_ratios(wall, 'RATIO=0.02', [0.02_wp, 0.02_wp])
      call check_ratios(wall, 'RAYLEIGH ALPHA=0.3', 0.15_wp/free)
      call check_ratios(wall, 'RAYLEIGH BETA=1e-3', 5.0e-4_wp*free)
      call check_ratios(wall, 'RATIO=0'//nl//' 2, 0.05', [0.0_wp, 0.05_wp])
      call check_ratios(pin//roller, 'RATIO=0.02', [0.02_wp, 0.02_wp])
      call check_ratios(pin//roller, 'RAYLEIGH ALPHA=0.3', 0.15_wp/pinned)
      call check_ratios(pin//roller, 'RAYLEIGH BETA=1e-3', 5.0e-4_wp*pinned)
   end subroutine check_damping

   !> First two damping ratios of the bar.
   subroutine check_ratios(held, damping, ratios)
      character(*), intent(in) :: held, damping
      real(wp), intent(in) :: ratios(2)
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: ratio(:)
      call run_bar('X=0', held//'*DAMPING, BODY=bar, '//damping//nl//'*MODES, NAME=modes, NUMBER=2, DAMPED=YES'//nl, reader)
      call reader%read_numbers('/modes/modes/damping_ratio', ratio, error)
      call check_no_error(error, damping)
      if (allocated(error)) return
      call check(maxval(abs(ratio(:2) - ratios)) <= 1.0e-6_wp, 'damping ratios of '//damping)
      call reader%close()
   end subroutine check_ratios

   !> First three frequencies of the bar, L sqrt(omega sqrt(rho A/(E I))) of them being given.
   subroutine check_frequencies(scene, waves, what)
      character(*), intent(in) :: scene, what
      real(wp), intent(in) :: waves(3)
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: frequency(:)
      call run_bar('X=0', scene//'*MODES, NAME=modes, NUMBER=3'//nl, reader)
      call reader%read_numbers('/modes/modes/frequency', frequency, error)
      call check_no_error(error, what)
      if (allocated(error)) return
      print '(a,3es10.2)', what//': errors of frequencies', frequency(:3)/waves**2 - 1
      call check(maxval(abs(frequency(:3)/waves**2 - 1)) <= 5.0e-4_wp, 'frequencies with '//what)
      call reader%close()
   end subroutine check_frequencies

   !> Too few functions are warned of: of a follower force (deflections 0.2 off with two, 0.01 with four, known from 16), a
   !> cantilever that does not stretch under an axial force, a stretch that is not constant.
   subroutine check_watch()
      character(*), parameter :: follower = wall//'*FORCE, NAME=load, POINT=bar.end, FOLLOWER=YES'//nl//' 0, 20*t'//nl// &
         & '*STATICS, INCREMENTS=10'//nl
      character(*), parameter :: pull = wall//'*FORCE, NAME=load, POINT=bar.end'//nl//' 1000*t, 0'//nl//'*STATICS'//nl
      character(*), parameter :: inner = wall//'*FORCE, NAME=load, POINT=bar.middle'//nl//' 1000*t, 0'//nl//'*STATICS'//nl
      call check(.not. warns('FUNCTIONS=7, STRAIN FUNCTIONS=0', follower, 'too few'), 'seven functions are enough')
      call check(warns('FUNCTIONS=2, STRAIN FUNCTIONS=0', follower, 'of the angle'), 'two functions are too few')
      call check(warns('FUNCTIONS=2, STRAIN FUNCTIONS=0', follower, 'use FUNCTIONS=4'), 'the remedy')
      call check(warns('FUNCTIONS=2, STRAIN FUNCTIONS=0', pull, 'of the strain'), 'a beam that cannot stretch')
      call check(.not. warns('FUNCTIONS=2, STRAIN FUNCTIONS=1', pull, 'too few'), 'a beam that stretches evenly')
      call check(warns('FUNCTIONS=2, STRAIN FUNCTIONS=1', inner, 'use STRAIN FUNCTIONS=3'), 'a stretch that is not constant')
   end subroutine check_watch

   !> Whether a scene of the bar warns with some words.
   logical function warns(functions, scene, words)
      character(*), intent(in) :: functions, scene, words
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      character(2000) :: new(2)
      new(1) = functions
      new(2) = scene
      call change_deck('verification/exact_bar.inp', trim(results)//'.inp', [character(38) :: &
         & 'FUNCTIONS=8, STRAIN FUNCTIONS=0', '** scene'], new)
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
      call check_no_error(error, scene)
      warns = .false.
      if (.not. allocated(error)) warns = index(report, words) > 0
   end function warns

end program test_exact
