!> Frames against closed forms and an exact theory of their own: frequencies against the dynamic stiffness of members whose
!> vibration is sines and hyperbolic functions, static deflections of an L and of a portal, rigid motions, a straight frame at an
!> angle against the beam that it is; and beams with concentrated masses.
program test_frame
   use exact_frames, only: exact_near
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_beam_elastic_forces, only: elastic_energy, elastic_force
   use limber_beam_plane_frame, only: frame_type, member_type, new_frame
   use limber_beam_frame_reduction, only: available_frame_modes, frame_choice_type, frame_point_shape, reduce_frame
   use limber_beam_frame_solver, only: connected_nodes, new_solver, rigid_motions, solve_static, solver_type
   use limber_beam_beam_mesh, only: beam_type, concentrate, displacement_field_type, new_support, nodal_masses
   use limber_beam_reduced_body, only: reduced_type
   use limber_beam_beam_reduction, only: fidelity_kg, fidelity_linear, point_shape, reduce_beam, reduction_type
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   !> Degrees of freedom of one node
   logical, parameter :: held(3) = .false.

   call test_portal_frequencies()
   call test_tip_mass()
   call test_beam_with_masses()
   call test_moved_nodes()
   call test_static_l()
   call test_portal_sway()
   call test_rigid_motions()
   call test_straight()
   call test_points()
   call test_attachments()
   call test_connection()
   call finish()

