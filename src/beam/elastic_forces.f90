!> Elastic energy and forces of a reduced body in the time loop. Linear or k_g. Plain kernels of the time loop; their cost depends
!> on the number of coordinates only. Floor: beam. Source: Han and Lee 1993, eqs. (10)-(14); doc/theory, eqs. (2.8), (2.9).
module limber_beam_elastic_forces
   use limber_base_kinds, only: wp
   use limber_beam_reduced_body, only: reduced_type
   implicit none
   private
   public :: elastic_force, elastic_tangent, elastic_energy, geometric_power, find_tension, tension_power, coriolis_power

contains

   !> Adds the restoring force to f: f = f + K_E eta + geometric part.
   pure subroutine elastic_force(body, eta, f, s)
      type(reduced_type), intent(in) :: body
      !> Coordinates (n)
      real(wp), contiguous, intent(in) :: eta(:)
      !> Force on the coordinates (n), the sign of M eta'' + f = 0
      real(wp), contiguous, intent(inout) :: f(:)
      !> Scratch (pairs): tension
      real(wp), contiguous, intent(inout) :: s(:)
      integer :: i
      do i = 1, body%n
         f(i) = f(i) + body%omega2(i)*eta(i)
      end do
      if (body%strained) f = f - body%omega2*body%exact%rest
      if (.not. body%geometric) return
      call pair_tension(body, eta, s)
      call add_pair_force(body%bending, eta, s, f)
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

   !> Adds the derivative of the restoring force to k (n,n): exact, a polynomial. Not symmetric in the model k_g.
   pure subroutine elastic_tangent(body, eta, k, s)
      type(reduced_type), intent(in) :: body
      !> Coordinates (n)
      real(wp), contiguous, intent(in) :: eta(:)
      !> Rows: force, columns: coordinate
      real(wp), intent(inout) :: k(:, :)
      !> Scratch (pairs): tension
      real(wp), contiguous, intent(inout) :: s(:)
      integer :: i, j, p, column
      do i = 1, body%n
         k(i, i) = k(i, i) + body%omega2(i)
      end do
      if (.not. body%geometric) return
      call pair_tension(body, eta, s)
      p = 0
      do j = 1, body%bending
         do i = 1, j
            p = p + 1
            k(i, j) = k(i, j) + s(p)
            k(j, i) = k(j, i) + s(p)
         end do
      end do
      do column = body%offset + 1, body%n
         p = 0
         do j = 1, body%bending
            do i = 1, j
               p = p + 1
               k(i, column) = k(i, column) + body%cubic(p, column - body%offset)*eta(j)
               k(j, column) = k(j, column) + body%cubic(p, column - body%offset)*eta(i)
            end do
         end do
      end do
   end subroutine elastic_tangent

   !> z = products of the bending coordinates, s = cubic eta_a .
   pure subroutine pair_tension(body, eta, s)
      type(reduced_type), intent(in) :: body
      real(wp), contiguous, intent(in) :: eta(:)
      real(wp), contiguous, intent(inout) :: s(:)
      integer :: pairs
      pairs = size(body%cubic, 1)
      s(:pairs) = 0.0_wp
      call add_tension(pairs, size(body%cubic, 2), body%cubic, eta(body%offset + 1:), s)
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

   !> Elastic energy. In the model k_g, whose geometric force is not a gradient, that of K_E alone.
   pure subroutine elastic_energy(body, eta, energy)
      type(reduced_type), intent(in) :: body
      !> Coordinates (n)
      real(wp), contiguous, intent(in) :: eta(:)
      real(wp), intent(out) :: energy
      integer :: j
      energy = 0.0_wp
      do j = 1, body%n
         energy = energy + 0.5_wp*body%omega2(j)*eta(j)**2
      end do
      if (body%strained) energy = energy - sum(body%omega2*body%exact%rest*(eta - 0.5_wp*body%exact%rest))
   end subroutine elastic_energy

   !> Power that the geometric force of the model k_g takes out of the kinetic and K_E energy; zero in the others.
   pure subroutine geometric_power(body, eta, rate, s, power)
      type(reduced_type), intent(in) :: body
      !> Coordinates and their rates (n)
      real(wp), contiguous, intent(in) :: eta(:), rate(:)
      !> Scratch (pairs)
      real(wp), contiguous, intent(inout) :: s(:)
      real(wp), intent(out) :: power
      power = 0.0_wp
      if (.not. body%geometric) return
      call pair_tension(body, eta, s)
      power = pair_power(body%bending, eta, rate, s)
   end subroutine geometric_power

   !> Tension of the model k_g; nothing in the others.
   pure subroutine find_tension(body, eta, s)
      type(reduced_type), intent(in) :: body
      !> Coordinates (n)
      real(wp), contiguous, intent(in) :: eta(:)
      !> Tension (pairs)
      real(wp), contiguous, intent(inout) :: s(:)
      if (body%geometric) call pair_tension(body, eta, s)
   end subroutine find_tension

   !> The power with the tension that `elastic_force` or `find_tension` has found.
   pure real(wp) function tension_power(body, eta, rate, s) result(power)
      type(reduced_type), intent(in) :: body
      !> Coordinates and their rates (n), tension (pairs)
      real(wp), contiguous, intent(in) :: eta(:), rate(:), s(:)
      power = 0.0_wp
      if (.not. body%geometric) return
      power = pair_power(body%bending, eta, rate, s)
   end function tension_power

   !> Power that the tension of the Coriolis forces, as at rest, takes out of the bending in the model k_g, eq. (7.22): what would
   !> give it back, the Coriolis force of the shortening, is not in the model. Zero in the others.
   pure subroutine coriolis_power(body, omega, eta, rate, room, s, power)
      type(reduced_type), intent(in) :: body
      !> Angular velocity of the frame; coordinates, and the rates or the shape of a vibration (n)
      real(wp), intent(in) :: omega
      real(wp), contiguous, intent(in) :: eta(:), rate(:)
      !> Scratch (n), (pairs)
      real(wp), contiguous, intent(inout) :: room(:), s(:)
      real(wp), intent(out) :: power
      integer :: k
      power = 0.0_wp
      if (.not. body%geometric .or. body%is_exact) return
      do k = 1, body%n
         room(k) = -2*omega*dot_product(body%skew(:, k), rate)/body%omega2(k)
      end do
      call pair_tension(body, room, s)
      power = pair_power(body%bending, eta, rate, s)
   end subroutine coriolis_power

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

end module limber_beam_elastic_forces
