!> Bounds of distances and their rates within a step. That of a cubic stays within its control points, eq. (5.45); the length of a
!> vector is that of a cubic vector, for where this passes the origin the length itself is none. Floor: multibody. Source:
!> doc/theory, eqs. (5.45), (5.54), (5.55).
module limber_multibody_bounds
   use limber_base_kinds, only: wp
   implicit none
   private
   public :: bound_cubic, bound_length

   !> Part of what the control points lie beyond the ends, for what a cubic leaves out
   real(wp), parameter :: margin = 0.25_wp
   !> Last digits of a place that its rate in the middle may be off by
   integer, parameter :: digits_off = 16

contains

   !> Bounds of a scalar, or of its rate, by the control points of the cubic through both ends.
   pure subroutine bound_cubic(h, place_a, rate_a, place_b, rate_b, by_rate, low, high)
      !> Time between; values and rates there
      real(wp), intent(in) :: h, place_a, rate_a, place_b, rate_b
      !> Whether the rate is meant
      logical, intent(in) :: by_rate
      real(wp), intent(out) :: low, high
      real(wp) :: middle, noise
      if (.not. by_rate) then
         call widen([place_a, place_b], [place_a + h*rate_a/3, place_b - h*rate_b/3], 0.0_wp, low, high)
         return
      end if
      ! One moment and the same: what begins with a step
      middle = rate_a
      noise = 0.0_wp
      if (h > 0.0_wp) then
         noise = digits_off*spacing(max(abs(place_a), abs(place_b)))/h
         middle = 3*(place_b - place_a)/h - rate_a - rate_b
      end if
      call widen([rate_a, rate_b], [middle], noise, low, high)
   end subroutine bound_cubic

   !> Bounds of the length of a vector less a number, or of its rate, by Bernstein's coefficients of the square of the cubic vector
   !> and of half its derivative, eqs. (5.54), (5.55).
   pure subroutine bound_length(h, place_a, rate_a, place_b, rate_b, origin, by_rate, low, high)
      !> Time between; the vector and its rate at both ends (2)
      real(wp), intent(in) :: h, place_a(2), rate_a(2), place_b(2), rate_b(2)
      !> What is subtracted
      real(wp), intent(in) :: origin
      logical, intent(in) :: by_rate
      real(wp), intent(out) :: low, high
      real(wp) :: p(2, 0:3), q(2, 0:2), length(2), least, most, ends(2), rates(2), fastest, noise
      p = reshape([place_a, place_a + h*rate_a/3, place_b - h*rate_b/3, place_b], [2, 4])
      ends = [norm2(place_a), norm2(place_b)]
      call range_of(square(p), least, most)
      length = sqrt([max(0.0_wp, least), max(0.0_wp, most)])
      if (.not. by_rate) then
         call widen(ends, length, 0.0_wp, low, high)
         low = max(0.0_wp, low) - origin
         high = high - origin
         return
      end if
      noise = 0.0_wp
      q = reshape([rate_a, rate_a, rate_b], [2, 3])
      if (h > 0.0_wp) then
         noise = digits_off*spacing(maxval(abs([place_a, place_b])))/h
         q(:, 1) = 3*(place_b - place_a)/h - rate_a - rate_b
      end if
      fastest = maxval(norm2(q, 1))
      rates = 0.0_wp
      if (ends(1) > 0.0_wp) rates(1) = dot_product(place_a, rate_a)/ends(1)
      if (ends(2) > 0.0_wp) rates(2) = dot_product(place_b, rate_b)/ends(2)
      call range_of(product_of(p, q), least, most)
      least = quotient(min(least, 0.0_wp), length(1)) + quotient(max(least, 0.0_wp), length(2))
      most = quotient(min(most, 0.0_wp), length(2)) + quotient(max(most, 0.0_wp), length(1))
      call widen(rates, [least, most], noise, low, high)

   contains

      !> A quotient that is no more than the largest speed.
      pure real(wp) function quotient(above, below)
         real(wp), intent(in) :: above, below
         quotient = sign(fastest, above)
         if (abs(above) < fastest*below) quotient = above/below
         if (.not. abs(above) > 0.0_wp) quotient = 0.0_wp
      end function quotient

   end subroutine bound_length

   !> Bounds by the values at both ends and others between, less noise, of which what lies beyond the ends counts with its margin.
   pure subroutine widen(ends, between, noise, low, high)
      real(wp), intent(in) :: ends(2), between(:), noise
      real(wp), intent(out) :: low, high
      low = minval(ends) - (1 + margin)*max(0.0_wp, minval(ends) - minval(between) - noise)
      high = maxval(ends) + (1 + margin)*max(0.0_wp, maxval(between) - maxval(ends) - noise)
   end subroutine widen

   pure subroutine range_of(numbers, least, most)
      real(wp), intent(in) :: numbers(:)
      real(wp), intent(out) :: least, most
      least = minval(numbers)
      most = maxval(numbers)
   end subroutine range_of

   !> Bernstein's coefficients of the square of a cubic vector (7).
   pure function square(p) result(c)
      !> Control points (2, 4)
      real(wp), intent(in) :: p(2, 0:3)
      real(wp) :: c(0:6)
      real(wp), parameter :: of_cubic(0:3) = [1.0_wp, 3.0_wp, 3.0_wp, 1.0_wp]
      real(wp), parameter :: of_sixth(0:6) = [1.0_wp, 6.0_wp, 15.0_wp, 20.0_wp, 15.0_wp, 6.0_wp, 1.0_wp]
      integer :: i, j
      c = 0.0_wp
      do j = 0, 3
         do i = 0, 3
            c(i + j) = c(i + j) + of_cubic(i)*of_cubic(j)*dot_product(p(:, i), p(:, j))
         end do
      end do
      c = c/of_sixth
   end function square

   !> Those of the product of a cubic vector and a quadratic one (6).
   pure function product_of(p, q) result(c)
      !> Control points (2, 4), (2, 3)
      real(wp), intent(in) :: p(2, 0:3), q(2, 0:2)
      real(wp) :: c(0:5)
      real(wp), parameter :: of_cubic(0:3) = [1.0_wp, 3.0_wp, 3.0_wp, 1.0_wp], of_square(0:2) = [1.0_wp, 2.0_wp, 1.0_wp]
      real(wp), parameter :: of_fifth(0:5) = [1.0_wp, 5.0_wp, 10.0_wp, 10.0_wp, 5.0_wp, 1.0_wp]
      integer :: i, j
      c = 0.0_wp
      do j = 0, 2
         do i = 0, 3
            c(i + j) = c(i + j) + of_cubic(i)*of_square(j)*dot_product(p(:, i), q(:, j))
         end do
      end do
      c = c/of_fifth
   end function product_of

end module limber_multibody_bounds
