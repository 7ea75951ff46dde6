!> Loads in whole runs against solutions in closed form, by all integrators, against the published one of the car axis, and
!> against the tables of beams. Forces between steps of a method that passes over vibrations, against a fine run. Usage, in tests/:
!> test_forces RESULT_FILE
program test_forces
   use limber_base_kinds, only: wp
   use limber_output_history_reader, only: history_reader_type
   use limber_base_error, only: error_type
   use runs, only: run_changed, run_text, channel
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   character(256) :: results

   call get_command_argument(1, results)
   call check_closed_forms('ADAMS', '1e-10', 1.0e-7_wp, 1.0e-8_wp)
   call check_closed_forms('RADAU', '1e-10', 1.0e-7_wp, 1.0e-9_wp)
   call check_closed_forms('ALPHA', '1e-7', 1.0e-3_wp, 1.0e-3_wp)
   ! The work is that of the laws along the way, which the forces of the steps do to the tolerance
   call check_closed_forms('CONSERVING', '1e-7', 2.0e-3_wp, 1.0e-6_wp)
   call check_car_axis('ADAMS', '1e-9', 1.0e-8_wp)
   call check_car_axis('RADAU', '1e-11', 1.0e-9_wp)
   call check_damping('ADAMS', '1e-10', 1.0e-6_wp)
   call check_damping('CONSERVING', '1e-6', 1.0e-3_wp)
   call check_distributed()
   call check_within_steps('*BEAM, NAME=b, MATERIAL=m, SECTION=s, LENGTH=1', 'pinned')
   call check_within_steps('*BEAM, NAME=b, MATERIAL=m, SECTION=s, LENGTH=1, SEGMENTS=2', 'in segments')
   call finish()

