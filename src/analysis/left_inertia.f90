!> What deflections in balance leave out. Velocities and inertia of the deflections themselves, found at samples from the balance
!> before and behind them, and vibrations that begin where the balance jumps. Channels and torques of drivers are compared. Floor:
!> analysis. Source: doc/theory, eq. (6.22).
!>
!>     call start_left_inertia(self, scene, step)
!>     call compare_inertia(self, scene, recorder, now) ! at samples
!>     call tell_left_inertia(self, scene, title, outcome)
module limber_analysis_left_inertia
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_analysis_static_aside, only: least_sizes, largest_force, is_place
   use limber_scene_scene, only: scene_type
   use limber_scene_outcome, only: outcome_type, warn
   use limber_model_law_breaks, only: find_breaks, changes_between, round_off
   use limber_model_model, only: analysis_step_type
   use limber_output_channel_values, only: recorder_type, channel_values, sample_width
   use limber_multibody_driven_motion, only: driven_motion_type, new_held, held_motion, balance_deflections, &
      & balance_inertia, free_accelerations
   use limber_multibody_kinematics, only: place_frames, move_frames
   use limber_multibody_layout, only: layout_type, advance, velocities_of
   use limber_multibody_multiplier_system, only: update_jacobians
   use limber_multibody_plane_vectors, only: cross
   implicit none
   private
   public :: left_inertia_type, balance_type, start_left_inertia, compare_inertia, tell_left_inertia

   !> Largest part that is not told, of what is left out all the way and of vibrations; above which only more than that is told
   real(wp), parameter :: little = 0.01_wp, little_vibration = 0.02_wp, beyond = 0.5_wp
   !> Part by which two looks may differ
   real(wp), parameter :: doubt = 0.3_wp

   !> A sample in balance
   type :: balance_type
      real(wp) :: t = 0.0_wp
      !> Coordinates (nq), rates and their derivatives (nw), multipliers (nc), values of the channels and more
      real(wp), allocatable :: q(:), w(:), a(:), lambda(:), values(:)
   end type balance_type

   !> What was seen so far; arrays over the channels, and the drivers behind them
   type :: left_inertia_type
      type(driven_motion_type) :: held
      !> First and last instant, time from one look to the next [time]; instants at which laws change
      real(wp) :: start = 0.0_wp, end = 0.0_wp, step = 0.0_wp
      real(wp), allocatable :: breaks(:)
      integer :: passed = 0
      !> What is left out all the way, when most; of vibrations the same; sizes, and the values at the first sample
      real(wp), allocatable :: left(:), left_time(:), shaken(:), shaken_time(:), size(:), first(:)
      real(wp) :: force = 0.0_wp
      logical :: used = .false.
   end type left_inertia_type

