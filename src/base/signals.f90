!> Signals that ask a run to end. SIGINT (Ctrl-C), SIGTERM, and SIGUSR1 with which Slurm warns of the end of its time. What must not
!> be cut short takes note of them only, and looks whether one came; a second one, or one that comes elsewhere, ends the process at
!> once, with a word and the status of an interruption. Floor: base.
module limber_base_signals
   use, intrinsic :: iso_c_binding, only: c_char, c_funloc, c_funptr, c_int, c_intptr_t, c_null_funptr, c_size_t
   use limber_base_error, only: status_interrupted
   implicit none
   private
   public :: end_by_signals, catch_signals, release_signals, let_signals_end, signal_came, signal_name, let_writes_fail

   integer(c_int), parameter :: interrupt = 2, user = 10, termination = 15
   integer(c_int), parameter :: caught_signals(*) = [interrupt, user, termination]

   !> The last one that came; zero: none
   integer(c_int), volatile :: caught = 0
   !> Whether they are taken note of; whether every one is, and none ends the process; whether the next one does
   logical, volatile :: catching = .false., patient = .false., impatient = .false.

   interface
      integer(c_size_t) function c_write(descriptor, text, length) bind(c, name='write')
         import :: c_char, c_int, c_size_t
         integer(c_int), value :: descriptor
         character(kind=c_char), intent(in) :: text(*)
         integer(c_size_t), value :: length
      end function c_write
      subroutine c_exit_now(status) bind(c, name='_exit')
         import :: c_int
         integer(c_int), value :: status
      end subroutine c_exit_now
      type(c_funptr) function c_signal(number, handler) bind(c, name='signal')
         import :: c_funptr, c_int
         integer(c_int), value :: number
         type(c_funptr), value :: handler
      end function c_signal
   end interface

contains

   !> From now on each ends the process at once, with a word.
   subroutine end_by_signals()
      type(c_funptr) :: handler
      catching = .false.
      handler = c_funloc(end_now)
      call set_handlers(handler)
   end subroutine end_by_signals

   !> From now on signals are taken note of. One that came since an earlier call stays.
   subroutine catch_signals(all)
      !> Whether all are, as in a process that another one watches over; else the second one ends the process. Absent: false
      logical, intent(in), optional :: all
      type(c_funptr) :: handler
      patient = .false.
      if (present(all)) patient = all
      if (catching) return
      caught = 0
      catching = .true.
      handler = c_funloc(note)
      call set_handlers(handler)
   end subroutine catch_signals

   !> From now on a file that grows beyond its limit (ulimit -f) is an error like a full disk; else SIGXFSZ would end the process.
   subroutine let_writes_fail()
      integer(c_int), parameter :: size_exceeded = 25
      integer(c_intptr_t), parameter :: ignore = 1
      type(c_funptr) :: ignored
      ignored = c_signal(size_exceeded, transfer(ignore, c_null_funptr))
   end subroutine let_writes_fail

   !> Whether the next one ends the process at once although they are taken note of: while a library computes that does not look,
   !> and all is written that the run goes on from.
   subroutine let_signals_end(do_so)
      logical, intent(in) :: do_so
      impatient = do_so
   end subroutine let_signals_end

   !> From now on they end the process again.
   subroutine release_signals()
      call end_by_signals()
   end subroutine release_signals

   subroutine set_handlers(handler)
      type(c_funptr), intent(in) :: handler
      type(c_funptr) :: ignored
      integer :: i
      do i = 1, size(caught_signals)
         ignored = c_signal(caught_signals(i), handler)
      end do
   end subroutine set_handlers

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
      if (impatient .or. (caught /= 0 .and. .not. patient)) call end_now(number)
      caught = number
   end subroutine note

   !> Ends the process. Nothing here allocates: the signal may have come anywhere.
   subroutine end_now(number) bind(c, name='limber_end_now')
      integer(c_int), value :: number
      character(*), parameter :: text = 'limber: ended at once by a signal; what was written before is whole, the rest is to be'// &
         & ' done again'//achar(10)
      integer(c_size_t) :: ignored
      if (number > 0) ignored = c_write(2_c_int, text, len(text, c_size_t))
      call c_exit_now(int(status_interrupted, c_int))
   end subroutine end_now

end module limber_base_signals
