!> The one exit of the program. It is `leave`. A library that ends the process itself (a run-time error, memory that is not to be
!> had, an abort) would give a status that means something else to limber; here it becomes that of a run that could not finish.
!> Floor: base.
module limber_base_ending
   use, intrinsic :: iso_c_binding, only: c_char, c_funloc, c_funptr, c_int, c_size_t
   use limber_base_error, only: status_run
   implicit none
   private
   public :: guard_ending, leave

   !> Whether the program itself has asked for its end
   logical :: asked = .false.

   interface
      integer(c_int) function c_atexit(handler) bind(c, name='atexit')
         import :: c_funptr, c_int
         type(c_funptr), value :: handler
      end function c_atexit
      type(c_funptr) function c_signal(number, handler) bind(c, name='signal')
         import :: c_funptr, c_int
         integer(c_int), value :: number
         type(c_funptr), value :: handler
      end function c_signal
      subroutine c_exit(status) bind(c, name='exit')
         import :: c_int
         integer(c_int), value :: status
      end subroutine c_exit
      subroutine c_exit_now(status) bind(c, name='_exit')
         import :: c_int
         integer(c_int), value :: status
      end subroutine c_exit_now
      integer(c_size_t) function c_write(descriptor, text, length) bind(c, name='write')
         import :: c_char, c_int, c_size_t
         integer(c_int), value :: descriptor
         character(kind=c_char), intent(in) :: text(*)
         integer(c_size_t), value :: length
      end function c_write
   end interface

contains

   !> From now on the process ends by `leave`, or with status 3 and a word.
   subroutine guard_ending()
      integer(c_int), parameter :: abort_signal = 6
      integer(c_int) :: ignored
      type(c_funptr) :: before
      ignored = c_atexit(c_funloc(at_end))
      before = c_signal(abort_signal, c_funloc(at_abort))
   end subroutine guard_ending

   !> Ends the program with a status and without a word, which `stop` cannot.
   subroutine leave(status)
      integer, intent(in) :: status
      asked = .true.
      call c_exit(int(status, c_int))
   end subroutine leave

   subroutine at_end() bind(c, name='limber_at_end')
      if (.not. asked) call end_with_word()
   end subroutine at_end

   subroutine at_abort(number) bind(c, name='limber_at_abort')
      integer(c_int), value :: number
      if (number > 0) call end_with_word()
   end subroutine at_abort

   !> Says that it was not limber, and ends. Nothing here allocates: there may be no memory left.
   subroutine end_with_word()
      character(*), parameter :: text = 'limber: a library has ended the process, for the reason above or for lack of memory; '// &
         & 'results and checkpoints written before are whole. Try fewer OUTPUTS, elements or modes, or more memory'//achar(10)
      integer(c_size_t) :: ignored
      ignored = c_write(2_c_int, text, len(text, c_size_t))
      call c_exit_now(int(status_run, c_int))
   end subroutine end_with_word

end module limber_base_ending
