!> Curves of several formulas that a bead is held on: kinks, which are impacts in closed form; jumps, which are refused; steep
!> ways, by their arc length; and the ends of open curves.
!> Usage, in tests/: test_curves RESULT_FILE
program test_curves
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: newline
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_text, channel
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   character(*), parameter :: bead = '*POINT MASS, NAME=p, MASS=1, X=-1, VX=2', still = '*POINT MASS, NAME=p, MASS=1, X=-1', &
      & motion = '*DYNAMICS, END=1, OUTPUTS=7, INTEGRATOR='
   character(10), parameter :: integrators(4) = [character(10) :: 'ADAMS', 'RADAU', 'ALPHA', 'CONSERVING']
   character(256) :: results
   real(wp) :: x, y, vx
   character(:), allocatable :: report
   integer :: i

   call get_command_argument(1, results)
   do i = 1, size(integrators)
      call check_ramps(trim(integrators(i)), merge(1.0e-9_wp, 1.0e-7_wp, i < 4))
      call refuse('0.1*step(x)', bead, motion//trim(integrators(i)), "joint 'j': its curve jumps at x = ")
   end do
   call check_carriage()
   call check_valley()
   call check_steep('0.02*smoothstep(x/0.001)', 2.0e-5_wp)
   call check_steep('0.02*tanh(x/0.0005)', 2.0e-5_wp)
   call check_steep('0.02*exp(-(x/0.002)**2)', 2.0e-5_wp)
   call check_polygon()
   call check_end()
   call refuse('abs(x)', bead, motion//'ADAMS', 'its point is stopped at t = 0.5 by a kink of its curve')
   call refuse('0.1*abs(x)', '*POINT MASS, NAME=p, MASS=1'//newline//'*GRAVITY', motion//'ADAMS', 'by a kink of its curve')
   call refuse('0.1*step(x)', still//newline//'*DRIVER, NAME=d, TYPE=X, POINT=p'//newline//' -1 + 2*t', &
      & '*KINEMATICS, END=1, OUTPUTS=10', "joint 'j': its curve jumps at x = 0")
   call refuse('-0.1*step(x)', still//newline//'*SPRING, NAME=s, STIFFNESS=10'//newline//' p, ground.origin', '*STATICS', &
      & "joint 'j': its curve jumps at x = 0")
   call run('0.1*abs(x)', still//newline//'*DRIVER, NAME=d, TYPE=X, POINT=p'//newline//' -1 + 2*t', &
      & '*INVERSE DYNAMICS, END=1, OUTPUTS=10', x, y, vx)
   call check(index(report, "joint 'j': its point passes a kink") > 0, 'inverse dynamics: a kink is told')
   call finish()

contains

   !> A ramp of 45 degrees between two levels: each kink leaves cos(45 degrees) of the speed.
   subroutine check_ramps(integrator, most)
      character(*), intent(in) :: integrator
      real(wp), intent(in) :: most
      integer :: side
      do side = 1, -1, -2
         if (side == 1) call run('min(0.1, max(0, x))', bead, motion//integrator, x, y, vx)
         if (side == -1) call run('min(0.1, max(0, -x))', '*POINT MASS, NAME=p, MASS=1, X=1, VX=-2', motion//integrator, x, y, vx)
         call check_close(side*x, 0.5_wp, most, integrator//': place behind two kinks')
         call check_close(y, 0.1_wp, most, integrator//': height behind two kinks')
         call check_close(side*vx, 1.0_wp, most, integrator//': speed behind two kinks')
         call check(index(report, 'passes kinks of its curve 2 times') > 0, integrator//': kinks are told')
         call check(index(report, 'energy balance is off') == 0, integrator//': the energy of impacts is known')
      end do
   end subroutine check_ramps

   !> The curve on a carriage of twice the mass: of 2 m/s the impulse l along (-1, 1) leaves vx = 2 - l, vy = l, V = l/2 with
   !> vy = vx - V, so that l = 0.8.
   subroutine check_carriage()
      call run('max(0, x)', bead//newline//'*RIGID BODY, NAME=b, MASS=2, INERTIA=1'//newline// &
         & '*JOINT, NAME=guide, TYPE=TRANSLATIONAL'//newline//' b.origin, ground.origin', motion//'RADAU', x, y, vx, 'b.origin')
      call check_close(vx, 1.2_wp, 1.0e-9_wp, 'carriage: speed')
      call check_close(y, 0.4_wp, 1.0e-9_wp, 'carriage: height')
      call check_close(x, 0.6_wp, 1.0e-9_wp, 'carriage: place')
   end subroutine check_carriage

   !> A valley of two slopes of 0.1: down in sqrt(2 s/a), and up with cos(2 atan 0.1) of the speed.
   subroutine check_valley()
      real(wp), parameter :: g = 9.81_wp
      real(wp) :: a, s, down, slow, since
      s = sqrt(1.01_wp)
      a = g*0.1_wp/s
      down = sqrt(2*s/a)
      slow = a*down*cos(2*atan(0.1_wp))
      since = 2 - down
      call run('0.1*abs(x)', still//', Y=0.1'//newline//'*GRAVITY', '*DYNAMICS, END=2, OUTPUTS=10', x, y, vx)
      call check_close(x, (slow*since - 0.5_wp*a*since**2)/s, 1.0e-8_wp, 'valley: place')
      call check_close(vx, (slow - a*since)/s, 1.0e-8_wp, 'valley: speed')
   end subroutine check_valley

   !> Without loads the speed along any smooth curve stays.
   subroutine check_steep(curve, most)
      character(*), intent(in) :: curve
      real(wp), intent(in) :: most
      real(wp) :: way, place, step, slope
      integer :: k
      step = 1.0e-6_wp
      way = 0.0_wp
      place = -1.0_wp
      do
         slope = height(curve, place + step) - height(curve, place)
         if (way + hypot(step, slope) > 2.0_wp) exit
         way = way + hypot(step, slope)
         place = place + step
      end do
      do k = 1, 3
         call run(curve, bead, motion//trim(integrators(k)), x, y, vx)
         call check_close(x, place, merge(most, 10*most, k < 3), curve//': '//trim(integrators(k)))
      end do
   end subroutine check_steep

   !> Slopes of -0.2, 0 and 0.2: each kink leaves the same part of the speed.
   subroutine check_polygon()
      call run('0.1*abs(x) + 0.1*abs(x - 0.3)', bead//', Y=0.23', motion//'ADAMS', x, y, vx)
      call check_close(vx, 2/1.04_wp, 1.0e-9_wp, 'polygon: speed')
      call check_close(x, 0.3_wp + 0.35_wp*2/1.04_wp, 1.0e-9_wp, 'polygon: place')
   end subroutine check_polygon

   !> An open curve through points goes on straight behind its end, which is told.
   subroutine check_end()
      character(*), parameter :: points = '-1, 0'//newline//' -0.5, 0.1'//newline//' 0, 0'//newline//' 0.5, 0.1'
      call run(points, bead//', Y=0', motion//'ADAMS', x, y, vx)
      call check(index(report, "joint 'j': its point leaves the end of its curve before t = ") > 0, 'the end of a curve is told')
      call run(points, bead//', Y=0', '*DYNAMICS, END=0.5', x, y, vx)
      call check(index(report, 'leaves the end') == 0, 'a point on its curve is not told')
   end subroutine check_end

   !> Runs a bead on a curve.
   subroutine run(curve, before, analysis, x, y, vx, on)
      !> Data of the curve; bodies and other blocks; the analysis
      character(*), intent(in) :: curve, before, analysis
      !> At the end
      real(wp), intent(out) :: x, y, vx
      !> Origin of the curve, the ground's if not given
      character(*), intent(in), optional :: on
      type(error_type), allocatable :: error
      type(history_reader_type) :: reader
      real(wp), allocatable :: values(:)
      call run_text(deck(curve, before, analysis, on), trim(results), report, error)
      call check_no_error(error, curve)
      if (allocated(error)) error stop 1
      call reader%open(trim(results), error)
      call check_no_error(error, curve//': results')
      allocate (values, source=channel(reader, 'x_p'))
      x = values(size(values))
      values = channel(reader, 'y_p')
      y = values(size(values))
      values = channel(reader, 'vx_p')
      vx = values(size(values))
      call reader%close()
   end subroutine run

   !> Runs what must be refused with some words.
   subroutine refuse(curve, before, analysis, words)
      character(*), intent(in) :: curve, before, analysis, words
      type(error_type), allocatable :: error
      call run_text(deck(curve, before, analysis), trim(results), report, error)
      call check(allocated(error), curve//', '//analysis//' is refused')
      if (allocated(error)) call check(index(error%message, words) > 0, curve//', '//analysis//': '//error%message)
   end subroutine refuse

   function deck(curve, before, analysis, on) result(text)
      character(*), intent(in) :: curve, before, analysis
      character(*), intent(in), optional :: on
      character(:), allocatable :: text
      text = ' p, ground.origin'
      if (present(on)) text = ' p, '//on
      text = '*CURVE, NAME=c'//newline//' '//curve//newline//before//newline//'*JOINT, NAME=j, TYPE=POINT ON CURVE, CURVE=c'// &
         & newline//text//newline//analysis//newline//'*OUTPUT'//newline//' x(p), y(p), vx(p)'//newline
   end function deck

   real(wp) function height(curve, x) result(y)
      character(*), intent(in) :: curve
      real(wp), intent(in) :: x
      real(wp) :: s
      select case (curve(6:8))
      case ('smo')
         s = max(0.0_wp, min(1.0_wp, x/0.001_wp))
         y = 0.02_wp*s**3*(10 - 15*s + 6*s**2)
      case ('tan')
         y = 0.02_wp*tanh(x/0.0005_wp)
      case default
         y = 0.02_wp*exp(-(x/0.002_wp)**2)
      end select
   end function height

end program test_curves
