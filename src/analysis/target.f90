!> A run that keeps a requested accuracy: the advised model is run and verified, in time by a smaller tolerance and in each beam
!> that matters by its next rung, and where the differences are too large it climbs and runs again. Floor: analysis.
!> Equations: doc/theory.md, accuracy on request.
module limber_analysis_target
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use limber_base_kinds, only: wp, long
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text, first_line, newline
   use limber_analysis_advice, only: advice_type, make_advice, find_floors, expected_error, take_measured
   use limber_analysis_dynamics, only: run_dynamics, new_integrator
   use limber_analysis_outcome, only: outcome_type
   use limber_analysis_errors, only: envelope, magnitude, unknown_ratio
   use limber_analysis_estimate, only: estimate_type, add_quantities, round_off
   use limber_analysis_indicators, only: indicator_value, indicator_slope, indicator_deflection, indicator_rotation, &
      & indicator_compression, indicator_geometric, indicator_shortening, indicator_names
   use limber_analysis_ranges, only: excess
   use limber_analysis_rungs, only: rung_type, apply_rung, next_rung, better_rung, can_climb, rung_name, level_full
   use limber_analysis_scene, only: scene_type, build_scene
   use limber_deck_content, only: deck_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_integrator_integrator, only: integrator_type
   use limber_integrator_statistics, only: step_statistics_type
   use limber_model_scene, only: channel_type
   use limber_output_progress, only: progress_type
   use limber_output_sink, only: memory_type
   implicit none
   private
   public :: reached_type, reach_target

   !> What a run towards a target leaves
   type :: reached_type
      !> As it was advised, with the rungs and the tolerance that were reached
      type(advice_type) :: advice
      !> Whether the verified error is within the target; if not, why
      logical :: done = .false.
      character(:), allocatable :: reason
      !> Samples of the run that was verified, what it counted, and how it ended
      type(memory_type) :: samples
      type(step_statistics_type) :: statistics
      type(outcome_type) :: outcome
      !> Its estimated errors
      type(estimate_type) :: estimate
      !> Largest of them, and their parts by the integration and by the model of each beam, relative
      real(wp) :: error = 0.0_wp, of_time = 0.0_wp
      real(wp), allocatable :: of_beam(:)
      !> Number of runs, of climbs, and CPU seconds of all but the last
      integer :: runs = 0, climbs = 0
      real(wp) :: cpu = 0.0_wp
      !> What was climbed, a line for each
      character(:), allocatable :: path
   end type reached_type

   !> A run in memory
   type :: trial_type
      type(memory_type) :: samples
      type(step_statistics_type) :: statistics
      type(outcome_type) :: outcome
      !> Why it failed; empty if it did not
      character(:), allocatable :: reason
      !> Magnitude that each channel's errors are relative to (channels)
      real(wp), allocatable :: scale(:)
      !> Largest slope and deflection of each open beam, the latter relative to the length; negative: not seen (rungs)
      real(wp), allocatable :: slope(:), deflection(:)
      !> Worst indicator of its model relative to its limit, and its kind (rungs)
      real(wp), allocatable :: excess(:)
      integer, allocatable :: kind(:)
      !> Error that its axial coordinates at rest make; zero if they are not at rest (rungs)
      real(wp), allocatable :: at_rest(:)
   end type trial_type

   !> Ratio of the tolerances of a run and its check, and least tolerance
   real(wp), parameter :: ladder = 0.1_wp, least_tolerance = 1.0e-13_wp
   !> What differences are multiplied by: the check has an error too
   real(wp), parameter :: widening = 1.25_wp
   !> Parts of the target that the integration and the models may have
   real(wp), parameter :: part_time = 0.4_wp, part_model = 0.6_wp
   !> Part of the target below which a beam does not matter
   real(wp), parameter :: no_matter = 0.02_wp
   !> Expected error in units of the target beyond which a model is not verified, and error of deflections at the limit of a range
   real(wp), parameter :: hopeless = 5.0_wp, at_limit = 0.03_wp
   !> Neighbours on each side that the envelope takes in
   integer, parameter :: reach = 2
   !> Most rounds, and CPU time in units of the first run after which no more are begun
   integer, parameter :: most_rounds = 8

