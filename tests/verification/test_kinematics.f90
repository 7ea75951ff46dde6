!> Kinematics and inverse dynamics of a slider-crank against closed forms, and the steps of a deck on one axis of time.
!> Usage, in tests/: test_kinematics RESULT_FILE
program test_kinematics
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_commands_run, only: run_deck
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_changed, change_deck, channel
   use testing, only: check, check_close, check_no_error, check_text, finish
   implicit none
   real(wp), parameter :: a = 0.15_wp, b = 0.30_wp, speed = 10.0_wp, g = 9.81_wp, pi = acos(-1.0_wp)
   character(256) :: results

   call get_command_argument(1, results)
   call check_slider_crank()
   call check_flexible()
   call check_missing_driver()
   call check_dead_centre()
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

end program test_kinematics
