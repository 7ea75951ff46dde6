!> Errors and warnings of a deck with line and caret. The reader and the model builder add to it; `main` prints what `render`
!> returns. Floor: deck.
module limber_deck_diagnostics
   use limber_base_names, only: name_index_type
   use limber_base_text, only: as_text, newline
   use limber_deck_origin, only: origin_type
   use limber_deck_source, only: source_type
   implicit none
   private
   public :: diagnostics_type, max_shown, max_errors

   !> So many are shown; the rest is counted
   integer, parameter :: max_shown = 50
   !> So many are kept
   integer, parameter :: max_kept = 1000
   !> So many errors end the reading of a deck and the building of its model
   integer, parameter :: max_errors = 10000
   !> Columns of a source line that are shown
   integer, parameter :: window = 160

   !> One error or warning
   type :: diagnostic_type
      !> Where
      type(origin_type) :: origin
      !> What is wrong, and beside the caret what to do about it
      character(:), allocatable :: message, label
      !> A second place, such as the first definition (file 0: none), and what it is
      type(origin_type) :: second_origin
      character(:), allocatable :: second_label
      !> The unknown name that it is about, for the reader to say whether it is defined further down
      character(:), allocatable :: about
      !> Whether the deck can be used all the same
      logical :: is_warning = .false.
   end type diagnostic_type

   !> All errors and warnings so far
   type :: diagnostics_type
      !> In the order of finding; only the first `kept` are in use
      type(diagnostic_type), allocatable :: items(:)
      !> Number of items in use
      integer :: kept = 0
      !> Number of errors and of warnings found, and of those errors that follow from others and are not shown
      integer :: count = 0, warnings = 0, silent = 0
      !> Objects whose definition is in error or missing, told already: what is said of them again is not shown
      type(name_index_type) :: told
      !> Number of objects whose names are in error: the first unknown names may be theirs, and are not shown
      integer :: nameless = 0
   contains
      procedure :: add
      procedure :: follow
      procedure :: tell
      procedure :: is_told
      procedure :: warn
      procedure :: render
   end type diagnostics_type

