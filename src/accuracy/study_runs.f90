!> Runs of a study. One setting at a time, the reference that limber makes itself, the grid with its repeats and its Pareto front,
!> and the families that vary one thing alone. Floor: accuracy; plan -> runs.
module limber_accuracy_study_runs
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use limber_base_kinds, only: wp, long
   use limber_base_error, only: error_type, raise, status_interrupted
   use limber_base_signals, only: signal_came, signal_name
   use limber_base_text, only: as_text, first_line, newline
   use limber_analysis_chosen_integrator, only: new_integrator
   use limber_analysis_dynamic_analysis, only: run_dynamics
   use limber_analysis_run_report, only: energy_warning
   use limber_monitor_model_ranges, only: range_warnings
   use limber_scene_outcome, only: outcome_type, all_warnings
   use limber_scene_first_scene, only: build_scene
   use limber_scene_scene, only: scene_type
   use limber_accuracy_study_plan, only: plan_type, setting_type, variant, finest, levels, set_fine, all_integrators, &
      & axis_integrator, axis_tolerance, axis_modes, axis_elements, axis_fidelity
   use limber_accuracy_study_reference, only: reference_type, take_reference, compare, difference
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_integrator_integrator, only: integrator_type
   use limber_output_progress, only: progress_type, teller_type
   use limber_output_sample_sink, only: memory_type
   implicit none
   private
   public :: run_type, fine_setting, make_reference, run_grid, run_family, median, slope

   !> A setting and what came of it
   type :: run_type
      type(setting_type) :: setting
      !> Why it failed; empty if it did not
      character(:), allocatable :: reason
      !> What it warns of, a line for each; not allocated before it has run
      character(:), allocatable :: warnings
      !> CPU seconds of the time loop of each repeat; wall seconds of building, assembly and time loop
      real(wp), allocatable :: cpu(:), whole(:)
      integer(long) :: steps = 0, rejected = 0, evaluations = 0
      !> Error of each channel: greatest, and at the end
      real(wp), allocatable :: greatest(:), last(:)
      !> Largest of them, or the reference's own uncertainty if that is larger
      real(wp) :: error = huge(1.0_wp), error_at_end = huge(1.0_wp)
      !> Largest residual of the constraints after a step, relative to their scales; imbalance of energy, relative to the
      !> largest energy
      real(wp) :: constraints = 0.0_wp, energy = 0.0_wp
      !> Whether no other run is both faster and more accurate
      logical :: on_front = .false.
   end type run_type

