!> Order of bodies from the ground to the free ends. Each stands behind the one that carries it. Open chains and trees are solved in
!> this order, from the free ends to the roots and back. Floor: multibody; used by `recursion` and `forest`.
module limber_multibody_tree_order
   use limber_model_model, only: ground
   use limber_multibody_system, only: system_type
   implicit none
   private
   public :: order_on_pins

contains

   !> Orders all bodies outward from the ground, then from one that is not on it, and so on.
   subroutine order_on_pins(system, body, carrier, pin)
      type(system_type), intent(in) :: system
      !> Body of a place, and place of its carrier: 0 for the ground, -1 for none (bodies)
      integer, intent(out) :: body(:), carrier(:)
      !> Joint that a body hangs on; -1: none. A joint that is not among them closes a loop (bodies)
      integer, intent(out) :: pin(:)
      integer, allocatable :: head(:), next(:)
      integer :: i, k, last
      call list_pins(system, head, next)
      pin = 0
      carrier = -1
      last = 0
      call reach(system, ground, head, next, 0, body, carrier, pin, last)
      k = 0
      i = 0
      do while (last < size(body))
         do while (k < last)
            k = k + 1
            call reach(system, body(k), head, next, k, body, carrier, pin, last)
         end do
         if (last == size(body)) exit
         i = i + 1
         if (pin(i) /= 0) cycle
         last = last + 1
         body(last) = i
         pin(i) = -1
      end do
   end subroutine order_on_pins

   !> Sides of all joints by body: number 2 (j - 1) + s is side s of joint j.
   subroutine list_pins(system, head, next)
      type(system_type), intent(in) :: system
      !> First side at each body or the ground (0:bodies), and the next one there; 0: none
      integer, allocatable, intent(out) :: head(:), next(:)
      integer :: j, s, body
      allocate (head(0:size(system%model%bodies)), source=0)
      allocate (next(2*size(system%constraints)), source=0)
      do j = size(system%constraints), 1, -1
         do s = 2, 1, -1
            body = system%constraints(j)%item%bodies(s)
            next(2*(j - 1) + s) = head(body)
            head(body) = 2*(j - 1) + s
         end do
      end do
   end subroutine list_pins

   !> Gives places to all bodies that hang on one, or on the ground.
   subroutine reach(system, from, head, next, place, body, carrier, pin, last)
      type(system_type), intent(in) :: system
      !> The carrier, and its place
      integer, intent(in) :: from, place
      integer, intent(in) :: head(0:), next(:)
      integer, intent(inout) :: body(:), carrier(:), pin(:)
      !> Places so far
      integer, intent(inout) :: last
      integer :: number, joint, other
      number = head(from)
      do while (number > 0)
         joint = (number + 1)/2
         other = system%constraints(joint)%item%bodies(3 - (number - 2*(joint - 1)))
         number = next(number)
         if (other == ground) cycle
         if (pin(other) /= 0) cycle
         last = last + 1
         body(last) = other
         carrier(last) = place
         pin(other) = joint
      end do
   end subroutine reach

end module limber_multibody_tree_order
