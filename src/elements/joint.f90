!> Joints of two points: *JOINT. What the kinds have in common; each kind is a file beside this one. Floor: elements. Source:
!> doc/theory, part 3.
module limber_elements_joint
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_deck_content, only: deck_type, block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_keywords, only: split_values
   use limber_deck_schema, only: keyword_type, option_spec_type, field_spec_type, word_spec_type, keyword_rows_type, many, needed, &
      & kind_name, kind_word, kind_real, kind_point, form_fields
   use limber_model_curve, only: curve_type
   use limber_model_curve_block, only: read_curve
   use limber_model_element, only: element_type
   use limber_model_element_effects, only: is_alone
   use limber_model_held_ends, only: hold_type, note
   use limber_model_joint_kind, only: joint_kind_type, joint_kinds, joint_kind, describe_joint
   use limber_model_joint_list, only: new_joint
   use limber_model_model, only: model_type, joint_type, ground, place_on_line, place_on_curve, place_on_beam, place_rolling
   use limber_model_points, only: find_point
   use limber_model_points_of_action, only: acting_type, enter, has_pair, body_of, point_of, line_angle, nearly
   implicit none
   private
   public :: joint_element_type, joint_element

   type(keyword_type), parameter :: keyword = &
      & keyword_type('JOINT', many, form_fields, 1, 1, 'A joint of two points')
   !> Options of all kinds; TYPE is made of their words
   type(option_spec_type), parameter :: name_option = option_spec_type('JOINT', 'NAME', kind_name, 'joints, drivers and loads', &
      & '', &
      & needed, 'name of the joint')
   type(option_spec_type), parameter :: options(*) = [ &
      & option_spec_type('JOINT', 'ANGLE', kind_real, '', &
      &    'rad', '0', 'POINT ON LINE, TRANSLATIONAL, RACK, POINT ON CURVE: direction of the (x) axis in the second section', &
      &    only='TYPE=POINT ON LINE|TRANSLATIONAL|RACK|POINT ON CURVE'), &
      & option_spec_type('JOINT', 'TURN', kind_real, '', &
      &    'rad', '', 'TRANSLATIONAL, WELD: angle of the first section from the second; if not given, as guessed', &
      &    only='TYPE=TRANSLATIONAL|WELD')]
   !> Fields of its data lines
   type(field_spec_type), parameter :: fields(*) = [ &
      & field_spec_type('JOINT', 'first point', kind_point, '', 'body.point'), &
      & field_spec_type('JOINT', 'second point', kind_point, '', 'body.point')]
   !> An example, as it stands in a deck of the tests
   character(*), parameter :: example(*) = [character(110) :: &
      & '*JOINT, NAME=slider-pin, TYPE=REVOLUTE', &
      & ' rod.end, slider', &
      & '*JOINT, NAME=guide, TYPE=POINT ON LINE', &
      & ' slider, ground.origin']

   type, extends(element_type) :: joint_element_type
   contains
      procedure :: read
      procedure :: act
      procedure :: hold
      procedure :: tie
   end type joint_element_type

