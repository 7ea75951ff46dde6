!> What every integrator counts. Floor: integrator.
module limber_integrator_statistics
   use limber_base_kinds, only: wp, long
   implicit none
   private
   public :: step_statistics_type

   !> Counts of one run
   type :: step_statistics_type
      !> Steps accepted, steps rejected by the error test, and by the projection
      integer(long) :: steps = 0, rejected = 0, failed_projections = 0
      !> Evaluations of the equations of motion, of their derivatives, and factorisations of matrices
      integer(long) :: evaluations = 0, jacobians = 0, factorisations = 0
      !> Smallest and largest accepted step [time]
      real(wp) :: smallest_step = huge(1.0_wp), largest_step = 0.0_wp
      !> Largest order used
      integer :: highest_order = 0
      !> Largest residual of the position constraints of an accepted state, relative to their scales
      real(wp) :: position_residual = 0.0_wp
   end type step_statistics_type

end module limber_integrator_statistics
