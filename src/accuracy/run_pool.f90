!> Runs of a search and their cost. What they have cost, what they may cost together, and the last ones themselves, so that none is
!> made twice. Floor: accuracy. Equations: doc/theory, part 7.
module limber_accuracy_run_pool
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use limber_accuracy_fidelity_levels, only: level_type, same_rungs, names_of
   use limber_accuracy_candidate, only: candidate_type, run_trial, least_patience, least_tolerance
   use limber_deck_content, only: deck_type
   use limber_integrator_bound_steps, only: bound_steps_type
   use limber_output_progress, only: teller_type
   implicit none
   private
   public :: pool_type

   !> A run that is kept: its rungs, tolerance, the integrator that its deck asks for, and whether its scales were found
   type :: entry_type
      type(candidate_type), allocatable :: trial
      type(level_type), allocatable :: rungs(:)
      real(wp) :: tolerance = 0.0_wp
      character(:), allocatable :: integrator
   end type entry_type

   !> Runs that are kept, and numbers of one that is
   integer, parameter :: most_kept = 8, most_numbers = 4000000
   !> Work of a search that is always allowed, some ten seconds, and beyond it in units of its first run, or of the last one that
   !> was to be verified, where that takes about a second at most
   real(wp), parameter :: least_budget = 3.0e6_wp, most_first = 60.0_wp, second = 3.0e5_wp

   !> The runs of a search
   type :: pool_type
      !> Number of runs that were made, their CPU seconds, their counted work, and what that may come to
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
      procedure :: allow, say, kept_tolerance
      procedure :: run => run_in_pool
      procedure :: check => run_check
   end type pool_type

