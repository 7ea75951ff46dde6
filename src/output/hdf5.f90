!> HDF5 files, groups, attributes and datasets. Errors are values. Floor: output; `limber_output_history` writes through it. Reading
!> is in `limber_output_hdf5_read`, datasets that grow in `limber_output_hdf5_series`. Source: HDF5 1.10 Reference Manual, Fortran
!> interface with H5LT (lite).
!>
!> Orientation: HDF5 stores C order, so a Fortran array (k, n) is a dataset (n, k) in h5py, h5dump and MATLAB's
!> documentation of the file; limber keeps samples in the last Fortran index and so in dimension 0 of the file.
!> Texts are variable-length UTF-8 strings and numbers in attributes are scalars, which h5py hands over as
!> `str`, `int` and `float`; H5LT would write fixed-length strings (`bytes`) and arrays of one number.
module limber_output_hdf5
   use, intrinsic :: iso_c_binding, only: c_char, c_loc, c_null_char, c_ptr
   use hdf5, only: hid_t, hsize_t, h5fcreate_f, h5fopen_f, h5fclose_f, h5fis_hdf5_f, &
      & h5f_acc_excl_f, h5f_acc_trunc_f, h5f_acc_rdonly_f, h5f_acc_rdwr_f, h5f_close_strong_f, &
      & h5f_libver_v18_f, h5f_libver_latest_f, h5pcreate_f, h5pclose_f, &
      & h5pset_fclose_degree_f, h5pset_libver_bounds_f, h5pset_link_creation_order_f, h5p_crt_order_indexed_f, &
      & h5p_crt_order_tracked_f, h5p_file_access_f, h5p_file_create_f, h5p_group_create_f, h5gcreate_f, h5gclose_f, &
      & h5p_dataset_xfer_f, h5pset_buffer_f, &
      & h5ldelete_f, h5oopen_f, h5oclose_f, h5acreate_f, h5awrite_f, h5aclose_f, h5adelete_f, h5aexists_f, &
      & h5dcreate_f, h5dwrite_f, h5dclose_f, h5screate_f, h5screate_simple_f, h5sclose_f, h5s_scalar_f, &
      & h5tcopy_f, h5tset_cset_f, h5tclose_f, h5t_cset_utf8_f, h5t_string, h5t_native_double, h5t_std_i64le, &
      & h5t_ieee_f64le
   use h5lt, only: h5ltmake_dataset_double_f, h5ltmake_dataset_int_f, h5ltpath_valid_f
   use limber_base_error, only: error_type, raise, status_deck
   use limber_base_files, only: is_locked, remove_file, kind_of_path, path_free, path_folder, path_other
   use limber_base_kinds, only: wp, long
   use limber_output_hdf5_error, only: hdf5_error, no_id, open_library, reason_in_use, stack_reason
   use limber_output_hdf5_inside, only: check_inside
   implicit none
   private
   public :: create_file, check_unused, open_file, reopen_file, close_file, create_group, object_exists, write_attribute, &
      & write_dataset, clear_the_way

   !> Sets an attribute of an object, replacing an older value:
   !> `call write_attribute(file, path, name, value, error)`; value is a text, integer, long, real or real (:)
   interface write_attribute
      module procedure :: write_attribute_text, write_attribute_integer, write_attribute_long
      module procedure :: write_attribute_real, write_attribute_reals
   end interface write_attribute

   !> Writes a whole dataset and the groups above it, replacing an older one:
   !> `call write_dataset(file, path, value, error)`; value is a text, integer (:), real (:) or real (:, :)
   interface write_dataset
      module procedure :: write_dataset_text, write_dataset_integers, write_dataset_reals, write_dataset_table
   end interface write_dataset

