!> Rigid stops, *STOP with LAW=RIGID, by all integrators, against closed forms and event-driven references: a ball whose bounces
!> accumulate, one that loses nothing, a bar on a limit of its joint, a block that rocks, a cam and its follower, two discs, balls
!> in a row, a ball in a corner, a bead that leaves a circle, a table on three supports, walls on a line and on a table, an elbow;
!> work and energies; what is refused.
!> Usage, in tests/: test_rigid_stops RESULT_FILE
program test_rigid_stops
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_output_history_reader, only: history_reader_type
   use runs, only: numbers, run_text, run_changed, channel
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   character(*), parameter :: nl = new_line('a')
   character(*), parameter :: integrators(4) = [character(10) :: 'ADAMS', 'RADAU', 'ALPHA', 'CONSERVING']
   character(*), parameter :: tolerances(3) = [character(5) :: '1e-6', '1e-9', '1e-11']
   real(wp), parameter :: g = 9.81_wp, pi = acos(-1.0_wp)
   character(256) :: results
   character(5) :: tolerance
   integer :: i, k

   call get_command_argument(1, results)
   do i = 1, size(integrators)
      do k = 1, merge(2, 3, is_rough(integrators(i)))
         tolerance = tolerances(k)
         call check_ball(trim(integrators(i)))
         call check_pendulum(trim(integrators(i)))
         call check_block(trim(integrators(i)))
         call check_cam(trim(integrators(i)))
         call check_discs(trim(integrators(i)))
         call check_row(trim(integrators(i)), '1', [-1.0_wp, 2.0_wp, 2.0_wp]/3)
         call check_row(trim(integrators(i)), '0', [1.0_wp, 1.0_wp, 1.0_wp]/3)
         call check_corner(trim(integrators(i)))
         call check_bead(trim(integrators(i)))
         call check_table(trim(integrators(i)))
         call check_jump(trim(integrators(i)))
         call check_walls(trim(integrators(i)))
         call check_turning_wall(trim(integrators(i)))
         call check_elbow(trim(integrators(i)), 'YES')
         call check_elbow(trim(integrators(i)), 'NO')
      end do
   end do
   call check_refusals()
   call check_elastic('1e-6', 1.0e-5_wp, 1.0e-4_wp)
   call check_elastic('1e-9', 1.0e-9_wp, 1.0e-8_wp)
   tolerance = '1e-6'
   do i = 1, size(integrators)
      call check_many('0.99', trim(integrators(i)))
      call check_many('0.997', trim(integrators(i)))
   end do
   call check_energy('a driven table', '*POINT MASS, NAME=tab, MASS=1, VY=0.5'//nl//rail('jt', 'tab')// &
      & '*DRIVER, NAME=m, TYPE=DISPLACEMENT, JOINT=jt'//nl//' 0.5*t'//nl//'*POINT MASS, NAME=b, MASS=1, Y=1, VY=-1'//nl// &
      & rail('jb', 'b')//'*STOP, NAME=s, AXIS=90 deg, LEAST=0, LAW=RIGID, RESTITUTION=0.5'//nl//' b, tab'//nl, 9/32.0_wp)
   call check_energy('a start on the limit', '*GRAVITY, X=0, Y=-9.81'//nl//'*POINT MASS, NAME=b, MASS=1, Y=1, VY=-2'//nl// &
      & '*STOP, NAME=s, AXIS=90 deg, LAW=RIGID, LEAST=1, RESTITUTION=0.5'//nl//' b, ground.origin'//nl, -2.0_wp)
   call finish()

contains

   !> Whether an integrator is of order two.
   pure logical function is_rough(integrator)
      character(*), intent(in) :: integrator
      is_rough = integrator == 'ALPHA' .or. integrator == 'CONSERVING'
   end function is_rough

   !> Error that an integrator is allowed: the default and the tight one of the reference, at 1e-9 ten times the tight one; of order
   !> two, the error of a result.
   real(wp) function bound(integrator, default, tight)
      character(*), intent(in) :: integrator
      !> At 1e-6 and 1e-11
      real(wp), intent(in) :: default, tight
      bound = default
      if (tolerance == '1e-9') bound = 10*tight
      if (tolerance == '1e-11') bound = tight
      if (is_rough(integrator)) bound = max(bound, merge(1.0e-5_wp, 1.0e-3_wp, tolerance == '1e-9'))
   end function bound

   !> A ball falls by 1 m, restitution 0.8: impacts, accumulation at 9 times the first instant, rest. Closed form.
   subroutine check_ball(integrator)
      character(*), intent(in) :: integrator
      real(wp), parameter :: e = 0.8_wp
      real(wp), allocatable :: t(:), y(:), energy(:), impulse(:), turned(:)
      type(history_reader_type) :: reader
      character(:), allocatable :: name
      real(wp) :: first, at
      integer :: n, j
      name = integrator//', '//trim(tolerance)//': ball, '
      call run_scene('*GRAVITY, X=0, Y=-9.81'//nl//'*POINT MASS, NAME=b, MASS=1, Y=1'//nl// &
         & '*STOP, NAME=floor, AXIS=90 deg, LEAST=0, LAW=RIGID, RESTITUTION=0.8'//nl//' b, ground.origin'//nl, integrator, &
         & 'END=5, OUTPUTS=250', ' y(b), tension(floor), elongation(floor), closed(floor), lost(floor), '// &
         & 'w = work(system), e = kinetic_energy(system) + potential_energy(system)', reader)
      first = sqrt(2/g)
      t = numbers(reader, '/events/time')
      energy = numbers(reader, '/events/energy')
      impulse = numbers(reader, '/events/impulse')
      turned = numbers(reader, '/events/turned')
      n = size(t)
      call check(n > 30, name//'impacts')
      do j = 1, 30
         at = first + 2*first*e*(1 - e**(j - 1))/(1 - e)
         call check_close(t(j), at, 1.0e-10_wp, name//'instant of an impact')
         call check_close(impulse(j), (1 + e)*g*first*e**(j - 1), 1.0e-9_wp, name//'impulse')
      end do
      call check(nint(turned(n)) == 1 .and. count(nint(turned) /= 0) == 1, name//'rests at last')
      call check_close(t(n), 9*first, 1.0e-10_wp, name//'end of the bounces')
      call check_close(sum(energy), -g, 1.0e-9_wp*g, name//'energy lost')
      y = channel(reader, 'y_b')
      do j = 0, 250
         call check_close(y(j + 1), height_of(0.02_wp*j, first, e), 1.0e-9_wp, name//'height')
      end do
      call check(all(y >= -1.0e-12_wp), name//'never below the floor')
      call reader%close()
   end subroutine check_ball

   !> Height of the ball at a time: falls from 1 m, impacts at t1 (1 + 2 (e + ... + e^k)), rest behind the last.
   pure real(wp) function height_of(t, first, e) result(height)
      !> Time, instant of the first impact; restitution
      real(wp), intent(in) :: t, first, e
      real(wp) :: impact, flight
      integer :: k
      height = 1 - 0.5_wp*g*t**2
      if (t < first) return
      height = 0.0_wp
      impact = first
      do k = 1, 1000
         flight = 2*first*e**k
         if (t < impact + flight) height = 0.5_wp*g*(t - impact)*(impact + flight - t)
         if (t < impact + flight) return
         impact = impact + flight
      end do
   end function height_of

   !> A ball that loses nothing in 1107 impacts.
   subroutine check_elastic(given, before, at_end)
      character(*), intent(in) :: given
      !> Errors allowed at 10 s and 100 s, at 1000 s
      real(wp), intent(in) :: before, at_end
      real(wp), allocatable :: y(:)
      type(history_reader_type) :: reader
      integer :: j
      tolerance = given
      do j = 1, 2
         call run_scene('*GRAVITY, X=0, Y=-9.81'//nl//'*POINT MASS, NAME=b, MASS=1, Y=1'//nl// &
            & '*STOP, NAME=floor, AXIS=90 deg, LEAST=0, LAW=RIGID, RESTITUTION=1'//nl//' b, ground.origin'//nl, &
            & trim(integrators(j)), 'END=1000, OUTPUTS=100', ' y(b)', reader)
         y = channel(reader, 'y_b')
         call check(size(numbers(reader, '/events/time')) == 1107, trim(integrators(j))//': 1107 impacts')
         call check_close(y(2), 0.978321975404438_wp, before, trim(integrators(j))//', '//trim(tolerance)//': ball at 10 s')
         call check_close(y(11), 0.7215811544478331_wp, before, trim(integrators(j))//', '//trim(tolerance)//': ball at 100 s')
         call check_close(y(101), 0.47660702466227467_wp, at_end, trim(integrators(j))//', '//trim(tolerance)//': ball at 1000 s')
         call reader%close()
      end do
   end subroutine check_elastic

   !> A bar on a pin falls from the horizontal onto a limit of 0.2 rad from below, restitution 0.6. Reference: DOP853 from impact to
   !> impact, 1.4e-12.
   subroutine check_pendulum(integrator)
      character(*), intent(in) :: integrator
      real(wp), parameter :: impacts(10) = [0.44634320506802405_wp, 1.186209247510043_wp, 1.8238928797516403_wp, &
         & 2.3449357314374146_wp, 2.7324798954227227_wp, 2.994306768261866_wp, 3.1600384191637416_wp, 3.2616141341552414_wp, &
         & 3.323046327365764_wp, 3.3600128875320796_wp], speed = 5.370601398900152_wp
      real(wp), allocatable :: t(:), impulse(:), turned(:), torque(:), energy(:)
      type(history_reader_type) :: reader
      character(:), allocatable :: name
      real(wp) :: allowed
      integer :: j, n
      name = integrator//', '//trim(tolerance)//': pendulum, '
      allowed = bound(integrator, 1.0e-5_wp, 1.0e-9_wp)
      call run_scene('*GRAVITY, X=0, Y=-9.81'//nl//'*RIGID BODY, NAME=bar, MASS=1, INERTIA=1/12, CENTRE X=0.5'//nl// &
         & '*JOINT, NAME=pin, TYPE=REVOLUTE'//nl//' bar.origin, ground.origin'//nl// &
         & '*STOP, NAME=limit, JOINT=pin, LEAST=0.2 - pi/2, LAW=RIGID, RESTITUTION=0.6'//nl, integrator, 'END=4, OUTPUTS=40', &
         & ' angle(bar), torque(limit)', reader)
      t = numbers(reader, '/events/time')
      impulse = numbers(reader, '/events/impulse')
      energy = numbers(reader, '/events/energy')
      turned = numbers(reader, '/events/turned')
      n = size(t)
      call check(n > 10, name//'impacts')
      do j = 1, min(n, size(impacts))
         call check_close(t(j), impacts(j), allowed, name//'instant of an impact')
         call check_close(impulse(j), 1.6_wp*speed*0.6_wp**(j - 1)/3, 2*allowed, name//'impulse')
         call check_close(energy(j), -0.64_wp*(speed*0.6_wp**(j - 1))**2/6, 5*allowed, name//'energy lost')
      end do
      call check(nint(turned(n)) == 1, name//'rests at last')
      call check_close(t(n), 3.41553717566883_wp, allowed, name//'end of the bounces')
      torque = channel(reader, 'torque_limit')
      call check_close(torque(size(torque)), 0.9744730675497754_wp, 1.0e-6_wp*allowed/1.0e-5_wp, name//'torque at rest')
      call reader%close()
   end subroutine check_pendulum

   !> A block of 0.3 m by 1.2 m rocks on its corners without slip: the law of Housner. Reference: DOP853 from impact to impact,
   !> 1e-12.
   subroutine check_block(integrator)
      character(*), intent(in) :: integrator
      real(wp), parameter :: impacts(8) = [0.3824983256607996_wp, 1.005016124072705_wp, 1.5332296223940336_wp, &
         & 1.9912717962182003_wp, 2.3937740611486964_wp, 2.750622978516353_wp, 3.068987117338761_wp, 3.354328241765731_wp], &
         & peaks(8) = [-0.09473679312081613_wp, 0.07506069800657408_wp, -0.06027883112723988_wp, 0.04882768844371006_wp, &
         & -0.03978817391458201_wp, 0.032562171068248255_wp, -0.026734475495142455_wp, 0.022003938834686605_wp]
      real(wp), allocatable :: t(:), which(:), angle(:), turned(:), lost(:), energy(:)
      character(60) :: changed(2)
      type(history_reader_type) :: reader
      character(:), allocatable :: name
      real(wp) :: allowed
      name = integrator//', '//trim(tolerance)//': block, '
      allowed = bound(integrator, 1.0e-4_wp, 1.0e-8_wp)
      changed = [character(60) :: 'TOLERANCE=', 'INTEGRATOR=']
      changed(1) = trim(changed(1))//tolerance
      changed(2) = trim(changed(2))//integrator
      call run_changed('../input/rocking_block.inp', trim(results), [character(60) :: 'TOLERANCE=1e-9', 'INTEGRATOR=RADAU'], &
         & changed, reader)
      t = numbers(reader, '/events/time')
      which = numbers(reader, '/events/event')
      turned = numbers(reader, '/events/turned')
      angle = numbers(reader, '/events/channels/angle_block')
      call check(count(nint(which) >= 4 .and. nint(turned) == 1) == 9, name//'rests at the start and behind eight impacts')
      if (count(nint(which) <= 2) < 8 .or. count(nint(which) == 3) < 8) return
      call check_all(pack(t, nint(which) <= 2), impacts, allowed, name//'instant of an impact')
      call check_all(pack(angle, nint(which) == 3), peaks, allowed, name//'largest angle')
      lost = channel(reader, 'loss')
      energy = channel(reader, 'energy')
      call check_close(energy(1) - energy(size(energy)), lost(size(lost)), max(1.0e-9_wp*lost(size(lost)), 10*allowed), &
         & name//'energy lost')
      call reader%close()
   end subroutine check_block

   !> An eccentric of 20 mm lifts a follower. At 150 rad/s it stays; at 250 rad/s it leaves, and lands with restitution 0 or 0.4.
   !> Reference: DOP853 from impact to impact, 6e-15.
   subroutine check_cam(integrator)
      character(*), intent(in) :: integrator
      real(wp), parameter :: leaves = 0.0015633045223017667_wp, period = 2*pi/250
      real(wp), parameter :: landings(6) = [0.021324419722148623_wp, 0.04597798456441011_wp, 0.07044223666958996_wp, &
         & 0.07584342195899517_wp, 0.09730121920497548_wp, 0.12224616569277195_wp], impulses(6) = [0.6369238363684152_wp, &
         & 0.6283582690607991_wp, 0.5362382332852959_wp, 0.14201190321860838_wp, 0.7100505214388317_wp, 0.7573184222744047_wp]
      real(wp), allocatable :: t(:), turned(:), impulse(:), pull(:)
      type(history_reader_type) :: reader
      character(:), allocatable :: name
      real(wp) :: allowed
      name = integrator//', '//trim(tolerance)//': cam, '
      allowed = bound(integrator, 1.0e-5_wp, 1.0e-9_wp)
      call run_cam(integrator, '150', '0', '2*pi/speed, OUTPUTS=40', reader)
      pull = channel(reader, 'tension_face')
      call check_close(minval(pull), 7.5_wp, 100*allowed, name//'least force')
      call check_close(maxval(pull), 32.5_wp, 100*allowed, name//'largest force')
      call check(size(numbers(reader, '/events/time')) == 1, name//'stays on at 150 rad/s')
      call reader%close()
      call run_cam(integrator, '250', '0', '0.1, OUTPUTS=40', reader)
      t = numbers(reader, '/events/time')
      turned = numbers(reader, '/events/turned')
      impulse = numbers(reader, '/events/impulse')
      call check_all(pack(t, nint(turned) < 0), leaves + period*[0, 1, 2, 3], allowed, name//'instant at which it leaves')
      t = pack(t, impulse > 0.0_wp)
      call check_all(t, 0.021324419722148623_wp + period*[0, 1, 2, 3], allowed, name//'landing without a rebound')
      call check_all(pack(impulse, impulse > 0.0_wp), 0.454945597406011_wp*[1, 1, 1, 1], allowed, name//'impulse without a rebound')
      call reader%close()
      call run_cam(integrator, '250', '0.4', '0.13, OUTPUTS=40', reader)
      t = numbers(reader, '/events/time')
      impulse = numbers(reader, '/events/impulse')
      ! Between the fourth and the fifth its bounces end on the cam
      call check_all(pack(t, impulse > 0.1_wp), landings, 10*allowed, name//'landing with a rebound')
      call check_all(pack(impulse, impulse > 0.1_wp), impulses, 100*allowed, name//'impulse with a rebound')
      call reader%close()
   end subroutine check_cam

   subroutine run_cam(integrator, speed, restitution, time, reader)
      character(*), intent(in) :: integrator, speed, restitution, time
      type(history_reader_type), intent(out) :: reader
      call run_scene('*PARAMETER'//nl//' speed = '//speed//', ecc = 0.005, base = 0.02'//nl// &
         & '*RIGID BODY, NAME=cam, MASS=1, INERTIA=1e-3'//nl//' middle, ecc, 0'//nl// &
         & '*JOINT, NAME=shaft, TYPE=REVOLUTE'//nl//' cam.origin, ground.origin'//nl// &
         & '*DRIVER, NAME=motor, TYPE=ANGLE, BODY=cam'//nl//' speed*t'//nl// &
         & '*RIGID BODY, NAME=follower, MASS=0.2, INERTIA=1e-4, Y=base, VY=speed*ecc'//nl// &
         & '*JOINT, NAME=guide, TYPE=TRANSLATIONAL, ANGLE=90 deg'//nl//' follower.origin, ground.origin'//nl// &
         & '*FORCE, NAME=spring, POINT=follower.origin'//nl//' 0, -20 - 2000*(y(follower.origin) - base)'//nl// &
         & '*STOP, NAME=face, AXIS=90 deg, MOST=-base, LAW=RIGID, RESTITUTION='//restitution//nl// &
         & ' cam.middle, follower.origin'//nl, integrator, 'END='//time, ' y(follower.origin), tension(face)', reader)
   end subroutine run_cam

   !> Two discs without friction: the impulse along the line of their centres. Closed form.
   subroutine check_discs(integrator)
      character(*), intent(in) :: integrator
      real(wp), parameter :: y = 0.1_wp, sum_of_radii = 0.25_wp
      real(wp), allocatable :: t(:), impulse(:), v(:)
      type(history_reader_type) :: reader
      character(:), allocatable :: name
      real(wp) :: normal(2), p
      name = integrator//', '//trim(tolerance)//': discs, '
      call run_scene('*RIGID BODY, NAME=a, MASS=1, INERTIA=0.005, X=-1, Y=0.1, VX=2'//nl// &
         & '*RIGID BODY, NAME=b, MASS=2, INERTIA=0.0225'//nl// &
         & '*STOP, NAME=contact, LEAST=0.1 + 0.15, LAW=RIGID, RESTITUTION=0.8'//nl//' a.origin, b.origin'//nl, integrator, &
         & 'END=1, OUTPUTS=10', ' x(a.origin), vx(a.origin), vy(a.origin), vx(b.origin), vy(b.origin)', reader)
      t = numbers(reader, '/events/time')
      impulse = numbers(reader, '/events/impulse')
      normal = [sqrt(sum_of_radii**2 - y**2), -y]/sum_of_radii
      p = 1.8_wp*2*normal(1)/(1 + 0.5_wp)
      call check_all(t, [0.385435607626104_wp], 1.0e-11_wp, name//'instant')
      call check_all(impulse, [2.199636333578803_wp], 1.0e-11_wp, name//'impulse')
      v = channel(reader, 'vx_a_origin')
      call check_close(v(size(v)), 2 - p*normal(1), 1.0e-11_wp, name//'vx of the first')
      v = channel(reader, 'vy_a_origin')
      call check_close(v(size(v)), -p*normal(2), 1.0e-11_wp, name//'vy of the first')
      v = channel(reader, 'vx_b_origin')
      call check_close(v(size(v)), 0.5_wp*p*normal(1), 1.0e-11_wp, name//'vx of the second')
      v = channel(reader, 'vy_b_origin')
      call check_close(v(size(v)), 0.5_wp*p*normal(2), 1.0e-11_wp, name//'vy of the second')
      call reader%close()
   end subroutine check_discs

   !> A ball strikes the first of two that touch: Newton's law for both contacts at once.
   subroutine check_row(integrator, restitution, speeds)
      character(*), intent(in) :: integrator, restitution
      !> Behind the impact, relative to the speed of the first
      real(wp), intent(in) :: speeds(3)
      real(wp), allocatable :: v(:)
      type(history_reader_type) :: reader
      character(:), allocatable :: name
      name = integrator//', '//trim(tolerance)//': balls in a row, restitution '//restitution
      call run_scene('*POINT MASS, NAME=a, MASS=1, X=-1, VX=3'//nl//'*POINT MASS, NAME=b, MASS=1'//nl// &
         & '*POINT MASS, NAME=c, MASS=1, X=0.2'//nl// &
         & '*STOP, NAME=ab, AXIS=0, LEAST=0.2, LAW=RIGID, RESTITUTION='//restitution//nl// &
         & ' b, a'//nl//'*STOP, NAME=bc, AXIS=0, LEAST=0.2, LAW=RIGID, RESTITUTION='//restitution//nl//' c, b'//nl, &
         & integrator, 'END=0.5, OUTPUTS=5', ' vx(a), vx(b), vx(c)', reader)
      v = channel(reader, 'vx_a')
      call check_close(v(size(v)), 3*speeds(1), 1.0e-11_wp, name//', first')
      v = channel(reader, 'vx_b')
      call check_close(v(size(v)), 3*speeds(2), 1.0e-11_wp, name//', second')
      v = channel(reader, 'vx_c')
      call check_close(v(size(v)), 3*speeds(3), 1.0e-11_wp, name//', third')
      call reader%close()
   end subroutine check_row

   !> A ball meets two walls at the same instant, restitution 0.5 and 0.25.
   subroutine check_corner(integrator)
      character(*), intent(in) :: integrator
      real(wp), allocatable :: t(:), v(:), energy(:)
      type(history_reader_type) :: reader
      character(:), allocatable :: name
      name = integrator//', '//trim(tolerance)//': corner, '
      call run_scene('*POINT MASS, NAME=b, MASS=2, X=1, Y=2, VX=-1, VY=-2'//nl// &
         & '*STOP, NAME=wall, AXIS=0, LEAST=0, LAW=RIGID, RESTITUTION=0.5'//nl//' b, ground.origin'//nl// &
         & '*STOP, NAME=floor, AXIS=90 deg, LEAST=0, LAW=RIGID, RESTITUTION=0.25'//nl//' b, ground.origin'//nl, integrator, &
         & 'END=2, OUTPUTS=4', ' vx(b), vy(b), w = work(system)', reader)
      t = numbers(reader, '/events/time')
      energy = numbers(reader, '/events/energy')
      call check_all(t, [1.0_wp, 1.0_wp], 1.0e-10_wp, name//'instant')
      call check_close(sum(energy), -0.75_wp - 3.75_wp, 1.0e-9_wp, name//'energy lost')
      v = channel(reader, 'vx_b')
      call check_close(v(size(v)), 0.5_wp, 1.0e-11_wp, name//'vx')
      v = channel(reader, 'vy_b')
      call check_close(v(size(v)), 0.5_wp, 1.0e-11_wp, name//'vy')
      v = channel(reader, 'w')
      call check_close(v(size(v)), -4.5_wp, 1.0e-9_wp, name//'work')
      call reader%close()
   end subroutine check_corner

   !> A bead of 1 m/s on top of a circle of 1 m leaves it at the cosine 2/3 + v^2/(3 g r). Closed form.
   subroutine check_bead(integrator)
      character(*), intent(in) :: integrator
      real(wp), allocatable :: t(:), turned(:), y(:), pull(:), x(:)
      type(history_reader_type) :: reader
      character(:), allocatable :: name
      real(wp) :: height, allowed, speed, since
      name = integrator//', '//trim(tolerance)//': bead, '
      allowed = bound(integrator, 1.0e-4_wp, 1.0e-7_wp)
      height = 2.0_wp/3 + 1/(3*g)
      call run_scene('*GRAVITY, X=0, Y=-9.81'//nl//'*POINT MASS, NAME=b, MASS=2, Y=1, VX=1'//nl// &
         & '*STOP, NAME=circle, LEAST=1, LAW=RIGID'//nl//' b, ground.origin'//nl, integrator, 'END=0.8, OUTPUTS=80', &
         & ' x(b), y(b), tension(circle)', reader)
      t = numbers(reader, '/events/time')
      turned = numbers(reader, '/events/turned')
      y = numbers(reader, '/events/channels/y_b')
      x = numbers(reader, '/events/channels/x_b')
      call check(size(t) == 2, name//'rests at the start, and leaves once')
      if (size(t) /= 2) return
      call check(all(nint(turned) == [1, -1]), name//'closed at the start, and opens')
      call check_close(y(2), height, allowed, name//'height where it leaves')
      speed = sqrt(g*height)
      pull = channel(reader, 'tension_circle')
      call check_close(pull(1), -2*(g - 1), allowed, name//'force on top')
      call check(all(pull <= 1.0e-6_wp), name//'it never pulls')
      y = channel(reader, 'y_b')
      since = 0.8_wp - t(2)
      call check_close(y(81), height - speed*sqrt(1 - height**2)*since - 0.5_wp*g*since**2, 10*allowed, &
         & name//'height of the flight')
      call reader%close()
   end subroutine check_bead

   !> A table falls on three supports, of which one more than needed, and rests: the forces carry its weight and balance its moment.
   subroutine check_table(integrator)
      character(*), intent(in) :: integrator
      real(wp), allocatable :: a(:), b(:), c(:), y(:), energy(:)
      type(history_reader_type) :: reader
      character(:), allocatable :: name
      integer :: n
      name = integrator//', '//trim(tolerance)//': table, '
      call run_scene('*GRAVITY, X=0, Y=-9.81'//nl//'*RIGID BODY, NAME=table, MASS=3, INERTIA=1, Y=0.1, CENTRE X=0.1'//nl// &
         & ' left, -1, 0'//nl//' right, 1, 0'//nl// &
         & '*JOINT, NAME=guide, TYPE=POINT ON LINE, ANGLE=90 deg'//nl//' table.origin, ground.origin'//nl// &
         & '*STOP, NAME=a, AXIS=90 deg, LEAST=0, LAW=RIGID'//nl//' table.left, ground.origin'//nl// &
         & '*STOP, NAME=b, AXIS=90 deg, LEAST=0, LAW=RIGID'//nl//' table.origin, ground.origin'//nl// &
         & '*STOP, NAME=c, AXIS=90 deg, LEAST=0, LAW=RIGID'//nl//' table.right, ground.origin'//nl, integrator, &
         & 'END=1, OUTPUTS=10', ' y(table.origin), angle(table), tension(a), tension(b), tension(c)', reader)
      a = channel(reader, 'tension_a')
      b = channel(reader, 'tension_b')
      c = channel(reader, 'tension_c')
      y = channel(reader, 'y_table_origin')
      energy = numbers(reader, '/events/energy')
      n = size(a)
      call check_close(sum(energy), -3*g*0.1_wp, 1.0e-9_wp, name//'energy lost')
      call check_close(y(n), 0.0_wp, 1.0e-10_wp, name//'rests')
      call check_close(a(n) + b(n) + c(n), -3*g, 1.0e-7_wp, name//'forces carry the weight')
      call check_close(c(n) - a(n), -0.3_wp*g, 1.0e-7_wp, name//'forces balance the moment')
      call check(max(a(n), b(n), c(n)) <= 0.0_wp, name//'all push')
      call reader%close()
   end subroutine check_table

   !> A ball rests on the floor; a force of 20 N lifts it from 1 s on. At the sample there the floor does not pull.
   subroutine check_jump(integrator)
      character(*), intent(in) :: integrator
      real(wp), allocatable :: t(:), turned(:), pull(:), y(:), closed(:)
      type(history_reader_type) :: reader
      character(:), allocatable :: name
      name = integrator//', '//trim(tolerance)//': jump, '
      call run_scene('*GRAVITY, X=0, Y=-9.81'//nl//'*POINT MASS, NAME=b, MASS=1, Y=1'//nl// &
         & '*STOP, NAME=floor, AXIS=90 deg, LEAST=1, LAW=RIGID'//nl//' b, ground.origin'//nl// &
         & '*FORCE, NAME=lift, POINT=b'//nl//' 0, 20*step(t - 1)'//nl, integrator, 'END=2, OUTPUTS=20', &
         & ' y(b), tension(floor), closed(floor)', reader)
      t = numbers(reader, '/events/time')
      turned = numbers(reader, '/events/turned')
      call check_all(t, [0.0_wp, 1.0_wp], 1.0e-12_wp, name//'rests, and opens')
      call check(all(nint(turned) == [1, -1]), name//'rests, and opens once')
      y = channel(reader, 'y_b')
      pull = channel(reader, 'tension_floor')
      closed = channel(reader, 'closed_floor')
      call check_close(maxval(abs(pull(:10) + g)), 0.0_wp, 1.0e-9_wp, name//'force at rest')
      call check_close(maxval(abs(pull(11:))), 0.0_wp, 0.0_wp, name//'no force behind')
      call check(all(nint(closed(:10)) == 1) .and. all(nint(closed(11:)) == 0), name//'state')
      call check_close(y(21), 1 + 0.5_wp*(20 - g), 1.0e-9_wp, name//'height at the end')
      call reader%close()
   end subroutine check_jump

   !> A mass on an inclined line between two walls that lose nothing: a zigzag.
   subroutine check_walls(integrator)
      character(*), intent(in) :: integrator
      real(wp), allocatable :: u(:), t(:), which(:)
      type(history_reader_type) :: reader
      character(:), allocatable :: name
      integer :: j
      name = integrator//', '//trim(tolerance)//': walls, '
      call run_scene('*RIGID BODY, NAME=b, MASS=2, INERTIA=1, VX=3*cos(0.5), VY=3*sin(0.5)'//nl// &
         & '*JOINT, NAME=rail, TYPE=TRANSLATIONAL, ANGLE=0.5'//nl//' b.origin, ground.origin'//nl// &
         & '*STOP, NAME=ends, JOINT=rail, LEAST=-1, MOST=0.5, LAW=RIGID, RESTITUTION=1'//nl, integrator, 'END=20, OUTPUTS=50', &
         & ' displacement(rail), lost(ends)', reader)
      u = channel(reader, 'displacement_rail')
      do j = 0, 50
         ! Way from the lower wall, there and back
         call check_close(u(j + 1), 0.5_wp - abs(modulo(1 + 3*0.4_wp*j, 3.0_wp) - 1.5_wp), 1.0e-9_wp, name//'place')
      end do
      t = numbers(reader, '/events/time')
      which = numbers(reader, '/events/event')
      call check(size(t) == 40, name//'forty impacts')
      call check(count(nint(which) == 1) == 20, name//'half of them at the lower wall')
      u = channel(reader, 'lost_ends')
      call check_close(u(51), 0.0_wp, 1.0e-12_wp, name//'nothing is lost')
      call reader%close()
   end subroutine check_walls

   !> A mass in a slot of a table at 5 rad/s rests against the outer wall, which pushes by m w^2 r; thrown inwards it returns there.
   subroutine check_turning_wall(integrator)
      character(*), intent(in) :: integrator
      real(wp), parameter :: speed = 5.0_wp, place = 0.5_wp, inwards = 1.0_wp
      real(wp), allocatable :: u(:), force(:), t(:), turned(:)
      type(history_reader_type) :: reader
      character(:), allocatable :: name
      real(wp) :: back, allowed
      name = integrator//', '//trim(tolerance)//': turning wall, '
      allowed = bound(integrator, 1.0e-5_wp, 1.0e-9_wp)
      call run_scene('*RIGID BODY, NAME=table, MASS=1, INERTIA=1'//nl//'*JOINT, NAME=hub, TYPE=REVOLUTE'//nl// &
         & ' table.origin, ground.origin'//nl//'*DRIVER, NAME=motor, TYPE=ANGLE, BODY=table'//nl//' 5*t'//nl// &
         & '*POINT MASS, NAME=b, MASS=2, X=0.5*cos(0.4), Y=0.5*sin(0.4), VX=-2.5*sin(0.4) - cos(0.4), '// &
         & 'VY=2.5*cos(0.4) - sin(0.4)'//nl//'*JOINT, NAME=slot, TYPE=POINT ON LINE, ANGLE=0.4'//nl//' b, table.origin'//nl// &
         & '*STOP, NAME=wall, AXIS=0.4, MOST=0.5, LAW=RIGID'//nl//' b, table.origin'//nl, integrator, 'END=1, OUTPUTS=10', &
         & ' displacement(slot), tension(wall)', reader)
      ! u'' = w^2 u: place cosh(w t) - inwards/w sinh(w t) = place again
      back = 2*atanh(inwards/(speed*place))/speed
      t = numbers(reader, '/events/time')
      turned = numbers(reader, '/events/turned')
      call check_all(t, [back], allowed, name//'instant of the return')
      call check(all(nint(turned) == 1), name//'rests')
      u = channel(reader, 'displacement_slot')
      force = channel(reader, 'tension_wall')
      call check_close(u(11), place, 1.0e-8_wp, name//'place')
      call check_close(force(11), 2*speed**2*place, 1.0e-6_wp, name//'force')
      call reader%close()
   end subroutine check_turning_wall

   !> A double pendulum whose elbow bends one way only, from -0.1 rad: impacts through the joints keep the balance of energies. Both
   !> forms of the equations, with the tree of bodies and without.
   subroutine check_elbow(integrator, elimination)
      character(*), intent(in) :: integrator, elimination
      real(wp), allocatable :: balance(:), bend(:), lost(:), energy(:), impulse(:), w(:)
      type(history_reader_type) :: reader
      character(:), allocatable :: name
      real(wp) :: allowed
      name = integrator//', '//trim(tolerance)//': elbow, '
      allowed = 5*bound(integrator, 1.0e-5_wp, 1.0e-9_wp)
      call run_scene('*GRAVITY, X=0, Y=-9.81'//nl//'*RIGID BODY, NAME=upper, MASS=2, INERTIA=0.2, CENTRE X=0.5'//nl// &
         & ' end, 1, 0'//nl//'*RIGID BODY, NAME=fore, MASS=1, INERTIA=0.05, CENTRE X=0.4, X=1, ANGLE=0.3'//nl// &
         & '*ASSEMBLY, ELIMINATION='//elimination//nl// &
         & '*JOINT, NAME=shoulder, TYPE=REVOLUTE'//nl//' upper.origin, ground.origin'//nl// &
         & '*JOINT, NAME=elbow, TYPE=REVOLUTE'//nl//' fore.origin, upper.end'//nl// &
         & '*STOP, NAME=limit, JOINT=elbow, LEAST=-0.1, LAW=RIGID, RESTITUTION=0.5'//nl, integrator, 'END=2, OUTPUTS=100', &
         & ' bend = joint_angle(elbow), balance = kinetic_energy(system) + potential_energy(system) - work(system), '// &
         & 'lost(limit), torque(limit), w = work(system)', reader)
      balance = channel(reader, 'balance')
      bend = channel(reader, 'bend')
      lost = channel(reader, 'lost_limit')
      w = channel(reader, 'w')
      energy = numbers(reader, '/events/energy')
      impulse = numbers(reader, '/events/impulse')
      call check(count(impulse > 0.0_wp) > 3, name//'impacts')
      call check(minval(bend) >= -0.1_wp - 1.0e-8_wp, name//'never beyond')
      call check_close(maxval(abs(balance - balance(1))), 0.0_wp, allowed, name//'balance of energies')
      call check_close(sum(energy), -lost(size(lost)), 1.0e-9_wp, name//'energy lost')
      call check_close(w(size(w)), -lost(size(lost)), allowed, name//'work is the energy lost')
      call check(lost(size(lost)) > 0.1_wp, name//'energy is lost')
      call reader%close()
   end subroutine check_elbow

   !> What rigid stops cannot do.
   subroutine check_refusals()
      character(*), parameter :: ball = '*GRAVITY, X=0, Y=-9.81'//nl//'*POINT MASS, NAME=b, MASS=1, Y=1'//nl, &
         & ends = nl//' b, ground.origin'//nl, stop = '*STOP, NAME=floor, AXIS=90 deg, LAW=RIGID, ', &
         & run = '*DYNAMICS, END=1'//nl//'*OUTPUT'//nl//' y(b)'//nl
      call check_refused(ball//stop//'LEAST=1.1'//ends//run, 'begins 0.1 m beyond it')
      call check_refused(ball//stop//'LEAST=0, RESTITUTION=1.2'//ends//run, 'makes each impact gain energy')
      call check_refused(ball//stop//'LEAST=0, MOST=0'//ends//run, 'leaves no way')
      call check_refused(ball//stop//'LEAST=0, STIFFNESS=5'//ends//run, 'STIFFNESS')
      call check_refused(ball//'*SWITCH, NAME=s'//nl//stop//'LEAST=0, ACTIVE=s'//ends//run, 'no switch turns it off')
      call check_refused(ball//'*STOP, NAME=floor, AXIS=90 deg, LEAST=0'//ends//run, 'has no STIFFNESS')
      call check_refused(ball//stop//'LEAST=0'//ends//'*STATICS'//nl//run, '*STATICS has no rigid stops')
      call check_refused(ball//stop//'LEAST=0'//ends//'*ACCURACY, ESTIMATE=YES'//nl//run, 'errors are to be estimated')
      call check_refused(ball//stop//'LEAST=0'//ends//'*DRIVER, NAME=press, TYPE=Y, POINT=b'//nl//' 1 - 2*t'//nl//run, &
         & 'no impulse ends the approach')
      call check_refused('*MATERIAL, NAME=steel, YOUNG=2e11, DENSITY=7850'//nl// &
         & '*SECTION, NAME=flat, SHAPE=RECTANGLE, WIDTH=0.02, HEIGHT=0.01'//nl//'*BEAM, NAME=b, MATERIAL=steel, SECTION=flat, '// &
         & 'LENGTH=1'//nl//'*JOINT, NAME=pin, TYPE=REVOLUTE'//nl//' b.start, ground.origin'//nl// &
         & '*STOP, NAME=limit, JOINT=pin, LEAST=-0.1, LAW=RIGID'//nl//'*DYNAMICS, END=1'//nl//'*OUTPUT'//nl//' y(b.end)'//nl, &
         & "acts on 'b', which bends")
   end subroutine check_refusals

   !> Checks that a deck is refused, with a text.
   subroutine check_refused(deck, text)
      character(*), intent(in) :: deck, text
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call run_text(deck, trim(results), report, error)
      call check(allocated(error), 'refused: '//text)
      if (allocated(error)) call check(index(error%message, text) > 0, text//': '//error%message)
   end subroutine check_refused

   !> Checks several values.
   subroutine check_all(values, wanted, allowed, name)
      real(wp), intent(in) :: values(:), wanted(:), allowed
      character(*), intent(in) :: name
      integer :: j
      call check(size(values) == size(wanted), name//': their number')
      do j = 1, min(size(values), size(wanted))
         call check_close(values(j), wanted(j), allowed, name)
      end do
   end subroutine check_all

   !> Restitution near one: the bounces of a ball end at (1 + e)/(1 - e) times the first instant, and all energy is lost.
   subroutine check_many(restitution, integrator)
      character(*), intent(in) :: restitution, integrator
      type(history_reader_type) :: reader
      real(wp), allocatable :: t(:), turned(:), lost(:), speed(:), closed(:)
      character(:), allocatable :: name
      real(wp) :: e, end
      integer :: n
      read (restitution, *) e
      end = sqrt(2/g)*(1 + e)/(1 - e)
      name = integrator//', bounces of '//restitution
      call run_scene('*GRAVITY, X=0, Y=-9.81'//nl//'*POINT MASS, NAME=b, MASS=1, Y=1'//nl// &
         & '*STOP, NAME=s, AXIS=90 deg, LAW=RIGID, LEAST=0, RESTITUTION='//restitution//nl//' b, ground.origin'//nl, &
         & integrator, 'END=310, OUTPUTS=31', ' vy(b), closed(s), lost(s)', reader)
      t = numbers(reader, '/events/time')
      turned = numbers(reader, '/events/turned')
      n = size(t)
      call check(n < 10000 .and. nint(turned(n)) == 1, name//': rests at last')
      call check_close(t(n)/end, 1.0_wp, 1.0e-5_wp, name//': end')
      speed = channel(reader, 'vy_b')
      closed = channel(reader, 'closed_s')
      lost = channel(reader, 'lost_s')
      call check(nint(closed(32)) == 1 .and. abs(speed(32)) < 1.0e-12_wp, name//': at rest')
      call check_close(lost(32), g, 1.0e-4_wp*g, name//': energy lost')
      call reader%close()
   end subroutine check_many

   !> Work and energy across an impact, without a warning: drivers take their part of the impulse, and one at the start counts.
   subroutine check_energy(label, scene, work)
      character(*), intent(in) :: label, scene
      !> Change of the energy by impact and drivers
      real(wp), intent(in) :: work
      type(error_type), allocatable :: error
      type(history_reader_type) :: reader
      real(wp), allocatable :: w(:), e(:)
      character(:), allocatable :: report
      integer :: i
      do i = 1, size(integrators)
         call run_text(scene//'*DYNAMICS, END=0.8, OUTPUTS=8, TOLERANCE=1e-8, INTEGRATOR='//trim(integrators(i))//nl// &
            & '*OUTPUT'//nl//' w = work(system), e = kinetic_energy(system) + potential_energy(system)'//nl, trim(results), &
            & report, error)
         call check_no_error(error, label)
         call check(index(report, 'warning') == 0, label//', '//trim(integrators(i))//': '//report)
         call reader%open(trim(results), error)
         w = channel(reader, 'w')
         e = channel(reader, 'e')
         call check_close(w(9), work, 1.0e-6_wp, label//', '//trim(integrators(i))//': work')
         call check_close(e(9) - e(1), w(9) - w(1), 1.0e-6_wp, label//', '//trim(integrators(i))//': energy')
         call reader%close()
      end do
   end subroutine check_energy

   function rail(name, mass) result(text)
      character(*), intent(in) :: name, mass
      character(:), allocatable :: text
      text = '*JOINT, NAME='//name//', TYPE=POINT ON LINE, ANGLE=90 deg'//nl//' '//mass//', ground.origin'//nl
   end function rail

   !> Runs a scene and opens its results.
   subroutine run_scene(scene, integrator, options, output, reader)
      !> Blocks; options of *DYNAMICS; lines of *OUTPUT
      character(*), intent(in) :: scene, integrator, options, output
      type(history_reader_type), intent(out) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call run_text(scene//'*DYNAMICS, INTEGRATOR='//integrator//', TOLERANCE='//trim(tolerance)//', '//options//nl// &
         & '*OUTPUT'//nl//output//nl, trim(results), report, error)
      call check_no_error(error, integrator//', '//trim(tolerance)//', '//output)
      call reader%open(trim(results), error)
      call check_no_error(error, 'results')
   end subroutine run_scene

end program test_rigid_stops
