!> Outlines of bodies, joints and springs for drawings. Its named points, an outline of each body, and what its joints and springs
!> connect. Floor: output; model -> geometry of `limber_output_motion_record`.
module limber_output_outline
   use limber_base_kinds, only: wp
   use limber_beam_exact_beam, only: undeformed_place
   use limber_base_spline, only: spline_at
   use limber_beam_plane_frame, only: member_length
   use limber_beam_frame_reduction, only: frame_point_shape
   use limber_beam_beam_reduction, only: point_shape
   use limber_model_model, only: place_on_curve, model_type, joint_type, body_point, body_flexible, ground
   use limber_output_drawn_coordinates, only: body_width, drawn_shape, drawn_place, named_places, stretches_of_beam
   use limber_output_motion_record, only: geometry_type, prepare
   use limber_multibody_plane_vectors, only: cross
   use limber_multibody_layout, only: layout_type
   implicit none
   private
   public :: geometry_of, hull

   !> Stretches of a curve between two of its points
   integer, parameter :: per_knot = 8
   !> Stretches of each member of a frame that bends
   integer, parameter :: member_stretches = 12
   !> Points that bodies have, and those that beams have, without the deck's naming them
   character(*), parameter :: points_of_bodies = ' origin centre ', points_of_beams = ' origin start middle end '

