!> Integrators of a motion: that of the deck, and another one in its place. Floor: analysis.
module limber_analysis_chosen_integrator
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_analysis_cost_watch, only: costs_type
   use limber_integrator_adams, only: adams_type
   use limber_integrator_alpha, only: alpha_type
   use limber_integrator_conserving, only: conserving_type
   use limber_integrator_integrator, only: integrator_type
   use limber_integrator_radau, only: radau_type
   use limber_model_model, only: dynamics_type
   use limber_scene_sampling, only: sample_type
   use limber_scene_scene, only: scene_type
   implicit none
   private
   public :: new_integrator, replace_integrator

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

   !> Puts another integrator in the place of one, at the state of a sample.
   subroutine replace_integrator(scene, dynamics, costs, t, sample, integrator, error)
      type(scene_type), intent(inout) :: scene
      type(dynamics_type), intent(in) :: dynamics
      !> What the other is; the same as at first if nothing has changed it
      type(costs_type), intent(in) :: costs
      real(wp), intent(in) :: t
      !> With the work put in so far
      type(sample_type), intent(in) :: sample
      class(integrator_type), allocatable, intent(inout) :: integrator
      type(error_type), allocatable, intent(out) :: error
      class(integrator_type), allocatable :: other
      type(dynamics_type) :: choice
      choice = dynamics
      if (allocated(costs%now)) choice%integrator = costs%now
      if (allocated(costs%now)) choice%tolerance = costs%tolerance(dynamics%tolerance)
      call new_integrator(choice, other)
      other%statistics = integrator%statistics
      other%work_at_start = sample%w
      other%input%asked = integrator%input%asked
      other%speeds_asked = integrator%speeds_asked
      other%ringing = integrator%ringing
      other%input%passing = integrator%input%passing
      other%input%throughput = integrator%input%throughput
      other%input%largest = integrator%input%largest
      call other%start(scene%system, scene%work, t, dynamics%end - dynamics%start, sample%q, sample%v, error)
      call move_alloc(other, integrator)
   end subroutine replace_integrator

end module limber_analysis_chosen_integrator
