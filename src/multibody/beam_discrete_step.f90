!> Energy-momentum step of an exact beam. The derivatives of the axis that make its change exactly, momenta, and what the change of
!> the inertia adds to them. Stations and points as in the centrelines of both ends; the centreline of the mean has the derivatives
!> of the step in the place of those of a state. No allocation but in `new_exact_step`. Floor: multibody. Source: doc/theory, part
!> 2, eqs. (2.57)-(2.60).
module limber_multibody_beam_discrete_step
   use limber_base_kinds, only: wp
   use limber_multibody_beam_axis, only: centreline_type, integrate, gather, inner, inner_pair
   use limber_multibody_beam_axis_tangent, only: add_columns
   implicit none
   private
   public :: exact_step_type, new_exact_step, place_mean, mean_turn, exact_momentum, exact_pull, exact_momentum_tangent, &
      & exact_pull_tangent, exact_weight_tangent

   !> Half of an angle below which its sine over itself is a series [rad]
   real(wp), parameter :: small = 1.0e-2_wp

   !> What a step makes of one beam. The last index of the fields is the end whose rates are meant: 1 its start, 2 its end
   type :: exact_step_type
      !> R of the mean angle, times the sine of half the change of the angle over this half (stations, 2): cosines, sines
      real(wp), allocatable :: swing(:, :)
      !> Angular velocities of the sections (stations, 2); rates of the strain in fixed axes (stations, 2, 2)
      real(wp), allocatable :: spin(:, :), straining(:, :, :)
      !> Momenta of the points (points, 2, 2), what they pull the stations by (stations, 2, 2)
      real(wp), allocatable :: push(:, :, :), pull(:, :, :)
      !> Changes of the velocities of stations and points with the coordinates (stations, n), (points, n, 2)
      real(wp), allocatable :: hx(:, :), hy(:, :), x(:, :, :), y(:, :, :)
      !> Scratch (stations, 2)
      real(wp), allocatable :: field(:, :)
   end type exact_step_type

