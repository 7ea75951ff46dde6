!> Common parts of ALPHA and RADAU. The state and the last step, the Newton matrix of the equations of motion and its derivatives,
!> the way past a fold. Floor: integrator. Source: doc/theory, eqs. (4.15), (4.16), (4.18), (4.38), (4.39), (4.41).
module limber_integrator_implicit
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_base_error, only: error_type, raise
   use limber_base_text, only: as_text
   use limber_integrator_fold_crossing, only: crossing_type, new_crossing, find_fold, step_across, increments_between, &
      & across_allowed
   use limber_integrator_integrator, only: integrator_type, constraint_limit
   use limber_integrator_error_scales, only: scales_type, new_scales, update_scales, rate_scales, energy_scale
   use limber_multibody_plane_vectors, only: cross
   use limber_multibody_equations_of_motion, only: linearise, accelerations, input_power
   use limber_multibody_kinematics, only: place_frames, move_frames
   use limber_multibody_layout, only: layout_type, rates_of, advance
   use limber_multibody_motion_laws, only: no_slope_text
   use limber_multibody_motion_residual, only: linearise_motion, place_motion
   use limber_multibody_system, only: system_type, workspace_type
   use limber_multibody_tangent, only: tangent_type, new_tangent
   implicit none
   private
   public :: implicit_type

   !> Memory of such a method
   type, abstract, extends(integrator_type) :: implicit_type
      !> Coordinates and velocities at t (nq); rates and accelerations (nw); multipliers (nc)
      real(wp), allocatable :: q(:), v(:), w(:), a(:), lambda(:)
      !> Coordinates and rates at the beginning of the last step, its increment of the coordinates (nw)
      real(wp), allocatable :: q_before(:), w_before(:), increment(:)
      !> What coordinates have lost by round-off in steps that are next to nothing (nw), and the length of the whole analysis
      real(wp), allocatable :: lost(:)
      real(wp) :: duration = 0.0_wp
      !> Scratch (nq)
      real(wp), allocatable :: change(:)
      type(tangent_type) :: tangent
      type(crossing_type) :: crossing
      type(layout_type) :: layout
      type(scales_type) :: scales
      !> Scales of coordinates and rates in the layout of the rates (nw)
      real(wp), allocatable :: scale_x(:), scale_w(:)
      !> Next step, last step, step of the factors
      real(wp) :: h = 0.0_wp, h_last = 0.0_wp, h_factors = 0.0_wp
      !> Whether the derivatives are those of the present state; rounds of the last Newton iteration
      logical :: fresh = .false.
      integer :: iterations = 0
      !> Factor of what Newton's method may leave: where it fails time and again, that is not small beside the width of a law, as
      !> that of friction near rest, eq. (5.11)
      real(wp) :: strictness = 1.0_wp
   contains
      procedure :: resume => resume_implicit
      procedure :: begin, begin_step_size, use_sparse, refresh, take_over, renew_scales, heed_failure, pass_fold, length_of_step, &
         & add_lost, singular_matrix, exchange_implicit
   end type implicit_type

