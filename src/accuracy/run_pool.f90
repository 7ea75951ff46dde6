!> Runs of a search and their cost. What they have cost, what they may cost together, and the last ones themselves, so that none is
!> made twice. Floor: accuracy. Equations: doc/theory, part 7.
module limber_accuracy_run_pool
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use limber_accuracy_fidelity_levels, only: level_type, same_rungs, names_of
   use limber_accuracy_candidate, only: candidate_type, run_request_type, run_trial
   use limber_accuracy_reference_run, only: reference_run_type, error_against
   use limber_accuracy_search_thresholds, only: least_budget, least_tolerance, most_first, most_ringing, &
      & much_ringing, second
   use limber_deck_content, only: deck_type
   use limber_integrator_bound_steps, only: bound_steps_type
   use limber_output_progress, only: teller_type
   implicit none
   private
   public :: pool_type

   !> A run that is kept, and what was asked for
   type :: entry_type
      type(candidate_type), allocatable :: trial
      type(run_request_type), allocatable :: request
   end type entry_type

   !> Runs that are kept, and numbers of one that is
   integer, parameter :: most_kept = 16, most_numbers = 4000000

   !> The runs of a search
   type :: pool_type
      !> As it was read; whether the progress is not shown
      type(deck_type) :: deck
      logical :: quiet = .true.
      !> Number of runs that were made, their CPU seconds, their counted work, and what that may come to, eq. (7.93)
      integer :: runs = 0
      real(wp) :: cpu = 0.0_wp, work = 0.0_wp, budget = huge(1.0_wp)
      !> Whether a run was given up for that
      logical :: spent = .false.
      !> The last ones, by turns; allocated by the first run
      type(entry_type), allocatable :: kept(:)
      integer :: next = 0
      !> What tells how far the search is
      type(teller_type), private :: teller
   contains
      procedure :: allow, say, kept_tolerance, take_cheapest
      procedure :: run => run_in_pool
   end type pool_type

