!> Equations of motion over a step that balance energy and momenta. The change of the momenta equals the mean forces, which are
!> discrete gradients of the energies. Unknowns are the increments of a `discrete_step_type` and the multipliers.
!>
!> Joints and loads come in by the kinematics of the mean: with positions, levers and u averaged over both ends, shapes by eqs.
!> (2.58), (5.25) and increments over the step for velocities, their Jacobians and forces are discrete gradients. No allocation.
!> Floor: multibody. Source: doc/theory, eqs. (5.21)-(5.27), (5.29).
module limber_multibody_discrete_motion
   use limber_base_kinds, only: wp
   use limber_beam_elastic_forces, only: elastic_force, elastic_tangent
   use limber_beam_reduced_body, only: damping_power
   use limber_model_model, only: ground
   use limber_multibody_plane_vectors, only: turn, along, into_frame, cross
   use limber_multibody_body, only: body_mass, centre_moment
   use limber_multibody_constraint, only: jacobian_type
   use limber_multibody_equations_of_motion, only: position_residual
   use limber_multibody_beam_discrete_step, only: exact_pull, exact_momentum_tangent, exact_pull_tangent, exact_weight_tangent
   use limber_multibody_kinematics, only: place_frames
   use limber_multibody_layout, only: layout_type
   use limber_multibody_momentum, only: balance, balance_tangent, momentum_tangent, pull_tangent, velocity_slope
   use limber_multibody_motion_residual, only: copy_rows, add_reaction_stiffness
   use limber_multibody_multiplier_system, only: update_jacobians
   use limber_multibody_discrete_step, only: discrete_step_type, find_end, find_mean, find_momenta, gauss
   use limber_multibody_system, only: system_type, workspace_type
   use limber_multibody_tangent, only: tangent_type, gather, combine
   implicit none
   private
   public :: step_residual, linearise_step, step_work

