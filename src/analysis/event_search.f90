!> Search for events within a step: scalars of the motion that cross zero. Bounds of each scalar along the dense output leave out
!> the parts of a step without a crossing; what is left is halved, up to the first crossing. A scalar is on the other side only
!> beyond a doubt far below the error of the run. Floor: analysis. Source: doc/theory, eq. (5.72).
module limber_analysis_event_search
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_deck_range, only: range_type
   use limber_integrator_integrator, only: integrator_type
   use limber_model_model, only: event_switch, turn_on, toggle
   use limber_multibody_kinematics, only: place_frames, move_frames
   use limber_multibody_motion_laws, only: moment_type, new_moment, read_law, range_between, law_doubt
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: event_search_type, event_crossing_type, start_search, begin_step, find_first, pass_crossing, end_step, choose_events, &
      & contact_doubt

   !> Halvings of a step, and looks at it, at most
   integer, parameter :: deepest = 60, most_looks = 400
   !> Parts of a step: in which crossings count as one instant; below which one without a change of sign is none
   real(wp), parameter :: together = 1.0e-12_wp, none = 1.0e-7_wp
   !> Error of a place by round-off, and of the dense output, relative to what it is computed from; parts of
   !> the tolerance within which a scalar has not crossed zero yet, and within which a gap has not
   real(wp), parameter :: few = 8*epsilon(1.0_wp), noise = 64*epsilon(1.0_wp), doubted = 1.0e-4_wp, &
      & unsure = 1.0e-3_wp

   !> A crossing that was found
   type :: event_crossing_type
      logical :: found = .false.
      !> Index of the event; 1 upwards, -1 downwards
      integer :: event = 0, direction = 0
      !> The first time at which the scalar is on the other side
      real(wp) :: t = 0.0_wp
   end type event_crossing_type

   !> The scalars of all events between steps
   type :: event_search_type
      !> On which side of zero each is, 1 or -1; 0: on none yet (events)
      integer, allocatable :: side(:)
      !> Whether only its sides at the ends of steps are looked at: it could not be resolved before (events)
      logical, allocatable :: coarse(:)
      !> Whether none of its crossings count, for its switch is in the state that it would turn it to (events)
      logical, allocatable :: without(:)
      !> Whether it has crossed in this step, and whether the search goes on behind a crossing (events)
      logical, allocatable, private :: crossed(:)
      logical, private :: behind = .false.
      !> State at the start of the step, and the work put in up to there
      real(wp) :: t = 0.0_wp, w = 0.0_wp
      real(wp), allocatable :: q(:), v(:)
      !> Event whose scalar could not be resolved in the last step: it stays at zero, or crosses it again and again; 0: none
      integer :: unresolved = 0
      !> Event whose scalar came to zero in the last step and went back, and when; 0: none
      integer :: grazing = 0
      real(wp) :: grazed = 0.0_wp
      !> Scalars where the search begins, at the end of the step, and at halves of it
      type(moment_type), private :: from, to, between
      type(moment_type), allocatable, private :: halves(:)
      !> Scratch of a state
      real(wp), allocatable, private :: trial_q(:), trial_v(:)
      integer, private :: looks = 0
      !> Length of the step
      real(wp), private :: h = 0.0_wp
      !> Local error allowed in a step, relative to the scales
      real(wp), private :: tolerance = 0.0_wp
   contains
      procedure :: exchange => exchange_search
   end type event_search_type

