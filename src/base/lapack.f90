!> Explicit interfaces of LAPACK, BLAS and ARPACK. Those of LAPACK are called by way of limber_base_finite: nothing that is not
!> finite, and nothing empty, gets there. Floor: base. Source: LAPACK Users' Guide; Lehoucq, Sorensen and Yang, ARPACK Users' Guide.
module limber_base_lapack
   use limber_base_kinds, only: wp
   implicit none
   private
   public :: dgetrf, dgetrs, dpbtrf, dpbtrs, dsyev, dsygv, dgeev, dgeqp3, dorgqr, dgelsd, dgesvd, dsaupd, dseupd

   interface

      !> LU factors of a general matrix
      subroutine dgetrf(m, n, a, lda, ipiv, info)
         import :: wp
         integer, intent(in) :: m, n, lda
         real(wp), intent(inout) :: a(lda, *)
         integer, intent(out) :: ipiv(*), info
      end subroutine dgetrf

      !> Solution with the factors of dgetrf
      subroutine dgetrs(trans, n, nrhs, a, lda, ipiv, b, ldb, info)
         import :: wp
         character(1), intent(in) :: trans
         integer, intent(in) :: n, nrhs, lda, ldb, ipiv(*)
         real(wp), intent(in) :: a(lda, *)
         real(wp), intent(inout) :: b(ldb, *)
         integer, intent(out) :: info
      end subroutine dgetrs

      !> Cholesky factors of a symmetric positive definite band matrix
      subroutine dpbtrf(uplo, n, kd, ab, ldab, info)
         import :: wp
         character(1), intent(in) :: uplo
         integer, intent(in) :: n, kd, ldab
         real(wp), intent(inout) :: ab(ldab, *)
         integer, intent(out) :: info
      end subroutine dpbtrf

      !> Solution with the factors of dpbtrf
      subroutine dpbtrs(uplo, n, kd, nrhs, ab, ldab, b, ldb, info)
         import :: wp
         character(1), intent(in) :: uplo
         integer, intent(in) :: n, kd, nrhs, ldab, ldb
         real(wp), intent(in) :: ab(ldab, *)
         real(wp), intent(inout) :: b(ldb, *)
         integer, intent(out) :: info
      end subroutine dpbtrs

      !> All eigenvalues and eigenvectors of a symmetric matrix
      subroutine dsyev(jobz, uplo, n, a, lda, w, work, lwork, info)
         import :: wp
         character(1), intent(in) :: jobz, uplo
         integer, intent(in) :: n, lda, lwork
         real(wp), intent(inout) :: a(lda, *)
         real(wp), intent(out) :: w(*), work(*)
         integer, intent(out) :: info
      end subroutine dsyev

      !> All eigenvalues and eigenvectors of a symmetric pencil, the second matrix positive definite
      subroutine dsygv(itype, jobz, uplo, n, a, lda, b, ldb, w, work, lwork, info)
         import :: wp
         character(1), intent(in) :: jobz, uplo
         integer, intent(in) :: itype, n, lda, ldb, lwork
         real(wp), intent(inout) :: a(lda, *), b(ldb, *)
         real(wp), intent(out) :: w(*), work(*)
         integer, intent(out) :: info
      end subroutine dsygv

      !> All eigenvalues and eigenvectors of a general matrix
      subroutine dgeev(jobvl, jobvr, n, a, lda, wr, wi, vl, ldvl, vr, ldvr, work, lwork, info)
         import :: wp
         character(1), intent(in) :: jobvl, jobvr
         integer, intent(in) :: n, lda, ldvl, ldvr, lwork
         real(wp), intent(inout) :: a(lda, *)
         real(wp), intent(out) :: wr(*), wi(*), vl(ldvl, *), vr(ldvr, *), work(*)
         integer, intent(out) :: info
      end subroutine dgeev

      !> QR factors with column pivoting
      subroutine dgeqp3(m, n, a, lda, jpvt, tau, work, lwork, info)
         import :: wp
         integer, intent(in) :: m, n, lda, lwork
         real(wp), intent(inout) :: a(lda, *)
         integer, intent(inout) :: jpvt(*)
         real(wp), intent(out) :: tau(*), work(*)
         integer, intent(out) :: info
      end subroutine dgeqp3

      !> Columns of the orthogonal factor of a QR factorisation
      subroutine dorgqr(m, n, k, a, lda, tau, work, lwork, info)
         import :: wp
         integer, intent(in) :: m, n, k, lda, lwork
         real(wp), intent(inout) :: a(lda, *)
         real(wp), intent(in) :: tau(*)
         real(wp), intent(out) :: work(*)
         integer, intent(out) :: info
      end subroutine dorgqr

      !> Minimum-norm least squares by singular values, with the rank
      subroutine dgelsd(m, n, nrhs, a, lda, b, ldb, s, rcond, rank, work, lwork, iwork, info)
         import :: wp
         integer, intent(in) :: m, n, nrhs, lda, ldb, lwork
         real(wp), intent(inout) :: a(lda, *), b(ldb, *)
         real(wp), intent(in) :: rcond
         real(wp), intent(out) :: s(*), work(*)
         integer, intent(out) :: rank, iwork(*), info
      end subroutine dgelsd

      !> Singular values and vectors
      subroutine dgesvd(jobu, jobvt, m, n, a, lda, s, u, ldu, vt, ldvt, work, lwork, info)
         import :: wp
         character(1), intent(in) :: jobu, jobvt
         integer, intent(in) :: m, n, lda, ldu, ldvt, lwork
         real(wp), intent(inout) :: a(lda, *)
         real(wp), intent(out) :: s(*), u(ldu, *), vt(ldvt, *), work(*)
         integer, intent(out) :: info
      end subroutine dgesvd

      !> Reverse communication of the implicitly restarted Lanczos iteration (ARPACK)
      subroutine dsaupd(ido, bmat, n, which, nev, tol, resid, ncv, v, ldv, iparam, ipntr, workd, workl, lworkl, info)
         import :: wp
         integer, intent(inout) :: ido, iparam(11), ipntr(11), info
         character(1), intent(in) :: bmat
         character(2), intent(in) :: which
         integer, intent(in) :: n, nev, ncv, ldv, lworkl
         real(wp), intent(inout) :: tol, resid(*), v(ldv, *), workd(*), workl(*)
      end subroutine dsaupd

      !> Eigenvalues and eigenvectors from a converged dsaupd (ARPACK)
      subroutine dseupd(rvec, howmny, select, d, z, ldz, sigma, bmat, n, which, nev, tol, resid, ncv, v, ldv, &
         & iparam, ipntr, workd, workl, lworkl, info)
         import :: wp
         logical, intent(in) :: rvec
         character(1), intent(in) :: howmny, bmat
         character(2), intent(in) :: which
         integer, intent(in) :: ldz, n, nev, ncv, ldv, lworkl
         logical, intent(inout) :: select(*)
         real(wp), intent(in) :: sigma
         real(wp), intent(inout) :: tol, d(*), z(ldz, *), resid(*), v(ldv, *), workd(*), workl(*)
         integer, intent(inout) :: iparam(11), ipntr(11), info
      end subroutine dseupd

   end interface

end module limber_base_lapack
