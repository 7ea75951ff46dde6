!> Norms of errors of channels. They serve `limber study` and the estimate of a run. Floor: scene.
module limber_scene_channel_errors
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use limber_base_kinds, only: wp
   implicit none
   private
   public :: magnitude, envelope, shrinkage, widening

   !> Ratio that counts as unknown
   real(wp), parameter, public :: unknown_ratio = -1.0_wp
   !> Largest ratio that eq. (7.5) is used with, and smallest one at which errors count as not shrinking
   real(wp), parameter :: largest_ratio = 0.75_wp
   real(wp), parameter, public :: no_shrinkage = 0.9_wp

contains

   !> Largest magnitude of a channel, which errors are relative to; one if it is zero throughout.
   pure real(wp) function magnitude(values)
      real(wp), intent(in) :: values(:)
      magnitude = maxval(abs(values))
      if (.not. magnitude > 0.0_wp) magnitude = 1.0_wp
   end function magnitude

   !> Largest magnitude among each sample and its neighbours, in eq. (7.6): a difference that changes its sign leaves no gap there.
   pure function envelope(difference, reach) result(largest)
      real(wp), intent(in) :: difference(:)
      !> Neighbours on each side
      integer, intent(in) :: reach
      real(wp) :: largest(size(difference))
      integer :: k
      do k = 1, size(difference)
         largest(k) = maxval(abs(difference(max(1, k - reach):min(size(difference), k + reach))))
      end do
   end function envelope

   !> Ratio of the difference to a more accurate run and that to a less accurate one, both over all samples: eq. (7.4).
   !> Zero if there is no difference, `unknown_ratio` if they are no numbers.
   pure real(wp) function shrinkage(fine, coarse) result(ratio)
      real(wp), intent(in) :: fine(:), coarse(:)
      real(wp) :: below
      ratio = norm2(fine)
      if (.not. ratio > 0.0_wp) return
      below = norm2(coarse)
      if (ieee_is_finite(ratio) .and. ieee_is_finite(below)) then
         ratio = ratio/max(below, tiny(below)*max(1.0_wp, ratio))
      else
         ratio = unknown_ratio
      end if
   end function shrinkage

   !> What a difference of two runs is multiplied by to bound the error of the coarser one: eq. (7.5).
   elemental real(wp) function widening(ratio)
      !> Of their errors, or `unknown_ratio`
      real(wp), intent(in) :: ratio
      widening = 2.0_wp
      if (ratio >= 0.0_wp) widening = 1/(1 - min(ratio, largest_ratio))
   end function widening

end module limber_scene_channel_errors
