!> Reader of decks: from files to blocks. Files and their lines become blocks; every error is collected with its place. The first
!> station of the data flow; the model builder takes it from here. Floor: deck.
!>
!>     call read_deck('rod.inp', deck, diagnostics)
!>     if (diagnostics%count > 0) print '(a)', diagnostics%render(deck%source)
module limber_deck_reader
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use limber_deck_origin, only: origin_type, after
   use limber_deck_source, only: source_file_type, beside
   use limber_deck_lexer, only: part_type, trimmed, split_fields, comment_start, is_comment, is_keyword_line, first_foreign, &
      & is_parameter_name, keyword_of
   use limber_deck_diagnostics, only: diagnostics_type, max_errors
   use limber_deck_families, only: settle_models
   use limber_deck_compile, only: looks_like_operand, is_reserved
   use limber_deck_parameters, only: parameter_type, override_type
   use limber_deck_schema, only: form_text
   use limber_deck_keywords, only: keyword_table, load_language
   use limber_deck_content, only: deck_type, repeat_type, resize_blocks
   use limber_deck_blocks, only: open_block_type, begin_block, add_line, end_block, tell_unknown
   use limber_deck_checks, only: check_deck
   use limber_deck_values, only: suggestion
   implicit none
   private
   public :: read_deck, read_deck_text, beside

   !> Longest line, deepest nesting of *INCLUDE and greatest number of files
   integer, parameter :: max_line = 4096, max_nesting = 20, max_files = 200
   !> Most turns of all *REPEAT together
   integer, parameter :: max_turns = 200000

