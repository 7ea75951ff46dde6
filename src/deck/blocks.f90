!> Blocks: a keyword line with its options and data lines. The reader hands in the lines; finished blocks are appended to the deck.
!> Floor: deck.
module limber_deck_blocks
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, lowercase, nearest_name
   use limber_deck_cursor, only: letters, digits
   use limber_deck_compile, only: is_reserved
   use limber_deck_quantity_names, only: quantity_names
   use limber_deck_lexer, only: part_type, trimmed, find_outside, collapsed, comment_start, is_parameter_name
   use limber_deck_origin, only: origin_type
   use limber_deck_source, only: beside
   use limber_deck_synonyms, only: advice_for, successor_of
   use limber_deck_tables, only: new_table
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_schema, only: option_spec_type, needed, kind_yes
   use limber_deck_keywords, only: keyword_table, keyword_options, find_keyword
   use limber_deck_content, only: deck_type, block_type, line_type, resize_blocks, resize_lines, move_line, &
      & tell_block
   use limber_deck_values, only: read_option, suggestion
   use limber_deck_data_lines, only: read_line, expected_line
   implicit none
   private
   public :: open_block_type, begin_block, add_line, end_block, tell_unknown

   !> Limits of a deck; beyond them the reading stops with an error
   integer, parameter :: max_blocks = 200000, max_lines = 1000000

   !> The block that is being put together
   type :: open_block_type
      !> Row of its keyword in the table; 0: no block is open
      integer :: row = 0
      !> Whether the data lines are those of an unknown keyword
      logical :: skipping = .false.
      !> Whether superfluous data lines have been reported
      logical :: reported = .false.
      type(block_type) :: block
      !> Errors of the deck before it
      integer :: errors = 0
      !> Data lines of the block that were seen, those in error included, and those that were kept
      integer :: seen = 0, kept = 0
      !> Blocks in the deck, and data lines of all blocks
      integer :: blocks = 0, lines = 0
      !> Turn of *REPEAT that is being read, as an index into those of the source; 0: none
      integer :: turn = 0
      !> A limit was exceeded: reading is to stop
      logical :: full = .false.
      !> A block of an unknown keyword with a name stands right above
      logical :: after_unknown = .false.
   end type open_block_type

