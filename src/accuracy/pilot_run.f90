!> Pilot run with rigid beams and forecast of deflections. The forces that act on their coordinates then, how these follow, and what
!> that does to the channels. Cheap, for a rigid scene has few coordinates and no vibrations. Floor: accuracy. Equations:
!> doc/theory, part 7.
module limber_accuracy_pilot_run
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_analysis_chosen_integrator, only: new_integrator
   use limber_accuracy_pilot_scenes, only: build_exact, probe_modally, make_rigid, build, probe_modes
   use limber_accuracy_fidelity_levels, only: level_type, bare_deck
   use limber_scene_scene, only: scene_type
   use limber_accuracy_modal_response, only: follow_forces, follow_first, vibration_modes, frequency_shifts
   use limber_deck_content, only: deck_type
   use limber_integrator_integrator, only: integrator_type
   use limber_model_law_breaks, only: find_breaks
   use limber_model_quantities, only: is_internal_force, quantity_u1, quantity_u2, quantity_rotation
   use limber_model_model, only: body_flexible
   use limber_output_channel_values, only: recorder_type, new_recorder, channel_values, sample_width
   use limber_output_followed_turns, only: follow_places
   use limber_multibody_assembly_newton, only: close_positions
   use limber_multibody_constraint_matrix, only: constraint_matrix_type, new_constraint_matrix
   use limber_multibody_equations_of_motion, only: linearise, accelerations, accelerate
   use limber_multibody_layout, only: rates_of
   use limber_multibody_motion_residual, only: motion_residual
   use limber_multibody_projection, only: settle
   implicit none
   private
   public :: pilot_type, forecast_type, make_probe

   !> Samples of the motion, and at how many of them channels are looked at, and coordinates moved
   integer, parameter :: samples = 200, looks = 40, moves = 5

   !> What a probe finds of one beam
   type :: forecast_type
      !> Its index in the model, and its first coordinate among those of the probe
      integer :: body = 0, first = 0, bending = 0, axial = 0
      !> Part of a channel, relative to its largest value, that each bending coordinate makes (bending), and all together, of the
      !> channel with the largest
      real(wp), allocatable :: part(:)
      real(wp) :: effect = 0.0_wp
      !> The same for its axial coordinates
      real(wp) :: stretch = 0.0_wp
      !> Part of a channel of forces or accelerations that vibrations along the beam make, which its stretch at rest does not, and
      !> their displacement relative to the length
      real(wp) :: ringing = 0.0_wp, ringing_size = 0.0_wp
      !> True if a channel asks for what a rigid beam does not have
      logical :: asked = .false.
      !> Relative change of the deflection by the axial force, and that force relative to the buckling load
      real(wp) :: geometric = 0.0_wp, force = 0.0_wp
      !> Axial strain by it
      real(wp) :: strain = 0.0_wp
      !> Largest rotation speed, relative to the first frequency
      real(wp) :: rotation = 0.0_wp
      !> Factor by which a compression enlarges the deflection
      real(wp) :: softening = 1.0_wp
      !> Largest deflection relative to the length, and slope
      real(wp) :: deflection = 0.0_wp, slope = 0.0_wp
      !> The slope that it would have without the axial force
      real(wp) :: slack_slope = 0.0_wp
      !> First frequency in the scene [1/time], and the part of the deflection that is vibration
      real(wp) :: frequency = 0.0_wp, vibration = 0.0_wp
   end type forecast_type

   !> The probe
   type :: pilot_type
      !> Beams whose rungs were asked for, in their order
      type(forecast_type), allocatable :: beams(:)
      !> True if the scene does not move with rigid beams, so that nothing is known of it
      logical :: blind = .false.
      !> Length of the analysis [time], and steps of the rigid scene
      real(wp) :: duration = 0.0_wp
      integer :: steps = 0
      !> CPU seconds
      real(wp) :: cpu = 0.0_wp
   end type pilot_type

   !> Motion of the rigid scene, and what it does to the coordinates of the flexible one
   type :: track_type
      integer :: count = 0
      real(wp), allocatable :: times(:), q(:, :), v(:, :), forces(:, :), spin(:, :)
   end type track_type

