!> Axis of an exact beam in motion and its inertia. Where its stations and masses are in the frame of the beam, how they move, and
!> the inertia forces and weight that follow; their derivatives stand in `centreline_tangent`. Everything is a sum over the stations
!> of
!>
!>    g = R(theta) sigma = x'(s),   d(g)/d(eta_a) = psi_a J g,   d(g)/d(eta_b) = R chi_b
!>
!> and of its integrals along the axis. No allocation but in `new_centreline`. Floor: multibody.
!> Source: doc/theory, part 2, eqs. (2.31)-(2.33), (2.36)-(2.38), (2.41)-(2.46).
module limber_multibody_beam_axis
   use limber_base_kinds, only: wp
   use limber_base_sines, only: take_sines
   use limber_base_snapshot, only: snapshot_type
   use limber_beam_exact_beam, only: exact_type, panel_stations, gauss_weight, integrate_panel, gather_panel
   use limber_multibody_plane_vectors, only: turn, along, cross
   implicit none
   private
   public :: centreline_type, new_centreline, integrate, gather, inner, inner_pair

   !> An exact beam at a state. Vectors are in the axes of its frame. Stations, or points, come first: they are many, the functions
   !> few
   type, extends(exact_type) :: centreline_type
      !> Functions of the angle (stations, angles), and of the strain (stations, 2, strains)
      real(wp), allocatable :: angle(:, :), stretch(:, :, :)
      !> g, and its derivatives by the coordinates, at the stations (stations, 2), (stations, n)
      real(wp), allocatable :: g(:, :), gx(:, :), gy(:, :)
      !> Places of the points, and their derivatives (points, 2), (points, n)
      real(wp), allocatable :: p(:, :), dx(:, :), dy(:, :)
      !> Rates of the angle (stations), of g, of the strain in fixed section axes R sigma' (stations, 2); what velocities alone
      !> make of the acceleration of g (stations, 2)
      real(wp), allocatable :: turning(:), drift(:, :), straining(:, :), bias(:, :)
      !> Velocities of the points (points, 2)
      real(wp), allocatable :: speed(:, :)
      !> Coordinates at which the stations are placed (n), and whether they are
      real(wp), allocatable :: at(:)
      logical :: placed = .false.
      !> Whether the points are placed, and moved, as the stations are
      logical :: spread = .false., swept = .false.
      !> Scratch: (stations, n), (points, n); fields along the axis (points, 6), forces on the points (points, 2), pulls on the
      !> stations (stations, 2)
      real(wp), allocatable :: hx(:, :), hy(:, :), ax(:, :), ay(:, :), field(:, :), force(:, :), pull(:, :)
   contains
      procedure :: place, place_axis, move, place_stations, move_stations, mass_matrix, eta_mass, forces, kinetic, moment, momenta
      procedure :: is_at, spread_points, add_curvature, add_bend, drift_of, accelerations, exchange => exchange_centreline
   end type centreline_type

