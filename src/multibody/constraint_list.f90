!> Builder of the constraints from joints and drivers. What functions of the motion each kind of them has, and how these are put
!> together. Floor: multibody. Source: doc/theory, eqs. (3.15), (3.16), (3.22)-(3.24), (3.28), (3.29).
module limber_multibody_constraint_list
   use limber_base_kinds, only: wp
   use limber_model_model, only: joint_type, function_term_type, driver_type, term_type, body_flexible, ground, &
      & place_on_curve, place_on_beam, place_on_line, function_component, function_displacement, function_parallel, &
      & function_distance, function_section_angle, function_direction, coordinate_joint_angle, coordinate_displacement, &
      & driver_angle, driver_joint_angle, driver_distance, driver_displacement, driver_x, driver_y
   use limber_multibody_constraint, only: constraint_type, constraint_item_type
   use limber_multibody_couplers, only: add_coupler
   use limber_multibody_plane_vectors, only: axis_of
   use limber_multibody_drivers, only: driven_angle_type, driven_origin_type
   use limber_multibody_beam_path, only: beam_path_type
   use limber_multibody_point_joints, only: revolute_type, point_on_line_type
   use limber_multibody_function_constraints, only: linear_type
   use limber_multibody_path_constraints, only: curve_joint_type
   use limber_multibody_scalar_functions, only: scalar_function_type, scalar_angle
   use limber_multibody_sliding_paths, only: new_path, new_coordinate, slides
   use limber_multibody_marker_registry, only: registry_type, marker_of, angle_of, guessed_angle, guessed_position
   use limber_multibody_function_sums, only: add_coordinate, add_section_angle, add_displacement, add_parallel, &
      & add_component, add_distance, add_scalar, take_functions, find_bodies, guessed_distance, guessed_place
   implicit none
   private
   public :: new_joint, new_driver

   real(wp), parameter :: right_angle = 0.5_wp*acos(-1.0_wp)

