!> What a rigid beam would do if it were elastic: deflections, frequencies and Euler's loads of textbooks.
program test_quasistatic
   use limber_base_kinds, only: wp
   use limber_beam_quasistatic_deflection, only: quasistatic_type, new_quasistatic, find_deflection
   use testing, only: check, check_close, finish
   implicit none
   real(wp), parameter :: ei = 3.0_wp, rho_a = 2.0_wp, l = 1.5_wp, pi = acos(-1.0_wp), fine = 2.0e-3_wp
   real(wp), parameter :: none(3, 0) = 0.0_wp

   call check_supports()
   call check_cantilever()
   call check_flight()
   call check_axial()
   call finish()

contains

   !> Between hinges under its weight q: 5 q L^4/(384 E I); the hinges carry a half each.
   subroutine check_supports()
      type(quasistatic_type) :: beam
      real(wp) :: force(3, 2), deflection, seen(3), axial, q
      q = rho_a*9.81_wp
      beam = new_quasistatic(ei, rho_a, l, 0.0_wp, [0.0_wp, l], [.true., .true.], .false.)
      force = 0.0_wp
      force(2, :) = q*l/2
      call find_deflection(beam, 0.0_wp, 9.81_wp, 0.0_wp, 0.0_wp, force, deflection, seen, axial)
      call check_close(deflection, 5*q*l**4/(384*ei), fine*deflection, 'weight between hinges')
      call check_close(seen(2), -deflection, 1.0e-12_wp, 'it sags')
      call check_close(beam%frequency, pi**2*sqrt(ei/rho_a)/l**2, 1.0e-12_wp, 'frequency between hinges')
      call check_close(beam%euler, pi**2*ei/l**2, 1.0e-12_wp, 'Euler load between hinges')
   end subroutine check_supports

   !> Clamped at its start: force and couple at the tip, F L^3/(3 E I) and C L^2/(2 E I); turned with alpha about the clamp, 11
   !> rho A alpha L^5/(120 E I). What the clamp carries is not needed.
   subroutine check_cantilever()
      type(quasistatic_type) :: beam
      real(wp) :: force(3, 2), deflection, seen(3), axial
      beam = new_quasistatic(ei, rho_a, l, 0.0_wp, [0.0_wp, l], [.true., .false.], .true.)
      force = 0.0_wp
      force(2, 2) = 0.7_wp
      call find_deflection(beam, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, force, deflection, seen, axial)
      call check_close(seen(3), 0.7_wp*l**3/(3*ei), fine*deflection, 'force at the tip')
      force(:, 2) = [0.0_wp, 0.0_wp, 0.4_wp]
      call find_deflection(beam, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, force, deflection, seen, axial)
      call check_close(seen(3), 0.4_wp*l**2/(2*ei), fine*deflection, 'couple at the tip')
      force = 0.0_wp
      call find_deflection(beam, 0.0_wp, 0.0_wp, 0.0_wp, 2.0_wp, force, deflection, seen, axial)
      call check_close(seen(3), -11*rho_a*2.0_wp*l**5/(120*ei), fine*deflection, 'angular acceleration')
      call check_close(beam%frequency*l**2/sqrt(ei/rho_a), 3.51602_wp, 1.0e-4_wp, 'frequency of a cantilever')
      call check_close(beam%euler, pi**2*ei/(4*l**2), 1.0e-12_wp, 'Euler load of a cantilever')
   end subroutine check_cantilever

   !> Pushed across in its middle, where its frame begins, and free: two cantilevers of half the length under q = F/L,
   !> q (L/2)^4/(8 E I) from the tangent in the middle.
   subroutine check_flight()
      type(quasistatic_type) :: beam
      real(wp) :: force(3, 1), deflection, seen(3), axial, hang
      beam = new_quasistatic(ei, rho_a, l, l/2, [l/2], [.false.], .false.)
      force(:, 1) = [0.0_wp, 0.5_wp, 0.0_wp]
      call find_deflection(beam, 0.0_wp, 0.5_wp/(rho_a*l), 0.0_wp, 0.0_wp, force, deflection, seen, axial)
      hang = 0.5_wp/l*(l/2)**4/(8*ei)
      call check_close(seen(2), hang, fine*hang, 'pushed in the middle')
      call check_close(deflection, hang, fine*hang, 'from the line through the ends')
      ! The same force by a driver, which has no place
      beam = new_quasistatic(ei, rho_a, l, l/2, none(1, :), [logical ::], .false.)
      call find_deflection(beam, 0.0_wp, 0.5_wp/(rho_a*l), 0.0_wp, 0.0_wp, none, deflection, seen, axial)
      call check_close(deflection, hang, fine*hang, 'what is missing of the balance acts at the origin')
   end subroutine check_flight

   !> Turned about its start: rho A omega^2 (L^2 - x^2)/2, in the mean rho A omega^2 L^2/3; compressed at the tip.
   subroutine check_axial()
      type(quasistatic_type) :: beam
      real(wp) :: force(3, 2), deflection, seen(3), axial
      beam = new_quasistatic(ei, rho_a, l, 0.0_wp, [0.0_wp, l], [.true., .false.], .true.)
      force = 0.0_wp
      force(1, 2) = -1.0_wp
      call find_deflection(beam, 0.0_wp, 0.0_wp, 4.0_wp, 0.0_wp, force, deflection, seen, axial)
      call check_close(axial, rho_a*16*l**2/3 - 1.0_wp, fine*rho_a*16*l**2/3, 'axial force')
      call check(deflection < 1.0e-12_wp, 'without deflection')
   end subroutine check_axial

end program test_quasistatic
