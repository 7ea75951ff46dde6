!> Rates of deflections at the start of a motion. Those by which the balance goes on with the motion, so that the start sets off no
!> vibration. Floor: multibody. Source: doc/theory, eq. (4.48).
module limber_multibody_start_rates
   use limber_base_kinds, only: wp
   use limber_multibody_driven_motion, only: driven_motion_type, factor_held, balance_deflections
   use limber_multibody_layout, only: advance, rates_of, velocities_of
   use limber_multibody_motion_residual, only: motion_residual
   use limber_multibody_first_deflections, only: balance_start, start_motion
   use limber_multibody_system, only: system_type, workspace_type
   use limber_multibody_tangent, only: solve_refined
   implicit none
   private
   public :: follow_balance

contains

   !> Finds the rates of balanced deflections from the balance at two instants right behind the start, and the velocities of the
   !> frames that go with them. A scene at rest stays as it is.
   subroutine follow_balance(system, work, held, t, driven, q, v, share, done)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(driven_motion_type), intent(inout) :: held
      real(wp), intent(in) :: t
      !> Whether drivers and joints hold all frames, so that deflections are those of `balance_deflections`
      logical, intent(in) :: driven
      !> Coordinates in balance; velocities, the rates of deflection nought before (nq)
      real(wp), intent(in) :: q(:)
      real(wp), intent(inout) :: v(:)
      !> Vibrations that these rates are, of the deflection, the largest of bodies whose frames move, eq. (4.48)
      real(wp), intent(out) :: share
      !> False if there is no such balance: the velocities stay as they were
      logical, intent(out) :: done
      !> Way of the frames to the first instant, relative; least speed that is a motion, of that of the accelerations
      real(wp), parameter :: way = 1.0e-4_wp, moves = 1.0e-9_wp
      real(wp), allocatable :: w(:), a(:), place(:), speed(:), rate(:), unused(:)
      real(wp) :: step, quick(2), s
      logical :: singular
      integer :: k
      done = .true.
      share = 0.0_wp
      allocate (w(system%layout%nw), a(system%layout%nw), place(size(q)), rate(size(held%deflections)))
      allocate (speed, source=v)
      allocate (unused, source=v)
      call start_motion(system, work, held, t, q, speed, singular)
      if (singular) return
      w = held%w
      a = held%a
      quick = [maxval(abs(w/held%scale)), sqrt(maxval(abs(a/held%scale)))]
      if (.not. quick(1) > moves*quick(2)) return
      step = way/maxval(quick)
      rate = 0.0_wp
      do k = 1, 2
         s = k*step
         call advance(system%layout, q, s*w + 0.5_wp*s**2*a, place)
         call velocities_of(system%layout, place, w + s*a, speed)
         if (driven) then
            call balance_deflections(system, work, held, t + s, place, speed, unused, done)
         else
            call balance_start(system, work, held, t + s, place, speed, done)
         end if
         if (.not. done) return
         rate = rate + merge(4, -1, k == 1)*deflections_of(system, place - q)/(2*step)
      end do
      share = vibrating_share(system, held, w, q, rate)
      call move_along(system, work, held, t, q, rate, v, done)
   end subroutine follow_balance

   !> Square root of the kinetic energy of the rates over the elastic one, the largest of bodies whose frames move.
   pure real(wp) function vibrating_share(system, held, w, q, rate) result(share)
      type(system_type), intent(in) :: system
      type(driven_motion_type), intent(in) :: held
      !> Rates (nw), coordinates (nq), rates of deflection (deflections)
      real(wp), intent(in) :: w(:), q(:), rate(:)
      real(wp), parameter :: moves = 1.0e-6_wp
      real(wp) :: fastest, elastic
      integer :: i, n, first
      share = 0.0_wp
      fastest = maxval(abs(w/held%scale))
      first = 0
      do i = 1, size(system%layout%q)
         n = system%layout%n(i)
         associate (own => rate(first + 1:first + n), from => system%layout%w(i), at => system%layout%q(i) + 4)
            first = first + n
            if (n == 0) cycle
            if (maxval(abs(w(from:from + 2)/held%scale(from:from + 2))) < moves*fastest) cycle
            elastic = sum(system%model%bodies(i)%reduced%omega2*q(at:at + n - 1)**2)
            if (elastic > 0.0_wp) share = max(share, sqrt(sum(own**2)/elastic))
         end associate
      end do
   end function vibrating_share

   !> Deflections among coordinates (deflections).
   pure function deflections_of(system, q) result(eta)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: q(:)
      real(wp) :: eta(sum(system%layout%n))
      integer :: i, n, first
      first = 0
      do i = 1, size(system%layout%q)
         n = system%layout%n(i)
         eta(first + 1:first + n) = q(system%layout%q(i) + 4:system%layout%q(i) + 3 + n)
         first = first + n
      end do
   end function deflections_of

   !> Velocities with given rates of deflection: the least change of those of the frames that the joints allow, in their masses.
   subroutine move_along(system, work, held, t, q, rate, v, done)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(driven_motion_type), intent(inout) :: held
      real(wp), intent(in) :: t, q(:), rate(:)
      real(wp), intent(inout) :: v(:)
      logical, intent(out) :: done
      real(wp), parameter :: satisfied = 1.0e-9_wp
      real(wp) :: moved(size(v)), w(system%layout%nw)
      logical :: singular
      integer :: round
      call rates_of(system%layout, q, v, w)
      w(held%deflections) = rate
      call velocities_of(system%layout, q, w, moved)
      call factor_held(system, work, held, t, q, moved, singular)
      done = .not. singular
      if (singular) return
      do round = 1, 2
         held%solution(:system%layout%nw) = 0.0_wp
         held%solution(system%layout%nw + 1:) = -held%rates
         call solve_refined(held%tangent, system%layout%nw, held%solution, held%correction)
         held%solution(held%deflections) = 0.0_wp
         w = w + held%solution(:system%layout%nw)
         call velocities_of(system%layout, q, w, moved)
         call motion_residual(system, work, t, q, moved, held%a, held%lambda, held%motion, held%rates)
      end do
      done = .not. any(abs(held%rates) > satisfied*maxval(abs(moved)))
      if (done) v = moved
   end subroutine move_along

end module limber_multibody_start_rates
