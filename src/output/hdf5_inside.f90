!> Check that a file keeps all its data in itself. No link leads elsewhere, and no dataset keeps its numbers in another file. limber
!> writes none of these, and follows none: they let a results file show what another file holds. Floor: output. Source: HDF5 1.10
!> Reference Manual, H5L, H5O, H5P.
module limber_output_hdf5_inside
   use hdf5, only: hid_t, hsize_t, size_t, h5d_virtual_f, h5dget_create_plist_f, h5gget_info_f, h5gopen_f, h5gclose_f, &
      & h5i_dataset_f, h5i_group_f, h5iget_type_f, h5l_type_hard_f, h5lget_info_by_idx_f, h5_index_name_f, h5_iter_native_f, &
      & h5oclose_f, h5oopen_by_idx_f, h5pclose_f, h5pget_external_count_f, h5pget_layout_f
   use limber_base_error, only: error_type, raise, status_deck
   implicit none
   private
   public :: check_inside

   !> Groups in groups of any file that limber reads, at most: a group that is in itself has no end
   integer, parameter :: deepest = 16

contains

   !> Refuses a file of which a part is elsewhere.
   subroutine check_inside(path, file, error)
      !> Name of the file, for the error
      character(*), intent(in) :: path
      !> Open
      integer(hid_t), intent(in) :: file
      type(error_type), allocatable, intent(out) :: error
      integer(hid_t) :: root
      integer :: status
      call h5gopen_f(file, '/', root, status)
      if (status < 0) then
         call raise(error, path//' is damaged: its groups cannot be read', status_deck)
         return
      end if
      call check_group(path, root, 1, error)
      call h5gclose_f(root, status)
   end subroutine check_inside

   recursive subroutine check_group(path, group, depth, error)
      character(*), intent(in) :: path
      integer(hid_t), value :: group
      integer, value :: depth
      type(error_type), allocatable, intent(out) :: error
      integer(hid_t) :: object
      integer(hsize_t) :: i
      integer(size_t) :: address, length
      integer :: status, storage, count, order, link, characters, kind, ignored
      logical :: ordered
      call h5gget_info_f(group, storage, count, order, status)
      if (status >= 0 .and. depth > deepest) status = -1
      ! In the order that HDF5 keeps: it would sort all names anew for each of them in another
      do i = 1, merge(count, 0, status >= 0)
         call h5lget_info_by_idx_f(group, '.', h5_index_name_f, h5_iter_native_f, i - 1, link, ordered, order, characters, &
            & address, length, status)
         if (status >= 0 .and. link /= h5l_type_hard_f) then
            call raise(error, path//': a link in it leads elsewhere, which limber does not follow; '// &
               & 'copy what it leads to into the file', status_deck)
            return
         end if
         if (status >= 0) call h5oopen_by_idx_f(group, '.', h5_index_name_f, h5_iter_native_f, i - 1, object, status)
         if (status < 0) exit
         call h5iget_type_f(object, kind, status)
         if (kind == h5i_dataset_f) call check_dataset(path, object, error)
         if (kind == h5i_group_f) call check_group(path, object, depth + 1, error)
         call h5oclose_f(object, ignored)
         if (allocated(error)) return
      end do
      if (status < 0) call raise(error, path//' is damaged: its groups cannot be read', status_deck)
   end subroutine check_group

   subroutine check_dataset(path, dataset, error)
      character(*), intent(in) :: path
      integer(hid_t), intent(in) :: dataset
      type(error_type), allocatable, intent(out) :: error
      integer(hid_t) :: list
      integer :: status, files, layout
      files = 0
      layout = h5d_virtual_f
      call h5dget_create_plist_f(dataset, list, status)
      if (status >= 0) call h5pget_layout_f(list, layout, status)
      if (status >= 0 .and. layout /= h5d_virtual_f) call h5pget_external_count_f(list, files, status)
      if (status < 0 .or. layout == h5d_virtual_f .or. files > 0) call raise(error, path// &
         & ': a dataset in it keeps its numbers in another file, which limber does not read; repack it (h5repack)', status_deck)
      call h5pclose_f(list, status)
   end subroutine check_dataset

end module limber_output_hdf5_inside
