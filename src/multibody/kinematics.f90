!> Kinematics of all frames and markers. Frames and markers (the points that joints and forces act on) from the coordinates q and
!> velocities v. All later terms are made of these. Floor: multibody. Source: Han and Lee 1993, eqs. (1)-(6); doc/theory, eqs.
!> (1.4)-(1.7), (3.3).
module limber_multibody_kinematics
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_deck_operations, only: jet_type
   use limber_model_driver_laws, only: driven_motion
   use limber_model_model, only: model_type, driver_type, driver_angle, ground
   use limber_multibody_plane_vectors, only: cross
   use limber_multibody_beam_axis, only: centreline_type, new_centreline
   use limber_multibody_layout, only: layout_type
   use limber_multibody_marker_motion, only: frame_motion_type, marker_type, place_rigid_marker, move_rigid_marker, place_marker, &
      & move_marker, place_exact_marker, move_exact_marker, place_exact_direction, move_exact_direction
   implicit none
   private
   public :: marker_type, angle_type, kinematics_type, new_kinematics
   public :: place_drives, place_bodies, place_frames, settle_angles, move_bodies, move_frames

   !> Angle of a vector from the x axis, accumulated over turns: that of the turn nearest to where its anchor has moved, eq. (3.10)
   type :: angle_type
      !> Markers that the vector leads from and to; without the first, the second is a direction
      integer :: markers(2) = 0
      !> [rad]
      real(wp) :: value = 0.0_wp
      !> Its value at the last state that counts: a trial that goes astray must not turn it around [rad]
      real(wp) :: anchor = 0.0_wp
      !> Rate with which it moves on [rad/time] from the time of that state
      real(wp) :: rate = 0.0_wp, since = 0.0_wp
      !> Of a direction of a body: the driver that gives its frame's angle, 0: none; its angle in that frame, undeformed [rad]
      integer :: drive = 0
      real(wp) :: own = 0.0_wp
   end type angle_type

   !> Deflections of a body that joints ask for themselves, not for those of its points
   type :: bend_type
      !> Index of the body
      integer :: body = ground
      !> Coordinates and their rates (n)
      real(wp), allocatable :: eta(:), rate(:)
      !> What a unit of them is in lengths: the largest of its shapes
      real(wp) :: size = 1.0_wp
   end type bend_type

   !> What a driver prescribes at a time: the value and its two derivatives; of a frame's angle also its unit vector
   type :: drive_type
      real(wp) :: heading(2) = 0.0_wp, value = 0.0_wp, rate = 0.0_wp, acceleration = 0.0_wp
      !> Behind those of the drivers: the joint whose law it is
      integer :: joint = 0
      !> True if the law is a constant
      logical :: still = .false.
   end type drive_type

   !> Times at which the values of drivers are kept
   integer, parameter :: times_kept = 4

   !> Frames of all bodies (index 0 is the ground), all markers in use, and what drivers prescribe, at a time
   type :: kinematics_type
      real(wp) :: time = -huge(1.0_wp)
      !> Time over which they are means, velocities being increments over it; zero: those of an instant
      real(wp) :: span = 0.0_wp
      type(drive_type), allocatable :: drives(:)
      !> What they prescribe at the last few times, these times, and the oldest of them: stages of a step come again in each round
      type(drive_type), allocatable :: known(:, :)
      real(wp) :: known_times(times_kept) = -huge(1.0_wp)
      integer :: oldest = 1
      type(frame_motion_type), allocatable :: frames(:)
      !> The exact beams, and the body of each
      type(centreline_type), allocatable :: lines(:)
      integer, allocatable :: beams(:)
      type(marker_type), allocatable :: markers(:)
      !> Those of them that move with rigid bodies as points, and with bodies that deflect
      integer, allocatable :: rigid(:), bending(:)
      !> Whether there are any of the following
      logical :: turns = .false.
      !> Markers that are directions of bodies
      integer, allocatable :: directions(:)
      !> Angles that joints and loads ask for
      type(angle_type), allocatable :: angles(:)
      !> Deflections that joints ask for
      type(bend_type), allocatable :: bends(:)
   contains
      procedure :: exchange => exchange_kinematics
   end type kinematics_type

