!> What implicit integrators are given: the residual of the equations of motion against the explicit solution and against
!> energies, all its derivatives against differences, and what combines and multiplies them. At random states that need not keep
!> the constraints, so that no term can hide behind one that vanishes.
program test_tangent
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_beam_elastic_forces, only: elastic_force, elastic_tangent
   use limber_beam_frame_reduction, only: frame_choice_type
   use limber_beam_exact_functions, only: exact_choice_type
   use limber_beam_beam_mesh, only: beam_type, concentrate, new_support
   use limber_beam_beam_reduction, only: fidelity_exact, fidelity_kg, fidelity_linear, reduction_type
   use limber_model_model, only: ground, model_type
   use limber_multibody_equations_of_motion, only: accelerations, linearise, mechanical_energy, position_residual, velocity_residual
   use limber_multibody_kinematics, only: place_frames
   use limber_multibody_layout, only: advance, rates_of, velocities_of
   use limber_multibody_motion_residual, only: linearise_motion, motion_residual
   use limber_multibody_system, only: new_system, new_workspace, system_type, workspace_type
   use limber_multibody_tangent, only: combine, combine_complex, new_tangent, tangent_type
   use limber_multibody_tangent_products, only: times_mass, times_stiffness
   use scenes, only: joint_revolute, joint_point_on_line, add_beam, add_beam_place, add_driver, add_force, add_frame, &
      & add_frame_place, add_joint, add_place, &
      & add_point_mass, add_rigid, derivative, empty_model, l_frame, random, slider_crank, wavy_law
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   !> Step of the stencils, of order four; polynomials and sines of it are exact to 1e-12. What differences may be off besides,
   !> relative to the largest entry of each row, is for rows that are small themselves
   real(wp), parameter :: step = 1.0e-3_wp, close = 1.0e-10_wp
   real(wp), parameter :: t = 0.37_wp
   real(wp), parameter :: nought = 0.0_wp, one = 1.0_wp

   !> A state that keeps no constraint
   type :: state_type
      real(wp), allocatable :: q(:), v(:), w(:), a(:), lambda(:)
   end type state_type

   call test_scene('slider-crank, rigid', crank_with(0))
   call test_scene('slider-crank, linear', crank_with(fidelity_linear))
   call test_scene('slider-crank, k_g', crank_with(fidelity_kg))
   call test_scene('a moving line', moving_line())
   call test_scene('every pairing', zoo(.false.))
   call test_scene('loads', loaded())
   call test_scene('frame, linear', framed(fidelity_linear))
   call test_scene('frame, k_g', framed(fidelity_kg))
   call test_elastic(fidelity_linear)
   call test_elastic(fidelity_kg)
   call test_scene('every pairing, exact', zoo(.true.))
   call finish()

