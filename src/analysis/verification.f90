!> Verification of a run towards a target, by finer ones: in time by a smaller tolerance, and in each beam that matters by its next
!> rung. The last of them is the truth that other settings are compared with; where its own error is in the way, it is looked at a
!> second time. Floor: analysis. Equations: doc/theory.md, accuracy on request.
module limber_analysis_verification
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use limber_analysis_advice, only: advice_type, floor_of, cost_of
   use limber_analysis_reached, only: reached_type
   use limber_analysis_rungs, only: rung_type, next_rung, in_pieces, can_climb, rung_name, rest_beyond, level_rigid, level_full, &
      & first_pieces, most_piece_modes, most_elements
   use limber_analysis_shares, only: no_matter, no_effect
   use limber_analysis_trial, only: trial_type, run_trial, least_patience
   use limber_analysis_truth, only: truth_type, error_against, largest_difference
   use limber_deck_content, only: deck_type
   implicit none
   private
   public :: verify, sharpen, rest_after_looks, matters, run_check, sum_up

   !> Least tolerance, and the least of a run that a smaller one can verify
   real(wp), parameter, public :: least_tolerance = 1.0e-13_wp, least_verified = 1.0e-12_wp
   !> What differences are multiplied by where a beam or the integration is judged
   real(wp), parameter, public :: widening = 1.25_wp
   !> Part of the target that a floor of one frame may have where runs in one frame verify each other
   real(wp), parameter, public :: unseen = 0.25_wp
   !> Ratio of the tolerances of a run and its check
   real(wp), parameter :: ladder = 0.1_wp
   !> Error of the check of the integration, as a part of the difference, and the power of the tolerance that errors of the
   !> integration are taken to fall with
   real(wp), parameter :: rest_of_time = 0.25_wp, falling = 0.6_wp
   !> Part of the work so far that a second look may cost
   real(wp), parameter :: part_of_search = 0.6_wp
   !> Part of the target that the truth of a scene with beams is taken to err at least, for how much it errs is an estimate; when it
   !> has been looked at a second time, in its integration or in its models, and in both
   real(wp), parameter :: doubt(0:2) = [0.1_wp, 0.07_wp, 0.05_wp]
   !> Slope beyond which a beam bends far, so that errors fall more slowly than is taken for granted, and what estimates of scenes
   !> with beams are multiplied by, and then, measured: doc/fidelity.md
   real(wp), parameter :: far = 0.3_wp, safety = 1.3_wp, safety_far = 2.2_wp

