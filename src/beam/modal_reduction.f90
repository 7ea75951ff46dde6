!> Lowest vibration modes by ARPACK. The lowest vibration modes of K phi = omega^2 M phi with a banded stiffness and a lumped,
!> semidefinite mass, by ARPACK on the shift-inverted operator
!>
!>    OP = M^(1/2) (K - sigma M)^(-1) M^(1/2)        on the coordinates that carry mass,
!>
!> which is symmetric, so that M may be singular without harm: there are exactly as many modes as
!> coordinates with mass. Rigid-body modes, if the supports leave any, are known beforehand and deflated. Displacements may be
!> held besides: their reactions are taken out of the inverse, eq. (2.18).
!> Floor: beam. Source: doc/theory, eqs. (2.4), (2.5), (2.17), (2.18); Lehoucq, Sorensen and Yang, ARPACK Users' Guide, section 3.2.
module limber_beam_modal_reduction
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_base_finite, only: dsyev, dpbtrf, dpbtrs, not_finite
   use limber_base_lapack, only: dsaupd, dseupd
   use limber_base_text, only: as_text
   use limber_beam_reduction_limits, only: check_operations
   implicit none
   private
   public :: lowest_modes, count_modes, count_held_modes, null_space

   !> The factored operator and its scratch
   type :: operator_type
      !> Bandwidth, all coordinates, coordinates with mass
      integer :: width = 0, n = 0, massive = 0
      !> Shift sigma [1/time^2]
      real(wp) :: shift = 0.0_wp
      !> Cholesky factor of K - sigma M, lower band
      real(wp), allocatable :: factor(:, :)
      !> Places of the coordinates with mass
      integer, allocatable :: place(:)
      !> Square roots of their masses
      real(wp), allocatable :: root(:)
      !> Rigid-body directions, orthonormal: M^(1/2) phi (massive, number) and phi itself (all coordinates, number)
      real(wp), allocatable :: rigid(:, :), motion(:, :)
      !> Displacements under the reactions of what is held, orthonormal in K - sigma M (all coordinates, number)
      real(wp), allocatable :: holding(:, :)
      !> One vector on all coordinates
      real(wp), allocatable :: full(:)
   end type operator_type

   !> Part of a row that must be new, and of a motion that is none
   real(wp), parameter :: new_part = 1.0e-8_wp, no_part = 1.0e-6_wp

