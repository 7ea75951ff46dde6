!> Monitor of exact beams under sudden loads. Vibrations that they have too late, or not at all, as parts of the largest deflection,
!> bending moment, shear force and axial force. Floor: monitor. Source: doc/theory, eqs. (7.58)-(7.62), (7.65).
module limber_monitor_function_sudden
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_beam_exact_beam, only: exact_type, sum_along, slope_along
   use limber_beam_exact_vibrations, only: exact_vibrations_type, new_held
   use limber_beam_exact_profile, only: of_ei, of_ea
   use limber_beam_beam_mesh, only: support_type
   use limber_beam_reduced_body, only: reduced_type
   use limber_monitor_function_fading, only: fading_type, fading_of, faded, late_part
   implicit none
   private
   public :: sudden_type, start_sudden, observe_sudden, join_sudden, lost_deflection, lost_moments, lost_shears, lost_pulls
   public :: is_struck, find_brevity, share_that_stays, opposite, share
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
      !> How damping ends each vibration, those behind the last one, and those of the functions of the strain
      type(fading_type), allocatable :: fading(:), fading_along(:)
      type(fading_type) :: fading_behind
      !> Largest amplitude of each vibration, of what it is late by, and of its speed by the rate at which that fades (vibrations)
      !> [length mass^1/2]; the first without those that creep right behind a jump
      real(wp), allocatable :: most(:), late(:), swing(:), kept(:)
      !> Squares of the jumps of what the functions leave out of the bending moment, the shear force and the axial force, added up
      !> as far as they have not faded (stations, 3), of the deflection that they make, and when the last one was; their largest
      real(wp), allocatable :: ringing(:, :)
      real(wp) :: ringing_place = 0.0_wp, jumped = -huge(1.0_wp)
      real(wp), allocatable :: moment(:), shear(:), pull(:)
      real(wp) :: place = 0.0_wp
      !> Distance from each station within which it is the nearest one (stations)
      real(wp), allocatable :: around(:)
      !> Largest bending moment, shear force, axial force, and force of both directions (stations)
      real(wp), allocatable :: bent(:), sheared(:), drawn(:), pushed(:)
      !> Curvature and stretch that the functions leave out before a jump (2, stations)
      real(wp), allocatable :: before(:, :)
      !> Squared frequencies of the functions of the strain, each alone, and how much their roots are too high, relative (strains)
      real(wp), allocatable :: omega2(:), slow(:)
      !> Largest axial force of vibrations that are late (stations)
      real(wp), allocatable :: ring(:)
      !> Largest bending moment and axial force of vibrations that the start sets off
      real(wp) :: struck(2) = 0.0_wp
   contains
      procedure :: exchange => exchange_sudden
   end type sudden_type

