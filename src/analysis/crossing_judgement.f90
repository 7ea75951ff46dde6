!> Judgement of what laws do within a step. What is remembered of the watched laws, and from values and bounds at moments of a step
!> whether a law is plain, smooth, unseen by the step, or met before. Floor: analysis. Source: doc/theory, eqs. (5.46)-(5.51).
module limber_analysis_crossing_judgement
   use limber_base_kinds, only: wp, long
   use limber_base_snapshot, only: snapshot_type
   use limber_analysis_sticking, only: sticking_type
   use limber_deck_range, only: range_type
   use limber_multibody_motion_laws, only: moment_type, law_between, law_noise, law_bend, law_rests, law_excess, &
      & law_is_steep
   use limber_multibody_system, only: system_type
   implicit none
   private
   public :: crossings_type, is_plain, no_matter, largest_of, judge_quarters, is_unseen, is_met, is_none, spoils_output

   !> What has been found in a step: nothing; a bend or a jump of a law; a place where a law comes up that the step has not seen
   integer, parameter, public :: found_nothing = 0, found_bend = 1, found_jump = 2, found_pulse = 3
   !> Depth of the halving
   integer, parameter, public :: deepest = 60
   !> Part of the largest value of a law that is little; part of its own largest value that is a slight change
   real(wp), parameter, public :: little = 1.0e-4_wp, slight = 0.05_wp
   !> Parts of a step behind its start: in which a crossing is one at the start, by round-off; in which one that has been met, found
   !> again, is the error by which constraints were corrected there
   real(wp), parameter, public :: just_met = 1.0e-8_wp, met_again = 1.0e-4_wp

   !> Changes of a law that matter, relative to how it varies in a step; fourth difference that no smooth law has; part of the
   !> largest of all laws below which one is nothing
   real(wp), parameter :: part = 0.02_wp, rough = 0.5_wp, level = 1.0e-6_wp
   !> Change of velocity in a step that is felt, in units of the tolerance
   real(wp), parameter :: left_out = 3.0_wp
   !> Part of the tolerance below which a change of velocity within a step does not matter
   real(wp), parameter :: matters = 0.1_wp

   !> What is remembered of the watched laws, and scratch
   type :: crossings_type
      !> Watched loads; none: nothing is done
      integer, allocatable :: loads(:)
      !> Start of the step and quarters of it; what halving finds
      type(moment_type), allocatable :: quarters(:), halves(:)
      !> Coordinates and velocities at the start of the step (nq), work put in before it; scratch
      real(wp), allocatable :: q(:), v(:), trial_q(:), trial_v(:)
      real(wp) :: w = 0.0_wp
      !> Largest value of each law, and how much it may differ from the quartic through the quarters (laws)
      real(wp), allocatable :: largest(:), allowed(:)
      !> Largest speed of what each law depends on; whether the step leaves out what it falls or rises by at an end of it (laws)
      real(wp), allocatable :: fastest(:)
      logical, allocatable :: steep(:)
      !> Force that changes velocities within the step by what the tolerance allows, eq. (5.50); part of such changes that steps
      !> have left out so far (laws)
      real(wp), allocatable :: felt(:), left(:)
      !> How much each law varies at the quarters (laws)
      real(wp), allocatable :: width(:)
      !> Excess of the bounds in the interval that is halved (laws, depths), and whether a law is smooth at the quarters
      real(wp), allocatable :: excess(:, :)
      logical, allocatable :: smooth(:)
      !> Whether a law is one of the place alone that it acts along, so that it has an energy (laws)
      logical, allocatable :: stored(:)
      !> Whether it changes its formula right behind the start of the step, right before its end, and not between (laws)
      logical, allocatable :: behind(:), ahead(:)
      !> What each law can give to velocities; change of it in this step that does not matter; and whether it makes no other (laws)
      real(wp), allocatable :: effect(:), nothing(:)
      logical, allocatable :: idle(:)
      !> Steps since the last bend of each law; looks in this step; steps to rest, and the next number of these
      integer, allocatable :: steps(:)
      !> Formula of each law behind its last crossing, and the time of that (laws)
      integer(long), allocatable :: entered(:)
      real(wp), allocatable :: crossed(:)
      integer :: looks = 0, rest = 0, next_rest = 1
      !> Whether the integrator starts anew with the next step
      logical :: anew = .true.
      !> The last jumps, and steps in a row that are next to nothing
      type(sticking_type) :: sticking
      !> Of the whole analysis: its length, and what local error is allowed
      real(wp) :: duration = 0.0_wp, tolerance = 0.0_wp
      !> What was found: kind, law, time; whether that is so near to the start of the step that the step must be done again
      integer :: found = found_nothing, which = 0
      logical :: again = .false.
      real(wp) :: t = 0.0_wp
      !> Where a step that is done again must end, and what was found there
      real(wp) :: hold = huge(1.0_wp)
      integer :: held = found_nothing
   contains
      procedure :: exchange => exchange_crossings
   end type crossings_type

