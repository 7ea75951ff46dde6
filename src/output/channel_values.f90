!> Values of the channels at a state. Only what they need is computed. Floor: output.
module limber_output_channel_values
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_model_quantities
   use limber_model_model, only: quantity_type, ground
   use limber_output_drawn_coordinates, only: drawn_type, new_drawn, drawn_width, drawn_coordinates
   use limber_output_internal_forces, only: section_forces_type, new_efforts, gather_efforts, section_forces, stresses, &
      & strength_at
   use limber_output_joint_forces, only: joint_force, joint_force_in_frame, joint_moment, joint_displacement, joint_sliding, &
      & section_rotation, joint_spin, driver_effort, driver_power, coupler_effort, coupler_power
   use limber_output_load_channels, only: load_value
   use limber_output_segment_measures, only: whole_direction, whole_spin, whole_displacement, whole_rotation
   use limber_output_followed_turns, only: turns_type, new_turns, turned_angle
   use limber_multibody_plane_vectors, only: cross
   use limber_multibody_equations_of_motion, only: mechanical_energy
   use limber_multibody_point_motion, only: point_position, point_velocity, point_acceleration
   use limber_multibody_beam_place, only: find_place, find_deflection
   use limber_multibody_momentum, only: total_momentum
   use limber_multibody_system, only: system_type, workspace_type, number_of_contacts
   implicit none
   private
   public :: recorder_type, new_recorder, channel_values, sample_width

   !> What is remembered between samples: the angles of frames, accumulated over turns
   type :: recorder_type
      !> Of all frames
      type(turns_type) :: turns
      !> True if anything is asked for but deflections: where bodies are, too
      logical :: needs_places = .false.
      !> True if a channel needs velocities; accelerations or multipliers; energies
      logical :: needs_velocities = .false., needs_accelerations = .false., needs_energy = .false., needs_momentum = .false.
      !> True if a channel is the work put in
      logical :: needs_work = .false.
      !> True if a channel needs internal forces; what acts on the bodies then
      logical :: needs_sections = .false.
      type(section_forces_type), allocatable :: efforts(:)
      !> What is drawn of exact beams, if the motion is asked for
      type(drawn_type), allocatable :: drawn(:)
      !> What is asked for, each once, and which of it stands in the slots of the expressions, channel by channel
      type(quantity_type), allocatable :: asked(:)
      integer, allocatable :: which(:)
      !> Scratch: values of what is asked for, and of one expression's slots
      real(wp), allocatable :: found(:), slots(:)
      !> True if energies and momenta are those of this sample already
      logical :: is_balanced = .false.
      !> Kinetic and potential energy, and work, at the sample
      real(wp) :: kinetic = 0.0_wp, potential = 0.0_wp, work = 0.0_wp
      !> Momentum along x and y, and about the fixed origin
      real(wp) :: momentum(3) = 0.0_wp
      !> Energy that impacts at rigid stops have lost (contacts)
      real(wp), allocatable :: lost(:)
   contains
      procedure :: exchange => exchange_recorder
   end type recorder_type

