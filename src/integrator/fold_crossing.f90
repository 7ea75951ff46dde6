!> Passage through positions where branches of the motion meet. There a combination of constraints loses its grip, regains it with
!> the other sign behind, and Newton's method fails with derivatives of one side for stages on the other. So when it has failed, it
!> is looked whether that happens within the step; then one step of Dormand and Prince's method, of order 5 and explicit on the
!> equations of index 1, leads from this side to the other, as far behind the position as it begins before it. Floor: integrator.
!> Source: Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, section II.5; doc/theory, eqs. (4.38)-(4.40).
module limber_integrator_fold_crossing
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_base_error, only: error_type
   use limber_multibody_plane_vectors, only: turn, cross
   use limber_multibody_equations_of_motion, only: linearise, accelerations, input_power, velocity_gaps, velocity_residual
   use limber_multibody_layout, only: advance
   use limber_multibody_multiplier_system, only: place_constraints
   use limber_multibody_projection, only: settle, project_velocity
   use limber_multibody_multiplier_solution, only: solve_gaps, recover_multipliers
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   !> Strength of a combination of constraints below which a fold is near
   real(wp), parameter, public :: weak = 1.0e-2_wp
   !> Error of the step across, in units of the tolerance, that is allowed: the nearer to the fold a step begins, the worse it gets
   real(wp), parameter, public :: across_allowed = 30.0_wp

   public :: crossing_type, new_crossing, find_weakest, find_fold, step_across, increments_between

   !> Coefficients of the method: stages, the fifth order result is the last stage; weights of the error estimate
   real(wp), parameter :: c(7) = [0.0_wp, 0.2_wp, 0.3_wp, 0.8_wp, 8.0_wp/9, 1.0_wp, 1.0_wp]
   real(wp), parameter :: a(6, 7) = reshape([ &
      & 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      & 0.2_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      & 3.0_wp/40, 9.0_wp/40, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      & 44.0_wp/45, -56.0_wp/15, 32.0_wp/9, 0.0_wp, 0.0_wp, 0.0_wp, &
      & 19372.0_wp/6561, -25360.0_wp/2187, 64448.0_wp/6561, -212.0_wp/729, 0.0_wp, 0.0_wp, &
      & 9017.0_wp/3168, -355.0_wp/33, 46732.0_wp/5247, 49.0_wp/176, -5103.0_wp/18656, 0.0_wp, &
      & 35.0_wp/384, 0.0_wp, 500.0_wp/1113, 125.0_wp/192, -2187.0_wp/6784, 11.0_wp/84], [6, 7])
   real(wp), parameter :: e(7) = [71.0_wp/57600, 0.0_wp, -71.0_wp/16695, 71.0_wp/1920, -17253.0_wp/339200, 22.0_wp/525, &
      & -1.0_wp/40]

   !> Scratch, allocated once
   type :: crossing_type
      !> State [q; v; work] at the start, or error estimates, and state of a stage (2 nq + 1), derivatives at the stages (2 nq + 1,
      !> 7)
      real(wp), allocatable :: start(:), y(:), slope(:, :)
      !> A change (nq), the combination of constraints that is weakest (nc), increments (nw), and a position (nq)
      real(wp), allocatable :: change(:), weakest(:), x(:), place(:)
      !> Steps across that were refused for the error of their work since the last one that was taken
      integer :: refused = 0
      !> Length that each row counts by: 1 of lengths, the inverse of the scene's length of angles (nc)
      real(wp), allocatable :: unit(:)
   contains
      procedure :: exchange => exchange_crossing
   end type crossing_type

