!> What a marker adds to equations in the independent rates (r, rotation, eta) of its body: first and second derivatives of
!> (weight . position) and of (weight . velocity). Joints and loads are made of these. Floor: system. Source: doc/theory.
module limber_system_markers
   use limber_base_kinds, only: wp
   use limber_model_scene, only: ground
   use limber_system_algebra, only: turn
   use limber_system_kinematics, only: kinematics_type, marker_type
   implicit none
   private
   public :: add_marker, marker_drift, marker_stiffness, marker_column, drift_column

contains

   !> Adds the derivatives of (weight . position of a marker) to a row.
   pure subroutine add_marker(marker, weight, row)
      type(marker_type), intent(in) :: marker
      real(wp), intent(in) :: weight(2)
      real(wp), intent(inout) :: row(:)
      integer :: k
      if (marker%body == ground) return
      row(1:2) = row(1:2) + weight
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
         row(3) = row(3) + dot_product(weight, turn(point%velocity - frame%velocity))
         do k = 1, size(point%shape, 2)
            row(3 + k) = row(3 + k) + frame%omega*dot_product(weight, turn(point%shape(:, k)))
         end do
      end associate
   end subroutine marker_drift

   !> Adds the second derivatives of (force . position of a marker) with respect to (r, rotation, eta).
   pure subroutine marker_stiffness(marker, force, k)
      type(marker_type), intent(in) :: marker
      real(wp), intent(in) :: force(2)
      real(wp), intent(inout) :: k(:, :)
      real(wp) :: part
      integer :: j
      if (size(k, 1) < 3) return
      k(3, 3) = k(3, 3) + dot_product(turn(marker%lever), force)
      do j = 1, size(marker%shape, 2)
         part = dot_product(turn(marker%shape(:, j)), force)
         k(3, 3 + j) = k(3, 3 + j) + part
         k(3 + j, 3) = k(3 + j, 3) + part
      end do
   end subroutine marker_stiffness

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
      case default; column = marker%shape(:, j - 3)
      end select
   end function marker_column

   !> Derivative of a marker's velocity by one of its body's (r, rotation, eta).
   pure function drift_column(kinematics, marker, j) result(column)
      type(kinematics_type), intent(in) :: kinematics
      integer, intent(in) :: marker, j
      real(wp) :: column(2)
      associate (point => kinematics%markers(marker), frame => kinematics%frames(kinematics%markers(marker)%body))
         select case (j)
         case (1:2); column = 0.0_wp
         case (3); column = turn(point%velocity - frame%velocity)
         case default; column = frame%omega*turn(point%shape(:, j - 3))
         end select
      end associate
   end function drift_column

end module limber_system_markers
