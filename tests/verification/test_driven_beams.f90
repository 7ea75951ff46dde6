!> Beams that drivers, *MOTION or couplers hold or move, against closed forms: the functions that they get, and what *KINEMATICS and
!> *INVERSE DYNAMICS tell of models that are used beyond their range. Usage, in tests/: test_driven_beams RESULT_FILE
program test_driven_beams
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use limber_output_history_reader, only: history_reader_type
   use bars, only: nl, pin
   use runs, only: channel, run_text
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   !> E I = 1, a weight of 1e-3 for each unit of length
   character(*), parameter :: stuff = '*HEADING'//nl//' Driven beams'//nl//'*MATERIAL, NAME=stuff, YOUNG=1e4, DENSITY=1'//nl// &
      & '*SECTION, NAME=thin, SHAPE=GENERAL, AREA=1, INERTIA=1e-4'//nl
   character(*), parameter :: weight = '*GRAVITY, Y=-1e-3'//nl
   character(*), parameter :: motion = '*MOTION, NAME=hold, BODY=bar'//nl
   character(*), parameter :: angle = '*DRIVER, NAME=hold, TYPE=ANGLE, BODY=bar'//nl//' 0'//nl
   character(*), parameter :: inverse = '*INVERSE DYNAMICS, END=1, OUTPUTS=1'//nl
   real(wp), parameter :: q = 1.0e-3_wp
   character(256) :: results
   character(:), allocatable :: report

   call get_command_argument(1, results)
   call check_held()
   call check_frequency()
   call check_chord()
   call check_watch()
   call check_columns()
   call check_work()
   call check_sections()
   call check_left_inertia()
   call check_rest()
   call finish()

