!> What the deck gives of the first state is kept where the joints allow it, and a change is told: a four-bar whose crank alone is
!> given starts at that angle and spin, the rocker as its loop closes, in closed form.
!> Usage, in tests/: test_given RESULT_FILE
program test_given
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_commands_run, only: run_deck
   use limber_output_history_reader, only: history_reader_type
   use runs, only: change_deck, channel
   use testing, only: check, check_close, check_no_error, finish
   implicit none
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
   call finish()

contains

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
