!> Sequence of the analyses of a deck. Floor: analysis.
module limber_analysis_analysis_steps
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise, status_deck, status_interrupted
   use limber_base_signals, only: let_signals_end
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text, newline
   use limber_analysis_run_report, only: energy_warning
   use limber_scene_damping_check, only: changed_damping
   use limber_analysis_chosen_integrator, only: new_integrator
   use limber_analysis_dynamic_analysis, only: run_dynamics
   use limber_analysis_fresh_start, only: meet_drivers
   use limber_scene_analysis_gaps, only: pass_gap
   use limber_scene_interruption, only: interruption_type
   use limber_scene_outcome, only: outcome_type, all_warnings
   use limber_monitor_indicators, only: join_indicators
   use limber_monitor_indicator_start, only: start_indicators
   use limber_analysis_kinematic_analysis, only: run_kinematics
   use limber_analysis_modal_analysis, only: run_modes
   use limber_scene_first_scene, only: settle_integrator
   use limber_scene_scene, only: scene_type
   use limber_analysis_small_motions, only: linearise_state, lowest_vibrations
   use limber_scene_speed_jumps, only: begin_behind, refused_speeds
   use limber_analysis_static_analysis, only: run_statics
   use limber_integrator_integrator, only: integrator_type
   use limber_integrator_statistics, only: step_statistics_type
   use limber_model_analyses, only: title
   use limber_model_model, only: model_type, dynamics_type, analysis_step_type, step_kinematics, step_inverse, step_statics, &
      & step_modes, &
      & step_dynamics, event_stop, stop_unstable, velocities_none, velocities_of_deck
   use limber_output_channel_values, only: recorder_type, new_recorder
   use limber_output_internal_forces, only: join_envelopes
   use limber_output_progress, only: progress_type
   use limber_output_sample_sink, only: sink_type
   use limber_multibody_assembly, only: assemble, first_guess, turn_rates
   use limber_multibody_control_states, only: keep_states
   use limber_multibody_equations_of_motion, only: linearise, worst_constraint
   use limber_multibody_equilibrium, only: equilibrium_type, new_equilibrium
   use limber_multibody_modal_damping, only: any_modal
   use limber_multibody_small_vibrations, only: vibrations_type, no_damping
   use limber_multibody_switching, only: exchange_switches
   implicit none
   private
   public :: run_steps, passed_type

   !> What the analyses that have run were
   type :: passed_type
      !> Samples of each, their first and last times (steps)
      integer, allocatable :: samples(:)
      real(wp), allocatable :: start(:), end(:)
      !> Number of them
      integer :: count = 0
   contains
      procedure :: exchange => exchange_passed
   end type passed_type

