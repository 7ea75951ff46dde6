!> Large deflections by dividing a beam: a cantilever under an axial load above Euler's, which it finds its way past alone, and
!> under a transverse load, against elliptic integrals. Usage, in tests/: test_elastica RESULT_FILE
program test_elastica
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_changed, channel
   use testing, only: check, check_close, finish
   implicit none
   !> Tip (x, y) of the elastica at 1.1 and 1.5 times Euler's load, and under P L^2/(E I) = 1 and 10 across
   real(wp), parameter :: axial(2, 2) = reshape([0.82029593994878_wp, 0.50853415829037_wp, 0.36358822492179_wp, &
      & 0.78857580569254_wp], [2, 2])
   real(wp), parameter :: across(2, 2) = reshape([0.94356676371662_wp, 0.30172077379981_wp, 0.44500440224625_wp, &
      & 0.8106091024889_wp], [2, 2])
   character(256) :: results

   call get_command_argument(1, results)
   call check_elastica()
   call check_cantilever()
   call check_order()
   call finish()

contains

   subroutine check_elastica()
      type(history_reader_type) :: reader
      real(wp), allocatable :: ratio(:), x(:), y(:)
      call run_changed('../input/elastica.inp', trim(results), [character(1) ::], [character(1) ::], reader)
      allocate (ratio, source=channel(reader, 'ratio'))
      allocate (x, source=channel(reader, 'x_tip'))
      allocate (y, source=channel(reader, 'y_tip'))
      call check(size(x) == 17, 'a sample at the critical load')
      call check_close(ratio(12), 1.0_wp, 1.0e-4_wp, 'Euler load')
      call check_close(maxval(abs(y(:12))), 0.0_wp, 1.0e-9_wp, 'straight below it')
      call check_close(ratio(13), 1.1_wp, 1.0e-12_wp, 'the increment behind it')
      call check_close(x(13)/axial(1, 1), 1.0_wp, 1.0e-3_wp, 'x of the tip at 1.1')
      call check_close(abs(y(13))/axial(2, 1), 1.0_wp, 1.0e-3_wp, 'y of the tip at 1.1')
      call check_close(x(17)/axial(1, 2), 1.0_wp, 1.0e-3_wp, 'x of the tip at 1.5')
      call check_close(abs(y(17))/axial(2, 2), 1.0_wp, 1.0e-3_wp, 'y of the tip at 1.5')
      call reader%close()
   end subroutine check_elastica

   subroutine check_cantilever()
      type(history_reader_type) :: reader
      real(wp), allocatable :: x(:), y(:)
      call run_changed('../input/cantilever_large.inp', trim(results), [character(1) ::], [character(1) ::], reader)
      allocate (x, source=channel(reader, 'x_tip'))
      allocate (y, source=channel(reader, 'y_tip'))
      call check_close(maxval(abs([x(2), y(2)]/across(:, 1) - 1)), 0.0_wp, 2.0e-5_wp, 'tip under P L^2/(E I) = 1')
      call check_close(maxval(abs([x(11), y(11)]/across(:, 2) - 1)), 0.0_wp, 2.0e-4_wp, 'tip under P L^2/(E I) = 10')
      call reader%close()
   end subroutine check_cantilever

   !> Errors fall faster than with the square of the number of functions, until what the axis shortens by, 1e-6, remains.
   subroutine check_order()
      real(wp) :: coarse(2), fine(2)
      integer :: k
      character(3), parameter :: ratio(2) = ['1.1', '1.5']
      do k = 1, 2
         call tip(2, ratio(k), coarse)
         call tip(4, ratio(k), fine)
         coarse = abs(coarse - axial(:, k))
         fine = abs(fine - axial(:, k))
         print '(3a,4es10.2)', 'ratio ', ratio(k), ': errors with 2 and 4 functions', coarse, fine
         call check(all(log(coarse/fine)/log(2.0_wp) > 2.0_wp), 'order of the tip, ratio '//ratio(k))
      end do
   end subroutine check_order

   !> Tip of an elastica.
   subroutine tip(functions, ratio, place)
      integer, intent(in) :: functions
      character(*), intent(in) :: ratio
      real(wp), intent(out) :: place(2)
      type(history_reader_type) :: reader
      character(13) :: old(3), new(3)
      old = [character(13) :: 'FUNCTIONS=9', '-1.5*t', 'INCREMENTS=15']
      new(1) = 'FUNCTIONS='//as_text(functions)
      new(2) = '-'//ratio//'*t'
      new(3) = 'INCREMENTS=4'
      call run_changed('../input/elastica.inp', trim(results), old, new, reader)
      place(1) = last_of(channel(reader, 'x_tip'))
      place(2) = abs(last_of(channel(reader, 'y_tip')))
      call reader%close()
   end subroutine tip

   pure real(wp) function last_of(values)
      real(wp), intent(in) :: values(:)
      last_of = values(size(values))
   end function last_of

end program test_elastica
