!> Topology: which bodies carry which. A revolute joint at the origin of a body's frame gives the place of that frame, a driver its
!> angle: both are solved in closed form, so that neither they nor what they give are unknowns of the multiplier system. A body that
!> hangs on the ground has its rotation left; a driven one on the ground nothing. Whatever else joins a body to the ground or to
!> bodies of known motion is solved with it: a weld or a moving guide leaves nothing, a fixed guide one coordinate along it. Joints
!> that close loops, and those on deforming points, keep their multipliers. Floor: multibody. Source: doc/theory, eqs. (4.6),
!> (4.8)-(4.12).
module limber_multibody_topology
   use limber_base_kinds, only: wp
   use limber_model_model, only: model_type, driver_x, driver_y, ground
   use limber_multibody_constraint, only: constraint_item_type
   use limber_multibody_drivers, only: driven_angle_type
   use limber_multibody_known_bodies, only: known_bodies_type, new_holding, find_grip
   use limber_multibody_point_joints, only: revolute_type
   use limber_multibody_layout, only: layout_type
   use limber_multibody_marker_registry, only: registry_type
   use limber_multibody_spanning_tree, only: spanning_tree_type, new_spanning_tree
   implicit none
   private
   public :: topology_type, new_tree

   !> Unknowns on which a frame may depend: in a long chain every few bodies one is left free, or the matrix would be full
   integer, parameter :: most = 4

   !> Constant structure; arrays are over bodies unless said otherwise
   type :: topology_type
      !> Constraints of each body, and a way from the ground to all bodies
      type(spanning_tree_type) :: span
      !> True if all constraints are hinges without a driver, none of which closes a loop: articulated trees
      logical :: articulated = .false.
      !> Bodies, each behind the one that carries it
      integer, allocatable :: order(:)
      !> Constraint that places the frame's origin, and the one that gives its angle; 0: none
      integer, allocatable :: joint(:), driver(:)
      !> Of a placed frame: which side of the joint it is (1 or 2), the body that carries it, and the marker it sits on
      integer, allocatable :: side(:), carrier(:), marker(:)
      !> Number of rows that hold a frame together, which are solved with it, and the constraints that they belong to, zeros behind
      !> (bodies); (3, bodies)
      integer, allocatable :: grip(:), holders(:, :)
      !> True if any body is held so
      logical :: holds = .false.
      !> Of a frame whose origin is driven along x and y: the two drivers of the model, 0: it is not; and their equations, where
      !> nothing but these and a driven angle holds it, so that they are solved one by one (2, bodies)
      integer, allocatable :: axes(:, :), axis_rows(:, :)
      !> Whether the origin of a frame, and its angle, are known in time and found at once: 1 and 2 (2, bodies)
      logical, allocatable :: given(:, :)
      !> Bodies of which something is known so and changes, each behind the one that carries it: not those that only hang on the
      !> ground
      integer, allocatable :: timed(:)
      !> True if the frame's own rates are unknowns, all of them
      logical, allocatable :: plain(:)
      !> Number of unknowns on which the frame's accelerations depend, and their indices (most, bodies)
      integer, allocatable :: count(:), columns(:, :)
      !> Body that a constraint places, holds or whose angle it gives; 0: none (constraints)
      integer, allocatable :: body(:)
      !> Constraints that frames in their places do not keep by themselves: projections close them
      integer, allocatable :: open(:)
      !> Number of unknown accelerations
      integer :: free = 0
      !> Place of each constraint equation among the unknowns; 0: solved in closed form (nc)
      integer, allocatable :: row(:)
      !> Constraint equations that have one, in the order of the unknowns, behind the accelerations
      integer, allocatable :: equations(:)
      !> Number of all unknowns
      integer :: unknowns = 0
   end type topology_type

   !> Bodies that could hang on others, by the joint: a side 2 (c - 1) + s is a hinge at the origin of that side's frame
   type :: candidates_type
      !> Those whose carriers are in the tree, as a heap; only the first `count` are in use
      integer, allocatable :: heap(:)
      integer :: count = 0
      !> Whether a body is in the tree (bodies); whether it is rigid and its motion known, as that of the ground is (0:bodies)
      logical, allocatable :: done(:), known(:)
      !> What could hold bodies; the bodies that are to be looked at, of which the first `waiting` are in use; no body before
      !> `partial` has a grip
      type(known_bodies_type) :: holding
      integer, allocatable :: queue(:)
      integer :: waiting = 0, partial = 1
   end type candidates_type

