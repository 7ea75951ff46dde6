!> limber sweep: one deck, many parameters. One deck, many values of its parameters. What is done stays done: called again, it runs
!> only rows that are missing or have failed. Floor: commands; deck -> plan -> rows -> summary.
module limber_commands_sweep
   use limber_base_error, only: error_type, raise, status_deck, status_run, status_interrupted
   use limber_base_files, only: make_folder, files_like, remove_file, longest_path
   use limber_base_process, only: processors
   use limber_base_signals, only: catch_signals, signal_came, signal_name
   use limber_base_text, only: as_text, newline
   use limber_commands_run, only: default_results
   use limber_commands_sweep_plan, only: sweep_type, swept_type, plan_sweep
   use limber_commands_sweep_pool, only: run_rows
   use limber_commands_sweep_rows, only: row_type, read_journals, is_journal, row_done, row_missing
   use limber_commands_sweep_summary, only: write_summary, summary_report, is_table
   use limber_output_write_permission, only: check_place
   implicit none
   private
   public :: sweep_deck, sweep_request_type

   !> What the command line asks of a sweep
   type :: sweep_request_type
      type(swept_type), allocatable :: settings(:)
      !> Processes; 0: as many as there are processors
      integer :: jobs = 0
      !> This process does only each `parts`-th row from the `part`-th on; 0: all, and the summary
      integer :: part = 0, parts = 0
      !> As the scheduler says that runs this process
      logical :: scheduled = .false.
      !> Whether only the summary is made; whether histories are kept
      logical :: collect = .false., keep = .false.
   end type sweep_request_type

