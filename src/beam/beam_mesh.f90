!> Finite elements of one straight uniform beam. Supports, assembly of k_E and the lumped mass, and its vibration modes, bending and
!> axial apart (they do not couple). Everything that follows sees the beam as nodal fields, `displacement_field_type`. Floor: beam.
!> Source: doc/theory, eqs. (2.1), (2.4).
module limber_beam_beam_mesh
   use limber_base_kinds, only: wp, long
   use limber_base_error, only: error_type
   use limber_beam_element_matrices, only: axial_stiffness, bending_stiffness, lumped_mass, bending_shape
   use limber_beam_modal_reduction, only: lowest_modes, count_modes
   implicit none
   private
   public :: beam_type, support_type, displacement_field_type, new_support, mesh_beam, count_bending_modes, count_axial_modes
   public :: concentrate, put_nodes, with_node, bending_modes, axial_modes, nodal_masses, nodal_inertias, deflection_at
   public :: slope_at, extension_at
   public :: element_length, field_bytes

   !> A straight uniform beam along the body's x axis and its division into elements
   type :: beam_type
      !> Axial rigidity E A [force], bending rigidity E I [force length^2], mass per length
      real(wp) :: ea = 0.0_wp, ei = 0.0_wp, rho_a = 0.0_wp
      !> Length
      real(wp) :: length = 0.0_wp
      !> Number of elements for the modes
      integer :: elements = 0
      !> Of a beam with concentrated masses, or on which something acts between the nodes: places of the nodes, which need not be
      !> equally far from each other, mass and moment of inertia added to each (0:elements); otherwise unallocated
      real(wp), allocatable :: place(:), mass(:), inertia(:)
   end type beam_type

   !> What holds the beam, relative to its floating frame, when its modes are computed: true where held
   type :: support_type
      !> Axial displacement, deflection and rotation at the start
      logical :: u_start = .false., w_start = .false., theta_start = .false.
      !> The same at the end
      logical :: u_end = .false., w_end = .false., theta_end = .false.
   end type support_type

   !> Displacement fields of the beam's coordinates, given at the nodes of its mesh
   type :: displacement_field_type
      !> Coordinate along the beam of each node (0:elements) [length]
      real(wp), allocatable :: s(:)
      !> Deflection and rotation of each bending coordinate (0:elements, number)
      real(wp), allocatable :: w(:, :), theta(:, :)
      !> Axial displacement of each axial coordinate (0:elements, number)
      real(wp), allocatable :: u(:, :)
      !> Mean strain of each axial coordinate over the k_G elements, or their pieces (pieces, number)
      real(wp), allocatable :: strain(:, :)
      !> Squared circular frequencies of both [1/time^2]
      real(wp), allocatable :: omega2_bending(:), omega2_axial(:)
   end type displacement_field_type

