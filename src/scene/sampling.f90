!> Samples of a motion: projection and channels. A state, projected onto the constraints, and its channels; what is checked there.
!> Floor: scene.
module limber_scene_sampling
   use limber_base_kinds, only: wp, long
   use limber_base_error, only: error_type, raise
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text
   use limber_scene_joint_check, only: check_joints
   use limber_scene_outcome, only: outcome_type, warn, allowed_imbalance, passing_scale
   use limber_scene_scene, only: scene_type
   use limber_integrator_implicit, only: implicit_type
   use limber_integrator_integrator, only: integrator_type
   use limber_model_model, only: dynamics_type, ground
   use limber_output_channel_values, only: recorder_type, channel_values
   use limber_output_sample_sink, only: sink_type
   use limber_multibody_plane_vectors, only: cross
   use limber_multibody_equations_of_motion, only: linearise, accelerations, position_residual, velocity_residual, &
      & mechanical_energy, add_parts_of_power, worst_constraint
   use limber_multibody_driven_motion, only: driven_motion_type, new_held, held_position, balance_passed
   use limber_multibody_kinematics, only: place_frames
   use limber_monitor_run_monitor, only: find_weak
   use limber_multibody_layout, only: normalise_frames
   use limber_multibody_projection, only: harmless, settle, settle_place, settle_position
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: sample_type, sample_time, record, balance_sample, look_between, check_residuals, check_energy
   public :: forget_system

   !> Scratch of the sampling, allocated once, and when the next samples are
   type :: sample_type
      real(wp), allocatable :: q(:), v(:), a(:), change(:), values(:)
      real(wp) :: w = 0.0_wp
      !> Number of the next sample
      integer :: next = 1
      !> Number of the step and time at which flexible bodies are to be observed next, whichever comes first, and the number of
      !> evaluations before which they are not
      integer(long) :: next_step = 0
      real(wp) :: next_look = -huge(1.0_wp)
      integer :: next_evaluation = 0
      !> The step whose interpolated places are as good as the joints ask for
      real(wp) :: good_from = huge(1.0_wp), good_to = -huge(1.0_wp)
      !> Whether samples show what bodies do in their own frames alone, and nothing of the joints
      logical :: local = .false.
      !> Largest multiplier at samples that were not at a singular position
      real(wp) :: forces = 0.0_wp
      !> Whether the sample just taken is at a singular position, and was not recorded: constraints have no grip there, and forces
      !> and accelerations have round-off only; what these constraints are; and whether it is to be recorded as it is
      logical :: ungripped = .false., anyhow = .false.
      character(:), allocatable :: weakest
      !> Samples that were recorded aside of such a position
      integer :: aside = 0
      !> Of samples within steps that pass over vibrations; accelerations in the layout of the rates (nw)
      type(driven_motion_type), allocatable, private :: held
      real(wp), allocatable, private :: rates(:)
   contains
      procedure :: exchange => exchange_sample
   end type sample_type

