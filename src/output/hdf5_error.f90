!> Errors of HDF5 as error values. Floor: output, below every other module that calls HDF5. Source: HDF5 1.10 Reference Manual, H5E.
module limber_output_hdf5_error
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_pointer, c_funloc, c_funptr, c_int, c_int64_t, &
      & c_loc, c_null_ptr, c_ptr, c_size_t
   use hdf5, only: hid_t, h5open_f, h5dont_atexit_f, h5eset_auto_f, h5fget_name_f
   use limber_base_error, only: error_type, raise
   implicit none
   private
   public :: open_library, hdf5_error, stack_reason, text_of, no_id, reason_in_use, no_reason

   !> Value of an identifier that is not open
   integer(hid_t), parameter :: no_id = -1_hid_t

   !> Reason for a file that is locked
   character(*), parameter :: reason_in_use = 'another program has it open'
   !> Reason where HDF5 has none
   character(*), parameter :: no_reason = 'no reason given by HDF5'

   !> One entry of the HDF5 error stack (H5E_error2_t)
   type, bind(c) :: stack_entry_type
      integer(c_int64_t) :: class, major, minor
      integer(c_int) :: line
      type(c_ptr) :: procedure, file, description
   end type stack_entry_type

   interface
      !> Visits the entries of an error stack; the Fortran interface of HDF5 has no such procedure
      integer(c_int) function h5ewalk2(stack, direction, visit, store) bind(c, name='H5Ewalk2')
         import :: c_int, c_int64_t, c_funptr, c_ptr
         integer(c_int64_t), value :: stack
         integer(c_int), value :: direction
         type(c_funptr), value :: visit
         type(c_ptr), value :: store
      end function h5ewalk2

      !> Length of a C string
      integer(c_size_t) function strlen(text) bind(c, name='strlen')
         import :: c_ptr, c_size_t
         type(c_ptr), value :: text
      end function strlen
   end interface

   !> The library is opened once a process: every h5open_f would make all predefined types anew
   logical :: library_open = .false.

contains

   !> Opens the HDF5 library, once, and keeps it from printing its error stack. It is also kept from cleaning up when
   !> the program ends: after a full disk, HDF5 1.10 tries to close the file once more there and crashes.
   subroutine open_library(error)
      type(error_type), allocatable, intent(out) :: error
      integer :: status
      if (library_open) return
      call h5dont_atexit_f(status)
      call h5open_f(status)
      if (status >= 0) call h5eset_auto_f(0, status)
      if (status < 0) then
         call raise(error, 'the HDF5 library cannot be started')
         return
      end if
      library_open = .true.
   end subroutine open_library

   !> Raises the failure of the HDF5 call just made: '<file>: <what>: <reason>'.
   subroutine hdf5_error(error, object, what, status)
      !> Allocated on return
      type(error_type), allocatable, intent(out) :: error
      !> File, or an open object in it
      integer(hid_t), intent(in) :: object
      !> What could not be done
      character(*), intent(in) :: what
      !> Exit status (default `status_run`)
      integer, intent(in), optional :: status
      character(:), allocatable :: reason
      character(4096) :: name
      integer(c_size_t) :: length
      integer :: failed
      reason = stack_reason()
      call h5fget_name_f(object, name, length, failed)
      if (failed < 0) name = 'results file'
      call raise(error, trim(name)//': '//what//': '//reason, status)
   end subroutine hdf5_error

   !> Innermost reason on the HDF5 error stack: the system's own words if it has some.
   function stack_reason() result(reason)
      character(:), allocatable :: reason
      character(*), parameter :: mark = "error message = '"
      type(c_ptr), target :: description
      integer(c_int) :: status
      integer :: start
      description = c_null_ptr
      status = h5ewalk2(0_c_int64_t, 0_c_int, c_funloc(keep_innermost), c_loc(description))
      reason = no_reason
      if (status < 0 .or. .not. c_associated(description)) return
      reason = text_of(description)
      if (index(reason, 'unable to lock file') > 0) then
         reason = reason_in_use
         return
      end if
      start = index(reason, mark)
      if (start == 0) return
      reason = reason(start + len(mark):)
      if (index(reason, "'") > 0) reason = reason(:index(reason, "'") - 1)
   end function stack_reason

   !> A C string as a text.
   function text_of(string) result(text)
      !> NUL-terminated text; not null
      type(c_ptr), intent(in) :: string
      character(:), allocatable :: text
      character(kind=c_char), pointer :: letters(:)
      integer :: i
      call c_f_pointer(string, letters, [strlen(string)])
      allocate (character(size(letters)) :: text)
      do i = 1, size(letters)
         text(i:i) = letters(i)
      end do
   end function text_of

   !> Keeps the description of the first entry visited and stops the walk.
   integer(c_int) function keep_innermost(n, entry, store) bind(c) result(stop)
      integer(c_int), value :: n
      type(stack_entry_type), intent(in) :: entry
      type(c_ptr), value :: store
      type(c_ptr), pointer :: description
      call c_f_pointer(store, description)
      if (n == 0) description = entry%description
      stop = 1
   end function keep_innermost

end module limber_output_hdf5_error
