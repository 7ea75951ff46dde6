!> Scalar functions of the motion: lengths, angles and coordinates of points and directions. Constraints, loads and laws are made of
!> them. Each has a value, a rate, first and second derivatives by the positions of its markers. Over a step the first derivatives
!> are such that their sum with the increments of the markers is the change of the value, exactly. Constraints and loads turn them
!> into derivatives by the coordinates of bodies. Floor: multibody. Source: doc/theory, eqs. (3.8), (3.9), (3.14), (3.17),
!> (3.31)-(3.33).
module limber_multibody_scalar_functions
   use limber_base_kinds, only: wp
   use limber_multibody_kinematics, only: kinematics_type
   use limber_multibody_markers, only: vector_angle_gradient, vector_angle_hessian
   use limber_multibody_plane_vectors, only: turn, cross
   implicit none
   private
   public :: scalar_function_type, compare_functions
   public :: function_value, read_function, read_gap, function_weights, function_ends, function_hessian, hessian_times

   !> Of the vectors v1, v2, v3, points or directions: the component axis.(v1 - v2) along a fixed axis; the coordinate (v1 - v2).v3
   !> along a direction; the product v1 x v2 of directions; the distance |v1 - v2|; the angle of v1 - v2, and the angle of the
   !> direction v1 less that of v2, both followed over turns; (v1 x v2)(v2.v2 - v1.v1), the cube of the slope of a section whose
   !> direction is v2 in the frame of direction v1
   integer, parameter, public :: scalar_component = 1, scalar_along = 2, scalar_cross = 3, scalar_distance = 4, scalar_angle = 5, &
      & scalar_turn = 6, scalar_slope = 7

   !> A scalar function of the motion
   type :: scalar_function_type
      !> One of the kinds
      integer :: kind = 0
      !> Markers of v1, v2, v3; 0: none, which counts as zero
      integer :: markers(3) = 0
      !> Of a constraint: which of its vectors these are; of a load: which of its bodies they are on. 0: none
      integer :: vectors(3) = 0, parts(3) = 0
      !> Of angles: the followed angle of v1 - v2, or those of v1 and v2; 0: none, which counts as zero
      integer :: angles(2) = 0
      !> Of a component: unit vector along the axis
      real(wp) :: axis(2) = 0.0_wp
      !> Of a coordinate along a direction: whether v3 counts as a unit vector, whatever deflections stretch it by
      logical :: unit = .false.
      !> Of a distance: what is added to it at right angles, so that it has derivatives where the points meet [length]
      real(wp) :: softening = 0.0_wp
      !> What is subtracted: a free length or angle
      real(wp) :: origin = 0.0_wp
   end type scalar_function_type

