!> Dense output of RADAU behind a jump of loads. Stiff coordinates leave the state at a jump within a small part of the first step,
!> and a polynomial through that state and its accelerations is wrong all along the step; the one through the stages is right.
!> Floor: integrator. Source: Hairer and Wanner, Solving Ordinary Differential Equations II, section IV.8; doc/theory, section 5.3.
module limber_integrator_relaxed_output
   use limber_base_kinds, only: wp
   use limber_integrator_quintic_output, only: factors_of_rates
   use limber_integrator_radau_method, only: radau_a, radau_c
   implicit none
   private
   public :: relax_ends

contains

   !> Rates and accelerations at both ends of a first step for its dense output, with which the quintic goes through the rates of
   !> the stages and not through that at the beginning, for each coordinate that this errs less for. What the quintic errs shows
   !> itself at the stages, what the other one errs at the beginning.
   pure subroutine relax_ends(h, z, a, near, w_before, a_before, a_end)
      !> Step; increments of the rates at the stages (nw,3); accelerations of the state at the end, and how much those of the
      !> stages may differ from them (nw)
      real(wp), intent(in) :: h, z(:, :), a(:), near(:)
      !> Rates at the beginning, accelerations at the beginning and at the end (nw)
      real(wp), intent(inout) :: w_before(:), a_before(:), a_end(:)
      !> What the polynomial through the stages errs within the step, in parts of what it does at the beginning
      real(wp), parameter :: within = 0.6_wp
      real(wp) :: d(5, 2), change(3), quintic(2), first, slope, curve, ending, place
      integer :: i, k
      do i = 1, 2
         d(:, i) = factors_of_rates(radau_c(i))
      end do
      do k = 1, size(w_before)
         change = z(k, :)
         ! first + slope s + curve s^2 through the stages
         slope = (change(2) - change(1))/(radau_c(2) - radau_c(1))
         curve = ((change(3) - change(2))/(radau_c(3) - radau_c(2)) - slope)/(radau_c(3) - radau_c(1))
         slope = slope - curve*(radau_c(1) + radau_c(2))
         first = change(3) - slope - curve
         ! With the acceleration of the end: the polynomial that is zero at the stages has no integral
         ending = slope + 2*curve
         if (abs(a(k) - a_end(k)) <= near(k) .or. abs(a(k) - ending/h) <= near(k)) ending = h*a(k)
         first = first - (ending - slope - 2*curve)/3
         slope = slope + 3*(ending - slope - 2*curve)
         place = radau_a(3, 1)*change(1) + radau_a(3, 2)*change(2) + radau_a(3, 3)*change(3)
         quintic = d(1, :)*place + d(3, :)*h*a_before(k) + d(4, :)*change(3) + d(5, :)*h*a_end(k)
         if (maxval(abs(quintic - change(:2))) <= within*abs(first)) cycle
         w_before(k) = w_before(k) + first
         a_before(k) = slope/h
         a_end(k) = ending/h
      end do
   end subroutine relax_ends

end module limber_integrator_relaxed_output
