!> Effects of joints, drivers and loads on a body that is built before them: points of action, supports, ties. Floor: model. Source:
!> doc/theory, eq. (2.49).
module limber_model_element_effects
   use limber_base_kinds, only: wp
   use limber_deck_content, only: deck_type, block_type
   use limber_model_element, only: elements, find_element
   use limber_model_held_ends, only: hold_type
   use limber_model_points_of_action, only: acting_type, body_of, point_of, has_pair
   implicit none
   private
   public :: acting_points, find_shared, find_turning, holds_of, is_alone

contains

   !> Points of a body under joints, drivers and loads, each once. Drivers of the frame act at the origin.
   subroutine acting_points(deck, body, points)
      type(deck_type), intent(in) :: deck
      !> Name of the body
      character(*), intent(in) :: body
      type(acting_type), allocatable, intent(out) :: points(:)
      integer :: i, element
      allocate (points(0))
      do i = 1, size(deck%blocks)
         element = find_element(deck%blocks(i)%keyword)
         if (element > 0) call elements(element)%item%act(deck, deck%blocks(i), body, points)
      end do
   end subroutine acting_points

   !> Index of the first block that drives, loads or couples the frame of a body; 0 if there is none.
   pure integer function find_turning(deck, body) result(found)
      type(deck_type), intent(in) :: deck
      !> Name of the body
      character(*), intent(in) :: body
      integer :: element
      do found = 1, size(deck%blocks)
         element = find_element(deck%blocks(found)%keyword)
         if (element == 0) cycle
         if (elements(element)%item%turns(deck%blocks(found), body)) return
      end do
      found = 0
   end function find_turning

   !> Finds inner points with a fixed distance from another point of the body: by joints and bodies in a loop, by joints and drivers
   !> to the ground, or by a driver of their distance.
   subroutine find_shared(deck, body, inner, points)
      type(deck_type), intent(in) :: deck
      character(*), intent(in) :: body
      !> Whether a point lies within the body, not at its ends (points)
      logical, intent(in) :: inner(:)
      type(acting_type), intent(inout) :: points(:)
      !> Fixed points, and the node of the body at the other side of each
      character(64), allocatable :: own(:)
      integer, allocatable :: partner(:), first(:)
      !> Union-find: representative of each block, and of the ground (0), among all bodies that are joined
      integer :: node(0:size(deck%blocks))
      character(64) :: names(2)
      integer :: i, k, element
      logical :: mine(2), tied
      if (.not. any(inner .and. points%force)) return
      allocate (own(0), partner(0))
      node = [(i, i=0, size(deck%blocks))]
      do i = 1, size(deck%blocks)
         element = find_element(deck%blocks(i)%keyword)
         if (element == 0) cycle
         call elements(element)%item%tie(deck, deck%blocks(i), body, names, tied)
         if (.not. tied) cycle
         mine = [(body_of(names(k)) == body, k=1, 2)]
         if (.not. any(mine)) call join(block_of(names(1)), block_of(names(2)))
         do k = 1, 2
            if (.not. mine(k)) cycle
            own = [own, point_of(names(k))]
            partner = [partner, block_of(names(3 - k))]
         end do
      end do
      allocate (first, source=partner)
      do i = 1, size(own)
         partner(i) = last_of(partner(i))
      end do
      do i = 1, size(own)
         points%shared = points%shared .or. (inner .and. points%name == own(i) .and. &
            & any(partner == partner(i) .and. own /= own(i)))
         points%firm = points%firm .or. (inner .and. points%name == own(i) .and. any(first == first(i) .and. own /= own(i)))
      end do

   contains

      !> Block of the body of a point; 0 for the ground.
      integer function block_of(name)
         character(*), intent(in) :: name
         block_of = deck%find_named('RIGID BODY|BEAM|FRAME|POINT MASS', trim(body_of(name)))
      end function block_of

      !> Representative of a node.
      integer function last_of(from)
         integer, intent(in) :: from
         last_of = from
         do while (node(last_of) /= last_of)
            node(last_of) = node(node(last_of))
            last_of = node(last_of)
         end do
      end function last_of

      !> Joins the sets of two nodes.
      subroutine join(first, second)
         integer, intent(in) :: first, second
         node(last_of(first)) = last_of(second)
      end subroutine join

   end subroutine find_shared

   !> Points of a body with supports or hanging bodies, each once.
   subroutine holds_of(deck, body, holds)
      type(deck_type), intent(in) :: deck
      !> Name of the body
      character(*), intent(in) :: body
      type(hold_type), allocatable, intent(out) :: holds(:)
      integer :: i, element
      allocate (holds(0))
      do i = 1, size(deck%blocks)
         element = lasting_element(deck%blocks(i))
         if (element > 0) call elements(element)%item%hold(deck, deck%blocks(i), body, holds)
      end do
      ! If nothing else supports the body, the hanging bodies serve as its supports
      if (any((holds%held(1) .or. holds%held(2) .or. holds%clamped .or. holds%across + holds%turning > 0.0_wp) .and. &
         & .not. holds%hangs)) then
         do i = 1, size(holds)
            if (.not. holds(i)%hangs) cycle
            holds(i)%held = .false.
            holds(i)%clamped = .false.
         end do
      else
         holds%mass = 0.0_wp
      end if
   end subroutine holds_of

   !> Index of the element of a block that acts all the time; 0 if it asks for a switch, or is none: shapes of a body are not those
   !> of a support that a switch takes away.
   pure integer function lasting_element(block) result(element)
      type(block_type), intent(in) :: block
      element = find_element(block%keyword)
      if (element == 0) return
      if (.not. elements(element)%item%switchable) return
      if (block%has('ACTIVE') .or. block%has('INACTIVE')) element = 0
   end function lasting_element

   !> Whether a body hangs on another one alone: joined to it only, by one joint, without a driver.
   logical function is_alone(deck, name, body)
      type(deck_type), intent(in) :: deck
      !> The hanging body, and the body that carries it
      character(*), intent(in) :: name, body
      character(64) :: ends(2)
      integer :: i, joints, element
      joints = 0
      is_alone = .false.
      do i = 1, size(deck%blocks)
         element = lasting_element(deck%blocks(i))
         if (element == 0) cycle
         associate (block => deck%blocks(i), kind => elements(element)%item)
            if (kind%drives(block, name)) return
            if (.not. kind%joins .or. .not. has_pair(block)) cycle
            ends = [body_of(block%lines(1)%text(1)), body_of(block%lines(1)%text(2))]
            if (all(ends /= name)) cycle
            if (all(ends /= body)) return
            joints = joints + 1
            if (joints > 1) return
         end associate
      end do
      is_alone = .true.
   end function is_alone

end module limber_model_element_effects
