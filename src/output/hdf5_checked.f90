!> Datasets with a checksum. Damaged ones are refused. Floor: output. Source: HDF5 1.10 Reference Manual, H5P.
module limber_output_hdf5_checked
   use, intrinsic :: iso_c_binding, only: c_char, c_loc, c_null_char, c_ptr
   use hdf5, only: hid_t, hsize_t, size_t, h5dcreate_f, h5dwrite_f, h5dclose_f, h5pcreate_f, h5pclose_f, h5p_dataset_create_f, &
      & h5pset_chunk_f, h5pset_fletcher32_f, h5screate_simple_f, h5sclose_f, h5tcopy_f, h5tclose_f, h5tset_cset_f, h5tset_size_f, &
      & h5t_c_s1, h5t_cset_utf8_f, h5t_ieee_f64le, h5t_native_double, h5t_native_integer
   use h5lt, only: h5ltset_attribute_string_f
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_output_hdf5, only: clear_the_way
   use limber_output_hdf5_error, only: hdf5_error
   implicit none
   private
   public :: write_checked, write_checked_label

   !> Writes a whole dataset and the groups above it, replacing an older one:
   !> `call write_checked(file, path, value, error)`; value is a text, integer (:) or real (:)
   interface write_checked
      module procedure :: write_checked_text, write_checked_integers, write_checked_reals
   end interface write_checked

contains

   !> Sets an attribute of the root to a text of fixed length, which stands in a structure with a checksum. Texts of variable length
   !> have none, and HDF5 1.10 may look without end for one that is damaged.
   subroutine write_checked_label(file, name, value, error)
      integer(hid_t), intent(in) :: file
      character(*), intent(in) :: name, value
      type(error_type), allocatable, intent(out) :: error
      integer :: status
      call h5ltset_attribute_string_f(file, '/', name, value, status)
      if (status < 0) call hdf5_error(error, file, 'cannot write the attribute '//name)
   end subroutine write_checked_label

   subroutine write_checked_reals(file, path, value, error)
      integer(hid_t), intent(in) :: file
      character(*), intent(in) :: path
      real(wp), intent(in) :: value(:)
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable, target :: copy(:)
      allocate (copy(max(1, size(value))))
      copy(:size(value)) = value
      call write_checked_any(file, path, h5t_ieee_f64le, h5t_native_double, size(value), c_loc(copy), error)
   end subroutine write_checked_reals

   subroutine write_checked_integers(file, path, value, error)
      integer(hid_t), intent(in) :: file
      character(*), intent(in) :: path
      integer, intent(in) :: value(:)
      type(error_type), allocatable, intent(out) :: error
      integer, allocatable, target :: copy(:)
      allocate (copy(max(1, size(value))))
      copy(:size(value)) = value
      call write_checked_any(file, path, h5t_native_integer, h5t_native_integer, size(value), c_loc(copy), error)
   end subroutine write_checked_integers

   subroutine write_checked_text(file, path, value, error)
      integer(hid_t), intent(in) :: file
      character(*), intent(in) :: path, value
      type(error_type), allocatable, intent(out) :: error
      character(kind=c_char, len=:), allocatable, target :: text
      integer(hid_t) :: string
      integer :: status
      text = value//c_null_char
      call h5tcopy_f(h5t_c_s1, string, status)
      call h5tset_size_f(string, len(text, size_t), status)
      call h5tset_cset_f(string, h5t_cset_utf8_f, status)
      call write_checked_any(file, path, string, string, 1, c_loc(text(1:1)), error)
      call h5tclose_f(string, status)
   end subroutine write_checked_text

   subroutine write_checked_any(file, path, stored, given, count, value, error)
      integer(hid_t), intent(in) :: file, stored, given
      character(*), intent(in) :: path
      integer, intent(in) :: count
      type(c_ptr), intent(in) :: value
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: longest_chunk = 131072
      integer(hid_t) :: space, creation, dataset
      integer :: status, ignored
      call clear_the_way(file, path, error)
      if (allocated(error)) return
      call h5screate_simple_f(1, [int(count, hsize_t)], space, ignored)
      call h5pcreate_f(h5p_dataset_create_f, creation, status)
      if (count > 0) then
         call h5pset_chunk_f(creation, 1, [int(min(count, longest_chunk), hsize_t)], status)
         call h5pset_fletcher32_f(creation, status)
      end if
      call h5dcreate_f(file, path, stored, space, dataset, status, creation)
      if (status >= 0) then
         if (count > 0) call h5dwrite_f(dataset, given, value, status)
         if (status < 0) call hdf5_error(error, file, 'cannot write '//path)
         ! A chunk goes to the disk when the dataset is closed: what finds no room there is lost
         call h5dclose_f(dataset, status)
         if (status < 0 .and. .not. allocated(error)) call hdf5_error(error, file, 'cannot write '//path)
      else
         call hdf5_error(error, file, 'cannot create '//path)
      end if
      call h5pclose_f(creation, ignored)
      call h5sclose_f(space, ignored)
   end subroutine write_checked_any

end module limber_output_hdf5_checked
