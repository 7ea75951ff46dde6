!> Motion of markers by frames and deflections. Places, levers, velocities and what velocities alone make of accelerations, of rigid
!> bodies, bodies with modes and exact beams. Floor: multibody. Source: Han and Lee 1993, eqs. (1)-(6); doc/theory, eqs.
!> (1.4)-(1.7), (3.3).
module limber_multibody_marker_motion
   use limber_base_kinds, only: wp
   use limber_model_model, only: point_type, ground
   use limber_multibody_plane_vectors, only: turn, along, cross
   use limber_multibody_beam_axis, only: centreline_type, inner
   implicit none
   private
   public :: frame_motion_type, marker_type
   public :: place_rigid_marker, move_rigid_marker, place_marker, move_marker, place_exact_marker, place_exact_shapes
   public :: move_exact_marker, place_exact_direction, move_exact_direction

   !> State of one body
   type :: frame_motion_type
      real(wp) :: position(2) = 0.0_wp, u(2) = [1.0_wp, 0.0_wp]
      real(wp) :: velocity(2) = 0.0_wp, rate(2) = 0.0_wp
      !> Angular velocity (J u).u'
      real(wp) :: omega = 0.0_wp
   end type frame_motion_type

   !> State of one point: its acceleration is r'' + lever alpha + shape eta'' + bias. Or of a direction, A(p) u with
   !> p = (cos a, sin a) + psi.eta (-sin a, cos a), which is a point without r: its "position" is the vector
   type :: marker_type
      !> Index of the point in the model, and of its body
      integer :: point = 0, body = ground
      !> The body that moves it as a point; `ground` for a direction, which does not move with r
      integer :: carrier = ground
      logical :: direction = .false.
      real(wp) :: position(2) = 0.0_wp, velocity(2) = 0.0_wp
      !> J A(p) u
      real(wp) :: lever(2) = 0.0_wp
      !> What velocities alone contribute to its acceleration
      real(wp) :: bias(2) = 0.0_wp
      !> Undeformed place in the body frame, that of the point
      real(wp) :: p0(2) = 0.0_wp
      !> A(phi_k) u (2,n); no columns where no deflection moves it
      real(wp), allocatable :: shape(:, :)
      !> Of a point or direction of an exact beam: which of the centrelines that is, else 0; what its stations give to the place
      !> of the point (stations), and whether they give anything: the frame's origin has none
      integer :: line = 0
      real(wp), allocatable :: reach(:)
      logical :: reaching = .false.
   end type marker_type