contains

   !> Room.
   pure subroutine new_centreline(exact, line)
      type(exact_type), intent(in) :: exact
      type(centreline_type), intent(out) :: line
      integer :: i
      line%exact_type = exact
      associate (n => exact%n, k => exact%stations, m => exact%points)
         allocate (line%g(k, 2), line%gx(k, n), line%gy(k, n), line%p(m, 2), line%dx(m, n), line%dy(m, n))
         allocate (line%turning(k), line%drift(k, 2), line%straining(k, 2), line%bias(k, 2), line%speed(m, 2))
         allocate (line%hx(k, n), line%hy(k, n), line%ax(m, n), line%ay(m, n), line%field(m, 6), line%force(m, 2), &
            & line%pull(k, 2))
         allocate (line%angle(k, exact%angles), line%stretch(k, 2, exact%strains))
         line%angle = transpose(exact%psi)
         do i = 1, exact%strains
            line%stretch(:, :, i) = transpose(exact%chi(:, i, :))
         end do
         line%turning = 0.0_wp
         line%drift = 0.0_wp
         line%straining = 0.0_wp
         line%bias = 0.0_wp
         line%speed = 0.0_wp
         allocate (line%at(n))
         line%at = 0.0_wp
      end associate
   end subroutine new_centreline

   !> Places stations and points at the coordinates.
   pure subroutine place(self, eta)
      class(centreline_type), intent(inout) :: self
      !> (n)
      real(wp), contiguous, intent(in) :: eta(:)
      call self%place_stations(eta)
      call spread_points(self)
   end subroutine place

   !> Places stations and points, without their derivatives: all that energies ask for.
   pure subroutine place_axis(self, eta)
      class(centreline_type), intent(inout) :: self
      !> (n)
      real(wp), contiguous, intent(in) :: eta(:)
      call self%place_stations(eta)
      if (.not. self%spread) call integrate(self, 2, self%g, self%p)
   end subroutine place_axis

   !> Velocities of stations and points at the placed coordinates.
   pure subroutine move(self, rate)
      class(centreline_type), intent(inout) :: self
      !> Rates of the coordinates (n)
      real(wp), contiguous, intent(in) :: rate(:)
      call self%move_stations(rate)
      call sweep_points(self)
   end subroutine move

   !> Places the stations, if they are elsewhere: all that markers need. The points follow when something asks for them.
   pure subroutine place_stations(self, eta)
      class(centreline_type), intent(inout) :: self
      !> (n)
      real(wp), contiguous, intent(in) :: eta(:)
      integer :: before
      if (self%is_at(eta)) return
      self%at = eta
      self%placed = all(abs(eta) <= huge(eta))
      do before = 0, self%stations - panel_stations, panel_stations
         call place_panel(before, self%stations, self%angles, self%strains, self%n, self%lean, self%angle, self%stretch, eta, &
            & self%g, self%gx, self%gy)
      end do
      self%spread = .false.
      self%swept = .false.
   end subroutine place_stations

   !> Whether the stations are placed at coordinates.
   pure logical function is_at(self, eta)
      class(centreline_type), intent(in) :: self
      !> (n)
      real(wp), contiguous, intent(in) :: eta(:)
      is_at = self%placed
      if (is_at) is_at = .not. any(abs(eta - self%at) > 0.0_wp)
   end function is_at

   !> The stations of a panel: g and its derivatives.
   pure subroutine place_panel(before, stations, angles, strains, n, lean, angle, stretch, eta, g, gx, gy)
      !> Stations before the panel; numbers of all, of functions of the angle, of the strain, of both
      integer, intent(in) :: before, stations, angles, strains, n
      !> Angle of the undeformed axis, functions, coordinates
      real(wp), intent(in) :: lean(stations), angle(stations, angles), stretch(stations, 2, strains), eta(n)
      real(wp), intent(inout) :: g(stations, 2), gx(stations, n), gy(stations, n)
      real(wp) :: theta(panel_stations), c(panel_stations), s(panel_stations), x(panel_stations), y(panel_stations)
      integer :: i, k
      do k = 1, panel_stations
         theta(k) = lean(before + k)
      end do
      do i = 1, angles
         do k = 1, panel_stations
            theta(k) = theta(k) + angle(before + k, i)*eta(i)
         end do
      end do
      call take_sines(panel_stations, theta, s, c)
      x = 1.0_wp
      y = 0.0_wp
      do i = 1, strains
         do k = 1, panel_stations
            x(k) = x(k) + stretch(before + k, 1, i)*eta(angles + i)
            y(k) = y(k) + stretch(before + k, 2, i)*eta(angles + i)
            gx(before + k, angles + i) = c(k)*stretch(before + k, 1, i) - s(k)*stretch(before + k, 2, i)
            gy(before + k, angles + i) = s(k)*stretch(before + k, 1, i) + c(k)*stretch(before + k, 2, i)
         end do
      end do
      do k = 1, panel_stations
         g(before + k, 1) = c(k)*x(k) - s(k)*y(k)
         g(before + k, 2) = s(k)*x(k) + c(k)*y(k)
      end do
      do i = 1, angles
         do k = 1, panel_stations
            gx(before + k, i) = -g(before + k, 2)*angle(before + k, i)
            gy(before + k, i) = g(before + k, 1)*angle(before + k, i)
         end do
      end do
   end subroutine place_panel

   !> Places the points, if they are not.
   pure subroutine spread_points(self)
      class(centreline_type), intent(inout) :: self
      if (self%spread) return
      call integrate(self, 2, self%g, self%p)
      call integrate(self, self%n, self%gx, self%dx)
      call integrate(self, self%n, self%gy, self%dy)
      self%spread = .true.
   end subroutine spread_points

   !> Velocities of the stations at the placed coordinates.
   pure subroutine move_stations(self, rate)
      class(centreline_type), intent(inout) :: self
      !> Rates of the coordinates (n)
      real(wp), contiguous, intent(in) :: rate(:)
      integer :: before
      do before = 0, self%stations - panel_stations, panel_stations
         call move_panel(before, self%stations, self%angles, self%n, self%angle, self%gx, self%gy, self%g, rate, self%turning, &
            & self%straining, self%drift, self%bias)
      end do
      self%swept = .false.
   end subroutine move_stations

   !> The stations of a panel: rates of the angle, of the strain, of g, and what these make of its acceleration.
   pure subroutine move_panel(before, stations, angles, n, angle, gx, gy, g, rate, turning, straining, drift, bias)
      !> As in `place_panel`
      integer, intent(in) :: before, stations, angles, n
      real(wp), intent(in) :: angle(stations, angles), gx(stations, n), gy(stations, n), g(stations, 2), rate(n)
      real(wp), intent(inout) :: turning(stations), straining(stations, 2), drift(stations, 2), bias(stations, 2)
      real(wp) :: spin(panel_stations), x(panel_stations), y(panel_stations)
      integer :: i, k
      spin = 0.0_wp
      do i = 1, angles
         do k = 1, panel_stations
            spin(k) = spin(k) + angle(before + k, i)*rate(i)
         end do
      end do
      x = 0.0_wp
      y = 0.0_wp
      do i = angles + 1, n
         do k = 1, panel_stations
            x(k) = x(k) + gx(before + k, i)*rate(i)
            y(k) = y(k) + gy(before + k, i)*rate(i)
         end do
      end do
      do k = 1, panel_stations
         turning(before + k) = spin(k)
         straining(before + k, 1) = x(k)
         straining(before + k, 2) = y(k)
         drift(before + k, 1) = x(k) - spin(k)*g(before + k, 2)
         drift(before + k, 2) = y(k) + spin(k)*g(before + k, 1)
         bias(before + k, 1) = -spin(k)*(2*y(k) + spin(k)*g(before + k, 1))
         bias(before + k, 2) = spin(k)*(2*x(k) - spin(k)*g(before + k, 2))
      end do
   end subroutine move_panel

   !> Velocities of the points, if they are not there.
   pure subroutine sweep_points(self)
      class(centreline_type), intent(inout) :: self
      if (self%swept) return
      call integrate(self, 2, self%drift, self%speed)
      self%swept = .true.
   end subroutine sweep_points

   !> Integrals from the origin to all points of fields that are given at the stations.
   pure subroutine integrate(self, n, field, integral)
      class(centreline_type), intent(in) :: self
      !> Number of fields
      integer, intent(in) :: n
      real(wp), intent(in) :: field(self%stations, n)
      real(wp), intent(inout) :: integral(self%points, n)
      real(wp) :: before, half
      integer :: p, i, j, first
      do i = 1, n
         before = 0.0_wp
         if (self%shifted) before = -inner(self%stations, self%base, field(:, i))
         do p = 1, size(self%panel)
            first = panel_stations*(p - 1)
            half = 0.5_wp*self%panel(p)
            call integrate_panel(self%even, self%odd, field(first + 1:, i), before, half, integral(first + 1:, i))
            if (p < size(self%panel)) before = before + half*inner(panel_stations, gauss_weight, field(first + 1:, i))
         end do
         do j = 1, self%points - self%stations
            integral(self%stations + j, i) = inner(self%stations, self%reach(:, j), field(:, i))
         end do
      end do
   end subroutine integrate

   !> Sum of products, in four parts that are independent of one another.
   pure real(wp) function inner(n, a, b)
      integer, intent(in) :: n
      real(wp), intent(in) :: a(n), b(n)
      real(wp) :: part(4)
      integer :: k
      part = 0.0_wp
      do k = 1, n - 3, 4
         part = part + a(k:k + 3)*b(k:k + 3)
      end do
      inner = (part(1) + part(2)) + (part(3) + part(4))
      do k = n - modulo(n, 4) + 1, n
         inner = inner + a(k)*b(k)
      end do
   end function inner

   !> The same of two pairs.
   pure real(wp) function inner_pair(n, a, b, c, d) result(total)
      integer, intent(in) :: n
      real(wp), intent(in) :: a(n), b(n), c(n), d(n)
      real(wp) :: part(4)
      integer :: k
      part = 0.0_wp
      do k = 1, n - 3, 4
         part = part + (a(k:k + 3)*b(k:k + 3) + c(k:k + 3)*d(k:k + 3))
      end do
      total = (part(1) + part(2)) + (part(3) + part(4))
      do k = n - modulo(n, 4) + 1, n
         total = total + (a(k)*b(k) + c(k)*d(k))
      end do
   end function inner_pair

   !> The transpose: what forces at the points are for the field at the stations.
   pure subroutine gather(self, force, pull)
      class(centreline_type), intent(in) :: self
      !> (points, 2), (stations, 2)
      real(wp), contiguous, intent(in) :: force(:, :)
      real(wp), contiguous, intent(inout) :: pull(:, :)
      real(wp) :: beyond, half
      integer :: p, i, j, first
      do i = 1, 2
         beyond = 0.0_wp
         do p = size(self%panel), 1, -1
            first = panel_stations*(p - 1)
            half = 0.5_wp*self%panel(p)
            call gather_panel(self%even_across, self%odd_across, force(first + 1:, i), beyond, half, pull(first + 1:, i))
            beyond = beyond + total(force(first + 1:, i))
         end do
         do j = 1, self%points - self%stations
            pull(:, i) = pull(:, i) + self%reach(:, j)*force(self%stations + j, i)
         end do
         if (self%shifted) pull(:, i) = pull(:, i) - self%base*beyond
      end do
   end subroutine gather

   !> Sum over the stations of a panel, in parts that are independent of one another.
   pure real(wp) function total(f)
      real(wp), intent(in) :: f(panel_stations)
      total = ((f(1) + f(2)) + (f(3) + f(4))) + ((f(5) + f(6)) + (f(7) + f(8)))
   end function total

   !> Mass matrix of the frame and its coupling with the coordinates, eq. (2.37).
   pure subroutine mass_matrix(self, u, frame, coupling)
      class(centreline_type), intent(inout) :: self
      !> Unit vector of the frame (2)
      real(wp), intent(in) :: u(2)
      !> Of (r'', alpha) (3, 3); rows eta'', columns (r'', alpha) (n, 3)
      real(wp), intent(out) :: frame(3, 3)
      real(wp), intent(inout) :: coupling(:, :)
      real(wp) :: c(2), inertia, whole, x, y
      integer :: i, m
      call spread_points(self)
      m = self%points
      associate (mx => self%field(:, 1), my => self%field(:, 2))
         mx = self%mass*self%p(:, 1)
         my = self%mass*self%p(:, 2)
         whole = sum(self%mass)
         inertia = sum(self%inertia) + inner_pair(m, mx, self%p(:, 1), my, self%p(:, 2))
         do i = 1, self%n
            x = inner(m, self%mass, self%dx(:, i))
            y = inner(m, self%mass, self%dy(:, i))
            coupling(i, 1) = u(1)*x - u(2)*y
            coupling(i, 2) = u(1)*y + u(2)*x
            coupling(i, 3) = inner(m, mx, self%dy(:, i)) - inner(m, my, self%dx(:, i))
         end do
         c = along([sum(mx), sum(my)], u)
      end associate
      if (self%spinning) coupling(:self%angles, 3) = coupling(:self%angles, 3) + self%rotary
      frame(:, 1) = [whole, 0.0_wp, -c(2)]
      frame(:, 2) = [0.0_wp, whole, c(1)]
      frame(:, 3) = [-c(2), c(1), inertia]
   end subroutine mass_matrix

   !> Mass matrix of the coordinates, eq. (2.37): its lower triangle and its upper one.
   pure subroutine eta_mass(self, mass)
      class(centreline_type), intent(inout) :: self
      !> (n, n)
      real(wp), intent(inout) :: mass(:, :)
      integer :: i, j
      call spread_points(self)
      associate (x => self%field(:, 1), y => self%field(:, 2))
         do j = 1, self%n
            x = self%mass*self%dx(:, j)
            y = self%mass*self%dy(:, j)
            do i = j, self%n
               mass(i, j) = inner_pair(self%points, x, self%dx(:, i), y, self%dy(:, i))
            end do
         end do
      end associate
      if (self%spinning) mass(:self%angles, :self%angles) = mass(:self%angles, :self%angles) + self%rotary_mass
      do j = 2, self%n
         do i = 1, j - 1
            mass(i, j) = mass(j, i)
         end do
      end do
   end subroutine eta_mass

   !> Adds velocity terms and weight: minus what the rates alone contribute to M a, and gravity, eq. (2.38).
   pure subroutine forces(self, gravity, u, omega, on_frame, on_eta)
      class(centreline_type), intent(inout) :: self
      !> Acceleration of gravity (2), unit vector of the frame (2), its angular velocity
      real(wp), intent(in) :: gravity(2), u(2), omega
      !> Force and moment on the frame's origin (3), along the fixed axes; on the coordinates (n)
      real(wp), intent(inout) :: on_frame(3), on_eta(:)
      real(wp) :: weight(2)
      integer :: i
      call spread_points(self)
      weight = along(gravity, [u(1), -u(2)])
      self%pull(:, 1) = omega*(omega*self%g(:, 1) + 2*self%drift(:, 2)) - self%bias(:, 1)
      self%pull(:, 2) = omega*(omega*self%g(:, 2) - 2*self%drift(:, 1)) - self%bias(:, 2)
      call integrate(self, 2, self%pull, self%force)
      associate (fx => self%force(:, 1), fy => self%force(:, 2))
         fx = self%mass*(fx + weight(1))
         fy = self%mass*(fy + weight(2))
         on_frame(1:2) = on_frame(1:2) + along([sum(fx), sum(fy)], u)
         on_frame(3) = on_frame(3) + inner(self%points, self%p(:, 1), fy) - inner(self%points, self%p(:, 2), fx)
         do i = 1, self%n
            on_eta(i) = on_eta(i) + inner_pair(self%points, self%dx(:, i), fx, self%dy(:, i), fy)
         end do
      end associate
   end subroutine forces

   !> Adds the second derivatives by the coordinates of the sum of pull . g over the stations, eq. (2.44).
   pure subroutine add_curvature(self, pull, k)
      class(centreline_type), intent(in) :: self
      !> In the axes of the frame (stations, 2)
      real(wp), intent(in) :: pull(:, :)
      !> (n, n)
      real(wp), intent(inout) :: k(:, :)
      real(wp) :: x(panel_stations), y(panel_stations)
      integer :: before
      do before = 0, self%stations - 1, panel_stations
         x = pull(before + 1:before + panel_stations, 1)
         y = pull(before + 1:before + panel_stations, 2)
         call add_panel_curvature(self, before, x, y, k)
      end do
   end subroutine add_curvature

   !> The same of one force at a place with a reach.
   pure subroutine add_bend(self, reach, force, k)
      class(centreline_type), intent(in) :: self
      !> What the stations give to the place (stations); along the axes of the frame (2)
      real(wp), intent(in) :: reach(:), force(2)
      !> (n, n)
      real(wp), intent(inout) :: k(:, :)
      real(wp) :: x(panel_stations), y(panel_stations)
      integer :: before
      do before = 0, self%stations - 1, panel_stations
         x = reach(before + 1:before + panel_stations)*force(1)
         y = reach(before + 1:before + panel_stations)*force(2)
         call add_panel_curvature(self, before, x, y, k)
      end do
   end subroutine add_bend

   !> The part of a panel, behind so many stations.
   pure subroutine add_panel_curvature(self, before, x, y, k)
      class(centreline_type), intent(in) :: self
      integer, intent(in) :: before
      real(wp), intent(in) :: x(panel_stations), y(panel_stations)
      real(wp), intent(inout) :: k(:, :)
      real(wp) :: bend(panel_stations), part(panel_stations), value
      integer :: i, j, from, to
      from = before + 1
      to = before + panel_stations
      bend = x*self%g(from:to, 1) + y*self%g(from:to, 2)
      do j = 1, self%angles
         part = bend*self%angle(from:to, j)
         do i = j, self%angles
            value = inner(panel_stations, part, self%angle(from:to, i))
            k(i, j) = k(i, j) - value
            if (i > j) k(j, i) = k(j, i) - value
         end do
      end do
      do j = self%angles + 1, self%n
         part = self%gx(from:to, j)*y - self%gy(from:to, j)*x
         do i = 1, self%angles
            value = inner(panel_stations, part, self%angle(from:to, i))
            k(i, j) = k(i, j) + value
            k(j, i) = k(j, i) + value
         end do
      end do
   end subroutine add_panel_curvature

   !> Rate, in the axes of the frame, of the derivative by a coordinate of a place with a reach.
   pure function drift_of(self, reach, j) result(rate)
      class(centreline_type), intent(in) :: self
      real(wp), intent(in) :: reach(:)
      integer, intent(in) :: j
      real(wp) :: rate(2)
      integer :: k
      rate = 0.0_wp
      if (j <= self%angles) then
         do k = 1, self%stations
            rate = rate + reach(k)*self%angle(k, j)*[-self%drift(k, 2), self%drift(k, 1)]
         end do
      else
         do k = 1, self%stations
            rate = rate + reach(k)*self%turning(k)*[-self%gy(k, j), self%gx(k, j)]
         end do
      end if
   end function drift_of

   !> Accelerations of the points, less that of gravity, in the axes of the frame (points, 2); stations are placed and moved.
   pure subroutine accelerations(self, heavy, omega, alpha, eta_acceleration, field, push)
      class(centreline_type), intent(in) :: self
      !> Acceleration of the frame's origin less that of gravity, in the axes of the frame (2), angular velocity and acceleration,
      !> second derivatives of the coordinates (n)
      real(wp), intent(in) :: heavy(2), omega, alpha, eta_acceleration(:)
      !> Scratch (stations, 2)
      real(wp), contiguous, intent(inout) :: field(:, :)
      real(wp), contiguous, intent(inout) :: push(:, :)
      integer :: i
      field(:, 1) = self%bias(:, 1) - alpha*self%g(:, 2) - omega*(omega*self%g(:, 1) + 2*self%drift(:, 2))
      field(:, 2) = self%bias(:, 2) + alpha*self%g(:, 1) - omega*(omega*self%g(:, 2) - 2*self%drift(:, 1))
      do i = 1, self%n
         field(:, 1) = field(:, 1) + self%gx(:, i)*eta_acceleration(i)
         field(:, 2) = field(:, 2) + self%gy(:, i)*eta_acceleration(i)
      end do
      call integrate(self, 2, field, push)
      push(:, 1) = push(:, 1) + heavy(1)
      push(:, 2) = push(:, 2) + heavy(2)
   end subroutine accelerations

   !> First moment of mass in the axes of the frame (2).
   pure function moment(self) result(c)
      class(centreline_type), intent(in) :: self
      real(wp) :: c(2)
      integer :: k
      c = 0.0_wp
      do k = 1, self%points
         c = c + self%mass(k)*self%p(k, :)
      end do
   end function moment

   !> Kinetic energy; placed and moved.
   pure real(wp) function kinetic(self, velocity, omega, rate) result(energy)
      class(centreline_type), intent(in) :: self
      !> Velocity of the frame's origin in its axes (2), angular velocity, rates of the coordinates (n)
      real(wp), intent(in) :: velocity(2), omega, rate(:)
      real(wp) :: x, y
      integer :: k
      energy = 0.5_wp*sum(self%inertia)*omega**2
      do k = 1, self%points
         x = velocity(1) - omega*self%p(k, 2) + self%speed(k, 1)
         y = velocity(2) + omega*self%p(k, 1) + self%speed(k, 2)
         energy = energy + 0.5_wp*self%mass(k)*(x**2 + y**2)
      end do
      if (.not. self%spinning) return
      energy = energy + omega*dot_product(self%rotary, rate(:self%angles)) &
         & + 0.5_wp*dot_product(rate(:self%angles), matmul(self%rotary_mass, rate(:self%angles)))
   end function kinetic

   !> Linear momentum (2) and angular momentum about the origin, in the axes of the frame; placed and moved.
   pure function momenta(self, velocity, omega, rate) result(p)
      class(centreline_type), intent(in) :: self
      !> As in `kinetic`
      real(wp), intent(in) :: velocity(2), omega, rate(:)
      real(wp) :: p(3), v(2)
      integer :: k
      p = [0.0_wp, 0.0_wp, sum(self%inertia)*omega]
      do k = 1, self%points
         v = self%mass(k)*(velocity + omega*turn(self%p(k, :)) + self%speed(k, :))
         p(1:2) = p(1:2) + v
         p(3) = p(3) + cross(self%p(k, :), v)
      end do
      if (self%spinning) p(3) = p(3) + dot_product(self%rotary, rate(:self%angles))
   end function momenta

   !> Saves or restores its memory.
   subroutine exchange_centreline(self, snapshot)
      class(centreline_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%keep('g', self%g)
      call snapshot%keep('gx', self%gx)
      call snapshot%keep('gy', self%gy)
      call snapshot%keep('p', self%p)
      call snapshot%keep('dx', self%dx)
      call snapshot%keep('dy', self%dy)
      call snapshot%keep('turning', self%turning)
      call snapshot%keep('drift', self%drift)
      call snapshot%keep('straining', self%straining)
      call snapshot%keep('bias', self%bias)
      call snapshot%keep('speed', self%speed)
      self%placed = .false.
      self%spread = .false.
      self%swept = .false.
      ! Not saved: angle, stretch, at, hx, hy, ax, ay, field, force, pull
   end subroutine exchange_centreline

end module limber_multibody_beam_axis
