!> Axial coordinates that follow at rest, at random states: the projector, the foreshortening against differences, the accelerations
!> of the multiplier system against the residual that implicit integrators take, and its derivatives against differences.
program test_condensation
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_flex_elastic, only: elastic_force
   use limber_flex_folding, only: fold_matrix, foreshortening
   use limber_flex_mesh, only: beam_type, new_support
   use limber_flex_reduced, only: reduced_type
   use limber_flex_reduction, only: axial_by_elements, axial_by_modes, axial_static, fidelity_full, fidelity_kg, &
      & fidelity_linear, reduction_type
   use limber_model_scene, only: ground, joint_point_on_line, joint_revolute, model_type
   use limber_system_condensation, only: place_axial, place_axial_rates, project_vector, update_folds
   use limber_system_condensed_motion, only: condensed_rows_type, condense_residual, condense_tangent, new_condensed_rows
   use limber_system_dynamics, only: accelerations, linearise
   use limber_system_layout, only: advance, rates_of, velocities_of
   use limber_system_motion, only: linearise_motion, motion_residual
   use limber_system_system, only: new_system, new_workspace, system_type, workspace_type
   use limber_system_tangent, only: combine, new_tangent, tangent_type
   use scenes, only: add_beam, add_beam_place, add_driver, add_joint, add_place, add_point_mass, derivative, empty_model, random, &
      & wavy_law
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   real(wp), parameter :: t = 0.37_wp
   !> Factors of mass and stiffness in the Newton matrix
   real(wp), parameter :: mu = 3.0_wp, kappa = 0.2_wp

   call test_scene('linear', fidelity_linear, axial_by_modes)
   call test_scene('k_g', fidelity_kg, axial_by_modes)
   call test_scene('full, functions of elements', fidelity_full, axial_by_elements)
   call test_scene('full, static functions', fidelity_full, axial_static)
   call finish()

