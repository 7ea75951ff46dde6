!> Contributions of a marker to equations in the rates of its body. First and second derivatives of (weight . position) and of
!> (weight . velocity), of points as of directions; and the derivatives of an angle by the vector that it is of. Joints and loads
!> are made of these. Floor: multibody. Source: doc/theory, eqs. (3.7), (3.9), (3.14).
module limber_multibody_markers
   use limber_base_kinds, only: wp
   use limber_model_model, only: ground
   use limber_multibody_plane_vectors, only: turn, along, cross
   use limber_multibody_kinematics, only: kinematics_type, marker_type
   implicit none
   private
   public :: add_marker, marker_drift, marker_stiffness, marker_column, drift_column
   public :: angle_change, vector_angle_gradient, vector_angle_hessian

contains

   !> Adds the derivatives of (weight . position of a marker) to a row.
   pure subroutine add_marker(marker, weight, row)
      type(marker_type), intent(in) :: marker
      real(wp), intent(in) :: weight(2)
      real(wp), intent(inout) :: row(:)
      integer :: k
      if (marker%body == ground) return
      if (.not. marker%direction) row(1:2) = row(1:2) + weight
      if (size(row) < 3) return
      row(3) = row(3) + dot_product(weight, marker%lever)
      do k = 1, size(marker%shape, 2)
         row(3 + k) = row(3 + k) + dot_product(weight, marker%shape(:, k))
      end do
   end subroutine add_marker

   !> Adds the derivatives of (weight . velocity of a marker) with respect to (r, rotation, eta) to a row.
   pure subroutine marker_drift(kinematics, marker, weight, row)
      type(kinematics_type), intent(in) :: kinematics
      integer, intent(in) :: marker
      real(wp), intent(in) :: weight(2)
      real(wp), intent(inout) :: row(:)
      integer :: k
      if (size(row) < 3) return
      associate (point => kinematics%markers(marker), frame => kinematics%frames(kinematics%markers(marker)%body))
         row(3) = row(3) + dot_product(weight, swing(kinematics, marker))
         do k = 1, size(point%shape, 2)
            row(3 + k) = row(3 + k) + frame%omega*dot_product(weight, turn(point%shape(:, k)))
         end do
         if (point%line == 0) return
         do k = 1, size(point%shape, 2)
            row(3 + k) = row(3 + k) + dot_product(weight, bending_drift(kinematics, point, k))
         end do
      end associate
   end subroutine marker_drift

   !> Adds the second derivatives of (force . position of a marker) with respect to (r, rotation, eta).
   pure subroutine marker_stiffness(kinematics, marker, force, k)
      type(kinematics_type), intent(in) :: kinematics
      !> Its index
      integer, intent(in) :: marker
      real(wp), intent(in) :: force(2)
      real(wp), intent(inout) :: k(:, :)
      real(wp) :: part
      integer :: j
      if (size(k, 1) < 3) return
      associate (point => kinematics%markers(marker))
         k(3, 3) = k(3, 3) + dot_product(turn(point%lever), force)
         do j = 1, size(point%shape, 2)
            part = dot_product(turn(point%shape(:, j)), force)
            k(3, 3 + j) = k(3, 3 + j) + part
            k(3 + j, 3) = k(3 + j, 3) + part
         end do
         if (point%line > 0 .and. size(point%shape, 2) > 0) call bend_marker(kinematics, point, force, k(4:, 4:))
      end associate
   end subroutine marker_stiffness

   !> The second derivatives by the coordinates of an exact beam, eq. (2.44).
   pure subroutine bend_marker(kinematics, marker, force, k)
      type(kinematics_type), intent(in) :: kinematics
      type(marker_type), intent(in) :: marker
      real(wp), intent(in) :: force(2)
      real(wp), intent(inout) :: k(:, :)
      real(wp) :: within(2)
      integer :: i, j
      if (marker%direction) then
         ! shape = psi J d, so that the second derivative -psi psi d is the product of shapes along J d
         do j = 1, size(marker%shape, 2)
            do i = 1, size(marker%shape, 2)
               k(i, j) = k(i, j) - dot_product(marker%shape(:, i), marker%lever)*dot_product(marker%shape(:, j), marker%lever) &
                  & *dot_product(force, marker%position)
            end do
         end do
         return
      end if
      if (.not. marker%reaching) return
      within = along(force, kinematics%frames(marker%body)%u*[1.0_wp, -1.0_wp])
      call kinematics%lines(marker%line)%add_bend(marker%reach, within, k)
   end subroutine bend_marker

   !> Derivative of a marker's position by one of its body's (r, rotation, eta); the same is that of its velocity by the rate.
   pure function marker_column(marker, j) result(column)
      type(marker_type), intent(in) :: marker
      !> Which of them
      integer, intent(in) :: j
      real(wp) :: column(2)
      select case (j)
      case (1); column = [1.0_wp, 0.0_wp]
      case (2); column = [0.0_wp, 1.0_wp]
      case (3); column = marker%lever
      case default
         column = 0.0_wp
         if (j - 3 <= size(marker%shape, 2)) column = marker%shape(:, j - 3)
      end select
      if (marker%direction .and. j < 3) column = 0.0_wp
   end function marker_column

   !> Derivative of a marker's velocity by one of its body's (r, rotation, eta).
   pure function drift_column(kinematics, marker, j) result(column)
      type(kinematics_type), intent(in) :: kinematics
      integer, intent(in) :: marker, j
      real(wp) :: column(2)
      associate (point => kinematics%markers(marker), frame => kinematics%frames(kinematics%markers(marker)%body))
         select case (j)
         case (1:2); column = 0.0_wp
         case (3); column = swing(kinematics, marker)
         case default
            column = 0.0_wp
            if (j - 3 <= size(point%shape, 2)) column = frame%omega*turn(point%shape(:, j - 3))
            if (j - 3 <= size(point%shape, 2) .and. point%line > 0) column = column + bending_drift(kinematics, point, j - 3)
         end select
      end associate
   end function drift_column

   !> Rate of the derivative of a marker's position by a coordinate of an exact beam, without that of the frame.
   pure function bending_drift(kinematics, marker, j) result(rate)
      type(kinematics_type), intent(in) :: kinematics
      type(marker_type), intent(in) :: marker
      integer, intent(in) :: j
      real(wp) :: rate(2)
      associate (frame => kinematics%frames(marker%body))
         if (marker%direction) then
            rate = (cross(marker%position, marker%velocity) - frame%omega)*turn(marker%shape(:, j))
         else
            rate = along(kinematics%lines(marker%line)%drift_of(marker%reach, j), frame%u)
         end if
      end associate
   end function bending_drift

   !> Derivative of a marker's velocity by the rotation of its frame.
   pure function swing(kinematics, marker) result(column)
      type(kinematics_type), intent(in) :: kinematics
      integer, intent(in) :: marker
      real(wp) :: column(2)
      associate (point => kinematics%markers(marker), frame => kinematics%frames(kinematics%markers(marker)%body))
         column = turn(point%velocity)
         if (.not. point%direction) column = turn(point%velocity - frame%velocity)
      end associate
   end function swing

   !> The vector of an angle and its rate; over a step their mean and increment over the step.
   pure subroutine angle_vector(kinematics, angle, vector, rate)
      type(kinematics_type), intent(in) :: kinematics
      !> Index of the angle
      integer, intent(in) :: angle
      real(wp), intent(out) :: vector(2), rate(2)
      associate (from => kinematics%angles(angle)%markers(1), to => kinematics%markers(kinematics%angles(angle)%markers(2)))
         vector = to%position
         rate = to%velocity
         if (from > 0) vector = vector - kinematics%markers(from)%position
         if (from > 0) rate = rate - kinematics%markers(from)%velocity
      end associate
   end subroutine angle_vector

   !> What an angle changes by over a step; of the mean only.
   pure real(wp) function angle_change(kinematics, angle) result(change)
      type(kinematics_type), intent(in) :: kinematics
      !> Index of the angle
      integer, intent(in) :: angle
      real(wp) :: vector(2), rate(2), half(2)
      call angle_vector(kinematics, angle, vector, rate)
      half = 0.5_wp*kinematics%span*rate
      change = atan2(cross(vector - half, vector + half), dot_product(vector - half, vector + half))
   end function angle_change

   !> Derivative of the angle of a vector by it, J w/(w.w). Over a step the multiple of J w of the mean that makes the change of
   !> the angle, eq. (3.9).
   pure function vector_angle_gradient(vector, rate, span) result(gradient)
      !> The vector and its rate; over a step of length `span` their mean and increment over it
      real(wp), intent(in) :: vector(2), rate(2), span
      real(wp) :: gradient(2), half(2), sine, cosine, ratio
      if (.not. span > 0.0_wp) then
         gradient = turn(vector)/dot_product(vector, vector)
         return
      end if
      half = 0.5_wp*span*rate
      sine = cross(vector - half, vector + half)
      cosine = dot_product(vector - half, vector + half)
      ratio = sine/cosine
      if (abs(ratio) < 1.0e-3_wp .and. cosine > 0.0_wp) then
         ratio = (1 - ratio**2*(1 - ratio**2*(0.6_wp - ratio**2*(3.0_wp/7)))/3)/cosine
      else
         ratio = atan2(sine, cosine)/sine
      end if
      gradient = ratio*turn(vector)
   end function vector_angle_gradient

   !> Second derivatives of the angle of a vector by it, -(w (J w)^T + J w w^T)/(w.w)^2.
   pure function vector_angle_hessian(vector) result(hessian)
      real(wp), intent(in) :: vector(2)
      real(wp) :: hessian(2, 2), along(2), across(2)
      integer :: i, j
      along = vector/dot_product(vector, vector)
      across = turn(along)
      do j = 1, 2
         do i = 1, 2
            hessian(i, j) = -(along(i)*across(j) + across(i)*along(j))
         end do
      end do
   end function vector_angle_hessian

end module limber_multibody_markers
