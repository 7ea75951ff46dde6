!> Base type of integrators: start, step, interpolate. It advances the state [q; v; w] of a system, w being the work put in by
!> drivers and loads; it never writes files. Its memory is all in named components, so that it can be restarted exactly. Floor:
!> integrator.
module limber_integrator_integrator
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text
   use limber_integrator_unfollowed_vibrations, only: ringing_type
   use limber_integrator_statistics, only: step_statistics_type
   use limber_integrator_work_integral, only: work_type
   use limber_multibody_equations_of_motion, only: worst_constraint
   use limber_multibody_redundant_constraints, only: constraint_names
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: integrator_type, even_step

   !> Relative residual of the position constraints that a step aims at, and the one that is tolerated where round-off forbids
   !> more
   real(wp), parameter, public :: constraint_tolerance = 1.0e-14_wp, constraint_limit = 1.0e-11_wp

   !> An integrator between two steps
   type, abstract :: integrator_type
      !> Local error allowed in a step, relative to the scales
      real(wp) :: tolerance = 1.0e-6_wp
      !> First step, and largest step; zero: chosen, unbounded
      real(wp) :: initial_step = 0.0_wp, maximum_step = 0.0_wp
      !> The length of every step, whatever its error: the tolerance is then that of iterations only; zero: chosen by the error
      real(wp) :: fixed_step = 0.0_wp
      !> Time reached
      real(wp) :: t = 0.0_wp
      !> Time of the step before: `interpolate` serves from there to t
      real(wp) :: t_before = 0.0_wp
      !> Work put in before the start
      real(wp) :: work_at_start = 0.0_wp
      !> Work put in by drivers and loads
      type(work_type) :: input
      !> What it loses of vibrations that it does not follow
      type(ringing_type) :: ringing
      !> True if channels ask for speeds or what follows from them: errors of rates count as they are then
      logical :: speeds_asked = .false.
      !> True if what it promises holds at the ends of its steps only: samples are then taken there, their velocities as they are
      logical :: ends_on_samples = .false.
      !> Whether its steps pass over fast vibrations: a deflection within a step is as exact as a motion, not as its force
      logical :: steps_over = .false.
      !> Whether a step knows the loads within it, not those at its ends alone
      logical :: sees_inside = .false.
      !> Steps that it takes behind a start until they are as long as before
      integer :: steps_to_start = 4
      !> Order of the last step
      integer :: order = 0
      !> Whether the error of the last step would have allowed one of more than twice its length
      logical :: spare = .false.
      type(step_statistics_type) :: statistics
   contains
      procedure(start_interface), deferred :: start
      procedure(step_interface), deferred :: step
      !> Takes over a state at t in which loads have jumped by what hardly changes them otherwise, as at a sample of a control
      procedure :: resume => resume_by_start
      procedure(interpolate_interface), deferred :: interpolate
      !> The same where coordinates alone are asked for: velocities, and the work if no channel asks for it, may be left as they are
      procedure :: interpolate_place => interpolate_all
      !> Coordinates and velocities that `interpolate` leaves to those they follow from; called behind it
      procedure :: complete => complete_nothing
      !> Accelerations of the dense output; called behind `interpolate`
      procedure :: interpolate_accelerations => interpolate_none
      !> Saves or restores its memory; behind `start`, which makes room for it
      procedure(exchange_interface), deferred :: exchange
      procedure :: count_step, least_step, last_digits, step_too_small, exchange_common
   end type integrator_type

   abstract interface
      !> Takes over an assembled state (t, q, v) and prepares the first step. Called again, it forgets the steps before, for what
      !> acts may have changed abruptly, but not the scales of the motion.
      subroutine start_interface(self, system, work, t, duration, q, v, error)
         import :: integrator_type, system_type, workspace_type, error_type, wp
         class(integrator_type), intent(inout) :: self
         type(system_type), intent(in) :: system
         type(workspace_type), intent(inout) :: work
         !> Time, and length of the whole analysis
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
         real(wp), contiguous, intent(out) :: q(:), v(:)
         real(wp), intent(out) :: w
      end subroutine interpolate_interface

      !> Saves or restores its memory.
      subroutine exchange_interface(self, snapshot, system)
         import :: integrator_type, snapshot_type, system_type
         class(integrator_type), intent(inout) :: self
         type(snapshot_type), intent(inout) :: snapshot
         !> Of the run
         type(system_type), intent(in) :: system
         ! Not saved: tolerance, initial_step, maximum_step, fixed_step, speeds_asked, ends_on_samples, steps_over, sees_inside
         ! Not saved: steps_to_start, order, spare
      end subroutine exchange_interface
   end interface

