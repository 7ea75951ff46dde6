!> Forces in the mesh of a flexible body at a state. The axial forces in all members under the loads and the inertia that act, what
!> these do to the coordinates, what the coordinates cannot carry of the loads, and what the lumped masses make of each. A straight
!> beam is a frame of one member here. Made once, before the first step. Floor: beam. Source: doc/theory, eqs. (7.28),
!> (7.36)-(7.38).
!>
!>     call new_survey(mesh, shape, omega2, load, survey, error)
!>     call axial_work(survey, amplitude, work)            ! of the axial forces on rotation and coordinates
module limber_beam_mesh_forces
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_beam_element_matrices, only: beam_stiffness, geometric_stiffness
   use limber_beam_plane_frame, only: frame_type, element_forces, own_displacements
   use limber_beam_frame_solver, only: solver_type, new_solver, solve_static
   implicit none
   private
   public :: survey_type, new_survey, axial_work, mass_error

   !> Most coordinates that are looked at: those that yield most under what acts
   integer, parameter :: most = 120

   !> The constants of one body
   type :: survey_type
      !> Number of coordinates of the body, and of places where joints and loads act
      integer :: n = 0, places = 0
      !> Coordinates that are looked at, in ascending order, and their squared frequencies [1/time^2]
      integer, allocatable :: chosen(:)
      real(wp), allocatable :: omega2(:)
      !> The mesh, and the displacements of its nodes for each coordinate of the body (3, nodes, n)
      type(frame_type) :: mesh
      real(wp), allocatable :: shape(:, :, :)
      !> The factored stiffness, and unit loads of the places: along both axes of the body, and couples (3, nodes, 3 places)
      type(solver_type) :: solver
      real(wp), allocatable :: load(:, :, :)
      !> Axial force of each element for unit amplitudes, eq. (7.36) (elements, amplitudes)
      real(wp), allocatable :: pull(:, :)
      !> Work of the axial force of unit amplitudes on the slopes that the rotation of the body (0) and its chosen coordinates
      !> make, eq. (7.37) (0:chosen, 0:chosen, amplitudes)
      real(wp), allocatable :: work(:, :, :)
      !> Stiffness of the chosen coordinates against bending alone, without the stretch of members (chosen, chosen)
      real(wp), allocatable :: bending(:, :)
      !> Flexibility that the coordinates leave out, for the accelerations and the loads at places (3 + 3 places, 3 + 3 places)
      real(wp), allocatable :: left_out(:, :)
      !> Relative error of each frequency by the lumped masses, eq. (7.28) (chosen)
      real(wp), allocatable :: lumping(:)
   end type survey_type