contains

   function crank_with(fidelity) result(model)
      integer, intent(in) :: fidelity
      type(model_type) :: model
      type(error_type), allocatable :: error
      call slider_crank(fidelity, 5.0e2_wp, model, error)
      call check_no_error(error, 'slider-crank')
   end function crank_with

   !> Points on a line that a rigid body carries: of a mass, of another body, of the ground.
   function moving_line() result(model)
      type(model_type) :: model
      integer :: arm, block, bead, slot, corner, here
      model = empty_model(1.5_wp)
      model%gravity = [0.4_wp, -9.81_wp]
      arm = add_rigid(model, 'arm', 1.3_wp, 0.2_wp, [0.3_wp, 0.1_wp], [0.1_wp, 0.2_wp], 0.4_wp)
      block = add_rigid(model, 'block', 2.0_wp, 0.3_wp, [0.1_wp, -0.2_wp], [0.5_wp, 0.5_wp], 2.0_wp)
      bead = add_point_mass(model, 'bead', 0.7_wp, [1.0_wp, -0.4_wp])
      slot = add_place(model, 'arm.slot', arm, [0.2_wp, -0.3_wp])
      corner = add_place(model, 'block.corner', block, [-0.4_wp, 0.25_wp])
      here = add_place(model, 'ground.here', ground, [0.3_wp, -0.6_wp])
      call add_joint(model, 'bead on arm', joint_point_on_line, add_place(model, 'bead', bead, [0.0_wp, 0.0_wp]), slot, 0.6_wp)
      call add_joint(model, 'block on arm', joint_point_on_line, corner, slot, -1.3_wp)
      call add_joint(model, 'ground on arm', joint_point_on_line, here, slot, 2.2_wp)
      call add_joint(model, 'arm on ground', joint_point_on_line, slot, here, 0.3_wp)
      call add_driver(model, 'motor', arm, wavy_law(0.2_wp, 1.3_wp, 0.4_wp, 2.1_wp))
   end function moving_line

   !> Every pairing of bodies and ground in every joint.
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
      if (exact) beam%rho_a = 500.0_wp
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
      call add_joint(model, 'flexible on flexible', joint_point_on_line, b, c, 0.7_wp)
      call add_joint(model, 'flexible on rigid', joint_point_on_line, a, e, -0.9_wp)
      call add_joint(model, 'flexible on ground', joint_point_on_line, a, g, -0.4_wp)
      call add_joint(model, 'ground on flexible', joint_point_on_line, h, b, 1.9_wp)
      call add_joint(model, 'bead on rigid', joint_point_on_line, f, e, 0.3_wp)
      call add_joint(model, 'bead on ground', joint_point_on_line, f, g, 0.0_wp)
      call add_driver(model, 'drive rod', rod, wavy_law(0.2_wp, 1.3_wp, 0.4_wp, 2.1_wp))
      call add_driver(model, 'drive block', block, wavy_law(2.9_wp, -0.7_wp, 0.6_wp, -1.4_wp))
   end function zoo

   !> Dead forces that turn a rigid body, bend a beam and push a mass; no joints at all.
   function loaded() result(model)
      type(model_type) :: model
      type(reduction_type) :: choice
      type(error_type), allocatable :: error
      integer :: beam, block, bead
      model = empty_model(1.2_wp)
      choice = reduction_type(support=new_support('FREE-FREE'), bending=2, axial=2, geometric_elements=3, &
         & fidelity=fidelity_linear, origin=0.3_wp)
      beam = add_beam(model, 'beam', beam_type(ea=4.0e3_wp, ei=2.0_wp, rho_a=0.9_wp, length=1.2_wp, elements=8), choice, &
         & [0.1_wp, 0.2_wp], 0.4_wp, error)
      call check_no_error(error, 'beam')
      block = add_rigid(model, 'block', 2.0_wp, 0.3_wp, [0.1_wp, -0.2_wp], [0.5_wp, 0.5_wp], 2.0_wp)
      bead = add_point_mass(model, 'bead', 0.7_wp, [1.0_wp, -0.4_wp])
      call add_force(model, add_beam_place(model, 'beam.place', beam, 0.9_wp), wavy_law(3.0_wp, 0.0_wp, 2.0_wp, 3.0_wp), &
         & wavy_law(-1.0_wp, 7.0_wp, 0.0_wp, 0.0_wp))
      call add_force(model, add_place(model, 'block.corner', block, [-0.4_wp, 0.25_wp]), &
         & wavy_law(-5.0_wp, 0.0_wp, 0.0_wp, 0.0_wp), wavy_law(4.0_wp, 1.0_wp, 0.0_wp, 0.0_wp))
      call add_force(model, add_place(model, 'bead', bead, [0.0_wp, 0.0_wp]), wavy_law(1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp), &
         & wavy_law(2.0_wp, 0.0_wp, 0.0_wp, 0.0_wp))
   end function loaded

   !> A frame and a beam, both with masses that turn with their sections, between the ground and a rigid body.
   function framed(fidelity) result(model)
      integer, intent(in) :: fidelity
      type(model_type) :: model
      type(frame_choice_type) :: choice
      type(reduction_type) :: own
      type(beam_type) :: beam
      type(error_type), allocatable :: error
      integer :: frame, block, arm, tip
      model = empty_model(1.5_wp)
      model%gravity = [0.4_wp, -9.81_wp]
      choice%modes = 2
      choice%fidelity = fidelity
      choice%accelerations = .true.
      frame = add_frame(model, 'frame', l_frame(), choice, [0.1_wp, 0.2_wp], 0.4_wp, error)
      call check_no_error(error, 'frame')
      own = reduction_type(support=new_support('CLAMPED-FREE'), bending=2, axial=1, geometric_elements=2, fidelity=fidelity)
      beam = beam_type(ea=4.0e3_wp, ei=2.0_wp, rho_a=0.9_wp, length=1.2_wp, elements=6)
      call concentrate(beam, 0.7_wp, 0.4_wp, 0.03_wp)
      arm = add_beam(model, 'arm', beam, own, [0.7_wp, 0.5_wp], -1.0_wp, error)
      call check_no_error(error, 'beam')
      block = add_rigid(model, 'block', 2.0_wp, 0.3_wp, [0.1_wp, -0.2_wp], [0.5_wp, 0.5_wp], 2.0_wp)
      tip = add_frame_place(model, 'frame.tip', frame, 2, 0.0_wp)
      call add_joint(model, 'foot', joint_revolute, add_frame_place(model, 'frame.foot', frame, 1, 0.0_wp), &
         & add_place(model, 'ground.here', ground, [0.3_wp, -0.6_wp]))
      call add_joint(model, 'tip', joint_revolute, tip, add_beam_place(model, 'arm.start', arm, 0.0_wp))
      call add_joint(model, 'slot', joint_point_on_line, add_beam_place(model, 'arm.inside', arm, 0.95_wp), &
         & add_place(model, 'block.slot', block, [0.2_wp, -0.3_wp]), 0.6_wp)
      call add_force(model, add_frame_place(model, 'frame.inside', frame, 2, 0.33_wp), &
         & wavy_law(-5.0_wp, 0.0_wp, 0.0_wp, 0.0_wp), wavy_law(4.0_wp, 1.0_wp, 0.0_wp, 0.0_wp))
   end function framed

   !> All checks at three states of a scene.
   subroutine test_scene(name, model)
      character(*), intent(in) :: name
      type(model_type), intent(in) :: model
      type(system_type) :: system
      type(workspace_type) :: work
      type(tangent_type) :: tangent
      type(state_type) :: state
      integer :: i
      system = new_system(model)
      call new_workspace(system, work)
      call new_tangent(system, tangent)
      do i = 1, 3
         state = random_state(system)
         call test_coordinates(name, system, state)
         call test_solution(name, system, work, state)
         call test_inertia_and_joints(name, system, work, state)
         call test_derivatives(name, system, work, tangent, state)
         call test_products(name, system, tangent)
      end do
   end subroutine test_scene

   !> Random rates, accelerations and multipliers; deflections of a tenth of the length; u of unit length.
   function random_state(system) result(state)
      type(system_type), intent(in) :: system
      type(state_type) :: state
      real(wp) :: change(system%layout%nw), straight(system%layout%nq)
      integer :: i, first
      allocate (state%q(system%layout%nq), state%v(system%layout%nq))
      straight = 0.0_wp
      state%q = 0.0_wp
      do i = 1, size(system%layout%q)
         if (system%layout%framed(i)) straight(system%layout%q(i) + 2) = 1.0_wp
      end do
      allocate (state%w, source=randoms(system%layout%nw))
      allocate (state%a, source=randoms(system%layout%nw))
      allocate (state%lambda, source=randoms(system%nc))
      change = randoms(system%layout%nw)
      do i = 1, size(system%layout%q)
         first = system%layout%w(i)
         if (system%layout%n(i) > 0) change(first + 3:first + 2 + system%layout%n(i)) = &
            & 0.1_wp*change(first + 3:first + 2 + system%layout%n(i))
         if (system%layout%framed(i)) change(first + 2) = 3*change(first + 2)
      end do
      call advance(system%layout, straight, change, state%q)
      state%v = 0.0_wp
      call velocities_of(system%layout, state%q, state%w, state%v)
   end function random_state

   function randoms(n) result(x)
      integer, intent(in) :: n
      real(wp) :: x(n)
      integer :: i
      do i = 1, n
         x(i) = random()
      end do
   end function randoms

   !> Rates and velocities, there and back; a rotation keeps u of unit length; the velocities are what `advance` does.
   subroutine test_coordinates(name, system, state)
      character(*), intent(in) :: name
      type(system_type), intent(in) :: system
      type(state_type), intent(in) :: state
      real(wp) :: w(system%layout%nw), q(system%layout%nq, 4), speed(system%layout%nq)
      integer :: i
      w = 0.0_wp
      call rates_of(system%layout, state%q, state%v, w)
      call check(maxval(abs(w - state%w)) <= 1.0e-15_wp, name//': rates of the velocities of rates')
      q = 0.0_wp
      call advance(system%layout, state%q, state%w, q(:, 1))
      call advance(system%layout, q(:, 1), -state%w, q(:, 2))
      call check(maxval(abs(q(:, 2) - state%q)) <= 1.0e-15_wp, name//': an increment and back')
      do i = 1, size(system%layout%q)
         if (system%layout%framed(i)) call check_close(norm2(q(system%layout%q(i) + 2:system%layout%q(i) + 3, 1)), 1.0_wp, &
            & 4.0e-16_wp, name//': u turns')
      end do
      call shifted(system, state, -2*step, state%w, q(:, 1))
      call shifted(system, state, -step, state%w, q(:, 2))
      call shifted(system, state, step, state%w, q(:, 3))
      call shifted(system, state, 2*step, state%w, q(:, 4))
      speed = derivative(q(:, 1), q(:, 2), q(:, 3), q(:, 4), step)
      call check(maxval(abs(speed - state%v)) <= 2.0e-12_wp, name//': the derivative of an increment')
   end subroutine test_coordinates

   !> q moved by a part of a direction.
   subroutine shifted(system, state, part, direction, q)
      type(system_type), intent(in) :: system
      type(state_type), intent(in) :: state
      real(wp), intent(in) :: part, direction(:)
      real(wp), intent(inout) :: q(:)
      call advance(system%layout, state%q, part*direction, q)
   end subroutine shifted

   !> At the accelerations and multipliers of the condensed solution nothing is left; the velocity equations are those that
   !> the projection sees.
   subroutine test_solution(name, system, work, state)
      character(*), intent(in) :: name
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(state_type), intent(in) :: state
      type(error_type), allocatable :: error
      real(wp) :: second(system%layout%nq), a(system%layout%nw), motion(system%layout%nw), rates(system%nc), bulk(system%layout%nw)
      real(wp) :: lambda(system%nc), largest
      if (redundant(system)) return
      call linearise(system, work, t, state%q, error)
      call check_no_error(error, name//': regular')
      if (allocated(error)) return
      call accelerations(system, work, state%q, state%v, second)
      a = 0.0_wp
      motion = 0.0_wp
      rates = 0.0_wp
      bulk = 0.0_wp
      call rates_of(system%layout, state%q, second, a)
      lambda = work%lambda
      call motion_residual(system, work, t, state%q, state%v, 0*a, 0*lambda, bulk, rates)
      call motion_residual(system, work, t, state%q, state%v, a, lambda, motion, rates)
      largest = max(1.0_wp, maxval(abs(bulk)), maxval(abs(a)))
      call check(maxval(abs(motion)) <= 1.0e-11_wp*largest, name//': nothing is left at the solution')
      call linearise(system, work, t, state%q, error)
      call check_no_error(error, name//': regular')
      largest = velocity_residual(system, work, state%v)
      call check(maxval(abs(rates + work%gamma)) <= 1.0e-14_wp, name//': velocity equations')
   end subroutine test_solution

   !> More constraints than a scene can keep: it has no solution, but derivatives all the same.
   pure logical function redundant(system)
      type(system_type), intent(in) :: system
      redundant = system%nc > size(system%layout%q)*3
   end function redundant

   !> The residual is linear in a and lambda: b.M c from kinetic energies, b.G^T lambda from differences of the residuals of
   !> position, neither of which the residual's own code knows.
   subroutine test_inertia_and_joints(name, system, work, state)
      character(*), intent(in) :: name
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(state_type), intent(in) :: state
      real(wp), dimension(system%layout%nw) :: motion, base, b, c
      real(wp) :: rates(system%nc), mu(system%nc), phi(system%nc, 4), expected
      real(wp) :: q(system%layout%nq), largest
      real(wp), parameter :: parts(4) = step*[-2, -1, 1, 2]
      integer :: i
      motion = 0.0_wp
      base = 0.0_wp
      rates = 0.0_wp
      b = randoms(size(b))
      c = randoms(size(c))
      mu = randoms(size(mu))
      call motion_residual(system, work, t, state%q, state%v, state%a, state%lambda, base, rates)
      call motion_residual(system, work, t, state%q, state%v, state%a + c, state%lambda, motion, rates)
      expected = kinetic(system, work, state%q, b + c) - kinetic(system, work, state%q, b) - kinetic(system, work, state%q, c)
      call check_close(dot_product(b, motion - base), expected, 1.0e-12_wp*max(1.0_wp, maxval(abs(base))), name//': inertia')
      call motion_residual(system, work, t, state%q, state%v, state%a, state%lambda + mu, motion, rates)
      q = 0.0_wp
      do i = 1, 4
         call advance(system%layout, state%q, parts(i)*b, q)
         call place_frames(system%model, system%layout, t, q, work%kinematics)
         largest = position_residual(system, work)
         phi(:, i) = work%phi
      end do
      expected = dot_product(mu, derivative(phi(:, 1), phi(:, 2), phi(:, 3), phi(:, 4), step))
      call check_close(dot_product(b, motion - base), expected, 1.0e-11_wp*max(1.0_wp, maxval(abs(base))), name//': joints')
   end subroutine test_inertia_and_joints

   !> Kinetic energy at rates w.
   real(wp) function kinetic(system, work, q, w)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: q(:), w(:)
      real(wp) :: v(size(q)), potential
      v = 0.0_wp
      call velocities_of(system%layout, q, w, v)
      call mechanical_energy(system, work, q, v, kinetic, potential)
   end function kinetic

   !> M, D, K, G and its drift, each through `combine` by itself, against differences.
   subroutine test_derivatives(name, system, work, tangent, state)
      character(*), intent(in) :: name
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(tangent_type), intent(inout) :: tangent
      type(state_type), intent(in) :: state
      real(wp), dimension(system%layout%nw + system%nc, system%layout%nw + system%nc) :: joints, matrix, expected
      real(wp) :: noise
      integer :: nw
      nw = system%layout%nw
      call motion_residual(system, work, t, state%q, state%v, state%a, state%lambda, joints(:nw, 1), joints(nw + 1:, 1))
      ! Round-off of the residual in the differences
      noise = 20*epsilon(noise)*maxval(abs(joints(:, 1)))/step
      call linearise_motion(system, work, tangent, state%q, state%v, state%a, state%lambda)

      call combine(tangent, nought, nought, nought, nought)
      joints = dense(tangent, .false.)
      expected = 0.0_wp
      expected(:, nw + 1:) = differences(system, work, state, 'multipliers')
      call compare(name//': G^T', joints(:, nw + 1:), expected(:, nw + 1:), noise)
      expected(:, :nw) = differences(system, work, state, 'rates')
      call compare(name//': G', joints(nw + 1:, :nw), expected(nw + 1:, :nw), noise)
      call check(all(abs(joints(:nw, :nw)) <= 0.0_wp), name//': nothing but the joints')

      call combine(tangent, nought, one, nought, nought)
      matrix = dense(tangent, .false.) - joints
      call compare(name//': damping', matrix(:nw, :nw), expected(:nw, :nw), noise)
      call check(all(abs(matrix(nw + 1:, :)) <= 0.0_wp), name//': damping has no part in the joints')

      call combine(tangent, one, nought, nought, nought)
      matrix = dense(tangent, .false.) - joints
      expected = 0.0_wp
      expected(:, :nw) = differences(system, work, state, 'accelerations')
      call compare(name//': mass', matrix, expected, noise)
      call check(maxval(abs(matrix - transpose(matrix))) <= 0.0_wp, name//': mass is symmetric')

      call combine(tangent, nought, nought, one, one)
      matrix = dense(tangent, .false.) - joints
      expected(:, :nw) = differences(system, work, state, 'coordinates')
      call compare(name//': stiffness', matrix(:nw, :), expected(:nw, :), noise)
      call compare(name//': drift', matrix(nw + 1:, :), expected(nw + 1:, :), noise)

      ! The drift by itself, then nothing of it
      call combine(tangent, nought, nought, nought, one)
      matrix = dense(tangent, .false.) - joints
      call compare(name//': drift alone', matrix(nw + 1:, :), expected(nw + 1:, :), noise)
      call check(all(abs(matrix(:nw, :)) <= 0.0_wp), name//': drift has no part in the motion')
   end subroutine test_derivatives

   !> Each row's largest deviation beyond the noise, in units of its largest entry.
   subroutine compare(name, matrix, expected, noise)
      character(*), intent(in) :: name
      real(wp), intent(in) :: matrix(:, :), expected(:, :), noise
      real(wp) :: worst
      integer :: row
      worst = 0.0_wp
      do row = 1, size(matrix, 1)
         worst = max(worst, (maxval(abs(matrix(row, :) - expected(row, :))) - noise)/max(1.0_wp, maxval(abs(expected(row, :)))))
      end do
      call check_close(worst, 0.0_wp, close, name)
   end subroutine compare

   !> Derivatives of [motion; rates], one column for each component of what is varied.
   function differences(system, work, state, of) result(matrix)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(state_type), intent(in) :: state
      character(*), intent(in) :: of
      real(wp), allocatable :: matrix(:, :)
      type(state_type) :: moved
      real(wp) :: side(system%layout%nw + system%nc, 4), direction(system%layout%nw)
      real(wp), parameter :: parts(4) = step*[-2, -1, 1, 2]
      integer :: nw, columns, column, i
      nw = system%layout%nw
      columns = nw
      if (of == 'multipliers') columns = system%nc
      allocate (matrix(nw + system%nc, columns))
      do column = 1, columns
         do i = 1, 4
            moved = state
            direction = 0.0_wp
            if (of /= 'multipliers') direction(column) = parts(i)
            select case (of)
            case ('coordinates')
               call advance(system%layout, state%q, direction, moved%q)
            case ('rates')
               moved%w = moved%w + direction
            case ('accelerations')
               moved%a = moved%a + direction
            case ('multipliers')
               moved%lambda(column) = moved%lambda(column) + parts(i)
            end select
            call velocities_of(system%layout, moved%q, moved%w, moved%v)
            call motion_residual(system, work, t, moved%q, moved%v, moved%a, moved%lambda, side(:nw, i), side(nw + 1:, i))
         end do
         matrix(:, column) = derivative(side(:, 1), side(:, 2), side(:, 3), side(:, 4), step)
      end do
      call motion_residual(system, work, t, state%q, state%v, state%a, state%lambda, side(:nw, 1), side(nw + 1:, 1))
   end function differences

   !> The real values, or the imaginary parts of the complex ones, as a full matrix.
   function dense(tangent, is_imaginary) result(matrix)
      type(tangent_type), intent(in) :: tangent
      logical, intent(in) :: is_imaginary
      real(wp) :: matrix(tangent%matrix%n, tangent%matrix%n)
      integer :: row, column, at, absent
      matrix = 0.0_wp
      do column = 1, tangent%matrix%n
         ! What is not in the pattern has the place of a row that there is not
         absent = tangent%matrix%place(0, column)
         do row = 1, tangent%matrix%n
            at = tangent%matrix%place(row, column)
            if (at == absent) cycle
            if (is_imaginary) then
               matrix(row, column) = aimag(tangent%matrix%complex_values(at))
            else
               matrix(row, column) = tangent%matrix%values(at)
            end if
         end do
      end do
   end function dense

   !> Products with M and K, complex factors, and solutions with both kinds of factors.
   subroutine test_products(name, system, tangent)
      character(*), intent(in) :: name
      type(system_type), intent(in) :: system
      type(tangent_type), intent(inout) :: tangent
      real(wp), allocatable, dimension(:, :) :: joints, whole, imaginary
      real(wp), dimension(system%layout%nw) :: x, y
      real(wp) :: b(system%layout%nw + system%nc)
      complex(wp) :: c(system%layout%nw + system%nc)
      complex(wp), parameter :: mu = (90.0_wp, 60.0_wp)
      logical :: singular
      integer :: nw
      nw = system%layout%nw
      x = randoms(nw)
      call combine(tangent, nought, nought, nought, nought)
      allocate (joints, source=dense(tangent, .false.))
      call combine(tangent, one, nought, nought, nought)
      allocate (whole, source=dense(tangent, .false.) - joints)
      y = 0.5_wp
      call times_mass(system, tangent, 0.7_wp, x, y)
      call check(maxval(abs(y - 0.5_wp - 0.7_wp*matmul(whole(:nw, :nw), x))) <= 1.0e-13_wp*maxval(abs(whole)), &
         & name//': product with the mass')
      call combine(tangent, nought, nought, one, nought)
      whole = dense(tangent, .false.) - joints
      y = 0.5_wp
      call times_stiffness(system, tangent, 0.7_wp, x, y)
      call check(maxval(abs(y - 0.5_wp - 0.7_wp*matmul(whole(:nw, :nw), x))) <= 1.0e-13_wp*maxval(abs(whole)), &
         & name//': product with the stiffness')

      call combine_complex(tangent, mu, (1.0_wp, 0.0_wp), 1/mu, 1/mu)
      call combine(tangent, real(mu, wp), one, real(1/mu, wp), real(1/mu, wp))
      whole = dense(tangent, .false.)
      allocate (imaginary, source=dense(tangent, .true.))
      if (redundant(system)) return
      call tangent%matrix%factor(singular)
      call check(.not. singular, name//': real factors')
      b = randoms(size(b))
      c = b
      call tangent%matrix%solve(b)
      b = matmul(whole, b) - real(c, wp)
      call check(maxval(abs(b)) <= 1.0e-9_wp, name//': real solution')
      call tangent%matrix%factor_complex(singular)
      call check(.not. singular, name//': complex factors')
      b = real(c, wp)
      c = cmplx(b, randoms(size(b)), wp)
      b = aimag(c)
      call tangent%matrix%solve_complex(c)
      call check(maxval(abs(matmul(whole, aimag(c)) + matmul(imaginary, real(c, wp)) - b)) <= 1.0e-9_wp, name//': complex solution')
   end subroutine test_products

   !> The elastic stiffness by itself at large deflections; symmetric where there is an energy, and only there.
   subroutine test_elastic(fidelity)
      integer, intent(in) :: fidelity
      character(6), parameter :: names(2) = [character(6) :: 'linear', 'k_g']
      type(model_type) :: model
      type(reduction_type) :: choice
      type(error_type), allocatable :: error
      real(wp), allocatable :: k(:, :), expected(:, :), eta(:), side(:, :), z(:), s(:), slope(:, :), moved(:)
      real(wp), parameter :: parts(4) = step*[-2, -1, 1, 2]
      real(wp) :: skew
      integer :: body, n, pairs, trial, column, i
      model = empty_model(1.0_wp)
      choice = reduction_type(support=new_support('CLAMPED-FREE'), bending=3, axial=2, geometric_elements=4, &
         & fidelity=fidelity)
      body = add_beam(model, 'beam', beam_type(ea=4.0e3_wp, ei=2.0_wp, rho_a=0.9_wp, length=1.2_wp, elements=12), choice, &
         & [0.0_wp, 0.0_wp], 0.0_wp, error)
      call check_no_error(error, 'beam')
      associate (reduced => model%bodies(body)%reduced, name => 'elastic, '//trim(names(fidelity)))
         n = reduced%n
         pairs = reduced%bending*(reduced%bending + 1)/2
         allocate (k(n, n), expected(n, n), eta(n), moved(n), side(n, 4), z(pairs), s(pairs), slope(pairs, 2))
         z = 0.0_wp
         s = 0.0_wp
         slope = 0.0_wp
         do trial = 1, 5
            eta = randoms(n)
            ! The tangent adds to what is there
            k = 1.0_wp
            call elastic_tangent(reduced, eta, k, s)
            k = k - 1.0_wp
            do column = 1, n
               do i = 1, 4
                  moved = eta
                  moved(column) = moved(column) + parts(i)
                  side(:, i) = 0.0_wp
                  call elastic_force(reduced, moved, side(:, i), s)
               end do
               expected(:, column) = derivative(side(:, 1), side(:, 2), side(:, 3), side(:, 4), step)
            end do
            call compare(name, k, expected, 20*epsilon(skew)*maxval(abs(side))/step)
            skew = maxval(abs(k - transpose(k)))/maxval(abs(k))
            if (fidelity == fidelity_kg) then
               call check(skew > 1.0e-3_wp, name//': not symmetric')
            else
               call check_close(skew, 0.0_wp, 1.0e-14_wp, name//': symmetric')
            end if
         end do
      end associate
   end subroutine test_elastic

end program test_tangent
