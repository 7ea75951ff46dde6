!> Events that a run has met: when, which, and the channels there. Floor: scene.
module limber_scene_met_events
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text, newline
   use limber_model_model, only: event_type, event_switch
   implicit none
   private
   public :: met_events_type, most_rows

   !> Rows at most: a scalar that goes to and fro without an end must not fill the memory
   integer, parameter :: most_rows = 100000
   !> Numbers of a row before the channels: time, index of the event, direction, state of the switch, change of the energy, impulse
   integer, parameter :: heads = 6

   !> Rows in the order of time
   type :: met_events_type
      integer :: count = 0
      !> Time, index of the event, direction (1 or -1), the switch turned on 1, off -1, or none turned 0, and by how much the energy
      !> changes thereby, impulse of a contact, channels (6 + channels, at least count)
      real(wp), allocatable, private :: rows(:, :)
   contains
      procedure :: add, turn, strike, join, times, indices, directions, turns, energies, impulses, channel, report
      procedure :: exchange => exchange_events
   end type met_events_type

contains

   !> Adds a row.
   subroutine add(self, t, event, direction, values)
      class(met_events_type), intent(inout) :: self
      real(wp), intent(in) :: t
      !> Index of the event; 1 upwards, -1 downwards
      integer, intent(in) :: event, direction
      !> All channels
      real(wp), intent(in) :: values(:)
      real(wp), allocatable :: longer(:, :)
      integer, parameter :: least = 16
      if (.not. allocated(self%rows)) allocate (self%rows(heads + size(values), least))
      if (self%count == size(self%rows, 2)) then
         allocate (longer(size(self%rows, 1), 2*self%count), source=0.0_wp)
         longer(:, :self%count) = self%rows
         call move_alloc(longer, self%rows)
      end if
      self%count = self%count + 1
      self%rows(:heads, self%count) = [t, real(event, wp), real(direction, wp), 0.0_wp, 0.0_wp, 0.0_wp]
      self%rows(heads + 1:, self%count) = values
   end subroutine add

   !> Notes in the last row of an event that it has turned a switch.
   subroutine turn(self, event, on, energy)
      class(met_events_type), intent(inout) :: self
      !> Index of the event
      integer, intent(in) :: event
      !> Whether the switch is on now
      logical, intent(in) :: on
      !> By how much the energy of the scene has changed thereby
      real(wp), intent(in) :: energy
      integer :: row
      row = findloc(nint(self%rows(2, :self%count)), event, dim=1, back=.true.)
      ! Rows beyond the most are not noted
      if (row > 0 .and. self%count < most_rows) self%rows(4:5, row) = [merge(1.0_wp, -1.0_wp, on), energy]
   end subroutine turn

   !> Notes in the last row what a contact does there.
   subroutine strike(self, turned, energy, impulse)
      class(met_events_type), intent(inout) :: self
      !> 1 if it closes, -1 if it opens, 0 if it only strikes
      integer, intent(in) :: turned
      !> By how much the energy of the scene changes thereby, and its impulse, positive where it pushes
      real(wp), intent(in) :: energy, impulse
      self%rows(4:6, self%count) = [real(turned, wp), energy, impulse]
   end subroutine strike

   !> Adds the rows of a later analysis.
   subroutine join(self, later)
      class(met_events_type), intent(inout) :: self
      type(met_events_type), intent(in) :: later
      integer :: i
      do i = 1, later%count
         call self%add(later%rows(1, i), nint(later%rows(2, i)), nint(later%rows(3, i)), later%rows(heads + 1:, i))
         self%rows(4:heads, self%count) = later%rows(4:heads, i)
      end do
   end subroutine join

   !> Times of all rows (count).
   pure function times(self)
      class(met_events_type), intent(in) :: self
      real(wp) :: times(self%count)
      times = self%rows(1, :self%count)
   end function times

   !> Indices of their events (count).
   pure function indices(self)
      class(met_events_type), intent(in) :: self
      integer :: indices(self%count)
      indices = nint(self%rows(2, :self%count))
   end function indices

   !> Directions of all rows: 1 upwards, -1 downwards (count).
   pure function directions(self)
      class(met_events_type), intent(in) :: self
      integer :: directions(self%count)
      directions = nint(self%rows(3, :self%count))
   end function directions

   !> What all rows have done to a switch: 1 turned on, -1 turned off, 0 none (count).
   pure function turns(self)
      class(met_events_type), intent(in) :: self
      integer :: turns(self%count)
      turns = nint(self%rows(4, :self%count))
   end function turns

   !> By how much the energy has changed thereby (count).
   pure function energies(self)
      class(met_events_type), intent(in) :: self
      real(wp) :: energies(self%count)
      energies = self%rows(5, :self%count)
   end function energies

   !> Impulses of contacts, positive where they push; zero of all other events (count).
   pure function impulses(self)
      class(met_events_type), intent(in) :: self
      real(wp) :: impulses(self%count)
      impulses = self%rows(6, :self%count)
   end function impulses

   !> A channel in all rows (count).
   pure function channel(self, index)
      class(met_events_type), intent(in) :: self
      integer, intent(in) :: index
      real(wp) :: channel(self%count)
      channel = self%rows(heads + index, :self%count)
   end function channel

   !> Lines for the report: the first of each event, and how many there are.
   function report(self, events, time_unit) result(text)
      class(met_events_type), intent(in) :: self
      type(event_type), intent(in) :: events(:)
      character(*), intent(in) :: time_unit
      character(:), allocatable :: text
      integer, allocatable :: index(:)
      integer :: i, n
      text = ''
      allocate (index(self%count))
      if (self%count > 0) index = self%indices()
      do i = 1, size(events)
         n = count(index == i)
         text = text//newline//"   event '"//events(i)%name//"': "
         if (n == 0) then
            text = text//'not met'
         else
            text = text//'t = '//as_text(self%rows(1, findloc(index, i, dim=1)), 10)//' '//time_unit
            if (n > 1) text = text//', and '//as_text(n - 1)//' more up to t = '// &
               & as_text(self%rows(1, findloc(index, i, dim=1, back=.true.)), 10)//' '//time_unit
         end if
         if (n > 0 .and. events(i)%contact > 0) then
            text = text//told_contact(self, index == i)
         else if (n > 0 .and. events(i)%action == event_switch) then
            text = text//told_turns(self, index == i)
         end if
      end do
   end function report

   !> What a contact has done: impacts, energy lost in them, how often it has opened and rested.
   pure function told_contact(self, mask) result(text)
      type(met_events_type), intent(in) :: self
      !> Its rows (count)
      logical, intent(in) :: mask(:)
      character(:), allocatable :: text
      integer :: impacts
      impacts = count(mask .and. self%impulses() > 0.0_wp)
      text = ', '//as_text(impacts)//' impact'
      if (impacts /= 1) text = text//'s'
      text = text//' that lost '//as_text(-sum(self%energies(), mask=mask), 6)//' of energy'
      if (any(mask .and. self%turns() > 0)) text = text//', at rest '//number_of_times(count(mask .and. self%turns() > 0))
      if (any(mask .and. self%turns() < 0)) text = text//', opened '//number_of_times(count(mask .and. self%turns() < 0))
   end function told_contact

   !> A number of times in words.
   pure function number_of_times(number) result(text)
      integer, intent(in) :: number
      character(:), allocatable :: text
      text = as_text(number)//' times'
      if (number == 1) text = 'once'
   end function number_of_times

   !> What turns of a switch have changed; empty if no switch was turned.
   pure function told_turns(self, mask) result(text)
      type(met_events_type), intent(in) :: self
      !> The rows that are meant (count)
      logical, intent(in) :: mask(:)
      character(:), allocatable :: text
      logical :: turned(size(mask))
      text = ''
      turned = mask .and. self%turns() /= 0
      if (.not. any(turned)) return
      text = ', turned a switch'
      if (count(turned) > 1) text = text//' '//as_text(count(turned))//' times'
      text = text//', the energy changed by '//as_text(sum(self%energies(), mask=turned), 6)
   end function told_turns

   !> Saves or restores it.
   subroutine exchange_events(self, snapshot)
      class(met_events_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%exchange('events', self%count)
      call snapshot%keep('event_rows', self%rows)
   end subroutine exchange_events

end module limber_scene_met_events
