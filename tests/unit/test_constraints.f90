!> Joints, drivers and the multiplier system: Jacobians and right-hand sides against differences of the residual along motions
!> that need not keep the constraints, the condensed solution against the whole matrix, powers and energy rates.
program test_constraints
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_base_lapack, only: dgetrf, dgetrs
   use limber_beam_exact_functions, only: exact_choice_type
   use limber_beam_beam_mesh, only: beam_type, concentrate, new_support
   use limber_beam_beam_reduction, only: fidelity_exact, fidelity_kg, fidelity_linear, reduction_type
   use limber_model_model, only: coordinate_angle, coordinate_displacement, driver_displacement, ground, model_type, &
      & term_type
   use limber_multibody_assembly, only: assemble, first_guess
   use limber_multibody_body, only: body_mass
   use limber_multibody_equations_of_motion, only: accelerations, input_power, linearise, mechanical_energy, &
      & position_residual, velocity_residual
   use limber_multibody_projection, only: project_position, project_velocity
   use limber_multibody_kinematics, only: move_frames, place_frames
   use limber_multibody_point_motion, only: point_acceleration, point_position, point_velocity
   use limber_multibody_multiplier_system, only: update_jacobians
   use limber_multibody_system, only: new_system, new_workspace, system_type, workspace_type
   use scenes, only: joint_revolute, joint_point_on_line, joint_sliding, joint_coupler, add_beam, add_beam_place, add_driver, &
      & add_force, add_joint, add_place, add_point_mass, add_rigid, &
      & derivative, empty_model, random, second_derivative, wavy_law
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   !> A motion q(t): every rate of every body with constant acceleration; angles instead of u
   type :: motion_type
      !> Layout of the rates: [r, angle, eta] of each body after another
      real(wp), allocatable :: value(:), rate(:), push(:)
   end type motion_type

   call test_derivatives(zoo(.false.))
   call test_points(zoo(.false.))
   call test_pendulum_force()
   call test_whole_matrix()
   call test_energy_rate(fidelity_linear)
   call test_energy_rate(fidelity_kg)
   call test_joint_power()
   call test_projection()
   call test_derivatives(zoo(.true.))
   call test_points(zoo(.true.))
   call finish()

