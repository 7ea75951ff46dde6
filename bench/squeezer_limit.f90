!> Andrews' squeezing mechanism written by hand: how fast a general program could be at most. It knows nothing of limber.
!> Seven angles, the smallest set that keeps the loops as constraints; index 1, that is one dense system of 7 accelerations and
!> 6 multipliers for each right-hand side; an Adams predictor-corrector of variable order and step in divided differences.
!> Equations and data: Test Set for Initial Value Problem Solvers, "Andrews' squeezing mechanism".
!> Method: Shampine and Gordon, Computer Solution of Ordinary Differential Equations (1975).
!> Usage: squeezer_limit REFERENCE.csv TOLERANCE ...
!> It prints a line for each tolerance: tolerance, largest absolute error of an angle over the samples of the reference,
!> median and least CPU seconds of a run, steps, evaluations of the right-hand side.
module squeezer_equations
   implicit none
   private
   public :: right_hand_side
   integer, parameter, public :: wp = kind(1.0d0), angles = 7, states = 2*angles

   !> beta, Theta, gamma, Phi, delta, Omega, epsilon
   real(wp), parameter, public :: start_angles(angles) = [-0.0617138900142764496358948458001_wp, 0.0_wp, &
      & 0.455279819163070380255912382449_wp, 0.222668390165885884674473185609_wp, 0.487364979543842550225598953530_wp, &
      & -0.222668390165885884674473185609_wp, 1.23054744454982119249735015568_wp]

   integer, parameter :: loops = 6, unknowns = angles + loops
   !> Masses and moments of inertia of the bodies K1 to K7
   real(wp), parameter :: m(7) = [0.04325_wp, 0.00365_wp, 0.02373_wp, 0.00706_wp, 0.07050_wp, 0.00706_wp, 0.05498_wp]
   real(wp), parameter :: inertia(7) = [2.194e-6_wp, 4.410e-7_wp, 5.255e-6_wp, 5.667e-7_wp, 1.169e-5_wp, 5.667e-7_wp, 1.912e-5_wp]
   !> Point where the spring is fixed, its stiffness and free length; the torque
   real(wp), parameter :: xc = 0.014_wp, yc = 0.072_wp, c0 = 4530.0_wp, l0 = 0.07785_wp, torque = 0.033_wp
   real(wp), parameter :: xb = -0.03635_wp, yb = 0.03273_wp
   !> Lengths, as the Test Set names them
   real(wp), parameter :: d = 0.028_wp, da = 0.0115_wp, e = 0.02_wp, ea = 0.01421_wp, rr = 0.007_wp, ra = 0.00092_wp, &
      & ss = 0.035_wp, sa = 0.01874_wp, sb = 0.01043_wp, sc = 0.018_wp, sd = 0.02_wp, ta = 0.02308_wp, tb = 0.00916_wp, &
      & u = 0.04_wp, ua = 0.01228_wp, ub = 0.00449_wp, zf = 0.02_wp, zt = 0.04_wp, fa = 0.01421_wp
   real(wp), parameter :: e4 = e - ea, z6 = zf - fa

