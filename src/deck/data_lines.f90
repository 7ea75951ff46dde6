!> Data lines in the forms of the keyword table. Free text, rows of fields, assignments of parameters, channels of the output.
!> Floor: deck.
module limber_deck_data_lines
   use limber_base_text, only: as_text, lowercase
   use limber_deck_origin, only: after
   use limber_deck_lexer, only: part_type, trimmed, collapsed, split_fields, find_outside, is_parameter_name
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_parameters, only: parameter_type, max_parameters
   use limber_deck_compile, only: compile, is_reserved
   use limber_deck_operations, only: op_slot
   use limber_deck_template, only: fill_in
   use limber_deck_schema, only: field_spec_type, list_spec_type, option_spec_type, form_text, form_fields, form_assignments, &
      & form_channels, form_lists
   use limber_deck_keywords, only: keyword_table, keyword_fields, keyword_lists, keyword_options
   use limber_deck_content, only: deck_type, line_type, field_type, option_type
   use limber_deck_values, only: read_field, read_option, check_name, suggestion, tell_words
   implicit none
   private
   public :: read_line, expected_line

contains

   !> Reads the fields of a data line in the form that the keyword wants.
   subroutine read_line(row, line, deck, ok, diagnostics)
      !> Row of the keyword in the table
      integer, intent(in) :: row
      !> Content and origin on entry; receives the fields
      type(line_type), intent(inout) :: line
      !> The deck so far; *PARAMETER adds to its parameters
      type(deck_type), intent(inout) :: deck
      logical, intent(out) :: ok
      type(diagnostics_type), intent(inout) :: diagnostics
      type(part_type), allocatable :: parts(:)
      logical :: field_ok
      integer :: i, count
      ok = .true.
      if (keyword_table(row)%form == form_text) then
         allocate (line%fields(0))
         return
      end if
      call split_fields(line%content, line%origin, parts)
      count = size(parts)
      if (count > 1 .and. len(parts(count)%text) == 0) count = count - 1
      allocate (line%fields(count))
      select case (keyword_table(row)%form)
      case (form_fields)
         call read_row(trim(keyword_table(row)%name), parts(:count), deck, line, ok, diagnostics)
      case (form_assignments)
         do i = 1, count
            call read_assignment(parts(i), keyword_table(row)%name == 'EXPRESSION', deck, line%fields(i), field_ok, diagnostics)
            ok = ok .and. field_ok
         end do
      case (form_channels)
         do i = 1, count
            call read_channel(parts(i), deck, line%fields(i), field_ok, diagnostics)
            ok = ok .and. field_ok
         end do
      case (form_lists); call read_list(trim(keyword_table(row)%name), parts(:count), deck, line, ok, diagnostics)
      end select
   end subroutine read_line

   !> Column of the last parenthesis that is open at the end of a text; 0: none is.
   pure integer function open_parenthesis(text) result(column)
      character(*), intent(in) :: text
      integer :: depth
      depth = 0
      do column = len(text), 1, -1
         if (text(column:column) == ')') depth = depth + 1
         if (text(column:column) == '(') depth = depth - 1
         if (depth < 0) return
      end do
      column = 0
   end function open_parenthesis

   !> A row of fields of which the table gives number and kinds.
   subroutine read_row(keyword, parts, deck, line, ok, diagnostics)
      character(*), intent(in) :: keyword
      type(part_type), intent(in) :: parts(:)
      type(deck_type), intent(in) :: deck
      type(line_type), intent(inout) :: line
      logical, intent(out) :: ok
      type(diagnostics_type), intent(inout) :: diagnostics
      type(field_spec_type), allocatable :: specs(:)
      character(:), allocatable :: wanted
      logical :: field_ok
      integer :: i, least, most, which
      allocate (specs, source=keyword_fields(keyword))
      least = count(.not. specs%optional)
      most = size(specs)
      if (specs(most)%repeated) most = huge(1)
      ok = size(parts) >= least .and. size(parts) <= most
      if (.not. ok) then
         wanted = ''
         do i = 1, size(specs)
            wanted = wanted//', '//trim(specs(i)%name)
         end do
         if (specs(size(specs))%repeated) then
            wanted = 'at least '//counted(least)//' ('//wanted(3:)//'), not '//as_text(size(parts))
         else
            wanted = counted(size(specs))//' ('//wanted(3:)//'), not '//as_text(size(parts))
            if (least < size(specs)) wanted = as_text(least)//' to '//wanted
         end if
         wanted = 'a data line of *'//keyword//' has '//wanted
         if (size(parts) < least .and. open_parenthesis(parts(size(parts))%text) > 0) then
            associate (last => parts(size(parts)))
               call diagnostics%add(after(last%origin), "a parenthesis is not closed in '"//last%text//"'", 'write ) where it ends')
            end associate
         else if (size(parts) < least) then
            call diagnostics%add(after(line%origin), wanted, trim(specs(size(parts) + 1)%name)//' is missing')
         else
            call diagnostics%add(parts(size(specs) + 1)%origin, wanted, 'this is too much')
         end if
         return
      end if
      do i = 1, size(parts)
         which = min(i, size(specs))
         call read_field(trim(specs(which)%name), specs(which)%kind, trim(specs(which)%meaning), parts(i), deck%parameters, &
            & line%fields(i), field_ok, diagnostics)
         ok = ok .and. field_ok
      end do
   end subroutine read_row

   !> The name of a list and its values, each as the option wants it that they are for.
   subroutine read_list(keyword, parts, deck, line, ok, diagnostics)
      character(*), intent(in) :: keyword
      type(part_type), intent(in) :: parts(:)
      type(deck_type), intent(in) :: deck
      type(line_type), intent(inout) :: line
      logical, intent(out) :: ok
      type(diagnostics_type), intent(inout) :: diagnostics
      type(list_spec_type), allocatable :: lists(:)
      logical :: value_ok
      integer :: which, i
      allocate (lists, source=keyword_lists(keyword))
      line%fields(1)%text = lowercase(collapsed(parts(1)%text))
      line%fields(1)%origin = parts(1)%origin
      line%fields(1)%name = ''
      do which = size(lists), 1, -1
         if (lists(which)%name == line%fields(1)%text) exit
      end do
      ok = which > 0 .and. size(parts) > 1
      if (which == 0) then
         call diagnostics%add(parts(1)%origin, '*'//keyword//" has no list '"//line%fields(1)%text//"'", &
            & suggestion(line%fields(1)%text, lists%name))
      else if (.not. ok) then
         call diagnostics%add(parts(1)%origin, "the list '"//line%fields(1)%text//"' has no values", trim(lists(which)%meaning))
      end if
      if (.not. ok) return
      do i = 2, size(parts)
         call read_list_value(lists(which), parts(i), deck, line%fields(i), value_ok, diagnostics)
         ok = ok .and. value_ok
      end do
   end subroutine read_list

   !> A value of a list: a name, or what the option takes.
   subroutine read_list_value(list, written, deck, field, ok, diagnostics)
      type(list_spec_type), intent(in) :: list
      type(part_type), intent(in) :: written
      type(deck_type), intent(in) :: deck
      type(field_type), intent(out) :: field
      logical, intent(out) :: ok
      type(diagnostics_type), intent(inout) :: diagnostics
      type(option_spec_type), allocatable :: specs(:)
      type(option_type) :: option
      type(part_type) :: part
      part = written
      call fill_in(part, deck%parameters, ok, diagnostics)
      field%origin = part%origin
      field%name = ''
      field%text = lowercase(part%text)
      if (.not. ok) return
      ok = len(part%text) > 0
      if (.not. ok) then
         call diagnostics%add(part%origin, 'a value is missing between two commas', trim(list%meaning))
      else if (len_trim(list%option) == 0) then
         call check_name(part, ok, diagnostics)
      else
         allocate (specs, source=keyword_options(trim(list%of)))
         specs = pack(specs, specs%name == list%option)
         call read_option(specs(1), part, deck%parameters, option, diagnostics)
         ok = option%has_value
         field%text = option%text
         field%value = option%value
      end if
   end subroutine read_list_value

   pure function counted(fields) result(text)
      integer, intent(in) :: fields
      character(:), allocatable :: text
      text = as_text(fields)//' fields'
      if (fields == 1) text = '1 field'
   end function counted

   !> `name = expression` of *PARAMETER or *EXPRESSION: defines the name.
   subroutine read_assignment(part, of_motion, deck, field, ok, diagnostics)
      type(part_type), intent(in) :: part
      !> Whether the expression may depend on time and motion
      logical, intent(in) :: of_motion
      type(deck_type), intent(inout) :: deck
      type(field_type), intent(out) :: field
      logical, intent(out) :: ok
      type(diagnostics_type), intent(inout) :: diagnostics
      type(part_type) :: name, value
      type(parameter_type) :: parameter
      character(:), allocatable :: what
      integer :: found
      call split_assignment(part, name, value, field)
      ok = .false.
      what = 'parameter'
      if (of_motion) what = 'named expression'
      found = deck%parameters%find(name%text)
      if (len(part%text) == 0) then
         call diagnostics%add(part%origin, 'a '//what//' is missing between two commas', 'write name = expression')
      else if (len(name%text) == 0) then
         call diagnostics%add(part%origin, "'"//part%text//"' defines no "//what, 'write name = expression')
      else if (.not. is_parameter_name(name%text)) then
         call diagnostics%add(name%origin, "'"//name%text//"' is not the name of a "//what, &
            & 'a letter, then letters, digits and _')
      else if (is_reserved(name%text)) then
         call diagnostics%add(name%origin, "'"//name%text//"' has a meaning already and cannot be a "//what, &
            & 't, pi and the functions are reserved; capitals are not distinguished')
      else if (found > 0) then
         call diagnostics%add(name%origin, "the parameter '"//lowercase(name%text)//"' is defined twice", &
            & 'give it another name; capitals are not distinguished', deck%parameters%items(found)%origin, 'first defined here')
      else if (deck%parameters%count >= max_parameters) then
         call diagnostics%add(name%origin, 'the deck has more than '//as_text(max_parameters)//' parameters')
      else
         field%name = lowercase(name%text)
         if (of_motion) then
            call compile(value%text, value%origin, deck%parameters, field%expression, ok, diagnostics, time=.true., &
               & quantities=.true.)
            if (ok) allocate (parameter%law, source=field%expression)
         else
            call compile(value%text, value%origin, deck%parameters, field%expression, ok, diagnostics)
            if (ok) field%value = field%expression%constant_value()
            if (ok) call deck%parameters%override(field%name, field%value)
            parameter%value = field%value
         end if
         if (.not. ok) call tell_words(lowercase(value%text), diagnostics)
         parameter%name = field%name
         parameter%valid = ok
         parameter%origin = name%origin
         call deck%parameters%define(parameter)
      end if
   end subroutine read_assignment

   !> `name = expression` or a bare quantity of *OUTPUT.
   subroutine read_channel(part, deck, field, ok, diagnostics)
      type(part_type), intent(in) :: part
      type(deck_type), intent(in) :: deck
      type(field_type), intent(out) :: field
      logical, intent(out) :: ok
      type(diagnostics_type), intent(inout) :: diagnostics
      type(part_type) :: name, value
      integer :: found
      call split_assignment(part, name, value, field)
      call fill_in(name, deck%parameters, ok, diagnostics)
      if (ok) call fill_in(value, deck%parameters, ok, diagnostics)
      if (.not. ok) return
      field%text = value%text
      if (len(part%text) == 0) then
         call diagnostics%add(part%origin, 'a channel is missing between two commas')
         ok = .false.
      else if (find_outside(part%text, '=', 1) > 0) then
         field%name = name%text
         call check_name(name, ok, diagnostics)
      end if
      if (.not. ok) return
      call compile(value%text, value%origin, deck%parameters, field%expression, ok, diagnostics, &
         & time=.true., quantities=.true.)
      if (.not. ok .or. len(field%name) > 0) return
      ! A named expression has its name already
      found = deck%parameters%find(value%text)
      if (found > 0) then
         if (allocated(deck%parameters%items(found)%law)) field%name = value%text
         if (field%name /= '') return
      end if
      if (size(field%expression%codes) == 1) then
         if (field%expression%codes(1) == op_slot) return
      end if
      call diagnostics%add(part%origin, 'a channel that is not a single quantity needs a name', &
         & 'write name = expression')
      ok = .false.
   end subroutine read_channel

   !> Cuts a field at its '='; without one, all of it is the value.
   subroutine split_assignment(part, name, value, field)
      type(part_type), intent(in) :: part
      type(part_type), intent(out) :: name, value
      !> Receives text and origin of the value
      type(field_type), intent(inout) :: field
      integer :: equals
      equals = find_outside(part%text, '=', 1)
      name = trimmed(part%text, part%origin, 1, equals - 1)
      value = trimmed(part%text, part%origin, equals + 1, len(part%text))
      field%text = value%text
      field%origin = value%origin
      field%name = ''
   end subroutine split_assignment

   !> What a data line of a keyword looks like.
   pure function expected_line(row) result(text)
      integer, intent(in) :: row
      character(:), allocatable :: text
      type(field_spec_type), allocatable :: specs(:)
      integer :: i
      allocate (specs, source=keyword_fields(trim(keyword_table(row)%name)))
      select case (keyword_table(row)%form)
      case (form_assignments); text = 'name = expression'
      case (form_channels); text = 'quantity(object) or name = expression'
      case (form_lists); text = 'name of a list, value, ...'
      case default
         text = ''
         do i = 1, size(specs)
            if (i > 1) text = text//', '
            text = text//trim(specs(i)%name)
         end do
      end select
   end function expected_line

end module limber_deck_data_lines
