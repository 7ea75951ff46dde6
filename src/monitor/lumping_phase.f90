!> Monitor of the phase of vibrations with lumped masses. Small motions of the body as joints hold it, each with the error of its
!> frequency, and how late each is in the end. The motions are made when the body is first observed. Floor: monitor. Source:
!> doc/theory, eqs. (7.29)-(7.31).
module limber_monitor_lumping_phase
   use limber_base_kinds, only: wp
   use limber_base_finite, only: dsyev
   use limber_base_snapshot, only: snapshot_type
   use limber_monitor_noise, only: noise_of
   use limber_beam_plane_frame, only: frame_type, beam_frame
   use limber_beam_mesh_forces, only: mass_error
   use limber_model_model, only: place_at_point, body_type, ground
   use limber_multibody_plane_vectors, only: along, turn
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: phase_type, start_phase, observe_phase, observe_swings, join_phases, phase_error

   !> Most coordinates that are looked at: the first ones
   integer, parameter :: most = 40
   !> Vibrations that ADAMS keeps up at the limit of its steps, in units of the noise
   real(wp), parameter :: kept_up = 5.0_wp
   !> The error of moments against the sum over vibrations that do not lag alike, measured on an L-frame
   real(wp), parameter :: in_moments = 0.5_wp

   !> One flexible body
   type :: phase_type
      !> Number of coordinates that are looked at
      integer :: n = 0
      !> Whether bodies are held by the ground, themselves or by what is (bodies), and whether no driver sets the pace
      logical, allocatable :: grounded(:)
      logical :: free = .false., made = .false.
      !> Whether channels ask for what its deflections make alone
      logical :: shown = .false.
      !> Whether channels ask for section forces or reactions, in which fast vibrations count more
      logical :: strained = .false.
      !> Whether channels ask for accelerations or forces: those of a swing go to and fro twice as often as its places
      logical :: pulled = .false.
      !> Where its frame is at first (4), and how far it moves, the rotation times the size of the body [length]
      real(wp) :: home(4) = 0.0_wp, way = 0.0_wp
      !> Square of the coordinates that deflect the body by next to nothing
      real(wp) :: nothing = 0.0_wp
      !> Of each vibration: its amplitude of unit coordinates (n, vibrations), what its unit amplitude is in them, frequency, rate
      !> at which it forgets, relative error of the frequency (vibrations)
      real(wp), allocatable :: part(:, :), size(:), frequency(:), forgets(:), error(:)
      !> Half of what the moment of inertia is too large [mass length^2]; error of the frequency of swings of the scene
      real(wp) :: heavy = 0.0_wp, swing = 0.0_wp
      !> Largest product of speed and time, largest speed, sums of squared speeds and accelerations, of each vibration (vibrations)
      real(wp), allocatable :: late(:), most(:), speed(:), acceleration(:)
      !> Of the rotation of the body: both sums; first and last time; number of states
      integer :: looks = 0
      real(wp) :: swung(2) = 0.0_wp, span(2) = [huge(1.0_wp), -huge(1.0_wp)]
   contains
      procedure :: exchange => exchange_phase
   end type phase_type

