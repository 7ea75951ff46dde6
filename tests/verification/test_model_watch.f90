!> No silent wrong answers of frames, of modal analyses, and of defaults: each is right against an independent value and without a
!> warning, or warned of with cause and remedy. Sources: stability functions of beam-columns (slope and deflection), frequencies of
!> beams under tension in closed form, Leipholz' column (40.05), ratios of damping. Usage, in tests/: test_model_watch RESULT_FILE
program test_model_watch
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_changed, channel, check_warning
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   character(*), parameter :: rich = 'SECTION=bar@*NODE > SECTION=bar, MODES=20@*NODE'
   !> Exact beams have no floating frame to hold nodes in: another block stands in its place
   character(*), parameter :: large = 'SECTION=bar > SECTION=bar, LARGE=YES; *BOUNDARY > *GROUND; 1, 1, 6 > q, 1, 6'
   real(wp), parameter :: pi = acos(-1.0_wp), critical = 7.379_wp
   character(256) :: results

   call get_command_argument(1, results)
   call check_portal()
   call check_modes()
   call check_size()
   call check_inner()
   call check_statics()
   call check_weight()
   call check_ends()
   call check_phase()
   call check_kinks()
   call check_defaults()
   call check_follower()
   call check_damping()
   call check_rotating()
   call check_pulled()
   call finish()

