!> Right-hand side, constraint residuals, energy and power. No allocation, no finite elements. Floor: multibody. Source: Han and Lee
!> 1993, eq. (28); doc/theory, eqs. (4.1), (4.2).
module limber_multibody_equations_of_motion
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_base_text, only: as_text
   use limber_beam_elastic_forces, only: elastic_force, elastic_energy, geometric_power, find_tension, tension_power
   use limber_beam_reduced_body, only: add_damping, damping_power
   use limber_model_model, only: body_flexible, ground
   use limber_multibody_plane_vectors, only: turn, along, cross
   use limber_multibody_beam_axis, only: centreline_type
   use limber_multibody_unit_mass_coordinates, only: factor_eta_masses
   use limber_multibody_body, only: velocity_forces, gravity_forces, rigid_forces, kinetic_energy, weight_potential
   use limber_multibody_kinematics, only: place_bodies, place_frames, move_frames
   use limber_multibody_multiplier_system, only: update_jacobians, factor_multiplier_system
   use limber_multibody_multiplier_solution, only: solve_multiplier_system, recover_multipliers
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: linearise, linearise_placed, accelerations, accelerate, sum_forces, sum_given_forces
   public :: position_residual, open_residual, velocity_residual, velocity_gaps, acceleration_gaps
   public :: input_power, power_at, add_parts_of_power, mechanical_energy, worst_constraint

