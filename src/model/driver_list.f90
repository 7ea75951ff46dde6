!> Drivers of the model: a new one with its name. Floor: model.
module limber_model_driver_list
   use limber_model_model, only: model_type, driver_type
   use limber_model_points, only: enter_name
   implicit none
   private
   public :: append_driver

contains

   !> Appends a driver, which has its name.
   subroutine append_driver(model, driver)
      type(model_type), intent(inout) :: model
      type(driver_type), intent(in) :: driver
      type(driver_type), allocatable :: longer(:)
      integer :: n
      n = size(model%drivers) + 1
      allocate (longer(n))
      longer(:n - 1) = model%drivers
      longer(n) = driver
      call move_alloc(longer, model%drivers)
      call enter_name(model, 'driver', driver%name, n)
   end subroutine append_driver

end module limber_model_driver_list
