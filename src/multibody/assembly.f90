!> Assembly: first position and velocity on the constraints. First place and motion. Starts from the guesses of the deck and
!> satisfies every constraint to round-off, at position and at velocity level, with the least change of the frames; deflections and
!> their rates stay as given unless the frames alone cannot satisfy the constraints (then see `misfit`). Says which equations are
!> redundant. Floor: multibody. Source: least-norm Gauss-Newton; Nikravesh 1988, chapter 5; doc/theory, eqs. (4.27), (4.29)-(4.31).
module limber_multibody_assembly
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_base_text, only: as_text
   use limber_deck_operations, only: jet_type
   use limber_model_driver_laws, only: driven_motion
   use limber_model_model, only: driver_angle, driver_joint_angle, ground
   use limber_model_switches, only: acts
   use limber_multibody_plane_vectors, only: turn, cross
   use limber_multibody_assembly_newton, only: close_positions, close_velocities, approach, move, change_between
   use limber_multibody_constraint_matrix, only: constraint_matrix_type, new_constraint_matrix, hold_columns, given_columns
   use limber_multibody_equations_of_motion, only: position_residual, velocity_residual
   use limber_multibody_kinematics, only: place_frames, move_frames
   use limber_multibody_layout, only: guess_place, rates_of, velocities_of
   use limber_multibody_multiplier_system, only: place_constraints
   use limber_multibody_constraint_rank, only: assembly_type, check_rank, check_branch, stretch_remedy
   use limber_multibody_redundant_constraints, only: constraint_names
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: assemble, first_guess, turn_rates

   !> Part of the largest residual above which a constraint that is left open takes part in a contradiction
   real(wp), parameter :: takes_part = 0.1_wp

