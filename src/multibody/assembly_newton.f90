!> Newton's method onto the constraints from afar. Newton's method with the least change of the coordinates, in steps that find the
!> nearest branch, and the least change of the velocities. Floor: multibody. Source: least-norm Gauss-Newton; Nikravesh 1988,
!> chapter 5; doc/theory, eq. (4.27).
module limber_multibody_assembly_newton
   use limber_base_kinds, only: wp
   use limber_multibody_plane_vectors, only: cross
   use limber_multibody_constraint_matrix, only: constraint_matrix_type, fill, least_step, damped_step
   use limber_multibody_equations_of_motion, only: position_residual, velocity_residual
   use limber_multibody_kinematics, only: place_frames, move_frames
   use limber_multibody_layout, only: advance, normalise_frames, rates_of, velocities_of
   use limber_multibody_multiplier_system, only: place_constraints, update_jacobians
   use limber_multibody_point_motion, only: point_position
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: close_positions, close_velocities, approach, move, change_between

   !> Relative residual that counts as satisfied, and the one that is aimed at
   real(wp), parameter :: satisfied = 1.0e-12_wp, aim = 2.0e-16_wp
   !> Deflection relative to the body's size beyond which an assembly by bending bodies is none
   real(wp), parameter :: most_deflection = 0.1_wp

