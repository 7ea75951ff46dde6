!> Summary of a sweep. A results file in which a row stands for a sample, as in that of a study, and the same as text with commas.
!> Floor: commands.
module limber_commands_sweep_summary
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use limber_base_error, only: error_type, raise
   use limber_base_files, only: append_text, rename_file, remove_file, first_bytes
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, newline
   use limber_analysis_provenance, only: record_origin
   use limber_base_version, only: version
   use limber_commands_sweep_plan, only: sweep_type
   use limber_commands_sweep_pool, only: history_name
   use limber_commands_sweep_rows, only: row_type, row_states, row_missing, row_done, row_refused, row_failed, row_crashed
   use limber_output_history, only: history_type
   use limber_output_own_files, only: remove_own
   implicit none
   private
   public :: write_summary, summary_report, is_table

contains

   !> Writes both files; they take the place of older ones only when they are whole.
   subroutine write_summary(sweep, rows, folder, path, csv, error)
      type(sweep_type), intent(in) :: sweep
      type(row_type), intent(in) :: rows(:)
      !> Of the histories
      character(*), intent(in) :: folder
      !> Of the results file, and of the text
      character(*), intent(in) :: path, csv
      type(error_type), allocatable, intent(out) :: error
      logical :: ok
      call write_results(sweep, rows, folder, path//'.new', error)
      if (.not. allocated(error)) call write_text(sweep, rows, folder, csv//'.new', error)
      if (allocated(error)) then
         call remove_own(path//'.new', '')
         call remove_file(csv//'.new')
         return
      end if
      call rename_file(path//'.new', path, ok)
      if (ok) call rename_file(csv//'.new', csv, ok)
      if (.not. ok) call raise(error, 'cannot give '//path//'.new its name')
   end subroutine write_summary

   !> Whether a file is a table of a sweep, or nothing is there.
   logical function is_table(path)
      character(*), intent(in) :: path
      character(:), allocatable :: bytes
      bytes = first_bytes(path, 4)
      is_table = bytes == 'row,' .or. len(bytes) == 0
   end function is_table

   subroutine write_results(sweep, rows, folder, path, error)
      type(sweep_type), intent(in) :: sweep
      type(row_type), intent(in) :: rows(:)
      character(*), intent(in) :: folder, path
      type(error_type), allocatable, intent(out) :: error
      type(history_type) :: file
      type(error_type), allocatable :: close_error
      real(wp) :: scalars(size(sweep%scalars))
      integer :: i
      call remove_own(path, '')
      call file%create(path, .false., version, error)
      if (.not. allocated(error)) call file%define_time('row', error)
      do i = 1, size(sweep%names)
         if (.not. allocated(error)) call file%define_channel(trim(sweep%names(i)), 1, '', 'parameter of the deck', error)
      end do
      if (.not. allocated(error)) call file%define_channel('state', 1, '1', &
         & '0 missing, 1 ok, 2 refused (deck), 3 failed (run), 4 crashed; /run/messages says why; scalars are NaN of all but 1', &
         & error)
      if (.not. allocated(error)) call file%define_channel('error_estimate', 1, '1', &
         & 'largest estimated error of a channel relative to its magnitude; -1: none was asked for', error)
      if (.not. allocated(error)) call file%define_channel('warnings', 1, '1', 'number of warnings; /run/messages has them', error)
      do i = 1, size(sweep%scalars)
         if (.not. allocated(error)) call file%define_channel(trim(sweep%scalars(i)), 1, trim(sweep%units(i)), &
            & trim(sweep%meanings(i)), error)
      end do
      do i = 1, size(rows)
         if (allocated(error)) exit
         scalars = ieee_value(1.0_wp, ieee_quiet_nan)
         if (rows(i)%state == row_done) scalars = rows(i)%scalars
         call file%append(real(i, wp), [sweep%values(:, i), real(rows(i)%state, wp), rows(i)%error, real(rows(i)%warnings, wp), &
            & scalars], error)
      end do
      if (.not. allocated(error)) call file%write_samples(error)
      if (.not. allocated(error)) call put_texts()
      if (allocated(error)) then
         call file%finish(.false., error%message, close_error)
      else
         call file%finish(all(rows%state /= row_missing), count_line(rows), error)
      end if

   contains

      subroutine put_texts()
         character(:), allocatable :: messages, histories
         messages = ''
         histories = ''
         do i = 1, size(rows)
            messages = messages//rows(i)%message//newline
            histories = histories//kept(sweep, rows, folder, i)//newline
         end do
         call file%put_real('/run/seconds', rows%seconds, 's', 'CPU seconds of each row, reading and modes included', error)
         if (.not. allocated(error)) call file%put_text('/run/messages', messages, error)
         if (.not. allocated(error)) call file%put_text('/run/histories', histories, error)
         if (.not. allocated(error)) call record_origin(sweep%deck, file, error)
      end subroutine put_texts

   end subroutine write_results

   !> Path of the history of a row; empty if there is none.
   pure function kept(sweep, rows, folder, i) result(path)
      type(sweep_type), intent(in) :: sweep
      type(row_type), intent(in) :: rows(:)
      character(*), intent(in) :: folder
      integer, intent(in) :: i
      character(:), allocatable :: path
      path = ''
      if (sweep%keep .and. any(rows(i)%state == [row_done, row_failed])) path = history_name(folder, sweep%keys(i))
   end function kept

   subroutine write_text(sweep, rows, folder, path, error)
      type(sweep_type), intent(in) :: sweep
      type(row_type), intent(in) :: rows(:)
      character(*), intent(in) :: folder, path
      type(error_type), allocatable, intent(out) :: error
      !> Lines are written in pieces of this length
      integer, parameter :: enough = 65536
      character(:), allocatable :: lines
      integer :: i, k
      logical :: ok
      call remove_file(path)
      lines = 'row'
      do k = 1, size(sweep%names)
         lines = lines//','//trim(sweep%names(k))
      end do
      lines = lines//',state,error_estimate,seconds,warnings'
      do k = 1, size(sweep%scalars)
         lines = lines//','//trim(sweep%scalars(k))
      end do
      lines = lines//',history,message'//newline
      ok = .true.
      do i = 1, size(rows)
         lines = lines//as_text(i)
         do k = 1, size(sweep%names)
            lines = lines//','//as_text(sweep%values(k, i))
         end do
         lines = lines//','//trim(row_states(rows(i)%state))//','
         if (rows(i)%error >= 0.0_wp) lines = lines//as_text(rows(i)%error, 3)
         lines = lines//','//as_text(rows(i)%seconds, 4)//','//as_text(rows(i)%warnings)
         do k = 1, size(sweep%scalars)
            lines = lines//','
            if (rows(i)%state == row_done) lines = lines//as_text(rows(i)%scalars(k))
         end do
         lines = lines//','//field_of(kept(sweep, rows, folder, i))//',"'//doubled(rows(i)%message)//'"'//newline
         if (len(lines) < enough .or. .not. ok) cycle
         call append_text(path, lines, ok)
         lines = ''
      end do
      if (ok) call append_text(path, lines, ok)
      if (.not. ok) call raise(error, 'cannot write '//path//': is the disk full?')
   end subroutine write_text

   !> A text as a field of a table: in quotes where something in it would end the field.
   pure function field_of(text) result(field)
      character(*), intent(in) :: text
      character(:), allocatable :: field
      field = text
      if (scan(text, ',"'//newline) > 0) field = '"'//doubled(text)//'"'
   end function field_of

   !> A text whose quotes stand twice.
   pure function doubled(text) result(quoted)
      character(*), intent(in) :: text
      character(:), allocatable :: quoted
      integer :: i
      quoted = ''
      do i = 1, len(text)
         quoted = quoted//text(i:i)
         if (text(i:i) == '"') quoted = quoted//'"'
      end do
   end function doubled

   !> '10 rows: 8 ok, 2 failed'
   pure function count_line(rows) result(text)
      type(row_type), intent(in) :: rows(:)
      character(:), allocatable :: text
      integer, parameter :: order(5) = [row_done, row_refused, row_failed, row_crashed, row_missing]
      integer :: i
      text = as_text(size(rows))//' rows: '//as_text(count(rows%state == row_done))//' ok'
      do i = 2, size(order)
         if (any(rows%state == order(i))) text = text//', '//as_text(count(rows%state == order(i)))//' '// &
            & trim(row_states(order(i)))
      end do
   end function count_line

   !> How the sweep stands, and the first rows that have not ended well.
   function summary_report(sweep, rows) result(text)
      type(sweep_type), intent(in) :: sweep
      type(row_type), intent(in) :: rows(:)
      character(:), allocatable :: text
      integer, parameter :: most = 5
      integer :: i, k, shown
      text = sweep%path//': '//count_line(rows)//'; '//as_text(sum(rows%seconds), 4)//' s CPU in all'
      if (any(rows%same_as > 0)) text = text//newline//'   '//as_text(count(rows%same_as > 0))// &
         & ' of them have the values of an earlier row, and its run'
      shown = 0
      do i = 1, size(rows)
         if (any(rows(i)%state == [row_done, row_missing]) .or. rows(i)%same_as > 0) cycle
         shown = shown + 1
         if (shown > most) cycle
         text = text//newline//'   row '//as_text(i)//' ('
         do k = 1, size(sweep%names)
            if (k > 1) text = text//', '
            text = text//trim(sweep%names(k))//' = '//as_text(sweep%values(k, i), 6)
         end do
         text = text//') '//trim(row_states(rows(i)%state))//': '//rows(i)%message(:index(rows(i)%message//' / ', ' / ') - 1)
      end do
      if (shown > most) text = text//newline//'   and '//as_text(shown - most)//' more'
   end function summary_report

end module limber_commands_sweep_summary
