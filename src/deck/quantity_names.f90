!> Names of quantities in expressions. What *OUTPUT can ask for, as names that nothing else may have. Floor: deck.
module limber_deck_quantity_names
   implicit none
   private
   public :: quantity_names

   !> In the order of limber_model_quantities, which says what they are
   character(16), parameter :: quantity_names(44) = [character(16) :: 'x', 'y', 'vx', 'vy', 'ax', 'ay', 'angle', 'spin', &
      & 'deflection', 'length', 'force_x', 'force_y', 'torque', 'kinetic_energy', 'potential_energy', 'work', 'u1', 'u2', &
      & 'rotation', 'tension', 'force_1', 'force_2', 'moment', 'joint_angle', 'joint_spin', 'displacement', 'sliding_speed', &
      & 'force', 'power', 'elongation', 'rate', 'axial_force', 'shear_force', 'bending_moment', 'stress_top', 'stress_bottom', &
      & 'momentum_x', 'momentum_y', 'angular_momentum', 'coupling', 'output', 'state', 'closed', 'lost']

end module limber_deck_quantity_names
