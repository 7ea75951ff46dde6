!> A place of an exact beam at any state, without a centreline. Floor: system. Source: doc/theory, eq. (X7).
module limber_system_exact_place
   use limber_base_kinds, only: wp
   use limber_flex_exact, only: exact_type
   use limber_system_algebra, only: turn, along
   implicit none
   private
   public :: follow_place

contains

   !> Place with a reach, and its velocity and acceleration, in the axes of the frame, without a centreline.
   pure subroutine follow_place(exact, reach, eta, p, drift, push, rate, acceleration)
      type(exact_type), intent(in) :: exact
      !> (stations), coordinates (n)
      real(wp), intent(in) :: reach(:), eta(:)
      real(wp), intent(out) :: p(2), drift(2), push(2)
      !> Rates and second derivatives of the coordinates (n); zero if absent
      real(wp), intent(in), optional :: rate(:), acceleration(:)
      real(wp) :: axis(2), g(2), speed, swing, strain(2)
      integer :: k, a
      a = exact%angles
      p = 0.0_wp
      drift = 0.0_wp
      push = 0.0_wp
      do k = 1, exact%stations
         if (.not. abs(reach(k)) > 0.0_wp) cycle
         speed = exact%lean(k) + dot_product(exact%psi(:, k), eta(:a))
         axis = [cos(speed), sin(speed)]
         g = along([1.0_wp, 0.0_wp] + strained(k, eta), axis)
         p = p + reach(k)*g
         if (.not. present(rate)) cycle
         speed = dot_product(exact%psi(:, k), rate(:a))
         strain = along(strained(k, rate), axis)
         drift = drift + reach(k)*(speed*turn(g) + strain)
         if (.not. present(acceleration)) cycle
         swing = dot_product(exact%psi(:, k), acceleration(:a))
         push = push + reach(k)*(swing*turn(g) + 2*speed*turn(strain) - speed**2*g &
            & + along(strained(k, acceleration), axis))
      end do

   contains

      !> What coordinates make of the strain at a station (2).
      pure function strained(k, x) result(strain)
         integer, intent(in) :: k
         real(wp), intent(in) :: x(:)
         real(wp) :: strain(2)
         integer :: i
         strain = 0.0_wp
         do i = 1, exact%strains
            strain = strain + exact%chi(:, i, k)*x(a + i)
         end do
      end function strained

   end subroutine follow_place

end module limber_system_exact_place
