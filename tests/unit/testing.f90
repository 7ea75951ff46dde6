!> What every unit test uses: named checks that are counted and printed, and a status that tells.
module testing
   use, intrinsic :: iso_fortran_env, only: output_unit
   use limber_base_ending, only: leave
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   implicit none
   private
   public :: check, check_close, check_text, check_no_error, make_folder, finish

   integer :: passed = 0, failed = 0

contains

   !> Counts a condition; prints it if it does not hold.
   subroutine check(condition, name)
      logical, intent(in) :: condition
      character(*), intent(in) :: name
      if (condition) then
         passed = passed + 1
      else
         failed = failed + 1
         print '(2a)', 'FAILED: ', name
      end if
   end subroutine check

   !> Holds if |value - expected| <= tolerance (NaN fails).
   subroutine check_close(value, expected, tolerance, name)
      real(wp), intent(in) :: value, expected, tolerance
      character(*), intent(in) :: name
      call check(abs(value - expected) <= tolerance, name//': '//as_text(value)// &
         & ', expected '//as_text(expected)//' within '//as_text(tolerance))
   end subroutine check_close

   !> Holds if two texts are the same, byte for byte.
   subroutine check_text(value, expected, name)
      character(*), intent(in) :: value, expected, name
      call check(len(value) == len(expected) .and. value == expected, &
         & name//new_line('a')//'--- got'//new_line('a')//value//new_line('a')//'--- expected'//new_line('a')//expected)
   end subroutine check_text

   !> Holds if no error was raised.
   subroutine check_no_error(error, name)
      type(error_type), allocatable, intent(in) :: error
      character(*), intent(in) :: name
      if (allocated(error)) then
         call check(.false., name//': '//error%message)
      else
         call check(.true., name)
      end if
   end subroutine check_no_error

   !> Makes a folder for files, of its own, in the one that the environment variable TMPDIR names, or in /tmp.
   subroutine make_folder(name, folder)
      !> Of the test
      character(*), intent(in) :: name
      character(:), allocatable, intent(out) :: folder
      character(512) :: base
      character(16) :: number
      integer :: length, clock
      call get_environment_variable('TMPDIR', base, length)
      if (length == 0) base = '/tmp'
      call system_clock(clock)
      write (number, '(i0)') clock
      folder = trim(base)//'/limber-test-'//name//'-'//trim(number)
      call execute_command_line('mkdir -p '//folder)
   end subroutine make_folder

   !> Prints the counts and ends the test; a failure, or no check at all, with a non-zero status. What a main program holds is never
   !> freed: it ends here, while that is in use still, and not behind its last line, where the leak sanitizer would count it.
   subroutine finish()
      print '(i0,a,i0,a)', passed, ' checks passed, ', failed, ' failed'
      flush (output_unit)
      call leave(merge(1, 0, failed > 0 .or. passed == 0))
   end subroutine finish

end module testing
