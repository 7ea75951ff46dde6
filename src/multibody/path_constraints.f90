!> Joints that hold a point on a curve or on a beam. A curve in the frame of a body, or the line of a beam that deforms. Variables
!> are the place of the point in the body's frame, xi along its first and zeta along its second axis. Floor: multibody. Source:
!> doc/theory, eqs. (3.22)-(3.24), (3.28).
module limber_multibody_path_constraints
   use limber_base_kinds, only: wp
   use limber_base_spline, only: spline_type, new_spline, spline_segment, spline_clamped, spline_natural
   use limber_beam_beam_mesh, only: displacement_field_type
   use limber_model_curve, only: curve_type
   use limber_multibody_beam_path, only: beam_path_type
   use limber_multibody_function_constraints, only: function_constraint_type, variables_type
   use limber_multibody_kinematics, only: kinematics_type
   use limber_multibody_scalar_functions, only: read_function
   implicit none
   private
   public :: curve_joint_type, sliding_type, set_line

   !> A point stays on a curve
   type, extends(function_constraint_type) :: curve_joint_type
      type(curve_type) :: curve
   contains
      procedure :: evaluate => curve_evaluate
      procedure :: place => curve_place
   end type curve_joint_type

   !> A point slides along a beam: zeta = w(s, eta) at the s with xi = s - origin + u(s, eta)
   type, extends(beam_path_type) :: sliding_type
      !> Coordinate along the beam of the frame's origin
      real(wp) :: origin = 0.0_wp
      !> Nodes of the beam (n), shapes of its coordinates there, across (n, bending) and along (n, axial), and their second
      !> derivatives: splines
      real(wp), allocatable :: s(:), w(:, :), w_bent(:, :), u(:, :), u_bent(:, :)
   contains
      procedure :: evaluate => sliding_evaluate
      procedure :: coordinate => sliding_coordinate
   end type sliding_type

