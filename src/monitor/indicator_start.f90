!> First values of the indicators. Stations, places of joints and loads, and what holds each flexible body and each rigid beam.
!> Floor: monitor. Source: doc/theory, eqs. (7.8)-(7.11), (7.15)-(7.17), (7.21), (7.25)-(7.27), (7.32)-(7.35).
module limber_monitor_indicator_start
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_monitor_function_watch, only: start_functions
   use limber_monitor_indicators, only: indicators_type, body_indicators_type, indicator_set_type
   use limber_monitor_false_damping, only: start_false_damping
   use limber_monitor_lumping_phase, only: start_phase
   use limber_monitor_modal_sudden, only: start_modal_sudden
   use limber_monitor_body_surveys, only: start_surveys, is_base
   use limber_monitor_drawn_channels, only: start_drawn_channels
   use limber_beam_quasistatic_deflection, only: new_quasistatic
   use limber_beam_monitored_sections, only: new_stations, patch_type, hold_none, hold_some, hold_hinge, hold_clamp
   use limber_model_distributed_loads, only: spread_parts
   use limber_model_model, only: place_at_point, place_on_line, place_on_curve, place_on_beam, ground, body_rigid, body_type
   use limber_model_quantities, only: quantity_ax, quantity_axial_force, quantity_ay, quantity_bending_moment, &
      & quantity_deflection, quantity_force_1, quantity_force_2, quantity_force_x, quantity_force_y, quantity_moment, &
      & quantity_rotation, quantity_shear_force, quantity_stress_bottom, quantity_stress_top, quantity_u1, quantity_u2
   use limber_multibody_system, only: system_type
   use limber_output_point_forces, only: new_pulls, pulled_points
   implicit none
   private
   public :: start_indicators

   !> A joint, driver or load that acts on a beam: the point, what it is as a joint that holds the beam across and does not slide
   !> along it (a weld to any body is a clamp here), and the other body of a pin or weld, -1 for others
   type :: contact_type
      integer :: point = 0
      integer :: hold = hold_none
      integer :: partner = -1
   end type contact_type

