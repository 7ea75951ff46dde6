!> Monitor of exact beams under sudden loads. Vibrations that they have too late, or not at all, as parts of the largest deflection,
!> bending moment, shear force and axial force. Floor: monitor. Source: doc/theory, eqs. (7.58)-(7.62), (7.65).
module limber_monitor_function_sudden
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_beam_exact_beam, only: exact_type, sum_along, slope_along
   use limber_beam_exact_vibrations, only: exact_vibrations_type, new_held
   use limber_beam_exact_profile, only: of_ei, of_ea
   use limber_beam_beam_mesh, only: support_type
   implicit none
   private
   public :: sudden_type, start_sudden, observe_sudden, join_sudden, lost_deflection, lost_moments, lost_shears, lost_pulls
   public :: is_struck
   public :: at_rest, in_motion, at_start, before_break, behind_break

   !> What a state is that is looked at: at rest; within a motion; its first one; on both sides of an instant at which loads jump
   integer, parameter :: at_rest = 0, in_motion = 1, at_start = 2, before_break = 3, behind_break = 4
   !> Largest error of a vibration in parts of its amplitude; most that functions which are missing can have, in parts of the last
   !> ones; how far a vibration goes beyond the load that sets it off, for each of several
   real(wp), parameter :: opposite = 1.5_wp, most_left = 4.0_wp, beyond = 1.4_wp

   !> One beam
   type :: sudden_type
      type(exact_vibrations_type) :: held
      type(support_type) :: support
      !> Time of the first state, negative huge before
      real(wp) :: begun = -huge(1.0_wp)
      !> Largest amplitude of each vibration, and of what it is late by (vibrations) [length mass^1/2]
      real(wp), allocatable :: most(:), late(:)
      !> Squares of the jumps of what the functions leave out of the bending moment and the shear force, added up (stations), and of
      !> the deflection that they make
      real(wp), allocatable :: moment(:), shear(:)
      real(wp) :: place = 0.0_wp
      !> Largest bending moment, shear force, axial force, and force of both directions (stations)
      real(wp), allocatable :: bent(:), sheared(:), drawn(:), pushed(:)
      !> Curvature and stretch that the functions leave out before a jump (2, stations)
      real(wp), allocatable :: before(:, :)
      !> Squared frequencies of the functions of the strain, each alone, and how much their roots are too high, relative (strains)
      real(wp), allocatable :: omega2(:), slow(:)
      !> Squares of the jumps of what the functions leave out of the axial force, added up, and largest axial force of
      !> vibrations that are late (stations)
      real(wp), allocatable :: pull(:), ring(:)
      !> Largest bending moment and axial force of vibrations that the start sets off
      real(wp) :: struck(2) = 0.0_wp
   contains
      procedure :: exchange => exchange_sudden
   end type sudden_type

