!> Journal of the rows of a sweep. Each process that runs rows writes a journal of its own, a line when a row begins and a line when
!> it ends, at once to the disk. So nothing that was done is lost, whatever happens, and nobody waits for anybody. Floor: commands.
module limber_commands_sweep_rows
   use limber_base_error, only: error_type, raise, status_deck
   use limber_base_files, only: append_text, files_like, longest_path, kind_of_path, path_file
   use limber_base_kinds, only: wp
   use limber_base_names, only: name_index_type
   use limber_base_process, only: host_name, own_number
   use limber_base_text, only: as_text, newline
   use limber_commands_sweep_plan, only: sweep_type
   implicit none
   private
   public :: row_type, journal_type, open_journal, note_begin, note_end, read_journals, is_journal, begun_last

   !> How a row has ended: not at all, well, with a deck that cannot be used, with a run that could not finish, with a crash
   integer, parameter, public :: row_missing = 0, row_done = 1, row_refused = 2, row_failed = 3, row_crashed = 4
   character(8), parameter, public :: row_states(0:4) = [character(8) :: 'missing', 'ok', 'refused', 'failed', 'crashed']

   !> What came of a row
   type :: row_type
      integer :: state = row_missing
      !> Earlier row with the same values, which is run for both; 0: there is none
      integer :: same_as = 0
      !> CPU seconds; estimated relative error, negative if there is none; number of warnings
      real(wp) :: seconds = 0.0_wp, error = -1.0_wp
      integer :: warnings = 0
      !> Scalars (scalars)
      real(wp), allocatable :: scalars(:)
      !> Why it has not ended well, or its first warning
      character(:), allocatable :: message
   end type row_type

   !> A journal that is being written
   type :: journal_type
      character(:), allocatable, private :: path
   end type journal_type

   character(1), parameter :: tab = achar(9)
   !> Longest line of a journal
   integer, parameter :: longest = 65536