contains

   !> Number of elastic modes that a lumped mass gives.
   pure integer function count_modes(mass, rigid_modes)
      !> Lumped masses of the free coordinates; zero on rotations
      real(wp), intent(in) :: mass(:)
      !> Number of rigid-body modes that the supports leave
      integer, intent(in) :: rigid_modes
      count_modes = max(0, count(mass > 0.0_wp) - rigid_modes)
   end function count_modes

   !> Number of elastic modes while displacements are held: a row that acts on coordinates with mass only takes one of these away,
   !> what is left of another one moves coordinates without mass.
   integer function count_held_modes(mass, rigid, held) result(modes)
      !> Lumped masses of the free coordinates (n)
      real(wp), intent(in) :: mass(:)
      !> Rigid-body modes (n, number), and rows of the displacements that are held (n, number)
      real(wp), intent(in) :: rigid(:, :), held(:, :)
      real(wp), allocatable :: left(:, :)
      real(wp) :: massless(size(held, 1), size(held, 2))
      integer :: i
      do i = 1, size(held, 2)
         massless(:, i) = merge(0.0_wp, held(:, i), mass > 0.0_wp)
         if (norm2(massless(:, i)) <= new_part*norm2(held(:, i))) massless(:, i) = 0.0_wp
      end do
      allocate (left, source=null_space(matmul(transpose(held), rigid)))
      modes = max(0, count(mass > 0.0_wp) - (independent(held) - independent(massless)) - size(left, 2))
   end function count_held_modes

   !> Number of independent columns.
   pure integer function independent(columns)
      real(wp), intent(in) :: columns(:, :)
      real(wp) :: unit(size(columns, 1), size(columns, 2)), rest(size(columns, 1))
      integer :: i, k, pass
      independent = 0
      do i = 1, size(columns, 2)
         if (.not. norm2(columns(:, i)) > 0.0_wp) cycle
         rest = columns(:, i)/norm2(columns(:, i))
         do pass = 1, 2
            do k = 1, independent
               rest = rest - unit(:, k)*dot_product(unit(:, k), rest)
            end do
         end do
         if (norm2(rest) <= new_part) cycle
         independent = independent + 1
         unit(:, independent) = rest/norm2(rest)
      end do
   end function independent

   !> Combinations, orthonormal, that a matrix turns into nothing (columns, number); rows count whatever their scale is.
   function null_space(matrix) result(combinations)
      !> (rows, columns)
      real(wp), intent(in) :: matrix(:, :)
      real(wp), allocatable :: combinations(:, :)
      real(wp) :: gram(size(matrix, 2), size(matrix, 2)), value(size(matrix, 2)), work(max(1, 8*size(matrix, 2))), length, &
         & largest
      integer :: n, i, j, info, kept
      n = size(matrix, 2)
      gram = 0.0_wp
      largest = 0.0_wp
      do i = 1, size(matrix, 1)
         largest = max(largest, norm2(matrix(i, :)))
      end do
      do i = 1, size(matrix, 1)
         length = norm2(matrix(i, :))
         if (.not. length > 1.0e-10_wp*largest) cycle
         do j = 1, n
            gram(:, j) = gram(:, j) + (matrix(i, :)/length)*(matrix(i, j)/length)
         end do
      end do
      call dsyev('V', 'L', n, gram, max(1, n), value, work, size(work), info)
      kept = 0
      if (info == 0) kept = count(value <= no_part**2*max(1.0_wp, maxval(value)))
      allocate (combinations(n, kept))
      combinations(:, :) = gram(:, :kept)
   end function null_space

   !> The lowest elastic modes, mass-normalised, in ascending frequency.
   subroutine lowest_modes(stiffness, mass, rigid, shift, wanted, omega2, phi, error, held, next)
      !> Lower band of K, (1 + bandwidth, n), LAPACK storage
      real(wp), intent(in) :: stiffness(:, :)
      !> Lumped masses (n) [mass]; zero where a coordinate has none
      real(wp), intent(in) :: mass(:)
      !> Rigid-body modes that the supports leave, any scaling, (n, number)
      real(wp), intent(in) :: rigid(:, :)
      !> Shift sigma <= 0 [1/time^2]; below zero if there are rigid-body modes
      real(wp), intent(in) :: shift
      !> Number of modes
      integer, intent(in) :: wanted
      !> Squared circular frequencies (wanted) [1/time^2]
      real(wp), intent(out) :: omega2(:)
      !> Mode shapes on all coordinates (n, wanted); sign: the first sizeable entry is positive
      real(wp), intent(out) :: phi(:, :)
      !> Too many modes, or no convergence
      type(error_type), allocatable, intent(out) :: error
      !> Displacements that are held: rows of them (n, number)
      real(wp), intent(in), optional :: held(:, :)
      !> Squared frequency of the lowest mode that is left out; huge if none is
      real(wp), intent(out), optional :: next
      type(operator_type) :: op
      real(wp), allocatable :: theta(:), y(:, :)
      real(wp) :: beside
      integer :: available, i, j

      if (present(next)) next = huge(next)
      available = count_modes(mass, size(rigid, 2))
      if (present(held)) available = count_held_modes(mass, rigid, held)
      if (wanted > available) then
         call raise(error, 'the lumped mass gives '//as_text(available)//' modes, '//as_text(wanted)//' are asked for')
         return
      end if
      if (wanted == 0) return
      call check_operations(operations(count(mass > 0.0_wp), size(mass), size(stiffness, 1), wanted, available), &
         & as_text(wanted)//' modes on '//as_text(size(mass))//' coordinates', error)
      if (allocated(error)) return
      call factor_operator(op, stiffness, mass, rigid, shift, error)
      if (allocated(error)) return
      if (present(held)) call hold(op, mass, held)
      allocate (theta(wanted), y(op%massive, wanted))
      if (wanted < available) then
         call iterate(op, wanted, theta, y, error)
         if (.not. allocated(error)) call find_equals(op, theta, y, beside, error)
         if (.not. allocated(error) .and. present(next) .and. beside > 0.0_wp) next = op%shift + 1.0_wp/beside
      else
         call solve_whole(op, wanted, theta, y, error)
      end if
      if (allocated(error)) return
      do j = 1, wanted
         omega2(j) = op%shift + 1.0_wp/theta(j)
         call expand(op, y(:, j), phi(:, j))
         do i = 1, size(op%rigid, 2)
            phi(:, j) = phi(:, j) - op%motion(:, i)*sum(mass*op%motion(:, i)*phi(:, j))
         end do
         phi(:, j) = phi(:, j)*leading_sign(phi(:, j))/sqrt(sum(mass*phi(:, j)**2))
      end do
   end subroutine lowest_modes

   !> Estimate of the operations that modes take.
   pure real(wp) function operations(massive, n, width, wanted, available)
      !> Coordinates with mass, all coordinates, their band; modes that are wanted, and that there are
      integer, intent(in) :: massive, n, width, wanted, available
      real(wp) :: basis
      basis = basis_size(massive, wanted)
      operations = 16*massive*basis**2 + 8*basis**3 + 12*basis*n*width
      if (wanted == available) operations = 12*real(massive, wp)**3
   end function operations

   !> Vectors of the Krylov space for so many modes.
   pure integer function basis_size(massive, wanted)
      integer, intent(in) :: massive, wanted
      basis_size = min(massive, max(2*wanted + 1, 20))
   end function basis_size

   !> Sign of the first entry that is not small beside the largest one with mass.
   pure real(wp) function leading_sign(vector)
      real(wp), intent(in) :: vector(:)
      integer :: i
      leading_sign = 1.0_wp
      do i = 1, size(vector)
         if (abs(vector(i)) > 1.0e-3_wp*maxval(abs(vector))) then
            leading_sign = sign(1.0_wp, vector(i))
            return
         end if
      end do
   end function leading_sign

   !> Factors K - sigma M and orthonormalises the rigid-body directions.
   subroutine factor_operator(op, stiffness, mass, rigid, shift, error)
      type(operator_type), intent(out) :: op
      real(wp), intent(in) :: stiffness(:, :), mass(:), rigid(:, :), shift
      type(error_type), allocatable, intent(out) :: error
      integer :: i, j, info
      op%width = size(stiffness, 1) - 1
      op%n = size(mass)
      op%shift = shift
      op%massive = count(mass > 0.0_wp)
      ! Allocated by statements: at an assignment gfortran 12 reads bounds that were never set, which the sanitizer sees
      allocate (op%place(op%massive), op%root(op%massive))
      allocate (op%factor, source=stiffness)
      allocate (op%motion, source=rigid)
      op%place = pack([(i, i=1, op%n)], mass > 0.0_wp)
      op%root = sqrt(mass(op%place))
      op%factor(1, :) = op%factor(1, :) - shift*mass
      allocate (op%full(op%n), op%rigid(op%massive, size(rigid, 2)), op%holding(op%n, 0))
      call dpbtrf('L', op%n, op%width, op%factor, op%width + 1, info)
      if (info == 0 .and. .not. (all(ieee_is_finite(op%factor(1, :))) .and. all(ieee_is_finite(op%root)))) then
         call raise(error, 'masses or stiffness are too great or too small to compute modes with')
         return
      else if (info /= 0) then
         call raise(error, 'the stiffness matrix under these supports is not positive definite (row '//as_text(info)//')')
         return
      end if
      do j = 1, size(rigid, 2)
         do i = 1, j - 1
            op%motion(:, j) = op%motion(:, j) - op%motion(:, i)*sum(mass*op%motion(:, i)*op%motion(:, j))
         end do
         op%motion(:, j) = op%motion(:, j)/sqrt(sum(mass*op%motion(:, j)**2))
         op%rigid(:, j) = op%root*op%motion(op%place, j)
      end do
   end subroutine factor_operator

   !> Holds displacements, eq. (2.18); rigid motions that they do not let be are none of the system's any more.
   subroutine hold(op, mass, held)
      type(operator_type), intent(inout) :: op
      real(wp), intent(in) :: mass(:), held(:, :)
      real(wp) :: holding(size(held, 1), size(held, 2)), rest(size(held, 1)), whole, part
      real(wp), allocatable :: combinations(:, :)
      integer :: i, k, kept, pass, info
      kept = 0
      do i = 1, size(held, 2)
         rest = held(:, i)
         call dpbtrs('L', op%n, op%width, 1, op%factor, op%width + 1, rest, op%n, info)
         whole = dot_product(held(:, i), rest)
         if (.not. whole > 0.0_wp) cycle
         do pass = 1, 2
            do k = 1, kept
               ! In the product of K - sigma M
               part = shifted_product(op, holding(:, k), rest)
               rest = rest - holding(:, k)*part
            end do
         end do
         part = shifted_product(op, rest, rest)
         if (part <= new_part**2*whole) cycle
         kept = kept + 1
         holding(:, kept) = rest/sqrt(part)
      end do
      allocate (combinations, source=null_space(matmul(transpose(held), op%motion)))
      op%motion = matmul(op%motion, combinations)
      deallocate (op%rigid, op%holding)
      allocate (op%rigid(op%massive, size(op%motion, 2)), op%holding(op%n, kept))
      op%holding(:, :) = holding(:, :kept)
      do k = 1, size(op%motion, 2)
         op%motion(:, k) = op%motion(:, k)/sqrt(sum(mass*op%motion(:, k)**2))
         op%rigid(:, k) = op%root*op%motion(op%place, k)
      end do
   end subroutine hold

   !> a.(K - sigma M) b, of the Cholesky factor.
   pure real(wp) function shifted_product(op, a, b) result(product)
      type(operator_type), intent(in) :: op
      real(wp), intent(in) :: a(:), b(:)
      integer :: j, last
      product = 0.0_wp
      do j = 1, op%n
         last = min(op%width, op%n - j)
         product = product + dot_product(op%factor(1:last + 1, j), a(j:j + last))* &
            & dot_product(op%factor(1:last + 1, j), b(j:j + last))
      end do
   end function shifted_product

   !> full = (K - sigma M)^(-1) M^(1/2) x, on all coordinates; held displacements remain zero.
   subroutine expand(op, x, full)
      type(operator_type), intent(in) :: op
      real(wp), intent(in) :: x(:)
      real(wp), intent(out) :: full(:)
      real(wp) :: reaction(size(op%holding, 2))
      integer :: info, k
      full = 0.0_wp
      full(op%place) = op%root*x
      do k = 1, size(reaction)
         reaction(k) = dot_product(op%holding(:, k), full)
      end do
      call dpbtrs('L', op%n, op%width, 1, op%factor, op%width + 1, full, op%n, info)
      do k = 1, size(reaction)
         full = full - op%holding(:, k)*reaction(k)
      end do
   end subroutine expand

   !> y = OP x, with the rigid-body directions taken out before and after.
   subroutine apply_operator(op, x, y)
      type(operator_type), intent(inout) :: op
      real(wp), intent(in) :: x(:)
      real(wp), intent(out) :: y(:)
      y = x
      call deflate(op, y)
      call expand(op, y, op%full)
      y = op%root*op%full(op%place)
      call deflate(op, y)
   end subroutine apply_operator

   pure subroutine deflate(op, y)
      type(operator_type), intent(in) :: op
      real(wp), intent(inout) :: y(:)
      integer :: j
      do j = 1, size(op%rigid, 2)
         y = y - op%rigid(:, j)*dot_product(op%rigid(:, j), y)
      end do
   end subroutine deflate

   !> The largest eigenvalues theta of OP by ARPACK, descending.
   subroutine iterate(op, wanted, theta, y, error)
      type(operator_type), intent(inout) :: op
      integer, intent(in) :: wanted
      real(wp), intent(out) :: theta(:), y(:, :)
      type(error_type), allocatable, intent(out) :: error
      integer :: ido, ncv, iparam(11), ipntr(11), lworkl, info, from, to, i
      real(wp), allocatable :: resid(:), basis(:, :), workd(:), workl(:), value(:), vector(:, :)
      logical, allocatable :: select(:)
      real(wp) :: tolerance
      real(wp), parameter :: golden = 0.6180339887498949_wp

      ncv = basis_size(op%massive, wanted)
      lworkl = ncv*(ncv + 8)
      allocate (resid(op%massive), basis(op%massive, ncv), workd(3*op%massive), workl(lworkl), select(ncv))
      allocate (value(wanted), vector(op%massive, wanted))
      ! A start vector without symmetry, the same in every run: the golden-ratio sequence
      resid = [(modulo(i*golden, 1.0_wp) - 0.5_wp, i=1, op%massive)]
      call deflate(op, resid)
      iparam = 0
      iparam([1, 3, 4, 7]) = [1, 3000, 1, 1]
      tolerance = 0.0_wp
      ido = 0
      info = 1
      do
         call dsaupd(ido, 'I', op%massive, 'LA', wanted, tolerance, resid, ncv, basis, op%massive, iparam, ipntr, &
            & workd, workl, lworkl, info)
         if (abs(ido) /= 1) exit
         from = ipntr(1)
         to = ipntr(2)
         call apply_operator(op, workd(from:from + op%massive - 1), workd(to:to + op%massive - 1))
         if (all(ieee_is_finite(workd(to:to + op%massive - 1)))) cycle
         info = not_finite
         exit
      end do
      if (info == 0) call dseupd(.true., 'A', select, value, vector, op%massive, 0.0_wp, 'I', op%massive, 'LA', wanted, &
         & tolerance, resid, ncv, basis, op%massive, iparam, ipntr, workd, workl, lworkl, info)
      if (info /= 0) then
         call raise(error, 'the mode computation did not converge (ARPACK info '//as_text(info)//')')
         return
      end if
      ! dseupd returns ascending theta; the lowest frequency has the largest
      do i = 1, wanted
         theta(i) = value(wanted + 1 - i)
         y(:, i) = vector(:, wanted + 1 - i)
      end do
   end subroutine iterate

   !> Modes of exactly equal frequency, of which a Krylov space of one start vector may hold one only: what is left beside the
   !> modes found is searched for a lower one.
   subroutine find_equals(op, theta, y, beside, error)
      type(operator_type), intent(inout) :: op
      !> Descending, and their vectors
      real(wp), intent(inout) :: theta(:), y(:, :)
      !> The largest one beside these
      real(wp), intent(out) :: beside
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: equal = 1.0e-9_wp
      real(wp), allocatable :: rigid(:, :)
      real(wp) :: another(1), vector(op%massive, 1)
      integer :: turn, i, n
      n = size(theta)
      beside = 0.0_wp
      call move_alloc(op%rigid, rigid)
      do turn = 1, n
         allocate (op%rigid(op%massive, size(rigid, 2) + n))
         op%rigid(:, :size(rigid, 2)) = rigid
         op%rigid(:, size(rigid, 2) + 1:) = y
         another = 0.0_wp
         call iterate(op, 1, another, vector, error)
         deallocate (op%rigid)
         if (allocated(error)) exit
         beside = another(1)
         if (another(1) <= theta(n)*(1 + equal)) exit
         beside = theta(n)
         i = count(theta >= another(1))
         theta(i + 2:) = theta(i + 1:n - 1)
         theta(i + 1) = another(1)
         y(:, i + 2:) = y(:, i + 1:n - 1)
         y(:, i + 1) = vector(:, 1)
      end do
      call move_alloc(rigid, op%rigid)
   end subroutine find_equals

   !> The same for all modes at once, which a Krylov space cannot give: the dense operator, by LAPACK.
   subroutine solve_whole(op, wanted, theta, y, error)
      type(operator_type), intent(inout) :: op
      integer, intent(in) :: wanted
      real(wp), intent(out) :: theta(:), y(:, :)
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: dense(:, :), value(:), unit(:), work(:)
      integer :: j, info
      allocate (dense(op%massive, op%massive), value(op%massive), unit(op%massive), work(8*op%massive))
      do j = 1, op%massive
         unit = 0.0_wp
         unit(j) = 1.0_wp
         call apply_operator(op, unit, dense(:, j))
      end do
      dense = 0.5_wp*(dense + transpose(dense))
      call dsyev('V', 'L', op%massive, dense, op%massive, value, work, size(work), info)
      if (info /= 0) then
         call raise(error, 'the mode computation did not converge (LAPACK info '//as_text(info)//')')
         return
      end if
      do j = 1, wanted
         theta(j) = value(op%massive + 1 - j)
         y(:, j) = dense(:, op%massive + 1 - j)
      end do
   end subroutine solve_whole

end module limber_beam_modal_reduction
