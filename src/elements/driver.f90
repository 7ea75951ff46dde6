!> Motions of one coordinate as functions of time: *DRIVER. Floor: elements. Source: doc/theory, eqs. (3.6), (3.28), (3.29).
module limber_elements_driver
   use limber_base_kinds, only: wp
   use limber_deck_content, only: deck_type, block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_schema, only: keyword_type, option_spec_type, field_spec_type, word_spec_type, keyword_rows_type, many, needed, &
      & kind_name, kind_word, kind_reference, kind_point, kind_real, kind_time_expression, form_fields
   use limber_model_beam_segments, only: find_frame
   use limber_model_driver_list, only: append_driver
   use limber_model_element, only: element_type
   use limber_model_held_ends, only: hold_type, note
   use limber_model_joint_coordinates, only: check_coordinate
   use limber_model_joint_list, only: find_joint, warn_along
   use limber_model_law_breaks, only: law_breaks, law_stations
   use limber_model_law_integrals, only: integrate
   use limber_model_model, only: model_type, driver_type, ground, driver_angle, driver_joint_angle, driver_distance, &
      & driver_displacement, driver_x, driver_y, coordinate_joint_angle, coordinate_displacement
   use limber_model_load_parts, only: keep_distance
   use limber_model_points, only: find_point
   use limber_model_points_of_action, only: acting_type, enter, along_joint, has_pair, body_of, point_of, first_angle, nearly
   implicit none
   private
   public :: driver_element_type, driver_element

   real(wp), parameter :: right_angle = acos(0.0_wp)
   type(keyword_type), parameter :: keyword = &
      & keyword_type('DRIVER', many, form_fields, 1, 1, &
      &    'A motion that is given as a function of time; turns of what it drives are those of the law')
   !> Options: kind, values, unit, default, meaning
   type(option_spec_type), parameter :: options(*) = [ &
      & option_spec_type('DRIVER', 'NAME', kind_name, 'joints, drivers and loads', '', needed, 'name of the driver'), &
      & option_spec_type('DRIVER', 'TYPE', kind_word, 'ANGLE|DISTANCE|DISPLACEMENT|X|Y', &
      &    '', needed, 'angle of BODY or JOINT, distance of POINT and TO, displacement of JOINT, x or y of POINT'), &
      & option_spec_type('DRIVER', 'BODY', kind_reference, 'RIGID BODY|BEAM|FRAME', '', '', &
      &    'ANGLE: body that is driven', only='TYPE=ANGLE'), &
      & option_spec_type('DRIVER', 'JOINT', kind_reference, 'JOINT', &
      &    '', '', 'ANGLE, DISPLACEMENT: joint whose joint_angle or displacement is driven', &
      &    only='TYPE=ANGLE|DISPLACEMENT'), &
      & option_spec_type('DRIVER', 'POINT', kind_point, '', '', '', 'X, Y, DISTANCE: point that is driven', &
      &    only='TYPE=X|Y|DISTANCE'), &
      & option_spec_type('DRIVER', 'TO', kind_point, '', '', '', 'DISTANCE: point that the distance is counted from', &
      &    only='TYPE=DISTANCE'), &
      & option_spec_type('DRIVER', 'LEVEL', kind_word, 'POSITION|VELOCITY|ACCELERATION', &
      &    '', 'POSITION', 'what the expression gives: the coordinate, its rate, or its second rate'), &
      & option_spec_type('DRIVER', 'INITIAL', kind_real, '', &
      &    'rad, m', '', 'VELOCITY, ACCELERATION: the coordinate at first; if not given, as guessed', &
      &    only='LEVEL=VELOCITY|ACCELERATION'), &
      & option_spec_type('DRIVER', 'INITIAL VELOCITY', kind_real, '', &
      &    'rad/s, m/s', '', 'ACCELERATION: the rate at first; if not given, 0', only='LEVEL=ACCELERATION')]
   !> Fields of its data lines
   type(field_spec_type), parameter :: fields(*) = [ &
      & field_spec_type('DRIVER', 'value', kind_time_expression, 'rad, m', &
      &    'expression of the time t; of an angle with all its turns, at each start too')]
   !> Words of TYPE
   type(word_spec_type), parameter :: words(*) = [ &
      & word_spec_type('DRIVER', 'ANGLE', &
      &    'angle of the frame of BODY, or joint_angle(JOINT)'), &
      & word_spec_type('DRIVER', 'DISTANCE', &
      &    'distance of POINT and TO, above 0'), &
      & word_spec_type('DRIVER', 'DISPLACEMENT', &
      &    'displacement(JOINT); of SLIDING the coordinate along the undeformed axis from the second point, so that the ' &
      &    //'force acts where the first point is, along the tangent there; laws of loads cannot use it'), &
      & word_spec_type('DRIVER', 'X', &
      &    'coordinate of POINT along the fixed x axis; Y: along the y axis')]
   !> An example, as it stands in a deck of the tests
   character(*), parameter :: example(*) = [character(110) :: &
      & '*DRIVER, NAME=motor, TYPE=ANGLE, JOINT=motor-shaft, LEVEL=VELOCITY', &
      & ' speed*cycloidal(5*t)']

   type, extends(element_type) :: driver_element_type
   contains
      procedure :: read
      procedure :: act
      procedure :: hold
      procedure :: tie
      procedure :: turns
      procedure :: drives
   end type driver_element_type

contains

   type(driver_element_type) function driver_element() result(element)
      element%rows = keyword_rows_type(keyword, options, fields, words, example)
      element%round = 2
   end function driver_element

   !> Adds a driver.
   subroutine read(self, deck, index, model, diagnostics)
      class(driver_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: index
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      type(driver_type) :: driver
      integer :: before
      before = diagnostics%count
      associate (block => deck%blocks(index))
         if (size(block%lines) /= 1) return
         driver%name = block%name()
         call read_driven(block, model, driver%kind, driver%body, driver%joint, driver%points, diagnostics)
         driver%law = block%lines(1)%fields(1)%expression
         if (block%word('LEVEL') == 'VELOCITY') driver%level = 1
         if (block%word('LEVEL') == 'ACCELERATION') driver%level = 2
         driver%initial = [block%real('INITIAL'), block%real('INITIAL VELOCITY')]
         driver%has_initial = block%given('INITIAL')
         if (.not. driver%has_initial .and. driver%body > 0) driver%initial(1) = model%bodies(driver%body)%angle
      end associate
      if (diagnostics%count > before) return
      call prepare(model, driver)
      call append_driver(model, driver)
   end subroutine read

   !> Finds kind, body, joint and points of a driver.
   subroutine read_driven(block, model, kind, body, joint, points, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(in) :: model
      integer, intent(out) :: kind, body, joint, points(2)
      type(diagnostics_type), intent(inout) :: diagnostics
      logical :: ok
      body = 0
      joint = 0
      points = 0
      kind = driver_angle
      ok = .true.
      if (block%has('BODY')) then
         body = find_frame(model, block%name('BODY'), block%origin_of('BODY'), diagnostics)
         if (body == 0) return
      end if
      if (block%has('JOINT')) joint = find_joint(model, block%name('JOINT'))
      if (block%has('POINT')) then
         points(1) = find_point(model, block%text('POINT'), block%origin_of('POINT'), diagnostics)
         if (points(1) == 0) return
      end if
      if (block%has('TO')) then
         points(2) = find_point(model, block%text('TO'), block%origin_of('TO'), diagnostics)
         if (points(2) == 0) return
      end if
      select case (block%word('TYPE'))
      case ('ANGLE')
         if (joint > 0) kind = driver_joint_angle
         call need((joint > 0) .neqv. (body > 0), 'BODY or JOINT, one of the two')
         if (ok .and. joint > 0) call check_coordinate(model%joints(joint), coordinate_joint_angle, block%origin_of('JOINT'), &
            & diagnostics)
      case ('DISPLACEMENT')
         kind = driver_displacement
         call need(joint > 0, 'JOINT')
         if (ok) call check_coordinate(model%joints(joint), coordinate_displacement, block%origin_of('JOINT'), diagnostics)
         if (ok) call warn_along(model, joint, block%origin_of('JOINT'), diagnostics)
      case ('DISTANCE')
         kind = driver_distance
         call need(all(points > 0), 'POINT and TO')
      case ('X')
         kind = driver_x
         call need(points(1) > 0, 'POINT')
      case ('Y')
         kind = driver_y
         call need(points(1) > 0, 'POINT')
      end select
      if (.not. ok) return
      if (kind == driver_joint_angle .or. kind == driver_displacement) points = model%joints(joint)%points
      if (any(points > 0)) then
         if (all(model%points(pack(points, points > 0))%body == ground)) call diagnostics%add(block%origin, &
            & "driver '"//block%name()//"' drives a point of the ground", 'name a point of a body')
      end if
      if (kind == driver_distance) then
         if (any(model%points(points)%body /= ground) .and. keep_distance(model, points)) call diagnostics%add( &
            & block%origin_of('TO'), "driver '"//block%name()//"' drives a distance that never changes", &
            & 'name points of two different bodies')
      end if
      if (kind /= driver_distance .and. kind /= driver_x .and. kind /= driver_y) points = 0

   contains

      !> Reports missing options unless `given`.
      subroutine need(given, options)
         logical, intent(in) :: given
         character(*), intent(in) :: options
         ok = given
         if (.not. given) call diagnostics%add(block%origin, "driver '"//block%name()//"' of TYPE="//block%word('TYPE')// &
            & ' needs '//options, 'add it behind the keyword')
      end subroutine need

   end subroutine read_driven

   !> Integrates the law of a velocity or acceleration over the time of all analyses.
   subroutine prepare(model, driver)
      type(model_type), intent(in) :: model
      type(driver_type), intent(inout) :: driver
      real(wp), allocatable :: breaks(:)
      real(wp) :: start, end
      integer :: i
      if (driver%level == 0) return
      start = model%dynamics%start
      end = model%dynamics%end
      if (allocated(model%steps)) then
         do i = 1, size(model%steps)
            start = min(start, model%steps(i)%dynamics%start)
            end = max(end, model%steps(i)%dynamics%end)
         end do
      end if
      ! Without an analysis the first position is still needed
      if (.not. end > start) end = start + max(1.0_wp, abs(start))
      allocate (breaks(0))
      call law_breaks(driver%law, start, end, breaks)
      call law_stations(driver%law, start, end, breaks)
      driver%integral = integrate(driver%law, start, end, breaks)
   end subroutine prepare

   !> The driven points, and the origin of a body whose frame it drives.
   subroutine act(self, deck, block, body, points)
      class(driver_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      type(acting_type), allocatable, intent(inout) :: points(:)
      if (block%has('JOINT')) call along_joint(deck, block%name('JOINT'), body, points)
      if (block%has('POINT')) call enter(block%text('POINT'), body, .true., .false., points, .true.)
      if (block%has('TO')) call enter(block%text('TO'), body, .true., .false., points, .true.)
      if (block%has('BODY')) call enter(block%name('BODY'), body, .false., .true., points, .false., .true.)
   end subroutine act

   !> Adds the support by a driver: of a coordinate at its point, of an angle for the section, at both sides of a joint.
   subroutine hold(self, deck, block, body, holds)
      class(driver_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      type(hold_type), allocatable, intent(inout) :: holds(:)
      integer :: joint, k
      if (block%has('BODY')) then
         if (block%name('BODY') == body) call note(hold_type('origin', clamped=.true.), holds)
      end if
      if (block%has('POINT')) then
         if (body_of(block%text('POINT')) == body) call note(hold_type(point_of(block%text('POINT')), ways()), holds)
      end if
      if (block%has('TO')) then
         if (body_of(block%text('TO')) == body) call note(hold_type(point_of(block%text('TO')), [.true., .true.]), holds)
      end if
      if (.not. block%has('JOINT') .or. block%word('TYPE') /= 'ANGLE') return
      joint = deck%find_named('JOINT', block%name('JOINT'))
      if (joint == 0) return
      if (.not. has_pair(deck%blocks(joint))) return
      do k = 1, 2
         if (body_of(deck%blocks(joint)%lines(1)%text(k)) == body) &
            & call note(hold_type(point_of(deck%blocks(joint)%lines(1)%text(k)), clamped=.true.), holds)
      end do

   contains

      !> Fixed directions of a driver of x or y, by the angle of the body.
      function ways()
         logical :: ways(2)
         ways = .true.
         if (all(block%word('TYPE') /= [character(1) :: 'X', 'Y'])) return
         associate (angle => first_angle(deck, body))
            ways = abs([cos(angle), sin(angle)]) > nearly
            if (block%word('TYPE') == 'Y') ways = abs([sin(angle), cos(angle)]) > nearly
         end associate
      end function ways
   end subroutine hold

   !> A driven point and the other point, or the ground if the driver acts along the axis.
   subroutine tie(self, deck, block, body, names, tied)
      class(driver_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      character(64), intent(inout) :: names(2)
      logical, intent(out) :: tied
      tied = block%has('POINT')
      if (.not. tied) return
      names = [character(64) :: block%text('POINT'), 'ground.origin']
      if (block%has('TO')) then
         names(2) = block%text('TO')
      else
         tied = abs(sin(first_angle(deck, body) + merge(right_angle, 0.0_wp, block%word('TYPE') == 'X'))) > nearly
      end if
   end subroutine tie

   !> Whether it drives the frame of a body.
   pure logical function turns(self, block, body)
      class(driver_element_type), intent(in) :: self
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      turns = block%has('BODY')
      if (turns) turns = block%name('BODY') == body
   end function turns

   !> Whether it drives the frame of a body or a point of it.
   pure logical function drives(self, block, body)
      class(driver_element_type), intent(in) :: self
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      drives = self%turns(block, body)
      if (block%has('POINT')) drives = drives .or. body_of(block%text('POINT')) == body
      if (block%has('TO')) drives = drives .or. body_of(block%text('TO')) == body
   end function drives

end module limber_elements_driver
