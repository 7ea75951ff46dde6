!> System of index 1 with Lagrange multipliers and its factors.
!>
!>    [ M   G^T ] [ a      ]   [ Q     ]
!>    [ G   0   ] [ lambda ] = [ gamma ]
!>
!> with the coordinates eta of each body condensed first (their mass matrix is the identity), so that a body enters
!> with three unknowns however many modes it has; and with the frames that hang on others, or are driven, expressed by those
!> that are free, so that their joints enter not at all. The same factors serve the accelerations and the projections onto the
!> position and velocity constraints. M may be singular as long as the whole is not. Floor: multibody.
!> Source: Han and Lee 1993, eq. (28); doc/theory, eqs. (4.1), (4.4)-(4.6), (4.8).
module limber_multibody_multiplier_system
   use limber_base_kinds, only: wp
   use limber_model_model, only: ground
   use limber_multibody_body, only: body_mass, rigid_mass
   use limber_multibody_constraint, only: jacobian_type
   use limber_multibody_kinematics, only: place_frames
   use limber_multibody_unit_mass_coordinates, only: to_unit_mass
   use limber_multibody_known_bodies, only: split_motion
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: place_constraints, place_jacobians, update_jacobians, update_masses, update_beam_masses, factor_multiplier_system, &
      & side_at

