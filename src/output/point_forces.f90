!> Forces on single points of a body. Their sum on the body, which the equations of motion have, does not tell what is between these
!> points. Floor: output. Source: doc/theory, eqs. (2.24)-(2.26), (2.28).
module limber_output_point_forces
   use limber_base_kinds, only: wp
   use limber_model_model, only: ground
   use limber_multibody_plane_vectors, only: cross
   use limber_multibody_constraint, only: constraint_type
   use limber_multibody_force_elements, only: force_element_type
   use limber_multibody_function_constraints, only: function_constraint_type, linear_type, most_vectors, vector_pulls
   use limber_multibody_load, only: load_type
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: pull_type, pulls_type, new_pulls, pulled_points, constraint_pulls, load_pulls

   !> Most forces of a constraint or load
   integer, parameter, public :: most_pulls = most_vectors

   !> A force on a body
   type :: pull_type
      !> Indices of the body and of the point; 0: none, the frame of the body
      integer :: body = 0, point = 0
      !> Along the fixed axes, and moment about the origin of the frame
      real(wp) :: force(3) = 0.0_wp
   end type pull_type

   !> What is found once of a system
   type :: pulls_type
      !> The point of the deck that each marker is at, 0: none (markers)
      integer, allocatable :: point(:)
      !> Which constraints and loads act on several points of a body, or at points that they do not name; which constraints name
      !> one of several points of a body
      logical, allocatable :: constraint(:), load(:), pair(:)
   end type pulls_type

