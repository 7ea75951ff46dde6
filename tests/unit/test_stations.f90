!> Stations of beams: Euler's loads and the axial force of rotation in closed form, the flexibility that modes leave out, the error
!> by the lumped masses against frequencies that are known.
program test_stations
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_beam_beam_mesh, only: beam_type, displacement_field_type, new_support
   use limber_beam_reduced_body, only: reduced_type
   use limber_beam_beam_reduction, only: reduction_type, reduce_beam, fidelity_kg
   use limber_beam_monitored_sections, only: monitored_sections_type, patch_type, new_stations, hold_none, hold_some, &
      & hold_hinge, hold_clamp
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   real(wp), parameter :: pi = acos(-1.0_wp)

   call test_euler()
   call test_rotation()
   call test_left_out()
   call test_spread()
   call test_lumping()
   call finish()

contains

   !> A beam of unit length, mass and bending rigidity with joints or loads at both ends.
   subroutine make(support, elements, modes, hold, stations, omega2, uniform)
      character(*), intent(in) :: support
      integer, intent(in) :: elements, modes
      integer, intent(in) :: hold(2)
      type(monitored_sections_type), intent(out) :: stations
      real(wp), allocatable, intent(out) :: omega2(:)
      !> A third place, of a uniform load along the beam; without it there is none
      type(patch_type), intent(in), optional :: uniform
      type(beam_type) :: beam
      type(reduction_type) :: choice
      type(displacement_field_type) :: field
      type(reduced_type) :: body
      type(error_type), allocatable :: error
      beam%ea = 1.0e6_wp
      beam%ei = 1.0_wp
      beam%rho_a = 1.0_wp
      beam%length = 1.0_wp
      beam%elements = elements
      choice%support = new_support(support)
      choice%bending = modes
      choice%axial = 0
      choice%fidelity = fidelity_kg
      choice%geometric_elements = 2
      choice%static_axial = .true.
      call reduce_beam(beam, choice, body, field, error)
      call check_no_error(error, support)
      if (present(uniform)) then
         call new_stations(beam, choice, field, body, [0.0_wp, 1.0_wp, 0.5_wp], [hold, hold_none], &
            & .false., stations, error, [patch_type(), patch_type(), uniform])
      else
         call new_stations(beam, choice, field, body, [0.0_wp, 1.0_wp], hold, .false., stations, error)
      end if
      call check_no_error(error, support//': stations')
      allocate (omega2, source=body%omega2(:body%bending))
   end subroutine make

   subroutine test_euler()
      call judge('PINNED-ROLLER', [hold_some, hold_some], 1, pi**2, 1.0e-6_wp)
      call judge('CLAMPED-FREE', [hold_some, hold_none], 6, pi**2/4, 3.0e-3_wp)
      call judge('CLAMPED-CLAMPED', [hold_some, hold_some], 6, 4*pi**2, 3.0e-3_wp)
      ! Modes of a cantilever between two pins: the force acts along the line through them
      call judge('CLAMPED-FREE', [hold_some, hold_some], 10, pi**2, 2.0e-2_wp)
      call judge('FREE-FREE', [hold_some, hold_some], 10, pi**2, 2.0e-2_wp)
      ! Hinges and welds to the ground at both ends: the load is known, and by how much the functions take it too large
      call misfit('CLAMPED-FREE', [hold_hinge, hold_hinge], 2, pi**2)
      call misfit('FREE-FREE', [hold_hinge, hold_hinge], 2, pi**2)
      call misfit('PINNED-ROLLER', [hold_clamp, hold_hinge], 3, 20.190729_wp)
      call misfit('CLAMPED-FREE', [hold_clamp, hold_clamp], 3, 4*pi**2)
   end subroutine test_euler

   subroutine judge(support, hold, modes, load, tolerance)
      character(*), intent(in) :: support
      integer, intent(in) :: hold(2)
      integer, intent(in) :: modes
      real(wp), intent(in) :: load, tolerance
      type(monitored_sections_type) :: stations
      real(wp), allocatable :: omega2(:)
      call make(support, 64, modes, hold, stations, omega2)
      call check_close(stations%euler/load, 1.0_wp, tolerance, support//": Euler's load")
      call check(stations%euler > load*(1 - 1.0e-6_wp), support//': from above')
      call check_close(sum(stations%buckling)*stations%euler, 1.0_wp, 1.0e-9_wp, support//': of a uniform force')
   end subroutine judge

   !> A load known in closed form, and how much too large that of the functions is, from the same functions without that.
   subroutine misfit(support, hold, modes, load)
      character(*), intent(in) :: support
      integer, intent(in) :: hold(2), modes
      real(wp), intent(in) :: load
      type(monitored_sections_type) :: known, own
      real(wp), allocatable :: omega2(:)
      call make(support, 64, modes, hold, known, omega2)
      call make(support, 64, modes, spread(hold_some, 1, 2), own, omega2)
      call check_close(known%euler/load, 1.0_wp, 1.0e-5_wp, support//": Euler's load in closed form")
      if (all(hold == hold_hinge)) call check_close(known%misfit, own%euler/load - 1, 1.0e-9_wp, support//': misfit')
      call check(known%misfit > 0.01_wp, support//': functions of another support are told')
      call check_close(sum(known%buckling)*known%euler, 1.0_wp, 1.0e-9_wp, support//': of a uniform force')
   end subroutine misfit

   !> N = 1/2 omega^2 (1 - x^2), and that of forces at both ends.
   subroutine test_rotation()
      type(monitored_sections_type) :: stations
      real(wp), allocatable :: omega2(:), force(:)
      real(wp) :: amplitude(2 + 2 + 3 + 2)
      call make('CLAMPED-FREE', 7, 3, [hold_some, hold_none], stations, omega2)
      call check(size(stations%pull, 1) == size(amplitude), 'amplitudes')
      amplitude = 0.0_wp
      amplitude(2) = 9.0_wp
      allocate (force(stations%count))
      force(:) = matmul(amplitude, stations%pull)
      ! Half of each element is at its node: within h^2/8 of the uniform beam
      call check_close(maxval(abs(force - 4.5_wp*(1 - stations%x**2))), 0.0_wp, 9.0_wp/(8*49) + 1.0e-9_wp, 'rotation')
      amplitude = 0.0_wp
      amplitude(8:9) = [3.0_wp, 5.0_wp]
      force(:) = matmul(amplitude, stations%pull)
      call check_close(maxval(abs(force - 5.0_wp)), 0.0_wp, 1.0e-12_wp, 'forces at the ends')
   end subroutine test_rotation

   !> The tip of a cantilever yields by 1/3 to a force and by 1 to a couple, less what the modes carry: 4/omega^2, (2 beta
   !> tan)^2/omega^2.
   subroutine test_left_out()
      type(monitored_sections_type) :: stations
      real(wp), allocatable :: omega2(:)
      call make('CLAMPED-FREE', 128, 1, [hold_some, hold_none], stations, omega2)
      call check_close(stations%left_out(5, 5), 1/3.0_wp - 4/12.3623633683_wp, 2.0e-4_wp, 'force at the tip')
      call check_close(stations%left_out(6, 6), 1 - (2*1.3765055_wp)**2/12.3623633683_wp, 5.0e-4_wp, 'couple at the tip')
      call check_close(maxval(abs(stations%left_out(3:4, :))), 0.0_wp, 1.0e-12_wp, 'at the clamp')
      call check_close(maxval(abs(stations%left_out - transpose(stations%left_out))), 0.0_wp, 1.0e-12_wp, 'symmetric')
   end subroutine test_left_out

   !> A uniform load acts all along: N = p (1 - x) of it along the beam, and across q^2/20 less q^2 (0.782992/omega)^2 of the first
   !> mode. At its mean place it was N = p and ten times as much that one mode leaves out.
   subroutine test_spread()
      integer, parameter :: parts = 400
      type(monitored_sections_type) :: stations
      type(patch_type) :: uniform
      real(wp), allocatable :: omega2(:)
      integer :: i
      allocate (uniform%at(parts), uniform%part(parts))
      uniform%at(:) = [((i - 0.5_wp)/parts, i=1, parts)]
      uniform%part = 1.0_wp/parts
      call make('CLAMPED-FREE', 128, 1, [hold_some, hold_none], stations, omega2, uniform)
      i = size(stations%pull, 1)
      call check_close(maxval(abs(stations%pull(i, :) - (1 - stations%x))), 0.0_wp, 1.0_wp/parts, 'load along the beam')
      call check_close(stations%left_out(7, 7), 0.05_wp - 0.782992_wp**2/12.3623633683_wp, 1.0e-5_wp, 'load across the beam')
   end subroutine test_spread

   !> Frequencies of lumped masses in closed form between pins, of a cantilever from tables.
   subroutine test_lumping()
      type(monitored_sections_type) :: stations
      real(wp), allocatable :: omega2(:)
      call make('PINNED-ROLLER', 10, 4, [hold_some, hold_some], stations, omega2)
      call check_close(stations%lumping(2)/(1 - sqrt(omega2(2))/(4*pi**2)), 1.0_wp, 0.1_wp, 'second mode between pins')
      call make('CLAMPED-FREE', 16, 1, [hold_some, hold_none], stations, omega2)
      call check_close(sqrt(omega2(1)), 3.5097247_wp, 1.0e-6_wp, 'lumped cantilever')
      call check_close(stations%lumping(1)/(1 - 3.5097247_wp/3.5160153_wp), 1.0_wp, 0.05_wp, 'cantilever')
      call make('PINNED-ROLLER', 2, 1, [hold_some, hold_some], stations, omega2)
      ! Of the uniform load on one mode of two elements: 5/8 of the length in place of 1/2
      call check_close(stations%lost(1, 1)*sqrt(0.5_wp), 0.125_wp, 1.0e-9_wp, 'load lost')
   end subroutine test_lumping

end program test_stations
