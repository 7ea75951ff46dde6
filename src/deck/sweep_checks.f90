!> Checks of *SWEEP: its parameters and their values, before anything runs. Floor: deck.
module limber_deck_sweep_checks
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, suggestion
   use limber_deck_content, only: deck_type, block_type, field_type
   use limber_deck_diagnostics, only: diagnostics_type
   implicit none
   private
   public :: check_sweep

   !> Most runs of a sweep
   integer, parameter, public :: most_rows = 10000000

contains

   !> Reports a sweep of nothing, unknown parameters, and values that the method cannot use.
   subroutine check_sweep(deck, index, diagnostics)
      type(deck_type), intent(in) :: deck
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
            call check_parameter(deck, block%lines(k)%fields(1), diagnostics)
            call check_values(block, k, counts(k), diagnostics)
         end do
         if (diagnostics%count > before .or. block%word('METHOD') /= 'PAIRS') return
         do k = 2, size(counts)
            if (counts(k) /= counts(1)) call diagnostics%add(block%lines(k)%origin_of(2), 'METHOD=PAIRS needs as many values of'// &
               & ' one parameter as of another, not '//as_text(counts(k))//' and '//as_text(counts(1)), &
               & 'give '//as_text(counts(1))//' values, or METHOD=GRID')
         end do
      end associate
   end subroutine check_sweep

   !> Reports a parameter that the deck does not define.
   subroutine check_parameter(deck, field, diagnostics)
      type(deck_type), intent(in) :: deck
      type(field_type), intent(in) :: field
      type(diagnostics_type), intent(inout) :: diagnostics
      character(*), parameter :: otherwise = 'define it with *PARAMETER: name = value'
      associate (known => deck%parameters)
         if (known%find(field%text) > 0) return
         if (known%count == 0) then
            call diagnostics%add(field%origin, "there is no parameter '"//field%text//"'", otherwise, about=field%text)
         else
            call diagnostics%add(field%origin, "there is no parameter '"//field%text//"'", &
               & suggestion(field%text, known%items(:known%count)%name, otherwise), about=field%text)
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
      real(wp) :: part(3)
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
            else if (abs(0.5_wp*part(2) - 0.5_wp*part(1)) > 0.5_wp*huge(1.0_wp)) then
               call complain(i, 'the range is too wide for a number', 'the largest number is about 1.8e308')
            end if
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
