!> Indicators of beams at a state. Floor: monitor. Source: doc/theory, eqs. (7.8)-(7.11), (7.15)-(7.17), (7.25)-(7.27).
module limber_monitor_observation
   use limber_base_kinds, only: wp
   use limber_beam_quasistatic_deflection, only: find_deflection
   use limber_monitor_indicators, only: indicators_type, body_indicators_type, raise_peak, peak_deflection, peak_slope, &
      & peak_rotation, peak_compression, peak_tension, peak_energy, peak_kinetic, peak_left_out, peak_axial, &
      & peak_coarse, peak_lost, peak_quartic, peak_bent, peak_stretch, &
      & peak_unstretched, peak_strained, peak_axial_grown, peak_coarse_grown, peak_quartic_grown, peak_growth, peak_pull, &
      & peak_own_pull, add_geometric, add_vibration, raise_recoil_force, tell_drawn
   use limber_monitor_beam_shortening, only: add_shortening, observe_recoil, observe_drawn
   use limber_monitor_drawn_channels, only: observe_drawn_channels
   use limber_beam_monitored_sections, only: monitored_sections_type
   use limber_monitor_false_damping, only: observe_false_damping
   use limber_monitor_function_watch, only: observe_functions
   use limber_monitor_lumping_phase, only: observe_phase, observe_swings
   use limber_monitor_modal_sudden, only: observe_modal_sudden
   use limber_monitor_frame_watch, only: observe_frames
   use limber_model_model, only: body_type, ground
   use limber_multibody_plane_vectors, only: cross
   use limber_multibody_point_motion, only: point_position
   use limber_multibody_system, only: system_type, workspace_type
   use limber_output_point_forces, only: pull_type, constraint_pulls, load_pulls, most_pulls
   implicit none
   private
   public :: observe

   !> Least part of the stiffness that a compression leaves, of which an error is a part
   real(wp), parameter :: softest = 0.02_wp

