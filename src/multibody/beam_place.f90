!> Place of a point of an exact beam at a state. Floor: multibody. Source: doc/theory, eq. (2.42).
module limber_multibody_beam_place
   use limber_base_kinds, only: wp
   use limber_base_sines, only: take_sines
   use limber_beam_exact_beam, only: exact_type, panel_stations
   use limber_multibody_plane_vectors, only: turn, along, cross
   implicit none
   private
   public :: find_place, find_deflection, follow_place

contains

   !> Place with a reach, in the axes of the frame, panel by panel.
   pure subroutine find_place(exact, reach, eta, p)
      type(exact_type), intent(in) :: exact
      !> (stations), coordinates (n)
      real(wp), contiguous, intent(in) :: reach(:), eta(:)
      real(wp), intent(out) :: p(2)
      real(wp) :: g(panel_stations, 2)
      integer :: first
      p = 0.0_wp
      do first = 1, exact%stations, panel_stations
         if (.not. reaches(reach(first:))) cycle
         call place_panel(exact, first, eta, g)
         call add_panel(reach(first:), g, p)
      end do
   end subroutine find_place

   !> Distance of a place from the chord between two others, positive on its left.
   pure real(wp) function find_deflection(exact, start, end, reach, eta) result(deflection)
      type(exact_type), intent(in) :: exact
      !> Reaches of the ends of the chord and of the place (stations), coordinates (n)
      real(wp), contiguous, intent(in) :: start(:), end(:), reach(:), eta(:)
      real(wp) :: g(panel_stations, 2), p(2), origin(2), chord(2)
      integer :: first
      p = 0.0_wp
      origin = 0.0_wp
      chord = 0.0_wp
      do first = 1, exact%stations, panel_stations
         call place_panel(exact, first, eta, g)
         call add_panel(start(first:), g, origin)
         call add_panel(end(first:), g, chord)
         call add_panel(reach(first:), g, p)
      end do
      chord = chord - origin
      deflection = cross(chord, p - origin)/sqrt(chord(1)**2 + chord(2)**2)
   end function find_deflection

   !> Whether the stations of a panel give anything.
   pure logical function reaches(reach)
      real(wp), intent(in) :: reach(panel_stations)
      reaches = any(abs(reach) > 0.0_wp)
   end function reaches

   !> Derivatives x'(s) of the places at the stations of a panel.
   pure subroutine place_panel(exact, first, eta, g)
      type(exact_type), intent(in) :: exact
      !> First station
      integer, intent(in) :: first
      real(wp), contiguous, intent(in) :: eta(:)
      real(wp), intent(out) :: g(panel_stations, 2)
      real(wp) :: theta(panel_stations), c(panel_stations), s(panel_stations), sigma(panel_stations, 2)
      theta = exact%lean(first:first + panel_stations - 1)
      call add_angles(exact%angles, exact%psi(:, first:first + panel_stations - 1), eta, theta)
      call take_sines(panel_stations, theta, s, c)
      if (exact%strains == 0) then
         g(:, 1) = c
         g(:, 2) = s
         return
      end if
      call add_strains(exact%strains, exact%chi(:, :, first:first + panel_stations - 1), eta(exact%angles + 1:), sigma)
      g(:, 1) = c*sigma(:, 1) - s*sigma(:, 2)
      g(:, 2) = s*sigma(:, 1) + c*sigma(:, 2)
   end subroutine place_panel

   !> Adds to angles at the stations of a panel what the coordinates make.
   pure subroutine add_angles(n, psi, eta, theta)
      integer, intent(in) :: n
      real(wp), intent(in) :: psi(n, panel_stations), eta(n)
      real(wp), intent(inout) :: theta(panel_stations)
      integer :: i, k
      do i = 1, n
         do k = 1, panel_stations
            theta(k) = theta(k) + psi(i, k)*eta(i)
         end do
      end do
   end subroutine add_angles

   !> Stretch of the axis at the stations of a panel: that of the undeformed one, and what the coordinates make.
   pure subroutine add_strains(n, chi, eta, sigma)
      integer, intent(in) :: n
      real(wp), intent(in) :: chi(2, n, panel_stations), eta(n)
      real(wp), intent(out) :: sigma(panel_stations, 2)
      integer :: i, k
      sigma(:, 1) = 1.0_wp
      sigma(:, 2) = 0.0_wp
      do i = 1, n
         do k = 1, panel_stations
            sigma(k, 1) = sigma(k, 1) + chi(1, i, k)*eta(i)
            sigma(k, 2) = sigma(k, 2) + chi(2, i, k)*eta(i)
         end do
      end do
   end subroutine add_strains

   !> Adds what the stations of a panel give to a place.
   pure subroutine add_panel(reach, g, p)
      real(wp), intent(in) :: reach(panel_stations), g(panel_stations, 2)
      real(wp), intent(inout) :: p(2)
      !> In four parts that are independent of one another
      real(wp) :: part(4)
      integer :: i
      do i = 1, 2
         part = reach(1:4)*g(1:4, i) + reach(5:8)*g(5:8, i)
         p(i) = p(i) + ((part(1) + part(2)) + (part(3) + part(4)))
      end do
   end subroutine add_panel

   !> Place with a reach, and its velocity and acceleration, in the axes of the frame, without a centreline.
   pure subroutine follow_place(exact, reach, eta, p, drift, push, rate, acceleration)
      type(exact_type), intent(in) :: exact
      !> (stations), coordinates (n)
      real(wp), intent(in) :: reach(:), eta(:)
      real(wp), intent(out) :: p(2), drift(2), push(2)
      !> Rates of the coordinates (n), and second derivatives, zero if absent
      real(wp), intent(in) :: rate(:)
      real(wp), intent(in), optional :: acceleration(:)
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

end module limber_multibody_beam_place
