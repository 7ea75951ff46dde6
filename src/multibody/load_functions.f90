!> Scalar functions of loads and laws. Scalars of the motion that loads act along and laws depend on, made of markers. One layer
!> turns the derivatives by the markers' positions into those by the coordinates. Over a step the weights are such that the rate
!> times the span is what the gauge changes by, exactly. Floor: multibody. Source: doc/theory, eqs. (3.31)-(3.33).
module limber_multibody_load_functions
   use limber_base_kinds, only: wp
   use limber_multibody_kinematics, only: kinematics_type
   use limber_multibody_markers, only: marker_column, drift_column, angle_gradient, angle_hessian
   implicit none
   private
   public :: load_function_type, read_gauge, read_gap, gauge_ends, gauge_curvature, gauge_column, gauge_drift, compare_gauges

   !> Displacement of P1 from P2 along a fixed axis; distance of P2 from P1; coordinate of P1 from P2 along a direction; angle of a
   !> direction less that of another
   integer, parameter, public :: gauge_shift = 1, gauge_distance = 2, gauge_slide = 3, gauge_angle = 4

   !> A scalar of the motion
   type :: load_function_type
      !> gauge_shift, gauge_distance, gauge_slide or gauge_angle
      integer :: kind = 0
      !> Markers: P1, P2 and the direction; of an angle the two directions. 0: none
      integer :: markers(3) = 0
      !> Which of a load's bodies each marker is on; 0: none of them
      integer :: parts(3) = 0
      !> Of an angle: the two followed angles
      integer :: angles(2) = 0
      !> Of a shift: unit vector along the axis
      real(wp) :: axis(2) = 0.0_wp
      !> Of a distance: what is added to it at right angles, so that it has derivatives where the points meet [length]
      real(wp) :: softening = 0.0_wp
      !> What is subtracted: a free length or angle
      real(wp) :: origin = 0.0_wp
   end type load_function_type

