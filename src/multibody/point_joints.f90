!> Revolute joint and point on a line. Floor: multibody. Source: doc/theory, eqs. (3.4), (3.5).
module limber_multibody_point_joints
   use limber_base_kinds, only: wp
   use limber_model_model, only: ground
   use limber_multibody_plane_vectors, only: turn, along
   use limber_multibody_constraint, only: constraint_type, jacobian_type
   use limber_multibody_kinematics, only: kinematics_type, marker_type
   use limber_multibody_markers, only: add_marker, marker_drift, marker_stiffness
   implicit none
   private
   public :: revolute_type, point_on_line_type

   !> Two markers coincide: P1 - P2 = 0
   type, extends(constraint_type) :: revolute_type
      !> Indices of the two markers
      integer :: markers(2) = 0
   contains
      procedure :: residual => revolute_residual
      procedure :: jacobian => revolute_jacobian
      procedure :: stiffness => revolute_stiffness
      procedure :: drift => revolute_drift
      procedure :: gamma => revolute_gamma
   end type revolute_type

   !> The first marker stays on the line through the second along e = A(direction) u of the second body's frame:
   !> (J e).(P1 - P2) = 0
   type, extends(constraint_type) :: point_on_line_type
      !> Indices of the two markers
      integer :: markers(2) = 0
      !> Unit vector of the line in the second body's frame
      real(wp) :: direction(2) = [1.0_wp, 0.0_wp]
   contains
      procedure :: residual => line_residual
      procedure :: jacobian => line_jacobian
      procedure :: stiffness => line_stiffness
      procedure :: drift => line_drift
      procedure :: gamma => line_gamma
      procedure :: couples => line_couples
   end type point_on_line_type

