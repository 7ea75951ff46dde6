!> Modified divided differences of the method of Adams. Coefficients for steps of any length, prediction, what a correction changes,
!> and what lies between two states. Plain kernels on arrays. Floor: integrator. Source: Shampine and Gordon, Computer Solution of
!> Ordinary Differential Equations, 1975, chapters 5 and 10, in their names.
module limber_integrator_divided_differences
   use limber_base_kinds, only: wp
   implicit none
   private
   public :: step_coefficients, interpolation_coefficients, interpolate, predict, finish_differences, &
      & restore_differences

   !> Highest order
   integer, parameter, public :: most = 12
   !> Components that are updated together, so that all their differences stay at hand
   integer, parameter :: block = 128
   integer :: place
   !> Integrals of 1, s, s**2, ... from 0 to 1
   real(wp), parameter :: first_weight(most + 1) = [(1.0_wp/place, place=1, most + 1)]

contains

   !> Coefficients for a step (block 1).
   pure subroutine step_coefficients(k, ns, h, psi, alpha, beta, sig, g)
      !> Order; steps taken with the same length, this one among them
      integer, intent(in) :: k, ns
      !> Length of the step [time]
      real(wp), intent(in) :: h
      !> Sums of the lengths behind [time], and what follows from them; g are those of the prediction
      real(wp), intent(inout) :: psi(most), alpha(most), beta(most), sig(most + 1), g(most + 1)
      integer :: i, iq
      real(wp) :: sum_of_steps, old, w(most)
      if (k < ns) return
      beta(ns) = 1.0_wp
      alpha(ns) = 1.0_wp/ns
      sum_of_steps = h*ns
      sig(ns + 1) = 1.0_wp
      do i = ns + 1, k
         old = psi(i - 1)
         psi(i - 1) = sum_of_steps
         beta(i) = beta(i - 1)*psi(i - 1)/old
         sum_of_steps = old + h
         alpha(i) = h/sum_of_steps
         sig(i + 1) = i*alpha(i)*sig(i)
      end do
      psi(k) = sum_of_steps
      ! All of g anew from the triangle of its integrals: updating it in place, as the classical code does, goes wrong when the
      ! order is lowered and raised again
      do iq = 1, k
         w(iq) = 1.0_wp/(iq*(iq + 1))
      end do
      do i = 3, k + 1
         do iq = 1, k + 2 - i
            w(iq) = w(iq) - alpha(i - 1)*w(iq + 1)
         end do
         g(i) = w(1)
      end do
   end subroutine step_coefficients

   !> Factors of the differences for the state a time before the last one.
   pure subroutine interpolation_coefficients(order, back, psi, g)
      integer, intent(in) :: order
      !> From the last state, not positive; sums of the lengths behind [time]
      real(wp), intent(in) :: back, psi(most)
      !> The first `order` are set; to be multiplied by `back`
      real(wp), intent(out) :: g(most + 1)
      real(wp) :: weight(most + 1), term, ratio, part, inverse
      integer :: i, j
      weight(:order) = first_weight(:order)
      g(1) = 1.0_wp
      term = 0.0_wp
      do j = 2, order
         inverse = 1.0_wp/psi(j - 1)
         ratio = (back + term)*inverse
         part = back*inverse
         do i = 1, order + 1 - j
            weight(i) = ratio*weight(i) - part*weight(i + 1)
         end do
         g(j) = weight(1)
         term = psi(j - 1)
      end do
   end subroutine interpolation_coefficients

   !> State between two steps, three differences at a time.
   pure subroutine interpolate(ny, wanted, order, back, g, y, phi, p)
      !> Number of components, and of those at their front that are wanted; differences that count
      integer, intent(in) :: ny, wanted, order
      !> As in `interpolation_coefficients`; last state, differences
      real(wp), intent(in) :: back, g(most + 1), y(ny), phi(ny, most + 2)
      !> State there
      real(wp), intent(inout) :: p(ny)
      real(wp) :: factor(3)
      integer :: i, j
      p(:wanted) = y(:wanted)
      do j = order, 3, -3
         factor = back*g(j - 2:j)
         do i = 1, wanted
            p(i) = p(i) + factor(3)*phi(i, j) + factor(2)*phi(i, j - 1) + factor(1)*phi(i, j - 2)
         end do
      end do
      do j = modulo(order, 3), 1, -1
         p(:wanted) = p(:wanted) + (back*g(j))*phi(:wanted, j)
      end do
   end subroutine interpolate

   !> Predicted state p; the differences become those at the new point (block 2).
   pure subroutine predict(ny, k, ns, h, beta, g, y, phi, p)
      !> Number of components; order; steps of the same length
      integer, intent(in) :: ny, k, ns
      !> Length of the step [time], coefficients, state
      real(wp), intent(in) :: h, beta(most), g(most + 1), y(ny)
      !> Differences; predicted state
      real(wp), intent(inout) :: phi(ny, most + 2), p(ny)
      integer :: i, a, b
      do a = 1, ny, block
         b = min(ny, a + block - 1)
         do i = ns + 1, k
            phi(a:b, i) = beta(i)*phi(a:b, i)
         end do
         phi(a:b, k + 2) = phi(a:b, k + 1)
         phi(a:b, k + 1) = 0.0_wp
         p(a:b) = 0.0_wp
         do i = k, 2, -2
            call extrapolate(b - a + 1, g(i - 1:i), phi(a:b, i + 1), phi(a:b, i), phi(a:b, i - 1), p(a:b))
         end do
         if (modulo(k, 2) == 1) call add_lowest(b - a + 1, g(1), phi(a:b, 2), phi(a:b, 1), p(a:b))
         p(a:b) = y(a:b) + h*p(a:b)
      end do
   end subroutine predict

   !> Adds two differences to the prediction, and to each the one behind it.
   pure subroutine extrapolate(n, factor, behind, upper, lower, p)
      integer, intent(in) :: n
      !> Of the lower, of the upper
      real(wp), intent(in) :: factor(2), behind(n)
      real(wp), intent(inout) :: upper(n), lower(n), p(n)
      integer :: c
      do c = 1, n
         p(c) = (p(c) + factor(2)*upper(c)) + factor(1)*lower(c)
         upper(c) = upper(c) + behind(c)
         lower(c) = lower(c) + upper(c)
      end do
   end subroutine extrapolate

   !> The same with the lowest alone, where their number is odd.
   pure subroutine add_lowest(n, factor, behind, lowest, p)
      integer, intent(in) :: n
      real(wp), intent(in) :: factor, behind(n)
      real(wp), intent(inout) :: lowest(n), p(n)
      p = p + factor*lowest
      lowest = lowest + behind
   end subroutine add_lowest

   !> Takes a prediction back (block 3).
   pure subroutine restore_differences(k, h, beta, psi, phi)
      !> Order
      integer, intent(in) :: k
      !> Length of the step [time], coefficients
      real(wp), intent(in) :: h, beta(most)
      !> Sums of the lengths behind [time]; differences (components, most + 2)
      real(wp), intent(inout) :: psi(most), phi(:, :)
      integer :: i
      do i = 1, k
         phi(:, i) = (phi(:, i) - phi(:, i + 1))/beta(i)
      end do
      do i = 2, k
         psi(i - 1) = psi(i) - h
      end do
   end subroutine restore_differences

   !> Differences of all orders at the new point (block 4).
   pure subroutine finish_differences(ny, k, yp, phi)
      !> Number of components; order
      integer, intent(in) :: ny, k
      !> Derivative of the corrected state
      real(wp), intent(in) :: yp(ny)
      real(wp), intent(inout) :: phi(ny, most + 2)
      integer :: i, a, b
      do a = 1, ny, block
         b = min(ny, a + block - 1)
         phi(a:b, k + 1) = yp(a:b) - phi(a:b, 1)
         phi(a:b, k + 2) = phi(a:b, k + 1) - phi(a:b, k + 2)
         do i = 1, k - 1, 2
            call add_change(b - a + 1, phi(a:b, k + 1), phi(a:b, i), phi(a:b, i + 1))
         end do
         if (modulo(k, 2) == 1) phi(a:b, k) = phi(a:b, k) + phi(a:b, k + 1)
      end do
   end subroutine finish_differences

   !> Adds the change of the derivative to two differences.
   pure subroutine add_change(n, change, lower, upper)
      integer, intent(in) :: n
      real(wp), intent(in) :: change(n)
      real(wp), intent(inout) :: lower(n), upper(n)
      integer :: c
      do c = 1, n
         lower(c) = lower(c) + change(c)
         upper(c) = upper(c) + change(c)
      end do
   end subroutine add_change

end module limber_integrator_divided_differences
