!> Modal response to forces on a given motion. Small vibrations about it, coordinate by coordinate in the modes of the whole scene,
!> and the first one with a stiffness that changes in time. What an advice needs to know of a scene before it runs; plain numbers.
!> Floor: accuracy. Equations: doc/theory, part 7.
module limber_accuracy_modal_response
   use limber_base_kinds, only: wp
   use limber_base_finite, only: dsyev, dgetrf, dgetrs
   implicit none
   private
   public :: follow_forces, follow_first, vibration_modes, frequency_shifts

   !> Mobility of a coordinate that does not move; one that nothing holds has 1
   real(wp), parameter :: unmoved = 1.0e-9_wp

contains

   !> Frequencies of the scene's modes: eigenvalues of K^(1/2) A K^(1/2), eq. (7.73).
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

   !> By how much coordinates that follow lower the frequencies of bending: of each bending coordinate the shift of the mode that it
   !> takes part in most, or of one of nearly the same frequency, with all other coordinates held and with some of these free, eq.
   !> (7.80).
   subroutine frequency_shifts(mobility, stiffness, bends, frees, shifts)
      !> Accelerations (n) of the coordinates that a force on each of them makes (n, n); their stiffness (n) [1/time^2]
      real(wp), intent(in) :: mobility(:, :), stiffness(:)
      !> Which coordinates are those of bending, and which others are free (n)
      logical, intent(in) :: bends(:), frees(:)
      !> Lost frequency of each coordinate, 0 of those that do not bend (n) [1/time]
      real(wp), intent(out) :: shifts(:)
      real(wp), allocatable :: held(:, :), free(:, :), square(:), vectors(:, :), with(:), scratch(:, :)
      integer, allocatable :: bending(:), all_free(:)
      !> Modes whose frequencies differ by no more than this part share their motions
      real(wp), parameter :: near = 0.05_wp
      integer :: i, k, n, none
      logical :: done
      shifts = 0.0_wp
      allocate (bending(count(bends)), all_free(count(bends .or. frees)))
      bending = pack([(i, i=1, size(bends))], bends)
      all_free = pack([(i, i=1, size(bends))], bends .or. frees)
      allocate (held(size(bending), size(bending)), free(size(all_free), size(all_free)), square(size(bending)), &
         & vectors(size(bending), size(bending)), with(size(all_free)), scratch(size(all_free), size(all_free)))
      call hold_others(mobility, bends, held, done)
      if (done) call hold_others(mobility, bends .or. frees, free, done)
      if (done) call vibration_modes(held, stiffness(bending), square, vectors, done)
      if (done) call vibration_modes(free, stiffness(all_free), with, scratch, done)
      if (.not. done) return
      ! What the constraints hold has no mobility, and the frequency zero in this form: it stands first
      none = count(with < unmoved*minval(stiffness)) - count(square < unmoved*minval(stiffness))
      n = min(size(square), size(with) - none)
      if (none < 0) return
      square = sqrt(max(square, 0.0_wp))
      with = sqrt(max(with, 0.0_wp))
      do i = 1, n
         k = maxloc(abs(vectors(i, :)), 1)
         shifts(bending(i)) = max(0.0_wp, maxval(square(:n) - with(1 + none:n + none), &
            & abs(square(:n) - square(k)) <= near*square(k)))
      end do
   end subroutine frequency_shifts

   !> Mobility of some coordinates with all others held.
   subroutine hold_others(mobility, kept, held, done)
      !> Of all coordinates (n, n); which are kept (n)
      real(wp), intent(in) :: mobility(:, :)
      logical, intent(in) :: kept(:)
      !> Of those that are kept, in their order
      real(wp), intent(out) :: held(:, :)
      logical, intent(out) :: done
      real(wp), allocatable :: among(:, :), across(:, :)
      integer, allocatable :: stay(:), go(:), pivots(:)
      integer :: i, info
      allocate (stay(count(kept)), go(count(.not. kept)), pivots(count(.not. kept)))
      stay = pack([(i, i=1, size(kept))], kept)
      go = pack([(i, i=1, size(kept))], .not. kept)
      allocate (among(size(go), size(go)), across(size(go), size(stay)))
      held = mobility(stay, stay)
      done = .true.
      if (size(go) == 0) return
      among = mobility(go, go)
      across = mobility(go, stay)
      ! Coordinates that the constraints hold have no mobility
      do i = 1, size(go)
         among(i, i) = among(i, i) + 1.0e-3_wp*unmoved
      end do
      call dgetrf(size(go), size(go), among, size(go), pivots, info)
      if (info == 0) call dgetrs('N', size(go), size(stay), among, size(go), pivots, across, size(go), info)
      done = info == 0
      if (done) held = held - matmul(mobility(stay, go), across)
   end subroutine hold_others

   !> Coordinates that forces make from rest: each mode answers a force that is linear between the samples
   !> exactly, eq. (7.74).
   subroutine follow_forces(times, forces, stiffness, square, vectors, eta, speed, balanced, swing)
      !> Times (samples); forces on the coordinates at each (n, samples)
      real(wp), intent(in) :: times(:), forces(:, :)
      !> Stiffness of the coordinates, modes of the scene (n), (n), (n, n)
      real(wp), intent(in) :: stiffness(:), square(:), vectors(:, :)
      !> Coordinates (n, samples), and the largest speed of each (n)
      real(wp), intent(out) :: eta(:, :), speed(:)
      !> Whether they begin in balance with the first forces, not at zero
      logical, intent(in), optional :: balanced
      !> Largest part of each that is vibration about its value at rest (n)
      real(wp), intent(out), optional :: swing(:)
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
      if (present(balanced)) x = merge(static, x, balanced)
      eta(:, 1) = matmul(shapes, x)
      speed = 0.0_wp
      if (present(swing)) swing = 0.0_wp
      call take_swing()
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
         call take_swing()
      end do

   contains

      !> Takes in the vibrations at a sample. What the constraints hold does not vibrate.
      subroutine take_swing()
         if (present(swing)) swing = max(swing, &
            & abs(matmul(shapes, merge(x - static, 0.0_wp, square > unmoved*minval(stiffness)))))
      end subroutine take_swing

   end subroutine follow_forces

   !> The first coordinate alone, with and without the stiffness that the axial force adds: largest magnitude with it, and largest
   !> difference, eq. (7.75).
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

end module limber_accuracy_modal_response
