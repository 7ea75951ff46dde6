!> Loads and damping of the deck: forces, torques, springs, bushings, friction, damping of beams. Each load consists of parts, and
!> each part acts along one scalar function of the motion. Floor: model.
module limber_model_load_blocks
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_deck_content, only: block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_expression, only: expression_type
   use limber_deck_joint_kinds, only: joint_revolute, joint_sliding, joint_kinds, place_on_line
   use limber_deck_operations, only: op_constant
   use limber_deck_origin, only: origin_type
   use limber_model_requested_channels, only: find_quantity
   use limber_model_points, only: add_point, find_point, find_named, find_body
   use limber_model_quantities, only: quantities, quantity_x, quantity_y, quantity_vx, quantity_vy, quantity_angle, &
      & quantity_spin, quantity_u1, quantity_u2, quantity_elongation, quantity_rate, quantity_joint_angle, &
      & quantity_joint_spin, quantity_displacement, quantity_sliding_speed
   use limber_model_beam_segments, only: pieces_of, find_frame, has_frame
   use limber_model_model, only: model_type, load_part_type, named_load_type, quantity_type, body_type, body_point, ground, &
      & along_axis, along_follower, along_distance, along_slide, along_angle, load_force, load_torque, load_spring, &
      & load_rotational, load_bushing, load_friction, own_elongation, own_rate, most_slots
   implicit none
   private
   public :: add_force, add_torque, add_spring, add_bushing, add_friction, add_damping, resolve_laws
   public :: new_part, set_law, append_part, name_load, constant

   real(wp), parameter :: quarter = 0.5_wp*acos(-1.0_wp)

