!> ALPHA: generalised alpha of order 2. Generalised-alpha of order 2 with a chosen spectral radius at infinity, on the equations of
!> index 2: motion and velocity constraints at the end of the step, the position constraints restored by projection after it.
!> Variable step by the local error, filtered so that vibrations which the step does not resolve do not bind it. Floor: integrator.
!> Source: Chung and Hulbert, J. Appl. Mech. 60 (1993) 371; Arnold and Bruels, Multibody System Dynamics 18 (2007) 185; doc/theory,
!> eqs. (5.17)-(5.19).
module limber_integrator_alpha
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_base_error, only: error_type
   use limber_integrator_cubic_output, only: cubic_state
   use limber_integrator_implicit, only: implicit_type
   use limber_integrator_integrator, only: constraint_limit
   use limber_integrator_error_scales, only: energy_scale
   use limber_multibody_equations_of_motion, only: accelerations, input_power
   use limber_multibody_articulated, only: articulated_type, new_forest, forest_solve
   use limber_multibody_articulated_factors, only: forest_factor
   use limber_multibody_articulated_motion, only: forest_residual, forest_settle, forest_times_mass, forest_power
   use limber_multibody_layout, only: rates_of, velocities_of, advance
   use limber_multibody_motion_residual, only: motion_residual, place_motion
   use limber_multibody_projection, only: settle
   use limber_multibody_system, only: system_type, workspace_type
   use limber_multibody_tangent, only: combine, give_way
   use limber_multibody_tangent_products, only: times_mass
   implicit none
   private
   public :: alpha_type

   integer, parameter :: most_iterations = 8

   !> Memory of the method
   type, extends(implicit_type) :: alpha_type
      !> Spectral radius at infinity: 1 damps nothing, 0 all that is not resolved
      real(wp) :: radius = 0.8_wp
      !> Coefficients that follow from it
      real(wp) :: alpha_m = 0.0_wp, alpha_f = 0.0_wp, beta = 0.0_wp, gamma = 0.0_wp
      !> Accelerations of the algorithm, and the slope of the accelerations over the last step (nw)
      real(wp), allocatable :: algorithmic(:), jerk(:)
      !> The step that is tried
      real(wp), allocatable :: new_q(:), new_v(:), new_w(:), new_a(:), new_algorithmic(:), new_lambda(:), x(:)
      !> Power put in at the end of the step that is tried
      real(wp) :: new_power = 0.0_wp
      !> Scratch
      real(wp), allocatable :: motion(:), rate(:), unknown(:), e(:)
      !> Where bodies on pins close no loop and stand on the ground: takes the place of the tangent and of the multiplier system
      type(articulated_type) :: forest
   contains
      procedure :: start => alpha_start
      procedure :: step => alpha_step
      procedure :: interpolate => alpha_interpolate
      procedure :: exchange => exchange_alpha
   end type alpha_type

