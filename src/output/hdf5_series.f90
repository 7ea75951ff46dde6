!> Datasets that grow by rows. Floor: output; used by `limber_output_history`. Source: HDF5 1.10 User's Guide, chunked storage and
!> hyperslabs.
module limber_output_hdf5_series
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_c_binding, only: c_loc, c_ptr
   use hdf5, only: hid_t, hsize_t, h5pcreate_f, h5pclose_f, h5pset_chunk_f, h5pset_fill_value_f, h5pset_fletcher32_f, h5dread_f, &
      & h5p_dataset_create_f, h5dcreate_f, h5dopen_f, h5dwrite_f, h5dclose_f, h5dset_extent_f, h5dget_space_f, &
      & h5screate_simple_f, h5sclose_f, h5sselect_hyperslab_f, h5s_select_set_f, h5s_unlimited_f, &
      & h5t_ieee_f64le, h5t_native_double
   use limber_base_error, only: error_type, status_deck
   use limber_base_kinds, only: wp
   use limber_output_hdf5_error, only: hdf5_error, no_id
   implicit none
   private
   public :: series_type, create_series, reopen_series, append_rows, close_series

   !> A dataset that grows by rows: shape (time) for width 1, else (time, width) as h5py sees it
   type :: series_type
      !> Open dataset
      integer(hid_t) :: id = no_id
      !> Numbers in a row
      integer :: width = 1
      !> Rows written so far
      integer(hsize_t) :: rows = 0
   end type series_type

