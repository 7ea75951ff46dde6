!> limber run with a TARGET. With the model and the tolerance that keep it. Floor: commands.
module limber_commands_target_run
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise, status_deck, status_interrupted
   use limber_base_signals, only: catch_signals, release_signals
   use limber_base_text, only: as_text, newline
   use limber_accuracy_advice, only: apply_advice
   use limber_commands_advise, only: advice_table, target_of
   use limber_commands_batch, only: batch_type
   use limber_analysis_run_report, only: closing_report, energy_warning, what_is_left
   use limber_analysis_chosen_integrator, only: new_integrator
   use limber_analysis_error_estimate, only: kept_type
   use limber_analysis_estimate_report, only: record_estimate, estimate_table
   use limber_monitor_function_report, only: ring_warnings
   use limber_scene_outcome, only: all_warnings
   use limber_monitor_model_ranges, only: range_warnings
   use limber_accuracy_reached_target, only: reached_type
   use limber_analysis_provenance, only: open_history, record_outcome
   use limber_scene_scalar_values, only: scalar_lines, scalar_warnings
   use limber_scene_first_scene, only: build_scene
   use limber_scene_scene, only: scene_type
   use limber_accuracy_target_search, only: reach_target
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_integrator_integrator, only: integrator_type
   use limber_model_run_scalars, only: add_usual_scalars
   use limber_output_history, only: history_type
   implicit none
   private
   public :: run_to_target