contains

   !> Gauss-Newton on the position constraints; steps are limited so that the nearest branch is found.
   subroutine close_positions(system, work, matrix, t, q, done)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Of the frames, or of the deflections too
      type(constraint_matrix_type), intent(inout) :: matrix
      real(wp), intent(in) :: t
      real(wp), intent(inout) :: q(:)
      logical, intent(out) :: done
      integer, parameter :: most = 200
      !> Rounds without any progress after which there will be none where columns are held
      integer, parameter :: patience = 10
      real(wp), allocatable :: step(:), best(:)
      real(wp) :: residual, least
      integer :: round, since
      logical :: partly
      allocate (step(system%layout%nw))
      least = huge(least)
      since = 0
      partly = any(abs(matrix%scale(:matrix%columns) - matrix%unweighted(:matrix%columns)) > 0.0_wp)
      allocate (best, source=q)
      do round = 1, most
         call place_constraints(system, work, t, q)
         residual = position_residual(system, work)
         if (.not. residual <= huge(residual)) exit
         since = since + 1
         if (residual < least) then
            least = residual
            best = q
            since = 0
         else if (least <= enough(system, q) .or. (partly .and. since > patience)) then
            exit
         end if
         if (residual <= aim) exit
         call fill(system, work, matrix)
         work%gamma = -work%phi
         call least_step(matrix, work%gamma, step)
         step = step*min(1.0_wp, 0.5_wp/max(tiny(1.0_wp), largest_turn(system, step)))
         call move(system, step, q)
      end do
      q = best
      done = least <= enough(system, q)
      if (matrix%flexible) done = done .and. largest_deflection(system, q) <= most_deflection
      call place_constraints(system, work, t, q)
   end subroutine close_positions

   !> Relative residual that counts as satisfied: round-off of the farthest place sets a bound.
   pure real(wp) function enough(system, q)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: q(:)
      integer :: i
      enough = satisfied*system%model%length
      do i = 1, size(system%layout%q)
         enough = max(enough, 4*epsilon(enough)*maxval(abs(q(system%layout%q(i):system%layout%q(i) + 1))))
      end do
      enough = enough/system%model%length
   end function enough

   !> Comes as near to all constraints as can be: the least sum of squares of their residuals. What is open there is open because
   !> constraints contradict each other.
   subroutine approach(system, work, matrix, t, q)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(constraint_matrix_type), intent(inout) :: matrix
      real(wp), intent(in) :: t
      real(wp), intent(inout) :: q(:)
      integer, parameter :: most = 300
      real(wp), allocatable :: step(:), best(:)
      real(wp) :: open, least, damping
      integer :: round
      allocate (step(system%layout%nw))
      allocate (best, source=q)
      least = huge(least)
      damping = 1.0e-2_wp
      do round = 1, most
         call place_frames(system%model, system%layout, t, q, work%kinematics)
         open = position_residual(system, work)
         open = norm2(work%phi/matrix%row_scale)
         if (open < least) then
            if (least - open < 1.0e-10_wp*least) exit
            least = open
            best = q
            damping = max(0.2_wp*damping, 1.0e-10_wp)
            call update_jacobians(system, work)
            call fill(system, work, matrix)
            work%gamma = -work%phi
         else
            q = best
            damping = 10*damping
            if (damping > 1.0e8_wp) exit
         end if
         call damped_step(matrix, work%gamma, damping*matrix%norm**2, step)
         step = step*min(1.0_wp, 0.5_wp/max(tiny(1.0_wp), largest_turn(system, step)))
         call move(system, step, q)
      end do
      q = best
      call place_constraints(system, work, t, q)
   end subroutine approach

   !> Least-norm change of the rates that satisfies the velocity equations, or comes nearest to that; refined. Bodies without
   !> inertia go first: whatever the deck says of them, they have no momentum that others could take from.
   subroutine close_velocities(system, work, matrix, q, v, done)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(constraint_matrix_type), intent(inout) :: matrix
      real(wp), intent(in) :: q(:)
      real(wp), intent(inout) :: v(:)
      logical, intent(out) :: done
      real(wp), allocatable :: step(:)
      logical, allocatable :: massless(:)
      real(wp) :: rest(size(v)), residual, speed
      integer :: round
      allocate (step(system%layout%nw))
      massless = .not. (system%inertia(1, :) > 0.0_wp .or. system%inertia(4, :) > 0.0_wp)
      ! What drivers ask for, and what the motion has before and after
      rest = 0.0_wp
      speed = max(velocity_residual(system, work, rest), largest_rate(system, v))
      call fill(system, work, matrix)
      if (any(massless)) then
         residual = velocity_residual(system, work, v)
         call keep_columns(system, matrix, massless)
         call least_step(matrix, work%gamma, step)
         call add_rates(system, q, step, v)
         call fill(system, work, matrix)
      end if
      do round = 1, 3
         residual = velocity_residual(system, work, v)
         call least_step(matrix, work%gamma, step)
         call add_rates(system, q, step, v)
      end do
      residual = velocity_residual(system, work, v)
      done = residual <= enough(system, q)*max(speed, largest_rate(system, v))
      call move_frames(system%model, system%layout, q, v, work%kinematics)
   end subroutine close_velocities

   !> Adds a change of the rates to velocities.
   pure subroutine add_rates(system, q, step, v)
      type(system_type), intent(in) :: system
      !> Coordinates (nq), change (nw), velocities (nq)
      real(wp), intent(in) :: q(:), step(:)
      real(wp), intent(inout) :: v(:)
      real(wp) :: change(size(v))
      call velocities_of(system%layout, q, step, change)
      v = v + change
   end subroutine add_rates

   !> Largest rate of a motion, relative to the scene [1/time].
   pure real(wp) function largest_rate(system, v) result(largest)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: v(:)
      integer :: i, first, last
      largest = 0.0_wp
      do i = 1, size(system%layout%q)
         first = system%layout%q(i)
         largest = max(largest, norm2(v(first:first + 1))/system%model%length)
         if (.not. system%layout%framed(i)) cycle
         largest = max(largest, norm2(v(first + 2:first + 3)))
         if (system%layout%n(i) == 0) cycle
         last = first + 3 + system%layout%n(i)
         largest = max(largest, maxval(abs(v(first + 4:last)))*system%model%bodies(i)%largest_shape/system%model%length)
      end do
   end function largest_rate

   !> Forgets the entries of all bodies but some.
   pure subroutine keep_columns(system, matrix, kept)
      type(system_type), intent(in) :: system
      type(constraint_matrix_type), intent(inout) :: matrix
      !> Which bodies are kept (bodies)
      logical, intent(in) :: kept(:)
      logical :: column(matrix%columns)
      integer :: i, k
      i = 1
      do k = 1, matrix%columns
         do while (i < size(kept))
            if (matrix%rate(k) < system%layout%w(i + 1)) exit
            i = i + 1
         end do
         column(k) = kept(i)
      end do
      do k = 1, size(matrix%value)
         if (.not. column(matrix%column(k))) matrix%value(k) = 0.0_wp
      end do
   end subroutine keep_columns

   !> Largest rotation in a step [rad].
   pure real(wp) function largest_turn(system, step) result(largest)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: step(:)
      integer :: i
      largest = 0.0_wp
      do i = 1, size(system%layout%w)
         if (system%layout%framed(i)) largest = max(largest, abs(step(system%layout%w(i) + 2)))
      end do
   end function largest_turn

   !> Bound of the largest deflection relative to the size of its body; of an exact beam how much longer its chord is, for one that
   !> is longer than its span, as a rope, bends in its plane.
   pure real(wp) function largest_deflection(system, q) result(largest)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: q(:)
      !> Least chord that such a beam may have, of the undeformed one
      real(wp), parameter :: shortest = 0.3_wp
      real(wp) :: longer
      integer :: i, first
      largest = 0.0_wp
      do i = 1, size(system%layout%q)
         first = system%layout%q(i) + 4
         if (system%layout%n(i) == 0) cycle
         associate (body => system%model%bodies(i), points => system%model%points)
            if (body%reduced%is_exact .and. body%start_point > 0 .and. body%whole == 0) then
               longer = norm2(point_position(system%model, system%layout, points(body%end_point), q) &
                  & - point_position(system%model, system%layout, points(body%start_point), q)) &
                  & /norm2(points(body%end_point)%p0 - points(body%start_point)%p0) - 1
               if (longer > shortest - 1 .and. longer < most_deflection) cycle
            end if
         end associate
         largest = max(largest, maxval(abs(q(first:first + system%layout%n(i) - 1)))* &
            & system%model%bodies(i)%largest_shape/system%model%bodies(i)%size)
      end do
   end function largest_deflection

   !> Moves q by a step in the layout of the rates.
   pure subroutine move(system, step, q)
      type(system_type), intent(in) :: system
      !> (nw), (nq)
      real(wp), intent(in) :: step(:)
      real(wp), intent(inout) :: q(:)
      real(wp) :: moved(size(q))
      call advance(system%layout, q, step, moved)
      call normalise_frames(system%layout, moved)
      q = moved
   end subroutine move

   !> Change from one position to another, in the layout of the rates.
   pure subroutine change_between(system, from, to, change)
      type(system_type), intent(in) :: system
      !> (nq), (nw)
      real(wp), intent(in) :: from(:), to(:)
      real(wp), intent(out) :: change(:)
      integer :: i, first
      call rates_of(system%layout, from, to - from, change)
      do i = 1, size(system%layout%q)
         if (.not. system%layout%framed(i)) cycle
         first = system%layout%q(i) + 2
         change(system%layout%w(i) + 2) = atan2(cross(from(first:first + 1), to(first:first + 1)), &
            & dot_product(from(first:first + 1), to(first:first + 1)))
      end do
   end subroutine change_between

end module limber_multibody_assembly_newton
