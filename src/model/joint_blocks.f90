!> Joints, couplers and drivers of the deck, with all checks beyond its grammar. Floor: model.
module limber_model_joint_blocks
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_deck_content, only: deck_type, block_type, line_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_joint_kinds, only: joint_curve, joint_sliding, joint_gear, joint_rack, joint_belt, joint_coupler, &
      & joint_kinds, joint_kind, place_rolling
   use limber_deck_keywords, only: split_values
   use limber_deck_origin, only: origin_type
   use limber_model_law_breaks, only: law_breaks, law_stations
   use limber_model_curve, only: curve_type, spline_curve, expression_curve
   use limber_model_law_integrals, only: integrate
   use limber_model_lists, only: append
   use limber_model_points, only: find_point, find_named, enter_name
   use limber_model_beam_segments, only: find_frame
   use limber_model_model, only: model_type, joint_type, driver_type, term_type, body_point, body_flexible, ground, &
      & coordinate_angle, coordinate_joint_angle, coordinate_displacement, driver_angle, driver_joint_angle, &
      & driver_distance, driver_displacement, driver_x, driver_y
   implicit none
   private
   public :: add_joint, add_coupler, add_driver, most_bends

   !> Largest number of coordinates of a beam in a sliding joint
   integer, parameter :: most_bends = 24

