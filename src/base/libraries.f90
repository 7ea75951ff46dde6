!> Settings of the libraries that the program is linked with: threads of linear algebra, heap of C. Each is asked for by name and
!> left alone where it is not there. Floor: base.
module limber_base_libraries
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_procpointer, c_funptr, c_int, c_intptr_t, c_null_char, &
      & c_null_ptr, c_ptr
   implicit none
   private
   public :: use_one_thread, keep_heap

   !> Procedures that take the number of threads, of OpenBLAS, MKL and BLIS
   character(*), parameter :: setters(*) = [character(27) :: 'openblas_set_num_threads', 'MKL_Set_Num_Threads', &
      & 'bli_thread_set_num_threads']
   !> Parameters of mallopt, as <malloc.h> of the GNU C library numbers them
   integer(c_int), parameter :: trim_threshold = -1, top_pad = -2, mmap_threshold = -3
   integer(c_int), parameter :: heap_parameters(*) = [trim_threshold, top_pad, mmap_threshold]
   !> Their values: bytes free at the end of the heap before some are given back; bytes taken at a time; bytes from which an array
   !> has pages of its own
   integer(c_int), parameter :: heap_bytes(*) = [256*1024**2, 1024**2, 4*1024**2]

   interface
      !> The procedure of a name among those that the program has been linked with, if it is there
      type(c_funptr) function c_dlsym(handle, name) bind(c, name='dlsym')
         import :: c_char, c_funptr, c_ptr
         type(c_ptr), value :: handle
         character(kind=c_char), intent(in) :: name(*)
      end function c_dlsym
   end interface

   abstract interface
      subroutine setter_interface(count) bind(c)
         import :: c_intptr_t
         integer(c_intptr_t), value :: count
      end subroutine setter_interface
      integer(c_int) function mallopt_interface(parameter, value) bind(c)
         import :: c_int
         integer(c_int), value :: parameter, value
      end function mallopt_interface
   end interface

contains

   !> From now on the library for linear algebra uses one thread, whatever the environment says. Some share their sums among
   !> threads, and then the last bits of a result depend on how many there are; limber's matrices are too small to gain by it, and
   !> its sweeps run processes side by side.
   subroutine use_one_thread()
      type(c_funptr) :: address
      procedure(setter_interface), pointer :: set_threads
      integer :: i
      do i = 1, size(setters)
         address = c_dlsym(c_null_ptr, trim(setters(i))//c_null_char)
         if (.not. c_associated(address)) cycle
         call c_f_procpointer(address, set_threads)
         call set_threads(1_c_intptr_t)
      end do
   end subroutine use_one_thread

   !> From now on the process keeps its heap. The GNU C library gives the free end of the heap back to the system, and takes it
   !> again with the next array: each page of it then costs a page fault. limber's arrays come and go.
   subroutine keep_heap()
      type(c_funptr) :: address
      procedure(mallopt_interface), pointer :: mallopt
      integer :: i
      address = c_dlsym(c_null_ptr, 'mallopt'//c_null_char)
      if (.not. c_associated(address)) return
      call c_f_procpointer(address, mallopt)
      do i = 1, size(heap_parameters)
         if (mallopt(heap_parameters(i), heap_bytes(i)) == 0) return
      end do
   end subroutine keep_heap

end module limber_base_libraries
