!> Text: case, numbers as text, the nearest valid name. Floor: base.
module limber_base_text
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use limber_base_kinds, only: wp, long
   implicit none
   private
   public :: lowercase, uppercase, as_text, nearest_name, suggestion, first_line, one_line, newline

   !> Line separator of every text that limber writes
   character(1), parameter :: newline = new_line('a')

   !> A number as text without blanks; a real as the shortest form that reads back to the same bits
   !> (or, with `digits`, rounded to so many significant digits)
   interface as_text
      module procedure :: integer_as_text, long_as_text, real_as_text
   end interface as_text

contains

   !> The same text in lower case (ASCII).
   pure function lowercase(text) result(lower)
      character(*), intent(in) :: text
      character(len(text)) :: lower
      integer :: i
      do i = 1, len(text)
         select case (text(i:i))
         case ('A':'Z'); lower(i:i) = achar(iachar(text(i:i)) + 32)
         case default; lower(i:i) = text(i:i)
         end select
      end do
   end function lowercase

   !> The same text in upper case (ASCII).
   pure function uppercase(text) result(upper)
      character(*), intent(in) :: text
      character(len(text)) :: upper
      integer :: i
      do i = 1, len(text)
         select case (text(i:i))
         case ('a':'z'); upper(i:i) = achar(iachar(text(i:i)) - 32)
         case default; upper(i:i) = text(i:i)
         end select
      end do
   end function uppercase

   !> A text up to its first line feed.
   pure function first_line(text) result(line)
      character(*), intent(in) :: text
      character(:), allocatable :: line
      line = text(:index(text//newline, newline) - 1)
   end function first_line

   !> A text from outside in one line and without control characters: a blank in place of each.
   pure function one_line(text) result(line)
      character(*), intent(in) :: text
      character(len(text)) :: line
      integer :: i
      line = text
      do i = 1, len(line)
         if (iachar(line(i:i)) < 32 .or. iachar(line(i:i)) == 127) line(i:i) = ' '
      end do
   end function one_line

   pure function integer_as_text(value) result(text)
      integer, intent(in) :: value
      character(:), allocatable :: text
      text = long_as_text(int(value, long))
   end function integer_as_text

   pure function long_as_text(value) result(text)
      integer(long), intent(in) :: value
      character(:), allocatable :: text
      character(24) :: buffer
      write (buffer, '(i0)') value
      text = trim(buffer)
   end function long_as_text

   pure function real_as_text(value, digits) result(text)
      real(wp), intent(in) :: value
      integer, intent(in), optional :: digits
      character(:), allocatable :: text
      character(40) :: buffer
      real(wp) :: back
      integer :: count
      if (ieee_is_nan(value)) then
         text = 'nan'
         return
      else if (abs(value) > huge(value)) then
         text = merge('inf ', '-inf', value > 0.0_wp)
         text = trim(text)
         return
      end if
      if (present(digits)) then
         ! Rounded to fewer digits the largest numbers would be beyond all
         buffer = rounded(value, merge(17, min(max(digits, 1), 17), abs(value) > 1.79e308_wp))
      else
         ! The least that read back to the same bits: a number of at most 15 digits is itself when rounded to 15, with zeros behind
         do count = merge(17, 15, abs(value) > 1.79e308_wp), 17
            buffer = rounded(value, count)
            if (count == 17) exit
            read (buffer, *) back
            if (.not. abs(back - value) > 0.0_wp) exit
         end do
      end if
      text = plain_form(trim(adjustl(buffer)))
   end function real_as_text

   !> A number with so many significant digits, as 'd.dddE+eee'.
   pure function rounded(value, digits) result(buffer)
      real(wp), intent(in) :: value
      integer, intent(in) :: digits
      character(40) :: buffer
      character(16) :: form
      buffer = ''
      write (form, '("(es40.",i0,"e3)")') digits - 1
      write (buffer, form) value
   end function rounded

   !> Rewrites 'd.dddE+eee' without needless zeros, as a plain decimal if that is short.
   pure function plain_form(scientific) result(text)
      character(*), intent(in) :: scientific
      character(:), allocatable :: text, mantissa, sign
      integer :: mark, exponent, point
      mark = index(scientific, 'E')
      read (scientific(mark + 1:), *) exponent
      mantissa = scientific(:mark - 1)
      sign = ''
      if (mantissa(1:1) == '-') then
         sign = '-'
         mantissa = mantissa(2:)
      end if
      point = index(mantissa, '.')
      mantissa = mantissa(:point - 1)//mantissa(point + 1:)
      do while (len(mantissa) > 1 .and. mantissa(len(mantissa):) == '0')
         mantissa = mantissa(:len(mantissa) - 1)
      end do
      if (verify(mantissa, '0') == 0) then
         text = '0'
      else if (exponent >= 0 .and. exponent < 6) then
         if (len(mantissa) <= exponent + 1) then
            text = sign//mantissa//repeat('0', exponent + 1 - len(mantissa))
         else
            text = sign//mantissa(:exponent + 1)//'.'//mantissa(exponent + 2:)
         end if
      else if (exponent < 0 .and. exponent >= -3) then
         text = sign//'0.'//repeat('0', -exponent - 1)//mantissa
      else
         text = sign//mantissa(1:1)
         if (len(mantissa) > 1) text = text//'.'//mantissa(2:)
         text = text//'e'//integer_as_text(exponent)
      end if
   end function plain_form

   !> Index of the candidate nearest to a misspelt name by edit distance; 0 if none is near enough
   !> (more than a third of its letters differ, or all). A word left out or added counts as a letter. Case and blanks around are
   !> ignored.
   pure integer function nearest_name(name, candidates) result(nearest)
      character(*), intent(in) :: name
      character(*), intent(in) :: candidates(:)
      character(len(name)) :: wanted
      integer :: i, distance, best
      wanted = lowercase(adjustl(name))
      nearest = 0
      best = min(max(1, (len_trim(name) + 2)/3) + 1, len_trim(name))
      do i = 1, size(candidates)
         ! Among many names only those of a like length can be near, or those that have a word more or less
         if (abs(len_trim(candidates(i)) - len_trim(name)) >= best .and. index(candidates(i), ' ') > len_trim(candidates(i)) &
            & .and. index(trim(wanted), ' ') == 0) cycle
         distance = name_distance(trim(wanted), lowercase(trim(adjustl(candidates(i)))))
         if (distance < best) then
            best = distance
            nearest = i
         end if
         if (best <= 1) exit
      end do
   end function nearest_name

   !> Remedy for an unknown name: the nearest candidate, or another remedy if none is near.
   pure function suggestion(name, candidates, otherwise) result(text)
      !> What is written; names that exist, empty ones aside; the other remedy
      character(*), intent(in) :: name, candidates(:), otherwise
      character(:), allocatable :: text
      integer :: near
      near = nearest_name(name, candidates)
      text = otherwise
      if (near > 0) text = "did you mean '"//trim(candidates(near))//"'?"
   end function suggestion

   !> How far two names are from each other, in letters.
   pure integer function name_distance(a, b) result(distance)
      character(*), intent(in) :: a, b
      distance = edit_distance(a, b)
      if (begins_or_ends(a, b) .or. begins_or_ends(b, a)) distance = min(distance, 1)
   end function name_distance

   !> Whether a text begins or ends with another one, and a blank is between that and the rest.
   pure logical function begins_or_ends(part, text)
      character(*), intent(in) :: part, text
      integer :: n
      n = len(part)
      begins_or_ends = .false.
      if (n == 0 .or. len(text) <= n) return
      begins_or_ends = text(:n + 1) == part//' ' .or. text(len(text) - n:) == ' '//part
   end function begins_or_ends

   !> Levenshtein distance of two texts.
   pure integer function edit_distance(a, b) result(distance)
      character(*), intent(in) :: a, b
      integer :: row(0:len(b)), i, j, diagonal, above
      row = [(j, j=0, len(b))]
      do i = 1, len(a)
         diagonal = row(0)
         row(0) = i
         do j = 1, len(b)
            above = row(j)
            row(j) = min(above + 1, row(j - 1) + 1, diagonal + merge(0, 1, a(i:i) == b(j:j)))
            diagonal = above
         end do
      end do
      distance = row(len(b))
   end function edit_distance

end module limber_base_text
