!> Weld: TYPE=WELD. Floor: elements. Source: doc/theory, eqs. (3.2), (3.8).
module limber_elements_weld
   use limber_model_joint_kind, only: joint_kind_type, coincidence, alignment
   use limber_model_model, only: joint_type, place_at_point
   implicit none
   private
   public :: weld_kind_type, weld_kind

   type, extends(joint_kind_type) :: weld_kind_type
   contains
      procedure :: describe
   end type weld_kind_type

contains

   pure type(weld_kind_type) function weld_kind() result(kind)
      kind%word = 'WELD'
      kind%meaning = 'the points coincide, and the first section keeps its angle from the second'
      kind%place = place_at_point
      kind%keeps_angle = .true.
      kind%clamps = .true.
   end function weld_kind

   pure subroutine describe(self, joint)
      class(weld_kind_type), intent(in) :: self
      type(joint_type), intent(inout) :: joint
      allocate (joint%functions, source=[coincidence(), alignment(3)])
   end subroutine describe

end module limber_elements_weld
