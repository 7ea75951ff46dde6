!> Reader of HDF5 files. Floor: output. Source: HDF5 1.10 Reference Manual, Fortran interface with H5LT (lite).
module limber_output_hdf5_read
   use, intrinsic :: iso_c_binding, only: c_associated, c_loc, c_null_ptr, c_ptr
   use hdf5, only: hid_t, hsize_t, size_t, h5oopen_f, h5oclose_f, h5aopen_f, h5aread_f, h5aclose_f, h5aexists_f, &
      & h5aget_space_f, h5aget_type_f, h5dopen_f, h5dread_f, h5dclose_f, h5dget_space_f, h5dget_type_f, &
      & h5dvlen_reclaim_f, h5gopen_f, h5gclose_f, h5gget_info_f, h5lget_name_by_idx_f, h5_index_crt_order_f, &
      & h5_index_name_f, h5_iter_inc_f, h5p_default_f, h5sclose_f, &
      & h5sget_simple_extent_npoints_f, h5sget_simple_extent_dims_f, h5sget_simple_extent_ndims_f, &
      & h5t_native_integer, h5t_native_double, h5tclose_f, h5tget_class_f, h5tget_size_f, h5tis_variable_str_f, &
      & h5t_string_f
   use h5lt, only: h5ltread_dataset_double_f
   use limber_base_error, only: error_type, raise, status_deck, status_run
   use limber_base_kinds, only: wp
   use limber_output_hdf5_error, only: hdf5_error, text_of
   implicit none
   private
   public :: read_attribute, read_dataset, dataset_shape, list_members, longest_name

   !> Longest name of a member that is listed whole
   integer, parameter :: longest_name = 255

   !> How a text is stored
   integer, parameter :: no_text = 0, fixed_text = 1, variable_text = 2

   !> Reads an attribute, `call read_attribute(file, path, name, value, error)`; value is a text (allocatable) or an
   !> integer (of one element in the file). Its absence is an error.
   interface read_attribute
      module procedure :: read_attribute_text, read_attribute_integer, read_attribute_real
   end interface read_attribute

   !> Reads a whole dataset into an allocatable, `call read_dataset(file, path, value, error)`; value is a text,
   !> real (:) or real (:, :), the latter in Fortran order: (width, samples)
   interface read_dataset
      module procedure :: read_dataset_text, read_dataset_reals, read_dataset_table
   end interface read_dataset

