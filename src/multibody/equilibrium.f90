!> Equilibrium at rest or in steady rotation. Newton's method with the exact tangent of motion and constraints. Floor: multibody.
!> Source: doc/theory, eqs. (4.42), (4.43), (6.3), (6.15)-(6.17).
module limber_multibody_equilibrium
   use limber_base_kinds, only: wp
   use limber_base_signals, only: signal_came
   use limber_multibody_plane_vectors, only: turn
   use limber_multibody_equations_of_motion, only: position_residual
   use limber_multibody_free_motions, only: free_motions_type, rate_scales
   use limber_multibody_kinematics, only: angle_type, move_frames
   use limber_multibody_layout, only: advance
   use limber_multibody_motion_residual, only: motion_residual, linearise_motion, linearise_loads
   use limber_multibody_system, only: system_type, workspace_type
   use limber_multibody_tangent, only: tangent_type, new_tangent, combine_stiffness, factor_masses, gather, solve_refined
   use limber_multibody_turn_counts, only: count_turns
   implicit none
   private
   public :: equilibrium_type, new_equilibrium, find_equilibrium, settle, settle_rates, linearise_balance, steady_motion, is_near, &
      & extent, first_step, solve_step, take_step, go, settle_beside, begin_way

   !> Change of a coordinate relative to its scale: aimed at, taken where round-off forbids more, and most in an iteration
   real(wp), parameter, public :: aim = 1.0e-12_wp, good = 1.0e-8_wp, most_change = 0.25_wp

   !> What is sought, what is found, and scratch
   type :: equilibrium_type
      type(tangent_type) :: tangent
      type(free_motions_type) :: freedom
      !> Speed of a steady rotation [rad/time], and its centre (2)
      real(wp) :: rotation = 0.0_wp, centre(2) = 0.0_wp
      !> Iterations so far
      integer :: iterations = 0
      !> Lowest and largest stiffness of the last `judge` [energy], its motion (nw), and whether it is above, below or at zero
      real(wp) :: lowest = 0.0_wp, largest = 0.0_wp
      real(wp), allocatable :: softest(:)
      logical :: stable = .false., neutral = .false.
      !> Whether the loads have a potential; if not, whether small vibrations grow, and their circular frequency [rad/time]
      logical :: potential = .true., flutters = .false.
      !> True once a scene without potential was too large to look for vibrations that grow
      logical :: unseen = .false.
      real(wp) :: frequency = 0.0_wp
      !> Vibrations that are faster do not count [rad/time]
      real(wp) :: fastest = huge(1.0_wp)
      !> Whether `descend` has left an unstable equilibrium on its way, and the motion in which it was unstable (nw)
      logical :: has_left = .false.
      real(wp), allocatable :: left(:)
      !> Constraint that `descend` could not close, 0 if it could, and how far it was open [length, or 1 for angles]
      integer :: open = 0
      real(wp) :: gap = 0.0_wp
      !> Largest of the forces of constraints and loads in the scaled rates [energy]
      real(wp) :: forces = 0.0_wp
      !> Velocities and accelerations of the coordinates (nq); the latter in the layout of the rates too (nw)
      real(wp), allocatable :: v(:), a(:), push(:)
      !> Scales (nw), residuals (nw), (nc), unknowns (nw + nc), a place moved (nq), places of the diagonal in the matrix (nw)
      real(wp), allocatable :: scale(:), motion(:), rates(:), solution(:), correction(:), moved(:)
      integer, allocatable :: diagonal(:)
      !> Change of the coordinates in the last `find_equilibrium`, and that of its first step (nw)
      real(wp), allocatable :: change(:), first_change(:)
      !> By how much frames have turned since `begin_way`, whole turns too (bodies) [rad]
      real(wp), allocatable :: turned(:)
   end type equilibrium_type

