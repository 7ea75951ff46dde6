!> Distributed loads as forces at moving points. The displacement of such a point is the mean over the load, weighted with it. The
!> distribution is kept for section forces. Floor: model. Source: doc/theory, eqs. (3.37), (3.38).
module limber_model_distributed_loads
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_deck_content, only: block_type, line_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_expression, only: expression_type
   use limber_deck_origin, only: origin_type
   use limber_beam_plane_frame, only: member_length
   use limber_beam_frame_reduction, only: frame_point_shape
   use limber_beam_exact_beam, only: lean_at
   use limber_beam_beam_reduction, only: point_shape, exact_shape
   use limber_model_law_breaks, only: law_breaks, law_stations, undefined_at
   use limber_model_load_parts, only: new_part, set_law, append_part, name_load, constant
   use limber_model_points, only: add_point, find_body
   use limber_model_beam_segments, only: pieces_of, piece_start
   use limber_model_model, only: model_type, load_part_type, distributed_load_type, body_type, body_flexible, along_axis, &
      & along_follower
   implicit none
   private
   public :: add_distributed, spread_parts

   real(wp), parameter :: quarter = 0.5_wp*acos(-1.0_wp)
   !> Bending coordinates per interval of a follower load
   integer, parameter :: follower_coordinates = 3
   !> Error of the integral of a load relative to the integral of its magnitude; shortest interval relative to the whole; most
   !> intervals
   real(wp), parameter :: exactly = 1.0e-9_wp, shortest = 1.0e-9_wp
   integer, parameter :: most_intervals = 5000
   !> Gauss points and weights on an interval from -1 to 1
   real(wp), parameter :: points(5) = [-0.906179845938663993_wp, -0.538469310105683091_wp, 0.0_wp, 0.538469310105683091_wp, &
      & 0.906179845938663993_wp]
   real(wp), parameter :: weights(5) = [0.236926885056189088_wp, 0.478628670499366468_wp, 0.568888888888888889_wp, &
      & 0.478628670499366468_wp, 0.236926885056189088_wp]