contains

   !> Names of a group's members in the order of their creation; by name if the group keeps no order.
   subroutine list_members(file, path, names, error)
      !> Open file
      integer(hid_t), intent(in) :: file
      !> Absolute path of the group
      character(*), intent(in) :: path
      !> Blank-padded names
      character(longest_name), allocatable, intent(out) :: names(:)
      !> Allocated if there is no such group
      type(error_type), allocatable, intent(out) :: error
      integer(hid_t) :: group
      integer(hsize_t) :: i
      integer(size_t) :: length
      integer :: status, storage, count, order
      call h5gopen_f(file, path, group, status)
      if (status < 0) then
         call hdf5_error(error, file, 'cannot open the group '//path, status_deck)
         return
      end if
      call h5gget_info_f(group, storage, count, order, status)
      allocate (names(count))
      order = h5_index_crt_order_f
      do i = 1, count
         call h5lget_name_by_idx_f(group, '.', order, h5_iter_inc_f, i - 1, names(i), status, length)
         if (status < 0) then
            order = h5_index_name_f
            call h5lget_name_by_idx_f(group, '.', order, h5_iter_inc_f, i - 1, names(i), status, length)
         end if
      end do
      call h5gclose_f(group, status)
   end subroutine list_members

   !> Shape of a dataset in Fortran order; empty for a scalar.
   subroutine dataset_shape(file, path, extent, error)
      !> Open file
      integer(hid_t), intent(in) :: file
      !> Absolute path of the dataset
      character(*), intent(in) :: path
      !> Length of each dimension, (width, samples) for a channel
      integer(hsize_t), allocatable, intent(out) :: extent(:)
      !> Allocated if there is no such dataset
      type(error_type), allocatable, intent(out) :: error
      integer(hsize_t), allocatable :: limit(:)
      integer(hid_t) :: dataset, space
      integer :: status, rank
      call h5dopen_f(file, path, dataset, status)
      if (status < 0) then
         allocate (extent(0))
         call hdf5_error(error, file, 'cannot open '//path, status_deck)
         return
      end if
      call h5dget_space_f(dataset, space, status)
      call h5sget_simple_extent_ndims_f(space, rank, status)
      allocate (extent(rank), limit(rank))
      if (rank > 0) call h5sget_simple_extent_dims_f(space, extent, limit, status)
      call h5sclose_f(space, status)
      call h5dclose_f(dataset, status)
   end subroutine dataset_shape

   subroutine read_attribute_text(file, path, name, value, error)
      integer(hid_t), intent(in) :: file
      character(*), intent(in) :: path, name
      character(:), allocatable, intent(out) :: value
      type(error_type), allocatable, intent(out) :: error
      integer(hid_t) :: object, attribute, string, space
      integer(size_t) :: length
      integer :: status
      type(c_ptr), target :: pointer_to_text
      type(c_ptr) :: place
      character(:), allocatable, target :: buffer
      value = ''
      call open_attribute(file, path, name, object, attribute, error)
      if (allocated(error)) return
      call h5aget_type_f(attribute, string, status)
      call h5aget_space_f(attribute, space, status)
      select case (kind_of_text(string, space))
      case (variable_text)
         pointer_to_text = c_null_ptr
         place = c_loc(pointer_to_text)
         call h5aread_f(attribute, string, place, status)
         if (status < 0) call hdf5_error(error, file, 'cannot read the attribute '//name//' of '//path, status_deck)
         call take_text(pointer_to_text, string, space, value)
      case (fixed_text)
         call h5tget_size_f(string, length, status)
         allocate (character(length) :: buffer)
         place = c_loc(buffer(1:1))
         call h5aread_f(attribute, string, place, status)
         if (status < 0) call hdf5_error(error, file, 'cannot read the attribute '//name//' of '//path, status_deck)
         value = trim(buffer(:index(buffer//achar(0), achar(0)) - 1))
      case default
         call raise(error, 'the attribute '//name//' of '//path//' is not a text', status_deck)
      end select
      call h5sclose_f(space, status)
      call h5tclose_f(string, status)
      call h5aclose_f(attribute, status)
      call h5oclose_f(object, status)
   end subroutine read_attribute_text

   subroutine read_attribute_integer(file, path, name, value, error)
      integer(hid_t), intent(in) :: file
      character(*), intent(in) :: path, name
      integer, intent(out) :: value
      type(error_type), allocatable, intent(out) :: error
      integer(hid_t) :: object, attribute, space
      integer(hsize_t) :: count
      integer, target :: number
      type(c_ptr) :: place
      integer :: status
      value = 0
      call open_attribute(file, path, name, object, attribute, error)
      if (allocated(error)) return
      call h5aget_space_f(attribute, space, status)
      call h5sget_simple_extent_npoints_f(space, count, status)
      if (count == 1) then
         place = c_loc(number)
         call h5aread_f(attribute, h5t_native_integer, place, status)
      else
         status = -1
      end if
      if (status >= 0) then
         value = number
      else
         call raise(error, 'the attribute '//name//' of '//path//' is not an integer', status_deck)
      end if
      call h5sclose_f(space, status)
      call h5aclose_f(attribute, status)
      call h5oclose_f(object, status)
   end subroutine read_attribute_integer

   subroutine read_attribute_real(file, path, name, value, error)
      integer(hid_t), intent(in) :: file
      character(*), intent(in) :: path, name
      real(wp), intent(out) :: value
      type(error_type), allocatable, intent(out) :: error
      integer(hid_t) :: object, attribute, space
      integer(hsize_t) :: count
      real(wp), target :: number
      type(c_ptr) :: place
      integer :: status
      value = 0.0_wp
      call open_attribute(file, path, name, object, attribute, error)
      if (allocated(error)) return
      call h5aget_space_f(attribute, space, status)
      call h5sget_simple_extent_npoints_f(space, count, status)
      if (count == 1) then
         place = c_loc(number)
         call h5aread_f(attribute, h5t_native_double, place, status)
      else
         status = -1
      end if
      if (status >= 0) then
         value = number
      else
         call raise(error, 'the attribute '//name//' of '//path//' is not a number', status_deck)
      end if
      call h5sclose_f(space, status)
      call h5aclose_f(attribute, status)
      call h5oclose_f(object, status)
   end subroutine read_attribute_real

   !> Opens an attribute and its object; neither is open after an error.
   subroutine open_attribute(file, path, name, object, attribute, error)
      integer(hid_t), intent(in) :: file
      character(*), intent(in) :: path, name
      integer(hid_t), intent(out) :: object, attribute
      type(error_type), allocatable, intent(out) :: error
      logical :: exists
      integer :: status
      call h5oopen_f(file, path, object, status)
      if (status < 0) then
         call hdf5_error(error, file, 'cannot find '//path, status_deck)
         return
      end if
      call h5aexists_f(object, name, exists, status)
      if (status >= 0 .and. exists) then
         call h5aopen_f(object, name, attribute, status)
         if (status >= 0) return
         call hdf5_error(error, file, 'cannot open the attribute '//name//' of '//path, status_deck)
      else
         call raise(error, path//' has no attribute '//name, status_deck)
      end if
      call h5oclose_f(object, status)
   end subroutine open_attribute

   subroutine read_dataset_text(file, path, value, error)
      integer(hid_t), intent(in) :: file
      character(*), intent(in) :: path
      character(:), allocatable, intent(out) :: value
      type(error_type), allocatable, intent(out) :: error
      integer(hid_t) :: dataset, string, space
      integer(size_t) :: length
      integer :: status
      type(c_ptr), target :: pointer_to_text
      type(c_ptr) :: place
      character(:), allocatable, target :: buffer
      value = ''
      call h5dopen_f(file, path, dataset, status)
      if (status < 0) then
         call hdf5_error(error, file, 'cannot open '//path, status_deck)
         return
      end if
      call h5dget_type_f(dataset, string, status)
      call h5dget_space_f(dataset, space, status)
      if (kind_of_text(string, space) == variable_text) then
         pointer_to_text = c_null_ptr
         place = c_loc(pointer_to_text)
         call h5dread_f(dataset, string, place, status)
         if (status < 0) call hdf5_error(error, file, 'cannot read '//path, status_deck)
         call take_text(pointer_to_text, string, space, value)
      else if (kind_of_text(string, space) == fixed_text) then
         call h5tget_size_f(string, length, status)
         buffer = ''
         deallocate (buffer)
         allocate (character(length) :: buffer, stat=status)
         if (status == 0) then
            place = c_loc(buffer(1:1))
            call h5dread_f(dataset, string, place, status)
         end if
         if (status == 0) then
            value = buffer(:index(buffer//achar(0), achar(0)) - 1)
         else
            call hdf5_error(error, file, 'cannot read '//path, status_deck)
         end if
      else
         call raise(error, path//' is not a text', status_deck)
      end if
      call h5sclose_f(space, status)
      call h5tclose_f(string, status)
      call h5dclose_f(dataset, status)
   end subroutine read_dataset_text

   subroutine read_dataset_reals(file, path, value, error)
      integer(hid_t), intent(in) :: file
      character(*), intent(in) :: path
      real(wp), allocatable, intent(out) :: value(:)
      type(error_type), allocatable, intent(out) :: error
      integer(hsize_t), allocatable :: extent(:)
      integer :: status
      call dataset_shape(file, path, extent, error)
      if (allocated(error)) return
      if (size(extent) /= 1) then
         call raise(error, path//' does not have one dimension', status_deck)
         return
      end if
      allocate (value(extent(1)), stat=status)
      if (status /= 0) then
         call raise(error, path//' is too large for the memory', status_run)
         return
      end if
      call h5ltread_dataset_double_f(file, path, value, extent, status)
      if (status < 0) call hdf5_error(error, file, 'cannot read '//path, status_deck)
   end subroutine read_dataset_reals

   subroutine read_dataset_table(file, path, value, error)
      integer(hid_t), intent(in) :: file
      character(*), intent(in) :: path
      real(wp), allocatable, intent(out) :: value(:, :)
      type(error_type), allocatable, intent(out) :: error
      integer(hsize_t), allocatable :: extent(:)
      integer :: status
      call dataset_shape(file, path, extent, error)
      if (allocated(error)) return
      if (size(extent) == 1) extent = [1_hsize_t, extent]
      if (size(extent) /= 2) then
         call raise(error, path//' has neither one nor two dimensions', status_deck)
         return
      end if
      allocate (value(extent(1), extent(2)), stat=status)
      if (status /= 0) then
         call raise(error, path//' is too large for the memory', status_run)
         return
      end if
      call h5ltread_dataset_double_f(file, path, value, extent, status)
      if (status < 0) call hdf5_error(error, file, 'cannot read '//path, status_deck)
   end subroutine read_dataset_table

   !> How a text is stored, if it is one text at all.
   integer function kind_of_text(string, space) result(kind)
      integer(hid_t), intent(in) :: string, space
      integer(hsize_t) :: count
      integer :: status, class
      logical :: variable
      kind = no_text
      call h5tget_class_f(string, class, status)
      call h5sget_simple_extent_npoints_f(space, count, status)
      if (class /= h5t_string_f .or. count /= 1) return
      call h5tis_variable_str_f(string, variable, status)
      kind = merge(variable_text, fixed_text, variable)
   end function kind_of_text

   !> Copies a text that HDF5 allocated, and frees it.
   subroutine take_text(pointer_to_text, string, space, value)
      type(c_ptr), intent(inout), target :: pointer_to_text
      integer(hid_t), intent(in) :: string, space
      character(:), allocatable, intent(out) :: value
      type(c_ptr) :: place
      integer :: status
      value = ''
      if (.not. c_associated(pointer_to_text)) return
      value = text_of(pointer_to_text)
      place = c_loc(pointer_to_text)
      call h5dvlen_reclaim_f(string, space, h5p_default_f, place, status)
   end subroutine take_text

end module limber_output_hdf5_read