contains

   !> Value at an instant; kinematics are placed.
   pure real(wp) function function_value(scalar, kinematics) result(value)
      type(scalar_function_type), intent(in) :: scalar
      type(kinematics_type), intent(in) :: kinematics
      real(wp) :: v(2, 3), weights(2, 3)
      if (is_angle(scalar)) then
         value = angle_value(scalar, kinematics)
      else
         call fetch(scalar, kinematics, v)
         call find_at(scalar, v, value, weights)
      end if
   end function function_value

   !> Value and rate; over a step the mean of the values at both ends, and the increment over the span.
   pure subroutine read_function(scalar, kinematics, value, rate, weights)
      type(scalar_function_type), intent(in) :: scalar
      !> Placed and moved
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(out) :: value, rate
      !> Derivatives by the positions of the markers (2, 3)
      real(wp), intent(out) :: weights(2, 3)
      real(wp) :: v(2, 3), w(2, 3), end
      call fetch(scalar, kinematics, v)
      call fetch_rates(scalar, kinematics, w)
      if (kinematics%span > 0.0_wp) then
         call find_over(scalar, v, w, kinematics%span, value, end, weights)
         value = 0.5_wp*(value + end)
      else
         call find_at(scalar, v, value, weights)
      end if
      if (is_angle(scalar)) value = angle_value(scalar, kinematics)
      rate = rate_of(weights, w)
   end subroutine read_function

   !> Derivatives by the positions of the markers (2, 3).
   pure subroutine function_weights(scalar, kinematics, weights)
      type(scalar_function_type), intent(in) :: scalar
      !> Placed; of a step also moved
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(out) :: weights(2, 3)
      real(wp) :: v(2, 3), w(2, 3), value, end
      call fetch(scalar, kinematics, v)
      if (kinematics%span > 0.0_wp .and. .not. is_quadratic(scalar)) then
         call fetch_rates(scalar, kinematics, w)
         call find_over(scalar, v, w, kinematics%span, value, end, weights)
      else
         call find_at(scalar, v, value, weights)
      end if
   end subroutine function_weights

   !> Values at the start and the end of a step; at an instant both are the value.
   pure subroutine function_ends(scalar, kinematics, start, end)
      type(scalar_function_type), intent(in) :: scalar
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(out) :: start, end
      real(wp) :: v(2, 3), w(2, 3), weights(2, 3), half
      call fetch(scalar, kinematics, v)
      call fetch_rates(scalar, kinematics, w)
      call find_over(scalar, v, w, kinematics%span, start, end, weights)
      if (.not. is_angle(scalar)) return
      half = 0.5_wp*kinematics%span*rate_of(weights, w)
      start = angle_value(scalar, kinematics) - half
      end = angle_value(scalar, kinematics) + half
   end subroutine function_ends

   !> Second derivatives by the positions of the markers (2, 3, 2, 3), at an instant; over a step those of the mean.
   pure subroutine function_hessian(scalar, kinematics, h)
      type(scalar_function_type), intent(in) :: scalar
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(out) :: h(2, 3, 2, 3)
      real(wp) :: v(2, 3), block(2, 2), length
      h = 0.0_wp
      if (scalar%kind == scalar_component) return
      call fetch(scalar, kinematics, v)
      select case (scalar%kind)
      case (scalar_along)
         block = reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [2, 2])
         if (scalar%unit) then
            length = length_of(v(:, 3), 0.0_wp)
            block = across(v(:, 3), length)
            h(:, 3, :, 3) = stretching(v(:, 1) - v(:, 2), v(:, 3)/length)/length**2
         end if
         h(:, 1, :, 3) = block
         h(:, 2, :, 3) = -block
         h(:, 3, :, 1) = block
         h(:, 3, :, 2) = -block
      case (scalar_cross)
         call add_cross(1.0_wp, h)
      case (scalar_distance)
         call spread_block(across(v(:, 1) - v(:, 2), length_of(v(:, 1) - v(:, 2), scalar%softening)), h)
      case (scalar_angle)
         call spread_block(vector_angle_hessian(v(:, 1) - v(:, 2)), h)
      case (scalar_turn)
         if (scalar%angles(1) > 0) h(:, 1, :, 1) = vector_angle_hessian(v(:, 1))
         if (scalar%angles(2) > 0) h(:, 2, :, 2) = -vector_angle_hessian(v(:, 2))
      case (scalar_slope)
         call slope_hessian(v, h)
      end select
   end subroutine function_hessian

   !> A block of second derivatives times a vector: the change of the weight of one marker by the movement of another.
   pure function hessian_times(h, m, n, vector) result(product)
      real(wp), intent(in) :: h(2, 3, 2, 3)
      !> Markers of the function
      integer, intent(in) :: m, n
      real(wp), intent(in) :: vector(2)
      real(wp) :: product(2)
      product = h(:, m, 1, n)*vector(1) + h(:, m, 2, n)*vector(2)
   end function hessian_times

   !> The vector v1 - v2 and its rate, at an instant.
   pure subroutine read_gap(scalar, kinematics, gap, rate)
      type(scalar_function_type), intent(in) :: scalar
      !> Placed and moved
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(out) :: gap(2), rate(2)
      real(wp) :: v(2, 3), w(2, 3)
      call fetch(scalar, kinematics, v)
      call fetch_rates(scalar, kinematics, w)
      gap = v(:, 1) - v(:, 2)
      rate = w(:, 1) - w(:, 2)
   end subroutine read_gap

   !> Whether a function is sign times another, plus a shift, in every position.
   pure subroutine compare_functions(one, other, sign, shift, alike)
      type(scalar_function_type), intent(in) :: one, other
      !> other = sign one + shift
      real(wp), intent(out) :: sign, shift
      logical, intent(out) :: alike
      logical :: same, swapped
      sign = 0.0_wp
      shift = 0.0_wp
      alike = one%kind == other%kind .and. (one%unit .eqv. other%unit)
      if (.not. alike) return
      same = all(one%markers == other%markers)
      swapped = all(one%markers(1:2) == other%markers(2:1:-1))
      select case (one%kind)
      case (scalar_turn)
         same = all(one%angles == other%angles)
         swapped = all(one%angles == other%angles(2:1:-1))
         sign = merge(1.0_wp, merge(-1.0_wp, 0.0_wp, swapped), same)
      case (scalar_component)
         if (same .or. swapped) sign = dot_product(one%axis, other%axis)*merge(1.0_wp, -1.0_wp, same)
         if (abs(abs(sign) - 1) > 4*epsilon(sign)) sign = 0.0_wp
         sign = anint(sign)
      case (scalar_distance)
         if (same .or. swapped) sign = 1.0_wp
      case default
         if (same) sign = 1.0_wp
      end select
      alike = abs(sign) > 0.0_wp
      shift = sign*one%origin - other%origin
   end subroutine compare_functions

   !> The vectors, zero where there is none; over a step their means.
   pure subroutine fetch(scalar, kinematics, v)
      type(scalar_function_type), intent(in) :: scalar
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(out) :: v(2, 3)
      integer :: m
      v = 0.0_wp
      do m = 1, 3
         if (scalar%markers(m) > 0) v(:, m) = kinematics%markers(scalar%markers(m))%position
      end do
   end subroutine fetch

   !> Their velocities; over a step increments over the span.
   pure subroutine fetch_rates(scalar, kinematics, w)
      type(scalar_function_type), intent(in) :: scalar
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(out) :: w(2, 3)
      integer :: m
      w = 0.0_wp
      do m = 1, 3
         if (scalar%markers(m) > 0) w(:, m) = kinematics%markers(scalar%markers(m))%velocity
      end do
   end subroutine fetch_rates

   !> Whether the value is one of followed angles, with turns that the vectors do not tell.
   pure logical function is_angle(scalar)
      type(scalar_function_type), intent(in) :: scalar
      is_angle = scalar%kind == scalar_angle .or. scalar%kind == scalar_turn
   end function is_angle

   !> Whether the function is at most quadratic in the vectors: its derivatives at their means give its change.
   pure logical function is_quadratic(scalar)
      type(scalar_function_type), intent(in) :: scalar
      is_quadratic = scalar%kind == scalar_component .or. scalar%kind == scalar_cross &
         & .or. (scalar%kind == scalar_along .and. .not. scalar%unit)
   end function is_quadratic

   !> Value of followed angles; over a step they are means.
   pure real(wp) function angle_value(scalar, kinematics) result(value)
      type(scalar_function_type), intent(in) :: scalar
      type(kinematics_type), intent(in) :: kinematics
      value = -scalar%origin
      if (scalar%angles(1) > 0) value = value + kinematics%angles(scalar%angles(1))%value
      if (scalar%angles(2) > 0) value = value - kinematics%angles(scalar%angles(2))%value
   end function angle_value

   !> Value, not of angles, and derivatives at given vectors.
   pure subroutine find_at(scalar, v, value, weights)
      type(scalar_function_type), intent(in) :: scalar
      real(wp), intent(in) :: v(2, 3)
      real(wp), intent(out) :: value, weights(2, 3)
      real(wp) :: gap(2), length
      gap = v(:, 1) - v(:, 2)
      value = 0.0_wp
      weights = 0.0_wp
      select case (scalar%kind)
      case (scalar_component)
         value = dot_product(scalar%axis, gap)
         weights(:, 1) = scalar%axis
         weights(:, 2) = -scalar%axis
      case (scalar_along)
         length = 1.0_wp
         if (scalar%unit) length = length_of(v(:, 3), 0.0_wp)
         value = dot_product(gap, v(:, 3))/length
         weights(:, 1) = v(:, 3)/length
         weights(:, 2) = -weights(:, 1)
         weights(:, 3) = gap/length
         if (scalar%unit) weights(:, 3) = weights(:, 3) - value/length*weights(:, 1)
      case (scalar_cross)
         value = cross(v(:, 1), v(:, 2))
         weights(:, 1) = -turn(v(:, 2))
         weights(:, 2) = turn(v(:, 1))
      case (scalar_distance)
         value = length_of(gap, scalar%softening)
         weights(:, 1) = gap/value
         weights(:, 2) = -weights(:, 1)
      case (scalar_angle, scalar_turn)
         call angle_weights(scalar, v, v, 0.0_wp, weights)
      case (scalar_slope)
         value = cross(v(:, 1), v(:, 2))*excess(v(:, 1), v(:, 2))
         call slope_weights(v, cross(v(:, 1), v(:, 2)), excess(v(:, 1), v(:, 2)), weights)
      end select
      value = value - scalar%origin
   end subroutine find_at

   !> Values, not of angles, at the start and the end of a step, and the derivatives that give the change exactly.
   pure subroutine find_over(scalar, v, w, span, start, end, weights)
      type(scalar_function_type), intent(in) :: scalar
      !> Means of the vectors, their increments over the span (2, 3), and its length; 0: an instant
      real(wp), intent(in) :: v(2, 3), w(2, 3), span
      real(wp), intent(out) :: start, end, weights(2, 3)
      real(wp) :: a(2, 3), b(2, 3)
      if (is_angle(scalar)) then
         start = 0.0_wp
         end = 0.0_wp
         weights = 0.0_wp
         call angle_weights(scalar, v, w, span, weights)
         return
      end if
      a = v - 0.5_wp*span*w
      b = v + 0.5_wp*span*w
      call find_at(scalar, a, start, weights)
      call find_at(scalar, b, end, weights)
      select case (scalar%kind)
      case (scalar_distance)
         weights(:, 1) = (v(:, 1) - v(:, 2))/(0.5_wp*(start + end) + scalar%origin)
         weights(:, 2) = -weights(:, 1)
      case (scalar_along)
         call along_weights(scalar, a, b, weights)
      case (scalar_slope)
         ! The mean of one factor times the change of the other, both ways
         call slope_weights(v, 0.5_wp*(cross(a(:, 1), a(:, 2)) + cross(b(:, 1), b(:, 2))), &
            & 0.5_wp*(excess(a(:, 1), a(:, 2)) + excess(b(:, 1), b(:, 2))), weights)
      case (scalar_cross)
         weights(:, 1) = -turn(v(:, 2))
         weights(:, 2) = turn(v(:, 1))
      end select
   end subroutine find_over

   !> Sum of weights and velocities.
   pure real(wp) function rate_of(weights, w) result(rate)
      real(wp), intent(in) :: weights(2, 3), w(2, 3)
      rate = dot_product(weights(:, 1), w(:, 1)) + dot_product(weights(:, 2), w(:, 2)) + dot_product(weights(:, 3), w(:, 3))
   end function rate_of

   !> Weights of a coordinate along a direction over a step, eq. (3.33).
   pure subroutine along_weights(scalar, a, b, weights)
      type(scalar_function_type), intent(in) :: scalar
      !> Vectors at the start and the end
      real(wp), intent(in) :: a(2, 3), b(2, 3)
      real(wp), intent(out) :: weights(2, 3)
      real(wp) :: along(2), start, end, factor
      along = 0.5_wp*(a(:, 3) + b(:, 3))
      weights(:, 1) = along
      weights(:, 2) = -along
      weights(:, 3) = 0.5_wp*(a(:, 1) - a(:, 2) + b(:, 1) - b(:, 2))
      if (.not. scalar%unit) return
      start = length_of(a(:, 3), 0.0_wp)
      end = length_of(b(:, 3), 0.0_wp)
      factor = (dot_product(a(:, 1) - a(:, 2), a(:, 3)) + dot_product(b(:, 1) - b(:, 2), b(:, 3)))/(start*end*(start + end))
      weights = 0.5_wp*(1/start + 1/end)*weights
      weights(:, 3) = weights(:, 3) - factor*along
   end subroutine along_weights

   !> Weights of angles, eqs. (3.8), (3.9).
   pure subroutine angle_weights(scalar, v, w, span, weights)
      type(scalar_function_type), intent(in) :: scalar
      real(wp), intent(in) :: v(2, 3), w(2, 3), span
      !> Zero on entry where the function has no marker
      real(wp), intent(inout) :: weights(2, 3)
      if (scalar%kind == scalar_angle) then
         weights(:, 1) = vector_angle_gradient(v(:, 1) - v(:, 2), w(:, 1) - w(:, 2), span)
         weights(:, 2) = -weights(:, 1)
      else
         if (scalar%angles(1) > 0) weights(:, 1) = vector_angle_gradient(v(:, 1), w(:, 1), span)
         if (scalar%angles(2) > 0) weights(:, 2) = -vector_angle_gradient(v(:, 2), w(:, 2), span)
      end if
   end subroutine angle_weights

   !> Weights of (v1 x v2)(v2.v2 - v1.v1), with given values of both factors.
   pure subroutine slope_weights(v, turned, longer, weights)
      real(wp), intent(in) :: v(2, 3), turned, longer
      real(wp), intent(inout) :: weights(2, 3)
      weights(:, 1) = -longer*turn(v(:, 2)) - 2*turned*v(:, 1)
      weights(:, 2) = longer*turn(v(:, 1)) + 2*turned*v(:, 2)
   end subroutine slope_weights

   !> Second derivatives of (v1 x v2)(v2.v2 - v1.v1).
   pure subroutine slope_hessian(v, h)
      real(wp), intent(in) :: v(2, 3)
      !> Zero on entry
      real(wp), intent(inout) :: h(2, 3, 2, 3)
      real(wp) :: turning(2, 2), lengthening(2, 2), sides(2)
      integer :: i, j, m, n
      turning(:, 1) = -turn(v(:, 2))
      turning(:, 2) = turn(v(:, 1))
      lengthening(:, 1) = -2*v(:, 1)
      lengthening(:, 2) = 2*v(:, 2)
      sides = [-2.0_wp, 2.0_wp]*cross(v(:, 1), v(:, 2))
      do n = 1, 2
         do j = 1, 2
            do m = 1, 2
               do i = 1, 2
                  h(i, m, j, n) = turning(i, m)*lengthening(j, n) + lengthening(i, m)*turning(j, n)
               end do
            end do
            h(j, n, j, n) = h(j, n, j, n) + sides(n)
         end do
      end do
      call add_cross(excess(v(:, 1), v(:, 2)), h)
   end subroutine slope_hessian

   !> Adds a factor times the second derivatives of v1 x v2.
   pure subroutine add_cross(factor, h)
      real(wp), intent(in) :: factor
      real(wp), intent(inout) :: h(2, 3, 2, 3)
      h(1, 1, 2, 2) = h(1, 1, 2, 2) + factor
      h(2, 2, 1, 1) = h(2, 2, 1, 1) + factor
      h(2, 1, 1, 2) = h(2, 1, 1, 2) - factor
      h(1, 2, 2, 1) = h(1, 2, 2, 1) - factor
   end subroutine add_cross

   !> Second derivatives by v1 and v2 of a function of v1 - v2, from those by this.
   pure subroutine spread_block(block, h)
      real(wp), intent(in) :: block(2, 2)
      real(wp), intent(inout) :: h(2, 3, 2, 3)
      h(:, 1, :, 1) = block
      h(:, 2, :, 2) = block
      h(:, 1, :, 2) = -block
      h(:, 2, :, 1) = -block
   end subroutine spread_block

   !> sqrt(g.g + s^2).
   pure real(wp) function length_of(g, s) result(length)
      real(wp), intent(in) :: g(2), s
      length = sqrt(dot_product(g, g) + s**2)
   end function length_of

   !> Square of the second vector less that of the first.
   pure real(wp) function excess(a, b)
      real(wp), intent(in) :: a(2), b(2)
      excess = dot_product(b, b) - dot_product(a, a)
   end function excess

   !> (I - g g^T/l^2)/l.
   pure function across(g, l) result(block)
      real(wp), intent(in) :: g(2), l
      real(wp) :: block(2, 2)
      integer :: i, j
      do j = 1, 2
         do i = 1, 2
            block(i, j) = -g(i)*g(j)/l**3
         end do
         block(j, j) = block(j, j) + 1/l
      end do
   end function across

   !> 3 (e.g) e e^T - g e^T - e g^T - (e.g) I with the unit vector e.
   pure function stretching(g, e) result(block)
      real(wp), intent(in) :: g(2), e(2)
      real(wp) :: block(2, 2)
      integer :: i, j
      do j = 1, 2
         do i = 1, 2
            block(i, j) = 3*dot_product(g, e)*e(i)*e(j) - g(i)*e(j) - e(i)*g(j)
         end do
         block(j, j) = block(j, j) - dot_product(g, e)
      end do
   end function stretching

end module limber_multibody_scalar_functions
