!> The dense decompositions of LAPACK for matrices that may hold what a wild deck or a diverging run has left in them: of a matrix
!> that is not finite LAPACK prints lines of its own and may not return. Here it is refused; the arguments, and all else, are as in
!> limber_base_lapack. Floor: base.
module limber_base_finite
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use limber_base_kinds, only: wp
   use limber_base_lapack, only: lapack_dsyev => dsyev, lapack_dsygv => dsygv, lapack_dgeev => dgeev, lapack_dgelsd => dgelsd, &
      & lapack_dgesvd => dgesvd
   implicit none
   private
   public :: dsyev, dsygv, dgeev, dgelsd, dgesvd, not_finite

   !> What `info` is where a matrix is not finite; its values are zero then, and there are no vectors
   integer, parameter :: not_finite = -1000

contains

   !> Whether all entries of a matrix are numbers.
   pure logical function is_finite(matrix)
      real(wp), intent(in) :: matrix(:, :)
      is_finite = all(ieee_is_finite(matrix))
   end function is_finite

   !> Whether all entries of the triangle that is used of a symmetric matrix are numbers; the other one may never have been set.
   pure logical function is_half_finite(uplo, matrix) result(finite)
      !> L or U
      character(1), intent(in) :: uplo
      real(wp), intent(in) :: matrix(:, :)
      integer :: j
      finite = .true.
      do j = 1, size(matrix, 2)
         if (uplo == 'L') then
            finite = all(ieee_is_finite(matrix(j:, j)))
         else
            finite = all(ieee_is_finite(matrix(:j, j)))
         end if
         if (.not. finite) return
      end do
   end function is_half_finite

   !> All eigenvalues and eigenvectors of a symmetric matrix.
   subroutine dsyev(jobz, uplo, n, a, lda, w, work, lwork, info)
      character(1), intent(in) :: jobz, uplo
      integer, intent(in) :: n, lda, lwork
      real(wp), intent(inout) :: a(lda, *), w(*), work(*)
      integer, intent(out) :: info
      if (is_half_finite(uplo, a(:n, :n))) then
         call lapack_dsyev(jobz, uplo, n, a, lda, w, work, lwork, info)
      else
         w(:n) = 0.0_wp
         info = not_finite
      end if
   end subroutine dsyev

   !> All eigenvalues and eigenvectors of a symmetric pencil, the second matrix positive definite.
   subroutine dsygv(itype, jobz, uplo, n, a, lda, b, ldb, w, work, lwork, info)
      character(1), intent(in) :: jobz, uplo
      integer, intent(in) :: itype, n, lda, ldb, lwork
      real(wp), intent(inout) :: a(lda, *), b(ldb, *), w(*), work(*)
      integer, intent(out) :: info
      if (is_half_finite(uplo, a(:n, :n)) .and. is_half_finite(uplo, b(:n, :n))) then
         call lapack_dsygv(itype, jobz, uplo, n, a, lda, b, ldb, w, work, lwork, info)
      else
         w(:n) = 0.0_wp
         info = not_finite
      end if
   end subroutine dsygv

   !> All eigenvalues and eigenvectors of a general matrix.
   subroutine dgeev(jobvl, jobvr, n, a, lda, wr, wi, vl, ldvl, vr, ldvr, work, lwork, info)
      character(1), intent(in) :: jobvl, jobvr
      integer, intent(in) :: n, lda, ldvl, ldvr, lwork
      real(wp), intent(inout) :: a(lda, *), wr(*), wi(*), vl(ldvl, *), vr(ldvr, *), work(*)
      integer, intent(out) :: info
      if (is_finite(a(:n, :n))) then
         call lapack_dgeev(jobvl, jobvr, n, a, lda, wr, wi, vl, ldvl, vr, ldvr, work, lwork, info)
      else
         wr(:n) = 0.0_wp
         wi(:n) = 0.0_wp
         info = not_finite
      end if
   end subroutine dgeev

   !> Minimum-norm least squares by singular values, with the rank.
   subroutine dgelsd(m, n, nrhs, a, lda, b, ldb, s, rcond, rank, work, lwork, iwork, info)
      integer, intent(in) :: m, n, nrhs, lda, ldb, lwork
      real(wp), intent(inout) :: a(lda, *), b(ldb, *), s(*), work(*)
      real(wp), intent(in) :: rcond
      integer, intent(inout) :: iwork(*)
      integer, intent(out) :: rank, info
      if (is_finite(a(:m, :n)) .and. is_finite(b(:m, :nrhs))) then
         call lapack_dgelsd(m, n, nrhs, a, lda, b, ldb, s, rcond, rank, work, lwork, iwork, info)
      else
         s(:min(m, n)) = 0.0_wp
         rank = 0
         info = not_finite
      end if
   end subroutine dgelsd

   !> Singular values and vectors.
   subroutine dgesvd(jobu, jobvt, m, n, a, lda, s, u, ldu, vt, ldvt, work, lwork, info)
      character(1), intent(in) :: jobu, jobvt
      integer, intent(in) :: m, n, lda, ldu, ldvt, lwork
      real(wp), intent(inout) :: a(lda, *), s(*), u(ldu, *), vt(ldvt, *), work(*)
      integer, intent(out) :: info
      if (is_finite(a(:m, :n))) then
         call lapack_dgesvd(jobu, jobvt, m, n, a, lda, s, u, ldu, vt, ldvt, work, lwork, info)
      else
         s(:min(m, n)) = 0.0_wp
         info = not_finite
      end if
   end subroutine dgesvd

end module limber_base_finite
