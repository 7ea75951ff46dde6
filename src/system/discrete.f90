!> The equations of motion over a step from one state to another, such that energy and momenta balance whatever the step: the
!> change of the momenta equals the mean forces, which are discrete gradients of the energies. Unknowns are the increments
!> y = [dr; alpha; deta] of all bodies, in the layout of the rates, and the multipliers. The rates that go with them are those of
!> the frame's axes, [S^T r'; omega; eta']; those of a point mass stay in the fixed axes.
!>
!> Joints and loads come in by the kinematics of the mean: with positions, levers and u averaged over both ends, shapes by eq.
!> (53) and increments over the step for velocities, their Jacobians and forces are discrete gradients.
!> No allocation but in `new_step`. Floor: system. Source: doc/theory, eqs. (49)-(56).
module limber_system_discrete
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_flex_elastic, only: elastic_force, elastic_tangent
   use limber_model_scene, only: ground
   use limber_system_algebra, only: turn, along, cross
   use limber_system_body, only: body_mass, centre_moment
   use limber_system_constraint, only: jacobian_type
   use limber_system_dynamics, only: position_residual
   use limber_system_kinematics, only: kinematics_type, layout_type, new_kinematics, place_drives, place_frames, settle_angles
   use limber_system_markers, only: angle_change
   use limber_system_momentum, only: body_momentum, inertia_pull, momentum_tangent, pull_tangent
   use limber_system_motion, only: copy_rows, add_reaction_stiffness
   use limber_system_multiplier, only: update_jacobians
   use limber_system_system, only: system_type, workspace_type
   use limber_system_tangent, only: tangent_type, gather, combine
   implicit none
   private
   public :: step_type, new_step, begin_step, frame_rates, fixed_rates, step_residual, linearise_step, step_work
   public :: gauss, find_end, into_frame

   !> Gauss points of a step: to degree three, that of the elastic force
   real(wp), parameter :: gauss(2) = [0.5_wp - sqrt(3.0_wp)/6, 0.5_wp + sqrt(3.0_wp)/6]

   !> Scratch of a body
   type :: step_body_type
      !> Coordinates between the ends (n), elastic tangent (n,n)
      real(wp), allocatable :: eta(:), tangent(:, :)
   end type step_body_type

   !> A step from a state
   type :: step_type
      !> Time at its start, its length, time at its end: their sum but for rounding
      real(wp) :: t = 0.0_wp, h = 0.0_wp, final = 0.0_wp
      !> State at its start: coordinates (nq), rates and momenta in the axes of the frames (nw)
      real(wp), allocatable :: q(:), b(:), p(:)
      !> The end that is tried: coordinates, rates, momenta
      real(wp), allocatable :: new_q(:), new_b(:), new_p(:)
      !> Kinematics at the start, and of the mean; allocatable, since gfortran 12 gives back the parts of the first only otherwise
      type(kinematics_type), allocatable :: start, mean
      !> Jacobians of the mean (2, constraints)
      type(jacobian_type), allocatable :: jacobians(:, :)
      type(step_body_type), allocatable :: bodies(:)
   contains
      procedure :: exchange => exchange_step
   end type step_type

