!> Modal damping of a body as the scene holds it. With the joints, drivers, springs and bushings, and the inertia of all other
!> bodies, whose deflections are held. Found once, as a matrix on the coordinates of the body, so that it is the same for any
!> coordinates that can have these modes; and what the modes of the whole scene have of it. Floor: multibody. Source: doc/theory,
!> eqs. (3.39)-(3.44).
module limber_multibody_modal_damping
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use limber_base_kinds, only: wp
   use limber_base_finite, only: dgetrf, dgetrs
   use limber_beam_reduced_body, only: damping_power
   use limber_model_model, only: model_type, ground
   use limber_multibody_dense_eigenmodes, only: symmetric_modes
   use limber_multibody_unit_mass_coordinates, only: update_eta_masses
   use limber_multibody_free_motions, only: free_motions_type, find_freedom
   use limber_multibody_kinematics, only: place_frames, move_frames
   use limber_multibody_multiplier_system, only: update_jacobians, update_beam_masses, update_masses
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: any_modal, find_damping, damped_modes_type

   !> Most rates of frames of a scene whose motions are found for a body, and most rates of one whose own modes are found
   integer, parameter :: most = 400, most_rates = 400

   !> The modes of one body as it is held, which are damped: the more of the strain energy is in the body, the sooner
   type :: held_modes_type
      !> Frequencies, ascending (modes); coordinates that each strains in units of energy, and what has a part of one in it and none
      !> in all others (n, modes)
      real(wp), allocatable :: frequency(:), strain(:, :), dual(:, :)
   end type held_modes_type

   !> What the lowest modes of the scene have of the damping that their bodies ask for, eq. (3.44)
   type :: damped_modes_type
      !> False if the scene is too large
      logical :: found = .false.
      !> Circular frequencies [rad/time]; parts of the critical damping (modes): by ratios of bodies, as these ask for, by all else
      real(wp), allocatable :: frequency(:), ratio(:), asked(:), dampers(:)
      !> Part of the strain energy in springs (modes), and in each body (bodies, modes)
      real(wp), allocatable :: springs(:), share(:, :)
   end type damped_modes_type

