!> Linear complementarity problems: z and w = G z + b, both at least zero, one of each pair zero. Lemke's method, which ends at a
!> solution for symmetric G without negative eigenvalues, if there is one. Its solution is basic: columns of G whose z is positive
!> are independent. Floor: multibody. Source: doc/theory, eqs. (5.87), (5.89); cottle1992, section 4.4.
module limber_multibody_complementarity
   use limber_base_kinds, only: wp
   implicit none
   private
   public :: solve_complementarity

   !> Pivots that count as zero, and right-hand sides that count as negative, of a problem with the diagonal one
   real(wp), parameter :: nothing = 1.0e-11_wp, negative = 1.0e-14_wp

contains

   !> Solves one problem. Units of the rows may differ: they are scaled by the diagonal.
   subroutine solve_complementarity(g, b, z, solved)
      !> Symmetric, no negative eigenvalues (n, n); (n)
      real(wp), intent(in) :: g(:, :), b(:)
      !> (n)
      real(wp), intent(out) :: z(:)
      !> False if there is no solution
      logical, intent(out) :: solved
      real(wp) :: scaled(size(b), size(b)), right(size(b)), d(size(b)), largest, most
      integer :: i, j
      z = 0.0_wp
      solved = .true.
      if (.not. any(b < 0.0_wp)) return
      most = maxval([(g(i, i), i=1, size(b))])
      do i = 1, size(b)
         d(i) = sqrt(max(g(i, i), 0.0_wp))
         ! Nothing that gives way: it stays where it is, and cannot be helped
         if (g(i, i) > epsilon(most)*epsilon(most)*most) cycle
         d(i) = 1.0_wp
         if (b(i) < 0.0_wp) solved = .false.
      end do
      if (.not. solved) return
      right = b/d
      largest = maxval(abs(right))
      do j = 1, size(b)
         scaled(:, j) = g(:, j)/d/d(j)
      end do
      call pivot_to_end(scaled, right/largest, z, solved)
      z = z*largest/d
   end subroutine solve_complementarity

   !> Lemke's method: the artificial variable makes all w positive, and leaves after some exchanges of complementary variables.
   subroutine pivot_to_end(g, b, z, solved)
      !> Of order one (n, n), (n)
      real(wp), intent(in) :: g(:, :), b(:)
      real(wp), intent(out) :: z(:)
      logical, intent(out) :: solved
      !> Rows: basic variables; columns: w, z, artificial, right-hand side
      real(wp) :: table(size(b), 2*size(b) + 2)
      integer :: basis(size(b)), n, i, row, enters, leaves
      n = size(b)
      table = 0.0_wp
      do i = 1, n
         table(i, i) = 1.0_wp
         basis(i) = i
      end do
      table(:, n + 1:2*n) = -g
      table(:, 2*n + 1) = -1.0_wp
      table(:, 2*n + 2) = b
      z = 0.0_wp
      solved = .true.
      row = minloc(b, dim=1)
      if (b(row) >= -negative) return
      enters = 2*n + 1
      leaves = 0
      do i = 1, 50*(n + 1)
         leaves = basis(row)
         call exchange(table, row, enters)
         basis(row) = enters
         if (leaves == 2*n + 1) exit
         enters = merge(leaves + n, leaves - n, leaves <= n)
         row = least_ratio(table, basis, enters)
         if (row == 0) exit
      end do
      solved = leaves == 2*n + 1
      do i = 1, n
         if (basis(i) > n .and. basis(i) <= 2*n) z(basis(i) - n) = max(table(i, 2*n + 2), 0.0_wp)
      end do
   end subroutine pivot_to_end

   !> Row of the basic variable that becomes zero first as another grows, the artificial one before others; 0: none does.
   pure integer function least_ratio(table, basis, enters) result(row)
      real(wp), intent(in) :: table(:, :)
      integer, intent(in) :: basis(:), enters
      real(wp) :: ratio, least
      integer :: i, last
      last = size(table, 2)
      row = 0
      least = huge(least)
      do i = 1, size(basis)
         if (table(i, enters) <= nothing) cycle
         ratio = table(i, last)/table(i, enters)
         if (basis(i) == last - 1 .and. ratio <= least + negative) then
            row = i
            least = min(ratio, least)
         else if (ratio < least - negative) then
            row = i
            least = ratio
         end if
      end do
   end function least_ratio

   !> Makes a variable basic in the place of that of a row.
   pure subroutine exchange(table, row, enters)
      real(wp), intent(inout) :: table(:, :)
      integer, intent(in) :: row, enters
      integer :: i
      table(row, :) = table(row, :)/table(row, enters)
      do i = 1, size(table, 1)
         if (i /= row) table(i, :) = table(i, :) - table(i, enters)*table(row, :)
      end do
   end subroutine exchange

end module limber_multibody_complementarity
