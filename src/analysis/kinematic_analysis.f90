!> *KINEMATICS and *INVERSE DYNAMICS. The motion of a scene that its drivers move wholly, with the reactions and the torques and
!> forces of the drivers. Nothing is integrated: each position follows from the one before by Newton's method, from a prediction so
!> near that the branch is kept. Floor: analysis. Source: doc/theory, eqs. (6.19)-(6.21).
module limber_analysis_kinematic_analysis
   use limber_base_kinds, only: wp, long
   use limber_base_error, only: error_type, raise
   use limber_base_text, only: as_text, newline
   use limber_analysis_driver_grip, only: grip_type, start_grip, begin_grip, grip_time, feel_grip, keep_grip, drivers_text
   use limber_analysis_driver_pulses, only: shown_until
   use limber_analysis_driven_watch, only: driven_watch_type, start_driven_watch, observe_driven, tell_driven
   use limber_analysis_curve_path, only: curve_path_type, new_paths, follow_paths, break_text
   use limber_scene_joint_check, only: check_joints
   use limber_scene_law_checks, only: check_law_energies
   use limber_scene_kinematic_determinacy, only: undriven_text
   use limber_scene_outcome, only: outcome_type
   use limber_scene_sampling, only: check_residuals
   use limber_scene_scene, only: scene_type, seconds_since
   use limber_scene_speed_jumps, only: speed_jumps_type, new_speed_jumps, pass_speed_jumps, tell_speed_jumps
   use limber_analysis_static_aside, only: aside_sample_type
   use limber_model_law_breaks, only: last_instant
   use limber_model_model, only: analysis_step_type, step_inverse
   use limber_output_channel_values, only: recorder_type, new_recorder, channel_values, sample_width
   use limber_output_internal_forces, only: hold_efforts
   use limber_output_progress, only: progress_type
   use limber_output_sample_sink, only: sink_type
   use limber_output_followed_turns, only: follow_places
   use limber_multibody_constraint_matrix, only: constraint_matrix_type, new_constraint_matrix, fill
   use limber_multibody_equations_of_motion, only: mechanical_energy
   use limber_multibody_free_motions, only: free_motions_type, find_freedom
   use limber_multibody_driven_motion, only: driven_motion_type, new_held, held_position, held_motion, balance_deflections
   use limber_multibody_kinematics, only: place_frames, settle_angles
   use limber_multibody_layout, only: advance
   use limber_multibody_motion_residual, only: motion_residual
   use limber_multibody_multiplier_system, only: place_constraints
   use limber_multibody_redundant_constraints, only: redundancy_type, find_redundancy, constraint_names
   implicit none
   private
   public :: run_kinematics

   !> State and scratch
   type :: driven_path_type
      type(driven_motion_type) :: held
      type(recorder_type) :: recorder
      !> What is told of deflections in equilibrium
      type(driven_watch_type) :: watch
      type(curve_path_type) :: paths
      type(speed_jumps_type) :: jumps
      type(grip_type) :: grip
      real(wp) :: t = 0.0_wp
      !> Coordinates, velocities, accelerations (nq); a trial place (nq); increments (nw); values of the channels
      real(wp), allocatable :: q(:), v(:), a(:), trial(:), change(:), values(:)
      !> Largest force or torque of each driver's equations in size, with its sign, and when; and the same of the power
      real(wp), allocatable :: peak(:), peak_time(:), power(:), power_time(:)
   end type driven_path_type