contains

   !> Name of the journal of a process.
   function journal_name(folder, process) result(name)
      character(*), intent(in) :: folder
      !> Its number on this machine
      integer, intent(in) :: process
      character(:), allocatable :: name
      name = folder//'/'//host_name()//'-'//as_text(process)//'.journal'
   end function journal_name

   !> Opens the journal of this process.
   subroutine open_journal(folder, journal, error)
      character(*), intent(in) :: folder
      type(journal_type), intent(out) :: journal
      type(error_type), allocatable, intent(out) :: error
      logical :: ok
      journal%path = journal_name(folder, own_number())
      call append_text(journal%path, '', ok)
      if (.not. ok) call raise(error, 'cannot write into the folder '//folder, status_deck)
   end subroutine open_journal

   subroutine note_begin(journal, key)
      type(journal_type), intent(in) :: journal
      character(*), intent(in) :: key
      logical :: ignored
      call append_text(journal%path, key//tab//'begun'//newline, ignored)
   end subroutine note_begin

   !> Notes how a row has ended.
   subroutine note_end(journal, key, row, ok)
      type(journal_type), intent(in) :: journal
      character(*), intent(in) :: key
      type(row_type), intent(in) :: row
      !> False if it cannot be written
      logical, intent(out) :: ok
      character(:), allocatable :: scalars
      integer :: i
      scalars = ''
      do i = 1, size(row%scalars)
         scalars = scalars//' '//as_text(row%scalars(i))
      end do
      call append_text(journal%path, key//tab//trim(row_states(row%state))//tab//as_text(row%seconds, 6)//tab// &
         & as_text(row%error)//tab//as_text(row%warnings)//tab//as_text(size(row%scalars))//scalars//tab// &
         & plain(row%message)//tab//'.'//newline, ok)
   end subroutine note_end

   !> A message as one line without tabs, of a length that fits; between its lines stands ' / '.
   pure function plain(text) result(line)
      character(*), intent(in) :: text
      character(:), allocatable :: line
      integer :: i
      line = ''
      do i = 1, min(len(text), 4096)
         if (text(i:i) == newline .and. i < len(text)) then
            line = trim(line)//' / '
         else if (iachar(text(i:i)) >= 32) then
            line = line//text(i:i)
         end if
      end do
   end function plain

   !> All rows as far as they are done. Rows with the same values are one run: the later ones have what came of the first.
   subroutine read_journals(folder, sweep, rows)
      character(*), intent(in) :: folder
      type(sweep_type), intent(in) :: sweep
      type(row_type), allocatable, intent(out) :: rows(:)
      type(name_index_type) :: places
      character(longest_path), allocatable :: journals(:)
      integer :: i, first
      allocate (rows(size(sweep%keys)))
      do i = 1, size(rows)
         rows(i)%message = ''
         allocate (rows(i)%scalars(size(sweep%scalars)), source=0.0_wp)
         rows(i)%same_as = places%find(sweep%keys(i))
         if (rows(i)%same_as == 0) call places%add(sweep%keys(i), i)
      end do
      call files_like(folder, '.journal', journals)
      do i = 1, size(journals)
         call read_journal(trim(journals(i)), places, rows)
      end do
      do i = 1, size(rows)
         first = rows(i)%same_as
         if (first == 0) cycle
         rows(i) = rows(first)
         rows(i)%same_as = first
         rows(i)%seconds = 0.0_wp
      end do
   end subroutine read_journals

   !> Whether a file is a journal: empty, or its first line is one.
   logical function is_journal(path)
      character(*), intent(in) :: path
      character(longest) :: line
      integer :: unit, status, first, last
      is_journal = .false.
      if (kind_of_path(path) /= path_file) return
      open (newunit=unit, file=path, action='read', recl=longest, iostat=status)
      if (status /= 0) return
      read (unit, '(a)', iostat=status) line
      is_journal = status /= 0
      close (unit)
      if (is_journal) return
      first = index(line, tab)
      last = first + index(line(first + 1:)//tab, tab)
      if (first > 1) is_journal = any([character(8) :: 'begun', row_states(1:)] == line(first + 1:last - 1))
   end function is_journal

   subroutine read_journal(path, places, rows)
      character(*), intent(in) :: path
      type(name_index_type), intent(in) :: places
      type(row_type), intent(inout) :: rows(:)
      character(longest) :: line
      integer :: unit, status
      if (kind_of_path(path) /= path_file) return
      open (newunit=unit, file=path, action='read', recl=longest, iostat=status)
      if (status /= 0) return
      do
         read (unit, '(a)', iostat=status) line
         if (status /= 0) exit
         call read_entry(trim(line), places, rows)
      end do
      close (unit)
   end subroutine read_journal

   !> A line of a journal; one that was cut off, or belongs to no row of the plan, is passed over.
   subroutine read_entry(line, places, rows)
      character(*), intent(in) :: line
      type(name_index_type), intent(in) :: places
      type(row_type), intent(inout) :: rows(:)
      integer :: ends(8), i, place, state, count, status
      ends = 0
      do i = 1, 7
         ends(i + 1) = ends(i) + index(line(ends(i) + 1:), tab)
         if (ends(i + 1) == ends(i)) return
      end do
      if (line(ends(8) + 1:) /= '.') return
      place = places%find(field(1))
      if (place == 0) return
      do state = ubound(row_states, 1), 1, -1
         if (row_states(state) == field(2)) exit
      end do
      associate (row => rows(place))
         if (row%state == row_done) return
         read (line(ends(3) + 1:ends(6) - 1), *, iostat=status) row%seconds, row%error, row%warnings
         read (line(ends(6) + 1:ends(7) - 1), *, iostat=status) count
         if (count == size(row%scalars) .and. status == 0) read (line(ends(6) + 1:ends(7) - 1), *, iostat=status) count, row%scalars
         if (status == 0) row%state = state
         row%message = field(7)
      end associate

   contains

      pure function field(number)
         integer, intent(in) :: number
         character(:), allocatable :: field
         field = line(ends(number) + 1:ends(number + 1) - 1)
      end function field

   end subroutine read_entry

   !> The key of the row that a process had begun and not ended; empty if there is none.
   function begun_last(folder, process) result(key)
      character(*), intent(in) :: folder
      integer, intent(in) :: process
      character(:), allocatable :: key
      character(longest) :: line
      integer :: unit, status, cut
      key = ''
      open (newunit=unit, file=journal_name(folder, process), action='read', recl=longest, iostat=status)
      if (status /= 0) return
      do
         read (unit, '(a)', iostat=status) line
         if (status /= 0) exit
         cut = index(line, tab)
         if (cut == 0) cycle
         if (line(cut + 1:) == 'begun') then
            key = line(:cut - 1)
         else
            key = ''
         end if
      end do
      close (unit)
   end function begun_last

end module limber_commands_sweep_rows
