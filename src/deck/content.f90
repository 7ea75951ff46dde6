!> Deck after reading: blocks, options, data lines. Blocks with their options, defaults filled in, and data lines; every value with
!> its origin. The model builder works on this. Floor: deck.
module limber_deck_content
   use limber_base_kinds, only: wp
   use limber_base_names, only: name_index_type
   use limber_base_text, only: as_text, lowercase
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_origin, only: origin_type
   use limber_deck_source, only: source_type
   use limber_deck_parameters, only: parameter_list_type
   use limber_deck_expression, only: expression_type
   use limber_deck_schema, only: kind_yes, kind_word, is_integer_kind
   use limber_deck_lexer, only: collapsed
   implicit none
   private
   public :: deck_type, block_type, option_type, line_type, field_type, repeat_type, resize_blocks, resize_lines, &
      & move_line, tell_block

   !> Longest name of an option
   integer, parameter :: option_length = 20

   !> An option of a block
   type :: option_type
      !> Name in upper case
      character(option_length) :: name = ''
      integer :: kind = 0
      !> Value as text: a word in upper case, a name in lower case, a number or path as written; empty: none
      character(:), allocatable :: text
      !> Value of a number
      real(wp) :: value = 0.0_wp
      integer :: whole = 0
      !> Whether the deck gives it; whether it has a value, its default included
      logical :: given = .false., has_value = .false.
      !> The value in the deck, or the keyword if it is not given
      type(origin_type) :: origin
   end type option_type

   !> A field of a data line
   type :: field_type
      !> As written; a name or a point in lower case
      character(:), allocatable :: text
      type(origin_type) :: origin
      !> Of `name = expression`: the name in lower case, otherwise empty
      character(:), allocatable :: name
      !> Of a number or an expression
      type(expression_type) :: expression
      !> Of a constant number
      real(wp) :: value = 0.0_wp
   end type field_type

   !> A data line
   type :: line_type
      !> As written, without comment and blanks around
      character(:), allocatable :: content
      !> The line as a whole
      type(origin_type) :: origin
      !> None for free text
      type(field_type), allocatable :: fields(:)
   contains
      procedure :: count => line_count
      procedure :: text => line_text
      procedure :: number => line_number
      procedure :: origin_of => line_origin
   end type line_type

   !> A block: a keyword with its options and data lines
   type :: block_type
      !> In upper case, without the asterisk
      character(:), allocatable :: keyword
      !> The keyword in the deck
      type(origin_type) :: origin
      !> All options of the keyword in the order of the table
      type(option_type), allocatable :: options(:)
      !> Data lines
      type(line_type), allocatable :: lines(:)
      !> Whether an error stands in it, so that nothing can be built of it
      logical :: broken = .false.
      !> Whether a block of an unknown keyword with a name stands right above it
      logical :: after_unknown = .false.
   contains
      procedure :: knows
      procedure :: given
      procedure :: has
      procedure :: real => real_of
      procedure :: integer => integer_of
      procedure :: word => text_of
      procedure :: text => text_of
      procedure :: name => name_of
      procedure :: yes
      procedure :: origin_of
      procedure, private :: position
   end type block_type

   !> A *REPEAT that stands in no other
   type :: repeat_type
      !> First and last of the blocks that came of it
      integer :: first_block = 0, last_block = 0
      !> Its file, and its first and last line there
      integer :: file = 0, first_line = 0, last_line = 0
   end type repeat_type

   !> A deck
   type :: deck_type
      !> All its lines, for showing errors
      type(source_type) :: source
      type(parameter_list_type) :: parameters
      !> All blocks but *INCLUDE and *REPEAT, those in a *REPEAT once for each turn, in the order of reading
      type(block_type), allocatable :: blocks(:)
      !> The outer ones of *REPEAT, in the order of reading
      type(repeat_type), allocatable :: repeats(:)
      !> Whether all lines were read: too many blocks, lines or errors end the reading
      logical :: is_whole = .true.
      !> Blocks by 'KEYWORD name'; empty until the whole deck has been read
      type(name_index_type) :: names
   contains
      procedure :: find
      procedure :: find_named
      procedure :: index_names
      procedure :: indices
      procedure :: set_option
      procedure :: set_number
   end type deck_type

