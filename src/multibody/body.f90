!> Mass matrix and forces of one body: polynomials with constant invariants.
!>
!> The norm constraint u.u = 1 is eliminated here: u' = omega J u and u'' = alpha J u - (u'.u') u, so that the
!> unknown accelerations of a body are (r'', alpha, eta''). Their mass matrix, rows in that order, is
!>
!>    [ m I    J A(c) u          A(C_k) u    ]      c = c0 + C eta,  h = e - E eta,
!>    [ .      I(eta)            h_k         ]      I(eta) = I0 + 2 d.eta + eta.eta
!>    [ .      .                 1           ]
!>
!> less eta.R eta in I(eta) where nodes have a rotary inertia, eq. (1.13).
!>
!> Plain kernels on arrays; no allocation. Floor: multibody. Source: Han and Lee 1993, eqs. (6), (7), (28); doc/theory, eqs.
!> (1.7)-(1.11), (1.15), (1.17).
module limber_multibody_body
   use limber_base_kinds, only: wp
   use limber_beam_reduced_body, only: reduced_type, rotary_row, rotary_square
   use limber_multibody_plane_vectors, only: turn, along, cross
   implicit none
   private
   public :: rigid_mass, rigid_forces, body_mass, body_tangent, velocity_forces, gravity_forces, inertia_forces, &
      & kinetic_energy, weight_potential, centre_moment

