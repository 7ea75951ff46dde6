!> `limber run`: deck -> model -> modes -> system -> integrator -> history, with a closing report. Floor: analysis.
module limber_analysis_run
   use limber_base_kinds, only: wp, long
   use limber_base_error, only: error_type, raise, status_deck
   use limber_base_text, only: as_text, newline
   use limber_analysis_advise, only: advice_table, target_of
   use limber_analysis_advice, only: apply_advice
   use limber_analysis_dynamics, only: run_dynamics, new_integrator, outcome_type
   use limber_analysis_estimate, only: kept_type, estimate_type, make_estimate
   use limber_analysis_estimate_report, only: record_estimate, estimate_warning, estimate_table
   use limber_analysis_errors, only: magnitude
   use limber_analysis_ranges, only: range_warnings
   use limber_analysis_record, only: open_history, record_outcome, record_steps
   use limber_analysis_scalars, only: scalar_values, scalar_lines
   use limber_analysis_scene, only: scene_type, read_scene, build_scene, seconds_since, mobility_line, inner_joints
   use limber_analysis_steps, only: run_steps, passed_type
   use limber_analysis_target, only: reached_type, reach_target
   use limber_deck_content, only: deck_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_reader, only: read_deck
   use limber_deck_parameters, only: override_type
   use limber_flex_library, only: library_type
   use limber_integrator_integrator, only: integrator_type
   use limber_integrator_statistics, only: step_statistics_type
   use limber_model_analyses, only: single_dynamics
   use limber_model_scalars, only: add_usual_scalars
   use limber_model_scene, only: body_type, body_flexible, units_type
   use limber_output_progress, only: progress_type
   use limber_output_sink, only: memory_type
   implicit none
   private
   public :: run_deck, check_deck, run_one, batch_type, default_results

   !> What a run of many is given, and what it leaves behind
   type :: batch_type
      !> Values of parameters in place of those of the deck
      type(override_type), allocatable :: overrides(:)
      !> Reductions of beams that earlier runs have made
      type(library_type) :: library
      !> Whether the history is forgotten; whether the usual scalars are taken of a deck that asks for none
      logical :: in_memory = .false., usual_scalars = .false.
      !> CPU time after which the run is given up [s]
      real(wp) :: limit = huge(1.0_wp)
      !> Largest estimated error of a channel relative to its magnitude, if the deck asks for that; else negative
      real(wp) :: error = -1.0_wp
      !> CPU seconds of the run, all included; its warnings
      real(wp) :: cpu = 0.0_wp
      character(:), allocatable :: warnings
      !> Scalars (scalars)
      real(wp), allocatable :: scalars(:)
   end type batch_type

