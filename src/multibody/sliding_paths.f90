!> Points that slide along beams, from the joints of the model, for what takes the coordinate along a beam: joints, drivers and
!> couplers. Floor: multibody. Source: doc/theory, eqs. (3.21)-(3.27).
module limber_multibody_sliding_paths
   use limber_base_kinds, only: wp
   use limber_model_model, only: place_on_beam, joint_type
   use limber_multibody_beam_path, only: beam_path_type
   use limber_multibody_function_constraints, only: linear_type
   use limber_multibody_function_sums, only: add_scalar, take_functions
   use limber_multibody_marker_registry, only: registry_type, marker_of, frame_marker, frame_direction, bend_of, guessed_position, &
      & guessed_turn
   use limber_multibody_path_constraints, only: sliding_type, set_line
   use limber_multibody_plane_vectors, only: cross
   use limber_multibody_scalar_functions, only: scalar_function_type, scalar_along
   use limber_multibody_sliding_along_beam, only: exact_path_type, set_axis
   implicit none
   private
   public :: new_path, new_coordinate, slides

   real(wp), parameter :: right_angle = 0.5_wp*acos(-1.0_wp)

contains

   !> Whether the point of a joint slides along a beam.
   pure logical function slides(joint)
      type(joint_type), intent(in) :: joint
      slides = joint%place == place_on_beam
   end function slides

   !> A point stays on the line of a deforming beam; the second point names the beam, and where its coordinate is counted from.
   subroutine new_path(system, joint, path)
      class(registry_type), intent(inout) :: system
      type(joint_type), intent(in) :: joint
      class(beam_path_type), allocatable, intent(out) :: path
      type(exact_path_type) :: exact
      type(sliding_type) :: line
      type(linear_type) :: axes
      integer :: markers(3), side, body
      body = system%model%points(joint%points(2))%body
      markers(1) = marker_of(system, joint%points(1))
      markers(2) = frame_marker(system, body)
      do side = 1, 2
         markers(3) = frame_direction(system, body, (side - 1)*right_angle)
         call add_scalar(axes, scalar_function_type(kind=scalar_along, markers=markers), 1.0_wp, 1)
      end do
      if (system%model%bodies(body)%reduced%is_exact) then
         call set_axis(exact, system%model%bodies(body)%reduced%exact)
         allocate (path, source=exact)
      else
         call set_line(line, system%model%bodies(body)%field, system%model%bodies(body)%choice%origin)
         allocate (path, source=line)
      end if
      call take_functions(axes, path)
      if (system%layout%n(body) > 0) path%bend = bend_of(system, body)
      path%start = system%model%points(joint%points(2))%along
      path%bodies = [system%model%points(joint%points(1))%body, body]
      path%points = joint%points
   end subroutine new_path

   !> The coordinate along the beam from the second point of a joint to the first, times a factor.
   subroutine new_coordinate(system, joint, factor, path, guess)
      class(registry_type), intent(inout) :: system
      type(joint_type), intent(in) :: joint
      real(wp), intent(in) :: factor
      class(beam_path_type), allocatable, intent(out) :: path
      !> Its value in the first guess
      real(wp), intent(out) :: guess
      real(wp) :: arm(2), u(2), angle, speed
      real(wp), allocatable :: z(:)
      call new_path(system, joint, path)
      path%of_coordinate = .true.
      path%factor = factor
      path%offset = factor*path%start
      associate (body => path%bodies(2))
         arm = guessed_position(system, system%model%points(joint%points(1))) - system%model%bodies(body)%position
         angle = guessed_turn(system, body)
         allocate (z(2 + system%layout%n(body)), source=0.0_wp)
      end associate
      u = [cos(angle), sin(angle)]
      z(1:2) = [dot_product(u, arm), cross(u, arm)]
      call path%coordinate(z, 0*z, guess, speed)
      guess = factor*guess - path%offset
   end subroutine new_coordinate

end module limber_multibody_sliding_paths
