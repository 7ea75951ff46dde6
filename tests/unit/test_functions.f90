!> Static functions beside modes: they hold the flexibility of the mesh where something acts, with the supports' closed forms to
!> compare with; interfaces of Craig and Bampton; modes while displacements are held, equal frequencies among them; what depends
!> on others, limits of frequency, and what is left out.
program test_functions
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_beam_plane_frame, only: beam_frame, frame_type, member_type, new_frame, strain_energy
   use limber_beam_frame_reduction, only: available_frame_modes, frame_choice_type, reduce_frame
   use limber_beam_frame_solver, only: frame_band, new_solver, on_equations, rigid_motions, solve_static, solver_type
   use limber_beam_static_functions, only: attachment_loads, attachment_type
   use limber_beam_beam_mesh, only: beam_type, concentrate, displacement_field_type, mesh_beam, new_support
   use limber_beam_modal_reduction, only: lowest_modes
   use limber_beam_reduced_body, only: reduced_type
   use limber_beam_beam_reduction, only: fidelity_linear, reduce_beam, reduction_type
   use testing, only: check, check_close, check_no_error, check_text, finish
   implicit none
   real(wp), parameter :: ea = 5.0e3_wp, ei = 2.0_wp, rho_a = 0.7_wp, length = 1.5_wp
   real(wp), parameter :: pi = acos(-1.0_wp)
   character(15), parameter :: names(7) = [character(15) :: 'PINNED-ROLLER', 'PINNED-PINNED', 'CLAMPED-FREE', &
      & 'CLAMPED-ROLLER', 'CLAMPED-PINNED', 'CLAMPED-CLAMPED', 'FREE-FREE']
   integer :: i

   do i = 1, size(names)
      call test_corrections(trim(names(i)))
      call test_interface(trim(names(i)))
   end do
   call test_closed_forms()
   call test_two_spans()
   call test_star()
   call test_dependent()
   call test_portal()
   call finish()

