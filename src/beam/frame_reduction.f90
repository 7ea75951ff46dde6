!> Reduction of a plane frame to its constants. Vibration modes, static functions, geometric part, invariants. Each member is a
!> straight beam that all coordinates bend and stretch. Floor: beam. Source: doc/theory, eqs. (2.4)-(2.6), (2.8), (2.13)-(2.15).
module limber_beam_frame_reduction
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_base_text, only: as_text
   use limber_beam_element_matrices, only: bending_slope
   use limber_beam_plane_frame, only: frame_type, member_field
   use limber_beam_frame_solver, only: solver_type, new_solver, frame_band, rigid_motions, on_equations, &
      & from_equations, remove_motion
   use limber_beam_static_functions, only: attachment_type, attachment_loads, constraint_functions, static_responses, &
      & remaining_responses, add_functions, &
      & left_out_note
   use limber_beam_geometric_stiffness, only: mean_slopes, mean_strains, project_cubic
   use limber_beam_beam_mesh, only: displacement_field_type, deflection_at, slope_at, extension_at
   use limber_beam_modal_reduction, only: lowest_modes, count_held_modes
   use limber_beam_reduction_limits, only: check_size, check_slopes
   use limber_beam_reduced_body, only: reduced_type, start_inertia, add_inertia, add_rotary
   use limber_beam_beam_reduction, only: fidelity_linear, fidelity_kg
   implicit none
   private
   public :: frame_choice_type, reduce_frame, available_frame_modes, frame_point_shape

   !> Modes that are looked for at first if there is a limit of their frequencies
   integer, parameter :: first_search = 8
   !> Most modes below a limit of frequency
   integer, parameter :: max_limited = 1000

   !> What the user chooses of a frame's reduction
   type :: frame_choice_type
      !> Number of vibration modes
      integer :: modes = 0
      !> Circular frequency above which modes are left out, whatever their number; zero: none [1/time]
      real(wp) :: frequency_limit = 0.0_wp
      !> Whether the modes are those with the interface held, and its shapes join them (Craig and Bampton)
      logical :: craig_bampton = .false.
      !> The interface, beside `attachments`; and what else acts on the frame, the responses to which join the coordinates
      type(attachment_type), allocatable :: interface(:), corrections(:)
      !> fidelity_linear or fidelity_kg
      integer :: fidelity = fidelity_kg
      !> Static functions: responses to rotation and to the three accelerations of the frame
      logical :: accelerations = .false.
      !> Static functions: responses to unit loads on degrees of freedom, [node, 1 to 3] each (2, number)
      integer, allocatable :: attachments(:, :)
   end type frame_choice_type