contains

   !> Value of a gauge and its rate; over a step the mean of its values at both ends, and its increment over the span.
   pure subroutine read_gauge(gauge, kinematics, value, rate, weights)
      type(load_function_type), intent(in) :: gauge
      !> Placed and moved
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(out) :: value, rate
      !> Derivatives by the positions of the markers (2, 3)
      real(wp), intent(out) :: weights(2, 3)
      real(wp) :: a(2), b(2), gap(2), along(2), da(2), db(2)
      real(wp) :: factor, cube, other
      weights = 0.0_wp
      select case (gauge%kind)
      case (gauge_distance)
         call fetch(gauge, kinematics, 0.0_wp, gap, along)
         call gauge_ends(gauge, kinematics, value, other)
         value = 0.5_wp*(value + other) + gauge%origin
         weights(:, 1) = gap/value
         weights(:, 2) = -gap/value
      case (gauge_slide)
         call fetch(gauge, kinematics, 0.0_wp, gap, along)
         if (kinematics%span > 0.0_wp) then
            call fetch(gauge, kinematics, -0.5_wp, a, da)
            call fetch(gauge, kinematics, 0.5_wp, b, db)
            factor = 0.5_wp*(1/norm2(da) + 1/norm2(db))
            cube = 2/(norm2(da)*norm2(db)*(norm2(da) + norm2(db)))
            value = 0.5_wp*(dot_product(a, da)/norm2(da) + dot_product(b, db)/norm2(db))
            cube = cube*0.5_wp*(dot_product(a, da) + dot_product(b, db))
         else
            factor = 1/norm2(along)
            value = dot_product(gap, along)*factor
            cube = value*factor**2
         end if
         weights(:, 1) = factor*along
         weights(:, 2) = -factor*along
         weights(:, 3) = factor*gap - cube*along
      case default
         call read_linear(gauge, kinematics, value, rate, weights)
         return
      end select
      value = value - gauge%origin
      rate = rate_of(gauge, kinematics, weights)
   end subroutine read_gauge

   !> The vector from the second marker to the first, and its rate, at an instant.
   pure subroutine read_gap(gauge, kinematics, gap, rate)
      type(load_function_type), intent(in) :: gauge
      !> Placed and moved
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(out) :: gap(2), rate(2)
      gap = 0.0_wp
      rate = 0.0_wp
      associate (markers => kinematics%markers)
         if (gauge%markers(1) > 0) gap = markers(gauge%markers(1))%position
         if (gauge%markers(1) > 0) rate = markers(gauge%markers(1))%velocity
         if (gauge%markers(2) > 0) gap = gap - markers(gauge%markers(2))%position
         if (gauge%markers(2) > 0) rate = rate - markers(gauge%markers(2))%velocity
      end associate
   end subroutine read_gap

   !> Whether a gauge is sign times another, plus a shift, in every position.
   pure subroutine compare_gauges(one, other, sign, shift, alike)
      type(load_function_type), intent(in) :: one, other
      !> other = sign one + shift
      real(wp), intent(out) :: sign, shift
      logical, intent(out) :: alike
      logical :: same, swapped
      sign = 0.0_wp
      shift = 0.0_wp
      alike = one%kind == other%kind
      if (.not. alike) return
      same = all(one%markers == other%markers)
      swapped = all(one%markers(1:2) == other%markers(2:1:-1))
      select case (one%kind)
      case (gauge_angle)
         same = all(one%angles == other%angles)
         swapped = all(one%angles == other%angles(2:1:-1))
         sign = merge(1.0_wp, merge(-1.0_wp, 0.0_wp, swapped), same)
      case (gauge_shift)
         if (same .or. swapped) sign = dot_product(one%axis, other%axis)*merge(1.0_wp, -1.0_wp, same)
         if (abs(abs(sign) - 1) > 4*epsilon(sign)) sign = 0.0_wp
         sign = anint(sign)
      case (gauge_distance)
         if (same .or. swapped) sign = 1.0_wp
      case default
         if (same) sign = 1.0_wp
      end select
      alike = abs(sign) > 0.0_wp
      shift = sign*one%origin - other%origin
   end subroutine compare_gauges

   !> Sum of weights and velocities.
   pure real(wp) function rate_of(gauge, kinematics, weights) result(rate)
      type(load_function_type), intent(in) :: gauge
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(in) :: weights(2, 3)
      integer :: m
      rate = 0.0_wp
      do m = 1, 3
         if (gauge%markers(m) > 0) rate = rate + dot_product(weights(:, m), kinematics%markers(gauge%markers(m))%velocity)
      end do
   end function rate_of

   !> P1 - P2 and the direction; over a step those at a part of it from its middle.
   pure subroutine fetch(gauge, kinematics, part, gap, along)
      type(load_function_type), intent(in) :: gauge
      type(kinematics_type), intent(in) :: kinematics
      !> From -1/2 to 1/2
      real(wp), intent(in) :: part
      real(wp), intent(out) :: gap(2), along(2)
      real(wp) :: time
      time = part*kinematics%span
      gap = 0.0_wp
      along = 0.0_wp
      associate (markers => kinematics%markers)
         if (gauge%markers(1) > 0) gap = markers(gauge%markers(1))%position + time*markers(gauge%markers(1))%velocity
         if (gauge%markers(2) > 0) gap = gap - markers(gauge%markers(2))%position - time*markers(gauge%markers(2))%velocity
         if (gauge%markers(3) > 0) along = markers(gauge%markers(3))%position + time*markers(gauge%markers(3))%velocity
      end associate
   end subroutine fetch

   !> Values of a gauge at the start and the end of a step; at an instant both are its value.
   pure subroutine gauge_ends(gauge, kinematics, start, end)
      type(load_function_type), intent(in) :: gauge
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(out) :: start, end
      real(wp) :: gap(2), along(2), rate, weights(2, 3)
      select case (gauge%kind)
      case (gauge_distance)
         call fetch(gauge, kinematics, -0.5_wp, gap, along)
         start = sqrt(dot_product(gap, gap) + gauge%softening**2) - gauge%origin
         call fetch(gauge, kinematics, 0.5_wp, gap, along)
         end = sqrt(dot_product(gap, gap) + gauge%softening**2) - gauge%origin
      case (gauge_slide)
         call fetch(gauge, kinematics, -0.5_wp, gap, along)
         start = dot_product(gap, along)/norm2(along) - gauge%origin
         call fetch(gauge, kinematics, 0.5_wp, gap, along)
         end = dot_product(gap, along)/norm2(along) - gauge%origin
      case default
         call read_linear(gauge, kinematics, start, rate, weights)
         end = start + 0.5_wp*kinematics%span*rate
         start = start - 0.5_wp*kinematics%span*rate
      end select
   end subroutine gauge_ends

   !> Of shifts and angles, whose mean is halfway between the ends.
   pure subroutine read_linear(gauge, kinematics, value, rate, weights)
      type(load_function_type), intent(in) :: gauge
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(out) :: value, rate, weights(2, 3)
      real(wp) :: gap(2), along(2)
      weights = 0.0_wp
      if (gauge%kind == gauge_shift) then
         call fetch(gauge, kinematics, 0.0_wp, gap, along)
         value = dot_product(gauge%axis, gap)
         weights(:, 1) = gauge%axis
         weights(:, 2) = -gauge%axis
      else
         value = 0.0_wp
         if (gauge%angles(1) > 0) value = kinematics%angles(gauge%angles(1))%value
         if (gauge%angles(1) > 0) weights(:, 1) = angle_gradient(kinematics, gauge%angles(1))
         if (gauge%angles(2) > 0) value = value - kinematics%angles(gauge%angles(2))%value
         if (gauge%angles(2) > 0) weights(:, 2) = -angle_gradient(kinematics, gauge%angles(2))
      end if
      value = value - gauge%origin
      rate = rate_of(gauge, kinematics, weights)
   end subroutine read_linear

   !> Second derivatives by the positions of the markers (2, 3, 2, 3), at an instant; over a step those of the mean.
   pure subroutine gauge_curvature(gauge, kinematics, curvature)
      type(load_function_type), intent(in) :: gauge
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(out) :: curvature(2, 3, 2, 3)
      real(wp) :: gap(2), along(2), length, block(2, 2)
      curvature = 0.0_wp
      select case (gauge%kind)
      case (gauge_distance)
         call fetch(gauge, kinematics, 0.0_wp, gap, along)
         length = sqrt(dot_product(gap, gap) + gauge%softening**2)
         block = across(gap, length)
         curvature(:, 1, :, 1) = block
         curvature(:, 2, :, 2) = block
         curvature(:, 1, :, 2) = -block
         curvature(:, 2, :, 1) = -block
      case (gauge_slide)
         call fetch(gauge, kinematics, 0.0_wp, gap, along)
         length = norm2(along)
         block = across(along, length)
         curvature(:, 1, :, 3) = block
         curvature(:, 3, :, 1) = block
         curvature(:, 2, :, 3) = -block
         curvature(:, 3, :, 2) = -block
         curvature(:, 3, :, 3) = turning(gap, along/length)/length**2
      case (gauge_angle)
         if (gauge%angles(1) > 0) curvature(:, 1, :, 1) = angle_hessian(kinematics, gauge%angles(1))
         if (gauge%angles(2) > 0) curvature(:, 2, :, 2) = -angle_hessian(kinematics, gauge%angles(2))
      end select
   end subroutine gauge_curvature

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
   pure function turning(g, e) result(block)
      real(wp), intent(in) :: g(2), e(2)
      real(wp) :: block(2, 2)
      integer :: i, j
      do j = 1, 2
         do i = 1, 2
            block(i, j) = 3*dot_product(g, e)*e(i)*e(j) - g(i)*e(j) - e(i)*g(j)
         end do
         block(j, j) = block(j, j) - dot_product(g, e)
      end do
   end function turning

   !> Derivative of a marker's position by one of the stacked coordinates of a load's bodies (2).
   pure function gauge_column(gauge, kinematics, m, part, j) result(column)
      type(load_function_type), intent(in) :: gauge
      type(kinematics_type), intent(in) :: kinematics
      !> Which marker of the gauge
      integer, intent(in) :: m
      !> Which of the load's bodies, and which of its coordinates
      integer, intent(in) :: part, j
      real(wp) :: column(2)
      column = 0.0_wp
      if (gauge%parts(m) == part .and. part > 0) column = marker_column(kinematics%markers(gauge%markers(m)), j)
   end function gauge_column

   !> Derivative of a gauge and of its rate by one of the stacked coordinates of a load's bodies.
   pure subroutine gauge_drift(gauge, kinematics, weights, push, part, j, by_place, drift)
      type(load_function_type), intent(in) :: gauge
      type(kinematics_type), intent(in) :: kinematics
      !> Weights, and curvature times velocities (2, 3)
      real(wp), intent(in) :: weights(2, 3), push(2, 3)
      integer, intent(in) :: part, j
      real(wp), intent(out) :: by_place, drift
      real(wp) :: column(2)
      integer :: m
      by_place = 0.0_wp
      drift = 0.0_wp
      if (part == 0) return
      do m = 1, 3
         if (gauge%parts(m) /= part) cycle
         column = marker_column(kinematics%markers(gauge%markers(m)), j)
         by_place = by_place + dot_product(weights(:, m), column)
         drift = drift + dot_product(push(:, m), column) &
            & + dot_product(weights(:, m), drift_column(kinematics, gauge%markers(m), j))
      end do
   end subroutine gauge_drift

end module limber_multibody_load_functions
