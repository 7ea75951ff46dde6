!> The effective deck: all that a run used, defaults included and numbers evaluated, as a deck that can
!> be read again. It is stored with the results. Floor: deck.
module limber_deck_effective
   use limber_base_text, only: as_text, newline
   use limber_deck_schema, only: form_none, form_text, form_assignments, kind_text, kind_path, &
      & is_number_kind, is_integer_kind, is_expression_kind, field_spec_type
   use limber_deck_keywords, only: keyword_table, keyword_fields, find_keyword
   use limber_deck_content, only: deck_type, block_type, option_type, line_type
   implicit none
   private
   public :: effective_deck

   !> Columns that keyword lines are kept within
   integer, parameter :: width = 100

contains

   !> The text of the effective deck, ending with a line feed. Parameters are kept, each with its value; an
   !> expression of time or of quantities stands as it was written.
   function effective_deck(deck) result(text)
      type(deck_type), intent(in) :: deck
      character(:), allocatable :: text
      integer :: i
      text = ''
      do i = 1, size(deck%blocks)
         text = text//block_text(deck%blocks(i))
      end do
   end function effective_deck

   function block_text(block) result(text)
      type(block_type), intent(in) :: block
      character(:), allocatable :: text
      type(field_spec_type), allocatable :: specs(:)
      integer :: i, form
      form = keyword_table(find_keyword(block%keyword))%form
      allocate (specs, source=keyword_fields(block%keyword))
      text = keyword_line(block)
      if (form == form_none) return
      do i = 1, size(block%lines)
         text = text//'  '//line_text(block%lines(i), form, specs)//newline
      end do
   end function block_text

   !> The keyword and all options that have a value, on as many lines as needed.
   function keyword_line(block) result(text)
      type(block_type), intent(in) :: block
      character(:), allocatable :: text, line, item
      integer :: i
      text = ''
      item = ''
      line = '*'//block%keyword
      do i = 1, size(block%options)
         if (.not. block%options(i)%has_value) cycle
         item = block%options(i)%name//'='//value_text(block%options(i))
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
         if (form == form_assignments) then
            text = text//as_text(line%fields(i)%value)
         else if (i <= size(specs)) then
            text = text//field_text(line, i, specs(i)%kind)
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
      if (is_number_kind(kind)) text = as_text(line%fields(i)%value)
      if (is_expression_kind(kind)) then
         if (line%fields(i)%expression%is_constant()) text = as_text(line%fields(i)%expression%constant_value())
      end if
   end function field_text

end module limber_deck_effective