contains

   !> Number of modes that the lumped mass gives, with the interface held if the choice says so.
   integer function available_frame_modes(frame, choice) result(available)
      type(frame_type), intent(in) :: frame
      type(frame_choice_type), intent(in), optional :: choice
      integer, allocatable :: number(:, :)
      real(wp), allocatable :: band(:, :), rigid(:, :), held(:, :)
      call frame_band(frame, number, band)
      call rigid_vectors(frame, number, rigid)
      allocate (held(size(band, 2), 0))
      if (present(choice)) then
         deallocate (held)
         call held_rows(frame, choice, number, held)
      end if
      available = count_held_modes(on_equations(number, frame%mass), rigid, held)
   end function available_frame_modes

   !> Rigid motions that the supports leave, on the equations (n, number).
   subroutine rigid_vectors(frame, number, rigid)
      type(frame_type), intent(in) :: frame
      integer, intent(in) :: number(:, :)
      real(wp), allocatable, intent(out) :: rigid(:, :)
      real(wp), allocatable :: motion(:, :, :)
      integer :: j
      call rigid_motions(frame, motion)
      allocate (rigid(maxval(number), size(motion, 3)))
      do j = 1, size(motion, 3)
         rigid(:, j) = on_equations(number, motion(:, :, j))
      end do
   end subroutine rigid_vectors

   !> Unit loads of the interface: at the attachments of the deck and at places (3, nodes, number); none without Craig and Bampton.
   subroutine interface_loads(frame, choice, load)
      type(frame_type), intent(in) :: frame
      type(frame_choice_type), intent(in) :: choice
      real(wp), allocatable, intent(out) :: load(:, :, :)
      integer :: nodes, places, i
      nodes = 0
      places = 0
      if (choice%craig_bampton .and. allocated(choice%attachments)) nodes = size(choice%attachments, 2)
      if (choice%craig_bampton .and. allocated(choice%interface)) places = size(choice%interface)
      allocate (load(3, size(frame%place, 2), nodes + places))
      load = 0.0_wp
      do i = 1, nodes
         associate (part => choice%attachments(2, i), node => choice%attachments(1, i))
            if (frame%free(part, node)) load(part, node, i) = 1.0_wp
         end associate
      end do
      if (places > 0) load(:, :, nodes + 1:) = attachment_loads(frame, choice%interface)
   end subroutine interface_loads

   !> Displacements that are held while the modes are computed, on the equations (n, number).
   subroutine held_rows(frame, choice, number, held)
      type(frame_type), intent(in) :: frame
      type(frame_choice_type), intent(in) :: choice
      integer, intent(in) :: number(:, :)
      real(wp), allocatable, intent(out) :: held(:, :)
      real(wp), allocatable :: load(:, :, :)
      integer :: i
      call interface_loads(frame, choice, load)
      allocate (held(maxval(number), size(load, 3)))
      do i = 1, size(load, 3)
         held(:, i) = on_equations(number, load(:, :, i))
      end do
   end subroutine held_rows

   !> Reduces a frame.
   subroutine reduce_frame(frame, choice, body, shape, error, note, cut, lost)
      type(frame_type), intent(in) :: frame
      type(frame_choice_type), intent(in) :: choice
      !> Constants for the time loop
      type(reduced_type), intent(out) :: body
      !> Displacements of the nodes for each coordinate, in the axes of the body (3, nodes, n)
      real(wp), allocatable, intent(out) :: shape(:, :, :)
      !> More modes asked for than there are, or no convergence
      type(error_type), allocatable, intent(out) :: error
      !> What was left out because it depends on others; empty if nothing was
      character(:), allocatable, intent(out), optional :: note
      !> Whether the first mode that is left out has the frequency of the last one that is not
      logical, intent(out), optional :: cut
      !> Largest part of the strain energy of a response that is lost, as the modes leave no mass for it
      real(wp), intent(out), optional :: lost
      type(solver_type) :: solver
      real(wp), parameter :: equal = 1.0e-7_wp
      real(wp), allocatable :: omega2(:), functions(:, :, :), rests(:, :, :), load(:, :, :)
      real(wp) :: next, part
      integer :: i, left_out, modes
      left_out = 0
      part = 0.0_wp
      if (present(cut)) cut = .false.
      call vibration_modes(frame, choice, shape, omega2, next, error)
      if (allocated(error)) return
      modes = size(omega2)
      if (present(cut) .and. size(omega2) > 0) cut = next <= omega2(size(omega2))*(1 + equal)
      call interface_loads(frame, choice, load)
      if (size(load, 3) > 0) then
         call new_solver(frame, solver, error)
         if (allocated(error)) return
         do i = 1, size(shape, 3)
            call remove_motion(frame, solver, shape(:, :, i))
         end do
         call constraint_functions(frame, solver, load, functions)
         call add_functions(frame, functions, rests, .true., shape, omega2, left_out, part, error)
         if (allocated(error)) return
         deallocate (functions)
      end if
      call static_functions(frame, choice, shape, functions, rests, error)
      if (allocated(error)) return
      if (size(functions, 3) > 0) call add_functions(frame, functions, rests, size(load, 3) > 0, shape, omega2, left_out, part, &
         & error)
      if (present(lost)) lost = part
      if (allocated(error)) return
      if (present(note)) note = left_out_note(left_out, '')
      call start_inertia(body, size(omega2))
      body%bending = body%n
      body%modes = modes
      do i = 1, size(frame%place, 2)
         call add_inertia(body, frame%mass(1, i), frame%place(:, i), shape(1:2, i, :))
         if (frame%mass(3, i) > 0.0_wp) call add_rotary(body, frame%mass(3, i), shape(3, i, :))
      end do
      allocate (body%omega2, source=omega2)
      body%geometric = choice%fidelity /= fidelity_linear .and. body%n > 0
      if (body%geometric) call check_size(body%n, body%n, error)
      if (body%geometric .and. .not. allocated(error)) call check_slopes(body%n, size(frame%length), size(frame%length), &
         & 'MODES or DIVISIONS, or for LARGE=YES', error)
      if (.not. allocated(error)) call project_members(frame, shape, body)
   end subroutine reduce_frame

   !> Displacement (2,n) and rotation (n) of all coordinates at a place along a member.
   pure subroutine frame_point_shape(frame, shape, member, x, phi, psi)
      type(frame_type), intent(in) :: frame
      !> (3, nodes, n)
      real(wp), intent(in) :: shape(:, :, :)
      integer, intent(in) :: member
      !> Coordinate along the member [length]
      real(wp), intent(in) :: x
      real(wp), allocatable, intent(out) :: phi(:, :), psi(:)
      type(displacement_field_type) :: field
      real(wp) :: axis(2), u(size(shape, 3)), w(size(shape, 3))
      field = member_field(frame, shape, member)
      axis = frame%axis(:, frame%first(member))
      u = extension_at(field, x)
      w = deflection_at(field, x)
      allocate (phi(2, size(u)), psi(size(u)))
      phi(1, :) = axis(1)*u - axis(2)*w
      phi(2, :) = axis(2)*u + axis(1)*w
      psi = slope_at(field, x, bending_slope)
   end subroutine frame_point_shape

   !> The lowest vibration modes under the supports, eqs. (2.4), (2.5), with the interface held as well if there is one; none above
   !> the limit.
   subroutine vibration_modes(frame, choice, shape, omega2, next, error)
      type(frame_type), intent(in) :: frame
      type(frame_choice_type), intent(in) :: choice
      real(wp), allocatable, intent(out) :: shape(:, :, :), omega2(:)
      !> That of the lowest mode that is left out; huge if none is
      real(wp), intent(out) :: next
      type(error_type), allocatable, intent(out) :: error
      integer, allocatable :: number(:, :)
      real(wp), allocatable :: band(:, :), rigid(:, :), phi(:, :), mass(:), held(:, :), all(:)
      real(wp) :: shift
      integer :: j, wanted, most
      logical :: limited
      limited = choice%frequency_limit > 0.0_wp
      call frame_band(frame, number, band)
      call rigid_vectors(frame, number, rigid)
      call held_rows(frame, choice, number, held)
      allocate (mass, source=on_equations(number, frame%mass))
      shift = 0.0_wp
      if (size(rigid, 2) > 0) shift = -maxval(frame%ei)/(sum(frame%mass(1, :))*sum(frame%length)**3)
      most = choice%modes
      if (limited) most = min(most, count_held_modes(mass, rigid, held))
      wanted = most
      if (limited) wanted = min(most, first_search)
      do
         allocate (all(wanted), phi(size(band, 2), wanted))
         call lowest_modes(band, mass, rigid, shift, wanted, all, phi, error, held, next)
         if (allocated(error)) return
         if (wanted == most .or. any(all > choice%frequency_limit**2)) exit
         if (wanted > max_limited) call raise(error, 'more than '//as_text(max_limited)//' modes lie below FREQUENCY LIMIT')
         if (allocated(error)) return
         wanted = min(most, 2*wanted)
         deallocate (all, phi)
      end do
      if (limited) then
         wanted = count(all <= choice%frequency_limit**2)
         if (wanted < size(all)) next = all(wanted + 1)
      end if
      allocate (omega2(wanted), shape(3, size(frame%place, 2), wanted))
      omega2(:) = all(:wanted)
      do j = 1, wanted
         shape(:, :, j) = from_equations(number, phi(:, j))
      end do
   end subroutine vibration_modes

   !> Responses to the chosen loads.
   subroutine static_functions(frame, choice, shape, functions, rests, error)
      type(frame_type), intent(in) :: frame
      type(frame_choice_type), intent(in) :: choice
      !> Modes (3, nodes, n)
      real(wp), intent(in) :: shape(:, :, :)
      !> (3, nodes, number)
      real(wp), allocatable, intent(out) :: functions(:, :, :)
      !> The same without the modes, where these are vibrations under the supports
      real(wp), allocatable, intent(out) :: rests(:, :, :)
      type(error_type), allocatable, intent(out) :: error
      type(solver_type) :: solver
      real(wp), allocatable :: load(:, :, :)
      integer :: i, count, attached, corrections
      attached = 0
      ! Of Craig and Bampton they are the interface
      if (allocated(choice%attachments) .and. .not. choice%craig_bampton) attached = size(choice%attachments, 2)
      corrections = 0
      if (allocated(choice%corrections)) corrections = size(choice%corrections)
      count = attached + corrections + merge(4, 0, choice%accelerations)
      allocate (functions(3, size(frame%place, 2), count), load(3, size(frame%place, 2), count))
      if (count == 0) return
      call new_solver(frame, solver, error)
      if (allocated(error)) return
      load = 0.0_wp
      do i = 1, attached
         load(choice%attachments(2, i), choice%attachments(1, i), i) = 1.0_wp
      end do
      if (corrections > 0) load(:, :, attached + 1:attached + corrections) = attachment_loads(frame, choice%corrections)
      count = attached + corrections
      if (choice%accelerations) then
         load(1:2, :, count + 1) = frame%mass(1:2, :)*frame%place
         load(1, :, count + 2) = frame%mass(1, :)
         load(2, :, count + 3) = frame%mass(2, :)
         load(1, :, count + 4) = -frame%mass(1, :)*frame%place(2, :)
         load(2, :, count + 4) = frame%mass(2, :)*frame%place(1, :)
         load(3, :, count + 4) = frame%mass(3, :)
      end if
      call static_responses(frame, solver, load, functions)
      if (.not. choice%craig_bampton) call remaining_responses(frame, solver, shape, load, rests)
   end subroutine static_functions

   !> The geometric part: a sum over the members, in each finite element of which the axial force is that of its own strain.
   subroutine project_members(frame, shape, body)
      type(frame_type), intent(in) :: frame
      real(wp), intent(in) :: shape(:, :, :)
      type(reduced_type), intent(inout) :: body
      type(displacement_field_type) :: field
      real(wp), allocatable :: slopes(:, :, :)
      integer :: m
      allocate (body%cubic(merge(body%n*(body%n + 1)/2, 0, body%geometric), body%n))
      body%cubic = 0.0_wp
      if (.not. body%geometric) return
      do m = 1, size(frame%first) - 1
         field = member_field(frame, shape, m)
         allocate (slopes(body%n, body%n, frame%first(m + 1) - frame%first(m)))
         slopes = mean_slopes(field, field%s, .false.)
         body%cubic = body%cubic + project_cubic(frame%ea(frame%first(m)), field%s, mean_strains(field, field%s), slopes)
         deallocate (slopes)
      end do
   end subroutine project_members

end module limber_beam_frame_reduction
