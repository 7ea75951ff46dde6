!> Search for deviations of a curve from a cubic between two places on it. Floor: model. Source: doc/theory, eqs. (5.43), (5.57).
module limber_model_hidden_curve
   use limber_base_kinds, only: wp
   use limber_base_spline, only: spline_at
   use limber_deck_operations, only: jet_type
   use limber_deck_range, only: range_type, law_range
   use limber_model_curve, only: curve_type
   implicit none
   private
   public :: hides

contains

   !> Whether the curve between two places deviates from the cubic through both ends with their slopes, eq. (5.57). The deviation
   !> counts if it exceeds `distance` [length] and a tenth of the deviation from the chord. `from`, `to`: places on the curve (2)
   !> [length].
   pure logical function hides(self, from, to, distance)
      type(curve_type), intent(in) :: self
      real(wp), intent(in) :: from(2), to(2), distance
      hides = .false.
      if (self%explicit) then
         ! Within the limits of the expression
         call search_law(self, max(self%low, min(self%high, from(1))), max(self%low, min(self%high, to(1))), distance, hides)
         return
      end if
      hides = hides_knots(self, self%s(nearest_knot(self, from)), self%s(nearest_knot(self, to)), distance)
   end function hides

   !> The same for an expression of x. Interval bounds of the expression exclude a deviation, or the interval is halved.
   pure subroutine search_law(self, from, to, distance, found)
      type(curve_type), intent(in) :: self
      real(wp), intent(in) :: from, to, distance
      logical, intent(out) :: found
      integer, parameter :: most_looks = 300, deepest = 40, samples = 8
      type(jet_type) :: first, last, y
      type(range_type) :: range
      !> Parts of the range still to be searched: start, end (0 to 1), and y at both
      real(wp) :: parts(4, deepest), a, b, s
      integer :: top, looks
      found = .false.
      if (.not. abs(to - from) > 0.0_wp) return
      first = self%height(from)
      last = self%height(to)
      ! First equally spaced samples: a steep range has no values beyond those of its ends
      do looks = 1, samples - 1
         s = real(looks, wp)/samples
         y = self%height(from + s*(to - from))
         found = is_off(y%value, s, first%value, (to - from)*first%first, last%value, (to - from)*last%first, distance)
         if (found) return
      end do
      parts(:, 1) = [0.0_wp, 1.0_wp, first%value, last%value]
      top = 1
      do looks = 1, most_looks
         if (top == 0 .or. found) return
         associate (part => parts(:, top))
            a = from + part(1)*(to - from)
            b = from + part(2)*(to - from)
            range = law_range(self%expression, min(a, b), max(a, b))
            if (range%defined) then
               if (max(range%high - maxval(part(3:)), minval(part(3:)) - range%low) <= distance) then
                  top = top - 1
                  cycle
               end if
            end if
            s = 0.5_wp*(part(1) + part(2))
            y = self%height(from + s*(to - from))
            found = is_off(y%value, s, first%value, (to - from)*first%first, last%value, (to - from)*last%first, distance)
            b = part(2)
            a = part(4)
            parts(2, top) = s
            parts(4, top) = y%value
         end associate
         if (top == deepest) cycle
         top = top + 1
         parts(:, top) = [s, b, y%value, a]
      end do
   end subroutine search_law

   !> The same for a spline, at the knots between those nearest to both places.
   pure logical function hides_knots(self, from, to, distance) result(found)
      type(curve_type), intent(in) :: self
      !> Arc coordinates of both places, smallest deviation that counts [length]
      real(wp), intent(in) :: from, to, distance
      integer, parameter :: most = 400
      real(wp) :: ends(0:2, 2, 2), x(2), s, h
      integer :: i, k, first, last, stride
      found = .false.
      first = count(self%s < min(from, to)) + 1
      last = count(self%s <= max(from, to))
      if (last - first < 2) return
      ends(:, 1, 1) = spline_at(self%ends, self%s, self%x, self%x_bent, from)
      ends(:, 2, 1) = spline_at(self%ends, self%s, self%y, self%y_bent, from)
      ends(:, 1, 2) = spline_at(self%ends, self%s, self%x, self%x_bent, to)
      ends(:, 2, 2) = spline_at(self%ends, self%s, self%y, self%y_bent, to)
      h = to - from
      stride = 1 + (last - first)/most
      do i = first, last, stride
         x = [self%x(i), self%y(i)]
         s = (self%s(i) - from)/h
         do k = 1, 2
            found = found .or. is_off(x(k), s, ends(0, k, 1), h*ends(1, k, 1), ends(0, k, 2), h*ends(1, k, 2), distance)
         end do
         if (found) return
      end do
   end function hides_knots

   !> Index of the knot nearest to a place.
   pure integer function nearest_knot(self, place) result(knot)
      type(curve_type), intent(in) :: self
      real(wp), intent(in) :: place(2)
      knot = minloc((self%x - place(1))**2 + (self%y - place(2))**2, dim=1)
   end function nearest_knot

   !> Whether a value at the fraction s of the range deviates from the cubic through both ends. Slopes: with respect to s.
   pure logical function is_off(value, s, first, first_slope, last, last_slope, distance) result(off)
      real(wp), intent(in) :: value, s, first, first_slope, last, last_slope, distance
      real(wp), parameter :: part = 0.1_wp
      real(wp) :: cubic, chord
      cubic = (1 - s)**2*((1 + 2*s)*first + s*first_slope) + s**2*((3 - 2*s)*last - (1 - s)*last_slope)
      chord = (1 - s)*first + s*last
      off = abs(value - cubic) > max(distance, part*abs(value - chord))
   end function is_off

end module limber_model_hidden_curve
