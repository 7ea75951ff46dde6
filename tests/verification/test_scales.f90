!> Scales of errors and of springs beside far places: a small oscillator errs no more for a point that nothing uses, for a large
!> structure beside it, or for the distance of its own place from the origin; else that is told. All is known in closed form.
!> Usage, in tests/: test_scales RESULT_FILE
program test_scales
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text, newline
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_text, channel
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   character(*), parameter :: mount = 'STIFFNESS X=1e4, STIFFNESS Y=1e4'//newline
   character(256) :: results
   character(10) :: integrator(5) = ['AUTO      ', 'ADAMS     ', 'RADAU     ', 'ALPHA     ', 'CONSERVING']
   integer :: i

   call get_command_argument(1, results)
   do i = 1, size(integrator)
      call check_unused(trim(integrator(i)))
      call check_on_ground(trim(integrator(i)))
      call check_at_seat(trim(integrator(i)))
      call check_beside_bridge(trim(integrator(i)))
      call check_on_bridge(trim(integrator(i)))
      call check_rail(trim(integrator(i)), '1e-3')
      call check_rail(trim(integrator(i)), '1e-5')
   end do
   call check_statics('')
   call check_statics('*POINT MASS, NAME=z, MASS=1, X=1e10'//newline//'*JOINT, NAME=w, TYPE=REVOLUTE'//newline//' z, ground.far'// &
      & newline)
   call check_short_spring('')
   call check_short_spring(', 0')
   call finish()