contains

   !> Runs a setting, or takes the run that was made already; arguments as those of `run_trial`.
   subroutine run_in_pool(self, deck, rungs, tolerance, part, limit, wide, quiet, label, trial, error, truth, allowed, most, &
      & fresh, only)
      class(pool_type), intent(inout) :: self
      type(deck_type), intent(in) :: deck
      type(level_type), intent(in) :: rungs(:)
      real(wp), intent(in) :: tolerance, part, limit
      logical, intent(in) :: wide, quiet
      character(*), intent(in) :: label
      type(candidate_type), intent(inout) :: trial
      type(error_type), allocatable, intent(out) :: error
      real(wp), intent(in), optional :: truth(:, :), allowed(:), most
      !> Whether its deck is another one than that of the search, so that none that is kept will do; default: no
      logical, intent(in), optional :: fresh
      character(*), intent(in), optional :: only
      logical :: other
      integer :: i
      if (.not. allocated(self%kept)) allocate (self%kept(most_kept))
      other = .false.
      if (present(fresh)) other = fresh
      do i = 1, most_kept
         if (other) exit
         if (.not. serves(self%kept(i), deck, rungs, tolerance, part, wide)) cycle
         trial = self%kept(i)%trial
         return
      end do
      if (.not. quiet) call self%say(as_text(self%runs)//' runs; '//label//' begins: '//setting_words(rungs, tolerance))
      call run_trial(deck, rungs, tolerance, part, min(limit, max(self%budget - self%work, 0.0_wp)), wide, quiet, label, trial, &
         & error, truth, allowed, most, only, pace_of(self, deck, tolerance/part, part))
      if (allocated(error)) return
      self%runs = self%runs + 1
      self%cpu = self%cpu + trial%outcome%cpu
      self%work = self%work + trial%work
      if (self%runs == 1 .and. trial%reason == '') self%budget = least_budget + most_first*trial%work
      if (trial%reason /= '') self%spent = self%spent .or. self%work >= 0.999_wp*self%budget
      if (trial%reason == '' .and. .not. other) call keep(self, deck, rungs, tolerance, part, wide, trial)
   end subroutine run_in_pool

   !> Lets a search go on where the run that is to be verified has become dearer than the first, but is cheap.
   pure subroutine allow(self, work)
      class(pool_type), intent(inout) :: self
      !> Counted work of that run
      real(wp), intent(in) :: work
      self%budget = max(self%budget, least_budget + most_first*min(work, second))
   end subroutine allow

   !> The tolerance nearest to one that a run which is kept has, of the same models, between two bounds; else that one itself.
   real(wp) function kept_tolerance(self, deck, rungs, tolerance, least, most) result(nearest)
      class(pool_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      type(level_type), intent(in) :: rungs(:)
      real(wp), intent(in) :: tolerance, least, most
      real(wp) :: away
      integer :: i
      nearest = tolerance
      away = huge(away)
      if (.not. allocated(self%kept)) return
      do i = 1, most_kept
         associate (entry => self%kept(i))
            if (.not. allocated(entry%rungs)) cycle
            if (entry%tolerance < least .or. entry%tolerance > most) cycle
            if (.not. serves(entry, deck, rungs, entry%tolerance, 1.0_wp, .false.)) cycle
            if (abs(log(entry%tolerance/tolerance)) >= away) cycle
            away = abs(log(entry%tolerance/tolerance))
            nearest = entry%tolerance
         end associate
      end do
   end function kept_tolerance

   !> A line of what the search is at, once it takes long.
   subroutine say(self, text)
      class(pool_type), intent(inout) :: self
      character(*), intent(in) :: text
      call self%teller%say('search for TARGET', text)
   end subroutine say

   !> A setting for people: 'EXACT 10 + 0, TOLERANCE=1e-4'.
   function setting_words(rungs, tolerance) result(text)
      type(level_type), intent(in) :: rungs(:)
      real(wp), intent(in) :: tolerance
      character(:), allocatable :: text
      text = ''
      if (size(rungs) > 0) text = names_of(rungs)//', '
      text = text//'TOLERANCE='//as_text(tolerance, 2)
   end function setting_words

   !> Runs a check of a run at a smaller tolerance.
   subroutine run_check(self, deck, rungs, tolerance, part, limit, wide, quiet, label, check, error, fresh)
      class(pool_type), intent(inout) :: self
      type(deck_type), intent(in) :: deck
      type(level_type), intent(in) :: rungs(:)
      !> Tolerance of the run that it verifies, and its own in units of that
      real(wp), intent(in) :: tolerance, part
      !> Counted work beyond `least_patience` after which it is given up
      real(wp), intent(in) :: limit
      !> Whether the scales of the channels are found
      logical, intent(in) :: wide, quiet
      character(*), intent(in) :: label
      type(candidate_type), intent(inout) :: check
      type(error_type), allocatable, intent(out) :: error
      !> As in `run_in_pool`
      logical, intent(in), optional :: fresh
      call self%run(deck, rungs, max(least_tolerance, part*tolerance), part, least_patience + limit, wide, quiet, label, check, &
         & error, fresh=fresh)
   end subroutine run_check

   !> Whether a run that is kept is the one that is asked for.
   logical function serves(entry, deck, rungs, tolerance, part, wide)
      type(entry_type), intent(in) :: entry
      type(deck_type), intent(in) :: deck
      type(level_type), intent(in) :: rungs(:)
      real(wp), intent(in) :: tolerance, part
      logical, intent(in) :: wide
      real(wp), parameter :: same = 1.0e-6_wp
      serves = .false.
      if (wide .or. .not. allocated(entry%rungs)) return
      if (abs(tolerance - entry%tolerance) > same*tolerance .or. has_steps(deck, part, entry%trial)) return
      if (entry%integrator /= integrator_of(deck)) return
      serves = same_rungs(rungs, entry%rungs)
   end function serves

   !> Steps of the last run that is kept, of the same deck and tolerance, for the companion that verifies it: the models may differ.
   function pace_of(self, deck, tolerance, part) result(pace)
      class(pool_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      !> Of the run, and that of the companion in units of it
      real(wp), intent(in) :: tolerance, part
      type(bound_steps_type) :: pace
      integer :: i
      if (part >= 1.0_wp) return
      do i = self%next, self%next - most_kept + 1, -1
         associate (entry => self%kept(modulo(i - 1, most_kept) + 1))
            if (.not. allocated(entry%rungs)) cycle
            if (.not. serves(entry, deck, entry%rungs, tolerance, 1.0_wp, .false.)) cycle
            pace = entry%trial%outcome%bound
            pace%factor = part
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

   pure function integrator_of(deck) result(word)
      type(deck_type), intent(in) :: deck
      character(:), allocatable :: word
      word = deck%blocks(deck%find('DYNAMICS'))%word('INTEGRATOR')
   end function integrator_of

   !> Keeps a run, in place of the oldest.
   subroutine keep(self, deck, rungs, tolerance, part, wide, trial)
      type(pool_type), intent(inout) :: self
      type(deck_type), intent(in) :: deck
      type(level_type), intent(in) :: rungs(:)
      real(wp), intent(in) :: tolerance, part
      !> Whether it has the quantities of the channels behind them, which are left out; coordinates, which a deck may ask for, it
      !> has not
      logical, intent(in) :: wide
      type(candidate_type), intent(in) :: trial
      if (has_steps(deck, part, trial) .or. size(trial%samples%values) > most_numbers) return
      if (wide .and. asks_motion(deck)) return
      self%next = modulo(self%next, most_kept) + 1
      associate (entry => self%kept(self%next))
         if (.not. allocated(entry%trial)) allocate (entry%trial)
         entry%trial = trial
         if (wide) entry%trial%samples%values = trial%samples%values(:size(trial%scale), :)
         entry%rungs = rungs
         entry%tolerance = tolerance
         entry%integrator = integrator_of(deck)
      end associate
   end subroutine keep

end module limber_accuracy_run_pool