contains

   !> Cantilevers and beams that are held in their middle: what holds the frame acts where its origin is.
   subroutine check_held()
      character(*), parameter :: tip = 'y(bar.end)', inner = 'ORIGIN=0.5, X=0.5', middle = 'y(bar.middle)'
      character(*), parameter :: level = '*COUPLER, NAME=hold'//nl//' 1, angle, bar'//nl
      call check_place('*MOTION', '', motion//' 0, 0, 0'//nl, tip, -q/8, 1.0e-6_wp)
      call check_place('hinge and driver of the frame', '', pin//angle, tip, -q/8, 1.0e-6_wp)
      call check_place('hinge and coupler of the frame', '', pin//level, tip, -q/8, 1.0e-6_wp)
      call check_place('drivers of the place and the frame', '', '*DRIVER, NAME=x, TYPE=X, POINT=bar.start'//nl//' 0'//nl// &
         & '*DRIVER, NAME=y, TYPE=Y, POINT=bar.start'//nl//' 0'//nl//angle, tip, -q/8, 1.0e-6_wp)
      ! The middle held level by a couple, behind a hinge: each half has its own weight, the first the force of the hinge too
      call check_place('driver in the middle', inner, pin//angle, middle, -13*q/384, 1.0e-4_wp)
      call check_place('coupler in the middle', inner, pin//level, middle, -13*q/384, 1.0e-4_wp)
      call check_place('*MOTION of the middle', inner, motion//' 0.5, 0, 0'//nl, tip, -q/128, 1.0e-5_wp)
      call check_place('*MOTION of a quarter', 'ORIGIN=0.25, X=0.25', motion//' 0.25, 0, 0'//nl, tip, -q/8*0.75_wp**4, 1.0e-5_wp)
   end subroutine check_held

   !> A channel at rest.
   subroutine check_place(name, words, held, asked, truth, tolerance)
      !> What is checked, options of the beam, what holds it, the channel
      character(*), intent(in) :: name, words, held, asked
      !> Its value, and the largest relative error
      real(wp), intent(in) :: truth, tolerance
      real(wp), allocatable :: y(:)
      call run_bar(words, held//weight//inverse//'*STATICS'//nl, 'value = '//asked, y)
      call check_close(y(1), truth, tolerance*abs(truth), name//', *INVERSE DYNAMICS')
      call check_close(y(size(y)), truth, tolerance*abs(truth), name//', *STATICS')
      call check(index(report, 'warning') == 0, name//': '//report)
   end subroutine check_place

   !> A beam with modes that is turned up: the driver lifts its weight by sin(1)/2, and nothing is told of that work.
   subroutine check_work()
      real(wp), allocatable :: y(:)
      call run_bar('SUPPORT=CLAMPED-FREE, GEOMETRIC=K_G, BENDING MODES=4, AXIAL MODES=1', pin//'*DRIVER, NAME=hold, TYPE=ANGLE,'// &
         & ' BODY=bar'//nl//' 0.1*t'//nl//weight//'*INVERSE DYNAMICS, END=10, OUTPUTS=10'//nl, 'value = work(system)', y)
      call check_close(y(size(y)), 0.5_wp*q*sin(1.0_wp), 5.0e-3_wp*q, 'work of the driver')
      call check(index(report, 'warning') == 0, 'nothing is wrong with the work: '//report)
   end subroutine check_work

   !> The first two frequencies of a cantilever.
   subroutine check_frequency()
      real(wp), parameter :: free(2) = [1.8751040687120_wp, 4.6940911329742_wp]
      real(wp), allocatable :: y(:)
      real(wp) :: frequency
      integer :: i, at, status
      call run_bar('', motion//' 0, 0, 0'//nl//'*MODES, NUMBER=2'//nl, 'value = y(bar.end)', y)
      do i = 1, 2
         at = index(report, nl//'         '//as_text(i)//' ')
         frequency = 0.0_wp
         if (at > 0) read (report(at + 11:at + 28), *, iostat=status) frequency
         call check_close(frequency, free(i)**2, 1.0e-4_wp*free(i)**2, '*MODES of a beam that *MOTION holds')
      end do
   end subroutine check_frequency

   !> What acts on the frame of a beam with modes acts on both of its ends, unless the deck says what the frame is.
   subroutine check_chord()
      character(*), parameter :: modal = 'GEOMETRIC=K_G, CORRECTIONS=YES'
      real(wp), allocatable :: y(:)
      call run_bar(modal, motion//' 0, 0, 0'//nl//weight//'*STATICS'//nl, 'value = y(bar.end)', y)
      call check(index(report, 'the line through its two ends') > 0, 'the line through its ends is told of: '//report)
      call run_bar(modal//', SUPPORT=PINNED-ROLLER', motion//' 0, 0, 0'//nl//weight//'*STATICS'//nl, 'value = y(bar.end)', y)
      call check(index(report, 'warning') == 0, 'nothing is told of a line that is asked for: '//report)
      call run_bar(modal//', SUPPORT=CLAMPED-FREE, ELEMENTS=40', motion//' 0, 0, 0'//nl//weight//'*STATICS'//nl, &
         & 'value = y(bar.end)', y)
      call check_close(y(size(y)), -q/8, 2.0e-3_wp*q/8, '*MOTION of a beam with modes')
   end subroutine check_chord

   !> Internal forces of a bar that a hinge turns with a steady speed under its weight, its deflections held: of beams and frames
   !> with any model those of equilibrium.
   subroutine check_sections()
      character(*), parameter :: modes = 'SUPPORT=CLAMPED-FREE, ELEMENTS=60, BENDING MODES=3', &
         & members = '*NODE'//nl//' 1, 0, 0, start'//nl//' 2, 1, 0, end'//nl//'*ELEMENT'//nl//' 1, 1, 2'//nl, &
         & parts = members//'*BOUNDARY'//nl//' 1, 1, 6'//nl
      call check_section('exact beam', '*BEAM, LENGTH=1', ' mid, 0.5'//nl)
      call check_section('K_G beam', '*BEAM, LENGTH=1, GEOMETRIC=K_G, AXIAL MODES=1, '//modes, ' mid, 0.5'//nl)
      call check_section('K_G beam, responses', '*BEAM, LENGTH=1, GEOMETRIC=K_G, AXIAL MODES=1, CORRECTIONS=YES, '//modes, &
         & ' mid, 0.5'//nl)
      call check_section('LINEAR beam', '*BEAM, LENGTH=1, GEOMETRIC=LINEAR, '//modes, ' mid, 0.5'//nl)
      call check_section('frame', '*FRAME, DIVISIONS=60', ' mid, 1, 0.5'//nl//parts)
      call check_section('LINEAR frame', '*FRAME, DIVISIONS=60, GEOMETRIC=LINEAR', ' mid, 1, 0.5'//nl//parts)
      call check_section('frame of few modes', '*FRAME, DIVISIONS=60, MODES=2', ' mid, 1, 0.5'//nl//parts)
      call check_section('frame of exact beams', '*FRAME, LARGE=YES', ' mid, 1, 0.5'//nl//members)
   end subroutine check_sections

   !> Forces in the middle when the bar has turned by 1: weight and centrifugal force of the outer half.
   subroutine check_section(name, block, parts)
      !> The block of the bar, and what stands below it
      character(*), intent(in) :: name, block, parts
      character(*), parameter :: asked(3) = [character(14) :: 'axial_force', 'shear_force', 'bending_moment']
      real(wp), parameter :: speed = 0.02_wp, truth(3) = [-0.5_wp*q*sin(1.0_wp) + speed**2*0.375_wp, 0.5_wp*q*cos(1.0_wp), &
         & -q*cos(1.0_wp)/8]
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: y(:)
      integer :: i
      call run_text(stuff//block//', NAME=bar, MATERIAL=stuff, SECTION=thin'//nl//parts//pin//'*DRIVER, NAME=motor, TYPE=ANGLE,'// &
         & ' JOINT=pin'//nl//' 0.02*t'//nl//weight//'*KINEMATICS, END=50, OUTPUTS=2'//nl//'*OUTPUT, ENVELOPE=bar'//nl// &
         & ' axial_force = axial_force(bar.mid), shear_force = shear_force(bar.mid)'//nl// &
         & ' bending_moment = bending_moment(bar.mid)'//nl, trim(results), report, error)
      call check_no_error(error, name)
      if (allocated(error)) return
      call check(index(report, 'warning') == 0, name//': '//report)
      call reader%open(trim(results), error)
      do i = 1, 3
         y = channel(reader, trim(asked(i)))
         call check_close(abs(y(3)), abs(truth(i)), 2.0e-3_wp*q/2, name//', held, '//asked(i))
      end do
      call reader%close()
   end subroutine check_section

   !> Models beyond their range, and functions and modes that are too few, in both analyses.
   subroutine check_watch()
      character(*), parameter :: linear = 'GEOMETRIC=LINEAR, SUPPORT=CLAMPED-FREE, MODES=4, ELEMENTS=40'
      call check_told('one function', 'FUNCTIONS=1', '0', 'too few functions of the angle', .true.)
      call check_told('seven functions', 'FUNCTIONS=7', '0', '', .false.)
      call check_told('modes of pins', 'GEOMETRIC=LINEAR, MODES=2', '0', 'errs by about 31 %', .true.)
      call check_told('one element', 'GEOMETRIC=K_G, SUPPORT=CLAMPED-FREE, MODES=2, ELEMENTS=1', '0', &
         & 'has too few elements', .true.)
      call check_told('LINEAR at rest', linear, '0', '', .false.)
      ! The first frequency is 3.5
      call check_told('LINEAR in a rotation', linear, '3.4*t', 'a LINEAR beam leaves it out', .true.)
      call check_told('LINEAR in a slow rotation', linear, '0.3*t', '', .false.)
   end subroutine check_watch

   !> A cantilever under its weight on a driver, against the closed form at rest; what is told, where something is.
   subroutine check_told(name, words, law, warning, wrong)
      character(*), intent(in) :: name, words, law, warning
      !> Whether the deflection at the first instant is wrong
      logical, intent(in) :: wrong
      character(*), parameter :: analyses(3) = [character(50) :: '*INVERSE DYNAMICS, END=1, OUTPUTS=2', &
         & '*KINEMATICS, END=1, OUTPUTS=2, DEFLECTIONS=STATIC', '*KINEMATICS, END=1, OUTPUTS=2']
      real(wp), allocatable :: y(:)
      integer :: i
      do i = 1, size(analyses)
         call run_bar(words, pin//'*DRIVER, NAME=motor, TYPE=ANGLE, JOINT=pin'//nl//' '//law//nl//weight//trim(analyses(i))//nl, &
            & 'value = y(bar.end)'//nl//' y(bar.end)', y)
         if (i == 3) then
            call check(index(report, 'warning') == 0, name//', deflections held: '//report)
            cycle
         end if
         if (law == '0') call check((abs(y(1)/(-q/8) - 1) > 0.02_wp) .eqv. wrong, name//': '//as_text(y(1))//' is right or wrong')
         call check((index(report, 'warning') > 0) .eqv. (warning /= ''), name//': '//report)
         call check(index(report, warning) > 0, name//' is told of: '//report)
      end do
   end subroutine check_told

   !> What inverse dynamics leaves out of a bar that a hinge rocks: the inertia of its bending, against the closed form of the beam
   !> with a prescribed slope, and vibrations where its acceleration jumps.
   subroutine check_left_inertia()
      real(wp), parameter :: quick = 0.7_wp
      real(wp), allocatable :: y(:)
      real(wp) :: truth, told
      integer :: at, model
      truth = 1 - 1/torque_of(sqrt(quick))
      do model = 1, 2
         call rock(model, '1e-3*cos('//as_text(quick)//'*t)', y)
         at = index(report, 'errs by about')
         told = 0.0_wp
         if (at > 0) read (report(at + 13:index(report(at:), '%') + at - 2), *) told
         call check_close(told/100, truth, 0.05_wp*truth, 'inertia of the bending: '//report)
         call check_close(maxval(abs(y)), 1.0e-3_wp*quick**2/3, 1.0e-3_wp*quick**2, 'torque with bending in balance')
         call rock(model, '1e-3*cos(0.1*t)', y)
         call check(index(report, 'warning') == 0, 'slowly nothing is left out: '//report)
         ! The torque of a step of the acceleration goes to and fro about its mean by as much
         call rock(model, '1e-3*max(0, t - 4)**2', y)
         call check(index(report, 'errs by more than about 50 % at t = 4: deflections, or their rates, jump') > 0, &
            & 'vibrations behind a step: '//report)
         call rock(model, '1e-3*smoothstep((t - 2)/6)', y)
         call check(index(report, 'jump') > 0, 'vibrations behind a step of the rate of the acceleration: '//report)
      end do
   end subroutine check_left_inertia

   !> A mass of 100 at the end of a bar that is turned from rest by t^3: on its stiffness of 3 it vibrates with 1/(omega t) of the
   !> largest deflection in balance, for the rate of that is not zero at the start.
   subroutine check_rest()
      real(wp), parameter :: time = 60.0_wp, omega = sqrt(3/(100 + 33.0_wp/140))
      real(wp), allocatable :: y(:)
      real(wp) :: told
      integer :: at
      call run_bar('', pin//'*DRIVER, NAME=motor, TYPE=ANGLE, JOINT=pin'//nl//' 1e-7*t**3'//nl// &
         & '*POINT MASS, NAME=tip, MASS=100, X=1'//nl//'*JOINT, NAME=hold, TYPE=REVOLUTE'//nl//' tip, bar.end'//nl// &
         & '*INVERSE DYNAMICS, END=60, OUTPUTS=60'//nl, 'value = torque(motor)', y)
      at = index(report, 'errs by about')
      told = 0.0_wp
      if (at > 0) read (report(at + 13:index(report(at:), '%') + at - 2), *) told
      call check_close(told/100, 1/(omega*time), 0.15_wp/(omega*time), 'vibration behind a start from rest: '//report)
      call check(index(report, '% at t = 0: deflections, or their rates, jump') > 0, 'that it begins there: '//report)
   end subroutine check_rest

   !> Torque at the end of a bar of length, mass and E I 1 whose slope there is prescribed, over that of the rigid bar.
   pure real(wp) function torque_of(b)
      !> Fourth root of mass times square of the frequency
      real(wp), intent(in) :: b
      torque_of = 3*(sin(b)*cosh(b) - cos(b)*sinh(b))/(b**3*(1 + cos(b)*cosh(b)))
   end function torque_of

   !> Runs a bar of one model, 1: exact, 2: with modes, whose driver has a law: its torque.
   subroutine rock(model, law, y)
      integer, intent(in) :: model
      character(*), intent(in) :: law
      real(wp), allocatable, intent(out) :: y(:)
      character(*), parameter :: words(2) = [character(80) :: '', 'SUPPORT=CLAMPED-FREE, GEOMETRIC=LINEAR, MODES=4, ELEMENTS=40']
      call run_bar(trim(words(model)), pin//'*DRIVER, NAME=motor, TYPE=ANGLE, JOINT=pin'//nl//' '//law//nl// &
         & '*INVERSE DYNAMICS, END=9, OUTPUTS=90'//nl, 'value = torque(motor)', y)
   end subroutine rock

   !> Columns below and above Euler's load, pi^2/4.
   subroutine check_columns()
      call check_column('EXACT', 2.2_wp, .false.)
      call check_column('EXACT', 2.7_wp, .true.)
      call check_column('K_G, SUPPORT=CLAMPED-FREE', 2.7_wp, .true.)
   end subroutine check_columns

   subroutine check_column(model, load, buckled)
      character(*), intent(in) :: model
      real(wp), intent(in) :: load
      logical, intent(in) :: buckled
      real(wp), allocatable :: y(:)
      call run_bar('GEOMETRIC='//model, pin//'*DRIVER, NAME=motor, TYPE=ANGLE, JOINT=pin'//nl//' 0'//nl// &
         & '*FORCE, NAME=push, POINT=bar.end'//nl//' -'//as_text(load)//', 1e-3'//nl//inverse, 'value = y(bar.end)', y)
      call check((index(report, 'not stably') > 0) .eqv. buckled, model//' under '//as_text(load)//': '//report)
      call check((y(1) < 0.0_wp) .eqv. buckled, model//' under '//as_text(load)//': side to which it bends')
   end subroutine check_column

   !> Runs a bar of length 1, and reads its channel `value`.
   subroutine run_bar(words, blocks, asked, values)
      !> Options of the beam, blocks behind it, channels
      character(*), intent(in) :: words, blocks, asked
      real(wp), allocatable, intent(out) :: values(:)
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: options
      options = ''
      if (words /= '') options = ', '//words
      call run_text(stuff//'*BEAM, NAME=bar, MATERIAL=stuff, SECTION=thin, LENGTH=1'//options//nl//blocks//'*OUTPUT'//nl//' '// &
         & asked//nl, trim(results), report, error)
      call check_no_error(error, blocks)
      if (allocated(error)) error stop 1
      call reader%open(trim(results), error)
      call check_no_error(error, 'results')
      allocate (values, source=channel(reader, 'value'))
      call reader%close()
   end subroutine run_bar

end program test_driven_beams
