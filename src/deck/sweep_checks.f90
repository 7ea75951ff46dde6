!> Checks of *SWEEP: its parameters and their values, before anything runs. Floor: deck.
module limber_deck_sweep_checks
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, suggestion, lowercase
   use limber_deck_content, only: deck_type, block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_lexer, only: part_type
   use limber_deck_origin, only: origin_type
   use limber_deck_sweep_table, only: read_table
   implicit none
   private
   public :: check_sweep

   !> Most runs of a sweep
   integer, parameter, public :: most_rows = 10000000

contains

   !> Reports a sweep of nothing, unknown parameters, and values that the method cannot use.
   subroutine check_sweep(deck, index, diagnostics)
      type(deck_type), intent(inout) :: deck
      !> Its block
      integer, intent(in) :: index
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: k, counts(size(deck%blocks(index)%lines)), before
      associate (block => deck%blocks(index))
         ! Its options may be for `limber sweep --set`
         if (size(counts) == 0 .and. .not. any(block%options%given)) call diagnostics%add(block%origin, '*SWEEP sweeps nothing', &
            & 'add lines: parameter, values; or FILE=')
         before = diagnostics%count
         do k = 1, size(counts)
            call check_parameter(deck, block%lines(k)%fields(1)%text, block%lines(k)%fields(1)%origin, diagnostics)
            call check_values(block, k, counts(k), diagnostics)
         end do
         if (diagnostics%count > before) return
         do k = 2, size(counts)
            if (block%word('METHOD') /= 'PAIRS' .or. counts(k) == counts(1)) cycle
            call diagnostics%add(block%lines(k)%origin_of(2), 'METHOD=PAIRS needs as many values of one parameter as of'// &
               & ' another, not '//as_text(counts(k))//' and '//as_text(counts(1)), &
               & 'give '//as_text(counts(1))//' values, or METHOD=GRID')
         end do
      end associate
      if (diagnostics%count == before) call check_file(deck, index, counts, diagnostics)
   end subroutine check_sweep

   !> Checks the file of a sweep. Rows of a sweep leave it out: it was looked at before.
   subroutine check_file(deck, index, counts, diagnostics)
      type(deck_type), intent(inout) :: deck
      integer, intent(in) :: index
      !> Numbers of values of the lines
      integer, intent(in) :: counts(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      type(part_type), allocatable :: columns(:)
      real(wp), allocatable :: values(:, :)
      integer :: files, before, i, k
      if (.not. deck%blocks(index)%given('FILE') .or. deck%blocks(index)%word('METHOD') == 'LATIN HYPERCUBE') return
      if (allocated(deck%parameters%overrides)) then
         if (size(deck%parameters%overrides) > 0) return
      end if
      files = deck%source%count
      before = diagnostics%count
      call read_table(deck, index, columns, values, diagnostics)
      if (diagnostics%count > before) return
      associate (block => deck%blocks(index))
         do i = 1, size(columns)
            call check_parameter(deck, columns(i)%text, columns(i)%origin, diagnostics)
            do k = 1, i - 1
               if (columns(k)%text == columns(i)%text) call complain(i)
            end do
            do k = 1, size(block%lines)
               if (block%lines(k)%text(1) == columns(i)%text) call complain(i)
            end do
         end do
         if (block%word('METHOD') == 'PAIRS' .and. any(counts /= size(values, 2))) call diagnostics%add( &
            & block%origin_of('FILE'), 'METHOD=PAIRS needs as many values of one parameter as of another, not '// &
            & as_text(size(values, 2))//' rows and '//as_text(counts(1))//' values', 'give as many, or METHOD=GRID')
      end associate
      ! Only messages show it
      if (diagnostics%count == before) deck%source%count = files

   contains

      !> Reports a column of a parameter that has its values already.
      subroutine complain(i)
         integer, intent(in) :: i
         call diagnostics%add(columns(i)%origin, "the parameter '"//columns(i)%text//"' is swept twice", 'remove one of the two')
      end subroutine complain

   end subroutine check_file

   !> Reports a parameter that the deck does not define, or that has the name of a scalar.
   subroutine check_parameter(deck, name, origin, diagnostics)
      type(deck_type), intent(in) :: deck
      character(*), intent(in) :: name
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      character(*), parameter :: otherwise = 'define it with *PARAMETER: name = value'
      integer :: i, k, m
      do i = 1, size(deck%blocks)
         if (deck%blocks(i)%keyword /= 'SCALAR') cycle
         do k = 1, size(deck%blocks(i)%lines)
            do m = 1, deck%blocks(i)%lines(k)%count()
               associate (field => deck%blocks(i)%lines(k)%fields(m))
                  if (lowercase(field%name) == name) call diagnostics%add(field%origin, "scalar '"//name// &
                     & "' has the name of a swept parameter", 'give it another name', origin, 'swept here')
               end associate
            end do
         end do
      end do
      associate (known => deck%parameters)
         if (known%find(name) > 0) return
         if (known%count == 0) then
            call diagnostics%add(origin, "there is no parameter '"//name//"'", otherwise, about=name)
         else
            call diagnostics%add(origin, "there is no parameter '"//name//"'", &
               & suggestion(name, known%items(:known%count)%name, otherwise), about=name)
         end if
      end associate
   end subroutine check_parameter

   !> Checks the values of a line.
   subroutine check_values(block, line, count, diagnostics)
      type(block_type), intent(in) :: block
      integer, intent(in) :: line
      !> Number of its values
      integer, intent(out) :: count
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp) :: part(3), before(size(block%lines(line)%fields))
      logical :: samples
      integer :: i, parts
      samples = block%word('METHOD') == 'LATIN HYPERCUBE'
      associate (fields => block%lines(line)%fields)
         count = size(fields) - 1
         do i = 2, size(fields)
            call read_parts(fields(i)%text, part, parts)
            if (parts > 1 .and. size(fields) > 2) then
               call complain(i, 'a range stands alone in its line', 'write numbers, or first:last:count')
            else if (samples .and. parts /= 2) then
               call complain(i, 'METHOD=LATIN HYPERCUBE cannot use this', 'it takes first:last, and SAMPLES= in place of a count')
            else if (.not. samples .and. parts == 2) then
               call complain(i, 'METHOD='//block%word('METHOD')//' cannot use this', &
                  & 'numbers, or first:last:count; first:last is for LATIN HYPERCUBE')
            else if (parts > 1 .and. .not. (part(2) > part(1) .or. part(2) < part(1))) then
               call complain(i, 'the range begins and ends with '//as_text(part(1)), &
                  & 'give two different numbers, or this one alone')
            else if (parts == 3 .and. part(3) < 2.0_wp) then
               call complain(i, 'a range has at least two values', 'give a count of 2 or more, or a number alone')
            else if (parts == 3 .and. part(3) > real(most_rows, wp)) then
               call complain(i, 'a sweep of '//as_text(part(3))//' runs', 'at most '//as_text(most_rows))
            else if (parts == 1 .and. block%word('METHOD') == 'GRID' .and. &
               & any(.not. (before(2:i - 1) > part(1) .or. before(2:i - 1) < part(1)))) then
               call complain(i, 'the value '//as_text(part(1))//' stands twice', 'leave one out: each value has its runs')
            else if (abs(0.5_wp*part(2) - 0.5_wp*part(1)) > 0.5_wp*huge(1.0_wp)) then
               call complain(i, 'the range is too wide for a number', 'the largest number is about 1.8e308')
            end if
            before(i) = part(1)
            if (parts == 3) count = nint(min(part(3), real(most_rows, wp)))
         end do
      end associate

   contains

      !> Adds an error at a field.
      subroutine complain(i, message, remedy)
         integer, intent(in) :: i
         character(*), intent(in) :: message, remedy
         call diagnostics%add(block%lines(line)%origin_of(i), message, remedy)
      end subroutine complain

   end subroutine check_values

   !> The numbers of a value: one, first:last, or first:last:count.
   pure subroutine read_parts(text, part, parts)
      character(*), intent(in) :: text
      real(wp), intent(out) :: part(3)
      integer, intent(out) :: parts
      integer :: first, colon, status
      part = 0.0_wp
      first = 1
      do parts = 1, 3
         colon = index(text(first:)//':', ':')
         read (text(first:first + colon - 2), *, iostat=status) part(parts)
         if (status /= 0) part(parts) = 0.0_wp
         first = first + colon
         if (first > len(text)) exit
      end do
      if (parts == 1) part(2) = part(1)
   end subroutine read_parts

end module limber_deck_sweep_checks