contains

   !> A recorder for the channels of a system, at the first state.
   function new_recorder(system, q) result(recorder)
      type(system_type), intent(in) :: system
      !> Coordinates (nq)
      real(wp), contiguous, intent(in) :: q(:)
      type(recorder_type) :: recorder
      integer :: i, j, most
      most = 0
      do i = 1, size(system%model%channels)
         most = max(most, size(system%model%channels(i)%quantities))
         do j = 1, size(system%model%channels(i)%quantities)
            associate (quantity => system%model%channels(i)%quantities(j))
               recorder%needs_places = recorder%needs_places .or. is_of_place(system, quantity)
               select case (quantity%kind)
               case (quantity_ax, quantity_ay, quantity_force_x, quantity_force_y, quantity_torque, quantity_tension, &
                  & quantity_force_1, quantity_force_2, quantity_moment, quantity_force, quantity_power, &
                  & quantity_elongation, quantity_rate, quantity_coupling)
                  recorder%needs_accelerations = .true.
               case (quantity_axial_force, quantity_shear_force, quantity_bending_moment, quantity_stress_top, &
                  & quantity_stress_bottom)
                  recorder%needs_accelerations = .true.
                  recorder%needs_sections = .true.
               case (quantity_vx, quantity_vy, quantity_spin, quantity_joint_spin, quantity_sliding_speed)
                  recorder%needs_velocities = .true.
               case (quantity_state); recorder%needs_velocities = .true.
               case (quantity_kinetic, quantity_potential); recorder%needs_energy = .true.
               case (quantity_work); recorder%needs_work = .true.
               case (quantity_momentum_x, quantity_momentum_y, quantity_angular_momentum); recorder%needs_momentum = .true.
               end select
            end associate
         end do
      end do
      if (any(system%model%bodies%envelope)) then
         recorder%needs_accelerations = .true.
         recorder%needs_sections = .true.
      end if
      recorder%needs_velocities = recorder%needs_velocities .or. recorder%needs_accelerations .or. recorder%needs_energy &
         & .or. recorder%needs_momentum
      recorder%needs_places = recorder%needs_places .or. recorder%needs_velocities .or. system%model%motion
      allocate (recorder%slots(most))
      call list_asked(system, recorder)
      allocate (recorder%efforts, source=new_efforts(system))
      if (system%model%motion) allocate (recorder%drawn, source=new_drawn(system%model))
      recorder%turns = new_turns(system, q)
      allocate (recorder%lost(number_of_contacts(system%model)), source=0.0_wp)
   end function new_recorder

   !> Lists what is asked for. What several channels ask for, mostly channels that stand together, is found once.
   pure subroutine list_asked(system, recorder)
      type(system_type), intent(in) :: system
      type(recorder_type), intent(inout) :: recorder
      !> Last quantities among which the same is sought
      integer, parameter :: near = 64
      integer :: i, j, k, at, n
      n = 0
      do i = 1, size(system%model%channels)
         n = n + size(system%model%channels(i)%quantities)
      end do
      allocate (recorder%asked(n), recorder%which(n))
      n = 0
      at = 0
      do i = 1, size(system%model%channels)
         do j = 1, size(system%model%channels(i)%quantities)
            associate (quantity => system%model%channels(i)%quantities(j))
               do k = n, max(1, n - near), -1
                  if (same(quantity, recorder%asked(k))) exit
               end do
               if (k < max(1, n - near)) then
                  n = n + 1
                  recorder%asked(n) = quantity
                  k = n
               end if
               at = at + 1
               recorder%which(at) = k
            end associate
         end do
      end do
      recorder%asked = recorder%asked(:n)
      allocate (recorder%found(n))
   end subroutine list_asked

   !> Whether two quantities are one.
   pure logical function same(a, b)
      type(quantity_type), intent(in) :: a, b
      same = a%kind == b%kind .and. a%of == b%of .and. (a%of_load .eqv. b%of_load) .and. (a%of_coupler .eqv. b%of_coupler)
   end function same

   !> Whether a quantity depends on where frames are: the deflection of a body in its own frame does not.
   pure logical function is_of_place(system, quantity)
      type(system_type), intent(in) :: system
      type(quantity_type), intent(in) :: quantity
      is_of_place = quantity%kind /= 0
      if (quantity%of_load) return
      select case (quantity%kind)
      case (quantity_length); is_of_place = .false.
      case (quantity_deflection, quantity_u1, quantity_u2, quantity_rotation)
         is_of_place = system%model%bodies(system%model%points(quantity%of)%body)%whole > 0
      end select
   end function is_of_place

   !> Angle of the first section of a joint from the second, accumulated over turns.
   pure real(wp) function joint_angle(recorder, system, joint, t, q) result(angle)
      type(recorder_type), intent(in) :: recorder
      type(system_type), intent(in) :: system
      integer, intent(in) :: joint
      real(wp), intent(in) :: t
      real(wp), contiguous, intent(in) :: q(:)
      integer :: side
      real(wp) :: own
      angle = 0.0_wp
      do side = 1, 2
         associate (body => system%constraints(joint)%item%bodies(side))
            if (body == ground) cycle
            if (.not. system%layout%framed(body)) cycle
            own = turned_angle(recorder%turns, system, body, t, q(system%layout%q(body) + 2:)) &
               & + section_rotation(system, system%model%joints(joint)%points(side), q)
            angle = angle + merge(own, -own, side == 1)
         end associate
      end do
   end function joint_angle

   !> Numbers in a sample: the channels, and behind them the coordinates, if the motion is asked for.
   pure integer function sample_width(system) result(width)
      type(system_type), intent(in) :: system
      width = size(system%model%channels)
      if (system%model%motion) width = width + drawn_width(system%model, system%layout)
   end function sample_width

   !> A sample: values of all channels, in their order, and the coordinates, if the motion is asked for.
   subroutine channel_values(recorder, system, work, t, q, v, a, values)
      type(recorder_type), intent(inout) :: recorder
      type(system_type), intent(in) :: system
      !> Multipliers and kinematics are those of the state if the recorder needs accelerations
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      !> Coordinates, velocities, accelerations (nq)
      real(wp), contiguous, intent(in) :: q(:), v(:), a(:)
      !> (sample_width)
      real(wp), intent(inout) :: values(:)
      integer :: i, j, at, n
      if (.not. recorder%is_balanced) call gather_balance(recorder, system, work, q, v)
      recorder%is_balanced = .false.
      if (recorder%needs_sections) call gather_efforts(recorder%efforts, system, work, q, v, a)
      do i = 1, size(recorder%asked)
         recorder%found(i) = quantity_value(recorder, recorder%asked(i), system, work, t, q, v, a)
      end do
      at = 0
      do i = 1, size(system%model%channels)
         associate (channel => system%model%channels(i))
            n = size(channel%quantities)
            do j = 1, n
               recorder%slots(j) = recorder%found(recorder%which(at + j))
            end do
            at = at + n
            values(i) = channel%expression%evaluate(recorder%slots(:n))
         end associate
      end do
      if (system%model%motion) call drawn_coordinates(recorder%drawn, system%model, system%layout, q, &
         & values(size(system%model%channels) + 1:))
   end subroutine channel_values

   !> Energies and momenta of a state, for the channels of the sample that follows.
   subroutine gather_balance(recorder, system, work, q, v)
      type(recorder_type), intent(inout) :: recorder
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Coordinates and velocities (nq)
      real(wp), contiguous, intent(in) :: q(:), v(:)
      if (recorder%needs_energy) call mechanical_energy(system, work, q, v, recorder%kinetic, recorder%potential)
      if (recorder%needs_momentum) call total_momentum(system, q, v, recorder%momentum)
      recorder%is_balanced = .true.
   end subroutine gather_balance

   !> Value of one quantity.
   real(wp) function quantity_value(recorder, quantity, system, work, t, q, v, a) result(value)
      type(recorder_type), intent(in) :: recorder
      type(quantity_type), intent(in) :: quantity
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      real(wp), intent(in) :: t
      !> Not by their bounds, which each call would have to hand on
      real(wp), intent(in) :: q(system%layout%nq), v(system%layout%nq), a(system%layout%nq)
      real(wp) :: vector(2), force(3)
      if (quantity%kind == 0) then
         value = t
         return
      end if
      vector = 0.0_wp
      value = 0.0_wp
      if (quantity%of_load) then
         if (quantity%kind == quantity_lost) then
            value = sum(recorder%lost, mask=system%model%contacts%load == quantity%of)
         else
            value = load_value(system, work, quantity)
         end if
         return
      end if
      select case (quantity%kind)
      case (quantity_x, quantity_y)
         vector = point_position(system%model, system%layout, system%model%points(quantity%of), q)
      case (quantity_vx, quantity_vy)
         vector = point_velocity(system%model, system%layout, system%model%points(quantity%of), q, v)
      case (quantity_ax, quantity_ay)
         vector = point_acceleration(system%model, system%layout, system%model%points(quantity%of), q, v, a)
      case (quantity_force_x, quantity_force_y)
         vector = joint_force(system, work, quantity%of)
      case (quantity_angle)
         value = frame_angle(recorder, system, quantity%of, t, q)
      case (quantity_spin)
         if (system%model%bodies(quantity%of)%whole > 0) then
            value = whole_spin(system, system%model%bodies(quantity%of)%whole, q, v)
         else
            associate (first => system%layout%q(quantity%of) + 2)
               value = cross(q(first:first + 1), v(first:first + 1))
            end associate
         end if
      case (quantity_deflection)
         value = deflection(system, quantity%of, q)
      case (quantity_length)
         value = system%model%bodies(quantity%of)%beam%length
         if (system%model%bodies(quantity%of)%whole > 0) &
            & value = system%model%wholes(system%model%bodies(quantity%of)%whole)%length
      case (quantity_torque, quantity_force)
         value = driver_effort(system, work, quantity%of)
      case (quantity_u1, quantity_u2)
         if (system%model%bodies(system%model%points(quantity%of)%body)%whole > 0) then
            vector = whole_displacement(system, quantity%of, q)
         else
            vector = beam_displacement(system, quantity%of, q)
         end if
      case (quantity_rotation)
         associate (point => system%model%points(quantity%of))
            if (system%model%bodies(point%body)%whole > 0) then
               value = whole_rotation(recorder%turns, system, quantity%of, t, q)
            else
               value = dot_product(point%psi, q(system%layout%q(point%body) + 4:system%layout%q(point%body) + 3 + size(point%psi)))
            end if
         end associate
      case (quantity_force_1, quantity_force_2); vector = joint_force_in_frame(system, work, quantity%of, q)
      case (quantity_moment); value = joint_moment(system, work, quantity%of, q)
      case (quantity_joint_angle); value = joint_angle(recorder, system, quantity%of, t, q)
      case (quantity_joint_spin); value = joint_spin(system, quantity%of, q, v)
      case (quantity_displacement); value = joint_displacement(system, quantity%of, q)
      case (quantity_sliding_speed); value = joint_sliding(system, quantity%of, q, v)
      case (quantity_state); value = v(system%layout%q(system%model%points(quantity%of)%body))
      case (quantity_coupling); value = coupler_effort(system, work, quantity%of)
      case (quantity_power)
         if (quantity%of_coupler) then
            value = coupler_power(system, work, quantity%of)
         else
            value = driver_power(system, work, quantity%of)
         end if
      case (quantity_axial_force, quantity_shear_force, quantity_bending_moment, quantity_stress_top, quantity_stress_bottom)
         force = section_forces(recorder%efforts, system, quantity%of, q)
         value = section_value(quantity%kind, force, system, quantity%of)
      case (quantity_momentum_x); value = recorder%momentum(1)
      case (quantity_momentum_y); value = recorder%momentum(2)
      case (quantity_angular_momentum); value = recorder%momentum(3)
      case (quantity_kinetic); value = recorder%kinetic
      case (quantity_potential); value = recorder%potential
      case (quantity_work); value = recorder%work
      end select
      select case (quantity%kind)
      case (quantity_x, quantity_vx, quantity_ax, quantity_force_x, quantity_u1, quantity_force_1); value = vector(1)
      case (quantity_y, quantity_vy, quantity_ay, quantity_force_y, quantity_u2, quantity_force_2); value = vector(2)
      end select
   end function quantity_value

   !> Angle of the frame of a body as the deck knows it, accumulated over turns; a member of a frame has the turns of its own
   !> frame, whose angle to the whole one may be half a turn.
   pure real(wp) function frame_angle(recorder, system, body, t, q) result(angle)
      type(recorder_type), intent(in) :: recorder
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      real(wp), intent(in) :: t
      real(wp), contiguous, intent(in) :: q(:)
      logical :: leans
      leans = .false.
      associate (whole => system%model%bodies(body)%whole)
         if (whole > 0) leans = allocated(system%model%wholes(whole)%lean)
         if (whole > 0 .and. .not. leans) then
            angle = turned_angle(recorder%turns, system, body, t, whole_direction(system, whole, q))
            return
         end if
         angle = turned_angle(recorder%turns, system, body, t, q(system%layout%q(body) + 2:))
         if (leans) angle = angle - system%model%wholes(whole)%lean(1)
      end associate
   end function frame_angle

   !> One of the internal forces at a point, or a stress in an extreme fibre.
   pure real(wp) function section_value(kind, force, system, point) result(value)
      integer, intent(in) :: kind
      !> Axial force, shear force, bending moment
      real(wp), intent(in) :: force(3)
      type(system_type), intent(in) :: system
      integer, intent(in) :: point
      real(wp) :: stress(2)
      associate (body => system%model%bodies(system%model%points(point)%body))
         stress = stresses(force, strength_at(body, body%recovery%sections(system%model%points(point)%section)))
         select case (kind)
         case (quantity_axial_force); value = force(1)
         case (quantity_shear_force); value = force(2)
         case (quantity_bending_moment); value = force(3)
         case (quantity_stress_top); value = stress(1)
         case default; value = stress(2)
         end select
      end associate
   end function section_value

   !> Signed distance of a beam's point from the chord through the beam's ends.
   pure real(wp) function deflection(system, point, q)
      type(system_type), intent(in) :: system
      integer, intent(in) :: point
      real(wp), contiguous, intent(in) :: q(:)
      real(wp) :: start(2), chord(2)
      integer :: first
      associate (points => system%model%points, body => system%model%bodies(system%model%points(point)%body))
         ! The ends of a beam in segments are points of other bodies
         if (body%whole == 0 .and. points(point)%exact .and. points(body%start_point)%exact .and. points(body%end_point)%exact) then
            first = system%layout%q(points(point)%body) + 4
            deflection = find_deflection(body%reduced%exact, points(body%start_point)%reach, points(body%end_point)%reach, &
               & points(point)%reach, q(first:first + body%reduced%n - 1))
            return
         end if
         start = point_position(system%model, system%layout, points(body%start_point), q)
         chord = point_position(system%model, system%layout, points(body%end_point), q) - start
         deflection = cross(chord, point_position(system%model, system%layout, points(point), q) - start)/norm2(chord)
      end associate
   end function deflection

   !> Displacement of a beam's point from its undeformed place, along the axes of the beam's frame.
   pure function beam_displacement(system, point, q) result(displacement)
      type(system_type), intent(in) :: system
      integer, intent(in) :: point
      real(wp), contiguous, intent(in) :: q(:)
      real(wp) :: displacement(2)
      integer :: first, k
      displacement = 0.0_wp
      first = system%layout%q(system%model%points(point)%body) + 4
      if (system%model%points(point)%exact) then
         associate (own => system%model%points(point))
            call find_place(system%model%bodies(own%body)%reduced%exact, own%reach, q(first:first + size(own%psi) - 1), &
               & displacement)
            displacement = displacement - own%p0
         end associate
         return
      end if
      do k = 1, size(system%model%points(point)%psi)
         displacement = displacement + system%model%points(point)%phi(:, k)*q(first + k - 1)
      end do
   end function beam_displacement

   !> Saves or restores its memory.
   subroutine exchange_recorder(self, snapshot)
      class(recorder_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      integer :: i
      call self%turns%exchange(snapshot)
      do i = 1, size(self%efforts)
         call snapshot%keep('amplitude', self%efforts(i)%amplitude)
         call snapshot%keep('extremes', self%efforts(i)%extremes)
      end do
      call snapshot%exchange('is_balanced', self%is_balanced)
      call snapshot%exchange('kinetic', self%kinetic)
      call snapshot%exchange('potential', self%potential)
      call snapshot%exchange('work', self%work)
      call snapshot%exchange('momentum', self%momentum)
      call snapshot%exchange('lost', self%lost)
      ! Not saved: needs_places, needs_velocities, needs_accelerations, needs_energy, needs_momentum, needs_work, needs_sections
      ! Not saved: drawn, asked, which, found, slots
   end subroutine exchange_recorder

end module limber_output_channel_values
