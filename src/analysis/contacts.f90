!> Contacts of rigid stops in a motion: impacts at touches, rest while they push, the end of bounces that accumulate. Floor:
!> analysis. Source: doc/theory, section 5.22.
module limber_analysis_contacts
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text
   use limber_analysis_contact_release, only: find_release, find_least_push
   use limber_analysis_event_search, only: contact_doubt
   use limber_analysis_events, only: events_type, turned_states, read_channels, add_row
   use limber_analysis_impact, only: impact_type, find_impact
   use limber_analysis_switched_start, only: set_states
   use limber_integrator_integrator, only: integrator_type
   use limber_multibody_contact_impulses, only: gap_set_type, read_gaps, new_gap_set, lift_gaps, speeds_at
   use limber_multibody_equations_of_motion, only: mechanical_energy
   use limber_multibody_projection, only: settle
   use limber_multibody_switching, only: set_switches, find_redundant
   use limber_multibody_system, only: system_type, number_of_contacts
   use limber_output_channel_values, only: recorder_type
   use limber_scene_outcome, only: outcome_type, warn
   use limber_scene_sampling, only: sample_type
   use limber_scene_scene, only: scene_type
   implicit none
   private
   public :: contacts_type, new_contacts, check_gaps, turn_states, find_opening, find_jump, note_rest

   !> Impacts that are remembered
   integer, parameter :: remembered = 1000
   !> Height of bounces that count as rest, in doubts about a gap; part of the scene's length, or angle, by which a stop may be
   !> passed at the start: in tolerances, and at least
   real(wp), parameter :: low = 10.0_wp, allowed = 100.0_wp, least = 1.0e-6_wp
   !> Impulse that counts, as a change of speed relative to the largest; gain of energy that is told, relative to the kinetic one;
   !> round-off of speeds
   real(wp), parameter :: slight = 1.0e-6_wp, gained = 1.0e-9_wp, round_off = 64*epsilon(1.0_wp)

   !> Contacts between the steps of a motion
   type :: contacts_type
      !> Which one opens at the end of the last step (contacts)
      logical, allocatable :: opens(:)
      !> When the bounces of each would have ended, which rests since a little earlier; huge: it does not, or that is noted
      !> (contacts)
      real(wp), allocatable :: rest(:)
      !> The first of these times; the time at which one opens in the last step
      real(wp) :: hold = huge(1.0_wp), release = huge(1.0_wp)
      !> Time at which the step that is done again is to end, and the contact that opens there
      real(wp) :: until = huge(1.0_wp)
      integer, private :: held = 0
      !> Local error allowed in a step
      real(wp), private :: tolerance = 0.0_wp
      !> Times of the last impacts, the latest at `latest`; whether a gain of energy has been told
      real(wp), private :: impacts(remembered) = -huge(1.0_wp)
      integer, private :: latest = 1
      logical, private :: told = .false.
   contains
      procedure :: exchange => exchange_contacts
   end type contacts_type