contains

   !> Its rows are those of the keyword and of all kinds.
   type(joint_element_type) function joint_element() result(element)
      type(word_spec_type) :: words(size(joint_kinds))
      character(112) :: types
      integer :: i
      types = ''
      do i = 1, size(joint_kinds)
         associate (kind => joint_kinds(i)%item)
            words(i) = word_spec_type('JOINT', kind%word, kind%meaning)
            types = trim(types)//'|'//kind%word
         end associate
      end do
      element%rows = keyword_rows_type(keyword, [name_option, option_spec_type('JOINT', 'TYPE', kind_word, types(2:), '', needed, &
         & 'what the joint is: see the list below'), options, (joint_kinds(i)%item%options, i=1, size(joint_kinds))], fields, &
         & words, example)
      element%joins = .true.
   end function joint_element

   !> Adds a joint between two points.
   subroutine read(self, deck, index, model, diagnostics)
      class(joint_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: index
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: points(2), i, bodies(2), before, joint
      before = diagnostics%count
      associate (block => deck%blocks(index))
         if (size(block%lines) /= 1) return
         do i = 1, 2
            points(i) = find_point(model, block%lines(1)%text(i), block%lines(1)%origin_of(i), diagnostics)
         end do
         if (any(points == 0)) return
         bodies = [model%points(points(1))%body, model%points(points(2))%body]
         if (bodies(1) == bodies(2)) then
            call diagnostics%add(block%lines(1)%origin_of(2), "joint '"//block%name()//"' joins a body to itself", &
               & 'name points of two different bodies')
            return
         end if
         joint = new_joint(model, block%name())
         model%joints(joint)%points = points
         associate (kind => joint_kinds(joint_kind(block%word('TYPE')))%item)
            call read_sizes(block, kind, model%joints(joint), diagnostics)
            if (diagnostics%count > before) return
            call kind%check(block, model, bodies, diagnostics)
            call check_guess(block, model, kind, model%joints(joint), diagnostics)
         end associate
         if (diagnostics%count == before .and. model%joints(joint)%place == place_on_curve) &
            & call find_curve(deck, block, model%joints(joint)%curve, diagnostics)
      end associate
   end subroutine read

   !> Reads the sizes of a joint and writes its equations. Reports options that the kind needs and the deck does not give.
   subroutine read_sizes(block, kind, joint, diagnostics)
      type(block_type), intent(in) :: block
      class(joint_kind_type), intent(in) :: kind
      type(joint_type), intent(inout) :: joint
      type(diagnostics_type), intent(inout) :: diagnostics
      character(len(kind%needs)), allocatable :: needs(:)
      character(:), allocatable :: missing
      integer :: i
      joint%angle = block%real('ANGLE')
      joint%turn = block%real('TURN')
      joint%has_turn = block%given('TURN')
      call kind%read(block, joint, diagnostics)
      call describe_joint(kind%word, joint)
      allocate (needs, source=split_values(kind%needs))
      missing = ''
      do i = 1, size(needs)
         if (needs(i) == '') cycle
         if (.not. block%has(trim(needs(i)))) missing = missing//', '//trim(needs(i))
      end do
      if (missing /= '') call diagnostics%add(block%origin, "joint '"//block%name()//"' of TYPE="//block%word('TYPE')// &
         & ' needs '//missing(3:), 'add '//missing(3:index(missing(3:)//',', ',') + 1)//'=')
   end subroutine read_sizes

   !> Reports initial guesses that a joint cannot start from, and warns of doubtful ones.
   subroutine check_guess(block, model, kind, joint, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(in) :: model
      class(joint_kind_type), intent(in) :: kind
      type(joint_type), intent(in) :: joint
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp) :: turn
      if (kind%apart) then
         if (norm2(guess_of(model, joint%points(1)) - guess_of(model, joint%points(2))) > 1.0e-9_wp*model%length) return
         call diagnostics%add(block%lines(1)%origin_of(2), "the two points of joint '"//block%name()// &
            & "' are in one place in the first guess", 'give better guesses (X=, Y=, ANGLE=) for its bodies')
      else if (joint%keeps_angle .and. joint%has_turn) then
         turn = guessed_turn(model, joint%points(1)) - guessed_turn(model, joint%points(2)) - joint%turn
         if (cos(turn) < 0.0_wp) call diagnostics%warn(block%origin_of('TURN'), "the bodies of joint '"//block%name()// &
            & "' are guessed more than a right angle away from TURN", &
            & 'it may be assembled the other way round; give ANGLE= for them')
      end if
   end subroutine check_guess

   !> Guessed angle of the axes of a point [rad]; 0 for the ground.
   pure real(wp) function guessed_turn(model, point) result(angle)
      type(model_type), intent(in) :: model
      integer, intent(in) :: point
      angle = 0.0_wp
      if (model%points(point)%body /= ground) angle = model%bodies(model%points(point)%body)%angle - model%points(point)%lean
   end function guessed_turn

   !> Guessed position of a point (2) [length].
   pure function guess_of(model, point) result(place)
      type(model_type), intent(in) :: model
      integer, intent(in) :: point
      real(wp) :: place(2)
      associate (own => model%points(point))
         place = own%p0
         if (own%body == ground) return
         associate (body => model%bodies(own%body))
            place = body%position + [cos(body%angle)*own%p0(1) - sin(body%angle)*own%p0(2), &
               & sin(body%angle)*own%p0(1) + cos(body%angle)*own%p0(2)]
         end associate
      end associate
   end function guess_of

   !> Makes the curve of a joint from its *CURVE.
   subroutine find_curve(deck, block, curve, diagnostics)
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      type(curve_type), intent(inout) :: curve
      type(diagnostics_type), intent(inout) :: diagnostics
      type(diagnostics_type) :: told
      integer :: from
      from = deck%find_named('CURVE', block%name('CURVE'))
      if (from == 0) return
      call read_curve(deck%blocks(from), curve, told)
      ! Its errors stand at the *CURVE
      if (told%count > 0) call diagnostics%follow()
   end subroutine find_curve

   !> Both points; the force of a sliding point acts anywhere along the beam.
   subroutine act(self, deck, block, body, points)
      class(joint_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      type(acting_type), allocatable, intent(inout) :: points(:)
      logical :: couple(2), held
      if (.not. has_pair(block)) return
      associate (kind => joint_kinds(joint_kind(block%word('TYPE')))%item)
         couple = kind%keeps_angle .or. kind%place == place_rolling
         couple(2) = couple(2) .or. kind%place == place_on_line .or. kind%place == place_on_curve
         held = .not. any(kind%place == [place_rolling, place_on_beam])
         call enter(block%lines(1)%text(1), body, .true., couple(1), points, held, kind%keeps_angle)
         if (kind%place == place_on_beam) return
         call enter(block%lines(1)%text(2), body, .true., couple(2), points, held, kind%keeps_angle)
      end associate
   end subroutine act

   !> The support of a body by the other body, or that body if it hangs there alone.
   subroutine hold(self, deck, block, body, holds)
      class(joint_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      type(hold_type), allocatable, intent(inout) :: holds(:)
      integer :: k
      if (.not. has_pair(block)) return
      do k = 1, 2
         if (body_of(block%lines(1)%text(k)) == body) call hold_side(deck, block, k, holds)
      end do
   end subroutine hold

   !> Adds the support of one side of a joint, or the body that hangs there.
   subroutine hold_side(deck, block, side, holds)
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      integer, intent(in) :: side
      type(hold_type), allocatable, intent(inout) :: holds(:)
      type(hold_type) :: new
      integer :: kind, other
      kind = joint_kind(block%word('TYPE'))
      if (joint_kinds(kind)%item%place == place_on_beam) return
      new%name = point_of(block%lines(1)%text(side))
      other = deck%find_named('RIGID BODY|BEAM|FRAME|POINT MASS', trim(body_of(block%lines(1)%text(3 - side))))
      if (other > 0) new%hangs = is_alone(deck, deck%blocks(other)%name(), body_of(block%lines(1)%text(side)))
      new%held = joint_kinds(kind)%item%place /= place_rolling
      ! A line fixes the direction across itself
      if (joint_kinds(kind)%item%place == place_on_line) then
         associate (angle => line_angle(deck, block, body_of(block%lines(1)%text(side))))
            new%held = abs([sin(angle), cos(angle)]) > nearly
         end associate
      end if
      new%clamped = joint_kinds(kind)%item%clamps(side)
      if (new%hangs) then
         if (any(deck%blocks(other)%keyword == [character(10) :: 'RIGID BODY', 'POINT MASS'])) &
            & new%mass = deck%blocks(other)%real('MASS')
      end if
      call note(new, holds)
   end subroutine hold_side

   !> Both points, unless the joint leaves the direction of the axis free: wheels do, and a line along this axis.
   subroutine tie(self, deck, block, body, names, tied)
      class(joint_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      character(64), intent(inout) :: names(2)
      logical, intent(out) :: tied
      tied = has_pair(block)
      if (.not. tied) return
      select case (joint_kinds(joint_kind(block%word('TYPE')))%item%place)
      case (place_rolling, place_on_beam)
         tied = .false.
      case (place_on_line)
         tied = abs(sin(line_angle(deck, block, body))) > nearly
      end select
      names = [character(64) :: block%lines(1)%text(1), block%lines(1)%text(2)]
   end subroutine tie

end module limber_elements_joint
