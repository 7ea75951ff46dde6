!> CONSERVING: energy-momentum scheme of order 2. By discrete gradients energy less work put in, and linear and angular momentum
!> where the scene keeps them, are constant to round-off at any step; the position constraints hold at the end of every step, with
!> one set of multipliers for a step (index 3). Its velocities meet the velocity constraints in the mean of a step only; where
!> drivers move the scene they are brought onto them at the end of each step, at the cost of their work, eq. (5.33). Floor:
!> integrator. Source: Simo and Tarnow, ZAMP 43 (1992) 757; Gonzalez, J. Nonlinear Sci. 6 (1996) 449; doc/theory, eqs.
!> (5.21)-(5.27), (5.31).
module limber_integrator_conserving
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_base_error, only: error_type
   use limber_integrator_cubic_output, only: cubic_state
   use limber_integrator_integrator, only: integrator_type, even_step
   use limber_integrator_mean_rates, only: means_type, new_means, begin_means, predict, find_curvature, note_mean, largest_change
   use limber_integrator_error_scales, only: scales_type, new_scales, update_scales, rate_scales, energy_scale, find_grain
   use limber_multibody_discrete_motion, only: step_residual, linearise_step, step_work
   use limber_multibody_equations_of_motion, only: linearise, accelerations
   use limber_multibody_articulated, only: articulated_type, new_forest, forest_solve
   use limber_multibody_articulated_step, only: begin_forest_step, forest_step_residual, forest_step_factor, forest_step_mass
   use limber_model_model, only: ground
   use limber_multibody_kinematics, only: place_frames, move_frames
   use limber_multibody_load, only: load_type
   use limber_multibody_layout, only: layout_type, rates_of, velocities_of
   use limber_multibody_projection, only: project_velocity
   use limber_multibody_discrete_step, only: discrete_step_type, new_step, begin_step, find_momenta, frame_rates, fixed_rates
   use limber_multibody_system, only: system_type, workspace_type
   use limber_multibody_tangent, only: tangent_type, new_tangent, give_way
   use limber_multibody_tangent_products, only: times_mass
   implicit none
   private
   public :: conserving_type

   integer, parameter :: most_iterations = 20
   !> Number of rates above which round-off of the corrections grows with it
   real(wp), parameter :: many_rates = 200.0_wp
   !> Largest ratio of successive corrections that the factors at hand may give, relative change of the step that they may serve,
   !> the correction that is too small to matter, and the one at which no progress, a ratio so large, counts as round-off, or that
   !> in units of the round-off of places: what is stiff multiplies it; part of the tolerance that counts as round-off where so
   !> many corrections in a row make no progress, and at most: what bends much for little force multiplies it more; and the
   !> corrections, in units of the round-off of coordinates, eq. (5.30), that count as round-off there
   real(wp), parameter :: slow = 0.05_wp, same_step = 1.0e-3_wp, negligible = 1.0e-18_wp, small_correction = 1.0e-9_wp, &
      & no_progress = 0.5_wp, stiff = 200.0_wp, part_of_tolerance = 0.01_wp, most_noise = 1.0e-7_wp, grains = 50.0_wp
   integer, parameter :: stalled = 4

   !> Memory of the method
   type, extends(integrator_type) :: conserving_type
      !> Coordinates and velocities at t (nq); rates in the axes of the frames (nw); increments of the step (nw); multipliers (nc)
      real(wp), allocatable :: q(:), v(:), b(:), y(:), lambda(:)
      !> Coordinates (nq) and rates (nw) at the beginning of the last step, its increment (nw), and rates at its end (nw), all in
      !> the fixed axes
      real(wp), allocatable :: q_before(:), w_before(:), increment(:), w(:)
      !> Rates at the end of the step that is tried, in the fixed axes (nw); a state between its ends (nq)
      real(wp), allocatable :: new_w(:), path_q(:), path_v(:)
      !> Of the last two steps
      type(means_type) :: means
      !> Scratch
      real(wp), allocatable :: motion(:), phi(:), unknown(:), e(:), change(:)
      !> Impulses of laws along the way that the forces of the step that is tried do not give (nw)
      real(wp), allocatable :: missed(:)
      !> Multipliers under which redundant constraints do not give way, and how far those of the step differ (nc)
      real(wp), allocatable :: held(:), apart(:)
      type(discrete_step_type) :: trial
      type(tangent_type) :: tangent
      !> Where bodies on pins close no loop: takes the place of the tangent
      type(articulated_type) :: forest
      type(layout_type) :: layout
      type(scales_type) :: scales
      !> Scales of coordinates and rates in the layout of the rates (nw)
      real(wp), allocatable :: scale_x(:), scale_w(:)
      !> Changes of the coordinates in the layout of the rates that move places by round-off, eq. (5.30) (nw)
      real(wp), allocatable :: grain(:)
      !> Impulses of the multipliers that change the momenta much (nc)
      real(wp), allocatable :: scale_lambda(:)
      !> Largest coordinate of a place, or the length of the scene [length]
      real(wp) :: reach = 0.0_wp
      !> Next step, step of the factors at hand, what t is above the sum of all steps
      real(wp) :: h = 0.0_wp, h_factors = 0.0_wp, rounding = 0.0_wp
      !> Whether a constraint moves in time
      logical :: driven = .false.
   contains
      procedure :: start => conserving_start
      procedure :: step => conserving_step
      procedure :: resume => conserving_resume
      procedure :: interpolate => conserving_interpolate
      procedure :: exchange => exchange_conserving
   end type conserving_type

