!> Rack and pinion: TYPE=RACK. Floor: elements. Source: doc/theory, eq. (3.16).
module limber_elements_rack
   use limber_deck_content, only: block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_schema, only: option_spec_type, kind_positive
   use limber_model_joint_kind, only: joint_kind_type
   use limber_model_model, only: joint_type, function_term_type, function_displacement, function_section_angle, &
      & place_rolling
   implicit none
   private
   public :: rack_kind_type, rack_kind

   type, extends(joint_kind_type) :: rack_kind_type
   contains
      procedure :: read
      procedure :: describe
   end type rack_kind_type

contains

   pure type(rack_kind_type) function rack_kind() result(kind)
      kind%word = 'RACK'
      kind%meaning = 'a pinion about the first point rolls along the line through the second one, at ANGLE in the section ' &
         & //'there, on the side where it is in the first guess'
      kind%place = place_rolling
      kind%clamps = [.true., .false.]
      kind%needs = 'RADIUS'
      allocate (kind%options, source=[option_spec_type('JOINT', 'RADIUS', kind_positive, '', 'm', '', &
         & 'RACK: radius of the pinion', only='TYPE=RACK')])
   end function rack_kind

   subroutine read(self, block, joint, diagnostics)
      class(rack_kind_type), intent(in) :: self
      type(block_type), intent(in) :: block
      type(joint_type), intent(inout) :: joint
      type(diagnostics_type), intent(inout) :: diagnostics
      joint%radius(1) = block%real('RADIUS')
   end subroutine read

   !> Place along the line, plus the radius times the angle of the first section less that of the second; minus on the right.
   pure subroutine describe(self, joint)
      class(rack_kind_type), intent(in) :: self
      type(joint_type), intent(inout) :: joint
      allocate (joint%functions, source=[function_term_type(function=function_displacement, angle=joint%angle), &
         & function_term_type(function=function_section_angle, side=1, coefficient=joint%radius(1), by_side=.true.), &
         & function_term_type(function=function_section_angle, side=2, coefficient=-joint%radius(1), by_side=.true.)])
      joint%zero = .false.
   end subroutine describe

end module limber_elements_rack