contains

   !> Room.
   pure subroutine new_exact_step(line, own)
      type(centreline_type), intent(in) :: line
      type(exact_step_type), intent(out) :: own
      associate (n => line%n, k => line%stations, m => line%points)
         allocate (own%swing(k, 2), own%spin(k, 2), own%straining(k, 2, 2), own%push(m, 2, 2), own%pull(k, 2, 2), own%hx(k, n), &
            & own%hy(k, n), own%x(m, n, 2), own%y(m, n, 2), own%field(k, 2))
      end associate
   end subroutine new_exact_step

   !> Derivatives by the coordinates whose products with the increments are the changes of g, eq. (2.57), and the mean rates.
   pure subroutine place_mean(own, line, eta, change, h)
      type(exact_step_type), intent(inout) :: own
      !> Of the mean
      type(centreline_type), intent(inout) :: line
      !> Mean of the coordinates (n), their increments (n), length of the step
      real(wp), intent(in) :: eta(:), change(:), h
      real(wp) :: angle, half, c, s, sigma(2), rate(size(change))
      integer :: i, k, a
      a = line%angles
      do k = 1, line%stations
         angle = line%lean(k)
         half = 0.0_wp
         do i = 1, a
            angle = angle + line%angle(k, i)*eta(i)
            half = half + 0.5_wp*line%angle(k, i)*change(i)
         end do
         sigma = [1.0_wp, 0.0_wp]
         do i = 1, line%strains
            sigma = sigma + line%stretch(k, :, i)*eta(a + i)
         end do
         own%swing(k, :) = mean_turn(angle, half)
         line%g(k, 1) = own%swing(k, 1)*sigma(1) - own%swing(k, 2)*sigma(2)
         line%g(k, 2) = own%swing(k, 2)*sigma(1) + own%swing(k, 1)*sigma(2)
         do i = 1, a
            line%gx(k, i) = -line%g(k, 2)*line%angle(k, i)
            line%gy(k, i) = line%g(k, 1)*line%angle(k, i)
         end do
         c = cos(half)*cos(angle)
         s = cos(half)*sin(angle)
         do i = 1, line%strains
            line%gx(k, a + i) = c*line%stretch(k, 1, i) - s*line%stretch(k, 2, i)
            line%gy(k, a + i) = s*line%stretch(k, 1, i) + c*line%stretch(k, 2, i)
         end do
      end do
      line%placed = .false.
      line%spread = .false.
      rate = change/h
      call line%move_stations(rate)
      call line%spread_points()
   end subroutine place_mean

   !> Derivative by an angle of its direction over a step, less J: cosine and sine of the mean angle, times the sine of half the
   !> change over this half.
   pure function mean_turn(angle, half) result(axis)
      !> Mean of the angle, half of its change
      real(wp), intent(in) :: angle, half
      real(wp) :: axis(2), share, square
      if (abs(half) < small) then
         square = half**2
         share = 1 - square*(1 - square*(1 - square/42)/20)/6
      else
         share = sin(half)/half
      end if
      axis = share*[cos(angle), sin(angle)]
   end function mean_turn

   !> Momenta of rates, both in the axes of the frame.
   pure subroutine exact_momentum(line, rates, p)
      !> Placed; moved here
      type(centreline_type), intent(inout) :: line
      !> (3 + n), (3 + n)
      real(wp), intent(in) :: rates(:)
      real(wp), intent(inout) :: p(:)
      real(wp) :: eta_rates(size(rates) - 3)
      integer :: i
      eta_rates = rates(4:)
      call line%spread_points()
      call line%move(eta_rates)
      associate (x => line%force(:, 1), y => line%force(:, 2))
         x = line%mass*(rates(1) - rates(3)*line%p(:, 2) + line%speed(:, 1))
         y = line%mass*(rates(2) + rates(3)*line%p(:, 1) + line%speed(:, 2))
         p(1:2) = [sum(x), sum(y)]
         p(3) = sum(line%inertia)*rates(3) + inner(line%points, line%p(:, 1), y) - inner(line%points, line%p(:, 2), x)
         do i = 1, line%n
            p(3 + i) = inner_pair(line%points, line%dx(:, i), x, line%dy(:, i), y)
         end do
      end associate
      if (.not. line%spinning) return
      do i = 1, line%angles
         p(3) = p(3) + line%rotary(i)*eta_rates(i)
         p(3 + i) = p(3 + i) + line%rotary(i)*rates(3) + dot_product(line%rotary_mass(:, i), eta_rates(:line%angles))
      end do
   end subroutine exact_momentum

   !> b0.(Delta M) b1/2 as a discrete gradient, eq. (2.59): what the growth of the inertia with the coordinates adds to their
   !> momenta. Leaves in `own` what its derivatives need.
   pure subroutine exact_pull(own, before, after, mean, b0, b1, pull)
      type(exact_step_type), intent(inout) :: own
      !> At both ends, and of the mean
      type(centreline_type), intent(in) :: before, after, mean
      !> Rates in the axes of the frame at both ends (3 + n)
      real(wp), intent(in) :: b0(:), b1(:)
      !> (n)
      real(wp), intent(inout) :: pull(:)
      integer :: i
      call momenta_between(own, before, after, mean, b0, 1)
      call momenta_between(own, before, after, mean, b1, 2)
      call swerve(own, mean, 1, 2)
      do i = 1, mean%angles
         pull(i) = inner(mean%stations, mean%angle(:, i), own%field(:, 1))
      end do
      call swerve(own, mean, 2, 1)
      do i = 1, mean%angles
         pull(i) = 0.5_wp*(pull(i) + inner(mean%stations, mean%angle(:, i), own%field(:, 1)))
      end do
      associate (x => own%field(:, 1), y => own%field(:, 2))
         x = 0.5_wp*(own%spin(:, 1)*own%pull(:, 2, 2) + own%spin(:, 2)*own%pull(:, 2, 1))
         y = -0.5_wp*(own%spin(:, 1)*own%pull(:, 1, 2) + own%spin(:, 2)*own%pull(:, 1, 1))
         do i = mean%angles + 1, mean%n
            pull(i) = inner_pair(mean%stations, x, mean%gx(:, i), y, mean%gy(:, i))
         end do
      end associate
   end subroutine exact_pull

   !> Momenta of the points by the rates of one end, the mean of those at both places, and what they pull the stations by; angular
   !> velocities of the stations and rates of their strain.
   pure subroutine momenta_between(own, before, after, mean, b, end)
      type(exact_step_type), intent(inout) :: own
      type(centreline_type), intent(in) :: before, after, mean
      !> (3 + n)
      real(wp), intent(in) :: b(:)
      integer, intent(in) :: end
      integer :: i, a
      a = mean%angles
      associate (turning => own%spin(:, end), x => own%field(:, 1), y => own%field(:, 2), sx => own%straining(:, 1, end), &
         & sy => own%straining(:, 2, end))
         turning = 0.0_wp
         do i = 1, a
            turning = turning + mean%angle(:, i)*b(3 + i)
         end do
         x = -0.5_wp*turning*(before%g(:, 2) + after%g(:, 2))
         y = 0.5_wp*turning*(before%g(:, 1) + after%g(:, 1))
         sx = 0.0_wp
         sy = 0.0_wp
         do i = 1, mean%strains
            x = x + (0.5_wp*b(3 + a + i))*(before%gx(:, a + i) + after%gx(:, a + i))
            y = y + (0.5_wp*b(3 + a + i))*(before%gy(:, a + i) + after%gy(:, a + i))
            sx = sx + b(3 + a + i)*(own%swing(:, 1)*mean%stretch(:, 1, i) - own%swing(:, 2)*mean%stretch(:, 2, i))
            sy = sy + b(3 + a + i)*(own%swing(:, 2)*mean%stretch(:, 1, i) + own%swing(:, 1)*mean%stretch(:, 2, i))
         end do
         turning = turning + b(3)
      end associate
      associate (x => own%push(:, 1, end), y => own%push(:, 2, end))
         call integrate(mean, 2, own%field, own%push(:, :, end))
         x = mean%mass*(x + b(1) - 0.5_wp*b(3)*(before%p(:, 2) + after%p(:, 2)))
         y = mean%mass*(y + b(2) + 0.5_wp*b(3)*(before%p(:, 1) + after%p(:, 1)))
      end associate
      call gather(mean, own%push(:, :, end), own%pull(:, :, end))
   end subroutine momenta_between

   !> Into the scratch: what a unit of an angle, with the rates of one end, adds to velocities of g, times the pull of the other.
   pure subroutine swerve(own, mean, rates, other)
      type(exact_step_type), intent(inout) :: own
      type(centreline_type), intent(in) :: mean
      !> Ends of the rates and of the pull
      integer, intent(in) :: rates, other
      own%field(:, 1) = own%pull(:, 2, other)*(own%straining(:, 1, rates) - own%spin(:, rates)*mean%g(:, 2)) &
         & - own%pull(:, 1, other)*(own%straining(:, 2, rates) + own%spin(:, rates)*mean%g(:, 1))
   end subroutine swerve

   !> Derivative of the momenta at the end of a step by its increments y = [dr; alpha; deta].
   pure subroutine exact_momentum_tangent(line, w, frame, coupling, eta_mass, slope, h, tangent)
      !> At the end, placed and moved
      type(centreline_type), intent(inout) :: line
      !> Rates at the end (3 + n)
      real(wp), intent(in) :: w(:)
      !> Mass matrix there, in the axes of the frame
      real(wp), intent(in) :: frame(3, 3), coupling(:, :), eta_mass(:, :)
      !> Derivative of the velocity in the axes of the frame by dr and alpha (2,3); length of the step
      real(wp), intent(in) :: slope(2, 3), h
      !> (3 + n, 3 + n)
      real(wp), intent(inout) :: tangent(:, :)
      integer :: j, k, n
      n = line%n
      do j = 1, 3
         tangent(1:3, j) = matmul(frame(:, 1:2), slope(:, j))
         tangent(4:, j) = matmul(coupling(:, 1:2), slope(:, j))
      end do
      tangent(1:3, 3) = tangent(1:3, 3) + frame(:, 3)*(2/h)
      tangent(4:, 3) = tangent(4:, 3) + coupling(:, 3)*(2/h)
      do k = 1, n
         tangent(1:3, 3 + k) = coupling(k, :)*(2/h)
      end do
      tangent(4:, 4:) = eta_mass*(2/h)
      ! Momenta of the points
      associate (x => line%force(:, 1), y => line%force(:, 2), whirl => line%field(:line%stations, 1))
         x = line%mass*(w(1) - w(3)*line%p(:, 2) + line%speed(:, 1))
         y = line%mass*(w(2) + w(3)*line%p(:, 1) + line%speed(:, 2))
         whirl = w(3) + line%turning
         do k = 1, line%angles
            line%hx(:, k) = -line%angle(:, k)*(whirl*line%g(:, 1) + line%straining(:, 2))
            line%hy(:, k) = -line%angle(:, k)*(whirl*line%g(:, 2) - line%straining(:, 1))
         end do
         do k = line%angles + 1, n
            line%hx(:, k) = -whirl*line%gy(:, k)
            line%hy(:, k) = whirl*line%gx(:, k)
         end do
         call integrate(line, n, line%hx, line%ax)
         call integrate(line, n, line%hy, line%ay)
         do k = 1, n
            tangent(3, 3 + k) = tangent(3, 3 + k) + inner(line%points, line%dx(:, k), y) - inner(line%points, line%dy(:, k), x)
         end do
      end associate
      call add_columns(line, [1.0_wp, 0.0_wp], tangent(:, 4:))
      call gather(line, line%force, line%pull)
      call line%add_curvature(line%pull, tangent(4:, 4:))
   end subroutine exact_momentum_tangent

   !> Takes the derivative of `exact_pull` by the increments from a matrix: exact by the rates; by the coordinates with the second
   !> derivatives of the mean.
   pure subroutine exact_pull_tangent(own, before, after, mean, slope, h, tangent)
      !> As `exact_pull` leaves it
      type(exact_step_type), intent(inout) :: own
      type(centreline_type), intent(in) :: before, after, mean
      !> As above
      real(wp), intent(in) :: slope(2, 3), h
      !> (3 + n, 3 + n); rows of the coordinates
      real(wp), intent(inout) :: tangent(:, :)
      real(wp) :: drift(2), swing
      integer :: j, k, m
      m = mean%points
      call changes(own, mean, 1)
      call changes(own, mean, 2)
      do k = 1, mean%n
         associate (x => own%x(:, k, 1), y => own%y(:, k, 1))
            drift = 0.5_wp*[inner(m, mean%mass, x), inner(m, mean%mass, y)]
            swing = 0.25_wp*sum(mean%mass*((before%p(:, 1) + after%p(:, 1))*y - (before%p(:, 2) + after%p(:, 2))*x)) &
               & + 0.5_wp*sum(mean%dx(:, k)*own%push(:, 2, 1) - mean%dy(:, k)*own%push(:, 1, 1))
         end associate
         do j = 1, 3
            tangent(3 + k, j) = tangent(3 + k, j) - dot_product(drift, slope(:, j))
         end do
         tangent(3 + k, 3) = tangent(3 + k, 3) - swing*(2/h)
         do j = 1, mean%n
            tangent(3 + k, 3 + j) = tangent(3 + k, 3 + j) - sum(mean%mass*( &
               & own%x(:, k, 1)*((0.5_wp/h)*(before%dx(:, j) + after%dx(:, j)) + 0.25_wp*own%x(:, j, 2)) &
               & + own%y(:, k, 1)*((0.5_wp/h)*(before%dy(:, j) + after%dy(:, j)) + 0.25_wp*own%y(:, j, 2)) &
               & + 0.25_wp*(own%x(:, j, 1)*own%x(:, k, 2) + own%y(:, j, 1)*own%y(:, k, 2))))
         end do
      end do
      own%field(:, 1) = 0.25_wp*(own%spin(:, 1)*own%pull(:, 2, 2) + own%spin(:, 2)*own%pull(:, 2, 1))
      own%field(:, 2) = -0.25_wp*(own%spin(:, 1)*own%pull(:, 1, 2) + own%spin(:, 2)*own%pull(:, 1, 1))
      own%field = -own%field - own%pull(:, :, 1)/h
      call mean%add_curvature(own%field, tangent(4:, 4:))
      own%field(:, 1) = 0.25_wp*(own%pull(:, 1, 2)*own%straining(:, 1, 1) + own%pull(:, 2, 2)*own%straining(:, 2, 1) &
         & + own%pull(:, 1, 1)*own%straining(:, 1, 2) + own%pull(:, 2, 1)*own%straining(:, 2, 2))
      do k = 1, mean%angles
         do j = 1, mean%angles
            tangent(3 + k, 3 + j) = tangent(3 + k, 3 + j) + sum(own%field(:, 1)*mean%angle(:, k)*mean%angle(:, j))
         end do
      end do
   end subroutine exact_pull_tangent

   !> What a unit of each coordinate changes of the velocities of the points, with the rates of one end.
   pure subroutine changes(own, mean, end)
      type(exact_step_type), intent(inout) :: own
      type(centreline_type), intent(in) :: mean
      integer, intent(in) :: end
      integer :: k
      associate (whirl => own%spin(:, end), s => own%straining(:, :, end))
         do k = 1, mean%angles
            own%hx(:, k) = -mean%angle(:, k)*(whirl*mean%g(:, 1) + s(:, 2))
            own%hy(:, k) = -mean%angle(:, k)*(whirl*mean%g(:, 2) - s(:, 1))
         end do
         do k = mean%angles + 1, mean%n
            own%hx(:, k) = -whirl*mean%gy(:, k)
            own%hy(:, k) = whirl*mean%gx(:, k)
         end do
      end associate
      call integrate(mean, mean%n, own%hx, own%x(:, :, end))
      call integrate(mean, mean%n, own%hy, own%y(:, :, end))
   end subroutine changes

   !> Adds the second derivatives of minus the potential of the weight by the coordinates, less a factor, to a stiffness.
   pure subroutine exact_weight_tangent(own, mean, weight, stiffness)
      type(exact_step_type), intent(inout) :: own
      type(centreline_type), intent(in) :: mean
      !> Acceleration of gravity in the axes of the frame (2)
      real(wp), intent(in) :: weight(2)
      !> (n, n)
      real(wp), intent(inout) :: stiffness(:, :)
      own%push(:, 1, 1) = -mean%mass*weight(1)
      own%push(:, 2, 1) = -mean%mass*weight(2)
      call gather(mean, own%push(:, :, 1), own%field)
      call mean%add_curvature(own%field, stiffness)
   end subroutine exact_weight_tangent

end module limber_multibody_beam_discrete_step