contains

   !> A portal: two columns of height 1 and 0.8 and a girder, clamped.
   function portal(divisions) result(frame)
      integer, intent(in) :: divisions
      type(frame_type) :: frame
      frame = new_frame(portal_corners(), portal_members(divisions))
      frame%free(:, 1) = held
      frame%free(:, 4) = held
   end function portal

   function portal_corners() result(corners)
      real(wp) :: corners(2, 4)
      corners = reshape([0.0_wp, 0.0_wp, 0.1_wp, 1.0_wp, 1.5_wp, 1.2_wp, 1.5_wp, 0.4_wp], [2, 4])
   end function portal_corners

   function portal_members(divisions) result(members)
      integer, intent(in) :: divisions
      type(member_type) :: members(3)
      members(1) = member_type(ends=[1, 2], ea=5.0e3_wp, ei=2.0_wp, rho_a=0.9_wp, divisions=divisions)
      members(2) = member_type(ends=[2, 3], ea=8.0e3_wp, ei=5.0_wp, rho_a=1.4_wp, divisions=divisions)
      members(3) = member_type(ends=[4, 3], ea=5.0e3_wp, ei=2.0_wp, rho_a=0.9_wp, divisions=divisions)
   end function portal_members

   !> Frequencies of the portal at two meshes, whose errors are of order two.
   subroutine test_portal_frequencies()
      type(frame_type) :: frame
      type(reduced_type) :: body
      type(frame_choice_type) :: choice
      type(error_type), allocatable :: error
      real(wp), allocatable :: shape(:, :, :)
      real(wp) :: omega(4, 2), exact
      integer :: round, k
      choice%modes = 4
      choice%fidelity = fidelity_linear
      do round = 1, 2
         frame = portal(16*round)
         call reduce_frame(frame, choice, body, shape, error)
         call check_no_error(error, 'portal')
         omega(:, round) = sqrt(body%omega2)
         deallocate (shape)
      end do
      do k = 1, 4
         exact = exact_near(portal_corners(), portal_members(1), 0*frame%mass(:, :4), frame%free(:, :4), omega(k, 2))
         print '(a,i0,a,f12.6,a,2es10.2)', 'portal, mode ', k, ': ', exact, ', errors ', omega(k, :)/exact - 1
         call check_close(omega(k, 2)/exact, 1.0_wp, 2.0e-4_wp, 'portal: frequency '//as_text(k))
         call check_close((4*omega(k, 2) - omega(k, 1))/(3*exact), 1.0_wp, 1.0e-5_wp, 'portal: extrapolated frequency '//as_text(k))
      end do
   end subroutine test_portal_frequencies

   !> The portal with a mass at one knee and a mass with a large moment of inertia at the other.
   subroutine test_tip_mass()
      type(frame_type) :: frame
      type(reduced_type) :: body
      type(frame_choice_type) :: choice
      type(error_type), allocatable :: error
      real(wp), allocatable :: shape(:, :, :)
      real(wp) :: mass(3, 4), exact
      integer :: k
      choice%modes = 5
      choice%fidelity = fidelity_linear
      mass = 0.0_wp
      mass(:, 2) = [0.5_wp, 0.5_wp, 0.0_wp]
      mass(:, 3) = [0.3_wp, 0.3_wp, 0.4_wp]
      frame = portal(16)
      frame%mass(:, :4) = frame%mass(:, :4) + mass
      call reduce_frame(frame, choice, body, shape, error)
      call check_no_error(error, 'portal with masses')
      call check(body%spinning, 'it has rotary inertia')
      do k = 1, 5
         exact = exact_near(portal_corners(), portal_members(1), mass, frame%free(:, :4), sqrt(body%omega2(k)))
         print '(a,i0,a,f12.6,a,es10.2)', 'portal with masses, mode ', k, ': ', exact, ', error ', sqrt(body%omega2(k))/exact - 1
         call check_close(sqrt(body%omega2(k))/exact, 1.0_wp, 1.0e-3_wp, 'portal with masses: frequency '//as_text(k))
      end do
   end subroutine test_tip_mass

   !> A cantilever with a disc within its span and one at its tip: bending and axial frequencies.
   subroutine test_beam_with_masses()
      type(beam_type) :: beam
      type(reduced_type) :: body
      type(displacement_field_type) :: field
      type(error_type), allocatable :: error
      type(reduction_type) :: choice
      type(member_type) :: members(2)
      real(wp) :: corners(2, 3), mass(3, 3), exact
      logical :: free(3, 3)
      integer :: k
      beam = beam_type(ea=2.0e4_wp, ei=3.0_wp, rho_a=0.8_wp, length=1.3_wp, elements=20)
      call concentrate(beam, 0.55_wp, 0.4_wp, 0.05_wp)
      call concentrate(beam, 1.3_wp, 0.2_wp, 0.03_wp)
      choice = reduction_type(support=new_support('CLAMPED-FREE'), bending=4, axial=2, fidelity=fidelity_linear)
      call reduce_beam(beam, choice, body, field, error)
      call check_no_error(error, 'beam with masses')
      corners = reshape([0.0_wp, 0.0_wp, 0.55_wp, 0.0_wp, 1.3_wp, 0.0_wp], [2, 3])
      members(1) = member_type(ends=[1, 2], ea=beam%ea, ei=beam%ei, rho_a=beam%rho_a)
      members(2) = member_type(ends=[2, 3], ea=beam%ea, ei=beam%ei, rho_a=beam%rho_a)
      mass = reshape([0.0_wp, 0.0_wp, 0.0_wp, 0.4_wp, 0.4_wp, 0.05_wp, 0.2_wp, 0.2_wp, 0.03_wp], [3, 3])
      free = .true.
      free(:, 1) = held
      do k = 1, 6
         exact = exact_near(corners, members, mass, free, sqrt(body%omega2(k)))
         print '(a,i0,a,f12.6,a,es10.2)', 'beam with masses, coordinate ', k, ': ', exact, ', error ', &
            & sqrt(body%omega2(k))/exact - 1
         call check_close(sqrt(body%omega2(k))/exact, 1.0_wp, 2.0e-3_wp, &
            & 'beam with masses: frequency '//as_text(k))
      end do
      call check_close(body%mass, 0.8_wp*1.3_wp + 0.6_wp, 1.0e-14_wp, 'beam with masses: mass')
      call check_close(body%i0, sum(nodal_masses(beam)*beam%place**2) + 0.08_wp, 1.0e-13_wp, 'beam with masses: second moment')
   end subroutine test_beam_with_masses

   !> Nodes move to the masses, or new ones are made; the mass of the beam stays.
   subroutine test_moved_nodes()
      type(beam_type) :: beam
      beam = beam_type(ea=1.0_wp, ei=1.0_wp, rho_a=2.0_wp, length=4.0_wp, elements=4)
      call concentrate(beam, 2.0_wp, 1.0_wp, 0.0_wp)
      call check(beam%elements == 4 .and. maxval(abs(beam%place - [0, 1, 2, 3, 4])) <= 0.0_wp, 'a mass on a node moves none')
      call concentrate(beam, 1.2_wp, 1.0_wp, 0.0_wp)
      call check(beam%elements == 4, 'the nearest node moves')
      call check_close(beam%place(1), 1.2_wp, 0.0_wp, 'to the mass')
      call concentrate(beam, 1.9_wp, 1.0_wp, 0.5_wp)
      call check(beam%elements == 5, 'a node that carries a mass stays')
      call check_close(beam%place(2), 1.9_wp, 0.0_wp, 'there is one more')
      call concentrate(beam, 0.1_wp, 1.0_wp, 0.0_wp)
      call concentrate(beam, 3.9_wp, 1.0_wp, 0.0_wp)
      call check(beam%elements == 7 .and. abs(beam%place(7) - 4.0_wp) <= 0.0_wp, 'the ends stay')
      call check(all(beam%place(1:) > beam%place(:6)), 'the order stays')
      call check_close(sum(nodal_masses(beam)), 13.0_wp, 1.0e-14_wp, 'all masses')
   end subroutine test_moved_nodes

   !> A cantilevered L of lengths a and b under a force P across its free leg's end: w = P b^3/(3 EI) + P b^2 a/EI along it,
   !> and the corner moves by P b a^2/(2 EI) across the first leg.
   subroutine test_static_l()
      type(member_type) :: members(2)
      type(frame_type) :: frame
      type(solver_type) :: solver
      type(error_type), allocatable :: error
      real(wp), allocatable :: load(:, :), u(:, :)
      real(wp), parameter :: a = 1.3_wp, b = 0.7_wp, ei = 2.0_wp, ea = 5.0e3_wp, p = 0.4_wp
      real(wp) :: c, s
      integer :: node
      members(1) = member_type(ends=[1, 2], ea=ea, ei=ei, rho_a=1.0_wp, divisions=2)
      members(2) = member_type(ends=[2, 3], ea=ea, ei=ei, rho_a=1.0_wp, divisions=3)
      ! Turned by an angle: the first leg along (c, s), the second along (-s, c)
      c = 0.6_wp
      s = 0.8_wp
      frame = new_frame(reshape([0.0_wp, 0.0_wp, a*c, a*s, a*c - b*s, a*s + b*c], [2, 3]), members)
      frame%free(:, 1) = held
      call check_close(sum(frame%length), a + b, 1.0e-14_wp, 'lengths')
      call check(all(frame%first == [1, 3, 6]) .and. size(frame%member) == 5, 'elements')
      node = frame%ends(2, 3)
      call new_solver(frame, solver, error)
      call check_no_error(error, 'L')
      allocate (load(3, size(frame%place, 2)), u(3, size(frame%place, 2)))
      load = 0.0_wp
      load(1:2, 3) = p*[c, s]
      call solve_static(frame, solver, load, u)
      call check_close(c*u(1, 3) + s*u(2, 3), p*b**3/(3*ei) + p*b**2*a/ei + p*a/ea, 1.0e-12_wp, 'L: along the force')
      call check_close(-s*u(1, 3) + c*u(2, 3), -p*b*a**2/(2*ei), 1.0e-12_wp, 'L: across it')
      call check_close(u(3, 3), -p*b**2/(2*ei) - p*b*a/ei, 1.0e-12_wp, 'L: rotation')
      call check_close(c*u(1, node) + s*u(2, node), p*((b/3)**2*(3*b - b/3)/6 + b/3*a*b)/ei + p*a/ea, 1.0e-12_wp, &
         & 'L: within the leg')
   end subroutine test_static_l

   !> Sway of a clamped portal of columns h and girder l under a force H at the top, without stretch:
   !> H h^3/(12 E I) (2 + 3k)/(1 + 6k), k = I_girder h/(I_column l).
   subroutine test_portal_sway()
      type(member_type) :: members(3)
      type(frame_type) :: frame
      type(solver_type) :: solver
      type(error_type), allocatable :: error
      real(wp), allocatable :: load(:, :), u(:, :)
      real(wp), parameter :: h = 1.2_wp, l = 2.0_wp, ei = 2.0_wp, girder = 3.0_wp
      real(wp) :: k
      integer :: m
      do m = 1, 3
         members(m) = member_type(ends=[m, m + 1], ea=1.0e9_wp, ei=merge(girder, ei, m == 2), rho_a=1.0_wp, divisions=2)
      end do
      frame = new_frame(reshape([0.0_wp, 0.0_wp, 0.0_wp, h, l, h, l, 0.0_wp], [2, 4]), members)
      frame%free(:, [1, 4]) = .false.
      call new_solver(frame, solver, error)
      call check_no_error(error, 'portal')
      allocate (load(3, size(frame%place, 2)), u(3, size(frame%place, 2)))
      load = 0.0_wp
      load(1, 2) = 1.0_wp
      call solve_static(frame, solver, load, u)
      k = girder*h/(ei*l)
      call check_close(u(1, 2)/(h**3/(12*ei)*(2 + 3*k)/(1 + 6*k)), 1.0_wp, 1.0e-6_wp, 'portal: sway')
   end subroutine test_portal_sway

   !> Rigid motions that supports leave, and modes that are free of them.
   subroutine test_rigid_motions()
      type(frame_type) :: frame
      type(reduced_type) :: body
      type(frame_choice_type) :: choice
      type(error_type), allocatable :: error
      real(wp), allocatable :: motion(:, :, :), shape(:, :, :)
      real(wp) :: exact
      integer :: k, free
      do free = 0, 3
         frame = portal(20)
         frame%free = .true.
         if (free < 3) frame%free(1:2, 1) = .false.
         if (free < 1) frame%free(3, 4) = .false.
         if (free == 2) frame%free(2, 1) = .true.
         call rigid_motions(frame, motion)
         call check(size(motion, 3) == free, 'rigid motions: '//as_text(size(motion, 3))//' of '//as_text(free))
         call check(available_frame_modes(frame) == 2*size(frame%place, 2) - free - count(.not. frame%free(1:2, :)), 'available')
         choice%modes = 3
         choice%accelerations = .true.
         choice%fidelity = fidelity_linear
         call reduce_frame(frame, choice, body, shape, error)
         call check_no_error(error, 'free frame')
         do k = 1, body%n
            call check(maxval([(abs(sum(frame%mass*motion(:, :, free)*shape(:, :, k))), free=1, size(motion, 3))]) < 1.0e-8_wp, &
               & 'coordinates without rigid motion')
         end do
         call check(minval(body%omega2) > 0.1_wp, 'no frequency is zero')
         if (free == 3) then
            do k = 1, 3
               exact = exact_near(portal_corners(), portal_members(1), 0*frame%mass(:, :4), frame%free(:, :4), sqrt(body%omega2(k)))
               call check_close(sqrt(body%omega2(k))/exact, 1.0_wp, 2.0e-3_wp, 'free portal: frequency '//as_text(k))
            end do
         end if
         deallocate (motion, shape)
      end do
   end subroutine test_rigid_motions

   !> A straight member at an angle is the beam: invariants, energy and forces at the same deflections.
   subroutine test_straight()
      type(beam_type) :: beam
      type(member_type) :: members(1)
      type(frame_type) :: frame
      type(reduced_type) :: straight, body
      type(displacement_field_type) :: field
      type(reduction_type) :: choice
      type(frame_choice_type) :: own
      type(error_type), allocatable :: error
      real(wp), allocatable :: shape(:, :, :), eta(:), mine(:), z(:), s(:), force(:), expected(:), z2(:), s2(:), whole(:)
      real(wp), parameter :: c = 0.6_wp, si = 0.8_wp
      real(wp) :: energy, other, sign
      integer :: fidelity, i, k, order(5)
      beam = beam_type(ea=2.0e3_wp, ei=3.0_wp, rho_a=0.8_wp, length=1.3_wp, elements=6)
      call concentrate(beam, 1.3_wp, 0.3_wp, 0.02_wp)
      members(1) = member_type(ends=[1, 2], ea=beam%ea, ei=beam%ei, rho_a=beam%rho_a, divisions=6)
      do fidelity = fidelity_linear, fidelity_kg
         choice = reduction_type(support=new_support('CLAMPED-FREE'), bending=3, axial=2, fidelity=fidelity, geometric_elements=6)
         call reduce_beam(beam, choice, straight, field, error)
         call check_no_error(error, 'beam')
         frame = new_frame(reshape([0.0_wp, 0.0_wp, 1.3_wp*c, 1.3_wp*si], [2, 2]), members)
         frame%free(:, 1) = held
         frame%mass(:, 2) = frame%mass(:, 2) + [0.3_wp, 0.3_wp, 0.02_wp]
         own%modes = 12
         own%fidelity = fidelity
         call reduce_frame(frame, own, body, shape, error)
         call check_no_error(error, 'frame')
         allocate (eta(5), mine(12), z(6), s(6), z2(78), s2(78), force(5), expected(5), whole(12))
         mine = 0.0_wp
         whole = 0.0_wp
         eta = [0.02_wp, -0.01_wp, 0.005_wp, 0.003_wp, -0.002_wp]
         do i = 1, 5
            order(i) = minloc(abs(body%omega2 - straight%omega2(i)), dim=1)
            call check_close(body%omega2(order(i))/straight%omega2(i), 1.0_wp, 1.0e-9_wp, 'straight frame: frequency')
            ! The sign of a shape, from its displacement along or across the beam at the tip
            if (i <= 3) sign = field%w(6, i)*(c*shape(2, 2, order(i)) - si*shape(1, 2, order(i)))
            if (i > 3) sign = field%u(6, i - 3)*(c*shape(1, 2, order(i)) + si*shape(2, 2, order(i)))
            sign = sign/abs(sign)
            mine(order(i)) = sign*eta(i)
            expected(i) = sign
         end do
         force = 0.0_wp
         call elastic_force(straight, eta, force, s)
         expected = expected*force
         call elastic_force(body, mine, whole, s2)
         call check(maxval(abs(whole(order) - expected)) <= 1.0e-8_wp*maxval(abs(expected)), 'straight frame: elastic force')
         call elastic_energy(straight, eta, other)
         call elastic_energy(body, mine, energy)
         call check_close(energy, other, 1.0e-9_wp*abs(other), 'straight frame: energy')
         call check_close(body%i0, straight%i0, 1.0e-12_wp, 'straight frame: second moment')
         do k = 1, 5
            call check_close(abs(body%e(order(k))), abs(straight%e(k)), 1.0e-9_wp, 'straight frame: e')
            call check_close(abs(body%d(order(k))), abs(straight%d(k)), 1.0e-9_wp, 'straight frame: d')
            call check_close(norm2(body%c(:, order(k))), norm2(straight%c(:, k)), 1.0e-9_wp, 'straight frame: C')
         end do
         deallocate (shape, eta, mine, z, s, z2, s2, force, expected, whole)
      end do
   end subroutine test_straight

   !> Shapes at points within members and elements of beams: cubic between the nodes, rotations their slope; a body that moves
   !> without strain moves its points as a rigid one.
   subroutine test_points()
      type(frame_type) :: frame
      type(beam_type) :: beam
      type(displacement_field_type) :: field
      real(wp), allocatable :: shape(:, :, :), phi(:, :), psi(:), left(:, :), right(:, :), none(:)
      real(wp) :: p(2)
      real(wp), parameter :: h = 1.0e-5_wp
      integer :: i
      frame = portal(3)
      allocate (shape(3, size(frame%place, 2), 2))
      do i = 1, size(frame%place, 2)
         shape(:, i, 1) = [0.3_wp - 0.7_wp*frame%place(2, i), -0.2_wp + 0.7_wp*frame%place(1, i), 0.7_wp]
         shape(:, i, 2) = sin([1.0_wp, 2.0_wp, 3.0_wp]*i)
      end do
      do i = 1, 3
         call frame_point_shape(frame, shape, i, 0.37_wp, phi, psi)
         p = frame%place(:, frame%ends(1, frame%first(i))) + 0.37_wp*frame%axis(:, frame%first(i))
         call check(norm2(phi(:, 1) - [0.3_wp - 0.7_wp*p(2), -0.2_wp + 0.7_wp*p(1)]) < 1.0e-14_wp, 'points: rigid displacement')
         call check_close(psi(1), 0.7_wp, 1.0e-14_wp, 'points: rigid rotation')
         call frame_point_shape(frame, shape, i, 0.37_wp - h, left, none)
         call frame_point_shape(frame, shape, i, 0.37_wp + h, right, none)
         associate (a => frame%axis(:, frame%first(i)))
            call check_close(psi(2), (a(1)*(right(2, 2) - left(2, 2)) - a(2)*(right(1, 2) - left(1, 2)))/(2*h), 1.0e-7_wp, &
               & 'points: the rotation is the slope')
         end associate
      end do
      beam = beam_type(ea=1.0_wp, ei=1.0_wp, rho_a=1.0_wp, length=2.0_wp, elements=3)
      allocate (field%s(0:3), field%w(0:3, 1), field%theta(0:3, 1), field%u(0:3, 1))
      field%s(:) = [0.0_wp, 0.5_wp, 1.3_wp, 2.0_wp]
      ! A cubic deflection is there exactly, between nodes too
      field%w(:, 1) = field%s**3 - 2*field%s
      field%theta(:, 1) = 3*field%s**2 - 2
      field%u(:, 1) = 0.4_wp*field%s
      call point_shape(field, 0.9_wp, phi, psi)
      call check(norm2(phi(:, 1) - [0.0_wp, 0.9_wp**3 - 1.8_wp]) < 1.0e-14_wp, 'points: cubic deflection')
      call check_close(psi(1), 3*0.81_wp - 2, 1.0e-14_wp, 'points: its slope')
      call check(norm2(phi(:, 2) - [0.36_wp, 0.0_wp]) < 1.0e-14_wp .and. abs(psi(2)) <= 0.0_wp, 'points: stretch')
   end subroutine test_points

   !> With the responses to unit loads among the coordinates a load there deflects the frame as all modes would.
   subroutine test_attachments()
      type(frame_type) :: frame
      type(solver_type) :: solver
      type(reduced_type) :: body
      type(frame_choice_type) :: choice
      type(error_type), allocatable :: error
      real(wp), allocatable :: shape(:, :, :), load(:, :), u(:, :), poor(:, :)
      integer :: k, round
      frame = portal(4)
      call new_solver(frame, solver, error)
      call check_no_error(error, 'portal')
      allocate (load(3, size(frame%place, 2)), u(3, size(frame%place, 2)), poor(3, size(frame%place, 2)))
      load = 0.0_wp
      load(:, 3) = [0.3_wp, -1.0_wp, 0.2_wp]
      call solve_static(frame, solver, load, u)
      choice%modes = 2
      choice%fidelity = fidelity_linear
      do round = 1, 2
         if (round == 2) choice%attachments = reshape([3, 1, 3, 2, 3, 3], [2, 3])
         call reduce_frame(frame, choice, body, shape, error)
         call check_no_error(error, 'attachments')
         poor = 0.0_wp
         do k = 1, body%n
            poor = poor + shape(:, :, k)*sum(shape(:, :, k)*load)/body%omega2(k)
         end do
         if (round == 1) call check(maxval(abs(poor - u)) > 0.05_wp*maxval(abs(u)), 'two modes are too few')
         if (round == 2) call check(maxval(abs(poor - u)) < 1.0e-9_wp*maxval(abs(u)), 'attachments carry the load')
         deallocate (shape)
      end do
      call check(body%n == 5, 'three more coordinates')
   end subroutine test_attachments

   !> A part that does not hang together with the first node is found.
   subroutine test_connection()
      type(frame_type) :: frame
      type(member_type) :: members(2)
      logical, allocatable :: connected(:)
      members(1) = member_type(ends=[1, 2], ea=1.0_wp, ei=1.0_wp, rho_a=1.0_wp, divisions=2)
      members(2) = member_type(ends=[3, 4], ea=1.0_wp, ei=1.0_wp, rho_a=1.0_wp, divisions=2)
      frame = new_frame(reshape([0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 1.0_wp, 1.0_wp], [2, 4]), members)
      allocate (connected, source=connected_nodes(frame))
      call check(all(connected .eqv. [.true., .true., .false., .false., .true., .false.]), 'connected nodes')
   end subroutine test_connection

end program test_frame
