!> Internal forces at sections: with few modes those of statics to round-off, whatever the supports; a forced vibration and a
!> rotating beam against their closed forms; a portal against equilibrium.
program test_recovery
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_beam_element_matrices, only: bending_slope
   use limber_beam_plane_frame, only: beam_frame, element_forces, frame_type, member_type, new_frame
   use limber_beam_frame_reduction, only: frame_choice_type, reduce_frame
   use limber_beam_frame_solver, only: new_solver, solve_static, solver_type
   use limber_beam_beam_mesh, only: beam_type, concentrate, displacement_field_type, new_support, slope_at
   use limber_beam_force_recovery, only: amplitudes, internal_forces, load_place_type, new_recovery, recovery_type, &
      & section_type
   use limber_beam_reduced_body, only: reduced_type
   use limber_beam_beam_reduction, only: fidelity_linear, point_shape, reduce_beam, reduction_type
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   real(wp), parameter :: ea = 2.0e4_wp, ei = 3.0_wp, rho_a = 0.8_wp, length = 1.3_wp
   !> Places of sections: at a node of ten elements, in an element, at both ends
   real(wp), parameter :: places(5) = [0.0_wp, 0.2_wp*length, 0.57_wp, 0.9_wp, length]
   !> Of coordinates that are held: none is
   real(wp), allocatable :: held(:)
   !> Of frames under tension: none is
   real(wp), allocatable :: none(:, :)

   call test_cantilever(1)
   call test_cantilever(3)
   call test_simply_supported()
   call test_held_ends()
   call test_free_beam()
   call test_vibration()
   call test_rotation()
   call test_masses()
   call test_portal()
   call finish()

