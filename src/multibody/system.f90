!> System of equations of a model: layout, constraints, loads. Constant during a run; everything that changes lives in
!> `workspace_type`. Floor: multibody.
module limber_multibody_system
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_beam_reduced_body, only: reduced_type
   use limber_model_model, only: model_type, ground
   use limber_model_switches, only: first_states, acts
   use limber_multibody_beam_axis, only: centreline_type, new_centreline
   use limber_multibody_constraint, only: constraint_item_type, jacobian_type, new_jacobian
   use limber_multibody_constraint_list, only: new_joint, new_driver
   use limber_multibody_contact_constraints, only: new_contact
   use limber_multibody_idle_parts, only: set_constraint, set_load
   use limber_multibody_kinematics, only: kinematics_type, new_kinematics
   use limber_multibody_force_elements, only: force_element_type
   use limber_multibody_load_list, only: new_loads, new_event_scalars, new_control_inputs
   use limber_multibody_load, only: load_item_type
   use limber_multibody_marker_registry, only: registry_type, start_registry, end_registry
   use limber_multibody_sparse_matrix, only: sparse_type
   use limber_multibody_topology, only: topology_type, new_tree
   implicit none
   private
   public :: system_type, new_system, workspace_type, new_workspace, body_workspace_type, mark_block, block_place
   public :: let_act, number_equations, switch_of, contact_constraint, number_of_contacts

   !> The equations; constant once it is built
   type, extends(registry_type) :: system_type
      !> Joints first, then drivers, in the order of the model, then the parts that some of them have more than one of, then the
      !> contacts of rigid stops
      type(constraint_item_type), allocatable :: constraints(:)
      !> One for each part of the loads of the model, in their order
      type(load_item_type), allocatable :: loads(:)
      !> Scalars of the events of the model, as laws without a force
      type(force_element_type), allocatable :: events(:)
      !> First inputs of the controls of the model, as laws without a force
      type(force_element_type), allocatable :: inputs(:)
      !> Mass of all bodies of the deck
      real(wp) :: mass = 0.0_wp
      !> Of each body mass, first moment (2) and second moment of mass about the origin of its frame, undeformed; side by side,
      !> since they are all that the steps of a rigid body need (4, bodies)
      real(wp), allocatable :: inertia(:, :)
      !> Number of constraint equations (without the norm constraints)
      integer :: nc = 0
      !> Number of followed angles that constraints ask for: the first of all
      integer :: held_angles = 0
      !> True if some equations are sums of several constraints
      logical :: parted = .false.
      !> Which bodies hang on which, and the unknowns of the multiplier system that are left
      type(topology_type) :: tree
      !> True if there is an exact beam
      logical :: exact = .false.
      !> True if something puts energy in or takes it out: a driver, a load, or the force of the model k_g
      logical :: powered = .false.
      !> True if some load does
      logical :: loaded = .false.
      !> True if some constraint equations repeat others: then each may give way by `slack` times its multiplier (nc)
      logical :: redundant = .false.
      real(wp), allocatable :: slack(:)
      !> Whether each switch of the model is on (switches)
      logical, allocatable :: on(:)
      !> Whether the samples of a control come from outside, and the value of the next ones (controls)
      logical, allocatable :: is_given(:)
      real(wp), allocatable :: given(:)
   end type system_type

   !> Scratch of one body in the multiplier system
   type :: body_workspace_type
      !> Mass matrix and force of the frame; the mass after condensation of eta once the system is factored
      real(wp) :: mass(3, 3) = 0.0_wp, force(3) = 0.0_wp
      !> The force after condensation of eta, and the accelerations that solve the system
      real(wp) :: condensed(3) = 0.0_wp, acceleration(3) = 0.0_wp
      !> Of a frame that hangs on another, or is driven: its accelerations are hanging . unknowns + bias (rates, count)
      real(wp) :: bias(3) = 0.0_wp
      real(wp), allocatable :: hanging(:, :)
      !> Of a frame that is held: the rows that hold it, those in use first, and its accelerations for unit right-hand sides of them
      !> (rates, rows)
      real(wp) :: held(3, 3) = huge(1.0_wp), inverse(3, 3) = 0.0_wp
      !> Coupling (n,3) of eta'' with the frame, and forces on eta (n)
      real(wp), allocatable :: coupling(:, :), eta_force(:)
      !> Scratch of the elastic force (pairs)
      real(wp), allocatable :: s(:)
      !> Constraint equations with multipliers that act on the body: their places among the unknowns (rows), where each comes
      !> from, [constraint, side, row in it] (3, rows), and their eta parts (n, rows)
      integer, allocatable :: rows(:), sources(:, :)
      real(wp), allocatable :: eta_rows(:, :)
      !> Their parts on r' and omega, after the condensation of eta once the system is factored (3, rows)
      real(wp), allocatable :: frame_rows(:, :)
      !> Where the mass matrix of the frame (count, count), the parts of the constraint rows on it, as they are and transposed
      !> (rows, count), and what eta adds between these rows (rows, rows), stand in the multiplier matrix
      integer, allocatable :: frame_place(:, :), across_place(:, :), transposed_place(:, :), rows_place(:, :)
      !> Of an exact beam (else not allocated) the mass matrix of its coordinates and its Cholesky factor, in the lower triangle
      !> (n, n); and a centreline for what is asked at other states
      real(wp), allocatable :: eta_mass(:, :), factor(:, :)
      type(centreline_type), allocatable :: line
   contains
      procedure :: exchange => exchange_body_workspace
   end type body_workspace_type

   !> Scratch of one load: its forces on both bodies (rates)
   type :: load_workspace_type
      real(wp), allocatable :: force(:)
   end type load_workspace_type

   !> Everything that changes while the equations are evaluated; allocated once
   type :: workspace_type
      type(kinematics_type) :: kinematics
      type(body_workspace_type), allocatable :: bodies(:)
      !> Jacobian of each constraint on its two bodies (2, constraints)
      type(jacobian_type), allocatable :: jacobians(:, :)
      type(load_workspace_type), allocatable :: loads(:)
      !> Residuals and right-hand sides of the constraints (nc)
      real(wp), allocatable :: phi(:), gamma(:)
      !> Multiplier matrix of the unknowns [free accelerations of frames; multipliers], and a vector of them
      type(sparse_type) :: matrix
      real(wp), allocatable :: solution(:)
      !> Of redundant constraints: places of the diagonal (nc), and a correction of the solution
      integer, allocatable :: slack_place(:)
      real(wp), allocatable :: correction(:)
      !> Multipliers of the last solution (nc): the constraints act on the bodies with -Jacobian^T lambda
      real(wp), allocatable :: lambda(:)
      !> Count of evaluations of the right-hand side
      integer :: evaluations = 0
   contains
      procedure :: exchange => exchange_workspace
   end type workspace_type