contains

   !> Adds an error.
   subroutine add(self, origin, message, label, second_origin, second_label, about, object)
      class(diagnostics_type), intent(inout) :: self
      !> Where
      type(origin_type), intent(in) :: origin
      !> What is wrong: one line that begins in lower case
      character(*), intent(in) :: message
      !> Text beside the caret
      character(*), intent(in), optional :: label
      !> A second place and its text
      type(origin_type), intent(in), optional :: second_origin
      character(*), intent(in), optional :: second_label
      !> The unknown name that it is about
      character(*), intent(in), optional :: about
      !> The object that is missing, or that of its point: shown once, and not at all if its definition is in error
      character(*), intent(in), optional :: object
      type(diagnostic_type) :: item
      if (present(object) .and. self%nameless > 0 .and. .not. self%is_told(object)) then
         self%nameless = self%nameless - 1
         call self%tell(object)
      end if
      if (self%is_told(about) .or. self%is_told(object)) then
         call self%follow()
         return
      end if
      self%count = self%count + 1
      call self%tell(object)
      call self%tell(about)
      item%origin = origin
      item%message = message
      item%label = ''
      item%second_label = ''
      if (present(label)) item%label = label
      if (present(second_origin)) item%second_origin = second_origin
      if (present(second_label)) item%second_label = second_label
      if (present(about)) item%about = about
      call keep(self, item)
   end subroutine add

   !> Counts an error that follows from another one, and is not shown.
   subroutine follow(self)
      class(diagnostics_type), intent(inout) :: self
      self%count = self%count + 1
      self%silent = self%silent + 1
   end subroutine follow

   !> Takes note of an object in error: what depends on it is no error of its own.
   subroutine tell(self, name)
      class(diagnostics_type), intent(inout) :: self
      !> In lower case; absent or empty: none
      character(*), intent(in), optional :: name
      if (.not. present(name)) return
      if (len_trim(name) > 0 .and. self%told%find(trim(name)) == 0) call self%told%add(trim(name), 1)
   end subroutine tell

   !> Whether an object is in error, or missing, as said before.
   pure logical function is_told(self, name)
      class(diagnostics_type), intent(in) :: self
      character(*), intent(in), optional :: name
      is_told = .false.
      if (present(name)) is_told = self%told%find(trim(name)) > 0
   end function is_told

   !> Adds a warning.
   subroutine warn(self, origin, message, label)
      class(diagnostics_type), intent(inout) :: self
      !> Where
      type(origin_type), intent(in) :: origin
      !> What is doubtful, and the text beside the caret
      character(*), intent(in) :: message
      character(*), intent(in), optional :: label
      type(diagnostic_type) :: item
      item%origin = origin
      item%message = message
      item%label = ''
      item%second_label = ''
      item%is_warning = .true.
      if (present(label)) item%label = label
      self%warnings = self%warnings + 1
      call keep(self, item)
   end subroutine warn

   subroutine keep(self, item)
      class(diagnostics_type), intent(inout) :: self
      type(diagnostic_type), intent(in) :: item
      type(diagnostic_type), allocatable :: longer(:)
      if (self%kept == max_kept) return
      if (item%origin%turn > 0) then
         if (is_kept(self, item)) return
      end if
      if (.not. allocated(self%items)) allocate (self%items(8))
      if (self%kept == size(self%items)) then
         allocate (longer(2*self%kept))
         longer(:self%kept) = self%items
         call move_alloc(longer, self%items)
      end if
      self%kept = self%kept + 1
      self%items(self%kept) = item
   end subroutine keep

   !> Whether the same has been said of an earlier turn of a *REPEAT.
   pure logical function is_kept(self, item)
      class(diagnostics_type), intent(in) :: self
      type(diagnostic_type), intent(in) :: item
      integer :: i
      is_kept = .false.
      do i = 1, self%kept
         associate (a => self%items(i)%origin, b => item%origin)
            is_kept = a%file == b%file .and. a%line == b%line .and. a%first == b%first .and. self%items(i)%message == item%message
         end associate
         if (is_kept) return
      end do
   end function is_kept

   !> Everything as text, sorted by file and line, without a trailing newline; empty if there is nothing.
   function render(self, source) result(text)
      class(diagnostics_type), intent(in) :: self
      !> The files that the origins point into
      type(source_type), intent(in) :: source
      character(:), allocatable :: text
      integer :: order(self%kept), i, shown
      text = ''
      call sort(self, order)
      shown = min(self%kept, max_shown)
      do i = 1, shown
         if (i > 1) text = text//newline
         text = text//rendered(self%items(order(i)), source)
      end do
      if (self%count - self%silent + self%warnings > shown) text = text//newline//'... and ' &
         & //as_text(self%count - self%silent + self%warnings - shown)//' more'
   end function render

   !> Indices of the items by file, line and column; equal ones stay in the order of finding.
   pure subroutine sort(self, order)
      class(diagnostics_type), intent(in) :: self
      integer, intent(out) :: order(:)
      integer :: i, j, item
      do i = 1, self%kept
         item = i
         do j = i - 1, 1, -1
            if (.not. before(self%items(item)%origin, self%items(order(j))%origin)) exit
            order(j + 1) = order(j)
         end do
         order(j + 1) = item
      end do
   end subroutine sort

   pure logical function before(a, b)
      type(origin_type), intent(in) :: a, b
      if (a%file /= b%file) then
         before = a%file < b%file
      else if (a%line /= b%line) then
         before = a%line < b%line
      else
         before = a%first < b%first
      end if
   end function before

   !> One item: header, line and caret, and the second line and caret.
   function rendered(item, source) result(text)
      type(diagnostic_type), intent(in) :: item
      type(source_type), intent(in) :: source
      character(:), allocatable :: text, kind
      kind = 'error: '
      if (item%is_warning) kind = 'warning: '
      text = place(item%origin, source)//kind//item%message
      if (item%origin%turn > 0) text = text//' (*REPEAT, '//source%turn_label(item%origin%turn)//')'
      if (item%origin%line > 0) then
         text = text//newline//pointed(item%origin, item%label, source)
      else if (len(item%label) > 0) then
         text = text//' ('//item%label//')'
      end if
      if (item%second_origin%file == 0) return
      if (item%second_origin%file /= item%origin%file) &
         & text = text//newline//'  in '//source%path_of(item%second_origin)//included(item%second_origin%file, source)//':'
      text = text//newline//pointed(item%second_origin, item%second_label, source)
   end function rendered

   !> ', included at path:line' of an included file.
   function included(file, source) result(text)
      integer, intent(in) :: file
      type(source_type), intent(in) :: source
      character(:), allocatable :: text
      text = ''
      associate (by => source%files(file)%included_at)
         if (by%file > 0) text = ', included at '//source%path_of(by)//':'//as_text(by%line)
      end associate
   end function included

   !> 'path:line:column: ', as far as there is one.
   function place(origin, source) result(text)
      type(origin_type), intent(in) :: origin
      type(source_type), intent(in) :: source
      character(:), allocatable :: text
      text = source%path_of(origin)
      if (len(text) == 0) return
      if (origin%line > 0) text = text//':'//as_text(origin%line)//':'//as_text(origin%first)
      text = text//': '
   end function place

   !> The source line, and below it the carets and the label.
   function pointed(origin, label, source) result(text)
      type(origin_type), intent(in) :: origin
      character(*), intent(in) :: label
      type(source_type), intent(in) :: source
      character(:), allocatable :: text, line, shown, head, number
      integer :: from, to, first, last
      line = printable(source%line_at(origin))
      first = max(1, min(origin%first, len(line) + 1))
      last = max(first, min(origin%last, max(len(line), first)))
      from = 1
      if (len(line) > window .and. first > window/2) from = first - window/4
      to = min(len(line), from + window - 1)
      last = max(first, min(last, to))
      shown = line(from:to)
      head = ''
      if (from > 1) head = '... '
      if (to < len(line)) shown = shown//' ...'
      number = as_text(origin%line)
      number = repeat(' ', max(0, 5 - len(number)))//number
      text = number//' | '//head//shown//newline &
         & //repeat(' ', len(number))//' | '//repeat(' ', len(head) + width(line(from:first - 1))) &
         & //repeat('^', max(1, width(line(first:min(last, len(line))))))
      if (len(label) > 0) text = text//' '//label
   end function pointed

   !> Number of columns that a text takes on a terminal: UTF-8 continuation bytes take none.
   pure integer function width(text)
      character(*), intent(in) :: text
      integer :: i
      width = 0
      do i = 1, len(text)
         if (iand(ichar(text(i:i)), 192) /= 128) width = width + 1
      end do
   end function width

   !> The line as it can be shown: tabs as one blank, other control characters, and all bytes
   !> beyond ASCII if they are not UTF-8, as a question mark.
   pure function printable(line) result(shown)
      character(*), intent(in) :: line
      character(len(line)) :: shown
      logical :: utf8
      integer :: i
      utf8 = is_utf8(line)
      do i = 1, len(line)
         select case (ichar(line(i:i)))
         case (9); shown(i:i) = ' '
         case (0:8, 10:31, 127); shown(i:i) = '?'
         case (128:)
            shown(i:i) = line(i:i)
            if (.not. utf8) shown(i:i) = '?'
         case default; shown(i:i) = line(i:i)
         end select
      end do
   end function printable

   !> Whether lead bytes and continuation bytes follow one another as in UTF-8.
   pure logical function is_utf8(text)
      character(*), intent(in) :: text
      integer :: i, pending
      pending = 0
      is_utf8 = .false.
      do i = 1, len(text)
         select case (ichar(text(i:i)))
         case (:127)
            if (pending /= 0) return
         case (128:191)
            if (pending == 0) return
            pending = pending - 1
         case (194:223)
            if (pending /= 0) return
            pending = 1
         case (224:239)
            if (pending /= 0) return
            pending = 2
         case (240:244)
            if (pending /= 0) return
            pending = 3
         case default
            return
         end select
      end do
      is_utf8 = pending == 0
   end function is_utf8

end module limber_deck_diagnostics
