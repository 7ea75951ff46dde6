!> Stability of an equilibrium, and the way to a stable one. By the stiffness on the motions that the constraints leave, and where
!> the loads have no potential by the motions that grow; a descent to a stable equilibrium where Newton's method finds none or an
!> unstable one. Floor: multibody. Source: doc/theory, eqs. (6.4), (6.6), (6.7).
module limber_multibody_stability
   use limber_base_kinds, only: wp
   use limber_base_signals, only: signal_came
   use limber_multibody_equations_of_motion, only: position_residual, worst_constraint
   use limber_multibody_equilibrium, only: equilibrium_type, find_equilibrium, linearise_balance, solve_step, take_step, go, aim, &
      & most_change
   use limber_multibody_free_motions, only: find_freedom, lowest_stiffness, has_potential
   use limber_multibody_kinematics, only: angle_type
   use limber_multibody_small_vibrations, only: find_growth
   use limber_multibody_sparse_eigenmodes, only: nearest_eigenvalues, is_large, by_scales
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: judge, descend

   !> Energy of a unit motion, relative to the largest and to the forces in the scene, that counts as none
   real(wp), parameter :: none_of_largest = 1.0e-13_wp, none_of_forces = 1.0e-10_wp

contains

   !> Stability of the place of the last `find_equilibrium`, or of any other that was linearised: by the stiffness, and where the
   !> loads have no potential by the motions that grow.
   subroutine judge(system, work, balance, lambda)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      type(equilibrium_type), intent(inout) :: balance
      real(wp), intent(in) :: lambda(:)
      real(wp) :: growth
      logical :: done
      call judge_stiffness(system, work, balance, lambda)
      balance%potential = has_potential(balance%tangent)
      balance%flutters = .false.
      if (is_large(system)) then
         balance%unseen = balance%unseen .or. .not. balance%potential
         return
      end if
      if (balance%potential .or. balance%neutral .or. size(balance%freedom%basis, 2) == 0) return
      call find_growth(system, balance%tangent, balance%freedom, balance%fastest, growth, balance%frequency, balance%softest, done)
      if (.not. done) return
      balance%stable = .not. growth > 0.0_wp
      balance%flutters = growth > 0.0_wp .and. balance%frequency > 0.0_wp
   end subroutine judge

   !> The same by the lowest eigenvalue of the stiffness alone, eq. (6.4).
   subroutine judge_stiffness(system, work, balance, lambda)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      type(equilibrium_type), intent(inout) :: balance
      real(wp), intent(in) :: lambda(:)
      real(wp) :: threshold
      integer :: i, side, body, k
      if (is_large(system)) then
         call judge_large(system, balance)
      else
         call find_freedom(system, work, .false., balance%freedom)
         call lowest_stiffness(system, balance%tangent, balance%freedom, balance%lowest, balance%largest, balance%softest)
      end if
      balance%forces = 0.0_wp
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            do side = 1, 2
               body = item%bodies(side)
               if (body == 0) cycle
               do k = 1, item%rows
                  balance%forces = max(balance%forces, abs(lambda(item%first + k - 1)) &
                     & *maxval(abs(work%jacobians(side, i)%z(k, :))*[1.0_wp, 1.0_wp, 1/system%model%length])*system%model%length)
               end do
            end do
         end associate
      end do
      do i = 1, size(work%loads)
         if (size(work%loads(i)%force) > 0) balance%forces = max(balance%forces, maxval(abs(work%loads(i)%force)) &
            & *min(1.0_wp, system%model%length))
      end do
      threshold = max(none_of_largest*balance%largest, none_of_forces*balance%forces, tiny(threshold))
      balance%stable = balance%lowest > threshold
      balance%neutral = abs(balance%lowest) <= threshold
   end subroutine judge_stiffness

   !> The same for a large scene, from the eigenvalues nearest to zero. Where there is none the scene is taken for neutral.
   subroutine judge_large(system, balance)
      type(system_type), intent(in) :: system
      type(equilibrium_type), intent(inout) :: balance
      integer, parameter :: wanted = 4
      real(wp) :: value(wanted), motion(system%layout%nw, wanted)
      logical :: done
      integer :: i, first, m, least
      balance%largest = 0.0_wp
      do i = 1, size(balance%tangent%bodies)
         first = system%layout%w(i)
         do m = 1, size(balance%tangent%bodies(i)%stiffness, 1)
            balance%largest = max(balance%largest, abs(balance%tangent%bodies(i)%stiffness(m, m))*balance%scale(first + m - 1)**2)
         end do
      end do
      call nearest_eigenvalues(system, balance%tangent, by_scales, 0.0_wp, wanted, value, motion, done)
      balance%lowest = 0.0_wp
      if (.not. done) return
      least = minloc(value, 1)
      balance%lowest = value(least)
      balance%softest = motion(:, least)
      first = maxloc(abs(balance%softest/balance%scale), 1)
      balance%softest = balance%softest*sign(1.0_wp, balance%softest(first))/norm2(balance%softest/balance%scale)
   end subroutine judge_large

   !> Descends from a place that is no equilibrium, or an unstable one, to a stable one: implicit steps along the forces, as if
   !> the scene were moving slowly in something viscous; then Newton's method. Eq. (6.7).
   subroutine descend(system, work, balance, t, leave, q, lambda, done)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(equilibrium_type), intent(inout) :: balance
      real(wp), intent(in) :: t
      !> Whether unstable equilibrium is left
      logical, intent(in) :: leave
      real(wp), intent(inout) :: q(:), lambda(:)
      !> Whether a stable equilibrium was found, or a neutral one; or an unstable one that is not to be left. Never once a signal
      !> asks for the end
      logical, intent(out) :: done
      !> Rounds; those without progress in which constraints may stay open, and trials of springs in each round
      integer, parameter :: most = 1000, most_open = 100, most_springs = 200
      !> Part of a radian, or of the scene; residual of constraints that are closed, and of those that a long way keeps open
      real(wp), parameter :: push = 1.0e-2_wp, closed = 1.0e-6_wp, underway = 1.0e-3_wp
      !> Energy that none has
      real(wp), parameter :: endless = 1.0e100_wp
      real(wp), allocatable :: found(:), found_lambda(:), turned(:)
      type(angle_type), allocatable :: angles(:), first_angles(:)
      real(wp) :: spring, size_of, gap, least_gap
      integer :: round, trial, closing
      allocate (found, source=q)
      allocate (found_lambda, source=lambda)
      allocate (turned, source=balance%turned)
      allocate (angles, source=work%kinematics%angles)
      allocate (first_angles, source=angles)
      done = .false.
      balance%has_left = .false.
      balance%open = 0
      closing = 0
      least_gap = huge(least_gap)
      spring = 0.0_wp
      do round = 1, most
         call linearise_balance(system, work, balance, t, q, lambda)
         if (stays_open()) exit
         call judge_stiffness(system, work, balance, lambda)
         ! Forces without end: no place is found
         if (max(balance%largest, balance%forces) > endless) exit
         if (balance%lowest < 0.0_wp) spring = max(spring, -2*balance%lowest)
         if (.not. spring > 0.0_wp) spring = max(1.0e-3_wp*balance%largest, balance%forces)
         if (.not. spring > 0.0_wp) spring = 1.0_wp
         do trial = 1, most_springs
            if (signal_came()) return
            call solve_step(system, work, balance, spring, size_of)
            if (size_of <= most_change) exit
            spring = 3*spring
            if (spring > 1.0e30_wp*max(balance%largest, balance%forces, 1.0_wp)) exit
         end do
         if (size_of > most_change) exit
         call take_step(system, balance, 1.0_wp, q, lambda)
         if (size_of <= aim .and. settled(balance%solution(system%layout%nw + 1:), lambda)) then
            ! At rest where nothing holds it, or on top of a hill, which it leaves by a small push
            done = balance%neutral .or. .not. (balance%stable .or. leave)
            if (done) return
            if (.not. balance%stable) then
               balance%has_left = .true.
               balance%left = balance%softest
               balance%motion = push*balance%softest
               call go(system, balance%motion, balance%moved, balance%turned, q)
               cycle
            end if
         end if
         if (size_of < 0.5_wp*most_change) spring = 0.3_wp*spring
         if (.not. balance%stable .or. size_of > 0.1_wp) cycle
         found = q
         found_lambda = lambda
         turned = balance%turned
         angles(:) = work%kinematics%angles
         call find_equilibrium(system, work, balance, t, found, found_lambda, .false., done)
         if (.not. done) cycle
         call judge_stiffness(system, work, balance, found_lambda)
         done = balance%stable .or. balance%neutral
         if (.not. done) then
            balance%turned = turned
            work%kinematics%angles(:) = angles
            cycle
         end if
         q = found
         lambda = found_lambda
         return
      end do
      if (gap > closed) call close_constraints()
      work%kinematics%angles(:) = first_angles

   contains

      !> Closes constraints that are open at the last place, by steps without regard to forces. What cannot be closed is told.
      subroutine close_constraints()
         integer, parameter :: most_closing = 100
         !> Spring beside all that is stiff; largest way
         real(wp), parameter :: stiff = 1.0e6_wp, longest = 2.0_wp
         real(wp) :: way
         integer :: i
         call worst_constraint(system, work, balance%open, balance%gap)
         spring = stiff*max(balance%largest, balance%forces)
         if (.not. spring > 0.0_wp) spring = 1.0_wp
         found = q
         found_lambda = lambda
         way = 0.0_wp
         do i = 1, most_closing
            call linearise_balance(system, work, balance, t, found, found_lambda)
            if (position_residual(system, work) <= closed) then
               balance%open = 0
               return
            end if
            call solve_step(system, work, balance, spring, size_of)
            if (size_of >= huge(size_of) .or. signal_came()) return
            way = way + min(size_of, most_change)
            if (way > longest) return
            call take_step(system, balance, min(1.0_wp, most_change/max(size_of, tiny(size_of))), found, found_lambda)
         end do
      end subroutine close_constraints

      !> Whether constraints have been open for long, and do not close: no place satisfies them.
      logical function stays_open()
         real(wp), parameter :: progress = 0.9_wp
         gap = 0.0_wp
         if (system%nc > 0) gap = position_residual(system, work)
         if (gap <= max(underway, progress*least_gap)) closing = round
         least_gap = min(least_gap, gap)
         stays_open = round - closing >= most_open
      end function stays_open

   end subroutine descend

   !> Whether multipliers have stopped changing.
   pure logical function settled(change, lambda)
      real(wp), intent(in) :: change(:), lambda(:)
      settled = .true.
      if (size(lambda) > 0) settled = maxval(abs(change)) <= 1.0e-10_wp*maxval(abs(lambda))
   end function settled

end module limber_multibody_stability
