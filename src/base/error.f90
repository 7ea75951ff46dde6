!> Errors as values. A fallible procedure ends with `type(error_type), allocatable, intent(out) :: error`; unallocated means
!> success. The library never stops and never prints; only `main` does. Floor: base.
module limber_base_error
   implicit none
   private
   public :: error_type, raise, status_deck, status_run, status_interrupted

   !> Exit status of a command or deck that cannot be used
   integer, parameter :: status_deck = 2
   !> Exit status of a run that could not finish
   integer, parameter :: status_run = 3
   !> Exit status of a run that a signal has interrupted and that can go on
   integer, parameter :: status_interrupted = 4

   !> What went wrong: names the object and the numbers, and says what to try
   type :: error_type
      !> One or more lines of text, without a trailing newline
      character(:), allocatable :: message
      !> Exit status that the program ends with
      integer :: status = status_run
   end type error_type

contains

   !> Sets an error.
   pure subroutine raise(error, message, status)
      !> Allocated on return
      type(error_type), allocatable, intent(out) :: error
      !> Text for the user
      character(*), intent(in) :: message
      !> Exit status (default `status_run`)
      integer, intent(in), optional :: status
      allocate (error)
      error%message = message
      if (present(status)) error%status = status
   end subroutine raise

end module limber_base_error