contains

   !> By a start.
   subroutine resume_by_start(self, system, work, duration, q, v, error)
      class(integrator_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> As in `start`
      real(wp), intent(in) :: duration, q(:), v(:)
      type(error_type), allocatable, intent(out) :: error
      call self%start(system, work, self%t, duration, q, v, error)
   end subroutine resume_by_start

   !> Of an integrator whose velocities cost next to nothing.
   subroutine interpolate_all(self, t, q, v, w)
      class(integrator_type), intent(inout) :: self
      real(wp), intent(in) :: t
      !> As in `interpolate`
      real(wp), contiguous, intent(inout) :: q(:), v(:)
      real(wp), intent(inout) :: w
      call self%interpolate(t, q, v, w)
   end subroutine interpolate_all

   !> Of an integrator that carries on all coordinates.
   subroutine complete_nothing(self, system, work, t, q, v)
      class(integrator_type), intent(in) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> The time of `interpolate`
      real(wp), intent(in) :: t
      !> Coordinates and velocities (nq)
      real(wp), contiguous, intent(inout) :: q(:), v(:)
   end subroutine complete_nothing

   !> Of an integrator without accelerations that are better than those of its states.
   subroutine interpolate_none(self, t, a, pace)
      class(integrator_type), intent(in) :: self
      real(wp), intent(in) :: t
      !> In the layout of the rates (nw)
      real(wp), contiguous, intent(inout) :: a(:)
      !> Vibrations that are faster are not followed [1/time]; 0: there are no accelerations
      real(wp), intent(out) :: pace
      pace = 0.0_wp
   end subroutine interpolate_none

   !> Saves or restores what all integrators have.
   subroutine exchange_common(self, snapshot, system)
      class(integrator_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      type(system_type), intent(in) :: system
      integer :: constraints
      constraints = system%nc
      call snapshot%exchange('constraints', constraints)
      if (constraints /= system%nc .and. .not. allocated(snapshot%missing)) snapshot%missing = 'constraints'
      call snapshot%exchange('t', self%t)
      call snapshot%exchange('t_before', self%t_before)
      call snapshot%exchange('work_at_start', self%work_at_start)
      call self%input%exchange(snapshot)
      call self%ringing%exchange(snapshot)
      call self%statistics%exchange(snapshot)
   end subroutine exchange_common

   !> Counts an accepted step.
   subroutine count_step(self, h, order, spare)
      class(integrator_type), intent(inout) :: self
      !> Its length [time] and order
      real(wp), intent(in) :: h
      integer, intent(in) :: order
      !> Whether its error would have allowed one of more than twice its length
      logical, intent(in) :: spare
      self%order = order
      self%spare = spare
      associate (statistics => self%statistics)
         statistics%steps = statistics%steps + 1
         statistics%smallest_step = min(statistics%smallest_step, h)
         statistics%largest_step = max(statistics%largest_step, h)
         statistics%highest_order = max(statistics%highest_order, order)
      end associate
   end subroutine count_step

   !> Length below which a step has shrunk to nothing: round-off of the time that is reached, whatever END is.
   pure real(wp) function least_step(self, stop)
      class(integrator_type), intent(in) :: self
      !> Time that the step may not pass
      real(wp), intent(in) :: stop
      !> Part of that time which stands for the start, where the time may be zero
      real(wp), parameter :: part = 1.0e-8_wp
      least_step = 4*spacing(max(abs(self%t), part*abs(stop)))
   end function least_step

   !> The step that divides the way to the next stop evenly and is not above the one wanted.
   pure real(wp) function even_step(way, wanted) result(h)
      real(wp), intent(in) :: way, wanted
      !> Part of the step that round-off may take
      real(wp), parameter :: slack = 1.0e-6_wp
      h = wanted
      if (way > 1.0e6_wp*wanted) return
      h = way/max(1, ceiling(way/wanted - slack))
      if (way > 1.5_wp*wanted .and. abs(h - wanted) <= slack*wanted) h = wanted
   end function even_step

   !> Steps so short that their work is taken as it is: across a jump of the power nothing makes it more exact.
   pure real(wp) function last_digits(self) result(h)
      class(integrator_type), intent(in) :: self
      h = 256*spacing(abs(self%t))
   end function last_digits

   !> Error of a step that has shrunk to nothing: which constraint, which body, when, what to try.
   subroutine step_too_small(self, system, work, body, error)
      class(integrator_type), intent(in) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> The body with the largest local error
      integer, intent(in) :: body
      type(error_type), allocatable, intent(out) :: error
      character(:), allocatable :: where_it_is, culprit_name
      integer :: culprit, i
      real(wp) :: residual
      logical, allocatable :: drives(:)
      where_it_is = ''
      if (size(system%constraints) > 0) then
         call worst_constraint(system, work, culprit, residual)
         if (residual > constraint_limit*system%constraints(culprit)%item%scale) where_it_is = '; '// &
            & system%constraints(culprit)%item%label//' cannot be kept (residual '//as_text(residual, 3)//')'
         ! Constraints stand in the order of the model: joints, then drivers
         drives = [(i > size(system%model%joints) .and. i <= size(system%model%joints) + size(system%model%drivers), &
            & i=1, size(system%constraints))]
         if (where_it_is /= '' .and. any(drives)) where_it_is = where_it_is//'; the scene is driven by '// &
            & constraint_names(system, drives)//', which its joints may not follow from there'
      end if
      culprit_name = "body '"//system%model%bodies(body)%name
      if (system%layout%carries(body)) culprit_name = "a state of control '"//system%model%controls( &
         & system%model%bodies(body)%control)%name
      call raise(error, 'the step has shrunk to nothing at t = '//as_text(self%t, 10)//where_it_is//'; '// &
         & culprit_name//"' has the largest local error. The motion may be diverging or at a singular"// &
         & ' position: try a smaller END, a looser TOLERANCE, or look at the history up to there')
   end subroutine step_too_small

end module limber_integrator_integrator
