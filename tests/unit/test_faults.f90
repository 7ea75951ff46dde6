!> What libraries complain of: an impossible argument does not end the process, and empty matrices are no complaint.
program test_faults
   use limber_base_error, only: error_type, status_run
   use limber_base_fault, only: add_fault, forget_fault
   use limber_base_finite, only: dsyev, dsygv, dgeev, dgelsd, dgesvd, dgetrf, dgetrs, dpbtrf, dpbtrs, dgeqp3, dorgqr
   use limber_base_kinds, only: wp
   use limber_base_lapack, only: lapack_dsyev => dsyev
   use testing, only: check, check_close, finish
   implicit none
   call test_complaint()
   call test_empty()
   call test_half_empty()
   call finish()

contains

   !> A leading dimension of 0: LAPACK's own XERBLA would end this test with status 0, unnoticed but for `finish`.
   subroutine test_complaint()
      real(wp) :: matrix(2, 2), value(2), work(16)
      type(error_type), allocatable :: error
      integer :: info
      call add_fault(error)
      call check(.not. allocated(error), 'no complaint before')
      matrix = 1.0_wp
      call lapack_dsyev('N', 'L', 2, matrix, 0, value, work, 16, info)
      call check(info == -5, 'LAPACK returns')
      call add_fault(error)
      call check(allocated(error), 'the complaint is an error')
      if (.not. allocated(error)) return
      call check(index(error%message, 'DSYEV refused its argument 5') > 0, error%message)
      call check(error%status == status_run, 'status')
      error%message = 'no convergence'
      call add_fault(error)
      call check(index(error%message, 'no convergence') == 1 .and. index(error%message, 'DSYEV') > 0, 'cause of another error')
      call forget_fault()
      deallocate (error)
      call add_fault(error)
      call check(.not. allocated(error), 'forgotten')
   end subroutine test_complaint

   !> No routine sees a matrix without rows and columns.
   subroutine test_empty()
      real(wp) :: matrix(0, 0), value(0), vector(0, 1), other(0), work(8), left(1, 1), band(1, 0)
      integer :: pivot(0), integers(8), info, rank, n
      type(error_type), allocatable :: error
      n = 0
      call dsyev('V', 'L', n, matrix, n, value, work, 8, info)
      call check(info == 0, 'dsyev')
      call dsygv(1, 'V', 'L', n, matrix, n, matrix, n, value, work, 8, info)
      call check(info == 0, 'dsygv')
      call dgeev('N', 'V', n, matrix, n, value, other, left, 1, matrix, n, work, 8, info)
      call check(info == 0, 'dgeev')
      call dgelsd(n, n, 1, matrix, n, vector, n, value, 1.0e-10_wp, rank, work, 8, integers, info)
      call check(info == 0 .and. rank == 0, 'dgelsd')
      call dgesvd('A', 'A', n, n, matrix, n, value, matrix, n, matrix, n, work, 8, info)
      call check(info == 0, 'dgesvd')
      call dgetrf(n, n, matrix, n, pivot, info)
      call check(info == 0, 'dgetrf')
      call dgetrs('N', n, 1, matrix, n, pivot, vector, n, info)
      call check(info == 0, 'dgetrs')
      call dpbtrf('L', n, 0, band, 1, info)
      call check(info == 0, 'dpbtrf')
      call dpbtrs('L', n, 0, 1, band, 1, vector, n, info)
      call check(info == 0, 'dpbtrs')
      call dgeqp3(n, n, matrix, n, pivot, value, work, 8, info)
      call check(info == 0, 'dgeqp3')
      call dorgqr(n, n, 0, matrix, n, value, work, 8, info)
      call check(info == 0, 'dorgqr')
      call add_fault(error)
      call check(.not. allocated(error), 'no complaint of empty matrices')
   end subroutine test_empty

   !> Rows without columns, columns without rows: the solution of least norm is zero, all directions are in the null space.
   subroutine test_half_empty()
      real(wp) :: wide(0, 2), tall(2, 0), right(2, 1), value(0), work(8), left(2, 2), turned(2, 2)
      integer :: integers(8), info, rank
      right = 7.0_wp
      call dgelsd(0, 2, 1, wide, 0, right, 2, value, 1.0e-10_wp, rank, work, 8, integers, info)
      call check_close(sum(abs(right)), 0.0_wp, 0.0_wp, 'least norm')
      call dgesvd('A', 'N', 2, 0, tall, 2, value, left, 2, turned, 1, work, 8, info)
      call check_close(sum(abs(left - reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [2, 2]))), 0.0_wp, 0.0_wp, 'left vectors')
      call dgesvd('N', 'A', 0, 2, wide, 0, value, left, 1, turned, 2, work, 8, info)
      call check_close(sum(abs(turned - reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [2, 2]))), 0.0_wp, 0.0_wp, 'right vectors')
   end subroutine test_half_empty

end program test_faults
