!> Reads a deck: files and their lines become blocks; every error is collected with its place. The first
!> station of the data flow; the model builder takes it from here. Floor: deck.
!>
!>     call read_deck('rod.inp', deck, diagnostics)
!>     if (diagnostics%count > 0) print '(a)', diagnostics%render(deck%source)
module limber_deck_reader
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use limber_deck_origin, only: origin_type, after
   use limber_deck_source, only: source_file_type, beside
   use limber_deck_lexer, only: part_type, trimmed, split_fields, comment_start, is_comment, is_keyword_line, first_foreign
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_compile, only: looks_like_expression
   use limber_deck_schema, only: form_text
   use limber_deck_keywords, only: keyword_table
   use limber_deck_content, only: deck_type, block_type
   use limber_deck_assembly, only: assembly_type, begin_block, add_line, end_block
   use limber_deck_checks, only: check_deck
   implicit none
   private
   public :: read_deck, read_deck_text, beside, deck_type, block_type, diagnostics_type

   !> Longest line, deepest nesting of *INCLUDE and greatest number of files
   integer, parameter :: max_line = 4096, max_nesting = 20, max_files = 200

contains

   !> Reads a deck from a file.
   subroutine read_deck(path, deck, diagnostics)
      !> File to read
      character(*), intent(in) :: path
      !> The deck; complete only if there are no errors
      type(deck_type), intent(out) :: deck
      !> Receives all errors
      type(diagnostics_type), intent(inout) :: diagnostics
      type(error_type), allocatable :: error
      type(origin_type) :: nowhere
      allocate (deck%blocks(0))
      call deck%source%read_file(path, nowhere, error)
      if (allocated(error)) then
         call diagnostics%add(nowhere, error%message)
      else
         call read_all(deck, diagnostics)
      end if
   end subroutine read_deck

   !> Reads a deck from a text.
   subroutine read_deck_text(path, text, deck, diagnostics)
      !> Path to show; *INCLUDE is relative to its folder
      character(*), intent(in) :: path
      !> The whole deck, lines separated by line feeds
      character(*), intent(in) :: text
      type(deck_type), intent(out) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      allocate (deck%blocks(0))
      call deck%source%add_text(path, text)
      call read_all(deck, diagnostics)
   end subroutine read_deck_text

   subroutine read_all(deck, diagnostics)
      type(deck_type), intent(inout) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      type(assembly_type) :: assembly
      type(block_type), allocatable :: blocks(:)
      call read_lines(1, 1, assembly, deck, diagnostics)
      allocate (blocks(assembly%blocks))
      blocks = deck%blocks(:assembly%blocks)
      call move_alloc(blocks, deck%blocks)
      if (assembly%blocks == 0 .and. diagnostics%count == 0) &
         & call diagnostics%add(origin_type(file=1), 'the deck is empty')
      call check_deck(deck, diagnostics)
   end subroutine read_all

   !> Reads all lines of one file.
   recursive subroutine read_lines(file, nesting, assembly, deck, diagnostics)
      !> Index of the file in the source, and how deep it is included (1: not at all)
      integer, intent(in) :: file, nesting
      type(assembly_type), intent(inout) :: assembly
      type(deck_type), intent(inout) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      type(part_type), allocatable :: parts(:)
      type(part_type) :: content
      integer :: i
      logical :: ok, broken
      if (is_binary(deck%source%files(file))) then
         call diagnostics%add(origin_type(file=file), 'this file is not a text: it holds bytes that are 0')
         return
      end if
      i = 0
      do while (i < size(deck%source%files(file)%lines) .and. .not. assembly%full)
         i = i + 1
         call clean_line(file, i, is_free_text(assembly), deck, content, ok, broken, diagnostics)
         if (broken) call skip_broken(is_keyword_line(deck%source%files(file)%lines(i)%text), assembly, deck, diagnostics)
         if (.not. ok) cycle
         if (is_keyword_line(content%text)) then
            call end_block(assembly, deck, diagnostics)
            call read_keyword_line(file, i, content, deck, parts, diagnostics)
            call begin_block(assembly, parts, deck, diagnostics)
            if (assembly%row > 0) then
               if (assembly%block%keyword == 'INCLUDE') call include(file, nesting, assembly, deck, diagnostics)
            end if
         else
            call add_line(assembly, content, deck, diagnostics)
         end if
      end do
      call end_block(assembly, deck, diagnostics)
   end subroutine read_lines

   !> Takes note of a line in error, so that what it leaves out is not reported as missing.
   subroutine skip_broken(keyword, assembly, deck, diagnostics)
      !> Whether the line begins a block
      logical, intent(in) :: keyword
      type(assembly_type), intent(inout) :: assembly
      type(deck_type), intent(inout) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      if (keyword) then
         call end_block(assembly, deck, diagnostics)
         assembly%skipping = .true.
      else
         assembly%seen = assembly%seen + 1
      end if
   end subroutine skip_broken

   !> Whether a file is no text.
   pure logical function is_binary(file)
      type(source_file_type), intent(in) :: file
      integer :: i
      is_binary = .false.
      do i = 1, size(file%lines)
         is_binary = index(file%lines(i)%text, achar(0)) > 0
         if (is_binary) return
      end do
   end function is_binary

   !> Whether data lines are free text now.
   pure logical function is_free_text(assembly)
      type(assembly_type), intent(in) :: assembly
      is_free_text = .false.
      if (assembly%row > 0) is_free_text = keyword_table(assembly%row)%form == form_text
   end function is_free_text

   !> The content of a line without comment and blanks around.
   subroutine clean_line(file, number, free_text, deck, content, ok, broken, diagnostics)
      integer, intent(in) :: file, number
      !> Whether the line may be free text
      logical, intent(in) :: free_text
      type(deck_type), intent(in) :: deck
      type(part_type), intent(out) :: content
      !> Whether there is a content; whether that is for an error in the line
      logical, intent(out) :: ok, broken
      type(diagnostics_type), intent(inout) :: diagnostics
      type(origin_type) :: start
      integer :: last, foreign
      start = origin_type(file, number, 1, 1)
      broken = .false.
      ok = .false.
      associate (line => deck%source%files(file)%lines(number)%text)
         if (is_comment(line)) return
         last = len(line)
         if (last > max_line) then
            call diagnostics%add(start, 'the line has more than '//as_text(max_line)//' characters')
            broken = .true.
            return
         end if
         if (is_keyword_line(line) .or. .not. free_text) then
            last = comment_start(line) - 1
            call check_power(line, last + 1, start, deck, broken, diagnostics)
            foreign = first_foreign(line(:last))
            if (foreign > 0) then
               call diagnostics%add(origin_type(file, number, foreign, foreign), 'this character cannot stand here', &
                  & 'only comments and *HEADING take others than plain ASCII')
               broken = .true.
            end if
         end if
         content = trimmed(line, start, 1, last)
         ok = len(content%text) > 0 .and. .not. broken
      end associate
   end subroutine clean_line

   !> Reports a power that is written with a blank before the asterisks, so that it looks like a comment.
   subroutine check_power(line, column, start, deck, broken, diagnostics)
      character(*), intent(in) :: line
      !> Where the comment begins
      integer, intent(in) :: column
      !> Origin of the line
      type(origin_type), intent(in) :: start
      type(deck_type), intent(in) :: deck
      !> Set if so
      logical, intent(inout) :: broken
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: last
      if (column + 2 > len(line)) return
      last = column + 1 + comment_start(line(column + 2:)) - 1
      if (.not. looks_like_expression(line(column + 2:last), deck%parameters)) return
      broken = .true.
      call diagnostics%add(origin_type(start%file, start%line, column, column + 1), &
         & "'**' behind a blank begins a comment, but this looks like a power", &
         & 'write a power without the blank, t**2, or begin the comment with a word')
   end subroutine check_power

   !> The fields of a keyword line and of the lines that continue it.
   subroutine read_keyword_line(file, number, first, deck, parts, diagnostics)
      integer, intent(in) :: file
      !> Number of the line; on return that of the last line that belongs to it
      integer, intent(inout) :: number
      !> Content of the first line
      type(part_type), intent(in) :: first
      type(deck_type), intent(in) :: deck
      type(part_type), allocatable, intent(out) :: parts(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      type(part_type), allocatable :: more(:)
      type(part_type) :: content, last, nothing(0)
      integer :: next
      logical :: ok, broken
      call split_fields(first%text, first%origin, parts)
      last = first
      next = number
      do while (size(parts) > 1 .and. len(parts(size(parts))%text) == 0)
         ok = .false.
         do while (.not. ok .and. next < size(deck%source%files(file)%lines))
            next = next + 1
            call clean_line(file, next, .false., deck, content, ok, broken, diagnostics)
            if (broken) return
         end do
         if (ok) ok = .not. is_keyword_line(content%text)
         if (.not. ok) then
            call join(parts, nothing)
            call diagnostics%add(after(last%origin), 'the line ends in a comma, but no line continues it', &
               & 'remove the comma')
            return
         end if
         number = next
         last = content
         call split_fields(content%text, content%origin, more)
         call join(parts, more)
      end do
   end subroutine read_keyword_line

   !> Replaces the last, empty part by more of them.
   pure subroutine join(parts, more)
      type(part_type), allocatable, intent(inout) :: parts(:)
      type(part_type), intent(in) :: more(:)
      type(part_type), allocatable :: longer(:)
      integer :: count
      count = size(parts) - 1
      allocate (longer(count + size(more)))
      longer(:count) = parts(:count)
      longer(count + 1:) = more
      call move_alloc(longer, parts)
   end subroutine join

   !> Reads the file that an *INCLUDE names.
   recursive subroutine include(file, nesting, assembly, deck, diagnostics)
      !> Index of the including file, and its nesting
      integer, intent(in) :: file, nesting
      type(assembly_type), intent(inout) :: assembly
      type(deck_type), intent(inout) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      type(error_type), allocatable :: error
      type(origin_type) :: origin
      character(:), allocatable :: path
      path = assembly%block%text('FILE')
      origin = assembly%block%origin_of('FILE')
      call end_block(assembly, deck, diagnostics)
      assembly%blocks = assembly%blocks - 1
      if (len(path) == 0) return
      path = beside(deck%source%files(file)%path, path)
      if (is_open(path, file, deck)) then
         call diagnostics%add(origin, "the file '"//path//"' includes itself", chain(file, deck)//' -> '//path)
      else if (nesting >= max_nesting) then
         call diagnostics%add(origin, '*INCLUDE is nested more than '//as_text(max_nesting)//' deep', chain(file, deck))
      else if (deck%source%count >= max_files) then
         call diagnostics%add(origin, 'the deck has more than '//as_text(max_files)//' files')
         assembly%full = .true.
      else
         call deck%source%read_file(path, origin, error)
         if (allocated(error)) then
            call diagnostics%add(origin, error%message, 'the path is relative to the folder of this file')
         else
            call read_lines(deck%source%count, nesting + 1, assembly, deck, diagnostics)
         end if
      end if
   end subroutine include

   !> Whether a path is a file or one of those that include it.
   pure logical function is_open(path, file, deck)
      character(*), intent(in) :: path
      integer, intent(in) :: file
      type(deck_type), intent(in) :: deck
      integer :: i
      i = file
      is_open = .false.
      do while (i > 0 .and. .not. is_open)
         is_open = deck%source%files(i)%path == path
         i = deck%source%files(i)%included_at%file
      end do
   end function is_open

   !> 'deck -> included -> included', down to a file.
   pure function chain(file, deck) result(text)
      integer, intent(in) :: file
      type(deck_type), intent(in) :: deck
      character(:), allocatable :: text
      integer :: i
      text = deck%source%files(file)%path
      i = deck%source%files(file)%included_at%file
      do while (i > 0)
         text = deck%source%files(i)%path//' -> '//text
         i = deck%source%files(i)%included_at%file
      end do
   end function chain

end module limber_deck_reader