contains

   !> A beam on the ground, another on its end, a mass at the end of that, on a line; driven.
   function arms(fidelity, basis) result(model)
      integer, intent(in) :: fidelity, basis
      type(model_type) :: model
      type(beam_type) :: beam
      type(reduction_type) :: choice
      type(error_type), allocatable :: error
      integer :: upper, fore, bead
      model = empty_model(1.5_wp)
      model%gravity = [0.4_wp, -9.81_wp]
      beam = beam_type(ea=4.0e3_wp, ei=2.0_wp, rho_a=0.9_wp, length=1.2_wp, elements=8)
      choice = reduction_type(support=new_support('PINNED-ROLLER'), bending=2, axial=1, geometric_elements=3, axial_basis=basis, &
         & fidelity=fidelity, condensed=.true.)
      upper = add_beam(model, 'upper', beam, choice, [0.1_wp, 0.2_wp], 0.4_wp, error)
      call check_no_error(error, 'upper')
      choice%support = new_support('CLAMPED-FREE')
      choice%bending = 3
      choice%origin = 0.3_wp
      fore = add_beam(model, 'fore', beam, choice, [-0.3_wp, 0.7_wp], -1.1_wp, error)
      call check_no_error(error, 'fore')
      bead = add_point_mass(model, 'bead', 0.7_wp, [1.0_wp, -0.4_wp])
      call add_joint(model, 'shoulder', joint_revolute, add_beam_place(model, 'upper.start', upper, 0.0_wp), &
         & add_place(model, 'ground.a', ground, [0.3_wp, -0.6_wp]))
      call add_joint(model, 'elbow', joint_revolute, add_beam_place(model, 'upper.end', upper, 1.2_wp), &
         & add_beam_place(model, 'fore.start', fore, 0.0_wp))
      call add_joint(model, 'hand', joint_revolute, add_beam_place(model, 'fore.end', fore, 1.2_wp), &
         & add_place(model, 'bead.origin', bead, [0.0_wp, 0.0_wp]))
      call add_joint(model, 'line', joint_point_on_line, add_place(model, 'bead.again', bead, [0.0_wp, 0.0_wp]), &
         & add_place(model, 'ground.b', ground, [-0.2_wp, 0.9_wp]), 0.3_wp)
      call add_driver(model, 'drive', upper, wavy_law(0.2_wp, 1.3_wp, 0.4_wp, 2.1_wp))
   end function arms

   subroutine test_scene(name, fidelity, basis)
      character(*), intent(in) :: name
      integer, intent(in) :: fidelity, basis
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:), w(:), full(:), a(:), motion(:), rates(:)
      integer :: i
      system = new_system(arms(fidelity, basis))
      call new_workspace(system, work)
      call check(system%condensed, name//': condensed')
      associate (nq => system%layout%nq, nw => system%layout%nw)
         allocate (q(nq), v(nq), w(nw), full(nq), a(nw), motion(nw), rates(system%nc))
         q = [(0.2_wp*(2*random() - 1), i=1, nq)]
         w = [(2*random() - 1, i=1, nw)]
      end associate
      do i = 1, size(system%layout%q)
         if (system%layout%framed(i)) q(system%layout%q(i) + 2:system%layout%q(i) + 3) = [0.6_wp, 0.8_wp]
      end do
      call place_axial(system, work, q)
      call velocities_of(system%layout, q, w, v)
      call update_folds(system, work, q)
      call place_axial_rates(system, work, v)
      call rates_of(system%layout, q, v, w)
      call test_folds(name, system%model%bodies(2)%reduced, q(system%layout%q(2) + 4:), work)
      call linearise(system, work, t, q, error)
      call check_no_error(error, name)
      call accelerations(system, work, q, v, full)
      call rates_of(system%layout, q, full, a)
      call motion_residual(system, work, t, q, v, a, work%lambda, motion, rates)
      call condense_residual(system, work, q, v, motion)
      call check_close(maxval(abs(motion)), 0.0_wp, 1.0e-9_wp*maxval(abs(a)), name//': accelerations and residual')
      call test_tangent(name, system, work, q, w, a)
   end subroutine test_scene

   !> The foreshortening needs no axial force; H is its derivative; the projector is one.
   subroutine test_folds(name, body, eta, work)
      character(*), intent(in) :: name
      type(reduced_type), intent(in) :: body
      real(wp), intent(in) :: eta(:)
      type(workspace_type), intent(inout) :: work
      real(wp) :: h(body%n - body%bending, 4), matrix(size(h, 1), body%bending), x(body%n), y(body%n), force(body%n)
      real(wp) :: z(body%bending*(body%bending + 1)/2), s(size(z)), moved(body%bending)
      real(wp), parameter :: step = 1.0e-3_wp
      integer :: j, k
      call fold_matrix(body, eta(:body%bending), matrix)
      do j = 1, body%bending
         do k = 1, 4
            moved = eta(:body%bending)
            moved(j) = eta(j) + step*real(merge(k - 3, k - 2, k < 3), wp)
            call foreshortening(body, moved, h(:, k))
         end do
         if (body%full) call check_close(maxval(abs(derivative(h(:, 1), h(:, 2), h(:, 3), h(:, 4), step) - matrix(:, j))), 0.0_wp, &
            & 1.0e-10_wp, name//': derivative of the foreshortening')
      end do
      call foreshortening(body, eta(:body%bending), h(:, 1))
      force = 0.0_wp
      call elastic_force(body, [eta(:body%bending), h(:, 1)], force, z, s)
      call check_close(maxval(abs(force(body%bending + 1:))), 0.0_wp, 1.0e-12_wp*maxval(abs(force)), name//': no axial force')
      x = [(random(), j=1, size(x))]
      y = x
      call project_vector(body, work%bodies(2)%fold, work%bodies(2)%normal, y)
      if (body%full) call check_close(maxval(abs(matmul(matrix, y(:body%bending)) - y(body%bending + 1:))), 0.0_wp, 1.0e-12_wp, &
         & name//': along the motions')
      ! What was taken away is across them
      x = x - y
      if (.not. body%full) matrix = 0.0_wp
      call check_close(maxval(abs(x(:body%bending) + matmul(x(body%bending + 1:), matrix))), 0.0_wp, 1.0e-12_wp, &
         & name//': across the motions')
      x = y
      call project_vector(body, work%bodies(2)%fold, work%bodies(2)%normal, y)
      call check_close(maxval(abs(x - y)), 0.0_wp, 1.0e-12_wp, name//': twice')
   end subroutine test_folds

   !> The solution of the Newton matrix for a random right-hand side changes the residuals by that.
   subroutine test_tangent(name, system, work, q, w, a)
      character(*), intent(in) :: name
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: q(:), w(:), a(:)
      type(tangent_type) :: tangent
      type(condensed_rows_type) :: rows
      real(wp), allocatable :: right(:), solution(:), residual(:, :), v(:), lambda(:)
      real(wp), parameter :: step = 1.0e-3_wp
      logical :: singular
      integer :: i, nw, n
      nw = system%layout%nw
      n = nw + system%nc
      allocate (right(n), solution(n), residual(n, 4), v(size(q)), lambda(system%nc))
      lambda = work%lambda
      right = [(2*random() - 1, i=1, n)]
      solution = right
      call new_tangent(system, tangent)
      call new_condensed_rows(system, tangent, rows)
      ! The residual at this state leaves kinematics and axial loads where the derivatives are taken
      call residuals(system, work, q, w, a, lambda, solution, 0.0_wp, residual(:, 1))
      call velocities_of(system%layout, q, w, v)
      call linearise_motion(system, work, tangent, q, v, a, lambda)
      call condense_tangent(system, work, rows, q, v, tangent)
      call combine(tangent, cmplx(mu, 0.0_wp, wp), (1.0_wp, 0.0_wp), cmplx(kappa, 0.0_wp, wp), cmplx(kappa, 0.0_wp, wp), .false.)
      call tangent%matrix%factor(singular)
      call check(.not. singular, name//': Newton matrix')
      call tangent%matrix%solve(solution)
      solution = solution/maxval(abs(solution))
      do i = 1, 4
         call residuals(system, work, q, w, a, lambda, solution, step*real(merge(i - 3, i - 2, i < 3), wp), residual(:, i))
      end do
      right = derivative(residual(:, 1), residual(:, 2), residual(:, 3), residual(:, 4), step)
      call tangent%matrix%solve(right)
      call check_close(maxval(abs(right - solution)), 0.0_wp, 1.0e-6_wp, name//': derivatives')
   end subroutine test_tangent

   !> Residuals at a state moved along a direction by a step.
   subroutine residuals(system, work, q, w, a, lambda, direction, s, values)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: q(:), w(:), a(:), lambda(:), direction(:), s
      real(wp), intent(out) :: values(:)
      real(wp) :: moved(size(q)), speed(size(q))
      associate (nw => system%layout%nw)
         call advance(system%layout, q, s*kappa*direction(:nw), moved)
         call velocities_of(system%layout, moved, w + s*direction(:nw), speed)
         call motion_residual(system, work, t, moved, speed, a + s*mu*direction(:nw), lambda + s*direction(nw + 1:), values(:nw), &
            & values(nw + 1:))
         call condense_residual(system, work, moved, speed, values(:nw))
      end associate
   end subroutine residuals

end program test_condensation