contains

   !> Position of a point of a rigid body and its derivative by the rotation.
   pure subroutine place_rigid_marker(p0, frame, marker)
      !> Place in the frame
      real(wp), intent(in) :: p0(2)
      type(frame_motion_type), intent(in) :: frame
      type(marker_type), intent(inout) :: marker
      real(wp) :: arm(2)
      arm(1) = p0(1)*frame%u(1) - p0(2)*frame%u(2)
      arm(2) = p0(1)*frame%u(2) + p0(2)*frame%u(1)
      marker%position = frame%position + arm
      marker%lever(1) = -arm(2)
      marker%lever(2) = arm(1)
   end subroutine place_rigid_marker

   !> Velocity of such a point, and its acceleration without those of the frame.
   pure subroutine move_rigid_marker(frame, marker)
      type(frame_motion_type), intent(in) :: frame
      type(marker_type), intent(inout) :: marker
      real(wp) :: square
      square = frame%omega**2
      marker%velocity = frame%velocity + frame%omega*marker%lever
      marker%bias(1) = -square*marker%lever(2)
      marker%bias(2) = square*marker%lever(1)
   end subroutine move_rigid_marker

   !> Position of a point and its derivatives with respect to the rates.
   pure subroutine place_marker(point, frame, eta, marker)
      type(point_type), intent(in) :: point
      type(frame_motion_type), intent(in) :: frame
      !> Coordinates of the body (n)
      real(wp), contiguous, intent(in) :: eta(:)
      type(marker_type), intent(inout) :: marker
      real(wp) :: arm(2)
      integer :: k
      arm = along(marker%p0, frame%u)
      do k = 1, size(marker%shape, 2)
         marker%shape(:, k) = along(point%phi(:, k), frame%u)
         arm = arm + marker%shape(:, k)*eta(k)
      end do
      marker%position = frame%position + arm
      marker%lever = turn(arm)
   end subroutine place_marker

   !> Velocity of a point and the part of its acceleration that velocities alone make.
   pure subroutine move_marker(point, frame, eta, rate, marker)
      type(point_type), intent(in) :: point
      type(frame_motion_type), intent(in) :: frame
      !> Coordinates of the body and their rates (n)
      real(wp), contiguous, intent(in) :: eta(:), rate(:)
      type(marker_type), intent(inout) :: marker
      real(wp) :: p(2), drift(2)
      integer :: k
      p = marker%p0
      drift = 0.0_wp
      do k = 1, size(marker%shape, 2)
         p = p + point%phi(:, k)*eta(k)
         drift = drift + point%phi(:, k)*rate(k)
      end do
      marker%velocity = frame%velocity + along(p, frame%rate) + along(drift, frame%u)
      marker%bias = 2*along(drift, frame%rate) - dot_product(frame%rate, frame%rate)*along(p, frame%u)
   end subroutine move_marker

   !> Position of a point of an exact beam and its derivatives, eq. (2.42).
   pure subroutine place_exact_marker(line, frame, marker)
      type(centreline_type), intent(in) :: line
      type(frame_motion_type), intent(in) :: frame
      type(marker_type), intent(inout) :: marker
      real(wp) :: p(2)
      if (.not. marker%reaching) then
         marker%position = frame%position
         return
      end if
      call place_exact_shapes(line, frame%u, marker)
      p = along([inner(line%stations, marker%reach, line%g(:, 1)), inner(line%stations, marker%reach, line%g(:, 2))], frame%u)
      marker%position = frame%position + p
      marker%lever = turn(p)
   end subroutine place_exact_marker

   !> Its derivatives by the coordinates.
   pure subroutine place_exact_shapes(line, u, marker)
      type(centreline_type), intent(in) :: line
      !> Vector that turns, and stretches, the axes of the frame into those of space (2)
      real(wp), intent(in) :: u(2)
      type(marker_type), intent(inout) :: marker
      real(wp) :: x, y
      integer :: i
      if (.not. marker%reaching) return
      do i = 1, size(marker%shape, 2)
         x = inner(line%stations, marker%reach, line%gx(:, i))
         y = inner(line%stations, marker%reach, line%gy(:, i))
         marker%shape(1, i) = u(1)*x - u(2)*y
         marker%shape(2, i) = u(1)*y + u(2)*x
      end do
   end subroutine place_exact_shapes

   !> Velocity of such a point and the part of its acceleration that velocities alone make.
   pure subroutine move_exact_marker(line, frame, marker)
      type(centreline_type), intent(in) :: line
      type(frame_motion_type), intent(in) :: frame
      type(marker_type), intent(inout) :: marker
      real(wp) :: drift(2), swerve(2)
      if (.not. marker%reaching) then
         marker%velocity = frame%velocity
         return
      end if
      associate (n => line%stations, reach => marker%reach)
         drift = [inner(n, reach, line%drift(:, 1)), inner(n, reach, line%drift(:, 2))]
         swerve = [inner(n, reach, line%bias(:, 1)), inner(n, reach, line%bias(:, 2))]
      end associate
      marker%velocity = frame%velocity + frame%omega*marker%lever + along(drift, frame%u)
      marker%bias = 2*along(drift, frame%rate) + frame%omega**2*turn(marker%lever) + along(swerve, frame%u)
   end subroutine move_exact_marker

   !> Direction in a section of an exact beam, and its derivatives.
   pure subroutine place_exact_direction(point, frame, eta, marker)
      type(point_type), intent(in) :: point
      type(frame_motion_type), intent(in) :: frame
      real(wp), contiguous, intent(in) :: eta(:)
      type(marker_type), intent(inout) :: marker
      real(wp) :: angle
      integer :: k
      angle = 0.0_wp
      do k = 1, size(eta)
         angle = angle + point%psi(k)*eta(k)
      end do
      marker%position = along(along(marker%p0, [cos(angle), sin(angle)]), frame%u)
      marker%lever = turn(marker%position)
      do k = 1, size(marker%shape, 2)
         marker%shape(:, k) = point%psi(k)*marker%lever
      end do
   end subroutine place_exact_direction

   !> Velocity of such a direction, and the part of its acceleration that velocities alone make.
   pure subroutine move_exact_direction(point, frame, rate, marker)
      type(point_type), intent(in) :: point
      type(frame_motion_type), intent(in) :: frame
      real(wp), contiguous, intent(in) :: rate(:)
      type(marker_type), intent(inout) :: marker
      real(wp) :: turning
      integer :: k
      turning = frame%omega
      do k = 1, size(rate)
         turning = turning + point%psi(k)*rate(k)
      end do
      marker%velocity = turning*marker%lever
      marker%bias = -turning**2*marker%position
   end subroutine move_exact_direction

end module limber_multibody_marker_motion
