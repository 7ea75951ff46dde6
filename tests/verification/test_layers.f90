!> Exact beams under so much tension that they bend only within a small part of their length: moments, reactions and deflections
!> against closed forms with the length d = sqrt(E I (1 + strain)/N), and the warning where the deck does not tell the tension.
!> Usage, in tests/: test_layers RESULT_FILE
program test_layers
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_commands_run, only: run_deck
   use limber_output_history_reader, only: history_reader_type
   use runs, only: channel
   use testing, only: check, check_no_error, finish
   implicit none
   character(*), parameter :: nl = new_line('a')
   !> E I = 1, E A = 1e9, little mass
   character(*), parameter :: unit_stuff = '*MATERIAL, NAME=stuff, YOUNG=1e6, DENSITY=1e-9'//nl// &
      & '*SECTION, NAME=bar, SHAPE=GENERAL, AREA=1000, INERTIA=1e-6'//nl
   character(*), parameter :: bar = '*BEAM, NAME=bar, MATERIAL=stuff, SECTION=bar, LENGTH=1'
   character(*), parameter :: wall = '*JOINT, NAME=wall, TYPE=WELD, TURN=0'//nl//' bar.start, ground.origin'//nl
   character(*), parameter :: outputs = '*OUTPUT'//nl//' moment = moment(wall), y = y(bar.end)'//nl
   real(wp), parameter :: ea = 1.0e9_wp
   real(wp), parameter :: pulls(3) = [1.0e3_wp, 1.0e4_wp, 1.0e6_wp]
   character(9), parameter :: words(3) = ['1e3', '1e4', '1e6']
   character(256) :: results
   integer :: i

   call get_command_argument(1, results)
   do i = 1, size(pulls)
      call check_tip(pulls(i), trim(words(i)))
   end do
   call check_between_walls()
   call check_hinges()
   call check_rotor()
   call check_blade()
   call check_wire()
   call check_follower()
   call check_few()
   call finish()

