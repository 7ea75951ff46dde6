!> limber run. Deck -> model -> modes -> system -> integrator -> history, with a closing report. Floor: commands.
module limber_commands_run
   use limber_base_kinds, only: wp, long
   use limber_base_error, only: error_type, raise, status_deck, status_interrupted
   use limber_base_fault, only: add_fault, forget_fault
   use limber_base_signals, only: catch_signals, signal_came, signal_name
   use limber_base_text, only: as_text, newline
   use limber_commands_advise, only: target_of
   use limber_commands_batch, only: batch_type
   use limber_analysis_run_report, only: closing_report, energy_warning, what_is_left
   use limber_analysis_chosen_integrator, only: new_integrator
   use limber_analysis_dynamic_analysis, only: run_dynamics
   use limber_scene_channel_errors, only: magnitude
   use limber_analysis_error_estimate, only: kept_type, estimate_type, make_estimate
   use limber_analysis_estimate_report, only: record_estimate, estimate_warning, estimate_table
   use limber_scene_interruption, only: interruption_type, request_type
   use limber_scene_outcome, only: outcome_type, all_warnings
   use limber_monitor_model_ranges, only: range_warnings
   use limber_analysis_provenance, only: open_history, record_outcome, record_steps
   use limber_scene_scalar_values, only: scalar_values, scalar_lines, scalar_warnings
   use limber_scene_first_scene, only: build_scene
   use limber_scene_scene, only: scene_type, seconds_since
   use limber_analysis_analysis_steps, only: run_steps, passed_type
   use limber_commands_target_run, only: run_to_target
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_effective, only: effective_deck
   use limber_deck_parameters, only: override_type
   use limber_deck_reader, only: read_deck
   use limber_integrator_integrator, only: integrator_type
   use limber_integrator_statistics, only: step_statistics_type
   use limber_model_analyses, only: single_dynamics
   use limber_model_run_scalars, only: add_usual_scalars
   use limber_output_progress, only: progress_type
   use limber_output_sample_sink, only: memory_type
   implicit none
   private
   public :: run_deck, run_one, default_results

