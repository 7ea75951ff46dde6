!> The dynamic analysis: lets the integrator run from the assembled state to the end and records a sample at each of the
!> asked times, projected onto the constraints. Floor: analysis.
module limber_analysis_dynamics
   use limber_base_kinds, only: wp, long
   use limber_base_error, only: error_type, raise
   use limber_base_text, only: as_text, newline
   use limber_analysis_axial, only: axial_watch_type, axial_verdict_type, axial_target, axial_share, start_axial_watch, &
      & watch_axial, pass_axial_break, axial_findings
   use limber_analysis_indicators, only: indicators_type, start_indicators
   use limber_analysis_observation, only: observe
   use limber_analysis_scene, only: scene_type, seconds_since
   use limber_analysis_watch, only: check_deflections, jump_watch_type, start_watch, watch_velocities, scale_warning
   use limber_integrator_adams, only: adams_type
   use limber_integrator_alpha, only: alpha_type
   use limber_integrator_conserving, only: conserving_type
   use limber_integrator_radau, only: radau_type
   use limber_integrator_integrator, only: integrator_type
   use limber_model_breaks, only: break_times, station_times
   use limber_model_scene, only: dynamics_type
   use limber_output_channels, only: recorder_type, new_recorder, follow_angles, channel_values, gather_balance, sample_width
   use limber_output_internal_forces, only: effort_type
   use limber_output_progress, only: progress_type
   use limber_output_sink, only: sink_type
   use limber_system_dynamics, only: linearise, accelerations, position_residual, velocity_residual, mechanical_energy, &
      & worst_constraint
   use limber_system_kinematics, only: place_frames, settle_angles
   use limber_system_multiplier, only: update_jacobians
   use limber_system_projection, only: harmless, settle, settle_position, settle_stretched
   use limber_system_system, only: system_type, workspace_type
   implicit none
   private
   public :: run_dynamics, outcome_type, new_integrator, check_residuals

   !> What a run leaves behind besides its history
   type :: outcome_type
      !> Time reached, and samples taken
      real(wp) :: reached = 0.0_wp
      integer(long) :: samples = 0
      !> Wall and CPU seconds of the time loop
      real(wp) :: wall = 0.0_wp, cpu = 0.0_wp
      !> Largest constraint residuals at a sample: position [length or 1], velocity [the same per time]
      real(wp) :: position_residual = 0.0_wp, velocity_residual = 0.0_wp
      !> Whether a sample could not be brought onto the constraints
      logical :: astray = .false.
      !> Whether a channel had no value at a sample
      logical :: undefined = .false.
      !> Mechanical energy at the start and the end, and work put in
      real(wp) :: first_energy = 0.0_wp, last_energy = 0.0_wp, work = 0.0_wp
      !> Largest |energy - first energy - work| at the end of a step with samples, and the largest energy that it compares with
      real(wp) :: imbalance = 0.0_wp, largest_energy = 0.0_wp
      !> What the user should know, one line after another; not allocated if there is nothing
      character(:), allocatable :: warnings
      !> What is left out where axial coordinates follow at rest, a line for each such beam; not allocated if there is none
      character(:), allocatable :: axial
      !> Error of deflections that this is expected to make, 1 where axial waves are left out (bodies); not allocated if there is none
      real(wp), allocatable :: left_out(:)
      !> Envelopes of internal forces (bodies)
      type(effort_type), allocatable :: efforts(:)
      !> How far the flexible bodies are within the ranges of their models; allocated by analyses that look at it
      type(indicators_type), allocatable :: indicators
   end type outcome_type

   !> Scratch of the sampling, allocated once
   type :: sample_type
      real(wp), allocatable :: q(:), v(:), a(:), change(:), values(:)
      real(wp) :: w = 0.0_wp
      !> Number of the step and time at which flexible bodies are to be observed next, whichever comes first, and the number of
      !> evaluations before which they are not
      integer(long) :: next_step = 0
      real(wp) :: next_look = -huge(1.0_wp)
      integer :: next_evaluation = 0
   end type sample_type

