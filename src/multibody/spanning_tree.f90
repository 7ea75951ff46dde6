!> Spanning tree: which constraints each body has, and a way from the ground to all bodies. Each body stands behind the one that
!> carries it; what is left of the constraints closes loops. Topology and the elimination along articulated trees read it. Floor:
!> multibody.
module limber_multibody_spanning_tree
   use limber_model_model, only: ground
   use limber_multibody_constraint, only: constraint_item_type
   implicit none
   private
   public :: spanning_tree_type, new_spanning_tree

   !> Constant structure of a scene; a side 2 (c - 1) + s is side s of constraint c
   type :: spanning_tree_type
      !> First side at each body or the ground (0:bodies), and the next one there (2 constraints); 0: none
      integer, allocatable :: first(:), next(:)
      !> Bodies outward from the ground, then from one that is not on it, and so on; place of the carrier of each: 0 for the ground,
      !> -1 for none (bodies)
      integer, allocatable :: body(:), carrier(:)
      !> The side of a constraint by which the body at a place is carried; 0: none (bodies)
      integer, allocatable :: side(:)
      !> Number of constraints that carry no body: they close loops
      integer :: loops = 0
   end type spanning_tree_type

contains

   !> Spanning tree of constraints.
   function new_spanning_tree(constraints, bodies) result(self)
      type(constraint_item_type), intent(in) :: constraints(:)
      !> Number of bodies
      integer, intent(in) :: bodies
      type(spanning_tree_type) :: self
      logical :: reached(bodies)
      integer :: i, k, last
      call list_sides(constraints, bodies, self)
      allocate (self%body(bodies), self%carrier(bodies), self%side(bodies), source=0)
      reached = .false.
      last = 0
      call reach(constraints, ground, 0, self, reached, last)
      k = 0
      do i = 1, bodies
         call reach_on()
         if (reached(i)) cycle
         last = last + 1
         self%body(last) = i
         self%carrier(last) = -1
         reached(i) = .true.
      end do
      call reach_on()
      self%loops = count([(constraints(i)%item%rows > 0, i=1, size(constraints))]) - count(self%side > 0)

   contains

      !> Goes on from all bodies that have a place.
      subroutine reach_on()
         do while (k < last)
            k = k + 1
            call reach(constraints, self%body(k), k, self, reached, last)
         end do
      end subroutine reach_on

   end function new_spanning_tree

   !> Sides of all constraints by body, in the order of the constraints.
   pure subroutine list_sides(constraints, bodies, self)
      type(constraint_item_type), intent(in) :: constraints(:)
      integer, intent(in) :: bodies
      type(spanning_tree_type), intent(inout) :: self
      integer :: c, s, body
      allocate (self%first(0:bodies), self%next(2*size(constraints)), source=0)
      do c = size(constraints), 1, -1
         if (constraints(c)%item%rows == 0) cycle
         do s = 2, 1, -1
            body = constraints(c)%item%bodies(s)
            self%next(2*(c - 1) + s) = self%first(body)
            self%first(body) = 2*(c - 1) + s
         end do
      end do
   end subroutine list_sides

   !> Gives places to all bodies that are joined to one, or to the ground.
   pure subroutine reach(constraints, from, place, self, reached, last)
      type(constraint_item_type), intent(in) :: constraints(:)
      !> The carrier, and its place
      integer, intent(in) :: from, place
      type(spanning_tree_type), intent(inout) :: self
      logical, intent(inout) :: reached(:)
      !> Places so far
      integer, intent(inout) :: last
      integer :: number, other, c, s
      number = self%first(from)
      do while (number > 0)
         c = (number + 1)/2
         s = 3 - (number - 2*(c - 1))
         other = constraints(c)%item%bodies(s)
         number = self%next(number)
         if (other == ground) cycle
         if (reached(other)) cycle
         reached(other) = .true.
         last = last + 1
         self%body(last) = other
         self%carrier(last) = place
         self%side(last) = 2*(c - 1) + s
      end do
   end subroutine reach

end module limber_multibody_spanning_tree
