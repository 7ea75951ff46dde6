!> Events that a run has met: when, which, and the channels there. Floor: scene.
module limber_scene_met_events
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text, newline
   use limber_model_model, only: event_type
   implicit none
   private
   public :: met_events_type, most_rows

   !> Rows at most: a scalar that goes to and fro without an end must not fill the memory
   integer, parameter :: most_rows = 100000
   !> Numbers of a row before the channels: time, index of the event, direction
   integer, parameter :: heads = 3

   !> Rows in the order of time
   type :: met_events_type
      integer :: count = 0
      !> Time, index of the event, direction (1 or -1), channels (3 + channels, at least count)
      real(wp), allocatable, private :: rows(:, :)
   contains
      procedure :: add, join, times, indices, directions, channel, report
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
      self%rows(:heads, self%count) = [t, real(event, wp), real(direction, wp)]
      self%rows(heads + 1:, self%count) = values
   end subroutine add

   !> Adds the rows of a later analysis.
   subroutine join(self, later)
      class(met_events_type), intent(inout) :: self
      type(met_events_type), intent(in) :: later
      integer :: i
      do i = 1, later%count
         call self%add(later%rows(1, i), nint(later%rows(2, i)), nint(later%rows(3, i)), later%rows(heads + 1:, i))
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
      end do
   end function report

   !> Saves or restores it.
   subroutine exchange_events(self, snapshot)
      class(met_events_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%exchange('events', self%count)
      call snapshot%keep('event_rows', self%rows)
   end subroutine exchange_events

end module limber_scene_met_events
