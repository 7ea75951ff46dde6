!> Text of a deck as lines of all its files. Included files belong to it. Kept with the deck as long as errors may have to be shown.
!> Floor: deck.
module limber_deck_source
   use limber_base_error, only: error_type, raise, status_deck
   use limber_base_files, only: kind_of_path, longest_path, path_free, path_folder, path_other
   use limber_base_text, only: as_text, newline
   use limber_base_kinds, only: long
   use limber_deck_origin, only: origin_type
   implicit none
   private
   public :: source_type, source_file_type, beside, max_file_bytes

   !> A file longer than this is no deck
   integer, parameter :: max_file_bytes = 32*1024*1024

   !> One line without its line end
   type :: text_line_type
      character(:), allocatable :: text
   end type text_line_type

   !> One file of a deck
   type :: source_file_type
      !> Path as it is shown: as given by the user, or joined to the folder of the including file
      character(:), allocatable :: path
      !> All lines
      type(text_line_type), allocatable :: lines(:)
      !> The *INCLUDE that brought it in (file 0 for the deck itself)
      type(origin_type) :: included_at
   end type source_file_type

   !> One turn of a *REPEAT
   type :: turn_type
      !> Indices and their values, for messages: 'i = 3, j = 1'
      character(:), allocatable :: label
   end type turn_type

   !> All files of a deck in the order of opening
   type :: source_type
      !> Only the first `count` are in use
      type(source_file_type), allocatable :: files(:)
      !> Number of files
      integer :: count = 0
      !> Turns of *REPEAT; only the first `turn_count` are in use
      type(turn_type), allocatable :: turns(:)
      integer :: turn_count = 0
   contains
      procedure :: read_file
      procedure :: add_text
      procedure :: add_turn
      procedure :: turn_label
      procedure :: text_of
      procedure :: line_at
      procedure :: path_of
      procedure :: paths
   end type source_type

