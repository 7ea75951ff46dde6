!> Sines and cosines of several angles at once. Small ones are sums of powers, which the compiler takes two at a time: to round-off,
!> at a third of the cost. Floor: base.
module limber_base_sines
   use limber_base_kinds, only: wp
   implicit none
   private
   public :: take_sines

   !> Largest angle of the sums: what they leave out is below 3e-17 [rad]
   real(wp), parameter :: small = 0.3_wp

contains

   !> Sines and cosines.
   pure subroutine take_sines(n, angle, sine, cosine)
      integer, intent(in) :: n
      !> (n) [rad]
      real(wp), intent(in) :: angle(n)
      real(wp), intent(out) :: sine(n), cosine(n)
      real(wp) :: square, largest
      integer :: k
      largest = 0.0_wp
      do k = 1, n
         largest = max(largest, abs(angle(k)))
      end do
      if (largest <= small) then
         do k = 1, n
            square = angle(k)**2
            sine(k) = angle(k) - angle(k)*square*(1.0_wp/6 - square*(1.0_wp/120 - square*(1.0_wp/5040 - square*(1.0_wp/362880 &
               & - square*(1.0_wp/39916800)))))
            cosine(k) = 1.0_wp - square*(0.5_wp - square*(1.0_wp/24 - square*(1.0_wp/720 - square*(1.0_wp/40320 &
               & - square*(1.0_wp/3628800 - square*(1.0_wp/479001600))))))
         end do
         return
      end if
      do k = 1, n
         cosine(k) = cos(angle(k))
      end do
      do k = 1, n
         sine(k) = sin(angle(k))
      end do
   end subroutine take_sines

end module limber_base_sines