contains

   !> State at the time t that satisfies all constraints.
   subroutine assemble(system, work, t, q, v, error, culprit, found, dense)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      !> Coordinates and velocities (nq): in, the guess; out, the assembled state
      real(wp), intent(inout) :: q(:), v(:)
      !> The scene cannot be assembled
      type(error_type), allocatable, intent(out) :: error
      !> Index of the constraint that the error is about
      integer, intent(out) :: culprit
      !> Rank, redundant equations, the way from the guess
      type(assembly_type), intent(inout), optional :: found
      !> Whether to use singular values; if not given, in small scenes
      logical, intent(in), optional :: dense
      type(assembly_type) :: unasked
      if (present(found)) then
         call put_together(system, work, t, q, v, error, culprit, found, dense)
      else
         call put_together(system, work, t, q, v, error, culprit, unasked, dense)
      end if
   end subroutine assemble

   !> The same, and what is found is wanted.
   subroutine put_together(system, work, t, q, v, error, culprit, result, dense)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      real(wp), intent(inout) :: q(:), v(:)
      type(error_type), allocatable, intent(out) :: error
      integer, intent(out) :: culprit
      type(assembly_type), intent(out) :: result
      logical, intent(in), optional :: dense
      type(constraint_matrix_type) :: frames, bodies
      real(wp), allocatable :: start(:)
      logical :: done
      culprit = 0
      allocate (result%redundancy, result%singular)
      result%rates = system%layout%nw - 2*count(system%layout%carries)
      result%equations = system%nc
      if (system%nc == 0) then
         allocate (result%redundancy%group(0), result%singular%group(0))
         call place_frames(system%model, system%layout, t, q, work%kinematics)
         return
      end if
      allocate (start(max(size(q), size(v))))
      start = q
      call new_constraint_matrix(system, .false., frames, dense)
      call new_constraint_matrix(system, .true., bodies, dense)
      call close_kept(system, work, frames, t, .false., q, v, done)
      if (.not. done) then
         q = start
         call close_positions(system, work, bodies, t, q, done)
         result%bends = done
      end if
      if (.not. done) then
         q = start
         call approach(system, work, frames, t, q)
         call report(system, work, t, error, culprit)
         return
      end if
      call find_turn(system, start, q, result)
      call turn_rates(system, start, q, v)
      call check_rank(system, work, bodies, t, q, result, error, culprit)
      if (allocated(error)) return
      frames%truncation = bodies%truncation
      start = v
      call close_kept(system, work, frames, t, .true., q, v, done)
      if (.not. done) then
         v = start
         call close_velocities(system, work, bodies, q, v, done)
      end if
      if (.not. done) then
         v = start
         call close_velocities(system, work, frames, q, v, done)
         call report_rates(system, work, t, v, error, culprit)
      else if (result%singular%count > 0) then
         call check_branch(system, work, bodies, q, v, result, error, culprit)
      end if
      if (.not. allocated(error) .and. result%rank < result%equations) &
         & call look_ahead(system, work, frames, t, q, v, error, culprit)
   end subroutine put_together

   !> Satisfies the constraints, or the velocity equations, by the frames, and keeps what the deck gives: all of it, or what can be
   !> kept together of that, angles before places, in the order of the bodies, eq. (4.28).
   subroutine close_kept(system, work, frames, t, rates, q, v, done)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(constraint_matrix_type), intent(inout) :: frames
      real(wp), intent(in) :: t
      !> Whether the velocity equations are meant
      logical, intent(in) :: rates
      !> Coordinates and velocities (nq)
      real(wp), intent(inout) :: q(:), v(:)
      logical, intent(out) :: done
      !> Numbers of given columns that are tried one by one
      integer, parameter :: most = 12
      real(wp) :: start(size(q)), kept(size(q))
      integer, allocatable :: given(:)
      logical :: held(frames%columns), any_kept
      integer :: i
      start = merge(v, q, rates)
      allocate (given, source=given_columns(system, frames, rates))
      held = .false.
      held(given) = .true.
      any_kept = .false.
      if (size(given) > 0) call try(any_kept)
      if (.not. any_kept) then
         held = .false.
         do i = 1, min(most, size(given))
            held(given(i)) = .true.
            call try(done)
            any_kept = any_kept .or. done
            held(given(i)) = done
         end do
      end if
      done = any_kept
      held = .false.
      if (.not. any_kept) then
         call try(done)
      else if (rates) then
         v = kept
         call move_frames(system%model, system%layout, q, v, work%kinematics)
      else
         q = kept
         call place_constraints(system, work, t, q)
      end if
      call hold_columns(frames, [(.false., i=1, frames%columns)])

   contains

      !> Closes with the columns held; what is found is kept.
      subroutine try(closed)
         logical, intent(out) :: closed
         call hold_columns(frames, held)
         if (rates) then
            v = start
            call close_velocities(system, work, frames, q, v, closed)
            if (closed) kept = v
         else
            q = start
            call close_positions(system, work, frames, t, q, closed)
            if (closed) kept = q
         end if
      end subroutine try

   end subroutine close_kept

   !> Turns the rates of the frames' vectors along with the frames: the guessed angular velocities stay.
   pure subroutine turn_rates(system, before, q, v)
      type(system_type), intent(in) :: system
      !> Coordinates before and after (nq)
      real(wp), intent(in) :: before(:), q(:)
      real(wp), intent(inout) :: v(:)
      real(wp) :: w(system%layout%nw)
      call rates_of(system%layout, before, v, w)
      call velocities_of(system%layout, q, w, v)
   end subroutine turn_rates

   !> Coordinates and velocities as the model guesses them; driven frames already point where they are driven.
   subroutine first_guess(system, t, q, v)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: t
      !> Coordinates and velocities (nq)
      real(wp), intent(out) :: q(:), v(:)
      type(jet_type) :: theta
      integer :: i, first
      call guess_place(system%model, system%layout, q)
      v = 0.0_wp
      do i = 1, size(system%model%bodies)
         associate (body => system%model%bodies(i))
            first = system%layout%q(i)
            v(first:first + 1) = body%velocity
            if (.not. system%layout%framed(i)) cycle
            v(first + 2:first + 3) = body%spin*[-sin(body%angle), cos(body%angle)]
         end associate
      end do
      if (allocated(system%model%assembly%deflections)) then
         do i = 1, size(system%model%assembly%deflections)
            associate (deflection => system%model%assembly%deflections(i))
               first = system%layout%q(deflection%body) + 3 + deflection%coordinate
               q(first) = deflection%value
               v(first) = deflection%rate
            end associate
         end do
      end if
      do i = 1, size(system%model%drivers)
         if (system%model%drivers(i)%kind /= driver_angle .or. .not. acts(system%model%drivers(i)%switch, system%on)) cycle
         theta = driven_motion(system%model%drivers(i), t)
         first = system%layout%q(system%model%drivers(i)%body) + 2
         q(first:first + 1) = [cos(theta%value), sin(theta%value)]
         v(first:first + 1) = theta%first*[-sin(theta%value), cos(theta%value)]
      end do
      call turn_held(system, q, v)
   end subroutine first_guess

   !> What a weld or guide holds at a given angle to a driven frame, and points away from it in the guess, points there at once:
   !> from beyond a right angle Newton's method finds the opposite direction, which satisfies the same equation.
   subroutine turn_held(system, q, v)
      type(system_type), intent(in) :: system
      !> Coordinates and velocities (nq)
      real(wp), intent(inout) :: q(:), v(:)
      real(wp) :: angle, wanted(2)
      logical :: driven(0:size(system%model%bodies)), more
      integer :: i, from, to, bodies(2)
      driven = .false.
      do i = 1, size(system%model%drivers)
         if (system%model%drivers(i)%kind == driver_angle .and. acts(system%model%drivers(i)%switch, system%on)) &
            & driven(system%model%drivers(i)%body) = .true.
      end do
      more = any(driven)
      do while (more)
         more = .false.
         do i = 1, size(system%model%joints)
            associate (joint => system%model%joints(i))
               if (.not. (joint%has_turn .and. joint%keeps_angle .and. acts(joint%switch, system%on))) cycle
               bodies = system%model%points(joint%points)%body
               if (any(bodies == ground) .or. (driven(bodies(1)) .eqv. driven(bodies(2)))) cycle
               if (.not. all(system%layout%framed(bodies))) cycle
               from = merge(bodies(1), bodies(2), driven(bodies(1)))
               to = sum(bodies) - from
               driven(to) = .true.
               more = .true.
               angle = merge(1, -1, to == bodies(1))*(joint%turn &
                  & + system%model%points(joint%points(1))%lean - system%model%points(joint%points(2))%lean)
               associate (u => q(system%layout%q(from) + 2:system%layout%q(from) + 3), &
                  & own => q(system%layout%q(to) + 2:system%layout%q(to) + 3), &
                  & rate => v(system%layout%q(to) + 2:system%layout%q(to) + 3))
                  wanted = cos(angle)*u + sin(angle)*turn(u)
                  if (dot_product(wanted, own) > 0.0_wp) cycle
                  rate = cross(own, rate)*turn(wanted)
                  own = wanted
               end associate
            end associate
         end do
      end do
   end subroutine turn_held

   !> The body that has turned most from its guess.
   pure subroutine find_turn(system, start, q, found)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: start(:), q(:)
      type(assembly_type), intent(inout) :: found
      real(wp) :: change(system%layout%nw)
      integer :: i
      call change_between(system, start, q, change)
      do i = 1, size(system%layout%w)
         if (.not. system%layout%framed(i)) cycle
         if (abs(change(system%layout%w(i) + 2)) <= found%turned) cycle
         found%turned = abs(change(system%layout%w(i) + 2))
         found%body = i
      end do
   end subroutine find_turn

   !> An error if drivers ask for a motion that the joints do not follow. At a singular position (a dead centre) velocities do not
   !> show that: a little later no position satisfies all of them.
   subroutine look_ahead(system, work, frames, t, q, v, error, culprit)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(constraint_matrix_type), intent(inout) :: frames
      real(wp), intent(in) :: t
      !> Assembled coordinates and velocities (nq)
      real(wp), intent(in) :: q(:), v(:)
      type(error_type), allocatable, intent(out) :: error
      integer, intent(inout) :: culprit
      !> Way of the fastest driver, as an angle or relative to the scene; residual relative to the scene that is no round-off
      real(wp), parameter :: way = 0.05_wp, open = 1.0e-5_wp
      real(wp), allocatable :: other(:)
      character(:), allocatable :: others
      real(wp) :: step(system%layout%nw), rate, later, residual
      rate = fastest_driver(system, t)
      if (.not. rate > 0.0_wp) return
      later = t + way/rate
      allocate (other, source=q)
      call rates_of(system%layout, q, v, step)
      call move(system, (way/rate)*step, other)
      call approach(system, work, frames, later, other)
      residual = position_residual(system, work)
      if (residual > open) then
         call find_parties(system, work%phi, culprit, residual, others)
         call raise(error, system%constraints(culprit)%item%label//' is at a dead centre or another singular position at t = '// &
            & as_text(t, 6)//', from where drivers and joints contradict each other'//others//'; '//as_text(residual, 3)// &
            & ' is left open at t = '//as_text(later, 6)//'. Remove one of the drivers, or let them agree')
         return
      end if
      call place_constraints(system, work, t, q)
      call move_frames(system%model, system%layout, q, v, work%kinematics)
   end subroutine look_ahead

   !> The largest rate of the drivers, angles or ways relative to the scene [1/time].
   real(wp) function fastest_driver(system, t) result(rate)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: t
      type(jet_type) :: theta
      real(wp) :: unit
      integer :: i
      rate = 0.0_wp
      do i = 1, size(system%model%drivers)
         if (.not. acts(system%model%drivers(i)%switch, system%on)) cycle
         theta = driven_motion(system%model%drivers(i), t)
         unit = system%model%length
         if (any(system%model%drivers(i)%kind == [driver_angle, driver_joint_angle])) unit = 1.0_wp
         rate = max(rate, abs(theta%first)/unit, sqrt(abs(theta%second)/unit))
      end do
   end function fastest_driver

   !> Error of rates that do not exist.
   subroutine report_rates(system, work, t, v, error, culprit)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t, v(:)
      type(error_type), allocatable, intent(out) :: error
      integer, intent(out) :: culprit
      character(:), allocatable :: others
      real(wp) :: residual
      residual = velocity_residual(system, work, v)
      call find_parties(system, work%gamma, culprit, residual, others)
      call raise(error, system%constraints(culprit)%item%label//': no velocities satisfy the constraints at t = '// &
         & as_text(t, 6)//others//'; the mechanism is at a dead centre or driven against a joint')
   end subroutine report_rates

   !> Error that names the constraint that is left open, and those that it contradicts.
   subroutine report(system, work, t, error, culprit)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      type(error_type), allocatable, intent(out) :: error
      integer, intent(out) :: culprit
      character(:), allocatable :: others
      real(wp) :: residual
      integer :: i
      residual = position_residual(system, work)
      call find_parties(system, work%phi, culprit, residual, others)
      call raise(error, system%constraints(culprit)%item%label//': the initial position cannot be assembled'//others//'; '// &
         & as_text(residual, 3)//' is left open at t = '//as_text(t, 6)// &
         & '. Check the lengths, or give a better first guess (X=, Y=, ANGLE=) for its bodies'// &
         & trim(merge('; a beam that is longer than its span goes without SEGMENTS', repeat(' ', 59), &
         & any(system%model%bodies%whole > 0)))// &
         & stretch_remedy(system, [(i == culprit, i=1, size(system%constraints))]))
   end subroutine report

   !> Who takes part in a contradiction: the constraint that is farthest from satisfied, the first one if several are, and others.
   subroutine find_parties(system, residuals, culprit, residual, others)
      type(system_type), intent(in) :: system
      !> Of all equations (nc)
      real(wp), intent(in) :: residuals(:)
      integer, intent(out) :: culprit
      !> Norm of its residual
      real(wp), intent(out) :: residual
      !> Text with the names of the others; empty if there are none
      character(:), allocatable, intent(out) :: others
      real(wp) :: part(size(system%constraints))
      logical :: other(size(part)), drives(size(part))
      integer :: i
      do i = 1, size(part)
         associate (item => system%constraints(i)%item)
            part(i) = norm2(residuals(item%first:item%first + item%rows - 1))/item%scale
         end associate
      end do
      do culprit = 1, size(part)
         if (part(culprit) > (1 - 1.0e-4_wp)*maxval(part)) exit
      end do
      culprit = min(culprit, size(part))
      residual = part(culprit)*system%constraints(culprit)%item%scale
      other = part > takes_part*part(culprit)
      other(culprit) = .false.
      do i = 1, size(part)
         if (system%constraints(i)%item%part_of > 0) other(i) = .false.
      end do
      others = ''
      if (any(other)) others = ': it contradicts '//constraint_names(system, other)
      ! At a dead centre a driver has no share: it is named all the same, for without it the others might go on
      other(culprit) = .true.
      drives = [(i > size(system%model%joints) .and. i <= size(system%model%joints) + size(system%model%drivers), &
         & i=1, size(part))]
      if (any(drives .and. .not. other)) others = others//' (the scene is driven by '//constraint_names(system, drives)//')'
   end subroutine find_parties

end module limber_multibody_assembly
