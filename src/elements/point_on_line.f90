!> Point on a line: TYPE=POINT ON LINE. Floor: elements. Source: doc/theory, eq. (3.3).
module limber_elements_point_on_line
   use limber_model_joint_kind, only: joint_kind_type, across_line
   use limber_model_model, only: joint_type, place_on_line
   implicit none
   private
   public :: point_on_line_kind_type, point_on_line_kind

   type, extends(joint_kind_type) :: point_on_line_kind_type
   contains
      procedure :: describe
   end type point_on_line_kind_type

contains

   pure type(point_on_line_kind_type) function point_on_line_kind() result(kind)
      kind%word = 'POINT ON LINE'
      kind%meaning = 'the first point stays on the line through the second one, at ANGLE in the section there: a pin in a slot'
      kind%place = place_on_line
   end function point_on_line_kind

   pure subroutine describe(self, joint)
      class(point_on_line_kind_type), intent(in) :: self
      type(joint_type), intent(inout) :: joint
      allocate (joint%functions, source=[across_line(joint%angle)])
   end subroutine describe

end module limber_elements_point_on_line
