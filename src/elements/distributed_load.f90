!> Loads along beams and members of frames: *DISTRIBUTED LOAD. Floor: elements. Source: doc/theory, eqs. (3.37), (3.38).
module limber_elements_distributed_load
   use limber_deck_content, only: deck_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_schema, only: keyword_type, option_spec_type, field_spec_type, word_spec_type, keyword_rows_type, many, &
      & needed, kind_name, kind_reference, kind_counting, kind_yes, kind_nonnegative, kind_positive, kind_shape, kind_law, &
      & form_fields
   use limber_model_distributed_loads, only: add_distributed
   use limber_model_element, only: element_type
   use limber_model_model, only: model_type
   implicit none
   private
   public :: distributed_load_element_type, distributed_load_element

   type(keyword_type), parameter :: keyword = &
      & keyword_type('DISTRIBUTED LOAD', many, form_fields, 1, many, &
      &    'A load along a beam or a member of a frame; several data lines are added')
   !> Options: kind, values, unit, default, meaning
   type(option_spec_type), parameter :: options(*) = [ &
      & option_spec_type('DISTRIBUTED LOAD', 'NAME', kind_name, 'joints, drivers and loads', '', needed, 'name of the load'), &
      & option_spec_type('DISTRIBUTED LOAD', 'BODY', kind_reference, 'BEAM|FRAME', '', needed, 'beam or frame that it acts on'), &
      & option_spec_type('DISTRIBUTED LOAD', 'MEMBER', kind_counting, '', '', '', 'number of the member of the frame'), &
      & option_spec_type('DISTRIBUTED LOAD', 'FOLLOWER', kind_yes, '', &
      &    '', 'NO', 'components along and across each section, with which they turn, not along the axes of space'), &
      & option_spec_type('DISTRIBUTED LOAD', 'START', kind_nonnegative, '', 'm', '0', 'coordinate s where it begins'), &
      & option_spec_type('DISTRIBUTED LOAD', 'END', kind_positive, '', &
      &    'm', '', 'coordinate s where it ends; if not given, the end of the beam or member')]
   !> Fields of its data lines
   type(field_spec_type), parameter :: fields(*) = [ &
      & field_spec_type('DISTRIBUTED LOAD', 'qx', kind_shape, 'N/m', 'along the first axis, expression of s along it'), &
      & field_spec_type('DISTRIBUTED LOAD', 'qy', kind_shape, 'N/m', 'along the second axis, expression of s'), &
      & field_spec_type('DISTRIBUTED LOAD', 'factor', kind_law, '', &
      &    'expression of the time t and of quantities', .true.)]
   !> An example, as it stands in a deck of the tests
   character(*), parameter :: example(*) = [character(110) :: &
      & '*DISTRIBUTED LOAD, NAME=triangular, BODY=triangular', &
      & ' 0, -q*s/length, smoothstep(t)']

   type, extends(element_type) :: distributed_load_element_type
   contains
      procedure :: read
   end type distributed_load_element_type

contains

   type(distributed_load_element_type) function distributed_load_element() result(element)
      element%rows = keyword_rows_type(keyword, options, fields, [word_spec_type ::], example)
   end function distributed_load_element

   !> Adds the load as forces at points that represent it.
   subroutine read(self, deck, index, model, diagnostics)
      class(distributed_load_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: index
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      call add_distributed(deck%blocks(index), model, diagnostics)
   end subroutine read

end module limber_elements_distributed_load
