!> Complaints of libraries as error values. LAPACK and BLAS report an impossible argument to XERBLA, and theirs ends the process
!> with status 0: this one takes its place in every program that links limber, takes note and returns. Floor: base.
module limber_base_fault
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_size_t
   use limber_base_error, only: error_type, raise, status_run
   use limber_base_text, only: as_text, newline
   implicit none
   private
   public :: add_fault, forget_fault, note_fault

   !> Longest name of a routine that is taken note of
   integer, parameter :: longest = 32

   !> The first routine that complained, and the number of the argument; empty: none did
   character(:), allocatable :: routine
   integer :: argument = 0

contains

   !> Takes note of an impossible argument.
   subroutine note_fault(name, number, length) bind(c, name='xerbla_')
      !> Routine of LAPACK or BLAS
      character(kind=c_char), intent(in) :: name(*)
      !> Which of its arguments, from 1
      integer(c_int), intent(in) :: number
      !> Letters of the name, as gfortran passes it behind the arguments
      integer(c_size_t), value :: length
      integer :: i
      if (allocated(routine)) return
      routine = ''
      do i = 1, int(min(max(length, 0_c_size_t), int(longest, c_size_t)))
         if (verify(name(i), 'ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_') > 0) exit
         routine = routine//name(i)
      end do
      argument = int(number)
   end subroutine note_fault

   !> Lets a complaint since the start of the process, or since it was forgotten, be an error, or the cause of one that is there.
   subroutine add_fault(error)
      !> Unallocated: there was none so far
      type(error_type), allocatable, intent(inout) :: error
      character(:), allocatable :: text
      if (.not. allocated(routine)) return
      text = 'the library routine '//routine//' refused its argument '//as_text(argument)// &
         & ': this is an error in limber, not in the deck; please report it with the deck'
      if (.not. allocated(error)) then
         call raise(error, text, status_run)
      else if (index(error%message, routine) == 0) then
         error%message = error%message//newline//text
      end if
   end subroutine add_fault

   !> Forgets what a library has complained of.
   subroutine forget_fault()
      if (allocated(routine)) deallocate (routine)
      argument = 0
   end subroutine forget_fault

end module limber_base_fault