contains

   !> Reads a file and adds it as the last one; on error nothing is added.
   subroutine read_file(self, path, included_at, error)
      class(source_type), intent(inout) :: self
      !> Path to open
      character(*), intent(in) :: path
      !> The *INCLUDE, or an origin without a file
      type(origin_type), intent(in) :: included_at
      !> Missing, unreadable, a folder, or too long
      type(error_type), allocatable, intent(out) :: error
      character(:), allocatable :: text
      call slurp(path, text, error)
      if (.not. allocated(error)) call self%add_text(path, text, included_at)
   end subroutine read_file

   !> Adds a text as if it were the content of a file.
   subroutine add_text(self, path, text, included_at)
      class(source_type), intent(inout) :: self
      !> Path to show
      character(*), intent(in) :: path
      !> Lines separated by LF or CR LF; the last line end may be missing
      character(*), intent(in) :: text
      !> The *INCLUDE, or an origin without a file
      type(origin_type), intent(in), optional :: included_at
      type(source_file_type), allocatable :: longer(:)
      integer :: i
      if (.not. allocated(self%files)) allocate (self%files(4))
      if (self%count == size(self%files)) then
         allocate (longer(2*self%count))
         do i = 1, self%count
            longer(i)%path = self%files(i)%path
            longer(i)%included_at = self%files(i)%included_at
            call move_alloc(self%files(i)%lines, longer(i)%lines)
         end do
         call move_alloc(longer, self%files)
      end if
      self%count = self%count + 1
      self%files(self%count)%path = path
      if (present(included_at)) self%files(self%count)%included_at = included_at
      call split_lines(text, self%files(self%count)%lines)
   end subroutine add_text

   !> Adds a turn of a *REPEAT as the last one.
   pure subroutine add_turn(self, label)
      class(source_type), intent(inout) :: self
      !> Indices and their values
      character(*), intent(in) :: label
      type(turn_type), allocatable :: longer(:)
      integer :: i
      if (.not. allocated(self%turns)) allocate (self%turns(16))
      if (self%turn_count == size(self%turns)) then
         allocate (longer(2*self%turn_count))
         do i = 1, self%turn_count
            call move_alloc(self%turns(i)%label, longer(i)%label)
         end do
         call move_alloc(longer, self%turns)
      end if
      self%turn_count = self%turn_count + 1
      self%turns(self%turn_count)%label = label
   end subroutine add_turn

   !> Indices and their values in a turn; empty if there is none.
   pure function turn_label(self, turn) result(label)
      class(source_type), intent(in) :: self
      integer, intent(in) :: turn
      character(:), allocatable :: label
      label = ''
      if (turn >= 1 .and. turn <= self%turn_count) label = self%turns(turn)%label
   end function turn_label

   !> Lines of a file as one text, each with a line feed at its end.
   pure function text_of(self, file, first, last) result(text)
      class(source_type), intent(in) :: self
      !> Index of the file; first and last line
      integer, intent(in) :: file, first, last
      character(:), allocatable :: text
      integer :: i, length, at
      length = 0
      do i = first, last
         length = length + len(self%files(file)%lines(i)%text) + 1
      end do
      allocate (character(length) :: text)
      at = 0
      do i = first, last
         associate (line => self%files(file)%lines(i)%text)
            text(at + 1:at + len(line)) = line
            at = at + len(line) + 1
            text(at:at) = newline
         end associate
      end do
   end function text_of

   !> The text of the line at an origin; empty if there is none.
   pure function line_at(self, origin) result(text)
      class(source_type), intent(in) :: self
      type(origin_type), intent(in) :: origin
      character(:), allocatable :: text
      text = ''
      if (origin%file < 1 .or. origin%file > self%count) return
      if (origin%line < 1 .or. origin%line > size(self%files(origin%file)%lines)) return
      text = self%files(origin%file)%lines(origin%line)%text
   end function line_at

   !> The path of the file at an origin; empty if there is none.
   pure function path_of(self, origin) result(path)
      class(source_type), intent(in) :: self
      type(origin_type), intent(in) :: origin
      character(:), allocatable :: path
      path = ''
      if (origin%file >= 1 .and. origin%file <= self%count) path = self%files(origin%file)%path
   end function path_of

   !> Paths of all files, padded with blanks.
   pure function paths(self) result(list)
      class(source_type), intent(in) :: self
      character(longest_path) :: list(self%count)
      integer :: i
      do i = 1, self%count
         list(i) = self%files(i)%path
      end do
   end function paths

   !> Reads a whole file into a text.
   subroutine slurp(path, text, error)
      character(*), intent(in) :: path
      character(:), allocatable, intent(out) :: text
      type(error_type), allocatable, intent(out) :: error
      character(200) :: reason
      integer :: unit, status
      integer(long) :: bytes
      call check_readable(path, error)
      if (allocated(error)) return
      reason = ''
      open (newunit=unit, file=path, access='stream', form='unformatted', status='old', action='read', &
         & iostat=status, iomsg=reason)
      if (status /= 0) then
         call raise(error, "cannot open '"//path//"': "//trim(reason), status_deck)
         return
      end if
      inquire (unit=unit, size=bytes)
      if (bytes < 0) then
         call raise(error, "cannot read '"//path//"': it is not a regular file", status_deck)
      else if (bytes > max_file_bytes) then
         call raise(error, "cannot read '"//path//"': "//as_text(bytes)//' bytes are more than the ' &
            & //as_text(max_file_bytes)//' of the longest deck', status_deck)
      else
         allocate (character(int(bytes)) :: text)
         if (bytes > 0) read (unit, iostat=status, iomsg=reason) text
         if (status /= 0) call raise(error, "cannot read '"//path//"': "//trim(reason), status_deck)
      end if
      close (unit, iostat=status)
   end subroutine slurp

   !> Refuses what is no file with content: a pipe would be waited for.
   subroutine check_readable(path, error)
      character(*), intent(in) :: path
      type(error_type), allocatable, intent(out) :: error
      integer :: kind
      kind = path_free
      if (len_trim(path) > 0) kind = kind_of_path(path)
      select case (kind)
      case (path_free); call raise(error, "there is no file '"//path//"'", status_deck)
      case (path_folder); call raise(error, "cannot read '"//path//"': it is a folder", status_deck)
      case (path_other); call raise(error, "cannot read '"//path//"': it is a pipe or a device, not a file", status_deck)
      end select
   end subroutine check_readable

   !> Cuts a text into lines; a byte-order mark and carriage returns before a line end are dropped.
   subroutine split_lines(text, lines)
      character(*), intent(in) :: text
      type(text_line_type), allocatable, intent(out) :: lines(:)
      character(1), parameter :: line_feed = achar(10), carriage_return = achar(13)
      character(3), parameter :: mark = char(239)//char(187)//char(191)
      integer :: start, first, last, count, i
      start = 1
      if (len(text) >= 3) then
         if (text(1:3) == mark) start = 4
      end if
      count = 0
      do i = start, len(text)
         if (text(i:i) == line_feed) count = count + 1
      end do
      if (len(text) >= start) then
         if (text(len(text):) /= line_feed) count = count + 1
      end if
      allocate (lines(count))
      first = start
      do i = 1, count
         last = index(text(first:), line_feed)
         last = merge(len(text), first + last - 2, last == 0)
         if (last >= first) then
            lines(i)%text = text(first:last)
            if (text(last:last) == carriage_return) lines(i)%text = text(first:last - 1)
         else
            lines(i)%text = ''
         end if
         first = last + 2
      end do
   end subroutine split_lines

   !> A path that is relative to the folder of a file.
   pure function beside(file, path) result(joined)
      character(*), intent(in) :: file, path
      character(:), allocatable :: joined
      joined = path
      do while (index(joined, './') == 1 .and. len(joined) > 2)
         joined = joined(3:)
      end do
      if (joined(1:1) /= '/') joined = file(:index(file, '/', back=.true.))//joined
   end function beside

end module limber_deck_source
