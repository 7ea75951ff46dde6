!> A run that keeps a requested accuracy: the advised model is run and verified, in time by a smaller tolerance and in each beam
!> that matters by its next rung, and where the differences are too large it climbs and runs again. Floor: analysis.
!> Equations: doc/theory.md, accuracy on request.
module limber_analysis_target
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, status_interrupted
   use limber_base_text, only: as_text, newline
   use limber_analysis_advice, only: advice_type, make_advice, find_floors, floor_of, expected_error, cost_of, &
      & take_measured, divide_beam
   use limber_analysis_descent, only: descend
   use limber_analysis_errors, only: envelope, unknown_ratio
   use limber_analysis_estimate, only: estimate_type
   use limber_analysis_indicators, only: indicator_names
   use limber_analysis_outcome, only: outcome_type
   use limber_analysis_rungs, only: rung_type, next_rung, better_rung, in_pieces, can_climb, rung_name, &
      & rest_beyond, level_full, first_pieces, most_piece_modes, most_elements
   use limber_analysis_trial, only: trial_type, truth_type, run_trial, take_samples, take_outcome, error_against
   use limber_deck_content, only: deck_type
   use limber_integrator_statistics, only: step_statistics_type
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
      !> Where a signal has ended the search; not allocated if none came. If the target is kept all else is as it should be, only
      !> less might do; if not there are neither samples nor an outcome
      character(:), allocatable :: interruption
      !> Samples of the run that was verified, what it counted, and how it ended
      type(memory_type) :: samples
      type(step_statistics_type) :: statistics
      type(outcome_type) :: outcome
      !> Its estimated errors
      type(estimate_type) :: estimate
      !> Largest of them, and their parts by the integration and by the model of each beam, relative
      real(wp) :: error = 0.0_wp, of_time = 0.0_wp
      real(wp), allocatable :: of_beam(:)
      !> Parts of the beams when they were last verified in one frame; zero: never (rungs)
      real(wp), allocatable :: before(:)
      !> Number of runs, of climbs, and CPU seconds of all but the last
      integer :: runs = 0, climbs = 0
      real(wp) :: cpu = 0.0_wp
      !> Work of all, counted
      real(wp) :: work = 0.0_wp
      !> What was climbed, a line for each
      character(:), allocatable :: path
   end type reached_type

   !> Ratio of the tolerances of a run and its check, and least tolerance
   real(wp), parameter :: ladder = 0.1_wp, least_tolerance = 1.0e-13_wp
   !> What differences are multiplied by where a beam or the integration is judged; error of the check of the integration, as a part
   !> of the difference, and the power of the tolerance that errors of the integration are taken to fall with
   real(wp), parameter :: widening = 1.25_wp, rest_of_time = 0.25_wp, falling = 0.6_wp
   !> Part of the target that a floor of one frame may have where runs in one frame verify each other; error of the truth that is
   !> good enough for another setting
   real(wp), parameter :: unseen = 0.25_wp, sure = 0.3_wp
   !> Part of an error that is left when a richer basis does not help
   real(wp), parameter :: stalled = 0.7_wp
   !> Parts of the target that the integration and the models may have
   real(wp), parameter :: part_time = 0.4_wp, part_model = 0.6_wp
   !> Part of the target that the truth of a scene with beams is taken to err at least: how much it errs is an estimate
   real(wp), parameter :: doubt = 0.1_wp
   !> Part of the target below which a beam does not matter
   real(wp), parameter :: no_matter = 0.02_wp
   !> Expected error in units of the target beyond which a model is not verified, and error of deflections at the limit of a range
   real(wp), parameter :: hopeless = 5.0_wp, at_limit = 0.03_wp
   !> Neighbours on each side that the envelope takes in
   integer, parameter :: reach = 2
   !> Most rounds, and work in units of the last run's after which no more are begun
   integer, parameter :: most_rounds = 10
   real(wp), parameter :: patience = 100.0_wp

