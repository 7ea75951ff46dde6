!> Search of the setting for a target. The advised model is run and verified by a finer run, climbs where that shows too large an
!> error, and goes down where less will do. Floor: accuracy. Equations: doc/theory, part 7.
module limber_accuracy_target_search
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, status_interrupted
   use limber_base_text, only: as_text, newline
   use limber_accuracy_advice, only: advice_type, make_advice, expected_error, expected_stretch, check_rung, begin_bending, deck_of
   use limber_accuracy_coarsening, only: descend
   use limber_accuracy_fixed_options, only: verify_fixed, find_fixed, unverified_words
   use limber_accuracy_run_pool, only: pool_type
   use limber_accuracy_reached_target, only: reached_type, record_errors, say_why
   use limber_accuracy_pilot_run, only: forecast_type
   use limber_accuracy_fidelity_levels, only: level_type, richer, can_climb, names_of
   use limber_accuracy_candidate, only: candidate_type, take_trial, take_samples, least_patience, least_verified
   use limber_accuracy_reference_run, only: reference_run_type, error_against
   use limber_accuracy_verification, only: verify, bound_strain, does_for, falls_short, ladder, widening, time_first
   use limber_deck_content, only: deck_type
   implicit none
   private
   public :: reach_target

   !> Most rounds, and work of a run in units of that of the last one after which it is given up
   integer, parameter :: most_rounds = 60
   real(wp), parameter :: patience = 100.0_wp
   !> The run that misses the target by the least, and what it was compared with
   type :: best_type
      type(reached_type) :: reached
      type(candidate_type) :: candidate
      type(reference_run_type) :: truth
      logical :: known = .false.
   end type best_type

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
      type(candidate_type) :: candidate
      type(reference_run_type) :: truth
      type(pool_type) :: pool
      call search(deck, target, quiet, pool, reached, candidate, truth, error)
      reached%runs = pool%runs
      reached%cpu = pool%cpu
      reached%work = pool%work
      reached%spent = pool%spent
      if (allocated(error)) then
         if (error%status /= status_interrupted) return
         call move_alloc(error%message, reached%interruption)
         deallocate (error)
         if (.not. allocated(candidate%outcome)) return
      end if
      if (reached%done .or. truth%known) call record_errors(truth, candidate, reached)
      if (.not. (reached%done .or. allocated(reached%interruption))) call say_why(target, reached)
      reached%statistics = candidate%statistics
      call move_alloc(candidate%outcome, reached%outcome)
      call take_samples(candidate%samples%memory_type, reached%samples)
   end subroutine reach_target

   !> The search itself.
   subroutine search(deck, target, quiet, pool, reached, candidate, truth, error)
      type(deck_type), intent(in) :: deck
      real(wp), intent(in) :: target
      logical, intent(in) :: quiet
      !> All runs
      type(pool_type), intent(inout) :: pool
      type(reached_type), intent(inout) :: reached
      !> The run that was verified, and the finest
      type(candidate_type), intent(inout) :: candidate
      type(reference_run_type), intent(inout) :: truth
      !> The deck is wrong (status 2), or a signal asks for the end (status 4)
      type(error_type), allocatable, intent(out) :: error
      type(best_type) :: best
      type(candidate_type) :: next
      type(advice_type) :: verified
      real(wp) :: limit
      integer :: round
      !> Whether the error that is known is that of the candidate
      logical :: own
      logical :: climbed, on, looser
      own = .false.
      reached%reason = ''
      reached%path = ''
      reached%place = ''
      reached%place_of_time = ''
      reached%place_of_model = ''
      call find_fixed(deck, reached%fixed)
      reached%unverified = unverified_words(deck)
      call make_advice(deck, target, reached%advice, error)
      if (allocated(error)) return
      limit = huge(limit)
      do round = 1, most_rounds
         climbed = .false.
         reached%reason = ''
         reached%doubted = .false.
         if (round == 1) then
            call begin(deck, quiet, pool, next, reached, error)
         else
            call pool%run(deck_of(reached%advice, deck), reached%advice%rungs, reached%advice%tolerance, 1.0_wp, limit, .false., &
               & quiet, 'run', next, error)
         end if
         ! What a signal ends at the first run is what there is
         if (.not. allocated(error) .or. round == 1) then
            verified = reached%advice
            call take_trial(next, candidate)
            own = .false.
         end if
         if (allocated(error)) exit
         limit = least_patience + patience*candidate%work
         if (candidate%reason == '') call pool%allow(candidate%work)
         ! Up only if what is there can be run as well
         on = round < most_rounds .and. .not. pool%spent
         if (candidate%reason /= '') then
            reached%reason = candidate%reason
            if (on) call climb_all(reached, climbed)
         else
            if (does_for(truth, reached%advice%rungs, reached%advice%tolerance, target) .and. &
               & .not. falls_short(truth, reached%advice, .true.)) then
               reached%error = error_against(truth, candidate%samples%values)
               reached%of_model = reached%error
            else
               call verify(deck_of(reached%advice, deck), target, quiet, on, pool, candidate, reached, truth, looser, error)
               if (allocated(error)) exit
               if (looser) cycle
               ! What the probe expects does not count where it has been wrong
               if (reached%error <= target .and. falls_short(truth, reached%advice, .true.)) call bound_strain( &
                  & deck_of(reached%advice, deck), target, quiet, pool, candidate, reached, truth, error)
               if (allocated(error)) exit
               reached%doubted = reached%error <= target .and. falls_short(truth, reached%advice, .true.)
               if (reached%doubted) call verify(deck_of(reached%advice, deck), target, quiet, on, pool, candidate, reached, &
                  & truth, looser, error)
               if (allocated(error)) exit
               if (looser) cycle
            end if
            if (.not. quiet .and. reached%error < huge(1.0_wp)) call pool%say('this one errs by '//as_text(reached%error, 2)// &
               & reached%place)
            reached%done = reached%reason == '' .and. truth%known .and. reached%error <= target
            if (reached%done .and. on) call look_back(target, truth, reached, climbed)
            if (reached%done) then
               call verify_fixed(deck, target, quiet, pool, candidate, reached, truth, error)
               if (allocated(error) .or. .not. reached%done) exit
               call descend(deck, target, quiet, pool, truth, reached, candidate, error)
               exit
            end if
            own = reached%reason == '' .and. truth%known
            if (.not. climbed .and. own) call keep_best()
            if (on .and. .not. climbed) call climb(target, truth, reached, climbed)
         end if
         if (.not. climbed) exit
         reached%climbs = reached%climbs + 1
      end do
      if (allocated(error) .and. .not. reached%done) reached%advice = verified
      if (.not. reached%done .and. best%known) call give_back()

   contains

      !> Keeps a run that misses the target if it misses it by less than those before.
      subroutine keep_best()
         if (best%known .and. best%reached%error <= reached%error) return
         best%known = .true.
         best%reached = reached
         best%candidate = candidate
         best%truth = truth
      end subroutine keep_best

      !> Gives the best run back where the last one misses the target by more, or was not verified.
      subroutine give_back()
         if (own .and. best%reached%error >= reached%error) return
         candidate = best%candidate
         truth = best%truth
         reached%advice = best%reached%advice
         reached%error = best%reached%error
         reached%of_time = best%reached%of_time
         reached%of_model = best%reached%of_model
         reached%place = best%reached%place
         reached%path = reached%path//newline//'   the best of these runs is kept: TOLERANCE='// &
            & as_text(reached%advice%tolerance, 2)//', error '//as_text(reached%error, 2)
      end subroutine give_back

   end subroutine search

   !> The first run. Scenes with beams take RADAU, and try what AUTO takes: ADAMS at the tolerance of rigid bodies, which it needs,
   !> stays if it costs much less.
   subroutine begin(deck, quiet, pool, candidate, reached, error)
      type(deck_type), intent(in) :: deck
      !> Whether the progress is not shown
      logical, intent(in) :: quiet
      type(pool_type), intent(inout) :: pool
      type(candidate_type), intent(inout) :: candidate
      type(reached_type), intent(inout) :: reached
      !> The deck is wrong (status 2), or a signal asks for the end (status 4)
      type(error_type), allocatable, intent(out) :: error
      !> Tolerance of ADAMS in units of the target, and the part of RADAU's work that it may take
      real(wp), parameter :: of_adams = 0.03_wp, cheaper = 1.0_wp/3
      type(candidate_type) :: adams
      type(level_type) :: higher(size(reached%advice%rungs))
      real(wp) :: tolerance, limit
      integer :: i
      logical :: both
      associate (advice => reached%advice)
         both = any(advice%rungs%step > 0) .and. advice%open_integrator .and. advice%open_tolerance
         call begin_bending(advice)
         call pool%run(deck_of(advice, deck), advice%rungs, advice%tolerance, 1.0_wp, huge(limit), .false., quiet, 'run', &
            & candidate, error)
         if (allocated(error) .or. .not. any(advice%rungs%step > 0) .or. .not. advice%open_tolerance) return
         tolerance = min(advice%tolerance, of_adams*advice%target)
         if (.not. (both .or. candidate%integrator == 'ADAMS' .and. tolerance < advice%tolerance)) return
         limit = huge(limit)
         if (both .and. candidate%reason == '') then
            limit = cheaper*candidate%work
            ! What verifies it must be for ADAMS as well
            do i = 1, size(higher)
               higher(i) = check_rung(advice, i, doubted=.true.)
            end do
            call pool%run(deck, higher, tolerance, 1.0_wp, 0.0_wp, .false., quiet, 'choice of AUTO', adams, error, only='ADAMS')
            if (allocated(error) .or. adams%integrator /= 'ADAMS') return
         end if
         call pool%run(deck, advice%rungs, tolerance, 1.0_wp, limit, .false., quiet, 'run with ADAMS', adams, error, &
            & only='ADAMS')
         if (allocated(error)) return
         if (adams%integrator /= 'ADAMS' .or. (both .and. adams%reason /= '')) return
         advice%integrator = ''
         advice%tolerance = tolerance
         call take_trial(adams, candidate)
      end associate
   end subroutine begin

   !> Up where the verification shows too large a part: a smaller tolerance, and the beams one rung or two, or with strain where the
   !> stretch is what was expected.
   subroutine climb(target, truth, reached, climbed)
      real(wp), intent(in) :: target
      !> What the run was compared with
      type(reference_run_type), intent(in) :: truth
      type(reached_type), intent(inout) :: reached
      logical, intent(out) :: climbed
      !> Part of the error that is left when more functions have not helped, of few and of many functions
      real(wp), parameter :: stalled = 0.7_wp, stalled_high = 0.5_wp
      !> Part of the target that a smaller tolerance is to leave of the error of the integration
      real(wp), parameter :: of_tightened = 0.3_wp
      integer, parameter :: high = 7
      type(level_type) :: higher
      integer :: i
      logical :: stalls, rigid
      climbed = .false.
      stalls = reached%before > 0.0_wp .and. reached%of_model > reached%before* &
         & merge(stalled_high, stalled, any(reached%advice%rungs%step >= high))
      reached%before = 0.0_wp
      associate (advice => reached%advice)
         rigid = .not. any(advice%rungs%step > 0)
         if (stalls .and. does_for(truth, advice%rungs, advice%tolerance, target) .and. &
            & .not. any(truth%rungs%stretches .and. .not. advice%rungs%stretches)) then
            ! Beside a truth of a much smaller tolerance it may be the integration that is left
            if (advice%open_tolerance .and. truth%tolerance < 0.5_wp*ladder*advice%tolerance) call tighten(ladder)
            if (climbed) return
            ! Few functions may all lack the same shape, and the truth has it
            do i = 1, size(advice%rungs)
               call put(i, richer(advice%rungs(i), max(1, truth%rungs(i)%step - 1 - advice%rungs(i)%step), .false.))
            end do
            if (climbed) return
         end if
         if (reached%useless .and. (reached%gave_way .or. reached%of_model <= 0.5_wp*target)) then
            reached%slow = .true.
            reached%useless = .false.
         else if (reached%useless) then
            reached%gave_way = .true.
            advice%tolerance = reached%tolerance_before
         end if
         if (widening*reached%of_time > time_first*target .and. advice%open_tolerance .and. .not. reached%useless) &
            & call tighten(merge(ladder, 2.5_wp*ladder, &
            & (of_tightened*target/reached%of_time)**(0.75_wp/reached%shown%falling) < 1.5_wp*ladder))
         if (.not. climbed) reached%of_time_before = 0.0_wp
         if (.not. truth%known .and. climbed) return
         if (stalls .and. climbed) return
         if (reached%of_model > 0.5_wp*target .or. .not. climbed) then
            do i = 1, size(advice%rungs)
               if (.not. can_climb(advice%rungs(i))) cycle
               higher = next_rung(advice%rungs(i), advice%probe%beams(i), stalls .and. truth%rungs(i)%stretches, &
                  & reached%of_model, target)
               ! Without strain all has kept the target
               if (reached%doubted .and. truth%rungs(i)%stretches) higher = richer(advice%rungs(i), 0, .true.)
               call put(i, higher)
            end do
         end if
         if (climbed) reached%before = reached%of_model
         if (rigid .and. .not. reached%tightened) call begin_bending(advice)
         if (.not. climbed .and. advice%open_tolerance .and. reached%of_time > 0.1_wp*target) call tighten(0.2_wp)
      end associate

   contains

      subroutine tighten(factor)
         real(wp), intent(in) :: factor
         if (reached%advice%tolerance <= least_verified) return
         reached%tightened = .true.
         reached%tolerance_before = reached%advice%tolerance
         reached%of_time_before = reached%of_time
         reached%advice%tolerance = max(least_verified, factor*reached%advice%tolerance)
         if (stalls) then
            reached%path = reached%path//newline//'   the model hardly changed an error of '//as_text(reached%of_model, 2)// &
               & reached%place_of_model
         else
            reached%path = reached%path//newline//'   the integration had an error of '//as_text(reached%of_time, 2)// &
               & reached%place_of_time
         end if
         reached%path = reached%path//': TOLERANCE='//as_text(reached%advice%tolerance, 2)
         climbed = .true.
      end subroutine tighten

      subroutine put(i, higher)
         integer, intent(in) :: i
         type(level_type), intent(in) :: higher
         if (higher%step == reached%advice%rungs(i)%step .and. (higher%stretches .eqv. reached%advice%rungs(i)%stretches)) return
         reached%advice%rungs(i) = higher
         call say()
      end subroutine put

      !> What led to the present rungs.
      subroutine say()
         integer :: k
         climbed = .true.
         reached%path = reached%path//newline//'   the model had an error of '
         if (reached%of_model < 1.0e3_wp) then
            reached%path = reached%path//as_text(reached%of_model, 2)//reached%place_of_model
         else
            reached%path = reached%path//'unknown size'
         end if
         reached%path = reached%path//': '//names_of(reached%advice%rungs)
         do k = 1, size(reached%advice%rungs)
            reached%advice%expected(k) = expected_error(reached%advice%rungs(k), reached%advice%probe%beams(k))
         end do
      end subroutine say

   end subroutine climb

   !> The rung above one that errs by too much: with strain where the stretch is what was expected, else one higher or two.
   pure type(level_type) function next_rung(rung, beam, stalls, error, target) result(higher)
      type(level_type), intent(in) :: rung
      type(forecast_type), intent(in) :: beam
      !> Whether more functions of the angle have not helped
      logical, intent(in) :: stalls
      !> That it has shown, and what is asked for, relative
      real(wp), intent(in) :: error, target
      !> Part of the error from which on the stretch, or the bending, is one of its causes; what a rung divides the error by
      real(wp), parameter :: cause = 0.3_wp, each = 4.0_wp, unknown = 1.0e3_wp
      integer, parameter :: most_steps = 3
      real(wp) :: aim, stretch
      integer :: steps
      logical :: by_stretch
      steps = 1
      if (error > target .and. error < unknown) steps = min(most_steps, 1 + int(log(error/target)/log(each)))
      aim = cause*min(1.0_wp, error)
      stretch = expected_stretch(rung, beam)
      by_stretch = rung%open_strains .and. .not. rung%stretches .and. (stalls .or. stretch > max(aim, 0.9_wp*target))
      higher = richer(rung, 0, by_stretch)
      if (.not. by_stretch .or. .not. stalls .and. expected_error(rung, beam) - stretch > aim) &
         & higher = richer(higher, steps, .false.)
      if (higher%step > rung%highest - 1) higher%step = max(rung%highest - 1, rung%step)
      if (higher%step == rung%step) higher = richer(higher, 0, .true.)
   end function next_rung

   !> Two runs that agree may both miss what a finer run of an earlier pair has met: then a smaller tolerance decides, eq. (7.94).
   subroutine look_back(target, truth, reached, again)
      real(wp), intent(in) :: target
      type(reference_run_type), intent(in) :: truth
      !> With a target that is kept
      type(reached_type), intent(inout) :: reached
      !> Whether it is to be run at a smaller tolerance
      logical, intent(out) :: again
      !> Most of such looks, and what the tolerance is multiplied by
      integer, parameter :: most_looks = 2
      real(wp), parameter :: smaller = 0.1_wp
      associate (advice => reached%advice, shown => reached%shown)
         again = advice%open_tolerance .and. advice%tolerance > least_verified .and. shown%looks < most_looks
         if (again) again = shown%is_forgotten(advice%rungs, truth%values, truth%scale, target)
         if (.not. again) return
         shown%looks = shown%looks + 1
         advice%tolerance = max(least_verified, smaller*advice%tolerance)
         reached%path = reached%path//newline//'   a finer run had shown a difference of '//as_text(shown%difference, 2)// &
            & ' that these two do not: TOLERANCE='//as_text(advice%tolerance, 2)
         reached%done = .false.
      end associate
   end subroutine look_back

   !> Goes up with all beams, for a run has failed.
   subroutine climb_all(reached, climbed)
      type(reached_type), intent(inout) :: reached
      logical, intent(out) :: climbed
      associate (rungs => reached%advice%rungs)
         climbed = any(can_climb(rungs))
         if (.not. climbed) return
         reached%path = reached%path//newline//'   '//names_of(rungs)//' failed: '
         rungs = merge(richer(rungs, 1, .true.), rungs, can_climb(rungs))
         reached%path = reached%path//names_of(rungs)
      end associate
   end subroutine climb_all

end module limber_accuracy_target_search
