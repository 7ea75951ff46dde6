!> Axial dynamics: a struck rod against d'Alembert's solution; beams whose axial coordinates follow at rest (AXIAL DYNAMICS=STATIC)
!> against those that vibrate along themselves and against independent solutions, by all integrators; what is admissible, and what
!> is not. Usage, in tests/: test_axial RESULT_FILE
program test_axial
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use limber_analysis_axial, only: axial_verdict_type, judge_axial
   use limber_analysis_run, only: run_deck
   use limber_analysis_scene, only: scene_type, read_scene
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_changed, change_deck, channel, read_columns
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   character(40), parameter :: still = 'AXIAL DYNAMICS=STATIC, AXIAL BASIS=', basis = 'AXIAL BASIS='
   character(256) :: results

   call get_command_argument(1, results)
   call test_struck_rod()
   call test_slider_crank()
   call test_spin_up()
   call test_blade()
   call test_verdicts()
   call test_refusals()
   call finish()

contains

   !> Both ends of the rod: the impulse over Z = rho A c, and its reflections. Everything vibrates.
   subroutine test_struck_rod()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), parameter :: c = sqrt(2.0e11_wp/7850), z = 7850*acos(-1.0_wp)*0.01_wp**2*c
      real(wp), allocatable :: t(:), struck(:), free(:), exact(:)
      real(wp) :: whole
      integer :: k, i
      call run_changed('../input/struck_rod.inp', trim(results), [character(1) ::], [character(1) ::], reader)
      call reader%read_time(t, error)
      call check_no_error(error, 'struck rod: times')
      allocate (struck, source=channel(reader, 'x_rod_start'))
      allocate (free, source=channel(reader, 'x_rod_end'))
      call reader%close()
      allocate (exact(size(t)))
      exact = [(impulse(t(i)), i=1, size(t))]/z
      do k = 1, 4
         exact = exact + [(2*impulse(t(i) - 2*k/c), i=1, size(t))]/z
      end do
      whole = exact(size(t))
      print '(a,2es10.2)', 'struck rod: errors of the struck end', maxval(abs(struck - exact))/whole
      call check_close(maxval(abs(struck - exact))/whole, 0.0_wp, 2.0e-3_wp, 'struck rod: struck end')
      exact = 1.0_wp
      do k = 1, 4
         exact = exact + [(2*impulse(t(i) - (2*k - 1)/c), i=1, size(t))]/z
      end do
      print '(a,2es10.2)', 'struck rod: errors of the free end', maxval(abs(free - exact))/whole
      call check_close(maxval(abs(free - exact))/whole, 0.0_wp, 5.0e-4_wp, 'struck rod: free end')
   end subroutine test_struck_rod

   !> Integral of the blow 1e4 sin^2 until t.
   pure real(wp) function impulse(t)
      real(wp), intent(in) :: t
      real(wp), parameter :: passage = 1/sqrt(2.0e11_wp/7850), pi = acos(-1.0_wp)
      impulse = 0.0_wp
      if (t > 0.0_wp) impulse = 1.0e4_wp*(0.5_wp*t - passage*sin(2*pi*t/passage)/(4*pi))
      if (t > passage) impulse = 0.5e4_wp*passage
   end function impulse

   !> The paper's mechanism: within the target of 1e-2 by far, at steps more than 5 times as long.
   subroutine test_slider_crank()
      real(wp), allocatable :: full(:), now(:), reference(:, :)
      integer :: steps(2), i
      character(5), parameter :: integrators(3) = ['ADAMS', 'RADAU', 'ALPHA']
      real(wp), parameter :: most(3) = [1.5e-3_wp, 1.5e-3_wp, 5.0e-3_wp]
      character(14), parameter :: tolerances(3) = ['TOLERANCE=1e-8', 'TOLERANCE=1e-7', 'TOLERANCE=1e-5']
      character(60) :: old(2), new(2)
      old = [character(60) :: basis, 'TOLERANCE=1e-8']
      new = [character(60) :: basis, 'TOLERANCE=1e-8, INTEGRATOR=ADAMS']
      call run('../input/slider_crank_full.inp', old, new, 'deflection_over_length', full, steps(1))
      allocate (reference(7, size(full)))
      call read_columns('reference/slider_crank_6mm.csv', reference)
      do i = 1, 3
         new = [character(60) :: still, tolerances(i)//', INTEGRATOR='//integrators(i)]
         call run('../input/slider_crank_full.inp', old, new, 'deflection_over_length', now, steps(2))
         call compare('slider-crank, '//integrators(i), now, full, most(i))
         call compare('slider-crank, '//integrators(i)//', and the reference', now, reference(3, :), most(i))
         if (i == 1) call check(steps(1) > 5*steps(2), 'slider-crank: steps '//as_text(steps(1))//' and '//as_text(steps(2)))
      end do
   end subroutine test_slider_crank

   !> Spin-up (FULL): deflection and the stretch, which is found afterwards.
   subroutine test_spin_up()
      real(wp), allocatable :: full(:), now(:), energy(:)
      real(wp) :: exact(4, 1001), k
      integer :: steps(2), i
      character(5), parameter :: integrators(2) = ['ADAMS', 'RADAU']
      character(60) :: old(2), new(2)
      call read_columns('reference/spin_up_beam.csv', exact)
      old = [character(60) :: basis, 'INTEGRATOR=ADAMS']
      call run('../input/spin_up.inp', old, old, 'u2_tip', full, steps(1))
      ! Steady extension
      k = 6*sqrt(1.2_wp/2.8e7_wp)
      do i = 1, 2
         new = [character(60) :: still, 'INTEGRATOR='//integrators(i)]
         call run('../input/spin_up.inp', old, new, 'u2_tip', now, steps(2))
         call compare('spin-up, '//integrators(i), now, full, 2.0e-4_wp)
         call compare('spin-up, '//integrators(i)//', and the reference', now, exact(3, :), 1.0e-2_wp)
         call check(steps(1) > 5*steps(2), 'spin-up: steps '//as_text(steps(1))//' and '//as_text(steps(2)))
         now = channel_again('u1_tip')
         call check_close(now(1001), 10*(tan(10*k)/(10*k) - 1), 1.0e-3_wp*now(1001), 'spin-up: steady extension')
         energy = channel_again('energy_balance')
         call check_close(maxval(abs(energy)), 0.0_wp, 2.0e-3_wp, 'spin-up: balance of energy, of 7200, and work')
      end do
   end subroutine test_spin_up

   !> The rotating cantilever (K_G), whose axial loads push the bending without a potential.
   subroutine test_blade()
      real(wp), allocatable :: full(:), force(:), now(:)
      integer :: steps(2), i
      character(5), parameter :: integrators(2) = ['ADAMS', 'RADAU']
      character(60) :: old(2), new(2)
      old = [character(60) :: basis, 'TOLERANCE=1e-7']
      new = [character(60) :: basis, 'TOLERANCE=1e-7, INTEGRATOR=ADAMS']
      call run('../input/rotating_cantilever.inp', old, new, 'u2_blade_end', full, steps(1))
      force = channel_again('axial_force_blade_start')
      do i = 1, 2
         new = [character(60) :: still, 'TOLERANCE=1e-7, INTEGRATOR='//integrators(i)]
         call run('../input/rotating_cantilever.inp', old, new, 'u2_blade_end', now, steps(2))
         call compare('blade, '//integrators(i), now, full, 2.0e-4_wp)
         call check(steps(1) > 5*steps(2), 'blade: steps '//as_text(steps(1))//' and '//as_text(steps(2)))
         call compare('blade, axial force, '//integrators(i), channel_again('axial_force_blade_start'), force, 5.0e-4_wp)
      end do
   end subroutine test_blade

   !> Runs a changed deck; a channel of it, and the steps that it took.
   subroutine run(path, old, new, name, values, steps)
      character(*), intent(in) :: path, old(:), new(:), name
      real(wp), allocatable, intent(out) :: values(:)
      integer, intent(out) :: steps
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      integer :: to
      call change_deck(path, trim(results)//'.inp', old, new)
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
      call check_no_error(error, path)
      steps = 0
      allocate (values(0))
      if (allocated(error)) return
      call check(index(report, 'warning') == 0, path//' has no warning: '//report)
      to = index(report, ' steps (')
      read (report(index(report(:to - 1), ' ', back=.true.):to), *) steps
      values = channel_again(name)
   end subroutine run

   !> A channel of the last run.
   function channel_again(name) result(values)
      character(*), intent(in) :: name
      real(wp), allocatable :: values(:)
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      call reader%open(trim(results), error)
      call check_no_error(error, 'results')
      allocate (values, source=channel(reader, name))
      call reader%close()
   end function channel_again

   subroutine compare(name, now, reference, most)
      character(*), intent(in) :: name
      real(wp), intent(in) :: now(:), reference(:), most
      real(wp) :: wrong
      call check(size(now) == size(reference), name//': number of samples')
      wrong = maxval(abs(now - reference))/maxval(abs(reference))
      print '(2a,es10.2)', name, ': difference', wrong
      call check_close(wrong, 0.0_wp, most, name)
   end subroutine compare

   !> What is said of scenes before they run.
   subroutine test_verdicts()
      call judge('../input/slider_crank_full.inp', [basis], [still], .true.)
      call judge('../input/spin_up.inp', [basis], [still], .true.)
      call judge('../input/rotating_cantilever.inp', [basis], [still], .true.)
      call judge('../input/struck_rod.inp', ['AXIAL MODES=40'], ['AXIAL DYNAMICS=STATIC, AXIAL MODES=40'], .false.)
   end subroutine test_verdicts

   subroutine judge(path, old, new, admissible)
      character(*), intent(in) :: path, old(:), new(:)
      logical, intent(in) :: admissible
      type(scene_type) :: scene
      type(error_type), allocatable :: error
      type(axial_verdict_type) :: verdict
      integer :: i
      call change_deck(path, trim(results)//'.inp', old, new)
      call read_scene(trim(results)//'.inp', scene, error)
      call check_no_error(error, path)
      if (allocated(error)) return
      do i = 1, size(scene%system%model%bodies)
         if (.not. scene%system%model%bodies(i)%reduced%condensed) cycle
         call judge_axial(scene%system, scene%work, scene%q, scene%v, i, 1.0e-2_wp, verdict)
         print '(a,4es10.2)', path, verdict%frequency, verdict%change, verdict%error, verdict%share
         print '(2x,a)', verdict%words
         call check(verdict%admissible .eqv. admissible, path//': '//verdict%words)
      end do
   end subroutine judge

   !> Warnings before and after a run; errors where nothing can be run.
   subroutine test_refusals()
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call change_deck('../input/struck_rod.inp', trim(results)//'.inp', ['AXIAL MODES=40'], &
         & ['AXIAL DYNAMICS=STATIC, AXIAL MODES=40'])
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
      call check_no_error(error, 'struck rod at rest')
      call check(index(report, "beam 'rod' must not stretch as at rest") > 0, 'struck rod: warned of before the run: '//report)
      call check(index(report, 'did not follow its loads') > 0, 'struck rod: warned of by the run: '//report)
      call change_deck('../input/slider_crank_full.inp', trim(results)//'.inp', [character(60) :: basis, 'TOLERANCE=1e-8'], &
         & [character(60) :: still, 'TOLERANCE=1e-5, INTEGRATOR=CONSERVING'])
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
      call check(allocated(error), 'CONSERVING is refused')
      if (allocated(error)) call check(index(error%message, 'CONSERVING cannot be used where axial coordinates') > 0, error%message)
      ! Held at both ends it cannot bend without stretching
      call change_deck('../input/slider_crank_full.inp', trim(results)//'.inp', [character(60) :: basis, ' slider, ground.origin', &
         & 'TYPE=POINT ON LINE', '*DRIVER, NAME=motor, TYPE=ANGLE, BODY=crank', ' speed*t'], [character(60) :: still, &
         & ' slider, ground.nail', 'TYPE=REVOLUTE', '*GROUND', ' nail, crank + length, 0'])
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
      call check(allocated(error), 'a beam that is held at both ends is refused')
      if (allocated(error)) call check(index(error%message, 'cannot bend without stretching') > 0, error%message)
   end subroutine test_refusals

end program test_axial
