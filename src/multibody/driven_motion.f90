!> Motion of a scene that its drivers determine wholly. Position, velocities, accelerations and multipliers of a scene that its
!> drivers move wholly. Deflections are held, or in equilibrium with the loads and the inertia of the motion. Floor: multibody.
!> Source: doc/theory, eqs. (6.19)-(6.21); Nikravesh 1988, chapter 3.
module limber_multibody_driven_motion
   use limber_base_kinds, only: wp
   use limber_multibody_plane_vectors, only: turn
   use limber_multibody_equations_of_motion, only: position_residual, acceleration_gaps
   use limber_multibody_free_motions, only: rate_scales
   use limber_multibody_layout, only: advance, velocities_of
   use limber_multibody_motion_residual, only: motion_residual, linearise_motion
   use limber_multibody_system, only: system_type, workspace_type
   use limber_multibody_tangent, only: tangent_type, new_tangent, combine, combine_stiffness, factor_masses, solve_refined
   implicit none
   private
   public :: driven_motion_type, new_held, factor_held, correct_motion, follows, held_position, held_motion, balance_deflections, &
      & balance_passed, balance_inertia, free_accelerations, rest_multipliers

   !> Stiffness that holds a coordinate, relative to its mass of one
   real(wp), parameter :: rigid = 1.0e30_wp

   !> Matrix and scratch
   type :: driven_motion_type
      type(tangent_type) :: tangent
      !> Places of the diagonal of the deflections in the matrix, and the deflections among the rates (their number)
      integer, allocatable :: diagonal(:), deflections(:)
      !> Scales of the rates, residuals and unknowns (nw), (nc), (nw + nc); places moved (nq)
      real(wp), allocatable :: scale(:), motion(:), rates(:), solution(:), correction(:), moved(:), place(:)
      !> Rates, accelerations in the layout of the rates (nw), multipliers (nc)
      real(wp), allocatable :: w(:), a(:), lambda(:)
   end type driven_motion_type

