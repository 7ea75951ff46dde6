!> Articulated trees of rigid and flexible bodies: structure and solution. Their structure, and the solution of linear systems with
!> the sparsity of a tree by elimination from the free ends to the roots and back,
!>
!>    A_k x_k + G_k^T l_k - sum over what hangs on k of H_j^T l_j = f_k,      L_k x_k - N_k x_c = g_k
!>
!> with the block A_k of each body, the multipliers l_k of the pin that it hangs on, and the rows of that pin on the body itself
!> (G, L) and on its carrier c (H, N). All numbers stand in arrays in the order of the elimination, so that a body costs the same
!> in the longest chain. Who fills the blocks decides what is solved: `limber_multibody_articulated_factors`,
!> `limber_multibody_articulated_step`.
!> Floor: multibody. Source: doc/theory, eqs. (4.24)-(4.26).
module limber_multibody_articulated
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_beam_reduced_body, only: reduced_type
   use limber_multibody_articulated_six, only: eliminate_six => eliminate_block, hand_on_six => hand_on_block, &
      & gather_six => gather_block, &
      & spread_six => spread_block
   use limber_multibody_articulated_three, only: eliminate_three => eliminate_block, hand_on_three => hand_on_block, &
      & gather_three => gather_block, spread_three => spread_block
   use limber_model_model, only: model_type, point_type, body_rigid, body_flexible, ground
   use limber_multibody_point_joints, only: revolute_type
   use limber_multibody_system, only: system_type
   implicit none
   private
   public :: articulated_type, new_forest, hinge_points, most_order, eliminate, hand_on, forest_solve

   !> Bodies from which on a system is worth the trouble
   integer, parameter :: many = 10
   !> Pivots below this part of the first entry are none
   real(wp), parameter :: least_pivot = 1.0e-11_wp
   !> Largest block
   integer, parameter :: most_order = 40

   !> A place in the order of the elimination: a body and the pin that it hangs on
   type :: place_type
      !> The first body that has the same constants
      integer :: model = 0
      !> Place of its carrier: 0 for the ground, -1 for none
      integer :: carrier = -1
      !> First index of its coordinates, of its rates; number of deflection coordinates
      integer :: q = 0, w = 0, n = 0
      !> First equation of its pin; 0: none
      integer :: row = 0
      !> Columns of `pins` for the pin on the body and on its carrier
      integer :: own = 1, base = 1
      !> 1, or -1 if the body is the second one of its joint
      real(wp) :: sign = 1.0_wp
   end type place_type

   !> A forest; arrays are over places unless said otherwise
   type :: articulated_type
      !> True if the system is a forest
      logical :: usable = .false.
      !> True if all trees stand on the ground
      logical :: grounded = .false.
      !> Numbers of rates and of equations of all; order of the largest block
      integer :: nw = 0, nc = 0, order = 3
      type(place_type), allocatable :: places(:)
      !> Places of pins and their shapes (2, 0:n, pins)
      real(wp), allocatable :: pins(:, :, :)
      !> A, then its inverse (order, order, places)
      real(wp), allocatable :: block(:, :, :)
      !> G^T, then A^-1 G^T; and L (order, 2, places)
      real(wp), allocatable :: reaction(:, :, :), rows(:, :, :)
      !> Of the carrier: H^T; and N^T, then (S^-1 N)^T, S = L A^-1 G^T (order, 2, places)
      real(wp), allocatable :: carried(:, :, :), carrying(:, :, :)
      !> S^-1 (2, 2, places)
      real(wp), allocatable :: compliance(:, :, :)
      !> Whether the block of a body has been started
      logical, allocatable :: started(:)
      !> Derivatives of the momenta of a step by its increments, if they are wanted (order, order, places)
      real(wp), allocatable :: masses(:, :, :)
      !> Scratch of the elastic force: (pairs), (n, n)
      real(wp), allocatable :: pairs(:), tangent(:, :)
   contains
      procedure :: exchange => exchange_forest
   end type articulated_type

