!> Builder of the loads from the model. Markers, gauges and followed angles that they need, and the bodies that they act on or
!> depend on. Floor: multibody. Source: doc/theory, eqs. (3.31)-(3.37), (3.39).
module limber_multibody_load_list
   use limber_base_kinds, only: wp
   use limber_model_quantities, only: quantity_x, quantity_y, quantity_vx, quantity_vy, quantity_angle, quantity_spin, &
      & quantity_u1, quantity_u2, quantity_elongation, quantity_rate, quantity_joint_angle, quantity_joint_spin, &
      & quantity_displacement, quantity_sliding_speed
   use limber_model_model, only: model_type, force_type, torque_type, spring_type, load_effort_type, named_load_type, &
      & quantity_type, ground, effort_axis, effort_follower, effort_distance, effort_slide, effort_angle, own_elongation, &
      & own_rate, in_forces, in_torques, in_springs, in_efforts
   use limber_multibody_force_elements, only: force_element_type
   use limber_multibody_load_functions, only: load_function_type, compare_gauges, gauge_shift, gauge_distance, gauge_slide, &
      & gauge_angle
   use limber_multibody_load, only: load_type, load_item_type, dead_force_type, body_torque_type
   use limber_multibody_marker_registry, only: registry_type, marker_of, direction_of, angle_of, frame_point
   use limber_multibody_springs, only: point_spring_type
   implicit none
   private
   public :: new_loads, places_of

   !> Distance below which a spring's direction fades, relative to the characteristic length
   real(wp), parameter :: softening = 1.0e-10_wp

