!> Contacts of rigid stops at a state: gaps, what impulses at them do, and accelerations of the gaps. All contacts are open in the
!> system, so that impulses and forces at them act on what joints and drivers leave free. Floor: multibody. Source: doc/theory,
!> eqs. (5.85), (5.86), (5.89).
module limber_multibody_contact_impulses
   use limber_base_kinds, only: wp
   use limber_model_model, only: ground
   use limber_multibody_complementarity, only: solve_complementarity
   use limber_multibody_constraint, only: constraint_type, jacobian_type, new_jacobian
   use limber_multibody_contact_constraints, only: contact_constraint_type
   use limber_multibody_equations_of_motion, only: accelerations, accelerate
   use limber_multibody_idle_parts, only: idle_constraint_type
   use limber_multibody_kinematics, only: place_frames, move_frames
   use limber_multibody_layout, only: normalise_frames
   use limber_multibody_plane_vectors, only: cross
   use limber_multibody_system, only: system_type, workspace_type, contact_constraint
   implicit none
   private
   public :: gap_set_type, read_gaps, new_gap_set, speeds_at, lift_gaps, add_impulses, gap_accelerations, &
      & contact_push

   !> Mobility that counts as none, relative to that without joints
   real(wp), parameter :: stuck = 1.0e-13_wp

   !> Gaps that are looked at together
   type :: gap_set_type
      !> Indices of their contacts (n)
      integer, allocatable :: contacts(:)
      !> Gradient of each gap by the rates, and the rates that a unit impulse along it makes (nw, n)
      real(wp), allocatable :: rows(:, :), moves(:, :)
      !> Rate of each gap for a unit impulse at each (n, n)
      real(wp), allocatable :: mobility(:, :)
   end type gap_set_type

