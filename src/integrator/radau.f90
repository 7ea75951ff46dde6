!> RADAU: Radau IIA of order 5, three stages, on the equations of index 2: motion and velocity constraints at every stage, the
!> position constraints restored by projection after the step. In each Newton step one real and one complex sparse system of the
!> exact derivatives are solved. Dense output of order 5 from coordinates, rates and accelerations at both ends. Floor: integrator.
!> Source: Hairer and Wanner, Solving Ordinary Differential Equations II, sections IV.8, VII; doc/theory, eqs. (5.6)-(5.8), (5.12).
module limber_integrator_radau
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_base_error, only: error_type
   use limber_integrator_implicit, only: implicit_type
   use limber_integrator_lasting_errors, only: lasting_type, motion_time
   use limber_integrator_integrator, only: constraint_limit
   use limber_integrator_error_scales, only: energy_scale
   use limber_integrator_quintic_output, only: quintic_state, quintic_place, quintic_accelerations, add_projection
   use limber_integrator_relaxed_output, only: relax_ends
   use limber_integrator_radau_method, only: radau_a, radau_c, radau_t, radau_ti, radau_inverse, radau_weights, &
      & gamma => radau_gamma, alpha => radau_alpha, beta => radau_beta
   use limber_multibody_equations_of_motion, only: input_power, power_at
   use limber_multibody_layout, only: velocities_of, advance
   use limber_multibody_motion_residual, only: motion_residual
   use limber_multibody_projection, only: settle
   use limber_multibody_system, only: system_type, workspace_type
   use limber_multibody_tangent, only: combine, combine_complex, give_way
   use limber_multibody_tangent_products, only: times_mass, times_stiffness
   implicit none
   private
   public :: radau_type

   integer, parameter :: most_iterations = 10
   !> Contraction of Newton's method below which the derivatives serve the next step, too; growth of the step that is not worth new
   !> factors then
   real(wp), parameter :: lazy = 1.0e-3_wp, alike = 1.2_wp
   !> Steps that a step may have failed at for that to count
   real(wp), parameter :: forgotten = 10.0_wp

   !> Memory of the method
   type, extends(implicit_type) :: radau_type
      !> Accelerations at the beginning and the end of the last step (nw)
      real(wp), allocatable :: a_before(:), a_end(:)
      !> The same two for its dense output (nw,2)
      real(wp), allocatable :: a_shown(:, :)
      !> Stages: increments of rates and coordinates (nw,3), multipliers (nc,3), power of what puts work in (3)
      real(wp), allocatable :: z(:, :), x(:, :), multipliers(:, :)
      real(wp) :: stage_power(3) = 0.0_wp
      !> What lasts of errors of the rates; steps until it is looked at again where it has not paid
      type(lasting_type) :: lasting
      integer :: rest = 0
      !> Scratch
      real(wp), allocatable :: motion(:, :), rate(:, :), stage_q(:), stage_v(:), stage_a(:), real_part(:), e(:), q_stage_end(:)
      complex(wp), allocatable :: complex_part(:)
      !> Error and step of the last accepted step, for the prediction
      real(wp) :: error_last = 0.0_wp, h_accepted = 0.0_wp
      !> Step at which Newton's method has failed, longer with each step since then; zero: there is none
      real(wp) :: h_failed = 0.0_wp
      !> Contraction of the last Newton iteration, and whether the derivatives are those of the present state
      real(wp) :: contraction = 1.0_wp
      logical :: current = .false.
   contains
      procedure :: start => radau_start
      procedure :: step => radau_step
      procedure :: interpolate => radau_interpolate
      procedure :: interpolate_place => radau_interpolate_place
      procedure :: interpolate_accelerations => radau_accelerations
      procedure :: exchange => exchange_radau
   end type radau_type

