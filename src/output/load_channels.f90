!> Forces, elongations and power of loads. Elongations, tensions, torques, forces of bushings, power. Floor: output.
module limber_output_load_channels
   use limber_base_kinds, only: wp
   use limber_model_quantities, only: quantity_force_x, quantity_force_y, quantity_moment, quantity_power, quantity_elongation, &
      & quantity_rate, quantity_tension, quantity_torque, quantity_closed
   use limber_model_model, only: quantity_type
   use limber_multibody_contact_impulses, only: contact_push
   use limber_multibody_force_elements, only: force_element_type
   use limber_multibody_kinematics, only: kinematics_type
   use limber_multibody_load, only: load_type
   use limber_multibody_system, only: system_type, workspace_type, number_of_contacts
   implicit none
   private
   public :: load_value

contains

   !> A quantity of a load of the deck.
   real(wp) function load_value(system, work, quantity) result(value)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      type(quantity_type), intent(in) :: quantity
      integer :: i
      real(wp) :: force(2)
      value = 0.0_wp
      associate (first => system%model%loads(quantity%of)%first, last => system%model%loads(quantity%of)%last)
         select case (quantity%kind)
         case (quantity_power)
            do i = first, last
               value = value + load_power(system%loads(i)%item, work%kinematics)
            end do
         case (quantity_force_x, quantity_force_y)
            force = load_vector(system%loads(first)%item, work%kinematics) &
               & + load_vector(system%loads(first + 1)%item, work%kinematics)
            value = force(merge(1, 2, quantity%kind == quantity_force_x))
         case (quantity_moment)
            value = spring_value(system%loads(last)%item, work%kinematics, quantity_moment)
         case (quantity_closed)
            if (any(system%model%contacts%load == quantity%of .and. system%on(system%model%contacts%switch))) value = 1.0_wp
         case default
            value = spring_value(system%loads(first)%item, work%kinematics, quantity%kind)
            if (quantity%kind == quantity_tension .or. quantity%kind == quantity_torque) value = value &
               & + rigid_pull(system, work, quantity%of)
            if (quantity%kind == quantity_torque .and. system%model%loads(quantity%of)%from_second) value = -value
         end select
      end associate
   end function load_value

   !> Pull of the contacts of a rigid stop; zero of all other loads.
   pure real(wp) function rigid_pull(system, work, load) result(pull)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      !> Index of the named load
      integer, intent(in) :: load
      integer :: i
      pull = 0.0_wp
      do i = 1, number_of_contacts(system%model)
         associate (contact => system%model%contacts(i))
            if (contact%load == load) pull = pull - contact%side*contact_push(system, work, i)
         end associate
      end do
   end function rigid_pull

   !> Elongation, its rate, tension or torque of a spring.
   real(wp) function spring_value(load, kinematics, kind) result(value)
      class(load_type), intent(in) :: load
      type(kinematics_type), intent(in) :: kinematics
      !> Index into the table of quantities
      integer, intent(in) :: kind
      real(wp) :: elongation, rate, push
      call load%state_along(kinematics, elongation, rate, push)
      select case (kind)
      case (quantity_elongation); value = elongation
      case (quantity_rate); value = rate
      case (quantity_moment); value = push
      case default; value = -push
      end select
   end function spring_value

   !> Force of a force element on its first marker, along the fixed axes (2).
   function load_vector(load, kinematics) result(force)
      class(load_type), intent(in) :: load
      type(kinematics_type), intent(in) :: kinematics
      real(wp) :: force(2), elongation, rate, push, weights(2, 3)
      force = 0.0_wp
      select type (load)
      type is (force_element_type)
         call load%force_along(kinematics, elongation, rate, push, weights)
         force = push*weights(:, 1)
      end select
   end function load_vector

   !> Power that a load gives to the bodies: what it puts in and what it takes from its energy.
   real(wp) function load_power(load, kinematics) result(power)
      class(load_type), intent(in) :: load
      type(kinematics_type), intent(in) :: kinematics
      real(wp) :: elongation, rate, push
      call load%state_along(kinematics, elongation, rate, push)
      power = push*rate
   end function load_power

end module limber_output_load_channels