contains

   !> Begins to watch.
   subroutine start_sudden(self, reduced, support)
      type(sudden_type), intent(out) :: self
      !> Of an exact beam
      type(reduced_type), intent(in) :: reduced
      type(support_type), intent(in) :: support
      call start_vibrations(self, reduced%exact, support)
      call start_fading(self, reduced)
   end subroutine start_sudden

   !> The vibrations.
   subroutine start_vibrations(self, exact, support)
      type(sudden_type), intent(inout) :: self
      type(exact_type), intent(in) :: exact
      type(support_type), intent(in) :: support
      real(wp) :: place(exact%stations)
      integer :: k
      self%support = support
      call new_held(exact, support, self%held)
      associate (n => self%held%count, m => exact%stations)
         allocate (self%most(n), self%late(n), self%swing(n), self%kept(n), source=0.0_wp)
         allocate (self%ringing(m, 3), source=0.0_wp)
         allocate (self%moment(m), self%shear(m), self%bent(m), self%sheared(m), self%drawn(m), self%pushed(m), self%pull(m), &
            & self%ring(m), source=0.0_wp)
         allocate (self%before(2, m), source=0.0_wp)
         allocate (self%around(m))
         do k = 1, m
            self%around(k) = merge(exact%s(k), 0.5_wp*(exact%s(k) - exact%s(max(1, k - 1))), k == 1)
            self%around(k) = max(self%around(k), merge(exact%total - exact%s(k), 0.5_wp*(exact%s(min(m, k + 1)) - exact%s(k)), &
               & k == m))
         end do
      end associate
      allocate (self%omega2(exact%strains - exact%shears), self%slow(exact%strains - exact%shears))
      do k = 1, size(self%omega2)
         place = sum_along(exact, exact%chi(1, k, :)) - sum(exact%base*exact%chi(1, k, :))
         self%omega2(k) = sum(exact%weight*exact%section(of_ea, :)*exact%chi(1, k, :)**2) &
            & /max(sum(exact%mass(:exact%stations)*place**2), tiny(place))
         self%slow(k) = excess_of(exact, place, self%omega2(k))
      end do
   end subroutine start_vibrations

   !> Ratios of their damping by that of the beam's coordinates, section 7.14.
   subroutine start_fading(self, reduced)
      type(sudden_type), intent(inout) :: self
      type(reduced_type), intent(in) :: reduced
      real(wp) :: ratio(self%held%count), along(size(self%omega2)), shape(reduced%exact%angles)
      integer :: j, k, a
      ratio = 0.0_wp
      along = 0.0_wp
      a = reduced%exact%angles
      if (allocated(reduced%damping)) then
         if (size(reduced%damping, 1) == reduced%n) then
            do j = 1, self%held%count
               shape = self%held%part(j, :)*self%held%omega2(j)/reduced%omega2(:a)
               ratio(j) = 0.5_wp*dot_product(shape, matmul(reduced%damping(:a, :a), shape))/sqrt(self%held%omega2(j))
            end do
            do k = 1, size(along)
               along(k) = 0.5_wp*reduced%damping(a + k, a + k)*sqrt(self%omega2(k))/reduced%omega2(a + k)
            end do
         end if
      end if
      self%fading = fading_of(ratio, self%held%omega2(:size(ratio)))
      self%fading_along = fading_of(along, self%omega2)
      j = self%held%count
      if (j > 0) self%fading_behind = fading_of(minval(ratio(max(1, j - 1):)), self%held%omega2(j))
   end subroutine start_fading

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
   subroutine observe_sudden(self, exact, kind, t, eta, rate, acceleration, lack, forces)
      type(sudden_type), intent(inout) :: self
      type(exact_type), intent(in) :: exact
      !> One of at_rest, ...
      integer, intent(in) :: kind
      !> Time; coordinates less those at rest, their rates and second derivatives (n)
      real(wp), intent(in) :: t, eta(:), rate(:), acceleration(:)
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
            if (self%fading(j)%creeps) self%swing(j) = max(self%swing(j), abs(dot_product(held%part(j, :), rate(:a))) &
               & /self%fading(j)%fast, amplitude*held%omega2(j)/self%fading(j)%fast**2)
            ! What creeps follows soon behind a jump: until then all that is lacking there counts, below
            if (is_fresh(self, self%fading(j), kind, t)) cycle
            self%kept(j) = max(self%kept(j), amplitude)
            self%late(j) = max(self%late(j), amplitude*late_part(self%fading(j), held%omega2(j), held%error(j), t - self%begun, &
               & opposite))
         end do
         if (is_sudden(kind)) call fade(self, t)
         call observe_stretch(self, exact, kind, t, eta(a + 1:), acceleration(a + 1:), lack(2, :))
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
      self%moment = max(self%moment, self%ringing(:, 1))
      self%shear = max(self%shear, self%ringing(:, 2))
      self%pull = max(self%pull, self%ringing(:, 3))
      self%place = max(self%place, self%ringing_place)
   end subroutine observe_sudden

   !> Whether loads have jumped right before a state.
   elemental logical function is_sudden(kind)
      integer, intent(in) :: kind
      is_sudden = kind == at_start .or. kind == behind_break
   end function is_sudden

   !> Whether what creeps has not followed the last jump yet.
   pure logical function is_fresh(self, fading, kind, t) result(fresh)
      type(sudden_type), intent(in) :: self
      type(fading_type), intent(in) :: fading
      integer, intent(in) :: kind
      real(wp), intent(in) :: t
      !> Until so many times its rate have passed
      real(wp), parameter :: soon = 5.0_wp
      fresh = fading%creeps .and. is_sudden(kind)
      if (fading%creeps .and. .not. fresh) fresh = t - self%jumped < soon/max(fading%fast, 1/sqrt(huge(t)))
   end function is_fresh

   !> What the time since the last jump leaves of those before.
   subroutine fade(self, t)
      type(sudden_type), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp) :: along
      along = 0.0_wp
      if (size(self%fading_along) > 0) along = minval(self%fading_along%fast)
      if (self%jumped > -huge(t)) then
         self%ringing(:, :2) = self%ringing(:, :2)*faded(self%fading_behind%fast, t - self%jumped)
         self%ringing(:, 3) = self%ringing(:, 3)*faded(along, t - self%jumped)
         self%ringing_place = self%ringing_place*faded(self%fading_behind%slow, t - self%jumped)
      end if
      self%jumped = t
   end subroutine fade

   !> The same along the axis, eq. (7.65): each function of the strain vibrates by itself, the upper half of them is late at once,
   !> the others in time.
   subroutine observe_stretch(self, exact, kind, t, eta, acceleration, lack)
      type(sudden_type), intent(inout) :: self
      type(exact_type), intent(in) :: exact
      integer, intent(in) :: kind
      real(wp), intent(in) :: t
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
         if (2*b <= size(self%omega2)) late = late_part(self%fading_along(b), self%omega2(b), self%slow(b), &
            & t - self%begun, opposite)/opposite
         if (is_fresh(self, self%fading_along(b), kind, t)) late = 0.0_wp
         ring = ring + late*abs(acceleration(b)/self%omega2(b)*exact%chi(1, b, :))
      end do
      self%ring = max(self%ring, exact%section(of_ea, :)*ring)
      if (kind == at_start) self%struck(2) = maxval(exact%section(of_ea, :)*ring)
      if (size(self%omega2) == 0) return
      associate (ringing => self%ringing(:, 3))
         if (kind == at_start) ringing = ringing + (exact%section(of_ea, :)*lack*share(loads, presents))**2
         if (kind == behind_break) ringing = ringing + (exact%section(of_ea, :)*(lack - self%before(2, :)))**2
      end associate
   end subroutine observe_stretch

   !> A part of what it makes with the rest.
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
      self%ringing(:, 1) = self%ringing(:, 1) + moment**2
      self%ringing(:, 2) = self%ringing(:, 2) + slope_along(exact, moment)**2
      place = sum_along(exact, curvature) - sum(exact%base*curvature)
      arm = exact%s - exact%origin
      place = sum_along(exact, place) - sum(exact%base*place)
      ! Measured from the chord, or where nothing holds the rotation from the axis that goes through the middle of the motion
      if (self%support%w_start .and. self%support%w_end) then
         place = place - arm*place(size(place))/arm(size(arm))
      else if (.not. self%support%theta_start .and. .not. self%support%theta_end) then
         place = place - arm*sum(exact%weight*arm*place)/sum(exact%weight*arm**2)
      end if
      self%ringing_place = self%ringing_place + maxval(place**2)
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
      real(wp) :: height(self%held%count), late(self%held%count), part(self%held%count)
      height = 0.0_wp
      if (self%held%count > 0) height = maxval(abs(self%held%place), dim=1)
      late = self%late
      part = self%most
      where (self%fading%creeps)
         part = min(self%most, 2*self%swing)
         late = part*min(1.0_wp, self%fading%most_late*self%held%error(:size(part)))
      end where
      associate (behind => self%fading_behind)
         lost = sum(late*height) + max(left_over(part*height), goes_beyond(behind)*share_of(behind)*sqrt(self%place))
      end associate
   end function lost_deflection

   !> How far what jumps goes, in parts of the jump, several together.
   elemental real(wp) function goes_beyond(fading)
      type(fading_type), intent(in) :: fading
      goes_beyond = 1 + (beyond - 1)*fading%overshoot
   end function goes_beyond

   !> Part of the deflection of what jumps that vibrations make which creep back: forces that are gone soon move them less than they
   !> would at rest, section 7.14.
   elemental real(wp) function share_of(behind) result(part)
      type(fading_type), intent(in) :: behind
      part = 1.0_wp
      if (behind%creeps) part = min(1.0_wp, 2*behind%slow/behind%fast)
   end function share_of

   !> Part of the deflection of what is lacking at a state: right behind jumps what creeps has not moved.
   pure real(wp) function share_that_stays(self, kind, t) result(part)
      type(sudden_type), intent(in) :: self
      integer, intent(in) :: kind
      real(wp), intent(in) :: t
      part = 1.0_wp
      if (is_fresh(self, self%fading_behind, kind, t)) part = share_of(self%fading_behind)
   end function share_that_stays

   !> Whether what is lost of bending moments is lost for an instant behind jumps alone, and about how long [time].
   pure subroutine find_brevity(self, brief, time)
      type(sudden_type), intent(in) :: self
      logical, intent(out) :: brief
      real(wp), intent(out) :: time
      real(wp) :: jumps, others
      !> Part of the whole
      real(wp), parameter :: little = 0.1_wp
      time = 0.0_wp
      brief = self%fading_behind%creeps
      if (.not. brief) return
      jumps = sqrt(maxval(self%moment))
      others = left_over(self%kept*maxval(abs(self%held%moment), dim=1)) + maxval(matmul(abs(self%held%moment), self%late))
      brief = others < little*jumps
      ! Until a tenth of it is left
      time = log(10.0_wp)/self%fading_behind%fast
   end subroutine find_brevity

   !> Bending moments that are off at most (stations).
   pure function lost_moments(self) result(lost)
      type(sudden_type), intent(in) :: self
      real(wp) :: lost(size(self%moment))
      if (self%fading_behind%creeps) then
         ! No wave runs along the beam: what jumps is off where it jumps, here as far as the next station
         lost = sqrt(self%moment) + self%around*sqrt(self%shear)
      else
         lost = goes_beyond(self%fading_behind)*sqrt(maxval(self%moment))
      end if
      call add_vibrations(self, self%held%moment, lost)
   end function lost_moments

   !> Shear forces that are off at most (stations).
   pure function lost_shears(self) result(lost)
      type(sudden_type), intent(in) :: self
      real(wp) :: lost(size(self%shear))
      lost = goes_beyond(self%fading_behind)*sqrt(maxval(self%shear))
      call add_vibrations(self, self%held%shear, lost)
   end function lost_shears

   !> Axial forces that are off at most (stations).
   pure function lost_pulls(self) result(lost)
      type(sudden_type), intent(in) :: self
      real(wp) :: lost(size(self%pull))
      lost = beyond
      if (size(self%fading_along) > 0) lost = maxval(goes_beyond(self%fading_along))
      lost = opposite*self%ring + lost*sqrt(maxval(self%pull))
   end function lost_pulls

   !> What is off of moments and shear forces by jumps, or by vibrations that are missing, if that is more, and by late ones.
   pure subroutine add_vibrations(self, field, lost)
      type(sudden_type), intent(in) :: self
      !> Of unit amplitudes (stations, vibrations); by jumps, then all (stations)
      real(wp), intent(in) :: field(:, :)
      real(wp), intent(inout) :: lost(:)
      real(wp) :: height(self%held%count)
      height = 0.0_wp
      if (self%held%count > 0) height = maxval(abs(field), dim=1)
      lost = max(left_over(self%kept*height), lost) + matmul(abs(field), self%late)
   end subroutine add_vibrations

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
      whole%swing = max(whole%swing, part%swing)
      whole%kept = max(whole%kept, part%kept)
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
      call snapshot%keep('swing', self%swing)
      call snapshot%keep('kept', self%kept)
      call snapshot%keep('ringing', self%ringing)
      call snapshot%exchange('ringing_place', self%ringing_place)
      call snapshot%exchange('jumped', self%jumped)
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
      ! Not saved: held, support, fading, fading_along, fading_behind, around, omega2, slow
   end subroutine exchange_sudden

end module limber_monitor_function_sudden
