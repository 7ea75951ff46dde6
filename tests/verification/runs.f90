!> What tests of whole runs share: a deck with some of its words exchanged, run, and its history opened.
module runs
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_commands_run, only: run_deck
   use limber_output_history_reader, only: history_reader_type
   use testing, only: check, check_no_error
   implicit none
   private
   public :: run_changed, run_text, change_deck, contents, channel, numbers, check_warning, read_columns

contains

   !> Writes a deck with texts exchanged beside the results, runs it, and opens its history.
   subroutine run_changed(path, results, old, new, reader)
      !> The deck; the file for its results; texts that occur in the deck, and what stands for them (of equal numbers)
      character(*), intent(in) :: path, results, old(:), new(:)
      type(history_reader_type), intent(out) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call change_deck(path, results//'.inp', old, new)
      call run_deck(results//'.inp', results, .true., .true., report, error)
      call check_no_error(error, path)
      if (allocated(error)) error stop 1
      call reader%open(results, error)
      call check_no_error(error, path//': results')
      call check(reader%complete, path//' is marked complete')
   end subroutine run_changed

   !> Numbers of a dataset; none if it is not there.
   function numbers(reader, path) result(values)
      type(history_reader_type), intent(in) :: reader
      character(*), intent(in) :: path
      real(wp), allocatable :: values(:)
      type(error_type), allocatable :: error
      call reader%read_numbers(path, values, error)
      call check_no_error(error, path)
      if (.not. allocated(values)) allocate (values(0))
   end function numbers

   !> Checks that a run has a warning with a text, or none.
   subroutine check_warning(reader, warning, name)
      type(history_reader_type), intent(in) :: reader
      character(*), intent(in) :: warning, name
      character(:), allocatable :: text
      type(error_type), allocatable :: error
      call reader%read_text('/run/warnings', text, error)
      call check_no_error(error, name//': warnings')
      if (warning == '') then
         call check(text == '', name//' has no warning, but: '//text)
      else
         call check(index(text, warning) > 0, name//' is warned of: '//text)
      end if
   end subroutine check_warning

   !> Writes a deck beside its results, and runs it.
   subroutine run_text(text, results, report, error)
      !> The deck; the file for its results
      character(*), intent(in) :: text, results
      character(:), allocatable, intent(out) :: report
      type(error_type), allocatable, intent(out) :: error
      call write_text(text, results//'.inp')
      call run_deck(results//'.inp', results, .true., .true., report, error)
   end subroutine run_text

   !> Writes a file.
   subroutine write_text(text, path)
      character(*), intent(in) :: text, path
      integer :: unit
      open (newunit=unit, file=path, access='stream', action='write', status='replace')
      write (unit) text
      close (unit)
   end subroutine write_text

   !> Writes a deck with texts exchanged, each where it occurs first.
   subroutine change_deck(path, changed, old, new)
      !> The deck and the new one; texts that occur in it, and what stands for them (of equal numbers)
      character(*), intent(in) :: path, changed, old(:), new(:)
      character(:), allocatable :: text
      integer :: i, at
      text = contents(path)
      do i = 1, size(old)
         at = index(text, trim(old(i)))
         call check(at > 0, path//' has '//trim(old(i)))
         if (at > 0) text = text(:at - 1)//trim(new(i))//text(at + len_trim(old(i)):)
      end do
      call write_text(text, changed)
   end subroutine change_deck

   !> All samples of a channel.
   function channel(reader, name) result(values)
      type(history_reader_type), intent(in) :: reader
      character(*), intent(in) :: name
      real(wp), allocatable :: values(:), table(:, :)
      type(error_type), allocatable :: error
      call reader%read_channel(name, table, error)
      call check_no_error(error, name)
      allocate (values(size(table, 2)), source=table(1, :))
   end function channel

   !> Columns of numbers, separated by commas, under one line of names.
   subroutine read_columns(path, table)
      character(*), intent(in) :: path
      !> (columns, rows); their numbers are known
      real(wp), intent(out) :: table(:, :)
      integer :: unit, status, i
      open (newunit=unit, file=path, action='read', status='old', iostat=status)
      call check(status == 0, path//' opens')
      read (unit, *)
      do i = 1, size(table, 2)
         read (unit, *) table(:, i)
      end do
      close (unit)
   end subroutine read_columns

   !> The text of a file, at most 2 GB.
   function contents(path) result(text)
      character(*), intent(in) :: path
      character(:), allocatable :: text
      integer :: unit, length
      inquire (file=path, size=length)
      call check(length > 0, path//' is there')
      allocate (character(max(0, length)) :: text)
      open (newunit=unit, file=path, access='stream', action='read', status='old')
      read (unit) text
      close (unit)
   end function contents

end module runs
