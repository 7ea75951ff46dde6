!> Constants of an exact beam before the time loop. Section angle and strain along the axis as fields of few functions, their bases,
!> and what integrals along the axis are made of. Undeformed axis 0 <= s <= L, section axes t and n = J t, and
!>
!>    theta(s) = sum eta_a psi_a(s),   sigma(s) = (1, 0) + sum eta_b chi_b(s),   x'(s) = R(theta) sigma
!>
!> so that the geometry is exact and the strain energy is quadratic. The floating frame is the section at the origin: psi_a and the
!> displacement are zero there. Integrals are sums over stations, eight of Gauss's formula in each panel. Floor: beam.
!> Source: doc/theory, part 2, eqs. (2.31)-(2.33), (2.36).
module limber_beam_exact_beam
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_base_finite, only: dsyev
   use limber_beam_exact_functions, only: exact_choice_type, candidate_moments, count_of_places, axial_forces, &
      & layer_places, legendre, sorted
   use limber_beam_exact_profile, only: profile_type, uniform_profile, profile_at, of_ea, of_ei, of_ga, of_mass, of_rotary, &
      & profile_values
   use limber_beam_beam_mesh, only: beam_type
   implicit none
   private
   public :: exact_type, new_exact, reach_of, angles_at
   public :: undeformed_place, lean_at, sum_along, slope_along
   public :: panel_stations, gauss_place, gauss_weight, integrate_panel, gather_panel

   !> Stations of a panel, and of half of it
   integer, parameter :: panel_stations = 8, half_panel = panel_stations/2
   !> Gauss's formula in an interval from -1 to 1
   real(wp), parameter :: gauss_place(panel_stations) = [-0.96028985649753623_wp, -0.79666647741362674_wp, &
      & -0.52553240991632899_wp, -0.18343464249564980_wp, 0.18343464249564980_wp, 0.52553240991632899_wp, &
      & 0.79666647741362674_wp, 0.96028985649753623_wp]
   real(wp), parameter :: gauss_weight(panel_stations) = [0.10122853629037626_wp, 0.22238103445337447_wp, &
      & 0.31370664587788729_wp, 0.36268378337836198_wp, 0.36268378337836198_wp, 0.31370664587788729_wp, &
      & 0.22238103445337447_wp, 0.10122853629037626_wp]
   !> Stations for each function of the angle in a beam of one part: with fewer the mass matrix loses rank. And in parts, where each
   !> has its own share: with 1.6 there frequencies of the higher functions are up to 0.6 % too high
   real(wp), parameter :: stations_per_function = 1.6_wp, stations_in_parts = 2.0_wp
   !> Part of a function that the others must leave for it to count
   real(wp), parameter :: independent = 1.0e-5_wp
   !> Constants of an exact beam. Its n coordinates eta are those of the angle, then those of the strain; at rest they are
   !> modes with unit mass
   type :: exact_type
      integer :: n = 0, angles = 0, strains = 0
      !> How many of the strains, the last ones, are of shear
      integer :: shears = 0
      !> Stations, and points with mass: the stations, then concentrated masses
      integer :: stations = 0, points = 0
      !> Coordinates of the stations [length] and their weights [length] (stations); lengths of the panels
      real(wp), allocatable :: s(:), weight(:), panel(:)
      !> Integrals to the stations of the first half of a panel of unit half length: of half the sum and of half the difference of
      !> Lagrange's polynomials j and 9 - j to station i (i, j); the same with j first
      real(wp), dimension(half_panel, half_panel) :: even = 0.0_wp, odd = 0.0_wp, even_across = 0.0_wp, odd_across = 0.0_wp
      !> Functions of the angle and of the curvature (angles, stations), of the strain in section axes (2, strains, stations)
      real(wp), allocatable :: psi(:, :), kappa(:, :), chi(:, :, :)
      !> Mass and moment of inertia of the points (points); of concentrated masses their reach (stations, masses)
      real(wp), allocatable :: mass(:), inertia(:), reach(:, :)
      !> Coordinates of the concentrated masses (masses) [length]
      real(wp), allocatable :: lump_at(:)
      !> What the rotary inertia adds to the couplings with the rotation (angles), and to the mass matrix (angles, angles)
      real(wp), allocatable :: rotary(:), rotary_mass(:, :)
      logical :: spinning = .false.
      !> Reach of the frame's origin (stations), of use if that is not the start
      real(wp), allocatable :: base(:)
      logical :: shifted = .false.
      !> Sections at the stations: axial, bending and shear rigidity, mass and rotary inertia per length (profile_values, stations)
      real(wp), allocatable :: section(:, :)
      !> Angle of the undeformed axis at the stations, zero at the origin (stations) [rad]; its curvature [1/length], and the
      !> coordinate of the origin [length]
      real(wp), allocatable :: lean(:)
      real(wp) :: arc = 0.0_wp, origin = 0.0_wp
      !> Coordinates of the beam that no force holds, which heat, or tension, makes (n)
      real(wp), allocatable :: rest(:)
      !> Length
      real(wp) :: total = 0.0_wp
   end type exact_type