contains

   !> Ten elements, one node of which a mass has moved.
   function uneven_beam() result(beam)
      type(beam_type) :: beam
      beam = beam_type(ea=ea, ei=ei, rho_a=rho_a, length=length, elements=10)
      call concentrate(beam, 0.62_wp, 0.3_wp, 0.01_wp)
   end function uneven_beam

   !> Displacements of attachments under unit loads there: those of the mesh, and what the coordinates leave out of them,
   !> eq. (2.22).
   subroutine static_residual(frame, shape, omega2, attachments, whole, left_out, error)
      type(frame_type), intent(in) :: frame
      !> Shapes (3, nodes, n) and squared circular frequencies (n) of the coordinates
      real(wp), intent(in) :: shape(:, :, :), omega2(:)
      type(attachment_type), intent(in) :: attachments(:)
      !> [length/force], [1/(force length)] of couples; zero where the supports take the load (attachments)
      real(wp), intent(out) :: whole(:), left_out(:)
      !> The supports do not hold the body
      type(error_type), allocatable, intent(out) :: error
      type(solver_type) :: solver
      real(wp) :: load(3, size(frame%place, 2), size(attachments)), u(3, size(frame%place, 2))
      integer :: i, j
      whole = 0.0_wp
      left_out = 0.0_wp
      call new_solver(frame, solver, error)
      if (allocated(error)) return
      load = attachment_loads(frame, attachments)
      do i = 1, size(attachments)
         call solve_static(frame, solver, load(:, :, i), u)
         whole(i) = sum(load(:, :, i)*u)
         left_out(i) = whole(i)
         do j = 1, size(omega2)
            left_out(i) = left_out(i) - sum(load(:, :, i)*shape(:, :, j))**2/omega2(j)
         end do
      end do
   end subroutine static_residual

   !> Coordinates orthonormal in the mass, diagonal in the stiffness.
   subroutine check_basis(frame, shape, omega2, name)
      type(frame_type), intent(in) :: frame
      real(wp), intent(in) :: shape(:, :, :), omega2(:)
      character(*), intent(in) :: name
      real(wp) :: mass(size(omega2), size(omega2)), stiffness(size(omega2), size(omega2))
      integer :: j, k
      do k = 1, size(omega2)
         do j = 1, size(omega2)
            mass(j, k) = sum(frame%mass*shape(:, :, j)*shape(:, :, k))
            stiffness(j, k) = strain_energy(frame, shape(:, :, j), shape(:, :, k))/sqrt(omega2(j)*omega2(k))
         end do
         mass(k, k) = mass(k, k) - 1.0_wp
         stiffness(k, k) = stiffness(k, k) - 1.0_wp
      end do
      call check_close(maxval(abs(mass)), 0.0_wp, 1.0e-11_wp, name//': the modal mass is the identity')
      call check_close(maxval(abs(stiffness)), 0.0_wp, 1.0e-7_wp, name//': the stiffness is diagonal')
      call check(all(omega2 > 0.0_wp), name//': no coordinate without stiffness')
   end subroutine check_basis

   !> Two modes of each kind leave a part of the flexibility out, the corrections nothing, at a node and within an element, for
   !> forces and couples.
   subroutine test_corrections(name)
      character(*), intent(in) :: name
      type(attachment_type), parameter :: at(5) = [attachment_type(1, 0.75_wp, 1), attachment_type(1, 0.75_wp, 2), &
         & attachment_type(1, 0.41_wp, 2), attachment_type(1, 0.41_wp, 3), attachment_type(1, 0.0_wp, 3)]
      type(beam_type) :: beam
      type(reduction_type) :: choice
      type(reduced_type) :: body
      type(displacement_field_type) :: field
      type(frame_type) :: frame
      type(error_type), allocatable :: error
      real(wp), allocatable :: shape(:, :, :)
      real(wp) :: whole(5), left(5)
      integer :: turn
      beam = uneven_beam()
      choice = reduction_type(support=new_support(name), bending=2, axial=2, fidelity=fidelity_linear)
      do turn = 1, 2
         if (turn == 2) allocate (choice%corrections, source=at)
         call reduce_beam(beam, choice, body, field, error)
         call check_no_error(error, name)
         call beam_frame(beam, choice%support, 0.0_wp, field, frame, shape)
         call check_basis(frame, shape, body%omega2, name//' with corrections')
         call static_residual(frame, shape, body%omega2, at, whole, left, error)
         call check_no_error(error, name)
         if (turn == 1) call check(all(left(1:4) > 1.0e-4_wp*whole(1:4)), name//': modes leave something out')
         if (turn == 2) call check(all(abs(left) <= 1.0e-9_wp*whole), name//': corrections hold the rest')
         deallocate (shape)
      end do
      call check(body%bending == 2 + merge(3, 4, choice%support%theta_start), name//': a function for each load across')
      call check(body%n - body%bending == 3, name//': a function for the load along')
      deallocate (choice%corrections)
   end subroutine test_corrections

   !> All modes with the interface held and its shapes span what all vibrations do: the frequencies are the same. A beam as frame.
   subroutine test_interface(name)
      character(*), intent(in) :: name
      type(beam_type) :: beam
      type(frame_choice_type) :: choice
      type(reduced_type) :: all_modes, body
      type(error_type), allocatable :: error
      type(frame_type) :: frame
      real(wp), allocatable :: shape(:, :, :)
      beam = uneven_beam()
      call beam_frame(beam, new_support(name), 0.0_wp, mesh_beam(beam), frame, shape)
      choice%fidelity = fidelity_linear
      choice%modes = available_frame_modes(frame)
      call reduce_frame(frame, choice, all_modes, shape, error)
      call check_no_error(error, name)
      choice%craig_bampton = .true.
      allocate (choice%interface(4))
      choice%interface = [attachment_type(1, 0.0_wp, 2), attachment_type(1, 0.62_wp, 1), attachment_type(1, 0.62_wp, 2), &
         & attachment_type(1, 0.9_wp, 2)]
      choice%modes = available_frame_modes(frame, choice)
      call reduce_frame(frame, choice, body, shape, error)
      call check_no_error(error, name)
      call check(body%n == all_modes%n, name//': as many coordinates')
      if (body%n /= all_modes%n) return
      call check(maxval(abs(body%omega2/all_modes%omega2 - 1.0_wp)) < 1.0e-7_wp, name//': the same frequencies')
      ! One mode only
      choice%modes = 1
      call reduce_frame(frame, choice, body, shape, error)
      call check_no_error(error, name)
      call check_basis(frame, shape, body%omega2, name//', Craig and Bampton')
      call check(body%omega2(1) >= all_modes%omega2(1)*(1 - 1.0e-9_wp), name//': no frequency is below the lowest')
      call check(body%omega2(1) <= all_modes%omega2(1)*merge(1.5_wp, 1.02_wp, name == 'FREE-FREE'), name//': nor far above it')
      choice%modes = 99
      call reduce_frame(frame, choice, body, shape, error)
      call check(allocated(error), name//': too many modes')
      deallocate (choice%interface)
   end subroutine test_interface

   !> Deflections of textbooks, from coordinates without a single vibration.
   subroutine test_closed_forms()
      real(wp), parameter :: a = 0.4_wp*length, b = length - a
      call compare('PINNED-ROLLER', attachment_type(1, a, 2), a**2*b**2/(3*ei*length), 'a force on two supports')
      call compare('PINNED-ROLLER', attachment_type(1, 0.0_wp, 3), length/(3*ei), 'a couple at a support')
      call compare('PINNED-ROLLER', attachment_type(1, a, 1), a/ea, 'a force along')
      call compare('PINNED-PINNED', attachment_type(1, a, 1), a*b/(ea*length), 'a force along between two pins')
      call compare('CLAMPED-FREE', attachment_type(1, length, 2), length**3/(3*ei), 'a force at the tip')
      call compare('CLAMPED-FREE', attachment_type(1, length, 3), length/ei, 'a couple at the tip')
      call compare('CLAMPED-CLAMPED', attachment_type(1, a, 2), a**3*b**3/(3*ei*length**3), 'a force between two walls')
      call compare('CLAMPED-PINNED', attachment_type(1, length, 3), length/(4*ei), 'a couple at the far end')
   end subroutine test_closed_forms

   subroutine compare(support, at, exact, name)
      character(*), intent(in) :: support, name
      type(attachment_type), intent(in) :: at
      !> Displacement under a unit load
      real(wp), intent(in) :: exact
      type(beam_type), parameter :: beam = beam_type(ea=ea, ei=ei, rho_a=rho_a, length=length, elements=10)
      type(reduction_type) :: choice
      type(reduced_type) :: body
      type(displacement_field_type) :: field
      type(frame_type) :: frame
      type(error_type), allocatable :: error
      real(wp), allocatable :: shape(:, :, :)
      real(wp) :: whole(1), left(1)
      choice = reduction_type(support=new_support(support), bending=0, axial=0, fidelity=fidelity_linear)
      allocate (choice%corrections(1))
      choice%corrections = at
      call reduce_beam(beam, choice, body, field, error)
      call check_no_error(error, name)
      call check(body%n == 1, name//': one coordinate')
      call beam_frame(beam, choice%support, 0.0_wp, field, frame, shape)
      call static_residual(frame, shape, body%omega2, [at], whole, left, error)
      call check_close(whole(1), exact, 1.0e-9_wp*exact, name)
      call check_close(whole(1) - left(1), exact, 1.0e-9_wp*exact, name//' by the coordinate')
      deallocate (choice%corrections)
   end subroutine compare

   !> A beam held in its middle is two beams: clamped there each has the frequencies of a clamped and pinned one, twice; held
   !> against deflection alone they sway against each other as pinned ones, or together as clamped ones.
   subroutine test_two_spans()
      real(wp), parameter :: clamped(3) = [3.926602_wp, 7.068583_wp, 10.210176_wp]
      type(attachment_type), parameter :: middle(2) = [attachment_type(1, 0.5_wp*length, 2), attachment_type(1, 0.5_wp*length, 3)]
      real(wp), allocatable :: omega2(:)
      real(wp) :: unit
      integer :: j
      unit = ei/rho_a/(0.5_wp*length)**4
      call held_frequencies('PINNED-ROLLER', middle, 6, omega2)
      do j = 1, 3
         call check_close(omega2(2*j)/omega2(2*j - 1), 1.0_wp, 1.0e-8_wp, 'clamped: equal frequencies')
         call check_close(sqrt(omega2(2*j)/unit), clamped(j)**2, 1.0e-3_wp*clamped(j)**2, 'clamped: frequency')
      end do
      call held_frequencies('PINNED-ROLLER', middle(:1), 4, omega2)
      call check_close(sqrt(omega2(1)/unit), pi**2, 1.0e-3_wp*pi**2, 'against each other')
      call check_close(sqrt(omega2(2)/unit), clamped(1)**2, 1.0e-3_wp*clamped(1)**2, 'together')
      ! Free in space: what remains of the rigid motions about one held point is no mode
      call held_frequencies('FREE-FREE', middle(:1), 1, omega2)
      call check(omega2(1) > 0.1_wp*unit, 'a rigid rotation is no mode')
   end subroutine test_two_spans

   !> Squared frequencies of the modes of a beam that cannot stretch, with an interface held.
   subroutine held_frequencies(support, interface, modes, omega2)
      character(*), intent(in) :: support
      type(attachment_type), intent(in) :: interface(:)
      integer, intent(in) :: modes
      real(wp), allocatable, intent(out) :: omega2(:)
      type(beam_type), parameter :: beam = beam_type(ea=1.0e6_wp*ea, ei=ei, rho_a=rho_a, length=length, elements=80)
      type(frame_type) :: frame
      real(wp), allocatable :: band(:, :), rigid(:, :), held(:, :), shape(:, :, :), load(:, :, :), motion(:, :, :), phi(:, :)
      type(error_type), allocatable :: error
      integer, allocatable :: number(:, :)
      integer :: i
      call beam_frame(beam, new_support(support), 0.0_wp, mesh_beam(beam), frame, shape)
      call frame_band(frame, number, band)
      call rigid_motions(frame, motion)
      allocate (rigid(maxval(number), size(motion, 3)), held(maxval(number), size(interface)), omega2(modes), &
         & phi(maxval(number), modes))
      do i = 1, size(motion, 3)
         rigid(:, i) = on_equations(number, motion(:, :, i))
      end do
      allocate (load, source=attachment_loads(frame, interface))
      do i = 1, size(interface)
         held(:, i) = on_equations(number, load(:, :, i))
      end do
      call lowest_modes(band, on_equations(number, frame%mass), rigid, -ei/(rho_a*length**4), modes, omega2, phi, error, held)
      call check_no_error(error, 'two spans')
   end subroutine held_frequencies

   !> Four equal arms: frequencies come in pairs, and none is missed, however many are asked for.
   subroutine test_star()
      type(member_type) :: member(4)
      type(frame_type) :: frame
      type(frame_choice_type) :: choice
      type(reduced_type) :: every, body
      type(error_type), allocatable :: error
      real(wp), allocatable :: shape(:, :, :)
      real(wp) :: corners(2, 5)
      integer :: k, available
      corners = reshape([0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, -1.0_wp, 0.0_wp, 0.0_wp, -1.0_wp], [2, 5])
      do k = 1, 4
         member(k) = member_type([1, k + 1], ea, ei, rho_a, 6)
      end do
      frame = new_frame(corners, member)
      frame%free(:, 2:5) = .false.
      available = available_frame_modes(frame)
      choice%fidelity = fidelity_linear
      choice%modes = available
      call reduce_frame(frame, choice, every, shape, error)
      call check_no_error(error, 'star')
      call check(count(every%omega2(2:12)/every%omega2(:11) < 1 + 1.0e-9_wp) >= 3, 'star: equal frequencies')
      do k = 1, 12
         choice%modes = k
         call reduce_frame(frame, choice, body, shape, error)
         call check_no_error(error, 'star')
         call check(maxval(abs(body%omega2/every%omega2(:k) - 1.0_wp)) < 1.0e-8_wp, 'star: none is missed')
         call check_basis(frame, shape, body%omega2, 'star')
      end do
   end subroutine test_star

   !> What depends on others is left out, and said.
   subroutine test_dependent()
      type(beam_type), parameter :: beam = beam_type(ea=ea, ei=ei, rho_a=rho_a, length=length, elements=6)
      type(reduction_type) :: choice
      type(reduced_type) :: body
      type(displacement_field_type) :: field
      type(error_type), allocatable :: error
      character(:), allocatable :: note
      choice = reduction_type(support=new_support('CLAMPED-FREE'), bending=2, axial=1, fidelity=fidelity_linear)
      call reduce_beam(beam, choice, body, field, error, note)
      call check_text(note, '', 'nothing depends')
      allocate (choice%corrections(3))
      choice%corrections = [attachment_type(1, length, 2), attachment_type(1, length, 2), attachment_type(1, 0.0_wp, 2)]
      call reduce_beam(beam, choice, body, field, error, note)
      call check_no_error(error, 'twice the same')
      call check(body%bending == 3, 'twice the same force, and one on a support: one function')
      call check_text(note, '1 bending function depends on others and is left out', 'twice the same')
      ! All masses move as they like in the modes: a function could add rotations alone
      choice%bending = 6
      choice%axial = 6
      choice%corrections = [attachment_type(1, length, 2), attachment_type(1, length, 3), attachment_type(1, length, 1)]
      call reduce_beam(beam, choice, body, field, error, note)
      call check_no_error(error, 'all modes')
      call check(body%bending == 6 .and. body%n == 12, 'all modes: nothing to add')
      call check_text(note, '2 bending functions depend on others and are left out, '// &
         & '1 axial function depends on others and is left out', 'all modes')
      deallocate (choice%corrections)
   end subroutine test_dependent

   !> A clamped portal: with the knees as interface and all modes of the held members the frequencies are those of the mesh; few
   !> of them hold the lowest ones, and the sway under a force at a knee to round-off.
   subroutine test_portal()
      type(member_type) :: member(3)
      type(frame_type) :: frame
      type(frame_choice_type) :: choice, held
      type(reduced_type) :: every, body
      type(error_type), allocatable :: error
      real(wp), allocatable :: shape(:, :, :)
      real(wp) :: whole(3), left(3)
      type(attachment_type), parameter :: knee(3) = [attachment_type(1, 2.0_wp, 1), attachment_type(1, 2.0_wp, 2), &
         & attachment_type(1, 2.0_wp, 3)]
      integer :: k
      do k = 1, 3
         member(k) = member_type([k, k + 1], ea, ei, rho_a, 6)
      end do
      frame = new_frame(reshape([0.0_wp, 0.0_wp, 0.0_wp, 2.0_wp, 3.0_wp, 2.0_wp, 3.0_wp, 0.0_wp], [2, 4]), member)
      frame%free(:, [1, 4]) = .false.
      choice%fidelity = fidelity_linear
      choice%modes = available_frame_modes(frame)
      call reduce_frame(frame, choice, every, shape, error)
      call check_no_error(error, 'portal')
      held = choice
      held%craig_bampton = .true.
      allocate (held%attachments(2, 3), held%interface(3))
      held%attachments = reshape([2, 1, 2, 2, 2, 3], [2, 3])
      held%interface = [attachment_type(2, 3.0_wp, 1), attachment_type(2, 3.0_wp, 2), attachment_type(2, 3.0_wp, 3)]
      held%modes = available_frame_modes(frame, held)
      call check(held%modes == choice%modes - 4, 'portal: two displacements at each knee have mass')
      deallocate (shape)
      call reduce_frame(frame, held, body, shape, error)
      call check_no_error(error, 'portal, all')
      call check(body%n == every%n, 'portal: as many coordinates')
      if (body%n == every%n) call check(maxval(abs(body%omega2/every%omega2 - 1.0_wp)) < 1.0e-9_wp, 'portal: same frequencies')
      held%modes = 6
      deallocate (shape)
      call reduce_frame(frame, held, body, shape, error)
      call check_no_error(error, 'portal, few')
      call check(body%n == 12, 'portal: six modes and six shapes')
      call check_basis(frame, shape, body%omega2, 'portal')
      call check(maxval(abs(sqrt(body%omega2(:4)/every%omega2(:4)) - 1.0_wp)) < 2.0e-3_wp, 'portal: the lowest frequencies')
      call static_residual(frame, shape, body%omega2, knee, whole, left, error)
      call check(all(abs(left) <= 1.0e-9_wp*whole), 'portal: flexibility of a knee')
      deallocate (shape)
      ! Corrections, within a member
      choice%modes = 3
      allocate (choice%corrections(2))
      choice%corrections = [attachment_type(2, 1.3_wp, 2), attachment_type(2, 1.3_wp, 3)]
      call reduce_frame(frame, choice, body, shape, error)
      call check_no_error(error, 'portal, corrections')
      call check_basis(frame, shape, body%omega2, 'portal with corrections')
      call static_residual(frame, shape, body%omega2, choice%corrections, whole(:2), left(:2), error)
      call check(all(abs(left(:2)) <= 1.0e-9_wp*whole(:2)), 'portal: corrections')
      ! A limit between two frequencies
      choice%modes = huge(1)
      choice%frequency_limit = 0.5_wp*(sqrt(every%omega2(11)) + sqrt(every%omega2(12)))
      deallocate (choice%corrections)
      call reduce_frame(frame, choice, body, shape, error)
      call check(body%n == 11, 'portal: modes below a limit')
      deallocate (held%attachments, held%interface, shape)
   end subroutine test_portal

end program test_functions
