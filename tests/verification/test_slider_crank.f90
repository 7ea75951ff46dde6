!> The paper's slider-crank against values that limber did not make: the extremes of two independent prototypes (the table in
!> doc/theory, from the same formulation) and a converged geometrically exact solution (tests/reference/slider_crank_6mm.csv).
!> Usage, in tests/: test_slider_crank RESULT_FILE
program test_slider_crank
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_commands_run, only: run_deck
   use limber_output_history_reader, only: history_reader_type
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   !> Time, deflection over length and slider position of the reference
   real(wp), allocatable :: t_exact(:), w_exact(:), x_exact(:)

   call read_reference('reference/slider_crank_6mm.csv')

   ! Extremes of the same formulation, within 0.5 %
   call check_extremes('../input/slider_crank_fig4_linear.inp', 0.01503_wp, -0.01505_wp)
   call check_extremes('../input/slider_crank_fig4_kg.inp', 0.01236_wp, -0.01213_wp)
   call check_extremes('../input/slider_crank_fig5_linear.inp', 0.01861_wp, -0.01853_wp)
   call check_extremes('../input/slider_crank_fig5_kg.inp', 0.01562_wp, -0.01565_wp)

   ! Errors over time against the exact solution: not above, and for the crude models not below either
   call check_errors('../input/slider_crank_fig5_linear.inp', 0.24_wp, 0.28_wp, 1.0e-3_wp)
   call check_errors('../input/slider_crank_fig5_kg.inp', 0.03_wp, 5.5e-2_wp, 1.0e-3_wp)
   call check_errors('../input/slider_crank_exact.inp', 0.0_wp, 2.0e-4_wp, 2.0e-5_wp)

   call check_energy('verification/exact_free.inp', 1.0e-8_wp)
   deallocate (t_exact, w_exact, x_exact)
   call finish()

contains

   !> Runs a deck and opens its history; constraint residuals of the samples are checked for every deck.
   subroutine run(path, reader)
      character(*), intent(in) :: path
      type(history_reader_type), intent(out) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp) :: residual
      character(256) :: results
      call get_command_argument(1, results)
      call run_deck(path, trim(results), .true., .true., report, error)
      call check_no_error(error, path)
      if (allocated(error)) error stop 1
      call reader%open(trim(results), error)
      call check_no_error(error, path//': results')
      call check(reader%complete, path//' is marked complete')
      call reader%read_statistic('position_residual', residual, error)
      call check_close(residual, 0.0_wp, 1.0e-10_wp, path//' position residual of the samples')
      call reader%read_statistic('velocity_residual', residual, error)
      call check_close(residual, 0.0_wp, 1.0e-8_wp, path//' velocity residual of the samples')
   end subroutine run

   function channel(reader, name) result(values)
      type(history_reader_type), intent(in) :: reader
      character(*), intent(in) :: name
      real(wp), allocatable :: values(:), table(:, :)
      type(error_type), allocatable :: error
      call reader%read_channel(name, table, error)
      call check_no_error(error, name)
      allocate (values(size(table, 2)), source=table(1, :))
   end function channel

   subroutine check_extremes(path, highest, lowest)
      character(*), intent(in) :: path
      real(wp), intent(in) :: highest, lowest
      type(history_reader_type) :: reader
      real(wp), allocatable :: w(:)
      call run(path, reader)
      allocate (w, source=channel(reader, 'deflection_over_length'))
      call check_close(maxval(w), highest, 5.0e-3_wp*highest, path//' highest deflection')
      call check_close(minval(w), lowest, -5.0e-3_wp*lowest, path//' lowest deflection')
      call reader%close()
   end subroutine check_extremes

   !> Errors relative to the largest value of the reference, over all samples.
   subroutine check_errors(path, least, most, most_slider)
      character(*), intent(in) :: path
      !> Bounds of the error of the deflection, and of the slider
      real(wp), intent(in) :: least, most, most_slider
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: t(:), w(:), x(:)
      real(wp) :: wrong
      call run(path, reader)
      call reader%read_time(t, error)
      allocate (w, source=channel(reader, 'deflection_over_length'))
      allocate (x, source=channel(reader, 'slider_x'))
      call check(size(t) == size(t_exact), path//' number of samples')
      if (size(t) /= size(t_exact)) return
      call check(maxval(abs(t - t_exact)) <= 1.0e-12_wp, path//' times of the samples')
      wrong = maxval(abs(w - w_exact))/maxval(abs(w_exact))
      print '(2a,2es10.2)', path, ': errors of deflection and slider', wrong, maxval(abs(x - x_exact))/maxval(abs(x_exact))
      call check_close(wrong, 0.5_wp*(least + most), 0.5_wp*(most - least), path//' error of the deflection')
      call check_close(maxval(abs(x - x_exact))/maxval(abs(x_exact)), 0.0_wp, most_slider, path//' error of the slider')
      call reader%close()
   end subroutine check_errors

   !> Mechanical energy of a scene that nothing drives, over all samples.
   subroutine check_energy(path, tolerance)
      character(*), intent(in) :: path
      real(wp), intent(in) :: tolerance
      type(history_reader_type) :: reader
      real(wp), allocatable :: energy(:)
      call run(path, reader)
      allocate (energy, source=channel(reader, 'energy'))
      print '(2a,es10.2)', path, ': drift of the energy', maxval(abs(energy - energy(1)))/energy(1)
      call check(energy(1) > 1.0_wp, path//' has energy')
      call check_close(maxval(abs(energy - energy(1)))/energy(1), 0.0_wp, tolerance, path//' drift of the energy')
      call reader%close()
   end subroutine check_energy

   subroutine read_reference(path)
      character(*), intent(in) :: path
      integer :: unit, status, i
      real(wp) :: row(7)
      allocate (t_exact(839), w_exact(839), x_exact(839))
      open (newunit=unit, file=path, action='read', status='old', iostat=status)
      call check(status == 0, path//' opens')
      read (unit, *)
      do i = 1, size(t_exact)
         read (unit, *) row
         t_exact(i) = row(1)
         w_exact(i) = row(3)
         x_exact(i) = row(4)
      end do
      close (unit)
   end subroutine read_reference

end program test_slider_crank
