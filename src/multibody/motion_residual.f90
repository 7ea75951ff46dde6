!> Residual of the equations of motion in the independent rates. Their residual, and its exact derivatives into the blocks of the
!> tangent. Increments of the coordinates are those of `advance`, in the layout of w. Floor: multibody. Source: Han and Lee 1993,
!> eq. (28); doc/theory, eqs. (4.15), (4.16), (4.18).
module limber_multibody_motion_residual
   use limber_base_kinds, only: wp
   use limber_beam_elastic_forces, only: elastic_tangent
   use limber_model_model, only: ground
   use limber_multibody_body, only: body_tangent, inertia_forces
   use limber_multibody_beam_residual, only: add_beam_residual
   use limber_multibody_beam_axis_tangent, only: add_centreline_tangent
   use limber_multibody_equations_of_motion, only: sum_given_forces
   use limber_multibody_unit_mass_coordinates, only: update_eta_masses
   use limber_multibody_kinematics, only: kinematics_type, place_frames, move_bodies, move_frames
   use limber_multibody_multiplier_system, only: place_jacobians, update_beam_masses, update_masses
   use limber_multibody_system, only: system_type, workspace_type
   use limber_multibody_tangent, only: tangent_type, body_tangent_type, gather
   implicit none
   private
   public :: place_motion, motion_residual, linearise_motion, linearise_loads, add_reaction_stiffness, copy_rows

