!> Reduction of a straight beam to its constants. Modes, axial functions, geometric part, invariants. The number of elements for the
!> modes, of modes, and of k_G elements are independent of each other. Floor: beam. Source: Han and Lee 1993, sections 3 and 6;
!> doc/theory, part 2.
module limber_beam_beam_reduction
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_base_text, only: as_text
   use limber_beam_element_matrices, only: bending_slope
   use limber_beam_exact_beam, only: exact_type, new_exact, reach_of, angles_at, undeformed_place
   use limber_beam_axial_functions, only: static_functions, axial_basis
   use limber_beam_exact_functions, only: exact_choice_type
   use limber_beam_plane_frame, only: frame_type, beam_frame, beam_nodes
   use limber_beam_frame_solver, only: solver_type, new_solver, remove_motion
   use limber_beam_static_functions, only: attachment_type, attachment_loads, static_responses, remaining_responses, &
      & add_functions, left_out_note
   use limber_beam_geometric_stiffness, only: mean_slopes, slope_moments, mean_strains, strain_moments, joined_strains, &
      & element_ends, &
      & project_cubic
   use limber_beam_beam_mesh, only: beam_type, support_type, displacement_field_type, mesh_beam, bending_modes, axial_modes, &
      & nodal_masses, &
      & nodal_inertias, count_bending_modes, count_axial_modes, deflection_at, slope_at, extension_at
   use limber_beam_reduction_limits, only: check_size, check_slopes
   use limber_beam_reduced_body, only: reduced_type, start_inertia, add_inertia, add_rotary
   implicit none
   private
   public :: reduction_type, reduce_beam, available_modes, point_shape, exact_shape

   !> Fidelities of a flexible body
   integer, parameter, public :: fidelity_linear = 1, fidelity_kg = 2, fidelity_exact = 3

   !> What the user chooses of a beam's reduction
   type :: reduction_type
      !> Supports of the modes
      type(support_type) :: support
      !> Modes in all, the lowest of both kinds together; unused (-1) if both counts are given apart
      integer :: modes = -1
      !> Bending and axial modes apart; -1 where `modes` decides
      integer :: bending = -1, axial = -1
      !> What acts on the beam, the responses to which join the coordinates
      type(attachment_type), allocatable :: corrections(:)
      !> fidelity_linear, fidelity_kg or fidelity_exact
      integer :: fidelity = fidelity_kg
      !> Number of k_G elements
      integer :: geometric_elements = 2
      !> True: w'^2 of a k_G element from w and theta at its own ends; false: the exact integral
      logical :: nodal = .false.
      !> True: the tension changes linearly within a k_G element, which the model k_g only can have
      logical :: linear = .false.
      !> True: axial functions are static responses; false: vibration modes
      logical :: static_axial = .false.
      !> Coordinate along the beam of the floating frame's origin [length]
      real(wp) :: origin = 0.0_wp
      !> Of an exact beam
      type(exact_choice_type) :: exact
   end type reduction_type

