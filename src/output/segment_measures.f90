!> Channels of a beam in segments as a whole. Its frame, from which deflections count, and displacements and rotations of its
!> points. The frame is the section at the start if the beam is clamped there, else it lies along the chord through its ends, as the
!> frame of an undivided beam does. Floor: output. Source: doc/theory, eq. (2.61).
module limber_output_segment_measures
   use limber_base_kinds, only: wp
   use limber_multibody_plane_vectors, only: cross
   use limber_multibody_point_motion, only: point_position, point_velocity
   use limber_multibody_system, only: system_type
   use limber_output_followed_turns, only: turns_type, turned_angle
   implicit none
   private
   public :: whole_direction, whole_spin, whole_displacement, whole_rotation

contains

   !> Direction of the frame of a whole beam (2), of unit length.
   pure function whole_direction(system, whole, q) result(direction)
      type(system_type), intent(in) :: system
      !> Index of the whole
      integer, intent(in) :: whole
      !> Coordinates (nq)
      real(wp), intent(in) :: q(:)
      real(wp) :: direction(2)
      integer :: first
      first = system%layout%q(system%model%wholes(whole)%first) + 2
      direction = q(first:first + 1)
      if (allocated(system%model%wholes(whole)%lean)) then
         direction = turned(direction, -system%model%wholes(whole)%lean(1))
      else if (.not. system%model%wholes(whole)%clamped) then
         direction = chord(system, whole, q)
      end if
      direction = direction/norm2(direction)
   end function whole_direction

   !> Its angular velocity.
   pure real(wp) function whole_spin(system, whole, q, v) result(spin)
      type(system_type), intent(in) :: system
      integer, intent(in) :: whole
      !> Coordinates and velocities (nq)
      real(wp), intent(in) :: q(:), v(:)
      real(wp) :: along(2), rate(2)
      integer :: first
      associate (own => system%model%bodies(system%model%wholes(whole)%first), points => system%model%points)
         if (system%model%wholes(whole)%clamped .or. allocated(system%model%wholes(whole)%lean)) then
            first = system%layout%q(system%model%wholes(whole)%first) + 2
            spin = cross(q(first:first + 1), v(first:first + 1))
         else
            along = chord(system, whole, q)
            rate = point_velocity(system%model, system%layout, points(own%end_point), q, v) &
               & - point_velocity(system%model, system%layout, points(own%start_point), q, v)
            spin = cross(along, rate)/dot_product(along, along)
         end if
      end associate
   end function whole_spin

   !> From the start of a whole beam to its end (2) [length].
   pure function chord(system, whole, q)
      type(system_type), intent(in) :: system
      integer, intent(in) :: whole
      real(wp), intent(in) :: q(:)
      real(wp) :: chord(2)
      associate (own => system%model%bodies(system%model%wholes(whole)%first), points => system%model%points)
         chord = point_position(system%model, system%layout, points(own%end_point), q) - point_position(system%model, &
            & system%layout, points(own%start_point), q)
      end associate
   end function chord

   !> Displacement of a point of a beam in segments from its undeformed place, along the axes of the whole beam's frame (2), eqs.
   !> (2.16), (2.61).
   pure function whole_displacement(system, point, q) result(displacement)
      type(system_type), intent(in) :: system
      !> Index of the point
      integer, intent(in) :: point
      real(wp), intent(in) :: q(:)
      real(wp) :: displacement(2), direction(2), arm(2)
      integer :: piece
      associate (own => system%model%points(point), points => system%model%points)
         associate (body => system%model%bodies(own%body))
            direction = whole_direction(system, body%whole, q)
            arm = point_position(system%model, system%layout, own, q) - point_position(system%model, system%layout, &
               & points(body%start_point), q)
            piece = own%body - system%model%wholes(body%whole)%first
            displacement = [dot_product(direction, arm) - (own%along + piece*body%beam%length), cross(direction, arm)]
            associate (whole => system%model%wholes(body%whole))
               if (.not. allocated(whole%lean)) return
               arm = point_position(system%model, system%layout, own, q) - point_position(system%model, system%layout, &
                  & points(system%model%bodies(whole%first)%start_point), q)
               displacement = [dot_product(direction, arm), cross(direction, arm)] - whole%place(:, piece + 1) + whole%place(:, 1) &
                  & - own%along*[cos(whole%lean(piece + 1)), sin(whole%lean(piece + 1))]
            end associate
         end associate
      end associate
   end function whole_displacement

   !> Rotation of the section at a point of a beam in segments or a large frame within the frame of the whole [rad]: of the first
   !> piece less than half a turn, of the others with the turns that they have made beside it.
   pure real(wp) function whole_rotation(turns, system, point, t, q) result(angle)
      type(turns_type), intent(in) :: turns
      type(system_type), intent(in) :: system
      integer, intent(in) :: point
      real(wp), intent(in) :: t, q(:)
      real(wp) :: direction(2), here(2)
      integer :: first, own
      own = system%model%points(point)%body
      associate (whole => system%model%wholes(system%model%bodies(own)%whole))
         first = system%layout%q(whole%first) + 2
         here = q(first:first + 1)
         direction = whole_direction(system, system%model%bodies(own)%whole, q)
         angle = atan2(cross(direction, here), dot_product(direction, here))
         if (allocated(whole%lean)) angle = whole%lean(1) - whole%lean(own - whole%first + 1)
         if (own /= whole%first) then
            angle = angle - turned_angle(turns, system, whole%first, t, here)
            first = system%layout%q(own) + 2
            angle = angle + turned_angle(turns, system, own, t, q(first:first + 1))
         end if
      end associate
      first = system%layout%q(own) + 4
      angle = angle + dot_product(system%model%points(point)%psi, q(first:first + size(system%model%points(point)%psi) - 1))
   end function whole_rotation

   !> A vector turned by an angle [rad].
   pure function turned(vector, angle)
      real(wp), intent(in) :: vector(2), angle
      real(wp) :: turned(2)
      turned = cos(angle)*vector + sin(angle)*[-vector(2), vector(1)]
   end function turned

end module limber_output_segment_measures
