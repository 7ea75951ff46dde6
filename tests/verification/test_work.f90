!> The work put in by every integrator, at every sample, against closed forms: drivers whose multipliers do it, laws of time, of
!> place and of rates; stops that CONSERVING must not feed energy from; and accelerations that an integrator does not follow.
!> Usage: test_work RESULT_FILE
program test_work
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_base_text, only: newline
   use limber_commands_run, only: run_deck
   use limber_output_history_reader, only: history_reader_type
   use runs, only: channel
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   character(*), parameter :: nl = newline
   character(10), parameter :: integrators(4) = [character(10) :: 'ADAMS', 'RADAU', 'ALPHA', 'CONSERVING']
   real(wp), parameter :: g = 9.81_wp
   character(256) :: results
   character(:), allocatable :: report
   type(history_reader_type) :: reader

   call get_command_argument(1, results)
   call check_cranks()
   call check_broken_law()
   call check_slider_crank()
   call check_flywheel()
   call check_stops()
   call check_collision()
   call check_ringing()
   call check_kept_up()
   call check_kept_axial()
   call check_unasked()
   call check_balance()
   call check_no_circle()
   call check_units()
   call finish()

contains

   !> Runs a deck by an integrator.
   subroutine run(scene, dynamics, integrator, tolerance)
      !> Blocks before and options of *DYNAMICS with the output behind; names
      character(*), intent(in) :: scene, dynamics, integrator, tolerance
      type(error_type), allocatable :: error
      integer :: unit
      open (newunit=unit, file=trim(results)//'.inp', action='write', status='replace')
      write (unit, '(a)') '*HEADING'//nl//' work'//nl//scene//'*DYNAMICS, INTEGRATOR='//integrator//', TOLERANCE='// &
         & tolerance//', '//dynamics
      close (unit)
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
      call check_no_error(error, integrator//' at '//tolerance)
      if (allocated(error)) error stop 1
      call reader%open(trim(results), error)
      call check_no_error(error, 'results')
   end subroutine run

   !> An eccentric crank at constant speed: the driver does m g e sin(w t), whatever the step. Nothing but the work bounds the
   !> steps of RADAU and ALPHA here.
   subroutine check_cranks()
      integer :: i
      do i = 1, 3
         call turn_crank(trim(integrators(i)), '1e-4', merge(4.0e-3_wp, 1.0e-3_wp, i == 3))
         call turn_crank(trim(integrators(i)), '1e-8', merge(1.0e-6_wp, 2.0e-7_wp, i == 3))
      end do
      call turn_crank('RADAU', '1e-11', 1.0e-9_wp)
      call turn_crank('CONSERVING', '1e-6', 4.0e-4_wp)
   end subroutine check_cranks

   !> One of them.
   subroutine turn_crank(integrator, tolerance, allowed)
      character(*), intent(in) :: integrator, tolerance
      real(wp), intent(in) :: allowed
      character(*), parameter :: scene = '*RIGID BODY, NAME=crank, MASS=2, INERTIA=0.01, CENTRE X=0.1'//nl// &
         & '*JOINT, NAME=pin, TYPE=REVOLUTE'//nl//' crank.origin, ground.origin'//nl// &
         & '*DRIVER, NAME=motor, TYPE=ANGLE, BODY=crank'//nl//' 20*t'//nl//'*GRAVITY'//nl
      character(*), parameter :: dynamics = 'END=1, OUTPUTS=500'//nl//'*OUTPUT'//nl//' work = work(system)'
      real(wp), allocatable :: work(:)
      real(wp) :: off
      integer :: k
      call run(scene, dynamics, integrator, tolerance)
      allocate (work, source=channel(reader, 'work'))
      off = maxval([(abs(work(k) - 2*g*0.1_wp*sin(20*0.002_wp*(k - 1))), k=1, size(work))])
      print '(3a,es10.2)', 'crank, '//integrator, ' at ', tolerance//': work off by', off
      call check_close(off, 0.0_wp, allowed, 'crank, '//integrator//' at '//tolerance//': work')
      call reader%close()
   end subroutine turn_crank

   !> A force whose law of the time bends, on a point mass: the work is the kinetic energy.
   subroutine check_broken_law()
      character(*), parameter :: scene = '*POINT MASS, NAME=p, MASS=2'//nl//'*FORCE, NAME=f, POINT=p'//nl// &
         & ' 3*max(0, t - 0.3), 2*abs(sin(9*t))'//nl
      real(wp), parameter :: allowed(4) = [1.0e-6_wp, 1.0e-6_wp, 2.0e-5_wp, 1.0e-4_wp]
      real(wp), allocatable :: work(:)
      real(wp) :: off, t, v(2)
      integer :: i, k
      do i = 1, 4
         call run(scene, 'END=1, OUTPUTS=97'//nl//'*OUTPUT'//nl//' work = work(system)', trim(integrators(i)), '1e-7')
         allocate (work, source=channel(reader, 'work'))
         off = 0.0_wp
         do k = 1, size(work)
            t = real(k - 1, wp)/97
            v = [0.75_wp*max(0.0_wp, t - 0.3_wp)**2, integral(9*t)/9]
            off = max(off, abs(work(k) - sum(v**2)))
         end do
         print '(2a,es10.2)', trim(integrators(i)), ': work of broken laws off by', off
         call check_close(off, 0.0_wp, allowed(i), trim(integrators(i))//': work of broken laws')
         deallocate (work)
         call reader%close()
      end do
   end subroutine check_broken_law

   !> Integral of |sin|.
   pure real(wp) function integral(x)
      real(wp), intent(in) :: x
      real(wp), parameter :: pi = acos(-1.0_wp)
      integral = 2*floor(x/pi) + 1 - cos(x - pi*floor(x/pi))
   end function integral

   !> A mechanism that its driver moves wholly: the work is the change of the energy, which is exact in every position.
   subroutine check_slider_crank()
      character(*), parameter :: scene = '*RIGID BODY, NAME=crank, MASS=1, INERTIA=0.01'//nl//' tip, 0.15, 0'//nl// &
         & '*RIGID BODY, NAME=rod, MASS=1, INERTIA=0.02, X=0.15, CENTRE X=0.15'//nl//' end, 0.3, 0'//nl// &
         & '*POINT MASS, NAME=slider, MASS=0.5, X=0.45'//nl//'*JOINT, NAME=a, TYPE=REVOLUTE'//nl// &
         & ' crank.origin, ground.origin'//nl//'*JOINT, NAME=b, TYPE=REVOLUTE'//nl//' crank.tip, rod.origin'//nl// &
         & '*JOINT, NAME=c, TYPE=REVOLUTE'//nl//' rod.end, slider'//nl//'*JOINT, NAME=d, TYPE=POINT ON LINE'//nl// &
         & ' slider, ground.origin'//nl//'*GRAVITY'//nl//'*DRIVER, NAME=motor, TYPE='
      character(32), parameter :: drivers(3) = [character(32) :: 'ANGLE, BODY=crank', 'ANGLE, JOINT=a', 'ANGLE, BODY=rod']
      character(24), parameter :: laws(3) = [character(24) :: '20*t', '20*t + sin(7*t)', '0.3*sin(9*t)']
      real(wp), parameter :: allowed(4) = [3.0e-5_wp, 3.0e-5_wp, 5.0e-4_wp, 2.0e-3_wp]
      real(wp), allocatable :: work(:), energy(:)
      integer :: i, k
      do i = 1, 3
         do k = 1, 3
            call run(scene//trim(drivers(i))//nl//' '//trim(laws(i))//nl, 'END=0.4, OUTPUTS=200'//nl//'*OUTPUT'//nl// &
               & ' work = work(system), energy = kinetic_energy(system) + potential_energy(system)', trim(integrators(k)), '1e-6')
            allocate (work, source=channel(reader, 'work'))
            allocate (energy, source=channel(reader, 'energy'))
            print '(4a,es10.2,a,es9.1)', trim(integrators(k)), ', driver of ', drivers(i), ': energy less work', &
               & maxval(abs(energy - energy(1) - work)), ' of', maxval(abs(work))
            call check_close(maxval(abs(energy - energy(1) - work)), 0.0_wp, allowed(k)*max(1.0_wp, maxval(abs(work))), &
               & trim(integrators(k))//', '//trim(drivers(i))//': energy less work')
            deallocate (work, energy)
            call reader%close()
         end do
      end do
   end subroutine check_slider_crank

   !> A heavy wheel at speed under a small torque of the time: its own scale decides, not the energy of the wheel.
   subroutine check_flywheel()
      character(*), parameter :: scene = '*RIGID BODY, NAME=wheel, MASS=100, INERTIA=50, SPIN=30'//nl// &
         & '*JOINT, NAME=a, TYPE=REVOLUTE'//nl//' wheel, ground.origin'//nl//'*TORQUE, NAME=t, BODY=wheel'//nl//' sin(50*t)'//nl
      real(wp), allocatable :: work(:)
      real(wp) :: off, t
      integer :: i, k
      do i = 1, 4
         call run(scene, 'END=1, OUTPUTS=211'//nl//'*OUTPUT'//nl//' work = work(system)', trim(integrators(i)), '1e-6')
         allocate (work, source=channel(reader, 'work'))
         off = 0.0_wp
         do k = 1, size(work)
            t = real(k - 1, wp)/211
            off = max(off, abs(work(k) - 25*((30 + (1 - cos(50*t))/2500)**2 - 900)))
         end do
         print '(2a,es10.2)', trim(integrators(i)), ': small work on a heavy wheel off by', off
         call check_close(off, 0.0_wp, merge(2.0e-3_wp, 2.0e-4_wp, i > 2), trim(integrators(i))//': small work on a heavy wheel')
         deallocate (work)
         call reader%close()
      end do
   end subroutine check_flywheel

   !> Stiff stops by laws of the coordinate that they act along, however the deck names it: a ball and a wheel come back to where
   !> they began. By samples that lie away from the stop the energy is a closed form.
   subroutine check_stops()
      character(*), parameter :: ball = '*POINT MASS, NAME=ball, MASS=1, Y=10'//nl//'*GRAVITY'//nl
      character(*), parameter :: wheel = '*RIGID BODY, NAME=wheel, MASS=1, INERTIA=1, ANGLE=0.6, SPIN=-14'//nl// &
         & '*JOINT, NAME=a, TYPE=REVOLUTE'//nl//' wheel, ground.origin'//nl
      call meet_stop('force', ball//'*FORCE, NAME=stop, POINT=ball'//nl//' 0, max(0, -1e9*y(ball))'//nl, 98.1_wp)
      call meet_stop('force, sideways', '*POINT MASS, NAME=ball, MASS=1, X=-10'//nl//'*GRAVITY, X=9.81, Y=0'//nl// &
         & '*FORCE, NAME=stop, POINT=ball'//nl//' -1e9*max(0, x(ball)), 0'//nl, 98.1_wp)
      call meet_stop('torque', wheel//'*TORQUE, NAME=stop, BODY=wheel'//nl// &
         & ' max(0, -1e9*angle(wheel)) - max(0, 1e9*(angle(wheel) - 1))'//nl, 98.0_wp)
      call meet_stop('torque of a joint', wheel//'*TORQUE, NAME=stop, BODY=wheel'//nl// &
         & ' max(0, -1e9*joint_angle(a)) - max(0, 1e9*(joint_angle(a) - 1))'//nl, 98.0_wp)
      call meet_stop('force of rate too', ball//'*FORCE, NAME=stop, POINT=ball'//nl// &
         & ' 0, max(0, -1e9*y(ball))*(1 + 0*vy(ball))'//nl, 98.1_wp)
      call meet_stop('force of place too', ball//'*FORCE, NAME=stop, POINT=ball'//nl// &
         & ' 0, max(0, -1e9*y(ball))*(1 + 0*x(ball))'//nl, 98.1_wp)
   end subroutine check_stops

   !> One of them.
   subroutine meet_stop(name, scene, energy)
      character(*), intent(in) :: name, scene
      real(wp), intent(in) :: energy
      real(wp), allocatable :: values(:), work(:)
      call run(scene, 'END=6, OUTPUTS=60'//nl//'*OUTPUT'//nl// &
         & ' e = kinetic_energy(system) + potential_energy(system), work = work(system)', 'CONSERVING', '1e-6')
      allocate (values, source=channel(reader, 'e'))
      allocate (work, source=channel(reader, 'work'))
      print '(2a,3es11.3)', 'stop by '//name, ': energy, least and largest, energy less work', minval(values), maxval(values), &
         & maxval(abs(values - values(1) - work))
      call check_close(maxval(abs(values - energy))/energy, 0.0_wp, 2.0e-4_wp, 'stop by '//name//': energy')
      call reader%close()
   end subroutine meet_stop

   !> A stop with a damper, k z (1 + a z'), Hunt's law: the speed v1 behind it solves
   !> v0 - ln(1 + a v0)/a = -v1 - ln(1 - a v1)/a, whatever k.
   subroutine check_collision()
      real(wp), parameter :: a = 0.08_wp, v0 = 14.0_wp
      real(wp), parameter :: allowed(4) = [1.0e-4_wp, 1.0e-4_wp, 1.0e-3_wp, 1.0e-3_wp]
      real(wp), allocatable :: speed(:)
      real(wp) :: low, high, middle
      integer :: i
      low = 0.0_wp
      high = v0
      do i = 1, 60
         middle = 0.5_wp*(low + high)
         if (-middle - log(1 - a*middle)/a < v0 - log(1 + a*v0)/a) then
            low = middle
         else
            high = middle
         end if
      end do
      do i = 1, 4
         call run('*POINT MASS, NAME=ball, MASS=1, Y=1, VY=-14'//nl//'*FORCE, NAME=stop, POINT=ball'//nl// &
            & ' 0, max(0, -1e7*y(ball))*(1 - 0.08*vy(ball))'//nl, 'END=0.5, OUTPUTS=10, MAXIMUM STEP=1e-3'//nl//'*OUTPUT'//nl// &
            & ' speed = vy(ball), balance = kinetic_energy(system) - work(system)', trim(integrators(i)), '1e-6')
         allocate (speed, source=channel(reader, 'speed'))
         print '(2a,2f12.6)', trim(integrators(i)), ': speed behind a collision', speed(size(speed)), low
         call check_close(speed(size(speed))/low, 1.0_wp, allowed(i), trim(integrators(i))//': speed behind a collision')
         deallocate (speed)
         allocate (speed, source=channel(reader, 'balance'))
         call check_close(maxval(abs(speed - speed(1)))/98, 0.0_wp, allowed(i), trim(integrators(i))//': energy less work')
         deallocate (speed)
         call reader%close()
      end do
   end subroutine check_collision

   !> A blade behind a gear, rung by a torque that sets in: its accelerations are those of ADAMS to a hundredth, or there is a
   !> warning, and none where they are.
   subroutine check_ringing()
      character(*), parameter :: scene = '*MATERIAL, NAME=m, YOUNG=2e11, DENSITY=7800'//nl// &
         & '*SECTION, NAME=s, SHAPE=CIRCLE, DIAMETER=0.02'//nl//'*GROUND'//nl//' b, 0.5, 0'//nl// &
         & '*RIGID BODY, NAME=small, MASS=1, INERTIA=0.1'//nl//'*BEAM, NAME=blade, MATERIAL=m, SECTION=s, LENGTH=0.5, '// &
         & 'SUPPORT=CLAMPED-FREE, ELEMENTS=20,'//nl//' BENDING MODES=6, GEOMETRIC=LINEAR, X=0.5'//nl// &
         & '*JOINT, NAME=j1, TYPE=REVOLUTE'//nl//' small, ground.origin'//nl//'*JOINT, NAME=j2, TYPE=REVOLUTE'//nl// &
         & ' blade.start, ground.b'//nl//'*JOINT, NAME=mesh, TYPE=GEAR, FIRST RADIUS=0.2, SECOND RADIUS=0.3'//nl// &
         & ' small, blade.start'//nl//'*TORQUE, NAME=t, BODY=small'//nl//' 5*cos(6*t)'//nl//'*GRAVITY'//nl
      character(*), parameter :: dynamics = 'END=0.05, OUTPUTS=60'//nl//'*OUTPUT'//nl//' a = ay(blade.end)'
      character(*), parameter :: names(4) = [character(5) :: 'RADAU', 'RADAU', 'RADAU', 'ALPHA']
      character(*), parameter :: tolerances(4) = [character(5) :: '1e-4', '1e-7', '1e-10', '1e-6']
      real(wp), allocatable :: truth(:), values(:)
      real(wp) :: off
      integer :: i
      logical :: told
      call run(scene, dynamics, 'ADAMS', '1e-10')
      allocate (truth, source=channel(reader, 'a'))
      call reader%close()
      do i = 1, size(names)
         call run(scene, dynamics, trim(names(i)), trim(tolerances(i)))
         allocate (values, source=channel(reader, 'a'))
         off = maxval(abs(values - truth))/maxval(abs(truth))
         told = index(report, 'does not follow a vibration') > 0
         print '(4a,es9.1,l2)', names(i), ' at ', tolerances(i), ': acceleration behind a gear off by, told', off, told
         call check(told .or. off < 1.0e-2_wp, names(i)//' at '//tolerances(i)//': an acceleration is right, or there is a warning')
         call check(.not. told .or. off > 2.0e-3_wp, names(i)//' at '//tolerances(i)//': no warning where it is right')
         deallocate (values)
         call reader%close()
      end do
   end subroutine check_ringing

   !> A cantilever at rest behind statics, under a force at its tip that hardly changes: what ADAMS at the limit of its stability
   !> keeps up of its fast vibrations is told where it is more than a hundredth of the reaction, that force; by RADAU none.
   subroutine check_kept_up()
      character(*), parameter :: scene = '*MATERIAL, NAME=metal, YOUNG=7e10, DENSITY=2700'//nl// &
         & '*SECTION, NAME=bar, SHAPE=RECTANGLE, WIDTH=0.048, HEIGHT=0.024'//nl//'*BEAM, NAME=arm, MATERIAL=metal, '// &
         & 'SECTION=bar, LENGTH=0.592, GEOMETRIC=EXACT, FUNCTIONS=6, STRAIN FUNCTIONS=1, X=0.1, ANGLE=0.839'//nl//'*GROUND'//nl// &
         & ' wall, 0.1, 0'//nl//'*JOINT, NAME=clamp, TYPE=WELD, TURN=0.839'//nl//' arm.start, ground.wall'//nl// &
         & '*POINT MASS, NAME=tip, MASS=0.411, X=0.1 + 0.592*cos(0.839), Y=0.592*sin(0.839)'//nl// &
         & '*JOINT, NAME=pin, TYPE=REVOLUTE'//nl//' tip, arm.end'//nl//'*FORCE, NAME=pull, POINT=arm.end'//nl// &
         & ' 1.23*(1 + 1e-3*max(0, t - 1)), -0.567'//nl//'*STATICS, PERIOD=1, INCREMENTS=4'//nl
      character(*), parameter :: dynamics = 'END=1.1, OUTPUTS=10'//nl//'*OUTPUT'//nl//' fx = force_x(clamp), fy = force_y(clamp)'
      character(*), parameter :: names(4) = [character(5) :: 'ADAMS', 'ADAMS', 'ADAMS', 'RADAU']
      character(*), parameter :: tolerances(4) = [character(5) :: '1e-5', '1e-6', '1e-8', '1e-6']
      real(wp), allocatable :: fx(:), fy(:)
      real(wp) :: off
      integer :: i
      logical :: told
      do i = 1, size(names)
         call run(scene, dynamics, trim(names(i)), trim(tolerances(i)))
         allocate (fx, source=channel(reader, 'fx'))
         allocate (fy, source=channel(reader, 'fy'))
         off = max(maxval(abs(abs(fx(6:)) - 1.23_wp)), maxval(abs(abs(fy(6:)) - 0.567_wp)))
         told = index(report, 'keeps up a vibration') > 0
         print '(4a,es9.1,l2)', names(i), ' at ', tolerances(i), ': reaction at rest off by, told', off, told
         call check(told .or. off < 1.23e-2_wp, names(i)//' at '//tolerances(i)//': a reaction is right, or there is a warning')
         if (i <= 2) call check(told .or. off < 1.0e-3_wp, 'what is kept up is told')
         if (i == 4) call check(.not. told .and. off < 1.0e-3_wp, 'RADAU keeps nothing up')
         deallocate (fx, fy)
         call reader%close()
      end do
   end subroutine check_kept_up

   !> A column with a head under its weight and a slow force across: RADAU does not follow how the weight makes it vibrate along
   !> itself. Forces and moments across do not show that, and are right; the force along the column is wrong, and told by its size.
   subroutine check_unasked()
      character(*), parameter :: scene = '*MATERIAL, NAME=steel, YOUNG=2.1e11, DENSITY=7850'//nl// &
         & '*SECTION, NAME=col, SHAPE=RECTANGLE, WIDTH=0.04, HEIGHT=0.02'//nl//'*GRAVITY'//nl//'*BEAM, NAME=column, '// &
         & 'MATERIAL=steel, SECTION=col, LENGTH=0.8, ANGLE=90 deg'//nl//'*POINT MASS, NAME=top, MASS=5, Y=0.8'//nl// &
         & '*JOINT, NAME=foot, TYPE=WELD'//nl//' column.start, ground.origin'//nl//'*JOINT, NAME=head, TYPE=REVOLUTE'//nl// &
         & ' top, column.end'//nl//'*FORCE, NAME=f, POINT=column.end'//nl//' 50*cycloidal(t/0.5), 0'//nl
      character(*), parameter :: dynamics = 'END=0.5, OUTPUTS=500'//nl//'*OUTPUT'//nl
      character(*), parameter :: across = ' fx = force_x(foot), mw = moment(foot), v = shear_force(column.start)'//nl// &
         & ' m = bending_moment(column.start)'
      character(2), parameter :: names(4) = ['fx', 'mw', 'v ', 'm ']
      real(wp), allocatable :: truth(:, :), along(:)
      real(wp) :: off, told
      integer :: i, at, found
      allocate (truth(501, size(names)))
      call run(scene, dynamics//across//', fy = force_y(foot)', 'ADAMS', '1e-9')
      do i = 1, size(names)
         truth(:, i) = channel(reader, trim(names(i)))
      end do
      allocate (along, source=channel(reader, 'fy'))
      call reader%close()
      call run(scene, dynamics//across, 'RADAU', '1e-5')
      do i = 1, size(names)
         off = maxval(abs(channel(reader, trim(names(i))) - truth(:, i)))/maxval(abs(truth(:, i)))
         call check(off < 1.0e-3_wp, trim(names(i))//' across a column is right')
      end do
      call check(index(report, 'does not follow a vibration') == 0, 'nothing is told of a vibration that nobody asks for: '//report)
      call reader%close()
      call run(scene, dynamics//across//', fy = force_y(foot)', 'RADAU', '1e-5')
      off = maxval(abs(channel(reader, 'fy') - along))/maxval(abs(along))
      call check(off > 2.0e-2_wp, 'the force along the column lacks its vibration')
      at = index(report, "channel 'fy' may err by about ")
      call check(at > 0, 'it is told: '//report)
      if (at > 0) then
         read (report(at + 29:at + 32), *, iostat=found) told
         call check(found == 0 .and. told > 50*off .and. told < 200*off, 'by its size: '//report)
      end if
      call reader%close()
   end subroutine check_unasked

   !> Balances of energies have no value but round-off of their terms: beside these no vibration matters. All else of both scenes
   !> differs by less than 1e-4 from runs with a thousandth of the tolerance.
   subroutine check_balance()
      character(*), parameter :: decks(2) = [character(32) :: '../input/flexible_four_bar.inp', '../input/portal_frame.inp']
      type(error_type), allocatable :: error
      integer :: i
      do i = 1, size(decks)
         call run_deck(trim(decks(i)), trim(results), .true., .true., report, error)
         call check_no_error(error, decks(i))
         call check(index(report, "'balance' may err") == 0, 'nothing is told of a balance: '//report)
      end do
   end subroutine check_balance

   !> A cantilever under a sudden force at its tip: where RADAU tells that the moment lacks vibrations and names ADAMS, ADAMS must
   !> not name RADAU.
   subroutine check_no_circle()
      character(*), parameter :: scene = '*MATERIAL, NAME=steel, YOUNG=2.1e11, DENSITY=7850'//nl// &
         & '*SECTION, NAME=flat, SHAPE=RECTANGLE, WIDTH=0.04, HEIGHT=0.02'//nl//'*BEAM, NAME=arm, MATERIAL=steel, '// &
         & 'SECTION=flat, LENGTH=0.8, FUNCTIONS=14'//nl//'*JOINT, NAME=clamp, TYPE=WELD'//nl//' arm.start, ground.origin'//nl// &
         & '*FORCE, NAME=motor, POINT=arm.end'//nl//' 0, 20'//nl
      character(*), parameter :: dynamics = 'END=0.05, OUTPUTS=200'//nl//'*OUTPUT'//nl//' m = bending_moment(arm.start)'
      real(wp), allocatable :: truth(:)
      real(wp) :: off
      call run(scene, dynamics, 'ADAMS', '1e-9')
      allocate (truth, source=channel(reader, 'm'))
      call reader%close()
      call run(scene, dynamics, 'RADAU', '1e-4')
      off = maxval(abs(channel(reader, 'm') - truth))/maxval(abs(truth))
      call check(off > 1.0e-2_wp .and. index(report, "channel 'm' may err by") > 0 .and. index(report, 'INTEGRATOR=ADAMS') > 0, &
         & 'RADAU tells of the moment: '//report)
      call reader%close()
      call run(scene, dynamics, 'ADAMS', '1e-6')
      off = maxval(abs(channel(reader, 'm') - truth))/maxval(abs(truth))
      call check(off < 5.0e-3_wp, 'ADAMS has the moment right')
      call check(index(report, 'INTEGRATOR=') == 0, 'and names no other integrator: '//report)
      call reader%close()
   end subroutine check_no_circle

   !> Units of moments, energies, power and of numbers that are taken from lengths; none where a number may mean anything.
   subroutine check_units()
      character(*), parameter :: scene = '*PARAMETER'//nl//' base = 0.1, k = 5'//nl//'*RIGID BODY, NAME=crank, MASS=2, '// &
         & 'INERTIA=0.01'//nl//'*JOINT, NAME=pin, TYPE=REVOLUTE'//nl//' crank.origin, ground.origin'//nl// &
         & '*DRIVER, NAME=motor, TYPE=ANGLE, BODY=crank'//nl//' t'//nl
      character(*), parameter :: dynamics = 'END=0.1, OUTPUTS=2'//nl//'*OUTPUT'//nl// &
         & ' a = torque(motor), b = kinetic_energy(system), c = power(motor), d = x(crank) - base'//nl// &
         & ' e = k*(base - x(crank)), f = 2*moment(pin)'//nl// &
         & ' g = torque(motor)*angle(crank), h = abs(force_x(pin)), i = k*t, j = 2*t, l = angle(crank) - k*t'//nl// &
         & ' m = angle(crank)/spin(crank), n = max(spin(crank), 0), o = x(crank) - base*sin(k*t), p = spin(crank)/spin(crank)'
      character(*), parameter :: names(15) = ['a', 'b', 'c', 'd', 'e', 'f', 'g', 'h', 'i', 'j', 'l', 'm', 'n', 'o', 'p']
      character(*), parameter :: other(7) = [character(7) :: 'unknown', 's', 'rad', 's', 'rad/s', 'm', '1']
      character(*), parameter :: si(15) = [[character(7) :: 'N m', 'J', 'W', 'm', 'unknown', 'N m', 'J', 'N'], other]
      character(*), parameter :: small(15) = [[character(7) :: 'N mm', 'mJ', 'mW', 'mm', 'unknown', 'N mm', 'mJ', 'N'], &
         & other(1:5), [character(7) :: 'mm', '1']]
      integer :: i
      call run(scene, dynamics, 'RADAU', '1e-6')
      do i = 1, size(names)
         call check(unit_of(names(i)) == trim(si(i)), 'unit of '//names(i)//': '//unit_of(names(i)))
      end do
      call reader%close()
      call run('*UNITS, LENGTH=mm, MASS=t'//nl//scene, dynamics, 'RADAU', '1e-6')
      do i = 1, size(names)
         call check(unit_of(names(i)) == trim(small(i)), 'unit of '//names(i)//' in mm and t: '//unit_of(names(i)))
      end do
      call reader%close()
   end subroutine check_units

   !> Unit of a channel of the open results.
   function unit_of(name) result(text)
      character(*), intent(in) :: name
      character(:), allocatable :: text
      integer :: i
      text = ''
      do i = 1, size(reader%channels)
         if (reader%channels(i)%name == name) text = reader%channels(i)%units
      end do
   end function unit_of

   !> A mass that slides along a hinged beam: the beam vibrates along its axis by local errors of ADAMS alone, at orders of 5 to 8.
   !> Its axial force at the pin is told to be wrong, in any units; by RADAU it is the truth.
   subroutine check_kept_axial()
      character(*), parameter :: scene = '*PARAMETER'//nl//' m = 1, s = 1'//nl// &
         & '*MATERIAL, NAME=metal, YOUNG=7e10/m/s**2, DENSITY=2700/m**3'//nl// &
         & '*SECTION, NAME=tube, SHAPE=TUBE, DIAMETER=0.0260208*m, THICKNESS=0.00260208*m'//nl//'*GROUND'//nl// &
         & ' far, 0.624*cos(0.259)*m, 0.624*sin(0.259)*m'//nl//'*BEAM, NAME=beam, MATERIAL=metal, SECTION=tube, '// &
         & 'LENGTH=0.624*m, GEOMETRIC=LINEAR, BENDING MODES=3, AXIAL MODES=1, ANGLE=0.259'//nl// &
         & '*POINT MASS, NAME=mass, MASS=0.448, X=0.261*cos(0.259)*m, Y=0.261*sin(0.259)*m, VX=-0.465*cos(0.259)*m/s, '// &
         & 'VY=-0.465*sin(0.259)*m/s'//nl//'*JOINT, NAME=hinge, TYPE=REVOLUTE'//nl//' beam.start, ground.origin'//nl// &
         & '*JOINT, NAME=roller, TYPE=POINT ON LINE, ANGLE=0.259'//nl//' beam.end, ground.far'//nl// &
         & '*JOINT, NAME=collar, TYPE=SLIDING'//nl//' mass, beam'//nl//'*GRAVITY, X=0, Y=-9.81*m/s**2'//nl
      character(*), parameter :: dynamics = 'END=0.0308*s, OUTPUTS=20'//nl//'*OUTPUT'//nl//' f = axial_force(beam.start)'
      character(*), parameter :: units(2) = [character(14) :: 'm = 1, s = 1', 'm = 1e3, s = 1']
      real(wp), allocatable :: truth(:), values(:)
      real(wp) :: off
      integer :: i
      logical :: told
      call run(scene, dynamics, 'RADAU', '1e-9')
      allocate (truth, source=channel(reader, 'f'))
      call reader%close()
      do i = 1, 2
         call run(replaced(scene, 'm = 1, s = 1', trim(units(i))), dynamics, 'ADAMS', '1e-6')
         allocate (values, source=channel(reader, 'f'))
         if (i == 2) values = values/1.0e3_wp
         call reader%close()
         off = maxval(abs(values - truth))/maxval(abs(truth))
         told = index(report, 'keeps up a vibration') > 0
         print '(a,es9.1,l2)', 'axial force of a beam under a sliding mass off by, told', off, told
         call check(told .or. off < 1.0e-2_wp, 'an axial force is right, or there is a warning, '//units(i))
         deallocate (values)
      end do
   end subroutine check_kept_axial

   !> A text with the first of some words replaced.
   function replaced(text, old, new) result(other)
      character(*), intent(in) :: text, old, new
      character(:), allocatable :: other
      integer :: at
      at = index(text, old)
      other = text(:at - 1)//new//text(at + len(old):)
   end function replaced

end program test_work