contains

   !> Places everything at (t, q) and factors the multiplier system there.
   subroutine linearise(system, work, t, q, error)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      !> Coordinates (nq)
      real(wp), contiguous, intent(in) :: q(:)
      !> The matrix is singular
      type(error_type), allocatable, intent(out) :: error
      call place_frames(system%model, system%layout, t, q, work%kinematics)
      call linearise_placed(system, work, t, q, error)
   end subroutine linearise

   !> The same where the kinematics are placed at (t, q) already.
   subroutine linearise_placed(system, work, t, q, error)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      real(wp), contiguous, intent(in) :: q(:)
      type(error_type), allocatable, intent(out) :: error
      logical :: singular
      if (system%exact) then
         call factor_eta_masses(work, singular)
         if (singular) then
            call raise(error, 'the mass matrix of an exact beam is singular at t = '//as_text(t, 6)// &
               & ': it is wound up too much for its FUNCTIONS')
            return
         end if
      end if
      call update_jacobians(system, work)
      call factor_multiplier_system(system, work, q, singular)
      if (singular) call raise(error, 'the multiplier system is singular at t = '//as_text(t, 6)// &
         & ': a constraint is redundant there, or a body without mass is free to move')
   end subroutine linearise_placed

   !> Accelerations and multipliers at (t, q, v); `linearise` at the same (t, q) comes first.
   subroutine accelerations(system, work, q, v, a, reactions)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Coordinates and velocities (nq)
      real(wp), contiguous, intent(in) :: q(:), v(:)
      !> Second derivatives of q (nq)
      real(wp), contiguous, intent(out) :: a(:)
      !> Whether multipliers are asked for; if not given, they are
      logical, intent(in), optional :: reactions
      logical :: asked
      integer :: i, first
      real(wp) :: alpha, square
      asked = .true.
      if (present(reactions)) asked = reactions
      call move_frames(system%model, system%layout, q, v, work%kinematics)
      call sum_forces(system, work, q, v)
      call acceleration_gaps(system, work)
      call solve_multiplier_system(system, work, work%gamma, a, .false.)
      if (asked) call recover_multipliers(system, work)
      do i = 1, size(work%bodies)
         if (.not. system%layout%framed(i)) cycle
         first = system%layout%q(i) + 2
         alpha = a(first)
         associate (frame => work%kinematics%frames(i))
            square = frame%rate(1)**2 + frame%rate(2)**2
            a(first) = -alpha*frame%u(2) - square*frame%u(1)
            a(first + 1) = alpha*frame%u(1) - square*frame%u(2)
         end associate
      end do
      work%evaluations = work%evaluations + 1
   end subroutine accelerations

   !> Right-hand sides of the acceleration equations into work%gamma; kinematics are placed and moved.
   subroutine acceleration_gaps(system, work)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      integer :: i
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            call item%gamma(work%kinematics, work%gamma(item%first:item%first + item%rows - 1))
         end associate
      end do
   end subroutine acceleration_gaps

   !> Accelerations that forces alone make, at rest and with the constraints kept; `linearise` comes first.
   subroutine accelerate(system, work, force, push)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Forces in the layout of the rates (nw)
      real(wp), intent(in) :: force(:)
      !> Accelerations in the layout of the rates (nw)
      real(wp), intent(out) :: push(:)
      real(wp) :: change(system%layout%nq)
      integer :: i, first, rates, n
      do i = 1, size(work%bodies)
         first = system%layout%w(i)
         rates = system%layout%rates(i)
         n = system%layout%n(i)
         work%bodies(i)%force = 0.0_wp
         work%bodies(i)%force(:rates) = force(first:first + rates - 1)
         work%bodies(i)%eta_force = force(first + rates:first + rates + n - 1)
      end do
      work%gamma = 0.0_wp
      call solve_multiplier_system(system, work, work%gamma, change, .false.)
      do i = 1, size(work%bodies)
         first = system%layout%w(i)
         rates = system%layout%rates(i)
         n = system%layout%n(i)
         push(first:first + rates - 1) = work%bodies(i)%acceleration(:rates)
         push(first + rates:first + rates + n - 1) = change(system%layout%q(i) + 4:system%layout%q(i) + 3 + n)
      end do
   end subroutine accelerate

   !> Velocity terms, weight, elasticity and loads of all bodies into the workspace.
   subroutine sum_forces(system, work, q, v)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), contiguous, intent(in) :: q(:), v(:)
      integer :: i
      call sum_given_forces(system, work, q, v, .true.)
      do i = 1, size(work%kinematics%beams)
         associate (body => work%bodies(work%kinematics%beams(i)), frame => work%kinematics%frames(work%kinematics%beams(i)))
            call work%kinematics%lines(i)%forces(system%model%gravity, frame%u, frame%omega, body%force, body%eta_force)
         end associate
      end do
   end subroutine sum_forces

   !> The same without velocity terms and weight: of exact beams, or of all bodies.
   subroutine sum_given_forces(system, work, q, v, inertial)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), contiguous, intent(in) :: q(:), v(:)
      !> Whether bodies other than exact beams have theirs
      logical, intent(in) :: inertial
      integer :: i, first, last, side
      logical :: heavy
      heavy = inertial .and. any(abs(system%model%gravity) > 0.0_wp)
      do i = 1, size(work%bodies)
         associate (body => work%bodies(i), reduced => system%model%bodies(i)%reduced, frame => work%kinematics%frames(i))
            body%force = 0.0_wp
            if (.not. system%layout%framed(i)) then
               if (heavy .and. .not. system%layout%carries(i)) body%force(1:2) = system%inertia(1, i)*system%model%gravity
               cycle
            else if (system%layout%n(i) == 0) then
               if (inertial) call rigid_forces(system%inertia(:, i), system%model%gravity, frame%u, frame%omega, body%force)
               cycle
            end if
            first = system%layout%q(i) + 4
            last = first + reduced%n - 1
            if (reduced%n > 0) then
               body%eta_force = 0.0_wp
               call elastic_force(reduced, q(first:last), body%eta_force, body%s)
               body%eta_force = -body%eta_force
               if (reduced%damped) call add_damping(reduced, -1.0_wp, v(first:last), body%eta_force)
            end if
            if (reduced%is_exact .or. .not. inertial) cycle
            call velocity_forces(reduced, frame%u, frame%omega, q(first:last), v(first:last), body%force, body%eta_force)
            if (heavy) call gravity_forces(reduced, system%model%gravity, frame%u, q(first:last), body%force, body%eta_force)
         end associate
      end do
      do i = 1, size(system%loads)
         associate (load => system%loads(i)%item, force => work%loads(i)%force)
            force = 0.0_wp
            call load%add_force(work%kinematics, force)
            if (load%is_scaled) force = load%share*force
            do side = 1, size(load%bodies)
               call add_to_body(system, work, load%bodies(side), &
                  & force(load%offsets(side) + 1:load%offsets(side) + load%rates(side)))
            end do
         end associate
      end do
   end subroutine sum_given_forces

   !> Adds a load's forces, in the layout of a body's rates, to those of the body.
   pure subroutine add_to_body(system, work, body, force)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Index of the body, or `ground`
      integer, intent(in) :: body
      !> Forces (rates)
      real(wp), intent(in) :: force(:)
      integer :: k, rates
      if (body == ground) return
      rates = system%layout%rates(body)
      do k = 1, rates
         work%bodies(body)%force(k) = work%bodies(body)%force(k) + force(k)
      end do
      do k = 1, system%layout%n(body)
         work%bodies(body)%eta_force(k) = work%bodies(body)%eta_force(k) + force(rates + k)
      end do
   end subroutine add_to_body

   !> Residual of every constraint at the placed kinematics into work%phi; returns the largest, each relative to its scale.
   real(wp) function position_residual(system, work) result(largest)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      integer :: i
      largest = 0.0_wp
      do i = 1, size(system%constraints)
         call find_residual(system, work, i, largest)
      end do
      if (system%parted) largest = largest_of(system, work%phi)
   end function position_residual

   !> The same where all frames that hang or are driven are in their places: the constraints that place them are kept there, and
   !> have no residual.
   real(wp) function open_residual(system, work) result(largest)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      integer :: k
      largest = 0.0_wp
      work%phi = 0.0_wp
      do k = 1, size(system%tree%open)
         call find_residual(system, work, system%tree%open(k), largest)
      end do
      if (system%parted) largest = largest_of(system, work%phi)
   end function open_residual

   !> Residual of one constraint into work%phi.
   subroutine find_residual(system, work, which, largest)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Index of the constraint
      integer, intent(in) :: which
      !> Raised to its residual, relative to its scale
      real(wp), intent(inout) :: largest
      real(wp) :: worst
      integer :: k
      associate (item => system%constraints(which)%item)
         call item%residual(work%kinematics, work%phi(item%first:item%first + item%rows - 1))
         worst = 0.0_wp
         do k = item%first, item%first + item%rows - 1
            worst = max(worst, abs(work%phi(k)))
         end do
         largest = max(largest, worst/item%scale)
      end associate
   end subroutine find_residual

   !> The largest of complete residuals, each relative to its scale: where equations are sums of several constraints.
   pure real(wp) function largest_of(system, residuals) result(largest)
      type(system_type), intent(in) :: system
      !> Of all equations (nc)
      real(wp), intent(in) :: residuals(:)
      real(wp) :: worst
      integer :: i, k
      largest = 0.0_wp
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            worst = 0.0_wp
            do k = item%first, item%first + item%rows - 1
               worst = max(worst, abs(residuals(k)))
            end do
            largest = max(largest, worst/item%scale)
         end associate
      end do
   end function largest_of

   !> Label and residual of the constraint that is farthest from satisfied, for messages.
   subroutine worst_constraint(system, work, index, residual)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Index of the constraint
      integer, intent(out) :: index
      !> Norm of its residual [length, or 1 for angles]
      real(wp), intent(out) :: residual
      integer :: i
      real(wp) :: size_of, worst
      residual = position_residual(system, work)
      index = 0
      worst = -1.0_wp
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            size_of = norm2(work%phi(item%first:item%first + item%rows - 1))
            if (size_of/item%scale > worst) then
               index = i
               worst = size_of/item%scale
               residual = size_of
            end if
         end associate
      end do
   end subroutine worst_constraint

   !> Residual of the velocity equations into work%gamma (rate - Jacobian v); returns the largest, relative to its scale.
   !> Kinematics and Jacobians are those of q.
   real(wp) function velocity_residual(system, work, v) result(largest)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), contiguous, intent(in) :: v(:)
      call velocity_gaps(system, work, v)
      largest = largest_of(system, work%gamma)
   end function velocity_residual

   !> The same residual without a look at its size.
   subroutine velocity_gaps(system, work, v)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), contiguous, intent(in) :: v(:)
      integer :: i, side, body, at, first, n
      real(wp) :: rates(3)
      work%gamma = 0.0_wp
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            at = item%first - 1
            if (item%driven) call item%rate(work%kinematics, work%gamma(at + 1:at + item%rows))
            do side = 1, 2
               body = item%bodies(side)
               if (body == ground) cycle
               first = system%layout%q(body)
               ! No deflection moves the origin that a frame hangs at
               n = merge(0, system%layout%n(body), system%tree%joint(body) == i)
               rates = [v(first), v(first + 1), 0.0_wp]
               if (system%layout%framed(body)) rates(3) = cross(work%kinematics%frames(body)%u, v(first + 2:first + 3))
               call take_speed(item%rows, system%layout%n(body), n, work%jacobians(side, i)%z, work%jacobians(side, i)%eta, rates, &
                  & v(first + 4:), work%gamma(at + 1:))
            end do
         end associate
      end do
   end subroutine velocity_gaps

   !> Takes from rates the speed that a body gives constraint equations.
   pure subroutine take_speed(rows, columns, n, z, eta, rates, eta_rates, left)
      integer, intent(in) :: rows, columns
      !> Number of deflections that give any
      integer, intent(in) :: n
      real(wp), intent(in) :: z(rows, 3), eta(rows, columns), rates(3), eta_rates(n)
      real(wp), intent(inout) :: left(rows)
      integer :: row, k
      do row = 1, rows
         left(row) = left(row) - (z(row, 1)*rates(1) + z(row, 2)*rates(2) + z(row, 3)*rates(3))
      end do
      do k = 1, n
         do row = 1, rows
            left(row) = left(row) - eta(row, k)*eta_rates(k)
         end do
      end do
   end subroutine take_speed

   !> Power that drivers and loads put in, less what damping and the geometric force of the model k_g take, at the state of the
   !> last `accelerations`.
   real(wp) function input_power(system, work, q, v) result(power)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), contiguous, intent(in) :: q(:), v(:)
      integer :: i
      power = 0.0_wp
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            if (item%driven .and. item%part_of == 0) power = power - driver_loss(system, work, i)
         end associate
      end do
      do i = 1, size(system%loads)
         if (system%loads(i)%item%powered) call system%loads(i)%item%add_power(work%kinematics, power)
      end do
      do i = 1, size(work%bodies)
         if (system%model%bodies(i)%kind == body_flexible) power = power - body_loss(system, work, q, v, i)
      end do
   end function input_power

   !> The same at a state without accelerations, with the multipliers in work%lambda: places only what that needs.
   real(wp) function power_at(system, work, t, q, v) result(power)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      !> Coordinates and velocities (nq)
      real(wp), contiguous, intent(in) :: q(:), v(:)
      integer :: i, first
      if (system%loaded) then
         call place_frames(system%model, system%layout, t, q, work%kinematics)
         call move_frames(system%model, system%layout, q, v, work%kinematics)
      else
         call place_bodies(system%model, system%layout, t, q, work%kinematics)
      end if
      do i = 1, size(work%bodies)
         if (system%layout%n(i) == 0) cycle
         first = system%layout%q(i) + 4
         call find_tension(system%model%bodies(i)%reduced, q(first:first + system%layout%n(i) - 1), &
            & work%bodies(i)%s)
      end do
      power = input_power(system, work, q, v)
   end function power_at

   !> The parts of `input_power`, times a duration, added to sums: of each constraint, each load, each body.
   subroutine add_parts_of_power(system, work, q, v, duration, sums)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), contiguous, intent(in) :: q(:), v(:)
      real(wp), intent(in) :: duration
      !> (constraints + loads + bodies) [energy]
      real(wp), intent(inout) :: sums(:)
      real(wp) :: power
      integer :: i, k
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            if (item%driven .and. item%part_of == 0) sums(i) = sums(i) - duration*driver_loss(system, work, i)
         end associate
      end do
      k = size(system%constraints)
      do i = 1, size(system%loads)
         power = 0.0_wp
         call system%loads(i)%item%add_power(work%kinematics, power)
         sums(k + i) = sums(k + i) + duration*power
      end do
      k = k + size(system%loads)
      do i = 1, size(work%bodies)
         if (system%model%bodies(i)%kind == body_flexible) sums(k + i) = sums(k + i) - duration*body_loss(system, work, q, v, i)
      end do
   end subroutine add_parts_of_power

   !> Power that a driver takes.
   real(wp) function driver_loss(system, work, which) result(power)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Index of its constraint
      integer, intent(in) :: which
      integer :: last
      associate (item => system%constraints(which)%item)
         last = item%first + item%rows - 1
         call item%rate(work%kinematics, work%gamma(item%first:last))
         power = dot_product(work%lambda(item%first:last), work%gamma(item%first:last))
      end associate
   end function driver_loss

   !> Power that damping and the geometric force of the model k_g take in a flexible body; the accelerations have left its tension.
   real(wp) function body_loss(system, work, q, v, which) result(taken)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), contiguous, intent(in) :: q(:), v(:)
      !> Its index
      integer, intent(in) :: which
      integer :: first, last
      first = system%layout%q(which) + 4
      last = first + system%layout%n(which) - 1
      associate (body => work%bodies(which), reduced => system%model%bodies(which)%reduced)
         taken = tension_power(reduced, q(first:last), v(first:last), body%s)
         if (reduced%damped) taken = taken + damping_power(reduced, v(first:last))
      end associate
   end function body_loss

   !> Kinetic energy, and potential energy: of beams, weight and springs. In the model k_g the energy of a beam is that of K_E.
   !> Axes of exact beams that are placed at q are left moved with v; with loads, all kinematics are left placed at q.
   subroutine mechanical_energy(system, work, q, v, kinetic, potential)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Coordinates and velocities (nq)
      real(wp), contiguous, intent(in) :: q(:), v(:)
      real(wp), intent(out) :: kinetic, potential
      integer :: i, first, last
      real(wp) :: u(2), omega, elastic
      kinetic = 0.0_wp
      potential = 0.0_wp
      do i = 1, size(work%bodies)
         associate (reduced => system%model%bodies(i)%reduced)
            first = system%layout%q(i)
            if (system%layout%carries(i)) cycle
            if (.not. system%layout%framed(i)) then
               kinetic = kinetic + 0.5_wp*reduced%mass*dot_product(v(first:first + 1), v(first:first + 1))
               potential = potential - reduced%mass*dot_product(system%model%gravity, q(first:first + 1))
               cycle
            end if
            last = first + 3 + reduced%n
            u = q(first + 2:first + 3)
            omega = dot_product(turn(u), v(first + 2:first + 3))
            if (reduced%is_exact) then
               potential = potential - reduced%mass*dot_product(system%model%gravity, q(first:first + 1))
               associate (placed => work%kinematics%lines(findloc(work%kinematics%beams, i, dim=1)))
                  if (placed%is_at(q(first + 4:last))) then
                     call add_axis_energy(placed, system%model%gravity, u, omega, q(first:last), v(first:last), kinetic, potential)
                  else
                     call add_axis_energy(work%bodies(i)%line, system%model%gravity, u, omega, q(first:last), v(first:last), &
                        & kinetic, potential)
                  end if
               end associate
            else
               kinetic = kinetic + kinetic_energy(reduced, u, q(first + 4:last), v(first:first + 1), omega, v(first + 4:last))
               potential = potential + weight_potential(reduced, system%model%gravity, q(first:first + 1), u, q(first + 4:last))
            end if
            call elastic_energy(reduced, q(first + 4:last), elastic)
            potential = potential + elastic
         end associate
      end do
      if (size(system%loads) == 0) return
      call place_frames(system%model, system%layout, work%kinematics%time, q, work%kinematics)
      do i = 1, size(system%loads)
         call system%loads(i)%item%add_energy(work%kinematics, potential)
      end do
   end subroutine mechanical_energy

   !> Adds the kinetic energy of an exact beam, and that of its weight from the origin of its frame on.
   pure subroutine add_axis_energy(line, gravity, u, omega, q, v, kinetic, potential)
      !> Left at the state
      type(centreline_type), intent(inout) :: line
      !> Acceleration of gravity (2), unit vector of the frame (2), its angular velocity, coordinates and velocities of the body
      real(wp), intent(in) :: gravity(2), u(2), omega
      real(wp), contiguous, intent(in) :: q(:), v(:)
      real(wp), intent(inout) :: kinetic, potential
      call line%place_axis(q(5:))
      call line%move(v(5:))
      kinetic = kinetic + line%kinetic(along(v(1:2), [u(1), -u(2)]), omega, v(5:))
      potential = potential - dot_product(gravity, along(line%moment(), u))
   end subroutine add_axis_energy

end module limber_multibody_equations_of_motion