contains

   !> Room and pattern.
   subroutine new_held(system, held)
      type(system_type), intent(in) :: system
      type(driven_motion_type), intent(inout) :: held
      integer :: i, k, count
      associate (nw => system%layout%nw, nc => system%nc)
         call new_tangent(system, held%tangent)
         allocate (held%scale(nw), held%motion(nw), held%rates(nc), held%moved(system%layout%nq), &
            & held%place(system%layout%nq))
         allocate (held%solution(nw + nc), held%correction(nw + nc))
         allocate (held%w(nw), held%a(nw), held%lambda(nc))
         allocate (held%deflections(sum(system%layout%n)), held%diagonal(sum(system%layout%n)))
      end associate
      held%scale = rate_scales(system)
      held%lambda = 0.0_wp
      held%a = 0.0_wp
      held%w = 0.0_wp
      count = 0
      do i = 1, size(system%layout%w)
         do k = 1, system%layout%n(i)
            count = count + 1
            held%deflections(count) = system%layout%w(i) + system%layout%rates(i) + k - 1
            held%diagonal(count) = held%tangent%matrix%place(held%deflections(count), held%deflections(count))
         end do
      end do
   end subroutine new_held

   !> Derivatives at a place, and the factors of the mass with the constraints, deflections held; `motion` is there too.
   subroutine factor_held(system, work, held, t, q, v, singular)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(driven_motion_type), intent(inout) :: held
      !> Time; coordinates, velocities (nq)
      real(wp), intent(in) :: t, q(:), v(:)
      logical, intent(out) :: singular
      held%a = 0.0_wp
      held%lambda = 0.0_wp
      call motion_residual(system, work, t, q, v, held%a, held%lambda, held%motion, held%rates)
      call linearise_motion(system, work, held%tangent, q, v, held%a, held%lambda)
      held%tangent%softness = 1.0_wp
      call combine(held%tangent, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp)
      held%tangent%matrix%values(held%diagonal) = rigid
      call held%tangent%matrix%factor(singular)
   end subroutine factor_held

   !> Moves the frames onto the constraints, deflections held, by Newton's method.
   subroutine held_position(system, work, held, t, q, change, done)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(driven_motion_type), intent(inout) :: held
      real(wp), intent(in) :: t
      !> Coordinates (nq)
      real(wp), intent(inout) :: q(:)
      !> Largest change of a coordinate relative to its scale
      real(wp), intent(out) :: change
      !> Whether the constraints are satisfied
      logical, intent(out) :: done
      integer, parameter :: most = 12
      real(wp), parameter :: satisfied = 1.0e-13_wp, limit = 1.0e-11_wp
      real(wp) :: residual, size_of
      integer :: round
      logical :: singular
      change = 0.0_wp
      residual = huge(residual)
      held%moved = 0.0_wp
      do round = 1, most
         call factor_held(system, work, held, t, q, held%moved, singular)
         residual = position_residual(system, work)
         if (residual <= satisfied .or. singular) exit
         held%solution(:system%layout%nw) = 0.0_wp
         held%solution(system%layout%nw + 1:) = -work%phi
         call solve_refined(held%tangent, system%layout%nw, held%solution, held%correction)
         held%solution(held%deflections) = 0.0_wp
         size_of = maxval(abs(held%solution(:system%layout%nw)/held%scale))
         if (.not. size_of < 1.0_wp) exit
         change = max(change, size_of)
         call advance(system%layout, q, held%solution(:system%layout%nw), held%moved)
         q = held%moved
         held%moved = 0.0_wp
      end do
      done = residual <= limit
   end subroutine held_position

   !> Moves an interpolated place into balance with interpolated accelerations, as far as vibrations are faster than a pace, and
   !> onto the
   !> constraints, eq. (5.71): what a dense output errs in a stiff coordinate makes a force that is not there.
   subroutine balance_passed(system, work, held, t, q, v, a, pace, moved)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(driven_motion_type), intent(inout) :: held
      !> Time; velocities (nq); accelerations in the layout of the rates (nw); pace [1/time]
      real(wp), intent(in) :: t, v(:), a(:), pace
      !> Coordinates (nq)
      real(wp), intent(inout) :: q(:)
      !> Largest change of a coordinate relative to its scale; huge if there is no balance
      real(wp), intent(out) :: moved
      integer, parameter :: rounds = 2
      real(wp) :: residual
      logical :: singular
      integer :: round
      held%lambda = 0.0_wp
      held%moved = q
      moved = 0.0_wp
      do round = 1, rounds
         call motion_residual(system, work, t, held%moved, v, a, held%lambda, held%motion, held%rates)
         residual = position_residual(system, work)
         if (round == 1) then
            call linearise_motion(system, work, held%tangent, held%moved, v, a, held%lambda)
            held%tangent%softness = 1.0_wp/pace**2
            call combine(held%tangent, pace**2, pace, 1.0_wp, 0.0_wp)
            call held%tangent%matrix%factor(singular)
            if (singular) moved = huge(moved)
            if (singular) return
         end if
         held%solution(:system%layout%nw) = -held%motion
         held%solution(system%layout%nw + 1:) = -work%phi
         call solve_refined(held%tangent, system%layout%nw, held%solution, held%correction)
         held%lambda = held%lambda + held%solution(system%layout%nw + 1:)
         moved = max(moved, maxval(abs(held%solution(:system%layout%nw)/held%scale)))
         if (.not. moved <= huge(moved)) return
         held%place = held%moved
         call advance(system%layout, held%place, held%solution(:system%layout%nw), held%moved)
      end do
      q = held%moved
   end subroutine balance_passed

   !> Velocities, accelerations and multipliers at a position, deflections held; kinematics and multipliers of the workspace are
   !> those of this state.
   subroutine held_motion(system, work, held, t, q, v, a, done)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(driven_motion_type), intent(inout) :: held
      real(wp), intent(in) :: t, q(:)
      !> Velocities and accelerations (nq)
      real(wp), intent(inout) :: v(:), a(:)
      !> False at a singular position
      logical, intent(out) :: done
      logical :: singular
      v = 0.0_wp
      call factor_held(system, work, held, t, q, v, singular)
      done = .not. singular
      if (singular) return
      held%w = 0.0_wp
      call correct_motion(system, work, held, t, q, v)
      work%lambda = held%lambda
      done = follows(held, v) .and. all(abs(held%a) <= huge(1.0_wp)) .and. all(abs(held%lambda) <= huge(1.0_wp))
      call accelerations_of(system, work, held%a, a)
   end subroutine held_motion

   !> Brings the rates `w` onto the velocity equations, deflections held, with the velocities, and finds the accelerations and
   !> multipliers that go with them; behind `factor_held` at the same state.
   subroutine correct_motion(system, work, held, t, q, v)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(driven_motion_type), intent(inout) :: held
      real(wp), intent(in) :: t, q(:)
      !> Velocities (nq)
      real(wp), intent(inout) :: v(:)
      associate (nw => system%layout%nw, solution => held%solution)
         solution(:nw) = 0.0_wp
         solution(nw + 1:) = -held%rates
         call solve_refined(held%tangent, nw, held%solution, held%correction)
         held%w = held%w + solution(:nw)
         held%w(held%deflections) = 0.0_wp
         call velocities_of(system%layout, q, held%w, v)
         call motion_residual(system, work, t, q, v, held%a, held%lambda, held%motion, held%rates)
         call acceleration_gaps(system, work)
         solution(:nw) = -held%motion
         solution(held%deflections) = 0.0_wp
         solution(nw + 1:) = work%gamma
         call solve_refined(held%tangent, nw, held%solution, held%correction)
         held%a = solution(:nw)
         held%a(held%deflections) = 0.0_wp
         held%lambda = solution(nw + 1:)
      end associate
   end subroutine correct_motion

   !> Whether the velocities of `correct_motion` satisfy the joints: not where these bend bodies as the motion goes on.
   pure logical function follows(held, v)
      type(driven_motion_type), intent(in) :: held
      !> (nq)
      real(wp), intent(in) :: v(:)
      real(wp), parameter :: off = 1.0e-6_wp
      follows = .not. any(abs(held%rates) > off*maxval(abs(v)))
   end function follows

   !> Second derivatives of the coordinates from those of the rates: u'' = alpha J u - omega^2 u.
   subroutine accelerations_of(system, work, rates, a)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      !> (nw); kinematics are moved
      real(wp), intent(in) :: rates(:)
      !> (nq)
      real(wp), intent(inout) :: a(:)
      integer :: i, from, to
      do i = 1, size(system%layout%q)
         to = system%layout%q(i)
         from = system%layout%w(i)
         a(to:to + 1) = rates(from:from + 1)
         if (.not. system%layout%framed(i)) cycle
         associate (frame => work%kinematics%frames(i))
            a(to + 2:to + 3) = rates(from + 2)*turn(frame%u) - frame%omega**2*frame%u
         end associate
         a(to + 4:to + 3 + system%layout%n(i)) = rates(from + 3:from + 2 + system%layout%n(i))
      end do
   end subroutine accelerations_of

   !> Brings deflections, frames and multipliers into the equilibrium of the moving scene: velocities and accelerations are those
   !> of held deflections, eq. (6.21). On return they, and the multipliers, belong to the state.
   subroutine balance_deflections(system, work, held, t, q, v, a, done)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(driven_motion_type), intent(inout) :: held
      real(wp), intent(in) :: t
      !> Coordinates, velocities, accelerations (nq)
      real(wp), intent(inout) :: q(:), v(:), a(:)
      !> False if the motion is too fast for its deflections to follow, or at a singular position
      logical, intent(out) :: done
      integer, parameter :: most = 100
      real(wp), parameter :: small = 1.0e-12_wp, stalled = 1.0e-9_wp, limit = 0.3_wp
      real(wp) :: size_of, last
      integer :: round
      last = huge(last)
      do round = 1, most
         call held_motion(system, work, held, t, q, v, a, done)
         if (.not. done) return
         call step_to_balance(system, work, held, t, q, v, held%lambda, size_of, done)
         if (.not. done) return
         associate (nw => system%layout%nw, solution => held%solution)
            work%lambda = held%lambda + solution(nw + 1:)
            done = size_of <= small .or. (size_of <= stalled .and. size_of >= 0.5_wp*last)
            last = size_of
            if (.not. size_of <= huge(size_of)) return
            if (size_of > limit) solution(:nw) = solution(:nw)*limit/size_of
            call advance(system%layout, q, solution(:nw), held%moved)
            q = held%moved
         end associate
         if (done) return
      end do
   end subroutine balance_deflections

   !> Newton's step to the balance of all forces with accelerations held%a into `solution`: increments, and changes of the
   !> multipliers.
   subroutine step_to_balance(system, work, held, t, q, v, lambda, size_of, done)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(driven_motion_type), intent(inout) :: held
      !> Time; coordinates, velocities (nq); multipliers (nc)
      real(wp), intent(in) :: t, q(:), v(:), lambda(:)
      !> Largest increment relative to its scale
      real(wp), intent(out) :: size_of
      !> False if the matrix is singular
      logical, intent(out) :: done
      logical :: singular
      call motion_residual(system, work, t, q, v, held%a, lambda, held%motion, held%rates)
      size_of = position_residual(system, work)
      call linearise_motion(system, work, held%tangent, q, v, held%a, lambda)
      call combine_stiffness(held%tangent, 0.0_wp)
      call held%tangent%matrix%factor(singular)
      done = .not. singular
      if (singular) return
      held%solution(:system%layout%nw) = -held%motion
      held%solution(system%layout%nw + 1:) = -work%phi
      call held%tangent%matrix%solve(held%solution)
      size_of = maxval(abs(held%solution(:system%layout%nw)/held%scale))
   end subroutine step_to_balance

   !> Brings deflections, frames and multipliers, near a balance already, into that with given velocities and accelerations, those
   !> of the deflections too: a round of eq. (6.21), with the residual of eq. (6.22).
   subroutine balance_inertia(system, work, held, t, w, q, v, a, lambda, done)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(driven_motion_type), intent(inout) :: held
      real(wp), intent(in) :: t
      !> Rates (nw), their derivatives in held%a
      real(wp), intent(in) :: w(:)
      !> Coordinates; velocities and accelerations of those before (nq)
      real(wp), intent(inout) :: q(:), v(:), a(:)
      !> Multipliers (nc)
      real(wp), intent(inout) :: lambda(:)
      logical, intent(out) :: done
      real(wp) :: size_of
      call velocities_of(system%layout, q, w, v)
      call step_to_balance(system, work, held, t, q, v, lambda, size_of, done)
      if (.not. done) return
      call accelerations_of(system, work, held%a, a)
      associate (nw => system%layout%nw, solution => held%solution)
         done = size_of <= 1.0_wp
         if (.not. done) return
         lambda = lambda + solution(nw + 1:)
         call advance(system%layout, q, solution(:nw), held%moved)
         q = held%moved
      end associate
   end subroutine balance_inertia

   !> Accelerations and multipliers of a state whose deflections are free, into a and held%lambda: eq. (4.15).
   subroutine free_accelerations(system, work, held, t, q, v, a, done)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(driven_motion_type), intent(inout) :: held
      real(wp), intent(in) :: t
      !> Coordinates, velocities; accelerations (nq)
      real(wp), intent(in) :: q(:), v(:)
      real(wp), intent(inout) :: a(:)
      logical, intent(out) :: done
      call balance_free(system, work, held, t, q, v, .true., done)
      if (done) call accelerations_of(system, work, held%a, a)
   end subroutine free_accelerations

   !> Multipliers, and accelerations of the rates (nw), that a scene at rest has at a place, into held%lambda, held%a: the balance
   !> of forces of eq. (4.1) without velocities; deflections are free.
   subroutine rest_multipliers(system, work, held, t, q, done)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(driven_motion_type), intent(inout) :: held
      real(wp), intent(in) :: t, q(:)
      logical, intent(out) :: done
      held%moved = 0.0_wp
      call balance_free(system, work, held, t, q, held%moved, .false., done)
   end subroutine rest_multipliers

   !> The balance of forces of eq. (4.1) with free deflections, into held%a, held%lambda.
   subroutine balance_free(system, work, held, t, q, v, moves, done)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(driven_motion_type), intent(inout) :: held
      !> Time, coordinates and velocities (nq)
      real(wp), intent(in) :: t, q(:), v(:)
      !> Whether constraints have what velocities make of them
      logical, intent(in) :: moves
      !> False if the matrix is singular
      logical, intent(out) :: done
      logical :: singular
      held%a = 0.0_wp
      held%lambda = 0.0_wp
      call motion_residual(system, work, t, q, v, held%a, held%lambda, held%motion, held%rates)
      if (moves) call acceleration_gaps(system, work)
      call linearise_motion(system, work, held%tangent, q, v, held%a, held%lambda)
      call factor_masses(held%tangent, singular)
      done = .not. singular
      if (singular) return
      associate (nw => system%layout%nw)
         held%solution(:nw) = -held%motion
         held%solution(nw + 1:) = 0.0_wp
         if (moves) held%solution(nw + 1:) = work%gamma
         call solve_refined(held%tangent, nw, held%solution, held%correction)
         held%a = held%solution(:nw)
         held%lambda = held%solution(nw + 1:)
      end associate
   end subroutine balance_free

end module limber_multibody_driven_motion
