!> Static analysis against beam theory: the table of a cantilever, Euler's load and what follows it, a pendulum that finds its
!> place, steady rotation; and scenes that nothing holds. Usage, in tests/: test_statics RESULT_FILE
program test_statics
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_commands_run, only: run_deck
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_changed, change_deck, channel, run_text
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   real(wp), parameter :: pi = acos(-1.0_wp)
   character(256) :: results

   call get_command_argument(1, results)
   call check_cantilever()
   call check_euler()
   call check_pendulum()
   call check_extension()
   call check_free()
   call check_corners()
   call check_dead_centre()
   call check_redundant()
   call check_no_mode()
   call check_first_deflections()
   call check_turning_mount()
   call check_crossed_elements()
   call check_propped()
   call check_ramp()
   call check_start()
   call finish()

contains

   subroutine check_cantilever()
      type(history_reader_type) :: reader
      real(wp), parameter :: length = 2.0_wp, load = 0.01_wp, weight = 0.01_wp
      real(wp), allocatable :: y(:), slope(:), force(:), torque(:), kinetic(:)
      real(wp) :: lumped, x
      integer :: k
      call run_changed('../input/cantilever_statics.inp', trim(results), [character(1) ::], [character(1) ::], reader)
      allocate (y, source=channel(reader, 'y_tip'))
      allocate (slope, source=channel(reader, 'slope'))
      allocate (force, source=channel(reader, 'wall_force'))
      allocate (torque, source=channel(reader, 'wall_torque'))
      allocate (kinetic, source=channel(reader, 'kinetic'))
      call check(size(y) == 5 + 5 + 11, 'samples of three analyses')
      call check_close(y(5), -weight*length**4/8, 2.0e-3_wp*weight*length**4/8, 'weight: tip')
      lumped = 0.0_wp
      do k = 1, 20
         x = length*k/20
         lumped = lumped + merge(0.5_wp, 1.0_wp, k == 20)*weight*length/20*x**2*(3*length - x)/6
      end do
      call check_close(y(5), -lumped, 1.0e-9_wp*lumped, 'weight of lumped masses: tip')
      call check_close(y(3), -0.5_wp*lumped, 1.0e-9_wp*lumped, 'half the weight')
      call check_close(force(5), weight*length, 1.0e-12_wp, 'weight: wall')
      call check_close(torque(5), weight*length**2/2, 1.0e-12_wp, 'weight: clamp')
      call check_close(y(10) - y(5), -load*length**3/3, 1.0e-9_wp, 'load at the tip: tip')
      call check_close(y(8) - y(5), -0.5_wp*load*length**3/3, 1.0e-9_wp, 'half the load')
      call check_close(slope(10) - slope(5), -load*length**2/2, 1.0e-9_wp, 'load at the tip: slope')
      call check_close(torque(10) - torque(5), load*length, 1.0e-12_wp, 'load at the tip: clamp')
      call check_close(maxval(abs(y(11:) - y(10))), 0.0_wp, 1.0e-10_wp, 'released, it stays')
      call check_close(maxval(kinetic), 0.0_wp, 1.0e-18_wp, 'released, it has no speed')
      call reader%close()
   end subroutine check_cantilever

   !> The load within 0.1 %, found as an instant of the ramp; the deflection behind it grows as a root.
   subroutine check_euler()
      type(history_reader_type) :: reader
      real(wp), allocatable :: load(:), middle(:)
      integer :: k
      character(5), parameter :: fidelity(2) = [character(5) :: 'EXACT', 'K_G']
      character(100) :: changed(2)
      do k = 1, 2
         ! K_G has no equilibrium behind the load: it does not know that bending shortens the column
         changed(1) = 'LENGTH=length'
         changed(2) = merge('INSTABILITY=LEAVE', 'INSTABILITY=STOP ', k == 1)
         if (k == 2) changed(1) = 'LENGTH=length, BENDING MODES=3, GEOMETRIC ELEMENTS=8, AXIAL BASIS=STATIC'
         call run_changed('../input/euler_buckling.inp', trim(results), [character(20) :: 'LENGTH=length', &
            & 'INSTABILITY=LEAVE'], changed, reader)
         allocate (load, source=channel(reader, 'load'))
         allocate (middle, source=channel(reader, 'middle'))
         call check_close(load(11), pi**2, 1.0e-4_wp*pi**2, 'Euler load, '//fidelity(k))
         call check_close(maxval(abs(middle(:11))), 0.0_wp, 1.0e-12_wp, 'straight below it, '//fidelity(k))
         if (k == 1) then
            ! The elastica between hinges: K(k) = sqrt(P)/2, w/L = k/K
            call check_close(abs(middle(12))/0.10188460028_wp, 1.0_wp, 5.0e-3_wp, 'deflection behind it')
            call check_close(abs(middle(14))/0.33181467473_wp, 1.0_wp, 1.0e-2_wp, 'and far behind it')
         else
            call check(size(load) == 11, 'INSTABILITY=STOP ends the run at the load')
         end if
         call reader%close()
         deallocate (load, middle)
      end do
   end subroutine check_euler

   !> From a horizontal start a pendulum finds its lower equilibrium, not the upper one.
   subroutine check_pendulum()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: angle(:), force(:), frequency(:)
      call run_changed('verification/hanging.inp', trim(results), [character(1) ::], [character(1) ::], reader)
      allocate (angle, source=channel(reader, 'angle_bar'))
      allocate (force, source=channel(reader, 'force_y_hinge'))
      call check_close(angle(3), -0.5_wp*pi, 1.0e-12_wp, 'a pendulum hangs')
      call check_close(force(3), 9.81_wp, 1.0e-12_wp, 'its hinge carries it')
      call reader%read_numbers('/modes/modes/frequency', frequency, error)
      call check_close(frequency(1), sqrt(1.5_wp*9.81_wp), 1.0e-12_wp, 'frequency of a hanging bar')
      call reader%close()
   end subroutine check_pendulum

   !> A bar in steady rotation is stretched by L (tan(kL)/(kL) - 1), k^2 = speed^2 rho/E.
   subroutine check_extension()
      type(history_reader_type) :: reader
      real(wp), allocatable :: x(:)
      real(wp) :: k
      call run_changed('verification/rotating_bar.inp', trim(results), [character(1) ::], [character(1) ::], reader)
      allocate (x, source=channel(reader, 'x_bar_end'))
      k = 6*sqrt(1.2_wp/2.8e7_wp)
      call check_close(x(2) - 10, 10*(tan(10*k)/(10*k) - 1), 1.0e-4_wp*10*(tan(10*k)/(10*k) - 1), 'stretched by its rotation')
      call reader%close()
   end subroutine check_extension

   !> Nothing holds a bar on a hinge without weight, and nothing balances a torque on it.
   subroutine check_free()
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call change_deck('verification/hanging.inp', trim(results)//'.inp', [character(8) :: '*GRAVITY'], [character(2) :: '**'])
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
      call check(allocated(error), 'a free bar has no equilibrium of its own')
      if (allocated(error)) call check(index(error%message, "nothing holds the scene") > 0 &
         & .and. index(error%message, "body 'bar' turns freely") > 0, 'what is free: '//error%message)
      call change_deck('verification/hanging.inp', trim(results)//'.inp', [character(8) :: '*GRAVITY'], &
         & [character(40) :: '*TORQUE, NAME=wind, BODY=bar'//new_line('a')//' 10'])
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
      call check(allocated(error), 'a torque on a free bar has no equilibrium')
      if (allocated(error)) call check(index(error%message, "no stable equilibrium is found") > 0 &
         & .and. index(error%message, "body 'bar' turns") > 0, 'what turns: '//error%message)
   end subroutine check_free

   !> Laws of place that hold a scene alone, with corners: closed form at half and all of the load; where a law holds nothing behind
   !> its corner, the error names it.
   subroutine check_corners()
      character(60), parameter :: laws(8) = [character(60) :: '10*t - x(m) - 100*max(0, x(m) - 1)', &
         & '10*t - x(m) - 100*max(0, x(m))', '10*t + bend(x(m))', '10*t - 5*abs(x(m) - 0.3) - x(m) + 1.5', &
         & 't - x(m) - 100*max(0, x(m) - 1)', '-10*t - x(m) - 100*min(0, x(m) + 1)', '10*t - x(m) - 100*step(x(m) - 1)', &
         & '10*t - min(x(m), 1)']
      real(wp), parameter :: places(2, 6) = reshape([105/101.0_wp, 110/101.0_wp, 5/101.0_wp, 10/101.0_wp, 1.04_wp, 1.09_wp, &
         & 4/3.0_wp, 13/6.0_wp, 0.5_wp, 1.0_wp, -105/101.0_wp, -110/101.0_wp], [2, 6])
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      character(1), parameter :: nl = new_line('a')
      real(wp), allocatable :: x(:)
      integer :: i
      do i = 1, size(laws)
         call run_text('*TABLE, NAME=bend'//nl//' -10, 10'//nl//' 0, 0'//nl//' 1, -1'//nl//' 2, -101'//nl// &
            & '*POINT MASS, NAME=m, MASS=1'//nl//'*JOINT, NAME=g, TYPE=POINT ON LINE'//nl//' m, ground.origin'//nl// &
            & '*FORCE, NAME=push, POINT=m'//nl//' '//trim(laws(i))//', 0'//nl//'*STATICS, INCREMENTS=2'//nl// &
            & '*OUTPUT'//nl//' x = x(m)'//nl, trim(results), report, error)
         if (i > size(places, 2)) then
            call check(allocated(error), 'behind its corner the law holds nothing: '//laws(i))
            if (allocated(error)) call check(index(error%message, "the law of 'push' on body 'm' jumps or bends there") > 0, &
               & 'the law is named: '//error%message)
            cycle
         end if
         call check(.not. allocated(error), 'a law with a corner: '//laws(i))
         if (allocated(error)) cycle
         call reader%open(trim(results), error)
         x = channel(reader, 'x')
         call check_close(maxval(abs(x(size(x) - 1:) - places(:, i))), 0.0_wp, 1.0e-9_wp, laws(i))
         call reader%close()
      end do
   end subroutine check_corners

   !> A bar placed aslant hangs from the first sample on, with all its weight if that does not grow; growing from nothing, its first
   !> sample is that of a part of it, which is told.
   subroutine check_start()
      character(1), parameter :: nl = new_line('a')
      character(*), parameter :: scene = '*GRAVITY'//nl//'*RIGID BODY, NAME=bar, MASS=2, INERTIA=1, CENTRE X=0.5, ANGLE=1'//nl// &
         & '*JOINT, NAME=pin, TYPE=REVOLUTE'//nl//' bar.origin, ground.origin'//nl//'*STATICS, INCREMENTS=4'
      character(*), parameter :: asked = nl//'*OUTPUT'//nl//' a = angle(bar), f = force_y(pin)'//nl
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp), allocatable :: angle(:), force(:)
      integer :: i
      do i = 1, 2
         call run_text(scene//trim(merge(', RAMP=NO', '         ', i == 1))//asked, trim(results), report, error)
         call check(.not. allocated(error), 'a bar that hangs')
         if (allocated(error)) return
         call reader%open(trim(results), error)
         angle = channel(reader, 'a')
         force = channel(reader, 'f')
         call reader%close()
         call check_close(maxval(abs(cos(angle))), 0.0_wp, 1.0e-9_wp, 'it hangs from the first sample on')
         call check_close(force(1), 2*9.81_wp*merge(1.0_wp, 1.0e-3_wp, i == 1), 1.0e-9_wp, 'its weight at the first sample')
         call check((index(report, 'at t = 0 no stable equilibrium is determined') > 0) .eqv. i == 2, 'what is told: '//report)
      end do
   end subroutine check_start

   !> A slider-crank at its dead centre: pulled it stays, pushed it folds over and says so, without a load nothing holds it.
   subroutine check_dead_centre()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp), allocatable :: x(:)
      call run_changed('verification/dead_centre.inp', trim(results), [character(6) :: '-100,'], [character(6) :: '100,'], reader)
      allocate (x, source=channel(reader, 'x_slider'))
      call check_close(x(size(x)), 3.0_wp, 1.0e-12_wp, 'pulled at its dead centre it stays')
      call reader%close()
      deallocate (x)
      call change_deck('verification/dead_centre.inp', trim(results)//'.inp', [character(1) ::], [character(1) ::])
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
      call check(.not. allocated(error), 'pushed at its dead centre it finds another place')
      call check(index(report, "as at a dead centre: body 'crank' turns, body 'rod' turns; left for") > 0, &
         & 'a dead centre is told: '//report)
      call reader%open(trim(results), error)
      allocate (x, source=channel(reader, 'x_slider'))
      call check_close(x(size(x)), 1.0_wp, 1.0e-10_wp, 'pushed at its dead centre it folds over')
      call reader%close()
      call change_deck('verification/dead_centre.inp', trim(results)//'.inp', [character(6) :: '-100,'], [character(6) :: '0,'])
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
      call check(allocated(error), 'without a load nothing holds it')
      if (allocated(error)) call check(index(error%message, "body 'crank' turns, body 'rod' turns freely") > 0 &
         & .and. index(error%message, 'dead centre') > 0, 'what is free: '//error%message)
   end subroutine check_dead_centre

   !> The parallelogram with five cranks hangs under its weight, its pins share the weight of the coupler and of half the cranks,
   !> and it swings as one pendulum.
   subroutine check_redundant()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: pin(:), frequency(:)
      character(80) :: changed(1)
      changed(1) = '*STATICS, INCREMENTS=1'//new_line('a')//'*MODES'//new_line('a')//'*DYNAMICS, START=0, END=1,'
      call run_changed('../input/parallelogram_five_cranks.inp', trim(results), [character(20) :: '*DYNAMICS, END=10,'], changed, &
         & reader)
      allocate (pin, source=channel(reader, 'pin3_y'))
      call check_close(pin(2), -4*9.81_wp/5, 1.0e-7_wp, 'five pins share the coupler')
      call reader%read_numbers('/modes/modes/frequency', frequency, error)
      call check_close(frequency(1), sqrt((4 + 2.5_wp)*9.81_wp/(4 + 5/3.0_wp)), 1.0e-6_wp, 'they swing together')
      call reader%close()
   end subroutine check_redundant

   !> With the responses to what acts and no mode at all a cantilever has the deflection and the slope of a load at its tip.
   subroutine check_no_mode()
      type(history_reader_type) :: reader
      real(wp), allocatable :: y(:), slope(:)
      call run_changed('../input/cantilever_statics.inp', trim(results), [character(32) :: 'BENDING MODES=20'], &
         & [character(32) :: 'BENDING MODES=0, CORRECTIONS=YES'], reader)
      allocate (y, source=channel(reader, 'y_tip'))
      allocate (slope, source=channel(reader, 'slope'))
      call check_close(y(10) - y(5), -0.01_wp*2.0_wp**3/3, 1.0e-12_wp, 'no mode: tip')
      call check_close(slope(10) - slope(5), -0.01_wp*2.0_wp**2/2, 1.0e-12_wp, 'no mode: slope')
      call reader%close()
   end subroutine check_no_mode

   !> A beam on a hinge, let go from the horizontal with the deflection that its weight and its acceleration make: relative to its
   !> chord that of the load rho A g (1 - 3x/2L). Let go undeflected, it rings.
   subroutine check_first_deflections()
      type(history_reader_type) :: reader
      real(wp), allocatable :: middle(:), smooth(:)
      real(wp), parameter :: expected = -9.81_wp*0.5_wp/100*(1/384.0_wp - 1/2560.0_wp - 1/192.0_wp + 1/160.0_wp)
      call run_changed('verification/falling_beam.inp', trim(results), [character(1) ::], [character(1) ::], reader)
      allocate (smooth, source=channel(reader, 'deflection_beam_middle'))
      call check_close(smooth(1), expected, 2.0e-3_wp*abs(expected), 'deflection of a beam that begins to fall')
      call reader%close()
      call run_changed('verification/falling_beam.inp', trim(results), [character(6) :: 'STATIC'], [character(6) :: 'ZERO'], reader)
      allocate (middle, source=channel(reader, 'deflection_beam_middle'))
      call check_close(middle(1), 0.0_wp, 1.0e-15_wp, 'without it there is none')
      call check(maxval(abs(middle - smooth)) > 0.8_wp*abs(expected), 'and it rings')
      call check(maxval(abs(smooth - smooth(1))) < 0.2_wp*abs(expected), 'with it it does not')
      call reader%close()
   end subroutine check_first_deflections

   !> Modes of a mass on a bushing in steady rotation, at the ground, which turns too, or at a hub: roots of the determinant of the
   !> mass in turning axes, whatever the origin of its frame is.
   subroutine check_turning_mount()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(40) :: changed(2)
      character(11), parameter :: seats(2) = ['ground.seat', 'hub.seat   ']
      character(14), parameter :: origins(3) = ['px = 0, py = 0', 'px = 2, py = 1', 'px =-1, py = 3']
      real(wp), allocatable :: frequency(:), growth(:), x(:), y(:)
      integer :: i, j, k
      do i = 1, size(seats)
         do j = 1, size(origins)
            changed(1) = origins(j)
            changed(2) = 'mass.seat, '//seats(i)
            call run_changed('verification/turning_mount.inp', trim(results), [character(22) :: origins(1), &
               & 'mass.seat, ground.seat'], changed, reader)
            allocate (x, source=channel(reader, 'x_mass_centre'))
            allocate (y, source=channel(reader, 'y_mass_centre'))
            call check_close(hypot(x(3), y(3)), 0.0_wp, 1.0e-12_wp, 'dampers do not move what turns as a whole, '//trim(changed(2)))
            call reader%read_numbers('/modes/modes/frequency', frequency, error)
            call reader%read_numbers('/modes/modes/growth', growth, error)
            call check(size(growth) == 3, 'three modes of the mass')
            do k = 1, size(growth)
               call check_close(mount_determinant(cmplx(growth(k), frequency(k), wp)), 0.0_wp, 1.0e-10_wp, 'mode of a mass '// &
                  & 'on a bushing in rotation, '//trim(changed(1))//', '//trim(changed(2)))
            end do
            call reader%close()
            deallocate (x, y, frequency, growth)
         end do
      end do
   end subroutine check_turning_mount

   !> |det(s^2 M + s (D + 2 speed J M) + K - speed^2 M)| of the mass on its bushing, relative to the product of the rows' sizes.
   real(wp) function mount_determinant(s) result(relative)
      complex(wp), intent(in) :: s
      real(wp), parameter :: speed = 7, m = 1.3_wp, a(2) = [0.3_wp, -0.2_wp], stiffness(2) = [150, 100], damping(2) = [3, 2]
      complex(wp) :: matrix(3, 3), spring(2)
      spring = stiffness + s*damping
      matrix = 0.0_wp
      matrix(1, :) = [m*(s**2 - speed**2) + spring(1), -2*speed*m*s, -a(2)*spring(1)]
      matrix(2, :) = [2*speed*m*s, m*(s**2 - speed**2) + spring(2), a(1)*spring(2)]
      matrix(3, :) = [-a(2)*spring(1), a(1)*spring(2), 0.05_wp*s**2 + 0.4_wp*s + 30 + a(2)**2*spring(1) + a(1)**2*spring(2)]
      relative = abs(matrix(1, 1)*(matrix(2, 2)*matrix(3, 3) - matrix(2, 3)*matrix(3, 2)) &
         & - matrix(1, 2)*(matrix(2, 1)*matrix(3, 3) - matrix(2, 3)*matrix(3, 1)) &
         & + matrix(1, 3)*(matrix(2, 1)*matrix(3, 2) - matrix(2, 2)*matrix(3, 1)))
      relative = relative/product(sum(abs(matrix), 2))
   end function mount_determinant

   !> A cantilever under a force F across its end has the axial force F w' = F^2 (L x - x^2/2)/(E I) along its deflected axis and
   !> none along the undeformed one, also where a finite element lies in two geometric elements.
   subroutine check_crossed_elements()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(1), parameter :: points(5) = ['a', 'b', 'c', 'd', 'e']
      character(2), parameter :: elements(3) = [character(2) :: '3', '7', '4']
      real(wp), parameter :: x(5) = [0.32_wp, 0.35_wp, 0.38_wp, 0.65_wp, 0.05_wp], most = 60.0_wp**2/(2.0e3_wp/12)
      real(wp), allocatable :: force(:), envelope(:)
      integer :: i, k
      do k = 1, size(elements)
         call run_changed('verification/crossed_elements.inp', trim(results), ['GEOMETRIC ELEMENTS=3'], &
            & ['GEOMETRIC ELEMENTS='//elements(k)], reader)
         do i = 1, size(points)
            force = channel(reader, 'axial_force_beam_'//points(i))
            call check_close(force(2), most*(x(i) - x(i)**2/2), 1.0e-7_wp, 'axial force at '//points(i)//', elements: '// &
               & elements(k))
         end do
         call reader%read_numbers('/bodies/beam/envelope/axial_force', envelope, error)
         if (.not. allocated(error)) call check_close(maxval(abs(envelope)), most/2, 1.0e-7_wp, 'axial force in the envelope')
         call reader%close()
      end do
   end subroutine check_crossed_elements

   !> The reactions of a propped cantilever with a force in its middle, 5/16 F and 3/16 F L, with the remedies that warnings name.
   subroutine check_propped()
      type(history_reader_type) :: reader
      character(40), parameter :: remedies(2) = [character(40) :: 'SUPPORT=PINNED-ROLLER, CORRECTIONS=YES', &
         & 'SUPPORT=CLAMPED-FREE, CORRECTIONS=YES']
      real(wp), allocatable :: roller(:), moment(:)
      integer :: k
      do k = 1, size(remedies)
         call run_changed('models/bad_warn_redundant_beam.inp', trim(results), ['SUPPORT=CLAMPED-PINNED'], remedies(k:k), reader)
         roller = channel(reader, 'force_y_roller')
         moment = channel(reader, 'moment_wall')
         call check_close(roller(2), 5*0.01_wp/16, 1.0e-9_wp, 'propped: roller, '//remedies(k))
         call check_close(moment(2), 3*0.01_wp*2/16, 1.0e-9_wp, 'propped: wall, '//remedies(k))
         call reader%close()
      end do
   end subroutine check_propped

   !> A bar of 10 kg that a driver lifts by a quarter turn: with RAMP=NO its torque is that of the whole weight, with RAMP=YES of a
   !> growing part, and by default a warning says so.
   subroutine check_ramp()
      character(*), parameter :: nl = new_line('a'), ramps(3) = [character(10) :: '', ', RAMP=NO', ', RAMP=YES']
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp), allocatable :: torque(:)
      integer :: i
      do i = 1, 3
         call run_text('*GRAVITY'//nl//'*RIGID BODY, NAME=bar, MASS=10, INERTIA=1, CENTRE X=0.5'//nl// &
            & '*JOINT, NAME=pin, TYPE=REVOLUTE'//nl//' bar.origin, ground.origin'//nl// &
            & '*DRIVER, NAME=motor, TYPE=ANGLE, BODY=bar'//nl//' pi/2*t'//nl//'*STATICS, INCREMENTS=4'//trim(ramps(i))//nl// &
            & '*OUTPUT'//nl//' tq = torque(motor)'//nl, trim(results), report, error)
         call check_no_error(error, 'ramp'//ramps(i))
         if (allocated(error)) return
         call check((index(report, "driver 'motor' moves the scene") > 0) .eqv. i == 1, 'ramp'//trim(ramps(i))//': '//report)
         call reader%open(trim(results), error)
         allocate (torque, source=channel(reader, 'tq'))
         call check_close(torque(1), merge(49.05_wp, 0.0_wp, i == 2), 1.0e-9_wp, 'ramp'//trim(ramps(i))//': at first')
         call check_close(torque(3), merge(1.0_wp, 0.5_wp, i == 2)*49.05_wp*cos(pi/4), 1.0e-9_wp, 'ramp'//trim(ramps(i)))
         call reader%close()
         deallocate (torque)
      end do
   end subroutine check_ramp

end program test_statics
