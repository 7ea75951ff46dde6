!> How deflections follow forces on a motion that they do not change: small vibrations about it, coordinate by coordinate in the
!> modes of the whole scene, and the first one with a stiffness that changes in time. What an advice needs to know of a scene
!> before it runs; plain numbers. Floor: analysis. Equations: doc/theory.md, accuracy on request.
module limber_analysis_shadow
   use limber_base_kinds, only: wp
   use limber_base_finite, only: dsyev
   implicit none
   private
   public :: follow_forces, follow_first, vibration_modes

contains

   !> Frequencies of the scene's modes: eigenvalues of K^(1/2) A K^(1/2), eq. (170).
   subroutine vibration_modes(mobility, stiffness, square, vectors, done)
      !> Accelerations (n) of the coordinates that a force on each of them makes (n, n)
      real(wp), intent(in) :: mobility(:, :)
      !> Stiffness of each coordinate (n) [1/time^2]
      real(wp), intent(in) :: stiffness(:)
      !> Squared frequencies, ascending (n), and vectors (n, n)
      real(wp), intent(out) :: square(:), vectors(:, :)
      logical, intent(out) :: done
      real(wp), allocatable :: work(:)
      integer :: j, n, info
      n = size(stiffness)
      allocate (work(max(1, 8*n)))
      do j = 1, n
         vectors(:, j) = sqrt(stiffness)*0.5_wp*(mobility(:, j) + mobility(j, :))*sqrt(stiffness(j))
      end do
      call dsyev('V', 'L', n, vectors, max(1, n), square, work, size(work), info)
      done = info == 0
   end subroutine vibration_modes

   !> Coordinates that forces make from rest: each mode answers a force that is linear between the samples
   !> exactly, eq. (171).
   subroutine follow_forces(times, forces, stiffness, square, vectors, eta, speed)
      !> Times (samples); forces on the coordinates at each (n, samples)
      real(wp), intent(in) :: times(:), forces(:, :)
      !> Stiffness of the coordinates, modes of the scene (n), (n), (n, n)
      real(wp), intent(in) :: stiffness(:), square(:), vectors(:, :)
      !> Coordinates (n, samples), and the largest speed of each (n)
      real(wp), intent(out) :: eta(:, :), speed(:)
      real(wp) :: static(size(stiffness)), before(size(stiffness)), x(size(stiffness)), v(size(stiffness)), slope, h, omega, c, s
      real(wp) :: gap, shapes(size(stiffness), size(stiffness))
      integer :: i, k
      do i = 1, size(x)
         shapes(:, i) = vectors(:, i)/sqrt(stiffness)
      end do
      x = 0.0_wp
      v = 0.0_wp
      before = matmul(forces(:, 1), shapes)
      static = before
      eta(:, 1) = 0.0_wp
      speed = 0.0_wp
      do k = 2, size(times)
         static = matmul(forces(:, k), shapes)
         h = times(k) - times(k - 1)
         do i = 1, size(x)
            omega = sqrt(max(square(i), 0.0_wp))
            if (.not. (h > 0.0_wp .and. omega > 0.0_wp)) cycle
            slope = (static(i) - before(i))/h
            c = cos(omega*h)
            s = sin(omega*h)
            gap = x(i) - before(i)
            x(i) = static(i) + gap*c + (v(i) - slope)/omega*s
            v(i) = slope - gap*omega*s + (v(i) - slope)*c
         end do
         before = static
         eta(:, k) = matmul(shapes, x)
         speed = max(speed, abs(matmul(shapes, v)))
      end do
   end subroutine follow_forces

   !> The first coordinate alone, with and without the stiffness that the axial force adds: largest magnitude with it, and largest
   !> difference, eq. (172).
   subroutine follow_first(times, force, square, extra, softening, largest, difference)
      !> Times, acceleration that the force makes, what the axial force adds to the squared frequency, and what rotation takes
      !> from it (samples)
      real(wp), intent(in) :: times(:), force(:), extra(:), softening(:)
      !> Squared frequency
      real(wp), intent(in) :: square
      real(wp), intent(out) :: largest, difference
      integer, parameter :: most = 20000, in_a_turn = 30
      real(wp) :: with(2), without(2), h, part, f, k_with, k_without, fastest, limit
      integer :: i, j, steps
      with = 0.0_wp
      without = 0.0_wp
      largest = 0.0_wp
      difference = 0.0_wp
      fastest = sqrt(max(square + max(maxval(extra), 0.0_wp), tiny(square)))
      limit = 2*acos(-1.0_wp)/(in_a_turn*fastest)
      if ((times(size(times)) - times(1))/limit > most) limit = (times(size(times)) - times(1))/most
      do i = 2, size(times)
         steps = max(1, ceiling((times(i) - times(i - 1))/limit))
         h = (times(i) - times(i - 1))/steps
         do j = 1, steps
            part = (j - 0.5_wp)/steps
            f = force(i - 1) + part*(force(i) - force(i - 1))
            k_without = square - (softening(i - 1) + part*(softening(i) - softening(i - 1)))
            k_with = k_without + extra(i - 1) + part*(extra(i) - extra(i - 1))
            call turn_by(k_with, f, h, with)
            call turn_by(k_without, f, h, without)
            if (abs(without(1)) > 1.0e9_wp*(abs(with(1)) + tiny(part))) without = 0.5_wp*without
         end do
         largest = max(largest, abs(with(1)))
         difference = max(difference, abs(with(1) - without(1)))
      end do
   end subroutine follow_first

   !> One step of x'' = f - k x with constant f and k, exactly; growing if k is negative.
   pure subroutine turn_by(k, f, h, x)
      real(wp), intent(in) :: k, f, h
      !> Place and velocity
      real(wp), intent(inout) :: x(2)
      real(wp) :: omega, c, s, rest
      omega = sqrt(abs(k))
      if (omega*h < 1.0e-6_wp) then
         x = [x(1) + h*x(2) + 0.5_wp*h**2*f, x(2) + h*f]
         return
      end if
      if (k > 0.0_wp) then
         c = cos(omega*h)
         s = sin(omega*h)/omega
      else
         c = cosh(omega*h)
         s = sinh(omega*h)/omega
      end if
      rest = x(1) - f/k
      x = [f/k + rest*c + x(2)*s, x(2)*c - k*rest*s]
   end subroutine turn_by

end module limber_analysis_shadow
