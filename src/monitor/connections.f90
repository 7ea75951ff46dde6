!> Bodies connected by joints. Floor: monitor.
module limber_monitor_connections
   use limber_model_model, only: model_type, ground
   implicit none
   private
   public :: ends_of, hangs_on, connected_with

contains

   !> Whether joints connect a body with nothing but some others.
   pure logical function hangs_on(model, body, bodies) result(hangs)
      type(model_type), intent(in) :: model
      integer, intent(in) :: body, bodies(:)
      integer :: i, ends(2)
      hangs = .false.
      if (body == ground) return
      do i = 1, size(model%joints)
         ends = ends_of(model, i)
         if (all(ends /= body)) cycle
         hangs = any(ends(1) == bodies) .or. any(ends(2) == bodies)
         if (.not. hangs) return
      end do
   end function hangs_on

   !> The two bodies of a joint.
   pure function ends_of(model, joint) result(bodies)
      type(model_type), intent(in) :: model
      integer, intent(in) :: joint
      integer :: bodies(2), side
      bodies = ground
      do side = 1, 2
         associate (point => model%joints(joint)%points(side))
            if (point > 0) bodies(side) = model%points(point)%body
         end associate
      end do
   end function ends_of

   !> Bodies that joints connect with a body, not by the ground (bodies).
   pure function connected_with(model, body) result(reached)
      type(model_type), intent(in) :: model
      integer, intent(in) :: body
      logical :: reached(0:size(model%bodies)), changed
      integer :: i, ends(2)
      reached = .false.
      reached(body) = .true.
      changed = .true.
      do while (changed)
         changed = .false.
         do i = 1, size(model%joints)
            ends = ends_of(model, i)
            if (any(ends == ground) .or. (reached(ends(1)) .eqv. reached(ends(2)))) cycle
            reached(ends) = .true.
            changed = .true.
         end do
      end do
   end function connected_with

end module limber_monitor_connections