contains

   !> Makes the constants; bodies whose constants cannot be made are left out.
   subroutine start_indicators(self, system)
      type(indicators_type), intent(out) :: self
      type(system_type), intent(in) :: system
      type(contact_type), allocatable :: contacts(:)
      integer :: first(size(system%model%bodies) + 1)
      integer :: i, k, count, most
      call start_functions(self%functions, system)
      allocate (self%of(size(system%model%bodies)), self%place(size(system%model%points)))
      allocate (self%fixed(2, size(system%constraints)), self%turned(size(system%model%bodies)))
      self%turned = .false.
      self%of = 0
      self%place = 0
      self%fixed = .true.
      count = 0
      do i = 1, size(self%of)
         if (system%layout%n(i) == 0 .and. .not. is_rigid_beam(system%model%bodies(i))) cycle
         ! Nothing of these is left out of an exact beam
         if (system%model%bodies(i)%reduced%is_exact) cycle
         count = count + 1
         self%of(i) = count
      end do
      allocate (self%bodies(count), self%sets(min(count, 4)))
      most = 0
      do i = 1, size(system%loads)
         most = max(most, sum(system%loads(i)%item%rates))
      end do
      allocate (self%scratch(most))
      self%pulls = new_pulls(system)
      allocate (self%drawn%channels(0))
      if (count == 0) return
      do i = 1, size(system%model%joints)
         if (any(system%model%joints(i)%place == [place_on_line, place_on_curve, place_on_beam])) &
            & self%fixed(2, i) = .false.
      end do
      do i = 1, size(system%constraints)
         do k = 1, 2
            associate (item => system%constraints(i)%item)
               if (item%bodies(k) /= ground .and. item%points(k) == 0) self%turned(item%bodies(k)) = .true.
            end associate
         end do
      end do
      call list_contacts(self, system, first, contacts)
      call start_surveys(self%surveys, system, frames_only=.true.)
      do i = 1, size(self%of)
         if (self%of(i) > 0) call start_body(self, system, i, contacts(first(i):first(i + 1) - 1), self%bodies(self%of(i)))
      end do
      do i = 1, size(self%bodies)
         associate (body => self%bodies(i))
            if (system%layout%n(body%body) > 0) call start_modal_sudden(body%sudden, system, body%body, body%lumping)
         end associate
      end do
      call find_shown(self, system)
      call start_drawn(self, system)
   end subroutine start_indicators

   !> Channels that bending draws in, and the points of frames that these need.
   subroutine start_drawn(self, system)
      type(indicators_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      logical :: watched(size(self%of))
      integer :: i, k, n
      watched = .false.
      do i = 1, size(self%bodies)
         associate (body => self%bodies(i))
            watched(body%body) = body%is_beam .or. (system%model%bodies(body%body)%is_frame .and. self%surveys%of(body%body) > 0)
         end associate
      end do
      call start_drawn_channels(self%drawn, system, watched)
      if (.not. allocated(self%drawn%moves%points)) return
      do i = 1, size(self%bodies)
         if (self%bodies(i)%is_beam .or. .not. self%drawn%moves%bends(self%bodies(i)%body)) cycle
         associate (own => self%bodies(i)%drawing_in, points => self%drawn%moves%points)
            n = 0
            do k = 1, size(points)
               if (system%model%points(points(k))%body == self%bodies(i)%body) n = n + 1
            end do
            allocate (own%slots(n), own%member(n), own%along(n), own%place(2, n))
            n = 0
            do k = 1, size(points)
               associate (point => system%model%points(points(k)))
                  if (point%body /= self%bodies(i)%body) cycle
                  n = n + 1
                  own%slots(n) = k
                  own%member(n) = max(1, point%member)
                  own%along(n) = point%along
                  own%place(:, n) = point%p0
               end associate
            end do
         end associate
      end do
   end subroutine start_drawn

   !> Which bodies channels ask for deflections or internal forces of.
   subroutine find_shown(self, system)
      type(indicators_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      integer, parameter :: pulls(*) = [quantity_ax, quantity_ay, quantity_force_x, quantity_force_y, quantity_force_1, &
         & quantity_force_2, quantity_moment, quantity_axial_force, quantity_shear_force, quantity_bending_moment]
      integer :: i, j, body
      associate (model => system%model)
         do i = 1, size(model%channels)
            do j = 1, size(model%channels(i)%quantities)
               associate (quantity => model%channels(i)%quantities(j))
                  if (any(quantity%kind == pulls)) self%bodies%phase%pulled = .true.
                  if (quantity%kind == quantity_moment .and. .not. (quantity%of_load .or. quantity%of_coupler)) &
                     & call show_reaction(quantity%of)
                  call show_axial(self, system, quantity%kind, quantity%of, quantity%of_load .or. quantity%of_coupler)
                  if (.not. any(quantity%kind == [quantity_shear_force, quantity_bending_moment, quantity_stress_top, &
                     & quantity_stress_bottom, quantity_deflection, quantity_u1, quantity_u2, quantity_rotation])) cycle
                  if (model%points(quantity%of)%body == ground) cycle
                  body = self%of(model%points(quantity%of)%body)
                  if (body == 0) cycle
                  self%bodies(body)%phase%shown = .true.
                  if (any(quantity%kind == [quantity_deflection, quantity_u1, quantity_u2, quantity_rotation])) cycle
                  if (quantity%kind == quantity_shear_force) self%bodies(body)%shows_shear = .true.
                  if (quantity%kind /= quantity_shear_force) self%bodies(body)%shows_moment = .true.
                  self%bodies(body)%phase%strained = system%model%bodies(self%bodies(body)%body)%is_frame
               end associate
            end do
         end do
         do i = 1, size(model%bodies)
            if (self%of(i) == 0 .or. .not. model%bodies(i)%envelope) cycle
            self%bodies(self%of(i))%shows_axial = .true.
            self%bodies(self%of(i))%shows_force = .true.
            self%bodies(self%of(i))%shows_shear = .true.
            self%bodies(self%of(i))%shows_moment = .true.
            self%bodies(self%of(i))%phase%shown = .true.
         end do
      end associate

   contains

      !> The bodies of a joint.
      subroutine show_reaction(joint)
         integer, intent(in) :: joint
         integer :: side, held
         do side = 1, 2
            if (system%model%joints(joint)%points(side) == 0) cycle
            held = system%model%points(system%model%joints(joint)%points(side))%body
            if (held == ground) cycle
            if (self%of(held) == 0) cycle
            self%bodies(self%of(held))%shows_reaction = .true.
            if (.not. system%model%bodies(held)%is_frame) cycle
            self%bodies(self%of(held))%phase%shown = .true.
            self%bodies(self%of(held))%phase%strained = .true.
         end do
      end subroutine show_reaction

   end subroutine find_shown

   !> Which body a channel asks for axial forces of: at a point, or by the force of a joint.
   subroutine show_axial(self, system, kind, of, is_other)
      type(indicators_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Kind of quantity; index of the point or the joint
      integer, intent(in) :: kind, of
      !> Whether it is of a load or a coupler
      logical, intent(in) :: is_other
      integer :: side, point, body
      if (is_other) return
      do side = 1, 2
         point = 0
         select case (kind)
         case (quantity_axial_force, quantity_stress_top, quantity_stress_bottom); point = of
         case (quantity_force_x, quantity_force_y, quantity_force_1, quantity_force_2)
            if (of <= size(system%model%joints)) point = system%model%joints(of)%points(side)
         end select
         if (point == 0) cycle
         body = system%model%points(point)%body
         if (body == ground) cycle
         if (self%of(body) == 0) cycle
         self%bodies(self%of(body))%shows_axial = .true.
         if (all(kind /= [quantity_stress_top, quantity_stress_bottom])) self%bodies(self%of(body))%shows_force = .true.
      end do
   end subroutine show_axial

   !> Whether a body is a straight beam that is taken for rigid.
   pure logical function is_rigid_beam(body)
      type(body_type), intent(in) :: body
      is_rigid_beam = body%kind == body_rigid .and. body%beam%length > 0.0_wp .and. body%beam%ei > 0.0_wp .and. &
         & body%beam%rho_a > 0.0_wp .and. .not. allocated(body%beam%mass)
   end function is_rigid_beam

   !> The constants of a rigid beam.
   subroutine start_rigid(self, system, index, contacts, body)
      type(indicators_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      integer, intent(in) :: index
      type(contact_type), intent(in) :: contacts(:)
      type(body_indicators_type), intent(inout) :: body
      real(wp), allocatable :: place(:)
      type(patch_type), allocatable :: patch(:)
      integer, allocatable :: hold(:)
      logical :: held, clamped
      body%is_rigid = .true.
      call find_places(self, system, index, contacts, place, patch, hold, held)
      clamped = self%turned(index) .or. any(contacts%hold == hold_clamp)
      associate (beam => system%model%bodies(index)%beam, choice => system%model%bodies(index)%choice)
         body%quasistatic = new_quasistatic(beam%ei, beam%rho_a, beam%length, choice%origin, place, hold > hold_none, clamped)
      end associate
      body%first_frequency = body%quasistatic%frequency
      body%length = system%model%bodies(index)%beam%length
      allocate (body%modal(0), body%modal_time(0), body%moving(0), body%pressed(3, size(place)))
   end subroutine start_rigid

   !> The masses that hang on a beam or a frame, and the place that stays where it is: one on the ground, or else the start.
   subroutine find_carried(self, system, contacts, body)
      type(indicators_type), intent(in) :: self
      type(system_type), intent(in) :: system
      type(contact_type), intent(in) :: contacts(:)
      type(body_indicators_type), intent(inout) :: body
      integer :: i, at
      if (body%is_beam) allocate (body%carried(self%sets(body%set)%stations%places))
      if (.not. body%is_beam) allocate (body%carried(self%surveys%bodies(self%surveys%of(body%body))%survey%places))
      body%carried = 0.0_wp
      do i = 1, size(contacts)
         at = merge(self%place(contacts(i)%point), self%surveys%place(contacts(i)%point), body%is_beam)
         if (contacts(i)%partner == ground) body%anchor = at
         if (contacts(i)%partner > ground) body%carried(at) = body%carried(at) &
            & + system%model%bodies(contacts(i)%partner)%reduced%mass
      end do
   end subroutine find_carried

   !> The constants of one body.
   subroutine start_body(self, system, index, contacts, body)
      type(indicators_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      integer, intent(in) :: index
      type(contact_type), intent(in) :: contacts(:)
      type(body_indicators_type), intent(inout) :: body
      real(wp), allocatable :: place(:)
      type(patch_type), allocatable :: patch(:)
      integer, allocatable :: hold(:)
      logical :: held
      integer :: k
      body%body = index
      if (system%layout%n(index) == 0) then
         call start_rigid(self, system, index, contacts, body)
         return
      end if
      associate (flexible => system%model%bodies(index))
         body%is_beam = .not. flexible%is_frame .and. flexible%reduced%bending > 0
         body%first_frequency = sqrt(minval(flexible%reduced%omega2))
         body%length = flexible%size
         allocate (body%modal(flexible%reduced%bending), body%modal_time(flexible%reduced%bending))
         body%modal = 0.0_wp
         body%modal_time = 0.0_wp
         allocate (body%moving, source=body%modal)
         call start_phase(body%phase, system, index)
         call start_false_damping(body%false_damping, flexible%reduced)
         if (flexible%is_frame) call start_frame(self, system, index, contacts, body)
         if (.not. body%is_beam) return
         call find_places(self, system, index, contacts, place, patch, hold, held)
         ! Beside the one place that holds it, it hangs: what turns with that body, or is turned, is clamped there
         if (count(hold > hold_none) == 1 .and. (self%turned(index) .or. any(contacts%hold == hold_clamp))) &
            & hold = merge(hold_clamp, hold_none, hold > hold_none)
         ! A driver of its angle may hold a section that its hinge leaves free
         if (self%turned(index)) hold = merge(hold_some, hold, hold == hold_hinge)
         call find_set(self, system, index, place, patch, hold, held, body%set)
         body%is_beam = body%set > 0
         if (.not. body%is_beam) return
         associate (stations => self%sets(body%set)%stations)
            body%elements = stations%elements
            body%held = stations%membrane > 0.0_wp
            body%misfit = stations%misfit
            if (stations%euler < huge(1.0_wp)) body%layer = sqrt(stations%euler/flexible%beam%ei)*flexible%beam%length/ &
               & stations%bending
            body%bending = [(k, k=1, stations%bending)]
            call find_carried(self, system, contacts, body)
            allocate (body%lumping, source=stations%lumping)
            allocate (body%slope(stations%count), body%force(stations%count))
            allocate (body%along(size(stations%pull, 1)), body%across(2 + 2*size(place)), body%own(stations%bending), &
               & body%push(3, stations%bending))
         end associate
      end associate
   end subroutine start_body

   !> Room for what a frame is watched with; none if it has no survey.
   subroutine start_frame(self, system, index, contacts, body)
      type(indicators_type), intent(in) :: self
      type(system_type), intent(in) :: system
      integer, intent(in) :: index
      type(contact_type), intent(in) :: contacts(:)
      type(body_indicators_type), intent(inout) :: body
      integer :: m, k
      if (self%surveys%of(index) == 0) return
      associate (survey => self%surveys%bodies(self%surveys%of(index))%survey, reduced => system%model%bodies(index)%reduced)
         m = size(survey%chosen)
         allocate (body%slope_work(0:m, 0:m), body%lacking(0:m), body%elastic(reduced%n), &
            & body%s(size(reduced%cubic, 1)), body%lumping(reduced%n))
         body%lumping = 0.0_wp
         body%lumping(survey%chosen) = survey%lumping
         body%bending = pack(survey%chosen, [(survey%bending(k, k) > 0.5_wp*survey%omega2(k), k=1, m)])
         call find_carried(self, system, contacts, body)
         body%layer = max(1, size(body%bending))/real(size(survey%mesh%first) - 1, wp)
      end associate
   end subroutine start_frame

   !> The set of constants of a beam: that of an earlier one if it is the same, else a new one; 0 if they cannot be made.
   subroutine find_set(self, system, index, place, patch, hold, held, set)
      type(indicators_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> The body; coordinates along it where joints and loads act, and what joints do there; whether two of these places are held
      !> by the same other body
      integer, intent(in) :: index
      real(wp), intent(in) :: place(:)
      type(patch_type), intent(in) :: patch(:)
      integer, intent(in) :: hold(:)
      logical, intent(in) :: held
      integer, intent(out) :: set
      !> Sets before the last that are looked at
      integer, parameter :: last = 8
      type(error_type), allocatable :: error
      do set = self%count, max(1, self%count - last), -1
         if (is_same(self%sets(set))) return
      end do
      if (self%count == size(self%sets)) call make_room(self)
      set = self%count + 1
      associate (new => self%sets(set), flexible => system%model%bodies(index))
         call new_stations(flexible%beam, flexible%choice, flexible%field, flexible%reduced, place, hold, held, &
            & new%stations, error, patch)
         if (.not. allocated(error)) then
            new%body = index
            new%held = held
            allocate (new%hold, source=hold)
            self%count = set
         else
            set = 0
         end if
      end associate

   contains

      !> Whether a set is that of this beam.
      pure logical function is_same(other)
         type(indicator_set_type), intent(in) :: other
         associate (bodies => system%model%bodies)
            is_same = bodies(index)%twin > 0 .and. bodies(other%body)%twin == bodies(index)%twin .and. (other%held .eqv. held)
         end associate
         if (is_same) is_same = size(other%hold) == size(hold)
         if (is_same) is_same = all(other%hold == hold) .and. all(abs(other%stations%place - place) <= 0.0_wp)
         if (is_same) is_same = are_same(other%stations%patch, patch)
      end function is_same

   end subroutine find_set

   !> Whether loads along two beams are spread alike.
   pure logical function are_same(one, other)
      type(patch_type), intent(in) :: one(:), other(:)
      integer :: i
      are_same = .true.
      do i = 1, size(one)
         are_same = are_same .and. (allocated(one(i)%at) .eqv. allocated(other(i)%at))
         if (.not. (are_same .and. allocated(one(i)%at))) cycle
         are_same = size(one(i)%at) == size(other(i)%at)
         if (are_same) are_same = all(abs(one(i)%at - other(i)%at) <= 0.0_wp) .and. all(abs(one(i)%part - other(i)%part) <= 0.0_wp)
      end do
   end function are_same

   !> Twice as many sets.
   subroutine make_room(self)
      type(indicators_type), intent(inout) :: self
      type(indicator_set_type), allocatable :: more(:)
      integer :: i
      allocate (more(2*size(self%sets)))
      do i = 1, self%count
         more(i) = self%sets(i)
      end do
      call move_alloc(more, self%sets)
   end subroutine make_room

   !> What acts on flexible bodies, body by body.
   subroutine list_contacts(self, system, first, contacts)
      type(indicators_type), intent(in) :: self
      type(system_type), intent(in) :: system
      !> Where the contacts of a body begin (bodies + 1)
      integer, intent(out) :: first(:)
      type(contact_type), allocatable, intent(out) :: contacts(:)
      integer :: pass, i, side, fill(size(first)), partner
      integer :: hold
      first = 0
      do pass = 1, 2
         do i = 1, size(system%constraints)
            associate (item => system%constraints(i)%item)
               do side = 1, 2
                  partner = -1
                  hold = hold_none
                  if (i <= size(system%model%joints)) then
                     associate (joint => system%model%joints(i), body => item%bodies(side))
                        if (self%fixed(side, i) .and. joint%bears(side)) hold = merge(hold_hinge, hold_some, joint%is_hinge())
                        if (body /= ground) then
                           if (joint%guides(side) .and. is_rigid_beam(system%model%bodies(body))) hold = max(hold, hold_some)
                        end if
                        if (joint%is_weld() .and. joint%bears(side)) hold = hold_clamp
                     end associate
                     if (system%model%joints(i)%place == place_at_point) partner = item%bodies(3 - side)
                     if (partner > ground) then
                        if (is_base(system, partner)) partner = ground
                     end if
                  end if
                  call enter(item%bodies(side), item%points(side), hold, partner)
               end do
            end associate
         end do
         do i = 1, size(system%loads)
            associate (item => system%loads(i)%item)
               do side = 1, size(item%points)
                  call enter(item%bodies(side), item%points(side), hold_none, -1)
               end do
            end associate
         end do
         associate (pulled => pulled_points(self%pulls, system))
            do i = 1, size(pulled)
               call enter(system%model%points(pulled(i))%body, pulled(i), hold_none, -1)
            end do
         end associate
         if (pass == 2) exit
         first(1) = 1
         do i = 2, size(first)
            first(i) = first(i - 1) + first(i)
         end do
         fill = first
         allocate (contacts(first(size(first)) - 1))
      end do

   contains

      !> First counts, then enters.
      subroutine enter(body, point, hold, partner)
         integer, intent(in) :: body, point, hold, partner
         if (body == ground .or. point == 0) return
         if (self%of(body) == 0) return
         if (pass == 1) then
            first(body + 1) = first(body + 1) + 1
         else
            contacts(fill(body))%point = point
            contacts(fill(body))%hold = hold
            contacts(fill(body))%partner = partner
            fill(body) = fill(body) + 1
         end if
      end subroutine enter

   end subroutine list_contacts

   !> Where joints and loads act on a beam.
   subroutine find_places(self, system, index, contacts, place, patch, hold, held)
      type(indicators_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      integer, intent(in) :: index
      !> Those of the beam
      type(contact_type), intent(in) :: contacts(:)
      !> Coordinates along the beam, all different, and what joints do there
      real(wp), allocatable, intent(out) :: place(:)
      !> Loads along the beam among them, each at its mean place (places)
      type(patch_type), allocatable, intent(out) :: patch(:)
      integer, allocatable, intent(out) :: hold(:)
      !> Whether two places are pinned or welded to the same other body
      logical, intent(out) :: held
      real(wp) :: found(size(contacts)), x
      integer :: found_hold(size(contacts)), own
      type(patch_type) :: spread_out(size(contacts))
      integer :: i, k, count, spread
      count = 0
      found_hold = hold_none
      held = .false.
      associate (body => system%model%bodies(index))
         do i = 1, size(contacts)
            x = min(max(system%model%points(contacts(i)%point)%p0(1) + body%choice%origin, 0.0_wp), body%beam%length)
            spread = findloc(system%model%spreads%point, contacts(i)%point, dim=1)
            do k = 1, count
               if (spread == 0 .and. .not. allocated(spread_out(k)%at) .and. abs(found(k) - x) <= 1.0e-9_wp*body%beam%length) exit
            end do
            if (k > count) then
               count = k
               found(k) = x
               if (spread > 0) call spread_parts(system%model%spreads(spread), body, [real(wp) ::], spread_out(k)%at, &
                  & spread_out(k)%part)
            end if
            own = contacts(i)%hold
            if (own == hold_clamp) own = merge(hold_clamp, hold_some, keeps_angle(system, contacts(i)%partner))
            if (own == hold_hinge .and. found_hold(k) /= hold_none) own = found_hold(k)
            if (own == hold_some .and. found_hold(k) == hold_clamp) own = hold_clamp
            if (own > hold_none) found_hold(k) = own
            self%place(contacts(i)%point) = k
         end do
      end associate
      do i = 1, size(contacts)
         do k = 1, i - 1
            if (contacts(i)%partner < 0 .or. contacts(i)%partner /= contacts(k)%partner) cycle
            held = held .or. self%place(contacts(i)%point) /= self%place(contacts(k)%point)
         end do
      end do
      allocate (place, source=found(:count))
      allocate (patch, source=spread_out(:count))
      allocate (hold, source=found_hold(:count))
   end subroutine find_places

   !> Whether a body cannot turn: the ground, a base, and what a joint to the ground guides without a rotation.
   pure logical function keeps_angle(system, body)
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      integer :: i
      keeps_angle = is_base(system, body)
      do i = 1, size(system%model%joints)
         if (keeps_angle) return
         if (.not. system%model%joints(i)%keeps_angle .or. system%model%joints(i)%switch /= 0) cycle
         associate (bodies => system%constraints(i)%item%bodies)
            keeps_angle = any(bodies == body) .and. any(bodies == ground)
         end associate
      end do
   end function keeps_angle

end module limber_monitor_indicator_start
