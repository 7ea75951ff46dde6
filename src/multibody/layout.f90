!> Positions of all coordinates and rates in the vectors of the system. Floor: multibody. Source: Han and Lee 1993, eqs. (1)-(6);
!> doc/theory, eqs. (1.4)-(1.7).
module limber_multibody_layout
   use limber_base_kinds, only: wp
   use limber_model_model, only: model_type, body_point
   use limber_multibody_plane_vectors, only: cross
   implicit none
   private
   public :: layout_type, new_layout, guess_place, rates_of, velocities_of, advance, normalise_frames

   !> Where each body's coordinates stand. In q and v a body has [r (2); u (2); eta (n)], a point mass r only; the
   !> independent rates have [r' (2); omega] for the frame, or r' only.
   type :: layout_type
      !> True for a body with a floating frame (bodies)
      logical, allocatable :: framed(:)
      !> True for a point that carries a state of a control, its velocity along x: no place, weight or energy (bodies)
      logical, allocatable :: carries(:)
      !> Number of coordinates eta (bodies)
      integer, allocatable :: n(:)
      !> First index of r in q (bodies)
      integer, allocatable :: q(:)
      !> Number of the frame's rates: 3 or 2 (bodies)
      integer, allocatable :: rates(:)
      !> Length of q
      integer :: nq = 0
      !> First index of a body's rates [r' (2); omega; eta' (n)], or r' only, among the rates w of all; length of w
      integer, allocatable :: w(:)
      integer :: nw = 0
   end type layout_type

contains

   !> Lays the coordinates of all bodies one after another.
   pure function new_layout(model) result(layout)
      type(model_type), intent(in) :: model
      type(layout_type) :: layout
      integer :: i, bodies
      bodies = size(model%bodies)
      allocate (layout%framed(bodies), layout%n(bodies), layout%q(bodies), layout%rates(bodies), layout%w(bodies), &
         & layout%carries(bodies))
      do i = 1, bodies
         layout%framed(i) = model%bodies(i)%kind /= body_point
         layout%carries(i) = model%bodies(i)%control > 0
         layout%n(i) = model%bodies(i)%reduced%n
         layout%rates(i) = merge(3, 2, layout%framed(i))
         layout%q(i) = layout%nq + 1
         layout%nq = layout%nq + merge(4, 2, layout%framed(i)) + layout%n(i)
         layout%w(i) = layout%nw + 1
         layout%nw = layout%nw + layout%rates(i) + layout%n(i)
      end do
   end function new_layout

   !> Coordinates as the model guesses them, undeformed.
   pure subroutine guess_place(model, layout, q)
      type(model_type), intent(in) :: model
      type(layout_type), intent(in) :: layout
      !> Coordinates (nq)
      real(wp), intent(out) :: q(:)
      integer :: i
      q = 0.0_wp
      do i = 1, size(layout%q)
         associate (body => model%bodies(i), first => layout%q(i))
            q(first:first + 1) = body%position
            if (layout%framed(i)) q(first + 2:first + 3) = [cos(body%angle), sin(body%angle)]
         end associate
      end do
   end subroutine guess_place

   !> Independent rates w of velocities v at q: omega in place of u'.
   pure subroutine rates_of(layout, q, v, w)
      type(layout_type), intent(in) :: layout
      !> Coordinates and velocities (nq)
      real(wp), intent(in) :: q(:), v(:)
      !> Rates (nw)
      real(wp), intent(inout) :: w(:)
      integer :: i, from, to
      do i = 1, size(layout%q)
         from = layout%q(i)
         to = layout%w(i)
         w(to:to + 1) = v(from:from + 1)
         if (.not. layout%framed(i)) cycle
         w(to + 2) = cross(q(from + 2:from + 3), v(from + 2:from + 3))
         w(to + 3:to + 2 + layout%n(i)) = v(from + 4:from + 3 + layout%n(i))
      end do
   end subroutine rates_of

   !> Velocities v of independent rates w at q: u' = omega J u.
   pure subroutine velocities_of(layout, q, w, v)
      type(layout_type), intent(in) :: layout
      !> Coordinates (nq) and rates (nw)
      real(wp), intent(in) :: q(:), w(:)
      !> Velocities (nq)
      real(wp), intent(inout) :: v(:)
      integer :: i, from, to
      do i = 1, size(layout%q)
         to = layout%q(i)
         from = layout%w(i)
         v(to:to + 1) = w(from:from + 1)
         if (.not. layout%framed(i)) cycle
         v(to + 2) = -w(from + 2)*q(to + 3)
         v(to + 3) = w(from + 2)*q(to + 2)
         v(to + 4:to + 3 + layout%n(i)) = w(from + 3:from + 2 + layout%n(i))
      end do
   end subroutine velocities_of

   !> Coordinates q moved by an increment in the layout of the rates: r and eta by addition, u by a rotation.
   pure subroutine advance(layout, q, change, moved)
      type(layout_type), intent(in) :: layout
      !> Coordinates (nq), increment (nw)
      real(wp), intent(in) :: q(:), change(:)
      !> Coordinates (nq)
      real(wp), intent(inout) :: moved(:)
      real(wp) :: c, s
      integer :: i, from, to
      do i = 1, size(layout%q)
         to = layout%q(i)
         from = layout%w(i)
         moved(to:to + 1) = q(to:to + 1) + change(from:from + 1)
         if (.not. layout%framed(i)) cycle
         call find_turn(change(from + 2), c, s)
         moved(to + 2) = c*q(to + 2) - s*q(to + 3)
         moved(to + 3) = c*q(to + 3) + s*q(to + 2)
         moved(to + 4:to + 3 + layout%n(i)) = q(to + 4:to + 3 + layout%n(i)) + change(from + 3:from + 2 + layout%n(i))
      end do
   end subroutine advance

   !> Brings every frame's u to unit length.
   pure subroutine normalise_frames(layout, q)
      type(layout_type), intent(in) :: layout
      !> Coordinates (nq)
      real(wp), intent(inout) :: q(:)
      integer :: i
      do i = 1, size(layout%q)
         if (.not. layout%framed(i)) cycle
         associate (first => layout%q(i) + 2)
            q(first:first + 1) = q(first:first + 1)/sqrt(q(first)**2 + q(first + 1)**2)
         end associate
      end do
   end subroutine normalise_frames

   !> Cosine and sine of an angle, by their series where it is as small as in a step: at a third of the cost.
   pure subroutine find_turn(angle, c, s)
      real(wp), intent(in) :: angle
      real(wp), intent(out) :: c, s
      !> Up to here what the series leave out is below round-off
      real(wp), parameter :: small = 0.25_wp
      !> Reciprocal factorials
      real(wp), parameter :: r(2:12) = 1/[2.0_wp, 6.0_wp, 24.0_wp, 120.0_wp, 720.0_wp, 5040.0_wp, 40320.0_wp, 362880.0_wp, &
         & 3628800.0_wp, 39916800.0_wp, 479001600.0_wp]
      real(wp) :: square
      if (abs(angle) > small) then
         c = cos(angle)
         s = sin(angle)
         return
      end if
      square = angle**2
      c = 1 - square*(r(2) - square*(r(4) - square*(r(6) - square*(r(8) - square*(r(10) - square*r(12))))))
      s = angle*(1 - square*(r(3) - square*(r(5) - square*(r(7) - square*(r(9) - square*r(11))))))
   end subroutine find_turn

end module limber_multibody_layout
