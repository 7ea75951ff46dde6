!> Axial dynamics: a struck rod against d'Alembert's solution. Usage, in tests/: test_axial RESULT_FILE
program test_axial
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_changed, channel
   use testing, only: check_close, check_no_error, finish
   implicit none

   character(256) :: results

   call get_command_argument(1, results)
   call test_struck_rod()
   call finish()

contains

   !> Both ends of the rod: the impulse over Z = rho A c, and its reflections. Everything vibrates.
   subroutine test_struck_rod()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), parameter :: c = sqrt(2.0e11_wp/7850), z = 7850*acos(-1.0_wp)*0.01_wp**2*c
      real(wp), allocatable :: t(:), struck(:), free(:), exact(:)
      real(wp) :: whole
      integer :: k, i
      call run_changed('../input/struck_rod.inp', trim(results), [character(1) ::], [character(1) ::], reader)
      call reader%read_time(t, error)
      call check_no_error(error, 'struck rod: times')
      allocate (struck, source=channel(reader, 'x_rod_start'))
      allocate (free, source=channel(reader, 'x_rod_end'))
      call reader%close()
      allocate (exact(size(t)))
      exact = [(impulse(t(i)), i=1, size(t))]/z
      do k = 1, 4
         exact = exact + [(2*impulse(t(i) - 2*k/c), i=1, size(t))]/z
      end do
      whole = exact(size(t))
      print '(a,2es10.2)', 'struck rod: errors of the struck end', maxval(abs(struck - exact))/whole
      call check_close(maxval(abs(struck - exact))/whole, 0.0_wp, 2.0e-3_wp, 'struck rod: struck end')
      exact = 1.0_wp
      do k = 1, 4
         exact = exact + [(2*impulse(t(i) - (2*k - 1)/c), i=1, size(t))]/z
      end do
      print '(a,2es10.2)', 'struck rod: errors of the free end', maxval(abs(free - exact))/whole
      call check_close(maxval(abs(free - exact))/whole, 0.0_wp, 5.0e-4_wp, 'struck rod: free end')
   end subroutine test_struck_rod

   !> Integral of the blow 1e4 sin^2 until t.
   pure real(wp) function impulse(t)
      real(wp), intent(in) :: t
      real(wp), parameter :: passage = 1/sqrt(2.0e11_wp/7850), pi = acos(-1.0_wp)
      impulse = 0.0_wp
      if (t > 0.0_wp) impulse = 1.0e4_wp*(0.5_wp*t - passage*sin(2*pi*t/passage)/(4*pi))
      if (t > passage) impulse = 0.5e4_wp*passage
   end function impulse

end program test_axial
