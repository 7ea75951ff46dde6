!> Curves of joints in the frame of a body: a spline through points, open or closed, or y as an expression of x. `evaluate` gives a
!> function f(x, y) with f = 0 on the curve: the signed distance from the spline, positive on its left, or y - y(x). An expression
!> of several formulas can be limited to one piece. Floor: model. Source: doc/theory, eqs. (3.28), (5.59).
module limber_model_curve
   use limber_base_kinds, only: wp
   use limber_base_spline, only: spline_moments, spline_at, spline_natural, spline_closed
   use limber_deck_expression, only: expression_type
   use limber_deck_operations, only: jet_type
   implicit none
   private
   public :: curve_type, spline_curve, expression_curve, limit_curve, release_curve

   !> A curve
   type :: curve_type
      !> True if y is an expression of x
      logical :: explicit = .false.
      type(expression_type) :: expression
      !> Range of x of the active piece, and y with derivatives at its ends; beyond them the curve is a parabola
      real(wp) :: low = -huge(1.0_wp), high = huge(1.0_wp)
      type(jet_type) :: at_low, at_high
      !> Ends of the spline: closed, or natural (straight)
      integer :: ends = spline_natural
      !> Chord lengths up to each point, coordinates, and their second derivatives (points). No components of a spline type: with
      !> two of them gfortran 12 returns parts of the first one only
      real(wp), allocatable :: s(:), x(:), y(:), x_bent(:), y_bent(:)
   contains
      procedure :: evaluate, height, past
   end type curve_type

