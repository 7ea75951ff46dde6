!> Chains and trees of rigid and flexible bodies on pins: residual, Newton step and return to the constraints are those of the
!> general equations and of sparse factors, to round-off; what is no forest is refused.
program test_forest
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_beam_beam_mesh, only: beam_type, new_support
   use limber_beam_beam_reduction, only: fidelity_kg, fidelity_linear, reduction_type
   use limber_model_model, only: ground, model_type
   use limber_multibody_assembly, only: assemble
   use limber_multibody_discrete_motion, only: linearise_step, step_residual
   use limber_multibody_equations_of_motion, only: accelerations, input_power, linearise
   use limber_multibody_articulated, only: articulated_type, forest_solve, new_forest
   use limber_multibody_articulated_factors, only: forest_factor
   use limber_multibody_articulated_motion, only: forest_power, forest_residual, forest_settle, forest_times_mass
   use limber_multibody_articulated_step, only: begin_forest_step, forest_step_factor, forest_step_mass, forest_step_residual
   use limber_multibody_layout, only: rates_of, velocities_of
   use limber_multibody_motion_residual, only: linearise_motion, motion_residual, place_motion
   use limber_multibody_projection, only: settle
   use limber_multibody_discrete_step, only: begin_step, frame_rates, new_step, discrete_step_type
   use limber_multibody_system, only: new_system, new_workspace, system_type, workspace_type
   use limber_multibody_tangent, only: combine, new_tangent, tangent_type
   use limber_multibody_tangent_products, only: times_mass
   use scenes, only: joint_revolute, joint_point_on_line, add_beam, add_beam_place, add_joint, add_place, add_point_mass, &
      & add_rigid, add_torque, constant_law, &
      & empty_model, random
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   call test_scene('rigid chain', chain(0))
   call test_scene('chain of beams of order six', chain(1))
   call test_scene('chain of beams, damped', chain(2))
   call test_scene('trees of all kinds', trees())
   call test_refused()
   call finish()

