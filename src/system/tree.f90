!> Which bodies hang on which. A revolute joint at the origin of a body's frame gives the place of that frame, a driver its
!> angle: both are solved in closed form, so that neither they nor what they give are unknowns of the multiplier system. A body
!> that hangs on the ground has its rotation left; a driven one on the ground nothing. Joints that close loops, and those on
!> deforming points, keep their multipliers. Floor: system. Source: doc/theory, eqs. (33a)-(33c).
module limber_system_tree
   use limber_base_kinds, only: wp
   use limber_model_scene, only: model_type, ground
   use limber_system_constraint, only: constraint_item_type
   use limber_system_drivers, only: driven_angle_type
   use limber_system_joints, only: revolute_type
   use limber_system_kinematics, only: layout_type
   implicit none
   private
   public :: tree_type, new_tree

   !> Unknowns on which a frame may depend: in a long chain every few bodies one is left free, or the matrix would be full
   integer, parameter :: most = 4

   !> Constant structure; arrays are over bodies unless said otherwise
   type :: tree_type
      !> Bodies, each behind the one that carries it
      integer, allocatable :: order(:)
      !> Constraint that places the frame's origin, and the one that gives its angle; 0: none
      integer, allocatable :: joint(:), driver(:)
      !> Of a placed frame: which side of the joint it is (1 or 2), the body that carries it, and the marker it sits on
      integer, allocatable :: side(:), carrier(:), marker(:)
      !> True if the frame's own rates are unknowns, all of them
      logical, allocatable :: plain(:)
      !> Number of unknowns on which the frame's accelerations depend, and their indices (most, bodies)
      integer, allocatable :: count(:), columns(:, :)
      !> First body that hangs on a body, and the next one on the same carrier, in the order of `order`; 0: none
      integer, allocatable :: first(:), next(:)
      !> Body that a constraint places or whose angle it gives; 0: none (constraints)
      integer, allocatable :: body(:)
      !> Number of unknown accelerations
      integer :: free = 0
      !> Place of each constraint equation among the unknowns; 0: solved in closed form (nc)
      integer, allocatable :: row(:)
      !> Number of all unknowns
      integer :: unknowns = 0
   end type tree_type

   !> Bodies that could hang on others, by the joint
   type :: candidates_type
      !> First candidate on each body or the ground (0:bodies), and the next one on the same (2 constraints); 0: none
      integer, allocatable :: first(:), next(:)
      !> Candidates whose carriers are in the tree, as a heap; only the first `count` are in use
      integer, allocatable :: heap(:)
      integer :: count = 0
      !> Whether a body is in the tree (bodies)
      logical, allocatable :: done(:)
   end type candidates_type