contains

   !> A beam, its coordinates, and what gives its internal forces at sections on either side of places and with loads there.
   subroutine prepare(support, modes, elements, at, body, recovery, phi, beam)
      character(*), intent(in) :: support
      integer, intent(in) :: modes, elements
      !> Coordinates along the beam
      real(wp), intent(in) :: at(:)
      type(reduced_type), intent(out) :: body
      type(recovery_type), intent(out) :: recovery
      !> Displacements of the places (2, n, places)
      real(wp), allocatable, intent(out) :: phi(:, :, :)
      type(beam_type), intent(in), optional :: beam
      type(beam_type) :: own
      type(reduction_type) :: choice
      type(displacement_field_type) :: field
      type(frame_type) :: frame
      type(error_type), allocatable :: error
      real(wp), allocatable :: shape(:, :, :), one(:, :), psi(:)
      integer :: i
      own = beam_type(ea=ea, ei=ei, rho_a=rho_a, length=length, elements=elements)
      if (present(beam)) own = beam
      choice = reduction_type(support=new_support(support), bending=modes, axial=1, fidelity=fidelity_linear)
      call reduce_beam(own, choice, body, field, error)
      call check_no_error(error, support)
      call beam_frame(own, choice%support, 0.0_wp, field, frame, shape)
      call new_recovery(frame, shape, body, [(section_type(1, at(i), .false.), section_type(1, at(i), .true.), &
         & i=1, size(at))], [(load_place_type(1, at(i)), i=1, size(at))], recovery, error)
      call check_no_error(error, support//': recovery')
      allocate (phi(2, body%n, size(at)))
      do i = 1, size(at)
         call point_shape(field, at(i), one, psi)
         phi(:, :, i) = one
      end do
   end subroutine prepare

   !> At rest under accelerations of gravity and forces at the places: axial, shear and moment on both sides of each (3, 2, places).
   function at_rest(body, recovery, phi, gravity, force) result(inner)
      type(reduced_type), intent(in) :: body
      type(recovery_type), intent(in) :: recovery
      real(wp), intent(in) :: phi(:, :, :), gravity(2), force(:, :)
      real(wp) :: inner(3, 2, size(force, 2)), eta(body%n), zero(body%n), amplitude(4 + 3*body%n + 3*size(force, 2))
      integer :: i
      amplitude = 0.0_wp
      zero = 0.0_wp
      eta = matmul(gravity, body%c)
      do i = 1, size(force, 2)
         eta = eta + matmul(force(:, i), phi(:, :, i))
         amplitude(4 + 3*body%n + 3*i - 2:4 + 3*body%n + 3*i - 1) = force(:, i)
      end do
      eta = eta/body%omega2
      call amplitudes(-gravity, 0.0_wp, 0.0_wp, eta, zero, zero, amplitude)
      do i = 1, size(force, 2)
         inner(:, 1, i) = internal_forces(recovery, 2*i - 1, eta, amplitude, none, held)
         inner(:, 2, i) = internal_forces(recovery, 2*i, eta, amplitude, none, held)
      end do
   end function at_rest

   !> A cantilever under its weight and forces, clamped at the start: sums over what is beyond the section.
   subroutine test_cantilever(modes)
      integer, intent(in) :: modes
      type(reduced_type) :: body
      type(recovery_type) :: recovery
      real(wp), allocatable :: phi(:, :, :)
      real(wp) :: inner(3, 2, 5), force(2, 5), expected(3), rest
      real(wp), parameter :: g(2) = [2.0_wp, -9.0_wp]
      integer :: i, j, side
      call prepare('CLAMPED-FREE', modes, 10, places, body, recovery, phi)
      force = 0.0_wp
      force(:, 3) = [3.0_wp, -2.0_wp]
      force(:, 1) = [-7.0_wp, 6.0_wp]
      force(:, 5) = [-1.0_wp, 4.0_wp]
      inner = at_rest(body, recovery, phi, g, force)
      do i = 1, 5
         do side = 1, 2
            ! At the clamp and at the tip both sides are the one that is there
            rest = length - places(i)
            expected = [rho_a*rest*g(1), rho_a*rest*g(2), rho_a*rest**2/2*g(2)]
            do j = i, 5
               if (j == i .and. (side == 2 .and. i < 5 .or. i == 1)) cycle
               expected = expected + [force(1, j), force(2, j), force(2, j)*(places(j) - places(i))]
            end do
            call check(maxval(abs(inner(:, side, i) - expected)) <= 1.0e-9_wp, 'cantilever, '//as_text(modes)//' modes, at '// &
               & as_text(places(i), 3)//': '//as_text(maxval(abs(inner(:, side, i) - expected))))
         end do
      end do
   end subroutine test_cantilever

   !> Simply supported: q x (L - x)/2 and P a b/L; the shear jumps by the force.
   subroutine test_simply_supported()
      type(reduced_type) :: body
      type(recovery_type) :: recovery
      real(wp), allocatable :: phi(:, :, :)
      real(wp) :: inner(3, 2, 5), force(2, 5), moment, x
      real(wp), parameter :: q = 5.0_wp, p = 7.0_wp
      integer :: i, k
      call prepare('PINNED-ROLLER', 2, 10, places, body, recovery, phi)
      force = 0.0_wp
      force(2, 3) = p
      inner = at_rest(body, recovery, phi, [0.0_wp, q/rho_a], force)
      do i = 1, 5
         x = places(i)
         moment = -q*x*(length - x)/2 - p*min(x, places(3))*(length - max(x, places(3)))/length
         do k = 1, 2
            call check_close(inner(3, k, i), moment, 1.0e-9_wp, 'simply supported: moment at '//as_text(x, 3))
         end do
      end do
      call check_close(inner(2, 1, 3) - inner(2, 2, 3), p, 1.0e-9_wp, 'simply supported: shear jumps by the force')
      call check_close(inner(2, 1, 1), q*length/2 + p*(length - places(3))/length, 1.0e-9_wp, 'simply supported: first support')
      call check_close(inner(2, 1, 5), -q*length/2 - p*places(3)/length, 1.0e-9_wp, 'simply supported: second support')
   end subroutine test_simply_supported

   !> Both ends clamped, which statics alone does not decide: q L^2/12 at the ends, q L^2/24 in the middle, right to the second
   !> order of the elements, and a force in the middle, P L/8, exactly.
   subroutine test_held_ends()
      type(reduced_type) :: body
      type(recovery_type) :: recovery
      real(wp), allocatable :: phi(:, :, :)
      real(wp) :: inner(3, 2, 3), force(2, 3)
      real(wp), parameter :: q = 5.0_wp
      call prepare('CLAMPED-CLAMPED', 2, 20, [0.0_wp, 0.5_wp*length, length], body, recovery, phi)
      force = 0.0_wp
      inner = at_rest(body, recovery, phi, [0.0_wp, -q/rho_a], force)
      call check_close(inner(3, 1, 1)/(q*length**2/12), -1.0_wp, 3.0e-3_wp, 'clamped: moment at the start')
      call check_close(inner(3, 1, 3)/(q*length**2/12), -1.0_wp, 3.0e-3_wp, 'clamped: moment at the end')
      call check_close(inner(3, 1, 2)/(q*length**2/24), 1.0_wp, 6.0e-3_wp, 'clamped: moment in the middle')
      call check_close(inner(2, 1, 1), -q*length/2, 1.0e-9_wp, 'clamped: shear')
      force(2, 2) = -q
      inner = at_rest(body, recovery, phi, [0.0_wp, 0.0_wp], force)
      call check_close(inner(3, 1, 1), -q*length/8, 1.0e-9_wp, 'clamped: moment of a force in the middle, at the start')
      call check_close(inner(3, 1, 2), q*length/8, 1.0e-9_wp, 'clamped: and under it')
   end subroutine test_held_ends

   !> A free beam that is thrown by forces at its ends, F each: the inertia balances them, M = F x - m a x^2/2 with m a = 2 F/L.
   subroutine test_free_beam()
      type(reduced_type) :: body
      type(recovery_type) :: recovery
      real(wp), allocatable :: phi(:, :, :)
      real(wp) :: inner(3, 2, 5), force(2, 5), x
      real(wp), parameter :: f = 3.0_wp
      integer :: i
      call prepare('FREE-FREE', 2, 40, places, body, recovery, phi)
      force = 0.0_wp
      force(2, [1, 5]) = f
      ! The frame's origin accelerates by 2 F/m, as if gravity pulled back
      inner = at_rest(body, recovery, phi, [0.0_wp, -2*f/(rho_a*length)], force)
      do i = 1, 5
         x = places(i)
         call check_close(inner(3, 1, i), f*x - f*x**2/length, 1.0e-9_wp, 'free: moment at '//as_text(x, 3))
      end do
   end subroutine test_free_beam

   !> Forced vibration, F cos(W t) in the middle of a simply supported beam: F/(4 k) (tan(kL/2) + tanh(kL/2)) under the force,
   !> with k^4 = rho A W^2/EI. Three modes alone are off by much more.
   subroutine test_vibration()
      type(reduced_type) :: body
      type(recovery_type) :: recovery
      real(wp), allocatable :: phi(:, :, :)
      real(wp) :: eta(4), zero(4), amplitude(4 + 12 + 3), frequency, k, exact, inner(3), modal
      real(wp), parameter :: f = 2.0_wp, parts(3) = [0.4_wp, 1.3_wp, 5.0_wp]
      integer :: round
      call prepare('PINNED-ROLLER', 3, 40, [0.5_wp*length], body, recovery, phi)
      do round = 1, 3
         frequency = sqrt(body%omega2(1))*parts(round)
         eta = f*phi(2, :, 1)/(body%omega2 - frequency**2)
         zero = 0.0_wp
         amplitude = 0.0_wp
         amplitude(4 + 12 + 2) = f
         call amplitudes([0.0_wp, 0.0_wp], 0.0_wp, 0.0_wp, eta, zero, -frequency**2*eta, amplitude)
         inner = internal_forces(recovery, 1, eta, amplitude, none, held)
         modal = dot_product(recovery%modal(3, :, 1), eta)
         k = sqrt(frequency*sqrt(rho_a/ei))
         exact = -f/(4*k)*(tan(0.5_wp*k*length) + tanh(0.5_wp*k*length))
         print '(a,f8.3,a,f10.6,a,es10.2,a,es10.2)', 'vibration at ', frequency, ': moment ', exact, ', error ', &
            & inner(3)/exact - 1, ', of three modes ', modal/exact - 1
         call check_close(inner(3)/exact, 1.0_wp, merge(2.0e-3_wp, 1.0e-2_wp, round < 3), 'vibration: moment under the force')
         call check(abs(modal/exact - 1) > 5*abs(inner(3)/exact - 1), 'vibration: better than the modal sum')
         call check_close(inner(2), f/2, 0.3_wp*f, 'vibration: half of the force on either side')
      end do
   end subroutine test_vibration

   !> A beam that rotates about its clamped end: rho A omega^2 (L^2 - x^2)/2, and rho A alpha (2 L^3 - 3 L^2 x + x^3)/6 when it
   !> is accelerated.
   subroutine test_rotation()
      type(reduced_type) :: body
      type(recovery_type) :: recovery
      real(wp), allocatable :: phi(:, :, :)
      real(wp) :: eta(3), zero(3), amplitude(4 + 9 + 15), inner(3), x
      real(wp), parameter :: omega = 0.05_wp, alpha = 0.0007_wp
      integer :: i
      call prepare('CLAMPED-FREE', 2, 20, places, body, recovery, phi)
      eta = (omega**2*body%d - alpha*body%e)/(body%omega2 - omega**2)
      zero = 0.0_wp
      amplitude = 0.0_wp
      call amplitudes([0.0_wp, 0.0_wp], omega, alpha, eta, zero, zero, amplitude)
      do i = 1, 5
         x = places(i)
         inner = internal_forces(recovery, 2*i - 1, eta, amplitude, none, held)
         call check_close(inner(1), rho_a*omega**2*(length**2 - x**2)/2, 1.0e-3_wp*rho_a*omega**2*length**2, 'rotation: tension')
         call check_close(inner(3), -rho_a*alpha*(2*length**3 - 3*length**2*x + x**3)/6, 3.0e-3_wp*rho_a*alpha*length**3, &
            & 'rotation: moment')
      end do
   end subroutine test_rotation

   !> Concentrated masses: their weight jumps in the shear force.
   subroutine test_masses()
      type(beam_type) :: beam
      type(reduced_type) :: body
      type(recovery_type) :: recovery
      real(wp), allocatable :: phi(:, :, :)
      real(wp) :: inner(3, 2, 3), force(2, 3)
      real(wp), parameter :: g = 9.81_wp
      beam = beam_type(ea=ea, ei=ei, rho_a=rho_a, length=length, elements=10)
      call concentrate(beam, 0.57_wp, 0.6_wp, 0.1_wp)
      call prepare('CLAMPED-FREE', 2, 10, [0.0_wp, 0.57_wp, length], body, recovery, phi, beam)
      force = 0.0_wp
      inner = at_rest(body, recovery, phi, [0.0_wp, -g], force)
      call check_close(inner(2, 1, 1), -g*(rho_a*length + 0.6_wp), 1.0e-9_wp, 'mass: shear at the clamp')
      call check_close(inner(2, 1, 2) - inner(2, 2, 2), -0.6_wp*g, 1.0e-9_wp, 'mass: its weight')
      call check_close(inner(3, 1, 1), -g*(rho_a*length**2/2 + 0.6_wp*0.57_wp), 1.0e-9_wp, 'mass: moment at the clamp')
   end subroutine test_masses

   !> A portal at rest with one mode: the forces of a finite-element solution of the whole, at corners and within a member.
   subroutine test_portal()
      type(member_type) :: members(3)
      type(frame_type) :: frame
      type(reduced_type) :: body
      type(frame_choice_type) :: choice
      type(recovery_type) :: recovery
      type(solver_type) :: solver
      type(error_type), allocatable :: error
      type(section_type) :: sections(4)
      real(wp), allocatable :: shape(:, :, :), load(:, :), u(:, :), eta(:), amplitude(:), zero(:)
      real(wp) :: inner(3, 4), ends(4)
      real(wp), parameter :: f(2) = [3.0_wp, -2.0_wp], couple = 0.6_wp
      integer, parameter :: elements(4) = [1, 4, 5, 9]
      integer :: m, i, e
      do m = 1, 3
         members(m) = member_type(ends=[m, m + 1], ea=5.0e3_wp, ei=2.0_wp + m, rho_a=0.5_wp, divisions=4)
      end do
      frame = new_frame(reshape([0.0_wp, 0.0_wp, 0.1_wp, 1.0_wp, 1.2_wp, 1.3_wp, 1.4_wp, 0.0_wp], [2, 4]), members)
      frame%free(:, [1, 4]) = .false.
      choice%modes = 1
      choice%fidelity = fidelity_linear
      call reduce_frame(frame, choice, body, shape, error)
      call check_no_error(error, 'portal')
      sections = [section_type(1, 0.0_wp, .true.), section_type(1, frame%from(4) + frame%length(4), .false.), &
         & section_type(2, 0.0_wp, .true.), section_type(3, 0.4_wp*frame%length(9), .false.)]
      call new_recovery(frame, shape, body, sections, [load_place_type(2, 0.0_wp)], recovery, error)
      call check_no_error(error, 'portal: recovery')
      allocate (load(3, size(frame%place, 2)), u(3, size(frame%place, 2)), eta(body%n), zero(body%n), amplitude(4 + 3*body%n + 3))
      load = 0.0_wp
      load(:, 2) = [f, couple]
      eta = 0.0_wp
      zero = 0.0_wp
      do i = 1, body%n
         eta(i) = sum(shape(:, :, i)*load)/body%omega2(i)
      end do
      amplitude = 0.0_wp
      amplitude(size(amplitude) - 2:) = [f, couple]
      call amplitudes([0.0_wp, 0.0_wp], 0.0_wp, 0.0_wp, eta, zero, zero, amplitude)
      call new_solver(frame, solver, error)
      call check_no_error(error, 'portal: solver')
      call solve_static(frame, solver, load, u)
      do i = 1, 4
         e = elements(i)
         inner(:, i) = internal_forces(recovery, i, eta, amplitude, none, held)
         ends = element_forces(frame, e, u)
         call check_close(inner(1, i), ends(1), 1.0e-9_wp, 'portal: tension')
         call check_close(inner(2, i), ends(2), 1.0e-9_wp, 'portal: shear')
         if (i == 1 .or. i == 3) call check_close(inner(3, i), ends(3), 1.0e-9_wp, 'portal: moment at a start')
         if (i == 2) call check_close(inner(3, i), ends(4), 1.0e-9_wp, 'portal: moment at an end')
         if (i == 4) call check_close(inner(3, i), 0.6_wp*ends(3) + 0.4_wp*ends(4), 1.0e-9_wp, 'portal: moment between')
      end do
      ! Balance of the corner: the girder's forces at its start, less those of the column at its end, are the load
      associate (a => frame%axis(:, 4), b => frame%axis(:, 5))
         call check(norm2(inner(1, 2)*a + inner(2, 2)*[-a(2), a(1)] - inner(1, 3)*b - inner(2, 3)*[-b(2), b(1)] - f) < 1.0e-9_wp, &
            & 'portal: forces on the corner')
         call check_close(inner(3, 2) - inner(3, 3), couple, 1.0e-9_wp, 'portal: couple on the corner')
      end associate
   end subroutine test_portal

end program test_recovery