contains

   !> Geometry of a model. Its places are the points of the model, in their order, and behind them those along beams.
   function geometry_of(model, layout) result(geometry)
      type(model_type), intent(in) :: model
      type(layout_type), intent(in) :: layout
      type(geometry_type) :: geometry
      integer, allocatable :: order(:), first(:)
      logical, allocatable :: drawn(:)
      integer :: i, body, member, place, shape, filled(2)
      call size_geometry(model, layout, geometry)
      place = 0
      shape = 0
      do i = 1, size(model%points)
         if (is_state(model, model%points(i)%body)) then
            call add_place(ground, model%points(i)%p0, model%points(i)%phi, geometry, place, shape)
            cycle
         end if
         geometry%place_names(i) = model%points(i)%name
         if (is_exact(model, model%points(i)%body)) then
            call add_place(model%points(i)%body, model%points(i)%p0, drawn_shape(model, layout, model%points(i)%body, &
               & drawn_place(model, i)), geometry, place, shape)
            cycle
         end if
         call add_place(model%points(i)%body, model%points(i)%p0, model%points(i)%phi, geometry, place, shape)
      end do
      call take_connections(model, geometry)
      call sort_points(model, order, first)
      call find_drawn(model, geometry, drawn)
      filled = 0
      do body = 1, size(geometry%bodies)
         geometry%bodies(body) = model%bodies(body)%name
         if (model%bodies(body)%kind == body_point) cycle
         if (is_bent_beam(model, body)) then
            call add_stroke(geometry, filled, [(i, i=place + 1, place + stretches(model, body) + 1)], .false.)
            call add_stations(model, layout, body, geometry, place, shape)
         else if (model%bodies(body)%is_frame) then
            do member = 1, members(model, body)
               call add_stroke(geometry, filled, [(i, i=place + 1, place + stretches(model, body) + 1)], .false.)
               call add_member_stations(model, body, member, geometry, place, shape)
            end do
         else
            call add_outline(order(first(body):first(body + 1) - 1), drawn, geometry, filled)
         end if
      end do
      do i = 1, size(model%joints)
         call add_curve(model, layout, model%joints(i), geometry, place, shape, filled)
      end do
      geometry%stroke_places = geometry%stroke_places(:filled(2))
      call prepare(geometry)
   end function geometry_of

   !> Allocates the lists; that of the places in strokes longer than needed.
   subroutine size_geometry(model, layout, geometry)
      type(model_type), intent(in) :: model
      type(layout_type), intent(in) :: layout
      type(geometry_type), intent(inout) :: geometry
      integer :: body, places, shapes, strokes, i
      places = size(model%points)
      shapes = 0
      do i = 1, places
         if (is_exact(model, model%points(i)%body)) then
            shapes = shapes + 2*(body_width(model, layout, model%points(i)%body) - 4)
         else
            shapes = shapes + size(model%points(i)%phi)
         end if
      end do
      ! Those that carry states of controls are the last, and not drawn
      allocate (geometry%bodies(count(model%bodies%control == 0)))
      allocate (geometry%widths(size(geometry%bodies)))
      do body = 1, size(geometry%bodies)
         geometry%widths(body) = body_width(model, layout, body)
         if (.not. (is_bent_beam(model, body) .or. model%bodies(body)%is_frame)) cycle
         places = places + members(model, body)*(stretches(model, body) + 1)
         if (is_exact(model, body)) then
            shapes = shapes + 2*(body_width(model, layout, body) - 4)*(stretches(model, body) + 1)
         else
            shapes = shapes + 2*layout%n(body)*members(model, body)*(stretches(model, body) + 1)
         end if
      end do
      strokes = 0
      do body = 1, size(model%bodies)
         if (model%bodies(body)%kind /= body_point) strokes = strokes + members(model, body)
      end do
      do i = 1, size(model%joints)
         if (places_of_curve(model%joints(i)) == 0) cycle
         strokes = strokes + 1
         places = places + places_of_curve(model%joints(i))
         associate (point => model%points(model%joints(i)%points(2)))
            if (is_exact(model, point%body)) then
               shapes = shapes + 2*places_of_curve(model%joints(i))*(body_width(model, layout, point%body) - 4)
            else
               shapes = shapes + places_of_curve(model%joints(i))*size(point%phi)
            end if
         end associate
      end do
      allocate (geometry%places(2, places), geometry%place_bodies(places), geometry%place_names(places), geometry%shapes(shapes))
      allocate (geometry%stroke_widths(strokes), geometry%stroke_closed(strokes), geometry%stroke_places(places))
      geometry%place_names = ''
      geometry%stroke_widths = 0
   end subroutine size_geometry

   !> Whether a body, or the ground, carries a state of a control.
   pure logical function is_state(model, body)
      type(model_type), intent(in) :: model
      integer, intent(in) :: body
      is_state = .false.
      if (body > 0) is_state = model%bodies(body)%control > 0
   end function is_state

   !> Whether a body, or the ground, is a beam, rigid or not.
   pure logical function is_beam(model, body)
      type(model_type), intent(in) :: model
      integer, intent(in) :: body
      is_beam = .false.
      if (body > 0) is_beam = model%bodies(body)%end_point > 0
   end function is_beam

   !> Whether a body is an exact beam.
   pure logical function is_exact(model, body)
      type(model_type), intent(in) :: model
      !> Or the ground
      integer, intent(in) :: body
      is_exact = .false.
      if (body > 0) is_exact = model%bodies(body)%reduced%is_exact
   end function is_exact

   !> Whether a body is a beam that bends.
   pure logical function is_bent_beam(model, body)
      type(model_type), intent(in) :: model
      integer, intent(in) :: body
      is_bent_beam = is_beam(model, body) .and. model%bodies(body)%kind == body_flexible
   end function is_bent_beam

   !> Number of strokes that a body is drawn with: the members of a frame.
   pure integer function members(model, body)
      type(model_type), intent(in) :: model
      integer, intent(in) :: body
      members = 1
      if (model%bodies(body)%is_frame) members = size(model%bodies(body)%mesh%first) - 1
   end function members

   !> Number of stretches of a beam's outline, or of that of a member.
   pure integer function stretches(model, body)
      type(model_type), intent(in) :: model
      integer, intent(in) :: body
      if (model%bodies(body)%is_frame) then
         stretches = merge(member_stretches, 1, model%bodies(body)%kind == body_flexible)
         return
      end if
      stretches = stretches_of_beam(model, body)
   end function stretches

   !> Adds a place.
   pure subroutine add_place(body, p0, phi, geometry, place, shape)
      integer, intent(in) :: body
      !> Undeformed place (2) and displacement for each coordinate (2,n)
      real(wp), intent(in) :: p0(2), phi(:, :)
      type(geometry_type), intent(inout) :: geometry
      !> Places and entries of shapes so far
      integer, intent(inout) :: place, shape
      integer :: k
      place = place + 1
      geometry%places(:, place) = p0
      geometry%place_bodies(place) = body
      do k = 1, size(phi, 2)
         geometry%shapes(shape + 1:shape + 2) = phi(:, k)
         shape = shape + 2
      end do
   end subroutine add_place

   !> Adds the places along a beam.
   subroutine add_stations(model, layout, body, geometry, place, shape)
      type(model_type), intent(in) :: model
      type(layout_type), intent(in) :: layout
      integer, intent(in) :: body
      type(geometry_type), intent(inout) :: geometry
      integer, intent(inout) :: place, shape
      real(wp), allocatable :: phi(:, :), psi(:)
      real(wp) :: s, p0(2)
      integer :: i
      associate (beam => model%bodies(body))
         do i = 0, stretches(model, body)
            s = beam%beam%length*i/stretches(model, body)
            if (is_exact(model, body)) then
               phi = drawn_shape(model, layout, body, named_places(model, body) + 1 + i)
            else
               call point_shape(beam%field, s, phi, psi)
            end if
            p0 = [s - beam%choice%origin, 0.0_wp]
            if (is_exact(model, body)) p0 = undeformed_place(beam%reduced%exact, s)
            call add_place(body, p0, phi, geometry, place, shape)
         end do
      end associate
   end subroutine add_stations

   !> Adds the places along a member of a frame.
   subroutine add_member_stations(model, body, member, geometry, place, shape)
      type(model_type), intent(in) :: model
      integer, intent(in) :: body, member
      type(geometry_type), intent(inout) :: geometry
      integer, intent(inout) :: place, shape
      real(wp), allocatable :: phi(:, :), psi(:)
      real(wp) :: s
      integer :: i, first
      associate (frame => model%bodies(body))
         first = frame%mesh%first(member)
         do i = 0, stretches(model, body)
            s = member_length(frame%mesh, member)*i/stretches(model, body)
            if (frame%kind == body_flexible) then
               call frame_point_shape(frame%mesh, frame%shape, member, s, phi, psi)
            else if (.not. allocated(phi)) then
               allocate (phi(2, 0))
            end if
            call add_place(body, frame%mesh%place(:, frame%mesh%ends(1, first)) + s*frame%mesh%axis(:, first), phi, geometry, &
               & place, shape)
         end do
      end associate
   end subroutine add_member_stations

   !> What joints and springs connect; couplers have no points.
   subroutine take_connections(model, geometry)
      type(model_type), intent(in) :: model
      type(geometry_type), intent(inout) :: geometry
      integer :: i, k, n
      n = count([(len(model%loads(i)%symbol) > 0, i=1, size(model%loads))])
      do i = 1, size(model%joints)
         if (all(model%joints(i)%points > 0)) n = n + 1
      end do
      allocate (geometry%connections(n), geometry%connection_types(n), geometry%connection_places(2, n), &
         & geometry%connection_angles(n), geometry%connection_radii(2, n))
      geometry%connection_angles = 0.0_wp
      geometry%connection_radii = 0.0_wp
      k = 0
      do i = 1, size(model%joints)
         if (any(model%joints(i)%points == 0)) cycle
         k = k + 1
         geometry%connections(k) = model%joints(i)%name
         geometry%connection_types(k) = model%joints(i)%symbol
         if (index(model%joints(i)%name, '/') > 0) geometry%connection_types(k) = 'SEGMENTS'
         geometry%connection_places(:, k) = model%joints(i)%points
         geometry%connection_angles(k) = model%joints(i)%angle - model%points(model%joints(i)%points(2))%lean
         geometry%connection_radii(:, k) = model%joints(i)%radius
      end do
      do i = 1, size(model%loads)
         if (len(model%loads(i)%symbol) == 0) cycle
         k = k + 1
         geometry%connections(k) = model%loads(i)%name
         geometry%connection_types(k) = model%loads(i)%symbol
         geometry%connection_places(:, k) = model%load_parts(model%loads(i)%first)%points
      end do
   end subroutine take_connections

   !> Number of places along the curve of a joint; 0 if it has none, or one that has no ends, y of x.
   pure integer function places_of_curve(joint) result(places)
      type(joint_type), intent(in) :: joint
      places = 0
      if (joint%place == place_on_curve .and. .not. joint%curve%explicit) places = per_knot*(size(joint%curve%s) - 1) + 1
   end function places_of_curve

   !> Adds the curve of a joint, which belongs to the body of its second point.
   subroutine add_curve(model, layout, joint, geometry, place, shape, filled)
      type(model_type), intent(in) :: model
      type(layout_type), intent(in) :: layout
      type(joint_type), intent(in) :: joint
      type(geometry_type), intent(inout) :: geometry
      integer, intent(inout) :: place, shape, filled(2)
      real(wp) :: x(0:2), y(0:2), s, gap
      integer :: i, n
      n = places_of_curve(joint)
      if (n == 0) return
      call add_stroke(geometry, filled, [(i, i=place + 1, place + n)], .false.)
      associate (point => model%points(joint%points(2)), curve => joint%curve)
         do i = 1, n
            s = curve%s(1) + (curve%s(size(curve%s)) - curve%s(1))*(i - 1)/(n - 1)
            x = spline_at(curve%ends, curve%s, curve%x, curve%x_bent, s)
            y = spline_at(curve%ends, curve%s, curve%y, curve%y_bent, s)
            if (is_exact(model, point%body)) then
               call add_place(point%body, point%p0 + [x(0), y(0)], drawn_shape(model, layout, point%body, &
                  & drawn_place(model, joint%points(2))), geometry, place, shape)
            else
               call add_place(point%body, point%p0 + [x(0), y(0)], point%phi, geometry, place, shape)
            end if
         end do
      end associate
      gap = norm2(geometry%places(:, place) - geometry%places(:, place - n + 1))
      if (gap <= 1.0e-9_wp*norm2(geometry%places(:, place - n/2) - geometry%places(:, place))) geometry%stroke_closed(filled(1)) = 1
   end subroutine add_curve

   !> Numbers of the points of each body in their order: order(first(body):first(body + 1) - 1).
   pure subroutine sort_points(model, order, first)
      type(model_type), intent(in) :: model
      integer, allocatable, intent(out) :: order(:), first(:)
      integer, allocatable :: next(:)
      integer :: i, body
      allocate (first(size(model%bodies) + 1), next(size(model%bodies)), order(size(model%points)))
      next = 0
      do i = 1, size(model%points)
         if (model%points(i)%body > 0) next(model%points(i)%body) = next(model%points(i)%body) + 1
      end do
      first(1) = 1
      do body = 1, size(next)
         first(body + 1) = first(body) + next(body)
      end do
      next = first(:size(next))
      do i = 1, size(model%points)
         body = model%points(i)%body
         if (body == 0) cycle
         order(next(body)) = i
         next(body) = next(body) + 1
      end do
   end subroutine sort_points

   !> Which points outlines go through: those that are connected, or that the deck names; of a rigid beam also its ends.
   subroutine find_drawn(model, geometry, drawn)
      type(model_type), intent(in) :: model
      type(geometry_type), intent(in) :: geometry
      logical, allocatable, intent(out) :: drawn(:)
      integer :: i
      allocate (drawn(size(model%points)))
      do i = 1, size(drawn)
         associate (name => model%points(i)%name)
            if (model%points(i)%direction) then
               drawn(i) = .false.
            else if (is_beam(model, model%points(i)%body)) then
               drawn(i) = index(points_of_beams, ' '//name(index(name, '.') + 1:)//' ') == 0
            else
               drawn(i) = index(points_of_bodies, ' '//name(index(name, '.') + 1:)//' ') == 0
            end if
         end associate
      end do
      do i = 1, size(geometry%connection_places, 2)
         drawn(geometry%connection_places(:, i)) = .true.
      end do
      do i = 1, size(model%bodies)
         if (.not. is_beam(model, i)) cycle
         drawn(model%bodies(i)%start_point) = .true.
         drawn(model%bodies(i)%end_point) = .true.
      end do
   end subroutine find_drawn

   !> Adds the outline of a rigid body: the convex hull of its drawn points; with the centre of mass and the origin of the frame
   !> among them if they are no more than one without.
   subroutine add_outline(points, drawn, geometry, filled)
      !> Numbers of its points: first its origin, then, if it has one, its centre of mass
      integer, intent(in) :: points(:)
      logical, intent(in) :: drawn(:)
      type(geometry_type), intent(inout) :: geometry
      integer, intent(inout) :: filled(2)
      integer, allocatable :: chosen(:), corners(:)
      integer :: i
      allocate (chosen, source=pack(points, drawn(points)))
      do i = min(2, size(points)), 1, -1
         call hull(geometry%places, chosen, corners)
         if (size(corners) > 1) exit
         chosen = [chosen, points(i)]
      end do
      call hull(geometry%places, chosen, corners)
      call add_stroke(geometry, filled, corners, size(corners) > 2)
   end subroutine add_outline

   !> Adds a stroke.
   subroutine add_stroke(geometry, filled, places, closed)
      type(geometry_type), intent(inout) :: geometry
      !> Strokes, and places in them, so far
      integer, intent(inout) :: filled(2)
      integer, intent(in) :: places(:)
      logical, intent(in) :: closed
      geometry%stroke_places(filled(2) + 1:filled(2) + size(places)) = places
      filled = filled + [1, size(places)]
      geometry%stroke_widths(filled(1)) = size(places)
      geometry%stroke_closed(filled(1)) = merge(1, 0, closed)
   end subroutine add_stroke

   !> Corners of the convex hull, against the clock; two if all points are in a line, one if they are in one place.
   !> Source: Andrew 1979, monotone chain.
   subroutine hull(places, points, corners)
      real(wp), intent(in) :: places(:, :)
      !> Columns of `places`, in any order
      integer, intent(in) :: points(:)
      integer, allocatable, intent(out) :: corners(:)
      integer :: sorted(size(points)), chain(2*size(points) + 1)
      integer :: i, top, bottom
      sorted = points
      call sort_places(places, sorted)
      top = 0
      do i = 1, size(sorted)
         call push(sorted(i), 1)
      end do
      bottom = top
      do i = size(sorted) - 1, 1, -1
         call push(sorted(i), bottom)
      end do
      ! The last corner is the first one again
      allocate (corners, source=chain(:max(min(1, size(points)), top - 1)))

   contains

      !> Adds a point, and drops those before it, down to the end `base` of the chain, that then lie inside.
      subroutine push(point, base)
         integer, intent(in) :: point, base
         if (top > 0) then
            if (all(.not. abs(places(:, point) - places(:, chain(top))) > 0.0_wp)) return
         end if
         do while (top > base)
            if (cross(places(:, chain(top)) - places(:, chain(top - 1)), places(:, point) - places(:, chain(top))) > 0.0_wp) exit
            top = top - 1
         end do
         top = top + 1
         chain(top) = point
      end subroutine push

   end subroutine hull

   !> Sorts points by x, then y, by insertion.
   pure subroutine sort_places(places, points)
      real(wp), intent(in) :: places(:, :)
      integer, intent(inout) :: points(:)
      integer :: i, j, point
      do i = 2, size(points)
         point = points(i)
         j = i - 1
         do while (j >= 1)
            if (.not. is_before(places(:, point), places(:, points(j)))) exit
            points(j + 1) = points(j)
            j = j - 1
         end do
         points(j + 1) = point
      end do

   contains

      pure logical function is_before(a, b)
         real(wp), intent(in) :: a(2), b(2)
         is_before = a(1) < b(1)
         if (.not. abs(a(1) - b(1)) > 0.0_wp) is_before = a(2) < b(2)
      end function is_before

   end subroutine sort_places

end module limber_output_outline