contains

   !> Probes a deck.
   subroutine make_probe(deck, rungs, probe, error)
      type(deck_type), intent(in) :: deck
      !> Its beams whose fidelity is open
      type(level_type), intent(inout) :: rungs(:)
      type(pilot_type), intent(out) :: probe
      !> The deck is wrong (status 2)
      type(error_type), allocatable, intent(out) :: error
      type(scene_type) :: rigid, flexible, exact
      type(track_type) :: track
      real(wp), allocatable :: mobility(:, :), stiffness(:), square(:), vectors(:, :), eta(:, :), speed(:), swing(:)
      real(wp), allocatable :: other(:, :), its_speed(:)
      real(wp) :: clock(2)
      logical :: done
      integer :: i
      call cpu_time(clock(1))
      call build_exact(deck, rungs, exact, error)
      if (allocated(error)) return
      flexible%deck = deck
      call bare_deck(deck, rigid%deck)
      do i = 1, size(rungs)
         call probe_modally(exact, rungs(i), flexible%deck)
         call make_rigid(rungs(i), rigid%deck)
      end do
      call flexible%deck%set_option(deck%find('DYNAMICS'), 'INTEGRATOR', 'ADAMS')
      call rigid%deck%set_number(deck%find('DYNAMICS'), 'TOLERANCE', 1.0e-4_wp)
      if (.not. deck%blocks(deck%find('DYNAMICS'))%given('INTEGRATOR')) &
         & call rigid%deck%set_option(deck%find('DYNAMICS'), 'INTEGRATOR', 'ADAMS')
      associate (dynamics => exact%system%model%dynamics)
         probe%duration = dynamics%end - dynamics%start
      end associate
      allocate (probe%beams(size(rungs)))
      if (size(rungs) > 0) then
         call build(flexible, error)
         if (.not. allocated(error)) call find_beams(flexible, rungs, probe, error)
         if (.not. allocated(error)) call build(rigid, error)
         if (.not. allocated(error)) then
            if (rigid%system%nc /= flexible%system%nc) call raise(error, 'the rigid scene has other constraints')
            if (rigid%system%redundant .and. .not. allocated(error)) &
               & call raise(error, 'the forces in the rigid scene depend on how its beams bend')
         end if
         if (.not. allocated(error)) call move_rigidly(rigid, flexible, track, probe%steps, error)
         if (allocated(error)) then
            ! Without its beams' deflections the scene does not move, or no modes can be had: nothing is known before it runs
            deallocate (error)
            call assume(probe)
            return
         end if
         call find_mobility(flexible, mobility, stiffness, error)
         if (allocated(error)) return
         associate (n => size(stiffness))
            allocate (square(n), vectors(n, n), eta(n, track%count), speed(n), swing(n))
         end associate
         call vibration_modes(mobility, stiffness, square, vectors, done)
         associate (times => track%times(:track%count), forces => track%forces(:, :track%count))
            call follow_forces(times, forces, stiffness, square, vectors, eta, speed, swing=swing)
            if (exact%system%model%assembly%static_deflections) then
               allocate (other, source=eta)
               allocate (its_speed, source=speed)
               call follow_forces(times, forces, stiffness, square, vectors, other, its_speed, .true., swing)
            end if
         end associate
         do i = 1, size(probe%beams)
            call look_at_beam(flexible, track, mobility, stiffness, eta, probe%beams(i))
         end do
         call look_at_channels(flexible, track, eta, speed, swing, probe)
         call look_at_phases(mobility, stiffness, probe)
      end if
      call cpu_time(clock(2))
      probe%cpu = clock(2) - clock(1)
   end subroutine make_probe

   !> Beams that stretch are softer supports of the others, whose vibrations lose their phase then: eq. (7.81).
   subroutine look_at_phases(mobility, stiffness, probe)
      !> As in `find_mobility`
      real(wp), intent(in) :: mobility(:, :), stiffness(:)
      type(pilot_type), intent(inout) :: probe
      !> Of more coordinates than these the mobility is not known, and beams without effect on each other need no look
      integer, parameter :: most = 80
      logical :: bends(size(stiffness)), frees(size(stiffness))
      real(wp) :: shifts(size(stiffness))
      integer :: i, j
      if (size(stiffness) > most .or. sum(probe%beams%bending + probe%beams%axial) < size(stiffness)) return
      bends = .false.
      do i = 1, size(probe%beams)
         associate (beam => probe%beams(i))
            bends(beam%first:beam%first + beam%bending - 1) = .true.
         end associate
      end do
      do i = 1, size(probe%beams)
         associate (beam => probe%beams(i))
            if (beam%axial == 0) cycle
            frees = .false.
            frees(beam%first + beam%bending:beam%first + beam%bending + beam%axial - 1) = .true.
            call frequency_shifts(mobility, stiffness, bends, frees, shifts)
            do j = 1, size(probe%beams)
               associate (other => probe%beams(j))
                  if (other%bending > 0) beam%stretch = max(beam%stretch, &
                     & other%effect*other%vibration*min(1.0_wp, shifts(other%first)*probe%duration))
               end associate
            end do
         end associate
      end do
   end subroutine look_at_phases

   !> What is assumed of beams where a probe fails: that they matter, and that nothing else is known.
   subroutine assume(probe)
      type(pilot_type), intent(inout) :: probe
      integer :: i, k
      probe%blind = .true.
      do i = 1, size(probe%beams)
         associate (beam => probe%beams(i))
            beam%part = [(1/real(k, wp)**5, k=1, probe_modes)]
            beam%effect = 1.0_wp
            beam%geometric = 1.0_wp
            beam%deflection = 0.015_wp
            beam%slope = 0.05_wp
            beam%vibration = 1.0_wp
            beam%frequency = 1/max(probe%duration, tiny(1.0_wp))
         end associate
      end do
   end subroutine assume

   !> Which bodies the beams are, and where their coordinates stand among all deflections.
   subroutine find_beams(scene, rungs, probe, error)
      type(scene_type), intent(in) :: scene
      type(level_type), intent(in) :: rungs(:)
      type(pilot_type), intent(inout) :: probe
      !> One of them is not there as it should be
      type(error_type), allocatable, intent(out) :: error
      integer :: i, k, j
      associate (model => scene%system%model)
         do k = 1, size(rungs)
            do i = 1, size(model%bodies)
               if (model%bodies(i)%kind /= body_flexible) cycle
               if (model%bodies(i)%name == scene%deck%blocks(rungs(k)%block)%name()) probe%beams(k)%body = i
            end do
            if (probe%beams(k)%body == 0) call raise(error, 'no modes')
            if (allocated(error)) return
            associate (beam => probe%beams(k))
               beam%first = sum(scene%system%layout%n(:beam%body - 1)) + 1
               beam%bending = model%bodies(beam%body)%reduced%bending
               beam%axial = model%bodies(beam%body)%reduced%n - beam%bending
               allocate (beam%part(beam%bending))
               beam%part = 0.0_wp
               do i = 1, size(model%channels)
                  do j = 1, size(model%channels(i)%quantities)
                     associate (quantity => model%channels(i)%quantities(j))
                        if (.not. (is_internal_force(quantity%kind) .or. any(quantity%kind == &
                           & [quantity_u1, quantity_u2, quantity_rotation]))) cycle
                        if (model%points(quantity%of)%body == beam%body) beam%asked = .true.
                     end associate
                  end do
               end do
            end associate
         end do
      end associate
   end subroutine find_beams

   !> Moves the rigid scene, and at each sample finds the forces on the held deflections of the flexible one.
   subroutine move_rigidly(rigid, flexible, track, steps, error)
      type(scene_type), intent(inout) :: rigid, flexible
      type(track_type), intent(out) :: track
      integer, intent(out) :: steps
      type(error_type), allocatable, intent(out) :: error
      class(integrator_type), allocatable :: integrator
      real(wp), allocatable :: breaks(:), q(:), v(:), a(:), change(:)
      character(:), allocatable :: restless
      real(wp) :: barrier, near, w, residual
      integer :: passed, next
      associate (dynamics => rigid%system%model%dynamics, layout => flexible%system%layout, nq => rigid%system%layout%nq)
         call find_breaks(rigid%system%model, breaks, restless)
         associate (most => samples + 1 + 2*size(breaks))
            allocate (track%times(most), track%q(layout%nq, most), track%v(layout%nq, most), track%forces(sum(layout%n), most))
            allocate (track%spin(size(layout%n), most))
         end associate
         allocate (q(nq), v(nq), a(nq), change(nq))
         q = rigid%q
         v = rigid%v
         near = 8*spacing(max(abs(dynamics%start), abs(dynamics%end)))
         call new_integrator(dynamics, integrator)
         call integrator%start(rigid%system, rigid%work, dynamics%start, dynamics%end - dynamics%start, q, v, error)
         if (allocated(error)) return
         call take(dynamics%start)
         next = 1
         passed = 0
         do while (next <= samples .and. .not. allocated(error))
            if (integrator%statistics%steps > 20000) then
               call raise(error, 'the probe with rigid beams takes too many steps')
               exit
            end if
            barrier = dynamics%end
            if (passed < size(breaks)) barrier = nearest(breaks(passed + 1), -1.0_wp)
            call integrator%step(rigid%system, rigid%work, barrier, error)
            if (allocated(error)) exit
            do while (next <= samples .and. .not. allocated(error))
               if (time_of(next) > integrator%t + near) exit
               call integrator%interpolate(time_of(next), q, v, w)
               call take(time_of(next))
               next = next + 1
            end do
            if (allocated(error) .or. passed == size(breaks)) cycle
            if (integrator%t < barrier - near) cycle
            passed = passed + 1
            call integrator%interpolate(integrator%t, q, v, w)
            call take(integrator%t)
            if (allocated(error)) exit
            call settle(rigid%system, rigid%work, breaks(passed), q, v, change, .true., residual, error)
            if (allocated(error)) exit
            call take(breaks(passed))
            if (.not. allocated(error)) call integrator%start(rigid%system, rigid%work, breaks(passed), &
               & dynamics%end - dynamics%start, q, v, error)
         end do
         steps = int(integrator%statistics%steps)
      end associate

   contains

      pure real(wp) function time_of(index)
         integer, intent(in) :: index
         time_of = rigid%system%model%dynamics%start + (rigid%system%model%dynamics%end &
            & - rigid%system%model%dynamics%start)*(real(index, wp)/samples)
      end function time_of

      !> One sample.
      subroutine take(t)
         real(wp), intent(in) :: t
         call settle(rigid%system, rigid%work, t, q, v, change, .true., residual, error)
         if (allocated(error)) return
         call accelerations(rigid%system, rigid%work, q, v, a)
         track%count = track%count + 1
         track%times(track%count) = t
         call hold(rigid, flexible, t, q, v, a, track)
      end subroutine take

   end subroutine move_rigidly

   !> The forces on the coordinates of flexible bodies that move as the rigid ones: what would have to hold them, eq. (7.72).
   subroutine hold(rigid, flexible, t, q, v, a, track)
      type(scene_type), intent(inout) :: rigid, flexible
      real(wp), intent(in) :: t, q(:), v(:), a(:)
      type(track_type), intent(inout) :: track
      real(wp) :: change(flexible%system%layout%nq), push(flexible%system%layout%nw), motion(flexible%system%layout%nw)
      real(wp) :: rates(flexible%system%nc)
      integer :: i, from, to, n, width, first
      change = 0.0_wp
      first = 0
      associate (layout => flexible%system%layout, k => track%count)
         track%q(:, k) = 0.0_wp
         track%v(:, k) = 0.0_wp
         do i = 1, size(layout%q)
            from = rigid%system%layout%q(i)
            to = layout%q(i)
            n = min(rigid%system%layout%n(i), layout%n(i))
            width = merge(4, 2, layout%framed(i)) + n - 1
            track%q(to:to + width, k) = q(from:from + width)
            track%v(to:to + width, k) = v(from:from + width)
            change(to:to + width) = a(from:from + width)
         end do
         call rates_of(layout, track%q(:, k), change, push)
         call motion_residual(flexible%system, flexible%work, t, track%q(:, k), track%v(:, k), push, &
            & rigid%work%lambda, motion, rates)
         do i = 1, size(layout%q)
            n = layout%n(i)
            from = layout%w(i) + layout%rates(i)
            track%forces(first + 1:first + n, k) = -motion(from:from + n - 1)
            first = first + n
            track%spin(i, k) = 0.0_wp
            if (layout%framed(i)) track%spin(i, k) = flexible%work%kinematics%frames(i)%omega
         end do
      end associate
   end subroutine hold

   !> Accelerations that unit forces on the coordinates make at the first place, all else free to follow.
   subroutine find_mobility(scene, mobility, stiffness, error)
      type(scene_type), intent(inout) :: scene
      real(wp), allocatable, intent(out) :: mobility(:, :), stiffness(:)
      type(error_type), allocatable, intent(out) :: error
      !> Of more coordinates than these only the diagonal is found
      integer, parameter :: most = 80
      real(wp), allocatable :: force(:), push(:)
      integer, allocatable :: place(:)
      integer :: i, k, n
      associate (layout => scene%system%layout, system => scene%system)
         n = sum(layout%n)
         allocate (mobility(n, n), stiffness(n), place(n), force(layout%nw), push(layout%nw))
         n = 0
         do i = 1, size(layout%n)
            do k = 1, layout%n(i)
               n = n + 1
               place(n) = layout%w(i) + layout%rates(i) + k - 1
               stiffness(n) = max(system%model%bodies(i)%reduced%omega2(k), tiny(1.0_wp))
            end do
         end do
         mobility = 0.0_wp
         call linearise(system, scene%work, system%model%dynamics%start, scene%q, error)
         if (allocated(error)) return
         do i = 1, n
            force = 0.0_wp
            force(place(i)) = 1.0_wp
            call accelerate(system, scene%work, force, push)
            mobility(:, i) = push(place)
            if (n > most) then
               mobility(:, i) = 0.0_wp
               mobility(i, i) = push(place(i))
            end if
         end do
      end associate
   end subroutine find_mobility

   !> Deflection, slope, axial force and vibration of one beam.
   subroutine look_at_beam(scene, track, mobility, stiffness, eta, beam)
      type(scene_type), intent(in) :: scene
      type(track_type), intent(in) :: track
      real(wp), intent(in) :: mobility(:, :), stiffness(:), eta(:, :)
      type(forecast_type), intent(inout) :: beam
      real(wp) :: extra(track%count), softening(track%count), lead(track%count), largest, difference, bend
      integer :: k, j, first, last
      if (beam%bending == 0) return
      first = beam%first
      last = first + beam%bending - 1
      associate (body => scene%system%model%bodies(beam%body), n => track%count)
         do k = 1, n
            ! Tension of axial coordinates that follow at once, on the first bending coordinate
            extra(k) = 0.0_wp
            do j = 1, beam%axial
               extra(k) = extra(k) + 2*body%reduced%cubic(1, j)*track%forces(last + j, k)/stiffness(last + j)
            end do
            bend = maxval(abs(matmul(body%field%w, eta(first:last, k))))/body%beam%length
            beam%deflection = max(beam%deflection, bend)
            beam%slope = max(beam%slope, maxval(abs(matmul(body%field%theta, eta(first:last, k)))))
         end do
         beam%slack_slope = beam%slope
         beam%force = maxval(abs(extra))/stiffness(first)
         beam%strain = beam%force*(acos(-1.0_wp)/body%beam%length)**2*body%beam%ei/body%beam%ea
         softening = track%spin(beam%body, :n)**2
         beam%rotation = sqrt(maxval(softening)/stiffness(first))
         beam%frequency = sqrt(mobility(first, first)*stiffness(first))
         lead = mobility(first, first)*track%forces(first, :n)
         call follow_first(track%times(:n), lead, beam%frequency**2, mobility(first, first)*extra, softening, largest, difference)
         if (largest > 0.0_wp) then
            beam%geometric = difference/largest
            ! The axial force stiffens, or lets the beam buckle
            bend = largest/max(maxval(abs(eta(first, :))), tiny(largest))
            if (beam%geometric > 0.01_wp) then
               beam%deflection = min(1.0_wp, bend*beam%deflection)
               beam%slope = min(1.0_wp, bend*beam%slope)
               beam%softening = max(1.0_wp, bend)
            end if
            beam%vibration = min(1.0_wp, maxval(abs(eta(first, :) - track%forces(first, :n)/stiffness(first))) &
               & /max(maxval(abs(eta(first, :))), tiny(largest)))
         end if
      end associate
   end subroutine look_at_beam

   !> What each coordinate does to the channels.
   subroutine look_at_channels(scene, track, eta, speed, swing, probe)
      type(scene_type), intent(inout) :: scene
      type(track_type), intent(in) :: track
      !> Coordinates at the samples (n, samples), and the largest speed of each (n)
      real(wp), intent(in) :: eta(:, :), speed(:)
      !> What of each vibrates (n)
      real(wp), intent(in) :: swing(:)
      type(pilot_type), intent(inout) :: probe
      type(recorder_type) :: recorder
      real(wp), allocatable :: values(:), moved(:), largest(:), slope(:, :), amplitude(:)
      type(constraint_matrix_type) :: frames
      integer :: i, k, j, channels
      logical :: looked
      associate (system => scene%system, n => size(eta, 1))
         channels = size(system%model%channels)
         allocate (values(sample_width(system)), moved(sample_width(system)), largest(channels), slope(channels, n), amplitude(n))
         recorder = new_recorder(system, track%q(:, 1))
         call new_constraint_matrix(system, .false., frames)
         largest = 0.0_wp
         slope = 0.0_wp
         amplitude = maxval(abs(eta), 2)
         do k = 1, track%count
            call follow_places(recorder%turns, system, scene%work%kinematics, track%times(k), track%q(:, k))
            looked = mod(k, max(1, track%count/looks)) == 0
            if (looked) then
               call evaluate(0, values)
               largest = max(largest, abs(values(:channels)))
            end if
            if (mod(k - track%count/(2*moves), max(1, track%count/moves)) /= 0) cycle
            if (.not. looked) call evaluate(0, values)
            do j = 1, n
               if (.not. amplitude(j) > 0.0_wp) cycle
               call evaluate(j, moved)
               slope(:, j) = max(slope(:, j), abs(moved(:channels) - values(:channels)))
            end do
         end do
      end associate
      do i = 1, size(probe%beams)
         call weigh(probe%beams(i))
      end do

   contains

      !> Channels at the rigid place, with one coordinate moved by its amplitude, at its largest speed.
      subroutine evaluate(coordinate, values)
         integer, intent(in) :: coordinate
         real(wp), intent(inout) :: values(:)
         real(wp) :: q(size(track%q, 1)), v(size(track%q, 1)), a(size(track%q, 1)), scratch(size(track%q, 1)), residual
         real(wp) :: before(size(track%q, 1))
         type(error_type), allocatable :: error
         integer :: b, first
         logical :: done
         q = track%q(:, k)
         v = track%v(:, k)
         if (coordinate > 0) then
            first = 0
            do b = 1, size(scene%system%layout%n)
               if (coordinate <= first + scene%system%layout%n(b)) exit
               first = first + scene%system%layout%n(b)
            end do
            q(scene%system%layout%q(b) + 3 + coordinate - first) = amplitude(coordinate)
            ! Frames follow, and no other deflection: in the mass norm a light beam would give way to what it carries
            before = q
            call close_positions(scene%system, scene%work, frames, track%times(k), q, done)
            if (.not. done) q = before
            ! Bodies move with the vibration as they are moved by the deflection, eq. (7.76)
            v = v + speed(coordinate)/amplitude(coordinate)*(q - track%q(:, k))
         end if
         a = 0.0_wp
         call settle(scene%system, scene%work, track%times(k), q, v, scratch, recorder%needs_accelerations, residual, error)
         if (allocated(error)) return
         if (recorder%needs_accelerations) call accelerations(scene%system, scene%work, q, v, a)
         call channel_values(recorder, scene%system, scene%work, track%times(k), q, v, a, values)
      end subroutine evaluate

      !> Parts of the channels, relative to their largest values.
      subroutine weigh(beam)
         type(forecast_type), intent(inout) :: beam
         real(wp) :: whole, sum_of, along
         integer :: c, m, first, last
         first = beam%first + beam%bending
         last = first + beam%axial - 1
         associate (body => scene%system%model%bodies(beam%body))
            do m = 1, beam%axial
               beam%ringing_size = beam%ringing_size + maxval(abs(body%field%u(:, m)))*swing(first + m - 1)/body%beam%length
            end do
         end associate
         do c = 1, channels
            whole = largest(c)
            sum_of = sum(slope(c, :))
            whole = max(whole, sum_of)
            if (.not. whole > 0.0_wp) cycle
            do m = 1, beam%bending
               beam%part(m) = max(beam%part(m), slope(c, beam%first + m - 1)/whole)
            end do
            beam%effect = max(beam%effect, sum(slope(c, beam%first:beam%first + beam%bending - 1))/whole)
            if (beam%axial == 0) cycle
            along = sum(slope(c, first:last))/whole
            if (is_of_motion(c)) then
               beam%stretch = max(beam%stretch, along)
               cycle
            end if
            if (largest(c) > 0.0_wp) whole = largest(c)
            along = sum(slope(c, first:last)*swing(first:last)/max(amplitude(first:last), tiny(whole)))
            beam%ringing = max(beam%ringing, min(1.0_wp, along/whole))
         end do
         beam%part = min(1.0_wp, beam%softening*beam%part)
         beam%effect = min(1.0_wp, beam%softening*beam%effect)
         if (beam%asked) beam%effect = 1.0_wp
      end subroutine weigh

      !> Whether a channel has places and speeds alone. Forces and accelerations of a disturbed state are those of the disturbance:
      !> in them a stretch would count as the whole axial force, which is there without it too.
      pure logical function is_of_motion(c)
         integer, intent(in) :: c
         integer :: j
         is_of_motion = .true.
         associate (asked => scene%system%model%channels(c)%quantities)
            do j = 1, size(asked)
               is_of_motion = is_of_motion .and. asked(j)%dimension(3) == 0 .and. asked(j)%dimension(2) > -2
            end do
         end associate
      end function is_of_motion

   end subroutine look_at_channels

end module limber_accuracy_pilot_run
