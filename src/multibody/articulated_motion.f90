!> Equations of motion of articulated trees. What `motion_residual` does for any scene, to round-off, but body by body in one pass,
!> without kinematics of markers in between; power; and what moves a state onto the pins. No allocation. Floor: multibody. Source:
!> doc/theory, eqs. (1.15), (4.13)-(4.15), (4.24)-(4.26).
module limber_multibody_articulated_motion
   use limber_base_kinds, only: wp
   use limber_beam_elastic_forces, only: elastic_force, geometric_power
   use limber_beam_reduced_body, only: add_damping, damping_power, reduced_type
   use limber_model_model, only: model_type
   use limber_multibody_articulated, only: articulated_type, most_order
   use limber_multibody_body, only: inertia_forces
   implicit none
   private
   public :: forest_residual, forest_settle, forest_times_mass, forest_power

contains

   !> Residual of the equations of motion (nw) and of the velocity equations of the pins (nc): that of `motion_residual`.
   subroutine forest_residual(forest, model, q, w, a, lambda, motion, rates)
      type(articulated_type), intent(inout) :: forest
      type(model_type), intent(in) :: model
      !> Coordinates (nq), rates, accelerations (nw), multipliers (nc)
      real(wp), intent(in) :: q(*), w(*), a(*), lambda(*)
      real(wp), intent(inout) :: motion(*), rates(*)
      real(wp) :: force(2), speed(2)
      integer :: k, c
      do k = 1, size(forest%places)
         associate (place => forest%places(k))
            c = place%carrier
            associate (at => place%q, to => place%w, reduced => model%bodies(place%model)%reduced)
               call inertia_forces(reduced, place%n, model%gravity, q(at + 2), q(at + 4), w(to + 2), w(to + 3), a(to), a(to + 2), &
                  & a(to + 3), motion(to))
               if (place%n > 0) call add_elastic(forest, reduced, q(at + 4:at + 3 + place%n), w(to + 3:to + 2 + place%n), &
                  & motion(to + 3:to + 2 + place%n))
               if (c < 0) cycle
               force = place%sign*lambda(place%row:place%row + 1)
               speed = 0.0_wp
               call add_pin(place%n, 1.0_wp, forest%pins(:, :, place%own), q(at + 2), q(at + 4), w(to), force, motion(to), speed)
               if (c > 0) then
                  associate (carrier => forest%places(c))
                     call add_pin(carrier%n, -1.0_wp, forest%pins(:, :, place%base), q(carrier%q + 2), q(carrier%q + 4), &
                        & w(carrier%w), force, motion(carrier%w), speed)
                  end associate
               end if
               rates(place%row:place%row + 1) = place%sign*speed
            end associate
         end associate
      end do
   end subroutine forest_residual

   !> Adds the elastic force and the damping of a body.
   subroutine add_elastic(forest, body, eta, rate, motion)
      type(articulated_type), intent(inout) :: forest
      type(reduced_type), intent(in) :: body
      real(wp), contiguous, intent(in) :: eta(:), rate(:)
      real(wp), contiguous, intent(inout) :: motion(:)
      call elastic_force(body, eta, motion, forest%pairs)
      if (body%damped) call add_damping(body, 1.0_wp, rate, motion)
   end subroutine add_elastic

   !> Adds a force at a pin to the forces of its body, and the velocity of the pin to that of a gap.
   pure subroutine add_pin(n, sign, pin, u, eta, w, force, motion, speed)
      integer, intent(in) :: n
      !> 1 on the body that hangs, -1 on its carrier
      real(wp), intent(in) :: sign
      !> Place and shapes of the pin; vector of the frame, coordinates, rates of the body, force along the fixed axes
      real(wp), intent(in) :: pin(2, 0:n), u(2), eta(n), w(3 + n), force(2)
      real(wp), intent(inout) :: motion(3 + n), speed(2)
      real(wp) :: p(2), drift(2), own(2)
      integer :: k
      own(1) = sign*(u(1)*force(1) + u(2)*force(2))
      own(2) = sign*(u(1)*force(2) - u(2)*force(1))
      p = pin(:, 0)
      drift = 0.0_wp
      do k = 1, n
         p(1) = p(1) + pin(1, k)*eta(k)
         p(2) = p(2) + pin(2, k)*eta(k)
         drift(1) = drift(1) + pin(1, k)*w(3 + k)
         drift(2) = drift(2) + pin(2, k)*w(3 + k)
         motion(3 + k) = motion(3 + k) + pin(1, k)*own(1) + pin(2, k)*own(2)
      end do
      motion(1) = motion(1) + sign*force(1)
      motion(2) = motion(2) + sign*force(2)
      motion(3) = motion(3) + p(1)*own(2) - p(2)*own(1)
      drift(1) = drift(1) - w(3)*p(2)
      drift(2) = drift(2) + w(3)*p(1)
      speed(1) = speed(1) + sign*(w(1) + drift(1)*u(1) - drift(2)*u(2))
      speed(2) = speed(2) + sign*(w(2) + drift(1)*u(2) + drift(2)*u(1))
   end subroutine add_pin

   !> Moves a state that is near the pins onto them, at position and velocity level. No pin closes a loop, so that the place and the
   !> velocity of each frame follow from its carrier: rotations, deflections and their rates stay as they are. The momentum of a
   !> tree in flight does not.
   pure subroutine forest_settle(forest, q, v)
      type(articulated_type), intent(in) :: forest
      !> Coordinates and velocities (nq)
      real(wp), intent(inout) :: q(*), v(*)
      real(wp) :: place(2), speed(2), arm(2), sway(2), omega
      integer :: k, c
      do k = 1, size(forest%places)
         associate (at => forest%places(k)%q, n => forest%places(k)%n, own => forest%places(k)%own, base => forest%places(k)%base)
            q(at + 2:at + 3) = q(at + 2:at + 3)/sqrt(q(at + 2)**2 + q(at + 3)**2)
            omega = q(at + 2)*v(at + 3) - q(at + 3)*v(at + 2)
            v(at + 2) = -omega*q(at + 3)
            v(at + 3) = omega*q(at + 2)
            c = forest%places(k)%carrier
            if (c < 0) cycle
            place = forest%pins(:, 0, base)
            speed = 0.0_wp
            if (c > 0) call follow_pin(forest%places(c)%n, forest%pins(:, :, base), q(forest%places(c)%q), v(forest%places(c)%q), &
               & place, speed)
            q(at:at + 1) = 0.0_wp
            v(at:at + 1) = 0.0_wp
            call follow_pin(n, forest%pins(:, :, own), q(at), v(at), arm, sway)
            q(at:at + 1) = place - arm
            v(at:at + 1) = speed - sway
         end associate
      end do
   end subroutine forest_settle

   !> Place and velocity of a pin.
   pure subroutine follow_pin(n, pin, q, v, place, speed)
      integer, intent(in) :: n
      real(wp), intent(in) :: pin(2, 0:n), q(4 + n), v(4 + n)
      real(wp), intent(out) :: place(2), speed(2)
      real(wp) :: p(2), drift(2), omega
      integer :: k
      p = pin(:, 0)
      drift = 0.0_wp
      do k = 1, n
         p(1) = p(1) + pin(1, k)*q(4 + k)
         p(2) = p(2) + pin(2, k)*q(4 + k)
         drift(1) = drift(1) + pin(1, k)*v(4 + k)
         drift(2) = drift(2) + pin(2, k)*v(4 + k)
      end do
      place(1) = q(1) + p(1)*q(3) - p(2)*q(4)
      place(2) = q(2) + p(1)*q(4) + p(2)*q(3)
      omega = q(3)*v(4) - q(4)*v(3)
      drift(1) = drift(1) - omega*p(2)
      drift(2) = drift(2) + omega*p(1)
      speed(1) = v(1) + drift(1)*q(3) - drift(2)*q(4)
      speed(2) = v(2) + drift(1)*q(4) + drift(2)*q(3)
   end subroutine follow_pin

   !> product = product + factor M vector, in the layout of the rates, at q; the blocks of the factors are not touched.
   subroutine forest_times_mass(forest, model, q, factor, vector, product)
      type(articulated_type), intent(in) :: forest
      type(model_type), intent(in) :: model
      real(wp), intent(in) :: q(*), vector(*)
      real(wp), intent(in) :: factor
      real(wp), intent(inout) :: product(*)
      !> At rest and without weight the residual of a body is M a
      real(wp), parameter :: none(2) = 0.0_wp
      real(wp) :: force(most_order), rest(most_order)
      integer :: k, j
      rest = 0.0_wp
      do k = 1, size(forest%places)
         associate (place => forest%places(k), to => forest%places(k)%w)
            call inertia_forces(model%bodies(place%model)%reduced, place%n, none, q(place%q + 2), q(place%q + 4), 0.0_wp, rest, &
               & vector(to), vector(to + 2), vector(to + 3), force)
            do j = 1, 3 + place%n
               product(to + j - 1) = product(to + j - 1) + factor*force(j)
            end do
         end associate
      end do
   end subroutine forest_times_mass

   !> Power put in: less what damping and the geometric force of the model k_g take.
   real(wp) function forest_power(forest, model, q, w) result(power)
      type(articulated_type), intent(inout) :: forest
      type(model_type), intent(in) :: model
      !> Coordinates (nq) and rates (nw)
      real(wp), intent(in) :: q(*), w(*)
      real(wp) :: taken
      integer :: k
      power = 0.0_wp
      do k = 1, size(forest%places)
         associate (place => forest%places(k), reduced => model%bodies(forest%places(k)%model)%reduced)
            if (place%n == 0) cycle
            call geometric_power(reduced, q(place%q + 4:place%q + 3 + place%n), w(place%w + 3:place%w + 2 + place%n), &
               & forest%pairs, taken)
            power = power - taken
            if (reduced%damped) power = power - damping_power(reduced, w(place%w + 3:place%w + 2 + place%n))
         end associate
      end do
   end function forest_power

end module limber_multibody_articulated_motion
