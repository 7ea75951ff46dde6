!> Drivers that change their speed right where one analysis ends and the next begins: the bodies take the impact, with every
!> integrator and however the law is written, and the samples on both sides are one state each.
!> Usage, in tests/: test_borders RESULT_FILE
program test_borders
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: newline
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_text, channel
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   character(*), parameter :: nl = newline
   !> Told of an impact
   character(*), parameter :: told = "as by an impact, for driver 'd' changes speed abruptly there"
   character(256) :: results
   character(:), allocatable :: report

   call get_command_argument(1, results)
   call check_impacts()
   call check_rotation()
   call check_jumps()
   call finish()

contains

   !> A hub at rest that its driver turns at 3 rad/s from the end of the first analysis on, and an arm hinged on it, straight
   !> outwards. Of the arm (c = 0.5 m, L = 1 m, 0.7 kg m^2 about its hinge) the angular momentum about the hinge is kept:
   !> 0.7 s + 2 c L 3 = 0. Then 0.7 (s - 3)^2/2 - 3^2 2 c L cos(angle) stays as it is, and the kinetic energy behind the impact is
   !> (3^2 + 2 (3 L + c s)^2 + 0.2 s^2)/2.
   subroutine check_impacts()
      character(10), parameter :: integrators(5) = [character(10) :: 'AUTO', 'ADAMS', 'RADAU', 'ALPHA', 'CONSERVING']
      character(24), parameter :: ends(3) = [character(24) :: '1', '0.1*3', '0.3']
      character(44), parameter :: laws(5) = [character(44) :: '3*max(t - 1, 0)', 'L3*step(t - 1)', 'L3 - 3*step(1 - t)', &
         & '3*max(t - 0.3, 0)', '3*max(t - 0.1*3, 0)']
      integer, parameter :: of_law(5) = [1, 1, 1, 2, 3]
      integer :: i, k
      do i = 1, size(integrators)
         do k = 1, size(laws)
            if (i > 2 .and. k > 3) cycle
            call check_impact(trim(laws(k)), trim(ends(of_law(k))), trim(integrators(i)))
         end do
      end do
   end subroutine check_impacts

   subroutine check_impact(law, border, integrator)
      !> Of the hub's angle, or behind an L of its speed
      character(*), intent(in) :: law, border, integrator
      character(:), allocatable :: level, text, what
      type(error_type), allocatable :: error
      type(history_reader_type) :: reader
      real(wp), allocatable :: hub(:), arm(:), energy(:), angle(:)
      real(wp), parameter :: s = -30.0_wp/7
      real(wp) :: most
      integer :: n
      level = ''
      text = law
      if (law(1:1) == 'L') level = ', LEVEL=VELOCITY'
      if (law(1:1) == 'L') text = law(2:)
      what = integrator//', '//law//', '//border
      n = 5
      call run_text('*RIGID BODY, NAME=h, MASS=1, INERTIA=1'//nl//' p, 1, 0'//nl//'*JOINT, NAME=j, TYPE=REVOLUTE'//nl// &
         & ' h.origin, ground.origin'//nl//'*DRIVER, NAME=d, TYPE=ANGLE, BODY=h'//level//nl//' '//text//nl// &
         & '*RIGID BODY, NAME=m, MASS=2, INERTIA=0.2, X=1, CENTRE X=0.5'//nl//'*JOINT, NAME=k, TYPE=REVOLUTE'//nl// &
         & ' m.origin, h.p'//nl//'*DYNAMICS, NAME=a, END='//border//', OUTPUTS=5, INTEGRATOR='//integrator//nl// &
         & '*DYNAMICS, NAME=b, END=1.7, OUTPUTS=7, INTEGRATOR='//integrator//nl//'*OUTPUT'//nl// &
         & ' hub=spin(h), arm=spin(m), energy=kinetic_energy(system), angle=angle(m) - angle(h)'//nl, trim(results), report, error)
      call check_no_error(error, what)
      if (allocated(error)) return
      call check(index(report, told) > 0, what//': the impact is told: '//report)
      call reader%open(trim(results), error)
      call check_no_error(error, what//': results')
      hub = channel(reader, 'hub')
      arm = channel(reader, 'arm')
      energy = channel(reader, 'energy')
      angle = channel(reader, 'angle')
      call reader%close()
      call check_close(abs(hub(n + 1)) + abs(arm(n + 1)) + energy(n + 1), 0.0_wp, 1.0e-9_wp, what//': at rest before')
      call check_close(hub(n + 2), 3.0_wp, 1.0e-8_wp, what//': speed of the hub behind')
      call check_close(arm(n + 2), s, 1.0e-7_wp, what//': speed of the arm behind')
      call check_close(energy(n + 2), 99.0_wp/14, 1.0e-6_wp, what//': energy behind')
      most = 1.0e-3_wp
      call check_close(0.35_wp*(arm(n + 9) - 3)**2 - 9*cos(angle(n + 9)), 0.35_wp*(s - 3)**2 - 9, most, what//': motion after')
   end subroutine check_impact

   !> A steady rotation that a driver stops.
   subroutine check_rotation()
      type(error_type), allocatable :: error
      type(history_reader_type) :: reader
      real(wp), allocatable :: spin(:)
      integer :: i
      character(3), parameter :: laws(2) = [character(3) :: '0', '3*t']
      do i = 1, 2
         call run_text('*RIGID BODY, NAME=h, MASS=1, INERTIA=1'//nl//'*JOINT, NAME=j, TYPE=REVOLUTE'//nl// &
            & ' h.origin, ground.origin'//nl//'*DRIVER, NAME=d, TYPE=ANGLE, BODY=h'//nl//' '//laws(i)//nl// &
            & '*STATICS, ROTATION=3'//nl//'*DYNAMICS, END=2, OUTPUTS=4'//nl//'*OUTPUT'//nl//' spin=spin(h)'//nl, trim(results), &
            & report, error)
         call check_no_error(error, 'a rotation that a driver takes over')
         if (allocated(error)) return
         call reader%open(trim(results), error)
         spin = channel(reader, 'spin')
         call reader%close()
         call check_close(spin(size(spin)), 3.0_wp*(i - 1), 1.0e-9_wp, 'speed of the driver')
         call check((index(report, told) > 0) .eqv. i == 1, 'impact on a rotation: '//laws(i)//report)
      end do
   end subroutine check_rotation

   !> What jumps itself is refused, what is continuous is not told.
   subroutine check_jumps()
      character(*), parameter :: wheel = '*RIGID BODY, NAME=h, MASS=1, INERTIA=1'//nl//'*JOINT, NAME=j, TYPE=REVOLUTE'//nl// &
         & ' h.origin, ground.origin'//nl//'*DRIVER, NAME=d, TYPE=ANGLE, BODY=h'//nl
      character(*), parameter :: analyses = '*DYNAMICS, NAME=a, END=0.3'//nl//'*DYNAMICS, NAME=b, END=1'//nl
      character(20), parameter :: jumps(2) = [character(20) :: '0.1*step(t - 0.3)', '0.1*step(0.3 - t)'], &
         & smooth(3) = [character(20) :: 'max(t - 0.3, 0)**2', 'smoothstep(t - 0.3)', '2*t']
      type(error_type), allocatable :: error
      integer :: i
      do i = 1, size(jumps)
         call run_text(wheel//' '//trim(jumps(i))//nl//analyses, trim(results), report, error)
         call check(allocated(error), trim(jumps(i))//' is refused')
         if (allocated(error)) call check(index(error%message, "driver 'd' jumps by 0.") > 0, error%message)
      end do
      do i = 1, size(smooth)
         call run_text(wheel//' '//trim(smooth(i))//nl//analyses, trim(results), report, error)
         call check_no_error(error, trim(smooth(i)))
         if (.not. allocated(error)) call check(index(report, 'impact') == 0, trim(smooth(i))//': '//report)
      end do
   end subroutine check_jumps

end program test_borders
