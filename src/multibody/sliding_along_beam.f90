!> Point that slides along an exact beam. Its distance from the deformed axis is zero; where on the axis it is, is a coordinate that
!> drivers, couplers and laws take. Variables are the place z of the point in the frame of the beam and the beam's coordinates.
!> Floor: multibody. Source: doc/theory, eqs. (3.25)-(3.27).
module limber_multibody_sliding_along_beam
   use limber_base_kinds, only: wp
   use limber_beam_exact_beam, only: exact_type, panel_stations, gauss_place, gauss_weight
   use limber_multibody_plane_vectors, only: turn, along
   use limber_multibody_beam_path, only: beam_path_type
   use limber_multibody_function_constraints, only: variables_type
   implicit none
   private
   public :: exact_path_type, set_axis, foot_of

   !> A point slides along an exact beam: f = n(s) . (z - p(s)) at the s with p'(s) . (z - p(s)) = 0; or f = factor s - offset
   type, extends(beam_path_type) :: exact_path_type
      type(exact_type) :: exact
      !> Lagrange's polynomials of a panel in those of Legendre (0:, stations of a panel)
      real(wp) :: legendre(0:panel_stations - 1, panel_stations) = 0.0_wp
   contains
      procedure :: evaluate
      procedure :: coordinate
   end type exact_path_type

   !> The foot of a point on the axis
   type :: foot_type
      !> Its coordinate; its place with three derivatives by that (2, 0:3); the point from it (2)
      real(wp) :: s = 0.0_wp, p(2, 0:3) = 0.0_wp, gap(2) = 0.0_wp
   end type foot_type

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
      real(wp) :: g(2, self%exact%stations), by(2, self%exact%n, self%exact%stations), rows(self%exact%stations, 0:3)
      real(wp) :: p_by(2, self%exact%n, 0:2), normal(2)
      type(foot_type) :: foot
      integer :: k, m, n
      n = self%exact%n
      call place_axis(self%exact, at%z(3:2 + n), order, g, by)
      call find_foot(self, g, at%z(1:2), rows, foot)
      normal = turn(foot%p(:, 1)/norm2(foot%p(:, 1)))
      at%f(1) = dot_product(normal, foot%gap)
      if (self%of_coordinate) at%f(1) = self%factor*foot%s - self%offset
      if (order == 0) return
      p_by = 0.0_wp
      do m = 0, order
         do k = 1, self%exact%stations
            if (abs(rows(k, m)) > 0.0_wp) p_by(:, :, m) = p_by(:, :, m) + rows(k, m)*by(:, :, k)
         end do
      end do
      if (self%of_coordinate) then
         at%gradient(1, :2 + n) = self%factor*foot_gradient(foot, p_by)
         if (order > 1) call coordinate_hessian(self%exact, foot, rows, by, p_by, at%hessian(:2 + n, :2 + n, 1))
         if (order > 1) at%hessian(:2 + n, :2 + n, 1) = self%factor*at%hessian(:2 + n, :2 + n, 1)
         return
      end if
      at%gradient(1, 1:2) = normal
      at%gradient(1, 3:2 + n) = -matmul(normal, p_by(:, :, 0))
      if (order > 1) call distance_hessian(self%exact, foot, rows, by, p_by, at%hessian(:2 + n, :2 + n, 1))
   end subroutine evaluate

   !> Second derivatives of the distance: the foot moves by s_x, and the tangent turns there, eqs. (3.26), (3.27).
   pure subroutine distance_hessian(exact, foot, rows, by, p_by, hessian)
      type(exact_type), intent(in) :: exact
      type(foot_type), intent(in) :: foot
      !> What the stations give to the place and its derivatives (stations, 0:3); derivatives by the coordinates of p' at the
      !> stations (2, n, stations), and of the foot's place with two derivatives (2, n, 0:2)
      real(wp), intent(in) :: rows(:, 0:), by(:, :, :), p_by(:, :, 0:)
      real(wp), intent(out) :: hessian(:, :)
      real(wp) :: s_by(2 + exact%n), turn_by(2 + exact%n), unit(2), normal(2), length, push(2, exact%stations)
      integer :: j, k, n
      n = exact%n
      length = norm2(foot%p(:, 1))
      unit = foot%p(:, 1)/length
      normal = turn(unit)
      s_by = foot_gradient(foot, p_by)
      turn_by = dot_product(normal, foot%p(:, 2))*s_by
      turn_by(3:) = turn_by(3:) + matmul(normal, p_by(:, :, 1))
      turn_by = turn_by/length
      do k = 1, exact%stations
         push(:, k) = -rows(k, 0)*normal
      end do
      call add_bent(exact, push, by, hessian)
      do j = 1, 2 + n
         hessian(1:2, j) = -unit*turn_by(j)
         hessian(3:, j) = hessian(3:, j) + matmul(unit, p_by(:, :, 0))*turn_by(j) - matmul(normal, p_by(:, :, 1))*s_by(j)
      end do
   end subroutine distance_hessian

   !> Second derivatives of the coordinate of the foot, eq. (3.27).
   pure subroutine coordinate_hessian(exact, foot, rows, by, p_by, hessian)
      type(exact_type), intent(in) :: exact
      type(foot_type), intent(in) :: foot
      real(wp), intent(in) :: rows(:, 0:), by(:, :, :), p_by(:, :, 0:)
      real(wp), intent(out) :: hessian(:, :)
      real(wp) :: s_by(2 + exact%n), row_by(2 + exact%n), row_s, push(2, exact%stations)
      integer :: i, j, k, n
      n = exact%n
      s_by = foot_gradient(foot, p_by)
      ! Of F = p' . (z - p), which is zero at the foot: F_ss, and F_s by all variables
      row_s = dot_product(foot%p(:, 3), foot%gap) - 3*dot_product(foot%p(:, 1), foot%p(:, 2))
      row_by(1:2) = foot%p(:, 2)
      row_by(3:) = matmul(foot%gap, p_by(:, :, 2)) - 2*matmul(foot%p(:, 1), p_by(:, :, 1)) - matmul(foot%p(:, 2), p_by(:, :, 0))
      do k = 1, exact%stations
         push(:, k) = rows(k, 1)*foot%gap - rows(k, 0)*foot%p(:, 1)
      end do
      call add_bent(exact, push, by, hessian)
      hessian(1:2, 3:) = p_by(:, :, 1)
      hessian(3:, 1:2) = transpose(p_by(:, :, 1))
      do j = 1, n
         do i = 1, n
            hessian(2 + i, 2 + j) = hessian(2 + i, 2 + j) - dot_product(p_by(:, i, 1), p_by(:, j, 0)) &
               & - dot_product(p_by(:, j, 1), p_by(:, i, 0))
         end do
      end do
      do j = 1, 2 + n
         hessian(:, j) = hessian(:, j) + row_by*s_by(j) + s_by*row_by(j) + row_s*s_by*s_by(j)
      end do
      hessian = hessian/steepness(foot)
   end subroutine coordinate_hessian

   !> Sum over the stations of a vector and the second derivatives of p' by the coordinates; zero elsewhere.
   pure subroutine add_bent(exact, push, by, hessian)
      type(exact_type), intent(in) :: exact
      !> Vectors (2, stations)
      real(wp), intent(in) :: push(:, :), by(:, :, :)
      !> Rows and columns 1 and 2 are those of z
      real(wp), intent(out) :: hessian(:, :)
      real(wp) :: second
      integer :: i, j, k
      hessian = 0.0_wp
      do j = 1, exact%n
         do i = 1, min(j, exact%angles)
            second = 0.0_wp
            do k = 1, exact%stations
               second = second + exact%psi(i, k)*dot_product(push(:, k), turn(by(:, j, k)))
            end do
            hessian(2 + i, 2 + j) = second
            hessian(2 + j, 2 + i) = second
         end do
      end do
   end subroutine add_bent

   !> Derivatives of the coordinate of the foot by z and the beam's coordinates, eq. (3.26).
   pure function foot_gradient(foot, p_by) result(s_by)
      type(foot_type), intent(in) :: foot
      !> Of the foot's place and its derivative (2, n, 0:)
      real(wp), intent(in) :: p_by(:, :, 0:)
      real(wp) :: s_by(2 + size(p_by, 2))
      s_by(1:2) = foot%p(:, 1)
      s_by(3:) = matmul(foot%gap, p_by(:, :, 1)) - matmul(foot%p(:, 1), p_by(:, :, 0))
      s_by = s_by/steepness(foot)
   end function foot_gradient

   !> |p'|^2 - p'' . (z - p).
   pure real(wp) function steepness(foot)
      type(foot_type), intent(in) :: foot
      steepness = dot_product(foot%p(:, 1), foot%p(:, 1)) - dot_product(foot%p(:, 2), foot%gap)
   end function steepness

   !> s and its rate, eq. (3.26).
   pure subroutine coordinate(self, z, rate, s, speed)
      class(exact_path_type), intent(in) :: self
      real(wp), intent(in) :: z(:), rate(:)
      real(wp), intent(out) :: s, speed
      real(wp) :: g(2, self%exact%stations), by(2, self%exact%n, self%exact%stations), rows(self%exact%stations, 0:3)
      real(wp) :: p_by(2, self%exact%n, 0:1)
      type(foot_type) :: foot
      integer :: k, m
      call place_axis(self%exact, z(3:), 1, g, by)
      call find_foot(self, g, z(1:2), rows, foot)
      s = foot%s
      p_by = 0.0_wp
      do m = 0, 1
         do k = 1, self%exact%stations
            p_by(:, :, m) = p_by(:, :, m) + rows(k, m)*by(:, :, k)
         end do
      end do
      speed = dot_product(foot_gradient(foot, p_by), rate)
   end subroutine coordinate

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
   pure subroutine find_foot(self, g, z, rows, foot)
      class(exact_path_type), intent(in) :: self
      real(wp), intent(in) :: g(:, :), z(2)
      !> What the stations give to the place, and to its first three derivatives (stations, 0:3)
      real(wp), intent(out) :: rows(:, 0:)
      type(foot_type), intent(out) :: foot
      real(wp) :: change, square
      integer :: round
      foot%s = nearest_station(self%exact, g, z)
      do round = 1, 30
         call find_rows(self, foot%s, rows)
         foot%p = matmul(g, rows)
         foot%gap = z - foot%p(:, 0)
         square = dot_product(foot%p(:, 1), foot%p(:, 1))
         change = dot_product(foot%p(:, 1), foot%gap)/(square - min(dot_product(foot%p(:, 2), foot%gap), 0.5_wp*square))
         if (abs(change) <= 2*epsilon(change)*self%exact%total) return
         foot%s = foot%s + change
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
      real(wp) :: g(2, self%exact%stations), by(2, self%exact%n, self%exact%stations), rows(self%exact%stations, 0:3)
      type(foot_type) :: foot
      call place_axis(self%exact, eta, 0, g, by)
      call find_foot(self, g, z, rows, foot)
      s = foot%s
   end function foot_of

   !> What the stations give to the place of a coordinate and to its first three derivatives; straight beyond the ends.
   pure subroutine find_rows(self, s, rows)
      class(exact_path_type), intent(in) :: self
      real(wp), intent(in) :: s
      real(wp), intent(out) :: rows(:, 0:)
      real(wp) :: place, from, x, p(0:panel_stations), inner, value(0:2), rate(0:panel_stations - 1, 0:2)
      integer :: panel, first, j, k
      place = max(0.0_wp, min(s, self%exact%total))
      rows = 0.0_wp
      rows(:, 0) = -self%exact%base
      from = 0.0_wp
      first = 0
      do panel = 1, size(self%exact%panel) - 1
         if (place <= from + self%exact%panel(panel)) exit
         rows(first + 1:first + panel_stations, 0) = rows(first + 1:first + panel_stations, 0) &
            & + self%exact%weight(first + 1:first + panel_stations)
         from = from + self%exact%panel(panel)
         first = first + panel_stations
      end do
      associate (length => self%exact%panel(panel))
         x = 2*(place - from)/length - 1
         p = polynomials(x)
         ! The polynomials with two derivatives
         rate(:, 0) = p(:panel_stations - 1)
         rate(0:1, 1) = [0.0_wp, 1.0_wp]
         rate(0:1, 2) = 0.0_wp
         do k = 2, panel_stations - 1
            rate(k, 1:2) = rate(k - 2, 1:2) + (2*k - 1)*rate(k - 1, 0:1)
         end do
         do j = 1, panel_stations
            inner = self%legendre(0, j)*(x + 1)
            do k = 1, panel_stations - 1
               inner = inner + self%legendre(k, j)*(p(k + 1) - p(k - 1))/(2*k + 1)
            end do
            value = matmul(self%legendre(:, j), rate)*[1.0_wp, 2/length, (2/length)**2]
            rows(first + j, 0) = rows(first + j, 0) + 0.5_wp*length*inner + (s - place)*value(0)
            rows(first + j, 1) = value(0)
            if (.not. abs(s - place) > 0.0_wp) rows(first + j, 2:3) = value(1:2)
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
