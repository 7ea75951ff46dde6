!> Local errors of the method of Adams at several orders. Floor: integrator. Source: Shampine and Gordon, Computer Solution of
!> Ordinary Differential Equations, 1975, chapter 10, block 2; doc/theory, eq. (5.4).
module limber_integrator_adams_errors
   use limber_base_kinds, only: wp
   use limber_integrator_divided_differences, only: most
   implicit none
   private
   public :: estimate_errors, weighted, add_lost, apart

   !> Coefficients gamma* of the error estimate at constant step, orders 1 to 13
   real(wp), parameter, public :: gamma_star(13) = [0.5_wp, 0.0833_wp, 0.0417_wp, 0.0264_wp, 0.0188_wp, 0.0143_wp, 0.0114_wp, &
      & 0.00936_wp, 0.00789_wp, 0.00679_wp, 0.00592_wp, 0.00524_wp, 0.00468_wp]
   !> Relative difference of norms up to which those of several orders count as the same
   real(wp), parameter :: flat = 0.15_wp

contains

   !> Norm of the first components of a vector in units of their scales.
   pure real(wp) function weighted(n, vector, scale)
      !> Number of components
      integer, intent(in) :: n
      real(wp), intent(in) :: vector(n), scale(n)
      integer :: i
      weighted = 0.0_wp
      do i = 1, n
         weighted = weighted + (vector(i)/scale(i))**2
      end do
      weighted = sqrt(weighted)
   end function weighted

   !> Norm of a difference.
   pure real(wp) function apart(n, a, b, scale)
      !> Number of components
      integer, intent(in) :: n
      real(wp), intent(in) :: a(n), b(n), scale(n)
      integer :: i
      apart = 0.0_wp
      do i = 1, n
         apart = apart + ((a(i) - b(i))/scale(i))**2
      end do
      apart = sqrt(apart)
   end function apart

   !> Local error of a step and what it would be at orders k, k-1, k-2; the order that seems better (block 2).
   pure subroutine estimate_errors(ny, n, k, h, g, sig, scale, yp, phi, estimate, err, k_next)
      !> Length of the state, number of its first components that count, order
      integer, intent(in) :: ny, n, k
      !> Step; its coefficients
      real(wp), intent(in) :: h, g(most + 1), sig(most + 1)
      !> Scales of what counts (n); derivative at the predicted state, and predicted differences
      real(wp), intent(in) :: scale(n), yp(ny), phi(ny, most + 2)
      !> Orders k, k-1, k-2
      real(wp), intent(out) :: estimate(0:3)
      !> In units of the scales
      real(wp), intent(out) :: err
      integer, intent(out) :: k_next
      real(wp) :: norm(0:2), difference, weight
      integer :: i
      norm = 0.0_wp
      do i = 1, n
         weight = 1/scale(i)
         difference = yp(i) - phi(i, 1)
         norm(0) = norm(0) + (difference*weight)**2
         if (k > 1) norm(1) = norm(1) + ((phi(i, k) + difference)*weight)**2
         if (k > 2) norm(2) = norm(2) + ((phi(i, k - 1) + difference)*weight)**2
      end do
      norm = h*sqrt(norm)
      err = norm(0)*(g(k) - g(k + 1))
      if (k > 1) then
         if (abs(norm(1) - norm(0)) <= flat*norm(0) .and. (k == 2 .or. abs(norm(2) - norm(0)) <= flat*norm(0))) &
            & err = max(err, norm(0)*gamma_star(seen_order(ny, n, k, h, scale, yp, phi, norm(0))))
      end if
      estimate = 0.0_wp
      estimate(0) = norm(0)*sig(k + 1)*gamma_star(k)
      if (k > 1) estimate(1) = norm(1)*sig(k)*gamma_star(k - 1)
      if (k > 2) estimate(2) = norm(2)*sig(k - 1)*gamma_star(k - 2)
      k_next = k
      if (k > 2) then
         if (max(estimate(1), estimate(2)) <= estimate(0)) k_next = k - 1
      else if (k == 2) then
         if (estimate(1) <= 0.5_wp*estimate(0)) k_next = k - 1
      end if
      if (.not. err <= huge(err)) err = huge(err)
   end subroutine estimate_errors

   !> The lowest order whose difference is as large as that of the present one: a law that jumps, or nearly does, within the step
   !> adds the same to the differences of all orders, and what the higher ones promise does not hold, eq. (5.4).
   pure integer function seen_order(ny, n, k, h, scale, yp, phi, largest) result(order)
      integer, intent(in) :: ny, n, k
      real(wp), intent(in) :: h, scale(n), yp(ny), phi(ny, most + 2)
      !> Difference of the present order times the step, in units of the scales
      real(wp), intent(in) :: largest
      real(wp) :: norm
      integer :: i
      order = max(1, k - 2)
      do while (order > 1)
         norm = 0.0_wp
         do i = 1, n
            norm = norm + ((phi(i, order) + yp(i) - phi(i, 1))/scale(i))**2
         end do
         if (abs(h*sqrt(norm) - largest) > flat*largest) return
         order = order - 1
      end do
   end function seen_order

   !> Adds to coordinates what they have lost by round-off in steps that are next to nothing: one that moves less in a step than its
   !> last digit would never get to where a law changes. The mean velocity tells how far it goes.
   pure subroutine add_lost(nq, h, y, p, lost)
      !> Number of coordinates; length of the step; state before it
      integer, intent(in) :: nq
      real(wp), intent(in) :: h, y(:)
      !> State behind it; what the coordinates still lack (nq)
      real(wp), intent(inout) :: p(:), lost(:)
      real(wp) :: way
      integer :: i
      do i = 1, nq
         way = 0.5_wp*h*(y(nq + i) + p(nq + i)) + lost(i)
         if (abs(way - (p(i) - y(i))) > 4*spacing(p(i))) then
            lost(i) = 0.0_wp
         else
            p(i) = y(i) + way
            lost(i) = way - (p(i) - y(i))
         end if
      end do
   end subroutine add_lost

end module limber_integrator_adams_errors