contains

   !> Rates of angles and angular velocities, y = (q, v).
   subroutine right_hand_side(y, rate)
      real(wp), intent(in) :: y(states)
      real(wp), intent(out) :: rate(states)
      real(wp) :: a(unknowns, unknowns), x(unknowns)
      call equations(y(:angles), y(angles + 1:), a, x)
      call solve(a, x)
      rate(:angles) = y(angles + 1:)
      rate(angles + 1:) = x(:angles)
   end subroutine right_hand_side

   !> The system (M G^T; G 0)(q'', -lambda) = (f; -dG/dt v).
   pure subroutine equations(q, v, a, x)
      real(wp), intent(in) :: q(angles), v(angles)
      real(wp), intent(out) :: a(unknowns, unknowns), x(unknowns)
      real(wp) :: s(angles), c(angles), s12, c12, s45, c45, s67, c67, xd, yd, length, pull, fx, fy, w12, w45, w67, ax, ay
      real(wp) :: g(loops, angles)
      s = sin(q)
      c = cos(q)
      ! Sums of the angles of bodies that ride on others
      s12 = s(1)*c(2) + c(1)*s(2)
      c12 = c(1)*c(2) - s(1)*s(2)
      s45 = s(4)*c(5) + c(4)*s(5)
      c45 = c(4)*c(5) - s(4)*s(5)
      s67 = s(6)*c(7) + c(6)*s(7)
      c67 = c(6)*c(7) - s(6)*s(7)

      a = 0.0_wp
      a(1, 1) = m(1)*ra**2 + m(2)*(rr**2 - 2*da*rr*c(2) + da**2) + inertia(1) + inertia(2)
      a(2, 1) = m(2)*(da**2 - da*rr*c(2)) + inertia(2)
      a(1, 2) = a(2, 1)
      a(2, 2) = m(2)*da**2 + inertia(2)
      a(3, 3) = m(3)*(sa**2 + sb**2) + inertia(3)
      a(4, 4) = m(4)*e4**2 + inertia(4)
      a(5, 4) = m(4)*(e4**2 + zt*e4*s(4)) + inertia(4)
      a(4, 5) = a(5, 4)
      a(5, 5) = m(4)*(zt**2 + 2*zt*e4*s(4) + e4**2) + m(5)*(ta**2 + tb**2) + inertia(4) + inertia(5)
      a(6, 6) = m(6)*z6**2 + inertia(6)
      a(7, 6) = m(6)*(z6**2 - u*z6*s(6)) + inertia(6)
      a(6, 7) = a(7, 6)
      a(7, 7) = m(6)*(z6**2 - 2*u*z6*s(6) + u**2) + m(7)*(ua**2 + ub**2) + inertia(6) + inertia(7)

      xd = sd*c(3) + sc*s(3) + xb
      yd = sd*s(3) - sc*c(3) + yb
      length = sqrt((xd - xc)**2 + (yd - yc)**2)
      pull = -c0*(length - l0)/length
      fx = pull*(xd - xc)
      fy = pull*(yd - yc)
      x(1) = torque - m(2)*da*rr*v(2)*(v(2) + 2*v(1))*s(2)
      x(2) = m(2)*da*rr*v(1)**2*s(2)
      x(3) = fx*(sc*c(3) - sd*s(3)) + fy*(sd*c(3) + sc*s(3))
      x(4) = m(4)*zt*e4*v(5)**2*c(4)
      x(5) = -m(4)*zt*e4*v(4)*(v(4) + 2*v(5))*c(4)
      x(6) = -m(6)*u*z6*v(7)**2*c(6)
      x(7) = m(6)*u*z6*v(6)*(v(6) + 2*v(7))*c(6)

      ! Each loop runs through K1 and K2, and returns by K3, by K4 and K5, by K6 and K7
      g = 0.0_wp
      g(1::2, 1) = -rr*s(1) + d*s12
      g(1::2, 2) = d*s12
      g(2::2, 1) = rr*c(1) - d*c12
      g(2::2, 2) = -d*c12
      g(1:2, 3) = -ss*[c(3), s(3)]
      g(3:4, 4) = -e*[c45, s45]
      g(3:4, 5) = [-e*c45 + zt*s(5), -e*s45 - zt*c(5)]
      g(5:6, 6) = zf*[s67, -c67]
      g(5:6, 7) = [zf*s67 - u*c(7), -zf*c67 - u*s(7)]
      a(angles + 1:, :angles) = g
      a(:angles, angles + 1:) = transpose(g)

      w12 = (v(1) + v(2))**2
      w45 = (v(4) + v(5))**2
      w67 = (v(6) + v(7))**2
      ax = -rr*c(1)*v(1)**2 + d*c12*w12
      ay = -rr*s(1)*v(1)**2 + d*s12*w12
      x(8) = -(ax + ss*s(3)*v(3)**2)
      x(9) = -(ay - ss*c(3)*v(3)**2)
      x(10) = -(ax + e*s45*w45 + zt*c(5)*v(5)**2)
      x(11) = -(ay - e*c45*w45 + zt*s(5)*v(5)**2)
      x(12) = -(ax + zf*c67*w67 + u*s(7)*v(7)**2)
      x(13) = -(ay + zf*s67*w67 - u*c(7)*v(7)**2)
   end subroutine equations

   !> Gaussian elimination with partial pivoting, of a size that the compiler knows.
   pure subroutine solve(a, x)
      real(wp), intent(inout) :: a(unknowns, unknowns), x(unknowns)
      real(wp) :: row(unknowns), factor, held
      integer :: i, j, k, pivot
      do k = 1, unknowns - 1
         pivot = k
         do i = k + 1, unknowns
            if (abs(a(i, k)) > abs(a(pivot, k))) pivot = i
         end do
         if (pivot /= k) then
            row(k:) = a(k, k:)
            a(k, k:) = a(pivot, k:)
            a(pivot, k:) = row(k:)
            held = x(k)
            x(k) = x(pivot)
            x(pivot) = held
         end if
         factor = 1.0_wp/a(k, k)
         a(k + 1:, k) = a(k + 1:, k)*factor
         do j = k + 1, unknowns
            a(k + 1:, j) = a(k + 1:, j) - a(k, j)*a(k + 1:, k)
         end do
         x(k + 1:) = x(k + 1:) - x(k)*a(k + 1:, k)
      end do
      do k = unknowns, 1, -1
         x(k) = x(k)/a(k, k)
         x(:k - 1) = x(:k - 1) - x(k)*a(:k - 1, k)
      end do
   end subroutine solve

