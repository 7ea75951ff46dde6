!> ADAMS: predictor-corrector of variable order and step. Predictor-corrector of Adams, Bashforth and Moulton (PECE) with variable
!> order and step, in the divided-difference form of Shampine and Gordon, on the equations of index 1. After each correction the
!> coordinates and velocities are projected onto the constraints, least in the mass norm. Coordinates that follow from others at
!> once are not integrated. Floor: integrator. Source: Shampine and Gordon, Computer Solution of Ordinary Differential Equations,
!> 1975, chapters 5 and 10; doc/theory, eqs. (5.1)-(5.3).
module limber_integrator_adams
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_base_error, only: error_type
   use limber_integrator_adams_errors, only: add_lost, apart, gamma_star, estimate_errors, weighted
   use limber_integrator_divided_differences, only: most, step_coefficients, interpolation_coefficients, interpolate, predict, &
      & finish_differences, restore_differences
   use limber_integrator_integrator, only: integrator_type, constraint_tolerance, constraint_limit
   use limber_integrator_error_scales, only: scales_type, new_scales, update_scales, energy_scale
   use limber_multibody_kinematics, only: place_frames
   use limber_multibody_equations_of_motion, only: linearise, accelerations, input_power
   use limber_multibody_motion_laws, only: watched_loads
   use limber_multibody_projection, only: project_state, list_unplaced, place_known
   use limber_multibody_layout, only: rates_of
   use limber_multibody_articulated_rigid, only: articulated_rigid_type, new_recursion, recursive_accelerations, recursive_settle
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: adams_type

   !> Steps of low order in a row from which on the step counts as one at the limit of stability
   integer, parameter :: many_low = 20
   !> Step in radians of the fastest vibration from which methods of middle orders are at the limit of their stability
   real(wp), parameter :: near_limit = 0.4_wp
   !> Part of the whole time below which a step is next to nothing
   real(wp), parameter :: short = 1.0e-9_wp
   !> Least number of bodies whose accelerations are found by recursion
   integer, parameter :: many = 10
   !> Memory of the method, in the names of Shampine and Gordon
   type, extends(integrator_type) :: adams_type
      !> Number of coordinates that are integrated; length of y = [q; v; w] or [q; v] with those
      integer :: nq = 0, ny = 0
      !> Indices of these coordinates (nq); whether they are all
      integer, allocatable :: kept(:)
      logical :: whole = .true.
      !> Number of the first components of y whose errors count: also the work if it is asked for, and with coordinates that are
      !> not integrated, for it is all that feels how fast driven bodies move
      integer :: weighed = 0
      !> Otherwise all coordinates, velocities and accelerations at the last state that was evaluated
      real(wp), allocatable :: q(:), v(:), a(:)
      !> State at t, predicted state, its derivative (ny)
      real(wp), allocatable :: y(:), p(:), yp(:)
      !> State, derivative and what is lost of coordinates before the correction
      real(wp), allocatable :: y_before(:), yp_before(:), lost_before(:)
      !> Whether laws of the motion may jump or bend, so that steps are confirmed
      logical :: laws_bend = .false.
      !> Modified divided differences (ny, most + 2)
      real(wp), allocatable :: phi(:, :)
      !> Scratch (all coordinates)
      real(wp), allocatable :: change(:)
      !> What coordinates have lost by round-off in steps that are next to nothing (nq)
      real(wp), allocatable :: lost(:)
      !> Accelerations in the layout of the rates, where vibrations are noted (nw)
      real(wp), allocatable :: rates(:)
      !> Scales of the local error, and those of y (weighed)
      type(scales_type) :: scales
      real(wp), allocatable :: scale(:)
      !> Whether there are drivers, whose power asks for their multipliers
      logical :: driven = .false.
      !> The bodies of an open chain or tree, whose accelerations need no matrix
      type(articulated_rigid_type) :: tree
      !> Next step, last step
      real(wp) :: h = 0.0_wp, h_last = 0.0_wp
      !> Length of the whole analysis; local error allowed in the present step, eq. (5.5)
      real(wp) :: duration = 0.0_wp, bound = 0.0_wp
      !> Next order, last order, steps taken with the same h
      integer :: k = 1, k_last = 0, ns = 0
      !> Steps in a row of order 4 or less: many are a sign of stiffness
      integer :: low_orders = 0
      !> Steps of low order, or near the limit of stability, beyond others, steps of high order in a row, and whether it has gone at
      !> that limit since the last many of these
      integer :: more_low = 0, high_orders = 0
      logical :: limited = .false.
      !> True while order and step are raised in every step
      logical :: starting = .true.
      !> Coefficients
      real(wp) :: psi(most) = 0.0_wp, alpha(most) = 0.0_wp, beta(most) = 0.0_wp, sig(most + 1) = 0.0_wp
      real(wp) :: g(most + 1) = 0.0_wp
   contains
      procedure :: start => adams_start
      procedure :: step => adams_step
      procedure :: resume => adams_resume
      procedure :: interpolate => adams_interpolate
      procedure :: interpolate_place => adams_interpolate_place
      procedure :: complete => adams_complete
      procedure :: exchange => exchange_adams
   end type adams_type

