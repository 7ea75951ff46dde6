!> Position, velocity and acceleration of a point at any state. For the tree of what hangs or is driven, and for results. Floor:
!> multibody. Source: doc/theory, eqs. (1.4)-(1.7), (2.42).
module limber_multibody_point_motion
   use limber_base_kinds, only: wp
   use limber_model_model, only: model_type, point_type, ground
   use limber_multibody_plane_vectors, only: along
   use limber_multibody_beam_place, only: find_place, follow_place
   use limber_multibody_layout, only: layout_type
   implicit none
   private
   public :: point_position, point_velocity, point_acceleration

contains

   !> Position of any point of the model at the coordinates q (2).
   pure function point_position(model, layout, point, q) result(position)
      type(model_type), intent(in) :: model
      type(layout_type), intent(in) :: layout
      type(point_type), intent(in) :: point
      !> Coordinates (nq)
      real(wp), intent(in) :: q(:)
      real(wp) :: position(2), p(2)
      integer :: first, k
      position = point%p0
      if (point%body == ground) return
      first = layout%q(point%body)
      position = q(first:first + 1)
      if (.not. layout%framed(point%body)) return
      p = point%p0
      if (point%exact) then
         call find_place(model%bodies(point%body)%reduced%exact, point%reach, q(first + 4:first + 3 + layout%n(point%body)), p)
      else
         do k = 1, layout%n(point%body)
            p = p + point%phi(:, k)*q(first + 3 + k)
         end do
      end if
      position = position + along(p, q(first + 2:first + 3))
   end function point_position

   !> Velocity of any point of the model (2).
   pure function point_velocity(model, layout, point, q, v) result(velocity)
      type(model_type), intent(in) :: model
      type(layout_type), intent(in) :: layout
      type(point_type), intent(in) :: point
      !> Coordinates and velocities (nq)
      real(wp), intent(in) :: q(:), v(:)
      real(wp) :: velocity(2), p(2), drift(2), push(2)
      integer :: first, last, k
      velocity = 0.0_wp
      if (point%body == ground) return
      first = layout%q(point%body)
      velocity = v(first:first + 1)
      if (.not. layout%framed(point%body)) return
      p = point%p0
      drift = 0.0_wp
      if (point%exact) then
         last = first + 3 + layout%n(point%body)
         call follow_place(model%bodies(point%body)%reduced%exact, point%reach, q(first + 4:last), p, drift, push, &
            & v(first + 4:last))
      else
         do k = 1, layout%n(point%body)
            p = p + point%phi(:, k)*q(first + 3 + k)
            drift = drift + point%phi(:, k)*v(first + 3 + k)
         end do
      end if
      velocity = velocity + along(p, v(first + 2:first + 3)) + along(drift, q(first + 2:first + 3))
   end function point_velocity

   !> Acceleration of any point of the model (2).
   pure function point_acceleration(model, layout, point, q, v, a) result(acceleration)
      type(model_type), intent(in) :: model
      type(layout_type), intent(in) :: layout
      type(point_type), intent(in) :: point
      !> Coordinates, velocities and accelerations (nq)
      real(wp), intent(in) :: q(:), v(:), a(:)
      real(wp) :: acceleration(2), p(2), drift(2), push(2)
      integer :: first, last, k
      acceleration = 0.0_wp
      if (point%body == ground) return
      first = layout%q(point%body)
      acceleration = a(first:first + 1)
      if (.not. layout%framed(point%body)) return
      p = point%p0
      drift = 0.0_wp
      push = 0.0_wp
      if (point%exact) then
         last = first + 3 + layout%n(point%body)
         call follow_place(model%bodies(point%body)%reduced%exact, point%reach, q(first + 4:last), p, drift, push, &
            & v(first + 4:last), a(first + 4:last))
      else
         do k = 1, layout%n(point%body)
            p = p + point%phi(:, k)*q(first + 3 + k)
            drift = drift + point%phi(:, k)*v(first + 3 + k)
            push = push + point%phi(:, k)*a(first + 3 + k)
         end do
      end if
      acceleration = acceleration + along(p, a(first + 2:first + 3)) + along(push, q(first + 2:first + 3)) &
         & + 2*along(drift, v(first + 2:first + 3))
   end function point_acceleration

end module limber_multibody_point_motion
