!> Projection of a state onto the constraints. Frames that hang or are driven into their places in closed form, the rest by Newton's
!> method with the factors of the multiplier system, least in the mass norm; positions first, then velocities. Floor: multibody.
!> Source: doc/theory, eqs. (4.13), (4.14).
module limber_multibody_projection
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_model_model, only: ground
   use limber_multibody_plane_vectors, only: along, cross
   use limber_multibody_assembly_newton, only: close_positions
   use limber_multibody_drivers, only: driven_angle_type
   use limber_multibody_constraint_matrix, only: constraint_matrix_type, new_constraint_matrix
   use limber_multibody_equations_of_motion, only: linearise, linearise_placed, position_residual, open_residual, &
      & velocity_residual, velocity_gaps
   use limber_multibody_kinematics, only: place_drives, place_frames
   use limber_multibody_layout, only: normalise_frames
   use limber_multibody_point_motion, only: point_velocity
   use limber_multibody_multiplier_system, only: update_jacobians
   use limber_multibody_multiplier_solution, only: solve_multiplier_system, solve_gaps
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   !> Residual relative to the constraints' scales that a sample may have
   real(wp), parameter, public :: harmless = 1.0e-9_wp
   !> And the one that is aimed at
   real(wp), parameter :: least_residual = 1.0e-14_wp
   !> Most rounds of Newton's method
   integer, parameter :: most_rounds = 6

   public :: project_state, project_position, project_velocity, settle, settle_position, settle_place, &
      & list_unplaced, place_known

