!> Couplers of more than two moving bodies: a planetary gear against Willis' formula and its wheels as free bodies, and against
!> gears with teeth; an arm whose grip is geared to its elbow against Lagrange's equations in absolute angles, integrated here.
!> Usage, in tests/: test_couplers RESULT_FILE
program test_couplers
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_base_text, only: newline
   use limber_commands_run, only: run_deck
   use limber_output_history_reader, only: history_reader_type
   use runs, only: change_deck, channel, run_changed
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   character(*), parameter :: nl = newline
   !> What the tendon of the arm makes of the absolute angles of its links
   real(wp), parameter :: tie(4) = [-1.5_wp, 1.5_wp, -1.0_wp, 1.0_wp]
   character(10), parameter :: integrators(4) = [character(10) :: 'ADAMS', 'RADAU', 'ALPHA', 'CONSERVING']
   character(256) :: results

   call get_command_argument(1, results)
   call check_planetary_gear()
   call check_arm()
   call check_power()
   call check_statics()
   call check_kinematics()
   call finish()

contains

   !> Speeds and torques of the deck in input/, by all integrators; with gears in place of couplers.
   subroutine check_planetary_gear()
      character(*), parameter :: deck = '../input/planetary_gear.inp', redundant = 'models/bad_warn_redundant_coupler.inp'
      character(*), parameter :: dynamics = '*DYNAMICS, END=2, TOLERANCE=1e-10, OUTPUTS=40'
      real(wp), parameter :: places(4) = [1.0e-8_wp, 1.0e-9_wp, 1.0e-4_wp, 1.0e-4_wp]
      ! The work of loads that follow the time is that of their laws, which the forces of CONSERVING do to order 2
      real(wp), parameter :: energies(4) = [1.0e-9_wp, 1.0e-9_wp, 1.0e-4_wp, 1.0e-10_wp]
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
      ! As above: that of the motor
      real(wp), parameter :: energies(4) = [1.0e-8_wp, 1.0e-8_wp, 1.0e-3_wp, 1.0e-6_wp]
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

   !> The arm hangs: weight and tendon balance on each link; its frequencies are zeros of the characteristic determinant.
   subroutine check_statics()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(70) :: old(2), new(2)
      real(wp), allocatable :: frequency(:)
      real(wp) :: theta(4), mass(4, 4), weight(4), small(3, 3), k(3, 3), m(3, 3), tendon, last
      integer :: i
      old = [character(70) :: ' torque*sin(3*t)', '*DYNAMICS, END=2, OUTPUTS=20, INTEGRATOR=ADAMS, TOLERANCE=1e-10']
      new = [character(70) :: ' 0', '*STATICS, RAMP=YES'//nl//'*MODES, NAME=hanging, NUMBER=3']
      call run_changed('verification/coupled_arm.inp', trim(results), old, new, reader)
      theta = [at_end(reader, 'upper'), at_end(reader, 'fore'), at_end(reader, 'hand'), at_end(reader, 'tool')]
      tendon = at_end(reader, 'tendon')
      call check_close(theta(4), tool_angle(theta(:3)), 1.0e-12_wp, 'the tendon keeps its length')
      call find_arm(theta, mass, weight)
      call check_close(maxval(abs(-weight*cos(theta) + tie*tendon)), 0.0_wp, 1.0e-10_wp, 'balance of weight and tendon')
      call check(abs(tendon) > 0.1_wp, 'the tendon pulls')
      call reader%read_numbers('/modes/hanging/frequency', frequency, error)
      call check_no_error(error, 'frequencies')
      call check(size(frequency) == 3, 'three frequencies')
      m = reduced(mass)
      mass = 0.0_wp
      do i = 1, 4
         mass(i, i) = -weight(i)*sin(theta(i))
      end do
      k = reduced(mass)
      last = 0.0_wp
      do i = 1, 3
         small = k - frequency(i)**2*m
         call check_close(determinant(small)/(frequency(i)**6*determinant(m)), 0.0_wp, 1.0e-9_wp, 'frequency of the arm')
         call check(frequency(i) > last + 1, 'each is another')
         last = frequency(i)
      end do
      call reader%close()
   end subroutine check_statics

   !> A matrix of the absolute angles for the three that are independent.
   pure function reduced(whole) result(own)
      real(wp), intent(in) :: whole(4, 4)
      real(wp) :: own(3, 3), turns(4, 3)
      integer :: i
      turns = 0.0_wp
      do i = 1, 3
         turns(i, i) = 1.0_wp
      end do
      turns(4, :) = [1.5_wp, -1.5_wp, 1.0_wp]
      own = matmul(transpose(turns), matmul(whole, turns))
   end function reduced

   pure real(wp) function determinant(a)
      real(wp), intent(in) :: a(3, 3)
      determinant = a(1, 1)*(a(2, 2)*a(3, 3) - a(2, 3)*a(3, 2)) - a(1, 2)*(a(2, 1)*a(3, 3) - a(2, 3)*a(3, 1)) &
         & + a(1, 3)*(a(2, 1)*a(3, 2) - a(2, 2)*a(3, 1))
   end function determinant

   !> Driven wholly: the tool follows; torques are those of Lagrange's equations; the report has the drivers, not the coupler.
   subroutine check_kinematics()
      character(*), parameter :: deck = 'verification/coupled_arm.inp'
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(160) :: old(3), new(3)
      character(:), allocatable :: report
      real(wp) :: t(5), theta(4), acceleration(4), omega(4), tendon(5), wrist(5), tool(5), torque
      integer :: i
      old = [character(160) :: '*TORQUE, NAME=motor, BODY=upper', ' torque*sin(3*t)', &
         & '*DYNAMICS, END=2, OUTPUTS=20, INTEGRATOR=ADAMS, TOLERANCE=1e-10']
      new(1) = '*DRIVER, NAME=a, TYPE=ANGLE, BODY=upper'//nl//' -1 + 0.3*sin(3*t)'//nl//'*DRIVER, NAME=b, TYPE=ANGLE, JOINT=elbow'
      new(2) = ' 0.6 + 0.2*t'//nl//'*DRIVER, NAME=motor, TYPE=ANGLE, JOINT=wrist'//nl//' 0.5'
      new(3) = '*INVERSE DYNAMICS, END=1, OUTPUTS=4'
      call change_deck(deck, trim(results)//'.inp', [character(160) :: old, 'upper = angle(upper)'], &
         & [character(160) :: new, 'wrist = torque(motor)'])
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
      call check_no_error(error, 'kinematics')
      if (allocated(error)) return
      call check(index(report, "driver 'motor': largest") > 0, 'the report has the drivers')
      call check(index(report, "coupler 'tendon'") == 0, 'and not the coupler')
      call reader%open(trim(results), error)
      tool = channel(reader, 'tool')
      tendon = channel(reader, 'tendon')
      wrist = channel(reader, 'wrist')
      t = [0.0_wp, 0.25_wp, 0.5_wp, 0.75_wp, 1.0_wp]
      do i = 1, 5
         theta(1) = -1 + 0.3_wp*sin(3*t(i))
         theta(2) = theta(1) + 0.6_wp + 0.2_wp*t(i)
         theta(3) = theta(2) + 0.5_wp
         theta(4) = tool_angle(theta(:3))
         call check_close(tool(i), theta(4), 1.0e-10_wp, 'the tool follows')
         omega = 0.9_wp*cos(3*t(i))
         omega(2:3) = omega(2:3) + 0.2_wp
         omega(4) = omega(3) - 0.3_wp
         acceleration = -2.7_wp*sin(3*t(i))
         ! on the tool the tendon alone; on the hand the wrist's motor and the tendon's other end
         torque = inertia_of(4, theta, omega, acceleration)
         call check_close(tendon(i), torque, 1.0e-9_wp, 'pull of the tendon, driven')
         torque = inertia_of(3, theta, omega, acceleration) + tendon(i)
         call check_close(wrist(i), torque, 1.0e-9_wp, 'torque of the wrist')
      end do
      call reader%close()
   end subroutine check_kinematics

   !> Left-hand side of the equation of a link.
   real(wp) function inertia_of(link, theta, omega, acceleration) result(left)
      integer, intent(in) :: link
      !> Absolute angles, and their two derivatives
      real(wp), intent(in) :: theta(4), omega(4), acceleration(4)
      real(wp) :: mass(4, 4), weight(4)
      integer :: j
      call find_arm(theta, mass, weight)
      left = weight(link)*cos(theta(link))
      do j = 1, 4
         left = left + mass(link, j)*acceleration(j)
         if (j /= link) left = left + mass(link, j)*tan(theta(link) - theta(j))*omega(j)**2
      end do
   end function inertia_of

   !> The last value of a channel.
   real(wp) function at_end(reader, name)
      type(history_reader_type), intent(in) :: reader
      character(*), intent(in) :: name
      real(wp), allocatable :: values(:)
      values = channel(reader, name)
      at_end = values(size(values))
   end function at_end

   !> Masses of the absolute angles, M_ij = A_ij cos(theta_i - theta_j), and moments of the weights of level links.
   pure subroutine find_arm(theta, m, weight)
      real(wp), intent(in) :: theta(4)
      real(wp), intent(out) :: m(4, 4), weight(4)
      real(wp), parameter :: mass(4) = [3.0_wp, 2.0_wp, 1.2_wp, 0.8_wp], inertia(4) = [0.09_wp, 0.05_wp, 0.02_wp, 0.01_wp]
      real(wp), parameter :: centre(4) = [0.25_wp, 0.2_wp, 0.15_wp, 0.1_wp], long(4) = [0.6_wp, 0.5_wp, 0.3_wp, 0.0_wp]
      real(wp) :: arm(4, 4)
      integer :: i, j
      arm = 0.0_wp
      do i = 1, 4
         arm(:i - 1, i) = long(:i - 1)
         arm(i, i) = centre(i)
      end do
      do i = 1, 4
         do j = 1, 4
            m(i, j) = sum(mass*arm(i, :)*arm(j, :))*cos(theta(i) - theta(j))
         end do
         m(i, i) = m(i, i) + inertia(i)
         weight(i) = 9.81_wp*sum(mass*arm(i, :))
      end do
   end subroutine find_arm

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
      real(wp) :: theta(4), omega(4), weight(4), m(5, 6)
      integer :: i, j
      theta = [y(:3), tool_angle(y(:3))]
      omega = [y(4:6), y(6) - 1.5_wp*(y(5) - y(4))]
      m = 0.0_wp
      call find_arm(theta, m(:4, :4), weight)
      do i = 1, 4
         m(i, 6) = -weight(i)*cos(theta(i))
         do j = 1, 4
            if (j /= i) m(i, 6) = m(i, 6) - m(i, j)*tan(theta(i) - theta(j))*omega(j)**2
         end do
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