contains

   !> Whether no law can do anything within the step that its ends do not show. Leaves the excess of the bounds.
   logical function is_plain(self, system, means) result(plain)
      type(crossings_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Whether the integrator sees laws in the mean of a step only, not at its ends
      logical, intent(in) :: means
      type(range_type) :: range
      real(wp) :: change
      integer :: i
      plain = .true.
      self%felt = huge(change)
      where (self%effect > 0.0_wp) self%felt = left_out*self%tolerance*max(self%fastest, system%model%length/self%duration)/ &
         & ((self%quarters(4)%t - self%quarters(0)%t)*self%effect)
      do i = 1, size(self%loads)
         associate (a => self%quarters(0), b => self%quarters(4))
            range = law_between(system, self%loads, i, a, b)
            change = abs(b%force(i) - a%force(i))
            self%excess(i, 0) = law_excess(range, a%force(i), b%force(i))
            self%allowed(i) = min(little*largest_of(self, i, range), self%felt(i)) + part*change
            self%steep(i) = .not. means .and. law_is_steep(a, b, i, self%felt(i))
            self%idle(i) = self%excess(i, 0) <= self%allowed(i) .and. range%whole .and. a%branches(i) == b%branches(i) .and. &
               & .not. self%steep(i)
            if (means .and. change > little*self%largest(i)) self%idle(i) = .false.
            if (self%idle(i)) cycle
            self%nothing(i) = no_matter(self, system, i)
            self%idle(i) = self%excess(i, 0) <= self%nothing(i) .and. change <= self%nothing(i)
            if (.not. self%idle(i)) plain = .false.
         end associate
      end do
   end function is_plain

   !> Change of a law within the step that does not matter, whatever its own size: that makes no velocity worth the name, or is
   !> due to what its places and rates are not known to, eq. (5.49).
   real(wp) function no_matter(self, system, law) result(change)
      type(crossings_type), intent(in) :: self
      type(system_type), intent(in) :: system
      integer, intent(in) :: law
      real(wp) :: h
      ! Steps that crawl, as where something sticks, count as longer ones
      h = max(self%quarters(4)%t - self%quarters(0)%t, 1.0e-3_wp*self%duration)
      change = min(law_noise(system, self%loads, law, self%quarters(0), self%tolerance, self%duration, h), &
         & law_noise(system, self%loads, law, self%quarters(4), self%tolerance, self%duration, h))
      if (self%effect(law) > 0.0_wp) change = max(change, matters*self%tolerance*system%model%length &
         & /(self%duration*h*self%effect(law)))
   end function no_matter

   !> Largest value of a law, bounds included.
   pure real(wp) function largest_of(self, law, range) result(largest)
      type(crossings_type), intent(in) :: self
      integer, intent(in) :: law
      type(range_type), intent(in) :: range
      largest = max(self%largest(law), level*maxval(self%largest))
      if (range%defined) largest = max(largest, abs(range%low), abs(range%high))
   end function largest_of

   !> How much each law varies at the quarters, and whether a smooth one could do so: one that goes up and down within the step has
   !> no large fourth difference.
   subroutine judge_quarters(self, means, ends_only)
      type(crossings_type), intent(inout) :: self
      !> As above: then one that goes up or down steeply is not seen either
      logical, intent(in) :: means
      !> Whether the step, a first one, knows laws at its ends only
      logical, intent(in) :: ends_only
      !> Part of what a law rises by within a step that its ends must show
      real(wp), parameter :: shown = 0.5_wp
      real(wp) :: f(0:4), width, difference, bulge
      integer :: i, k, first, last
      do i = 1, size(self%loads)
         do k = 0, 4
            f(k) = self%quarters(k)%force(i)
         end do
         first = merge(1, 0, self%behind(i))
         last = merge(3, 4, self%ahead(i))
         if (self%behind(i)) f(0) = self%halves(1)%force(i)
         if (self%ahead(i)) f(4) = self%halves(2)%force(i)
         width = maxval(f) - minval(f)
         self%width(i) = width
         self%allowed(i) = min(little*max(self%largest(i), level*maxval(self%largest)), self%felt(i)) + part*width
         if (self%sticking%crawls > 0 .or. self%idle(i)) self%allowed(i) = huge(width)
         if (.not. self%idle(i)) self%allowed(i) = max(self%allowed(i), self%nothing(i))
         difference = abs(f(0) - 4*f(1) + 6*f(2) - 4*f(3) + f(4))
         bulge = maxval(abs(f(1:3) - f(0) - [1, 2, 3]*(0.25_wp*(f(4) - f(0)))))
         ! The mean of a step is not the mean of a law without an energy, which Boole's rule gives
         if (means) bulge = merge(0.0_wp, abs(f(2) - (7*(f(0) + f(4)) + 32*(f(1) + f(3)) + 12*f(2))/90), self%stored(i))
         self%smooth(i) = all([(self%quarters(k)%branches(i) == self%quarters(first)%branches(i), k=first + 1, last)])
         if (.not. self%smooth(i)) then
            ! The formula changes: that is looked for first, and no pulse before it
            self%allowed(i) = huge(width)
            self%smooth(i) = .true.
         else if (width > self%allowed(i) .and. difference > rough*width) then
            self%smooth(i) = .not. (means .or. self%steep(i)) .and. (all(f(1:) >= f(:3)) .or. all(f(1:) <= f(:3)))
         else if ((ends_only .or. means) .and. bulge > max(self%allowed(i), shown*max(abs(f(0)), abs(f(4))))) then
            ! Of all such steps together no more is left out than one may leave out
            self%left(i) = self%left(i) + bulge/self%felt(i)
            self%smooth(i) = self%left(i) <= 1.0_wp
            if (.not. self%smooth(i)) self%left(i) = self%left(i) - bulge/self%felt(i)
         end if
      end do
   end subroutine judge_quarters

   !> Whether a law does something between the start of the step and a moment in it that the ends of the step do not show. Then the
   !> dense output up to there does not know of it, and the step must be done again to end there.
   logical function is_unseen(self, system, moment) result(unseen)
      type(crossings_type), intent(in) :: self
      type(system_type), intent(in) :: system
      type(moment_type), intent(in) :: moment
      type(range_type) :: range
      real(wp) :: ends(2), most
      integer :: i
      unseen = .false.
      do i = 1, size(self%loads)
         if (self%idle(i)) cycle
         range = law_between(system, self%loads, i, self%quarters(0), moment)
         ends = [self%quarters(0)%force(i), self%quarters(4)%force(i)]
         most = little*largest_of(self, i, range) + part*abs(moment%force(i) - ends(1))
         most = max(most, no_matter(self, system, i))
         unseen = unseen .or. law_excess(range, ends(1), moment%force(i)) > most .or. &
            & max(minval(ends) - moment%force(i), moment%force(i) - maxval(ends)) > most
      end do
   end function is_unseen

   !> Whether a law behind a change of its formula reaches the dense output before it by more than is felt. The stages of a step
   !> behind
   !> the change share in the polynomial of the whole step, and the estimate of its error may be zero by chance.
   pure logical function spoils_output(self, before, law) result(spoils)
      type(crossings_type), intent(in) :: self
      !> The moment right before the change
      type(moment_type), intent(in) :: before
      integer, intent(in) :: law
      !> Weight of the last stage in a step of Radau's formula
      real(wp), parameter :: weight = 1.0_wp/9
      real(wp) :: beyond
      associate (end => self%quarters(4))
         beyond = abs(end%force(law) - before%force(law) - before%slope(law)*(end%t - before%t))
      end associate
      spoils = weight*beyond > self%felt(law)
   end function spoils_output

   !> Whether a change of formula up to a moment is a crossing that has just been met: by round-off the state at the start of the
   !> step is still before it, right behind it in time or as long as nothing moves. Laws with the same argument, as components of a
   !> force, cross at the same time, one after another.
   pure logical function is_met(self, system, moment, law) result(met)
      type(crossings_type), intent(in) :: self
      type(system_type), intent(in) :: system
      type(moment_type), intent(in) :: moment
      integer, intent(in) :: law
      associate (start => self%quarters(0)%t, end => self%quarters(4)%t)
         met = moment%branches(law) == self%entered(law)
         if (met) met = moment%t - self%crossed(law) <= met_again*(end - start) .or. &
            & law_rests(system, self%loads, law, self%quarters(0), moment)
      end associate
   end function is_met

   !> Whether a law does not bend where its formula changes early in a step, and is plain behind: inside max(0, ...) where that is
   !> 0, or v abs(v) at rest. Places that begin to move are known to round-off only, and change such formulas at random.
   logical function is_none(self, system, a, b, law) result(none)
      type(crossings_type), intent(in) :: self
      type(system_type), intent(in) :: system
      type(moment_type), intent(in) :: a, b
      integer, intent(in) :: law
      !> Part of a step that is early, and of the change of the law that its bounds may lie beyond: they do so for a cubic, too
      real(wp), parameter :: early = 0.01_wp, unseen = 0.5_wp
      type(range_type) :: range
      real(wp) :: left
      associate (start => self%quarters(0), end => self%quarters(4))
         none = b%t - start%t <= early*(end%t - start%t)
         if (.not. none) return
         left = no_matter(self, system, law)
         range = law_between(system, self%loads, law, b, end)
         none = law_bend(system, self%loads, law, a, b, start, end)*(end%t - b%t) <= left .and. &
            & law_excess(range, b%force(law), end%force(law)) <= left + unseen*abs(end%force(law) - b%force(law))
      end associate
   end function is_none

   !> Saves or restores what is remembered between steps.
   subroutine exchange_crossings(self, snapshot)
      class(crossings_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      integer :: i
      if (size(self%loads) == 0) return
      call snapshot%keep('crossing_q', self%q)
      call snapshot%keep('crossing_v', self%v)
      call snapshot%exchange('crossing_w', self%w)
      call snapshot%exchange('crossing_hold', self%hold)
      call snapshot%exchange('crossing_held', self%held)
      call snapshot%keep('crossing_largest', self%largest)
      call snapshot%keep('crossing_crossed', self%crossed)
      call snapshot%keep('crossing_fastest', self%fastest)
      call snapshot%keep('crossing_left', self%left)
      do i = 1, size(self%steps)
         call snapshot%exchange('crossing_steps', self%steps(i))
         call snapshot%exchange('crossing_entered', self%entered(i))
      end do
      call snapshot%exchange('crossing_anew', self%anew)
      call snapshot%exchange('crossing_rest', self%rest)
      call snapshot%exchange('crossing_next_rest', self%next_rest)
      call self%sticking%exchange(snapshot)
      ! Not saved: quarters, halves, trial_q, trial_v, allowed, steep, felt, width, excess, smooth, stored, behind, ahead, effect
      ! Not saved: nothing, idle, looks, duration, tolerance, found, which, again, t
   end subroutine exchange_crossings

end module limber_analysis_crossing_judgement
