!> A run that keeps a requested accuracy: the advised model is run and verified, climbs where the verification shows too large an
!> error and runs again, and goes down where less will do. Floor: analysis. Equations: doc/theory.md, accuracy on request.
module limber_analysis_target
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, status_interrupted
   use limber_base_text, only: as_text, newline
   use limber_analysis_advice, only: advice_type, make_advice, find_floors
   use limber_analysis_climb, only: take_seen, climb, climb_all, look_back
   use limber_analysis_descent, only: descend
   use limber_analysis_fixed, only: verify_fixed, find_fixed, unverified_words, support_words
   use limber_analysis_reached, only: reached_type, record_errors, say_why
   use limber_analysis_trial, only: trial_type, run_trial, take_samples, take_outcome, least_patience
   use limber_analysis_truth, only: truth_type, error_against
   use limber_analysis_verification, only: verify, matters
   use limber_deck_content, only: deck_type
   implicit none
   private
   public :: reach_target

   !> Part of the target that the error of a truth may be that is good enough for another setting
   real(wp), parameter :: sure = 0.3_wp
   !> Most rounds, and work in units of the last run's after which no more are begun
   integer, parameter :: most_rounds = 10
   real(wp), parameter :: patience = 100.0_wp

   !> The run that misses the target by the least, and what it was compared with
   type :: best_type
      real(wp) :: error = huge(1.0_wp), of_time = 0.0_wp
      type(trial_type) :: candidate
      type(truth_type) :: truth
      type(advice_type) :: advice
   contains
      procedure :: keep => keep_best
      procedure :: give_back
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
      if (.not. reached%done) reached%of_supports = support_words(deck, target, reached)
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
      type(best_type) :: best
      real(wp) :: limit
      integer :: round
      logical :: climbed, on
      reached%reason = ''
      reached%path = ''
      reached%of_supports = ''
      call find_fixed(deck, reached%fixed)
      reached%unverified = unverified_words(deck)
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
         limit = 5*least_patience + patience*candidate%work
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
            if (.not. reached%done) then
               call verify(deck, target, quiet, on, candidate, reached, truth, error)
               if (allocated(error)) return
               reached%done = reached%reason == '' .and. reached%error <= target
            end if
            if (reached%done .and. on) call look_back(target, truth, reached, climbed)
            if (reached%done) then
               call verify_fixed(deck, target, quiet, candidate, reached, truth, error)
               if (allocated(error) .or. .not. reached%done) exit
            end if
            if (reached%done) call descend(deck, target, quiet, truth, reached, candidate, error)
            if (reached%done .or. allocated(error)) exit
            if (.not. climbed) call best%keep(candidate, truth, reached)
            if (on .and. .not. climbed) call climb(deck, target, truth, reached, climbed)
         end if
         if (.not. climbed) exit
         reached%cpu = reached%cpu + candidate%outcome%cpu
         reached%climbs = reached%climbs + 1
         reached%reason = ''
      end do
      if (.not. (reached%done .or. allocated(error)) .and. reached%reason == '') call best%give_back(candidate, truth, reached)
   end subroutine search

   !> Keeps a run that misses the target if it misses it by less than those before.
   subroutine keep_best(self, candidate, truth, reached)
      class(best_type), intent(inout) :: self
      type(trial_type), intent(in) :: candidate
      type(truth_type), intent(in) :: truth
      type(reached_type), intent(in) :: reached
      if (.not. truth%known .or. reached%reason /= '' .or. reached%error >= self%error) return
      self%error = reached%error
      self%of_time = reached%of_time
      self%candidate = candidate
      self%truth = truth
      self%advice = reached%advice
   end subroutine keep_best

   !> Gives the best run back where the last one misses the target by more.
   subroutine give_back(self, candidate, truth, reached)
      class(best_type), intent(in) :: self
      type(trial_type), intent(inout) :: candidate
      type(truth_type), intent(inout) :: truth
      type(reached_type), intent(inout) :: reached
      if (self%error >= reached%error) return
      candidate = self%candidate
      truth = self%truth
      reached%advice = self%advice
      reached%error = self%error
      reached%of_time = self%of_time
      reached%path = reached%path//newline//'   the best of these runs is kept: TOLERANCE='// &
         & as_text(reached%advice%tolerance, 2)//', error '//as_text(reached%error, 2)
   end subroutine give_back

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
            if (high%segments > low%segments .or. .not. matters(advice, i, target)) cycle
            if (high%segments < low%segments .or. high%level < low%level .or. high%bending <= low%bending) does_for = .false.
         end associate
      end do
   end function does_for

end module limber_analysis_target
