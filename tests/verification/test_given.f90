!> What the deck gives of the first state is kept where the joints allow it, and a change is told: a four-bar whose crank alone is
!> given starts at that angle and spin, the rocker as its loop closes, in closed form.
!> Usage, in tests/: test_given RESULT_FILE
program test_given
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_commands_run, only: run_deck
   use limber_output_history_reader, only: history_reader_type
   use runs, only: change_deck, channel, run_text
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   character(1), parameter :: nl = new_line('a')
   character(512) :: argument

   call get_command_argument(1, argument)
   ! The crank alone; the crank and a rough rocker; the crank behind the others; mirrored
   call check_start(trim(argument), 'X=base', 'X=base', 1.0_wp, '')
   call check_start(trim(argument), 'X=base', 'X=base, ANGLE=1.9', 1.0_wp, &
      & "body 'rocker' does not start where it is given, which its joints do not allow together with what is given of the"// &
      & ' other bodies: ANGLE=1.9 becomes ')
   call check_start(trim(argument), 'X=base', 'X=base, SPIN=3', 1.0_wp, 'SPIN=3 becomes ')
   call check_start(trim(argument), 'ANGLE=0.5, SPIN=10', 'ANGLE=-0.5, SPIN=-10', -1.0_wp, '')
   ! Drivers that disagree at a dead centre: by speeds, and in the second order; those that agree; racks that cannot roll
   call check_refused(trim(argument), 'verification/dead_drivers.inp', '10*t', '10*t', "driver 'turning' and driver 'pushing'")
   call check_refused(trim(argument), 'verification/dead_drivers.inp', 'r + l + 0.1*t', 'r + l', &
      & "driver 'turning' and driver 'pushing'")
   call check_refused(trim(argument), 'verification/dead_drivers.inp', 'r + l + 0.1*t', &
      & 'r*cos(10*t) + sqrt(l**2 - (r*sin(10*t))**2)', '')
   call check_refused(trim(argument), 'verification/stuck_rack.inp', 'lever, 0.3, 0', 'lever, 0.3, 0', &
      & "joint 'hinge' and joint 'rack' let it move by an infinitely small way only")
   call check_refused(trim(argument), 'verification/stuck_rack.inp', 'lever, 0.3, 0', 'lever, 0, 3', &
      & "joint 'hinge' and joint 'rack' let it move by an infinitely small way only")
   ! Velocities of the deck in a later analysis, whatever has turned since
   call check_later(trim(argument))
   ! The effective deck gives what the deck gave, and nothing more
   call check_effective(trim(argument), 'rods', '*GRAVITY'//nl//'*POINT MASS, NAME=a, MASS=1, VX=2'//nl// &
      & '*POINT MASS, NAME=b, MASS=1, X=1, Y=1'//nl//'*POINT MASS, NAME=c, MASS=1, X=2'//nl//'*JOINT, NAME=j, TYPE=ROD'//nl// &
      & ' a, b'//nl//'*JOINT, NAME=k, TYPE=ROD'//nl//' b, c'//nl//'*DYNAMICS, END=0.3, OUTPUTS=3'//nl//'*OUTPUT'//nl// &
      & ' x(a), vx(a), y(b), vy(b), vx(c)')
   call check_effective(trim(argument), 'an exact beam', '*MATERIAL, NAME=m, YOUNG=1E6, DENSITY=1'//nl// &
      & '*SECTION, NAME=s, SHAPE=GENERAL, AREA=1, INERTIA=1E-6'//nl//'*BEAM, NAME=b, MATERIAL=m, SECTION=s, LENGTH=1'//nl// &
      & '*JOINT, NAME=j, TYPE=WELD, TURN=0'//nl//' b.start, ground.origin'//nl//'*FORCE, NAME=f, POINT=b.end'//nl//' 0, -t'// &
      & nl//'*STATICS, INCREMENTS=2'//nl//'*OUTPUT'//nl//' x(b.end), y(b.end), rotation(b.end)')
   call finish()

contains

   !> A pendulum that statics has turned from ANGLE=-60 deg to its lowest place starts with the SPIN of the deck.
   subroutine check_later(results)
      character(*), intent(in) :: results
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp), allocatable :: spin(:), angle(:)
      call run_text('*GRAVITY'//nl//'*RIGID BODY, NAME=b, MASS=1, INERTIA=0.1, CENTRE X=0.5, ANGLE=-60 deg, SPIN=2'//nl// &
         & '*JOINT, NAME=j, TYPE=REVOLUTE'//nl//' b.origin, ground.origin'//nl//'*STATICS'//nl// &
         & '*DYNAMICS, END=1.001, OUTPUTS=1, VELOCITIES=DECK'//nl//'*OUTPUT'//nl//' spin(b), angle(b)', results, report, error)
      call check_no_error(error, 'velocities of the deck')
      call reader%open(results, error)
      spin = channel(reader, 'spin_b')
      angle = channel(reader, 'angle_b')
      call reader%close()
      call check_close(angle(size(angle) - 1), -0.5_wp*acos(-1.0_wp), 1.0e-6_wp, 'statics has turned the pendulum')
      call check_close(spin(size(spin) - 1), 2.0_wp, 1.0e-12_wp, 'and it starts with the spin of the deck')
   end subroutine check_later

   !> All channels of a deck and of its effective deck are the same.
   subroutine check_effective(results, name, text)
      character(*), intent(in) :: results, name, text
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report, effective
      real(wp), allocatable :: first(:, :), second(:, :)
      call run_text(text, results, report, error)
      call check_no_error(error, name)
      call reader%open(results, error)
      call all_channels(reader, first)
      call reader%read_text('/run/effective_deck', effective, error)
      call reader%close()
      call run_text(effective, results, report, error)
      call check_no_error(error, name//': effective deck')
      call check(index(report, 'warning') == 0, name//': the effective deck has nothing to tell: '//report)
      call reader%open(results, error)
      call all_channels(reader, second)
      call reader%close()
      call check(maxval(abs(first)) > 0.0_wp .and. maxval(abs(first - second)) <= 0.0_wp, name//': the same results')
   end subroutine check_effective

   !> Samples of all channels (samples, channels).
   subroutine all_channels(reader, values)
      type(history_reader_type), intent(inout) :: reader
      real(wp), allocatable, intent(out) :: values(:, :)
      real(wp), allocatable :: one(:)
      integer :: i
      do i = 1, size(reader%channels)
         one = channel(reader, reader%channels(i)%name)
         if (.not. allocated(values)) allocate (values(size(one), size(reader%channels)))
         values(:, i) = one
      end do
   end subroutine all_channels

   !> A deck that is refused by name, or is not.
   subroutine check_refused(results, deck, old, new, names)
      character(*), intent(in) :: results, deck, old, new
      !> What the error says; empty: there is none
      character(*), intent(in) :: names
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call change_deck(deck, results//'.inp', [old], [new])
      call run_deck(results//'.inp', results, .true., .true., report, error)
      if (names == '') then
         call check_no_error(error, deck//', '//new)
      else
         call check(allocated(error), deck//', '//new//' is refused')
         if (allocated(error)) call check(index(error%message, names) > 0, deck//', '//new//': '//error%message)
      end if
   end subroutine check_refused

   !> The first sample, and the warning.
   subroutine check_start(results, old, new, sense, warning)
      character(*), intent(in) :: results, old, new, warning
      !> -1: mirrored
      real(wp), intent(in) :: sense
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp), allocatable :: angle(:), spin(:), rocker(:), rocker_spin(:)
      real(wp), parameter :: a = 0.1_wp, b = 0.25_wp, c = 0.2_wp, d = 0.3_wp
      real(wp) :: tip(2), gap(2), distance, expected, link(2), arm(2)
      call change_deck('verification/given.inp', results//'.inp', [old], [new])
      call run_deck(results//'.inp', results, .true., .true., report, error)
      call check_no_error(error, new)
      if (allocated(error)) return
      call reader%open(results, error)
      call check_no_error(error, new//': results')
      angle = channel(reader, 'crank')
      spin = channel(reader, 'crank_spin')
      rocker = channel(reader, 'rocker')
      rocker_spin = channel(reader, 'rocker_spin')
      call reader%close()
      call check_close(angle(1), sense*0.5_wp, 1.0e-12_wp, new//': angle of the crank')
      call check_close(spin(1), sense*10, 1.0e-10_wp, new//': spin of the crank')
      ! Triangle of the rocker's foot, its tip and that of the crank; either of its two sides
      tip = a*[cos(0.5_wp), sense*sin(0.5_wp)]
      gap = tip - [d, 0.0_wp]
      distance = norm2(gap)
      expected = acos((c**2 + distance**2 - b**2)/(2*c*distance))
      call check_close(cos(rocker(1) - atan2(gap(2), gap(1))), cos(expected), 1.0e-10_wp, new//': angle of the rocker')
      ! The coupler's ends have one speed along it
      arm = c*[cos(rocker(1)), sin(rocker(1))]
      link = [d, 0.0_wp] + arm - tip
      expected = sense*10*dot_product(link, [-tip(2), tip(1)])/dot_product(link, [-arm(2), arm(1)])
      call check_close(rocker_spin(1), expected, 1.0e-9_wp*abs(expected) + 1.0e-9_wp, new//': spin of the rocker')
      if (warning == '') then
         call check(index(report, 'does not start') == 0, new//': nothing to tell: '//report)
      else
         call check(index(report, warning) > 0, new//': told: '//report)
      end if
   end subroutine check_start

end program test_given
