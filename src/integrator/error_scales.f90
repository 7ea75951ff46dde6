!> Scales of local errors. A tolerance of 1e-6 means a millionth of the scale. Lengths and directions have fixed scales; speeds,
!> deflections and their rates the largest that has occurred so far, not below a floor; speeds the largest among bodies that joints,
!> drivers or loads connect, for what goes on beside a body says nothing about it. For an integrator that damps what it does
!> not resolve, the rate of a coordinate that vibrates at omega has omega times the deflection's scale instead: its error counts as
!> the deflection that it makes, so that a fast ringing of small amplitude is not resolved for its own sake. (An explicit one must
!> not be given that freedom: at 1e-3 it lost the slider-crank.) Floor: integrator.
module limber_integrator_error_scales
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_model_model, only: ground
   use limber_multibody_drivers, only: driven_origin_type
   use limber_multibody_system, only: system_type
   implicit none
   private
   public :: scales_type, new_scales, update_scales, rate_scales, energy_scale, find_grain, connected_lengths

   !> Scale of what is no place: the integral of a state of a control
   real(wp), parameter :: no_place = 1.0e30_wp

   !> A scale for each component of [q; v]
   type :: scales_type
      !> Value for each component (2 nq)
      real(wp), allocatable :: value(:)
      !> Bodies that are connected have one number, from 1 on (bodies)
      integer, allocatable :: group(:)
      !> Length of what is connected [length] (groups)
      real(wp), allocatable :: length(:)
      !> Whether it is the way that they have made so far, and from where (groups); (2, groups)
      logical, allocatable :: of_motion(:)
      real(wp), allocatable :: middle(:, :)
      !> Speed [length/time], common to connected bodies, without coordinates that drivers prescribe, and that of these (groups)
      real(wp), allocatable :: speed(:), driven(:)
      !> Whether a driver prescribes x or y of a body (2, bodies)
      logical, allocatable :: given(:, :)
      !> Whether a group is a state of a control, whose speed is its size (groups)
      logical, allocatable :: is_state(:)
      !> Deflection coordinate and its rate, of each body (bodies)
      real(wp), allocatable :: deflection(:), rate(:)
      !> True if rates of fast coordinates are weighed by the deflection that they make
      logical :: damping = .false.
   contains
      procedure :: fastest, exchange => exchange_scales
   end type scales_type