contains

   pure subroutine curve_evaluate(self, order, at)
      class(curve_joint_type), intent(in) :: self
      integer, intent(in) :: order
      type(variables_type), intent(inout) :: at
      real(wp) :: gradient(2), hessian(2, 2)
      call self%curve%evaluate(at%z(1:2), at%f(1), gradient, hessian)
      if (order > 0) at%gradient(1, 1:2) = gradient
      if (order > 1) at%hessian(1:2, 1:2, 1) = hessian
   end subroutine curve_evaluate

   !> Where the point is in the frame of the curve, and how it moves there.
   pure subroutine curve_place(self, kinematics, place, rate)
      class(curve_joint_type), intent(in) :: self
      !> Placed, and moved where the rate is asked for
      type(kinematics_type), intent(in) :: kinematics
      !> [length]
      real(wp), intent(out) :: place(2)
      !> [length/time]
      real(wp), intent(out), optional :: rate(2)
      real(wp) :: speed(2), weights(2, 3)
      integer :: j
      do j = 1, 2
         call read_function(self%functions(j), kinematics, place(j), speed(j), weights)
      end do
      if (present(rate)) rate = speed
   end subroutine curve_place

   !> Shapes of a beam as splines of the coordinate along it: those across with the slopes of the field at both ends.
   subroutine set_line(joint, field, origin)
      type(sliding_type), intent(inout) :: joint
      type(displacement_field_type), intent(in) :: field
      !> Coordinate along the beam of the frame's origin
      real(wp), intent(in) :: origin
      type(spline_type) :: spline
      integer :: n, k
      n = size(field%s)
      joint%origin = origin
      allocate (joint%s(n), joint%w(n, size(field%w, 2)), joint%w_bent(n, size(field%w, 2)), joint%u(n, size(field%u, 2)), &
         & joint%u_bent(n, size(field%u, 2)))
      joint%s = field%s
      joint%w = field%w
      joint%u = field%u
      do k = 1, size(joint%w, 2)
         spline = new_spline(joint%s, joint%w(:, k), spline_clamped, [field%theta(0, k), field%theta(n - 1, k)])
         joint%w_bent(:, k) = spline%m
      end do
      do k = 1, size(joint%u, 2)
         spline = new_spline(joint%s, joint%u(:, k), spline_natural)
         joint%u_bent(:, k) = spline%m
      end do
   end subroutine set_line

   !> f = zeta - w(s(xi, eta), eta), with s eliminated by its own equation, or f of s: eqs. (3.22)-(3.24).
   pure subroutine sliding_evaluate(self, order, at)
      class(sliding_type), intent(in) :: self
      integer, intent(in) :: order
      type(variables_type), intent(inout) :: at
      real(wp) :: s, u(0:2), w(0:2), shape(0:2), by_s(size(at%z)), rows(0:2, size(at%z)), mixed
      integer :: i, j, bending, n, axial
      bending = size(self%w, 2)
      n = at%count
      axial = 2 + bending
      s = at%z(1) + self%origin
      call settle(self, at%z, s, u)
      w = 0.0_wp
      rows(:, :n) = 0.0_wp
      do i = 1, bending
         shape = line_shape(self%s, self%w(:, i), self%w_bent(:, i), s)
         w = w + shape*at%z(2 + i)
         rows(:, 2 + i) = shape
      end do
      at%f(1) = at%z(2) - w(0)
      if (self%of_coordinate) at%f(1) = self%factor*s - self%offset
      if (order == 0) return
      ! s by xi, by zeta, by eta across, by eta along
      by_s(:n) = 0.0_wp
      by_s(1) = 1/(1 + u(1))
      do i = 1, size(self%u, 2)
         rows(:, axial + i) = -line_shape(self%s, self%u(:, i), self%u_bent(:, i), s)
         by_s(axial + i) = rows(0, axial + i)*by_s(1)
      end do
      do i = 1, n
         at%gradient(1, i) = -w(1)*by_s(i)
         if (i > 2 .and. i <= axial) at%gradient(1, i) = at%gradient(1, i) - rows(0, i)
      end do
      at%gradient(1, 2) = at%gradient(1, 2) + 1
      if (self%of_coordinate) at%gradient(1, :n) = self%factor*by_s(:n)
      if (order == 1) return
      do j = 1, n
         do i = 1, n
            ! second derivative of s; rows of the axial coordinates hold minus their shapes
            mixed = -u(2)*by_s(i)*by_s(j)
            if (i > axial) mixed = mixed + rows(1, i)*by_s(j)
            if (j > axial) mixed = mixed + rows(1, j)*by_s(i)
            at%hessian(i, j, 1) = -w(2)*by_s(i)*by_s(j) - w(1)*mixed*by_s(1)
            if (i > 2 .and. i <= axial) at%hessian(i, j, 1) = at%hessian(i, j, 1) - rows(1, i)*by_s(j)
            if (j > 2 .and. j <= axial) at%hessian(i, j, 1) = at%hessian(i, j, 1) - rows(1, j)*by_s(i)
            if (self%of_coordinate) at%hessian(i, j, 1) = self%factor*mixed*by_s(1)
         end do
      end do
   end subroutine sliding_evaluate

   !> s and its rate, eqs. (3.22), (3.24).
   pure subroutine sliding_coordinate(self, z, rate, s, speed)
      class(sliding_type), intent(in) :: self
      real(wp), intent(in) :: z(:), rate(:)
      real(wp), intent(out) :: s, speed
      real(wp) :: u(0:2), shape(0:2)
      integer :: k, axial
      axial = 2 + size(self%w, 2)
      s = z(1) + self%origin
      call settle(self, z, s, u)
      speed = rate(1)
      do k = 1, size(self%u, 2)
         shape = line_shape(self%s, self%u(:, k), self%u_bent(:, k), s)
         speed = speed - shape(0)*rate(axial + k)
      end do
      speed = speed/(1 + u(1))
   end subroutine sliding_coordinate

   !> The coordinate along the beam whose section is at xi, by Newton's method; the displacement along it with two derivatives.
   pure subroutine settle(self, z, s, u)
      type(sliding_type), intent(in) :: self
      real(wp), intent(in) :: z(:)
      !> A first guess; the coordinate
      real(wp), intent(inout) :: s
      real(wp), intent(out) :: u(0:2)
      real(wp) :: change
      integer :: round, k, bending
      bending = size(self%w, 2)
      do round = 1, 20
         u = 0.0_wp
         do k = 1, size(self%u, 2)
            u = u + line_shape(self%s, self%u(:, k), self%u_bent(:, k), s)*z(2 + bending + k)
         end do
         change = (z(1) - (s - self%origin) - u(0))/(1 + u(1))
         if (abs(change) <= 2*epsilon(s)*self%s(size(self%s))) return
         s = s + change
      end do
   end subroutine settle

   !> Shape of one coordinate with two derivatives; straight beyond the ends of the beam.
   pure function line_shape(nodes, values, bent, s) result(shape)
      real(wp), intent(in) :: nodes(:), values(:), bent(:), s
      real(wp) :: shape(0:2), place
      integer :: i, n
      n = size(nodes)
      place = max(nodes(1), min(s, nodes(n)))
      ! Nodes that loads and masses have put in are not at equal distances
      i = max(1, min(int((place - nodes(1))/(nodes(n) - nodes(1))*(n - 1)) + 1, n - 1))
      do while (i > 1 .and. place < nodes(i))
         i = i - 1
      end do
      do while (i < n - 1 .and. place > nodes(i + 1))
         i = i + 1
      end do
      shape = spline_segment(nodes(i:i + 1), values(i:i + 1), bent(i:i + 1), place)
      if (.not. abs(s - place) > 0.0_wp) return
      shape(0) = shape(0) + (s - place)*shape(1)
      shape(2) = 0.0_wp
   end function line_shape

end module limber_multibody_path_constraints
