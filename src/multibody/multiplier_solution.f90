!> Accelerations and projections by the factors of the multiplier system. Accelerations, projections onto the constraints, and the
!> multipliers of what hangs, is driven or held, which are no unknowns. Floor: multibody. Source: Han and Lee 1993, eq. (28);
!> doc/theory, eqs. (4.1), (4.4)-(4.6), (4.8), (4.11), (4.12), (4.34), (4.35).
module limber_multibody_multiplier_solution
   use limber_base_kinds, only: wp
   use limber_model_model, only: ground
   use limber_multibody_compliant_constraints, only: refine, next_correction, rounds
   use limber_multibody_unit_mass_coordinates, only: to_unit_mass, from_unit_mass
   use limber_multibody_multiplier_system, only: side_at
   use limber_multibody_system, only: system_type, workspace_type, body_workspace_type
   implicit none
   private
   public :: solve_multiplier_system, solve_gaps, recover_multipliers

contains

   !> Takes from a frame's force, and from the right-hand sides of the constraints on it, the part of eta.
   pure subroutine condense_force(n, rows, coupling, eta_rows, eta_force, list, condensed, solution)
      integer, intent(in) :: n, rows
      real(wp), intent(in) :: coupling(n, 3), eta_rows(n, rows), eta_force(n)
      !> Places of the constraints among the unknowns
      integer, intent(in) :: list(rows)
      real(wp), intent(inout) :: condensed(3)
      real(wp), contiguous, intent(inout) :: solution(:)
      real(wp) :: part, parts(3)
      integer :: j, k
      parts = 0.0_wp
      do k = 1, n
         parts(1) = parts(1) + coupling(k, 1)*eta_force(k)
         parts(2) = parts(2) + coupling(k, 2)*eta_force(k)
         parts(3) = parts(3) + coupling(k, 3)*eta_force(k)
      end do
      condensed = condensed - parts
      do j = 1, rows
         part = 0.0_wp
         do k = 1, n
            part = part + eta_rows(k, j)*eta_force(k)
         end do
         solution(list(j)) = solution(list(j)) - part
      end do
   end subroutine condense_force

   !> Second derivatives of eta, eq. (4.4).
   pure subroutine expand_eta(n, rows, coupling, eta_rows, eta_force, list, solution, acceleration, a)
      integer, intent(in) :: n, rows
      real(wp), intent(in) :: coupling(n, 3), eta_rows(n, rows), eta_force(n)
      integer, intent(in) :: list(rows)
      !> Unknowns, and accelerations of the frame
      real(wp), contiguous, intent(in) :: solution(:)
      real(wp), intent(in) :: acceleration(3)
      real(wp), intent(inout) :: a(n)
      integer :: j, k
      do k = 1, n
         a(k) = eta_force(k) - coupling(k, 1)*acceleration(1) - coupling(k, 2)*acceleration(2) - coupling(k, 3)*acceleration(3)
      end do
      do j = 1, rows
         do k = 1, n
            a(k) = a(k) - eta_rows(k, j)*solution(list(j))
         end do
      end do
   end subroutine expand_eta

   !> Solves with the factors. In: `force` and `eta_force` of each body in the workspace, `gamma` of the constraints.
   !> Out: a (nq layout; the places of u hold [alpha, 0]), and the multipliers of the unknowns in work%solution.
   subroutine solve_multiplier_system(system, work, gamma, a, still)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Right-hand sides of the constraints (nc)
      real(wp), intent(in) :: gamma(:)
      !> Frame accelerations, alpha and eta'' (nq)
      real(wp), contiguous, intent(out) :: a(:)
      !> Whether all forces are zero
      logical, intent(in) :: still
      integer :: i
      if (.not. still) then
         do i = 1, size(work%kinematics%beams)
            associate (body => work%bodies(work%kinematics%beams(i)))
               call to_unit_mass(body%factor, body%eta_force)
            end associate
         end do
      end if
      call set_bias(system, work, gamma)
      call set_right_side(system, work, gamma, still)
      call work%matrix%solve(work%solution)
      if (system%redundant) then
         associate (free => system%tree%free)
            call refine(work%matrix, free, system%slack, work%solution, work%correction)
            if (.not. still) then
               ! The last correction, and all before it, have the part of the multipliers that balances nothing, eq. (4.35)
               call next_correction(work%matrix, free, system%slack, work%correction)
               work%solution(free + 1:) = work%solution(free + 1:) - (rounds + 1)*work%correction(free + 1:)
            end if
         end associate
      end if
      call expand(system, work, a)
   end subroutine solve_multiplier_system

   !> The same without forces, and with all frames that hang in their places: only the other constraints have a right-hand side.
   subroutine solve_gaps(system, work, gaps, a)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Right-hand sides (nc); those of what hangs are not looked at, or zero
      real(wp), intent(in) :: gaps(:)
      !> As in `solve_multiplier_system`
      real(wp), contiguous, intent(out) :: a(:)
      integer :: i
      do i = 1, size(work%bodies)
         work%bodies(i)%force = 0.0_wp
         work%bodies(i)%eta_force = 0.0_wp
         work%bodies(i)%bias = 0.0_wp
      end do
      if (system%tree%holds) then
         call set_bias(system, work, gaps)
         call set_right_side(system, work, gaps, .true.)
      else
         work%solution(:system%tree%free) = 0.0_wp
         do i = 1, size(system%tree%equations)
            work%solution(system%tree%free + i) = gaps(system%tree%equations(i))
         end do
      end if
      call work%matrix%solve(work%solution)
      call expand(system, work, a)
   end subroutine solve_gaps

   !> Accelerations of all frames and coordinates from the unknowns.
   subroutine expand(system, work, a)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), contiguous, intent(out) :: a(:)
      integer :: i, first, last
      associate (layout => system%layout, tree => system%tree)
         call expand_frames(size(work%bodies), layout%q, layout%rates, tree%plain, tree%count, size(tree%columns, 1), &
            & tree%columns, work%solution, work%bodies, a)
         do i = 1, size(work%bodies)
            if (layout%n(i) == 0) cycle
            first = layout%q(i) + 4
            last = first + layout%n(i) - 1
            associate (body => work%bodies(i))
               call expand_eta(layout%n(i), size(body%rows), body%coupling, body%eta_rows, body%eta_force, body%rows, &
                  & work%solution, body%acceleration, a(first:last))
               if (allocated(body%factor)) call from_unit_mass(body%factor, a(first:last))
            end associate
         end do
      end associate
   end subroutine expand

   !> The part of the frames.
   pure subroutine expand_frames(n, places, rates, plain, counts, most, columns, solution, bodies, a)
      !> Number of bodies, first index and number of rates of each, whether these are unknowns
      integer, intent(in) :: n, places(n), rates(n)
      logical, intent(in) :: plain(n)
      !> Number of unknowns on which each depends, and their indices
      integer, intent(in) :: counts(n), most, columns(most, n)
      real(wp), contiguous, intent(in) :: solution(:)
      type(body_workspace_type), intent(inout) :: bodies(n)
      real(wp), contiguous, intent(inout) :: a(:)
      integer :: i, j, first
      do i = 1, n
         associate (body => bodies(i))
            if (plain(i)) then
               do j = 1, rates(i)
                  body%acceleration(j) = solution(columns(j, i))
               end do
            else
               call hang_frame(rates(i), counts(i), columns(:, i), body%hanging, body%bias, solution, body%acceleration)
            end if
            first = places(i)
            a(first) = body%acceleration(1)
            a(first + 1) = body%acceleration(2)
            if (rates(i) == 2) cycle
            a(first + 2) = body%acceleration(3)
            a(first + 3) = 0.0_wp
         end associate
      end do
   end subroutine expand_frames

   !> What the joints and drivers of the tree give their frames beside the unknowns, eq. (4.6).
   subroutine set_bias(system, work, gamma)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: gamma(:)
      !> Of the body's side in the joint that places it
      real(wp) :: sign
      integer :: i, k, row
      associate (tree => system%tree)
         do k = 1, size(tree%order)
            i = tree%order(k)
            if (tree%plain(i)) cycle
            associate (bias => work%bodies(i)%bias)
               bias = 0.0_wp
               if (tree%grip(i) > 0) then
                  call set_held_bias(system, work, i, gamma)
                  cycle
               end if
               if (tree%joint(i) > 0) then
                  row = system%constraints(tree%joint(i))%item%first
                  sign = merge(1.0_wp, -1.0_wp, tree%side(i) == 1)
                  bias(1) = sign*gamma(row)
                  bias(2) = sign*gamma(row + 1)
                  if (tree%carrier(i) /= ground) then
                     associate (carrier => work%bodies(tree%carrier(i))%bias, &
                        & lever => work%kinematics%markers(tree%marker(i))%lever)
                        bias(1) = bias(1) + carrier(1) + lever(1)*carrier(3)
                        bias(2) = bias(2) + carrier(2) + lever(2)*carrier(3)
                     end associate
                  end if
               end if
               if (tree%axis_rows(1, i) > 0) bias(1:2) = [gamma(tree%axis_rows(1, i)), gamma(tree%axis_rows(2, i))]
               if (tree%driver(i) > 0) bias(3) = gamma(system%constraints(tree%driver(i))%item%first) &
                  & /work%jacobians(1, tree%driver(i))%z(1, 3)
            end associate
         end do
      end associate
   end subroutine set_bias

   !> What the rows that hold a frame give it beside the unknowns, eq. (4.11).
   pure subroutine set_held_bias(system, work, body, gamma)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      integer, intent(in) :: body
      real(wp), intent(in) :: gamma(:)
      real(wp) :: right
      integer :: k, j, row, side, other
      row = 0
      do k = 1, size(system%tree%holders, 1)
         if (system%tree%holders(k, body) == 0) exit
         associate (c => system%tree%holders(k, body), bias => work%bodies(body)%bias, inverse => work%bodies(body)%inverse)
            side = 3 - side_at(system, c, body)
            other = system%constraints(c)%item%bodies(side)
            do j = 1, system%constraints(c)%item%rows
               right = gamma(system%constraints(c)%item%first + j - 1)
               if (other /= ground) right = right - dot_product(work%jacobians(side, c)%z(j, :), work%bodies(other)%bias)
               row = row + 1
               bias = bias + inverse(:, row)*right
            end do
         end associate
      end do
   end subroutine set_held_bias

   !> Right-hand side of the unknowns, eqs. (4.5), (4.7).
   subroutine set_right_side(system, work, gamma, still)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: gamma(:)
      !> Whether there are no forces on eta
      logical, intent(in) :: still
      integer :: i, j, k, rates, column
      associate (tree => system%tree, solution => work%solution)
         solution(:tree%free) = 0.0_wp
         do k = 1, size(tree%equations)
            solution(tree%free + k) = gamma(tree%equations(k))
         end do
         do i = 1, size(work%bodies)
            rates = system%layout%rates(i)
            associate (body => work%bodies(i))
               body%condensed = body%force
               if (system%layout%n(i) > 0 .and. .not. still) call condense_force(system%layout%n(i), size(body%rows), &
                  & body%coupling, body%eta_rows, body%eta_force, body%rows, body%condensed, solution)
               if (tree%plain(i)) then
                  do j = 1, rates
                     column = tree%columns(j, i)
                     solution(column) = solution(column) + body%condensed(j)
                  end do
                  cycle
               end if
               if (tree%count(i) > 0) call add_hanging_force(rates, tree%count(i), tree%columns(:, i), body%hanging, body%bias, &
                  & body%mass, body%condensed, solution)
               call take_bias(size(body%rows), body%rows, body%frame_rows, body%bias, solution)
            end associate
         end do
      end associate
   end subroutine set_right_side

   !> Accelerations of a frame that hangs or is driven, from the unknowns.
   pure subroutine hang_frame(rates, count, columns, hanging, bias, solution, acceleration)
      integer, intent(in) :: rates, count
      integer, intent(in) :: columns(count)
      real(wp), intent(in) :: hanging(rates, count), bias(3)
      real(wp), contiguous, intent(in) :: solution(:)
      real(wp), intent(inout) :: acceleration(3)
      integer :: j
      acceleration = bias
      do j = 1, count
         acceleration(1) = acceleration(1) + hanging(1, j)*solution(columns(j))
         acceleration(2) = acceleration(2) + hanging(2, j)*solution(columns(j))
         if (rates == 3) acceleration(3) = acceleration(3) + hanging(3, j)*solution(columns(j))
      end do
   end subroutine hang_frame

   !> Force of such a frame, less that of its bias, on the unknowns.
   pure subroutine add_hanging_force(rates, count, columns, hanging, bias, mass, force, solution)
      integer, intent(in) :: rates, count
      integer, intent(in) :: columns(count)
      real(wp), intent(in) :: hanging(rates, count), bias(3), mass(3, 3), force(3)
      real(wp), contiguous, intent(inout) :: solution(:)
      real(wp) :: left(3), push
      integer :: j
      do j = 1, 3
         left(j) = force(j) - (mass(j, 1)*bias(1) + mass(j, 2)*bias(2) + mass(j, 3)*bias(3))
      end do
      do j = 1, count
         push = hanging(1, j)*left(1) + hanging(2, j)*left(2)
         if (rates == 3) push = push + hanging(3, j)*left(3)
         solution(columns(j)) = solution(columns(j)) + push
      end do
   end subroutine add_hanging_force

   !> Takes from the right-hand sides of the constraints on such a frame what its bias makes of them.
   pure subroutine take_bias(rows, list, frame_rows, bias, solution)
      integer, intent(in) :: rows
      !> Places of the constraints among the unknowns
      integer, intent(in) :: list(rows)
      real(wp), intent(in) :: frame_rows(3, rows), bias(3)
      real(wp), contiguous, intent(inout) :: solution(:)
      integer :: j
      do j = 1, rows
         solution(list(j)) = solution(list(j)) - (frame_rows(1, j)*bias(1) + frame_rows(2, j)*bias(2) + frame_rows(3, j)*bias(3))
      end do
   end subroutine take_bias

   !> All multipliers after `solve_multiplier_system`, into work%lambda: those of the unknowns as they are, those of the tree from
   !> what the equations of their body leave, the last in the tree first, eq. (4.8).
   subroutine recover_multipliers(system, work)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      integer :: i, j, k, row, placed
      real(wp) :: left(3), sign
      associate (tree => system%tree)
         do k = 1, size(tree%equations)
            work%lambda(tree%equations(k)) = work%solution(tree%free + k)
         end do
         do k = size(tree%order), 1, -1
            i = tree%order(k)
            if (tree%plain(i)) cycle
            associate (body => work%bodies(i))
               call find_left(size(body%rows), body%rows, body%mass, body%frame_rows, body%condensed, body%acceleration, &
                  & work%solution, left)
            end associate
            j = tree%span%first(i)
            do while (j > 0)
               placed = tree%body((j + 1)/2)
               if (placed /= 0 .and. placed /= i) call take_borne(system, work, j, left)
               j = tree%span%next(j)
            end do
            if (tree%grip(i) > 0) then
               call recover_held(system, work, i, left)
               cycle
            end if
            if (tree%joint(i) > 0) then
               row = system%constraints(tree%joint(i))%item%first
               sign = merge(1.0_wp, -1.0_wp, tree%side(i) == 1)
               work%lambda(row) = sign*left(1)
               work%lambda(row + 1) = sign*left(2)
            end if
            if (tree%axis_rows(1, i) > 0) then
               work%lambda(tree%axis_rows(1, i)) = left(1)
               work%lambda(tree%axis_rows(2, i)) = left(2)
            end if
            if (tree%driver(i) > 0) then
               row = system%constraints(tree%driver(i))%item%first
               work%lambda(row) = left(3)/work%jacobians(1, tree%driver(i))%z(1, 3)
            end if
         end do
      end associate
   end subroutine recover_multipliers

   !> What the accelerations and the multipliers of the unknowns leave of a frame's force.
   pure subroutine find_left(rows, list, mass, frame_rows, force, acceleration, solution, left)
      integer, intent(in) :: rows
      !> Places of the constraints among the unknowns
      integer, intent(in) :: list(rows)
      real(wp), intent(in) :: mass(3, 3), frame_rows(3, rows), force(3), acceleration(3)
      real(wp), contiguous, intent(in) :: solution(:)
      real(wp), intent(out) :: left(3)
      integer :: i, j
      do i = 1, 3
         left(i) = force(i) - (mass(i, 1)*acceleration(1) + mass(i, 2)*acceleration(2) + mass(i, 3)*acceleration(3))
      end do
      do j = 1, rows
         do i = 1, 3
            left(i) = left(i) - frame_rows(i, j)*solution(list(j))
         end do
      end do
   end subroutine find_left

   !> Multipliers of the rows that hold a frame, from what is left of its forces, eq. (4.12).
   pure subroutine recover_held(system, work, body, left)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      integer, intent(in) :: body
      real(wp), intent(in) :: left(3)
      integer :: k, j, row
      row = 0
      do k = 1, size(system%tree%holders, 1)
         if (system%tree%holders(k, body) == 0) exit
         associate (item => system%constraints(system%tree%holders(k, body))%item)
            do j = item%first, item%first + item%rows - 1
               row = row + 1
               work%lambda(j) = dot_product(work%bodies(body)%inverse(:, row), left)
            end do
         end associate
      end do
   end subroutine recover_held

   !> Takes from what is left of a body's forces those of a constraint that places another one on it.
   pure subroutine take_borne(system, work, number, left)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      !> Of the constraint's side, 2 (c - 1) + s
      integer, intent(in) :: number
      real(wp), intent(inout) :: left(3)
      integer :: row, c
      c = (number + 1)/2
      do row = 1, system%constraints(c)%item%rows
         left = left - work%jacobians(number - 2*(c - 1), c)%z(row, :)*work%lambda(system%constraints(c)%item%first + row - 1)
      end do
   end subroutine take_borne

end module limber_multibody_multiplier_solution