contains

   !> Places kinematics and Jacobians at a state: what `linearise_motion` needs.
   subroutine place_motion(system, work, t, q, v, passing)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      !> Coordinates and velocities (nq)
      real(wp), contiguous, intent(in) :: q(:), v(:)
      !> As in `motion_residual`
      logical, intent(in), optional :: passing
      logical :: bare
      bare = .false.
      if (present(passing)) bare = passing .and. size(system%loads) == 0
      call place_frames(system%model, system%layout, t, q, work%kinematics)
      if (bare) then
         call move_bodies(system%model, system%layout, v, work%kinematics)
      else
         call move_frames(system%model, system%layout, q, v, work%kinematics)
      end if
      call place_jacobians(system, work)
   end subroutine place_motion

   !> Residual of the equations of motion, M a - forces + G^T lambda (nw), and of the velocity equations, G w - rate (nc), at a
   !> state. Leaves the kinematics and Jacobians there.
   subroutine motion_residual(system, work, t, q, v, a, lambda, motion, rates, passing)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      !> Coordinates and velocities (nq); accelerations in the layout of the rates (nw); multipliers (nc)
      real(wp), contiguous, intent(in) :: q(:), v(:), a(:), lambda(:)
      real(wp), contiguous, intent(inout) :: motion(:), rates(:)
      !> Whether nothing else is to be asked of the state: markers are moved only if loads need it then
      logical, intent(in), optional :: passing
      integer :: i, first, n, j, k, m
      call place_motion(system, work, t, q, v, passing)
      call sum_given_forces(system, work, q, v, .false.)
      work%evaluations = work%evaluations + 1
      do i = 1, size(work%bodies)
         call body_residual(system, work, i, q, v, a, motion)
      end do
      do i = 1, size(work%kinematics%beams)
         first = system%layout%w(work%kinematics%beams(i))
         n = work%kinematics%lines(i)%n
         associate (frame => work%kinematics%frames(work%kinematics%beams(i)))
            call add_beam_residual(work%kinematics%lines(i), system%model%gravity, frame%u, frame%omega, a(first:first + 2 + n), &
               & motion(first:first + 2 + n))
         end associate
      end do
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            if (item%part_of == 0) then
               call item%rate(work%kinematics, rates(item%first:item%first + item%rows - 1))
               rates(item%first:item%first + item%rows - 1) = -rates(item%first:item%first + item%rows - 1)
            end if
            do j = 1, 2
               if (item%bodies(j) == ground) cycle
               first = system%layout%w(item%bodies(j))
               m = system%layout%rates(item%bodies(j))
               associate (jacobian => work%jacobians(j, i), frame => work%kinematics%frames(item%bodies(j)))
                  ! No deflection moves the origin that a frame hangs at
                  n = merge(0, size(jacobian%eta, 2), system%tree%joint(item%bodies(j)) == i)
                  k = min(system%layout%q(item%bodies(j)) + 4, size(v) + 1)
                  call add_side(item%rows, m, n, jacobian%z, jacobian%eta, lambda(item%first:), frame%velocity, frame%omega, &
                     & v(k:), motion(first:), rates(item%first:))
               end associate
            end do
         end associate
      end do
   end subroutine motion_residual

   !> The part of a body; of an exact beam its elastic forces and loads alone.
   subroutine body_residual(system, work, i, q, v, a, motion)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      integer, intent(in) :: i
      real(wp), contiguous, intent(in) :: q(:), v(:), a(:)
      real(wp), contiguous, intent(inout) :: motion(:)
      integer :: first, at, m, n, k
      first = system%layout%w(i)
      at = system%layout%q(i) + 4
      m = system%layout%rates(i)
      n = system%layout%n(i)
      associate (body => work%bodies(i), reduced => system%model%bodies(i)%reduced, frame => work%kinematics%frames(i))
         if (reduced%is_exact) then
            motion(first:first + 2 + n) = 0.0_wp
         else if (system%layout%framed(i)) then
            call inertia_forces(reduced, n, system%model%gravity, frame%u, q(at:), frame%omega, v(at:), a(first:), a(first + 2), &
               & a(first + 3:), motion(first:))
         else if (system%layout%carries(i)) then
            motion(first:first + 1) = reduced%mass*a(first:first + 1)
         else
            motion(first:first + 1) = reduced%mass*(a(first:first + 1) - system%model%gravity)
         end if
         ! What is left of the forces
         do k = 1, m
            motion(first + k - 1) = motion(first + k - 1) - body%force(k)
            body%force(k) = -motion(first + k - 1)
         end do
         do k = 1, n
            motion(first + m + k - 1) = motion(first + m + k - 1) - body%eta_force(k)
         end do
      end associate
   end subroutine body_residual

   !> Adds the forces of constraint equations on one of their bodies, and the speed that it gives them.
   pure subroutine add_side(rows, rates, n, z, eta, lambda, velocity, omega, eta_rates, motion, speed)
      !> Numbers of equations, of rates of the frame, and of deflections
      integer, intent(in) :: rows, rates, n
      !> Jacobian, multipliers, rates of the body
      real(wp), intent(in) :: z(rows, 3), eta(rows, n), lambda(rows), velocity(2), omega, eta_rates(n)
      real(wp), intent(inout) :: motion(rates + n), speed(rows)
      real(wp) :: force, total
      integer :: row, k
      do row = 1, rows
         force = lambda(row)
         total = speed(row) + z(row, 1)*velocity(1) + z(row, 2)*velocity(2)
         motion(1) = motion(1) + z(row, 1)*force
         motion(2) = motion(2) + z(row, 2)*force
         if (rates == 3) then
            total = total + z(row, 3)*omega
            motion(3) = motion(3) + z(row, 3)*force
         end if
         do k = 1, n
            total = total + eta(row, k)*eta_rates(k)
            motion(rates + k) = motion(rates + k) + eta(row, k)*force
         end do
         speed(row) = total
      end do
   end subroutine add_side

   !> Derivatives at the state of the last `place_motion` or `motion_residual`.
   subroutine linearise_motion(system, work, tangent, q, v, a, lambda)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(tangent_type), intent(inout) :: tangent
      !> As in `motion_residual`
      real(wp), contiguous, intent(in) :: q(:), v(:), a(:), lambda(:)
      integer :: i
      call update_masses(system, work, q)
      if (system%exact) then
         call update_beam_masses(work)
         call update_eta_masses(work)
      end if
      do i = 1, size(tangent%bodies)
         call linearise_body(system, work, i, q, v, a, tangent%bodies(i))
      end do
      do i = 1, size(tangent%constraints)
         call linearise_constraint(system, work, i, lambda, tangent)
      end do
      call linearise_loads(system, work, tangent)
      call gather(tangent)
   end subroutine linearise_motion

   !> Derivatives of the loads alone, at the kinematics as they are placed and moved.
   subroutine linearise_loads(system, work, tangent)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      type(tangent_type), intent(inout) :: tangent
      integer :: i
      do i = 1, size(tangent%loads)
         tangent%loads(i)%stiffness = 0.0_wp
         tangent%loads(i)%damping = 0.0_wp
         call system%loads(i)%item%add_tangent(work%kinematics, tangent%loads(i)%stiffness, tangent%loads(i)%damping)
         if (.not. system%loads(i)%item%is_scaled) cycle
         tangent%loads(i)%stiffness = system%loads(i)%item%share*tangent%loads(i)%stiffness
         tangent%loads(i)%damping = system%loads(i)%item%share*tangent%loads(i)%damping
      end do
   end subroutine linearise_loads

   subroutine linearise_body(system, work, i, q, v, a, body)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      integer, intent(in) :: i
      real(wp), contiguous, intent(in) :: q(:), v(:), a(:)
      type(body_tangent_type), intent(inout) :: body
      integer :: m, n, k, first, last, at
      m = system%layout%rates(i)
      n = system%layout%n(i)
      body%mass = 0.0_wp
      body%damping = 0.0_wp
      body%stiffness = 0.0_wp
      body%mass(:m, :m) = work%bodies(i)%mass(:m, :m)
      if (.not. system%layout%framed(i)) return
      do k = 1, n
         body%mass(3 + k, :3) = work%bodies(i)%coupling(k, :)
         body%mass(:3, 3 + k) = work%bodies(i)%coupling(k, :)
         body%mass(3 + k, 3 + k) = 1.0_wp
      end do
      if (allocated(work%bodies(i)%eta_mass)) body%mass(4:, 4:) = work%bodies(i)%eta_mass
      first = system%layout%q(i) + 4
      last = first + n - 1
      at = system%layout%w(i)
      associate (frame => work%kinematics%frames(i), reduced => system%model%bodies(i)%reduced)
         if (reduced%is_exact) then
            associate (line => work%kinematics%lines(findloc(work%kinematics%beams, i, dim=1)))
               call add_centreline_tangent(line, system%model%gravity, frame%u, frame%omega, a(at:at + 1), a(at + 2), &
                  & a(at + 3:at + 2 + n), body%stiffness(:, 3:), body%damping(:, 3:))
            end associate
         else
            call body_tangent(reduced, system%model%gravity, frame%u, frame%omega, q(first:last), v(first:last), a(at:at + 1), &
               & a(at + 2), a(at + 3:at + 2 + n), body%stiffness(:, 3:), body%damping(:, 3:))
         end if
         if (n > 0) call elastic_tangent(reduced, q(first:last), body%stiffness(4:, 4:), work%bodies(i)%s)
         if (.not. reduced%damped) return
         do k = 1, n
            body%damping(4:3 + n, 3 + k) = body%damping(4:3 + n, 3 + k) + reduced%damping(:, k)
         end do
      end associate
   end subroutine linearise_body

   subroutine linearise_constraint(system, work, i, lambda, tangent)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      integer, intent(in) :: i
      real(wp), intent(in) :: lambda(:)
      type(tangent_type), intent(inout) :: tangent
      associate (item => system%constraints(i)%item, c => tangent%constraints(i))
         call copy_rows(work%jacobians(1, i)%z, work%jacobians(1, i)%eta, c%first)
         call copy_rows(work%jacobians(2, i)%z, work%jacobians(2, i)%eta, c%second)
         c%first_drift = 0.0_wp
         c%second_drift = 0.0_wp
         call item%drift(work%kinematics, c%first_drift, c%second_drift)
         call add_reaction_stiffness(system, work%kinematics, i, lambda, tangent)
      end associate
   end subroutine linearise_constraint

   !> Adds the derivatives of the forces of a constraint to the stiffness of its bodies, and sets those across them.
   subroutine add_reaction_stiffness(system, kinematics, i, lambda, tangent)
      type(system_type), intent(in) :: system
      !> Where the derivatives are taken
      type(kinematics_type), intent(in) :: kinematics
      !> Index of the constraint
      integer, intent(in) :: i
      !> Multipliers of all (nc)
      real(wp), intent(in) :: lambda(:)
      type(tangent_type), intent(inout) :: tangent
      real(wp) :: none(0, 0)
      associate (item => system%constraints(i)%item, across => tangent%constraints(i)%across)
         across = 0.0_wp
         associate (force => lambda(item%first:item%first + item%rows - 1))
            if (item%bodies(1) == ground) then
               call item%stiffness(kinematics, force, none, tangent%bodies(item%bodies(2))%stiffness, across)
            else if (item%bodies(2) == ground) then
               call item%stiffness(kinematics, force, tangent%bodies(item%bodies(1))%stiffness, none, across)
            else
               call item%stiffness(kinematics, force, tangent%bodies(item%bodies(1))%stiffness, &
                  & tangent%bodies(item%bodies(2))%stiffness, across)
            end if
         end associate
      end associate
   end subroutine add_reaction_stiffness

   !> Rows of a Jacobian, frame and eta side by side.
   pure subroutine copy_rows(z, eta, rows)
      real(wp), intent(in) :: z(:, :), eta(:, :)
      real(wp), intent(inout) :: rows(:, :)
      integer :: m
      m = size(rows, 2) - size(eta, 2)
      rows(:, :m) = z(:, :m)
      rows(:, m + 1:) = eta
   end subroutine copy_rows

end module limber_multibody_motion_residual
