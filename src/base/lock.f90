!> A lock of the process: one thread at a time computes. gfortran keeps lengths of texts that functions return, and ARPACK what it
!> iterates, in variables that all threads share. Procedures that threads enter before they have it are recursive. Floor: base.
module limber_base_lock
   use, intrinsic :: iso_c_binding, only: c_int, c_int64_t, c_loc, c_ptr
   implicit none
   private
   public :: take_lock, release_lock

   !> A mutex of POSIX: zeros are PTHREAD_MUTEX_INITIALIZER of Linux
   integer(c_int64_t), target :: mutex(8) = 0

   interface
      integer(c_int) function c_mutex_lock(mutex) bind(c, name='pthread_mutex_lock')
         import :: c_int, c_ptr
         type(c_ptr), value :: mutex
      end function c_mutex_lock
      integer(c_int) function c_mutex_unlock(mutex) bind(c, name='pthread_mutex_unlock')
         import :: c_int, c_ptr
         type(c_ptr), value :: mutex
      end function c_mutex_unlock
   end interface

contains

   !> Waits until no other thread has the lock, and takes it. A thread that has it must not take it again.
   recursive subroutine take_lock()
      integer(c_int) :: ignored
      ignored = c_mutex_lock(c_loc(mutex))
   end subroutine take_lock

   !> Lets the next thread go on.
   recursive subroutine release_lock()
      integer(c_int) :: ignored
      ignored = c_mutex_unlock(c_loc(mutex))
   end subroutine release_lock

end module limber_base_lock
