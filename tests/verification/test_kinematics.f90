!> Kinematics and inverse dynamics of a slider-crank against closed forms, and the steps of a deck on one axis of time.
!> Usage, in tests/: test_kinematics RESULT_FILE
program test_kinematics
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_commands_run, only: run_deck
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_changed, run_text, change_deck, channel
   use testing, only: check, check_close, check_no_error, check_text, finish
   implicit none
   real(wp), parameter :: a = 0.15_wp, b = 0.30_wp, speed = 10.0_wp, g = 9.81_wp, pi = acos(-1.0_wp)
   character(256) :: results

   call get_command_argument(1, results)
   call check_slider_crank()
   call check_flexible()
   call check_missing_driver()
   call check_dead_centre()
   call check_gap()
   call check_pulse()
   call finish()

contains

   !> Kinetic and potential energy at a crank angle: what the torque of the motor changes.
   pure real(wp) function energy(theta)
      real(wp), intent(in) :: theta
      real(wp) :: s, phi, slope, slider, x, y
      s = sqrt(b**2 - (a*sin(theta))**2)
      phi = -asin(a/b*sin(theta))
      slope = -a*cos(theta)/s
      slider = -a*sin(theta)*(1 + a*cos(theta)/s)
      x = -a*sin(theta) - 0.5_wp*b*sin(phi)*slope
      y = a*cos(theta) + 0.5_wp*b*cos(phi)*slope
      energy = 0.5_wp*speed**2*(a**2/3 + 2*(x**2 + y**2) + b**2/6*slope**2 + 0.5_wp*slider**2) &
         & + g*(0.5_wp*a*sin(theta) + 2*(a*sin(theta) + 0.5_wp*b*sin(phi)))
   end function energy

   subroutine check_slider_crank()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: t(:), x(:), vx(:), torque(:), angle(:), steps(:)
      character(:), allocatable :: names
      real(wp), parameter :: h = 1.0e-3_wp
      real(wp) :: theta, s, worst(3)
      integer :: k
      call run_changed('../input/slider_crank_inverse.inp', trim(results), [character(1) ::], [character(1) ::], reader)
      call reader%read_time(t, error)
      call check_no_error(error, 'time')
      allocate (x, source=channel(reader, 'x'))
      allocate (vx, source=channel(reader, 'vx'))
      allocate (torque, source=channel(reader, 'torque'))
      allocate (angle, source=channel(reader, 'crank_angle'))
      call check(size(t) == 182, 'samples of two analyses')
      worst = 0.0_wp
      do k = 1, size(t)
         theta = speed*t(k)
         s = sqrt(b**2 - (a*sin(theta))**2)
         worst(1) = max(worst(1), abs(x(k) - a*cos(theta) - s))
         worst(2) = max(worst(2), abs(vx(k) + speed*a*sin(theta)*(1 + a*cos(theta)/s)))
         worst(3) = max(worst(3), abs(torque(k) - (8*(energy(theta + h) - energy(theta - h)) &
            & - energy(theta + 2*h) + energy(theta - 2*h))/(12*h)))
      end do
      call check_close(worst(1), 0.0_wp, 1.0e-13_wp, 'slider, closed form')
      call check_close(worst(2), 0.0_wp, 1.0e-12_wp, 'speed of the slider, closed form')
      call check_close(worst(3), 0.0_wp, 1.0e-10_wp, 'torque of the motor, from the energy')
      call check_close(angle(182), 4*pi, 1.0e-12_wp, 'the angle accumulates over both analyses')
      call reader%read_numbers('/step', steps, error)
      call check_no_error(error, 'steps of the samples')
      call check_close(sum(abs(steps(:91) - 1)) + sum(abs(steps(92:) - 2)), 0.0_wp, 0.0_wp, 'steps of the samples')
      call reader%read_text('/run/steps/names', names, error)
      call check_text(names, 'kinematics'//new_line('a')//'inverse_dynamics', 'names of the steps')
      call reader%close()
   end subroutine check_slider_crank

   !> The deflection of a slow flexible rod is that of a beam under its own weight, 5 m g L^3/(384 EI), and held it is none.
   subroutine check_flexible()
      type(history_reader_type) :: reader
      real(wp), allocatable :: middle(:)
      integer :: k
      real(wp) :: expected
      character(6), parameter :: kind(2) = [character(6) :: 'STATIC', 'HELD']
      do k = 1, 2
         call run_changed('verification/flexible_linkage.inp', trim(results), [character(18) :: 'DEFLECTIONS=STATIC'], &
            & [character(18) :: 'DEFLECTIONS='//kind(k)], reader)
         allocate (middle, source=channel(reader, 'middle'))
         ! Lumped masses on an even number of elements: the sum of the deflections of their weights
         expected = -lumped_middle(20)*0.5_wp*9.81_wp/100
         if (kind(k) == 'HELD') expected = 0.0_wp
         call check_close(middle(1), expected, 1.0e-3_wp*abs(expected) + 1.0e-15_wp, 'deflection of a linkage, '//kind(k))
         call reader%close()
         deallocate (middle)
      end do
   end subroutine check_flexible

   !> Middle deflection of a beam of unit length and EI on two supports under n equal parts of a unit weight, lumped.
   pure real(wp) function lumped_middle(n) result(w)
      integer, intent(in) :: n
      real(wp) :: x
      integer :: i
      w = 0.0_wp
      do i = 1, n - 1
         x = min(real(i, wp)/n, 1 - real(i, wp)/n)
         w = w + (3*x - 4*x**3)/48/n
      end do
   end function lumped_middle

   subroutine check_missing_driver()
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call change_deck('../input/slider_crank_inverse.inp', trim(results)//'.inp', &
         & [character(44) :: '*DRIVER, NAME=motor, TYPE=ANGLE, BODY=crank', 'speed*t', 'torque = torque(motor),'], &
         & [character(44) :: '**', '**', ''])
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
      call check(allocated(error), 'a scene without its driver has no kinematics')
      if (.not. allocated(error)) return
      call check(index(error%message, 'one driver is missing') > 0 .and. index(error%message, "body 'crank' turns") > 0, &
         & 'what moves without a driver: '//error%message)
   end subroutine check_missing_driver

   !> The crank is driven over its reach: with a longer crank than rod it comes to a stop.
   subroutine check_dead_centre()
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call change_deck('../input/slider_crank_inverse.inp', trim(results)//'.inp', [character(40) :: 'a = 0.15, b = 0.30'], &
         & [character(40) :: 'a = 0.30, b = 0.15'])
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
      call check(allocated(error), 'a crank that is too long stops')
      if (.not. allocated(error)) return
      call check(index(error%message, 'end of its reach') > 0 .and. index(error%message, 't = 0.0523') > 0, &
         & 'it stops at sin(angle) = 1/2: '//error%message)
   end subroutine check_dead_centre

   !> No position where crank and rocker are nearly in line, sqrt(5 - 4 cos(angle)) > coupler + rocker: no number of samples leads
   !> over the gap, however narrow it is. Just beyond it the same branch is followed, with the same orientation of the joint between
   !> coupler and rocker.
   subroutine check_gap()
      character(18), parameter :: analysis(2) = [character(18) :: '*KINEMATICS', '*INVERSE DYNAMICS']
      character(8), parameter :: samples(4) = [character(8) :: '7', '60', '100', '1000']
      character(14), parameter :: short(3) = [character(14) :: '1e-4', '1e-8', '0']
      real(wp), parameter :: gap(3) = [1.0e-4_wp, 1.0e-8_wp, 0.0_wp]
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report, label
      real(wp), allocatable :: crank(:), rocker(:)
      real(wp) :: found, reach, worst, expected
      integer :: i, j, k, at
      do i = 1, size(analysis)
         do j = 1, size(samples)
            do k = 1, size(short)
               label = trim(analysis(i))//', OUTPUTS='//trim(samples(j))//', short = '//trim(short(k))
               call change_deck('verification/four_bar_gap.inp', trim(results)//'.inp', [character(22) :: 'short = 1e-4', &
                  & '*KINEMATICS', 'OUTPUTS=60'], [character(22) :: 'short = '//short(k), analysis(i), 'OUTPUTS='//samples(j)])
               call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
               call check(allocated(error), 'no way over a gap: '//label)
               if (.not. allocated(error)) cycle
               call check(index(error%message, "driver 'motor': no position near") > 0, 'who is at the gap: '//error%message)
               at = index(error%message, ' t = ')
               found = 0.0_wp
               if (at > 0) read (error%message(at + 5:at + 4 + scan(error%message(at + 5:), ':') - 1), *) found
               reach = acos((5 - (3 - gap(k))**2)/4)
               call check_close(found, (reach - 1.2_wp)/6, 3.0e-6_wp, 'where the gap begins: '//label)
            end do
         end do
         call run_changed('verification/four_bar_gap.inp', trim(results), [character(27) :: 'short = 1e-4, long = 0', &
            & '*KINEMATICS'], [character(27) :: 'short = 0, long = 1e-6', analysis(i)], reader)
         crank = channel(reader, 'angle_crank')
         rocker = channel(reader, 'angle_rocker')
         worst = 0.0_wp
         do k = 1, size(crank)
            expected = rocker_angle(crank(k), 1.0_wp + 1.0e-6_wp)
            worst = max(worst, abs(modulo(rocker(k) - expected + pi, 2*pi) - pi))
         end do
         call check_close(worst, 0.0_wp, 1.0e-10_wp, 'a crank that just passes, '//analysis(i))
         call reader%close()
      end do
   end subroutine check_gap

   !> Angle of a rocker on a base of two, behind a coupler of two and a crank of one, on the branch of the first position.
   pure real(wp) function rocker_angle(angle, rocker)
      real(wp), intent(in) :: angle, rocker
      real(wp) :: x, y
      x = cos(angle) - 2
      y = sin(angle)
      rocker_angle = atan2(y, x) - acos((x**2 + y**2 + rocker**2 - 4)/(2*rocker*sqrt(x**2 + y**2)))
   end function rocker_angle

   !> A four-bar linkage with rods of 0.2, 0.15, 0.15 on pivots 0.3 apart, and a crank that a driver moves between two samples by a
   !> pulse: beyond the reach, where cos(angle) = 1/3 and both rods are in line, it stops; within, the samples are those without.
   subroutine check_pulse()
      real(wp), parameter :: reach = acos((0.2_wp**2 + 0.3_wp**2 - 0.3_wp**2)/(2*0.2_wp*0.3_wp)), width = 2.0e-4_wp
      character(40), parameter :: analysis(3) = [character(40) :: 'KINEMATICS, END=1, OUTPUTS=20', &
         & 'INVERSE DYNAMICS, END=1, OUTPUTS=20', 'STATICS, PERIOD=1, INCREMENTS=20']
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: angle(:)
      real(wp) :: found
      integer :: k, at, status
      do k = 1, size(analysis)
         call run_pulse('1.5', analysis(k), error)
         call check(allocated(error), 'no way beyond the reach within a pulse: '//analysis(k))
         if (allocated(error)) then
            call check(index(error%message, "driver 'm'") > 0, 'who is beyond the reach: '//error%message)
            at = index(error%message, 'behind t = ') + len('behind t = ')
            found = 0.0_wp
            read (error%message(at:at + scan(error%message(at:), ':') - 2), *, iostat=status) found
            call check_close(found, 0.43_wp - width*sqrt(log(1.5_wp/(reach - 0.3_wp))), 1.0e-6_wp, &
               & 'where the reach ends: '//analysis(k))
         end if
         call run_pulse('0.5', analysis(k), error)
         call check(.not. allocated(error), 'a pulse within the reach: '//analysis(k))
         if (allocated(error)) cycle
         call reader%open(trim(results), error)
         angle = channel(reader, 'angle_c')
         call reader%close()
         call check_close(maxval(abs(angle - 0.3_wp)), 0.0_wp, 1.0e-9_wp, 'samples beside a pulse: '//analysis(k))
      end do
   end subroutine check_pulse

   !> Runs it with a pulse of a height.
   subroutine run_pulse(height, analysis, error)
      character(*), intent(in) :: height, analysis
      type(error_type), allocatable, intent(out) :: error
      character(1), parameter :: nl = new_line('a')
      character(:), allocatable :: report
      call run_text('*GROUND'//nl//' p, 0.3, 0'//nl//'*RIGID BODY, NAME=c, MASS=1, INERTIA=0.01, ANGLE=0.3'//nl//' e, 0.2, 0'// &
         & nl//'*RIGID BODY, NAME=k, MASS=1, INERTIA=0.01, ANGLE=0.6, X=0.19, Y=0.06'//nl//' e, 0.15, 0'//nl// &
         & '*RIGID BODY, NAME=r, MASS=1, INERTIA=0.01, ANGLE=1.4, X=0.3'//nl//' e, 0.15, 0'//nl// &
         & '*JOINT, NAME=a, TYPE=REVOLUTE'//nl//' c, ground.origin'//nl//'*JOINT, NAME=b, TYPE=REVOLUTE'//nl//' k, c.e'//nl// &
         & '*JOINT, NAME=d, TYPE=REVOLUTE'//nl//' k.e, r.e'//nl//'*JOINT, NAME=e, TYPE=REVOLUTE'//nl//' r, ground.p'//nl// &
         & '*DRIVER, NAME=m, TYPE=ANGLE, BODY=c'//nl//' 0.3+'//height//'*exp(-((t-0.43)/0.0002)**2)'//nl//'*'//trim(analysis)// &
         & nl//'*OUTPUT'//nl//' angle(c)'//nl, trim(results), report, error)
   end subroutine run_pulse

end program test_kinematics