contains

   !> Room.
   subroutine new_step(system, work, step)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      type(step_type), intent(inout) :: step
      integer :: i
      associate (nq => system%layout%nq, nw => system%layout%nw)
         allocate (step%q(nq), step%new_q(nq), step%b(nw), step%new_b(nw), step%p(nw), step%new_p(nw))
      end associate
      allocate (step%start, step%mean)
      step%start = new_kinematics(system%model, system%marker_points, system%angles, system%bends)
      step%mean = step%start
      allocate (step%jacobians(2, size(system%constraints)), step%bodies(size(system%layout%q)))
      step%jacobians = work%jacobians
      do i = 1, size(step%bodies)
         associate (n => system%layout%n(i))
            allocate (step%bodies(i)%eta(n), step%bodies(i)%tangent(n, n))
         end associate
      end do
   end subroutine new_step

   !> Places the start at (t, q), rates b.
   subroutine begin_step(system, step, t, h, final, q, b)
      type(system_type), intent(in) :: system
      type(step_type), intent(inout) :: step
      !> Time, length, time at the end; coordinates (nq), rates in the axes of the frames (nw)
      real(wp), intent(in) :: t, h, final, q(:), b(:)
      step%t = t
      step%h = h
      step%final = final
      step%q = q
      step%b = b
      call place_frames(system%model, system%layout, t, q, step%start)
      call settle_angles(step%start)
      call place_drives(system%model, t + 0.5_wp*h, step%mean)
      step%mean%span = h
      call find_momenta(system, q, b, step%p)
   end subroutine begin_step

   pure subroutine find_momenta(system, q, b, p)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: q(:), b(:)
      real(wp), intent(inout) :: p(:)
      integer :: i, first, last, at
      do i = 1, size(system%layout%q)
         at = system%layout%w(i)
         associate (body => system%model%bodies(i)%reduced)
            if (system%layout%framed(i)) then
               first = system%layout%q(i) + 4
               last = at + 2 + body%n
               call body_momentum(body, q(first:first + body%n - 1), b(at:last), p(at:last))
            else
               p(at:at + 1) = body%mass*b(at:at + 1)
            end if
         end associate
      end do
   end subroutine find_momenta

   !> Rates in the axes of the frames from those in the fixed axes.
   pure subroutine frame_rates(layout, q, w, b)
      type(layout_type), intent(in) :: layout
      !> Coordinates (nq), rates (nw)
      real(wp), intent(in) :: q(:), w(:)
      real(wp), intent(inout) :: b(:)
      real(wp) :: part(2)
      integer :: i, at
      b = w
      do i = 1, size(layout%q)
         if (.not. layout%framed(i)) cycle
         at = layout%w(i)
         part = into_frame(w(at:at + 1), q(layout%q(i) + 2:layout%q(i) + 3))
         b(at:at + 1) = part
      end do
   end subroutine frame_rates

   !> And back.
   pure subroutine fixed_rates(layout, q, b, w)
      type(layout_type), intent(in) :: layout
      real(wp), intent(in) :: q(:), b(:)
      real(wp), intent(inout) :: w(:)
      real(wp) :: part(2)
      integer :: i, at
      w = b
      do i = 1, size(layout%q)
         if (.not. layout%framed(i)) cycle
         at = layout%w(i)
         part = along(b(at:at + 1), q(layout%q(i) + 2:layout%q(i) + 3))
         w(at:at + 1) = part
      end do
   end subroutine fixed_rates

   !> Components of a vector in the frame of u.
   pure function into_frame(a, u) result(p)
      real(wp), intent(in) :: a(2), u(2)
      real(wp) :: p(2)
      p(1) = u(1)*a(1) + u(2)*a(2)
      p(2) = cross(u, a)
   end function into_frame

   !> Coordinates and rates at the end of a step: eq. (49).
   pure subroutine find_end(layout, step, y)
      type(layout_type), intent(in) :: layout
      type(step_type), intent(inout) :: step
      real(wp), intent(in) :: y(:)
      real(wp) :: mean(2), alpha, along_u, across_u, size_of
      integer :: i, from, at
      do i = 1, size(layout%q)
         from = layout%q(i)
         at = layout%w(i)
         step%new_q(from:from + 1) = step%q(from:from + 1) + y(at:at + 1)
         if (.not. layout%framed(i)) then
            step%new_b(at:at + 1) = 2*y(at:at + 1)/step%h - step%b(at:at + 1)
            cycle
         end if
         alpha = y(at + 2)
         mean = into_frame(y(at:at + 1), step%q(from + 2:from + 3))
         mean = (mean - 0.5_wp*alpha*turn(mean))/step%h
         step%new_b(at:at + 1) = 2*mean - step%b(at:at + 1)
         step%new_b(at + 2:at + 2 + layout%n(i)) = 2*y(at + 2:at + 2 + layout%n(i))/step%h - step%b(at + 2:at + 2 + layout%n(i))
         along_u = 1 - 0.25_wp*alpha**2
         across_u = alpha
         associate (u => step%new_q(from + 2:from + 3), u0 => step%q(from + 2:from + 3))
            u(1) = along_u*u0(1) - across_u*u0(2)
            u(2) = along_u*u0(2) + across_u*u0(1)
            size_of = sqrt(u(1)**2 + u(2)**2)
            u = u/size_of
         end associate
         step%new_q(from + 4:from + 3 + layout%n(i)) = step%q(from + 4:from + 3 + layout%n(i)) + y(at + 3:at + 2 + layout%n(i))
      end do
   end subroutine find_end

   !> Kinematics of the mean, eq. (53).
   pure subroutine find_mean(layout, step, final, y)
      type(layout_type), intent(in) :: layout
      type(step_type), intent(inout) :: step
      !> Kinematics at the end
      type(kinematics_type), intent(in) :: final
      real(wp), intent(in) :: y(:)
      integer :: i, k, m, at
      do i = 1, size(layout%q)
         at = layout%w(i)
         associate (frame => step%mean%frames(i), a => step%start%frames(i), b => final%frames(i))
            frame%position = 0.5_wp*(a%position + b%position)
            frame%velocity = y(at:at + 1)/step%h
            if (.not. layout%framed(i)) cycle
            frame%u = 0.5_wp*(a%u + b%u)
            frame%omega = y(at + 2)/step%h
            frame%rate = frame%omega*turn(frame%u)
         end associate
      end do
      do m = 1, size(step%mean%markers)
         associate (marker => step%mean%markers(m), a => step%start%markers(m), b => final%markers(m))
            if (marker%body == ground) cycle
            associate (frame => step%mean%frames(marker%body))
               marker%position = 0.5_wp*(a%position + b%position)
               marker%lever = 0.5_wp*(a%lever + b%lever)
               marker%velocity = frame%omega*marker%lever
               if (.not. marker%direction) marker%velocity = frame%velocity + marker%velocity
               do k = 1, size(marker%shape, 2)
                  marker%shape(:, k) = 0.5_wp*(1 + 0.25_wp*(frame%omega*step%h)**2)*(a%shape(:, k) + b%shape(:, k))
                  marker%velocity = marker%velocity + marker%shape(:, k)*(y(layout%w(marker%body) + 2 + k)/step%h)
               end do
            end associate
         end associate
      end do
      do m = 1, size(step%mean%angles)
         step%mean%angles(m)%value = final%angles(m)%value - 0.5_wp*angle_change(step%mean, m)
      end do
      do m = 1, size(step%mean%bends)
         associate (bend => step%mean%bends(m))
            bend%eta = 0.5_wp*(step%start%bends(m)%eta + final%bends(m)%eta)
            at = layout%w(bend%body) + 3
            bend%rate = y(at:at + size(bend%rate) - 1)/step%h
         end associate
      end do
   end subroutine find_mean

   !> Residuals of the equations of motion, eq. (51), and of the position constraints at the end. Leaves the end and the mean in
   !> the step, the kinematics of the end in the workspace.
   subroutine step_residual(system, work, step, y, lambda, motion, phi)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(step_type), intent(inout) :: step
      !> Increments (nw), multipliers (nc)
      real(wp), intent(in) :: y(:), lambda(:)
      !> (nw) [force], (nc)
      real(wp), intent(inout) :: motion(:), phi(:)
      integer :: i, side, first
      real(wp) :: largest
      call find_end(system%layout, step, y)
      do i = 1, size(step%start%angles)
         work%kinematics%angles(i)%anchor = step%start%angles(i)%value
      end do
      call place_frames(system%model, system%layout, step%final, step%new_q, work%kinematics)
      call find_mean(system%layout, step, work%kinematics, y)
      call find_momenta(system, step%new_q, step%new_b, step%new_p)
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
      type(step_type), intent(inout) :: step
      integer, intent(in) :: i
      real(wp), intent(in) :: y(:)
      real(wp), intent(inout) :: motion(:)
      real(wp) :: before(2), after(2), arm(2), stretch(2)
      integer :: at, last, first, n, k
      at = system%layout%w(i)
      n = system%layout%n(i)
      associate (body => system%model%bodies(i)%reduced, u0 => step%start%frames(i)%u, u1 => work%kinematics%frames(i)%u, &
            & gravity => system%model%gravity, h => step%h)
         if (.not. system%layout%framed(i)) then
            motion(at:at + 1) = (step%new_p(at:at + 1) - step%p(at:at + 1))/h - body%mass*gravity
            return
         end if
         last = at + 2 + n
         first = system%layout%q(i) + 4
         before = along(step%p(at:at + 1), u0)
         after = along(step%new_p(at:at + 1), u1)
         arm = 0.5_wp*(along(centre_moment(body, step%q(first:first + n - 1)), u0) &
            & + along(centre_moment(body, step%new_q(first:first + n - 1)), u1))
         stretch = u0 + 0.5_wp*y(at + 2)*turn(u0)
         motion(at:at + 1) = (after - before)/h - body%mass*gravity
         motion(at + 2) = (step%new_p(at + 2) - step%p(at + 2) + cross(y(at:at + 1), 0.5_wp*(before + after)))/h &
            & - cross(arm, gravity)
         if (n == 0) return
         step%bodies(i)%eta = step%q(first:first + n - 1) + 0.5_wp*y(at + 3:last)
         call inertia_pull(body, step%bodies(i)%eta, step%b(at:last), step%new_b(at:last), motion(at + 3:last))
         call mean_elastic_force(system, work, step, i, y)
         do k = 1, n
            motion(at + 2 + k) = (step%new_p(at + 2 + k) - step%p(at + 2 + k))/h - motion(at + 2 + k) &
               & + work%bodies(i)%eta_force(k) - dot_product(along(body%c(:, k), stretch), gravity)
            if (body%damped) motion(at + 2 + k) = motion(at + 2 + k) + body%damping(k)*y(at + 2 + k)/h
         end do
      end associate
   end subroutine body_residual

   !> Mean of the elastic force over the segment of the coordinates into the body's `eta_force`: the mean-value discrete gradient,
   !> exact for polynomials of degree four.
   pure subroutine mean_elastic_force(system, work, step, i, y)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(step_type), intent(inout) :: step
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
            call elastic_force(system%model%bodies(i)%reduced, eta, scratch%eta_force, scratch%z, scratch%s)
         end do
         scratch%eta_force = scratch%eta_force/size(gauss)
      end associate
   end subroutine mean_elastic_force

   !> Matrix of a Newton step for [y; lambda] at the state of the last `step_residual`: exact but for the stiffness of joints and
   !> loads, which are taken at the end and at the mean.
   subroutine linearise_step(system, work, step, tangent, y, lambda)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(step_type), intent(inout) :: step
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
      call combine(tangent, (1.0_wp, 0.0_wp), cmplx(1/step%h, 0.0_wp, wp), (0.5_wp, 0.0_wp), (1.0_wp, 0.0_wp), .false.)
   end subroutine linearise_step

   !> Momenta into `mass`; twice the derivatives of minus the forces into `stiffness`.
   subroutine linearise_body(system, work, step, i, y, tangent)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(step_type), intent(inout) :: step
      integer, intent(in) :: i
      real(wp), intent(in) :: y(:)
      type(tangent_type), intent(inout) :: tangent
      real(wp) :: slope(2, 3), back(2), after(2), mean(2), arm(2), change(2), shrink
      integer :: at, last, first, n, j, k
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
         shrink = 1/(1 + 0.25_wp*y(at + 2)**2)
         back = [u0(1), -u0(2)]
         slope(:, 1) = (back - 0.5_wp*y(at + 2)*turn(back))*(2/h)
         slope(:, 2) = turn(slope(:, 1))
         slope(:, 3) = -turn(into_frame(y(at:at + 1), u0))/h
         call body_mass(body, [1.0_wp, 0.0_wp], step%new_q(first:first + n - 1), scratch%mass, scratch%coupling)
         call momentum_tangent(body, step%new_q(first:first + n - 1), step%new_b(at:last), scratch%mass, scratch%coupling, &
            & slope, h, mass)
         after = along(step%new_p(at:at + 1), u1)
         mean = 0.5_wp*(after + along(step%p(at:at + 1), u0))
         do j = 1, 3 + n
            change = along(mass(1:2, j), u1)
            if (j == 3) change = change + shrink*turn(after)
            mass(3, j) = mass(3, j) + 0.5_wp*cross(y(at:at + 1), change)
            mass(1:2, j) = change
         end do
         mass(3, 1) = mass(3, 1) + mean(2)
         mass(3, 2) = mass(3, 2) - mean(1)
         mass = mass/h
         step%bodies(i)%eta = step%q(first:first + n - 1) + 0.5_wp*y(at + 3:last)
         call pull_tangent(body, step%bodies(i)%eta, step%b(at:last), step%new_b(at:last), slope, h, mass)
         arm = along(centre_moment(body, step%new_q(first:first + n - 1)), u1)
         stiffness(3, 3) = shrink*dot_product(arm, gravity)
         do k = 1, n
            stiffness(3, 3 + k) = -cross(along(body%c(:, k), u1), gravity)
            stiffness(3 + k, 3) = -cross(along(body%c(:, k), u0), gravity)
            if (body%damped) tangent%bodies(i)%damping(3 + k, 3 + k) = body%damping(k)
         end do
         if (n > 0) call add_elastic_tangent(system, work, step, i, y, tangent)
      end associate
   end subroutine linearise_body

   !> Twice the derivative of the mean elastic force by the end.
   subroutine add_elastic_tangent(system, work, step, i, y, tangent)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(step_type), intent(inout) :: step
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
            call elastic_tangent(system%model%bodies(i)%reduced, own%eta, own%tangent, scratch%z, scratch%s, to%slope)
            to%stiffness(4:, 4:) = to%stiffness(4:, 4:) + gauss(point)*own%tangent
         end do
      end associate
   end subroutine add_elastic_tangent

   !> Transposed rows of the mean in the equations of motion; rows of the end, by alpha instead of the angle, as those of the
   !> constraint.
   subroutine linearise_constraint(system, work, step, i, y, lambda, tangent)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(step_type), intent(in) :: step
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
      type(step_type), intent(inout) :: step
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
            if (body%damped) done = done - sum(body%damping*y(at + 1:at + body%n)**2)/step%h
            if (body%full .or. .not. body%geometric) cycle
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
      type(step_type), intent(in) :: step
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

   !> Saves or restores its memory.
   subroutine exchange_step(self, snapshot)
      class(step_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      integer :: i, j
      call snapshot%exchange('t', self%t)
      call snapshot%exchange('h', self%h)
      call snapshot%exchange('final', self%final)
      call snapshot%keep('q', self%q)
      call snapshot%keep('b', self%b)
      call snapshot%keep('p', self%p)
      call snapshot%keep('new_q', self%new_q)
      call snapshot%keep('new_b', self%new_b)
      call snapshot%keep('new_p', self%new_p)
      call self%start%exchange(snapshot)
      call self%mean%exchange(snapshot)
      do i = 1, size(self%jacobians, 2)
         do j = 1, 2
            call self%jacobians(j, i)%exchange(snapshot)
         end do
      end do
      do i = 1, size(self%bodies)
         call snapshot%keep('eta', self%bodies(i)%eta)
         call snapshot%keep('tangent', self%bodies(i)%tangent)
      end do
   end subroutine exchange_step

end module limber_system_discrete
