!> Fields, comments and names of a line. Fields between commas, trailing comments, names. A part is a text with its origin. Floor:
!> deck.
module limber_deck_lexer
   use limber_base_text, only: uppercase
   use limber_deck_origin, only: origin_type, part_of
   use limber_deck_parameters, only: name_length
   implicit none
   private
   public :: part_type, trimmed, split_fields, comment_start, find_outside, is_comment, is_keyword_line, collapsed, is_name, &
      & is_parameter_name, keyword_of, is_point, first_foreign, unquoted, blanks

   !> Blank and tab
   character(2), parameter :: blanks = ' '//achar(9)
   character(*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ'
   !> What an object's name is made of, after the letter that it begins with
   character(*), parameter :: name_characters = letters//'0123456789_-'

   !> A piece of a line without blanks around it
   type :: part_type
      character(:), allocatable :: text
      type(origin_type) :: origin
   end type part_type

contains

   !> The part between two columns of a line, without blanks around.
   pure function trimmed(line, origin, first, last) result(part)
      !> Text that the columns count in, and its origin
      character(*), intent(in) :: line
      type(origin_type), intent(in) :: origin
      !> Columns; nothing if last < first
      integer, intent(in) :: first, last
      type(part_type) :: part
      integer :: i, j
      part%text = ''
      part%origin = part_of(origin, first, first)
      if (last < first) return
      i = verify(line(first:last), blanks)
      if (i == 0) return
      j = verify(line(first:last), blanks, back=.true.)
      part%text = line(first + i - 1:first + j - 1)
      part%origin = part_of(origin, first + i - 1, first + j - 1)
   end function trimmed

   !> The fields of a line: separated by commas outside parentheses and quotes.
   pure subroutine split_fields(line, origin, fields)
      character(*), intent(in) :: line
      type(origin_type), intent(in) :: origin
      !> At least one; an empty one is an empty text
      type(part_type), allocatable, intent(out) :: fields(:)
      integer :: first, comma, count
      count = 1
      first = 1
      do
         comma = find_outside(line, ',', first)
         if (comma == 0) exit
         count = count + 1
         first = comma + 1
      end do
      allocate (fields(count))
      first = 1
      do count = 1, size(fields)
         comma = find_outside(line, ',', first)
         if (comma == 0) comma = len(line) + 1
         fields(count) = trimmed(line, origin, first, comma - 1)
         first = comma + 1
      end do
   end subroutine split_fields

   !> Column of the first such character at or behind `first` that is outside parentheses and quotes; 0: none.
   pure integer function find_outside(line, character, first) result(column)
      character(*), intent(in) :: line
      character(1), intent(in) :: character
      integer, intent(in) :: first
      integer :: depth
      logical :: quoted
      depth = 0
      quoted = .false.
      do column = first, len(line)
         if (depth == 0 .and. .not. quoted .and. line(column:column) == character) return
         select case (line(column:column))
         case ('"'); quoted = .not. quoted
         case ('('); if (.not. quoted) depth = depth + 1
         case (')'); if (.not. quoted) depth = max(0, depth - 1)
         end select
      end do
      column = 0
   end function find_outside

   !> Column where a trailing comment begins: `**` behind a blank or a comma, outside parentheses and
   !> quotes; one behind the end if there is none.
   pure integer function comment_start(line) result(column)
      character(*), intent(in) :: line
      integer :: first
      first = 1
      do
         column = find_outside(line(first:), '*', 1)
         if (column == 0) exit
         column = column + first - 1
         if (column == len(line)) exit
         if (line(column + 1:column + 1) == '*') then
            if (column == 1) return
            if (scan(line(column - 1:column - 1), blanks//',') > 0) return
            first = column + 2
         else
            first = column + 1
         end if
         if (first > len(line)) exit
      end do
      column = len(line) + 1
   end function comment_start

   !> Whether a line is empty or a comment as a whole.
   pure logical function is_comment(line)
      character(*), intent(in) :: line
      integer :: i
      i = verify(line, blanks)
      is_comment = i == 0
      if (i > 0 .and. i < len(line)) is_comment = line(i:i + 1) == '**'
   end function is_comment

   !> Whether a line that is no comment begins a block.
   pure logical function is_keyword_line(line)
      character(*), intent(in) :: line
      integer :: i
      i = verify(line, blanks)
      is_keyword_line = .false.
      if (i > 0) is_keyword_line = line(i:i) == '*'
   end function is_keyword_line

   !> The keyword of a line that begins a block, in upper case, without the asterisk.
   pure function keyword_of(line) result(word)
      character(*), intent(in) :: line
      character(:), allocatable :: word
      type(origin_type) :: nowhere
      type(part_type) :: part
      part = trimmed(line(:min(comment_start(line), index(line//',', ',')) - 1), nowhere, 1, &
         & min(comment_start(line), index(line//',', ',')) - 1)
      word = collapsed(part%text(2:))
   end function keyword_of

   !> A keyword, option or word in the form that is compared: upper case, one blank between words.
   pure function collapsed(text) result(word)
      character(*), intent(in) :: text
      character(:), allocatable :: word
      character(len(text)) :: short
      integer :: i, n
      logical :: gap
      n = 0
      gap = .false.
      do i = 1, len(text)
         if (scan(text(i:i), blanks) > 0) then
            gap = n > 0
         else
            if (gap) n = n + 1
            if (gap) short(n:n) = ' '
            gap = .false.
            n = n + 1
            short(n:n) = text(i:i)
         end if
      end do
      word = uppercase(short(:n))
   end function collapsed

   !> Whether a text is the name of an object.
   pure logical function is_name(text)
      character(*), intent(in) :: text
      is_name = .false.
      if (len(text) == 0 .or. len(text) > name_length) return
      is_name = scan(text(1:1), letters) > 0 .and. verify(text, name_characters) == 0
   end function is_name

   !> Whether a text is the name of a parameter: without hyphens, which would be minus signs.
   pure logical function is_parameter_name(text)
      character(*), intent(in) :: text
      is_parameter_name = is_name(text) .and. index(text, '-') == 0
   end function is_parameter_name

   !> Whether a text is `object` or `object.point`.
   pure logical function is_point(text)
      character(*), intent(in) :: text
      integer :: dot
      dot = index(text, '.')
      if (dot == 0) then
         is_point = is_name(text)
      else
         is_point = is_name(text(:dot - 1)) .and. is_name(text(dot + 1:))
      end if
   end function is_point

   !> Column of the first character that no deck may hold outside comments and headings; 0: none.
   pure integer function first_foreign(line) result(column)
      character(*), intent(in) :: line
      integer :: code
      do column = 1, len(line)
         code = ichar(line(column:column))
         if (code > 126 .or. code < 32 .and. code /= 9) return
      end do
      column = 0
   end function first_foreign

   !> A text without the double quotes around it.
   pure function unquoted(text) result(inner)
      character(*), intent(in) :: text
      character(:), allocatable :: inner
      inner = text
      if (len(text) < 2) return
      if (text(1:1) == '"' .and. text(len(text):) == '"') inner = text(2:len(text) - 1)
   end function unquoted

end module limber_deck_lexer
