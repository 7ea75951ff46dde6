!> Loads of all kinds at once: the work put in against the change of the energy, energies of springs of any law by the conserving
!> integrator, and a manipulator with motors against an independent solution. Usage, in tests/: test_power RESULT_FILE
program test_power
   use limber_base_kinds, only: wp
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_changed, channel
   use testing, only: check, check_close, finish
   implicit none
   character(256) :: results

   call get_command_argument(1, results)
   call check_balance()
   call check_stored()
   call check_manipulator()
   call finish()

contains

   !> Every load at once, RADAU and ADAMS: the work put in is the change of the energy, and the motion is the same.
   subroutine check_balance()
      character(6), parameter :: names(5) = [character(6) :: 'x', 'y', 'angle', 'rod', 'bead']
      type(history_reader_type) :: reader, other
      real(wp), allocatable :: energy(:), work(:), values(:), again(:)
      integer :: i
      call run_changed('verification/all_loads.inp', trim(results), [character(40) :: 'END=2, TOLERANCE=1e-11'], &
         & [character(40) :: 'END=0.2, TOLERANCE=1e-10'], reader)
      call run_changed('verification/all_loads.inp', trim(results)//'.other', [character(60) :: &
         & 'END=2, TOLERANCE=1e-11, INTEGRATOR=RADAU'], [character(60) :: 'END=0.2, TOLERANCE=1e-11, INTEGRATOR=ADAMS'], other)
      allocate (energy, source=channel(reader, 'energy'))
      allocate (work, source=channel(reader, 'work'))
      print '(a,2es10.2)', 'all loads: change of energy less work, work', maxval(abs(energy - energy(1))), maxval(abs(work))
      call check(maxval(abs(work)) > 2.0_wp, 'all loads: there is work')
      call check_close(maxval(abs(energy - energy(1)))/maxval(abs(work)), 0.0_wp, 1.0e-9_wp, 'all loads: energy less work')
      do i = 1, size(names)
         allocate (values, source=channel(reader, trim(names(i))))
         allocate (again, source=channel(other, trim(names(i))))
         call check_close(maxval(abs(values - again)), 0.0_wp, 1.0e-8_wp, 'all loads: RADAU and ADAMS: '//names(i))
         deallocate (values, again)
      end do
      deallocate (energy, work)
      call reader%close()
      call other%close()
   end subroutine check_balance

   !> Springs of any law, bushings, gaps: the conserving integrator keeps the energy, with steps of any size.
   subroutine check_stored()
      type(history_reader_type) :: reader
      real(wp), allocatable :: energy(:), kinetic(:)
      call run_changed('verification/stored_loads.inp', trim(results), [character(40) :: 'INTEGRATOR=CONSERVING'], &
         & [character(40) :: 'INTEGRATOR=CONSERVING'], reader)
      allocate (energy, source=channel(reader, 'energy'))
      allocate (kinetic, source=channel(reader, 'kinetic'))
      print '(a,2es10.2)', 'stored: change of energy, kinetic energy', maxval(abs(energy - energy(1))), maxval(kinetic)
      call check_close(maxval(abs(energy - energy(1)))/maxval(kinetic), 0.0_wp, 1.0e-11_wp, 'stored: energy')
      deallocate (energy, kinetic)
      call reader%close()
   end subroutine check_stored

   !> The arms rigid: a solution in two angles by a program of its own. Flexible: ADAMS and RADAU, and the energy.
   subroutine check_manipulator()
      type(history_reader_type) :: reader, other
      real(wp), allocatable :: values(:), again(:)
      character(10), parameter :: names(4) = [character(10) :: 'shoulder', 'elbow', 'x_payload', 'y_payload']
      real(wp), parameter :: rigid(4) = [1.3541724736083771_wp, -2.5154278650233417_wp, 0.6131218808222764_wp, &
         & 0.05932494775128183_wp]
      integer :: i
      call run_changed('../input/two_link_manipulator.inp', trim(results)//'.rigid', [character(16) :: 'GEOMETRIC=LINEAR', &
         & 'GEOMETRIC=LINEAR'], [character(16) :: 'GEOMETRIC=RIGID', 'GEOMETRIC=RIGID'], other)
      do i = 1, size(names)
         allocate (values, source=channel(other, trim(names(i))))
         call check_close(values(size(values)), rigid(i), 1.0e-8_wp, 'manipulator, rigid: '//names(i))
         deallocate (values)
      end do
      call other%close()
      call run_changed('../input/two_link_manipulator.inp', trim(results), [character(40) :: 'INTEGRATOR=ADAMS'], &
         & [character(40) :: 'INTEGRATOR=ADAMS'], reader)
      call run_changed('../input/two_link_manipulator.inp', trim(results)//'.radau', [character(40) :: &
         & 'TOLERANCE=1e-8', 'INTEGRATOR=ADAMS'], [character(40) :: 'TOLERANCE=1e-6', 'INTEGRATOR=RADAU'], other)
      do i = 1, size(names)
         allocate (values, source=channel(reader, trim(names(i))))
         allocate (again, source=channel(other, trim(names(i))))
         print '(3a,es10.2)', 'manipulator: ', names(i), ' ADAMS and RADAU differ by', maxval(abs(values - again))
         call check_close(maxval(abs(values - again)), 0.0_wp, 1.0e-6_wp, 'manipulator: '//names(i))
         call check(abs(values(size(values)) - rigid(i)) > 1.0e-3_wp, 'manipulator: flexible is not rigid: '//names(i))
         deallocate (values, again)
      end do
      allocate (values, source=channel(reader, 'energy'))
      call check_close(maxval(abs(values - values(1))), 0.0_wp, 1.0e-8_wp, 'manipulator: energy less work')
      deallocate (values)
      call reader%close()
      call other%close()
   end subroutine check_manipulator

end program test_power