contains

   subroutine alpha_start(self, system, work, t, duration, q, v, error)
      class(alpha_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t, duration
      real(wp), intent(in) :: q(:), v(:)
      type(error_type), allocatable, intent(out) :: error
      self%alpha_m = (2*self%radius - 1)/(self%radius + 1)
      self%alpha_f = self%radius/(self%radius + 1)
      self%gamma = 0.5_wp + self%alpha_f - self%alpha_m
      self%beta = 0.25_wp*(self%gamma + 0.5_wp)**2
      if (.not. allocated(self%new_q)) then
         associate (nq => system%layout%nq, nw => system%layout%nw, nc => system%nc)
            allocate (self%algorithmic(nw), self%jerk(nw), self%new_q(nq), self%new_v(nq), self%new_w(nw), self%new_a(nw), &
               & self%new_algorithmic(nw), self%new_lambda(nc), self%x(nw), self%motion(nw), self%rate(nc), self%unknown(nw + nc), &
               & self%e(nw))
         end associate
         call new_forest(system, self%forest)
         if (.not. (self%forest%usable .and. self%forest%grounded)) call leave_forest(self, system)
      end if
      call self%begin(system, work, t, duration, q, v, error)
      if (allocated(error)) return
      self%algorithmic = self%a
      self%jerk = 0.0_wp
      call self%begin_step_size(duration, 0.1_wp*self%tolerance**(1.0_wp/3))
      ! At rest where a load is about to begin nothing says how soon
      if (system%powered) self%h = min(self%h, 1.0e-3_wp*duration)
   end subroutine alpha_start

   subroutine alpha_step(self, system, work, stop, error)
      class(alpha_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: stop
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: wanted, err, factor
      logical :: good, repeated
      integer :: i, failures
      wanted = self%h
      err = self%tolerance
      repeated = .false.
      failures = 0
      do
         if (self%maximum_step > 0.0_wp) self%h = min(self%h, self%maximum_step)
         if (self%fixed_step > 0.0_wp .and. .not. repeated) self%h = self%fixed_step
         if (self%t + 1.0001_wp*self%h > stop) self%h = stop - self%t
         if (self%h <= self%least_step(stop)) then
            if (self%forest%usable) call place_motion(system, work, self%t, self%q, self%v)
            i = maxloc(abs(self%e)/self%scale_w, dim=1)
            call self%step_too_small(system, work, count(system%layout%w <= i), error)
            return
         end if
         call prepare(self, system, work, error)
         if (allocated(error)) return
         call iterate(self, system, work, min(self%t + self%h, stop), good)
         if (.not. good) call self%heed_failure(failures)
         if (.not. good .and. .not. self%forest%usable) then
            call cross_fold(self, system, work, stop, good)
            if (good) then
               self%statistics%rejected = self%statistics%rejected + 1
               repeated = .true.
               factor = wanted/self%h
               exit
            end if
         end if
         if (good) then
            err = 0.0_wp
            if (.not. self%fixed_step > 0.0_wp) call estimate_error(self, system, err)
            good = err <= self%tolerance .or. self%fixed_step > 0.0_wp
            if (good) call close_step(self, system, work, stop, good, err, error)
            if (allocated(error)) return
            factor = max(0.2_wp, min(1.6_wp, 0.8_wp*(self%tolerance/max(err, 1.0e-6_wp*self%tolerance))**(1.0_wp/3)))
            if (.not. good) factor = min(factor, 0.9_wp)
         else
            factor = 0.5_wp
         end if
         if (good) then
            call accept(self, system, stop)
            exit
         end if
         self%statistics%rejected = self%statistics%rejected + 1
         self%h = self%h*min(factor, 0.9_wp)
         repeated = .true.
      end do
      call self%ringing%note(system, self%h, self%a, 1.0_wp/12 + 0.5_wp*abs(self%alpha_m - self%alpha_f), 3)
      call self%count_step(self%h, 2, 8*err < self%tolerance)
      self%h_last = self%h
      if (repeated) factor = min(factor, 1.0_wp)
      ! A step that would hardly change is kept
      if (factor < 0.95_wp .or. factor > 1.2_wp) self%h = self%h*factor
      if (self%t >= stop .and. .not. repeated) self%h = max(self%h, wanted)
      self%fresh = .false.
      call self%renew_scales(system)
   end subroutine alpha_step

   !> Sparse matrices in the place of the trees.
   subroutine leave_forest(self, system)
      class(alpha_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      self%forest%usable = .false.
      call self%use_sparse(system)
   end subroutine leave_forest

   !> Factors of the Newton matrix at the present state and for the present step.
   subroutine prepare(self, system, work, error)
      class(alpha_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(error_type), allocatable, intent(out) :: error
      logical :: singular
      if (self%forest%usable .and. abs(self%h - self%h_factors) > 0.0_wp) then
         call forest_factor(self%forest, system%model, self%q, self%w, self%a, self%lambda, mass_factor(self), &
            & self%h*self%beta/self%gamma, singular)
         if (.not. self%fresh) self%statistics%jacobians = self%statistics%jacobians + 1
         self%statistics%factorisations = self%statistics%factorisations + 1
         self%fresh = .not. singular
         self%h_factors = self%h
         ! Where the trees lose a pivot, sparse factors look for others
         if (singular) call leave_forest(self, system)
      end if
      if (self%forest%usable) return
      if (.not. self%fresh) call self%refresh(system, work)
      if (abs(self%h - self%h_factors) > 0.0_wp) call factor_matrix(self, system, work, error)
   end subroutine prepare

   !> Factors of the Newton matrix for the present step.
   subroutine factor_matrix(self, system, work, error)
      class(alpha_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(error_type), allocatable, intent(out) :: error
      logical :: singular
      self%tangent%softness = 1/mass_factor(self)
      call combine(self%tangent, mass_factor(self), 1.0_wp, self%h*self%beta/self%gamma, self%h*self%beta/self%gamma)
      call self%tangent%matrix%factor(singular)
      self%statistics%factorisations = self%statistics%factorisations + 1
      self%h_factors = self%h
      if (singular) call self%singular_matrix(system, work, 'ALPHA', error)
   end subroutine factor_matrix

   !> Change of the accelerations for a unit change of the rates.
   pure real(wp) function mass_factor(self)
      class(alpha_type), intent(in) :: self
      mass_factor = (1 - self%alpha_m)/((1 - self%alpha_f)*self%gamma*self%h)
   end function mass_factor

   !> Newton iteration for the end of the step.
   subroutine iterate(self, system, work, t, converged)
      class(alpha_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      logical, intent(out) :: converged
      real(wp) :: size_now, size_last, ratio, goal
      integer :: round, nw
      nw = system%layout%nw
      converged = .false.
      goal = max(1.0e-14_wp, self%strictness*self%tolerance*min(0.03_wp, sqrt(self%tolerance)))
      ! The accelerations of the algorithm belong to a time that depends on the step
      self%e = self%algorithmic + (self%alpha_m - self%alpha_f)*(self%h - self%h_last)*self%jerk
      self%new_a = self%a + self%h*self%jerk
      self%new_lambda = self%lambda
      size_last = 0.0_wp
      do round = 1, most_iterations
         self%iterations = round
         self%new_algorithmic = ((1 - self%alpha_f)*self%new_a + self%alpha_f*self%a - self%alpha_m*self%e)/(1 - self%alpha_m)
         self%x = self%h*self%w + self%h**2*((0.5_wp - self%beta)*self%e + self%beta*self%new_algorithmic)
         self%new_w = self%w + self%h*((1 - self%gamma)*self%e + self%gamma*self%new_algorithmic)
         call advance(system%layout, self%q, self%x, self%new_q)
         if (converged .or. .not. self%forest%usable) call velocities_of(system%layout, self%new_q, self%new_w, self%new_v)
         if (converged) return
         if (self%forest%usable) then
            call forest_residual(self%forest, system%model, self%new_q, self%new_w, self%new_a, self%new_lambda, self%motion, &
               & self%rate)
            work%evaluations = work%evaluations + 1
         else
            call motion_residual(system, work, t, self%new_q, self%new_v, self%new_a, self%new_lambda, self%motion, self%rate, &
               & .true.)
            if (system%redundant) call give_way(self%tangent, self%new_lambda, self%rate)
         end if
         self%unknown(:nw) = -self%motion
         self%unknown(nw + 1:) = -self%rate
         call solve(self, self%unknown)
         self%new_a = self%new_a + mass_factor(self)*self%unknown(:nw)
         self%new_lambda = self%new_lambda + self%unknown(nw + 1:)
         size_now = sqrt(sum((self%unknown(:nw)/self%scale_w)**2) + sum((self%h*self%unknown(:nw)/self%scale_x)**2))
         if (.not. size_now <= huge(size_now)) return
         converged = size_now <= goal
         if (round > 1) then
            ratio = size_now/max(size_last, tiny(size_last))
            if (ratio >= 0.99_wp .and. .not. converged) return
            if (ratio < 0.99_wp) converged = converged .or. size_now*ratio/(1 - ratio) <= goal
         end if
         size_last = size_now
      end do
      converged = .false.
   end subroutine iterate

   !> Solves with the factors at hand.
   subroutine solve(self, x)
      class(alpha_type), intent(inout) :: self
      real(wp), contiguous, intent(inout) :: x(:)
      if (self%forest%usable) then
         call forest_solve(self%forest, x)
      else
         call self%tangent%matrix%solve(x)
      end if
   end subroutine solve

   !> product = product + M vector mass_factor at the present state.
   subroutine add_mass(self, system, vector, product)
      class(alpha_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      real(wp), contiguous, intent(in) :: vector(:)
      real(wp), contiguous, intent(inout) :: product(:)
      if (self%forest%usable) then
         call forest_times_mass(self%forest, system%model, self%q, mass_factor(self), vector, product)
      else
         call times_mass(system, self%tangent, mass_factor(self), vector, product)
      end if
   end subroutine add_mass

   !> Local error in units of the scales: the next terms of the series, through the Newton matrix, which lets pass what the
   !> step resolves.
   subroutine estimate_error(self, system, err)
      class(alpha_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      real(wp), intent(out) :: err
      integer :: nw
      real(wp) :: factor_x, factor_w
      nw = system%layout%nw
      factor_x = abs(self%beta - 1.0_wp/6 + 0.5_wp*(self%alpha_m - self%alpha_f))
      factor_w = 1.0_wp/12 + 0.5_wp*abs(self%alpha_m - self%alpha_f)
      self%unknown = 0.0_wp
      self%e = factor_x*self%h**2*(self%new_a - self%a)
      call add_mass(self, system, self%e, self%unknown(:nw))
      call solve(self, self%unknown)
      err = sum((self%unknown(:nw)/self%scale_x)**2)
      self%unknown = 0.0_wp
      self%e = factor_w*self%h*(self%new_a - self%a - self%h*self%jerk)
      call add_mass(self, system, self%e, self%unknown(:nw))
      call solve(self, self%unknown)
      err = sqrt(err + sum((self%unknown(:nw)/self%scale_w)**2))
      if (.not. err <= huge(err)) err = huge(err)
   end subroutine estimate_error

   !> Restores the constraints at the end of a step; the work put in, whose error must be as small as that of the motion.
   subroutine close_step(self, system, work, stop, good, err, error)
      class(alpha_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: stop
      !> False if the constraints cannot be met, or the work is not exact enough
      logical, intent(out) :: good
      !> Error estimate of the motion, raised to that of the work if this is larger
      real(wp), intent(inout) :: err
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: residual, own
      if (self%forest%usable) then
         call forest_settle(self%forest, self%new_q, self%new_v)
         self%h_factors = 0.0_wp
         residual = 0.0_wp
      else
         call settle(system, work, end_of_step(self, stop), self%new_q, self%new_v, self%change, .false., residual, error)
         if (allocated(error)) return
      end if
      good = residual <= constraint_limit
      if (.not. good) return
      self%statistics%position_residual = max(self%statistics%position_residual, residual)
      call rates_of(system%layout, self%new_q, self%new_v, self%new_w)
      if (.not. system%powered) return
      if (self%forest%usable) then
         self%new_power = forest_power(self%forest, system%model, self%new_q, self%new_w)
      else
         call accelerations(system, work, self%new_q, self%new_v, self%change)
         self%new_power = input_power(system, work, self%new_q, self%new_v)
      end if
      call self%input%try_ends(self%h, self%new_power, energy_scale(system, self%scales), own)
      if (self%fixed_step > 0.0_wp) return
      own = own*self%tolerance/self%input%allowed(self%tolerance)
      good = self%input%is_within(own, self%tolerance)
      if (.not. (good .and. own > self%tolerance)) err = max(err, own)
   end subroutine close_step

   !> Time at the end of the step that is tried.
   pure real(wp) function end_of_step(self, stop) result(t)
      class(alpha_type), intent(in) :: self
      real(wp), intent(in) :: stop
      t = self%t + self%h
      if (self%h >= stop - self%t) t = stop
   end function end_of_step

   !> Takes the step.
   subroutine accept(self, system, stop)
      class(alpha_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: stop
      self%q_before = self%q
      self%w_before = self%w
      self%increment = self%x
      self%t_before = self%t
      self%t = end_of_step(self, stop)
      self%q = self%new_q
      self%v = self%new_v
      self%w = self%new_w
      self%jerk = (self%new_a - self%a)/self%h
      self%a = self%new_a
      self%algorithmic = self%new_algorithmic
      self%lambda = self%new_lambda
      if (system%powered) call self%input%accept(self%h, self%new_power)
   end subroutine accept

   !> After Newton's method has failed: passes a fold if there is one ahead.
   subroutine cross_fold(self, system, work, stop, passed)
      class(alpha_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: stop
      logical, intent(out) :: passed
      real(wp) :: away
      self%new_a = self%a
      call self%pass_fold(system, work, stop, away, passed)
      if (.not. passed) return
      self%jerk = (self%a - self%new_a)/self%h
      self%algorithmic = self%a + (self%alpha_m - self%alpha_f)*self%h*self%jerk
   end subroutine cross_fold

   !> Cubic through coordinates and rates at both ends of the step; its derivative for the rates.
   subroutine alpha_interpolate(self, t, q, v, w)
      class(alpha_type), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), contiguous, intent(out) :: q(:), v(:)
      real(wp), intent(out) :: w
      real(wp) :: h, s
      h = self%t - self%t_before
      if (.not. h > 0.0_wp .or. t >= self%t) then
         q = self%q
         v = self%v
         w = self%input%done
         return
      end if
      s = (t - self%t_before)/h
      h = self%length_of_step()
      call cubic_state(self%layout, s, h, self%q_before, self%increment, self%w_before, self%w, self%e, q, v)
      w = self%input%within(s)
   end subroutine alpha_interpolate

   !> Saves or restores its memory.
   subroutine exchange_alpha(self, snapshot, system)
      class(alpha_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      type(system_type), intent(in) :: system
      logical :: usable
      usable = self%forest%usable
      call snapshot%exchange('usable', usable)
      if (self%forest%usable .and. .not. usable) call leave_forest(self, system)
      call self%exchange_implicit(snapshot, system, .not. self%forest%usable)
      call self%forest%exchange(snapshot)
      call snapshot%keep('algorithmic', self%algorithmic)
      call snapshot%keep('jerk', self%jerk)
      call snapshot%keep('new_q', self%new_q)
      call snapshot%keep('new_v', self%new_v)
      call snapshot%keep('new_w', self%new_w)
      call snapshot%keep('new_a', self%new_a)
      call snapshot%keep('new_algorithmic', self%new_algorithmic)
      call snapshot%keep('new_lambda', self%new_lambda)
      call snapshot%keep('x', self%x)
      call snapshot%keep('motion', self%motion)
      call snapshot%keep('rate', self%rate)
      call snapshot%keep('unknown', self%unknown)
      call snapshot%keep('e', self%e)
      ! Not saved: radius, alpha_m, alpha_f, beta, gamma, new_power
   end subroutine exchange_alpha

end module limber_integrator_alpha
