!> Axial coordinates that follow at rest: eta_a = h(eta_b), with the foreshortening h of the bending, so that they have no
!> accelerations of their own and no vibrations. What loads them, inertia included, acts on the bending through the derivative H
!> of h; the stretch that it makes is found afterwards.
!>
!> In the multiplier system the coordinates of a body are condensed with a mass matrix that is the identity. Bound to
!> eta_a'' = H eta_b'' + b, they still are, if couplings, rows and forces are projected onto the motions [I; H]: nothing else of
!> the solution changes. Floor: system. Source: doc/theory, eqs. (137)-(144).
module limber_system_condensation
   use limber_base_kinds, only: wp
   use limber_flex_folding, only: foreshortening, fold_matrix
   use limber_flex_reduced, only: reduced_type
   use limber_model_scene, only: ground
   use limber_system_system, only: system_type, workspace_type, body_workspace_type
   implicit none
   private
   public :: update_folds, project_vector, condense_couplings, condense_forces, gather_loads, push_bending, release_axial
   public :: place_axial, place_axial_rates, stretch_axial, axial_posture

contains

   !> H and the factor of I + H^T H of each body at the coordinates q.
   pure subroutine update_folds(system, work, q)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Coordinates (nq)
      real(wp), intent(in) :: q(:)
      integer :: i, first
      do i = 1, size(work%bodies)
         associate (reduced => system%model%bodies(i)%reduced, body => work%bodies(i))
            if (.not. reduced%condensed) cycle
            first = system%layout%q(i) + 3
            call fold_matrix(reduced, q(first + 1:first + reduced%bending), body%fold)
            if (reduced%full) call factor_normal(body%fold, body%normal)
         end associate
      end do
   end subroutine update_folds

   !> Cholesky factor of I + H^T H, in the lower triangle.
   pure subroutine factor_normal(fold, normal)
      real(wp), intent(in) :: fold(:, :)
      real(wp), intent(inout) :: normal(:, :)
      integer :: i, j, k
      do j = 1, size(normal, 2)
         do i = j, size(normal, 2)
            normal(i, j) = merge(1.0_wp, 0.0_wp, i == j)
            do k = 1, size(fold, 1)
               normal(i, j) = normal(i, j) + fold(k, i)*fold(k, j)
            end do
            do k = 1, j - 1
               normal(i, j) = normal(i, j) - normal(i, k)*normal(j, k)
            end do
            if (i == j) normal(j, j) = sqrt(normal(j, j))
            if (i /= j) normal(i, j) = normal(i, j)/normal(j, j)
         end do
      end do
   end subroutine factor_normal

   !> The part of a vector (n) along the motions that are left: x = T (T^T T)^-1 T^T x, T = [I; H], eq. (140). In the models linear
   !> and k_g the bending part.
   pure subroutine project_vector(reduced, fold, normal, x)
      type(reduced_type), intent(in) :: reduced
      real(wp), intent(in) :: fold(:, :), normal(:, :)
      real(wp), intent(inout) :: x(:)
      integer :: i, k, b
      b = reduced%bending
      if (.not. reduced%full) then
         x(b + 1:) = 0.0_wp
         return
      end if
      do i = 1, b
         do k = 1, size(fold, 1)
            x(i) = x(i) + fold(k, i)*x(b + k)
         end do
         do k = 1, i - 1
            x(i) = x(i) - normal(i, k)*x(k)
         end do
         x(i) = x(i)/normal(i, i)
      end do
      do i = b, 1, -1
         do k = i + 1, b
            x(i) = x(i) - normal(k, i)*x(k)
         end do
         x(i) = x(i)/normal(i, i)
      end do
      x(b + 1:) = 0.0_wp
      do i = 1, b
         do k = 1, size(fold, 1)
            x(b + k) = x(b + k) + fold(k, i)*x(i)
         end do
      end do
   end subroutine project_vector

   !> Projects the couplings of all bodies with their frames; those of the axial coordinates are kept aside.
   pure subroutine condense_couplings(system, work)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      integer :: i, j
      do i = 1, size(work%bodies)
         associate (reduced => system%model%bodies(i)%reduced, body => work%bodies(i))
            if (.not. reduced%condensed) cycle
            body%axial_coupling = body%coupling(reduced%bending + 1:, :)
            do j = 1, 3
               call project_vector(reduced, body%fold, body%normal, body%coupling(:, j))
            end do
         end associate
      end do
   end subroutine condense_couplings

   !> Makes the forces of all bodies, and the right-hand sides of the constraints, those of the motions that are left: less what
   !> the velocities alone contribute, eta_a'' = H eta_b'' + 2 h(eta_b'), eq. (139).
   pure subroutine condense_forces(system, work, v)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Velocities (nq)
      real(wp), intent(in) :: v(:)
      integer :: i, j, k, b, first, row
      do i = 1, size(work%bodies)
         associate (reduced => system%model%bodies(i)%reduced, body => work%bodies(i))
            if (.not. reduced%condensed) cycle
            b = reduced%bending
            first = system%layout%q(i) + 3
            body%axial_force = body%eta_force(b + 1:)
            body%bending_force = body%eta_force(:b)
            call foreshortening(reduced, v(first + 1:first + b), body%drift)
            body%drift = 2*body%drift
            do k = 1, size(body%drift)
               do j = 1, 3
                  body%force(j) = body%force(j) - body%axial_coupling(k, j)*body%drift(k)
               end do
               body%eta_force(b + k) = body%eta_force(b + k) - body%drift(k)
            end do
            if (reduced%full) then
               call project_vector(reduced, body%fold, body%normal, body%eta_force)
            else
               call set_bending_force(body, b)
            end if
         end associate
      end do
      do i = 1, size(system%constraints)
         do j = 1, 2
            if (system%constraints(i)%item%bodies(j) == ground) cycle
            associate (body => work%bodies(system%constraints(i)%item%bodies(j)), eta => work%jacobians(j, i)%eta, &
                  & first => system%constraints(i)%item%first - 1)
               if (.not. allocated(body%drift)) cycle
               b = size(eta, 2) - size(body%drift)
               do k = 1, size(body%drift)
                  do row = 1, size(eta, 1)
                     work%gamma(first + row) = work%gamma(first + row) - eta(row, b + k)*body%drift(k)
                  end do
               end do
            end associate
         end do
      end do
   end subroutine condense_forces

   !> Forces on the bending coordinates, that of the axial loads among them; none on the axial ones.
   pure subroutine set_bending_force(body, bending)
      type(body_workspace_type), intent(inout) :: body
      integer, intent(in) :: bending
      integer :: j, k
      do j = 1, bending
         body%eta_force(j) = body%bending_force(j)
         do k = 1, size(body%load)
            body%eta_force(j) = body%eta_force(j) + body%fold(k, j)*body%load(k)
         end do
      end do
      body%eta_force(bending + 1:) = 0.0_wp
   end subroutine set_bending_force

   !> Loads on the axial coordinates after a solution: what their own rows of the equations of motion leave, eq. (142), and in a
   !> the accelerations of the foreshortening by velocities alone.
   pure subroutine gather_loads(system, work, a)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Accelerations of the solution (nq)
      real(wp), intent(inout) :: a(:)
      integer :: i, j, k, at
      do i = 1, size(work%bodies)
         associate (body => work%bodies(i), b => system%model%bodies(i)%reduced%bending)
            if (.not. system%model%bodies(i)%reduced%condensed) cycle
            at = system%layout%q(i) + 3 + b
            do k = 1, size(body%load)
               a(at + k) = a(at + k) + body%drift(k)
               body%new_load(k) = body%axial_force(k) - a(at + k)
               do j = 1, 3
                  body%new_load(k) = body%new_load(k) - body%axial_coupling(k, j)*body%acceleration(j)
               end do
               do j = 1, size(body%rows)
                  associate (from => body%sources(:, j))
                     body%new_load(k) = body%new_load(k) - work%jacobians(from(2), from(1))%eta(from(3), b + k) &
                        & *work%solution(body%rows(j))
                  end associate
               end do
            end do
         end associate
      end do
   end subroutine gather_loads

   !> Takes over the new loads. In the model k_g they push the bending coordinates, whose accelerations change them: then the next
   !> guess is made of this one and the last (Anderson), and the solution has to be repeated until they agree.
   pure subroutine push_bending(system, work, round, settled)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Number of solutions so far
      integer, intent(in) :: round
      !> Whether loads and solution agree
      logical, intent(out) :: settled
      real(wp), parameter :: agreed = 1.0e-13_wp
      real(wp) :: change, whole, mix, product, square
      integer :: i
      change = 0.0_wp
      whole = 0.0_wp
      product = 0.0_wp
      square = 0.0_wp
      do i = 1, size(work%bodies)
         if (system%model%bodies(i)%reduced%condensed) call measure_gap(system%model%bodies(i)%reduced, work%bodies(i), change, &
            & whole, product, square)
      end do
      settled = change <= agreed*whole
      mix = 0.0_wp
      if (square > 0.0_wp .and. .not. settled .and. round > 1) mix = product/square
      do i = 1, size(work%bodies)
         associate (reduced => system%model%bodies(i)%reduced, body => work%bodies(i))
            if (.not. reduced%condensed) cycle
            body%last_gap = body%new_load - body%load
            body%load = body%new_load - mix*(body%new_load - body%last_load)
            body%last_load = body%new_load
            if (reduced%geometric .and. .not. reduced%full .and. .not. settled) call set_bending_force(body, reduced%bending)
         end associate
      end do
   end subroutine push_bending

   !> By how much loads and solution of a body of the model k_g disagree: as forces on the bending, and what the mixture needs.
   pure subroutine measure_gap(reduced, body, change, whole, product, square)
      type(reduced_type), intent(in) :: reduced
      type(body_workspace_type), intent(in) :: body
      !> Largest change of a force on the bending, and largest such force
      real(wp), intent(inout) :: change, whole
      !> Of the gap with its change since the last solution, and of that change with itself
      real(wp), intent(inout) :: product, square
      real(wp) :: gap, push, pushed
      integer :: j, k
      if (reduced%full .or. .not. reduced%geometric) return
      do k = 1, size(body%load)
         gap = body%new_load(k) - body%load(k)
         product = product + gap*(gap - body%last_gap(k))/reduced%omega2(reduced%bending + k)
         square = square + (gap - body%last_gap(k))**2/reduced%omega2(reduced%bending + k)
      end do
      do j = 1, reduced%bending
         push = 0.0_wp
         pushed = 0.0_wp
         do k = 1, size(body%load)
            push = push + body%fold(k, j)*(body%new_load(k) - body%load(k))
            pushed = pushed + body%fold(k, j)*body%new_load(k)
         end do
         change = max(change, abs(push))
         whole = max(whole, abs(body%bending_force(j)), abs(pushed))
      end do
   end subroutine measure_gap

   !> Puts the axial coordinates where they belong, eq. (137), and their rates, eq. (138).
   pure subroutine place_axial(system, work, q)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Coordinates (nq)
      real(wp), intent(inout) :: q(:)
      integer :: i, b, first
      do i = 1, size(work%bodies)
         associate (reduced => system%model%bodies(i)%reduced, body => work%bodies(i))
            if (.not. reduced%condensed) cycle
            b = reduced%bending
            first = system%layout%q(i) + 3
            call foreshortening(reduced, q(first + 1:first + b), body%drift)
            q(first + b + 1:first + reduced%n) = body%drift + body%stretch
         end associate
      end do
   end subroutine place_axial

   !> The rates of the axial coordinates with the H of the last `update_folds`.
   pure subroutine place_axial_rates(system, work, v)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      !> Velocities (nq)
      real(wp), intent(inout) :: v(:)
      integer :: i, j, b, first
      do i = 1, size(work%bodies)
         associate (reduced => system%model%bodies(i)%reduced, body => work%bodies(i))
            if (.not. reduced%condensed) cycle
            b = reduced%bending
            first = system%layout%q(i) + 3
            v(first + b + 1:first + reduced%n) = 0.0_wp
            if (.not. reduced%full) cycle
            do j = 1, b
               v(first + b + 1:first + reduced%n) = v(first + b + 1:first + reduced%n) + body%fold(:, j)*v(first + j)
            end do
         end associate
      end do
   end subroutine place_axial_rates

   !> Lets the loads of the last accelerations stretch the bodies, eq. (143): until `release_axial` the axial coordinates are placed
   !> with that stretch.
   pure subroutine stretch_axial(system, work)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      integer :: i
      do i = 1, size(work%bodies)
         associate (reduced => system%model%bodies(i)%reduced, body => work%bodies(i))
            if (reduced%condensed) body%stretch = body%load/reduced%omega2(reduced%bending + 1:)
         end associate
      end do
   end subroutine stretch_axial

   !> Takes the stretch back.
   pure subroutine release_axial(work)
      type(workspace_type), intent(inout) :: work
      integer :: i
      do i = 1, size(work%bodies)
         if (allocated(work%bodies(i)%stretch)) work%bodies(i)%stretch = 0.0_wp
      end do
   end subroutine release_axial

   !> Coordinates of a body whose axial loads stretch it: what its tension follows from, in the model k_g (n).
   pure subroutine axial_posture(reduced, load, eta, posture)
      type(reduced_type), intent(in) :: reduced
      !> Loads on the axial coordinates, coordinates (n)
      real(wp), intent(in) :: load(:), eta(:)
      real(wp), intent(inout) :: posture(:)
      posture = eta
      posture(reduced%bending + 1:) = eta(reduced%bending + 1:) + load/reduced%omega2(reduced%bending + 1:)
   end subroutine axial_posture

end module limber_system_condensation
