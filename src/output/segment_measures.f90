!> Channels of a beam in segments as a whole. Its frame, from which deflections count, and displacements and rotations of its
!> points. The frame is the section at the start if the beam is clamped there, else it lies along the chord through its ends, as the
!> frame of an undivided beam does. Floor: output. Source: doc/theory, eq. (2.61).
module limber_output_segment_measures
   use limber_base_kinds, only: wp
   use limber_beam_exact_beam, only: angles_at, lean_at
   use limber_multibody_plane_vectors, only: cross
   use limber_multibody_point_motion, only: point_position, point_velocity
   use limber_multibody_system, only: system_type
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

   !> Rotation of the section at a point of a beam in segments within the whole beam's frame [rad]: of the first piece less than
   !> half a turn, from piece to piece by what the one before is bent, for they are welded.
   pure real(wp) function whole_rotation(system, point, q) result(angle)
      type(system_type), intent(in) :: system
      integer, intent(in) :: point
      real(wp), intent(in) :: q(:)
      real(wp) :: slope, before(2), here(2)
      real(wp), parameter :: whole_turn = 2*acos(-1.0_wp)
      integer :: body, first
      associate (own => system%model%points(point))
         before = whole_direction(system, system%model%bodies(own%body)%whole, q)
         angle = 0.0_wp
         associate (whole => system%model%wholes(system%model%bodies(own%body)%whole))
            if (allocated(whole%lean)) then
               first = system%layout%q(own%body) + 2
               before = turned(before, whole%lean(own%body - whole%first + 1))
               here = q(first:first + 1)
               first = system%layout%q(own%body) + 4
               angle = atan2(cross(before, here), dot_product(before, here)) + dot_product(own%psi, &
                  & q(first:first + size(own%psi) - 1))
               return
            end if
         end associate
         do body = system%model%wholes(system%model%bodies(own%body)%whole)%first, own%body
            first = system%layout%q(body) + 2
            here = q(first:first + 1)
            slope = atan2(cross(before, here), dot_product(before, here))
            if (body > system%model%wholes(system%model%bodies(own%body)%whole)%first) &
               & slope = slope + whole_turn*anint((end_angle(system, body - 1, q, slope) - slope)/whole_turn)
            angle = angle + slope
            before = here
         end do
         first = system%layout%q(own%body) + 4
         slope = dot_product(own%psi, q(first:first + size(own%psi) - 1))
         angle = angle + slope
      end associate
   end function whole_rotation

   !> Angle of the section at the end of a piece in its frame, which is the section at its start, if it is an exact beam [rad].
   pure real(wp) function end_angle(system, body, q, otherwise) result(angle)
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      real(wp), intent(in) :: q(:)
      !> Of other pieces, which bend little [rad]
      real(wp), intent(in) :: otherwise
      integer :: first
      angle = otherwise
      if (.not. system%model%bodies(body)%reduced%is_exact) return
      first = system%layout%q(body) + 4
      associate (exact => system%model%bodies(body)%reduced%exact)
         angle = lean_at(exact, exact%total) + dot_product(angles_at(exact, exact%total), q(first:first + exact%angles - 1))
      end associate
   end function end_angle

   !> A vector turned by an angle [rad].
   pure function turned(vector, angle)
      real(wp), intent(in) :: vector(2), angle
      real(wp) :: turned(2)
      turned = cos(angle)*vector + sin(angle)*[-vector(2), vector(1)]
   end function turned

end module limber_output_segment_measures
