!> What the mesh of a flexible body says beside its coordinates: the axial forces in all members under the loads and the inertia
!> that act, what these do to the coordinates, what the coordinates cannot carry of the loads, and what the lumped masses make of
!> each. A straight beam is a frame of one member here. Made once, before the first step. Floor: flex.
!> Source: doc/theory, section 43, eqs. (R2)-(R7).
!>
!>     call new_survey(mesh, shape, omega2, load, survey, error)
!>     call axial_work(survey, amplitude, work)            ! of the axial forces on rotation and coordinates
!>     call find_response(survey, amplitude, omega2, base, rotation2, u, held, lower)  ! what a mode leaves out
module limber_flex_survey
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_finite, only: dgetrf, dgetrs, dsyev
   use limber_flex_beam, only: beam_stiffness
   use limber_flex_frame, only: frame_type, element_forces, element_stiffness, own_displacements
   use limber_flex_frame_solver, only: solver_type, new_solver, solve_static
   implicit none
   private
   public :: survey_type, new_survey, axial_work, mass_error, find_response

   !> Most coordinates that are looked at: those of the lowest frequencies
   integer, parameter :: most = 40

   !> Motions beyond a mode that are looked for
   integer, parameter :: motions = 6

   !> What keeps the places of a mesh where they are: the displacements of which stay, the motions without strain and those of unit
   !> forces (3, nodes, .), the factored equations of the forces
   type :: holder_type
      integer, allocatable :: row(:), pivot(:)
      real(wp), allocatable :: motion(:, :, :), own(:, :, :), matrix(:, :)
      logical :: done = .false.
   end type holder_type

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
      !> Axial force of each element for unit amplitudes, eq. (R2) (elements, amplitudes)
      real(wp), allocatable :: pull(:, :)
      !> Work of the axial force of unit amplitudes on the slopes that the rotation of the body (0) and its chosen coordinates
      !> make, eq. (R3) (0:chosen, 0:chosen, amplitudes)
      real(wp), allocatable :: work(:, :, :)
      !> Stiffness of the chosen coordinates against bending alone, without the stretch of members (chosen, chosen)
      real(wp), allocatable :: bending(:, :)
      !> Flexibility that the coordinates leave out, for the accelerations and the loads at places (3 + 3 places, 3 + 3 places)
      real(wp), allocatable :: left_out(:, :)
      !> Relative error of each frequency by the lumped masses, eq. (R5) (chosen)
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
      call choose(omega2, survey%chosen)
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
      call leave_out(survey, load, u)
      allocate (survey%lumping(size(survey%chosen)))
      do i = 1, size(survey%chosen)
         survey%lumping(i) = 0.5_wp*abs(mass_error(mesh, shape(:, :, survey%chosen(i))))
      end do
   end subroutine new_survey

   !> The coordinates of the lowest frequencies, in ascending order of their indices.
   pure subroutine choose(omega2, chosen)
      real(wp), intent(in) :: omega2(:)
      integer, allocatable, intent(out) :: chosen(:)
      logical :: taken(size(omega2))
      integer :: i
      taken = .false.
      do i = 1, min(most, size(omega2))
         taken(minloc(omega2, dim=1, mask=.not. taken)) = .true.
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

   !> Sums k_G of the elements over the mesh, eq. (R3).
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
         part = matmul(transpose(own), matmul(unit_tension(survey%mesh%length(e)), own))
         do i = 1, size(survey%pull, 2)
            survey%work(:, :, i) = survey%work(:, :, i) + survey%pull(e, i)*part
         end do
      end do
   end subroutine work_on_slopes

   !> Geometric stiffness of an element under unit tension on (w, theta) of both ends, eq. (17).
   pure function unit_tension(l) result(k)
      real(wp), intent(in) :: l
      real(wp) :: k(4, 4)
      k = reshape([36.0_wp, 3*l, -36.0_wp, 3*l, 3*l, 4*l**2, -3*l, -l**2, -36.0_wp, -3*l, 36.0_wp, -3*l, 3*l, -l**2, -3*l, &
         & 4*l**2], [4, 4])/(30*l)
   end function unit_tension

   !> What is left of the flexibility when that of the coordinates is taken out, eq. (R4).
   pure subroutine leave_out(survey, load, u)
      type(survey_type), intent(inout) :: survey
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
      do k = 1, size(survey%chosen)
         do i = 1, n
            part(i) = sum(load(:, :, at(i))*survey%shape(:, :, survey%chosen(k)))
         end do
         do j = 1, n
            survey%left_out(:, j) = survey%left_out(:, j) - part*part(j)/survey%omega2(k)
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

   !> What the kinetic energy of a shape is more with the mass spread over the elements than with it in the nodes, twice, eq. (R5).
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

   !> Work of the axial forces on the slopes of rotation (0) and chosen coordinates, eq. (R3) (0:chosen, 0:chosen).
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

   !> What the mesh does in a mode that the coordinates cannot: with its places held where the mode has them, it moves on under
   !> what is not in balance in the mode, and on under the inertia of that, eqs. (R6), (R7).
   subroutine find_response(survey, amplitude, omega2, base, rotation2, u, held, lower)
      type(survey_type), intent(in) :: survey
      !> Amplitudes of the loads that make the axial forces
      real(wp), intent(in) :: amplitude(:)
      !> Squares of the frequency of the mode, of that with all axial forces, and of the speed of a steady rotation [1/time^2]
      real(wp), intent(in) :: omega2, base, rotation2
      !> Displacements of the nodes, the motion of the body included (3, nodes)
      real(wp), intent(in) :: u(:, :)
      !> Which of the displacements of the places stay (3 places)
      logical, intent(in) :: held(:)
      !> By how much the squared frequency is lower with these motions, zero if nothing is held
      real(wp), intent(out) :: lower
      real(wp) :: d(3, size(u, 2), motions), force(3, size(u, 2), 0:motions), stiffness(0:motions, 0:motions), &
         & mass(0:motions, 0:motions), size_of
      type(holder_type) :: holder
      integer :: i, j, n
      lower = 0.0_wp
      if (count(held) < 3) return
      call new_holder(survey, held, holder)
      if (.not. holder%done) return
      force(:, :, 0) = stiffness_times(survey, amplitude, u) - rotation2*survey%mesh%mass*u
      stiffness(0, 0) = base
      mass(0, 0) = 1.0_wp
      n = 0
      do j = 1, motions
         if (j == 1) d(:, :, 1) = omega2*survey%mesh%mass*u - force(:, :, 0)
         if (j > 1) d(:, :, j) = (omega2 + rotation2)*survey%mesh%mass*d(:, :, j - 1) &
            & - stiffness_times(survey, amplitude, d(:, :, j - 1), tension_only=.true.)
         call respond(survey, holder, d(:, :, j))
         size_of = sqrt(sum(survey%mesh%mass*d(:, :, j)**2))
         if (.not. size_of > 1.0e-10_wp) exit
         d(:, :, j) = d(:, :, j)/size_of
         n = j
         force(:, :, j) = stiffness_times(survey, amplitude, d(:, :, j)) - rotation2*survey%mesh%mass*d(:, :, j)
         mass(0, j) = sum(d(:, :, j)*survey%mesh%mass*u)
         stiffness(0, j) = sum(d(:, :, j)*force(:, :, 0))
         do i = 1, j
            mass(i, j) = sum(d(:, :, i)*survey%mesh%mass*d(:, :, j))
            stiffness(i, j) = sum(d(:, :, i)*force(:, :, j))
         end do
      end do
      if (n > 0) lower = base - nearest_value(stiffness(0:n, 0:n), mass(0:n, 0:n), base)
   end subroutine find_response

   !> The eigenvalue whose vector has most of the first unknown. The upper triangles of both matrices count.
   real(wp) function nearest_value(stiffness, mass, otherwise) result(nearest)
      real(wp), intent(in) :: stiffness(0:, 0:), mass(0:, 0:)
      !> If there is none
      real(wp), intent(in) :: otherwise
      real(wp) :: vector(0:ubound(mass, 1), 0:ubound(mass, 1)), value(0:ubound(mass, 1)), room(8*size(mass, 1))
      real(wp), allocatable :: base(:, :), own(:, :), full(:, :), part(:)
      integer :: n, m, i, info
      nearest = otherwise
      n = size(mass, 1)
      vector = mass
      call dsyev('V', 'U', n, vector, n, value, room, size(room), info)
      if (info /= 0) return
      m = count(value > 1.0e-9_wp*value(n - 1))
      allocate (base(0:n - 1, m), full(0:n - 1, 0:n - 1), own(m, m), part(m))
      do i = 1, m
         base(:, i) = vector(:, n - 1 - m + i)/sqrt(value(n - 1 - m + i))
      end do
      do i = 0, n - 1
         full(:i, i) = stiffness(:i, i)
         full(i, :i) = stiffness(:i, i)
      end do
      own = matmul(transpose(base), matmul(full, base))
      call dsyev('V', 'U', m, own, m, value(0:m - 1), room, size(room), info)
      if (info /= 0) return
      do i = 0, n - 1
         full(:i, i) = mass(:i, i)
         full(i, :i) = mass(:i, i)
      end do
      part = abs(matmul(matmul(full(0, :), base), own))
      nearest = value(maxloc(part, dim=1) - 1)
   end function nearest_value

   !> Factors what keeps the places where they are: their forces, and the motions without strain.
   subroutine new_holder(survey, held, holder)
      type(survey_type), intent(in) :: survey
      logical, intent(in) :: held(:)
      type(holder_type), intent(out) :: holder
      integer :: i, j, n, info
      allocate (holder%row, source=pack([(i, i=1, size(held))], held))
      n = size(holder%row)
      associate (nodes => size(survey%mesh%place, 2))
         allocate (holder%motion(3, nodes, 3), holder%own(3, nodes, n), holder%matrix(n + 3, n + 3), holder%pivot(n + 3))
      end associate
      call rigid(survey%mesh, holder%motion)
      associate (matrix => holder%matrix, row => holder%row)
         matrix = 0.0_wp
         do j = 1, n
            call solve_static(survey%mesh, survey%solver, merge(survey%load(:, :, row(j)), 0.0_wp, survey%mesh%free), &
               & holder%own(:, :, j))
            do i = 1, n
               matrix(i, j) = sum(survey%load(:, :, row(i))*holder%own(:, :, j))
            end do
            do i = 1, 3
               matrix(n + i, j) = sum(holder%motion(:, :, i)*survey%load(:, :, row(j)))
               matrix(j, n + i) = matrix(n + i, j)
            end do
         end do
         call dgetrf(n + 3, n + 3, matrix, n + 3, holder%pivot, info)
      end associate
      holder%done = info == 0
   end subroutine new_holder

   !> Displacements of the nodes under a load on them, with the places held (3, nodes).
   subroutine respond(survey, holder, d)
      type(survey_type), intent(in) :: survey
      type(holder_type), intent(in) :: holder
      !> The load, then the displacements
      real(wp), intent(inout) :: d(:, :)
      real(wp) :: load(3, size(d, 2)), right(size(holder%pivot))
      integer :: i, n, info
      n = size(holder%row)
      load = d
      call solve_static(survey%mesh, survey%solver, merge(load, 0.0_wp, survey%mesh%free), d)
      do i = 1, n
         right(i) = -sum(survey%load(:, :, holder%row(i))*d)
      end do
      do i = 1, 3
         right(n + i) = -sum(holder%motion(:, :, i)*load)
      end do
      call dgetrs('N', n + 3, 1, holder%matrix, n + 3, holder%pivot, right, n + 3, info)
      do i = 1, n
         d = d + right(i)*holder%own(:, :, i)
      end do
      do i = 1, 3
         d = d + right(n + i)*holder%motion(:, :, i)
      end do
   end subroutine respond

   !> The motions of the mesh without strain: along both axes, and about its middle.
   pure subroutine rigid(mesh, motion)
      type(frame_type), intent(in) :: mesh
      real(wp), intent(out) :: motion(:, :, :)
      real(wp) :: middle(2), size_of
      integer :: k
      do k = 1, 2
         middle(k) = 0.5_wp*(minval(mesh%place(k, :)) + maxval(mesh%place(k, :)))
      end do
      size_of = maxval(abs(mesh%place - spread(middle, 2, size(mesh%place, 2))))
      motion = 0.0_wp
      motion(1, :, 1) = 1.0_wp
      motion(2, :, 2) = 1.0_wp
      motion(1, :, 3) = -(mesh%place(2, :) - middle(2))/size_of
      motion(2, :, 3) = (mesh%place(1, :) - middle(1))/size_of
      motion(3, :, 3) = 1.0_wp/size_of
   end subroutine rigid

   !> (K + K_G) u on all nodes, whatever the supports hold, with K_G of the axial forces of the loads (3, nodes).
   pure function stiffness_times(survey, amplitude, u, tension_only) result(force)
      type(survey_type), intent(in) :: survey
      real(wp), intent(in) :: amplitude(:), u(:, :)
      !> Whether K is left out
      logical, intent(in), optional :: tension_only
      real(wp) :: force(3, size(u, 2)), part(6), own(6), side(4)
      integer :: e, k
      force = 0.0_wp
      associate (mesh => survey%mesh)
         do e = 1, size(mesh%member)
            part = 0.0_wp
            if (.not. present(tension_only)) part = matmul(element_stiffness(mesh, e), &
               & [u(:, mesh%ends(1, e)), u(:, mesh%ends(2, e))])
            own = own_displacements(mesh, e, u)
            side = dot_product(survey%pull(e, :), amplitude)*matmul(unit_tension(mesh%length(e)), own([2, 3, 5, 6]))
            do k = 1, 2
               force(:, mesh%ends(k, e)) = force(:, mesh%ends(k, e)) + part(3*k - 2:3*k) &
                  & + [-mesh%axis(2, e)*side(2*k - 1), mesh%axis(1, e)*side(2*k - 1), side(2*k)]
            end do
         end do
      end associate
   end function stiffness_times

end module limber_flex_survey
