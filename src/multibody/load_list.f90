!> Builder of the loads from the model. Markers, scalar functions and followed angles that they need, and the bodies that they act
!> on or depend on. Floor: multibody. Source: doc/theory, eqs. (3.31)-(3.37), (3.39).
module limber_multibody_load_list
   use limber_base_kinds, only: wp
   use limber_deck_expression, only: expression_type
   use limber_model_quantities, only: quantity_x, quantity_y, quantity_vx, quantity_vy, quantity_angle, quantity_spin, &
      & quantity_u1, quantity_u2, quantity_elongation, quantity_rate, quantity_joint_angle, quantity_joint_spin, &
      & quantity_displacement, quantity_sliding_speed, quantity_state
   use limber_model_model, only: load_part_type, quantity_type, ground, along_axis, along_follower, along_distance, &
      & along_slide, along_angle, own_elongation, own_rate
   use limber_multibody_force_elements, only: force_element_type
   use limber_multibody_load, only: load_type, load_item_type, dead_force_type, body_torque_type
   use limber_multibody_marker_registry, only: registry_type, marker_of, direction_of, angle_of, frame_point, &
      & guessed_position
   use limber_multibody_plane_vectors, only: axis_of
   use limber_multibody_scalar_functions, only: scalar_function_type, compare_functions, scalar_component, scalar_distance, &
      & scalar_along, scalar_turn
   use limber_multibody_springs, only: point_spring_type
   implicit none
   private
   public :: new_loads, new_event_scalars, new_control_inputs

   !> Distance below which a spring's direction fades, relative to its length
   real(wp), parameter :: softening = 1.0e-10_wp

