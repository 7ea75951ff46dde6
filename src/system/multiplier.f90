!> The multiplier system of index 1, its factorisation and its solution:
!>
!>    [ M   G^T ] [ a      ]   [ Q     ]
!>    [ G   0   ] [ lambda ] = [ gamma ]
!>
!> with the coordinates eta of each body condensed first (their mass matrix is the identity), so that a body enters
!> with three unknowns however many modes it has; and with the frames that hang on others, or are driven, expressed by those
!> that are free, so that their joints enter not at all. The same factors serve the accelerations and the projections onto the
!> position and velocity constraints. M may be singular as long as the whole is not. Floor: system.
!> Source: Han and Lee 1993, eq. (28); doc/theory, eqs. (14), (15), (32), (33a)-(33c).
module limber_system_multiplier
   use limber_base_kinds, only: wp
   use limber_model_scene, only: ground
   use limber_system_body, only: body_mass, rigid_mass
   use limber_system_condensation, only: condense_couplings, project_vector
   use limber_system_holding, only: split_motion
   use limber_system_system, only: system_type, workspace_type
   implicit none
   private
   public :: update_jacobians, update_masses, factor_multiplier_system, solve_multiplier_system, solve_gaps, &
      & recover_multipliers

contains

   !> Jacobians of all constraints at the placed kinematics.
   subroutine update_jacobians(system, work)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      integer :: i, column
      do i = 1, size(system%constraints)
         call system%constraints(i)%item%jacobian(work%kinematics, work%jacobians(1, i), work%jacobians(2, i))
      end do
      do i = 1, size(work%bodies)
         if (system%layout%n(i) == 0) cycle
         associate (body => work%bodies(i))
            do column = 1, size(body%rows)
               associate (from => body%sources(:, column))
                  body%eta_rows(:, column) = work%jacobians(from(2), from(1))%eta(from(3), :)
               end associate
               if (system%model%bodies(i)%reduced%condensed) call project_vector(system%model%bodies(i)%reduced, body%fold, &
                  & body%normal, body%eta_rows(:, column))
            end do
         end associate
      end do
   end subroutine update_jacobians

   !> Mass matrices of all bodies at the coordinates q; kinematics are placed.
   subroutine update_masses(system, work, q)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Coordinates (nq)
      real(wp), intent(in) :: q(:)
      integer :: i, first
      do i = 1, size(work%bodies)
         associate (body => work%bodies(i), reduced => system%model%bodies(i)%reduced)
            if (system%layout%framed(i) .and. system%layout%n(i) == 0) then
               call rigid_mass(system%inertia(:, i), work%kinematics%frames(i)%u, body%mass)
            else if (system%layout%framed(i)) then
               first = system%layout%q(i) + 4
               call body_mass(reduced, work%kinematics%frames(i)%u, q(first:first + reduced%n - 1), body%mass, body%coupling)
            else
               body%mass = 0.0_wp
               body%mass(1, 1) = system%inertia(1, i)
               body%mass(2, 2) = system%inertia(1, i)
            end if
         end associate
      end do
   end subroutine update_masses

   !> Builds and factors the condensed matrix at the coordinates q; kinematics are placed, Jacobians up to date.
   subroutine factor_multiplier_system(system, work, q, singular)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Coordinates (nq)
      real(wp), intent(in) :: q(:)
      !> True if a pivot is zero
      logical, intent(out) :: singular
      integer :: i
      call update_masses(system, work, q)
      if (system%condensed) call condense_couplings(system, work)
      call update_hanging(system, work)
      work%matrix%values = 0.0_wp
      do i = 1, size(work%bodies)
         associate (body => work%bodies(i), n => system%layout%n(i))
            if (n > 0) call condense_body(n, size(body%rows), body%coupling, body%eta_rows, body%rows_place, body%mass, &
               & work%matrix%values)
            if (system%tree%plain(i)) then
               call add_frame(body%frame_place, body%mass, work%matrix%values)
            else
               call add_hanging_frame(system%layout%rates(i), system%tree%count(i), body%frame_place, body%mass, body%hanging, &
                  & work%matrix%values)
            end if
         end associate
      end do
      call add_constraint_rows(system, work)
      if (system%redundant) call give_slack(system, work)
      call work%matrix%factor(singular)
   end subroutine factor_multiplier_system

   !> Lets redundant constraints give way, eq. (73).
   subroutine give_slack(system, work)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      integer :: i
      do i = 1, system%nc
         work%matrix%values(work%slack_place(i)) = work%matrix%values(work%slack_place(i)) - system%slack(i)
      end do
   end subroutine give_slack

   !> Accelerations of frames that hang on others, for unit values of the unknowns: those of the carrier at the joint, eq. (33a).
   !> Ones and zeros stand there already.
   subroutine update_hanging(system, work)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      integer :: i, k, column
      associate (tree => system%tree)
         do k = 1, size(tree%order)
            i = tree%order(k)
            if (tree%grip(i) > 0) call hold_frame(system, work, i)
            if (tree%carrier(i) == ground) cycle
            associate (hanging => work%bodies(i)%hanging, carrier => work%bodies(tree%carrier(i))%hanging, &
                  & lever => work%kinematics%markers(tree%marker(i))%lever)
               do column = 1, size(carrier, 2)
                  hanging(1, column) = carrier(1, column) + lever(1)*carrier(3, column)
                  hanging(2, column) = carrier(2, column) + lever(2)*carrier(3, column)
               end do
            end associate
         end do
      end associate
   end subroutine update_hanging

   !> What the rows that hold a frame leave free, and what they give, eqs. (152), (153).
   pure subroutine hold_frame(system, work, body)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      integer, intent(in) :: body
      real(wp) :: z(3, 3)
      integer :: k, row, rows
      row = 0
      associate (tree => system%tree)
         do k = 1, size(tree%holders, 1)
            if (tree%holders(k, body) == 0) exit
            associate (c => tree%holders(k, body))
               rows = system%constraints(c)%item%rows
               z(row + 1:row + rows, :) = work%jacobians(side_at(system, c, body), c)%z
               row = row + rows
            end associate
         end do
         call split_motion(system%layout%rates(body), row, z, system%model%length, work%bodies(body)%inverse, &
            & work%bodies(body)%hanging)
      end associate
   end subroutine hold_frame

   !> The side of a constraint that a body is.
   pure integer function side_at(system, constraint, body) result(side)
      type(system_type), intent(in) :: system
      integer, intent(in) :: constraint, body
      side = merge(1, 2, system%constraints(constraint)%item%bodies(1) == body)
   end function side_at

   !> Takes from a body's mass the part of eta, and adds what eta makes between the constraints.
   pure subroutine condense_body(n, rows, coupling, eta_rows, rows_place, mass, values)
      integer, intent(in) :: n, rows
      real(wp), intent(in) :: coupling(n, 3), eta_rows(n, rows)
      !> Places of the block between the constraint rows
      integer, intent(in) :: rows_place(rows, rows)
      real(wp), intent(inout) :: mass(3, 3)
      !> Entries of the multiplier matrix
      real(wp), contiguous, intent(inout) :: values(:)
      real(wp) :: part
      integer :: i, j, k
      do j = 1, 3
         do i = 1, j
            part = 0.0_wp
            do k = 1, n
               part = part + coupling(k, i)*coupling(k, j)
            end do
            mass(i, j) = mass(i, j) - part
            mass(j, i) = mass(i, j)
         end do
      end do
      do j = 1, rows
         do i = 1, j
            part = 0.0_wp
            do k = 1, n
               part = part + eta_rows(k, i)*eta_rows(k, j)
            end do
            values(rows_place(i, j)) = values(rows_place(i, j)) - part
            if (i /= j) values(rows_place(j, i)) = values(rows_place(j, i)) - part
         end do
      end do
   end subroutine condense_body

   !> Takes from a frame's force, and from the right-hand sides of the constraints on it, the part of eta.
   pure subroutine condense_force(n, rows, rates, coupling, eta_rows, eta_force, list, condensed, solution)
      integer, intent(in) :: n, rows, rates
      real(wp), intent(in) :: coupling(n, 3), eta_rows(n, rows), eta_force(n)
      !> Places of the constraints among the unknowns
      integer, intent(in) :: list(rows)
      real(wp), intent(inout) :: condensed(3)
      real(wp), contiguous, intent(inout) :: solution(:)
      real(wp) :: part
      integer :: j, k
      do j = 1, rates
         part = 0.0_wp
         do k = 1, n
            part = part + coupling(k, j)*eta_force(k)
         end do
         condensed(j) = condensed(j) - part
      end do
      do j = 1, rows
         part = 0.0_wp
         do k = 1, n
            part = part + eta_rows(k, j)*eta_force(k)
         end do
         solution(list(j)) = solution(list(j)) - part
      end do
   end subroutine condense_force

   !> Second derivatives of eta, eq. (14).
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

   !> Adds the mass of a free frame.
   pure subroutine add_frame(place, mass, values)
      integer, intent(in) :: place(:, :)
      real(wp), intent(in) :: mass(3, 3)
      real(wp), contiguous, intent(inout) :: values(:)
      integer :: i, j
      do j = 1, size(place, 2)
         do i = 1, size(place, 1)
            values(place(i, j)) = values(place(i, j)) + mass(i, j)
         end do
      end do
   end subroutine add_frame

   !> Adds the mass of a frame that hangs or is driven: hanging^T mass hanging.
   pure subroutine add_hanging_frame(rates, count, place, mass, hanging, values)
      integer, intent(in) :: rates, count
      integer, intent(in) :: place(count, count)
      real(wp), intent(in) :: mass(3, 3), hanging(rates, count)
      real(wp), contiguous, intent(inout) :: values(:)
      real(wp) :: product(3), part
      integer :: i, j, k
      do j = 1, count
         product = 0.0_wp
         do k = 1, rates
            product = product + mass(:, k)*hanging(k, j)
         end do
         do i = 1, count
            part = hanging(1, i)*product(1)
            do k = 2, rates
               part = part + hanging(k, i)*product(k)
            end do
            values(place(i, j)) = values(place(i, j)) + part
         end do
      end do
   end subroutine add_hanging_frame

   !> Adds the condensed Jacobian rows and their transposes.
   subroutine add_constraint_rows(system, work)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      integer :: i, side, body
      do i = 1, size(system%constraints)
         if (system%tree%row(system%constraints(i)%item%first) == 0) cycle
         do side = 1, 2
            body = system%constraints(i)%item%bodies(side)
            if (body == ground) cycle
            associate (jacobian => work%jacobians(side, i), scratch => work%bodies(body), rates => system%layout%rates(body))
               call condense_rows(size(jacobian%z, 1), system%layout%n(body), rates, jacobian%z, jacobian%eta, scratch%coupling, &
                  & jacobian%condensed)
               if (system%tree%plain(body)) then
                  call add_rows(size(jacobian%z, 1), rates, jacobian%condensed, jacobian%place, jacobian%transposed, &
                     & work%matrix%values)
               else
                  call add_hanging_rows(size(jacobian%z, 1), rates, system%tree%count(body), jacobian%condensed, &
                     & scratch%hanging, jacobian%place, jacobian%transposed, work%matrix%values)
               end if
            end associate
         end do
      end do
   end subroutine add_constraint_rows

   !> Rows of a Jacobian after the condensation of eta.
   pure subroutine condense_rows(rows, n, rates, z, eta, coupling, condensed)
      integer, intent(in) :: rows, n, rates
      real(wp), intent(in) :: z(rows, 3), eta(rows, n), coupling(n, 3)
      real(wp), intent(inout) :: condensed(rows, 3)
      integer :: j, k
      do j = 1, rates
         condensed(:, j) = z(:, j)
         do k = 1, n
            condensed(:, j) = condensed(:, j) - eta(:, k)*coupling(k, j)
         end do
      end do
   end subroutine condense_rows

   !> Adds rows on a free frame.
   pure subroutine add_rows(rows, rates, condensed, place, transposed, values)
      integer, intent(in) :: rows, rates
      real(wp), intent(in) :: condensed(rows, 3)
      integer, intent(in) :: place(rows, rates), transposed(rows, rates)
      real(wp), contiguous, intent(inout) :: values(:)
      integer :: row, j
      do j = 1, rates
         do row = 1, rows
            values(place(row, j)) = values(place(row, j)) + condensed(row, j)
            values(transposed(row, j)) = values(transposed(row, j)) + condensed(row, j)
         end do
      end do
   end subroutine add_rows

   !> Adds rows on a frame that hangs or is driven.
   pure subroutine add_hanging_rows(rows, rates, count, condensed, hanging, place, transposed, values)
      integer, intent(in) :: rows, rates, count
      real(wp), intent(in) :: condensed(rows, 3), hanging(rates, count)
      integer, intent(in) :: place(rows, count), transposed(rows, count)
      real(wp), contiguous, intent(inout) :: values(:)
      real(wp) :: value
      integer :: row, j, k
      do j = 1, count
         do row = 1, rows
            value = condensed(row, 1)*hanging(1, j)
            do k = 2, rates
               value = value + condensed(row, k)*hanging(k, j)
            end do
            values(place(row, j)) = values(place(row, j)) + value
            values(transposed(row, j)) = values(transposed(row, j)) + value
         end do
      end do
   end subroutine add_hanging_rows

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
      call set_bias(system, work, gamma)
      call set_right_side(system, work, gamma, still)
      call work%matrix%solve(work%solution)
      if (system%redundant) call refine(system, work)
      call expand(system, work, a)
   end subroutine solve_multiplier_system

   !> Takes out of the accelerations what constraints that give way have let pass, eq. (74).
   subroutine refine(system, work)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      integer, parameter :: rounds = 2
      integer :: round, i
      work%correction(system%tree%free + 1:) = work%solution(system%tree%free + 1:)
      do round = 1, rounds
         work%correction(:system%tree%free) = 0.0_wp
         do i = 1, system%nc
            work%correction(system%tree%free + i) = -system%slack(i)*work%correction(system%tree%free + i)
         end do
         call work%matrix%solve(work%correction)
         work%solution = work%solution + work%correction
      end do
   end subroutine refine

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
         work%bodies(i)%bias = 0.0_wp
         work%bodies(i)%eta_force = 0.0_wp
      end do
      if (system%tree%holds) then
         do i = 1, size(work%bodies)
            work%bodies(i)%force = 0.0_wp
         end do
         call set_bias(system, work, gaps)
         call set_right_side(system, work, gaps, .true.)
         call work%matrix%solve(work%solution)
         call expand(system, work, a)
         return
      end if
      work%solution(:system%tree%free) = 0.0_wp
      do i = 1, size(gaps)
         if (system%tree%row(i) > 0) work%solution(system%tree%row(i)) = gaps(i)
      end do
      call work%matrix%solve(work%solution)
      call expand(system, work, a)
   end subroutine solve_gaps

   !> Accelerations of all frames and coordinates from the unknowns.
   subroutine expand(system, work, a)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), contiguous, intent(out) :: a(:)
      integer :: i, j, first
      do i = 1, size(work%bodies)
         first = system%layout%q(i)
         associate (body => work%bodies(i))
            if (system%tree%plain(i)) then
               do j = 1, system%layout%rates(i)
                  body%acceleration(j) = work%solution(system%tree%columns(j, i))
               end do
            else
               call hang_frame(system%layout%rates(i), system%tree%count(i), system%tree%columns(:, i), body%hanging, body%bias, &
                  & work%solution, body%acceleration)
            end if
            a(first:first + 1) = body%acceleration(1:2)
            if (.not. system%layout%framed(i)) cycle
            a(first + 2:first + 3) = [body%acceleration(3), 0.0_wp]
            if (system%layout%n(i) > 0) call expand_eta(system%layout%n(i), size(body%rows), body%coupling, body%eta_rows, &
               & body%eta_force, body%rows, work%solution, body%acceleration, a(first + 4:first + 3 + system%layout%n(i)))
         end associate
      end do
   end subroutine expand

   !> What the joints and drivers of the tree give their frames beside the unknowns, eq. (33a).
   subroutine set_bias(system, work, gamma)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: gamma(:)
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
                  bias(1:2) = gamma(row:row + 1)*work%jacobians(tree%side(i), tree%joint(i))%z(1, 1)
                  if (tree%carrier(i) /= ground) then
                     associate (carrier => work%bodies(tree%carrier(i))%bias)
                        bias(1:2) = bias(1:2) + carrier(1:2) + work%kinematics%markers(tree%marker(i))%lever*carrier(3)
                     end associate
                  end if
               end if
               if (tree%driver(i) > 0) bias(3) = gamma(system%constraints(tree%driver(i))%item%first) &
                  & /work%jacobians(1, tree%driver(i))%z(1, 3)
            end associate
         end do
      end associate
   end subroutine set_bias

   !> What the rows that hold a frame give it beside the unknowns, eq. (154).
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

   !> Right-hand side of the unknowns, eqs. (15) and (33b).
   subroutine set_right_side(system, work, gamma, still)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: gamma(:)
      !> Whether there are no forces on eta
      logical, intent(in) :: still
      integer :: i, j, k, rates, column
      associate (tree => system%tree, solution => work%solution)
         solution(:tree%free) = 0.0_wp
         do k = 1, size(gamma)
            if (tree%row(k) > 0) solution(tree%row(k)) = gamma(k)
         end do
         do i = 1, size(work%bodies)
            rates = system%layout%rates(i)
            associate (body => work%bodies(i))
               body%condensed = body%force
               if (system%layout%n(i) > 0 .and. .not. still) call condense_force(system%layout%n(i), size(body%rows), rates, &
                  & body%coupling, body%eta_rows, body%eta_force, body%rows, body%condensed, solution)
               if (tree%plain(i)) then
                  do j = 1, rates
                     column = tree%columns(j, i)
                     solution(column) = solution(column) + body%condensed(j)
                  end do
                  cycle
               end if
               call add_hanging_force(rates, tree%count(i), tree%columns(:, i), body%hanging, body%bias, body%mass, &
                  & body%condensed, solution)
               do j = 1, size(body%rows)
                  associate (condensed => work%jacobians(body%sources(2, j), body%sources(1, j))%condensed)
                     do k = 1, rates
                        solution(body%rows(j)) = solution(body%rows(j)) - condensed(body%sources(3, j), k)*body%bias(k)
                     end do
                  end associate
               end do
            end associate
         end do
      end associate
   end subroutine set_right_side

   !> Accelerations of a frame that hangs or is driven, from the unknowns.
   pure subroutine hang_frame(rates, count, columns, hanging, bias, solution, acceleration)
      integer, intent(in) :: rates, count
      integer, intent(in) :: columns(count)
      real(wp), intent(in) :: hanging(rates, count), bias(3), solution(:)
      real(wp), intent(inout) :: acceleration(3)
      integer :: j
      acceleration = bias
      do j = 1, count
         acceleration(:rates) = acceleration(:rates) + hanging(:, j)*solution(columns(j))
      end do
   end subroutine hang_frame

   !> Force of such a frame, less that of its bias, on the unknowns.
   pure subroutine add_hanging_force(rates, count, columns, hanging, bias, mass, force, solution)
      integer, intent(in) :: rates, count
      integer, intent(in) :: columns(count)
      real(wp), intent(in) :: hanging(rates, count), bias(3), mass(3, 3), force(3)
      real(wp), intent(inout) :: solution(:)
      real(wp) :: left(3)
      integer :: j, k
      left = force
      do j = 1, rates
         left = left - mass(:, j)*bias(j)
      end do
      do j = 1, count
         do k = 1, rates
            solution(columns(j)) = solution(columns(j)) + hanging(k, j)*left(k)
         end do
      end do
   end subroutine add_hanging_force

   !> All multipliers after `solve_multiplier_system`, into work%lambda: those of the unknowns as they are, those of the tree from
   !> what the equations of their body leave, the last in the tree first, eq. (33c).
   subroutine recover_multipliers(system, work)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      integer :: i, j, k, row
      real(wp) :: left(3)
      associate (tree => system%tree)
         do k = 1, size(work%lambda)
            if (tree%row(k) > 0) work%lambda(k) = work%solution(tree%row(k))
         end do
         do k = size(tree%order), 1, -1
            i = tree%order(k)
            if (tree%plain(i)) cycle
            left = work%bodies(i)%condensed
            do j = 1, system%layout%rates(i)
               left = left - work%bodies(i)%mass(:, j)*work%bodies(i)%acceleration(j)
            end do
            associate (body => work%bodies(i))
               do j = 1, size(body%rows)
                  associate (condensed => work%jacobians(body%sources(2, j), body%sources(1, j))%condensed)
                     do row = 1, 3
                        left(row) = left(row) - condensed(body%sources(3, j), row)*work%solution(body%rows(j))
                     end do
                  end associate
               end do
            end associate
            j = tree%first(i)
            do while (j > 0)
               call take_borne(system, work, j, left)
               j = tree%next(j)
            end do
            if (tree%grip(i) > 0) then
               call recover_held(system, work, i, left)
               cycle
            end if
            if (tree%joint(i) > 0) then
               row = system%constraints(tree%joint(i))%item%first
               work%lambda(row:row + 1) = left(1:2)*work%jacobians(tree%side(i), tree%joint(i))%z(1, 1)
            end if
            if (tree%driver(i) > 0) then
               row = system%constraints(tree%driver(i))%item%first
               work%lambda(row) = left(3)/work%jacobians(1, tree%driver(i))%z(1, 3)
            end if
         end do
      end associate
   end subroutine recover_multipliers

   !> Multipliers of the rows that hold a frame, from what is left of its forces, eq. (155).
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

end module limber_system_multiplier
