!> Signals by which a run is asked to end: SIGINT (Ctrl-C), SIGTERM, and SIGUSR1 with which Slurm warns of the end of its time.
!> They are taken note of only; a second one ends the process at once. Floor: base.
module limber_base_signals
   use, intrinsic :: iso_c_binding, only: c_funloc, c_funptr, c_int, c_intptr_t, c_null_funptr
   implicit none
   private
   public :: catch_signals, release_signals, signal_came, signal_name, let_writes_fail

   integer(c_int), parameter :: interrupt = 2, user = 10, termination = 15
   integer(c_int), parameter :: caught_signals(*) = [interrupt, user, termination]

   !> The last one that came; zero: none
   integer(c_int), volatile :: caught = 0

   interface
      type(c_funptr) function c_signal(number, handler) bind(c, name='signal')
         import :: c_funptr, c_int
         integer(c_int), value :: number
         type(c_funptr), value :: handler
      end function c_signal
   end interface

contains

   !> From now on signals are taken note of.
   subroutine catch_signals()
      type(c_funptr) :: ignored
      integer :: i
      caught = 0
      do i = 1, size(caught_signals)
         ignored = c_signal(caught_signals(i), c_funloc(note))
      end do
   end subroutine catch_signals

   !> From now on a file that grows beyond its limit (ulimit -f) is an error like a full disk; else SIGXFSZ would end the process.
   subroutine let_writes_fail()
      integer(c_int), parameter :: size_exceeded = 25
      integer(c_intptr_t), parameter :: ignore = 1
      type(c_funptr) :: ignored
      ignored = c_signal(size_exceeded, transfer(ignore, c_null_funptr))
   end subroutine let_writes_fail

   !> From now on they end the process again.
   subroutine release_signals()
      type(c_funptr) :: ignored
      integer :: i
      do i = 1, size(caught_signals)
         ignored = c_signal(caught_signals(i), c_null_funptr)
      end do
   end subroutine release_signals

   !> Whether one has come.
   logical function signal_came()
      signal_came = caught /= 0
   end function signal_came

   !> Name of the one that came; empty if none has.
   function signal_name() result(name)
      character(:), allocatable :: name
      select case (caught)
      case (0); name = ''
      case (interrupt); name = 'SIGINT'
      case (user); name = 'SIGUSR1'
      case default; name = 'SIGTERM'
      end select
   end function signal_name

   subroutine note(number) bind(c, name='limber_note_signal')
      integer(c_int), value :: number
      type(c_funptr) :: ignored
      caught = number
      ignored = c_signal(number, c_null_funptr)
   end subroutine note

end module limber_base_signals
