!> Small vibrations about a state: the lowest eigenvalues s and shapes of (s^2 M + s D + K) phi = 0 on the motions that the
!> constraints leave. Dense: LAPACK. Floor: system. Source: doc/theory, eqs. (110)-(113); Meirovitch 1967, chapter 9.
module limber_system_vibrations
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_base_finite, only: dsygv, dgeev, dgetrf, dgetrs
   use limber_base_text, only: as_text
   use limber_system_freedom, only: freedom_type, rate_scales
   use limber_system_krylov, only: nearest_eigenvalues, sort, by_mass
   use limber_system_system, only: system_type
   use limber_system_tangent, only: tangent_type
   use limber_system_tangent_products, only: times_mass, times_damping, times_stiffness
   implicit none
   private
   public :: vibrations_type, find_vibrations, find_large_vibrations, find_growth, kind_of_growth, add_rotation_damping, &
      & quadratic_modes, symmetric_modes

   !> Velocity terms that count: none, those that do no work (gyroscopic ones), all
   integer, parameter, public :: no_damping = 0, gyroscopic = 1, all_damping = 2

   !> Modes in ascending |s|, of a conjugate pair that with positive frequency
   type :: vibrations_type
      !> Circular frequency Im s and growth Re s (modes) [rad/time], [1/time]
      real(wp), allocatable :: frequency(:), growth(:)
      !> Shapes in the layout of the rates (nw, modes), phi^H M phi = 1, the largest entry real and positive
      complex(wp), allocatable :: shape(:, :)
   end type vibrations_type