contains

   !> Loads of the system, one for each part of the loads of the model, in their order.
   subroutine new_loads(system, loads)
      class(registry_type), intent(inout) :: system
      type(load_item_type), allocatable, intent(out) :: loads(:)
      integer :: i, side
      allocate (loads(size(system%model%load_parts)))
      do i = 1, size(loads)
         call new_load(system, system%model%load_parts(i), loads(i)%item)
         associate (load => loads(i)%item)
            load%grows = system%model%load_parts(i)%is_constant()
            load%resists = may_resist(system%model%load_parts(i))
            ! The rate of a state of a control has no power
            if (system%model%load_parts(i)%control > 0) load%powered = .false.
            allocate (load%rates(size(load%bodies)), load%offsets(size(load%bodies)))
            load%rates = 0
            do side = 1, size(load%bodies)
               if (load%bodies(side) /= ground) load%rates(side) = system%layout%rates(load%bodies(side)) &
                  & + system%layout%n(load%bodies(side))
               load%offsets(side) = sum(load%rates(:side - 1))
            end do
         end associate
      end do
   end subroutine new_loads

   !> The scalars of the events of the model, as laws along nothing: they exert no force.
   subroutine new_event_scalars(system, scalars)
      class(registry_type), intent(inout) :: system
      !> In the order of the events
      type(force_element_type), allocatable, intent(out) :: scalars(:)
      integer :: i, number
      number = 0
      if (allocated(system%model%events)) number = size(system%model%events)
      allocate (scalars(number))
      do i = 1, size(scalars)
         call new_scalar(system, system%model%events(i)%law, system%model%events(i)%quantities, scalars(i))
      end do
   end subroutine new_event_scalars

   !> The first inputs of the controls of the model, as laws along nothing.
   subroutine new_control_inputs(system, scalars)
      class(registry_type), intent(inout) :: system
      !> In the order of the controls
      type(force_element_type), allocatable, intent(out) :: scalars(:)
      integer :: i, number
      number = 0
      if (allocated(system%model%controls)) number = size(system%model%controls)
      allocate (scalars(number))
      do i = 1, size(scalars)
         call new_scalar(system, system%model%controls(i)%law, system%model%controls(i)%quantities, scalars(i))
      end do
   end subroutine new_control_inputs

   !> A law along nothing.
   subroutine new_scalar(system, law, quantities, scalar)
      class(registry_type), intent(inout) :: system
      type(expression_type), intent(in) :: law
      !> What it depends on (slots)
      type(quantity_type), intent(in) :: quantities(:)
      type(force_element_type), intent(inout) :: scalar
      type(load_part_type) :: none
      integer :: k
      scalar%factor = 1.0_wp
      scalar%driven = .true.
      scalar%law = law
      allocate (scalar%functions(0), scalar%bodies(0), scalar%slots(size(quantities)), scalar%by_rate(size(quantities)))
      do k = 1, size(quantities)
         call read_slot(system, none, quantities(k), scalar, k)
      end do
   end subroutine new_scalar

   !> The load of a part, of the cheapest type that can be it.
   subroutine new_load(system, part, item)
      class(registry_type), intent(inout) :: system
      type(load_part_type), intent(in) :: part
      class(load_type), allocatable, intent(out) :: item
      if (part%along == along_distance .and. .not. part%driven) then
         call add_spring(system, part, item)
      else if (.not. is_prescribed(part)) then
         call add_element(system, part, item)
      else if (part%along == along_axis) then
         call add_force(system, part, item)
      else if (part%along == along_angle .and. turns_with_frame(system, part%points(1))) then
         call add_torque(system, part, item)
      else
         call add_element(system, part, item)
      end if
   end subroutine new_load

   !> Whether a part acts at one point, with a law of the time and nothing else.
   pure logical function is_prescribed(part)
      type(load_part_type), intent(in) :: part
      is_prescribed = part%driven .and. part%points(2) == 0 .and. part%is_of_time() &
         & .and. .not. (part%stiffness > 0.0_wp .or. part%damping > 0.0_wp)
   end function is_prescribed

   !> Whether the section at a point has the angle of the frame, whatever deflects.
   pure logical function turns_with_frame(system, point)
      class(registry_type), intent(in) :: system
      integer, intent(in) :: point
      turns_with_frame = system%model%points(point)%body /= ground
      if (turns_with_frame) turns_with_frame = .not. any(abs(system%model%points(point)%psi) > 0.0_wp)
   end function turns_with_frame

   subroutine add_force(system, part, item)
      class(registry_type), intent(inout) :: system
      type(load_part_type), intent(in) :: part
      class(load_type), allocatable, intent(out) :: item
      type(dead_force_type) :: dead
      dead%marker = marker_of(system, part%points(1))
      dead%direction = part%factor*axis_of(part%angle)
      dead%law = part%law
      dead%bodies = [system%model%points(part%points(1))%body]
      dead%points = [part%points(1)]
      allocate (item, source=dead)
   end subroutine add_force

   subroutine add_torque(system, part, item)
      class(registry_type), intent(in) :: system
      type(load_part_type), intent(in) :: part
      class(load_type), allocatable, intent(out) :: item
      type(body_torque_type) :: turning
      turning%factor = part%factor
      turning%law = part%law
      turning%bodies = [system%model%points(part%points(1))%body]
      turning%points = [part%points(1)]
      allocate (item, source=turning)
   end subroutine add_torque

   subroutine add_spring(system, part, item)
      class(registry_type), intent(inout) :: system
      type(load_part_type), intent(in) :: part
      class(load_type), allocatable, intent(out) :: item
      type(point_spring_type) :: pull
      pull%markers(1) = marker_of(system, part%points(1))
      pull%markers(2) = marker_of(system, part%points(2))
      pull%bodies = [system%model%points(part%points(1))%body, system%model%points(part%points(2))%body]
      pull%points = part%points
      pull%stiffness = part%stiffness
      pull%free_length = part%origin
      pull%damping = part%damping
      pull%softening = softening_of(system, part)
      pull%powered = part%damping > 0.0_wp
      allocate (item, source=pull)
   end subroutine add_spring

   !> Distance below which the direction of a spring fades: far below its own length, but not below the round-off of its places.
   real(wp) function softening_of(system, part) result(distance)
      class(registry_type), intent(in) :: system
      type(load_part_type), intent(in) :: part
      real(wp) :: a(2), b(2)
      a = guessed_position(system, system%model%points(part%points(1)))
      b = guessed_position(system, system%model%points(part%points(2)))
      distance = max(softening*max(abs(part%origin), norm2(b - a)), 4*epsilon(a)*max(norm2(a), norm2(b)))
      if (.not. max(abs(part%origin), norm2(b - a)) > 0.0_wp) distance = max(distance, softening*system%model%length)
   end function softening_of

   !> Whether a part may resist places of its points.
   pure logical function may_resist(part)
      type(load_part_type), intent(in) :: part
      may_resist = part%along /= along_follower .and. (part%stiffness > 0.0_wp .or. (part%driven .and. .not. part%is_of_time()))
   end function may_resist

   !> A force element: its scalar functions, and the bodies that these are on.
   subroutine add_element(system, part, item)
      class(registry_type), intent(inout) :: system
      type(load_part_type), intent(in) :: part
      class(load_type), allocatable, intent(out) :: item
      type(force_element_type) :: element
      type(scalar_function_type) :: scalar
      integer :: k
      element%follower = part%along == along_follower
      element%stiffness = part%stiffness
      element%damping = part%damping
      element%factor = part%factor
      element%driven = part%driven
      allocate (element%functions(0), element%bodies(0), element%slots(0), element%by_rate(0))
      call own_function(system, part, scalar)
      call include_function(system, scalar, element%functions, element%bodies, k)
      if (part%driven) call read_law(system, part, element)
      element%powered = part%damping > 0.0_wp .or. (part%driven .and. .not. element%stores)
      allocate (element%points(size(element%bodies)), source=0)
      do k = 2, 1, -1
         if (part%points(k) == 0) cycle
         where (element%bodies == system%model%points(part%points(k))%body) element%points = part%points(k)
      end do
      allocate (item, source=element)
   end subroutine add_element

   !> The law of a force element, and what it depends on.
   subroutine read_law(system, part, element)
      class(registry_type), intent(inout) :: system
      type(load_part_type), intent(in) :: part
      type(force_element_type), intent(inout) :: element
      integer :: k
      element%law = part%law
      deallocate (element%slots, element%by_rate)
      allocate (element%slots(size(part%quantities)), element%by_rate(size(part%quantities)))
      do k = 1, size(part%quantities)
         call read_slot(system, part, part%quantities(k), element, k)
      end do
      call find_potential(element)
      element%stores = element%potential .and. all(part%quantities%kind == own_elongation)
   end subroutine read_law

   !> Whether the law of a force element depends on nothing but the function that it acts along, whatever name the deck
   !> has for that.
   subroutine find_potential(element)
      type(force_element_type), intent(inout) :: element
      integer :: k
      allocate (element%sign(size(element%slots)), element%shift(size(element%slots)))
      element%potential = size(element%slots) > 0 .and. .not. element%follower
      do k = 1, size(element%slots)
         if (element%potential) element%potential = element%slots(k) > 0 .and. .not. element%by_rate(k)
         if (element%potential) call compare_functions(element%functions(1), element%functions(element%slots(k)), element%sign(k), &
            & element%shift(k), element%potential)
      end do
   end subroutine find_potential

   !> What a slot of a law stands for.
   subroutine read_slot(system, part, quantity, element, slot)
      class(registry_type), intent(inout) :: system
      type(load_part_type), intent(in) :: part
      type(quantity_type), intent(in) :: quantity
      type(force_element_type), intent(inout) :: element
      integer, intent(in) :: slot
      type(scalar_function_type) :: scalar
      element%by_rate(slot) = .false.
      element%slots(slot) = 0
      if (quantity%kind == 0) return
      if (quantity%kind < 0) then
         call own_function(system, part, scalar)
         element%by_rate(slot) = quantity%kind == own_rate
      else
         call quantity_function(system, quantity, scalar, element%by_rate(slot))
      end if
      call include_function(system, scalar, element%functions, element%bodies, element%slots(slot))
   end subroutine read_slot

   !> The scalar function that a part of a load acts along.
   subroutine own_function(system, part, scalar)
      class(registry_type), intent(inout) :: system
      type(load_part_type), intent(in) :: part
      type(scalar_function_type), intent(out) :: scalar
      integer :: k
      scalar%origin = part%origin
      if (part%along == along_angle) then
         scalar%kind = scalar_turn
         do k = 1, 2
            if (part%points(k) == 0) cycle
            scalar%markers(k) = direction_of(system, part%points(k), 0.0_wp)
            if (system%model%points(system%marker_points(scalar%markers(k)))%body == ground) cycle
            scalar%angles(k) = angle_of(system, 0, scalar%markers(k))
         end do
         return
      end if
      do k = 1, 2
         if (part%points(k) > 0) scalar%markers(k) = marker_of(system, part%points(k))
      end do
      select case (part%along)
      case (along_axis)
         scalar%kind = scalar_component
         scalar%axis = axis_of(part%angle)
      case (along_distance)
         scalar%kind = scalar_distance
         scalar%softening = softening_of(system, part)
      case (along_follower)
         scalar%kind = scalar_along
         scalar%unit = .true.
         scalar%markers(3) = direction_of(system, part%points(1), part%angle)
      case (along_slide)
         scalar%kind = scalar_along
         scalar%unit = .true.
         scalar%markers(3) = direction_of(system, part%points(2), part%angle)
      end select
   end subroutine own_function

   !> The scalar function of a quantity, and whether its rate is meant.
   subroutine quantity_function(system, quantity, scalar, by_rate)
      class(registry_type), intent(inout) :: system
      type(quantity_type), intent(in) :: quantity
      type(scalar_function_type), intent(out) :: scalar
      logical, intent(out) :: by_rate
      type(load_part_type) :: like
      by_rate = .false.
      like%points = [quantity%of, 0]
      select case (quantity%kind)
      case (quantity_x, quantity_y, quantity_vx, quantity_vy, quantity_state)
         like%along = along_axis
         if (quantity%kind == quantity_y .or. quantity%kind == quantity_vy) like%angle = 0.5_wp*acos(-1.0_wp)
         by_rate = quantity%kind == quantity_vx .or. quantity%kind == quantity_vy .or. quantity%kind == quantity_state
      case (quantity_angle, quantity_spin)
         like%along = along_angle
         like%points(1) = frame_point(system, quantity%of)
         by_rate = quantity%kind == quantity_spin
      case (quantity_u1, quantity_u2)
         like%along = along_slide
         like%points(2) = frame_point(system, system%model%points(quantity%of)%body)
         if (quantity%kind == quantity_u2) like%angle = 0.5_wp*acos(-1.0_wp)
         like%origin = system%model%points(quantity%of)%p0(merge(2, 1, quantity%kind == quantity_u2))
      case (quantity_joint_angle, quantity_joint_spin, quantity_displacement, quantity_sliding_speed)
         like%along = merge(along_angle, along_slide, &
            & quantity%kind == quantity_joint_angle .or. quantity%kind == quantity_joint_spin)
         like%points = system%model%joints(quantity%of)%points
         like%angle = system%model%joints(quantity%of)%angle
         by_rate = quantity%kind == quantity_joint_spin .or. quantity%kind == quantity_sliding_speed
      case (quantity_elongation, quantity_rate)
         like = system%model%load_parts(system%model%loads(quantity%of)%first)
         by_rate = quantity%kind == quantity_rate
      end select
      call own_function(system, like, scalar)
   end subroutine quantity_function

   !> Adds a scalar function to a list, unless it is there, and the bodies of its markers to another.
   subroutine include_function(system, scalar, functions, bodies, found)
      class(registry_type), intent(in) :: system
      type(scalar_function_type), intent(inout) :: scalar
      type(scalar_function_type), allocatable, intent(inout) :: functions(:)
      integer, allocatable, intent(inout) :: bodies(:)
      !> Index in the list
      integer, intent(out) :: found
      type(scalar_function_type), allocatable :: longer(:)
      integer :: m, body, part
      do found = 1, size(functions)
         if (functions(found)%kind == scalar%kind .and. all(functions(found)%markers == scalar%markers) &
            & .and. .not. (any(abs(functions(found)%axis - scalar%axis) > 0.0_wp) &
            & .or. abs(functions(found)%origin - scalar%origin) > 0.0_wp)) return
      end do
      do m = 1, 3
         if (scalar%markers(m) == 0) cycle
         body = system%model%points(system%marker_points(scalar%markers(m)))%body
         if (body == ground) cycle
         do part = 1, size(bodies)
            if (bodies(part) == body) exit
         end do
         if (part > size(bodies)) bodies = [bodies, body]
         scalar%parts(m) = part
      end do
      allocate (longer(found))
      longer(:found - 1) = functions
      longer(found) = scalar
      call move_alloc(longer, functions)
   end subroutine include_function

end module limber_multibody_load_list