contains

   !> Runs a deck.
   subroutine run_deck(path, output, force, quiet, report, error, overrides)
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
      type(batch_type) :: batch
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
      class(integrator_type), allocatable :: integrator
      type(kept_type) :: history
      type(progress_type) :: progress
      type(outcome_type) :: outcome
      type(error_type), allocatable :: write_error
      type(diagnostics_type) :: diagnostics
      character(:), allocatable :: table
      integer(long) :: tick
      real(wp) :: started
      call cpu_time(started)
      report = ''
      batch%error = -1.0_wp
      batch%cpu = 0.0_wp
      batch%warnings = ''
      call system_clock(tick)
      call read_deck(path, scene%deck, diagnostics, batch%overrides)
      scene%reading = seconds_since(tick)
      if (diagnostics%count == 0 .and. target_of(scene%deck) > 0.0_wp) then
         call run_to_target(path, results, force, quiet, batch, scene, history, report, error)
         if (allocated(scene%warnings)) call fill_batch()
         return
      end if
      call build_scene(scene, diagnostics, error, batch%library)
      if (allocated(error)) return
      if (.not. scene%system%model%dynamics%wanted) then
         call raise(error, path//': nothing to run; add an analysis, such as *DYNAMICS (limber help DYNAMICS)', status_deck)
         return
      end if
      if (batch%usual_scalars) call add_usual_scalars(scene%system%model)
      if (size(scene%system%model%scalars) > 0) call history%summarise(size(scene%system%model%channels))
      call history%watch_limit(batch%limit)
      call open_history(scene, results, force, history%history_type, error, batch%in_memory)
      if (allocated(error)) return
      if (.not. single_dynamics(scene%system%model)) then
         call run_analyses(path, results, quiet, scene, history, report, error)
         call fill_batch()
         return
      end if
      call keep_samples(scene, history)
      call new_integrator(scene%system%model%dynamics, integrator)
      if (.not. quiet) call progress%start(scene%system%model%dynamics%start, scene%system%model%dynamics%end, path)
      call run_dynamics(scene, integrator, history, progress, outcome, error)
      if (.not. quiet) call progress%finish()
      if (allocated(outcome%warnings)) scene%warnings = scene%warnings//outcome%warnings
      scene%warnings = scene%warnings//range_warnings(outcome%indicators, scene%system%model)//energy_warning(outcome)
      if (allocated(error)) then
         call record_outcome(scene, outcome, integrator%statistics, error%message, history%history_type, write_error)
         error%message = path//': '//error%message//what_is_left(results, batch%in_memory)
      else
         call add_estimate(scene, integrator, outcome, quiet, history, batch%error, table, error)
         if (.not. allocated(error)) call record_outcome(scene, outcome, integrator%statistics, '', history%history_type, error)
         report = scene%warnings//closing_report(path, scene, outcome, integrator, results)// &
            & scalar_lines(scene%system%model, history)//table
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
      !> A deck that cannot be used (status 2), or a target that no rung keeps (status 3)
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
      if (.not. allocated(error)) call reach_target(scene%deck, target_of(scene%deck), quiet, reached, error)
      if (.not. allocated(error)) call build_reached(reached, scene, error)
      if (allocated(error)) return
      scene%reading = reading
      if (batch%usual_scalars) call add_usual_scalars(scene%system%model)
      if (size(scene%system%model%scalars) > 0) call history%summarise(size(scene%system%model%channels))
      call open_history(scene, results, force, history%history_type, error, batch%in_memory)
      do k = 1, reached%samples%samples
         if (allocated(error)) return
         call history%append(reached%samples%times(k), reached%samples%values(:, k), error)
      end do
      if (allocated(error)) return
      batch%error = reached%error
      if (allocated(reached%outcome%warnings)) scene%warnings = scene%warnings//reached%outcome%warnings
      scene%warnings = scene%warnings//energy_warning(reached%outcome)
      call new_integrator(scene%system%model%dynamics, integrator)
      integrator%statistics = reached%statistics
      if (allocated(reached%estimate%values)) call record_estimate(reached%estimate, scene%system%model%channels, &
         & history%history_type, error)
      if (allocated(error)) return
      if (.not. reached%done) then
         call record_outcome(scene, reached%outcome, reached%statistics, reached%reason, history%history_type, write_error)
         call raise(error, path//': '//reached%reason//reached%path//what_is_left(results, batch%in_memory))
         return
      end if
      call record_outcome(scene, reached%outcome, reached%statistics, '', history%history_type, error)
      table = estimate_table(reached%estimate, scene%system%model%channels, reached%samples)
      report = scene%warnings//closing_report(path, scene, reached%outcome, integrator, results)// &
         & scalar_lines(scene%system%model, history)//newline//advice_table(reached%advice, scene)//reached%path//newline//table
   end subroutine run_to_target

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

   !> Where the results of a run are that could not finish.
   pure function what_is_left(results, in_memory) result(text)
      character(*), intent(in) :: results
      logical, intent(in) :: in_memory
      character(:), allocatable :: text
      text = ''
      if (.not. in_memory) text = newline//'   What was computed up to there is in '//results//', marked incomplete.'
   end function what_is_left

   !> Runs a deck with several analyses, or another one than the motion in time.
   subroutine run_analyses(path, results, quiet, scene, history, report, error)
      !> The deck, and the result file
      character(*), intent(in) :: path, results
      logical, intent(in) :: quiet
      type(scene_type), intent(inout) :: scene
      !> Open
      type(kept_type), intent(inout) :: history
      character(:), allocatable, intent(out) :: report
      type(error_type), allocatable, intent(out) :: error
      type(passed_type) :: passed
      type(outcome_type) :: outcome
      type(step_statistics_type) :: statistics
      type(error_type), allocatable :: write_error
      character(:), allocatable :: lines
      call run_steps(scene, path, quiet, history, passed, outcome, statistics, lines, error)
      if (allocated(outcome%indicators)) scene%warnings = scene%warnings//range_warnings(outcome%indicators, scene%system%model)
      call record_steps(scene, passed, history%history_type, write_error)
      report = scene%warnings//path//': '//scene%system%model%heading//lines//newline//'   '//as_text(outcome%cpu, 3)// &
         & ' s CPU; '//as_text(scene%reading + scene%building + scene%assembling, 3)//' s before it'//newline//'   '// &
         & as_text(outcome%samples)//' samples in '//results//scalar_lines(scene%system%model, history)
      if (allocated(error)) then
         call record_outcome(scene, outcome, statistics, error%message, history%history_type, write_error)
         error%message = path//': '//error%message//newline//'   What was computed up to there is in '//results// &
            & ', marked incomplete.'
      else if (allocated(write_error)) then
         call move_alloc(write_error, error)
      else
         call record_outcome(scene, outcome, statistics, '', history%history_type, error)
      end if
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
      call make_estimate(scene, history%memory, integrator%statistics%steps, outcome%cpu, quiet, estimate)
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

   !> Reads, builds and assembles a deck, and says what it found.
   subroutine check_deck(path, overrides, report, error)
      character(*), intent(in) :: path
      !> Values of parameters in place of those of the deck
      type(override_type), intent(in) :: overrides(:)
      character(:), allocatable, intent(out) :: report
      type(error_type), allocatable, intent(out) :: error
      !> Of more bodies than this only the first ones and the last one are shown
      integer, parameter :: most_lines = 30, head = 10
      type(scene_type) :: scene
      integer :: i
      call read_scene(path, scene, error, overrides)
      if (allocated(error)) return
      associate (model => scene%system%model)
         report = scene%warnings//path//': '//model%heading
         do i = 1, size(model%bodies)
            if (size(model%bodies) > most_lines .and. i > head .and. i < size(model%bodies)) then
               if (i == head + 1) report = report//newline//'   ... '//as_text(size(model%bodies) - head - 1)//' bodies between'
               cycle
            end if
            if (model%bodies(i)%whole > 0) then
               associate (whole => model%wholes(model%bodies(i)%whole))
                  if (i == whole%first) report = report//newline//'   '//whole%name//' in '// &
                     & as_text(whole%last - whole%first + 1)//' segments; '//body_line(model%bodies(i), model%units)
               end associate
               cycle
            end if
            report = report//newline//'   '//body_line(model%bodies(i), model%units)
         end do
         report = report//newline//'   '//as_text(size(model%joints) - inner_joints(model))//' joints, '// &
            & as_text(size(model%drivers))//' drivers, '//as_text(size(model%loads))//' loads; '// &
            & as_text(size(model%channels))//' channels'//newline//'   '//mobility_line(scene%assembly, inner_joints(model))
      end associate
   end subroutine check_deck

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

   pure function body_line(body, units) result(line)
      type(body_type), intent(in) :: body
      type(units_type), intent(in) :: units
      character(:), allocatable :: line
      integer :: j
      line = body%name//': mass '//as_text(body%reduced%mass, 6)//' '//units%mass
      if (body%kind /= body_flexible) return
      line = line//', '//as_text(body%reduced%bending)//' bending and '//as_text(body%reduced%n - body%reduced%bending)// &
         & ' axial coordinates, rad/'//units%time//':'
      do j = 1, body%reduced%n
         line = line//' '//as_text(sqrt(body%reduced%omega2(j)), 4)
      end do
      if (allocated(body%note)) then
         if (body%note /= '') line = line//newline//'      '//body%note
      end if
   end function body_line

   !> A warning if energy has come or gone from nowhere: the one check that every run has. Empty if all is well.
   pure function energy_warning(outcome) result(text)
      type(outcome_type), intent(in) :: outcome
      character(:), allocatable :: text
      real(wp), parameter :: allowed = 1.0e-2_wp
      text = ''
      if (outcome%imbalance <= allowed*outcome%largest_energy) return
      text = 'warning: the energy balance is off by '//as_text(100*outcome%imbalance/outcome%largest_energy, 2)// &
         & ' % of the largest energy: the integrator has damped or fed vibrations that the tolerance does not resolve;'// &
         & ' compare with a run at a tenth of TOLERANCE'//newline
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
         if (allocated(outcome%axial)) text = text//outcome%axial
         text = text//'   '//as_text(outcome%samples)//' samples in '//results
      end associate
   end function closing_report

end module limber_analysis_run