contains

   function new_pulls(system) result(pulls)
      type(system_type), intent(in) :: system
      type(pulls_type) :: pulls
      integer :: i
      allocate (pulls%point(system%markers), pulls%constraint(size(system%constraints)), pulls%load(size(system%loads)))
      allocate (pulls%pair(size(system%constraints)))
      do i = 1, system%markers
         pulls%point(i) = point_of(system, system%marker_points(i))
      end do
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            pulls%pair(i) = is_pair(pulls, system, item)
            pulls%constraint(i) = pulls%pair(i) .or. is_nameless(item)
         end associate
      end do
      do i = 1, size(system%loads)
         pulls%load(i) = is_within(pulls, system, system%loads(i)%item)
      end do
   end function new_pulls

   !> The point of the deck that a point of the system is, or a direction at it; 0: none.
   pure integer function point_of(system, index) result(point)
      type(system_type), intent(in) :: system
      integer, intent(in) :: index
      associate (points => system%model%points)
         if (points(index)%name == '') then
            point = 0
            return
         end if
         do point = 1, size(points)
            if (points(point)%member == 0 .or. points(point)%direction) cycle
            if (points(point)%body == points(index)%body .and. points(point)%name == points(index)%name) return
         end do
      end associate
      point = 0
   end function point_of

   !> Whether a constraint has vectors at several points of a body.
   pure logical function is_pair(pulls, system, item)
      type(pulls_type), intent(in) :: pulls
      type(system_type), intent(in) :: system
      class(constraint_type), intent(in) :: item
      is_pair = .false.
      if (is_nameless(item)) return
      select type (item)
      class is (function_constraint_type)
         ! What slides along a body has its own way
         if (item%bend == 0) is_pair = are_apart(pulls, system, item%markers(:item%vectors))
      end select
   end function is_pair

   !> Whether a constraint names no point of a body that it acts on.
   pure logical function is_nameless(item)
      class(constraint_type), intent(in) :: item
      is_nameless = .false.
      select type (item)
      type is (linear_type)
         is_nameless = any(item%points == 0 .and. item%bodies /= ground)
      end select
   end function is_nameless

   !> Whether a load acts on several points of a body, of which its forces have the sum only.
   pure logical function is_within(pulls, system, item)
      type(pulls_type), intent(in) :: pulls
      type(system_type), intent(in) :: system
      class(load_type), intent(in) :: item
      is_within = .false.
      select type (item)
      class is (force_element_type)
         if (.not. item%follower) is_within = are_apart(pulls, system, pack(item%functions(1)%markers, item%functions(1)%parts > 0))
      end select
   end function is_within

   !> Whether markers are at several places of a body.
   pure logical function are_apart(pulls, system, markers)
      type(pulls_type), intent(in) :: pulls
      type(system_type), intent(in) :: system
      integer, intent(in) :: markers(:)
      integer :: j, k
      are_apart = .false.
      do j = 1, size(markers)
         do k = j + 1, size(markers)
            associate (body => system%model%points(system%marker_points(markers([j, k])))%body)
               if (body(1) == ground .or. body(1) /= body(2)) cycle
               are_apart = are_apart .or. pulls%point(markers(j)) /= pulls%point(markers(k))
            end associate
         end do
      end do
   end function are_apart

   !> The points of the deck that such constraints and loads act on.
   pure function pulled_points(self, system) result(points)
      type(pulls_type), intent(in) :: self
      type(system_type), intent(in) :: system
      integer, allocatable :: points(:)
      integer :: i
      allocate (points(0))
      do i = 1, size(system%constraints)
         if (.not. self%pair(i)) cycle
         select type (item => system%constraints(i)%item)
         class is (function_constraint_type)
            points = [points, self%point(item%markers(:item%vectors))]
         end select
      end do
      do i = 1, size(system%loads)
         if (.not. self%load(i)) cycle
         select type (item => system%loads(i)%item)
         class is (force_element_type)
            points = [points, self%point(pack(item%functions(1)%markers, item%functions(1)%parts > 0))]
         end select
      end do
      points = pack(points, points > 0)
   end function pulled_points

   !> Forces of a constraint; multipliers and kinematics are those of the state.
   subroutine constraint_pulls(self, work, item, pulls, count)
      type(pulls_type), intent(in) :: self
      type(workspace_type), intent(in) :: work
      class(constraint_type), intent(in) :: item
      type(pull_type), intent(out) :: pulls(most_pulls)
      integer, intent(out) :: count
      real(wp) :: pull(2, most_vectors)
      integer :: j
      count = 0
      select type (item)
      class is (function_constraint_type)
         call vector_pulls(item, work%kinematics, work%lambda(item%first:item%first + item%rows - 1), pull)
         count = item%vectors
         do j = 1, count
            pulls(j) = pull_at(self, work, item%markers(j), pull(:, j))
         end do
      end select
   end subroutine constraint_pulls

   !> Forces of a load; kinematics are those of the state.
   subroutine load_pulls(self, work, item, pulls, count)
      type(pulls_type), intent(in) :: self
      type(workspace_type), intent(in) :: work
      class(load_type), intent(in) :: item
      type(pull_type), intent(out) :: pulls(most_pulls)
      integer, intent(out) :: count
      real(wp) :: value, rate, push, weights(2, 3)
      integer :: m
      count = 0
      select type (item)
      class is (force_element_type)
         call item%force_along(work%kinematics, value, rate, push, weights)
         if (item%is_scaled) push = item%share*push
         do m = 1, 3
            if (item%functions(1)%parts(m) == 0) cycle
            count = count + 1
            pulls(count) = pull_at(self, work, item%functions(1)%markers(m), push*weights(:, m))
         end do
      end select
   end subroutine load_pulls

   !> A force on a marker, or on the end of a direction.
   pure function pull_at(self, work, index, force) result(pull)
      type(pulls_type), intent(in) :: self
      type(workspace_type), intent(in) :: work
      integer, intent(in) :: index
      real(wp), intent(in) :: force(2)
      type(pull_type) :: pull
      associate (marker => work%kinematics%markers(index))
         pull%body = marker%body
         if (marker%body == ground) return
         pull%point = self%point(index)
         if (marker%direction) then
            pull%force(3) = cross(marker%position, force)
         else
            pull%force(1:2) = force
            pull%force(3) = cross(marker%position - work%kinematics%frames(marker%body)%position, force)
         end if
      end associate
   end function pull_at

end module limber_output_point_forces