contains

   !> Nothing has touched yet.
   subroutine new_contacts(self, system, tolerance)
      type(contacts_type), intent(out) :: self
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: tolerance
      integer :: n
      n = number_of_contacts(system%model)
      self%tolerance = tolerance
      allocate (self%opens(n), source=.false.)
      allocate (self%rest(n), source=huge(1.0_wp))
   end subroutine new_contacts

   !> An error where the scene begins beyond a stop.
   subroutine check_gaps(scene, t, tolerance, error)
      type(scene_type), intent(inout) :: scene
      real(wp), intent(in) :: t, tolerance
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: gap(:), rate(:), scale(:)
      integer :: i
      associate (model => scene%system%model)
         allocate (gap(size(model%contacts)), rate(size(model%contacts)), scale(size(model%contacts)))
         call read_gaps(scene%system, scene%work, t, scene%q, scene%v, gap, rate, scale)
         do i = 1, size(gap)
            if (gap(i) >= -max(least, allowed*tolerance)*scale(i)) cycle
            call raise(error, "stop '"//model%contacts(i)%name//"' is rigid, and the scene begins "//as_text(-gap(i), 4)//' '// &
               & trim(merge('rad           ', model%units%length//'             ', model%loads(model%contacts(i)%load)%angular))// &
               & ' beyond it at t = '//as_text(t, 6)//'; begin within its limits, or give it a STIFFNESS')
            return
         end do
      end associate
   end subroutine check_gaps

   !> Which contacts are closed (contacts).
   pure function closed_contacts(system) result(closed)
      type(system_type), intent(in) :: system
      logical :: closed(number_of_contacts(system%model))
      integer :: i
      do i = 1, size(closed)
         closed(i) = system%on(system%model%contacts(i)%switch)
      end do
   end function closed_contacts

   !> Looks whether a contact that rests would pull within the last step. There it opens, and the step counts up to there. An
   !> integrator whose promise holds at the ends of its steps does the step again, up to there.
   subroutine find_opening(self, scene, integrator, near, t, again, error)
      type(contacts_type), intent(inout) :: self
      type(scene_type), intent(inout) :: scene
      class(integrator_type), intent(inout) :: integrator
      !> Times so near that there is no step between them
      real(wp), intent(in) :: near
      !> Time up to which the last step counts
      real(wp), intent(inout) :: t
      !> Whether the step has to be done again, up to `until`
      logical, intent(out) :: again
      type(error_type), allocatable, intent(out) :: error
      logical :: closed(size(self%rest))
      integer :: contact
      again = .false.
      self%opens = .false.
      self%release = huge(t)
      closed = closed_contacts(scene%system)
      if (.not. any(closed)) return
      call find_release(scene%system, scene%work, integrator, closed, t, self%release, contact, error)
      if (allocated(error)) return
      if (t >= self%until - near) then
         ! By round-off a step may end right before the instant at which it is held
         if (contact == 0) self%release = t
         if (contact == 0) contact = self%held
         self%until = huge(t)
      end if
      if (contact == 0) return
      again = integrator%ends_on_samples .and. self%release < t - near .and. self%release > integrator%t_before + near
      if (again) then
         self%until = self%release
         self%held = contact
         return
      end if
      self%opens(contact) = .true.
      t = self%release
   end subroutine find_opening

   !> Looks whether a contact that rests would pull right behind a jump of a law; there it opens.
   subroutine find_jump(self, scene, t, sample, error)
      type(contacts_type), intent(inout) :: self
      type(scene_type), intent(inout) :: scene
      real(wp), intent(in) :: t
      !> State there
      type(sample_type), intent(in) :: sample
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: q(size(sample%q)), v(size(sample%v)), push
      logical :: closed(size(self%rest))
      integer :: contact
      self%opens = .false.
      closed = closed_contacts(scene%system)
      if (.not. any(closed)) return
      q = sample%q
      v = sample%v
      call find_least_push(scene%system, scene%work, t, q, v, closed, push, contact, error)
      if (push < 0.0_wp) self%opens(contact) = .true.
   end subroutine find_jump

   !> Turns the switches of the events at the end of the last step, and lets contacts strike, rest or open there. Contacts come
   !> behind joints that close at the same instant.
   subroutine turn_states(self, events, scene, t, integrator, recorder, sample, renewed, outcome, error)
      type(contacts_type), intent(inout) :: self
      type(events_type), intent(inout) :: events
      type(scene_type), intent(inout) :: scene
      real(wp), intent(in) :: t
      class(integrator_type), intent(inout) :: integrator
      type(recorder_type), intent(inout) :: recorder
      !> State, and work put in so far; in: right before, out: right behind
      type(sample_type), intent(inout) :: sample
      !> Whether the constraints may be others than before
      logical, intent(out) :: renewed
      type(outcome_type), intent(inout) :: outcome
      type(error_type), allocatable, intent(out) :: error
      logical :: closed(size(self%rest)), touched(size(self%rest)), on(size(scene%system%on)), turning(size(events%turning))
      real(wp) :: work
      logical :: closes
      integer :: i
      turning = events%turning
      on = turned_states(events, scene%system)
      if (size(closed) == 0) then
         call set_states(scene, t, on, turning, self%tolerance, sample, renewed, outcome, error)
         return
      end if
      call read_channels(events, scene, integrator, recorder, sample, t, outcome, error)
      if (allocated(error)) return
      closed = closed_contacts(scene%system)
      do i = 1, size(closed)
         associate (contact => scene%system%model%contacts(i))
            touched(i) = turning(contact%event)
            turning(contact%event) = .false.
            on(contact%switch) = .false.
         end associate
      end do
      if (any(touched)) call stay_above(scene, integrator, t, touched, sample)
      work = sample%w
      call set_states(scene, t, on, turning, self%tolerance, sample, renewed, outcome, error)
      if (allocated(error)) return
      ! What only brings the state onto joints is no work
      if (.not. any(turning)) sample%w = work
      call strike(self, events, scene, t, closed, touched, recorder, sample, on, outcome, error)
      if (allocated(error)) return
      call set_switches(scene%system, scene%work, on, closes)
      call settle_contacts(scene, t, closes, sample, error)
      renewed = renewed .or. closes
   end subroutine turn_states

   !> Takes a state right before a touch, where no gap is below zero yet: to lift it there would gain energy, which adds up over
   !> many impacts.
   subroutine stay_above(scene, integrator, t, touched, sample)
      type(scene_type), intent(inout) :: scene
      class(integrator_type), intent(inout) :: integrator
      !> Time of the touch, to round-off
      real(wp), intent(in) :: t
      !> Which contacts touch (contacts)
      logical, intent(in) :: touched(:)
      type(sample_type), intent(inout) :: sample
      !> Units of round-off of the time
      integer, parameter :: most = 8
      real(wp) :: gap(size(touched)), rate(size(touched)), scale(size(touched)), at
      integer :: k
      do k = 0, most
         at = t - k*spacing(t)
         if (at <= integrator%t_before) return
         if (k > 0) call integrator%interpolate(at, sample%q, sample%v, sample%w)
         if (k > 0) call integrator%complete(scene%system, scene%work, at, sample%q, sample%v)
         call read_gaps(scene%system, scene%work, at, sample%q, sample%v, gap, rate, scale)
         if (all(gap >= 0.0_wp .or. .not. touched)) return
      end do
   end subroutine stay_above

   !> Brings a state onto contacts that have closed, and lifts it where others are below zero by the error of positions.
   subroutine settle_contacts(scene, t, closes, sample, error)
      type(scene_type), intent(inout) :: scene
      real(wp), intent(in) :: t
      !> Whether some have closed
      logical, intent(in) :: closes
      type(sample_type), intent(inout) :: sample
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: gap(:), rate(:), scale(:)
      integer, allocatable :: list(:)
      real(wp) :: residual
      type(gap_set_type) :: set
      integer :: i, n
      n = number_of_contacts(scene%system%model)
      allocate (gap(n), rate(n), scale(n))
      if (closes) call find_redundant(scene%system, scene%work, t, sample%q, error)
      if (allocated(error)) return
      call settle(scene%system, scene%work, t, sample%q, sample%v, sample%a, .true., residual, error)
      if (allocated(error)) return
      call read_gaps(scene%system, scene%work, t, sample%q, sample%v, gap, rate, scale)
      list = pack([(i, i=1, n)], gap < 0.0_wp .and. .not. closed_contacts(scene%system))
      if (size(list) == 0) return
      call new_gap_set(scene%system, scene%work, list, set)
      call lift_gaps(scene%system, scene%work, set, gap(list), sample%q, sample%v)
   end subroutine settle_contacts

   !> Impulses of all contacts at an instant, and which are closed behind it. All are open in the system.
   subroutine strike(self, events, scene, t, closed, touched, recorder, sample, on, outcome, error)
      type(contacts_type), intent(inout) :: self
      type(events_type), intent(inout) :: events
      type(scene_type), intent(inout) :: scene
      real(wp), intent(in) :: t
      !> Which were closed before, which have just touched (contacts)
      logical, intent(in) :: closed(:), touched(:)
      type(recorder_type), intent(inout) :: recorder
      type(sample_type), intent(inout) :: sample
      !> Switches of the contacts are set (switches)
      logical, intent(inout) :: on(:)
      type(outcome_type), intent(inout) :: outcome
      type(error_type), allocatable, intent(out) :: error
      type(gap_set_type) :: set
      type(impact_type) :: impact
      real(wp) :: gap(size(closed)), rate(size(closed)), scale(size(closed)), residual, kinetic(2), potential
      integer, allocatable :: list(:)
      integer :: i
      associate (system => scene%system, work => scene%work)
         call settle(system, work, t, sample%q, sample%v, sample%a, .true., residual, error)
         if (allocated(error)) return
         call read_gaps(system, work, t, sample%q, sample%v, gap, rate, scale)
         scale = contact_doubt(self%tolerance)*scale
         list = pack([(i, i=1, size(closed))], closed .or. touched .or. gap <= scale)
         if (size(list) == 0) return
         call new_gap_set(system, work, list, set)
         allocate (impact%before(size(list)), impact%noise(size(list)))
         impact%before = rate(list)
         impact%noise = merge(self%tolerance, round_off, closed(list))*speeds_at(system, work, set, sample%v)
         call mechanical_energy(system, work, sample%q, sample%v, kinetic(1), potential)
         call find_impact(system, work, set, sample%q, system%model%contacts(list)%restitution, &
            & height_of_rest(system%model%contacts(list)%restitution)*scale(list), .not. self%opens(list), sample%v, impact)
         if (.not. impact%solved) then
            call refuse(system, t, list(minloc(rate(list), dim=1)), error)
            return
         end if
         do i = 1, size(list)
            on(system%model%contacts(list(i))%switch) = impact%rests(i)
            call note_contact(self, events, system, t, list(i), closed(list(i)), low*scale(list(i)), set%mobility(i, i), &
               & impact, i, outcome)
         end do
         if (size(system%model%drivers) > 0) then
            ! Drivers take a part of the impulse
            call mechanical_energy(system, work, sample%q, sample%v, kinetic(2), potential)
            sample%w = sample%w + kinetic(2) - kinetic(1)
         else
            sample%w = sample%w + sum(impact%energies())
         end if
         recorder%lost(list) = recorder%lost(list) - impact%energies()
         self%hold = minval(self%rest)
         self%until = huge(t)
         call check_gain(self, system, t, list, impact, outcome)
         if (any(touched)) call count_impact(self, system, t, findloc(touched, .true., dim=1), error)
      end associate
   end subroutine strike

   !> Height of bounces that count as rest, in doubts about a gap. The doubt lifts a body at each bounce; above this bounces lose
   !> more than that.
   elemental real(wp) function height_of_rest(restitution) result(height)
      real(wp), intent(in) :: restitution
      !> In the ratio of what is lifted to what is lost; least loss that is counted on
      real(wp), parameter :: lifted = 4.0_wp, least_loss = 1.0e-4_wp
      height = low
      if (restitution < 1.0_wp) height = max(low, lifted/max(least_loss, 1 - restitution**2))
   end function height_of_rest

   !> Notes what a contact does: a row of the events if it strikes, closes or opens.
   subroutine note_contact(self, events, system, t, contact, was_closed, height, mobility, impact, i, outcome)
      type(contacts_type), intent(inout) :: self
      type(events_type), intent(inout) :: events
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: t
      !> Its index; whether it was closed
      integer, intent(in) :: contact
      logical, intent(in) :: was_closed
      !> Of bounces that count as rest; speed for a unit impulse
      real(wp), intent(in) :: height, mobility
      type(impact_type), intent(in) :: impact
      !> Its place in the impact
      integer, intent(in) :: i
      type(outcome_type), intent(inout) :: outcome
      real(wp) :: change, energies(size(impact%impulse))
      logical :: closes, strikes, added
      integer :: turned
      change = impact%impulse(i)*mobility
      closes = impact%rests(i) .and. .not. was_closed
      strikes = change > max(slight*maxval(abs(impact%before)), impact%noise(i)) .and. &
         & (closes .or. change**2 > 2*abs(impact%acceleration(i))*height)
      turned = 0
      if (was_closed .and. .not. impact%rests(i)) turned = -1
      if (closes) then
         turned = 1
         self%rest(contact) = t + impact%remaining(i)
         ! The row of its rest is that of the end of its bounces
         if (impact%remaining(i) > 8*spacing(max(abs(t), abs(system%model%dynamics%end)))) turned = 0
      end if
      if (.not. impact%rests(i) .or. turned == 1) self%rest(contact) = huge(t)
      if (.not. strikes .and. turned == 0) return
      call add_row(events, t, system%model%contacts(contact)%event, merge(1, -1, turned < 0), outcome, added)
      energies = impact%energies()
      if (added) call outcome%events%strike(turned, energies(i), merge(impact%impulse(i), 0.0_wp, strikes))
   end subroutine note_contact

   !> Notes that contacts have come to rest: the times at which their bounces would have ended are reached.
   subroutine note_rest(self, events, scene, t, integrator, recorder, sample, outcome, error)
      type(contacts_type), intent(inout) :: self
      type(events_type), intent(inout) :: events
      type(scene_type), intent(inout) :: scene
      !> Time that is reached, to round-off
      real(wp), intent(in) :: t
      class(integrator_type), intent(inout) :: integrator
      type(recorder_type), intent(inout) :: recorder
      type(sample_type), intent(inout) :: sample
      type(outcome_type), intent(inout) :: outcome
      type(error_type), allocatable, intent(out) :: error
      logical :: added
      integer :: i
      call integrator%interpolate(min(t, integrator%t), sample%q, sample%v, sample%w)
      call integrator%complete(scene%system, scene%work, min(t, integrator%t), sample%q, sample%v)
      call read_channels(events, scene, integrator, recorder, sample, min(t, integrator%t), outcome, error)
      if (allocated(error)) return
      do i = 1, size(self%rest)
         if (self%rest(i) > t) cycle
         call add_row(events, self%rest(i), scene%system%model%contacts(i)%event, -1, outcome, added)
         if (added) call outcome%events%strike(1, 0.0_wp, 0.0_wp)
         self%rest(i) = huge(t)
      end do
      self%hold = minval(self%rest)
   end subroutine note_rest

   !> An error where nothing gives way at a touch.
   subroutine refuse(system, t, contact, error)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: t
      !> The one that approaches fastest
      integer, intent(in) :: contact
      type(error_type), allocatable, intent(out) :: error
      call raise(error, "stop '"//system%model%contacts(contact)%name//"' is rigid and is met at t = "//as_text(t, 8)// &
         & ', and no impulse ends the approach: drivers move what meets there, or stops hold it from both sides; '// &
         & 'let a driver end before, or give the stop a STIFFNESS')
   end subroutine refuse

   !> Tells once that impacts have gained energy: the law of Newton may do so where contacts of different restitution meet.
   subroutine check_gain(self, system, t, list, impact, outcome)
      type(contacts_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: t
      !> Contacts of the impact
      integer, intent(in) :: list(:)
      type(impact_type), intent(in) :: impact
      type(outcome_type), intent(inout) :: outcome
      real(wp) :: parts(size(list))
      parts = impact%energies()
      if (self%told .or. sum(parts) <= gained*sum(abs(impact%before*impact%impulse))) return
      call warn(outcome, "the impact at stop '"//system%model%contacts(list(maxloc(parts, dim=1)))%name//"' at t = "// &
         & as_text(t, 8)//' gains '//as_text(sum(parts), 3)//' of energy: several stops meet there, and the law of Newton with'// &
         & ' their RESTITUTION does not hold for them together; give all the same')
      self%told = .true.
   end subroutine check_gain

   !> Counts impacts. An error where they come ever faster, and do not end as bounces do.
   subroutine count_impact(self, system, t, contact, error)
      type(contacts_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: t
      !> One that has touched
      integer, intent(in) :: contact
      type(error_type), allocatable, intent(out) :: error
      !> Part of the analysis within which so many impacts are no motion that could be followed
      real(wp), parameter :: at_once = 1.0e-7_wp
      self%latest = modulo(self%latest, remembered) + 1
      associate (dynamics => system%model%dynamics, earliest => self%impacts(self%latest))
         if (t - earliest <= at_once*(dynamics%end - dynamics%start)) call raise(error, "stop '"// &
            & system%model%contacts(contact)%name//"' is struck again and again at t = "//as_text(t, 8)//': '// &
            & as_text(remembered)//' impacts within '//as_text(t - earliest, 2)//' '//system%model%units%time// &
            & '; give a smaller RESTITUTION, or a STIFFNESS instead of LAW=RIGID')
         earliest = t
      end associate
   end subroutine count_impact

   !> Saves or restores it.
   subroutine exchange_contacts(self, snapshot)
      class(contacts_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      ! Not saved: opens, release, tolerance
      if (size(self%rest) == 0) return
      call snapshot%exchange('rest', self%rest)
      call snapshot%exchange('contact_hold', self%hold)
      call snapshot%exchange('until', self%until)
      call snapshot%exchange('held_contact', self%held)
      call snapshot%exchange('impacts', self%impacts)
      call snapshot%exchange('latest_impact', self%latest)
      call snapshot%exchange('told_gain', self%told)
   end subroutine exchange_contacts

end module limber_analysis_contacts
