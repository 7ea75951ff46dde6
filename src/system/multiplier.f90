!> The multiplier system of index 1, its factorisation and its solution:
!>
!>    [ M   G^T ] [ a      ]   [ Q     ]
!>    [ G   0   ] [ lambda ] = [ gamma ]
!>
!> with the coordinates eta of each body condensed first (their mass matrix is the identity), so that a body enters
!> with three unknowns however many modes it has. The same factors serve the accelerations and the projections onto the
!> position and velocity constraints. M may be singular as long as the whole is not. Floor: system.
!> Source: Han and Lee 1993, eq. (28); doc/theory, eqs. (14), (15), (32).
module limber_system_multiplier
   use limber_base_kinds, only: wp
   use limber_model_scene, only: ground
   use limber_system_body, only: body_mass
   use limber_system_system, only: system_type, workspace_type
   implicit none
   private
   public :: update_jacobians, update_masses, factor_multiplier_system, solve_multiplier_system

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
            if (system%layout%framed(i)) then
               first = system%layout%q(i) + 4
               call body_mass(reduced, work%kinematics%frames(i)%u, q(first:first + reduced%n - 1), body%mass, body%coupling)
            else
               body%mass = 0.0_wp
               body%mass(1, 1) = reduced%mass
               body%mass(2, 2) = reduced%mass
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
      work%matrix%values = 0.0_wp
      do i = 1, size(work%bodies)
         associate (body => work%bodies(i), n => system%layout%n(i))
            if (n > 0) call condense_body(n, body%coupling, body%eta_rows, body%rows_place, body%mass, work%matrix%values)
            call add_frame(body%frame_place, body%mass, work%matrix%values)
         end associate
      end do
      call add_constraint_rows(system, work)
      call work%matrix%factor(singular)
   end subroutine factor_multiplier_system

   !> Takes from a body's mass the part of eta, and adds what eta makes between the constraints.
   pure subroutine condense_body(n, coupling, eta_rows, rows_place, mass, values)
      integer, intent(in) :: n
      !> (n,3), (n,rows)
      real(wp), intent(in) :: coupling(:, :), eta_rows(:, :)
      !> Places of the block between the constraint rows (rows,rows)
      integer, intent(in) :: rows_place(:, :)
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
      do j = 1, size(rows_place, 2)
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

   !> Adds the mass of a frame.
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

   !> Adds the condensed Jacobian rows and their transposes.
   subroutine add_constraint_rows(system, work)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      integer :: i, side, body, row, j, k
      real(wp) :: value
      do i = 1, size(system%constraints)
         do side = 1, 2
            body = system%constraints(i)%item%bodies(side)
            if (body == ground) cycle
            associate (jacobian => work%jacobians(side, i), coupling => work%bodies(body)%coupling, values => work%matrix%values)
               do j = 1, system%layout%rates(body)
                  do row = 1, size(jacobian%z, 1)
                     value = jacobian%z(row, j)
                     do k = 1, size(jacobian%eta, 2)
                        value = value - jacobian%eta(row, k)*coupling(k, j)
                     end do
                     values(jacobian%place(row, j)) = values(jacobian%place(row, j)) + value
                     values(jacobian%transposed(row, j)) = values(jacobian%transposed(row, j)) + value
                  end do
               end do
            end associate
         end do
      end do
   end subroutine add_constraint_rows

   !> Solves with the factors. In: `force` and `eta_force` of each body in the workspace, `gamma` of the constraints.
   !> Out: a (nq layout; the places of u hold [alpha, 0]) and work%lambda.
   subroutine solve_multiplier_system(system, work, gamma, a)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Right-hand sides of the constraints (nc)
      real(wp), intent(in) :: gamma(:)
      !> Frame accelerations, alpha and eta'' (nq)
      real(wp), intent(out) :: a(:)
      integer :: i, j, k, first, rates
      real(wp) :: value
      work%solution(system%layout%nz + 1:) = gamma
      do i = 1, size(work%bodies)
         first = system%layout%z(i)
         rates = system%layout%rates(i)
         associate (body => work%bodies(i))
            work%solution(first:first + rates - 1) = body%force(1:rates)
            do k = 1, system%layout%n(i)
               do j = 1, rates
                  work%solution(first + j - 1) = work%solution(first + j - 1) - body%coupling(k, j)*body%eta_force(k)
               end do
               do j = 1, size(body%rows)
                  work%solution(system%layout%nz + body%rows(j)) = work%solution(system%layout%nz + body%rows(j)) &
                     & - body%eta_rows(k, j)*body%eta_force(k)
               end do
            end do
         end associate
      end do
      call work%matrix%solve(work%solution)
      work%lambda = work%solution(system%layout%nz + 1:)
      do i = 1, size(work%bodies)
         first = system%layout%q(i)
         associate (body => work%bodies(i), frame => work%solution(system%layout%z(i):))
            a(first:first + 1) = frame(1:2)
            if (.not. system%layout%framed(i)) cycle
            a(first + 2:first + 3) = [frame(3), 0.0_wp]
            do k = 1, system%layout%n(i)
               value = body%eta_force(k)
               do j = 1, 3
                  value = value - body%coupling(k, j)*frame(j)
               end do
               do j = 1, size(body%rows)
                  value = value - body%eta_rows(k, j)*work%lambda(body%rows(j))
               end do
               a(first + 3 + k) = value
            end do
         end associate
      end do
   end subroutine solve_multiplier_system

end module limber_system_multiplier
