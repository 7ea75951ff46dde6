!> Block elimination along trees, order 6. Bodies with three deflection coordinates. Floor: multibody. Source: doc/theory, eqs.
!> (4.24)-(4.26).
module limber_multibody_articulated_six
   use limber_base_kinds, only: wp
   implicit none
   private
   public :: eliminate_block, hand_on_block, gather_block, spread_block

   integer, parameter :: order = 6
   !> Pivots below this part of the first entry are none
   real(wp), parameter :: least_pivot = 1.0e-11_wp

contains

   include 'articulated_blocks.inc'

end module limber_multibody_articulated_six
