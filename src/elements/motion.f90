!> Motions of whole bodies as functions of time: *MOTION. One driver for each coordinate of the frame's origin and one for its
!> angle;
!> the system solves them without unknowns. Floor: elements. Source: doc/theory, eqs. (4.9)-(4.12).
module limber_elements_motion
   use limber_deck_content, only: deck_type, block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_expression, only: expression_type
   use limber_deck_schema, only: keyword_type, option_spec_type, field_spec_type, word_spec_type, keyword_rows_type, many, needed, &
      & kind_name, kind_reference, kind_time_expression, form_fields
   use limber_model_beam_segments, only: find_frame
   use limber_model_driver_list, only: append_driver
   use limber_model_element, only: element_type
   use limber_model_held_ends, only: hold_type, note
   use limber_model_model, only: model_type, driver_type, body_point, driver_x, driver_y, driver_angle
   use limber_model_points, only: find_named
   use limber_model_points_of_action, only: acting_type, enter
   implicit none
   private
   public :: motion_element_type, motion_element

   type(keyword_type), parameter :: keyword = &
      & keyword_type('MOTION', many, form_fields, 1, 1, &
      &    'The whole motion of a body as functions of time: it has no unknowns, its mass only adds to the driving forces')
   !> Options: kind, values, unit, default, meaning
   type(option_spec_type), parameter :: options(*) = [ &
      & option_spec_type('MOTION', 'NAME', kind_name, 'joints, drivers and loads', &
      &    '', needed, 'name; its drivers are NAME_x, NAME_y and NAME_angle, of which force and torque can be asked'), &
      & option_spec_type('MOTION', 'BODY', kind_reference, 'RIGID BODY|POINT MASS|BEAM|FRAME', &
      &    '', needed, 'body whose frame is moved')]
   !> Fields of its data lines
   type(field_spec_type), parameter :: fields(*) = [ &
      & field_spec_type('MOTION', 'x', kind_time_expression, 'm', 'of the origin of the body''s frame, expression of the time t'), &
      & field_spec_type('MOTION', 'y', kind_time_expression, 'm', 'of the origin, likewise'), &
      & field_spec_type('MOTION', 'angle', kind_time_expression, 'rad', &
      &    'of the frame, likewise; a point mass has none', optional=.true.)]
   !> An example, as it stands in a deck of the tests
   character(*), parameter :: example(*) = [character(110) :: &
      & '*MOTION, NAME=motor, BODY=crank', &
      & ' 0, 0, speed*t']

   type, extends(element_type) :: motion_element_type
   contains
      procedure :: read
      procedure :: act
      procedure :: hold
      procedure :: tie
      procedure :: turns
      procedure :: drives => turns
   end type motion_element_type

contains

   type(motion_element_type) function motion_element() result(element)
      element%rows = keyword_rows_type(keyword, options, fields, [word_spec_type ::], example)
      element%round = 2
   end function motion_element

   !> Adds the drivers of a *MOTION.
   subroutine read(self, deck, index, model, diagnostics)
      class(motion_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: index
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: body, origin
      associate (block => deck%blocks(index))
         if (size(block%lines) /= 1) return
         body = find_frame(model, block%name('BODY'), block%origin_of('BODY'), diagnostics, &
            & 'weld it to a rigid body and move that, or drive a joint or points of it by *DRIVER')
         if (body == 0) return
         associate (line => block%lines(1), turns => model%bodies(body)%kind /= body_point)
            if (line%count() == 3 .and. .not. turns) then
               call diagnostics%add(line%origin_of(3), "'"//model%bodies(body)%name//"' is a point mass and has no angle", &
                  & 'give x and y alone')
               return
            else if (line%count() < 3 .and. turns) then
               call diagnostics%add(line%origin, "motion '"//block%name()//"' gives no angle of body '"//block%name('BODY')// &
                  & "'", 'add a third field; to leave it free, use *DRIVER of TYPE=X and TYPE=Y')
               return
            end if
            origin = find_named(model, 'point', block%name('BODY')//'.origin')
            if (origin == 0) then
               call diagnostics%add(block%origin_of('BODY'), "frame '"//model%bodies(body)%name//"' has no node at the origin"// &
                  & ' of its axes, where *MOTION moves it', 'move the axes so that a node is at 0, 0')
               return
            end if
            call add('_x', driver_x, line%fields(1)%expression)
            call add('_y', driver_y, line%fields(2)%expression)
            if (turns) call add('_angle', driver_angle, line%fields(3)%expression)
         end associate
      end associate

   contains

      !> Appends one driver.
      subroutine add(suffix, kind, law)
         character(*), intent(in) :: suffix
         integer, intent(in) :: kind
         type(expression_type), intent(in) :: law
         type(driver_type) :: driver
         driver%name = deck%blocks(index)%name()//suffix
         driver%kind = kind
         driver%law = law
         if (kind == driver_angle) then
            driver%body = body
         else
            driver%points(1) = origin
         end if
         if (find_named(model, 'driver', driver%name) > 0) call diagnostics%add(deck%blocks(index)%origin_of('NAME'), &
            & "there is a driver '"//driver%name//"' already", 'choose another name')
         call append_driver(model, driver)
      end subroutine add

   end subroutine read

   !> The origin of the body.
   subroutine act(self, deck, block, body, points)
      class(motion_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      type(acting_type), allocatable, intent(inout) :: points(:)
      if (block%has('BODY')) call enter(block%name('BODY'), body, .true., .true., points, .true., .true.)
   end subroutine act

   !> The origin of the body, in all directions.
   subroutine hold(self, deck, block, body, holds)
      class(motion_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      type(hold_type), allocatable, intent(inout) :: holds(:)
      if (block%name('BODY') == body) call note(hold_type('origin', [.true., .true.], .true.), holds)
   end subroutine hold

   !> The origin of the body and the ground.
   subroutine tie(self, deck, block, body, names, tied)
      class(motion_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      character(64), intent(inout) :: names(2)
      logical, intent(out) :: tied
      tied = block%has('BODY')
      if (tied) names = [character(64) :: block%name('BODY'), 'ground.origin']
   end subroutine tie

   pure logical function turns(self, block, body)
      class(motion_element_type), intent(in) :: self
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      turns = block%has('BODY')
      if (turns) turns = block%name('BODY') == body
   end function turns

end module limber_elements_motion