contains

   !> The tree of a model. Its constraints are the joints in the order of the model, then the drivers.
   function new_tree(model, layout, constraints, marker_points, nc) result(tree)
      type(model_type), intent(in) :: model
      type(layout_type), intent(in) :: layout
      type(constraint_item_type), intent(in) :: constraints(:)
      !> Point of each marker
      integer, intent(in) :: marker_points(:)
      !> Number of constraint equations
      integer, intent(in) :: nc
      type(tree_type) :: tree
      type(candidates_type) :: candidates
      integer :: bodies, done, i, left
      bodies = size(layout%q)
      allocate (tree%order(bodies), tree%joint(bodies), tree%driver(bodies), tree%side(bodies), tree%carrier(bodies), &
         & tree%marker(bodies), tree%plain(bodies), tree%count(bodies), tree%columns(most, bodies), tree%row(nc), &
         & tree%first(bodies), tree%next(bodies), tree%body(size(constraints)))
      tree%order = 0
      tree%joint = 0
      tree%driver = 0
      tree%side = 0
      tree%carrier = ground
      tree%marker = 0
      tree%count = 0
      tree%columns = 0
      call find_drivers(constraints, tree)
      call find_candidates(model, constraints, marker_points, bodies, candidates)
      call release(candidates, ground)
      left = 1
      do done = 1, bodies
         call hang_next(constraints, candidates, tree, left, i)
         tree%order(done) = i
         candidates%done(i) = .true.
         call number_unknowns(layout, i, tree)
         if (can_carry(layout, tree, i)) call release(candidates, i)
      end do
      call find_children(tree)
      call number_rows(constraints, tree)
   end function new_tree

   !> The first driver of each body's angle.
   subroutine find_drivers(constraints, tree)
      type(constraint_item_type), intent(in) :: constraints(:)
      type(tree_type), intent(inout) :: tree
      integer :: i, body
      do i = size(constraints), 1, -1
         select type (item => constraints(i)%item)
         type is (driven_angle_type)
            body = item%bodies(1)
            tree%driver(body) = i
         end select
      end do
   end subroutine find_drivers

   !> What could hang where: number 2 (c - 1) + s is side s of constraint c, a revolute joint at the origin of that side's frame.
   subroutine find_candidates(model, constraints, marker_points, bodies, candidates)
      type(model_type), intent(in) :: model
      type(constraint_item_type), intent(in) :: constraints(:)
      integer, intent(in) :: marker_points(:), bodies
      type(candidates_type), intent(out) :: candidates
      integer :: i, own, number
      allocate (candidates%first(0:bodies), source=0)
      allocate (candidates%next(2*size(constraints)), candidates%heap(2*size(constraints)), &
         & candidates%done(bodies))
      candidates%next = 0
      candidates%done = .false.
      do i = size(constraints), 1, -1
         select type (item => constraints(i)%item)
         type is (revolute_type)
            do own = 2, 1, -1
               if (item%bodies(own) == ground) cycle
               if (.not. at_origin(model, marker_points(item%markers(own)))) cycle
               number = 2*(i - 1) + own
               candidates%next(number) = candidates%first(item%bodies(3 - own))
               candidates%first(item%bodies(3 - own)) = number
            end do
         end select
      end do
   end subroutine find_candidates

   !> Puts all that could hang on a body, or the ground, into the heap: least number first.
   pure subroutine release(candidates, body)
      type(candidates_type), intent(inout) :: candidates
      integer, intent(in) :: body
      integer :: number, i
      number = candidates%first(body)
      do while (number > 0)
         candidates%count = candidates%count + 1
         i = candidates%count
         do while (i > 1)
            if (candidates%heap(i/2) <= number) exit
            candidates%heap(i) = candidates%heap(i/2)
            i = i/2
         end do
         candidates%heap(i) = number
         number = candidates%next(number)
      end do
   end subroutine release

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

   !> The next body: one that can be hung on what is there, by the first joint that does; else the first that is left, free.
   subroutine hang_next(constraints, candidates, tree, left, body)
      type(constraint_item_type), intent(in) :: constraints(:)
      type(candidates_type), intent(inout) :: candidates
      type(tree_type), intent(inout) :: tree
      !> No body before this one is left
      integer, intent(inout) :: left
      integer, intent(out) :: body
      integer :: number, i, own
      do while (candidates%count > 0)
         call take(candidates, number)
         i = (number + 1)/2
         own = number - 2*(i - 1)
         select type (item => constraints(i)%item)
         type is (revolute_type)
            body = item%bodies(own)
            if (candidates%done(body)) cycle
            tree%joint(body) = i
            tree%side(body) = own
            tree%carrier(body) = item%bodies(3 - own)
            tree%marker(body) = item%markers(3 - own)
            return
         end select
      end do
      do while (candidates%done(left))
         left = left + 1
      end do
      body = left
   end subroutine hang_next

   !> Whether a point is the origin of its body's frame, whatever the deflection.
   pure logical function at_origin(model, point)
      type(model_type), intent(in) :: model
      integer, intent(in) :: point
      at_origin = .not. (any(abs(model%points(point)%p0) > 0.0_wp) .or. any(abs(model%points(point)%phi) > 0.0_wp))
   end function at_origin

   !> Whether a frame can hang on a body of the tree: on a rigid one with few unknowns.
   pure logical function can_carry(layout, tree, body)
      type(layout_type), intent(in) :: layout
      type(tree_type), intent(in) :: tree
      integer, intent(in) :: body
      can_carry = layout%framed(body) .and. layout%n(body) == 0 .and. tree%count(body) < most
   end function can_carry

   !> What hangs on each body, and what each constraint places or drives.
   pure subroutine find_children(tree)
      type(tree_type), intent(inout) :: tree
      integer :: k, body
      tree%first = 0
      tree%next = 0
      tree%body = 0
      do k = size(tree%order), 1, -1
         body = tree%order(k)
         if (tree%joint(body) > 0) tree%body(tree%joint(body)) = body
         if (tree%driver(body) > 0) tree%body(tree%driver(body)) = body
         if (tree%carrier(body) == ground) cycle
         tree%next(body) = tree%first(tree%carrier(body))
         tree%first(tree%carrier(body)) = body
      end do
   end subroutine find_children

   !> Unknowns of a body that has just been put into the tree: those of its carrier, then its own.
   subroutine number_unknowns(layout, body, tree)
      type(layout_type), intent(in) :: layout
      integer, intent(in) :: body
      type(tree_type), intent(inout) :: tree
      integer :: own, k
      if (tree%carrier(body) /= ground) then
         tree%count(body) = tree%count(tree%carrier(body))
         tree%columns(:, body) = tree%columns(:, tree%carrier(body))
      end if
      own = 0
      if (tree%joint(body) == 0) own = 2
      if (layout%framed(body) .and. tree%driver(body) == 0) own = own + 1
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
      type(tree_type), intent(inout) :: tree
      integer :: i, row
      tree%unknowns = tree%free
      tree%row = 0
      do i = 1, size(constraints)
         if (tree%body(i) > 0) cycle
         do row = constraints(i)%item%first, constraints(i)%item%first + constraints(i)%item%rows - 1
            tree%unknowns = tree%unknowns + 1
            tree%row(row) = tree%unknowns
         end do
      end do
   end subroutine number_rows

end module limber_system_tree
