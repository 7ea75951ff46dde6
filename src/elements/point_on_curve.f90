!> Point on a curve, a cam: TYPE=POINT ON CURVE. Its *CURVE is read by `limber_elements_joint`. Floor: elements. Source: doc/theory,
!> eqs. (3.17)-(3.20).
module limber_elements_point_on_curve
   use limber_deck_schema, only: option_spec_type, kind_reference
   use limber_model_joint_kind, only: joint_kind_type, right_angle
   use limber_model_model, only: joint_type, function_term_type, function_displacement, place_on_curve
   implicit none
   private
   public :: point_on_curve_kind_type, point_on_curve_kind

   type, extends(joint_kind_type) :: point_on_curve_kind_type
   contains
      procedure :: describe
   end type point_on_curve_kind_type

contains

   pure type(point_on_curve_kind_type) function point_on_curve_kind() result(kind)
      kind%word = 'POINT ON CURVE'
      kind%meaning = 'the first point stays on CURVE, whose origin is the second point, its x axis at ANGLE in the ' &
         & //'section there; a cam. A kink is an impact, a jump is refused; behind its ends an open curve is straight'
      kind%place = place_on_curve
      kind%needs = 'CURVE'
      allocate (kind%options, source=[option_spec_type('JOINT', 'CURVE', kind_reference, 'CURVE', '', '', &
         & 'POINT ON CURVE: the curve, around the second point', only='TYPE=POINT ON CURVE')])
   end function point_on_curve_kind

   !> The functions that its curve relates: both coordinates of the first point in the axes of the curve.
   pure subroutine describe(self, joint)
      class(point_on_curve_kind_type), intent(in) :: self
      type(joint_type), intent(inout) :: joint
      allocate (joint%functions, source=[function_term_type(function=function_displacement, angle=joint%angle), &
         & function_term_type(function=function_displacement, angle=joint%angle + right_angle)])
   end subroutine describe

end module limber_elements_point_on_curve
