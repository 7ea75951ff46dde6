!> Report of a run. Floor: analysis.
module limber_analysis_run_report
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text, newline
   use limber_model_model, only: dynamics_type
   use limber_scene_outcome, only: outcome_type, energy_scale, passing_scale, allowed_imbalance
   use limber_scene_scene, only: scene_type, mobility_line, inner_joints
   use limber_integrator_integrator, only: integrator_type
   use limber_output_history, only: history_type
   implicit none
   private
   public :: closing_report, energy_warning, what_is_left

contains

   !> Where the results of a run are that could not finish.
   pure function what_is_left(results, unkept, history, write_error) result(text)
      character(*), intent(in) :: results
      logical, intent(in) :: unkept
      !> Closed
      type(history_type), intent(in) :: history
      !> Allocated if not all of it could be written
      type(error_type), intent(in), allocatable :: write_error
      character(:), allocatable :: text
      text = ''
      if (unkept) return
      if (.not. (allocated(write_error) .or. history%failed)) then
         text = newline//'   What was computed up to there is in '//results//', marked incomplete.'
      else if (history%safe > 0) then
         text = newline//'   '//results//' has the first '//as_text(history%safe)//' samples, marked incomplete; '// &
            & 'more could not be written.'
      else
         text = newline//'   Nothing of it could be written to '//results//'.'
      end if
   end function what_is_left

   !> A warning if energy has come or gone from nowhere: the one check that every run has. Empty if all is well.
   pure function energy_warning(outcome, dynamics) result(text)
      type(outcome_type), intent(in) :: outcome
      type(dynamics_type), intent(in) :: dynamics
      character(:), allocatable :: text, cause, unable, remedy
      real(wp) :: scale
      text = ''
      scale = energy_scale(outcome)
      if (outcome%imbalance > allowed_imbalance*scale) then
         cause = ''
         if (outcome%shows_work) cause = ', or the errors of a work that goes to and fro add up'
         unable = 'the tolerance does'
         remedy = 'a tenth of TOLERANCE'
         if (dynamics%fixed_step > 0.0_wp) then
            unable = 'the steps do'
            remedy = dynamics%finer()//', or without it'
         end if
         text = 'warning: the energy balance is off by '//as_text(100*outcome%imbalance/scale, 2)// &
            & ' % of '//trim(merge('the largest energy  ', 'the energy exchanged', scale <= outcome%largest_energy))// &
            & ': the integrator has damped or fed vibrations that '//unable//' not resolve'//cause//'; compare with a'// &
            & ' run at '//remedy//newline
      else if (outcome%imbalance > allowed_imbalance*passing_scale(outcome)) then
         scale = outcome%moved_time/outcome%duration
         text = 'warning: the energy balance is off by '//as_text(100*outcome%imbalance/scale, 2)//' % of what it is in'// &
            & ' the mean: for a short time it is '//as_text(outcome%fastest/scale, 2)//' times as large and more, and'// &
            & ' errors that are small beside that are not small beside the motion that follows, which goes on too fast or too'// &
            & ' slowly; use '//dynamics%finer()//', or INTEGRATOR=RADAU'//newline
      end if
   end function energy_warning

   !> Time, steps, residuals, energy balance, where the file is.
   function closing_report(path, scene, outcome, integrator, results) result(text)
      character(*), intent(in) :: path
      type(scene_type), intent(in) :: scene
      type(outcome_type), intent(in) :: outcome
      class(integrator_type), intent(in) :: integrator
      character(*), intent(in) :: results
      character(:), allocatable :: text
      associate (statistics => integrator%statistics, units => scene%system%model%units)
         text = path//': '//scene%system%model%heading//newline
         if (scene%system%model%dynamics%reason /= '') text = text//'   '//scene%system%model%dynamics%integrator//', chosen: '// &
            & scene%system%model%dynamics%reason//newline
         text = text//'   '//mobility_line(scene%assembly, inner_joints(scene%system%model))//newline
         text = text//'   reached t = '//as_text(outcome%reached, 8)//' '//units%time//' in '//as_text(statistics%steps)// &
            & ' steps ('//as_text(statistics%rejected)//' rejected), '//as_text(statistics%evaluations)//' evaluations'//newline// &
            & '   '//as_text(outcome%cpu, 3)//' s CPU in the time loop; '//as_text(scene%reading + scene%building + &
            & scene%assembling, 3)//' s before it'//newline// &
            & '   constraints: position '//as_text(outcome%position_residual, 2)//' '//units%length//', velocity '// &
            & as_text(outcome%velocity_residual, 2)//' '//units%length//'/'//units%time//' at worst'//newline// &
            & '   energy balance: '//as_text(outcome%imbalance, 2)//' of at most '//as_text(outcome%largest_energy, 3)//newline
         text = text//'   '//as_text(outcome%samples)//' samples in '//results
         if (size(scene%system%model%events) > 0) text = text//outcome%events%report(scene%system%model%events, units%time)
      end associate
   end function closing_report

end module limber_analysis_run_report
