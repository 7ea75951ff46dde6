!> Driven angles and coordinates. The angle of a frame, or a coordinate of its origin, prescribed in time. Floor: multibody. Source:
!> doc/theory, eq. (3.6).
module limber_multibody_drivers
   use limber_base_kinds, only: wp
   use limber_multibody_plane_vectors, only: turn
   use limber_multibody_constraint, only: constraint_type, jacobian_type
   use limber_multibody_kinematics, only: kinematics_type
   implicit none
   private
   public :: driven_angle_type, driven_origin_type

   !> The frame's unit vector u points along e = (cos theta, sin theta), theta(t) given: (J e).u = 0. No angle
   !> coordinate is needed; which of the two directions is meant is settled by the assembly and kept by continuity.
   type, extends(constraint_type) :: driven_angle_type
      !> Index of the driver in the model
      integer :: drive = 0
   contains
      procedure :: residual => angle_residual
      procedure :: jacobian => angle_jacobian
      procedure :: rate => angle_rate
      procedure :: stiffness => angle_stiffness
      procedure :: drift => angle_drift
      procedure :: gamma => angle_gamma
   end type driven_angle_type

   !> A coordinate of the origin of a frame, or of a point mass, is s(t): r_k - s = 0
   type, extends(constraint_type) :: driven_origin_type
      !> Index of the driver in the model, and of the axis of space: 1 or 2
      integer :: drive = 0, axis = 1
   contains
      procedure :: residual => origin_residual
      procedure :: jacobian => origin_jacobian
      procedure :: rate => origin_rate
      procedure :: stiffness => origin_stiffness
      procedure :: drift => origin_drift
      procedure :: gamma => origin_gamma
   end type driven_origin_type

contains

   pure subroutine angle_residual(self, kinematics, phi)
      class(driven_angle_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: phi(:)
      phi = dot_product(turn(kinematics%drives(self%drive)%heading), kinematics%frames(self%bodies(1))%u)
   end subroutine angle_residual

   pure subroutine angle_jacobian(self, kinematics, first, second)
      class(driven_angle_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      type(jacobian_type), intent(inout) :: first, second
      first%z(1, 3) = dot_product(kinematics%drives(self%drive)%heading, kinematics%frames(self%bodies(1))%u)
      second%z(1, :) = 0.0_wp
   end subroutine angle_jacobian

   pure subroutine angle_rate(self, kinematics, rate)
      class(driven_angle_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: rate(:)
      associate (drive => kinematics%drives(self%drive))
         rate = drive%rate*dot_product(drive%heading, kinematics%frames(self%bodies(1))%u)
      end associate
   end subroutine angle_rate

   pure subroutine angle_stiffness(self, kinematics, lambda, first, second, across)
      class(driven_angle_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(in) :: lambda(:)
      real(wp), intent(inout) :: first(:, :), second(:, :), across(:, :)
      associate (u => kinematics%frames(self%bodies(1))%u)
         first(3, 3) = first(3, 3) - lambda(1)*dot_product(turn(kinematics%drives(self%drive)%heading), u)
      end associate
   end subroutine angle_stiffness

   pure subroutine angle_drift(self, kinematics, first, second)
      class(driven_angle_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: first(:, :), second(:, :)
      associate (frame => kinematics%frames(self%bodies(1)), drive => kinematics%drives(self%drive))
         first(1, 3) = first(1, 3) + (drive%rate - frame%omega)*dot_product(turn(drive%heading), frame%u)
      end associate
   end subroutine angle_drift

   pure subroutine angle_gamma(self, kinematics, rate)
      class(driven_angle_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: rate(:)
      associate (frame => kinematics%frames(self%bodies(1)), drive => kinematics%drives(self%drive))
         rate = (dot_product(frame%rate, frame%rate) + drive%rate**2)*dot_product(turn(drive%heading), frame%u) &
            & + 2*drive%rate*dot_product(drive%heading, frame%rate) + drive%acceleration*dot_product(drive%heading, frame%u)
      end associate
   end subroutine angle_gamma

   pure subroutine origin_residual(self, kinematics, phi)
      class(driven_origin_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: phi(:)
      phi = kinematics%frames(self%bodies(1))%position(self%axis) - kinematics%drives(self%drive)%value
   end subroutine origin_residual

   pure subroutine origin_jacobian(self, kinematics, first, second)
      class(driven_origin_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      type(jacobian_type), intent(inout) :: first, second
      first%z(1, self%axis) = 1.0_wp
      second%z(1, :) = 0.0_wp
   end subroutine origin_jacobian

   pure subroutine origin_rate(self, kinematics, rate)
      class(driven_origin_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: rate(:)
      rate = kinematics%drives(self%drive)%rate
   end subroutine origin_rate

   !> None: the coordinate is itself linear.
   pure subroutine origin_stiffness(self, kinematics, lambda, first, second, across)
      class(driven_origin_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(in) :: lambda(:)
      real(wp), intent(inout) :: first(:, :), second(:, :), across(:, :)
   end subroutine origin_stiffness

   !> None: the coordinate is itself linear.
   pure subroutine origin_drift(self, kinematics, first, second)
      class(driven_origin_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: first(:, :), second(:, :)
   end subroutine origin_drift

   pure subroutine origin_gamma(self, kinematics, rate)
      class(driven_origin_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: rate(:)
      rate = kinematics%drives(self%drive)%acceleration
   end subroutine origin_gamma

end module limber_multibody_drivers
