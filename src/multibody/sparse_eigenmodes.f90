!> Eigenvalues of large scenes by ARPACK.
!>
!>    [ K - sigma B   G^T ] [ y ]   [ B x ]
!>    [ G             0   ] [ . ] = [ 0   ]
!>
!> B is the mass, or scales. The operator x -> y is symmetric in B on the motions that the constraints leave, which are its range.
!> Floor: multibody. Source: doc/theory, eq. (6.14); Lehoucq, Sorensen and Yang, ARPACK Users' Guide, sections 3.2, 4.
module limber_multibody_sparse_eigenmodes
   use limber_base_kinds, only: wp
   use limber_base_lapack, only: dsaupd, dseupd
   use limber_base_signals, only: signal_came
   use limber_multibody_free_motions, only: rate_scales
   use limber_multibody_system, only: system_type
   use limber_multibody_tangent, only: tangent_type, combine_stiffness
   use limber_multibody_tangent_products, only: times_mass
   implicit none
   private
   public :: nearest_eigenvalues, sort, is_large, vectors_for, by_mass, by_scales

   !> Metrics: K x = lambda M x [1/time^2]; K x = lambda diag(s)^-2 x [energy]
   integer, parameter :: by_mass = 1, by_scales = 2
   !> Rates and constraints of a scene from which on dense matrices cost more
   integer, parameter :: large = 900

contains

   !> Whether a scene is too large for dense matrices.
   pure logical function is_large(system)
      type(system_type), intent(in) :: system
      is_large = system%layout%nw + system%nc > large
   end function is_large

   !> Vectors that ARPACK takes for some eigenvalues.
   pure integer function vectors_for(wanted)
      integer, intent(in) :: wanted
      vectors_for = max(2*wanted + 1, 20)
   end function vectors_for

   !> The eigenvalues nearest to a shift, in ascending distance, with their motions.
   subroutine nearest_eigenvalues(system, tangent, metric, shift, wanted, value, motion, done, but)
      type(system_type), intent(in) :: system
      !> At the state; its matrix is filled and factored
      type(tangent_type), intent(inout) :: tangent
      integer, intent(in) :: metric
      !> Beside the mass only
      real(wp), intent(in) :: shift
      integer, intent(in) :: wanted
      !> (wanted); motions in the layout of the rates (nw, wanted)
      real(wp), intent(out) :: value(:), motion(:, :)
      !> False if the matrix is singular, ARPACK does not converge, or a signal asks for the end
      logical, intent(out) :: done
      !> Motions (nw, number), orthonormal in the metric, beside which others are looked for
      real(wp), intent(in), optional :: but(:, :)
      integer :: ido, ncv, iparam(11), ipntr(11), lworkl, info, from, to, i, n
      real(wp), allocatable :: resid(:), basis(:, :), workd(:), workl(:), scale(:), solution(:), ritz(:), found(:, :), &
         & weighted(:, :)
      integer, allocatable :: order(:)
      logical, allocatable :: select(:)
      logical :: singular
      real(wp) :: tolerance
      real(wp), parameter :: golden = 0.6180339887498949_wp
      n = system%layout%nw
      call combine_stiffness(tangent, shift)
      call tangent%matrix%factor(singular)
      done = .not. singular
      if (singular) return
      ncv = min(n, vectors_for(wanted))
      lworkl = ncv*(ncv + 8)
      allocate (resid(n), basis(n, ncv), workd(3*n), workl(lworkl), select(ncv), scale(n), solution(n + system%nc), ritz(wanted))
      allocate (order(wanted), found(n, wanted))
      scale = rate_scales(system)
      if (present(but)) then
         allocate (weighted(n, size(but, 2)))
         do i = 1, size(but, 2)
            call apply_metric(but(:, i), weighted(:, i))
         end do
      end if
      ! A start vector without symmetry, the same in every run, in the range of the operator
      workd(:n) = scale*[(modulo(i*golden, 1.0_wp) - 0.5_wp, i=1, n)]
      call apply_metric(workd(:n), workd(n + 1:2*n))
      call apply_inverse(workd(n + 1:2*n), resid)
      iparam = 0
      iparam([1, 3, 4, 7]) = [1, 300, 1, 3]
      tolerance = 1.0e-12_wp
      ido = 0
      info = 1
      do
         call dsaupd(ido, 'G', n, 'LM', wanted, tolerance, resid, ncv, basis, n, iparam, ipntr, workd, workl, lworkl, info)
         from = ipntr(1)
         to = ipntr(2)
         if (ido == -1) then
            call apply_metric(workd(from:from + n - 1), workd(to:to + n - 1))
            solution(:n) = workd(to:to + n - 1)
            call apply_inverse(solution(:n), workd(to:to + n - 1))
         else if (ido == 1) then
            call apply_inverse(workd(ipntr(3):ipntr(3) + n - 1), workd(to:to + n - 1))
         else if (ido == 2) then
            call apply_metric(workd(from:from + n - 1), workd(to:to + n - 1))
         else
            exit
         end if
         done = .not. signal_came()
         if (.not. done) return
      end do
      if (info == 0) call dseupd(.true., 'A', select, ritz, found, n, shift, 'G', n, 'LM', wanted, tolerance, resid, ncv, &
         & basis, n, iparam, ipntr, workd, workl, lworkl, info)
      done = info == 0
      if (.not. done) return
      call sort(abs(ritz - shift), order)
      value = ritz(order)
      motion = found(:, order)

   contains

      subroutine apply_metric(x, y)
         real(wp), intent(in) :: x(:)
         real(wp), intent(inout) :: y(:)
         y = 0.0_wp
         if (metric == by_mass) then
            call times_mass(system, tangent, 1.0_wp, x, y)
         else
            y = x/scale**2
         end if
      end subroutine apply_metric

      subroutine apply_inverse(x, y)
         real(wp), intent(in) :: x(:)
         real(wp), intent(out) :: y(:)
         solution(:n) = x
         solution(n + 1:) = 0.0_wp
         call tangent%matrix%solve(solution)
         y = solution(:n)
         if (present(but)) y = y - matmul(but, matmul(y, weighted))
      end subroutine apply_inverse

   end subroutine nearest_eigenvalues

   !> Indices in ascending order, by insertion.
   pure subroutine sort(key, order)
      !> What is compared (n)
      real(wp), intent(in) :: key(:)
      !> Index of the least, of the next, ... (n)
      integer, intent(out) :: order(:)
      integer :: i, j, item
      order = [(i, i=1, size(key))]
      do i = 2, size(key)
         item = order(i)
         do j = i - 1, 1, -1
            if (key(order(j)) <= key(item)) exit
            order(j + 1) = order(j)
         end do
         order(j + 1) = item
      end do
   end subroutine sort

end module limber_multibody_sparse_eigenmodes
