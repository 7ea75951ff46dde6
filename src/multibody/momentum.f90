!> Momenta of one body in the axes of its frame. There the mass matrix is a polynomial of degree two in eta alone.
!>
!> Plain kernels on arrays; no allocation. Floor: multibody. Source: doc/theory, eqs. (1.11), (5.22), (5.23).
module limber_multibody_momentum
   use limber_base_kinds, only: wp
   use limber_beam_reduced_body, only: reduced_type, rotary_row, rotary_square
   use limber_multibody_plane_vectors, only: turn, along, into_frame, cross
   use limber_multibody_body, only: centre_moment
   use limber_multibody_beam_axis, only: centreline_type, new_centreline
   use limber_multibody_system, only: system_type
   implicit none
   private
   public :: body_momentum, balance, velocity_slope, momentum_tangent, balance_tangent, pull_tangent, total_momentum

contains

   !> Momenta.
   pure subroutine body_momentum(body, eta, w, p)
      type(reduced_type), intent(in) :: body
      !> Coordinates (n); rates in the axes of the frame (3 + n)
      real(wp), intent(in) :: eta(:), w(:)
      !> Linear (2) and angular momentum about the origin in the same axes, and those of the coordinates (3 + n)
      real(wp), intent(inout) :: p(:)
      real(wp) :: c(2), drift(2), inertia, h
      integer :: j, k
      c = turn(centre_moment(body, eta))
      drift = 0.0_wp
      inertia = body%i0
      p(3) = c(1)*w(1) + c(2)*w(2)
      do k = 1, body%n
         h = body%e(k)
         do j = 1, body%n
            h = h + body%skew(j, k)*eta(j)
         end do
         drift = drift + body%c(:, k)*w(3 + k)
         inertia = inertia + (2*body%d(k) + eta(k))*eta(k)
         p(3) = p(3) + h*w(3 + k)
         p(3 + k) = body%c(1, k)*w(1) + body%c(2, k)*w(2) + h*w(3) + w(3 + k)
      end do
      if (body%spinning) inertia = inertia - rotary_square(body, eta)
      p(1:2) = body%mass*w(1:2) + w(3)*c + drift
      p(3) = p(3) + inertia*w(3)
   end subroutine body_momentum

   !> Change of the momenta of a body over a step less its weight and the pull of its growing inertia, eq. (5.23): the residual of a
   !> body on which nothing else acts.
   pure subroutine balance(body, n, h, gravity, u0, u1, eta, y, b, new_b, p, new_p, motion)
      type(reduced_type), intent(in) :: body
      integer, intent(in) :: n
      !> Step; frames' vectors at both ends (2), coordinates at the start (n)
      real(wp), intent(in) :: h, gravity(2), u0(2), u1(2), eta(n)
      !> Increments, rates and momenta at both ends (3 + n)
      real(wp), intent(in) :: y(3 + n), b(3 + n), new_b(3 + n), p(3 + n), new_p(3 + n)
      real(wp), intent(inout) :: motion(3 + n)
      real(wp) :: before(2), after(2), c0(2), c1(2), arm(2), stretch(2), own(2), speed(2), spin, part, inverse
      integer :: j, k
      inverse = 1/h
      before = along(p(1:2), u0)
      after = along(new_p(1:2), u1)
      c0 = body%c0
      do k = 1, n
         c0 = c0 + body%c(:, k)*eta(k)
      end do
      c1 = c0
      do k = 1, n
         c1 = c1 + body%c(:, k)*y(3 + k)
      end do
      arm = 0.5_wp*(along(c0, u0) + along(c1, u1))
      stretch = u0 + 0.5_wp*y(3)*turn(u0)
      motion(1:2) = (after - before)*inverse - body%mass*gravity
      motion(3) = (new_p(3) - p(3) + 0.5_wp*cross(y(1:2), before + after))*inverse - cross(arm, gravity)
      own = into_frame(gravity, stretch)
      speed = b(3)*new_b(1:2) + new_b(3)*b(1:2)
      spin = b(3)*new_b(3)
      do k = 1, n
         part = body%c(1, k)*speed(2) - body%c(2, k)*speed(1) + 2*(body%d(k) + eta(k) + 0.5_wp*y(3 + k))*spin
         do j = 1, n
            part = part - body%skew(j, k)*(new_b(3)*b(3 + j) + b(3)*new_b(3 + j))
         end do
         if (body%spinning) part = part - (2*rotary_row(body, k, eta) + rotary_row(body, k, y(4:)))*spin
         motion(3 + k) = (new_p(3 + k) - p(3 + k))*inverse - 0.5_wp*part - body%c(1, k)*own(1) - body%c(2, k)*own(2)
      end do
   end subroutine balance

   !> Derivative of the velocity at the end of a step, in the axes of the frame, by dr and alpha (2,3).
   pure function velocity_slope(h, u0, y) result(slope)
      !> Length of the step, vector of the frame at its start (2), increments of the frame (3)
      real(wp), intent(in) :: h, u0(2), y(3)
      real(wp) :: slope(2, 3), back(2)
      back = [u0(1), -u0(2)]
      slope(:, 1) = (back - 0.5_wp*y(3)*turn(back))*(2/h)
      slope(:, 2) = turn(slope(:, 1))
      slope(:, 3) = -turn(into_frame(y(1:2), u0))/h
   end function velocity_slope

   !> Derivative of the momenta at the end of a step by its increments y = [dr; alpha; deta].
   pure subroutine momentum_tangent(body, eta, w, frame, coupling, slope, h, tangent)
      type(reduced_type), intent(in) :: body
      !> Coordinates (n) and rates (3 + n) at the end
      real(wp), intent(in) :: eta(:), w(:)
      !> Mass matrix there, in the axes of the frame, as `body_mass` gives it
      real(wp), intent(in) :: frame(3, 3), coupling(:, :)
      !> Derivative of the velocity in the axes of the frame by dr and alpha (2,3); length of the step
      real(wp), intent(in) :: slope(2, 3), h
      !> (3 + n, 3 + n)
      real(wp), intent(inout) :: tangent(:, :)
      integer :: j, k
      do j = 1, 3
         tangent(1:2, j) = body%mass*slope(:, j)
         tangent(3, j) = frame(3, 1)*slope(1, j) + frame(3, 2)*slope(2, j)
         do k = 1, body%n
            tangent(3 + k, j) = coupling(k, 1)*slope(1, j) + coupling(k, 2)*slope(2, j)
         end do
      end do
      tangent(1:3, 3) = tangent(1:3, 3) + frame(:, 3)*(2/h)
      do k = 1, body%n
         tangent(3 + k, 3) = tangent(3 + k, 3) + coupling(k, 3)*(2/h)
         tangent(1:2, 3 + k) = body%c(:, k)*(2/h) + w(3)*turn(body%c(:, k))
         tangent(3, 3 + k) = coupling(k, 3)*(2/h) + cross(body%c(:, k), w(1:2)) + 2*(body%d(k) + eta(k))*w(3)
         do j = 1, body%n
            tangent(3, 3 + k) = tangent(3, 3 + k) - body%skew(j, k)*w(3 + j)
            tangent(3 + j, 3 + k) = -body%skew(j, k)*w(3)
         end do
         if (body%spinning) tangent(3, 3 + k) = tangent(3, 3 + k) - 2*rotary_row(body, k, eta)*w(3)
         tangent(3 + k, 3 + k) = tangent(3 + k, 3 + k) + 2/h
      end do
   end subroutine momentum_tangent

   !> Makes derivatives of the momenta at the end, in the axes of the frame, to those of their change in `balance`.
   pure subroutine balance_tangent(h, u0, u1, y, p, new_p, tangent)
      !> Length of the step; vectors of the frame (2), increments (3 + n), momenta at both ends (2)
      real(wp), intent(in) :: h, u0(2), u1(2), y(:), p(2), new_p(2)
      !> (3 + n, 3 + n)
      real(wp), intent(inout) :: tangent(:, :)
      real(wp) :: after(2), mean(2), change(2), shrink
      integer :: j, m
      m = size(y)
      shrink = 1/(1 + 0.25_wp*y(3)**2)
      after = along(new_p, u1)
      mean = 0.5_wp*(after + along(p, u0))
      do j = 1, m
         change = along(tangent(1:2, j), u1)
         if (j == 3) change = change + shrink*turn(after)
         tangent(3, j) = tangent(3, j) + 0.5_wp*cross(y(1:2), change)
         tangent(1:2, j) = change
      end do
      tangent(3, 1) = tangent(3, 1) + mean(2)
      tangent(3, 2) = tangent(3, 2) - mean(1)
      tangent(:m, :m) = tangent(:m, :m)/h
   end subroutine balance_tangent

   !> Takes the derivative of the pull of the growing inertia, w0.(dM/deta) w1 / 2 at the mean of the coordinates, by the increments
   !> from a matrix.
   pure subroutine pull_tangent(body, eta, w0, w1, slope, h, tangent)
      type(reduced_type), intent(in) :: body
      !> Mean coordinates (n), rates at both ends (3 + n)
      real(wp), intent(in) :: eta(:), w0(:), w1(:)
      !> As above
      real(wp), intent(in) :: slope(2, 3), h
      !> (3 + n, 3 + n); rows of the coordinates
      real(wp), intent(inout) :: tangent(:, :)
      real(wp) :: part
      integer :: j, k
      do k = 1, body%n
         do j = 1, 3
            tangent(3 + k, j) = tangent(3 + k, j) - 0.5_wp*w0(3)*cross(body%c(:, k), slope(:, j))
         end do
         part = cross(body%c(:, k), w0(1:2)) + 2*(body%d(k) + eta(k))*w0(3)
         do j = 1, body%n
            part = part - body%skew(j, k)*w0(3 + j)
            tangent(3 + k, 3 + j) = tangent(3 + k, 3 + j) + body%skew(j, k)*w0(3)/h
         end do
         if (body%spinning) then
            part = part - 2*rotary_row(body, k, eta)*w0(3)
            do j = 1, body%n
               tangent(3 + k, 3 + j) = tangent(3 + k, 3 + j) + 0.5_wp*w0(3)*w1(3)*body%rotary(j, k)
            end do
         end if
         tangent(3 + k, 3) = tangent(3 + k, 3) - part/h
         tangent(3 + k, 3 + k) = tangent(3 + k, 3 + k) - 0.5_wp*w0(3)*w1(3)
      end do
   end subroutine pull_tangent

   !> Momentum of all bodies along the fixed axes and about the fixed origin.
   pure subroutine total_momentum(system, q, v, momentum)
      type(system_type), intent(in) :: system
      !> Coordinates and velocities (nq)
      real(wp), intent(in) :: q(:), v(:)
      !> Along x and y [mass length/time], and about the origin [mass length^2/time]
      real(wp), intent(out) :: momentum(3)
      real(wp) :: rates(3 + maxval(system%layout%n)), p(3 + maxval(system%layout%n)), linear(2)
      type(centreline_type) :: line
      integer :: i, first, n
      momentum = 0.0_wp
      do i = 1, size(system%layout%q)
         if (system%layout%carries(i)) cycle
         first = system%layout%q(i)
         n = system%layout%n(i)
         linear = system%model%bodies(i)%reduced%mass*v(first:first + 1)
         if (system%layout%framed(i)) then
            associate (u => q(first + 2:first + 3))
               rates(1:2) = [dot_product(u, v(first:first + 1)), cross(u, v(first:first + 1))]
               rates(3) = cross(u, v(first + 2:first + 3))
               rates(4:3 + n) = v(first + 4:first + 3 + n)
               if (system%model%bodies(i)%reduced%is_exact) then
                  call new_centreline(system%model%bodies(i)%reduced%exact, line)
                  call line%place(q(first + 4:first + 3 + n))
                  call line%move(v(first + 4:first + 3 + n))
                  p(:3) = line%momenta(rates(1:2), rates(3), rates(4:3 + n))
               else
                  call body_momentum(system%model%bodies(i)%reduced, q(first + 4:first + 3 + n), rates(:3 + n), p(:3 + n))
               end if
               linear = p(1)*u + p(2)*turn(u)
               momentum(3) = momentum(3) + p(3)
            end associate
         end if
         momentum(1:2) = momentum(1:2) + linear
         momentum(3) = momentum(3) + cross(q(first:first + 1), linear)
      end do
   end subroutine total_momentum

end module limber_multibody_momentum