contains

   !> Adds a distributed load: one or two parts for each component of each line.
   subroutine add_distributed(block, model, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp) :: ends(2), length
      integer :: body, pieces(2), member, i, k, first
      body = find_body(model, block%name('BODY'))
      if (body == 0) return
      pieces = pieces_of(model, body)
      if (is_large_frame()) then
         call find_large(member)
         if (member == 0) return
         pieces = pieces(1) + member - 1
         length = model%bodies(pieces(1))%beam%length
         member = 1
      else
         call find_member(block, model%bodies(body), member, length, diagnostics)
         if (member == 0) return
      end if
      length = length*(pieces(2) - pieces(1) + 1)
      ends = [block%real('START'), length]
      if (block%has('END')) ends(2) = block%real('END')
      if (ends(2) > length*(1 + 1.0e-12_wp) .or. ends(1) >= ends(2)) then
         call diagnostics%add(block%origin_of('END'), "load '"//block%name()//"' acts from "//as_text(ends(1))//' to '// &
            & as_text(ends(2)), trim(merge('member', 'beam  ', model%bodies(body)%is_frame))//" of '"//block%name('BODY')// &
            & "' goes from 0 to "//as_text(length))
         return
      end if
      first = size(model%load_parts) + 1
      do i = 1, size(block%lines)
         do k = 1, 2
            if (.not. has_values(block%lines(i)%fields(k)%expression, block%lines(i)%fields(k)%origin)) cycle
            do body = pieces(1), pieces(2)
               call add_share(block, block%lines(i), k, body, member, piece_start(model, body), ends, model)
            end do
         end do
      end do
      call name_load(model, block%name(), first)

   contains

      !> Whether a load has a value everywhere, and not too many breaks; else adds an error.
      logical function has_values(law, origin)
         type(expression_type), intent(in) :: law
         type(origin_type), intent(in) :: origin
         real(wp), allocatable :: edges(:)
         real(wp) :: place
         place = undefined_at(law, ends(1), ends(2))
         has_values = place > ends(2)
         if (.not. has_values) then
            call diagnostics%add(origin, "load '"//block%name()//"' has no value, or grows without bound, at s = "// &
               & as_text(place, 6), 'let START= and END= keep it away, or write a law that is finite throughout')
            return
         end if
         allocate (edges, source=ends)
         call refine(law, 0.0_wp, 0.0_wp, edges)
         has_values = size(edges) <= most_intervals
         if (.not. has_values) call diagnostics%add(origin, "load '"//block%name()//"' changes more often along it than "// &
            & as_text(most_intervals)//' intervals show', 'write a smoother law, or several loads with START= and END=')
      end function has_values

      !> Whether the body is a frame of exact beams.
      pure logical function is_large_frame()
         is_large_frame = model%bodies(body)%whole > 0
         if (is_large_frame) is_large_frame = allocated(model%wholes(model%bodies(body)%whole)%lean)
      end function is_large_frame

      !> Index of the loaded member of a large frame; 0 and an error if there is none.
      subroutine find_large(found)
         integer, intent(out) :: found
         found = 0
         if (.not. block%has('MEMBER')) then
            call diagnostics%add(block%origin, "load '"//block%name()//"' acts on a frame", 'add MEMBER=, the number of a member')
            return
         end if
         found = findloc(model%wholes(model%bodies(body)%whole)%member_numbers, block%integer('MEMBER'), dim=1)
         if (found == 0) call diagnostics%add(block%origin_of('MEMBER'), "frame '"//block%name('BODY')//"' has no member "// &
            & as_text(block%integer('MEMBER')))
      end subroutine find_large

   end subroutine add_distributed

   !> Index and length of the loaded member; 0 and an error if there is none.
   subroutine find_member(block, body, member, length, diagnostics)
      type(block_type), intent(in) :: block
      type(body_type), intent(in) :: body
      integer, intent(out) :: member
      real(wp), intent(out) :: length
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: number
      member = 1
      length = body%beam%length
      if (.not. body%is_frame) then
         if (block%has('MEMBER')) call diagnostics%add(block%origin_of('MEMBER'), "'"//body%name//"' is a beam and has no members")
         return
      end if
      member = 0
      if (.not. allocated(body%mesh%first)) return
      if (.not. block%has('MEMBER')) then
         call diagnostics%add(block%origin, "load '"//block%name()//"' acts on a frame", 'add MEMBER=, the number of a member')
         return
      end if
      number = block%integer('MEMBER')
      do member = size(body%member_numbers), 1, -1
         if (body%member_numbers(member) == number) exit
      end do
      if (member == 0) then
         call diagnostics%add(block%origin_of('MEMBER'), "frame '"//body%name//"' has no member "//as_text(number))
      else
         length = member_length(body%mesh, member)
      end if
   end subroutine find_member

   !> Adds one component of one line on one body.
   subroutine add_share(block, line, component, body, member, start, whole, model)
      type(block_type), intent(in) :: block
      type(line_type), intent(in) :: line
      integer, intent(in) :: component, body, member
      !> Coordinate along the beam at the start of this piece; interval of the load on the beam or member (2) [length]
      real(wp), intent(in) :: start, whole(2)
      type(model_type), intent(inout) :: model
      real(wp) :: total, absolute, place, level, ends(2)
      real(wp), allocatable :: shape(:, :), reach(:)
      ends = whole - start
      if (.not. model%bodies(body)%is_frame) ends = min(max(ends, 0.0_wp), model%bodies(body)%beam%length)
      if (.not. ends(2) > ends(1)) return
      allocate (shape(2, model%bodies(body)%reduced%n), reach(0))
      if (model%bodies(body)%reduced%is_exact) reach = model%bodies(body)%reduced%exact%base
      associate (law => line%fields(component)%expression)
         if (block%yes('FOLLOWER') .and. model%bodies(body)%reduced%n > 0) then
            call follow_sections()
            return
         end if
         call weigh(model%bodies(body), member, law, start, 0.0_wp, ends, total, absolute, place, shape, reach)
         if (.not. absolute > 0.0_wp) return
         if (abs(total) >= 0.01_wp*absolute) then
            call push(law, 0.0_wp, total)
         else
            ! A load whose parts cancel has no place: a uniform one is added and taken away
            level = absolute/(ends(2) - ends(1))
            call weigh(model%bodies(body), member, constant(1.0_wp), start, 0.0_wp, ends, total, absolute, place, shape, reach)
            call push(constant(1.0_wp), 0.0_wp, total, -level)
            call weigh(model%bodies(body), member, law, start, level, ends, total, absolute, place, shape, reach)
            call push(law, level, total)
         end if
      end associate

   contains

      !> Adds a force with the last integrals of a load.
      subroutine push(law, added, total, factor)
         type(expression_type), intent(in) :: law
         real(wp), intent(in) :: added, total
         !> Factor of the force, default 1
         real(wp), intent(in), optional :: factor
         real(wp) :: psi(size(shape, 2)), force
         psi = 0.0_wp
         force = total
         if (present(factor)) force = factor*total
         call act(place/total, shape/total, psi, reach/total, force)
         call append_spread(model, law, start, added, total, member, ends)
      end subroutine push

      !> Adds follower forces at the Gauss points, eq. (3.38). In each interval the load is divided by the Lagrange polynomials of
      !> the points. Their sum is 1, so that force, moment and virtual work at rest remain.
      subroutine follow_sections()
         real(wp), allocatable :: phi(:, :), psi(:), own(:)
         real(wp) :: whole(2), s(size(points))
         integer :: i, k, count
         count = 1 + model%bodies(body)%reduced%bending/follower_coordinates
         whole = ends
         associate (law => line%fields(component)%expression)
            do k = 1, count
               ends = whole(1) + (whole(2) - whole(1))*[k - 1, k]/real(count, wp)
               s(:) = 0.5_wp*(ends(1) + ends(2)) + 0.5_wp*(ends(2) - ends(1))*points
               do i = 1, size(points)
                  call weigh(model%bodies(body), member, law, start, 0.0_wp, ends, total, absolute, place, shape, reach, i)
                  if (.not. absolute > 0.0_wp) cycle
                  call section_shape(model%bodies(body), member, s(i), phi, psi, own)
                  if (abs(total) > 0.01_wp*absolute) then
                     call act(place/total, shape/total, psi, reach/total, total)
                     call append_spread(model, law, start, 0.0_wp, total, member, ends, i)
                  else
                     call act(s(i), phi, psi, own, total)
                  end if
               end do
            end do
         end associate
      end subroutine follow_sections

      !> Adds a force at a point that represents a load.
      subroutine act(along, phi, psi, reach, force)
         !> Coordinate along the beam or member [length]; shapes of the point (2, n) and of its section (n); for an exact beam the
         !> weights of its stations in the position (stations)
         real(wp), intent(in) :: along, phi(:, :), psi(:), reach(:)
         real(wp), intent(in) :: force
         type(load_part_type) :: part
         real(wp) :: origin(2), axis(2)
         call line_of(model%bodies(body), member, origin, axis)
         if (model%bodies(body)%reduced%is_exact) then
            call add_point(model, ' '//block%name(), body, origin + axis*along, phi, psi, reach)
         else
            call add_point(model, ' '//block%name(), body, origin + axis*along, phi, psi)
         end if
         model%points(model%counts%points)%member = member
         model%points(model%counts%points)%along = along
         part = new_part(merge(along_follower, along_axis, block%yes('FOLLOWER')), model%counts%points, 0)
         part%angle = (component - 1)*quarter
         if (block%yes('FOLLOWER')) part%angle = part%angle + atan2(axis(2), axis(1))
         if (block%yes('FOLLOWER') .and. model%bodies(body)%reduced%is_exact) &
            & part%angle = part%angle + lean_at(model%bodies(body)%reduced%exact, along)
         if (line%count() > 2) then
            call set_law(part, line%fields(3)%expression, force)
         else
            call set_law(part, constant(1.0_wp), force)
         end if
         call append_part(model, part)
      end subroutine act

   end subroutine add_share

   !> Start and direction of a member in the axes of its body (2), (2).
   pure subroutine line_of(body, member, origin, axis)
      type(body_type), intent(in) :: body
      integer, intent(in) :: member
      real(wp), intent(out) :: origin(2), axis(2)
      origin = [-body%choice%origin, 0.0_wp]
      axis = [1.0_wp, 0.0_wp]
      if (.not. body%is_frame) return
      associate (e => body%mesh%first(member))
         origin = body%mesh%place(:, body%mesh%ends(1, e))
         axis = body%mesh%axis(:, e)
      end associate
   end subroutine line_of

   !> Stores the distribution of a load for the last point.
   subroutine append_spread(model, law, start, added, total, member, ends, station)
      type(model_type), intent(inout) :: model
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: start, added, total, ends(2)
      integer, intent(in) :: member
      !> Number of the Gauss point of this share; absent for the whole load
      integer, intent(in), optional :: station
      type(distributed_load_type), allocatable :: longer(:)
      integer :: n
      n = size(model%spreads) + 1
      allocate (longer(n))
      longer(:n - 1) = model%spreads
      longer(n)%point = model%counts%points
      longer(n)%member = member
      longer(n)%ends = ends
      longer(n)%law = law
      longer(n)%start = start
      longer(n)%added = added
      longer(n)%total = total
      if (present(station)) longer(n)%station = station
      call move_alloc(longer, model%spreads)
   end subroutine append_spread

   !> Integrals along a member: of a load, of its magnitude, and of coordinate and shapes times the load.
   subroutine weigh(body, member, law, start, added, ends, total, absolute, place, shape, reach, station)
      type(body_type), intent(in) :: body
      integer, intent(in) :: member
      !> Load as a function of s along the beam or member; s at the start of the body [length]; constant to be added [force/length]
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: start, added, ends(2)
      !> [force], [force], [force length]; shape (2, n); for an exact beam weights of its stations (stations), else of size 0
      real(wp), intent(out) :: total, absolute, place, shape(:, :), reach(:)
      !> Number of the Gauss point whose share is meant; absent for the whole load
      integer, intent(in), optional :: station
      real(wp), allocatable :: edges(:), s(:), q(:), phi(:, :), psi(:), own(:)
      integer :: g
      allocate (edges, source=edges_of(body, member, ends))
      call refine(law, start, added, edges)
      call sample(law, start, added, edges, s, q)
      if (present(station)) q = q*part_of_station(station, ends, s)
      total = sum(q)
      absolute = sum(abs(q))
      place = sum(q*s)
      shape = 0.0_wp
      reach = 0.0_wp
      if (body%kind /= body_flexible) return
      do g = 1, size(s)
         call section_shape(body, member, s(g), phi, psi, own)
         shape = shape + q(g)*phi
         if (size(reach) > 0) reach = reach + q(g)*own
      end do
   end subroutine weigh

   !> Displacement (2, n) and rotation (n) of a section of a beam or member for unit coordinates.
   pure subroutine section_shape(body, member, s, phi, psi, reach)
      type(body_type), intent(in) :: body
      integer, intent(in) :: member
      !> Coordinate along the body [length]
      real(wp), intent(in) :: s
      real(wp), allocatable, intent(out) :: phi(:, :), psi(:)
      !> For an exact beam weights of its stations in the position (stations), else of size 0
      real(wp), allocatable, intent(out) :: reach(:)
      allocate (reach(0))
      if (body%is_frame) then
         call frame_point_shape(body%mesh, body%shape, member, s, phi, psi)
      else if (body%reduced%is_exact) then
         call exact_shape(body%reduced%exact, s, phi, psi, reach)
      else
         call point_shape(body%field, s, phi, psi)
      end if
   end subroutine section_shape

   !> Coordinates of point forces that represent a load, and their shares, with the sum 1. Intervals end at sections.
   subroutine spread_parts(spread, body, sections, at, part)
      type(distributed_load_type), intent(in) :: spread
      type(body_type), intent(in) :: body
      !> Coordinates of sections along the member [length]
      real(wp), intent(in) :: sections(:)
      real(wp), allocatable, intent(inout) :: at(:), part(:)
      real(wp), allocatable :: edges(:)
      real(wp) :: cut
      integer :: i, k
      allocate (edges, source=edges_of(body, spread%member, spread%ends))
      call refine(spread%law, spread%start, spread%added, edges)
      do i = 1, size(sections)
         cut = sections(i)
         if (cut <= edges(1) .or. cut >= edges(size(edges))) cycle
         k = count(edges < cut)
         edges = [edges(:k), cut, edges(k + 1:)]
      end do
      call sample(spread%law, spread%start, spread%added, edges, at, part)
      if (spread%station > 0) part = part*part_of_station(spread%station, spread%ends, at)
      part = part/spread%total
   end subroutine spread_parts

   !> Lagrange polynomial of a Gauss point.
   elemental real(wp) function lagrange(station, x) result(value)
      integer, intent(in) :: station
      !> Coordinate in the interval, from -1 to 1
      real(wp), intent(in) :: x
      integer :: i
      value = 1.0_wp
      do i = 1, size(points)
         if (i /= station) value = value*(x - points(i))/(points(station) - points(i))
      end do
   end function lagrange

   !> Share of a load at places s that belongs to one Gauss point of the interval.
   pure function part_of_station(station, ends, s) result(part)
      integer, intent(in) :: station
      real(wp), intent(in) :: ends(2), s(:)
      real(wp) :: part(size(s))
      part = lagrange(station, (2*s - ends(1) - ends(2))/(ends(2) - ends(1)))
   end function part_of_station

   !> Ends of the intervals of a load, divided at the nodes of its member [length].
   pure function edges_of(body, member, ends) result(edges)
      type(body_type), intent(in) :: body
      integer, intent(in) :: member
      real(wp), intent(in) :: ends(2)
      real(wp), allocatable :: edges(:), nodes(:)
      integer :: e
      if (body%is_frame) then
         allocate (nodes(body%mesh%first(member + 1) - body%mesh%first(member)))
         nodes = body%mesh%from(body%mesh%first(member):body%mesh%first(member + 1) - 1)
      else if (body%kind == body_flexible) then
         allocate (nodes(size(body%field%s)))
         nodes = body%field%s
      else
         allocate (nodes(body%beam%elements))
         nodes = [(body%beam%length*e/body%beam%elements, e=1, body%beam%elements)]
      end if
      allocate (edges(2 + count(nodes > ends(1) .and. nodes < ends(2))))
      edges = [ends(1), pack(nodes, nodes > ends(1) .and. nodes < ends(2)), ends(2)]
   end function edges_of

   !> Divides the intervals of a load at its breaks and short pulses. Then it halves each interval until the Gauss formula on both
   !> halves agrees with the whole. Stops beyond `most_intervals`.
   subroutine refine(law, start, added, edges)
      type(expression_type), intent(in) :: law
      !> As in `weigh`
      real(wp), intent(in) :: start, added
      !> Edges in ascending order [length]
      real(wp), allocatable, intent(inout) :: edges(:)
      real(wp), allocatable :: bends(:), fine(:), s(:), q(:)
      real(wp) :: scale
      integer :: i, k
      if (size(law%slots) == 0) return
      allocate (bends(0))
      associate (first => start + edges(1), last => start + edges(size(edges)))
         call law_breaks(law, first, last, bends)
         call law_stations(law, first, last, bends)
      end associate
      do i = 1, size(bends)
         k = count(edges < bends(i) - start)
         if (k == 0 .or. k == size(edges)) cycle
         if (abs(edges(k + 1) - (bends(i) - start)) > 0.0_wp) edges = [edges(:k), bends(i) - start, edges(k + 1:)]
      end do
      call sample(law, start, added, edges, s, q)
      scale = exactly*sum(abs(q))
      allocate (fine, source=edges(:1))
      do i = 1, size(edges) - 1
         call divide(edges(i), edges(i + 1))
         fine = [fine, edges(i + 1)]
      end do
      call move_alloc(fine, edges)

   contains

      !> Adds edges within an interval where they are needed.
      recursive subroutine divide(left, right)
         real(wp), intent(in) :: left, right
         real(wp) :: middle
         real(wp), allocatable :: at(:), whole(:), halves(:)
         if (size(fine) > most_intervals .or. right - left <= shortest*(edges(size(edges)) - edges(1))) return
         middle = left + 0.5_wp*(right - left)
         call sample(law, start, added, [left, right], at, whole)
         call sample(law, start, added, [left, middle, right], at, halves)
         if (abs(sum(whole) - sum(halves)) <= scale .and. abs(sum(abs(whole)) - sum(abs(halves))) <= scale) return
         call divide(left, middle)
         fine = [fine, middle]
         call divide(middle, right)
      end subroutine divide

   end subroutine refine

   !> Values of a load at the Gauss points of all intervals, times their weights [force].
   subroutine sample(law, start, added, edges, s, q)
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: start, added, edges(:)
      real(wp), allocatable, intent(inout) :: s(:), q(:)
      real(wp) :: values(1), half
      integer :: i, g, k
      if (allocated(s)) deallocate (s)
      if (allocated(q)) deallocate (q)
      allocate (s(5*(size(edges) - 1)), q(5*(size(edges) - 1)))
      do i = 1, size(edges) - 1
         half = 0.5_wp*(edges(i + 1) - edges(i))
         do g = 1, 5
            k = 5*(i - 1) + g
            s(k) = edges(i) + half*(1 + points(g))
            values = start + s(k)
            q(k) = (law%evaluate(values) + added)*weights(g)*half
         end do
      end do
   end subroutine sample

end module limber_model_distributed_loads
