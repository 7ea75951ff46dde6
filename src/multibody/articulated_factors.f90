!> Factors of the tangent of articulated trees. What `linearise_motion` and sparse factors do for any scene, body by body by
!> elimination along the trees. No allocation. Floor: multibody. Source: doc/theory, eqs. (1.10), (4.16), (4.18), (4.24)-(4.26).
module limber_multibody_articulated_factors
   use limber_base_kinds, only: wp
   use limber_beam_elastic_forces, only: elastic_tangent
   use limber_beam_reduced_body, only: reduced_type
   use limber_model_model, only: model_type
   use limber_multibody_articulated, only: articulated_type, eliminate, hand_on
   implicit none
   private
   public :: forest_factor

contains

   !> Factors of mass M + D + stiffness (K, and the drift of the rows): the matrix (41) at a state.
   subroutine forest_factor(forest, model, q, w, a, lambda, mass, stiffness, singular)
      type(articulated_type), intent(inout) :: forest
      type(model_type), intent(in) :: model
      !> As in `forest_residual`
      real(wp), intent(in) :: q(*), w(*), a(*), lambda(*)
      !> Factors of the mass and of the stiffness
      real(wp), intent(in) :: mass, stiffness
      logical, intent(out) :: singular
      real(wp) :: force(2)
      integer :: k, c, order
      order = forest%order
      singular = .false.
      forest%started = .false.
      do k = size(forest%places), 1, -1
         associate (place => forest%places(k))
            c = place%carrier
            if (.not. forest%started(k)) call start_newton(forest, model, k, q, w, a, mass, stiffness)
            if (c >= 0) then
               force = place%sign*lambda(place%row:place%row + 1)
               call pin_rows(order, place%n, forest%pins(:, :, place%own), q(place%q + 2), q(place%q + 4), &
                  & forest%reaction(:, :, k), forest%rows(:, :, k))
               call pin_derivatives(order, place%n, stiffness, forest%pins(:, :, place%own), q(place%q + 2), q(place%q + 4), &
                  & w(place%w), force, forest%rows(:, :, k), forest%block(:, :, k))
            end if
            call eliminate(forest, k, singular)
            if (singular) return
            if (c <= 0) cycle
            associate (carrier => forest%places(c))
               if (.not. forest%started(c)) call start_newton(forest, model, c, q, w, a, mass, stiffness)
               call pin_rows(order, carrier%n, forest%pins(:, :, place%base), q(carrier%q + 2), q(carrier%q + 4), &
                  & forest%carried(:, :, k), forest%carrying(:, :, k))
               call pin_derivatives(order, carrier%n, stiffness, forest%pins(:, :, place%base), q(carrier%q + 2), &
                  & q(carrier%q + 4), w(carrier%w), -force, forest%carrying(:, :, k), forest%block(:, :, c))
               call hand_on(forest, k)
            end associate
         end associate
      end do
   end subroutine forest_factor

   !> The block of a body: mass M + D + stiffness K.
   subroutine start_newton(forest, model, k, q, w, a, mass, stiffness)
      type(articulated_type), intent(inout) :: forest
      type(model_type), intent(in) :: model
      integer, intent(in) :: k
      real(wp), intent(in) :: q(*), w(*), a(*)
      real(wp), intent(in) :: mass, stiffness
      integer :: i, n
      associate (place => forest%places(k), reduced => model%bodies(forest%places(k)%model)%reduced)
         n = place%n
         forest%started(k) = .true.
         call inertia_tangent(forest%order, n, reduced, mass, stiffness, model%gravity, q(place%q + 2), q(place%q + 4), &
            & w(place%w + 2), w(place%w + 3), a(place%w), forest%block(:, :, k))
         if (n == 0) return
         forest%tangent(:n, :n) = 0.0_wp
         call elastic_tangent(reduced, q(place%q + 4:place%q + 3 + n), forest%tangent(:n, :n), forest%pairs)
         forest%block(4:3 + n, 4:3 + n, k) = forest%block(4:3 + n, 4:3 + n, k) + stiffness*forest%tangent(:n, :n)
         if (.not. reduced%damped) return
         do i = 1, n
            forest%block(4:3 + n, 3 + i, k) = forest%block(4:3 + n, 3 + i, k) + reduced%damping(:, i)
         end do
      end associate
   end subroutine start_newton

   !> mass M + D + stiffness K of the inertia forces and the weight, eqs. (1.10), (4.16).
   pure subroutine inertia_tangent(order, n, body, mass, stiffness, gravity, u, eta, omega, rate, a, block)
      integer, intent(in) :: order, n
      type(reduced_type), intent(in) :: body
      real(wp), intent(in) :: mass, stiffness, gravity(2)
      !> As in `inertia_forces`; accelerations (3 + n)
      real(wp), intent(in) :: u(2), eta(n), omega, rate(n), a(3 + n)
      real(wp), intent(out) :: block(order, 3 + n)
      real(wp) :: c(2), drift(2), push(2), own(2), arm(2), turning, inertia, square, h, spin, sway, along_r, across_r, moment
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
         push(1) = push(1) + body%c(1, k)*a(3 + k)
         push(2) = push(2) + body%c(2, k)*a(3 + k)
         turning = turning + (body%d(k) + eta(k))*rate(k)
         inertia = inertia + (2*body%d(k) + eta(k))*eta(k)
      end do
      own(1) = u(1)*(a(1) - gravity(1)) + u(2)*(a(2) - gravity(2))
      own(2) = u(1)*(a(2) - gravity(2)) - u(2)*(a(1) - gravity(1))
      push(1) = push(1) - a(3)*c(2) - square*c(1) - 2*omega*drift(2)
      push(2) = push(2) + a(3)*c(1) - square*c(2) + 2*omega*drift(1)
      ! Columns of r, and that of the rotation; in the axes of the frame first
      block(1, 1) = mass*body%mass
      block(2, 1) = 0.0_wp
      block(1, 2) = 0.0_wp
      block(2, 2) = mass*body%mass
      block(3, 1) = mass*(-c(1)*u(2) - c(2)*u(1))
      block(3, 2) = mass*(c(1)*u(1) - c(2)*u(2))
      arm(1) = -mass*c(2) - stiffness*push(2) - 2*drift(2) - 2*omega*c(1)
      arm(2) = mass*c(1) + stiffness*push(1) + 2*drift(1) - 2*omega*c(2)
      block(1, 3) = arm(1)*u(1) - arm(2)*u(2)
      block(2, 3) = arm(1)*u(2) + arm(2)*u(1)
      block(3, 3) = mass*inertia + 2*turning - stiffness*(c(1)*own(1) + c(2)*own(2))
      ! Of what stands along a shape, and across it: J C_j
      along_r = mass - stiffness*square
      across_r = stiffness*a(3) + 2*omega
      do j = 1, n
         h = body%e(j)
         spin = 0.0_wp
         sway = 0.0_wp
         do k = 1, n
            h = h + body%skew(k, j)*eta(k)
            spin = spin + body%skew(k, j)*rate(k)
            sway = sway + body%skew(k, j)*a(3 + k)
            block(3 + k, 3 + j) = -body%skew(k, j)*across_r
         end do
         block(3 + j, 3 + j) = block(3 + j, 3 + j) + along_r
         arm(1) = along_r*body%c(1, j) - across_r*body%c(2, j)
         arm(2) = along_r*body%c(2, j) + across_r*body%c(1, j)
         block(1, 3 + j) = arm(1)*u(1) - arm(2)*u(2)
         block(2, 3 + j) = arm(1)*u(2) + arm(2)*u(1)
         moment = stiffness*(body%c(1, j)*own(2) - body%c(2, j)*own(1))
         block(3, 3 + j) = mass*h + moment + 2*(body%d(j) + eta(j))*(stiffness*a(3) + omega) + stiffness*(2*omega*rate(j) - sway)
         block(3 + j, 1) = mass*(body%c(1, j)*u(1) - body%c(2, j)*u(2))
         block(3 + j, 2) = mass*(body%c(1, j)*u(2) + body%c(2, j)*u(1))
         block(3 + j, 3) = mass*h + moment - 2*omega*(body%d(j) + eta(j)) + 2*spin
      end do
   end subroutine inertia_tangent

   !> Rows of a pin on a body, transposed: derivatives of its place by (r, rotation, eta), twice.
   pure subroutine pin_rows(order, n, pin, u, eta, rows, again)
      integer, intent(in) :: order, n
      real(wp), intent(in) :: pin(2, 0:n), u(2), eta(n)
      real(wp), intent(inout) :: rows(order, 2), again(order, 2)
      real(wp) :: p(2)
      integer :: k
      p = pin(:, 0)
      do k = 1, n
         p(1) = p(1) + pin(1, k)*eta(k)
         p(2) = p(2) + pin(2, k)*eta(k)
         rows(3 + k, 1) = pin(1, k)*u(1) - pin(2, k)*u(2)
         rows(3 + k, 2) = pin(1, k)*u(2) + pin(2, k)*u(1)
      end do
      rows(1, 1) = 1.0_wp
      rows(2, 1) = 0.0_wp
      rows(1, 2) = 0.0_wp
      rows(2, 2) = 1.0_wp
      rows(3, 1) = -p(1)*u(2) - p(2)*u(1)
      rows(3, 2) = p(1)*u(1) - p(2)*u(2)
      do k = 1, 3 + n
         again(k, 1) = rows(k, 1)
         again(k, 2) = rows(k, 2)
      end do
   end subroutine pin_rows

   !> Adds the drift of the rows of a pin to them, and the derivatives of its force to the block of the body.
   pure subroutine pin_derivatives(order, n, stiffness, pin, u, eta, w, force, rows, block)
      integer, intent(in) :: order, n
      real(wp), intent(in) :: stiffness, pin(2, 0:n), u(2), eta(n), w(3 + n), force(2)
      real(wp), intent(inout) :: rows(order, 2), block(order, 3 + n)
      real(wp) :: p(2), drift(2), own(2), part, turned
      integer :: k
      own(1) = stiffness*(u(1)*force(1) + u(2)*force(2))
      own(2) = stiffness*(u(1)*force(2) - u(2)*force(1))
      p = pin(:, 0)
      drift = 0.0_wp
      turned = stiffness*w(3)
      do k = 1, n
         p(1) = p(1) + pin(1, k)*eta(k)
         p(2) = p(2) + pin(2, k)*eta(k)
         drift(1) = drift(1) + pin(1, k)*w(3 + k)
         drift(2) = drift(2) + pin(2, k)*w(3 + k)
         part = pin(1, k)*own(2) - pin(2, k)*own(1)
         block(3, 3 + k) = block(3, 3 + k) + part
         block(3 + k, 3) = block(3 + k, 3) + part
         rows(3 + k, 1) = rows(3 + k, 1) - turned*(pin(1, k)*u(2) + pin(2, k)*u(1))
         rows(3 + k, 2) = rows(3 + k, 2) + turned*(pin(1, k)*u(1) - pin(2, k)*u(2))
      end do
      block(3, 3) = block(3, 3) - p(1)*own(1) - p(2)*own(2)
      drift(1) = stiffness*drift(1) - turned*p(2)
      drift(2) = stiffness*drift(2) + turned*p(1)
      rows(3, 1) = rows(3, 1) - drift(1)*u(2) - drift(2)*u(1)
      rows(3, 2) = rows(3, 2) + drift(1)*u(1) - drift(2)*u(2)
   end subroutine pin_derivatives

end module limber_multibody_articulated_factors