contains

   !> Before the first state.
   subroutine start_phase(self, system, index)
      type(phase_type), intent(out) :: self
      type(system_type), intent(in) :: system
      !> The body
      integer, intent(in) :: index
      integer :: i, k
      self%n = min(most, system%layout%n(index))
      self%free = size(system%model%drivers) == 0 .and. (norm2(system%model%gravity) > 0.0_wp .or. &
         & any(abs(system%model%load_parts%stiffness) > 0.0_wp))
      allocate (self%grounded(size(system%model%bodies)), source=.false.)
      do i = 1, size(system%constraints)
         associate (bodies => system%constraints(i)%item%bodies)
            do k = 1, 2
               if (bodies(k) /= ground .and. bodies(3 - k) == ground) self%grounded(bodies(k)) = .true.
            end do
         end associate
      end do
      if (system%model%bodies(index)%largest_shape > 0.0_wp) self%nothing = (kept_up* &
         & noise_of(system%model%dynamics%tolerance)*system%model%bodies(index)%size/system%model%bodies(index)%largest_shape)**2
      allocate (self%late(0), self%most(0), self%speed(0), self%acceleration(0))
   end subroutine start_phase

   !> Takes a state.
   subroutine observe_phase(self, system, work, index, t, q, v, a)
      type(phase_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Jacobians of the state
      type(workspace_type), intent(in) :: work
      integer, intent(in) :: index
      !> Time; coordinates, velocities, accelerations (nq)
      real(wp), intent(in) :: t, q(:), v(:), a(:)
      real(wp) :: speed, acceleration
      integer :: first, j
      if (self%n == 0) return
      first = system%layout%q(index) + 3
      if (.not. self%made) call make_motions(self, system, work, index, q(first - 1:first))
      self%span = [min(self%span(1), t), max(self%span(2), t)]
      do j = 1, size(self%error)
         speed = dot_product(self%part(:, j), v(first + 1:first + self%n))
         acceleration = dot_product(self%part(:, j), a(first + 1:first + self%n))
         self%speed(j) = self%speed(j) + speed**2
         self%acceleration(j) = self%acceleration(j) + acceleration**2
         self%most(j) = max(self%most(j), abs(speed))
         self%late(j) = max(self%late(j), abs(speed)*min(t - self%span(1), 1/max(self%forgets(j), tiny(1.0_wp))))
      end do
      if (self%looks == 0) self%home = q(first - 3:first)
      self%way = max(self%way, norm2(q(first - 3:first - 2) - self%home(1:2)), &
         & system%model%bodies(index)%size*norm2(q(first - 1:first) - self%home(3:4)))
      self%looks = self%looks + 1
      self%swung(1) = self%swung(1) + turning(q(first - 1:first), v(first - 1:first))**2
      self%swung(2) = self%swung(2) + turning(q(first - 1:first), a(first - 1:first))**2
   end subroutine observe_phase

   !> Adds the energies of a state that swings are judged by, eq. (7.31): what the masses in the nodes are too heavy for the
   !> rotation of their bodies, and the kinetic energy of the scene as if all were rigid.
   subroutine observe_swings(bodies, index, system, v, q, energy)
      !> Of the flexible bodies, and their indices
      type(phase_type), intent(in) :: bodies(:)
      integer, intent(in) :: index(:)
      type(system_type), intent(in) :: system
      !> Velocities and coordinates (nq)
      real(wp), intent(in) :: v(:), q(:)
      !> Both sums
      real(wp), intent(inout) :: energy(2)
      real(wp) :: omega, moved(2)
      integer :: i, first
      do i = 1, size(bodies)
         first = system%layout%q(index(i))
         energy(1) = energy(1) + bodies(i)%heavy*turning(q(first + 2:first + 3), v(first + 2:first + 3))**2
      end do
      do i = 1, size(system%model%bodies)
         first = system%layout%q(i)
         associate (reduced => system%model%bodies(i)%reduced)
            energy(2) = energy(2) + 0.5_wp*reduced%mass*dot_product(v(first:first + 1), v(first:first + 1))
            if (.not. system%layout%framed(i)) cycle
            omega = turning(q(first + 2:first + 3), v(first + 2:first + 3))
            moved = along(reduced%c0, v(first + 2:first + 3))
            energy(2) = energy(2) + 0.5_wp*reduced%i0*omega**2 + dot_product(v(first:first + 1), moved)
         end associate
      end do
   end subroutine observe_swings

   !> Rotation by the rate of a unit vector.
   pure real(wp) function turning(u, rate)
      real(wp), intent(in) :: u(2), rate(2)
      turning = u(1)*rate(2) - u(2)*rate(1)
   end function turning

   !> The small motions: with the places held where joints with the ground, or with bodies that have such joints, hold them, and
   !> with the masses of all other bodies that are pinned or welded to it, eq. (7.29).
   subroutine make_motions(self, system, work, index, u)
      type(phase_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      integer, intent(in) :: index
      !> Unit vector of the body
      real(wp), intent(in) :: u(2)
      type(frame_type) :: mesh
      real(wp), allocatable :: shape(:, :, :), moved(:, :, :), mass(:, :), free(:, :), stiffness(:, :), value(:)
      integer :: m, j
      logical :: done
      self%made = .true.
      m = 3 + self%n
      associate (body => system%model%bodies(index))
         if (body%is_frame) then
            mesh = body%mesh
            allocate (shape, source=body%shape(:, :, :self%n))
         else
            call beam_frame(body%beam, body%choice%support, body%choice%origin, body%field, mesh, shape)
         end if
      end associate
      allocate (moved(3, size(mesh%place, 2), m))
      moved = 0.0_wp
      moved(1, :, 1) = 1.0_wp
      moved(2, :, 2) = 1.0_wp
      moved(1, :, 3) = -mesh%place(2, :)
      moved(2, :, 3) = mesh%place(1, :)
      moved(3, :, 3) = 1.0_wp
      moved(:, :, 4:) = shape(:, :, :self%n)
      allocate (mass(m, m))
      do j = 1, m
         call weigh(mesh%mass*moved(:, :, j), mass(:, j))
      end do
      call carry(self, system, index, mass)
      call free_motions(self, system, work, index, u, mass, free, done)
      if (done) call vibrations(system%model%bodies(index), mass, free, stiffness, value, done)
      if (.not. done) allocate (stiffness(m, 0), value(0))
      call keep_motions(self, system%model%bodies(index), mesh, welded_ends(system, index), moved, stiffness, value)

   contains

      !> Work of forces on the nodes on each motion.
      pure subroutine weigh(force, works)
         real(wp), intent(in) :: force(:, :)
         real(wp), intent(out) :: works(:)
         integer :: i
         do i = 1, m
            works(i) = sum(force*moved(:, :, i))
         end do
      end subroutine weigh

   end subroutine make_motions

   !> Whether flexible bodies are welded to the start and to the end of a beam.
   pure function welded_ends(system, index) result(welded)
      type(system_type), intent(in) :: system
      integer, intent(in) :: index
      logical :: welded(2)
      real(wp) :: x
      integer :: i, k
      welded = .false.
      do i = 1, size(system%model%joints)
         if (.not. system%model%joints(i)%is_weld()) cycle
         associate (item => system%constraints(i)%item, body => system%model%bodies(index))
            do k = 1, 2
               if (item%bodies(k) /= index .or. item%bodies(3 - k) == ground .or. item%points(k) == 0) cycle
               if (system%layout%n(item%bodies(3 - k)) == 0) cycle
               x = system%model%points(item%points(k))%p0(1) + body%choice%origin
               welded(1) = welded(1) .or. x <= 1.0e-9_wp*body%beam%length
               welded(2) = welded(2) .or. x >= (1 - 1.0e-9_wp)*body%beam%length
            end do
         end associate
      end do
   end function welded_ends

   !> Adds the masses of bodies that hang on it.
   subroutine carry(self, system, index, mass)
      type(phase_type), intent(in) :: self
      type(system_type), intent(in) :: system
      integer, intent(in) :: index
      real(wp), intent(inout) :: mass(:, :)
      real(wp) :: row(size(mass, 1), 3), weight(3)
      integer :: i, k, j, other
      do i = 1, size(system%model%joints)
         if (system%model%joints(i)%place /= place_at_point) cycle
         associate (item => system%constraints(i)%item)
            do k = 1, 2
               if (item%bodies(k) /= index .or. item%points(k) == 0) cycle
               other = item%bodies(3 - k)
               if (other == ground .or. other == index) cycle
               if (self%grounded(other)) cycle
               associate (point => system%model%points(item%points(k)), reduced => system%model%bodies(other)%reduced)
                  row(:, 1) = [1.0_wp, 0.0_wp, -point%p0(2), point%phi(1, :self%n)]
                  row(:, 2) = [0.0_wp, 1.0_wp, point%p0(1), point%phi(2, :self%n)]
                  row(:, 3) = [0.0_wp, 0.0_wp, 1.0_wp, point%psi(:self%n)]
                  weight = [reduced%mass, reduced%mass, 0.0_wp]
                  if (system%model%joints(i)%is_weld()) weight(3) = reduced%i0
               end associate
               do j = 1, size(mass, 2)
                  mass(:, j) = mass(:, j) + matmul(row, weight*row(j, :))
               end do
            end do
         end associate
      end do
   end subroutine carry

   !> Motions of unit modal mass that the joints allow: along the axes of the body, its rotation, its coordinates (3 + n, motions).
   subroutine free_motions(self, system, work, index, u, mass, free, done)
      type(phase_type), intent(in) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      integer, intent(in) :: index
      real(wp), intent(in) :: u(2), mass(:, :)
      real(wp), allocatable, intent(out) :: free(:, :)
      logical, intent(out) :: done
      real(wp), allocatable :: rows(:, :)
      real(wp) :: gram(size(mass, 1), size(mass, 1)), value(size(mass, 1)), room(8*size(mass, 1)), unit(size(mass, 1))
      integer :: i, side, row, count, m, j, info, other
      m = size(mass, 1)
      do j = 1, m
         unit(j) = 1/sqrt(max(mass(j, j), tiny(1.0_wp)))
      end do
      allocate (rows(system%nc, m))
      count = 0
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            do side = 1, 2
               if (item%bodies(side) /= index) cycle
               other = item%bodies(3 - side)
               if (other /= ground) then
                  if (.not. self%grounded(other)) cycle
               end if
               do row = 1, item%rows
                  count = count + 1
                  associate (z => work%jacobians(side, i)%z(row, 1:3))
                     rows(count, :2) = [dot_product(z(1:2), u), dot_product(z(1:2), turn(u))]
                     rows(count, 3) = z(3)
                  end associate
                  rows(count, 4:) = work%jacobians(side, i)%eta(row, :self%n)
                  rows(count, :) = rows(count, :)*unit
                  rows(count, :) = rows(count, :)/max(norm2(rows(count, :)), tiny(1.0_wp))
               end do
            end do
         end associate
      end do
      gram = matmul(transpose(rows(:count, :)), rows(:count, :))
      call dsyev('V', 'L', m, gram, m, value, room, size(room), info)
      done = info == 0
      if (.not. done) return
      count = 0
      do j = 1, m
         if (value(j) < 1.0e-10_wp) count = j
      end do
      allocate (free(m, count))
      do j = 1, count
         free(:, j) = unit*gram(:, j)
      end do
      call orthonormalise(mass, free, done)
   end subroutine free_motions

   !> Makes motions orthonormal in the mass; those without mass are left out.
   subroutine orthonormalise(mass, motions, done)
      real(wp), intent(in) :: mass(:, :)
      real(wp), allocatable, intent(inout) :: motions(:, :)
      logical, intent(out) :: done
      real(wp), allocatable :: own(:, :), value(:), room(:), kept(:, :)
      integer :: k, j, n, info
      n = size(motions, 2)
      done = n > 0
      if (.not. done) return
      allocate (own(n, n), value(n), room(8*n))
      own = matmul(transpose(motions), matmul(mass, motions))
      call dsyev('V', 'L', n, own, n, value, room, size(room), info)
      done = info == 0
      if (.not. done) return
      k = count(value > 1.0e-9_wp*value(n))
      allocate (kept(size(motions, 1), k))
      do j = 1, k
         kept(:, j) = matmul(motions, own(:, n - k + j))/sqrt(value(n - k + j))
      end do
      call move_alloc(kept, motions)
   end subroutine orthonormalise

   !> The vibrations among the motions, and their squared frequencies.
   subroutine vibrations(body, mass, free, shape, value, done)
      type(body_type), intent(in) :: body
      real(wp), intent(in) :: mass(:, :), free(:, :)
      !> Of unit modal mass (3 + n, motions), (motions)
      real(wp), allocatable, intent(out) :: shape(:, :), value(:)
      logical, intent(out) :: done
      real(wp) :: stiffness(size(free, 2), size(free, 2)), room(8*size(free, 2))
      integer :: i, k, info
      k = size(free, 2)
      do i = 1, k
         stiffness(:, i) = matmul(body%reduced%omega2(:size(mass, 1) - 3)*free(4:, i), free(4:, :))
      end do
      allocate (value(k))
      call dsyev('V', 'L', k, stiffness, k, value, room, size(room), info)
      done = info == 0
      allocate (shape(size(free, 1), k))
      if (done) shape = matmul(free, stiffness)
   end subroutine vibrations

   !> What is needed in the motion: of a vibration what eq. (7.30) asks for, and the error of a swing.
   subroutine keep_motions(self, body, mesh, goes_on, moved, shape, value)
      type(phase_type), intent(inout) :: self
      type(body_type), intent(in) :: body
      type(frame_type), intent(in) :: mesh
      !> Whether flexible bodies are welded to the start and to the end of a beam
      logical, intent(in) :: goes_on(2)
      !> Displacements of the nodes by each motion along the axes of the body, its rotation and its coordinates (3, nodes, 3 + n)
      real(wp), intent(in) :: moved(:, :, :)
      real(wp), intent(in) :: shape(:, :), value(:)
      real(wp) :: bent
      integer :: j, k, kept, count_of
      count_of = 0
      if (.not. any(goes_on)) count_of = count(value > elastic_from())
      allocate (self%part(self%n, count_of), self%size(count_of), self%frequency(count_of), self%forgets(count_of), &
         & self%error(count_of))
      deallocate (self%late, self%most, self%speed, self%acceleration)
      allocate (self%late(count_of), self%most(count_of), self%speed(count_of), self%acceleration(count_of), source=0.0_wp)
      self%heavy = 0.5_wp*abs(mass_error(mesh, moved(:, :, 3)))
      kept = 0
      do j = 1, size(value)
         if (.not. value(j) > elastic_from() .or. any(goes_on)) cycle
         kept = kept + 1
         bent = 0.0_wp
         do k = 1, min(self%n, body%reduced%bending)
            bent = bent + shape(3 + k, j)**2
         end do
         self%part(:, kept) = body%reduced%omega2(:self%n)*shape(4:, j)/value(j)
         self%size(kept) = sqrt(bent)
         self%frequency(kept) = sqrt(value(j))
         self%error(kept) = 0.5_wp*abs(mass_error(mesh, displaced(shape(:, j))))
         self%forgets(kept) = 0.0_wp
         if (body%reduced%damped) self%forgets(kept) = 0.5_wp*dot_product(shape(4:, j), &
            & matmul(body%reduced%damping(:self%n, :self%n), shape(4:, j)))
      end do

   contains

      !> Squared frequency above which a motion is a vibration.
      pure real(wp) function elastic_from()
         elastic_from = 1.0e-9_wp*minval(body%reduced%omega2)
      end function elastic_from

      !> Displacements of the nodes (3, nodes).
      pure function displaced(motion) result(d)
         real(wp), intent(in) :: motion(:)
         real(wp) :: d(3, size(moved, 2))
         integer :: i
         d = 0.0_wp
         do i = 1, size(motion)
            d = d + moved(:, :, i)*motion(i)
         end do
      end function displaced

   end subroutine keep_motions

   !> Error of the motion at the end by the frequencies, relative to the largest deflection, or to the swing, eqs. (7.30), (7.31);
   !> above one the vibrations have lost their phase.
   pure real(wp) function phase_error(self, bent, deflection) result(error)
      type(phase_type), intent(in) :: self
      !> Largest square of the bending coordinates; largest deflection [length]
      real(wp), intent(in) :: bent, deflection
      !> Angle below which a swing is none [rad]
      real(wp), parameter :: little = 0.01_wp
      real(wp) :: pace, shift, own, moment, largest
      integer :: j
      error = 0.0_wp
      if (.not. self%made) return
      shift = 0.0_wp
      moment = 0.0_wp
      largest = 0.0_wp
      if (size(self%frequency) > 0) largest = bent*minval(self%frequency)**2
      do j = 1, size(self%error)
         if (.not. self%speed(j) > 0.0_wp) cycle
         ! What follows its loads slowly does not run on by itself
         pace = min(1.0_wp, self%acceleration(j)/(self%speed(j)*self%frequency(j)**2))
         own = (self%size(j)*min(self%error(j)*self%late(j)*pace, 2*self%most(j)/self%frequency(j)))**2
         shift = shift + own
         ! A bending moment is to the deflection as the frequency
         moment = moment + own*self%frequency(j)**2
         largest = largest + (self%size(j)*self%most(j))**2
      end do
      if (bent > self%nothing) error = sqrt(shift/bent)
      if (bent > self%nothing .and. self%strained) error = max(error, in_moments*sqrt(moment/largest))
      ! Where only the motion is asked for, of which they are a small part
      if (.not. self%shown .and. self%way > deflection) error = error*deflection/self%way
      if (.not. (self%free .and. self%heavy > 0.0_wp .and. self%swung(2) > 0.0_wp)) return
      if (self%swung(1) <= little*sqrt(0.5_wp*self%swung(2)*self%looks)) return
      error = max(error, merge(2.0_wp, 1.0_wp, self%pulled)*self%swing*sqrt(self%swung(2)/self%swung(1))* &
         & max(0.0_wp, self%span(2) - self%span(1)))
   end function phase_error

   !> Joins an analysis to those before it.
   subroutine join_phases(part, whole)
      type(phase_type), intent(in) :: part
      type(phase_type), intent(inout) :: whole
      if (.not. part%made) return
      if (.not. whole%made) then
         whole = part
      else if (size(part%error) == size(whole%error)) then
         where (part%late > whole%late)
            whole%error = part%error
            whole%frequency = part%frequency
         end where
         whole%late = max(whole%late, part%late)
         whole%most = max(whole%most, part%most)
         whole%speed = whole%speed + part%speed
         whole%acceleration = whole%acceleration + part%acceleration
         whole%swing = max(whole%swing, part%swing)
         whole%swung = whole%swung + part%swung
         whole%looks = whole%looks + part%looks
         whole%way = max(whole%way, part%way)
         whole%span = [min(whole%span(1), part%span(1)), max(whole%span(2), part%span(2))]
      end if
   end subroutine join_phases

   !> Saves or restores its memory.
   subroutine exchange_phase(self, snapshot)
      class(phase_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%exchange('made', self%made)
      call snapshot%keep('part', self%part)
      call snapshot%keep('size', self%size)
      call snapshot%keep('frequency', self%frequency)
      call snapshot%keep('forgets', self%forgets)
      call snapshot%keep('error', self%error)
      call snapshot%exchange('heavy', self%heavy)
      call snapshot%exchange('swing', self%swing)
      call snapshot%exchange('looks', self%looks)
      call snapshot%exchange('home', self%home)
      call snapshot%exchange('way', self%way)
      call snapshot%keep('late', self%late)
      call snapshot%keep('most', self%most)
      call snapshot%keep('speed', self%speed)
      call snapshot%keep('acceleration', self%acceleration)
      call snapshot%exchange('swung', self%swung)
      call snapshot%exchange('span', self%span)
      ! Not saved: n, grounded, free, shown, strained, pulled, nothing
   end subroutine exchange_phase

end module limber_monitor_lumping_phase