end module squeezer_equations

!> Adams predictor-corrector (PECE with local extrapolation) of order 1 to 12 and variable step, on modified divided differences.
module squeezer_adams
   use squeezer_equations, only: wp, states, right_hand_side
   implicit none
   private
   public :: adams_type, begin, step, interpolate
   integer, parameter :: highest = 12
   !> Error constants of the correctors
   real(wp), parameter :: gstar(highest + 1) = [0.5_wp, 0.0833_wp, 0.0417_wp, 0.0264_wp, 0.0188_wp, 0.0143_wp, 0.0114_wp, &
      & 0.00936_wp, 0.00789_wp, 0.00679_wp, 0.00592_wp, 0.00524_wp, 0.00468_wp]

   type :: adams_type
      real(wp) :: t = 0.0_wp, y(states) = 0.0_wp
      !> Next step and the last one; bound of the local error
      real(wp) :: h = 0.0_wp, h_last = 0.0_wp, tolerance = 0.0_wp
      !> Modified divided differences of the rates
      real(wp) :: phi(states, highest + 2) = 0.0_wp
      !> Coefficients of the last step sizes
      real(wp) :: psi(highest) = 0.0_wp, alpha(highest) = 0.0_wp, beta(highest) = 0.0_wp, sigma(highest + 1) = 0.0_wp
      real(wp) :: v(highest) = 0.0_wp, w(highest) = 0.0_wp, g(highest + 1) = 0.0_wp
      !> Next order and the last one; steps of equal size
      integer :: k = 1, k_last = 0, equal = 0
      !> Whether order and step may still be raised at each step
      logical :: starting = .true.
      integer :: steps = 0, evaluations = 0
   end type adams_type

