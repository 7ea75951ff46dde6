!> Places of a drawing at an instant. Those of a body from the undeformed body, those of a beam in segments from the undeformed
!> beam. Floor: output. Source: doc/theory, eqs. (6.23), (6.24).
module limber_output_drawn_posture
   use limber_base_kinds, only: wp
   use limber_output_motion_record, only: geometry_type, deflections
   implicit none
   private
   public :: place_all

contains

   !> Where all places are: eq. (6.24).
   pure subroutine place_all(geometry, coordinates, factor, positions)
      type(geometry_type), intent(in) :: geometry
      !> Coordinates at an instant (k)
      real(wp), intent(in) :: coordinates(:)
      !> Factor of the deflections from the undeformed body that has its two connected places where they are; from the frame if
      !> none is connected, from the frame moved to that place if one is
      real(wp), intent(in) :: factor
      !> (2, places) [length]
      real(wp), intent(out) :: positions(:, :)
      real(wp) :: ends(2, 2), still(2)
      integer :: i, body, own, anchor
      own = -1
      do i = 1, size(positions, 2)
         associate (g => geometry)
            body = g%place_bodies(i)
            positions(:, i) = in_space(g, coordinates, body, bent(g, coordinates, i))
            if (body == 0) cycle
            if (g%root(body) > 0) body = g%root(body)
            if (g%root(body) == 0 .and. deflections(g, body) == 0) cycle
            if (body /= own) then
               own = body
               do anchor = 1, 2
                  if (g%anchors(anchor, body) > 0) ends(:, anchor) = in_space(g, coordinates, &
                     & g%place_bodies(g%anchors(anchor, body)), bent(g, coordinates, g%anchors(anchor, body)))
               end do
            end if
            still = undeformed(g, coordinates, body, ends, i)
            positions(:, i) = still + factor*(positions(:, i) - still)
         end associate
      end do
   end subroutine place_all

   !> A place on the deformed body, in the body's frame (2).
   pure function bent(geometry, coordinates, place) result(p)
      type(geometry_type), intent(in) :: geometry
      real(wp), intent(in) :: coordinates(:)
      integer, intent(in) :: place
      real(wp) :: p(2)
      integer :: k, body
      body = geometry%place_bodies(place)
      p = geometry%places(:, place)
      do k = 1, deflections(geometry, body)
         associate (from => geometry%first_shape(place) + 2*(k - 1))
            p = p + geometry%shapes(from:from + 1)*coordinates(geometry%first(body) + 3 + k)
         end associate
      end do
   end function bent

   !> A place on the undeformed body, in space, that is moved, turned and stretched so that its anchors are where `ends` says (2):
   !> eq. (6.23).
   pure function undeformed(geometry, coordinates, body, ends, place) result(p)
      type(geometry_type), intent(in) :: geometry
      real(wp), intent(in) :: coordinates(:)
      !> The body, or the first piece of the beam
      integer, intent(in) :: body
      real(wp), intent(in) :: ends(2, 2)
      integer, intent(in) :: place
      real(wp) :: p(2)
      complex(wp) :: arm
      associate (anchors => geometry%anchors(:, body), unbent => geometry%unbent)
         if (anchors(1) == 0) then
            p = in_space(geometry, coordinates, body, unbent(:, place))
         else if (anchors(2) == 0) then
            p = ends(:, 1) + in_space(geometry, coordinates, body, unbent(:, place)) &
               & - in_space(geometry, coordinates, body, unbent(:, anchors(1)))
         else
            arm = as_complex(ends(:, 2) - ends(:, 1))/as_complex(unbent(:, anchors(2)) - unbent(:, anchors(1)))
            arm = arm*as_complex(unbent(:, place) - unbent(:, anchors(1)))
            p = ends(:, 1) + [real(arm, wp), aimag(arm)]
         end if
      end associate
   end function undeformed

   pure complex(wp) function as_complex(p)
      real(wp), intent(in) :: p(2)
      as_complex = cmplx(p(1), p(2), wp)
   end function as_complex

   !> A place in a body's frame, in space (2).
   pure function in_space(geometry, coordinates, body, p) result(position)
      type(geometry_type), intent(in) :: geometry
      real(wp), intent(in) :: coordinates(:), p(2)
      integer, intent(in) :: body
      real(wp) :: position(2)
      position = p
      if (body == 0) return
      associate (q => coordinates(geometry%first(body):))
         if (geometry%widths(body) == 2) then
            position = q(:2) + p
         else
            position = q(:2) + [q(3)*p(1) - q(4)*p(2), q(4)*p(1) + q(3)*p(2)]
         end if
      end associate
   end function in_space

end module limber_output_drawn_posture