contains

   !> First moment of mass c = c0 + C eta in the body frame (2) [mass length].
   pure function centre_moment(body, eta) result(c)
      type(reduced_type), intent(in) :: body
      real(wp), intent(in) :: eta(:)
      real(wp) :: c(2)
      integer :: k
      c = body%c0
      do k = 1, body%n
         c(1) = c(1) + body%c(1, k)*eta(k)
         c(2) = c(2) + body%c(2, k)*eta(k)
      end do
   end function centre_moment

   !> The mass matrix of (r'', alpha) of a body without coordinates.
   pure subroutine rigid_mass(inertia, u, frame)
      !> Mass, first moment (2) and second moment of mass about the origin of the frame
      real(wp), intent(in) :: inertia(4)
      !> Unit vector of the frame (2)
      real(wp), intent(in) :: u(2)
      real(wp), intent(out) :: frame(3, 3)
      real(wp) :: arm(2)
      arm = along(inertia(2:3), u)
      frame(:, 1) = [inertia(1), 0.0_wp, -arm(2)]
      frame(:, 2) = [0.0_wp, inertia(1), arm(1)]
      frame(:, 3) = [-arm(2), arm(1), inertia(4)]
   end subroutine rigid_mass

   !> Velocity terms and weight of a body without coordinates.
   pure subroutine rigid_forces(inertia, gravity, u, omega, on_frame)
      !> As in `rigid_mass`; acceleration of gravity (2), unit vector of the frame (2), angular velocity
      real(wp), intent(in) :: inertia(4), gravity(2), u(2), omega
      real(wp), intent(out) :: on_frame(3)
      real(wp) :: arm(2), square
      arm = along(inertia(2:3), u)
      square = omega**2
      on_frame(1) = square*arm(1) + inertia(1)*gravity(1)
      on_frame(2) = square*arm(2) + inertia(1)*gravity(2)
      on_frame(3) = cross(arm, gravity)
   end subroutine rigid_forces

   !> The mass matrix of (r'', alpha) and its coupling with eta''.
   pure subroutine body_mass(body, u, eta, frame, coupling)
      type(reduced_type), intent(in) :: body
      !> Unit vector of the frame (2)
      real(wp), intent(in) :: u(2)
      !> Coordinates (n)
      real(wp), contiguous, intent(in) :: eta(:)
      !> Mass matrix of (r'', alpha) (3,3)
      real(wp), intent(out) :: frame(3, 3)
      !> Rows eta'', columns (r'', alpha) (n,3)
      real(wp), intent(inout) :: coupling(:, :)
      real(wp) :: inertia, c(2), h
      integer :: k, j
      c = body%c0
      inertia = body%i0
      do k = 1, body%n
         c(1) = c(1) + body%c(1, k)*eta(k)
         c(2) = c(2) + body%c(2, k)*eta(k)
         inertia = inertia + (2*body%d(k) + eta(k))*eta(k)
         h = body%e(k)
         do j = 1, body%n
            h = h + body%skew(j, k)*eta(j)
         end do
         coupling(k, 1) = body%c(1, k)*u(1) - body%c(2, k)*u(2)
         coupling(k, 2) = body%c(1, k)*u(2) + body%c(2, k)*u(1)
         coupling(k, 3) = h
      end do
      if (body%spinning) inertia = inertia - rotary_square(body, eta)
      c = along(c, u)
      frame(:, 1) = [body%mass, 0.0_wp, -c(2)]
      frame(:, 2) = [0.0_wp, body%mass, c(1)]
      frame(:, 3) = [-c(2), c(1), inertia]
   end subroutine body_mass

   !> Derivatives of the inertia forces and the weight, M a + velocity terms - weight, with respect to (rotation, eta) and to
   !> (omega, eta'), both without the row and column of r: nothing depends on r or r'.
   pure subroutine body_tangent(body, gravity, u, omega, eta, rate, acceleration, alpha, eta_acceleration, stiffness, damping)
      type(reduced_type), intent(in) :: body
      !> Acceleration of gravity (2) [length/time^2]
      real(wp), intent(in) :: gravity(2)
      !> Unit vector of the frame (2), angular velocity, coordinates and their rates (n)
      real(wp), intent(in) :: u(2), omega, eta(:), rate(:)
      !> r'' (2), alpha, eta'' (n)
      real(wp), intent(in) :: acceleration(2), alpha, eta_acceleration(:)
      !> Rows r'' (2), alpha, eta''; columns rotation, eta: (3 + n, 1 + n). Added to
      real(wp), intent(inout) :: stiffness(:, :)
      !> The same rows; columns omega, eta': (3 + n, 1 + n). Added to
      real(wp), intent(inout) :: damping(:, :)
      real(wp) :: c(2), drift(2), push(2), heavy(2), arm(2), turning
      integer :: j, k
      c = centre_moment(body, eta)
      drift = 0.0_wp
      push = 0.0_wp
      turning = 0.0_wp
      do k = 1, body%n
         drift = drift + body%c(:, k)*rate(k)
         push = push + body%c(:, k)*eta_acceleration(k)
         turning = turning + (body%d(k) + eta(k))*rate(k)
      end do
      heavy = acceleration - gravity
      stiffness(1:2, 1) = stiffness(1:2, 1) + turn(along(alpha*turn(c) - omega**2*c + push + 2*omega*turn(drift), u))
      stiffness(3, 1) = stiffness(3, 1) - dot_product(along(c, u), heavy)
      damping(1:2, 1) = damping(1:2, 1) + along(2*turn(drift) - 2*omega*c, u)
      damping(3, 1) = damping(3, 1) + 2*turning
      do j = 1, body%n
         arm = along(body%c(:, j), u)
         stiffness(1:2, 1 + j) = stiffness(1:2, 1 + j) + alpha*turn(arm) - omega**2*arm
         stiffness(3, 1 + j) = stiffness(3, 1 + j) + dot_product(turn(arm), heavy) + 2*(body%d(j) + eta(j))*alpha &
            & + 2*omega*rate(j)
         stiffness(3 + j, 1) = stiffness(3 + j, 1) + dot_product(turn(arm), heavy)
         stiffness(3 + j, 1 + j) = stiffness(3 + j, 1 + j) - omega**2
         damping(1:2, 1 + j) = damping(1:2, 1 + j) + 2*omega*turn(arm)
         damping(3, 1 + j) = damping(3, 1 + j) + 2*omega*(body%d(j) + eta(j))
         damping(3 + j, 1) = damping(3 + j, 1) - 2*omega*(body%d(j) + eta(j))
         do k = 1, body%n
            stiffness(3, 1 + j) = stiffness(3, 1 + j) - body%skew(k, j)*eta_acceleration(k)
            stiffness(3 + k, 1 + j) = stiffness(3 + k, 1 + j) - body%skew(k, j)*alpha
            damping(3 + k, 1 + j) = damping(3 + k, 1 + j) - 2*omega*body%skew(k, j)
            damping(3 + k, 1) = damping(3 + k, 1) - 2*body%skew(k, j)*rate(j)
         end do
      end do
      if (body%spinning) call rotary_tangent(body, omega, eta, rate, alpha, stiffness, damping)
   end subroutine body_tangent

   !> What rotary inertia takes from the derivatives: the inertia does not grow with the rotations of the nodes.
   pure subroutine rotary_tangent(body, omega, eta, rate, alpha, stiffness, damping)
      type(reduced_type), intent(in) :: body
      real(wp), intent(in) :: omega, eta(:), rate(:), alpha
      real(wp), intent(inout) :: stiffness(:, :), damping(:, :)
      real(wp) :: turned
      integer :: j, k
      do j = 1, body%n
         turned = rotary_row(body, j, eta)
         stiffness(3, 1 + j) = stiffness(3, 1 + j) - 2*turned*alpha - 2*omega*rotary_row(body, j, rate)
         damping(3, 1) = damping(3, 1) - 2*rate(j)*turned
         damping(3, 1 + j) = damping(3, 1 + j) - 2*omega*turned
         damping(3 + j, 1) = damping(3 + j, 1) + 2*omega*turned
         do k = 1, body%n
            stiffness(3 + k, 1 + j) = stiffness(3 + k, 1 + j) + omega**2*body%rotary(k, j)
         end do
      end do
   end subroutine rotary_tangent

   !> Adds the velocity terms to the forces: minus what the rates alone contribute to M a.
   pure subroutine velocity_forces(body, u, omega, eta, rate, on_frame, on_eta)
      type(reduced_type), intent(in) :: body
      !> Unit vector of the frame (2)
      real(wp), intent(in) :: u(2)
      !> Angular velocity of the frame [rad/time]
      real(wp), intent(in) :: omega
      !> Coordinates and their rates (n)
      real(wp), contiguous, intent(in) :: eta(:), rate(:)
      !> Force and moment on the frame's origin (3), along the fixed axes
      real(wp), intent(inout) :: on_frame(3)
      !> Forces on the coordinates (n)
      real(wp), contiguous, intent(inout) :: on_eta(:)
      real(wp) :: c(2), drift(2), moment, turning
      integer :: k, j
      c = body%c0
      drift = 0.0_wp
      moment = 0.0_wp
      do k = 1, body%n
         c(1) = c(1) + body%c(1, k)*eta(k)
         c(2) = c(2) + body%c(2, k)*eta(k)
         drift(1) = drift(1) + body%c(1, k)*rate(k)
         drift(2) = drift(2) + body%c(2, k)*rate(k)
         moment = moment + (body%d(k) + eta(k))*rate(k)
         turning = 0.0_wp
         do j = 1, body%n
            turning = turning + body%skew(j, k)*rate(j)
         end do
         on_eta(k) = on_eta(k) + omega*(omega*(body%d(k) + eta(k)) - 2*turning)
      end do
      if (body%spinning) call rotary_forces(body, omega, eta, rate, moment, on_eta)
      on_frame(1:2) = on_frame(1:2) + along(omega**2*c - 2*omega*turn(drift), u)
      on_frame(3) = on_frame(3) - 2*omega*moment
   end subroutine velocity_forces

   !> What rotary inertia takes from the velocity terms.
   pure subroutine rotary_forces(body, omega, eta, rate, moment, on_eta)
      type(reduced_type), intent(in) :: body
      real(wp), intent(in) :: omega, eta(:), rate(:)
      !> (d + eta).eta', forces on the coordinates (n)
      real(wp), intent(inout) :: moment, on_eta(:)
      integer :: k
      do k = 1, body%n
         on_eta(k) = on_eta(k) - omega**2*rotary_row(body, k, eta)
         moment = moment - rate(k)*rotary_row(body, k, eta)
      end do
   end subroutine rotary_forces

   !> Adds the weight.
   pure subroutine gravity_forces(body, gravity, u, eta, on_frame, on_eta)
      type(reduced_type), intent(in) :: body
      !> Acceleration of gravity (2) [length/time^2]
      real(wp), intent(in) :: gravity(2)
      !> Unit vector of the frame (2)
      real(wp), intent(in) :: u(2)
      !> Coordinates (n)
      real(wp), intent(in) :: eta(:)
      !> Force and moment on the frame's origin (3), forces on the coordinates (n)
      real(wp), intent(inout) :: on_frame(3), on_eta(:)
      integer :: k
      on_frame(1:2) = on_frame(1:2) + body%mass*gravity
      on_frame(3) = on_frame(3) + cross(along(centre_moment(body, eta), u), gravity)
      do k = 1, body%n
         on_eta(k) = on_eta(k) + dot_product(along(body%c(:, k), u), gravity)
      end do
   end subroutine gravity_forces

   !> M a + velocity terms - weight, eq. (1.15): the residual of a body on which nothing else acts.
   pure subroutine inertia_forces(body, n, gravity, u, eta, omega, rate, acceleration, alpha, push_rate, motion)
      type(reduced_type), intent(in) :: body
      integer, intent(in) :: n
      !> Vector of the frame (2), deflection coordinates (n), angular velocity, rates (n)
      real(wp), intent(in) :: gravity(2), u(2), eta(n), omega, rate(n)
      !> r'' (2), alpha, eta'' (n)
      real(wp), intent(in) :: acceleration(2), alpha, push_rate(n)
      real(wp), intent(out) :: motion(3 + n)
      real(wp) :: c(2), drift(2), push(2), heavy(2), own(2), turning, inertia, square, h
      integer :: j, k
      c = body%c0
      drift = 0.0_wp
      push = 0.0_wp
      turning = 0.0_wp
      inertia = body%i0
      square = omega**2
      do k = 1, n
         c(1) = c(1) + body%c(1, k)*eta(k)
         c(2) = c(2) + body%c(2, k)*eta(k)
         drift(1) = drift(1) + body%c(1, k)*rate(k)
         drift(2) = drift(2) + body%c(2, k)*rate(k)
         push(1) = push(1) + body%c(1, k)*push_rate(k)
         push(2) = push(2) + body%c(2, k)*push_rate(k)
         turning = turning + (body%d(k) + eta(k))*rate(k)
         inertia = inertia + (2*body%d(k) + eta(k))*eta(k)
      end do
      if (body%spinning) then
         inertia = inertia - rotary_square(body, eta)
         do k = 1, n
            turning = turning - rate(k)*rotary_row(body, k, eta)
         end do
      end if
      heavy = acceleration - gravity
      own(1) = u(1)*heavy(1) + u(2)*heavy(2)
      own(2) = u(1)*heavy(2) - u(2)*heavy(1)
      push(1) = push(1) - alpha*c(2) - square*c(1) - 2*omega*drift(2)
      push(2) = push(2) + alpha*c(1) - square*c(2) + 2*omega*drift(1)
      motion(1) = body%mass*heavy(1) + push(1)*u(1) - push(2)*u(2)
      motion(2) = body%mass*heavy(2) + push(1)*u(2) + push(2)*u(1)
      motion(3) = c(1)*own(2) - c(2)*own(1) + inertia*alpha + 2*omega*turning
      do k = 1, n
         h = body%e(k)
         turning = 0.0_wp
         do j = 1, n
            h = h + body%skew(j, k)*eta(j)
            turning = turning + body%skew(j, k)*rate(j)
         end do
         motion(3) = motion(3) + h*push_rate(k)
         motion(3 + k) = body%c(1, k)*own(1) + body%c(2, k)*own(2) + h*alpha + push_rate(k) - square*(body%d(k) + eta(k)) &
            & + 2*omega*turning
         if (body%spinning) motion(3 + k) = motion(3 + k) + square*rotary_row(body, k, eta)
      end do
   end subroutine inertia_forces

   !> Kinetic energy.
   pure real(wp) function kinetic_energy(body, u, eta, velocity, omega, rate) result(energy)
      type(reduced_type), intent(in) :: body
      !> Unit vector of the frame (2), coordinates (n)
      real(wp), intent(in) :: u(2), eta(:)
      !> Velocity of the frame's origin (2), angular velocity, rates of the coordinates (n)
      real(wp), intent(in) :: velocity(2), omega, rate(:)
      real(wp) :: drift(2), h
      integer :: k, j
      drift = 0.0_wp
      energy = 0.5_wp*body%mass*dot_product(velocity, velocity) + 0.5_wp*body%i0*omega**2
      do k = 1, body%n
         h = body%e(k)
         do j = 1, body%n
            h = h - body%skew(k, j)*eta(j)
         end do
         drift = drift + body%c(:, k)*rate(k)
         energy = energy + 0.5_wp*rate(k)**2 + omega*h*rate(k) + 0.5_wp*omega**2*(2*body%d(k) + eta(k))*eta(k)
      end do
      if (body%spinning) energy = energy - 0.5_wp*omega**2*rotary_square(body, eta)
      energy = energy + dot_product(velocity, along(drift + omega*turn(centre_moment(body, eta)), u))
   end function kinetic_energy

   !> Potential of the weight, zero at the fixed origin.
   pure real(wp) function weight_potential(body, gravity, position, u, eta) result(energy)
      type(reduced_type), intent(in) :: body
      !> Acceleration of gravity (2), position of the frame's origin (2), its unit vector (2), coordinates (n)
      real(wp), intent(in) :: gravity(2), position(2), u(2), eta(:)
      energy = -dot_product(gravity, body%mass*position + along(centre_moment(body, eta), u))
   end function weight_potential

end module limber_multibody_body
