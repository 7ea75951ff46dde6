!> Basis of an exact beam from the bending moments of its modes and loads. Bending moments along the axis, so that the curvatures
!> are right where the section changes. Floor: beam. Source: doc/theory, part 2, eqs. (2.33), (2.51).
module limber_beam_exact_functions
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_spline, only: spline_type, new_spline, spline_natural
   use limber_beam_element_matrices, only: bending_curvature
   use limber_beam_exact_profile, only: profile_type
   use limber_beam_beam_mesh, only: beam_type, support_type, displacement_field_type, mesh_beam, bending_modes, &
      & count_bending_modes, &
      & slope_at
   implicit none
   private
   public :: exact_choice_type, candidate_moments, count_of_places, axial_forces, layer_places, legendre, sorted

   !> Finite elements for each function, at least
   integer, parameter, public :: elements_of_a_function = 8
   !> Polynomials up to this degree are taken by turns with the modes
   integer, parameter :: early_degree = 3
   !> Conditions at both ends: no bending moment, no shear force
   integer, parameter :: conditions = 4
   !> What is left of conditions that are met
   real(wp), parameter :: met = 1.0e-9_wp

   !> What the user, or the program for him, chooses of an exact beam
   type :: exact_choice_type
      !> Functions of the angle, and of the strain along the axis; whether sections shear too, with functions of their own
      integer :: angles = 6, strains = 1
      logical :: shear = .false.
      !> Support of the modes
      type(support_type) :: support
      !> Whether something acts at the start and at the end that makes a bending moment, or a shear force, there
      logical :: moment(2) = .true., shear_force(2) = .true.
      !> Coordinate of the frame's origin [length]
      real(wp) :: origin = 0.0_wp
      !> Places within the beam where forces and couples act: the curvature has a kink, or a step, there
      real(wp), allocatable :: kinks(:), steps(:)
      !> Places within the beam where a spread load begins or ends: the slope of the curvature has a kink there
      real(wp), allocatable :: corners(:)
      !> Places within the beam where the axial force may jump, and joints feel how the parts between them stretch; unallocated:
      !> none
      real(wp), allocatable :: pulls(:)
      !> Lengths in which bending dies away where a large tension keeps the beam straight, ascending; unallocated: no functions for
      !> that. Whether it does so at the start, at the end
      real(wp), allocatable :: layers(:)
      logical :: layered(2) = .false.
      !> Sections; with unallocated values: the beam is uniform
      type(profile_type) :: profile
      !> Curvature of the undeformed axis, curvature and strain that heat makes in a beam that nothing holds [1/length], -; tension
      !> of the undeformed beam [force]
      real(wp) :: arc = 0.0_wp, hot_curvature = 0.0_wp, hot_strain = 0.0_wp, pretension = 0.0_wp
   end type exact_choice_type

   !> The conditions at the ends where nothing acts, and polynomials that correct what does not meet them
   type :: natural_type
      !> Whether the moment and the shear force at the start, and those at the end, are to be zero
      logical :: wanted(conditions) = .false.
      !> The polynomials (stations, count), what they have at the ends (conditions, count), and the condition of each
      real(wp), allocatable :: moment(:, :), ends(:, :)
      integer, allocatable :: row(:)
   end type natural_type

