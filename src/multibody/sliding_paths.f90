!> Paths along exact beams from the joints of the model, for what takes the coordinate along such a beam: joints, drivers, couplers
!> and loads. Floor: multibody. Source: doc/theory, eqs. (3.25)-(3.27).
module limber_multibody_sliding_paths
   use limber_base_kinds, only: wp
   use limber_model_model, only: joint_type, joint_sliding
   use limber_multibody_function_constraints, only: linear_type
   use limber_multibody_function_sums, only: add_measure, vector, take_measures
   use limber_multibody_joint_functions, only: joint_function_type, measure_along
   use limber_multibody_marker_registry, only: registry_type, marker_of, frame_marker, frame_direction, bend_of, guessed_position, &
      & guessed_turn
   use limber_multibody_plane_vectors, only: cross
   use limber_multibody_sliding_along_beam, only: exact_path_type, set_axis, foot_of
   implicit none
   private
   public :: find_axes, new_path, guessed_coordinate, slides_exactly

   real(wp), parameter :: right_angle = 0.5_wp*acos(-1.0_wp)

contains

   !> Whether the point of a joint slides along an exact beam.
   pure logical function slides_exactly(system, joint) result(slides)
      class(registry_type), intent(in) :: system
      type(joint_type), intent(in) :: joint
      slides = joint%kind == joint_sliding
      if (slides) slides = system%model%bodies(system%model%points(joint%points(2))%body)%reduced%is_exact
   end function slides_exactly

   !> The place of the first point of a joint along the axes of the frame of the second one's body.
   subroutine find_axes(system, joint, axes)
      class(registry_type), intent(inout) :: system
      type(joint_type), intent(in) :: joint
      type(linear_type), intent(inout) :: axes
      integer :: markers(2), side, direction, body
      body = system%model%points(joint%points(2))%body
      markers = [marker_of(system, joint%points(1)), 0]
      markers(2) = frame_marker(system, body)
      do side = 1, 2
         direction = frame_direction(system, body, (side - 1)*right_angle)
         call add_measure(axes, joint_function_type(kind=measure_along, &
            & vectors=[vector(axes, markers(1)), vector(axes, markers(2)), vector(axes, direction)]), 1.0_wp, 1)
      end do
   end subroutine find_axes

   !> The constraint of a point that slides along an exact beam.
   function new_path(system, joint) result(path)
      class(registry_type), intent(inout) :: system
      type(joint_type), intent(in) :: joint
      type(exact_path_type) :: path
      type(linear_type) :: axes
      integer :: body
      body = system%model%points(joint%points(2))%body
      call find_axes(system, joint, axes)
      call take_measures(axes, path)
      path%start = system%model%points(joint%points(2))%along
      path%bend = bend_of(system, body)
      path%bodies = [system%model%points(joint%points(1))%body, body]
      path%points = joint%points
      call set_axis(path, system%model%bodies(body)%reduced%exact)
   end function new_path

   !> Coordinate of the first point of a joint along the beam from the second one, in the first guess.
   real(wp) function guessed_coordinate(system, joint, path) result(s)
      class(registry_type), intent(in) :: system
      type(joint_type), intent(in) :: joint
      type(exact_path_type), intent(in) :: path
      real(wp) :: arm(2), u(2), rest(path%exact%n), angle
      rest = 0.0_wp
      associate (body => system%model%points(joint%points(2))%body)
         arm = guessed_position(system, system%model%points(joint%points(1))) - system%model%bodies(body)%position
         angle = guessed_turn(system, body)
      end associate
      u = [cos(angle), sin(angle)]
      s = foot_of(path, [dot_product(u, arm), cross(u, arm)], rest) - path%start
   end function guessed_coordinate

end module limber_multibody_sliding_paths