contains

   !> Room for frames and for the given points as markers.
   pure function new_kinematics(model, points, angles, bends) result(kinematics)
      type(model_type), intent(in) :: model
      !> Indices of the points that become markers
      integer, intent(in) :: points(:)
      !> Angles that are followed, with values near those of the first place
      type(angle_type), intent(in) :: angles(:)
      !> Bodies whose deflections are wanted
      integer, intent(in) :: bends(:)
      type(kinematics_type) :: kinematics
      integer :: m
      allocate (kinematics%frames(0:size(model%bodies)), kinematics%markers(size(points)))
      allocate (kinematics%beams(count([(model%bodies(m)%reduced%is_exact, m=1, size(model%bodies))])))
      kinematics%beams = pack([(m, m=1, size(model%bodies))], [(model%bodies(m)%reduced%is_exact, m=1, size(model%bodies))])
      allocate (kinematics%lines(size(kinematics%beams)))
      do m = 1, size(kinematics%beams)
         call new_centreline(model%bodies(kinematics%beams(m))%reduced%exact, kinematics%lines(m))
      end do
      allocate (kinematics%drives(size(model%drivers) + count(model%joints%has_law)))
      kinematics%drives(size(model%drivers) + 1:)%joint = pack([(m, m=1, size(model%joints))], model%joints%has_law)
      allocate (kinematics%known(size(kinematics%drives), times_kept))
      do m = 1, size(model%drivers)
         kinematics%drives(m)%still = model%drivers(m)%level == 0 .and. model%drivers(m)%law%is_constant()
         if (kinematics%drives(m)%still) call place_drive(model%drivers(m), 0.0_wp, kinematics%drives(m))
      end do
      do m = 1, size(points)
         kinematics%markers(m)%point = points(m)
         kinematics%markers(m)%body = model%points(points(m))%body
         kinematics%markers(m)%p0 = model%points(points(m))%p0
         kinematics%markers(m)%direction = model%points(points(m))%direction
         kinematics%markers(m)%carrier = merge(ground, kinematics%markers(m)%body, kinematics%markers(m)%direction)
         associate (point => model%points(points(m)))
            allocate (kinematics%markers(m)%shape(2, merge(size(point%psi), 0, any(abs(point%phi) > 0.0_wp))), source=0.0_wp)
            if (point%exact) kinematics%markers(m)%line = findloc(kinematics%beams, point%body, dim=1)
            allocate (kinematics%markers(m)%reach(0))
            if (allocated(point%reach)) kinematics%markers(m)%reach = point%reach
            kinematics%markers(m)%reaching = any(abs(kinematics%markers(m)%reach) > 0.0_wp)
         end associate
         if (kinematics%markers(m)%body == ground) kinematics%markers(m)%position = model%points(points(m))%p0
      end do
      call sort_markers(model, kinematics)
      allocate (kinematics%directions(count(kinematics%markers%direction .and. kinematics%markers%body /= ground)))
      kinematics%directions = pack([(m, m=1, size(points))], kinematics%markers%direction .and. kinematics%markers%body /= ground)
      kinematics%turns = size(kinematics%directions) + size(angles) + size(bends) > 0
      allocate (kinematics%bends(size(bends)))
      do m = 1, size(bends)
         kinematics%bends(m)%body = bends(m)
         allocate (kinematics%bends(m)%eta(model%bodies(bends(m))%reduced%n), &
            & kinematics%bends(m)%rate(model%bodies(bends(m))%reduced%n))
         kinematics%bends(m)%eta = 0.0_wp
         kinematics%bends(m)%rate = 0.0_wp
         if (model%bodies(bends(m))%largest_shape > 0.0_wp) kinematics%bends(m)%size = model%bodies(bends(m))%largest_shape
      end do
      allocate (kinematics%angles(size(angles)))
      do m = 1, size(angles)
         kinematics%angles(m) = angles(m)
         kinematics%angles(m)%anchor = angles(m)%value
         associate (angle => kinematics%angles(m), to => kinematics%markers(angles(m)%markers(2)))
            if (angle%markers(1) > 0 .or. to%body == ground) cycle
            angle%own = atan2(to%p0(2), to%p0(1))
            angle%drive = findloc(model%drivers%kind == driver_angle .and. model%drivers%body == to%body &
               & .and. model%drivers%switch == 0, .true., dim=1)
         end associate
      end do
   end function new_kinematics

   !> Lists the markers that move as points by what their bodies are.
   pure subroutine sort_markers(model, kinematics)
      type(model_type), intent(in) :: model
      type(kinematics_type), intent(inout) :: kinematics
      logical :: moves(size(kinematics%markers)), bends(size(kinematics%markers))
      integer :: m
      moves = kinematics%markers%carrier /= ground
      do m = 1, size(moves)
         bends(m) = moves(m)
         if (moves(m)) bends(m) = model%bodies(kinematics%markers(m)%carrier)%reduced%n > 0
      end do
      kinematics%rigid = pack([(m, m=1, size(moves))], moves .and. .not. bends)
      kinematics%bending = pack([(m, m=1, size(moves))], bends)
   end subroutine sort_markers

   !> What the drivers prescribe at the time t; nothing is done if it is that of the last call.
   pure subroutine place_drives(model, t, kinematics)
      type(model_type), intent(in) :: model
      real(wp), intent(in) :: t
      type(kinematics_type), intent(inout) :: kinematics
      type(jet_type) :: theta
      integer :: i
      if (.not. abs(t - kinematics%time) > 0.0_wp) return
      kinematics%time = t
      if (size(kinematics%drives) == 0) return
      do i = 1, times_kept
         if (abs(t - kinematics%known_times(i)) > 0.0_wp) cycle
         kinematics%drives(:) = kinematics%known(:, i)
         return
      end do
      do i = 1, size(model%drivers)
         if (.not. kinematics%drives(i)%still) call place_drive(model%drivers(i), t, kinematics%drives(i))
      end do
      do i = size(model%drivers) + 1, size(kinematics%drives)
         theta = model%joints(kinematics%drives(i)%joint)%law%evaluate_jet(t)
         kinematics%drives(i)%value = theta%value
         kinematics%drives(i)%rate = theta%first
         kinematics%drives(i)%acceleration = theta%second
      end do
      kinematics%known(:, kinematics%oldest) = kinematics%drives
      kinematics%known_times(kinematics%oldest) = t
      kinematics%oldest = modulo(kinematics%oldest, times_kept) + 1
   end subroutine place_drives

   !> What one driver prescribes at the time t.
   pure subroutine place_drive(driver, t, drive)
      type(driver_type), intent(in) :: driver
      real(wp), intent(in) :: t
      type(drive_type), intent(inout) :: drive
      type(jet_type) :: theta
      theta = driven_motion(driver, t)
      if (driver%kind == driver_angle) drive%heading = [cos(theta%value), sin(theta%value)]
      drive%value = theta%value
      drive%rate = theta%first
      drive%acceleration = theta%second
   end subroutine place_drive

   !> Drivers and frames at the time t and coordinates q, without markers.
   pure subroutine place_bodies(model, layout, t, q, kinematics)
      type(model_type), intent(in) :: model
      type(layout_type), intent(in) :: layout
      real(wp), intent(in) :: t
      !> Coordinates (nq)
      real(wp), contiguous, intent(in) :: q(:)
      type(kinematics_type), intent(inout) :: kinematics
      integer :: i, first
      call place_drives(model, t, kinematics)
      do i = 1, size(model%bodies)
         first = layout%q(i)
         kinematics%frames(i)%position = q(first:first + 1)
         if (layout%framed(i)) kinematics%frames(i)%u = q(first + 2:first + 3)
      end do
   end subroutine place_bodies

   !> Frames and markers at the time t and coordinates q.
   pure subroutine place_frames(model, layout, t, q, kinematics)
      type(model_type), intent(in) :: model
      type(layout_type), intent(in) :: layout
      real(wp), intent(in) :: t
      !> Coordinates (nq)
      real(wp), contiguous, intent(in) :: q(:)
      type(kinematics_type), intent(inout) :: kinematics
      integer :: i, k, first
      call place_bodies(model, layout, t, q, kinematics)
      do i = 1, size(kinematics%beams)
         first = layout%q(kinematics%beams(i)) + 4
         call kinematics%lines(i)%place_stations(q(first:first + kinematics%lines(i)%n - 1))
      end do
      call place_rigid_markers(size(kinematics%rigid), kinematics%rigid, kinematics%frames, kinematics%markers)
      do k = 1, size(kinematics%bending)
         associate (marker => kinematics%markers(kinematics%bending(k)))
            if (marker%line > 0) then
               call place_exact_marker(kinematics%lines(marker%line), kinematics%frames(marker%carrier), marker)
               cycle
            end if
            first = layout%q(marker%carrier) + 4
            call place_marker(model%points(marker%point), kinematics%frames(marker%carrier), &
               & q(first:first + layout%n(marker%carrier) - 1), marker)
         end associate
      end do
      if (kinematics%turns) call place_directions(model, layout, q, kinematics)
   end subroutine place_frames

   !> Places those of the markers that are points of rigid bodies.
   pure subroutine place_rigid_markers(n, list, frames, markers)
      integer, intent(in) :: n, list(n)
      !> Of the ground and the bodies; all markers
      type(frame_motion_type), intent(in) :: frames(0:*)
      type(marker_type), intent(inout) :: markers(*)
      integer :: k, m
      do k = 1, n
         m = list(k)
         call place_rigid_marker(markers(m)%p0, frames(markers(m)%carrier), markers(m))
      end do
   end subroutine place_rigid_markers

   !> The same for their velocities.
   pure subroutine move_rigid_markers(n, list, frames, markers)
      integer, intent(in) :: n, list(n)
      type(frame_motion_type), intent(in) :: frames(0:*)
      type(marker_type), intent(inout) :: markers(*)
      integer :: k, m
      do k = 1, n
         m = list(k)
         call move_rigid_marker(frames(markers(m)%carrier), markers(m))
      end do
   end subroutine move_rigid_markers

   !> Directions, angles that are followed, and deflections; all else is placed.
   pure subroutine place_directions(model, layout, q, kinematics)
      type(model_type), intent(in) :: model
      type(layout_type), intent(in) :: layout
      real(wp), contiguous, intent(in) :: q(:)
      type(kinematics_type), intent(inout) :: kinematics
      integer :: i, m, first
      do i = 1, size(kinematics%directions)
         associate (marker => kinematics%markers(kinematics%directions(i)))
            first = layout%q(marker%body) + 4
            if (marker%line > 0) then
               call place_exact_direction(model%points(marker%point), kinematics%frames(marker%body), &
                  & q(first:first + layout%n(marker%body) - 1), marker)
               cycle
            end if
            call place_marker(model%points(marker%point), without_origin(kinematics%frames(marker%body)), &
               & q(first:first + layout%n(marker%body) - 1), marker)
         end associate
      end do
      do m = 1, size(kinematics%angles)
         if (kinematics%angles(m)%drive > 0) then
            associate (marker => kinematics%markers(kinematics%angles(m)%markers(2)))
               first = layout%q(marker%body) + 4
               call take_drive(kinematics, kinematics%angles(m), dot_product(model%points(marker%point)%psi, &
                  & q(first:first + layout%n(marker%body) - 1)))
            end associate
         end if
         call follow_angle(kinematics%markers, kinematics%time, kinematics%angles(m))
      end do
      do i = 1, size(kinematics%bends)
         first = layout%q(kinematics%bends(i)%body) + 4
         kinematics%bends(i)%eta = q(first:first + size(kinematics%bends(i)%eta) - 1)
      end do
   end subroutine place_directions

   !> A frame whose origin stands in that of space: that of its directions.
   pure function without_origin(frame) result(turning)
      type(frame_motion_type), intent(in) :: frame
      type(frame_motion_type) :: turning
      turning = frame
      turning%position = 0.0_wp
      turning%velocity = 0.0_wp
   end function without_origin

   !> Takes the placed angles for those of a state that counts. From a motion they go on at their rates; else they stay.
   pure subroutine settle_angles(kinematics, moving)
      !> Placed; from a motion also moved
      type(kinematics_type), intent(inout) :: kinematics
      logical, intent(in) :: moving
      real(wp) :: vector(2), rate(2)
      integer :: m
      do m = 1, size(kinematics%angles)
         associate (angle => kinematics%angles(m), to => kinematics%markers(kinematics%angles(m)%markers(2)))
            angle%anchor = angle%value
            angle%since = kinematics%time
            angle%rate = 0.0_wp
            if (.not. moving) cycle
            vector = to%position
            rate = to%velocity
            if (angle%markers(1) > 0) then
               vector = vector - kinematics%markers(angle%markers(1))%position
               rate = rate - kinematics%markers(angle%markers(1))%velocity
            end if
            if (dot_product(vector, vector) > 0.0_wp) angle%rate = cross(vector, rate)/dot_product(vector, vector)
         end associate
      end do
   end subroutine settle_angles

   !> The turns of a driven frame are those of its driver's law, whatever it was before.
   pure subroutine take_drive(kinematics, angle, bend)
      type(kinematics_type), intent(in) :: kinematics
      type(angle_type), intent(inout) :: angle
      !> Of the section from its frame [rad]
      real(wp), intent(in) :: bend
      angle%anchor = kinematics%drives(angle%drive)%value + angle%own + bend
      angle%since = kinematics%time
   end subroutine take_drive

   !> Angle of a vector at placed markers, with the turns that bring it nearest to where its anchor has moved; that follows what
   !> is near.
   pure subroutine follow_angle(markers, time, angle)
      type(marker_type), intent(in) :: markers(:)
      real(wp), intent(in) :: time
      type(angle_type), intent(inout) :: angle
      real(wp), parameter :: turn_once = 2*acos(-1.0_wp), near = 1.0_wp
      real(wp) :: vector(2), nearest, expected
      vector = markers(angle%markers(2))%position
      if (angle%markers(1) > 0) vector = vector - markers(angle%markers(1))%position
      nearest = atan2(vector(2), vector(1))
      expected = angle%anchor + angle%rate*(time - angle%since)
      angle%value = nearest + turn_once*anint((expected - nearest)/turn_once)
      if (abs(angle%value - expected) >= near) return
      angle%anchor = angle%value
      angle%since = time
   end subroutine follow_angle

   !> Velocities of frames and exact beams, without markers; `place_frames` comes first.
   pure subroutine move_bodies(model, layout, v, kinematics)
      type(model_type), intent(in) :: model
      type(layout_type), intent(in) :: layout
      !> Velocities (nq)
      real(wp), contiguous, intent(in) :: v(:)
      type(kinematics_type), intent(inout) :: kinematics
      integer :: i, first
      do i = 1, size(model%bodies)
         first = layout%q(i)
         associate (frame => kinematics%frames(i))
            frame%velocity = v(first:first + 1)
            if (layout%framed(i)) then
               frame%rate = v(first + 2:first + 3)
               frame%omega = cross(frame%u, frame%rate)
            end if
         end associate
      end do
      do i = 1, size(kinematics%beams)
         first = layout%q(kinematics%beams(i)) + 4
         call kinematics%lines(i)%move_stations(v(first:first + kinematics%lines(i)%n - 1))
      end do
   end subroutine move_bodies

   !> Velocities and bias accelerations at q and v; `place_frames` comes first.
   pure subroutine move_frames(model, layout, q, v, kinematics)
      type(model_type), intent(in) :: model
      type(layout_type), intent(in) :: layout
      !> Coordinates and velocities (nq)
      real(wp), contiguous, intent(in) :: q(:), v(:)
      type(kinematics_type), intent(inout) :: kinematics
      integer :: k, first, last
      call move_bodies(model, layout, v, kinematics)
      call move_rigid_markers(size(kinematics%rigid), kinematics%rigid, kinematics%frames, kinematics%markers)
      do k = 1, size(kinematics%bending)
         associate (marker => kinematics%markers(kinematics%bending(k)))
            if (marker%line > 0) then
               call move_exact_marker(kinematics%lines(marker%line), kinematics%frames(marker%carrier), marker)
               cycle
            end if
            first = layout%q(marker%carrier) + 4
            last = first + layout%n(marker%carrier) - 1
            call move_marker(model%points(marker%point), kinematics%frames(marker%carrier), q(first:last), v(first:last), marker)
         end associate
      end do
      if (kinematics%turns) call move_directions(model, layout, q, v, kinematics)
   end subroutine move_frames

   !> Velocities of the directions; those of the frames are there.
   pure subroutine move_directions(model, layout, q, v, kinematics)
      type(model_type), intent(in) :: model
      type(layout_type), intent(in) :: layout
      real(wp), contiguous, intent(in) :: q(:), v(:)
      type(kinematics_type), intent(inout) :: kinematics
      integer :: i, first, last
      do i = 1, size(kinematics%directions)
         associate (marker => kinematics%markers(kinematics%directions(i)))
            first = layout%q(marker%body) + 4
            last = first + layout%n(marker%body) - 1
            if (marker%line > 0) then
               call move_exact_direction(model%points(marker%point), kinematics%frames(marker%body), v(first:last), marker)
               cycle
            end if
            call move_marker(model%points(marker%point), without_origin(kinematics%frames(marker%body)), q(first:last), &
               & v(first:last), marker)
         end associate
      end do
      do i = 1, size(kinematics%bends)
         first = layout%q(kinematics%bends(i)%body) + 4
         kinematics%bends(i)%rate = v(first:first + size(kinematics%bends(i)%rate) - 1)
      end do
   end subroutine move_directions

   !> Saves or restores its memory.
   subroutine exchange_kinematics(self, snapshot)
      class(kinematics_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      integer :: i
      call snapshot%exchange('time', self%time)
      call snapshot%exchange('span', self%span)
      do i = 1, size(self%drives)
         call snapshot%exchange('heading', self%drives(i)%heading)
         call snapshot%exchange('value', self%drives(i)%value)
         call snapshot%exchange('rate', self%drives(i)%rate)
         call snapshot%exchange('acceleration', self%drives(i)%acceleration)
      end do
      do i = lbound(self%frames, 1), ubound(self%frames, 1)
         call snapshot%exchange('position', self%frames(i)%position)
         call snapshot%exchange('u', self%frames(i)%u)
         call snapshot%exchange('velocity', self%frames(i)%velocity)
         call snapshot%exchange('rate', self%frames(i)%rate)
         call snapshot%exchange('omega', self%frames(i)%omega)
      end do
      do i = 1, size(self%lines)
         call self%lines(i)%exchange(snapshot)
      end do
      do i = 1, size(self%markers)
         call snapshot%exchange('position', self%markers(i)%position)
         call snapshot%exchange('velocity', self%markers(i)%velocity)
         call snapshot%exchange('lever', self%markers(i)%lever)
         call snapshot%exchange('bias', self%markers(i)%bias)
         call snapshot%exchange('p0', self%markers(i)%p0)
         call snapshot%keep('shape', self%markers(i)%shape)
      end do
      do i = 1, size(self%angles)
         call snapshot%exchange('value', self%angles(i)%value)
         call snapshot%exchange('anchor', self%angles(i)%anchor)
         call snapshot%exchange('angle_rate', self%angles(i)%rate)
         call snapshot%exchange('since', self%angles(i)%since)
      end do
      do i = 1, size(self%bends)
         call snapshot%keep('eta', self%bends(i)%eta)
         call snapshot%keep('rate', self%bends(i)%rate)
      end do
      ! Not saved: known, known_times, oldest, beams, rigid, bending, turns, directions
   end subroutine exchange_kinematics

end module limber_multibody_kinematics
