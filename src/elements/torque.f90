!> Torques on frames of bodies and on sections: *TORQUE. Floor: elements. Source: doc/theory, eqs. (3.31), (3.33).
module limber_elements_torque
   use limber_base_kinds, only: wp
   use limber_deck_content, only: deck_type, block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_schema, only: keyword_type, option_spec_type, field_spec_type, word_spec_type, keyword_rows_type, many, &
      & needed, kind_name, kind_reference, kind_point, kind_law, form_fields
   use limber_model_element, only: element_type
   use limber_model_beam_segments, only: find_frame
   use limber_model_load_parts, only: new_part, set_law, append_part, name_load, section, frame_point, turn_alike
   use limber_model_model, only: model_type, load_part_type, along_angle, ground
   use limber_model_points_of_action, only: acting_type, enter
   implicit none
   private
   public :: torque_element_type, torque_element

   type(keyword_type), parameter :: keyword = &
      & keyword_type('TORQUE', many, form_fields, 1, 1, 'A torque on a body, or between two')
   !> Options: kind, values, unit, default, meaning
   type(option_spec_type), parameter :: options(*) = [ &
      & option_spec_type('TORQUE', 'NAME', kind_name, 'joints, drivers and loads', '', needed, 'name of the torque'), &
      & option_spec_type('TORQUE', 'BODY', kind_reference, 'RIGID BODY|BEAM|FRAME', &
      &    '', '', 'body that it acts on; of a beam: its floating frame; this or POINT'), &
      & option_spec_type('TORQUE', 'POINT', kind_point, '', '', '', 'section of a beam that it acts on; this or BODY'), &
      & option_spec_type('TORQUE', 'REACTION', kind_point, '', &
      &    '', '', 'body, or section of a beam, on which the opposite torque acts; if not given, the ground')]
   !> Fields of its data lines
   type(field_spec_type), parameter :: fields(*) = [ &
      & field_spec_type('TORQUE', 'value', kind_law, 'N m', &
      &    'positive from x to y, expression of the time t and of quantities')]
   !> An example, as it stands in a deck of the tests
   character(*), parameter :: example(*) = [character(110) :: &
      & '*TORQUE, NAME=elbow-motor, POINT=fore.start, REACTION=upper.end', &
      & ' -0.4*cos(2*pi*t/stop)']

   type, extends(element_type) :: torque_element_type
   contains
      procedure :: read
      procedure :: act
      procedure :: turns
   end type torque_element_type

contains

   type(torque_element_type) function torque_element() result(element)
      element%rows = keyword_rows_type(keyword, options, fields, [word_spec_type ::], example)
   end function torque_element

   !> Adds a torque on the frame of a body or on a section.
   subroutine read(self, deck, index, model, diagnostics)
      class(torque_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: index
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      type(load_part_type) :: part
      integer :: body, points(2)
      associate (block => deck%blocks(index))
         if (block%has('BODY') .eqv. block%has('POINT')) then
            call diagnostics%add(block%origin, "torque '"//block%name()//"' needs BODY or POINT, one of them", &
               & 'BODY=body, or POINT=beam.point for a section of a beam')
            return
         end if
         if (size(block%lines) /= 1) return
         points = 0
         if (block%has('BODY')) then
            body = find_frame(model, block%name('BODY'), block%origin_of('BODY'), diagnostics)
            if (body == 0) return
            points(1) = frame_point(model, body)
         else
            points(1) = section(block, 'POINT', model, diagnostics)
            if (points(1) == 0) return
         end if
         if (block%has('REACTION')) then
            points(2) = section(block, 'REACTION', model, diagnostics)
            if (points(2) == 0) return
         end if
         call check_effect(block, model, points, diagnostics)
         part = new_part(along_angle, points(1), points(2))
         call set_law(part, block%lines(1)%fields(1)%expression, 1.0_wp)
         call append_part(model, part)
         call name_load(model, block%name(), size(model%load_parts))
      end associate
   end subroutine read

   !> Reports a torque that moves nothing: on the ground, or on two sections that always turn alike.
   subroutine check_effect(block, model, points, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(in) :: model
      !> The second is 0 without REACTION
      integer, intent(in) :: points(2)
      type(diagnostics_type), intent(inout) :: diagnostics
      if (points(2) == 0) then
         if (model%points(points(1))%body == ground) call diagnostics%add(block%origin_of('POINT'), "torque '"//block%name()// &
            & "' acts on the ground, and moves nothing", 'name a section of a body')
      else if (turn_alike(model, points)) then
         call diagnostics%add(block%origin_of('REACTION'), "torque '"//block%name()// &
            & "' and its reaction act on the same "//trim(merge('body   ', 'section', size(model%points(points(1))%psi) == 0))// &
            & ', and move nothing', &
            & 'name another body, or leave REACTION out: then the ground bears it')
      end if
   end subroutine check_effect

   !> Its sections, or the origin of its body.
   subroutine act(self, deck, block, body, points)
      class(torque_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      type(acting_type), allocatable, intent(inout) :: points(:)
      if (block%has('POINT')) call enter(block%text('POINT'), body, .false., .true., points)
      if (block%has('REACTION')) call enter(block%text('REACTION'), body, .false., .true., points)
      if (block%has('BODY')) call enter(block%name('BODY'), body, .false., .true., points)
   end subroutine act

   !> Whether it acts on the frame of a body.
   pure logical function turns(self, block, body)
      class(torque_element_type), intent(in) :: self
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      turns = block%has('BODY')
      if (turns) turns = block%name('BODY') == body
   end function turns

end module limber_elements_torque
