!> Accelerations of trees by recursion: those of the multiplier system, to round-off; bodies that are put on their pins meet the
!> constraints; what is no open tree is refused.
program test_recursion
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_model_model, only: model_type, ground
   use limber_multibody_equations_of_motion, only: linearise, accelerations, position_residual, velocity_residual
   use limber_multibody_kinematics, only: place_frames
   use limber_multibody_multiplier_system, only: update_jacobians
   use limber_multibody_articulated_rigid, only: articulated_rigid_type, new_recursion, recursive_accelerations, recursive_settle
   use limber_multibody_system, only: system_type, workspace_type, new_system, new_workspace
   use scenes, only: joint_revolute, joint_point_on_line, random, empty_model, add_rigid, add_point_mass, join, add_spring, &
      & add_place, constant_law, add_torque
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   real(wp), parameter :: nil(2) = [0.0_wp, 0.0_wp]

   call test_forest()
   call test_refused()
   call finish()

contains

   !> Two trees on the ground and one in flight, their bodies in no order, pins beside the frames' origins.
   subroutine forest(model)
      type(model_type), intent(out) :: model
      integer, parameter :: carrier(14) = [3, ground, 2, 2, 8, 5, 6, -1, 8, ground, 10, 10, 12, 1]
      character(4) :: name
      integer :: i, body
      model = empty_model(1.0_wp)
      model%gravity = [0.7_wp, -9.81_wp]
      do i = 1, size(carrier)
         write (name, '(a,i0)') 'b', i
         body = add_rigid(model, trim(name), 1.0_wp + 0.5_wp*random(), 0.1_wp + 0.05_wp*random(), [random(), random()], &
            & [random(), random()], 3*random())
      end do
      do i = 1, size(carrier)
         if (carrier(i) < 0) cycle
         write (name, '(a,i0)') 'j', i
         if (modulo(i, 3) == 0) then
            call join(model, trim(name), joint_revolute, carrier(i), [random(), random()], i, nil)
         else
            call join(model, trim(name), joint_revolute, i, [random(), random()], carrier(i), [random(), random()])
         end if
      end do
   end subroutine forest

   subroutine test_forest()
      type(model_type) :: model
      type(system_type) :: system
      type(workspace_type) :: work
      type(articulated_rigid_type) :: recursion
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:), a(:), b(:)
      real(wp) :: largest
      integer :: i
      call forest(model)
      system = new_system(model)
      call new_workspace(system, work)
      call check_span(system)
      call new_recursion(system, recursion)
      call check(recursion%usable, 'a forest is one')
      associate (nq => system%layout%nq)
         allocate (q(nq), v(nq), a(nq), b(nq))
      end associate
      do i = 1, size(q)
         q(i) = random()
         v(i) = 3*random()
      end do
      call recursive_settle(recursion, q, v)
      call place_frames(model, system%layout, 0.0_wp, q, work%kinematics)
      call update_jacobians(system, work)
      largest = position_residual(system, work)
      call check_close(largest, 0.0_wp, 1.0e-14_wp, 'bodies on their pins')
      largest = velocity_residual(system, work, v)
      call check_close(largest, 0.0_wp, 1.0e-13_wp, 'velocities on the pins')
      call linearise(system, work, 0.0_wp, q, error)
      call check_no_error(error, 'multiplier system')
      call accelerations(system, work, q, v, a)
      call recursive_accelerations(recursion, model%gravity, q, v, b)
      call check(maxval(abs(a)) > 1.0_wp, 'it moves')
      do i = 1, size(q)
         call check_close(b(i), a(i), 1.0e-11_wp*maxval(abs(a)), 'acceleration '//as_text(i))
      end do
   end subroutine test_forest

   !> Each body has one place, behind that of its carrier; one tree is in flight, and no joint closes a loop.
   subroutine check_span(system)
      type(system_type), intent(in) :: system
      integer :: i
      associate (span => system%tree%span, bodies => size(system%layout%q))
         call check(all([(count(span%body == i) == 1, i=1, bodies)]), 'each body has a place')
         call check(all(span%carrier < [(i, i=1, bodies)]), 'behind that of its carrier')
         call check(count(span%carrier < 0) == 1 .and. count(span%side == 0) == 1, 'one tree is in flight')
         call check(span%loops == 0 .and. system%tree%articulated, 'no loop')
      end associate
   end subroutine check_span

   !> Loops, other joints, loads, bodies that are no rigid ones or have no inertia, and scenes where nothing is to be eliminated.
   subroutine test_refused()
      type(model_type) :: model
      integer :: i, points(2)
      do i = 1, 7
         call forest(model)
         select case (i)
         case (1); call join(model, 'loop', joint_revolute, 4, [0.3_wp, 0.1_wp], 13, nil)
         case (2); call join(model, 'line', joint_point_on_line, 4, nil, ground, nil)
         case (3)
            points = [add_place(model, 'p', 4, nil), add_place(model, 'g', ground, nil)]
            call add_spring(model, points(1), points(2), 1.0_wp, 0.0_wp, 0.0_wp)
         case (4); points(1) = add_point_mass(model, 'mass', 1.0_wp, nil)
         case (5); call add_torque(model, 3, constant_law(1.0_wp))
         case (6)
            points(1) = add_rigid(model, 'wire', 1.0_wp, 0.0_wp, nil, nil, 0.0_wp)
            call join(model, 'bead', joint_revolute, 4, [1.0_wp, 0.0_wp], points(1), nil)
         case (7); model%assembly%elimination = .false.
         end select
         call check(.not. usable(model), 'what is no open tree of bodies: '//as_text(i))
      end do
   end subroutine test_refused

   logical function usable(model)
      type(model_type), intent(in) :: model
      type(system_type) :: system
      type(articulated_rigid_type) :: recursion
      system = new_system(model)
      call new_recursion(system, recursion)
      usable = recursion%usable
   end function usable

end program test_recursion
