!> Store of reductions for the runs of a sweep. Floor: beam.
module limber_beam_reduction_cache
   use limber_base_kinds, only: long
   use limber_base_names, only: name_index_type
   use limber_beam_beam_mesh, only: displacement_field_type, field_bytes
   use limber_beam_reduced_body, only: reduced_type, bytes_of
   implicit none
   private
   public :: library_type

   !> Reductions that are kept, and memory that they take [bytes]; beyond that all are forgotten
   integer, parameter :: most = 512
   integer(long), parameter :: most_bytes = 256_long*1024**2

   !> A reduction
   type :: book_type
      type(reduced_type) :: reduced
      type(displacement_field_type) :: field
      !> What was left out of it
      character(:), allocatable :: note
   end type book_type

   !> Reductions by a text that all of a reduction follows from
   type :: library_type
      type(name_index_type), private :: names
      type(book_type), allocatable, private :: books(:)
      integer, private :: count = 0
      integer(long), private :: bytes = 0
   contains
      procedure :: look_up, put
   end type library_type

contains

   !> The reduction of a beam, if it has been made.
   subroutine look_up(self, fingerprint, reduced, field, note, found)
      class(library_type), intent(in) :: self
      character(*), intent(in) :: fingerprint
      !> Set if it is found
      type(reduced_type), intent(inout) :: reduced
      type(displacement_field_type), intent(inout) :: field
      character(:), allocatable, intent(inout) :: note
      logical, intent(out) :: found
      integer :: i
      i = self%names%find(fingerprint)
      found = i > 0
      if (.not. found) return
      reduced = self%books(i)%reduced
      field = self%books(i)%field
      note = self%books(i)%note
   end subroutine look_up

   !> Keeps a reduction that it does not have.
   subroutine put(self, fingerprint, reduced, field, note)
      class(library_type), intent(inout) :: self
      !> All that it follows from, and what was left out of it
      character(*), intent(in) :: fingerprint, note
      type(reduced_type), intent(in) :: reduced
      type(displacement_field_type), intent(in) :: field
      if (.not. allocated(self%books)) allocate (self%books(most))
      if (self%count == most .or. self%bytes > most_bytes) then
         self%count = 0
         self%bytes = 0
         deallocate (self%books)
         allocate (self%books(most))
         call self%names%shorten(0)
      end if
      self%count = self%count + 1
      self%books(self%count)%reduced = reduced
      self%books(self%count)%field = field
      self%books(self%count)%note = note
      self%bytes = self%bytes + bytes_of(reduced) + field_bytes(field)
      call self%names%add(fingerprint, self%count)
   end subroutine put

end module limber_beam_reduction_cache
