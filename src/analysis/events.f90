!> Events of a motion: those that count are noted with all channels, and may end it. Floor: analysis. Source: doc/theory, section
!> 5.19.
module limber_analysis_events
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text
   use limber_analysis_event_search, only: event_search_type, event_crossing_type, start_search, begin_step, find_first, &
      & pass_crossing, end_step, choose_events
   use limber_integrator_integrator, only: integrator_type
   use limber_model_model, only: event_sample, event_switch, turn_on, toggle
   use limber_multibody_system, only: system_type, workspace_type
   use limber_output_channel_values, only: recorder_type
   use limber_output_sample_sink, only: memory_type
   use limber_scene_met_events, only: most_rows
   use limber_scene_outcome, only: outcome_type, warn
   use limber_scene_sampling, only: sample_type, record
   use limber_scene_scene, only: scene_type
   implicit none
   private
   public :: events_type, start_events, begin_events, pass_events, turned_states, count_turn, read_channels, add_row

   !> Turns of switches that are remembered
   integer, parameter :: remembered = 32

   !> Events between the steps of a motion
   type :: events_type
      type(event_search_type) :: search
      !> Crossings of each that have counted (events)
      integer, allocatable :: counts(:)
      !> Whether it has been told of that it cannot be resolved, that it grazes zero (2, events); that no more rows are noted
      logical, allocatable, private :: told(:, :)
      logical, private :: full = .false.
      !> Time at which the step that is done again is to end, and the directions of the crossings there, 0: none (events)
      real(wp) :: hold = huge(1.0_wp)
      integer, allocatable, private :: held(:)
      !> Which events turn their switch at the end of the last step (events), and the times of the last turns, the latest first
      logical, allocatable :: turning(:)
      real(wp), private :: turns(remembered) = -huge(1.0_wp)
      !> Takes the channels at an event, and their number
      type(memory_type), private :: memory
      integer, private :: width = 0
   contains
      procedure :: exchange => exchange_events
   end type events_type

