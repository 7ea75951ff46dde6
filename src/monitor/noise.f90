!> Limit below which deflections are errors of the integrator. What watches would make of them is not told. Floor: monitor.
module limber_monitor_noise
   use limber_base_kinds, only: wp
   implicit none
   private
   public :: noise_of

contains

   !> Part of its length below which a deflection of a body is none.
   pure real(wp) function noise_of(tolerance) result(noise)
      !> Of the integration
      real(wp), intent(in) :: tolerance
      !> Part of the tolerance, the most and the least
      real(wp), parameter :: part = 2.0e-2_wp, most = 1.0e-6_wp, least = 1.0e-9_wp
      noise = max(least, min(most, part*tolerance))
   end function noise_of

end module limber_monitor_noise
