!> The axis of an exact beam in motion: where its stations and masses are in the frame of the beam, how they move, and the inertia
!> forces, weight and their derivatives that follow. Everything is a sum over the stations of
!>
!>    g = R(theta) sigma = x'(s),   d(g)/d(eta_a) = psi_a J g,   d(g)/d(eta_b) = R chi_b
!>
!> and of its integrals along the axis. No allocation but in `new_centreline`. Floor: system.
!> Source: doc/theory, section "The exact beam", eqs. (X1)-(X12).
module limber_system_centreline
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_flex_exact, only: exact_type, panel_stations, inside, gauss_weight, gauss_place
   use limber_system_algebra, only: turn, along, cross
   implicit none
   private
   public :: centreline_type, new_centreline, follow_place

   !> An exact beam at a state. Vectors are in the axes of its frame
   type, extends(exact_type) :: centreline_type
      !> Integrals of Lagrange's polynomials to the stations of a panel of unit half length
      real(wp) :: within(panel_stations, panel_stations) = 0.0_wp
      !> g, and its derivatives by the coordinates, at the stations (2, stations), (n, stations)
      real(wp), allocatable :: g(:, :), gx(:, :), gy(:, :)
      !> Section axis t at the stations (2, stations)
      real(wp), allocatable :: axis(:, :)
      !> Places of the points, and their derivatives (2, points), (n, points)
      real(wp), allocatable :: p(:, :), dx(:, :), dy(:, :)
      !> Rates of the angle (stations), of g, of the strain in fixed section axes R sigma' (2, stations); what velocities alone
      !> make of the acceleration of g (2, stations)
      real(wp), allocatable :: turning(:), drift(:, :), straining(:, :), bias(:, :)
      !> Velocities of the points, and what velocities alone make of their accelerations (2, points)
      real(wp), allocatable :: speed(:, :), swerve(:, :)
      !> Scratch: (n, stations), (n, points)
      real(wp), allocatable :: hx(:, :), hy(:, :), ax(:, :), ay(:, :)
   contains
      procedure :: place, move, mass_matrix, eta_mass, forces, tangent, kinetic, moment, momenta
      procedure :: add_curvature, drift_of, accelerations, exchange => exchange_centreline
   end type centreline_type

