!> Number of threads of the linear algebra libraries. Some of them share their sums among threads, and then the last bits of a
!> result depend on how many there are; limber's matrices are too small to gain by it, and its sweeps run processes side by side.
!> Floor: base.
module limber_base_threads
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_procpointer, c_funptr, c_intptr_t, c_null_char, c_null_ptr, &
      & c_ptr
   implicit none
   private
   public :: use_one_thread

   !> Procedures that take the number of threads, of OpenBLAS, MKL and BLIS
   character(*), parameter :: setters(*) = [character(27) :: 'openblas_set_num_threads', 'MKL_Set_Num_Threads', &
      & 'bli_thread_set_num_threads']

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
   end interface

contains

   !> From now on the library for linear algebra uses one thread, whatever the environment says.
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

end module limber_base_threads