contains

   subroutine begin(self, y, tolerance)
      type(adams_type), intent(out) :: self
      real(wp), intent(in) :: y(states), tolerance
      real(wp) :: rate(states), size
      self%y = y
      self%tolerance = tolerance
      call right_hand_side(y, rate)
      self%evaluations = 1
      self%phi(:, 1) = rate
      self%g(1:2) = [1.0_wp, 0.5_wp]
      self%sigma(1) = 1.0_wp
      size = norm(rate, weights(y))
      self%h = 0.25_wp*sqrt(tolerance/size)
   end subroutine begin

   !> One step, repeated until its error is small enough.
   subroutine step(self)
      type(adams_type), intent(inout) :: self
      real(wp) :: p(states), rate(states), change(states), weight(states), error(-2:1), estimate
      integer :: failures, wanted, i, k
      weight = weights(self%y)
      do failures = 0, 30
         k = self%k
         call coefficients(self)
         call predict(self, p)
         call right_hand_side(p, rate)
         self%evaluations = self%evaluations + 1
         change = rate - self%phi(:, 1)
         call estimates(self, change, weight, error, estimate, wanted)
         if (estimate <= self%tolerance) exit
         ! Back to the differences before the step
         self%starting = .false.
         do i = 1, k
            self%phi(:, i) = (self%phi(:, i) - self%phi(:, i + 1))/self%beta(i)
         end do
         do i = 2, k
            self%psi(i - 1) = self%psi(i) - self%h
         end do
         if (failures >= 2) wanted = 1
         self%h = 0.5_wp*self%h
         self%k = wanted
      end do
      self%steps = self%steps + 1
      self%t = self%t + self%h
      self%k_last = k
      self%h_last = self%h
      self%y = p + self%h*self%g(k + 1)*change
      call right_hand_side(self%y, rate)
      self%evaluations = self%evaluations + 1
      self%phi(:, k + 1) = rate - self%phi(:, 1)
      self%phi(:, k + 2) = self%phi(:, k + 1) - self%phi(:, k + 2)
      do i = 1, k
         self%phi(:, i) = self%phi(:, i) + self%phi(:, k + 1)
      end do
      call next_order_and_step(self, weight, error, wanted)
   end subroutine step

   !> Angles at a time within the last step.
   pure subroutine interpolate(self, t, values)
      type(adams_type), intent(in) :: self
      real(wp), intent(in) :: t
      !> The first of the states
      real(wp), intent(out) :: values(:)
      real(wp) :: w(highest + 1), h, term, gamma
      integer :: i, j, order
      h = t - self%t
      order = self%k_last + 1
      do i = 1, order
         w(i) = 1.0_wp/i
      end do
      values = self%phi(:size(values), 1)
      term = 0.0_wp
      do j = 2, order
         gamma = (h + term)/self%psi(j - 1)
         do i = 1, order + 1 - j
            w(i) = gamma*w(i) - h/self%psi(j - 1)*w(i + 1)
         end do
         values = values + w(1)*self%phi(:size(values), j)
         term = self%psi(j - 1)
      end do
      values = self%y(:size(values)) + h*values
   end subroutine interpolate

   !> What depends on the step sizes only.
   subroutine coefficients(self)
      type(adams_type), intent(inout) :: self
      real(wp) :: sum_of_steps, old
      integer :: i, j, k, n
      k = self%k
      if (self%h /= self%h_last) self%equal = 0
      if (self%equal <= self%k_last) self%equal = self%equal + 1
      n = self%equal
      if (k < n) return
      self%beta(n) = 1.0_wp
      self%alpha(n) = 1.0_wp/n
      sum_of_steps = self%h*n
      self%sigma(n + 1) = 1.0_wp
      do i = n + 1, k
         old = self%psi(i - 1)
         self%psi(i - 1) = sum_of_steps
         self%beta(i) = self%beta(i - 1)*self%psi(i - 1)/old
         sum_of_steps = old + self%h
         self%alpha(i) = self%h/sum_of_steps
         self%sigma(i + 1) = i*self%alpha(i)*self%sigma(i)
      end do
      self%psi(k) = sum_of_steps
      if (n <= 1) then
         do i = 1, k
            self%v(i) = 1.0_wp/(i*(i + 1))
         end do
         self%w(:k) = self%v(:k)
      else
         if (k > self%k_last) then
            self%v(k) = 1.0_wp/(k*(k + 1))
            do j = 1, n - 2
               self%v(k - j) = self%v(k - j) - self%alpha(j + 1)*self%v(k - j + 1)
            end do
         end if
         do i = 1, k + 1 - n
            self%v(i) = self%v(i) - self%alpha(n)*self%v(i + 1)
         end do
         self%w(:k + 1 - n) = self%v(:k + 1 - n)
         self%g(n + 1) = self%w(1)
      end if
      do j = n + 2, k + 1
         do i = 1, k + 2 - j
            self%w(i) = self%w(i) - self%alpha(j - 1)*self%w(i + 1)
         end do
         self%g(j) = self%w(1)
      end do
   end subroutine coefficients

   subroutine predict(self, p)
      type(adams_type), intent(inout) :: self
      real(wp), intent(out) :: p(states)
      integer :: i, k
      k = self%k
      do i = self%equal + 1, k
         self%phi(:, i) = self%beta(i)*self%phi(:, i)
      end do
      self%phi(:, k + 2) = self%phi(:, k + 1)
      self%phi(:, k + 1) = 0.0_wp
      p = 0.0_wp
      do i = k, 1, -1
         p = p + self%g(i)*self%phi(:, i)
         self%phi(:, i) = self%phi(:, i) + self%phi(:, i + 1)
      end do
      p = self%y + self%h*p
   end subroutine predict

   !> Local errors at the orders k - 2, k - 1 and k, that of the step, and the order that they ask for.
   subroutine estimates(self, change, weight, error, estimate, wanted)
      type(adams_type), intent(in) :: self
      real(wp), intent(in) :: change(states), weight(states)
      real(wp), intent(out) :: error(-2:1), estimate
      integer, intent(out) :: wanted
      integer :: k
      k = self%k
      wanted = k
      error = 0.0_wp
      error(0) = self%h*norm(change, weight)
      estimate = error(0)*(self%g(k) - self%g(k + 1))
      error(0) = error(0)*self%sigma(k + 1)*gstar(k)
      if (k > 1) error(-1) = self%h*self%sigma(k)*gstar(k - 1)*norm(self%phi(:, k) + change, weight)
      if (k > 2) error(-2) = self%h*self%sigma(k - 1)*gstar(k - 2)*norm(self%phi(:, k - 1) + change, weight)
      if (k == 2 .and. error(-1) <= 0.5_wp*error(0)) wanted = k - 1
      if (k > 2 .and. maxval(error(-2:-1)) <= error(0)) wanted = k - 1
   end subroutine estimates

   subroutine next_order_and_step(self, weight, error, wanted)
      type(adams_type), intent(inout) :: self
      real(wp), intent(in) :: weight(states)
      real(wp), intent(inout) :: error(-2:1)
      integer, intent(in) :: wanted
      integer :: k, change
      real(wp) :: left
      k = self%k
      change = 0
      if (wanted < k .or. k == highest) self%starting = .false.
      if (self%starting) then
         change = 1
      else if (wanted < k) then
         change = -1
      else if (k < self%equal) then
         error(1) = self%h*gstar(k + 1)*norm(self%phi(:, k + 2), weight)
         if (k == 1) then
            if (error(1) < 0.5_wp*error(0)) change = 1
         else if (error(-1) <= min(error(0), error(1))) then
            change = -1
         else if (error(1) < error(0) .and. k < highest) then
            change = 1
         end if
      end if
      self%k = k + change
      left = 0.5_wp*self%tolerance
      if (self%starting .or. left >= error(change)*2.0_wp**(self%k + 1)) then
         self%h = 2*self%h
      else if (left < error(change)) then
         self%h = self%h*max(0.5_wp, min(0.9_wp, (left/error(change))**(1.0_wp/(self%k + 1))))
      end if
   end subroutine next_order_and_step

   !> Errors are relative to a value above 1 and absolute below.
   pure function weights(y) result(weight)
      real(wp), intent(in) :: y(states)
      real(wp) :: weight(states)
      weight = 1.0_wp/(1.0_wp + abs(y))
   end function weights

   pure real(wp) function norm(x, weight)
      real(wp), intent(in) :: x(states), weight(states)
      norm = sqrt(sum((x*weight)**2))
   end function norm

