!> Which bodies hang on which. A revolute joint at the origin of a body's frame gives the place of that frame, a driver its
!> angle: both are solved in closed form, so that neither they nor what they give are unknowns of the multiplier system. A body
!> that hangs on the ground has its rotation left; a driven one on the ground nothing. Joints that close loops, and those on
!> deforming points, keep their multipliers. Floor: system. Source: doc/theory, eqs. (32a)-(32c).
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
      !> Number of unknown accelerations
      integer :: free = 0
      !> Place of each constraint equation among the unknowns; 0: solved in closed form (nc)
      integer, allocatable :: row(:)
      !> Number of all unknowns
      integer :: unknowns = 0
   end type tree_type

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
      integer :: bodies, done, i
      bodies = size(layout%q)
      allocate (tree%order(bodies), tree%joint(bodies), tree%driver(bodies), tree%side(bodies), tree%carrier(bodies), &
         & tree%marker(bodies), tree%plain(bodies), tree%count(bodies), tree%columns(most, bodies), tree%row(nc))
      tree%order = 0
      tree%joint = 0
      tree%driver = 0
      tree%side = 0
      tree%carrier = ground
      tree%marker = 0
      tree%count = 0
      tree%columns = 0
      call find_drivers(constraints, tree)
      done = 0
      do while (done < bodies)
         call hang_next(model, layout, constraints, marker_points, tree, done, i)
         done = done + 1
         tree%order(done) = i
         call number_unknowns(layout, i, tree)
      end do
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

   !> The next body: one that can be hung on what is there, else the first that is left, free.
   subroutine hang_next(model, layout, constraints, marker_points, tree, done, body)
      type(model_type), intent(in) :: model
      type(layout_type), intent(in) :: layout
      type(constraint_item_type), intent(in) :: constraints(:)
      integer, intent(in) :: marker_points(:)
      type(tree_type), intent(inout) :: tree
      !> Number of bodies in the tree
      integer, intent(in) :: done
      integer, intent(out) :: body
      integer :: i, own
      do i = 1, size(constraints)
         select type (item => constraints(i)%item)
         type is (revolute_type)
            do own = 1, 2
               body = item%bodies(own)
               if (body == ground) cycle
               if (any(tree%order(:done) == body)) cycle
               if (.not. at_origin(model, marker_points(item%markers(own)))) cycle
               if (.not. can_carry(layout, tree, done, item%bodies(3 - own))) cycle
               tree%joint(body) = i
               tree%side(body) = own
               tree%carrier(body) = item%bodies(3 - own)
               tree%marker(body) = item%markers(3 - own)
               return
            end do
         end select
      end do
      do body = 1, size(tree%order)
         if (.not. any(tree%order(:done) == body)) return
      end do
   end subroutine hang_next

   !> Whether a point is the origin of its body's frame, whatever the deflection.
   pure logical function at_origin(model, point)
      type(model_type), intent(in) :: model
      integer, intent(in) :: point
      at_origin = .not. (any(abs(model%points(point)%p0) > 0.0_wp) .or. any(abs(model%points(point)%phi) > 0.0_wp))
   end function at_origin

   !> Whether a frame can hang on a body: the ground, or a rigid body in the tree with few unknowns.
   pure logical function can_carry(layout, tree, done, body)
      type(layout_type), intent(in) :: layout
      type(tree_type), intent(in) :: tree
      integer, intent(in) :: done, body
      can_carry = body == ground
      if (can_carry) return
      can_carry = any(tree%order(:done) == body) .and. layout%framed(body) .and. layout%n(body) == 0 .and. tree%count(body) < most
   end function can_carry

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
         if (any(tree%joint == i) .or. any(tree%driver == i)) cycle
         do row = constraints(i)%item%first, constraints(i)%item%first + constraints(i)%item%rows - 1
            tree%unknowns = tree%unknowns + 1
            tree%row(row) = tree%unknowns
         end do
      end do
   end subroutine number_rows

end module limber_system_tree