contains

   !> Saves or restores it.
   subroutine exchange_sample(self, snapshot)
      class(sample_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%keep('sample_q', self%q)
      call snapshot%keep('sample_v', self%v)
      call snapshot%keep('sample_a', self%a)
      call snapshot%keep('sample_change', self%change)
      call snapshot%keep('sample_values', self%values)
      call snapshot%exchange('sample_w', self%w)
      call snapshot%exchange('next', self%next)
      call snapshot%exchange('next_step', self%next_step)
      call snapshot%exchange('next_look', self%next_look)
      call snapshot%exchange('next_evaluation', self%next_evaluation)
      call snapshot%exchange('good_from', self%good_from)
      call snapshot%exchange('good_to', self%good_to)
      call snapshot%exchange('sample_forces', self%forces)
      call snapshot%exchange('sample_aside', self%aside)
      ! Not saved: local, ungripped, anyhow, weakest, held, rates
   end subroutine exchange_sample

   !> Time of a sample; the last is the end, to the bit.
   pure real(wp) function sample_time(dynamics, index)
      type(dynamics_type), intent(in) :: dynamics
      integer, intent(in) :: index
      sample_time = dynamics%start + (dynamics%end - dynamics%start)*(real(index, wp)/dynamics%outputs)
      if (index == dynamics%outputs) sample_time = dynamics%end
   end function sample_time

   !> Projects a state onto the constraints, evaluates the channels there and hands them to the history. Velocities at the end of
   !> a step that conserves energy are left as they are: projected, they would have another.
   subroutine record(scene, t, time, integrator, recorder, sample, history, outcome, error)
      type(scene_type), intent(inout) :: scene
      !> Time of the state, and of the sample: the same, or on different sides of an instant at which a law changes
      real(wp), intent(in) :: t, time
      class(integrator_type), intent(in) :: integrator
      type(recorder_type), intent(inout) :: recorder
      type(sample_type), intent(inout) :: sample
      class(sink_type), intent(inout) :: history
      type(outcome_type), intent(inout) :: outcome
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: before, residual
      logical :: moving, good
      moving = recorder%needs_velocities .or. recorder%needs_accelerations
      associate (system => scene%system, work => scene%work)
         good = t > sample%good_from .and. t < sample%good_to .and. .not. moving
         if (good .or. (sample%local .and. sample%next < system%model%dynamics%outputs)) then
            call show(scene, t, recorder, sample, outcome, error)
            if (.not. allocated(error)) call history%take(time, sample%values, error)
            outcome%samples = outcome%samples + 1
            return
         end if
         if (recorder%needs_accelerations .and. integrator%steps_over) call balance_sample(scene, t, integrator, sample)
         if (recorder%needs_velocities .and. .not. integrator%ends_on_samples) then
            call settle(system, work, t, sample%q, sample%v, sample%change, recorder%needs_accelerations, residual, error)
         else if (moving) then
            call settle_position(system, work, t, sample%q, sample%change, before, residual, error)
         else
            call settle_place(system, work, t, sample%q, sample%change, may_stay(integrator%tolerance), residual, error)
         end if
         if (allocated(error)) return
         if (recorder%needs_velocities) then
            call check_residuals(system, work, t, .true., sample%v, outcome)
         else if (system%nc > 0) then
            ! They are those of the place reached
            outcome%position_residual = max(outcome%position_residual, maxval(abs(work%phi)))
         end if
         if (residual > may_stay(integrator%tolerance)) call check_place(system, work, t, residual, outcome)
         call check_joints(system, work, t, sample%q, outcome)
         if (recorder%needs_accelerations) then
            call accelerations(system, work, sample%q, sample%v, sample%a)
            call look_at_grip(system, work, t, sample)
            if (sample%ungripped) return
         end if
      end associate
      call show(scene, t, recorder, sample, outcome, error)
      if (.not. allocated(error)) call history%take(time, sample%values, error)
      outcome%samples = outcome%samples + 1
   end subroutine record

   !> Whether a sample is at a singular position. That is looked at where its multipliers are much larger than all before.
   subroutine look_at_grip(system, work, t, sample)
      type(system_type), intent(in) :: system
      !> With the accelerations and multipliers of the sample
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      type(sample_type), intent(inout) :: sample
      !> Growth of the multipliers that is much; grip that is none, relative to the inverse of the mean mass
      real(wp), parameter :: much = 3.0_wp, none = 1.0e-7_wp
      real(wp) :: forces, grip
      sample%ungripped = .false.
      if (system%nc == 0 .or. sample%anyhow) return
      forces = maxval(abs(work%lambda(:system%nc)))
      if (forces <= much*sample%forces) return
      call find_weak(system, work, t, sample%q, sample%weakest, grip)
      sample%ungripped = sample%weakest /= '' .and. grip < none
      call accelerations(system, work, sample%q, sample%v, sample%a)
      if (.not. sample%ungripped) sample%forces = forces
   end subroutine look_at_grip

   !> Brings a sample of an integrator that passes over vibrations into balance with the accelerations of its dense output. Forces
   !> of stiff bodies and springs would else be those of the errors of the motion. Where there are no such accelerations, frames
   !> alone close the joints of samples within steps.
   subroutine balance_sample(scene, t, integrator, sample)
      type(scene_type), intent(inout) :: scene
      real(wp), intent(in) :: t
      class(integrator_type), intent(in) :: integrator
      type(sample_type), intent(inout) :: sample
      !> Largest move of a coordinate, in units of its scale: in tolerances, and at all
      real(wp), parameter :: tolerances = 100.0_wp, most = 0.01_wp
      real(wp) :: pace, moved
      logical :: closed
      associate (system => scene%system, work => scene%work)
         if (.not. is_elastic(system)) return
         if (.not. allocated(sample%held)) then
            allocate (sample%held, sample%rates(system%layout%nw))
            call new_held(system, sample%held)
         end if
         call integrator%interpolate_accelerations(t, sample%rates, pace)
         if (.not. pace > 0.0_wp .and. .not. t < integrator%t) return
         call start_factors(integrator, sample%held)
         sample%change = sample%q
         if (pace > 0.0_wp) then
            call balance_passed(system, work, sample%held, t, sample%change, sample%v, sample%rates, pace, moved)
            if (moved <= min(most, tolerances*integrator%tolerance)) then
               sample%q = sample%change
               return
            end if
            sample%change = sample%q
         end if
         if (system%nc == 0 .or. .not. t < integrator%t .or. .not. any(system%layout%n > 0)) return
         call held_position(system, work, sample%held, t, sample%change, moved, closed)
         if (closed) sample%q = sample%change
      end associate
   end subroutine balance_sample

   !> Forgets what is made of the constraints and loads of a system, which are others from now on.
   subroutine forget_system(sample)
      type(sample_type), intent(inout) :: sample
      if (allocated(sample%held)) deallocate (sample%held, sample%rates)
   end subroutine forget_system

   !> Forgets the factors of the samples before, which a restart does not have: those of this one begin with the pivots of the
   !> integrator's own.
   subroutine start_factors(integrator, held)
      class(integrator_type), intent(in) :: integrator
      type(driven_motion_type), intent(inout) :: held
      call held%tangent%matrix%release_factors()
      select type (integrator)
      class is (implicit_type)
         call held%tangent%matrix%follow_pivots(integrator%tangent%matrix)
      end select
   end subroutine start_factors

   !> Whether a scene has something that bends, or loads that resist places.
   pure logical function is_elastic(system)
      type(system_type), intent(in) :: system
      integer :: i
      is_elastic = any(system%layout%n > 0)
      do i = 1, size(system%loads)
         is_elastic = is_elastic .or. system%loads(i)%item%resists
      end do
   end function is_elastic

   !> The channels of a sample.
   subroutine show(scene, t, recorder, sample, outcome, error)
      type(scene_type), intent(inout) :: scene
      real(wp), intent(in) :: t
      type(recorder_type), intent(inout) :: recorder
      type(sample_type), intent(inout) :: sample
      type(outcome_type), intent(inout) :: outcome
      type(error_type), allocatable, intent(out) :: error
      recorder%work = sample%w
      call channel_values(recorder, scene%system, scene%work, t, sample%q, sample%v, sample%a, sample%values)
      call check_values(scene%system, t, sample, outcome, error)
   end subroutine show

   !> Whether samples within the last step may stay where they are interpolated, and need not be brought onto the joints: those that
   !> show places only, where the interpolation keeps the joints in the middle of the step, the place where it errs most.
   subroutine look_between(scene, integrator, recorder, sample, outcome)
      type(scene_type), intent(inout) :: scene
      class(integrator_type), intent(inout) :: integrator
      type(recorder_type), intent(in) :: recorder
      !> Its state is scratch
      type(sample_type), intent(inout) :: sample
      type(outcome_type), intent(inout) :: outcome
      real(wp), parameter :: part = 0.5_wp
      real(wp) :: t, residual
      sample%good_to = -huge(t)
      associate (system => scene%system, work => scene%work)
         if (recorder%needs_velocities .or. recorder%needs_accelerations .or. integrator%ends_on_samples) return
         t = integrator%t_before + 0.5_wp*(integrator%t - integrator%t_before)
         call integrator%interpolate_place(t, sample%q, sample%v, sample%w)
         call integrator%complete(system, work, t, sample%q, sample%v)
         ! Joints on pins are linear in the frames' vectors: what these lack shows in their length only
         call normalise_frames(system%layout, sample%q)
         call place_frames(system%model, system%layout, t, sample%q, work%kinematics)
         residual = position_residual(system, work)
         if (residual > part*may_stay(integrator%tolerance)) return
         if (system%nc > 0) outcome%position_residual = max(outcome%position_residual, maxval(abs(work%phi)))
         sample%good_from = integrator%t_before
         sample%good_to = integrator%t
      end associate
   end subroutine look_between

   !> Residual that samples may have which show places only: far below the error of the motion. A projection would cost as much as
   !> the motion there.
   pure real(wp) function may_stay(tolerance)
      !> Of the integrator
      real(wp), intent(in) :: tolerance
      real(wp), parameter :: part = 1.0e-4_wp
      may_stay = part*tolerance
   end function may_stay

   !> A warning if a sample could not be brought onto the constraints, once a run.
   subroutine check_place(system, work, t, residual, outcome)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Time; residual that is left
      real(wp), intent(in) :: t, residual
      type(outcome_type), intent(inout) :: outcome
      real(wp) :: worst
      integer :: culprit
      if (outcome%astray .or. .not. residual > harmless) return
      outcome%astray = .true.
      call worst_constraint(system, work, culprit, worst)
      call warn(outcome, system%constraints(culprit)%item%label//' is not kept at the sample at t = '//as_text(t, 8)// &
         & ' (residual '//as_text(worst, 3)//'): it is nearly singular there, or masses differ too much; this sample,'// &
         & ' and others like it, are wrong; try '//system%model%dynamics%finer()//', or another INTEGRATOR')
   end subroutine check_place

   !> An error if a state is no number; a warning if a channel is none, once a run.
   subroutine check_values(system, t, sample, outcome, error)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: t
      type(sample_type), intent(in) :: sample
      type(outcome_type), intent(inout) :: outcome
      type(error_type), allocatable, intent(out) :: error
      integer :: i
      if (.not. all(abs(sample%q) <= huge(t))) then
         call raise(error, 'the motion is no number any more at t = '//as_text(t, 8)//': something in it is too large or too'// &
            & ' small for double precision; use other units, or look at the numbers of the deck')
         return
      end if
      if (all(abs(sample%values) <= huge(t))) return
      if (.not. allocated(outcome%undefined)) allocate (outcome%undefined(size(system%model%channels)), source=.false.)
      do i = 1, size(system%model%channels)
         if (outcome%undefined(i) .or. abs(sample%values(i)) <= huge(t)) cycle
         outcome%undefined(i) = .true.
         call warn(outcome, "channel '"//system%model%channels(i)%name//"' has no value at t = "//as_text(t, 8)// &
            & ': a logarithm, root or quotient in it is not defined there')
      end do
   end subroutine check_values

   !> Constraint residuals of a sample.
   subroutine check_residuals(system, work, t, moving, v, outcome)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Its time
      real(wp), intent(in) :: t
      !> Whether its velocities are asked for
      logical, intent(in) :: moving
      real(wp), contiguous, intent(in) :: v(:)
      type(outcome_type), intent(inout) :: outcome
      real(wp) :: largest
      if (system%nc == 0) return
      largest = position_residual(system, work)
      outcome%position_residual = max(outcome%position_residual, maxval(abs(work%phi)))
      if (.not. moving) return
      largest = velocity_residual(system, work, v)
      outcome%velocity_residual = max(outcome%velocity_residual, maxval(abs(work%gamma)))
      call add_slips(system, work, t, v, outcome)
   end subroutine check_residuals

   !> Velocity residuals of all constraints, which work%gamma holds, and the speeds that they are to be compared with: what either
   !> side of a single equation makes by its place, or by its rotation.
   subroutine add_slips(system, work, t, v, outcome)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      real(wp), intent(in) :: t, v(:)
      type(outcome_type), intent(inout) :: outcome
      real(wp) :: slip
      integer :: i, side, first
      if (.not. allocated(outcome%slip)) allocate (outcome%slip(size(system%constraints)), outcome%slip_time( &
         & size(system%constraints)), outcome%slip_speed(size(system%constraints)), source=0.0_wp)
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            slip = maxval(abs(work%gamma(item%first:item%first + item%rows - 1)))
            if (slip > outcome%slip(i)) then
               outcome%slip(i) = slip
               outcome%slip_time(i) = t
            end if
            if (item%rows /= 1) cycle
            do side = 1, 2
               if (item%bodies(side) == ground) cycle
               first = system%layout%q(item%bodies(side))
               associate (z => work%jacobians(side, i)%z)
                  ! Across a rod as along it
                  outcome%slip_speed(i) = max(outcome%slip_speed(i), norm2(z(1, 1:2))*norm2(v(first:first + 1)))
                  if (system%layout%framed(item%bodies(side))) outcome%slip_speed(i) = max(outcome%slip_speed(i), &
                     & abs(z(1, 3)*cross(work%kinematics%frames(item%bodies(side))%u, v(first + 2:first + 3))))
               end associate
            end do
         end associate
      end do
   end subroutine add_slips

   !> Energy balance at the end of a step.
   subroutine check_energy(scene, t, sample, outcome)
      type(scene_type), intent(inout) :: scene
      real(wp), intent(in) :: t
      type(sample_type), intent(inout) :: sample
      type(outcome_type), intent(inout) :: outcome
      !> Part of the largest energy below which the kinetic energy says nothing of how fast a motion goes on
      real(wp), parameter :: turning_back = 0.02_wp
      real(wp) :: kinetic, potential
      if (outcome%samples == 0) then
         call find_no_energy(scene, sample, outcome)
         outcome%summed = t
      end if
      call mechanical_energy(scene%system, scene%work, sample%q, sample%v, kinetic, potential)
      ! An impact at the start has done work already
      if (outcome%samples == 0) outcome%first_energy = kinetic + potential - sample%w
      if (outcome%samples == 0) outcome%first_potential = potential
      outcome%last_energy = kinetic + potential
      if (.not. allocated(outcome%net_work)) outcome%work_before = outcome%work
      outcome%work = sample%w
      outcome%imbalance = max(outcome%imbalance, abs(kinetic + potential - outcome%first_energy - sample%w))
      outcome%largest_energy = max(outcome%largest_energy, kinetic, abs(potential - outcome%first_energy))
      if (size(scene%system%model%drivers) == 0) then
         outcome%moved_time = outcome%moved_time + (t - outcome%summed)*max(kinetic, abs(potential - outcome%first_potential))
         outcome%duration = outcome%duration + (t - outcome%summed)
         outcome%fastest = max(outcome%fastest, kinetic)
      end if
      if (outcome%imbalance > allowed_imbalance*min(max(outcome%largest_energy, outcome%no_energy), passing_scale(outcome))) &
         & call add_exchange(scene, t, sample, outcome)
      call add_turn(scene, t - outcome%summed, sample, outcome)
      if (outcome%largest_energy > 0.0_wp) outcome%ahead = outcome%ahead + (t - outcome%summed)*(kinetic + potential &
         & - outcome%first_energy - sample%w)/(2*max(kinetic, turning_back*outcome%largest_energy))
      outcome%summed = t
   end subroutine check_energy

   !> Adds the turn that each body has made since the last look.
   subroutine add_turn(scene, duration, sample, outcome)
      type(scene_type), intent(in) :: scene
      !> Since then
      real(wp), intent(in) :: duration
      type(sample_type), intent(in) :: sample
      type(outcome_type), intent(inout) :: outcome
      integer :: i, first
      if (.not. allocated(outcome%turned)) allocate (outcome%turned(size(scene%system%layout%q)), source=0.0_wp)
      do i = 1, size(outcome%turned)
         if (.not. scene%system%layout%framed(i)) cycle
         first = scene%system%layout%q(i) + 2
         outcome%turned(i) = outcome%turned(i) + duration*cross(sample%q(first:first + 1), sample%v(first:first + 1))
      end do
   end subroutine add_turn

   !> Sums up the net work of drivers, loads and damping, eq. (7.1): only where the balance is off, for it costs an evaluation,
   !> which is not counted.
   subroutine add_exchange(scene, t, sample, outcome)
      type(scene_type), intent(inout) :: scene
      real(wp), intent(in) :: t
      !> With the state; its accelerations are scratch
      type(sample_type), intent(inout) :: sample
      type(outcome_type), intent(inout) :: outcome
      type(error_type), allocatable :: error
      integer :: before(2)
      associate (system => scene%system, work => scene%work)
         if (.not. system%powered) return
         if (.not. allocated(outcome%net_work)) allocate (outcome%net_work(size(system%constraints) + size(system%loads) &
            & + size(work%bodies)), source=0.0_wp)
         before = [work%evaluations, work%matrix%factorisations]
         call linearise(system, work, t, sample%q, error)
         if (.not. allocated(error)) then
            call accelerations(system, work, sample%q, sample%v, sample%a)
            call add_parts_of_power(system, work, sample%q, sample%v, t - outcome%summed, outcome%net_work)
         end if
         work%evaluations = before(1)
         work%matrix%factorisations = before(2)
      end associate
   end subroutine add_exchange

   !> Energy that counts as none, eq. (7.2).
   subroutine find_no_energy(scene, sample, outcome)
      type(scene_type), intent(inout) :: scene
      !> At the start; its accelerations are scratch
      type(sample_type), intent(inout) :: sample
      type(outcome_type), intent(inout) :: outcome
      real(wp), parameter :: part = 1.0e-8_wp
      real(wp) :: kinetic, potential
      integer :: i
      associate (system => scene%system, dynamics => scene%system%model%dynamics)
         sample%a = 0.0_wp
         do i = 1, size(system%layout%q)
            sample%a(system%layout%q(i)) = system%model%length/(dynamics%end - dynamics%start)
         end do
         call mechanical_energy(system, scene%work, sample%q, sample%a, kinetic, potential)
         outcome%no_energy = part*(kinetic + abs(potential))
      end associate
   end subroutine find_no_energy

end module limber_scene_sampling
