!> Translational joint: TYPE=TRANSLATIONAL. Floor: elements. Source: doc/theory, eqs. (3.3), (3.8).
module limber_elements_translational
   use limber_model_joint_kind, only: joint_kind_type, across_line, alignment
   use limber_model_model, only: joint_type, place_on_line
   implicit none
   private
   public :: translational_kind_type, translational_kind

   type, extends(joint_kind_type) :: translational_kind_type
   contains
      procedure :: describe
   end type translational_kind_type

contains

   pure type(translational_kind_type) function translational_kind() result(kind)
      kind%word = 'TRANSLATIONAL'
      kind%meaning = 'the same, and the first section keeps its angle from the second'
      kind%place = place_on_line
      kind%keeps_angle = .true.
      kind%clamps = .true.
   end function translational_kind

   pure subroutine describe(self, joint)
      class(translational_kind_type), intent(in) :: self
      type(joint_type), intent(inout) :: joint
      allocate (joint%functions, source=[across_line(joint%angle), alignment(2)])
   end subroutine describe

end module limber_elements_translational