contains

   !> Forces, torques, springs and efforts of the model, in this order.
   subroutine new_loads(system, loads)
      class(registry_type), intent(inout) :: system
      type(load_item_type), allocatable, intent(out) :: loads(:)
      integer :: i, side, count
      associate (model => system%model)
         allocate (loads(size(model%forces) + size(model%torques) + size(model%springs) + size(model%efforts)))
      end associate
      count = 0
      do i = 1, size(system%model%forces)
         count = count + 1
         call add_force(system, system%model%forces(i), loads(count)%item)
      end do
      do i = 1, size(system%model%torques)
         count = count + 1
         call add_torque(system%model%torques(i), loads(count)%item)
      end do
      do i = 1, size(system%model%springs)
         count = count + 1
         call add_spring(system, system%model%springs(i), loads(count)%item)
      end do
      do i = 1, size(system%model%efforts)
         count = count + 1
         call add_effort(system, i, loads(count)%item)
      end do
      do i = 1, count
         associate (load => loads(i)%item)
            allocate (load%rates(size(load%bodies)), load%offsets(size(load%bodies)))
            if (.not. allocated(load%points)) allocate (load%points(size(load%bodies)), source=0)
            load%rates = 0
            do side = 1, size(load%bodies)
               if (load%bodies(side) /= ground) load%rates(side) = system%layout%rates(load%bodies(side)) &
                  & + system%layout%n(load%bodies(side))
               load%offsets(side) = sum(load%rates(:side - 1))
            end do
         end associate
      end do
   end subroutine new_loads

   !> First and last place of a load of the deck in the list that `new_loads` makes.
   pure subroutine places_of(model, named, first, last)
      type(model_type), intent(in) :: model
      type(named_load_type), intent(in) :: named
      integer, intent(out) :: first, last
      integer :: before
      before = 0
      if (named%list > in_forces) before = before + size(model%forces)
      if (named%list > in_torques) before = before + size(model%torques)
      if (named%list > in_springs) before = before + size(model%springs)
      first = before + named%first
      last = before + named%last
   end subroutine places_of

   subroutine add_force(system, force, item)
      class(registry_type), intent(inout) :: system
      type(force_type), intent(in) :: force
      class(load_type), allocatable, intent(out) :: item
      type(dead_force_type) :: dead
      dead%marker = marker_of(system, force%point)
      dead%law_x = force%law(1)
      dead%law_y = force%law(2)
      dead%bodies = [system%model%points(force%point)%body]
      dead%points = [force%point]
      allocate (item, source=dead)
   end subroutine add_force

   subroutine add_torque(torque, item)
      type(torque_type), intent(in) :: torque
      class(load_type), allocatable, intent(out) :: item
      type(body_torque_type) :: turning
      turning%law = torque%law
      turning%bodies = [torque%body]
      allocate (item, source=turning)
   end subroutine add_torque

   subroutine add_spring(system, spring, item)
      class(registry_type), intent(inout) :: system
      type(spring_type), intent(in) :: spring
      class(load_type), allocatable, intent(out) :: item
      type(point_spring_type) :: pull
      pull%markers(1) = marker_of(system, spring%points(1))
      pull%markers(2) = marker_of(system, spring%points(2))
      pull%bodies = [system%model%points(spring%points(1))%body, system%model%points(spring%points(2))%body]
      pull%points = spring%points
      pull%stiffness = spring%stiffness
      pull%free_length = spring%length
      pull%damping = spring%damping
      pull%softening = softening*system%model%length
      pull%powered = spring%damping > 0.0_wp
      allocate (item, source=pull)
   end subroutine add_spring

   !> An effort: its gauges, and the bodies that these are on.
   subroutine add_effort(system, index, item)
      class(registry_type), intent(inout) :: system
      !> In the model
      integer, intent(in) :: index
      class(load_type), allocatable, intent(out) :: item
      type(force_element_type) :: effort
      type(load_function_type) :: gauge
      integer :: k
      associate (spec => system%model%efforts(index))
         effort%follower = spec%along == effort_follower
         effort%stiffness = spec%stiffness
         effort%damping = spec%damping
         effort%factor = spec%factor
         effort%driven = spec%driven
         allocate (effort%gauges(0), effort%bodies(0))
         call own_gauge(system, spec, gauge)
         call include_gauge(system, gauge, effort%gauges, effort%bodies, k)
         if (spec%driven) then
            effort%law = spec%law
            allocate (effort%slots(size(spec%quantities)), effort%by_rate(size(spec%quantities)))
            do k = 1, size(spec%quantities)
               call read_slot(system, spec, spec%quantities(k), effort, k)
            end do
            call find_potential(effort)
            effort%stores = effort%potential .and. all(spec%quantities%kind == own_elongation)
         else
            allocate (effort%slots(0), effort%by_rate(0))
         end if
         effort%powered = spec%damping > 0.0_wp .or. (spec%driven .and. .not. effort%stores)
      end associate
      allocate (effort%points(size(effort%bodies)), source=0)
      do k = 2, 1, -1
         if (system%model%efforts(index)%points(k) == 0) cycle
         where (effort%bodies == system%model%points(system%model%efforts(index)%points(k))%body) &
            & effort%points = system%model%efforts(index)%points(k)
      end do
      allocate (item, source=effort)
   end subroutine add_effort

   !> Whether the law of an effort depends on nothing but the gauge that it acts along, whatever name the deck has for that.
   subroutine find_potential(effort)
      type(force_element_type), intent(inout) :: effort
      integer :: k
      allocate (effort%sign(size(effort%slots)), effort%shift(size(effort%slots)))
      effort%potential = size(effort%slots) > 0 .and. .not. effort%follower
      do k = 1, size(effort%slots)
         if (effort%potential) effort%potential = effort%slots(k) > 0 .and. .not. effort%by_rate(k)
         if (effort%potential) call compare_gauges(effort%gauges(1), effort%gauges(effort%slots(k)), effort%sign(k), &
            & effort%shift(k), effort%potential)
      end do
   end subroutine find_potential

   !> What a slot of a law stands for.
   subroutine read_slot(system, spec, quantity, effort, slot)
      class(registry_type), intent(inout) :: system
      type(load_effort_type), intent(in) :: spec
      type(quantity_type), intent(in) :: quantity
      type(force_element_type), intent(inout) :: effort
      integer, intent(in) :: slot
      type(load_function_type) :: gauge
      effort%by_rate(slot) = .false.
      effort%slots(slot) = 0
      if (quantity%kind == 0) return
      if (quantity%kind < 0) then
         call own_gauge(system, spec, gauge)
         effort%by_rate(slot) = quantity%kind == own_rate
      else
         call quantity_gauge(system, quantity, gauge, effort%by_rate(slot))
      end if
      call include_gauge(system, gauge, effort%gauges, effort%bodies, effort%slots(slot))
   end subroutine read_slot

   !> The gauge that an effort acts along.
   subroutine own_gauge(system, spec, gauge)
      class(registry_type), intent(inout) :: system
      type(load_effort_type), intent(in) :: spec
      type(load_function_type), intent(out) :: gauge
      integer :: k
      gauge%origin = spec%origin
      if (spec%along == effort_angle) then
         gauge%kind = gauge_angle
         do k = 1, 2
            if (spec%points(k) == 0) cycle
            gauge%markers(k) = direction_of(system, spec%points(k), 0.0_wp)
            if (system%model%points(system%marker_points(gauge%markers(k)))%body == ground) cycle
            gauge%angles(k) = angle_of(system, 0, gauge%markers(k))
         end do
         return
      end if
      do k = 1, 2
         if (spec%points(k) > 0) gauge%markers(k) = marker_of(system, spec%points(k))
      end do
      select case (spec%along)
      case (effort_axis)
         gauge%kind = gauge_shift
         gauge%axis = [cos(spec%angle), sin(spec%angle)]
      case (effort_distance)
         gauge%kind = gauge_distance
         gauge%softening = softening*system%model%length
      case (effort_follower)
         gauge%kind = gauge_slide
         gauge%markers(3) = direction_of(system, spec%points(1), spec%angle)
      case (effort_slide)
         gauge%kind = gauge_slide
         gauge%markers(3) = direction_of(system, spec%points(2), spec%angle)
      end select
   end subroutine own_gauge

   !> The gauge of a quantity, and whether its rate is meant.
   subroutine quantity_gauge(system, quantity, gauge, by_rate)
      class(registry_type), intent(inout) :: system
      type(quantity_type), intent(in) :: quantity
      type(load_function_type), intent(out) :: gauge
      logical, intent(out) :: by_rate
      type(load_effort_type) :: like
      by_rate = .false.
      like%points = [quantity%of, 0]
      select case (quantity%kind)
      case (quantity_x, quantity_y, quantity_vx, quantity_vy)
         like%along = effort_axis
         if (quantity%kind == quantity_y .or. quantity%kind == quantity_vy) like%angle = 0.5_wp*acos(-1.0_wp)
         by_rate = quantity%kind == quantity_vx .or. quantity%kind == quantity_vy
      case (quantity_angle, quantity_spin)
         like%along = effort_angle
         like%points(1) = frame_point(system, quantity%of)
         by_rate = quantity%kind == quantity_spin
      case (quantity_u1, quantity_u2)
         like%along = effort_slide
         like%points(2) = frame_point(system, system%model%points(quantity%of)%body)
         if (quantity%kind == quantity_u2) like%angle = 0.5_wp*acos(-1.0_wp)
         like%origin = system%model%points(quantity%of)%p0(merge(2, 1, quantity%kind == quantity_u2))
      case (quantity_joint_angle, quantity_joint_spin, quantity_displacement, quantity_sliding_speed)
         like%along = merge(effort_angle, effort_slide, &
            & quantity%kind == quantity_joint_angle .or. quantity%kind == quantity_joint_spin)
         like%points = system%model%joints(quantity%of)%points
         like%angle = system%model%joints(quantity%of)%angle
         by_rate = quantity%kind == quantity_joint_spin .or. quantity%kind == quantity_sliding_speed
      case (quantity_elongation, quantity_rate)
         like = effort_of(system%model, quantity%of)
         by_rate = quantity%kind == quantity_rate
      end select
      call own_gauge(system, like, gauge)
   end subroutine quantity_gauge

   !> A spring of the deck as an effort.
   function effort_of(model, load) result(effort)
      type(model_type), intent(in) :: model
      !> Index among the named loads
      integer, intent(in) :: load
      type(load_effort_type) :: effort
      associate (named => model%loads(load))
         if (named%list == in_efforts) then
            effort%along = model%efforts(named%first)%along
            effort%points = model%efforts(named%first)%points
            effort%origin = model%efforts(named%first)%origin
         else
            effort%along = effort_distance
            effort%points = model%springs(named%first)%points
            effort%origin = model%springs(named%first)%length
         end if
      end associate
   end function effort_of

   !> Adds a gauge to a list, unless it is there, and the bodies of its markers to another.
   subroutine include_gauge(system, gauge, gauges, bodies, found)
      class(registry_type), intent(in) :: system
      type(load_function_type), intent(inout) :: gauge
      type(load_function_type), allocatable, intent(inout) :: gauges(:)
      integer, allocatable, intent(inout) :: bodies(:)
      !> Index in the list
      integer, intent(out) :: found
      type(load_function_type), allocatable :: longer(:)
      integer :: m, body, part
      do found = 1, size(gauges)
         if (gauges(found)%kind == gauge%kind .and. all(gauges(found)%markers == gauge%markers) &
            & .and. .not. (any(abs(gauges(found)%axis - gauge%axis) > 0.0_wp) &
            & .or. abs(gauges(found)%origin - gauge%origin) > 0.0_wp)) return
      end do
      do m = 1, 3
         if (gauge%markers(m) == 0) cycle
         body = system%model%points(system%marker_points(gauge%markers(m)))%body
         if (body == ground) cycle
         do part = 1, size(bodies)
            if (bodies(part) == body) exit
         end do
         if (part > size(bodies)) bodies = [bodies, body]
         gauge%parts(m) = part
      end do
      allocate (longer(found))
      longer(:found - 1) = gauges
      longer(found) = gauge
      call move_alloc(longer, gauges)
   end subroutine include_gauge

end module limber_multibody_load_list
