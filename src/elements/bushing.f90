!> Bushings: springs and dampers that hold a section near another one: *BUSHING. Floor: elements. Source: doc/theory, eqs.
!> (3.34)-(3.36).
module limber_elements_bushing
   use limber_base_kinds, only: wp
   use limber_deck_content, only: deck_type, block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_schema, only: keyword_type, option_spec_type, field_spec_type, word_spec_type, keyword_rows_type, many, &
      & needed, kind_name, kind_real, kind_nonnegative, kind_point, form_fields
   use limber_model_element, only: element_type
   use limber_model_held_ends, only: hold_type, note_pair
   use limber_model_load_parts, only: new_part, append_part, name_load, describe_load, find_pair, check_turning
   use limber_model_model, only: model_type, load_part_type, along_angle, along_slide
   use limber_model_points_of_action, only: acting_type, enter_pair, has_pair
   implicit none
   private
   public :: bushing_element_type, bushing_element

   real(wp), parameter :: quarter = 0.5_wp*acos(-1.0_wp)
   type(keyword_type), parameter :: keyword = &
      & keyword_type('BUSHING', many, form_fields, 1, 1, &
      &    'Springs and dampers that hold a point near another one, and two sections near one direction')
   !> Options: kind, values, unit, default, meaning
   type(option_spec_type), parameter :: options(*) = [ &
      & option_spec_type('BUSHING', 'NAME', kind_name, 'joints, drivers and loads', '', needed, 'name of the bushing'), &
      & option_spec_type('BUSHING', 'AXES', kind_real, '', &
      &    'rad', '0', 'angle of its axes in the second body''s frame or section'), &
      & option_spec_type('BUSHING', 'STIFFNESS X', kind_nonnegative, '', &
      &    'N/m', '0', 'force along its first axis for each unit of displacement'), &
      & option_spec_type('BUSHING', 'STIFFNESS Y', kind_nonnegative, '', 'N/m', '0', 'the same along its second axis'), &
      & option_spec_type('BUSHING', 'STIFFNESS ROTATION', kind_nonnegative, '', &
      &    'N m/rad', '0', 'torque for each unit of the angle between the sections'), &
      & option_spec_type('BUSHING', 'DAMPING X', kind_nonnegative, '', 'N s/m', '0', 'force for each unit of speed'), &
      & option_spec_type('BUSHING', 'DAMPING Y', kind_nonnegative, '', 'N s/m', '0', 'force for each unit of speed'), &
      & option_spec_type('BUSHING', 'DAMPING ROTATION', kind_nonnegative, '', 'N m s', '0', 'torque for each unit of spin'), &
      & option_spec_type('BUSHING', 'ANGLE', kind_real, '', &
      &    'rad', '0', 'angle of the first section less that of the second without torque', &
      &    only='STIFFNESS ROTATION')]
   !> Fields of its data lines
   type(field_spec_type), parameter :: fields(*) = [ &
      & field_spec_type('BUSHING', 'first point', kind_point, '', 'body.point'), &
      & field_spec_type('BUSHING', 'second point', kind_point, '', 'body.point: its section carries the axes')]
   !> An example, as it stands in a deck of the tests
   character(*), parameter :: example(*) = [character(110) :: &
      & '*BUSHING, NAME=mount, STIFFNESS X=2e4, STIFFNESS Y=1e4, STIFFNESS ROTATION=500, DAMPING Y=30', &
      & ' engine.origin, bracket.seat']

   type, extends(element_type) :: bushing_element_type
   contains
      procedure :: read
      procedure :: act
      procedure :: hold
      procedure :: tie
   end type bushing_element_type

contains

   type(bushing_element_type) function bushing_element() result(element)
      element%rows = keyword_rows_type(keyword, options, fields, [word_spec_type ::], example)
      element%joins = .true.
   end function bushing_element

   !> Adds two translational parts and a rotational one.
   subroutine read(self, deck, index, model, diagnostics)
      class(bushing_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: index
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      type(load_part_type) :: part
      character(8), parameter :: ends(3) = [character(8) :: 'X', 'Y', 'ROTATION']
      integer :: points(2), k
      associate (block => deck%blocks(index))
         if (size(block%lines) /= 1) return
         call find_pair(block, model, points, diagnostics)
         if (any(points == 0)) return
         if (model%points(points(1))%body == model%points(points(2))%body) call diagnostics%add(block%lines(1)%origin_of(2), &
            & "bushing '"//block%name()//"' joins a body to itself", 'name points of two different bodies')
         if (.not. acts(block)) call diagnostics%add(block%origin, "bushing '"//block%name()//"' does nothing", &
            & 'give it a STIFFNESS or DAMPING: limber help BUSHING')
         do k = 1, 3
            part = new_part(merge(along_angle, along_slide, k == 3), points(1), points(2))
            part%angle = block%real('AXES') + (k - 1)*quarter
            if (k == 3) part%origin = block%real('ANGLE')
            part%stiffness = block%real('STIFFNESS '//trim(ends(k)))
            part%damping = block%real('DAMPING '//trim(ends(k)))
            if (k == 3 .and. part%stiffness + part%damping > 0.0_wp) call check_turning(block, model, points, diagnostics)
            call append_part(model, part)
         end do
         call name_load(model, block%name(), size(model%load_parts) - 2)
         call describe_load(model, holds_sections=.true.)
         model%loads(size(model%loads))%resists = [(block%given('STIFFNESS '//trim(ends(k))) .or. &
            & block%given('DAMPING '//trim(ends(k))), k=1, 3)]
      end associate
   end subroutine read

   !> Whether a stiffness or damping is given.
   pure logical function acts(block)
      type(block_type), intent(in) :: block
      acts = any(block%options%given .and. (index(block%options%name, 'STIFFNESS') == 1 .or. &
         & index(block%options%name, 'DAMPING') == 1))
   end function acts

   !> Both points, and both sections if it resists rotation.
   subroutine act(self, deck, block, body, points)
      class(bushing_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      type(acting_type), allocatable, intent(inout) :: points(:)
      call enter_pair(block, body, .true., block%real('STIFFNESS ROTATION') + block%real('DAMPING ROTATION') > 0.0_wp, points)
   end subroutine act

   !> Its stiffnesses, across the beam the larger one of both axes.
   subroutine hold(self, deck, block, body, holds)
      class(bushing_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      type(hold_type), allocatable, intent(inout) :: holds(:)
      type(hold_type) :: new
      new%across = max(block%real('STIFFNESS X'), block%real('STIFFNESS Y'))
      new%turning = block%real('STIFFNESS ROTATION')
      call note_pair(block, body, new, holds)
   end subroutine hold

   !> Both points.
   subroutine tie(self, deck, block, body, names, tied)
      class(bushing_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      character(64), intent(inout) :: names(2)
      logical, intent(out) :: tied
      tied = has_pair(block)
      if (tied) names = [character(64) :: block%lines(1)%text(1), block%lines(1)%text(2)]
   end subroutine tie

end module limber_elements_bushing
