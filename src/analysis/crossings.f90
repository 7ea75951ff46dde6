!> Changes of formula of motion laws within a step. After a step the watched laws are looked at along its dense output, by bounds
!> that miss nothing between looks; where one has changed, the step is cut. So scalars of the motion that change their sign are met.
!> Floor: analysis. Source: doc/theory, eqs. (5.45)-(5.49), (5.52).
module limber_analysis_crossings
   use limber_base_kinds, only: wp, long
   use limber_base_error, only: error_type
   use limber_analysis_crossing_judgement, only: crossings_type, is_plain, no_matter, largest_of, judge_quarters, is_unseen, &
      & is_met, is_none, spoils_output, found_nothing, found_bend, found_jump, found_pulse, deepest, little, slight, &
      & just_met, met_again
   use limber_analysis_sticking, only: note_step, count_jump, crawl
   use limber_deck_range, only: range_type
   use limber_integrator_integrator, only: integrator_type
   use limber_multibody_kinematics, only: place_frames, move_frames
   use limber_multibody_motion_laws, only: moment_type, new_moment, watched_loads, read_moment, law_between, law_effect, law_turn, &
      & law_excess, law_is_stored, quartic
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: crossings_type, new_crossings, begin_crossings, resume_crossings, go_on, find_crossing, count_crossing
   public :: found_nothing, found_bend, found_jump, found_pulse

   !> Looks at most before the rest of a step is taken as it is, and steps without such looks after that at most
   integer, parameter :: most_looks = 100, most_rest = 64
   !> Parts of a step: in which a crossing is found, and which are halved without one
   real(wp), parameter :: fine = 1.0e-10_wp, coarse = 1.0e-7_wp
   !> Shares of the excess of bounds that shrink as those of a law that only occurs wide
   real(wp), parameter :: quartered = 0.4_wp, halved = 0.6_wp

contains

   !> Room, and which laws are watched.
   subroutine new_crossings(self, system, start, duration, tolerance)
      type(crossings_type), intent(out) :: self
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
      allocate (self%quarters(0:4))
      if (n == 0) return
      allocate (self%halves(deepest))
      do i = 0, 4
         call new_moment(n, self%quarters(i))
      end do
      do i = 1, deepest
         call new_moment(n, self%halves(i))
      end do
      associate (nq => system%layout%nq)
         allocate (self%q(nq), self%v(nq), self%trial_q(nq), self%trial_v(nq))
      end associate
      allocate (self%largest(n), self%fastest(n), self%felt(n), self%left(n), self%allowed(n), self%width(n), source=0.0_wp)
      allocate (self%excess(n, 0:deepest), source=0.0_wp)
      allocate (self%smooth(n), self%behind(n), self%ahead(n), self%steep(n), self%steps(n), self%idle(n), self%nothing(n))
      allocate (self%effect, source=[(law_effect(system, self%loads(i)), i=1, n)])
      allocate (self%stored, source=[(law_is_stored(system, self%loads(i)), i=1, n)])
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
      if (self%rest > 0 .and. all(self%quarters(0)%branches == self%quarters(4)%branches .and. &
         & (self%idle .or. self%excess(:, 0) <= slight*self%largest))) then
         self%rest = self%rest - 1
         return
      end if
      do i = 1, 3
         call look(self, system, work, integrator, self%quarters(0)%t + 0.25_wp*i*h, self%quarters(i))
      end do
      call look_inside(self, system, work, integrator)
      call judge_quarters(self, integrator%ends_on_samples, self%anew .and. .not. integrator%sees_inside)
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

   !> Finds which laws change their formula right behind the start of the step, or right before its end, where it has been cut: by
   !> round-off an end is on the other side of the crossing. Between, such a law has one formula, and may come and go like any
   !> other.
   subroutine look_inside(self, system, work, integrator)
      type(crossings_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      class(integrator_type), intent(inout) :: integrator
      real(wp) :: close
      integer :: k
      associate (start => self%quarters(0), end => self%quarters(4), inner => self%quarters(1:3))
         self%behind = start%branches /= inner(1)%branches
         self%ahead = end%branches /= inner(3)%branches
         do k = 2, 3
            self%behind = self%behind .and. inner(k)%branches == inner(1)%branches
            self%ahead = self%ahead .and. inner(k)%branches == inner(1)%branches
         end do
         close = max(met_again*(end%t - start%t), 64*spacing(end%t))
         if (any(self%behind)) then
            call look(self, system, work, integrator, start%t + close, self%halves(1))
            self%behind = self%behind .and. self%halves(1)%branches == inner(1)%branches
         end if
         if (any(self%ahead)) then
            call look(self, system, work, integrator, end%t - close, self%halves(2))
            self%ahead = self%ahead .and. self%halves(2)%branches == inner(3)%branches
         end if
      end associate
   end subroutine look_inside

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
         if (self%found == found_nothing .or. b%t <= self%quarters(0)%t + max(just_met*h, 64*spacing(b%t))) return
         if (b%t < self%quarters(4)%t - last*h) self%again = is_unseen(self, system, a)
         if (integrator%sees_inside) self%again = self%again .or. spoils_output(self, a, changed)
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

   !> Counts a crossing that has been met. An error if a law jumps to and fro ever faster: what it drives sticks.
   subroutine count_crossing(self, system, error)
      type(crossings_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(error_type), allocatable, intent(out) :: error
      self%steps(self%which) = 0
      if (self%found == found_jump) call count_jump(self%sticking, system, self%loads, self%which, self%t, self%duration, error)
   end subroutine count_crossing

end module limber_analysis_crossings
