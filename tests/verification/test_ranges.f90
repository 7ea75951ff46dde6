!> No silent wrong answers: for each assumption of the models of beams a scene that breaks it, wrong against an independent value
!> and warned of, and beside it one within range, right and without a warning. Sources: elliptic integrals and shooting for the
!> elastica, shooting for w'''' = (T w')' + omega^2 w, beam-columns and membranes in closed form (doc/fidelity.md). Usage, in
!> tests/: test_ranges RESULT_FILE
program test_ranges
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text, newline
   use limber_monitor_indicators, only: indicator_count, indicator_meanings, indicator_names
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_changed, channel, check_warning
   use testing, only: check, check_no_error, check_text, finish
   implicit none
   !> The beam on a hinge and a roller, and between two hinges: words that are exchanged
   character(*), parameter :: pins = 'CLAMPED-FREE > PINNED-ROLLER; TYPE=WELD > TYPE=REVOLUTE; *FORCE, NAME=tip > '
   character(*), parameter :: on_roller = pins//'*JOINT, NAME=roller, TYPE=POINT ON LINE'//achar(10)// &
      & ' beam.end, ground.origin'//achar(10)//'*FORCE, NAME=tip; '
   character(*), parameter :: on_hinges = pins//'*JOINT, NAME=second, TYPE=REVOLUTE'//achar(10)//' beam.end, ground.far'// &
      & achar(10)//'*GROUND'//achar(10)//' far, 1, 0'//achar(10)//'*FORCE, NAME=tip; '
   character(*), parameter :: linear = 'GEOMETRIC=K_G > GEOMETRIC=LINEAR; ', &
      & rigid = 'GEOMETRIC=K_G, ELEMENTS=40 > GEOMETRIC=RIGID; '// &
      & 'BENDING MODES=4, GEOMETRIC ELEMENTS=8, AXIAL BASIS=STATIC > MODES=6; '
   character(*), parameter :: one_mode = 'AXIAL BASIS=STATIC > AXIAL BASIS=MODES, AXIAL MODES=1; '
   character(*), parameter :: pushed = 'across = 0 > across = '
   real(wp), parameter :: pi = acos(-1.0_wp)
   character(256) :: results

   call get_command_argument(1, results)
   call check_linear()
   call check_buckling()
   call check_size()
   call check_axial()
   call check_loads()
   call check_motion()
   call check_drift()
   call check_stiffening()
   call check_rigid()
   call check_quick()
   call finish()

contains

   !> LINEAR leaves out the work of axial forces: of rotation, and of a compression.
   subroutine check_linear()
      call judge('rotation 0.28 of the first frequency', pushed//'0.1; speed = 0 > speed = 1; '//linear, 'tip', &
         & 0.0327510999_wp, 0.10_wp, 'geometric', 0.088_wp, "beam 'beam' deflects under axial forces")
      call judge('rotation 0.14 of it', pushed//'0.1; speed = 0 > speed = 0.5; '//linear, 'tip', &
         & 0.0331853505_wp, 0.03_wp, 'geometric', 0.023_wp, '')
      call judge('K_G under rotation', pushed//'0.1; speed = 0 > speed = 1', 'tip', &
         & 0.0327510999_wp, 0.005_wp, 'geometric', 0.088_wp, '')
      call judge('LINEAR beam-column', on_roller//linear//'along = 0 > along = -4; weight = 0 > weight = 0.001', 'middle', &
         & -2.1925982355e-5_wp, 0.40_wp, 'geometric', 0.405_wp, 'a LINEAR beam leaves it out')
      call judge('LINEAR beam-column at 2 %', on_roller//linear//'along = 0 > along = -0.2; weight = 0 > weight = 0.001', &
         & 'middle', -1.3288756e-5_wp, 0.025_wp, 'geometric', 0.020_wp, '')
   end subroutine check_linear

   !> At 1.115 times Euler's load the elastica has its middle at 0.268.
   subroutine check_buckling()
      call judge('LINEAR does not buckle', on_roller//linear//'along = 0 > along = -11', 'middle', 0.2679176218_wp, 1.0_wp, &
         & 'compression', 1.115_wp, 'a LINEAR beam does not buckle')
      call judge('K_G at 0.96 of it', on_roller//'along = 0 > along = -9.5; weight = 0 > weight = 0.001', 'middle', &
         & -3.4898191519e-4_wp, 0.002_wp, 'compression', 0.9625_wp, '')
   end subroutine check_buckling

   !> Deflections and slopes in one frame, against the elastica under a dead load at the tip.
   subroutine check_size()
      call judge('K_G at 16 % of the length', pushed//'0.5', 'tip', 0.162144_wp, 0.027_wp, 'deflection', 0.1666_wp, &
         & 'of its length in its frame at t = 0, beyond the 10 % that K_G is for')
      call judge('K_G at 7 %', pushed//'0.2', 'tip', 0.066364_wp, 0.005_wp, 'deflection', 0.0666_wp, '')
   end subroutine check_size

   !> Axial functions that cannot carry the tension or the shortening, k_G elements that are too few, ends that cannot approach.
   subroutine check_axial()
      character(*), parameter :: sixteen = 'GEOMETRIC ELEMENTS=8 > GEOMETRIC ELEMENTS=16; '
      call judge('one axial mode for a centrifugal tension', one_mode//sixteen//pushed//'0.1; speed = 0 > speed = 10', 'tip', &
         & 0.0144294776_wp, 0.19_wp, 'axial', 0.056_wp, 'its axial functions cannot carry the tension')
      call judge('static functions for it', sixteen//pushed//'0.1; speed = 0 > speed = 10', 'tip', &
         & 0.0144294776_wp, 0.0123_wp, 'axial', 0.00063_wp, "channel 'slope' of *STATICS 'statics' errs by about 3")
      call judge('2 k_G elements', pushed//'0.1; speed = 0 > speed = 6; GEOMETRIC ELEMENTS=8 > GEOMETRIC ELEMENTS=2', 'tip', &
         & 0.0213660959_wp, 0.1_wp, 'coarseness', 0.13_wp, 'use GEOMETRIC ELEMENTS=4')
      call judge('8 k_G elements', pushed//'0.1; speed = 0 > speed = 6', 'tip', 0.0213660959_wp, 0.012_wp, 'coarseness', &
         & 0.007_wp, '')
      call judge('held ends', on_hinges//'weight = 0 > weight = 0.1', 'middle', -1.0272756052e-3_wp, 0.26_wp, 'axial', 0.30_wp, &
         & 'its ends cannot approach each other')
      call judge('held ends, little bent', on_hinges//'weight = 0 > weight = 0.01', 'middle', -1.2965712247e-4_wp, 0.006_wp, &
         & 'axial', 0.0043_wp, '')
   end subroutine check_axial

   !> Loads and joints that the modes cannot follow, and masses in too few nodes.
   subroutine check_loads()
      call judge('a couple on two modes', 'couple = 0 > couple = 0.05; MODES=4 > MODES=2', 'slope', 0.05_wp, 0.2_wp, &
         & 'residual', 0.2_wp, 'in ways that its 2 bending coordinates cannot')
      call judge('with the shapes of its ends', 'couple = 0 > couple = 0.05; MODES=4 > MODES=2, CORRECTIONS=YES', &
         & 'slope', 0.05_wp, 0.003_wp, 'residual', 0.0_wp, '')
      call judge('modes of pins on a weld', 'CLAMPED-FREE > PINNED-ROLLER; '//pushed//'0.1', 'slope', 1/60.0_wp, 0.03_wp, &
         & 'residual', 0.13_wp, 'a SUPPORT that is like its joints')
      call judge('two elements', on_roller//'weight = 0 > weight = 0.1; ELEMENTS=40 > ELEMENTS=2; MODES=4 > MODES=1; '// &
         & 'GEOMETRIC ELEMENTS=8 > GEOMETRIC ELEMENTS=1', 'middle', -1.3020833333e-3_wp, 0.2_wp, 'lumping', 0.25_wp, &
         & 'use ELEMENTS=6')
      call judge('ten elements', on_roller//'weight = 0 > weight = 0.1; ELEMENTS=40 > ELEMENTS=10', 'middle', &
         & -1.3020833333e-3_wp, 0.009_wp, 'lumping', 0.01_wp, '')
   end subroutine check_loads

   !> The linear slider-crank of the paper in half a turn: 0.01876 in place of 0.015388; a blade above its first frequency.
   subroutine check_motion()
      type(history_reader_type) :: reader
      real(wp), allocatable :: tip(:)
      real(wp) :: right, wrong
      call run_changed('../input/slider_crank_fig5_linear.inp', trim(results), [character(9) :: 'turns = 2'], &
         & [character(11) :: 'turns = 0.5'], reader)
      wrong = maxval(abs(channel(reader, 'deflection_over_length')))
      call check(wrong > 1.15_wp*0.015388114793_wp, 'the linear rod deflects too much')
      call check_warning(reader, "beam 'rod' deflects under axial forces", 'linear rod')
      call reader%close()
      call run_changed('../input/slider_crank_fig5_kg.inp', trim(results), [character(9) :: 'turns = 2'], &
         & [character(11) :: 'turns = 0.5'], reader)
      right = maxval(abs(channel(reader, 'deflection_over_length')))
      call check(abs(right/0.015388114793_wp - 1) < 0.03_wp, 'that with k_G elements does not')
      call check_warning(reader, '', 'rod with k_G elements')
      call reader%close()
      call run_changed('verification/range_rotor.inp', trim(results), [character(1) ::], [character(1) ::], reader)
      allocate (tip, source=channel(reader, 'tip'))
      wrong = tip(size(tip))
      call check_warning(reader, 'rotates at 1.1 times its first frequency', 'linear blade')
      call reader%close()
      call run_changed('verification/range_rotor.inp', trim(results), [character(100) :: 'GEOMETRIC=LINEAR, ELEMENTS=40,', &
         & '       BENDING MODES=2, GEOMETRIC ELEMENTS=8, AXIAL BASIS=STATIC'], &
         & [character(100) :: 'FUNCTIONS=8', '** no modes'], reader)
      tip(:) = channel(reader, 'tip')
      right = maxval(abs(tip))
      call check_warning(reader, '', 'blade with tension')
      call reader%close()
      print '(a,2es12.3)', 'blade above its first frequency: linear, full', wrong, right
      call check(abs(wrong) > 3*right, 'the linear blade runs away')
   end subroutine check_motion

   !> K_G leaves out the inertia of the shortening: with the mode sin(pi x) and the mass at the end, (1/2 + c a^2) a'' + c a a'^2 +
   !> pi^4/2 a = 0, c = mass pi^4/4 + int (int_0^x pi^2 cos^2)^2. Without it 16/pi and 5/pi are 8 and 2.5 vibrations.
   subroutine check_drift()
      character(*), parameter :: long = 'end = 5 > end = 16/pi', &
         & short = 'amplitude = 0.008 > amplitude = 0.004; end = 5 > end = 5/pi'
      real(wp), parameter :: eight = 16/pi, few = 5/pi
      call drifts('K_G for eight vibrations', long, 0.008_wp, eight, 0.168_wp, 0.155_wp, 'the inertia of its shortening')
      call drifts('K_G for few small ones', short, 0.004_wp, few, 0.015_wp, 0.012_wp, '')
   end subroutine check_drift

   !> A blade at a tenth of its first frequency, pushed for a moment, in thirty vibrations: omega**2 = omega1**2 + 0.193 speed**2 in
   !> the plane of rotation (Wright et al. 1982); LINEAR has omega1**2 - speed**2, and is more than one radian behind.
   subroutine check_stiffening()
      character(*), parameter :: slow(2) = [character(9) :: 'speed = 4', 'END=1.5'], &
         & changed(2) = [character(12) :: 'speed = 0.35', 'END=54']
      real(wp), parameter :: first = 3.516015_wp, speed = 0.35_wp, pushed_for = 0.2_wp
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: tip(:), t(:), right(:)
      real(wp) :: omega
      call run_changed('verification/range_rotor.inp', trim(results), slow, changed, reader)
      allocate (tip, source=channel(reader, 'tip'))
      call reader%read_time(t, error)
      call check_no_error(error, 'times of the blade')
      omega = sqrt(first**2 + 0.193_wp*speed**2)
      allocate (right, source=0.04_wp/omega**2*(cos(omega*max(t - pushed_for, 0.0_wp)) - cos(omega*t)))
      print '(a,f8.3)', 'LINEAR blade, thirty vibrations', maxval(abs(tip - right))/maxval(abs(right))
      call check(maxval(abs(tip - right)) > 0.9_wp*maxval(abs(right)), 'the linear blade is late')
      call check_warning(reader, 'the work of axial forces on its bending, which a LINEAR beam leaves out, to shift the', &
         & 'linear blade, thirty vibrations')
      call reader%close()
      call run_changed('verification/range_rotor.inp', trim(results), [character(100) :: slow(1), slow(2), &
         & 'GEOMETRIC=LINEAR, ELEMENTS=40,', &
         & '       BENDING MODES=2, GEOMETRIC ELEMENTS=8, AXIAL BASIS=STATIC'], &
         & [character(100) :: changed(1), changed(2), 'FUNCTIONS=8', '** no modes'], reader)
      tip(:) = channel(reader, 'tip')
      print '(a,f8.3)', 'blade with tension, thirty vibrations', maxval(abs(tip - right))/maxval(abs(right))
      call check(maxval(abs(tip - right)) < 0.1_wp*maxval(abs(right)), 'the blade with tension is in time')
      call reader%close()
   end subroutine check_stiffening

   !> Runs the beam with a mass at its end, and compares its middle at the end with the solution, relative to the amplitude.
   subroutine drifts(name, words, amplitude, end, error, value, warning)
      !> As in `judge`
      character(*), intent(in) :: name, words, warning
      real(wp), intent(in) :: amplitude, end, error, value
      integer, parameter :: steps = 20000
      real(wp) :: c, x, a(2), k1(2), k2(2), h
      integer :: i
      c = 4*pi**4/4
      do i = 1, 1000
         x = (i - 0.5_wp)/1000
         c = c + (pi**2*(x/2 + sin(2*pi*x)/(4*pi)))**2/1000
      end do
      a = [0.0_wp, pi**2*amplitude]
      h = end/steps
      do i = 1, steps
         k1 = rate(c, a)
         k2 = rate(c, a + h/2*k1)
         a = a + h*k2
      end do
      call judge_run('verification/range_drift.inp', name, words, 'middle', a(1), error, amplitude, 'drift', value, warning)
   end subroutine drifts

   !> Speed and acceleration of the middle.
   pure function rate(c, y)
      real(wp), intent(in) :: c, y(2)
      real(wp) :: rate(2)
      rate = [y(2), -(pi**4/2*y(1) + c*y(1)*y(2)**2)/(0.5_wp + c*y(1)**2)]
   end function rate

   !> A beam that the deck makes rigid deflects as elastic ones do, F L^3/(3 E I), C L^2/(2 E I), q L^4/(8 E I), 5 q L^4/(384 E I),
   !> or buckles; what is left out is all of it, in range up to a hundredth of the length.
   subroutine check_rigid()
      character(*), parameter :: bends = 'it would deflect by'
      call judge('RIGID under a force', rigid//pushed//'0.05', 'tip', 1/60.0_wp, 1.0_wp, 'deflection', 0.01667_wp, bends)
      call judge('RIGID under a small force', 'SUPPORT=CLAMPED-FREE > X=0; '//rigid//pushed//'0.02', 'tip', 1/150.0_wp, 1.001_wp, &
         & 'deflection', 0.00667_wp, '')
      call judge('RIGID under a couple', rigid//'couple = 0 > couple = 0.03', 'tip', 0.015_wp, 1.0_wp, 'deflection', &
         & 0.015_wp, bends)
      call judge('RIGID under its weight', rigid//'weight = 0 > weight = 0.1', 'tip', -0.0125_wp, 1.0_wp, 'deflection', &
         & 0.0125_wp, bends)
      call judge('RIGID on a roller', on_roller//rigid//'weight = 0 > weight = 1', 'middle', -5/384.0_wp, 1.0_wp, 'deflection', &
         & 0.01302_wp, bends)
      call judge('RIGID strut', on_roller//rigid//'along = 0 > along = -11', 'middle', 0.2679176218_wp, 1.0_wp, 'compression', &
         & 1.115_wp, 'a RIGID beam does not buckle')
      call judge_run('verification/range_beam.inp', 'RIGID strut at 0.41 of it', on_roller//rigid//'along = 0 > along = -4', &
         & 'middle', 0.0_wp, 1.0e-9_wp, 1.0_wp, 'compression', 0.405_wp, '')
   end subroutine check_rigid

   !> A force at 0.85 of the first frequency, which at rest would bend the rigid bar by 0.4 % of its length, bends an elastic one by
   !> the factor of a forced vibration; one at 0.14 of it does not.
   subroutine check_quick()
      real(wp), parameter :: first = 3.51602_wp, rest = 0.012_wp/3
      type(history_reader_type) :: reader
      real(wp) :: bent
      integer :: i
      bent = 0.0_wp
      do i = 1, 600
         bent = max(bent, abs(rest/(1 - (3/first)**2)*(sin(0.03_wp*i) - 3/first*sin(first*0.01_wp*i))))
      end do
      call check(bent > 0.0195_wp, 'an elastic bar deflects by two per cent: '//as_text(bent, 3))
      call run_changed('verification/range_rigid.inp', trim(results), [character(1) ::], [character(1) ::], reader)
      call check_warning(reader, "beam 'beam' is RIGID, but its loads change at 0.8", 'RIGID under a quick force')
      call reader%close()
      call run_changed('verification/range_rigid.inp', trim(results), [character(8) :: 'pace = 3'], &
         & [character(10) :: 'pace = 0.5'], reader)
      call check_warning(reader, '', 'RIGID under a slow force')
      call reader%close()
   end subroutine check_quick

   !> Runs the beam with words exchanged and compares the last sample of a channel with its true value, an indicator with a value
   !> to a tenth, and the warnings of the run.
   subroutine judge(name, words, of, truth, error, indicator, value, warning)
      !> What is judged; words and those that stand for them: 'old > new; old > new'; channel and its true value
      character(*), intent(in) :: name, words, of
      real(wp), intent(in) :: truth
      !> Relative error: about what it is, if there is a warning (between 0.8 and 1.25 times that), else its bound
      real(wp), intent(in) :: error
      character(*), intent(in) :: indicator
      real(wp), intent(in) :: value
      !> Part of the warning; empty: there is none
      character(*), intent(in) :: warning
      call judge_run('verification/range_beam.inp', name, words, of, truth, error, abs(truth), indicator, value, warning)
   end subroutine judge

   !> The same of any deck, with an error relative to what is given.
   subroutine judge_run(deck, name, words, of, truth, error, scale, indicator, value, warning)
      character(*), intent(in) :: deck, name, words, of, indicator, warning
      real(wp), intent(in) :: truth, error, scale, value
      type(history_reader_type) :: reader
      type(error_type), allocatable :: failure
      real(wp), allocatable :: samples(:), table(:, :)
      real(wp) :: pair(2)
      character(200) :: old(12), new(12)
      real(wp) :: off
      integer :: count, at
      call split(words, old, new, count)
      call run_changed(deck, trim(results), old(:count), new(:count), reader)
      allocate (samples, source=channel(reader, of))
      off = abs(abs(samples(size(samples))) - abs(truth))/scale
      call reader%read_table('/bodies/beam/indicators', table, failure)
      call check_no_error(failure, name//': indicators')
      do at = 1, indicator_count
         if (indicator_names(at) == indicator) exit
      end do
      pair = table(:, at)
      print '(2(a,es10.2),3a)', name//': error', off, ', '//indicator, pair(1), ' (', warning, ')'
      if (warning == '') then
         call check(off < error, name//': right to '//as_text(error, 2)//', off by '//as_text(off, 3))
      else
         call check(off > 0.8_wp*error .and. off < 1.25_wp*error, name//': wrong by '//as_text(error, 2)//', '//as_text(off, 3))
      end if
      call check(abs(pair(1) - value) <= 0.1_wp*value + 1.0e-3_wp, name//': '//indicator//' is '//as_text(pair(1), 4))
      call check_warning(reader, warning, name)
      call check_labels(reader)
      call reader%close()
   end subroutine judge_run

   pure subroutine split(words, old, new, count)
      character(*), intent(in) :: words
      character(*), intent(out) :: old(:), new(:)
      integer, intent(out) :: count
      integer :: from, to, arrow
      count = 0
      from = 1
      do while (len_trim(words(from:)) > 0)
         to = index(words(from:), ';') + from - 2
         if (to < from) to = len(words)
         arrow = index(words(from:to), '>') + from - 1
         count = count + 1
         old(count) = adjustl(words(from:arrow - 1))
         new(count) = adjustl(words(arrow + 1:to))
         from = to + 2
         if (from > len(words)) exit
      end do
   end subroutine split

   !> Names and meanings of the indicators stand beside their values, in their order: words and lines.
   subroutine check_labels(reader)
      type(history_reader_type), intent(in) :: reader
      type(error_type), allocatable :: failure
      character(:), allocatable :: names, meanings
      integer :: k
      call reader%read_label('/bodies/beam/indicators', 'names', names, failure)
      call check_no_error(failure, 'names of the indicators')
      call reader%read_label('/bodies/beam/indicators', 'meanings', meanings, failure)
      call check_no_error(failure, 'meanings of the indicators')
      names = names//' '
      meanings = meanings//newline
      do k = 1, indicator_count
         call check_text(names(:index(names, ' ') - 1), trim(indicator_names(k)), 'name of an indicator')
         call check_text(meanings(:index(meanings, newline) - 1), trim(indicator_meanings(k)), 'meaning of an indicator')
         names = names(index(names, ' ') + 1:)
         meanings = meanings(index(meanings, newline) + 1:)
      end do
      call check_text(names//meanings, '', 'no more indicators')
   end subroutine check_labels

end program test_ranges
