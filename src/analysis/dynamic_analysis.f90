!> *DYNAMICS: the motion in time. Lets the integrator run from the assembled state to the end and records a sample at each of the
!> asked times, projected onto the constraints. Floor: analysis.
module limber_analysis_dynamic_analysis
   use limber_base_kinds, only: wp, long
   use limber_base_error, only: error_type, raise, status_deck
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text, newline
   use limber_monitor_indicators, only: looks_at_jumps
   use limber_monitor_curve_watch, only: curve_watch_type, new_curve_watch, begin_curves, go_on_curves, find_hidden
   use limber_analysis_curve_pieces, only: curve_pieces_type, new_pieces, begin_pieces, look_ahead, find_end, pass_end, &
      & count_kink, tell_kinks, release_pieces
   use limber_analysis_chosen_integrator, only: replace_integrator
   use limber_analysis_contacts, only: contacts_type, new_contacts, check_gaps, turn_states, find_opening, find_jump, &
      & note_rest
   use limber_analysis_cost_watch, only: costs_type, watch_costs, stands_in
   use limber_analysis_crossings, only: crossings_type, new_crossings, begin_crossings, resume_crossings, go_on, find_crossing, &
      & count_crossing, found_nothing, found_bend, found_jump
   use limber_analysis_events, only: events_type, start_events, begin_events, pass_events, count_turn
   use limber_analysis_fresh_start, only: pass_break
   use limber_analysis_added_errors, only: added_errors_type, start_added, begin_added, note_added, tell_errors, tell_passages
   use limber_scene_interruption, only: interruption_type
   use limber_monitor_indicator_start, only: start_indicators
   use limber_scene_joint_check, only: watches_joints
   use limber_scene_law_checks, only: find_instants
   use limber_analysis_looks, only: look, look_at_end, observe_state
   use limber_monitor_function_sudden, only: at_start, in_motion, before_break, behind_break
   use limber_monitor_noise, only: noise_of
   use limber_scene_outcome, only: outcome_type, warn
   use limber_scene_sampling, only: sample_type, sample_time, record, look_between, check_energy, check_residuals, &
      & forget_system
   use limber_scene_scene, only: scene_type, seconds_since
   use limber_analysis_ringing_springs, only: ringing_springs_type
   use limber_analysis_stiffening, only: stiffening_type, watch_stiffness, stiffness_warning
   use limber_analysis_turn_steps, only: turning_type, start_turning, turn_time, watch_turning
   use limber_analysis_unfollowed, only: unfollowed_type, start_unfollowed, watch_channels, unfollowed_warning, shows_vibrations
   use limber_monitor_run_monitor, only: check_deflections, jump_watch_type, start_watch, watch_velocities, find_weak
   use limber_integrator_adams, only: adams_type
   use limber_integrator_bound_steps, only: bound_steps_type
   use limber_integrator_integrator, only: integrator_type
   use limber_model_law_breaks, only: last_instant
   use limber_model_model, only: dynamics_type, event_switch
   use limber_output_channel_values, only: recorder_type, new_recorder, sample_width
   use limber_output_internal_forces, only: renew_efforts
   use limber_output_progress, only: progress_type
   use limber_output_sample_sink, only: sink_type, memory_type
   use limber_output_followed_turns, only: follow_places, follow_motion
   use limber_multibody_control_states, only: next_sample, take_samples, has_inputs
   use limber_multibody_kinematics, only: place_frames, move_frames, settle_angles
   use limber_multibody_multiplier_system, only: place_constraints
   use limber_multibody_switching, only: exchange_switches
   use limber_multibody_system, only: system_type
   implicit none
   private
   public :: run_dynamics

