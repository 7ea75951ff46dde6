!> Couplers of more than two moving bodies: a planetary gear against Willis' formula and its wheels as free bodies, and against
!> gears with teeth; an arm whose grip is geared to its elbow against Lagrange's equations in absolute angles, integrated here.
!> Usage, in tests/: test_couplers RESULT_FILE
program test_couplers
   use limber_base_kinds, only: wp
   use limber_base_text, only: newline
   use limber_output_history_reader, only: history_reader_type
   use runs, only: channel, run_changed
   use testing, only: check, check_close, finish
   implicit none

   character(*), parameter :: nl = newline
   character(10), parameter :: integrators(4) = [character(10) :: 'ADAMS', 'RADAU', 'ALPHA', 'CONSERVING']
   character(256) :: results

   call get_command_argument(1, results)
   call check_planetary_gear()
   call check_arm()
   call check_power()
   call finish()

contains

   !> Speeds and torques of the deck in input/, by all integrators; with gears in place of couplers.
   subroutine check_planetary_gear()
      character(*), parameter :: deck = '../input/planetary_gear.inp', redundant = 'models/bad_warn_redundant_coupler.inp'
      character(*), parameter :: dynamics = '*DYNAMICS, END=2, TOLERANCE=1e-10, OUTPUTS=40'
      real(wp), parameter :: places(4) = [1.0e-8_wp, 1.0e-9_wp, 1.0e-4_wp, 1.0e-4_wp]
      real(wp), parameter :: energies(4) = [1.0e-9_wp, 1.0e-9_wp, 1.0e-4_wp, 1.0e-11_wp]
      character(256) :: old(4), new(4)
      integer :: k
      do k = 1, 4
         old(1) = dynamics
         new(1) = '*DYNAMICS, END=2, OUTPUTS=40, TOLERANCE=1e-10, INTEGRATOR='//integrators(k)
         if (k == 3) new(1) = '*DYNAMICS, END=2, OUTPUTS=40, FIXED STEP=2e-3, INTEGRATOR=ALPHA'
         if (k == 4) new(1) = '*DYNAMICS, END=2, OUTPUTS=40, FIXED STEP=2e-4, INTEGRATOR=CONSERVING'
         call compare_gear(deck, trim(integrators(k)), old(:1), new(:1), 1.0_wp, places(k), energies(k))
         call compare_gear(redundant, trim(integrators(k))//', redundant', old(:1), new(:1), -1.0_wp, 3*places(k), &
            & 3*energies(k))
      end do
      old(1) = '*COUPLER, NAME=sun-mesh'//nl//' sun, angle, sun'//nl//' -sun, angle, carrier'//nl &
         & //' planet, joint_angle, planet-pin'
      new(1) = '*JOINT, NAME=sun-mesh, TYPE=GEAR, FIRST RADIUS=24e-3*1.5, SECOND RADIUS=18e-3*1.5'//nl//' sun.origin, planet.origin'
      old(2) = '*COUPLER, NAME=ring-mesh'//nl//' ring, angle, ring'//nl//' -ring, angle, carrier'//nl &
         & //' -planet, joint_angle, planet-pin'
      new(2) = '*JOINT, NAME=ring-mesh, TYPE=GEAR, FIRST RADIUS=60e-3*1.5, SECOND RADIUS=18e-3*1.5, INTERNAL'//nl &
         & //' ring.origin, planet.origin'
      old(3) = 'coupling(sun-mesh)'
      new(3) = 'moment(sun-mesh)'
      old(4) = 'coupling(ring-mesh)'
      new(4) = 'moment(ring-mesh)'
      call compare_gear(deck, 'gears with teeth', old, new, 0.0_wp, 1.0e-8_wp, 1.0e-9_wp)
   end subroutine check_planetary_gear

   !> One run of the planetary gear against its equations.
   subroutine compare_gear(deck, name, old, new, teeth, place, energy)
      character(*), intent(in) :: deck, name, old(:), new(:)
      !> 1: the channels of the teeth are per tooth; 0: they are moments; -1: there is none alone
      real(wp), intent(in) :: teeth
      !> How exactly angles are met [rad], and the energy relative to 100 J
      real(wp), intent(in) :: place, energy
      integer, parameter :: n = 41
      real(wp), parameter :: sun = 24, planet = 18, ring = 60, arm = 0.063_wp
      real(wp), parameter :: of_sun = 5.0e-4_wp, of_planet = 8.0e-5_wp, of_ring = 0.02_wp, of_carrier = 4.0e-3_wp + 0.4_wp*arm**2
      type(history_reader_type) :: reader
      real(wp), dimension(n) :: t, load, brake, a, a_carrier, a_planet, a_ring, inner, outer, spin, angle, given
      integer :: i
      call run_changed(deck, trim(results), old, new, reader)
      t = [(2.0_wp*i/(n - 1), i=0, n - 1)]
      a = 30*t
      load = -6
      brake = 4 + 0.3_wp*t
      ! carrier as a free body, with the teeth from planet and ring as free bodies
      a_carrier = (load + (sun + planet)*(2*(of_ring*sun/ring*a + brake)/ring + of_planet*sun/planet**2*a)) &
         & /(of_carrier + (sun + planet)*(2*of_ring*(1 + sun/ring)/ring + of_planet*(1 + sun/planet)/planet))
      a_planet = a_carrier - sun/planet*(a - a_carrier)
      a_ring = a_carrier + planet/ring*(a_planet - a_carrier)
      outer = (of_ring*a_ring - brake)/ring
      inner = outer + of_planet*a_planet/planet
      if (teeth > 0.5_wp) then
         call compare(reader, name, 'sun_teeth', inner, 1.0e-6_wp + 0.1_wp*place, 'torque of the teeth of the sun')
         call compare(reader, name, 'ring_teeth', outer, 1.0e-6_wp + 0.1_wp*place, 'torque of the teeth of the ring')
      else if (teeth > -0.5_wp) then
         call compare(reader, name, 'sun_teeth', sun*inner, 1.0e-6_wp, 'moment of the teeth on the sun')
         call compare(reader, name, 'ring_teeth', ring*outer, 1.0e-6_wp, 'moment of the teeth on the ring')
      end if
      call compare(reader, name, 'motor', of_sun*a - sun*inner, 1.0e-6_wp + place, 'torque of the motor')
      ! accelerations are linear in time, the ring starts at rest
      spin = 20*sun/(sun + ring) + a_carrier(1)*t + (a_carrier(n) - a_carrier(1))*t**2/4
      angle = 20*sun/(sun + ring)*t + a_carrier(1)*t**2/2 + (a_carrier(n) - a_carrier(1))*t**3/12
      call compare(reader, name, 'carrier', angle, place, 'angle of the carrier')
      call compare(reader, name, 'carrier_spin', spin, 10*place, 'its speed')
      given = 20*t + 5*t**3
      call compare(reader, name, 'ring', angle - sun/ring*(given - angle), 2*place, 'angle of the ring by Willis')
      call compare(reader, name, 'planet', angle - sun/planet*(given - angle), 2*place, 'angle of the planet')
      call check(maxval(abs(channel(reader, 'planet'))) > 50, name//': it turns often')
      spin = channel(reader, 'ring_spin') - channel(reader, 'carrier_spin')
      call check_close(maxval(abs(spin + sun/ring*(channel(reader, 'sun_spin') - channel(reader, 'carrier_spin')))), 0.0_wp, &
         & 1.0e-9_wp + 10*place, name//': Willis')
      spin = channel(reader, 'energy')
      call check_close(maxval(abs(spin - spin(1)))/100, 0.0_wp, energy, name//': energy less work')
      call reader%close()
   end subroutine compare_gear

   !> A channel against values at all samples.
   subroutine compare(reader, name, channel_name, expected, tolerance, what)
      type(history_reader_type), intent(in) :: reader
      !> Of the run, of the channel, of what it is
      character(*), intent(in) :: name, channel_name, what
      real(wp), intent(in) :: expected(:), tolerance
      real(wp) :: values(size(expected))
      values = channel(reader, channel_name)
      print '(4a,2es9.1)', name, ': ', what, repeat(' ', max(1, 50 - len(name) - len(what))), maxval(abs(values - expected)), &
         & maxval(abs(expected))
      call check_close(maxval(abs(values - expected)), 0.0_wp, tolerance, name//': '//what)
   end subroutine compare

   !> Four links, by all integrators.
   subroutine check_arm()
      character(*), parameter :: deck = 'verification/coupled_arm.inp'
      character(*), parameter :: names(4) = [character(5) :: 'upper', 'fore', 'hand', 'tool']
      integer, parameter :: n = 21
      real(wp), parameter :: places(4) = [1.0e-7_wp, 1.0e-7_wp, 1.0e-3_wp, 2.0e-3_wp]
      real(wp), parameter :: energies(4) = [1.0e-8_wp, 1.0e-8_wp, 1.0e-3_wp, 1.0e-11_wp]
      type(history_reader_type) :: reader
      character(100) :: new(1)
      real(wp) :: theta(4, n), tendon(n), values(n), off
      integer :: k, i
      call integrate_arm(theta, tendon)
      do k = 1, 4
         new(1) = 'INTEGRATOR='//trim(integrators(k))//', TOLERANCE=1e-10'
         if (k > 2) new(1) = 'INTEGRATOR='//trim(integrators(k))//', FIXED STEP=5e-4'
         call run_changed(deck, trim(results), ['INTEGRATOR=ADAMS, TOLERANCE=1e-10'], new, reader)
         off = 0
         do i = 1, 4
            values = channel(reader, trim(names(i)))
            off = max(off, maxval(abs(values - theta(i, :))))
         end do
         print '(2a,2es9.1)', integrators(k), ' arm off by', off, maxval(abs(theta))
         call check_close(off, 0.0_wp, places(k), trim(integrators(k))//': angles of the arm')
         values = channel(reader, 'tendon')
         if (k <= 2) call check_close(maxval(abs(values - tendon)), 0.0_wp, 1.0e-5_wp, trim(integrators(k))//': pull of the tendon')
         values = channel(reader, 'energy')
         print '(2a,es9.1)', integrators(k), ' energy less work', maxval(abs(values - values(1)))
         call check_close(maxval(abs(values - values(1)))/maxval(channel(reader, 'kinetic')), 0.0_wp, energies(k), &
            & trim(integrators(k))//': energy less work')
         call reader%close()
      end do
   end subroutine check_arm

   !> A tendon that is pulled: its power is what the work grows by, by Simpson's rule.
   subroutine check_power()
      integer, parameter :: n = 401
      type(history_reader_type) :: reader
      character(80) :: old(4), new(4)
      real(wp) :: power(n), effort(n), work(n), t(n), sum
      integer :: i
      old = [character(80) :: ' ratio, joint_angle, elbow', ' torque*sin(3*t)', 'OUTPUTS=20', 'upper = angle(upper)']
      new = [character(80) :: ' ratio, joint_angle, elbow'//nl//' 1.7 + 0.4*sin(2*t), value', ' 0', 'OUTPUTS=400', &
         & 'power = power(tendon), work = work(system)']
      call run_changed('verification/coupled_arm.inp', trim(results), old, new, reader)
      power = channel(reader, 'power')
      effort = channel(reader, 'tendon')
      work = channel(reader, 'work')
      t = [(2.0_wp*i/(n - 1), i=0, n - 1)]
      call check_close(maxval(abs(power - effort*0.8_wp*cos(2*t))), 0.0_wp, 1.0e-12_wp*maxval(abs(power)), 'power of a tendon')
      sum = 0.0_wp
      do i = 1, n - 2, 2
         sum = sum + (power(i) + 4*power(i + 1) + power(i + 2))*(t(2) - t(1))/3
         call check_close(work(i + 2), sum, 1.0e-5_wp*maxval(abs(work)), 'its work')
      end do
      call check(maxval(abs(work)) > 0.3_wp, 'there is some')
      call reader%close()
   end subroutine check_power

   !> Absolute angles of the links at the samples, and the torque in the tendon, by Runge and Kutta's method.
   subroutine integrate_arm(theta, tendon)
      !> (links, samples); (samples)
      real(wp), intent(out) :: theta(:, :), tendon(:)
      integer, parameter :: steps = 400
      real(wp) :: y(6), k1(6), k2(6), k3(6), k4(6), pull, t, h
      integer :: i, j
      y = [-1.0_wp, -0.4_wp, 0.1_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      h = 0.1_wp/steps
      do i = 1, size(tendon)
         t = 0.1_wp*(i - 1)
         theta(:3, i) = y(:3)
         theta(4, i) = tool_angle(y(:3))
         call slope(t, y, k1, tendon(i))
         if (i == size(tendon)) exit
         do j = 1, steps
            call slope(t, y, k1, pull)
            call slope(t + h/2, y + h/2*k1, k2, pull)
            call slope(t + h/2, y + h/2*k2, k3, pull)
            call slope(t + h, y + h*k3, k4, pull)
            y = y + h/6*(k1 + 2*k2 + 2*k3 + k4)
            t = t + h
         end do
      end do
   end subroutine integrate_arm

   !> theta_4 - theta_3 + 1.5 (theta_2 - theta_1) keeps its value.
   pure real(wp) function tool_angle(theta)
      real(wp), intent(in) :: theta(3)
      tool_angle = theta(3) - 1.5_wp*(theta(2) - theta(1)) + 0.9_wp - 0.1_wp + 1.5_wp*0.6_wp
   end function tool_angle

   !> Lagrange's equations of a chain in absolute angles, M_ij = A_ij cos(theta_i - theta_j), with the multiplier of the tendon.
   subroutine slope(t, y, rate, pull)
      real(wp), intent(in) :: t, y(6)
      real(wp), intent(out) :: rate(6), pull
      real(wp), parameter :: mass(4) = [3.0_wp, 2.0_wp, 1.2_wp, 0.8_wp], inertia(4) = [0.09_wp, 0.05_wp, 0.02_wp, 0.01_wp]
      real(wp), parameter :: centre(4) = [0.25_wp, 0.2_wp, 0.15_wp, 0.1_wp], long(4) = [0.6_wp, 0.5_wp, 0.3_wp, 0.0_wp]
      real(wp), parameter :: tie(4) = [-1.5_wp, 1.5_wp, -1.0_wp, 1.0_wp]
      real(wp) :: theta(4), omega(4), arm(4, 4), a, m(5, 6)
      integer :: i, j, k
      theta = [y(:3), tool_angle(y(:3))]
      omega = [y(4:6), y(6) - 1.5_wp*(y(5) - y(4))]
      arm = 0.0_wp
      do k = 1, 4
         arm(:k - 1, k) = long(:k - 1)
         arm(k, k) = centre(k)
      end do
      m = 0.0_wp
      do i = 1, 4
         m(i, i) = inertia(i)
         do j = 1, 4
            a = sum(mass*arm(i, :)*arm(j, :))
            m(i, j) = m(i, j) + a*cos(theta(i) - theta(j))
            m(i, 6) = m(i, 6) - a*sin(theta(i) - theta(j))*omega(j)**2
         end do
         m(i, 6) = m(i, 6) - 9.81_wp*sum(mass*arm(i, :))*cos(theta(i))
      end do
      m(1, 6) = m(1, 6) + 6*sin(3*t)
      m(:4, 5) = -tie
      m(5, :4) = tie
      call eliminate(m)
      rate = [omega(:3), m(:3, 6)]
      pull = m(5, 6)
   end subroutine slope

   !> Gauss and Jordan's elimination; the solution is left in the last column.
   pure subroutine eliminate(m)
      real(wp), intent(inout) :: m(5, 6)
      real(wp) :: row(6)
      integer :: i, j, best
      do i = 1, 5
         best = i - 1 + maxloc(abs(m(i:, i)), dim=1)
         row = m(best, :)
         m(best, :) = m(i, :)
         m(i, :) = row/row(i)
         do j = 1, 5
            if (j /= i) m(j, :) = m(j, :) - m(j, i)*m(i, :)
         end do
      end do
   end subroutine eliminate

end program test_couplers