contains

   subroutine adams_start(self, system, work, t, duration, q, v, error)
      class(adams_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t, duration
      real(wp), intent(in) :: q(:), v(:)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: slope
      integer :: i
      if (size(system%layout%q) >= many) call new_recursion(system, self%tree)
      call list_unplaced(system, self%kept)
      if (self%tree%usable .or. .not. sum(system%inertia(1, :)) > 0.0_wp) self%kept = [(i, i=1, size(q))]
      self%nq = size(self%kept)
      self%whole = self%nq == size(q)
      self%steps_to_start = 15
      self%laws_bend = size(watched_loads(system)) > 0
      self%driven = .false.
      do i = 1, size(system%constraints)
         self%driven = self%driven .or. system%constraints(i)%item%driven
      end do
      self%ny = 2*self%nq + merge(1, 0, system%powered)
      self%weighed = merge(2*self%nq, self%ny, self%whole .and. .not. self%input%asked)
      if (allocated(self%y)) deallocate (self%y, self%p, self%yp, self%phi, self%change, self%q, self%v, self%a, self%scale, &
         & self%lost, self%y_before, self%yp_before, self%lost_before)
      allocate (self%y_before(self%ny), self%yp_before(self%ny), self%lost_before(self%nq))
      allocate (self%y(self%ny), self%p(self%ny), self%yp(self%ny), self%phi(self%ny, most + 2), self%change(size(q)), &
         & self%lost(self%nq))
      allocate (self%q(size(q)), self%v(size(q)), self%a(size(q)), self%scale(self%weighed))
      if (.not. allocated(self%rates)) allocate (self%rates(system%layout%nw), source=0.0_wp)
      self%q = q
      self%v = v
      self%a = 0.0_wp
      self%y = 0.0_wp
      self%lost = 0.0_wp
      self%y(:self%nq) = q(self%kept)
      self%y(self%nq + 1:2*self%nq) = v(self%kept)
      if (system%powered) self%y(self%ny) = self%work_at_start
      self%h_last = 0.0_wp
      self%k = 1
      self%k_last = 0
      self%ns = 0
      self%starting = .true.
      self%t = t
      self%t_before = t
      if (.not. allocated(self%scales%value)) self%scales = new_scales(system, duration, .false.)
      call update_scales(system, q, v, self%scales)
      call keep_scales(self, system)
      self%duration = duration
      self%bound = self%tolerance
      call evaluate(self, system, work, t, self%y, self%yp, error)
      if (allocated(error)) return
      self%phi = 0.0_wp
      self%phi(:, 1) = self%yp
      self%g(1:2) = [1.0_wp, 0.5_wp]
      self%sig(1) = 1.0_wp
      slope = weighted(self%weighed, self%yp, self%scale)
      self%h = duration
      if (self%tolerance < 16*slope*self%h**2) self%h = 0.25_wp*sqrt(self%tolerance/slope)
      ! At rest where a load is about to begin nothing says how soon
      if (system%powered) self%h = min(self%h, 1.0e-3_wp*duration)
      if (self%initial_step > 0.0_wp) self%h = min(self%h, self%initial_step)
      if (self%maximum_step > 0.0_wp) self%h = min(self%h, self%maximum_step)
   end subroutine adams_start

   !> A jump of the accelerations moves all that they have been by as much, and gives the velocities before that slope: only the
   !> first differences change, eq. (5.84). Order and step go on.
   subroutine adams_resume(self, system, work, duration, q, v, error)
      class(adams_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: duration, q(:), v(:)
      type(error_type), allocatable, intent(out) :: error
      if (self%k_last == 0) then
         call self%start(system, work, self%t, duration, q, v, error)
         return
      end if
      self%q = q
      self%v = v
      self%y(:self%nq) = q(self%kept)
      self%y(self%nq + 1:2*self%nq) = v(self%kept)
      call evaluate(self, system, work, self%t, self%y, self%yp, error)
      associate (nq => self%nq)
         self%phi(:nq, 2) = self%phi(:nq, 2) + self%h_last*(self%yp(nq + 1:2*nq) - self%phi(nq + 1:2*nq, 1))
      end associate
      self%phi(:, 1) = self%yp
   end subroutine adams_resume

   !> y' = [v; a; power], at any (t, y).
   subroutine evaluate(self, system, work, t, y, yp, error)
      class(adams_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      real(wp), contiguous, intent(in) :: y(:)
      real(wp), contiguous, intent(inout) :: yp(:)
      type(error_type), allocatable, intent(out) :: error
      if (.not. self%whole) then
         call spread_state(self, system, work, t, y)
         call linearise(system, work, t, self%q, error)
      else if (.not. self%tree%usable) then
         call linearise(system, work, t, y(:self%nq), error)
      end if
      if (allocated(error)) return
      call differentiate(self, system, work, y, yp)
   end subroutine evaluate

   !> All coordinates and velocities at (t, y).
   subroutine spread_state(self, system, work, t, y)
      class(adams_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      real(wp), contiguous, intent(in) :: y(:)
      call spread_kept(self, y)
      call place_known(system, work, t, self%q, self%v)
   end subroutine spread_state

   !> Those that are integrated.
   subroutine spread_kept(self, y)
      class(adams_type), intent(inout) :: self
      real(wp), contiguous, intent(in) :: y(:)
      integer :: i
      do i = 1, self%nq
         self%q(self%kept(i)) = y(i)
         self%v(self%kept(i)) = y(self%nq + i)
      end do
   end subroutine spread_kept

   !> Takes them out of all, into p.
   subroutine gather_kept(self)
      class(adams_type), intent(inout) :: self
      integer :: i
      do i = 1, self%nq
         self%p(i) = self%q(self%kept(i))
         self%p(self%nq + i) = self%v(self%kept(i))
      end do
   end subroutine gather_kept

   !> The scales of what is integrated.
   subroutine keep_scales(self, system)
      class(adams_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      integer :: i
      do i = 1, self%nq
         self%scale(i) = self%scales%value(self%kept(i))
         self%scale(self%nq + i) = self%scales%value(size(self%q) + self%kept(i))
      end do
      if (self%weighed > 2*self%nq) self%scale(self%weighed) = self%input%scale_of(energy_scale(system, self%scales), 0.0_wp)
   end subroutine keep_scales

   !> The same where the system is linearised at (t, q) already, and the state is spread.
   subroutine differentiate(self, system, work, y, yp)
      class(adams_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), contiguous, intent(in) :: y(:)
      real(wp), contiguous, intent(inout) :: yp(:)
      integer :: nq, i
      nq = self%nq
      if (.not. self%whole) then
         call accelerations(system, work, self%q, self%v, self%a, self%driven)
         do i = 1, nq
            yp(nq + i) = self%a(self%kept(i))
         end do
         yp(:nq) = y(nq + 1:2*nq)
         if (system%powered) yp(self%ny) = input_power(system, work, self%q, self%v)
         return
      end if
      if (self%tree%usable) then
         call recursive_accelerations(self%tree, system%model%gravity, y(:nq), y(nq + 1:2*nq), yp(nq + 1:2*nq))
         work%evaluations = work%evaluations + 1
      else
         call accelerations(system, work, y(:nq), y(nq + 1:2*nq), yp(nq + 1:2*nq), self%driven)
      end if
      yp(:nq) = y(nq + 1:2*nq)
      if (system%powered) yp(self%ny) = input_power(system, work, y(:nq), y(nq + 1:2*nq))
   end subroutine differentiate

   subroutine adams_step(self, system, work, stop, error)
      class(adams_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: stop
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: wanted, estimate(0:3), err, t
      integer :: failures, k_next, i
      logical :: accepted, raised

      wanted = self%h
      failures = 0
      if (self%whole) then
         self%bound = turning_bound(self, system, self%y(:self%nq), self%y(self%nq + 1:2*self%nq))
      else
         self%bound = turning_bound(self, system, self%q, self%v)
      end if
      do
         if (self%maximum_step > 0.0_wp) self%h = min(self%h, self%maximum_step)
         if (self%fixed_step > 0.0_wp .and. failures == 0) self%h = self%fixed_step
         if (self%t + self%h > stop) self%h = stop - self%t
         if (self%h <= self%least_step(stop)) then
            if (self%tree%usable) call place_frames(system%model, system%layout, self%t, self%y(:self%nq), work%kinematics)
            i = maxloc(abs((self%yp(:2*self%nq) - self%phi(:2*self%nq, 1))/self%scale(:2*self%nq)), dim=1)
            if (i > 0) i = self%kept(modulo(i - 1, self%nq) + 1)
            call self%step_too_small(system, work, count(system%layout%q <= max(1, i)), error)
            return
         end if
         t = self%t + self%h
         if (self%h >= stop - self%t) t = stop
         if (abs(self%h - self%h_last) > 0.0_wp) self%ns = 0
         if (self%ns <= self%k_last) self%ns = self%ns + 1
         call step_coefficients(self%k, self%ns, self%h, self%psi, self%alpha, self%beta, self%sig, self%g)
         call predict(self%ny, self%k, self%ns, self%h, self%beta, self%g, self%y, self%phi, self%p)
         call evaluate(self, system, work, t, self%p, self%yp, error)
         if (allocated(error)) return
         call estimate_errors(self%ny, self%weighed, self%k, self%h, self%g, self%sig, self%scale, self%yp, self%phi, estimate, &
            & err, k_next)
         if (err > self%bound .and. self%weighed > 2*self%nq .and. self%h <= self%last_digits()) call estimate_errors(self%ny, &
            & 2*self%nq, self%k, self%h, self%g, self%sig, self%scale(:2*self%nq), self%yp, self%phi, estimate, err, k_next)
         accepted = err <= self%bound .or. self%fixed_step > 0.0_wp
         if (accepted) then
            call correct(self, system, work, t, accepted, error)
            if (allocated(error)) return
            if (.not. accepted) self%statistics%failed_projections = self%statistics%failed_projections + 1
            if (accepted .and. self%laws_bend) call confirm(self, accepted)
         else
            self%statistics%rejected = self%statistics%rejected + 1
         end if
         if (accepted) exit
         failures = failures + 1
         call retreat(self, failures, estimate(0), k_next)
      end do

      self%t_before = self%t
      self%t = t
      self%k_last = self%k
      self%h_last = self%h
      self%low_orders = merge(self%low_orders + 1, 0, self%k <= 4)
      self%more_low = max(0, min(many_low, self%more_low + merge(1, -1, self%k <= 4 .or. (self%k <= 8 .and. &
         & self%h_last*self%ringing%fastest > near_limit))))
      self%high_orders = merge(self%high_orders + 1, 0, self%k > 8)
      self%limited = self%more_low >= many_low .or. (self%limited .and. self%high_orders < many_low)
      call finish_differences(self%ny, self%k, self%yp, self%phi)
      call self%count_step(self%h_last, self%k_last, err*2.5_wp**(self%k_last + 1) < self%bound)
      if (self%ringing%watched) call note_vibrations(self, system)
      call next_order_and_step(self, estimate, k_next)
      ! A step that was cut short to end at `stop` says nothing about the next one
      if (self%t >= stop .and. failures == 0) self%h = max(self%h, min(wanted, 2*self%h))
      if (self%whole) then
         call update_scales(system, self%y(:self%nq), self%y(self%nq + 1:2*self%nq), self%scales, raised)
      else
         call update_scales(system, self%q, self%v, self%scales, raised)
      end if
      if (self%input%asked .and. system%powered) call self%input%note_passing(self%h_last*abs(self%yp(self%ny)), self%y(self%ny))
      if (raised .or. self%input%asked) call keep_scales(self, system)
   end subroutine adams_step

   !> Has the vibrations noted that are kept up at the limit of stability, until steps of high order say that it is left: those that
   !> grow to some tolerances raise the order again and again.
   subroutine note_vibrations(self, system)
      class(adams_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      integer :: i
      if (.not. self%limited) then
         call self%ringing%forget()
         return
      end if
      if (self%whole) then
         self%q = self%y(:self%nq)
         self%a = self%yp(self%nq + 1:2*self%nq)
      end if
      self%change = 0.0_wp
      do i = 1, self%nq
         self%change(self%kept(i)) = self%bound*self%scale(self%nq + i)
      end do
      call rates_of(system%layout, self%q, self%a, self%rates)
      call self%ringing%note_limit(system, self%h_last, self%rates, self%change)
   end subroutine note_vibrations

   !> Local error allowed in a step: errors of the speed of what turns add up turn by turn, and those of its angle with the square
   !> of that, so that a long run of many turns needs smaller ones, eq. (5.5).
   pure real(wp) function turning_bound(self, system, q, v) result(bound)
      class(adams_type), intent(in) :: self
      type(system_type), intent(in) :: system
      !> Coordinates and velocities (nq)
      real(wp), intent(in) :: q(:), v(:)
      !> Turns in the whole time up to which the tolerance is kept as it is; least error
      real(wp), parameter :: turns = 3.0_wp, least = 1.0e-13_wp
      real(wp) :: spin
      integer :: i, first
      spin = 0.0_wp
      do i = 1, size(system%layout%q)
         if (.not. system%layout%framed(i) .or. system%tree%driver(i) > 0) cycle
         first = system%layout%q(i) + 2
         spin = max(spin, abs(q(first)*v(first + 1) - q(first + 1)*v(first)))
      end do
      spin = spin*self%duration
      bound = self%tolerance
      if (spin > 2*acos(-1.0_wp)*turns) bound = max(min(bound, least), bound*2*acos(-1.0_wp)*turns/spin)
   end function turning_bound

   !> Puts the differences back and chooses a smaller step (block 3).
   subroutine retreat(self, failures, estimate, k_next)
      class(adams_type), intent(inout) :: self
      integer, intent(in) :: failures, k_next
      real(wp), intent(in) :: estimate
      real(wp) :: factor
      self%starting = .false.
      call restore_differences(self%k, self%h, self%beta, self%psi, self%phi)
      factor = 0.5_wp
      if (failures > 3 .and. 0.5_wp*self%bound < 0.25_wp*estimate) factor = sqrt(0.5_wp*self%bound/estimate)
      self%k = k_next
      if (failures >= 3) self%k = 1
      self%h = factor*self%h
      self%ns = 0
   end subroutine retreat

   !> Whether the derivative at the corrected state confirms that at the predicted one, eq. (5.56): where a law jumps between the
   !> two, as one that a body rests at does, the error estimate knows nothing of it. Else the state is what it was before.
   subroutine confirm(self, accepted)
      class(adams_type), intent(inout) :: self
      logical, intent(out) :: accepted
      !> Second corrections of vibrations at the limit of stability are some times the error allowed
      real(wp), parameter :: many_times = 20.0_wp
      real(wp) :: first, second
      associate (n => merge(2*self%nq, self%weighed, self%h <= self%last_digits()))
         second = apart(n, self%yp, self%yp_before, self%scale)
         first = apart(n, self%yp_before, self%phi(:, 1), self%scale)
      end associate
      accepted = second <= max(first, many_times*self%bound/(self%h*self%g(self%k + 1))) .or. self%fixed_step > 0.0_wp
      if (accepted) return
      self%statistics%rejected = self%statistics%rejected + 1
      self%y = self%y_before
      self%yp = self%yp_before
      self%lost = self%lost_before
   end subroutine confirm

   !> Corrects, projects onto the constraints, and evaluates at the result (block 4).
   subroutine correct(self, system, work, t, accepted, error)
      class(adams_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      !> False if the constraints cannot be met
      logical, intent(out) :: accepted
      type(error_type), allocatable, intent(out) :: error
      !> Part of the tolerance that a residual of the positions may be: far below the error of the step. They do not add up, for
      !> each state is projected anew.
      real(wp), parameter :: part = 1.0e-6_wp
      real(wp) :: aim, limit, residual
      integer :: nq
      nq = self%nq
      if (self%laws_bend) then
         self%y_before = self%y
         self%yp_before = self%yp
         self%lost_before = self%lost
      end if
      self%p = self%p + self%h*self%g(self%k + 1)*(self%yp - self%phi(:, 1))
      if (self%h < short*self%duration) call add_lost(nq, self%h, self%y, self%p, self%lost)
      accepted = .true.
      if (self%tree%usable) then
         call recursive_settle(self%tree, self%p(:nq), self%p(nq + 1:2*nq))
      else
         aim = max(constraint_tolerance, part*self%tolerance)
         limit = max(constraint_limit, aim)
         if (self%whole) then
            call project_state(system, work, t, self%p(:nq), self%p(nq + 1:2*nq), self%change, aim, limit, residual, error)
         else
            ! What follows from the time is there since the prediction
            call spread_kept(self, self%p)
            call project_state(system, work, t, self%q, self%v, self%change, aim, limit, residual, error)
            call gather_kept(self)
         end if
         accepted = residual <= limit
         if (allocated(error) .or. .not. accepted) return
         self%statistics%position_residual = max(self%statistics%position_residual, residual)
      end if
      self%y = self%p
      call differentiate(self, system, work, self%y, self%yp)
   end subroutine correct

   !> Order and step of the next step (block 4).
   subroutine next_order_and_step(self, estimate, k_next)
      class(adams_type), intent(inout) :: self
      real(wp), intent(in) :: estimate(0:3)
      integer, intent(in) :: k_next
      real(wp) :: chosen, raised
      integer :: k
      k = self%k
      chosen = estimate(0)
      if (k_next == k - 1 .or. k == most) self%starting = .false.
      if (self%starting) then
         self%k = k + 1
         chosen = 0.0_wp
      else if (k_next == k - 1) then
         self%k = k - 1
         chosen = estimate(1)
      else if (k + 1 <= self%ns) then
         raised = self%h*gamma_star(k + 1)*weighted(self%weighed, self%phi(:, k + 2), self%scale)
         if (k > 1) then
            if (estimate(1) <= min(estimate(0), raised)) then
               self%k = k - 1
               chosen = estimate(1)
            else if (raised < estimate(0) .and. k < most) then
               self%k = k + 1
               chosen = raised
            end if
         else if (raised < 0.5_wp*estimate(0)) then
            self%k = k + 1
            chosen = raised
         end if
      end if
      if (self%starting .or. 0.5_wp*self%bound >= chosen*2.0_wp**(self%k + 1)) then
         self%h = 2*self%h
      else if (0.5_wp*self%bound < chosen) then
         self%h = self%h*max(0.5_wp, min(0.9_wp, (0.5_wp*self%bound/chosen)**(1.0_wp/(self%k + 1))))
      end if
   end subroutine next_order_and_step

   !> Dense output from the differences.
   subroutine adams_interpolate(self, t, q, v, w)
      class(adams_type), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), contiguous, intent(out) :: q(:), v(:)
      real(wp), intent(out) :: w
      integer :: nq
      nq = self%nq
      call interpolate_first(self, t, self%ny)
      if (self%whole) then
         q = self%p(:nq)
         v = self%p(nq + 1:2*nq)
      else
         q = self%q
         v = self%v
         q(self%kept) = self%p(:nq)
         v(self%kept) = self%p(nq + 1:2*nq)
      end if
      w = self%work_at_start
      if (self%ny > 2*nq) w = self%p(self%ny)
   end subroutine adams_interpolate

   subroutine adams_interpolate_place(self, t, q, v, w)
      class(adams_type), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), contiguous, intent(inout) :: q(:), v(:)
      real(wp), intent(inout) :: w
      integer :: i
      if (self%input%asked) then
         call self%interpolate(t, q, v, w)
         return
      end if
      call interpolate_first(self, t, self%nq)
      if (.not. self%whole) q = self%q
      do i = 1, self%nq
         q(self%kept(i)) = self%p(i)
      end do
   end subroutine adams_interpolate_place

   !> The first of what it carries on, at a time within the last step, into p.
   subroutine interpolate_first(self, t, wanted)
      class(adams_type), intent(inout) :: self
      real(wp), intent(in) :: t
      !> Number of components
      integer, intent(in) :: wanted
      real(wp) :: g(most + 1), back
      integer :: order
      back = t - self%t
      order = self%k_last + 1
      if (.not. abs(back) > 0.0_wp) order = 0
      call interpolation_coefficients(order, back, self%psi, g)
      call interpolate(self%ny, wanted, order, back, g, self%y, self%phi, self%p)
   end subroutine interpolate_first

   !> At the end of the step they are there.
   subroutine adams_complete(self, system, work, t, q, v)
      class(adams_type), intent(in) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      real(wp), contiguous, intent(inout) :: q(:), v(:)
      if (.not. self%whole .and. abs(t - self%t) > 0.0_wp) call place_known(system, work, t, q, v)
   end subroutine adams_complete

   !> Saves or restores its memory.
   subroutine exchange_adams(self, snapshot, system)
      class(adams_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      type(system_type), intent(in) :: system
      call self%exchange_common(snapshot, system)
      call snapshot%keep('q', self%q)
      call snapshot%keep('v', self%v)
      call snapshot%keep('a', self%a)
      call snapshot%keep('y', self%y)
      call snapshot%keep('p', self%p)
      call snapshot%keep('yp', self%yp)
      call snapshot%keep('phi', self%phi)
      call snapshot%keep('change', self%change)
      call snapshot%keep('lost', self%lost)
      call self%scales%exchange(snapshot)
      call snapshot%keep('scale', self%scale)
      if (self%tree%usable) call self%tree%exchange(snapshot)
      call snapshot%exchange('h', self%h)
      call snapshot%exchange('h_last', self%h_last)
      call snapshot%exchange('duration', self%duration)
      call snapshot%exchange('bound', self%bound)
      call snapshot%exchange('k', self%k)
      call snapshot%exchange('k_last', self%k_last)
      call snapshot%exchange('ns', self%ns)
      call snapshot%exchange('low_orders', self%low_orders)
      call snapshot%exchange('more_low', self%more_low)
      call snapshot%exchange('high_orders', self%high_orders)
      call snapshot%exchange('limited', self%limited)
      call snapshot%exchange('starting', self%starting)
      call snapshot%exchange('psi', self%psi)
      call snapshot%exchange('alpha', self%alpha)
      call snapshot%exchange('beta', self%beta)
      call snapshot%exchange('sig', self%sig)
      call snapshot%exchange('g', self%g)
      ! Not saved: nq, ny, kept, whole, weighed, y_before, yp_before, lost_before, laws_bend, rates, driven
   end subroutine exchange_adams

end module limber_integrator_adams
