!> *STATICS: equilibrium under growing loads. Loads grow increment by increment; each equilibrium has its stability. Where it turns
!> unstable the instant is found, and the scene goes on to a stable equilibrium, without a hint of where that is. Floor: analysis.
!> Source: doc/theory, eqs. (6.4)-(6.7), (6.15), (6.16).
module limber_analysis_static_analysis
   use limber_base_kinds, only: wp, long
   use limber_base_error, only: error_type, raise
   use limber_base_text, only: as_text
   use limber_analysis_static_branch, only: statics_type, load_scene, scale_loads, time_of, accept, try, try_start, &
      & fall_into_place, find_critical, loads_drive, tell, tell_of_leaving, tell_unstable, most_turn, stay_on, stand, &
      & place_text, flutter_text, judge_branch
   use limber_analysis_curve_path, only: new_paths, follow_paths, break_text
   use limber_monitor_function_checks, only: function_load_warning, function_state_warning
   use limber_monitor_indicator_start, only: start_indicators
   use limber_monitor_observation, only: observe
   use limber_scene_joint_check, only: check_joints
   use limber_scene_law_checks, only: check_law_energies
   use limber_scene_outcome, only: outcome_type, warn
   use limber_monitor_model_ranges, only: likely_cause
   use limber_scene_sampling, only: check_residuals
   use limber_scene_scene, only: scene_type, seconds_since
   use limber_analysis_static_aside, only: static_aside_type, aside_sample_type, start_static_aside, compare_sample, static_warning
   use limber_analysis_shape_aside, only: shape_aside_type, compare_shapes, tell_shapes
   use limber_analysis_driver_pulses, only: shown_until
   use limber_analysis_skipped_laws, only: bent_law
   use limber_analysis_static_stations, only: find_stations
   use limber_monitor_run_monitor, only: find_weak
   use limber_model_analyses, only: title
   use limber_model_model, only: analysis_step_type, leave_unstable, stop_unstable
   use limber_output_channel_values, only: new_recorder, channel_values, sample_width
   use limber_output_progress, only: progress_type
   use limber_output_sample_sink, only: sink_type
   use limber_output_followed_turns, only: follow_places
   use limber_multibody_equilibrium, only: new_equilibrium, steady_motion, extent, linearise_balance, begin_way
   use limber_multibody_free_motions, only: motion_text
   use limber_multibody_kinematics, only: place_frames, move_frames
   use limber_multibody_layout, only: advance
   use limber_multibody_motion_laws, only: describe_law
   use limber_multibody_multiplier_system, only: update_jacobians
   use limber_multibody_stability, only: descend
   use limber_multibody_turn_counts, only: driven_turn
   implicit none
   private
   public :: run_statics

   !> Increment, beside the part of the step that is done, below which it is not divided further; and the least of a step
   real(wp), parameter :: least_part = 1.0e-9_wp, least_of_step = 1.0e-13_wp
   !> Increment, beside the part of the step at its end, before which that may be taken for a critical load
   real(wp), parameter :: near_part = 1.0e-6_wp
   !> Most attempts for a part of what is left of an increment; what the search behind an instability counts
   integer, parameter :: most_tries = 3000, tries_of_search = 30
   real(wp), parameter :: least_way = 1.0e-3_wp

