!> Search for the instant in a step at which a contact that rests would begin to pull: the first zero of the least force of all that
!> are closed, along the dense output. Floor: analysis. Source: doc/theory, eq. (5.91).
module limber_analysis_contact_release
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_integrator_integrator, only: integrator_type
   use limber_multibody_contact_impulses, only: contact_push
   use limber_multibody_equations_of_motion, only: accelerations
   use limber_multibody_projection, only: settle
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: find_release, find_least_push

contains

   !> The first time at which a closed contact pulls, and which.
   subroutine find_release(system, work, integrator, closed, last, t, contact, error)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      class(integrator_type), intent(inout) :: integrator
      !> (contacts)
      logical, intent(in) :: closed(:)
      !> Time up to which the last step counts
      real(wp), intent(in) :: last
      !> Huge, and 0: none pulls
      real(wp), intent(out) :: t
      integer, intent(out) :: contact
      type(error_type), allocatable, intent(out) :: error
      !> Parts of the step at which forces are looked at
      integer, parameter :: parts = 4
      real(wp) :: times(0:parts), least(0:parts), lowest
      integer :: which(0:parts), i
      t = huge(t)
      contact = 0
      do i = 0, parts
         times(i) = integrator%t_before + (last - integrator%t_before)*i/parts
         if (i == parts) times(i) = last
         least(i) = push_at(times(i), which(i))
         if (allocated(error)) return
         if (least(i) < 0.0_wp) exit
      end do
      if (i > parts) then
         ! One that comes near zero between two looks
         i = minloc(least(1:parts - 1), dim=1)
         lowest = lowest_of(times(i - 1:i + 1), least(i - 1:i + 1))
         if (.not. lowest > times(i - 1) .or. .not. lowest < times(i + 1)) return
         least(parts) = push_at(lowest, which(parts))
         if (allocated(error) .or. least(parts) >= 0.0_wp) return
         i = merge(i, i - 1, lowest > times(i))
         call polish(times(i), lowest, least(i), least(parts), which(parts))
      else if (i == 0) then
         t = times(0)
         contact = which(0)
      else
         call polish(times(i - 1), times(i), least(i - 1), least(i), which(i))
      end if

   contains

      !> Least force of the closed contacts at a time of the dense output, and whose it is.
      real(wp) function push_at(at, whose) result(push)
         real(wp), intent(in) :: at
         integer, intent(out) :: whose
         real(wp) :: q(system%layout%nq), v(system%layout%nq), w
         call integrator%interpolate(at, q, v, w)
         call integrator%complete(system, work, at, q, v)
         call find_least_push(system, work, at, q, v, closed, push, whose, error)
      end function push_at

      !> The zero between a time at which all push and one at which the least force pulls, by the method of Illinois and halving.
      subroutine polish(from, to, push_from, push_to, whose)
         real(wp), intent(in) :: from, to, push_from, push_to
         integer, intent(in) :: whose
         integer, parameter :: rounds = 100
         real(wp) :: before, behind, f_before, f_behind, at, f
         integer :: round, kept, whose_there
         before = from
         behind = to
         f_before = push_from
         f_behind = push_to
         contact = whose
         kept = 0
         do round = 1, rounds
            if (behind - before <= 2*spacing(behind)) exit
            at = before + 0.5_wp*(behind - before)
            if (modulo(round, 4) /= 0) at = min(max(before + f_before*(behind - before)/(f_before - f_behind), &
               & nearest(before, 1.0_wp)), nearest(behind, -1.0_wp))
            f = push_at(at, whose_there)
            if (allocated(error)) return
            if (f < 0.0_wp) then
               behind = at
               f_behind = f
               contact = whose_there
               if (kept == 1) f_before = 0.5_wp*f_before
               kept = 1
            else
               before = at
               f_before = f
               if (kept == -1) f_behind = 0.5_wp*f_behind
               kept = -1
            end if
         end do
         t = behind
      end subroutine polish

   end subroutine find_release

   !> Least force of the closed contacts at a state, and whose it is.
   subroutine find_least_push(system, work, t, q, v, closed, push, contact, error)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      !> Coordinates and velocities; out: those on the constraints (nq)
      real(wp), intent(inout) :: q(:), v(:)
      !> (contacts)
      logical, intent(in) :: closed(:)
      !> Huge, and 0: none is closed
      real(wp), intent(out) :: push
      integer, intent(out) :: contact
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: a(size(q)), residual
      integer :: k
      push = huge(push)
      contact = 0
      call settle(system, work, t, q, v, a, .true., residual, error)
      if (allocated(error)) return
      call accelerations(system, work, q, v, a)
      do k = 1, size(closed)
         if (.not. closed(k)) cycle
         if (contact_push(system, work, k) >= push) cycle
         push = contact_push(system, work, k)
         contact = k
      end do
   end subroutine find_least_push

   !> Where the parabola through three points is lowest; huge if it has no lowest point.
   pure real(wp) function lowest_of(x, y) result(lowest)
      real(wp), intent(in) :: x(3), y(3)
      real(wp) :: first, second, bend
      lowest = huge(lowest)
      first = (y(2) - y(1))/(x(2) - x(1))
      second = (y(3) - y(2))/(x(3) - x(2))
      bend = (second - first)/(x(3) - x(1))
      if (bend > 0.0_wp) lowest = 0.5_wp*(x(1) + x(2)) - 0.5_wp*first/bend
   end function lowest_of

end module limber_analysis_contact_release
