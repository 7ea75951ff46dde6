!> Lists that grow at constant cost per item. Their memory doubles when it is full; `trim_lists` cuts it to the number of items.
!> Floor: model.
module limber_model_lists
   use limber_model_model, only: model_type, body_type, point_type, joint_type, channel_type
   implicit none
   private
   public :: append, trim_lists

   !> `append(list, count, item)` puts an item behind the first `count` items and increases `count`; size(list) may exceed `count`
   interface append
      module procedure :: append_body, append_point, append_joint, append_channel
   end interface append

   !> First size of a list
   integer, parameter :: least = 8

contains

   !> Cuts all lists to their numbers of items.
   subroutine trim_lists(model)
      type(model_type), intent(inout) :: model
      associate (counts => model%counts)
         if (size(model%bodies) > counts%bodies) model%bodies = model%bodies(:counts%bodies)
         if (size(model%points) > counts%points) model%points = model%points(:counts%points)
         if (size(model%joints) > counts%joints) model%joints = model%joints(:counts%joints)
         if (size(model%channels) > counts%channels) model%channels = model%channels(:counts%channels)
      end associate
   end subroutine trim_lists

   subroutine append_body(list, count, item)
      type(body_type), allocatable, intent(inout) :: list(:)
      integer, intent(inout) :: count
      type(body_type), intent(in) :: item
      type(body_type), allocatable :: longer(:)
      if (count == size(list)) then
         allocate (longer(max(least, 2*count)))
         longer(:count) = list
         call move_alloc(longer, list)
      end if
      count = count + 1
      list(count) = item
   end subroutine append_body

   subroutine append_point(list, count, item)
      type(point_type), allocatable, intent(inout) :: list(:)
      integer, intent(inout) :: count
      type(point_type), intent(in) :: item
      type(point_type), allocatable :: longer(:)
      if (count == size(list)) then
         allocate (longer(max(least, 2*count)))
         longer(:count) = list
         call move_alloc(longer, list)
      end if
      count = count + 1
      list(count) = item
   end subroutine append_point

   subroutine append_joint(list, count, item)
      type(joint_type), allocatable, intent(inout) :: list(:)
      integer, intent(inout) :: count
      type(joint_type), intent(in) :: item
      type(joint_type), allocatable :: longer(:)
      if (count == size(list)) then
         allocate (longer(max(least, 2*count)))
         longer(:count) = list
         call move_alloc(longer, list)
      end if
      count = count + 1
      list(count) = item
   end subroutine append_joint

   subroutine append_channel(list, count, item)
      type(channel_type), allocatable, intent(inout) :: list(:)
      integer, intent(inout) :: count
      type(channel_type), intent(in) :: item
      type(channel_type), allocatable :: longer(:)
      if (count == size(list)) then
         allocate (longer(max(least, 2*count)))
         longer(:count) = list
         call move_alloc(longer, list)
      end if
      count = count + 1
      list(count) = item
   end subroutine append_channel

end module limber_model_lists
