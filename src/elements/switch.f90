!> Switches: states that loads, joints and drivers ask for: *SWITCH, and the options ACTIVE and INACTIVE. Floor: elements. Source:
!> doc/theory, section 5.20.
module limber_elements_switch
   use limber_deck_content, only: deck_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_schema, only: keyword_type, option_spec_type, field_spec_type, word_spec_type, keyword_rows_type, many, needed, &
      & kind_name, kind_reference, kind_word, form_none
   use limber_model_element, only: element_type
   use limber_model_model, only: model_type, switch_type
   implicit none
   private
   public :: switch_element_type, switch_element, switch_options

   type(keyword_type), parameter :: keyword = &
      & keyword_type('SWITCH', many, form_none, 0, 0, &
      &    'A switch: loads, joints and drivers with ACTIVE= act while it is on; events turn it, ACTION=SWITCH')
   !> Options: kind, values, unit, default, meaning
   type(option_spec_type), parameter :: options(*) = [ &
      & option_spec_type('SWITCH', 'NAME', kind_name, 'switches', '', needed, 'name of the switch'), &
      & option_spec_type('SWITCH', 'STATE', kind_word, 'ON|OFF', '', 'ON', 'its state at the start of the first analysis')]
   !> Options of what asks for a switch
   type(option_spec_type), parameter :: asking(*) = [ &
      & option_spec_type('SWITCH', 'ACTIVE', kind_reference, 'SWITCH', '', '', 'it acts only while this switch is on'), &
      & option_spec_type('SWITCH', 'INACTIVE', kind_reference, 'SWITCH', '', '', 'it acts only while this switch is off')]
   !> An example, as it stands in a deck of the tests
   character(*), parameter :: example(*) = [character(110) :: &
      & '*SWITCH, NAME=latch, STATE=OFF', &
      & '*JOINT, NAME=grip, TYPE=REVOLUTE, ACTIVE=latch', &
      & ' ball, arm.claw', &
      & '*EVENT, NAME=catch, DIRECTION=DOWN, ACTION=SWITCH, SWITCH=latch', &
      & ' angle(arm) + pi/2']

   type, extends(element_type) :: switch_element_type
   contains
      procedure :: read
   end type switch_element_type

contains

   type(switch_element_type) function switch_element() result(element)
      element%rows = keyword_rows_type(keyword, options, [field_spec_type ::], [word_spec_type ::], example)
      element%round = 0
      element%switchable = .false.
   end function switch_element

   !> Rows of the options of a keyword whose blocks may ask for a switch.
   function switch_options(name) result(rows)
      !> The keyword
      character(*), intent(in) :: name
      type(option_spec_type) :: rows(size(asking))
      rows = asking
      rows%keyword = name
   end function switch_options

   !> Adds a switch.
   subroutine read(self, deck, index, model, diagnostics)
      class(switch_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: index
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      type(switch_type) :: switch
      switch%name = deck%blocks(index)%name()
      switch%on = deck%blocks(index)%word('STATE') == 'ON'
      model%switches = [model%switches, switch]
   end subroutine read

end module limber_elements_switch
