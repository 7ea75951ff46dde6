!> Instants at which flexible bodies are monitored. Now and then, and on both sides of instants at which loads jump. Floor:
!> analysis.
module limber_analysis_looks
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_monitor_observation, only: observe
   use limber_scene_outcome, only: outcome_type
   use limber_scene_sampling, only: sample_type, balance_sample
   use limber_scene_scene, only: scene_type
   use limber_monitor_function_sudden, only: in_motion
   use limber_integrator_integrator, only: integrator_type
   use limber_model_model, only: dynamics_type
   use limber_multibody_equations_of_motion, only: linearise, accelerations
   implicit none
   private
   public :: look, look_at_end, observe_state

contains

   !> Observes the flexible bodies now and then. It is as dear as up to ten evaluations, which are not counted, and so seldom that
   !> the run hardly notices.
   subroutine look(scene, dynamics, integrator, kind, sample, outcome)
      type(scene_type), intent(inout) :: scene
      type(dynamics_type), intent(in) :: dynamics
      class(integrator_type), intent(in) :: integrator
      !> at_start or in_motion
      integer, intent(in) :: kind
      !> With the state at the end of a step
      type(sample_type), intent(inout) :: sample
      type(outcome_type), intent(inout) :: outcome
      !> Steps, and parts of the run, after which they are observed again; evaluations that lie between in any case
      integer, parameter :: steps = 32, parts = 50, evaluations = 32
      if (size(outcome%indicators%bodies) + size(outcome%indicators%functions%beams) == 0) return
      if (integrator%statistics%steps < sample%next_step .and. integrator%t < sample%next_look) return
      if (scene%work%evaluations < sample%next_evaluation) return
      sample%next_evaluation = scene%work%evaluations + evaluations
      sample%next_step = integrator%statistics%steps + steps
      sample%next_look = integrator%t + (dynamics%end - dynamics%start)/parts
      if (integrator%steps_over .and. kind == in_motion) then
         call observe_balanced(scene, integrator, kind, sample, outcome)
      else
         call observe_state(scene, integrator%t, kind, sample, outcome)
      end if
   end subroutine look

   !> Observes them in balance with the accelerations of the dense output: errors of the motion in stiff deflections are no forces.
   subroutine observe_balanced(scene, integrator, kind, sample, outcome)
      type(scene_type), intent(inout) :: scene
      class(integrator_type), intent(in) :: integrator
      !> As in `look`
      integer, intent(in) :: kind
      type(sample_type), intent(inout) :: sample
      type(outcome_type), intent(inout) :: outcome
      real(wp) :: q(size(sample%q))
      q = sample%q
      call balance_sample(scene, integrator%t, integrator, sample)
      call observe_state(scene, integrator%t, kind, sample, outcome)
      sample%q = q
   end subroutine observe_balanced

   !> Observes them at the end of a run of so few steps that hardly any other state has been seen.
   subroutine look_at_end(scene, integrator, sample, outcome)
      type(scene_type), intent(inout) :: scene
      class(integrator_type), intent(in) :: integrator
      !> With the last state
      type(sample_type), intent(inout) :: sample
      type(outcome_type), intent(inout) :: outcome
      integer, parameter :: few = 32
      if (size(outcome%indicators%bodies) + size(outcome%indicators%functions%beams) == 0) return
      if (integrator%statistics%steps < few) call observe_state(scene, integrator%t, in_motion, sample, outcome)
   end subroutine look_at_end

   !> Observes the flexible bodies at a state; the evaluations are not counted.
   subroutine observe_state(scene, t, kind, sample, outcome)
      type(scene_type), intent(inout) :: scene
      real(wp), intent(in) :: t
      !> What the state is: at_start, in_motion, before_break or behind_break
      integer, intent(in) :: kind
      !> With the state
      type(sample_type), intent(inout) :: sample
      type(outcome_type), intent(inout) :: outcome
      type(error_type), allocatable :: error
      integer :: before(2)
      associate (system => scene%system, work => scene%work)
         before = [work%evaluations, work%matrix%factorisations]
         call linearise(system, work, t, sample%q, error)
         if (.not. allocated(error)) then
            call accelerations(system, work, sample%q, sample%v, sample%a)
            outcome%indicators%functions%kind = kind
            call observe(outcome%indicators, system, work, t, sample%q, sample%v, sample%a)
         end if
         work%evaluations = before(1)
         work%matrix%factorisations = before(2)
      end associate
   end subroutine observe_state

end module limber_analysis_looks