contains

   subroutine conserving_start(self, system, work, t, duration, q, v, error)
      class(conserving_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t, duration
      real(wp), intent(in) :: q(:), v(:)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: slope
      integer :: nq, nw, nc, i
      nq = system%layout%nq
      nw = system%layout%nw
      nc = system%nc
      if (.not. allocated(self%q)) then
         allocate (self%q(nq), self%v(nq), self%b(nw), self%y(nw), self%lambda(nc), self%q_before(nq), self%w_before(nw), &
            & self%increment(nw), self%w(nw), self%motion(nw), self%phi(nc), self%unknown(nw + nc), self%e(nw), self%change(nq), &
            & self%scale_x(nw), self%scale_w(nw), self%scale_lambda(nc), self%new_w(nw), self%path_q(nq), self%path_v(nq), &
            & self%held(nc), self%apart(nc), self%grain(nw), self%missed(nw))
         call new_means(nw, nc, self%means)
         call new_forest(system, self%forest)
         if (.not. self%forest%usable) call new_tangent(system, self%tangent)
         if (self%forest%usable .and. .not. self%fixed_step > 0.0_wp) allocate (self%forest%masses, source=self%forest%block)
         call new_step(system, work, self%trial)
         self%scales = new_scales(system, duration, .true.)
         do i = 1, size(system%constraints)
            self%driven = self%driven .or. system%constraints(i)%item%driven
         end do
      end if
      self%missed = 0.0_wp
      call self%input%begin(self%work_at_start, 0.0_wp)
      call self%ringing%forget()
      self%h_factors = 0.0_wp
      self%rounding = 0.0_wp
      self%q = q
      self%v = v
      self%t = t
      self%t_before = t
      self%ends_on_samples = .true.
      self%sees_inside = .true.
      self%layout = system%layout
      call find_scales(self, system)
      call linearise(system, work, t, q, error)
      if (allocated(error)) return
      call accelerations(system, work, q, v, self%change)
      call rates_of(system%layout, q, v, self%w)
      call rates_of(system%layout, q, self%change, self%e)
      self%q_before = q
      self%w_before = self%w
      self%increment = 0.0_wp
      self%unknown = 0.0_wp
      slope = sqrt(sum((self%w/self%scale_x)**2) + sum((self%e/self%scale_w)**2))
      self%h = duration
      if (slope*self%h > 0.1_wp*self%tolerance**(1.0_wp/3)) self%h = 0.1_wp*self%tolerance**(1.0_wp/3)/slope
      if (self%initial_step > 0.0_wp) self%h = self%initial_step
      call frame_rates(system%layout, q, self%w, self%b)
      call frame_rates(system%layout, q, self%e, self%motion)
      call begin_means(self%means, system%layout, t, self%h, self%b, self%motion, work%lambda)
   end subroutine conserving_start

   !> The next step is as long as it was to be.
   subroutine conserving_resume(self, system, work, duration, q, v, error)
      class(conserving_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: duration, q(:), v(:)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: h
      h = self%h
      call self%start(system, work, self%t, duration, q, v, error)
      self%h = max(self%h, h)
   end subroutine conserving_resume

   subroutine conserving_step(self, system, work, stop, error)
      class(conserving_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: stop
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: h, err, factor
      logical :: good, repeated
      integer :: i, doubts
      repeated = .false.
      doubts = 0
      do
         if (self%maximum_step > 0.0_wp) self%h = min(self%h, self%maximum_step)
         if (self%fixed_step > 0.0_wp .and. .not. repeated) self%h = self%fixed_step
         h = even_step(stop - self%t, self%h)
         if (h <= self%least_step(stop)) then
            if (self%forest%usable) call place_frames(system%model, system%layout, self%t, self%q, work%kinematics)
            i = max(1, maxloc(abs(self%unknown(:system%layout%nw))/self%scale_x, dim=1))
            call self%step_too_small(system, work, count(system%layout%w <= i), error)
            return
         end if
         call begin(self, system, h, merge(stop, self%t + (h - self%rounding), h >= stop - self%t))
         call predict(self%means, system%layout, self%t, h, self%q, .true., self%y, self%lambda)
         call find_end(self, system, work, good)
         if (.not. good) then
            self%h_factors = 0.0_wp
            call predict(self%means, system%layout, self%t, h, self%q, .false., self%y, self%lambda)
            call find_end(self, system, work, good)
         end if
         if (good) then
            err = 0.0_wp
            if (.not. self%fixed_step > 0.0_wp) call estimate_error(self, system, err)
            ! What round-off of places makes of the rates is no error
            good = err <= max(self%tolerance, maxval(self%grain/(h*self%scale_w))) .or. self%fixed_step > 0.0_wp
            if (good) call measure_work(self, system, work, err, good)
            factor = max(0.2_wp, min(1.6_wp, 0.8_wp*(self%tolerance/max(err, 1.0e-6_wp*self%tolerance))**(1.0_wp/3)))
            if (good .and. self%driven) call follow_drivers(self, system, work, doubts, good)
            if (.not. good) factor = min(factor, merge(0.5_wp, 0.9_wp, doubts > 0))
         else
            factor = 0.5_wp
         end if
         if (good) exit
         self%statistics%rejected = self%statistics%rejected + 1
         self%h = h*factor
         repeated = .true.
      end do
      call accept(self, system, stop)
      call self%count_step(h, 2, 8*err < self%tolerance)
      if (repeated) factor = min(factor, 1.0_wp)
      ! A step that would hardly change is kept; one that was cut short by a sample does not count
      if (factor < 0.95_wp) then
         self%h = h*factor
      else if (factor > 1.2_wp) then
         self%h = max(self%h, h*factor)
      end if
      call find_scales(self, system)
   end subroutine conserving_step

   !> Places the start of a step of length h.
   subroutine begin(self, system, h, final)
      class(conserving_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Length, time at the end
      real(wp), intent(in) :: h, final
      if (self%forest%usable) then
         call begin_forest_step(self%forest, system%model, self%trial, self%t, h, final, self%q, self%b)
      else
         call begin_step(system, self%trial, self%t, h, final, self%q, self%b)
      end if
   end subroutine begin

   !> Scales at the present state.
   subroutine find_scales(self, system)
      class(conserving_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      real(wp) :: momentum
      integer :: i
      call update_scales(system, self%q, self%v, self%scales)
      call rate_scales(system, self%scales, self%scale_x, self%scale_w)
      momentum = 0.0_wp
      self%reach = system%model%length
      do i = 1, size(system%model%bodies)
         if (system%layout%carries(i)) cycle
         self%reach = max(self%reach, abs(self%q(system%layout%q(i))), abs(self%q(system%layout%q(i) + 1)))
         momentum = momentum + system%model%bodies(i)%reduced%mass*self%scales%fastest()
      end do
      call find_grain(system, self%reach, self%grain)
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            self%scale_lambda(item%first:item%first + item%rows - 1) = momentum*system%model%length/item%scale
         end associate
      end do
      ! Of redundant constraints the multipliers are known to round-off of the constraints only; the motion does not feel it
      if (system%redundant) self%scale_lambda = huge(1.0_wp)
   end subroutine find_scales

   !> The end of the step. What redundant constraints give way is taken back: under the multipliers found they give way no more,
   !> eq. (4.37). Beside a fold little of it would be much of the reactions.
   subroutine find_end(self, system, work, good)
      class(conserving_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      logical, intent(out) :: good
      integer, parameter :: rounds = 2
      integer :: round
      self%held = 0.0_wp
      call iterate(self, system, work, good)
      if (.not. system%redundant) return
      do round = 1, rounds
         if (.not. good) return
         self%held = self%lambda
         call iterate(self, system, work, good)
      end do
   end subroutine find_end

   !> Newton iteration, down to round-off. The factors at hand serve as long as it is quick.
   subroutine iterate(self, system, work, converged)
      class(conserving_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      logical, intent(out) :: converged
      real(wp) :: size_now, moved, size_last, ratio, noise, least
      integer :: round, nw, idle
      logical :: fresh
      nw = system%layout%nw
      converged = .false.
      fresh = .false.
      if (abs(self%trial%h - self%h_factors) > same_step*self%trial%h) self%h_factors = 0.0_wp
      ! Rounding of one joint moves all that follows in a chain
      noise = epsilon(noise)*max(1.0_wp, self%reach/(self%trial%h*minval(max(self%scales%speed, self%scales%driven), &
         & mask=.not. self%scales%is_state))) &
         & *max(1.0_wp, nw/many_rates)
      size_last = 0.0_wp
      least = huge(least)
      idle = 0
      do round = 1, most_iterations
         call find_residual(self, system, work)
         if (converged) return
         if (.not. self%h_factors > 0.0_wp) then
            call refresh(self, system, work)
            fresh = .true.
            if (.not. self%h_factors > 0.0_wp) return
         end if
         if (system%redundant) then
            self%apart = self%lambda - self%held
            call give_way(self%tangent, self%apart, self%phi)
         end if
         self%unknown(:nw) = -self%motion
         self%unknown(nw + 1:) = -self%phi
         call solve(self)
         moved = sqrt(sum((self%unknown(:nw)/(self%trial%h*self%scale_w))**2))
         size_now = sqrt(moved**2 + sum((self%trial%h*self%unknown(nw + 1:)/self%scale_lambda)**2))
         if (.not. size_now <= 1.0e10_wp) return
         self%y = self%y + self%unknown(:nw)
         self%lambda = self%lambda + self%unknown(nw + 1:)
         if (round > 1) then
            ratio = size_now/max(size_last, tiny(size_last))
            converged = ratio*size_now <= negligible .or. size_last <= noise
            if (.not. converged .and. ratio > slow .and. size_now > noise) then
               converged = fresh .and. ratio > no_progress .and. size_now <= max(small_correction, stiff*noise)
               self%h_factors = 0.0_wp
            end if
            idle = merge(idle + 1, 0, fresh .and. size_now > no_progress*least)
            if (idle >= stalled) converged = converged .or. all(abs(self%unknown(:nw)) <= grains*self%grain) &
               & .or. (size_now <= self%tolerance .and. moved <= min(part_of_tolerance*self%tolerance, most_noise))
         end if
         least = min(least, size_now)
         size_last = size_now
      end do
      converged = .false.
   end subroutine iterate

   !> Residuals of the end that is tried.
   subroutine find_residual(self, system, work)
      class(conserving_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      if (self%forest%usable) then
         call forest_step_residual(self%forest, system%model, system%layout, self%trial, self%y, self%lambda, self%motion, self%phi)
         work%evaluations = work%evaluations + 1
      else
         call step_residual(system, work, self%trial, self%y, self%lambda, self%motion, self%phi)
      end if
   end subroutine find_residual

   !> Solves for the unknowns with the factors at hand.
   subroutine solve(self)
      class(conserving_type), intent(inout) :: self
      if (self%forest%usable) then
         call forest_solve(self%forest, self%unknown)
      else
         call self%tangent%matrix%solve(self%unknown)
      end if
   end subroutine solve

   !> The tangent of any scene in place of the forest.
   subroutine use_sparse(self, system)
      class(conserving_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      self%forest%usable = .false.
      call new_tangent(system, self%tangent)
   end subroutine use_sparse

   !> Derivatives and factors at the state of the last residual.
   subroutine refresh(self, system, work)
      class(conserving_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      logical :: singular
      if (self%forest%usable) then
         call forest_step_factor(self%forest, system%model, self%trial, self%y, self%lambda, singular)
         self%statistics%jacobians = self%statistics%jacobians + 1
         self%statistics%factorisations = self%statistics%factorisations + 1
         if (.not. singular) self%h_factors = self%trial%h
         if (.not. singular) return
         ! Where the trees lose a pivot, sparse factors look for others
         call use_sparse(self, system)
         call begin_step(system, self%trial, self%t, self%trial%h, self%trial%final, self%q, self%b)
         call find_residual(self, system, work)
      end if
      call linearise_step(system, work, self%trial, self%tangent, self%y, self%lambda)
      call self%tangent%matrix%factor(singular)
      self%statistics%jacobians = self%statistics%jacobians + 1
      self%statistics%factorisations = self%statistics%factorisations + 1
      if (.not. singular) self%h_factors = self%trial%h
   end subroutine refresh

   !> Local error in units of the scales, eq. (5.31): from the mean rates of three steps, through the Newton matrix, which lets pass
   !> what the step resolves.
   subroutine estimate_error(self, system, err)
      class(conserving_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      real(wp), intent(out) :: err
      real(wp) :: since
      call find_curvature(self%means, self%t, self%trial%h, self%b, self%trial%new_b, since, self%e)
      err = part_of_error(self, system, self%means%curvature, self%scale_x)
      err = err + turning_error(self, system)
      self%motion = (self%means%curvature - self%means%curvature_before)/since
      if (self%means%has_curvature) err = err + part_of_error(self, system, self%motion, self%scale_w)
      err = sqrt(err)
      if (.not. err <= huge(err)) err = huge(err)
   end subroutine estimate_error

   !> Square of h^3/12 times a derivative of the rates, filtered, in units of scales.
   real(wp) function part_of_error(self, system, derivative, scales) result(square)
      class(conserving_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: derivative(:), scales(:)
      call fixed_rates(system%layout, self%trial%new_q, derivative, self%e)
      self%e = self%trial%h**3/12*self%e
      square = filtered_square(self, system, scales)
   end function part_of_error

   !> The same of what frames turn too little, eq. (5.32): a steady rotation has no other error.
   real(wp) function turning_error(self, system) result(square)
      class(conserving_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Part of the tolerance that is worth a look
      real(wp), parameter :: worth = 0.1_wp
      real(wp) :: largest
      integer :: i, at
      largest = 0.0_wp
      self%e = 0.0_wp
      do i = 1, size(system%layout%q)
         if (.not. system%layout%framed(i)) cycle
         at = system%layout%w(i) + 2
         self%e(at) = self%y(at)**3/12
         largest = max(largest, abs(self%e(at)))
      end do
      square = 0.0_wp
      if (largest > worth*self%tolerance) square = filtered_square(self, system, self%scale_x)
   end function turning_error

   !> Square of an error of the coordinates, in `e`, that the Newton matrix lets pass, in units of scales.
   real(wp) function filtered_square(self, system, scales) result(square)
      class(conserving_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: scales(:)
      self%unknown = 0.0_wp
      if (self%forest%usable) then
         call forest_step_mass(self%forest, self%e, self%unknown)
      else
         call times_mass(system, self%tangent, 1.0_wp, self%e, self%unknown(:system%layout%nw))
      end if
      call solve(self)
      square = sum((self%unknown(:system%layout%nw)/scales)**2)
   end function filtered_square

   !> Increment and rates at the end of the step that is tried, in the fixed axes, and the work put in. What the forces of the step
   !> do differs from what their laws do along the way, eq. (5.28): that is energy that the scheme feeds, and must be small.
   subroutine measure_work(self, system, work, err, good)
      class(conserving_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Error estimate of the motion, raised to that of the work if this is larger
      real(wp), intent(inout) :: err
      logical, intent(out) :: good
      real(wp) :: done, missed, own
      integer :: i, at
      good = .true.
      self%increment = self%y
      do i = 1, size(system%layout%q)
         at = system%layout%w(i)
         if (system%layout%framed(i)) self%increment(at + 2) = 2*atan(0.5_wp*self%y(at + 2))
      end do
      call fixed_rates(system%layout, self%trial%new_q, self%trial%new_b, self%new_w)
      if (.not. system%powered) return
      done = step_work(system, work, self%trial, self%y, self%lambda)
      missed = 0.0_wp
      do i = 1, size(system%loads)
         if (.not. system%loads(i)%item%powered) cycle
         missed = missed_work(self, system, work)
         exit
      end do
      call self%input%try_known(done, missed)
      if (self%fixed_step > 0.0_wp) return
      own = abs(missed)/self%input%scale_of(energy_scale(system, self%scales), abs(done))
      ! Beside a heavy body the energy of a light one is nothing, and its speed is not
      own = max(own, kicked(self))
      good = self%input%is_within(own, self%tolerance)
      if (.not. (good .and. own > self%tolerance)) err = max(err, own)
   end subroutine measure_work

   !> Largest velocity by the impulses that the forces of the step that is tried have missed, through the Newton matrix, in units of
   !> the scales.
   real(wp) function kicked(self)
      class(conserving_type), intent(inout) :: self
      integer :: nw
      nw = size(self%missed)
      kicked = 0.0_wp
      if (.not. any(abs(self%missed) > 0.0_wp)) return
      self%unknown(:nw) = self%missed/self%trial%h
      self%unknown(nw + 1:) = 0.0_wp
      call solve(self)
      kicked = 2*maxval(abs(self%unknown(:nw))/self%scale_w)/self%trial%h
      if (.not. kicked <= huge(kicked)) kicked = huge(kicked)
   end function kicked

   !> What the laws of loads do along the way of the step that is tried, less what the forces of the step do there: by Lobatto's
   !> formula on the cubic through both ends. Leaves the impulses that are missed.
   real(wp) function missed_work(self, system, work) result(missed)
      class(conserving_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), parameter :: inner = 0.5_wp*sqrt(3.0_wp/7)
      real(wp), parameter :: nodes(5) = [0.0_wp, 0.5_wp - inner, 0.5_wp, 0.5_wp + inner, 1.0_wp]
      real(wp), parameter :: weights(5) = [9.0_wp, 49.0_wp, 64.0_wp, 49.0_wp, 9.0_wp]/180
      real(wp) :: power
      integer :: i, k
      missed = 0.0_wp
      self%missed = 0.0_wp
      do k = 1, size(nodes)
         call cubic_state(system%layout, nodes(k), self%trial%h, self%q, self%increment, self%w, self%new_w, self%e, self%path_q, &
            & self%path_v)
         call place_frames(system%model, system%layout, self%t + nodes(k)*self%trial%h, self%path_q, work%kinematics)
         call move_frames(system%model, system%layout, self%path_q, self%path_v, work%kinematics)
         power = 0.0_wp
         do i = 1, size(system%loads)
            if (.not. system%loads(i)%item%powered) cycle
            call system%loads(i)%item%add_missed_power(self%trial%mean, work%kinematics, power)
            call add_missed(system%loads(i)%item, work%loads(i)%force, weights(k)*self%trial%h)
         end do
         missed = missed + weights(k)*self%trial%h*power
      end do

   contains

      !> Adds what the force of a load misses, times a part of the step.
      subroutine add_missed(load, force, part)
         class(load_type), intent(in) :: load
         !> Scratch
         real(wp), intent(inout) :: force(:)
         real(wp), intent(in) :: part
         integer :: side, at, n
         force = 0.0_wp
         call load%add_missed_force(self%trial%mean, work%kinematics, part, force)
         do side = 1, size(load%bodies)
            if (load%bodies(side) == ground) cycle
            at = system%layout%w(load%bodies(side))
            n = load%rates(side)
            self%missed(at:at + n - 1) = self%missed(at:at + n - 1) + force(load%offsets(side) + 1:load%offsets(side) + n)
         end do
      end subroutine add_missed

   end function missed_work

   !> Brings the rates at the end of the step onto the velocity constraints, least in the mass norm, eq. (5.33). Only what
   !> constraints prescribe changes; the kinetic energy that this gives or takes is work of the drivers. At a singular place they
   !> stay. Where it changes much the places have not moved as the velocities say, perhaps to another branch: the step is halved.
   subroutine follow_drivers(self, system, work, doubts, good)
      class(conserving_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> How often this step has been halved for that
      integer, intent(inout) :: doubts
      logical, intent(out) :: good
      integer, parameter :: most_doubts = 12
      type(error_type), allocatable :: error
      real(wp) :: before, change
      good = .true.
      call linearise(system, work, self%trial%final, self%trial%new_q, error)
      if (allocated(error)) return
      call velocities_of(system%layout, self%trial%new_q, self%new_w, self%path_v)
      call project_velocity(system, work, self%path_v, self%change)
      self%e = self%new_w
      call rates_of(system%layout, self%trial%new_q, self%path_v, self%new_w)
      change = largest_change(system%layout, self%e, self%new_w, self%scale_w)
      good = change <= 0.2_wp*self%tolerance**(1.0_wp/3) .or. doubts >= most_doubts .or. self%fixed_step > 0.0_wp
      doubts = doubts + merge(0, 1, good)
      if (.not. good) return
      before = dot_product(self%trial%new_b, self%trial%new_p)
      call frame_rates(system%layout, self%trial%new_q, self%new_w, self%e)
      call find_momenta(system, work%kinematics%lines, self%trial%new_q, self%e, self%trial%new_p)
      self%input%new_shape(1) = self%input%new_shape(1) + 0.5_wp*(dot_product(self%e, self%trial%new_p) - before)
   end subroutine follow_drivers

   !> Takes the step.
   subroutine accept(self, system, stop)
      class(conserving_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: stop
      associate (trial => self%trial, statistics => self%statistics)
         if (system%powered) call self%input%accept(trial%h, sum(self%input%new_shape)/trial%h)
         if (self%ringing%watched) then
            self%e = (self%new_w - self%w)/trial%h
            call self%ringing%note(system, trial%h, self%e, 1.0_wp/12, 3)
         end if
         call note_mean(self%means, self%t, trial%h, self%b, trial%new_b, self%lambda, statistics%steps > 0)
         self%q_before = self%q
         self%w_before = self%w
         self%t_before = self%t
         self%t = trial%final
         self%rounding = merge(0.0_wp, (self%t - self%t_before) - (trial%h - self%rounding), self%t >= stop)
         self%q = trial%new_q
         self%b = trial%new_b
         if (self%driven) call frame_rates(system%layout, self%q, self%new_w, self%b)
         if (system%nc > 0) statistics%position_residual = max(statistics%position_residual, &
            & maxval(abs(self%phi))/system%model%length)
      end associate
      self%w = self%new_w
      call velocities_of(system%layout, self%q, self%w, self%v)
   end subroutine accept

   !> Cubic through coordinates and rates at both ends of the step; its derivative for the rates. The work put in is taken as even.
   subroutine conserving_interpolate(self, t, q, v, w)
      class(conserving_type), intent(inout) :: self
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
      call cubic_state(self%layout, s, h, self%q_before, self%increment, self%w_before, self%w, self%e, q, v)
      w = self%input%within(s)
   end subroutine conserving_interpolate

   !> Saves or restores its memory.
   subroutine exchange_conserving(self, snapshot, system)
      class(conserving_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      type(system_type), intent(in) :: system
      logical :: usable
      call self%exchange_common(snapshot, system)
      usable = self%forest%usable
      call snapshot%exchange('usable', usable)
      if (self%forest%usable .and. .not. usable) call use_sparse(self, system)
      call snapshot%keep('q', self%q)
      call snapshot%keep('v', self%v)
      call snapshot%keep('b', self%b)
      call snapshot%keep('y', self%y)
      call snapshot%keep('lambda', self%lambda)
      call snapshot%keep('q_before', self%q_before)
      call snapshot%keep('w_before', self%w_before)
      call snapshot%keep('increment', self%increment)
      call snapshot%keep('w', self%w)
      call snapshot%keep('new_w', self%new_w)
      call self%means%exchange(snapshot)
      call snapshot%keep('motion', self%motion)
      call snapshot%keep('phi', self%phi)
      call snapshot%keep('unknown', self%unknown)
      call snapshot%keep('e', self%e)
      call snapshot%keep('change', self%change)
      call snapshot%keep('missed', self%missed)
      call self%trial%exchange(snapshot)
      if (.not. self%forest%usable) call self%tangent%exchange(snapshot)
      call self%forest%exchange(snapshot)
      call self%scales%exchange(snapshot)
      call snapshot%keep('scale_x', self%scale_x)
      call snapshot%keep('scale_w', self%scale_w)
      call snapshot%keep('grain', self%grain)
      call snapshot%keep('scale_lambda', self%scale_lambda)
      call snapshot%exchange('reach', self%reach)
      call snapshot%exchange('h', self%h)
      call snapshot%exchange('h_factors', self%h_factors)
      call snapshot%exchange('rounding', self%rounding)
      ! Not saved: path_q, path_v, held, apart, layout, driven
   end subroutine exchange_conserving

end module limber_integrator_conserving