contains

   !> Runs all analyses of a deck.
   subroutine run_steps(scene, path, quiet, history, passed, outcome, statistics, report, error, guard)
      type(scene_type), intent(inout) :: scene
      !> Of the deck, for the progress
      character(*), intent(in) :: path
      logical, intent(in) :: quiet
      class(sink_type), intent(inout) :: history
      type(passed_type), intent(out) :: passed
      !> Of all together: sums, and the worst
      type(outcome_type), intent(out) :: outcome
      type(step_statistics_type), intent(inout) :: statistics
      !> Some lines for each analysis
      character(:), allocatable, intent(out) :: report
      !> Which analysis could not finish, and why
      type(error_type), allocatable, intent(out) :: error
      !> Lets the run be interrupted and go on
      class(interruption_type), intent(inout), optional :: guard
      type(outcome_type) :: part
      type(progress_type) :: progress
      character(:), allocatable :: lines
      integer :: i, steps, first
      steps = size(scene%system%model%steps)
      allocate (passed%samples(steps), passed%start(steps), passed%end(steps))
      passed%samples = 0
      passed%start = 0.0_wp
      passed%end = 0.0_wp
      report = ''
      i = 1
      if (present(guard)) call begin_guarded(i)
      if (allocated(error)) return
      first = i
      do i = first, steps
         associate (step => scene%system%model%steps(i))
            if (present(guard) .and. i > first) call look_at_guard(i)
            if (i > 1) call shift_step(scene%system%model%steps(i - 1:i), passed%end(i - 1))
            if (.not. allocated(error)) call enter_step(scene, i, error)
            if (allocated(error)) exit
            if (.not. quiet) call progress%start(step%dynamics%start, step%dynamics%end, path)
            ! A motion in time is asked by its guard
            if (present(guard)) history%heeds_signals = step%kind /= step_dynamics
            call run_step(scene, i, history, progress, part, statistics, lines, error, guard)
            if (present(guard) .and. allocated(error)) call interrupt_step(step%kind)
            if (.not. quiet) call progress%finish()
            passed%count = i
            passed%samples(i) = int(part%samples)
            passed%start(i) = step%dynamics%start
            passed%end(i) = part%reached
            call add_outcome(part, i == 1, outcome)
            report = report//newline//'   '//title(step)//': t = '//as_text(step%dynamics%start, 6)//' to '// &
               & as_text(part%reached, 6)//' '//scene%system%model%units%time//', '//as_text(part%samples)//' samples'//lines
            if (allocated(error)) exit
            if (part%ended == event_stop) then
               if (i < steps) report = report//newline//'   an event has ended the run; the analyses behind it are not run'
               exit
            end if
            if (step%kind == step_statics .and. step%instability == stop_unstable .and. lines /= '') then
               if (i < steps) report = report//newline//'   the analyses behind it are not run'
               exit
            end if
         end associate
      end do
      if (allocated(error)) error%message = title(scene%system%model%steps(i))//': '//error%message

   contains

      !> Begins with the first analysis, or with the one that was interrupted.
      subroutine begin_guarded(i)
         !> Index of that analysis
         integer, intent(out) :: i
         i = 1
         call guard%snapshot%begin(guard%restarting)
         call exchange(guard%snapshot)
         call guard%snapshot%mark()
         if (allocated(guard%snapshot%missing)) then
            call raise(error, guard%path//" does not fit the run: '"//guard%snapshot%missing//"' is not what it should be", &
               & status_deck)
            return
         end if
         i = passed%count + 1
         guard%before = sum(passed%samples)
         ! Within an analysis there is more behind the mark
         if (guard%restarting) guard%restarting = size(guard%snapshot%integers) > guard%snapshot%integer_count
      end subroutine begin_guarded

      !> Keeps all that is known before an analysis, writes it to a checkpoint if it is time, and ends the run if that is asked for.
      subroutine look_at_guard(i)
         integer, intent(in) :: i
         logical :: save, ends
         guard%restarting = .false.
         guard%before = sum(passed%samples)
         call guard%snapshot%mark(forget=.true.)
         call guard%snapshot%begin(.false.)
         call exchange(guard%snapshot)
         call guard%snapshot%mark()
         call guard%asks_between(passed%end(i - 1), save, ends)
         if (save) call guard%write(history, 0, scene%system%model%steps(i)%dynamics%start, error)
         if (ends .and. .not. allocated(error)) call guard%interrupt(scene%system%model%steps(i)%dynamics%start, error)
      end subroutine look_at_guard

      !> Of an analysis that has no checkpoints of its own and was interrupted: writes that of its start.
      subroutine interrupt_step(kind)
         integer, intent(in) :: kind
         if (error%status /= status_interrupted .or. kind == step_dynamics) return
         deallocate (error)
         call guard%write(history, 0, scene%system%model%steps(i)%dynamics%start, error)
         if (.not. allocated(error)) call guard%interrupt(part%reached, error, is_earlier=.true.)
      end subroutine interrupt_step

      !> Saves or restores all that the next analysis begins with, and what is reported of those before it.
      subroutine exchange(snapshot)
         type(snapshot_type), intent(inout) :: snapshot
         logical :: renewed
         call passed%exchange(snapshot)
         call scene%last%exchange(snapshot)
         call exchange_switches(scene%system, scene%work, snapshot, renewed)
         call scene%work%exchange(snapshot)
         call history%exchange(snapshot)
         call exchange_outcomes(scene, outcome, snapshot)
         call statistics%exchange(snapshot)
         call snapshot%keep('warnings', scene%warnings)
         call snapshot%keep('report', report)
      end subroutine exchange

   end subroutine run_steps

   !> Lets an analysis begin where an event has ended the one before. A period keeps its length.
   pure subroutine shift_step(steps, time)
      !> The one before, and this one
      type(analysis_step_type), intent(inout) :: steps(2)
      !> Time that the one before has reached
      real(wp), intent(in) :: time
      !> Last digits of its end, right before which a run ends where a law changes there
      integer, parameter :: digits = 64
      associate (before => steps(1)%dynamics, own => steps(2)%dynamics)
         if (.not. steps(2)%follows .or. time >= before%end - digits*spacing(abs(before%end))) return
         if (steps(2)%kind == step_statics .or. steps(2)%kind == step_modes) own%end = time + own%end - own%start
         own%start = time
      end associate
   end subroutine shift_step

   !> Saves or restores which analyses have run.
   subroutine exchange_passed(self, snapshot)
      class(passed_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%exchange('samples', self%samples)
      call snapshot%exchange('start', self%start)
      call snapshot%exchange('end', self%end)
      call snapshot%exchange('count', self%count)
   end subroutine exchange_passed

   !> Saves or restores the outcome of the analyses that have run.
   subroutine exchange_outcomes(scene, outcome, snapshot)
      type(scene_type), intent(in) :: scene
      type(outcome_type), intent(inout) :: outcome
      type(snapshot_type), intent(inout) :: snapshot
      type(recorder_type), allocatable :: recorder
      logical :: has(2)
      integer :: i
      has = [allocated(outcome%indicators), allocated(outcome%efforts)]
      do i = 1, 2
         call snapshot%exchange('has', has(i))
      end do
      if (snapshot%restoring .and. has(1)) then
         allocate (outcome%indicators)
         call start_indicators(outcome%indicators, scene%system)
      end if
      if (snapshot%restoring .and. has(2)) then
         allocate (recorder, source=new_recorder(scene%system, scene%q))
         call move_alloc(recorder%efforts, outcome%efforts)
      end if
      call snapshot%exchange('reached', outcome%reached)
      call outcome%exchange(snapshot)
      if (.not. has(2)) return
      do i = 1, size(outcome%efforts)
         call snapshot%keep('extremes', outcome%efforts(i)%extremes)
      end do
   end subroutine exchange_outcomes

   !> Runs one analysis.
   subroutine run_step(scene, i, history, progress, part, statistics, lines, error, guard)
      type(scene_type), intent(inout) :: scene
      integer, intent(in) :: i
      class(sink_type), intent(inout) :: history
      type(progress_type), intent(inout) :: progress
      type(outcome_type), intent(out) :: part
      type(step_statistics_type), intent(inout) :: statistics
      character(:), allocatable, intent(out) :: lines
      type(error_type), allocatable, intent(out) :: error
      class(interruption_type), intent(inout), optional :: guard
      !> Rates of a scene whose modes are found within a second
      integer, parameter :: quick = 400
      class(integrator_type), allocatable :: integrator
      type(analysis_step_type) :: step
      logical :: is_secured
      step = scene%system%model%steps(i)
      lines = ''
      select case (step%kind)
      case (step_kinematics, step_inverse)
         call run_kinematics(scene, step, history, progress, part, lines, error)
      case (step_statics)
         call run_statics(scene, step, history, progress, part, lines, error)
      case (step_modes)
         is_secured = .false.
         if (present(guard) .and. scene%system%layout%nw > quick) then
            call guard%write(history, 0, step%dynamics%start, error)
            if (allocated(error)) return
            is_secured = guard%trouble == ''
         end if
         call run_modes(scene, step, history, part, lines, error, is_secured)
         call let_signals_end(.false.)
      case (step_dynamics)
         if (scene%system%layout%nw <= quick) call weigh_damping(scene, step)
         call new_integrator(scene%system%model%dynamics, integrator)
         call run_dynamics(scene, integrator, history, progress, part, error, guard)
         lines = newline//'      '//scene%system%model%dynamics%integrator//', '//as_text(integrator%statistics%steps)// &
            & ' steps ('//as_text(integrator%statistics%rejected)//' rejected), energy balance '//as_text(part%imbalance, 2)// &
            & ' of at most '//as_text(part%largest_energy, 3)//chosen(scene%system%model%dynamics)
         scene%warnings = scene%warnings//energy_warning(part, scene%system%model%dynamics)
         call add_statistics(integrator%statistics, statistics)
      end select
      scene%warnings = scene%warnings//all_warnings(part)
   end subroutine run_step

   !> Damping by ratios is that of the first position without loads: behind a static analysis it may be another one.
   subroutine weigh_damping(scene, step)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      !> Modes that are looked at
      integer, parameter :: looked = 5
      type(equilibrium_type) :: balance
      type(vibrations_type) :: vibrations
      type(error_type), allocatable :: error
      logical :: balanced
      if (.not. scene%last%balanced .or. .not. any_modal(scene%system%model)) return
      call new_equilibrium(scene%system, balance)
      call linearise_state(scene, step, balance, balanced, error)
      if (allocated(error) .or. .not. balanced) return
      call lowest_vibrations(scene, balance, no_damping, looked, 0, vibrations, error)
      if (allocated(error)) return
      scene%warnings = scene%warnings//changed_damping(scene%system, balance%tangent, vibrations, &
         & scene%warnings, "the equilibrium before *DYNAMICS '"//step%name//"'")
   end subroutine weigh_damping

   !> A line that says why limber has chosen an integrator; empty if the deck has.
   pure function chosen(dynamics) result(text)
      type(dynamics_type), intent(in) :: dynamics
      character(:), allocatable :: text
      text = ''
      if (dynamics%reason /= '') text = newline//'      '//dynamics%integrator//', chosen: '//dynamics%reason
   end function chosen

   !> Makes the end of the analysis before the start of the next: its time, its velocities, the constraints satisfied.
   subroutine enter_step(scene, i, error)
      type(scene_type), intent(inout) :: scene
      !> Index of the next
      integer, intent(in) :: i
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: guess(:), before(:)
      real(wp) :: residual, rotation, jumps(size(scene%system%constraints))
      integer :: culprit
      logical :: follows
      !> Residual relative to the scales beyond which a scene is put together anew
      real(wp), parameter :: jump = 1.0e-6_wp
      if (i == 1) return
      associate (system => scene%system, step => scene%system%model%steps(i))
         scene%q = scene%last%q
         scene%v = scene%last%v
         scene%angle = scene%last%angle
         system%model%dynamics = step%dynamics
         ! Other analyses take up what they find, but not behind a gap of time in which drivers have gone on
         if (step%kind /= step_dynamics .and. .not. (size(scene%work%kinematics%drives) > 0 .and. &
            & abs(step%dynamics%start - system%model%steps(i - 1)%dynamics%end) > 0.0_wp)) return
         call pass_gap(scene, system%model%steps(i - 1)%dynamics%end, step%dynamics%start)
         rotation = scene%last%rotation
         if (step%kind == step_dynamics) scene%last%rotation = 0.0_wp
         allocate (guess(size(scene%q)))
         before = scene%v
         if (step%velocities == velocities_none) scene%v = 0.0_wp
         if (step%velocities == velocities_of_deck) then
            call first_guess(system, step%dynamics%start, guess, scene%v)
            call turn_rates(system, guess, scene%q, scene%v)
         end if
         call keep_states(system, before, scene%v)
         follows = is_motion_before(system%model, i)
         call begin_behind(system, scene%work, scene%q, follows, scene%begin, jumps, error)
         if (allocated(error)) return
         residual = 0.0_wp
         if (system%nc > 0) then
            call linearise(system, scene%work, scene%begin, scene%q, error)
            if (allocated(error)) return
            call worst_constraint(system, scene%work, culprit, residual)
            residual = residual/system%constraints(culprit)%item%scale
         end if
         if (residual > jump) then
            call assemble(system, scene%work, scene%begin, scene%q, scene%v, error, culprit)
         else if (step%kind == step_dynamics) then
            if (abs(rotation) > 0.0_wp) call refused_speeds(system, scene%work, scene%begin, scene%q, scene%v, rotation, jumps)
            call meet_drivers(scene, jumps > 0.0_wp, (follows .or. abs(rotation) > 0.0_wp) .and. &
               & step%velocities /= velocities_none .and. step%velocities /= velocities_of_deck, error)
         end if
         if (.not. allocated(error) .and. step%kind == step_dynamics) call settle_integrator(scene)
      end associate
   end subroutine enter_step

   !> Whether a motion has come to the very time at which an analysis starts, and no other analysis has changed its state since.
   pure logical function is_motion_before(model, i) result(follows)
      type(model_type), intent(in) :: model
      !> Index of the analysis
      integer, intent(in) :: i
      integer :: k
      follows = .false.
      do k = i - 1, 1, -1
         if (model%steps(k)%kind == step_modes) cycle
         follows = model%steps(k)%kind /= step_statics .and. .not. abs(model%steps(i)%dynamics%start &
            & - model%steps(k)%dynamics%end) > 0.0_wp
         return
      end do
   end function is_motion_before

   !> Adds the outcome of an analysis to that of all.
   subroutine add_outcome(part, is_first, outcome)
      type(outcome_type), intent(inout) :: part
      logical, intent(in) :: is_first
      type(outcome_type), intent(inout) :: outcome
      call join_envelopes(part%efforts, outcome%efforts)
      call join_indicators(part%indicators, outcome%indicators)
      outcome%reached = part%reached
      outcome%samples = outcome%samples + part%samples
      outcome%wall = outcome%wall + part%wall
      outcome%cpu = outcome%cpu + part%cpu
      outcome%position_residual = max(outcome%position_residual, part%position_residual)
      outcome%velocity_residual = max(outcome%velocity_residual, part%velocity_residual)
      if (is_first) outcome%first_energy = part%first_energy
      outcome%last_energy = part%last_energy
      outcome%work = outcome%work + part%work
      outcome%imbalance = max(outcome%imbalance, part%imbalance)
      outcome%largest_energy = max(outcome%largest_energy, part%largest_energy)
      call outcome%events%join(part%events)
   end subroutine add_outcome

   !> Adds the counts of an integrator to those of all.
   pure subroutine add_statistics(part, statistics)
      type(step_statistics_type), intent(in) :: part
      type(step_statistics_type), intent(inout) :: statistics
      statistics%steps = statistics%steps + part%steps
      statistics%rejected = statistics%rejected + part%rejected
      statistics%failed_projections = statistics%failed_projections + part%failed_projections
      statistics%evaluations = statistics%evaluations + part%evaluations
      statistics%jacobians = statistics%jacobians + part%jacobians
      statistics%factorisations = statistics%factorisations + part%factorisations
      statistics%highest_order = max(statistics%highest_order, part%highest_order)
      statistics%smallest_step = min(statistics%smallest_step, part%smallest_step)
      statistics%largest_step = max(statistics%largest_step, part%largest_step)
   end subroutine add_statistics

end module limber_analysis_analysis_steps
