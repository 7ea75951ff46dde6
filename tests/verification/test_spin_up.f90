!> Spin-up of a cantilever (Simo and Vu-Quoc 1986) against a converged geometrically exact solution
!> (tests/reference/spin_up_beam.csv) and the steady extension of the rotating beam, by all integrators.
!> Usage, in tests/: test_spin_up RESULT_FILE
program test_spin_up
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_changed, channel, read_columns
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   !> Columns time, u1, u2 and rotation of the section at the tip
   real(wp) :: exact(4, 1001)
   character(256) :: results

   call get_command_argument(1, results)
   call read_columns('reference/spin_up_beam.csv', exact)
   call check_errors('../input/spin_up.inp', 'ADAMS', 1.0e-4_wp)
   call check_errors('../input/spin_up.inp', 'RADAU', 1.0e-4_wp)
   call finish()

contains

   !> Largest errors over all samples relative to the largest value.
   subroutine check_errors(path, integrator, most)
      character(*), intent(in) :: path, integrator
      !> Bound of the error of u2
      real(wp), intent(in) :: most
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: t(:), u1(:), u2(:), rotation(:), angle(:), energy(:)
      real(wp) :: wrong(3), steady, k
      call run_changed(path, trim(results), ['INTEGRATOR=ADAMS'], ['INTEGRATOR='//integrator], reader)
      call reader%read_time(t, error)
      call check_no_error(error, path//': times')
      call check(size(t) == size(exact, 2), path//': number of samples')
      if (size(t) /= size(exact, 2)) return
      call check(maxval(abs(t - exact(1, :))) <= 1.0e-12_wp, path//': times of the samples')
      allocate (u1, source=channel(reader, 'u1_tip'))
      allocate (u2, source=channel(reader, 'u2_tip'))
      allocate (rotation, source=channel(reader, 'section_rotation_tip'))
      allocate (angle, source=channel(reader, 'hub_angle'))
      allocate (energy, source=channel(reader, 'energy_balance'))
      wrong = [maxval(abs(u1 - exact(2, :))), maxval(abs(u2 - exact(3, :))), maxval(abs(rotation - exact(4, :)))] &
         & /maxval(abs(exact(2:, :)), dim=2)
      ! L (tan(kL)/(kL) - 1) with k^2 = omega^2 rho A/(E A)
      k = 6*sqrt(1.2_wp/2.8e7_wp)
      steady = 10*(tan(10*k)/(10*k) - 1)
      print '(4a,3es10.2,a,2es10.2)', path, ', ', integrator, ': errors of u1, u2, rotation', wrong, '; extension, energy', &
         & u1(size(u1))/steady - 1, maxval(abs(energy))
      call check_close(wrong(2), 0.0_wp, most, path//': deflection of the tip')
      call check_close(wrong(1), 0.0_wp, 5*most, path//': shortening of the tip')
      call check_close(wrong(3), 0.0_wp, 5*most, path//': rotation of the tip')
      call check_close(u1(size(u1)), steady, 1.0e-3_wp*steady, path//': steady extension')
      call check_close(minval(u2), minval(exact(3, :)), most*maxval(abs(exact(3, :))), path//': largest deflection')
      call check_close(angle(751), 45.0_wp, 1.0e-12_wp, path//': angle of the hub at full speed')
      call check_close(angle(1001), 75.0_wp, 1.0e-12_wp, path//': angle of the hub at the end')
      call check_close(maxval(abs(energy)), 0.0_wp, 1.0e-4_wp, path//': balance of energy and work')
      call reader%close()
   end subroutine check_errors

end program test_spin_up
