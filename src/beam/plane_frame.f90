!> Mesh of a plane frame of straight members. Its mesh, its elements, and its members as straight beams. Used before the time loop
!> only. Floor: beam. Source: Przemieniecki, sections 5.6 and 6.4; doc/theory, eqs. (2.1), (2.12).
module limber_beam_plane_frame
   use limber_base_kinds, only: wp
   use limber_beam_element_matrices, only: beam_stiffness, bending_shape, bending_slope, bending_curvature, lumped_mass
   use limber_beam_beam_mesh, only: beam_type, support_type, displacement_field_type, nodal_masses, nodal_inertias, with_node
   implicit none
   private
   public :: frame_type, member_type, acted_type, new_frame, beam_frame, beam_nodes, element_at, member_field, member_length
   public :: element_stiffness, strain_energy, element_forces, own_displacements, add_element_load, unit_load

   !> A straight member between two corners
   type :: member_type
      !> Corners at its start and its end
      integer :: ends(2) = 0
      !> Axial rigidity E A [force], bending rigidity E I [force length^2], mass per length
      real(wp) :: ea = 0.0_wp, ei = 0.0_wp, rho_a = 0.0_wp
      !> Number of elements
      integer :: divisions = 1
   end type member_type

   !> A place where something acts within a member: its index, coordinate along it [length]
   type :: acted_type
      integer :: member = 0
      real(wp) :: x = 0.0_wp
   end type acted_type

   !> A mesh. The corners come first among the nodes; the elements of a member follow each other from its start to its end
   type :: frame_type
      !> Places in the axes of the body (2, nodes) [length]
      real(wp), allocatable :: place(:, :)
      !> Masses that x, y and the rotation of each node move (3, nodes) [mass, mass, mass length^2]
      real(wp), allocatable :: mass(:, :)
      !> What the supports of the modes leave free of x, y and the rotation (3, nodes)
      logical, allocatable :: free(:, :)
      !> Nodes of each element (2, elements), and its member
      integer, allocatable :: ends(:, :), member(:)
      !> Coordinate of each element's start along its member, and its length (elements) [length]
      real(wp), allocatable :: from(:), length(:)
      !> Unit vector along it (2, elements)
      real(wp), allocatable :: axis(:, :)
      !> E A, E I and mass per length (elements)
      real(wp), allocatable :: ea(:), ei(:), rho_a(:)
      !> First element of each member, and one behind the last (members + 1)
      integer, allocatable :: first(:)
   end type frame_type

