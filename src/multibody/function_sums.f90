!> Sums of scalar functions for joints, couplers and drivers. What joints, couplers and drivers are put together of, with what each
!> is in the first guess. Floor: multibody. Source: doc/theory, eqs. (3.7), (3.9), (3.14)-(3.16).
module limber_multibody_function_sums
   use limber_base_kinds, only: wp
   use limber_model_model, only: joint_type, term_type, ground, coordinate_angle, coordinate_joint_angle
   use limber_multibody_function_constraints, only: function_constraint_type, linear_type, most_vectors
   use limber_multibody_joint_functions, only: joint_function_type, measure_component, measure_along, measure_cross, &
      & measure_distance, &
      & measure_angle, measure_slope
   use limber_multibody_marker_registry, only: registry_type, marker_of, direction_of, frame_direction, angle_of, guessed_angle, &
      & guessed_turn, guessed_position
   implicit none
   private
   public :: add_coordinate, add_section_angle, add_displacement, add_parallel, add_component, add_distance, add_measure, vector, &
      & take_measures, find_bodies, guessed_distance, guessed_place

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
         call add_measure(item, joint_function_type(kind=measure_angle, vectors=[vector(item, direction), 0, 0], &
            & angle=angle_of(system, 0, direction)), term%coefficient, 1)
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
      call add_measure(item, joint_function_type(kind=measure_angle, vectors=[vector(item, direction), 0, 0], &
         & angle=angle_of(system, 0, direction)), coefficient, 1)
      sum = sum + coefficient*guessed_angle(system, 0, direction)
   end subroutine add_section_angle

   !> Adds the place of the first point of a joint along a line through the second, at an angle in the second section. Measures
   !> of one kind stand in one row each, unless the row is given.
   subroutine add_displacement(system, item, joint, angle, coefficient)
      class(registry_type), intent(inout) :: system
      type(linear_type), intent(inout) :: item
      type(joint_type), intent(in) :: joint
      real(wp), intent(in) :: angle, coefficient
      integer :: vectors(3)
      vectors(1) = vector(item, marker_of(system, joint%points(1)))
      vectors(2) = vector(item, marker_of(system, joint%points(2)))
      vectors(3) = vector(item, direction_of(system, joint%points(2), angle))
      call add_measure(item, joint_function_type(kind=measure_along, vectors=vectors), coefficient, 1)
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
      call add_measure(item, joint_function_type(kind=measure_cross, vectors=[vector(item, second), vector(item, first), 0]), &
         & system%model%length, row)
      call add_slope(system, item, joint%points(1), system%model%length, row)
      call add_slope(system, item, joint%points(2), -system%model%length, row)
   end subroutine add_parallel

   !> Adds what the angle of a section of a beam is more than that of its direction (1, slope) in the frame, to third order.
   subroutine add_slope(system, item, point, coefficient, row)
      class(registry_type), intent(inout) :: system
      type(linear_type), intent(inout) :: item
      integer, intent(in) :: point, row
      real(wp), intent(in) :: coefficient
      integer :: vectors(3), body
      body = system%model%points(point)%body
      if (body == ground) return
      if (system%model%points(point)%exact .or. .not. any(abs(system%model%points(point)%psi) > 0.0_wp)) return
      vectors = 0
      vectors(1) = vector(item, frame_direction(system, body, 0.0_wp))
      vectors(2) = vector(item, direction_of(system, point, 0.0_wp))
      call add_measure(item, joint_function_type(kind=measure_slope, vectors=vectors), &
         & coefficient/3, row)
   end subroutine add_slope

   !> Adds the distance along an axis of space from the second point to the first; without the second (0), from the origin.
   subroutine add_component(system, item, points, axis, row)
      class(registry_type), intent(inout) :: system
      type(linear_type), intent(inout) :: item
      integer, intent(in) :: points(2), row
      real(wp), intent(in) :: axis(2)
      integer :: vectors(3)
      vectors = 0
      vectors(1) = vector(item, marker_of(system, points(1)))
      if (points(2) > 0) vectors(2) = vector(item, marker_of(system, points(2)))
      call add_measure(item, joint_function_type(kind=measure_component, vectors=vectors, axis=axis), 1.0_wp, row)
   end subroutine add_component

   subroutine add_distance(system, item, points, row)
      class(registry_type), intent(inout) :: system
      type(linear_type), intent(inout) :: item
      integer, intent(in) :: points(2), row
      integer :: vectors(3)
      vectors = 0
      vectors(1) = vector(item, marker_of(system, points(1)))
      vectors(2) = vector(item, marker_of(system, points(2)))
      call add_measure(item, joint_function_type(kind=measure_distance, vectors=vectors), 1.0_wp, row)
   end subroutine add_distance

   !> Adds a measure with its coefficient in one row.
   subroutine add_measure(item, measure, coefficient, row)
      type(linear_type), intent(inout) :: item
      type(joint_function_type), intent(in) :: measure
      real(wp), intent(in) :: coefficient
      integer, intent(in) :: row
      item%count = item%count + 1
      item%measures(item%count) = measure
      item%coefficients(row, item%count) = coefficient
      item%rows = max(item%rows, row)
   end subroutine add_measure

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

   !> The measures of one constraint for another.
   subroutine take_measures(from, to)
      type(linear_type), intent(in) :: from
      class(function_constraint_type), intent(inout) :: to
      to%rows = 1
      to%vectors = from%vectors
      to%markers = from%markers
      to%count = from%count
      to%measures = from%measures
   end subroutine take_measures

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

   !> Angle of an undeformed section in the first guess, at a point of a frame of exact beams that of the frame; nought of the ground
   !> and of a point mass.
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