contains

   !> Residuals of the equations of motion, eq. (5.23), and of the position constraints at the end. Leaves the end and the mean in
   !> the step, the kinematics of the end in the workspace.
   subroutine step_residual(system, work, step, y, lambda, motion, phi)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(discrete_step_type), intent(inout) :: step
      !> Increments (nw), multipliers (nc)
      real(wp), contiguous, intent(in) :: y(:), lambda(:)
      !> (nw) [force], (nc)
      real(wp), contiguous, intent(inout) :: motion(:), phi(:)
      integer :: i, side, first
      real(wp) :: largest
      call find_end(system%layout, step, y)
      do i = 1, size(step%start%angles)
         work%kinematics%angles(i)%anchor = step%start%angles(i)%value
         work%kinematics%angles(i)%since = step%final
      end do
      call place_frames(system%model, system%layout, step%final, step%new_q, work%kinematics)
      call find_mean(system, step, work%kinematics, y)
      call find_momenta(system, work%kinematics%lines, step%new_q, step%new_b, step%new_p)
      do i = 1, size(work%bodies)
         call body_residual(system, work, step, i, y, motion)
      end do
      do i = 1, size(system%loads)
         associate (load => system%loads(i)%item, force => work%loads(i)%force)
            force = 0.0_wp
            call load%add_force(step%mean, force)
            do side = 1, size(load%bodies)
               call take(motion, load%bodies(side), force(load%offsets(side) + 1:load%offsets(side) + load%rates(side)))
            end do
         end associate
      end do
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            call item%jacobian(step%mean, step%jacobians(1, i), step%jacobians(2, i))
            do side = 1, 2
               if (item%bodies(side) == ground) cycle
               first = system%layout%w(item%bodies(side))
               call add_reaction(step%jacobians(side, i), system%layout%rates(item%bodies(side)), &
                  & lambda(item%first:item%first + item%rows - 1), motion(first:))
            end do
         end associate
      end do
      largest = position_residual(system, work)
      phi = work%phi
      work%evaluations = work%evaluations + 1

   contains

      subroutine take(motion, body, force)
         real(wp), intent(inout) :: motion(:)
         integer, intent(in) :: body
         real(wp), intent(in) :: force(:)
         if (body == ground) return
         first = system%layout%w(body)
         motion(first:first + size(force) - 1) = motion(first:first + size(force) - 1) - force
      end subroutine take

   end subroutine step_residual

   !> Adds Jacobian^T lambda to a body's rows.
   pure subroutine add_reaction(jacobian, rates, lambda, motion)
      type(jacobian_type), intent(in) :: jacobian
      !> Number of the frame's rates
      integer, intent(in) :: rates
      real(wp), intent(in) :: lambda(:)
      real(wp), intent(inout) :: motion(:)
      integer :: row, k
      do row = 1, size(lambda)
         do k = 1, rates
            motion(k) = motion(k) + jacobian%z(row, k)*lambda(row)
         end do
         do k = 1, size(jacobian%eta, 2)
            motion(rates + k) = motion(rates + k) + jacobian%eta(row, k)*lambda(row)
         end do
      end do
   end subroutine add_reaction

   !> Change of the momenta of a body less elastic forces and weight.
   subroutine body_residual(system, work, step, i, y, motion)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(discrete_step_type), intent(inout) :: step
      integer, intent(in) :: i
      real(wp), contiguous, intent(in) :: y(:)
      real(wp), contiguous, intent(inout) :: motion(:)
      integer :: at, last, first, n, k
      at = system%layout%w(i)
      n = system%layout%n(i)
      last = at + 2 + n
      first = system%layout%q(i) + 4
      associate (body => system%model%bodies(i)%reduced, gravity => system%model%gravity, h => step%h)
         if (.not. system%layout%framed(i)) then
            motion(at:at + 1) = (step%new_p(at:at + 1) - step%p(at:at + 1))/h
            if (.not. system%layout%carries(i)) motion(at:at + 1) = motion(at:at + 1) - body%mass*gravity
            return
         else if (step%bodies(i)%line > 0) then
            call exact_balance(system, work, step, i, y, motion)
         else
            call balance(body, n, h, gravity, step%start%frames(i)%u, work%kinematics%frames(i)%u, step%q(first:), y(at:), &
               & step%b(at:), step%new_b(at:), step%p(at:), step%new_p(at:), motion(at:))
         end if
         if (n == 0) return
         call mean_elastic_force(system, work, step, i, y)
         do k = 1, n
            motion(at + 2 + k) = motion(at + 2 + k) + work%bodies(i)%eta_force(k)
            if (body%damped) motion(at + 2 + k) = motion(at + 2 + k) + dot_product(body%damping(:, k), y(at + 3:last))/h
         end do
      end associate
   end subroutine body_residual

   !> What `balance` finds of other bodies, of an exact beam.
   subroutine exact_balance(system, work, step, i, y, motion)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      type(discrete_step_type), intent(inout) :: step
      integer, intent(in) :: i
      real(wp), intent(in) :: y(:)
      real(wp), intent(inout) :: motion(:)
      real(wp) :: before(2), after(2), arm(2), stretch(2)
      integer :: at, last, k
      at = system%layout%w(i)
      last = at + 2 + system%layout%n(i)
      associate (own => step%bodies(i), u0 => step%start%frames(i)%u, u1 => work%kinematics%frames(i)%u, h => step%h, &
         & gravity => system%model%gravity, start => step%start%lines(step%bodies(i)%line), &
         & end => work%kinematics%lines(step%bodies(i)%line), mean => step%mean%lines(step%bodies(i)%line))
         before = along(step%p(at:at + 1), u0)
         after = along(step%new_p(at:at + 1), u1)
         arm = 0.5_wp*(along(start%moment(), u0) + along(end%moment(), u1))
         stretch = u0 + 0.5_wp*y(at + 2)*turn(u0)
         motion(at:at + 1) = (after - before)/h - system%model%bodies(i)%reduced%mass*gravity
         motion(at + 2) = (step%new_p(at + 2) - step%p(at + 2) + cross(y(at:at + 1), 0.5_wp*(before + after)))/h &
            & - cross(arm, gravity)
         call exact_pull(own%exact, start, end, mean, step%b(at:last), step%new_b(at:last), motion(at + 3:last))
         do k = 1, size(own%moment, 2)
            motion(at + 2 + k) = (step%new_p(at + 2 + k) - step%p(at + 2 + k))/h - motion(at + 2 + k) &
               & - dot_product(along(own%moment(:, k), stretch), gravity)
         end do
      end associate
   end subroutine exact_balance

   !> Mean of the elastic force over the segment of the coordinates into the body's `eta_force`: the mean-value discrete gradient,
   !> exact for polynomials of degree four.
   pure subroutine mean_elastic_force(system, work, step, i, y)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(discrete_step_type), intent(inout) :: step
      integer, intent(in) :: i
      real(wp), intent(in) :: y(:)
      integer :: at, first, n, point
      at = system%layout%w(i) + 3
      first = system%layout%q(i) + 4
      n = system%layout%n(i)
      associate (scratch => work%bodies(i), eta => step%bodies(i)%eta)
         scratch%eta_force = 0.0_wp
         do point = 1, size(gauss)
            eta = step%q(first:first + n - 1) + gauss(point)*y(at:at + n - 1)
            call elastic_force(system%model%bodies(i)%reduced, eta, scratch%eta_force, scratch%s)
         end do
         scratch%eta_force = scratch%eta_force/size(gauss)
      end associate
   end subroutine mean_elastic_force

   !> Matrix of a Newton step for [y; lambda] at the state of the last `step_residual`: exact but for the stiffness of joints and
   !> loads, which are taken at the end and at the mean.
   subroutine linearise_step(system, work, step, tangent, y, lambda)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(discrete_step_type), intent(inout) :: step
      type(tangent_type), intent(inout) :: tangent
      real(wp), intent(in) :: y(:), lambda(:)
      integer :: i
      call update_jacobians(system, work)
      do i = 1, size(tangent%bodies)
         call linearise_body(system, work, step, i, y, tangent)
      end do
      do i = 1, size(tangent%constraints)
         call linearise_constraint(system, work, step, i, y, lambda, tangent)
      end do
      do i = 1, size(tangent%loads)
         tangent%loads(i)%stiffness = 0.0_wp
         tangent%loads(i)%damping = 0.0_wp
         call system%loads(i)%item%add_tangent(step%mean, tangent%loads(i)%stiffness, tangent%loads(i)%damping)
      end do
      call gather(tangent)
      tangent%softness = 0.5_wp*step%h**2
      call combine(tangent, 1.0_wp, 1/step%h, 0.5_wp, 1.0_wp)
   end subroutine linearise_step

   !> Momenta into `mass`; twice the derivatives of minus the forces into `stiffness`.
   subroutine linearise_body(system, work, step, i, y, tangent)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(discrete_step_type), intent(inout) :: step
      integer, intent(in) :: i
      real(wp), intent(in) :: y(:)
      type(tangent_type), intent(inout) :: tangent
      real(wp) :: slope(2, 3), arm(2)
      integer :: at, last, first, n, k
      at = system%layout%w(i)
      n = system%layout%n(i)
      last = at + 2 + n
      first = system%layout%q(i) + 4
      associate (body => system%model%bodies(i)%reduced, u0 => step%start%frames(i)%u, u1 => work%kinematics%frames(i)%u, &
         & gravity => system%model%gravity, h => step%h, mass => tangent%bodies(i)%mass, &
         & stiffness => tangent%bodies(i)%stiffness, scratch => work%bodies(i))
         tangent%bodies(i)%damping = 0.0_wp
         stiffness = 0.0_wp
         if (.not. system%layout%framed(i)) then
            mass = reshape([2*body%mass/h**2, 0.0_wp, 0.0_wp, 2*body%mass/h**2], [2, 2])
            return
         end if
         slope = velocity_slope(h, u0, y(at:at + 2))
         if (step%bodies(i)%line > 0) then
            associate (line => work%kinematics%lines(step%bodies(i)%line))
               call line%mass_matrix([1.0_wp, 0.0_wp], scratch%mass, scratch%coupling)
               call line%eta_mass(scratch%eta_mass)
               call exact_momentum_tangent(line, step%new_b(at:last), scratch%mass, scratch%coupling, scratch%eta_mass, slope, h, &
                  & mass)
            end associate
         else
            call body_mass(body, [1.0_wp, 0.0_wp], step%new_q(first:first + n - 1), scratch%mass, scratch%coupling)
            call momentum_tangent(body, step%new_q(first:first + n - 1), step%new_b(at:last), scratch%mass, scratch%coupling, &
               & slope, h, mass)
         end if
         call balance_tangent(h, u0, u1, y(at:last), step%p(at:at + 1), step%new_p(at:at + 1), mass)
         step%bodies(i)%eta = step%q(first:first + n - 1) + 0.5_wp*y(at + 3:last)
         if (step%bodies(i)%line > 0) then
            associate (k => step%bodies(i)%line)
               call exact_pull_tangent(step%bodies(i)%exact, step%start%lines(k), work%kinematics%lines(k), step%mean%lines(k), &
                  & slope, h, mass)
               call exact_weight_tangent(step%bodies(i)%exact, step%mean%lines(k), into_frame(gravity, step%mean%frames(i)%u), &
                  & stiffness(4:, 4:))
               arm = along(work%kinematics%lines(k)%moment(), u1)
            end associate
         else
            call pull_tangent(body, step%bodies(i)%eta, step%b(at:last), step%new_b(at:last), slope, h, mass)
            arm = along(centre_moment(body, step%new_q(first:first + n - 1)), u1)
         end if
         stiffness(3, 3) = dot_product(arm, gravity)/(1 + 0.25_wp*y(at + 2)**2)
         do k = 1, n
            stiffness(3, 3 + k) = -cross(along(scratch%coupling(k, 1:2), u1), gravity)
            stiffness(3 + k, 3) = -cross(along(step%bodies(i)%moment(:, k), u0), gravity)
            if (body%damped) tangent%bodies(i)%damping(4:3 + n, 3 + k) = body%damping(:, k)
         end do
         if (n > 0) call add_elastic_tangent(system, work, step, i, y, tangent)
      end associate
   end subroutine linearise_body

   !> Twice the derivative of the mean elastic force by the end.
   subroutine add_elastic_tangent(system, work, step, i, y, tangent)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(discrete_step_type), intent(inout) :: step
      integer, intent(in) :: i
      real(wp), intent(in) :: y(:)
      type(tangent_type), intent(inout) :: tangent
      integer :: at, first, n, point
      at = system%layout%w(i) + 3
      first = system%layout%q(i) + 4
      n = system%layout%n(i)
      associate (scratch => work%bodies(i), own => step%bodies(i), to => tangent%bodies(i))
         do point = 1, size(gauss)
            own%eta = step%q(first:first + n - 1) + gauss(point)*y(at:at + n - 1)
            own%tangent = 0.0_wp
            call elastic_tangent(system%model%bodies(i)%reduced, own%eta, own%tangent, scratch%s)
            to%stiffness(4:, 4:) = to%stiffness(4:, 4:) + gauss(point)*own%tangent
         end do
      end associate
   end subroutine add_elastic_tangent

   !> Transposed rows of the mean in the equations of motion; rows of the end, by alpha instead of the angle, as those of the
   !> constraint.
   subroutine linearise_constraint(system, work, step, i, y, lambda, tangent)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(discrete_step_type), intent(in) :: step
      integer, intent(in) :: i
      real(wp), intent(in) :: y(:), lambda(:)
      type(tangent_type), intent(inout) :: tangent
      associate (item => system%constraints(i)%item, c => tangent%constraints(i))
         call copy_rows(step%jacobians(1, i)%z, step%jacobians(1, i)%eta, c%first)
         call copy_rows(step%jacobians(2, i)%z, step%jacobians(2, i)%eta, c%second)
         call copy_rows(work%jacobians(1, i)%z, work%jacobians(1, i)%eta, c%first_drift)
         call copy_rows(work%jacobians(2, i)%z, work%jacobians(2, i)%eta, c%second_drift)
         call by_alpha(system%layout, item%bodies(1), y, c%first_drift)
         call by_alpha(system%layout, item%bodies(2), y, c%second_drift)
         c%first_drift = c%first_drift - c%first
         c%second_drift = c%second_drift - c%second
         call add_reaction_stiffness(system, step%mean, i, lambda, tangent)
      end associate
   end subroutine linearise_constraint

   !> Turns the column of the angle into that of alpha = 2 tan(angle/2).
   pure subroutine by_alpha(layout, body, y, rows)
      type(layout_type), intent(in) :: layout
      integer, intent(in) :: body
      real(wp), intent(in) :: y(:)
      real(wp), intent(inout) :: rows(:, :)
      if (body == ground) return
      if (layout%framed(body)) rows(:, 3) = rows(:, 3)/(1 + 0.25_wp*y(layout%w(body) + 2)**2)
   end subroutine by_alpha

   !> Work put in by drivers, loads, damping and the force of the model k_g in the step of the last `step_residual`.
   real(wp) function step_work(system, work, step, y, lambda) result(done)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(discrete_step_type), intent(inout) :: step
      real(wp), intent(in) :: y(:), lambda(:)
      integer :: i, k, at, first
      real(wp) :: power
      power = 0.0_wp
      do i = 1, size(system%loads)
         call system%loads(i)%item%add_power(step%mean, power)
      end do
      done = step%h*power
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            if (item%driven) done = done + driver_work(system, step, i, y, lambda(item%first:item%first + item%rows - 1))
         end associate
      end do
      do i = 1, size(work%bodies)
         associate (body => system%model%bodies(i)%reduced)
            at = system%layout%w(i) + 2
            if (body%damped) done = done - damping_power(body, y(at + 1:at + body%n))/step%h
            if (.not. body%geometric) cycle
            call mean_elastic_force(system, work, step, i, y)
            first = system%layout%q(i) + 3
            do k = 1, body%n
               done = done - y(at + k)*(work%bodies(i)%eta_force(k) - body%omega2(k)*(step%q(first + k) + 0.5_wp*y(at + k)))
            end do
         end associate
      end do
   end function step_work

   !> Work of what moves a constraint in time: force times increment on both bodies.
   pure real(wp) function driver_work(system, step, i, y, lambda) result(done)
      type(system_type), intent(in) :: system
      type(discrete_step_type), intent(in) :: step
      !> Index of the constraint
      integer, intent(in) :: i
      !> Increments (nw), its multipliers
      real(wp), intent(in) :: y(:), lambda(:)
      integer :: side, k, at, rates
      done = 0.0_wp
      do side = 1, 2
         associate (body => system%constraints(i)%item%bodies(side), jacobian => step%jacobians(side, i))
            if (body == ground) cycle
            at = system%layout%w(body) - 1
            rates = system%layout%rates(body)
            do k = 1, rates
               done = done - y(at + k)*dot_product(jacobian%z(:, k), lambda)
            end do
            do k = 1, system%layout%n(body)
               done = done - y(at + rates + k)*dot_product(jacobian%eta(:, k), lambda)
            end do
         end associate
      end do
   end function driver_work

end module limber_multibody_discrete_motion
