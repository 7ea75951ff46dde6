!> Changes of formula of motion laws within a step. After a step the watched laws are looked at along its dense output, by bounds
!> that miss nothing between looks; where one has changed, the step is cut. So scalars of the motion that change their sign are met.
!> Floor: analysis. Source: doc/theory, eqs. (5.45)-(5.49), (5.52).
module limber_analysis_crossings
   use limber_base_kinds, only: wp, long
   use limber_base_error, only: error_type
   use limber_base_snapshot, only: snapshot_type
   use limber_analysis_sticking, only: sticking_type, note_step, count_jump, crawl
   use limber_deck_range, only: range_type
   use limber_integrator_integrator, only: integrator_type
   use limber_multibody_kinematics, only: place_frames, move_frames
   use limber_multibody_motion_laws, only: moment_type, new_moment, watched_loads, read_moment, law_between, law_noise, &
      & law_effect, law_turn, law_bend, law_rests, law_excess, law_is_steep, quartic
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: crossings_type, new_crossings, begin_crossings, resume_crossings, go_on, find_crossing, count_crossing

   !> What has been found in a step: nothing; a bend or a jump of a law; a place where a law comes up that the step has not seen
   integer, parameter, public :: found_nothing = 0, found_bend = 1, found_jump = 2, found_pulse = 3

   !> Looks at most before the rest of a step is taken as it is, and steps without such looks after that at most
   integer, parameter :: most_looks = 100, most_rest = 64
   !> Depth of the halving; parts of a step: in which a crossing is found, and which are halved without one
   integer, parameter :: deepest = 60
   real(wp), parameter :: fine = 1.0e-10_wp, coarse = 1.0e-7_wp
   !> Changes of a law that matter: relative to its largest value, to how it varies in a step; shares of the excess of bounds that
   !> shrink as those of a law that only occurs wide; fourth difference that no smooth law has; part of the largest of all
   !> laws below which one is nothing, and of its own largest value that is a slight change
   real(wp), parameter :: little = 1.0e-4_wp, part = 0.02_wp, quartered = 0.4_wp, halved = 0.6_wp, rough = 0.5_wp, &
      & level = 1.0e-6_wp, slight = 0.05_wp
   !> Part of a step right behind a crossing in which the same crossing, found again, is round-off
   real(wp), parameter :: just_met = 1.0e-8_wp
   !> Change of velocity in a step that is felt, in units of the tolerance
   real(wp), parameter :: left_out = 3.0_wp
   !> Part of the tolerance below which a change of velocity within a step does not matter
   real(wp), parameter :: matters = 0.1_wp

   !> What is remembered of the watched laws, and scratch
   type :: crossings_type
      !> Watched loads; none: nothing is done
      integer, allocatable :: loads(:)
      !> Start of the step and quarters of it; what halving finds
      type(moment_type) :: quarters(0:4), halves(deepest)
      !> Coordinates and velocities at the start of the step (nq), work put in before it; scratch
      real(wp), allocatable :: q(:), v(:), trial_q(:), trial_v(:)
      real(wp) :: w = 0.0_wp
      !> Largest value of each law, and how much it may differ from the quartic through the quarters (laws)
      real(wp), allocatable :: largest(:), allowed(:)
      !> Largest speed of what each law depends on; whether the step leaves out what it falls or rises by at an end of it (laws)
      real(wp), allocatable :: fastest(:)
      logical, allocatable :: steep(:)
      !> Force that changes velocities within the step by what the tolerance allows, eq. (5.50) (laws)
      real(wp), allocatable :: felt(:)
      !> How much each law varies at the quarters (laws)
      real(wp), allocatable :: width(:)
      !> Excess of the bounds in the interval that is halved (laws, depths), and whether a law is smooth at the quarters
      real(wp), allocatable :: excess(:, :)
      logical, allocatable :: smooth(:)
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

   !> Room, and which laws are watched.
   subroutine new_crossings(self, system, start, duration, tolerance)
      type(crossings_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> First time, and length of the whole analysis
      real(wp), intent(in) :: start, duration
      !> Local error allowed in a step, relative to the scales
      real(wp), intent(in) :: tolerance
      integer :: i, n
      self%loads = watched_loads(system)
      n = size(self%loads)
      self%sticking%jumped = start
      self%duration = duration
      self%tolerance = tolerance
      if (n == 0) return
      do i = 0, 4
         call new_moment(n, self%quarters(i))
      end do
      do i = 1, deepest
         call new_moment(n, self%halves(i))
      end do
      associate (nq => system%layout%nq)
         allocate (self%q(nq), self%v(nq), self%trial_q(nq), self%trial_v(nq))
      end associate
      allocate (self%largest(n), self%fastest(n), self%felt(n), self%allowed(n), self%width(n), source=0.0_wp)
      allocate (self%excess(n, 0:deepest), source=0.0_wp)
      allocate (self%smooth(n), self%steep(n), self%steps(n), self%idle(n), self%nothing(n))
      allocate (self%effect, source=[(law_effect(system, self%loads(i)), i=1, n)])
      self%steps = huge(n)
      allocate (self%entered(n), source=-1_long)
      allocate (self%crossed(n), source=start)
      self%smooth = .true.
   end subroutine new_crossings

   !> Takes a state for the start of the next step; kinematics are left there.
   subroutine begin_crossings(self, system, work, t, q, v, w)
      type(crossings_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Time; coordinates and velocities (nq), work put in
      real(wp), intent(in) :: t, q(:), v(:), w
      self%q = q
      self%v = v
      self%w = w
      self%anew = .true.
      call read_state(self, system, work, t, q, v, self%quarters(0))
   end subroutine begin_crossings

   !> Reads the laws at the start of the next step again, behind `exchange`.
   subroutine resume_crossings(self, system, work, t)
      type(crossings_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      call read_state(self, system, work, t, self%q, self%v, self%quarters(0))
   end subroutine resume_crossings

   !> Takes the end of the last step for the start of the next one.
   subroutine go_on(self, q, v, w)
      type(crossings_type), intent(inout) :: self
      !> State there
      real(wp), intent(in) :: q(:), v(:), w
      self%q = q
      self%v = v
      self%w = w
      self%anew = .false.
      self%quarters(0) = self%quarters(4)
   end subroutine go_on

   !> Reads the laws at a state.
   subroutine read_state(self, system, work, t, q, v, moment)
      type(crossings_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      real(wp), contiguous, intent(in) :: q(:), v(:)
      type(moment_type), intent(inout) :: moment
      call place_frames(system%model, system%layout, t, q, work%kinematics)
      call move_frames(system%model, system%layout, q, v, work%kinematics)
      call read_moment(system, self%loads, work%kinematics, moment)
      self%largest = max(self%largest, abs(moment%force))
      self%fastest = max(self%fastest, moment%speed)
   end subroutine read_state

   !> Reads the laws at a time of the dense output.
   subroutine look(self, system, work, integrator, t, moment)
      type(crossings_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      class(integrator_type), intent(inout) :: integrator
      real(wp), intent(in) :: t
      type(moment_type), intent(inout) :: moment
      real(wp) :: w
      call integrator%interpolate(t, self%trial_q, self%trial_v, w)
      call integrator%complete(system, work, t, self%trial_q, self%trial_v)
      call read_state(self, system, work, t, self%trial_q, self%trial_v, moment)
      self%looks = self%looks + 1
   end subroutine look

   !> Looks for the first crossing within the last step, from the state that `begin_crossings` has taken: `found`, `which`, `t`.
   subroutine find_crossing(self, system, work, integrator, error)
      type(crossings_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      class(integrator_type), intent(inout) :: integrator
      !> Something sticks where a law jumps, or steps do not get on
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: h
      integer :: i
      self%found = found_nothing
      self%again = .false.
      self%looks = 0
      self%steps = min(self%steps, huge(self%steps) - 1) + 1
      h = integrator%t - self%quarters(0)%t
      if (.not. h > 0.0_wp) return
      call note_step(self%sticking, system, self%loads, integrator%t, h, self%duration, error)
      if (allocated(error)) return
      call look(self, system, work, integrator, integrator%t, self%quarters(4))
      if (is_plain(self, system, integrator%ends_on_samples)) return
      if (integrator%ends_on_samples .and. .not. integrator%fixed_step > 0.0_wp) call find_turn(self, system, h)
      if (self%found /= found_nothing) return
      if (self%rest > 0 .and. all(self%quarters(0)%branches == self%quarters(4)%branches)) then
         self%rest = self%rest - 1
         return
      end if
      do i = 1, 3
         call look(self, system, work, integrator, self%quarters(0)%t + 0.25_wp*i*h, self%quarters(i))
      end do
      call judge_quarters(self, integrator%ends_on_samples)
      if (any(.not. self%smooth)) then
         call find_rise(self, system, work, integrator)
         return
      end if
      do i = 1, 4
         call search(self, system, work, integrator, self%quarters(i - 1), self%quarters(i), 1)
         if (self%found /= found_nothing) return
      end do
      if (self%looks < most_looks) then
         self%next_rest = 1
      else
         self%rest = self%next_rest
         self%next_rest = min(most_rest, 2*self%next_rest)
      end if
   end subroutine find_crossing

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

   !> Whether a law turns the motion within a step more than the tolerance allows, eq. (5.52). An error estimate that leaves out
   !> what a step does not resolve, as a vibration whose size is all that counts, does not see that a hard contact is not one.
   subroutine find_turn(self, system, h)
      type(crossings_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Length of the step
      real(wp), intent(in) :: h
      real(wp), parameter :: least = 0.1_wp, most = 0.5_wp
      real(wp) :: turn
      integer :: i
      if (h < crawl*self%duration) return
      turn = 0.0_wp
      do i = 1, size(self%loads)
         if (self%idle(i)) cycle
         turn = max(turn, law_turn(system, self%loads, i, self%quarters(0), self%quarters(4), self%effect(i), self%excess(i, 0)))
      end do
      if (turn <= self%tolerance) return
      self%found = found_pulse
      self%again = .true.
      self%t = self%quarters(0)%t + max(least, min(most, sqrt(self%tolerance/turn)))*h
   end subroutine find_turn

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
   subroutine judge_quarters(self, means)
      type(crossings_type), intent(inout) :: self
      !> As above: then one that goes up or down steeply is not seen either
      logical, intent(in) :: means
      real(wp) :: f(0:4), width, difference
      integer :: i, k
      do i = 1, size(self%loads)
         do k = 0, 4
            f(k) = self%quarters(k)%force(i)
         end do
         width = maxval(f) - minval(f)
         self%width(i) = width
         self%allowed(i) = min(little*max(self%largest(i), level*maxval(self%largest)), self%felt(i)) + part*width
         if (self%sticking%crawls > 0 .or. self%idle(i)) self%allowed(i) = huge(width)
         if (.not. self%idle(i)) self%allowed(i) = max(self%allowed(i), self%nothing(i))
         difference = abs(f(0) - 4*f(1) + 6*f(2) - 4*f(3) + f(4))
         self%smooth(i) = all([(self%quarters(k)%branches(i) == self%quarters(0)%branches(i), k=1, 4)])
         if (.not. self%smooth(i)) then
            ! The formula changes: that is looked for first, and no pulse before it
            self%allowed(i) = huge(width)
            self%smooth(i) = .true.
         else if (width > self%allowed(i) .and. difference > rough*width) then
            self%smooth(i) = .not. (means .or. self%steep(i)) .and. (all(f(1:) >= f(:3)) .or. all(f(1:) <= f(:3)))
         end if
      end do
   end subroutine judge_quarters

   !> Where a law that is not smooth at the quarters begins to change.
   subroutine find_rise(self, system, work, integrator)
      type(crossings_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      class(integrator_type), intent(inout) :: integrator
      integer :: i
      do i = 1, 4
         if (any(.not. self%smooth .and. abs(self%quarters(i)%force - self%quarters(0)%force) > self%allowed)) exit
      end do
      i = min(i, 4)
      self%which = findloc(self%smooth, .false., dim=1)
      call find_start(self, system, work, integrator, self%quarters(0), self%quarters(i)%t)
      self%excess(:, 1) = 0.0_wp
      call search_before(self, system, work, integrator, self%quarters(0), 1)
   end subroutine find_rise

   !> The last time between two up to which a law is what it was before, as its bounds tell, to what is felt; there the step is cut,
   !> or done again if that is near its start.
   subroutine find_start(self, system, work, integrator, from, to)
      type(crossings_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      class(integrator_type), intent(inout) :: integrator
      type(moment_type), intent(in) :: from
      real(wp), intent(in) :: to
      integer, parameter :: rounds = 16
      real(wp), parameter :: near = 0.05_wp
      real(wp) :: before, end, seen
      integer :: round
      logical :: same
      ! What is left out of the motion up to there must be nothing, however high the law is behind it
      seen = min(self%allowed(self%which), self%nothing(self%which))
      before = from%force(self%which)
      end = to
      associate (start => self%halves(deepest - 1), middle => self%halves(deepest), law => self%which)
         start = from
         do round = 1, rounds
            call look(self, system, work, integrator, 0.5_wp*(start%t + end), middle)
            same = abs(middle%force(law) - before) <= seen
            if (same) same = law_excess(law_between(system, self%loads, law, start, middle), before, before) <= seen
            if (same) then
               start = middle
            else
               end = middle%t
            end if
         end do
         self%t = start%t
      end associate
      self%found = found_pulse
      associate (start => self%quarters(0)%t, h => integrator%t - self%quarters(0)%t)
         if (self%t > start + near*h) return
         self%again = .true.
         self%t = start + 0.125_wp*h
      end associate
   end subroutine find_start

   !> Looks for what other laws do before the start of a pulse that has been found, for the step is cut at the first of all.
   recursive subroutine search_before(self, system, work, integrator, from, depth)
      type(crossings_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      class(integrator_type), intent(inout) :: integrator
      !> Where nothing has happened yet, and at what depth that was
      type(moment_type), intent(in) :: from
      integer, intent(in) :: depth
      real(wp) :: t
      integer :: law
      if (self%again .or. self%t <= from%t .or. depth >= deepest - 3) return
      t = self%t
      law = self%which
      self%found = found_nothing
      call look(self, system, work, integrator, t, self%halves(depth))
      call search(self, system, work, integrator, from, self%halves(depth), depth + 1)
      if (self%found /= found_nothing) return
      self%found = found_pulse
      self%which = law
      self%t = t
   end subroutine search_before

   !> Halves an interval until laws are plain in it, or a crossing is found; the first one in time.
   recursive subroutine search(self, system, work, integrator, a, b, depth)
      type(crossings_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      class(integrator_type), intent(inout) :: integrator
      type(moment_type), intent(in) :: a, b
      integer, intent(in) :: depth
      !> Part of a step that is not worth a repetition
      real(wp), parameter :: last = 0.01_wp
      type(range_type) :: range
      logical :: stubborn(size(self%loads)), opens
      real(wp) :: h
      integer :: i, changed
      h = self%quarters(4)%t - self%quarters(0)%t
      changed = 0
      opens = .false.
      stubborn = .false.
      do i = 1, size(self%loads)
         if (self%idle(i)) cycle
         if (a%branches(i) /= b%branches(i)) then
            if (.not. is_met(self, system, b, i)) changed = i
            self%excess(i, depth) = huge(h)
            cycle
         end if
         range = law_between(system, self%loads, i, a, b)
         self%excess(i, depth) = law_excess(range, a%force(i), b%force(i))
         stubborn(i) = self%excess(i, depth) > max(self%allowed(i), min(little*largest_of(self, i, range), self%felt(i))) &
            & .and. self%excess(i, depth) > merge(quartered, halved, depth == 1)*self%excess(i, depth - 1)
         opens = opens .or. stubborn(i) .or. .not. range%whole
      end do
      if (changed > 0 .and. b%t - a%t <= max(8*spacing(b%t), fine*h)) then
         call take_crossing(self, system, integrator, a, b, changed)
         ! Right behind the start there is nothing to be done again
         if (self%found /= found_nothing .and. b%t < self%quarters(4)%t - last*h .and. &
            & b%t > self%quarters(0)%t + max(just_met*h, 64*spacing(b%t))) self%again = is_unseen(self, system, a)
         return
      end if
      if (changed == 0 .and. (.not. opens .or. self%looks >= most_looks .or. b%t - a%t <= coarse*h)) return
      if (depth >= deepest) return
      call look(self, system, work, integrator, a%t + 0.5_wp*(b%t - a%t), self%halves(depth))
      do i = 1, size(self%loads)
         if (.not. stubborn(i)) cycle
         if (abs(self%halves(depth)%force(i) - quartic(self%quarters, i, self%halves(depth)%t)) <= self%allowed(i)) cycle
         self%which = i
         call find_start(self, system, work, integrator, a, self%halves(depth)%t)
         call search_before(self, system, work, integrator, a, depth)
         return
      end do
      call search(self, system, work, integrator, a, self%halves(depth), depth + 1)
      if (self%found /= found_nothing) return
      call search(self, system, work, integrator, self%halves(depth), b, depth + 1)
   end subroutine search

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
         if (met) met = moment%t - self%crossed(law) <= just_met*(end - start) .or. &
            & law_rests(system, self%loads, law, self%quarters(0), moment)
      end associate
   end function is_met

   !> Takes a change of formula between two moments that are next to each other. It jumps if the law does.
   subroutine take_crossing(self, system, integrator, a, b, law)
      type(crossings_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      class(integrator_type), intent(in) :: integrator
      type(moment_type), intent(in) :: a, b
      integer, intent(in) :: law
      !> Relative to the largest value
      real(wp), parameter :: jump = 1.0e-6_wp
      self%which = law
      self%entered(law) = b%branches(law)
      self%crossed(law) = b%t
      self%t = b%t
      self%found = found_bend
      if (abs(b%force(law) - a%force(law)) > jump*self%largest(law)) then
         self%found = found_jump
      else if (is_none(self, system, a, b, law)) then
         self%found = found_nothing
      else if (self%anew .and. b%t - self%quarters(0)%t <= just_met*(self%quarters(4)%t - self%quarters(0)%t)) then
         ! A start at the bend: one right behind it would be as near to it
         self%found = found_nothing
      else if (self%steps(law) < integrator%steps_to_start .and. &
         & max(self%width(law), self%excess(law, 0)) <= slight*self%largest(law)) then
         ! Bends that come with every few steps and matter little are left to the error of these
         self%found = found_nothing
         self%looks = most_looks
      end if
   end subroutine take_crossing

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

   !> Counts a crossing that has been met. An error if a law jumps to and fro ever faster: what it drives sticks.
   subroutine count_crossing(self, system, error)
      type(crossings_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(error_type), allocatable, intent(out) :: error
      self%steps(self%which) = 0
      if (self%found == found_jump) call count_jump(self%sticking, system, self%loads, self%which, self%t, self%duration, error)
   end subroutine count_crossing

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
      do i = 1, size(self%steps)
         call snapshot%exchange('crossing_steps', self%steps(i))
         call snapshot%exchange('crossing_entered', self%entered(i))
      end do
      call snapshot%exchange('crossing_anew', self%anew)
      call snapshot%exchange('crossing_rest', self%rest)
      call snapshot%exchange('crossing_next_rest', self%next_rest)
      call self%sticking%exchange(snapshot)
   end subroutine exchange_crossings

end module limber_analysis_crossings