contains

   !> Runs a setting once, and adds its times. One that has run before stays as it was when a signal ends the repeat.
   subroutine simulate(plan, setting, samples, run, limit)
      type(plan_type), intent(in) :: plan
      type(setting_type), intent(in) :: setting
      type(memory_type), intent(inout) :: samples
      type(run_type), intent(inout) :: run
      !> CPU time after which it is given up, if not that of the plan [s]
      real(wp), intent(in), optional :: limit
      type(scene_type) :: scene
      type(diagnostics_type) :: diagnostics
      type(outcome_type) :: outcome
      type(progress_type) :: progress
      type(error_type), allocatable :: error
      class(integrator_type), allocatable :: integrator
      run%setting = setting
      run%reason = ''
      if (.not. allocated(run%cpu)) allocate (run%cpu(0), run%whole(0))
      call variant(plan, setting, scene%deck)
      call build_scene(scene, diagnostics, error)
      if (allocated(error)) then
         run%reason = diagnostics%items(1)%message
         return
      end if
      call new_integrator(scene%system%model%dynamics, integrator)
      call samples%start(size(scene%system%model%channels), plan%samples, plan%limit)
      if (present(limit)) call samples%watch_limit(limit)
      samples%heeds_signals = .true.
      call run_dynamics(scene, integrator, samples, progress, outcome, error)
      if (allocated(error)) then
         if (signal_came() .and. size(run%cpu) > 0) return
         run%reason = first_line(error%message)
         return
      end if
      run%cpu = [run%cpu, outcome%cpu]
      run%whole = [run%whole, scene%building + scene%assembling + outcome%wall]
      run%warnings = scene%warnings//all_warnings(outcome)//range_warnings(outcome%indicators, scene%system%model)// &
         & energy_warning(outcome, scene%system%model%dynamics)
      run%steps = integrator%statistics%steps
      run%rejected = integrator%statistics%rejected
      run%evaluations = integrator%statistics%evaluations
      run%constraints = integrator%statistics%position_residual
      run%energy = outcome%imbalance
      if (outcome%largest_energy > 0.0_wp) run%energy = outcome%imbalance/outcome%largest_energy
   end subroutine simulate

   !> Runs a setting and compares it.
   subroutine measure(plan, setting, reference, samples, run)
      type(plan_type), intent(in) :: plan
      type(setting_type), intent(in) :: setting
      type(reference_type), intent(in) :: reference
      type(memory_type), intent(inout) :: samples
      type(run_type), intent(inout) :: run
      call simulate(plan, setting, samples, run)
      if (run%reason /= '' .or. signal_came()) return
      if (.not. allocated(run%greatest)) allocate (run%greatest(size(plan%channels)), run%last(size(plan%channels)))
      call compare(plan, samples, reference, run%greatest, run%last)
      run%error = max(maxval(run%greatest), reference%uncertainty)
      run%error_at_end = max(maxval(run%last), reference%uncertainty)
      if (.not. (ieee_is_finite(run%error))) run%reason = 'a channel is not finite'
   end subroutine measure

   !> The finest model at the smallest tolerance, with the first integrator of the list.
   function finest_setting(plan) result(setting)
      type(plan_type), intent(in) :: plan
      type(setting_type) :: setting
      integer :: i
      do i = 1, size(setting%level)
         setting%level(i) = finest(plan, i)
      end do
      call set_fine(setting, plan%axis(axis_integrator)%texts(1), least_tolerance(plan))
   end function finest_setting

   !> Smallest tolerance of a study; of one with fixed steps a usual one.
   pure real(wp) function least_tolerance(plan)
      type(plan_type), intent(in) :: plan
      least_tolerance = 1.0e-6_wp
      if (.not. plan%has_steps) least_tolerance = minval(plan%axis(axis_tolerance)%values)
   end function least_tolerance

   !> Makes a reference of the finest model: every integrator at tolerances that are refined by ten until the two that agree
   !> best differ by less than a hundredth of the smallest tolerance of the study, or agree no better. An integrator that costs many
   !> times what RADAU does is given up; where no two are left the one is compared with itself at ten times the tolerance.
   subroutine make_reference(plan, quiet, reference, fine, error)
      !> On return a run may take no longer than four times the faster of the two integrators took: that one is better in
      !> any case
      type(plan_type), intent(inout) :: plan
      !> Whether nothing is said of what is being run
      logical, intent(in) :: quiet
      type(reference_type), intent(out) :: reference
      !> As accurate, with the faster of the two: for the families that vary the model
      type(setting_type), intent(out) :: fine
      !> No two integrators finish, or they do not agree; or a signal asks for the end (status 4)
      type(error_type), allocatable, intent(out) :: error
      type(reference_type), allocatable :: solution(:), before(:)
      type(run_type), allocatable :: runs(:)
      character(24), allocatable :: names(:)
      type(teller_type) :: teller
      real(wp) :: tolerance, least, enough, spent
      integer :: pair(2), best, round
      !> Uncertainty, in units of the error that the advice aims at, that is small enough where more costs more than the limit of a
      !> run
      real(wp), parameter :: certain = 0.1_wp
      allocate (names, source=all_integrators(plan))
      allocate (before(size(names)))
      allocate (solution(size(names)), runs(size(names)))
      fine = finest_setting(plan)
      tolerance = fine%tolerance
      reference%uncertainty = huge(1.0_wp)
      enough = plan%limit
      spent = 0.0_wp
      do round = 1, 12
         tolerance = max(0.1_wp*tolerance, 1.0e-13_wp)
         before = solution
         call solve_all(plan, names, tolerance, quiet, teller, runs, solution, spent)
         if (signal_came()) then
            call raise(error, 'interrupted by '//signal_name()//' while the reference was made; a study begins anew', &
               & status_interrupted)
            return
         end if
         call closest(solution, runs, pair, least)
         if (pair(1) == 0) then
            pair = the_only_one(runs)
            if (pair(1) == 0) exit
            if (round > 1) least = apart(solution(pair(1)), before(pair(1)))
         end if
         if (round > 1 .or. pair(1) /= pair(2)) then
            if (least > 0.5_wp*reference%uncertainty) exit
            best = pair(1)
            if (round > 1) then
               if (apart(solution(pair(2)), before(pair(2))) < apart(solution(pair(1)), before(pair(1)))) best = pair(2)
            end if
            reference = solution(best)
            reference%uncertainty = max(least, 10*epsilon(1.0_wp))
            reference%warnings = runs(best)%warnings
            reference%of_deck = .true.
            reference%source = trim(names(best))//' at '//as_text(tolerance, 2)//'; '//trim(names(sum(pair) - best))//' agrees'
            if (pair(1) == pair(2)) reference%source = trim(names(best))//' at '//as_text(tolerance, 2)// &
               & '; at ten times that it agrees (the others cost too much)'
            enough = max(1.0_wp, 4*min(runs(pair(1))%cpu(1), runs(pair(2))%cpu(1)))
            call set_fine(fine, names(merge(pair(2), pair(1), runs(pair(2))%cpu(1) < runs(pair(1))%cpu(1))), tolerance)
         end if
         if (reference%uncertainty <= 0.01_wp*least_tolerance(plan) .or. tolerance <= 1.0e-13_wp) exit
         ! RADAU, of order 5, takes less than twice the steps at a tenth of the tolerance; methods of lower order more
         if (4*min(runs(pair(1))%cpu(1), runs(pair(2))%cpu(1)) > plan%limit) exit
         if (round > 1 .and. spent > plan%limit .and. reference%uncertainty < certain*plan%aim) exit
      end do
      if (allocated(reference%times)) plan%limit = min(plan%limit, enough)
      if (.not. allocated(reference%times)) then
         call raise(error, 'no reference: it takes two integrators that finish'//reasons(names, runs)//newline// &
            & '   Give a REFERENCE to *STUDY, or more CPU time as LIMIT.')
      else if (reference%uncertainty > 0.1_wp) then
         call raise(error, 'no reference: the integrators do not agree, they are '//as_text(reference%uncertainty, 2)// &
            & ' apart; give smaller tolerances, or a REFERENCE to *STUDY')
      end if
   end subroutine make_reference

   !> The integrator that alone has not failed, twice; zero: there is none.
   pure function the_only_one(runs) result(pair)
      type(run_type), intent(in) :: runs(:)
      integer :: pair(2), i
      pair = 0
      do i = 1, size(runs)
         if (runs(i)%reason == '') pair = i
      end do
   end function the_only_one

   !> Solves the finest model with every integrator that has not failed yet: RADAU first, which ends soonest where vibrations are
   !> fast;
   !> what takes many times as long fails.
   subroutine solve_all(plan, names, tolerance, quiet, teller, runs, solution, spent)
      type(plan_type), intent(in) :: plan
      character(*), intent(in) :: names(:)
      real(wp), intent(in) :: tolerance
      logical, intent(in) :: quiet
      type(teller_type), intent(inout) :: teller
      type(run_type), intent(inout) :: runs(:)
      type(reference_type), intent(inout) :: solution(:)
      !> CPU time of all [s]
      real(wp), intent(inout) :: spent
      !> What an integrator may cost in units of the cheapest so far, and at least [s]
      real(wp), parameter :: dear = 10.0_wp, always = 2.0_wp
      type(memory_type) :: samples
      type(setting_type) :: setting
      real(wp) :: cheapest, clock(2)
      integer :: i, k, first
      setting = finest_setting(plan)
      first = 1
      do i = 1, size(names)
         if (names(i) == 'RADAU') first = i
      end do
      cheapest = plan%limit
      do k = 1, size(names)
         i = modulo(first + k - 2, size(names)) + 1
         if (allocated(runs(i)%reason)) then
            if (runs(i)%reason /= '') cycle
         end if
         if (signal_came()) return
         call set_fine(setting, names(i), tolerance)
         if (allocated(runs(i)%cpu)) deallocate (runs(i)%cpu, runs(i)%whole)
         if (.not. quiet) call teller%say('study', 'reference: '//trim(names(i))//' at TOLERANCE='// &
            & as_text(tolerance, 2)//' begins')
         call cpu_time(clock(1))
         call simulate(plan, setting, samples, runs(i), min(plan%limit, max(always, dear*cheapest)))
         call cpu_time(clock(2))
         spent = spent + clock(2) - clock(1)
         if (runs(i)%reason /= '') cycle
         cheapest = min(cheapest, runs(i)%cpu(1))
         call take_reference(plan, samples, solution(i))
      end do
   end subroutine solve_all

   !> Why integrators failed, a line for each.
   pure function reasons(names, runs) result(text)
      character(*), intent(in) :: names(:)
      type(run_type), intent(in) :: runs(:)
      character(:), allocatable :: text
      integer :: i
      text = ''
      do i = 1, size(runs)
         if (runs(i)%reason /= '') text = text//newline//'   '//trim(names(i))//': '//runs(i)%reason
      end do
   end function reasons

   !> Greatest relative difference of two solutions.
   real(wp) function apart(a, b)
      type(reference_type), intent(in) :: a, b
      real(wp) :: greatest(size(a%values, 1)), last(size(a%values, 1))
      call difference(a, b, greatest, last)
      apart = maxval(greatest)
   end function apart

   !> The two solutions that agree best.
   subroutine closest(solution, runs, pair, least)
      type(reference_type), intent(in) :: solution(:)
      !> Of the solutions; those that failed do not count
      type(run_type), intent(in) :: runs(:)
      !> Indices; zero if there are no two
      integer, intent(out) :: pair(2)
      real(wp), intent(out) :: least
      real(wp) :: now
      integer :: i, j
      least = huge(least)
      pair = 0
      do i = 1, size(solution)
         do j = i + 1, size(solution)
            if (runs(i)%reason /= '' .or. runs(j)%reason /= '') cycle
            now = apart(solution(i), solution(j))
            if (now > least) cycle
            least = now
            pair = [i, j]
         end do
      end do
   end subroutine closest

   !> Runs the whole grid once, then again what can be worth its time: what no other run beats in error at half the time.
   !> Each round goes over all settings in turn, so that a slow moment of the machine does not fall on one of them. When a signal
   !> asks for the end, what has run once is kept.
   subroutine run_grid(plan, reference, progress, runs)
      type(plan_type), intent(in) :: plan
      type(reference_type), intent(in) :: reference
      type(progress_type), intent(inout) :: progress
      !> All settings; fewer after a signal
      type(run_type), allocatable, intent(out) :: runs(:)
      type(memory_type) :: samples
      type(setting_type), allocatable :: settings(:)
      logical, allocatable :: worth(:)
      integer :: i, round
      allocate (settings, source=grid_of(plan))
      allocate (runs(size(settings)), worth(size(settings)))
      do i = 1, size(runs)
         call measure(plan, settings(i), reference, samples, runs(i))
         if (signal_came()) then
            runs = runs(:i - 1)
            call mark_front(runs)
            return
         end if
         call progress%update(real(i, wp)/size(runs))
      end do
      worth = [(is_worth(runs, i), i=1, size(runs))]
      do round = 2, plan%repeats
         do i = 1, size(runs)
            if (worth(i) .and. .not. signal_came()) call measure(plan, settings(i), reference, samples, runs(i))
         end do
      end do
      call mark_front(runs)
   end subroutine run_grid

   !> Whether no other run is more accurate and takes less than half the time.
   pure logical function is_worth(runs, which)
      type(run_type), intent(in) :: runs(:)
      integer, intent(in) :: which
      integer :: i
      is_worth = runs(which)%reason == ''
      if (.not. is_worth) return
      do i = 1, size(runs)
         if (runs(i)%reason /= '') cycle
         if (runs(i)%error <= runs(which)%error .and. 2*runs(i)%cpu(1) < runs(which)%cpu(1)) is_worth = .false.
      end do
   end function is_worth

   !> All settings: the tolerance changes fastest.
   function grid_of(plan) result(settings)
      type(plan_type), intent(in) :: plan
      type(setting_type), allocatable :: settings(:)
      real(wp) :: tolerance
      integer :: order(4), i, k, rest
      order = [axis_elements, axis_modes, axis_fidelity, axis_integrator]
      tolerance = plan%deck%blocks(plan%deck%find('DYNAMICS'))%real('TOLERANCE')
      associate (controls => plan%axis(axis_tolerance)%values)
         allocate (settings(size(controls)*product([(levels(plan%axis(order(k))), k=1, 4)])))
         do i = 1, size(settings)
            rest = i - 1
            settings(i)%level(axis_tolerance) = 1 + mod(rest, size(controls))
            associate (value => controls(settings(i)%level(axis_tolerance)))
               settings(i)%tolerance = merge(tolerance, value, plan%has_steps)
               settings(i)%step = merge(value, 0.0_wp, plan%has_steps)
            end associate
            rest = rest/size(controls)
            do k = 1, 4
               if (size(plan%axis(order(k))%values) > 0) settings(i)%level(order(k)) = 1 + mod(rest, levels(plan%axis(order(k))))
               rest = rest/levels(plan%axis(order(k)))
            end do
            settings(i)%integrator = plan%axis(axis_integrator)%texts(settings(i)%level(axis_integrator))
         end do
      end associate
   end function grid_of

   !> The finest model at the smallest tolerance, with the fastest integrator of the grid there: for the families if the
   !> reference is not limber's own.
   function fine_setting(plan, runs) result(fine)
      type(plan_type), intent(in) :: plan
      type(run_type), intent(in) :: runs(:)
      type(setting_type) :: fine
      real(wp) :: least
      integer :: i
      fine = finest_setting(plan)
      least = huge(least)
      do i = 1, size(runs)
         if (runs(i)%reason /= '' .or. runs(i)%setting%level(axis_tolerance) /= finest(plan, axis_tolerance)) cycle
         if (any(runs(i)%setting%level(axis_modes:) /= fine%level(axis_modes:)) .or. runs(i)%cpu(1) >= least) cycle
         least = runs(i)%cpu(1)
         fine%integrator = runs(i)%setting%integrator
      end do
   end function fine_setting

   !> Marks the runs that no other one beats in time and error.
   pure subroutine mark_front(runs)
      type(run_type), intent(inout) :: runs(:)
      integer :: i, j
      real(wp) :: mine, other
      do i = 1, size(runs)
         runs(i)%on_front = runs(i)%reason == ''
         if (.not. runs(i)%on_front) cycle
         mine = median(runs(i)%cpu)
         do j = 1, size(runs)
            if (runs(j)%reason /= '' .or. j == i) cycle
            other = median(runs(j)%cpu)
            if (other <= mine .and. runs(j)%error <= runs(i)%error .and. (other < mine .or. runs(j)%error < runs(i)%error)) &
               & runs(i)%on_front = .false.
         end do
      end do
   end subroutine mark_front

   !> Varies one axis alone at fine settings; the error is that against its finest value. Of no use once a signal asks for the end.
   subroutine run_family(plan, which, fine, runs)
      type(plan_type), intent(in) :: plan
      !> Axis
      integer, intent(in) :: which
      type(setting_type), intent(in) :: fine
      !> One for each value
      type(run_type), allocatable, intent(out) :: runs(:)
      type(setting_type) :: setting
      type(reference_type) :: reference
      type(memory_type) :: samples
      type(run_type) :: best
      integer :: i
      allocate (runs(size(plan%axis(which)%values)))
      setting = fine
      setting%level(which) = finest(plan, which)
      call simulate(plan, setting, samples, best)
      if (best%reason == '') call take_reference(plan, samples, reference)
      do i = 1, size(runs)
         if (signal_came()) return
         setting%level(which) = i
         if (best%reason /= '') then
            runs(i) = best
            runs(i)%setting = setting
         else if (i == finest(plan, which)) then
            runs(i) = best
            runs(i)%setting = setting
            allocate (runs(i)%greatest(size(plan%channels)), runs(i)%last(size(plan%channels)))
            runs(i)%greatest = 0.0_wp
            runs(i)%last = 0.0_wp
            runs(i)%error = 0.0_wp
            runs(i)%error_at_end = 0.0_wp
         else
            call measure(plan, setting, reference, samples, runs(i))
         end if
      end do
   end subroutine run_family

   !> The middle one, or the mean of the two in the middle.
   pure real(wp) function median(values)
      real(wp), intent(in) :: values(:)
      real(wp) :: sorted(size(values)), keep
      integer :: i, j
      sorted = values
      do i = 2, size(sorted)
         keep = sorted(i)
         do j = i - 1, 1, -1
            if (sorted(j) <= keep) exit
            sorted(j + 1) = sorted(j)
         end do
         sorted(j + 1) = keep
      end do
      i = size(sorted)
      median = 0.5_wp*(sorted((i + 1)/2) + sorted(i/2 + 1))
   end function median

   !> Slope of the straight line through points (x, y) in the sense of least squares; zero for fewer than two.
   pure real(wp) function slope(x, y)
      real(wp), intent(in) :: x(:), y(:)
      real(wp) :: spread
      slope = 0.0_wp
      if (size(x) < 2) return
      associate (dx => x - sum(x)/size(x), dy => y - sum(y)/size(y))
         spread = sum(dx**2)
         if (spread > 0.0_wp) slope = sum(dx*dy)/spread
      end associate
   end function slope

end module limber_accuracy_study_runs
