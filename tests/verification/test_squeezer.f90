!> Andrews' squeezing mechanism, seven rigid bodies with a spring and a torque, against a solution in quadruple precision
!> (tests/reference/andrews_squeezer.csv), by all integrators. Usage, in tests/: test_squeezer RESULT_FILE
program test_squeezer
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_changed, channel, read_columns
   use testing, only: check, check_close, finish
   implicit none

   !> Columns time and the seven angles
   character(*), parameter :: names(7) = [character(7) :: 'beta', 'theta', 'gamma', 'phi', 'delta', 'omega', 'epsilon']
   real(wp), parameter :: last(7) = [15.810771195153707_wp, -15.756371058411839_wp, 0.040822240119645805_wp, &
      & -0.53473011634207959_wp, 0.52440996587995407_wp, 0.53473011634207959_wp, 1.0480807410419379_wp]
   real(wp) :: exact(8, 301)
   character(256) :: results

   call get_command_argument(1, results)
   call read_columns('reference/andrews_squeezer.csv', exact)
   call check_angles('ADAMS', '1e-12')
   call check_angles('RADAU', '1e-10')
   call check_samples('ADAMS', '1e-4', 300, 0.5_wp)
   call check_samples('ADAMS', '1e-6', 300, 0.5_wp)
   ! Many in a step: joints on pins are linear in the frames' vectors, and kept by an interpolation of these that errs
   call check_samples('ADAMS', '1e-6', 3000, 0.02_wp)
   call finish()

contains

   subroutine check_angles(integrator, tolerance)
      character(*), intent(in) :: integrator, tolerance
      type(history_reader_type) :: reader
      real(wp), allocatable :: angle(:), energy(:)
      character(:), allocatable :: title
      real(wp) :: largest, largest_at_end
      integer :: i
      title = integrator//' at '//tolerance//': '
      call run_changed('../input/andrews_squeezer.inp', trim(results), [character(16) :: 'INTEGRATOR=ADAMS', 'TOLERANCE=1e-8'], &
         & [character(16) :: 'INTEGRATOR='//integrator, 'TOLERANCE='//tolerance], reader)
      largest = 0.0_wp
      largest_at_end = 0.0_wp
      do i = 1, size(names)
         allocate (angle, source=channel(reader, trim(names(i))))
         call check(size(angle) == size(exact, 2), title//'number of samples')
         if (size(angle) /= size(exact, 2)) return
         largest = max(largest, maxval(abs(angle - exact(1 + i, :))))
         largest_at_end = max(largest_at_end, abs(angle(size(angle)) - last(i)))
         call check_close(angle(1), exact(1 + i, 1), 1.0e-14_wp, title//trim(names(i))//' at the start')
         call check_close(angle(size(angle)), last(i), 1.0e-9_wp, title//trim(names(i))//' at the end')
         deallocate (angle)
      end do
      call check_close(largest, 0.0_wp, 1.0e-9_wp, title//'all samples')
      allocate (energy, source=channel(reader, 'energy'))
      print '(2a,3es10.2)', title, 'errors at the end and over all samples, energy', largest_at_end, largest, &
         & maxval(abs(energy - energy(1)))
      call check_close(maxval(abs(energy - energy(1))), 0.0_wp, 1.0e-9_wp, title//'balance of energy and work')
      call reader%close()
   end subroutine check_angles

   !> Samples of places alone, which are moved onto the joints as far as the tolerance asks, are those of a run that moves each of
   !> them all the way, for it shows a speed too.
   subroutine check_samples(integrator, tolerance, outputs, part)
      character(*), intent(in) :: integrator, tolerance
      !> Samples behind the first one; part of the tolerance by which they may differ
      integer, intent(in) :: outputs
      real(wp), intent(in) :: part
      type(history_reader_type) :: reader
      real(wp) :: places(size(names), outputs + 1), allowed, largest
      character(80) :: old(5), new(5)
      integer :: i
      old = [character(80) :: 'INTEGRATOR=ADAMS', 'TOLERANCE=1e-8', 'spring_tension = tension(spring)', &
         & 'energy = kinetic_energy(system) + potential_energy(system) - work(system)', 'OUTPUTS=300']
      new = [character(80) :: 'INTEGRATOR='//integrator, 'TOLERANCE='//tolerance, 'now = t', 'later = t', &
         & 'OUTPUTS='//as_text(outputs)]
      call run_changed('../input/andrews_squeezer.inp', trim(results), old, new, reader)
      do i = 1, size(names)
         places(i, :) = channel(reader, trim(names(i)))
      end do
      call reader%close()
      new(4) = 'speed = spin(k1)'
      call run_changed('../input/andrews_squeezer.inp', trim(results), old, new, reader)
      largest = 0.0_wp
      do i = 1, size(names)
         largest = max(largest, maxval(abs(channel(reader, trim(names(i))) - places(i, :))))
      end do
      call reader%close()
      read (tolerance, *) allowed
      print '(4a,es10.2)', integrator, ' at ', tolerance, ': samples of places beside those on the joints', largest
      call check_close(largest, 0.0_wp, part*allowed, integrator//' at '//tolerance//': samples of places')
   end subroutine check_samples

end program test_squeezer
