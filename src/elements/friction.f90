!> Viscous friction in joints: *FRICTION. Floor: elements. Source: doc/theory, eq. (3.36).
module limber_elements_friction
   use limber_deck_content, only: deck_type, block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_schema, only: keyword_type, option_spec_type, field_spec_type, word_spec_type, keyword_rows_type, many, &
      & needed, kind_name, kind_reference, kind_nonnegative, form_none
   use limber_model_element, only: element_type
   use limber_model_joint_coordinates, only: free_motion
   use limber_model_load_parts, only: append_part, name_load
   use limber_model_model, only: model_type, load_part_type
   use limber_model_points, only: find_named
   use limber_model_points_of_action, only: acting_type, along_joint
   implicit none
   private
   public :: friction_element_type, friction_element

   type(keyword_type), parameter :: keyword = &
      & keyword_type('FRICTION', many, form_none, 0, 0, 'Viscous friction in a REVOLUTE, TRANSLATIONAL or POINT ON LINE joint')
   !> Options: kind, values, unit, default, meaning
   type(option_spec_type), parameter :: options(*) = [ &
      & option_spec_type('FRICTION', 'NAME', kind_name, 'joints, drivers and loads', '', needed, 'name of the friction'), &
      & option_spec_type('FRICTION', 'JOINT', kind_reference, 'JOINT', '', needed, &
      &    'joint that it is in, of TYPE REVOLUTE, TRANSLATIONAL or POINT ON LINE'), &
      & option_spec_type('FRICTION', 'COEFFICIENT', kind_nonnegative, '', &
      &    'N m s, N s/m', needed, 'torque for each unit of relative spin, force for each unit of sliding speed')]
   !> An example, as it stands in a deck of the tests
   character(*), parameter :: example(*) = [character(110) :: &
      & '*FRICTION, NAME=rail, JOINT=left-guide, COEFFICIENT=25']

   type, extends(element_type) :: friction_element_type
   contains
      procedure :: read
      procedure :: act
   end type friction_element_type

contains

   type(friction_element_type) function friction_element() result(element)
      element%rows = keyword_rows_type(keyword, options, [field_spec_type ::], [word_spec_type ::], example)
      element%round = 2
   end function friction_element

   !> Adds viscous friction along the free coordinate of a joint.
   subroutine read(self, deck, index, model, diagnostics)
      class(friction_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: index
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      type(load_part_type) :: part
      integer :: i
      logical :: found
      associate (block => deck%blocks(index))
         i = find_named(model, 'joint', block%name('JOINT'))
         if (i == 0) return
         associate (joint => model%joints(i))
            call free_motion(joint, part, found)
            if (.not. found) then
               call diagnostics%add(block%origin_of('JOINT'), "there is no friction in joint '"//joint%name//"'", &
                  & 'it is for joints of the types REVOLUTE, TRANSLATIONAL and POINT ON LINE', object=block%name('JOINT'))
               return
            end if
            part%damping = block%real('COEFFICIENT')
            call append_part(model, part)
            call name_load(model, block%name(), size(model%load_parts))
         end associate
      end associate
   end subroutine read

   !> The points of its joint.
   subroutine act(self, deck, block, body, points)
      class(friction_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      type(acting_type), allocatable, intent(inout) :: points(:)
      call along_joint(deck, block%name('JOINT'), body, points)
   end subroutine act

end module limber_elements_friction
