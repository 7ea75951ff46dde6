!> Pause of a run at a time, to go on from there in the same process. An interruption whose checkpoint stays in memory. Floor:
!> scene.
module limber_scene_pause
   use limber_base_error, only: error_type, raise, status_interrupted
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_output_sample_sink, only: sink_type
   use limber_scene_interruption, only: interruption_type
   implicit none
   private
   public :: pause_type

   !> The guard of a run that pauses at the time `until`; no signals, no files
   type, extends(interruption_type) :: pause_type
      !> Whether the run pauses between two analyses
      logical :: is_between = .false.
   contains
      procedure :: asks => asks_for_pause, asks_between => asks_for_pause_between, write => keep_in_memory
      procedure :: interrupt => end_at_pause
   end type pause_type

contains

   !> Whether the run pauses behind this step.
   subroutine asks_for_pause(self, save, stop)
      class(pause_type), intent(inout) :: self
      logical, intent(out) :: save, stop
      save = self%paused
      stop = self%paused
   end subroutine asks_for_pause

   !> The same before the next analysis of a deck.
   subroutine asks_for_pause_between(self, t, save, stop)
      class(pause_type), intent(inout) :: self
      real(wp), intent(in) :: t
      logical, intent(out) :: save, stop
      self%paused = self%pauses(t)
      self%is_between = self%paused
      if (self%paused) self%from = t
      save = self%paused
      stop = self%paused
   end subroutine asks_for_pause_between

   !> Lets go of the room behind the snapshot: it is kept as it is.
   subroutine keep_in_memory(self, history, samples, t, error)
      class(pause_type), intent(inout) :: self
      class(sink_type), intent(inout) :: history
      integer, intent(in) :: samples
      real(wp), intent(in) :: t
      type(error_type), allocatable, intent(out) :: error
      self%snapshot%reals = self%snapshot%reals(:self%snapshot%real_count)
      self%snapshot%integers = self%snapshot%integers(:self%snapshot%integer_count)
   end subroutine keep_in_memory

   !> Ends this piece of the run.
   subroutine end_at_pause(self, t, error, is_earlier)
      class(pause_type), intent(in) :: self
      real(wp), intent(in) :: t
      type(error_type), allocatable, intent(out) :: error
      logical, intent(in), optional :: is_earlier
      call raise(error, 'paused at t = '//as_text(min(t, self%until), 8), status_interrupted)
   end subroutine end_at_pause

end module limber_scene_pause
