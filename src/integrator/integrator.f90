!> The abstract integrator: start, step, interpolate. It advances the state [q; v; w] of a system, w being the work put in by
!> drivers and loads; it never writes files. Its memory is all in named components, so that it can be restarted exactly.
!> Floor: integrator.
module limber_integrator_integrator
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_integrator_statistics, only: step_statistics_type
   use limber_system_system, only: system_type, workspace_type
   implicit none
   private
   public :: integrator_type

   !> An integrator between two steps
   type, abstract :: integrator_type
      !> Local error allowed in a step, relative to the scales
      real(wp) :: tolerance = 1.0e-6_wp
      !> First step, and largest step; zero: chosen, unbounded
      real(wp) :: initial_step = 0.0_wp, maximum_step = 0.0_wp
      !> Time reached
      real(wp) :: t = 0.0_wp
      !> Time of the step before: `interpolate` serves from there to t
      real(wp) :: t_before = 0.0_wp
      type(step_statistics_type) :: statistics
   contains
      procedure(start_interface), deferred :: start
      procedure(step_interface), deferred :: step
      procedure(interpolate_interface), deferred :: interpolate
   end type integrator_type

   abstract interface
      !> Takes over an assembled state (t, q, v) and prepares the first step.
      subroutine start_interface(self, system, work, t, duration, q, v, error)
         import :: integrator_type, system_type, workspace_type, error_type, wp
         class(integrator_type), intent(inout) :: self
         type(system_type), intent(in) :: system
         type(workspace_type), intent(inout) :: work
         !> Time, and time from there to the end of the analysis
         real(wp), intent(in) :: t, duration
         !> Coordinates and velocities (nq)
         real(wp), intent(in) :: q(:), v(:)
         type(error_type), allocatable, intent(out) :: error
      end subroutine start_interface

      !> One accepted step, not beyond `stop`.
      subroutine step_interface(self, system, work, stop, error)
         import :: integrator_type, system_type, workspace_type, error_type, wp
         class(integrator_type), intent(inout) :: self
         type(system_type), intent(in) :: system
         type(workspace_type), intent(inout) :: work
         !> Time that the step may not pass
         real(wp), intent(in) :: stop
         type(error_type), allocatable, intent(out) :: error
      end subroutine step_interface

      !> State at a time within the last step, to the accuracy of the step; not projected.
      subroutine interpolate_interface(self, t, q, v, w)
         import :: integrator_type, wp
         class(integrator_type), intent(inout) :: self
         real(wp), intent(in) :: t
         !> Coordinates and velocities (nq), work put in
         real(wp), intent(out) :: q(:), v(:), w
      end subroutine interpolate_interface
   end interface

end module limber_integrator_integrator
