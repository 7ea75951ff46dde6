!> Limits of memory and time of a reduction. Floor: beam.
module limber_beam_reduction_limits
   use limber_base_error, only: error_type, raise
   use limber_base_kinds, only: wp, long
   use limber_base_text, only: as_text
   implicit none
   private
   public :: check_size, check_slopes, check_operations

   !> Most memory of the constants of one body [bytes]
   integer(long), parameter :: max_bytes = 64_long*1024**2
   !> Most operations that modes or the geometric part of one body may take: some seconds
   real(wp), parameter :: max_operations = 4.0e9_wp

contains

   !> Refuses a geometric part that would take too much memory, before it is made.
   subroutine check_size(bending, others, error)
      !> Coordinates that bend, and that carry tension
      integer, intent(in) :: bending, others
      type(error_type), allocatable, intent(out) :: error
      integer(long) :: pairs, bytes
      pairs = int(bending, long)*(bending + 1)/2
      bytes = 8*pairs*others
      if (bytes > max_bytes) call raise(error, 'the geometric part of '//as_text(bending)//' coordinates would take '// &
         & as_text(bytes/1024**2)//' MB of memory, more than '//as_text(max_bytes/1024**2)//'; ask for fewer modes')
   end subroutine check_size

   !> Refuses k_G elements whose slopes would take too much memory or time, before they are made.
   subroutine check_slopes(bending, geometric, fine, remedy, error)
      !> Coordinates that bend, k_G elements, and the finite elements that they are integrated over
      integer, intent(in) :: bending, geometric, fine
      !> Options of which there may be fewer
      character(*), intent(in) :: remedy
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: squares
      squares = real(bending, wp)**2
      call check_operations((4*real(fine, wp) + 3*real(geometric, wp))*squares, &
         & 'the geometric part of '//as_text(bending)//' coordinates', error)
      if (allocated(error)) return
      if (8*squares*geometric > real(max_bytes, wp)) call raise(error, 'the slopes of '//as_text(bending)//' coordinates in '// &
         & as_text(geometric)//' elements of the geometric part would take '//as_text(8*squares*geometric/1024**2, 3)// &
         & ' MB of memory, more than '//as_text(max_bytes/1024**2)//'; ask for fewer '//remedy)
   end subroutine check_slopes

   !> Refuses what would take too long, before it is begun.
   subroutine check_operations(operations, what, error)
      !> Their estimated number, and what they are for
      real(wp), intent(in) :: operations
      character(*), intent(in) :: what
      type(error_type), allocatable, intent(out) :: error
      if (operations > max_operations) call raise(error, what//' would take about '//as_text(operations, 2)// &
         & ' operations, more than '//as_text(max_operations, 2)//'; ask for fewer modes or elements')
   end subroutine check_operations

end module limber_beam_reduction_limits