contains

   !> Runs a deck.
   subroutine run_deck(path, output, force, quiet, report, error, overrides, request)
      !> The deck, and the result file; empty: the deck's name with the ending .h5, in the working folder
      character(*), intent(in) :: path, output
      !> Whether an existing result may be replaced; whether the progress is not shown
      logical, intent(in) :: force, quiet
      !> What to tell the user
      character(:), allocatable, intent(out) :: report
      !> A deck that cannot be used (status 2), or a run that could not finish (status 3)
      type(error_type), allocatable, intent(out) :: error
      !> Values of parameters in place of those of the deck
      type(override_type), intent(in), optional :: overrides(:)
      !> Whether an interrupted run is to go on, and how often it is made sure that it can
      type(request_type), intent(in), optional :: request
      type(batch_type) :: batch
      batch%guarded = .true.
      if (present(request)) batch%request = request
      if (present(overrides)) then
         allocate (batch%overrides, source=overrides)
      else
         allocate (batch%overrides(0))
      end if
      if (output == '') then
         call run_one(path, default_results(path, '.h5'), force, quiet, batch, report, error)
      else
         call run_one(path, output, force, quiet, batch, report, error)
      end if
   end subroutine run_deck

   !> Runs a deck, by itself or as one of many.
   subroutine run_one(path, results, force, quiet, batch, report, error)
      !> The deck, and the result file
      character(*), intent(in) :: path, results
      logical, intent(in) :: force, quiet
      type(batch_type), intent(inout) :: batch
      character(:), allocatable, intent(out) :: report
      type(error_type), allocatable, intent(out) :: error
      type(scene_type) :: scene
      type(kept_type) :: history
      type(interruption_type) :: guard
      type(diagnostics_type) :: diagnostics
      logical :: done
      integer(long) :: tick
      real(wp) :: started
      call cpu_time(started)
      report = ''
      batch%error = -1.0_wp
      batch%cpu = 0.0_wp
      batch%warnings = ''
      call forget_fault()
      call system_clock(tick)
      call read_deck(path, scene%deck, diagnostics, batch%overrides)
      scene%reading = seconds_since(tick)
      if (diagnostics%count == 0 .and. target_of(scene%deck) > 0.0_wp) then
         call begin_guard(path, results, force, .false., batch, scene, guard, done, report, error)
         if (done .or. allocated(error)) return
         call run_to_target(path, results, force, quiet, batch, scene, history, report, error)
         if (allocated(scene%warnings)) call fill_batch()
         return
      end if
      call build_scene(scene, diagnostics, error, batch%library)
      call add_fault(error)
      if (allocated(error)) return
      if (.not. scene%system%model%dynamics%wanted) then
         call raise(error, path//': nothing to run; add an analysis, such as *DYNAMICS (limber help DYNAMICS)', status_deck)
         return
      end if
      if (batch%usual_scalars) call add_usual_scalars(scene%system%model)
      if (size(scene%system%model%scalars) > 0) call history%summarise(size(scene%system%model%channels))
      call history%watch_limit(batch%limit)
      ! One of many has no checkpoints: it ends, and is run again
      history%heeds_signals = .not. batch%guarded
      call begin_guard(path, results, force, .true., batch, scene, guard, done, report, error)
      if (done .or. allocated(error)) return
      call open_results(results, force .or. guard%anew, batch, scene, guard, history, error)
      if (allocated(error)) return
      if (single_dynamics(scene%system%model)) then
         call run_motion(path, results, quiet, batch, scene, guard, history, report, error)
      else
         call run_analyses(path, results, quiet, batch, scene, guard, history, report, error)
      end if
      call fill_batch()

   contains

      subroutine fill_batch()
         real(wp) :: now
         call cpu_time(now)
         batch%cpu = now - started
         batch%warnings = scene%warnings
         if (allocated(batch%scalars)) deallocate (batch%scalars)
         allocate (batch%scalars, source=scalar_values(scene%system%model, history))
      end subroutine fill_batch

   end subroutine run_one

   !> Looks for what an earlier run has left, unless this is one of many.
   subroutine begin_guard(path, results, force, continuable, batch, scene, guard, done, report, error)
      !> The deck, and the result file
      character(*), intent(in) :: path, results
      !> Whether results may be replaced; whether an interrupted run can go on
      logical, intent(in) :: force, continuable
      type(batch_type), intent(in) :: batch
      type(scene_type), intent(in) :: scene
      type(interruption_type), intent(inout) :: guard
      !> Whether there is nothing to do any more, and the report then says so
      logical, intent(out) :: done
      character(:), allocatable, intent(inout) :: report
      type(error_type), allocatable, intent(out) :: error
      done = .false.
      if (.not. batch%guarded) return
      guard%continuable = continuable
      if (continuable) guard%estimates = scene%system%model%accuracy%estimate .and. single_dynamics(scene%system%model)
      call guard%find(results, effective_deck(scene%deck), scene%deck%source%paths(), batch%request, force, done, &
         & error)
      if (done) report = path//': '//results//' is complete; there is nothing left to do'
   end subroutine begin_guard

   !> Makes the results file, or goes on with the one that is there.
   subroutine open_results(results, force, batch, scene, guard, history, error)
      character(*), intent(in) :: results
      logical, intent(in) :: force
      type(batch_type), intent(in) :: batch
      type(scene_type), intent(in) :: scene
      type(interruption_type), intent(in) :: guard
      type(kept_type), intent(inout) :: history
      type(error_type), allocatable, intent(out) :: error
      ! What is written from here on must not be cut short
      if (batch%guarded) call catch_signals()
      if (guard%restarting) then
         call open_history(scene, results, force, history%history_type, error, resume=guard%checkpoint%samples)
         history%safe = guard%samples
         if (allocated(error)) call drop_history(history)
         return
      end if
      call open_history(scene, results, force, history%history_type, error, batch%unkept)
      if (.not. batch%guarded .or. allocated(error)) return
      history%safe = guard%samples
      call history%put_attribute('/run', 'number', guard%checkpoint%run, error)
      if (.not. allocated(error)) call history%put_attribute('/run', 'checkpoints', 0, error)
   end subroutine open_results

   !> Closes a history that nothing is to be kept of: what stands under its name stays as it is.
   subroutine drop_history(history)
      type(kept_type), intent(inout) :: history
      type(error_type), allocatable :: ignored
      history%failed = .true.
      call history%finish(.false., '', ignored)
   end subroutine drop_history

   !> Runs a motion in time, and estimates its errors if that is asked for.
   subroutine run_motion(path, results, quiet, batch, scene, guard, history, report, error)
      !> The deck, and the result file
      character(*), intent(in) :: path, results
      logical, intent(in) :: quiet
      type(batch_type), intent(inout) :: batch
      type(scene_type), intent(inout) :: scene
      type(interruption_type), intent(inout) :: guard
      !> Open
      type(kept_type), intent(inout) :: history
      character(:), allocatable, intent(inout) :: report
      type(error_type), allocatable, intent(out) :: error
      class(integrator_type), allocatable :: integrator
      type(progress_type) :: progress
      type(outcome_type) :: outcome
      type(error_type), allocatable :: write_error
      character(:), allocatable :: table
      call keep_samples(scene, history)
      call new_integrator(scene%system%model%dynamics, integrator)
      if (.not. quiet) call progress%start(scene%system%model%dynamics%start, scene%system%model%dynamics%end, path)
      if (batch%guarded) then
         call guard%start()
         call run_dynamics(scene, integrator, history, progress, outcome, error, guard)
         scene%warnings = scene%warnings//guard%warning()
      else
         call run_dynamics(scene, integrator, history, progress, outcome, error)
      end if
      call add_fault(error)
      ! Of a checkpoint that does not fit nothing is kept
      if (allocated(guard%snapshot%missing)) history%failed = .true.
      if (.not. quiet) call progress%finish()
      scene%warnings = scene%warnings//all_warnings(outcome)
      scene%warnings = scene%warnings//range_warnings(outcome%indicators, scene%system%model)// &
         & energy_warning(outcome, scene%system%model%dynamics)//scalar_warnings(scene%system%model, history)
      table = ''
      if (.not. allocated(error)) call add_estimate(scene, integrator, outcome, quiet, history, batch%error, table, error)
      if (allocated(error)) then
         call record_outcome(scene, outcome, integrator%statistics, error%message, history%history_type, write_error)
         error%message = path//': '//error%message//what_is_left(results, batch%unkept, history%history_type, write_error)
         report = scene%warnings//path//': '
      else
         call record_outcome(scene, outcome, integrator%statistics, '', history%history_type, error)
         if (allocated(error)) error%message = error%message//what_is_left(results, batch%unkept, history%history_type, error)
         report = scene%warnings//guard%note_line(path)//closing_report(path, scene, outcome, integrator, results)// &
            & scalar_lines(scene%system%model, history)//table
      end if
      if (batch%guarded) call guard%finish(.not. allocated(error))
   end subroutine run_motion

   !> Runs a deck with several analyses, or another one than the motion in time.
   subroutine run_analyses(path, results, quiet, batch, scene, guard, history, report, error)
      !> The deck, and the result file
      character(*), intent(in) :: path, results
      logical, intent(in) :: quiet
      type(batch_type), intent(in) :: batch
      type(scene_type), intent(inout) :: scene
      type(interruption_type), intent(inout) :: guard
      !> Open
      type(kept_type), intent(inout) :: history
      character(:), allocatable, intent(inout) :: report
      type(error_type), allocatable, intent(out) :: error
      type(passed_type) :: passed
      type(outcome_type) :: outcome
      type(step_statistics_type) :: statistics
      type(error_type), allocatable :: write_error
      character(:), allocatable :: lines
      if (batch%guarded) then
         call guard%start()
         call run_steps(scene, path, quiet, history, passed, outcome, statistics, lines, error, guard)
         scene%warnings = scene%warnings//guard%warning()
      else
         call run_steps(scene, path, quiet, history, passed, outcome, statistics, lines, error)
      end if
      call add_fault(error)
      ! Of a checkpoint that does not fit nothing is kept
      if (allocated(guard%snapshot%missing)) history%failed = .true.
      if (allocated(outcome%indicators)) scene%warnings = scene%warnings//range_warnings(outcome%indicators, scene%system%model)
      scene%warnings = scene%warnings//scalar_warnings(scene%system%model, history)
      call record_steps(scene, passed, history%history_type, write_error)
      report = scene%warnings//guard%note_line(path)//path//': '//scene%system%model%heading//lines//newline//'   '// &
         & as_text(outcome%cpu, 3)//' s CPU; '//as_text(scene%reading + scene%building + scene%assembling, 3)//' s before it'// &
         & newline//'   '//as_text(outcome%samples)//' samples in '//results// &
         & outcome%events%report(scene%system%model%events, scene%system%model%units%time)// &
         & scalar_lines(scene%system%model, history)
      if (allocated(error)) then
         call record_outcome(scene, outcome, statistics, error%message, history%history_type, write_error)
         error%message = path//': '//error%message//what_is_left(results, batch%unkept, history%history_type, write_error)
      else if (allocated(write_error)) then
         call move_alloc(write_error, error)
      else
         call record_outcome(scene, outcome, statistics, '', history%history_type, error)
      end if
      if (batch%guarded) call guard%finish(.not. allocated(error))
   end subroutine run_analyses

   !> Lets the history keep its samples in memory if errors are to be estimated from them.
   subroutine keep_samples(scene, history)
      type(scene_type), intent(in) :: scene
      type(kept_type), intent(inout) :: history
      associate (model => scene%system%model)
         history%keeps = model%accuracy%estimate
         if (history%keeps) call history%memory%start(size(model%channels), model%dynamics%outputs + 1, huge(1.0_wp))
      end associate
   end subroutine keep_samples

   !> Estimates the errors, if the deck asks for that, and writes them. Until then the file has all samples, but is not complete.
   subroutine add_estimate(scene, integrator, outcome, quiet, history, worst, table, error)
      type(scene_type), intent(inout) :: scene
      class(integrator_type), intent(in) :: integrator
      type(outcome_type), intent(in) :: outcome
      logical, intent(in) :: quiet
      type(kept_type), intent(inout) :: history
      !> Largest estimated error of a channel relative to its magnitude; left as it is if there is none
      real(wp), intent(inout) :: worst
      !> Lines for the report
      character(:), allocatable, intent(out) :: table
      !> The file cannot be written
      type(error_type), allocatable, intent(out) :: error
      type(estimate_type) :: estimate
      table = ''
      if (.not. history%keeps) return
      call history%put_attribute('/run', 'status', 'finished; its errors were being estimated', error)
      if (.not. allocated(error)) call history%flush(error)
      if (allocated(error)) return
      call make_estimate(scene, history%memory, outcome%bound, integrator%statistics%steps, integrator%statistics%evaluations, &
         & outcome%cpu, quiet, estimate)
      if (signal_came()) then
         call raise(error, 'interrupted by '//signal_name()//' while the errors of the run were estimated; with --restart they '// &
            & 'are estimated again', status_interrupted)
         return
      end if
      associate (channels => scene%system%model%channels)
         scene%warnings = scene%warnings//estimate_warning(estimate, channels)
         table = estimate_table(estimate, channels, history%memory)
         if (table /= '') table = newline//table
         if (estimate%reason == '') worst = worst_relative(estimate, history%memory)
         call record_estimate(estimate, channels, history%history_type, error)
      end associate
   end subroutine add_estimate

   !> Largest estimated error of a channel relative to its magnitude.
   pure real(wp) function worst_relative(estimate, samples) result(worst)
      type(estimate_type), intent(in) :: estimate
      type(memory_type), intent(in) :: samples
      real(wp) :: scale
      integer :: i
      worst = 0.0_wp
      do i = 1, size(estimate%values, 1)
         scale = magnitude(samples%values(i, :samples%samples))
         if (scale > 0.0_wp) worst = max(worst, maxval(estimate%values(i, :))/scale)
      end do
   end function worst_relative

   !> Deck's name without its folder, with another ending.
   pure function default_results(path, ending) result(name)
      character(*), intent(in) :: path, ending
      character(:), allocatable :: name
      integer :: dot
      name = path(index(path, '/', back=.true.) + 1:)
      dot = index(name, '.', back=.true.)
      if (dot > 1) name = name(:dot - 1)
      name = name//ending
   end function default_results

end module limber_commands_run
