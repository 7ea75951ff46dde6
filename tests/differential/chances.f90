!> Numbers by chance, from a seed alone, the same on every machine.
module chances
   use limber_base_kinds, only: wp, long
   implicit none
   private
   public :: sow, pick, between, decades, likely

   integer(long) :: state = 1

contains

   !> Begins anew.
   subroutine sow(seed)
      integer, intent(in) :: seed
      integer :: i
      state = mod(48271_long*seed + 11, 2147483646_long) + 1
      do i = 1, 5  ! neighbours part
         state = mod(state*16807_long, 2147483647_long)
      end do
   end subroutine sow

   !> A whole number from 1 to n, by the minimal standard generator of Park and Miller.
   integer function pick(n)
      integer, intent(in) :: n
      state = mod(state*16807_long, 2147483647_long)
      pick = 1 + int(mod(state/7, int(n, long)))
   end function pick

   !> A number of a range, with three digits.
   real(wp) function between(low, high) result(value)
      real(wp), intent(in) :: low, high
      character(16) :: text
      state = mod(state*16807_long, 2147483647_long)
      value = low + (high - low)*real(state, wp)/2147483647.0_wp
      write (text, '(es10.2)') value
      read (text, *) value
   end function between

   !> A number of a range of several decades, with three digits.
   real(wp) function decades(low, high) result(value)
      real(wp), intent(in) :: low, high
      character(16) :: text
      state = mod(state*16807_long, 2147483647_long)
      value = low*(high/low)**(real(state, wp)/2147483647.0_wp)
      write (text, '(es10.2)') value
      read (text, *) value
   end function decades

   !> True once in so many times.
   logical function likely(one_in)
      integer, intent(in) :: one_in
      likely = pick(one_in) == 1
   end function likely

end module chances
