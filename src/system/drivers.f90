!> Driven motion: the angle of a frame prescribed in time. Floor: system. Source: doc/theory, eq. (31).
module limber_system_drivers
   use limber_base_kinds, only: wp
   use limber_system_algebra, only: turn
   use limber_system_constraint, only: constraint_type, jacobian_type
   use limber_system_kinematics, only: kinematics_type
   implicit none
   private
   public :: driven_angle_type

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
      second = second
      across = across
   end subroutine angle_stiffness

   pure subroutine angle_drift(self, kinematics, first, second)
      class(driven_angle_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: first(:, :), second(:, :)
      associate (frame => kinematics%frames(self%bodies(1)), drive => kinematics%drives(self%drive))
         first(1, 3) = first(1, 3) + (drive%rate - frame%omega)*dot_product(turn(drive%heading), frame%u)
      end associate
      second = second
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

end module limber_system_drivers
