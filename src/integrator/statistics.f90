!> Counts of an integrator. Floor: integrator.
module limber_integrator_statistics
   use limber_base_kinds, only: wp, long
   use limber_base_snapshot, only: snapshot_type
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
   contains
      procedure :: exchange => exchange_step_statistics
   end type step_statistics_type

contains

   !> Saves or restores its memory.
   subroutine exchange_step_statistics(self, snapshot)
      class(step_statistics_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%exchange('steps', self%steps)
      call snapshot%exchange('rejected', self%rejected)
      call snapshot%exchange('failed_projections', self%failed_projections)
      call snapshot%exchange('evaluations', self%evaluations)
      call snapshot%exchange('jacobians', self%jacobians)
      call snapshot%exchange('factorisations', self%factorisations)
      call snapshot%exchange('smallest_step', self%smallest_step)
      call snapshot%exchange('largest_step', self%largest_step)
      call snapshot%exchange('highest_order', self%highest_order)
      call snapshot%exchange('position_residual', self%position_residual)
   end subroutine exchange_step_statistics

end module limber_integrator_statistics
