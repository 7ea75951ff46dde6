!> What an exact beam is asked for, and the functions that its basis is taken from: bending moments along the axis, so that the
!> curvatures are right where the section changes. Floor: flex. Source: doc/theory, section "The exact beam", eqs. (X3), (X22).
module limber_flex_exact_functions
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_spline, only: spline_type, new_spline, spline_natural
   use limber_flex_beam, only: bending_curvature
   use limber_flex_exact_profile, only: profile_type
   use limber_flex_mesh, only: beam_type, support_type, field_type, mesh_beam, bending_modes, count_bending_modes, slope_at
   implicit none
   private
   public :: exact_choice_type, candidate_moments, legendre, sorted

   !> Most functions of the angle that are polynomials, beside the modes
   integer, parameter :: most_polynomials = 4

   !> What the user, or the program for him, chooses of an exact beam
   type :: exact_choice_type
      !> Functions of the angle, and of the strain along the axis; whether sections shear too, with functions of their own
      integer :: angles = 6, strains = 1
      logical :: shear = .false.
      !> Support of the modes
      type(support_type) :: support
      !> Whether more than the support acts at the ends: polynomials beside the modes
      logical :: mixed = .true.
      !> Coordinate of the frame's origin [length]
      real(wp) :: origin = 0.0_wp
      !> Places within the beam where forces and couples act: the curvature has a kink, or a step, there
      real(wp), allocatable :: kinks(:), steps(:)
      !> Sections; with unallocated values: the beam is uniform
      type(profile_type) :: profile
      !> Curvature of the undeformed axis, curvature and strain that heat makes in a beam that nothing holds [1/length], -; tension
      !> of the undeformed beam [force]
      real(wp) :: arc = 0.0_wp, hot_curvature = 0.0_wp, hot_strain = 0.0_wp, pretension = 0.0_wp
   end type exact_choice_type

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
   !> elements of a uniform beam, by turns with polynomials if the support is not all that holds the beam, then polynomials
   !> (stations, candidates).
   subroutine candidate_moments(beam, choice, s, candidates, error)
      type(beam_type), intent(in) :: beam
      type(exact_choice_type), intent(in) :: choice
      !> Coordinates of the stations [length]
      real(wp), intent(in) :: s(:)
      real(wp), allocatable, intent(inout) :: candidates(:, :)
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: modes(:, :), kinks(:), steps(:)
      integer :: i, k, count, polynomials
      allocate (modes(0, 0))
      call mode_curvatures(beam, choice, s, modes, error)
      if (allocated(error)) return
      allocate (kinks, source=sorted(choice%kinks, beam%length))
      allocate (steps, source=sorted(choice%steps, beam%length))
      count = size(kinks) + size(steps)
      polynomials = choice%angles + most_polynomials
      deallocate (candidates)
      allocate (candidates(size(s), count + size(modes, 2) + polynomials))
      do i = 1, size(steps)
         candidates(:, i) = merge(1.0_wp, 0.0_wp, s > steps(i))
      end do
      do i = 1, size(kinks)
         candidates(:, size(steps) + i) = max(s - kinks(i), 0.0_wp)/beam%length
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
         candidates(:, count) = legendre(k - 1, 2*s/beam%length - 1)
      end subroutine add_polynomial

   end subroutine candidate_moments

   !> Curvatures of the modes of the finite elements, smoothed: splines through the means of neighbouring elements.
   subroutine mode_curvatures(beam, choice, s, modes, error)
      type(beam_type), intent(in) :: beam
      type(exact_choice_type), intent(in) :: choice
      !> Coordinates of the stations [length]
      real(wp), intent(in) :: s(:)
      !> (stations, modes)
      real(wp), allocatable, intent(inout) :: modes(:, :)
      type(error_type), allocatable, intent(out) :: error
      type(field_type) :: field
      type(spline_type) :: spline
      real(wp), allocatable :: left(:, :), right(:, :)
      !> Elements for each function, so that its mode is resolved
      integer, parameter :: of_a_function = 8
      type(beam_type) :: mesh
      real(wp) :: value(0:2), tiny_part
      integer :: count, i, j
      mesh = beam
      ! Masses within the beam have nodes of their own
      if (.not. allocated(mesh%place)) mesh%elements = max(beam%elements, of_a_function*choice%angles)
      field = mesh_beam(mesh)
      ! Modes that the mesh does not resolve are no better than polynomials
      count = min(choice%angles, count_bending_modes(mesh, choice%support), mesh%elements/3)
      call bending_modes(mesh, choice%support, count, field, error)
      if (allocated(error)) return
      allocate (left(0:mesh%elements, count), right(0:mesh%elements, count))
      deallocate (modes)
      allocate (modes(size(s), count))
      do i = 0, mesh%elements
         tiny_part = 1.0e-9_wp*beam%length/mesh%elements
         left(i, :) = slope_at(field, max(field%s(i) - tiny_part, 0.0_wp), bending_curvature)
         right(i, :) = slope_at(field, min(field%s(i) + tiny_part, beam%length), bending_curvature)
      end do
      do j = 1, count
         spline = new_spline(field%s, 0.5_wp*(left(:, j) + right(:, j)), spline_natural)
         do i = 1, size(s)
            value = spline%evaluate(s(i))
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

end module limber_flex_exact_functions
