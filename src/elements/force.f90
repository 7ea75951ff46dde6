!> Forces on points: *FORCE. Floor: elements. Source: doc/theory, eqs. (3.31), (3.32).
module limber_elements_force
   use limber_base_kinds, only: wp
   use limber_deck_content, only: deck_type, block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_schema, only: keyword_type, option_spec_type, field_spec_type, word_spec_type, keyword_rows_type, many, &
      & needed, kind_name, kind_point, kind_yes, kind_law, form_fields
   use limber_model_element, only: element_type
   use limber_model_load_parts, only: new_part, set_law, append_part, name_load, need_frame, is_zero
   use limber_model_model, only: ground, model_type, load_part_type, along_axis, along_follower
   use limber_model_points, only: find_point
   use limber_model_points_of_action, only: acting_type, enter
   implicit none
   private
   public :: point_force_element_type, force_element

   real(wp), parameter :: quarter = 0.5_wp*acos(-1.0_wp)
   type(keyword_type), parameter :: keyword = &
      & keyword_type('FORCE', many, form_fields, 1, 1, &
      &    'A force on a point; laws of loads may use places, speeds, angles and joint coordinates, no accelerations')
   !> Options: kind, values, unit, default, meaning
   type(option_spec_type), parameter :: options(*) = [ &
      & option_spec_type('FORCE', 'NAME', kind_name, 'joints, drivers and loads', '', needed, 'name of the force'), &
      & option_spec_type('FORCE', 'POINT', kind_point, '', '', needed, 'point that it acts on: body.point'), &
      & option_spec_type('FORCE', 'FOLLOWER', kind_yes, '', &
      &    '', 'NO', 'components along the axes of the body''s frame, of a beam: of its section at the point')]
   !> Fields of its data lines
   type(field_spec_type), parameter :: fields(*) = [ &
      & field_spec_type('FORCE', 'fx', kind_law, 'N', &
      &    'component along the first axis, expression of the time t and of quantities'), &
      & field_spec_type('FORCE', 'fy', kind_law, 'N', 'component along the second axis, likewise')]
   !> An example, as it stands in a deck of the tests
   character(*), parameter :: example(*) = [character(110) :: &
      & '*FORCE, NAME=hammer, POINT=bar.end', &
      & ' 0, blow*step(duration - t)']

   type, extends(element_type) :: point_force_element_type
   contains
      procedure :: read
      procedure :: act
   end type point_force_element_type

contains

   type(point_force_element_type) function force_element() result(element)
      element%rows = keyword_rows_type(keyword, options, fields, [word_spec_type ::], example)
   end function force_element

   !> Adds a force as one part for each of its two components; a zero component is left out.
   subroutine read(self, deck, index, model, diagnostics)
      class(point_force_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: index
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      type(load_part_type) :: part
      integer :: point, first, k
      associate (block => deck%blocks(index))
         point = find_point(model, block%text('POINT'), block%origin_of('POINT'), diagnostics)
         if (point == 0 .or. size(block%lines) /= 1) return
         if (model%points(point)%body == ground) then
            call diagnostics%add(block%origin_of('POINT'), "force '"//block%name()//"' acts on the ground, and moves nothing", &
               & 'name a point of a body')
            return
         end if
         if (block%yes('FOLLOWER')) call need_frame(model, point, block%text('POINT'), block%origin_of('POINT'), diagnostics)
         first = size(model%load_parts) + 1
         do k = 1, 2
            if (is_zero(block%lines(1)%fields(k)%expression)) cycle
            part = new_part(merge(along_follower, along_axis, block%yes('FOLLOWER')), point, 0)
            part%angle = (k - 1)*quarter
            call set_law(part, block%lines(1)%fields(k)%expression, 1.0_wp)
            call append_part(model, part)
         end do
         call name_load(model, block%name(), first)
      end associate
   end subroutine read

   !> Its point.
   subroutine act(self, deck, block, body, points)
      class(point_force_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      type(acting_type), allocatable, intent(inout) :: points(:)
      call enter(block%text('POINT'), body, .true., .false., points)
   end subroutine act

end module limber_elements_force
