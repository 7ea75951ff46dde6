!> Errors that add up beside the tolerance. Those of many passages of laws, and those that are much of the own motion of a body; and
!> what else a run may tell at its end of the errors of its motion. Floor: analysis. Source: doc/theory, section 5.17.
module limber_analysis_added_errors
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_analysis_crossings, only: crossings_type, found_bend, found_jump
   use limber_analysis_turned_springs, only: turned_springs_type, start_springs, note_springs, springs_warning
   use limber_analysis_own_motions, only: motions_type, start_motions, note_place, is_due, note_errors, motion_warning
   use limber_analysis_passing_errors, only: passages_type, start_passages, note_rates, looks_at, note_passage, count_passage, &
      & passing_warning
   use limber_analysis_step_defects, only: defect_type, new_defect, begin_step, find_defect
   use limber_integrator_integrator, only: integrator_type
   use limber_model_model, only: dynamics_type
   use limber_monitor_run_monitor, only: jump_watch_type, scale_warning, phase_warning, slip_warning
   use limber_multibody_system, only: system_type, workspace_type
   use limber_scene_outcome, only: outcome_type, warn
   implicit none
   private
   public :: added_errors_type, start_added, begin_added, note_added, tell_errors, tell_passages

   !> What is remembered
   type :: added_errors_type
      !> Whether there are laws of the motion, or bodies that loads alone connect; without them nothing is looked at
      logical :: wanted = .false.
      type(defect_type) :: defect
      type(passages_type) :: passages
      type(motions_type) :: motions
      type(turned_springs_type) :: springs
   contains
      procedure :: exchange => exchange_added
   end type added_errors_type

contains

   !> Begins a run.
   subroutine start_added(self, system, crossings, t, q, v)
      type(added_errors_type), intent(out) :: self
      type(system_type), intent(in) :: system
      type(crossings_type), intent(in) :: crossings
      !> First state (nq)
      real(wp), intent(in) :: t, q(:), v(:)
      call start_motions(self%motions, system, q)
      call start_springs(self%springs, system, t, q, v)
      self%wanted = size(crossings%loads) > 0 .or. size(self%motions%body) > 0
      if (.not. self%wanted) return
      call new_defect(self%defect, system)
      call begin_step(self%defect, t, q, v)
      call start_passages(self%passages, system, size(crossings%loads))
   end subroutine start_added

   !> Takes a state for the start of the next step.
   pure subroutine begin_added(self, t, q, v)
      type(added_errors_type), intent(inout) :: self
      real(wp), intent(in) :: t, q(:), v(:)
      if (self%wanted) call begin_step(self%defect, t, q, v)
   end subroutine begin_added

   !> Takes a step up to a state.
   subroutine note_added(self, system, work, integrator, crossings, end, t, q, v)
      type(added_errors_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      class(integrator_type), intent(inout) :: integrator
      type(crossings_type), intent(in) :: crossings
      !> End of the run, time of the state
      real(wp), intent(in) :: end, t
      !> Coordinates and velocities (nq), as the integrator has them
      real(wp), intent(inout) :: q(:), v(:)
      real(wp) :: put_in
      logical :: passes, small, found
      if (size(self%springs%loads) > 0) call note_springs(self%springs, system, t, q, v)
      if (.not. self%wanted) return
      call note_place(self%motions, system, q)
      passes = looks_at(self%passages, crossings)
      small = is_due(self%motions, system)
      if (passes .or. small) then
         call find_defect(self%defect, system, work, integrator, t, q, v, found)
         if (found .and. passes) call note_passage(self%passages, self%defect)
         if (found .and. small) call note_errors(self%motions, system, work, self%defect, t, end - t)
         ! What comes behind finds the kinematics where they were
         call integrator%interpolate(t, q, v, put_in)
         call integrator%complete(system, work, t, q, v)
      end if
      if (size(crossings%loads) > 0) then
         call note_rates(self%passages, system, q, v)
         if (crossings%found == found_bend .or. crossings%found == found_jump) call count_passage(self%passages, crossings)
      end if
      call begin_step(self%defect, t, q, v)
   end subroutine note_added

   !> Tells of errors of passages of laws and of own motions.
   subroutine tell_passages(self, system, crossings, dynamics, outcome)
      type(added_errors_type), intent(in) :: self
      type(system_type), intent(in) :: system
      type(crossings_type), intent(in) :: crossings
      type(dynamics_type), intent(in) :: dynamics
      type(outcome_type), intent(inout) :: outcome
      if (size(crossings%loads) > 0) call tell(outcome, passing_warning(self%passages, system, crossings, dynamics))
      call tell(outcome, motion_warning(self%motions, system, dynamics))
      call tell(outcome, springs_warning(self%springs, system))
   end subroutine tell_passages

   !> Tells at the end of a run of errors of its motion.
   subroutine tell_errors(self, system, crossings, dynamics, watch, tolerance, t, outcome)
      type(added_errors_type), intent(in) :: self
      type(system_type), intent(in) :: system
      type(crossings_type), intent(in) :: crossings
      type(dynamics_type), intent(in) :: dynamics
      type(jump_watch_type), intent(in) :: watch
      !> Local error allowed, end of the run
      real(wp), intent(in) :: tolerance, t
      type(outcome_type), intent(inout) :: outcome
      call tell_passages(self, system, crossings, dynamics, outcome)
      call tell(outcome, scale_warning(watch, system, tolerance, t))
      if (allocated(outcome%turned)) call tell(outcome, phase_warning(system, tolerance, maxval(abs(outcome%turned)), &
         & dynamics%end - dynamics%start, outcome%ahead))
      if (allocated(outcome%slip)) call tell(outcome, slip_warning(watch, system, dynamics, outcome%slip, outcome%slip_time, &
         & outcome%slip_speed))
   end subroutine tell_errors

   subroutine tell(outcome, text)
      type(outcome_type), intent(inout) :: outcome
      character(*), intent(in) :: text
      if (text /= '') call warn(outcome, text)
   end subroutine tell

   !> Saves or restores its memory.
   subroutine exchange_added(self, snapshot)
      class(added_errors_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%exchange('added_t', self%defect%t)
      call snapshot%keep('added_q', self%defect%q)
      call snapshot%keep('added_v', self%defect%v)
      call self%passages%exchange(snapshot)
      call self%motions%exchange(snapshot)
      call self%springs%exchange(snapshot)
      ! Not saved: wanted
   end subroutine exchange_added

end module limber_analysis_added_errors
