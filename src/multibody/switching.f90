!> Switches between two steps of a motion: the system takes up or lets go joints, drivers and loads, and finds its topology and its
!> redundant equations anew. Floor: multibody. Source: doc/theory, section 5.20, eqs. (5.73), (5.74).
module limber_multibody_switching
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text
   use limber_model_model, only: ground
   use limber_multibody_assembly_newton, only: close_positions
   use limber_multibody_compliant_constraints, only: soften_constraints
   use limber_multibody_constraint_matrix, only: constraint_matrix_type, new_constraint_matrix
   use limber_multibody_constraint_rank, only: assembly_type, check_rank
   use limber_multibody_multiplier_system, only: place_constraints
   use limber_multibody_equations_of_motion, only: position_residual, worst_constraint
   use limber_multibody_function_constraints, only: linear_type
   use limber_multibody_kinematics, only: angle_type
   use limber_multibody_system, only: system_type, workspace_type, new_workspace, let_act, number_equations
   use limber_multibody_topology, only: new_tree
   implicit none
   private
   public :: set_switches, keep_values, missed_positions, find_redundant, exchange_switches

contains

   !> Sets all switches. Where joints or drivers begin or end to act, the system is numbered anew and its workspace made anew.
   subroutine set_switches(system, work, on, renewed)
      type(system_type), intent(inout) :: system
      type(workspace_type), intent(inout) :: work
      !> New states (switches)
      logical, intent(in) :: on(:)
      !> Whether the constraints are others than before
      logical, intent(out) :: renewed
      integer :: i, rows(size(system%constraints))
      rows = [(system%constraints(i)%item%rows, i=1, size(rows))]
      system%on = on
      call let_act(system)
      renewed = any([(system%constraints(i)%item%rows /= rows(i), i=1, size(rows))])
      if (renewed) call renew(system, work)
   end subroutine set_switches

   !> Numbers the equations, finds the topology and makes the workspace anew.
   subroutine renew(system, work)
      type(system_type), intent(inout) :: system
      type(workspace_type), intent(inout) :: work
      call number_equations(system)
      system%redundant = .false.
      system%tree = new_tree(system, system%constraints, system%nc, system%model%assembly%elimination)
      call renew_workspace(system, work)
   end subroutine renew

   !> A workspace of the same motion: angles that are followed and counts of work go on.
   subroutine renew_workspace(system, work)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(angle_type), allocatable :: angles(:)
      integer :: counts(2)
      counts = [work%evaluations, work%matrix%factorisations]
      call move_alloc(work%kinematics%angles, angles)
      call new_workspace(system, work)
      call move_alloc(angles, work%kinematics%angles)
      work%evaluations = counts(1)
      work%matrix%factorisations = counts(2)
      work%lambda = 0.0_wp
   end subroutine renew_workspace

   !> Lets constraints that begin to act keep the values that they have at a state, if they are of that kind: couplers and gears,
   !> rods without a length.
   subroutine keep_values(system, work, before, t, q)
      type(system_type), intent(inout) :: system
      type(workspace_type), intent(inout) :: work
      !> Number of equations of each before (constraints)
      integer, intent(in) :: before(:)
      !> Time; coordinates (nq)
      real(wp), intent(in) :: t, q(:)
      real(wp) :: largest
      integer :: i
      call place_constraints(system, work, t, q)
      largest = position_residual(system, work)
      do i = 1, size(before)
         if (before(i) > 0) cycle
         select type (item => system%constraints(i)%item)
         type is (linear_type)
            if (item%keeps .and. item%part_of == 0) item%offset(:item%rows) = item%offset(:item%rows) &
               & + work%phi(item%first:item%first + item%rows - 1)
         end select
      end do
   end subroutine keep_values

   !> By how much constraints that begin to act miss their positions at a state: norm of the residual (constraints) [length, rad];
   !> zero for all others.
   subroutine missed_positions(system, work, before, t, q, missed)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Number of equations of each before (constraints)
      integer, intent(in) :: before(:)
      !> Time; coordinates (nq)
      real(wp), intent(in) :: t, q(:)
      real(wp), intent(out) :: missed(:)
      real(wp) :: largest
      integer :: i
      missed = 0.0_wp
      if (system%nc == 0) return
      call place_constraints(system, work, t, q)
      largest = position_residual(system, work)
      do i = 1, size(missed)
         associate (item => system%constraints(i)%item)
            if (before(i) > 0 .or. item%rows == 0 .or. item%part_of > 0) cycle
            missed(i) = norm2(work%phi(item%first:item%first + item%rows - 1))
            if (points_back(system, work, i)) missed(i) = 2*item%scale
         end associate
      end do
   end subroutine missed_positions

   !> Whether a joint that keeps an angle is half a turn away from it, where its equation, the sine of the angle, is satisfied too.
   pure logical function points_back(system, work, joint)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      !> Index of the constraint
      integer, intent(in) :: joint
      points_back = .false.
      if (joint > size(system%model%joints)) return
      if (.not. system%model%joints(joint)%keeps_angle) return
      associate (item => system%constraints(joint)%item)
         ! The equation of the angle is the last, and grows with the rotation of the first body
         if (item%bodies(1) /= ground) then
            points_back = work%jacobians(1, joint)%z(item%rows, 3) < 0.0_wp
         else
            points_back = work%jacobians(2, joint)%z(item%rows, 3) > 0.0_wp
         end if
      end associate
   end function points_back

   !> Brings a state onto constraints that begin to act, and lets redundant equations give way, where there are some.
   subroutine find_redundant(system, work, t, q, error)
      type(system_type), intent(inout) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      !> Coordinates, near the constraints (nq)
      real(wp), intent(inout) :: q(:)
      !> The constraints stop at a dead centre, or cannot be kept
      type(error_type), allocatable, intent(out) :: error
      type(constraint_matrix_type) :: matrix
      type(assembly_type) :: found
      integer :: culprit
      real(wp) :: residual
      logical :: done
      if (system%nc == 0) return
      allocate (found%redundancy, found%singular)
      call new_constraint_matrix(system, .true., matrix)
      call close_positions(system, work, matrix, t, q, done)
      if (.not. done) then
         call worst_constraint(system, work, culprit, residual)
         call raise(error, system%constraints(culprit)%item%label//' cannot be kept at t = '//as_text(t, 8)//' with all that is'// &
            & ' active then; '//as_text(residual, 3)//' is left open')
         return
      end if
      call check_rank(system, work, matrix, t, q, found, error, culprit)
      if (allocated(error)) return
      if (found%rank == system%nc) return
      call soften_constraints(system)
      call renew_workspace(system, work)
   end subroutine find_redundant

   !> Saves or restores the states of all switches. On restoring the system is that of these states.
   subroutine exchange_switches(system, work, snapshot, renewed)
      type(system_type), intent(inout) :: system
      type(workspace_type), intent(inout) :: work
      type(snapshot_type), intent(inout) :: snapshot
      !> Whether restoring has changed what acts
      logical, intent(out) :: renewed
      logical :: on(size(system%on)), redundant, others
      integer :: i
      renewed = .false.
      if (size(on) == 0) return
      on = system%on
      redundant = system%redundant
      do i = 1, size(on)
         call snapshot%exchange('switch', on(i))
      end do
      call snapshot%exchange('redundant', redundant)
      if (snapshot%restoring) then
         renewed = any(on .neqv. system%on)
         call set_switches(system, work, on, others)
      end if
      do i = 1, size(system%constraints)
         select type (item => system%constraints(i)%item)
         type is (linear_type)
            if (item%keeps) call snapshot%exchange('kept', item%offset)
         end select
      end do
      if (redundant .neqv. system%redundant) then
         call soften_constraints(system)
         call renew_workspace(system, work)
      end if
   end subroutine exchange_switches

end module limber_multibody_switching
