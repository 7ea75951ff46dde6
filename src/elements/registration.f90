!> Registration of all kinds of joints, and of all joints, drivers and loads: a line for each. Their order is that of the manual.
!> Floor: elements.
submodule (limber_deck_keywords) limber_elements_registration
   use limber_elements_revolute, only: revolute_kind
   use limber_elements_point_on_line, only: point_on_line_kind
   use limber_elements_translational, only: translational_kind
   use limber_elements_weld, only: weld_kind
   use limber_elements_rod, only: rod_kind
   use limber_elements_point_on_curve, only: point_on_curve_kind
   use limber_elements_sliding, only: sliding_kind
   use limber_elements_gear, only: gear_kind
   use limber_elements_rack, only: rack_kind
   use limber_elements_belt, only: belt_kind
   use limber_elements_joint, only: joint_element
   use limber_elements_coupler, only: coupler_element
   use limber_elements_driver, only: driver_element
   use limber_elements_motion, only: motion_element
   use limber_elements_force, only: force_element
   use limber_elements_torque, only: torque_element
   use limber_elements_spring, only: spring_element
   use limber_elements_bushing, only: bushing_element
   use limber_elements_distributed_load, only: distributed_load_element
   use limber_elements_friction, only: friction_element
   use limber_elements_stop, only: stop_element
   use limber_elements_switch, only: switch_element, switch_options
   use limber_elements_control, only: control_element
   use limber_elements_event, only: event_element
   use limber_deck_schema, only: keyword_rows_type
   use limber_model_element, only: element_type, add_element
   use limber_model_joint_kind, only: add_joint_kind
   implicit none

contains

   module subroutine register_elements()
      call add_joint_kind(revolute_kind())
      call add_joint_kind(point_on_line_kind())
      call add_joint_kind(translational_kind())
      call add_joint_kind(weld_kind())
      call add_joint_kind(rod_kind())
      call add_joint_kind(point_on_curve_kind())
      call add_joint_kind(sliding_kind())
      call add_joint_kind(gear_kind())
      call add_joint_kind(rack_kind())
      call add_joint_kind(belt_kind())
      call register(joint_element())
      call register(coupler_element())
      call register(driver_element())
      call register(motion_element())
      call register(force_element())
      call register(torque_element())
      call register(spring_element())
      call register(bushing_element())
      call register(distributed_load_element())
      call register(friction_element())
      call register(stop_element())
      call register(switch_element())
      call register(control_element())
      call register(event_element())
   end subroutine register_elements

   !> Adds an element to the list, and its rows to the keyword table.
   subroutine register(element)
      class(element_type), intent(in) :: element
      type(keyword_rows_type) :: rows
      call add_element(element)
      rows = element%rows
      if (element%switchable) rows%options = [rows%options, switch_options(rows%keyword%name)]
      call add_rows(rows)
   end subroutine register

end submodule limber_elements_registration
