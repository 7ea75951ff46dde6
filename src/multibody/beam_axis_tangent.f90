!> Derivatives of the inertia forces of an exact beam. No allocation. Floor: multibody. Source: doc/theory, part 2, eqs.
!> (2.43)-(2.45).
module limber_multibody_beam_axis_tangent
   use limber_base_kinds, only: wp
   use limber_multibody_plane_vectors, only: along
   use limber_multibody_beam_axis, only: centreline_type, integrate, gather, inner, inner_pair
   implicit none
   private
   public :: add_centreline_tangent, add_columns

contains

   !> Derivatives of the inertia forces and the weight, M a + velocity terms - weight, with respect to (rotation, eta) and to
   !> (omega, eta'), both without the row and column of r, eqs. (2.43)-(2.45).
   pure subroutine add_centreline_tangent(self, gravity, u, omega, acceleration, alpha, eta_acceleration, stiffness, damping)
      type(centreline_type), intent(inout) :: self
      !> Acceleration of gravity (2), unit vector of the frame (2), its angular velocity, r'' (2), alpha, eta'' (n)
      real(wp), intent(in) :: gravity(2), u(2), omega, acceleration(2), alpha, eta_acceleration(:)
      !> Rows r'' (2), alpha, eta''; columns rotation, eta, and omega, eta': (3 + n, 1 + n). Added to
      real(wp), intent(inout) :: stiffness(:, :), damping(:, :)
      real(wp) :: heavy(2), x, y
      integer :: i, m
      m = self%points
      heavy = along(acceleration - gravity, [u(1), -u(2)])
      call self%spread_points()
      call self%accelerations(heavy, omega, alpha, eta_acceleration, self%pull, self%force)
      self%force(:, 1) = self%mass*self%force(:, 1)
      self%force(:, 2) = self%mass*self%force(:, 2)
      call change_accelerations(self, omega, alpha, eta_acceleration)
      call integrate(self, self%n, self%hx, self%ax)
      call integrate(self, self%n, self%hy, self%ay)
      call add_columns(self, u, stiffness(:, 2:))
      x = sum(self%mass)*heavy(1)
      y = sum(self%mass)*heavy(2)
      stiffness(1:2, 1) = stiffness(1:2, 1) + along([y - sum(self%force(:, 2)), sum(self%force(:, 1)) - x], u)
      stiffness(3, 1) = stiffness(3, 1) - inner(m, self%mass, self%p(:, 1))*heavy(1) - inner(m, self%mass, self%p(:, 2))*heavy(2)
      do i = 1, self%n
         stiffness(3, 1 + i) = stiffness(3, 1 + i) + inner(m, self%dx(:, i), self%force(:, 2)) &
            & - inner(m, self%dy(:, i), self%force(:, 1))
         stiffness(3 + i, 1) = stiffness(3 + i, 1) + inner(m, self%mass, self%dx(:, i))*heavy(2) &
            & - inner(m, self%mass, self%dy(:, i))*heavy(1)
      end do
      call gather(self, self%force, self%pull)
      call self%add_curvature(self%pull, stiffness(4:, 2:))
      call rate_columns(self, u, omega, damping)
   end subroutine add_centreline_tangent

   !> What a change of the coordinates makes of the accelerations of g, into the scratch.
   pure subroutine change_accelerations(self, omega, alpha, eta_acceleration)
      type(centreline_type), intent(inout) :: self
      real(wp), intent(in) :: omega, alpha, eta_acceleration(:)
      integer :: i, m
      m = self%stations
      associate (swing => self%field(:m, 1), whirl => self%field(:m, 2), x => self%field(:m, 3), y => self%field(:m, 4), &
         & bend => self%field(:m, 5))
         swing = alpha
         do i = 1, self%angles
            swing = swing + self%angle(:, i)*eta_acceleration(i)
         end do
         x = 0.0_wp
         y = 0.0_wp
         do i = self%angles + 1, self%n
            x = x + self%gx(:, i)*eta_acceleration(i)
            y = y + self%gy(:, i)*eta_acceleration(i)
         end do
         whirl = omega + self%turning
         do i = self%angles + 1, self%n
            self%hx(:, i) = -whirl**2*self%gx(:, i) - swing*self%gy(:, i)
            self%hy(:, i) = -whirl**2*self%gy(:, i) + swing*self%gx(:, i)
         end do
         bend = x
         x = -swing*self%g(:, 1) + whirl*(whirl*self%g(:, 2) - 2*self%straining(:, 1)) - y
         y = -swing*self%g(:, 2) - whirl*(whirl*self%g(:, 1) + 2*self%straining(:, 2)) + bend
         do i = 1, self%angles
            self%hx(:, i) = self%angle(:, i)*x
            self%hy(:, i) = self%angle(:, i)*y
         end do
      end associate
   end subroutine change_accelerations

   !> Adds to the rows of frame and coordinates what changed accelerations `ax`, `ay` of the points make.
   pure subroutine add_columns(self, u, block)
      type(centreline_type), intent(inout) :: self
      real(wp), intent(in) :: u(2)
      !> (3 + n, n)
      real(wp), intent(inout) :: block(:, :)
      integer :: i, j
      associate (x => self%field(:, 5), y => self%field(:, 6))
         do j = 1, self%n
            x = self%mass*self%ax(:, j)
            y = self%mass*self%ay(:, j)
            block(1:2, j) = block(1:2, j) + along([sum(x), sum(y)], u)
            block(3, j) = block(3, j) + inner(self%points, self%p(:, 1), y) - inner(self%points, self%p(:, 2), x)
            do i = 1, self%n
               block(3 + i, j) = block(3 + i, j) + inner_pair(self%points, self%dx(:, i), x, self%dy(:, i), y)
            end do
         end do
      end associate
   end subroutine add_columns

   !> The columns of omega and eta'.
   pure subroutine rate_columns(self, u, omega, damping)
      type(centreline_type), intent(inout) :: self
      real(wp), intent(in) :: u(2), omega
      real(wp), intent(inout) :: damping(:, :)
      integer :: i
      associate (x => self%force(:, 1), y => self%force(:, 2))
         self%pull(:, 1) = -2*(self%drift(:, 2) + omega*self%g(:, 1))
         self%pull(:, 2) = 2*(self%drift(:, 1) - omega*self%g(:, 2))
         do i = 1, self%angles
            self%hx(:, i) = self%angle(:, i)*self%pull(:, 1)
            self%hy(:, i) = self%angle(:, i)*self%pull(:, 2)
         end do
         do i = self%angles + 1, self%n
            self%hx(:, i) = -2*(omega + self%turning)*self%gy(:, i)
            self%hy(:, i) = 2*(omega + self%turning)*self%gx(:, i)
         end do
         call integrate(self, self%n, self%hx, self%ax)
         call integrate(self, self%n, self%hy, self%ay)
         call add_columns(self, u, damping(:, 2:))
         call integrate(self, 2, self%pull, self%force)
         x = self%mass*x
         y = self%mass*y
         damping(1:2, 1) = damping(1:2, 1) + along([sum(x), sum(y)], u)
         damping(3, 1) = damping(3, 1) + inner(self%points, self%p(:, 1), y) - inner(self%points, self%p(:, 2), x)
         do i = 1, self%n
            damping(3 + i, 1) = damping(3 + i, 1) + inner_pair(self%points, self%dx(:, i), x, self%dy(:, i), y)
         end do
      end associate
   end subroutine rate_columns

end module limber_multibody_beam_axis_tangent