contains

   !> Adds a joint between two points.
   subroutine add_joint(deck, index, model, diagnostics)
      type(deck_type), intent(in) :: deck
      !> Index of the block
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
         joint = new_joint(model, block)
         model%joints(joint)%points = points
         call read_sizes(block, model%joints(joint), diagnostics)
         call check_bodies(block, model, bodies, model%joints(joint)%kind, diagnostics)
         call check_guess(block, model, model%joints(joint), diagnostics)
         if (diagnostics%count == before .and. model%joints(joint)%kind == joint_curve) &
            & call find_curve(deck, block, model%joints(joint)%curve, diagnostics)
      end associate
   end subroutine add_joint

   !> Appends a joint with its name and kind; returns its index.
   integer function new_joint(model, block) result(index)
      type(model_type), intent(inout) :: model
      type(block_type), intent(in) :: block
      type(joint_type) :: empty
      empty%name = block%name()
      call append(model%joints, model%counts%joints, empty)
      index = model%counts%joints
      call enter_name(model, 'joint', empty%name, index)
      associate (joint => model%joints(index))
         joint%kind = joint_coupler
         if (block%keyword == 'COUPLER') return
         joint%kind = joint_kind(block%word('TYPE'))
         joint%angle = block%real('ANGLE')
      end associate
   end function new_joint

   !> Reads angles, lengths and radii. Reports options that the kind needs and the deck does not give.
   subroutine read_sizes(block, joint, diagnostics)
      type(block_type), intent(in) :: block
      type(joint_type), intent(inout) :: joint
      type(diagnostics_type), intent(inout) :: diagnostics
      character(len(joint_kinds%needs)), allocatable :: needs(:)
      integer :: i
      joint%turn = block%real('TURN')
      joint%has_turn = block%given('TURN')
      joint%length = block%real('LENGTH')
      joint%has_length = block%given('LENGTH')
      select case (joint%kind)
      case (joint_gear, joint_belt)
         joint%radius = [block%real('FIRST RADIUS'), block%real('SECOND RADIUS')]
         joint%same_direction = block%yes('INTERNAL')
         if (joint%kind == joint_belt) joint%same_direction = .not. block%yes('CROSSED')
      case (joint_rack)
         joint%radius(1) = block%real('RADIUS')
      case (joint_sliding)
         if (block%given('ANGLE')) call diagnostics%warn(block%origin_of('ANGLE'), 'ANGLE means nothing of a joint of'// &
            & ' TYPE=SLIDING: its point slides along the beam', 'remove it')
      end select
      allocate (needs, source=split_values(joint_kinds(joint%kind)%needs))
      do i = 1, size(needs)
         if (needs(i) == '') cycle
         if (.not. block%has(trim(needs(i)))) call diagnostics%add(block%origin, "joint '"//block%name()//"' of TYPE="// &
            & block%word('TYPE')//' needs '//trim(needs(i)), 'add '//trim(needs(i))//'=')
      end do
   end subroutine read_sizes

   !> Reports bodies that a kind of joint cannot connect.
   subroutine check_bodies(block, model, bodies, kind, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(in) :: model
      !> Indices of both bodies, or `ground`; kind of the joint
      integer, intent(in) :: bodies(2), kind
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: side
      if (joint_kinds(kind)%keeps_angle .or. joint_kinds(kind)%place == place_rolling) then
         do side = 1, 2
            if (bodies(side) == ground) cycle
            if (model%bodies(bodies(side))%kind == body_point) call diagnostics%add(block%lines(1)%origin_of(side), &
               & "joint '"//block%name()//"' needs a body that can turn, which a point mass cannot", &
               & 'make it a *RIGID BODY, or use REVOLUTE or POINT ON LINE')
         end do
      else if (kind == joint_sliding) then
         if (bodies(2) /= ground) then
            if (is_in_segments(bodies(2))) then
               call diagnostics%add(block%lines(1)%origin_of(2), "joint '"//block%name()//"' slides along a beam in segments", &
                  & 'leave out SEGMENTS: a point slides along an undivided beam only')
               return
            end if
            if (model%bodies(bodies(2))%kind == body_flexible .and. model%bodies(bodies(2))%end_point > 0) then
               if (model%bodies(bodies(2))%reduced%n > most_bends) call diagnostics%add(block%lines(1)%origin_of(2), &
                  & "the beam of joint '"//block%name()//"' has "//as_text(model%bodies(bodies(2))%reduced%n)//' coordinates', &
                  & 'a point slides along a beam with at most '//as_text(most_bends)//': functions of the angle and the strain,'// &
                  & ' one for each place between its ends where joints or loads act along it, and with SHEAR one for each of'// &
                  & ' the angle; use fewer FUNCTIONS')
               return
            end if
         end if
         call diagnostics%add(block%lines(1)%origin_of(2), "joint '"//block%name()//"' slides along something that is no "// &
            & 'flexible beam', 'name a *BEAM second; along what is straight, use POINT ON LINE')
      end if

   contains

      !> Whether a body is a piece of a beam. Members of a frame are whole beams.
      pure logical function is_in_segments(body)
         integer, intent(in) :: body
         is_in_segments = model%bodies(body)%whole > 0
         if (is_in_segments) is_in_segments = .not. allocated(model%wholes(model%bodies(body)%whole)%lean)
      end function is_in_segments

   end subroutine check_bodies

   !> Reports initial guesses that a joint cannot start from, and warns of doubtful ones.
   subroutine check_guess(block, model, joint, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(in) :: model
      type(joint_type), intent(in) :: joint
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp) :: turn
      if (joint_kinds(joint%kind)%apart) then
         if (norm2(guess_of(model, joint%points(1)) - guess_of(model, joint%points(2))) > 1.0e-9_wp*model%length) return
         call diagnostics%add(block%lines(1)%origin_of(2), "the two points of joint '"//block%name()// &
            & "' are in one place in the first guess", 'give better guesses (X=, Y=, ANGLE=) for its bodies')
      else if (joint_kinds(joint%kind)%keeps_angle .and. joint%has_turn) then
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
      real(wp), allocatable :: points(:, :)
      integer :: from, i, n
      from = deck%find_named('CURVE', block%name('CURVE'))
      if (from == 0) return
      associate (lines => deck%blocks(from)%lines)
         n = size(lines)
         if (n == 1) then
            if (size(lines(1)%fields) == 1) then
               curve = expression_curve(lines(1)%fields(1)%expression)
               return
            end if
         end if
         allocate (points(2, n))
         do i = 1, n
            if (size(lines(i)%fields) < 2 .or. .not. lines(i)%fields(1)%expression%is_constant()) then
               call diagnostics%add(lines(i)%origin, "curve '"//deck%blocks(from)%name()//"' has a line that is no point", &
                  & 'give points x, y; or one line alone with y as an expression of x')
               return
            end if
            points(1, i) = lines(i)%fields(1)%expression%constant_value()
            points(2, i) = lines(i)%fields(2)%value
            if (i > 1) then
               if (.not. norm2(points(:, i) - points(:, i - 1)) > 0.0_wp) then
                  call diagnostics%add(lines(i)%origin, 'this point is the one before it', 'remove one of the two')
                  return
               end if
            end if
         end do
         if (n < 3) then
            call diagnostics%add(deck%blocks(from)%origin, "curve '"//deck%blocks(from)%name()//"' has "//as_text(n)//' points', &
               & 'give at least three')
            return
         end if
         ! A closed curve may repeat its first point
         if (deck%blocks(from)%yes('CLOSED') .and. norm2(points(:, n) - points(:, 1)) <= 1.0e-12_wp*maxval(abs(points))) n = n - 1
         curve = spline_curve(points(:, :n), deck%blocks(from)%yes('CLOSED'))
      end associate
   end subroutine find_curve

   !> Adds a coupler, a linear relation of joint coordinates. All joints must be in the model.
   subroutine add_coupler(block, model, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      type(term_type) :: term
      integer :: i, joint, before
      before = diagnostics%count
      joint = new_joint(model, block)
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
         if (term%of > 0) model%joints(joint)%terms = [model%joints(joint)%terms, term]
      end do
      if (diagnostics%count > before) return
      if (size(model%joints(joint)%terms) == 0) call diagnostics%add(block%origin, "coupler '"//block%name()// &
         & "' has no joint coordinate", 'add a line: coefficient, angle, body')
   end subroutine add_coupler

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
         if (term%of > 0 .and. term%kind == coordinate_displacement) &
            & call check_along(model, term%of, line%origin_of(3), diagnostics)
      end if
   end subroutine read_term

   !> Warns of a driver or coupler along a beam that is not exact: the section forces of such beams omit its force.
   subroutine check_along(model, joint, origin, diagnostics)
      type(model_type), intent(in) :: model
      !> Index of the joint
      integer, intent(in) :: joint
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      if (model%joints(joint)%kind /= joint_sliding) return
      associate (beam => model%bodies(model%points(model%joints(joint)%points(2))%body))
         if (.not. beam%reduced%is_exact) call diagnostics%warn(origin, "axial forces of '"//beam%name//"' lack the force "// &
            & "along it at joint '"//model%joints(joint)%name//"'", 'leave out GEOMETRIC and modes: an EXACT beam has them')
      end associate
   end subroutine check_along

   !> Index of a joint between two points by name; 0 if there is none.
   pure integer function find_joint(model, name) result(found)
      type(model_type), intent(in) :: model
      character(*), intent(in) :: name
      found = find_named(model, 'joint', name)
      if (found == 0) return
      if (model%joints(found)%kind == joint_coupler) found = 0
   end function find_joint

   !> Adds a driver. All joints must be in the model.
   subroutine add_driver(block, model, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      type(driver_type), allocatable :: longer(:)
      integer :: index, before
      before = diagnostics%count
      if (size(block%lines) /= 1) return
      index = size(model%drivers) + 1
      allocate (longer(index))
      longer(:index - 1) = model%drivers
      call move_alloc(longer, model%drivers)
      associate (driver => model%drivers(index))
         driver%name = block%name()
         call read_driven(block, model, driver%kind, driver%body, driver%joint, driver%points, diagnostics)
         driver%law = block%lines(1)%fields(1)%expression
         if (block%word('LEVEL') == 'VELOCITY') driver%level = 1
         if (block%word('LEVEL') == 'ACCELERATION') driver%level = 2
         driver%initial = [block%real('INITIAL'), block%real('INITIAL VELOCITY')]
         driver%has_initial = block%given('INITIAL')
         if (.not. driver%has_initial .and. driver%body > 0) driver%initial(1) = model%bodies(driver%body)%angle
      end associate
      if (diagnostics%count == before) then
         call prepare(model, model%drivers(index))
         call enter_name(model, 'driver', model%drivers(index)%name, index)
      else
         allocate (longer(index - 1))
         longer(:) = model%drivers(:index - 1)
         call move_alloc(longer, model%drivers)
      end if
   end subroutine add_driver

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
      case ('DISPLACEMENT')
         kind = driver_displacement
         call need(joint > 0, 'JOINT')
         if (ok) call check_along(model, joint, block%origin_of('JOINT'), diagnostics)
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

end module limber_model_joint_blocks
