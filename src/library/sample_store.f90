!> Samples of a run in memory that grows. Those behind a time can be dropped, for a run that goes back. Floor: library.
module limber_library_sample_store
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_output_sample_sink, only: sink_type
   implicit none
   private
   public :: store_type

   !> Samples of all channels
   type, extends(sink_type) :: store_type
      !> Number of samples; the first `count` of times and values are in use
      integer :: count = 0
      !> Times, and channels at them (channels, times)
      real(wp), allocatable :: times(:), channels(:, :)
   contains
      procedure :: start => start_store, append => append_sample, up_to
   end type store_type

contains

   !> Makes room.
   subroutine start_store(self, width, samples)
      class(store_type), intent(inout) :: self
      !> Number of channels, and of the samples that are expected
      integer, intent(in) :: width, samples
      allocate (self%times(samples), self%channels(width, samples))
   end subroutine start_store

   !> Stores a sample.
   subroutine append_sample(self, t, values, error)
      class(store_type), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), intent(in) :: values(:)
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: times(:), channels(:, :)
      associate (room => size(self%times), width => size(self%channels, 1))
         if (self%count == room) then
            allocate (times(2*room + 16), channels(width, 2*room + 16))
            times(:room) = self%times
            channels(:, :room) = self%channels
            call move_alloc(times, self%times)
            call move_alloc(channels, self%channels)
         end if
      end associate
      self%count = self%count + 1
      self%times(self%count) = t
      self%channels(:, self%count) = values(:size(self%channels, 1))
   end subroutine append_sample

   !> Number of the samples up to a time.
   pure integer function up_to(self, t) result(number)
      class(store_type), intent(in) :: self
      real(wp), intent(in) :: t
      do number = self%count, 1, -1
         if (self%times(number) <= t) return
      end do
   end function up_to

end module limber_library_sample_store
