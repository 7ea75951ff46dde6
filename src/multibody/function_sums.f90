!> Sums of scalar functions for joints, couplers and drivers. What joints, couplers and drivers are put together of, with what each
!> is in the first guess. Floor: multibody. Source: doc/theory, eqs. (3.7), (3.9), (3.14)-(3.16).
module limber_multibody_function_sums
   use limber_base_kinds, only: wp
   use limber_model_model, only: joint_type, term_type, ground, coordinate_angle, coordinate_joint_angle
   use limber_multibody_function_constraints, only: function_constraint_type, linear_type, most_vectors
   use limber_multibody_marker_registry, only: registry_type, marker_of, direction_of, frame_direction, angle_of, guessed_angle, &
      & guessed_turn, guessed_position
   use limber_multibody_scalar_functions, only: scalar_function_type, scalar_component, scalar_along, scalar_cross, &
      & scalar_distance, scalar_turn, scalar_slope
   implicit none
   private
   public :: add_coordinate, add_section_angle, add_displacement, add_parallel, add_component, add_distance, add_scalar, &
      & take_functions, find_bodies, guessed_distance, guessed_place

contains

   !> Adds the term of a joint coordinate, and what it is in the first guess to a sum.
   subroutine add_coordinate(system, item, term, sum)
      class(registry_type), intent(inout) :: system
      type(linear_type), intent(inout) :: item
      type(term_type), intent(in) :: term
      real(wp), intent(inout) :: sum
      integer :: direction
      select case (term%kind)
      case (coordinate_angle)
         direction = frame_direction(system, term%of, 0.0_wp)
         call add_scalar(item, scalar_function_type(kind=scalar_turn, markers=[direction, 0, 0], &
            & angles=[angle_of(system, 0, direction), 0]), term%coefficient, 1)
         sum = sum + term%coefficient*guessed_turn(system, term%of)
      case (coordinate_joint_angle)
         associate (points => system%model%joints(term%of)%points)
            call add_section_angle(system, item, points(1), term%coefficient, sum)
            call add_section_angle(system, item, points(2), -term%coefficient, sum)
         end associate
      case default
         associate (joint => system%model%joints(term%of))
            sum = sum + term%coefficient*guessed_place(system, joint%points, joint%angle)
         end associate
         call add_displacement(system, item, system%model%joints(term%of), system%model%joints(term%of)%angle, term%coefficient)
      end select
   end subroutine add_coordinate

   !> Adds the followed angle of a section; nothing of the ground.
   subroutine add_section_angle(system, item, point, coefficient, sum)
      class(registry_type), intent(inout) :: system
      type(linear_type), intent(inout) :: item
      integer, intent(in) :: point
      real(wp), intent(in) :: coefficient
      !> Receives the term's value in the first guess
      real(wp), intent(inout) :: sum
      integer :: direction
      if (system%model%points(point)%body == ground) return
      direction = direction_of(system, point, 0.0_wp)
      call add_scalar(item, scalar_function_type(kind=scalar_turn, markers=[direction, 0, 0], &
         & angles=[angle_of(system, 0, direction), 0]), coefficient, 1)
      sum = sum + coefficient*guessed_angle(system, 0, direction)
   end subroutine add_section_angle

   !> Adds the place of the first point of a joint along a line through the second, at an angle in the second section.
   subroutine add_displacement(system, item, joint, angle, coefficient)
      class(registry_type), intent(inout) :: system
      type(linear_type), intent(inout) :: item
      type(joint_type), intent(in) :: joint
      real(wp), intent(in) :: angle, coefficient
      integer :: markers(3)
      markers(1) = marker_of(system, joint%points(1))
      markers(2) = marker_of(system, joint%points(2))
      markers(3) = direction_of(system, joint%points(2), angle)
      call add_scalar(item, scalar_function_type(kind=scalar_along, markers=markers), coefficient, 1)
   end subroutine add_displacement

   !> Adds the equation that a section of the first body has a given angle from that of the second: of lengths.
   subroutine add_parallel(system, item, joint, row)
      class(registry_type), intent(inout) :: system
      type(linear_type), intent(inout) :: item
      type(joint_type), intent(in) :: joint
      integer, intent(in) :: row
      real(wp) :: angle
      integer :: first, second
      first = direction_of(system, joint%points(1), 0.0_wp)
      angle = joint%turn
      if (.not. joint%has_turn) angle = guessed_angle(system, 0, first) - guessed_section(system, joint%points(2))
      second = direction_of(system, joint%points(2), angle)
      call add_scalar(item, scalar_function_type(kind=scalar_cross, markers=[second, first, 0]), system%model%length, row)
      call add_slope(system, item, joint%points(1), system%model%length, row)
      call add_slope(system, item, joint%points(2), -system%model%length, row)
   end subroutine add_parallel

   !> Adds what the angle of a section of a beam is more than that of its direction (1, slope) in the frame, to third order.
   subroutine add_slope(system, item, point, coefficient, row)
      class(registry_type), intent(inout) :: system
      type(linear_type), intent(inout) :: item
      integer, intent(in) :: point, row
      real(wp), intent(in) :: coefficient
      integer :: markers(3), body
      body = system%model%points(point)%body
      if (body == ground) return
      if (system%model%points(point)%exact .or. .not. any(abs(system%model%points(point)%psi) > 0.0_wp)) return
      markers(1) = frame_direction(system, body, 0.0_wp)
      markers(2) = direction_of(system, point, 0.0_wp)
      markers(3) = 0
      call add_scalar(item, scalar_function_type(kind=scalar_slope, markers=markers), coefficient/3, row)
   end subroutine add_slope

   !> Adds the distance along an axis of space from the second point to the first; without the second (0), from the origin.
   subroutine add_component(system, item, points, axis, row)
      class(registry_type), intent(inout) :: system
      type(linear_type), intent(inout) :: item
      integer, intent(in) :: points(2), row
      real(wp), intent(in) :: axis(2)
      integer :: markers(3)
      markers = 0
      markers(1) = marker_of(system, points(1))
      if (points(2) > 0) markers(2) = marker_of(system, points(2))
      call add_scalar(item, scalar_function_type(kind=scalar_component, markers=markers, axis=axis), 1.0_wp, row)
   end subroutine add_component

   subroutine add_distance(system, item, points, row)
      class(registry_type), intent(inout) :: system
      type(linear_type), intent(inout) :: item
      integer, intent(in) :: points(2), row
      integer :: markers(3)
      markers(1) = marker_of(system, points(1))
      markers(2) = marker_of(system, points(2))
      markers(3) = 0
      call add_scalar(item, scalar_function_type(kind=scalar_distance, markers=markers), 1.0_wp, row)
   end subroutine add_distance

   !> Adds a scalar function with its coefficient in one row; its markers become vectors of the constraint.
   subroutine add_scalar(item, scalar, coefficient, row)
      type(linear_type), intent(inout) :: item
      type(scalar_function_type), intent(in) :: scalar
      real(wp), intent(in) :: coefficient
      integer, intent(in) :: row
      integer :: j
      item%count = item%count + 1
      item%functions(item%count) = scalar
      do j = 1, 3
         item%functions(item%count)%vectors(j) = 0
         if (scalar%markers(j) > 0) item%functions(item%count)%vectors(j) = vector(item, scalar%markers(j))
      end do
      item%coefficients(row, item%count) = coefficient
      item%rows = max(item%rows, row)
   end subroutine add_scalar

   !> Place of a marker among the vectors of a constraint; a new one if it is not there yet.
   integer function vector(item, marker)
      type(linear_type), intent(inout) :: item
      integer, intent(in) :: marker
      do vector = 1, item%vectors
         if (item%markers(vector) == marker) return
      end do
      item%vectors = vector
      if (vector <= most_vectors) item%markers(vector) = marker
   end function vector

   !> The scalar functions of one constraint for another.
   subroutine take_functions(from, to)
      type(linear_type), intent(in) :: from
      class(function_constraint_type), intent(inout) :: to
      to%rows = 1
      to%vectors = from%vectors
      to%markers = from%markers
      to%count = from%count
      to%functions = from%functions
   end subroutine take_functions

   !> The bodies of a constraint, from its vectors.
   subroutine find_bodies(system, item)
      class(registry_type), intent(in) :: system
      type(linear_type), intent(inout) :: item
      integer :: j, body
      item%bodies = ground
      do j = 1, item%vectors
         body = system%model%points(system%marker_points(item%markers(j)))%body
         if (body == ground .or. any(item%bodies == body)) cycle
         if (item%bodies(1) == ground) then
            item%bodies(1) = body
         else
            item%bodies(2) = body
         end if
      end do
   end subroutine find_bodies

   !> Angle of an undeformed section in the first guess, at a point of a frame of exact beams that of the frame; nought of the
   !> ground and of a point mass.
   real(wp) function guessed_section(system, point) result(angle)
      class(registry_type), intent(in) :: system
      integer, intent(in) :: point
      angle = 0.0_wp
      associate (body => system%model%points(point)%body)
         if (body == ground) return
         if (system%layout%framed(body)) angle = guessed_turn(system, body) - system%model%points(point)%lean
      end associate
   end function guessed_section

   !> Distance of two points in the first guess.
   real(wp) function guessed_distance(system, points) result(distance)
      class(registry_type), intent(in) :: system
      integer, intent(in) :: points(2)
      distance = norm2(guessed_position(system, system%model%points(points(1))) &
         & - guessed_position(system, system%model%points(points(2))))
   end function guessed_distance

   !> Place of the first point along a line through the second, at an angle in the second section, in the first guess.
   real(wp) function guessed_place(system, points, angle) result(place)
      class(registry_type), intent(in) :: system
      integer, intent(in) :: points(2)
      real(wp), intent(in) :: angle
      real(wp) :: whole
      whole = angle + guessed_section(system, points(2))
      place = dot_product([cos(whole), sin(whole)], guessed_position(system, system%model%points(points(1))) &
         & - guessed_position(system, system%model%points(points(2))))
   end function guessed_place

end module limber_multibody_function_sums