contains

   !> Runs the checks of a run and estimates its errors from the differences, eqs. (180), (181): with a smaller tolerance, and then
   !> with one beam after another on its next rung; the last of them is the truth that the run is compared with. Where the
   !> integration alone errs by too much, and there is another round, the beams wait.
   subroutine verify(deck, target, quiet, on, candidate, reached, truth, error)
      type(deck_type), intent(in) :: deck
      real(wp), intent(in) :: target
      !> Whether the progress is not shown; whether there is another round if this one fails
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
      !> Tolerance of the check of the integration, in units of that of the run
      real(wp) :: step
      real(wp) :: part
      integer :: i, n, channels
      reached%of_beam = 0.0_wp
      reached%of_time = 0.0_wp
      higher = deck
      associate (advice => reached%advice, estimate => reached%estimate)
         ! Where no smaller tolerance is left, a looser one shows how far errors fall
         step = merge(ladder, 1/ladder, advice%tolerance > 0.99_wp*least_verified)
         estimate%companion = step*advice%tolerance
         estimate%reason = ''
         estimate%of_model = .true.
         call run_next(advice%rungs, step, .true., 'check of the integration')
         if (allocated(error)) return
         if (check%reason /= '') then
            reached%reason = 'the check at TOLERANCE='//as_text(estimate%companion, 2)//' failed: '//check%reason
            estimate%reason = reached%reason
            return
         end if
         channels = size(check%scale)
         n = candidate%samples%samples
         call truth%start(advice%rungs, advice%tolerance, check%scale, candidate%samples%values(:channels, :n), candidate%work)
         reached%of_time = difference()
         call reached%shown%take(advice%rungs, advice%tolerance, reached%of_time, target, candidate%samples%values(:channels, :n), &
            & check%samples%values(:channels, :n))
         if (step < 1.0_wp) then
            call take_check(truth%of_time, rest_of_time)
            truth%tolerance = estimate%companion
            truth%growth = check%work/candidate%work
         else
            truth%of_time = rest_of_time*largest_difference(check%samples%values, truth%finest)
            truth%growth = candidate%work/check%work
         end if
         allocate (truth%coarse, source=truth%finest)
         if (on .and. advice%open_tolerance .and. size(advice%rungs) > 0 .and. widening*reached%of_time > target) then
            truth%known = .false.
            reached%error = widening*reached%of_time
            return
         end if
         part = part_of_check()
         higher = higher_deck(deck, reached)
         ! Elements cost nothing in the time loop: those of all beams are twice as many in the truth
         where (.not. truth%rungs%given_elements) truth%rungs%elements = min(most_elements, 2*truth%rungs%elements)
         do i = 1, size(advice%rungs)
            if (.not. matters(advice, i, target)) cycle
            if (.not. (can_climb(advice%rungs(i)) .or. advice%rungs(i)%open_modes)) cycle
            rung = truth%rungs(i)
            truth%rungs(i) = check_rung(i)
            if (on .and. truth%rungs(i)%segments > rung%segments .and. rung%segments == 1) then
               call look_ahead(i)
               if (allocated(error) .or. .not. truth%known) return
            end if
            call run_next(truth%rungs, part, .false., 'check of '//rung_name(truth%rungs(i)))
            if (allocated(error)) return
            if (check%reason /= '') then
               reached%of_beam(i) = huge(1.0_wp)
               truth%rungs(i) = rung
               cycle
            end if
            call begin_models()
            reached%of_beam(i) = difference()
            call take_check(truth%of_model, rest_beyond(rung, truth%rungs(i)))
         end do
         call sum_up(target, reached, truth)
         reached%error = error_against(truth, candidate%samples%values) &
            & + sum(merge(reached%of_beam, 0.0_wp, reached%of_beam > 1.0e3_wp))
      end associate

   contains

      !> One run at a smaller tolerance.
      subroutine run_next(rungs, part, wide, label)
         type(rung_type), intent(in) :: rungs(:)
         !> Its tolerance, in units of that of the run
         real(wp), intent(in) :: part
         logical, intent(in) :: wide
         character(*), intent(in) :: label
         call run_check(higher, rungs, reached%advice%tolerance, part, 60*candidate%work, wide, quiet, label, reached, &
            & check, error)
      end subroutine run_next

      !> Before the dear check of a beam in pieces: there is no use in it if a richer basis in one frame shows that the run fails.
      subroutine look_ahead(i)
         integer, intent(in) :: i
         type(rung_type) :: rungs(size(truth%rungs))
         rungs = reached%advice%rungs
         rungs(i) = next_rung(rungs(i))
         if (rungs(i)%segments > 1) return
         call run_next(rungs, 1.0_wp, .false., 'look at '//rung_name(rungs(i)))
         if (allocated(error) .or. check%reason /= '') return
         reached%of_beam(i) = maxval(largest_difference(check%samples%values, candidate%samples%values(:channels, :n))/truth%scale)
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
         if (reached%of_time > 0.5_wp*doubt(0)*target) part_of_check = &
            & max(ladder, (0.5_wp*doubt(0)*target/reached%of_time)**(1/falling))
      end function part_of_check

      !> Before the first check of a beam: it is compared with the run whose tolerance is nearer to its own, and errs in time as it.
      subroutine begin_models()
         if (truth%tolerance > 0.99_wp*part*reached%advice%tolerance) return
         truth%tolerance = part*reached%advice%tolerance
         deallocate (truth%coarse)
         truth%of_time = part**falling/rest_of_time*truth%of_time
         if (part**2 > ladder) call truth%refine(candidate%samples%values(:channels, :n), candidate%work)
      end subroutine begin_models

      !> Takes the last check for the truth; its error is taken for a part of the difference from the one before, or from the look
      !> ahead if that was nearer.
      subroutine take_check(errors, part)
         !> Of the truth, which it is added to (channels)
         real(wp), intent(inout) :: errors(:)
         real(wp), intent(in) :: part
         real(wp) :: away(channels)
         away = largest_difference(check%samples%values, truth%finest)
         if (allocated(ahead)) then
            away = min(away, largest_difference(check%samples%values, ahead))
            deallocate (ahead)
         end if
         errors = errors + part*away
         call truth%refine(check%samples%values(:channels, :n), check%work)
      end subroutine take_check

      !> The rung that shows what a beam leaves out: in pieces where one frame leaves out too much itself.
      type(rung_type) function check_rung(i)
         integer, intent(in) :: i
         associate (rung => reached%advice%rungs(i))
            check_rung = next_rung(rung)
            check_rung%elements = truth%rungs(i)%elements
            ! Beyond the richest, so that it is verified too
            if (.not. can_climb(rung)) check_rung%bending = rung%bending + max(1, rung%bending/3)
            if (rung%segments > 1 .or. rung%level < level_full .or. .not. rung%open_segments) return
            if (reached%advice%floor(i) <= unseen*target) return
            check_rung = in_pieces(rung, first_pieces, min(most_piece_modes, max(3, rung%bending/2 + 1)))
            check_rung%elements = truth%rungs(i)%elements
         end associate
      end function check_rung

      !> Largest difference of the check from the truth so far over channels and samples, relative.
      pure real(wp) function difference()
         difference = maxval([0.0_wp, largest_difference(check%samples%values, truth%finest)/truth%scale])
      end function difference

   end subroutine verify

   !> Looks at the truth a second time, eq. (182a): at its integration, for the error of that shows in the run that it has verified
   !> as well, which is cheap; when that has been looked at, at its models, for which all beams that matter go up once more. Neither
   !> may cost more than 0.6 of what the search has cost so far.
   subroutine sharpen(deck, target, quiet, reached, truth, sharper, error)
      type(deck_type), intent(in) :: deck
      real(wp), intent(in) :: target
      logical, intent(in) :: quiet
      type(reached_type), intent(inout) :: reached
      type(truth_type), intent(inout) :: truth
      !> Whether its error is known better now
      logical, intent(out) :: sharper
      type(error_type), allocatable, intent(out) :: error
      sharper = .false.
      call sharpen_integration()
      if (.not. (sharper .or. allocated(error))) call sharpen_models()
      if (sharper) call sum_up(target, reached, truth)

   contains

      !> What another tenth of the tolerance changes in the verified run is taken for the error of the truth's integration.
      subroutine sharpen_integration()
         type(trial_type) :: check
         real(wp) :: part
         integer :: n, channels
         if (truth%sharp_time .or. ladder*truth%tolerance < least_tolerance) return
         truth%sharp_time = .true.
         part = truth%tolerance/truth%verified_tolerance
         if (truth%verified_work*truth%growth**(1 + log(part)/log(ladder)) > part_of_search*reached%work) return
         channels = size(truth%scale)
         n = size(truth%finest, 2)
         if (.not. allocated(truth%coarse)) then
            call run_check(deck, truth%verified, truth%verified_tolerance, part, 2*reached%work, .false., quiet, &
               & 'second look at the integration', reached, check, error)
            if (allocated(error) .or. check%reason /= '') return
            allocate (truth%coarse, source=check%samples%values(:channels, :n))
         end if
         call run_check(deck, truth%verified, truth%verified_tolerance, ladder*part, 2*reached%work, .false., quiet, &
            & 'second look at the integration', reached, check, error)
         if (allocated(error) .or. check%reason /= '') return
         truth%values = truth%finest + (check%samples%values(:channels, :n) - truth%coarse)
         truth%of_time = rest_of_time*largest_difference(check%samples%values, truth%coarse)
         sharper = .true.
      end subroutine sharpen_integration

      !> All beams that matter once more one rung up, at the tolerance of the truth.
      subroutine sharpen_models()
         type(trial_type) :: check
         type(rung_type) :: rungs(size(truth%rungs))
         type(deck_type) :: higher
         real(wp) :: part
         integer :: i, n, channels
         if (truth%sharp_model) return
         truth%sharp_model = .true.
         rungs = truth%rungs
         part = 0.0_wp
         do i = 1, size(rungs)
            if (.not. (can_climb(rungs(i)) .and. matters(reached%advice, i, target))) cycle
            rungs(i) = next_rung(truth%rungs(i))
            rungs(i)%elements = truth%rungs(i)%elements
            part = max(part, rest_beyond(truth%rungs(i), rungs(i)))
         end do
         if (part <= 0.0_wp) return
         if (truth%work*sum(cost_of(rungs))/sum(cost_of(truth%rungs)) > part_of_search*reached%work) return
         if (allocated(truth%freed)) then
            higher = truth%freed
         else
            higher = higher_deck(deck, reached)
         end if
         call run_check(higher, [rungs, truth%aside], truth%verified_tolerance, truth%tolerance/truth%verified_tolerance, &
            & 2*reached%work, .false., quiet, 'second look at the models', reached, check, error)
         if (allocated(error) .or. check%reason /= '') return
         channels = size(truth%scale)
         n = size(truth%finest, 2)
         truth%of_model = part*largest_difference(check%samples%values, truth%finest)
         call truth%refine(check%samples%values(:channels, :n), check%work)
         truth%rungs = rungs
         sharper = .true.
      end subroutine sharpen_models

   end subroutine sharpen

   !> What may be left of the error of the truth after second looks, at best, relative.
   pure real(wp) function rest_after_looks(target, truth) result(left)
      real(wp), intent(in) :: target
      type(truth_type), intent(in) :: truth
      real(wp) :: rest(size(truth%rest))
      rest = truth%left_out*truth%scale
      if (truth%sharp_time) rest = rest + truth%of_time
      if (truth%sharp_model) rest = rest + truth%of_model
      left = min(maxval(truth%rest/truth%scale), max(doubt(2)*target, maxval(rest/truth%scale)))
   end function rest_after_looks

   !> One run at a smaller tolerance, counted.
   subroutine run_check(deck, rungs, tolerance, part, limit, wide, quiet, label, reached, check, error)
      type(deck_type), intent(in) :: deck
      type(rung_type), intent(in) :: rungs(:)
      !> Tolerance of the run that it verifies, and its own in units of that
      real(wp), intent(in) :: tolerance, part
      !> Counted work beyond `least_patience` after which it is given up
      real(wp), intent(in) :: limit
      !> Whether the scales of the channels are found
      logical, intent(in) :: wide, quiet
      character(*), intent(in) :: label
      type(reached_type), intent(inout) :: reached
      type(trial_type), intent(inout) :: check
      type(error_type), allocatable, intent(out) :: error
      call run_trial(deck, rungs, max(least_tolerance, part*tolerance), part, least_patience + limit, wide, quiet, label, check, &
         & error)
      reached%runs = reached%runs + 1
      reached%cpu = reached%cpu + check%outcome%cpu
      reached%work = reached%work + check%work
   end subroutine run_check

   !> Whether a beam is to be verified: if an error is expected, or if it bends so much that the expectation may be wrong.
   pure logical function matters(advice, i, target)
      type(advice_type), intent(in) :: advice
      integer, intent(in) :: i
      real(wp), intent(in) :: target
      matters = advice%expected(i) >= no_matter*target
      if (advice%rungs(i)%level > level_rigid) &
         & matters = matters .or. advice%probe%beams(i)%effect + advice%probe%beams(i)%stretch > no_effect*target
   end function matters

   !> The deck of the checks of the beams: with axial vibrations the steps of ADAMS would be bound to them.
   function higher_deck(deck, reached) result(higher)
      type(deck_type), intent(in) :: deck
      type(reached_type), intent(in) :: reached
      type(deck_type) :: higher
      higher = deck
      if (any(reached%advice%rungs%at_rest .and. can_climb(reached%advice%rungs))) &
         & call higher%set_option(deck%find('DYNAMICS'), 'INTEGRATOR', 'AUTO')
   end function higher_deck

   !> The error of the truth, with what no finer run of the kind can see.
   subroutine sum_up(target, reached, truth)
      real(wp), intent(in) :: target
      type(reached_type), intent(in) :: reached
      type(truth_type), intent(inout) :: truth
      integer :: i
      truth%left_out = 0.0_wp
      truth%safety = 1.0_wp
      if (size(truth%rungs) + size(truth%aside) > 0) truth%safety = safety
      if (any(reached%advice%probe%beams%slope > far .and. reached%advice%rungs%level > level_rigid)) truth%safety = safety_far
      do i = 1, size(truth%rungs)
         if (truth%rungs(i)%level == level_full) truth%left_out = truth%left_out + &
            & floor_of(truth%rungs(i), reached%advice%probe%beams(i))
      end do
      truth%rest = truth%of_time + truth%of_model + truth%left_out*truth%scale
      if (size(truth%rungs) + size(truth%aside) > 0) truth%rest = &
         & max(truth%rest, doubt(count([truth%sharp_time, truth%sharp_model]))*target*truth%scale)
   end subroutine sum_up

end module limber_analysis_verification
