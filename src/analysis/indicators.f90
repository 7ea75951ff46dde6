!> How far each flexible body is within the range of its model: running maxima of dimensionless indicators, each with its time.
!> An analysis lets a state be observed now and then; nothing is allocated there. `limber_analysis_ranges` judges them.
!>
!>     call start_indicators(indicators, system)                    ! before the first step; makes the constants of each beam
!>     call observe(indicators, system, work, t, q, v, a)           ! at a state with its accelerations and multipliers
!>     value = indicator_value(indicators%bodies(i), indicator_slope)
!>     t = indicator_time(indicators%bodies(i), indicator_slope)
!>
!> Floor: analysis. Source: doc/theory, eqs. (156)-(165).
module limber_analysis_indicators
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_flex_stations, only: stations_type, new_stations
   use limber_model_scene, only: body_type, ground, joint_point_on_line, joint_translational, joint_curve, joint_sliding, &
      & joint_revolute, joint_weld
   use limber_system_algebra, only: cross
   use limber_system_kinematics, only: point_position
   use limber_system_system, only: system_type, workspace_type
   implicit none
   private
   public :: indicators_type, body_indicators_type, start_indicators, observe, join_indicators, indicator_value, indicator_time
   public :: indicator_names, indicator_meanings

   !> Kinds of indicators, those of a body in this order
   integer, parameter, public :: indicator_deflection = 1, indicator_slope = 2, indicator_rotation = 3, indicator_compression = 4, &
      & indicator_tension = 5, indicator_pace = 6, indicator_last_mode = 7, indicator_residual = 8, indicator_geometric = 9, &
      & indicator_axial = 10, indicator_coarseness = 11, indicator_lumping = 12, indicator_shortening = 13, indicator_count = 13

   !> Their names in results, and what they are
   character(*), parameter :: indicator_names(indicator_count) = [character(16) :: 'deflection', 'slope', 'rotation', &
      & 'compression', 'tension', 'pace', 'last_mode', 'residual', 'geometric', 'axial', 'coarseness', 'lumping', 'shortening']
   character(*), parameter :: indicator_meanings(indicator_count) = [character(120) :: &
      & 'largest deflection in the frame / length', &
      & 'largest slope in the frame', &
      & 'largest rotation speed of the frame / first frequency', &
      & 'largest axial compression / Euler load', &
      & 'largest axial tension / Euler load', &
      & 'how dynamic the bending is: sqrt(largest kinetic / largest elastic energy of the coordinates)', &
      & 'part of the last bending coordinate in the energy of bending', &
      & 'part of the energy of bending that the coordinates cannot carry', &
      & 'largest work of the axial force on the bending / energy of bending', &
      & 'relative deflection that the axial force makes which the model lacks in the means of its k_G elements', &
      & 'the same of the variation of the axial force within the k_G elements', &
      & 'error of frequencies and deflections by the lumped masses', &
      & 'work of the axial force on the shortening beyond half of the squared slope / energy of bending']

   !> Maxima that the indicators are made of
   integer, parameter :: peak_deflection = 1, peak_slope = 2, peak_rotation = 3, peak_compression = 4, peak_tension = 5, &
      & peak_energy = 6, peak_kinetic = 7, peak_left_out = 8, peak_geometric = 9, peak_axial = 10, peak_coarse = 11, &
      & peak_stiffness = 12, peak_lost = 13, peak_quartic = 14, peak_bent = 15, peaks = 15

   !> One flexible body
   type :: body_indicators_type
      !> Index of the body in the model, and whether it is a straight beam: a frame has no indicators of axial forces and loads
      integer :: body = 0
      logical :: is_beam = .false.
      !> Whether its model is FULL
      logical :: is_full = .false.
      type(stations_type) :: stations
      !> First frequency, and length or size
      real(wp) :: first_frequency = 1.0_wp, length = 1.0_wp
      !> Maxima and their times; largest energy of each bending coordinate, and its time
      real(wp) :: peak(peaks) = 0.0_wp, time(peaks) = 0.0_wp
      real(wp), allocatable :: modal(:), modal_time(:)
      !> Scratch: slopes and axial forces at the stations, amplitudes along and across, and of the bending coordinates,
      !> forces on these
      real(wp), allocatable, private :: slope(:), force(:), along(:), across(:), own(:), push(:, :)
   end type body_indicators_type

   !> A joint, driver or load that acts on a beam: the point, whether it is a joint that does not slide along the beam, and the other
   !> body of a pin or weld, -1 for others
   type :: contact_type
      integer :: point = 0
      logical :: is_joint = .false.
      integer :: partner = -1
   end type contact_type

   !> All flexible bodies of a scene
   type :: indicators_type
      type(body_indicators_type), allocatable :: bodies(:)
      !> Number of states that were observed
      integer :: observations = 0
      !> Index into `bodies` of each body of the model; 0: none
      integer, allocatable :: of(:)
      !> Place of each point among those of its beam; 0: none (points)
      integer, allocatable, private :: place(:)
      !> Whether the force of a side of a constraint acts at its point across the beam: not if something slides along it
      logical, allocatable, private :: fixed(:, :)
      real(wp), allocatable, private :: scratch(:)
   end type indicators_type

