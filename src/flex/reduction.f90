!> From a beam and the user's choices to its reduced constants: modes, axial functions, geometric part, invariants.
!> The number of elements for the modes, of modes, and of k_G elements are independent of each other.
!> Floor: flex. Source: Han and Lee 1993, sections 3 and 6; doc/theory, sections 5-8.
module limber_flex_reduction
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_base_text, only: as_text
   use limber_flex_beam, only: bending_slope
   use limber_flex_axial, only: element_functions, static_functions, axial_basis
   use limber_flex_end_shapes, only: add_end_shapes
   use limber_flex_geometric, only: mean_slopes, slope_moments, mean_strains, strain_moments, joined_strains, element_ends, &
      & project_cubic, project_membrane, project_curvature
   use limber_flex_mesh, only: beam_type, support_type, field_type, mesh_beam, bending_modes, axial_modes, nodal_masses, &
      & nodal_inertias, count_bending_modes, count_axial_modes, deflection_at, slope_at, extension_at
   use limber_flex_reduced, only: reduced_type, start_inertia, add_inertia, add_rotary
   implicit none
   private
   public :: reduction_type, reduce_beam, available_modes, point_shape

   !> Fidelities of a flexible body
   integer, parameter, public :: fidelity_linear = 1, fidelity_kg = 2, fidelity_full = 3
   !> Axial bases: vibration modes, one function for each k_G element, chosen static functions
   integer, parameter, public :: axial_by_modes = 1, axial_by_elements = 2, axial_static = 3

   !> What the user chooses of a beam's reduction
   type :: reduction_type
      !> Supports of the modes
      type(support_type) :: support
      !> Modes in all, the lowest of both kinds together; unused (-1) if both counts are given apart
      integer :: modes = -1
      !> Bending and axial modes apart; -1 where `modes` decides
      integer :: bending = -1, axial = -1
      !> fidelity_linear, fidelity_kg or fidelity_full
      integer :: fidelity = fidelity_kg
      !> Number of k_G elements
      integer :: geometric_elements = 2
      !> True: w'^2 of a k_G element from w and theta at its own ends; false: the exact integral
      logical :: nodal = .false.
      !> True: the tension changes linearly within a k_G element, which the model k_g only can have
      logical :: linear = .false.
      !> axial_by_modes, axial_by_elements or axial_static
      integer :: axial_basis = axial_by_modes
      !> Which static functions, and how many modal derivatives
      logical :: end_force = .true., centrifugal = .true.
      integer :: derivatives = 3
      !> Whether the shapes that forces and moments at the ends make join the bending modes
      logical :: end_shapes = .false.
      !> Coordinate along the beam of the floating frame's origin [length]
      real(wp) :: origin = 0.0_wp
   end type reduction_type

