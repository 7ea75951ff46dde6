!> The multiplier system of index 1 and its factorisation; `limber_system_solution` solves with the factors:
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
   public :: update_jacobians, update_masses, factor_multiplier_system, side_at

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

end module limber_system_multiplier
