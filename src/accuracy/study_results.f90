!> Results file of a study. A "sample" is a run, whose number stands for the time, so that `limber export` prints it as plain
!> columns for postproc/study.gp. Floor: accuracy.
module limber_accuracy_study_results
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_version, only: version
   use limber_analysis_provenance, only: record_origin
   use limber_accuracy_study_plan, only: plan_type, varied_type, axis_integrator, axis_modes, axis_elements, axis_fidelity
   use limber_accuracy_study_runs, only: run_type, median
   use limber_output_history, only: history_type
   implicit none
   private
   public :: open_results, add_runs

   !> Columns besides those of the channels: name and meaning; two have the names of lists of *STUDY, functions or modes and so on
   character(*), parameter :: columns(2, 18) = reshape([character(96) :: &
      & 'table', '0: the grid; 1, 2, 3: one column of the model alone, in their order, against its finest value', &
      & 'integrator', 'place in /run/integrators', &
      & 'tolerance', 'TOLERANCE of *DYNAMICS', &
      & '', 'number in the list of this name; 0: as in the deck', &
      & '', 'number in the list of this name; 0: as in the deck', &
      & 'fidelity', 'place in /run/fidelities; 0: as in the deck', &
      & 'failed', '1 if the run failed; /run/failures says why', &
      & 'on_front', '1 if no other run is both faster and more accurate', &
      & 'repeats', 'runs that the times are medians of', &
      & 'cpu_seconds', 'CPU seconds of the time loop', &
      & 'whole_seconds', 'wall seconds of building, assembly and time loop', &
      & 'steps', 'accepted steps', &
      & 'evaluations', 'evaluations of the right-hand side', &
      & 'constraint_drift', 'largest residual of the constraints after a step, relative to their scales', &
      & 'energy_drift', 'largest imbalance of energy at a sample, relative to the largest energy', &
      & 'error', 'largest error of a channel, not below what is known of the reference', &
      & 'error_at_end', 'the same at the last sample', &
      & 'fixed_step', 'FIXED STEP of *DYNAMICS; 0: chosen by the error'], [2, 18])

contains

   !> Creates the file, before the runs: a file that cannot be written is known at once.
   subroutine open_results(plan, path, overwrite, file, error)
      type(plan_type), intent(in) :: plan
      character(*), intent(in) :: path
      logical, intent(in) :: overwrite
      type(history_type), intent(inout) :: file
      type(error_type), allocatable, intent(out) :: error
      integer :: i
      call file%create(path, overwrite, version, error)
      if (.not. allocated(error)) call file%define_time('run', error)
      do i = 1, size(columns, 2)
         if (.not. allocated(error)) call file%define_channel(column_name(plan, i), 1, '1', trim(columns(2, i)), error)
      end do
      do i = 1, size(plan%names)
         if (.not. allocated(error)) call file%define_channel('error_of_'//trim(plan%names(i)), 1, '1', &
            & 'largest difference from the reference over the samples, relative to its largest magnitude', error)
         if (.not. allocated(error)) call file%define_channel('error_at_end_of_'//trim(plan%names(i)), 1, '1', &
            & 'difference from the reference at the last sample, relative to its largest magnitude', error)
      end do
      if (.not. allocated(error)) call file%put_text('/run/integrators', words_of(plan%axis(axis_integrator)%texts), error)
      if (.not. allocated(error)) call file%put_text('/run/fidelities', words_of(plan%axis(axis_fidelity)%texts), error)
      if (.not. allocated(error)) call record_origin(plan%deck, file, error)
      if (.not. allocated(error)) call file%put_attribute('/run', 'heading', plan%heading, error)
      if (.not. allocated(error)) call file%put_attribute('/run', 'deck_path', plan%path, error)
   end subroutine open_results

   !> Name of a column: of numbers of the model that of their list, as in the deck.
   pure function column_name(plan, i) result(name)
      type(plan_type), intent(in) :: plan
      integer, intent(in) :: i
      character(:), allocatable :: name
      integer, parameter :: of_modes = 4, of_elements = 5
      integer :: k
      name = trim(columns(1, i))
      if (i == of_modes) name = plan%axis(axis_modes)%name
      if (i == of_elements) name = plan%axis(axis_elements)%name
      do k = 1, len(name)
         if (name(k:k) == ' ') name(k:k) = '_'
      end do
   end function column_name

   !> Words in a line.
   pure function words_of(words) result(text)
      character(*), intent(in) :: words(:)
      character(:), allocatable :: text
      integer :: i
      text = ''
      do i = 1, size(words)
         if (i > 1) text = text//' '
         text = text//trim(words(i))
      end do
   end function words_of

   !> Adds the runs of a table.
   subroutine add_runs(plan, table, runs, file, error)
      type(plan_type), intent(in) :: plan
      !> Number of the table
      integer, intent(in) :: table
      type(run_type), intent(in) :: runs(:)
      type(history_type), intent(inout) :: file
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: row(size(columns, 2) + 2*size(plan%names)), none
      integer :: i, n
      none = ieee_value(none, ieee_quiet_nan)
      n = size(columns, 2)
      do i = 1, size(runs)
         row = none
         row(1:6) = [real(table, wp), real(runs(i)%setting%level(axis_integrator), wp), runs(i)%setting%tolerance, &
            & number(plan%axis(axis_modes), runs(i)%setting%level(axis_modes)), &
            & number(plan%axis(axis_elements), runs(i)%setting%level(axis_elements)), &
            & real(runs(i)%setting%level(axis_fidelity), wp)]
         row(7:8) = [merge(1.0_wp, 0.0_wp, runs(i)%reason /= ''), merge(1.0_wp, 0.0_wp, runs(i)%on_front)]
         row(n) = runs(i)%setting%step
         if (runs(i)%reason == '') then
            row(9:11) = [real(size(runs(i)%cpu), wp), median(runs(i)%cpu), median(runs(i)%whole)]
            row(12:13) = real([runs(i)%steps, runs(i)%evaluations], wp)
            row(14:17) = [runs(i)%constraints, runs(i)%energy, runs(i)%error, runs(i)%error_at_end]
            row(n + 1::2) = runs(i)%greatest
            row(n + 2::2) = runs(i)%last
         end if
         call file%append(real(file%samples + 1, wp), row, error)
         if (allocated(error)) return
      end do
   end subroutine add_runs

   pure real(wp) function number(axis, level)
      type(varied_type), intent(in) :: axis
      integer, intent(in) :: level
      number = 0.0_wp
      if (level > 0) number = axis%values(level)
   end function number

end module limber_accuracy_study_results
