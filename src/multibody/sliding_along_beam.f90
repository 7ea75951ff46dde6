!> Point that slides along an exact beam. Its distance from the deformed axis is zero. Variables are the place z of the point in the
!> frame of the beam and the beam's coordinates. Floor: multibody. Source: doc/theory, eqs. (3.25)-(3.27).
module limber_multibody_sliding_along_beam
   use limber_base_kinds, only: wp
   use limber_beam_exact_beam, only: exact_type, panel_stations, gauss_place, gauss_weight
   use limber_multibody_plane_vectors, only: turn, along
   use limber_multibody_function_constraints, only: function_constraint_type, variables_type
   implicit none
   private
   public :: exact_path_type, set_axis, foot_of

   !> A point slides along an exact beam: f = n(s) . (z - p(s)) at the s with p'(s) . (z - p(s)) = 0
   type, extends(function_constraint_type) :: exact_path_type
      type(exact_type) :: exact
      !> Lagrange's polynomials of a panel in those of Legendre (0:, stations of a panel)
      real(wp) :: legendre(0:panel_stations - 1, panel_stations) = 0.0_wp
   contains
      procedure :: evaluate
   end type exact_path_type

contains

   !> Takes the constants of a beam.
   subroutine set_axis(joint, exact)
      type(exact_path_type), intent(inout) :: joint
      type(exact_type), intent(in) :: exact
      real(wp) :: p(0:panel_stations)
      integer :: j, k
      joint%exact = exact
      do j = 1, panel_stations
         p = polynomials(gauss_place(j))
         do k = 0, panel_stations - 1
            joint%legendre(k, j) = 0.5_wp*(2*k + 1)*gauss_weight(j)*p(k)
         end do
      end do
   end subroutine set_axis

   !> f with its derivatives, eqs. (3.25)-(3.27).
   pure subroutine evaluate(self, order, at)
      class(exact_path_type), intent(in) :: self
      integer, intent(in) :: order
      type(variables_type), intent(inout) :: at
      real(wp) :: g(2, self%exact%stations), by(2, self%exact%n, self%exact%stations), p_by(2, self%exact%n)
      real(wp) :: normal(2), gap(2), unit(2), size_of
      real(wp) :: reach(self%exact%stations), slope(self%exact%stations), bent(self%exact%stations)
      real(wp) :: p(2), tangent(2), tangent_s(2), s
      integer :: i, k, n
      n = self%exact%n
      call place_axis(self%exact, at%z(3:2 + n), order, g, by)
      call find_foot(self, g, at%z(1:2), s, reach, slope, bent, p, tangent, tangent_s)
      gap = at%z(1:2) - p
      size_of = norm2(tangent)
      unit = tangent/size_of
      normal = turn(unit)
      at%f(1) = dot_product(normal, gap)
      if (order == 0) return
      p_by = 0.0_wp
      do k = 1, self%exact%stations
         do i = 1, n
            p_by(:, i) = p_by(:, i) + reach(k)*by(:, i, k)
         end do
      end do
      at%gradient(1, 1:2) = normal
      do i = 1, n
         at%gradient(1, 2 + i) = -dot_product(normal, p_by(:, i))
      end do
      if (order > 1) call find_hessian(at%hessian(:, :, 1))

   contains

      !> The foot moves by s_x, and the tangent turns there.
      pure subroutine find_hessian(hessian)
         real(wp), intent(inout) :: hessian(:, :)
         real(wp) :: tangent_by(2, n), s_by(2 + n), turn_by(2 + n), second
         integer :: i, j, k, a
         a = self%exact%angles
         tangent_by = 0.0_wp
         do k = 1, self%exact%stations
            if (.not. abs(slope(k)) > 0.0_wp) cycle
            do i = 1, n
               tangent_by(:, i) = tangent_by(:, i) + slope(k)*by(:, i, k)
            end do
         end do
         s_by(1:2) = tangent
         do i = 1, n
            s_by(2 + i) = dot_product(tangent_by(:, i), gap) - dot_product(tangent, p_by(:, i))
         end do
         s_by = s_by/(size_of**2 - dot_product(tangent_s, gap))
         turn_by = dot_product(normal, tangent_s)*s_by
         do i = 1, n
            turn_by(2 + i) = turn_by(2 + i) + dot_product(normal, tangent_by(:, i))
         end do
         turn_by = turn_by/size_of
         do j = 1, 2 + n
            hessian(1:2, j) = -unit*turn_by(j)
            do i = 1, n
               hessian(2 + i, j) = dot_product(unit, p_by(:, i))*turn_by(j) - dot_product(normal, tangent_by(:, i))*s_by(j)
            end do
         end do
         do j = 1, n
            do i = 1, n
               if (i > a .and. j > a) cycle
               second = 0.0_wp
               do k = 1, self%exact%stations
                  if (i <= a) second = second + reach(k)*self%exact%psi(i, k)*dot_product(normal, turn(by(:, j, k)))
                  if (i > a) second = second + reach(k)*self%exact%psi(j, k)*dot_product(normal, turn(by(:, i, k)))
               end do
               hessian(2 + i, 2 + j) = hessian(2 + i, 2 + j) - second
            end do
         end do
      end subroutine find_hessian

   end subroutine evaluate

   !> p' at the stations (2, stations); its derivatives by the coordinates (2, n, stations) from order 1 on.
   pure subroutine place_axis(exact, eta, order, g, by)
      type(exact_type), intent(in) :: exact
      real(wp), intent(in) :: eta(:)
      integer, intent(in) :: order
      real(wp), intent(out) :: g(:, :), by(:, :, :)
      real(wp) :: angle, axis(2), strain(2)
      integer :: i, k, a
      a = exact%angles
      do k = 1, exact%stations
         angle = exact%lean(k)
         do i = 1, a
            angle = angle + exact%psi(i, k)*eta(i)
         end do
         strain = [1.0_wp, 0.0_wp]
         do i = 1, exact%strains
            strain = strain + exact%chi(:, i, k)*eta(a + i)
         end do
         axis = [cos(angle), sin(angle)]
         g(:, k) = along(strain, axis)
         if (order == 0) cycle
         do i = 1, a
            by(:, i, k) = exact%psi(i, k)*turn(g(:, k))
         end do
         do i = 1, exact%strains
            by(:, a + i, k) = along(exact%chi(:, i, k), axis)
         end do
      end do
   end subroutine place_axis

   !> The place on the axis next to a point, by Newton's method from the nearest station.
   pure subroutine find_foot(self, g, z, s, reach, slope, bent, p, tangent, tangent_s)
      class(exact_path_type), intent(in) :: self
      real(wp), intent(in) :: g(:, :), z(2)
      !> Coordinate; what the stations give to the place, and to its first two derivatives (stations); these (2)
      real(wp), intent(out) :: s, reach(:), slope(:), bent(:), p(2), tangent(2), tangent_s(2)
      real(wp) :: change
      integer :: round
      s = nearest_station(self%exact, g, z)
      do round = 1, 30
         call find_rows(self, s, reach, slope, bent)
         p = matmul(g, reach)
         tangent = matmul(g, slope)
         tangent_s = matmul(g, bent)
         change = dot_product(tangent, z - p) &
            & /(dot_product(tangent, tangent) - min(dot_product(tangent_s, z - p), 0.5_wp*dot_product(tangent, tangent)))
         if (abs(change) <= 2*epsilon(s)*self%exact%total) return
         s = s + change
      end do
   end subroutine find_foot

   !> Coordinate of the station that is nearest to a point, to the breadth of a station.
   pure real(wp) function nearest_station(exact, g, z) result(s)
      type(exact_type), intent(in) :: exact
      real(wp), intent(in) :: g(:, :), z(2)
      real(wp) :: p(2), distance, least
      integer :: k
      p = -matmul(g, exact%base)
      least = huge(1.0_wp)
      s = 0.0_wp
      do k = 1, exact%stations
         p = p + 0.5_wp*exact%weight(k)*g(:, k)
         distance = norm2(z - p)
         if (distance < least) s = exact%s(k)
         least = min(least, distance)
         p = p + 0.5_wp*exact%weight(k)*g(:, k)
      end do
   end function nearest_station

   !> Coordinate along the beam where the point slides.
   pure real(wp) function foot_of(self, z, eta) result(s)
      class(exact_path_type), intent(in) :: self
      !> Place of the point in the frame of the beam (2), coordinates of the beam (n)
      real(wp), intent(in) :: z(2), eta(:)
      real(wp) :: g(2, self%exact%stations), by(2, self%exact%n, self%exact%stations), p(2), tangent(2, 2)
      real(wp) :: reach(self%exact%stations), slope(self%exact%stations), bent(self%exact%stations)
      call place_axis(self%exact, eta, 0, g, by)
      call find_foot(self, g, z, s, reach, slope, bent, p, tangent(:, 1), tangent(:, 2))
   end function foot_of

   !> What the stations give to the place of a coordinate and to its first two derivatives; straight beyond the ends.
   pure subroutine find_rows(self, s, reach, slope, bent)
      class(exact_path_type), intent(in) :: self
      real(wp), intent(in) :: s
      real(wp), intent(out) :: reach(:), slope(:), bent(:)
      real(wp) :: place, from, x, p(0:panel_stations), value, inner, change, rate(0:panel_stations - 1)
      integer :: panel, first, j, k
      place = max(0.0_wp, min(s, self%exact%total))
      reach = -self%exact%base
      slope = 0.0_wp
      bent = 0.0_wp
      from = 0.0_wp
      first = 0
      do panel = 1, size(self%exact%panel) - 1
         if (place <= from + self%exact%panel(panel)) exit
         reach(first + 1:first + panel_stations) = reach(first + 1:first + panel_stations) &
            & + self%exact%weight(first + 1:first + panel_stations)
         from = from + self%exact%panel(panel)
         first = first + panel_stations
      end do
      associate (length => self%exact%panel(panel))
         x = 2*(place - from)/length - 1
         p = polynomials(x)
         rate(0:1) = [0.0_wp, 1.0_wp]
         do k = 2, panel_stations - 1
            rate(k) = rate(k - 2) + (2*k - 1)*p(k - 1)
         end do
         do j = 1, panel_stations
            inner = self%legendre(0, j)*(x + 1)
            value = self%legendre(0, j)
            change = 0.0_wp
            do k = 1, panel_stations - 1
               inner = inner + self%legendre(k, j)*(p(k + 1) - p(k - 1))/(2*k + 1)
               value = value + self%legendre(k, j)*p(k)
               change = change + self%legendre(k, j)*rate(k)
            end do
            reach(first + j) = reach(first + j) + 0.5_wp*length*inner + (s - place)*value
            slope(first + j) = value
            if (.not. abs(s - place) > 0.0_wp) bent(first + j) = 2*change/length
         end do
      end associate
   end subroutine find_rows

   !> Legendre's polynomials of degrees 0 to `panel_stations`.
   pure function polynomials(x) result(p)
      real(wp), intent(in) :: x
      real(wp) :: p(0:panel_stations)
      integer :: k
      p(0:1) = [1.0_wp, x]
      do k = 2, panel_stations
         p(k) = ((2*k - 1)*x*p(k - 1) - (k - 1)*p(k - 2))/k
      end do
   end function polynomials

end module limber_multibody_sliding_along_beam