contains

   !> Whether a body is damped by the ratios of its modes.
   pure logical function any_modal(model)
      type(model_type), intent(in) :: model
      integer :: i
      any_modal = .false.
      do i = 1, size(model%bodies)
         any_modal = any_modal .or. allocated(model%bodies(i)%ratio)
      end do
   end function any_modal

   !> Finds the damping of all such bodies. Pieces of a beam keep that of their coordinates.
   subroutine find_damping(system, work, model, q, missed, modes)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Of the system; the damping of its bodies is changed
      type(model_type), intent(inout) :: model
      !> Coordinates (nq)
      real(wp), intent(in) :: q(:)
      !> Bodies whose damping is that of their own coordinates: the scene is too large (bodies)
      logical, allocatable, intent(out) :: missed(:)
      !> What the modes of the scene have of it
      type(damped_modes_type), intent(out) :: modes
      type(held_modes_type) :: held(size(model%bodies))
      real(wp), allocatable :: springs(:, :)
      real(wp) :: rest(size(q))
      integer :: i
      allocate (missed(size(model%bodies)))
      missed = .false.
      rest = 0.0_wp
      call place_frames(system%model, system%layout, system%model%dynamics%start, q, work%kinematics)
      call move_frames(system%model, system%layout, q, rest, work%kinematics)
      call update_jacobians(system, work)
      call update_masses(system, work, q)
      call update_beam_masses(work)
      if (system%exact) call update_eta_masses(work)
      allocate (springs(0, 0))
      if (sum(system%layout%rates) <= most) call find_springs(system, work, springs)
      do i = 1, size(model%bodies)
         if (.not. allocated(model%bodies(i)%ratio)) cycle
         if (model%bodies(i)%whole > 0) then
            held(i) = own_coordinates(model%bodies(i)%reduced%omega2)
            cycle
         end if
         missed(i) = sum(system%layout%rates) > most
         if (missed(i)) cycle
         call find_held_modes(system, work, i, springs, held(i), missed(i))
         if (.not. missed(i)) call damp_body(held(i), model%bodies(i)%ratio, model%bodies(i)%rayleigh, &
            & model%bodies(i)%reduced%omega2, model%bodies(i)%reduced%damping)
      end do
      if (.not. any(missed) .and. sum(system%layout%rates) <= most .and. system%layout%nw <= most_rates) &
         & call find_damped_modes(system, work, model, springs, held, modes)
      ! Those of pieces are not known to be right
      if (.not. modes%found) missed = missed .or. [(allocated(model%bodies(i)%ratio) .and. model%bodies(i)%whole > 0, &
         & i=1, size(missed))]
   end subroutine find_damping

   !> The damping of one body, eq. (3.42).
   pure subroutine damp_body(held, ratio, rayleigh, omega2, damping)
      type(held_modes_type), intent(in) :: held
      !> Of its modes in ascending order (n); factors of mass and stiffness; squared frequencies of its coordinates (n)
      real(wp), intent(in) :: ratio(:), rayleigh(2), omega2(:)
      !> (n, n)
      real(wp), intent(inout) :: damping(:, :)
      real(wp) :: factor, force(size(omega2))
      integer :: k, j
      damping = 0.0_wp
      do k = 1, size(omega2)
         damping(k, k) = rayleigh(2)*omega2(k)
      end do
      do j = 1, size(held%frequency)
         factor = 2*ratio(j)/held%frequency(j) + rayleigh(1)/held%frequency(j)**2
         force = sqrt(omega2)*held%dual(:, j)
         do k = 1, size(omega2)
            damping(:, k) = damping(:, k) + factor*force*force(k)
         end do
      end do
   end subroutine damp_body

   !> Each coordinate by itself.
   pure type(held_modes_type) function own_coordinates(omega2) result(held)
      real(wp), intent(in) :: omega2(:)
      integer :: k
      allocate (held%strain(size(omega2), size(omega2)))
      held%strain = 0.0_wp
      do k = 1, size(omega2)
         held%strain(k, k) = 1.0_wp
      end do
      allocate (held%dual, source=held%strain)
      held%frequency = sqrt(omega2)
   end function own_coordinates

   !> Modes of a body as it is held: of the motions that are left, eq. (3.40), those that have the most of their strain energy in it
   !> and are no sums of others, eq. (3.41).
   subroutine find_held_modes(system, work, body, springs, held, missed)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      integer, intent(in) :: body
      !> Stiffness of springs and bushings (nw, nw)
      real(wp), intent(in) :: springs(:, :)
      type(held_modes_type), intent(out) :: held
      !> True if they are not found
      logical, intent(out) :: missed
      type(free_motions_type) :: freedom
      real(wp), allocatable :: frequency(:), motion(:, :), strain(:, :)
      integer :: first, n, j, count
      integer, allocatable :: chosen(:)
      call find_freedom(system, work, .true., freedom, body)
      call find_modes(system, work, freedom%basis, springs, frequency, motion, missed)
      if (missed) return
      n = system%layout%n(body)
      first = system%layout%w(body) + system%layout%rates(body)
      allocate (strain(n, size(frequency)))
      associate (omega2 => system%model%bodies(body)%reduced%omega2)
         do j = 1, size(frequency)
            strain(:, j) = sqrt(omega2)*motion(first:first + n - 1, j)/frequency(j)
         end do
      end associate
      allocate (chosen(size(frequency)))
      call choose(strain, chosen, count)
      held%frequency = frequency(chosen(:count))
      held%strain = strain(:, chosen(:count))
      call find_dual(held%strain, held%dual, missed)
   end subroutine find_held_modes

   !> The columns that have the most beside those chosen before, in ascending order.
   pure subroutine choose(strain, chosen, count)
      !> (n, modes)
      real(wp), intent(in) :: strain(:, :)
      integer, intent(inout) :: chosen(:)
      integer, intent(out) :: count
      !> Part of the energy of a mode that is none beside that of others
      real(wp), parameter :: none = 1.0e-6_wp
      real(wp) :: rest(size(strain, 1), size(strain, 2)), unit(size(strain, 1)), part(size(strain, 2))
      logical :: taken(size(strain, 2))
      integer :: k, j, next
      rest = strain
      taken = .false.
      do k = 1, min(size(strain, 1), size(strain, 2))
         part = [(dot_product(rest(:, j), rest(:, j)), j=1, size(part))]
         next = maxloc(part, dim=1, mask=.not. taken)
         if (.not. part(next) > none) exit
         taken(next) = .true.
         unit = rest(:, next)/sqrt(part(next))
         do j = 1, size(part)
            rest(:, j) = rest(:, j) - unit*dot_product(unit, rest(:, j))
         end do
      end do
      count = 0
      do j = 1, size(taken)
         if (.not. taken(j)) cycle
         count = count + 1
         chosen(count) = j
      end do
   end subroutine choose

   !> Y (Y^T Y)^-1 of columns that are independent.
   subroutine find_dual(strain, dual, missed)
      real(wp), intent(in) :: strain(:, :)
      real(wp), allocatable, intent(out) :: dual(:, :)
      logical, intent(out) :: missed
      real(wp) :: factors(size(strain, 2), size(strain, 2)), right(size(strain, 2), size(strain, 1))
      integer :: pivot(size(strain, 2)), m, info
      m = size(strain, 2)
      missed = .false.
      allocate (dual, source=strain)
      if (m == 0) return
      factors = matmul(transpose(strain), strain)
      right = transpose(strain)
      call dgetrf(m, m, factors, m, pivot, info)
      missed = info /= 0
      if (missed) return
      call dgetrs('N', m, size(strain, 1), factors, m, pivot, right, m, info)
      dual = transpose(right)
   end subroutine find_dual

   !> Modes of motions that are left: of all bodies' deflections and of springs. Those without strain are left out.
   subroutine find_modes(system, work, basis, springs, frequency, motion, missed)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      !> (nw, motions), and the stiffness of springs (nw, nw)
      real(wp), intent(in) :: basis(:, :), springs(:, :)
      !> Ascending (modes); of unit modal mass (nw, modes)
      real(wp), allocatable, intent(out) :: frequency(:), motion(:, :)
      logical, intent(out) :: missed
      real(wp), allocatable :: stiffness(:, :), mass(:, :)
      complex(wp), allocatable :: value(:), vector(:, :)
      logical, allocatable :: strained(:)
      integer :: i, first, j, f, rigid
      f = size(basis, 2)
      allocate (stiffness(f, f), mass(f, f))
      stiffness = matmul(transpose(basis), matmul(springs, basis))
      do i = 1, size(system%layout%w)
         first = system%layout%w(i) + system%layout%rates(i)
         do j = 1, system%layout%n(i)
            call add_square(system%model%bodies(i)%reduced%omega2(j), basis(first + j - 1, :), stiffness)
         end do
      end do
      call project_mass(system, work, basis, mass)
      missed = f > 0
      if (f > 0) call symmetric_modes(mass, stiffness, f, value, vector)
      if (allocated(value)) missed = .false.
      if (missed .or. f == 0) then
         allocate (frequency(0), motion(size(basis, 1), 0))
         return
      end if
      rigid = count(.not. aimag(value) > 0.0_wp)
      motion = matmul(basis, real(vector(:, rigid + 1:), wp))
      strained = [(is_strained(system, springs, aimag(value(rigid + i)), motion(:, i)), i=1, size(motion, 2))]
      frequency = pack(aimag(value(rigid + 1:)), strained)
      motion = motion(:, pack([(i, i=1, size(strained))], strained))
   end subroutine find_modes

   !> Whether a mode strains bodies or springs: its frequency is not that of round-off, and its energy not that of its parts.
   pure logical function is_strained(system, springs, frequency, motion)
      type(system_type), intent(in) :: system
      !> (nw, nw), of unit modal mass (nw)
      real(wp), intent(in) :: springs(:, :), frequency, motion(:)
      !> Part of a sum that is round-off
      real(wp), parameter :: none = 1.0e-13_wp
      real(wp) :: energy, parts
      integer :: i, first, last
      energy = dot_product(motion, matmul(springs, motion))
      parts = dot_product(abs(motion), matmul(abs(springs), abs(motion)))
      do i = 1, size(system%layout%w)
         first = system%layout%w(i) + system%layout%rates(i)
         last = first + system%layout%n(i) - 1
         energy = energy + sum(system%model%bodies(i)%reduced%omega2*motion(first:last)**2)
      end do
      is_strained = energy > max(0.5_wp*frequency**2, none*parts)
   end function is_strained

   !> matrix = matrix + factor row row^T.
   pure subroutine add_square(factor, row, matrix)
      real(wp), intent(in) :: factor, row(:)
      real(wp), intent(inout) :: matrix(:, :)
      integer :: k
      do k = 1, size(row)
         matrix(:, k) = matrix(:, k) + factor*row*row(k)
      end do
   end subroutine add_square

   !> Stiffness of all springs, bushings and laws of places there, without what follows, or controls one body by another (nw, nw).
   subroutine find_springs(system, work, springs)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      real(wp), allocatable, intent(inout) :: springs(:, :)
      real(wp), allocatable :: stiffness(:, :), damping(:, :), whole(:, :)
      integer, allocatable :: to(:), at(:)
      integer :: i, j, k, m
      deallocate (springs)
      allocate (springs(system%layout%nw, system%layout%nw), whole(system%layout%nw, system%layout%nw))
      springs = 0.0_wp
      do i = 1, size(system%model%loads)
         allocate (at(0))
         do k = system%model%loads(i)%first, system%model%loads(i)%last
            if (.not. system%loads(k)%item%resists) cycle
            to = unknowns_of(system, k)
            if (size(at) == 0) whole = 0.0_wp
            allocate (stiffness(size(to), size(to)), damping(size(to), size(to)), source=0.0_wp)
            call system%loads(k)%item%add_tangent(work%kinematics, stiffness, damping)
            ! A load may have the same body on both sides
            do j = 1, size(to)
               do m = 1, size(to)
                  whole(to(m), to(j)) = whole(to(m), to(j)) + stiffness(m, j)
               end do
               if (all(at /= to(j))) at = [at, to(j)]
            end do
            deallocate (stiffness, damping)
         end do
         ! The parts of a load along two axes are one spring together
         if (size(at) > 0 .and. is_symmetric(whole(at, at))) springs(at, at) = springs(at, at) + 0.5_wp*(whole(at, at) + &
            & transpose(whole(at, at)))
         deallocate (at)
      end do
   end subroutine find_springs

   !> Whether a stiffness is one of a spring: finite, and symmetric.
   pure logical function is_symmetric(stiffness)
      real(wp), intent(in) :: stiffness(:, :)
      !> Difference that is round-off
      real(wp), parameter :: none = 1.0e-9_wp
      is_symmetric = all(ieee_is_finite(stiffness))
      if (is_symmetric) is_symmetric = all(abs(stiffness - transpose(stiffness)) <= none*maxval(abs(stiffness)))
   end function is_symmetric

   !> Rates that a load acts on, body after body.
   pure function unknowns_of(system, load) result(list)
      type(system_type), intent(in) :: system
      integer, intent(in) :: load
      integer, allocatable :: list(:)
      integer :: side, k
      allocate (list(0))
      associate (item => system%loads(load)%item)
         do side = 1, size(item%bodies)
            if (item%bodies(side) == ground) cycle
            list = [list, [(system%layout%w(item%bodies(side)) + k - 1, k=1, item%rates(side))]]
         end do
      end associate
   end function unknowns_of

   !> The lowest modes of the whole scene with their damping, eqs. (3.43), (3.44).
   subroutine find_damped_modes(system, work, model, springs, held, modes)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      !> With the damping of its bodies
      type(model_type), intent(in) :: model
      real(wp), intent(in) :: springs(:, :)
      type(held_modes_type), intent(in) :: held(:)
      type(damped_modes_type), intent(out) :: modes
      type(free_motions_type) :: freedom
      real(wp), allocatable :: frequency(:), motion(:, :)
      real(wp) :: asked, flexible
      integer :: i, j, first, last
      logical :: missed
      call find_freedom(system, work, .false., freedom)
      call find_modes(system, work, freedom%basis, springs, frequency, motion, missed)
      modes%found = .not. missed
      if (missed) return
      allocate (modes%ratio(size(frequency)), modes%asked(size(frequency)), modes%springs(size(frequency)), &
         & modes%dampers(size(frequency)), modes%share(size(model%bodies), size(frequency)))
      modes%share = 0.0_wp
      modes%ratio = 0.0_wp
      modes%asked = 0.0_wp
      do j = 1, size(frequency)
         flexible = 0.0_wp
         modes%dampers(j) = 0.5_wp*damper_power(system, work, motion(:, j))/frequency(j)
         do i = 1, size(model%bodies)
            if (system%layout%n(i) == 0) cycle
            first = system%layout%w(i) + system%layout%rates(i)
            last = first + system%layout%n(i) - 1
            associate (eta => motion(first:last, j), reduced => model%bodies(i)%reduced)
               modes%share(i, j) = sum(reduced%omega2*eta**2)/frequency(j)**2
               flexible = flexible + modes%share(i, j)
               if (reduced%damped .and. .not. allocated(model%bodies(i)%ratio)) modes%dampers(j) = modes%dampers(j) &
                  & + 0.5_wp*damping_power(reduced, eta)/frequency(j)
               if (.not. allocated(model%bodies(i)%ratio)) cycle
               modes%ratio(j) = modes%ratio(j) + 0.5_wp/frequency(j)*(dot_product(eta, matmul(reduced%damping, eta)) &
                  & - model%bodies(i)%rayleigh(2)*modes%share(i, j)*frequency(j)**2)
               call ask(held(i), model%bodies(i)%ratio, model%bodies(i)%rayleigh(1), sqrt(reduced%omega2)*eta/frequency(j), &
                  & frequency(j), asked)
               modes%asked(j) = modes%asked(j) + modes%share(i, j)*asked
            end associate
         end do
         modes%asked(j) = modes%asked(j)/max(flexible, tiny(1.0_wp))
         modes%springs(j) = 1 - flexible
      end do
      call move_alloc(frequency, modes%frequency)
   end subroutine find_damped_modes

   !> Power that springs, bushings and laws of velocities take from a motion; those without derivatives there none.
   real(wp) function damper_power(system, work, motion) result(power)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      !> (nw)
      real(wp), intent(in) :: motion(:)
      real(wp), allocatable :: stiffness(:, :), damping(:, :)
      real(wp) :: part
      integer, allocatable :: to(:)
      integer :: i
      power = 0.0_wp
      do i = 1, size(system%loads)
         to = unknowns_of(system, i)
         allocate (stiffness(size(to), size(to)), damping(size(to), size(to)), source=0.0_wp)
         call system%loads(i)%item%add_tangent(work%kinematics, stiffness, damping)
         part = dot_product(motion(to), matmul(damping, motion(to)))
         if (ieee_is_finite(part)) power = power + part
         deallocate (stiffness, damping)
      end do
   end function damper_power

   !> The ratio that a body asks for where a mode of the scene strains it: that of its own modes which make up this strain.
   pure subroutine ask(held, ratio, alpha, strain, frequency, asked)
      type(held_modes_type), intent(in) :: held
      !> Of its modes; Rayleigh's factor of mass; strain in units of energy (n); of the mode
      real(wp), intent(in) :: ratio(:), alpha, strain(:), frequency
      real(wp), intent(out) :: asked
      real(wp) :: part(size(held%frequency))
      integer :: k
      part = [(dot_product(held%dual(:, k), strain)**2, k=1, size(part))]
      asked = 0.5_wp*alpha/frequency
      if (sum(part) > 0.0_wp) asked = asked + dot_product(part, ratio(:size(part)))/sum(part)
   end subroutine ask

   !> Inertia of motions.
   subroutine project_mass(system, work, motion, mass)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      !> (nw, motions), (motions, motions)
      real(wp), intent(in) :: motion(:, :)
      real(wp), intent(out) :: mass(:, :)
      real(wp), allocatable :: product(:)
      integer :: i, j, m, n, at
      allocate (product(size(motion, 1)))
      do j = 1, size(motion, 2)
         product = 0.0_wp
         do i = 1, size(system%layout%w)
            at = system%layout%w(i)
            m = system%layout%rates(i)
            n = system%layout%n(i)
            product(at:at + m - 1) = matmul(work%bodies(i)%mass(:m, :m), motion(at:at + m - 1, j))
            if (n == 0) cycle
            associate (eta => motion(at + m:at + m + n - 1, j), coupling => work%bodies(i)%coupling)
               product(at:at + m - 1) = product(at:at + m - 1) + matmul(eta, coupling)
               product(at + m:at + m + n - 1) = eta + matmul(coupling, motion(at:at + m - 1, j))
               if (allocated(work%bodies(i)%eta_mass)) product(at + m:at + m + n - 1) = product(at + m:at + m + n - 1) &
                  & + matmul(work%bodies(i)%eta_mass, eta) - eta
            end associate
         end do
         mass(:, j) = matmul(product, motion)
      end do
   end subroutine project_mass

end module limber_multibody_modal_damping
