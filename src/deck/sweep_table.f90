!> Values of a sweep as the deck, its file and the command line write them. Floor: deck.
module limber_deck_sweep_table
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, lowercase
   use limber_deck_compile, only: compile
   use limber_deck_content, only: deck_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_expression, only: expression_type
   use limber_deck_lexer, only: part_type, split_fields, trimmed
   use limber_deck_origin, only: origin_type
   use limber_deck_parameters, only: parameter_list_type
   use limber_deck_source, only: beside
   implicit none
   private
   public :: read_table, read_value, is_number

contains

   !> The columns of the file that *SWEEP names.
   subroutine read_table(deck, block, names, values, diagnostics)
      type(deck_type), intent(inout) :: deck
      integer, intent(in) :: block
      !> The parameters above its columns
      type(part_type), allocatable, intent(out) :: names(:)
      !> (names, rows)
      real(wp), allocatable, intent(out) :: values(:, :)
      type(diagnostics_type), intent(inout) :: diagnostics
      type(error_type), allocatable :: error
      type(part_type), allocatable :: parts(:)
      type(part_type) :: line
      real(wp), allocatable :: rows(:, :)
      logical :: ok
      integer :: file, i, k, count
      allocate (names(0), values(0, 0), rows(0, 0))
      call deck%source%read_file(beside(deck%source%files(deck%blocks(block)%origin%file)%path, deck%blocks(block)%text('FILE')), &
         & deck%blocks(block)%origin_of('FILE'), error)
      if (allocated(error)) then
         call diagnostics%add(deck%blocks(block)%origin_of('FILE'), error%message, &
            & 'the path is relative to the folder of this file')
         return
      end if
      file = deck%source%count
      count = 0
      do i = 1, size(deck%source%files(file)%lines)
         line = trimmed(deck%source%files(file)%lines(i)%text, origin_type(file, i, 1, 1), 1, &
            & len(deck%source%files(file)%lines(i)%text))
         if (len(line%text) == 0) cycle
         if (line%text(1:1) == '#') cycle
         call split_fields(line%text, line%origin, parts)
         if (size(names) == 0) then
            call move_alloc(parts, names)
            do k = 1, size(names)
               names(k)%text = lowercase(names(k)%text)
            end do
            deallocate (rows)
            allocate (rows(size(names), size(deck%source%files(file)%lines)))
         else if (size(parts) /= size(names)) then
            call diagnostics%add(line%origin, 'this row has '//as_text(size(parts))//' values for '//as_text(size(names))// &
               & ' columns')
            return
         else
            count = count + 1
            do k = 1, size(parts)
               call read_value(parts(k)%text, rows(k, count), ok)
               if (.not. ok .or. len(parts(k)%text) == 0 .or. .not. abs(rows(k, count)) <= huge(1.0_wp)) then
                  call diagnostics%add(parts(k)%origin, "'"//parts(k)%text//"' is not a number")
                  return
               end if
            end do
         end if
      end do
      if (count == 0) then
         call diagnostics%add(deck%blocks(block)%origin_of('FILE'), 'the file has no rows', &
            & 'names of parameters, then their values')
         return
      end if
      deallocate (values)
      allocate (values(size(names), count), source=rows(:, :count))
   end subroutine read_table

   !> A number, or an expression of numbers, such as pi/2.
   subroutine read_value(text, value, ok)
      character(*), intent(in) :: text
      real(wp), intent(out) :: value
      logical, intent(out) :: ok
      type(parameter_list_type) :: none
      type(expression_type) :: expression
      type(diagnostics_type) :: unheard
      integer :: status
      value = 0.0_wp
      if (is_number(trim(adjustl(text)))) then
         read (text, *, iostat=status) value
         ok = status == 0
         return
      end if
      call compile(text, origin_type(1, 1, 1, len(text)), none, expression, ok, unheard)
      if (ok) ok = expression%is_constant()
      if (ok) value = expression%constant_value()
   end subroutine read_value

   !> Whether a text has the form of a number; one with a sign within, as 1+1, is a sum: for Fortran it would be 1e+1.
   pure logical function is_number(text)
      character(*), intent(in) :: text
      integer :: i
      is_number = verify(text, '0123456789+-.eEdD') == 0
      do i = 2, len(text)
         if (scan(text(i:i), '+-') > 0) is_number = is_number .and. scan(text(i - 1:i - 1), 'eEdD') > 0
      end do
   end function is_number

end module limber_deck_sweep_table
