!> One-sided stops: end of travel, joint limits, walls, ropes that go slack: *STOP, springs or rigid. Floor: elements. Source:
!> doc/theory, sections 3.9 and 5.22.
module limber_elements_stop
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_deck_compile, only: compile
   use limber_deck_content, only: deck_type, block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_expression, only: expression_type
   use limber_deck_parameters, only: parameter_list_type
   use limber_deck_schema, only: keyword_type, option_spec_type, field_spec_type, word_spec_type, keyword_rows_type, many, needed, &
      & kind_name, kind_reference, kind_real, kind_positive, kind_nonnegative, kind_word, kind_point, form_fields
   use limber_model_rigid_stops, only: append_contact
   use limber_model_element, only: element_type
   use limber_model_joint_coordinates, only: free_motion
   use limber_model_joint_list, only: find_joint
   use limber_model_load_parts, only: new_part, set_law, append_part, name_load, describe_load, find_pair
   use limber_model_model, only: model_type, load_part_type, along_angle, along_distance, along_slide
   use limber_model_points_of_action, only: acting_type, enter_pair, along_joint
   implicit none
   private
   public :: stop_element_type, stop_element

   type(keyword_type), parameter :: keyword = &
      & keyword_type('STOP', many, form_fields, 0, 1, &
      &    'A one-sided stop, spring or rigid: acts at a limit of a joint, of a distance, or of a place beside a wall')
   !> Options: kind, values, unit, default, meaning
   type(option_spec_type), parameter :: options(*) = [ &
      & option_spec_type('STOP', 'NAME', kind_name, 'joints, drivers and loads', '', needed, 'name of the stop'), &
      & option_spec_type('STOP', 'JOINT', kind_reference, 'JOINT', '', '', &
      &    'REVOLUTE: limits of joint_angle, turns counted; POINT ON LINE, TRANSLATIONAL: limits of displacement'), &
      & option_spec_type('STOP', 'LEAST', kind_real, '', 'm, rad', '', &
      & 'limit below which it pushes, tension < 0; this or MOST, or both'), &
      & option_spec_type('STOP', 'MOST', kind_real, '', 'm, rad', '', &
      & 'limit above which it pulls, tension > 0: a rope that goes slack; elongation counts from LEAST, else from MOST'), &
      & option_spec_type('STOP', 'AXIS', kind_real, '', 'rad', '', &
      &    'the limits are those of the place of the first point along this axis in the section at the second: a wall'), &
      & option_spec_type('STOP', 'LAW', kind_word, 'SPRING|RIGID', '', 'SPRING', &
      &    'SPRING: a force beyond the limit; RIGID: the limit is never passed'), &
      & option_spec_type('STOP', 'RESTITUTION', kind_nonnegative, '', '', '0', &
      &    'RIGID: speed behind an impact over that before it, 0 to 1', only='LAW=RIGID'), &
      & option_spec_type('STOP', 'STIFFNESS', kind_positive, '', 'N/m, N m/rad', '', &
      &    'SPRING, needed: force for each unit beyond the limit; with EXPONENT for each unit to this power', &
      &    only='LAW=SPRING'), &
      & option_spec_type('STOP', 'EXPONENT', kind_positive, '', '', '1', &
      &    'power of the depth beyond the limit, 1 at least; 1.5: balls, cylinders (Hertz)', only='LAW=SPRING'), &
      & option_spec_type('STOP', 'DAMPING', kind_nonnegative, '', 's/m, s/rad', '0', &
      &    'grows the force by this part per speed into the stop (Hunt and Crossley); its energy then counts as work', &
      &    only='LAW=SPRING')]
   !> Fields of its data lines
   type(field_spec_type), parameter :: fields(*) = [ &
      & field_spec_type('STOP', 'first point', kind_point, '', &
      & 'body.point: the distance of the points has the limits, or the place with AXIS'), &
      & field_spec_type('STOP', 'second point', kind_point, '', 'body.point')]
   !> Words that LAW takes
   type(word_spec_type), parameter :: words(*) = [ &
      & word_spec_type('STOP', 'SPRING', 'STIFFNESS, EXPONENT and DAMPING give the force beyond the limit; it gives way'), &
      & word_spec_type('STOP', 'RIGID', 'in *DYNAMICS: impacts with RESTITUTION at the touches, which are rows of /events of ' &
      &    //'the results; behind its bounces the contact rests while it pushes, and opens when it would pull')]
   !> An example, as it stands in a deck of the tests
   character(*), parameter :: example(*) = [character(110) :: &
      & '*STOP, NAME=buffer, JOINT=left-guide, LEAST=-2, MOST=5, STIFFNESS=2e5, DAMPING=0.3']

   type, extends(element_type) :: stop_element_type
   contains
      procedure :: read
      procedure :: act
   end type stop_element_type

contains

   type(stop_element_type) function stop_element() result(element)
      element%rows = keyword_rows_type(keyword, options, fields, words, example)
      element%round = 2
   end function stop_element

   !> Adds one part, along the distance of the points or the coordinate of the joint.
   subroutine read(self, deck, index, model, diagnostics)
      class(stop_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: index
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      type(load_part_type) :: part
      type(expression_type) :: law
      integer :: before
      before = diagnostics%count
      associate (block => deck%blocks(index))
         call check_limits(block, diagnostics)
         call check_law(block, diagnostics)
         call find_scalar(block, model, part, diagnostics)
         if (diagnostics%count > before) return
         part%origin = origin(block)
         if (.not. is_rigid(block)) then
            call write_law(block, law, diagnostics)
            call set_law(part, law, 1.0_wp)
         end if
         call append_part(model, part)
         call name_load(model, block%name(), size(model%load_parts))
         call describe_load(model, stretches=.true., angular=part%along == along_angle, from_second=.true.)
         if (is_rigid(block)) call add_contacts(block, index, model)
      end associate
   end subroutine read

   !> Whether the limits are never passed.
   logical function is_rigid(block)
      type(block_type), intent(in) :: block
      is_rigid = block%word('LAW') == 'RIGID'
   end function is_rigid

   !> A contact at each limit.
   subroutine add_contacts(block, index, model)
      type(block_type), intent(in) :: block
      !> Index of the block
      integer, intent(in) :: index
      type(model_type), intent(inout) :: model
      logical :: both
      both = block%given('LEAST') .and. block%given('MOST')
      if (block%given('LEAST')) call append_contact(model, index, block%name()//trim(merge(' least', '      ', both)), 1, &
         & block%real('LEAST'), block%real('RESTITUTION'))
      if (block%given('MOST')) call append_contact(model, index, block%name()//trim(merge(' most', '     ', both)), -1, &
         & block%real('MOST'), block%real('RESTITUTION'))
   end subroutine add_contacts

   !> Reports what the law needs and cannot have.
   subroutine check_law(block, diagnostics)
      type(block_type), intent(in) :: block
      type(diagnostics_type), intent(inout) :: diagnostics
      character(*), parameter :: of_switches(*) = [character(8) :: 'ACTIVE', 'INACTIVE']
      integer :: i
      if (.not. is_rigid(block)) then
         if (.not. block%has('STIFFNESS')) call diagnostics%add(block%origin, "stop '"//block%name()//"' has no STIFFNESS", &
            & 'add STIFFNESS=, or LAW=RIGID')
         return
      end if
      do i = 1, size(of_switches)
         if (block%has(trim(of_switches(i)))) call diagnostics%add(block%origin_of(trim(of_switches(i))), "stop '"// &
            & block%name()//"' is rigid: no switch turns it off", 'remove '//trim(of_switches(i))//', or give a STIFFNESS'// &
            & ' instead of LAW=RIGID')
      end do
      if (block%real('RESTITUTION') > 1.0_wp) call diagnostics%add(block%origin_of('RESTITUTION'), 'RESTITUTION='// &
         & as_text(block%real('RESTITUTION'))//' makes each impact gain energy', 'give a number from 0 to 1')
      if (.not. (block%given('LEAST') .and. block%given('MOST'))) return
      if (.not. abs(block%real('MOST') - block%real('LEAST')) > 0.0_wp) call diagnostics%add(block%origin_of('MOST'), &
         & "stop '"//block%name()//"' is rigid and leaves no way between its limits", 'let MOST be above LEAST')
   end subroutine check_law

   !> Reports a stop without limits, and limits in the wrong order.
   subroutine check_limits(block, diagnostics)
      type(block_type), intent(in) :: block
      type(diagnostics_type), intent(inout) :: diagnostics
      if (.not. block%given('LEAST') .and. .not. block%given('MOST')) then
         call diagnostics%add(block%origin, "stop '"//block%name()//"' has no limit", 'add LEAST= or MOST=')
      else if (block%given('LEAST') .and. block%given('MOST') .and. block%real('LEAST') > block%real('MOST')) then
         call diagnostics%add(block%origin_of('LEAST'), "stop '"//block%name()//"': LEAST is above MOST", 'exchange them')
      end if
      if (block%given('AXIS') .and. block%has('JOINT')) call diagnostics%add(block%origin_of('AXIS'), "stop '"//block%name()// &
         & "': a joint has its own axis", 'remove AXIS, or JOINT')
      if (block%real('EXPONENT') < 1.0_wp) call diagnostics%add(block%origin_of('EXPONENT'), 'EXPONENT='// &
         & as_text(block%real('EXPONENT'))//' makes the stop infinitely stiff at the touch', 'give 1 or more')
   end subroutine check_limits

   !> Finds the scalar that has the limits: the distance of two points, or the coordinate of a joint.
   subroutine find_scalar(block, model, part, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(in) :: model
      type(load_part_type), intent(out) :: part
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: points(2), i
      logical :: found
      if (block%has('JOINT') .eqv. size(block%lines) == 1) then
         call diagnostics%add(block%origin, "stop '"//block%name()//"' needs JOINT or two points, one of them", &
            & 'add JOINT=, or a data line: first point, second point')
      else if (block%has('JOINT')) then
         i = find_joint(model, block%name('JOINT'))
         if (i == 0) return
         associate (joint => model%joints(i))
            call free_motion(joint, part, found)
            if (.not. found) call diagnostics%add(block%origin_of('JOINT'), "there is no stop in joint '"//joint%name//"'", &
               & 'it is for joints of the types REVOLUTE, TRANSLATIONAL and POINT ON LINE', object=block%name('JOINT'))
         end associate
      else
         call find_pair(block, model, points, diagnostics)
         if (any(points == 0)) return
         part = new_part(merge(along_slide, along_distance, block%given('AXIS')), points(1), points(2))
         if (block%given('AXIS')) part%angle = block%real('AXIS')
         if (.not. block%given('AXIS')) call check_distance(block, diagnostics)
         if (model%points(points(1))%body == model%points(points(2))%body) call diagnostics%add(block%lines(1)%origin_of(2), &
            & "stop '"//block%name()//"' acts between two points of one body", 'name points of two different bodies')
      end if
   end subroutine find_scalar

   !> Reports limits that a distance is never below.
   subroutine check_distance(block, diagnostics)
      type(block_type), intent(in) :: block
      type(diagnostics_type), intent(inout) :: diagnostics
      character(*), parameter :: limits(2) = [character(5) :: 'LEAST', 'MOST']
      integer :: i
      do i = 1, 2
         if (.not. block%given(trim(limits(i)))) cycle
         if (block%real(trim(limits(i))) > 0.0_wp .or. (i == 2 .and. block%real('MOST') >= 0.0_wp)) cycle
         call diagnostics%add(block%origin_of(trim(limits(i))), "stop '"//block%name()//"': a distance is never below "// &
            & as_text(block%real(trim(limits(i)))), 'give a length, or AXIS= for a place along a line')
      end do
   end subroutine check_distance

   !> The limit from which its elongation and its energy are counted: LEAST if there is one, else MOST.
   pure real(wp) function origin(block)
      type(block_type), intent(in) :: block
      origin = block%real(trim(merge('LEAST', 'MOST ', block%given('LEAST'))))
   end function origin

   !> The force along the scalar, by its elongation x from the first limit and its rate v: zero between the limits, and never
   !> towards the stop.
   subroutine write_law(block, law, diagnostics)
      type(block_type), intent(in) :: block
      type(expression_type), intent(out) :: law
      type(diagnostics_type), intent(inout) :: diagnostics
      type(parameter_list_type) :: none
      character(:), allocatable :: text
      logical :: ok
      text = ''
      if (block%given('LEAST')) text = side('1', '-x', '-')
      if (block%given('MOST')) text = text//side('-1', 'x - ('//as_text(block%real('MOST') - origin(block))//')', '+')
      call compile(text, block%origin, none, law, ok, diagnostics, time=.true., variables=['x', 'v'])

   contains

      !> Force at one limit: its direction, depth beyond the limit, sign of the speed into the stop.
      function side(direction, depth, sign)
         character(*), intent(in) :: direction, depth, sign
         character(:), allocatable :: side
         side = '+('//direction//')*'//as_text(block%real('STIFFNESS'))//'*max(0, '//depth//')'
         if (block%real('EXPONENT') > 1.0_wp) side = side//'**'//as_text(block%real('EXPONENT'))
         if (block%real('DAMPING') > 0.0_wp) side = side//'*max(0, 1 '//sign//' '//as_text(block%real('DAMPING'))//'*v)'
      end function side

   end subroutine write_law

   !> The points of its joint, or both points.
   subroutine act(self, deck, block, body, points)
      class(stop_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      type(acting_type), allocatable, intent(inout) :: points(:)
      if (block%has('JOINT')) call along_joint(deck, block%name('JOINT'), body, points)
      call enter_pair(block, body, .true., .false., points)
   end subroutine act

end module limber_elements_stop
