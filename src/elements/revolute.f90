!> Revolute joint: TYPE=REVOLUTE. Floor: elements. Source: doc/theory, eq. (3.2).
module limber_elements_revolute
   use limber_model_joint_kind, only: joint_kind_type, coincidence
   use limber_model_model, only: joint_type, place_at_point
   implicit none
   private
   public :: revolute_kind_type, revolute_kind

   type, extends(joint_kind_type) :: revolute_kind_type
   contains
      procedure :: describe
   end type revolute_kind_type

contains

   pure type(revolute_kind_type) function revolute_kind() result(kind)
      kind%word = 'REVOLUTE'
      kind%meaning = 'the two points coincide'
      kind%place = place_at_point
   end function revolute_kind

   pure subroutine describe(self, joint)
      class(revolute_kind_type), intent(in) :: self
      type(joint_type), intent(inout) :: joint
      allocate (joint%functions, source=coincidence())
   end subroutine describe

end module limber_elements_revolute
