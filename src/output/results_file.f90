!> Parts of a results file that are not sampled. Groups, small datasets with their units and what they are, attributes.
!> `limber_output_history` adds the samples. Floor: output.
module limber_output_results_file
   use hdf5, only: hid_t, h5dclose_f
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp, long
   use limber_output_hdf5, only: create_group, write_attribute, write_dataset
   use limber_output_hdf5_error, only: no_id
   use limber_output_hdf5_scales, only: open_scale, attach_scale
   use limber_output_sample_sink, only: sink_type
   implicit none
   private
   public :: results_type

   !> An open results file
   type, extends(sink_type), abstract :: results_type
      !> Of HDF5; `no_id`: not open
      integer(hid_t) :: file = no_id
      !> Whether there is no file: nothing is written, and only what the sink sums up stays
      logical :: unkept = .false.
   contains
      procedure :: put_group, put_text, put_axis, put_integer
      !> `put_real(path, value, units, long_name, error)`: value (:) or (:, :), which h5py sees transposed
      generic :: put_real => put_reals, put_table
      !> `put_attribute(path, name, value, error)`: value a text, integer, long, real or real (:)
      generic :: put_attribute => put_attribute_text, put_attribute_integer, put_attribute_long, &
         & put_attribute_real, put_attribute_reals
      procedure, private :: put_reals, put_table, put_attribute_text, put_attribute_integer, put_attribute_long, &
         & put_attribute_real, put_attribute_reals
   end type results_type

contains

   !> Makes a group, such as one for `put_beside`; its attributes are those of all its datasets.
   subroutine put_group(self, path, error)
      !> Open file
      class(results_type), intent(in) :: self
      !> Absolute path, such as '/error_estimate'
      character(*), intent(in) :: path
      !> Allocated if it cannot be written
      type(error_type), allocatable, intent(out) :: error
      if (self%unkept) return
      call create_group(self%file, path, error)
   end subroutine put_group

   !> Writes the numbers 1..n as a dimension scale, and makes it that of the slowest dimension of datasets beside it.
   subroutine put_axis(self, path, n, long_name, names, error)
      !> Open file
      class(results_type), intent(in) :: self
      !> Absolute path of the scale
      character(*), intent(in) :: path
      integer, intent(in) :: n
      !> One line for people
      character(*), intent(in) :: long_name
      !> Datasets of the same group
      character(*), intent(in) :: names(:)
      !> Allocated if it cannot be written
      type(error_type), allocatable, intent(out) :: error
      integer(hid_t) :: scale
      integer :: i, ignored
      if (self%unkept) return
      call self%put_integer(path, [(i, i=1, n)], long_name, error)
      if (allocated(error)) return
      call open_scale(self%file, path, .true., scale, error)
      do i = 1, size(names)
         if (allocated(error)) exit
         call attach_scale(self%file, path(:index(path, '/', back=.true.))//trim(names(i)), scale, error)
      end do
      call h5dclose_f(scale, ignored)
   end subroutine put_axis

   !> Writes a text as a dataset, replacing an older one.
   subroutine put_text(self, path, text, error)
      !> Open file
      class(results_type), intent(in) :: self
      !> Absolute path, such as '/run/deck'
      character(*), intent(in) :: path
      !> Text of any length, UTF-8
      character(*), intent(in) :: text
      !> Allocated if it cannot be written
      type(error_type), allocatable, intent(out) :: error
      if (self%unkept) return
      call write_dataset(self%file, path, text, error)
   end subroutine put_text

   !> Writes integers as a dataset, replacing an older one.
   subroutine put_integer(self, path, value, long_name, error)
      !> Open file
      class(results_type), intent(in) :: self
      !> Absolute path, such as '/bodies/rod/nodes'
      character(*), intent(in) :: path
      !> Numbers
      integer, intent(in) :: value(:)
      !> One line for people
      character(*), intent(in) :: long_name
      !> Allocated if it cannot be written
      type(error_type), allocatable, intent(out) :: error
      if (self%unkept) return
      call write_dataset(self%file, path, value, error)
      if (.not. allocated(error)) call write_attribute(self%file, path, 'long_name', long_name, error)
   end subroutine put_integer

   subroutine put_reals(self, path, value, units, long_name, error)
      class(results_type), intent(in) :: self
      character(*), intent(in) :: path, units, long_name
      real(wp), intent(in) :: value(:)
      type(error_type), allocatable, intent(out) :: error
      if (self%unkept) return
      call write_dataset(self%file, path, value, error)
      if (.not. allocated(error)) call write_attribute(self%file, path, 'units', units, error)
      if (.not. allocated(error)) call write_attribute(self%file, path, 'long_name', long_name, error)
   end subroutine put_reals

   subroutine put_table(self, path, value, units, long_name, error)
      class(results_type), intent(in) :: self
      character(*), intent(in) :: path, units, long_name
      real(wp), intent(in) :: value(:, :)
      type(error_type), allocatable, intent(out) :: error
      if (self%unkept) return
      call write_dataset(self%file, path, value, error)
      if (.not. allocated(error)) call write_attribute(self%file, path, 'units', units, error)
      if (.not. allocated(error)) call write_attribute(self%file, path, 'long_name', long_name, error)
   end subroutine put_table

   subroutine put_attribute_text(self, path, name, value, error)
      class(results_type), intent(in) :: self
      character(*), intent(in) :: path, name
      character(*), intent(in) :: value
      type(error_type), allocatable, intent(out) :: error
      if (self%unkept) return
      call write_attribute(self%file, path, name, value, error)
   end subroutine put_attribute_text

   subroutine put_attribute_integer(self, path, name, value, error)
      class(results_type), intent(in) :: self
      character(*), intent(in) :: path, name
      integer, intent(in) :: value
      type(error_type), allocatable, intent(out) :: error
      if (self%unkept) return
      call write_attribute(self%file, path, name, value, error)
   end subroutine put_attribute_integer

   subroutine put_attribute_long(self, path, name, value, error)
      class(results_type), intent(in) :: self
      character(*), intent(in) :: path, name
      integer(long), intent(in) :: value
      type(error_type), allocatable, intent(out) :: error
      if (self%unkept) return
      call write_attribute(self%file, path, name, value, error)
   end subroutine put_attribute_long

   subroutine put_attribute_real(self, path, name, value, error)
      class(results_type), intent(in) :: self
      character(*), intent(in) :: path, name
      real(wp), intent(in) :: value
      type(error_type), allocatable, intent(out) :: error
      if (self%unkept) return
      call write_attribute(self%file, path, name, value, error)
   end subroutine put_attribute_real

   subroutine put_attribute_reals(self, path, name, value, error)
      class(results_type), intent(in) :: self
      character(*), intent(in) :: path, name
      real(wp), intent(in) :: value(:)
      type(error_type), allocatable, intent(out) :: error
      if (self%unkept) return
      call write_attribute(self%file, path, name, value, error)
   end subroutine put_attribute_reals

end module limber_output_results_file