contains

   !> Number of modes that exist: bending and axial.
   pure function available_modes(beam, support) result(available)
      type(beam_type), intent(in) :: beam
      type(support_type), intent(in) :: support
      integer :: available(2)
      available = [count_bending_modes(beam, support), count_axial_modes(beam, support)]
   end function available_modes

   !> Reduces a beam.
   subroutine reduce_beam(beam, choice, body, field, error)
      type(beam_type), intent(in) :: beam
      type(reduction_type), intent(in) :: choice
      !> Constants for the time loop
      type(reduced_type), intent(out) :: body
      !> Shapes of the coordinates at the nodes, for points and results
      type(field_type), intent(out) :: field
      !> More modes asked for than there are, or no convergence
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: x(:), slopes(:, :, :), strains(:, :)
      integer :: pieces

      field = mesh_beam(beam)
      call compute_modes(beam, choice, field, error)
      if (choice%end_shapes .and. any(nodal_inertias(beam) > 0.0_wp) .and. .not. allocated(error)) call raise(error, &
         & 'END SHAPES cannot be used beside concentrated moments of inertia')
      if (choice%end_shapes .and. .not. allocated(error)) call add_end_shapes(beam, choice%support, field, error)
      if (allocated(error)) return
      ! Axial functions on pieces of the k_G elements, if the tension may vary within these
      pieces = 1
      if (choice%linear) pieces = max(1, beam%elements/choice%geometric_elements)
      allocate (x(0:choice%geometric_elements*pieces))
      x(:) = element_ends(beam%length, choice%geometric_elements*pieces)
      allocate (slopes, source=mean_slopes(field, x, choice%nodal))
      select case (choice%axial_basis)
      case (axial_by_modes)
         allocate (strains, source=mean_strains(field, x))
      case (axial_by_elements)
         call axial_basis(beam, choice%support, x, element_functions(size(x) - 1), field, strains, error)
      case (axial_static)
         call axial_basis(beam, choice%support, x, static_functions(x, slopes, load_origin(beam, choice), &
            & choice%end_force, choice%centrifugal, choice%derivatives), field, strains, error)
      end select
      if (allocated(error)) return
      allocate (field%strain, source=strains)

      call sum_inertia(beam, choice%origin, field, body)
      allocate (body%omega2, source=[field%omega2_bending, field%omega2_axial])
      body%geometric = choice%fidelity /= fidelity_linear .and. body%bending > 0
      body%full = choice%fidelity == fidelity_full .and. body%bending > 0
      if (body%geometric .and. choice%linear) then
         x = x(::pieces)
         allocate (body%cubic, source=project_cubic(beam%ea, x, joined_strains(strains, pieces), mean_slopes(field, x, .false.)) &
            & + project_cubic(beam%ea, x, strain_moments(strains, pieces), slope_moments(field, x)))
      else if (body%geometric) then
         allocate (body%cubic, source=project_cubic(beam%ea, x, strains, slopes))
      else
         allocate (body%cubic(0, body%n - body%bending))
      end if
      if (body%full) then
         allocate (body%quartic, source=project_membrane(beam%ea, x, slopes) + project_curvature(beam, field))
      else
         allocate (body%quartic(0, 0))
      end if
   end subroutine reduce_beam

   !> Displacement (2,n) and rotation (n) of all coordinates at a place along the beam.
   pure subroutine point_shape(field, x, phi, psi)
      type(field_type), intent(in) :: field
      !> Coordinate along the beam [length]
      real(wp), intent(in) :: x
      !> Displacement along the body's axes for each coordinate (2,n)
      real(wp), allocatable, intent(out) :: phi(:, :)
      !> Rotation of the section for each coordinate (n)
      real(wp), allocatable, intent(out) :: psi(:)
      integer :: bending, n
      bending = size(field%w, 2)
      n = bending + size(field%u, 2)
      allocate (phi(2, n), psi(n))
      phi = 0.0_wp
      psi = 0.0_wp
      phi(2, :bending) = deflection_at(field, x)
      phi(1, bending + 1:) = extension_at(field, x)
      psi(:bending) = slope_at(field, x, bending_slope)
   end subroutine point_shape

   !> The vibration modes: so many of each kind as asked for, or the lowest of both kinds together.
   subroutine compute_modes(beam, choice, field, error)
      type(beam_type), intent(in) :: beam
      type(reduction_type), intent(in) :: choice
      type(field_type), intent(inout) :: field
      type(error_type), allocatable, intent(out) :: error
      integer :: available(2), bending, axial
      available = available_modes(beam, choice%support)
      bending = choice%bending
      axial = choice%axial
      if (choice%modes >= 0) then
         if (choice%modes > sum(available)) then
            call raise(error, 'the lumped mass gives '//as_text(sum(available))//' modes, '// &
               & as_text(choice%modes)//' are asked for')
            return
         end if
         call bending_modes(beam, choice%support, min(choice%modes, available(1)), field, error)
         if (allocated(error)) return
         call axial_modes(beam, choice%support, min(choice%modes, available(2)), field, error)
         if (allocated(error)) return
         bending = lowest_of(field%omega2_bending, field%omega2_axial, choice%modes)
         axial = choice%modes - bending
         if (choice%axial_basis /= axial_by_modes) axial = 0
         call keep(field, bending, axial)
      else
         call bending_modes(beam, choice%support, bending, field, error)
         if (allocated(error)) return
         if (choice%axial_basis == axial_by_modes) call axial_modes(beam, choice%support, axial, field, error)
      end if
   end subroutine compute_modes

   !> How many of the lowest `wanted` values of two ascending lists stand in the first.
   pure integer function lowest_of(a, b, wanted) result(count)
      real(wp), intent(in) :: a(:), b(:)
      integer, intent(in) :: wanted
      integer :: i
      count = 0
      do i = 1, wanted
         if (count == size(a)) exit
         if (i - count <= size(b)) then
            if (b(i - count) < a(count + 1)) cycle
         end if
         count = count + 1
      end do
   end function lowest_of

   !> Keeps the first modes of each kind.
   pure subroutine keep(field, bending, axial)
      type(field_type), intent(inout) :: field
      integer, intent(in) :: bending, axial
      real(wp), allocatable :: kept(:, :)
      integer :: last
      last = ubound(field%s, 1)
      allocate (kept(0:last, bending))
      kept(:, :) = field%w(:, :bending)
      call move_alloc(kept, field%w)
      allocate (kept(0:last, bending))
      kept(:, :) = field%theta(:, :bending)
      call move_alloc(kept, field%theta)
      allocate (kept(0:last, axial))
      kept(:, :) = field%u(:, :axial)
      call move_alloc(kept, field%u)
      field%omega2_bending = field%omega2_bending(:bending)
      field%omega2_axial = field%omega2_axial(:axial)
   end subroutine keep

   !> Where the centrifugal load grows from: the frame's origin, or the middle of a beam that nothing holds.
   pure real(wp) function load_origin(beam, choice)
      type(beam_type), intent(in) :: beam
      type(reduction_type), intent(in) :: choice
      load_origin = choice%origin
      if (.not. (choice%support%u_start .or. choice%support%u_end)) load_origin = 0.5_wp*beam%length
   end function load_origin

   !> Inertia invariants: sums over the nodes.
   subroutine sum_inertia(beam, origin, field, body)
      type(beam_type), intent(in) :: beam
      real(wp), intent(in) :: origin
      type(field_type), intent(in) :: field
      type(reduced_type), intent(out) :: body
      real(wp) :: mass(0:beam%elements), inertia(0:beam%elements)
      real(wp), allocatable :: phi(:, :), psi(:)
      integer :: i
      body%bending = size(field%w, 2)
      body%offset = body%bending
      call start_inertia(body, body%bending + size(field%u, 2))
      allocate (phi(2, body%n), psi(body%n))
      mass = nodal_masses(beam)
      inertia = nodal_inertias(beam)
      do i = 0, beam%elements
         phi = 0.0_wp
         phi(2, :body%bending) = field%w(i, :)
         phi(1, body%bending + 1:) = field%u(i, :)
         call add_inertia(body, mass(i), [field%s(i) - origin, 0.0_wp], phi)
         if (.not. inertia(i) > 0.0_wp) cycle
         psi = 0.0_wp
         psi(:body%bending) = field%theta(i, :)
         call add_rotary(body, inertia(i), psi)
      end do
   end subroutine sum_inertia

end module limber_flex_reduction
