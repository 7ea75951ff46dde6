!> Stands for the Fortran modules of HDF5 1.10, whose compiled form serves one compiler only: tests/second_compiler/run checks
!> sources against it, and nothing is linked. It has what src uses, with the kinds of arguments that src uses. Source: HDF5 1.10
!> Reference Manual.
module hdf5
   use, intrinsic :: iso_c_binding, only: c_int64_t, c_ptr, c_size_t
   implicit none
   public

   integer, parameter :: hid_t = c_int64_t, hsize_t = c_int64_t, size_t = c_size_t, wp = kind(1.0d0)

   integer(hid_t), protected :: h5t_c_s1, h5t_ieee_f64le, h5t_native_double, h5t_native_integer, h5t_std_i64le, h5t_string
   integer(hid_t), protected :: h5p_default_f, h5p_dataset_create_f, h5p_file_access_f, h5p_file_create_f, h5p_group_create_f
   integer(hsize_t), protected :: h5s_unlimited_f
   integer, protected :: h5d_virtual_f, h5f_acc_excl_f, h5f_acc_rdonly_f, h5f_acc_rdwr_f, h5f_acc_trunc_f, h5f_close_strong_f, &
      & h5f_libver_latest_f, h5f_libver_v18_f, h5f_scope_global_f, h5i_dataset_f, h5i_group_f, h5_index_crt_order_f, &
      & h5_index_name_f, h5_iter_inc_f, h5_iter_native_f, h5l_type_hard_f, h5p_crt_order_indexed_f, h5p_crt_order_tracked_f, &
      & h5s_scalar_f, h5s_select_set_f, h5t_cset_utf8_f, h5t_string_f

   interface h5awrite_f
      subroutine h5awrite_ptr(attr_id, mem_type_id, buf, hdferr)
         import :: c_ptr, hid_t
         integer(hid_t), intent(in) :: attr_id, mem_type_id
         type(c_ptr), intent(in), target :: buf
         integer, intent(out) :: hdferr
      end subroutine h5awrite_ptr
   end interface h5awrite_f

   interface h5aread_f
      subroutine h5aread_ptr(attr_id, mem_type_id, buf, hdferr)
         import :: c_ptr, hid_t
         integer(hid_t), intent(in) :: attr_id, mem_type_id
         type(c_ptr), intent(inout), target :: buf
         integer, intent(out) :: hdferr
      end subroutine h5aread_ptr
   end interface h5aread_f

   interface h5dwrite_f
      subroutine h5dwrite_ptr(dset_id, mem_type_id, buf, hdferr, mem_space_id, file_space_id, xfer_prp)
         import :: c_ptr, hid_t
         integer(hid_t), intent(in) :: dset_id, mem_type_id
         type(c_ptr), intent(in) :: buf
         integer, intent(out) :: hdferr
         integer(hid_t), intent(in), optional :: mem_space_id, file_space_id, xfer_prp
      end subroutine h5dwrite_ptr
   end interface h5dwrite_f

   interface h5dread_f
      subroutine h5dread_ptr(dset_id, mem_type_id, buf, hdferr, mem_space_id, file_space_id, xfer_prp)
         import :: c_ptr, hid_t
         integer(hid_t), intent(in) :: dset_id, mem_type_id
         type(c_ptr), intent(inout) :: buf
         integer, intent(out) :: hdferr
         integer(hid_t), intent(in), optional :: mem_space_id, file_space_id, xfer_prp
      end subroutine h5dread_ptr
   end interface h5dread_f

   interface h5pset_fill_value_f
      subroutine h5pset_fill_value_double(prp_id, type_id, fillvalue, hdferr)
         import :: hid_t, wp
         integer(hid_t), intent(in) :: prp_id, type_id
         real(wp), intent(in) :: fillvalue
         integer, intent(out) :: hdferr
      end subroutine h5pset_fill_value_double
   end interface h5pset_fill_value_f

   interface

      subroutine h5open_f(error)
         integer, intent(out) :: error
      end subroutine h5open_f

      subroutine h5dont_atexit_f(error)
         integer, intent(out) :: error
      end subroutine h5dont_atexit_f

      subroutine h5aclose_f(attr_id, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: attr_id
         integer, intent(out) :: hdferr
      end subroutine h5aclose_f

      subroutine h5acreate_f(loc_id, name, type_id, space_id, attr_id, hdferr, acpl_id, aapl_id)
         import :: hid_t
         integer(hid_t), intent(in) :: loc_id, type_id, space_id
         character(*), intent(in) :: name
         integer(hid_t), intent(out) :: attr_id
         integer, intent(out) :: hdferr
         integer(hid_t), intent(in), optional :: acpl_id, aapl_id
      end subroutine h5acreate_f

      subroutine h5adelete_f(obj_id, name, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: obj_id
         character(*), intent(in) :: name
         integer, intent(out) :: hdferr
      end subroutine h5adelete_f

      subroutine h5aexists_f(obj_id, attr_name, attr_exists, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: obj_id
         character(*), intent(in) :: attr_name
         logical, intent(out) :: attr_exists
         integer, intent(out) :: hdferr
      end subroutine h5aexists_f

      subroutine h5aget_space_f(attr_id, space_id, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: attr_id
         integer(hid_t), intent(out) :: space_id
         integer, intent(out) :: hdferr
      end subroutine h5aget_space_f

      subroutine h5aget_type_f(attr_id, type_id, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: attr_id
         integer(hid_t), intent(out) :: type_id
         integer, intent(out) :: hdferr
      end subroutine h5aget_type_f

      subroutine h5aopen_f(obj_id, attr_name, attr_id, hdferr, aapl_id)
         import :: hid_t
         integer(hid_t), intent(in) :: obj_id
         character(*), intent(in) :: attr_name
         integer(hid_t), intent(out) :: attr_id
         integer, intent(out) :: hdferr
         integer(hid_t), intent(in), optional :: aapl_id
      end subroutine h5aopen_f

      subroutine h5dclose_f(dset_id, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: dset_id
         integer, intent(out) :: hdferr
      end subroutine h5dclose_f

      subroutine h5dcreate_f(loc_id, name, type_id, space_id, dset_id, hdferr, dcpl_id, lcpl_id, dapl_id)
         import :: hid_t
         integer(hid_t), intent(in) :: loc_id, type_id, space_id
         character(*), intent(in) :: name
         integer(hid_t), intent(out) :: dset_id
         integer, intent(out) :: hdferr
         integer(hid_t), intent(in), optional :: dcpl_id, lcpl_id, dapl_id
      end subroutine h5dcreate_f

      subroutine h5dget_create_plist_f(dset_id, plist_id, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: dset_id
         integer(hid_t), intent(out) :: plist_id
         integer, intent(out) :: hdferr
      end subroutine h5dget_create_plist_f

      subroutine h5dget_space_f(dataset_id, dataspace_id, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: dataset_id
         integer(hid_t), intent(out) :: dataspace_id
         integer, intent(out) :: hdferr
      end subroutine h5dget_space_f

      subroutine h5dget_type_f(dataset_id, datatype_id, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: dataset_id
         integer(hid_t), intent(out) :: datatype_id
         integer, intent(out) :: hdferr
      end subroutine h5dget_type_f

      subroutine h5dopen_f(loc_id, name, dset_id, hdferr, dapl_id)
         import :: hid_t
         integer(hid_t), intent(in) :: loc_id
         character(*), intent(in) :: name
         integer(hid_t), intent(out) :: dset_id
         integer, intent(out) :: hdferr
         integer(hid_t), intent(in), optional :: dapl_id
      end subroutine h5dopen_f

      subroutine h5dset_extent_f(dataset_id, size, hdferr)
         import :: hid_t, hsize_t
         integer(hid_t), intent(in) :: dataset_id
         integer(hsize_t), intent(in) :: size(*)
         integer, intent(out) :: hdferr
      end subroutine h5dset_extent_f

      subroutine h5dvlen_reclaim_f(type_id, space_id, plist_id, buf, hdferr)
         import :: c_ptr, hid_t
         integer(hid_t), intent(in) :: type_id, space_id, plist_id
         type(c_ptr), intent(inout) :: buf
         integer, intent(out) :: hdferr
      end subroutine h5dvlen_reclaim_f

      subroutine h5eset_auto_f(printflag, hdferr)
         integer, intent(in) :: printflag
         integer, intent(out) :: hdferr
      end subroutine h5eset_auto_f

      subroutine h5fclose_f(file_id, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: file_id
         integer, intent(out) :: hdferr
      end subroutine h5fclose_f

      subroutine h5fcreate_f(name, access_flags, file_id, hdferr, creation_prp, access_prp)
         import :: hid_t
         character(*), intent(in) :: name
         integer, intent(in) :: access_flags
         integer(hid_t), intent(out) :: file_id
         integer, intent(out) :: hdferr
         integer(hid_t), intent(in), optional :: creation_prp, access_prp
      end subroutine h5fcreate_f

      subroutine h5fflush_f(object_id, scope, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: object_id
         integer, intent(in) :: scope
         integer, intent(out) :: hdferr
      end subroutine h5fflush_f

      subroutine h5fget_name_f(obj_id, buf, size, hdferr)
         import :: hid_t, size_t
         integer(hid_t), intent(in) :: obj_id
         character(*), intent(inout) :: buf
         integer(size_t), intent(out) :: size
         integer, intent(out) :: hdferr
      end subroutine h5fget_name_f

      subroutine h5fis_hdf5_f(name, status, hdferr)
         character(*), intent(in) :: name
         logical, intent(out) :: status
         integer, intent(out) :: hdferr
      end subroutine h5fis_hdf5_f

      subroutine h5fopen_f(name, access_flags, file_id, hdferr, access_prp)
         import :: hid_t
         character(*), intent(in) :: name
         integer, intent(in) :: access_flags
         integer(hid_t), intent(out) :: file_id
         integer, intent(out) :: hdferr
         integer(hid_t), intent(in), optional :: access_prp
      end subroutine h5fopen_f

      subroutine h5gclose_f(grp_id, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: grp_id
         integer, intent(out) :: hdferr
      end subroutine h5gclose_f

      subroutine h5gcreate_f(loc_id, name, grp_id, hdferr, size_hint, lcpl_id, gcpl_id, gapl_id)
         import :: hid_t, size_t
         integer(hid_t), intent(in) :: loc_id
         character(*), intent(in) :: name
         integer(hid_t), intent(out) :: grp_id
         integer, intent(out) :: hdferr
         integer(size_t), intent(in), optional :: size_hint
         integer(hid_t), intent(in), optional :: lcpl_id, gcpl_id, gapl_id
      end subroutine h5gcreate_f

      subroutine h5gget_info_f(group_id, storage_type, nlinks, max_corder, hdferr, mounted)
         import :: hid_t
         integer(hid_t), intent(in) :: group_id
         integer, intent(out) :: storage_type, nlinks, max_corder, hdferr
         logical, intent(out), optional :: mounted
      end subroutine h5gget_info_f

      subroutine h5gopen_f(loc_id, name, grp_id, hdferr, gapl_id)
         import :: hid_t
         integer(hid_t), intent(in) :: loc_id
         character(*), intent(in) :: name
         integer(hid_t), intent(out) :: grp_id
         integer, intent(out) :: hdferr
         integer(hid_t), intent(in), optional :: gapl_id
      end subroutine h5gopen_f

      subroutine h5iget_type_f(obj_id, type, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: obj_id
         integer, intent(out) :: type, hdferr
      end subroutine h5iget_type_f

      subroutine h5ldelete_f(loc_id, name, hdferr, lapl_id)
         import :: hid_t
         integer(hid_t), intent(in) :: loc_id
         character(*), intent(in) :: name
         integer, intent(out) :: hdferr
         integer(hid_t), intent(in), optional :: lapl_id
      end subroutine h5ldelete_f

      subroutine h5lget_info_by_idx_f(loc_id, group_name, index_field, order, n, link_type, f_corder_valid, corder, cset, &
         & address, val_size, hdferr, lapl_id)
         import :: hid_t, hsize_t, size_t
         integer(hid_t), intent(in) :: loc_id
         character(*), intent(in) :: group_name
         integer, intent(in) :: index_field, order
         integer(hsize_t), intent(in) :: n
         integer, intent(out) :: link_type, corder, cset, hdferr
         logical, intent(out) :: f_corder_valid
         integer(hsize_t), intent(out) :: address
         integer(size_t), intent(out) :: val_size
         integer(hid_t), intent(in), optional :: lapl_id
      end subroutine h5lget_info_by_idx_f

      subroutine h5lget_name_by_idx_f(loc_id, group_name, index_field, order, n, name, hdferr, size, lapl_id)
         import :: hid_t, hsize_t, size_t
         integer(hid_t), intent(in) :: loc_id
         character(*), intent(in) :: group_name
         integer, intent(in) :: index_field, order
         integer(hsize_t), intent(in) :: n
         character(*), intent(out) :: name
         integer, intent(out) :: hdferr
         integer(size_t), intent(out), optional :: size
         integer(hid_t), intent(in), optional :: lapl_id
      end subroutine h5lget_name_by_idx_f

      subroutine h5oclose_f(object_id, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: object_id
         integer, intent(out) :: hdferr
      end subroutine h5oclose_f

      subroutine h5oopen_by_idx_f(loc_id, group_name, index_type, order, n, obj_id, hdferr, lapl_id)
         import :: hid_t, hsize_t
         integer(hid_t), intent(in) :: loc_id
         character(*), intent(in) :: group_name
         integer, intent(in) :: index_type, order
         integer(hsize_t), intent(in) :: n
         integer(hid_t), intent(out) :: obj_id
         integer, intent(out) :: hdferr
         integer(hid_t), intent(in), optional :: lapl_id
      end subroutine h5oopen_by_idx_f

      subroutine h5oopen_f(loc_id, name, obj_id, hdferr, lapl_id)
         import :: hid_t
         integer(hid_t), intent(in) :: loc_id
         character(*), intent(in) :: name
         integer(hid_t), intent(out) :: obj_id
         integer, intent(out) :: hdferr
         integer(hid_t), intent(in), optional :: lapl_id
      end subroutine h5oopen_f

      subroutine h5pclose_f(prp_id, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: prp_id
         integer, intent(out) :: hdferr
      end subroutine h5pclose_f

      subroutine h5pcreate_f(class, prp_id, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: class
         integer(hid_t), intent(out) :: prp_id
         integer, intent(out) :: hdferr
      end subroutine h5pcreate_f

      subroutine h5pget_external_count_f(prp_id, count, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: prp_id
         integer, intent(out) :: count, hdferr
      end subroutine h5pget_external_count_f

      subroutine h5pget_layout_f(prp_id, layout, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: prp_id
         integer, intent(out) :: layout, hdferr
      end subroutine h5pget_layout_f

      subroutine h5pset_chunk_f(prp_id, ndims, dims, hdferr)
         import :: hid_t, hsize_t
         integer(hid_t), intent(in) :: prp_id
         integer, intent(in) :: ndims
         integer(hsize_t), intent(in) :: dims(ndims)
         integer, intent(out) :: hdferr
      end subroutine h5pset_chunk_f

      subroutine h5pset_fapl_core_f(prp_id, increment, backing_store, hdferr)
         import :: hid_t, size_t
         integer(hid_t), intent(in) :: prp_id
         integer(size_t), intent(in) :: increment
         logical, intent(in) :: backing_store
         integer, intent(out) :: hdferr
      end subroutine h5pset_fapl_core_f

      subroutine h5pset_fclose_degree_f(fapl_id, degree, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: fapl_id
         integer, intent(in) :: degree
         integer, intent(out) :: hdferr
      end subroutine h5pset_fclose_degree_f

      subroutine h5pset_fletcher32_f(prp_id, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: prp_id
         integer, intent(out) :: hdferr
      end subroutine h5pset_fletcher32_f

      subroutine h5pset_libver_bounds_f(fapl_id, low, high, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: fapl_id
         integer, intent(in) :: low, high
         integer, intent(out) :: hdferr
      end subroutine h5pset_libver_bounds_f

      subroutine h5pset_link_creation_order_f(gcpl_id, crt_order_flags, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: gcpl_id
         integer, intent(in) :: crt_order_flags
         integer, intent(out) :: hdferr
      end subroutine h5pset_link_creation_order_f

      subroutine h5sclose_f(space_id, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: space_id
         integer, intent(out) :: hdferr
      end subroutine h5sclose_f

      subroutine h5screate_f(classtype, space_id, hdferr)
         import :: hid_t
         integer, intent(in) :: classtype
         integer(hid_t), intent(out) :: space_id
         integer, intent(out) :: hdferr
      end subroutine h5screate_f

      subroutine h5screate_simple_f(rank, dims, space_id, hdferr, maxdims)
         import :: hid_t, hsize_t
         integer, intent(in) :: rank
         integer(hsize_t), intent(in) :: dims(rank)
         integer(hid_t), intent(out) :: space_id
         integer, intent(out) :: hdferr
         integer(hsize_t), intent(in), optional :: maxdims(rank)
      end subroutine h5screate_simple_f

      subroutine h5sget_simple_extent_dims_f(space_id, dims, maxdims, hdferr)
         import :: hid_t, hsize_t
         integer(hid_t), intent(in) :: space_id
         integer(hsize_t), intent(out) :: dims(*), maxdims(*)
         integer, intent(out) :: hdferr
      end subroutine h5sget_simple_extent_dims_f

      subroutine h5sget_simple_extent_ndims_f(space_id, rank, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: space_id
         integer, intent(out) :: rank, hdferr
      end subroutine h5sget_simple_extent_ndims_f

      subroutine h5sget_simple_extent_npoints_f(space_id, npoints, hdferr)
         import :: hid_t, hsize_t
         integer(hid_t), intent(in) :: space_id
         integer(hsize_t), intent(out) :: npoints
         integer, intent(out) :: hdferr
      end subroutine h5sget_simple_extent_npoints_f

      subroutine h5sselect_hyperslab_f(space_id, operator, start, count, hdferr, stride, block)
         import :: hid_t, hsize_t
         integer(hid_t), intent(in) :: space_id
         integer, intent(in) :: operator
         integer(hsize_t), intent(in) :: start(*), count(*)
         integer, intent(out) :: hdferr
         integer(hsize_t), intent(in), optional :: stride(:), block(:)
      end subroutine h5sselect_hyperslab_f

      subroutine h5tclose_f(type_id, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: type_id
         integer, intent(out) :: hdferr
      end subroutine h5tclose_f

      subroutine h5tcopy_f(type_id, new_type_id, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: type_id
         integer(hid_t), intent(out) :: new_type_id
         integer, intent(out) :: hdferr
      end subroutine h5tcopy_f

      subroutine h5tget_class_f(type_id, class, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: type_id
         integer, intent(out) :: class, hdferr
      end subroutine h5tget_class_f

      subroutine h5tget_size_f(type_id, size, hdferr)
         import :: hid_t, size_t
         integer(hid_t), intent(in) :: type_id
         integer(size_t), intent(out) :: size
         integer, intent(out) :: hdferr
      end subroutine h5tget_size_f

      subroutine h5tis_variable_str_f(type_id, status, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: type_id
         logical, intent(out) :: status
         integer, intent(out) :: hdferr
      end subroutine h5tis_variable_str_f

      subroutine h5tset_cset_f(type_id, cset, hdferr)
         import :: hid_t
         integer(hid_t), intent(in) :: type_id
         integer, intent(in) :: cset
         integer, intent(out) :: hdferr
      end subroutine h5tset_cset_f

      subroutine h5tset_size_f(type_id, size, hdferr)
         import :: hid_t, size_t
         integer(hid_t), intent(in) :: type_id
         integer(size_t), intent(in) :: size
         integer, intent(out) :: hdferr
      end subroutine h5tset_size_f

   end interface

end module hdf5

!> The high-level interface
module h5lt
   use hdf5, only: hid_t, hsize_t, wp
   implicit none
   private
   public :: h5ltmake_dataset_double_f, h5ltmake_dataset_int_f, h5ltpath_valid_f, h5ltread_dataset_double_f, &
      & h5ltset_attribute_string_f

   interface h5ltmake_dataset_double_f
      subroutine h5ltmake_dataset_double_1(loc_id, dset_name, rank, dims, buf, errcode)
         import :: hid_t, hsize_t, wp
         integer(hid_t), intent(in) :: loc_id
         character(*), intent(in) :: dset_name
         integer, intent(in) :: rank
         integer(hsize_t), intent(in) :: dims(*)
         real(wp), intent(in) :: buf(:)
         integer, intent(out) :: errcode
      end subroutine h5ltmake_dataset_double_1
      subroutine h5ltmake_dataset_double_2(loc_id, dset_name, rank, dims, buf, errcode)
         import :: hid_t, hsize_t, wp
         integer(hid_t), intent(in) :: loc_id
         character(*), intent(in) :: dset_name
         integer, intent(in) :: rank
         integer(hsize_t), intent(in) :: dims(*)
         real(wp), intent(in) :: buf(:, :)
         integer, intent(out) :: errcode
      end subroutine h5ltmake_dataset_double_2
   end interface h5ltmake_dataset_double_f

   interface h5ltmake_dataset_int_f
      subroutine h5ltmake_dataset_int_1(loc_id, dset_name, rank, dims, buf, errcode)
         import :: hid_t, hsize_t
         integer(hid_t), intent(in) :: loc_id
         character(*), intent(in) :: dset_name
         integer, intent(in) :: rank
         integer(hsize_t), intent(in) :: dims(*)
         integer, intent(in) :: buf(:)
         integer, intent(out) :: errcode
      end subroutine h5ltmake_dataset_int_1
   end interface h5ltmake_dataset_int_f

   interface h5ltread_dataset_double_f
      subroutine h5ltread_dataset_double_1(loc_id, dset_name, buf, dims, errcode)
         import :: hid_t, hsize_t, wp
         integer(hid_t), intent(in) :: loc_id
         character(*), intent(in) :: dset_name
         real(wp), intent(inout) :: buf(:)
         integer(hsize_t), intent(in) :: dims(*)
         integer, intent(out) :: errcode
      end subroutine h5ltread_dataset_double_1
      subroutine h5ltread_dataset_double_2(loc_id, dset_name, buf, dims, errcode)
         import :: hid_t, hsize_t, wp
         integer(hid_t), intent(in) :: loc_id
         character(*), intent(in) :: dset_name
         real(wp), intent(inout) :: buf(:, :)
         integer(hsize_t), intent(in) :: dims(*)
         integer, intent(out) :: errcode
      end subroutine h5ltread_dataset_double_2
   end interface h5ltread_dataset_double_f

   interface

      subroutine h5ltpath_valid_f(loc_id, path, check_object_valid, path_valid, errcode)
         import :: hid_t
         integer(hid_t), intent(in) :: loc_id
         character(*), intent(in) :: path
         logical, intent(in) :: check_object_valid
         logical, intent(out) :: path_valid
         integer, intent(out) :: errcode
      end subroutine h5ltpath_valid_f

      subroutine h5ltset_attribute_string_f(loc_id, dset_name, attr_name, buf, errcode)
         import :: hid_t
         integer(hid_t), intent(in) :: loc_id
         character(*), intent(in) :: dset_name, attr_name, buf
         integer, intent(out) :: errcode
      end subroutine h5ltset_attribute_string_f

   end interface

end module h5lt

!> Dimension scales
module h5ds
   use hdf5, only: hid_t
   implicit none
   private
   public :: h5dsset_scale_f, h5dsattach_scale_f, h5dsdetach_scale_f

   interface

      subroutine h5dsset_scale_f(dsid, errcode, dimname)
         import :: hid_t
         integer(hid_t), intent(in) :: dsid
         integer, intent(out) :: errcode
         character(*), intent(in), optional :: dimname
      end subroutine h5dsset_scale_f

      subroutine h5dsattach_scale_f(dsid, dsscale, idx, errcode)
         import :: hid_t
         integer(hid_t), intent(in) :: dsid, dsscale
         integer, intent(in) :: idx
         integer, intent(out) :: errcode
      end subroutine h5dsattach_scale_f

      subroutine h5dsdetach_scale_f(dsid, dsscale, idx, errcode)
         import :: hid_t
         integer(hid_t), intent(in) :: dsid, dsscale
         integer, intent(in) :: idx
         integer, intent(out) :: errcode
      end subroutine h5dsdetach_scale_f

   end interface

end module h5ds