contains

   !> Makes the constants of a beam.
   subroutine new_exact(beam, choice, exact, omega2, error)
      type(beam_type), intent(in) :: beam
      type(exact_choice_type), intent(in) :: choice
      type(exact_type), intent(out) :: exact
      !> Squared circular frequencies of the coordinates at rest, with the frame held (n)
      real(wp), allocatable, intent(inout) :: omega2(:)
      !> No convergence of the modes, or fewer functions than asked for
      type(error_type), allocatable, intent(out) :: error
      type(profile_type) :: profile
      real(wp), allocatable :: candidates(:, :)
      integer :: i
      exact%total = beam%length
      profile = uniform_profile(beam%ea, beam%ei, beam%rho_a, beam%length)
      if (allocated(choice%profile%value)) profile = choice%profile
      call place_stations(beam, choice, profile, exact)
      allocate (exact%section(profile_values, exact%stations))
      do i = 1, exact%stations
         exact%section(:, i) = profile_at(profile, exact%s(i))
      end do
      exact%arc = choice%arc
      allocate (exact%lean(exact%stations))
      exact%origin = choice%origin
      exact%lean = exact%arc*(exact%s - exact%origin)
      allocate (candidates(0, 0))
      call candidate_moments(beam, choice, exact%s, candidates, error)
      if (allocated(error)) return
      call choose_curvatures(choice, candidates, exact, error)
      if (allocated(error)) return
      call integrate_angles(choice%origin, exact)
      call strain_functions(choice, exact)
      exact%n = exact%angles + exact%strains
      call place_masses(beam, exact)
      call find_modes(exact, omega2, error)
      if (allocated(error)) return
      allocate (exact%rest(exact%n))
      exact%rest = 0.0_wp
      associate (a => exact%angles, b => exact%n - exact%shears, weight => exact%weight)
         exact%rest(:a) = matmul(exact%kappa, weight*exact%section(of_ei, :)*choice%hot_curvature)
         exact%rest(a + 1:b) = matmul(exact%chi(1, :b - a, :), &
            & weight*(exact%section(of_ea, :)*choice%hot_strain - choice%pretension))
      end associate
      exact%rest = exact%rest/omega2
   end subroutine new_exact

   !> Panels between the ends and all places where something is not smooth, and their stations.
   pure subroutine place_stations(beam, choice, profile, exact)
      type(beam_type), intent(in) :: beam
      type(exact_choice_type), intent(in) :: choice
      type(profile_type), intent(in) :: profile
      type(exact_type), intent(inout) :: exact
      real(wp), allocatable :: ends(:), inner(:)
      !> A share that round-off has made larger than a number of panels
      real(wp), parameter :: round_off = 1.0e-6_wp
      real(wp) :: from, wanted
      integer :: i, j, k, count, p
      allocate (inner, source=sorted([choice%kinks, choice%steps, choice%corners, profile%at, layer_panels(choice, beam%length)], &
         & beam%length))
      allocate (ends(size(inner) + 2))
      ends(:) = [0.0_wp, inner, beam%length]
      wanted = merge(stations_per_function, stations_in_parts, size(inner) == 0)*max(choice%angles, choice%strains)/panel_stations
      allocate (exact%panel(0))
      do i = 1, size(ends) - 1
         count = max(1, ceiling(wanted*(ends(i + 1) - ends(i))/beam%length - round_off))
         exact%panel = [exact%panel, ((ends(i + 1) - ends(i))/count, j=1, count)]
      end do
      exact%stations = panel_stations*size(exact%panel)
      allocate (exact%s(exact%stations), exact%weight(exact%stations))
      from = 0.0_wp
      k = 0
      do p = 1, size(exact%panel)
         do j = 1, panel_stations
            k = k + 1
            exact%s(k) = from + 0.5_wp*exact%panel(p)*(1 + gauss_place(j))
            exact%weight(k) = 0.5_wp*exact%panel(p)*gauss_weight(j)
         end do
         from = from + exact%panel(p)
      end do
      call halve_integrals(exact)
   end subroutine place_stations

   !> Integrals to the stations of a panel, which are as much on either side of its middle: half of them is enough.
   pure subroutine halve_integrals(exact)
      type(exact_type), intent(inout) :: exact
      real(wp) :: within(panel_stations)
      integer :: i, j
      do i = 1, half_panel
         within = inside(gauss_place(i))
         do j = 1, half_panel
            exact%even(i, j) = 0.5_wp*(within(j) + within(panel_stations + 1 - j))
            exact%odd(i, j) = 0.5_wp*(within(j) - within(panel_stations + 1 - j))
         end do
      end do
      exact%even_across = transpose(exact%even)
      exact%odd_across = transpose(exact%odd)
   end subroutine halve_integrals

   !> Integrals of a field within a panel, from a value at its begin on.
   pure subroutine integrate_panel(even, odd, field, before, half, integral)
      !> Of the constants of the beam
      real(wp), intent(in) :: even(half_panel, half_panel), odd(half_panel, half_panel)
      real(wp), intent(in) :: field(panel_stations)
      !> Integral up to the panel, and half the length of the panel
      real(wp), intent(in) :: before, half
      real(wp), intent(inout) :: integral(panel_stations)
      real(wp), dimension(half_panel) :: plus, minus, inner, outer
      real(wp) :: whole
      integer :: k
      do k = 1, half_panel
         plus(k) = field(k) + field(panel_stations + 1 - k)
         minus(k) = field(k) - field(panel_stations + 1 - k)
      end do
      whole = (gauss_weight(1)*plus(1) + gauss_weight(2)*plus(2)) + (gauss_weight(3)*plus(3) + gauss_weight(4)*plus(4))
      inner = (even(:, 1)*plus(1) + even(:, 2)*plus(2)) + (even(:, 3)*plus(3) + even(:, 4)*plus(4))
      outer = (odd(:, 1)*minus(1) + odd(:, 2)*minus(2)) + (odd(:, 3)*minus(3) + odd(:, 4)*minus(4))
      do k = 1, half_panel
         integral(k) = before + half*(outer(k) + inner(k))
         integral(panel_stations + 1 - k) = before + half*(outer(k) + (whole - inner(k)))
      end do
   end subroutine integrate_panel

   !> The transpose: what forces at the stations of a panel are for a field at them, with the sum of those beyond.
   pure subroutine gather_panel(even_across, odd_across, force, beyond, half, pull)
      !> Of the constants of the beam
      real(wp), intent(in) :: even_across(half_panel, half_panel), odd_across(half_panel, half_panel)
      real(wp), intent(in) :: force(panel_stations)
      !> The sum, and half the length of the panel
      real(wp), intent(in) :: beyond, half
      real(wp), intent(inout) :: pull(panel_stations)
      real(wp), dimension(half_panel) :: plus, minus, inner, outer
      real(wp) :: behind
      integer :: k
      do k = 1, half_panel
         plus(k) = force(k) + force(panel_stations + 1 - k)
         minus(k) = force(k) - force(panel_stations + 1 - k)
      end do
      behind = beyond + ((force(5) + force(6)) + (force(7) + force(8)))
      inner = (even_across(:, 1)*minus(1) + even_across(:, 2)*minus(2)) &
         & + (even_across(:, 3)*minus(3) + even_across(:, 4)*minus(4))
      outer = (odd_across(:, 1)*plus(1) + odd_across(:, 2)*plus(2)) + (odd_across(:, 3)*plus(3) + odd_across(:, 4)*plus(4))
      do k = 1, half_panel
         pull(k) = half*((gauss_weight(k)*behind + inner(k)) + outer(k))
         pull(panel_stations + 1 - k) = half*((gauss_weight(k)*behind + inner(k)) - outer(k))
      end do
   end subroutine gather_panel

   !> Ends of panels to both sides of the places of layers; what lies beyond the beam is left out by `sorted`.
   pure function layer_panels(choice, length) result(ends)
      type(exact_choice_type), intent(in) :: choice
      real(wp), intent(in) :: length
      real(wp), allocatable :: ends(:), places(:)
      !> Ends of panels in units of a layer
      real(wp), parameter :: near(2) = [3.0_wp, 9.0_wp]
      integer :: i, k
      allocate (ends(0))
      allocate (places, source=layer_places(choice, length))
      do i = 1, size(places)
         do k = 1, size(choice%layers)
            ends = [ends, places(i) - near*choice%layers(k), places(i) + near*choice%layers(k)]
         end do
      end do
   end function layer_panels

   !> Curvatures of the first moments that are independent, as many as asked for and those of what acts within.
   subroutine choose_curvatures(choice, candidates, exact, error)
      type(exact_choice_type), intent(in) :: choice
      real(wp), intent(in) :: candidates(:, :)
      type(exact_type), intent(inout) :: exact
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: forces(:, :)
      integer :: wanted
      wanted = choice%angles + count_of_places(choice, exact%total)
      allocate (exact%kappa(wanted, exact%stations))
      allocate (forces(exact%stations, 1 + size(candidates, 2)))
      ! What heat makes of a beam that nothing holds
      forces(:, 1) = exact%section(of_ei, :)*choice%hot_curvature
      forces(:, 2:) = candidates
      call take_independent(exact%weight, exact%section(of_ei, :), forces, exact%kappa, exact%angles)
      if (exact%angles < wanted) call raise(error, 'no more independent functions of the section angle')
   end subroutine choose_curvatures

   !> Strains of the first forces that are independent, orthonormal in the strain energy, eq. (2.51).
   pure subroutine take_independent(weight, rigidity, forces, basis, taken)
      !> Of the stations (stations)
      real(wp), intent(in) :: weight(:), rigidity(:)
      !> (stations, candidates)
      real(wp), intent(in) :: forces(:, :)
      !> (wanted, stations), and how many were found
      real(wp), intent(inout) :: basis(:, :)
      integer, intent(out) :: taken
      real(wp) :: strain(size(forces, 1)), whole, left
      integer :: i, j, round
      taken = 0
      do j = 1, size(forces, 2)
         if (taken == size(basis, 1)) return
         strain = forces(:, j)/rigidity
         whole = sqrt(sum(weight*rigidity*strain**2))
         if (.not. whole > 0.0_wp) cycle
         do round = 1, 2
            do i = 1, taken
               strain = strain - sum(weight*rigidity*basis(i, :)*strain)*basis(i, :)
            end do
         end do
         left = sqrt(sum(weight*rigidity*strain**2))
         if (left < independent*whole) cycle
         taken = taken + 1
         basis(taken, :) = strain/left
      end do
   end subroutine take_independent

   !> The angle of each function, the integral of its curvature from the origin.
   pure subroutine integrate_angles(origin, exact)
      real(wp), intent(in) :: origin
      type(exact_type), intent(inout) :: exact
      integer :: i
      exact%base = reach_of(exact, origin)
      exact%shifted = any(abs(exact%base) > 0.0_wp)
      allocate (exact%psi(exact%angles, exact%stations))
      do i = 1, exact%angles
         exact%psi(i, :) = sum_along(exact, exact%kappa(i, :)) - sum(exact%base*exact%kappa(i, :))
      end do
   end subroutine integrate_angles

   !> Strains of axial forces, then of the shear forces that go with the bending moments, eq. (2.51).
   pure subroutine strain_functions(choice, exact)
      type(exact_choice_type), intent(in) :: choice
      type(exact_type), intent(inout) :: exact
      real(wp) :: slopes(exact%stations, exact%angles), moment(exact%stations), slide(exact%angles, exact%stations)
      real(wp), allocatable :: axial(:, :), stretch(:, :)
      integer :: i, taken
      allocate (axial, source=axial_forces(choice, exact%total, exact%s))
      allocate (stretch(size(axial, 2), exact%stations))
      call take_independent(exact%weight, exact%section(of_ea, :), axial, stretch, taken)
      if (choice%shear) then
         do i = 1, exact%angles
            moment = exact%section(of_ei, :)*exact%kappa(i, :)
            slopes(:, i) = slope_along(exact, moment)
            ! Of a constant moment there is nothing but round-off
            if (exact%total*norm2(slopes(:, i)) < independent*norm2(moment)) slopes(:, i) = 0.0_wp
         end do
         call take_independent(exact%weight, exact%section(of_ga, :), slopes, slide, exact%shears)
      end if
      exact%strains = taken + exact%shears
      allocate (exact%chi(2, exact%strains, exact%stations))
      exact%chi = 0.0_wp
      exact%chi(1, :taken, :) = stretch(:taken, :)
      exact%chi(2, taken + 1:, :) = slide(:exact%shears, :)
   end subroutine strain_functions

   !> Masses of the stations and of what is concentrated on the beam.
   pure subroutine place_masses(beam, exact)
      type(beam_type), intent(in) :: beam
      type(exact_type), intent(inout) :: exact
      integer :: lumps, i, k
      real(wp), allocatable :: psi(:, :)
      lumps = 0
      if (allocated(beam%mass)) lumps = count(beam%mass > 0.0_wp .or. beam%inertia > 0.0_wp)
      exact%points = exact%stations + lumps
      allocate (exact%mass(exact%points), exact%inertia(exact%points), exact%reach(exact%stations, lumps), psi(exact%angles, lumps))
      allocate (exact%lump_at(lumps))
      exact%mass(:exact%stations) = exact%section(of_mass, :)*exact%weight
      exact%inertia(:exact%stations) = exact%section(of_rotary, :)*exact%weight
      k = 0
      do i = 0, beam%elements
         if (lumps == 0) exit
         if (.not. (beam%mass(i) > 0.0_wp .or. beam%inertia(i) > 0.0_wp)) cycle
         k = k + 1
         exact%mass(exact%stations + k) = beam%mass(i)
         exact%lump_at(k) = beam%place(i)
         exact%inertia(exact%stations + k) = beam%inertia(i)
         exact%reach(:, k) = reach_of(exact, beam%place(i)) - exact%base
         psi(:, k) = angles_at(exact, beam%place(i))
      end do
      exact%spinning = any(exact%inertia > 0.0_wp)
      allocate (exact%rotary(exact%angles), exact%rotary_mass(exact%angles, exact%angles))
      exact%rotary = 0.0_wp
      exact%rotary_mass = 0.0_wp
      if (.not. exact%spinning) return
      do k = 1, exact%stations
         call add_rotary(exact, exact%inertia(k), exact%psi(:, k))
      end do
      do k = 1, lumps
         call add_rotary(exact, exact%inertia(exact%stations + k), psi(:, k))
      end do
   end subroutine place_masses

   !> What turns with a section, eq. (2.37).
   pure subroutine add_rotary(exact, inertia, turn)
      type(exact_type), intent(inout) :: exact
      !> Moment of inertia; angles of the functions there (angles)
      real(wp), intent(in) :: inertia, turn(:)
      integer :: j
      exact%rotary = exact%rotary + inertia*turn
      do j = 1, exact%angles
         exact%rotary_mass(:, j) = exact%rotary_mass(:, j) + inertia*turn*turn(j)
      end do
   end subroutine add_rotary

   !> Makes the functions modes at rest with the frame held: unit mass, diagonal stiffness.
   subroutine find_modes(exact, omega2, error)
      type(exact_type), intent(inout) :: exact
      real(wp), allocatable, intent(inout) :: omega2(:)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: bend(exact%angles, exact%angles), rotary_mass(exact%angles, exact%angles)
      real(wp) :: stretch(exact%strains - exact%shears, exact%strains - exact%shears), slide(exact%shears, exact%shears)
      real(wp) :: push(2, exact%n, exact%stations), t(2)
      integer :: a, b, k
      a = exact%angles
      b = exact%n - exact%shears
      do k = 1, exact%stations
         t = [cos(exact%lean(k)), sin(exact%lean(k))]
         push(1, :a, k) = -t(2)*exact%psi(:, k)
         push(2, :a, k) = t(1)*exact%psi(:, k)
         push(1, a + 1:, k) = t(1)*exact%chi(1, :, k) - t(2)*exact%chi(2, :, k)
         push(2, a + 1:, k) = t(2)*exact%chi(1, :, k) + t(1)*exact%chi(2, :, k)
      end do
      deallocate (omega2)
      allocate (omega2(exact%n))
      rotary_mass = exact%rotary_mass
      bend = rotary_mass
      stretch = 0.0_wp
      slide = 0.0_wp
      call decouple(exact, push(:, :a, :), bend, omega2(:a), error)
      if (.not. allocated(error)) call decouple(exact, push(:, a + 1:b, :), stretch, omega2(a + 1:b), error)
      if (.not. allocated(error)) call decouple(exact, push(:, b + 1:, :), slide, omega2(b + 1:), error)
      if (allocated(error)) return
      exact%psi = matmul(transpose(bend), exact%psi)
      exact%kappa = matmul(transpose(bend), exact%kappa)
      exact%rotary = matmul(transpose(bend), exact%rotary)
      exact%rotary_mass = matmul(transpose(bend), matmul(rotary_mass, bend))
      exact%chi(1, :b - a, :) = matmul(transpose(stretch), exact%chi(1, :b - a, :))
      exact%chi(2, b - a + 1:, :) = matmul(transpose(slide), exact%chi(2, b - a + 1:, :))
   end subroutine find_modes

   !> Modes among functions of one kind, which have the stiffness 1: a column of `mix` for each.
   subroutine decouple(exact, push, mix, omega2, error)
      type(exact_type), intent(in) :: exact
      !> Changes of the undeformed axis g for unit coordinates (2, count, stations)
      real(wp), intent(in) :: push(:, :, :)
      !> The mass beside that of the points at first (count, count)
      real(wp), intent(inout) :: mix(:, :)
      !> Ascending (count)
      real(wp), intent(out) :: omega2(:)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: moved(2, exact%points, size(mix, 1)), value(size(mix, 1)), work(64*size(mix, 1) + 64)
      integer :: count, i, j, k, info
      count = size(mix, 1)
      do i = 1, count
         do j = 1, 2
            moved(j, :exact%stations, i) = sum_along(exact, push(j, i, :)) - sum(exact%base*push(j, i, :))
            do k = 1, exact%points - exact%stations
               moved(j, exact%stations + k, i) = sum(exact%reach(:, k)*push(j, i, :))
            end do
         end do
      end do
      do i = 1, count
         do j = 1, count
            mix(j, i) = mix(j, i) + sum(exact%mass*(moved(1, :, i)*moved(1, :, j) + moved(2, :, i)*moved(2, :, j)))
         end do
      end do
      call dsyev('V', 'L', count, mix, max(1, count), value, work, size(work), info)
      if (info /= 0 .or. any(.not. value > 0.0_wp)) then
         call raise(error, 'the functions of the beam have no modes; ask for fewer')
         return
      end if
      ! Ascending frequencies: the largest mass first
      mix = mix(:, count:1:-1)
      omega2 = 1/value(count:1:-1)
      do i = 1, count
         mix(:, i) = mix(:, i)*sqrt(omega2(i))
      end do
   end subroutine decouple

   !> Integrals of Lagrange's polynomials of a panel from its start to a place (-1..1), for half its length.
   pure function inside(x) result(row)
      real(wp), intent(in) :: x
      real(wp) :: row(panel_stations), integral
      integer :: k
      row = gauss_weight*0.5_wp*(x + 1)
      do k = 1, panel_stations - 1
         integral = legendre(k + 1, x) - legendre(k - 1, x)
         row = row + gauss_weight*0.5_wp*legendre(k, gauss_place)*integral
      end do
   end function inside

   !> Derivative of a field along the axis, panel by panel (stations) [1/length].
   pure function slope_along(exact, field) result(slope)
      type(exact_type), intent(in) :: exact
      real(wp), intent(in) :: field(:)
      real(wp) :: slope(exact%stations), part(panel_stations), rate(0:panel_stations - 1, panel_stations)
      integer :: p, k, first
      rate(0, :) = 0.0_wp
      rate(1, :) = 1.0_wp
      do k = 2, panel_stations - 1
         rate(k, :) = rate(k - 2, :) + (2*k - 1)*legendre(k - 1, gauss_place)
      end do
      do p = 1, size(exact%panel)
         first = panel_stations*(p - 1)
         part = 0.0_wp
         do k = 1, panel_stations - 1
            part = part + rate(k, :)*(2*k + 1)/exact%panel(p) &
               & *sum(gauss_weight*legendre(k, gauss_place)*field(first + 1:first + panel_stations))
         end do
         slope(first + 1:first + panel_stations) = part
      end do
   end function slope_along

   !> What the stations give to the integral from the start to a place (stations) [length].
   pure function reach_of(exact, place) result(reach)
      type(exact_type), intent(in) :: exact
      real(wp), intent(in) :: place
      real(wp) :: reach(exact%stations), from
      integer :: p, first
      reach = 0.0_wp
      from = 0.0_wp
      do p = 1, size(exact%panel)
         first = panel_stations*(p - 1)
         if (place >= from + exact%panel(p)) then
            reach(first + 1:first + panel_stations) = exact%weight(first + 1:first + panel_stations)
         else if (place > from) then
            reach(first + 1:first + panel_stations) = 0.5_wp*exact%panel(p)*inside(2*(place - from)/exact%panel(p) - 1)
         end if
         from = from + exact%panel(p)
      end do
   end function reach_of

   !> Functions of the angle at a place (angles).
   pure function angles_at(exact, place) result(psi)
      type(exact_type), intent(in) :: exact
      real(wp), intent(in) :: place
      real(wp) :: psi(exact%angles), reach(exact%stations)
      reach = reach_of(exact, place) - exact%base
      psi = matmul(exact%kappa, reach)
   end function angles_at

   !> Angle of the undeformed axis at a place along it [rad].
   pure real(wp) function lean_at(exact, place)
      type(exact_type), intent(in) :: exact
      real(wp), intent(in) :: place
      lean_at = exact%arc*(place - exact%origin)
   end function lean_at

   !> Place of a coordinate along the undeformed beam, in the axes of its frame (2) [length].
   pure function undeformed_place(exact, x) result(place)
      type(exact_type), intent(in) :: exact
      real(wp), intent(in) :: x
      real(wp) :: place(2), reach(exact%stations)
      reach = reach_of(exact, x) - exact%base
      place = [sum(reach*cos(exact%lean)), sum(reach*sin(exact%lean))]
   end function undeformed_place

   !> Integrals of a field from the start to each station (stations).
   pure function sum_along(exact, field) result(integral)
      type(exact_type), intent(in) :: exact
      real(wp), intent(in) :: field(:)
      real(wp) :: integral(exact%stations), part(panel_stations), before
      integer :: p, first
      before = 0.0_wp
      do p = 1, size(exact%panel)
         first = panel_stations*(p - 1)
         part = field(first + 1:first + panel_stations)
         call integrate_panel(exact%even, exact%odd, part, before, 0.5_wp*exact%panel(p), integral(first + 1:))
         before = before + 0.5_wp*exact%panel(p)*dot_product(gauss_weight, part)
      end do
   end function sum_along

end module limber_beam_exact_beam
