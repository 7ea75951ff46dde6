!> Sections of a straight beam for its monitors. Stations along it where deflection, slope and axial force are known from the
!> coordinates and the loads, and what they are compared with: Euler's load, what the chosen functions leave out at rest, and what
!> the lumped masses make of the frequencies. Made once, before the first step. Floor: beam. Source: doc/theory, eqs. (7.8)-(7.11),
!> (7.15)-(7.17), (7.25), (7.26).
module limber_beam_monitored_sections
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_finite, only: dsyev
   use limber_beam_element_matrices, only: bending_shape, bending_slope
   use limber_beam_plane_frame, only: frame_type, beam_frame
   use limber_beam_frame_solver, only: solver_type, new_solver, solve_static
   use limber_beam_geometric_stiffness, only: mean_slopes, joined_strains, strain_moments, element_ends
   use limber_beam_beam_mesh, only: beam_type, displacement_field_type, nodal_masses, deflection_at, slope_at, element_length
   use limber_beam_reduced_body, only: reduced_type
   use limber_beam_beam_reduction, only: reduction_type
   implicit none
   private
   public :: monitored_sections_type, patch_type, new_stations

   !> What joints do at a place of a beam: nothing, hold it, hold it and leave its section free to turn, weld it to the ground
   integer, parameter, public :: hold_none = 0, hold_some = 1, hold_hinge = 2, hold_clamp = 3

   !> A load along a beam that acts as one force
   type :: patch_type
      !> Coordinates along the beam [length] and parts of the force there, whose sum is one; not allocated of a force at a place
      real(wp), allocatable :: at(:), part(:)
   end type patch_type

   !> The constants of one beam
   type :: monitored_sections_type
      !> Number of bending and of axial coordinates, of stations, of places where joints and loads act, of k_G elements
      integer :: bending = 0, axial = 0, count = 0, places = 0, elements = 0
      !> Coordinate along the beam [length], weight of the integral along it [length], and k_G element of each station
      real(wp), allocatable :: x(:), weight(:)
      integer, allocatable :: element(:)
      !> Place of each station in its k_G element, from -1 to 1; used if the tension of the model varies there
      real(wp), allocatable :: xi(:)
      logical :: linear = .false.
      !> Deflection of each bending coordinate at the stations and at both ends (bending, count + 2), slope (bending, count)
      real(wp), allocatable :: deflection(:, :), slope(:, :)
      !> Coordinates along the beam of the places [length]
      real(wp), allocatable :: place(:)
      !> Of loads along the beam, whose mean places they are (places)
      type(patch_type), allocatable :: patch(:)
      !> Axial force at each station for unit amplitudes (2 + axial + bending + places, count), eq. (7.9)
      real(wp), allocatable :: pull(:, :)
      !> Tension that the model itself has at each station for unit axial coordinates (axial, count), and of the model full the
      !> matrices E A B_g / 2 (bending, bending, elements); otherwise (0,0,0)
      real(wp), allocatable :: strain(:, :)
      !> Euler's load of the chosen functions, as the joints hold the beam, and the weights of the axial force of the stations in
      !> its ratio to that load (count), eq. (7.11)
      real(wp) :: euler = 0.0_wp
      real(wp), allocatable :: buckling(:)
      !> By how much the chosen functions take that load too large, relative; zero if nothing is known of it
      real(wp) :: misfit = 0.0_wp
      !> Flexibility across the beam that the chosen functions leave out, for unit amplitudes (2 + 2 places, 2 + 2 places), eq.
      !> (7.25)
      real(wp), allocatable :: left_out(:, :)
      !> Relative error of each bending frequency by the lumped masses (bending), and what they lose of the force that a uniform
      !> acceleration, one about the origin of the frame, and those of the coordinates put on each (bending, 2 + bending),
      !> eqs. (7.26), (7.27)
      real(wp), allocatable :: lumping(:), lost(:, :)
      !> Elongation of the whole beam for unit axial coordinates (axial)
      real(wp), allocatable :: stretch(:)
      !> E A / 2 length of a beam whose ends cannot approach each other while its model lets them, otherwise zero
      real(wp) :: membrane = 0.0_wp
   end type monitored_sections_type

   !> Largest misfit that is told: functions that leave no bending at all have any
   real(wp), parameter :: most_misfit = 10.0_wp

   !> Least number of stations
   integer, parameter :: least = 16

