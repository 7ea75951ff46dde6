!> Errors that add up beside the tolerance. Laws of place that come and go many times: what their passages add up to is right,
!> against the integral of the law along a known motion, or the run tells of it. The same of a body whose motion is small beside
!> what a soft spring connects it with, or beside its own travel, in closed form. Usage, in tests/: test_passages RESULT_FILE
program test_passages
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: newline, as_text
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_text, channel
   use testing, only: check, check_no_error, finish
   implicit none

   character(10), parameter :: integrators(4) = [character(10) :: 'AUTO', 'RADAU', 'ALPHA', 'CONSERVING']
   character(4), parameter :: tolerances(4) = ['1e-4', '1e-6', '1e-8', '1e-9']
   character(*), parameter :: told = 'errors of these passages add up: the speed along y'
   character(256) :: results
   integer :: i

   call get_command_argument(1, results)
   do i = 1, size(integrators)
      call check_hills(trim(integrators(i)), '1e-4')
      call check_hills(trim(integrators(i)), '1e-5')
      call check_hills(trim(integrators(i)), '1e-6')
      call check_small(trim(integrators(i)), '1e-3', '0.05')
      call check_small(trim(integrators(i)), '1e-4', '0.05')
      call check_small(trim(integrators(i)), '1e-5', '1')
      call check_small(trim(integrators(i)), '1e-7', '0.05')
   end do
   call check_beside('ADAMS', '0')
   call check_beside('ADAMS', '30')
   call check_beside('RADAU', '0')
   call check_beside('RADAU', '100')
   call check_beside('ALPHA', '10')
   call check_beside('CONSERVING', '10')
   do i = 1, size(tolerances)
      call check_along(trim(tolerances(i)))
      call check_hanging(trim(tolerances(i)))
   end do
   call finish()

