!> Errors by vibrations that an integrator does not follow. Their accelerations, which the integrator watches, times what a
!> vibration of unit acceleration makes in each channel and envelope. Floor: analysis. Source: doc/theory, eqs. (5.38)-(5.41).
module limber_analysis_unfollowed
   use limber_base_finite, only: dsyev
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text, newline
   use limber_scene_sampling, only: sample_type
   use limber_scene_scene, only: scene_type
   use limber_deck_difference_terms, only: size_of_terms
   use limber_integrator_integrator, only: constraint_limit
   use limber_integrator_unfollowed_vibrations, only: ringing_type
   use limber_model_model, only: dynamics_type, model_type
   use limber_output_channel_values, only: recorder_type, new_recorder, channel_values, sample_width
   use limber_multibody_equations_of_motion, only: linearise, accelerations
   use limber_multibody_system, only: system_type
   implicit none
   private
   public :: unfollowed_type, start_unfollowed, watch_channels, unfollowed_warning, shows_vibrations

   !> Samples of a run at which the channels of vibrations are found; internal forces of an envelope
   integer, parameter :: looks = 4, kinds = 3
   !> Part of the largest value of a channel that may be lost; part of the largest channel of the same unit below which one is
   !> small; part of the scene within which joints hold one at zero
   real(wp), parameter :: allowed = 1.0e-2_wp, nothing = 1.0e-4_wp, held = constraint_limit
   !> Their names in an envelope
   character(*), parameter :: forces(kinds) = [character(14) :: 'axial force', 'shear force', 'bending moment']

   !> What is known of the channels, and behind them of axial force, shear force and bending moment of each envelope
   type :: unfollowed_type
      !> Whether accelerations or forces are asked for, and something can vibrate
      logical :: watched = .false.
      !> Largest magnitude at a sample (asked)
      real(wp), allocatable :: largest(:)
      !> The same of the terms that cancel in it; of envelopes zero (asked)
      real(wp), allocatable :: terms(:)
      !> Largest change by a vibration of unit acceleration of each elastic coordinate (asked, nw)
      real(wp), allocatable :: reach(:, :)
      !> Bodies of the envelopes
      integer, allocatable, private :: bodies(:)
      !> First entry of the same unit (asked)
      integer, allocatable, private :: alike(:)
      !> Exponents of length, time and mass (3, asked), and length of the scene
      integer, allocatable, private :: exponents(:, :)
      real(wp), private :: length = 1.0_wp
      !> Channels of disturbed states; the run's own recorder remembers turns and envelopes
      type(recorder_type), private :: recorder
      !> Scratch: coordinates, accelerations undisturbed and disturbed (nq)
      real(wp), allocatable, private :: q(:), a(:), moved(:)
      !> Scratch: samples and internal forces of the envelopes (sample_width), (kinds, sections of all)
      real(wp), allocatable, private :: base(:), values(:), sections(:, :), others(:, :)
   contains
      procedure :: exchange => exchange_unfollowed
   end type unfollowed_type