contains

   !> Runs a deck; the largest error of the channel `err` relative to the amplitude 1, steps, and warnings.
   subroutine run_scene(text, name, off, steps, report)
      character(*), intent(in) :: text, name
      real(wp), intent(out) :: off
      integer, intent(out) :: steps
      character(:), allocatable, intent(out) :: report
      type(error_type), allocatable :: error
      type(history_reader_type) :: reader
      call run_text(text, trim(results), report, error)
      call check_no_error(error, name)
      off = huge(off)
      steps = 0
      if (allocated(error)) return
      call reader%open(trim(results), error)
      off = maxval(abs(channel(reader, 'err')))
      call reader%close()
      steps = steps_of(report)
   end subroutine run_scene

   !> Steps of the run that a report tells.
   integer function steps_of(report) result(steps)
      character(*), intent(in) :: report
      integer :: at, behind, status
      steps = 0
      behind = index(report, ' steps (')
      if (behind == 0) return
      at = index(report(:behind - 1), ' ', back=.true.)
      read (report(at + 1:behind - 1), *, iostat=status) steps
      call check(status == 0, 'number of steps')
   end function steps_of

   !> Errors of a sixteenth are told, and small ones are not.
   subroutine check_told(name, off, report)
      character(*), intent(in) :: name, report
      real(wp), intent(in) :: off
      logical :: tells
      tells = index(report, "body 'm' moves by") > 0
      if (off > 1.0_wp/16) call check(tells, name//': '//as_text(100*off, 2)//' % off, and not told: '//report)
      if (off < 4.0e-3_wp) call check(.not. tells, name//': off by '//as_text(100*off, 2)//' %: '//report)
   end subroutine check_told

   function analysis(integrator, end) result(text)
      character(*), intent(in) :: integrator, end
      character(:), allocatable :: text
      text = '*DYNAMICS, END='//end//', OUTPUTS=100, INTEGRATOR='//integrator//newline//'*OUTPUT'//newline
   end function analysis

   !> A point of the ground that nothing uses changes nothing, wherever it is.
   subroutine check_unused(integrator)
      character(*), intent(in) :: integrator
      real(wp) :: off, off_near
      integer :: steps, steps_near
      call run_free('', integrator, off_near, steps_near)
      call run_free('*GROUND'//newline//' far, 1e4, 0'//newline, integrator, off, steps)
      print '(2a,2es10.2,2i7)', integrator, ', an unused point: errors, steps', off_near, off, steps_near, steps
      call check(steps == steps_near, integrator//': steps with an unused point')
      call check_close(off, off_near, 1.0e-12_wp, integrator//': error with an unused point')
      call check(off < 0.01_wp, integrator//': error beside an unused point: '//as_text(off, 2))
   end subroutine check_unused

   !> A mass on a spring, with or without other points of the ground.
   subroutine run_free(ground, integrator, off, steps)
      character(*), intent(in) :: ground, integrator
      real(wp), intent(out) :: off
      integer, intent(out) :: steps
      character(:), allocatable :: report
      call run_scene(ground//'*POINT MASS, NAME=m, MASS=1, X=1e-3'//newline//'*BUSHING, NAME=b, '//mount//' m, ground.origin'// &
         & newline//analysis(integrator, '0.5')//' err = x(m)/1e-3 - cos(100*t)'//newline, integrator//', an unused point', &
         & off, steps, report)
   end subroutine run_free

   !> A mass falls onto its spring beside a far body that a joint holds.
   subroutine check_on_ground(integrator)
      character(*), intent(in) :: integrator
      character(:), allocatable :: report
      real(wp) :: off
      integer :: steps
      call run_scene('*GROUND'//newline//' far, 1e5, 0'//newline//'*POINT MASS, NAME=z, MASS=1, X=1e5'//newline// &
         & '*JOINT, NAME=w, TYPE=REVOLUTE'//newline//' z, ground.far'//newline//'*POINT MASS, NAME=m, MASS=1'//newline// &
         & '*BUSHING, NAME=b, '//mount//' m, ground.origin'//newline//'*GRAVITY'//newline//analysis(integrator, '0.2')// &
         & ' err = y(m)*1e4/9.81 + 1 - cos(100*t)'//newline, integrator//', beside a far body', off, steps, report)
      print '(2a,es10.2,i7)', integrator, ', beside a far body: error, steps', off, steps
      call check(off < 0.01_wp, integrator//': error beside a far body: '//as_text(off, 2))
   end subroutine check_on_ground

   !> A mass far from the origin, at the place where a spring holds it, under a sudden force.
   subroutine check_at_seat(integrator)
      character(*), intent(in) :: integrator
      character(:), allocatable :: report
      real(wp) :: off
      integer :: steps
      call run_scene('*GROUND'//newline//' seat, 1e4, 0'//newline//'*POINT MASS, NAME=m, MASS=1, X=1e4'//newline// &
         & '*BUSHING, NAME=b, '//mount//' m, ground.seat'//newline//'*FORCE, NAME=f, POINT=m'//newline//' 0, 10'//newline// &
         & analysis(integrator, '1')//' err = y(m)/1e-3 - 1 + cos(100*t)'//newline, integrator//', far from the origin', off, &
         & steps, report)
      print '(2a,es10.2,i7)', integrator, ', far from the origin: error, steps', off, steps
      call check(off < 0.04_wp, integrator//': error far from the origin: '//as_text(off, 2))
      call check_told(integrator//', far from the origin', off, report)
   end subroutine check_at_seat

   !> A bridge of 100 m on a hinge and a roller.
   function bridge() result(text)
      character(:), allocatable :: text
      text = '*GROUND'//newline//' right, 100, 0'//newline//' middle, 50, 0'//newline// &
         & '*RIGID BODY, NAME=bridge, MASS=1e5, INERTIA=1e8, CENTRE X=50'//newline//' right, 100, 0'//newline//' seat, 50, 0'// &
         & newline//'*POINT MASS, NAME=m, MASS=1, X=50, Y=1e-3'//newline//'*JOINT, NAME=hinge, TYPE=REVOLUTE'//newline// &
         & ' bridge, ground.origin'//newline//'*JOINT, NAME=roller, TYPE=POINT ON LINE'//newline//' bridge.right, ground.right'// &
         & newline
   end function bridge

   !> A machine of 100 rad/s stands on the ground beside a bridge.
   subroutine check_beside_bridge(integrator)
      character(*), intent(in) :: integrator
      character(:), allocatable :: report
      real(wp) :: off
      integer :: steps
      call run_scene(bridge()//'*BUSHING, NAME=b, '//mount//' m, ground.middle'//newline//analysis(integrator, '1')// &
         & ' err = y(m)/1e-3 - cos(100*t)'//newline, integrator//', beside a bridge', off, steps, report)
      print '(2a,es10.2,i7)', integrator, ', beside a bridge: error, steps', off, steps
      call check(off < 0.01_wp, integrator//': error beside a bridge: '//as_text(off, 2))
   end subroutine check_beside_bridge

   !> The same on the bridge, which is what its errors are judged by: that is told.
   subroutine check_on_bridge(integrator)
      character(*), intent(in) :: integrator
      character(:), allocatable :: report
      real(wp) :: off
      integer :: steps
      call run_scene(bridge()//'*BUSHING, NAME=b, '//mount//' m, bridge.seat'//newline//analysis(integrator, '1')// &
         & ' err = y(m)/1e-3 - cos(100*t)'//newline, integrator//', on a bridge', off, steps, report)
      print '(2a,es10.2,i7)', integrator, ', on a bridge: error, steps', off, steps
      call check_told(integrator//', on a bridge', off, report)
   end subroutine check_on_bridge

   !> A mass on a rail at the end of a spring of 10 m vibrates by little.
   subroutine check_rail(integrator, amplitude)
      character(*), intent(in) :: integrator, amplitude
      character(:), allocatable :: report
      real(wp) :: off
      integer :: steps
      call run_scene('*GROUND'//newline//' a, -10, 0'//newline//'*POINT MASS, NAME=m, MASS=1, X='//amplitude//newline// &
         & '*JOINT, NAME=w, TYPE=POINT ON LINE'//newline//' m, ground.origin'//newline// &
         & '*SPRING, NAME=s, STIFFNESS=1e4, LENGTH=10'//newline//' ground.a, m'//newline//analysis(integrator, '1')// &
         & ' err = x(m)/'//amplitude//' - cos(100*t)'//newline, integrator//', on a rail', off, steps, report)
      print '(4a,es10.2,i7)', integrator, ', on a rail, ', amplitude, ': error, steps', off, steps
      call check_told(integrator//', on a rail, '//amplitude, off, report)
   end subroutine check_rail

   !> A mass of the weight 9.81 hangs on a spring of 98.1 and 1 m, beside a far point that nothing uses, or that is used.
   subroutine check_statics(far)
      character(*), intent(in) :: far
      character(:), allocatable :: report
      type(error_type), allocatable :: error
      type(history_reader_type) :: reader
      call run_text('*GROUND'//newline//' far, 1e10, 0'//newline//far//'*POINT MASS, NAME=m, MASS=1, Y=-1'//newline// &
         & '*SPRING, NAME=s, STIFFNESS=98.1, LENGTH=1'//newline//' m, ground.origin'//newline//'*GRAVITY'//newline//'*STATICS'// &
         & newline//'*OUTPUT'//newline//' y = y(m)'//newline, trim(results), report, error)
      call check_no_error(error, 'a spring beside a far point')
      if (allocated(error)) return
      call reader%open(trim(results), error)
      associate (y => channel(reader, 'y'))
         call check_close(y(size(y)), -1.1_wp, 1.0e-9_wp, 'a spring beside a far point')
      end associate
      call reader%close()
   end subroutine check_statics

   !> Two masses on a spring of half a millimetre, beside a body 1e7 away: they are 0.5 + 0.2 cos(w t) mm apart, w^2 = k (1/m +
   !> 1/M).
   subroutine check_short_spring(law)
      !> Of the spring, beside its stiffness
      character(*), intent(in) :: law
      character(:), allocatable :: report
      real(wp) :: off
      integer :: steps
      call run_scene('*GROUND'//newline//' far, 1e7, 0'//newline//'*POINT MASS, NAME=z, MASS=1, X=1e7'//newline// &
         & '*JOINT, NAME=w, TYPE=REVOLUTE'//newline//' z, ground.far'//newline//'*POINT MASS, NAME=m, MASS=1'//newline// &
         & '*POINT MASS, NAME=n, MASS=2, X=0.7e-3'//newline//'*SPRING, NAME=s, STIFFNESS=10, LENGTH=0.5e-3'//newline// &
         & ' m, n'//law//newline//analysis('ADAMS', '2')//' err = (x(n) - x(m) - 0.5e-3)/0.2e-3 - cos(sqrt(15)*t)'//newline, &
         & 'a short spring', off, steps, report)
      call check(off < 1.0e-3_wp, 'a short spring'//law//': '//as_text(off, 2))
   end subroutine check_short_spring

end program test_scales