contains

   !> Runs from the first to the last instant.
   subroutine run_kinematics(scene, step, history, progress, outcome, report, error)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      class(sink_type), intent(inout) :: history
      type(progress_type), intent(inout) :: progress
      type(outcome_type), intent(out) :: outcome
      !> Lines about the drivers
      character(:), allocatable, intent(out) :: report
      !> The scene has freedom left, or passes a singular position
      type(error_type), allocatable, intent(out) :: error
      type(driven_path_type) :: motion
      integer(long) :: tick
      real(wp) :: cpu, last
      integer :: k
      call system_clock(tick)
      call cpu_time(cpu)
      outcome%cpu = -cpu
      outcome%reached = step%dynamics%start
      report = ''
      call check_freedom(scene, step, error)
      if (allocated(error)) return
      call start(scene, step, motion)
      if (step%static_deflections) call start_driven_watch(motion%watch, scene, step, outcome)
      ! Where a law of time changes at the end, as behind the last line of a table, the formula before counts
      last = last_instant(scene%system%model, step%dynamics%start, step%dynamics%end)
      do k = 0, step%dynamics%outputs
         if (k > 0) call move_to(scene, min(last, sample_time(step, k)), motion, history, outcome, error)
         if (.not. allocated(error)) call sample(scene, step, motion, history, outcome, error)
         if (allocated(error)) exit
         outcome%reached = motion%t
         call progress%update(motion%t)
      end do
      if (step%static_deflections) call tell_driven(motion%watch, scene, step, outcome)
      call tell_speed_jumps(motion%jumps, scene%system, outcome)
      scene%last%q = motion%q
      scene%last%v = motion%v
      scene%last%angle = motion%recorder%turns%angle
      if (allocated(motion%recorder%efforts)) call move_alloc(motion%recorder%efforts, outcome%efforts)
      scene%last%balanced = .false.
      scene%last%rotation = 0.0_wp
      if (step%kind == step_inverse) report = driver_report(scene, motion)
      call cpu_time(cpu)
      outcome%cpu = outcome%cpu + cpu
      outcome%wall = seconds_since(tick)
   end subroutine run_kinematics

   pure real(wp) function sample_time(step, k)
      type(analysis_step_type), intent(in) :: step
      integer, intent(in) :: k
      associate (dynamics => step%dynamics)
         sample_time = dynamics%start + (dynamics%end - dynamics%start)*(real(k, wp)/dynamics%outputs)
         if (k == dynamics%outputs) sample_time = dynamics%end
      end associate
   end function sample_time

   !> An error if something can move that no driver moves.
   subroutine check_freedom(scene, step, error)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      type(error_type), allocatable, intent(out) :: error
      type(free_motions_type) :: freedom
      integer :: missing
      associate (system => scene%system, work => scene%work)
         call place_constraints(system, work, step%dynamics%start, scene%q)
         call find_freedom(system, work, .true., freedom)
         missing = size(freedom%basis, 2)
         if (missing > 0) then
            call raise(error, undriven_text(scene, freedom)//'; drive as many motions as there are'// &
               & ' degrees of freedom, or use *DYNAMICS')
         else if (freedom%rank < system%nc .and. .not. system%redundant) then
            missing = system%nc - freedom%rank
            call find_freedom(system, work, .false., freedom)
            call raise(error, repeated_text(scene, missing, freedom%rank == system%nc))
         end if
      end associate
   end subroutine check_freedom

   !> What is told of joints and drivers that hold what others hold, as long as bodies keep their shape. Their Jacobians are
   !> at hand.
   function repeated_text(scene, number, bends) result(text)
      type(scene_type), intent(inout) :: scene
      !> Of equations
      integer, intent(in) :: number
      !> Whether all can be kept by bodies that bend
      logical, intent(in) :: bends
      character(:), allocatable :: text
      type(constraint_matrix_type) :: frames
      type(redundancy_type) :: found
      associate (system => scene%system)
         call new_constraint_matrix(system, .false., frames)
         call fill(system, scene%work, frames)
         call find_redundancy(system, frames, found)
         text = 'joints and drivers'
         if (found%count > 0) text = constraint_names(system, found%group > 0)
         if (bends) then
            text = 'the joints bend bodies, and the motion of the frames does not say how; use *STATICS with PERIOD=, which'// &
               & ' finds the shapes in equilibrium as the drivers move on, or *DYNAMICS; or remove what repeats as long as'// &
               & ' bodies keep their shape, '//as_text(number)//' equations among '//text
         else
            text = text//' repeat each other in '//as_text(number)//' equations at the start, or the mechanism is at a dead'// &
               & ' centre: start elsewhere, or remove what repeats'
         end if
      end associate
   end function repeated_text

   subroutine start(scene, step, motion)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      type(driven_path_type), intent(inout) :: motion
      integer :: drivers
      associate (nq => scene%system%layout%nq)
         allocate (motion%q, source=scene%q)
         allocate (motion%v(nq), motion%a(nq), motion%trial(nq), motion%change(scene%system%layout%nw))
         allocate (motion%values(sample_width(scene%system)))
      end associate
      drivers = size(scene%system%model%drivers)
      allocate (motion%peak(drivers), motion%peak_time(drivers), motion%power(drivers), motion%power_time(drivers))
      motion%peak = 0.0_wp
      motion%power = 0.0_wp
      motion%peak_time = step%dynamics%start
      motion%power_time = step%dynamics%start
      motion%v = 0.0_wp
      motion%a = 0.0_wp
      motion%t = step%dynamics%start
      call new_held(scene%system, motion%held)
      call start_grip(motion%grip, scene%system, motion%held)
      motion%recorder = new_recorder(scene%system, scene%q)
      if (allocated(scene%angle)) motion%recorder%turns%angle = scene%angle
      call follow_places(motion%recorder%turns, scene%system, scene%work%kinematics, motion%t, motion%q)
      call place_frames(scene%system%model, scene%system%layout, motion%t, motion%q, scene%work%kinematics)
      call new_paths(motion%paths, scene%system, scene%work%kinematics)
      call new_speed_jumps(motion%jumps, scene%system)
   end subroutine start

   !> Moves on to a time in steps so small that the next position is sure to be on the same branch.
   subroutine move_to(scene, t, motion, history, outcome, error)
      type(scene_type), intent(inout) :: scene
      real(wp), intent(in) :: t
      type(driven_path_type), intent(inout) :: motion
      class(sink_type), intent(in) :: history
      type(outcome_type), intent(inout) :: outcome
      type(error_type), allocatable, intent(out) :: error
      !> Largest change of a coordinate that is predicted, and largest correction, relative to the scales
      real(wp), parameter :: stride = 0.2_wp, correction = 0.05_wp
      !> Part of the way to a sample that the first step of all takes, for its rate of the grip is not known
      real(wp), parameter :: first = 1.0e-3_wp
      real(wp) :: h, shortest, size_of, shown
      real(wp), dimension(scene%system%layout%nw) :: w, a
      logical :: done
      shortest = 1.0e-10_wp*max(abs(t - motion%t), spacing(t))
      associate (system => scene%system, work => scene%work, held => motion%held)
         call begin_grip(motion%grip, system, work, held, motion%t, motion%q)
         do while (motion%t < t)
            call history%check_limit(motion%t, error)
            if (allocated(error)) return
            h = min(t - motion%t, grip_time(motion%grip))
            if (motion%grip%rate < 0.0_wp) h = first*h
            w = held%w
            a = held%a
            do
               if (h < shortest .and. h < t - motion%t) then
                  call raise(error, drivers_text(motion%grip, system)//'no position near the last one satisfies the'// &
                     & ' constraints behind t = '//as_text(motion%t, 8)//': the mechanism is at a dead centre or at the end of'// &
                     & ' its reach there, or a driver jumps'//break_text(motion%paths, system))
                  return
               end if
               motion%change = h*(w + 0.5_wp*h*a)
               size_of = maxval(abs(motion%change/held%scale))
               if (size_of > stride) then
                  h = h*max(0.1_wp, 0.9_wp*stride/size_of)
                  cycle
               end if
               shown = shown_until(system%model, motion%t, motion%t + h)
               if (shown < motion%t + h) then
                  h = shown - motion%t
                  cycle
               end if
               call advance(system%layout, motion%q, motion%change, motion%trial)
               call held_position(system, work, held, motion%t + h, motion%trial, size_of, done)
               if (done .and. size_of <= correction) then
                  call feel_grip(motion%grip, system, held, done)
                  if (done) exit
               end if
               h = 0.5_wp*h
            end do
            call keep_grip(motion%grip, h)
            motion%t = merge(t, motion%t + h, t - motion%t - h < shortest)
            motion%q = motion%trial
            call pass_speed_jumps(motion%jumps, system, work, motion%t, motion%q, error)
            if (allocated(error)) return
            call place_frames(system%model, system%layout, motion%t, motion%q, work%kinematics)
            call settle_angles(work%kinematics, .false.)
            call follow_places(motion%recorder%turns, system, work%kinematics, motion%t, motion%q)
            call follow_paths(motion%paths, system, work%kinematics, motion%t, .true., outcome, error)
            if (allocated(error)) return
            if (motion%t < t) call held_motion(system, work, held, motion%t, motion%q, motion%v, motion%a, done)
            if (.not. done) then
               call raise_singular(motion%t, error)
               return
            end if
         end do
      end associate
   end subroutine move_to

   subroutine raise_singular(t, error)
      real(wp), intent(in) :: t
      type(error_type), allocatable, intent(out) :: error
      call raise(error, 'the mechanism is at a singular position at t = '//as_text(t, 8)// &
         & ', a dead centre: velocities and reactions are not determined there')
   end subroutine raise_singular

   !> The whole state at the present time, and its channels.
   subroutine sample(scene, step, motion, history, outcome, error)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      type(driven_path_type), intent(inout) :: motion
      class(sink_type), intent(inout) :: history
      type(outcome_type), intent(inout) :: outcome
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: kinetic, potential
      logical :: done
      associate (system => scene%system, work => scene%work)
         if (step%static_deflections) then
            call balance_deflections(system, work, motion%held, motion%t, motion%q, motion%v, motion%a, done)
            if (.not. done) call raise(error, 'no equilibrium of the deflections is found at t = '//as_text(motion%t, 8)// &
               & ': the motion is too fast for them to follow, or the mechanism is at a dead centre;'// &
               & ' use DEFLECTIONS=HELD or *DYNAMICS')
         else
            call held_motion(system, work, motion%held, motion%t, motion%q, motion%v, motion%a, done)
            if (.not. done) call raise_singular(motion%t, error)
            if (done .and. motion%recorder%needs_sections) then
               call motion_residual(system, work, motion%t, motion%q, motion%v, motion%held%a, motion%held%lambda, &
                  & motion%held%motion, motion%held%rates)
               call hold_efforts(motion%recorder%efforts, system, motion%held%motion)
            end if
         end if
         if (allocated(error)) return
         call watch_drivers(scene, motion)
         call check_residuals(system, work, motion%t, .true., motion%v, outcome)
         call check_joints(system, work, motion%t, motion%q, outcome)
         call mechanical_energy(system, work, motion%q, motion%v, kinetic, potential)
         call check_law_energies(system, work%kinematics, motion%t, outcome)
         if (outcome%samples == 0) outcome%first_energy = kinetic + potential
         outcome%last_energy = kinetic + potential
         outcome%largest_energy = max(outcome%largest_energy, kinetic, abs(potential - outcome%first_energy))
         outcome%work = outcome%last_energy - outcome%first_energy
         motion%recorder%work = outcome%work
         call channel_values(motion%recorder, system, work, motion%t, motion%q, motion%v, motion%a, motion%values)
      end associate
      if (step%static_deflections) call observe_driven(motion%watch, scene, motion%held, motion%recorder, &
         & sample_of(motion, scene), motion%v, motion%a, outcome)
      call history%take(motion%t, motion%values, error)
      outcome%samples = outcome%samples + 1
   end subroutine sample

   !> The present sample, for the watch.
   function sample_of(motion, scene) result(sample)
      type(driven_path_type), intent(in) :: motion
      type(scene_type), intent(in) :: scene
      type(aside_sample_type) :: sample
      sample%t = motion%t
      sample%driven = .true.
      allocate (sample%q, source=motion%q)
      allocate (sample%lambda, source=scene%work%lambda)
      allocate (sample%angle, source=motion%recorder%turns%angle)
      allocate (sample%values, source=motion%values)
   end function sample_of

   !> Keeps the largest force and power of each driver.
   subroutine watch_drivers(scene, motion)
      type(scene_type), intent(inout) :: scene
      type(driven_path_type), intent(inout) :: motion
      real(wp) :: force, power
      integer :: i
      associate (system => scene%system, work => scene%work, joints => size(scene%system%model%joints))
         do i = 1, size(motion%peak)
            associate (item => system%constraints(joints + i)%item)
               if (item%rows == 0) cycle
               call item%rate(work%kinematics, work%gamma(item%first:item%first + item%rows - 1))
               power = -dot_product(work%lambda(item%first:item%first + item%rows - 1), &
                  & work%gamma(item%first:item%first + item%rows - 1))
               force = -work%lambda(item%first)
            end associate
            if (abs(force) > abs(motion%peak(i))) then
               motion%peak(i) = force
               motion%peak_time(i) = motion%t
            end if
            if (abs(power) > abs(motion%power(i))) then
               motion%power(i) = power
               motion%power_time(i) = motion%t
            end if
         end do
      end associate
   end subroutine watch_drivers

   !> A line for each driver.
   function driver_report(scene, motion) result(text)
      type(scene_type), intent(in) :: scene
      type(driven_path_type), intent(in) :: motion
      character(:), allocatable :: text
      integer :: i
      text = ''
      do i = 1, size(motion%peak)
         text = text//newline//'      '//scene%system%constraints(size(scene%system%model%joints) + i)%item%label// &
            & ': largest torque or force '//as_text(motion%peak(i), 6)//' at t = '//as_text(motion%peak_time(i), 6)// &
            & ', largest power '//as_text(motion%power(i), 6)//' at t = '//as_text(motion%power_time(i), 6)
      end do
   end function driver_report

end module limber_analysis_kinematic_analysis
