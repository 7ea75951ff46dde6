!> Eigenvalues and shapes of small scenes. Their number is known before: two for each motion with mass. None is lost beside a zero
!> frequency or beside a motion without mass. Floor: multibody. Source: doc/theory, eqs. (6.9)-(6.13); Golub and Van Loan, Matrix
!> Computations, section 8.7.
module limber_multibody_dense_eigenmodes
   use limber_base_kinds, only: wp
   use limber_base_finite, only: dsyev, dsygv, dgeev, dgetrf, dgetrs, unit_matrix
   use limber_multibody_sparse_eigenmodes, only: sort
   implicit none
   private
   public :: symmetric_modes, quadratic_modes, least_stiff, nothing

   !> Part of the first elastic omega^2 below which an omega^2 is the round-off of a rigid motion
   real(wp), parameter :: nothing = 1.0e-12_wp

contains

   !> Modes of K phi = omega^2 M phi, both symmetric, lowest omega^2 first. M may be singular. Nothing is allocated if a motion has
   !> neither mass nor stiffness, or if LAPACK fails.
   subroutine symmetric_modes(mass, stiffness, wanted, value, vector)
      !> (n, n)
      real(wp), intent(in) :: mass(:, :), stiffness(:, :)
      integer, intent(in) :: wanted
      !> s = sqrt(-omega^2) (modes), shapes (n, modes): as many as wanted, or one for each motion with mass
      complex(wp), allocatable, intent(out) :: value(:), vector(:, :)
      real(wp), allocatable :: heavy(:, :), light(:, :), follow(:, :), omega2(:), shape(:, :)
      logical :: done
      integer :: count, j
      call split_by_mass(mass, heavy, light, done)
      if (done) call follow_stiffness(stiffness, heavy, light, follow, done)
      if (.not. done) return
      allocate (omega2(size(heavy, 2)), shape(size(heavy, 2), size(heavy, 2)))
      call definite_modes(matmul(transpose(heavy), matmul(mass, heavy)), matmul(transpose(follow), matmul(stiffness, follow)), &
         & omega2, shape, done)
      if (.not. done) return
      count = min(size(omega2), wanted)
      allocate (value(count), vector(size(mass, 1), count))
      do j = 1, count
         value(j) = cmplx(0.0_wp, sqrt(abs(omega2(j))), wp)
         if (omega2(j) < 0.0_wp) value(j) = cmplx(sqrt(-omega2(j)), 0.0_wp, wp)
         vector(:, j) = matmul(follow, shape(:, j))
      end do
   end subroutine symmetric_modes

   !> Bases of the motions with mass and of those without, eq. (6.9). Where all have mass the first is that of the unit matrix.
   subroutine split_by_mass(mass, heavy, light, done)
      !> (n, n)
      real(wp), intent(in) :: mass(:, :)
      !> (n, with mass), (n, without)
      real(wp), allocatable, intent(out) :: heavy(:, :), light(:, :)
      logical, intent(out) :: done
      !> Parts that are round-off: of the largest mass; of the mass of a motion that is scaled to one
      real(wp), parameter :: no_entry = 1.0e-18_wp, no_mass = 1.0e-13_wp
      real(wp), allocatable :: scaled(:, :), part(:), scratch(:), scale(:)
      real(wp) :: largest
      integer :: n, lost, j, info
      n = size(mass, 1)
      allocate (scaled(n, n), part(n), scratch(64*n + 64), scale(n))
      largest = maxval([(mass(j, j), j=1, n)])
      done = largest > 0.0_wp
      if (.not. done) then
         ! Nothing has mass: nothing vibrates
         allocate (heavy(n, 0), light(n, 0))
         done = maxval(abs(mass)) <= 0.0_wp
         return
      end if
      scale = [(1/sqrt(merge(mass(j, j), largest, mass(j, j) > no_entry*largest)), j=1, n)]
      do j = 1, n
         scaled(:, j) = 0.5_wp*(mass(:, j) + mass(j, :))*scale*scale(j)
      end do
      call dsyev('V', 'L', n, scaled, n, part, scratch, size(scratch), info)
      done = info == 0
      if (.not. done) return
      lost = count(part <= no_mass*part(n))
      allocate (light(n, lost), heavy(n, n - lost))
      if (lost == 0) then
         heavy = 0.0_wp
         do j = 1, n
            heavy(j, j) = 1.0_wp
         end do
         return
      end if
      do j = 1, n
         if (j <= lost) light(:, j) = scale*scaled(:, j)
         if (j > lost) heavy(:, j - lost) = scale*scaled(:, j)
      end do
   end subroutine split_by_mass

   !> What motions without mass do as those with mass move: they stay in equilibrium, eq. (6.9).
   subroutine follow_stiffness(stiffness, heavy, light, follow, done)
      !> (n, n), (n, with mass), (n, without)
      real(wp), intent(in) :: stiffness(:, :), heavy(:, :), light(:, :)
      !> (n, with mass)
      real(wp), allocatable, intent(out) :: follow(:, :)
      !> False if a motion without mass has no stiffness
      logical, intent(out) :: done
      real(wp) :: factors(size(light, 2), size(light, 2)), right(size(light, 2), size(heavy, 2)), scale(size(light, 2))
      integer :: pivot(size(light, 2)), n, j, info
      !> Pivot of a scaled matrix that is round-off
      real(wp), parameter :: no_pivot = 1.0e-13_wp
      n = size(light, 2)
      done = .true.
      allocate (follow, source=heavy)
      if (n == 0) return
      factors = matmul(transpose(light), matmul(stiffness, light))
      right = matmul(transpose(light), matmul(stiffness, heavy))
      scale = [(1/max(sqrt(maxval(abs(factors(:, j)))), tiny(1.0_wp)**0.25_wp), j=1, n)]
      do j = 1, n
         factors(:, j) = factors(:, j)*scale*scale(j)
      end do
      do j = 1, size(right, 2)
         right(:, j) = right(:, j)*scale
      end do
      call dgetrf(n, n, factors, n, pivot, info)
      done = info == 0 .and. minval([(abs(factors(j, j)), j=1, n)]) > no_pivot
      if (.not. done) return
      call dgetrs('N', n, size(right, 2), factors, n, pivot, right, n, info)
      do j = 1, size(right, 2)
         follow(:, j) = heavy(:, j) - matmul(light, scale*right(:, j))
      end do
   end subroutine follow_stiffness

   !> Modes of a definite mass: all of them, lowest omega^2 first.
   subroutine definite_modes(mass, stiffness, omega2, shape, done)
      !> (n, n)
      real(wp), intent(in) :: mass(:, :), stiffness(:, :)
      !> (n); (n, n), of unit modal mass
      real(wp), intent(out) :: omega2(:), shape(:, :)
      logical, intent(out) :: done
      !> Highest omega^2 beside the lowest up to which 1/omega^2 tells all of them
      real(wp), parameter :: widest = 1.0e9_wp
      real(wp) :: other(size(omega2)), turned(size(omega2), size(omega2)), shift
      done = .true.
      omega2 = 0.0_wp
      if (size(omega2) == 0) return
      ! The lowest frequencies are the largest eigenvalues of M against K: they are not lost in the rounding of the highest
      call inverse_modes(mass, stiffness, 0.0_wp, omega2, shape, done)
      if (done) then
         if (omega2(size(omega2)) <= widest*omega2(1)) return
      end if
      call direct_modes(mass, stiffness, omega2, shape, done)
      if (.not. done .or. .not. any(omega2 > 0.0_wp)) return
      shift = max(least_stiff(omega2), -2*omega2(1))
      call inverse_modes(mass, stiffness, shift, other, turned, done)
      if (done) then
         omega2 = other
         shape = turned
      end if
      done = .true.
      where (abs(omega2) <= nothing*shift) omega2 = 0.0_wp
   end subroutine definite_modes

   !> The least omega^2 of an elastic motion, beside which those of rigid motions are the rounding of the largest.
   pure real(wp) function least_stiff(omega2)
      !> Some of them positive
      real(wp), intent(in) :: omega2(:)
      real(wp), parameter :: rounding = 1.0e-11_wp
      least_stiff = minval(omega2, mask=omega2 > rounding*maxval(omega2))
   end function least_stiff

   !> By the eigenvalues 1/(omega^2 + shift) of M against K + shift M, eq. (6.10).
   subroutine inverse_modes(mass, stiffness, shift, omega2, shape, done)
      !> (n, n), and the shift
      real(wp), intent(in) :: mass(:, :), stiffness(:, :), shift
      !> (n), (n, n)
      real(wp), intent(out) :: omega2(:), shape(:, :)
      !> False if K + shift M is not definite beyond round-off
      logical, intent(out) :: done
      !> A pivot beside its diagonal entry, and an eigenvalue beside the largest, that are round-off
      real(wp), parameter :: no_pivot = 100*epsilon(1.0_wp), no_value = 4*epsilon(1.0_wp)
      real(wp) :: a(size(mass, 1), size(mass, 1)), b(size(mass, 1), size(mass, 1)), theta(size(mass, 1)), &
         & scratch(64*size(mass, 1) + 64), diagonal(size(mass, 1))
      integer :: n, info, j
      n = size(mass, 1)
      a = 0.5_wp*(mass + transpose(mass))
      b = 0.5_wp*(stiffness + transpose(stiffness)) + shift*a
      diagonal = [(b(j, j), j=1, n)]
      omega2 = 0.0_wp
      shape = 0.0_wp
      call dsygv(1, 'V', 'L', n, a, n, b, n, theta, scratch, size(scratch), info)
      done = info == 0
      if (done) done = all([(b(j, j)**2 > no_pivot*diagonal(j), j=1, n)]) .and. theta(1) > no_value*theta(n)
      if (.not. done) return
      do j = 1, n
         omega2(j) = 1/theta(n + 1 - j) - shift
         shape(:, j) = a(:, n + 1 - j)/sqrt(theta(n + 1 - j))
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

   !> Modes of (s^2 M + s D + K) phi = 0, lowest |s| first; of a conjugate pair the one with positive frequency. They are found
   !> among the modes of M and the symmetric part of K, in which frequencies of all sizes stand apart. Nothing is allocated if a
   !> motion has no mass, damping or stiffness, or if LAPACK fails.
   subroutine quadratic_modes(mass, damping, stiffness, wanted, value, vector)
      !> (n, n)
      real(wp), intent(in) :: mass(:, :), damping(:, :), stiffness(:, :)
      integer, intent(in) :: wanted
      !> s (modes), shapes (n, modes)
      complex(wp), allocatable, intent(out) :: value(:), vector(:, :)
      !> Damping of a motion without mass that is round-off
      real(wp), parameter :: no_damping = 1.0e-12_wp
      real(wp), allocatable :: heavy(:, :), light(:, :), follow(:, :), omega2(:), shape(:, :), left(:, :), right(:, :), d(:, :), &
         & k(:, :)
      complex(wp), allocatable :: reduced(:, :)
      real(wp) :: shift
      integer :: n, j
      logical :: done
      n = size(mass, 1)
      call split_by_mass(mass, heavy, light, done)
      if (.not. done) return
      if (size(light) > 0) then
         if (maxval(abs(matmul(damping, light))) > no_damping*maxval(abs(damping))*maxval(abs(light))) then
            ! Motions without mass that are damped have roots of their own
            shift = 1.0e-3_wp*sqrt(maxval(abs(stiffness))/maxval(abs(mass)))
            call inverse_roots(mass, damping, stiffness, [0.0_wp, shift], 2*size(heavy, 2) + rank_of(matmul(transpose(light), &
               & matmul(damping, light))), wanted, value, vector)
            return
         end if
      end if
      call follow_stiffness(stiffness, heavy, light, follow, done)
      if (.not. done) return
      n = size(heavy, 2)
      allocate (omega2(n), shape(n, n), d(n, n), k(n, n))
      k = matmul(transpose(heavy), matmul(stiffness, follow))
      call definite_modes(matmul(transpose(heavy), matmul(mass, heavy)), 0.5_wp*(k + transpose(k)), omega2, shape, done)
      if (.not. done) return
      allocate (left(size(mass, 1), n), right(size(mass, 1), n))
      left = matmul(heavy, shape)
      right = matmul(follow, shape)
      d = matmul(transpose(left), matmul(damping, left))
      k = matmul(transpose(shape), matmul(0.5_wp*(k - transpose(k)), shape))
      do j = 1, n
         k(j, j) = k(j, j) + omega2(j)
      end do
      call inverse_roots(unit_matrix(n), d, k, shifts_of(omega2), 2*n, wanted, value, reduced)
      if (.not. allocated(value)) return
      allocate (vector(size(mass, 1), size(value)))
      do j = 1, size(value)
         vector(:, j) = cmplx(matmul(right, real(reduced(:, j), wp)), matmul(right, aimag(reduced(:, j))), wp)
      end do
   end subroutine quadratic_modes

   !> Shifts to try: zero, unless a motion is rigid, and the first elastic frequency.
   pure function shifts_of(omega2) result(shifts)
      !> Of the symmetric part of the stiffness
      real(wp), intent(in) :: omega2(:)
      real(wp), allocatable :: shifts(:)
      !> Part of the first elastic omega^2 that counts as rigid
      real(wp), parameter :: rigid = 1.0e-8_wp
      real(wp) :: first
      first = 1.0_wp
      if (any(abs(omega2) > 0.0_wp)) first = least_stiff(abs(omega2))
      if (any(abs(omega2) <= rigid*first)) then
         shifts = sqrt(first)*[1.0_wp, 1.37_wp]
      else
         shifts = sqrt(first)*[0.0_wp, 1.0_wp, 1.37_wp]
      end if
   end function shifts_of

   !> By the eigenvalues 1/(s - sigma) of a matrix of twice the size, eq. (6.13), at the first shift sigma at which it exists.
   subroutine inverse_roots(mass, damping, stiffness, shifts, finite, wanted, value, vector)
      !> (n, n); sigma in the order of trial
      real(wp), intent(in) :: mass(:, :), damping(:, :), stiffness(:, :), shifts(:)
      !> Eigenvalues that are finite, and modes wanted
      integer, intent(in) :: finite, wanted
      !> s (modes), shapes (n, modes)
      complex(wp), allocatable, intent(out) :: value(:), vector(:, :)
      real(wp), allocatable :: pencil(:, :), factors(:, :), right(:, :), re(:), im(:), left(:, :), basis(:, :), scratch(:), &
         & largest(:)
      complex(wp), allocatable :: all_values(:), found(:), shape(:, :)
      integer, allocatable :: pivot(:), order(:)
      !> Part of the shift below which an eigenvalue is that of a rigid motion; pivot that is round-off
      real(wp), parameter :: rigid = 1.0e-5_wp, no_pivot = 1.0e-12_wp
      real(wp) :: shift
      integer :: n, info, i, j, k, kept
      n = size(mass, 1)
      allocate (pencil(2*n, 2*n), factors(n, n), right(n, 2*n), pivot(n), re(2*n), im(2*n), left(1, 2*n), basis(2*n, 2*n))
      allocate (scratch(128*n + 64), all_values(2*n), order(2*n), found(2*n), shape(n, 2*n), largest(n))
      shift = 0.0_wp
      do i = 1, size(shifts)
         shift = shifts(i)
         factors = stiffness + shift*damping + shift**2*mass
         largest = maxval(abs(factors), dim=2)
         call dgetrf(n, n, factors, n, pivot, info)
         do j = 1, n
            largest([j, pivot(j)]) = largest([pivot(j), j])
            if (abs(factors(j, j)) <= no_pivot*largest(j)) info = 1
         end do
         if (info == 0) exit
         if (i == size(shifts)) return
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
      ! Infinite frequencies of motions without mass are the smallest, and the conjugates: 1/s has the imaginary part of other sign
      call sort(-hypot(re, im), order)
      all_values = huge(1.0_wp)
      do i = 1, min(finite, 2*n)
         j = order(i)
         if (im(j) <= 0.0_wp .and. hypot(re(j), im(j)) > 0.0_wp) all_values(j) = shift + 1/cmplx(re(j), im(j), wp)
      end do
      call sort(abs(all_values), order)
      kept = 0
      do j = 1, 2*n
         k = order(j)
         if (real(all_values(k), wp) >= huge(1.0_wp) .or. kept == wanted) exit
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
      end do
      allocate (value, source=found(:kept))
      allocate (vector, source=shape(:, :kept))
   end subroutine inverse_roots

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

   !> Rank of a small matrix of damping, by its symmetric part.
   integer function rank_of(matrix) result(rank)
      real(wp), intent(in) :: matrix(:, :)
      real(wp), parameter :: none = 1.0e-12_wp
      real(wp) :: copy(size(matrix, 1), size(matrix, 1)), part(size(matrix, 1)), scratch(64*size(matrix, 1) + 64)
      integer :: info
      copy = 0.5_wp*(matrix + transpose(matrix))
      part = 0.0_wp
      call dsyev('N', 'L', size(part), copy, size(part), part, scratch, size(scratch), info)
      rank = count(abs(part) > none*max(maxval(abs(part)), tiny(1.0_wp)))
   end function rank_of

end module limber_multibody_dense_eigenmodes