contains

   !> Takes a state into the maxima. Kinematics are placed and moved there; Jacobians and multipliers are those of the state.
   subroutine observe(self, system, work, t, q, v, a)
      type(indicators_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      !> Time
      real(wp), intent(in) :: t
      !> Coordinates, velocities, accelerations (nq)
      real(wp), contiguous, intent(in) :: q(:), v(:), a(:)
      integer :: i, first, last
      call observe_functions(self%functions, system, work, t, q, v, a)
      if (size(self%bodies) == 0) return
      self%observations = self%observations + 1
      do i = 1, size(self%bodies)
         first = system%layout%q(self%bodies(i)%body)
         last = first + 3 + system%layout%n(self%bodies(i)%body)
         associate (u => q(first + 2:first + 3), eta => q(first + 4:last), rate => v(first + 4:last))
            call observe_motion(self%bodies(i), system%model%bodies(self%bodies(i)%body), t, &
               & cross(u, v(first + 2:first + 3)), eta, rate)
            if (self%bodies(i)%is_rigid) self%bodies(i)%pressed = 0.0_wp
            call observe_false_damping(self%bodies(i)%false_damping, system%model%bodies(self%bodies(i)%body)%reduced, t, &
               & cross(u, v(first + 2:first + 3)), eta, rate)
            if (self%bodies(i)%sudden%body > 0) call observe_modal_sudden(self%bodies(i)%sudden, system, work, &
               & self%functions%kind, t, q, v, a)
            call observe_phase(self%bodies(i)%phase, system, work, self%bodies(i)%body, t, q, v, a)
            if (.not. self%bodies(i)%is_beam) cycle
            associate (stations => self%sets(self%bodies(i)%set)%stations)
               call bend(self%bodies(i), stations, t, eta)
               call observe_drawn(self%bodies(i), stations, system%model, t, rate, a(first + 4:last), self%drawn)
               call start_amplitudes(self%bodies(i), stations, a(first:first + 1) - system%model%gravity, u, &
                  & cross(u, v(first + 2:first + 3)), cross(u, a(first + 2:first + 3)), eta, rate, a(first + 4:last))
               if (self%bodies(i)%held) cycle
               associate (body => system%model%bodies(self%bodies(i)%body))
                  call add_vibration(self%bodies(i), body%reduced%omega2, t, eta, rate, a(first + 4:last))
                  call add_shortening(self%bodies(i), stations, body, rate)
                  call observe_recoil(self%bodies(i), stations, body, t, rate, a(first + 4:last))
               end associate
            end associate
         end associate
      end do
      call observe_swings(self%bodies%phase, self%bodies%body, system, v, q, self%swings)
      if (self%swings(2) > 0.0_wp) self%bodies%phase%swing = 0.5_wp*self%swings(1)/self%swings(2)
      call add_reactions(self, system, work, q)
      call add_loads(self, system, work, q)
      call observe_frames(self, system, work, t, q, v, a)
      if (size(self%drawn%channels) > 0) then
         call observe_drawn_channels(self%drawn, system, work, t, q, v, a)
         call tell_drawn(self)
      end if
      do i = 1, size(self%bodies)
         if (self%bodies(i)%is_rigid) then
            first = system%layout%q(self%bodies(i)%body)
            call observe_rigid(self%bodies(i), t, q(first + 2:first + 3), v(first + 2:first + 3), &
               & a(first:first + 1) - system%model%gravity, a(first + 2:first + 3))
         end if
         if (.not. self%bodies(i)%is_beam) cycle
         first = system%layout%q(self%bodies(i)%body) + 4
         last = first + system%layout%n(self%bodies(i)%body) - 1
         call observe_forces(self%bodies(i), self%sets(self%bodies(i)%set)%stations, system%model%bodies(self%bodies(i)%body), t, &
            & q(first:last))
      end do
   end subroutine observe

   !> Rotation and energies; of a frame deflection and slope.
   pure subroutine observe_motion(self, body, t, omega, eta, rate)
      type(body_indicators_type), intent(inout) :: self
      type(body_type), intent(in) :: body
      !> Time, angular velocity of the frame, coordinates and their rates (n)
      real(wp), intent(in) :: t, omega, eta(:), rate(:)
      real(wp) :: deflection, slope, elastic, kinetic, bent, part
      integer :: k
      elastic = 0.0_wp
      kinetic = 0.0_wp
      bent = 0.0_wp
      do k = 1, body%reduced%bending
         part = body%reduced%omega2(k)*eta(k)**2
         elastic = elastic + part
         kinetic = kinetic + rate(k)**2
         bent = bent + eta(k)**2
         if (part > self%modal(k)) then
            self%modal(k) = part
            self%modal_time(k) = t
         end if
         self%moving(k) = max(self%moving(k), rate(k)**2)
      end do
      if (body%is_frame) then
         call frame_extremes(body%shape, eta, deflection, slope)
         call raise_peak(self, peak_deflection, deflection/self%length, t)
         call raise_peak(self, peak_slope, slope, t)
      end if
      call raise_peak(self, peak_rotation, abs(omega)/self%first_frequency, t)
      call raise_peak(self, peak_energy, elastic, t)
      call raise_peak(self, peak_kinetic, kinetic, t)
      call raise_peak(self, peak_bent, bent, t)
   end subroutine observe_motion

   !> What a rigid beam would do if it were elastic: eqs. (7.32)-(7.35).
   subroutine observe_rigid(self, t, u, turning, heavy, turned)
      type(body_indicators_type), intent(inout) :: self
      !> Time; unit vector of the frame, its rate and acceleration (2); acceleration of the origin less that of gravity (2)
      real(wp), intent(in) :: t, u(2), turning(2), heavy(2), turned(2)
      real(wp) :: deflection, seen(3), axial
      call find_deflection(self%quasistatic, dot_product(u, heavy), cross(u, heavy), cross(u, turning), cross(u, turned), &
         & self%pressed, deflection, seen, axial)
      call raise_peak(self, peak_deflection, deflection/self%length, t)
      call raise_peak(self, peak_compression, -axial/self%quasistatic%euler, t)
      call raise_peak(self, peak_tension, axial/self%quasistatic%euler, t)
      call raise_peak(self, peak_energy, (self%first_frequency*maxval(abs(seen)))**2, t)
      if (self%looks > 0 .and. t > self%seen_at) call raise_peak(self, peak_kinetic, &
         & (maxval(abs(seen - self%seen))/(t - self%seen_at))**2, t)
      self%seen = seen
      self%seen_at = t
      self%looks = self%looks + 1
   end subroutine observe_rigid

   !> Deflection and slope of a beam at its stations.
   pure subroutine bend(self, stations, t, eta)
      type(body_indicators_type), intent(inout) :: self
      type(monitored_sections_type), intent(in) :: stations
      real(wp), intent(in) :: t, eta(:)
      real(wp) :: deflection, slope, part
      integer :: k, s
      deflection = 0.0_wp
      slope = 0.0_wp
      do s = 1, stations%count + 2
         part = 0.0_wp
         do k = 1, stations%bending
            part = part + stations%deflection(k, s)*eta(k)
         end do
         deflection = max(deflection, abs(part))
      end do
      do s = 1, stations%count
         self%slope(s) = 0.0_wp
         do k = 1, stations%bending
            self%slope(s) = self%slope(s) + stations%slope(k, s)*eta(k)
         end do
         slope = max(slope, abs(self%slope(s)))
      end do
      call raise_peak(self, peak_deflection, deflection/self%length, t)
      call raise_peak(self, peak_slope, slope, t)
   end subroutine bend

   !> Largest displacement and rotation of the nodes of a frame.
   pure subroutine frame_extremes(shape, eta, deflection, slope)
      !> (3, nodes, n)
      real(wp), intent(in) :: shape(:, :, :), eta(:)
      real(wp), intent(out) :: deflection, slope
      real(wp) :: u(3)
      integer :: i, k
      deflection = 0.0_wp
      slope = 0.0_wp
      do i = 1, size(shape, 2)
         u = 0.0_wp
         do k = 1, size(eta)
            u = u + shape(:, i, k)*eta(k)
         end do
         deflection = max(deflection, norm2(u(1:2)))
         slope = max(slope, abs(u(3)))
      end do
   end subroutine frame_extremes

   !> Amplitudes of the inertia, eq. (7.9); those of the places are zero.
   pure subroutine start_amplitudes(self, stations, heavy, u, omega, alpha, eta, rate, acceleration)
      type(body_indicators_type), intent(inout) :: self
      type(monitored_sections_type), intent(in) :: stations
      !> Acceleration of the frame's origin less that of gravity, along the fixed axes (2); unit vector of the frame (2)
      real(wp), intent(in) :: heavy(2), u(2)
      !> Angular velocity and acceleration; coordinates, their rates and accelerations (n)
      real(wp), intent(in) :: omega, alpha, eta(:), rate(:), acceleration(:)
      integer :: k, b
      b = stations%bending
      self%along = 0.0_wp
      self%along(1) = -dot_product(u, heavy)
      self%along(2) = omega**2
      do k = 1, stations%axial
         self%along(2 + k) = omega**2*eta(b + k) - acceleration(b + k)
      end do
      do k = 1, b
         self%along(2 + stations%axial + k) = alpha*eta(k) + 2*omega*rate(k)
      end do
      self%across = 0.0_wp
      self%across(1) = -cross(u, heavy)
      self%across(2) = -alpha
      self%own = omega**2*eta(:b) - acceleration(:b)
   end subroutine start_amplitudes

   !> Forces of joints and drivers.
   subroutine add_reactions(self, system, work, q)
      type(indicators_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      real(wp), intent(in) :: q(:)
      type(pull_type) :: pulls(most_pulls)
      real(wp) :: force(3)
      integer :: i, side, row, k, count
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            if (self%pulls%pair(i)) then
               call constraint_pulls(self%pulls, work, item, pulls, count)
               call add_pulls(self, system, pulls(:count), q)
               cycle
            end if
            do side = 1, 2
               if (item%bodies(side) == ground .or. item%points(side) == 0) cycle
               if (self%place(item%points(side)) == 0) cycle
               force = 0.0_wp
               do row = 1, item%rows
                  do k = 1, 3
                     force(k) = force(k) - work%lambda(item%first + row - 1)*work%jacobians(side, i)%z(row, k)
                  end do
               end do
               call add_force(self, system, item%bodies(side), item%points(side), force, self%fixed(side, i), q)
            end do
         end associate
      end do
   end subroutine add_reactions

   !> Forces of loads.
   subroutine add_loads(self, system, work, q)
      type(indicators_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      real(wp), intent(in) :: q(:)
      type(pull_type) :: pulls(most_pulls)
      integer :: i, side, count
      logical :: at_points
      do i = 1, size(system%loads)
         associate (item => system%loads(i)%item)
            at_points = .false.
            do side = 1, size(item%points)
               if (item%bodies(side) == ground .or. item%points(side) == 0) cycle
               at_points = at_points .or. self%place(item%points(side)) > 0
            end do
            if (.not. at_points) cycle
            if (self%pulls%load(i)) then
               call load_pulls(self%pulls, work, item, pulls, count)
               call add_pulls(self, system, pulls(:count), q)
               cycle
            end if
            self%scratch = 0.0_wp
            call item%add_force(work%kinematics, self%scratch(:sum(item%rates)))
            if (item%is_scaled) self%scratch = item%share*self%scratch
            do side = 1, size(item%points)
               if (item%bodies(side) == ground .or. item%points(side) == 0) cycle
               if (self%place(item%points(side)) == 0) cycle
               call add_force(self, system, item%bodies(side), item%points(side), &
                  & self%scratch(item%offsets(side) + 1:item%offsets(side) + 3), &
                  & system%model%points(item%points(side))%member > 0, q)
            end do
         end associate
      end do
   end subroutine add_loads

   !> Those forces among others that act on beams.
   pure subroutine add_pulls(self, system, pulls, q)
      type(indicators_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(pull_type), intent(in) :: pulls(:)
      real(wp), intent(in) :: q(:)
      integer :: j
      do j = 1, size(pulls)
         if (pulls(j)%body == ground .or. pulls(j)%point == 0) cycle
         if (self%place(pulls(j)%point) > 0) call add_force(self, system, pulls(j)%body, pulls(j)%point, pulls(j)%force, .true., q)
      end do
   end subroutine add_pulls

   !> A force and its moment about the origin of a beam's frame, as forces along and across it and a couple at a place.
   pure subroutine add_force(self, system, body, point, force, is_fixed, q)
      type(indicators_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      integer, intent(in) :: body, point
      !> Along the fixed axes (2), and moment
      real(wp), intent(in) :: force(3)
      !> Whether it bends the beam at this point
      logical, intent(in) :: is_fixed
      real(wp), intent(in) :: q(:)
      real(wp) :: u(2), arm(2)
      integer :: first, at
      first = system%layout%q(body)
      u = q(first + 2:first + 3)
      at = self%place(point)
      associate (own => self%bodies(self%of(body)))
         if (own%is_rigid) then
            own%pressed(1, at) = own%pressed(1, at) + dot_product(u, force(1:2))
            if (.not. is_fixed) return
            arm = point_position(system%model, system%layout, system%model%points(point), q) - q(first:first + 1)
            own%pressed(2, at) = own%pressed(2, at) + cross(u, force(1:2))
            own%pressed(3, at) = own%pressed(3, at) + force(3) - cross(arm, force(1:2))
         end if
         if (.not. own%is_beam) return
         associate (k => 2 + self%sets(own%set)%stations%axial + self%sets(own%set)%stations%bending + at)
            own%along(k) = own%along(k) + dot_product(u, force(1:2))
         end associate
         if (.not. is_fixed) return
         own%across(1 + 2*at) = own%across(1 + 2*at) + cross(u, force(1:2))
         arm = point_position(system%model, system%layout, system%model%points(point), q)
         arm = arm - q(first:first + 1)
         own%across(2 + 2*at) = own%across(2 + 2*at) + force(3) - cross(arm, force(1:2))
      end associate
   end subroutine add_force

   !> How far a small deflection grows while the compression is on the mean beyond Euler's load, eq. (7.13).
   pure subroutine observe_growth(self, t, compression)
      type(body_indicators_type), intent(inout) :: self
      !> Time; compression in parts of Euler's load
      real(wp), intent(in) :: t, compression
      if (t > self%pressed_at) self%overload = self%overload + (t - self%pressed_at)*(0.5_wp*(compression + self%compression) - 1)
      if (.not. self%overload > 0.0_wp) then
         self%overload = 0.0_wp
         self%since = t
      end if
      self%compression = compression
      self%pressed_at = t
      call raise_peak(self, peak_growth, self%first_frequency*sqrt(self%overload*max(0.0_wp, t - self%since)), t)
   end subroutine observe_growth

   !> Axial force, its work on the bending, what the model has of it, and what the coordinates cannot carry.
   pure subroutine observe_forces(self, stations, body, t, eta)
      type(body_indicators_type), intent(inout) :: self
      type(monitored_sections_type), intent(in) :: stations
      type(body_type), intent(in) :: body
      real(wp), intent(in) :: t, eta(:)
      real(wp) :: load, work, lack, coarse, growth, elastic, left_out, lost, row, foreshortening, quartic, &
         & strained
      integer :: s, k
      load = 0.0_wp
      work = 0.0_wp
      quartic = 0.0_wp
      strained = 0.0_wp
      foreshortening = 0.0_wp
      if (stations%membrane > 0.0_wp) foreshortening = sum(stations%weight*self%slope**2)
      do s = 1, stations%count
         self%force(s) = 0.0_wp
         do k = 1, size(self%along)
            self%force(s) = self%force(s) + stations%pull(k, s)*self%along(k)
         end do
         self%force(s) = self%force(s) + stations%membrane*foreshortening
         load = load + stations%buckling(s)*self%force(s)
         work = work + stations%weight(s)*self%force(s)*self%slope(s)**2
         quartic = quartic + 0.5_wp*stations%weight(s)*self%force(s)*self%slope(s)**4
         strained = strained + stations%weight(s)*(min(0.0_wp, self%force(s))*self%slope(s))**2/body%beam%ea
      end do
      call observe_pull(self, stations, t)
      call compare_tension(self, stations, body, eta, lack, coarse)
      growth = 1/max(softest, 1 + min(load, 0.0_wp))**2
      call compare_length(self, stations, body, t, eta)
      elastic = 0.0_wp
      lost = 0.0_wp
      do k = 1, stations%bending
         elastic = elastic + body%reduced%omega2(k)*eta(k)**2
         row = stations%lost(k, 1)*self%across(1) + stations%lost(k, 2)*self%across(2)
         do s = 1, stations%bending
            row = row + stations%lost(k, 2 + s)*self%own(s)
         end do
         lost = lost + row**2/body%reduced%omega2(k)
      end do
      left_out = 0.0_wp
      do s = 1, size(self%across)
         row = 0.0_wp
         do k = 1, size(self%across)
            row = row + stations%left_out(k, s)*self%across(k)
         end do
         left_out = left_out + row*self%across(s)
      end do
      call raise_peak(self, peak_compression, -load, t)
      call observe_growth(self, t, -load)
      call raise_peak(self, peak_tension, load, t)
      call add_geometric(self, work, elastic, t)
      call raise_peak(self, peak_axial, lack, t)
      call raise_peak(self, peak_coarse, coarse, t)
      ! Where the bending follows slowly, a compression makes changes of the deflection larger
      call raise_peak(self, peak_axial_grown, growth*lack, t)
      call raise_peak(self, peak_coarse_grown, growth*coarse, t)
      call raise_peak(self, peak_left_out, left_out, t)
      call raise_peak(self, peak_lost, lost, t)
      call raise_peak(self, peak_quartic, abs(quartic), t)
      call raise_peak(self, peak_quartic_grown, abs(quartic), t)
      call raise_peak(self, peak_strained, strained/max(softest, 1 + min(load, 0.0_wp)), t)
   end subroutine observe_forces

   !> Largest axial force, and largest one or load, so far; and what the shortening adds to that, eq. (7.47).
   pure subroutine observe_pull(self, stations, t)
      type(body_indicators_type), intent(inout) :: self
      type(monitored_sections_type), intent(in) :: stations
      real(wp), intent(in) :: t
      integer :: at, from
      if (.not. self%shows_force) return
      from = size(self%along) - stations%places
      call raise_peak(self, peak_own_pull, maxval(abs(self%force)), t)
      do at = 1, stations%places
         call raise_peak(self, peak_pull, norm2([self%along(from + at), self%across(1 + 2*at)]), t)
      end do
      call raise_peak(self, peak_pull, self%peak(peak_own_pull), t)
      if (.not. self%held) call raise_recoil_force(self, self%drawing_in%force, t)
   end subroutine observe_pull

   !> What the axial force that the model lacks does to the bending: by its means in the k_G elements, and by what varies about
   !> them; squares of the change: in energy, eqs. (7.15), (7.16).
   pure subroutine compare_tension(self, stations, body, eta, lack, coarse)
      type(body_indicators_type), intent(inout) :: self
      type(monitored_sections_type), intent(in) :: stations
      type(body_type), intent(in) :: body
      real(wp), intent(in) :: eta(:)
      real(wp), intent(out) :: lack, coarse
      real(wp) :: length, mean, tilt, tension, part
      integer :: g, s, k, j, from, each
      self%push = 0.0_wp
      each = stations%count/stations%elements
      do g = 1, stations%elements
         from = (g - 1)*each
         length = 0.0_wp
         mean = 0.0_wp
         tilt = 0.0_wp
         do s = from + 1, from + each
            length = length + stations%weight(s)
            mean = mean + stations%weight(s)*self%force(s)
            tilt = tilt + stations%weight(s)*self%force(s)*stations%xi(s)
         end do
         mean = mean/length
         tilt = merge(3*tilt/length, 0.0_wp, stations%linear)
         do s = from + 1, from + each
            tension = 0.0_wp
            do k = 1, stations%axial
               tension = tension + stations%strain(k, s)*eta(stations%bending + k)
            end do
            do j = 1, stations%bending
               part = stations%weight(s)*self%slope(s)*stations%slope(j, s)
               self%push(1, j) = self%push(1, j) + part*(tension - mean - tilt*stations%xi(s))
               self%push(2, j) = self%push(2, j) + part*(self%force(s) - mean - tilt*stations%xi(s))
               self%push(3, j) = self%push(3, j) + stations%weight(s)*self%force(s)*stations%slope(j, s)**2
            end do
         end do
      end do
      lack = 0.0_wp
      coarse = 0.0_wp
      do j = 1, stations%bending
         part = body%reduced%omega2(j) + max(self%push(3, j), 0.0_wp)
         lack = lack + self%push(1, j)**2/part
         coarse = coarse + self%push(2, j)**2/part
      end do
   end subroutine compare_tension

   !> How much longer the axial forces make a beam, and how much of that its axial functions do not have, eq. (7.18).
   pure subroutine compare_length(self, stations, body, t, eta)
      type(body_indicators_type), intent(inout) :: self
      type(monitored_sections_type), intent(in) :: stations
      type(body_type), intent(in) :: body
      real(wp), intent(in) :: t, eta(:)
      real(wp) :: elongation, own
      integer :: s, k
      if (self%held) return
      elongation = 0.0_wp
      own = 0.0_wp
      do s = 1, stations%count
         elongation = elongation + stations%weight(s)*self%force(s)/body%beam%ea
      end do
      do k = 1, stations%axial
         own = own + stations%stretch(k)*eta(stations%bending + k)
      end do
      call raise_peak(self, peak_stretch, abs(elongation)/self%length, t)
      call raise_peak(self, peak_unstretched, abs(elongation - own)/self%length, t)
   end subroutine compare_length

end module limber_monitor_observation
