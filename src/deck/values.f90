!> Values of options and fields by the keyword table. Floor: deck.
module limber_deck_values
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, lowercase, nearest_name
   use limber_deck_cursor, only: letters, digits
   use limber_deck_lexer, only: part_type, collapsed, is_name, is_point, unquoted, trimmed, &
      & find_outside
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_synonyms, only: word_in_deck, successor_of
   use limber_deck_parameters, only: parameter_list_type, name_length
   use limber_deck_expression, only: expression_type
   use limber_deck_compile, only: compile
   use limber_deck_template, only: fill_in
   use limber_deck_schema, only: option_spec_type, kind_name, kind_reference, kind_real, kind_positive, kind_nonnegative, &
      & kind_count, kind_counting, kind_word, kind_point, kind_yes, kind_law, kind_spring_law, kind_shape, kind_curve, kind_label, &
      & kind_range, is_number_kind, is_integer_kind, is_expression_kind
   use limber_deck_keywords, only: split_values, contains_value
   use limber_deck_content, only: option_type, field_type
   implicit none
   private
   public :: read_option, read_field, check_name, suggestion, tell_words

contains

   !> Reads the value of an option; its text is not empty.
   subroutine read_option(spec, part, parameters, option, diagnostics)
      !> Row of the table
      type(option_spec_type), intent(in) :: spec
      !> Value as written
      type(part_type), intent(in) :: part
      !> Parameters that are defined so far
      type(parameter_list_type), intent(in) :: parameters
      !> Receives the value
      type(option_type), intent(inout) :: option
      type(diagnostics_type), intent(inout) :: diagnostics
      type(part_type) :: filled
      logical :: ok
      option%text = part%text
      option%origin = part%origin
      ok = .true.
      if (is_number_kind(spec%kind)) then
         call read_number(trim(spec%name), spec%kind, trim(spec%meaning), part, parameters, option%value, ok, diagnostics, &
            & spec%most)
         if (ok .and. is_integer_kind(spec%kind)) option%whole = nint(option%value)
      else
         filled = part
         call fill_in(filled, parameters, ok, diagnostics)
         if (ok) call read_words(spec, filled, option, ok, diagnostics)
      end if
      option%has_value = ok
   end subroutine read_option

   !> Reads the value of an option that is no number.
   subroutine read_words(spec, part, option, ok, diagnostics)
      type(option_spec_type), intent(in) :: spec
      type(part_type), intent(in) :: part
      type(option_type), intent(inout) :: option
      logical, intent(out) :: ok
      type(diagnostics_type), intent(inout) :: diagnostics
      ok = .true.
      select case (spec%kind)
      case (kind_word)
         call read_word(spec, trim(spec%values), part, option, ok, diagnostics)
      case (kind_yes)
         call read_word(spec, 'YES|NO', part, option, ok, diagnostics)
      case (kind_name, kind_reference)
         option%text = lowercase(part%text)
         call check_name(part, ok, diagnostics)
      case (kind_point)
         option%text = lowercase(part%text)
         call check_point(part, ok, diagnostics)
      case default
         option%text = unquoted(part%text)
      end select
   end subroutine read_words

   !> Reads a field of a data line.
   subroutine read_field(what, kind, meaning, written, parameters, field, ok, diagnostics)
      !> What the field is called, its kind and meaning: as in the table
      character(*), intent(in) :: what, meaning
      integer, intent(in) :: kind
      !> Field as written; may be empty
      type(part_type), intent(in) :: written
      type(parameter_list_type), intent(in) :: parameters
      type(field_type), intent(out) :: field
      logical, intent(out) :: ok
      type(diagnostics_type), intent(inout) :: diagnostics
      type(part_type) :: part
      part = written
      call fill_in(part, parameters, ok, diagnostics)
      field%text = part%text
      field%origin = part%origin
      field%name = ''
      if (.not. ok) return
      if (len(part%text) == 0) then
         ok = .false.
         call diagnostics%add(part%origin, "the field '"//what//"' is empty", meaning)
      else if (is_number_kind(kind)) then
         call read_number(what, kind, meaning, part, parameters, field%value, ok, diagnostics)
      else if (kind == kind_label .and. .not. is_name(part%text)) then
         field%text = ''
         call read_number(what, kind, meaning, part, parameters, field%value, ok, diagnostics)
      else if (kind == kind_range) then
         call read_range(what, meaning, part, parameters, field, ok, diagnostics)
      else if (is_expression_kind(kind)) then
         call read_expression(kind, part, parameters, field%expression, ok, diagnostics)
      else if (kind == kind_point) then
         field%text = lowercase(part%text)
         call check_point(part, ok, diagnostics)
      else
         field%text = lowercase(part%text)
         call check_name(part, ok, diagnostics)
      end if
   end subroutine read_field

   !> Reads a number, or first:last, or first:last:count; the text of the field is then that of the numbers.
   subroutine read_range(what, meaning, part, parameters, field, ok, diagnostics)
      character(*), intent(in) :: what, meaning
      type(part_type), intent(in) :: part
      type(parameter_list_type), intent(in) :: parameters
      type(field_type), intent(inout) :: field
      logical, intent(out) :: ok
      type(diagnostics_type), intent(inout) :: diagnostics
      type(part_type) :: number
      real(wp) :: value
      integer :: first, colon, count
      ok = .true.
      field%text = ''
      first = 1
      do count = 1, 3
         colon = find_outside(part%text, ':', first)
         if (colon == 0) colon = len(part%text) + 1
         number = trimmed(part%text, part%origin, first, colon - 1)
         call read_number(what, merge(kind_counting, kind_real, count == 3), meaning, number, parameters, value, ok, diagnostics)
         if (.not. ok) return
         if (count == 1) field%value = value
         if (count > 1) field%text = field%text//':'
         field%text = field%text//as_text(value)
         first = colon + 1
         if (first > len(part%text)) return
      end do
      ok = .false.
      call diagnostics%add(part%origin, what//' has more than three parts', 'write first:last:count')
   end subroutine read_range

   !> Reads an expression of what its kind allows.
   subroutine read_expression(kind, part, parameters, expression, ok, diagnostics)
      integer, intent(in) :: kind
      type(part_type), intent(in) :: part
      type(parameter_list_type), intent(in) :: parameters
      type(expression_type), intent(out) :: expression
      logical, intent(out) :: ok
      type(diagnostics_type), intent(inout) :: diagnostics
      select case (kind)
      case (kind_law)
         call compile(part%text, part%origin, parameters, expression, ok, diagnostics, time=.true., quantities=.true.)
      case (kind_spring_law)
         call compile(part%text, part%origin, parameters, expression, ok, diagnostics, time=.true., quantities=.true., &
            & variables=['x', 'v'])
      case (kind_shape)
         call compile(part%text, part%origin, parameters, expression, ok, diagnostics, variables=['s'])
      case (kind_curve)
         call compile(part%text, part%origin, parameters, expression, ok, diagnostics, variables=['x'])
      case default
         call compile(part%text, part%origin, parameters, expression, ok, diagnostics, time=.true.)
      end select
   end subroutine read_expression

   !> Reads a constant number and checks its range.
   subroutine read_number(what, kind, meaning, part, parameters, value, ok, diagnostics, most)
      character(*), intent(in) :: what, meaning
      integer, intent(in) :: kind
      type(part_type), intent(in) :: part
      type(parameter_list_type), intent(in) :: parameters
      real(wp), intent(out) :: value
      logical, intent(out) :: ok
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Greatest whole number
      integer, intent(in), optional :: most
      type(expression_type) :: expression
      character(:), allocatable :: wanted
      integer :: greatest
      value = 0.0_wp
      call compile(part%text, part%origin, parameters, expression, ok, diagnostics)
      if (.not. ok) return
      value = expression%constant_value()
      wanted = ''
      select case (kind)
      case (kind_positive); if (value <= 0.0_wp) wanted = 'greater than 0'
      case (kind_nonnegative); if (value < 0.0_wp) wanted = '0 or greater'
      case (kind_count); if (value < 0.0_wp) wanted = 'a whole number from 0 on'
      case (kind_counting); if (value < 1.0_wp) wanted = 'a whole number from 1 on'
      end select
      if (is_integer_kind(kind)) then
         if (abs(value - anint(value)) > 0.0_wp) wanted = 'a whole number'
         greatest = huge(1)
         if (present(most)) greatest = most
         if (value > real(greatest, wp)) wanted = 'at most '//as_text(greatest)
         if (value < -real(huge(1), wp)) wanted = 'at least '//as_text(-huge(1))
      end if
      ok = len(wanted) == 0
      if (.not. ok) call diagnostics%add(part%origin, what//' must be '//wanted//', not '//as_text(value), meaning)
   end subroutine read_number

   subroutine read_word(spec, choices, part, option, ok, diagnostics)
      type(option_spec_type), intent(in) :: spec
      !> Separated by |
      character(*), intent(in) :: choices
      type(part_type), intent(in) :: part
      type(option_type), intent(inout) :: option
      logical, intent(out) :: ok
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: label
      option%text = collapsed(part%text)
      ok = contains_value(choices, option%text)
      if (ok) return
      label = suggestion(option%text, split_values(choices))
      if (spec%name == 'GEOMETRIC' .and. len(successor_of(option%text)) > 0) label = successor_of(option%text)
      call diagnostics%add(part%origin, trim(spec%name)//" cannot be '"//option%text//"'", label)
   end subroutine read_word

   !> Reports a text that is not the name of an object.
   subroutine check_name(part, ok, diagnostics)
      type(part_type), intent(in) :: part
      logical, intent(out) :: ok
      type(diagnostics_type), intent(inout) :: diagnostics
      ok = is_name(part%text)
      if (ok) return
      call diagnostics%add(part%origin, "'"//part%text//"' is not a name", &
         & 'a letter, then letters, digits, _ and -; at most '//as_text(name_length)//' of them')
      call diagnostics%tell(lowercase(part%text))
      call tell_words(lowercase(part%text), diagnostics)
   end subroutine check_name

   !> Takes note of the words in a text in error, that may be names of what was to be defined: a comma may be missing, or a blank
   !> too much.
   subroutine tell_words(text, diagnostics)
      !> In lower case
      character(*), intent(in) :: text
      type(diagnostics_type), intent(inout) :: diagnostics
      character(*), parameter :: characters = letters//digits//'_-'
      integer :: first, last, letter
      first = 1
      do while (first <= len(text))
         last = first + verify(text(first:)//' ', characters) - 2
         ! A number before, or a minus between them, is no part of a name
         letter = scan(text(first:last), letters)
         if (letter > 0) then
            call diagnostics%tell(text(first:last))
            call diagnostics%tell(text(first + letter - 1:last))
            call diagnostics%tell(text(first + letter - 1:first + index(text(first:last)//'-', '-') - 2))
            call diagnostics%tell(text(first + index(text(first:last), '-', back=.true.):last))
         end if
         first = max(last, first) + 1
      end do
   end subroutine tell_words

   subroutine check_point(part, ok, diagnostics)
      type(part_type), intent(in) :: part
      logical, intent(out) :: ok
      type(diagnostics_type), intent(inout) :: diagnostics
      ok = is_point(part%text)
      if (ok) return
      call diagnostics%add(part%origin, "'"//part%text//"' is not a point", &
         & 'write object.point, or the name of a point mass')
      call tell_words(lowercase(part%text), diagnostics)
   end subroutine check_point

   !> "did you mean 'MODES'? Valid: NAME, ..." or only the second half.
   pure function suggestion(name, candidates) result(text)
      !> What was written, and what may be written
      character(*), intent(in) :: name, candidates(:)
      character(:), allocatable :: text
      integer :: i, near
      text = 'valid: '
      near = 0
      if (len(name) > 1) near = nearest_name(name, candidates)
      if (near > 0) text = "did you mean '"//trim(candidates(near))//"'? Valid: "
      if (word_in_deck(name, candidates) /= '') text = "did you mean '"//word_in_deck(name, candidates)//"'? Valid: "
      do i = 1, size(candidates)
         if (i > 1) text = text//', '
         text = text//trim(candidates(i))
      end do
   end function suggestion

end module limber_deck_values
