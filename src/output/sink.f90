!> Where an analysis puts its samples: a results file, or memory. Floor: output.
module limber_output_sink
   use limber_base_error, only: error_type, raise
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   implicit none
   private
   public :: sink_type, memory_type

   !> What takes samples
   type, abstract :: sink_type
   contains
      procedure(append_interface), deferred :: append
   end type sink_type

   abstract interface
      !> Takes a sample.
      subroutine append_interface(self, t, values, error)
         import :: sink_type, error_type, wp
         class(sink_type), intent(inout) :: self
         !> Time
         real(wp), intent(in) :: t
         !> All channels one after another in the order of definition; behind them the coordinates, if they are sampled
         real(wp), intent(in) :: values(:)
         !> Allocated if no more samples can be taken: the run is to end
         type(error_type), allocatable, intent(out) :: error
      end subroutine append_interface
   end interface

   !> Samples in memory, whose run may be given up after some time
   type, extends(sink_type) :: memory_type
      !> Samples taken
      integer :: samples = 0
      !> Times (samples), and the first `width` numbers (width, samples); longer than that if a run ends early
      real(wp), allocatable :: times(:), values(:, :)
      !> CPU time of a run, and CPU clock at its start [s]
      real(wp) :: limit = huge(1.0_wp)
      real(wp), private :: started = 0.0_wp
   contains
      procedure :: start => start_memory, append => append_memory
   end type memory_type

contains

   !> Empties the memory for a run that begins now.
   subroutine start_memory(self, width, samples, limit)
      class(memory_type), intent(inout) :: self
      !> Numbers of a sample that are kept, and greatest number of samples
      integer, intent(in) :: width, samples
      !> CPU time after which the run is given up at its next sample [s]
      real(wp), intent(in) :: limit
      if (allocated(self%times)) deallocate (self%times, self%values)
      allocate (self%times(samples), self%values(width, samples))
      self%samples = 0
      self%limit = limit
      call cpu_time(self%started)
   end subroutine start_memory

   !> Takes a sample, unless the time is over.
   subroutine append_memory(self, t, values, error)
      class(memory_type), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), intent(in) :: values(:)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: now
      call cpu_time(now)
      if (now - self%started > self%limit) then
         call raise(error, 'given up after '//as_text(self%limit, 3)//' s at t = '//as_text(t, 4))
         return
      end if
      self%samples = self%samples + 1
      self%times(self%samples) = t
      self%values(:, self%samples) = values(:size(self%values, 1))
   end subroutine append_memory

end module limber_output_sink