contains

   !> The forest of a system, if it is one: bodies with inertia, pins that close no loop, no loads but weight.
   subroutine new_forest(system, forest)
      type(system_type), intent(in) :: system
      type(articulated_type), intent(out) :: forest
      integer :: bodies, i, n, pairs
      bodies = size(system%model%bodies)
      if (bodies < many .or. .not. system%tree%articulated .or. size(system%loads) > 0 .or. system%exact) return
      if (3 + maxval(system%layout%n) > most_order .or. size(system%angles) + size(system%bends) > 0) return
      do i = 1, bodies
         if (.not. may_belong(system%model%bodies(i)%kind, system%model%bodies(i)%reduced)) return
      end do
      n = maxval(system%layout%n)
      pairs = max(1, n*(n + 1)/2)
      forest%order = 3 + n
      forest%nw = system%layout%nw
      forest%nc = system%nc
      allocate (forest%places(bodies))
      call set_places(system, n, forest)
      allocate (forest%block(3 + n, 3 + n, bodies), forest%reaction(3 + n, 2, bodies), forest%rows(3 + n, 2, bodies), &
         & forest%carried(3 + n, 2, bodies), forest%carrying(3 + n, 2, bodies), forest%compliance(2, 2, bodies))
      allocate (forest%started(bodies), forest%pairs(pairs), &
         & forest%tangent(n, n))
      forest%block = 0.0_wp
      forest%started = .false.
      forest%grounded = all(forest%places%carrier >= 0)
      forest%usable = .true.
   end subroutine new_forest

   !> Whether a body is rigid or flexible, has mass and inertia and no nodes with a rotary inertia of their own.
   pure logical function may_belong(kind, reduced)
      integer, intent(in) :: kind
      type(reduced_type), intent(in) :: reduced
      may_belong = (kind == body_rigid .or. kind == body_flexible) .and. reduced%mass > 0.0_wp .and. reduced%i0 > 0.0_wp &
         & .and. .not. reduced%spinning
      ! All mass in one point has no inertia about it
      if (may_belong .and. reduced%n == 0) may_belong = reduced%i0*reduced%mass > (1 + 1.0e-9_wp)*sum(reduced%c0**2)
   end function may_belong

   !> Numbers of all places, and the pins, each kind of them once.
   subroutine set_places(system, n, forest)
      type(system_type), intent(in) :: system
      !> Most deflection coordinates
      integer, intent(in) :: n
      type(articulated_type), intent(inout) :: forest
      real(wp), allocatable :: pins(:, :, :)
      integer :: k, i, count, points(2)
      allocate (pins(2, 0:n, 1 + 2*size(forest%places)))
      pins(:, :, 1) = 0.0_wp
      count = 1
      do k = 1, size(forest%places)
         associate (place => forest%places(k), side => system%tree%span%side(k))
            i = system%tree%span%body(k)
            place%carrier = system%tree%span%carrier(k)
            place%model = i
            if (k > 1) then
               if (same_body(system%model%bodies(forest%places(k - 1)%model)%reduced, system%model%bodies(i)%reduced)) &
                  & place%model = forest%places(k - 1)%model
            end if
            place%q = system%layout%q(i)
            place%w = system%layout%w(i)
            place%n = system%layout%n(i)
            if (side == 0) cycle
            place%row = system%constraints((side + 1)/2)%item%first
            place%sign = merge(1.0_wp, -1.0_wp, modulo(side, 2) == 1)
            points = hinge_points(system, k)
            call find_pin(system%model%points(points(1)), n, pins, count, place%own)
            call find_pin(system%model%points(points(2)), n, pins, count, place%base)
         end associate
      end do
      allocate (forest%pins(2, 0:n, count))
      forest%pins = pins(:, :, :count)
   end subroutine set_places

   !> Points of the hinge that the body of a place hangs on: its own, and that of its carrier.
   pure function hinge_points(system, k) result(points)
      type(system_type), intent(in) :: system
      integer, intent(in) :: k
      integer :: points(2), side
      side = system%tree%span%side(k)
      points = 0
      select type (item => system%constraints((side + 1)/2)%item)
      type is (revolute_type)
         points = system%marker_points(item%markers([1, 2]))
         if (modulo(side, 2) == 0) points = points([2, 1])
      end select
   end function hinge_points

   !> Column of a point among the pins; it is appended unless it is one of the last.
   subroutine find_pin(point, n, pins, count, column)
      type(point_type), intent(in) :: point
      integer, intent(in) :: n
      real(wp), intent(inout) :: pins(2, 0:n, *)
      integer, intent(inout) :: count
      integer, intent(out) :: column
      integer, parameter :: last = 8
      real(wp) :: pin(2, 0:n)
      pin = 0.0_wp
      pin(:, 0) = point%p0
      if (point%body /= ground) pin(:, 1:size(point%phi, 2)) = point%phi
      do column = count, max(1, count - last), -1
         if (all(abs(pins(:, :, column) - pin) <= 0.0_wp)) return
      end do
      count = count + 1
      column = count
      pins(:, :, column) = pin
   end subroutine find_pin

   !> Whether two bodies have the same constants.
   pure logical function same_body(a, b) result(same)
      type(reduced_type), intent(in) :: a, b
      same = a%n == b%n .and. a%bending == b%bending .and. a%offset == b%offset .and. (a%geometric .eqv. b%geometric) &
         & .and. (a%damped .eqv. b%damped)
      if (.not. same) return
      same = abs(a%mass - b%mass) + sum(abs(a%c0 - b%c0)) + abs(a%i0 - b%i0) <= 0.0_wp
      if (.not. same .or. a%n == 0) return
      same = all(abs(a%c - b%c) <= 0.0_wp) .and. all(abs(a%d - b%d) <= 0.0_wp) .and. all(abs(a%e - b%e) <= 0.0_wp) &
         & .and. all(abs(a%skew - b%skew) <= 0.0_wp) .and. all(abs(a%omega2 - b%omega2) <= 0.0_wp)
      if (same .and. a%damped) same = all(abs(a%damping - b%damping) <= 0.0_wp)
      if (.not. same .or. .not. a%geometric) return
      same = all(abs(a%cubic - b%cubic) <= 0.0_wp)
   end function same_body

   !> Inverse of the block of a place, and what its pin yields to its carrier; blocks of all that hangs on it are there:
   !> eqs. (4.24), (4.25).
   pure subroutine eliminate(forest, k, singular)
      type(articulated_type), intent(inout) :: forest
      integer, intent(in) :: k
      !> True if a pivot vanishes
      logical, intent(out) :: singular
      associate (m => 3 + forest%places(k)%n, pinned => forest%places(k)%carrier >= 0)
         select case (merge(m, 0, m == forest%order))
         case (3)
            call eliminate_three(pinned, forest%block(:, :, k), forest%reaction(:, :, k), forest%rows(:, :, k), &
               & forest%compliance(:, :, k), singular)
         case (6)
            call eliminate_six(pinned, forest%block(:, :, k), forest%reaction(:, :, k), forest%rows(:, :, k), &
               & forest%compliance(:, :, k), singular)
         case default
            call eliminate_order(forest%order, m, pinned, forest%block(:, :, k), forest%reaction(:, :, k), forest%rows(:, :, k), &
               & forest%compliance(:, :, k), singular)
         end select
      end associate
   end subroutine eliminate

   !> The same for any order.
   pure subroutine eliminate_order(order, m, pinned, block, reaction, rows, compliance, singular)
      !> Leading dimension; number of the body's rates
      integer, intent(in) :: order, m
      !> Whether it has a pin
      logical, intent(in) :: pinned
      !> A, then its inverse; G^T, then A^-1 G^T; L^T; S^-1
      real(wp), intent(inout) :: block(order, order), reaction(order, 2)
      real(wp), intent(in) :: rows(order, 2)
      real(wp), intent(inout) :: compliance(2, 2)
      logical, intent(out) :: singular
      real(wp) :: s(2, 2), g(most_order, 2), determinant
      integer :: i, j
      call invert(order, m, block, singular)
      if (singular .or. .not. pinned) return
      g(:m, 1) = reaction(:m, 1)
      g(:m, 2) = reaction(:m, 2)
      reaction(:m, 1) = 0.0_wp
      reaction(:m, 2) = 0.0_wp
      do j = 1, m
         do i = 1, m
            reaction(i, 1) = reaction(i, 1) + block(i, j)*g(j, 1)
            reaction(i, 2) = reaction(i, 2) + block(i, j)*g(j, 2)
         end do
      end do
      s = 0.0_wp
      do i = 1, m
         s(1, 1) = s(1, 1) + rows(i, 1)*reaction(i, 1)
         s(2, 1) = s(2, 1) + rows(i, 2)*reaction(i, 1)
         s(1, 2) = s(1, 2) + rows(i, 1)*reaction(i, 2)
         s(2, 2) = s(2, 2) + rows(i, 2)*reaction(i, 2)
      end do
      determinant = s(1, 1)*s(2, 2) - s(1, 2)*s(2, 1)
      singular = .not. abs(determinant) > least_pivot*(abs(s(1, 1)*s(2, 2)) + abs(s(1, 2)*s(2, 1)))
      if (singular) return
      determinant = 1/determinant
      compliance(1, 1) = s(2, 2)*determinant
      compliance(2, 2) = s(1, 1)*determinant
      compliance(1, 2) = -s(1, 2)*determinant
      compliance(2, 1) = -s(2, 1)*determinant
   end subroutine eliminate_order

   !> Inverse in place, without a search for pivots. An inverse takes fewer and quicker operations to multiply with than factors to
   !> solve with, in blocks so small.
   pure subroutine invert(order, m, a, singular)
      integer, intent(in) :: order, m
      real(wp), intent(inout) :: a(order, m)
      logical, intent(out) :: singular
      real(wp) :: first(most_order), column(most_order), pivot, part
      integer :: i, j, k
      singular = .false.
      do k = 1, m
         first(k) = least_pivot*abs(a(k, k))
      end do
      do k = 1, m
         if (.not. abs(a(k, k)) > first(k)) singular = .true.
         pivot = 1/a(k, k)
         do i = 1, m
            column(i) = a(i, k)
            a(i, k) = 0.0_wp
         end do
         a(k, k) = 1.0_wp
         do j = 1, m
            part = a(k, j)*pivot
            do i = 1, m
               a(i, j) = a(i, j) - column(i)*part
            end do
            a(k, j) = part
         end do
      end do
   end subroutine invert

   !> Adds to the block of the carrier of a place what hangs on its pin: eq. (4.25).
   pure subroutine hand_on(forest, k)
      type(articulated_type), intent(inout) :: forest
      integer, intent(in) :: k
      associate (c => forest%places(k)%carrier, m => 3 + forest%places(forest%places(k)%carrier)%n)
         select case (merge(m, 0, m == forest%order))
         case (3)
            call hand_on_three(forest%compliance(:, :, k), forest%carried(:, :, k), forest%carrying(:, :, k), forest%block(:, :, c))
         case (6)
            call hand_on_six(forest%compliance(:, :, k), forest%carried(:, :, k), forest%carrying(:, :, k), forest%block(:, :, c))
         case default
            call hand_on_order(forest%order, m, forest%compliance(:, :, k), forest%carried(:, :, k), forest%carrying(:, :, k), &
               & forest%block(:, :, c))
         end select
      end associate
   end subroutine hand_on

   !> The same for any order.
   pure subroutine hand_on_order(order, m, compliance, carried, carrying, block)
      !> Leading dimension; number of the carrier's rates
      integer, intent(in) :: order, m
      real(wp), intent(in) :: compliance(2, 2), carried(order, 2)
      !> N^T, then (S^-1 N)^T; block of the carrier
      real(wp), intent(inout) :: carrying(order, 2), block(order, order)
      real(wp) :: first, second
      integer :: i, j
      do j = 1, m
         first = compliance(1, 1)*carrying(j, 1) + compliance(1, 2)*carrying(j, 2)
         second = compliance(2, 1)*carrying(j, 1) + compliance(2, 2)*carrying(j, 2)
         carrying(j, 1) = first
         carrying(j, 2) = second
         do i = 1, m
            block(i, j) = block(i, j) + carried(i, 1)*first + carried(i, 2)*second
         end do
      end do
   end subroutine hand_on_order

   !> Solves in place with the inverses at hand: eq. (4.26).
   pure subroutine forest_solve(forest, x)
      type(articulated_type), intent(in) :: forest
      !> Right-hand sides of the bodies in the layout of the rates, and of the constraints; then the unknowns (nw + nc)
      real(wp), intent(inout) :: x(*)
      integer :: k
      do k = size(forest%places), 1, -1
         call gather(forest, k, x)
      end do
      do k = 1, size(forest%places)
         if (forest%places(k)%carrier >= 0) call spread_out(forest, k, x)
      end do
   end subroutine forest_solve

   !> On the way to the roots: y = A^-1 f, z = S^-1 (L y - g), and H^T z for the carrier.
   pure subroutine gather(forest, k, x)
      type(articulated_type), intent(in) :: forest
      integer, intent(in) :: k
      real(wp), intent(inout) :: x(*)
      real(wp) :: none(1)
      associate (place => forest%places(k), c => forest%places(k)%carrier, m => 3 + forest%places(k)%n, &
         & z => forest%nw + forest%places(k)%row, order => forest%order)
         none = 0.0_wp
         if (c < 0) then
            call multiply(order, m, forest%block(:, :, k), x(place%w))
         else if (c == 0) then
            call gather_order(order, m, 0, place%sign, forest%block(:, :, k), forest%rows(:, :, k), forest%compliance(:, :, k), &
               & forest%carried(:, :, k), x(place%w), x(z), none)
         else
            associate (carriers => 3 + forest%places(c)%n, f => forest%places(c)%w)
               select case (merge(order, 0, m == order .and. carriers == order))
               case (3)
                  call gather_three(place%sign, forest%block(:, :, k), forest%rows(:, :, k), forest%compliance(:, :, k), &
                     & forest%carried(:, :, k), x(place%w), x(z), x(f))
               case (6)
                  call gather_six(place%sign, forest%block(:, :, k), forest%rows(:, :, k), forest%compliance(:, :, k), &
                     & forest%carried(:, :, k), x(place%w), x(z), x(f))
               case default
                  call gather_order(order, m, carriers, place%sign, forest%block(:, :, k), forest%rows(:, :, k), &
                     & forest%compliance(:, :, k), forest%carried(:, :, k), x(place%w), x(z), x(f))
               end select
            end associate
         end if
      end associate
   end subroutine gather

   !> The same for any order.
   pure subroutine gather_order(order, m, carriers, sign, block, rows, compliance, carried, y, z, f)
      !> Leading dimension; numbers of the rates of the body and of its carrier
      integer, intent(in) :: order, m, carriers
      real(wp), intent(in) :: sign, block(order, order), rows(order, 2), compliance(2, 2), carried(order, 2)
      !> f, then y; g, then z; right-hand side of the carrier
      real(wp), intent(inout) :: y(m), z(2), f(*)
      real(wp) :: a, b, first, second
      integer :: i
      call multiply(order, m, block, y)
      a = -sign*z(1)
      b = -sign*z(2)
      do i = 1, m
         a = a + rows(i, 1)*y(i)
         b = b + rows(i, 2)*y(i)
      end do
      first = compliance(1, 1)*a + compliance(1, 2)*b
      second = compliance(2, 1)*a + compliance(2, 2)*b
      z(1) = first
      z(2) = second
      do i = 1, carriers
         f(i) = f(i) + carried(i, 1)*first + carried(i, 2)*second
      end do
   end subroutine gather_order

   !> y = A y.
   pure subroutine multiply(order, m, a, y)
      integer, intent(in) :: order, m
      real(wp), intent(in) :: a(order, m)
      real(wp), intent(inout) :: y(m)
      real(wp) :: x(most_order)
      integer :: i, j
      do i = 1, m
         x(i) = a(i, 1)*y(1)
      end do
      do j = 2, m
         do i = 1, m
            x(i) = x(i) + a(i, j)*y(j)
         end do
      end do
      do i = 1, m
         y(i) = x(i)
      end do
   end subroutine multiply

   !> On the way back: l = z - S^-1 N x of the carrier, x = y - A^-1 G^T l.
   pure subroutine spread_out(forest, k, x)
      type(articulated_type), intent(in) :: forest
      integer, intent(in) :: k
      real(wp), intent(inout) :: x(*)
      real(wp) :: none(1)
      associate (place => forest%places(k), c => forest%places(k)%carrier, m => 3 + forest%places(k)%n, &
         & z => forest%nw + forest%places(k)%row, order => forest%order)
         none = 0.0_wp
         if (c == 0) then
            call spread_order(order, m, 0, place%sign, forest%reaction(:, :, k), forest%carrying(:, :, k), none, x(z), x(place%w))
         else
            associate (carriers => 3 + forest%places(c)%n, above => forest%places(c)%w)
               select case (merge(order, 0, m == order .and. carriers == order))
               case (3)
                  call spread_three(place%sign, forest%reaction(:, :, k), forest%carrying(:, :, k), x(above), x(z), x(place%w))
               case (6)
                  call spread_six(place%sign, forest%reaction(:, :, k), forest%carrying(:, :, k), x(above), x(z), x(place%w))
               case default
                  call spread_order(order, m, carriers, place%sign, forest%reaction(:, :, k), forest%carrying(:, :, k), x(above), &
                     & x(z), x(place%w))
               end select
            end associate
         end if
      end associate
   end subroutine spread_out

   !> The same for any order.
   pure subroutine spread_order(order, m, carriers, sign, reaction, carrying, above, z, y)
      integer, intent(in) :: order, m, carriers
      !> x of the carrier
      real(wp), intent(in) :: sign, reaction(order, 2), carrying(order, 2), above(*)
      !> z, then the multipliers in their own sign; y, then x
      real(wp), intent(inout) :: z(2), y(m)
      real(wp) :: first, second
      integer :: i
      first = z(1)
      second = z(2)
      do i = 1, carriers
         first = first - carrying(i, 1)*above(i)
         second = second - carrying(i, 2)*above(i)
      end do
      do i = 1, m
         y(i) = y(i) - (reaction(i, 1)*first + reaction(i, 2)*second)
      end do
      z(1) = sign*first
      z(2) = sign*second
   end subroutine spread_order

   !> Saves or restores its memory.
   subroutine exchange_forest(self, snapshot)
      class(articulated_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      if (.not. self%usable) return
      call snapshot%keep('block', self%block)
      call snapshot%keep('reaction', self%reaction)
      call snapshot%keep('rows', self%rows)
      call snapshot%keep('carried', self%carried)
      call snapshot%keep('carrying', self%carrying)
      call snapshot%keep('compliance', self%compliance)
      call snapshot%keep('started', self%started)
      call snapshot%keep('masses', self%masses)
      ! Not saved: grounded, nw, nc, order, places, pins, pairs, tangent
   end subroutine exchange_forest

end module limber_multibody_articulated