contains

   !> Runs a setting, or takes the run that was made already.
   subroutine run_in_pool(self, request, trial, error, aside)
      class(pool_type), intent(inout) :: self
      type(run_request_type), intent(in) :: request
      type(candidate_type), intent(inout) :: trial
      !> As in `run_trial`
      type(error_type), allocatable, intent(out) :: error
      !> Another deck than that of the search
      type(deck_type), intent(in), optional :: aside
      type(run_request_type) :: asked
      integer :: i
      if (.not. allocated(self%kept)) allocate (self%kept(most_kept))
      asked = request
      asked%tolerance = max(least_tolerance, request%tolerance)
      do i = 1, most_kept
         if (present(aside)) exit
         if (.not. serves(self, self%kept(i), asked)) cycle
         trial = self%kept(i)%trial
         return
      end do
      if (.not. self%quiet) call self%say(as_text(self%runs)//' runs; '//asked%label//' begins: '//setting_words(asked))
      asked%limit = min(asked%limit, max(self%budget - self%work, 0.0_wp))
      if (present(aside)) then
         call run_trial(aside, asked, self%quiet, trial, error, pace_of(self, asked))
      else
         call run_trial(self%deck, asked, self%quiet, trial, error, pace_of(self, asked))
      end if
      if (allocated(error)) return
      self%runs = self%runs + 1
      self%cpu = self%cpu + trial%outcome%cpu
      self%work = self%work + trial%work
      if (self%runs == 1 .and. trial%reason == '') self%budget = least_budget &
         & + merge(most_ringing, most_first, trial%ringing > much_ringing)*trial%work
      if (trial%reason /= '') self%spent = self%spent .or. self%work >= 0.999_wp*self%budget
      if (trial%reason == '' .and. .not. present(aside)) call keep(self, asked, trial)
   end subroutine run_in_pool

   !> Lets a search go on where the run that is to be verified has become more expensive than the first, but is cheap.
   pure subroutine allow(self, work)
      class(pool_type), intent(inout) :: self
      !> Counted work of that run
      real(wp), intent(in) :: work
      self%budget = max(self%budget, least_budget + most_first*min(work, second))
   end subroutine allow

   !> The tolerance nearest to one that a run which is kept has, of the same models, between two bounds; else that one itself.
   real(wp) function kept_tolerance(self, request, bounds) result(nearest)
      class(pool_type), intent(in) :: self
      type(run_request_type), intent(in) :: request
      real(wp), intent(in) :: bounds(2)
      type(run_request_type) :: other
      real(wp) :: away
      integer :: i
      nearest = request%tolerance
      away = huge(away)
      if (.not. allocated(self%kept)) return
      other = request
      other%part = 1.0_wp
      do i = 1, most_kept
         if (.not. allocated(self%kept(i)%request)) cycle
         other%tolerance = self%kept(i)%request%tolerance
         if (other%tolerance < bounds(1) .or. other%tolerance > bounds(2)) cycle
         if (.not. serves(self, self%kept(i), other)) cycle
         if (abs(log(other%tolerance/request%tolerance)) >= away) cycle
         away = abs(log(other%tolerance/request%tolerance))
         nearest = other%tolerance
      end do
   end function kept_tolerance

   !> The cheapest run that is kept and errs by less than a limit, if it costs less than another one.
   subroutine take_cheapest(self, truth, limit, best, place)
      class(pool_type), intent(in) :: self
      type(reference_run_type), intent(in) :: truth
      !> Relative
      real(wp), intent(in) :: limit
      !> The run that it is to be cheaper than; on return it itself
      type(candidate_type), intent(inout) :: best
      !> Its place among those that are kept; zero: there is none
      integer, intent(out) :: place
      integer :: i
      place = 0
      do i = 1, most_kept
         associate (entry => self%kept(i))
            if (.not. allocated(entry%trial)) cycle
            if (size(entry%request%rungs) /= size(truth%rungs) .or. entry%trial%work >= best%work) cycle
            if (entry%trial%samples%samples /= size(truth%values, 2)) cycle
            if (error_against(truth, entry%trial%samples%values) > limit) cycle
            place = i
            best = entry%trial
         end associate
      end do
   end subroutine take_cheapest

   !> A line of what the search is at, once it takes long.
   subroutine say(self, text)
      class(pool_type), intent(inout) :: self
      character(*), intent(in) :: text
      call self%teller%say('search for TARGET', text)
   end subroutine say

   !> A setting for people: 'EXACT 10 + 0, TOLERANCE=1e-4'.
   function setting_words(request) result(text)
      type(run_request_type), intent(in) :: request
      character(:), allocatable :: text
      text = ''
      if (size(request%rungs) > 0) text = names_of(request%rungs)//', '
      text = text//'TOLERANCE='//as_text(request%tolerance, 2)
   end function setting_words

   !> Whether a run that is kept is the one that is asked for.
   logical function serves(self, entry, request)
      class(pool_type), intent(in) :: self
      type(entry_type), intent(in) :: entry
      type(run_request_type), intent(in) :: request
      real(wp), parameter :: same = 1.0e-6_wp
      serves = .false.
      if (request%wide .or. .not. allocated(entry%trial)) return
      if (abs(request%tolerance - entry%request%tolerance) > same*request%tolerance) return
      if (has_steps(self%deck, request%part, entry%trial)) return
      if (entry%request%integrator /= request%integrator) return
      serves = same_rungs(request%rungs, entry%request%rungs)
   end function serves

   !> Steps of the last run that is kept, of the same integrator and tolerance, for the companion that verifies it: the models may
   !> differ.
   function pace_of(self, request) result(pace)
      class(pool_type), intent(in) :: self
      !> Of the companion
      type(run_request_type), intent(in) :: request
      type(bound_steps_type) :: pace
      type(run_request_type) :: run
      integer :: i
      if (request%part >= 1.0_wp) return
      run = request
      run%tolerance = request%tolerance/request%part
      run%part = 1.0_wp
      run%wide = .false.
      do i = self%next, self%next - most_kept + 1, -1
         associate (entry => self%kept(modulo(i - 1, most_kept) + 1))
            if (.not. allocated(entry%trial)) cycle
            run%rungs = entry%request%rungs
            if (.not. serves(self, entry, run)) cycle
            pace = entry%trial%outcome%bound
            pace%factor = request%part
            return
         end associate
      end do
   end function pace_of

   !> Whether a part of the tolerance shortens steps that the deck gives, or those that something else has bound.
   pure logical function has_steps(deck, part, trial)
      type(deck_type), intent(in) :: deck
      real(wp), intent(in) :: part
      type(candidate_type), intent(in) :: trial
      has_steps = .false.
      if (abs(part - 1.0_wp) < 1.0e-6_wp) return
      associate (block => deck%blocks(deck%find('DYNAMICS')))
         has_steps = block%given('INITIAL STEP') .or. block%given('MAXIMUM STEP') .or. block%given('FIXED STEP')
      end associate
      if (has_steps .or. .not. allocated(trial%outcome)) return
      has_steps = trial%outcome%bound%prevail() .or. trial%outcome%bound%factor < 1.0_wp
   end function has_steps

   !> Whether a deck asks for the motion of all bodies.
   pure logical function asks_motion(deck)
      type(deck_type), intent(in) :: deck
      integer :: i
      asks_motion = .false.
      i = deck%find('OUTPUT')
      do while (i > 0)
         asks_motion = asks_motion .or. deck%blocks(i)%yes('MOTION')
         i = deck%find('OUTPUT', i)
      end do
   end function asks_motion

   !> Keeps a run, in place of the oldest.
   subroutine keep(self, request, trial)
      class(pool_type), intent(inout) :: self
      type(run_request_type), intent(in) :: request
      type(candidate_type), intent(in) :: trial
      if (has_steps(self%deck, request%part, trial) .or. size(trial%samples%values) > most_numbers) return
      ! Of a wide run the quantities behind the channels are left out; coordinates, which a deck may ask for, it has not
      if (request%wide .and. asks_motion(self%deck)) return
      self%next = modulo(self%next, most_kept) + 1
      associate (entry => self%kept(self%next))
         if (.not. allocated(entry%trial)) allocate (entry%trial)
         entry%trial = trial
         if (request%wide) entry%trial%samples%values = trial%samples%values(:size(trial%scale), :)
         entry%request = request
         if (allocated(entry%request%truth)) deallocate (entry%request%truth, entry%request%allowed)
      end associate
   end subroutine keep

end module limber_accuracy_run_pool