contains

   !> A mass that flies along x at 10 through 589 hills of a force along y.
   subroutine check_hills(integrator, tolerance)
      character(*), intent(in) :: integrator, tolerance
      !> Error that must be told, and the one that must not be, relative to the speed at the end
      real(wp), parameter :: wrong = 5.0e-2_wp, right = 1.0e-2_wp
      integer, parameter :: cells = 2000000
      type(error_type), allocatable :: error
      type(history_reader_type) :: reader
      real(wp), allocatable :: speed(:)
      character(:), allocatable :: report, name
      real(wp) :: exact, off
      integer :: k
      name = 'hills, '//integrator//', '//tolerance//': '
      exact = 0.0_wp
      do k = 1, cells
         exact = exact + 1.0e4_wp*max(0.0_wp, cos(37*(10*(k - 0.5_wp)/cells)**2) - 0.999_wp)/cells
      end do
      call run_text('*POINT MASS, NAME=a, MASS=1, VX=10'//newline//'*FORCE, NAME=f, POINT=a'//newline// &
         & ' 0, 1e4*max(0, cos(37*x(a)*x(a)) - 0.999)'//newline//'*DYNAMICS, END=1, OUTPUTS=5, TOLERANCE='//tolerance// &
         & ', INTEGRATOR='//integrator//newline//'*OUTPUT'//newline//' vy(a)'//newline, trim(results), report, error)
      call check_no_error(error, name//'run')
      if (allocated(error)) return
      call reader%open(trim(results), error)
      speed = channel(reader, 'vy_a')
      call reader%close()
      off = abs(speed(size(speed))/exact - 1)
      if (off > wrong) call check(index(report, told) > 0, name//as_text(100*off, 2)//' % off, and not told: '//report)
      if (off < right) call check(index(report, told) == 0, name//'off by '//as_text(100*off, 2)//' %: '//report)
   end subroutine check_hills

   !> A mass of 1e-6 on a spring to the ground, 1000 rad/s with an amplitude of 3e-3, and by a spring of a millionth of the
   !> stiffness on a pendulum 5 long.
   subroutine check_small(integrator, tolerance, end)
      character(*), intent(in) :: integrator, tolerance, end
      real(wp), parameter :: wrong = 6.0e-2_wp, right = 4.0e-3_wp, amplitude = 3.0e-3_wp, omega = 1000.0_wp
      type(error_type), allocatable :: error
      type(history_reader_type) :: reader
      real(wp), allocatable :: t(:), y(:)
      character(:), allocatable :: report, name
      real(wp) :: off
      logical :: tells
      name = 'small motion, '//integrator//', '//tolerance//', END='//end//': '
      call run_text('*RIGID BODY, NAME=big, MASS=1e6, INERTIA=1e8, CENTRE X=5'//newline// &
         & '*JOINT, NAME=j, TYPE=REVOLUTE'//newline// &
         & ' big.origin, ground.origin'//newline//'*POINT MASS, NAME=s, MASS=1e-6, X=0.001, VY=3'//newline// &
         & '*SPRING, NAME=own, STIFFNESS=1'//newline//' s, ground.origin'//newline// &
         & '*SPRING, NAME=soft, STIFFNESS=1e-6, LENGTH=5'// &
         & newline//' s, big.centre'//newline//'*DYNAMICS, END='//end//', OUTPUTS=200, TOLERANCE='//tolerance//', INTEGRATOR='// &
         & integrator//newline//'*OUTPUT'//newline//' y(s)'//newline, trim(results), report, error)
      call check_no_error(error, name//'run')
      if (allocated(error)) return
      call reader%open(trim(results), error)
      call reader%read_time(t, error)
      y = channel(reader, 'y_s')
      call reader%close()
      off = maxval(abs(y - amplitude*sin(omega*t)))/amplitude
      tells = index(report, "body 's' moves by") > 0
      if (off > wrong) call check(tells, name//as_text(100*off, 2)//' % off, and not told: '//report)
      if (off < right) call check(.not. tells, name//'off by '//as_text(100*off, 2)//' %: '//report)
   end subroutine check_small

   !> Masses of 1000 and 10 on a spring of 1000, which vibrate by 1e-3 while both drive at a speed.
   subroutine check_beside(integrator, speed)
      character(*), intent(in) :: integrator, speed
      real(wp), parameter :: wrong = 6.0e-2_wp, right = 1.0e-2_wp, amplitude = 1.0e-3_wp, omega = sqrt(101.0_wp)
      type(error_type), allocatable :: error
      type(history_reader_type) :: reader
      real(wp), allocatable :: t(:), e(:)
      character(:), allocatable :: report, name
      real(wp) :: off
      logical :: tells
      name = 'vibration on the way, '//integrator//', speed '//speed//': '
      call run_text('*POINT MASS, NAME=car, MASS=1000, VX='//speed//newline// &
         & '*POINT MASS, NAME=m, MASS=10, VX='//speed//', X=1.001'//newline// &
         & '*SPRING, NAME=s, STIFFNESS=1000, LENGTH=1'//newline//' car, m'//newline// &
         & '*DYNAMICS, END=100, OUTPUTS=2000, INTEGRATOR='//integrator//newline// &
         & '*OUTPUT'//newline//' e = elongation(s)'//newline, &
         & trim(results), report, error)
      call check_no_error(error, name//'run')
      if (allocated(error)) return
      call reader%open(trim(results), error)
      call reader%read_time(t, error)
      e = channel(reader, 'e')
      call reader%close()
      off = maxval(abs(e - amplitude*cos(omega*t)))/amplitude
      tells = index(report, "body 'm' moves by") > 0 .and. index(report, "beside body 'car'") > 0
      if (off > wrong) call check(tells, name//as_text(100*off, 2)//' % off, and not told: '//report)
      if (off < right) call check(index(report, 'moves by') == 0, name//'off by '//as_text(100*off, 2)//' %: '//report)
   end subroutine check_beside

   !> A mass at 20 m/s on a road of 0.1 mm, by a force of its height: a vibration along one axis beside a long way, in closed form.
   subroutine check_along(tolerance)
      character(*), intent(in) :: tolerance
      real(wp), parameter :: wrong = 3.0e-2_wp, right = 2.0e-3_wp, height = 1.0e-4_wp, k = 2.0e4_wp, c = 100.0_wp, m = 40.0_wp, &
         & forced = 60.0_wp
      type(error_type), allocatable :: error
      type(history_reader_type) :: reader
      real(wp), allocatable :: t(:), y(:)
      character(:), allocatable :: report, name
      complex(wp) :: shape, root
      real(wp) :: off, decay, omega
      name = 'a road of 0.1 mm, '//tolerance//': '
      call run_text('*POINT MASS, NAME=axle, MASS=40, VX=20'//newline//'*FORCE, NAME=tyre, POINT=axle'//newline// &
         & ' 0, 2e4*(0.0001*sin(x(axle)*3.0) - y(axle)) - 100*vy(axle)'//newline// &
         & '*DYNAMICS, END=20, OUTPUTS=1000, TOLERANCE='//tolerance//newline//'*OUTPUT'//newline//' y = y(axle)'//newline, &
         & trim(results), report, error)
      call check_no_error(error, name//'run')
      if (allocated(error)) return
      call reader%open(trim(results), error)
      call reader%read_time(t, error)
      y = channel(reader, 'y')
      call reader%close()
      shape = k*height/cmplx(k - m*forced**2, c*forced, wp)
      decay = 0.5_wp*c/m
      omega = sqrt(k/m - decay**2)
      ! Im(shape exp(i forced t)) and the decaying vibration that begins it at rest
      root = cmplx(-aimag(shape), (-forced*real(shape) - decay*aimag(shape))/omega, wp)
      off = maxval(abs(y - aimag(shape*exp(cmplx(0.0_wp, forced*t, wp))) - exp(-decay*t)*(real(root)*cos(omega*t) &
         & + aimag(root)*sin(omega*t))))/maxval(abs(y))
      print '(a,es10.2)', name, off
      if (off > wrong) call check(index(report, "body 'axle' moves by") > 0 .and. index(report, 'along y') > 0, name//report)
      if (off < right) call check(index(report, 'moves by') == 0, name//report)
   end subroutine check_along

   !> A load on a rope of 8 m under a trolley that travels by 100 m: its sway, against a run at 1e-11.
   subroutine check_hanging(tolerance)
      character(*), intent(in) :: tolerance
      real(wp), parameter :: wrong = 3.0e-2_wp, right = 1.0e-3_wp
      real(wp), allocatable :: sway(:), exact(:)
      character(:), allocatable :: report, ignored, name
      real(wp) :: off
      name = 'a load on a rope, '//tolerance//': '
      call travel('1e-11', exact, ignored)
      call travel(tolerance, sway, report)
      off = maxval(abs(sway - exact))/maxval(abs(exact))
      print '(a,es10.2)', name, off
      if (off > wrong) call check(index(report, "body 'load' moves by") > 0, name//report)
      if (off < right) call check(index(report, 'moves by') == 0, name//report)
   end subroutine check_hanging

   subroutine travel(tolerance, sway, report)
      character(*), intent(in) :: tolerance
      real(wp), allocatable, intent(out) :: sway(:)
      character(:), allocatable, intent(out) :: report
      type(error_type), allocatable :: error
      type(history_reader_type) :: reader
      call run_text('*GRAVITY'//newline//'*POINT MASS, NAME=tr, MASS=200'//newline// &
         & '*JOINT, NAME=rail, TYPE=POINT ON LINE'//newline//' tr, ground.origin'//newline// &
         & '*POINT MASS, NAME=load, MASS=500, Y=-8'//newline//'*JOINT, NAME=rope, TYPE=ROD'//newline//' load, tr'//newline// &
         & '*DRIVER, NAME=d, TYPE=X, POINT=tr'//newline//' 100*poly345(t/60)'//newline// &
         & '*DYNAMICS, END=90, OUTPUTS=500, INTEGRATOR=ADAMS, TOLERANCE='//tolerance//newline// &
         & '*OUTPUT'//newline//' sway = x(load) - x(tr)'//newline, trim(results), report, error)
      call check_no_error(error, 'a load on a rope')
      allocate (sway(0))
      if (allocated(error)) return
      call reader%open(trim(results), error)
      sway = channel(reader, 'sway')
      call reader%close()
   end subroutine travel

end program test_passages
