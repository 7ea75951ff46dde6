!> What the tests of integrators share: a pendulum of length 1 with its known motion, and the start on a model.
module swings
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_integrator_integrator, only: integrator_type
   use limber_model_model, only: ground, model_type
   use limber_multibody_assembly, only: assemble, first_guess
   use limber_multibody_system, only: new_system, new_workspace, system_type, workspace_type
   use scenes, only: joint_revolute, add_rigid, empty_model, join
   use testing, only: check_no_error
   implicit none
   private
   public :: pendulum, swing_of, begin

   !> Gravity of the pendulum
   real(wp), parameter, public :: g = 9.81_wp
   !> Its period from rest at the horizontal, 4 K(sin 45 degrees)/sqrt(g), and its place at t = 10
   real(wp), parameter, public :: period = 2.36784194757623745_wp
   real(wp), parameter, public :: place(2) = [0.27508746257611686_wp, -0.961419205099125_wp]

contains

   !> A mass of 1 without moment of inertia at (1, 0) of a body whose origin is pinned to the ground.
   function pendulum() result(model)
      type(model_type) :: model
      integer :: bob
      model = empty_model(1.0_wp)
      model%gravity = [0.0_wp, -g]
      bob = add_rigid(model, 'bob', 1.0_wp, 0.0_wp, [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp], 0.0_wp)
      call join(model, 'pin', joint_revolute, bob, [0.0_wp, 0.0_wp], ground, [0.0_wp, 0.0_wp])
   end function pendulum

   !> Angle of the pendulum, theta'' = -g cos(theta), by Runge and Kutta's fourth-order method with steps so small that its error
   !> is round-off: 1e-13.
   pure subroutine swing_of(from, to, theta, omega)
      !> Times
      real(wp), intent(in) :: from, to
      !> At the first time, then at the second
      real(wp), intent(inout) :: theta, omega
      real(wp) :: h, a(4), b(4)
      integer :: i, steps
      steps = 1 + int((to - from)/2.0e-4_wp)
      h = (to - from)/steps
      do i = 1, steps
         a(1) = omega
         b(1) = -g*cos(theta)
         a(2) = omega + h*b(1)/2
         b(2) = -g*cos(theta + h*a(1)/2)
         a(3) = omega + h*b(2)/2
         b(3) = -g*cos(theta + h*a(2)/2)
         a(4) = omega + h*b(3)
         b(4) = -g*cos(theta + h*a(3))
         theta = theta + h*(a(1) + 2*a(2) + 2*a(3) + a(4))/6
         omega = omega + h*(b(1) + 2*b(2) + 2*b(3) + b(4))/6
      end do
   end subroutine swing_of

   !> Assembles a model and starts an integrator on it.
   subroutine begin(model, tolerance, duration, system, work, integrator, q, v)
      type(model_type), intent(in) :: model
      real(wp), intent(in) :: tolerance, duration
      type(system_type), intent(out) :: system
      type(workspace_type), intent(out) :: work
      class(integrator_type), intent(inout) :: integrator
      !> Coordinates and velocities at the start
      real(wp), allocatable, intent(out) :: q(:), v(:)
      type(error_type), allocatable :: error
      integer :: culprit
      system = new_system(model)
      call new_workspace(system, work)
      allocate (q(system%layout%nq), v(system%layout%nq))
      q = 0.0_wp
      v = 0.0_wp
      call first_guess(system, 0.0_wp, q, v)
      call assemble(system, work, 0.0_wp, q, v, error, culprit)
      call check_no_error(error, 'assembly')
      integrator%tolerance = tolerance
      call integrator%start(system, work, 0.0_wp, duration, q, v, error)
      call check_no_error(error, 'start')
   end subroutine begin

end module swings
