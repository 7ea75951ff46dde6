!> Base type of constraints. Its residual, its Jacobian with respect to the independent rates (r', omega, eta') of the one or two
!> bodies it acts on, and the right-hand sides of its velocity and acceleration equations. An equation of more bodies, a coupler, is
!> a sum of parts of two bodies each: the parts behind the first have its equations for theirs, and add to them. Floor: multibody.
!> Source: doc/theory, eqs. (3.1), (3.21).
module limber_multibody_constraint
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_model_model, only: ground
   use limber_multibody_kinematics, only: kinematics_type
   implicit none
   private
   public :: constraint_type, constraint_item_type, jacobian_type, new_jacobian

   !> Rows of the Jacobian that act on one body: z (rows,3) on r' and omega, eta (rows,n) on eta'
   type :: jacobian_type
      real(wp), allocatable :: z(:, :), eta(:, :)
   contains
      procedure :: exchange => exchange_jacobian
   end type jacobian_type

   !> A joint or a driver
   type, abstract :: constraint_type
      !> For messages: "joint 'crank-pin'"
      character(:), allocatable :: label
      !> Number of equations, and where they stand among all
      integer :: rows = 0, first = 0
      !> The bodies it acts on; `ground` where there is none
      integer :: bodies(2) = ground
      !> Points of the model where it acts on them; 0: none
      integer :: points(2) = 0
      !> Length that a residual is to be compared with: 1 for angles
      real(wp) :: scale = 1.0_wp
      !> True if it moves in time, and so puts work in
      logical :: driven = .false.
      !> Index of the constraint that it is a part of: their equations, and so `rows`, `first`, `scale`, are the same, and it adds
      !> to what that one writes, which comes first; 0: it is a constraint of its own
      integer :: part_of = 0
   contains
      !> Position residual
      procedure(residual_interface), deferred :: residual
      !> Jacobian on either body
      procedure(jacobian_interface), deferred :: jacobian
      !> Derivative of Jacobian^T lambda with respect to the bodies' coordinates: what implicit methods need
      procedure(stiffness_interface), deferred :: stiffness
      !> Derivative of Jacobian times rates, less the rate, with respect to the bodies' coordinates
      procedure(drift_interface), deferred :: drift
      !> Acceleration equation: Jacobian times accelerations = rate
      procedure(rate_interface), deferred :: gamma
      !> Velocity equation: Jacobian times rates = rate; zero unless the constraint moves in time
      procedure :: rate => resting_rate
      !> Whether `stiffness` has a part across the two bodies
      procedure :: couples => never
   end type constraint_type

   !> One place of a list of constraints
   type :: constraint_item_type
      class(constraint_type), allocatable :: item
   end type constraint_item_type

   abstract interface
      !> Writes phi (rows), or adds to it (`part_of`); kinematics are placed at their time.
      pure subroutine residual_interface(self, kinematics, phi)
         import :: constraint_type, kinematics_type, wp
         class(constraint_type), intent(in) :: self
         type(kinematics_type), intent(in) :: kinematics
         real(wp), intent(inout) :: phi(:)
      end subroutine residual_interface

      !> Writes the rows on the first and the second body; kinematics are placed. What is zero always is left alone.
      pure subroutine jacobian_interface(self, kinematics, first, second)
         import :: constraint_type, kinematics_type, jacobian_type, wp
         class(constraint_type), intent(in) :: self
         type(kinematics_type), intent(in) :: kinematics
         type(jacobian_type), intent(inout) :: first, second
      end subroutine jacobian_interface

      !> Writes a right-hand side (rows), or adds to it (`part_of`); kinematics are placed, for `gamma` also moved.
      pure subroutine rate_interface(self, kinematics, rate)
         import :: constraint_type, kinematics_type, wp
         class(constraint_type), intent(in) :: self
         type(kinematics_type), intent(in) :: kinematics
         real(wp), intent(inout) :: rate(:)
      end subroutine rate_interface

      !> Adds the second derivatives of lambda.phi with respect to (r, rotation, eta): within the first and the second body, and
      !> rows first, columns second body. Arrays of a body that is the ground have no size. Kinematics are placed.
      pure subroutine stiffness_interface(self, kinematics, lambda, first, second, across)
         import :: constraint_type, kinematics_type, wp
         class(constraint_type), intent(in) :: self
         type(kinematics_type), intent(in) :: kinematics
         real(wp), intent(in) :: lambda(:)
         real(wp), intent(inout) :: first(:, :), second(:, :), across(:, :)
      end subroutine stiffness_interface

      !> Adds the derivatives of the velocity equation, rows of it, columns (r, rotation, eta) of either body. Kinematics are
      !> placed and moved.
      pure subroutine drift_interface(self, kinematics, first, second)
         import :: constraint_type, kinematics_type, wp
         class(constraint_type), intent(in) :: self
         type(kinematics_type), intent(in) :: kinematics
         real(wp), intent(inout) :: first(:, :), second(:, :)
      end subroutine drift_interface
   end interface

contains

   !> The rate of a constraint that does not depend on time.
   pure subroutine resting_rate(self, kinematics, rate)
      class(constraint_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: rate(:)
      rate = 0.0_wp
   end subroutine resting_rate

   !> A constraint whose second derivatives are within its bodies.
   pure logical function never(self)
      class(constraint_type), intent(in) :: self
      never = self%rows < 0
   end function never

   !> Room for the rows on a body with n coordinates, all zero.
   pure function new_jacobian(rows, n) result(jacobian)
      integer, intent(in) :: rows, n
      type(jacobian_type) :: jacobian
      allocate (jacobian%z(rows, 3), jacobian%eta(rows, n))
      jacobian%z = 0.0_wp
      jacobian%eta = 0.0_wp
   end function new_jacobian

   !> Saves or restores its memory.
   subroutine exchange_jacobian(self, snapshot)
      class(jacobian_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%keep('z', self%z)
      call snapshot%keep('eta', self%eta)
   end subroutine exchange_jacobian

end module limber_multibody_constraint