contains

   !> The constraint of a joint of the model, which has its index.
   subroutine new_joint(system, index, item, parts)
      class(registry_type), intent(inout) :: system
      !> Of the joint in the model
      integer, intent(in) :: index
      class(constraint_type), allocatable, intent(out) :: item
      !> Receives the parts behind the first of a coupler of more than two bodies
      type(constraint_item_type), allocatable, intent(inout) :: parts(:)
      type(joint_type) :: joint
      joint = system%model%joints(index)
      if (joint%is_coupler()) then
         call add_coupler(system, index, item, parts)
         item%label = "coupler '"//joint%name//"'"
         return
      end if
      select case (joint%place)
      case (place_on_curve); call add_curve(system, joint, item)
      case (place_on_beam); call add_sliding(system, joint, item)
      case default
         if (joint%is_hinge()) then
            call add_revolute(system, joint, item)
         else if (joint%place == place_on_line .and. .not. joint%keeps_angle .and. .not. bends(system, joint%points(2))) then
            call add_line(system, joint, item)
         else
            call add_sums(system, joint, item)
         end if
      end select
      item%label = "joint '"//joint%name//"'"
      item%scale = system%model%length
      item%bodies = [system%model%points(joint%points(1))%body, system%model%points(joint%points(2))%body]
      item%points = joint%points
   end subroutine new_joint

   subroutine add_revolute(system, joint, item)
      class(registry_type), intent(inout) :: system
      type(joint_type), intent(in) :: joint
      class(constraint_type), allocatable, intent(out) :: item
      type(revolute_type) :: revolute
      revolute%rows = 2
      revolute%markers(1) = marker_of(system, joint%points(1))
      revolute%markers(2) = marker_of(system, joint%points(2))
      allocate (item, source=revolute)
   end subroutine add_revolute

   !> A point on a line of the ground, or of a body that does not bend at the line's point: closed form of `add_sums`.
   subroutine add_line(system, joint, item)
      class(registry_type), intent(inout) :: system
      type(joint_type), intent(in) :: joint
      class(constraint_type), allocatable, intent(out) :: item
      type(point_on_line_type) :: line
      line%rows = 1
      line%markers(1) = marker_of(system, joint%points(1))
      line%markers(2) = marker_of(system, joint%points(2))
      line%direction = [cos(joint%angle), sin(joint%angle)]
      allocate (item, source=line)
   end subroutine add_line

   !> Equations that are sums of scalar functions, as the kind of the joint describes them.
   subroutine add_sums(system, joint, item)
      class(registry_type), intent(inout) :: system
      type(joint_type), intent(in) :: joint
      class(constraint_type), allocatable, intent(out) :: item
      type(linear_type) :: sums
      real(wp) :: guess(3), side
      integer :: i
      guess = 0.0_wp
      side = 1.0_wp
      if (any(joint%functions%by_side)) then
         if (guessed_place(system, joint%points, joint%angle + right_angle) < 0.0_wp) side = -1.0_wp
      end if
      do i = 1, size(joint%functions)
         associate (term => joint%functions(i))
            call add_function(system, sums, joint, term, merge(side, 1.0_wp, term%by_side)*term%coefficient, guess(term%row))
         end associate
      end do
      if (.not. joint%zero) sums%offset(:sums%rows) = guess(:sums%rows)
      if (joint%has_length) sums%offset(1) = joint%length
      sums%keeps = .not. (joint%zero .or. joint%has_length)
      allocate (item, source=sums)
   end subroutine add_sums

   !> Adds a term of an equation, and its value in the first guess to a sum.
   subroutine add_function(system, sums, joint, term, coefficient, guess)
      class(registry_type), intent(inout) :: system
      type(linear_type), intent(inout) :: sums
      type(joint_type), intent(in) :: joint
      type(function_term_type), intent(in) :: term
      real(wp), intent(in) :: coefficient
      real(wp), intent(inout) :: guess
      integer :: centre(2)
      select case (term%function)
      case (function_component)
         call add_component(system, sums, joint%points, axis_of(term%angle), term%row)
      case (function_displacement)
         call add_displacement(system, sums, joint, term%angle, coefficient)
         guess = guess + coefficient*guessed_place(system, joint%points, term%angle)
      case (function_parallel)
         call add_parallel(system, sums, joint, term%row)
      case (function_distance)
         call add_distance(system, sums, joint%points, term%row)
         guess = guess + coefficient*guessed_distance(system, joint%points)
      case (function_section_angle)
         call add_section_angle(system, sums, joint%points(term%side), coefficient, guess)
      case (function_direction)
         centre = [marker_of(system, joint%points(1)), marker_of(system, joint%points(2))]
         call add_scalar(sums, scalar_function_type(kind=scalar_angle, markers=[centre(2), centre(1), 0], &
            & angles=[angle_of(system, centre(1), centre(2)), 0]), coefficient, term%row)
         guess = guess + coefficient*guessed_angle(system, centre(1), centre(2))
      end select
   end subroutine add_function

   !> A point on a curve in the section of the second body, its origin at the second point.
   subroutine add_curve(system, joint, item)
      class(registry_type), intent(inout) :: system
      type(joint_type), intent(in) :: joint
      class(constraint_type), allocatable, intent(out) :: item
      type(curve_joint_type) :: path
      type(linear_type) :: axes
      real(wp) :: guess
      integer :: i
      guess = 0.0_wp
      do i = 1, size(joint%functions)
         call add_function(system, axes, joint, joint%functions(i), 1.0_wp, guess)
      end do
      call take_functions(axes, path)
      path%curve = joint%curve
      allocate (item, source=path)
   end subroutine add_curve

   !> A point on the line of a deforming beam.
   subroutine add_sliding(system, joint, item)
      class(registry_type), intent(inout) :: system
      type(joint_type), intent(in) :: joint
      class(constraint_type), allocatable, intent(out) :: item
      class(beam_path_type), allocatable :: path
      call new_path(system, joint, path)
      call move_alloc(path, item)
   end subroutine add_sliding

   !> Drives the coordinate of a point along a beam.
   subroutine add_drive_along(system, index, item)
      class(registry_type), intent(inout) :: system
      !> Of the driver in the model
      integer, intent(in) :: index
      class(constraint_type), allocatable, intent(out) :: item
      class(beam_path_type), allocatable :: path
      real(wp) :: guess
      call new_coordinate(system, system%model%joints(system%model%drivers(index)%joint), 1.0_wp, path, guess)
      path%drive = index
      path%scale = system%model%length
      if (.not. system%model%drivers(index)%has_initial) system%model%drivers(index)%initial(1) = guess
      call move_alloc(path, item)
   end subroutine add_drive_along

   !> The constraint of a driver of the model.
   subroutine new_driver(system, index, item)
      class(registry_type), intent(inout) :: system
      !> Of the driver in the model
      integer, intent(in) :: index
      class(constraint_type), allocatable, intent(out) :: item
      type(driven_angle_type) :: driven
      type(driven_origin_type) :: origin
      type(linear_type) :: along
      type(driver_type) :: driver
      real(wp) :: value, axis(2)
      driver = system%model%drivers(index)
      value = 0.0_wp
      if (driver%kind == driver_angle) then
         driven%rows = 1
         driven%drive = index
         driven%bodies = [driver%body, ground]
         allocate (item, source=driven)
      else if (drives_origin(system, driver)) then
         origin%rows = 1
         origin%drive = index
         origin%axis = merge(1, 2, driver%kind == driver_x)
         associate (body => system%model%points(driver%points(1))%body)
            origin%bodies = [body, ground]
            if (.not. driver%has_initial) system%model%drivers(index)%initial(1) = system%model%bodies(body)%position(origin%axis)
         end associate
         origin%points = [driver%points(1), 0]
         origin%scale = system%model%length
         allocate (item, source=origin)
      else if (drives_along_beam(system, driver)) then
         call add_drive_along(system, index, item)
      else
         along%rows = 1
         along%drive = index
         select case (driver%kind)
         case (driver_joint_angle)
            call add_coordinate(system, along, term_type(1.0_wp, coordinate_joint_angle, driver%joint), value)
         case (driver_displacement)
            call add_coordinate(system, along, term_type(1.0_wp, coordinate_displacement, driver%joint), value)
         case (driver_distance)
            call add_distance(system, along, driver%points, 1)
            value = guessed_distance(system, driver%points)
         case default
            axis = merge([1.0_wp, 0.0_wp], [0.0_wp, 1.0_wp], driver%kind == driver_x)
            call add_component(system, along, [driver%points(1), 0], axis, 1)
            value = dot_product(axis, guessed_position(system, system%model%points(driver%points(1))))
         end select
         if (.not. driver%has_initial) system%model%drivers(index)%initial(1) = value
         call find_bodies(system, along)
         call find_points(system, driver, along)
         if (driver%kind /= driver_joint_angle) along%scale = system%model%length
         allocate (item, source=along)
      end if
      item%driven = .true.
      item%label = "driver '"//driver%name//"'"
   end subroutine new_driver

   !> Whether a driver moves the origin of a frame, whatever the deflection.
   pure logical function drives_origin(system, driver) result(drives)
      class(registry_type), intent(in) :: system
      type(driver_type), intent(in) :: driver
      drives = .false.
      if (driver%kind /= driver_x .and. driver%kind /= driver_y) return
      associate (point => system%model%points(driver%points(1)))
         drives = .not. (any(abs(point%p0) > 0.0_wp) .or. any(abs(point%phi) > 0.0_wp))
      end associate
   end function drives_origin

   !> Whether a driver moves a point along a beam.
   pure logical function drives_along_beam(system, driver) result(drives)
      class(registry_type), intent(in) :: system
      type(driver_type), intent(in) :: driver
      drives = driver%kind == driver_displacement
      if (drives) drives = slides(system%model%joints(driver%joint))
   end function drives_along_beam

   !> Points where a driver acts on its bodies.
   subroutine find_points(system, driver, item)
      class(registry_type), intent(in) :: system
      type(driver_type), intent(in) :: driver
      type(linear_type), intent(inout) :: item
      integer :: points(2), k
      points = driver%points
      if (driver%kind == driver_joint_angle .or. driver%kind == driver_displacement) &
         & points = system%model%joints(driver%joint)%points
      do k = 1, 2
         if (points(k) == 0) cycle
         where (item%bodies == system%model%points(points(k))%body) item%points = points(k)
      end do
   end subroutine find_points

   !> Whether a point is on a flexible body.
   pure logical function bends(system, point)
      class(registry_type), intent(in) :: system
      integer, intent(in) :: point
      bends = .false.
      associate (body => system%model%points(point)%body)
         if (body /= ground) bends = system%model%bodies(body)%kind == body_flexible
      end associate
   end function bends

end module limber_multibody_constraint_list