contains

   !> Number of modes that exist: bending and axial.
   function available_modes(beam, choice) result(available)
      type(beam_type), intent(in) :: beam
      type(reduction_type), intent(in) :: choice
      integer :: available(2)
      available = [count_bending_modes(beam, choice%support), count_axial_modes(beam, choice%support)]
   end function available_modes

   !> Reduces a beam.
   subroutine reduce_beam(beam, choice, body, field, error, note)
      type(beam_type), intent(in) :: beam
      type(reduction_type), intent(in) :: choice
      !> Constants for the time loop
      type(reduced_type), intent(out) :: body
      !> Shapes of the coordinates at the nodes, for points and results
      type(displacement_field_type), intent(out) :: field
      !> More modes asked for than there are, or no convergence
      type(error_type), allocatable, intent(out) :: error
      !> What was left out because it depends on others; empty if nothing was
      character(:), allocatable, intent(out), optional :: note
      real(wp), allocatable :: x(:), slopes(:, :, :), strains(:, :)
      integer :: pieces, left_out(2), modes

      field = mesh_beam(beam)
      if (present(note)) note = ''
      if (choice%fidelity == fidelity_exact) then
         call reduce_exact(beam, choice%exact, field, body, error)
         return
      end if
      left_out = 0
      call compute_modes(beam, choice, field, error)
      if (allocated(error)) return
      modes = size(field%omega2_bending)
      call add_static(beam, choice, field, left_out, error)
      if (allocated(error)) return
      ! Axial functions on pieces of the k_G elements, if the tension may vary within these
      pieces = 1
      if (choice%linear) pieces = max(1, beam%elements/choice%geometric_elements)
      call check_slopes(size(field%w, 2), choice%geometric_elements*pieces, beam%elements, 'modes or GEOMETRIC ELEMENTS', error)
      if (allocated(error)) return
      allocate (x(0:choice%geometric_elements*pieces))
      x(:) = element_ends(beam%length, choice%geometric_elements*pieces)
      allocate (slopes, source=mean_slopes(field, x, choice%nodal))
      if (choice%static_axial) then
         call axial_basis(beam, choice%support, x, static_functions(x, load_origin(beam, choice), axial_places(choice), &
            & choice%support), field, strains, error, left_out(2))
         if (allocated(error)) return
      else
         allocate (strains, source=mean_strains(field, x))
      end if
      if (present(note)) then
         note = left_out_note(left_out(1), 'bending ')
         if (all(left_out > 0)) note = note//', '
         note = note//left_out_note(left_out(2), 'axial ')
      end if
      allocate (field%strain, source=strains)

      call sum_inertia(beam, choice%origin, field, body)
      body%modes = modes
      allocate (body%omega2, source=[field%omega2_bending, field%omega2_axial])
      body%geometric = choice%fidelity /= fidelity_linear .and. body%bending > 0
      if (body%geometric) call check_size(body%bending, body%n - body%bending, error)
      if (allocated(error)) return
      if (body%geometric .and. choice%linear) then
         x = x(::pieces)
         allocate (body%cubic, source=project_cubic(beam%ea, x, joined_strains(strains, pieces), mean_slopes(field, x, .false.)) &
            & + project_cubic(beam%ea, x, strain_moments(strains, pieces), slope_moments(field, x)))
      else if (body%geometric) then
         allocate (body%cubic, source=project_cubic(beam%ea, x, strains, slopes))
      else
         allocate (body%cubic(0, body%n - body%bending))
      end if
   end subroutine reduce_beam

   !> Reduces a beam to the functions of an exact one; the fields are those of small deflections.
   subroutine reduce_exact(beam, choice, field, body, error)
      type(beam_type), intent(in) :: beam
      type(exact_choice_type), intent(in) :: choice
      type(displacement_field_type), intent(inout) :: field
      type(reduced_type), intent(out) :: body
      type(error_type), allocatable, intent(out) :: error
      type(exact_type), allocatable :: exact
      real(wp), allocatable :: phi(:, :), psi(:), omega2(:)
      real(wp) :: x
      integer :: i, a, n
      allocate (exact, omega2(0))
      call new_exact(beam, choice, exact, omega2, error)
      if (allocated(error)) return
      n = exact%n
      a = exact%angles
      deallocate (field%w, field%theta, field%u)
      allocate (field%w(0:beam%elements, a), field%theta(0:beam%elements, a), field%u(0:beam%elements, n - a))
      do i = 0, beam%elements
         call exact_shape(exact, field%s(i), phi, psi)
         field%w(i, :) = phi(2, :a)
         field%theta(i, :) = psi(:a)
         field%u(i, :) = phi(1, a + 1:)
      end do
      field%omega2_bending = omega2(:a)
      field%omega2_axial = omega2(a + 1:)
      body%bending = a
      body%offset = a
      call start_inertia(body, n)
      do i = 1, exact%points
         if (i <= exact%stations) then
            x = exact%s(i)
         else
            x = exact%lump_at(i - exact%stations)
         end if
         call exact_shape(exact, x, phi, psi)
         call add_inertia(body, exact%mass(i), undeformed_place(exact, x), phi)
         if (exact%inertia(i) > 0.0_wp) call add_rotary(body, exact%inertia(i), psi)
      end do
      body%strained = any(abs(exact%rest) > 0.0_wp)
      call move_alloc(exact, body%exact)
      call move_alloc(omega2, body%omega2)
      body%is_exact = .true.
      allocate (body%cubic(0, 0))
   end subroutine reduce_exact

   !> Displacement (2,n) and rotation (n) of the coordinates of an exact beam at a place along it, undeformed, and what its stations
   !> give to the place (stations).
   pure subroutine exact_shape(exact, x, phi, psi, reach)
      type(exact_type), intent(in) :: exact
      !> Coordinate along the beam [length]
      real(wp), intent(in) :: x
      real(wp), allocatable, intent(out) :: phi(:, :), psi(:)
      real(wp), allocatable, intent(out), optional :: reach(:)
      real(wp) :: own(exact%stations), axis(2)
      integer :: i
      own = reach_of(exact, x) - exact%base
      allocate (phi(2, exact%n), psi(exact%n))
      phi = 0.0_wp
      psi = 0.0_wp
      psi(:exact%angles) = angles_at(exact, x)
      do i = 1, exact%stations
         axis = own(i)*[cos(exact%lean(i)), sin(exact%lean(i))]
         phi(1, :exact%angles) = phi(1, :exact%angles) - axis(2)*exact%psi(:, i)
         phi(2, :exact%angles) = phi(2, :exact%angles) + axis(1)*exact%psi(:, i)
         phi(1, exact%angles + 1:) = phi(1, exact%angles + 1:) + axis(1)*exact%chi(1, :, i) - axis(2)*exact%chi(2, :, i)
         phi(2, exact%angles + 1:) = phi(2, exact%angles + 1:) + axis(2)*exact%chi(1, :, i) + axis(1)*exact%chi(2, :, i)
      end do
      if (present(reach)) allocate (reach, source=own)
   end subroutine exact_shape

   !> Displacement (2,n) and rotation (n) of all coordinates at a place along the beam.
   pure subroutine point_shape(field, x, phi, psi)
      type(displacement_field_type), intent(in) :: field
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

   !> Coordinates of the places where forces along the beam act [length].
   pure function axial_places(choice) result(x)
      type(reduction_type), intent(in) :: choice
      real(wp), allocatable :: x(:)
      type(attachment_type), allocatable :: acting(:)
      call find_acting(choice, acting)
      allocate (x, source=pack(acting%x, acting%part == 1))
   end function axial_places

   !> Where the centrifugal load grows from: the frame's origin, or the middle of a beam that nothing holds.
   pure real(wp) function load_origin(beam, choice)
      type(beam_type), intent(in) :: beam
      type(reduction_type), intent(in) :: choice
      load_origin = choice%origin
      if (.not. (choice%support%u_start .or. choice%support%u_end)) load_origin = 0.5_wp*beam%length
   end function load_origin

   !> What acts on the beam; empty if nothing does.
   pure subroutine find_acting(choice, acting)
      type(reduction_type), intent(in) :: choice
      type(attachment_type), allocatable, intent(out) :: acting(:)
      integer :: count
      count = 0
      if (allocated(choice%corrections)) count = size(choice%corrections)
      allocate (acting(count))
      if (count > 0) acting(:) = choice%corrections
   end subroutine find_acting

   !> The modes, vibrations under the supports: so many of each kind as asked for, or the lowest of both kinds together.
   subroutine compute_modes(beam, choice, field, error)
      type(beam_type), intent(in) :: beam
      type(reduction_type), intent(in) :: choice
      type(displacement_field_type), intent(inout) :: field
      type(error_type), allocatable, intent(out) :: error
      integer :: available(2), bending, axial
      bending = choice%bending
      axial = choice%axial
      if (choice%modes >= 0) then
         available = available_modes(beam, choice)
         if (choice%modes > sum(available)) then
            call raise(error, 'the lumped mass gives '//as_text(sum(available))//' modes, '// &
               & as_text(choice%modes)//' are asked for')
            return
         end if
         bending = min(choice%modes, available(1))
         axial = min(choice%modes, available(2))
      end if
      call bending_modes(beam, choice%support, bending, field, error)
      if (allocated(error)) return
      if (choice%modes >= 0 .or. .not. choice%static_axial) call axial_modes(beam, choice%support, axial, field, error)
      if (allocated(error)) return
      bending = size(field%omega2_bending)
      axial = size(field%omega2_axial)
      if (choice%modes >= 0) then
         bending = lowest_of(field%omega2_bending, field%omega2_axial, choice%modes)
         axial = choice%modes - bending
      end if
      if (choice%static_axial) axial = 0
      call keep(field, bending, axial)
   end subroutine compute_modes

   !> Static functions beside the modes: the responses to what acts. Bending and axial ones do not couple.
   subroutine add_static(beam, choice, field, left_out, error)
      type(beam_type), intent(in) :: beam
      type(reduction_type), intent(in) :: choice
      type(displacement_field_type), intent(inout) :: field
      !> Functions that depend on others: bending and axial ones
      integer, intent(inout) :: left_out(2)
      type(error_type), allocatable, intent(out) :: error
      type(attachment_type), allocatable :: acting(:)
      type(frame_type) :: frame
      type(solver_type) :: solver
      real(wp), allocatable :: shape(:, :, :), part(:, :, :), omega2(:)
      integer :: node(0:beam%elements), i, modes
      call find_acting(choice, acting)
      if (size(acting) == 0) return
      call beam_frame(beam, choice%support, choice%origin, field, frame, shape)
      call new_solver(frame, solver, error)
      if (allocated(error)) return
      do i = 1, size(shape, 3)
         call remove_motion(frame, solver, shape(:, :, i))
      end do
      node = beam_nodes(frame)
      modes = size(field%w, 2)
      allocate (part, source=shape(:, :, :modes))
      allocate (omega2, source=field%omega2_bending)
      call add_responses(frame, solver, pack(acting, acting%part /= 1), part, omega2, left_out(1), error)
      if (allocated(error)) return
      deallocate (field%w, field%theta, field%omega2_bending)
      allocate (field%w(0:beam%elements, size(omega2)), field%theta(0:beam%elements, size(omega2)))
      allocate (field%omega2_bending, source=omega2)
      field%w(:, :) = part(2, node, :)
      field%theta(:, :) = part(3, node, :)
      if (choice%static_axial) return
      deallocate (part, omega2)
      allocate (part, source=shape(:, :, modes + 1:))
      allocate (omega2, source=field%omega2_axial)
      call add_responses(frame, solver, pack(acting, acting%part == 1), part, omega2, left_out(2), error)
      if (allocated(error)) return
      deallocate (field%u, field%omega2_axial)
      allocate (field%u(0:beam%elements, size(omega2)))
      allocate (field%omega2_axial, source=omega2)
      field%u(:, :) = part(1, node, :)
   end subroutine add_static

   !> Responses to what acts in one way, across or along the beam.
   subroutine add_responses(frame, solver, acting, shape, omega2, left_out, error)
      type(frame_type), intent(in) :: frame
      type(solver_type), intent(in) :: solver
      type(attachment_type), intent(in) :: acting(:)
      !> Of the modes (3, nodes, n) and (n); receive those of all
      real(wp), allocatable, intent(inout) :: shape(:, :, :), omega2(:)
      integer, intent(inout) :: left_out
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: load(:, :, :), responses(:, :, :), rests(:, :, :)
      real(wp) :: lost
      lost = 0.0_wp
      if (size(acting) == 0) return
      allocate (load, source=attachment_loads(frame, acting))
      allocate (responses, mold=load)
      call static_responses(frame, solver, load, responses)
      call remaining_responses(frame, solver, shape, load, rests)
      call add_functions(frame, responses, rests, .false., shape, omega2, left_out, lost, error)
   end subroutine add_responses

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
      type(displacement_field_type), intent(inout) :: field
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

   !> Inertia invariants: sums over the nodes.
   subroutine sum_inertia(beam, origin, field, body)
      type(beam_type), intent(in) :: beam
      real(wp), intent(in) :: origin
      type(displacement_field_type), intent(in) :: field
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

end module limber_beam_beam_reduction