contains

   !> Reads a deck from a file.
   subroutine read_deck(path, deck, diagnostics, overrides)
      !> File to read
      character(*), intent(in) :: path
      !> The deck; complete only if there are no errors
      type(deck_type), intent(out) :: deck
      !> Receives all errors
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Values that parameters have in place of those of the deck
      type(override_type), intent(in), optional :: overrides(:)
      type(error_type), allocatable :: error
      type(origin_type) :: nowhere
      allocate (deck%blocks(0))
      if (present(overrides)) allocate (deck%parameters%overrides, source=overrides)
      call deck%source%read_file(path, nowhere, error)
      if (allocated(error)) then
         call diagnostics%add(nowhere, error%message)
      else
         call read_all(deck, diagnostics)
      end if
   end subroutine read_deck

   !> Reads a deck from a text.
   subroutine read_deck_text(path, text, deck, diagnostics, overrides)
      !> Path to show; *INCLUDE is relative to its folder
      character(*), intent(in) :: path
      !> The whole deck, lines separated by line feeds
      character(*), intent(in) :: text
      type(deck_type), intent(out) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Values that parameters have in place of those of the deck
      type(override_type), intent(in), optional :: overrides(:)
      allocate (deck%blocks(0))
      if (present(overrides)) allocate (deck%parameters%overrides, source=overrides)
      call deck%source%add_text(path, text)
      call read_all(deck, diagnostics)
   end subroutine read_deck_text

   subroutine read_all(deck, diagnostics)
      type(deck_type), intent(inout) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      type(open_block_type) :: assembly
      call load_language()
      allocate (deck%repeats(0))
      call read_lines(1, 1, assembly, deck, diagnostics)
      call resize_blocks(deck%blocks, assembly%blocks)
      if (assembly%blocks == 0 .and. diagnostics%count == 0) &
         & call diagnostics%add(origin_type(file=1), 'the deck is empty')
      call deck%index_names()
      call settle_models(deck)
      deck%is_whole = .not. assembly%full
      if (deck%is_whole) call check_deck(deck, diagnostics)
      deck%is_whole = deck%is_whole .and. diagnostics%count < max_errors
      call check_overrides(deck, diagnostics)
   end subroutine read_all

   !> Complains of values from outside for parameters that the deck does not define.
   subroutine check_overrides(deck, diagnostics)
      type(deck_type), intent(in) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i
      if (.not. allocated(deck%parameters%overrides)) return
      do i = 1, size(deck%parameters%overrides)
         associate (override => deck%parameters%overrides(i))
            if (override%used) cycle
            if (deck%parameters%count == 0) then
               call diagnostics%add(origin_type(file=1), "the deck has no parameter '"//trim(override%name)//"' to be set", &
                  & 'define it: *PARAMETER, then name = value')
            else
               call diagnostics%add(origin_type(file=1), "the deck has no parameter '"//trim(override%name)//"' to be set", &
                  & suggestion(trim(override%name), deck%parameters%items(:deck%parameters%count)%name))
            end if
         end associate
      end do
   end subroutine check_overrides

   !> Reads all lines of one file.
   recursive subroutine read_lines(file, nesting, assembly, deck, diagnostics)
      !> Index of the file in the source, and how deep it is included (1: not at all); copies, as the deck grows meanwhile
      integer, value :: file, nesting
      type(open_block_type), intent(inout) :: assembly
      type(deck_type), intent(inout) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      if (is_binary(deck%source%files(file))) then
         call diagnostics%add(origin_type(file=file), 'this file is not a text: it holds bytes that are 0')
         return
      end if
      call read_stretch(file, 1, size(deck%source%files(file)%lines), nesting, assembly, deck, diagnostics)
   end subroutine read_lines

   !> Reads some lines of a file.
   recursive subroutine read_stretch(file, first, last, nesting, assembly, deck, diagnostics)
      !> Index of the file, first and last line, how deep it is included; copies
      integer, value :: file, first, last, nesting
      type(open_block_type), intent(inout) :: assembly
      type(deck_type), intent(inout) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      type(part_type), allocatable :: parts(:)
      type(part_type) :: content
      integer :: i, head
      logical :: ok, broken
      i = first - 1
      do while (i < last .and. .not. assembly%full .and. diagnostics%count < max_errors)
         i = i + 1
         call clean_line(file, i, is_free_text(assembly), assembly%turn, deck, content, ok, broken, diagnostics)
         if (broken) call skip_broken(deck%source%files(file)%lines(i)%text, assembly, deck, diagnostics)
         if (.not. ok) cycle
         if (is_keyword_line(content%text)) then
            call end_block(assembly, deck, diagnostics)
            head = i
            call read_keyword_line(file, i, last, content, deck, parts, diagnostics)
            call begin_block(assembly, parts, deck, diagnostics)
            if (assembly%row > 0) then
               select case (assembly%block%keyword)
               case ('INCLUDE'); call include(file, nesting, assembly, deck, diagnostics)
               case ('REPEAT'); call repeat_lines(file, head, i, last, nesting, assembly, deck, diagnostics)
               case ('END REPEAT')
                  call diagnostics%add(assembly%block%origin, 'there is no *REPEAT that this *END REPEAT ends')
                  call drop_block(assembly, deck, diagnostics)
               end select
            end if
         else
            call add_line(assembly, content, deck, diagnostics)
         end if
      end do
      call end_block(assembly, deck, diagnostics)
   end subroutine read_stretch

   !> Closes the open block without keeping it.
   subroutine drop_block(assembly, deck, diagnostics)
      type(open_block_type), intent(inout) :: assembly
      type(deck_type), intent(inout) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      call end_block(assembly, deck, diagnostics)
      assembly%blocks = assembly%blocks - 1
   end subroutine drop_block

   !> Reads what an open *REPEAT repeats, once for each turn.
   recursive subroutine repeat_lines(file, head, line, last, nesting, assembly, deck, diagnostics)
      !> File, line of the *REPEAT; copies
      integer, value :: file, head
      !> Last line of its options; on return that of its *END REPEAT
      integer, intent(inout) :: line
      !> Line to end before or at; how deep the file is included; copies
      integer, value :: last, nesting
      type(open_block_type), intent(inout) :: assembly
      type(deck_type), intent(inout) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      type(repeat_type) :: stretch
      type(parameter_type) :: counter
      character(:), allocatable :: outside
      integer :: i, from, turns, outer, known, end
      call begin_repeat(assembly, deck, counter, from, turns, diagnostics)
      end = end_of_repeat(deck%source%files(file), line, last)
      if (end > last) then
         call diagnostics%add(assembly%block%origin, 'this *REPEAT has no *END REPEAT', &
            & 'it stands in the same file, and each *REPEAT within has its own')
         ! What it would repeat is not known
         assembly%full = .true.
      end if
      call drop_block(assembly, deck, diagnostics)
      outer = assembly%turn
      outside = deck%source%turn_label(outer)
      if (outer > 0) outside = outside//', '
      known = deck%parameters%count
      stretch = repeat_type(assembly%blocks + 1, 0, file, head, end)
      do i = from, from + turns - 1
         if (assembly%full) exit
         if (deck%source%turn_count >= max_turns) then
            call diagnostics%add(counter%origin, 'the deck has more than '//as_text(max_turns)//' turns of *REPEAT')
            assembly%full = .true.
            exit
         end if
         call deck%source%add_turn(outside//trim(counter%name)//' = '//as_text(i))
         assembly%turn = deck%source%turn_count
         counter%value = real(i, wp)
         call deck%parameters%define(counter)
         call read_stretch(file, line + 1, end - 1, nesting, assembly, deck, diagnostics)
         call deck%parameters%shorten(known)
      end do
      assembly%turn = outer
      stretch%last_block = assembly%blocks
      if (outer == 0 .and. stretch%last_block >= stretch%first_block) call keep_repeat(deck, stretch)
      line = end
   end subroutine repeat_lines

   !> Index and number of turns of an open *REPEAT.
   subroutine begin_repeat(assembly, deck, counter, from, turns, diagnostics)
      type(open_block_type), intent(in) :: assembly
      type(deck_type), intent(in) :: deck
      !> The index, yet without a value
      type(parameter_type), intent(out) :: counter
      !> First value; one turn if what is to be repeated is in error, for the errors in there
      integer, intent(out) :: from, turns
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: taken
      associate (block => assembly%block)
         counter%name = block%name('INDEX')
         counter%origin = block%origin_of('INDEX')
         from = block%integer('FROM')
         turns = block%integer('COUNT')
         if (.not. block%has('COUNT')) turns = 1
         turns = min(turns, huge(turns) - from)
         if (.not. block%has('INDEX')) return
         taken = deck%parameters%find(trim(counter%name))
         if (.not. is_parameter_name(trim(counter%name)) .or. is_reserved(trim(counter%name))) then
            call diagnostics%add(counter%origin, "'"//trim(counter%name)//"' cannot be an index", &
               & 'a letter, then letters, digits and _; t, pi and the functions are reserved')
         else if (taken > 0) then
            call diagnostics%add(counter%origin, "the index '"//trim(counter%name)//"' is a parameter already", &
               & 'give it another name', deck%parameters%items(taken)%origin, 'first defined here')
         end if
      end associate
   end subroutine begin_repeat

   !> Line of the *END REPEAT that belongs to a *REPEAT; one behind the last line if there is none.
   pure integer function end_of_repeat(file, line, last) result(end)
      type(source_file_type), intent(in) :: file
      !> Last line of the *REPEAT and its options; line to stop at
      integer, intent(in) :: line, last
      integer :: depth
      depth = 1
      do end = line + 1, last
         if (len(file%lines(end)%text) > max_line .or. .not. is_keyword_line(file%lines(end)%text)) cycle
         if (is_comment(file%lines(end)%text)) cycle
         select case (keyword_of(file%lines(end)%text))
         case ('REPEAT'); depth = depth + 1
         case ('END REPEAT'); depth = depth - 1
         end select
         if (depth == 0) return
      end do
   end function end_of_repeat

   !> Takes note of a *REPEAT in no other, for the effective deck.
   pure subroutine keep_repeat(deck, stretch)
      type(deck_type), intent(inout) :: deck
      type(repeat_type), intent(in) :: stretch
      type(repeat_type), allocatable :: longer(:)
      integer :: count
      count = size(deck%repeats)
      allocate (longer(count + 1))
      longer(:count) = deck%repeats
      longer(count + 1) = stretch
      call move_alloc(longer, deck%repeats)
   end subroutine keep_repeat

   !> Takes note of a line in error, so that what it leaves out is not reported as missing.
   subroutine skip_broken(line, assembly, deck, diagnostics)
      character(*), intent(in) :: line
      type(open_block_type), intent(inout) :: assembly
      type(deck_type), intent(inout) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      type(part_type) :: parts(1)
      if (is_keyword_line(line)) then
         call end_block(assembly, deck, diagnostics)
         parts(1)%text = line
         call tell_unknown(assembly, parts, deck, diagnostics)
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
      type(open_block_type), intent(in) :: assembly
      is_free_text = .false.
      if (assembly%row > 0) is_free_text = keyword_table(assembly%row)%form == form_text
   end function is_free_text

   !> The content of a line without comment and blanks around.
   subroutine clean_line(file, number, free_text, turn, deck, content, ok, broken, diagnostics)
      integer, intent(in) :: file, number
      !> Whether the line may be free text
      logical, intent(in) :: free_text
      !> Turn of a *REPEAT that it is read in
      integer, intent(in) :: turn
      type(deck_type), intent(in) :: deck
      type(part_type), intent(out) :: content
      !> Whether there is a content; whether that is for an error in the line
      logical, intent(out) :: ok, broken
      type(diagnostics_type), intent(inout) :: diagnostics
      type(origin_type) :: start
      integer :: last, foreign
      start = origin_type(file, number, 1, 1, turn)
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
               call diagnostics%add(origin_type(file, number, foreign, foreign, turn), 'this character cannot stand here', &
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
      if (column + 2 > len(line)) return
      if (.not. looks_like_operand(line(column + 2:), line(:column - 1), deck%parameters)) return
      broken = .true.
      call diagnostics%add(origin_type(start%file, start%line, column, column + 1, start%turn), &
         & "'**' behind a blank begins a comment, but this looks like a power", &
         & 'write a power without the blank, t**2, or begin the comment with a word')
   end subroutine check_power

   !> The fields of a keyword line and of the lines that continue it.
   subroutine read_keyword_line(file, number, end, first, deck, parts, diagnostics)
      integer, intent(in) :: file
      !> Number of the line; on return that of the last line that belongs to it
      integer, intent(inout) :: number
      !> Line to stop at
      integer, intent(in) :: end
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
         do while (.not. ok .and. next < end)
            next = next + 1
            call clean_line(file, next, .false., first%origin%turn, deck, content, ok, broken, diagnostics)
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
      !> Index of the including file, and its nesting; copies
      integer, value :: file, nesting
      type(open_block_type), intent(inout) :: assembly
      type(deck_type), intent(inout) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      type(error_type), allocatable :: error
      type(origin_type) :: origin
      character(:), allocatable :: path
      integer :: again
      path = assembly%block%text('FILE')
      origin = assembly%block%origin_of('FILE')
      call drop_block(assembly, deck, diagnostics)
      if (len(path) == 0) return
      path = beside(deck%source%files(file)%path, path)
      again = 0
      if (origin%turn > 0) again = opened(origin, deck)
      if (is_open(path, file, deck)) then
         call diagnostics%add(origin, "the file '"//path//"' includes itself", chain(file, deck)//' -> '//path)
      else if (nesting >= max_nesting) then
         call diagnostics%add(origin, '*INCLUDE is nested more than '//as_text(max_nesting)//' deep', chain(file, deck))
      else if (again > 0) then
         if (deck%source%files(again)%path /= path) call diagnostics%add(origin, 'another file than in an earlier turn', &
            & 'each turn of a *REPEAT includes the same files')
         call read_lines(again, nesting + 1, assembly, deck, diagnostics)
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

   !> Index of the file that an *INCLUDE at an origin has brought in already, in an earlier turn; 0: none.
   pure integer function opened(origin, deck) result(file)
      type(origin_type), intent(in) :: origin
      type(deck_type), intent(in) :: deck
      do file = deck%source%count, 1, -1
         associate (at => deck%source%files(file)%included_at)
            if (at%file == origin%file .and. at%line == origin%line) return
         end associate
      end do
   end function opened

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