contains

   !> Room.
   pure subroutine new_centreline(exact, line)
      type(exact_type), intent(in) :: exact
      type(centreline_type), intent(out) :: line
      integer :: i
      line%exact_type = exact
      associate (n => exact%n, k => exact%stations, m => exact%points)
         allocate (line%g(2, k), line%gx(n, k), line%gy(n, k), line%axis(2, k), line%p(2, m), line%dx(n, m), line%dy(n, m))
         allocate (line%turning(k), line%drift(2, k), line%straining(2, k), line%bias(2, k), line%speed(2, m), line%swerve(2, m))
         allocate (line%hx(n, k), line%hy(n, k), line%ax(n, m), line%ay(n, m))
         line%turning = 0.0_wp
         line%drift = 0.0_wp
         line%straining = 0.0_wp
         line%bias = 0.0_wp
         line%speed = 0.0_wp
         line%swerve = 0.0_wp
      end associate
      do i = 1, panel_stations
         line%within(:, i) = inside(gauss_place(i))
      end do
   end subroutine new_centreline

   !> Places stations and points at the coordinates.
   pure subroutine place(self, eta)
      class(centreline_type), intent(inout) :: self
      !> (n)
      real(wp), contiguous, intent(in) :: eta(:)
      real(wp) :: theta, strain(2), c, s
      integer :: i, k, a
      a = self%angles
      do k = 1, self%stations
         theta = 0.0_wp
         do i = 1, a
            theta = theta + self%psi(i, k)*eta(i)
         end do
         strain = [1.0_wp, 0.0_wp]
         do i = 1, self%strains
            strain = strain + self%chi(:, i, k)*eta(a + i)
         end do
         c = cos(theta)
         s = sin(theta)
         self%axis(:, k) = [c, s]
         self%g(1, k) = c*strain(1) - s*strain(2)
         self%g(2, k) = s*strain(1) + c*strain(2)
         do i = 1, a
            self%gx(i, k) = -self%g(2, k)*self%psi(i, k)
            self%gy(i, k) = self%g(1, k)*self%psi(i, k)
         end do
         do i = 1, self%strains
            self%gx(a + i, k) = c*self%chi(1, i, k) - s*self%chi(2, i, k)
            self%gy(a + i, k) = s*self%chi(1, i, k) + c*self%chi(2, i, k)
         end do
      end do
      call integrate(self%panel, self%within, self%base, self%shifted, self%reach, 2, self%g, self%p)
      call integrate(self%panel, self%within, self%base, self%shifted, self%reach, self%n, self%gx, self%dx)
      call integrate(self%panel, self%within, self%base, self%shifted, self%reach, self%n, self%gy, self%dy)
   end subroutine place

   !> Velocities at the placed coordinates.
   pure subroutine move(self, rate)
      class(centreline_type), intent(inout) :: self
      !> Rates of the coordinates (n)
      real(wp), contiguous, intent(in) :: rate(:)
      real(wp) :: strain(2)
      integer :: i, k
      do k = 1, self%stations
         self%turning(k) = 0.0_wp
         do i = 1, self%angles
            self%turning(k) = self%turning(k) + self%psi(i, k)*rate(i)
         end do
         strain = 0.0_wp
         do i = self%angles + 1, self%n
            strain(1) = strain(1) + self%gx(i, k)*rate(i)
            strain(2) = strain(2) + self%gy(i, k)*rate(i)
         end do
         self%straining(:, k) = strain
         self%drift(:, k) = self%turning(k)*turn(self%g(:, k)) + strain
         self%bias(:, k) = 2*self%turning(k)*turn(strain) - self%turning(k)**2*self%g(:, k)
      end do
      call integrate(self%panel, self%within, self%base, self%shifted, self%reach, 2, self%drift, self%speed)
      call integrate(self%panel, self%within, self%base, self%shifted, self%reach, 2, self%bias, self%swerve)
   end subroutine move

   !> Integrals from the origin to all points of fields that are given at the stations.
   pure subroutine integrate(panel, within, base, shifted, reach, n, field, integral)
      !> As in the beam: lengths of the panels, integrals inside them, reach of the origin and of concentrated masses
      real(wp), intent(in) :: panel(:), within(panel_stations, panel_stations), base(:)
      logical, intent(in) :: shifted
      real(wp), intent(in) :: reach(:, :)
      !> Number of fields
      integer, intent(in) :: n
      real(wp), intent(in) :: field(n, size(base))
      real(wp), intent(inout) :: integral(n, size(base) + size(reach, 2))
      real(wp) :: before(n), half
      integer :: p, i, j, first
      before = 0.0_wp
      if (shifted) then
         do j = 1, size(base)
            before = before - base(j)*field(:, j)
         end do
      end if
      do p = 1, size(panel)
         first = panel_stations*(p - 1)
         half = 0.5_wp*panel(p)
         do i = 1, panel_stations
            integral(:, first + i) = before
            do j = 1, panel_stations
               integral(:, first + i) = integral(:, first + i) + half*within(j, i)*field(:, first + j)
            end do
         end do
         do j = 1, panel_stations
            before = before + half*gauss_weight(j)*field(:, first + j)
         end do
      end do
      do i = 1, size(reach, 2)
         integral(:, size(base) + i) = 0.0_wp
         do j = 1, size(base)
            integral(:, size(base) + i) = integral(:, size(base) + i) + reach(j, i)*field(:, j)
         end do
      end do
   end subroutine integrate

   !> The transpose: what forces at the points are for the field at the stations.
   pure subroutine gather(self, force, pull)
      class(centreline_type), intent(in) :: self
      !> (2, points), (2, stations)
      real(wp), intent(in) :: force(:, :)
      real(wp), intent(inout) :: pull(:, :)
      real(wp) :: beyond(2), whole(2), half
      integer :: p, i, j, first
      beyond = 0.0_wp
      do p = size(self%panel), 1, -1
         first = panel_stations*(p - 1)
         half = 0.5_wp*self%panel(p)
         do j = 1, panel_stations
            pull(:, first + j) = gauss_weight(j)*beyond
            do i = 1, panel_stations
               pull(:, first + j) = pull(:, first + j) + self%within(j, i)*force(:, first + i)
            end do
            pull(:, first + j) = half*pull(:, first + j)
         end do
         do i = 1, panel_stations
            beyond = beyond + force(:, first + i)
         end do
      end do
      whole = beyond
      do i = 1, self%points - self%stations
         do j = 1, self%stations
            pull(:, j) = pull(:, j) + self%reach(j, i)*force(:, self%stations + i)
         end do
      end do
      if (.not. self%shifted) return
      do j = 1, self%stations
         pull(:, j) = pull(:, j) - self%base(j)*whole
      end do
   end subroutine gather

   !> Mass matrix of the frame and its coupling with the coordinates, eq. (X5).
   pure subroutine mass_matrix(self, u, frame, coupling)
      class(centreline_type), intent(in) :: self
      !> Unit vector of the frame (2)
      real(wp), intent(in) :: u(2)
      !> Of (r'', alpha) (3, 3); rows eta'', columns (r'', alpha) (n, 3)
      real(wp), intent(out) :: frame(3, 3)
      real(wp), intent(inout) :: coupling(:, :)
      real(wp) :: c(2), m, inertia, whole
      integer :: i, k
      c = 0.0_wp
      inertia = sum(self%inertia)
      whole = 0.0_wp
      coupling = 0.0_wp
      do k = 1, self%points
         m = self%mass(k)
         whole = whole + m
         c = c + m*self%p(:, k)
         inertia = inertia + m*(self%p(1, k)**2 + self%p(2, k)**2)
         do i = 1, self%n
            coupling(i, 1) = coupling(i, 1) + m*self%dx(i, k)
            coupling(i, 2) = coupling(i, 2) + m*self%dy(i, k)
            coupling(i, 3) = coupling(i, 3) + m*(self%p(1, k)*self%dy(i, k) - self%p(2, k)*self%dx(i, k))
         end do
      end do
      do i = 1, self%n
         coupling(i, 1:2) = along(coupling(i, 1:2), u)
      end do
      if (self%spinning) coupling(:self%angles, 3) = coupling(:self%angles, 3) + self%rotary
      c = along(c, u)
      frame(:, 1) = [whole, 0.0_wp, -c(2)]
      frame(:, 2) = [0.0_wp, whole, c(1)]
      frame(:, 3) = [-c(2), c(1), inertia]
   end subroutine mass_matrix

   !> Mass matrix of the coordinates, eq. (X5): its lower triangle and its upper one.
   pure subroutine eta_mass(self, mass)
      class(centreline_type), intent(in) :: self
      !> (n, n)
      real(wp), intent(inout) :: mass(:, :)
      real(wp) :: x, y
      integer :: i, j, k
      mass = 0.0_wp
      do k = 1, self%points
         do j = 1, self%n
            x = self%mass(k)*self%dx(j, k)
            y = self%mass(k)*self%dy(j, k)
            do i = j, self%n
               mass(i, j) = mass(i, j) + x*self%dx(i, k) + y*self%dy(i, k)
            end do
         end do
      end do
      if (self%spinning) mass(:self%angles, :self%angles) = mass(:self%angles, :self%angles) + self%rotary_mass
      do j = 2, self%n
         mass(:j - 1, j) = mass(j, :j - 1)
      end do
   end subroutine eta_mass

   !> Adds velocity terms and weight: minus what the rates alone contribute to M a, and gravity, eq. (X6).
   pure subroutine forces(self, gravity, u, omega, on_frame, on_eta)
      class(centreline_type), intent(in) :: self
      !> Acceleration of gravity (2), unit vector of the frame (2), its angular velocity
      real(wp), intent(in) :: gravity(2), u(2), omega
      !> Force and moment on the frame's origin (3), along the fixed axes; on the coordinates (n)
      real(wp), intent(inout) :: on_frame(3), on_eta(:)
      real(wp) :: f(2), total(2), weight(2)
      integer :: i, k
      weight = along(gravity, [u(1), -u(2)])
      total = 0.0_wp
      do k = 1, self%points
         f = self%mass(k)*(omega**2*self%p(:, k) - 2*omega*turn(self%speed(:, k)) - self%swerve(:, k) + weight)
         total = total + f
         on_frame(3) = on_frame(3) + cross(self%p(:, k), f)
         do i = 1, self%n
            on_eta(i) = on_eta(i) + self%dx(i, k)*f(1) + self%dy(i, k)*f(2)
         end do
      end do
      on_frame(1:2) = on_frame(1:2) + along(total, u)
   end subroutine forces

   !> Derivatives of the inertia forces and the weight, M a + velocity terms - weight, with respect to (rotation, eta) and to
   !> (omega, eta'), both without the row and column of r, eqs. (X8)-(X10).
   pure subroutine tangent(self, gravity, u, omega, acceleration, alpha, eta_acceleration, stiffness, damping)
      class(centreline_type), intent(inout) :: self
      !> Acceleration of gravity (2), unit vector of the frame (2), its angular velocity, r'' (2), alpha, eta'' (n)
      real(wp), intent(in) :: gravity(2), u(2), omega, acceleration(2), alpha, eta_acceleration(:)
      !> Rows r'' (2), alpha, eta''; columns rotation, eta, and omega, eta': (3 + n, 1 + n). Added to
      real(wp), intent(inout) :: stiffness(:, :), damping(:, :)
      real(wp) :: heavy(2), swing, whirl, strain(2), h(2), part(2), pull(2, self%stations), force(2, self%points)
      integer :: i, k, n, a
      n = self%n
      a = self%angles
      heavy = along(acceleration - gravity, [u(1), -u(2)])
      ! What a change of the coordinates makes of the accelerations of the points
      do k = 1, self%stations
         swing = alpha
         do i = 1, a
            swing = swing + self%psi(i, k)*eta_acceleration(i)
         end do
         strain = 0.0_wp
         do i = a + 1, n
            strain(1) = strain(1) + self%gx(i, k)*eta_acceleration(i)
            strain(2) = strain(2) + self%gy(i, k)*eta_acceleration(i)
         end do
         whirl = omega + self%turning(k)
         h = -swing*self%g(:, k) - whirl**2*turn(self%g(:, k)) - 2*whirl*self%straining(:, k) + turn(strain)
         do i = 1, a
            self%hx(i, k) = self%psi(i, k)*h(1)
            self%hy(i, k) = self%psi(i, k)*h(2)
         end do
         do i = a + 1, n
            self%hx(i, k) = -whirl**2*self%gx(i, k) - swing*self%gy(i, k)
            self%hy(i, k) = -whirl**2*self%gy(i, k) + swing*self%gx(i, k)
         end do
      end do
      call self%accelerations(heavy, omega, alpha, eta_acceleration, force)
      do k = 1, self%points
         force(:, k) = self%mass(k)*force(:, k)
      end do
      call integrate(self%panel, self%within, self%base, self%shifted, self%reach, n, self%hx, self%ax)
      call integrate(self%panel, self%within, self%base, self%shifted, self%reach, n, self%hy, self%ay)
      call add_columns(self, u, stiffness(:, 2:))
      do k = 1, self%points
         do i = 1, n
            stiffness(3, 1 + i) = stiffness(3, 1 + i) + self%dx(i, k)*force(2, k) - self%dy(i, k)*force(1, k)
         end do
         part = turn(force(:, k) - self%mass(k)*heavy)
         stiffness(1:2, 1) = stiffness(1:2, 1) + along(part, u)
         stiffness(3, 1) = stiffness(3, 1) - self%mass(k)*dot_product(self%p(:, k), heavy)
         part = -self%mass(k)*turn(heavy)
         do i = 1, n
            stiffness(3 + i, 1) = stiffness(3 + i, 1) + self%dx(i, k)*part(1) + self%dy(i, k)*part(2)
         end do
      end do
      call gather(self, force, pull)
      call self%add_curvature(pull, stiffness(4:, 2:))
      call rate_columns(self, u, omega, damping)
   end subroutine tangent

   !> Adds to the rows of frame and coordinates what changed accelerations `ax`, `ay` of the points make.
   pure subroutine add_columns(self, u, block)
      class(centreline_type), intent(in) :: self
      real(wp), intent(in) :: u(2)
      !> (3 + n, n)
      real(wp), intent(inout) :: block(:, :)
      real(wp) :: x, y, push(2)
      integer :: i, j, k
      do j = 1, self%n
         push = 0.0_wp
         do k = 1, self%points
            x = self%mass(k)*self%ax(j, k)
            y = self%mass(k)*self%ay(j, k)
            push = push + [x, y]
            block(3, j) = block(3, j) + self%p(1, k)*y - self%p(2, k)*x
            do i = 1, self%n
               block(3 + i, j) = block(3 + i, j) + self%dx(i, k)*x + self%dy(i, k)*y
            end do
         end do
         block(1:2, j) = block(1:2, j) + along(push, u)
      end do
   end subroutine add_columns

   !> The columns of omega and eta'.
   pure subroutine rate_columns(self, u, omega, damping)
      class(centreline_type), intent(inout) :: self
      real(wp), intent(in) :: u(2), omega
      real(wp), intent(inout) :: damping(:, :)
      real(wp) :: part(2)
      integer :: i, k
      do k = 1, self%stations
         part = 2*(turn(self%drift(:, k)) - omega*self%g(:, k))
         do i = 1, self%angles
            self%hx(i, k) = self%psi(i, k)*part(1)
            self%hy(i, k) = self%psi(i, k)*part(2)
         end do
         do i = self%angles + 1, self%n
            self%hx(i, k) = -2*(omega + self%turning(k))*self%gy(i, k)
            self%hy(i, k) = 2*(omega + self%turning(k))*self%gx(i, k)
         end do
      end do
      call integrate(self%panel, self%within, self%base, self%shifted, self%reach, self%n, self%hx, self%ax)
      call integrate(self%panel, self%within, self%base, self%shifted, self%reach, self%n, self%hy, self%ay)
      call add_columns(self, u, damping(:, 2:))
      do k = 1, self%points
         part = 2*self%mass(k)*(turn(self%speed(:, k)) - omega*self%p(:, k))
         damping(1:2, 1) = damping(1:2, 1) + along(part, u)
         damping(3, 1) = damping(3, 1) + cross(self%p(:, k), part)
         do i = 1, self%n
            damping(3 + i, 1) = damping(3 + i, 1) + self%dx(i, k)*part(1) + self%dy(i, k)*part(2)
         end do
      end do
   end subroutine rate_columns

   !> Adds the second derivatives by the coordinates of the sum of pull . g over the stations, eq. (X9).
   pure subroutine add_curvature(self, pull, k)
      class(centreline_type), intent(in) :: self
      !> In the axes of the frame (2, stations)
      real(wp), intent(in) :: pull(:, :)
      !> (n, n)
      real(wp), intent(inout) :: k(:, :)
      real(wp) :: bend, slide
      integer :: i, j, s
      do s = 1, self%stations
         bend = dot_product(pull(:, s), self%g(:, s))
         do j = 1, self%angles
            do i = 1, self%angles
               k(i, j) = k(i, j) - bend*self%psi(i, s)*self%psi(j, s)
            end do
         end do
         do j = self%angles + 1, self%n
            slide = self%gx(j, s)*pull(2, s) - self%gy(j, s)*pull(1, s)
            do i = 1, self%angles
               k(i, j) = k(i, j) + slide*self%psi(i, s)
               k(j, i) = k(j, i) + slide*self%psi(i, s)
            end do
         end do
      end do
   end subroutine add_curvature

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
            rate = rate + reach(k)*self%psi(j, k)*turn(self%drift(:, k))
         end do
      else
         do k = 1, self%stations
            rate = rate + reach(k)*self%turning(k)*[-self%gy(j, k), self%gx(j, k)]
         end do
      end if
   end function drift_of

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
         speed = dot_product(exact%psi(:, k), eta(:a))
         axis = [cos(speed), sin(speed)]
         g = along([1.0_wp, 0.0_wp] + matmul(exact%chi(:, :, k), eta(a + 1:)), axis)
         p = p + reach(k)*g
         if (.not. present(rate)) cycle
         speed = dot_product(exact%psi(:, k), rate(:a))
         strain = along(matmul(exact%chi(:, :, k), rate(a + 1:)), axis)
         drift = drift + reach(k)*(speed*turn(g) + strain)
         if (.not. present(acceleration)) cycle
         swing = dot_product(exact%psi(:, k), acceleration(:a))
         push = push + reach(k)*(swing*turn(g) + 2*speed*turn(strain) - speed**2*g &
            & + along(matmul(exact%chi(:, :, k), acceleration(a + 1:)), axis))
      end do
   end subroutine follow_place

   !> Accelerations of the points, less that of gravity, in the axes of the frame (2, points); placed and moved.
   pure subroutine accelerations(self, heavy, omega, alpha, eta_acceleration, push)
      class(centreline_type), intent(in) :: self
      !> Acceleration of the frame's origin less that of gravity, in the axes of the frame (2), angular velocity and acceleration,
      !> second derivatives of the coordinates (n)
      real(wp), intent(in) :: heavy(2), omega, alpha, eta_acceleration(:)
      real(wp), intent(inout) :: push(:, :)
      real(wp) :: field(2, self%stations)
      integer :: k
      do k = 1, self%stations
         field(1, k) = dot_product(self%gx(:, k), eta_acceleration)
         field(2, k) = dot_product(self%gy(:, k), eta_acceleration)
         field(:, k) = field(:, k) + self%bias(:, k)
      end do
      call integrate(self%panel, self%within, self%base, self%shifted, self%reach, 2, field, push)
      do k = 1, self%points
         push(:, k) = push(:, k) + heavy + alpha*turn(self%p(:, k)) - omega**2*self%p(:, k) + 2*omega*turn(self%speed(:, k))
      end do
   end subroutine accelerations

   !> First moment of mass in the axes of the frame (2).
   pure function moment(self) result(c)
      class(centreline_type), intent(in) :: self
      real(wp) :: c(2)
      integer :: k
      c = 0.0_wp
      do k = 1, self%points
         c = c + self%mass(k)*self%p(:, k)
      end do
   end function moment

   !> Kinetic energy; placed and moved.
   pure real(wp) function kinetic(self, velocity, omega, rate) result(energy)
      class(centreline_type), intent(in) :: self
      !> Velocity of the frame's origin in its axes (2), angular velocity, rates of the coordinates (n)
      real(wp), intent(in) :: velocity(2), omega, rate(:)
      real(wp) :: v(2)
      integer :: k
      energy = 0.5_wp*sum(self%inertia)*omega**2
      do k = 1, self%points
         v = velocity + omega*turn(self%p(:, k)) + self%speed(:, k)
         energy = energy + 0.5_wp*self%mass(k)*(v(1)**2 + v(2)**2)
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
         v = self%mass(k)*(velocity + omega*turn(self%p(:, k)) + self%speed(:, k))
         p(1:2) = p(1:2) + v
         p(3) = p(3) + cross(self%p(:, k), v)
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
      call snapshot%keep('axis', self%axis)
      call snapshot%keep('p', self%p)
      call snapshot%keep('dx', self%dx)
      call snapshot%keep('dy', self%dy)
      call snapshot%keep('turning', self%turning)
      call snapshot%keep('drift', self%drift)
      call snapshot%keep('straining', self%straining)
      call snapshot%keep('bias', self%bias)
      call snapshot%keep('speed', self%speed)
      call snapshot%keep('swerve', self%swerve)
   end subroutine exchange_centreline

end module limber_system_centreline