contains

   !> Advises, runs, verifies, climbs, and descends where less will do.
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
      type(truth_type) :: truth
      call search(deck, target, quiet, reached, candidate, truth, error)
      if (allocated(error)) then
         if (error%status /= status_interrupted) return
         call move_alloc(error%message, reached%interruption)
         deallocate (error)
         if (.not. reached%done) return
      end if
      if (reached%done .or. truth%known) call record_errors(truth, candidate, reached)
      if (.not. reached%done) call say_why(target, reached)
      reached%statistics = candidate%statistics
      call take_outcome(candidate%outcome, reached%outcome)
      call take_samples(candidate%samples%memory_type, reached%samples)
   end subroutine reach_target

   !> The search itself.
   subroutine search(deck, target, quiet, reached, candidate, truth, error)
      type(deck_type), intent(in) :: deck
      real(wp), intent(in) :: target
      logical, intent(in) :: quiet
      type(reached_type), intent(inout) :: reached
      !> The run that was verified, and the finest
      type(trial_type), intent(inout) :: candidate
      type(truth_type), intent(inout) :: truth
      !> The deck is wrong (status 2), or a signal asks for the end (status 4)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: limit
      integer :: round
      logical :: climbed, on
      reached%reason = ''
      reached%path = ''
      call make_advice(deck, target, reached%advice, error)
      if (allocated(error)) return
      allocate (reached%of_beam(size(reached%advice%rungs)), reached%before(size(reached%advice%rungs)))
      reached%before = 0.0_wp
      limit = huge(limit)
      do round = 1, most_rounds
         climbed = .false.
         call find_floors(reached%advice)
         call run_trial(deck, reached%advice%rungs, reached%advice%tolerance, 1.0_wp, limit, .false., quiet, 'run', &
            & candidate, error)
         if (allocated(error)) return
         limit = 10 + patience*candidate%outcome%cpu
         reached%runs = reached%runs + 1
         reached%work = reached%work + candidate%work
         ! Up only if what is there can be run as well
         on = round < most_rounds .and. (reached%work < patience*candidate%work .or. round < 3)
         if (candidate%reason /= '') then
            reached%reason = candidate%reason
            if (on) call climb_all(deck, reached, climbed)
         else
            if (on) call take_seen(deck, target, candidate, reached, climbed)
            if (climbed) then
               reached%cpu = reached%cpu + candidate%outcome%cpu
               reached%climbs = reached%climbs + 1
               cycle
            end if
            if (does_for(truth, reached%advice, target)) then
               reached%error = error_against(truth, candidate%samples%values)
               reached%done = reached%error <= target
            end if
            if (reached%done) exit
            call verify(deck, target, quiet, on, candidate, reached, truth, error)
            if (allocated(error)) return
            reached%done = reached%reason == '' .and. reached%error <= target
            if (reached%done) exit
            if (on) call climb(deck, target, truth, reached, climbed)
         end if
         if (.not. climbed) exit
         reached%cpu = reached%cpu + candidate%outcome%cpu
         reached%climbs = reached%climbs + 1
         reached%reason = ''
      end do
      if (reached%done) call descend(deck, target, quiet, truth, reached%advice, candidate, reached%error, reached%runs, &
         & reached%cpu, reached%path, error)
   end subroutine search

   !> Why a target is not kept.
   subroutine say_why(target, reached)
      real(wp), intent(in) :: target
      type(reached_type), intent(inout) :: reached
      if (reached%reason == '') then
         reached%reason = 'no rung keeps TARGET='//as_text(target, 2)//': '
         if (reached%error < 1.0e3_wp) then
            reached%reason = reached%reason//'the error that the verification shows is '//as_text(reached%error, 2)
         else
            reached%reason = reached%reason//'the run one rung higher that is to verify it fails'
         end if
      end if
      if (any(reached%advice%floor > 0.5_wp*target)) reached%reason = reached%reason//newline// &
         & '   Slopes of '//as_text(maxval(reached%advice%probe%beams%slope), 2)//' are more than one floating frame describes'// &
         & ' to that accuracy: leave SEGMENTS open, or divide the beam'
   end subroutine say_why

   !> Whether a finer run that is there already does for the present setting, so that none has to be made.
   pure logical function does_for(truth, advice, target)
      type(truth_type), intent(in) :: truth
      type(advice_type), intent(in) :: advice
      real(wp), intent(in) :: target
      integer :: i
      does_for = .false.
      if (.not. truth%known) return
      does_for = truth%tolerance <= advice%tolerance .and. all(truth%rest <= sure*target*truth%scale)
      do i = 1, size(advice%rungs)
         associate (high => truth%rungs(i), low => advice%rungs(i))
            if (high%segments > low%segments .or. advice%expected(i) < no_matter*target) cycle
            if (high%segments < low%segments .or. high%level < low%level .or. high%bending <= low%bending) does_for = .false.
         end associate
      end do
   end function does_for

   !> Errors of the run at each sample.
   subroutine record_errors(truth, candidate, reached)
      type(truth_type), intent(in) :: truth
      type(trial_type), intent(in) :: candidate
      type(reached_type), intent(inout) :: reached
      integer :: i, n
      associate (estimate => reached%estimate)
         n = size(truth%values, 2)
         if (n /= candidate%samples%samples) return
         if (allocated(estimate%values)) deallocate (estimate%values, estimate%ratio, estimate%stuck)
         allocate (estimate%values(size(truth%scale), n), estimate%ratio(size(truth%scale)), estimate%stuck(size(truth%scale)))
         do i = 1, size(truth%scale)
            estimate%values(i, :) = envelope(candidate%samples%values(i, :n) - truth%values(i, :), reach) + truth%rest(i)
         end do
         estimate%ratio = unknown_ratio
         estimate%stuck = .false.
         estimate%tolerance = reached%advice%tolerance
         estimate%companion = truth%tolerance
         estimate%cpu = reached%cpu
         estimate%factor = reached%cpu/max(candidate%outcome%cpu, tiny(1.0_wp))
      end associate
   end subroutine record_errors

   !> Puts what a run has shown in place of what the probe expected; climbs at once where the model of a beam is so far outside its
   !> range that there is no use in verifying it, eqs. (183), (184).
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
            if (rung%level == level_full .and. rung%open_segments) then
               call divide_beam(reached%advice, i)
            else
               rung = better_rung(rung, .false.)
            end if
            reached%path = reached%path//': '//rung_name(rung)
            ! It is to be verified in any case
            reached%advice%expected(i) = max(reached%advice%share, expected_error(rung, reached%advice%probe%beams(i), &
               & reached%advice%probe%duration))
         end associate
         climbed = .true.
      end subroutine go_up

   end subroutine take_seen

   !> Runs the checks of a run and estimates its errors from the differences, eqs. (180), (181): with a smaller tolerance, and then
   !> with one beam after another on its next rung; the last of them is the truth that the run is compared with. Where the
   !> integration alone errs by too much, and there is another round, the beams wait.
   subroutine verify(deck, target, quiet, on, candidate, reached, truth, error)
      type(deck_type), intent(in) :: deck
      real(wp), intent(in) :: target
      !> Whether there is another round if this one fails
      logical, intent(in) :: quiet, on
      type(trial_type), intent(in) :: candidate
      type(reached_type), intent(inout) :: reached
      type(truth_type), intent(inout) :: truth
      type(error_type), allocatable, intent(out) :: error
      type(trial_type) :: check
      type(deck_type) :: higher
      type(rung_type) :: rung
      !> What a look ahead has shown (channels, samples)
      real(wp), allocatable :: ahead(:, :)
      real(wp) :: part
      integer :: i, c, n, channels
      reached%of_beam = 0.0_wp
      reached%of_time = 0.0_wp
      associate (advice => reached%advice, estimate => reached%estimate)
         estimate%companion = max(least_tolerance, ladder*advice%tolerance)
         estimate%reason = ''
         estimate%of_model = .true.
         call run_check(deck, advice%rungs, ladder, .true., 'check of the integration')
         if (allocated(error)) return
         if (check%reason /= '') then
            reached%reason = 'the check at TOLERANCE='//as_text(estimate%companion, 2)//' failed: '//check%reason
            estimate%reason = reached%reason
            return
         end if
         channels = size(check%scale)
         n = candidate%samples%samples
         call begin_truth()
         if (on .and. advice%open_tolerance .and. size(advice%rungs) > 0 .and. widening*reached%of_time > target) then
            truth%known = .false.
            reached%error = widening*reached%of_time
            return
         end if
         part = part_of_check()
         higher = deck
         ! Elements cost nothing in the time loop: those of all beams are twice as many in the truth
         where (.not. truth%rungs%given_elements) truth%rungs%elements = min(most_elements, 2*truth%rungs%elements)
         do i = 1, size(advice%rungs)
            if (.not. can_climb(advice%rungs(i)) .or. advice%expected(i) < no_matter*target) cycle
            ! With axial vibrations the steps of ADAMS would be bound to them
            if (advice%rungs(i)%at_rest) call higher%set_option(deck%find('DYNAMICS'), 'INTEGRATOR', 'AUTO')
            rung = truth%rungs(i)
            truth%rungs(i) = check_rung(i)
            if (on .and. truth%rungs(i)%segments > rung%segments .and. rung%segments == 1) then
               call look_ahead(i)
               if (allocated(error) .or. .not. truth%known) return
            end if
            call run_check(higher, truth%rungs, part, .false., 'check of '//rung_name(truth%rungs(i)))
            if (allocated(error)) return
            if (check%reason /= '') then
               reached%of_beam(i) = huge(1.0_wp)
               truth%rungs(i) = rung
               cycle
            end if
            call begin_models()
            reached%of_beam(i) = relative(truth%values)
            call refine_truth(rest_beyond(rung, truth%rungs(i)))
         end do
         do i = 1, size(advice%rungs)
            truth%rest = truth%rest + floor_beyond(i)*truth%scale
         end do
         if (size(advice%rungs) > 0) truth%rest = max(truth%rest, doubt*target*truth%scale)
         reached%error = error_against(truth, candidate%samples%values) &
            & + sum(merge(reached%of_beam, 0.0_wp, reached%of_beam > 1.0e3_wp))
      end associate

   contains

      !> One run at a smaller tolerance.
      subroutine run_check(changed, rungs, part, wide, label)
         type(deck_type), intent(in) :: changed
         type(rung_type), intent(in) :: rungs(:)
         !> Its tolerance, in units of that of the run
         real(wp), intent(in) :: part
         logical, intent(in) :: wide
         character(*), intent(in) :: label
         call run_trial(changed, rungs, max(least_tolerance, part*reached%advice%tolerance), part, &
            & 2 + 60*candidate%outcome%cpu, wide, quiet, label, check, error)
         reached%runs = reached%runs + 1
         reached%cpu = reached%cpu + check%outcome%cpu
         reached%work = reached%work + check%work
      end subroutine run_check

      !> The run with the smaller tolerance is the first truth.
      subroutine begin_truth()
         if (allocated(truth%rungs)) deallocate (truth%rungs, truth%values, truth%scale, truth%rest)
         allocate (truth%rungs, source=reached%advice%rungs)
         allocate (truth%values(channels, n), truth%scale(channels), truth%rest(channels))
         truth%known = .true.
         truth%tolerance = reached%estimate%companion
         truth%scale = check%scale
         truth%rest = 0.0_wp
         truth%values = candidate%samples%values(:channels, :n)
         reached%of_time = relative(truth%values)
         call refine_truth(rest_of_time)
      end subroutine begin_truth

      !> Before the dear check of a beam in pieces: there is no use in it if a richer basis in one frame shows that the run fails.
      subroutine look_ahead(i)
         integer, intent(in) :: i
         type(rung_type) :: rungs(size(truth%rungs))
         rungs = reached%advice%rungs
         rungs(i) = next_rung(rungs(i))
         if (rungs(i)%segments > 1) return
         call run_check(higher, rungs, 1.0_wp, .false., 'look at '//rung_name(rungs(i)))
         if (allocated(error) .or. check%reason /= '') return
         reached%of_beam(i) = relative(candidate%samples%values)
         allocate (ahead, source=check%samples%values(:channels, :n))
         if (widening*reached%of_beam(i) <= target) return
         reached%error = widening*reached%of_beam(i)
         truth%known = .false.
         truth%rungs = reached%advice%rungs
      end subroutine look_ahead

      !> Tolerance of the checks of the beams, in units of that of the run: no smaller than it takes for the integration to err by
      !> less than half of the doubt about the truth, eq. (180).
      pure real(wp) function part_of_check()
         part_of_check = 1.0_wp
         if (reached%of_time > 0.5_wp*doubt*target) part_of_check = max(ladder, (0.5_wp*doubt*target/reached%of_time)**(1/falling))
      end function part_of_check

      !> Before the first check of a beam: it is compared with the run whose tolerance is nearer to its own, and errs in time as it.
      subroutine begin_models()
         if (truth%tolerance > 0.99_wp*part*reached%advice%tolerance) return
         truth%tolerance = part*reached%advice%tolerance
         truth%rest = part**falling/rest_of_time*truth%rest
         if (part**2 > ladder) truth%values = candidate%samples%values(:channels, :n)
      end subroutine begin_models

      !> Takes the last check for the truth; its error is taken for a part of the difference from the one before, or from the look
      !> ahead if that was nearer.
      subroutine refine_truth(part)
         real(wp), intent(in) :: part
         real(wp) :: away
         do c = 1, channels
            away = maxval(abs(check%samples%values(c, :n) - truth%values(c, :)))
            if (allocated(ahead)) away = min(away, maxval(abs(check%samples%values(c, :n) - ahead(c, :))))
            truth%rest(c) = truth%rest(c) + part*away
         end do
         if (allocated(ahead)) deallocate (ahead)
         truth%values = check%samples%values(:channels, :n)
      end subroutine refine_truth

      !> The rung that shows what a beam leaves out: in pieces where one frame leaves out too much itself.
      type(rung_type) function check_rung(i)
         integer, intent(in) :: i
         associate (rung => reached%advice%rungs(i))
            check_rung = next_rung(rung)
            check_rung%elements = truth%rungs(i)%elements
            if (rung%segments > 1 .or. rung%level < level_full .or. .not. rung%open_segments) return
            if (reached%advice%floor(i) <= unseen*target) return
            check_rung = in_pieces(rung, first_pieces, min(most_piece_modes, max(3, rung%bending/2 + 1)))
            check_rung%elements = truth%rungs(i)%elements
         end associate
      end function check_rung

      !> What the truth leaves out of a beam.
      pure real(wp) function floor_beyond(i)
         integer, intent(in) :: i
         floor_beyond = 0.0_wp
         if (truth%rungs(i)%level == level_full) floor_beyond = floor_of(truth%rungs(i), reached%advice%probe%beams(i))
      end function floor_beyond

      !> Largest difference of the check over channels and samples, relative.
      pure real(wp) function relative(values)
         real(wp), intent(in) :: values(:, :)
         integer :: k
         relative = 0.0_wp
         do k = 1, channels
            relative = max(relative, maxval(abs(check%samples%values(k, :n) - values(k, :)))/truth%scale(k))
         end do
      end function relative

   end subroutine verify

   !> Goes up where the verification shows too large a part.
   subroutine climb(deck, target, truth, reached, climbed)
      type(deck_type), intent(in) :: deck
      real(wp), intent(in) :: target
      !> What the run was compared with
      type(truth_type), intent(in) :: truth
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
            if (widening*reached%of_beam(i) > share) then
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
         integer :: k, from
         reached%path = reached%path//newline//"   beam '"//deck%blocks(reached%advice%rungs(i)%block)%name()// &
            & "' as "//rung_name(reached%advice%rungs(i))
         if (reached%of_beam(i) < 1.0e3_wp) then
            reached%path = reached%path//' had an error of '//as_text(reached%of_beam(i), 2)
         else
            reached%path = reached%path//' could not be verified'
         end if
         associate (rung => reached%advice%rungs(i))
            if (rung%segments == 1 .and. rung%open_segments .and. (one_frame_is_not_enough(i) .or. stalls(i))) then
               call divide(i)
            else if (rung%segments > 1 .and. one_frame_is_not_enough(i)) then
               rung = better_rung(rung, .true.)
            else
               ! Errors fall with the third power of the modes at least
               from = rung%bending
               do k = 1, 3
                  reached%before(i) = merge(reached%of_beam(i), 0.0_wp, rung%level == level_full)
                  rung = better_rung(rung, .false.)
                  if (rung%level < level_full .or. .not. can_climb(rung) .or. rung%segments > 1) exit
                  if ((real(from, wp)/rung%bending)**3*reached%of_beam(i) < share) exit
               end do
            end if
            reached%path = reached%path//': '//rung_name(rung)
            ! It is to be verified in any case
            reached%advice%expected(i) = max(reached%advice%share, expected_error(rung, reached%advice%probe%beams(i), &
               & reached%advice%probe%duration))
         end associate
         climbed = .true.
      end subroutine raise_beam

      !> Divides a beam: into the pieces of the check if these are known to do and cost not much more than those that are
      !> expected to.
      subroutine divide(i)
         integer, intent(in) :: i
         real(wp), parameter :: dearer = 3.0_wp
         type(rung_type) :: rung
         rung = reached%advice%rungs(i)
         call divide_beam(reached%advice, i)
         if (truth%rungs(i)%segments == 1 .or. reached%of_beam(i) > 1.0e3_wp) return
         if (cost_of(truth%rungs(i)) > dearer*cost_of(reached%advice%rungs(i))) return
         if (floor_of(truth%rungs(i), reached%advice%probe%beams(i)) > unseen*target) return
         if (rest_beyond(rung, truth%rungs(i))*reached%of_beam(i) > share) return
         rung%elements = reached%advice%rungs(i)%elements
         reached%advice%rungs(i) = in_pieces(rung, truth%rungs(i)%segments, truth%rungs(i)%bending)
      end subroutine divide

      !> Whether a richer basis has not helped the last time.
      pure logical function stalls(i)
         integer, intent(in) :: i
         stalls = reached%before(i) > 0.0_wp .and. reached%of_beam(i) > stalled*reached%before(i) .and. &
            & reached%advice%floor(i) > 0.1_wp*target
      end function stalls

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