contains

   !> Makes the constants; bodies whose constants cannot be made are left out.
   subroutine start_indicators(self, system)
      type(indicators_type), intent(out) :: self
      type(system_type), intent(in) :: system
      type(contact_type), allocatable :: contacts(:)
      integer :: first(size(system%model%bodies) + 1)
      integer :: i, count, most
      allocate (self%of(size(system%model%bodies)), self%place(size(system%model%points)))
      allocate (self%fixed(2, size(system%constraints)))
      self%of = 0
      self%place = 0
      self%fixed = .true.
      count = 0
      do i = 1, size(self%of)
         if (system%layout%n(i) == 0) cycle
         count = count + 1
         self%of(i) = count
      end do
      allocate (self%bodies(count))
      most = 0
      do i = 1, size(system%loads)
         most = max(most, sum(system%loads(i)%item%rates))
      end do
      allocate (self%scratch(most))
      if (count == 0) return
      do i = 1, size(system%model%joints)
         select case (system%model%joints(i)%kind)
         case (joint_point_on_line, joint_translational, joint_curve, joint_sliding)
            self%fixed(2, i) = .false.
         end select
      end do
      call list_contacts(self, system, first, contacts)
      do i = 1, size(self%of)
         if (self%of(i) > 0) call start_body(self, system, i, contacts(first(i):first(i + 1) - 1), self%bodies(self%of(i)))
      end do
   end subroutine start_indicators

   !> The constants of one body.
   subroutine start_body(self, system, index, contacts, body)
      type(indicators_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      integer, intent(in) :: index
      type(contact_type), intent(in) :: contacts(:)
      type(body_indicators_type), intent(inout) :: body
      type(error_type), allocatable :: error
      real(wp), allocatable :: place(:)
      logical, allocatable :: jointed(:)
      logical :: held
      body%body = index
      associate (flexible => system%model%bodies(index))
         body%is_beam = .not. flexible%is_frame .and. flexible%reduced%bending > 0
         body%first_frequency = sqrt(minval(flexible%reduced%omega2))
         body%length = flexible%size
         body%is_full = flexible%reduced%full
         allocate (body%modal(flexible%reduced%bending), body%modal_time(flexible%reduced%bending))
         body%modal = 0.0_wp
         body%modal_time = 0.0_wp
         if (.not. body%is_beam) return
         call find_places(self, system, index, contacts, place, jointed, held)
         call new_stations(flexible%beam, flexible%choice, flexible%field, flexible%reduced, place, jointed, held, &
            & body%stations, error)
         body%is_beam = .not. allocated(error)
         associate (stations => body%stations)
            allocate (body%slope(stations%count), body%force(stations%count))
            allocate (body%along(size(stations%pull, 1)), body%across(2 + 2*size(place)), body%own(stations%bending), &
               & body%push(3, stations%bending))
         end associate
      end associate
   end subroutine start_body

   !> What acts on flexible bodies, body by body.
   subroutine list_contacts(self, system, first, contacts)
      type(indicators_type), intent(in) :: self
      type(system_type), intent(in) :: system
      !> Where the contacts of a body begin (bodies + 1)
      integer, intent(out) :: first(:)
      type(contact_type), allocatable, intent(out) :: contacts(:)
      integer :: pass, i, side, fill(size(first)), partner
      first = 0
      do pass = 1, 2
         do i = 1, size(system%constraints)
            associate (item => system%constraints(i)%item)
               do side = 1, 2
                  partner = -1
                  if (i <= size(system%model%joints)) then
                     if (any(system%model%joints(i)%kind == [joint_revolute, joint_weld])) partner = item%bodies(3 - side)
                  end if
                  call enter(item%bodies(side), item%points(side), i <= size(system%model%joints) .and. self%fixed(side, i), &
                     & partner)
               end do
            end associate
         end do
         do i = 1, size(system%loads)
            associate (item => system%loads(i)%item)
               do side = 1, size(item%points)
                  call enter(item%bodies(side), item%points(side), .false., -1)
               end do
            end associate
         end do
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
      subroutine enter(body, point, is_joint, partner)
         integer, intent(in) :: body, point, partner
         logical, intent(in) :: is_joint
         if (body == ground .or. point == 0) return
         if (self%of(body) == 0) return
         if (pass == 1) then
            first(body + 1) = first(body + 1) + 1
         else
            contacts(fill(body))%point = point
            contacts(fill(body))%is_joint = is_joint
            contacts(fill(body))%partner = partner
            fill(body) = fill(body) + 1
         end if
      end subroutine enter

   end subroutine list_contacts

   !> Where joints and loads act on a beam.
   subroutine find_places(self, system, index, contacts, place, jointed, held)
      type(indicators_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      integer, intent(in) :: index
      !> Those of the beam
      type(contact_type), intent(in) :: contacts(:)
      !> Coordinates along the beam, all different, and whether joints act there
      real(wp), allocatable, intent(out) :: place(:)
      logical, allocatable, intent(out) :: jointed(:)
      !> Whether two places are pinned or welded to the same other body
      logical, intent(out) :: held
      real(wp) :: found(size(contacts)), x
      logical :: joint(size(contacts))
      integer :: i, k, count
      count = 0
      joint = .false.
      held = .false.
      associate (body => system%model%bodies(index))
         do i = 1, size(contacts)
            x = min(max(system%model%points(contacts(i)%point)%p0(1) + body%choice%origin, 0.0_wp), body%beam%length)
            do k = 1, count
               if (abs(found(k) - x) <= 1.0e-9_wp*body%beam%length) exit
            end do
            if (k > count) then
               count = k
               found(k) = x
            end if
            joint(k) = joint(k) .or. contacts(i)%is_joint
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
      allocate (jointed, source=joint(:count))
   end subroutine find_places

   !> Takes a state into the maxima. Kinematics are placed and moved there; Jacobians and multipliers are those of the state.
   subroutine observe(self, system, work, t, q, v, a)
      type(indicators_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      !> Time; coordinates, velocities, accelerations (nq)
      real(wp), intent(in) :: t, q(:), v(:), a(:)
      integer :: i, first, last
      if (size(self%bodies) == 0) return
      self%observations = self%observations + 1
      do i = 1, size(self%bodies)
         first = system%layout%q(self%bodies(i)%body)
         last = first + 3 + system%layout%n(self%bodies(i)%body)
         associate (u => q(first + 2:first + 3), eta => q(first + 4:last), rate => v(first + 4:last))
            call observe_motion(self%bodies(i), system%model%bodies(self%bodies(i)%body), t, &
               & cross(u, v(first + 2:first + 3)), eta, rate)
            if (self%bodies(i)%is_beam) call start_amplitudes(self%bodies(i), a(first:first + 1) - system%model%gravity, u, &
               & cross(u, v(first + 2:first + 3)), cross(u, a(first + 2:first + 3)), eta, rate, a(first + 4:last))
         end associate
      end do
      call add_reactions(self, system, work, q)
      call add_loads(self, system, work, q)
      do i = 1, size(self%bodies)
         if (.not. self%bodies(i)%is_beam) cycle
         first = system%layout%q(self%bodies(i)%body) + 4
         last = first + system%layout%n(self%bodies(i)%body) - 1
         call observe_forces(self%bodies(i), system%model%bodies(self%bodies(i)%body), t, q(first:last))
      end do
   end subroutine observe

   !> Deflection, slope, rotation and energies.
   pure subroutine observe_motion(self, body, t, omega, eta, rate)
      type(body_indicators_type), intent(inout) :: self
      type(body_type), intent(in) :: body
      !> Time, angular velocity of the frame, coordinates and their rates (n)
      real(wp), intent(in) :: t, omega, eta(:), rate(:)
      real(wp) :: deflection, slope, elastic, kinetic, bent, part
      integer :: k, s
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
      end do
      deflection = 0.0_wp
      slope = 0.0_wp
      if (self%is_beam) then
         do s = 1, self%stations%count + 2
            part = 0.0_wp
            do k = 1, self%stations%bending
               part = part + self%stations%deflection(k, s)*eta(k)
            end do
            deflection = max(deflection, abs(part))
         end do
         do s = 1, self%stations%count
            self%slope(s) = 0.0_wp
            do k = 1, self%stations%bending
               self%slope(s) = self%slope(s) + self%stations%slope(k, s)*eta(k)
            end do
            slope = max(slope, abs(self%slope(s)))
         end do
      else if (body%is_frame) then
         call frame_extremes(body%shape, eta, deflection, slope)
      end if
      call raise_peak(self, peak_deflection, deflection/self%length, t)
      call raise_peak(self, peak_slope, slope, t)
      call raise_peak(self, peak_rotation, abs(omega)/self%first_frequency, t)
      call raise_peak(self, peak_energy, elastic, t)
      call raise_peak(self, peak_kinetic, kinetic, t)
      call raise_peak(self, peak_bent, bent, t)
   end subroutine observe_motion

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

   !> Amplitudes of the inertia, eq. (157); those of the places are zero.
   pure subroutine start_amplitudes(self, heavy, u, omega, alpha, eta, rate, acceleration)
      type(body_indicators_type), intent(inout) :: self
      !> Acceleration of the frame's origin less that of gravity, along the fixed axes (2); unit vector of the frame (2)
      real(wp), intent(in) :: heavy(2), u(2)
      !> Angular velocity and acceleration; coordinates, their rates and accelerations (n)
      real(wp), intent(in) :: omega, alpha, eta(:), rate(:), acceleration(:)
      integer :: k, b
      b = self%stations%bending
      self%along = 0.0_wp
      self%along(1) = -dot_product(u, heavy)
      self%along(2) = omega**2
      do k = 1, self%stations%axial
         self%along(2 + k) = omega**2*eta(b + k) - acceleration(b + k)
      end do
      do k = 1, b
         self%along(2 + self%stations%axial + k) = alpha*eta(k) + 2*omega*rate(k)
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
      real(wp) :: force(3)
      integer :: i, side, row, k
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
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
      integer :: i, side
      logical :: at_points
      do i = 1, size(system%loads)
         associate (item => system%loads(i)%item)
            at_points = .false.
            do side = 1, size(item%points)
               if (item%bodies(side) == ground .or. item%points(side) == 0) cycle
               at_points = at_points .or. self%place(item%points(side)) > 0
            end do
            if (.not. at_points) cycle
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
         if (.not. own%is_beam) return
         associate (k => 2 + own%stations%axial + own%stations%bending + at)
            own%along(k) = own%along(k) + dot_product(u, force(1:2))
         end associate
         if (.not. is_fixed) return
         own%across(1 + 2*at) = own%across(1 + 2*at) + cross(u, force(1:2))
         arm = point_position(system%layout, system%model%points(point), q)
         arm = arm - q(first:first + 1)
         own%across(2 + 2*at) = own%across(2 + 2*at) + force(3) - cross(arm, force(1:2))
      end associate
   end subroutine add_force

   !> Axial force, its work on the bending, what the model has of it, and what the coordinates cannot carry.
   pure subroutine observe_forces(self, body, t, eta)
      type(body_indicators_type), intent(inout) :: self
      type(body_type), intent(in) :: body
      real(wp), intent(in) :: t, eta(:)
      real(wp) :: load, work, lack, coarse, elastic, left_out, lost, row, foreshortening, quartic
      integer :: s, k
      associate (stations => self%stations)
         load = 0.0_wp
         work = 0.0_wp
         quartic = 0.0_wp
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
         end do
         call compare_tension(self, body, eta, lack, coarse)
         ! Axial coordinates that follow at rest hold no stretch in the motion: limber_analysis_axial judges these
         if (body%reduced%condensed) lack = 0.0_wp
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
      end associate
      call raise_peak(self, peak_compression, -load, t)
      call raise_peak(self, peak_tension, load, t)
      call raise_peak(self, peak_geometric, abs(work), t)
      call raise_peak(self, peak_stiffness, elastic + max(work, 0.0_wp), t)
      call raise_peak(self, peak_axial, lack, t)
      call raise_peak(self, peak_coarse, coarse, t)
      call raise_peak(self, peak_left_out, left_out, t)
      call raise_peak(self, peak_lost, lost, t)
      call raise_peak(self, peak_quartic, abs(quartic), t)
   end subroutine observe_forces

   !> What the axial force that the model lacks does to the bending: by its means in the k_G elements, and by what varies about them;
   !> squares of the change: in energy, of what FULL lacks in deflection, eqs. (160), (161).
   pure subroutine compare_tension(self, body, eta, lack, coarse)
      type(body_indicators_type), intent(inout) :: self
      type(body_type), intent(in) :: body
      real(wp), intent(in) :: eta(:)
      real(wp), intent(out) :: lack, coarse
      real(wp) :: length, mean, tilt, own, tension, part
      integer :: g, s, k, j, from, each
      self%push = 0.0_wp
      associate (stations => self%stations)
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
            own = 0.0_wp
            if (size(stations%slopes, 3) > 0) then
               do j = 1, stations%bending
                  do k = 1, stations%bending
                     own = own + eta(k)*stations%slopes(k, j, g)*eta(j)
                  end do
               end do
            end if
            do s = from + 1, from + each
               tension = own
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
            lack = lack + merge((self%push(1, j)/part)**2, self%push(1, j)**2/part, body%reduced%full)
            coarse = coarse + self%push(2, j)**2/part
         end do
      end associate
   end subroutine compare_tension

   pure subroutine raise_peak(self, kind, value, t)
      type(body_indicators_type), intent(inout) :: self
      integer, intent(in) :: kind
      real(wp), intent(in) :: value, t
      if (.not. value > self%peak(kind)) return
      self%peak(kind) = value
      self%time(kind) = t
   end subroutine raise_peak

   !> Joins the maxima of an analysis to those of the ones before it.
   subroutine join_indicators(part, whole)
      !> Unallocated if the analysis has none; of the first analysis it moves
      type(indicators_type), allocatable, intent(inout) :: part
      type(indicators_type), allocatable, intent(inout) :: whole
      integer :: i, k
      if (.not. allocated(part)) return
      if (.not. allocated(whole)) then
         call move_alloc(part, whole)
         return
      end if
      whole%observations = whole%observations + part%observations
      do i = 1, size(part%bodies)
         do k = 1, peaks
            call raise_peak(whole%bodies(i), k, part%bodies(i)%peak(k), part%bodies(i)%time(k))
         end do
         do k = 1, size(part%bodies(i)%modal)
            if (.not. part%bodies(i)%modal(k) > whole%bodies(i)%modal(k)) cycle
            whole%bodies(i)%modal(k) = part%bodies(i)%modal(k)
            whole%bodies(i)%modal_time(k) = part%bodies(i)%modal_time(k)
         end do
      end do
   end subroutine join_indicators

   !> Value of an indicator so far; zero where a body has none of its kind.
   pure real(wp) function indicator_value(self, kind) result(value)
      type(body_indicators_type), intent(in) :: self
      !> One of indicator_...
      integer, intent(in) :: kind
      associate (peak => self%peak)
         select case (kind)
         case (indicator_pace); value = sqrt(ratio(peak(peak_kinetic), peak(peak_energy)))
         case (indicator_last_mode)
            value = 0.0_wp
            if (size(self%modal) > 0) value = ratio(self%modal(size(self%modal)), peak(peak_energy))
         case (indicator_residual); value = ratio(peak(peak_left_out), peak(peak_left_out) + peak(peak_energy))
         case (indicator_geometric); value = ratio(peak(peak_geometric), peak(peak_stiffness))
         case (indicator_axial); value = sqrt(ratio(peak(peak_axial), peak(merge(peak_bent, peak_stiffness, self%is_full))))
         case (indicator_coarseness); value = sqrt(ratio(peak(peak_coarse), peak(peak_stiffness)))
         case (indicator_lumping)
            value = 0.0_wp
            if (self%is_beam) value = max(ratio(maxval(self%modal*self%stations%lumping), peak(peak_energy)), &
               & sqrt(ratio(peak(peak_lost), peak(peak_energy))))
         case (indicator_shortening); value = ratio(peak(peak_quartic), peak(peak_stiffness))
         case default; value = peak(kind)
         end select
      end associate
   end function indicator_value

   !> Time of that value: of a quotient that of its numerator.
   pure real(wp) function indicator_time(self, kind) result(t)
      type(body_indicators_type), intent(in) :: self
      integer, intent(in) :: kind
      select case (kind)
      case (indicator_pace); t = self%time(peak_kinetic)
      case (indicator_last_mode)
         t = 0.0_wp
         if (size(self%modal) > 0) t = self%modal_time(size(self%modal))
      case (indicator_residual); t = self%time(peak_left_out)
      case (indicator_geometric); t = self%time(peak_geometric)
      case (indicator_axial); t = self%time(peak_axial)
      case (indicator_coarseness); t = self%time(peak_coarse)
      case (indicator_lumping)
         t = 0.0_wp
         if (self%is_beam) t = self%time(peak_lost)
      case (indicator_shortening); t = self%time(peak_quartic)
      case default; t = self%time(kind)
      end select
   end function indicator_time

   pure real(wp) function ratio(part, whole)
      real(wp), intent(in) :: part, whole
      ratio = 0.0_wp
      if (whole > 0.0_wp) ratio = part/whole
   end function ratio

end module limber_analysis_indicators