contains

   !> The topology of a model. Its constraints are the joints in the order of the model, then the drivers.
   function new_tree(registry, constraints, nc, eliminates) result(tree)
      class(registry_type), intent(in) :: registry
      type(constraint_item_type), intent(in) :: constraints(:)
      !> Number of constraint equations
      integer, intent(in) :: nc
      !> Whether anything is solved in closed form; else all frames keep their unknowns, all constraints their multipliers
      logical, intent(in) :: eliminates
      type(topology_type) :: tree
      type(candidates_type) :: candidates
      integer :: bodies, done, i, left
      logical :: found
      bodies = size(registry%layout%q)
      call start_tree(bodies, size(constraints), nc, tree)
      allocate (candidates%done(bodies), candidates%known(0:bodies), candidates%queue(bodies))
      candidates%done = .false.
      candidates%known = .false.
      candidates%known(ground) = .true.
      tree%span = new_spanning_tree(constraints, bodies)
      tree%articulated = eliminates .and. tree%span%loops == 0 .and. are_hinges(constraints)
      allocate (candidates%heap(2*size(constraints)))
      associate (layout => registry%layout)
         if (eliminates) then
            call find_drivers(constraints, tree)
            call release(registry, constraints, tree%span, ground, candidates)
            call new_holding(registry, constraints, candidates%holding)
            call wait_for(candidates, constraints, tree%span, ground)
         end if
         left = 1
         do done = 1, bodies
            call hold_next(registry, constraints, candidates, tree, i, found)
            if (.not. found) call hang_next(constraints, candidates, tree, i, found)
            if (.not. found) call hold_partly(layout, constraints, candidates, tree, i, found)
            if (.not. found) then
               do while (candidates%done(left))
                  left = left + 1
               end do
               i = left
            end if
            tree%order(done) = i
            candidates%done(i) = .true.
            call number_unknowns(layout, i, tree)
            candidates%known(i) = tree%count(i) == 0 .and. layout%n(i) == 0
            if (.not. eliminates) cycle
            if (can_carry(layout, tree, i)) call release(registry, constraints, tree%span, i, candidates)
            if (candidates%known(i)) call wait_for(candidates, constraints, tree%span, i)
         end do
         call find_axes(registry, tree)
         call release_driven(layout, constraints, size(registry%model%joints), tree)
      end associate
      call find_given(constraints, tree)
      call find_placed(size(registry%model%joints), tree)
      call find_open(size(constraints), tree)
      call number_rows(constraints, tree)
   end function new_tree

   !> Room for all, nothing placed yet.
   subroutine start_tree(bodies, constraints, nc, tree)
      integer, intent(in) :: bodies, constraints, nc
      type(topology_type), intent(inout) :: tree
      allocate (tree%order(bodies), tree%joint(bodies), tree%driver(bodies), tree%side(bodies), tree%carrier(bodies), &
         & tree%marker(bodies), tree%plain(bodies), tree%count(bodies), tree%columns(most, bodies), tree%row(nc), &
         & tree%body(constraints), tree%grip(bodies), tree%holders(3, bodies), &
         & tree%axes(2, bodies), tree%axis_rows(2, bodies), tree%given(2, bodies))
      tree%given = .false.
      tree%order = 0
      tree%joint = 0
      tree%driver = 0
      tree%side = 0
      tree%carrier = ground
      tree%marker = 0
      tree%count = 0
      tree%columns = 0
      tree%grip = 0
      tree%holders = 0
      tree%axes = 0
      tree%axis_rows = 0
   end subroutine start_tree

   !> The first driver of each body's angle.
   subroutine find_drivers(constraints, tree)
      type(constraint_item_type), intent(in) :: constraints(:)
      type(topology_type), intent(inout) :: tree
      integer :: i, body
      do i = size(constraints), 1, -1
         select type (item => constraints(i)%item)
         type is (driven_angle_type)
            body = item%bodies(1)
            tree%driver(body) = i
         end select
      end do
   end subroutine find_drivers

   !> Whether all constraints are hinges that no driver turns.
   pure logical function are_hinges(constraints)
      type(constraint_item_type), intent(in) :: constraints(:)
      integer :: i
      are_hinges = .true.
      do i = 1, size(constraints)
         select type (item => constraints(i)%item)
         type is (revolute_type)
            are_hinges = are_hinges .and. .not. item%driven
         class default
            are_hinges = .false.
         end select
      end do
   end function are_hinges

   !> Takes note of all that could hang on a body, or the ground: by a hinge at the origin of its own frame.
   pure subroutine release(registry, constraints, span, body, candidates)
      class(registry_type), intent(in) :: registry
      type(constraint_item_type), intent(in) :: constraints(:)
      type(spanning_tree_type), intent(in) :: span
      integer, intent(in) :: body
      type(candidates_type), intent(inout) :: candidates
      integer :: number, c, own
      number = span%first(body)
      do while (number > 0)
         c = (number + 1)/2
         own = 3 - (number - 2*(c - 1))
         number = span%next(number)
         if (constraints(c)%item%bodies(own) == ground) cycle
         select type (item => constraints(c)%item)
         type is (revolute_type)
            if (at_origin(registry%model, registry%marker_points(item%markers(own)))) call put(candidates, 2*(c - 1) + own)
         end select
      end do
   end subroutine release

   !> Puts a candidate into the heap: least number first.
   pure subroutine put(candidates, number)
      type(candidates_type), intent(inout) :: candidates
      integer, intent(in) :: number
      integer :: i
      candidates%count = candidates%count + 1
      i = candidates%count
      do while (i > 1)
         if (candidates%heap(i/2) <= number) exit
         candidates%heap(i) = candidates%heap(i/2)
         i = i/2
      end do
      candidates%heap(i) = number
   end subroutine put

   !> Takes the least number out of the heap.
   pure subroutine take(candidates, number)
      type(candidates_type), intent(inout) :: candidates
      integer, intent(out) :: number
      integer :: i, child, last
      number = candidates%heap(1)
      last = candidates%heap(candidates%count)
      candidates%count = candidates%count - 1
      i = 1
      do while (2*i <= candidates%count)
         child = 2*i
         if (child < candidates%count) then
            if (candidates%heap(child + 1) < candidates%heap(child)) child = child + 1
         end if
         if (candidates%heap(child) >= last) exit
         candidates%heap(i) = candidates%heap(child)
         i = child
      end do
      candidates%heap(i) = last
   end subroutine take

   !> The next body that can be hung on what is there, by the first joint that does.
   subroutine hang_next(constraints, candidates, tree, body, found)
      type(constraint_item_type), intent(in) :: constraints(:)
      type(candidates_type), intent(inout) :: candidates
      type(topology_type), intent(inout) :: tree
      integer, intent(out) :: body
      logical, intent(out) :: found
      integer :: number, i, own
      body = 0
      found = .false.
      do while (candidates%count > 0)
         call take(candidates, number)
         i = (number + 1)/2
         own = number - 2*(i - 1)
         body = constraints(i)%item%bodies(own)
         if (candidates%done(body)) cycle
         call hang(constraints, i, own, body, tree)
         found = .true.
         return
      end do
   end subroutine hang_next

   !> Hangs a body on the other side of a revolute joint.
   subroutine hang(constraints, joint, side, body, tree)
      type(constraint_item_type), intent(in) :: constraints(:)
      !> The joint, and the side of it that the body is
      integer, intent(in) :: joint, side, body
      type(topology_type), intent(inout) :: tree
      select type (item => constraints(joint)%item)
      type is (revolute_type)
         tree%joint(body) = joint
         tree%side(body) = side
         tree%carrier(body) = item%bodies(3 - side)
         tree%marker(body) = item%markers(3 - side)
      end select
   end subroutine hang

   !> Takes note of the bodies that a body of known motion, or the ground, may hold.
   subroutine wait_for(candidates, constraints, span, body)
      type(candidates_type), intent(inout) :: candidates
      type(constraint_item_type), intent(in) :: constraints(:)
      type(spanning_tree_type), intent(in) :: span
      integer, intent(in) :: body
      integer :: i, c
      if (.not. candidates%holding%useful) return
      if (body == ground) then
         do i = size(candidates%done), 1, -1
            if (span%first(i) > 0) call note(i)
         end do
         return
      end if
      i = span%first(body)
      do while (i > 0)
         c = (i + 1)/2
         if (candidates%holding%suits(c)) call note(constraints(c)%item%bodies(3 - (i - 2*(c - 1))))
         i = span%next(i)
      end do

   contains

      subroutine note(other)
         integer, intent(in) :: other
         if (other == ground) return
         if (candidates%done(other) .or. any(candidates%queue(:candidates%waiting) == other)) return
         candidates%waiting = candidates%waiting + 1
         candidates%queue(candidates%waiting) = other
      end subroutine note

   end subroutine wait_for

   !> The next body whose motion follows from what is known.
   subroutine hold_next(registry, constraints, candidates, tree, body, found)
      class(registry_type), intent(in) :: registry
      type(constraint_item_type), intent(in) :: constraints(:)
      type(candidates_type), intent(inout) :: candidates
      type(topology_type), intent(inout) :: tree
      integer, intent(out) :: body
      logical, intent(out) :: found
      integer :: list(3), number, rows, k, own
      body = 0
      found = .false.
      do while (candidates%waiting > 0)
         body = candidates%queue(candidates%waiting)
         candidates%waiting = candidates%waiting - 1
         if (candidates%done(body)) cycle
         call find_grip(candidates%holding, tree%span, constraints, candidates%known, body, registry%layout%rates(body), list, &
            & number, rows)
         if (rows < registry%layout%rates(body)) cycle
         found = .true.
         ! A hinge at the origin is solved at less cost
         do k = 1, number
            select type (item => constraints(list(k))%item)
            type is (revolute_type)
               own = merge(1, 2, item%bodies(1) == body)
               if (.not. at_origin(registry%model, registry%marker_points(item%markers(own)))) cycle
               if (registry%layout%framed(body) .and. .not. any(list == tree%driver(body) .and. list > 0)) cycle
               call hang(constraints, list(k), own, body, tree)
               return
            end select
         end do
         call hold(list, rows, body, tree)
         return
      end do
   end subroutine hold_next

   !> The next body part of whose motion follows from what is known.
   subroutine hold_partly(layout, constraints, candidates, tree, body, found)
      type(layout_type), intent(in) :: layout
      type(constraint_item_type), intent(in) :: constraints(:)
      type(candidates_type), intent(inout) :: candidates
      type(topology_type), intent(inout) :: tree
      integer, intent(out) :: body
      logical, intent(out) :: found
      integer :: list(3), number, rows
      found = .false.
      body = 0
      if (.not. candidates%holding%useful) return
      do body = candidates%partial, size(candidates%done)
         if (candidates%done(body)) cycle
         call find_grip(candidates%holding, tree%span, constraints, candidates%known, body, layout%rates(body), list, number, rows)
         if (rows == 0) cycle
         ! A driven angle alone is solved at less cost
         if (number == 1 .and. list(1) == tree%driver(body)) cycle
         found = .true.
         call hold(list, rows, body, tree)
         exit
      end do
      candidates%partial = body
   end subroutine hold_partly

   !> Notes what holds a body.
   pure subroutine hold(list, rows, body, tree)
      integer, intent(in) :: list(3), rows, body
      type(topology_type), intent(inout) :: tree
      tree%holds = .true.
      tree%grip(body) = rows
      tree%holders(:, body) = list
      ! An angle that is driven but not among these keeps its multiplier
      tree%driver(body) = 0
   end subroutine hold

   !> Held frames whose origins are driven along both axes of space: they are placed at once.
   subroutine find_axes(registry, tree)
      class(registry_type), intent(in) :: registry
      type(topology_type), intent(inout) :: tree
      integer :: body, k, driver, axes(2)
      if (.not. tree%holds) return
      do body = 1, size(tree%grip)
         axes = 0
         do k = 1, count(tree%holders(:, body) > 0)
            driver = tree%holders(k, body) - size(registry%model%joints)
            if (driver < 1) cycle
            associate (drive => registry%model%drivers(driver))
               if (drive%kind /= driver_x .and. drive%kind /= driver_y) cycle
               if (at_origin(registry%model, drive%points(1))) axes(merge(1, 2, drive%kind == driver_x)) = driver
            end associate
         end do
         if (all(axes > 0)) tree%axes(:, body) = axes
      end do
   end subroutine find_axes

   !> Frames that are driven along both axes of space, and turned by a driver if they turn, need no grip: their equations are solved
   !> one by one.
   subroutine release_driven(layout, constraints, joints, tree)
      type(layout_type), intent(in) :: layout
      type(constraint_item_type), intent(in) :: constraints(:)
      !> Number of joints, behind which the drivers stand among the constraints
      integer, intent(in) :: joints
      type(topology_type), intent(inout) :: tree
      integer :: body, k, turning
      if (.not. tree%holds) return
      do body = 1, size(tree%grip)
         if (tree%axes(1, body) == 0 .or. tree%grip(body) < layout%rates(body)) cycle
         turning = 0
         do k = 1, layout%rates(body)
            select type (item => constraints(tree%holders(k, body))%item)
            type is (driven_angle_type)
               turning = tree%holders(k, body)
            end select
         end do
         if (layout%framed(body) .and. turning == 0) cycle
         tree%grip(body) = 0
         tree%holders(:, body) = 0
         tree%driver(body) = turning
         do k = 1, 2
            tree%axis_rows(k, body) = constraints(joints + tree%axes(k, body))%item%first
         end do
      end do
      tree%holds = any(tree%grip > 0)
   end subroutine release_driven

   !> Whether a point is the origin of its body's frame, whatever the deflection.
   pure logical function at_origin(model, point)
      type(model_type), intent(in) :: model
      integer, intent(in) :: point
      at_origin = .not. (any(abs(model%points(point)%p0) > 0.0_wp) .or. any(abs(model%points(point)%phi) > 0.0_wp))
   end function at_origin

   !> Whether a frame can hang on a body of the tree: on a rigid one with few unknowns.
   pure logical function can_carry(layout, tree, body)
      type(layout_type), intent(in) :: layout
      type(topology_type), intent(in) :: tree
      integer, intent(in) :: body
      can_carry = layout%framed(body) .and. layout%n(body) == 0 .and. tree%count(body) < most
   end function can_carry

   !> Frames, or parts of them, that follow from the time and are found in closed form.
   subroutine find_given(constraints, tree)
      type(constraint_item_type), intent(in) :: constraints(:)
      type(topology_type), intent(inout) :: tree
      !> Whether they change, in the order of the tree (bodies)
      logical :: changes(size(tree%order))
      integer :: i, j, k
      do k = 1, size(tree%order)
         i = tree%order(k)
         tree%given(1, i) = tree%axes(1, i) > 0
         if (tree%joint(i) > 0) then
            tree%given(1, i) = tree%carrier(i) == ground
            if (tree%carrier(i) /= ground) tree%given(1, i) = all(tree%given(:, tree%carrier(i)))
         end if
         tree%given(2, i) = tree%driver(i) > 0
         do j = 1, count(tree%holders(:, i) > 0)
            select type (item => constraints(tree%holders(j, i))%item)
            type is (driven_angle_type)
               tree%given(2, i) = item%rows > 0
            end select
         end do
         changes(k) = tree%given(2, i) .or. (tree%given(1, i) .and. (tree%joint(i) == 0 .or. tree%carrier(i) /= ground))
      end do
      tree%timed = pack(tree%order, changes)
   end subroutine find_given

   !> What each constraint places, holds or drives.
   subroutine find_placed(joints, tree)
      !> Number of joints, behind which the drivers stand among the constraints
      integer, intent(in) :: joints
      type(topology_type), intent(inout) :: tree
      integer :: body
      tree%body = 0
      do body = 1, size(tree%order)
         if (tree%driver(body) > 0) tree%body(tree%driver(body)) = body
         if (tree%joint(body) > 0) tree%body(tree%joint(body)) = body
         if (tree%axis_rows(1, body) > 0) tree%body(joints + tree%axes(:, body)) = body
         tree%body(pack(tree%holders(:, body), tree%holders(:, body) > 0)) = body
      end do
   end subroutine find_placed

   !> Constraints that are left where all frames are in their places: those that place none, and those of bodies that are held.
   subroutine find_open(constraints, tree)
      !> Number of all
      integer, intent(in) :: constraints
      type(topology_type), intent(inout) :: tree
      logical :: closed(constraints)
      integer :: i
      do i = 1, constraints
         closed(i) = tree%body(i) > 0
         if (closed(i)) closed(i) = tree%grip(tree%body(i)) == 0
      end do
      tree%open = pack([(i, i=1, constraints)], .not. closed)
   end subroutine find_open

   !> Unknowns of a body that has just been put into the tree: those of its carrier, then its own.
   subroutine number_unknowns(layout, body, tree)
      type(layout_type), intent(in) :: layout
      integer, intent(in) :: body
      type(topology_type), intent(inout) :: tree
      integer :: own, k
      if (tree%carrier(body) /= ground) then
         tree%count(body) = tree%count(tree%carrier(body))
         tree%columns(:, body) = tree%columns(:, tree%carrier(body))
      end if
      own = 0
      if (tree%joint(body) == 0) own = 2
      if (layout%framed(body) .and. tree%driver(body) == 0) own = own + 1
      if (tree%grip(body) > 0) own = layout%rates(body) - tree%grip(body)
      do k = 1, own
         tree%count(body) = tree%count(body) + 1
         tree%free = tree%free + 1
         tree%columns(tree%count(body), body) = tree%free
      end do
      tree%plain(body) = own == layout%rates(body)
   end subroutine number_unknowns

   !> Places of the constraint equations behind the unknown accelerations.
   subroutine number_rows(constraints, tree)
      type(constraint_item_type), intent(in) :: constraints(:)
      type(topology_type), intent(inout) :: tree
      integer :: i, row, list(size(tree%row))
      tree%unknowns = tree%free
      tree%row = 0
      do i = 1, size(constraints)
         if (tree%body(i) > 0 .or. constraints(i)%item%part_of > 0) cycle
         do row = constraints(i)%item%first, constraints(i)%item%first + constraints(i)%item%rows - 1
            tree%unknowns = tree%unknowns + 1
            tree%row(row) = tree%unknowns
            list(tree%unknowns - tree%free) = row
         end do
      end do
      tree%equations = list(:tree%unknowns - tree%free)
   end subroutine number_rows

end module limber_multibody_topology
