!> Supports of the ends of beams: what joints, drivers and springs hold there. Floor: model. Source: doc/theory, eq. (2.49).
module limber_model_held_ends
   use limber_base_kinds, only: wp
   implicit none
   private
   public :: hold_type, note

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

end module limber_model_held_ends
