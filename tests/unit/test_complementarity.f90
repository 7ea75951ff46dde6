!> Linear complementarity problems: random ones with and without redundant rows, rows of different units, degenerate ones, ones
!> without a solution.
program test_complementarity
   use limber_base_kinds, only: wp
   use limber_multibody_complementarity, only: solve_complementarity
   use testing, only: check, check_close, finish
   implicit none

   !> State of the generator of random numbers
   integer :: seed = 4711
   integer :: i

   do i = 1, 300
      call check_random(1 + modulo(i, 9), 12)
      call check_random(1 + modulo(i, 9), 1 + modulo(i, 4))
   end do
   call check_row(20)
   call check_stuck()
   call finish()

contains

   !> A number from -1 to 1 (Park and Miller).
   real(wp) function random()
      integer, parameter :: most = 2147483647
      seed = 16807*modulo(seed, 127773) - 2836*(seed/127773)
      if (seed <= 0) seed = seed + most
      random = 2*real(seed, wp)/most - 1
   end function random

   !> A problem of some contacts of a body with some coordinates: redundant where there are more contacts. Right-hand sides are
   !> those of a motion, so that there is a solution.
   subroutine check_random(contacts, coordinates)
      integer, intent(in) :: contacts, coordinates
      real(wp) :: rows(coordinates, contacts), g(contacts, contacts), b(contacts), z(contacts), w(contacts), way(coordinates), scale
      logical :: solved
      integer :: j, k
      do k = 1, coordinates
         ! One direction in which all gaps open
         way(k) = random()
      end do
      do j = 1, contacts
         do k = 1, coordinates
            rows(k, j) = random()
         end do
         if (dot_product(rows(:, j), way) < 0.0_wp) rows(:, j) = -rows(:, j)
         ! Units of its own
         rows(:, j) = rows(:, j)*10.0_wp**nint(3*random())
      end do
      do k = 1, coordinates
         way(k) = random()
      end do
      g = matmul(transpose(rows), rows)
      b = matmul(transpose(rows), way)
      call solve_complementarity(g, b, z, solved)
      call check(solved, 'random problem: solved')
      w = matmul(g, z) + b
      do j = 1, contacts
         scale = norm2(rows(:, j))
         call check(z(j) >= 0.0_wp, 'random problem: z')
         call check(w(j) >= -1.0e-9_wp*scale, 'random problem: w')
         call check(w(j)*z(j) <= 1.0e-9_wp, 'random problem: one of each pair is zero')
      end do
      call check(count(z > 0.0_wp) <= coordinates, 'random problem: independent contacts only')
   end subroutine check_random

   !> Equal balls that touch, the first one struck: all go on together, z(k) = (n + 1 - k)/(n + 1).
   subroutine check_row(n)
      integer, intent(in) :: n
      real(wp) :: g(n, n), b(n), z(n)
      logical :: solved
      integer :: j
      g = 0.0_wp
      do j = 1, n
         g(j, j) = 2.0_wp
      end do
      do j = 2, n
         g(j, j - 1) = -1.0_wp
         g(j - 1, j) = -1.0_wp
      end do
      b = 0.0_wp
      b(1) = -1.0_wp
      call solve_complementarity(g, b, z, solved)
      call check(solved, 'row: solved')
      do j = 1, n
         call check_close(z(j), real(n + 1 - j, wp)/(n + 1), 1.0e-12_wp, 'row')
      end do
   end subroutine check_row

   !> Between two walls that come together nothing helps; nor where nothing gives way.
   subroutine check_stuck()
      real(wp) :: z(2), one(1)
      logical :: solved
      call solve_complementarity(reshape([1.0_wp, -1.0_wp, -1.0_wp, 1.0_wp], [2, 2]), [-1.0_wp, -0.5_wp], z, solved)
      call check(.not. solved, 'two walls')
      call solve_complementarity(reshape([0.0_wp], [1, 1]), [-1.0_wp], one, solved)
      call check(.not. solved, 'what does not give way')
      call solve_complementarity(reshape([0.0_wp], [1, 1]), [1.0_wp], one, solved)
      call check(solved, 'what does not approach')
   end subroutine check_stuck

end program test_complementarity
