!> Processes by POSIX that share a queue of numbers. Floor: base.
module limber_base_process
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_long, c_null_char, c_associated, c_loc, c_ptr, c_size_t
   implicit none
   private
   public :: start_copy, end_copy, ask_copy, wait_for_copy, pause_shortly, own_number, parent_number, host_name, &
      & processors
   public :: queue_type, new_queue, next_in_queue, taken_of_queue

   !> Numbers that several processes take, each number one of them
   type :: queue_type
      integer(c_int), private :: descriptor = -1
      integer :: length = 0
   end type queue_type

   integer(c_int), parameter :: without_waiting = 1, from_start = 0, from_here = 1

   interface
      integer(c_int) function c_fork() bind(c, name='fork')
         import :: c_int
      end function c_fork
      subroutine c_exit_now(status) bind(c, name='_exit')
         import :: c_int
         integer(c_int), value :: status
      end subroutine c_exit_now
      integer(c_int) function c_waitpid(number, status, options) bind(c, name='waitpid')
         import :: c_int
         integer(c_int), value :: number
         integer(c_int), intent(out) :: status
         integer(c_int), value :: options
      end function c_waitpid
      integer(c_int) function c_kill(number, signal) bind(c, name='kill')
         import :: c_int
         integer(c_int), value :: number, signal
      end function c_kill
      integer(c_int) function c_getpid() bind(c, name='getpid')
         import :: c_int
      end function c_getpid
      integer(c_int) function c_getppid() bind(c, name='getppid')
         import :: c_int
      end function c_getppid
      integer(c_int) function c_usleep(microseconds) bind(c, name='usleep')
         import :: c_int
         integer(c_int), value :: microseconds
      end function c_usleep
      integer(c_int) function c_gethostname(name, length) bind(c, name='gethostname')
         import :: c_char, c_int, c_size_t
         character(kind=c_char), intent(out) :: name(*)
         integer(c_size_t), value :: length
      end function c_gethostname
      integer(c_int) function c_get_nprocs() bind(c, name='get_nprocs')
         import :: c_int
      end function c_get_nprocs
      type(c_ptr) function c_tmpfile() bind(c, name='tmpfile')
         import :: c_ptr
      end function c_tmpfile
      integer(c_int) function c_fileno(stream) bind(c, name='fileno')
         import :: c_int, c_ptr
         type(c_ptr), value :: stream
      end function c_fileno
      integer(c_size_t) function c_read(descriptor, buffer, length) bind(c, name='read')
         import :: c_int, c_ptr, c_size_t
         integer(c_int), value :: descriptor
         type(c_ptr), value :: buffer
         integer(c_size_t), value :: length
      end function c_read
      integer(c_size_t) function c_write(descriptor, buffer, length) bind(c, name='write')
         import :: c_int, c_ptr, c_size_t
         integer(c_int), value :: descriptor
         type(c_ptr), value :: buffer
         integer(c_size_t), value :: length
      end function c_write
      integer(c_long) function c_lseek(descriptor, offset, whence) bind(c, name='lseek')
         import :: c_int, c_long
         integer(c_int), value :: descriptor
         integer(c_long), value :: offset
         integer(c_int), value :: whence
      end function c_lseek
   end interface

contains

   !> Makes a copy of this process; true in the copy.
   subroutine start_copy(number, is_copy)
      !> Number of the copy; -1 if it could not be made
      integer, intent(out) :: number
      logical, intent(out) :: is_copy
      number = int(c_fork())
      is_copy = number == 0
   end subroutine start_copy

   !> Ends a copy at once, without touching what it shares with the others.
   subroutine end_copy(status)
      integer, intent(in) :: status
      call c_exit_now(int(status, c_int))
   end subroutine end_copy

   !> Asks a copy to end, or ends it.
   subroutine ask_copy(number, at_once)
      !> Of the copy; above zero
      integer, intent(in) :: number
      logical, intent(in) :: at_once
      integer(c_int), parameter :: kill = 9, terminate = 15
      integer(c_int) :: ignored
      if (number > 0) ignored = c_kill(int(number, c_int), merge(kill, terminate, at_once))
   end subroutine ask_copy

   !> The next copy that has ended, without waiting for it.
   subroutine wait_for_copy(number, signal)
      !> Its number; 0: none has ended
      integer, intent(out) :: number
      !> The signal that killed it; 0: none did
      integer, intent(out) :: signal
      integer(c_int) :: status
      status = 0
      number = max(0, int(c_waitpid(-1_c_int, status, without_waiting)))
      signal = iand(int(status), 127)
      if (signal == 0 .and. status /= 0) signal = -iand(ishft(int(status), -8), 255)
   end subroutine wait_for_copy

   !> Sleeps for a while.
   subroutine pause_shortly(seconds)
      !> Less than a second
      real, intent(in) :: seconds
      integer(c_int) :: ignored
      ignored = c_usleep(int(1.0e6*seconds, c_int))
   end subroutine pause_shortly

   !> Number of this process.
   integer function own_number()
      own_number = int(c_getpid())
   end function own_number

   !> Number of the process that has started this one; another one when that has ended.
   integer function parent_number()
      parent_number = int(c_getppid())
   end function parent_number

   !> Name of this machine.
   function host_name() result(name)
      character(:), allocatable :: name
      character(kind=c_char) :: buffer(256)
      integer :: i
      buffer = c_null_char
      name = 'host'
      if (c_gethostname(buffer, 255_c_size_t) /= 0) return
      name = ''
      do i = 1, 255
         if (buffer(i) == c_null_char) exit
         name = name//buffer(i)
      end do
   end function host_name

   !> Processors of this machine, or of the task that a scheduler runs.
   integer function processors()
      character(32) :: text
      integer :: status
      call get_environment_variable('SLURM_CPUS_PER_TASK', text, status=status)
      if (status == 0) read (text, *, iostat=status) processors
      if (status /= 0) processors = int(c_get_nprocs())
      processors = max(1, processors)
   end function processors

   !> A queue that copies of this process take from.
   subroutine new_queue(numbers, queue, ok)
      integer, intent(in) :: numbers(:)
      type(queue_type), intent(out) :: queue
      !> False if there is no room for it
      logical, intent(out) :: ok
      integer(c_int), target :: buffer(max(1, size(numbers)))
      type(c_ptr) :: stream
      integer(c_size_t) :: length
      buffer(:size(numbers)) = int(numbers, c_int)
      stream = c_tmpfile()
      ok = c_associated(stream)
      if (.not. ok) return
      queue%descriptor = c_fileno(stream)
      queue%length = size(numbers)
      length = 4_c_size_t*size(numbers)
      ok = c_write(queue%descriptor, c_loc(buffer), length) == length
      if (ok) ok = c_lseek(queue%descriptor, 0_c_long, from_start) == 0
   end subroutine new_queue

   !> The next number of a queue; 0 at its end. The place in the queue is shared by all copies.
   integer function next_in_queue(queue) result(number)
      type(queue_type), intent(in) :: queue
      integer(c_int), target :: buffer
      number = 0
      buffer = 0
      if (c_read(queue%descriptor, c_loc(buffer), 4_c_size_t) == 4) number = int(buffer)
   end function next_in_queue

   !> How many numbers have been taken.
   integer function taken_of_queue(queue) result(count)
      type(queue_type), intent(in) :: queue
      count = int(c_lseek(queue%descriptor, 0_c_long, from_here)/4)
   end function taken_of_queue

end module limber_base_process
