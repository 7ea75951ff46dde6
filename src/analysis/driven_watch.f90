!> Warnings of driven motions with quasi-static deflections. Models used beyond their range and functions that are too few, as of
!> any other analysis; channels that bodies with modes get wrong, as of *STATICS; and equilibria that are not stable. Floor:
!> analysis.
!>
!>     call start_driven_watch(self, scene, step, outcome)
!>     call observe_driven(self, scene, held, sample, v, a, outcome) ! at each sample
!>     call tell_driven(self, scene, step, outcome)                  ! at the end
module limber_analysis_driven_watch
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, newline
   use limber_monitor_indicator_start, only: start_indicators
   use limber_monitor_observation, only: observe
   use limber_scene_outcome, only: outcome_type
   use limber_scene_scene, only: scene_type
   use limber_analysis_static_aside, only: static_aside_type, aside_sample_type, start_static_aside, compare_sample, static_warning
   use limber_analysis_left_inertia, only: left_inertia_type, balance_type, start_left_inertia, compare_inertia, tell_left_inertia
   use limber_model_analyses, only: title
   use limber_model_model, only: analysis_step_type
   use limber_multibody_free_motions, only: free_motions_type, find_freedom, lowest_stiffness, motion_text
   use limber_multibody_driven_motion, only: driven_motion_type
   use limber_multibody_sparse_eigenmodes, only: is_large
   use limber_output_channel_values, only: recorder_type
   implicit none
   private
   public :: driven_watch_type, start_driven_watch, observe_driven, tell_driven

   !> Stiffness beside the largest one below which an equilibrium is not stable
   real(wp), parameter :: none_of_largest = 1.0e-13_wp
   !> Samples at which channels are compared, about
   integer, parameter :: compared = 50

   !> What was seen so far
   type :: driven_watch_type
      type(static_aside_type) :: aside
      type(left_inertia_type) :: inertia
      !> The last sample; every so many are compared; how many there were
      type(aside_sample_type) :: last
      integer :: stride = 1, samples = 0
      type(free_motions_type) :: freedom
      !> The first equilibrium that is not stable: when, and its softest motion (nw); unallocated: none
      real(wp) :: unstable_at = 0.0_wp
      real(wp), allocatable :: motion(:)
   end type driven_watch_type

contains

   !> Begins to watch.
   subroutine start_driven_watch(self, scene, step, outcome)
      type(driven_watch_type), intent(out) :: self
      type(scene_type), intent(in) :: scene
      type(analysis_step_type), intent(in) :: step
      !> Gets indicators
      type(outcome_type), intent(inout) :: outcome
      allocate (outcome%indicators)
      call start_indicators(outcome%indicators, scene%system)
      call start_static_aside(self%aside, scene)
      call start_left_inertia(self%inertia, scene, step)
      self%stride = max(1, step%dynamics%outputs/compared)
   end subroutine start_driven_watch

   !> Takes a sample in equilibrium; the workspace is that of this state, and its kinematics are placed there on return.
   subroutine observe_driven(self, scene, held, recorder, sample, v, a, outcome)
      type(driven_watch_type), intent(inout) :: self
      type(scene_type), intent(inout) :: scene
      !> Linearised there
      type(driven_motion_type), intent(in) :: held
      type(recorder_type), intent(in) :: recorder
      type(aside_sample_type), intent(in) :: sample
      !> Velocities and accelerations (nq)
      real(wp), intent(in) :: v(:), a(:)
      type(outcome_type), intent(inout) :: outcome
      call observe(outcome%indicators, scene%system, scene%work, sample%t, sample%q, v, a)
      call observe_stability(self, scene, held, sample%t)
      self%last = sample
      if (modulo(self%samples, self%stride) == 0) then
         if (self%aside%used) call compare_sample(self%aside, scene, sample)
         if (self%inertia%used) call compare_inertia(self%inertia, scene, recorder, balance_type(sample%t, sample%q, held%w, &
            & held%a, sample%lambda, sample%values))
      end if
      self%samples = self%samples + 1
   end subroutine observe_driven

   !> Whether the deflections are in stable equilibrium.
   subroutine observe_stability(self, scene, held, t)
      type(driven_watch_type), intent(inout) :: self
      type(scene_type), intent(in) :: scene
      type(driven_motion_type), intent(in) :: held
      real(wp), intent(in) :: t
      real(wp) :: lowest, largest, motion(scene%system%layout%nw)
      if (allocated(self%motion) .or. is_large(scene%system) .or. all(scene%system%layout%n == 0)) return
      call find_freedom(scene%system, scene%work, .false., self%freedom)
      call lowest_stiffness(scene%system, held%tangent, self%freedom, lowest, largest, motion)
      if (lowest > -none_of_largest*largest) return
      self%motion = motion
      self%unstable_at = t
   end subroutine observe_stability

   !> Adds what is to be told to the warnings.
   subroutine tell_driven(self, scene, step, outcome)
      type(driven_watch_type), intent(in) :: self
      type(scene_type), intent(in) :: scene
      type(analysis_step_type), intent(in) :: step
      type(outcome_type), intent(inout) :: outcome
      if (.not. allocated(outcome%warnings)) outcome%warnings = ''
      if (allocated(self%motion)) outcome%warnings = outcome%warnings//'warning: '//title(step)//': the deflections at t = '// &
         & as_text(self%unstable_at, 8)//' are in balance, but not stably: '//motion_text(scene%system, self%motion)// &
         & ', as at buckling; *STATICS finds the load and stable deflections, *DYNAMICS what happens'//newline
      if (self%samples == 0) return
      call tell_left_inertia(self%inertia, scene, title(step), outcome)
      if (self%aside%used .and. .not. allocated(self%motion)) &
         & outcome%warnings = outcome%warnings//static_warning(self%aside, scene, title(step), self%last)
   end subroutine tell_driven

end module limber_analysis_driven_watch