contains

   !> Kinematics and Jacobians at (t, q).
   subroutine place_constraints(system, work, t, q)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t
      !> Coordinates (nq)
      real(wp), contiguous, intent(in) :: q(:)
      call place_frames(system%model, system%layout, t, q, work%kinematics)
      call update_jacobians(system, work)
   end subroutine place_constraints

   !> Jacobians of all constraints at the placed kinematics.
   subroutine place_jacobians(system, work)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      integer :: i
      do i = 1, size(system%constraints)
         call system%constraints(i)%item%jacobian(work%kinematics, work%jacobians(1, i), work%jacobians(2, i))
      end do
   end subroutine place_jacobians

   !> The same, and their rows of eta as the multiplier system has them.
   subroutine update_jacobians(system, work)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      integer :: i, column
      call place_jacobians(system, work)
      do i = 1, size(work%bodies)
         if (system%layout%n(i) == 0) cycle
         associate (body => work%bodies(i))
            do column = 1, size(body%rows)
               associate (from => body%sources(:, column))
                  body%eta_rows(:, column) = work%jacobians(from(2), from(1))%eta(from(3), :)
               end associate
               if (allocated(body%factor)) call to_unit_mass(body%factor, body%eta_rows(:, column))
            end do
         end associate
      end do
   end subroutine update_jacobians

   !> Mass matrices of all bodies but exact beams at the coordinates q; kinematics are placed.
   subroutine update_masses(system, work, q)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Coordinates (nq)
      real(wp), contiguous, intent(in) :: q(:)
      integer :: i, first
      do i = 1, size(work%bodies)
         if (system%model%bodies(i)%reduced%is_exact) cycle
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

   !> Mass matrices of exact beams, without those of their coordinates alone; kinematics are placed.
   subroutine update_beam_masses(work)
      type(workspace_type), intent(inout) :: work
      integer :: i
      do i = 1, size(work%kinematics%beams)
         associate (body => work%bodies(work%kinematics%beams(i)), frame => work%kinematics%frames(work%kinematics%beams(i)))
            call work%kinematics%lines(i)%mass_matrix(frame%u, body%mass, body%coupling)
         end associate
      end do
   end subroutine update_beam_masses

   !> Builds and factors the condensed matrix at the coordinates q; kinematics are placed, Jacobians up to date.
   subroutine factor_multiplier_system(system, work, q, singular)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Coordinates (nq)
      real(wp), contiguous, intent(in) :: q(:)
      !> True if a pivot is zero
      logical, intent(out) :: singular
      integer :: i, j
      call update_masses(system, work, q)
      if (system%exact) call update_beam_masses(work)
      do i = 1, size(work%kinematics%beams)
         associate (body => work%bodies(work%kinematics%beams(i)))
            do j = 1, 3
               call to_unit_mass(body%factor, body%coupling(:, j))
            end do
         end associate
      end do
      call update_hanging(system, work)
      work%matrix%values = 0.0_wp
      do i = 1, size(work%bodies)
         associate (body => work%bodies(i), n => system%layout%n(i), rows => size(work%bodies(i)%rows))
            call take_rows(rows, size(system%constraints), body%sources, work%jacobians, body%frame_rows)
            if (n > 0) call condense_body(n, rows, body%coupling, body%eta_rows, body%rows_place, body%mass, body%frame_rows, &
               & work%matrix%values)
            if (system%tree%plain(i)) then
               call add_frame(system%layout%rates(i), rows, body%frame_place, body%across_place, body%transposed_place, body%mass, &
                  & body%frame_rows, work%matrix%values)
            else if (system%tree%count(i) > 0) then
               call add_hanging_frame(system%layout%rates(i), system%tree%count(i), rows, body%frame_place, body%across_place, &
                  & body%transposed_place, body%mass, body%frame_rows, body%hanging, work%matrix%values)
            end if
         end associate
      end do
      if (system%redundant) call give_slack(system, work)
      call work%matrix%factor(singular)
   end subroutine factor_multiplier_system

   !> Rows of the Jacobians on a frame.
   pure subroutine take_rows(rows, constraints, sources, jacobians, frame_rows)
      integer, intent(in) :: rows, constraints
      !> Where each comes from: constraint, side, row in it
      integer, intent(in) :: sources(3, rows)
      type(jacobian_type), intent(in) :: jacobians(2, constraints)
      real(wp), intent(inout) :: frame_rows(3, rows)
      integer :: row, k
      do row = 1, rows
         associate (z => jacobians(sources(2, row), sources(1, row))%z)
            do k = 1, 3
               frame_rows(k, row) = z(sources(3, row), k)
            end do
         end associate
      end do
   end subroutine take_rows

   !> Lets redundant constraints give way, eq. (4.33).
   subroutine give_slack(system, work)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      integer :: i
      do i = 1, system%nc
         work%matrix%values(work%slack_place(i)) = work%matrix%values(work%slack_place(i)) - system%slack(i)
      end do
   end subroutine give_slack

   !> Accelerations of frames that hang on others, for unit values of the unknowns: those of the carrier at the joint, eq. (4.6).
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

   !> What the rows that hold a frame leave free, and what they give, eqs. (4.9), (4.10): as it was if they have not turned.
   pure subroutine hold_frame(system, work, body)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      integer, intent(in) :: body
      logical :: turned
      integer :: k, j, side, row
      row = 0
      turned = .false.
      associate (tree => system%tree, scratch => work%bodies(body))
         do k = 1, size(tree%holders, 1)
            if (tree%holders(k, body) == 0) exit
            side = side_at(system, tree%holders(k, body), body)
            associate (z => work%jacobians(side, tree%holders(k, body))%z)
               do j = 1, size(z, 1)
                  row = row + 1
                  if (.not. any(abs(scratch%held(row, :) - z(j, :)) > 0.0_wp)) cycle
                  scratch%held(row, :) = z(j, :)
                  turned = .true.
               end do
            end associate
         end do
         if (turned) call split_motion(system%layout%rates(body), row, scratch%held, system%model%length, scratch%inverse, &
            & scratch%hanging)
      end associate
   end subroutine hold_frame

   !> The side of a constraint that a body is.
   pure integer function side_at(system, constraint, body) result(side)
      type(system_type), intent(in) :: system
      integer, intent(in) :: constraint, body
      side = merge(1, 2, system%constraints(constraint)%item%bodies(1) == body)
   end function side_at

   !> Takes from a body's mass, and from the constraint rows on its frame, the part of eta, and adds what eta makes between the
   !> constraints, eq. (4.5).
   pure subroutine condense_body(n, rows, coupling, eta_rows, rows_place, mass, frame_rows, values)
      integer, intent(in) :: n, rows
      real(wp), intent(in) :: coupling(n, 3), eta_rows(n, rows)
      !> Places of the block between the constraint rows
      integer, intent(in) :: rows_place(rows, rows)
      real(wp), intent(inout) :: mass(3, 3), frame_rows(3, rows)
      !> Entries of the multiplier matrix
      real(wp), contiguous, intent(inout) :: values(:)
      real(wp) :: part(3), square(3), product
      integer :: i, j, k
      part = 0.0_wp
      square = 0.0_wp
      do k = 1, n
         square(1) = square(1) + coupling(k, 1)**2
         square(2) = square(2) + coupling(k, 2)**2
         square(3) = square(3) + coupling(k, 3)**2
         part(1) = part(1) + coupling(k, 2)*coupling(k, 3)
         part(2) = part(2) + coupling(k, 1)*coupling(k, 3)
         part(3) = part(3) + coupling(k, 1)*coupling(k, 2)
      end do
      mass(:, 1) = mass(:, 1) - [square(1), part(3), part(2)]
      mass(:, 2) = mass(:, 2) - [part(3), square(2), part(1)]
      mass(:, 3) = mass(:, 3) - [part(2), part(1), square(3)]
      do j = 1, rows
         part = 0.0_wp
         do k = 1, n
            part(1) = part(1) + coupling(k, 1)*eta_rows(k, j)
            part(2) = part(2) + coupling(k, 2)*eta_rows(k, j)
            part(3) = part(3) + coupling(k, 3)*eta_rows(k, j)
         end do
         frame_rows(:, j) = frame_rows(:, j) - part
         do i = 1, j
            product = 0.0_wp
            do k = 1, n
               product = product + eta_rows(k, i)*eta_rows(k, j)
            end do
            values(rows_place(i, j)) = values(rows_place(i, j)) - product
            if (i /= j) values(rows_place(j, i)) = values(rows_place(j, i)) - product
         end do
      end do
   end subroutine condense_body

   !> Adds the mass of a free frame, and the constraint rows on it.
   pure subroutine add_frame(rates, rows, place, across, transposed, mass, frame_rows, values)
      integer, intent(in) :: rates, rows
      integer, intent(in) :: place(rates, rates), across(rows, rates), transposed(rows, rates)
      real(wp), intent(in) :: mass(3, 3), frame_rows(3, rows)
      real(wp), contiguous, intent(inout) :: values(:)
      integer :: i, j
      do j = 1, rates
         do i = 1, rates
            values(place(i, j)) = values(place(i, j)) + mass(i, j)
         end do
         do i = 1, rows
            values(across(i, j)) = values(across(i, j)) + frame_rows(j, i)
            values(transposed(i, j)) = values(transposed(i, j)) + frame_rows(j, i)
         end do
      end do
   end subroutine add_frame

   !> The same of a frame that hangs or is driven: hanging^T mass hanging, and rows hanging.
   pure subroutine add_hanging_frame(rates, count, rows, place, across, transposed, mass, frame_rows, hanging, values)
      integer, intent(in) :: rates, count, rows
      integer, intent(in) :: place(count, count), across(rows, count), transposed(rows, count)
      real(wp), intent(in) :: mass(3, 3), frame_rows(3, rows), hanging(rates, count)
      real(wp), contiguous, intent(inout) :: values(:)
      real(wp) :: turning, product(3), part
      integer :: i, j
      turning = 0.0_wp
      do j = 1, count
         if (rates == 3) turning = hanging(3, j)
         do i = 1, 3
            product(i) = mass(i, 1)*hanging(1, j) + mass(i, 2)*hanging(2, j) + mass(i, 3)*turning
         end do
         do i = 1, count
            part = hanging(1, i)*product(1) + hanging(2, i)*product(2)
            if (rates == 3) part = part + hanging(3, i)*product(3)
            values(place(i, j)) = values(place(i, j)) + part
         end do
         do i = 1, rows
            part = frame_rows(1, i)*hanging(1, j) + frame_rows(2, i)*hanging(2, j) + frame_rows(3, i)*turning
            values(across(i, j)) = values(across(i, j)) + part
            values(transposed(i, j)) = values(transposed(i, j)) + part
         end do
      end do
   end subroutine add_hanging_frame

end module limber_multibody_multiplier_system