contains

   !> Begins to watch.
   subroutine start_unfollowed(self, scene)
      type(unfollowed_type), intent(inout) :: self
      type(scene_type), intent(in) :: scene
      integer :: i, n, asked
      self%recorder = new_recorder(scene%system, scene%q)
      associate (system => scene%system)
         self%watched = self%recorder%needs_accelerations .and. any(system%layout%n > 0)
         if (.not. self%watched) return
         self%bodies = pack([(i, i=1, size(system%model%bodies))], system%model%bodies%envelope)
         n = 0
         do i = 1, size(self%bodies)
            n = n + size(self%recorder%efforts(self%bodies(i))%extremes, 3)
         end do
         asked = size(system%model%channels) + kinds*size(self%bodies)
         allocate (self%largest(asked), self%terms(asked), self%reach(asked, system%layout%nw), source=0.0_wp)
         self%alike = first_alike(system%model, asked)
         self%exponents = exponents_of(system%model, asked)
         self%length = system%model%length
         associate (nq => system%layout%nq, width => sample_width(system))
            allocate (self%q(nq), self%a(nq), self%moved(nq), self%base(width), self%values(width), self%sections(kinds, n), &
               & self%others(kinds, n), source=0.0_wp)
         end associate
      end associate
   end subroutine start_unfollowed

   !> Takes a sample; at some of them finds what vibrations make of it.
   subroutine watch_channels(self, scene, ringing, t, dynamics, recorder, sample)
      type(unfollowed_type), intent(inout) :: self
      !> Its workspace becomes that of a disturbed state
      type(scene_type), intent(inout) :: scene
      type(ringing_type), intent(in) :: ringing
      !> Time of the sample
      real(wp), intent(in) :: t
      type(dynamics_type), intent(in) :: dynamics
      !> Of the run, with its envelopes
      type(recorder_type), intent(in) :: recorder
      !> As it was recorded
      type(sample_type), intent(in) :: sample
      integer :: i, n, before(2)
      logical :: found
      if (.not. self%watched) return
      n = size(scene%system%model%channels)
      self%largest(:n) = max(self%largest(:n), abs(sample%values(:n)))
      call note_terms(self, scene%system%model, recorder)
      if (mod(sample%next, max(1, dynamics%outputs/looks)) /= 0) return
      do i = 1, size(self%bodies)
         associate (extremes => recorder%efforts(self%bodies(i))%extremes)
            self%largest(n + kinds*(i - 1) + 1:n + kinds*i) = maxval(maxval(abs(extremes(:kinds, :, :)), dim=3), dim=2)
         end associate
      end do
      associate (work => scene%work)
         before = [work%evaluations, work%matrix%factorisations]
         self%q = sample%q
         call evaluate(self, scene, t, sample%v, self%base, self%sections, self%a, found)
         do i = 1, size(scene%system%layout%n)
            if (found) call disturb(self, scene, ringing, t, sample%v, i)
         end do
         work%evaluations = before(1)
         work%matrix%factorisations = before(2)
      end associate
   end subroutine watch_channels

   !> Notes how large the terms of the channels are.
   pure subroutine note_terms(self, model, recorder)
      type(unfollowed_type), intent(inout) :: self
      type(model_type), intent(in) :: model
      !> Behind a sample
      type(recorder_type), intent(in) :: recorder
      integer :: i, at
      at = 0
      do i = 1, size(model%channels)
         associate (channel => model%channels(i))
            self%terms(i) = max(self%terms(i), size_of_terms(channel%expression, &
               & recorder%found(recorder%which(at + 1:at + size(channel%quantities)))))
            at = at + size(channel%quantities)
         end associate
      end do
   end subroutine note_terms

   !> What the vibrations of one body make of it, eq. (5.39): each elastic coordinate is disturbed.
   subroutine disturb(self, scene, ringing, t, v, body)
      type(unfollowed_type), intent(inout) :: self
      type(scene_type), intent(inout) :: scene
      type(ringing_type), intent(in) :: ringing
      real(wp), intent(in) :: t
      !> Velocities (nq)
      real(wp), contiguous, intent(in) :: v(:)
      integer, intent(in) :: body
      !> Disturbance, in parts of the size of the body
      real(wp), parameter :: small = 1.0e-7_wp
      real(wp), dimension(scene%system%layout%n(body), scene%system%layout%n(body)) :: pushed
      real(wp) :: effect(size(self%largest), scene%system%layout%n(body)), own, step
      integer :: k, first, last
      logical :: found
      first = scene%system%layout%w(body) + 3
      last = first - 1 + scene%system%layout%n(body)
      if (.not. any(ringing%lost(first:last) > 0.0_wp .or. ringing%top(first:last) > 0.0_wp)) return
      associate (model => scene%system%model, from => scene%system%layout%q(body) + 3)
         step = small*model%bodies(body)%size/model%bodies(body)%largest_shape
         do k = 1, size(pushed, 2)
            own = self%q(from + k)
            self%q(from + k) = own + step
            call evaluate(self, scene, t, v, self%values, self%others, self%moved, found)
            self%q(from + k) = own
            if (.not. found) return
            pushed(:, k) = (self%moved(from + 1:from + size(pushed, 1)) - self%a(from + 1:from + size(pushed, 1)))/step
            call add_changes(self, size(model%channels), effect(:, k))
         end do
         call note_reach(effect/step, pushed, model%bodies(body)%reduced%omega2, self%reach(:, first:last))
      end associate
   end subroutine disturb

   !> Changes of the channels, and of the envelopes: the largest along each body, in its place.
   pure subroutine add_changes(self, channels, change)
      type(unfollowed_type), intent(in) :: self
      integer, intent(in) :: channels
      !> (asked)
      real(wp), intent(out) :: change(:)
      integer :: i, k, first, last, at
      change(:channels) = self%values(:channels) - self%base(:channels)
      last = 0
      do i = 1, size(self%bodies)
         first = last + 1
         last = last + size(self%recorder%efforts(self%bodies(i))%extremes, 3)
         do k = 1, kinds
            at = first - 1 + maxloc(abs(self%others(k, first:last) - self%sections(k, first:last)), dim=1)
            change(channels + kinds*(i - 1) + k) = self%others(k, at) - self%sections(k, at)
         end do
      end do
   end subroutine add_changes

   !> Largest changes by a vibration of unit acceleration of each coordinate, eq. (5.39): without what joints hold of it, and
   !> without motions that are much slower.
   subroutine note_reach(effect, pushed, omega2, reach)
      !> Changes by unit deflections (asked, n); accelerations by them (n, n)
      real(wp), intent(in) :: effect(:, :), pushed(:, :)
      !> Squared frequencies of the coordinates (n)
      real(wp), intent(in) :: omega2(:)
      !> (asked, n)
      real(wp), intent(inout) :: reach(:, :)
      !> Part of the squared frequency of a coordinate below which a motion is slow
      real(wp), parameter :: slow = 1.0e-2_wp
      real(wp), dimension(size(omega2), size(omega2)) :: modes
      real(wp) :: value(size(omega2)), room(64*size(omega2) + 64), part(size(omega2)), root(size(omega2)), &
         & acceleration
      integer :: j, k, n, info
      n = size(omega2)
      if (.not. all(omega2 > 0.0_wp)) return
      root = sqrt(omega2)
      do k = 1, n
         modes(:, k) = -0.5_wp*(root*pushed(:, k)/root(k) + pushed(k, :)*root(k)/root)
      end do
      call dsyev('V', 'L', n, modes, n, value, room, size(room), info)
      if (info /= 0) return
      do k = 1, n
         part = 0.0_wp
         do j = 1, n
            if (value(j) > slow*omega2(k)) part = part + modes(:, j)*modes(k, j)
         end do
         acceleration = norm2(matmul(modes, value*matmul(part, modes)))
         if (acceleration > 0.0_wp) reach(:, k) = max(reach(:, k), root(k)*abs(matmul(effect, part/root))/acceleration)
      end do
   end subroutine note_reach

   !> Channels, internal forces and accelerations of a state.
   subroutine evaluate(self, scene, t, v, values, sections, a, found)
      type(unfollowed_type), intent(inout) :: self
      type(scene_type), intent(inout) :: scene
      real(wp), intent(in) :: t
      !> Velocities (nq)
      real(wp), contiguous, intent(in) :: v(:)
      !> (sample_width); (kinds, sections); (nq)
      real(wp), contiguous, intent(inout) :: values(:), sections(:, :), a(:)
      !> Whether there are any
      logical, intent(out) :: found
      type(error_type), allocatable :: error
      integer :: i, first, last
      associate (system => scene%system, work => scene%work)
         call linearise(system, work, t, self%q, error)
         found = .not. allocated(error)
         if (.not. found) return
         call accelerations(system, work, self%q, v, a)
         do i = 1, size(self%bodies)
            self%recorder%efforts(self%bodies(i))%extremes(:, 1, :) = huge(1.0_wp)
         end do
         call channel_values(self%recorder, system, work, t, self%q, v, a, values)
         found = all(abs(values) <= huge(t))
      end associate
      last = 0
      do i = 1, size(self%bodies)
         associate (extremes => self%recorder%efforts(self%bodies(i))%extremes)
            first = last + 1
            last = last + size(extremes, 3)
            sections(:, first:last) = extremes(:kinds, 1, :)
         end associate
      end do
   end subroutine evaluate

   !> A warning if something that is asked for lacks vibrations that the integrator does not follow, or has some that it keeps up.
   function unfollowed_warning(self, system, ringing, is_adams, dynamics) result(text)
      type(unfollowed_type), intent(in) :: self
      type(system_type), intent(in) :: system
      type(ringing_type), intent(in) :: ringing
      !> Whether ADAMS has run to the end
      logical, intent(in) :: is_adams
      type(dynamics_type), intent(in) :: dynamics
      !> Empty if all is well
      character(:), allocatable :: text
      character(:), allocatable :: vibration, errs
      real(wp), allocatable :: lost(:)
      real(wp) :: share, omega
      integer :: worst, body
      text = ''
      if (.not. self%watched) return
      lost = ringing%lost_of(system, rest_of(system, dynamics, is_adams))
      call find_worst(self, lost, worst, share)
      if (share <= allowed) return
      call find_vibration(system, self%reach(worst, :)*lost, body, omega)
      associate (model => system%model)
         vibration = " a vibration of body '"//model%bodies(body)%name//"' (about "//as_text(omega, 2)//' rad/'// &
            & model%units%time//')'
         errs = words(self, model, worst, share)
         if (is_adams) then
            text = 'warning: ADAMS keeps up'//vibration//' at the limit of its steps: '//errs//'; use INTEGRATOR=RADAU, or '// &
               & dynamics%finer()//newline
            return
         end if
         text = 'warning: '//dynamics%integrator
         if (dynamics%integrator == 'ADAMS') text = 'warning: RADAU'
         text = text//' does not follow'//vibration//' that loads or the start set off: '//errs//'; use INTEGRATOR=ADAMS, or'// &
            & ' loads that come more slowly than its period of '//as_text(2*acos(-1.0_wp)/omega, 2)//' '//model%units%time//newline
      end associate
   end function unfollowed_warning

   !> Whether vibrations at the limit of the steps of ADAMS are part of something that is asked for.
   logical function shows_vibrations(self, ringing) result(shows)
      type(unfollowed_type), intent(in) :: self
      type(ringing_type), intent(in) :: ringing
      real(wp) :: share
      integer :: worst
      shows = .false.
      if (.not. self%watched) return
      call find_worst(self, ringing%top, worst, share)
      shows = share > allowed
   end function shows_vibrations

   !> Acceleration below which a body is at rest: the scene is crossed once in the time of the run.
   pure real(wp) function rest_of(system, dynamics, is_adams) result(rest)
      type(system_type), intent(in) :: system
      type(dynamics_type), intent(in) :: dynamics
      logical, intent(in) :: is_adams
      !> The same by ADAMS, in units of that
      real(wp), parameter :: at_rest = 1.0e-4_wp
      rest = dynamics%tolerance
      if (is_adams) rest = max(rest, at_rest)
      rest = allowed*rest*system%model%length/(dynamics%end - dynamics%start)**2
   end function rest_of

   !> The channel or envelope that errs most, relative to its largest value, eq. (5.40).
   pure subroutine find_worst(self, lost, worst, share)
      type(unfollowed_type), intent(in) :: self
      !> Accelerations of the vibrations (nw)
      real(wp), intent(in) :: lost(:)
      !> Which; part of it
      integer, intent(out) :: worst
      real(wp), intent(out) :: share
      real(wp) :: off, scale, alike
      integer :: i
      worst = 0
      share = 0.0_wp
      do i = 1, size(self%largest)
         off = dot_product(self%reach(i, :), lost)
         alike = maxval(self%largest, mask=self%alike == self%alike(i))
         ! Joints hold it, but not the disturbed states
         if (self%largest(i) <= held*size_beside(self, i)) cycle
         scale = max(scale_of(self, i), nothing*alike)
         if (.not. off > share*scale) cycle
         worst = i
         share = off/max(scale, tiny(off))
      end do
   end subroutine find_worst

   !> How large the scene is in the unit of an entry: its length, or the largest entries whose units differ by lengths alone, forces
   !> beside moments and speeds beside rates of angles.
   pure real(wp) function size_beside(self, which) result(beside)
      type(unfollowed_type), intent(in) :: self
      integer, intent(in) :: which
      integer :: i
      beside = 0.0_wp
      associate (own => self%exponents(:, which))
         if (all(own(2:) == 0)) beside = self%length**own(1)
         do i = 1, size(self%largest)
            if (all(self%exponents(2:, i) == own(2:))) beside = max(beside, self%largest(i) &
               & *self%length**(own(1) - self%exponents(1, i)))
         end do
      end associate
   end function size_beside

   !> What an error counts beside: the largest value, or the terms where that is next to nothing beside them, eq. (5.42).
   pure real(wp) function scale_of(self, which) result(scale)
      type(unfollowed_type), intent(in) :: self
      integer, intent(in) :: which
      scale = self%largest(which)
      if (scale < nothing*self%terms(which)) scale = self%terms(which)
   end function scale_of

   !> First entry of the unit of each: channels with the same unit, forces of all envelopes, and their moments are alike.
   pure function first_alike(model, asked) result(first)
      type(model_type), intent(in) :: model
      !> Channels and forces of envelopes
      integer, intent(in) :: asked
      integer :: first(asked)
      integer :: i, j, channels
      channels = size(model%channels)
      first = [(i, i=1, asked)]
      do i = 1, channels
         do j = i - 1, 1, -1
            if (model%channels(j)%units == model%channels(i)%units) first(i) = first(j)
         end do
      end do
      do i = channels + 2, asked
         if (mod(i - channels, kinds) == 2) first(i) = first(i - 1)
         if (i > channels + kinds) first(i) = first(i - kinds)
      end do
   end function first_alike

   !> Exponents of length, time and mass in the units of channels, and of forces of envelopes (3, asked).
   pure function exponents_of(model, asked) result(exponents)
      type(model_type), intent(in) :: model
      !> Channels and forces of envelopes
      integer, intent(in) :: asked
      integer :: exponents(3, asked)
      integer :: i
      do i = 1, asked
         exponents(:, i) = [merge(2, 1, mod(i - size(model%channels), kinds) == 0), -2, 1]
         if (i <= size(model%channels)) exponents(:, i) = model%channels(i)%dimension%exponents
      end do
   end function exponents_of

   !> The vibration that makes most of an error.
   subroutine find_vibration(system, part, body, omega)
      type(system_type), intent(in) :: system
      !> Of each rate (nw)
      real(wp), intent(in) :: part(:)
      integer, intent(out) :: body
      !> [rad/time]
      real(wp), intent(out) :: omega
      integer :: i, k
      real(wp) :: most
      body = 1
      omega = 0.0_wp
      most = 0.0_wp
      do i = 1, size(system%layout%n)
         do k = 1, system%layout%n(i)
            if (.not. part(system%layout%w(i) + 2 + k) > most) cycle
            most = part(system%layout%w(i) + 2 + k)
            body = i
            omega = sqrt(system%model%bodies(i)%reduced%omega2(k))
         end do
      end do
   end subroutine find_vibration

   !> What errs, and by how much.
   function words(self, model, which, share) result(text)
      type(unfollowed_type), intent(in) :: self
      type(model_type), intent(in) :: model
      integer, intent(in) :: which
      real(wp), intent(in) :: share
      character(:), allocatable :: text
      integer :: beyond
      beyond = which - size(model%channels)
      if (beyond <= 0) then
         text = "channel '"//model%channels(which)%name//"'"
      else
         text = 'the '//trim(forces(1 + mod(beyond - 1, kinds)))//" in the envelope of body '"// &
            & model%bodies(self%bodies(1 + (beyond - 1)/kinds))%name//"'"
      end if
      text = text//' may err by about '//as_text(100*min(share, 1.0_wp), 2)//' % of '// &
         & trim(merge('its largest value', 'its terms        ', scale_of(self, which) <= self%largest(which)))
   end function words

   !> Saves or restores its memory.
   subroutine exchange_unfollowed(self, snapshot)
      class(unfollowed_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%keep('unfollowed_largest', self%largest)
      call snapshot%keep('unfollowed_reach', self%reach)
      call snapshot%keep('unfollowed_terms', self%terms)
      ! Not saved: watched, bodies, alike, exponents, length, recorder, q, a, moved, base, values, sections, others
   end subroutine exchange_unfollowed

end module limber_analysis_unfollowed