contains

   !> Makes the constants. Amplitudes are in this order: the accelerations of the origin less gravity along both axes, turned
   !> round, the angular one turned round, the squared speed of rotation, those of each coordinate that act along its shape, those
   !> that act across it, and forces along both axes and couples of each place.
   subroutine new_survey(mesh, shape, omega2, place_load, survey, error)
      type(frame_type), intent(in) :: mesh
      !> (3, nodes, n), (n)
      real(wp), intent(in) :: shape(:, :, :), omega2(:)
      !> Unit loads of the places on the nodes: along both axes of the body, and couples (3, nodes, 3 places)
      real(wp), intent(in) :: place_load(:, :, :)
      type(survey_type), intent(out) :: survey
      !> The stiffness is not positive definite
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: load(:, :, :), u(:, :, :)
      real(wp) :: force(4)
      integer :: i, k, amplitudes
      survey%n = size(omega2)
      survey%places = size(place_load, 3)/3
      survey%mesh = mesh
      allocate (survey%shape, source=shape)
      call choose(mesh, shape, omega2, place_load, survey%chosen)
      allocate (survey%omega2(size(survey%chosen)))
      survey%omega2 = omega2(survey%chosen)
      call new_solver(mesh, survey%solver, error)
      if (allocated(error)) return
      allocate (survey%load, source=place_load)
      amplitudes = 4 + 2*size(survey%chosen) + 3*survey%places
      allocate (load(3, size(mesh%place, 2), amplitudes), u(3, size(mesh%place, 2), amplitudes))
      call fill_loads(survey, load)
      do i = 1, amplitudes
         call solve_static(mesh, survey%solver, merge(load(:, :, i), 0.0_wp, mesh%free), u(:, :, i))
      end do
      allocate (survey%pull(size(mesh%member), amplitudes))
      do i = 1, amplitudes
         do k = 1, size(mesh%member)
            force = element_forces(mesh, k, u(:, :, i))
            survey%pull(k, i) = force(1)
         end do
      end do
      call work_on_slopes(survey)
      call leave_out(survey, omega2, load, u)
      allocate (survey%lumping(size(survey%chosen)))
      do i = 1, size(survey%chosen)
         survey%lumping(i) = 0.5_wp*abs(mass_error(mesh, shape(:, :, survey%chosen(i))))
      end do
   end subroutine new_survey

   !> The coordinates that yield most, in ascending order of their indices: by their largest share in the flexibility for an
   !> acceleration or a load of a place. Among the lowest ones alone responses to loads would be missing.
   pure subroutine choose(mesh, shape, omega2, place_load, chosen)
      type(frame_type), intent(in) :: mesh
      real(wp), intent(in) :: shape(:, :, :), omega2(:), place_load(:, :, :)
      integer, allocatable, intent(out) :: chosen(:)
      logical :: taken(size(omega2))
      real(wp) :: share(size(omega2)), part(size(omega2))
      integer :: i, k
      taken = size(omega2) <= most
      share = 0.0_wp
      do i = 1, merge(0, 3 + size(place_load, 3), all(taken))
         do k = 1, size(omega2)
            if (i > 3) part(k) = sum(place_load(:, :, i - 3)*shape(:, :, k))
            if (i < 3) part(k) = sum(mesh%mass(i, :)*shape(i, :, k))
            if (i == 3) part(k) = sum(mesh%mass(2, :)*mesh%place(1, :)*shape(2, :, k) - mesh%mass(1, :)*mesh%place(2, :) &
               & *shape(1, :, k))
         end do
         part = part**2/omega2
         share = max(share, part/max(sum(part), tiny(1.0_wp)))
      end do
      do i = 1, merge(0, most, all(taken))
         taken(maxloc(share, dim=1, mask=.not. taken)) = .true.
      end do
      allocate (chosen, source=pack([(i, i=1, size(omega2))], taken))
   end subroutine choose

   !> The loads of unit amplitudes on the nodes.
   pure subroutine fill_loads(survey, load)
      type(survey_type), intent(in) :: survey
      !> (3, nodes, amplitudes)
      real(wp), intent(out) :: load(:, :, :)
      integer :: k, m
      m = size(survey%chosen)
      load = 0.0_wp
      associate (mass => survey%mesh%mass, place => survey%mesh%place)
         load(1, :, 1) = mass(1, :)
         load(2, :, 2) = mass(2, :)
         load(1, :, 3) = -mass(1, :)*place(2, :)
         load(2, :, 3) = mass(2, :)*place(1, :)
         load(3, :, 3) = mass(3, :)
         load(1:2, :, 4) = mass(1:2, :)*place
         do k = 1, m
            associate (phi => survey%shape(:, :, survey%chosen(k)))
               load(:, :, 4 + k) = mass*phi
               load(1, :, 4 + m + k) = -mass(1, :)*phi(2, :)
               load(2, :, 4 + m + k) = mass(2, :)*phi(1, :)
            end associate
         end do
      end associate
      load(:, :, 5 + 2*m:) = survey%load
   end subroutine fill_loads

   !> Sums k_G of the elements over the mesh, eq. (7.37).
   pure subroutine work_on_slopes(survey)
      type(survey_type), intent(inout) :: survey
      real(wp) :: own(4, 0:size(survey%chosen)), part(0:size(survey%chosen), 0:size(survey%chosen))
      real(wp) :: displaced(6), stiffness(6, 6)
      integer :: e, i, m
      m = size(survey%chosen)
      allocate (survey%work(0:m, 0:m, size(survey%pull, 2)), survey%bending(m, m))
      survey%work = 0.0_wp
      survey%bending = 0.0_wp
      do e = 1, size(survey%mesh%member)
         own(:, 0) = [0.0_wp, 1.0_wp, survey%mesh%length(e), 1.0_wp]
         do i = 1, m
            displaced = own_displacements(survey%mesh, e, survey%shape(:, :, survey%chosen(i)))
            own(:, i) = displaced([2, 3, 5, 6])
         end do
         stiffness = beam_stiffness(0.0_wp, survey%mesh%ei(e), survey%mesh%length(e))
         survey%bending = survey%bending + matmul(transpose(own(:, 1:)), matmul(stiffness([2, 3, 5, 6], [2, 3, 5, 6]), own(:, 1:)))
         part = matmul(transpose(own), matmul(geometric_stiffness(survey%mesh%length(e)), own))
         do i = 1, size(survey%pull, 2)
            survey%work(:, :, i) = survey%work(:, :, i) + survey%pull(e, i)*part
         end do
      end do
   end subroutine work_on_slopes

   !> What is left of the flexibility when that of the coordinates is taken out, eq. (7.38).
   pure subroutine leave_out(survey, omega2, load, u)
      type(survey_type), intent(inout) :: survey
      !> Squared frequencies of all coordinates (n)
      real(wp), intent(in) :: omega2(:)
      !> Of all amplitudes (3, nodes, amplitudes)
      real(wp), intent(in) :: load(:, :, :), u(:, :, :)
      integer :: i, j, k, first, n
      real(wp) :: part(3 + 3*survey%places)
      first = 1 + 2*size(survey%chosen)
      n = 3 + 3*survey%places
      allocate (survey%left_out(n, n))
      do j = 1, n
         do i = 1, n
            survey%left_out(i, j) = sum(load(:, :, at(i))*u(:, :, at(j)), mask=survey%mesh%free)
         end do
      end do
      do k = 1, size(omega2)
         do i = 1, n
            part(i) = sum(load(:, :, at(i))*survey%shape(:, :, k))
         end do
         do j = 1, n
            survey%left_out(:, j) = survey%left_out(:, j) - part*part(j)/omega2(k)
         end do
      end do

   contains

      !> Number of the amplitude: of an acceleration or a load at a place.
      pure integer function at(i)
         integer, intent(in) :: i
         at = i
         if (i > 3) at = first + i
      end function at

   end subroutine leave_out

   !> What the kinetic energy of a shape is more with the mass spread over the elements than with it in the nodes, twice, eq.
   !> (7.28).
   pure real(wp) function mass_error(mesh, u) result(more)
      type(frame_type), intent(in) :: mesh
      !> Displacements of the nodes (3, nodes)
      real(wp), intent(in) :: u(:, :)
      real(wp) :: own(6), w(4), l, spread
      integer :: e
      more = 0.0_wp
      do e = 1, size(mesh%member)
         own = own_displacements(mesh, e, u)
         l = mesh%length(e)
         w = own([2, 3, 5, 6])
         spread = (own(1)**2 + own(1)*own(4) + own(4)**2)/3 + (156*(w(1)**2 + w(3)**2) + 108*w(1)*w(3) &
            & + 4*l**2*(w(2)**2 + w(4)**2) - 6*l**2*w(2)*w(4) + 44*l*(w(1)*w(2) - w(3)*w(4)) &
            & - 26*l*(w(1)*w(4) - w(2)*w(3)))/420
         more = more + mesh%rho_a(e)*l*(spread - 0.5_wp*(own(1)**2 + own(2)**2 + own(4)**2 + own(5)**2))
      end do
   end function mass_error

   !> Work of the axial forces on the slopes of rotation (0) and chosen coordinates, eq. (7.37) (0:chosen, 0:chosen).
   pure subroutine axial_work(survey, amplitude, work)
      type(survey_type), intent(in) :: survey
      !> (amplitudes)
      real(wp), intent(in) :: amplitude(:)
      real(wp), intent(inout) :: work(0:, 0:)
      integer :: i
      work = 0.0_wp
      do i = 1, size(amplitude)
         if (abs(amplitude(i)) > 0.0_wp) work = work + amplitude(i)*survey%work(:, :, i)
      end do
   end subroutine axial_work

end module limber_beam_mesh_forces
