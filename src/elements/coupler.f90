!> Linear couplings of joint coordinates: *COUPLER. Floor: elements. Source: doc/theory, eq. (3.21).
module limber_elements_coupler
   use limber_base_kinds, only: wp
   use limber_deck_content, only: deck_type, block_type, line_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_schema, only: keyword_type, option_spec_type, field_spec_type, word_spec_type, keyword_rows_type, many, needed, &
      & kind_name, kind_time_expression, form_fields
   use limber_model_beam_segments, only: find_frame
   use limber_model_element, only: element_type
   use limber_model_joint_coordinates, only: check_coordinate
   use limber_model_joint_list, only: new_joint, find_joint, warn_along
   use limber_model_model, only: model_type, term_type, body_point, coordinate_angle, coordinate_joint_angle, &
      & coordinate_displacement
   use limber_model_points_of_action, only: acting_type, enter, along_joint
   implicit none
   private
   public :: coupler_element_type, coupler_element

   type(keyword_type), parameter :: keyword = &
      & keyword_type('COUPLER', many, form_fields, 1, many, &
      &    'A linear coupling: the sum of coefficient times joint coordinate, a term each line, stays as it is or is given')
   !> Options: kind, values, unit, default, meaning
   type(option_spec_type), parameter :: options(*) = [ &
      & option_spec_type('COUPLER', 'NAME', kind_name, 'joints, drivers and loads', '', needed, 'name of the coupler')]
   !> Fields of its data lines
   type(field_spec_type), parameter :: fields(*) = [ &
      & field_spec_type('COUPLER', 'coefficient', kind_time_expression, '', &
      &    'of the term; of value: what the sum is, expression of the time t'), &
      & field_spec_type('COUPLER', 'coordinate', kind_name, '', 'angle, joint_angle, displacement or value; angles count turns'), &
      & field_spec_type('COUPLER', 'object', kind_name, '', 'body of angle, joint of the others', .true.)]
   !> An example, as it stands in a deck of the tests
   character(*), parameter :: example(*) = [character(110) :: &
      & '*COUPLER, NAME=ring-mesh', &
      & ' ring, angle, ring', &
      & ' -ring, angle, carrier', &
      & ' -planet, joint_angle, planet-pin']

   type, extends(element_type) :: coupler_element_type
   contains
      procedure :: read
      procedure :: act
      procedure :: turns
   end type coupler_element_type

contains

   type(coupler_element_type) function coupler_element() result(element)
      element%rows = keyword_rows_type(keyword, options, fields, [word_spec_type ::], example)
      element%round = 2
   end function coupler_element

   !> Adds a coupler, a linear relation of joint coordinates.
   subroutine read(self, deck, index, model, diagnostics)
      class(coupler_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: index
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      type(term_type) :: term
      integer :: i, joint, before
      associate (block => deck%blocks(index))
         before = diagnostics%count
         joint = new_joint(model, block%name())
         allocate (model%joints(joint)%terms(0))
         do i = 1, size(block%lines)
            if (block%lines(i)%text(2) == 'value') then
               if (model%joints(joint)%has_law) call diagnostics%add(block%lines(i)%origin_of(2), 'a second value of the sum', &
                  & 'add the two in one line')
               model%joints(joint)%has_law = .true.
               model%joints(joint)%law = block%lines(i)%fields(1)%expression
               cycle
            end if
            call read_term(block, block%lines(i), model, term, diagnostics)
            if (term%of == 0) cycle
            if (any(model%joints(joint)%terms%kind == term%kind .and. model%joints(joint)%terms%of == term%of)) call &
               & diagnostics%add(block%lines(i)%origin_of(2), block%lines(i)%text(2)//' of '//block%lines(i)%text(3)// &
               & " stands twice in coupler '"//block%name()//"'", 'add the two coefficients in one line')
            model%joints(joint)%terms = [model%joints(joint)%terms, term]
         end do
         if (diagnostics%count > before) return
         if (size(model%joints(joint)%terms) == 0) call diagnostics%add(block%origin, "coupler '"//block%name()// &
            & "' has no joint coordinate", 'add a line: coefficient, angle, body')
      end associate
   end subroutine read

   !> Reads one term: coefficient, coordinate, object.
   subroutine read_term(block, line, model, term, diagnostics)
      type(block_type), intent(in) :: block
      type(line_type), intent(in) :: line
      type(model_type), intent(in) :: model
      !> `of` is 0 after an error
      type(term_type), intent(out) :: term
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: before
      if (.not. line%fields(1)%expression%is_constant()) then
         call diagnostics%add(line%origin_of(1), "a coefficient of coupler '"//block%name()//"' must be a constant", &
            & 'only value may be an expression of t')
         return
      end if
      term%coefficient = line%fields(1)%expression%constant_value()
      if (.not. abs(term%coefficient) > 0.0_wp) call diagnostics%add(line%origin_of(1), "a coefficient of coupler '"// &
         & block%name()//"' is 0, and couples nothing", 'leave this line out, or give another number')
      select case (line%text(2))
      case ('angle'); term%kind = coordinate_angle
      case ('joint_angle'); term%kind = coordinate_joint_angle
      case ('displacement'); term%kind = coordinate_displacement
      case default
         call diagnostics%add(line%origin_of(2), "there is no joint coordinate '"//line%text(2)//"'", &
            & 'valid: angle, joint_angle, displacement, value')
         return
      end select
      if (size(line%fields) < 3) then
         call diagnostics%add(line%origin_of(2), line%text(2)//' of what?', 'add a third field: the body or the joint')
      else if (term%kind == coordinate_angle) then
         before = diagnostics%count
         term%of = find_frame(model, line%text(3), line%origin_of(3), diagnostics)
         if (diagnostics%count > before) return
         if (term%of == 0) then
            call diagnostics%add(line%origin_of(3), "there is no body '"//line%text(3)//"'", &
               & object=line%text(3))
         else if (model%bodies(term%of)%kind == body_point) then
            call diagnostics%add(line%origin_of(3), "'"//line%text(3)//"' is a point mass and has no angle")
            term%of = 0
         end if
      else
         term%of = find_joint(model, line%text(3))
         if (term%of == 0) call diagnostics%add(line%origin_of(3), "there is no joint '"//line%text(3)//"'", &
            & object=line%text(3))
         if (term%of == 0) return
         call check_coordinate(model%joints(term%of), term%kind, line%origin_of(2), diagnostics)
         if (term%kind == coordinate_displacement) call warn_along(model, term%of, line%origin_of(3), diagnostics)
      end if
   end subroutine read_term

   !> The points of its joints, and the origins of bodies whose angles it couples.
   subroutine act(self, deck, block, body, points)
      class(coupler_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      type(acting_type), allocatable, intent(inout) :: points(:)
      integer :: i
      do i = 1, size(block%lines)
         if (block%lines(i)%count() < 3) cycle
         if (block%lines(i)%text(2) == 'angle') then
            call enter(block%lines(i)%text(3), body, .false., .true., points)
         else
            call along_joint(deck, block%lines(i)%text(3), body, points)
         end if
      end do
   end subroutine act

   !> Whether it couples the angle of a body.
   pure logical function turns(self, block, body)
      class(coupler_element_type), intent(in) :: self
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      integer :: i
      turns = .false.
      do i = 1, size(block%lines)
         if (block%lines(i)%count() < 3) cycle
         turns = turns .or. (block%lines(i)%text(2) == 'angle' .and. block%lines(i)%text(3) == body)
      end do
   end function turns

end module limber_elements_coupler
