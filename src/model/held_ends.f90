!> Supports of the ends of beams: what joints, drivers and springs hold there. Floor: model. Source: doc/theory, eq. (2.49).
module limber_model_held_ends
   use limber_base_kinds, only: wp
   use limber_deck_content, only: block_type
   use limber_model_points_of_action, only: has_pair, body_of, point_of
   implicit none
   private
   public :: hold_type, note, note_pair

   !> A point of a body with its support
   type :: hold_type
      !> Name of the point without the name of the body
      character(64) :: name = ''
      !> Whether joints and drivers fix the point along the initial x and y axes of the body (2), and the rotation of the section
      logical :: held(2) = .false., clamped = .false.
      !> Whether the other body hangs here alone, and its mass if it is rigid
      logical :: hangs = .false.
      real(wp) :: mass = 0.0_wp
      !> Transverse stiffness of springs [force/length], rotational stiffness [moment/rad]
      real(wp) :: across = 0.0_wp, turning = 0.0_wp
   end type hold_type

contains

   !> Adds a support to the list, or to the entry of the same point.
   subroutine note(new, holds)
      type(hold_type), intent(in) :: new
      type(hold_type), allocatable, intent(inout) :: holds(:)
      integer :: i
      do i = 1, size(holds)
         associate (old => holds(i))
            if (old%name /= new%name) cycle
            if (old%hangs .neqv. new%hangs) cycle
            old%held = old%held .or. new%held
            old%clamped = old%clamped .or. new%clamped
            old%across = old%across + new%across
            old%turning = old%turning + new%turning
            old%mass = old%mass + new%mass
         end associate
         return
      end do
      holds = [holds, new]
   end subroutine note

   !> Adds a support at each point of a body of a block with exactly one line of two points.
   subroutine note_pair(block, body, support, holds)
      type(block_type), intent(in) :: block
      !> Name of the body
      character(*), intent(in) :: body
      !> Without a name
      type(hold_type), intent(in) :: support
      type(hold_type), allocatable, intent(inout) :: holds(:)
      type(hold_type) :: new
      integer :: k
      if (.not. has_pair(block)) return
      do k = 1, 2
         if (body_of(block%lines(1)%text(k)) /= body) cycle
         new = support
         new%name = point_of(block%lines(1)%text(k))
         call note(new, holds)
      end do
   end subroutine note_pair

end module limber_model_held_ends