contains

   !> Two stiff beams on soft springs, pushed by a force that comes smoothly: samples fall within the steps of RADAU, where joints
   !> that are closed by the stretch of the beams would carry 100 times their force. Against a run with a tolerance of 1e-10.
   subroutine check_within_steps(beam, name)
      character(*), intent(in) :: beam, name
      character(*), parameter :: nl = new_line('a')
      character(*), parameter :: channels(5) = [character(3) :: 'fx', 'fy', 'gy', 'bm', 'af'], &
         & tolerances(2) = [character(5) :: '1e-6', '1e-10']
      character(:), allocatable :: told
      type(error_type), allocatable :: error
      type(history_reader_type) :: reader
      real(wp) :: values(0:40, 5, 2), allowed
      integer :: i, k
      do k = 1, 2
         call run_text('*MATERIAL, NAME=m, YOUNG=9.8e10, DENSITY=2500'//nl// &
            & '*SECTION, NAME=s, SHAPE=RECTANGLE, WIDTH=0.04, HEIGHT=0.019'//nl//beam//nl// &
            & '*BEAM, NAME=c, MATERIAL=m, SECTION=s, LENGTH=0.37, X=1'//nl// &
            & '*JOINT, NAME=j, TYPE=REVOLUTE'//nl//' b.start, ground.origin'//nl// &
            & '*JOINT, NAME=i, TYPE=REVOLUTE'//nl//' c.start, b.end'//nl// &
            & '*SPRING, NAME=r, TYPE=ROTATIONAL, STIFFNESS=60, DAMPING=1.2'//nl//' ground.origin, b.start'//nl// &
            & '*SPRING, NAME=q, TYPE=ROTATIONAL, STIFFNESS=20, DAMPING=0.3'//nl//' b.end, c.start'//nl// &
            & '*FORCE, NAME=f, POINT=c.end'//nl//' 0, -4.7*smoothstep(t/0.386)'//nl// &
            & '*DYNAMICS, END=0.6, OUTPUTS=40, INTEGRATOR=RADAU, TOLERANCE='//trim(tolerances(k))//nl// &
            & '*OUTPUT'//nl//' fx=force_x(j), fy=force_y(j), gy=force_y(i), bm=bending_moment(b.middle)'//nl// &
            & ' af=axial_force(c.middle)'//nl, &
            & trim(results), told, error)
         call check_no_error(error, 'forces within steps, '//name)
         if (allocated(error)) error stop 1
         call reader%open(trim(results), error)
         call check_no_error(error, 'results')
         do i = 1, 5
            values(:, i, k) = channel(reader, trim(channels(i)))
         end do
         call reader%close()
      end do
      do i = 1, 5
         allowed = maxval(abs(values(:, i, 2)))
         if (i == 1) allowed = max(allowed, 0.5_wp*maxval(abs(values(:, 2, 2))))
         print '(4a,2es12.3)', 'within steps, ', name, ', ', channels(i), allowed, maxval(abs(values(:, i, 1) - values(:, i, 2)))
         call check(maxval(abs(values(:, i, 1) - values(:, i, 2))) <= 0.02_wp*allowed, 'within steps, '//name//', '//channels(i))
      end do
   end subroutine check_within_steps

   !> The scene forces.inp.
   subroutine check_closed_forms(integrator, tolerance, allowed, balance)
      character(*), intent(in) :: integrator, tolerance
      !> Of the motion, of the energy less work relative to the kinetic energy
      real(wp), intent(in) :: allowed, balance
      type(history_reader_type) :: reader
      real(wp), parameter :: j = 0.3_wp, k = 1.7_wp, c = 0.12_wp, m = 0.8_wp, free = 0.4_wp, turn = 9.0_wp
      real(wp), parameter :: x = 0.1_wp*cos(0.5_wp), y = -0.1_wp*sin(0.5_wp)
      real(wp), allocatable :: energy(:), kinetic(:), force(:), power(:), spin(:), other(:)
      character(40) :: new(1)
      real(wp) :: t(0:60), decay(0:60), along(0:60), across(0:60), w, d
      integer :: i
      t = [(0.1_wp*i, i=0, 60)]
      new(1) = 'TOLERANCE='//tolerance//', INTEGRATOR='//integrator
      call run_changed('verification/forces.inp', trim(results), [character(40) :: 'TOLERANCE=1e-10, INTEGRATOR=ADAMS'], new, &
         & reader)
      w = sqrt(k/j)
      call compare(reader, integrator, allowed, 'wheel', free + (turn - free)*cos(w*t))
      d = 0.5_wp*c/j
      w = sqrt(k/j - d**2)
      decay = free + (turn - free)*exp(-d*t)*(cos(w*t) + d/w*sin(w*t))
      call compare(reader, integrator, allowed, 'damped', decay)
      call compare(reader, integrator, allowed, 'held', decay)
      call compare(reader, integrator, allowed, 'cubic', [(cosine_of_half(t(i)), i=0, 60)])
      call compare(reader, integrator, 5*allowed, 'bilinear', [(two_springs(t(i), sqrt(1.3_wp), sqrt(7.0_wp)), i=0, 60)])
      call compare(reader, integrator, allowed, 'a', 1.5_wp*(1 - cos(2*t))/0.2_wp)
      call compare(reader, integrator, allowed, 'b', -1.5_wp*(1 - cos(2*t))/0.5_wp)
      call compare(reader, integrator, allowed, 'vx', -(1 - cos(1.5_wp*t)))
      call compare(reader, integrator, allowed, 'vy', sin(1.5_wp*t))
      w = sqrt(5/m)
      along = x*cos(w*t)
      d = 0.5_wp*0.3_wp/m
      w = sqrt(20/m - d**2)
      across = y*exp(-d*t)*(cos(w*t) + d/w*sin(w*t))
      call compare(reader, integrator, allowed, 'mount_x', along*cos(0.5_wp) - across*sin(0.5_wp))
      call compare(reader, integrator, allowed, 'mount_y', along*sin(0.5_wp) + across*cos(0.5_wp))
      call compare(reader, integrator, allowed, 'rotor', 20*exp(-c/j*t))
      call compare(reader, integrator, allowed, 'slider', 3*exp(-c/m*t))
      d = 0.5_wp*c/m
      w = sqrt(k/m - d**2)
      call compare(reader, integrator, allowed, 'block', 3*exp(-d*t)*sin(w*t)/w)
      allocate (energy, source=channel(reader, 'energy'))
      allocate (kinetic, source=channel(reader, 'kinetic'))
      print '(2a,2es10.2)', integrator, ': change of energy less work, kinetic energy', maxval(abs(energy - energy(1))), &
         & maxval(kinetic)
      call check_close(maxval(abs(energy - energy(1)))/maxval(kinetic), 0.0_wp, balance, integrator//': energy less work')
      ! What channels say of loads, by the motion of the same run
      allocate (spin, source=channel(reader, 'wheel'))
      allocate (force, source=channel(reader, 'torque_torsion'))
      call check_close(maxval(abs(force - k*(spin - free))), 0.0_wp, 1.0e-12_wp*k*turn, 'torque of a spring')
      allocate (other, source=channel(reader, 'elongation_torsion'))
      call check_close(maxval(abs(force - k*other)), 0.0_wp, 1.0e-12_wp*k*turn, 'elongation of a rotational spring')
      deallocate (spin, force, other)
      allocate (spin, source=channel(reader, 'rotor'))
      allocate (power, source=channel(reader, 'power_bearing'))
      call check_close(maxval(abs(power + c*spin**2)), 0.0_wp, 1.0e-10_wp, 'power of friction')
      deallocate (spin, power)
      allocate (spin, source=channel(reader, 'cubic'))
      allocate (force, source=channel(reader, 'tension_cubic'))
      call check_close(maxval(abs(force - m*spin**3)), 0.0_wp, 1.0e-12_wp, 'tension of a law')
      deallocate (spin, force)
      allocate (spin, source=channel(reader, 'a'))
      allocate (other, source=channel(reader, 'b'))
      allocate (power, source=channel(reader, 'power_motor'))
      call check_close(maxval(abs(power - 3*sin(2*t)*(spin - other))), 0.0_wp, 1.0e-10_wp, 'power of a motor')
      deallocate (spin, other, power, energy, kinetic)
      call reader%close()
   end subroutine check_closed_forms

   !> A channel against expected values, relative to the largest of these.
   subroutine compare(reader, label, allowed, name, expected)
      type(history_reader_type), intent(in) :: reader
      character(*), intent(in) :: label, name
      real(wp), intent(in) :: allowed, expected(:)
      real(wp), allocatable :: values(:)
      allocate (values, source=channel(reader, name))
      call check_close(maxval(abs(values - expected)), 0.0_wp, allowed*maxval(abs(expected)), label//': '//name)
      deallocate (values)
   end subroutine compare

   !> The solution of x'' = -x**3 from 1 at rest: Jacobi's cn(t) of the parameter 1/2, by the arithmetic-geometric mean.
   pure real(wp) function cosine_of_half(t) result(x)
      real(wp), intent(in) :: t
      real(wp) :: a(0:8), c(0:8), b, phi
      integer :: i
      a(0) = 1.0_wp
      b = sqrt(0.5_wp)
      c(0) = b
      do i = 1, 8
         a(i) = 0.5_wp*(a(i - 1) + b)
         c(i) = 0.5_wp*(a(i - 1) - b)
         b = sqrt(a(i - 1)*b)
      end do
      phi = 2**8*a(8)*t
      do i = 8, 1, -1
         phi = 0.5_wp*(phi + asin(c(i)*sin(phi)/a(i)))
      end do
      x = cos(phi)
   end function cosine_of_half

   !> Motion from -1 at rest with one frequency to the left of 0, and another to the right.
   pure real(wp) function two_springs(t, left, right) result(x)
      real(wp), intent(in) :: t, left, right
      real(wp), parameter :: pi = acos(-1.0_wp)
      real(wp) :: s
      s = modulo(t + 0.5_wp*pi/left, pi/left + pi/right)
      if (s < pi/left) then
         x = -sin(left*s)
      else
         x = left/right*sin(right*(s - pi/left))
      end if
   end function two_springs

   !> The published solution of the Test Set for IVP Solvers at t = 3; a solution in minimal coordinates by a program of its own
   !> agrees with it to 4e-12.
   subroutine check_car_axis(integrator, tolerance, allowed)
      character(*), intent(in) :: integrator, tolerance
      real(wp), intent(in) :: allowed
      character(3), parameter :: names(8) = [character(3) :: 'xl', 'yl', 'xr', 'yr', 'vxl', 'vyl', 'vxr', 'vyr']
      real(wp), parameter :: expected(8) = [0.4934557842755629e-1_wp, 0.4969894602303324_wp, 0.1041742524885400e1_wp, &
         & 0.3739110272652214_wp, -0.7705836840321485e-1_wp, 0.7446866596327776e-2_wp, 0.1755681574942899e-1_wp, &
         & 0.7703410437794031_wp]
      type(history_reader_type) :: reader
      character(40) :: new(2)
      real(wp), allocatable :: values(:)
      integer :: i
      new(1) = 'TOLERANCE='//tolerance
      new(2) = 'INTEGRATOR='//integrator
      call run_changed('../input/car_axis.inp', trim(results), [character(40) :: 'TOLERANCE=1e-9', 'INTEGRATOR=ADAMS'], new, &
         & reader)
      do i = 1, size(names)
         allocate (values, source=channel(reader, trim(names(i))))
         print '(5a,es10.2)', 'car axis, ', integrator, ': ', names(i), ' off by', values(size(values)) - expected(i)
         call check_close(values(size(values)), expected(i), allowed, 'car axis, '//integrator//': '//names(i))
         deallocate (values)
      end do
      allocate (values, source=channel(reader, 'balance'))
      call check_close(maxval(abs(values - values(1))), 0.0_wp, 1.0e-9_wp*1.2e-3_wp, 'car axis, '//integrator//': energy')
      deallocate (values)
      call reader%close()
   end subroutine check_car_axis

   !> One mode under a force from rest: 1 - exp(-z w t) (cos w_d t + z w/w_d sin w_d t) of the deflection at rest, with the
   !> frequency of a cantilever of 16 elements with lumped masses.
   subroutine check_damping(integrator, tolerance, allowed)
      character(*), intent(in) :: integrator, tolerance
      real(wp), intent(in) :: allowed
      real(wp), parameter :: ei = 2.0e11_wp*0.04_wp*0.004_wp**3/12, rho_a = 7870*0.04_wp*0.004_wp, length = 2.0_wp
      type(history_reader_type) :: reader
      character(60) :: new(1)
      real(wp) :: w
      new(1) = 'TOLERANCE='//tolerance//', OUTPUTS=80, INTEGRATOR='//integrator
      call run_changed('verification/damping.inp', trim(results), [character(60) :: &
         & 'TOLERANCE=1e-10, OUTPUTS=80, INTEGRATOR=ADAMS'], new, reader)
      w = 3.5097247_wp/length**2*sqrt(ei/rho_a)
      call compare_response(reader, integrator, allowed, 'a', w, 0.05_wp)
      call compare_response(reader, integrator, allowed, 'b', w, 0.5_wp*(0.2_wp/w + 4.0e-3_wp*w))
      call reader%close()
   end subroutine check_damping

   !> A channel against the response to a force that begins, in units of the deflection at rest.
   subroutine compare_response(reader, label, allowed, name, w, ratio)
      type(history_reader_type), intent(in) :: reader
      character(*), intent(in) :: label, name
      !> Relative error; circular frequency and part of the critical damping
      real(wp), intent(in) :: allowed, w, ratio
      real(wp), allocatable :: values(:)
      real(wp) :: t(0:80), shape(0:80), level, damped
      integer :: i
      t = [(0.1_wp*i, i=0, 80)]
      damped = w*sqrt(1 - ratio**2)
      shape = 1 - exp(-ratio*w*t)*(cos(damped*t) + ratio*w/damped*sin(damped*t))
      allocate (values, source=channel(reader, name))
      level = dot_product(values, shape)/dot_product(shape, shape)
      print '(5a,es10.2)', 'damping, ', label, ': ', name, ' off by', maxval(abs(values/level - shape))
      call check_close(maxval(abs(values/level - shape)), 0.0_wp, allowed, 'damping, '//label//': '//name)
      deallocate (values)
   end subroutine compare_response

   !> Deflections, slope, force and moment of clamped beams in textbook form.
   subroutine check_distributed()
      real(wp), parameter :: ei = 2.0e11_wp*0.04_wp*0.004_wp**3/12, q = 0.5_wp, l = 2.0_wp, a = 0.5_wp*l
      type(history_reader_type) :: reader
      call run_changed('../input/distributed_load.inp', trim(results), [character(4) :: 'q = '], [character(4) :: 'q = '], reader)
      call last(reader, 'uniform', -q*l**4/(8*ei), 1.0e-5_wp)
      call last(reader, 'slope', -q*l**3/(6*ei), 1.0e-4_wp)
      call last(reader, 'triangular', -11*q*l**4/(120*ei), 1.0e-5_wp)
      ! The load turns with the sections, whose slopes of 0.014 take a ten-thousandth of it: the formulas are those of small ones
      call last(reader, 'upright', -q*(l**4/8 - (a**4/8 + a**3*(l - a)/6))/ei, 1.2e-4_wp)
      call last(reader, 'force_y_a', q*l, 1.0e-9_wp)
      call last(reader, 'torque_clamp_a', q*l**2/2, 1.0e-9_wp)
      call last(reader, 'force_y_b', q*l/2, 1.0e-9_wp)
      call last(reader, 'torque_clamp_b', q*l**2/3, 1.0e-9_wp)
      call last(reader, 'force_x_c', -q*a, 1.2e-4_wp)
      call last(reader, 'torque_clamp_c', q*a*1.5_wp*a, 1.2e-4_wp)
      call reader%close()
   end subroutine check_distributed

   !> The last value of a channel, relative to what is expected.
   subroutine last(reader, name, expected, allowed)
      type(history_reader_type), intent(in) :: reader
      character(*), intent(in) :: name
      real(wp), intent(in) :: expected, allowed
      real(wp), allocatable :: values(:)
      allocate (values, source=channel(reader, name))
      call check_close(values(size(values))/expected, 1.0_wp, allowed, 'distributed load: '//name)
      deallocate (values)
   end subroutine last

end program test_forces
