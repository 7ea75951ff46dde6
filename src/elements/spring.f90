!> Springs, dampers and actuators between two points or two sections: *SPRING. Floor: elements. Source: doc/theory, eqs.
!> (3.34)-(3.36).
module limber_elements_spring
   use limber_base_kinds, only: wp
   use limber_deck_content, only: deck_type, block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_schema, only: keyword_type, option_spec_type, field_spec_type, word_spec_type, keyword_rows_type, many, &
      & needed, kind_name, kind_word, kind_nonnegative, kind_real, kind_point, kind_spring_law, form_fields
   use limber_model_element, only: element_type
   use limber_model_held_ends, only: hold_type, note_pair
   use limber_model_load_parts, only: new_part, set_law, append_part, name_load, describe_load, find_pair, check_turning, &
      & turn_alike, keep_distance
   use limber_model_model, only: model_type, load_part_type, along_angle, along_distance
   use limber_model_points_of_action, only: acting_type, enter_pair
   implicit none
   private
   public :: spring_element_type, spring_element

   type(keyword_type), parameter :: keyword = &
      & keyword_type('SPRING', many, form_fields, 1, 1, 'A spring, damper and actuator between two points or two sections')
   !> Options: kind, values, unit, default, meaning
   type(option_spec_type), parameter :: options(*) = [ &
      & option_spec_type('SPRING', 'NAME', kind_name, 'joints, drivers and loads', '', needed, 'name of the spring'), &
      & option_spec_type('SPRING', 'TYPE', kind_word, 'TRANSLATIONAL|ROTATIONAL', &
      &    '', 'TRANSLATIONAL', 'along the line through the points, or by the angle from the first section to the second'), &
      & option_spec_type('SPRING', 'STIFFNESS', kind_nonnegative, '', &
      &    'N/m, N m/rad', '0', 'tension for each unit of extension, torque for each unit of angle'), &
      & option_spec_type('SPRING', 'LENGTH', kind_nonnegative, '', &
      &    'm', '0', 'TRANSLATIONAL: free length, the distance of the points without tension', only='TYPE=TRANSLATIONAL'), &
      & option_spec_type('SPRING', 'ANGLE', kind_real, '', &
      &    'rad', '0', 'ROTATIONAL: free angle of the second body less that of the first, turns included', &
      &    only='TYPE=ROTATIONAL'), &
      & option_spec_type('SPRING', 'DAMPING', kind_nonnegative, '', &
      &    'N s/m, N m s', '0', 'tension for each unit of the speed at which the points part, torque for each unit of spin')]
   !> Fields of its data lines
   type(field_spec_type), parameter :: fields(*) = [ &
      & field_spec_type('SPRING', 'first point', kind_point, '', 'body.point'), &
      & field_spec_type('SPRING', 'second point', kind_point, '', 'body.point'), &
      & field_spec_type('SPRING', 'tension', kind_spring_law, 'N, N m', &
      &    'added: expression of the elongation x, its rate v, the time t, quantities', .true.)]
   !> An example, as it stands in a deck of the tests
   character(*), parameter :: example(*) = [character(110) :: &
      & '*SPRING, NAME=rope, STIFFNESS=2e4, LENGTH=0.6, DAMPING=50', &
      & ' load, boom.hook']

   type, extends(element_type) :: spring_element_type
   contains
      procedure :: read
      procedure :: act
      procedure :: hold
   end type spring_element_type

contains

   type(spring_element_type) function spring_element() result(element)
      element%rows = keyword_rows_type(keyword, options, fields, [word_spec_type ::], example)
   end function spring_element

   !> Adds a spring or damper between two points, or a rotational one between two sections.
   subroutine read(self, deck, index, model, diagnostics)
      class(spring_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: index
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      type(load_part_type) :: part
      integer :: points(2)
      logical :: turning, linear
      associate (block => deck%blocks(index))
         turning = block%word('TYPE') == 'ROTATIONAL'
         if (size(block%lines) /= 1) return
         call find_pair(block, model, points, diagnostics)
         if (any(points == 0)) return
         linear = block%lines(1)%count() < 3
         if (linear .and. .not. (block%given('STIFFNESS') .or. block%given('DAMPING'))) call diagnostics%add(block%origin, &
            & "spring '"//block%name()//"' does nothing", &
            & 'give STIFFNESS or DAMPING, or an expression of x, v and t behind the points')
         call check_pair(block, model, points, turning, diagnostics)
         if (turning) then
            part = new_part(along_angle, points(2), points(1))
         else
            part = new_part(along_distance, points(1), points(2))
         end if
         part%origin = block%real('LENGTH')
         if (turning) part%origin = block%real('ANGLE')
         part%stiffness = block%real('STIFFNESS')
         part%damping = block%real('DAMPING')
         if (.not. linear) call set_law(part, block%lines(1)%fields(3)%expression, -1.0_wp)
         call append_part(model, part)
         call name_load(model, block%name(), size(model%load_parts))
         call describe_load(model, stretches=.true., angular=turning, symbol=trim(merge('      ', 'SPRING', turning)))
      end associate
   end subroutine read

   !> Both points, or both sections.
   subroutine act(self, deck, block, body, points)
      class(spring_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      type(acting_type), allocatable, intent(inout) :: points(:)
      logical :: couple
      couple = block%word('TYPE') == 'ROTATIONAL'
      call enter_pair(block, body, .not. couple, couple, points)
   end subroutine act

   !> The stiffness of a rotational spring at a section.
   subroutine hold(self, deck, block, body, holds)
      class(spring_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      type(hold_type), allocatable, intent(inout) :: holds(:)
      type(hold_type) :: new
      if (block%word('TYPE') == 'ROTATIONAL') new%turning = block%real('STIFFNESS')
      call note_pair(block, body, new, holds)
   end subroutine hold

   !> Reports a spring between two points or sections that nothing moves against each other.
   subroutine check_pair(block, model, points, turning, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(in) :: model
      integer, intent(in) :: points(2)
      logical, intent(in) :: turning
      type(diagnostics_type), intent(inout) :: diagnostics
      if (turning) call check_turning(block, model, points, diagnostics)
      if (turning) then
         if (turn_alike(model, points)) call diagnostics%add(block%lines(1)%origin_of(2), "spring '"//block%name()// &
            & "' turns a body against itself", 'name points of two different bodies')
      else if (keep_distance(model, points)) then
         call diagnostics%add(block%lines(1)%origin_of(2), "spring '"//block%name()// &
            & "' pulls at two points whose distance never changes", 'name points of two different bodies')
      end if
   end subroutine check_pair

end module limber_elements_spring
