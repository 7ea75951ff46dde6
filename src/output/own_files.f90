!> Files that limber makes beside its results. It replaces and removes its own only. Floor: output.
module limber_output_own_files
   use hdf5, only: hid_t
   use limber_base_error, only: error_type, raise, status_deck
   use limber_base_files, only: kind_of_path, first_bytes, remove_file, path_free, path_file
   use limber_output_hdf5, only: open_file, close_file
   use limber_output_hdf5_error, only: no_id
   use limber_output_hdf5_read, only: read_attribute
   implicit none
   private
   public :: check_own, remove_own

   !> What a file of HDF5 begins with, and what the attribute `format` of limber's begins with
   character(*), parameter :: signature = char(137)//'HDF'//char(13)//char(10)//char(26)//char(10), of_limber = 'limber-'

contains

   !> Refuses a name that a file of somebody else has.
   subroutine check_own(path, format, error)
      character(*), intent(in) :: path
      !> The attribute `format` of a whole file; empty: any of limber's, and what a kill has left of one
      character(*), intent(in) :: format
      type(error_type), allocatable, intent(out) :: error
      if (kind_of_path(path) == path_free) return
      if (.not. is_own(path, format)) call raise(error, path//' is in the way: it is not of limber, which would replace or '// &
         & 'remove it; move it away, or give -o for another name', status_deck)
   end subroutine check_own

   !> Removes a file that limber has made, and no other.
   subroutine remove_own(path, format)
      character(*), intent(in) :: path
      !> As in `check_own`
      character(*), intent(in) :: format
      if (is_own(path, format)) call remove_file(path)
   end subroutine remove_own

   !> Whether a file is limber's. One that was being written when a kill came may not open.
   logical function is_own(path, format)
      character(*), intent(in) :: path, format
      type(error_type), allocatable :: error
      character(:), allocatable :: bytes, found
      integer(hid_t) :: file
      bytes = first_bytes(path, len(signature))
      is_own = .false.
      if (kind_of_path(path) /= path_file) return
      is_own = format == '' .and. (bytes == repeat(char(0), len(bytes)) .or. len(bytes) == 0)
      if (is_own .or. bytes /= signature) return
      file = no_id
      call open_file(path, file, error)
      if (allocated(error)) then
         is_own = format == ''
         return
      end if
      call read_attribute(file, '/', 'format', found, error)
      if (.not. allocated(error)) is_own = found == format .or. format == '' .and. index(found, of_limber) == 1
      call close_file(path, file, error)
   end function is_own

end module limber_output_own_files