contains

   !> Twelve equal bodies on the ground, one after the other.
   function chain(flexible) result(model)
      !> 0: rigid bodies, 1: beams with three coordinates, 2: with four, damped
      integer, intent(in) :: flexible
      type(model_type) :: model
      integer :: i, body, last, start
      model = empty_model(12.0_wp)
      model%gravity = [0.4_wp, -9.81_wp]
      last = add_place(model, 'ground.a', ground, [0.0_wp, 0.0_wp])
      do i = 1, 12
         call add_bar(model, 'b'//as_text(i), flexible, [i - 1.0_wp, 0.0_wp], body, start)
         if (modulo(i, 2) == 0) then
            call add_joint(model, 'pin'//as_text(i), joint_revolute, last, start)
         else
            call add_joint(model, 'pin'//as_text(i), joint_revolute, start, last)
         end if
         call add_end(model, 'b'//as_text(i), flexible, body, last)
      end do
   end function chain

   !> Two trees on the ground and one in flight, of rigid bodies and beams, their bodies in no order, pins anywhere.
   function trees() result(model)
      type(model_type) :: model
      integer, parameter :: carrier(14) = [3, ground, 2, 2, 8, 5, 6, -1, 8, ground, 10, 10, 12, 1]
      integer :: i, body, own(14), end(14), base
      model = empty_model(4.0_wp)
      model%gravity = [0.7_wp, -9.81_wp]
      do i = 1, 14
         call add_bar(model, 'b'//as_text(i), modulo(i, 3), [1.5_wp*random(), 1.5_wp*random()], body, own(i))
         call add_end(model, 'b'//as_text(i), modulo(i, 3), body, end(i))
      end do
      do i = 1, 14
         if (carrier(i) < 0) cycle
         if (carrier(i) == ground) then
            base = add_place(model, 'ground.'//as_text(i), ground, [random(), random()])
         else
            base = end(carrier(i))
         end if
         call add_joint(model, 'pin'//as_text(i), joint_revolute, own(i), base)
      end do
   end function trees

   subroutine add_bar(model, name, flexible, position, body, start)
      type(model_type), intent(inout) :: model
      character(*), intent(in) :: name
      integer, intent(in) :: flexible
      real(wp), intent(in) :: position(2)
      !> Its index, and that of the point at its start
      integer, intent(out) :: body, start
      type(beam_type) :: beam
      type(reduction_type) :: choice
      type(error_type), allocatable :: error
      integer :: i
      beam = beam_type(ea=4.0e3_wp, ei=2.0_wp, rho_a=0.9_wp, length=1.0_wp, elements=6)
      select case (flexible)
      case (0)
         body = add_rigid(model, name, 1.0_wp, 1.0_wp/12, [0.5_wp, 0.0_wp], position, 0.0_wp)
         start = add_place(model, name//'.start', body, [0.0_wp, 0.0_wp])
         return
      case (1)
         choice = reduction_type(support=new_support('PINNED-ROLLER'), bending=2, axial=1, geometric_elements=2, &
            & fidelity=fidelity_kg)
      case default
         choice = reduction_type(support=new_support('CLAMPED-FREE'), bending=2, axial=1, geometric_elements=2, &
            & fidelity=fidelity_linear, origin=0.3_wp)
      end select
      body = add_beam(model, name, beam, choice, position, 0.0_wp, error)
      call check_no_error(error, name)
      if (flexible == 2) then
         model%bodies(body)%reduced%damped = .true.
         associate (n => model%bodies(body)%reduced%n)
            allocate (model%bodies(body)%reduced%damping(n, n), source=0.05_wp)
            do i = 1, n
               model%bodies(body)%reduced%damping(i, i) = 0.3_wp
            end do
         end associate
      end if
      start = add_beam_place(model, name//'.start', body, 0.0_wp)
   end subroutine add_bar

   subroutine add_end(model, name, flexible, body, end)
      type(model_type), intent(inout) :: model
      character(*), intent(in) :: name
      integer, intent(in) :: flexible, body
      integer, intent(out) :: end
      if (flexible == 0) then
         end = add_place(model, name//'.end', body, [1.0_wp, 0.0_wp])
      else
         end = add_beam_place(model, name//'.end', body, 1.0_wp)
      end if
   end subroutine add_end

   subroutine test_scene(title, model)
      character(*), intent(in) :: title
      type(model_type), intent(in) :: model
      type(system_type) :: system
      type(workspace_type) :: work
      type(articulated_type) :: forest
      system = new_system(model)
      call new_workspace(system, work)
      call new_forest(system, forest)
      call check(forest%usable, title//': a forest')
      if (.not. forest%usable) return
      call test_motion(title, system, work, forest)
      call test_settle(title, system, work, forest)
      call test_step(title, system, work, forest)
   end subroutine test_scene

   !> Residual and Newton step at a random state that keeps no constraint.
   subroutine test_motion(title, system, work, forest)
      character(*), intent(in) :: title
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(articulated_type), intent(inout) :: forest
      real(wp), parameter :: mass = 50.0_wp, stiffness = 0.02_wp
      type(tangent_type) :: tangent
      real(wp), allocatable :: q(:), v(:), w(:), a(:), lambda(:), motion(:), rates(:), motion2(:), rates2(:), x(:), y(:)
      real(wp) :: turn
      logical :: singular
      integer :: i, at
      associate (nq => system%layout%nq, nw => system%layout%nw, nc => system%nc)
         allocate (q(nq), v(nq), w(nw), a(nw), lambda(nc), motion(nw), rates(nc), motion2(nw), rates2(nc), x(nw + nc), y(nw + nc))
      end associate
      do i = 1, size(q)
         q(i) = 0.3_wp*random()
      end do
      do i = 1, size(system%layout%q)
         at = system%layout%q(i) + 2
         turn = 3*random()
         q(at:at + 1) = [cos(turn), sin(turn)]
      end do
      do i = 1, size(w)
         w(i) = 2*random()
         a(i) = 3*random()
      end do
      do i = 1, size(lambda)
         lambda(i) = random()
      end do
      do i = 1, size(x)
         x(i) = random()
      end do
      y = x
      call velocities_of(system%layout, q, w, v)
      call motion_residual(system, work, 0.0_wp, q, v, a, lambda, motion, rates)
      call forest_residual(forest, system%model, q, w, a, lambda, motion2, rates2)
      call check_close(maxval(abs(motion2 - motion)), 0.0_wp, 1.0e-11_wp*maxval(abs(motion)), title//': motion')
      call check_close(maxval(abs(rates2 - rates)), 0.0_wp, 1.0e-13_wp*maxval(abs(rates)), title//': rates')
      call new_tangent(system, tangent)
      call place_motion(system, work, 0.0_wp, q, v)
      call linearise_motion(system, work, tangent, q, v, a, lambda)
      call combine(tangent, mass, 1.0_wp, stiffness, stiffness)
      call tangent%matrix%factor(singular)
      call tangent%matrix%solve(x)
      call forest_factor(forest, system%model, q, w, a, lambda, mass, stiffness, singular)
      call check(.not. singular, title//': pivots')
      call forest_solve(forest, y)
      call check_close(maxval(abs(y - x)), 0.0_wp, 1.0e-9_wp*maxval(abs(x)), title//': Newton step')
      call check(maxval(abs(x)) > 1.0e-3_wp, title//': there is one')
      motion = 0.0_wp
      motion2 = 0.0_wp
      call times_mass(system, tangent, 2.0_wp, w, motion)
      call forest_times_mass(forest, system%model, q, 2.0_wp, w, motion2)
      call check_close(maxval(abs(motion2 - motion)), 0.0_wp, 1.0e-12_wp*maxval(abs(motion)), title//': mass')
   end subroutine test_motion

   !> Residual and Newton step of a step that conserves energy, from a random state by random increments.
   subroutine test_step(title, system, work, forest)
      character(*), intent(in) :: title
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(articulated_type), intent(inout) :: forest
      real(wp), parameter :: h = 0.03_wp
      type(tangent_type) :: tangent
      type(discrete_step_type) :: step
      real(wp), allocatable :: q(:), b(:), y(:), lambda(:), motion(:), phi(:), motion2(:), phi2(:), x(:), x2(:)
      real(wp) :: turn
      logical :: singular
      integer :: i, at
      associate (nq => system%layout%nq, nw => system%layout%nw, nc => system%nc)
         allocate (q(nq), b(nw), y(nw), lambda(nc), motion(nw), phi(nc), motion2(nw), phi2(nc), x(nw + nc), x2(nw + nc))
      end associate
      do i = 1, size(q)
         q(i) = 0.3_wp*random()
      end do
      do i = 1, size(system%layout%q)
         at = system%layout%q(i) + 2
         turn = 3*random()
         q(at:at + 1) = [cos(turn), sin(turn)]
      end do
      do i = 1, size(b)
         b(i) = 2*random()
         y(i) = 0.1_wp*random()
      end do
      do i = 1, size(lambda)
         lambda(i) = random()
      end do
      do i = 1, size(x)
         x(i) = random()
      end do
      x2 = x
      call new_tangent(system, tangent)
      call new_step(system, work, step)
      call begin_step(system, step, 0.0_wp, h, h, q, b)
      call step_residual(system, work, step, y, lambda, motion, phi)
      call linearise_step(system, work, step, tangent, y, lambda)
      call tangent%matrix%factor(singular)
      call tangent%matrix%solve(x)
      step%p = 0.0_wp
      step%new_p = 0.0_wp
      call begin_forest_step(forest, system%model, step, 0.0_wp, h, h, q, b)
      call forest_step_residual(forest, system%model, system%layout, step, y, lambda, motion2, phi2)
      call check_close(maxval(abs(motion2 - motion)), 0.0_wp, 1.0e-11_wp*maxval(abs(motion)), title//': balance of a step')
      call check_close(maxval(abs(phi2 - phi)), 0.0_wp, 1.0e-13_wp*maxval(abs(phi)), title//': pins after a step')
      allocate (forest%masses, source=forest%block)
      call forest_step_factor(forest, system%model, step, y, lambda, singular)
      call check(.not. singular, title//': pivots of a step')
      call forest_solve(forest, x2)
      call check_close(maxval(abs(x2 - x)), 0.0_wp, 1.0e-9_wp*maxval(abs(x)), title//': Newton step of a step')
      motion = 0.0_wp
      motion2 = 0.0_wp
      call times_mass(system, tangent, 1.0_wp, y, motion)
      call forest_step_mass(forest, y, motion2)
      call check_close(maxval(abs(motion2 - motion)), 0.0_wp, 1.0e-12_wp*maxval(abs(motion)), title//': momenta of a step')
   end subroutine test_step

   !> A state a little off the constraints is moved onto them: no gap is left that the general projection sees, and rotations,
   !> deflections and their rates are those of before.
   subroutine test_settle(title, system, work, forest)
      character(*), intent(in) :: title
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(articulated_type), intent(inout) :: forest
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:), q2(:), v2(:), w(:), change(:)
      real(wp) :: residual, power
      integer :: i, culprit, round
      associate (nq => system%layout%nq)
         allocate (q(nq), v(nq), q2(nq), v2(nq), w(system%layout%nw), change(nq))
      end associate
      do i = 1, size(q)
         q(i) = 0.1_wp*random()
         v(i) = random()
      end do
      do i = 1, size(system%layout%q)
         q(system%layout%q(i) + 2) = 1.0_wp
      end do
      call assemble(system, work, 0.0_wp, q, v, error, culprit)
      call check_no_error(error, title)
      do round = 1, 2
         do i = 1, size(q)
            q(i) = q(i) + 10.0_wp**(-9 + 3*round)*random()
            v(i) = v(i) + 10.0_wp**(-9 + 3*round)*random()
         end do
         q2 = q
         v2 = v
         call forest_settle(forest, q2, v2)
         call check_same_inside(title, system, q, v, q2, v2)
         q = q2
         v = v2
         call settle(system, work, 0.0_wp, q, v, change, .false., residual, error)
         call check_no_error(error, title)
         call check_close(maxval(abs(q2 - q)), 0.0_wp, 1.0e-13_wp, title//': place, '//as_text(round))
         call check_close(maxval(abs(v2 - v)), 0.0_wp, 1.0e-12_wp, title//': velocities, '//as_text(round))
      end do
      if (.not. system%powered) return
      call linearise(system, work, 0.0_wp, q, error)
      call accelerations(system, work, q, v, change)
      power = input_power(system, work, q, v)
      call rates_of(system%layout, q, v, w)
      call check_close(forest_power(forest, system%model, q, w), power, 1.0e-12_wp*abs(power), title//': power')
   end subroutine test_settle

   !> Angles of the frames, angular velocities, deflections and rates that moving a state onto the pins must leave.
   subroutine check_same_inside(title, system, q, v, q2, v2)
      character(*), intent(in) :: title
      type(system_type), intent(in) :: system
      !> Before and after
      real(wp), intent(in) :: q(:), v(:), q2(:), v2(:)
      real(wp) :: change
      integer :: i, at
      change = 0.0_wp
      do i = 1, size(system%layout%q)
         at = system%layout%q(i) + 2
         associate (n => system%layout%n(i))
            change = max(change, abs(q(at)*q2(at + 1) - q(at + 1)*q2(at)), abs(norm2(q2(at:at + 1)) - 1.0_wp), &
               & abs((q(at)*v(at + 1) - q(at + 1)*v(at))/norm2(q(at:at + 1)) - q2(at)*v2(at + 1) + q2(at + 1)*v2(at)))
            if (n > 0) change = max(change, maxval(abs(q2(at + 2:at + 1 + n) - q(at + 2:at + 1 + n))), &
               & maxval(abs(v2(at + 2:at + 1 + n) - v(at + 2:at + 1 + n))))
         end associate
      end do
      call check_close(change, 0.0_wp, 1.0e-14_wp, title//': rotations and deflections stay')
   end subroutine check_same_inside

   !> Loops, other joints, loads, bodies without inertia, and scenes where nothing is to be eliminated.
   subroutine test_refused()
      type(model_type) :: model
      integer :: i, point
      do i = 1, 6
         model = chain(1)
         select case (i)
         case (1); call add_joint(model, 'loop', joint_revolute, model%joints(4)%points(1), model%joints(9)%points(1))
         case (2)
            point = add_place(model, 'ground.line', ground, [1.0_wp, 0.0_wp])
            call add_joint(model, 'line', joint_point_on_line, model%joints(12)%points(1), point, 0.0_wp)
         case (3); call add_torque(model, 3, constant_law(1.0_wp))
         case (4); point = add_point_mass(model, 'mass', 1.0_wp, [0.0_wp, 0.0_wp])
         case (5); point = add_rigid(model, 'wire', 1.0_wp, 0.0_wp, [0.2_wp, 0.0_wp], [0.0_wp, 0.0_wp], 0.0_wp)
         case (6); model%assembly%elimination = .false.
         end select
         call check(.not. usable(model), 'what is no forest: '//as_text(i))
      end do
   end subroutine test_refused

   logical function usable(model)
      type(model_type), intent(in) :: model
      type(system_type) :: system
      type(articulated_type) :: forest
      system = new_system(model)
      call new_forest(system, forest)
      usable = forest%usable
   end function usable

end program test_forest
