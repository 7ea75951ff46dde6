!> Tables: functions of one argument by points. Straight between their points or a cubic spline, and constant beyond them. A table
!> is packed into an array of reals, [points, kind, arguments, values, second derivatives], which expressions carry with them.
!> Floor: deck.
module limber_deck_tables
   use limber_base_kinds, only: wp
   use limber_base_spline, only: spline_moments, spline_segment, spline_natural
   implicit none
   private
   public :: new_table, table_value, table_segment, table_range

   !> Kinds
   real(wp), parameter :: linear = 1.0_wp, cubic = 2.0_wp

contains

   !> Packs a table.
   pure function new_table(x, y, spline) result(table)
      !> Arguments in increasing order, at least two, and values there (n)
      real(wp), intent(in) :: x(:), y(:)
      !> Whether it is a spline
      logical, intent(in) :: spline
      real(wp) :: table(2 + 3*size(x))
      integer :: n
      n = size(x)
      table(1) = real(n, wp)
      table(2) = merge(cubic, linear, spline)
      table(3:2 + n) = x
      table(3 + n:2 + 2*n) = y
      table(3 + 2*n:) = 0.0_wp
      if (spline) table(3 + 2*n:) = spline_moments(x, y, spline_natural, [0.0_wp, 0.0_wp])
   end function new_table

   !> Value and first two derivatives (0:2).
   pure function table_value(table, x) result(f)
      real(wp), intent(in) :: table(:), x
      real(wp) :: f(0:2)
      integer :: n, i
      n = nint(table(1))
      i = place(table, x)
      if (i == 0) then
         f = [table(3 + n), 0.0_wp, 0.0_wp]
      else if (i == n) then
         f = [table(2 + 2*n), 0.0_wp, 0.0_wp]
      else
         f = spline_segment(table(2 + i:3 + i), table(2 + n + i:3 + n + i), table(2 + 2*n + i:3 + 2*n + i), x)
      end if
   end function table_value

   !> A number for the formula that holds at x: the segment; of a spline only before, within or behind its points.
   pure integer function table_segment(table, x) result(segment)
      real(wp), intent(in) :: table(:), x
      segment = place(table, x)
      if (table(2) > linear .and. segment > 0) segment = merge(2, 1, segment == nint(table(1)))
   end function table_segment

   !> Bounds of the values for arguments between two, which on return are those of the values; whether one formula holds there.
   pure subroutine table_range(table, low, high, whole)
      real(wp), intent(in) :: table(:)
      !> In, the arguments; out, the values
      real(wp), intent(inout) :: low, high
      logical, intent(out) :: whole
      real(wp) :: a(0:2), b(0:2), margin
      integer :: first, last, n
      n = nint(table(1))
      first = place(table, low)
      last = place(table, high)
      whole = table_segment(table, low) == table_segment(table, high)
      a = table_value(table, low)
      b = table_value(table, high)
      margin = 0.0_wp
      ! A cubic is off the line through two of its points by at most an eighth of its curvature times their distance squared
      if (table(2) > linear .and. last > 0 .and. first < n) margin = 0.125_wp*(high - low)**2* &
         & maxval(abs(table(2 + 2*n + max(1, first):2 + 2*n + min(n, last + 1))))
      low = min(a(0), b(0))
      high = max(a(0), b(0))
      if (last > first) then
         low = min(low, minval(table(3 + n + first:2 + n + last)))
         high = max(high, maxval(table(3 + n + first:2 + n + last)))
      end if
      low = low - margin
      high = high + margin
   end subroutine table_range

   !> Index of the last argument that is not above x; 0: none.
   pure integer function place(table, x) result(low)
      real(wp), intent(in) :: table(:), x
      integer :: high, middle
      low = 0
      high = nint(table(1)) + 1
      do while (high - low > 1)
         middle = (low + high)/2
         if (table(2 + middle) <= x) then
            low = middle
         else
            high = middle
         end if
      end do
   end function place

end module limber_deck_tables