contains

   !> Creates a file. Nothing is touched unless it can be created; with `overwrite` an existing file is emptied
   !> at once. The file keeps to the format of HDF5 1.8, which has no mark of "open for writing" that would have
   !> to be cleared after a kill, and which lets the list of a scale's users grow past 64 kB.
   subroutine create_file(path, overwrite, file, error, checked)
      !> Name of the file
      character(*), intent(in) :: path
      !> Whether an existing file may be replaced
      logical, intent(in) :: overwrite
      !> Open file
      integer(hid_t), intent(out) :: file
      !> Allocated if it exists already (without `overwrite`) or cannot be written
      type(error_type), allocatable, intent(out) :: error
      !> Whether all structures have checksums, as those of HDF5 1.10 have: of no use to what is read while it is written
      logical, intent(in), optional :: checked
      integer(hid_t) :: creation, access
      integer :: status, tracked
      logical :: exists
      character(:), allocatable :: reason
      file = no_id
      call open_library(error)
      if (allocated(error)) return
      inquire (file=path, exist=exists)
      if (exists .and. .not. overwrite) then
         call raise(error, path//' exists; give --force to overwrite it or -o for another name', status_deck)
         return
      end if
      if (exists) call check_unused(path, error)
      if (allocated(error)) return
      call h5pcreate_f(h5p_file_create_f, creation, status)
      tracked = ior(h5p_crt_order_tracked_f, h5p_crt_order_indexed_f)
      call h5pset_link_creation_order_f(creation, tracked, status)
      call h5pcreate_f(h5p_file_access_f, access, status)
      call h5pset_libver_bounds_f(access, h5f_libver_v18_f, h5f_libver_v18_f, status)
      if (present(checked)) then
         if (checked) call h5pset_libver_bounds_f(access, h5f_libver_latest_f, h5f_libver_latest_f, status)
      end if
      call h5pset_fclose_degree_f(access, h5f_close_strong_f, status)
      call h5fcreate_f(path, merge(h5f_acc_trunc_f, h5f_acc_excl_f, overwrite), file, status, creation, access)
      if (status < 0) then
         reason = stack_reason()
         file = no_id
         call raise(error, 'cannot create '//path//': '//reason, status_deck)
         if (.not. exists) call remove_file(path)
      end if
      call h5pclose_f(access, status)
      call h5pclose_f(creation, status)
   end subroutine create_file

   !> Refuses a file that another program has open, such as a run that still goes on: HDF5 itself would empty it
   !> before it finds out.
   subroutine check_unused(path, error)
      character(*), intent(in) :: path
      type(error_type), allocatable, intent(out) :: error
      character(16) :: locking
      integer :: status
      call get_environment_variable('HDF5_USE_FILE_LOCKING', locking, status=status)
      if (status == 0 .and. any(locking == [character(16) :: 'FALSE', '0'])) return
      if (is_locked(path)) call raise(error, 'cannot overwrite '//path//': '//reason_in_use, status_deck)
   end subroutine check_unused

   !> Opens a file for reading.
   subroutine open_file(path, file, error)
      !> Name of the file
      character(*), intent(in) :: path
      !> Open file
      integer(hid_t), intent(out) :: file
      !> Allocated if it is missing, no HDF5 file, or damaged
      type(error_type), allocatable, intent(out) :: error
      integer :: status
      logical :: is_hdf5
      file = no_id
      call open_library(error)
      if (allocated(error)) return
      select case (kind_of_path(path))
      case (path_free); call raise(error, path//' does not exist', status_deck)
      case (path_folder, path_other); call raise(error, path//' is not an HDF5 file', status_deck)
      end select
      if (allocated(error)) return
      call h5fis_hdf5_f(path, is_hdf5, status)
      if (status >= 0 .and. .not. is_hdf5) then
         call raise(error, path//' is not an HDF5 file', status_deck)
         return
      end if
      call h5fopen_f(path, h5f_acc_rdonly_f, file, status)
      if (status < 0) then
         file = no_id
         call raise(error, 'cannot open '//path//': '//stack_reason(), status_deck)
         return
      end if
      call check_inside(path, file, error)
      if (.not. allocated(error)) return
      call h5fclose_f(file, status)
      file = no_id
   end subroutine open_file

   !> Opens a file that is there for writing.
   subroutine reopen_file(path, file, error)
      !> Name of the file
      character(*), intent(in) :: path
      !> Open file
      integer(hid_t), intent(out) :: file
      !> Allocated if it is missing, no HDF5 file, damaged, in use, or may not be written
      type(error_type), allocatable, intent(out) :: error
      type(error_type), allocatable :: ignored
      integer(hid_t) :: access
      integer :: status
      call open_file(path, file, error)
      if (allocated(error)) return
      call close_file(path, file, ignored)
      call h5pcreate_f(h5p_file_access_f, access, status)
      call h5pset_libver_bounds_f(access, h5f_libver_v18_f, h5f_libver_v18_f, status)
      call h5pset_fclose_degree_f(access, h5f_close_strong_f, status)
      call h5fopen_f(path, h5f_acc_rdwr_f, file, status, access)
      if (status < 0) then
         file = no_id
         call raise(error, 'cannot open '//path//' for writing: '//stack_reason(), status_deck)
      end if
      call h5pclose_f(access, status)
   end subroutine reopen_file

   !> Closes a file and forgets its identifier; does nothing if it is not open.
   subroutine close_file(path, file, error)
      !> Name of the file, for the error
      character(*), intent(in) :: path
      !> Open file; `no_id` on return
      integer(hid_t), intent(inout) :: file
      !> Allocated if what was still to be written could not be
      type(error_type), allocatable, intent(out) :: error
      integer :: status
      if (file == no_id) return
      call h5fclose_f(file, status)
      ! After a failure the identifier is half closed and must not be asked for its name: HDF5 1.10 would crash
      if (status < 0) call raise(error, path//': cannot close the file: '//stack_reason())
      file = no_id
   end subroutine close_file

   !> Whether an object of this path is in the file.
   logical function object_exists(file, path) result(exists)
      !> Open file
      integer(hid_t), intent(in) :: file
      !> Absolute path
      character(*), intent(in) :: path
      integer :: status
      call h5ltpath_valid_f(file, path, .true., exists, status)
      if (status < 0) exists = .false.
   end function object_exists

   !> Makes a group, and those above it, unless it is there; its members are listed in the order of creation.
   recursive subroutine create_group(file, path, error)
      !> Open file
      integer(hid_t), intent(in) :: file
      !> Absolute path, such as '/bodies/rod'
      character(*), intent(in) :: path
      !> Allocated if it cannot be written
      type(error_type), allocatable, intent(out) :: error
      integer(hid_t) :: group, creation
      integer :: status, last
      if (path == '' .or. path == '/') return
      if (object_exists(file, path)) return
      last = index(path, '/', back=.true.)
      if (last > 1) call create_group(file, path(:last - 1), error)
      if (allocated(error)) return
      call h5pcreate_f(h5p_group_create_f, creation, status)
      call h5pset_link_creation_order_f(creation, ior(h5p_crt_order_tracked_f, h5p_crt_order_indexed_f), status)
      call h5gcreate_f(file, path, group, status, gcpl_id=creation)
      if (status < 0) then
         call hdf5_error(error, file, 'cannot create the group '//path)
      else
         call h5gclose_f(group, status)
      end if
      call h5pclose_f(creation, status)
   end subroutine create_group

   subroutine write_attribute_text(file, path, name, value, error)
      integer(hid_t), intent(in) :: file
      character(*), intent(in) :: path, name, value
      type(error_type), allocatable, intent(out) :: error
      character(kind=c_char, len=len(value) + 1), target :: text
      type(c_ptr), target :: pointer_to_text
      integer(hid_t) :: string
      integer :: status
      text = value//c_null_char
      pointer_to_text = c_loc(text(1:1))
      call make_string_type(string)
      call write_attribute_any(file, path, name, string, string, -1, c_loc(pointer_to_text), error)
      call h5tclose_f(string, status)
   end subroutine write_attribute_text

   subroutine write_attribute_integer(file, path, name, value, error)
      integer(hid_t), intent(in) :: file
      character(*), intent(in) :: path, name
      integer, intent(in) :: value
      type(error_type), allocatable, intent(out) :: error
      call write_attribute_long(file, path, name, int(value, long), error)
   end subroutine write_attribute_integer

   subroutine write_attribute_long(file, path, name, value, error)
      integer(hid_t), intent(in) :: file
      character(*), intent(in) :: path, name
      integer(long), intent(in) :: value
      type(error_type), allocatable, intent(out) :: error
      integer(long), target :: copy
      copy = value
      call write_attribute_any(file, path, name, h5t_std_i64le, h5t_std_i64le, -1, c_loc(copy), error)
   end subroutine write_attribute_long

   subroutine write_attribute_real(file, path, name, value, error)
      integer(hid_t), intent(in) :: file
      character(*), intent(in) :: path, name
      real(wp), intent(in) :: value
      type(error_type), allocatable, intent(out) :: error
      real(wp), target :: copy
      copy = value
      call write_attribute_any(file, path, name, h5t_ieee_f64le, h5t_native_double, -1, c_loc(copy), error)
   end subroutine write_attribute_real

   subroutine write_attribute_reals(file, path, name, value, error)
      integer(hid_t), intent(in) :: file
      character(*), intent(in) :: path, name
      real(wp), intent(in) :: value(:)
      type(error_type), allocatable, intent(out) :: error
      real(wp), target :: copy(max(1, size(value)))
      copy(:size(value)) = value
      call write_attribute_any(file, path, name, h5t_ieee_f64le, h5t_native_double, size(value), c_loc(copy), error)
   end subroutine write_attribute_reals

   !> Writes an attribute of any type; a scalar if `count` is negative.
   subroutine write_attribute_any(file, path, name, stored, given, count, value, error)
      integer(hid_t), intent(in) :: file, stored, given
      character(*), intent(in) :: path, name
      integer, intent(in) :: count
      type(c_ptr), intent(in) :: value
      type(error_type), allocatable, intent(out) :: error
      integer(hid_t) :: object, space, attribute
      integer :: status, ignored
      logical :: exists
      call h5oopen_f(file, path, object, status)
      if (status < 0) then
         call hdf5_error(error, file, 'cannot find '//path)
         return
      end if
      if (count < 0) then
         call h5screate_f(h5s_scalar_f, space, ignored)
      else
         call h5screate_simple_f(1, [int(count, hsize_t)], space, ignored)
      end if
      call h5aexists_f(object, name, exists, status)
      if (status >= 0 .and. exists) call h5adelete_f(object, name, status)
      if (status >= 0) call h5acreate_f(object, name, stored, space, attribute, status)
      if (status >= 0) then
         call h5awrite_f(attribute, given, value, status)
         if (status < 0) call hdf5_error(error, file, 'cannot write the attribute '//name//' of '//path)
         call h5aclose_f(attribute, ignored)
      else
         call hdf5_error(error, file, 'cannot create the attribute '//name//' of '//path)
      end if
      call h5sclose_f(space, ignored)
      call h5oclose_f(object, ignored)
   end subroutine write_attribute_any

   subroutine write_dataset_text(file, path, value, error)
      integer(hid_t), intent(in) :: file
      character(*), intent(in) :: path
      character(*), intent(in) :: value
      type(error_type), allocatable, intent(out) :: error
      character(kind=c_char, len=:), allocatable, target :: text
      type(c_ptr), target :: pointer_to_text
      !> HDF5 fills a buffer of 1 MB with zeros for each text otherwise [bytes]
      integer(hsize_t), parameter :: buffer = 1024
      integer(hid_t) :: space, string, dataset, transfer
      integer :: status, ignored
      call clear_the_way(file, path, error)
      if (allocated(error)) return
      text = value//c_null_char
      pointer_to_text = c_loc(text(1:1))
      call make_string_type(string)
      call h5screate_f(h5s_scalar_f, space, ignored)
      call h5dcreate_f(file, path, string, space, dataset, status)
      if (status >= 0) then
         call h5pcreate_f(h5p_dataset_xfer_f, transfer, ignored)
         call h5pset_buffer_f(transfer, buffer, ignored)
         call h5dwrite_f(dataset, string, c_loc(pointer_to_text), status, xfer_prp=transfer)
         if (status < 0) call hdf5_error(error, file, 'cannot write '//path)
         call h5pclose_f(transfer, ignored)
         call h5dclose_f(dataset, status)
         if (status < 0 .and. .not. allocated(error)) call hdf5_error(error, file, 'cannot write '//path)
      else
         call hdf5_error(error, file, 'cannot create '//path)
      end if
      call h5sclose_f(space, ignored)
      call h5tclose_f(string, ignored)
   end subroutine write_dataset_text

   subroutine write_dataset_integers(file, path, value, error)
      integer(hid_t), intent(in) :: file
      character(*), intent(in) :: path
      integer, intent(in) :: value(:)
      type(error_type), allocatable, intent(out) :: error
      integer :: status
      call clear_the_way(file, path, error)
      if (allocated(error)) return
      call h5ltmake_dataset_int_f(file, path, 1, shape(value, hsize_t), value, status)
      if (status < 0) call hdf5_error(error, file, 'cannot write '//path)
   end subroutine write_dataset_integers

   subroutine write_dataset_reals(file, path, value, error)
      integer(hid_t), intent(in) :: file
      character(*), intent(in) :: path
      real(wp), intent(in) :: value(:)
      type(error_type), allocatable, intent(out) :: error
      integer :: status
      call clear_the_way(file, path, error)
      if (allocated(error)) return
      call h5ltmake_dataset_double_f(file, path, 1, shape(value, hsize_t), value, status)
      if (status < 0) call hdf5_error(error, file, 'cannot write '//path)
   end subroutine write_dataset_reals

   subroutine write_dataset_table(file, path, value, error)
      integer(hid_t), intent(in) :: file
      character(*), intent(in) :: path
      real(wp), intent(in) :: value(:, :)
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: packed(:, :)
      integer :: status
      call clear_the_way(file, path, error)
      if (allocated(error)) return
      allocate (packed, source=value)
      call h5ltmake_dataset_double_f(file, path, 2, shape(packed, hsize_t), packed, status)
      if (status < 0) call hdf5_error(error, file, 'cannot write '//path)
   end subroutine write_dataset_table

   !> Makes the groups above a dataset and removes an older dataset of its name.
   subroutine clear_the_way(file, path, error)
      integer(hid_t), intent(in) :: file
      character(*), intent(in) :: path
      type(error_type), allocatable, intent(out) :: error
      integer :: status
      call create_group(file, path(:index(path, '/', back=.true.) - 1), error)
      if (allocated(error)) return
      if (.not. object_exists(file, path)) return
      call h5ldelete_f(file, path, status)
      if (status < 0) call hdf5_error(error, file, 'cannot replace '//path)
   end subroutine clear_the_way

   !> Type of every text: variable length, UTF-8.
   subroutine make_string_type(string)
      integer(hid_t), intent(out) :: string
      integer :: ignored
      call h5tcopy_f(h5t_string, string, ignored)
      call h5tset_cset_f(string, h5t_cset_utf8_f, ignored)
   end subroutine make_string_type

end module limber_output_hdf5