contains

   !> Begins, if there are deflections.
   subroutine start_left_inertia(self, scene, step)
      type(left_inertia_type), intent(out) :: self
      type(scene_type), intent(in) :: scene
      type(analysis_step_type), intent(in) :: step
      !> Part of the time in which the slowest body vibrates by a radian, and of the analysis
      real(wp), parameter :: of_vibration = 0.1_wp, of_all = 0.01_wp
      character(:), allocatable :: restless
      real(wp) :: slowest, width
      integer :: i, n
      slowest = huge(slowest)
      do i = 1, size(scene%system%model%bodies)
         associate (reduced => scene%system%model%bodies(i)%reduced)
            if (scene%system%layout%n(i) > 0) slowest = min(slowest, sqrt(max(minval(reduced%omega2), tiny(slowest))))
         end associate
      end do
      self%used = slowest < huge(slowest)
      if (.not. self%used) return
      self%start = step%dynamics%start
      self%end = step%dynamics%end
      self%step = min(of_vibration/slowest, of_all*(self%end - self%start))
      call find_breaks(scene%system%model, self%breaks, restless)
      width = round_off(self%start, self%end)
      if (changes_between(scene%system%model, self%start - width, self%start + width)) self%breaks = [self%start, self%breaks]
      call new_held(scene%system, self%held)
      n = size(scene%system%model%channels) + size(scene%system%model%drivers)
      allocate (self%left(n), self%left_time(n), self%shaken(n), self%shaken_time(n), self%size(n), source=0.0_wp)
   end subroutine start_left_inertia

   !> Looks at a sample, with its recorder; leaves the kinematics placed there, and the multipliers.
   subroutine compare_inertia(self, scene, recorder, now)
      type(left_inertia_type), intent(inout) :: self
      type(scene_type), intent(inout) :: scene
      type(recorder_type), intent(in) :: recorder
      type(balance_type), intent(in) :: now
      real(wp) :: found(size(self%size), 0:2)
      logical :: done(2), places(size(self%size))
      integer :: k
      found(:, 0) = present_values(scene, now%values, now%lambda)
      if (.not. allocated(self%first)) then
         allocate (self%first, source=found(:, 0))
         if (is_at_rest(self, now)) then
            call compare_jump(self, scene, recorder, now, now%t, .true.)
            do while (self%passed < size(self%breaks))
               if (self%breaks(self%passed + 1) > now%t) exit
               self%passed = self%passed + 1
            end do
         end if
      end if
      do k = 1, 2
         call with_inertia(self, scene, recorder, now, k*self%step, found(:, k), done(k))
         if (.not. done(k)) exit
      end do
      places(:) = .false.
      places(:size(scene%system%model%channels)) = is_place(scene%system%model)
      if (all(done)) then
         ! Round-off, and places where the balance jumps, are not the same from near and from farther off
         where (abs(found(:, 1) - found(:, 2)) > doubt*abs(found(:, 1) - found(:, 0))) found(:, 1) = found(:, 0)
         where (places)
            self%size = max(self%size, abs(found(:, 0) - self%first), abs(found(:, 1) - self%first))
         elsewhere
            self%size = max(self%size, abs(found(:, 0)), abs(found(:, 1)))
         end where
         call keep(abs(found(:, 1) - found(:, 0)), now%t, self%left, self%left_time)
         self%force = max(self%force, largest_force(scene%system, scene%work))
      end if
      do while (self%passed < size(self%breaks))
         if (self%breaks(self%passed + 1) > now%t) exit
         self%passed = self%passed + 1
         call compare_jump(self, scene, recorder, now, self%breaks(self%passed), .false.)
      end do
      call place_frames(scene%system%model, scene%system%layout, now%t, now%q, scene%work%kinematics)
      scene%work%lambda = now%lambda
   end subroutine compare_inertia

   !> Keeps differences that are larger than those before.
   pure subroutine keep(off, t, largest, when)
      real(wp), intent(in) :: off(:), t
      real(wp), intent(inout) :: largest(:), when(:)
      where (off > largest)
         largest = off
         when = t
      end where
   end subroutine keep

   !> Channels, and first forces or torques of drivers.
   pure function present_values(scene, values, lambda) result(found)
      type(scene_type), intent(in) :: scene
      real(wp), intent(in) :: values(:), lambda(:)
      real(wp), allocatable :: found(:)
      integer :: i, channels, drivers
      channels = size(scene%system%model%channels)
      drivers = size(scene%system%model%drivers)
      allocate (found(channels + drivers))
      found(:channels) = values(:channels)
      do i = 1, drivers
         found(channels + i) = 0.0_wp
         associate (item => scene%system%constraints(size(scene%system%model%joints) + i)%item)
            if (item%rows > 0) found(channels + i) = -lambda(item%first)
         end associate
      end do
   end function present_values

   !> Values with the velocities and accelerations of the deflections, from the balance at two other instants.
   subroutine with_inertia(self, scene, recorder, now, step, found, done)
      type(left_inertia_type), intent(inout) :: self
      type(scene_type), intent(inout) :: scene
      type(recorder_type), intent(in) :: recorder
      type(balance_type), intent(in) :: now
      !> From one instant to the next
      real(wp), intent(in) :: step
      real(wp), intent(inout) :: found(:)
      logical, intent(out) :: done
      real(wp) :: s(2), way(size(now%w), 2), w(size(now%w))
      real(wp), allocatable :: q(:), v(:), a(:), lambda(:)
      integer :: k
      s = [-step, step]
      if (now%t - step < self%start) s = [step, 2*step]
      if (now%t + step > self%end) s = [-step, -2*step]
      do k = 1, 2
         call find_way(self, scene, now, s(k), now%t + s(k), way(:, k), done)
         if (.not. done) return
      end do
      self%held%a = 2*(way(:, 2)/s(2) - way(:, 1)/s(1))/(s(2) - s(1))
      w = way(:, 1)/s(1) - 0.5_wp*s(1)*self%held%a
      allocate (q, source=now%q)
      allocate (v, source=now%q)
      allocate (a, source=now%q)
      allocate (lambda, source=now%lambda)
      call balance_inertia(scene%system, scene%work, self%held, now%t, w, q, v, a, lambda, done)
      if (done) call take_values(scene, recorder, now%t, q, v, a, lambda, found)
   end subroutine with_inertia

   !> From a sample to the balance at another instant, in the layout of the rates.
   subroutine find_way(self, scene, now, s, t, way, done)
      type(left_inertia_type), intent(inout) :: self
      type(scene_type), intent(inout) :: scene
      type(balance_type), intent(in) :: now
      !> Time from the sample, and the instant
      real(wp), intent(in) :: s, t
      real(wp), intent(out) :: way(:)
      logical, intent(out) :: done
      real(wp), allocatable :: q(:), v(:), a(:)
      call balance_at(self, scene, now, s, t, q, v, a, done)
      if (done) call find_change(scene%system%layout, now%q, q, way)
   end subroutine find_way

   !> From a place to another, in the layout of the rates.
   pure subroutine find_change(layout, from, q, change)
      type(layout_type), intent(in) :: layout
      !> Coordinates (nq)
      real(wp), intent(in) :: from(:), q(:)
      !> (nw)
      real(wp), intent(out) :: change(:)
      integer :: i, at, to
      do i = 1, size(layout%q)
         at = layout%q(i)
         to = layout%w(i)
         change(to:to + 1) = q(at:at + 1) - from(at:at + 1)
         if (.not. layout%framed(i)) cycle
         change(to + 2) = atan2(cross(from(at + 2:at + 3), q(at + 2:at + 3)), dot_product(from(at + 2:at + 3), q(at + 2:at + 3)))
         change(to + 3:to + 2 + layout%n(i)) = q(at + 4:at + 3 + layout%n(i)) - from(at + 4:at + 3 + layout%n(i))
      end do
   end subroutine find_change

   !> The balance at an instant near a sample.
   subroutine balance_at(self, scene, now, s, t, q, v, a, done)
      type(left_inertia_type), intent(inout) :: self
      type(scene_type), intent(inout) :: scene
      type(balance_type), intent(in) :: now
      !> As in `find_way`
      real(wp), intent(in) :: s, t
      !> Coordinates, velocities, accelerations (nq)
      real(wp), allocatable, intent(out) :: q(:), v(:), a(:)
      logical, intent(out) :: done
      real(wp), parameter :: stride = 0.2_wp
      integer, parameter :: most = 50
      real(wp), allocatable :: before(:)
      real(wp) :: way(size(now%w)), part
      integer :: k, n
      allocate (q, v, a, source=now%q)
      v = 0.0_wp
      a = 0.0_wp
      way = s*(now%w + 0.5_wp*s*now%a)
      n = 1 + int(min(maxval(abs(way/self%held%scale))/stride, real(most, wp)))
      self%held%w = now%w
      self%held%a = now%a
      self%held%lambda = now%lambda
      part = s/n
      do k = 1, n
         before = q
         call advance(scene%system%layout, before, part*(self%held%w + 0.5_wp*part*self%held%a), q)
         call balance_deflections(scene%system, scene%work, self%held, merge(t, now%t + k*part, k == n), q, v, a, done)
         if (.not. done) return
      end do
   end subroutine balance_at

   !> Whether drivers begin from rest: what they moved before, nobody knows; most likely nothing.
   pure logical function is_at_rest(self, now) result(rests)
      type(left_inertia_type), intent(in) :: self
      type(balance_type), intent(in) :: now
      !> Way in the time of the analysis, in units of the scene, that is none
      real(wp), parameter :: none = 1.0e-9_wp
      rests = .not. maxval(abs(now%w/self%held%scale))*(self%end - self%start) > none
   end function is_at_rest

   !> The vibration that begins where the balance, or its rate, jumps: what channels are with the deflections from before, and a
   !> quarter of a period behind rates from before, against those in balance.
   subroutine compare_jump(self, scene, recorder, now, instant, from_rest)
      type(left_inertia_type), intent(inout) :: self
      type(scene_type), intent(inout) :: scene
      type(recorder_type), intent(in) :: recorder
      type(balance_type), intent(in) :: now
      real(wp), intent(in) :: instant
      !> Whether it is the start, and all was in balance at rest before
      logical, intent(in) :: from_rest
      !> Part of the time on either side of it
      real(wp), parameter :: aside = 1.0e-9_wp
      real(wp), allocatable :: from(:), q(:)
      real(wp) :: found(size(self%size), 0:2), rate(size(now%w), 2), off, square
      logical :: done
      off = aside*(self%end - self%start)
      if (from_rest) then
         allocate (from, source=now%q)
         rate(:, 1) = 0.0_wp
         done = .true.
      else
         call balance_side(self, scene, now, instant - off, -self%step, from, rate(:, 1), done)
      end if
      if (done) call balance_side(self, scene, now, instant + off, self%step, q, rate(:, 2), done)
      if (.not. done) return
      call free_values(self, scene, recorder, instant + off, q, found(:, 0), done)
      if (done) call free_values(self, scene, recorder, instant + off, from, found(:, 1), done)
      if (.not. done) return
      rate(:, 1) = rate(:, 2) - rate(:, 1)
      call advance(scene%system%layout, q, self%step*rate(:, 1), from)
      call free_values(self, scene, recorder, instant + off, from, found(:, 2), done)
      if (.not. done) return
      associate (own => self%held%deflections)
         square = -dot_product(rate(own, 1), self%held%a(own))*self%step
         off = 0.0_wp
         if (square > 0.0_wp) off = norm2(rate(own, 1))/sqrt(square)
      end associate
      call keep(hypot(found(:, 1) - found(:, 0), off*(found(:, 2) - found(:, 0))), instant, self%shaken, self%shaken_time)
   end subroutine compare_jump

   !> The balance on one side of an instant, and its rate there.
   subroutine balance_side(self, scene, now, instant, step, q, rate, done)
      type(left_inertia_type), intent(inout) :: self
      type(scene_type), intent(inout) :: scene
      type(balance_type), intent(in) :: now
      !> Time; from there to the next two, away from the other side
      real(wp), intent(in) :: instant, step
      !> Coordinates (nq), rate (nw)
      real(wp), allocatable, intent(out) :: q(:)
      real(wp), intent(out) :: rate(:)
      logical, intent(out) :: done
      real(wp), allocatable :: next(:), v(:), a(:)
      real(wp) :: change(size(rate)), t
      integer :: k
      rate = 0.0_wp
      call balance_at(self, scene, now, instant - now%t, instant, q, v, a, done)
      do k = 1, 2
         t = instant + k*step
         if (done) call balance_at(self, scene, now, t - now%t, t, next, v, a, done)
         if (.not. done) return
         call find_change(scene%system%layout, q, next, change)
         rate = rate + merge(4, -1, k == 1)*change/(2*step)
      end do
   end subroutine balance_side

   !> Values with free deflections, which rest in their frame.
   subroutine free_values(self, scene, recorder, t, q, found, done)
      type(left_inertia_type), intent(inout) :: self
      type(scene_type), intent(inout) :: scene
      type(recorder_type), intent(in) :: recorder
      real(wp), intent(in) :: t, q(:)
      real(wp), intent(inout) :: found(:)
      logical, intent(out) :: done
      real(wp), allocatable :: v(:), a(:)
      allocate (v, a, source=q)
      call held_motion(scene%system, scene%work, self%held, t, q, v, a, done)
      if (done) call free_accelerations(scene%system, scene%work, self%held, t, q, v, a, done)
      if (done) call take_values(scene, recorder, t, q, v, a, self%held%lambda, found)
   end subroutine free_values

   !> Values of a state.
   subroutine take_values(scene, recorder, t, q, v, a, lambda, found)
      type(scene_type), intent(inout) :: scene
      type(recorder_type), intent(in) :: recorder
      real(wp), intent(in) :: t, q(:), v(:), a(:), lambda(:)
      real(wp), intent(inout) :: found(:)
      type(recorder_type), allocatable :: own
      real(wp) :: room(sample_width(scene%system))
      associate (system => scene%system, work => scene%work)
         allocate (own, source=recorder)
         own%is_balanced = .false.
         call place_frames(system%model, system%layout, t, q, work%kinematics)
         call move_frames(system%model, system%layout, q, v, work%kinematics)
         call update_jacobians(system, work)
         work%lambda(:size(lambda)) = lambda
         call channel_values(own, system, work, t, q, v, a, room)
         found = present_values(scene, room, lambda)
      end associate
   end subroutine take_values

   !> Adds what is to be told to the warnings.
   subroutine tell_left_inertia(self, scene, title, outcome)
      type(left_inertia_type), intent(in) :: self
      type(scene_type), intent(in) :: scene
      !> Keyword and name of the analysis
      character(*), intent(in) :: title
      type(outcome_type), intent(inout) :: outcome
      real(wp), allocatable :: least(:)
      integer :: channels, at, others
      channels = size(scene%system%model%channels)
      if (.not. self%used) return
      if (size(self%size) == 0) return
      allocate (least(size(self%size)))
      least(:channels) = least_sizes(self%size(:channels), self%force, scene%system%model)
      least(channels + 1:) = max(self%size(channels + 1:), 1.0e-3_wp*self%force*min(1.0_wp, scene%system%model%length), &
         & tiny(self%force))
      call find_worst(self%left, little)
      if (self%left(at)/least(at) > little) call warn(outcome, part(self%left, self%left_time)// &
         & ': velocities and inertia of the deflections themselves are left out where these are in balance at each instant'// &
         & ' (DEFLECTIONS=STATIC); *DYNAMICS with *ASSEMBLY, INITIAL DEFLECTIONS=FOLLOWING has them')
      call find_worst(self%shaken, little_vibration)
      if (self%shaken(at)/least(at) > little_vibration) call warn(outcome, part(self%shaken, self%shaken_time)// &
         & ': deflections, or their rates, jump there from one balance to another (DEFLECTIONS=STATIC), without the'// &
         & ' vibrations that begin in this way; use a law that is slower or smoother there, or *DYNAMICS, which has them')

   contains

      !> The channel that errs most, or the driver if no channel does.
      subroutine find_worst(off, limit)
         real(wp), intent(in) :: off(:), limit
         logical :: told(size(off))
         told = off/least > limit
         told(channels + 1:) = told(channels + 1:) .and. .not. any(told(:channels))
         at = maxloc(off/least, dim=1, mask=told)
         others = count(told) - 1
         if (at == 0) at = 1
      end subroutine find_worst

      !> Begin of a warning: what errs most, and when.
      function part(off, when) result(text)
         real(wp), intent(in) :: off(:), when(:)
         character(:), allocatable :: text
         if (at <= channels) then
            text = "channel '"//scene%system%model%channels(at)%name//"' of "//title
         else
            associate (item => scene%system%constraints(size(scene%system%model%joints) + at - channels)%item)
               text = 'the torque or force of '//item%label//' in '//title
            end associate
         end if
         if (others > 0) text = text//' (and '//as_text(others)//' more)'
         text = text//' errs by '//trim(merge('more than about', 'about          ', off(at)/least(at) > beyond))//' '// &
            & as_text(100*min(off(at)/least(at), beyond), 2)//' % at t = '//as_text(when(at), 6)
      end function part

   end subroutine tell_left_inertia

end module limber_analysis_left_inertia
