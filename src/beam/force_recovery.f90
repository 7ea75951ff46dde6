!> Section forces of a flexible body with modes. The modal sum, and in addition what the functions that were left out carry at rest
!> (mode acceleration). Everything is linear in few amplitudes, whose coefficients are made once. Floor: beam. Source: doc/theory,
!> eqs. (2.24)-(2.26), (2.28).
module limber_beam_force_recovery
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_beam_element_matrices, only: bending_shape, bending_slope, bending_dofs, geometric_stiffness
   use limber_beam_plane_frame, only: frame_type, element_at, element_forces, own_displacements, add_element_load, unit_load
   use limber_beam_frame_solver, only: solver_type, new_solver, solve_static
   use limber_beam_reduced_body, only: reduced_type
   implicit none
   private
   public :: section_type, load_place_type, recovery_type, new_recovery, exact_recovery, all_sections, amplitudes, &
      & geometric_state, internal_forces

   !> A section: a place of a member, seen from the side of the member's start, or from that of its end
   type :: section_type
      integer :: member = 1
      !> Coordinate along the member [length]
      real(wp) :: x = 0.0_wp
      logical :: behind = .false.
   end type section_type

   !> A place where joints and loads act
   type :: load_place_type
      integer :: member = 1
      !> Coordinate along the member [length]
      real(wp) :: x = 0.0_wp
      !> Of a load along the member: where its parts act [length], and these, with the sum 1; otherwise unallocated
      real(wp), allocatable :: at(:), part(:)
   end type load_place_type

   !> Of a frame whose members bend under tension: its mesh, to find what the geometric forces of the members do to the functions
   !> that were left out, eq. (2.24)
   type :: frame_tension_type
      type(frame_type) :: frame
      type(solver_type) :: solver
      !> Shapes of the coordinates (3, nodes, n), and their squared frequencies
      real(wp), allocatable :: shape(:, :, :), omega2(:)
      !> Axial force of each element for unit coordinates (elements, n) and for unit amplitudes (elements, columns)
      real(wp), allocatable :: modal(:, :), load(:, :)
   end type frame_tension_type

   !> The coefficients of all sections of a body
   type :: recovery_type
      !> Number of coordinates, and of places of loads
      integer :: n = 0, places = 0
      !> Force along the undeformed member, shear force, bending moment and rotation of the section for unit coordinates (4, n,
      !> sections), and for unit amplitudes (4, columns, sections): see `amplitudes`
      real(wp), allocatable :: modal(:, :, :), load(:, :, :)
      !> Whether the axial force is that along the deflected axis, eq. (2.30): where tension acts on the bending
      logical :: deflected = .false.
      !> Of a frame of several members under tension; otherwise unallocated
      type(frame_tension_type), allocatable :: tension
      !> Sections: where they are
      type(section_type), allocatable :: sections(:)
      !> Of an exact beam, whose forces follow from equilibrium; `load` has no meaning there but its size: where each place of loads
      !> has its parts in the lists (places + 1), and where these act [length] and how much they are, 1 of a load at a point (parts)
      integer, allocatable :: first_part(:)
      real(wp), allocatable :: part_at(:), part(:)
      !> How many of its sections, the last ones, are the stations of its axis
      integer :: axis = 0
   end type recovery_type

