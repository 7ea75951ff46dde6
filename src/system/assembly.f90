!> Assembly: first place and motion. Starts from the guesses of the deck and satisfies every constraint to round-off, at
!> position and at velocity level, with the least change of the frames; deflections and their rates stay as given
!> unless the frames alone cannot satisfy the constraints. Floor: system.
!> Source: least-norm Gauss-Newton; Nikravesh 1988, chapter 5.
module limber_system_assembly
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_base_lapack, only: dgelsd
   use limber_base_text, only: as_text
   use limber_deck_operations, only: jet_type
   use limber_system_algebra, only: turn, cross
   use limber_system_dynamics, only: position_residual, velocity_residual, worst_constraint
   use limber_system_kinematics, only: place_frames, move_frames
   use limber_system_multiplier, only: update_jacobians
   use limber_system_system, only: system_type, workspace_type
   implicit none
   private
   public :: assemble, first_guess, constraint_rank

   !> Relative residual that counts as satisfied, and the one that is aimed at
   real(wp), parameter :: satisfied = 1.0e-12_wp, aim = 2.0e-16_wp
   !> Deflection relative to the body's size beyond which an assembly by bending bodies is none
   real(wp), parameter :: most_deflection = 0.1_wp

contains

   !> State at the time t that satisfies all constraints.
   subroutine assemble(system, work, t, q, v, error, culprit)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      !> Coordinates and velocities (nq): in, the guess; out, the assembled state
      real(wp), intent(inout) :: q(:), v(:)
      !> The scene cannot be assembled
      type(error_type), allocatable, intent(out) :: error
      !> Index of the constraint that the error is about
      integer, intent(out) :: culprit
      real(wp), allocatable :: start(:)
      logical :: done
      culprit = 0
      if (system%nc == 0) then
         call place_frames(system%model, system%layout, t, q, work%kinematics)
         return
      end if
      start = q
      call assemble_position(system, work, t, q, .false., done)
      if (.not. done) then
         q = start
         call assemble_position(system, work, t, q, .true., done)
      end if
      if (.not. done) then
         q = start
         call assemble_position(system, work, t, q, .false., done)
         call report(system, work, t, error, culprit)
         return
      end if
      call check_rank(system, work, error, culprit)
      if (allocated(error)) return
      call turn_rates(system, start, q, v)
      call assemble_velocity(system, work, q, v, .false., done)
      if (.not. done) call assemble_velocity(system, work, q, v, .true., done)
      if (.not. done) then
         call worst_rate(system, work, v, culprit)
         call raise(error, system%constraints(culprit)%item%label//': no velocities satisfy the constraints at t = '// &
            & as_text(t, 6)//'; the mechanism is at a dead centre or driven against a joint')
      end if
   end subroutine assemble

   !> Turns the rates of the frames' vectors along with the frames: the guessed angular velocities stay.
   pure subroutine turn_rates(system, before, q, v)
      type(system_type), intent(in) :: system
      !> Coordinates before and after (nq)
      real(wp), intent(in) :: before(:), q(:)
      real(wp), intent(inout) :: v(:)
      real(wp) :: omega
      integer :: i, first
      do i = 1, size(system%layout%q)
         if (.not. system%layout%framed(i)) cycle
         first = system%layout%q(i) + 2
         omega = cross(before(first:first + 1), v(first:first + 1))
         v(first:first + 1) = omega*turn(q(first:first + 1))
      end do
   end subroutine turn_rates

   !> Coordinates and velocities as the model guesses them; driven frames already point where they are driven.
   subroutine first_guess(system, t, q, v)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: t
      !> Coordinates and velocities (nq)
      real(wp), intent(out) :: q(:), v(:)
      type(jet_type) :: theta
      integer :: i, first
      q = 0.0_wp
      v = 0.0_wp
      do i = 1, size(system%model%bodies)
         associate (body => system%model%bodies(i))
            first = system%layout%q(i)
            q(first:first + 1) = body%position
            v(first:first + 1) = body%velocity
            if (.not. system%layout%framed(i)) cycle
            q(first + 2:first + 3) = [cos(body%angle), sin(body%angle)]
            v(first + 2:first + 3) = body%spin*[-sin(body%angle), cos(body%angle)]
         end associate
      end do
      do i = 1, size(system%model%drivers)
         theta = system%model%drivers(i)%law%evaluate_jet(t)
         first = system%layout%q(system%model%drivers(i)%body) + 2
         q(first:first + 1) = [cos(theta%value), sin(theta%value)]
         v(first:first + 1) = theta%first*[-sin(theta%value), cos(theta%value)]
      end do
   end subroutine first_guess

   !> Gauss-Newton on the position constraints; steps are limited so that the nearest branch is found.
   subroutine assemble_position(system, work, t, q, flexible, done)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      real(wp), intent(inout) :: q(:)
      !> True if the deflections may change too
      logical, intent(in) :: flexible
      logical, intent(out) :: done
      integer, parameter :: most = 200
      real(wp), allocatable :: step(:), best(:)
      real(wp) :: residual, least
      integer :: round, rank
      allocate (step(size(q)))
      least = huge(least)
      best = q
      do round = 1, most
         call place_frames(system%model, system%layout, t, q, work%kinematics)
         call update_jacobians(system, work)
         residual = position_residual(system, work)
         if (.not. residual <= huge(residual)) exit
         if (residual < least) then
            least = residual
            best = q
         else if (least <= satisfied) then
            exit
         end if
         if (residual <= aim) exit
         call least_norm_step(system, work, -work%phi, flexible, step, rank)
         step = step*min(1.0_wp, 0.5_wp/max(tiny(1.0_wp), largest_turn(system, step)))
         call move(system, step, q)
      end do
      q = best
      done = least <= satisfied
      if (flexible) done = done .and. largest_deflection(system, q) <= most_deflection
      call place_frames(system%model, system%layout, t, q, work%kinematics)
      call update_jacobians(system, work)
   end subroutine assemble_position

   !> Least-norm change of the rates that satisfies the velocity equations, refined once.
   subroutine assemble_velocity(system, work, q, v, flexible, done)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: q(:)
      real(wp), intent(inout) :: v(:)
      logical, intent(in) :: flexible
      logical, intent(out) :: done
      real(wp), allocatable :: step(:), start(:)
      real(wp) :: residual, speed
      integer :: round, rank, i
      allocate (step(size(v)))
      start = v
      do round = 1, 3
         residual = velocity_residual(system, work, v)
         call least_norm_step(system, work, work%gamma, flexible, step, rank)
         do i = 1, size(system%layout%q)
            if (.not. system%layout%framed(i)) cycle
            associate (first => system%layout%q(i) + 2)
               step(first:first + 1) = step(first)*turn(q(first:first + 1))
            end associate
         end do
         v = v + step
      end do
      residual = velocity_residual(system, work, v)
      speed = max(1.0_wp, maxval(abs(v))/system%model%length)
      done = residual <= satisfied*speed
      if (.not. done) v = start
      call move_frames(system%model, system%layout, q, v, work%kinematics)
   end subroutine assemble_velocity

   !> Solves Jacobian step = rhs in the least norm of scaled changes: lengths relative to the scene, angles, deflections.
   subroutine least_norm_step(system, work, rhs, flexible, step, rank)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      !> Right-hand sides (nc)
      real(wp), intent(in) :: rhs(:)
      logical, intent(in) :: flexible
      !> Changes in the layout of q, alpha in the first place of u (nq)
      real(wp), intent(out) :: step(:)
      !> Rank of the Jacobian
      integer, intent(out) :: rank
      real(wp), allocatable :: matrix(:, :), unknown(:, :), values(:), scale(:), row_scale(:), buffer(:)
      integer, allocatable :: integers(:), place(:)
      integer :: m, n, i, info
      call dense_jacobian(system, work, flexible, matrix, place, scale, row_scale)
      m = size(matrix, 1)
      n = size(matrix, 2)
      allocate (unknown(max(m, n), 1), values(min(m, n)), buffer(20*(m + n)**2 + 2000), integers(100*(m + n) + 100))
      unknown = 0.0_wp
      unknown(:m, 1) = rhs/row_scale
      call dgelsd(m, n, 1, matrix, m, unknown, max(m, n), values, 1.0e-11_wp, rank, buffer, size(buffer), integers, info)
      step = 0.0_wp
      if (info /= 0) return
      do i = 1, n
         step(place(i)) = unknown(i, 1)*scale(i)
      end do
   end subroutine least_norm_step

   !> The Jacobian as one matrix with scaled rows and columns.
   subroutine dense_jacobian(system, work, flexible, matrix, place, scale, row_scale)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      logical, intent(in) :: flexible
      !> (nc, columns)
      real(wp), allocatable, intent(out) :: matrix(:, :)
      !> Place of each column in the layout of q, and its scale; scale of each row
      integer, allocatable, intent(out) :: place(:)
      real(wp), allocatable, intent(out) :: scale(:), row_scale(:)
      integer, allocatable :: first(:)
      integer :: body, i, side, k, row, columns
      allocate (first(size(system%layout%q)), place(system%layout%nq), scale(system%layout%nq), row_scale(system%nc))
      columns = 0
      do body = 1, size(first)
         first(body) = columns + 1
         do k = 1, system%layout%rates(body)
            columns = columns + 1
            place(columns) = system%layout%q(body) + k - 1
            scale(columns) = merge(1.0_wp, system%model%length, k == 3)
         end do
         if (.not. flexible) cycle
         do k = 1, system%layout%n(body)
            columns = columns + 1
            place(columns) = system%layout%q(body) + 3 + k
            scale(columns) = system%model%length/system%model%bodies(body)%largest_shape
         end do
      end do
      allocate (matrix(system%nc, columns))
      matrix = 0.0_wp
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            row = item%first
            row_scale(row:row + item%rows - 1) = item%scale
            do side = 1, 2
               body = item%bodies(side)
               if (body == 0) cycle
               k = system%layout%rates(body)
               matrix(row:row + item%rows - 1, first(body):first(body) + k - 1) = work%jacobians(side, i)%z(:, :k)
               if (flexible) matrix(row:row + item%rows - 1, first(body) + k:first(body) + k + system%layout%n(body) - 1) = &
                  & work%jacobians(side, i)%eta
            end do
         end associate
      end do
      place = place(:columns)
      scale = scale(:columns)
      do k = 1, columns
         matrix(:, k) = matrix(:, k)*scale(k)/row_scale
      end do
   end subroutine dense_jacobian

   !> Rank of the Jacobian of the first `rows` constraint equations, deflections included.
   integer function constraint_rank(system, work, rows) result(rank)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      integer, intent(in) :: rows
      real(wp), allocatable :: matrix(:, :), unknown(:, :), values(:), scale(:), row_scale(:), buffer(:)
      integer, allocatable :: integers(:), place(:)
      integer :: n, info
      call dense_jacobian(system, work, .true., matrix, place, scale, row_scale)
      matrix = matrix(:rows, :)
      n = size(matrix, 2)
      allocate (unknown(max(rows, n), 1), values(min(rows, n)), buffer(20*(rows + n)**2 + 2000), integers(100*(rows + n) + 100))
      unknown = 0.0_wp
      call dgelsd(rows, n, 1, matrix, rows, unknown, max(rows, n), values, 1.0e-11_wp, rank, buffer, size(buffer), integers, info)
   end function constraint_rank

   !> An error if a constraint repeats what those before it demand.
   subroutine check_rank(system, work, error, culprit)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      type(error_type), allocatable, intent(out) :: error
      integer, intent(out) :: culprit
      integer :: rows
      culprit = 0
      if (constraint_rank(system, work, system%nc) == system%nc) return
      do culprit = 1, size(system%constraints)
         associate (item => system%constraints(culprit)%item)
            rows = item%first + item%rows - 1
            if (constraint_rank(system, work, rows) < rows) then
               call raise(error, item%label//': it repeats, wholly or in part, what the joints and drivers before it demand'// &
                  & ' (or the mechanism starts at a singular position); remove it or start elsewhere')
               return
            end if
         end associate
      end do
   end subroutine check_rank

   !> Largest rotation in a step [rad].
   pure real(wp) function largest_turn(system, step) result(largest)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: step(:)
      integer :: i, first
      largest = 0.0_wp
      do i = 1, size(system%layout%q)
         first = system%layout%q(i)
         if (system%layout%framed(i)) largest = max(largest, abs(step(first + 2)))
      end do
   end function largest_turn

   !> Bound of the largest deflection relative to the size of its body.
   pure real(wp) function largest_deflection(system, q) result(largest)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: q(:)
      integer :: i, first
      largest = 0.0_wp
      do i = 1, size(system%layout%q)
         first = system%layout%q(i) + 4
         if (system%layout%n(i) > 0) largest = max(largest, maxval(abs(q(first:first + system%layout%n(i) - 1)))* &
            & system%model%bodies(i)%largest_shape/system%model%bodies(i)%size)
      end do
   end function largest_deflection

   !> Moves q by a step that has alpha in the first place of u; rotates u exactly.
   pure subroutine move(system, step, q)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: step(:)
      real(wp), intent(inout) :: q(:)
      integer :: i, first, last
      do i = 1, size(system%layout%q)
         first = system%layout%q(i)
         q(first:first + 1) = q(first:first + 1) + step(first:first + 1)
         if (.not. system%layout%framed(i)) cycle
         associate (u => q(first + 2:first + 3))
            u = cos(step(first + 2))*u + sin(step(first + 2))*turn(u)
            u = u/norm2(u)
         end associate
         last = first + 3 + system%layout%n(i)
         q(first + 4:last) = q(first + 4:last) + step(first + 4:last)
      end do
   end subroutine move

   !> The constraint whose velocity equation is farthest from satisfied.
   subroutine worst_rate(system, work, v, culprit)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: v(:)
      integer, intent(out) :: culprit
      real(wp) :: worst, residual
      integer :: i
      worst = velocity_residual(system, work, v)
      worst = -1.0_wp
      culprit = 1
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            residual = norm2(work%gamma(item%first:item%first + item%rows - 1))/item%scale
            if (residual > worst) culprit = i
            worst = max(worst, residual)
         end associate
      end do
   end subroutine worst_rate

   !> Error that names the constraint that is left open.
   subroutine report(system, work, t, error, culprit)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      type(error_type), allocatable, intent(out) :: error
      integer, intent(out) :: culprit
      real(wp) :: residual
      call worst_constraint(system, work, culprit, residual)
      call raise(error, system%constraints(culprit)%item%label//': the initial position cannot be assembled; '// &
         & as_text(residual, 3)//' is left open at t = '//as_text(t, 6)// &
         & '. Check the lengths, or give a better first guess (X=, Y=, ANGLE=) for its bodies')
   end subroutine report

end module limber_system_assembly
