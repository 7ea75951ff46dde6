!> Cubic splines with continuous second derivatives. Tables, curves of joints, the line of a beam. Floor: base. Source: de Boor, A
!> Practical Guide to Splines, chapter IV.
module limber_base_spline
   use limber_base_kinds, only: wp
   implicit none
   private
   public :: spline_type, new_spline, spline_moments, spline_at, spline_segment

   !> What holds at the ends: no curvature, and straight beyond; given slopes; the end is the start again
   integer, parameter, public :: spline_natural = 1, spline_clamped = 2, spline_closed = 3

   !> A spline
   type :: spline_type
      !> What holds at the ends
      integer :: ends = spline_natural
      !> Knots in increasing order, values and second derivatives there (n)
      real(wp), allocatable :: x(:), y(:), m(:)
   contains
      procedure :: evaluate => spline_evaluate
   end type spline_type

contains

   !> The spline through points.
   pure function new_spline(x, y, ends, slopes) result(spline)
      !> At least two knots in increasing order, and values there (n); of a closed one the last value is the first
      real(wp), intent(in) :: x(:), y(:)
      integer, intent(in) :: ends
      !> Of a clamped one: slopes at both ends
      real(wp), intent(in), optional :: slopes(2)
      type(spline_type) :: spline
      spline%ends = ends
      allocate (spline%x(size(x)), source=x)
      allocate (spline%y(size(x)), source=y)
      allocate (spline%m(size(x)))
      if (present(slopes)) then
         spline%m = spline_moments(x, y, ends, slopes)
      else
         spline%m = spline_moments(x, y, ends, [0.0_wp, 0.0_wp])
      end if
   end function new_spline

   !> Second derivatives at the knots (n).
   pure function spline_moments(x, y, ends, slopes) result(m)
      real(wp), intent(in) :: x(:), y(:)
      integer, intent(in) :: ends
      real(wp), intent(in) :: slopes(2)
      real(wp) :: m(size(x)), a(size(x)), b(size(x)), c(size(x)), d(size(x)), e(size(x)), h(size(x)), s(size(x))
      integer :: i, n
      n = size(x)
      h(:n - 1) = x(2:) - x(:n - 1)
      s(:n - 1) = (y(2:) - y(:n - 1))/h(:n - 1)
      a = 0.0_wp
      b = 1.0_wp
      c = 0.0_wp
      d = 0.0_wp
      do i = 2, n - 1
         a(i) = h(i - 1)/6
         b(i) = (h(i - 1) + h(i))/3
         c(i) = h(i)/6
         d(i) = s(i) - s(i - 1)
      end do
      select case (ends)
      case (spline_clamped)
         b(1) = h(1)/3
         c(1) = h(1)/6
         d(1) = s(1) - slopes(1)
         a(n) = h(n - 1)/6
         b(n) = h(n - 1)/3
         d(n) = slopes(2) - s(n - 1)
      case (spline_closed)
         ! with m(n) = m(1) as a parameter: m = d + e m(1), and the equation at the first knot
         e = 0.0_wp
         e(1) = 1.0_wp
         e(n) = 1.0_wp
         call solve(a, b, c, d, e)
         m(1) = (s(1) - s(n - 1) - h(n - 1)/6*d(n - 1) - h(1)/6*d(2)) &
            & /((h(n - 1) + h(1))/3 + h(n - 1)/6*e(n - 1) + h(1)/6*e(2))
         m(2:) = d(2:) + e(2:)*m(1)
         return
      end select
      e = 0.0_wp
      call solve(a, b, c, d, e)
      m = d
   end function spline_moments

   !> Solves two systems with one tridiagonal matrix.
   pure subroutine solve(a, b, c, d, e)
      !> Below, on and above the diagonal
      real(wp), intent(in) :: a(:), b(:), c(:)
      !> Right-hand sides; solutions
      real(wp), intent(inout) :: d(:), e(:)
      real(wp) :: pivot(size(b)), factor
      integer :: i
      pivot = b
      do i = 2, size(b)
         factor = a(i)/pivot(i - 1)
         pivot(i) = b(i) - factor*c(i - 1)
         d(i) = d(i) - factor*d(i - 1)
         e(i) = e(i) - factor*e(i - 1)
      end do
      d(size(b)) = d(size(b))/pivot(size(b))
      e(size(b)) = e(size(b))/pivot(size(b))
      do i = size(b) - 1, 1, -1
         d(i) = (d(i) - c(i)*d(i + 1))/pivot(i)
         e(i) = (e(i) - c(i)*e(i + 1))/pivot(i)
      end do
   end subroutine solve

   !> Value and first two derivatives (0:2) at a place.
   pure function spline_evaluate(self, x) result(f)
      class(spline_type), intent(in) :: self
      real(wp), intent(in) :: x
      real(wp) :: f(0:2)
      f = spline_at(self%ends, self%x, self%y, self%m, x)
   end function spline_evaluate

   !> The same of a spline whose arrays are kept elsewhere.
   pure function spline_at(ends, x, y, m, place) result(f)
      !> What holds at the ends
      integer, intent(in) :: ends
      !> Knots, values and second derivatives there (n)
      real(wp), intent(in) :: x(:), y(:), m(:), place
      real(wp) :: f(0:2), within
      integer :: i, n
      n = size(x)
      within = place
      if (ends == spline_closed) within = x(1) + modulo(place - x(1), x(n) - x(1))
      if (ends == spline_natural) within = max(x(1), min(place, x(n)))
      i = segment_of(x, within)
      f = spline_segment(x(i:i + 1), y(i:i + 1), m(i:i + 1), within)
      if (ends == spline_natural .and. abs(place - within) > 0.0_wp) f = [f(0) + (place - within)*f(1), f(1), 0.0_wp]
   end function spline_at

   !> Value and first two derivatives within one segment.
   pure function spline_segment(x, y, m, place) result(f)
      !> Its two knots, values and second derivatives there
      real(wp), intent(in) :: x(2), y(2), m(2), place
      real(wp) :: f(0:2), h, left, right
      h = x(2) - x(1)
      right = (place - x(1))/h
      left = (x(2) - place)/h
      ! From the nearer knot, so that little is left of a zero there
      f(0) = merge(y(1) + right*(y(2) - y(1)), y(2) - left*(y(2) - y(1)), right < 0.5_wp)
      f(0) = f(0) - h**2/6*(left*(1 - left**2)*m(1) + right*(1 - right**2)*m(2))
      f(1) = (y(2) - y(1))/h + h/6*((1 - 3*left**2)*m(1) - (1 - 3*right**2)*m(2))
      f(2) = left*m(1) + right*m(2)
   end function spline_segment

   !> The segment (1 ... n-1) that holds a place; the first or last beyond the ends.
   pure integer function segment_of(x, place) result(low)
      real(wp), intent(in) :: x(:), place
      integer :: high, middle
      low = 1
      high = size(x)
      do while (high - low > 1)
         middle = (low + high)/2
         if (x(middle) <= place) then
            low = middle
         else
            high = middle
         end if
      end do
   end function segment_of

end module limber_base_spline
