!> Rows of a sweep in several processes. A crash takes one row with it and no more. Floor: commands.
module limber_commands_sweep_pool
   use limber_base_error, only: error_type, raise, status_deck, status_run, status_interrupted
   use limber_base_kinds, only: wp, long
   use limber_base_process, only: queue_type, new_queue, next_in_queue, taken_of_queue, start_copy, end_copy, ask_copy, &
      & wait_for_copy, pause_shortly, parent_number
   use limber_base_signals, only: catch_signals, signal_came
   use limber_base_text, only: as_text
   use limber_commands_batch, only: batch_type
   use limber_commands_run, only: run_one
   use limber_commands_sweep_plan, only: sweep_type, row_overrides
   use limber_commands_sweep_rows, only: row_type, journal_type, open_journal, note_begin, note_end, begun_last, &
      & row_done, row_refused, row_failed, row_crashed
   use limber_output_progress, only: progress_type
   implicit none
   private
   public :: run_rows, history_name

   !> Status of a process that could not note how its row has ended
   integer, parameter :: status_unnoted = 5

contains

   !> Runs rows, until a signal asks for the end: rows that are under way then are missing.
   subroutine run_rows(sweep, folder, waiting, jobs, quiet, error)
      type(sweep_type), intent(in) :: sweep
      !> Of the journals and histories
      character(*), intent(in) :: folder
      !> Indices of the rows; number of processes
      integer, intent(in) :: waiting(:), jobs
      !> Whether the progress is not shown
      logical, intent(in) :: quiet
      !> No row could be run (status 2), or not all of them could be noted (status 3)
      type(error_type), allocatable, intent(out) :: error
      type(queue_type) :: queue
      type(journal_type) :: journal
      type(progress_type) :: progress
      integer :: workers(min(jobs, size(waiting)))
      integer :: i, number, signal
      integer(long) :: asked
      logical :: ok, unnoted
      if (size(waiting) == 0) return
      call open_journal(folder, journal, error)
      if (allocated(error)) return
      call new_queue(waiting, queue, ok)
      if (.not. ok) then
         call raise(error, 'no room for the list of rows in the folder of temporary files (TMPDIR)', status_deck)
         return
      end if
      if (.not. quiet) call progress%start(0.0_wp, real(size(waiting), wp), sweep%path)
      unnoted = .false.
      do i = 1, size(workers)
         call start_worker(sweep, folder, queue, workers(i))
      end do
      asked = 0
      do while (any(workers > 0))
         if (signal_came()) call end_workers(workers, asked)
         call wait_for_copy(number, signal)
         if (number == 0) then
            call pause_shortly(0.01)
            call progress%update(real(taken_of_queue(queue) - count(workers > 0), wp))
            cycle
         end if
         do i = 1, size(workers)
            if (workers(i) /= number) cycle
            workers(i) = 0
            if (signal == 0) cycle
            if (signal == -status_unnoted) then
               unnoted = .true.
               cycle
            end if
            if (signal_came()) cycle
            call note_crash(journal, folder, number, signal)
            if (taken_of_queue(queue) < queue%length) call start_worker(sweep, folder, queue, workers(i))
         end do
      end do
      if (.not. quiet) call progress%finish()
      if (all(workers < 0)) call raise(error, 'no process could be started for the rows')
      if (unnoted) call raise(error, 'the folder '//folder//' takes no more rows: is the disk full?', status_run)
   end subroutine run_rows

   !> Asks the processes that run rows to end, once; after a while it ends them.
   subroutine end_workers(workers, asked)
      !> Their numbers; zero and below: none
      integer, intent(in) :: workers(:)
      !> Clock when they were asked [ticks]; zero: they have not been
      integer(long), intent(inout) :: asked
      !> [s]
      integer, parameter :: patience = 10
      integer(long) :: now, rate
      integer :: i
      call system_clock(now, rate)
      if (asked /= 0 .and. now - asked < patience*rate) return
      do i = 1, size(workers)
         call ask_copy(workers(i), at_once=asked /= 0)
      end do
      asked = now
   end subroutine end_workers

   subroutine start_worker(sweep, folder, queue, number)
      type(sweep_type), intent(in) :: sweep
      character(*), intent(in) :: folder
      type(queue_type), intent(in) :: queue
      !> Of the process; -1 if there is none
      integer, intent(out) :: number
      logical :: is_copy, is_noted
      call start_copy(number, is_copy)
      if (.not. is_copy) return
      call catch_signals(all=.true.)
      call work_off(sweep, folder, queue, is_noted)
      call end_copy(merge(merge(status_interrupted, 0, signal_came()), status_unnoted, is_noted))
   end subroutine start_worker

   !> What a process does.
   subroutine work_off(sweep, folder, queue, is_noted)
      type(sweep_type), intent(in) :: sweep
      character(*), intent(in) :: folder
      type(queue_type), intent(in) :: queue
      !> False if it could not be noted how a row has ended
      logical, intent(out) :: is_noted
      type(journal_type) :: journal
      type(batch_type) :: batch
      type(row_type) :: row
      type(error_type), allocatable :: error
      integer :: i, parent
      parent = parent_number()
      call open_journal(folder, journal, error)
      is_noted = .not. allocated(error)
      if (.not. is_noted) return
      batch%unkept = .not. sweep%keep
      batch%usual_scalars = .true.
      batch%limit = sweep%limit
      do
         i = next_in_queue(queue)
         if (i == 0) exit
         call note_begin(journal, sweep%keys(i))
         call run_row(sweep, folder, i, batch, row)
         if (signal_came() .and. row%state /= row_done) exit
         call note_end(journal, sweep%keys(i), row, is_noted)
         if (parent_number() /= parent .or. signal_came()) exit
         if (.not. is_noted) exit
      end do
   end subroutine work_off

   !> Runs one row.
   subroutine run_row(sweep, folder, i, batch, row)
      type(sweep_type), intent(in) :: sweep
      character(*), intent(in) :: folder
      integer, intent(in) :: i
      type(batch_type), intent(inout) :: batch
      type(row_type), intent(out) :: row
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      if (allocated(batch%overrides)) deallocate (batch%overrides)
      if (allocated(batch%scalars)) deallocate (batch%scalars)
      allocate (batch%overrides, source=row_overrides(sweep, i))
      call run_one(sweep%path, history_name(folder, sweep%keys(i)), .true., .true., batch, report, error)
      row%seconds = batch%cpu
      row%error = batch%error
      row%message = ''
      row%state = row_done
      if (allocated(error)) then
         row%state = merge(row_refused, row_failed, error%status == status_deck)
         row%message = error%message
      else if (allocated(batch%warnings)) then
         row%message = batch%warnings
         row%warnings = warnings_in(batch%warnings)
      end if
      if (.not. allocated(batch%scalars)) allocate (batch%scalars(size(sweep%scalars)), source=0.0_wp)
      allocate (row%scalars, source=batch%scalars)
   end subroutine run_row

   !> Number of warnings in a text; each has its word once, and may have several lines.
   pure integer function warnings_in(text) result(number)
      character(*), intent(in) :: text
      character(*), parameter :: word = 'warning: '
      integer :: i
      number = 0
      do i = 1, len(text) - len(word) + 1
         if (text(i:i + len(word) - 1) == word) number = number + 1
      end do
   end function warnings_in

   !> Where the history of a row is, if it is kept.
   pure function history_name(folder, key) result(name)
      character(*), intent(in) :: folder, key
      character(:), allocatable :: name
      name = folder//'/'//key//'.h5'
   end function history_name

   !> Notes that the row of a process has crashed.
   subroutine note_crash(journal, folder, number, signal)
      type(journal_type), intent(in) :: journal
      character(*), intent(in) :: folder
      !> Of the process; what killed it, or less its status
      integer, intent(in) :: number, signal
      type(row_type) :: row
      character(:), allocatable :: key
      logical :: ok
      key = begun_last(folder, number)
      if (key == '') return
      row%state = row_crashed
      allocate (row%scalars(0))
      row%message = 'the process has ended with signal '//as_text(signal)
      if (signal < 0) row%message = 'the process has ended with status '//as_text(-signal)
      call note_end(journal, key, row, ok)
   end subroutine note_crash

end module limber_commands_sweep_pool