contains

   !> Runs all increments.
   subroutine run_statics(scene, step, history, progress, outcome, report, error)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      class(sink_type), intent(inout) :: history
      type(progress_type), intent(inout) :: progress
      type(outcome_type), intent(out) :: outcome
      !> Lines about instabilities
      character(:), allocatable, intent(out) :: report
      !> No equilibrium: what moves, and when
      type(error_type), allocatable, intent(out) :: error
      type(statics_type) :: statics
      type(static_aside_type), allocatable :: aside
      type(shape_aside_type), allocatable :: shapes
      integer(long) :: tick
      real(wp) :: cpu
      call system_clock(tick)
      call cpu_time(cpu)
      outcome%cpu = -cpu
      outcome%reached = step%dynamics%start
      allocate (outcome%indicators)
      call start_indicators(outcome%indicators, scene%system)
      call start(scene, step, statics, outcome)
      allocate (aside, shapes)
      call start_static_aside(aside, scene)
      call pass_increments(scene, step, statics, aside, shapes, history, progress, outcome, error)
      call tell_shapes(shapes, outcome%indicators%functions)
      if (.not. allocated(error) .and. statics%stable .and. statics%report == '') &
         & call check_state(scene, step, statics, aside, outcome)
      if (allocated(statics%flutter%text)) call warn(outcome, title(step)//': '//statics%flutter%text)
      call load_scene(scene, step, 1.0_wp, statics)
      scene%system%model%gravity = statics%gravity
      call scale_loads(scene, .false., 1.0_wp)
      scene%last%q = statics%q
      scene%last%v = statics%balance%v
      scene%last%angle = statics%recorder%turns%angle
      scene%last%balanced = .true.
      scene%last%lambda = statics%lambda
      scene%last%rotation = statics%balance%rotation
      scene%last%centre = statics%balance%centre
      if (allocated(statics%recorder%efforts)) call move_alloc(statics%recorder%efforts, outcome%efforts)
      report = statics%start_text//statics%report
      call cpu_time(cpu)
      outcome%cpu = outcome%cpu + cpu
      outcome%wall = seconds_since(tick)
   end subroutine run_statics

   subroutine start(scene, step, statics, outcome)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      type(statics_type), intent(inout) :: statics
      !> Gets warnings
      type(outcome_type), intent(inout) :: outcome
      character(:), allocatable :: restless
      call new_equilibrium(scene%system, statics%balance)
      call place_frames(scene%system%model, scene%system%layout, scene%system%model%dynamics%start, scene%q, scene%work%kinematics)
      call find_stations(scene%system%model, step, statics%stations, restless)
      if (restless /= '') call warn(outcome, "the law of '"//restless//"' turns back too often for each turn to be an"// &
         & ' equilibrium: between two of them loads may come and go unseen; let PERIOD be shorter, or write a law with fewer turns')
      call new_paths(statics%paths, scene%system, scene%work%kinematics)
      statics%recorder = new_recorder(scene%system, scene%q)
      if (allocated(scene%angle)) statics%recorder%turns%angle = scene%angle
      call follow_places(statics%recorder%turns, scene%system, scene%work%kinematics, scene%system%model%dynamics%start, scene%q)
      allocate (statics%angles, source=scene%work%kinematics%angles)
      allocate (statics%q, source=scene%q)
      allocate (statics%trial, source=scene%q)
      allocate (statics%lambda(scene%system%nc), statics%trial_lambda(scene%system%nc))
      allocate (statics%values(sample_width(scene%system)))
      statics%lambda = 0.0_wp
      if (allocated(scene%last%lambda)) statics%lambda = scene%last%lambda
      statics%gravity = scene%system%model%gravity
      statics%first_rotation = scene%last%rotation
      statics%report = ''
      statics%start_text = ''
      statics%neutral_text = ''
      if (max(abs(step%rotation), abs(statics%first_rotation)) > 0.0_wp .and. any(abs(statics%gravity) > 0.0_wp)) &
         & call warn(outcome, title(step)//' is a steady rotation with *GRAVITY: all of it is seen in axes that turn, and'// &
         & ' the weight turns with them, as if it were fixed to the scene; leave *GRAVITY out, or use *DYNAMICS, in which'// &
         & ' the weight keeps its direction in space')
   end subroutine start

   !> All increments, with a sample at the end of each.
   subroutine pass_increments(scene, step, statics, aside, shapes, history, progress, outcome, error)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      type(statics_type), intent(inout) :: statics
      !> Compared with at each sample
      type(static_aside_type), intent(inout) :: aside
      type(shape_aside_type), intent(inout) :: shapes
      class(sink_type), intent(inout) :: history
      type(progress_type), intent(inout) :: progress
      type(outcome_type), intent(inout) :: outcome
      type(error_type), allocatable, intent(out) :: error
      logical :: takes_time
      integer :: k
      takes_time = step%dynamics%end > step%dynamics%start
      call try_start(scene, step, statics)
      if (.not. statics%known) call fall_into_place(scene, step, statics)
      call history%check_limit(time_of(step, statics%part), error)
      if (allocated(error)) return
      if (takes_time) call sample(scene, step, statics, history, outcome, error)
      do k = 1, step%dynamics%outputs
         if (allocated(error)) return
         if (statics%stopped) exit
         call advance_to(scene, step, real(k, wp)/step%dynamics%outputs, statics, history, takes_time, outcome, error)
         if (allocated(error) .or. statics%stopped) exit
         if (takes_time .or. k == step%dynamics%outputs) call sample(scene, step, statics, history, outcome, error)
         if (aside%used .and. statics%stable .and. .not. allocated(error) .and. outcome%samples > 0) &
            & call compare_sample(aside, scene, sample_of(step, statics))
         if (.not. allocated(error) .and. outcome%samples > 0) call compare_shapes(shapes, scene, &
            & sample_of(step, statics), outcome%indicators%functions)
         call progress%update(outcome%reached)
      end do
      call tell_neutral(statics)
      if (statics%balance%unseen) call tell(statics, 'loads without a potential, as forces that follow what they push, can make'// &
         & ' vibrations grow (flutter); a scene as large as this was not searched for them: *MODES behind it names them')
      if (.not. allocated(error) .and. statics%stopped .and. .not. takes_time) &
         & call sample(scene, step, statics, history, outcome, error)
   end subroutine pass_increments

   !> The last sample, for the scene aside.
   pure function sample_of(step, statics) result(sample)
      type(analysis_step_type), intent(in) :: step
      type(statics_type), intent(in) :: statics
      type(aside_sample_type) :: sample
      sample%t = time_of(step, statics%part)
      sample%rotation = statics%balance%rotation
      sample%centre = statics%balance%centre
      allocate (sample%q, source=statics%q)
      allocate (sample%lambda, source=statics%lambda)
      allocate (sample%angle, source=statics%recorder%turns%angle)
      allocate (sample%values, source=statics%values)
   end function sample_of

   !> Equilibrium at a part of the step, by way of the stations before it.
   subroutine advance_to(scene, step, target, statics, history, takes_time, outcome, error)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      real(wp), intent(in) :: target
      type(statics_type), intent(inout) :: statics
      class(sink_type), intent(inout) :: history
      logical, intent(in) :: takes_time
      type(outcome_type), intent(inout) :: outcome
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: next
      do while (statics%part < target)
         next = minval([target, pack(statics%stations, statics%stations > statics%part)])
         call follow_to(scene, step, next, statics, history, takes_time, outcome, error)
         if (allocated(error) .or. statics%stopped) return
      end do
   end subroutine advance_to

   !> Equilibrium at a part of the step; increments are divided where the branch of equilibria cannot be followed.
   subroutine follow_to(scene, step, target, statics, history, takes_time, outcome, error)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      real(wp), intent(in) :: target
      type(statics_type), intent(inout) :: statics
      class(sink_type), intent(inout) :: history
      logical, intent(in) :: takes_time
      type(outcome_type), intent(inout) :: outcome
      type(error_type), allocatable, intent(out) :: error
      character(:), allocatable :: text, reason
      real(wp) :: increment, next, least, mark
      integer :: tries
      logical :: done
      mark = statics%part
      statics%culprit = 0
      increment = target - statics%part
      if (statics%increment > 0.0_wp) increment = min(increment, 4*statics%increment)
      tries = 0
      do while (statics%part < target)
         next = statics%part + increment
         least = max(least_of_step, least_part*statics%part)
         if (target - next < 0.5_wp*least) next = target
         if (takes_time) next = min(next, max(statics%part + least, shown_part()))
         tries = tries + 1
         if (tries > most_tries) then
            text = motion_text(scene%system, statics%balance%change)
            call explain(scene, step, statics, outcome, law_text(scene, step, statics, 'does a law of a load jump?'), reason)
            call raise(error, 'equilibrium cannot be followed beyond t = '//as_text(time_of(step, statics%part), 8)//': '// &
               & text//' by leaps, however small the increment'//reason)
            return
         end if
         call try(scene, step, next, statics, done)
         call history%check_limit(time_of(step, statics%part), error)
         if (allocated(error)) return
         if (.not. done .and. increment > least .and. .not. (next >= target .and. increment <= near_part*target)) then
            increment = 0.25_wp*increment
            cycle
         end if
         if (.not. done) call stand(scene, step, next, target, statics, done)
         if (.not. done .and. increment > least) then
            increment = 0.25_wp*increment
            cycle
         end if
         if (done .and. is_acceptable(step, statics)) then
            call take(scene, step, next, statics)
            increment = min(2*increment, target - statics%part)
            if (statics%part - mark >= least_way*(target - mark)) then
               mark = statics%part
               tries = 0
            end if
            cycle
         end if
         call pass_instability(scene, step, next, target, done, statics, history, takes_time, outcome, error)
         if (allocated(error) .or. statics%stopped) return
         tries = tries + tries_of_search
         statics%increment = 0.0_wp
         statics%pace = 0.0_wp
         increment = target - statics%part
      end do

   contains

      !> The part of the step up to which drivers do nothing that their places at both ends do not show.
      real(wp) function shown_part() result(part)
         real(wp) :: from, to, shown
         part = next
         from = time_of(step, statics%part)
         to = time_of(step, next)
         if (.not. to > from) return
         shown = shown_until(scene%system%model, from, to)
         if (shown < to) part = statics%part + (next - statics%part)*((shown - from)/(to - from))
      end function shown_part

   end subroutine follow_to

   !> Goes on with the equilibrium of the last trial. At the very critical load it counts as stable: what follows tells.
   subroutine take(scene, step, next, statics)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      real(wp), intent(in) :: next
      type(statics_type), intent(inout) :: statics
      logical :: neutral
      neutral = statics%balance%neutral .and. statics%stable
      statics%stable = statics%balance%stable .or. neutral
      statics%known = .true.
      if (next - statics%part > least_of_step) then
         statics%increment = next - statics%part
         statics%pace = extent(statics%balance, statics%balance%change)/statics%increment
      end if
      call accept(scene, statics, next)
      if (.not. neutral) call tell_neutral(statics)
      if (neutral .and. statics%neutral_text == '') statics%neutral_text = 'equilibrium is neutral at '// &
         & place_text(step, statics%part)//' (a critical load, or nothing holds the scene): '// &
         & motion_text(scene%system, statics%balance%softest)
   end subroutine take

   !> Tells of a neutral equilibrium that no unstable one has followed.
   subroutine tell_neutral(statics)
      type(statics_type), intent(inout) :: statics
      if (statics%neutral_text /= '') call tell(statics, statics%neutral_text)
      statics%neutral_text = ''
   end subroutine tell_neutral

   !> Whether the equilibrium of the last trial is one to go on with.
   pure logical function is_acceptable(step, statics)
      type(analysis_step_type), intent(in) :: step
      type(statics_type), intent(in) :: statics
      is_acceptable = statics%balance%stable
      if (.not. statics%known) return
      if (statics%stable) then
         is_acceptable = is_acceptable .or. statics%balance%neutral
      else
         is_acceptable = is_acceptable .or. step%instability /= leave_unstable .or. statics%flutters
      end if
   end function is_acceptable

   !> What happens where the next equilibrium is unstable, or there is none.
   subroutine pass_instability(scene, step, next, target, found, statics, history, takes_time, outcome, error)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      !> The part of the step that was tried, and the end of the increment
      real(wp), intent(in) :: next, target
      !> Whether there is an equilibrium, which then is the trial
      logical, intent(in) :: found
      type(statics_type), intent(inout) :: statics
      class(sink_type), intent(inout) :: history
      logical, intent(in) :: takes_time
      type(outcome_type), intent(inout) :: outcome
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: motion(:)
      real(wp), allocatable :: q(:), lambda(:)
      character(:), allocatable :: kind, text, reason
      real(wp), allocatable :: ahead(:), ahead_lambda(:)
      logical :: done, was_known
      real(wp) :: goal, parts(2), place
      integer :: round
      !> Part of a radian, or of the scene, by which an unstable equilibrium is left; part of the way to the
      !> critical load at which it is looked at what happens there
      real(wp), parameter :: push = 1.0e-2_wp, just_before = 0.99_wp
      !> How often less of the increment is tried, where no stable equilibrium is found under all of it; change of the part of the
      !> step without a sample of its own
      integer, parameter :: most_rounds = 3
      real(wp), parameter :: alike = 1.0e-9_wp
      !> The shortest way to a station, beside its part of the step: the law jumps there
      real(wp), parameter :: jump = 1.0e-14_wp
      allocate (motion, source=statics%balance%softest)
      allocate (ahead, source=statics%trial)
      allocate (ahead_lambda, source=statics%trial_lambda)
      was_known = statics%known
      kind = 'limit point, snap-through: no equilibrium is near'
      goal = target
      if (found .or. driven_turn(scene%system, time_of(step, statics%part), time_of(step, target)) > most_turn) goal = next
      if (statics%known .and. (statics%stable .or. .not. found)) then
         allocate (q, source=statics%q)
         allocate (lambda, source=statics%lambda)
         parts = [just_before*statics%part, statics%part]
         statics%taken = 0.0_wp
         if (found) then
            call find_critical(scene, step, next, statics)
            call history%check_limit(time_of(step, statics%part), error)
            if (allocated(error)) return
            motion = statics%balance%softest
            parts(1) = parts(2) + just_before*(statics%part - parts(2))
         end if
         if (found .and. statics%balance%flutters) then
            kind = flutter_text(scene, statics)
         else if (found .and. .not. statics%balance%potential) then
            kind = 'divergence: it is left without vibrating'
         else if (.not. found .and. next - statics%part <= jump*max(1.0e-3_wp, next)) then
            kind = 'a law jumps: no equilibrium is near'
         else if (.not. loads_drive(scene, step, parts, q, lambda, statics)) then
            kind = 'bifurcation: another equilibrium branches off'
         end if
         place = statics%part
         if (found .and. statics%critical >= 0.0_wp) place = statics%critical
         call tell(statics, 'equilibrium '//trim(merge('turns unstable', 'ends          ', statics%stable))//' at '// &
            & place_text(step, place)//' ('//kind//'): '//motion_text(scene%system, motion))
         statics%neutral_text = ''
         call check_load(scene, step, statics, motion, outcome)
         if (takes_time .and. statics%part > statics%sampled + alike*statics%part) &
            & call sample(scene, step, statics, history, outcome, error)
         if (allocated(error)) return
         statics%stable = .false.
         statics%stopped = step%instability == stop_unstable
         statics%flutters = found .and. statics%balance%flutters
         if (statics%stopped) return
         if ((step%instability /= leave_unstable .or. statics%flutters) .and. found) then
            call stay_on(scene, step, next, ahead, ahead_lambda, statics)
            return
         end if
      else if (found .and. statics%balance%neutral) then
         call raise_neutral(scene, step, next, statics, error)
         return
      else if (found .and. statics%balance%flutters) then
         call accept(scene, statics, next)
         call stay_unstable(scene, step, statics)
         if (statics%stopped .and. takes_time) call sample(scene, step, statics, history, outcome, error)
         return
      end if
      statics%known = .true.
      do round = 0, most_rounds
         if (round > 0) goal = statics%part + 0.25_wp*(goal - statics%part)
         statics%trial = statics%q
         statics%trial_lambda = statics%lambda
         call begin_way(statics%balance, scene%work, statics%angles)
         call load_scene(scene, step, goal, statics)
         if (found .or. statics%part > 0.0_wp) call advance(scene%system%layout, statics%q, push*motion, statics%trial)
         call descend(scene%system, scene%work, statics%balance, time_of(step, goal), &
            & step%instability == leave_unstable, statics%trial, statics%trial_lambda, done)
         call history%check_limit(time_of(step, statics%part), error)
         if (allocated(error)) return
         text = ''
         if (done) exit
         call find_open(scene, step, statics, text)
         if (text /= '') exit
      end do
      if (.not. done .and. text /= '') then
         call raise(error, 'no position near the last one satisfies the constraints behind t = '// &
            & as_text(time_of(step, statics%part), 8)//': '//text//'; the mechanism is at a dead centre or at the end of its'// &
            & ' reach there, or a driver jumps'//break_text(statics%paths, scene%system))
         return
      else if (.not. done) then
         text = motion_text(scene%system, statics%balance%softest)
         call explain(scene, step, statics, outcome, law_text(scene, step, statics, 'is something missing that holds it?'), &
            & reason)
         call raise(error, 'no stable equilibrium is found at t = '//as_text(time_of(step, goal), 8)//': '// &
            & text//' without end, or back and forth'//reason)
         return
      else if (statics%balance%neutral .and. was_known .and. found) then
         ! All but at the critical load: the other branch is not apart from this one yet
         call accept(scene, statics, goal)
         return
      else if (statics%balance%neutral) then
         call raise_neutral(scene, step, goal, statics, error)
         return
      else if (statics%balance%has_left) then
         call tell_of_leaving(scene, statics, time_of(step, goal))
      end if
      call judge_branch(scene, statics, time_of(step, goal), statics%trial, statics%trial_lambda)
      if (statics%balance%flutters) then
         call accept(scene, statics, goal)
         call stay_unstable(scene, step, statics)
         if (statics%stopped .and. takes_time) call sample(scene, step, statics, history, outcome, error)
         return
      end if
      statics%stable = statics%balance%stable
      if (.not. statics%stable) call tell(statics, 'at t = '//as_text(time_of(step, goal), 8)//' the loads are in balance, but'// &
         & ' not stably, as at a dead centre: '//motion_text(scene%system, statics%balance%softest))
      statics%stopped = .not. statics%stable .and. step%instability == stop_unstable
      call accept(scene, statics, goal)
      if (statics%stopped .and. takes_time) call sample(scene, step, statics, history, outcome, error)
   end subroutine pass_instability

   !> Which constraint could not be closed, or which lose their grip at the present state; empty if none does.
   subroutine find_open(scene, step, statics, text)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      type(statics_type), intent(in) :: statics
      character(:), allocatable, intent(out) :: text
      if (statics%balance%open > 0) then
         text = scene%system%constraints(statics%balance%open)%item%label//' stays open by '//as_text(statics%balance%gap, 3)
      else
         call find_weak(scene%system, scene%work, time_of(step, statics%part), statics%q, text)
         if (text /= '') text = text//' lose their grip on the motion'
      end if
   end subroutine find_open

   !> Warns where exact beams buckle too late.
   subroutine check_load(scene, step, statics, motion, outcome)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      type(statics_type), intent(inout) :: statics
      !> Of buckling, in the layout of the rates (nw)
      real(wp), intent(in) :: motion(:)
      type(outcome_type), intent(inout) :: outcome
      real(wp) :: t
      t = time_of(step, statics%part)
      call load_scene(scene, step, statics%part, statics)
      if (.not. allocated(outcome%warnings)) outcome%warnings = ''
      outcome%warnings = outcome%warnings//function_load_warning(scene%system, scene%work, statics%balance, t, statics%q, &
         & statics%lambda, motion, statics%taken)
   end subroutine check_load

   !> Warns where exact beams are too stiff under the last loads, and of what bodies with modes lack in the channels.
   subroutine check_state(scene, step, statics, aside, outcome)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      type(statics_type), intent(inout) :: statics
      type(static_aside_type), intent(in) :: aside
      type(outcome_type), intent(inout) :: outcome
      call load_scene(scene, step, statics%part, statics)
      if (.not. allocated(outcome%warnings)) outcome%warnings = ''
      outcome%warnings = outcome%warnings//function_state_warning(scene%system, scene%work, statics%balance, &
         & time_of(step, statics%part), statics%q, statics%lambda)
      if (aside%used) outcome%warnings = outcome%warnings//static_warning(aside, scene, title(step), &
         & sample_of(step, statics))
   end subroutine check_state

   !> Why there is no equilibrium beyond the present state: a body at the end of its model, or else what is asked.
   subroutine explain(scene, step, statics, outcome, question, reason)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      type(statics_type), intent(inout) :: statics
      type(outcome_type), intent(inout) :: outcome
      character(*), intent(in) :: question
      character(:), allocatable, intent(out) :: reason
      call look(scene, step, statics, outcome)
      reason = likely_cause(outcome%indicators, scene%system%model)
      if (reason == '') reason = question
   end subroutine explain

   !> The law that bends or jumps at the present state, or that has kept increments short, for messages; else a question.
   function law_text(scene, step, statics, question) result(text)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      type(statics_type), intent(in) :: statics
      character(*), intent(in) :: question
      character(:), allocatable :: text
      integer :: culprit
      culprit = bent_law(scene%system, scene%work, time_of(step, statics%part), statics%q)
      if (culprit == 0) culprit = statics%culprit
      text = '; '//question//break_text(statics%paths, scene%system)
      associate (speed => statics%balance%rotation)
         if (abs(speed) > 0.0_wp) text = '; is '//as_text(abs(speed), 4)//' rad/'//scene%system%model%units%time// &
            & ' a critical speed of the ROTATION, at which its stiffness does not hold it against its centrifugal force?'
      end associate
      if (culprit > 0) text = '; '//describe_law(scene%system, culprit)//' jumps or bends there: does it hold'// &
         & ' the scene behind that place? Round it off (smoothstep, tanh), or use *DYNAMICS'
   end function law_text

   !> Goes on along the unstable equilibrium at the present state: it is to be kept, or vibrations grow about it, and there is no
   !> other one to go to.
   subroutine stay_unstable(scene, step, statics)
      type(scene_type), intent(in) :: scene
      type(analysis_step_type), intent(in) :: step
      type(statics_type), intent(inout) :: statics
      call tell_unstable(scene, step, statics)
      statics%known = .true.
      statics%stable = .false.
      statics%flutters = statics%balance%flutters
      statics%stopped = step%instability == stop_unstable
   end subroutine stay_unstable

   !> Nothing holds the scene at the trial: no force against its softest motion, or none that grows in proportion to it.
   subroutine raise_neutral(scene, step, part, statics, error)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      !> Part of the step there
      real(wp), intent(in) :: part
      type(statics_type), intent(inout) :: statics
      type(error_type), allocatable, intent(out) :: error
      character(:), allocatable :: text
      text = ' freely, without a force against it (a free motion, or a dead centre, where the loads have no leverage); add a'// &
         & ' driver, a spring or a joint'
      if (holds_farther_off(scene, step, part, statics)) text = ' without a stiffness against it: forces grow only'// &
         & ' farther off, as x**3 does; whether they hold it is not decided there: add a weak spring, or use *DYNAMICS'
      call raise(error, 'nothing holds the scene at t = '//as_text(time_of(step, part), 8)//': '// &
         & motion_text(scene%system, statics%balance%softest)//text)
   end subroutine raise_neutral

   !> Whether loads change farther off along the softest motion at the trial.
   logical function holds_farther_off(scene, step, part, statics) result(holds)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      real(wp), intent(in) :: part
      type(statics_type), intent(inout) :: statics
      !> How far; and the work of forces beside the largest that is none
      real(wp), parameter :: far = 1.0e-2_wp, none = 1.0e-6_wp
      real(wp), allocatable :: motion(:), moved(:)
      real(wp) :: work(2), largest
      integer :: i, k
      allocate (motion, source=statics%balance%softest)
      allocate (moved, source=statics%trial)
      largest = max(statics%balance%forces, tiny(largest))
      call load_scene(scene, step, part, statics)
      do i = 1, 2
         call advance(scene%system%layout, statics%trial, merge(-far, far, i == 1)*motion, moved)
         call linearise_balance(scene%system, scene%work, statics%balance, time_of(step, part), moved, statics%trial_lambda)
         work(i) = dot_product(statics%balance%motion, motion)
         do k = 1, size(scene%work%loads)
            if (size(scene%work%loads(k)%force) > 0) largest = max(largest, maxval(abs(scene%work%loads(k)%force)))
         end do
      end do
      holds = maxval(abs(work)) > none*largest
   end function holds_farther_off

   !> The channels at the present state.
   subroutine sample(scene, step, statics, history, outcome, error)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      type(statics_type), intent(inout) :: statics
      class(sink_type), intent(inout) :: history
      type(outcome_type), intent(inout) :: outcome
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: t
      t = time_of(step, statics%part)
      call look(scene, step, statics, outcome)
      call follow_paths(statics%paths, scene%system, scene%work%kinematics, t, .false., outcome, error)
      if (allocated(error)) return
      call check_joints(scene%system, scene%work, t, statics%q, outcome)
      associate (system => scene%system, work => scene%work, balance => statics%balance)
         statics%recorder%work = 0.0_wp
         call channel_values(statics%recorder, system, work, t, statics%q, balance%v, balance%a, statics%values)
         call check_law_energies(system, work%kinematics, t, outcome)
      end associate
      call history%take(t, statics%values, error)
      outcome%samples = outcome%samples + 1
      outcome%reached = t
      statics%sampled = statics%part
   end subroutine sample

   !> Takes the present state into the indicators of models that are used beyond their range.
   subroutine look(scene, step, statics, outcome)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      type(statics_type), intent(inout) :: statics
      type(outcome_type), intent(inout) :: outcome
      real(wp) :: t
      t = time_of(step, statics%part)
      call load_scene(scene, step, statics%part, statics)
      associate (system => scene%system, work => scene%work, balance => statics%balance)
         call steady_motion(system, balance, statics%q)
         call place_frames(system%model, system%layout, t, statics%q, work%kinematics)
         call move_frames(system%model, system%layout, statics%q, balance%v, work%kinematics)
         call update_jacobians(system, work)
         work%lambda = statics%lambda
         call check_residuals(system, work, t, .false., balance%v, outcome)
         call observe(outcome%indicators, system, work, t, statics%q, balance%v, balance%a)
      end associate
   end subroutine look

end module limber_analysis_static_analysis