contains

   !> Room, and the sides at the start. A scalar that is zero there is on the side to which it goes.
   subroutine start_search(self, system, work, t, q, v, tolerance)
      type(event_search_type), intent(out) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      !> Coordinates and velocities (nq)
      real(wp), intent(in) :: q(:), v(:)
      !> Local error allowed in a step, relative to the scales
      real(wp), intent(in) :: tolerance
      integer :: i, n
      n = size(system%events)
      self%tolerance = tolerance
      allocate (self%side(n), source=0)
      allocate (self%coarse(n), source=.false.)
      allocate (self%without(n), source=.true.)
      allocate (self%crossed(n), source=.false.)
      if (n == 0) return
      allocate (self%halves(deepest))
      call new_moment(n, self%from)
      call new_moment(n, self%to)
      call new_moment(n, self%between)
      do i = 1, deepest
         call new_moment(n, self%halves(i))
      end do
      allocate (self%trial_q(size(q)), self%trial_v(size(v)))
      call begin_step(self, system, work, t, q, v, 0.0_wp)
      call choose_events(self, system)
   end subroutine start_search

   !> Which events count as the switches are, at a state that `begin_step` has taken. One that begins to count has the side there: a
   !> scalar that is zero is on the side to which it goes.
   subroutine choose_events(self, system)
      type(event_search_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      logical :: before
      integer :: i
      do i = 1, size(self%side)
         before = self%without(i)
         self%without(i) = .false.
         associate (event => system%model%events(i))
            if (event%action == event_switch .and. event%to /= toggle) &
               & self%without(i) = system%on(event%switch) .eqv. event%to == turn_on
         end associate
         if (self%without(i) .or. .not. before .or. system%model%events(i)%contact > 0) cycle
         self%side(i) = side_of(self%from%force(i))
         if (abs(self%from%force(i)) <= law_doubt(system%events(i), system%model%length, self%from, i, few)) &
            & self%side(i) = side_of(self%from%slope(i))
      end do
   end subroutine choose_events

   !> Side of a value: 1, -1, or 0 for zero.
   pure integer function side_of(value)
      real(wp), intent(in) :: value
      side_of = 0
      if (value > 0.0_wp) side_of = 1
      if (value < 0.0_wp) side_of = -1
   end function side_of

   !> Takes a state for the start of the next step.
   subroutine begin_step(self, system, work, t, q, v, w)
      type(event_search_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Time; coordinates and velocities (nq), work put in
      real(wp), intent(in) :: t, q(:), v(:), w
      self%t = t
      self%q = q
      self%v = v
      self%w = w
      self%unresolved = 0
      self%grazing = 0
      self%crossed = .false.
      self%behind = .false.
      ! Gaps of contacts are never below zero
      where (system%model%events(:size(self%side))%contact > 0) self%side = 1
      call read_state(system, work, t, self%q, self%v, self%from)
   end subroutine begin_step

   !> The first crossing between where the search is and a time within the last step.
   subroutine find_first(self, system, work, integrator, last, crossing)
      type(event_search_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      class(integrator_type), intent(inout) :: integrator
      !> Not behind the end of the step
      real(wp), intent(in) :: last
      type(event_crossing_type), intent(out) :: crossing
      integer :: i
      self%looks = 0
      self%h = last - self%t
      if (self%behind) then
         ! What else has crossed up to this instant
         do i = 1, size(self%side)
            if (self%without(i) .or. self%crossed(i) .or. self%side(i)*self%from%force(i) >= 0.0_wp) cycle
            crossing = event_crossing_type(.true., i, -self%side(i), self%from%t)
            return
         end do
      end if
      if (.not. last > self%from%t) return
      call look(self, system, work, integrator, last, self%to)
      call search(self, system, work, integrator, self%from, self%to, 1, crossing)
   end subroutine find_first

   !> Goes on behind a crossing.
   subroutine pass_crossing(self, system, work, integrator, crossing)
      type(event_search_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      class(integrator_type), intent(inout) :: integrator
      type(event_crossing_type), intent(in) :: crossing
      self%side(crossing%event) = crossing%direction
      self%crossed(crossing%event) = .true.
      self%behind = .true.
      call look(self, system, work, integrator, crossing%t, self%from)
   end subroutine pass_crossing

   !> Goes on behind a step without another crossing: sides that were not known are.
   subroutine end_step(self)
      type(event_search_type), intent(inout) :: self
      integer :: i
      do i = 1, size(self%side)
         if (self%side(i) == 0) self%side(i) = side_of(self%to%force(i))
      end do
   end subroutine end_step

   !> Whether a scalar is on the other side of zero without a doubt.
   logical function is_beyond(self, system, moment, event)
      type(event_search_type), intent(in) :: self
      type(system_type), intent(in) :: system
      type(moment_type), intent(in) :: moment
      !> Its index
      integer, intent(in) :: event
      is_beyond = self%side(event)*moment%force(event) < 0.0_wp
      if (is_beyond) is_beyond = is_clear(self, system, moment, event)
   end function is_beyond

   !> Whether a scalar is on one side of zero without a doubt.
   logical function is_clear(self, system, moment, event)
      type(event_search_type), intent(in) :: self
      type(system_type), intent(in) :: system
      type(moment_type), intent(in) :: moment
      !> Its index
      integer, intent(in) :: event
      real(wp) :: doubt
      doubt = max(noise, doubted*self%tolerance)
      if (system%model%events(event)%contact > 0) doubt = contact_doubt(self%tolerance)
      is_clear = abs(moment%force(event)) > law_doubt(system%events(event), system%model%length, moment, event, doubt)
   end function is_clear

   !> Part of a place, and of the length of the scene, within which a gap has not been passed yet.
   pure real(wp) function contact_doubt(tolerance)
      !> Local error allowed in a step, relative to the scales
      real(wp), intent(in) :: tolerance
      contact_doubt = max(noise, unsure*tolerance)
   end function contact_doubt

   !> Reads the scalars at a time of the dense output.
   subroutine look(self, system, work, integrator, t, moment)
      type(event_search_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      class(integrator_type), intent(inout) :: integrator
      real(wp), intent(in) :: t
      type(moment_type), intent(inout) :: moment
      real(wp) :: w
      call integrator%interpolate(t, self%trial_q, self%trial_v, w)
      call integrator%complete(system, work, t, self%trial_q, self%trial_v)
      call read_state(system, work, t, self%trial_q, self%trial_v, moment)
      self%looks = self%looks + 1
   end subroutine look

   !> Reads the scalars at a state.
   subroutine read_state(system, work, t, q, v, moment)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      real(wp), contiguous, intent(in) :: q(:), v(:)
      type(moment_type), intent(inout) :: moment
      integer :: i
      call place_frames(system%model, system%layout, t, q, work%kinematics)
      call move_frames(system%model, system%layout, q, v, work%kinematics)
      moment%t = t
      do i = 1, size(system%events)
         call read_law(system%events(i), system%model%length, work%kinematics, moment, i)
      end do
   end subroutine read_state

   !> Halves an interval until no scalar may cross zero in it, or the first crossing is found.
   recursive subroutine search(self, system, work, integrator, a, b, depth, crossing)
      type(event_search_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      class(integrator_type), intent(inout) :: integrator
      type(moment_type), intent(in) :: a, b
      integer, intent(in) :: depth
      type(event_crossing_type), intent(inout) :: crossing
      !> Error of a place within a step, in tolerances of the scene's length: most move by far less than that
      real(wp), parameter :: share = 0.01_wp
      type(range_type) :: range
      real(wp) :: near
      integer :: i, crossed, open
      logical :: beyond(size(self%side))
      crossed = 0
      open = 0
      beyond = .false.
      do i = 1, size(self%side)
         if (self%side(i) == 0 .or. self%without(i)) cycle
         if (is_beyond(self, system, b, i)) then
            crossed = i
            open = open + 1
            beyond(i) = .true.
         else if (.not. self%coarse(i)) then
            range = range_between(system%events(i), i, a, b)
            near = 0.0_wp
            ! A scalar that turns back near zero may cross it within the error of the run
            if (self%side(i)*a%slope(i) < 0.0_wp .and. self%side(i)*b%slope(i) > 0.0_wp) near = law_doubt(system%events(i), &
               & system%model%length, b, i, share*self%tolerance)
            ! A contact touches where it would be passed without a doubt, not where it rests or comes near
            if (system%model%events(i)%contact > 0) near = -contact_doubt(self%tolerance)*law_doubt(system%events(i), &
               & system%model%length, b, i, 1.0_wp)
            if (range%defined .and. (range%low > near .or. range%high < -abs(near))) cycle
            open = open + 1
            if (crossed == 0) crossed = -i
         end if
      end do
      if (open == 0) return
      if (b%t - a%t <= max(together*self%h, 4*spacing(b%t))) then
         if (crossed > 0) call take(crossed, b%t)
         return
      end if
      if (crossed > 0 .and. open == 1) then
         call polish(self, system, work, integrator, a, b, crossed, crossing)
         return
      end if
      if (crossed > 0 .and. open == count(beyond)) then
         if (all_touch()) then
            call polish_all()
            return
         end if
      end if
      if (crossed < 0 .and. b%t - a%t <= none*self%h) then
         ! Right behind a crossing the scalar is still zero; at the end of a step it may be on its way to one
         if (a%t > self%from%t .and. self%grazing == 0 .and. self%side(-crossed)*b%slope(-crossed) >= 0.0_wp) then
            self%grazing = -crossed
            self%grazed = b%t
         end if
         return
      end if
      if (self%looks >= most_looks .or. depth > deepest) then
         self%unresolved = abs(crossed)
         self%coarse(abs(crossed)) = .true.
         if (crossed > 0) call take(crossed, b%t)
         return
      end if
      call look(self, system, work, integrator, a%t + 0.5_wp*(b%t - a%t), self%halves(depth))
      call search(self, system, work, integrator, a, self%halves(depth), depth + 1, crossing)
      if (.not. crossing%found) call search(self, system, work, integrator, self%halves(depth), b, depth + 1, crossing)

   contains

      subroutine take(event, t)
         integer, intent(in) :: event
         real(wp), intent(in) :: t
         crossing = event_crossing_type(.true., event, -self%side(event), t)
      end subroutine take

      !> Whether all that have crossed are gaps that were clearly open before.
      logical function all_touch()
         integer :: event
         all_touch = .false.
         do event = 1, size(beyond)
            if (.not. beyond(event)) cycle
            if (system%model%events(event)%contact == 0 .or. .not. a%force(event) > 0.0_wp) return
            if (.not. is_clear(self, system, a, event)) return
         end do
         all_touch = .true.
      end function all_touch

      !> Of several contacts that touch the first one.
      subroutine polish_all()
         type(event_crossing_type) :: one
         integer :: event
         do event = 1, size(beyond)
            if (.not. beyond(event)) cycle
            call polish(self, system, work, integrator, a, b, event, one)
            if (.not. crossing%found .or. one%t < crossing%t) crossing = one
         end do
      end subroutine polish_all

   end subroutine search

   !> The crossing of one scalar between two moments on different sides, by the method of Illinois and halving.
   subroutine polish(self, system, work, integrator, a, b, event, crossing)
      type(event_search_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      class(integrator_type), intent(inout) :: integrator
      type(moment_type), intent(in) :: a, b
      integer, intent(in) :: event
      type(event_crossing_type), intent(inout) :: crossing
      integer, parameter :: rounds = 100
      real(wp) :: before, behind, f_before, f_behind, t, f
      integer :: round, side, kept
      before = a%t
      behind = b%t
      f_before = a%force(event)
      f_behind = b%force(event)
      side = self%side(event)
      kept = 0
      if (.not. is_clear(self, system, a, event)) call leave_zero()
      do round = 1, rounds
         if (behind - before <= 2*spacing(behind)) exit
         t = before + 0.5_wp*(behind - before)
         ! Halved now and then, and where the start is on the far side by round-off
         if (modulo(round, 4) /= 0 .and. side*f_before > 0.0_wp) t = min(max(before - f_before*(behind - before)/ &
            & (f_behind - f_before), nearest(before, 1.0_wp)), nearest(behind, -1.0_wp))
         call look(self, system, work, integrator, t, self%between)
         f = self%between%force(event)
         if (side*f < 0.0_wp) then
            behind = t
            f_behind = f
            if (kept == 1) f_before = 0.5_wp*f_before
            kept = 1
         else
            before = t
            f_before = f
            if (kept == -1) f_behind = 0.5_wp*f_behind
            kept = -1
            if (abs(f) > 0.0_wp) cycle
            behind = t
            exit
         end if
      end do
      crossing = event_crossing_type(.true., event, -side, behind)

   contains

      !> Right behind a crossing the scalar is zero but for round-off: goes on to where it is on its side.
      subroutine leave_zero()
         do round = 1, rounds
            if (behind - before <= 2*spacing(behind)) exit
            t = before + 0.5_wp*(behind - before)
            call look(self, system, work, integrator, t, self%between)
            f = self%between%force(event)
            if (side*f > 0.0_wp .and. is_clear(self, system, self%between, event)) then
               before = t
               f_before = f
               return
            else if (is_beyond(self, system, self%between, event) .or. side*self%between%slope(event) < 0.0_wp) then
               behind = t
               f_behind = f
            else
               before = t
               f_before = f
            end if
         end do
         ! It is on neither side before the end
         before = a%t
         behind = b%t
         f_before = a%force(event)
         f_behind = b%force(event)
      end subroutine leave_zero

   end subroutine polish

   !> Saves or restores the sides.
   subroutine exchange_search(self, snapshot)
      class(event_search_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      integer :: i
      ! Not saved: t, w, q, v, crossed, behind, unresolved, grazing, grazed, from, to, between, halves, trial_q, trial_v, looks, h
      ! Not saved: tolerance
      call snapshot%exchange('sides', self%side)
      do i = 1, size(self%coarse)
         call snapshot%exchange('coarse', self%coarse(i))
         call snapshot%exchange('without', self%without(i))
      end do
   end subroutine exchange_search

end module limber_analysis_event_search