contains

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

   !> Bending moments at the stations, in the order of their use: of what acts within the beam, then of the modes of the finite
   !> elements of a uniform beam by turns with polynomials, then polynomials (stations, candidates). All meet the conditions at
   !> ends where nothing acts; the modes do so but for errors of the elements. Eq. (2.33).
   subroutine candidate_moments(beam, choice, s, candidates, error)
      type(beam_type), intent(in) :: beam
      type(exact_choice_type), intent(in) :: choice
      !> Coordinates of the stations [length]
      real(wp), intent(in) :: s(:)
      real(wp), allocatable, intent(inout) :: candidates(:, :)
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: modes(:, :), ends(:, :), smooth(:, :)
      type(natural_type) :: natural
      integer, allocatable :: degree(:)
      integer :: i, k, count
      allocate (modes(0, 0), ends(0, 0))
      call mode_curvatures(beam, choice, s, modes, ends, error)
      if (allocated(error)) return
      allocate (smooth(size(s), 0), degree(0))
      natural%wanted = [.not. choice%moment(1), .not. choice%shear_force(1), .not. choice%moment(2), .not. choice%shear_force(2)]
      call natural_polynomials(natural, choice%angles + early_degree + conditions, 2*s/beam%length - 1, smooth, degree)
      deallocate (candidates)
      allocate (candidates(size(s), 0))
      call of_places(beam%length, choice, s, natural, candidates)
      ! The motion of an end against the other one comes before vibrations between them
      k = 0
      if (choice%support%w_start .and. choice%support%w_end) k = count_up_to(1)
      candidates = reshape([candidates, smooth(:, :k)], [size(s), size(candidates, 2) + k])
      count = size(candidates, 2)
      candidates = reshape([candidates, modes, smooth(:, k + 1:)], [size(s), count + size(modes, 2) + size(smooth, 2) - k])
      do i = 1, size(modes, 2)
         call meet(natural, ends(:, i), modes(:, i))
         candidates(:, count + 1) = modes(:, i)
         count = count + 1
         if (k >= count_up_to(early_degree)) cycle
         ! Two modes first: a parabola is almost the first one
         if (i == 1 .and. degree(k + 1) > 1) cycle
         k = k + 1
         count = count + 1
         candidates(:, count) = smooth(:, k)
      end do
      candidates(:, count + 1:) = smooth(:, k + 1:)

   contains

      !> Polynomials of at most a degree.
      pure integer function count_up_to(most)
         integer, intent(in) :: most
         count_up_to = size(pack(degree, degree <= most))
      end function count_up_to

   end subroutine candidate_moments

   !> Bending moments of couples, then of forces, then of ends of spread loads within the beam, then of layers (stations,
   !> candidates).
   subroutine of_places(length, choice, s, natural, candidates)
      !> Of the beam; coordinates of the stations [length]
      real(wp), intent(in) :: length, s(:)
      type(exact_choice_type), intent(in) :: choice
      type(natural_type), intent(in) :: natural
      real(wp), allocatable, intent(inout) :: candidates(:, :)
      real(wp), allocatable :: places(:)
      real(wp) :: moment(size(s)), ends(conditions)
      integer :: i
      allocate (places, source=sorted(choice%steps, length))
      do i = 1, size(places)
         moment = merge(1.0_wp, 0.0_wp, s > places(i))
         ends = [0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp]
         call append()
      end do
      deallocate (places)
      allocate (places, source=sorted(choice%kinks, length))
      do i = 1, size(places)
         moment = max(s - places(i), 0.0_wp)/length
         ends = [0.0_wp, 0.0_wp, 1 - places(i)/length, 0.5_wp]
         call append()
      end do
      deallocate (places)
      allocate (places, source=sorted(choice%corners, length))
      do i = 1, size(places)
         moment = 0.5_wp*(max(s - places(i), 0.0_wp)/length)**2
         ends = [0.0_wp, 0.0_wp, 0.5_wp*(1 - places(i)/length)**2, 0.5_wp*(1 - places(i)/length)]
         call append()
      end do

      call of_layers(length, choice, s, natural, candidates)

   contains

      !> One more, with polynomials that make it meet the conditions.
      subroutine append()
         call append_moment(natural, ends, moment, candidates)
      end subroutine append

   end subroutine of_places

   !> Bending moments that die away from the ends, from forces and, of the other sign before them, from couples, eq. (2.35).
   subroutine of_layers(length, choice, s, natural, candidates)
      !> As of places
      real(wp), intent(in) :: length, s(:)
      type(exact_choice_type), intent(in) :: choice
      type(natural_type), intent(in) :: natural
      real(wp), allocatable, intent(inout) :: candidates(:, :)
      real(wp), allocatable :: places(:)
      real(wp) :: moment(size(s)), ends(conditions), slope
      integer :: i, k, couples
      if (.not. allocated(choice%layers)) return
      allocate (places, source=layer_places(choice, length))
      couples = size(sorted(choice%steps, length))
      do k = 1, size(choice%layers)
         slope = 0.5_wp*length/choice%layers(k)
         do i = 1, size(places)
            associate (x => (s - places(i))/choice%layers(k), x0 => places(i)/choice%layers(k), &
               & x1 => (length - places(i))/choice%layers(k))
               moment = exp(-abs(x))
               ends = [exp(-x0), slope*exp(-x0), exp(-x1), -slope*exp(-x1)]
               if (.not. places(i) > 0.0_wp) ends(2) = -slope
               if (.not. places(i) < length) ends(4) = slope
               if (i > size(places) - couples) then
                  moment = sign(moment, x)
                  ends(1:2) = -ends(1:2)
               end if
            end associate
            call append_moment(natural, ends, moment, candidates)
         end do
      end do
   end subroutine of_layers

   !> Places that layers spread from: the ends, forces, couples.
   pure function layer_places(choice, length) result(places)
      type(exact_choice_type), intent(in) :: choice
      real(wp), intent(in) :: length
      real(wp), allocatable :: places(:)
      allocate (places(0))
      if (.not. allocated(choice%layers)) return
      if (size(choice%layers) == 0) return
      places = [pack([0.0_wp, length], choice%layered), sorted(choice%kinks, length), sorted(choice%steps, length)]
   end function layer_places

   !> Functions beside those that the deck counts: of what acts within the beam, and of layers.
   pure integer function count_of_places(choice, length) result(number)
      type(exact_choice_type), intent(in) :: choice
      real(wp), intent(in) :: length
      number = size(sorted(choice%kinks, length)) + size(sorted(choice%steps, length)) + size(sorted(choice%corners, length))
      if (allocated(choice%layers)) number = number + size(choice%layers)*size(layer_places(choice, length))
   end function count_of_places

   !> Axial forces at the stations: polynomials, as many as the deck counts, and those that jump where joints hold the beam, which
   !> makes the stretch of each part between them right (stations, count). None for a beam that does not stretch. Eq. (2.51).
   pure function axial_forces(choice, length, s) result(forces)
      type(exact_choice_type), intent(in) :: choice
      !> Of the beam; coordinates of the stations [length]
      real(wp), intent(in) :: length, s(:)
      real(wp), allocatable :: forces(:, :), places(:)
      integer :: i
      allocate (places(0))
      if (allocated(choice%pulls) .and. choice%strains > 0) places = sorted(choice%pulls, length)
      allocate (forces(size(s), choice%strains + size(places)))
      do i = 1, choice%strains
         forces(:, i) = legendre(i - 1, 2*s/length - 1)
      end do
      do i = 1, size(places)
         forces(:, choice%strains + i) = merge(1.0_wp, 0.0_wp, s > places(i))
      end do
   end function axial_forces

   !> One more candidate, with polynomials that make it meet the conditions.
   subroutine append_moment(natural, ends, moment, candidates)
      type(natural_type), intent(in) :: natural
      !> As of `meet`
      real(wp), intent(inout) :: ends(conditions), moment(:)
      real(wp), allocatable, intent(inout) :: candidates(:, :)
      call meet(natural, ends, moment)
      candidates = reshape([candidates, moment], [size(moment), size(candidates, 2) + 1])
   end subroutine append_moment

   !> Polynomials that meet the conditions, by ascending degree, and what others need to meet them: of Legendre's polynomials each
   !> is added that lower ones cannot correct.
   subroutine natural_polynomials(natural, most, x, polynomials, degree)
      !> With its wanted conditions
      type(natural_type), intent(inout) :: natural
      !> Degree of the last one
      integer, intent(in) :: most
      !> Stations (-1..1)
      real(wp), intent(in) :: x(:)
      !> (stations, count) and their degrees (count)
      real(wp), allocatable, intent(inout) :: polynomials(:, :)
      integer, allocatable, intent(inout) :: degree(:)
      real(wp) :: ends(conditions), moment(size(x))
      integer :: k
      allocate (natural%moment(size(x), 0), natural%ends(conditions, 0), natural%row(0))
      do k = 0, most
         moment = legendre(k, x)
         ends = [(-1.0_wp)**k, (-1.0_wp)**(k + 1)*0.5_wp*k*(k + 1), 1.0_wp, 0.5_wp*k*(k + 1)]
         where (.not. natural%wanted) ends = 0.0_wp
         call meet(natural, ends, moment)
         if (maxval(abs(ends)) > met) then
            natural%row = [natural%row, maxloc(abs(ends), dim=1)]
            natural%moment = reshape([natural%moment, moment], [size(x), size(natural%row)])
            natural%ends = reshape([natural%ends, ends], [conditions, size(natural%row)])
         else
            polynomials = reshape([polynomials, moment], [size(x), size(degree) + 1])
            degree = [degree, k]
         end if
      end do
   end subroutine natural_polynomials

   !> Takes from a moment what the polynomials of the conditions can.
   pure subroutine meet(natural, ends, moment)
      type(natural_type), intent(in) :: natural
      !> Moment, and slope over the half length, at the start and at the end
      real(wp), intent(inout) :: ends(conditions), moment(:)
      real(wp) :: part
      integer :: i
      where (.not. natural%wanted) ends = 0.0_wp
      do i = 1, size(natural%row)
         part = ends(natural%row(i))/natural%ends(natural%row(i), i)
         ends = ends - part*natural%ends(:, i)
         moment = moment - part*natural%moment(:, i)
      end do
   end subroutine meet

   !> Curvatures of the modes of the finite elements, smoothed: splines through the means of neighbouring elements.
   subroutine mode_curvatures(beam, choice, s, modes, ends, error)
      type(beam_type), intent(in) :: beam
      type(exact_choice_type), intent(in) :: choice
      !> Coordinates of the stations [length]
      real(wp), intent(in) :: s(:)
      !> (stations, modes)
      real(wp), allocatable, intent(inout) :: modes(:, :)
      !> What they have at the ends (conditions, modes)
      real(wp), allocatable, intent(inout) :: ends(:, :)
      type(error_type), allocatable, intent(out) :: error
      type(displacement_field_type) :: field
      type(spline_type) :: spline
      real(wp), allocatable :: left(:, :), right(:, :)
      !> With enough elements for each function, so that its mode is resolved
      type(beam_type) :: mesh
      real(wp) :: value(0:2), tiny_part, curved(2)
      integer :: count, i, j
      mesh = beam
      ! Masses within the beam have nodes of their own
      if (.not. allocated(mesh%place)) mesh%elements = max(beam%elements, elements_of_a_function*choice%angles)
      field = mesh_beam(mesh)
      ! Modes that the mesh does not resolve are no better than polynomials
      count = min(choice%angles, count_bending_modes(mesh, choice%support), mesh%elements/3)
      call bending_modes(mesh, choice%support, count, field, error)
      if (allocated(error)) return
      allocate (left(0:mesh%elements, count), right(0:mesh%elements, count))
      deallocate (modes, ends)
      allocate (modes(size(s), count), ends(conditions, count))
      do i = 0, mesh%elements
         tiny_part = 1.0e-9_wp*beam%length/mesh%elements
         left(i, :) = slope_at(field, max(field%s(i) - tiny_part, 0.0_wp), bending_curvature)
         right(i, :) = slope_at(field, min(field%s(i) + tiny_part, beam%length), bending_curvature)
      end do
      do j = 1, count
         curved = field%omega2_bending(j)*mesh%rho_a/mesh%ei*field%w([0, mesh%elements], j)
         spline = new_spline(field%s, 0.5_wp*(left(:, j) + right(:, j)) - bow(field%s), spline_natural)
         do i = 1, size(s)
            value = spline%evaluate(s(i))
            modes(i, j) = value(0) + bow(s(i))
         end do
         value = spline%evaluate(0.0_wp)
         ends(1:2, j) = [value(0), 0.5_wp*beam%length*value(1)]
         value = spline%evaluate(beam%length)
         ends(3:4, j) = [value(0) + bow(beam%length), 0.5_wp*beam%length*(value(1) + 0.5_wp*beam%length*sum(curved))]
      end do

   contains

      !> The cubic with the second derivatives that inertia gives the curvature at the ends.
      pure elemental real(wp) function bow(x)
         real(wp), intent(in) :: x
         bow = x**2*(0.5_wp*curved(1) + (curved(2) - curved(1))*x/(6*beam%length))
      end function bow

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

end module limber_beam_exact_functions
