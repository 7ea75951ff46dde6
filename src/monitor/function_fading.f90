!> How damping ends vibrations that functions of exact beams have too late or not at all. Rates at which a vibration fades, and most
!> that a wrong frequency makes of it. Floor: monitor. Source: doc/theory, eq. (7.58), section 7.14.
module limber_monitor_function_fading
   use limber_base_kinds, only: wp
   implicit none
   private
   public :: fading_type, fading_of, faded, late_part

   !> A vibration with its damping
   type :: fading_type
      !> Whether it creeps back, damped beyond its critical damping
      logical :: creeps = .false.
      !> Rates at which it fades [1/time]: the same below the critical damping; beyond it those of its speed and of its place
      real(wp) :: fast = 0.0_wp, slow = 0.0_wp
      !> Most that is wrong of its amplitude, in relative errors of its frequency
      real(wp) :: most_late = huge(1.0_wp)
      !> How far it goes beyond a load that comes at once, in parts of the load
      real(wp) :: overshoot = 1.0_wp
   end type fading_type

contains

   !> Damping of a vibration.
   elemental function fading_of(ratio, omega2) result(fading)
      !> Ratio of damping, squared frequency
      real(wp), intent(in) :: ratio, omega2
      type(fading_type) :: fading
      real(wp) :: angle
      if (.not. ratio > 0.0_wp .or. .not. omega2 > 0.0_wp) return
      fading%creeps = ratio >= 1.0_wp
      if (fading%creeps) then
         fading%fast = sqrt(omega2)*(ratio + sqrt(ratio**2 - 1))
         fading%slow = omega2/fading%fast
         fading%most_late = 2.0_wp
         fading%overshoot = 0.0_wp
      else
         fading%fast = ratio*sqrt(omega2)
         fading%slow = fading%fast
         angle = 0.5_wp*acos(-1.0_wp)*ratio/sqrt(1 - ratio**2)
         fading%overshoot = exp(-2*angle)
         fading%most_late = 2*(1 + fading%overshoot)/max(tanh(angle), 1.0e-100_wp)
      end if
   end function fading_of

   !> What a time leaves of the square of a vibration.
   elemental real(wp) function faded(rate, time)
      real(wp), intent(in) :: rate, time
      faded = exp(-2*rate*max(time, 0.0_wp))
   end function faded

   !> Part of an amplitude that is wrong, eq. (7.58).
   elemental real(wp) function late_part(fading, omega2, error, time, opposite) result(part)
      type(fading_type), intent(in) :: fading
      !> Squared frequency, its root's relative error, time since the vibration may have begun, most
      real(wp), intent(in) :: omega2, error, time, opposite
      part = min(opposite, sqrt(omega2)*error*time)
      if (fading%creeps) part = min(1.0_wp, part)
      if (error < part/fading%most_late) part = error*fading%most_late
   end function late_part

end module limber_monitor_function_fading