contains

   !> Advises, runs, verifies, climbs.
   subroutine reach_target(deck, target, quiet, reached, error)
      !> As it was read
      type(deck_type), intent(in) :: deck
      real(wp), intent(in) :: target
      !> Whether the progress is not shown
      logical, intent(in) :: quiet
      type(reached_type), intent(out) :: reached
      !> The deck is wrong (status 2)
      type(error_type), allocatable, intent(out) :: error
      type(trial_type) :: candidate
      integer :: round
      logical :: climbed
      reached%reason = ''
      reached%path = ''
      call make_advice(deck, target, reached%advice, error)
      if (allocated(error)) return
      allocate (reached%of_beam(size(reached%advice%rungs)))
      do round = 1, most_rounds
         reached%of_beam = 0.0_wp
         call find_floors(reached%advice)
         reached%of_time = 0.0_wp
         call run_trial(deck, reached%advice%rungs, reached%advice%tolerance, 1.0_wp, huge(1.0_wp), &
            & .false., quiet, 'run', candidate, error)
         if (allocated(error)) return
         reached%runs = reached%runs + 1
         if (candidate%reason /= '') then
            reached%reason = candidate%reason
            call climb_all(deck, reached, climbed)
         else
            call take_seen(deck, target, candidate, reached, climbed)
            if (climbed .and. round < most_rounds) then
               reached%cpu = reached%cpu + candidate%outcome%cpu
               reached%climbs = reached%climbs + 1
               cycle
            end if
            call verify(deck, target, quiet, candidate, reached, error)
            if (allocated(error)) return
            reached%done = reached%reason == '' .and. reached%error <= target
            if (reached%done) exit
            call climb(deck, target, reached, climbed)
         end if
         if (.not. climbed .or. round == most_rounds) exit
         reached%cpu = reached%cpu + candidate%outcome%cpu
         reached%climbs = reached%climbs + 1
         reached%reason = ''
      end do
      if (.not. reached%done .and. reached%reason == '') then
         reached%reason = 'no rung keeps TARGET='//as_text(target, 2)//': '
         if (reached%error < 1.0e3_wp) then
            reached%reason = reached%reason//'the error that the verification shows is '//as_text(reached%error, 2)
         else
            reached%reason = reached%reason//'the run one rung higher that is to verify it fails'
         end if
      end if
      if (any(reached%advice%floor > 0.5_wp*target) .and. .not. reached%done) reached%reason = reached%reason//newline// &
         & '   Slopes of '//as_text(maxval(reached%advice%probe%beams%slope), 2)//' are more than one floating frame describes'// &
         & ' to that accuracy: leave SEGMENTS open, or divide the beam'
      reached%statistics = candidate%statistics
      call take_outcome(candidate%outcome, reached%outcome)
      call take_samples(candidate%samples, reached%samples)
   end subroutine reach_target

   !> Moves samples.
   subroutine take_samples(from, to)
      type(memory_type), intent(inout) :: from, to
      to%samples = from%samples
      call move_alloc(from%times, to%times)
      call move_alloc(from%values, to%values)
   end subroutine take_samples

   !> Moves an outcome.
   subroutine take_outcome(from, to)
      type(outcome_type), intent(inout) :: from, to
      to%reached = from%reached
      to%samples = from%samples
      to%wall = from%wall
      to%cpu = from%cpu
      to%position_residual = from%position_residual
      to%velocity_residual = from%velocity_residual
      to%first_energy = from%first_energy
      to%last_energy = from%last_energy
      to%work = from%work
      to%imbalance = from%imbalance
      to%largest_energy = from%largest_energy
      call move_alloc(from%warnings, to%warnings)
      call move_alloc(from%efforts, to%efforts)
      call move_alloc(from%axial, to%axial)
      call move_alloc(from%left_out, to%left_out)
      call move_alloc(from%indicators, to%indicators)
   end subroutine take_outcome

   !> Runs a setting into memory.
   subroutine run_trial(deck, rungs, tolerance, part, limit, wide, quiet, label, trial, error)
      type(deck_type), intent(in) :: deck
      type(rung_type), intent(in) :: rungs(:)
      !> Tolerance, and what part it is of that of the run: steps that the deck gives are shortened as those of order two would be;
      !> CPU seconds after which the run is given up
      real(wp), intent(in) :: tolerance, part, limit
      !> Whether the quantities of the channels are sampled too, and their scales found
      logical, intent(in) :: wide, quiet
      !> For the progress
      character(*), intent(in) :: label
      type(trial_type), intent(out) :: trial
      !> The deck is wrong (status 2)
      type(error_type), allocatable, intent(out) :: error
      type(scene_type) :: scene
      type(diagnostics_type) :: diagnostics
      type(progress_type) :: progress
      type(error_type), allocatable :: failure
      class(integrator_type), allocatable :: integrator
      type(channel_type), allocatable :: channels(:)
      integer :: i, width
      trial%reason = ''
      scene%deck = deck
      do i = 1, size(rungs)
         call apply_rung(rungs(i), scene%deck)
      end do
      call scene%deck%set_number(deck%find('DYNAMICS'), 'TOLERANCE', tolerance)
      call build_scene(scene, diagnostics, error)
      if (allocated(error)) return
      associate (model => scene%system%model)
         width = size(model%channels)
         if (wide) then
            call move_alloc(model%channels, channels)
            call add_quantities(channels, model%channels)
            width = size(model%channels)
         else if (model%motion) then
            width = width + scene%system%layout%nq
         end if
         model%dynamics%initial_step = part**(1.0_wp/3)*model%dynamics%initial_step
         model%dynamics%maximum_step = part**(1.0_wp/3)*model%dynamics%maximum_step
         model%dynamics%fixed_step = part**(1.0_wp/3)*model%dynamics%fixed_step
         call new_integrator(model%dynamics, integrator)
         call trial%samples%start(width, model%dynamics%outputs + 1, limit)
         if (.not. quiet) call progress%start(model%dynamics%start, model%dynamics%end, label)
         call run_dynamics(scene, integrator, trial%samples, progress, trial%outcome, failure)
         if (.not. quiet) call progress%finish()
         trial%statistics = integrator%statistics
         if (allocated(failure)) then
            trial%reason = first_line(failure%message)
         else if (.not. all(ieee_is_finite(trial%samples%values))) then
            trial%reason = 'a channel is not finite'
         end if
         if (wide .and. trial%reason == '') call find_scales(channels, trial)
      end associate
      call see_beams(scene, rungs, trial)
   end subroutine run_trial

   !> What a run has shown of the open beams in one frame.
   subroutine see_beams(scene, rungs, trial)
      type(scene_type), intent(in) :: scene
      type(rung_type), intent(in) :: rungs(:)
      type(trial_type), intent(inout) :: trial
      !> Those of which a higher rung keeps less
      integer, parameter :: kinds(*) = [indicator_deflection, indicator_slope, indicator_rotation, indicator_compression, &
         & indicator_geometric, indicator_shortening]
      real(wp) :: value
      integer :: i, k, j
      allocate (trial%slope(size(rungs)), trial%deflection(size(rungs)), trial%excess(size(rungs)), trial%kind(size(rungs)), &
         & trial%at_rest(size(rungs)))
      trial%slope = -1.0_wp
      trial%deflection = -1.0_wp
      trial%excess = 0.0_wp
      trial%kind = indicator_deflection
      trial%at_rest = 0.0_wp
      if (.not. allocated(trial%outcome%indicators)) return
      associate (seen => trial%outcome%indicators%bodies, model => scene%system%model)
         do i = 1, size(rungs)
            if (rungs(i)%segments > 1) cycle
            do k = 1, size(seen)
               if (model%bodies(seen(k)%body)%name /= scene%deck%blocks(rungs(i)%block)%name()) cycle
               trial%slope(i) = indicator_value(seen(k), indicator_slope)
               trial%deflection(i) = indicator_value(seen(k), indicator_deflection)
               if (allocated(trial%outcome%left_out)) trial%at_rest(i) = trial%outcome%left_out(seen(k)%body)
               do j = 1, size(kinds)
                  value = excess(seen(k), model%bodies(seen(k)%body), kinds(j))
                  if (.not. value > trial%excess(i)) cycle
                  trial%excess(i) = value
                  trial%kind(i) = kinds(j)
               end do
            end do
         end do
      end associate
   end subroutine see_beams

   !> Puts what a run has shown in place of what the probe expected; climbs at once where the model of a beam is so far outside its
   !> range that there is no use in verifying it, eqs. (182), (183).
   subroutine take_seen(deck, target, trial, reached, climbed)
      type(deck_type), intent(in) :: deck
      real(wp), intent(in) :: target
      type(trial_type), intent(in) :: trial
      type(reached_type), intent(inout) :: reached
      logical, intent(out) :: climbed
      real(wp) :: outside
      integer :: i
      climbed = .false.
      associate (advice => reached%advice)
         do i = 1, size(advice%rungs)
            if (trial%slope(i) >= 0.0_wp) call take_measured(advice, i, trial%slope(i), trial%deflection(i), trial%at_rest(i))
         end do
         call find_floors(advice)
         do i = 1, size(advice%rungs)
            if (trial%slope(i) < 0.0_wp .or. .not. can_climb(advice%rungs(i))) cycle
            outside = 0.0_wp
            if (trial%excess(i) > 1.0_wp) outside = at_limit*advice%probe%beams(i)%effect*trial%excess(i)
            if (advice%rungs(i)%level == level_full .and. .not. (advice%rungs(i)%open_segments .or. advice%rungs(i)%at_rest)) cycle
            if (trial%at_rest(i) > target) then
               call go_up(i, 'left out axial vibrations that make an error of '//as_text(trial%at_rest(i), 2))
            else if (advice%expected(i) > hopeless*target) then
               call go_up(i, 'reached slopes of '//as_text(trial%slope(i), 2)//', where an error of '// &
                  & as_text(advice%expected(i), 2)//' is expected')
            else if (outside > hopeless*target) then
               call go_up(i, 'left its range ('//trim(indicator_names(trial%kind(i)))//', '//as_text(trial%excess(i), 2)// &
                  & ' times its limit)')
            end if
         end do
      end associate

   contains

      subroutine go_up(i, why)
         integer, intent(in) :: i
         character(*), intent(in) :: why
         associate (rung => reached%advice%rungs(i))
            reached%path = reached%path//newline//"   beam '"//deck%blocks(rung%block)%name()//"' as "//rung_name(rung)//' '//why
            rung = better_rung(rung, rung%level == level_full)
            reached%path = reached%path//': '//rung_name(rung)
            ! It is to be verified in any case
            reached%advice%expected(i) = max(reached%advice%share, expected_error(rung, reached%advice%probe%beams(i), &
               & reached%advice%probe%duration))
         end associate
         climbed = .true.
      end subroutine go_up

   end subroutine take_seen

   !> What errors of the channels are relative to: their largest magnitude; of one that is the small difference of large terms, such
   !> as an energy balance, that of its terms.
   subroutine find_scales(channels, trial)
      !> As the deck asks for them; behind them in the samples are their quantities
      type(channel_type), intent(in) :: channels(:)
      type(trial_type), intent(inout) :: trial
      !> Part of its terms below which a channel counts as zero
      real(wp), parameter :: small = 1.0e-2_wp
      real(wp), allocatable :: floors(:), sizes(:)
      real(wp) :: largest
      integer :: i, j, first, n
      n = trial%samples%samples
      first = size(channels)
      allocate (trial%scale(size(channels)), floors(n), sizes(n))
      do i = 1, size(channels)
         associate (asked => channels(i)%quantities)
            call round_off(channels(i), trial%samples%values(first + 1:first + size(asked), :n), [(0.0_wp, j=1, size(asked))], &
               & trial%statistics%steps, floors, sizes)
            first = first + size(asked)
            largest = magnitude(trial%samples%values(i, :n))
            trial%scale(i) = largest
            if (size(asked) > 1 .and. largest < small*maxval(sizes)) trial%scale(i) = maxval(sizes)
         end associate
      end do
   end subroutine find_scales

   !> Runs the checks of a run and estimates its errors from the differences, eqs. (180), (181).
   subroutine verify(deck, target, quiet, candidate, reached, error)
      type(deck_type), intent(in) :: deck
      real(wp), intent(in) :: target
      logical, intent(in) :: quiet
      type(trial_type), intent(in) :: candidate
      type(reached_type), intent(inout) :: reached
      type(error_type), allocatable, intent(out) :: error
      type(trial_type) :: check, other
      type(deck_type) :: higher
      type(rung_type), allocatable :: rungs(:)
      real(wp), allocatable :: total(:, :), change(:, :)
      real(wp) :: limit
      integer :: i, n, channels
      associate (advice => reached%advice, estimate => reached%estimate)
         estimate%tolerance = advice%tolerance
         estimate%companion = max(least_tolerance, ladder*advice%tolerance)
         estimate%reason = ''
         estimate%of_model = .true.
         limit = 2 + 25*candidate%outcome%cpu
         call run_trial(deck, advice%rungs, estimate%companion, ladder, limit, .true., quiet, 'check of the integration', check, &
            & error)
         if (allocated(error)) return
         call count_run(check)
         if (check%reason /= '') then
            reached%reason = 'the check at TOLERANCE='//as_text(estimate%companion, 2)//' failed: '//check%reason
            estimate%reason = reached%reason
            return
         end if
         channels = size(check%scale)
         n = candidate%samples%samples
         allocate (total(channels, n), change(channels, n))
         total = check%samples%values(:channels, :n) - candidate%samples%values(:channels, :n)
         reached%of_time = relative(total)
         do i = 1, size(advice%rungs)
            if (.not. can_climb(advice%rungs(i)) .or. advice%expected(i) < no_matter*target) cycle
            allocate (rungs, source=advice%rungs)
            rungs(i) = next_rung(advice%rungs(i))
            higher = deck
            ! With axial vibrations the steps of ADAMS would be bound to them
            if (advice%rungs(i)%at_rest) call higher%set_option(deck%find('DYNAMICS'), 'INTEGRATOR', 'AUTO')
            call run_trial(higher, rungs, estimate%companion, ladder, limit, .false., quiet, 'check of '//rung_name(rungs(i)), &
               & other, error)
            if (allocated(error)) return
            deallocate (rungs)
            call count_run(other)
            if (other%reason /= '') then
               reached%of_beam(i) = huge(1.0_wp)
               cycle
            end if
            change = other%samples%values(:channels, :n) - check%samples%values(:channels, :n)
            reached%of_beam(i) = relative(change)
            total = total + change
         end do
         if (allocated(estimate%values)) deallocate (estimate%values, estimate%ratio, estimate%stuck)
         allocate (estimate%values(channels, n), estimate%ratio(channels), estimate%stuck(channels))
         do i = 1, channels
            estimate%values(i, :) = widening*envelope(total(i, :), reach) + sum(advice%floor)*check%scale(i)
         end do
         estimate%ratio = unknown_ratio
         estimate%stuck = .false.
         estimate%cpu = reached%cpu
         estimate%factor = reached%cpu/max(candidate%outcome%cpu, tiny(1.0_wp))
         reached%error = widening*relative(total) + sum(advice%floor) &
            & + sum(merge(reached%of_beam, 0.0_wp, reached%of_beam > 1.0_wp))
      end associate

   contains

      !> Adds to the costs.
      subroutine count_run(trial)
         type(trial_type), intent(in) :: trial
         reached%runs = reached%runs + 1
         reached%cpu = reached%cpu + trial%outcome%cpu
      end subroutine count_run

      !> Largest difference over channels and samples, relative.
      pure real(wp) function relative(difference)
         real(wp), intent(in) :: difference(:, :)
         integer :: c
         relative = 0.0_wp
         do c = 1, size(difference, 1)
            relative = max(relative, maxval(abs(difference(c, :)))/check%scale(c))
         end do
      end function relative

   end subroutine verify

   !> Goes up where the verification shows too large a part.
   subroutine climb(deck, target, reached, climbed)
      type(deck_type), intent(in) :: deck
      real(wp), intent(in) :: target
      type(reached_type), intent(inout) :: reached
      logical, intent(out) :: climbed
      real(wp) :: share, worst
      integer :: i
      climbed = .false.
      associate (advice => reached%advice)
         ! One frame is not enough, and more than one is not limber's to choose: nothing helps
         if (any(advice%floor > target .and. .not. advice%rungs%open_segments)) return
         if (reached%reason == '' .and. widening*reached%of_time > part_time*target .and. advice%open_tolerance) &
            & call tighten(min(0.5_wp, max(0.02_wp, 0.5_wp*part_time*target/reached%of_time)))
         share = part_model*target/max(1, count(reached%of_beam > no_matter*target))
         worst = maxval([0.0_wp, reached%of_beam])
         do i = 1, size(advice%rungs)
            if (.not. can_climb(advice%rungs(i))) cycle
            ! More coordinates in one frame do not help
            if (one_frame_is_not_enough(i) .and. .not. advice%rungs(i)%open_segments) cycle
            if (widening*reached%of_beam(i) + advice%floor(i) > share) then
               call raise_beam(i)
            else if (.not. climbed .and. reached%of_beam(i) >= worst .and. worst > 0.0_wp) then
               call raise_beam(i)
            end if
         end do
         if (.not. climbed .and. advice%open_tolerance .and. reached%of_time > 0.1_wp*target) call tighten(0.2_wp)
      end associate

   contains

      subroutine tighten(factor)
         real(wp), intent(in) :: factor
         if (reached%advice%tolerance <= least_tolerance) return
         reached%advice%tolerance = max(least_tolerance, factor*reached%advice%tolerance)
         reached%path = reached%path//newline//'   the integration had an error of '//as_text(reached%of_time, 2)// &
            & ': TOLERANCE='//as_text(reached%advice%tolerance, 2)
         climbed = .true.
      end subroutine tighten

      !> Whether what FULL leaves out in one frame takes too much of the target.
      pure logical function one_frame_is_not_enough(i)
         integer, intent(in) :: i
         one_frame_is_not_enough = reached%advice%floor(i) > 0.5_wp*target
      end function one_frame_is_not_enough

      subroutine raise_beam(i)
         integer, intent(in) :: i
         reached%path = reached%path//newline//"   beam '"//deck%blocks(reached%advice%rungs(i)%block)%name()// &
            & "' as "//rung_name(reached%advice%rungs(i))
         if (reached%of_beam(i) < 1.0e3_wp) then
            reached%path = reached%path//' had an error of '//as_text(reached%of_beam(i), 2)
         else
            reached%path = reached%path//' could not be verified'
         end if
         reached%advice%rungs(i) = better_rung(reached%advice%rungs(i), one_frame_is_not_enough(i))
         reached%path = reached%path//': '//rung_name(reached%advice%rungs(i))
         climbed = .true.
      end subroutine raise_beam

   end subroutine climb

   !> Goes up with all beams, for a run has failed.
   subroutine climb_all(deck, reached, climbed)
      type(deck_type), intent(in) :: deck
      type(reached_type), intent(inout) :: reached
      logical, intent(out) :: climbed
      integer :: i
      climbed = .false.
      do i = 1, size(reached%advice%rungs)
         if (.not. can_climb(reached%advice%rungs(i))) cycle
         reached%path = reached%path//newline//"   beam '"//deck%blocks(reached%advice%rungs(i)%block)%name()//"' as "// &
            & rung_name(reached%advice%rungs(i))//' failed: '
         reached%advice%rungs(i) = better_rung(reached%advice%rungs(i), reached%advice%rungs(i)%level == level_full)
         reached%path = reached%path//rung_name(reached%advice%rungs(i))
         climbed = .true.
      end do
   end subroutine climb_all

end module limber_analysis_target