contains

   !> Makes the stations of a beam.
   subroutine new_stations(beam, choice, field, body, place, hold, held, stations, error, patch)
      type(beam_type), intent(in) :: beam
      type(reduction_type), intent(in) :: choice
      type(displacement_field_type), intent(in) :: field
      type(reduced_type), intent(in) :: body
      !> Coordinates along the beam where joints and loads act [length], and what joints do there (places)
      real(wp), intent(in) :: place(:)
      integer, intent(in) :: hold(:)
      !> Whether joints hold two of its places at a distance
      logical, intent(in) :: held
      type(monitored_sections_type), intent(out) :: stations
      type(error_type), allocatable, intent(out) :: error
      !> Loads along the beam among these places; without them there are none
      type(patch_type), intent(in), optional :: patch(:)
      stations%bending = body%bending
      stations%axial = body%n - body%bending
      stations%places = size(place)
      stations%elements = choice%geometric_elements
      stations%linear = choice%linear
      allocate (stations%place, source=place)
      allocate (stations%patch(size(place)))
      if (present(patch)) stations%patch = patch
      allocate (stations%stretch(stations%axial))
      stations%stretch = field%u(beam%elements, :) - field%u(0, :)
      if (held .or. (choice%support%u_start .and. choice%support%u_end)) &
         & stations%membrane = 0.5_wp*beam%ea/beam%length
      call divide(beam, stations)
      call shape_stations(field, beam%length, stations)
      call share_tension(beam, field, body, stations)
      call collect_pull(beam, choice%origin, field, stations)
      call find_euler(beam, field, body, hold, stations)
      call find_left_out(beam, choice, field, body, stations, error)
      call estimate_lumping(beam, field, body, stations)
      call weigh_loads(beam, choice%origin, field, stations)
   end subroutine new_stations

   !> Places and weights: three Gauss points in each of equal pieces of the k_G elements.
   pure subroutine divide(beam, stations)
      type(beam_type), intent(in) :: beam
      type(monitored_sections_type), intent(inout) :: stations
      real(wp), parameter :: gauss(3) = [-sqrt(0.6_wp), 0.0_wp, sqrt(0.6_wp)], heavy(3) = [5.0_wp, 8.0_wp, 5.0_wp]/18
      integer :: pieces, g, i, k, s
      real(wp) :: l
      pieces = max(1, (least + 3*stations%elements - 1)/(3*stations%elements))
      stations%count = 3*pieces*stations%elements
      allocate (stations%x(stations%count), stations%weight(stations%count), stations%element(stations%count))
      allocate (stations%xi(stations%count))
      l = beam%length/(pieces*stations%elements)
      s = 0
      do g = 1, stations%elements
         do i = 1, pieces
            do k = 1, 3
               s = s + 1
               stations%x(s) = ((g - 1)*pieces + i - 0.5_wp + 0.5_wp*gauss(k))*l
               stations%weight(s) = heavy(k)*l
               stations%element(s) = g
               stations%xi(s) = (2*i - 1 + gauss(k))/pieces - 1
            end do
         end do
      end do
   end subroutine divide

   !> Deflections and slopes.
   pure subroutine shape_stations(field, length, stations)
      type(displacement_field_type), intent(in) :: field
      real(wp), intent(in) :: length
      type(monitored_sections_type), intent(inout) :: stations
      integer :: s
      associate (n => stations%count)
         allocate (stations%deflection(stations%bending, n + 2), stations%slope(stations%bending, n))
         do s = 1, n
            stations%deflection(:, s) = deflection_at(field, stations%x(s))
            stations%slope(:, s) = slope_at(field, stations%x(s), bending_slope)
         end do
         stations%deflection(:, n + 1) = deflection_at(field, 0.0_wp)
         stations%deflection(:, n + 2) = deflection_at(field, length)
      end associate
   end subroutine shape_stations

   !> The tension of the model: none in a linear one.
   subroutine share_tension(beam, field, body, stations)
      type(beam_type), intent(in) :: beam
      type(displacement_field_type), intent(in) :: field
      type(reduced_type), intent(in) :: body
      type(monitored_sections_type), intent(inout) :: stations
      real(wp) :: mean(stations%elements, stations%axial), tilt(stations%elements, stations%axial)
      integer :: s, pieces
      allocate (stations%strain(stations%axial, stations%count))
      stations%strain = 0.0_wp
      if (.not. body%geometric) return
      pieces = size(field%strain, 1)/stations%elements
      mean = joined_strains(field%strain, pieces)
      tilt = 0.0_wp
      if (stations%linear) tilt = strain_moments(field%strain, pieces)
      do s = 1, stations%count
         stations%strain(:, s) = beam%ea*(mean(stations%element(s), :) + tilt(stations%element(s), :)*stations%xi(s))
      end do
   end subroutine share_tension

   !> Axial force by the balance of what lies beyond a station: masses, spread over their halves of the elements, and loads.
   subroutine collect_pull(beam, origin, field, stations)
      type(beam_type), intent(in) :: beam
      real(wp), intent(in) :: origin
      type(displacement_field_type), intent(in) :: field
      type(monitored_sections_type), intent(inout) :: stations
      real(wp) :: mass(0:beam%elements), part, beyond
      integer :: s, k, e, p
      mass = nodal_masses(beam)
      allocate (stations%pull(2 + stations%axial + stations%bending + stations%places, stations%count))
      stations%pull = 0.0_wp
      do s = 1, stations%count
         e = min(beam%elements, count(field%s(1:) <= stations%x(s)) + 1)
         beyond = field%s(e) - stations%x(s)
         part = 0.5_wp*element_length(beam, e)
         do k = e, beam%elements
            call add(k, mass(k))
         end do
         ! The halves of the element that holds the station
         if (beyond > part) then
            call add(e - 1, beam%rho_a*(beyond - part))
         else
            call add(e, -beam%rho_a*(part - beyond))
         end if
         do p = 1, stations%places
            associate (pull => stations%pull(2 + stations%axial + stations%bending + p, s), patch => stations%patch(p))
               if (allocated(patch%at)) then
                  pull = sum(patch%part, mask=patch%at > stations%x(s))
               else if (stations%place(p) > stations%x(s)) then
                  pull = 1.0_wp
               end if
            end associate
         end do
      end do

   contains

      subroutine add(node, lump)
         integer, intent(in) :: node
         real(wp), intent(in) :: lump
         associate (pull => stations%pull(:, s))
            pull(1) = pull(1) + lump
            pull(2) = pull(2) + lump*(field%s(node) - origin)
            pull(3:2 + stations%axial) = pull(3:2 + stations%axial) + lump*field%u(node, :)
            pull(3 + stations%axial:2 + stations%axial + stations%bending) = &
               & pull(3 + stations%axial:2 + stations%axial + stations%bending) + lump*field%w(node, :)
         end associate
      end subroutine add

   end subroutine collect_pull

   !> Euler's load: the least uniform compression under which the bending coordinates, as the joints hold them, are not stable.
   !> Between joints at two places the force acts along the line through them; a weld to the ground keeps its section along that
   !> line, and alone it sets the direction of the force; otherwise that is the axis of the frame, eqs. (7.11), (7.12).
   subroutine find_euler(beam, field, body, hold, stations)
      type(beam_type), intent(in) :: beam
      type(displacement_field_type), intent(in) :: field
      type(reduced_type), intent(in) :: body
      integer, intent(in) :: hold(:)
      type(monitored_sections_type), intent(inout) :: stations
      real(wp) :: ratio(stations%bending, stations%bending), value(stations%bending), work(max(1, 8*stations%bending))
      real(wp) :: turned(stations%bending, stations%count), chord(stations%bending), from, to, truth
      integer :: i, j, info
      allocate (stations%buckling(stations%count))
      stations%buckling = 0.0_wp
      stations%euler = huge(1.0_wp)
      if (stations%bending == 0) return
      chord = 0.0_wp
      from = minval(stations%place, mask=hold > hold_none)
      to = maxval(stations%place, mask=hold > hold_none)
      if (any(hold > hold_none) .and. to > from) then
         do i = 1, stations%count
            if (stations%x(i) > from .and. stations%x(i) < to) chord = chord + stations%weight(i)*stations%slope(:, i)
         end do
         chord = chord/(to - from)
      else if (any(hold == hold_clamp)) then
         chord = slope_at(field, from, bending_slope)
      end if
      do i = 1, stations%bending
         turned(i, :) = (stations%slope(i, :) - chord(i))/sqrt(body%omega2(i))
      end do
      if (to > from) call clamp(field, chord, body%omega2(:stations%bending), pack(stations%place, hold == hold_clamp), turned)
      do j = 1, stations%bending
         do i = 1, stations%bending
            ratio(i, j) = sum(stations%weight*turned(i, :)*turned(j, :))
         end do
      end do
      call dsyev('V', 'L', stations%bending, ratio, stations%bending, value, work, size(work), info)
      if (info /= 0 .or. .not. value(stations%bending) > 0.0_wp) return
      stations%euler = 1/value(stations%bending)
      do i = 1, stations%count
         stations%buckling(i) = stations%weight(i)*dot_product(ratio(:, stations%bending), turned(:, i))**2
      end do
      truth = true_euler(beam, pack(hold, hold > hold_none), from, to)
      if (.not. truth > 0.0_wp .or. stations%euler <= truth) return
      stations%misfit = min(stations%euler/truth - 1, most_misfit)
      stations%buckling = stations%buckling*(stations%euler/truth)
      stations%euler = truth
   end subroutine find_euler

   !> Takes out of the slopes what turns sections that are welded to the ground.
   subroutine clamp(field, chord, omega2, place, turned)
      type(displacement_field_type), intent(in) :: field
      !> Mean slopes between the joints, squared frequencies (bending); coordinates of the welds
      real(wp), intent(in) :: chord(:), omega2(:), place(:)
      !> Slopes of coordinates of unit stiffness (bending, stations)
      real(wp), intent(inout) :: turned(:, :)
      real(wp) :: row(size(omega2), size(place)), slope(size(chord))
      integer :: i, k
      do k = 1, size(place)
         slope = slope_at(field, place(k), bending_slope)
         row(:, k) = (slope - chord)/sqrt(omega2)
         do i = 1, k - 1
            row(:, k) = row(:, k) - dot_product(row(:, i), row(:, k))*row(:, i)
         end do
         row(:, k) = row(:, k)/max(norm2(row(:, k)), tiny(1.0_wp))
         do i = 1, size(turned, 2)
            turned(:, i) = turned(:, i) - dot_product(row(:, k), turned(:, i))*row(:, k)
         end do
      end do
   end subroutine clamp

   !> Euler's load in closed form: of a beam clamped at one place alone, and of one with hinges or welds to the ground at its ends
   !> alone, eq. (7.12); zero for others.
   pure real(wp) function true_euler(beam, hold, from, to) result(load)
      type(beam_type), intent(in) :: beam
      !> What joints do at the places that they hold; coordinates of the first and the last of these
      integer, intent(in) :: hold(:)
      real(wp), intent(in) :: from, to
      !> Beams held at both ends, with none, one and two of them clamped, in units of E I pi^2/L^2
      real(wp), parameter :: pi = acos(-1.0_wp), of_clamps(0:2) = [1.0_wp, 2.04575_wp, 4.0_wp]
      load = 0.0_wp
      if (size(hold) == 1) then
         if (hold(1) == hold_clamp) load = pi**2*beam%ei/(2*max(from, beam%length - from))**2
      else if (size(hold) == 2 .and. all(hold >= hold_hinge)) then
         if (to - from > (1 - 1.0e-9_wp)*beam%length) load = of_clamps(count(hold == hold_clamp))*pi**2*beam%ei/beam%length**2
      end if
   end function true_euler

   !> What is left of the flexibility when that of the chosen functions is taken out.
   subroutine find_left_out(beam, choice, field, body, stations, error)
      type(beam_type), intent(in) :: beam
      type(reduction_type), intent(in) :: choice
      type(displacement_field_type), intent(in) :: field
      type(reduced_type), intent(in) :: body
      type(monitored_sections_type), intent(inout) :: stations
      type(error_type), allocatable, intent(out) :: error
      type(frame_type) :: frame
      type(solver_type) :: solver
      real(wp), allocatable :: shape(:, :, :), load(:, :, :), u(:, :)
      integer :: i, j, k, n
      n = 2 + 2*stations%places
      allocate (stations%left_out(n, n))
      stations%left_out = 0.0_wp
      call beam_frame(beam, choice%support, choice%origin, field, frame, shape)
      call new_solver(frame, solver, error)
      if (allocated(error)) return
      allocate (load(3, size(frame%place, 2), n), u(3, size(frame%place, 2)))
      load = 0.0_wp
      load(2, :, 1) = frame%mass(2, :)
      load(2, :, 2) = frame%mass(2, :)*frame%place(1, :)
      load(3, :, 2) = frame%mass(3, :)
      do i = 1, stations%places
         associate (patch => stations%patch(i))
            if (allocated(patch%at)) then
               do k = 1, size(patch%at)
                  call put_load(frame, patch%at(k), patch%part(k), load(:, :, 1 + 2*i), load(:, :, 2 + 2*i))
               end do
            else
               call put_load(frame, stations%place(i), 1.0_wp, load(:, :, 1 + 2*i), load(:, :, 2 + 2*i))
            end if
         end associate
      end do
      where (spread(.not. frame%free, 3, n)) load = 0.0_wp
      do j = 1, n
         call solve_static(frame, solver, load(:, :, j), u)
         do i = 1, stations%bending
            u = u - shape(:, :, i)*(sum(shape(:, :, i)*load(:, :, j))/body%omega2(i))
         end do
         do i = 1, n
            stations%left_out(i, j) = sum(load(:, :, i)*u)
         end do
      end do
   end subroutine find_left_out

   !> A part of a unit force across and of a unit couple at a place of the beam on the nodes of its element.
   pure subroutine put_load(frame, place, part, force, couple)
      type(frame_type), intent(in) :: frame
      real(wp), intent(in) :: place, part
      !> (3, nodes)
      real(wp), intent(inout) :: force(:, :), couple(:, :)
      real(wp) :: own(4), x
      integer :: e
      e = min(size(frame%from), max(1, count(frame%from <= place)))
      x = min(place - frame%from(e), frame%length(e))
      own = part*bending_shape(x, frame%length(e))
      force(2:3, frame%ends(1, e)) = force(2:3, frame%ends(1, e)) + own(1:2)
      force(2:3, frame%ends(2, e)) = force(2:3, frame%ends(2, e)) + own(3:4)
      own = part*bending_slope(x, frame%length(e))
      couple(2:3, frame%ends(1, e)) = couple(2:3, frame%ends(1, e)) + own(1:2)
      couple(2:3, frame%ends(2, e)) = couple(2:3, frame%ends(2, e)) + own(3:4)
   end subroutine put_load

   !> Error of the frequencies by the masses in the nodes: of free ends, and within the beam.
   pure subroutine estimate_lumping(beam, field, body, stations)
      type(beam_type), intent(in) :: beam
      type(displacement_field_type), intent(in) :: field
      type(reduced_type), intent(in) :: body
      type(monitored_sections_type), intent(inout) :: stations
      real(wp) :: h, b
      integer :: j, e, n
      allocate (stations%lumping(stations%bending))
      n = beam%elements
      h = 0.0_wp
      do e = 1, beam%elements
         h = max(h, element_length(beam, e))
      end do
      do j = 1, stations%bending
         b = h*sqrt(sqrt(body%omega2(j)*beam%rho_a/beam%ei))
         stations%lumping(j) = beam%rho_a*h**2/12*abs(field%w(n, j)*field%theta(n, j) - field%w(0, j)*field%theta(0, j)) &
            & + b**4/1440
      end do
   end subroutine estimate_lumping

   !> What the masses in the nodes take from the loads of accelerations: their sum, less the integral along the beam.
   subroutine weigh_loads(beam, origin, field, stations)
      type(beam_type), intent(in) :: beam
      real(wp), intent(in) :: origin
      type(displacement_field_type), intent(in) :: field
      type(monitored_sections_type), intent(inout) :: stations
      real(wp), parameter :: gauss(4) = [-0.861136311594053_wp, -0.339981043584856_wp, 0.339981043584856_wp, 0.861136311594053_wp]
      real(wp), parameter :: heavy(4) = [0.173927422568727_wp, 0.326072577431273_wp, 0.326072577431273_wp, 0.173927422568727_wp]
      real(wp) :: l, x, part
      integer :: e, k
      allocate (stations%lost(stations%bending, 2 + stations%bending))
      stations%lost = 0.0_wp
      do e = 1, beam%elements
         l = element_length(beam, e)
         do k = e - 1, e
            part = -0.5_wp*beam%rho_a*l
            call add(field%w(k, :), field%s(k))
         end do
         do k = 1, 4
            x = field%s(e - 1) + 0.5_wp*(1 + gauss(k))*l
            part = heavy(k)*beam%rho_a*l
            call add(deflection_at(field, x), x)
         end do
      end do

   contains

      subroutine add(w, at)
         real(wp), intent(in) :: w(:), at
         integer :: j
         stations%lost(:, 1) = stations%lost(:, 1) + part*w
         stations%lost(:, 2) = stations%lost(:, 2) + part*w*(at - origin)
         do j = 1, stations%bending
            stations%lost(:, 2 + j) = stations%lost(:, 2 + j) + part*w*w(j)
         end do
      end subroutine add

   end subroutine weigh_loads

end module limber_beam_monitored_sections