contains

   !> Creates an empty extendible dataset of reals; rows that a kill leaves unwritten read as NaN, and a checksum of
   !> each chunk keeps damaged ones from being read.
   subroutine create_series(file, path, width, chunk_rows, series, error)
      !> Open file
      integer(hid_t), intent(in) :: file
      !> Absolute path in a group that is there
      character(*), intent(in) :: path
      !> Numbers in a row; 1 makes a dataset of one dimension
      integer, intent(in) :: width
      !> Rows in a chunk
      integer, intent(in) :: chunk_rows
      !> Open dataset
      type(series_type), intent(out) :: series
      !> Allocated if it cannot be written
      type(error_type), allocatable, intent(out) :: error
      integer(hsize_t) :: extent(2), limit(2), chunk(2)
      integer(hid_t) :: space, creation
      integer :: status, ignored, rank
      rank = merge(1, 2, width == 1)
      extent = [int(width, hsize_t), 0_hsize_t]
      limit = [int(width, hsize_t), h5s_unlimited_f]
      chunk = [width, chunk_rows]
      call h5screate_simple_f(rank, extent(3 - rank:), space, ignored, limit(3 - rank:))
      call h5pcreate_f(h5p_dataset_create_f, creation, ignored)
      call h5pset_chunk_f(creation, rank, chunk(3 - rank:), ignored)
      call h5pset_fletcher32_f(creation, ignored)
      call h5pset_fill_value_f(creation, h5t_native_double, ieee_value(0.0_wp, ieee_quiet_nan), ignored)
      call h5dcreate_f(file, path, h5t_ieee_f64le, space, series%id, status, dcpl_id=creation)
      if (status < 0) then
         call hdf5_error(error, file, 'cannot create '//path)
         series%id = no_id
      end if
      series%width = width
      call h5pclose_f(creation, ignored)
      call h5sclose_f(space, ignored)
   end subroutine create_series

   !> Opens a series that is there, reads it once for its checksums, and cuts it off behind some rows.
   subroutine reopen_series(file, path, width, rows, series, error)
      !> Open file
      integer(hid_t), intent(in) :: file
      character(*), intent(in) :: path
      !> Numbers in a row, and rows that are left; it has as many
      integer, intent(in) :: width, rows
      !> Open dataset
      type(series_type), intent(out) :: series
      !> Allocated if it cannot be opened or cut off
      type(error_type), allocatable, intent(out) :: error
      integer(hsize_t) :: extent(2)
      integer :: status
      call h5dopen_f(file, path, series%id, status)
      if (status < 0) then
         call hdf5_error(error, file, 'cannot open '//path)
         series%id = no_id
         return
      end if
      series%width = width
      call check_rows(series, path, rows, error)
      if (allocated(error)) return
      extent = [width, rows]
      call h5dset_extent_f(series%id, extent(merge(2, 1, width == 1):), status)
      if (status < 0) call hdf5_error(error, file, 'cannot cut off '//path)
      series%rows = rows
   end subroutine reopen_series

   !> Reads the rows that are to be left.
   subroutine check_rows(series, path, rows, error)
      type(series_type), intent(in) :: series
      !> For the error
      character(*), intent(in) :: path
      integer, intent(in) :: rows
      !> Allocated if they are damaged
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: at_once = 256
      real(wp), allocatable, target :: values(:)
      integer(hsize_t) :: offset(2), extent(2)
      integer(hid_t) :: memory_space, file_space
      type(c_ptr) :: place
      integer :: status, ignored, skip, first
      allocate (values(series%width*at_once))
      skip = merge(1, 0, series%width == 1)
      do first = 0, rows - 1, at_once
         extent = [series%width, min(at_once, rows - first)]
         offset = [0, first]
         call h5screate_simple_f(2 - skip, extent(1 + skip:), memory_space, ignored)
         call h5dget_space_f(series%id, file_space, ignored)
         call h5sselect_hyperslab_f(file_space, h5s_select_set_f, offset(1 + skip:), extent(1 + skip:), ignored)
         place = c_loc(values)
         call h5dread_f(series%id, h5t_native_double, place, status, memory_space, file_space)
         if (status < 0) call hdf5_error(error, series%id, 'the samples of '//path//' are damaged', status_deck)
         call h5sclose_f(file_space, ignored)
         call h5sclose_f(memory_space, ignored)
         if (allocated(error)) return
      end do
   end subroutine check_rows

   !> Appends rows to a series.
   subroutine append_rows(series, rows, values, error)
      !> Series to extend
      type(series_type), intent(inout) :: series
      !> Number of samples
      integer, intent(in) :: rows
      !> The samples one after another (width*rows)
      real(wp), intent(in), target :: values(series%width*rows)
      !> Allocated if they cannot be written; the series is then damaged
      type(error_type), allocatable, intent(out) :: error
      integer(hsize_t) :: offset(2), extent(2)
      integer(hid_t) :: memory_space, file_space
      integer :: status, ignored, skip
      if (rows == 0) return
      skip = merge(1, 0, series%width == 1)
      extent = [int(series%width, hsize_t), series%rows + rows]
      call h5dset_extent_f(series%id, extent(1 + skip:), status)
      if (status < 0) then
         call hdf5_error(error, series%id, 'cannot extend a series')
         return
      end if
      extent(2) = rows
      offset = [0_hsize_t, series%rows]
      call h5screate_simple_f(2 - skip, extent(1 + skip:), memory_space, ignored)
      call h5dget_space_f(series%id, file_space, ignored)
      call h5sselect_hyperslab_f(file_space, h5s_select_set_f, offset(1 + skip:), extent(1 + skip:), ignored)
      call h5dwrite_f(series%id, h5t_native_double, c_loc(values), status, memory_space, file_space)
      if (status < 0) call hdf5_error(error, series%id, 'cannot write samples')
      series%rows = series%rows + rows
      call h5sclose_f(file_space, ignored)
      call h5sclose_f(memory_space, ignored)
   end subroutine append_rows

   !> Closes the dataset of a series; does nothing if it is not open.
   subroutine close_series(series)
      !> Series; not open on return
      type(series_type), intent(inout) :: series
      integer :: ignored
      if (series%id /= no_id) call h5dclose_f(series%id, ignored)
      series%id = no_id
   end subroutine close_series

end module limber_output_hdf5_series