contains

   !> Supports by their name in the deck, START-END: PINNED-ROLLER, PINNED-PINNED, CLAMPED-FREE, CLAMPED-ROLLER,
   !> CLAMPED-PINNED, CLAMPED-CLAMPED, FREE-FREE. A roller holds the deflection only.
   pure function new_support(name) result(support)
      character(*), intent(in) :: name
      type(support_type) :: support
      character(:), allocatable :: start, finish
      start = name(:index(name, '-') - 1)
      finish = name(index(name, '-') + 1:)
      support%u_start = start /= 'FREE'
      support%w_start = start /= 'FREE'
      support%theta_start = start == 'CLAMPED'
      support%u_end = finish == 'PINNED' .or. finish == 'CLAMPED'
      support%w_end = finish /= 'FREE'
      support%theta_end = finish == 'CLAMPED'
   end function new_support

   !> Memory of the shapes of a beam [bytes].
   pure integer(long) function field_bytes(field) result(bytes)
      type(displacement_field_type), intent(in) :: field
      bytes = 0
      if (allocated(field%w)) bytes = 16*size(field%w, kind=long)
      if (allocated(field%u)) bytes = bytes + 8*size(field%u, kind=long)
   end function field_bytes

   !> Fields without coordinates on the beam's mesh.
   pure function mesh_beam(beam) result(field)
      type(beam_type), intent(in) :: beam
      type(displacement_field_type) :: field
      integer :: i
      allocate (field%s(0:beam%elements))
      field%s = [(beam%length*i/beam%elements, i=0, beam%elements)]
      if (allocated(beam%place)) field%s = beam%place
      allocate (field%w(0:beam%elements, 0), field%theta(0:beam%elements, 0), field%u(0:beam%elements, 0))
      allocate (field%omega2_bending(0), field%omega2_axial(0))
   end function mesh_beam

   !> Adds a concentrated mass to a beam: the nearest inner node moves to it, or another element is made if that node carries one.
   pure subroutine concentrate(beam, x, mass, inertia)
      type(beam_type), intent(inout) :: beam
      !> Coordinate along the beam [length]
      real(wp), intent(in) :: x
      !> Mass, and moment of inertia about its centre
      real(wp), intent(in) :: mass, inertia
      type(displacement_field_type) :: field
      integer :: i, n
      if (.not. allocated(beam%place)) then
         field = mesh_beam(beam)
         allocate (beam%place(0:beam%elements), beam%mass(0:beam%elements), beam%inertia(0:beam%elements))
         beam%place(:) = field%s
         beam%mass = 0.0_wp
         beam%inertia = 0.0_wp
      end if
      n = beam%elements
      i = minloc(abs(beam%place - x), dim=1) - 1
      if (abs(beam%place(i) - x) > 1.0e-9_wp*beam%length) then
         if (i == 0 .or. i == n .or. beam%mass(i) > 0.0_wp .or. beam%inertia(i) > 0.0_wp) then
            i = count(beam%place < x)
            call insert(beam%place, i, x)
            call insert(beam%mass, i, 0.0_wp)
            call insert(beam%inertia, i, 0.0_wp)
            beam%elements = n + 1
         end if
         beam%place(i) = x
      end if
      beam%mass(i) = beam%mass(i) + mass
      beam%inertia(i) = beam%inertia(i) + inertia
   end subroutine concentrate

   !> Puts nodes of a beam where something acts: within an element the bending moment has no jump, and no bend.
   pure subroutine put_nodes(beam, x)
      type(beam_type), intent(inout) :: beam
      !> Coordinates along the beam [length]
      real(wp), intent(in) :: x(:)
      real(wp), allocatable :: place(:), mass(:), inertia(:), held(:)
      integer :: i, k
      if (allocated(beam%place)) then
         allocate (place, source=[beam%place])
         allocate (held, source=pack([beam%place], [beam%mass > 0.0_wp .or. beam%inertia > 0.0_wp]))
      else
         allocate (place, source=[(beam%length*i/beam%elements, i=0, beam%elements)])
         allocate (held(0))
      end if
      do i = 1, size(x)
         place = with_node(place, held, x(i))
         held = [held, x(i)]
      end do
      if (.not. allocated(beam%place)) then
         if (size(place) == beam%elements + 1) then
            if (all(abs(place - [(beam%length*i/beam%elements, i=0, beam%elements)]) <= 0.0_wp)) return
         end if
      end if
      allocate (mass(size(place)), inertia(size(place)))
      mass = 0.0_wp
      inertia = 0.0_wp
      do i = 0, beam%elements
         if (.not. allocated(beam%place)) exit
         if (.not. beam%mass(i) + beam%inertia(i) > 0.0_wp) cycle
         k = minloc(abs(place - beam%place(i)), dim=1)
         mass(k) = beam%mass(i)
         inertia(k) = beam%inertia(i)
      end do
      if (allocated(beam%place)) deallocate (beam%place, beam%mass, beam%inertia)
      beam%elements = size(place) - 1
      allocate (beam%place(0:beam%elements), beam%mass(0:beam%elements), beam%inertia(0:beam%elements))
      beam%place(:) = place
      beam%mass(:) = mass
      beam%inertia(:) = inertia
   end subroutine put_nodes

   !> Places of nodes with one at x: an inner one that is so near that an element between them would be too short moves there.
   pure function with_node(place, held, x) result(places)
      !> In ascending order, those of them that stay, and the new one [length]
      real(wp), intent(in) :: place(:), held(:), x
      real(wp), allocatable :: places(:)
      !> Parts of the length: places that are the same; shortest element
      real(wp), parameter :: same = 1.0e-9_wp, shortest = 3.0e-4_wp
      real(wp) :: gap, length
      integer :: k
      allocate (places, source=place)
      length = place(size(place)) - place(1)
      k = minloc(abs(place - x), dim=1)
      gap = abs(place(k) - x)
      if (gap <= same*length) return
      if (gap > shortest*length) then
         k = count(place < x)
         places = [place(:k), x, place(k + 1:)]
      else if (k > 1 .and. k < size(place) .and. .not. any(abs(held - place(k)) <= same*length)) then
         places(k) = x
      end if
   end function with_node

   !> Puts a value before entry i of a list that begins with 0.
   pure subroutine insert(list, i, value)
      real(wp), allocatable, intent(inout) :: list(:)
      integer, intent(in) :: i
      real(wp), intent(in) :: value
      real(wp), allocatable :: longer(:)
      integer :: last
      last = ubound(list, 1)
      allocate (longer(0:last + 1))
      longer(:i - 1) = list(:i - 1)
      longer(i) = value
      longer(i + 1:) = list(i:)
      call move_alloc(longer, list)
   end subroutine insert

   !> Lumped masses of the nodes (0:elements).
   pure function nodal_masses(beam) result(mass)
      type(beam_type), intent(in) :: beam
      real(wp) :: mass(0:beam%elements)
      real(wp) :: half
      integer :: e
      if (allocated(beam%place)) then
         mass = beam%mass
         do e = 1, beam%elements
            half = lumped_mass(beam%rho_a, beam%place(e) - beam%place(e - 1))
            mass(e - 1:e) = mass(e - 1:e) + half
         end do
         return
      end if
      half = lumped_mass(beam%rho_a, beam%length/beam%elements)
      mass = 2*half
      mass(0) = half
      mass(beam%elements) = half
   end function nodal_masses

   !> Moments of inertia of the nodes (0:elements): those of concentrated masses only.
   pure function nodal_inertias(beam) result(inertia)
      type(beam_type), intent(in) :: beam
      real(wp) :: inertia(0:beam%elements)
      inertia = 0.0_wp
      if (allocated(beam%inertia)) inertia = beam%inertia
   end function nodal_inertias

   !> Length of an element; of all elements of a beam without concentrated masses the same.
   pure real(wp) function element_length(beam, e) result(length)
      type(beam_type), intent(in) :: beam
      integer, intent(in) :: e
      length = beam%length/beam%elements
      if (allocated(beam%place)) length = beam%place(e) - beam%place(e - 1)
   end function element_length

   !> Number of bending modes that the lumped mass gives under these supports.
   integer function count_bending_modes(beam, support) result(modes)
      type(beam_type), intent(in) :: beam
      type(support_type), intent(in) :: support
      modes = count_modes(pack(bending_masses(beam), bending_free(beam, support)), rigid_bending(support))
   end function count_bending_modes

   !> Number of axial modes that the lumped mass gives under these supports.
   integer function count_axial_modes(beam, support) result(modes)
      type(beam_type), intent(in) :: beam
      type(support_type), intent(in) :: support
      modes = count_modes(pack(nodal_masses(beam), axial_free(beam, support)), rigid_axial(support))
   end function count_axial_modes

   !> The free entries of columns (free, number).
   pure function packed(columns, free) result(part)
      real(wp), intent(in) :: columns(:, :)
      logical, intent(in) :: free(:)
      real(wp) :: part(count(free), size(columns, 2))
      integer :: j
      do j = 1, size(columns, 2)
         part(:, j) = pack(columns(:, j), free)
      end do
   end function packed

   !> Rigid-body motions across the beam that the supports leave (free coordinates, number): a beam on one hinge turns about it, and
   !> one whose section is held at one end moves across; a free one does both.
   pure function bending_motions(beam, support) result(rigid)
      type(beam_type), intent(in) :: beam
      type(support_type), intent(in) :: support
      real(wp) :: rigid(count(bending_free(beam, support)), rigid_bending(support))
      type(displacement_field_type) :: field
      real(wp) :: all(2*(beam%elements + 1), 2)
      field = mesh_beam(beam)
      all(1::2, 1) = 1.0_wp
      all(2::2, 1) = 0.0_wp
      all(1::2, 2) = field%s
      all(2::2, 2) = 1.0_wp
      if (support%w_end) all(1::2, 2) = field%s - beam%length
      if (support%w_start .or. support%w_end) all(:, 1) = all(:, 2)
      rigid = packed(all(:, :rigid_bending(support)), bending_free(beam, support))
   end function bending_motions

   !> Adds the lowest bending modes to the fields.
   subroutine bending_modes(beam, support, wanted, field, error)
      type(beam_type), intent(in) :: beam
      type(support_type), intent(in) :: support
      !> Number of modes
      integer, intent(in) :: wanted
      !> From `mesh_beam`; receives w, theta and their frequencies
      type(displacement_field_type), intent(inout) :: field
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: band(:, :), phi(:, :), whole(:, :), mass(:)
      logical :: free(2*(beam%elements + 1))
      real(wp) :: k(4, 4, beam%elements), shift
      integer :: n, i, j
      n = 2*(beam%elements + 1)
      free = bending_free(beam, support)
      mass = pack(bending_masses(beam), free)
      do i = 1, beam%elements
         k(:, :, i) = bending_stiffness(beam%ei, element_length(beam, i))
      end do
      allocate (phi(size(mass), wanted), whole(n, wanted))
      shift = merge(-beam%ei/(beam%rho_a*beam%length**4), 0.0_wp, rigid_bending(support) > 0)
      band = assemble_band(beam%elements, 2, k, free)
      if (allocated(field%omega2_bending)) deallocate (field%omega2_bending)
      allocate (field%omega2_bending(wanted))
      call lowest_modes(band, mass, bending_motions(beam, support), shift, wanted, field%omega2_bending, phi, error)
      if (allocated(error)) return
      do j = 1, wanted
         whole(:, j) = unpack(phi(:, j), free, 0.0_wp)
      end do
      deallocate (field%w, field%theta)
      allocate (field%w(0:beam%elements, wanted), field%theta(0:beam%elements, wanted))
      field%w(:, :) = whole(1::2, :)
      field%theta(:, :) = whole(2::2, :)
   end subroutine bending_modes

   !> Adds the lowest axial modes to the fields.
   subroutine axial_modes(beam, support, wanted, field, error)
      type(beam_type), intent(in) :: beam
      type(support_type), intent(in) :: support
      !> Number of modes
      integer, intent(in) :: wanted
      !> From `mesh_beam`; receives u and its frequencies
      type(displacement_field_type), intent(inout) :: field
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: band(:, :), rigid(:, :), phi(:, :), mass(:)
      logical :: free(beam%elements + 1)
      real(wp) :: k(2, 2, beam%elements), shift
      integer :: i, j
      free = axial_free(beam, support)
      mass = pack(nodal_masses(beam), free)
      allocate (rigid(size(mass), rigid_axial(support)), phi(size(mass), wanted))
      rigid = 1.0_wp
      shift = merge(-beam%ea/(beam%rho_a*beam%length**2), 0.0_wp, rigid_axial(support) > 0)
      do i = 1, beam%elements
         k(:, :, i) = axial_stiffness(beam%ea, element_length(beam, i))
      end do
      band = assemble_band(beam%elements, 1, k, free)
      if (allocated(field%omega2_axial)) deallocate (field%omega2_axial)
      allocate (field%omega2_axial(wanted))
      call lowest_modes(band, mass, rigid, shift, wanted, field%omega2_axial, phi, error)
      if (allocated(error)) return
      deallocate (field%u)
      allocate (field%u(0:beam%elements, wanted))
      do j = 1, wanted
         field%u(:, j) = unpack(phi(:, j), free, 0.0_wp)
      end do
   end subroutine axial_modes

   !> Index of the element (1..) that holds the place x.
   pure integer function element_of(s, x)
      !> Node coordinates (0:elements)
      real(wp), intent(in) :: s(0:)
      !> Coordinate along the beam [length]
      real(wp), intent(in) :: x
      element_of = count(s(1:ubound(s, 1) - 1) <= x) + 1
   end function element_of

   !> Deflection of every bending coordinate at x (number).
   pure function deflection_at(field, x) result(w)
      type(displacement_field_type), intent(in) :: field
      !> Coordinate along the beam [length]
      real(wp), intent(in) :: x
      real(wp) :: w(size(field%w, 2)), shape(4)
      integer :: e
      e = element_of(field%s, x)
      shape = bending_shape(x - field%s(e - 1), field%s(e) - field%s(e - 1))
      w = shape(1)*field%w(e - 1, :) + shape(2)*field%theta(e - 1, :) + shape(3)*field%w(e, :) + shape(4)*field%theta(e, :)
   end function deflection_at

   !> Rotation of every bending coordinate at x (number).
   pure function slope_at(field, x, kernel) result(slope)
      type(displacement_field_type), intent(in) :: field
      !> Coordinate along the beam [length]
      real(wp), intent(in) :: x
      !> `bending_slope` for w', `bending_curvature` for w''
      interface
         pure function kernel(x, l) result(shape)
            import :: wp
            real(wp), intent(in) :: x, l
            real(wp) :: shape(4)
         end function kernel
      end interface
      real(wp) :: slope(size(field%w, 2)), shape(4)
      integer :: e
      e = element_of(field%s, x)
      shape = kernel(x - field%s(e - 1), field%s(e) - field%s(e - 1))
      slope = shape(1)*field%w(e - 1, :) + shape(2)*field%theta(e - 1, :) + shape(3)*field%w(e, :) + shape(4)*field%theta(e, :)
   end function slope_at

   !> Axial displacement of every axial coordinate at x (number).
   pure function extension_at(field, x) result(u)
      type(displacement_field_type), intent(in) :: field
      !> Coordinate along the beam [length]
      real(wp), intent(in) :: x
      real(wp) :: u(size(field%u, 2)), part
      integer :: e
      e = element_of(field%s, x)
      part = (x - field%s(e - 1))/(field%s(e) - field%s(e - 1))
      u = (1 - part)*field%u(e - 1, :) + part*field%u(e, :)
   end function extension_at

   !> Lower band of the free part of a chain of elements with `dofs` coordinates a node.
   pure function assemble_band(elements, dofs, k, free) result(band)
      integer, intent(in) :: elements, dofs
      real(wp), intent(in) :: k(:, :, :)
      logical, intent(in) :: free(:)
      real(wp), allocatable :: band(:, :)
      integer :: place(size(free)), e, i, j, row, column
      place = 0
      j = 0
      do i = 1, size(free)
         if (.not. free(i)) cycle
         j = j + 1
         place(i) = j
      end do
      allocate (band(2*dofs, j))
      band = 0.0_wp
      do e = 1, elements
         do j = 1, 2*dofs
            column = place((e - 1)*dofs + j)
            if (column == 0) cycle
            do i = 1, 2*dofs
               row = place((e - 1)*dofs + i)
               if (row >= column) band(1 + row - column, column) = band(1 + row - column, column) + k(i, j, e)
            end do
         end do
      end do
   end function assemble_band

   pure function bending_masses(beam) result(mass)
      type(beam_type), intent(in) :: beam
      real(wp) :: mass(2*(beam%elements + 1))
      mass = 0.0_wp
      mass(1::2) = nodal_masses(beam)
      mass(2::2) = nodal_inertias(beam)
   end function bending_masses

   pure function bending_free(beam, support) result(free)
      type(beam_type), intent(in) :: beam
      type(support_type), intent(in) :: support
      logical :: free(2*(beam%elements + 1))
      free = .true.
      free(:2) = [.not. support%w_start, .not. support%theta_start]
      free(2*beam%elements + 1:) = [.not. support%w_end, .not. support%theta_end]
   end function bending_free

   pure function axial_free(beam, support) result(free)
      type(beam_type), intent(in) :: beam
      type(support_type), intent(in) :: support
      logical :: free(beam%elements + 1)
      free = .true.
      free(1) = .not. support%u_start
      free(beam%elements + 1) = .not. support%u_end
   end function axial_free

   !> Number of rigid-body motions across the beam that the supports leave.
   pure integer function rigid_bending(support)
      type(support_type), intent(in) :: support
      rigid_bending = max(0, 2 - count([support%w_start, support%theta_start, support%w_end, support%theta_end]))
   end function rigid_bending

   pure integer function rigid_axial(support)
      type(support_type), intent(in) :: support
      rigid_axial = merge(0, 1, support%u_start .or. support%u_end)
   end function rigid_axial

end module limber_beam_beam_mesh