contains

   !> Nothing has been met yet.
   subroutine start_events(self, system, work, t, q, v, tolerance)
      type(events_type), intent(out) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Start; coordinates and velocities there (nq)
      real(wp), intent(in) :: t, q(:), v(:)
      !> Local error allowed in a step, relative to the scales
      real(wp), intent(in) :: tolerance
      call start_search(self%search, system, work, t, q, v, tolerance)
      allocate (self%counts(size(system%events)), source=0)
      allocate (self%turning(size(system%events)), source=.false.)
      allocate (self%held(size(system%events)), source=0)
      allocate (self%told(2, size(system%events)), source=.false.)
   end subroutine start_events

   !> Takes a state for the start of the next step.
   subroutine begin_events(self, system, work, t, q, v, w)
      type(events_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Time; coordinates and velocities (nq), work put in
      real(wp), intent(in) :: t, q(:), v(:), w
      call begin_step(self%search, system, work, t, q, v, w)
   end subroutine begin_events

   !> Notes the events within the last step, up to one that ends the motion: there the step is cut. An integrator whose promise
   !> holds at the ends of its steps does the step again, up to there.
   subroutine pass_events(self, scene, integrator, recorder, sample, near, t, action, again, outcome, error)
      type(events_type), intent(inout) :: self
      type(scene_type), intent(inout) :: scene
      class(integrator_type), intent(inout) :: integrator
      type(recorder_type), intent(inout) :: recorder
      !> Its state is scratch
      type(sample_type), intent(inout) :: sample
      !> Times so near that there is no step between them
      real(wp), intent(in) :: near
      !> Time up to which the last step counts; that of the event that ends the motion
      real(wp), intent(inout) :: t
      !> How the motion ends, event_stop or event_end_step, or that a switch is turned, event_switch; 0: it goes on
      integer, intent(out) :: action
      !> Whether the step has to be done again, up to `hold`
      logical, intent(out) :: again
      type(outcome_type), intent(inout) :: outcome
      type(error_type), allocatable, intent(out) :: error
      !> Part of the analysis that is no step: round-off of places is much of its speeds
      real(wp), parameter :: brief = 1.0e-7_wp
      type(event_crossing_type) :: crossing
      real(wp) :: last
      integer :: sides(size(self%counts)), counts(size(self%counts)), rows, does, i
      action = 0
      again = .false.
      self%turning = .false.
      last = t
      sides = self%search%side
      counts = self%counts
      rows = outcome%events%count
      do
         call find_first(self%search, scene%system, scene%work, integrator, last, crossing)
         if (.not. crossing%found .and. t >= self%hold - near .and. any(self%held /= 0)) then
            ! By round-off, or the error of its output, a step may end right before the crossings at which it is held
            i = findloc(self%held /= 0, .true., dim=1)
            crossing = event_crossing_type(.true., i, self%held(i), t)
         end if
         if (.not. crossing%found) exit
         associate (event => scene%system%model%events(crossing%event))
            if (t >= self%hold - near) then
               self%held(crossing%event) = 0
               if (all(self%held == 0)) self%hold = huge(t)
            end if
            if ((event%direction /= 0 .and. event%direction /= crossing%direction) .or. crossing%t < event%after) then
               call pass_crossing(self%search, scene%system, scene%work, integrator, crossing)
               cycle
            end if
            self%counts(crossing%event) = self%counts(crossing%event) + 1
            does = 0
            if (event%action /= event_sample .and. self%counts(crossing%event) == event%number) does = event%action
            if (event%action == event_switch .and. self%counts(crossing%event) > event%number) does = event_switch
            ! Right behind the start of a step its output is exact, and a step that ends there is not
            if (does > 0 .and. integrator%ends_on_samples .and. crossing%t < t - near .and. &
               & crossing%t > self%search%t + brief*(scene%system%model%dynamics%end - scene%system%model%dynamics%start)) then
               again = .true.
               call hold_at(self, scene, integrator, crossing, min(last, crossing%t + near))
               self%search%side = sides
               self%counts = counts
               outcome%events%count = rows
               return
            end if
         end associate
         ! What a contact does there is noted with its impulse
         if (scene%system%model%events(crossing%event)%contact == 0) call note(self, scene, integrator, recorder, sample, &
            & crossing, outcome, error)
         if (allocated(error)) return
         if (does > 0) then
            t = crossing%t
            action = does
            if (does /= event_switch) return
            ! What crosses at this instant turns its switch too
            self%turning(crossing%event) = .true.
            if (count(self%turning) == 1) last = min(last, t + near)
         end if
         call pass_crossing(self%search, scene%system, scene%work, integrator, crossing)
      end do
      if (action == event_switch) return
      call end_step(self%search)
      call tell(self, scene%system, outcome)
   end subroutine pass_events

   !> Notes a crossing at which the step is to end, and what else crosses at that instant. The search is where the step begins.
   subroutine hold_at(self, scene, integrator, crossing, last)
      type(events_type), intent(inout) :: self
      type(scene_type), intent(inout) :: scene
      class(integrator_type), intent(inout) :: integrator
      type(event_crossing_type), intent(in) :: crossing
      !> End of that instant, within the step
      real(wp), intent(in) :: last
      type(event_crossing_type) :: other
      real(wp) :: q(scene%system%layout%nq), v(scene%system%layout%nq)
      self%hold = crossing%t
      self%held = 0
      other = crossing
      do while (other%found)
         self%held(other%event) = other%direction
         call pass_crossing(self%search, scene%system, scene%work, integrator, other)
         call find_first(self%search, scene%system, scene%work, integrator, last, other)
      end do
      q = self%search%q
      v = self%search%v
      call begin_step(self%search, scene%system, scene%work, self%search%t, q, v, self%search%w)
   end subroutine hold_at

   !> States of all switches behind the events that turn some (switches): whether each is on. Those of contacts stay.
   pure function turned_states(self, system) result(on)
      type(events_type), intent(in) :: self
      type(system_type), intent(in) :: system
      logical :: on(size(system%on))
      integer :: i
      on = system%on
      do i = 1, size(self%turning)
         if (.not. self%turning(i)) cycle
         associate (event => system%model%events(i))
            if (event%contact > 0) cycle
            if (event%to == toggle) then
               on(event%switch) = .not. on(event%switch)
            else
               on(event%switch) = event%to == turn_on
            end if
         end associate
      end do
   end function turned_states

   !> Counts turns of switches, at a state that `begin_events` has taken. An error where they come ever faster.
   subroutine count_turn(self, system, t, error)
      type(events_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: t
      type(error_type), allocatable, intent(out) :: error
      !> Part of the analysis within which so many turns are no motion that could be followed
      real(wp), parameter :: at_once = 1.0e-7_wp
      call choose_events(self%search, system)
      if (.not. any(self%turning .and. system%model%events%contact == 0)) return
      self%turns = [t, self%turns(:remembered - 1)]
      associate (dynamics => system%model%dynamics, event => system%model%events(findloc(self%turning .and. &
         & system%model%events%contact == 0, .true., dim=1)))
         if (t - self%turns(remembered) <= at_once*(dynamics%end - dynamics%start)) call raise(error, "switch '"// &
            & system%model%switches(event%switch)%name//"' is turned again and again at t = "//as_text(t, 8)//', last by event '// &
            & "'"//event%name//"': "//as_text(remembered)//' turns within '//as_text(t - self%turns(remembered), 2)//' '// &
            & system%model%units%time//'; let it be turned on and off at different values')
      end associate
   end subroutine count_turn

   !> Notes an event with the channels there.
   subroutine note(self, scene, integrator, recorder, sample, crossing, outcome, error)
      type(events_type), intent(inout) :: self
      type(scene_type), intent(inout) :: scene
      class(integrator_type), intent(inout) :: integrator
      type(recorder_type), intent(inout) :: recorder
      type(sample_type), intent(inout) :: sample
      type(event_crossing_type), intent(in) :: crossing
      type(outcome_type), intent(inout) :: outcome
      type(error_type), allocatable, intent(out) :: error
      logical :: added
      if (self%full) return
      call integrator%interpolate(crossing%t, sample%q, sample%v, sample%w)
      call integrator%complete(scene%system, scene%work, crossing%t, sample%q, sample%v)
      call read_channels(self, scene, integrator, recorder, sample, crossing%t, outcome, error)
      if (.not. allocated(error)) call add_row(self, crossing%t, crossing%event, crossing%direction, outcome, added)
   end subroutine note

   !> Takes the channels at the state of a sample, for rows.
   subroutine read_channels(self, scene, integrator, recorder, sample, t, outcome, error)
      type(events_type), intent(inout) :: self
      type(scene_type), intent(inout) :: scene
      class(integrator_type), intent(in) :: integrator
      type(recorder_type), intent(inout) :: recorder
      type(sample_type), intent(inout) :: sample
      real(wp), intent(in) :: t
      type(outcome_type), intent(inout) :: outcome
      type(error_type), allocatable, intent(out) :: error
      self%width = size(scene%system%model%channels)
      call self%memory%start(self%width, 1, huge(1.0_wp))
      sample%anyhow = .true.
      call record(scene, t, t, integrator, recorder, sample, self%memory, outcome, error)
      sample%anyhow = .false.
      outcome%samples = outcome%samples - 1
   end subroutine read_channels

   !> Adds a row with the channels that were taken last, unless there are too many.
   subroutine add_row(self, t, event, direction, outcome, added)
      type(events_type), intent(inout) :: self
      real(wp), intent(in) :: t
      !> Index of the event; 1 upwards, -1 downwards
      integer, intent(in) :: event, direction
      type(outcome_type), intent(inout) :: outcome
      logical, intent(out) :: added
      added = outcome%events%count < most_rows
      if (added) then
         call outcome%events%add(t, event, direction, self%memory%values(:self%width, 1))
         return
      end if
      if (.not. self%full) call warn(outcome, 'more than '//as_text(most_rows)//' events have been met; from t = '// &
         & as_text(t, 6)//' on they are no longer noted')
      self%full = .true.
   end subroutine add_row

   !> Tells of scalars that the search could not resolve, and of those that touch zero.
   subroutine tell(self, system, outcome)
      type(events_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(outcome_type), intent(inout) :: outcome
      integer :: i
      i = self%search%unresolved
      if (i > 0) then
         if (.not. self%told(1, i)) call warn(outcome, "the scalar of event '"//system%model%events(i)%name// &
            & "' stays at zero, or crosses it ever again, from t = "//as_text(self%search%t, 6)//' on: of its crossings only'// &
            & ' those are met that show at the ends of steps; use a scalar that does not rest at zero')
         self%told(1, i) = .true.
      end if
      i = self%search%grazing
      if (i == 0) return
      if (.not. self%told(2, i)) call warn(outcome, "the scalar of event '"//system%model%events(i)%name// &
         & "' touches zero at t = "//as_text(self%search%grazed, 8)//' and goes back: whether it crosses is below'// &
         & ' the error of the run, and no event is noted there')
      self%told(2, i) = .true.
   end subroutine tell

   !> Saves or restores it.
   subroutine exchange_events(self, snapshot)
      class(events_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      integer :: i, k
      ! Not saved: memory, width, turning
      call self%search%exchange(snapshot)
      call snapshot%exchange('event_counts', self%counts)
      do i = 1, size(self%told, 2)
         do k = 1, 2
            call snapshot%exchange('told', self%told(k, i))
         end do
      end do
      call snapshot%exchange('turns', self%turns)
      call snapshot%exchange('full', self%full)
      call snapshot%exchange('event_hold', self%hold)
      call snapshot%exchange('held_events', self%held)
   end subroutine exchange_events

end module limber_analysis_events