contains

   !> The curve y = expression(x).
   function expression_curve(expression) result(curve)
      type(expression_type), intent(in) :: expression
      type(curve_type) :: curve
      curve%explicit = .true.
      curve%expression = expression
   end function expression_curve

   !> Limits an expression to a range of x.
   subroutine limit_curve(self, low, high)
      type(curve_type), intent(inout) :: self
      !> Ends of the range, +-huge for none; values just at the ends belong to the piece
      real(wp), intent(in) :: low, high
      call release_curve(self)
      if (low > -huge(low)) self%at_low = self%expression%evaluate_jet(low)
      if (high < huge(high)) self%at_high = self%expression%evaluate_jet(high)
      self%low = low
      self%high = high
   end subroutine limit_curve

   !> Removes the limits of an expression.
   subroutine release_curve(self)
      type(curve_type), intent(inout) :: self
      self%low = -huge(self%low)
      self%high = huge(self%high)
   end subroutine release_curve

   !> y of an expression at x, with its derivatives.
   pure function height(self, x) result(y)
      class(curve_type), intent(in) :: self
      real(wp), intent(in) :: x
      type(jet_type) :: y
      if (x < self%low) then
         y = beyond(self%at_low, x - self%low)
      else if (x > self%high) then
         y = beyond(self%at_high, x - self%high)
      else
         y = self%expression%evaluate_jet(x)
      end if
   end function height

   !> Distance of a place beyond an end of an open spline, along the tangent there; 0 otherwise [length].
   pure real(wp) function past(self, place)
      class(curve_type), intent(in) :: self
      !> A place on the curve (2) [length]
      real(wp), intent(in) :: place(2)
      real(wp) :: x(0:2, 2)
      integer :: n, knot
      past = 0.0_wp
      if (self%explicit .or. self%ends == spline_closed) return
      n = size(self%s)
      knot = minloc((self%x - place(1))**2 + (self%y - place(2))**2, dim=1)
      if (knot > 1 .and. knot < n) return
      x(:, 1) = spline_at(self%ends, self%s, self%x, self%x_bent, self%s(knot))
      x(:, 2) = spline_at(self%ends, self%s, self%y, self%y_bent, self%s(knot))
      past = max(0.0_wp, merge(-1, 1, knot == 1)*dot_product(place - x(0, :), x(1, :))/norm2(x(1, :)))
   end function past

   !> Parabola through a point, with its slope and curvature, at a distance from this point.
   pure type(jet_type) function beyond(at, distance)
      type(jet_type), intent(in) :: at
      real(wp), intent(in) :: distance
      beyond = jet_type(at%value + distance*(at%first + 0.5_wp*distance*at%second), at%first + distance*at%second, at%second)
   end function beyond

   !> The spline through points.
   pure function spline_curve(points, closed) result(curve)
      !> (2, points): at least two, neighbours distinct; a closed curve does not repeat the first
      real(wp), intent(in) :: points(:, :)
      logical, intent(in) :: closed
      type(curve_type) :: curve
      real(wp), parameter :: nothing(2) = 0.0_wp
      integer :: i, n
      n = size(points, 2)
      if (closed) n = n + 1
      allocate (curve%s(n), curve%x(n), curve%y(n), curve%x_bent(n), curve%y_bent(n))
      curve%x(:size(points, 2)) = points(1, :)
      curve%y(:size(points, 2)) = points(2, :)
      curve%x(n) = merge(points(1, 1), curve%x(n), closed)
      curve%y(n) = merge(points(2, 1), curve%y(n), closed)
      curve%s(1) = 0.0_wp
      do i = 2, n
         curve%s(i) = curve%s(i - 1) + hypot(curve%x(i) - curve%x(i - 1), curve%y(i) - curve%y(i - 1))
      end do
      curve%ends = merge(spline_closed, spline_natural, closed)
      curve%x_bent = spline_moments(curve%s, curve%x, curve%ends, nothing)
      curve%y_bent = spline_moments(curve%s, curve%y, curve%ends, nothing)
   end function spline_curve

   !> f, its gradient (2) and second derivatives (2,2) at a place.
   pure subroutine evaluate(self, place, f, gradient, hessian)
      class(curve_type), intent(in) :: self
      !> A place in the frame of the body (2) [length]
      real(wp), intent(in) :: place(2)
      real(wp), intent(out) :: f, gradient(2), hessian(2, 2)
      type(jet_type) :: y
      real(wp) :: x(0:2, 2), tangent(2), bend
      integer :: i, j
      if (self%explicit) then
         y = self%height(place(1))
         f = place(2) - y%value
         gradient = [-y%first, 1.0_wp]
         hessian = reshape([-y%second, 0.0_wp, 0.0_wp, 0.0_wp], [2, 2])
         return
      end if
      call nearest(self, place, x)
      tangent = x(1, :)/norm2(x(1, :))
      gradient = [-tangent(2), tangent(1)]
      f = dot_product(gradient, place - x(0, :))
      bend = (x(1, 1)*x(2, 2) - x(1, 2)*x(2, 1))/norm2(x(1, :))**3
      do j = 1, 2
         do i = 1, 2
            hessian(i, j) = -bend/(1 - bend*f)*tangent(i)*tangent(j)
         end do
      end do
   end subroutine evaluate

   !> Point of the spline nearest to a place, with derivatives (0:2, 2): Newton's method from the nearest knot.
   pure subroutine nearest(self, place, x)
      type(curve_type), intent(in) :: self
      real(wp), intent(in) :: place(2)
      real(wp), intent(out) :: x(0:2, 2)
      real(wp) :: s, best, distance, slope, change, width
      integer :: i, round
      s = self%s(1)
      width = 0.0_wp
      best = huge(best)
      do i = 1, size(self%s)
         distance = (self%x(i) - place(1))**2 + (self%y(i) - place(2))**2
         if (distance >= best) cycle
         best = distance
         s = self%s(i)
         width = self%s(min(i + 1, size(self%s))) - self%s(max(1, i - 1))
      end do
      do round = 1, 60
         x(:, 1) = spline_at(self%ends, self%s, self%x, self%x_bent, s)
         x(:, 2) = spline_at(self%ends, self%s, self%y, self%y_bent, s)
         slope = dot_product(x(1, :), x(1, :)) - dot_product(place - x(0, :), x(2, :))
         if (slope <= 0.1_wp*dot_product(x(1, :), x(1, :))) slope = dot_product(x(1, :), x(1, :))
         change = dot_product(place - x(0, :), x(1, :))/slope
         change = max(-0.5_wp*width, min(0.5_wp*width, change))
         s = s + change
         if (abs(change) <= 4*epsilon(s)*(abs(s) + width)) exit
      end do
      x(:, 1) = spline_at(self%ends, self%s, self%x, self%x_bent, s)
      x(:, 2) = spline_at(self%ends, self%s, self%y, self%y_bent, s)
   end subroutine nearest

end module limber_model_curve
