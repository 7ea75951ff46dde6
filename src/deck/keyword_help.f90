!> Keyword table as text: help and manual. `limber help KEYWORD`, and the reference chapter of the manual. Floor: deck.
module limber_deck_keyword_help
   use limber_base_text, only: as_text, newline
   use limber_deck_examples, only: example_text
   use limber_deck_operations, only: function_names, function_meanings
   use limber_deck_schema, only: keyword_type, option_spec_type, field_spec_type, list_spec_type, many, needed, kind_name, &
      & kind_reference, kind_real, kind_positive, kind_nonnegative, kind_count, kind_counting, kind_word, kind_text, &
      & kind_path, kind_point, kind_yes, form_none, form_text, form_assignments, form_channels, form_lists, word_spec_type
   use limber_deck_keywords, only: keyword_table, keyword_options, keyword_fields, keyword_lists, &
      & keyword_words, find_keyword, load_language, alternatives
   implicit none
   private
   public :: help_text, manual_text, asks_for_group

   !> What expressions are made with
   character(*), parameter :: operators = '+ - * / and ** (power), parentheses'
   !> Columns of help that a terminal shows
   integer, parameter :: width = 100

contains

   !> Help on a keyword; the list of all keywords if it is empty or unknown. Without a trailing line feed.
   function help_text(keyword) result(text)
      !> In any case, without the asterisk; behind BEAM or FRAME the word of a group of options asks for that group, as in BEAM
      !> MODES
      character(*), intent(in) :: keyword
      character(:), allocatable :: text
      integer :: row, last
      call load_language()
      row = find_keyword(keyword)
      last = index(trim(keyword), ' ', back=.true.)
      if (row > 0) then
         text = keyword_help(keyword_table(row), '')
      else if (asks_for_group(keyword)) then
         text = keyword_help(keyword_table(find_keyword(keyword(:last - 1))), trim(keyword(last + 1:)))
      else
         text = 'Keywords of a deck:'
         do row = 1, size(keyword_table)
            text = text//newline//'  *'//keyword_table(row)%name//'  '//trim(keyword_table(row)%meaning)
         end do
         text = text//newline//newline//wrapped('Expressions: '//operators//'. Functions: '//listed_functions() &
            & //' ('//function_meanings//'); pi; the time t; 90 deg is an angle in degrees', 0)
      end if
   end function help_text

   !> Whether words ask for a group of options: a keyword, and the word of one of its groups.
   pure logical function asks_for_group(words)
      !> In upper case; after `load_language`
      character(*), intent(in) :: words
      type(option_spec_type), allocatable :: specs(:)
      integer :: last
      last = index(trim(words), ' ', back=.true.)
      asks_for_group = last > 1
      if (asks_for_group) asks_for_group = find_keyword(words(:last - 1)) > 0
      if (.not. asks_for_group) return
      allocate (specs, source=keyword_options(words(:last - 1)))
      asks_for_group = any(specs%models == words(last + 1:))
   end function asks_for_group

   !> Help on one keyword, or on one group of its options.
   function keyword_help(keyword, group) result(text)
      type(keyword_type), intent(in) :: keyword
      !> Word of the group; empty: options of all models, and the names of the others
      character(*), intent(in) :: group
      character(:), allocatable :: text
      type(option_spec_type), allocatable :: specs(:)
      integer :: i
      text = '*'//trim(keyword%name)//newline//'  '//trim(keyword%meaning)
      if (keyword%most == 1) text = text//'; at most once'
      allocate (specs, source=keyword_options(trim(keyword%name)))
      do i = 1, size(specs)
         if (begins_group(specs, i)) then
            if (specs(i)%models == group) then
               text = text//newline//newline//'Options'//group_title(keyword%name, group)//':'
            else if (group == '') then
               text = text//newline//newline//group_names(keyword%name, specs(i)%models)
            end if
         end if
         if (specs(i)%models /= group) cycle
         text = text//newline//'  '//specs(i)%name//'  '//wrapped(option_sentence(specs(i)), len(specs%name) + 4)
      end do
      if (group /= '') return
      if (keyword%form /= form_none) text = text//newline//newline//'Data lines ('//line_count(keyword)//'): ' &
         & //line_form(keyword, .false.)//listed_words(trim(keyword%name), .false.)
      text = text//newline//newline//'Example:'//newline//example_text(trim(keyword%name))
   end function keyword_help

   !> The names of a group of options, and the command that shows them.
   function group_names(keyword, group) result(text)
      character(*), intent(in) :: keyword, group
      character(:), allocatable :: text, names
      type(option_spec_type), allocatable :: specs(:)
      integer :: i
      allocate (specs, source=keyword_options(trim(keyword)))
      specs = pack(specs, specs%models == group)
      names = trim(specs(1)%name)
      do i = 2, size(specs)
         names = names//', '//trim(specs(i)%name)
      end do
      text = as_text(size(specs))//' options'//group_title(keyword, group)//':'//newline//'  '//wrapped(names, 2)//newline &
         & //'  limber help '//trim(keyword)//' '//trim(group)
   end function group_names

   !> Whether an option is the first of those for some models.
   pure logical function begins_group(specs, i)
      type(option_spec_type), intent(in) :: specs(:)
      integer, intent(in) :: i
      begins_group = i == 1
      if (i > 1) begins_group = specs(i)%models /= specs(i - 1)%models
   end function begins_group

   !> Of which models a group of options is.
   pure function group_title(keyword, models) result(title)
      character(*), intent(in) :: keyword, models
      character(:), allocatable :: title
      select case (models)
      case ('EXACT'); title = ' of exact beams, GEOMETRIC=EXACT (default)'
      case ('LARGE'); title = ' of frames of exact beams, LARGE=YES'
      case ('MODES')
         title = ' of beams with modes, GEOMETRIC=LINEAR or K_G (default if one is given)'
         if (keyword == 'FRAME') title = ' of frames with modes, LARGE=NO (default)'
      case default; title = ''
      end select
   end function group_title

   !> Meaning, what may be written, default.
   function option_sentence(spec) result(text)
      type(option_spec_type), intent(in) :: spec
      character(:), allocatable :: text
      text = trim(spec%meaning)
      if (len_trim(spec%unit) > 0) text = text//' ['//trim(spec%unit)//']'
      text = text//'; '//kind_text_of(spec)
      if (spec%default == needed) then
         text = text//'; required'
      else if (len_trim(spec%default) > 0) then
         text = text//'; default '//trim(spec%default)
      end if
   end function option_sentence

   !> What may be written as the value of an option.
   pure function kind_text_of(spec) result(text)
      type(option_spec_type), intent(in) :: spec
      character(:), allocatable :: text
      select case (spec%kind)
      case (kind_name); text = 'a new name among the '//trim(spec%values)
      case (kind_reference); text = 'the name of a '//alternatives(trim(spec%values), '*')
      case (kind_real); text = 'number'
      case (kind_positive); text = 'number > 0'
      case (kind_nonnegative); text = 'number >= 0'
      case (kind_count); text = whole_numbers('0')
      case (kind_counting); text = whole_numbers('1')
      case (kind_word); text = joined(trim(spec%values), ', ')
      case (kind_text); text = 'text'
      case (kind_path); text = 'path'
      case (kind_point); text = 'body.point, or a point mass'
      case (kind_yes); text = 'YES or NO'
      case default; text = 'expression'
      end select

   contains

      pure function whole_numbers(least) result(words)
         character(*), intent(in) :: least
         character(:), allocatable :: words
         words = 'whole number >= '//least
         if (spec%most < many) words = 'whole number from '//least//' to '//as_text(spec%most)
      end function whole_numbers

   end function kind_text_of

   !> The words of a list with another separator.
   pure function joined(values, separator) result(text)
      character(*), intent(in) :: values, separator
      character(:), allocatable :: text
      integer :: i
      text = ''
      do i = 1, len(values)
         if (values(i:i) == '|') then
            text = text//separator
         else
            text = text//values(i:i)
         end if
      end do
   end function joined

   pure function line_count(keyword) result(text)
      type(keyword_type), intent(in) :: keyword
      character(:), allocatable :: text
      if (keyword%least_lines < keyword%most_lines .and. keyword%most_lines < many) then
         text = 'at most one'
      else if (keyword%most_lines < many) then
         text = 'exactly one'
      else if (keyword%least_lines > 0) then
         text = 'one or more'
      else
         text = 'any number'
      end if
   end function line_count

   !> What stands in a data line, and the meaning of its fields.
   function line_form(keyword, markdown) result(text)
      type(keyword_type), intent(in) :: keyword
      !> Fields as a list in Markdown
      logical, intent(in) :: markdown
      character(:), allocatable :: text, list
      type(field_spec_type), allocatable :: specs(:)
      integer :: i
      allocate (specs, source=keyword_fields(trim(keyword%name)))
      select case (keyword%form)
      case (form_text); text = 'free text'
      case (form_assignments); text = 'name = expression, ...'
      case (form_channels); text = 'quantity(object), name = expression, ...'
      case (form_lists); text = 'name of a list, value, value, ...'
      case default; text = ''
      end select
      if (markdown .and. size(specs) == 0) text = '`'//text//'`'
      list = ''
      do i = 1, size(specs)
         if (i > 1) text = text//', '
         if (specs(i)%optional) text = text//'['
         text = text//trim(specs(i)%name)
         if (specs(i)%optional) text = text//']'
         if (specs(i)%repeated) text = text//', ...'
         if (markdown) then
            list = list//newline//'- *'//trim(specs(i)%name)//'*: '//field_sentence(specs(i))
         else
            list = list//newline//'  '//specs(i)%name//'  '//field_sentence(specs(i))
         end if
      end do
      if (markdown .and. size(specs) > 0) text = '`'//text//'`'//newline
      if (keyword%form == form_lists) list = listed_lists(trim(keyword%name), markdown)
      text = text//list
   end function line_form

   !> Meanings of the words that an option of a keyword takes.
   function listed_words(keyword, markdown) result(text)
      character(*), intent(in) :: keyword
      logical, intent(in) :: markdown
      character(:), allocatable :: text
      type(word_spec_type), allocatable :: words(:)
      integer :: i
      allocate (words, source=keyword_words(keyword))
      text = ''
      if (size(words) > 0) text = newline
      do i = 1, size(words)
         if (markdown) then
            text = text//newline//'- `'//trim(words(i)%word)//'`: '//trim(words(i)%meaning)
         else
            text = text//newline//'  '//words(i)%word//'  '//wrapped(trim(words(i)%meaning), len(words%word) + 4)
         end if
      end do
      if (markdown .and. size(words) > 0) text = text//newline
   end function listed_words

   !> Names and meanings of the lists that data lines give, and the option that the values are for.
   function listed_lists(keyword, markdown) result(text)
      character(*), intent(in) :: keyword
      logical, intent(in) :: markdown
      character(:), allocatable :: text, sentence
      type(list_spec_type), allocatable :: specs(:)
      integer :: i
      allocate (specs, source=keyword_lists(keyword))
      text = ''
      if (markdown) text = newline
      do i = 1, size(specs)
         sentence = trim(specs(i)%meaning)
         if (len_trim(specs(i)%of) > 0) sentence = sentence//' (*'//trim(specs(i)%of)//', '//trim(specs(i)%option)//')'
         if (markdown) then
            if (len_trim(specs(i)%of) > 0) sentence = trim(specs(i)%meaning)//' (`*'//trim(specs(i)%of)//', '// &
               & trim(specs(i)%option)//'`)'
            text = text//newline//'- *'//trim(specs(i)%name)//'*: '//sentence
         else
            text = text//newline//'  '//specs(i)%name//'  '//sentence
         end if
      end do
   end function listed_lists

   function field_sentence(spec) result(text)
      type(field_spec_type), intent(in) :: spec
      character(:), allocatable :: text
      text = trim(spec%meaning)
      if (len_trim(spec%unit) > 0) text = text//' ['//trim(spec%unit)//']'
      if (spec%optional) text = text//'; may be left out'
   end function field_sentence

   !> The reference chapter of the manual in Markdown; ends with a line feed.
   function manual_text() result(text)
      character(:), allocatable :: text
      type(option_spec_type), allocatable :: specs(:)
      integer :: row, i
      call load_language()
      text = '# Keywords of a deck'//newline//newline//'Expressions: '//operators//'. Functions: '//listed_functions()//' (' &
         & //function_meanings//'). `pi` is the number, `t` the time; `90 deg` is an angle in degrees.'//newline &
         & //newline//'Capitals are not distinguished, in keywords and in names: `M` and `m` cannot both be channels.'//newline
      do row = 1, size(keyword_table)
         text = text//newline//'## *'//trim(keyword_table(row)%name)//newline//newline//trim(keyword_table(row)%meaning)//'.'
         if (keyword_table(row)%most == 1) text = text//' At most once.'
         text = text//newline
         if (allocated(specs)) deallocate (specs)
         allocate (specs, source=keyword_options(trim(keyword_table(row)%name)))
         do i = 1, size(specs)
            if (begins_group(specs, i)) then
               if (i > 1) text = text//newline//'Options'//group_title(keyword_table(row)%name, specs(i)%models)//':'//newline
               text = text//newline//'| Option | Value | Unit | Default | Meaning |'//newline//'|---|---|---|---|---|'//newline
            end if
            text = text//manual_row(specs(i))//newline
         end do
         if (keyword_table(row)%form /= form_none) text = text//newline//'Data lines ('//line_count(keyword_table(row)) &
            & //'): '//line_form(keyword_table(row), .true.)//newline//listed_words(trim(keyword_table(row)%name), .true.)
         text = text//newline//'```'//newline//example_text(trim(keyword_table(row)%name))//newline//'```'//newline
      end do
   end function manual_text

   function manual_row(spec) result(text)
      type(option_spec_type), intent(in) :: spec
      character(:), allocatable :: text, default
      default = trim(spec%default)
      if (default == needed) default = 'required'
      text = '| '//trim(spec%name)//' | '//kind_text_of(spec)//' | '//trim(spec%unit)//' | '//default//' | ' &
         & //trim(spec%meaning)//' |'
   end function manual_row

   pure function listed_functions() result(text)
      character(:), allocatable :: text
      integer :: i
      text = trim(function_names(1))
      do i = 2, size(function_names)
         text = text//', '//trim(function_names(i))
      end do
   end function listed_functions

   !> A text on several lines; all but the first are indented.
   pure function wrapped(text, indent) result(lines)
      character(*), intent(in) :: text
      !> Columns that are taken already in the first line, and left blank in the others
      integer, intent(in) :: indent
      character(:), allocatable :: lines
      integer :: first, last
      lines = ''
      first = 1
      do
         last = len(text)
         if (last - first + 1 > width - indent) then
            last = first + index(text(first:first + width - indent), ' ', back=.true.) - 2
            if (last < first) last = first + width - indent - 1
         end if
         if (first > 1) lines = lines//newline//repeat(' ', indent)
         lines = lines//text(first:last)
         if (last >= len(text)) exit
         first = last + 1
         if (text(first:first) == ' ') first = first + 1
      end do
   end function wrapped

end module limber_deck_keyword_help