contains

   !> The integrator that the deck chooses.
   subroutine new_integrator(dynamics, integrator)
      type(dynamics_type), intent(in) :: dynamics
      class(integrator_type), allocatable, intent(out) :: integrator
      select case (dynamics%integrator)
      case ('ALPHA'); allocate (alpha_type :: integrator)
      case ('CONSERVING'); allocate (conserving_type :: integrator)
      case ('RADAU'); allocate (radau_type :: integrator)
      case default; allocate (adams_type :: integrator)
      end select
      select type (integrator)
      type is (alpha_type)
         integrator%radius = dynamics%spectral_radius
      end select
      integrator%tolerance = dynamics%tolerance
      integrator%initial_step = dynamics%initial_step
      integrator%maximum_step = dynamics%maximum_step
      integrator%fixed_step = dynamics%fixed_step
   end subroutine new_integrator

   !> Runs from the start to the end.
   subroutine run_dynamics(scene, integrator, history, progress, outcome, error)
      type(scene_type), intent(inout) :: scene
      class(integrator_type), intent(inout) :: integrator
      !> Takes the samples: an open history with its channels defined, or memory
      class(sink_type), intent(inout) :: history
      type(progress_type), intent(inout) :: progress
      type(outcome_type), intent(out) :: outcome
      !> The run could not finish: which body, joint or constraint, when, and what to try
      type(error_type), allocatable, intent(out) :: error
      type(recorder_type) :: recorder
      type(sample_type) :: sample
      type(axial_watch_type) :: axial
      integer(long) :: tick
      real(wp) :: cpu
      integer :: before(2)
      before = [scene%work%evaluations, scene%work%matrix%factorisations]
      call system_clock(tick)
      call cpu_time(cpu)
      associate (nq => scene%system%layout%nq, dynamics => scene%system%model%dynamics)
         allocate (sample%q(nq), sample%v(nq), sample%a(nq), sample%change(nq), sample%values(sample_width(scene%system)))
         sample%a = 0.0_wp
         allocate (outcome%indicators)
         call start_indicators(outcome%indicators, scene%system)
         recorder = new_recorder(scene%system, scene%q)
         if (allocated(scene%angle)) recorder%angle = scene%angle
         outcome%reached = dynamics%start
         call start_axial(scene, axial, sample%change, error)
         if (.not. allocated(error)) call integrator%start(scene%system, scene%work, dynamics%start, &
            & dynamics%end - dynamics%start, scene%q, scene%v, error)
         if (.not. allocated(error)) call advance(scene, dynamics, integrator, recorder, sample, history, progress, axial, &
            & outcome, error)
      end associate
      scene%last%q = sample%q
      scene%last%v = sample%v
      scene%last%angle = recorder%angle
      scene%last%balanced = .false.
      scene%last%rotation = 0.0_wp
      if (allocated(recorder%efforts)) call move_alloc(recorder%efforts, outcome%efforts)
      outcome%wall = seconds_since(tick)
      outcome%cpu = cpu_now() - cpu
      associate (statistics => integrator%statistics)
         statistics%evaluations = scene%work%evaluations - before(1)
         statistics%factorisations = statistics%factorisations + scene%work%matrix%factorisations - before(2)
      end associate
   end subroutine run_dynamics

   !> The time loop. Steps end at the breaks of the drivers and loads, where the integrator starts anew.
   subroutine advance(scene, dynamics, integrator, recorder, sample, history, progress, axial, outcome, error)
      type(scene_type), intent(inout) :: scene
      type(dynamics_type), intent(in) :: dynamics
      class(integrator_type), intent(inout) :: integrator
      type(recorder_type), intent(inout) :: recorder
      type(sample_type), intent(inout) :: sample
      class(sink_type), intent(inout) :: history
      type(progress_type), intent(inout) :: progress
      type(axial_watch_type), intent(inout) :: axial
      type(outcome_type), intent(inout) :: outcome
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: breaks(:), stations(:)
      type(jump_watch_type) :: watch
      character(:), allocatable :: text
      !> Where the next step must end at the latest, the next break, and times so near that there is no step between them
      real(wp) :: stop, barrier, near
      integer :: next, passed, seen
      logical :: at_station
      allocate (breaks, source=break_times(scene%system%model))
      allocate (stations, source=station_times(scene%system%model))
      passed = 0
      seen = 0
      near = 8*spacing(max(abs(dynamics%start), abs(dynamics%end)))
      sample%q = scene%q
      sample%v = scene%v
      call start_watch(watch, dynamics%start, scene%v)
      watch%late = dynamics%end - 0.1_wp*(dynamics%end - dynamics%start)
      call check_energy(scene, sample, outcome)
      call record(scene, dynamics%start, integrator, recorder, sample, history, outcome, error)
      next = 1
      do while (next <= dynamics%outputs .and. .not. allocated(error))
         if (integrator%statistics%steps >= dynamics%maximum_steps) then
            text = ''
            if (dynamics%integrator == 'ADAMS') text = ', or INTEGRATOR=RADAU if vibrations that do not matter bind the step'
            call raise(error, 'MAXIMUM STEPS='//as_text(dynamics%maximum_steps)//' are used up at t = '// &
               & as_text(integrator%t, 6)//'; give more, or a looser TOLERANCE'//text)
            exit
         end if
         barrier = dynamics%end
         if (passed < size(breaks)) barrier = nearest(breaks(passed + 1), -1.0_wp)
         stop = barrier
         do while (seen < size(stations))
            if (stations(seen + 1) > integrator%t + near) exit
            seen = seen + 1
         end do
         if (seen < size(stations)) stop = min(stop, stations(seen + 1))
         if (integrator%ends_on_samples) then
            stop = min(stop, sample_time(dynamics, next))
         else
            stop = min(stop, integrator%t + turn_time(scene%system, integrator%t - integrator%t_before, sample%q, sample%v))
         end if
         call integrator%step(scene%system, scene%work, stop, error)
         if (allocated(error)) exit
         call integrator%interpolate(integrator%t, sample%q, sample%v, sample%w)
         call integrator%complete(scene%system, scene%work, integrator%t, sample%q, sample%v)
         call look(scene, dynamics, integrator, sample, outcome)
         call check_deflections(scene%system, integrator%t, sample%q, sample%v, error)
         if (allocated(error)) exit
         call watch_velocities(watch, scene%system, scene%work, integrator%t, sample%q, sample%v, text)
         if (allocated(text)) call warn(outcome, text)
         call follow_angles(recorder, scene%system, sample%q)
         call watch_axial(axial, scene%system, scene%work, integrator%t, sample%q)
         if (size(scene%work%kinematics%angles) > 0) then
            call place_frames(scene%system%model, scene%system%layout, integrator%t, sample%q, scene%work%kinematics)
            call settle_angles(scene%work%kinematics)
         end if
         at_station = .false.
         if (seen < size(stations)) at_station = stations(seen + 1) <= integrator%t + near
         if (at_station .or. sample_time(dynamics, next) <= integrator%t + near) call check_energy(scene, sample, outcome)
         if (passed < size(breaks) .and. integrator%t >= barrier - near) then
            call record_before(barrier - near)
            if (allocated(error)) exit
            passed = passed + 1
            call pass_break(scene, breaks(passed), integrator, sample, outcome, error)
            if (allocated(error)) exit
            call start_watch(watch, breaks(passed), sample%v)
            call pass_axial_break(axial, scene%system, scene%work, breaks(passed))
         end if
         call record_before(integrator%t + near)
         call progress%update(integrator%t)
      end do
      outcome%reached = integrator%t
      text = scale_warning(watch, scene%system, integrator%tolerance, integrator%t)
      if (text /= '' .and. .not. allocated(error)) call warn(outcome, text)
      call report_axial(scene, axial, outcome)

   contains

      !> Records the samples up to a time that the integrator has reached. At a break they are those that follow it.
      subroutine record_before(t)
         real(wp), intent(in) :: t
         do while (next <= dynamics%outputs .and. sample_time(dynamics, next) <= t)
            call integrator%interpolate(sample_time(dynamics, next), sample%q, sample%v, sample%w)
            call integrator%complete(scene%system, scene%work, sample_time(dynamics, next), sample%q, sample%v)
            call record(scene, sample_time(dynamics, next), integrator, recorder, sample, history, outcome, error)
            if (allocated(error)) exit
            next = next + 1
         end do
      end subroutine record_before

   end subroutine advance

   !> Time in which no frame turns by more than a part of a turn, so that turns can be counted; huge if the last step was so short that
   !> the next one cannot come near that.
   pure real(wp) function turn_time(system, last, q, v) result(longest)
      type(system_type), intent(in) :: system
      !> Length of the last step; coordinates and velocities (nq)
      real(wp), intent(in) :: last, q(:), v(:)
      !> Largest turn in a step [rad], and factor by which steps grow at most
      real(wp), parameter :: most = 2.0_wp, growth = 10.0_wp
      real(wp) :: spin
      integer :: i, first
      spin = 0.0_wp
      do i = 1, size(system%layout%q)
         if (.not. system%layout%framed(i)) cycle
         first = system%layout%q(i) + 2
         spin = max(spin, abs(q(first)*v(first + 1) - q(first + 1)*v(first)))
      end do
      longest = huge(longest)
      if (growth*last*spin > most) longest = most/spin
   end function turn_time

   !> Begins to watch axial coordinates that follow at rest, and puts them where they belong.
   subroutine start_axial(scene, axial, change, error)
      type(scene_type), intent(inout) :: scene
      type(axial_watch_type), intent(inout) :: axial
      !> Scratch (nq)
      real(wp), intent(inout) :: change(:)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: residual
      associate (system => scene%system, work => scene%work)
         call start_axial_watch(axial, system, work, scene%q, scene%v)
         if (system%condensed) call settle(system, work, system%model%dynamics%start, scene%q, scene%v, change, .true., residual, &
            & error)
      end associate
   end subroutine start_axial

   !> Says what was left out of beams whose axial coordinates have followed at rest; a warning where that is too much.
   subroutine report_axial(scene, axial, outcome)
      type(scene_type), intent(in) :: scene
      type(axial_watch_type), intent(in) :: axial
      type(outcome_type), intent(inout) :: outcome
      type(axial_verdict_type) :: verdict
      integer :: i
      do i = 1, size(scene%system%model%bodies)
         if (.not. scene%system%model%bodies(i)%reduced%condensed) cycle
         if (.not. allocated(outcome%axial)) outcome%axial = ''
         if (.not. allocated(outcome%left_out)) allocate (outcome%left_out(size(scene%system%model%bodies)), source=0.0_wp)
         call axial_findings(axial, scene%system, i, axial_target, verdict)
         outcome%left_out(i) = merge(1.0_wp, verdict%error, verdict%share > axial_share)
         if (verdict%admissible) outcome%axial = outcome%axial//"   beam '"//scene%system%model%bodies(i)%name//"' "// &
            & verdict%words//newline
         if (.not. verdict%admissible) call warn(outcome, "beam '"//scene%system%model%bodies(i)%name// &
            & "', AXIAL DYNAMICS=STATIC: "//verdict%words//'; use FULL')
      end do
   end subroutine report_axial

   !> Observes the flexible bodies now and then. It is as dear as up to ten evaluations, which are not counted, and so seldom that
   !> the run hardly notices.
   subroutine look(scene, dynamics, integrator, sample, outcome)
      type(scene_type), intent(inout) :: scene
      type(dynamics_type), intent(in) :: dynamics
      class(integrator_type), intent(in) :: integrator
      !> With the state at the end of a step
      type(sample_type), intent(inout) :: sample
      type(outcome_type), intent(inout) :: outcome
      !> Steps, and parts of the run, after which they are observed again; evaluations that lie between in any case
      integer, parameter :: steps = 32, parts = 50, evaluations = 24
      type(error_type), allocatable :: error
      integer :: before(2)
      if (size(outcome%indicators%bodies) == 0) return
      if (integrator%statistics%steps < sample%next_step .and. integrator%t < sample%next_look) return
      if (scene%work%evaluations < sample%next_evaluation) return
      sample%next_evaluation = scene%work%evaluations + evaluations
      sample%next_step = integrator%statistics%steps + steps
      sample%next_look = integrator%t + (dynamics%end - dynamics%start)/parts
      associate (system => scene%system, work => scene%work)
         before = [work%evaluations, work%matrix%factorisations]
         call linearise(system, work, integrator%t, sample%q, error)
         if (.not. allocated(error)) then
            call accelerations(system, work, sample%q, sample%v, sample%a)
            call observe(outcome%indicators, system, work, integrator%t, sample%q, sample%v, sample%a)
         end if
         work%evaluations = before(1)
         work%matrix%factorisations = before(2)
      end associate
   end subroutine look

   !> Starts the integrator anew at an instant from which other formulas hold. Velocities that a driver changes abruptly change as
   !> by an impact; a position that it changes is an error.
   subroutine pass_break(scene, t, integrator, sample, outcome, error)
      type(scene_type), intent(inout) :: scene
      real(wp), intent(in) :: t
      class(integrator_type), intent(inout) :: integrator
      type(sample_type), intent(inout) :: sample
      type(outcome_type), intent(inout) :: outcome
      type(error_type), allocatable, intent(out) :: error
      !> Relative residuals beyond which a position and a velocity have jumped
      real(wp), parameter :: jump = 1.0e-8_wp, impact = 1.0e-6_wp
      real(wp) :: residual, energy(2), before, speed
      integer :: culprit
      logical :: demanded
      associate (system => scene%system, work => scene%work)
         call integrator%interpolate(integrator%t, sample%q, sample%v, sample%w)
         call integrator%complete(system, work, integrator%t, sample%q, sample%v)
         demanded = demanded_jump(system, work, t, sample%q)
         call linearise(system, work, t, sample%q, error)
         if (allocated(error)) return
         if (system%nc > 0) then
            call worst_constraint(system, work, culprit, residual)
            if (residual > jump*system%constraints(culprit)%item%scale) then
               call raise(error, system%constraints(culprit)%item%label//' jumps by '//as_text(residual, 3)//' at t = '// &
                  & as_text(t, 8)//'; a motion must be continuous: use smoothstep((t - t0)/duration) in place of a jump')
               return
            end if
         end if
         call mechanical_energy(system, work, sample%q, sample%v, energy(1), energy(2))
         before = sum(energy)
         speed = maxval(abs(sample%v))
         sample%change = sample%v
         call settle(system, work, t, sample%q, sample%v, sample%a, .true., residual, error)
         if (allocated(error)) return
         call mechanical_energy(system, work, sample%q, sample%v, energy(1), energy(2))
         if (maxval(abs(sample%v - sample%change)) > impact*speed .and. demanded) call warn(outcome, 'velocities jump at t = '// &
            & as_text(t, 8)//' as by an impact, for a driver changes its speed abruptly there; the energy changes by '// &
            & as_text(sum(energy) - before, 3))
         integrator%work_at_start = sample%w + sum(energy) - before
         associate (dynamics => system%model%dynamics)
            call integrator%start(system, work, t, dynamics%end - dynamics%start, sample%q, sample%v, error)
         end associate
      end associate
   end subroutine pass_break

   !> Whether drivers ask for other velocities right after an instant than right before it.
   logical function demanded_jump(system, work, t, q) result(jumps)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Time; coordinates (nq)
      real(wp), intent(in) :: t, q(:)
      real(wp), parameter :: little = 1.0e-7_wp
      real(wp) :: before(system%nc), rest(size(q)), largest
      jumps = .false.
      if (system%nc == 0) return
      rest = 0.0_wp
      call place_frames(system%model, system%layout, nearest(t, -1.0_wp), q, work%kinematics)
      call update_jacobians(system, work)
      largest = velocity_residual(system, work, rest)
      before = work%gamma(:system%nc)
      call place_frames(system%model, system%layout, t, q, work%kinematics)
      call update_jacobians(system, work)
      largest = velocity_residual(system, work, rest)
      jumps = any(abs(work%gamma(:system%nc) - before) > little*max(abs(before), abs(work%gamma(:system%nc))))
   end function demanded_jump

   !> Adds a line to the warnings of a run.
   pure subroutine warn(outcome, text)
      type(outcome_type), intent(inout) :: outcome
      character(*), intent(in) :: text
      if (.not. allocated(outcome%warnings)) outcome%warnings = ''
      outcome%warnings = outcome%warnings//'warning: '//text//newline
   end subroutine warn

   !> Time of a sample; the last is the end, to the bit.
   pure real(wp) function sample_time(dynamics, index)
      type(dynamics_type), intent(in) :: dynamics
      integer, intent(in) :: index
      sample_time = dynamics%start + (dynamics%end - dynamics%start)*(real(index, wp)/dynamics%outputs)
      if (index == dynamics%outputs) sample_time = dynamics%end
   end function sample_time

   !> Projects a state onto the constraints, evaluates the channels there and hands them to the history. Velocities at the end of
   !> a step that conserves energy are left as they are: projected, they would have another.
   subroutine record(scene, t, integrator, recorder, sample, history, outcome, error)
      type(scene_type), intent(inout) :: scene
      real(wp), intent(in) :: t
      class(integrator_type), intent(in) :: integrator
      type(recorder_type), intent(inout) :: recorder
      type(sample_type), intent(inout) :: sample
      class(sink_type), intent(inout) :: history
      type(outcome_type), intent(inout) :: outcome
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: before, residual
      integer :: culprit
      associate (system => scene%system, work => scene%work)
         if (system%condensed) then
            ! The motion keeps the balance of energy without the stretch that the channels show
            call settle(system, work, t, sample%q, sample%v, sample%change, .true., residual, error)
            if (allocated(error)) return
            call accelerations(system, work, sample%q, sample%v, sample%a)
            call gather_balance(recorder, system, work, sample%q, sample%v)
            call settle_stretched(system, work, t, sample%q, sample%v, sample%change, residual, error)
         else if (recorder%needs_velocities .and. .not. integrator%ends_on_samples) then
            call settle(system, work, t, sample%q, sample%v, sample%change, recorder%needs_accelerations, residual, error)
         else
            call settle_position(system, work, t, sample%q, sample%change, before, residual, error)
         end if
         if (allocated(error)) return
         call check_residuals(system, work, recorder%needs_velocities, sample%v, outcome)
         if (residual > harmless .and. .not. outcome%astray) then
            outcome%astray = .true.
            call worst_constraint(system, work, culprit, residual)
            call warn(outcome, system%constraints(culprit)%item%label//' is not kept at the sample at t = '//as_text(t, 8)// &
               & ' (residual '//as_text(residual, 3)//'): it is nearly singular there, or masses differ too much; this sample,'// &
               & ' and others like it, are wrong; try a smaller TOLERANCE, or another INTEGRATOR')
         end if
         if (recorder%needs_accelerations .and. .not. system%condensed) call accelerations(system, work, sample%q, sample%v, &
            & sample%a)
         recorder%work = sample%w
         call channel_values(recorder, system, work, t, sample%q, sample%v, sample%a, sample%values)
         if (.not. all(abs(sample%q) <= huge(t))) then
            call raise(error, 'the motion is no number any more at t = '//as_text(t, 8)//': something in it is too large or too'// &
               & ' small for double precision; use other units, or look at the numbers of the deck')
            return
         end if
         if (.not. (outcome%undefined .or. all(abs(sample%values) <= huge(t)))) then
            outcome%undefined = .true.
            do culprit = 1, size(system%model%channels) - 1
               if (.not. abs(sample%values(culprit)) <= huge(t)) exit
            end do
            call warn(outcome, "channel '"//system%model%channels(culprit)%name//"' has no value at t = "//as_text(t, 8))
         end if
      end associate
      call history%take(t, sample%values, error)
      outcome%samples = outcome%samples + 1
   end subroutine record

   !> Constraint residuals of a sample.
   subroutine check_residuals(system, work, moving, v, outcome)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Whether its velocities are asked for
      logical, intent(in) :: moving
      real(wp), intent(in) :: v(:)
      type(outcome_type), intent(inout) :: outcome
      real(wp) :: largest
      if (system%nc == 0) return
      largest = position_residual(system, work)
      outcome%position_residual = max(outcome%position_residual, maxval(abs(work%phi)))
      if (.not. moving) return
      largest = velocity_residual(system, work, v)
      outcome%velocity_residual = max(outcome%velocity_residual, maxval(abs(work%gamma)))
   end subroutine check_residuals

   !> Energy balance at the end of a step.
   subroutine check_energy(scene, sample, outcome)
      type(scene_type), intent(inout) :: scene
      type(sample_type), intent(in) :: sample
      type(outcome_type), intent(inout) :: outcome
      real(wp) :: kinetic, potential
      call mechanical_energy(scene%system, scene%work, sample%q, sample%v, kinetic, potential)
      if (outcome%samples == 0) outcome%first_energy = kinetic + potential
      outcome%last_energy = kinetic + potential
      outcome%work = sample%w
      outcome%imbalance = max(outcome%imbalance, abs(kinetic + potential - outcome%first_energy - sample%w))
      outcome%largest_energy = max(outcome%largest_energy, kinetic, abs(potential - outcome%first_energy))
   end subroutine check_energy

   !> CPU seconds of this process.
   real(wp) function cpu_now()
      call cpu_time(cpu_now)
   end function cpu_now

end module limber_analysis_dynamics