contains

   !> The lowest modes.
   subroutine find_vibrations(system, tangent, freedom, damping, wanted, vibrations, error)
      type(system_type), intent(in) :: system
      !> Mass, damping and stiffness at the state
      type(tangent_type), intent(in) :: tangent
      type(freedom_type), intent(in) :: freedom
      !> Which velocity terms count
      integer, intent(in) :: damping
      !> Most modes
      integer, intent(in) :: wanted
      type(vibrations_type), intent(out) :: vibrations
      !> The eigenvalues could not be found
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: mass(:, :), damper(:, :), stiffness(:, :)
      complex(wp), allocatable :: value(:), vector(:, :)
      logical :: is_symmetric
      integer :: n, j
      n = size(freedom%basis, 2)
      call free_matrices(system, tangent, freedom, mass, damper, stiffness)
      if (damping == no_damping) damper = 0.0_wp
      if (damping == gyroscopic) damper = 0.5_wp*(damper - transpose(damper))
      is_symmetric = n == 0
      if (n > 0) is_symmetric = maxval(abs(stiffness - transpose(stiffness))) <= 1.0e-10_wp*maxval(abs(stiffness)) &
         & .and. maxval(abs(damper)) <= 0.0_wp
      if (is_symmetric) call symmetric_modes(mass, stiffness, wanted, value, vector)
      if (.not. allocated(value)) call quadratic_modes(mass, damper, stiffness, wanted, value, vector)
      if (.not. allocated(value)) then
         call raise(error, 'the eigenvalues of the '//as_text(n)//' free motions are not found (LAPACK)')
         return
      end if
      allocate (vibrations%frequency(size(value)), vibrations%growth(size(value)), vibrations%shape(system%layout%nw, size(value)))
      vibrations%frequency = aimag(value)
      vibrations%growth = real(value, wp)
      do j = 1, size(value)
         call normalise(mass, vector(:, j))
         vibrations%shape(:, j) = cmplx(matmul(freedom%basis, real(vector(:, j), wp)), &
            & matmul(freedom%basis, aimag(vector(:, j))), wp)
         call turn_phase(rate_scales(system), vibrations%shape(:, j))
      end do
   end subroutine find_vibrations

   !> Mass, damping and stiffness on the motions that are left, eq. (101), each (number, number).
   subroutine free_matrices(system, tangent, freedom, mass, damper, stiffness)
      type(system_type), intent(in) :: system
      type(tangent_type), intent(in) :: tangent
      type(freedom_type), intent(in) :: freedom
      real(wp), allocatable, intent(out) :: mass(:, :), damper(:, :), stiffness(:, :)
      real(wp) :: product(system%layout%nw)
      integer :: n, j
      n = size(freedom%basis, 2)
      allocate (mass(n, n), damper(n, n), stiffness(n, n))
      do j = 1, n
         product = 0.0_wp
         call times_mass(system, tangent, 1.0_wp, freedom%basis(:, j), product)
         mass(:, j) = matmul(product, freedom%basis)
         product = 0.0_wp
         call times_damping(system, tangent, 1.0_wp, freedom%basis(:, j), product)
         damper(:, j) = matmul(product, freedom%basis)
         product = 0.0_wp
         call times_stiffness(system, tangent, 1.0_wp, freedom%basis(:, j), product)
         stiffness(:, j) = matmul(product, freedom%basis)
      end do
   end subroutine free_matrices

   !> Whether small motions about a state grow, with all velocity terms, and which grows the fastest.
   subroutine find_growth(system, tangent, freedom, growth, frequency, motion, done)
      type(system_type), intent(in) :: system
      type(tangent_type), intent(in) :: tangent
      type(freedom_type), intent(in) :: freedom
      !> Largest Re s, with its |Im s| [1/time], both zero if none grows; a frequency of zero is divergence, any other is flutter
      real(wp), intent(out) :: growth, frequency
      !> Its real part in the layout of the rates (nw), scaled to unit length; unchanged if none grows
      real(wp), intent(inout) :: motion(:)
      !> False if the eigenvalues are not found
      logical, intent(out) :: done
      real(wp), allocatable :: mass(:, :), damper(:, :), stiffness(:, :)
      complex(wp), allocatable :: value(:), vector(:, :)
      integer :: j, fastest
      growth = 0.0_wp
      frequency = 0.0_wp
      call free_matrices(system, tangent, freedom, mass, damper, stiffness)
      call quadratic_modes(mass, damper, stiffness, 2*size(mass, 1), value, vector)
      done = allocated(value)
      if (.not. done) return
      fastest = 0
      do j = 1, size(value)
         if (kind_of_growth(aimag(value(j)), real(value(j), wp), maxval(abs(damper)) > 0.0_wp) == '') cycle
         if (real(value(j), wp) <= growth) cycle
         growth = real(value(j), wp)
         fastest = j
      end do
      if (fastest == 0) return
      frequency = aimag(value(fastest))
      if (kind_of_growth(frequency, growth, .true.) == 'divergence') frequency = 0.0_wp
      motion = matmul(freedom%basis, real(vector(:, fastest), wp))
      motion = motion/norm2(motion/rate_scales(system))
   end subroutine find_growth

   !> What becomes of a mode: 'flutter' if its vibrations grow, 'divergence' if it grows without vibrating, '' if it does not grow.
   pure function kind_of_growth(frequency, growth, is_damped) result(kind)
      real(wp), intent(in) :: frequency, growth
      !> Without damping two frequencies meet where flutter begins, and round-off is magnified
      logical, intent(in) :: is_damped
      character(:), allocatable :: kind
      !> Growth beside |s| that is round-off: without damping and with
      real(wp), parameter :: none(2) = [1.0e-6_wp, 1.0e-10_wp], no_vibration = 1.0e-6_wp
      kind = ''
      if (.not. growth > merge(none(2), none(1), is_damped)*hypot(frequency, growth)) return
      kind = 'flutter'
      if (abs(frequency) <= no_vibration*growth) kind = 'divergence'
   end function kind_of_growth

   !> The lowest undamped modes of a large scene with a symmetric stiffness, by ARPACK.
   subroutine find_large_vibrations(system, tangent, wanted, vibrations, error)
      type(system_type), intent(in) :: system
      !> Its matrix is factored anew
      type(tangent_type), intent(inout) :: tangent
      integer, intent(in) :: wanted
      type(vibrations_type), intent(out) :: vibrations
      !> No convergence
      type(error_type), allocatable, intent(out) :: error
      !> Part of the largest that is the round-off of rigid motions
      real(wp), parameter :: nothing = 1.0e-11_wp
      real(wp), allocatable :: value(:), motion(:, :), product(:)
      real(wp) :: shift
      logical :: done
      integer :: count, j
      count = min(wanted, system%layout%nw - system%nc - 1)
      allocate (value(count), motion(system%layout%nw, count), product(system%layout%nw))
      call nearest_eigenvalues(system, tangent, by_mass, 0.0_wp, count, value, motion, done)
      if (.not. done) then
         ! Something moves freely: a shift below zero
         shift = -1.0e-8_wp*maxval(abs(tangent%parts(:, 3)))/maxval(abs(tangent%parts(:, 1)))
         call nearest_eigenvalues(system, tangent, by_mass, min(shift, -tiny(shift)), count, value, motion, done)
      end if
      if (.not. done) then
         call raise(error, 'the eigenvalues of the scene are not found (ARPACK)')
         return
      end if
      where (abs(value) <= nothing*maxval(abs(value))) value = 0.0_wp
      allocate (vibrations%frequency(count), vibrations%growth(count), vibrations%shape(system%layout%nw, count))
      vibrations%frequency = sqrt(max(value, 0.0_wp))
      vibrations%growth = sqrt(max(-value, 0.0_wp))
      do j = 1, count
         product = 0.0_wp
         call times_mass(system, tangent, 1.0_wp, motion(:, j), product)
         vibrations%shape(:, j) = cmplx(motion(:, j)/sqrt(max(dot_product(product, motion(:, j)), tiny(1.0_wp))), 0.0_wp, wp)
         call turn_phase(rate_scales(system), vibrations%shape(:, j))
      end do
   end subroutine find_large_vibrations

   !> Adds what a steady rotation adds to the damping of a body, whose place is told in turning axes: 2 speed M J on r.
   pure subroutine add_rotation_damping(speed, mass, damping)
      real(wp), intent(in) :: speed, mass(:, :)
      real(wp), intent(inout) :: damping(:, :)
      damping(:, 1) = damping(:, 1) + 2*speed*mass(:, 2)
      damping(:, 2) = damping(:, 2) - 2*speed*mass(:, 1)
   end subroutine add_rotation_damping

   !> Unit modal mass, unless the shape has none.
   pure subroutine normalise(mass, vector)
      real(wp), intent(in) :: mass(:, :)
      complex(wp), intent(inout) :: vector(:)
      real(wp) :: modal
      integer :: j
      modal = 0.0_wp
      do j = 1, size(vector)
         modal = modal + real(conjg(vector(j))*sum(mass(:, j)*vector), wp)
      end do
      if (modal > 0.0_wp) vector = vector/sqrt(modal)
   end subroutine normalise

   !> Turns the phase so that the largest entry, each relative to its scale, is real and positive.
   pure subroutine turn_phase(scale, shape)
      real(wp), intent(in) :: scale(:)
      complex(wp), intent(inout) :: shape(:)
      integer :: i
      i = maxloc(abs(shape)/scale, 1)
      if (abs(shape(i)) > 0.0_wp) shape = shape*conjg(shape(i))/abs(shape(i))
   end subroutine turn_phase

   !> Modes of K phi = omega^2 M phi, both symmetric, lowest |omega^2| first. M may be singular if K is definite. Nothing is
   !> allocated if neither is definite.
   subroutine symmetric_modes(mass, stiffness, wanted, value, vector)
      !> (n, n)
      real(wp), intent(in) :: mass(:, :), stiffness(:, :)
      integer, intent(in) :: wanted
      !> s = sqrt(-omega^2) (modes), shapes (n, modes)
      complex(wp), allocatable, intent(out) :: value(:), vector(:, :)
      !> Part of the shift below which omega^2 is the round-off of a rigid motion
      real(wp), parameter :: nothing = 1.0e-12_wp
      real(wp) :: omega2(size(mass, 1)), shape(size(mass, 1), size(mass, 1)), shift
      logical :: done
      integer :: count, j
      ! The lowest frequencies are the largest eigenvalues of M against K: they are not lost in the rounding of the highest
      shift = 0.0_wp
      call inverse_modes(mass, stiffness, shift, count, omega2, shape, done)
      if (.not. done) then
         call direct_modes(mass, stiffness, omega2, shape, done)
         if (.not. done) return
         count = size(omega2)
         if (any(omega2 > 0.0_wp)) then
            shift = least_stiff(omega2)
            call inverse_modes(mass, stiffness, shift, count, omega2, shape, done)
            if (.not. done) call direct_modes(mass, stiffness, omega2, shape, done)
            if (count < size(omega2)) call direct_modes(mass, stiffness, omega2, shape, done)
            count = size(omega2)
         end if
      end if
      count = min(count, wanted)
      allocate (value(count), vector(size(mass, 1), count))
      do j = 1, count
         if (abs(omega2(j)) <= nothing*shift) omega2(j) = 0.0_wp
         value(j) = cmplx(0.0_wp, sqrt(abs(omega2(j))), wp)
         if (omega2(j) < 0.0_wp) value(j) = cmplx(sqrt(-omega2(j)), 0.0_wp, wp)
         vector(:, j) = shape(:, j)
      end do
   end subroutine symmetric_modes

   !> The least omega^2 of an elastic motion, beside which those of rigid motions are the rounding of the largest.
   pure real(wp) function least_stiff(omega2)
      !> Some of them positive
      real(wp), intent(in) :: omega2(:)
      real(wp), parameter :: rounding = 1.0e-11_wp
      least_stiff = minval(omega2, mask=omega2 > rounding*maxval(omega2))
   end function least_stiff

   !> By the eigenvalues 1/(omega^2 + shift) of M against K + shift M, the lowest omega^2 first.
   subroutine inverse_modes(mass, stiffness, shift, count, omega2, shape, done)
      !> (n, n), and the shift
      real(wp), intent(in) :: mass(:, :), stiffness(:, :), shift
      !> Motions with mass
      integer, intent(out) :: count
      !> (n), (n, n): the first `count` of them
      real(wp), intent(out) :: omega2(:), shape(:, :)
      !> False if K + shift M is not definite beyond round-off
      logical, intent(out) :: done
      !> Parts that are round-off: of the largest eigenvalue; a pivot beside its diagonal entry
      real(wp), parameter :: no_mass = 1.0e-14_wp, no_pivot = 100*epsilon(1.0_wp)
      real(wp) :: a(size(mass, 1), size(mass, 1)), b(size(mass, 1), size(mass, 1)), theta(size(mass, 1)), &
         & scratch(64*size(mass, 1) + 64), diagonal(size(mass, 1))
      integer :: n, info, j
      n = size(mass, 1)
      a = 0.5_wp*(mass + transpose(mass))
      b = 0.5_wp*(stiffness + transpose(stiffness)) + shift*a
      diagonal = [(b(j, j), j=1, n)]
      omega2 = 0.0_wp
      shape = 0.0_wp
      count = 0
      call dsygv(1, 'V', 'L', n, a, n, b, n, theta, scratch, size(scratch), info)
      done = info == 0
      if (.not. done) return
      done = all([(b(j, j)**2 > no_pivot*diagonal(j), j=1, n)])
      if (.not. done) return
      do j = n, 1, -1
         if (theta(j) <= no_mass*theta(n)) exit
         count = count + 1
         omega2(count) = 1/theta(j) - shift
         shape(:, count) = a(:, j)
      end do
   end subroutine inverse_modes

   !> By those of K against M.
   subroutine direct_modes(mass, stiffness, omega2, shape, done)
      real(wp), intent(in) :: mass(:, :), stiffness(:, :)
      real(wp), intent(out) :: omega2(:), shape(:, :)
      !> False if M is not definite
      logical, intent(out) :: done
      real(wp) :: b(size(mass, 1), size(mass, 1)), scratch(64*size(mass, 1) + 64)
      integer :: n, info
      n = size(mass, 1)
      shape = 0.5_wp*(stiffness + transpose(stiffness))
      b = 0.5_wp*(mass + transpose(mass))
      call dsygv(1, 'V', 'L', n, shape, n, b, n, omega2, scratch, size(scratch), info)
      done = info == 0
   end subroutine direct_modes

   !> Modes of (s^2 M + s D + K) phi = 0 by the eigenvalues 1/(s - sigma) of a matrix of twice the size, with a shift sigma where K
   !> is singular. Of a conjugate pair the one with positive frequency. Nothing is allocated if LAPACK fails.
   subroutine quadratic_modes(mass, damping, stiffness, wanted, value, vector)
      !> (n, n)
      real(wp), intent(in) :: mass(:, :), damping(:, :), stiffness(:, :)
      integer, intent(in) :: wanted
      !> s (modes), shapes (n, modes)
      complex(wp), allocatable, intent(out) :: value(:), vector(:, :)
      real(wp), allocatable :: pencil(:, :), factors(:, :), right(:, :), re(:), im(:), left(:, :), basis(:, :), scratch(:)
      complex(wp), allocatable :: all_values(:), found(:), shape(:, :)
      integer, allocatable :: pivot(:), order(:)
      !> Part of the shift below which an eigenvalue is that of a rigid motion
      real(wp), parameter :: rigid = 1.0e-5_wp
      real(wp) :: shift, largest
      integer :: n, info, i, j, k, count, kept
      n = size(mass, 1)
      allocate (pencil(2*n, 2*n), factors(n, n), right(n, 2*n), pivot(n), re(2*n), im(2*n), left(1, 2*n), basis(2*n, 2*n))
      allocate (scratch(128*n + 64), all_values(2*n), order(2*n))
      shift = 0.0_wp
      do
         factors = stiffness + shift*damping + shift**2*mass
         call dgetrf(n, n, factors, n, pivot, info)
         largest = 0.0_wp
         do i = 1, n
            largest = max(largest, abs(factors(i, i)))
         end do
         do i = 1, n
            if (abs(factors(i, i)) <= 1.0e-12_wp*largest) info = 1
         end do
         if (info == 0) exit
         if (shift > 0.0_wp) return
         shift = 1.0e-3_wp*sqrt(maxval(abs(stiffness))/maxval(abs(mass)))
         if (.not. shift > 0.0_wp) shift = 1.0_wp
      end do
      right(:, :n) = -damping - 2*shift*mass
      right(:, n + 1:) = -mass
      call dgetrs('N', n, 2*n, factors, n, pivot, right, n, info)
      pencil(:n, :) = right
      pencil(n + 1:, :) = 0.0_wp
      do i = 1, n
         pencil(n + i, i) = 1.0_wp
      end do
      call dgeev('N', 'V', 2*n, pencil, 2*n, re, im, left, 1, basis, 2*n, scratch, size(scratch), info)
      if (info /= 0) return
      largest = maxval(re**2 + im**2)
      count = 0
      do j = 1, 2*n
         all_values(j) = huge(1.0_wp)
         ! Infinite frequencies of motions without mass, and the conjugates: 1/s has the imaginary part of the other sign
         if (re(j)**2 + im(j)**2 <= 1.0e-26_wp*largest .or. im(j) > 0.0_wp) cycle
         all_values(j) = shift + 1/cmplx(re(j), im(j), wp)
         count = count + 1
      end do
      call sort(abs(all_values), order)
      allocate (found(count), shape(n, count))
      kept = 0
      do j = 1, count
         k = order(j)
         found(kept + 1) = all_values(k)
         shape(:, kept + 1) = basis(:n, k)
         ! Of a pair the vectors stand as real and imaginary part of the first, which has the positive imaginary part
         if (im(k) < 0.0_wp) shape(:, kept + 1) = cmplx(basis(:n, k - 1), -basis(:n, k), wp)
         ! A rigid motion is a double eigenvalue, which round-off parts by its root
         if (abs(found(kept + 1)) <= rigid*shift) then
            found(kept + 1) = 0.0_wp
            if (is_among(shape(:, kept + 1), shape(:, :kept))) cycle
         end if
         kept = kept + 1
         if (kept == wanted) exit
      end do
      allocate (value, source=found(:kept))
      allocate (vector, source=shape(:, :kept))
   end subroutine quadratic_modes

   !> Whether a shape is made of others.
   pure logical function is_among(shape, others)
      !> (n), (n, others)
      complex(wp), intent(in) :: shape(:), others(:, :)
      !> Part of a shape that is round-off of a double eigenvalue
      real(wp), parameter :: none = 1.0e-4_wp
      complex(wp) :: basis(size(shape), size(others, 2) + 1)
      integer :: j, k, round
      basis(:, :size(others, 2)) = others
      basis(:, size(others, 2) + 1) = shape
      is_among = .true.
      do j = 1, size(basis, 2)
         basis(:, j) = basis(:, j)/max(sqrt(real(dot_product(basis(:, j), basis(:, j)), wp)), tiny(1.0_wp))
         do round = 1, 2
            do k = 1, j - 1
               basis(:, j) = basis(:, j) - dot_product(basis(:, k), basis(:, j))*basis(:, k)
            end do
         end do
         is_among = real(dot_product(basis(:, j), basis(:, j)), wp) <= none**2
         if (is_among) then
            basis(:, j) = 0.0_wp
         else
            basis(:, j) = basis(:, j)/sqrt(real(dot_product(basis(:, j), basis(:, j)), wp))
         end if
      end do
   end function is_among

end module limber_system_vibrations
