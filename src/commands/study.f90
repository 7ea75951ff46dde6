!> limber study: speed against error. A deck is run with all combinations of integrators, tolerances and fineness that its *STUDY
!> names, and every run is compared with a reference. Floor: commands; deck -> plan -> runs -> report.
module limber_commands_study
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise, status_interrupted
   use limber_base_files, only: longest_path
   use limber_base_signals, only: catch_signals, signal_came, signal_name
   use limber_base_text, only: as_text, newline
   use limber_accuracy_study_plan, only: plan_type, setting_type, read_plan, axis_modes, axis_fidelity
   use limber_accuracy_study_reference, only: reference_type, read_reference
   use limber_accuracy_study_report, only: heading, grid_table, time_table, family_table, advice, failures
   use limber_accuracy_study_results, only: open_results, add_runs
   use limber_accuracy_study_runs, only: run_type, make_reference, fine_setting, run_grid, run_family
   use limber_output_history, only: history_type
   use limber_output_write_permission, only: check_place
   use limber_output_progress, only: progress_type
   implicit none
   private
   public :: study_deck

contains

   !> Studies a deck.
   subroutine study_deck(path, output, force, quiet, report, error)
      !> The deck, and the file for the table of the runs; empty: study.h5 in the working folder
      character(*), intent(in) :: path, output
      !> Whether an existing file may be replaced; whether the progress is not shown
      logical, intent(in) :: force, quiet
      !> Tables and advice
      character(:), allocatable, intent(out) :: report
      !> A deck that cannot be used (status 2), no reference (status 3), or a signal that asks for the end (status 4); a run that
      !> fails is in the report
      type(error_type), allocatable, intent(out) :: error
      type(plan_type) :: plan
      type(reference_type) :: reference
      type(setting_type) :: fine
      type(history_type) :: file
      type(progress_type) :: progress
      type(run_type), allocatable :: runs(:)
      type(error_type), allocatable :: close_error
      character(:), allocatable :: results
      report = ''
      call read_plan(path, plan, error)
      if (allocated(error)) return
      results = output
      if (results == '') results = 'study.h5'
      call check_place(results, [character(longest_path) :: plan%deck%source%paths(), plan%reference], error)
      if (allocated(error)) return
      if (plan%reference /= '') call read_reference(plan, reference, error)
      if (allocated(error)) return
      call catch_signals()
      call open_results(plan, results, force, file, error)
      if (allocated(error)) return
      if (plan%reference == '') call make_reference(plan, quiet, reference, fine, error)
      if (.not. allocated(error)) then
         if (.not. quiet) call progress%start(0.0_wp, 1.0_wp, path)
         call run_grid(plan, reference, progress, runs)
         if (.not. quiet) call progress%finish()
         if (signal_came() .and. size(runs) == 0) then
            call interrupt(error)
         else
            call report_runs()
         end if
      end if
      if (allocated(error)) then
         call file%finish(.false., error%message, close_error)
         error%message = path//': '//error%message
         if (error%status == status_interrupted) error%message = report//newline//error%message//newline//'   '//results// &
            & ' is marked incomplete; it has '//as_text(file%samples)//' runs'
      else
         call file%finish(.true., 'finished', error)
      end if

   contains

      !> Tables and advice of the grid, and what goes with them.
      subroutine report_runs()
         if (plan%reference /= '') fine = fine_setting(plan, runs)
         report = heading(plan, reference)//newline//newline//grid_table(plan, runs)//newline//newline// &
            & time_table(plan, reference, runs)
         call add_runs(plan, 0, runs, file, error)
         if (.not. allocated(error)) call file%put_text('/run/failures', failures(plan, runs), error)
         if (.not. allocated(error) .and. allocated(reference%warnings)) call file%put_text('/run/warnings', reference%warnings, &
            & error)
         if (.not. allocated(error) .and. .not. signal_came()) call study_families(plan, fine, file, report, error)
         report = report//newline//newline//advice(plan, runs, report)//newline//'The table of the runs is in '//results
         if (signal_came() .and. .not. allocated(error)) call interrupt(error)
      end subroutine report_runs

   end subroutine study_deck

   !> A signal has asked for the end.
   subroutine interrupt(error)
      type(error_type), allocatable, intent(out) :: error
      call raise(error, 'interrupted by '//signal_name()//'; what has run is kept, and a study begins anew', status_interrupted)
   end subroutine interrupt

   !> What the modes, the geometric elements and the fidelity do alone.
   subroutine study_families(plan, fine, file, report, error)
      type(plan_type), intent(in) :: plan
      type(setting_type), intent(in) :: fine
      type(history_type), intent(inout) :: file
      character(:), allocatable, intent(inout) :: report
      type(error_type), allocatable, intent(out) :: error
      type(run_type), allocatable :: runs(:)
      integer :: which
      do which = axis_modes, axis_fidelity
         if (size(plan%axis(which)%values) < 2) cycle
         call run_family(plan, which, fine, runs)
         if (signal_came()) return
         report = report//newline//newline//family_table(plan, which, fine, runs)
         call add_runs(plan, which - axis_modes + 1, runs, file, error)
         if (allocated(error)) return
      end do
   end subroutine study_families

end module limber_commands_study