contains

   !> Room, at the first time, and the state at the start; no step lies behind it.
   subroutine begin(self, system, work, t, duration, q, v, error)
      class(implicit_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> As in `start`
      real(wp), intent(in) :: t, duration, q(:), v(:)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: power
      if (.not. allocated(self%q)) then
         associate (nq => system%layout%nq, nw => system%layout%nw)
            allocate (self%q(nq), self%v(nq), self%w(nw), self%a(nw), self%lambda(system%nc), self%q_before(nq), &
               & self%w_before(nw), self%increment(nw), self%change(nq), self%scale_x(nw), self%scale_w(nw), &
               & self%lost(nw))
         end associate
         self%scales = new_scales(system, duration, .true.)
      end if
      self%h_last = 0.0_wp
      self%lost = 0.0_wp
      self%duration = duration
      call self%ringing%forget()
      self%fresh = .false.
      self%q = q
      self%v = v
      self%t = t
      self%t_before = t
      self%layout = system%layout
      self%steps_over = .true.
      call self%renew_scales(system)
      call linearise(system, work, t, q, error)
      if (allocated(error)) return
      call self%take_over(system, work)
      power = 0.0_wp
      if (system%powered) power = input_power(system, work, q, v)
      call self%input%begin(self%work_at_start, power)
      self%q_before = self%q
      self%w_before = self%w
      self%increment = 0.0_wp
   end subroutine begin

   !> The next step is as long as it was to be.
   subroutine resume_implicit(self, system, work, duration, q, v, error)
      class(implicit_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: duration, q(:), v(:)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: h
      h = self%h
      call self%start(system, work, self%t, duration, q, v, error)
      self%h = max(self%h, h)
   end subroutine resume_implicit

   !> First step: such that rates and accelerations change coordinates and rates by a part of their scales.
   subroutine begin_step_size(self, duration, part)
      class(implicit_type), intent(inout) :: self
      !> Length of the whole analysis
      real(wp), intent(in) :: duration, part
      real(wp) :: slope
      slope = sqrt(sum((self%w/self%scale_x)**2) + sum((self%a/self%scale_w)**2))
      self%h = duration
      if (slope*self%h > part) self%h = part/slope
      if (self%initial_step > 0.0_wp) self%h = min(self%h, self%initial_step)
   end subroutine begin_step_size

   !> Room for sparse matrices.
   subroutine use_sparse(self, system)
      class(implicit_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      call new_tangent(system, self%tangent)
      call new_crossing(system, self%crossing)
   end subroutine use_sparse

   !> Derivatives at the present state.
   subroutine refresh(self, system, work)
      class(implicit_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      call place_motion(system, work, self%t, self%q, self%v)
      call linearise_motion(system, work, self%tangent, self%q, self%v, self%a, self%lambda)
      self%statistics%jacobians = self%statistics%jacobians + 1
      self%fresh = .true.
      self%h_factors = 0.0_wp
   end subroutine refresh

   !> Rates, accelerations and multipliers where the system is linearised already.
   subroutine take_over(self, system, work)
      class(implicit_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      call accelerations(system, work, self%q, self%v, self%change)
      self%lambda = work%lambda
      call rates_of(system%layout, self%q, self%v, self%w)
      call rates_of(system%layout, self%q, self%change, self%a)
   end subroutine take_over

   !> Makes Newton's method stricter after it has failed some times in one step.
   subroutine heed_failure(self, failures)
      class(implicit_type), intent(inout) :: self
      !> In the present step so far; one more behind
      integer, intent(inout) :: failures
      integer, parameter :: many = 4
      real(wp), parameter :: strictest = 1.0e-8_wp
      failures = failures + 1
      if (failures == many) self%strictness = max(strictest, 0.1_wp*self%strictness)
   end subroutine heed_failure

   !> Scales at the present state.
   subroutine renew_scales(self, system)
      class(implicit_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      call update_scales(system, self%q, self%v, self%scales)
      call rate_scales(system, self%scales, self%scale_x, self%scale_w)
   end subroutine renew_scales

   !> Adds to the coordinates at the end of a step that is next to nothing what they have lost by round-off in it and before it: one
   !> that moves less in a step than its last digit would never get to where a law changes.
   subroutine add_lost(self, x, q)
      class(implicit_type), intent(inout) :: self
      !> Increment of the step (nw); coordinates before it are those of the state, and those behind it (nq)
      real(wp), intent(in) :: x(:)
      real(wp), intent(inout) :: q(:)
      !> Part of the whole time below which a step is next to nothing
      real(wp), parameter :: short = 1.0e-9_wp
      integer :: i, k, from, to
      if (self%h >= short*self%duration) return
      self%lost = self%lost + x
      call advance(self%layout, self%q, self%lost, q)
      do i = 1, size(self%layout%q)
         from = self%layout%q(i)
         to = self%layout%w(i)
         self%lost(to:to + 1) = self%lost(to:to + 1) - (q(from:from + 1) - self%q(from:from + 1))
         if (.not. self%layout%framed(i)) cycle
         self%lost(to + 2) = self%lost(to + 2) - cross(self%q(from + 2:from + 3), q(from + 2:from + 3))
         do k = 1, self%layout%n(i)
            self%lost(to + 2 + k) = self%lost(to + 2 + k) - (q(from + 3 + k) - self%q(from + 3 + k))
         end do
      end do
   end subroutine add_lost

   !> Length of the last step for its dense output: the one that the increments belong to. The difference of the times has their
   !> round-off, which of a step that is next to nothing is a part that counts.
   pure real(wp) function length_of_step(self) result(h)
      class(implicit_type), intent(in) :: self
      h = self%t - self%t_before
      if (abs(self%h_last - h) <= 8*spacing(self%t)) h = self%h_last
   end function length_of_step

   !> After Newton's method has failed: passes a fold if there is one ahead, and takes over the state behind it.
   subroutine pass_fold(self, system, work, stop, away, passed)
      class(implicit_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: stop
      !> Time to the fold; not positive: there is none
      real(wp), intent(out) :: away
      logical, intent(out) :: passed
      real(wp) :: err, residual, h, power
      integer :: nq
      nq = size(self%q)
      call find_fold(self%crossing, system, work, self%t, self%h, self%q, self%w, self%a, away)
      passed = away > 0.0_wp
      if (.not. passed) return
      h = min(2*away, stop - self%t)
      call step_across(self%crossing, system, work, self%t, h, self%q, self%v, self%input%done, self%scales%value, err, &
         & residual)
      passed = err <= across_allowed*self%tolerance .and. residual <= constraint_limit
      if (passed .and. system%powered) passed = work_across_is_good(self, system, h)
      if (.not. passed) return
      self%h = h
      call increments_between(system, self%q, self%crossing%y(:nq), self%increment)
      self%q_before = self%q
      self%w_before = self%w
      self%q = self%crossing%y(:nq)
      self%v = self%crossing%y(nq + 1:2*nq)
      self%t_before = self%t
      self%t = merge(stop, self%t + h, h >= stop - self%t)
      call self%take_over(system, work)
      if (.not. system%powered) return
      power = input_power(system, work, self%q, self%v)
      call self%input%try_cubic(h, power, self%crossing%y(2*nq + 1) - self%input%done)
      call self%input%accept(h, power)
   end subroutine pass_fold

   !> Whether the work of a step across a fold is exact enough, eq. (4.41): where drivers give the whole motion its error is that of
   !> its stages, which nothing settles. Too near to the fold no step is: the last of some is taken as it is.
   logical function work_across_is_good(self, system, h) result(good)
      class(implicit_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Length of the step
      real(wp), intent(in) :: h
      !> Most steps that are refused
      integer, parameter :: most = 4
      real(wp) :: lost
      lost = abs(self%crossing%start(size(self%crossing%start)))/ &
         & self%input%scale_of(energy_scale(system, self%scales), h*abs(self%input%power))
      good = lost <= across_allowed*self%input%allowed(self%tolerance) .or. self%fixed_step > 0.0_wp .or. &
         & self%crossing%refused == most
      self%crossing%refused = merge(0, self%crossing%refused + 1, good)
   end function work_across_is_good

   !> Error of a matrix without factors.
   subroutine singular_matrix(self, system, work, name, error)
      class(implicit_type), intent(in) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Of the method
      character(*), intent(in) :: name
      type(error_type), allocatable, intent(out) :: error
      character(:), allocatable :: cause
      call place_frames(system%model, system%layout, self%t, self%q, work%kinematics)
      call move_frames(system%model, system%layout, self%q, self%v, work%kinematics)
      cause = no_slope_text(system, work%kinematics)
      if (cause == '') cause = ': a constraint is redundant there, or a body without mass is free to move'
      call raise(error, 'the Newton matrix of '//name//' is singular at t = '//as_text(self%t, 8)//cause)
   end subroutine singular_matrix

   !> Saves or restores what they share, the matrices only if they are in use.
   subroutine exchange_implicit(self, snapshot, system, sparse)
      class(implicit_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      type(system_type), intent(in) :: system
      logical, intent(in) :: sparse
      call self%exchange_common(snapshot, system)
      call snapshot%keep('q', self%q)
      call snapshot%keep('v', self%v)
      call snapshot%keep('w', self%w)
      call snapshot%keep('a', self%a)
      call snapshot%keep('lambda', self%lambda)
      call snapshot%keep('q_before', self%q_before)
      call snapshot%keep('w_before', self%w_before)
      call snapshot%keep('increment', self%increment)
      call snapshot%keep('lost', self%lost)
      call snapshot%exchange('duration', self%duration)
      call snapshot%keep('change', self%change)
      if (sparse) call self%tangent%exchange(snapshot)
      call self%crossing%exchange(snapshot)
      call self%scales%exchange(snapshot)
      call snapshot%keep('scale_x', self%scale_x)
      call snapshot%keep('scale_w', self%scale_w)
      call snapshot%exchange('h', self%h)
      call snapshot%exchange('h_last', self%h_last)
      call snapshot%exchange('h_factors', self%h_factors)
      call snapshot%exchange('fresh', self%fresh)
      call snapshot%exchange('iterations', self%iterations)
      call snapshot%exchange('strictness', self%strictness)
      ! Not saved: layout
   end subroutine exchange_implicit

end module limber_integrator_implicit