contains

   !> Moves a state that is near the one whose factors are at hand onto the constraints, positions first, and leaves the system
   !> linearised there.
   subroutine project_state(system, work, t, q, v, change, aim, limit, residual, error)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      !> Coordinates and velocities (nq)
      real(wp), contiguous, intent(inout) :: q(:), v(:)
      !> Scratch (nq)
      real(wp), contiguous, intent(inout) :: change(:)
      !> Residual of the positions, relative to the constraints' scales, that is aimed at, and the one beyond which all else is
      !> left as it is; residual reached
      real(wp), intent(in) :: aim, limit
      real(wp), intent(out) :: residual
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: before
      call project_position(system, work, t, q, change, .false., most_rounds, aim, before, residual, error)
      ! One that is no number is beyond it, too
      if (.not. residual <= limit) return
      call linearise_placed(system, work, t, q, error)
      if (.not. allocated(error)) call project_velocity(system, work, v, change)
   end subroutine project_state

   !> Moves q onto the constraints, least in the mass norm, by Newton steps; the frames' vectors are brought to unit length. Leaves
   !> the kinematics placed at the new q.
   subroutine project_position(system, work, t, q, change, fresh, most, tolerance, before, residual, error)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      !> Coordinates (nq)
      real(wp), contiguous, intent(inout) :: q(:)
      !> Scratch (nq)
      real(wp), contiguous, intent(inout) :: change(:)
      !> Whether the system is linearised at the first place; else the factors at hand serve, which are of a state near by
      logical, intent(in) :: fresh
      !> Most steps
      integer, intent(in) :: most
      !> Residual relative to the constraints' scales that is small enough
      real(wp), intent(in) :: tolerance
      !> Residual at first, with all frames of the tree in their places, and residual reached
      real(wp), intent(out) :: before, residual
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: last
      integer :: round, i
      call put_together(system, work, t, q)
      before = 0.0_wp
      residual = 0.0_wp
      if (fresh) call linearise_placed(system, work, t, q, error)
      if (allocated(error)) return
      residual = open_residual(system, work)
      before = residual
      do round = 1, most
         if (residual <= tolerance) return
         last = residual
         work%phi = -work%phi
         call solve_gaps(system, work, work%phi, change)
         do i = 1, size(work%bodies)
            if (.not. system%layout%framed(i)) cycle
            call spin_frame(system%layout%q(i) + 2, change(system%layout%q(i) + 2), work%kinematics%frames(i)%u, change)
         end do
         q = q + change
         call put_together(system, work, t, q)
         residual = open_residual(system, work)
         if (residual < 2*last .or. residual <= harmless) cycle
         call go_back(system, work, t, q, change, residual)
         return
      end do
   end subroutine project_position

   !> Frames of unit length, all that follows, hangs or is driven in its place, and the kinematics there.
   subroutine put_together(system, work, t, q)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      !> Coordinates (nq)
      real(wp), contiguous, intent(inout) :: q(:)
      call normalise_frames(system%layout, q)
      call place_tree(system, work, t, q)
      call place_frames(system%model, system%layout, t, q, work%kinematics)
   end subroutine put_together

   !> Takes a way back on which the factors have led astray.
   subroutine go_back(system, work, t, q, change, residual)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Time; coordinates, and the way (nq)
      real(wp), intent(in) :: t
      real(wp), contiguous, intent(inout) :: q(:)
      real(wp), contiguous, intent(in) :: change(:)
      !> That of the place where it began
      real(wp), intent(out) :: residual
      q = q - change
      call put_together(system, work, t, q)
      residual = open_residual(system, work)
   end subroutine go_back

   !> Puts frames that hang on others, or are driven, where they belong.
   subroutine place_tree(system, work, t, q)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      !> Coordinates (nq)
      real(wp), contiguous, intent(inout) :: q(:)
      integer :: k
      call place_drives(system%model, t, work%kinematics)
      do k = 1, size(system%tree%order)
         if (system%tree%plain(system%tree%order(k))) cycle
         call place_body(system, work, system%tree%order(k), .true., q)
      end do
   end subroutine place_tree

   !> Coordinates and velocities that follow from the time alone: of frames that are driven, and origins of those that hang on them.
   !> What hangs on the ground is there from the start.
   subroutine place_known(system, work, t, q, v)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      !> Coordinates and velocities (nq)
      real(wp), contiguous, intent(inout) :: q(:), v(:)
      integer :: k
      call place_drives(system%model, t, work%kinematics)
      associate (tree => system%tree)
         do k = 1, size(tree%timed)
            call place_body(system, work, tree%timed(k), tree%given(1, tree%timed(k)), q, v)
         end do
      end associate
   end subroutine place_known

   !> Puts one frame where a joint or drivers place it, behind the frame that carries it.
   pure subroutine place_body(system, work, body, origin, q, v)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      !> Its index; whether its origin is placed, else only its angle
      integer, intent(in) :: body
      logical, intent(in) :: origin
      !> Coordinates (nq), and velocities if they are placed too (nq)
      real(wp), intent(inout) :: q(*)
      real(wp), intent(inout), optional :: v(*)
      integer :: j, first
      first = system%layout%q(body)
      associate (tree => system%tree)
         if (origin .and. tree%joint(body) > 0) then
            call hang_origin(system, body, q, v)
         else if (origin .and. tree%axes(1, body) > 0) then
            do j = 1, 2
               associate (drive => work%kinematics%drives(tree%axes(j, body)))
                  q(first + j - 1) = drive%value
                  if (present(v)) v(first + j - 1) = drive%rate
               end associate
            end do
         end if
         if (tree%driver(body) > 0) call turn_frame(system, work, tree%driver(body), first, q, v)
         if (tree%grip(body) == 0) return
         do j = 1, size(tree%holders, 1)
            if (tree%holders(j, body) == 0) exit
            call turn_frame(system, work, tree%holders(j, body), first, q, v)
         end do
      end associate
   end subroutine place_body

   !> Puts the origin of a frame where it hangs: at a point of a rigid body, or of the ground.
   pure subroutine hang_origin(system, body, q, v)
      type(system_type), intent(in) :: system
      !> Index of the body
      integer, intent(in) :: body
      real(wp), intent(inout) :: q(*)
      real(wp), intent(inout), optional :: v(*)
      real(wp) :: p(2), rate(2)
      integer :: to, from
      to = system%layout%q(body)
      associate (point => system%model%points(system%marker_points(system%tree%marker(body))))
         p = point%p0
         if (system%tree%carrier(body) /= ground) then
            from = system%layout%q(system%tree%carrier(body))
            p = along(p, q(from + 2:from + 3))
            p(1) = q(from) + p(1)
            p(2) = q(from + 1) + p(2)
         end if
         q(to) = p(1)
         q(to + 1) = p(2)
         if (.not. present(v)) return
         rate = 0.0_wp
         if (point%body /= ground) rate = point_velocity(system%model, system%layout, point, q(:system%layout%nq), &
            & v(:system%layout%nq))
         v(to:to + 1) = rate
      end associate
   end subroutine hang_origin

   !> Turns a frame as a driver does, if the constraint is one.
   pure subroutine turn_frame(system, work, constraint, first, q, v)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      !> Index of the constraint, first index of the frame's coordinates
      integer, intent(in) :: constraint, first
      real(wp), intent(inout) :: q(*)
      real(wp), intent(inout), optional :: v(*)
      select type (item => system%constraints(constraint)%item)
      type is (driven_angle_type)
         associate (drive => work%kinematics%drives(item%drive))
            q(first + 2:first + 3) = drive%heading
            if (.not. present(v)) return
            v(first + 2) = -drive%rate*drive%heading(2)
            v(first + 3) = drive%rate*drive%heading(1)
         end associate
      end select
   end subroutine turn_frame

   !> Indices of the coordinates that `place_known` does not give.
   subroutine list_unplaced(system, list)
      type(system_type), intent(in) :: system
      integer, allocatable, intent(out) :: list(:)
      logical :: placed(system%layout%nq)
      integer :: i, j, first
      placed = .false.
      do i = 1, size(system%layout%q)
         first = system%layout%q(i)
         placed(first:first + 1) = system%tree%given(1, i)
         if (system%layout%framed(i)) placed(first + 2:first + 3) = system%tree%given(2, i)
      end do
      allocate (list(count(.not. placed)))
      list = pack([(j, j=1, size(placed))], .not. placed)
   end subroutine list_unplaced

   !> Moves a state that is near the constraints onto them, at position and at velocity level.
   subroutine settle(system, work, t, q, v, change, exact, residual, error)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      !> Coordinates and velocities (nq)
      real(wp), contiguous, intent(inout) :: q(:), v(:)
      !> Scratch (nq)
      real(wp), contiguous, intent(inout) :: change(:)
      !> Whether the multiplier system is to be left linearised at the very state, as accelerations want it
      logical, intent(in) :: exact
      !> Residual of the position reached
      real(wp), intent(out) :: residual
      type(error_type), allocatable, intent(out) :: error
      !> Residual before, below which the factors serve the new place too, and below which they do so to round-off
      real(wp), parameter :: near = 1.0e-4_wp, nearest = 1.0e-9_wp
      !> And above which the velocities are projected twice: once leaves so large a part of what they lack
      real(wp), parameter :: rough = 1.0e-7_wp
      real(wp) :: before
      call settle_position(system, work, t, q, change, before, residual, error)
      if (allocated(error)) return
      if (before > near .or. (exact .and. before > nearest)) then
         call linearise(system, work, t, q, error)
         if (allocated(error)) return
         before = 0.0_wp
      else if (before > 0.0_wp) then
         call update_jacobians(system, work)
      end if
      call project_velocity(system, work, v, change)
      if (before > rough) call project_velocity(system, work, v, change)
   end subroutine settle

   !> Moves coordinates that are near the constraints onto them.
   subroutine settle_position(system, work, t, q, change, before, residual, error)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      !> Coordinates (nq)
      real(wp), contiguous, intent(inout) :: q(:)
      !> Scratch (nq)
      real(wp), contiguous, intent(inout) :: change(:)
      !> Residual before, zero if nothing had to be moved but what hangs or is driven; and residual reached
      real(wp), intent(out) :: before, residual
      type(error_type), allocatable, intent(out) :: error
      call project_position(system, work, t, q, change, .true., most_rounds, least_residual, before, residual, error)
      if (allocated(error)) return
      if (before <= least_residual) before = 0.0_wp
      if (residual > harmless) call settle_plainly(system, work, t, q, residual, error)
   end subroutine settle_position

   !> The same for coordinates alone, of which nothing else follows: with no factors if they are near enough, else with those at
   !> hand, which are of a state near by, and with factors of their own only where these do not do. Leaves the kinematics placed.
   subroutine settle_place(system, work, t, q, change, allowed, residual, error)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      !> Coordinates (nq)
      real(wp), contiguous, intent(inout) :: q(:)
      !> Scratch (nq)
      real(wp), contiguous, intent(inout) :: change(:)
      !> Residual that may stay, once all that hangs or is driven is in its place, and residual reached
      real(wp), intent(in) :: allowed
      real(wp), intent(out) :: residual
      type(error_type), allocatable, intent(out) :: error
      !> Rounds that cost less than factors
      integer, parameter :: few = 2
      real(wp) :: before
      call project_position(system, work, t, q, change, .false., merge(few, 0, allowed > 0.0_wp), max(allowed, least_residual), &
         & before, residual, error)
      if (residual > max(allowed, least_residual)) call settle_position(system, work, t, q, change, before, residual, error)
   end subroutine settle_place

   !> The same in the norm of the assembly: in the mass norm a light body between heavy ones goes far for little.
   subroutine settle_plainly(system, work, t, q, residual, error)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      real(wp), intent(inout) :: q(:)
      real(wp), intent(out) :: residual
      type(error_type), allocatable, intent(out) :: error
      type(constraint_matrix_type) :: matrix
      logical :: done
      residual = huge(residual)
      call new_constraint_matrix(system, .true., matrix)
      call close_positions(system, work, matrix, t, q, done)
      call linearise(system, work, t, q, error)
      if (.not. allocated(error)) residual = position_residual(system, work)
   end subroutine settle_plainly

   !> Takes out of v what violates the velocity equations, least in the mass norm; `linearise` at q comes first.
   subroutine project_velocity(system, work, v, change, residual)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Velocities (nq)
      real(wp), contiguous, intent(inout) :: v(:)
      !> Scratch (nq)
      real(wp), contiguous, intent(inout) :: change(:)
      !> Residual before, relative to the constraints' scales
      real(wp), intent(out), optional :: residual
      integer :: i, first
      real(wp) :: omega
      call clear_forces(work)
      if (present(residual)) then
         residual = velocity_residual(system, work, v)
      else
         call velocity_gaps(system, work, v)
      end if
      call solve_multiplier_system(system, work, work%gamma, change, .true.)
      do i = 1, size(work%bodies)
         if (.not. system%layout%framed(i)) cycle
         first = system%layout%q(i) + 2
         omega = cross(work%kinematics%frames(i)%u, v(first:first + 1)) + change(first)
         call spin_frame(first, omega, work%kinematics%frames(i)%u, v)
         change(first:first + 1) = 0.0_wp
      end do
      v = v + change
   end subroutine project_velocity

   !> Writes omega J u into the two places of a vector from `first` on.
   pure subroutine spin_frame(first, omega, u, vector)
      integer, intent(in) :: first
      real(wp), value :: omega
      real(wp), intent(in) :: u(2)
      real(wp), intent(inout) :: vector(:)
      vector(first) = -omega*u(2)
      vector(first + 1) = omega*u(1)
   end subroutine spin_frame

   subroutine clear_forces(work)
      type(workspace_type), intent(inout) :: work
      integer :: i
      do i = 1, size(work%bodies)
         work%bodies(i)%force = 0.0_wp
         work%bodies(i)%eta_force = 0.0_wp
      end do
   end subroutine clear_forces

end module limber_multibody_projection
