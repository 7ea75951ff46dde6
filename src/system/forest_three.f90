!> Elimination along trees for blocks of order 3: rigid bodies. Floor: system. Source: doc/theory, eqs. (166)-(168).
module limber_system_forest_three
   use limber_base_kinds, only: wp
   implicit none
   private
   public :: eliminate_block, hand_on_block, gather_block, spread_block

   integer, parameter :: order = 3
   !> Pivots below this part of the first entry are none
   real(wp), parameter :: least_pivot = 1.0e-11_wp

contains

   include 'forest_blocks.inc'

end module limber_system_forest_three
