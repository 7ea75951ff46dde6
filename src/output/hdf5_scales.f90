!> Dimension scales. What the dimensions of datasets count. Floor: output. Source: HDF5 1.10, Dimension Scales (H5DS), and the
!> netCDF-4 conventions built on them.
module limber_output_hdf5_scales
   use hdf5, only: hid_t, h5dopen_f, h5dclose_f
   use h5ds, only: h5dsset_scale_f, h5dsattach_scale_f, h5dsdetach_scale_f
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use limber_output_hdf5, only: object_exists, write_dataset
   use limber_output_hdf5_error, only: hdf5_error, no_id
   implicit none
   private
   public :: make_scale, open_scale, open_components, attach_scale, attach_open_scale, detach_scale

contains

   !> Makes an open dataset a dimension scale, of the name that its path ends with.
   subroutine make_scale(file, path, dataset, error)
      !> Open file and dataset
      integer(hid_t), intent(in) :: file, dataset
      !> Absolute path of the dataset
      character(*), intent(in) :: path
      !> Allocated if it cannot be written
      type(error_type), allocatable, intent(out) :: error
      integer :: status
      call h5dsset_scale_f(dataset, status, path(index(path, '/', back=.true.) + 1:))
      if (status < 0) call hdf5_error(error, file, 'cannot make '//path//' a dimension scale')
   end subroutine make_scale

   !> Opens a dataset as a dimension scale; it is to be closed, also after an error.
   subroutine open_scale(file, path, is_new, scale, error)
      !> Open file
      integer(hid_t), intent(in) :: file
      !> Absolute path of the dataset
      character(*), intent(in) :: path
      !> Whether the dataset has to be made a scale
      logical, intent(in) :: is_new
      integer(hid_t), intent(out) :: scale
      !> Allocated if it is not there or cannot be written
      type(error_type), allocatable, intent(out) :: error
      integer :: status
      scale = no_id
      call h5dopen_f(file, path, scale, status)
      if (status < 0) then
         call hdf5_error(error, file, 'cannot make '//path//' a dimension scale')
      else if (is_new) then
         call make_scale(file, path, scale, error)
      end if
   end subroutine open_scale

   !> Opens /component_<n>, the scale 1..n of the second dimension of datasets of that width; makes it at its first use.
   subroutine open_components(file, width, scale, error)
      !> Open file
      integer(hid_t), intent(in) :: file
      integer, intent(in) :: width
      integer(hid_t), intent(out) :: scale
      !> Allocated if it cannot be written
      type(error_type), allocatable, intent(out) :: error
      character(:), allocatable :: path
      logical :: is_new
      integer :: i
      scale = no_id
      path = '/component_'//as_text(width)
      is_new = .not. object_exists(file, path)
      if (is_new) call write_dataset(file, path, [(i, i=1, width)], error)
      if (.not. allocated(error)) call open_scale(file, path, is_new, scale, error)
   end subroutine open_components

   !> Makes an open scale that of the slowest dimension of a dataset.
   subroutine attach_scale(file, path, scale, error)
      !> Open file and scale
      integer(hid_t), intent(in) :: file, scale
      !> Absolute path of the dataset
      character(*), intent(in) :: path
      !> Allocated if it is not there or cannot be written
      type(error_type), allocatable, intent(out) :: error
      integer(hid_t) :: dataset
      integer :: status, ignored
      call h5dopen_f(file, path, dataset, status)
      if (status < 0) then
         call hdf5_error(error, file, 'cannot attach a dimension scale to '//path)
         return
      end if
      call attach_open_scale(file, path, dataset, scale, 1, error)
      call h5dclose_f(dataset, ignored)
   end subroutine attach_scale

   !> The same of an open dataset, and of any dimension.
   subroutine attach_open_scale(file, path, dataset, scale, dimension, error)
      !> Open file, dataset and scale
      integer(hid_t), intent(in) :: file, dataset, scale
      !> Absolute path of the dataset, for the error
      character(*), intent(in) :: path
      !> From 1, the slowest, as h5py counts them
      integer, intent(in) :: dimension
      !> Allocated if it cannot be written
      type(error_type), allocatable, intent(out) :: error
      integer :: status
      call h5dsattach_scale_f(dataset, scale, dimension, status)
      if (status < 0) call hdf5_error(error, file, 'cannot attach a dimension scale to '//path)
   end subroutine attach_open_scale

   !> Takes an open scale from the slowest dimension of a dataset, which may have none.
   subroutine detach_scale(file, path, scale)
      !> Open file and scale
      integer(hid_t), intent(in) :: file, scale
      !> Absolute path of the dataset, which is there
      character(*), intent(in) :: path
      integer(hid_t) :: dataset
      integer :: status
      call h5dopen_f(file, path, dataset, status)
      if (status < 0) return
      call h5dsdetach_scale_f(dataset, scale, 1, status)
      call h5dclose_f(dataset, status)
   end subroutine detach_scale

end module limber_output_hdf5_scales
