!> Balance of hanging bodies at the start. Where the beams sag the bodies hang elsewhere. Behind the first deflections
!> (`relaxation`), which leave bodies where the joints take them. Floor: multibody. Source: doc/theory, eqs. (4.47), (6.4), (6.6),
!> (6.7), (6.15), (6.16).
module limber_multibody_hanging_loads
   use limber_base_kinds, only: wp
   use limber_multibody_equilibrium, only: equilibrium_type, new_equilibrium, find_equilibrium
   use limber_multibody_driven_motion, only: driven_motion_type, held_motion
   use limber_multibody_stability, only: judge
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: first_push, hang_bodies

contains

   !> Largest acceleration of a frame with held deflections, relative to its scale [1/time^2]; huge where it moves.
   real(wp) function first_push(system, work, held, t, q, v) result(push)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(driven_motion_type), intent(inout) :: held
      !> Time; coordinates and velocities (nq)
      real(wp), intent(in) :: t, q(:), v(:)
      real(wp) :: a(size(q)), rates(size(q))
      logical :: done
      push = huge(push)
      if (any(abs(v) > 0.0_wp)) return
      call held_motion(system, work, held, t, q, rates, a, done)
      if (done .and. .not. any(abs(rates) > 0.0_wp)) push = maxval(abs(held%a/held%scale))
   end function first_push

   !> Moves a scene that was in balance without deflections, and is not with them, into the equilibrium of all of it, eq. (4.47).
   subroutine hang_bodies(system, work, held, t, push, q, left)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> At the first deflections
      type(driven_motion_type), intent(inout) :: held
      real(wp), intent(in) :: t
      !> `first_push` without deflections
      real(wp), intent(in) :: push
      !> Coordinates of a scene at rest (nq)
      real(wp), intent(inout) :: q(:)
      !> Largest acceleration that is left of what deflections have caused, relative to its scale [1/time^2]
      real(wp), intent(out) :: left
      !> Part of the acceleration with deflections
      real(wp), parameter :: none = 0.1_wp
      type(equilibrium_type) :: balance
      real(wp) :: rest(size(q)), lambda(system%nc)
      real(wp), allocatable :: hung(:)
      logical :: done
      rest = 0.0_wp
      left = 0.0_wp
      if (push >= huge(push)) return
      left = first_push(system, work, held, t, q, rest)
      if (left >= huge(left)) left = 0.0_wp
      if (push > none*left) left = 0.0_wp
      if (.not. left > 0.0_wp) return
      call new_equilibrium(system, balance)
      allocate (hung, source=q)
      lambda = held%lambda
      call find_equilibrium(system, work, balance, t, hung, lambda, .true., done)
      if (.not. done) return
      call judge(system, work, balance, lambda)
      if (.not. balance%stable .or. balance%neutral) return
      q = hung
      left = 0.0_wp
   end subroutine hang_bodies

end module limber_multibody_hanging_loads