contains

   !> Takes note of a block in error: what depends on an object that it makes is no error of its own.
   subroutine tell_block(block, diagnostics)
      type(block_type), intent(in) :: block
      type(diagnostics_type), intent(inout) :: diagnostics
      character(6), parameter :: driven(3) = [character(6) :: '_x', '_y', '_angle']
      character(:), allocatable :: name
      integer :: i
      name = block%name()
      call diagnostics%tell(name)
      if (block%keyword == 'GROUND') call diagnostics%tell('ground')
      if (block%keyword /= 'MOTION' .or. name == '') return
      do i = 1, size(driven)
         call diagnostics%tell(name//trim(driven(i)))
      end do
   end subroutine tell_block

   !> Index of an option. A name that the keyword does not have is an error in the program and ends it: a pure procedure has no
   !> other way to do that than to deallocate what is not allocated.
   pure integer function position(self, name)
      class(block_type), intent(in) :: self
      character(*), intent(in) :: name
      integer, allocatable :: option_that_the_keyword_table_does_not_have
      do position = size(self%options), 1, -1
         if (self%options(position)%name == name) return
      end do
      deallocate (option_that_the_keyword_table_does_not_have)
   end function position

   !> Whether the keyword has an option of this name: to be asked before, where a procedure serves several keywords.
   pure logical function knows(self, name)
      class(block_type), intent(in) :: self
      !> Name of the option in upper case; so in all procedures below
      character(*), intent(in) :: name
      knows = any(self%options%name == name)
   end function knows

   !> Whether the deck gives an option.
   pure logical function given(self, name)
      class(block_type), intent(in) :: self
      character(*), intent(in) :: name
      given = self%options(self%position(name))%given
   end function given

   !> Whether an option has a value, given or by default.
   pure logical function has(self, name)
      class(block_type), intent(in) :: self
      character(*), intent(in) :: name
      has = self%options(self%position(name))%has_value
   end function has

   !> The value of a number [unit of the table]; 0 if it has none.
   pure real(wp) function real_of(self, name) result(value)
      class(block_type), intent(in) :: self
      character(*), intent(in) :: name
      value = self%options(self%position(name))%value
   end function real_of

   !> The value of a whole number; 0 if it has none.
   pure integer function integer_of(self, name) result(value)
      class(block_type), intent(in) :: self
      character(*), intent(in) :: name
      value = self%options(self%position(name))%whole
   end function integer_of

   !> The value as text: a word in upper case, a name or point in lower case; empty if it has none.
   pure function text_of(self, name) result(text)
      class(block_type), intent(in) :: self
      character(*), intent(in) :: name
      character(:), allocatable :: text
      integer :: i
      i = self%position(name)
      text = ''
      if (allocated(self%options(i)%text)) text = self%options(i)%text
   end function text_of

   !> The name of the object that the block defines, or the one that an option refers to, in lower case.
   pure function name_of(self, name) result(text)
      class(block_type), intent(in) :: self
      !> Default: NAME
      character(*), intent(in), optional :: name
      character(:), allocatable :: text
      if (present(name)) then
         text = self%text(name)
      else if (self%knows('NAME')) then
         text = self%text('NAME')
      else
         text = ''
      end if
   end function name_of

   !> Whether an option of the kind YES or NO says yes.
   pure logical function yes(self, name)
      class(block_type), intent(in) :: self
      character(*), intent(in) :: name
      yes = self%text(name) == 'YES'
   end function yes

   !> Where the value of an option stands; the keyword if it is not given.
   pure type(origin_type) function origin_of(self, name) result(origin)
      class(block_type), intent(in) :: self
      character(*), intent(in) :: name
      integer :: i
      i = self%position(name)
      origin = self%origin
      if (self%options(i)%given) origin = self%options(i)%origin
   end function origin_of

   !> Number of fields of a line.
   pure integer function line_count(self) result(count)
      class(line_type), intent(in) :: self
      count = size(self%fields)
   end function line_count

   !> The i-th field as text; a name or a point in lower case.
   pure function line_text(self, i) result(text)
      class(line_type), intent(in) :: self
      integer, intent(in) :: i
      character(:), allocatable :: text
      text = self%fields(i)%text
   end function line_text

   !> The i-th field as a constant number.
   pure real(wp) function line_number(self, i) result(value)
      class(line_type), intent(in) :: self
      integer, intent(in) :: i
      value = self%fields(i)%value
   end function line_number

   !> Where the i-th field stands.
   pure type(origin_type) function line_origin(self, i) result(origin)
      class(line_type), intent(in) :: self
      integer, intent(in) :: i
      origin = self%fields(i)%origin
   end function line_origin

   !> Index of the next block of a keyword behind a block; 0: no more. `i = deck%find('BEAM', i)` from 0 on.
   pure integer function find(self, keyword, behind) result(found)
      class(deck_type), intent(in) :: self
      !> In upper case
      character(*), intent(in) :: keyword
      !> Default 0
      integer, intent(in), optional :: behind
      integer :: first
      first = 1
      if (present(behind)) first = behind + 1
      do found = first, size(self%blocks)
         if (self%blocks(found)%keyword == keyword) return
      end do
      found = 0
   end function find

   !> Index of the block of given keywords that defines a name; 0: none.
   pure integer function find_named(self, keywords, name) result(found)
      class(deck_type), intent(in) :: self
      !> In upper case, separated by |
      character(*), intent(in) :: keywords
      !> In any case
      character(*), intent(in) :: name
      integer :: first, bar, at
      found = 0
      first = 1
      do while (first <= len(keywords))
         bar = index(keywords(first:), '|')
         if (bar == 0) bar = len(keywords) - first + 2
         at = self%names%find(keywords(first:first + bar - 2)//' '//lowercase(name))
         if (at > 0 .and. (found == 0 .or. at < found)) found = at
         first = first + bar
      end do
   end function find_named

   !> Enters the names of all blocks, so that they can be found; of equal ones the first counts.
   pure subroutine index_names(self)
      class(deck_type), intent(inout) :: self
      integer :: i
      call self%names%shorten(0)
      do i = size(self%blocks), 1, -1
         if (self%blocks(i)%name() /= '') call self%names%add(self%blocks(i)%keyword//' '//self%blocks(i)%name(), i)
      end do
   end subroutine index_names

   !> Gives a list of blocks another length; what it holds is moved, not copied.
   pure subroutine resize_blocks(blocks, length)
      type(block_type), allocatable, intent(inout) :: blocks(:)
      integer, intent(in) :: length
      type(block_type), allocatable :: resized(:)
      integer :: i
      allocate (resized(length))
      do i = 1, min(length, size(blocks))
         call move_alloc(blocks(i)%keyword, resized(i)%keyword)
         resized(i)%origin = blocks(i)%origin
         resized(i)%broken = blocks(i)%broken
         resized(i)%after_unknown = blocks(i)%after_unknown
         call move_alloc(blocks(i)%options, resized(i)%options)
         call move_alloc(blocks(i)%lines, resized(i)%lines)
      end do
      call move_alloc(resized, blocks)
   end subroutine resize_blocks

   !> Gives a list of data lines another length; the lines are moved, not copied.
   pure subroutine resize_lines(lines, length)
      type(line_type), allocatable, intent(inout) :: lines(:)
      integer, intent(in) :: length
      type(line_type), allocatable :: resized(:)
      integer :: i
      if (size(lines) == length) return
      allocate (resized(length))
      do i = 1, min(length, size(lines))
         call move_line(lines(i), resized(i))
      end do
      call move_alloc(resized, lines)
   end subroutine resize_lines

   !> Moves a data line; nothing is left in the first place.
   pure subroutine move_line(from, to)
      type(line_type), intent(inout) :: from, to
      call move_alloc(from%content, to%content)
      call move_alloc(from%fields, to%fields)
      to%origin = from%origin
   end subroutine move_line

   !> Indices of all blocks of a keyword in order.
   pure function indices(self, keyword) result(list)
      class(deck_type), intent(in) :: self
      character(*), intent(in) :: keyword
      integer, allocatable :: list(:)
      integer :: i, count
      count = 0
      i = self%find(keyword)
      do while (i > 0)
         count = count + 1
         i = self%find(keyword, i)
      end do
      allocate (list(count))
      count = 0
      i = self%find(keyword)
      do while (i > 0)
         count = count + 1
         list(count) = i
         i = self%find(keyword, i)
      end do
   end function indices

   !> Sets a word, text or YES/NO that was left open in the deck, so that the effective deck shows it.
   pure subroutine set_option(self, block, name, text, given)
      class(deck_type), intent(inout) :: self
      !> Index of the block
      integer, intent(in) :: block
      !> Option in upper case, and its value
      character(*), intent(in) :: name, text
      !> Whether it counts as given by the deck; default: as before
      logical, intent(in), optional :: given
      integer :: i
      i = self%blocks(block)%position(name)
      associate (option => self%blocks(block)%options(i))
         option%text = text
         if (present(given)) option%given = given
         if (option%kind == kind_word .or. option%kind == kind_yes) option%text = collapsed(text)
         option%has_value = .true.
      end associate
   end subroutine set_option

   !> Sets a number, whole or not, in place of that of the deck.
   pure subroutine set_number(self, block, name, value, given)
      class(deck_type), intent(inout) :: self
      !> Index of the block
      integer, intent(in) :: block
      !> Option in upper case
      character(*), intent(in) :: name
      !> In the unit of the table
      real(wp), intent(in) :: value
      !> As in `set_option`
      logical, intent(in), optional :: given
      integer :: i
      i = self%blocks(block)%position(name)
      associate (option => self%blocks(block)%options(i))
         option%value = value
         if (present(given)) option%given = given
         if (is_integer_kind(option%kind)) option%whole = nint(value)
         option%text = as_text(value)
         option%has_value = .true.
      end associate
   end subroutine set_number

end module limber_deck_content