contains

   !> Builds the equations of a model.
   function new_system(model) result(system)
      type(model_type), intent(in) :: model
      type(system_type) :: system
      type(load_item_type), allocatable :: loads(:)
      type(force_element_type), allocatable :: events(:), inputs(:)
      integer :: i
      call start_registry(system, model)
      allocate (system%inertia(4, size(model%bodies)))
      do i = 1, size(model%bodies)
         associate (body => model%bodies(i)%reduced)
            system%inertia(:, i) = [body%mass, body%c0(1), body%c0(2), body%i0]
            if (.not. system%layout%carries(i)) system%mass = system%mass + body%mass
         end associate
      end do
      call new_constraints(model, system)
      system%held_angles = size(system%angles)
      call new_contacts(model, system)
      call new_loads(system, loads)
      call move_alloc(loads, system%loads)
      call new_event_scalars(system, events)
      call move_alloc(events, system%events)
      call new_control_inputs(system, inputs)
      call move_alloc(inputs, system%inputs)
      call end_registry(system)
      system%powered = any([(system%constraints(i)%item%driven, i=1, size(system%constraints))])
      system%loaded = any([(system%loads(i)%item%powered, i=1, size(system%loads))])
      allocate (system%on, source=first_states(model))
      allocate (system%is_given(size(system%inputs)), source=.false.)
      allocate (system%given(size(system%inputs)), source=0.0_wp)
      ! A switch may put in energy, or take it
      if (size(system%on) > 0) system%loaded = .true.
      call let_act(system)
      call number_equations(system)
      system%tree = new_tree(system, system%constraints, system%nc, model%assembly%elimination)
      system%powered = system%powered .or. system%loaded
      do i = 1, size(model%bodies)
         associate (body => model%bodies(i)%reduced)
            if (body%damped .or. body%geometric) system%powered = .true.
            if (body%is_exact) system%exact = .true.
         end associate
      end do
   end function new_system

   !> Joints, drivers, and further parts of couplers, with their equations; and places for the contacts.
   subroutine new_constraints(model, system)
      type(model_type), intent(in) :: model
      type(system_type), intent(inout) :: system
      type(constraint_item_type), allocatable :: whole(:)
      type(constraint_item_type), allocatable :: parts(:)
      integer :: i, joints
      joints = size(model%joints)
      allocate (whole(joints + size(model%drivers)), parts(0))
      do i = 1, joints
         call new_joint(system, i, whole(i)%item, parts)
      end do
      do i = 1, size(model%drivers)
         call new_driver(system, i, whole(joints + i)%item)
      end do
      allocate (system%constraints(size(whole) + size(parts) + number_of_contacts(model)))
      do i = 1, size(whole)
         call move_alloc(whole(i)%item, system%constraints(i)%item)
      end do
      system%parted = size(parts) > 0
      do i = 1, size(parts)
         call move_alloc(parts(i)%item, system%constraints(size(whole) + i)%item)
         associate (part => system%constraints(size(whole) + i)%item, &
            & item => system%constraints(system%constraints(size(whole) + i)%item%part_of)%item)
            part%scale = item%scale
            part%label = item%label
         end associate
      end do
   end subroutine new_constraints

   !> Contacts, in the places that are left behind the other constraints.
   subroutine new_contacts(model, system)
      type(model_type), intent(in) :: model
      type(system_type), intent(inout) :: system
      integer :: i
      do i = 1, number_of_contacts(model)
         call new_contact(system, i, system%constraints(contact_constraint(system, i))%item)
      end do
   end subroutine new_contacts

   !> Number of contacts of rigid stops.
   pure integer function number_of_contacts(model) result(number)
      type(model_type), intent(in) :: model
      number = 0
      if (allocated(model%contacts)) number = size(model%contacts)
   end function number_of_contacts

   !> Index of the constraint of a contact.
   pure integer function contact_constraint(system, contact) result(constraint)
      type(system_type), intent(in) :: system
      !> Its index in the model
      integer, intent(in) :: contact
      constraint = size(system%constraints) - size(system%model%contacts) + contact
   end function contact_constraint

   !> Lets joints, drivers and loads act as the switches are.
   subroutine let_act(system)
      type(system_type), intent(inout) :: system
      integer :: i
      do i = 1, size(system%constraints)
         call set_constraint(system%constraints(i)%item, acts(switch_of(system, i), system%on))
      end do
      do i = 1, size(system%loads)
         call set_load(system%loads(i)%item, acts(system%model%load_parts(i)%switch, system%on))
      end do
   end subroutine let_act

   !> Switch that a constraint asks for, as of a joint.
   pure integer function switch_of(system, constraint) result(switch)
      type(system_type), intent(in) :: system
      !> Its index
      integer, intent(in) :: constraint
      integer :: number, joints
      number = constraint
      if (system%constraints(constraint)%item%part_of > 0) number = system%constraints(constraint)%item%part_of
      joints = size(system%model%joints)
      if (number <= joints) then
         switch = system%model%joints(number)%switch
      else if (number > size(system%constraints) - number_of_contacts(system%model)) then
         switch = system%model%contacts(number + number_of_contacts(system%model) - size(system%constraints))%switch
      else
         switch = system%model%drivers(number - joints)%switch
      end if
   end function switch_of

   !> Numbers the equations of all constraints that act.
   subroutine number_equations(system)
      type(system_type), intent(inout) :: system
      integer :: i
      system%nc = 0
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            item%first = system%nc + 1
            if (item%part_of > 0) then
               item%first = system%constraints(item%part_of)%item%first
            else
               system%nc = system%nc + item%rows
            end if
         end associate
      end do
   end subroutine number_equations

   !> Room for everything that changes.
   subroutine new_workspace(system, work)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(out) :: work
      integer :: i, side, row, body, old
      work%kinematics = new_kinematics(system%model, system%marker_points, system%angles, system%bends)
      allocate (work%bodies(size(system%model%bodies)), work%jacobians(2, size(system%constraints)))
      allocate (work%phi(system%nc), work%gamma(system%nc), work%lambda(system%nc))
      allocate (work%solution(system%tree%unknowns))
      work%lambda = 0.0_wp
      allocate (work%loads(size(system%loads)))
      do i = 1, size(work%loads)
         allocate (work%loads(i)%force(sum(system%loads(i)%item%rates)))
      end do
      do i = 1, size(work%bodies)
         call size_body(system%model%bodies(i)%reduced, work%bodies(i))
      end do
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            do side = 1, 2
               body = item%bodies(side)
               work%jacobians(side, i) = new_jacobian(item%rows, merge(0, system%layout%n(max(1, body)), body == ground))
               if (body == ground .or. .not. is_solved(system, i)) cycle
               old = size(work%bodies(body)%rows)
               work%bodies(body)%rows = [work%bodies(body)%rows, rows_of(system, i)]
               work%bodies(body)%sources = reshape([work%bodies(body)%sources, ([i, side, row], row=1, item%rows)], &
                  & [3, old + item%rows])
            end do
         end associate
      end do
      do i = 1, size(work%bodies)
         allocate (work%bodies(i)%eta_rows(system%layout%n(i), size(work%bodies(i)%rows)))
         allocate (work%bodies(i)%frame_rows(3, size(work%bodies(i)%rows)), source=0.0_wp)
         call start_hanging(system, i, work%bodies(i)%hanging)
      end do
      call analyse_pattern(system, work)
   end subroutine new_workspace

   !> The constant entries of a frame's accelerations for unit values of the unknowns: its own.
   pure subroutine start_hanging(system, body, hanging)
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      real(wp), allocatable, intent(out) :: hanging(:, :)
      integer :: j
      allocate (hanging(system%layout%rates(body), system%tree%count(body)))
      hanging = 0.0_wp
      if (system%tree%grip(body) > 0) return
      if (system%tree%joint(body) == 0) then
         do j = 1, size(hanging, 2)
            hanging(j, j) = 1.0_wp
         end do
      else if (system%layout%framed(body) .and. system%tree%driver(body) == 0) then
         hanging(3, size(hanging, 2)) = 1.0_wp
      end if
   end subroutine start_hanging

   !> Unknowns on which a body's frame depends.
   pure function columns_of(system, body) result(list)
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      integer :: list(system%tree%count(body))
      list = system%tree%columns(:size(list), body)
   end function columns_of

   !> Whether a constraint has multipliers among the unknowns.
   pure logical function is_solved(system, constraint)
      type(system_type), intent(in) :: system
      integer, intent(in) :: constraint
      is_solved = .false.
      associate (item => system%constraints(constraint)%item)
         if (item%rows > 0) is_solved = system%tree%row(item%first) > 0
      end associate
   end function is_solved

   !> Places of a constraint's multipliers among the unknowns.
   pure function rows_of(system, constraint) result(list)
      type(system_type), intent(in) :: system
      integer, intent(in) :: constraint
      integer :: list(system%constraints(constraint)%item%rows)
      associate (first => system%constraints(constraint)%item%first)
         list = system%tree%row(first:first + size(list) - 1)
      end associate
   end function rows_of

   !> Pattern of the multiplier matrix, and the place in it of everything that will be filled in.
   subroutine analyse_pattern(system, work)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      integer :: i, side, body
      do i = 1, size(work%bodies)
         call mark_block(work%matrix, columns_of(system, i), columns_of(system, i))
         if (system%layout%n(i) > 0) call mark_block(work%matrix, work%bodies(i)%rows, work%bodies(i)%rows)
      end do
      do i = 1, size(system%constraints)
         do side = 1, 2
            body = system%constraints(i)%item%bodies(side)
            if (body == ground .or. .not. is_solved(system, i)) cycle
            call mark_block(work%matrix, rows_of(system, i), columns_of(system, body))
            call mark_block(work%matrix, columns_of(system, body), rows_of(system, i))
         end do
      end do
      call work%matrix%analyse(system%tree%unknowns)
      if (system%redundant) then
         allocate (work%slack_place(system%nc), work%correction(system%tree%unknowns))
         do i = 1, system%nc
            work%slack_place(i) = work%matrix%place(system%tree%row(i), system%tree%row(i))
         end do
      end if
      do i = 1, size(work%bodies)
         associate (body => work%bodies(i))
            body%frame_place = block_place(work%matrix, columns_of(system, i), columns_of(system, i))
            body%across_place = block_place(work%matrix, body%rows, columns_of(system, i))
            body%transposed_place = transpose(block_place(work%matrix, columns_of(system, i), body%rows))
            if (system%layout%n(i) > 0) body%rows_place = block_place(work%matrix, body%rows, body%rows)
         end associate
      end do
   end subroutine analyse_pattern

   !> Marks a block of the pattern.
   subroutine mark_block(matrix, rows, columns)
      type(sparse_type), intent(inout) :: matrix
      integer, intent(in) :: rows(:), columns(:)
      integer :: i, j
      do j = 1, size(columns)
         do i = 1, size(rows)
            call matrix%mark(rows(i), columns(j))
         end do
      end do
   end subroutine mark_block

   !> Places of a block's entries (rows, columns).
   function block_place(matrix, rows, columns) result(place)
      type(sparse_type), intent(in) :: matrix
      integer, intent(in) :: rows(:), columns(:)
      integer, allocatable :: place(:, :)
      integer :: i, j
      allocate (place(size(rows), size(columns)))
      do j = 1, size(columns)
         do i = 1, size(rows)
            place(i, j) = matrix%place(rows(i), columns(j))
         end do
      end do
   end function block_place

   subroutine size_body(body, scratch)
      type(reduced_type), intent(in) :: body
      type(body_workspace_type), intent(inout) :: scratch
      integer :: pairs, i
      pairs = body%bending*(body%bending + 1)/2
      allocate (scratch%coupling(body%n, 3), scratch%eta_force(body%n), scratch%s(pairs), scratch%rows(0))
      allocate (scratch%sources(3, 0))
      if (.not. body%is_exact) return
      allocate (scratch%eta_mass(body%n, body%n), scratch%factor(body%n, body%n), scratch%line)
      call new_centreline(body%exact, scratch%line)
      scratch%factor = 0.0_wp
      do i = 1, body%n
         scratch%factor(i, i) = 1.0_wp
      end do
      scratch%eta_mass = scratch%factor
   end subroutine size_body

   !> Saves or restores its memory.
   subroutine exchange_body_workspace(self, snapshot)
      class(body_workspace_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%exchange('mass', self%mass)
      call snapshot%exchange('force', self%force)
      call snapshot%exchange('condensed', self%condensed)
      call snapshot%exchange('acceleration', self%acceleration)
      call snapshot%exchange('bias', self%bias)
      call snapshot%exchange('held', self%held)
      call snapshot%exchange('inverse', self%inverse)
      call snapshot%keep('hanging', self%hanging)
      call snapshot%keep('coupling', self%coupling)
      call snapshot%keep('eta_force', self%eta_force)
      call snapshot%keep('s', self%s)
      call snapshot%keep('eta_rows', self%eta_rows)
      call snapshot%keep('frame_rows', self%frame_rows)
      call snapshot%keep('eta_mass', self%eta_mass)
      call snapshot%keep('factor', self%factor)
      ! Not saved: rows, sources, frame_place, across_place, transposed_place, rows_place, line
   end subroutine exchange_body_workspace

   !> Saves or restores all that changes.
   subroutine exchange_workspace(self, snapshot)
      class(workspace_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      integer :: i, j
      call self%kinematics%exchange(snapshot)
      do i = 1, size(self%bodies)
         call self%bodies(i)%exchange(snapshot)
      end do
      do i = 1, size(self%jacobians, 2)
         do j = 1, 2
            call self%jacobians(j, i)%exchange(snapshot)
         end do
      end do
      do i = 1, size(self%loads)
         call snapshot%keep('force', self%loads(i)%force)
      end do
      call snapshot%keep('phi', self%phi)
      call snapshot%keep('gamma', self%gamma)
      call self%matrix%exchange(snapshot)
      call snapshot%keep('solution', self%solution)
      call snapshot%keep('correction', self%correction)
      call snapshot%keep('lambda', self%lambda)
      call snapshot%exchange('evaluations', self%evaluations)
      ! Not saved: slack_place
   end subroutine exchange_workspace

end module limber_multibody_system