contains

   !> Room.
   subroutine new_crossing(system, self)
      type(system_type), intent(in) :: system
      type(crossing_type), intent(inout) :: self
      integer :: i
      associate (nq => system%layout%nq)
         allocate (self%start(2*nq + 1), self%y(2*nq + 1), self%slope(2*nq + 1, 7), self%change(nq), self%place(nq))
         allocate (self%weakest(system%nc), self%x(system%layout%nw), self%unit(system%nc))
      end associate
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            self%unit(item%first:item%first + item%rows - 1) = item%scale/system%model%length
         end associate
      end do
   end subroutine new_crossing

   !> The combination of constraints that binds least, by inverse iteration, into `weakest`; `linearise` comes first. The motion
   !> that it hardly binds is left in `change`, alpha in the first place of u. Angles count by the scene's length, so that the units
   !> of the deck do not matter.
   subroutine find_weakest(self, system, work, strength)
      type(crossing_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> How much it binds, relative to the inverse of the mean mass; below `weak` a fold is near
      real(wp), intent(out) :: strength
      integer, parameter :: rounds = 3
      integer :: round, i
      do i = 1, size(self%weakest)
         self%weakest(i) = merge(1.0_wp + 0.5_wp*modulo(0.618034_wp*i, 1.0_wp), 0.0_wp, system%tree%row(i) > 0)
      end do
      do round = 1, rounds + 1
         if (round > 1) self%weakest = self%weakest/max(norm2(self%weakest), tiny(1.0_wp))
         self%weakest = self%unit*self%weakest
         call solve_gaps(system, work, self%weakest, self%change)
         if (round > rounds) exit
         do i = 1, size(self%weakest)
            if (system%tree%row(i) > 0) self%weakest(i) = self%unit(i)*work%solution(system%tree%row(i))
         end do
      end do
      strength = 0.0_wp
      do i = 1, size(self%weakest)
         if (system%tree%row(i) > 0) strength = strength + (self%unit(i)*work%solution(system%tree%row(i)))**2
      end do
      strength = sqrt(strength)
      if (.not. (strength > 0.0_wp .and. strength <= huge(strength))) then
         ! Nothing with mass is bound: there is nothing to lose
         strength = huge(strength)
         return
      end if
      ! The joints of the tree take part with what they bear then
      do i = 1, size(work%bodies)
         work%bodies(i)%condensed = 0.0_wp
      end do
      call recover_multipliers(system, work)
      self%weakest = work%lambda/strength
      strength = sum(system%model%bodies%reduced%mass)/size(system%layout%q)/strength
   end subroutine find_weakest

   !> Looks for a fold ahead: the combination of constraints that binds least, found by inverse iteration at the present state, is
   !> followed along the motion, eq. (4.38).
   subroutine find_fold(self, system, work, t, h, q, w, acceleration, away)
      type(crossing_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Time, and the step that has failed
      real(wp), intent(in) :: t, h
      !> Coordinates (nq), rates and accelerations (nw)
      real(wp), intent(in) :: q(:), w(:), acceleration(:)
      !> Time to the fold, or half a step if the state is at one; negative: there is none within about two steps
      real(wp), intent(out) :: away
      integer, parameter :: looks = 4
      type(error_type), allocatable :: error
      real(wp) :: grip, now, before, s, strength
      integer :: i
      away = -1.0_wp
      ! What is redundant everywhere has no grip anywhere; and softened constraints let Newton's method pass
      if (maxval(system%tree%row) == 0 .or. system%redundant) return
      call linearise(system, work, t, q, error)
      if (allocated(error)) return
      call find_weakest(self, system, work, strength)
      if (strength >= huge(strength)) return
      now = grip_after(0.0_wp)
      if (.not. abs(now) > 0.0_wp) return
      before = 1.0_wp
      do i = 1, looks
         s = h*i/looks
         grip = grip_after(s)/now
         if (grip <= 0.0_wp) then
            away = s - h/looks*(-grip)/(before - grip)
            return
         end if
         before = grip
      end do
      if (grip < 0.5_wp) then
         ! It has lost more than half of its strength: just behind the step
         away = h/(1 - grip)
      else if (grip < 0.9_wp .and. strength < weak) then
         ! It is weak and loses strength
         away = min(4.0_wp, 1/(1 - grip))*h
      else if (grip > 1.2_wp .and. strength < weak) then
         ! It is weak and gains strength: the state is at a fold
         away = 0.5_wp*h
      end if

   contains

      !> What the combination does at a later place to the motion that it feels now.
      real(wp) function grip_after(s)
         real(wp), intent(in) :: s
         real(wp) :: largest
         integer :: i, first
         self%x = s*(w + 0.5_wp*s*acceleration)
         call advance(system%layout, q, self%x, self%place)
         call place_constraints(system, work, t + s, self%place)
         self%place = 0.0_wp
         largest = velocity_residual(system, work, self%place)
         grip_after = dot_product(self%weakest, work%gamma)
         do i = 1, size(system%layout%q)
            first = system%layout%q(i)
            self%place(first:first + 1) = self%change(first:first + 1)
            if (.not. system%layout%framed(i)) cycle
            self%place(first + 2:first + 3) = self%change(first + 2)*turn(work%kinematics%frames(i)%u)
            self%place(first + 4:first + 3 + system%layout%n(i)) = self%change(first + 4:first + 3 + system%layout%n(i))
         end do
         largest = velocity_residual(system, work, self%place)
         grip_after = grip_after - dot_product(self%weakest, work%gamma)
      end function grip_after

   end subroutine find_fold

   !> One step of length h, eq. (4.39): the new state, settled on the constraints, is left in `y`, the multiplier system linearised
   !> near it, and the error of the work in the last place of `start`.
   subroutine step_across(self, system, work, t, h, q, v, work_done, scale, err, residual)
      type(crossing_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Time, length
      real(wp), intent(in) :: t, h
      !> Coordinates and velocities (nq), work put in
      real(wp), intent(in) :: q(:), v(:), work_done
      !> Scales of [q; v] (2 nq)
      real(wp), intent(in) :: scale(:)
      !> Local error along the motion in units of the scales; huge if there is no such step
      real(wp), intent(out) :: err
      !> Residual of the position constraints reached
      real(wp), intent(out) :: residual
      type(error_type), allocatable :: error
      real(wp) :: raw
      integer :: nq, i, j
      nq = size(q)
      err = huge(err)
      residual = 0.0_wp
      self%start(:nq) = q
      self%start(nq + 1:2*nq) = v
      self%start(2*nq + 1) = work_done
      do i = 1, 7
         self%y = self%start
         do j = 1, i - 1
            self%y = self%y + h*a(j, i)*self%slope(:, j)
         end do
         call linearise(system, work, t + c(i)*h, self%y(:nq), error)
         if (allocated(error)) return
         self%slope(:nq, i) = self%y(nq + 1:2*nq)
         self%place = self%y(nq + 1:2*nq)
         call accelerations(system, work, self%y(:nq), self%place, self%change)
         self%slope(nq + 1:2*nq, i) = self%change
         self%slope(2*nq + 1, i) = 0.0_wp
         if (system%powered) self%slope(2*nq + 1, i) = power_across(system, work, self%y(:nq), self%place)
      end do
      ! The error estimate takes the place of the start, the state before it is settled that of the first derivatives
      do i = 1, 2*nq + 1
         self%start(i) = h*dot_product(e, self%slope(i, :))
      end do
      raw = norm2(self%start(:2*nq)/scale)
      if (.not. raw < 1.0_wp) return
      self%slope(:, 1) = self%y
      call settle(system, work, t + h, self%y(:nq), self%y(nq + 1:2*nq), self%change, .true., residual, error)
      if (allocated(error)) return
      ! A projection that is more than a correction may have found another branch
      if (any(abs(self%y(:2*nq) - self%slope(:2*nq, 1)) > max(100*raw, 1.0e-10_wp)*scale)) return
      err = sqrt(error_along(0)**2 + error_along(nq)**2)
      if (.not. err <= huge(err)) err = huge(err)

   contains

      !> Size of what the error of coordinates (from 0) or velocities (from nq) is along the motion that the constraints allow: the
      !> rest has been taken out when the state was settled.
      real(wp) function error_along(from)
         integer, intent(in) :: from
         self%place = self%y(nq + 1:2*nq) + self%start(from + 1:from + nq)
         call project_velocity(system, work, self%place, self%change)
         error_along = norm2((self%place - self%y(nq + 1:2*nq))/scale(from + 1:from + nq))
      end function error_along

   end subroutine step_across

   !> Power put in at a stage, eq. (4.40): beside a fold the multipliers are large, and what the speeds of a stage leave of the
   !> constraints is no power of theirs. The accelerations come first.
   real(wp) function power_across(system, work, q, v) result(power)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Coordinates and velocities (nq)
      real(wp), contiguous, intent(in) :: q(:), v(:)
      power = input_power(system, work, q, v)
      call velocity_gaps(system, work, v)
      power = power + dot_product(work%lambda, work%gamma)
   end function power_across

   !> Increments of the coordinates in the layout of the rates from one position to another near it.
   pure subroutine increments_between(system, from, to, x)
      type(system_type), intent(in) :: system
      !> Coordinates (nq)
      real(wp), intent(in) :: from(:), to(:)
      !> Increments (nw)
      real(wp), intent(inout) :: x(:)
      integer :: i, k, m, n
      do i = 1, size(system%layout%q)
         k = system%layout%q(i)
         m = system%layout%w(i)
         n = system%layout%n(i)
         x(m:m + 1) = to(k:k + 1) - from(k:k + 1)
         if (.not. system%layout%framed(i)) cycle
         x(m + 2) = atan2(cross(from(k + 2:k + 3), to(k + 2:k + 3)), dot_product(from(k + 2:k + 3), to(k + 2:k + 3)))
         x(m + 3:m + 2 + n) = to(k + 4:k + 3 + n) - from(k + 4:k + 3 + n)
      end do
   end subroutine increments_between

   !> Saves or restores its memory.
   subroutine exchange_crossing(self, snapshot)
      class(crossing_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%keep('start', self%start)
      call snapshot%keep('y', self%y)
      call snapshot%keep('slope', self%slope)
      call snapshot%keep('change', self%change)
      call snapshot%keep('weakest', self%weakest)
      call snapshot%keep('x', self%x)
      call snapshot%keep('place', self%place)
      call snapshot%exchange('across_refused', self%refused)
      ! Not saved: unit
   end subroutine exchange_crossing

end module limber_integrator_fold_crossing