contains

   !> Runs a deck with the model that its target asks for.
   subroutine run_to_target(path, results, force, quiet, batch, scene, history, report, error)
      !> The deck, and the result file, as in `run_one`
      character(*), intent(in) :: path, results
      logical, intent(in) :: force, quiet
      type(batch_type), intent(inout) :: batch
      !> With its deck as it was read; on return as it was run at last
      type(scene_type), intent(inout) :: scene
      type(kept_type), intent(inout) :: history
      character(:), allocatable, intent(out) :: report
      !> A deck that cannot be used (status 2), a target that no rung keeps (status 3), or a signal during the search (status 4)
      type(error_type), allocatable, intent(out) :: error
      type(reached_type) :: reached
      type(error_type), allocatable :: write_error
      class(integrator_type), allocatable :: integrator
      character(:), allocatable :: table
      real(wp) :: reading
      integer :: k
      report = ''
      reading = scene%reading
      call check_target(path, scene, force, results, error)
      if (batch%guarded) call catch_signals()
      if (.not. allocated(error)) call reach_target(scene%deck, target_of(scene%deck), quiet, reached, error)
      if (batch%guarded) call release_signals()
      if (.not. allocated(error)) call build_reached(reached, scene, error)
      if (allocated(error)) return
      scene%reading = reading
      if (batch%usual_scalars) call add_usual_scalars(scene%system%model)
      if (size(scene%system%model%scalars) > 0) call history%summarise(size(scene%system%model%channels))
      if (allocated(reached%interruption) .and. .not. allocated(reached%outcome)) then
         call raise(error, path//': '//interruption_text(reached, scene)//newline// &
            & '   No results were written.', status_interrupted)
         return
      end if
      call open_history(scene, results, force, history%history_type, error, batch%unkept)
      do k = 1, reached%samples%samples
         if (allocated(error)) return
         call history%take(reached%samples%times(k), reached%samples%values(:, k), error)
      end do
      if (allocated(error)) return
      batch%error = reached%error
      if (reached%done .and. allocated(reached%outcome%unfollowed)) deallocate (reached%outcome%unfollowed)
      scene%warnings = scene%warnings//all_warnings(reached%outcome)
      if (allocated(reached%outcome%indicators)) call add_ranges(reached, scene)
      if (reached%done) scene%warnings = scene%warnings//unverified_warning(reached)
      call record_target(reached, history%history_type, error)
      if (allocated(error)) return
      scene%warnings = scene%warnings//energy_warning(reached%outcome, scene%system%model%dynamics)
      call new_integrator(scene%system%model%dynamics, integrator)
      integrator%statistics = reached%statistics
      if (allocated(reached%estimate%values)) call record_estimate(reached%estimate, scene%system%model%channels, &
         & history%history_type, error)
      if (allocated(error)) return
      if (allocated(reached%interruption)) then
         call record_outcome(scene, reached%outcome, reached%statistics, interruption_text(reached, scene), history%history_type, &
            & write_error)
         call raise(error, path//': '//interruption_text(reached, scene)//what_is_left(results, batch%unkept, &
            & history%history_type, write_error), status_interrupted)
         return
      end if
      if (.not. reached%done) then
         call record_outcome(scene, reached%outcome, reached%statistics, reached%reason, history%history_type, write_error)
         call raise(error, path//': '//reached%reason//reached%path//what_is_left(results, batch%unkept, &
            & history%history_type, write_error))
         return
      end if
      scene%warnings = scene%warnings//scalar_warnings(scene%system%model, history)
      call record_outcome(scene, reached%outcome, reached%statistics, '', history%history_type, error)
      table = estimate_table(reached%estimate, scene%system%model%channels, reached%samples)
      report = scene%warnings//closing_report(path, scene, reached%outcome, integrator, results)// &
         & scalar_lines(scene%system%model, history)//newline//advice_table(reached%advice, scene, .true.)//reached%path// &
         & verified_line(reached)//newline//table
   end subroutine run_to_target

   !> Warnings of the ranges of models. What finer runs have verified needs none; a rigid beam that none has shown to bend does, and
   !> functions of the strain, of which no run has many.
   subroutine add_ranges(reached, scene)
      type(reached_type), intent(inout) :: reached
      type(scene_type), intent(inout) :: scene
      character(:), allocatable :: rings
      associate (indicators => reached%outcome%indicators, model => scene%system%model)
         rings = ring_warnings(indicators%functions, model)
         reached%rings = rings /= ''
         if (reached%unverified /= '' .or. reached%believed .or. .not. reached%done) rings = range_warnings(indicators, model)
      end associate
      scene%warnings = scene%warnings//rings
   end subroutine add_ranges

   !> What a search had found when a signal ended it, and what can be done with that.
   function interruption_text(reached, scene) result(text)
      type(reached_type), intent(in) :: reached
      !> With the model of the setting that it was at
      type(scene_type), intent(in) :: scene
      character(:), allocatable :: text
      text = 'the search for TARGET='//as_text(reached%advice%target, 2)//' was '//reached%interruption//', after '// &
         & as_text(reached%runs)//' runs; it has no checkpoints and begins anew'//newline
      if (reached%done) then
         text = text//'   The target is '//status_words(reached)//', with an error of '//as_text(reached%error, 2)// &
            & ', by this setting; whether less would do was still being tried.'
      else if (reached%error > 0.0_wp .and. reached%error < 1.0e3_wp) then
         text = text//'   None was found so far that keeps the target; this one errs by '//as_text(reached%error, 2)// &
            & reached%place//'.'
      else
         text = text//'   None was found so far that keeps the target; this one was being tried.'
      end if
      text = text//' Written into the deck in place of TARGET it runs without a search, and can then go on after a signal.'// &
         & newline//advice_table(reached%advice, scene, reached%done)//reached%path
   end function interruption_text

   !> What speaks against a target before anything runs: a deck that is wrong, and a result that is there already.
   subroutine check_target(path, scene, force, results, error)
      character(*), intent(in) :: path, results
      type(scene_type), intent(in) :: scene
      logical, intent(in) :: force
      type(error_type), allocatable, intent(out) :: error
      type(scene_type) :: trial
      type(diagnostics_type) :: diagnostics
      logical :: exists
      trial%deck = scene%deck
      call build_scene(trial, diagnostics, error)
      if (allocated(error)) return
      if (.not. trial%system%model%dynamics%wanted) call raise(error, path// &
         & ': nothing to run; add an analysis, such as *DYNAMICS (limber help DYNAMICS)', status_deck)
      if (size(trial%system%model%channels) == 0 .and. .not. allocated(error)) call raise(error, path// &
         & ': TARGET is for channels; add an *OUTPUT block (limber help OUTPUT)', status_deck)
      inquire (file=results, exist=exists)
      if (exists .and. .not. (force .or. allocated(error))) call raise(error, results// &
         & ' is there already; use --force to replace it', status_deck)
   end subroutine check_target

   !> A warning of what the estimated errors do not contain; empty if they contain all.
   function unverified_warning(reached) result(text)
      type(reached_type), intent(in) :: reached
      character(:), allocatable :: text
      text = ''
      if (reached%unverified == '') return
      text = 'warning: TARGET='//as_text(reached%advice%target, 2)//' is kept by the integration'
      if (size(reached%advice%rungs) > 0) text = text//' and by the models that limber chooses'
      text = text//' only: the model of '//reached%unverified//' is fixed by the deck and not verified; compare with more'
      text = text//' modes and elements; damp by RAYLEIGH BETA'//newline
   end function unverified_warning

   !> What was asked for, and whether it is kept, in words: 'kept', 'kept but for vibrations along beams', 'of the
   !> integration only', 'not kept'.
   subroutine record_target(reached, history, error)
      type(reached_type), intent(in) :: reached
      type(history_type), intent(inout) :: history
      type(error_type), allocatable, intent(out) :: error
      call history%put_attribute('/run', 'target', reached%advice%target, error)
      if (.not. allocated(error)) call history%put_attribute('/run', 'target_error', reached%error, error)
      if (.not. allocated(error)) call history%put_attribute('/run', 'target_status', status_words(reached), error)
      if (.not. allocated(error) .and. reached%unverified /= '') &
         & call history%put_attribute('/run', 'target_unverified', reached%unverified, error)
   end subroutine record_target

   pure function status_words(reached) result(text)
      type(reached_type), intent(in) :: reached
      character(:), allocatable :: text
      text = 'kept'
      if (reached%unverified /= '') text = 'of the integration only'
      if (reached%unverified /= '' .and. size(reached%advice%rungs) > 0) text = 'of the integration and of chosen models only'
      if (reached%rings) text = text//' but for vibrations along beams'
      if (.not. reached%done) text = 'not kept'
   end function status_words

   !> What was verified, a line of the report.
   function verified_line(reached) result(text)
      type(reached_type), intent(in) :: reached
      character(:), allocatable :: text
      text = newline//'   TARGET='//as_text(reached%advice%target, 2)//': '//status_words(reached)//', with an error of '// &
         & as_text(reached%error, 2)
      if (reached%fixed /= '') text = text//newline//'   what the deck fixes of '//reached%fixed//' makes '// &
         & as_text(reached%of_fixed, 2)//' of it, by a run aside with more'
   end function verified_line

   !> The scene as it was run at last.
   subroutine build_reached(reached, scene, error)
      type(reached_type), intent(in) :: reached
      !> With its deck as it was read
      type(scene_type), intent(inout) :: scene
      type(error_type), allocatable, intent(out) :: error
      type(diagnostics_type) :: diagnostics
      call apply_advice(reached%advice, scene%deck)
      call build_scene(scene, diagnostics, error)
   end subroutine build_reached

end module limber_commands_target_run
