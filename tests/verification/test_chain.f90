!> Chains made by *REPEAT: N four-bars through their folded positions against the equation of their one degree of freedom (IFToMM
!> benchmark A02); chains of rigid bars against their equations in angles, integrated here; a chain of stiff beams against the rigid
!> one. Usage, in tests/: test_chain RESULT_FILE
program test_chain
   use limber_base_kinds, only: wp
   use limber_base_lapack, only: dgetrf, dgetrs
   use limber_base_text, only: as_text
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_changed, channel
   use testing, only: check, check_close, finish
   implicit none
   real(wp), parameter :: gravity = 9.81_wp, pi = acos(-1.0_wp)
   character(256) :: results

   call get_command_argument(1, results)
   call check_four_bars(1)
   call check_four_bars(2)
   call check_four_bars(40)
   call check_pendulum(2, 'ADAMS', 1.0e-9_wp)
   call check_pendulum(3, 'RADAU', 1.0e-8_wp)
   call check_pendulum(12, 'ADAMS', 1.0e-8_wp)
   call check_pendulum(12, 'CONSERVING', 2.0e-4_wp)
   call check_pendulum(12, 'ALPHA', 2.0e-3_wp)
   call check_stiff_beams(3)
   call finish()

contains

   !> Upper end of the first upright over 20 s, and the energy.
   subroutine check_four_bars(n)
      integer, intent(in) :: n
      type(history_reader_type) :: reader
      real(wp), allocatable :: x(:), y(:), energy(:)
      real(wp) :: theta, omega, error
      integer :: i, j
      integer, parameter :: parts = 20
      character(32) :: word(1)
      word(1) = 'N = '//as_text(n)
      call run_changed('../input/four_bar_chain.inp', trim(results), ['N = 40'], word, reader)
      allocate (x, source=channel(reader, 'x_b0'))
      allocate (y, source=channel(reader, 'y_b0'))
      allocate (energy, source=channel(reader, 'energy'))
      theta = 0.5_wp*pi
      omega = -1.0_wp
      error = 0.0_wp
      do i = 1, size(x)
         error = max(error, hypot(x(i) - cos(theta), y(i) - sin(theta)))
         do j = 1, parts
            call swing(n, 20.0_wp/(size(x) - 1)/parts, theta, omega)
         end do
      end do
      print '(a,i0,a,2es10.2)', 'four-bars, N = ', n, ': error of B0, change of energy', error, maxval(abs(energy/energy(1) - 1))
      call check_close(error, 0.0_wp, 1.0e-3_wp, 'N = '//as_text(n)//': place of B0')
      call check_close(maxval(abs(energy/energy(1) - 1)), 0.0_wp, 1.0e-5_wp, 'N = '//as_text(n)//': energy')
      ! Published: IFToMM for N = 2; two formulations in quadruple precision for N = 40
      if (n == 2) call check_close(x(501), 0.328458111540815_wp, 1.0e-3_wp, 'N = 2: x at 10 s')
      if (n == 40) then
         call check_close(x(501), 0.180512227_wp, 1.0e-3_wp, 'N = 40: x at 10 s')
         call check_close(x(1001), 0.4109011538_wp, 1.0e-3_wp, 'N = 40: x at 20 s')
         call check_close(y(1001), 0.9116799010_wp, 1.0e-3_wp, 'N = 40: y at 20 s')
      end if
      call reader%close()
      deallocate (x, y, energy)
   end subroutine check_four_bars

   !> A step of Runge and Kutta for the parallelograms.
   subroutine swing(n, h, theta, omega)
      integer, intent(in) :: n
      real(wp), intent(in) :: h
      real(wp), intent(inout) :: theta, omega
      real(wp) :: k(4), w(4), factor
      factor = -((n + 1)/2.0_wp + n)/((n + 1)/3.0_wp + n)*gravity
      w(1) = omega
      k(1) = factor*cos(theta)
      w(2) = omega + 0.5_wp*h*k(1)
      k(2) = factor*cos(theta + 0.5_wp*h*w(1))
      w(3) = omega + 0.5_wp*h*k(2)
      k(3) = factor*cos(theta + 0.5_wp*h*w(2))
      w(4) = omega + h*k(3)
      k(4) = factor*cos(theta + h*w(3))
      theta = theta + h/6*(w(1) + 2*w(2) + 2*w(3) + w(4))
      omega = omega + h/6*(k(1) + 2*k(2) + 2*k(3) + k(4))
   end subroutine swing

   !> Free end of a chain over a second, at every sample.
   subroutine check_pendulum(n, integrator, allowed)
      integer, intent(in) :: n
      character(*), intent(in) :: integrator
      real(wp), intent(in) :: allowed
      type(history_reader_type) :: reader
      real(wp), allocatable :: end(:, :)
      real(wp) :: error
      character(32) :: words(2)
      words(1) = 'N = '//as_text(n)
      words(2) = 'INTEGRATOR='//integrator
      call run_changed('../input/chain_rigid.inp', trim(results), [character(32) :: 'N = 100', 'INTEGRATOR=ADAMS'], words, reader)
      call swing_chain(n, 0.0_wp, 100, end)
      error = distance(reader, n, end)
      print '(2a,i0,a,es10.2)', integrator, ', chain of ', n, ' bars: error of the free end', error
      call check_close(error, 0.0_wp, allowed, integrator//', chain of '//as_text(n)//' bars')
      call check(abs(end(2, 101)) > 1.0_wp, 'the chain has fallen')
      call reader%close()
      deallocate (end)
   end subroutine check_pendulum

   !> Beams that hardly bend.
   subroutine check_stiff_beams(n)
      integer, intent(in) :: n
      type(history_reader_type) :: reader
      real(wp), allocatable :: end(:, :)
      real(wp) :: error
      character(32) :: words(2)
      words(1) = 'N = '//as_text(n)
      words(2) = 'HEIGHT=0.2'
      call run_changed('../input/chain_flexible.inp', trim(results), [character(32) :: 'N = 100', 'HEIGHT=0.005'], words, reader)
      ! The lumped mass of ten elements is that of a bar with a moment of inertia of (1/12) (1 + 2/100) about its middle
      call swing_chain(n, 0.02_wp/12, 100, end)
      error = distance(reader, n, end)
      print '(a,i0,a,es10.2)', 'Chain of ', n, ' stiff beams: error of the free end', error
      call check_close(error, 0.0_wp, 2.0e-3_wp, 'chain of stiff beams')
      call reader%close()
      deallocate (end)
   end subroutine check_stiff_beams

   !> Largest distance of the free end from where it should be.
   real(wp) function distance(reader, n, end)
      type(history_reader_type), intent(in) :: reader
      integer, intent(in) :: n
      real(wp), intent(in) :: end(:, :)
      real(wp), allocatable :: x(:), y(:)
      integer :: i
      allocate (x, source=channel(reader, 'x_bar'//as_text(n)//'_end'))
      allocate (y, source=channel(reader, 'y_bar'//as_text(n)//'_end'))
      call check(size(x) == size(end, 2), 'number of samples')
      distance = 0.0_wp
      do i = 1, size(x)
         distance = max(distance, hypot(x(i) - end(1, i), y(i) - end(2, i)))
      end do
   end function distance

   !> The free end of a chain of uniform bars of 1 m and 1 kg, each with a further moment of inertia, released along the
   !> horizontal, at equal intervals of a second: its equations in the angles of the bars by Runge and Kutta.
   subroutine swing_chain(n, more, intervals, end)
      integer, intent(in) :: n, intervals
      real(wp), intent(in) :: more
      !> (2, intervals + 1)
      real(wp), allocatable, intent(out) :: end(:, :)
      integer, parameter :: parts = 20
      real(wp) :: theta(n), omega(n), k(n, 4), w(n, 4), h
      integer :: i, j
      allocate (end(2, intervals + 1))
      theta = 0.0_wp
      omega = 0.0_wp
      h = 1.0_wp/intervals/parts
      do i = 1, intervals + 1
         end(:, i) = [sum(cos(theta)), sum(sin(theta))]
         do j = 1, parts
            w(:, 1) = omega
            call turn_bars(more, theta, w(:, 1), k(:, 1))
            w(:, 2) = omega + 0.5_wp*h*k(:, 1)
            call turn_bars(more, theta + 0.5_wp*h*w(:, 1), w(:, 2), k(:, 2))
            w(:, 3) = omega + 0.5_wp*h*k(:, 2)
            call turn_bars(more, theta + 0.5_wp*h*w(:, 2), w(:, 3), k(:, 3))
            w(:, 4) = omega + h*k(:, 3)
            call turn_bars(more, theta + h*w(:, 3), w(:, 4), k(:, 4))
            theta = theta + h/6*(w(:, 1) + 2*w(:, 2) + 2*w(:, 3) + w(:, 4))
            omega = omega + h/6*(k(:, 1) + 2*k(:, 2) + 2*k(:, 3) + k(:, 4))
         end do
      end do
   end subroutine swing_chain

   !> Angular accelerations of the bars, from Lagrange's equations.
   subroutine turn_bars(more, theta, omega, alpha)
      real(wp), intent(in) :: more, theta(:), omega(:)
      real(wp), intent(out) :: alpha(:)
      real(wp) :: matrix(size(theta), size(theta)), factor
      integer :: pivots(size(theta)), i, j, n, info
      n = size(theta)
      do i = 1, n
         alpha(i) = -(n - i + 0.5_wp)*gravity*cos(theta(i))
         do j = 1, n
            factor = n - max(i, j) + 0.5_wp
            if (i == j) factor = n - i + 1.0_wp/3 + more
            matrix(i, j) = factor*cos(theta(i) - theta(j))
            if (i /= j) alpha(i) = alpha(i) - factor*sin(theta(i) - theta(j))*omega(j)**2
         end do
      end do
      call dgetrf(n, n, matrix, n, pivots, info)
      call dgetrs('N', n, 1, matrix, n, pivots, alpha, n, info)
      if (info /= 0) call check(.false., 'equations of the chain')
   end subroutine turn_bars

end program test_chain
