!> Controls of the model: a new one with the bodies that carry its states, and one by its name. Floor: model. Source: doc/theory,
!> section 5.21.
module limber_model_controls
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_beam_reduced_body, only: rigid_reduced
   use limber_model_bodies, only: append_body
   use limber_model_model, only: model_type, body_type, control_type, body_point
   use limber_model_points, only: add_point
   implicit none
   private
   public :: append_control, add_states, find_control, find_state

contains

   !> Appends a control. No array constructor: gfortran copies types with deep components badly there.
   subroutine append_control(model, control)
      type(model_type), intent(inout) :: model
      type(control_type), intent(in) :: control
      type(control_type), allocatable :: longer(:)
      integer :: n
      n = size(model%controls) + 1
      allocate (longer(n))
      longer(:n - 1) = model%controls
      longer(n) = control
      call move_alloc(longer, model%controls)
   end subroutine append_control

   !> Bodies that carry the states of the last control: points of unit mass whose velocities along x are these, eq. (5.83). Their
   !> names are none that a deck could write.
   subroutine add_states(model, scales)
      type(model_type), intent(inout) :: model
      !> Sizes of the states below which errors do not shrink (states)
      real(wp), intent(in) :: scales(:)
      type(body_type) :: body
      integer :: i, index
      associate (control => model%controls(size(model%controls)))
         allocate (control%points(size(scales)))
         do i = 1, size(scales)
            body = body_type()
            body%name = 'control '//control%name//' x'//as_text(i)
            body%kind = body_point
            body%reduced = rigid_reduced(1.0_wp, 0.0_wp, [0.0_wp, 0.0_wp])
            body%velocity(1) = control%first(i)
            body%control = size(model%controls)
            body%state_scale = scales(i)
            call append_body(model, body, index)
            call add_point(model, body%name//'.origin', index, [0.0_wp, 0.0_wp])
            control%points(i) = model%counts%points
         end do
      end associate
   end subroutine add_states

   !> Index of a control by its name; 0 if there is none.
   pure integer function find_control(model, name) result(found)
      type(model_type), intent(in) :: model
      character(*), intent(in) :: name
      do found = size(model%controls), 1, -1
         if (model%controls(found)%name == name) return
      end do
   end function find_control

   !> Index of the point that carries a state, control.x1 or control.x2 ...; 0 if there is none.
   pure integer function find_state(model, name) result(point)
      type(model_type), intent(in) :: model
      character(*), intent(in) :: name
      integer :: dot, control, i
      point = 0
      dot = index(name, '.')
      if (dot == 0) return
      control = find_control(model, name(:dot - 1))
      if (control == 0) return
      do i = 1, size(model%controls(control)%points)
         if (name(dot + 1:) == 'x'//as_text(i)) point = model%controls(control)%points(i)
      end do
   end function find_state

end module limber_model_controls