contains

   !> A scene with every pairing of bodies and ground in every joint; it need not be one that can move.
   function zoo(exact) result(model)
      !> Whether one of the beams is an exact one
      logical, intent(in) :: exact
      type(model_type) :: model
      type(beam_type) :: beam
      type(reduction_type) :: choice
      type(error_type), allocatable :: error
      integer :: rod, arm, block, bead, a, b, c, d, e, f, g, h
      model = empty_model(1.5_wp)
      model%gravity = [0.4_wp, -9.81_wp]
      beam = beam_type(ea=4.0e3_wp, ei=2.0_wp, rho_a=0.9_wp, length=1.2_wp, elements=8)
      choice = reduction_type(support=new_support('PINNED-ROLLER'), bending=2, axial=1, geometric_elements=2, &
         & fidelity=fidelity_kg)
      rod = add_beam(model, 'rod', beam, choice, [0.1_wp, 0.2_wp], 0.4_wp, error)
      call check_no_error(error, 'rod')
      choice = reduction_type(support=new_support('CLAMPED-FREE'), bending=2, axial=1, geometric_elements=3, &
         & fidelity=merge(fidelity_exact, fidelity_kg, exact), origin=0.3_wp)
      choice%exact = exact_choice_type(angles=3, strains=2, support=choice%support, origin=0.3_wp, kinks=[0.8_wp], steps=[0.5_wp], &
         & corners=[real(wp) ::])
      ! Heavy, so that a unit of its coordinates is no more than a stencil can follow
      if (exact) beam%rho_a = 5000.0_wp
      if (exact) call concentrate(beam, 0.8_wp, 200.0_wp, 50.0_wp)
      arm = add_beam(model, 'arm', beam, choice, [-0.3_wp, 0.7_wp], -1.1_wp, error)
      call check_no_error(error, 'arm')
      block = add_rigid(model, 'block', 2.0_wp, 0.3_wp, [0.1_wp, -0.2_wp], [0.5_wp, 0.5_wp], 2.0_wp)
      bead = add_point_mass(model, 'bead', 0.7_wp, [1.0_wp, -0.4_wp])
      a = add_beam_place(model, 'rod.end', rod, 1.2_wp)
      b = add_beam_place(model, 'rod.middle', rod, 0.55_wp)
      c = add_beam_place(model, 'arm.tip', arm, 1.2_wp)
      d = add_beam_place(model, 'arm.start', arm, 0.0_wp)
      e = add_place(model, 'block.corner', block, [-0.4_wp, 0.25_wp])
      f = add_place(model, 'bead.origin', bead, [0.0_wp, 0.0_wp])
      g = add_place(model, 'ground.a', ground, [0.3_wp, -0.6_wp])
      h = add_place(model, 'ground.b', ground, [-0.2_wp, 0.9_wp])
      call add_joint(model, 'flexible-flexible', joint_revolute, a, c)
      call add_joint(model, 'flexible-ground', joint_revolute, b, g)
      call add_joint(model, 'ground-flexible', joint_revolute, h, d)
      call add_joint(model, 'bead-rigid', joint_revolute, f, e)
      call add_joint(model, 'rigid-bead', joint_revolute, e, f)
      call add_joint(model, 'same body', joint_revolute, a, b)
      call add_joint(model, 'flexible on flexible', joint_point_on_line, b, c, 0.7_wp)
      call add_joint(model, 'flexible on ground', joint_point_on_line, a, g, -0.4_wp)
      call add_joint(model, 'ground on flexible', joint_point_on_line, h, b, 1.9_wp)
      call add_joint(model, 'bead on rigid', joint_point_on_line, f, e, 0.3_wp)
      call add_joint(model, 'bead on ground', joint_point_on_line, f, g, 0.0_wp)
      call add_joint(model, 'rigid on bead', joint_point_on_line, e, f, 1.1_wp)
      call add_joint(model, 'on its own line', joint_point_on_line, a, d, 2.5_wp)
      if (exact) call add_joint(model, 'along the exact beam', joint_sliding, f, c)
      call add_driver(model, 'drive rod', rod, wavy_law(0.2_wp, 1.3_wp, 0.4_wp, 2.1_wp))
      call add_driver(model, 'drive block', block, wavy_law(2.9_wp, -0.7_wp, 0.6_wp, -1.4_wp))
      if (exact) call move_along(model, size(model%joints))
   end function zoo

   !> A driver of a coordinate along the exact beam, and a coupler of it and of an angle.
   subroutine move_along(model, joint)
      type(model_type), intent(inout) :: model
      !> Its index
      integer, intent(in) :: joint
      call add_driver(model, 'creep', 0, wavy_law(0.2_wp, 1.3_wp, 0.4_wp, 2.1_wp))
      model%drivers(size(model%drivers))%kind = driver_displacement
      model%drivers(size(model%drivers))%joint = joint
      call add_joint(model, 'thread', joint_coupler, 0, 0)
      model%joints(size(model%joints))%terms = [term_type(1.2_wp, coordinate_angle, 1), term_type(0.7_wp, &
         & coordinate_displacement, joint)]
   end subroutine move_along

   !> Every coordinate random, deflections of a tenth of the length.
   function random_motion(system) result(motion)
      type(system_type), intent(in) :: system
      type(motion_type) :: motion
      integer :: i, k, at
      at = 0
      allocate (motion%value(sum(system%layout%rates + system%layout%n)))
      allocate (motion%rate(size(motion%value)), motion%push(size(motion%value)))
      do i = 1, size(system%layout%q)
         do k = 1, system%layout%rates(i)
            at = at + 1
            motion%value(at) = random()
            motion%rate(at) = random()
            motion%push(at) = random()
         end do
         do k = 1, system%layout%n(i)
            at = at + 1
            motion%value(at) = 0.1_wp*random()
            motion%rate(at) = random()
            motion%push(at) = random()
         end do
      end do
   end function random_motion

   !> q and v of a motion at a time; its accelerations, if asked for.
   subroutine at_time(system, motion, t, q, v, a)
      type(system_type), intent(in) :: system
      type(motion_type), intent(in) :: motion
      real(wp), intent(in) :: t
      real(wp), intent(out) :: q(:), v(:)
      real(wp), intent(out), optional :: a(:)
      real(wp) :: x(size(motion%value)), speed(size(motion%value)), u(2), normal(2)
      integer :: i, at, first, n
      x = motion%value + motion%rate*t + motion%push*t**2/2
      speed = motion%rate + motion%push*t
      at = 0
      do i = 1, size(system%layout%q)
         first = system%layout%q(i)
         n = system%layout%n(i)
         q(first:first + 1) = x(at + 1:at + 2)
         v(first:first + 1) = speed(at + 1:at + 2)
         if (present(a)) a(first:first + 1) = motion%push(at + 1:at + 2)
         if (system%layout%framed(i)) then
            u = [cos(x(at + 3)), sin(x(at + 3))]
            normal = [-u(2), u(1)]
            q(first + 2:first + 3) = u
            v(first + 2:first + 3) = speed(at + 3)*normal
            if (present(a)) a(first + 2:first + 3) = motion%push(at + 3)*normal - speed(at + 3)**2*u
            q(first + 4:first + 3 + n) = x(at + 4:at + 3 + n)
            v(first + 4:first + 3 + n) = speed(at + 4:at + 3 + n)
            if (present(a)) a(first + 4:first + 3 + n) = motion%push(at + 4:at + 3 + n)
         end if
         at = at + system%layout%rates(i) + n
      end do
   end subroutine at_time

   !> Residuals of all constraints at (t, q).
   subroutine residuals(system, work, t, q, phi)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t, q(:)
      real(wp), intent(out) :: phi(:)
      real(wp) :: largest
      call place_frames(system%model, system%layout, t, q, work%kinematics)
      largest = position_residual(system, work)
      phi = work%phi
      call check(largest >= maxval(abs(phi))/max(1.5_wp, system%model%length)*(1 - 1.0e-15_wp), 'the largest residual')
   end subroutine residuals

   !> Jacobian of all constraints on all rates as one matrix, from the workspace.
   function whole_jacobian(system, work) result(matrix)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      real(wp), allocatable :: matrix(:, :)
      integer :: i, side, body, first, row, rates
      allocate (matrix(system%nc, sum(system%layout%rates + system%layout%n)))
      matrix = 0.0_wp
      do i = 1, size(system%constraints)
         row = system%constraints(i)%item%first
         do side = 1, 2
            body = system%constraints(i)%item%bodies(side)
            if (body == ground) cycle
            first = sum(system%layout%rates(:body - 1) + system%layout%n(:body - 1))
            rates = system%layout%rates(body)
            associate (rows => matrix(row:row + system%constraints(i)%item%rows - 1, :), j => work%jacobians(side, i))
               rows(:, first + 1:first + rates) = rows(:, first + 1:first + rates) + j%z(:, :rates)
               rows(:, first + rates + 1:first + rates + system%layout%n(body)) = &
                  & rows(:, first + rates + 1:first + rates + system%layout%n(body)) + j%eta
            end associate
         end do
      end do
   end function whole_jacobian

   !> Jacobian by a stencil in every coordinate; velocity and acceleration equations along a motion, which breaks all
   !> constraints, so that every term counts.
   subroutine test_derivatives(model)
      type(model_type), intent(in) :: model
      type(system_type) :: system
      type(workspace_type) :: work
      type(motion_type) :: motion, moved
      real(wp), allocatable :: phi(:, :), q(:), v(:), jacobian(:, :), slope(:), expected(:)
      real(wp), parameter :: h = 2.0e-3_wp, still = 0.0_wp
      real(wp) :: t, largest
      integer :: trial, k, j, i, row
      system = new_system(model)
      call new_workspace(system, work)
      allocate (phi(system%nc, -2:2), q(system%layout%nq), v(system%layout%nq), expected(system%nc), slope(system%nc))
      do trial = 1, 4
         motion = random_motion(system)
         t = random()
         call at_time(system, motion, still, q, v)
         call place_frames(system%model, system%layout, t, q, work%kinematics)
         call update_jacobians(system, work)
         jacobian = whole_jacobian(system, work)
         do j = 1, size(motion%value)
            do k = -2, 2
               moved = motion
               moved%value(j) = moved%value(j) + k*h
               call at_time(system, moved, still, q, v)
               call residuals(system, work, t, q, phi(:, k))
            end do
            slope = derivative(phi(:, -2), phi(:, -1), phi(:, 1), phi(:, 2), h)
            ! Where a point far from a bent beam has its foot the stencil is not as exact
            call check_rows(system, slope, jacobian(:, j), merge(1.0e-10_wp, 1.0e-11_wp, system%exact), 'Jacobian')
         end do

         do k = -2, 2
            call at_time(system, motion, k*h, q, v)
            call residuals(system, work, t + k*h, q, phi(:, k))
         end do
         call at_time(system, motion, still, q, v)
         call place_frames(system%model, system%layout, t, q, work%kinematics)
         call move_frames(system%model, system%layout, q, v, work%kinematics)
         call update_jacobians(system, work)
         ! d phi/dt = B rates - rate of the constraint
         slope = derivative(phi(:, -2), phi(:, -1), phi(:, 1), phi(:, 2), h)
         largest = velocity_residual(system, work, v)
         call check_rows(system, slope, -work%gamma, 1.0e-9_wp, 'velocity equation')
         call check(largest > 0.01_wp, 'the motion breaks the constraints')
         do i = 1, size(system%constraints)
            row = system%constraints(i)%item%first
            call system%constraints(i)%item%rate(work%kinematics, expected(row:row + system%constraints(i)%item%rows - 1))
         end do
         call check_rows(system, slope, matmul(jacobian, motion%rate) - expected, 1.0e-9_wp, 'rate')
         ! d2 phi/dt2 = B accelerations - gamma
         slope = second_derivative(phi(:, -2), phi(:, -1), phi(:, 0), phi(:, 1), phi(:, 2), h)
         do i = 1, size(system%constraints)
            row = system%constraints(i)%item%first
            call system%constraints(i)%item%gamma(work%kinematics, expected(row:row + system%constraints(i)%item%rows - 1))
         end do
         call check_rows(system, slope, matmul(jacobian, motion%push) - expected, 2.0e-8_wp, 'gamma')
      end do
   end subroutine test_derivatives

   !> Compares a value for every row; names the constraint.
   subroutine check_rows(system, value, expected, tolerance, name)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: value(:), expected(:), tolerance
      character(*), intent(in) :: name
      integer :: i, row
      do i = 1, size(system%constraints)
         do row = system%constraints(i)%item%first, system%constraints(i)%item%first + system%constraints(i)%item%rows - 1
            call check_close(value(row), expected(row), tolerance*(1 + abs(expected(row))), &
               & name//' of '//system%constraints(i)%item%label)
         end do
      end do
   end subroutine check_rows

   !> Position, velocity and acceleration of points against the stencil; also through the markers.
   subroutine test_points(model)
      type(model_type), intent(in) :: model
      type(system_type) :: system
      type(workspace_type) :: work
      type(motion_type) :: motion
      real(wp), allocatable :: q(:), v(:), a(:)
      real(wp) :: x(2, -2:2), acceleration(2)
      real(wp), parameter :: h = 2.0e-3_wp
      integer :: i, k, m
      system = new_system(model)
      call new_workspace(system, work)
      allocate (q(system%layout%nq), v(system%layout%nq), a(system%layout%nq))
      motion = random_motion(system)
      do i = 1, size(system%model%points)
         if (system%model%points(i)%direction) cycle
         do k = -2, 2
            call at_time(system, motion, k*h, q, v)
            x(:, k) = point_position(system%model, system%layout, system%model%points(i), q)
         end do
         call at_time(system, motion, 0.0_wp, q, v, a)
         call check(maxval(abs(derivative(x(:, -2), x(:, -1), x(:, 1), x(:, 2), h) &
            & - point_velocity(system%model, system%layout, system%model%points(i), q, v))) <= 1.0e-9_wp, 'velocity of a point')
         acceleration = point_acceleration(system%model, system%layout, system%model%points(i), q, v, a)
         call check(maxval(abs(second_derivative(x(:, -2), x(:, -1), x(:, 0), x(:, 1), x(:, 2), h) - acceleration)) &
            & <= 2.0e-8_wp*(1 + maxval(abs(acceleration))), 'acceleration of a point')
         call place_frames(system%model, system%layout, 0.0_wp, q, work%kinematics)
         call move_frames(system%model, system%layout, q, v, work%kinematics)
         do m = 1, size(work%kinematics%markers)
            associate (marker => work%kinematics%markers(m))
               if (marker%point /= i) cycle
               call check(maxval(abs(marker%position - x(:, 0))) <= 4.0e-15_wp, 'position of a marker')
               call check(maxval(abs(marker%velocity - point_velocity(system%model, system%layout, system%model%points(i), q, v))) &
                  & <= 1.0e-14_wp, 'velocity of a marker')
            end associate
         end do
      end do
   end subroutine test_points

   !> The sign and size of multipliers: -B^T lambda acts on the body. Lowest point of a pendulum at speed s: the pin pulls up
   !> with m (g + s^2/L); at the horizontal, at rest, it pulls with nothing.
   subroutine test_pendulum_force()
      type(model_type) :: model
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      real(wp), parameter :: g = 9.81_wp, mass = 3.0_wp, length = 0.8_wp, speed = 1.7_wp
      real(wp) :: q(4), v(4), a(4)
      integer :: body, pin, fixed
      model = empty_model(length)
      model%gravity = [0.0_wp, -g]
      body = add_rigid(model, 'bob', mass, 0.0_wp, [length, 0.0_wp], [0.0_wp, 0.0_wp], 0.0_wp)
      pin = add_place(model, 'bob.pin', body, [0.0_wp, 0.0_wp])
      fixed = add_place(model, 'ground.pin', ground, [0.0_wp, 0.0_wp])
      call add_joint(model, 'pin', joint_revolute, pin, fixed)
      system = new_system(model)
      call new_workspace(system, work)
      q = [0.0_wp, 0.0_wp, 0.0_wp, -1.0_wp]
      v = [0.0_wp, 0.0_wp, speed/length, 0.0_wp]
      call linearise(system, work, 0.0_wp, q, error)
      call check_no_error(error, 'pendulum')
      call accelerations(system, work, q, v, a)
      call check(maxval(abs(-work%lambda - [0.0_wp, mass*(g + speed**2/length)])) <= 1.0e-13_wp*mass*g, 'the pin holds the bob')
      call check(maxval(abs(a - [0.0_wp, 0.0_wp, 0.0_wp, speed**2/length**2])) <= 1.0e-13_wp*g, &
         & 'the pin stays and u turns at constant speed')
      q = [0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp]
      v = 0.0_wp
      call linearise(system, work, 0.0_wp, q, error)
      call accelerations(system, work, q, v, a)
      call check(maxval(abs(work%lambda)) <= 1.0e-13_wp*mass*g, 'no force on a pin beside a falling bob')
      call check(maxval(abs(a - [0.0_wp, 0.0_wp, 0.0_wp, -g/length])) <= 1.0e-13_wp*g, 'the bob falls')
   end subroutine test_pendulum_force

   !> A driven slider-crank with a flexible rod, a point mass as slider, and forces on both.
   function slider_crank(fidelity, driven) result(model)
      integer, intent(in) :: fidelity
      logical, intent(in) :: driven
      type(model_type) :: model
      type(beam_type) :: beam
      type(reduction_type) :: choice
      type(error_type), allocatable :: error
      integer :: crank, rod, slider, pin, a, b, c, d, e, middle
      model = empty_model(0.5_wp)
      model%gravity = [0.0_wp, -9.81_wp]
      beam = beam_type(ea=5.0e4_wp, ei=1.2_wp, rho_a=0.6_wp, length=0.5_wp, elements=12)
      choice = reduction_type(support=new_support('PINNED-ROLLER'), bending=3, axial=3, geometric_elements=3, &
         & fidelity=fidelity, origin=0.1_wp)
      crank = add_rigid(model, 'crank', 0.4_wp, 2.0e-3_wp, [0.1_wp, 0.01_wp], [0.0_wp, 0.0_wp], 0.9_wp)
      rod = add_beam(model, 'rod', beam, choice, [0.2_wp, 0.1_wp], -0.3_wp, error)
      call check_no_error(error, 'rod')
      slider = add_point_mass(model, 'slider', 0.3_wp, [0.6_wp, 0.0_wp])
      pin = add_place(model, 'ground.pin', ground, [0.0_wp, 0.0_wp])
      a = add_place(model, 'crank.axle', crank, [0.0_wp, 0.0_wp])
      b = add_place(model, 'crank.pin', crank, [0.2_wp, 0.0_wp])
      c = add_beam_place(model, 'rod.start', rod, 0.0_wp)
      d = add_beam_place(model, 'rod.end', rod, 0.5_wp)
      e = add_place(model, 'slider.origin', slider, [0.0_wp, 0.0_wp])
      middle = add_beam_place(model, 'rod.middle', rod, 0.23_wp)
      call add_joint(model, 'axle', joint_revolute, a, pin)
      call add_joint(model, 'crank-pin', joint_revolute, c, b)
      call add_joint(model, 'wrist-pin', joint_revolute, d, e)
      call add_joint(model, 'slide', joint_point_on_line, e, pin, 0.05_wp)
      if (.not. driven) return
      call add_driver(model, 'motor', crank, wavy_law(0.9_wp, 4.0_wp, 0.3_wp, 5.0_wp))
      call add_force(model, middle, wavy_law(0.2_wp, 0.1_wp, 2.0_wp, 3.0_wp), wavy_law(-1.0_wp, 0.0_wp, 1.0_wp, 2.0_wp))
      call add_force(model, e, wavy_law(3.0_wp, 0.0_wp, 0.0_wp, 1.0_wp), wavy_law(0.5_wp, 0.0_wp, 0.0_wp, 1.0_wp))
   end function slider_crank

   !> A consistent state of a slider-crank that moves and vibrates.
   subroutine prepare(fidelity, driven, t, system, work, q, v)
      integer, intent(in) :: fidelity
      logical, intent(in) :: driven
      real(wp), intent(in) :: t
      type(system_type), intent(out) :: system
      type(workspace_type), intent(out) :: work
      real(wp), allocatable, intent(out) :: q(:), v(:)
      type(error_type), allocatable :: error
      real(wp), allocatable :: change(:)
      real(wp) :: before, residual
      integer :: culprit, i, first, round
      system = new_system(slider_crank(fidelity, driven))
      call new_workspace(system, work)
      allocate (q(system%layout%nq), v(system%layout%nq), change(system%layout%nq))
      call first_guess(system, t, q, v)
      call assemble(system, work, t, q, v, error, culprit)
      call check_no_error(error, 'slider-crank')
      first = system%layout%q(2) + 4
      do i = first, first + 2
         q(i) = 2.0e-2_wp*(1.0_wp + random())
         v(i) = random()
         q(i + 3) = 2.0e-4_wp*random()
         v(i + 3) = 0.3_wp*random()
      end do
      v(:2) = 0.0_wp
      if (.not. driven) v(3:4) = 3.0_wp*[-q(4), q(3)]
      do round = 1, 4
         call linearise(system, work, t, q, error)
         call check_no_error(error, 'slider-crank')
         call project_position(system, work, t, q, change, .false., 6, 1.0e-16_wp, before, residual, error)
      end do
      call linearise(system, work, t, q, error)
      do round = 1, 2
         call project_velocity(system, work, v, change, residual)
      end do
      call check(position_residual(system, work) <= 1.0e-15_wp, 'a consistent position')
      call check(velocity_residual(system, work, v) <= 1.0e-13_wp, 'consistent velocities')
   end subroutine prepare

   !> The condensed solution solves the whole system, eq. (4.1), at a consistent state and, with the pivots of one workspace, at
   !> any other one: in every position of the crank, and with deflections and speeds that are far off.
   subroutine test_whole_matrix()
      type(system_type) :: system
      type(workspace_type) :: work
      type(motion_type) :: motion
      real(wp), allocatable :: q(:), v(:)
      integer :: i
      call prepare(fidelity_linear, .true., 0.3_wp, system, work, q, v)
      call compare_whole(system, work, 0.3_wp, q, v)
      do i = 1, 100
         motion = random_motion(system)
         motion%value(3) = 0.063_wp*i
         call at_time(system, motion, 0.0_wp, q, v)
         call compare_whole(system, work, 0.063_wp*i, q, v)
      end do
   end subroutine test_whole_matrix

   !> Accelerations and multipliers against the whole system, whose mass matrix is put together here.
   subroutine compare_whole(system, work, t, q, v)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t, q(:), v(:)
      type(error_type), allocatable :: error
      real(wp), allocatable :: a(:), matrix(:, :), unknown(:), rest(:), coupling(:, :)
      real(wp) :: u(2), frame(3, 3), scale
      integer :: i, k, first, at, n, rates
      n = sum(system%layout%rates + system%layout%n)
      allocate (matrix(n + system%nc, n + system%nc), unknown(n + system%nc), rest(n + system%nc), a(size(q)))
      call linearise(system, work, t, q, error)
      call check_no_error(error, 'the multiplier system')
      call accelerations(system, work, q, v, a)
      matrix = 0.0_wp
      at = 0
      do i = 1, size(system%layout%q)
         first = system%layout%q(i)
         rates = system%layout%rates(i)
         unknown(at + 1:at + 2) = a(first:first + 1)
         rest(at + 1:at + rates) = work%bodies(i)%force(:rates)
         if (system%layout%framed(i)) then
            u = q(first + 2:first + 3)
            unknown(at + 3) = u(1)*a(first + 3) - u(2)*a(first + 2)
            allocate (coupling(system%layout%n(i), 3))
            associate (k_eta => system%layout%n(i))
               call body_mass(system%model%bodies(i)%reduced, u, q(first + 4:first + 3 + k_eta), frame, coupling)
               matrix(at + 1:at + 3, at + 1:at + 3) = frame
               matrix(at + 4:at + 3 + k_eta, at + 1:at + 3) = coupling
               matrix(at + 1:at + 3, at + 4:at + 3 + k_eta) = transpose(coupling)
               do k = at + 4, at + 3 + k_eta
                  matrix(k, k) = 1.0_wp
               end do
               unknown(at + 4:at + 3 + k_eta) = a(first + 4:first + 3 + k_eta)
               rest(at + 4:at + 3 + k_eta) = work%bodies(i)%eta_force
            end associate
            deallocate (coupling)
         else
            matrix(at + 1, at + 1) = system%model%bodies(i)%reduced%mass
            matrix(at + 2, at + 2) = matrix(at + 1, at + 1)
         end if
         at = at + rates + system%layout%n(i)
      end do
      unknown(n + 1:) = work%lambda
      rest(n + 1:) = work%gamma
      matrix(n + 1:, :n) = whole_jacobian(system, work)
      matrix(:n, n + 1:) = transpose(matrix(n + 1:, :n))
      scale = maxval(matmul(abs(matrix), abs(unknown)))
      call check(maxval(abs(matmul(matrix, unknown) - rest)) <= 1.0e-13_wp*scale, 'the condensed solution solves the whole system')
      call check(maxval(abs(rest)) > 1.0e-3_wp*scale, 'there are forces')
      call solve(matrix, rest)
      call check(maxval(abs(rest(:n) - unknown(:n))) <= 1.0e-10_wp*maxval(abs(unknown(:n))), 'accelerations by the whole system')
      call check(maxval(abs(rest(n + 1:) - unknown(n + 1:))) <= 1.0e-10_wp*maxval(abs(unknown(n + 1:))), &
         & 'multipliers by the whole system')
   end subroutine compare_whole

   subroutine solve(matrix, rhs)
      real(wp), intent(inout) :: matrix(:, :), rhs(:)
      integer :: pivots(size(rhs)), info
      call dgetrf(size(rhs), size(rhs), matrix, size(rhs), pivots, info)
      call check(info == 0, 'the whole system is regular')
      call dgetrs('N', size(rhs), 1, matrix, size(rhs), pivots, rhs, size(rhs), info)
   end subroutine solve

   !> The power put in is the rate of the mechanical energy: along q + v t + a t^2/2 with v + a t the energy's slope at t = 0
   !> needs no higher derivatives. Kinetic and elastic energy, weight, accelerations, multipliers and loads all enter.
   subroutine test_energy_rate(fidelity)
      integer, intent(in) :: fidelity
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:), a(:)
      real(wp) :: energy(-2:2), kinetic, potential, power, h, scale, t
      logical :: driven
      integer :: k, trial
      do trial = 1, 6
         driven = trial > 2
         t = 0.2_wp*trial
         call prepare(fidelity, driven, t, system, work, q, v)
         allocate (a(size(q)))
         call check(system%powered .eqv. (driven .or. fidelity == fidelity_kg), 'a system is powered or not')
         call linearise(system, work, t, q, error)
         call accelerations(system, work, q, v, a)
         power = input_power(system, work, q, v)
         ! The fastest coordinate has 1e4 rad/s
         h = 1.0e-6_wp
         do k = -2, 2
            call mechanical_energy(system, work, q + v*(k*h) + a*(k*h)**2/2, v + a*(k*h), kinetic, potential)
            energy(k) = kinetic + potential
         end do
         ! Power of the inertia of single coordinates, that cancels; and round-off of the energy over h
         scale = sum(abs(a(5:)*v(5:)))
         call check_close(derivative(energy(-2), energy(-1), energy(1), energy(2), h), power, &
            & 1.0e-9_wp*scale + 1.0e-15_wp*abs(kinetic)/h, 'power is the rate of the energy')
         if (.not. driven .and. fidelity == fidelity_linear) call check_close(power, 0.0_wp, 0.0_wp, 'nothing puts energy in')
         if (driven) call check(abs(power) > 1.0e-2_wp, 'the motor works')
         if (driven) call check(abs(power) > 1.0e-6_wp*scale, 'the motor can be seen')
         deallocate (a)
      end do
   end subroutine test_energy_rate

   !> The forces -B^T lambda of the joints do no work on a consistent motion, and are not nothing.
   subroutine test_joint_power()
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:), a(:), jacobian(:, :), rates(:)
      real(wp) :: each, total
      integer :: i, first, row
      call prepare(fidelity_linear, .false., 0.0_wp, system, work, q, v)
      allocate (a(size(q)), rates(sum(system%layout%rates + system%layout%n)))
      call linearise(system, work, 0.0_wp, q, error)
      call accelerations(system, work, q, v, a)
      jacobian = whole_jacobian(system, work)
      row = 0
      do i = 1, size(system%layout%q)
         first = system%layout%q(i)
         rates(row + 1:row + 2) = v(first:first + 1)
         if (system%layout%framed(i)) then
            rates(row + 3) = q(first + 2)*v(first + 3) - q(first + 3)*v(first + 2)
            rates(row + 4:row + 3 + system%layout%n(i)) = v(first + 4:first + 3 + system%layout%n(i))
         end if
         row = row + system%layout%rates(i) + system%layout%n(i)
      end do
      total = -dot_product(matmul(work%lambda, jacobian), rates)
      each = sum(abs(matmul(work%lambda, jacobian)*rates))
      call check(each > 1.0_wp, 'the joints do work on each body')
      call check_close(total, 0.0_wp, 1.0e-13_wp*each, 'the joints do no work in all')
   end subroutine test_joint_power

   !> Projections reach round-off from small errors, are the least change in the mass norm, and leave a good state alone.
   subroutine test_projection()
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:), good(:), change(:), speed(:)
      real(wp) :: before, residual
      integer :: i
      call prepare(fidelity_linear, .true., 0.4_wp, system, work, q, v)
      allocate (change(size(q)))
      good = q
      call linearise(system, work, 0.4_wp, q, error)
      call project_position(system, work, 0.4_wp, q, change, .false., 6, 1.0e-14_wp, before, residual, error)
      call check(maxval(abs(q - good)) <= 4.0e-16_wp, 'a good position is left alone')
      do i = 1, size(q)
         q(i) = q(i) + 1.0e-5_wp*random()
      end do
      call linearise(system, work, 0.4_wp, q, error)
      call project_position(system, work, 0.4_wp, q, change, .false., 6, 1.0e-14_wp, before, residual, error)
      call check(residual <= 1.0e-14_wp, 'positions are projected')
      call check(maxval(abs(q - good)) <= 1.0e-4_wp, 'not far')
      call check(abs(norm2(q(3:4)) - 1) <= 2.5e-16_wp, 'u has unit length')
      call linearise(system, work, 0.4_wp, q, error)
      do i = 1, size(v)
         v(i) = v(i) + 0.1_wp*random()
      end do
      call project_velocity(system, work, v, change, residual)
      call check(residual > 1.0e-3_wp, 'velocities were wrong')
      call check(velocity_residual(system, work, v) <= 1.0e-13_wp, 'velocities are projected')
      call check(abs(dot_product(q(3:4), v(3:4))) <= 1.0e-15_wp, 'u'' is square to u')
      speed = v
      call project_velocity(system, work, v, change, residual)
      call check(maxval(abs(speed - v)) <= 1.0e-12_wp, 'good velocities are left alone')
   end subroutine test_projection

end program test_constraints