contains

   !> Floors: a speed that crosses the scene once in the whole time; a deflection of a thousandth of the body's length, and
   !> its rate at the first natural frequency.
   function new_scales(system, duration, damping) result(scales)
      type(system_type), intent(in) :: system
      !> Time from start to end of the analysis
      real(wp), intent(in) :: duration
      !> True for an integrator that damps what it does not resolve
      logical, intent(in) :: damping
      type(scales_type) :: scales
      integer :: i
      allocate (scales%value(2*system%layout%nq), scales%deflection(size(system%layout%q)), scales%rate(size(system%layout%q)))
      scales%value = 1.0_wp
      allocate (scales%group(size(system%layout%q)))
      call find_groups(system, scales%group)
      allocate (scales%length(maxval([0, scales%group])))
      call find_lengths(system, scales%group, scales%length, scales%of_motion, scales%middle)
      allocate (scales%speed, source=scales%length/duration)
      allocate (scales%is_state(size(scales%speed)), source=.false.)
      do i = 1, size(scales%group)
         if (.not. system%layout%carries(i)) cycle
         scales%is_state(scales%group(i)) = .true.
         scales%speed(scales%group(i)) = system%model%bodies(i)%state_scale
      end do
      allocate (scales%driven(size(scales%speed)), source=0.0_wp)
      scales%deflection = 0.0_wp
      scales%rate = 0.0_wp
      scales%damping = damping
      allocate (scales%given(2, size(scales%deflection)), source=.false.)
      do i = 1, size(system%constraints)
         select type (item => system%constraints(i)%item)
         type is (driven_origin_type)
            scales%given(item%axis, item%bodies(1)) = .true.
         end select
      end do
      do i = 1, size(scales%deflection)
         if (system%layout%n(i) == 0) cycle
         associate (body => system%model%bodies(i))
            scales%deflection(i) = 1.0e-3_wp*body%size/body%largest_shape
            scales%rate(i) = scales%deflection(i)*sqrt(minval(body%reduced%omega2))
         end associate
      end do
      call spread_scales(system, scales)
   end function new_scales

   !> Numbers of bodies that are connected, by the ground alone not.
   subroutine find_groups(system, group)
      type(system_type), intent(in) :: system
      !> (bodies)
      integer, intent(out) :: group(:)
      !> A body of the same group with a lower number, or the body itself (bodies)
      integer :: lower(size(group))
      integer :: i, k, groups
      lower = [(i, i=1, size(group))]
      do i = 1, size(system%constraints)
         call join(system%constraints(i)%item%bodies)
         k = system%constraints(i)%item%part_of
         if (k > 0) call join([system%constraints(i)%item%bodies, system%constraints(k)%item%bodies])
      end do
      do i = 1, size(system%loads)
         call join(system%loads(i)%item%bodies)
      end do
      groups = 0
      do i = 1, size(group)
         if (lower(i) == i) then
            groups = groups + 1
            group(i) = groups
         else
            group(i) = group(lowest(i))
         end if
      end do

   contains

      subroutine join(bodies)
         integer, intent(in) :: bodies(:)
         integer :: j, first, other
         first = ground
         do j = 1, size(bodies)
            if (bodies(j) == ground) cycle
            if (system%layout%carries(bodies(j))) cycle
            other = lowest(bodies(j))
            if (first == ground) first = other
            lower(max(first, other)) = min(first, other)
            first = min(first, other)
         end do
      end subroutine join

      !> The lowest number of the group; the way to it gets shorter.
      integer function lowest(body)
         integer, intent(in) :: body
         lowest = body
         do while (lower(lowest) /= lowest)
            lower(lowest) = lower(lower(lowest))
            lowest = lower(lowest)
         end do
      end function lowest

   end subroutine find_groups

   !> Length of what is connected with each body [length] (bodies).
   function connected_lengths(system) result(length)
      type(system_type), intent(in) :: system
      real(wp) :: length(size(system%layout%q))
      integer :: group(size(length))
      real(wp), allocatable :: of_group(:), middle(:, :)
      logical, allocatable :: of_motion(:)
      call find_groups(system, group)
      allocate (of_group(maxval([0, group])))
      call find_lengths(system, group, of_group, of_motion, middle)
      length = of_group(group)
   end function connected_lengths

   !> Length of what is connected: that of the scene if all is, else of the largest body; of point masses the extent of their
   !> places and of points of the ground that they are connected with, of one alone its distance from the origin, but no more than
   !> the scene. If all of these are one place that the ground holds, it is the way that they make from there.
   subroutine find_lengths(system, group, length, of_motion, middle)
      type(system_type), intent(in) :: system
      !> (bodies)
      integer, intent(in) :: group(:)
      !> (groups)
      real(wp), intent(out) :: length(:)
      !> Whether it grows with the motion (groups); mean of the places (2, groups)
      logical, allocatable, intent(out) :: of_motion(:)
      real(wp), allocatable, intent(out) :: middle(:, :)
      !> Least part of the length of the scene that a point mass has which nothing holds, and one that the ground holds where it is
      real(wp), parameter :: part = 1.0e-3_wp, held_part = 1.0e-4_wp
      !> Distances, relative to that from the origin, that are none; round-off of places that errors are to be above
      real(wp), parameter :: together = 1.0e-9_wp, round_off = 1.0e2_wp*epsilon(1.0_wp)
      real(wp), dimension(size(length)) :: farthest, distance
      logical :: held(size(length))
      integer :: places(size(length)), i
      held = .false.
      allocate (middle(2, size(length)), source=0.0_wp)
      allocate (of_motion(size(length)), source=.false.)
      length = 0.0_wp
      distance = 0.0_wp
      do i = 1, size(group)
         associate (body => system%model%bodies(i))
            length(group(i)) = max(length(group(i)), body%size)
            if (body%whole > 0) length(group(i)) = max(length(group(i)), system%model%wholes(body%whole)%length)
            distance(group(i)) = max(distance(group(i)), norm2(body%position))
         end associate
      end do
      places = 0
      farthest = 0.0_wp
      call visit_places(.true.)
      do i = 1, size(length)
         middle(:, i) = middle(:, i)/max(1, places(i))
      end do
      call visit_places(.false.)
      where (.not. length > 0.0_wp) length = 2*farthest
      do i = 1, size(group)
         if (system%layout%carries(i)) length(group(i)) = system%model%length
      end do
      do i = 1, size(length)
         if (length(i) > together*max(distance(i), norm2(middle(:, i)))) cycle
         length(i) = max(part*system%model%length, min(distance(i), system%model%length))
         of_motion(i) = held(i) .and. all(group /= i .or. .not. system%layout%framed)
         if (of_motion(i)) length(i) = max(held_part*length(i), round_off/system%model%dynamics%tolerance*distance(i))
      end do
      if (size(length) - count(system%layout%carries) == 1 .and. .not. any(of_motion)) length = system%model%length

   contains

      !> Places of bodies, and of the ground where springs and joints hold them: added up, or their distances from the middle.
      subroutine visit_places(adds)
         logical, intent(in) :: adds
         integer :: k
         do k = 1, size(group)
            call visit(group(k), system%model%bodies(k)%position, adds)
         end do
         do k = 1, size(system%model%joints)
            if (all(system%model%joints(k)%points > 0)) call visit_ground(system%model%joints(k)%points, adds)
         end do
         do k = 1, size(system%model%drivers)
            if (all(system%model%drivers(k)%points > 0)) call visit_ground(system%model%drivers(k)%points, adds)
         end do
         do k = 1, size(system%model%load_parts)
            if (all(system%model%load_parts(k)%points > 0)) call visit_ground(system%model%load_parts(k)%points, adds)
         end do
      end subroutine visit_places

      !> The point of the ground of a pair, if one is.
      subroutine visit_ground(points, adds)
         integer, intent(in) :: points(2)
         logical, intent(in) :: adds
         integer :: bodies(2), k
         bodies = system%model%points(points)%body
         if (count(bodies == ground) /= 1) return
         k = maxloc(bodies, 1)
         held(group(bodies(k))) = .true.
         call visit(group(bodies(k)), system%model%points(points(3 - k))%p0, adds)
      end subroutine visit_ground

      !> Adds a place, or finds its distance.
      subroutine visit(of, place, adds)
         integer, intent(in) :: of
         real(wp), intent(in) :: place(2)
         logical, intent(in) :: adds
         if (adds) then
            middle(:, of) = middle(:, of) + place
            places(of) = places(of) + 1
         else
            farthest(of) = max(farthest(of), norm2(place - middle(:, of)))
         end if
      end subroutine visit

   end subroutine find_lengths

   !> The largest speed of all [length/time].
   pure real(wp) function fastest(self)
      class(scales_type), intent(in) :: self
      fastest = max(maxval(self%speed, mask=.not. self%is_state), maxval(self%driven, mask=.not. self%is_state))
   end function fastest

   !> Raises the scales to what occurs in a state.
   subroutine update_scales(system, q, v, scales, raised)
      type(system_type), intent(in) :: system
      !> Coordinates and velocities (nq)
      real(wp), contiguous, intent(in) :: q(:), v(:)
      type(scales_type), intent(inout) :: scales
      !> Whether any was
      logical, intent(out), optional :: raised
      integer :: i, k, first, last
      logical :: changed
      changed = .false.
      do i = 1, size(scales%deflection)
         first = system%layout%q(i)
         do k = 1, 2
            if (scales%given(k, i)) then
               call raise_to(scales%driven(scales%group(i)), abs(v(first + k - 1)))
            else
               call raise_to(scales%speed(scales%group(i)), abs(v(first + k - 1)))
            end if
         end do
         if (scales%of_motion(scales%group(i))) call raise_to(scales%length(scales%group(i)), &
            & 2*norm2(q(first:first + 1) - scales%middle(:, scales%group(i))))
         if (.not. system%layout%framed(i)) cycle
         call raise_to(scales%speed(scales%group(i)), scales%length(scales%group(i))*max(abs(v(first + 2)), abs(v(first + 3))))
         if (system%layout%n(i) == 0) cycle
         last = first + 3 + system%layout%n(i)
         call raise_to(scales%deflection(i), maxval(abs(q(first + 4:last))))
         call raise_to(scales%rate(i), maxval(abs(v(first + 4:last))))
      end do
      if (changed) call spread_scales(system, scales)
      if (present(raised)) raised = changed

   contains

      subroutine raise_to(scale, size)
         real(wp), intent(inout) :: scale
         real(wp), intent(in) :: size
         if (size > scale) then
            scale = size
            changed = .true.
         end if
      end subroutine raise_to

   end subroutine update_scales

   !> The same scales in the layout of the independent rates.
   pure subroutine rate_scales(system, scales, coordinate, rate)
      type(system_type), intent(in) :: system
      type(scales_type), intent(in) :: scales
      !> Scale of each coordinate and of each rate (nw)
      real(wp), intent(inout) :: coordinate(:), rate(:)
      integer :: i, from, to, n, nq
      nq = system%layout%nq
      do i = 1, size(system%layout%q)
         from = system%layout%q(i)
         to = system%layout%w(i)
         coordinate(to:to + 1) = scales%value(from:from + 1)
         rate(to:to + 1) = scales%value(nq + from:nq + from + 1)
         if (.not. system%layout%framed(i)) cycle
         n = system%layout%n(i)
         coordinate(to + 2:to + 2 + n) = scales%value(from + 3:from + 3 + n)
         rate(to + 2:to + 2 + n) = scales%value(nq + from + 3:nq + from + 3 + n)
      end do
   end subroutine rate_scales

   !> Changes of the coordinates in the layout of the independent rates that move places by their round-off, eq. (5.30).
   pure subroutine find_grain(system, reach, grain)
      type(system_type), intent(in) :: system
      !> Largest coordinate of a place [length]
      real(wp), intent(in) :: reach
      !> (nw)
      real(wp), intent(inout) :: grain(:)
      integer :: i, at, n
      grain = epsilon(reach)*reach
      do i = 1, size(system%layout%q)
         if (.not. system%layout%framed(i)) cycle
         at = system%layout%w(i) + 2
         n = system%layout%n(i)
         grain(at) = grain(at)/system%model%length
         if (n > 0) grain(at + 1:at + n) = grain(at + 1:at + n)/system%model%bodies(i)%largest_shape
      end do
   end subroutine find_grain

   !> Scale of the work: a tenth of an energy of the motion, for errors of the work add up.
   pure real(wp) function energy_scale(system, scales)
      type(system_type), intent(in) :: system
      type(scales_type), intent(in) :: scales
      energy_scale = 0.1_wp*system%mass*scales%fastest()**2
   end function energy_scale

   !> Writes the scales of all components.
   subroutine spread_scales(system, scales)
      type(system_type), intent(in) :: system
      type(scales_type), intent(inout) :: scales
      integer :: i, first, n, nq
      nq = system%layout%nq
      do i = 1, size(scales%deflection)
         first = system%layout%q(i)
         associate (speed => scales%speed(scales%group(i)), driven => scales%driven(scales%group(i)), &
            & length => scales%length(scales%group(i)))
            scales%value(first:first + 1) = length
            scales%value(nq + first:nq + first + 1) = merge(max(speed, driven), speed, scales%given(:, i))
         end associate
         if (system%layout%carries(i)) scales%value(first:first + 1) = no_place
         if (.not. system%layout%framed(i)) cycle
         n = system%layout%n(i)
         scales%value(first + 2:first + 3) = 1.0_wp
         scales%value(nq + first + 2:nq + first + 3) = scales%speed(scales%group(i))/scales%length(scales%group(i))
         scales%value(first + 4:first + 3 + n) = scales%deflection(i)
         scales%value(nq + first + 4:nq + first + 3 + n) = scales%rate(i)
         if (scales%damping) scales%value(nq + first + 4:nq + first + 3 + n) = max(scales%rate(i), scales%deflection(i) &
            & *sqrt(system%model%bodies(i)%reduced%omega2))
      end do
   end subroutine spread_scales

   !> Saves or restores its memory.
   subroutine exchange_scales(self, snapshot)
      class(scales_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%keep('value', self%value)
      call snapshot%keep('length', self%length)
      call snapshot%keep('speed', self%speed)
      call snapshot%keep('driven_speed', self%driven)
      call snapshot%keep('deflection', self%deflection)
      call snapshot%keep('rate', self%rate)
      ! Not saved: group, of_motion, middle, given, is_state, damping
   end subroutine exchange_scales

end module limber_integrator_error_scales