contains

   pure subroutine revolute_residual(self, kinematics, phi)
      class(revolute_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: phi(:)
      phi = kinematics%markers(self%markers(1))%position - kinematics%markers(self%markers(2))%position
   end subroutine revolute_residual

   pure subroutine revolute_jacobian(self, kinematics, first, second)
      class(revolute_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      type(jacobian_type), intent(inout) :: first, second
      call place_rows(kinematics%markers(self%markers(1)), 1.0_wp, first)
      call place_rows(kinematics%markers(self%markers(2)), -1.0_wp, second)
   end subroutine revolute_jacobian

   !> Rows of the Jacobian of (sign position of a marker).
   pure subroutine place_rows(marker, sign, jacobian)
      type(marker_type), intent(in) :: marker
      real(wp), intent(in) :: sign
      type(jacobian_type), intent(inout) :: jacobian
      integer :: k
      if (marker%body == ground) return
      jacobian%z(1, 1) = sign
      jacobian%z(2, 2) = sign
      jacobian%z(1, 3) = sign*marker%lever(1)
      jacobian%z(2, 3) = sign*marker%lever(2)
      do k = 1, size(marker%shape, 2)
         jacobian%eta(1, k) = sign*marker%shape(1, k)
         jacobian%eta(2, k) = sign*marker%shape(2, k)
      end do
   end subroutine place_rows

   pure subroutine revolute_gamma(self, kinematics, rate)
      class(revolute_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: rate(:)
      rate = kinematics%markers(self%markers(2))%bias - kinematics%markers(self%markers(1))%bias
   end subroutine revolute_gamma

   pure subroutine revolute_stiffness(self, kinematics, lambda, first, second, across)
      class(revolute_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(in) :: lambda(:)
      real(wp), intent(inout) :: first(:, :), second(:, :), across(:, :)
      call marker_stiffness(kinematics, self%markers(1), lambda, first)
      call marker_stiffness(kinematics, self%markers(2), -lambda(1:2), second)
   end subroutine revolute_stiffness

   pure subroutine revolute_drift(self, kinematics, first, second)
      class(revolute_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: first(:, :), second(:, :)
      real(wp), parameter :: x(2) = [1.0_wp, 0.0_wp], y(2) = [0.0_wp, 1.0_wp]
      call marker_drift(kinematics, self%markers(1), x, first(1, :))
      call marker_drift(kinematics, self%markers(1), y, first(2, :))
      call marker_drift(kinematics, self%markers(2), -x, second(1, :))
      call marker_drift(kinematics, self%markers(2), -y, second(2, :))
   end subroutine revolute_drift

   pure subroutine line_residual(self, kinematics, phi)
      class(point_on_line_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: phi(:)
      phi = dot_product(normal(self, kinematics), gap(self, kinematics))
   end subroutine line_residual

   pure subroutine line_jacobian(self, kinematics, first, second)
      class(point_on_line_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      type(jacobian_type), intent(inout) :: first, second
      real(wp) :: across(2)
      across = normal(self, kinematics)
      call marker_row(kinematics%markers(self%markers(1)), across, first, 1)
      call marker_row(kinematics%markers(self%markers(2)), -across, second, 1)
      if (self%bodies(2) /= ground) second%z(1, 3) = second%z(1, 3) + dot_product(turn(across), gap(self, kinematics))
   end subroutine line_jacobian

   pure subroutine line_gamma(self, kinematics, rate)
      class(point_on_line_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: rate(:)
      real(wp) :: across(2), turning(2)
      across = normal(self, kinematics)
      associate (a => kinematics%markers(self%markers(1)), b => kinematics%markers(self%markers(2)), &
         & frame => kinematics%frames(self%bodies(2)))
         turning = turn(along(self%direction, frame%rate))
         rate = -dot_product(across, a%bias - b%bias) - 2*dot_product(turning, a%velocity - b%velocity) &
            & + dot_product(frame%rate, frame%rate)*dot_product(across, gap(self, kinematics))
      end associate
   end subroutine line_gamma

   pure subroutine line_stiffness(self, kinematics, lambda, first, second, across)
      class(point_on_line_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(in) :: lambda(:)
      real(wp), intent(inout) :: first(:, :), second(:, :), across(:, :)
      real(wp) :: force(2), turned(2), arm(2)
      integer :: k
      force = lambda(1)*normal(self, kinematics)
      associate (a => kinematics%markers(self%markers(1)), frame => kinematics%frames(self%bodies(2)))
         call marker_stiffness(kinematics, self%markers(1), force, first)
         if (self%bodies(2) == ground .or. size(second, 1) < 3) return
         turned = turn(force)
         arm = a%position - frame%position
         second(1:2, 3) = second(1:2, 3) - turned
         second(3, 1:2) = second(3, 1:2) - turned
         second(3, 3) = second(3, 3) - dot_product(force, arm)
         if (size(first) == 0) return
         across(1:2, 3) = across(1:2, 3) + turned
         if (size(across, 1) < 3) return
         across(3, 3) = across(3, 3) + dot_product(turned, a%lever)
         do k = 1, size(a%shape, 2)
            across(3 + k, 3) = across(3 + k, 3) + dot_product(turned, a%shape(:, k))
         end do
      end associate
   end subroutine line_stiffness

   !> Between two bodies: the force on the point turns with the line.
   pure logical function line_couples(self)
      class(point_on_line_type), intent(in) :: self
      line_couples = all(self%bodies /= ground)
   end function line_couples

   pure subroutine line_drift(self, kinematics, first, second)
      class(point_on_line_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: first(:, :), second(:, :)
      real(wp) :: across(2), turning(2)
      across = normal(self, kinematics)
      call marker_drift(kinematics, self%markers(1), across, first(1, :))
      if (self%bodies(2) == ground) return
      if (size(second, 2) < 3) then
         call marker_drift(kinematics, self%markers(2), -across, second(1, :))
         return
      end if
      ! (J e).(v1 - r2') + (J e)'.(P1 - r2): its derivatives by what moves the point, then by what moves the line
      associate (a => kinematics%markers(self%markers(1)), frame => kinematics%frames(self%bodies(2)))
         turning = frame%omega*turn(across)
         call add_marker(a, turning, first(1, :))
         second(1, 1:2) = second(1, 1:2) - turning
         second(1, 3) = second(1, 3) + dot_product(turn(across), a%velocity - frame%velocity) &
            & - frame%omega*dot_product(across, a%position - frame%position)
      end associate
   end subroutine line_drift

   !> Unit normal J e of the line.
   pure function normal(self, kinematics) result(across)
      class(point_on_line_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp) :: across(2)
      across = turn(along(self%direction, kinematics%frames(self%bodies(2))%u))
   end function normal

   !> P1 - P2.
   pure function gap(self, kinematics) result(difference)
      class(point_on_line_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp) :: difference(2)
      difference = kinematics%markers(self%markers(1))%position - kinematics%markers(self%markers(2))%position
   end function gap

   !> Row of the Jacobian of (weight . position of a marker).
   pure subroutine marker_row(marker, weight, jacobian, row)
      type(marker_type), intent(in) :: marker
      real(wp), intent(in) :: weight(2)
      type(jacobian_type), intent(inout) :: jacobian
      integer, intent(in) :: row
      integer :: k
      if (marker%body == ground) return
      jacobian%z(row, 1:2) = weight
      jacobian%z(row, 3) = dot_product(weight, marker%lever)
      do k = 1, size(marker%shape, 2)
         jacobian%eta(row, k) = weight(1)*marker%shape(1, k) + weight(2)*marker%shape(2, k)
      end do
   end subroutine marker_row

end module limber_multibody_point_joints
