!> The exact beam before the time loop: section angle and strain along the axis as fields of few functions, their bases, and what
!> integrals along the axis are made of. Undeformed axis 0 <= s <= L, section axes t and n = J t, and
!>
!>    theta(s) = sum eta_a psi_a(s),   sigma(s) = (1, 0) + sum eta_b chi_b(s),   x'(s) = R(theta) sigma
!>
!> so that the geometry is exact and the strain energy is quadratic. The floating frame is the section at the origin: psi_a and the
!> displacement are zero there. Integrals are sums over stations, eight of Gauss's formula in each panel. Floor: flex.
!> Source: doc/theory, section "The exact beam", eqs. (X1)-(X4).
module limber_flex_exact
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_base_finite, only: dsyev
   use limber_base_spline, only: spline_type, new_spline, spline_natural
   use limber_flex_beam, only: bending_curvature
   use limber_flex_mesh, only: beam_type, support_type, field_type, mesh_beam, bending_modes, count_bending_modes, slope_at
   implicit none
   private
   public :: exact_type, exact_choice_type, new_exact, reach_of, angles_at, sum_along, inside
   public :: panel_stations, gauss_place, gauss_weight

   !> Stations of a panel
   integer, parameter :: panel_stations = 8
   !> Gauss's formula in an interval from -1 to 1
   real(wp), parameter :: gauss_place(panel_stations) = [-0.96028985649753623_wp, -0.79666647741362674_wp, &
      & -0.52553240991632899_wp, -0.18343464249564980_wp, 0.18343464249564980_wp, 0.52553240991632899_wp, &
      & 0.79666647741362674_wp, 0.96028985649753623_wp]
   real(wp), parameter :: gauss_weight(panel_stations) = [0.10122853629037626_wp, 0.22238103445337447_wp, &
      & 0.31370664587788729_wp, 0.36268378337836198_wp, 0.36268378337836198_wp, 0.31370664587788729_wp, &
      & 0.22238103445337447_wp, 0.10122853629037626_wp]
   !> Stations for each function of the angle: with fewer the mass matrix loses rank
   real(wp), parameter :: stations_per_function = 1.6_wp
   !> Part of a function that the others must leave for it to count
   real(wp), parameter :: independent = 1.0e-5_wp
   !> Most functions of the angle that are polynomials, beside the modes
   integer, parameter :: most_polynomials = 4

   !> What the user, or the program for him, chooses of an exact beam
   type :: exact_choice_type
      !> Functions of the angle, of the strain along the axis, and of the shear
      integer :: angles = 6, strains = 1
      !> Support of the modes
      type(support_type) :: support
      !> Whether more than the support acts at the ends: polynomials beside the modes
      logical :: mixed = .true.
      !> Coordinate of the frame's origin [length]
      real(wp) :: origin = 0.0_wp
      !> Places within the beam where forces and couples act: the curvature has a kink, or a step, there
      real(wp), allocatable :: kinks(:), steps(:)
   end type exact_choice_type

   !> Constants of an exact beam. Its n coordinates eta are those of the angle, then those of the strain; at rest they are
   !> modes with unit mass
   type :: exact_type
      integer :: n = 0, angles = 0, strains = 0
      !> Stations, and points with mass: the stations, then concentrated masses
      integer :: stations = 0, points = 0
      !> Coordinates of the stations [length] and their weights [length] (stations); lengths of the panels
      real(wp), allocatable :: s(:), weight(:), panel(:)
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
      !> Rigidities, mass per length [mass/length], length
      real(wp) :: ea = 0.0_wp, ei = 0.0_wp, rho_a = 0.0_wp, total = 0.0_wp
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
      real(wp), allocatable :: candidates(:, :)
      exact%ea = beam%ea
      exact%ei = beam%ei
      exact%rho_a = beam%rho_a
      exact%total = beam%length
      call place_stations(beam, choice, exact)
      allocate (candidates(0, 0))
      call candidate_curvatures(beam, choice, exact, candidates, error)
      if (allocated(error)) return
      call choose_curvatures(choice, candidates, exact, error)
      if (allocated(error)) return
      call integrate_angles(choice%origin, exact)
      call strain_functions(choice%strains, exact)
      exact%n = exact%angles + exact%strains
      call place_masses(beam, exact)
      call find_modes(exact, omega2, error)
   end subroutine new_exact

   !> Panels between the ends and all places where something is not smooth, and their stations.
   pure subroutine place_stations(beam, choice, exact)
      type(beam_type), intent(in) :: beam
      type(exact_choice_type), intent(in) :: choice
      type(exact_type), intent(inout) :: exact
      real(wp), allocatable :: ends(:), inner(:)
      real(wp) :: from
      integer :: wanted, i, j, k, count, p
      allocate (inner, source=sorted([choice%kinks, choice%steps], beam%length))
      allocate (ends(size(inner) + 2))
      ends(:) = [0.0_wp, inner, beam%length]
      wanted = max(1, ceiling(stations_per_function*choice%angles/panel_stations))
      allocate (exact%panel(0))
      do i = 1, size(ends) - 1
         count = max(1, nint(wanted*(ends(i + 1) - ends(i))/beam%length))
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
   end subroutine place_stations

   !> Places within the beam in ascending order, each once.
   pure function sorted(places, length) result(list)
      real(wp), intent(in) :: places(:), length
      real(wp), allocatable :: list(:)
      real(wp) :: left(size(places)), least
      allocate (list(0))
      left = places
      do
         least = huge(1.0_wp)
         if (size(left) > 0) least = minval(left)
         if (.not. least < (1 - 1.0e-6_wp)*length) return
         if (least > 1.0e-6_wp*length) list = [list, least]
         where (left <= least + 1.0e-6_wp*length) left = huge(1.0_wp)
      end do
   end function sorted

   !> Curvatures at the stations, in the order of their use: of what acts within the beam, then of the modes of the finite elements,
   !> by turns with polynomials if the support is not all that holds the beam, then polynomials (stations, candidates).
   subroutine candidate_curvatures(beam, choice, exact, candidates, error)
      type(beam_type), intent(in) :: beam
      type(exact_choice_type), intent(in) :: choice
      type(exact_type), intent(in) :: exact
      real(wp), allocatable, intent(inout) :: candidates(:, :)
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: modes(:, :), kinks(:), steps(:)
      integer :: i, k, count, polynomials
      allocate (modes(0, 0))
      call mode_curvatures(beam, choice, exact, modes, error)
      if (allocated(error)) return
      allocate (kinks, source=sorted(choice%kinks, beam%length))
      allocate (steps, source=sorted(choice%steps, beam%length))
      count = size(kinks) + size(steps)
      polynomials = choice%angles + most_polynomials
      deallocate (candidates)
      allocate (candidates(exact%stations, count + size(modes, 2) + polynomials))
      do i = 1, size(steps)
         candidates(:, i) = merge(1.0_wp, 0.0_wp, exact%s > steps(i))
      end do
      do i = 1, size(kinks)
         candidates(:, size(steps) + i) = max(exact%s - kinks(i), 0.0_wp)/beam%length
      end do
      k = 0
      do i = 1, size(modes, 2)
         count = count + 1
         candidates(:, count) = modes(:, i)
         if (k < merge(most_polynomials, 0, choice%mixed)) call add_polynomial()
      end do
      do while (k < polynomials)
         call add_polynomial()
      end do

   contains

      !> The next polynomial.
      subroutine add_polynomial()
         k = k + 1
         count = count + 1
         candidates(:, count) = legendre(k - 1, 2*exact%s/beam%length - 1)
      end subroutine add_polynomial

   end subroutine candidate_curvatures

   !> Curvatures of the modes of the finite elements, smoothed: splines through the means of neighbouring elements.
   subroutine mode_curvatures(beam, choice, exact, modes, error)
      type(beam_type), intent(in) :: beam
      type(exact_choice_type), intent(in) :: choice
      type(exact_type), intent(in) :: exact
      !> (stations, modes)
      real(wp), allocatable, intent(inout) :: modes(:, :)
      type(error_type), allocatable, intent(out) :: error
      type(field_type) :: field
      type(spline_type) :: spline
      real(wp), allocatable :: left(:, :), right(:, :)
      real(wp) :: value(0:2), tiny_part
      integer :: count, i, j
      field = mesh_beam(beam)
      ! Modes that the mesh does not resolve are no better than polynomials
      count = min(choice%angles, count_bending_modes(beam, choice%support), beam%elements/3)
      call bending_modes(beam, choice%support, count, field, error)
      if (allocated(error)) return
      allocate (left(0:beam%elements, count), right(0:beam%elements, count))
      deallocate (modes)
      allocate (modes(exact%stations, count))
      do i = 0, beam%elements
         tiny_part = 1.0e-9_wp*beam%length/beam%elements
         left(i, :) = slope_at(field, max(field%s(i) - tiny_part, 0.0_wp), bending_curvature)
         right(i, :) = slope_at(field, min(field%s(i) + tiny_part, beam%length), bending_curvature)
      end do
      do j = 1, count
         spline = new_spline(field%s, 0.5_wp*(left(:, j) + right(:, j)), spline_natural)
         do i = 1, exact%stations
            value = spline%evaluate(exact%s(i))
            modes(i, j) = value(0)
         end do
      end do
   end subroutine mode_curvatures

   !> Legendre's polynomial of a degree.
   pure elemental real(wp) function legendre(degree, x) result(p)
      integer, intent(in) :: degree
      real(wp), intent(in) :: x
      real(wp) :: before, last
      integer :: k
      p = 1.0_wp
      last = 0.0_wp
      do k = 1, degree
         before = last
         last = p
         p = ((2*k - 1)*x*last - (k - 1)*before)/k
      end do
   end function legendre

   !> Takes the first candidates that are independent, as many as asked for and those of what acts within; orthonormal in the
   !> strain energy.
   subroutine choose_curvatures(choice, candidates, exact, error)
      type(exact_choice_type), intent(in) :: choice
      real(wp), intent(in) :: candidates(:, :)
      type(exact_type), intent(inout) :: exact
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: curvature(size(candidates, 1)), whole, left
      integer :: wanted, i, j, round
      wanted = choice%angles + size(sorted(choice%kinks, exact%total)) + size(sorted(choice%steps, exact%total))
      allocate (exact%kappa(wanted, exact%stations))
      do j = 1, size(candidates, 2)
         if (exact%angles == wanted) exit
         curvature = candidates(:, j)
         whole = sqrt(sum(exact%weight*exact%ei*curvature**2))
         if (.not. whole > 0.0_wp) cycle
         do round = 1, 2
            do i = 1, exact%angles
               curvature = curvature - sum(exact%weight*exact%ei*exact%kappa(i, :)*curvature)*exact%kappa(i, :)
            end do
         end do
         left = sqrt(sum(exact%weight*exact%ei*curvature**2))
         if (left < independent*whole) cycle
         exact%angles = exact%angles + 1
         exact%kappa(exact%angles, :) = curvature/left
      end do
      if (exact%angles < wanted) call raise(error, 'no more independent functions of the section angle')
   end subroutine choose_curvatures

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

   !> Polynomials of the strain along the axis, orthonormal in the strain energy.
   pure subroutine strain_functions(count, exact)
      integer, intent(in) :: count
      type(exact_type), intent(inout) :: exact
      integer :: i
      exact%strains = count
      allocate (exact%chi(2, count, exact%stations))
      exact%chi = 0.0_wp
      do i = 1, count
         exact%chi(1, i, :) = legendre(i - 1, 2*exact%s/exact%total - 1)*sqrt((2*i - 1)/(exact%ea*exact%total))
      end do
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
      exact%mass(:exact%stations) = exact%rho_a*exact%weight
      exact%inertia = 0.0_wp
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
      do k = 1, lumps
         associate (inertia => exact%inertia(exact%stations + k))
            exact%rotary = exact%rotary + inertia*psi(:, k)
            do i = 1, exact%angles
               exact%rotary_mass(:, i) = exact%rotary_mass(:, i) + inertia*psi(:, k)*psi(i, k)
            end do
         end associate
      end do
   end subroutine place_masses

   !> Makes the functions modes at rest with the frame held: unit mass, diagonal stiffness.
   subroutine find_modes(exact, omega2, error)
      type(exact_type), intent(inout) :: exact
      real(wp), allocatable, intent(inout) :: omega2(:)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: bend(exact%angles, exact%angles), stretch(exact%strains, exact%strains)
      real(wp) :: value(exact%n), work(64*exact%n + 64), moved(exact%n, exact%points)
      integer :: i, info, a, b
      a = exact%angles
      b = exact%strains
      do i = 1, a
         moved(i, :) = displacement(exact%psi(i, :))
      end do
      do i = 1, b
         moved(a + i, :) = displacement(exact%chi(1, i, :))
      end do
      do i = 1, a
         bend(:, i) = matmul(moved(:a, :), exact%mass*moved(i, :)) + exact%rotary_mass(:, i)
      end do
      do i = 1, b
         stretch(:, i) = matmul(moved(a + 1:, :), exact%mass*moved(a + i, :))
      end do
      deallocate (omega2)
      allocate (omega2(exact%n))
      call dsyev('V', 'L', a, bend, max(1, a), value(:a), work, size(work), info)
      if (info == 0) call dsyev('V', 'L', b, stretch, max(1, b), value(a + 1:), work, size(work), info)
      if (info /= 0 .or. any(.not. value > 0.0_wp)) then
         call raise(error, 'the functions of the beam have no modes; ask for fewer')
         return
      end if
      ! Ascending frequencies: the largest mass first
      bend = bend(:, a:1:-1)
      stretch = stretch(:, b:1:-1)
      value = [value(a:1:-1), value(exact%n:a + 1:-1)]
      omega2(:) = 1/value
      do i = 1, a
         bend(:, i) = bend(:, i)/sqrt(value(i))
      end do
      do i = 1, b
         stretch(:, i) = stretch(:, i)/sqrt(value(a + i))
      end do
      exact%psi = matmul(transpose(bend), exact%psi)
      exact%kappa = matmul(transpose(bend), exact%kappa)
      exact%chi(1, :, :) = matmul(transpose(stretch), exact%chi(1, :, :))
      exact%rotary = matmul(transpose(bend), exact%rotary)
      exact%rotary_mass = matmul(transpose(bend), matmul(exact%rotary_mass, bend))

   contains

      !> Displacement of the points by a field along the axis.
      pure function displacement(field) result(moved)
         real(wp), intent(in) :: field(:)
         real(wp) :: moved(exact%points)
         integer :: k
         moved(:exact%stations) = sum_along(exact, field) - sum(exact%base*field)
         do k = 1, exact%points - exact%stations
            moved(exact%stations + k) = sum(exact%reach(:, k)*field)
         end do
      end function displacement

   end subroutine find_modes

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

   !> Integrals of a field from the start to each station (stations).
   pure function sum_along(exact, field) result(integral)
      type(exact_type), intent(in) :: exact
      real(wp), intent(in) :: field(:)
      real(wp) :: integral(exact%stations), before
      integer :: p, i, first
      before = 0.0_wp
      do p = 1, size(exact%panel)
         first = panel_stations*(p - 1)
         associate (part => field(first + 1:first + panel_stations))
            do i = 1, panel_stations
               integral(first + i) = before + 0.5_wp*exact%panel(p)*dot_product(inside(gauss_place(i)), part)
            end do
            before = before + 0.5_wp*exact%panel(p)*dot_product(gauss_weight, part)
         end associate
      end do
   end function sum_along

end module limber_flex_exact
