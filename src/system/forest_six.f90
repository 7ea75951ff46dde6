!> Elimination along trees for blocks of order 6: bodies with three deflection coordinates.
!> Floor: system. Source: doc/theory, eqs. (166)-(168).
module limber_system_forest_six
   use limber_base_kinds, only: wp
   implicit none
   private
   public :: eliminate_block, hand_on_block, gather_block, spread_block

   integer, parameter :: order = 6
   !> Pivots below this part of the first entry are none
   real(wp), parameter :: least_pivot = 1.0e-11_wp

contains

   include 'forest_blocks.inc'

end module limber_system_forest_six