contains

   !> Sweeps.
   subroutine sweep_deck(path, output, request, force, quiet, report, error)
      !> The deck, and the file for the summary; empty: the deck's name with the ending .sweep.h5
      character(*), intent(in) :: path, output
      type(sweep_request_type), intent(inout) :: request
      !> Whether all is done anew; whether the progress is not shown
      logical, intent(in) :: force, quiet
      character(:), allocatable, intent(out) :: report
      !> A sweep that cannot be run (status 2), rows that have not ended well (status 3), a signal that asks for the end (status 4)
      type(error_type), allocatable, intent(out) :: error
      type(sweep_type) :: sweep
      type(row_type), allocatable :: rows(:)
      character(:), allocatable :: results, base, folder
      integer, allocatable :: waiting(:)
      integer :: i
      report = ''
      call plan_sweep(path, request%settings, sweep, error)
      if (allocated(error)) return
      sweep%keep = sweep%keep .or. request%keep
      if (request%scheduled) call ask_scheduler(request)
      if (request%jobs == 0) request%jobs = processors()
      results = output
      if (results == '') results = default_results(path, '.sweep.h5')
      base = results
      if (len(base) > 3) then
         if (base(len(base) - 2:) == '.h5') base = base(:len(base) - 3)
      end if
      folder = base//'.rows'
      call check_places(results, base//'.csv', folder, sweep%sources, force, error)
      if (allocated(error)) return
      call read_journals(folder, sweep, rows)
      waiting = pack([(i, i=1, size(rows))], rows%state /= row_done .and. rows%same_as == 0)
      if (request%parts > 0) waiting = pack(waiting, mod(waiting - 1, request%parts) == request%part - 1)
      if (.not. request%collect) then
         if (any(rows%state == row_done) .and. request%parts == 0) report = as_text(count(rows%state == row_done))// &
            & ' rows were done already'//newline
         call catch_signals()
         call run_rows(sweep, folder, waiting, request%jobs, quiet, error)
         call read_journals(folder, sweep, rows)
         if (allocated(error)) then
            call say_what_stays(error)
            return
         end if
      end if
      report = report//summary_report(sweep, rows)
      if (request%parts == 0 .or. request%collect) then
         call write_summary(sweep, rows, folder, results, base//'.csv', error)
         if (allocated(error)) then
            error%message = 'the summary could not be written: '//error%message
            call say_what_stays(error)
            return
         end if
         report = report//newline//'   The summary'//trim(merge(', marked incomplete,', '                    ', &
            & any(rows%state == row_missing)))//' is in '//results//' and '//base//'.csv'
      end if
      call judge()

   contains

      !> Adds to an error which rows need not be run again.
      subroutine say_what_stays(error)
         type(error_type), allocatable, intent(inout) :: error
         error%message = path//': '//error%message//newline//'   '//as_text(count(rows%state == row_done))//' of '// &
            & as_text(size(rows))//' rows are done and are kept in '//folder//'; called again, the sweep goes on from there'
         error%status = status_run
      end subroutine say_what_stays

      !> Rows that have not ended well make the status of the command.
      subroutine judge()
         logical :: mine(size(rows))
         mine = .true.
         if (request%parts > 0 .and. .not. request%collect) mine = [(mod(i - 1, request%parts) == request%part - 1, &
            & i=1, size(rows))] .and. rows%same_as == 0
         if (signal_came() .and. any(mine .and. rows%state == row_missing)) then
            call raise(error, report//newline//path//': interrupted by '//signal_name()//'; '//as_text(count(rows%state == &
               & row_done))//' of '//as_text(size(rows))//' rows are done and are kept in '//folder//'; called again, the'// &
               & ' sweep goes on from there', status_interrupted)
            report = ''
         else if (any(mine .and. rows%state /= row_done)) then
            call raise(error, report, status_run)
            report = ''
         end if
      end subroutine judge

   end subroutine sweep_deck

   !> The place for the summary: with `force` what is there is forgotten, and a file of another kind is kept without it.
   subroutine check_places(results, csv, folder, sources, force, error)
      character(*), intent(in) :: results, csv, folder
      !> Files of the deck
      character(*), intent(in) :: sources(:)
      logical, intent(in) :: force
      type(error_type), allocatable, intent(out) :: error
      character(longest_path), allocatable :: journals(:)
      logical :: exists, fits
      integer :: i
      call check_place(results, sources, error)
      if (.not. allocated(error)) call check_place(csv, sources, error)
      if (.not. allocated(error)) call check_place(csv//'.new', sources, error)
      if (allocated(error)) return
      call files_like(folder, '.journal', journals)
      inquire (file=results, exist=exists)
      if (exists .and. size(journals) == 0 .and. .not. force) then
         call raise(error, results//' exists, and is no summary of rows in '//folder// &
            & '; give --force to overwrite it or -o for another name', status_deck)
         return
      end if
      fits = is_table(csv) .or. force
      if (fits) fits = is_table(csv//'.new')
      if (.not. fits) then
         call raise(error, csv//' or '//csv//'.new exists, and is no table of a sweep; move it away, or give -o for another name', &
            & status_deck)
         return
      end if
      if (force) then
         do i = 1, size(journals)
            if (is_journal(trim(journals(i)))) call remove_file(trim(journals(i)))
         end do
      end if
      call make_folder(folder)
   end subroutine check_places

   !> Part of the rows that belongs to this task of a job array, or to this rank of a parallel job.
   subroutine ask_scheduler(request)
      type(sweep_request_type), intent(inout) :: request
      integer :: first, last
      if (number_in('SLURM_ARRAY_TASK_COUNT') > 1) then
         first = number_in('SLURM_ARRAY_TASK_MIN')
         last = number_in('SLURM_ARRAY_TASK_STEP')
         request%parts = number_in('SLURM_ARRAY_TASK_COUNT')
         request%part = (number_in('SLURM_ARRAY_TASK_ID') - first)/max(1, last) + 1
      else if (number_in('OMPI_COMM_WORLD_SIZE') > 1) then
         request%parts = number_in('OMPI_COMM_WORLD_SIZE')
         request%part = number_in('OMPI_COMM_WORLD_RANK') + 1
      else if (number_in('PMI_SIZE') > 1) then
         request%parts = number_in('PMI_SIZE')
         request%part = number_in('PMI_RANK') + 1
      else if (number_in('SLURM_NTASKS') > 1) then
         request%parts = number_in('SLURM_NTASKS')
         request%part = number_in('SLURM_PROCID') + 1
      end if
      if (request%parts > 0 .and. request%jobs == 0) then
         request%jobs = max(1, number_in('SLURM_CPUS_PER_TASK'))
      end if
   end subroutine ask_scheduler

   !> A whole number in the environment; 0 if there is none.
   integer function number_in(name) result(number)
      character(*), intent(in) :: name
      character(32) :: text
      integer :: status
      number = 0
      call get_environment_variable(name, text, status=status)
      if (status == 0) read (text, *, iostat=status) number
      if (status /= 0) number = 0
   end function number_in

end module limber_commands_sweep
