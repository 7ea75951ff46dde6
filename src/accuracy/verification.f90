!> Verification of a candidate by finer runs. The finer runs have a smaller tolerance, and higher fidelity levels, with strain where
!> that may matter. Floor: accuracy. Equations: doc/theory, part 7.
module limber_accuracy_verification
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use limber_accuracy_advice, only: advice_type, check_rung, note_surprise, vibrates, rest_beyond
   use limber_accuracy_run_pool, only: pool_type
   use limber_accuracy_reached_target, only: reached_type
   use limber_accuracy_fidelity_levels, only: level_type, can_climb, names_of, richer, same_rungs
   use limber_accuracy_candidate, only: candidate_type, take_trial, least_patience, least_verified
   use limber_accuracy_reference_run, only: reference_run_type, error_against, largest_difference, place_of
   use limber_deck_content, only: deck_type
   implicit none
   private
   public :: verify, bound_strain, does_for, falls_short

   !> Part of the target that the error of a truth may be that is good enough for another setting; that it is taken to err at least
   !> where there are beams
   real(wp), parameter :: sure = 0.35_wp, doubt = 0.07_wp
   !> Part of the target that the integration of a truth may err by
   real(wp), parameter :: of_truth = 0.1_wp
   !> Ratio of the tolerances of a run and its check
   real(wp), parameter, public :: ladder = 0.2_wp
   !> What differences are multiplied by where the integration is judged, and the part of the target from which on it is mended
   !> first
   real(wp), parameter, public :: widening = 1.25_wp, time_first = 0.75_wp
   !> Tolerance from which on RADAU may step over vibrations of the strain; work of a run of higher rungs in units of the run's
   real(wp), parameter :: loose = 1.0e-4_wp, most_higher = 16.0_wp
   !> Part of the error of the integration that is left where a smaller tolerance has been of use
   real(wp), parameter :: helped = 0.5_wp

