!> Massless rod: TYPE=ROD. Floor: elements. Source: doc/theory, eq. (3.9).
module limber_elements_rod
   use limber_deck_content, only: block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_schema, only: option_spec_type, kind_positive
   use limber_model_joint_kind, only: joint_kind_type
   use limber_model_model, only: joint_type, function_term_type, function_distance, place_at_distance
   implicit none
   private
   public :: rod_kind_type, rod_kind

   type, extends(joint_kind_type) :: rod_kind_type
   contains
      procedure :: read
      procedure :: describe
   end type rod_kind_type

contains

   pure type(rod_kind_type) function rod_kind() result(kind)
      kind%word = 'ROD'
      kind%meaning = 'the distance of the points stays LENGTH'
      kind%place = place_at_distance
      kind%apart = .true.
      allocate (kind%options, source=[option_spec_type('JOINT', 'LENGTH', kind_positive, '', 'm', '', &
         & 'ROD: its length; if not given, as guessed', only='TYPE=ROD')])
   end function rod_kind

   subroutine read(self, block, joint, diagnostics)
      class(rod_kind_type), intent(in) :: self
      type(block_type), intent(in) :: block
      type(joint_type), intent(inout) :: joint
      type(diagnostics_type), intent(inout) :: diagnostics
      joint%length = block%real('LENGTH')
      joint%has_length = block%given('LENGTH')
   end subroutine read

   pure subroutine describe(self, joint)
      class(rod_kind_type), intent(in) :: self
      type(joint_type), intent(inout) :: joint
      allocate (joint%functions, source=[function_term_type(function=function_distance)])
      joint%zero = .false.
   end subroutine describe

end module limber_elements_rod