contains

   !> The sway of the portal near its critical load, and under tension; the first frequency where the loads are small.
   subroutine check_portal()
      call judge_portal('default at 0.9 of the critical load', 0.9_wp*critical, '', '')
      call judge_portal('more modes', 0.9_wp*critical, rich, '')
      call judge_portal('modes alone', 0.9_wp*critical, rich//'; MODES=20 > CORRECTIONS=NO', 'lacks axial force')
      call judge_portal('LINEAR at 0.9 of it', 0.9_wp*critical, rich//'; MODES=20 > GEOMETRIC=LINEAR, CORRECTIONS=YES', &
         & 'a LINEAR frame leaves it out')
      call judge_portal('default under tension', -5*critical, '', '')
      call judge_portal('the same, rich', -5*critical, rich, '')
      call judge_portal('rich without loads', 0.0_wp, rich, '')
   end subroutine check_portal

   !> Sway against slope and deflection, of columns with stability functions.
   subroutine judge_portal(name, load, words, warning)
      character(*), intent(in) :: name, words, warning
      real(wp), intent(in) :: load
      type(history_reader_type) :: reader
      real(wp), allocatable :: sway(:)
      real(wp) :: truth, off
      call run_words('verification/watch_portal.inp', 'load = 1 > load = '//as_text(load, 17)//'; '//words, reader)
      allocate (sway, source=channel(reader, 'sway'))
      truth = 1.0e-3_wp/sway_stiffness(load)
      off = abs(sway(size(sway))/truth - 1)
      print '(2a,3es12.4)', name, ': sway, truth, error', sway(size(sway)), truth, off
      if (warning /= '') then
         call check(off > 0.1_wp, 'portal, '//name//': wrong')
      else
         call check(off < 0.02_wp, 'portal, '//name//': right to 2 %')
      end if
      call check_warning(reader, warning, 'portal, '//name)
      call reader%close()
   end subroutine judge_portal

   !> Force on the side of the portal for a unit sway.
   pure real(wp) function sway_stiffness(load) result(stiffness)
      !> On each column
      real(wp), intent(in) :: load
      complex(wp) :: root, below
      real(wp) :: s, carried
      root = sqrt(cmplx(load, 0.0_wp, wp))
      if (abs(load) < 1.0e-6_wp) then
         s = 4.0_wp
         carried = 2.0_wp
      else
         below = 2 - 2*cos(root) - root*sin(root)
         s = real(root*(sin(root) - root*cos(root))/below, wp)
         carried = real(root*(root - sin(root))/below, wp)
      end if
      stiffness = 2*(2*(s + carried) - load - (s + carried)**2/(s + 6))
   end function sway_stiffness

   !> Tension a thousand times Euler's load, welds on the modes of pins, few elements.
   subroutine check_modes()
      character(*), parameter :: string = 'TYPE=WELD > TYPE=REVOLUTE; *FORCE > *JOINT, NAME=roller, TYPE=POINT ON LINE'// &
         & '@ beam.end, ground.origin@*FORCE; pull = 0 > pull = 9869.6044; YOUNG=1e4 > YOUNG=1e8; INERTIA=1e-4 > INERTIA=1e-8;'
      call judge_mode('LINEAR under tension', string//'LENGTH=1 > LENGTH=1, ELEMENTS=40, GEOMETRIC=LINEAR', &
         & pi**2*sqrt(1001.0_wp), 'carries axial forces that LINEAR leaves out; use GEOMETRIC=EXACT')
      call judge_mode('K_G under tension', string//'LENGTH=1 > LENGTH=1, ELEMENTS=40, AXIAL BASIS=STATIC', &
         & pi**2*sqrt(1001.0_wp), '')
      call judge_mode('modes of pins with a weld', '', 3.5160153_wp, 'cannot take this shape with its 7 coordinates; use'// &
         & ' CORRECTIONS=YES')
      call judge_mode('the same with shapes of its ends', 'LENGTH=1 > LENGTH=1, CORRECTIONS=YES', 3.5160153_wp, '')
      call judge_mode('modes of a cantilever', 'LENGTH=1 > LENGTH=1, SUPPORT=CLAMPED-FREE', 3.5160153_wp, '')
      call judge_mode('two elements', 'LENGTH=1 > LENGTH=1, SUPPORT=CLAMPED-FREE, ELEMENTS=2, MODES=1', 3.5160153_wp, &
         & 'too few elements: its mass is in their nodes; use ELEMENTS=')
   end subroutine check_modes

   !> The error that is told is of the size of the true one: a weld on the modes of pins, at rest and turning, where frequencies of
   !> the finite elements are 3.5160, 22.034, 61.697, and at a speed of 12 5.4270, 35.637, 78.705.
   subroutine check_size()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: text
      character(*), parameter :: key = 'frequency by about '
      real(wp) :: told
      integer :: at, from, to, k
      character(*), parameter :: words(2) = [character(120) :: 'YOUNG=1e4 > YOUNG=1e6; INERTIA=1e-4 > INERTIA=1e-6; NUMBER=1 > '// &
         & 'NUMBER=3', 'YOUNG=1e4 > YOUNG=1e6; INERTIA=1e-4 > INERTIA=1e-6; INCREMENTS=1 > INCREMENTS=1, ROTATION=12']
      real(wp), parameter :: least(2) = [0.05_wp, 0.12_wp], most(2) = [0.12_wp, 0.25_wp]
      do k = 1, 2
         call run_words('verification/watch_beam.inp', trim(words(k)), reader)
         call reader%read_text('/run/warnings', text, error)
         call check_no_error(error, 'sizes of errors: warnings')
         call reader%close()
         at = index(text, 'cannot take this shape')
         call check(at > 0, 'a basis that does not fit is warned of: '//text)
         if (at == 0) return
         from = index(text(:at), key, back=.true.) + len(key)
         to = from + index(text(from:), ' %') - 2
         read (text(from:to), *) told
         told = 0.01_wp*told
         print '(a,i3,es12.4)', 'error of a frequency as it is told, case', k, told
         call check(told > least(k) .and. told < most(k), 'the error that is told is of the size of the true one')
      end do
      call run_words('verification/watch_beam.inp', 'YOUNG=1e4 > YOUNG=1e6; INERTIA=1e-4 > INERTIA=1e-6; NUMBER=1 > NUMBER=3; '// &
         & 'INCREMENTS=1 > INCREMENTS=2, ROTATION=12; LENGTH=1 > LENGTH=1, SUPPORT=CLAMPED-FREE, ELEMENTS=60,'// &
         & ' AXIAL BASIS=STATIC, GEOMETRIC ELEMENTS=10', reader)
      call check_warning(reader, '', 'a rich basis in rotation')
      call reader%close()
   end subroutine check_size

   !> A body with a moment of inertia welded to an inner point of a beam or frame: frequencies of 200 finite elements by another
   !> program. Modes of hinges lack one of them; with responses they are right, on ten elements too, for the point is a node.
   subroutine check_inner()
      character(*), parameter :: lacks = 'the list lacks a mode at about 7', cure = 'use CORRECTIONS=YES', &
         & is_frame = '*BEAM > *FRAME; LENGTH=1,  > ; p, 0.08 > p, 1, 0.08@*NODE@ 1, 0, 0, start@ 2, 1, 0, end@*BOUNDARY@'// &
         & ' 1, 1, 2@ 2, 2@*ELEMENT@ 1, 1, 2; MODES=8, ELEMENTS=60 > MODES=8, '
      call judge_inner('K_G', '', lacks, cure)
      call judge_inner('K_G, ten elements', 'ELEMENTS=60 > ELEMENTS=10', lacks, cure)
      call judge_inner('LINEAR', 'K_G > LINEAR; MODES=8 > MODES=12', lacks, cure)
      call judge_inner('bending modes', 'MODES=8 > BENDING MODES=6, AXIAL MODES=2', lacks, cure)
      call judge_inner('frame', is_frame//'CORRECTIONS=NO', lacks, cure)
      call judge_inner('K_G with responses', 'MODES=8 > MODES=8, CORRECTIONS=YES', '', '')
      call judge_inner('ten elements with responses', 'MODES=8, ELEMENTS=60 > MODES=8, CORRECTIONS=YES', '', '')
      call judge_inner('frame with responses', is_frame//'CORRECTIONS=YES', '', '')
      call judge_inner('too few of the list', 'MODES=8, ELEMENTS=60 > BENDING MODES=3, AXIAL MODES=1, CORRECTIONS=YES', &
         & 'cannot take this shape', 'use BENDING MODES=')
   end subroutine check_inner

   subroutine judge_inner(name, words, warning, cure)
      character(*), intent(in) :: name, words, warning, cure
      real(wp), parameter :: truth(6) = [5.2822_wp, 20.1241_wp, 57.797_wp, 75.956_wp, 126.057_wp, 154.204_wp]
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: frequency(:)
      real(wp) :: off
      call run_words('verification/watch_inner.inp', words, reader)
      call reader%read_numbers('/modes/modes/frequency', frequency, error)
      call check_no_error(error, name)
      off = maxval(frequency/truth(:size(frequency)) - 1)
      print '(2a,es12.4)', 'body at an inner point, '//name, ': largest error', off
      if (warning == '') call check(off < 0.005_wp, 'body at an inner point, '//name//': right to 0.5 %')
      if (warning /= '') call check(off > 0.02_wp, 'body at an inner point, '//name//': wrong')
      call check_warning(reader, warning, 'body at an inner point, '//name)
      if (cure /= '') call check_warning(reader, cure, 'cure of a body at an inner point, '//name)
      call reader%close()
   end subroutine judge_inner

   !> Channels of statics: a truss with one member too many against linear finite elements of another program; the moment at the
   !> clamp of a cantilever whose middle a spring of 1000 EI/L keeps from turning: 1 - 0.375*1000/501 of force times length.
   subroutine check_statics()
      real(wp), parameter :: truss(2) = [3.307e-4_wp, 1.265e-4_wp], sprung(2) = [1.0e-4_wp*(1 - 375.0_wp/501), 2.5e-5_wp]
      call judge_static('truss of 40 modes', 'watch_truss', '', truss, "channel 'N' of *STATICS")
      call judge_static('truss with responses', 'watch_truss', 'MODES=40 > CORRECTIONS=YES', truss, '')
      call judge_static('sprung cantilever', 'watch_sprung', '', sprung, "channel 'M1' of *STATICS 'statics' errs by about 5.")
      call judge_static('sprung, with responses', 'watch_sprung', 'ELEMENTS=40 > ELEMENTS=40, CORRECTIONS=YES', sprung, '')
   end subroutine check_statics

   subroutine judge_static(name, deck, words, truth, warning)
      character(*), intent(in) :: name, deck, words, warning
      !> Of the first two channels
      real(wp), intent(in) :: truth(2)
      character(*), parameter :: channels(2, 2) = reshape([character(6) :: 'pull', 'N', 'M1', 'M2'], [2, 2])
      type(history_reader_type) :: reader
      real(wp), allocatable :: values(:)
      real(wp) :: off
      integer :: i
      call run_words('verification/'//deck//'.inp', words, reader)
      off = 0.0_wp
      do i = 1, 2
         if (allocated(values)) deallocate (values)
         allocate (values, source=channel(reader, trim(channels(i, merge(1, 2, deck == 'watch_truss')))))
         off = max(off, abs(values(size(values)) - truth(i))/max(abs(truth(i)), 0.1_wp*maxval(truth)))
      end do
      print '(2a,es12.4)', name, ': largest error of two channels', off
      if (warning == '') call check(off < 0.01_wp, name//': right to 1 %')
      if (warning /= '') call check(off > 0.04_wp, name//': wrong')
      call check_warning(reader, warning, name)
      call reader%close()
   end subroutine judge_static

   !> A mass at rest on a stiff spring is in equilibrium: its weight and the force of the spring cancel but for rounding.
   subroutine check_weight()
      type(history_reader_type) :: reader
      call run_words('verification/watch_weight.inp', '', reader)
      call check_warning(reader, '', 'a weight on a spring')
      call reader%close()
   end subroutine check_weight

   !> A column at 1.05 of Euler's load pi^2/4 that stays straight on the modes of pins; the shear force -1 at the root of a
   !> cantilever whose tension is 20 times that load, where the functions do not follow sqrt(EI/T).
   subroutine check_ends()
      type(history_reader_type) :: reader
      real(wp), allocatable :: shear(:)
      character(*), parameter :: channels = 'tip = y(beam.end), stretch > tip = y(beam.end), v = shear_force(beam.start), stretch'
      call run_words('verification/watch_beam.inp', 'pull = 0 > pull = -2.590771; NUMBER=1 > NUMBER=2', reader)
      call check_warning(reader, 'times its Euler load at t = 1, which its functions take 8.1 % too large: they do not fit'// &
         & ' how its joints hold it; use GEOMETRIC=EXACT', 'a column on functions that do not fit')
      call reader%close()
      call run_words('verification/watch_beam.inp', 'pull = 0 > pull = 49.348; push = 0 > push = 0.01; LENGTH=1 > LENGTH=1,'// &
         & ' CORRECTIONS=YES; '//channels, reader)
      allocate (shear, source=channel(reader, 'v'))
      call check_close(abs(shear(size(shear)))/0.01_wp, 1.0_wp, 5.0e-3_wp, 'the shear force of a stretched cantilever')
      call check_warning(reader, '', 'a stretched cantilever')
      call reader%close()
   end subroutine check_ends

   !> Laws that bend or jump where the mass rests: between 10 and 20 rad/s, damping ratios of 0.15 and -0.15, Coulomb's friction;
   !> none a little beside the bend, nor for a law that is smooth there.
   subroutine check_kinks()
      call judge_kink('a stop that touches', '', "the law of 'stop' on body 'm' bends in this state: with its slope to one side"// &
         & ' the frequency is 20 rad/s, with that to the other 10 rad/s, and *MODES takes one of them; go off the bend')
      call judge_kink('a stop beside it', 'gap = 0 > gap = 1e-5', '')
      call judge_kink('a damper to one side', '-300*max(0, x(m) - 1 - gap) > -3*abs(vx(m))', 'with its slope to one side the'// &
         & ' damping ratio is 0.15, with that to the other -0.15')
      call judge_kink('dry friction', '-300*max(0, x(m) - 1 - gap) > 1 - 2*step(vx(m))', 'jumps in this state')
      call judge_kink('a smooth law', '-300*max(0, x(m) - 1 - gap) > -3*tanh(vx(m)/1e-3) - 50*abs(x(m) - 1)*(x(m) - 1)', '')
   end subroutine check_kinks

   subroutine judge_kink(name, words, warning)
      character(*), intent(in) :: name, words, warning
      type(history_reader_type) :: reader
      call run_words('verification/watch_kink.inp', words, reader)
      call check_warning(reader, warning, name)
      call reader%close()
   end subroutine judge_kink

   !> A cantilever under a sudden force for four and a half vibrations, and a pendulum for thirteen swings: the masses in the nodes
   !> shift them, which is told; with more elements they are right without a word.
   subroutine check_phase()
      character(*), parameter :: late = 'with the mass in the nodes its vibrations are late by ', clamped = 'SUPPORT=CLAMPED-FREE'
      call judge_phase('modes of a cantilever', clamped, 8.0_wp, late)
      call judge_phase('modes of pins with shapes of its ends', 'CORRECTIONS=YES', 8.0_wp, late)
      call judge_phase('many elements', clamped//', ELEMENTS=100', 8.0_wp, '')
      call judge_swing('ten elements', 10, late)
      call judge_swing('eighty elements', 80, '')
   end subroutine check_phase

   !> The tip against the sum of the first modes, relative to the amplitude.
   subroutine judge_phase(name, words, duration, warning)
      character(*), intent(in) :: name, words, warning
      real(wp), intent(in) :: duration
      real(wp), parameter :: omega(3) = [3.5160153_wp, 22.034492_wp, 61.697214_wp], force = 0.01_wp
      type(history_reader_type) :: reader
      real(wp), allocatable :: tip(:)
      real(wp) :: off, t
      integer :: i
      call run_words('verification/watch_beam.inp', 'LENGTH=1 > LENGTH=1, GEOMETRIC=LINEAR, '//words//'; push = 0 > push = '// &
         & as_text(force, 4)//'; *STATICS, NAME=loaded, INCREMENTS=1 > *DYNAMICS, INTEGRATOR=RADAU, TOLERANCE=1e-5, END='// &
         & as_text(duration, 4)//'; *MODES, NAME=small, NUMBER=1 > ** no modes; , stretch = x(beam.end) - 1 > ', reader)
      allocate (tip, source=channel(reader, 'tip'))
      off = 0.0_wp
      do i = 1, size(tip)
         t = duration*(i - 1)/(size(tip) - 1)
         off = max(off, abs(tip(i) - sum(4*force/omega**2*(1 - cos(omega*t))))/(force/3))
      end do
      print '(2a,es12.4)', name, ': error of the tip', off
      if (warning == '') call check(off < 0.03_wp, 'vibrations, '//name//': right to 3 %')
      if (warning /= '') call check(off > 0.05_wp, 'vibrations, '//name//': wrong')
      call check_warning(reader, warning, 'vibrations, '//name)
      call reader%close()
   end subroutine judge_phase

   !> The angle of a stiff beam that hangs on a pin at first 0.05 beside its rest, against small swings of a slender bar.
   subroutine judge_swing(name, elements, warning)
      character(*), intent(in) :: name, warning
      integer, intent(in) :: elements
      real(wp), parameter :: first = 0.05_wp, duration = 21.0_wp
      type(history_reader_type) :: reader
      real(wp), allocatable :: angle(:)
      real(wp) :: off
      call run_words('verification/watch_beam.inp', 'LENGTH=1 > LENGTH=1, GEOMETRIC=LINEAR, CORRECTIONS=YES,'// &
         & ' ANGLE=-pi/2 + 0.05, ELEMENTS='//as_text(elements)//'; TYPE=WELD > TYPE=REVOLUTE; *FORCE > *GRAVITY@*FORCE;'// &
         & ' YOUNG=1e4 > YOUNG=1e7; *STATICS, NAME=loaded, INCREMENTS=1 > *DYNAMICS, INTEGRATOR=RADAU, TOLERANCE=1e-6, END='// &
         & as_text(duration, 4)//'; *MODES, NAME=small, NUMBER=1 > ** no modes; tip =  > swing = angle(beam), tip = ', reader)
      allocate (angle, source=channel(reader, 'swing'))
      off = abs(angle(size(angle)) + pi/2 - first*cos(sqrt(1.5_wp*9.81_wp)*(1 - first**2/16)*duration))/first
      print '(2a,2es12.4)', name, ': angle and its error', angle(size(angle)), off
      if (warning == '') call check(off < 0.01_wp, 'swings, '//name//': right to 1 %')
      if (warning /= '') call check(off > 0.05_wp, 'swings, '//name//': wrong')
      call check_warning(reader, warning, 'swings, '//name)
      call reader%close()
   end subroutine judge_swing

   !> The first frequency against its true value.
   subroutine judge_mode(name, words, truth, warning)
      character(*), intent(in) :: name, words, warning
      real(wp), intent(in) :: truth
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: frequency(:)
      real(wp) :: off
      call run_words('verification/watch_beam.inp', words, reader)
      call reader%read_numbers('/modes/small/frequency', frequency, error)
      call check_no_error(error, name)
      off = abs(frequency(1)/truth - 1)
      print '(2a,3es12.4)', name, ': frequency, truth, error', frequency(1), truth, off
      if (warning == '') then
         call check(off < 0.02_wp, name//': right to 2 %')
      else
         call check(off > 0.02_wp, name//': wrong by more than 2 %')
      end if
      call check_warning(reader, warning, name)
      call reader%close()
   end subroutine judge_mode

   !> A beam with default options bends, stretches and stiffens; what cannot is warned of.
   subroutine check_defaults()
      character(*), parameter :: clamped = 'LENGTH=1 > LENGTH=1, SUPPORT=CLAMPED-FREE'
      character(*), parameter :: pulled = '; pull = 0 > pull = 10; push = 0 > push = 1e-3'
      real(wp), parameter :: root = sqrt(10.0_wp)
      call judge_tip('defaults', clamped//pulled, 1.0e-3_wp*(1 - tanh(root)/root)/10, 1.0e-3_wp, '')
      call judge_tip('AXIAL MODES=1, as a warning says', clamped//', AXIAL MODES=1'//pulled, 1.0e-3_wp*(1 - tanh(root)/root)/10, &
         & 8.1e-4_wp, 'longer or shorter')
      call judge_tip('LINEAR', clamped//', GEOMETRIC=LINEAR; pull = 0 > pull = 10', 0.0_wp, 1.0e-3_wp, '')
      call judge_tip('bending modes alone', clamped//', GEOMETRIC=LINEAR, BENDING MODES=3; pull = 0 > pull = 10', 0.0_wp, &
         & 0.0_wp, 'has no axial coordinate')
   end subroutine check_defaults

   !> Deflection and elongation of the cantilever.
   subroutine judge_tip(name, words, deflection, elongation, warning)
      character(*), intent(in) :: name, words, warning
      real(wp), intent(in) :: deflection, elongation
      type(history_reader_type) :: reader
      real(wp), allocatable :: tip(:), stretch(:)
      call run_words('verification/watch_beam.inp', words//'; *MODES, NAME=small, NUMBER=1 > ** no modes', reader)
      allocate (tip, source=channel(reader, 'tip'))
      allocate (stretch, source=channel(reader, 'stretch'))
      print '(2a,2es12.4)', name, ': deflection, elongation', tip(size(tip)), stretch(size(stretch))
      if (warning == '') then
         call check(abs(tip(size(tip)) - deflection) <= 0.02_wp*abs(deflection) + 1.0e-12_wp, name//': deflection')
      else
         call check(tip(size(tip)) >= deflection, name//': it bends')
      end if
      call check(abs(stretch(size(stretch)) - elongation) <= 0.01_wp*elongation + 1.0e-7_wp, name//': elongation')
      call check_warning(reader, warning, name)
      call reader%close()
   end subroutine judge_tip

   !> Leipholz' column flutters at 40.05, whatever the basis is.
   subroutine check_follower()
      call judge_flutter('clamped', '')
      call judge_flutter('pins, with the shapes of the ends', 'SUPPORT=CLAMPED-FREE > SUPPORT=PINNED-ROLLER, CORRECTIONS=YES')
      call judge_flutter('free', 'SUPPORT=CLAMPED-FREE > SUPPORT=FREE-FREE, CORRECTIONS=YES')
   end subroutine check_follower

   subroutine judge_flutter(name, words)
      character(*), intent(in) :: name, words
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: growth(:)
      real(wp) :: below, above
      call run_words('verification/watch_follower.inp', 'push = 40 > push = 39.65; '//words, reader)
      call reader%read_numbers('/modes/small/growth', growth, error)
      call check_no_error(error, name)
      below = maxval(growth)
      call reader%close()
      call run_words('verification/watch_follower.inp', 'push = 40 > push = 40.45; '//words, reader)
      call reader%read_numbers('/modes/small/growth', growth, error)
      above = maxval(growth)
      call reader%close()
      print '(2a,2es12.4)', name, ': growth at 0.99 and 1.01 of the critical load', below, above
      call check(below < 1.0e-3_wp, 'Leipholz'' column, '//name//': at rest below 40.05')
      call check(above > 0.1_wp, 'Leipholz'' column, '//name//': flutter above 40.05')
   end subroutine judge_flutter

   !> The ratio of the modes as they are held, whatever the basis is; that of Rayleigh's mass is alpha/(2 omega).
   subroutine check_damping()
      character(*), parameter :: free = 'SUPPORT=CLAMPED-FREE > SUPPORT=FREE-FREE, CORRECTIONS=YES', &
         & pins = 'SUPPORT=CLAMPED-FREE > SUPPORT=PINNED-ROLLER, CORRECTIONS=YES', heavy = 'load = 1e-9 > load = 2', &
         & mass = 'RATIO=0.05 > RAYLEIGH ALPHA=0.2', both = 'RATIO=0.05 > RAYLEIGH BETA=1e-3, RATIO=0.02'
      real(wp), parameter :: alone(3) = [3.5160153_wp, 22.0344916_wp, 61.6972144_wp]
      call judge_damping('clamped', '', [0.05_wp, 0.05_wp, 0.05_wp], 1.0e-6_wp)
      call judge_damping('free, with corrections', free, [0.05_wp, 0.05_wp, 0.05_wp], 1.0e-6_wp)
      call judge_damping('pins, with the shapes of the ends', pins, [0.05_wp, 0.05_wp, 0.05_wp], 1.0e-6_wp)
      call judge_damping('clamped, with a mass', heavy, [0.05_wp, 0.05_wp, 0.05_wp], 1.0e-6_wp)
      call judge_damping('free, with a mass', free//'; '//heavy, [0.05_wp, 0.05_wp, 0.05_wp], 1.0e-6_wp)
      call judge_damping('mass, clamped', mass, 0.1_wp/alone, 0.01_wp)
      call judge_damping('mass, free', free//'; '//mass, 0.1_wp/alone, 0.01_wp)
      call judge_damping('mass, pins', pins//'; '//mass, 0.1_wp/alone, 0.01_wp)
      call judge_damping('stiffness and ratio, free', free//'; '//both, 0.02_wp + 0.5e-3_wp*alone, 0.01_wp)
      call judge_damping('a ratio of the second mode', pins//'; *MODES >  2, 0.1@*MODES', [0.05_wp, 0.1_wp, 0.05_wp], 1.0e-6_wp)
   end subroutine check_damping

   subroutine judge_damping(name, words, truth, tolerance)
      character(*), intent(in) :: name, words
      !> Of the first three modes
      real(wp), intent(in) :: truth(3), tolerance
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: ratio(:)
      integer :: k
      call run_words('verification/watch_damping.inp', words, reader)
      call reader%read_numbers('/modes/small/damping_ratio', ratio, error)
      call check_no_error(error, name)
      print '(2a,3es14.6)', name, ': damping ratios', ratio
      do k = 1, 3
         call check_close(ratio(k)/truth(k), 1.0_wp, tolerance, 'damping, '//name//', mode '//as_text(k))
      end do
      call reader%close()
   end subroutine judge_damping

   !> Runs a deck with words exchanged, 'old > new; old > new'; @ is a new line.
   subroutine run_words(deck, words, reader)
      character(*), intent(in) :: deck, words
      type(history_reader_type), intent(out) :: reader
      character(200) :: old(8), new(8)
      character(len(words)) :: rest
      integer :: count, at, arrow, i, k
      rest = words
      do i = 1, len(rest)
         if (rest(i:i) == '@') rest(i:i) = achar(10)
      end do
      count = 0
      do while (len_trim(rest) > 0)
         at = index(rest, ';')
         if (at == 0) at = len(rest) + 1
         arrow = index(rest(:at - 1), '>')
         if (arrow > 0) then
            count = count + 1
            old(count) = adjustl(rest(:arrow - 1))
            new(count) = adjustl(rest(arrow + 1:at - 1))
         end if
         do k = 1, min(at, len(rest))
            rest(k:k) = ' '
         end do
         rest = adjustl(rest)
      end do
      call run_changed(deck, trim(results), old(:count), new(:count), reader)
   end subroutine run_words

   !> A cantilever that rotates while a load bends it, without damping: where the model damps its vibrations, that is told, of modes
   !> and of motion; without the load, and of exact beams, nothing is.
   subroutine check_rotating()
      character(*), parameter :: cause = 'leaves out the Coriolis force of its shortening', &
         & fine = 'SECTION=bar > SECTION=bar, DIVISIONS=20'
      call judge_ratio('K_G', fine, cause)
      call judge_ratio('K_G without the load', fine//'; 0, 0.1 > 0, 0', '')
      call judge_ratio('LARGE=YES', large, '')
      call judge_decay('K_G', '', cause)
      call judge_decay('K_G without the load', '0, 0.1 > 0, 0.1*max(0, 1 - t/0.1)', '')
      call judge_decay('exact beam', '*FRAME, NAME=f > *BEAM, LENGTH=1, NAME=f; SPIN=6, DIVISIONS=8 > SPIN=6; '// &
         & '*NODE@ 1, 0, 0, a@ 2, 1, 0, e@*ELEMENT@ 1, 1, 2@*BOUNDARY@ 1, 1, 6@ > ** none@; f.a, > f.start,; '// &
         & 'f.e, FOLLOWER > f.end, FOLLOWER; u2(f.e) > u2(f.end)', '')
   end subroutine check_rotating

   !> The damping ratio of the first mode is zero, or wrong and warned of.
   subroutine judge_ratio(name, words, warning)
      character(*), intent(in) :: name, words, warning
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: growth(:), frequency(:)
      real(wp) :: ratio
      call run_words('verification/watch_rotating.inp', words, reader)
      call reader%read_numbers('/modes/small/growth', growth, error)
      call check_no_error(error, 'growth')
      call reader%read_numbers('/modes/small/frequency', frequency, error)
      call check_no_error(error, 'frequency')
      ratio = abs(growth(1)/frequency(1))
      print '(2a,es12.3)', name, ': ratio', ratio
      if (warning /= '') call check(ratio > 0.01_wp, 'rotating, '//name//': wrong')
      if (warning == '') call check(ratio < 1.0e-6_wp, 'rotating, '//name//': right')
      call check_warning(reader, warning, 'rotating, '//name)
      call reader%close()
   end subroutine judge_ratio

   !> The amplitude in the end is that at first, or not and warned of.
   subroutine judge_decay(name, words, warning)
      character(*), intent(in) :: name, words, warning
      type(history_reader_type) :: reader
      real(wp), allocatable :: u(:)
      type(error_type), allocatable :: error
      character(:), allocatable :: text
      real(wp) :: lost
      call run_words('verification/watch_decay.inp', words, reader)
      allocate (u, source=channel(reader, 'u'))
      lost = 1 - (maxval(u(351:)) - minval(u(351:)))/(maxval(u(21:171)) - minval(u(21:171)))
      print '(2a,es12.3)', name, ': lost', lost
      if (warning /= '') call check(lost > 0.1_wp, 'decay, '//name//': wrong')
      if (warning == '') call check(abs(lost) < 0.1_wp, 'decay, '//name//': right')
      call reader%read_text('/run/warnings', text, error)
      call check_no_error(error, name//': warnings')
      call check((index(text, 'Coriolis') > 0) .eqv. (warning /= ''), 'decay, '//name//': '//text)
      call reader%close()
   end subroutine judge_decay

   !> Moments at the clamp of a member that is pulled, in closed form, or wrong and warned of.
   subroutine check_pulled()
      character(*), parameter :: cause = 'bends near ends and loads over less length'
      integer :: i
      real(wp) :: pull
      do i = 1, 4
         pull = 100.0_wp*10.0_wp**(i - 2)
         call judge_pulled(pull, '', trim(merge(cause, repeat(' ', len(cause)), i > 2)))
         call judge_pulled(pull, 'm = bending_moment(f.a) > m = 0-moment(w)', trim(merge(cause, repeat(' ', len(cause)), i > 2)))
         if (i < 3) call judge_pulled(pull, large, '')
      end do
   end subroutine check_pulled

   subroutine judge_pulled(pull, words, warning)
      real(wp), intent(in) :: pull
      character(*), intent(in) :: words, warning
      type(history_reader_type) :: reader
      real(wp), allocatable :: m(:)
      real(wp) :: off, k
      call run_words('verification/watch_pulled.inp', 'pull = 100 > pull = '//as_text(pull, 6)//'; '//words, reader)
      allocate (m, source=channel(reader, 'm'))
      k = sqrt(pull)
      off = abs(m(size(m))*k/tanh(k) - 1)
      print '(a,f10.0,3a,es12.3)', 'pull', pull, ', ', words, ': error', off
      if (warning == '') call check(off < 0.05_wp, 'pulled, '//words//': right')
      call check_warning(reader, warning, 'pulled by '//as_text(pull, 6)//', '//words)
      call reader%close()
   end subroutine judge_pulled

end program test_model_watch