contains

   !> Whether a finer run that is there already does for the present setting, so that none has to be made.
   pure logical function does_for(truth, rungs, tolerance, target)
      type(reference_run_type), intent(in) :: truth
      type(level_type), intent(in) :: rungs(:)
      real(wp), intent(in) :: tolerance, target
      does_for = .false.
      if (.not. truth%known .or. size(rungs) == 0) return
      does_for = truth%tolerance <= tolerance .and. all(truth%rest <= sure*target*truth%scale) .and. &
         & all(truth%rungs%step > rungs%step .or. rungs%step == 0) .and. all(truth%rungs%stretches .or. .not. rungs%stretches)
   end function does_for

   !> Whether a finer run lacks functions or strain that its beams are to be verified with by what is known now.
   pure logical function falls_short(truth, advice, doubted)
      type(reference_run_type), intent(in) :: truth
      type(advice_type), intent(in) :: advice
      !> As in `check_rung`
      logical, intent(in) :: doubted
      type(level_type) :: check
      integer :: i
      falls_short = .false.
      if (.not. truth%known) return
      do i = 1, size(advice%rungs)
         check = check_rung(advice, i, doubted)
         falls_short = falls_short .or. (check%stretches .and. .not. (truth%rungs(i)%stretches .or. truth%strained)) .or. &
            & (check%step > advice%rungs(i)%step .and. truth%rungs(i)%step <= advice%rungs(i)%step)
      end do
   end function falls_short

   !> Runs the checks of a run and estimates its error from the differences, eqs. (7.89), (7.92): with a smaller tolerance, and then
   !> with all beams that matter higher, which is the truth. Where the integration alone errs by too much, and there is another
   !> round, the beams wait.
   subroutine verify(deck, target, quiet, on, pool, candidate, reached, truth, looser, error)
      type(deck_type), intent(in) :: deck
      real(wp), intent(in) :: target
      !> Whether the progress is not shown; whether there is another round if this one fails
      logical, intent(in) :: quiet, on
      type(pool_type), intent(inout) :: pool
      type(candidate_type), intent(in) :: candidate
      type(reached_type), intent(inout) :: reached
      type(reference_run_type), intent(inout) :: truth
      !> Whether the integration errs by so little that the next run is to have a larger tolerance, before anything else is looked
      !> at
      logical, intent(out) :: looser
      type(error_type), allocatable, intent(out) :: error
      type(candidate_type) :: finer, check
      type(level_type) :: rungs(size(reached%advice%rungs))
      real(wp), allocatable :: of_time(:), rest(:)
      real(wp) :: step, part, beyond, falling, rest_of_time
      !> Tolerances of a check that is there already, in units of that of the run
      real(wp), parameter :: finest = 0.005_wp, coarsest = 0.41_wp
      !> Part of the target from which on an error of the models is one that may surprise
      real(wp), parameter :: noticed = 0.1_wp
      integer :: i, n
      looser = .false.
      n = candidate%samples%samples
      reached%of_model = 0.0_wp
      truth%known = .false.
      associate (advice => reached%advice, estimate => reached%estimate)
         ! Where no smaller tolerance is left, a looser one shows how far errors fall
         step = merge(ladder, 1/ladder, advice%tolerance > 0.99_wp*least_verified)
         ! A run that is there already does as well
         if (step < 1.0_wp .and. allocated(truth%scale)) step = pool%kept_tolerance(deck, advice%rungs, step*advice%tolerance, &
            & finest*advice%tolerance, coarsest*advice%tolerance)/advice%tolerance
         estimate%companion = step*advice%tolerance
         estimate%reason = ''
         estimate%of_model = .true.
         call pool%check(deck, advice%rungs, advice%tolerance, step, 60*candidate%work, .not. allocated(truth%scale), quiet, &
            & 'check of the integration', finer, error)
         if (allocated(error)) return
         if (finer%reason /= '') then
            reached%reason = 'the check at TOLERANCE='//as_text(estimate%companion, 2)//' failed: '//finer%reason
            estimate%reason = reached%reason
            return
         end if
         if (.not. allocated(truth%scale)) then
            allocate (truth%scale, source=finer%scale)
            allocate (truth%of_terms, source=finer%of_terms)
         end if
         associate (channels => size(truth%scale))
            ! What the finer of the two errs by, and the run itself as it would differ from one with a tenth of its tolerance
            falling = reached%shown%falling
            rest_of_time = rest_of(min(step, 1/step), falling)
            allocate (rest, source=largest_difference(finer%samples%values(:channels, :n), &
               & candidate%samples%values(:channels, :n)))
            allocate (of_time, source=rest*(1 + rest_of_time)/(1 + rest_of(ladder, falling)))
            reached%of_time = maxval([0.0_wp, of_time/truth%scale])
            reached%place_of_time = place_of(finer%samples%values(:channels, :n), candidate%samples%values(:channels, :n), &
               & truth%scale, candidate%samples%times, candidate%names)
            call reached%shown%take(advice%rungs, advice%tolerance, reached%of_time, target, &
               & candidate%samples%values(:channels, :n), finer%samples%values(:channels, :n))
            if (step < 1.0_wp) then
               call truth%take(advice%rungs, estimate%companion, finer%samples%values(:channels, :n), finer%work, &
                  & rest_of_time*rest)
            else
               call truth%take(advice%rungs, advice%tolerance, candidate%samples%values(:channels, :n), candidate%work, &
                  & rest_of_time*rest)
            end if
            if (on) call loosen(reached, target, looser)
            if (looser) then
               truth%known = .false.
               return
            end if
            do i = 1, size(rungs)
               rungs(i) = check_rung(advice, i, reached%doubted)
            end do
            reached%believed = any(rungs%step == 0)
            reached%useless = reached%of_time_before > 0.0_wp .and. any(can_climb(advice%rungs)) .and. .not. reached%slow .and. &
               & reached%of_time > max(target, helped*reached%of_time_before)
            if (on .and. advice%open_tolerance .and. size(rungs) > 0 .and. widening*reached%of_time > time_first*target .and. &
               & .not. reached%useless) then
               reached%error = widening*reached%of_time
               reached%place = reached%place_of_time
               truth%known = .false.
               return
            end if
            if (any(rungs%step > advice%rungs%step .or. (rungs%stretches .neqv. advice%rungs%stretches))) then
               ! No smaller than it takes for the integration to err by less than half of the doubt
               part = 1.0_wp
               ! With strain for the first time a tolerance costs little, and the run may be one that just keeps the target
               beyond = merge(0.5_wp*doubt, of_truth, any(rungs%stretches .and. .not. advice%rungs%stretches))
               if (reached%of_time > beyond*target) part = max(ladder, (beyond*target/reached%of_time)**(1/falling))
               if (part < 1.5_wp*ladder) part = ladder
               ! What vibrates along itself tells nothing where steps are longer than that
               if (any([(vibrates(advice, i, reached%doubted), i=1, size(rungs))] .and. rungs%stretches)) &
                  & part = min(part, loose/advice%tolerance)
               part = pool%kept_tolerance(deck, rungs, part*advice%tolerance, ladder*part*advice%tolerance, &
                  & min(2*part, 1.0_wp)*advice%tolerance)/advice%tolerance
               call run_higher(deck, rungs, advice%tolerance, part, candidate%work, quiet, pool, reached, check, error)
               if (allocated(error)) return
               if (check%reason /= '') then
                  reached%of_model = huge(1.0_wp)
                  reached%error = huge(1.0_wp)
                  truth%known = .false.
                  return
               end if
               beyond = 0.0_wp
               do i = 1, size(rungs)
                  beyond = max(beyond, rest_beyond(advice%rungs(i), rungs(i), advice%probe%beams(i)))
               end do
               ! Of the two runs that it may be compared with, the nearer one errs less in time
               rest = min(largest_difference(check%samples%values(:channels, :n), truth%values), &
                  & largest_difference(check%samples%values(:channels, :n), candidate%samples%values(:channels, :n)))
               reached%of_model = maxval(rest/truth%scale)
               reached%place_of_model = place_of(check%samples%values(:channels, :n), candidate%samples%values(:channels, :n), &
                  & truth%scale, candidate%samples%times, candidate%names)
               if (reached%of_model - reached%of_time > noticed*target) &
                  & call note_surprise(advice, reached%of_model - reached%of_time)
               rest = max(beyond*rest + part**falling*of_time, doubt*target*truth%scale)
               call truth%take(rungs, part*advice%tolerance, check%samples%values(:channels, :n), check%work, rest)
               if (on .and. .not. falls_short(truth, advice, reached%doubted)) call look_further(deck, target, quiet, pool, &
                  & candidate, check, part**falling*of_time, reached, truth, error)
               if (allocated(error)) return
            else if (size(rungs) > 0) then
               truth%rest = max(truth%rest, doubt*target*truth%scale)
            end if
            reached%error = error_against(truth, candidate%samples%values)
            reached%place = place_of(candidate%samples%values(:channels, :n), truth%values, truth%scale, &
               & candidate%samples%times, candidate%names)
         end associate
      end associate
   end subroutine verify

   !> What the strain makes of a run where nothing is known of it and all else keeps the target: two runs of its own functions that
   !> differ in that alone cost the least. If it is little it is counted as an error of the truth, eq. (7.86).
   subroutine bound_strain(deck, target, quiet, pool, candidate, reached, truth, error)
      type(deck_type), intent(in) :: deck
      real(wp), intent(in) :: target
      logical, intent(in) :: quiet
      type(pool_type), intent(inout) :: pool
      type(candidate_type), intent(in) :: candidate
      type(reached_type), intent(inout) :: reached
      type(reference_run_type), intent(inout) :: truth
      type(error_type), allocatable, intent(out) :: error
      type(candidate_type) :: strained, plain
      type(level_type) :: rungs(size(reached%advice%rungs)), check
      real(wp) :: rest(size(truth%rest)), part
      integer :: i
      associate (advice => reached%advice)
         do i = 1, size(rungs)
            check = check_rung(advice, i, doubted=.true.)
            rungs(i) = richer(advice%rungs(i), 0, check%stretches)
            ! Functions are to be verified first
            if (check%step > advice%rungs(i)%step .and. truth%rungs(i)%step <= advice%rungs(i)%step) return
         end do
         part = 1.0_wp
         if (advice%probe%blind) part = reached%estimate%companion/advice%tolerance
         call pool%check(deck, rungs, advice%tolerance, part, 5*most_higher*candidate%work, .false., quiet, 'strain of '// &
            & names_of(rungs), strained, error)
         if (allocated(error) .or. strained%reason /= '') return
         ! It is there: the run itself, or the check of its integration
         call pool%check(deck, advice%rungs, advice%tolerance, part, 5*most_higher*candidate%work, .false., quiet, &
            & 'the same without strain', plain, error)
         if (allocated(error) .or. plain%reason /= '') return
         rest = truth%rest
         truth%rest = rest + largest_difference(strained%samples%values, plain%samples%values(:size(rest), :size(truth%values, 2)))
         truth%strained = error_against(truth, candidate%samples%values) <= target
         if (truth%strained) then
            reached%error = error_against(truth, candidate%samples%values)
         else
            truth%rest = rest
         end if
      end associate
   end subroutine bound_strain

   !> Error of a check as a part of its difference from the run, by the power that errors fall with; usually they fall faster,
   !> eq. (7.88).
   pure real(wp) function rest_of(step, falling)
      !> Tolerance of the check in units of that of the run, below 1
      real(wp), intent(in) :: step, falling
      real(wp), parameter :: usually = 0.75_wp
      rest_of = usually*step**falling/(1 - step**falling)
   end function rest_of

   !> A truth of still higher rungs, where all that speaks against a run is the doubt about the truth.
   subroutine look_further(deck, target, quiet, pool, candidate, check, of_time, reached, truth, error)
      type(deck_type), intent(in) :: deck
      real(wp), intent(in) :: target
      logical, intent(in) :: quiet
      type(pool_type), intent(inout) :: pool
      !> The run that is verified, and the truth's
      type(candidate_type), intent(in) :: candidate
      type(candidate_type), intent(inout) :: check
      !> What is left of the error of the integration in the truth (channels)
      real(wp), intent(in) :: of_time(:)
      type(reached_type), intent(in) :: reached
      type(reference_run_type), intent(inout) :: truth
      type(error_type), allocatable, intent(out) :: error
      !> Part of the target that the difference may be
      real(wp), parameter :: room = 0.75_wp
      type(candidate_type) :: further
      type(level_type) :: higher(size(truth%rungs))
      real(wp), allocatable :: rest(:)
      real(wp) :: part, beyond
      integer :: i, n
      n = size(truth%values, 2)
      if (error_against(truth, candidate%samples%values) <= target) return
      if (any(largest_difference(candidate%samples%values, truth%values) > room*target*truth%scale)) return
      associate (advice => reached%advice)
         higher = richer(truth%rungs, merge(1, 0, truth%rungs%step > 0), .false.)
         if (same_rungs(higher, truth%rungs)) return
         part = truth%tolerance/advice%tolerance
         call run_higher(deck, higher, advice%tolerance, part, candidate%work, quiet, pool, reached, further, error)
         if (allocated(error) .or. further%reason /= '') return
         beyond = 0.0_wp
         do i = 1, size(higher)
            beyond = max(beyond, rest_beyond(truth%rungs(i), higher(i), advice%probe%beams(i)))
         end do
         allocate (rest, source=beyond*largest_difference(further%samples%values, truth%values))
         call truth%take(higher, part*advice%tolerance, further%samples%values(:size(rest), :n), further%work, &
            & max(rest + of_time, doubt*target*truth%scale))
         call take_trial(further, check)
      end associate
   end subroutine look_further

   !> Takes a larger tolerance for a scene of beams whose integration errs by very little; the run that was made verifies it then.
   pure subroutine loosen(reached, target, loosens)
      type(reached_type), intent(inout) :: reached
      real(wp), intent(in) :: target
      logical, intent(out) :: loosens
      !> Part of the target that the error is below, the factor, and the largest tolerance
      real(wp), parameter :: little = 0.06_wp, loosest = 1.0e-2_wp
      !> The power that errors grow with at least, and the factor from which on it is taken in one step: then no run that is there
      !> verifies the next one
      real(wp), parameter :: growing = 0.6_wp, far = 1.0e3_wp
      real(wp) :: factor
      associate (advice => reached%advice)
         loosens = advice%open_tolerance .and. advice%integrator == 'RADAU' .and. .not. reached%tightened .and. &
            & reached%of_time < little*target .and. advice%tolerance < 0.5_wp*loosest
         if (.not. loosens) return
         factor = (little*target/max(reached%of_time, tiny(1.0_wp)**0.3_wp))**(1/growing)
         if (factor < far) factor = 1/ladder
         advice%tolerance = min(loosest, factor*advice%tolerance)
      end associate
   end subroutine loosen

   !> The run with higher rungs. A small tolerance may follow vibrations that cost very much, and a loose one excite them: then
   !> another one is tried, and patience at last.
   subroutine run_higher(deck, rungs, tolerance, part, work, quiet, pool, reached, check, error)
      type(deck_type), intent(in) :: deck
      type(level_type), intent(in) :: rungs(:)
      !> That of the run to be verified; its own in units of that, on return what it was; counted work of that run
      real(wp), intent(in) :: tolerance, work
      real(wp), intent(inout) :: part
      logical, intent(in) :: quiet
      type(pool_type), intent(inout) :: pool
      type(reached_type), intent(in) :: reached
      type(candidate_type), intent(inout) :: check
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: most(4) = [most_higher, 24.0_wp, 32.0_wp, 200.0_wp], looser = 0.7_wp
      integer :: i
      real(wp) :: factor(4), asked, limit
      asked = part
      factor = [1.0_wp, 0.1_wp, 1/part, 1.0_wp]
      if (part < looser) factor(2:3) = factor(3:2:-1)
      do i = 1, size(factor)
         part = factor(i)*asked
         if (part*tolerance < 0.1_wp*least_verified) cycle
         if (i == 3 .and. .not. asked < 1.0_wp) cycle
         ! Strain has fast vibrations, and a rigid beam has none
         limit = most(i)*merge(5.0_wp, 1.0_wp, any(rungs%stretches .and. .not. reached%advice%rungs%stretches .or. &
            & rungs%step > 0 .and. reached%advice%rungs%step == 0))*work
         if (i < size(factor)) limit = limit - least_patience
         call pool%check(deck, rungs, tolerance, part, limit, .false., quiet, 'check of '//names_of(rungs), check, error)
         if (allocated(error)) return
         if (check%reason == '') return
      end do
   end subroutine run_higher

end module limber_accuracy_verification
