!> What keeps a wild deck from taking for ever: runs end when their time is over, at each step and increment and not at samples
!> only; matrices that are not finite are refused before LAPACK. Usage, in tests/: test_limits FILE
program test_limits
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
   use limber_base_error, only: error_type
   use limber_base_finite, only: dsyev, dsygv, dgeev, dgelsd, dgesvd, not_finite
   use limber_base_kinds, only: wp
   use limber_commands_batch, only: batch_type
   use limber_commands_run, only: run_one
   use testing, only: check, check_close, finish
   implicit none

   call check_analysis('*DYNAMICS, END=1e6, OUTPUTS=1', 'dynamics')
   call check_analysis('*STATICS, INCREMENTS=1', 'statics')
   call check_analysis('*KINEMATICS, END=1e6, OUTPUTS=1', 'kinematics')
   call check_decompositions()
   call check_half()
   call finish()

contains

   !> A driven pendulum whose time is over before it begins is given up long before its only sample.
   subroutine check_analysis(analysis, name)
      !> Line of the deck
      character(*), intent(in) :: analysis, name
      type(batch_type) :: batch
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      character(200) :: path
      integer :: unit
      call get_command_argument(1, path)
      open (newunit=unit, file=trim(path)//'.inp', action='write', status='replace')
      write (unit, '(a)') '*RIGID BODY, NAME=rod, MASS=1, INERTIA=1, CENTRE X=1', '*JOINT, NAME=pin, TYPE=REVOLUTE', &
         & ' rod.origin, ground.origin', '*GRAVITY', analysis, '*OUTPUT', ' angle(rod)'
      if (name == 'kinematics') write (unit, '(a)') '*DRIVER, NAME=motor, TYPE=ANGLE, BODY=rod', ' t'
      if (name == 'dynamics') write (unit, '(a)') '*TORQUE, NAME=push, BODY=rod', ' sin(t)'
      close (unit)
      allocate (batch%overrides(0))
      batch%unkept = .true.
      batch%limit = merge(0.02_wp, 1.0e-9_wp, name == 'dynamics')
      call run_one(trim(path)//'.inp', trim(path), .true., .true., batch, report, error)
      call check(allocated(error), name//' is given up')
      if (.not. allocated(error)) return
      call check(index(error%message, 'given up after') > 0, name//': '//error%message)
   end subroutine check_analysis

   !> The decompositions are those of LAPACK, and refuse a matrix with one entry that is no number.
   subroutine check_decompositions()
      real(wp) :: a(2, 2), b(2, 2), values(2), other(2), vectors(2, 2), left(2, 2), work(2000), right(2, 1)
      integer :: info, rank, integers(50), k
      do k = 1, 2
         a = matrix(k)
         call dsyev('V', 'L', 2, a, 2, values, work, size(work), info)
         call expect('dsyev', k, info, [1.0_wp, 3.0_wp], values)
         a = matrix(k)
         b = reshape([2.0_wp, 0.0_wp, 0.0_wp, 2.0_wp], [2, 2])
         call dsygv(1, 'V', 'L', 2, a, 2, b, 2, values, work, size(work), info)
         call expect('dsygv', k, info, [0.5_wp, 1.5_wp], values)
         a = matrix(k)
         call dgeev('N', 'V', 2, a, 2, values, other, left, 2, vectors, 2, work, size(work), info)
         call expect('dgeev', k, info, [1.0_wp, 3.0_wp], [minval(values), maxval(values)])
         a = matrix(k)
         right(:, 1) = [3.0_wp, 3.0_wp]
         call dgelsd(2, 2, 1, a, 2, right, 2, values, 1.0e-10_wp, rank, work, size(work), integers, info)
         call expect('dgelsd', k, info, [3.0_wp, 1.0_wp], values)
         if (k == 1) call check_close(maxval(abs(right - 1.0_wp)), 0.0_wp, 1.0e-14_wp, 'dgelsd: its solution')
         a = matrix(k)
         call dgesvd('N', 'N', 2, 2, a, 2, values, left, 2, vectors, 2, work, size(work), info)
         call expect('dgesvd', k, info, [3.0_wp, 1.0_wp], values)
      end do
   end subroutine check_decompositions

   !> Of a symmetric matrix only the triangle counts that is named.
   subroutine check_half()
      real(wp) :: a(2, 2), values(2), work(200)
      integer :: info
      a = matrix(1)
      a(1, 2) = ieee_value(1.0_wp, ieee_quiet_nan)
      call dsyev('N', 'L', 2, a, 2, values, work, size(work), info)
      call expect('dsyev, the lower half', 1, info, [1.0_wp, 3.0_wp], values)
      a = matrix(2)
      call dsyev('N', 'U', 2, a, 2, values, work, size(work), info)
      call expect('dsyev, the upper half', 1, info, [1.0_wp, 3.0_wp], values)
   end subroutine check_half

   !> First a matrix with the eigenvalues 1 and 3, then one with a hole.
   function matrix(k) result(a)
      integer, intent(in) :: k
      real(wp) :: a(2, 2)
      a = reshape([2.0_wp, 1.0_wp, 1.0_wp, 2.0_wp], [2, 2])
      if (k == 2) a(2, 1) = ieee_value(1.0_wp, ieee_quiet_nan)
   end function matrix

   subroutine expect(name, k, info, wanted, found)
      character(*), intent(in) :: name
      integer, intent(in) :: k, info
      real(wp), intent(in) :: wanted(2), found(2)
      if (k == 1) then
         call check(info == 0, name//' succeeds')
         call check_close(maxval(abs(found - wanted)), 0.0_wp, 1.0e-14_wp, name//': its values')
      else
         call check(info == not_finite, name//' refuses NaN')
         call check_close(maxval(abs(found)), 0.0_wp, 0.0_wp, name//': no values of NaN')
      end if
   end subroutine expect

end program test_limits