contains

   !> Opens a block with the fields of its keyword line.
   subroutine begin_block(self, parts, deck, diagnostics)
      type(open_block_type), intent(inout) :: self
      !> '*KEYWORD', then the options
      type(part_type), intent(in) :: parts(:)
      type(deck_type), intent(inout) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      self%reported = .false.
      self%seen = 0
      self%kept = 0
      self%row = find_keyword(parts(1)%text(2:))
      self%skipping = self%row == 0
      self%errors = diagnostics%count
      if (self%skipping) then
         call complain_keyword(parts(1), diagnostics)
         call tell_unknown(self, parts, deck, diagnostics)
      else if (self%blocks >= max_blocks) then
         call diagnostics%add(parts(1)%origin, 'the deck has more than '//as_text(max_blocks)//' blocks', &
            & 'each turn of a *REPEAT counts')
         self%full = .true.
         self%row = 0
      else
         self%block%keyword = trim(keyword_table(self%row)%name)
         self%block%origin = parts(1)%origin
         if (allocated(self%block%lines)) deallocate (self%block%lines)
         allocate (self%block%lines(4))
         call read_options(self%block, keyword_options(self%block%keyword), parts(2:), deck, diagnostics)
         call look_for_name(self%block, keyword_options(self%block%keyword), diagnostics)
         if (self%block%keyword == 'TABLE' .or. self%block%keyword == 'CURVE') call read_points(self, deck, diagnostics)
      end if
   end subroutine begin_block

   !> Takes note of what a block of an unknown keyword defines: its NAME, or parts of a body. Without both, perhaps points of the
   !> ground.
   subroutine tell_unknown(self, parts, deck, diagnostics)
      type(open_block_type), intent(inout) :: self
      !> Parts of the keyword line, or the whole line as one
      type(part_type), intent(in) :: parts(:)
      type(deck_type), intent(in) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: name
      integer :: i
      name = value_of(parts, 'NAME')
      self%after_unknown = self%after_unknown .or. name /= ''
      if (name == '') name = value_of(parts, 'BODY')
      call diagnostics%tell(name)
      if (name /= '') return
      call diagnostics%tell('ground')
      do i = self%blocks, 1, -1
         if (deck%blocks(i)%keyword /= 'FRAME' .and. deck%blocks(i)%keyword /= 'BEAM') cycle
         if (deck%blocks(i)%keyword == 'FRAME' .or. may_be_part(parts(1)%text)) call diagnostics%tell(deck%blocks(i)%name())
         return
      end do
   end subroutine tell_unknown

   !> Value of an option of an unknown keyword, in lower case; empty if it is not there.
   pure function value_of(parts, option) result(value)
      type(part_type), intent(in) :: parts(:)
      character(*), intent(in) :: option
      character(:), allocatable :: value
      integer :: i, equals
      value = ''
      do i = 1, size(parts)
         equals = find_outside(parts(i)%text, '=', 1)
         if (equals == 0) cycle
         if (index(' '//collapsed(parts(i)%text(:equals - 1)), ' '//option, back=.true.) == 0) cycle
         value = lowercase(trim(adjustl(parts(i)%text(equals + 1:))))
         value = trim(value(:index(value//',', ',') - 1))
         return
      end do
   end function value_of

   !> Whether an unknown keyword is like one of the parts of beams.
   pure logical function may_be_part(keyword)
      !> With its asterisk
      character(*), intent(in) :: keyword
      integer :: near
      may_be_part = .false.
      near = nearest_name(collapsed(keyword(2:)), keyword_table%name)
      if (near > 0) may_be_part = any(keyword_table(near)%name == [character(10) :: 'MASS', 'PROFILE', 'ATTACHMENT'])
   end function may_be_part

   !> Reads the data lines that a block takes from a file of its own; the effective deck has them in place of the file's name.
   subroutine read_points(self, deck, diagnostics)
      type(open_block_type), intent(inout) :: self
      type(deck_type), intent(inout) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      type(error_type), allocatable :: error
      type(part_type) :: content
      character(:), allocatable :: path
      integer :: i, file
      path = self%block%text('FILE')
      if (len(path) == 0) return
      path = beside(deck%source%files(self%block%origin%file)%path, path)
      call deck%source%read_file(path, self%block%origin_of('FILE'), error)
      if (allocated(error)) then
         call diagnostics%add(self%block%origin_of('FILE'), error%message, 'the path is relative to the folder of this file')
         return
      end if
      file = deck%source%count
      do i = 1, size(deck%source%files(file)%lines)
         associate (text => deck%source%files(file)%lines(i)%text)
            content = trimmed(text, origin_type(file, i, 1, 1), 1, comment_start(text) - 1)
         end associate
         if (len(content%text) == 0) cycle
         if (scan(content%text(1:1), '#"'//letters) > 0) cycle
         call add_line(self, content, deck, diagnostics)
         if (self%full) exit
      end do
      do i = 1, size(self%block%options)
         if (self%block%options(i)%name == 'FILE') self%block%options(i)%has_value = .false.
      end do
   end subroutine read_points

   !> Reports an unknown keyword, or one with a missing comma behind it.
   subroutine complain_keyword(part, diagnostics)
      type(part_type), intent(in) :: part
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: word, label
      integer :: i, near
      word = collapsed(part%text(2:))
      if (is_end_of_unknown(word, diagnostics)) return
      near = 0
      if (index(word, '=') == 0) near = nearest_name(word, pack(keyword_table%name, &
         & index(keyword_table%name, ' ') < len_trim(keyword_table%name)))
      do i = 1, size(keyword_table)
         ! A keyword of two words, such as BEAM SECTION, may be meant
         if (near > 0) exit
         if (index(word, trim(keyword_table(i)%name)//' ') /= 1) cycle
         call diagnostics%add(part%origin, "a comma is missing behind '*"//trim(keyword_table(i)%name)//"'", &
            & 'write *'//trim(keyword_table(i)%name)//', OPTION=value, ...')
         return
      end do
      if (len(word) == 0) then
         call diagnostics%add(part%origin, "a keyword is missing behind '*'", suggestion(word, keyword_table%name))
      else
         label = advice_for(word)
         if (len(label) == 0) label = suggestion(word, keyword_table%name)
         call diagnostics%add(part%origin, "there is no keyword '*"//word//"'", label)
      end if
   end subroutine complain_keyword

   !> Whether a keyword ends what an unknown one has begun, as *END STEP does: that error has been told.
   logical function is_end_of_unknown(word, diagnostics) result(is_end)
      !> In upper case, without the asterisk
      character(*), intent(in) :: word
      type(diagnostics_type), intent(inout) :: diagnostics
      is_end = index(word, 'END ') == 1
      if (is_end) is_end = diagnostics%is_told('*'//word(5:))
      if (is_end) call diagnostics%follow()
      if (.not. is_end) call diagnostics%tell('*'//word)
   end function is_end_of_unknown

   !> Reads all options of a block, fills in defaults and reports missing ones.
   subroutine read_options(block, specs, parts, deck, diagnostics)
      type(block_type), intent(inout) :: block
      type(option_spec_type), intent(in) :: specs(:)
      type(part_type), intent(in) :: parts(:)
      type(deck_type), intent(in) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      logical :: attempted(size(specs))
      character(:), allocatable :: missing
      type(part_type) :: default
      integer :: i
      if (allocated(block%options)) deallocate (block%options)
      allocate (block%options(size(specs)))
      do i = 1, size(specs)
         block%options(i)%name = specs(i)%name
         block%options(i)%kind = specs(i)%kind
         block%options(i)%text = ''
      end do
      attempted = .false.
      do i = 1, size(parts)
         if (is_data_line(parts(i), block, specs)) then
            call diagnostics%add(parts(i)%origin, "'"//parts(i)%text//"' is no option: the comma at the end of the line above "// &
               & 'makes this line a part of it', 'remove the comma')
            return
         end if
         call read_given(block, specs, parts(i), deck, attempted, diagnostics)
      end do
      missing = ''
      do i = 1, size(specs)
         if (attempted(i)) cycle
         if (specs(i)%default == needed) then
            if (len(missing) > 0) missing = missing//', '
            missing = missing//trim(specs(i)%name)
         else if (len_trim(specs(i)%default) > 0) then
            default%text = trim(specs(i)%default)
            default%origin = block%origin
            call read_option(specs(i), default, deck%parameters, block%options(i), diagnostics)
         end if
      end do
      if (len(missing) > 0) call diagnostics%add(block%origin, '*'//block%keyword//' needs '//missing, &
         & 'add '//missing(:scan(missing//',', ',') - 1)//'=value')
   end subroutine read_options

   !> Takes note of a block whose name is missing or refused: it may be any that is unknown.
   subroutine look_for_name(block, specs, diagnostics)
      type(block_type), intent(in) :: block
      type(option_spec_type), intent(in) :: specs(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i
      do i = 1, size(specs)
         if (specs(i)%name /= 'NAME' .or. block%options(i)%has_value) cycle
         if (specs(i)%default == needed .or. block%options(i)%given) diagnostics%nameless = &
            & diagnostics%nameless + 1
      end do
   end subroutine look_for_name

   !> Whether a part is the first of a data line that a comma above has joined to the keyword line.
   pure logical function is_data_line(part, block, specs)
      type(part_type), intent(in) :: part
      type(block_type), intent(in) :: block
      type(option_spec_type), intent(in) :: specs(:)
      is_data_line = part%origin%line > block%origin%line .and. len(part%text) > 0 .and. find_outside(part%text, '=', 1) == 0
      if (is_data_line) is_data_line = .not. any(specs%name == collapsed(part%text))
   end function is_data_line

   !> Reads one option as it was given.
   subroutine read_given(block, specs, part, deck, attempted, diagnostics)
      type(block_type), intent(inout) :: block
      type(option_spec_type), intent(in) :: specs(:)
      !> 'NAME=value' or 'NAME'
      type(part_type), intent(in) :: part
      type(deck_type), intent(in) :: deck
      !> Options that were given, well or badly
      logical, intent(inout) :: attempted(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      type(part_type) :: name, value, next
      character(:), allocatable :: word
      integer :: equals, i
      logical :: has_value
      if (len(part%text) == 0) then
         call diagnostics%add(part%origin, 'an option is missing between two commas')
         return
      end if
      equals = find_outside(part%text, '=', 1)
      has_value = equals > 0
      if (equals == 0) equals = len(part%text) + 1
      name = trimmed(part%text, part%origin, 1, equals - 1)
      value = trimmed(part%text, part%origin, equals + 1, len(part%text))
      word = collapsed(name%text)
      do i = size(specs), 1, -1
         if (specs(i)%name == word) exit
      end do
      if (i == 0) then
         call complain_option(block, specs, name, word, attempted, diagnostics)
         return
      end if
      attempted(i) = .true.
      call find_joined(value%text, specs, equals)
      if (equals > 0) then
         next = trimmed(value%text, value%origin, equals, len(value%text))
         call diagnostics%add(next%origin, "a comma is missing before '"//next%text//"'", 'options are separated by commas')
         ! A semicolon may stand in its place
         if (value%text(equals - 2:equals - 2) == ';') equals = equals - 2
         value = trimmed(value%text, value%origin, 1, equals - 1)
         attempted = .true.
      end if
      if (block%options(i)%given) then
         call diagnostics%add(name%origin, "the option '"//word//"' is given twice", 'remove one of the two', &
            & block%options(i)%origin, 'first given here')
         return
      end if
      block%options(i)%given = .true.
      block%options(i)%origin = name%origin
      if (len(value%text) > 0) then
         call read_option(specs(i), value, deck%parameters, block%options(i), diagnostics)
      else if (specs(i)%kind == kind_yes .and. .not. has_value) then
         block%options(i)%text = 'YES'
         block%options(i)%has_value = .true.
      else
         call diagnostics%add(name%origin, "the option '"//word//"' has no value", 'write '//word//'=value: ' &
            & //trim(specs(i)%meaning))
      end if
   end subroutine read_given

   !> Where another option begins in a value, because the comma before it is missing: column, 0 if none does.
   pure subroutine find_joined(value, specs, column)
      character(*), intent(in) :: value
      type(option_spec_type), intent(in) :: specs(:)
      integer, intent(out) :: column
      integer :: equals, i
      column = 0
      equals = find_outside(value, '=', 1)
      do i = 2, equals - 1
         if (value(i - 1:i - 1) /= ' ' .or. value(i:i) == ' ') cycle
         if (.not. any(specs%name == collapsed(value(i:equals - 1)))) cycle
         column = i
         return
      end do
   end subroutine find_joined

   subroutine complain_option(block, specs, name, word, attempted, diagnostics)
      type(block_type), intent(in) :: block
      type(option_spec_type), intent(in) :: specs(:)
      type(part_type), intent(in) :: name
      character(*), intent(in) :: word
      logical, intent(inout) :: attempted(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: label
      label = 'it takes none'
      if (size(specs) > 0) label = suggestion(word, specs%name)
      if (len(word) > 0 .and. verify(word, digits) == 0) label = 'a number has a point in place of a comma: 0.'//word
      if (len(successor_of(word)) > 0) label = successor_of(word)
      call diagnostics%add(name%origin, '*'//block%keyword//" has no option '"//word//"'", label)
      ! What is missing may be meant by it
      attempted = .true.
   end subroutine complain_option

   !> Adds a data line to the open block.
   subroutine add_line(self, content, deck, diagnostics)
      type(open_block_type), intent(inout) :: self
      !> The line without comment and blanks around; not empty
      type(part_type), intent(in) :: content
      type(deck_type), intent(inout) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      type(line_type) :: line
      logical :: ok
      if (self%skipping) return
      if (self%row == 0) then
         call diagnostics%add(content%origin, 'a data line without a keyword above it', trim(merge( &
            & '*REPEAT repeats whole blocks: begin with *KEYWORD within it; *OUTPUT, *GROUND, *NODE may stand many times', &
            & 'begin with a line *KEYWORD                                                                               ', &
            & self%turn > 0)))
         self%skipping = .true.
         return
      end if
      self%seen = self%seen + 1
      self%lines = self%lines + 1
      if (self%lines > max_lines) then
         call diagnostics%add(content%origin, 'the deck has more than '//as_text(max_lines)//' data lines')
         self%full = .true.
      else if (self%seen > keyword_table(self%row)%most_lines) then
         call complain_surplus(self, content, diagnostics)
      else
         line%content = content%text
         line%origin = content%origin
         call read_line(self%row, line, deck, ok, diagnostics)
         if (ok) call keep_line(self, line)
      end if
   end subroutine add_line

   subroutine complain_surplus(self, content, diagnostics)
      type(open_block_type), intent(inout) :: self
      type(part_type), intent(in) :: content
      type(diagnostics_type), intent(inout) :: diagnostics
      if (.not. self%reported) then
         if (keyword_table(self%row)%most_lines == 0) then
            call diagnostics%add(content%origin, '*'//self%block%keyword//' takes no data lines', &
               & 'options stand behind the keyword; a comma at the end of its line continues it')
         else
            call diagnostics%add(content%origin, '*'//self%block%keyword//' takes only one data line')
         end if
      end if
      self%reported = .true.
   end subroutine complain_surplus

   !> Adds a line to the open block; the line is empty then.
   subroutine keep_line(self, line)
      type(open_block_type), intent(inout) :: self
      type(line_type), intent(inout) :: line
      if (self%kept == size(self%block%lines)) call resize_lines(self%block%lines, 2*self%kept)
      self%kept = self%kept + 1
      call move_line(line, self%block%lines(self%kept))
   end subroutine keep_line

   !> Makes the table that the open block defines known to expressions behind it.
   subroutine define_table(self, deck, diagnostics)
      type(open_block_type), intent(in) :: self
      type(deck_type), intent(inout) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp) :: x(self%kept), y(self%kept)
      character(:), allocatable :: name
      integer :: i
      name = self%block%name('NAME')
      do i = 1, self%kept
         x(i) = self%block%lines(i)%fields(1)%value
         y(i) = self%block%lines(i)%fields(2)%value
      end do
      do i = 2, self%kept
         if (x(i) > x(i - 1)) cycle
         call diagnostics%add(self%block%lines(i)%origin_of(1), "the arguments of table '"//name//"' must increase", &
            & 'this one is not greater than the one before it')
         return
      end do
      if (self%kept < 2) then
         if (self%seen == self%kept .and. len(self%block%text('FILE')) == 0) call diagnostics%add(self%block%origin, &
            & "table '"//name//"' has too few points", 'give at least two')
      else if (is_reserved(name) .or. any(quantity_names == lowercase(name)) .or. .not. is_parameter_name(name)) then
         call diagnostics%add(self%block%origin_of('NAME'), "'"//name//"' cannot be the name of a table", &
            & 'a letter, then letters, digits and _; t, pi, functions and quantities are reserved; write '//valid_name(name))
      else if (deck%parameters%find_table(name) == 0) then
         call deck%parameters%define_table(name, new_table(x, y, self%block%word('INTERPOLATION') == 'SPLINE'))
      end if
   end subroutine define_table

   !> The nearest name that a table can have.
   pure function valid_name(name) result(valid)
      character(*), intent(in) :: name
      character(:), allocatable :: valid
      character(*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyz'
      integer :: i
      valid = lowercase(name)
      do i = 1, len(valid)
         if (verify(valid(i:i), letters//'0123456789_') > 0) valid(i:i) = '_'
      end do
      if (verify(valid(1:min(1, len(valid))), letters) > 0 .or. len(valid) == 0) valid = 'table_'//valid
      if (is_reserved(valid) .or. any(quantity_names == valid)) valid = valid//'_table'
   end function valid_name

   !> Closes the open block, if there is one, and appends it to the deck.
   subroutine end_block(self, deck, diagnostics)
      type(open_block_type), intent(inout) :: self
      type(deck_type), intent(inout) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      self%skipping = .false.
      if (self%row == 0) return
      if (self%seen < keyword_table(self%row)%least_lines .and. diagnostics%count == self%errors) then
         call diagnostics%add(self%block%origin, '*'//self%block%keyword//' needs a data line below it', &
            & expected_line(self%row))
      end if
      if (self%block%keyword == 'TABLE') call define_table(self, deck, diagnostics)
      self%row = 0
      call resize_lines(self%block%lines, self%kept)
      if (self%blocks == size(deck%blocks)) call resize_blocks(deck%blocks, max(8, 2*self%blocks))
      self%blocks = self%blocks + 1
      associate (block => deck%blocks(self%blocks))
         block%keyword = self%block%keyword
         block%origin = self%block%origin
         block%broken = diagnostics%count > self%errors
         block%after_unknown = self%after_unknown
         self%after_unknown = .false.
         if (block%broken) call tell_block(self%block, diagnostics)
         call move_alloc(self%block%options, block%options)
         call move_alloc(self%block%lines, block%lines)
      end associate
   end subroutine end_block

end module limber_deck_blocks