contains

   subroutine radau_start(self, system, work, t, duration, q, v, error)
      class(radau_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t, duration, q(:), v(:)
      type(error_type), allocatable, intent(out) :: error
      if (.not. allocated(self%z)) then
         associate (nq => system%layout%nq, nw => system%layout%nw, nc => system%nc)
            allocate (self%a_before(nw), self%a_end(nw), self%a_shown(nw, 2), self%z(nw, 3), self%x(nw, 3), self%rate(nc, 3), &
               & self%multipliers(nc, 3), self%motion(nw, 3), self%stage_q(nq), self%q_stage_end(nq), self%stage_v(nq), &
               & self%stage_a(nw), self%real_part(nw + nc), self%e(nw), self%complex_part(nw + nc))
         end associate
         call self%use_sparse(system)
         call self%lasting%prepare(system, self%tangent)
      end if
      call self%lasting%forget()
      self%rest = 0
      self%sees_inside = .true.
      call self%begin(system, work, t, duration, q, v, error)
      if (allocated(error)) return
      self%h_accepted = 0.0_wp
      self%h_failed = 0.0_wp
      self%contraction = 1.0_wp
      self%a_before = self%a
      self%a_end = self%a
      self%a_shown = spread(self%a, 2, 2)
      call self%begin_step_size(duration, 0.1_wp*bound(self)**0.25_wp)
   end subroutine radau_start

   subroutine radau_step(self, system, work, stop, error)
      class(radau_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: stop
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: wanted, err, factor
      logical :: converged, accepted, repeated
      integer :: i, failures
      wanted = self%h
      repeated = .false.
      failures = 0
      do
         if (self%maximum_step > 0.0_wp) self%h = min(self%h, self%maximum_step)
         if (self%fixed_step > 0.0_wp .and. .not. repeated) self%h = self%fixed_step
         if (self%t + 1.0001_wp*self%h > stop) self%h = stop - self%t
         if (self%h <= self%least_step(stop)) then
            i = maxloc(abs(self%real_part(:system%layout%nw))/self%scale_w, dim=1)
            call self%step_too_small(system, work, count(system%layout%w <= i), error)
            return
         end if
         if (.not. self%fresh) then
            call self%refresh(system, work)
            call self%lasting%forget()
            self%current = .true.
         end if
         if (abs(self%h - self%h_factors) > 0.0_wp) call factor_both(self, converged)
         if (abs(self%h - self%h_factors) > 0.0_wp) then
            call self%singular_matrix(system, work, 'RADAU', error)
            return
         end if
         call guess_stages(self)
         call iterate(self, system, work, converged)
         if (.not. converged .and. .not. self%current) then
            self%fresh = .false.
            cycle
         end if
         if (.not. converged) then
            self%statistics%rejected = self%statistics%rejected + 1
            call self%heed_failure(failures)
            call cross_fold(self, system, work, stop, accepted)
            repeated = .true.
            if (.not. accepted) cycle
            err = bound(self)
            factor = min(8.0_wp, max(1.0_wp, wanted/self%h))
            exit
         end if
         call estimate_error(self, system, work, err)
         accepted = err <= bound(self) .or. self%fixed_step > 0.0_wp
         if (accepted .and. system%powered) call integrate_power(self, system, work, err, accepted)
         factor = next_factor(self, err, repeated .or. .not. accepted)
         if (.not. accepted) then
            self%statistics%rejected = self%statistics%rejected + 1
            self%h = self%h*min(factor, 0.9_wp)
            repeated = .true.
            cycle
         end if
         call accept(self, system, work, stop, accepted, error)
         if (allocated(error)) return
         if (accepted) exit
         self%statistics%failed_projections = self%statistics%failed_projections + 1
         self%h = 0.5_wp*self%h
         repeated = .true.
      end do
      self%error_last = max(err, 1.0e-2_wp*bound(self))
      self%h_accepted = self%h
      self%h_failed = 1.05_wp*self%h_failed
      if (self%h_failed > forgotten*self%h) self%h_failed = 0.0_wp
      self%h_last = self%h
      ! The function of stability of the method is exp(z) to z^6/7200
      call self%ringing%note(system, self%h, self%a_end, 1/7200.0_wp, 6)
      call self%count_step(self%h, 5, 16*err < bound(self))
      self%current = .false.
      self%fresh = self%contraction <= lazy .and. .not. repeated
      if (.not. self%fresh .or. factor < 1.0_wp .or. factor > alike) self%h = self%h*factor
      if (self%t >= stop .and. .not. repeated) self%h = max(self%h, wanted)
      call self%renew_scales(system)
   end subroutine radau_step

   !> Error estimate that a step may have. It is of order 4 in the step while the error that adds up is of order 5: so the result
   !> is as good as the tolerance, eq. (5.9).
   pure real(wp) function bound(self)
      class(radau_type), intent(in) :: self
      bound = bound_of(self%tolerance)
   end function bound

   !> The same of any tolerance.
   pure real(wp) function bound_of(tolerance)
      real(wp), intent(in) :: tolerance
      bound_of = 0.1_wp*tolerance**0.8_wp
   end function bound_of

   !> Factors of the real and the complex matrix for the present step.
   subroutine factor_both(self, done)
      class(radau_type), intent(inout) :: self
      logical, intent(out) :: done
      complex(wp) :: mu
      logical :: singular
      self%tangent%softness = self%h/gamma
      call combine(self%tangent, gamma/self%h, 1.0_wp, 1/(gamma/self%h), 1/(gamma/self%h))
      call self%tangent%matrix%factor(singular)
      done = .not. singular
      mu = cmplx(alpha, beta, wp)/self%h
      call combine_complex(self%tangent, mu, (1.0_wp, 0.0_wp), 1/mu, 1/mu)
      call self%tangent%matrix%factor_complex(singular)
      done = done .and. .not. singular
      self%statistics%factorisations = self%statistics%factorisations + 2
      if (done) self%h_factors = self%h
   end subroutine factor_both

   !> First guess of the stages: the quadratic rates that end accelerations and stages of the last step make.
   subroutine guess_stages(self)
      class(radau_type), intent(inout) :: self
      integer :: i
      do i = 1, 3
         self%z(:, i) = radau_c(i)*self%h*self%a_end
         if (self%h_last > 0.0_wp) self%z(:, i) = self%z(:, i) &
            & + 0.5_wp*(radau_c(i)*self%h/self%h_last)*radau_c(i)*self%h*(self%a_end - self%a_before)
         self%multipliers(:, i) = self%lambda
      end do
   end subroutine guess_stages

   !> Simplified Newton iteration for the stages. Whether it will converge is judged by the mean contraction of two rounds, if that
   !> is less: where a correction of one coordinate leaves a residual in a stiff one, each second round contracts by nothing.
   subroutine iterate(self, system, work, converged)
      class(radau_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      logical, intent(out) :: converged
      !> Correction, in units of the scales, that is round-off if it no longer shrinks
      real(wp), parameter :: noise = 1.0e-12_wp
      real(wp) :: size_now, size_last, goal, contraction_last, mean
      integer :: round, i
      converged = .false.
      goal = max(1.0e-14_wp, self%strictness*bound(self)*min(0.03_wp, sqrt(bound(self))))
      size_last = 0.0_wp
      do round = 1, most_iterations
         self%iterations = round
         do i = 1, 3
            call find_residual(self, system, work, i)
            if (system%redundant) call give_way(self%tangent, self%multipliers(:, i), self%rate(:, i))
         end do
         call newton_change(self, system, size_now)
         if (.not. size_now <= huge(size_now)) return
         if (round > 1) then
            contraction_last = merge(self%contraction, 1.0_wp, round > 2)
            self%contraction = size_now/max(size_last, tiny(size_last))
            mean = min(self%contraction, sqrt(self%contraction*contraction_last))
            if (round > 2 .and. mean >= 0.99_wp) converged = size_now <= noise
            if (round > 2 .and. mean >= 0.99_wp .and. size_now > goal) return
            if (round > 2 .and. mean < 0.99_wp) then
               converged = size_now/(1 - mean) <= noise
               if (size_now*mean**(most_iterations - round)/(1 - mean) > goal) return
            end if
            if (self%contraction < 1.0_wp) converged = converged .or. size_now*self%contraction/(1 - self%contraction) <= goal
         end if
         converged = converged .or. size_now <= 1.0e-2_wp*goal
         if (converged) exit
         size_last = size_now
      end do
   end subroutine iterate

   !> Places a stage; its residuals.
   subroutine find_residual(self, system, work, i)
      class(radau_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Which stage
      integer, intent(in) :: i
      call place_stage(self, system, i)
      call motion_residual(system, work, self%t + radau_c(i)*self%h, self%stage_q, self%stage_v, self%stage_a, &
         & self%multipliers(:, i), self%motion(:, i), self%rate(:, i), .true.)
   end subroutine find_residual

   !> Power put in at the stages, less what their residuals take: with them it is as exact as the stages will ever be. For the
   !> balance of energy of a rough motion the multipliers serve as Newton's method has left them.
   subroutine find_stage_power(self, system, work)
      class(radau_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      logical :: rough
      integer :: i
      rough = self%input%is_rough(self%tolerance)
      do i = 1, 3
         work%lambda = self%multipliers(:, i)
         if (rough) then
            call place_stage(self, system, i)
            self%stage_power(i) = power_at(system, work, self%t + radau_c(i)*self%h, self%stage_q, self%stage_v)
            cycle
         end if
         call find_residual(self, system, work, i)
         self%stage_power(i) = input_power(system, work, self%stage_q, self%stage_v) + dot_product(self%e, self%motion(:, i)) &
            & - dot_product(self%multipliers(:, i), self%rate(:, i))
      end do
   end subroutine find_stage_power

   !> Work of a step whose motion is good; its error must be as small.
   subroutine integrate_power(self, system, work, err, good)
      class(radau_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Error estimate of the motion, raised to that of the work if this is larger
      real(wp), intent(inout) :: err
      logical, intent(out) :: good
      real(wp) :: own
      call find_stage_power(self, system, work)
      call self%input%try_stages(self%h, self%stage_power, energy_scale(system, self%scales), own)
      own = own*bound(self)/bound_of(self%input%allowed(self%tolerance))
      good = self%fixed_step > 0.0_wp .or. self%h <= self%last_digits()
      if (.not. good) good = self%input%is_within(own, bound(self))
      if (.not. (good .and. own > bound(self))) err = max(err, own)
   end subroutine integrate_power

   !> Coordinates, velocities and accelerations of a stage from the increments of its rates.
   subroutine place_stage(self, system, i)
      class(radau_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Which stage
      integer, intent(in) :: i
      call add_stages(size(self%w), i, self%h, self%w, self%z, self%x, self%stage_a, self%e)
      call advance(system%layout, self%q, self%x(:, i), self%stage_q)
      call velocities_of(system%layout, self%stage_q, self%e, self%stage_v)
   end subroutine place_stage

   !> Increments, accelerations and rates of a stage.
   pure subroutine add_stages(nw, i, h, w, z, x, a, rates)
      !> Number of rates; which stage
      integer, intent(in) :: nw, i
      !> Step; rates at its beginning; what the stages add to them
      real(wp), intent(in) :: h, w(nw), z(nw, 3)
      !> Increments of the coordinates; accelerations and rates of the stage
      real(wp), intent(inout) :: x(nw, 3), a(nw), rates(nw)
      real(wp) :: along(3), across(3), start
      integer :: k
      start = radau_c(i)*h
      along = h*radau_a(i, :)
      across = radau_inverse(i, :)/h
      do k = 1, nw
         x(k, i) = start*w(k) + along(1)*z(k, 1) + along(2)*z(k, 2) + along(3)*z(k, 3)
         a(k) = across(1)*z(k, 1) + across(2)*z(k, 2) + across(3)*z(k, 3)
         rates(k) = w(k) + z(k, i)
      end do
   end subroutine add_stages

   !> One Newton change of stages and multipliers; its size in units of the scales.
   subroutine newton_change(self, system, largest)
      class(radau_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      real(wp), intent(out) :: largest
      integer :: k, nw
      real(wp) :: change(3), shift(3)
      nw = system%layout%nw
      call transform(nw, self%motion, self%real_part, self%complex_part)
      call transform(system%nc, self%rate, self%real_part(nw + 1:), self%complex_part(nw + 1:))
      call self%tangent%matrix%solve(self%real_part)
      call self%tangent%matrix%solve_complex(self%complex_part)
      largest = 0.0_wp
      do k = 1, nw
         change = changes_of(self%real_part(k), self%complex_part(k))
         shift = radau_a(:, 1)*change(1) + radau_a(:, 2)*change(2) + radau_a(:, 3)*change(3)
         self%z(k, :) = self%z(k, :) + change
         self%x(k, :) = self%x(k, :) + self%h*shift
         largest = largest + (change(1)**2 + change(2)**2 + change(3)**2)*(1/self%scale_w(k)**2 + (self%h/self%scale_x(k))**2)
      end do
      do k = 1, system%nc
         self%multipliers(k, :) = self%multipliers(k, :) + changes_of(self%real_part(nw + k), self%complex_part(nw + k))
      end do
      largest = sqrt(largest/3)
   end subroutine newton_change

   !> Right-hand sides of the real and the complex equations from the residuals of the stages.
   pure subroutine transform(n, residual, real_part, complex_part)
      integer, intent(in) :: n
      real(wp), intent(in) :: residual(n, 3)
      real(wp), intent(inout) :: real_part(n)
      complex(wp), intent(inout) :: complex_part(n)
      integer :: k
      do k = 1, n
         real_part(k) = -(radau_ti(1, 1)*residual(k, 1) + radau_ti(1, 2)*residual(k, 2) + radau_ti(1, 3)*residual(k, 3))
         complex_part(k) = -cmplx(radau_ti(2, 1)*residual(k, 1) + radau_ti(2, 2)*residual(k, 2) + radau_ti(2, 3)*residual(k, 3), &
            & radau_ti(3, 1)*residual(k, 1) + radau_ti(3, 2)*residual(k, 2) + radau_ti(3, 3)*residual(k, 3), wp)
      end do
   end subroutine transform

   !> Changes of the three stages from the solutions of the real and the complex equations.
   pure function changes_of(real_part, complex_part) result(change)
      real(wp), intent(in) :: real_part
      complex(wp), intent(in) :: complex_part
      real(wp) :: change(3)
      change = radau_t(:, 1)*real_part + radau_t(:, 2)*real(complex_part, wp) + radau_t(:, 3)*aimag(complex_part)
   end function changes_of

   !> Local error of the step in units of the scales: difference from an embedded formula of order 3, filtered.
   subroutine estimate_error(self, system, work, err)
      class(radau_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(out) :: err
      real(wp) :: of_rates
      integer :: i, nw
      nw = system%layout%nw
      ! real_part: what the stages and the beginning leave of x' (then of M w')
      self%stage_a = self%w
      self%e = self%a
      do i = 1, 3
         self%stage_a = self%stage_a + radau_weights(i)/self%h*self%x(:, i)
         self%e = self%e + radau_weights(i)/self%h*self%z(:, i)
      end do
      self%real_part = 0.0_wp
      call times_mass(system, self%tangent, 1.0_wp, self%e, self%real_part(:nw))
      call times_stiffness(system, self%tangent, -self%h/gamma, self%stage_a, self%real_part(:nw))
      call self%tangent%matrix%solve(self%real_part)
      self%e = self%h/gamma*(self%stage_a + self%real_part(:nw))
      err = sum((self%e/self%scale_x)**2)
      of_rates = sum((self%real_part(:nw)/self%scale_w)**2)
      if (of_rates > err .and. self%lasting%usable .and. .not. self%speeds_asked) &
         & call weigh_rates(self, system, work, err + of_rates, of_rates)
      err = sqrt(err + of_rates)
      if (.not. err <= huge(err)) err = huge(err)
   end subroutine estimate_error

   !> Takes from the error of the rates what does not last, where the step is short beside what the motion would need, eq. (5.16).
   subroutine weigh_rates(self, system, work, whole, of_rates)
      class(radau_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Squares, in units of the scales, of the whole error and of that of the rates
      real(wp), intent(in) :: whole
      real(wp), intent(inout) :: of_rates
      real(wp), parameter :: short = 3.0_wp, needless = 1.0e-2_wp, much = 0.1_wp
      integer, parameter :: pause = 20
      real(wp) :: tau, weighed
      logical :: found, pays
      integer :: nw
      nw = system%layout%nw
      tau = motion_time(system, self%scales)
      if (whole <= bound(self)**2) then
         self%rest = self%rest - 1
         if (self%rest > 0 .or. whole <= (needless*bound(self))**2 .or. self%h > short*tau*bound(self)**0.25_wp) return
      end if
      call self%lasting%find(system, work, self%tangent, self%t, self%q, self%v, tau, self%real_part(:nw), found)
      if (.not. found) return
      weighed = sum((self%lasting%part(:nw)/self%scale_w)**2) &
         & + tau**2*abs(sum(self%real_part(:nw)*self%lasting%part(:nw)/self%scale_x**2))
      pays = whole - of_rates + weighed < much*whole
      if (pays) of_rates = weighed
      self%rest = merge(0, pause, pays)
   end subroutine weigh_rates

   !> Factor for the next step from the error and, after an accepted step, from how the error has changed.
   real(wp) function next_factor(self, err, careful) result(factor)
      class(radau_type), intent(in) :: self
      real(wp), intent(in) :: err
      logical, intent(in) :: careful
      real(wp) :: safety, ratio
      safety = 0.9_wp*(2*most_iterations + 1)/(2*most_iterations + self%iterations)
      ratio = max(err/bound(self), 1.0e-8_wp)
      factor = safety*ratio**(-0.25_wp)
      if (err <= bound(self) .and. self%h_accepted > 0.0_wp) factor = min(factor, &
         & safety*self%h/self%h_accepted*(self%error_last/bound(self)/ratio**2)**0.25_wp)
      factor = max(0.2_wp, min(8.0_wp, newton_factor(self), factor))
      if (careful) factor = min(factor, 1.0_wp)
   end function next_factor

   !> Growth of the step that Newton's method can follow after it has failed: its contraction grows with the step, and where it has
   !> failed it fails again soon after, eq. (5.10).
   pure real(wp) function newton_factor(self) result(factor)
      class(radau_type), intent(in) :: self
      real(wp), parameter :: slow = 0.2_wp, part = 0.6_wp
      factor = huge(factor)
      if (.not. self%h_failed > 0.0_wp) return
      factor = max(1.0_wp, part*self%h_failed/self%h)
      if (self%iterations > 2) factor = min(factor, max(1.0_wp, (slow/max(self%contraction, tiny(factor)))**(1.0_wp/3)))
   end function newton_factor

   !> Takes the last stage as the new state, restores the constraints, evaluates there.
   subroutine accept(self, system, work, stop, accepted, error)
      class(radau_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: stop
      !> False if the constraints cannot be met
      logical, intent(out) :: accepted
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: residual, t
      t = self%t + self%h
      if (self%h >= stop - self%t) t = stop
      call place_stage(self, system, 3)
      call self%add_lost(self%x(:, 3), self%stage_q)
      self%q_stage_end = self%stage_q
      call settle(system, work, t, self%stage_q, self%stage_v, self%change, .false., residual, error)
      if (allocated(error)) return
      accepted = residual <= constraint_limit
      if (.not. accepted) return
      self%statistics%position_residual = max(self%statistics%position_residual, residual)
      self%increment = self%x(:, 3)
      call add_projection(system%layout, merge(64*epsilon(t), 0.0_wp, self%h < 1.0e-9_wp*self%duration), self%q_stage_end, &
         & self%stage_q, self%scale_x, self%increment)
      self%q_before = self%q
      self%w_before = self%w
      self%a_before = self%a_end
      self%a_end = (radau_inverse(3, 1)*self%z(:, 1) + radau_inverse(3, 2)*self%z(:, 2) + radau_inverse(3, 3)*self%z(:, 3))/self%h
      if (system%powered) call self%input%accept(self%h, self%stage_power(3))
      self%t_before = self%t
      self%t = t
      self%q = self%stage_q
      self%v = self%stage_v
      call self%take_over(system, work)
      self%e = bound(self)/self%h**2*self%scale_x
      where (abs(self%a - self%a_end) <= self%e) self%a_end = self%a
      self%a_shown(:, 1) = self%a_before
      self%a_shown(:, 2) = self%a_end
      if (.not. self%h_accepted > 0.0_wp) call relax_ends(self%h, self%z, self%a, self%e, self%w_before, self%a_shown(:, 1), &
         & self%a_shown(:, 2))
   end subroutine accept

   !> After Newton's method has failed: passes a fold if there is one ahead, else shortens the step.
   subroutine cross_fold(self, system, work, stop, passed)
      class(radau_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: stop
      logical, intent(out) :: passed
      real(wp) :: away
      call self%pass_fold(system, work, stop, away, passed)
      if (away > 0.0_wp) then
         self%h_factors = 0.0_wp
         self%fresh = .false.
      end if
      if (passed) then
         self%a_before = self%a_end
         self%a_end = self%a
         self%a_shown(:, 1) = self%a_before
         self%a_shown(:, 2) = self%a_end
      else if (away > 0.0_wp) then
         self%h = min(0.5_wp*self%h, 0.4_wp*away)
      else
         self%h_failed = self%h
         self%h = 0.5_wp*self%h
      end if
   end subroutine cross_fold

   !> Quintic through coordinates, rates and accelerations at both ends of the step; its derivative for the rates.
   subroutine radau_interpolate(self, t, q, v, w)
      class(radau_type), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), contiguous, intent(out) :: q(:), v(:)
      real(wp), intent(out) :: w
      real(wp) :: h, s
      h = self%t - self%t_before
      if (.not. h > 0.0_wp) then
         q = self%q
         v = self%v
         w = self%input%done
         return
      end if
      s = (t - self%t_before)/h
      h = self%length_of_step()
      call quintic_state(self%layout, s, h, self%q_before, self%increment, self%w_before, self%w, self%a_shown(:, 1), &
         & self%a_shown(:, 2), self%stage_a, self%e, q, v)
      w = self%input%within(s)
   end subroutine radau_interpolate

   !> Second derivative of the quintic. The pace is that of the real equation of a step.
   subroutine radau_accelerations(self, t, a, pace)
      class(radau_type), intent(in) :: self
      real(wp), intent(in) :: t
      real(wp), contiguous, intent(inout) :: a(:)
      real(wp), intent(out) :: pace
      real(wp) :: h
      pace = 0.0_wp
      h = self%t - self%t_before
      if (.not. h > 0.0_wp) return
      pace = gamma/self%length_of_step()
      call quintic_accelerations((t - self%t_before)/h, self%length_of_step(), self%increment, self%w_before, self%w, &
         & self%a_shown(:, 1), self%a_shown(:, 2), a)
   end subroutine radau_accelerations

   subroutine radau_interpolate_place(self, t, q, v, w)
      class(radau_type), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), contiguous, intent(inout) :: q(:), v(:)
      real(wp), intent(inout) :: w
      real(wp) :: h, s
      h = self%t - self%t_before
      if (self%input%asked .or. .not. h > 0.0_wp) then
         call self%interpolate(t, q, v, w)
         return
      end if
      s = (t - self%t_before)/h
      call quintic_place(self%layout, s, self%length_of_step(), self%q_before, self%increment, self%w_before, self%w, &
         & self%a_shown(:, 1), self%a_shown(:, 2), self%stage_a, q)
   end subroutine radau_interpolate_place

   !> Saves or restores its memory.
   subroutine exchange_radau(self, snapshot, system)
      class(radau_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      type(system_type), intent(in) :: system
      call self%exchange_implicit(snapshot, system, .true.)
      call self%lasting%exchange(snapshot)
      call snapshot%keep('a_before', self%a_before)
      call snapshot%keep('a_end', self%a_end)
      call snapshot%keep('a_shown', self%a_shown)
      call snapshot%keep('z', self%z)
      call snapshot%keep('x', self%x)
      call snapshot%exchange('stage_power', self%stage_power)
      call snapshot%keep('real_part', self%real_part)
      call snapshot%exchange('error_last', self%error_last)
      call snapshot%exchange('h_accepted', self%h_accepted)
      call snapshot%exchange('h_failed', self%h_failed)
      call snapshot%exchange('rest', self%rest)
      call snapshot%exchange('contraction', self%contraction)
      call snapshot%exchange('current', self%current)
      ! Not saved: multipliers, motion, rate, stage_q, stage_v, stage_a, e, q_stage_end, complex_part
   end subroutine exchange_radau

end module limber_integrator_radau
