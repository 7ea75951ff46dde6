!> Factors of small sparse matrices, up to six unknowns, up to forty, and above (by KLU), real and complex: known solutions of
!> matrices that are scaled badly, have zeros on the diagonal or dependent equations, and of values for which the pivots of those
!> before are unfit; singular matrices are told.
program test_elimination
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_multibody_sparse_matrix, only: sparse_type
   use scenes, only: random
   use testing, only: check, check_close, finish
   implicit none
   integer, parameter :: sizes(6) = [3, 7, 13, 26, 40, 60]
   integer :: i

   do i = 1, size(sizes)
      call check_random(sizes(i))
      call check_scales(sizes(i))
      call check_saddle(sizes(i))
      call check_redundant(sizes(i))
      call check_singular(sizes(i))
      if (sizes(i) <= 40) call check_unfit(sizes(i))
      if (sizes(i) <= 40) call check_followed(sizes(i))
   end do
   call finish()

contains

   !> A tenth of all places, a block without gaps, and the diagonal; twenty times other values.
   subroutine check_random(n)
      integer, intent(in) :: n
      real(wp) :: a(n, n), b(n, n)
      type(sparse_type) :: matrix
      integer :: round
      a = spread_numbers(n)
      call set_pattern(matrix, abs(a) > 0.0_wp)
      do round = 1, 20
         b = a
         call vary(b, 0.3_wp)
         call check_solution(matrix, b, 1.0e-11_wp, 'random, '//as_text(n))
      end do
      call check(matrix%searches <= 20, 'pivots serve again, '//as_text(n))
   end subroutine check_random

   !> Equations and unknowns in units from 1e-8 to 1e8: the solution is as good, each unknown in its unit.
   subroutine check_scales(n)
      integer, intent(in) :: n
      real(wp) :: a(n, n), left(n), right(n), x(n), y(n)
      type(sparse_type) :: matrix
      logical :: singular
      integer :: i, j
      a = spread_numbers(n)
      call set_pattern(matrix, abs(a) > 0.0_wp)
      do i = 1, n
         left(i) = 10.0_wp**nint(8*random())
         right(i) = 10.0_wp**nint(8*random())
         x(i) = random()
      end do
      do j = 1, n
         a(:, j) = left*a(:, j)*right(j)
      end do
      y = matmul(a, x/right)
      call fill(matrix, a)
      call matrix%factor(singular)
      call check(.not. singular, 'badly scaled, '//as_text(n))
      call matrix%solve(y)
      call check_close(maxval(abs(y*right - x)), 0.0_wp, 1.0e-9_wp, 'badly scaled, '//as_text(n))
   end subroutine check_scales

   !> Masses and constraint equations: no entries on the second half of the diagonal.
   subroutine check_saddle(n)
      integer, intent(in) :: n
      real(wp) :: a(n, n)
      type(sparse_type) :: matrix
      a = saddle(n)
      call set_pattern(matrix, abs(a) > 0.0_wp)
      call check_solution(matrix, a, 1.0e-10_wp, 'constraints, '//as_text(n))
      call vary(a, 0.2_wp)
      call check_solution(matrix, a, 1.0e-10_wp, 'constraints again, '//as_text(n))
   end subroutine check_saddle

   !> The last constraint equation twice, each a little soft: the sum of both multipliers is that of one, the rest as without the
   !> second.
   subroutine check_redundant(n)
      integer, intent(in) :: n
      real(wp), parameter :: soft = 1.0e-9_wp
      real(wp) :: a(n + 1, n + 1), b(n, n), x(n + 1), y(n)
      type(sparse_type) :: matrix, plain
      logical :: singular
      integer :: i
      b = saddle(n)
      a = 0.0_wp
      a(:n, :n) = b
      a(n + 1, :n) = b(n, :)
      a(:n, n + 1) = b(:, n)
      a(n, n) = -soft
      a(n + 1, n + 1) = -soft
      b(n, n) = -0.5_wp*soft
      call set_pattern(matrix, abs(a) > 0.0_wp)
      call set_pattern(plain, abs(b) > 0.0_wp)
      y = [(cos(1.0_wp*i), i=1, n)]
      x = [y, y(n)]
      call fill(matrix, a)
      call matrix%factor(singular)
      call check(.not. singular, 'redundant, '//as_text(n))
      call matrix%solve(x)
      call fill(plain, b)
      call plain%factor(singular)
      call plain%solve(y)
      call check_close(maxval(abs(x(:n - 1) - y(:n - 1)))/maxval(abs(y)), 0.0_wp, 1.0e-6_wp, 'redundant, '//as_text(n))
      call check_close((x(n) + x(n + 1) - y(n))/maxval(abs(y)), 0.0_wp, 1.0e-6_wp, 'sum of multipliers, '//as_text(n))
   end subroutine check_redundant

   !> An equation twice, and an equation without entries, of whole numbers: no round-off hides that there is no pivot. Then a matrix
   !> that has a solution.
   subroutine check_singular(n)
      integer, intent(in) :: n
      real(wp) :: a(n, n)
      type(sparse_type) :: matrix
      logical :: singular
      integer :: i
      a = 0.0_wp
      do i = 1, n - 1
         a(i, i) = 1.0_wp
         a(i, i + 1) = -1.0_wp
      end do
      a(n, :) = a(1, :)
      call set_pattern(matrix, abs(a) > 0.0_wp)
      call fill(matrix, a)
      call matrix%factor(singular)
      call check(singular, 'an equation twice, '//as_text(n))
      call set_complex(matrix)
      call matrix%factor_complex(singular)
      call check(singular, 'a complex equation twice, '//as_text(n))
      a(n, 1) = -1.0_wp
      call check_solution(matrix, a, 1.0e-10_wp, 'behind a singular matrix, '//as_text(n))
      a(n, :) = 0.0_wp
      call fill(matrix, a)
      call matrix%factor(singular)
      call check(singular, 'an equation of nothing, '//as_text(n))
   end subroutine check_singular

   !> Values under which the first pivots are nearly zero: others are sought. (Those of KLU are looked at one time in eight only.)
   subroutine check_unfit(n)
      integer, intent(in) :: n
      real(wp) :: a(n, n)
      type(sparse_type) :: matrix
      integer :: i, searches
      a = 0.0_wp
      do i = 1, n
         a(i, i) = 1.0_wp
         a(i, modulo(i, n) + 1) = 0.01_wp
      end do
      call set_pattern(matrix, abs(a) > 0.0_wp)
      call check_solution(matrix, a, 1.0e-12_wp, 'large diagonal, '//as_text(n))
      searches = matrix%searches
      do i = 1, n
         a(i, i) = 1.0e-13_wp*i
         a(i, modulo(i, n) + 1) = 1.0_wp
      end do
      call check_solution(matrix, a, 1.0e-12_wp, 'small diagonal, '//as_text(n))
      if (n > 6) call check(matrix%searches > searches, 'new pivots, '//as_text(n))
   end subroutine check_unfit

   !> Pivots of another matrix of the same pattern serve. One of six unknowns seeks its own.
   subroutine check_followed(n)
      integer, intent(in) :: n
      real(wp) :: a(n, n), b(n, n)
      type(sparse_type) :: first, second
      a = saddle(n)
      call set_pattern(first, abs(a) > 0.0_wp)
      call set_pattern(second, abs(a) > 0.0_wp)
      call check_solution(first, a, 1.0e-10_wp, 'followed, '//as_text(n))
      if (n > 6) call check(first%searches == 1, 'one search for real and complex values, '//as_text(n))
      b = a
      call vary(b, 0.2_wp)
      call second%follow_pivots(first)
      call check_solution(second, b, 1.0e-10_wp, 'following, '//as_text(n))
      if (n > 6) call check(second%searches == 0, 'no search of its own, '//as_text(n))
   end subroutine check_followed

   !> Real and complex solutions with known ones.
   subroutine check_solution(matrix, a, tolerance, name)
      type(sparse_type), intent(inout) :: matrix
      real(wp), intent(in) :: a(:, :), tolerance
      character(*), intent(in) :: name
      complex(wp) :: z(size(a, 1)), c(size(a, 1))
      real(wp) :: x(size(a, 1)), b(size(a, 1))
      logical :: singular
      integer :: i
      do i = 1, size(x)
         x(i) = random()
         z(i) = cmplx(random(), random(), wp)
      end do
      b = matmul(a, x)
      call fill(matrix, a)
      call matrix%factor(singular)
      call check(.not. singular, name//': not singular')
      if (singular) return
      call matrix%solve(b)
      call check_close(maxval(abs(b - x)), 0.0_wp, tolerance, name)
      ! (A + i A/2) z
      c = cmplx(1.0_wp, 0.5_wp, wp)*matmul(a, z)
      call set_complex(matrix)
      call matrix%factor_complex(singular)
      call check(.not. singular, name//': not singular, complex')
      if (singular) return
      call matrix%solve_complex(c)
      call check_close(maxval(abs(c - z)), 0.0_wp, tolerance, name//', complex')
   end subroutine check_solution

   !> Complex values from the real ones.
   subroutine set_complex(matrix)
      type(sparse_type), intent(inout) :: matrix
      if (.not. allocated(matrix%complex_values)) allocate (matrix%complex_values(size(matrix%values)))
      matrix%complex_values = cmplx(1.0_wp, 0.5_wp, wp)*matrix%values
   end subroutine set_complex

   !> Marks the places that are held.
   subroutine set_pattern(matrix, held)
      type(sparse_type), intent(inout) :: matrix
      logical, intent(in) :: held(:, :)
      integer :: i, j
      do j = 1, size(held, 2)
         do i = 1, size(held, 1)
            if (held(i, j)) call matrix%mark(i, j)
         end do
      end do
      call matrix%analyse(size(held, 1))
   end subroutine set_pattern

   !> Puts values into the places of the pattern.
   subroutine fill(matrix, a)
      type(sparse_type), intent(inout) :: matrix
      real(wp), intent(in) :: a(:, :)
      integer :: i, j
      matrix%values = 0.0_wp
      do j = 1, size(a, 2)
         do i = 1, size(a, 1)
            if (matrix%holds(i, j)) matrix%values(matrix%place(i, j)) = a(i, j)
         end do
      end do
   end subroutine fill

   !> Random numbers in a tenth of the places and a block, ones and more on the diagonal.
   function spread_numbers(n) result(a)
      integer, intent(in) :: n
      real(wp) :: a(n, n)
      integer :: i, j
      a = 0.0_wp
      do j = 1, n
         do i = 1, n
            if (random() > 0.8_wp .or. (abs(i - n/2) < n/5 .and. abs(j - n/2) < n/5)) a(i, j) = random()
            if (i == j) a(i, j) = 3.0_wp + random()
         end do
      end do
   end function spread_numbers

   !> Masses of the first two thirds of the unknowns, constraint equations of the others: each on three of the masses.
   function saddle(n) result(a)
      integer, intent(in) :: n
      real(wp) :: a(n, n)
      integer :: i, k, masses
      masses = (2*n + 2)/3
      a = 0.0_wp
      do i = 1, masses
         a(i, i) = 2.0_wp + random()
      end do
      do i = masses + 1, n
         do k = 0, 2
            a(i, modulo(2*(i - masses) - 2 + k, masses) + 1) = 1.0_wp + 0.5_wp*random()
         end do
         a(:masses, i) = a(i, :masses)
      end do
   end function saddle

   !> Changes all entries by a part of themselves.
   subroutine vary(a, part)
      real(wp), intent(inout) :: a(:, :)
      real(wp), intent(in) :: part
      integer :: i, j
      do j = 1, size(a, 2)
         do i = 1, size(a, 1)
            a(i, j) = a(i, j)*(1 + part*random())
         end do
      end do
   end subroutine vary

end program test_elimination
