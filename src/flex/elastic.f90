!> Elastic energy and force of a reduced body: linear, k_g or full. Plain kernels of the time loop; their cost
!> depends on the number of coordinates only. Floor: flex. Source: Han and Lee 1993, eqs. (10)-(14); doc/theory, eqs. (22)-(24).
module limber_flex_elastic
   use limber_base_kinds, only: wp
   use limber_flex_reduced, only: reduced_type
   implicit none
   private
   public :: elastic_force, elastic_tangent, elastic_energy, geometric_power, find_tension, tension_power

contains

   !> Adds the restoring force to f: f = f + K_E eta + geometric part.
   pure subroutine elastic_force(body, eta, f, z, s)
      type(reduced_type), intent(in) :: body
      !> Coordinates (n)
      real(wp), contiguous, intent(in) :: eta(:)
      !> Force on the coordinates (n), the sign of M eta'' + f = 0
      real(wp), contiguous, intent(inout) :: f(:)
      !> Scratch (pairs): products of the bending coordinates, and their conjugate tension
      real(wp), contiguous, intent(inout) :: z(:), s(:)
      integer :: i
      do i = 1, body%n
         f(i) = f(i) + body%omega2(i)*eta(i)
      end do
      if (body%strained) f = f - body%omega2*body%exact%rest
      if (.not. body%geometric) return
      call pair_tension(body, eta, z, s)
      call add_pair_force(body%bending, eta, s, f)
      if (body%full) call add_axial_force(size(body%cubic, 1), size(body%cubic, 2), body%cubic, z, f(body%offset + 1:))
   end subroutine elastic_force

   !> What the tension s does to the bending: f = f + s eta, as a symmetric matrix.
   pure subroutine add_pair_force(n, eta, s, f)
      integer, intent(in) :: n
      real(wp), intent(in) :: eta(n), s(n*(n + 1)/2)
      real(wp), intent(inout) :: f(n)
      integer :: i, j, p
      p = 0
      do j = 1, n
         do i = 1, j
            p = p + 1
            f(i) = f(i) + s(p)*eta(j)
            f(j) = f(j) + s(p)*eta(i)
         end do
      end do
   end subroutine add_pair_force

   !> What the products z pull along: f = f + cubic^T z.
   pure subroutine add_axial_force(pairs, axial, cubic, z, f)
      integer, intent(in) :: pairs, axial
      real(wp), intent(in) :: cubic(pairs, axial), z(pairs)
      !> Of the coordinates that carry tension
      real(wp), intent(inout) :: f(axial)
      real(wp) :: total
      integer :: j, p
      do j = 1, axial
         total = 0.0_wp
         do p = 1, pairs
            total = total + cubic(p, j)*z(p)
         end do
         f(j) = f(j) + total
      end do
   end subroutine add_axial_force

   !> Adds the derivative of the restoring force to k (n,n): exact, a polynomial. Not symmetric in the model k_g.
   pure subroutine elastic_tangent(body, eta, k, z, s, slope)
      type(reduced_type), intent(in) :: body
      !> Coordinates (n)
      real(wp), contiguous, intent(in) :: eta(:)
      !> Rows: force, columns: coordinate
      real(wp), intent(inout) :: k(:, :)
      !> Scratch (pairs), (pairs), and (pairs, 2): derivatives of z with respect to one coordinate, and of s
      real(wp), contiguous, intent(inout) :: z(:), s(:)
      real(wp), intent(inout) :: slope(:, :)
      integer :: i, j, p, column
      do i = 1, body%n
         k(i, i) = k(i, i) + body%omega2(i)
      end do
      if (.not. body%geometric) return
      call pair_tension(body, eta, z, s)
      p = 0
      do j = 1, body%bending
         do i = 1, j
            p = p + 1
            k(i, j) = k(i, j) + s(p)
            k(j, i) = k(j, i) + s(p)
         end do
      end do
      do column = 1, body%n
         slope(:, 2) = 0.0_wp
         if (column > body%offset) slope(:, 2) = body%cubic(:, column - body%offset)
         if (column <= body%bending .and. body%full) then
            call pair_slope(body, eta, column, slope(:, 1))
            do j = 1, size(body%quartic, 2)
               if (.not. abs(slope(j, 1)) > 0.0_wp) cycle
               do p = 1, size(body%quartic, 1)
                  slope(p, 2) = slope(p, 2) + body%quartic(p, j)*slope(j, 1)
               end do
            end do
            do j = 1, body%n - body%offset
               do p = 1, size(body%cubic, 1)
                  k(body%offset + j, column) = k(body%offset + j, column) + body%cubic(p, j)*slope(p, 1)
               end do
            end do
         else if (column <= body%offset) then
            cycle
         end if
         p = 0
         do j = 1, body%bending
            do i = 1, j
               p = p + 1
               k(i, column) = k(i, column) + slope(p, 2)*eta(j)
               k(j, column) = k(j, column) + slope(p, 2)*eta(i)
            end do
         end do
      end do
   end subroutine elastic_tangent

   !> Derivative of the products z with respect to one bending coordinate.
   pure subroutine pair_slope(body, eta, column, slope)
      type(reduced_type), intent(in) :: body
      real(wp), intent(in) :: eta(:)
      integer, intent(in) :: column
      real(wp), intent(inout) :: slope(:)
      integer :: i, j, p
      p = 0
      do j = 1, body%bending
         do i = 1, j
            p = p + 1
            slope(p) = 0.0_wp
            if (i == column) slope(p) = slope(p) + eta(j)
            if (j == column) slope(p) = slope(p) + eta(i)
         end do
      end do
   end subroutine pair_slope

   !> z = products of the bending coordinates, s = cubic eta_a (+ quartic z in the full model).
   pure subroutine pair_tension(body, eta, z, s)
      type(reduced_type), intent(in) :: body
      real(wp), contiguous, intent(in) :: eta(:)
      real(wp), contiguous, intent(inout) :: z(:), s(:)
      integer :: pairs
      pairs = size(body%cubic, 1)
      s(:pairs) = 0.0_wp
      call add_tension(pairs, size(body%cubic, 2), body%cubic, eta(body%offset + 1:), s)
      if (.not. body%full) return
      call pair_products(body%bending, eta, z)
      call add_tension(pairs, pairs, body%quartic, z, s)
   end subroutine pair_tension

   !> s = s + factors x.
   pure subroutine add_tension(pairs, count, factors, x, s)
      integer, intent(in) :: pairs, count
      real(wp), intent(in) :: factors(pairs, count), x(count)
      real(wp), intent(inout) :: s(pairs)
      integer :: j, p
      do j = 1, count
         do p = 1, pairs
            s(p) = s(p) + factors(p, j)*x(j)
         end do
      end do
   end subroutine add_tension

   !> z = eta_i eta_j, i <= j, in the order of `pair_index`.
   pure subroutine pair_products(n, eta, z)
      integer, intent(in) :: n
      !> Bending coordinates
      real(wp), intent(in) :: eta(n)
      !> Their products (pairs)
      real(wp), intent(inout) :: z(n*(n + 1)/2)
      integer :: i, j, p
      p = 0
      do j = 1, n
         do i = 1, j
            p = p + 1
            z(p) = eta(i)*eta(j)
         end do
      end do
   end subroutine pair_products

   !> Elastic energy. In the model k_g, whose geometric force is not a gradient, that of K_E alone.
   pure subroutine elastic_energy(body, eta, z, s, energy)
      type(reduced_type), intent(in) :: body
      !> Coordinates (n)
      real(wp), contiguous, intent(in) :: eta(:)
      !> Scratch (pairs)
      real(wp), contiguous, intent(inout) :: z(:), s(:)
      real(wp), intent(out) :: energy
      integer :: j, p
      real(wp) :: tension
      energy = 0.0_wp
      do j = 1, body%n
         energy = energy + 0.5_wp*body%omega2(j)*eta(j)**2
      end do
      if (body%strained) energy = energy - sum(body%omega2*body%exact%rest*(eta - 0.5_wp*body%exact%rest))
      if (.not. body%full) return
      call pair_tension(body, eta, z, s)
      do p = 1, size(body%cubic, 1)
         tension = 0.0_wp
         do j = 1, body%n - body%offset
            tension = tension + body%cubic(p, j)*eta(body%offset + j)
         end do
         energy = energy + 0.5_wp*z(p)*(s(p) + tension)
      end do
   end subroutine elastic_energy

   !> Power that the geometric force of the model k_g takes out of the kinetic and K_E energy; zero in the others.
   pure subroutine geometric_power(body, eta, rate, z, s, power)
      type(reduced_type), intent(in) :: body
      !> Coordinates and their rates (n)
      real(wp), contiguous, intent(in) :: eta(:), rate(:)
      !> Scratch (pairs)
      real(wp), contiguous, intent(inout) :: z(:), s(:)
      real(wp), intent(out) :: power
      power = 0.0_wp
      if (body%full .or. .not. body%geometric) return
      call pair_tension(body, eta, z, s)
      power = pair_power(body%bending, eta, rate, s)
   end subroutine geometric_power

   !> Tension of the model k_g; nothing in the others.
   pure subroutine find_tension(body, eta, z, s)
      type(reduced_type), intent(in) :: body
      !> Coordinates (n)
      real(wp), contiguous, intent(in) :: eta(:)
      !> Scratch and tension (pairs)
      real(wp), contiguous, intent(inout) :: z(:), s(:)
      if (body%geometric .and. .not. body%full) call pair_tension(body, eta, z, s)
   end subroutine find_tension

   !> The power with the tension that `elastic_force` or `find_tension` has found.
   pure real(wp) function tension_power(body, eta, rate, s) result(power)
      type(reduced_type), intent(in) :: body
      !> Coordinates and their rates (n), tension (pairs)
      real(wp), contiguous, intent(in) :: eta(:), rate(:), s(:)
      power = 0.0_wp
      if (body%full .or. .not. body%geometric) return
      power = pair_power(body%bending, eta, rate, s)
   end function tension_power

   !> Power of the tension s on the bending.
   pure real(wp) function pair_power(n, eta, rate, s) result(power)
      integer, intent(in) :: n
      real(wp), intent(in) :: eta(n), rate(n), s(n*(n + 1)/2)
      integer :: i, j, p
      power = 0.0_wp
      p = 0
      do j = 1, n
         do i = 1, j
            p = p + 1
            power = power + s(p)*(eta(i)*rate(j) + eta(j)*rate(i))
         end do
      end do
   end function pair_power

end module limber_flex_elastic
