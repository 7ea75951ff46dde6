!> Decompositions of LAPACK that refuse matrices with infinities or NaNs. Of a matrix that is not finite LAPACK prints lines of its
!> own and may not return. Here it is refused. A matrix without rows or columns is done at once: LAPACK refuses leading dimensions
!> of 0. The arguments, and all else, are as in limber_base_lapack. Floor: base.
module limber_base_finite
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use limber_base_kinds, only: wp
   use limber_base_fault, only: note_fault
   use limber_base_lapack, only: lapack_dsyev => dsyev, lapack_dsygv => dsygv, lapack_dgeev => dgeev, lapack_dgelsd => dgelsd, &
      & lapack_dgesvd => dgesvd, lapack_dgetrf => dgetrf, lapack_dgetrs => dgetrs, lapack_dpbtrf => dpbtrf, &
      & lapack_dpbtrs => dpbtrs, lapack_dgeqp3 => dgeqp3, lapack_dorgqr => dorgqr
   implicit none
   private
   public :: dsyev, dsygv, dgeev, dgelsd, dgesvd, dgetrf, dgetrs, dpbtrf, dpbtrs, dgeqp3, dorgqr, unit_matrix, not_finite
   ! Every program with a call of LAPACK has limber's own XERBLA by this
   public :: note_fault

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
      info = 0
      if (n == 0) return
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
      info = 0
      if (n == 0) return
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
      info = 0
      if (n == 0) return
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
      info = 0
      rank = 0
      if (min(m, n) == 0) then
         ! The solution of least norm is zero
         if (nrhs > 0) b(:n, :nrhs) = 0.0_wp
         return
      end if
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
      info = 0
      if (min(m, n) == 0) then
         ! Any orthogonal matrices will do
         if (jobu == 'A') u(:m, :m) = unit_matrix(m)
         if (jobvt == 'A') vt(:n, :n) = unit_matrix(n)
         return
      end if
      if (is_finite(a(:m, :n))) then
         call lapack_dgesvd(jobu, jobvt, m, n, a, lda, s, u, ldu, vt, ldvt, work, lwork, info)
      else
         s(:min(m, n)) = 0.0_wp
         info = not_finite
      end if
   end subroutine dgesvd

   !> Unit matrix of n rows.
   pure function unit_matrix(n) result(unit)
      integer, intent(in) :: n
      real(wp) :: unit(n, n)
      integer :: i
      unit = 0.0_wp
      do i = 1, n
         unit(i, i) = 1.0_wp
      end do
   end function unit_matrix

   !> LU factors of a general matrix.
   subroutine dgetrf(m, n, a, lda, ipiv, info)
      integer, intent(in) :: m, n, lda
      real(wp), intent(inout) :: a(lda, *)
      integer, intent(inout) :: ipiv(*)
      integer, intent(out) :: info
      info = 0
      if (min(m, n) > 0) call lapack_dgetrf(m, n, a, lda, ipiv, info)
   end subroutine dgetrf

   !> Solution with the factors of dgetrf.
   subroutine dgetrs(trans, n, nrhs, a, lda, ipiv, b, ldb, info)
      character(1), intent(in) :: trans
      integer, intent(in) :: n, nrhs, lda, ldb, ipiv(*)
      real(wp), intent(in) :: a(lda, *)
      real(wp), intent(inout) :: b(ldb, *)
      integer, intent(out) :: info
      info = 0
      if (min(n, nrhs) > 0) call lapack_dgetrs(trans, n, nrhs, a, lda, ipiv, b, ldb, info)
   end subroutine dgetrs

   !> Cholesky factors of a symmetric positive definite band matrix.
   subroutine dpbtrf(uplo, n, kd, ab, ldab, info)
      character(1), intent(in) :: uplo
      integer, intent(in) :: n, kd, ldab
      real(wp), intent(inout) :: ab(ldab, *)
      integer, intent(out) :: info
      info = 0
      if (n > 0) call lapack_dpbtrf(uplo, n, kd, ab, ldab, info)
   end subroutine dpbtrf

   !> Solution with the factors of dpbtrf.
   subroutine dpbtrs(uplo, n, kd, nrhs, ab, ldab, b, ldb, info)
      character(1), intent(in) :: uplo
      integer, intent(in) :: n, kd, nrhs, ldab, ldb
      real(wp), intent(in) :: ab(ldab, *)
      real(wp), intent(inout) :: b(ldb, *)
      integer, intent(out) :: info
      info = 0
      if (min(n, nrhs) > 0) call lapack_dpbtrs(uplo, n, kd, nrhs, ab, ldab, b, ldb, info)
   end subroutine dpbtrs

   !> QR factors with column pivoting.
   subroutine dgeqp3(m, n, a, lda, jpvt, tau, work, lwork, info)
      integer, intent(in) :: m, n, lda, lwork
      real(wp), intent(inout) :: a(lda, *), tau(*), work(*)
      integer, intent(inout) :: jpvt(*)
      integer, intent(out) :: info
      info = 0
      if (min(m, n) > 0) call lapack_dgeqp3(m, n, a, lda, jpvt, tau, work, lwork, info)
   end subroutine dgeqp3

   !> Columns of the orthogonal factor of a QR factorisation.
   subroutine dorgqr(m, n, k, a, lda, tau, work, lwork, info)
      integer, intent(in) :: m, n, k, lda, lwork
      real(wp), intent(inout) :: a(lda, *), work(*)
      real(wp), intent(in) :: tau(*)
      integer, intent(out) :: info
      info = 0
      if (min(m, n) > 0) call lapack_dorgqr(m, n, k, a, lda, tau, work, lwork, info)
   end subroutine dorgqr

end module limber_base_finite