end module squeezer_adams

program squeezer_limit
   use squeezer_equations, only: wp, angles, states, start_angles
   use squeezer_adams, only: adams_type, begin, step, interpolate
   implicit none
   integer, parameter :: repeats = 30
   real(wp), allocatable :: t(:), exact(:, :), found(:, :)
   real(wp) :: seconds(repeats), tolerance, before, after
   type(adams_type) :: adams
   character(256) :: text
   integer :: i, j

   if (command_argument_count() < 2) error stop 'usage: squeezer_limit REFERENCE.csv TOLERANCE ...'
   call get_command_argument(1, text)
   call read_reference(trim(text))
   allocate (found(angles, size(t)))
   do i = 2, command_argument_count()
      call get_command_argument(i, text)
      read (text, *) tolerance
      do j = 1, repeats
         call cpu_time(before)
         call integrate()
         call cpu_time(after)
         seconds(j) = after - before
      end do
      call sort(seconds)
      print '(a,3es14.6,2(1x,i0))', trim(text), maxval(abs(found - exact)), seconds((repeats + 1)/2), seconds(1), adams%steps, &
         & adams%evaluations
   end do

contains

   !> From rest to the last sample, with the angles at all samples.
   subroutine integrate()
      integer :: sample
      real(wp) :: y(states)
      y(:angles) = start_angles
      y(angles + 1:) = 0.0_wp
      found(:, 1) = start_angles
      sample = 2
      call begin(adams, y, tolerance)
      do
         call step(adams)
         do while (t(sample) <= adams%t)
            call interpolate(adams, t(sample), found(:, sample))
            sample = sample + 1
            if (sample > size(t)) return
         end do
      end do
   end subroutine integrate

   !> Times and angles: the first eight columns, separated by commas, under one line of names.
   subroutine read_reference(path)
      character(*), intent(in) :: path
      integer :: unit, status, rows, k
      open (newunit=unit, file=path, action='read', status='old')
      rows = -1
      do
         read (unit, *, iostat=status)
         if (status /= 0) exit
         rows = rows + 1
      end do
      allocate (t(rows), exact(angles, rows))
      rewind (unit)
      read (unit, *)
      do k = 1, rows
         read (unit, *) t(k), exact(:, k)
      end do
      close (unit)
   end subroutine read_reference

   pure subroutine sort(x)
      real(wp), intent(inout) :: x(:)
      real(wp) :: held
      integer :: k, l
      do k = 2, size(x)
         held = x(k)
         do l = k - 1, 1, -1
            if (x(l) <= held) exit
            x(l + 1) = x(l)
         end do
         x(l + 1) = held
      end do
   end subroutine sort

end program squeezer_limit