contains

   !> Begins to watch.
   subroutine start_sudden(self, exact, support)
      type(sudden_type), intent(out) :: self
      type(exact_type), intent(in) :: exact
      type(support_type), intent(in) :: support
      real(wp) :: place(exact%stations)
      integer :: k
      self%support = support
      call new_held(exact, support, self%held)
      associate (n => self%held%count, m => exact%stations)
         allocate (self%most(n), self%late(n), source=0.0_wp)
         allocate (self%moment(m), self%shear(m), self%bent(m), self%sheared(m), self%drawn(m), self%pushed(m), self%pull(m), &
            & self%ring(m), source=0.0_wp)
         allocate (self%before(2, m), source=0.0_wp)
      end associate
      allocate (self%omega2(exact%strains - exact%shears), self%slow(exact%strains - exact%shears))
      do k = 1, size(self%omega2)
         place = sum_along(exact, exact%chi(1, k, :)) - sum(exact%base*exact%chi(1, k, :))
         self%omega2(k) = sum(exact%weight*exact%section(of_ea, :)*exact%chi(1, k, :)**2) &
            & /max(sum(exact%mass(:exact%stations)*place**2), tiny(place))
         self%slow(k) = excess_of(exact, place, self%omega2(k))
      end do
   end subroutine start_sudden

   !> By how much the frequency of a function of the strain is too high, relative: the axial force that its own inertia asks for
   !> makes a better one, eq. (7.64).
   pure real(wp) function excess_of(exact, place, omega2) result(excess)
      type(exact_type), intent(in) :: exact
      !> Displacement along the axis (stations), and squared frequency
      real(wp), intent(in) :: place(:), omega2
      real(wp) :: force(size(place)), better
      force = sum_along(exact, exact%mass(:exact%stations)/exact%weight*place)
      ! What lies beyond, seen from the origin of the frame, which is held
      where (exact%s > exact%origin) force = force - sum(exact%mass(:exact%stations)*place)
      better = sum(exact%mass(:exact%stations)*place**2)/max(sum(exact%weight*force**2/exact%section(of_ea, :)), tiny(place))
      excess = max(0.0_wp, 0.5_wp*(omega2/better - 1))
   end function excess_of

   !> Takes a state.
   subroutine observe_sudden(self, exact, kind, t, eta, acceleration, lack, forces)
      type(sudden_type), intent(inout) :: self
      type(exact_type), intent(in) :: exact
      !> One of at_rest, ...
      integer, intent(in) :: kind
      !> Time; coordinates less those at rest, and their second derivatives (n)
      real(wp), intent(in) :: t, eta(:), acceleration(:)
      !> Curvature and stretch that the functions leave out (2, stations); axial force, shear force, bending moment by equilibrium
      !> (3, stations)
      real(wp), intent(in) :: lack(:, :), forces(:, :)
      real(wp) :: amplitude, present(self%held%count), load(self%held%count)
      integer :: j
      if (kind == at_rest) return
      if (.not. self%begun > -huge(t)) self%begun = t
      self%bent = max(self%bent, abs(forces(3, :)))
      self%sheared = max(self%sheared, abs(forces(2, :)))
      self%drawn = max(self%drawn, abs(forces(1, :)))
      self%pushed = max(self%pushed, sqrt(forces(1, :)**2 + forces(2, :)**2))
      associate (held => self%held, a => exact%angles)
         do j = 1, held%count
            amplitude = abs(dot_product(held%part(j, :), acceleration(:a)))/held%omega2(j)
            present(j) = abs(dot_product(held%part(j, :), eta(:a)))
            load(j) = amplitude
            self%most(j) = max(self%most(j), amplitude)
            self%late(j) = max(self%late(j), amplitude*min(opposite, sqrt(held%omega2(j))*held%error(j)*(t - self%begun)))
         end do
         call observe_stretch(self, exact, kind, t - self%begun, eta(a + 1:), acceleration(a + 1:), lack(2, :))
         select case (kind)
         case (at_start)
            if (held%count > 0) self%struck(1) = maxval(load*maxval(abs(held%moment), dim=1))
            ! Of what is in balance nothing vibrates
            j = (held%count + 1)/2
            if (held%count > 0) call add_jump(self, exact, lack(1, :)*share(sum(load(j:)*maxval(abs(held%moment(:, j:)), dim=1)), &
               & sum(present(j:)*maxval(abs(held%moment(:, j:)), dim=1))))
         case (before_break)
            self%before = lack
         case (behind_break)
            call add_jump(self, exact, lack(1, :) - self%before(1, :))
         end select
      end associate
   end subroutine observe_sudden

   !> The same along the axis, eq. (7.65): each function of the strain vibrates by itself, the upper half of them is late at once,
   !> the others in time.
   subroutine observe_stretch(self, exact, kind, time, eta, acceleration, lack)
      type(sudden_type), intent(inout) :: self
      type(exact_type), intent(in) :: exact
      integer, intent(in) :: kind
      !> Since the first state
      real(wp), intent(in) :: time
      !> Coordinates of the strain less those at rest, and their second derivatives (strains, then those of the shear)
      real(wp), intent(in) :: eta(:), acceleration(:)
      !> Stretch that the functions leave out (stations)
      real(wp), intent(in) :: lack(:)
      real(wp) :: ring(size(lack)), loads, presents, late
      integer :: b
      loads = 0.0_wp
      presents = 0.0_wp
      ring = 0.0_wp
      do b = 1, size(self%omega2)
         loads = loads + abs(acceleration(b))/self%omega2(b)*maxval(abs(exact%chi(1, b, :)))
         presents = presents + abs(eta(b))*maxval(abs(exact%chi(1, b, :)))
         late = 1.0_wp
         if (2*b <= size(self%omega2)) late = min(1.0_wp, sqrt(self%omega2(b))*self%slow(b)*time/opposite)
         ring = ring + late*abs(acceleration(b)/self%omega2(b)*exact%chi(1, b, :))
      end do
      self%ring = max(self%ring, exact%section(of_ea, :)*ring)
      if (kind == at_start) self%struck(2) = maxval(exact%section(of_ea, :)*ring)
      if (size(self%omega2) == 0) return
      if (kind == at_start) self%pull = self%pull + (exact%section(of_ea, :)*lack*share(loads, presents))**2
      if (kind == behind_break) self%pull = self%pull + (exact%section(of_ea, :)*(lack - self%before(2, :)))**2
   end subroutine observe_stretch

   pure real(wp) function share(part, rest)
      real(wp), intent(in) :: part, rest
      share = part/max(part + rest, tiny(part))
   end function share

   !> Adds a jump of the curvature that is left out.
   subroutine add_jump(self, exact, curvature)
      type(sudden_type), intent(inout) :: self
      type(exact_type), intent(in) :: exact
      real(wp), intent(in) :: curvature(:)
      real(wp) :: moment(size(curvature)), place(size(curvature)), arm(size(curvature))
      moment = exact%section(of_ei, :)*curvature
      self%moment = self%moment + moment**2
      self%shear = self%shear + slope_along(exact, moment)**2
      place = sum_along(exact, curvature) - sum(exact%base*curvature)
      arm = exact%s - exact%origin
      place = sum_along(exact, place) - sum(exact%base*place)
      ! Measured from the chord, or where nothing holds the rotation from the axis that goes through the middle of the motion
      if (self%support%w_start .and. self%support%w_end) then
         place = place - arm*place(size(place))/arm(size(arm))
      else if (.not. self%support%theta_start .and. .not. self%support%theta_end) then
         place = place - arm*sum(exact%weight*arm*place)/sum(exact%weight*arm**2)
      end if
      self%place = self%place + maxval(place**2)
   end subroutine add_jump

   !> Whether it is the start, where the deck has the beam without the deflections that its loads ask for, that sets off its
   !> vibrations: those across and along it, for each excites the other.
   pure logical function is_struck(self)
      type(sudden_type), intent(in) :: self
      !> Part of the largest ones
      real(wp), parameter :: much = 0.3_wp
      real(wp) :: bent
      bent = 0.0_wp
      if (self%held%count > 0) bent = maxval(self%most*maxval(abs(self%held%moment), dim=1))
      is_struck = any(self%struck > 0.0_wp .and. self%struck >= much*[bent, maxval(self%ring)])
   end function is_struck

   !> Deflection that is off at most [length].
   pure real(wp) function lost_deflection(self) result(lost)
      type(sudden_type), intent(in) :: self
      real(wp) :: height(self%held%count)
      height = 0.0_wp
      if (self%held%count > 0) height = maxval(abs(self%held%place), dim=1)
      lost = sum(self%late*height) + max(left_over(self%most*height), beyond*sqrt(self%place))
   end function lost_deflection

   !> Bending moments that are off at most (stations).
   pure function lost_moments(self) result(lost)
      type(sudden_type), intent(in) :: self
      real(wp) :: lost(size(self%moment))
      lost = lost_forces(self, self%held%moment, self%moment)
   end function lost_moments

   !> Shear forces that are off at most (stations).
   pure function lost_shears(self) result(lost)
      type(sudden_type), intent(in) :: self
      real(wp) :: lost(size(self%shear))
      lost = lost_forces(self, self%held%shear, self%shear)
   end function lost_shears

   !> Axial forces that are off at most (stations).
   pure function lost_pulls(self) result(lost)
      type(sudden_type), intent(in) :: self
      real(wp) :: lost(size(self%pull))
      lost = opposite*self%ring + beyond*sqrt(maxval(self%pull))
   end function lost_pulls

   !> The same of moments and shear forces.
   pure function lost_forces(self, field, jump) result(lost)
      type(sudden_type), intent(in) :: self
      !> Of unit amplitudes (stations, vibrations); squares that jumped (stations)
      real(wp), intent(in) :: field(:, :), jump(:)
      real(wp) :: lost(size(jump)), height(self%held%count)
      height = 0.0_wp
      if (self%held%count > 0) height = maxval(abs(field), dim=1)
      lost = max(left_over(self%most*height), beyond*sqrt(maxval(jump)))
      lost = lost + matmul(abs(field), self%late)
   end function lost_forces

   !> What vibrations behind the last one have, if they go on as the last ones do, eq. (7.61).
   pure real(wp) function left_over(part) result(left)
      !> Of the vibrations
      real(wp), intent(in) :: part(:)
      real(wp) :: before, last
      integer :: n
      left = 0.0_wp
      n = size(part)
      if (n == 0) return
      last = maxval(part(max(1, n - 1):))
      before = last
      if (n > 2) before = maxval(part(max(1, n - 3):n - 2))
      if (.not. last > 0.0_wp) return
      left = last*min(most_left, last/max(before - last, last/most_left))
   end function left_over

   !> Joins what an analysis has seen to that of those before.
   subroutine join_sudden(part, whole)
      type(sudden_type), intent(in) :: part
      type(sudden_type), intent(inout) :: whole
      whole%most = max(whole%most, part%most)
      whole%late = max(whole%late, part%late)
      whole%moment = max(whole%moment, part%moment)
      whole%shear = max(whole%shear, part%shear)
      whole%place = max(whole%place, part%place)
      whole%bent = max(whole%bent, part%bent)
      whole%sheared = max(whole%sheared, part%sheared)
      whole%drawn = max(whole%drawn, part%drawn)
      whole%pushed = max(whole%pushed, part%pushed)
      whole%pull = max(whole%pull, part%pull)
      whole%ring = max(whole%ring, part%ring)
      whole%struck = max(whole%struck, part%struck)
   end subroutine join_sudden

   !> Saves or restores it.
   subroutine exchange_sudden(self, snapshot)
      class(sudden_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%exchange('begun', self%begun)
      call snapshot%keep('most', self%most)
      call snapshot%keep('late', self%late)
      call snapshot%keep('jump_moment', self%moment)
      call snapshot%keep('jump_shear', self%shear)
      call snapshot%exchange('jump_place', self%place)
      call snapshot%keep('bent', self%bent)
      call snapshot%keep('sheared', self%sheared)
      call snapshot%keep('drawn', self%drawn)
      call snapshot%keep('pushed', self%pushed)
      call snapshot%keep('jump_pull', self%pull)
      call snapshot%keep('ring', self%ring)
      call snapshot%exchange('struck', self%struck)
      call snapshot%keep('before', self%before)
   end subroutine exchange_sudden

end module limber_monitor_function_sudden