contains

   !> Divides members into elements and lumps their masses; nothing is held.
   pure function new_frame(corners, members, acted) result(frame)
      !> Places (2, corners) [length]
      real(wp), intent(in) :: corners(:, :)
      type(member_type), intent(in) :: members(:)
      !> Where nodes are wanted besides
      type(acted_type), intent(in), optional :: acted(:)
      type(frame_type) :: frame
      integer :: nodes, elements, m, i, e, from, to
      real(wp) :: line(2), length
      real(wp), allocatable :: x(:)
      logical :: uniform
      allocate (x(0))
      elements = 0
      do m = 1, size(members)
         elements = elements + size(nodes_of(m)) - 1
      end do
      nodes = size(corners, 2) + elements - size(members)
      allocate (frame%place(2, nodes), frame%mass(3, nodes), frame%free(3, nodes), frame%ends(2, elements))
      allocate (frame%member(elements), frame%from(elements), frame%length(elements), frame%axis(2, elements))
      allocate (frame%ea(elements), frame%ei(elements), frame%rho_a(elements), frame%first(size(members) + 1))
      frame%place(:, :size(corners, 2)) = corners
      frame%mass = 0.0_wp
      frame%free = .true.
      nodes = size(corners, 2)
      e = 0
      do m = 1, size(members)
         frame%first(m) = e + 1
         line = corners(:, members(m)%ends(2)) - corners(:, members(m)%ends(1))
         x = nodes_of(m)
         uniform = .true.
         if (present(acted)) uniform = .not. any(acted%member == m)
         from = members(m)%ends(1)
         do i = 1, size(x) - 1
            e = e + 1
            to = members(m)%ends(2)
            if (i < size(x) - 1) then
               nodes = nodes + 1
               to = nodes
               frame%place(:, to) = corners(:, members(m)%ends(1)) + line*i/members(m)%divisions
               if (.not. uniform) frame%place(:, to) = corners(:, members(m)%ends(1)) + line*(x(i + 1)/norm2(line))
            end if
            length = norm2(line)/members(m)%divisions
            frame%from(e) = (i - 1)*length
            if (.not. uniform) then
               length = x(i + 1) - x(i)
               frame%from(e) = x(i)
            end if
            frame%ends(:, e) = [from, to]
            frame%member(e) = m
            frame%length(e) = length
            frame%axis(:, e) = line/norm2(line)
            frame%ea(e) = members(m)%ea
            frame%ei(e) = members(m)%ei
            frame%rho_a(e) = members(m)%rho_a
            frame%mass(1:2, frame%ends(:, e)) = frame%mass(1:2, frame%ends(:, e)) + lumped_mass(members(m)%rho_a, length)
            from = to
         end do
      end do
      frame%first(size(members) + 1) = e + 1

   contains

      !> Places of the nodes along a member, its ends included [length].
      pure function nodes_of(m) result(x)
         integer, intent(in) :: m
         real(wp), allocatable :: x(:)
         real(wp) :: length
         integer :: k
         length = norm2(corners(:, members(m)%ends(2)) - corners(:, members(m)%ends(1)))
         allocate (x, source=[(length*k/members(m)%divisions, k=0, members(m)%divisions)])
         if (.not. present(acted)) return
         do k = 1, size(acted)
            if (acted(k)%member == m) x = with_node(x, pack(acted(:k - 1)%x, acted(:k - 1)%member == m), acted(k)%x)
         end do
      end function nodes_of

   end function new_frame

   !> A straight beam as a frame of one member along its x axis, with the shapes of its coordinates (3, nodes, n).
   pure subroutine beam_frame(beam, support, origin, field, frame, shape)
      type(beam_type), intent(in) :: beam
      type(support_type), intent(in) :: support
      !> Coordinate along the beam of the origin of the body [length]
      real(wp), intent(in) :: origin
      type(displacement_field_type), intent(in) :: field
      type(frame_type), intent(out) :: frame
      real(wp), allocatable, intent(out) :: shape(:, :, :)
      type(member_type) :: member(1)
      integer :: node(0:beam%elements), e, b
      member(1)%ends = [1, 2]
      member(1)%ea = beam%ea
      member(1)%ei = beam%ei
      member(1)%rho_a = beam%rho_a
      member(1)%divisions = beam%elements
      frame = new_frame(reshape([-origin, 0.0_wp, beam%length - origin, 0.0_wp], [2, 2]), member)
      node = beam_nodes(frame)
      do e = 1, beam%elements
         frame%from(e) = field%s(e - 1)
         frame%length(e) = field%s(e) - field%s(e - 1)
      end do
      frame%place(1, node) = field%s - origin
      frame%mass(1, node) = nodal_masses(beam)
      frame%mass(2, :) = frame%mass(1, :)
      frame%mass(3, node) = nodal_inertias(beam)
      frame%free(:, 1) = [.not. support%u_start, .not. support%w_start, .not. support%theta_start]
      frame%free(:, 2) = [.not. support%u_end, .not. support%w_end, .not. support%theta_end]
      b = size(field%w, 2)
      allocate (shape(3, size(node), b + size(field%u, 2)))
      shape = 0.0_wp
      shape(1, node, b + 1:) = field%u
      shape(2, node, :b) = field%w
      shape(3, node, :b) = field%theta
   end subroutine beam_frame

   !> Nodes of a frame of one member from its start to its end (0:elements).
   pure function beam_nodes(frame) result(node)
      type(frame_type), intent(in) :: frame
      integer :: node(0:size(frame%member))
      node(0) = frame%ends(1, 1)
      node(1:) = frame%ends(2, :)
   end function beam_nodes

   !> Length of a member.
   pure real(wp) function member_length(frame, member) result(length)
      type(frame_type), intent(in) :: frame
      integer, intent(in) :: member
      associate (last => frame%first(member + 1) - 1)
         length = frame%from(last) + frame%length(last)
      end associate
   end function member_length

   !> Element of a member that holds a place; of two that meet there the one before it.
   pure integer function element_at(frame, member, x) result(e)
      type(frame_type), intent(in) :: frame
      integer, intent(in) :: member
      !> Coordinate along the member [length]
      real(wp), intent(in) :: x
      do e = frame%first(member), frame%first(member + 1) - 2
         if (x <= frame%from(e) + frame%length(e)*(1 + 1.0e-9_wp)) return
      end do
      e = frame%first(member + 1) - 1
   end function element_at

   !> A member as a straight beam: all coordinates of the frame bend it and stretch it.
   pure function member_field(frame, shape, member) result(field)
      type(frame_type), intent(in) :: frame
      !> Displacements of each coordinate in the axes of the body (3, nodes, n)
      real(wp), intent(in) :: shape(:, :, :)
      integer, intent(in) :: member
      type(displacement_field_type) :: field
      real(wp) :: own(6)
      integer :: e, j, elements, i
      elements = frame%first(member + 1) - frame%first(member)
      allocate (field%s(0:elements), field%w(0:elements, size(shape, 3)), field%theta(0:elements, size(shape, 3)))
      allocate (field%u(0:elements, size(shape, 3)), field%omega2_bending(0), field%omega2_axial(0))
      do i = 1, elements
         e = frame%first(member) + i - 1
         field%s(i - 1) = frame%from(e)
         field%s(i) = frame%from(e) + frame%length(e)
         do j = 1, size(shape, 3)
            own = own_displacements(frame, e, shape(:, :, j))
            field%u(i - 1:i, j) = own([1, 4])
            field%w(i - 1:i, j) = own([2, 5])
            field%theta(i - 1:i, j) = own([3, 6])
         end do
      end do
   end function member_field

   !> Displacements of the nodes of an element in its own axes (6): u, w, theta at its start and its end.
   pure function own_displacements(frame, e, u) result(own)
      type(frame_type), intent(in) :: frame
      integer, intent(in) :: e
      !> (3, nodes)
      real(wp), intent(in) :: u(:, :)
      real(wp) :: own(6)
      integer :: k
      do k = 1, 2
         associate (d => u(:, frame%ends(k, e)), a => frame%axis(:, e))
            own(3*k - 2) = a(1)*d(1) + a(2)*d(2)
            own(3*k - 1) = a(1)*d(2) - a(2)*d(1)
            own(3*k) = d(3)
         end associate
      end do
   end function own_displacements

   !> Axial force, shear force and bending moments at the start and the end of an element (4): tension positive; the shear is
   !> the force across that the part behind a section exerts; the moment is E I w''.
   pure function element_forces(frame, e, u) result(force)
      type(frame_type), intent(in) :: frame
      integer, intent(in) :: e
      !> Displacements (3, nodes)
      real(wp), intent(in) :: u(:, :)
      real(wp) :: force(4), own(6), l
      l = frame%length(e)
      own = own_displacements(frame, e, u)
      force(1) = frame%ea(e)*(own(4) - own(1))/l
      force(3) = frame%ei(e)*dot_product(bending_curvature(0.0_wp, l), own([2, 3, 5, 6]))
      force(4) = frame%ei(e)*dot_product(bending_curvature(l, l), own([2, 3, 5, 6]))
      force(2) = (force(3) - force(4))/l
   end function element_forces

   !> Unit load at a place as forces and couples on the nodes of its element that deflect these as it does (3, nodes).
   pure function unit_load(frame, member, x, part) result(load)
      type(frame_type), intent(in) :: frame
      integer, intent(in) :: member
      !> Coordinate along the member [length]
      real(wp), intent(in) :: x
      !> 1, 2: force along the first or second axis of the body; 3: couple
      integer, intent(in) :: part
      real(wp) :: load(3, size(frame%place, 2)), own(6), s, l
      !> Part of an element that tells no place from a node
      real(wp), parameter :: near = 1.0e-9_wp
      integer :: e
      load = 0.0_wp
      e = element_at(frame, member, x)
      l = frame%length(e)
      s = x - frame%from(e)
      if (abs(s) < near*l) s = 0.0_wp
      if (abs(s - l) < near*l) s = l
      own = 0.0_wp
      associate (a => frame%axis(:, e))
         if (part == 3) then
            own([2, 3, 5, 6]) = bending_slope(s, l)
         else
            own([1, 4]) = a(part)*[1 - s/l, s/l]
            own([2, 3, 5, 6]) = merge(-a(2), a(1), part == 1)*bending_shape(s, l)
         end if
      end associate
      call add_element_load(frame, e, own, load)
   end function unit_load

   !> Adds forces and couples on both nodes of an element, in its own axes, to those on the nodes of the mesh.
   pure subroutine add_element_load(frame, e, own, load)
      type(frame_type), intent(in) :: frame
      integer, intent(in) :: e
      !> Along, across and couple at its start and its end
      real(wp), intent(in) :: own(6)
      !> (3, nodes)
      real(wp), intent(inout) :: load(:, :)
      integer :: k
      do k = 1, 2
         associate (f => own(3*k - 2:3*k), a => frame%axis(:, e), node => load(:, frame%ends(k, e)))
            node = node + [a(1)*f(1) - a(2)*f(2), a(2)*f(1) + a(1)*f(2), f(3)]
         end associate
      end do
   end subroutine add_element_load

   !> Stiffness of an element in the axes of the body on (x, y, rotation) of its two nodes.
   pure function element_stiffness(frame, e) result(k)
      type(frame_type), intent(in) :: frame
      integer, intent(in) :: e
      real(wp) :: k(6, 6), turn(6, 6), half(6, 6)
      turn = 0.0_wp
      turn(1, 1:2) = frame%axis(:, e)
      turn(2, 1:2) = [-frame%axis(2, e), frame%axis(1, e)]
      turn(3, 3) = 1.0_wp
      turn(4:6, 4:6) = turn(1:3, 1:3)
      half = beam_stiffness(frame%ea(e), frame%ei(e), frame%length(e))
      half = matmul(half, turn)
      k = matmul(transpose(turn), half)
   end function element_stiffness

   !> u.K v.
   pure real(wp) function strain_energy(frame, u, v) result(energy)
      type(frame_type), intent(in) :: frame
      real(wp), intent(in) :: u(:, :), v(:, :)
      integer :: e
      energy = 0.0_wp
      do e = 1, size(frame%member)
         energy = energy + dot_product(own_displacements(frame, e, u), matmul(beam_stiffness(frame%ea(e), frame%ei(e), &
            & frame%length(e)), own_displacements(frame, e, v)))
      end do
   end function strain_energy

end module limber_beam_plane_frame