contains

   !> Adds a force as one part for each of its two components; a zero component is left out.
   subroutine add_force(block, model, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      type(load_part_type) :: part
      integer :: point, first, k
      point = find_point(model, block%text('POINT'), block%origin_of('POINT'), diagnostics)
      if (point == 0 .or. size(block%lines) /= 1) return
      if (block%yes('FOLLOWER')) call need_frame(model, point, block%text('POINT'), block%origin_of('POINT'), diagnostics)
      first = size(model%load_parts) + 1
      do k = 1, 2
         if (is_zero(block%lines(1)%fields(k)%expression)) cycle
         part = new_part(merge(along_follower, along_axis, block%yes('FOLLOWER')), point, 0)
         part%angle = (k - 1)*quarter
         call set_law(part, block%lines(1)%fields(k)%expression, 1.0_wp)
         call append_part(model, part)
      end do
      call name_load(block, load_force, first, model)
   end subroutine add_force

   !> Adds a torque on the frame of a body or on a section.
   subroutine add_torque(block, model, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      type(load_part_type) :: part
      integer :: body, points(2)
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
      part = new_part(along_angle, points(1), points(2))
      call set_law(part, block%lines(1)%fields(1)%expression, 1.0_wp)
      call append_part(model, part)
      call name_load(block, load_torque, size(model%load_parts), model)
   end subroutine add_torque

   !> Adds a spring or damper between two points, or a rotational one between two sections.
   subroutine add_spring(block, model, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      type(load_part_type) :: part
      integer :: points(2)
      logical :: turning, linear
      turning = block%word('TYPE') == 'ROTATIONAL'
      if (turning .and. block%real('LENGTH') > 0.0_wp) call diagnostics%add(block%origin_of('LENGTH'), &
         & 'LENGTH is of springs of TYPE=TRANSLATIONAL', 'the free angle is ANGLE')
      if (.not. turning .and. abs(block%real('ANGLE')) > 0.0_wp) call diagnostics%add(block%origin_of('ANGLE'), &
         & 'ANGLE is of springs of TYPE=ROTATIONAL', 'the free length is LENGTH')
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
      call name_load(block, merge(load_rotational, load_spring, turning), size(model%load_parts), model)
   end subroutine add_spring

   !> Adds a bushing: two translational parts and a rotational one.
   subroutine add_bushing(block, model, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      type(load_part_type) :: part
      character(8), parameter :: ends(3) = [character(8) :: 'X', 'Y', 'ROTATION']
      integer :: points(2), k
      if (size(block%lines) /= 1) return
      call find_pair(block, model, points, diagnostics)
      if (any(points == 0)) return
      if (model%points(points(1))%body == model%points(points(2))%body) call diagnostics%add(block%lines(1)%origin_of(2), &
         & "bushing '"//block%name()//"' joins a body to itself", 'name points of two different bodies')
      do k = 1, 3
         part = new_part(merge(along_angle, along_slide, k == 3), points(1), points(2))
         part%angle = block%real('AXES') + (k - 1)*quarter
         if (k == 3) part%origin = block%real('ANGLE')
         part%stiffness = block%real('STIFFNESS '//trim(ends(k)))
         part%damping = block%real('DAMPING '//trim(ends(k)))
         if (k == 3 .and. part%stiffness + part%damping > 0.0_wp) call check_turning(block, model, points, diagnostics)
         call append_part(model, part)
      end do
      call name_load(block, load_bushing, size(model%load_parts) - 2, model)
   end subroutine add_bushing

   !> Adds viscous friction along the free coordinate of a joint.
   subroutine add_friction(block, model, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      type(load_part_type) :: part
      integer :: i
      i = find_named(model, 'joint', block%name('JOINT'))
      if (i == 0) return
      associate (joint => model%joints(i))
         if (joint%kind == joint_revolute) then
            part = new_part(along_angle, joint%points(1), joint%points(2))
         else if (joint_kinds(joint%kind)%place == place_on_line) then
            part = new_part(along_slide, joint%points(1), joint%points(2))
            part%angle = joint%angle
         else
            call diagnostics%add(block%origin_of('JOINT'), "there is no friction in joint '"//joint%name//"'", &
               & 'it is for joints of the types REVOLUTE, TRANSLATIONAL and POINT ON LINE')
            return
         end if
         part%damping = block%real('COEFFICIENT')
         call append_part(model, part)
         call name_load(block, load_friction, size(model%load_parts), model)
      end associate
   end subroutine add_friction

   !> Adds damping of a beam or frame; of a beam in segments for all pieces.
   subroutine add_damping(block, model, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: body, pieces(2), before
      body = find_body(model, block%name('BODY'))
      if (body == 0) return
      pieces = pieces_of(model, body)
      before = diagnostics%count
      do body = pieces(1), pieces(2)
         call damp(block, body, before, model, diagnostics)
         if (diagnostics%count > before) return
      end do
   end subroutine add_damping

   !> Adds the damping of the modes of a body, eq. (3.39).
   subroutine damp(block, body, before, model, diagnostics)
      type(block_type), intent(in) :: block
      !> Body, and number of errors before the block
      integer, intent(in) :: body, before
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp), allocatable :: ratio(:)
      integer :: i, mode
      associate (reduced => model%bodies(body)%reduced)
         if (reduced%damped) then
            call diagnostics%add(block%origin, "beam '"//model%bodies(body)%name//"' is damped twice", 'put both into one *DAMPING')
            return
         end if
         allocate (ratio(reduced%n))
         ratio = block%real('RATIO')
         do i = 1, size(block%lines)
            mode = nint(block%lines(i)%number(1))
            ! A beam in error has no modes
            if (reduced%n == 0 .and. before > 0) cycle
            if (mode > reduced%n) then
               call diagnostics%add(block%lines(i)%origin_of(1), "beam '"//model%bodies(body)%name//"' has "// &
                  & as_text(reduced%n)//' modes, '//as_text(reduced%bending)//' of them bending', 'give a mode that it has')
            else
               ratio(mode) = block%lines(i)%number(2)
            end if
         end do
         if (reduced%n == 0) return
         reduced%damped = .true.
         allocate (reduced%damping(reduced%n, reduced%n))
         reduced%damping = 0.0_wp
         do i = 1, reduced%n
            reduced%damping(i, i) = 2*ratio(i)*sqrt(reduced%omega2(i)) + block%real('RAYLEIGH ALPHA') &
               & + block%real('RAYLEIGH BETA')*reduced%omega2(i)
         end do
         ! Damping by the modes under the supports is computed after the assembly
         if (.not. (maxval(ratio) > 0.0_wp .or. block%real('RAYLEIGH ALPHA') > 0.0_wp)) return
         allocate (model%bodies(body)%ratio, source=ratio)
         model%bodies(body)%rayleigh = [block%real('RAYLEIGH ALPHA'), block%real('RAYLEIGH BETA')]
      end associate
   end subroutine damp

   !> Finds the quantities in the laws of all loads. All bodies, joints and springs must be in the model.
   subroutine resolve_laws(model, diagnostics)
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i, k
      do i = 1, size(model%load_parts)
         if (.not. model%load_parts(i)%driven) cycle
         associate (law => model%load_parts(i)%law)
            if (size(law%slots) > most_slots) call diagnostics%add(law%slots(1)%origin, 'a law depends on '// &
               & as_text(size(law%slots))//' things', 'at most '//as_text(most_slots))
            allocate (model%load_parts(i)%quantities(size(law%slots)))
            do k = 1, size(law%slots)
               call resolve(i, k)
            end do
         end associate
      end do

   contains

      !> Finds the quantity of one variable.
      subroutine resolve(part, slot)
         integer, intent(in) :: part, slot
         type(quantity_type) :: quantity
         associate (what => model%load_parts(part)%law%slots(slot))
            if (what%argument == '' .and. what%name == 'x') then
               quantity%kind = own_elongation
            else if (what%argument == '' .and. what%name == 'v') then
               quantity%kind = own_rate
            else
               call find_quantity(what, model, quantity, diagnostics)
               if (quantity%of > 0) call check_quantity(quantity%kind, what%origin, diagnostics)
               if (quantity%of > 0) call check_frame(model, quantity, what%origin, diagnostics)
            end if
         end associate
         model%load_parts(part)%quantities(slot) = quantity
      end subroutine resolve

   end subroutine resolve_laws

   !> Reports a quantity that is neither a position nor a velocity.
   subroutine check_quantity(kind, origin, diagnostics)
      integer, intent(in) :: kind
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      integer, parameter :: usable(*) = [quantity_x, quantity_y, quantity_vx, quantity_vy, quantity_angle, quantity_spin, &
         & quantity_u1, quantity_u2, quantity_elongation, quantity_rate, quantity_joint_angle, quantity_joint_spin, &
         & quantity_displacement, quantity_sliding_speed]
      character(:), allocatable :: list
      integer :: i
      if (any(usable == kind)) return
      list = trim(quantities(usable(1))%name)
      do i = 2, size(usable)
         list = list//', '//trim(quantities(usable(i))%name)
      end do
      call diagnostics%add(origin, "a load cannot depend on '"//trim(quantities(kind)%name)//"'", 'it may depend on '//list)
   end subroutine check_quantity

   !> Reports a coordinate along a beam, and quantities measured from the frame of a beam in segments. Exception: the first piece,
   !> if it carries the frame of the whole.
   subroutine check_frame(model, quantity, origin, diagnostics)
      type(model_type), intent(in) :: model
      type(quantity_type), intent(in) :: quantity
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: body, pieces(2)
      select case (quantity%kind)
      case (quantity_angle, quantity_spin); body = quantity%of
      case (quantity_u1, quantity_u2); body = model%points(quantity%of)%body
      case (quantity_displacement, quantity_sliding_speed)
         if (model%joints(quantity%of)%kind == joint_sliding) call diagnostics%add(origin, "a load cannot depend on '"// &
            & trim(quantities(quantity%kind)%name)//"' of a point that slides along a beam", &
            & 'let it depend on x, y, vx, vy of the point')
         return
      case default; return
      end select
      pieces = pieces_of(model, body)
      if (has_frame(model, body) .and. body == pieces(1)) return
      call diagnostics%add(origin, "a load cannot depend on '"//trim(quantities(quantity%kind)%name)//"' of a beam in segments", &
         & 'let it depend on x, y, vx, vy of points')
   end subroutine check_frame

   !> A part without stiffness, damping and law. `along`: kind of coordinate; `first`, `second`: points, or 0.
   pure function new_part(along, first, second) result(part)
      integer, intent(in) :: along, first, second
      type(load_part_type) :: part
      part%along = along
      part%points = [first, second]
   end function new_part

   !> Whether a law is the constant zero.
   pure logical function is_zero(law)
      type(expression_type), intent(in) :: law
      is_zero = .false.
      if (law%is_constant()) is_zero = .not. abs(law%constant_value()) > 0.0_wp
   end function is_zero

   !> Gives a part a law and its factor.
   pure subroutine set_law(part, law, factor)
      type(load_part_type), intent(inout) :: part
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: factor
      part%driven = .true.
      part%law = law
      part%factor = factor
   end subroutine set_law

   !> A constant law.
   pure function constant(value) result(law)
      real(wp), intent(in) :: value
      type(expression_type) :: law
      allocate (law%codes(1), source=op_constant)
      allocate (law%operands(1), source=1)
      allocate (law%constants(1), source=value)
      allocate (law%slots(0))
   end function constant

   !> Appends a part to the model. No array constructor: gfortran copies types with deep components badly there.
   subroutine append_part(model, part)
      type(model_type), intent(inout) :: model
      type(load_part_type), intent(in) :: part
      type(load_part_type), allocatable :: longer(:)
      integer :: n
      n = size(model%load_parts) + 1
      allocate (longer(n))
      longer(:n - 1) = model%load_parts
      longer(n) = part
      call move_alloc(longer, model%load_parts)
   end subroutine append_part

   !> Enters a named load with the parts from `first` to the last one.
   subroutine name_load(block, kind, first, model)
      type(block_type), intent(in) :: block
      integer, intent(in) :: kind, first
      type(model_type), intent(inout) :: model
      type(named_load_type), allocatable :: longer(:)
      integer :: n
      n = size(model%loads) + 1
      allocate (longer(n))
      longer(:n - 1) = model%loads
      longer(n)%name = block%name()
      longer(n)%kind = kind
      longer(n)%first = first
      longer(n)%last = size(model%load_parts)
      call move_alloc(longer, model%loads)
   end subroutine name_load

   !> Finds the two points of the data line; 0 and an error where there is none.
   subroutine find_pair(block, model, points, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(in) :: model
      integer, intent(out) :: points(2)
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i
      do i = 1, 2
         points(i) = find_point(model, block%lines(1)%text(i), block%lines(1)%origin_of(i), diagnostics)
      end do
   end subroutine find_pair

   !> Reports a spring between two points of one body that is no beam.
   subroutine check_pair(block, model, points, turning, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(in) :: model
      integer, intent(in) :: points(2)
      logical, intent(in) :: turning
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: bodies(2)
      bodies = model%points(points)%body
      if (turning) call check_turning(block, model, points, diagnostics)
      if (bodies(1) /= bodies(2) .or. is_beam(model, bodies(1))) return
      if (turning) then
         call diagnostics%add(block%lines(1)%origin_of(2), "spring '"//block%name()//"' turns a body against itself", &
            & 'name points of two different bodies')
      else
         call diagnostics%add(block%lines(1)%origin_of(2), "spring '"//block%name()// &
            & "' pulls at two points whose distance never changes", 'name points of two different bodies')
      end if
   end subroutine check_pair

   !> Reports points of a rotational spring on a point mass.
   subroutine check_turning(block, model, points, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(in) :: model
      integer, intent(in) :: points(2)
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i
      do i = 1, 2
         call need_frame(model, points(i), block%lines(1)%text(i), block%lines(1)%origin_of(i), diagnostics)
      end do
   end subroutine check_turning

   !> Reports a point on a point mass, which has no rotation.
   subroutine need_frame(model, point, text, origin, diagnostics)
      type(model_type), intent(in) :: model
      integer, intent(in) :: point
      character(*), intent(in) :: text
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      if (model%points(point)%body == ground) return
      if (model%bodies(model%points(point)%body)%kind == body_point) call diagnostics%add(origin, &
         & "'"//text//"' is a point mass and does not turn")
   end subroutine need_frame

   !> Point of an option whose section is meant; 0 with an error if there is none.
   integer function section(block, option, model, diagnostics) result(point)
      type(block_type), intent(in) :: block
      character(*), intent(in) :: option
      type(model_type), intent(in) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      point = find_point(model, block%text(option), block%origin_of(option), diagnostics)
      if (point > 0) call need_frame(model, point, block%text(option), block%origin_of(option), diagnostics)
   end function section

   !> Adds a point that turns with the frame of a body, independent of deflections.
   integer function frame_point(model, body) result(point)
      type(model_type), intent(inout) :: model
      integer, intent(in) :: body
      real(wp), allocatable :: phi(:, :), psi(:)
      allocate (phi(2, model%bodies(body)%reduced%n), psi(model%bodies(body)%reduced%n))
      phi = 0.0_wp
      psi = 0.0_wp
      call add_point(model, ' '//model%bodies(body)%name, body, [0.0_wp, 0.0_wp], phi, psi)
      point = model%counts%points
   end function frame_point

   !> Whether a body is a beam or a frame.
   pure logical function is_beam(model, body)
      type(model_type), intent(in) :: model
      integer, intent(in) :: body
      is_beam = .false.
      if (body /= ground) is_beam = model%bodies(body)%end_point > 0 .or. model%bodies(body)%is_frame
   end function is_beam

end module limber_model_load_blocks
