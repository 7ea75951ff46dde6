!> Effective deck: the deck with all defaults and values. All that a run used, defaults included and numbers evaluated, as a deck
!> that can be read again. It is stored with the results. Floor: deck.
module limber_deck_effective
   use limber_base_text, only: as_text, newline
   use limber_deck_schema, only: form_none, form_text, form_assignments, kind_text, kind_path, kind_label, &
      & is_number_kind, is_integer_kind, is_expression_kind, field_spec_type, option_spec_type
   use limber_deck_keywords, only: keyword_table, keyword_fields, keyword_options, find_keyword
   use limber_deck_content, only: deck_type, block_type, option_type, line_type, repeat_type
   use limber_deck_families, only: is_void
   use limber_deck_idle_options, only: is_idle
   use limber_deck_lexer, only: is_comment, is_keyword_line, keyword_of
   use limber_deck_origin, only: origin_type
   implicit none
   private
   public :: effective_deck

   !> Columns that keyword lines are kept within
   integer, parameter :: width = 100

contains

   !> The text of the effective deck, ending with a line feed. Parameters are kept, each with its value; an
   !> expression of time or of quantities stands as it was written, and so does all that a *REPEAT repeats.
   function effective_deck(deck) result(text)
      type(deck_type), intent(in) :: deck
      character(:), allocatable :: text
      integer :: i, next, length
      text = ''
      length = 0
      next = 1
      i = 1
      do while (i <= size(deck%blocks))
         do while (next <= size(deck%repeats))
            if (deck%repeats(next)%last_block >= i) exit
            next = next + 1
         end do
         if (next <= size(deck%repeats)) then
            if (deck%repeats(next)%first_block == i) then
               call append(text, length, repeat_text(deck, deck%repeats(next)))
               i = deck%repeats(next)%last_block + 1
               cycle
            end if
         end if
         call append(text, length, block_text(deck%blocks(i)))
         i = i + 1
      end do
      text = text(:length)
   end function effective_deck

   !> Adds to a text that has room ahead.
   pure subroutine append(text, length, part)
      character(:), allocatable, intent(inout) :: text
      !> Characters in use
      integer, intent(inout) :: length
      character(*), intent(in) :: part
      character(:), allocatable :: longer
      if (length + len(part) > len(text)) then
         allocate (character(2*(length + len(part))) :: longer)
         longer(:length) = text(:length)
         call move_alloc(longer, text)
      end if
      text(length + 1:length + len(part)) = part
      length = length + len(part)
   end subroutine append

   !> A *REPEAT as it was written, with the files that it includes in their places.
   function repeat_text(deck, repeat) result(text)
      type(deck_type), intent(in) :: deck
      type(repeat_type), intent(in) :: repeat
      character(:), allocatable :: text
      text = source_text(deck, repeat%file, repeat%first_line, repeat%last_line)
   end function repeat_text

   recursive function source_text(deck, file, first, last) result(text)
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: file, first, last
      character(:), allocatable :: text, included
      integer :: i, begin, inner, end
      text = ''
      included = ''
      begin = first
      do i = first, last
         if (.not. is_include(deck%source%line_at(origin_type(file, i)))) cycle
         ! The block may go on in lines that follow
         inner = 0
         end = i
         do while (inner == 0 .and. end <= last)
            inner = included_file(deck, file, end)
            end = end + 1
         end do
         if (inner == 0) cycle
         ! In two statements: gfortran 12 loses what stands before a function that calls itself
         text = text//deck%source%text_of(file, begin, i - 1)
         included = source_text(deck, inner, 1, size(deck%source%files(inner)%lines))
         text = text//included
         begin = end
      end do
      text = text//deck%source%text_of(file, begin, last)
   end function source_text

   !> Whether a line begins an *INCLUDE.
   pure logical function is_include(line)
      character(*), intent(in) :: line
      is_include = .false.
      if (.not. is_keyword_line(line) .or. is_comment(line)) return
      is_include = keyword_of(line) == 'INCLUDE'
   end function is_include

   !> The file that was included by a line; 0: none.
   pure integer function included_file(deck, file, line) result(inner)
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: file, line
      do inner = deck%source%count, 1, -1
         if (deck%source%files(inner)%included_at%file == file .and. deck%source%files(inner)%included_at%line == line) return
      end do
   end function included_file

   function block_text(block) result(text)
      type(block_type), intent(in) :: block
      character(:), allocatable :: text
      type(field_spec_type), allocatable :: specs(:)
      integer :: i, form, length
      form = keyword_table(find_keyword(block%keyword))%form
      allocate (specs, source=keyword_fields(block%keyword))
      text = keyword_line(block)
      if (form == form_none) return
      length = len(text)
      do i = 1, size(block%lines)
         call append(text, length, '  '//line_text(block%lines(i), form, specs)//newline)
      end do
      text = text(:length)
   end function block_text

   !> The keyword and all options that have a value, on as many lines as needed.
   function keyword_line(block) result(text)
      type(block_type), intent(in) :: block
      character(:), allocatable :: text, line, item, model
      type(option_spec_type), allocatable :: specs(:)
      integer :: i
      allocate (specs, source=keyword_options(block%keyword))
      text = ''
      item = ''
      model = ''
      if (block%keyword == 'BEAM') model = block%word('GEOMETRIC')
      if (block%keyword == 'FRAME') then
         model = block%word('GEOMETRIC')
         if (block%yes('LARGE')) model = 'LARGE'
      end if
      line = '*'//block%keyword
      do i = 1, size(block%options)
         if (.not. block%options(i)%has_value) cycle
         if (is_idle(block, specs(i))) cycle
         ! What means nothing of this body is written only if the deck has it
         if (.not. block%options(i)%given .and. is_void(block%keyword, model, trim(block%options(i)%name))) cycle
         item = trim(block%options(i)%name)//'='//value_text(block%options(i))
         line = line//','
         if (len(line) + len(item) + 2 > width) then
            text = text//line//newline
            line = '   '
         end if
         line = line//' '//item
      end do
      text = text//line//newline
   end function keyword_line

   function value_text(option) result(text)
      type(option_type), intent(in) :: option
      character(:), allocatable :: text
      if (is_integer_kind(option%kind)) then
         text = as_text(option%whole)
      else if (is_number_kind(option%kind)) then
         text = as_text(option%value)
      else
         text = option%text
         if (option%kind == kind_text .or. option%kind == kind_path) text = '"'//text//'"'
      end if
   end function value_text

   !> A data line: constants as numbers, the rest as written.
   function line_text(line, form, specs) result(text)
      type(line_type), intent(in) :: line
      integer, intent(in) :: form
      !> Fields of the keyword, if it has rows of fields
      type(field_spec_type), intent(in) :: specs(:)
      character(:), allocatable :: text
      integer :: i
      text = line%content
      if (form == form_text) return
      text = ''
      do i = 1, line%count()
         if (i > 1) text = text//', '
         if (len(line%fields(i)%name) > 0) text = text//line%fields(i)%name//' = '
         if (form == form_assignments .and. line%fields(i)%expression%is_constant()) then
            text = text//as_text(line%fields(i)%value)
         else if (size(specs) > 0) then
            text = text//field_text(line, i, specs(min(i, size(specs)))%kind)
         else
            text = text//line%fields(i)%text
         end if
      end do
   end function line_text

   function field_text(line, i, kind) result(text)
      type(line_type), intent(in) :: line
      integer, intent(in) :: i, kind
      character(:), allocatable :: text
      text = line%fields(i)%text
      if (is_number_kind(kind) .or. kind == kind_label .and. len(text) == 0) text = as_text(line%fields(i)%value)
      if (is_expression_kind(kind)) then
         if (line%fields(i)%expression%is_constant()) text = as_text(line%fields(i)%expression%constant_value())
      end if
   end function field_text

end module limber_deck_effective