contains

   !> Sections on both sides of all nodes, of the places given, and of as many even intervals of each member; from the start of each
   !> member to its end.
   pure function all_sections(frame, places, intervals) result(sections)
      type(frame_type), intent(in) :: frame
      !> Where something acts, or the member changes: only `member` and `x` count
      type(section_type), intent(in) :: places(:)
      integer, intent(in) :: intervals
      type(section_type), allocatable :: sections(:)
      integer :: m, i
      allocate (sections(0))
      do m = 1, size(frame%first) - 1
         associate (e => frame%first(m), last => frame%first(m + 1) - 1)
            associate (end => frame%from(last) + frame%length(last))
               sections = [sections, both_sides(m, different([frame%from(e:last), [(end*i/intervals, i=1, intervals)], &
                  & pack(places%x, places%member == m)], end))]
            end associate
         end associate
      end do
   end function all_sections

   !> The sections of a member on both sides of places, but before its start and behind its end.
   pure function both_sides(member, x) result(sections)
      integer, intent(in) :: member
      !> [length]
      real(wp), intent(in) :: x(:)
      type(section_type) :: sections(2*size(x) - 2)
      integer :: i
      sections = [(section_type(member, x(i), .true.), section_type(member, x(i + 1), .false.), i=1, size(x) - 1)]
   end function both_sides

   !> Coordinates in their order, from 0 to the end, without those that lie at another one. Earlier ones of the list are kept.
   pure function different(list, end) result(x)
      !> [length]
      real(wp), intent(in) :: list(:), end
      real(wp), allocatable :: x(:)
      !> Distance of places that are the same, of the length
      real(wp), parameter :: near = 1.0e-9_wp
      integer :: i, k
      x = [0.0_wp, end]
      do i = 1, size(list)
         if (minval(abs(x - list(i))) <= near*end .or. list(i) < 0.0_wp .or. list(i) > end) cycle
         k = count(x < list(i))
         x = [x(:k), list(i), x(k + 1:)]
      end do
   end function different

   !> Makes the coefficients.
   subroutine new_recovery(frame, shape, body, sections, places, recovery, error)
      type(frame_type), intent(in) :: frame
      !> Shapes of the coordinates (3, nodes, n)
      real(wp), intent(in) :: shape(:, :, :)
      !> Their frequencies
      type(reduced_type), intent(in) :: body
      type(section_type), intent(in) :: sections(:)
      type(load_place_type), intent(in) :: places(:)
      type(recovery_type), intent(out) :: recovery
      type(error_type), allocatable, intent(out) :: error
      type(solver_type) :: solver
      real(wp), allocatable :: push(:, :, :), u(:, :), load(:, :)
      integer :: i, j, n, columns
      call new_solver(frame, solver, error)
      if (allocated(error)) return
      n = size(shape, 3)
      recovery%n = n
      recovery%places = size(places)
      columns = 4 + 3*n + 3*size(places)
      allocate (recovery%modal(4, n, size(sections)), recovery%load(4, columns, size(sections)))
      allocate (recovery%sections, source=sections)
      recovery%deflected = body%geometric
      do j = 1, size(sections)
         do i = 1, n
            recovery%modal(:, i, j) = section_state(frame, shape(:, :, i), sections(j))
         end do
      end do
      if (body%geometric .and. size(frame%first) > 2) then
         allocate (recovery%tension)
         call start_tension(recovery%tension, frame, solver, shape, body%omega2, columns)
      end if
      allocate (push(3, size(frame%place, 2), 4 + 3*n), u(3, size(frame%place, 2)), load(3, size(frame%place, 2)))
      call inertia_fields(frame, shape, push)
      do i = 1, columns
         associate (place => max(1, (i - 2 - 3*n)/3), part => 1 + modulo(i - 5 - 3*n, 3), inertial => i <= 4 + 3*n)
            if (inertial) then
               load = frame%mass*push(:, :, i)
            else
               load = nodal_load(frame, places(place), part)
            end if
            call solve_left_out(frame, solver, shape, body%omega2, load, u)
            if (allocated(recovery%tension)) recovery%tension%load(:, i) = axial_forces(frame, u)
            do j = 1, size(sections)
               recovery%load(:, i, j) = section_state(frame, u, sections(j))
               if (inertial) then
                  recovery%load(:3, i, j) = recovery%load(:3, i, j) + spread_forces(frame, push(:2, :, i), sections(j))
               else
                  recovery%load(:3, i, j) = recovery%load(:3, i, j) + held_forces(frame, places(place), part, sections(j))
               end if
            end do
         end associate
      end do
   end subroutine new_recovery

   !> Displacements that loads make at rest, without those of the coordinates.
   subroutine solve_left_out(frame, solver, shape, omega2, load, u)
      type(frame_type), intent(in) :: frame
      type(solver_type), intent(in) :: solver
      !> Shapes of the coordinates (3, nodes, n), their squared frequencies
      real(wp), intent(in) :: shape(:, :, :), omega2(:)
      !> Forces and couples (3, nodes)
      real(wp), intent(in) :: load(:, :)
      !> (3, nodes)
      real(wp), intent(out) :: u(:, :)
      integer :: j
      call solve_static(frame, solver, load, u)
      do j = 1, size(omega2)
         u = u - shape(:, :, j)*(sum(shape(:, :, j)*load)/omega2(j))
      end do
   end subroutine solve_left_out

   !> Axial forces of all elements (elements).
   pure function axial_forces(frame, u) result(force)
      type(frame_type), intent(in) :: frame
      !> Displacements (3, nodes)
      real(wp), intent(in) :: u(:, :)
      real(wp) :: force(size(frame%member)), of(4)
      integer :: e
      do e = 1, size(force)
         of = element_forces(frame, e, u)
         force(e) = of(1)
      end do
   end function axial_forces

   !> The axial forces for unit coordinates; those for unit amplitudes come.
   subroutine start_tension(tension, frame, solver, shape, omega2, columns)
      type(frame_tension_type), intent(out) :: tension
      type(frame_type), intent(in) :: frame
      type(solver_type), intent(in) :: solver
      !> Shapes of the coordinates (3, nodes, n), their squared frequencies
      real(wp), intent(in) :: shape(:, :, :), omega2(:)
      !> Number of amplitudes
      integer, intent(in) :: columns
      integer :: j
      tension%frame = frame
      tension%solver = solver
      tension%shape = shape
      tension%omega2 = omega2
      allocate (tension%modal(size(frame%member), size(omega2)), tension%load(size(frame%member), columns))
      do j = 1, size(omega2)
         tension%modal(:, j) = axial_forces(frame, shape(:, :, j))
      end do
   end subroutine start_tension

   !> What the geometric forces of the members make at all sections through the functions that were left out, as `section_state`
   !> (4, sections), eq. (2.24); only of a recovery with `tension`.
   subroutine geometric_state(recovery, eta, amplitude, state)
      type(recovery_type), intent(in) :: recovery
      !> Coordinates (n), amplitudes (columns)
      real(wp), intent(in) :: eta(:), amplitude(:)
      real(wp), intent(out) :: state(:, :)
      real(wp) :: force(size(recovery%tension%frame%member)), own(6)
      real(wp), dimension(3, size(recovery%tension%frame%place, 2)) :: load, u, left_out
      integer :: e, j
      associate (self => recovery%tension, frame => recovery%tension%frame)
         force = matmul(self%modal, eta) + matmul(self%load, amplitude)
         u = 0.0_wp
         do j = 1, size(eta)
            u = u + self%shape(:, :, j)*eta(j)
         end do
         load = 0.0_wp
         do e = 1, size(force)
            own = own_displacements(frame, e, u)
            own(bending_dofs) = -force(e)*matmul(geometric_stiffness(frame%length(e)), own(bending_dofs))
            own([1, 4]) = 0.0_wp
            call add_element_load(frame, e, own, load)
         end do
         call solve_left_out(frame, self%solver, self%shape, self%omega2, load, left_out)
         u = u + left_out
         do j = 1, size(recovery%sections)
            e = element_of_section(frame, recovery%sections(j))
            state(:, j) = section_state(frame, left_out, recovery%sections(j))
            state(2:3, j) = state(2:3, j) + tensioned_forces(frame, e, recovery%sections(j)%x, force(e), u)
         end do
      end associate
   end subroutine geometric_state

   !> What tension makes within an element whose nodes carry its geometric forces: shear force across the deflected axis and bending
   !> moment (2) in excess of those of the middle and of the straight line between the ends, eq. (2.28).
   pure function tensioned_forces(frame, e, at, tension, u) result(force)
      type(frame_type), intent(in) :: frame
      integer, intent(in) :: e
      !> Coordinate along the member of the section [length], axial force of the element
      real(wp), intent(in) :: at, tension
      !> Displacements (3, nodes)
      real(wp), intent(in) :: u(:, :)
      real(wp) :: force(2), own(6), nodal(4), x, l
      l = frame%length(e)
      x = at - frame%from(e)
      own = own_displacements(frame, e, u)
      associate (w => own(bending_dofs))
         nodal = matmul(geometric_stiffness(l), w)
         force(1) = -nodal(1) - dot_product(bending_slope(x, l), w)
         force(2) = -nodal(2) + nodal(1)*x + dot_product(bending_shape(x, l), w) - w(1)
      end associate
      force = tension*force
   end function tensioned_forces

   !> Of an exact beam: sections and places of loads only.
   subroutine exact_recovery(sections, places, recovery)
      type(section_type), intent(in) :: sections(:)
      type(load_place_type), intent(in) :: places(:)
      type(recovery_type), intent(out) :: recovery
      integer :: i
      recovery%places = size(places)
      allocate (recovery%sections, source=sections)
      allocate (recovery%first_part(size(places) + 1), recovery%part_at(0), recovery%part(0))
      do i = 1, size(places)
         recovery%first_part(i) = size(recovery%part) + 1
         if (allocated(places(i)%at)) then
            recovery%part_at = [recovery%part_at, places(i)%at]
            recovery%part = [recovery%part, places(i)%part]
         else
            recovery%part_at = [recovery%part_at, places(i)%x]
            recovery%part = [recovery%part, 1.0_wp]
         end if
      end do
      recovery%first_part(size(places) + 1) = size(recovery%part) + 1
      allocate (recovery%modal(4, 0, size(sections)), recovery%load(4, 3*size(places), size(sections)))
      recovery%load = 0.0_wp
   end subroutine exact_recovery

   !> The accelerations that the masses resist, for unit amplitudes (3, nodes, 4 + 3n): of the frame along x, y and about its
   !> origin, the centrifugal one; then of each coordinate its own, the centrifugal and the tangential one.
   pure subroutine inertia_fields(frame, modes, push)
      type(frame_type), intent(in) :: frame
      real(wp), intent(in) :: modes(:, :, :)
      real(wp), intent(out) :: push(:, :, :)
      integer :: j, n
      n = size(modes, 3)
      push = 0.0_wp
      push(1, :, 1) = 1.0_wp
      push(2, :, 2) = 1.0_wp
      push(1, :, 3) = -frame%place(2, :)
      push(2, :, 3) = frame%place(1, :)
      push(3, :, 3) = 1.0_wp
      push(1:2, :, 4) = frame%place
      do j = 1, n
         push(:, :, 4 + j) = modes(:, :, j)
         push(1:2, :, 4 + n + j) = modes(1:2, :, j)
         push(1, :, 4 + 2*n + j) = -modes(2, :, j)
         push(2, :, 4 + 2*n + j) = modes(1, :, j)
      end do
   end subroutine inertia_fields

   !> Internal forces at a section, and its rotation, from displacements of the nodes (4).
   pure function section_state(frame, u, section) result(state)
      type(frame_type), intent(in) :: frame
      real(wp), intent(in) :: u(:, :)
      type(section_type), intent(in) :: section
      real(wp) :: state(4), ends(4), own(6), s
      integer :: e
      e = element_of_section(frame, section)
      ends = element_forces(frame, e, u)
      own = own_displacements(frame, e, u)
      s = (section%x - frame%from(e))/frame%length(e)
      state(:3) = [ends(1), ends(2), (1 - s)*ends(3) + s*ends(4)]
      state(4) = dot_product(bending_slope(section%x - frame%from(e), frame%length(e)), own(bending_dofs))
   end function section_state

   !> What the load makes within an element whose nodes carry it: spread over the half of the element next to each node, so that
   !> axial and shear force, which are those of the middle, change linearly up to the nodes; the moment is a parabola between them,
   !> eq. (2.28).
   pure function spread_forces(frame, push, section) result(force)
      type(frame_type), intent(in) :: frame
      !> Accelerations of its nodes (2, nodes), a load with the sign that pushes
      real(wp), intent(in) :: push(:, :)
      type(section_type), intent(in) :: section
      real(wp) :: force(3), load(2, 2), x, half
      integer :: k
      integer :: e
      e = element_of_section(frame, section)
      do k = 1, 2
         associate (a => frame%axis(:, e), p => push(:, frame%ends(k, e)))
            load(:, k) = frame%rho_a(e)*[a(1)*p(1) + a(2)*p(2), a(1)*p(2) - a(2)*p(1)]
         end associate
      end do
      x = section%x - frame%from(e)
      half = 0.5_wp*frame%length(e)
      force(1:2) = load(:, merge(1, 2, x < half))*(half - x)
      force(3) = -0.25_wp*(load(2, 1) + load(2, 2))*x*(frame%length(e) - x)
   end function spread_forces

   !> Unit load at a place as forces and couples on nodes (3, nodes).
   pure function nodal_load(frame, place, part) result(load)
      type(frame_type), intent(in) :: frame
      type(load_place_type), intent(in) :: place
      !> 1, 2: force along the first or second axis of the body; 3: couple, of which a load along a member has none
      integer, intent(in) :: part
      real(wp) :: load(3, size(frame%place, 2))
      integer :: k
      load = 0.0_wp
      if (.not. allocated(place%at)) then
         load = unit_load(frame, place%member, place%x, part)
      else if (part < 3) then
         do k = 1, size(place%at)
            load = load + place%part(k)*unit_load(frame, place%member, place%at(k), part)
         end do
      end if
   end function nodal_load

   !> What a unit load makes at a section while all nodes are held, eq. (2.29).
   pure function held_forces(frame, place, part, section) result(force)
      type(frame_type), intent(in) :: frame
      type(load_place_type), intent(in) :: place
      integer, intent(in) :: part
      type(section_type), intent(in) :: section
      real(wp) :: force(3)
      integer :: k
      force = 0.0_wp
      if (section%member /= place%member) return
      if (.not. allocated(place%at)) then
         force = held_by(frame, place%x, part, section)
      else if (part < 3) then
         do k = 1, size(place%at)
            force = force + place%part(k)*held_by(frame, place%at(k), part, section)
         end do
      end if
   end function held_forces

   !> What a unit load makes within its element while the nodes are held, eq. (2.29).
   pure function held_by(frame, at, part, section) result(force)
      type(frame_type), intent(in) :: frame
      !> Coordinate along the member of the section [length]
      real(wp), intent(in) :: at
      integer, intent(in) :: part
      type(section_type), intent(in) :: section
      real(wp) :: force(3), along, across, a, b, l, y, near
      logical :: beyond
      integer :: e
      force = 0.0_wp
      e = element_at(frame, section%member, at)
      if (element_of_section(frame, section) /= e) return
      l = frame%length(e)
      a = at - frame%from(e)
      b = l - a
      y = section%x - frame%from(e)
      ! The ends of a member are within it
      near = 1.0e-9_wp*l
      beyond = y > a + near .or. (y > a - near .and. y < l - near .and. (section%behind .or. y < near))
      if (part == 3) then
         force(2) = -6*a*b/l**3
         force(3) = (b**2 - 2*a*b)/l**2 - force(2)*y
         if (beyond) force(3) = force(3) - 1
         return
      end if
      along = frame%axis(part, e)
      across = merge(-frame%axis(2, e), frame%axis(1, e), part == 1)
      force(1) = along*b/l
      force(2) = across*b**2*(3*a + b)/l**3
      force(3) = across*a*b**2/l**2 - force(2)*y
      if (.not. beyond) return
      force(1:2) = force(1:2) - [along, across]
      force(3) = force(3) + across*(y - a)
   end function held_by

   pure integer function element_of_section(frame, section) result(e)
      type(frame_type), intent(in) :: frame
      type(section_type), intent(in) :: section
      e = element_at(frame, section%member, section%x)
      if (.not. section%behind .or. e == frame%first(section%member + 1) - 1) return
      if (section%x >= frame%from(e + 1) - 1.0e-9_wp*frame%length(e)) e = e + 1
   end function element_of_section

   !> The amplitudes that the coefficients are for, but those of the places of loads: first 4 + 3n of them.
   pure subroutine amplitudes(heavy, omega, alpha, eta, rate, acceleration, amplitude)
      !> Acceleration of the frame's origin less that of gravity, in the axes of the frame (2)
      real(wp), intent(in) :: heavy(2)
      !> Angular velocity and acceleration
      real(wp), intent(in) :: omega, alpha
      !> Coordinates, their rates and accelerations (n)
      real(wp), intent(in) :: eta(:), rate(:), acceleration(:)
      !> (columns); behind the first 4 + 3n: force along the axes of the frame (2) and couple at each place of loads
      real(wp), intent(inout) :: amplitude(:)
      integer :: n
      n = size(eta)
      amplitude(1:2) = -heavy
      amplitude(3) = -alpha
      amplitude(4) = omega**2
      amplitude(5:4 + n) = -acceleration
      amplitude(5 + n:4 + 2*n) = omega**2*eta
      amplitude(5 + 2*n:4 + 3*n) = -alpha*eta - 2*omega*rate
   end subroutine amplitudes

   !> Axial force, shear force and bending moment at a section. The first is the part of the whole force along the deflected axis,
   !> eq. (2.30), where tension acts on the bending: the shear force, minus the slope of the moment, is across that axis already.
   !> Of coordinates that are held, forces are those of equilibrium, and the axis is deflected as it is held.
   pure function internal_forces(recovery, section, eta, amplitude, geometric, lacking) result(force)
      type(recovery_type), intent(in) :: recovery
      integer, intent(in) :: section
      real(wp), intent(in) :: eta(:), amplitude(:)
      !> See `geometric_state` (4, sections); unallocated without `tension`
      real(wp), allocatable, intent(in) :: geometric(:, :)
      !> By how much the coordinates that are held differ from those in equilibrium (n); unallocated if nothing is held
      real(wp), allocatable, intent(in) :: lacking(:)
      real(wp) :: force(3), state(4)
      integer :: k
      state = 0.0_wp
      do k = 1, recovery%n
         state = state + recovery%modal(:, k, section)*eta(k)
      end do
      do k = 1, size(recovery%load, 2)
         state = state + recovery%load(:, k, section)*amplitude(k)
      end do
      if (allocated(geometric)) state = state + geometric(:, section)
      if (allocated(lacking)) then
         state(:3) = state(:3) + matmul(recovery%modal(:3, :, section), lacking)
         state(4) = dot_product(recovery%modal(4, :, section), eta)
      end if
      force = state(:3)
      if (recovery%deflected) force(1) = force(1) + state(2)*state(4)
   end function internal_forces

end module limber_beam_force_recovery