contains

   !> Room and pattern.
   subroutine new_equilibrium(system, balance)
      type(system_type), intent(in) :: system
      type(equilibrium_type), intent(inout) :: balance
      integer :: i
      associate (nq => system%layout%nq, nw => system%layout%nw, nc => system%nc)
         call new_tangent(system, balance%tangent)
         allocate (balance%v(nq), balance%a(nq), balance%push(nw), balance%softest(nw), balance%scale(nw), balance%motion(nw))
         allocate (balance%rates(nc), balance%solution(nw + nc), balance%correction(nw + nc))
         allocate (balance%moved(nq), balance%diagonal(nw))
         balance%softest = 0.0_wp
         allocate (balance%left(nw), balance%change(nw), balance%first_change(nw))
         allocate (balance%turned(size(system%layout%q)), source=0.0_wp)
         balance%left = 0.0_wp
         balance%scale = rate_scales(system)
         do i = 1, nw
            balance%diagonal(i) = balance%tangent%matrix%place(i, i)
         end do
      end associate
   end subroutine new_equilibrium

   !> Velocities and accelerations of the steady rotation at a place; none without it.
   subroutine steady_motion(system, balance, q)
      type(system_type), intent(in) :: system
      type(equilibrium_type), intent(inout) :: balance
      !> Coordinates (nq)
      real(wp), intent(in) :: q(:)
      integer :: i, first, at
      balance%v = 0.0_wp
      balance%a = 0.0_wp
      balance%push = 0.0_wp
      associate (speed => balance%rotation)
         if (.not. abs(speed) > 0.0_wp) return
         do i = 1, size(system%layout%q)
            first = system%layout%q(i)
            at = system%layout%w(i)
            balance%v(first:first + 1) = speed*turn(q(first:first + 1) - balance%centre)
            balance%a(first:first + 1) = -speed**2*(q(first:first + 1) - balance%centre)
            balance%push(at:at + 1) = balance%a(first:first + 1)
            if (.not. system%layout%framed(i)) cycle
            balance%v(first + 2:first + 3) = speed*turn(q(first + 2:first + 3))
            balance%a(first + 2:first + 3) = -speed**2*q(first + 2:first + 3)
         end do
      end associate
   end subroutine steady_motion

   !> Residuals and derivatives at a place, eqs. (6.15), (6.16).
   subroutine linearise_balance(system, work, balance, t, q, lambda)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(equilibrium_type), intent(inout) :: balance
      !> Time; coordinates (nq); multipliers (nc)
      real(wp), intent(in) :: t, q(:), lambda(:)
      real(wp) :: residual
      integer :: i
      call steady_motion(system, balance, q)
      call motion_residual(system, work, t, q, balance%v, balance%push, lambda, balance%motion, balance%rates)
      residual = position_residual(system, work)
      call linearise_motion(system, work, balance%tangent, q, balance%v, balance%push, lambda)
      if (abs(balance%rotation) > 0.0_wp) then
         call turn_loads(system, work, balance, q)
         do i = 1, size(balance%tangent%bodies)
            call add_rotation_stiffness(balance%rotation, balance%tangent%bodies(i)%mass, balance%tangent%bodies(i)%stiffness)
         end do
         call gather(balance%tangent)
      end if
   end subroutine linearise_balance

   !> Loads in a steady rotation: they see the motion relative to the ground, which turns too, and at rest there is none. Takes what
   !> they make of the velocities of the rotation out of residual and derivatives, eq. (6.17).
   subroutine turn_loads(system, work, balance, q)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(equilibrium_type), intent(inout) :: balance
      !> Coordinates (nq)
      real(wp), intent(in) :: q(:)
      real(wp) :: rest(size(q))
      integer :: i, k
      rest = 0.0_wp
      call move_frames(system%model, system%layout, q, rest, work%kinematics)
      do i = 1, size(system%loads)
         associate (load => system%loads(i)%item, force => work%loads(i)%force, to => balance%tangent%loads(i)%unknowns)
            ! The bodies of a load may be the same one
            do k = 1, size(to)
               balance%motion(to(k)) = balance%motion(to(k)) + force(k)
            end do
            force = 0.0_wp
            call load%add_force(work%kinematics, force)
            if (load%is_scaled) force = load%share*force
            do k = 1, size(to)
               balance%motion(to(k)) = balance%motion(to(k)) - force(k)
            end do
         end associate
      end do
      call linearise_loads(system, work, balance%tangent)
      call move_frames(system%model, system%layout, q, balance%v, work%kinematics)
   end subroutine turn_loads

   !> Adds what a steady rotation adds to the stiffness of a body, whose accelerations depend on its place: -speed^2 M on r.
   pure subroutine add_rotation_stiffness(speed, mass, stiffness)
      real(wp), intent(in) :: speed, mass(:, :)
      real(wp), intent(inout) :: stiffness(:, :)
      stiffness(:, 1:2) = stiffness(:, 1:2) - speed**2*mass(:, 1:2)
   end subroutine add_rotation_stiffness

   !> Factors the tangent with a spring on every coordinate, and solves for the step: unknowns [increments; changes of multipliers].
   subroutine solve_step(system, work, balance, spring, size_of)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      type(equilibrium_type), intent(inout) :: balance
      !> Stiffness on scaled coordinates [energy]
      real(wp), intent(in) :: spring
      !> Largest change relative to its scale; huge if there is none
      real(wp), intent(out) :: size_of
      logical :: singular
      associate (nw => system%layout%nw, solution => balance%solution, matrix => balance%tangent%matrix)
         call combine_stiffness(balance%tangent, 0.0_wp)
         if (spring > 0.0_wp) matrix%values(balance%diagonal) = matrix%values(balance%diagonal) + spring/balance%scale**2
         call matrix%factor(singular)
         size_of = huge(size_of)
         if (singular) return
         solution(:nw) = -balance%motion
         solution(nw + 1:) = -work%phi
         call matrix%solve(solution)
         size_of = maxval(abs(solution(:nw)/balance%scale))
         if (.not. size_of <= huge(size_of)) size_of = huge(size_of)
      end associate
   end subroutine solve_step

   !> Size of the first step of Newton's method at a place that was linearised, relative to the scales; huge if there is none.
   subroutine first_step(system, work, balance, size_of)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      type(equilibrium_type), intent(inout) :: balance
      real(wp), intent(out) :: size_of
      call solve_step(system, work, balance, 0.0_wp, size_of)
   end subroutine first_step

   !> Takes the step found, or a part of it.
   subroutine take_step(system, balance, part, q, lambda)
      type(system_type), intent(in) :: system
      type(equilibrium_type), intent(inout) :: balance
      real(wp), intent(in) :: part
      real(wp), intent(inout) :: q(:), lambda(:)
      associate (nw => system%layout%nw)
         balance%solution(:nw) = part*balance%solution(:nw)
         call go(system, balance%solution(:nw), balance%moved, balance%turned, q)
         lambda = lambda + part*balance%solution(nw + 1:)
      end associate
      balance%iterations = balance%iterations + 1
   end subroutine take_step

   !> Moves to a place near by, and counts the turns on the way.
   pure subroutine go(system, change, moved, turned, q)
      type(system_type), intent(in) :: system
      !> (nw)
      real(wp), intent(in) :: change(:)
      !> Scratch (nq); turns so far (bodies); coordinates (nq)
      real(wp), intent(inout) :: moved(:), turned(:), q(:)
      call advance(system%layout, q, change, moved)
      call count_turns(system%layout, q, moved, turned)
      q = moved
   end subroutine go

   !> Begins a way at a place that counts, with the angles that are followed there.
   subroutine begin_way(balance, work, angles)
      type(equilibrium_type), intent(inout) :: balance
      type(workspace_type), intent(inout) :: work
      type(angle_type), intent(in) :: angles(:)
      balance%turned = 0.0_wp
      work%kinematics%angles(:) = angles
   end subroutine begin_way

   !> Newton's method from a place near by. Leaves residuals and derivatives at the last place.
   subroutine find_equilibrium(system, work, balance, t, q, lambda, keeps_near, done)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(equilibrium_type), intent(inout) :: balance
      real(wp), intent(in) :: t
      !> Coordinates (nq), multipliers (nc); those of the guess if it fails
      real(wp), intent(inout) :: q(:), lambda(:)
      !> Whether to give up where the first step is long, or more than that becomes of it
      logical, intent(in) :: keeps_near
      !> Whether it was found; never once a signal asks for the end
      logical, intent(out) :: done
      integer, parameter :: most = 30
      real(wp), parameter :: astray = 4
      real(wp), allocatable :: first(:), first_lambda(:), first_turned(:)
      type(angle_type), allocatable :: angles(:)
      real(wp) :: size_of, last
      integer :: round
      allocate (first, source=q)
      allocate (first_lambda, source=lambda)
      allocate (first_turned, source=balance%turned)
      allocate (angles, source=work%kinematics%angles)
      done = .false.
      last = huge(last)
      balance%change = 0.0_wp
      do round = 1, most
         call linearise_balance(system, work, balance, t, q, lambda)
         call solve_step(system, work, balance, 0.0_wp, size_of)
         if (size_of >= huge(size_of) .or. signal_came()) exit
         done = size_of <= aim .or. (size_of <= good .and. size_of >= 0.1_wp*last)
         call take_step(system, balance, min(1.0_wp, most_change/max(size_of, tiny(size_of))), q, lambda)
         balance%change = balance%change + balance%solution(:system%layout%nw)
         if (round == 1) balance%first_change = balance%change
         if (done) exit
         if (keeps_near .and. size_of > most_change) exit
         if (keeps_near .and. extent(balance, balance%change) > astray*extent(balance, balance%first_change) + good) exit
         last = size_of
      end do
      if (done) then
         call linearise_balance(system, work, balance, t, q, lambda)
         if (system%redundant) then
            call least_multipliers(system, work, balance, t, q, lambda)
            call linearise_balance(system, work, balance, t, q, lambda)
         end if
      else
         q = first
         lambda = first_lambda
         balance%turned = first_turned
         work%kinematics%angles(:) = angles
      end if
   end subroutine find_equilibrium

   !> Equilibrium at a critical load, near by: a spring holds what nothing holds there, all else is in balance.
   subroutine settle_beside(system, work, balance, t, q, lambda, done)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Judged near by
      type(equilibrium_type), intent(inout) :: balance
      real(wp), intent(in) :: t
      !> Coordinates (nq), multipliers (nc)
      real(wp), intent(inout) :: q(:), lambda(:)
      logical, intent(out) :: done
      integer, parameter :: most = 20
      !> Spring beside the stiffness and the forces; change that is round-off beside it; longest step
      real(wp), parameter :: soft = 1.0e-6_wp, little = 1.0e-9_wp, longest = 1.0e-3_wp
      real(wp) :: size_of, spring
      integer :: round
      spring = soft*max(balance%largest, balance%forces)
      done = .false.
      if (.not. spring > 0.0_wp) return
      balance%change = 0.0_wp
      do round = 1, most
         call linearise_balance(system, work, balance, t, q, lambda)
         call solve_step(system, work, balance, spring, size_of)
         if (.not. size_of <= longest) return
         call take_step(system, balance, 1.0_wp, q, lambda)
         balance%change = balance%change + balance%solution(:system%layout%nw)
         done = size_of <= little
         if (done) exit
      end do
      call linearise_balance(system, work, balance, t, q, lambda)
   end subroutine settle_beside

   !> Nearest equilibrium of a scene without loads whose frames may be free, eq. (4.42): Newton's method with a weak spring on every
   !> change, so that what costs no energy stays where it is. Leaves the factors of its last step.
   subroutine settle(system, work, balance, t, q, lambda, done)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(equilibrium_type), intent(inout) :: balance
      real(wp), intent(in) :: t
      !> Coordinates (nq), multipliers (nc)
      real(wp), intent(inout) :: q(:), lambda(:)
      logical, intent(out) :: done
      integer, parameter :: most = 200
      !> Spring relative to the largest stiffness
      real(wp), parameter :: weak = 1.0e-9_wp
      real(wp) :: size_of, last, spring
      integer :: round, i, k
      done = .false.
      last = huge(last)
      do round = 1, most
         call linearise_balance(system, work, balance, t, q, lambda)
         spring = 0.0_wp
         do i = 1, size(balance%tangent%bodies)
            associate (stiffness => balance%tangent%bodies(i)%stiffness, scale => balance%scale(system%layout%w(i):))
               do k = 1, size(stiffness, 1)
                  spring = max(spring, weak*abs(stiffness(k, k))*scale(k)**2)
               end do
            end associate
         end do
         call solve_step(system, work, balance, spring, size_of)
         if (size_of >= huge(size_of) .or. signal_came()) return
         done = size_of <= aim .or. (size_of <= good .and. size_of >= 0.5_wp*last)
         call take_step(system, balance, min(1.0_wp, most_change/max(size_of, tiny(size_of))), q, lambda)
         if (done) return
         last = size_of
      end do
   end subroutine settle

   !> Rates by which that equilibrium follows its drivers, eq. (4.43); behind `settle`.
   subroutine settle_rates(system, work, balance, t, q, v, lambda, w)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(equilibrium_type), intent(inout) :: balance
      real(wp), intent(in) :: t
      !> Coordinates, velocities (nq); multipliers (nc)
      real(wp), intent(in) :: q(:), v(:), lambda(:)
      !> Rates that belong to the velocities; corrected (nw)
      real(wp), intent(inout) :: w(:)
      associate (nw => system%layout%nw, solution => balance%solution)
         balance%push = 0.0_wp
         call motion_residual(system, work, t, q, v, balance%push, lambda, balance%motion, balance%rates)
         solution(:nw) = 0.0_wp
         solution(nw + 1:) = -balance%rates
         call balance%tangent%matrix%solve(solution)
         w = w + solution(:nw)
      end associate
   end subroutine settle_rates

   !> Largest entry of a change, each relative to its scale.
   pure real(wp) function extent(balance, change)
      type(equilibrium_type), intent(in) :: balance
      !> (nw)
      real(wp), intent(in) :: change(:)
      extent = maxval(abs(change/balance%scale))
   end function extent

   !> Whether the last `find_equilibrium` has stayed on the branch it came from: its change is that of the tangents at both ends,
   !> eq. (6.3). The loads are those of the place that it left, where the derivatives are those of the place that it found.
   subroutine is_near(system, work, balance, t, q, lambda, near)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(equilibrium_type), intent(inout) :: balance
      !> Time of the place that it left; coordinates (nq) and multipliers (nc) of that which it found
      real(wp), intent(in) :: t, q(:), lambda(:)
      logical, intent(out) :: near
      !> Difference from the mean of the tangents, and between the two, beside the change of a coordinate and beside the largest
      real(wp), parameter :: of_own(2) = [0.1_wp, 0.6_wp], of_largest(2) = [5.0e-4_wp, 0.05_wp]
      !> Change that is none: near a critical load round-off makes as much of it
      real(wp), parameter :: none = 1.0e-7_wp
      real(wp) :: size_of, largest, own(system%layout%nw), back(system%layout%nw)
      largest = extent(balance, balance%change)
      near = largest <= none
      if (near) return
      call steady_motion(system, balance, q)
      call motion_residual(system, work, t, q, balance%v, balance%push, lambda, balance%motion, balance%rates)
      size_of = position_residual(system, work)
      if (abs(balance%rotation) > 0.0_wp) call turn_loads(system, work, balance, q)
      call solve_step(system, work, balance, 0.0_wp, size_of)
      if (size_of >= huge(size_of)) return
      back = -balance%solution(:system%layout%nw)
      associate (ahead => balance%first_change, change => balance%change, scale => balance%scale)
         own = max(abs(ahead), abs(change), abs(back))/scale
         largest = maxval(own)
         near = all(abs(change - 0.5_wp*(ahead + back))/scale <= of_own(1)*own + of_largest(1)*largest + none) .and. &
            & all(abs(ahead - back)/scale <= of_own(2)*own + of_largest(2)*largest + none)
      end associate
   end subroutine is_near

   !> Of redundant constraints the multipliers of least norm, at the place of the last `linearise_balance`.
   subroutine least_multipliers(system, work, balance, t, q, lambda)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(equilibrium_type), intent(inout) :: balance
      real(wp), intent(in) :: t, q(:)
      !> With the multipliers of any norm
      real(wp), intent(inout) :: lambda(:)
      real(wp) :: none(size(lambda))
      logical :: singular
      none = 0.0_wp
      call motion_residual(system, work, t, q, balance%v, balance%push, none, balance%motion, balance%rates)
      call factor_masses(balance%tangent, singular)
      if (singular) return
      associate (nw => system%layout%nw)
         balance%solution(:nw) = -balance%motion
         balance%solution(nw + 1:) = 0.0_wp
         call solve_refined(balance%tangent, nw, balance%solution, balance%correction)
         lambda = balance%solution(nw + 1:)
      end associate
   end subroutine least_multipliers

end module limber_multibody_equilibrium
