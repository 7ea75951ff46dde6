!> Residual of the equations of motion of an exact beam. Inertia forces of given accelerations and weight, without a mass matrix, so
!> that it costs as much as the accelerations of the points and the pulls that they make on the stations. Floor: multibody. Source:
!> doc/theory, part 2, eqs. (2.31), (2.36), (2.38)-(2.40).
module limber_multibody_beam_residual
   use limber_base_kinds, only: wp
   use limber_multibody_plane_vectors, only: along
   use limber_multibody_beam_axis, only: centreline_type, integrate, gather, inner, inner_pair
   implicit none
   private
   public :: add_beam_residual

contains

   !> Adds M a + velocity terms - weight; the stations are placed and moved.
   pure subroutine add_beam_residual(line, gravity, u, omega, a, motion)
      class(centreline_type), intent(inout) :: line
      !> Acceleration of gravity (2), unit vector of the frame (2), its angular velocity
      real(wp), intent(in) :: gravity(2), u(2), omega
      !> Accelerations r'', alpha, eta'' (3 + n)
      real(wp), contiguous, intent(in) :: a(:)
      !> Equations of the same (3 + n)
      real(wp), contiguous, intent(inout) :: motion(:)
      real(wp) :: heavy(2)
      integer :: i
      heavy = along(a(1:2) - gravity, [u(1), -u(2)])
      call station_accelerations(line%stations, line%angles, line%n, line%angle, line%gx, line%gy, line%g, line%straining, &
         & line%turning, omega, a(3), a(4:), line%field, line%pull)
      call integrate(line, 2, line%pull, line%force)
      associate (fx => line%force(:, 1), fy => line%force(:, 2))
         fx = line%mass*(fx + heavy(1))
         fy = line%mass*(fy + heavy(2))
         motion(1:2) = motion(1:2) + along([sum(fx), sum(fy)], u)
      end associate
      call gather(line, line%force, line%pull)
      associate (m => line%stations, moment => line%field(:line%stations, 1), pull => line%pull)
         ! Pulls turn the stations, eq. (2.40)
         moment = line%g(:, 1)*pull(:, 2) - line%g(:, 2)*pull(:, 1)
         motion(3) = motion(3) + sum(moment)
         do i = 1, line%angles
            motion(3 + i) = motion(3 + i) + inner(m, line%angle(:, i), moment)
         end do
         do i = line%angles + 1, line%n
            motion(3 + i) = motion(3 + i) + inner_pair(m, line%gx(:, i), pull(:, 1), line%gy(:, i), pull(:, 2))
         end do
      end associate
      if (.not. line%spinning) return
      motion(3) = motion(3) + sum(line%inertia)*a(3) + dot_product(line%rotary, a(4:3 + line%angles))
      do i = 1, line%angles
         motion(3 + i) = motion(3 + i) + line%rotary(i)*a(3) + dot_product(line%rotary_mass(:, i), a(4:3 + line%angles))
      end do
   end subroutine add_beam_residual

   !> Accelerations of g in the axes of the frame, eq. (2.39).
   pure subroutine station_accelerations(m, angles, n, angle, gx, gy, g, straining, turning, omega, alpha, a, field, push)
      !> Numbers of stations, of functions of the angle, of all functions
      integer, intent(in) :: m, angles, n
      real(wp), intent(in) :: angle(m, angles), gx(m, n), gy(m, n), g(m, 2), straining(m, 2), turning(m)
      real(wp), intent(in) :: omega, alpha, a(n)
      !> Scratch
      real(wp), intent(inout) :: field(m, 2)
      real(wp), intent(inout) :: push(m, 2)
      integer :: i, k
      field(:, 1) = alpha
      do i = 1, angles
         field(:, 1) = field(:, 1) + angle(:, i)*a(i)
      end do
      field(:, 2) = omega + turning
      do k = 1, m
         push(k, 1) = -field(k, 1)*g(k, 2) - field(k, 2)*(field(k, 2)*g(k, 1) + 2*straining(k, 2))
         push(k, 2) = field(k, 1)*g(k, 1) - field(k, 2)*(field(k, 2)*g(k, 2) - 2*straining(k, 1))
      end do
      do i = angles + 1, n
         push(:, 1) = push(:, 1) + gx(:, i)*a(i)
         push(:, 2) = push(:, 2) + gy(:, i)*a(i)
      end do
   end subroutine station_accelerations

end module limber_multibody_beam_residual
