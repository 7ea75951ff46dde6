!> The same for articulated trees. What `limber_multibody_discrete_motion` does for any scene, to round-off, body by body in one
!> pass, with the solution by elimination along the trees. No allocation. Floor: multibody. Source: doc/theory, eqs. (4.24)-(4.26),
!> (5.21)-(5.27), (5.29).
module limber_multibody_articulated_step
   use limber_base_kinds, only: wp
   use limber_beam_elastic_forces, only: elastic_force, elastic_tangent
   use limber_beam_reduced_body, only: add_damping, reduced_type
   use limber_model_model, only: model_type
   use limber_multibody_plane_vectors, only: turn, along, cross
   use limber_multibody_body, only: body_mass, centre_moment
   use limber_multibody_articulated, only: articulated_type, most_order, eliminate, hand_on
   use limber_multibody_layout, only: layout_type
   use limber_multibody_momentum, only: balance, balance_tangent, body_momentum, momentum_tangent, pull_tangent, velocity_slope
   use limber_multibody_discrete_step, only: discrete_step_type, gauss, find_end
   implicit none
   private
   public :: begin_forest_step, forest_step_residual, forest_step_factor, forest_step_mass

contains

   !> The start of a step at (t, q), rates b: `begin_step`.
   subroutine begin_forest_step(forest, model, step, t, h, final, q, b)
      type(articulated_type), intent(in) :: forest
      type(model_type), intent(in) :: model
      type(discrete_step_type), intent(inout) :: step
      !> Time, length, time at the end; coordinates (nq), rates in the axes of the frames (nw)
      real(wp), intent(in) :: t, h, final, q(:), b(:)
      integer :: k
      step%t = t
      step%h = h
      step%final = final
      step%q = q
      step%b = b
      do k = 1, size(forest%places)
         associate (place => forest%places(k))
            call body_momentum(model%bodies(place%model)%reduced, q(place%q + 4:place%q + 3 + place%n), &
               & b(place%w:place%w + 2 + place%n), step%p(place%w:place%w + 2 + place%n))
         end associate
      end do
   end subroutine begin_forest_step

   !> Residuals of the equations of motion and of the pins at the end; leaves the end in the step: `step_residual`.
   subroutine forest_step_residual(forest, model, layout, step, y, lambda, motion, phi)
      type(articulated_type), intent(inout) :: forest
      type(model_type), intent(in) :: model
      type(layout_type), intent(in) :: layout
      type(discrete_step_type), intent(inout) :: step
      !> Increments (nw), multipliers (nc)
      real(wp), contiguous, intent(in) :: y(:), lambda(:)
      !> (nw), (nc)
      real(wp), contiguous, intent(inout) :: motion(:), phi(:)
      real(wp) :: force(2), gap(2)
      integer :: k, c
      call find_end(layout, step, y)
      do k = 1, size(forest%places)
         associate (place => forest%places(k), reduced => model%bodies(forest%places(k)%model)%reduced)
            c = place%carrier
            associate (at => place%w, last => place%w + 2 + place%n, first => place%q + 4)
               call body_momentum(reduced, step%new_q(first:first + place%n - 1), step%new_b(at:last), step%new_p(at:last))
               call balance(reduced, place%n, step%h, model%gravity, step%q(first - 2:first - 1), step%new_q(first - 2:first - 1), &
                  & step%q(first:first + place%n - 1), y(at:last), step%b(at:last), step%new_b(at:last), step%p(at:last), &
                  & step%new_p(at:last), motion(at:last))
               if (place%n > 0) call add_mean_elastic(forest, reduced, step%h, step%q(first:first + place%n - 1), y(at + 3:last), &
                  & motion(at + 3:last))
            end associate
            if (c < 0) cycle
            force = place%sign*lambda(place%row:place%row + 1)
            gap = 0.0_wp
            call add_pin(place%n, 1.0_wp, forest%pins(:, :, place%own), step%q(place%q:place%q + 3 + place%n), &
               & step%new_q(place%q:place%q + 3 + place%n), y(place%w + 2), force, motion(place%w:place%w + 2 + place%n), gap)
            if (c > 0) then
               associate (carrier => forest%places(c))
                  call add_pin(carrier%n, -1.0_wp, forest%pins(:, :, place%base), step%q(carrier%q:carrier%q + 3 + carrier%n), &
                     & step%new_q(carrier%q:carrier%q + 3 + carrier%n), y(carrier%w + 2), force, &
                     & motion(carrier%w:carrier%w + 2 + carrier%n), gap)
               end associate
            else
               gap = gap - forest%pins(:, 0, place%base)
            end if
            phi(place%row:place%row + 1) = place%sign*gap
         end associate
      end do
   end subroutine forest_step_residual

   !> Adds the mean of the elastic force over the step, eq. (5.26), and the damping.
   subroutine add_mean_elastic(forest, body, h, eta, change, motion)
      type(articulated_type), intent(inout) :: forest
      type(reduced_type), intent(in) :: body
      real(wp), intent(in) :: h, eta(:), change(:)
      real(wp), intent(inout) :: motion(:)
      real(wp) :: between(most_order), force(most_order)
      integer :: n, k, point
      n = body%n
      force(:n) = 0.0_wp
      do point = 1, size(gauss)
         do k = 1, n
            between(k) = eta(k) + gauss(point)*change(k)
         end do
         call elastic_force(body, between(:n), force(:n), forest%pairs)
      end do
      do k = 1, n
         motion(k) = motion(k) + force(k)/size(gauss)
      end do
      if (.not. body%damped) return
      call add_damping(body, 1/h, change, motion)
   end subroutine add_mean_elastic

   !> Adds the force at a pin over the step to a body, eq. (5.25), and the place of the pin at the end to a gap.
   pure subroutine add_pin(n, sign, pin, q, new_q, alpha, force, motion, gap)
      integer, intent(in) :: n
      real(wp), intent(in) :: sign, pin(2, 0:n), q(4 + n), new_q(4 + n), alpha, force(2)
      real(wp), intent(inout) :: motion(3 + n), gap(2)
      real(wp) :: p0(2), p1(2), arm(2), end(2), own(2), mean(2)
      integer :: k
      mean = (0.5_wp*(1 + 0.25_wp*alpha**2)*sign)*(q(3:4) + new_q(3:4))
      own(1) = mean(1)*force(1) + mean(2)*force(2)
      own(2) = mean(1)*force(2) - mean(2)*force(1)
      p0 = pin(:, 0)
      p1 = p0
      do k = 1, n
         p0(1) = p0(1) + pin(1, k)*q(4 + k)
         p0(2) = p0(2) + pin(2, k)*q(4 + k)
         p1(1) = p1(1) + pin(1, k)*new_q(4 + k)
         p1(2) = p1(2) + pin(2, k)*new_q(4 + k)
         motion(3 + k) = motion(3 + k) + pin(1, k)*own(1) + pin(2, k)*own(2)
      end do
      end = along(p1, new_q(3:4))
      arm = 0.5_wp*(along(p0, q(3:4)) + end)
      motion(1:2) = motion(1:2) + sign*force
      motion(3) = motion(3) + sign*cross(arm, force)
      gap = gap + sign*(new_q(1:2) + end)
   end subroutine add_pin

   !> Inverses for Newton steps at the state of the last `forest_step_residual`: `linearise_step`.
   subroutine forest_step_factor(forest, model, step, y, lambda, singular)
      type(articulated_type), intent(inout) :: forest
      type(model_type), intent(in) :: model
      type(discrete_step_type), intent(in) :: step
      real(wp), contiguous, intent(in) :: y(:), lambda(:)
      logical, intent(out) :: singular
      real(wp) :: force(2)
      integer :: k, c, order
      order = forest%order
      singular = .false.
      forest%started = .false.
      do k = size(forest%places), 1, -1
         associate (place => forest%places(k))
            c = place%carrier
            if (.not. forest%started(k)) call start_block(forest, model, step, k, y)
            if (c >= 0) then
               force = place%sign*lambda(place%row:place%row + 1)
               call pin_step_rows(order, place%n, forest%pins(:, :, place%own), step%q(place%q:place%q + 3 + place%n), &
                  & step%new_q(place%q:place%q + 3 + place%n), y(place%w + 2), force, forest%reaction(:, :, k), &
                  & forest%rows(:, :, k), forest%block(:, :, k))
            end if
            call eliminate(forest, k, singular)
            if (singular) return
            if (c <= 0) cycle
            associate (carrier => forest%places(c))
               if (.not. forest%started(c)) call start_block(forest, model, step, c, y)
               call pin_step_rows(order, carrier%n, forest%pins(:, :, place%base), step%q(carrier%q:carrier%q + 3 + carrier%n), &
                  & step%new_q(carrier%q:carrier%q + 3 + carrier%n), y(carrier%w + 2), -force, forest%carried(:, :, k), &
                  & forest%carrying(:, :, k), forest%block(:, :, c))
               call hand_on(forest, k)
            end associate
         end associate
      end do
   end subroutine forest_step_factor

   !> The block of a body: derivatives of its balance by its increments.
   subroutine start_block(forest, model, step, k, y)
      type(articulated_type), intent(inout) :: forest
      type(model_type), intent(in) :: model
      type(discrete_step_type), intent(in) :: step
      integer, intent(in) :: k
      real(wp), intent(in) :: y(:)
      real(wp) :: slope(2, 3), arm(2), frame(3, 3), coupling(most_order, 3), between(most_order)
      integer :: n, j, point
      forest%started(k) = .true.
      n = forest%places(k)%n
      associate (at => forest%places(k)%w, last => forest%places(k)%w + 2 + n, first => forest%places(k)%q + 4, &
         & body => model%bodies(forest%places(k)%model)%reduced, gravity => model%gravity, h => step%h, &
         & block => forest%block(:, :, k))
         associate (u0 => step%q(first - 2:first - 1), u1 => step%new_q(first - 2:first - 1))
            slope = velocity_slope(h, u0, y(at:at + 2))
            call body_mass(body, [1.0_wp, 0.0_wp], step%new_q(first:first + n - 1), frame, coupling(:n, :))
            call momentum_tangent(body, step%new_q(first:first + n - 1), step%new_b(at:last), frame, coupling(:n, :), slope, &
               & h, block)
            call balance_tangent(h, u0, u1, y(at:last), step%p(at:at + 1), step%new_p(at:at + 1), block)
            between(:n) = step%q(first:first + n - 1) + 0.5_wp*y(at + 3:last)
            call pull_tangent(body, between(:n), step%b(at:last), step%new_b(at:last), slope, h, block)
            if (allocated(forest%masses)) forest%masses(:, :, k) = block
            arm = along(centre_moment(body, step%new_q(first:first + n - 1)), u1)
            block(3, 3) = block(3, 3) + 0.5_wp*dot_product(arm, gravity)/(1 + 0.25_wp*y(at + 2)**2)
            if (n == 0) return
            do j = 1, n
               block(3, 3 + j) = block(3, 3 + j) - 0.5_wp*cross(along(body%c(:, j), u1), gravity)
               block(3 + j, 3) = block(3 + j, 3) - 0.5_wp*cross(along(body%c(:, j), u0), gravity)
               if (body%damped) block(4:3 + n, 3 + j) = block(4:3 + n, 3 + j) + body%damping(:, j)/h
            end do
            do point = 1, size(gauss)
               between(:n) = step%q(first:first + n - 1) + gauss(point)*y(at + 3:last)
               forest%tangent(:n, :n) = 0.0_wp
               call elastic_tangent(body, between(:n), forest%tangent(:n, :n), forest%pairs)
               block(4:3 + n, 4:3 + n) = block(4:3 + n, 4:3 + n) + 0.5_wp*gauss(point)*forest%tangent(:n, :n)
            end do
         end associate
      end associate
   end subroutine start_block

   !> Rows of a pin: of the mean, transposed, and of the end by the increments; adds the derivatives of its force.
   pure subroutine pin_step_rows(order, n, pin, q, new_q, alpha, force, mean, end, block)
      integer, intent(in) :: order, n
      real(wp), intent(in) :: pin(2, 0:n), q(4 + n), new_q(4 + n), alpha, force(2)
      real(wp), intent(inout) :: mean(order, 2), end(order, 2), block(order, order)
      real(wp) :: p0(2), p1(2), um(2), arm(2), last(2), shape(2), part
      integer :: k
      um = (0.5_wp*(1 + 0.25_wp*alpha**2))*(q(3:4) + new_q(3:4))
      p0 = pin(:, 0)
      p1 = p0
      do k = 1, n
         p0 = p0 + pin(:, k)*q(4 + k)
         p1 = p1 + pin(:, k)*new_q(4 + k)
         shape = along(pin(:, k), um)
         mean(3 + k, 1) = shape(1)
         mean(3 + k, 2) = shape(2)
         part = 0.5_wp*cross(shape, force)
         block(3, 3 + k) = block(3, 3 + k) + part
         block(3 + k, 3) = block(3 + k, 3) + part
         shape = along(pin(:, k), new_q(3:4))
         end(3 + k, 1) = shape(1)
         end(3 + k, 2) = shape(2)
      end do
      last = along(p1, new_q(3:4))
      arm = 0.5_wp*(along(p0, q(3:4)) + last)
      mean(1, :) = [1.0_wp, 0.0_wp]
      mean(2, :) = [0.0_wp, 1.0_wp]
      mean(3, :) = turn(arm)
      end(1, :) = [1.0_wp, 0.0_wp]
      end(2, :) = [0.0_wp, 1.0_wp]
      end(3, :) = turn(last)/(1 + 0.25_wp*alpha**2)
      block(3, 3) = block(3, 3) - 0.5_wp*dot_product(arm, force)
   end subroutine pin_step_rows

   !> product = product + (derivatives of the momenta) vector, those of the last factors.
   pure subroutine forest_step_mass(forest, vector, product)
      type(articulated_type), intent(in) :: forest
      real(wp), intent(in) :: vector(:)
      real(wp), intent(inout) :: product(:)
      integer :: k, j, m
      do k = 1, size(forest%places)
         associate (place => forest%places(k))
            m = 3 + place%n
            do j = 1, m
               product(place%w:place%w + m - 1) = product(place%w:place%w + m - 1) &
                  & + vector(place%w + j - 1)*forest%masses(:m, j, k)
            end do
         end associate
      end do
   end subroutine forest_step_mass

end module limber_multibody_articulated_step
