!> Values and derivatives of prescribed motions. Floor: model.
module limber_model_driver_laws
   use limber_base_kinds, only: wp
   use limber_deck_operations, only: jet_type
   use limber_model_law_integrals, only: integral_value
   use limber_model_model, only: driver_type
   implicit none
   private
   public :: driven_motion

contains

   !> Coordinate of a driver and its first two derivatives at time t: the law itself, or its integral plus the initial values, eq.
   !> (3.29).
   pure function driven_motion(driver, t) result(jet)
      type(driver_type), intent(in) :: driver
      real(wp), intent(in) :: t
      type(jet_type) :: jet
      if (driver%level == 0) then
         jet = driver%law%evaluate_jet(t)
         return
      end if
      jet = integral_value(driver%integral, driver%law, driver%level, t)
      jet%value = jet%value + driver%initial(1)
      if (driver%level == 1) return
      jet%value = jet%value + driver%initial(2)*(t - driver%integral%edges(0))
      jet%first = jet%first + driver%initial(2)
   end function driven_motion

end module limber_model_driver_laws