contains

   !> A cantilever that a force pulls, and another bends: F d tanh(L/d) at the wall; on few functions right with the tension, else
   !> warned.
   subroutine check_tip(pull, word)
      real(wp), intent(in) :: pull
      character(*), intent(in) :: word
      character(:), allocatable :: load, report
      real(wp) :: truth, across, d
      load = wall//'*FORCE, NAME=pull, POINT=bar.end'//nl//' '//word//', 1e-3*'//word//nl//'*STATICS, INCREMENTS=2'//nl//outputs
      across = 1.0e-3_wp*pull
      d = sqrt((1 + pull/ea)/pull)
      truth = -across*d*tanh(1/d)
      report = report_of('tip '//word, unit_stuff//bar//nl//load)
      call judge('tip '//word, 'moment', truth, 2.0e-3_wp)
      call check(index(report, 'TENSION=') == 0, 'tip '//word//': no warning of the moment')
      if (pull < 5.0e3_wp) return
      ! As if the deck did not tell the tension
      report = report_of('tip '//word//', untold', unit_stuff//bar//', TENSION=0'//nl//load)
      call check(index(report, 'near its start within') > 0 .and. index(report, 'use TENSION=') > 0, 'tip '//word//': warned')
   end subroutine check_tip

   !> A wire between two walls that a force pushes at its middle: F d/2 tanh(L/4d) at the walls and under the force.
   subroutine check_between_walls()
      character(:), allocatable :: report
      real(wp), parameter :: d = 1.0e-2_wp, truth = 2.5e-4_wp/d
      report = report_of('between walls', unit_stuff//bar//', PRETENSION=1e4'//nl//wall//'*GROUND'//nl//' far, 1, 0'//nl// &
         & '*JOINT, NAME=other, TYPE=WELD, TURN=0'//nl//' bar.end, ground.far'//nl//'*FORCE, NAME=push, POINT=bar.middle'//nl// &
         & ' 0, 5'//nl//'*STATICS, INCREMENTS=2'//nl//'*OUTPUT'//nl//' moment = moment(wall), other = moment(other)'//nl// &
         & ' middle = bending_moment(bar.middle)'//nl)
      call judge('between walls', 'moment', -truth, 2.0e-3_wp)
      call judge('between walls', 'other', truth, 2.0e-3_wp)
      call judge('between walls', 'middle', -truth, 2.0e-3_wp)
      call check(index(report, 'warning') == 0, 'between walls: no warning')
   end subroutine check_between_walls

   !> The same on hinges under a load of 1 all along it: -q E I/N in the middle, q/8N less q d^2/N there.
   subroutine check_hinges()
      character(:), allocatable :: report
      report = report_of('hinges', unit_stuff//bar//', PRETENSION=1e4'//nl//'*GROUND'//nl//' far, 1, 0'//nl// &
         & '*JOINT, NAME=wall, TYPE=REVOLUTE'//nl//' bar.start, ground.origin'//nl//'*JOINT, NAME=other, TYPE=REVOLUTE'//nl// &
         & ' bar.end, ground.far'//nl//'*DISTRIBUTED LOAD, NAME=load, BODY=bar'//nl//' 0, 1'//nl//'*STATICS, INCREMENTS=2'//nl// &
         & '*OUTPUT'//nl//' middle = bending_moment(bar.middle), y = y(bar.middle)'//nl)
      call judge('hinges', 'middle', -1.0e-4_wp, 1.0e-2_wp)
      call judge('hinges', 'y', 0.125e-4_wp - 1.0e-8_wp, 1.0e-4_wp)
   end subroutine check_hinges

   !> A mass on a wire that turns with its wall, pushed across by F: at rest there m w^2 L y = N y balances all but the layer,
   !> y = (F L/N) (L - d tanh(L/d))/(d tanh(L/d)). A mass of its own hangs on a hinge, so that the deck does not tell the tension.
   subroutine check_rotor()
      character(:), allocatable :: scene, report
      real(wp), parameter :: d = 1.0e-2_wp
      scene = '*POINT MASS, NAME=bob, MASS=1, X=1'//nl//'*JOINT, NAME=hang, TYPE=REVOLUTE'//nl//' bar.end, bob'//nl//wall// &
         & '*FORCE, NAME=push, POINT=bob'//nl//' 0, 0.1'//nl//'*STATICS, ROTATION=100, INCREMENTS=2'//nl//outputs
      report = report_of('rotor, untold', unit_stuff//bar//nl//scene)
      call check(index(report, 'near its start within') > 0 .and. index(report, 'use TENSION=') > 0, 'rotor: warned')
      report = report_of('rotor', unit_stuff//bar//', TENSION=1e4'//nl//scene)
      call judge('rotor', 'y', 1.0e-5_wp*(1 - d)/d, 2.0e-3_wp)
      call judge('rotor', 'moment', -0.1_wp, 2.0e-3_wp)
      call check(index(report, 'warning') == 0, 'rotor: no warning')
   end subroutine check_rotor

   !> A blade in rotation that a force of 1 at its tip bends: moments and shear forces inside against the boundary value problem of
   !> the elastica (scipy, solve_bvp, 1e-9); by the places of the functions alone that in the middle is -0.0080.
   subroutine check_blade()
      character(:), allocatable :: report
      report = report_of('blade', '*MATERIAL, NAME=stuff, YOUNG=1e6, DENSITY=1'//nl// &
         & '*SECTION, NAME=bar, SHAPE=GENERAL, AREA=1, INERTIA=1e-6'//nl//'*GROUND'//nl//' hub, 0.5, 0'//nl// &
         & bar//', X=0.5, STRAIN FUNCTIONS=4'//nl//' p, 0.05'//nl//' r, 0.75'//nl//'*JOINT, NAME=wall, TYPE=WELD, TURN=0'//nl// &
         & ' bar.start, ground.hub'//nl//'*FORCE, NAME=push, POINT=bar.end'//nl//' 0, 1'//nl// &
         & '*STATICS, INCREMENTS=4, ROTATION=100'//nl//'*OUTPUT, ENVELOPE=bar'//nl// &
         & ' start = bending_moment(bar.start), m1 = bending_moment(bar.p)'//nl// &
         & ' m2 = bending_moment(bar.middle), m3 = bending_moment(bar.r), sum = bending_moment(bar.start) + moment(wall)'//nl// &
         & ' v0 = shear_force(bar.start), v1 = shear_force(bar.p), v2 = shear_force(bar.middle)'//nl)
      call within('start', 0.02972673_wp, 1.5e-4_wp)
      call within('m1', 0.00035522_wp, 1.5e-4_wp)
      call within('m2', 0.00038363_wp, 1.5e-4_wp)
      call within('m3', 0.00131445_wp, 1.5e-4_wp)
      call within('sum', 0.0_wp, 1.0e-12_wp)
      call within('v0', 2.9522603_wp, 3.0e-3_wp)
      call within('v1', 0.019291913_wp, 3.0e-3_wp)
      call within('v2', -0.0012289754_wp, 3.0e-3_wp)
   end subroutine check_blade

   !> The last sample of a channel of the blade, absolutely.
   subroutine within(channel_name, truth, tolerance)
      character(*), intent(in) :: channel_name
      real(wp), intent(in) :: truth, tolerance
      print '(3a,2es13.5)', 'blade, ', channel_name, ':', last(channel_name), truth
      call check(abs(last(channel_name) - truth) <= tolerance, 'blade: '//channel_name//' is right')
   end subroutine within

   !> A taut wire between walls: its fourth frequency is too high by 0.307 % (roots of the frequency equation, scipy), and that is
   !> told; the energy that functions would save without the tension makes 2.4 % of it.
   subroutine check_wire()
      character(:), allocatable :: report
      report = report_of('wire', '*MATERIAL, NAME=steel, YOUNG=2.1e11, DENSITY=7850'//nl// &
         & '*SECTION, NAME=round, SHAPE=CIRCLE, DIAMETER=0.006'//nl//'*GROUND'//nl//' far, 2, 0'//nl// &
         & '*BEAM, NAME=bar, MATERIAL=steel, SECTION=round, LENGTH=2, PRETENSION=20000, FUNCTIONS=7'//nl//wall// &
         & '*JOINT, NAME=other, TYPE=WELD, TURN=0'//nl//' bar.end, ground.far'//nl//'*STATICS'//nl//'*MODES, NUMBER=4'//nl)
      call told('wire', report, "errs in its frequency by about ", 0.307_wp)
   end subroutine check_wire

   !> A cantilever under a force of 120 E I/L^2 that follows its tip, far behind its flutter load: the tip is 1.58 % of the length
   !> off the elastica (initial value problem from the tip, scipy), which is 1.1 lengths aside at most.
   subroutine check_follower()
      character(:), allocatable :: report
      report = report_of('follower', unit_stuff//bar//', FUNCTIONS=7'//nl//wall// &
         & '*FORCE, NAME=push, POINT=bar.end, FOLLOWER=YES'//nl//' 0, 120'//nl//'*STATICS'//nl//'*OUTPUT'//nl// &
         & ' x = x(bar.end), y = y(bar.end)'//nl)
      call told('follower', report, 'all of its shape at t = 1; about ', 100*hypot(last('x') + 0.008812838_wp, &
         & last('y') - 0.464138761_wp)/1.1_wp)
   end subroutine check_follower

   !> A clamped bar under tension with a force in its middle on three functions, which have no layers: the moment at the wall is
   !> F/2k tanh(kL/4) with k = sqrt(N/EI), and how much it errs is told.
   subroutine check_few()
      character(:), allocatable :: report
      real(wp), parameter :: k = sqrt(1.0e6_wp/(2.1e11_wp*0.02_wp**4/12))
      report = report_of('few', '*MATERIAL, NAME=steel, YOUNG=2.1e11, DENSITY=7850'//nl// &
         & '*SECTION, NAME=square, SHAPE=RECTANGLE, WIDTH=0.02, HEIGHT=0.02'//nl//'*GROUND'//nl//' far, 1, 0'//nl// &
         & '*BEAM, NAME=bar, MATERIAL=steel, SECTION=square, LENGTH=1, PRETENSION=1e6, FUNCTIONS=3'//nl//wall// &
         & '*JOINT, NAME=other, TYPE=WELD, TURN=0'//nl//' bar.end, ground.far'//nl//'*FORCE, NAME=push, POINT=bar.middle'//nl// &
         & ' 0, 1000'//nl//'*STATICS'//nl//'*OUTPUT'//nl//' moment = moment(wall)'//nl)
      call told('few', report, 'of its largest deflection, about ', 100*(abs(last('moment'))/(500/k*tanh(k/4)) - 1))
   end subroutine check_few

   !> A warning with a number that is right within a factor of 2 [%].
   subroutine told(name, report, words, truth)
      character(*), intent(in) :: name, report, words
      real(wp), intent(in) :: truth
      real(wp) :: number
      integer :: at, status
      at = index(report, words)
      call check(at > 0, name//' is told: '//report)
      if (at == 0) return
      at = at + len(words)
      read (report(at:at + index(report(at:), '%') - 2), *, iostat=status) number
      call check(status == 0, name//': a number is told: '//report)
      if (status /= 0) return
      print '(2a,2es10.2)', name, ' told and true [%]:', number, truth
      call check(number <= 2*truth .and. truth <= 2*number, name//': the number that is told is right')
   end subroutine told

   !> The last sample of a channel.
   real(wp) function last(channel_name)
      character(*), intent(in) :: channel_name
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: values(:)
      call reader%open(trim(results), error)
      call check_no_error(error, channel_name)
      allocate (values, source=channel(reader, channel_name))
      last = values(size(values))
      call reader%close()
   end function last

   !> Runs a scene: its report.
   function report_of(name, text) result(report)
      character(*), intent(in) :: name, text
      character(:), allocatable :: report
      type(error_type), allocatable :: error
      integer :: unit
      open (newunit=unit, file=trim(results)//'.inp', access='stream', action='write', status='replace')
      write (unit) text
      close (unit)
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
      call check_no_error(error, name)
   end function report_of

   !> The last sample of a channel against a value.
   subroutine judge(name, channel_name, truth, tolerance)
      character(*), intent(in) :: name, channel_name
      !> The value, and the relative error allowed
      real(wp), intent(in) :: truth, tolerance
      real(wp) :: value
      value = last(channel_name)
      print '(4a,es10.2)', name, ', ', channel_name, ':', value/truth - 1
      call check(abs(value/truth - 1) <= tolerance, name//': '//channel_name//' is right')
   end subroutine judge

end program test_layers
