!> Joints and couplers of the model: a new one, and one by its name. Floor: model.
module limber_model_joint_list
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_origin, only: origin_type
   use limber_model_lists, only: append
   use limber_model_model, only: model_type, joint_type, place_on_beam
   use limber_model_points, only: enter_name, find_named
   implicit none
   private
   public :: new_joint, find_joint, warn_along

contains

   !> Appends a joint or coupler with its name. Returns its index.
   integer function new_joint(model, name) result(index)
      type(model_type), intent(inout) :: model
      character(*), intent(in) :: name
      type(joint_type) :: empty
      empty%name = name
      call append(model%joints, model%counts%joints, empty)
      index = model%counts%joints
      call enter_name(model, 'joint', name, index)
   end function new_joint

   !> Index of a joint between two points by name; 0 if there is none.
   pure integer function find_joint(model, name) result(found)
      type(model_type), intent(in) :: model
      character(*), intent(in) :: name
      found = find_named(model, 'joint', name)
      if (found == 0) return
      if (model%joints(found)%is_coupler()) found = 0
   end function find_joint

   !> Warns of a driver or coupler along a beam that is not exact: the section forces of such beams omit its force.
   subroutine warn_along(model, joint, origin, diagnostics)
      type(model_type), intent(in) :: model
      !> Index of the joint
      integer, intent(in) :: joint
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      if (model%joints(joint)%place /= place_on_beam) return
      associate (beam => model%bodies(model%points(model%joints(joint)%points(2))%body))
         if (.not. beam%reduced%is_exact) call diagnostics%warn(origin, "axial forces of '"//beam%name//"' lack the force "// &
            & "along it at joint '"//model%joints(joint)%name//"'", 'leave out GEOMETRIC and modes: an EXACT beam has them')
      end associate
   end subroutine warn_along

end module limber_model_joint_list
