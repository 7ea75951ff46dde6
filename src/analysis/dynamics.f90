!> The dynamic analysis: lets the integrator run from the assembled state to the end and records a sample at each of the
!> asked times, projected onto the constraints. Floor: analysis.
module limber_analysis_dynamics
   use limber_base_kinds, only: wp, long
   use limber_base_error, only: error_type, raise
   use limber_base_text, only: as_text
   use limber_analysis_scene, only: scene_type, seconds_since
   use limber_integrator_adams, only: adams_type
   use limber_integrator_alpha, only: alpha_type
   use limber_integrator_conserving, only: conserving_type
   use limber_integrator_radau, only: radau_type
   use limber_integrator_integrator, only: integrator_type
   use limber_model_scene, only: dynamics_type
   use limber_output_channels, only: recorder_type, new_recorder, follow_angles, channel_values
   use limber_output_progress, only: progress_type
   use limber_output_sink, only: sink_type
   use limber_system_dynamics, only: linearise, accelerations, project_position, project_velocity, position_residual, &
      & velocity_residual, mechanical_energy
   implicit none
   private
   public :: run_dynamics, outcome_type, new_integrator

   !> What a run leaves behind besides its history
   type :: outcome_type
      !> Time reached, and samples taken
      real(wp) :: reached = 0.0_wp
      integer(long) :: samples = 0
      !> Wall and CPU seconds of the time loop
      real(wp) :: wall = 0.0_wp, cpu = 0.0_wp
      !> Largest constraint residuals at a sample: position [length or 1], velocity [the same per time]
      real(wp) :: position_residual = 0.0_wp, velocity_residual = 0.0_wp
      !> Mechanical energy at the start and the end, and work put in
      real(wp) :: first_energy = 0.0_wp, last_energy = 0.0_wp, work = 0.0_wp
      !> Largest |energy - first energy - work| at a sample, and the largest energy that it compares with
      real(wp) :: imbalance = 0.0_wp, largest_energy = 0.0_wp
   end type outcome_type

   !> Scratch of the sampling, allocated once
   type :: sample_type
      real(wp), allocatable :: q(:), v(:), a(:), change(:), values(:)
      real(wp) :: w = 0.0_wp
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
      integrator%tolerance = dynamics%tolerance
      integrator%initial_step = dynamics%initial_step
      integrator%maximum_step = dynamics%maximum_step
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
      integer(long) :: tick
      real(wp) :: cpu
      call system_clock(tick)
      call cpu_time(cpu)
      associate (nq => scene%system%layout%nq, dynamics => scene%system%model%dynamics)
         allocate (sample%q(nq), sample%v(nq), sample%a(nq), sample%change(nq), sample%values(size(scene%system%model%channels)))
         sample%a = 0.0_wp
         recorder = new_recorder(scene%system, scene%q)
         outcome%reached = dynamics%start
         call integrator%start(scene%system, scene%work, dynamics%start, dynamics%end - dynamics%start, scene%q, scene%v, error)
         if (.not. allocated(error)) call advance(scene, dynamics, integrator, recorder, sample, history, progress, outcome, error)
      end associate
      outcome%wall = seconds_since(tick)
      outcome%cpu = cpu_now() - cpu
      integrator%statistics%evaluations = scene%work%evaluations
      integrator%statistics%factorisations = scene%work%matrix%factorisations
   end subroutine run_dynamics

   !> The time loop.
   subroutine advance(scene, dynamics, integrator, recorder, sample, history, progress, outcome, error)
      type(scene_type), intent(inout) :: scene
      type(dynamics_type), intent(in) :: dynamics
      class(integrator_type), intent(inout) :: integrator
      type(recorder_type), intent(inout) :: recorder
      type(sample_type), intent(inout) :: sample
      class(sink_type), intent(inout) :: history
      type(progress_type), intent(inout) :: progress
      type(outcome_type), intent(inout) :: outcome
      type(error_type), allocatable, intent(out) :: error
      integer :: next
      real(wp) :: stop
      sample%q = scene%q
      sample%v = scene%v
      call record(scene, dynamics%start, integrator, recorder, sample, history, outcome, error)
      next = 1
      do while (next <= dynamics%outputs .and. .not. allocated(error))
         if (integrator%statistics%steps >= dynamics%maximum_steps) then
            call raise(error, 'MAXIMUM STEPS='//as_text(dynamics%maximum_steps)//' are used up at t = '// &
               & as_text(integrator%t, 6)//'; give more, or a looser TOLERANCE')
            exit
         end if
         stop = dynamics%end
         if (integrator%ends_on_samples) stop = sample_time(dynamics, next)
         call integrator%step(scene%system, scene%work, stop, error)
         if (allocated(error)) exit
         call integrator%interpolate(integrator%t, sample%q, sample%v, sample%w)
         call follow_angles(recorder, scene%system, sample%q)
         do while (next <= dynamics%outputs .and. sample_time(dynamics, next) <= integrator%t)
            call integrator%interpolate(sample_time(dynamics, next), sample%q, sample%v, sample%w)
            call record(scene, sample_time(dynamics, next), integrator, recorder, sample, history, outcome, error)
            if (allocated(error)) exit
            next = next + 1
         end do
         call progress%update(integrator%t)
      end do
      outcome%reached = integrator%t
   end subroutine advance

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
      real(wp) :: residual
      call project_position(scene%system, scene%work, t, sample%q, sample%change, 1.0e-14_wp, residual)
      call linearise(scene%system, scene%work, t, sample%q, error)
      if (allocated(error)) return
      if (.not. integrator%ends_on_samples) call project_velocity(scene%system, scene%work, sample%v, sample%change, residual)
      call check_sample(scene, sample, outcome)
      if (recorder%needs_accelerations) call accelerations(scene%system, scene%work, sample%q, sample%v, sample%a)
      recorder%work = sample%w
      call channel_values(recorder, scene%system, scene%work, t, sample%q, sample%v, sample%a, sample%values)
      call history%append(t, sample%values, error)
      outcome%samples = outcome%samples + 1
   end subroutine record

   !> Constraint residuals and energy balance of a sample.
   subroutine check_sample(scene, sample, outcome)
      type(scene_type), intent(inout) :: scene
      type(sample_type), intent(in) :: sample
      type(outcome_type), intent(inout) :: outcome
      real(wp) :: kinetic, potential, largest
      if (scene%system%nc > 0) then
         largest = position_residual(scene%system, scene%work)
         outcome%position_residual = max(outcome%position_residual, maxval(abs(scene%work%phi)))
         largest = velocity_residual(scene%system, scene%work, sample%v)
         outcome%velocity_residual = max(outcome%velocity_residual, maxval(abs(scene%work%gamma)))
      end if
      call mechanical_energy(scene%system, scene%work, sample%q, sample%v, kinetic, potential)
      if (outcome%samples == 0) outcome%first_energy = kinetic + potential
      outcome%last_energy = kinetic + potential
      outcome%work = sample%w
      outcome%imbalance = max(outcome%imbalance, abs(kinetic + potential - outcome%first_energy - sample%w))
      largest = max(kinetic, abs(potential - outcome%first_energy))
      outcome%largest_energy = max(outcome%largest_energy, largest)
   end subroutine check_sample

   !> CPU seconds of this process.
   real(wp) function cpu_now()
      call cpu_time(cpu_now)
   end function cpu_now

end module limber_analysis_dynamics