contains

   !> Gaps of all contacts and their rates at a state. Leaves the kinematics placed and moved.
   subroutine read_gaps(system, work, t, q, v, gap, rate, scale)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      !> Coordinates and velocities (nq)
      real(wp), contiguous, intent(in) :: q(:), v(:)
      !> (contacts) [length or rad], [per time]
      real(wp), intent(out) :: gap(:), rate(:)
      !> What their round-off is relative to (contacts) [length or rad]
      real(wp), intent(out) :: scale(:)
      real(wp) :: value, push
      integer :: i
      call place_frames(system%model, system%layout, t, q, work%kinematics)
      call move_frames(system%model, system%layout, q, v, work%kinematics)
      do i = 1, size(gap)
         associate (contact => system%model%contacts(i))
            associate (load => system%model%loads(contact%load))
               call system%loads(load%first)%item%state_along(work%kinematics, value, rate(i), push)
               gap(i) = contact%side*(value - (contact%limit - system%model%load_parts(load%first)%origin))
               rate(i) = contact%side*rate(i)
               scale(i) = abs(value) + merge(1.0_wp, system%model%length, load%angular)
            end associate
         end associate
      end do
   end subroutine read_gaps

   !> Gradients and mobilities of some gaps; `linearise` at the state comes first, with these contacts open.
   subroutine new_gap_set(system, work, contacts, set)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Indices of contacts (n)
      integer, intent(in) :: contacts(:)
      type(gap_set_type), intent(out) :: set
      integer :: i, j, n
      n = size(contacts)
      allocate (set%contacts, source=contacts)
      allocate (set%rows(system%layout%nw, n), set%moves(system%layout%nw, n), set%mobility(n, n))
      do i = 1, n
         call find_row(system, work, contacts(i), set%rows(:, i))
      end do
      do i = 1, n
         call accelerate(system, work, set%rows(:, i), set%moves(:, i))
      end do
      do j = 1, n
         do i = 1, n
            set%mobility(i, j) = dot_product(set%rows(:, i), set%moves(:, j))
         end do
      end do
      set%mobility = 0.5_wp*(set%mobility + transpose(set%mobility))
      do i = 1, n
         if (set%mobility(i, i) > stuck*free_mobility(system, set%rows(:, i))) cycle
         ! Nothing gives way: all that is left is round-off
         set%mobility(i, :) = 0.0_wp
         set%mobility(:, i) = 0.0_wp
      end do
   end subroutine new_gap_set

   !> Rate of a gap for a unit impulse at it, were there no joints. Bodies without mass are left out; inertias are those about the
   !> origins of frames.
   pure real(wp) function free_mobility(system, row) result(mobility)
      type(system_type), intent(in) :: system
      !> Its gradient (nw)
      real(wp), intent(in) :: row(:)
      integer :: i, first, rates, n
      mobility = 0.0_wp
      do i = 1, size(system%layout%q)
         first = system%layout%w(i)
         rates = system%layout%rates(i)
         n = system%layout%n(i)
         associate (body => system%model%bodies(i)%reduced)
            if (body%mass > 0.0_wp) mobility = mobility + dot_product(row(first:first + 1), row(first:first + 1))/body%mass
            if (rates > 2 .and. body%i0 > 0.0_wp) mobility = mobility + row(first + 2)**2/body%i0
         end associate
         mobility = mobility + dot_product(row(first + rates:first + rates + n - 1), row(first + rates:first + rates + n - 1))
      end do
   end function free_mobility

   !> Gradient of a gap by the rates of all bodies.
   subroutine find_row(system, work, contact, row)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Its index
      integer, intent(in) :: contact
      !> (nw)
      real(wp), intent(out) :: row(:)
      row = 0.0_wp
      select type (item => system%constraints(contact_constraint(system, contact))%item)
      type is (idle_constraint_type)
         call add_own(item%own)
      class default
         call add_own(item)
      end select
      row = system%model%contacts(contact)%side*row

   contains

      subroutine add_own(own)
         class(constraint_type), intent(in) :: own
         type(jacobian_type) :: sides(2)
         integer :: side, body, first, rates
         do side = 1, 2
            body = own%bodies(side)
            sides(side) = new_jacobian(1, merge(0, system%layout%n(max(1, body)), body == ground))
         end do
         call own%jacobian(work%kinematics, sides(1), sides(2))
         do side = 1, 2
            body = own%bodies(side)
            if (body == ground) cycle
            first = system%layout%w(body)
            rates = system%layout%rates(body)
            row(first:first + rates - 1) = row(first:first + rates - 1) + sides(side)%z(1, :rates)
            row(first + rates:first + rates + system%layout%n(body) - 1) = sides(side)%eta(1, :)
         end do
      end subroutine add_own

   end subroutine find_row

   !> What round-off of the rates of gaps is relative to: sums of the terms that they are made of (n).
   pure function speeds_at(system, work, set, v) result(speeds)
      type(system_type), intent(in) :: system
      !> Kinematics are placed
      type(workspace_type), intent(in) :: work
      type(gap_set_type), intent(in) :: set
      !> Velocities (nq)
      real(wp), intent(in) :: v(:)
      real(wp) :: speeds(size(set%contacts)), rates_of(system%layout%nw)
      integer :: i, first, from, rates, n
      do i = 1, size(system%layout%q)
         first = system%layout%q(i)
         from = system%layout%w(i)
         rates = system%layout%rates(i)
         n = system%layout%n(i)
         rates_of(from:from + 1) = v(first:first + 1)
         if (.not. system%layout%framed(i)) cycle
         rates_of(from + 2) = cross(work%kinematics%frames(i)%u, v(first + 2:first + 3))
         rates_of(from + rates:from + rates + n - 1) = v(first + 4:first + 3 + n)
      end do
      speeds = matmul(abs(rates_of), abs(set%rows))
   end function speeds_at

   !> Lifts coordinates by which gaps are below zero, least in the mass norm: what a projection onto joints has passed them by.
   subroutine lift_gaps(system, work, set, gap, q, v)
      type(system_type), intent(in) :: system
      !> Kinematics are placed
      type(workspace_type), intent(in) :: work
      type(gap_set_type), intent(in) :: set
      !> Small (n) [length or rad]
      real(wp), intent(in) :: gap(:)
      !> Coordinates, and velocities, which turn with their frames (nq)
      real(wp), intent(inout) :: q(:), v(:)
      real(wp) :: lift(size(gap)), way(size(q)), angle
      integer :: i, first
      logical :: solved
      call solve_complementarity(set%mobility, gap, lift, solved)
      if (.not. solved .or. .not. any(lift > 0.0_wp)) return
      way = 0.0_wp
      call add_impulses(system, work, set, lift, way)
      do i = 1, size(system%layout%q)
         if (.not. system%layout%framed(i)) cycle
         first = system%layout%q(i) + 2
         associate (u => work%kinematics%frames(i)%u)
            angle = cross(u, way(first:first + 1))
            v(first:first + 1) = v(first:first + 1) - angle*cross(u, v(first:first + 1))*u
         end associate
      end do
      q = q + way
      call normalise_frames(system%layout, q)
   end subroutine lift_gaps

   !> Changes velocities by impulses at gaps, eq. (5.86).
   subroutine add_impulses(system, work, set, impulses, v)
      type(system_type), intent(in) :: system
      !> Kinematics are placed
      type(workspace_type), intent(in) :: work
      type(gap_set_type), intent(in) :: set
      !> (n)
      real(wp), intent(in) :: impulses(:)
      !> (nq)
      real(wp), intent(inout) :: v(:)
      real(wp) :: change(system%layout%nw), omega
      integer :: i, first, from, rates, n
      change = matmul(set%moves, impulses)
      do i = 1, size(system%layout%q)
         first = system%layout%q(i)
         from = system%layout%w(i)
         rates = system%layout%rates(i)
         n = system%layout%n(i)
         v(first:first + 1) = v(first:first + 1) + change(from:from + 1)
         if (.not. system%layout%framed(i)) cycle
         associate (u => work%kinematics%frames(i)%u)
            omega = cross(u, v(first + 2:first + 3)) + change(from + 2)
            v(first + 2:first + 3) = omega*[-u(2), u(1)]
         end associate
         v(first + 4:first + 3 + n) = v(first + 4:first + 3 + n) + change(from + rates:from + rates + n - 1)
      end do
   end subroutine add_impulses

   !> Accelerations of gaps without forces at them, eq. (5.89), and what their round-off is relative to; `linearise` comes first.
   subroutine gap_accelerations(system, work, set, q, v, acceleration, scale)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(gap_set_type), intent(in) :: set
      !> Coordinates and velocities (nq)
      real(wp), contiguous, intent(in) :: q(:), v(:)
      !> (n)
      real(wp), intent(out) :: acceleration(:), scale(:)
      real(wp) :: a(system%layout%nq), rates_of_change(system%layout%nw), bias(1)
      integer :: i, first, rates, n
      call accelerations(system, work, q, v, a)
      do i = 1, size(work%bodies)
         first = system%layout%w(i)
         rates = system%layout%rates(i)
         n = system%layout%n(i)
         rates_of_change(first:first + rates - 1) = work%bodies(i)%acceleration(:rates)
         rates_of_change(first + rates:first + rates + n - 1) = a(system%layout%q(i) + 4:system%layout%q(i) + 3 + n)
      end do
      do i = 1, size(set%contacts)
         select type (item => system%constraints(contact_constraint(system, set%contacts(i)))%item)
         type is (idle_constraint_type)
            call item%own%gamma(work%kinematics, bias)
         type is (contact_constraint_type)
            call item%gamma(work%kinematics, bias)
         end select
         bias = system%model%contacts(set%contacts(i))%side*bias
         acceleration(i) = dot_product(set%rows(:, i), rates_of_change) - bias(1)
         scale(i) = dot_product(abs(set%rows(:, i)), abs(rates_of_change)) + abs(bias(1))
      end do
   end subroutine gap_accelerations

   !> Force of a contact along its gap, from the multipliers of the last accelerations; zero while it is open.
   pure real(wp) function contact_push(system, work, contact) result(push)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      !> Its index
      integer, intent(in) :: contact
      push = 0.0_wp
      associate (item => system%constraints(contact_constraint(system, contact))%item)
         if (item%rows > 0) push = -system%model%contacts(contact)%side*work%lambda(item%first)
      end associate
   end function contact_push

end module limber_multibody_contact_impulses