contains

   !> Runs from the start to the end.
   subroutine run_dynamics(scene, integrator, history, progress, outcome, error, guard, pace)
      type(scene_type), intent(inout) :: scene
      !> Another one behind if limber has chosen it and another costs less; the model's name of it then too
      class(integrator_type), allocatable, intent(inout) :: integrator
      !> Takes the samples: an open history with its channels defined, or memory
      class(sink_type), intent(inout) :: history
      type(progress_type), intent(inout) :: progress
      type(outcome_type), intent(out) :: outcome
      !> The run could not finish: which body, joint or constraint, when, and what to try
      type(error_type), allocatable, intent(out) :: error
      !> Lets the run be interrupted and go on
      class(interruption_type), intent(inout), optional :: guard
      !> Steps of the run whose companion this is
      type(bound_steps_type), intent(in), optional :: pace
      type(recorder_type) :: recorder
      type(sample_type) :: sample
      type(costs_type) :: costs
      integer(long) :: tick
      real(wp) :: cpu
      integer :: before(2)
      logical :: changed
      before = [scene%work%evaluations, scene%work%matrix%factorisations]
      call system_clock(tick)
      associate (nq => scene%system%layout%nq, dynamics => scene%system%model%dynamics)
         allocate (sample%q(nq), sample%v(nq), sample%a(nq), sample%change(nq), sample%values(sample_width(scene%system)))
         sample%a = 0.0_wp
         allocate (outcome%indicators)
         call start_indicators(outcome%indicators, scene%system)
         outcome%indicators%bodies%noise = noise_of(integrator%tolerance)
         recorder = new_recorder(scene%system, scene%q)
         if (allocated(scene%angle)) recorder%turns%angle = scene%angle
         call follow_places(recorder%turns, scene%system, scene%work%kinematics, dynamics%start, scene%q)
         ! Not by assignment: gfortran 12 reads the bounds of what is not allocated
         if (allocated(scene%followed)) deallocate (scene%followed)
         if (allocated(scene%work%kinematics%angles)) allocate (scene%followed, source=scene%work%kinematics%angles)
         integrator%input%asked = recorder%needs_work
         outcome%shows_work = recorder%needs_work
         ! The states of controls are velocities
         integrator%speeds_asked = recorder%needs_velocities .or. any(scene%system%layout%carries)
         if (recorder%needs_accelerations) call integrator%ringing%watch(scene%system)
         sample%local = .not. (recorder%needs_places .or. watches_joints(scene%system))
         outcome%reached = dynamics%start
         scene%assembling = scene%assembling + seconds_since(tick)
         call system_clock(tick)
         call cpu_time(cpu)
         if (size(scene%system%inputs) > 0) then
            call take_samples(scene%system, scene%work, max(scene%begin, dynamics%start), 8*spacing(max(abs(dynamics%start), &
               & abs(dynamics%end))), scene%q, scene%v, changed, error)
            if (allocated(error)) return
         end if
         call integrator%start(scene%system, scene%work, max(scene%begin, dynamics%start), &
            & dynamics%end - dynamics%start, scene%q, scene%v, error)
         if (.not. allocated(error)) call advance(scene, dynamics, integrator, recorder, sample, history, progress, &
            & costs, tick, cpu, outcome, error, guard, pace)
      end associate
      associate (dynamics => scene%system%model%dynamics)
         if (allocated(costs%now)) then
            dynamics%integrator = costs%now
            dynamics%reason = dynamics%reason//costs%story()
         end if
      end associate
      call release_pieces(scene%system)
      call settle_angles(scene%work%kinematics, .false.)
      scene%last%q = sample%q
      scene%last%v = sample%v
      scene%last%angle = recorder%turns%angle
      scene%last%balanced = .false.
      scene%last%rotation = 0.0_wp
      if (allocated(recorder%efforts)) call move_alloc(recorder%efforts, outcome%efforts)
      call add_seconds(tick, cpu, outcome)
      associate (statistics => integrator%statistics)
         statistics%evaluations = scene%work%evaluations - before(1)
         statistics%factorisations = statistics%factorisations + scene%work%matrix%factorisations - before(2)
      end associate
   end subroutine run_dynamics

   !> The time loop. Steps end at the breaks of the drivers and loads, and where laws of the motion change their formula; there the
   !> integrator starts anew.
   subroutine advance(scene, dynamics, integrator, recorder, sample, history, progress, costs, tick, cpu, outcome, &
      & error, guard, pace)
      type(scene_type), intent(inout) :: scene
      type(dynamics_type), intent(in) :: dynamics
      class(integrator_type), allocatable, intent(inout) :: integrator
      type(recorder_type), intent(inout) :: recorder
      type(sample_type), intent(inout) :: sample
      class(sink_type), intent(inout) :: history
      type(progress_type), intent(inout) :: progress
      type(costs_type), intent(inout) :: costs
      !> Clock and CPU clock at the start
      integer(long), intent(in) :: tick
      real(wp), intent(in) :: cpu
      type(outcome_type), intent(inout) :: outcome
      type(error_type), allocatable, intent(out) :: error
      class(interruption_type), intent(inout), optional :: guard
      type(bound_steps_type), intent(in), optional :: pace
      !> Part of the way from one break to the next at which the first step ends at the latest
      real(wp), parameter :: first_part = 0.125_wp
      real(wp), allocatable :: breaks(:), stations(:)
      type(stiffening_type) :: stiffening
      type(unfollowed_type) :: unfollowed
      type(ringing_springs_type) :: springs
      type(jump_watch_type) :: watch
      type(turning_type) :: turning
      type(crossings_type) :: crossings
      type(events_type) :: events
      type(contacts_type) :: contacts
      type(added_errors_type) :: added
      type(curve_watch_type) :: curves
      type(curve_pieces_type) :: pieces
      character(:), allocatable :: text
      !> Where the next step must end at the latest, the next break, times so near that there is no step between them, the time
      !> up to which the last step counts, the last break, and the end: right before it if a law of time changes there
      real(wp) :: stop, barrier, near, t, since, last
      !> When a sampled control takes its next sample or changes its output; whether there are such controls
      real(wp) :: next_instant
      logical :: sampled
      integer :: passed, seen, begun
      logical :: at_station, cut, stiff, changes, first, again, turns
      !> Whether the last pass is not at its end, because the run pauses before its inputs are taken
      logical :: waiting
      !> What an event in the last step does, event_switch, ...; 0: nothing
      integer :: action
      call find_instants(scene%system%model, breaks, stations, outcome)
      passed = 0
      seen = 0
      begun = scene%work%evaluations
      near = 8*spacing(max(abs(dynamics%start), abs(dynamics%end)))
      t = max(scene%begin, dynamics%start)
      since = t
      last = last_instant(scene%system%model, dynamics%start, dynamics%end)
      next_instant = next_sample(scene%system, t, near)
      sampled = next_instant < huge(t)
      changes = .false.
      waiting = .false.
      sample%q = scene%q
      sample%v = scene%v
      call new_contacts(contacts, scene%system, integrator%tolerance)
      if (size(contacts%rest) > 0 .and. .not. restarts(guard)) call begin_contacts()
      if (allocated(error)) return
      call watch_laws()
      call start_events(events, scene%system, scene%work, t, scene%q, scene%v, integrator%tolerance)
      if (recorder%needs_accelerations) call start_unfollowed(unfollowed, scene)
      if (recorder%needs_accelerations .and. dynamics%integrator == 'CONSERVING') call springs%start(scene%system)
      call start_watch(watch, t, scene%v)
      call start_turning(turning, scene%system, t, scene%q, scene%v, integrator%ends_on_samples)
      call follow_turns(t)
      call outcome%bound%start(dynamics%start, dynamics%end - dynamics%start)
      watch%late = dynamics%end - 0.1_wp*(dynamics%end - dynamics%start)
      if (restarts(guard)) then
         call restore()
         if (passed > 0) since = breaks(passed)
         next_instant = next_sample(scene%system, integrator%t, near)
      else
         call check_energy(scene, t, sample, outcome)
         if (looks_at_jumps(outcome%indicators)) call look(scene, dynamics, integrator, at_start, sample, outcome)
         call record(scene, t, dynamics%start, integrator, recorder, sample, history, outcome, error)
         if (sample%ungripped .and. .not. allocated(error)) then
            sample%anyhow = .true.
            call record(scene, t, dynamics%start, integrator, recorder, sample, history, outcome, error)
            sample%anyhow = .false.
            call warn(outcome, 'at the start '//sample%weakest//' have no grip on the motion: forces and accelerations of the'// &
               & ' first sample are not determined; begin a little behind it')
         end if
      end if
      if (present(guard) .and. .not. allocated(error)) call go_on_from_pause()
      do while (sample%next <= dynamics%outputs .and. .not. allocated(error))
         if (integrator%statistics%steps >= dynamics%maximum_steps) then
            text = ''
            if (dynamics%integrator == 'ADAMS') text = ', or INTEGRATOR=RADAU if vibrations that do not matter bind the step'
            call raise(error, 'MAXIMUM STEPS='//as_text(dynamics%maximum_steps)//' are used up at t = '// &
               & as_text(integrator%t, 6)//'; give more, or a '// &
               & trim(merge('longer FIXED STEP', 'looser TOLERANCE ', dynamics%fixed_step > 0.0_wp))//text)
            exit
         end if
         barrier = last
         if (passed < size(breaks)) barrier = nearest(breaks(passed + 1), -1.0_wp)
         stop = barrier
         do while (seen < size(stations))
            if (stations(seen + 1) > integrator%t + near) exit
            seen = seen + 1
         end do
         if (seen < size(stations)) stop = min(stop, stations(seen + 1))
         ! A law that is zero at this break and the next shows itself between them only
         first = .not. integrator%t > integrator%t_before
         if (first .and. passed < size(breaks)) stop = min(stop, integrator%t + first_part*(barrier - integrator%t))
         if (integrator%ends_on_samples) stop = min(stop, sample_time(dynamics, sample%next))
         if (.not. dynamics%fixed_step > 0.0_wp) stop = min(stop, integrator%t + turn_time(turning))
         stop = min(stop, crossings%hold, events%hold, contacts%hold, contacts%until)
         if (sampled) stop = min(stop, next_instant)
         if (present(pace)) call keep_pace()
         call integrator%step(scene%system, scene%work, stop, error)
         if (allocated(error)) then
            if (stands_in(costs, integrator)) then
               call change_integrator()
               if (.not. allocated(error)) cycle
            end if
            if (allocated(error)) call name_weak()
         end if
         if (.not. allocated(error)) call history%check_limit(integrator%t, error, &
            & int(scene%work%evaluations - begun, long))
         if (allocated(error)) exit
         t = integrator%t
         cut = .false.
         if (size(curves%joints) > 0) then
            if (crosses_unseen()) then
               call do_again()
               if (allocated(error)) exit
               cycle
            end if
         end if
         if (size(crossings%loads) > 0) then
            call find_crossing(crossings, scene%system, scene%work, integrator, error)
            if (allocated(error)) exit
            if (crossings%found /= found_nothing .and. integrator%ends_on_samples .and. crossings%t < t - near) &
               & crossings%again = .true.
            if (first .and. crossings%found == found_bend .and. .not. crossings%again) call begin_shorter()
            if (crossings%again) then
               call do_again()
               if (allocated(error)) exit
               cycle
            end if
            call meet_crossing()
         end if
         if (size(pieces%paths) > 0) call meet_end()
         turns = .false.
         if (size(contacts%rest) > 0) then
            call look_at_pushes(again)
            if (allocated(error)) exit
            if (again) cycle
         end if
         if (size(events%counts) > 0) then
            call pass_events(events, scene, integrator, recorder, sample, near, t, action, again, outcome, error)
            if (again) call step_again()
            if (allocated(error)) exit
            if (again) cycle
            if (t < contacts%release) contacts%opens = .false.
            turns = action == event_switch .or. (action == 0 .and. any(contacts%opens))
            if (turns) then
               cut = .true.
               crossings%found = found_nothing
               crossings%hold = huge(t)
            else
               outcome%ended = action
            end if
         end if
         if (.not. dynamics%fixed_step > 0.0_wp) call outcome%bound%note(integrator%t_before, t, integrator%order, &
            & integrator%spare .or. .not. cut .and. t >= stop - near)
         call integrator%interpolate(t, sample%q, sample%v, sample%w)
         call integrator%complete(scene%system, scene%work, t, sample%q, sample%v)
         call note_added(added, scene%system, scene%work, integrator, crossings, dynamics%end, t, sample%q, sample%v)
         if (size(crossings%loads) > 0 .and. .not. cut) call go_on(crossings, sample%q, sample%v, sample%w)
         if (size(curves%joints) > 0 .and. .not. cut) call go_on_curves(curves, t, sample%q, sample%v, sample%w)
         if (size(events%counts) > 0 .and. .not. cut) call begin_events(events, scene%system, scene%work, t, sample%q, sample%v, &
            & sample%w)
         call look(scene, dynamics, integrator, in_motion, sample, outcome)
         call watch_stiffness(stiffening, scene%system, scene%work, dynamics, integrator, sample%q, sample%v, stiff)
         call watch_costs(costs, scene%system, scene%work, dynamics, integrator, stiffening, stiff, sample%q, sample%v, changes)
         call check_deflections(scene%system, t, sample%q, sample%v, error)
         if (allocated(error)) exit
         call watch_velocities(watch, scene%system, scene%work, t, sample%q, sample%v, text)
         if (allocated(text)) call warn(outcome, text)
         call watch_turning(turning, scene%system, t, sample%q, sample%v, dynamics%fixed_step > 0.0_wp, text, error)
         if (allocated(text)) call warn(outcome, text)
         if (allocated(error)) exit
         call follow_turns(t)
         at_station = .false.
         if (seen < size(stations)) at_station = stations(seen + 1) <= t + near
         if (at_station .or. sample_time(dynamics, sample%next) <= t + near) call check_energy(scene, t, sample, outcome)
         if (outcome%ended > 0) then
            call record_end()
            exit
         end if
         if (passed < size(breaks) .and. t >= barrier - near) then
            call record_before(barrier - near)
            if (allocated(error)) exit
            passed = passed + 1
            since = breaks(passed)
            call start_anew(breaks(passed), .true.)
            if (size(contacts%rest) > 0 .and. .not. allocated(error)) call look_at_jump(breaks(passed))
         else if (cut) then
            call record_before(t + near)
            if (allocated(error)) exit
            if (.not. turns) call start_anew(t, .false.)
         end if
         if (turns .and. .not. allocated(error)) call turn_switch(max(t, integrator%t_before))
         if (allocated(error)) exit
         if (t >= contacts%hold - near .and. .not. turns) call note_rest(contacts, events, scene, t + near, integrator, recorder, &
            & sample, outcome, error)
         if (allocated(error)) exit
         if (present(guard)) call wait_for_inputs()
         if (.not. (waiting .or. allocated(error))) call end_pass()
         if (allocated(error)) exit
         call progress%update(t)
         if (present(guard) .and. .not. allocated(error)) call look_at_guard()
      end do
      if (present(guard) .and. .not. allocated(error)) then
         if (guard%asks_at_end()) call write_checkpoint(.false.)
      end if
      outcome%reached = t
      call tell_kinks(pieces, scene%system, outcome)
      if (.not. allocated(error)) call look_at_end(scene, integrator, sample, outcome)
      if (.not. allocated(error)) call tell_errors(added, scene%system, crossings, dynamics, watch, integrator%tolerance, t, &
         & outcome)
      if (.not. allocated(error)) call warn_of_vibrations()

   contains

      !> Makes room for all that looks at laws and curves that act, at the state of the sample.
      subroutine watch_laws()
         real(wp) :: duration
         duration = dynamics%end - dynamics%start
         call new_crossings(crossings, scene%system, dynamics%start, duration, integrator%tolerance)
         if (size(crossings%loads) > 0) call begin_crossings(crossings, scene%system, scene%work, t, sample%q, sample%v, &
            & integrator%work_at_start)
         call start_added(added, scene%system, crossings, t, sample%q, sample%v)
         call new_curve_watch(curves, scene%system, duration, integrator%tolerance)
         if (size(curves%joints) > 0) call begin_curves(curves, scene%system, scene%work, t, sample%q, sample%v, &
            & integrator%work_at_start)
         call new_pieces(pieces, scene%system, dynamics%start, duration)
         if (size(pieces%paths) > 0) call begin_pieces(pieces, scene%system, scene%work, t, sample%q, sample%v)
      end subroutine watch_laws

      !> Bounds the steps of a companion where those of its run were bound.
      subroutine keep_pace()
         integrator%maximum_step = pace%limit(integrator%t)
         if (dynamics%maximum_step > 0.0_wp) integrator%maximum_step = min(integrator%maximum_step, dynamics%maximum_step)
      end subroutine keep_pace

      !> Warns of vibrations that are not followed, or kept up, and of those that the motion no longer shows, though they bind
      !> ADAMS.
      subroutine warn_of_vibrations()
         logical :: is_adams
         is_adams = .false.
         select type (integrator)
         type is (adams_type)
            is_adams = .true.
         end select
         text = springs%warning(scene%system)
         if (text /= '') call warn(outcome, text)
         outcome%unfollowed = unfollowed_warning(unfollowed, scene%system, integrator%ringing, is_adams, dynamics)
         text = ''
         if (.not. shows_vibrations(unfollowed, integrator%ringing)) text = stiffness_warning(stiffening, &
            & scene%system%model%units%time)
         if (text /= '') call warn(outcome, text)
      end subroutine warn_of_vibrations

      !> Says at what constraints without a grip a step has failed, if that is why: there it does not matter how short it is.
      subroutine name_weak()
         character(:), allocatable :: names
         if (index(error%message, 'shrunk to nothing') == 0 .or. index(error%message, 'cannot be kept') > 0) return
         call integrator%interpolate(integrator%t, sample%q, sample%v, sample%w)
         call integrator%complete(scene%system, scene%work, integrator%t, sample%q, sample%v)
         call find_weak(scene%system, scene%work, integrator%t, sample%q, names)
         if (names /= '') error%message = error%message//'. There '//names//' lose their grip on the motion: branches of it'// &
            & ' meet, which ADAMS and RADAU may pass, or a driver moves what joints stop at a dead centre'
      end subroutine name_weak

      !> Whether the last step passes something of a curve that its ends do not show; then it must end earlier.
      logical function crosses_unseen() result(unseen)
         unseen = .false.
         if (.not. dynamics%fixed_step > 0.0_wp) call find_hidden(curves, scene%system, scene%work, integrator, unseen, crossings%t)
         if (.not. unseen .and. size(pieces%paths) > 0) call look_at_pieces(unseen)
         if (size(crossings%loads) == 0 .and. t >= crossings%hold - near) crossings%hold = huge(t)
         if (.not. unseen) return
         crossings%found = found_nothing
         crossings%quarters(0)%t = curves%t
         crossings%q = curves%q
         crossings%v = curves%v
         crossings%w = curves%w
      end function crosses_unseen

      !> Whether the last step has to be done again for the formulas of curves: it has passed one that was not known; or the
      !> integrator keeps its promise at the ends of its steps, and a point leaves its piece within.
      subroutine look_at_pieces(again)
         logical, intent(inout) :: again
         call integrator%interpolate(t, sample%q, sample%v, sample%w)
         call integrator%complete(scene%system, scene%work, t, sample%q, sample%v)
         crossings%t = t
         again = look_ahead(pieces, scene%system, scene%work, t, sample%q, sample%v)
         if (again) return
         call find_end(pieces, scene%system, scene%work, integrator)
         again = integrator%ends_on_samples .and. pieces%t < t - near
         if (again) crossings%t = pieces%t
      end subroutine look_at_pieces

      !> Cuts the last step where a point has reached the end of its piece of a curve.
      subroutine meet_end()
         if (pieces%t > t) return
         crossings%hold = huge(t)
         cut = .true.
         t = pieces%t
         crossings%found = found_nothing
      end subroutine meet_end

      !> Does the last step again, up to what was found in it, or as near to that as a step can end.
      subroutine do_again()
         crossings%hold = max(crossings%t, crossings%quarters(0)%t + near)
         crossings%held = crossings%found
         integrator%work_at_start = crossings%w
         integrator%statistics%steps = integrator%statistics%steps - 1
         integrator%statistics%rejected = integrator%statistics%rejected + 1
         call integrator%start(scene%system, scene%work, crossings%quarters(0)%t, dynamics%end - dynamics%start, crossings%q, &
            & crossings%v, error)
      end subroutine do_again

      !> Shortens a first step that goes beyond a bend: a law of the motion that is zero at both ends shows itself between them
      !> only.
      subroutine begin_shorter()
         associate (begin => crossings%quarters(0)%t)
            if (crossings%t - begin <= first_part*(t - begin) .or. crossings%t >= t - near) return
            crossings%t = begin + first_part*(crossings%t - begin)
            crossings%found = found_nothing
            crossings%again = .true.
         end associate
      end subroutine begin_shorter

      !> Cuts the last step where something was found. An integrator whose promise holds at the ends of its steps ends one there,
      !> and needs no start at a bend.
      subroutine meet_crossing()
         ! By round-off of its length a step may end next to where it is held
         if (t >= crossings%hold - near .and. crossings%found == found_nothing) then
            crossings%found = crossings%held
            crossings%t = t
         end if
         if (t >= crossings%hold - near) crossings%hold = huge(t)
         cut = crossings%found /= found_nothing .and. .not. integrator%ends_on_samples
         ! Where a step is cut before its end was to be held, nothing is known of what follows
         if (cut) crossings%hold = huge(t)
         if (cut) t = crossings%t
         if (.not. integrator%ends_on_samples) return
         cut = crossings%found == found_jump
         if (crossings%found == found_bend) crossings%steps(crossings%which) = 0
      end subroutine meet_crossing

      !> What is left of a pass of the loop behind its step: samples of controls, samples of the run, another integrator.
      subroutine end_pass()
         if (sampled .and. t >= next_instant - near) call pass_samples()
         if (allocated(error)) return
         call record_before(t + near)
         if (changes .and. .not. allocated(error)) call change_integrator()
      end subroutine end_pass

      !> Leaves the end of a pass for later where inputs from outside are taken there, and the run pauses before that.
      subroutine wait_for_inputs()
         waiting = sampled .and. t >= next_instant - near .and. guard%pauses(t + near)
         if (waiting) waiting = has_inputs(scene%system)
         if (.not. waiting) return
         call record_before(t - near)
         if (.not. allocated(error)) call show_before(t + near)
      end subroutine wait_for_inputs

      !> Begins where a run has paused: ends its last pass, unless it pauses there again.
      subroutine go_on_from_pause()
         call show_before(integrator%t + near)
         if (allocated(error)) return
         if (guard%paused) then
            call look_at_guard()
         else if (waiting) then
            t = integrator%t
            next_instant = t
            waiting = .false.
            call end_pass()
         end if
      end subroutine go_on_from_pause

      !> Takes the samples of controls at the end of the last step. Where an output changes the integrator goes on from there with
      !> other loads.
      subroutine pass_samples()
         logical :: changed
         call record_before(t - near)
         if (allocated(error)) return
         call integrator%interpolate(t, sample%q, sample%v, sample%w)
         call integrator%complete(scene%system, scene%work, t, sample%q, sample%v)
         call take_samples(scene%system, scene%work, t, near, sample%q, sample%v, changed, error)
         if (allocated(error)) return
         next_instant = next_sample(scene%system, t, near)
         integrator%work_at_start = sample%w
         call integrator%resume(scene%system, scene%work, dynamics%end - dynamics%start, sample%q, sample%v, error)
         if (allocated(error)) return
         since = t
         if (.not. changed) return
         call begin_added(added, t, sample%q, sample%v)
         if (size(crossings%loads) > 0) call begin_crossings(crossings, scene%system, scene%work, t, sample%q, sample%v, sample%w)
         if (size(curves%joints) > 0) call begin_curves(curves, scene%system, scene%work, t, sample%q, sample%v, sample%w)
         if (size(events%counts) > 0) call begin_events(events, scene%system, scene%work, t, sample%q, sample%v, sample%w)
      end subroutine pass_samples

      !> Starts anew at a time, where something changes abruptly.
      subroutine start_anew(time, of_time)
         real(wp), intent(in) :: time
         !> Whether a law of time changes there, which a driver or joint may follow
         logical, intent(in) :: of_time
         logical :: at_end
         if (cut .and. (crossings%found == found_bend .or. crossings%found == found_jump)) then
            crossings%t = time
            call count_crossing(crossings, scene%system, error)
            if (allocated(error)) return
         end if
         at_end = .false.
         if (size(pieces%paths) > 0) at_end = pieces%t <= t
         if (at_end .and. integrator%ends_on_samples) call look_at_slip()
         if (at_end) call pass_end(pieces, scene%system, time, error)
         if (allocated(error)) return
         call pass_break(scene, time, t, of_time, of_time .or. at_end .or. crossings%found == found_jump, watch%speed, integrator, &
            & sample, outcome, error)
         if (.not. allocated(error) .and. at_end) call count_kink(pieces, scene%system, scene%work, time, sample%q, sample%v, &
            & integrator%work_at_start - sample%w, error)
         if (allocated(error)) return
         call start_watch(watch, time, sample%v)
         call begin_added(added, time, sample%q, sample%v)
         call start_turning(turning, scene%system, time, sample%q, sample%v, integrator%ends_on_samples)
         call follow_turns(time)
         if (size(crossings%loads) > 0) call begin_crossings(crossings, scene%system, scene%work, time, sample%q, sample%v, &
            & integrator%work_at_start)
         if (size(curves%joints) > 0) call begin_curves(curves, scene%system, scene%work, time, sample%q, sample%v, &
            & integrator%work_at_start)
         if (size(events%counts) > 0) call begin_events(events, scene%system, scene%work, time, sample%q, sample%v, &
            & integrator%work_at_start)
      end subroutine start_anew

      !> Turns a switch at a time that the integrator has reached, or has just been started at, and starts it anew.
      subroutine turn_switch(time)
         real(wp), intent(in) :: time
         logical :: renewed
         if (integrator%t > integrator%t_before) then
            call integrator%interpolate(time, sample%q, sample%v, sample%w)
            call integrator%complete(scene%system, scene%work, time, sample%q, sample%v)
         else
            sample%w = integrator%work_at_start
         end if
         t = time
         call tell_kinks(pieces, scene%system, outcome)
         call tell_passages(added, scene%system, crossings, dynamics, outcome)
         call release_pieces(scene%system)
         if (looks_at_jumps(outcome%indicators)) call observe_state(scene, t, before_break, sample, outcome)
         call turn_states(contacts, events, scene, t, integrator, recorder, sample, renewed, outcome, error)
         if (allocated(error)) return
         call forget_system(sample)
         if (looks_at_jumps(outcome%indicators)) call observe_state(scene, t, behind_break, sample, outcome)
         call go_on_from(renewed)
         if (allocated(error)) return
         call watch_laws()
         call start_watch(watch, t, sample%v)
         call start_turning(turning, scene%system, t, sample%q, sample%v, integrator%ends_on_samples)
         call follow_turns(t)
         call begin_events(events, scene%system, scene%work, t, sample%q, sample%v, integrator%work_at_start)
         call count_turn(events, scene%system, t, error)
      end subroutine turn_switch

      !> Starts the integrator anew at the state of the sample.
      subroutine go_on_from(renewed)
         !> Whether the constraints may be others than before
         logical, intent(in) :: renewed
         call forget_system(sample)
         integrator%work_at_start = sample%w
         if (renewed) then
            call replace_integrator(scene, dynamics, costs, t, sample, integrator, error)
         else
            call integrator%start(scene%system, scene%work, t, dynamics%end - dynamics%start, sample%q, sample%v, error)
         end if
         call renew_efforts(recorder%efforts, scene%system)
      end subroutine go_on_from

      !> Lets contacts that are closed at the start strike or rest.
      subroutine begin_contacts()
         logical :: renewed
         call start_events(events, scene%system, scene%work, t, scene%q, scene%v, integrator%tolerance)
         call check_gaps(scene, t, integrator%tolerance, error)
         if (allocated(error)) return
         call turn_states(contacts, events, scene, t, integrator, recorder, sample, renewed, outcome, error)
         if (.not. allocated(error)) call go_on_from(renewed)
         scene%q = sample%q
         scene%v = sample%v
      end subroutine begin_contacts

      !> Looks whether a contact that rests would pull within the last step, which is cut there, or done again up to there.
      subroutine look_at_pushes(again)
         logical, intent(out) :: again
         call find_opening(contacts, scene, integrator, near, t, again, error)
         if (again .and. .not. allocated(error)) call step_again()
      end subroutine look_at_pushes

      !> Lets contacts open that would pull right behind a jump of a law of time.
      subroutine look_at_jump(time)
         real(wp), intent(in) :: time
         call find_jump(contacts, scene, time, sample, error)
         if (allocated(error) .or. .not. any(contacts%opens)) return
         events%turning = .false.
         call turn_switch(time)
      end subroutine look_at_jump

      !> Does the last step again, up to an event within it.
      subroutine step_again()
         integrator%work_at_start = events%search%w
         integrator%statistics%steps = integrator%statistics%steps - 1
         integrator%statistics%rejected = integrator%statistics%rejected + 1
         call integrator%start(scene%system, scene%work, events%search%t, dynamics%end - dynamics%start, events%search%q, &
            & events%search%v, error)
      end subroutine step_again

      !> Records the samples up to the event that ends the motion; the last is there.
      subroutine record_end()
         call record_before(t)
         if (allocated(error) .or. sample_time(dynamics, sample%next - 1) >= t) return
         call integrator%interpolate(t, sample%q, sample%v, sample%w)
         call integrator%complete(scene%system, scene%work, t, sample%q, sample%v)
         sample%anyhow = .true.
         call record(scene, t, t, integrator, recorder, sample, history, outcome, error)
         sample%anyhow = .false.
      end subroutine record_end

      !> Looks how far the velocities have left the piece of a curve that ends: what they have too much there is no impact.
      subroutine look_at_slip()
         call integrator%interpolate(t, sample%q, sample%v, sample%w)
         call integrator%complete(scene%system, scene%work, t, sample%q, sample%v)
         call place_constraints(scene%system, scene%work, t, sample%q)
         call check_residuals(scene%system, scene%work, t, .true., sample%v, outcome)
      end subroutine look_at_slip

      !> Carries followed angles on to the state at hand, those of the channels and those that joints and loads depend on.
      subroutine follow_turns(t)
         real(wp), intent(in) :: t
         call follow_motion(recorder%turns, scene%system, scene%work%kinematics, t, sample%q, sample%v)
         if (size(scene%work%kinematics%angles) == 0) return
         call place_frames(scene%system%model, scene%system%layout, t, sample%q, scene%work%kinematics)
         call move_frames(scene%system%model, scene%system%layout, sample%q, sample%v, scene%work%kinematics)
         call settle_angles(scene%work%kinematics, .not. integrator%ends_on_samples)
      end subroutine follow_turns

      !> Goes on with another integrator from where this one is.
      subroutine change_integrator()
         call integrator%interpolate(integrator%t, sample%q, sample%v, sample%w)
         call integrator%complete(scene%system, scene%work, integrator%t, sample%q, sample%v)
         call replace_integrator(scene, dynamics, costs, integrator%t, sample, integrator, error)
      end subroutine change_integrator

      !> Writes a checkpoint if it is time, and ends the run if that is asked for.
      subroutine look_at_guard()
         logical :: save, ends
         call guard%asks(save, ends)
         if (save .and. sample%next <= dynamics%outputs) call write_checkpoint(ends)
      end subroutine look_at_guard

      !> Writes a checkpoint, and ends the run if that is asked for.
      subroutine write_checkpoint(ends)
         logical, intent(in) :: ends
         real(wp) :: seconds(2)
         seconds = [outcome%wall, outcome%cpu]
         call add_seconds(tick, cpu, outcome)
         call guard%snapshot%begin(.false.)
         call exchange(guard%snapshot)
         outcome%wall = seconds(1)
         outcome%cpu = seconds(2)
         guard%from = integrator%t_before
         call guard%write(history, int(outcome%samples), integrator%t, error)
         if (ends .and. .not. allocated(error)) call guard%interrupt(integrator%t, error)
      end subroutine write_checkpoint

      !> Goes back to where a checkpoint was written.
      subroutine restore()
         call guard%snapshot%begin(.true.)
         call exchange(guard%snapshot)
         if (allocated(guard%snapshot%missing)) call raise(error, guard%path//" does not fit the run: '"// &
            & guard%snapshot%missing//"' is not what it should be", status_deck)
      end subroutine restore

      !> Saves or restores all that the run remembers.
      subroutine exchange(snapshot)
         type(snapshot_type), intent(inout) :: snapshot
         logical :: renewed
         call snapshot%exchange('passed', passed)
         call snapshot%exchange('changes', changes)
         call snapshot%exchange('waiting', waiting)
         call sample%exchange(snapshot)
         call exchange_switches(scene%system, scene%work, snapshot, renewed)
         call stiffening%exchange(snapshot)
         if (unfollowed%watched) call unfollowed%exchange(snapshot)
         call springs%exchange(snapshot)
         call costs%exchange(snapshot)
         if (snapshot%restoring .and. (allocated(costs%now) .or. renewed)) call replace_integrator(scene, dynamics, costs, &
            & dynamics%start, sample, integrator, error)
         if (allocated(error)) return
         if (renewed) call watch_laws()
         if (renewed) call renew_efforts(recorder%efforts, scene%system)
         call integrator%exchange(snapshot, scene%system)
         call scene%work%exchange(snapshot)
         call recorder%exchange(snapshot)
         call history%exchange(snapshot)
         call watch%exchange(snapshot)
         call turning%exchange(snapshot)
         call crossings%exchange(snapshot)
         call added%exchange(snapshot)
         call events%exchange(snapshot)
         call contacts%exchange(snapshot)
         if (snapshot%restoring .and. size(crossings%loads) > 0) call resume_crossings(crossings, scene%system, scene%work, &
            & integrator%t)
         call pieces%exchange(snapshot, scene%system)
         call outcome%exchange(snapshot)
         if (.not. snapshot%restoring .or. size(curves%joints) + size(events%counts) == 0) return
         call integrator%interpolate(integrator%t, sample%q, sample%v, sample%w)
         call integrator%complete(scene%system, scene%work, integrator%t, sample%q, sample%v)
         if (size(curves%joints) > 0) call begin_curves(curves, scene%system, scene%work, integrator%t, sample%q, sample%v, &
            & sample%w)
         if (size(events%counts) > 0) call begin_events(events, scene%system, scene%work, integrator%t, sample%q, sample%v, &
            & sample%w)
      end subroutine exchange

      !> Records the samples up to a time that the integrator has reached. At a break they are those that follow it.
      subroutine record_before(t)
         real(wp), intent(in) :: t
         !> Of a sample, on its side of a break that is within round-off
         real(wp) :: at
         if (sample%next < dynamics%outputs .and. .not. sample%local) then
            if (sample_time(dynamics, sample%next + 1) <= t) call look_between(scene, integrator, recorder, sample, outcome)
         end if
         do while (sample%next <= dynamics%outputs .and. sample_time(dynamics, sample%next) <= t)
            at = min(max(sample_time(dynamics, sample%next), since), last)
            ! The last sample is a state that others may begin with
            if (recorder%needs_velocities .or. sample%next == dynamics%outputs) then
               call integrator%interpolate(at, sample%q, sample%v, sample%w)
            else
               call integrator%interpolate_place(at, sample%q, sample%v, sample%w)
            end if
            if (.not. sample%local .or. sample%next == dynamics%outputs) call integrator%complete(scene%system, scene%work, at, &
               & sample%q, sample%v)
            call record(scene, at, sample_time(dynamics, sample%next), integrator, recorder, sample, history, outcome, error)
            if (sample%ungripped .and. .not. allocated(error)) call record_aside(at)
            if (allocated(error)) exit
            call springs%look(scene%system, integrator%ringing, sample%a)
            call watch_channels(unfollowed, scene, integrator%ringing, at, dynamics, recorder, sample)
            sample%next = sample%next + 1
         end do
         if (present(guard) .and. .not. allocated(error)) call show_before(t)
      end subroutine record_before

      !> Shows the state at which the run pauses, once the integrator has reached it. Nothing of it is left in the run: what a
      !> sample changes is put back.
      subroutine show_before(t)
         real(wp), intent(in) :: t
         type(snapshot_type) :: before
         type(memory_type) :: shown
         real(wp) :: at
         if (guard%paused .or. .not. guard%pauses(t)) return
         at = min(max(guard%until, since), last)
         call before%begin(.false.)
         call exchange_sampling(before)
         call shown%start(size(scene%system%model%channels), 1, huge(1.0_wp))
         call integrator%interpolate(at, sample%q, sample%v, sample%w)
         call integrator%complete(scene%system, scene%work, at, sample%q, sample%v)
         sample%anyhow = .true.
         call record(scene, at, guard%until, integrator, recorder, sample, shown, outcome, error)
         sample%anyhow = .false.
         if (.not. allocated(error)) call guard%show(shown%values(:, 1), sample%q, sample%v)
         call before%begin(.true.)
         call exchange_sampling(before)
      end subroutine show_before

      !> Saves or restores what a sample changes.
      subroutine exchange_sampling(snapshot)
         type(snapshot_type), intent(inout) :: snapshot
         call sample%exchange(snapshot)
         call scene%work%exchange(snapshot)
         call recorder%exchange(snapshot)
         call outcome%exchange(snapshot)
      end subroutine exchange_sampling

      !> Records a sample at a singular position by the state a little behind it, or before it.
      subroutine record_aside(at)
         real(wp), intent(in) :: at
         !> Part of the time between samples
         real(wp), parameter :: aside = 1.0e-4_wp
         real(wp) :: off
         off = aside*(dynamics%end - dynamics%start)/dynamics%outputs
         if (at + off > integrator%t) off = -off
         call integrator%interpolate(at + off, sample%q, sample%v, sample%w)
         call integrator%complete(scene%system, scene%work, at + off, sample%q, sample%v)
         sample%anyhow = .true.
         call record(scene, at + off, sample_time(dynamics, sample%next), integrator, recorder, sample, history, outcome, error)
         sample%anyhow = .false.
         sample%aside = sample%aside + 1
         if (sample%aside == 1) call warn(outcome, 'at t = '//as_text(at, 6)//' '//sample%weakest//' lose their grip on the'// &
            & ' motion: forces and accelerations have no value at such a singular position; those of that sample, and of the'// &
            & ' like, are taken '//as_text(abs(off), 1)//' '//scene%system%model%units%time// &
            & ' from it, and may be far off; other OUTPUTS miss it')
      end subroutine record_aside

   end subroutine advance

   !> Adds the wall and CPU seconds since some moment.
   subroutine add_seconds(tick, cpu, outcome)
      !> Clock and CPU clock then [ticks], [s]
      integer(long), intent(in) :: tick
      real(wp), intent(in) :: cpu
      type(outcome_type), intent(inout) :: outcome
      real(wp) :: now
      call cpu_time(now)
      outcome%wall = outcome%wall + seconds_since(tick)
      outcome%cpu = outcome%cpu + now - cpu
   end subroutine add_seconds

   !> Whether a run begins with a checkpoint.
   pure logical function restarts(guard)
      class(interruption_type), intent(in), optional :: guard
      restarts = .false.
      if (present(guard)) restarts = guard%restarting
   end function restarts

end module limber_analysis_dynamic_analysis
