!> Reading position in the text of an expression. Blanks, words, numbers. Floor: deck.
module limber_deck_cursor
   use limber_base_kinds, only: wp
   use limber_deck_lexer, only: blanks
   implicit none
   private
   public :: cursor_type, skip_blanks, peek, next_word, next_number, read_number, letters, digits

   !> What words and numbers are made of
   character(*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyz_', digits = '0123456789'

   !> A text that is read from the left to the right
   type :: cursor_type
      !> In lower case
      character(:), allocatable :: text
      !> Column that is read next
      integer :: at = 1
   end type cursor_type

contains

   !> Moves behind blanks and tabs.
   pure subroutine skip_blanks(c)
      class(cursor_type), intent(inout) :: c
      do while (c%at <= len(c%text))
         if (scan(c%text(c%at:c%at), blanks) == 0) exit
         c%at = c%at + 1
      end do
   end subroutine skip_blanks

   !> The next character, or two; blank behind the end.
   pure function peek(c, count) result(next)
      class(cursor_type), intent(in) :: c
      integer, intent(in), optional :: count
      character(:), allocatable :: next
      integer :: n
      n = 1
      if (present(count)) n = count
      next = repeat(' ', n)
      if (c%at + n - 1 <= len(c%text)) next = c%text(c%at:c%at + n - 1)
   end function peek

   !> The word of letters, digits and underscores that begins here; may be empty.
   pure function next_word(c) result(word)
      class(cursor_type), intent(in) :: c
      character(:), allocatable :: word
      word = ''
      if (c%at <= len(c%text)) word = c%text(c%at:c%at + span(c%text(c%at:), letters//digits) - 1)
   end function next_word

   !> The number that begins here: digits, point, exponent as far as they follow each other.
   pure function next_number(c) result(number)
      class(cursor_type), intent(in) :: c
      character(:), allocatable :: number
      integer :: last, mark
      last = c%at + span(c%text(c%at:), digits) - 1
      if (last < len(c%text)) then
         if (c%text(last + 1:last + 1) == '.') last = last + 1 + span(c%text(last + 2:), digits)
      end if
      mark = last + 1
      if (mark < len(c%text)) then
         if (scan(c%text(mark:mark), 'ed') > 0) then
            mark = mark + 1
            if (scan(c%text(mark:mark), '+-') > 0) mark = mark + 1
            if (span(c%text(mark:), digits) > 0) last = mark + span(c%text(mark:), digits) - 1
         end if
      end if
      number = c%text(c%at:last)
   end function next_number

   !> The value of such a number.
   subroutine read_number(number, value, status)
      character(*), intent(in) :: number
      real(wp), intent(out) :: value
      !> 0: a number; 1: none; 2: too large; 3: too small, but not 0
      integer, intent(out) :: status
      character(16) :: form
      value = 0.0_wp
      status = 1
      if (scan(number, digits) == 0) return
      write (form, '("(f",i0,".0)")') len(number)
      read (number, form, iostat=status) value
      if (status /= 0 .or. .not. abs(value) <= huge(value)) status = 2
      if (status == 0 .and. abs(value) < tiny(value) .and. scan(number(:scan(number//'e', 'ed') - 1), '123456789') > 0) status = 3
   end subroutine read_number

   !> Number of characters at the beginning of a text that belong to a set.
   pure integer function span(text, set)
      character(*), intent(in) :: text, set
      span = verify(text, set) - 1
      if (span < 0) span = len(text)
   end function span

end module limber_deck_cursor
