!> Branches of static equilibria against closed forms: kept or left through a bifurcation whatever the increments are, from an
!> unstable start, under loads that come and go between two increments; and what messages say. Usage, in tests/:
!> test_static_branches RESULT_FILE
program test_static_branches
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use limber_output_history_reader, only: history_reader_type
   use runs, only: channel, run_text
   use testing, only: check, check_close, finish
   implicit none
   real(wp), parameter :: pi = acos(-1.0_wp)
   character(1), parameter :: nl = new_line('a')
   character(256) :: results

   call get_command_argument(1, results)
   call check_bifurcation()
   call check_second_bifurcation()
   call check_unloading()
   call check_unstable_start()
   call check_pulses()
   call check_two_pulses()
   call check_open_chain()
   call check_far_rack()
   call check_turning_weight()
   call check_cubic()
   call finish()

contains

   !> Runs a deck and gives its first channel and report; not allocated after an error, which is told then.
   subroutine run(deck, name, report, values, times, message)
      character(*), intent(in) :: deck, name
      character(:), allocatable, intent(out) :: report
      real(wp), allocatable, intent(out) :: values(:)
      real(wp), allocatable, intent(out), optional :: times(:)
      !> Of the error that the run must end with
      character(:), allocatable, intent(out), optional :: message
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      call run_text(deck, trim(results), report, error)
      if (present(message)) then
         message = ''
         if (allocated(error)) message = error%message
         return
      end if
      if (allocated(error)) call check(.false., trim(name)//': '//error%message)
      if (allocated(error)) return
      call reader%open(trim(results), error)
      values = channel(reader, 'c')
      if (present(times)) times = channel(reader, 't')
      call reader%close()
   end subroutine run

   !> An upright bar on a rotational spring k under a dead load P on its end: upright it is in equilibrium under each load, stable
   !> below P L = k. Beyond that k a = P L sin(a).
   subroutine check_bifurcation()
      character(*), parameter :: scene = '*RIGID BODY, NAME=p, MASS=2, INERTIA=0.1, ANGLE=pi/2'//nl//' end, 1, 0'//nl// &
         & '*JOINT, NAME=h, TYPE=REVOLUTE'//nl//' p, ground.origin'//nl//'*SPRING, NAME=s, TYPE=ROTATIONAL, STIFFNESS=10'// &
         & ', ANGLE=-pi/2'//nl//' p, ground.origin'//nl//'*FORCE, NAME=f, POINT=p.end'//nl//' 0, -20*t'//nl// &
         & '*STATICS, INSTABILITY=', asked = nl//'*OUTPUT'//nl//' c = angle(p), t = t'//nl
      character(5), parameter :: choices(3) = ['STAY ', 'LEAVE', 'STOP ']
      character(:), allocatable :: report
      character(120) :: name
      real(wp), allocatable :: angle(:), time(:)
      integer :: i, n
      do i = 1, 3
         do n = 1, 24
            name = trim(choices(i))//', increments: '//as_text(n)
            call run(scene//trim(choices(i))//', INCREMENTS='//as_text(n)//asked, name, report, angle, time)
            if (.not. allocated(angle)) cycle
            call check(index(report, 'turns unstable at t = 0.5, ') > 0, trim(name)//': '//report)
            call check(index(report, 'turns unstable') == index(report, 'turns unstable', back=.true.), &
               & trim(name)//': once: '//report)
            call check(index(report, 'equilibrium ends') == 0, trim(name)//': upright does not end: '//report)
            if (i == 2) then
               call check_close(maxval(abs(10*(angle - pi/2) - 20*time*sin(angle - pi/2))), 0.0_wp, 1.0e-7_wp, &
                  & trim(name)//': balance')
               call check(all(abs(angle - pi/2) > 0.1_wp .or. time < 0.51_wp), trim(name)//': it has left')
               call check_close(abs(angle(size(angle)) - pi/2), 1.8954942670340_wp, 1.0e-9_wp, trim(name)//': last place')
            else
               call check_close(maxval(abs(angle - pi/2)), 0.0_wp, 1.0e-9_wp, trim(name)//': it stays upright')
               call check_close(time(size(time)), merge(1.0_wp, 0.5_wp, i == 1), 1.0e-9_wp, trim(name)//': last time')
            end if
         end do
      end do
   end subroutine check_bifurcation

   !> Two bars on springs k under a dead load: critical at (3 -+ sqrt(5))/2 k/L, both of which the branch passes; a load that is
   !> critical at a sample, and at the end.
   subroutine check_second_bifurcation()
      character(:), allocatable :: report
      character(120) :: name
      real(wp), allocatable :: angle(:), time(:)
      real(wp), parameter :: loads(3) = [30.0_wp, 5*(3 - sqrt(5.0_wp)), 10*(3 - sqrt(5.0_wp))]
      integer :: i, n
      do i = 1, 3
         do n = 1, 7
            name = 'two bars, load '//as_text(loads(i), 17)//', increments: '//as_text(n)
            call run('*RIGID BODY, NAME=p, MASS=2, INERTIA=0.1, ANGLE=pi/2'//nl//' end, 1, 0'//nl//'*RIGID BODY, NAME=q, MASS=2'// &
               & ', INERTIA=0.1, ANGLE=pi/2, Y=1'//nl//' end, 1, 0'//nl//'*JOINT, NAME=h, TYPE=REVOLUTE'//nl// &
               & ' p, ground.origin'//nl//'*JOINT, NAME=i, TYPE=REVOLUTE'//nl//' q, p.end'//nl// &
               & '*SPRING, NAME=s, TYPE=ROTATIONAL, STIFFNESS=10, ANGLE=-pi/2'//nl//' p, ground.origin'//nl// &
               & '*SPRING, NAME=r, TYPE=ROTATIONAL, STIFFNESS=10'//nl//' p.end, q'// &
               & nl//'*FORCE, NAME=f, POINT=q.end'//nl//' 0, -'//as_text(loads(i), 17)//'*t'//nl// &
               & '*STATICS, INSTABILITY=STAY, INCREMENTS='//as_text(n)//nl//'*OUTPUT'//nl//' c = angle(q), t = t'//nl, name, &
               & report, angle, time)
            if (.not. allocated(angle)) cycle
            call check_close(maxval(abs(angle - pi/2)), 0.0_wp, 1.0e-9_wp, trim(name)//': straight')
            call check_close(time(size(time)), 1.0_wp, 1.0e-12_wp, trim(name)//': to the end')
            call check(index(report, 'equilibrium ends') == 0, trim(name)//': it does not end: '//report)
            if (i /= 2) call check(index(report, 'turns unstable at t = '//as_text(5*(3 - sqrt(5.0_wp))/loads(i), 8)) > 0, &
               & trim(name)//': its critical load: '//report)
            if (i == 2) call check(index(report, 'at t = 1') > 0, trim(name)//': its critical load at the end: '//report)
         end do
      end do
   end subroutine check_second_bifurcation

   !> A hanging bar whose weight vanishes at the end: nothing holds it there, which is told.
   subroutine check_unloading()
      character(:), allocatable :: report
      character(120) :: name
      real(wp), allocatable :: angle(:)
      integer :: n
      do n = 1, 5
         name = 'unloaded, increments: '//as_text(n)
         call run('*RIGID BODY, NAME=p, MASS=2, INERTIA=0.1, ANGLE=-pi/2'//nl//' end, 1, 0'//nl//'*JOINT, NAME=h'// &
            & ', TYPE=REVOLUTE'//nl//' p, ground.origin'//nl//'*FORCE, NAME=f, POINT=p.end'//nl//' 0, -20*(1 - t)'//nl// &
            & '*STATICS, INCREMENTS='//as_text(n)//nl//'*OUTPUT'//nl//' c = angle(p)'//nl, name, report, angle)
         if (.not. allocated(angle)) cycle
         call check_close(maxval(abs(angle + pi/2)), 0.0_wp, 1.0e-9_wp, trim(name))
         call check(index(report, 'equilibrium is neutral at t = 1') > 0, trim(name)//': told: '//report)
      end do
   end subroutine check_unloading

   !> A pendulum placed exactly upright: kept there, with its weight in the hinge, or the run stops, or it hangs.
   subroutine check_unstable_start()
      character(5), parameter :: choices(3) = ['STAY ', 'STOP ', 'LEAVE']
      character(:), allocatable :: report
      character(120) :: name
      real(wp), allocatable :: force(:), angle(:)
      integer :: i, k, ramp
      do i = 1, 3
         do ramp = 1, 2
            do k = 1, 2
               name = 'upright, '//trim(choices(i))//trim(merge(', RAMP=NO ', ', RAMP=YES', ramp == 1))
               call run('*RIGID BODY, NAME=p, MASS=2, INERTIA=0.1, CENTRE X=0.5, ANGLE=pi/2'//nl//'*JOINT, NAME=h'// &
                  & ', TYPE=REVOLUTE'//nl//' p, ground.origin'//nl//'*GRAVITY'//nl//'*STATICS, INCREMENTS=2, INSTABILITY='// &
                  & trim(choices(i))//trim(merge(', RAMP=NO ', ', RAMP=YES', ramp == 1))//nl//'*OUTPUT'//nl// &
                  & trim(merge(' c = force_y(h)', ' c = angle(p)  ', k == 1))//nl, name, report, force)
               if (.not. allocated(force)) cycle
               if (k == 2) angle = force
               if (i < 3) call check(index(report, 'equilibrium is unstable at t = ') > 0, trim(name)//': told: '//report)
               call check(size(force) == merge(1, 3, i == 2), trim(name)//': samples')
               if (k == 1 .and. ramp == 1) call check_close(maxval(abs(force - 19.62_wp)), 0.0_wp, 1.0e-9_wp, &
                  & trim(name)//': weight')
               if (k == 1 .and. i /= 2) call check_close(force(3), 19.62_wp, 1.0e-9_wp, trim(name)//': weight at the end')
               if (k == 2) call check_close(maxval(abs(cos(angle))), 0.0_wp, 1.0e-9_wp, trim(name)//': up or down')
               if (k == 2) call check_close(sin(angle(size(angle))), merge(-1.0_wp, 1.0_wp, i == 3), 1.0e-9_wp, &
                  & trim(name)//': angle')
            end do
         end do
      end do
   end subroutine check_unstable_start

   !> A shallow truss with the limit load 9.95: pulses of 15 snap it through, pulses of 9.5 do not, wherever they are between two
   !> increments. Under no load the snapped truss is at y = -0.3.
   subroutine check_pulses()
      character(60), parameter :: pulses(13) = [character(60) :: 'step(t - 0.41)*step(0.47 - t)', 'sin(pi*t)', &
         & 'exp(-((t - 0.44)/0.01)**2)', 'exp(-((t - 0.443)/1e-5)**2)', '4*t*(1 - t)', &
         & 'smoothstep((t - 0.4)/0.03)*step(0.45 - t)', 'pulse(t)', &
         & '(1 + 1e-3*y(m))*step(t - 0.41)*step(0.47 - t)', 't/0.44*step(0.44 - t)', '(1 - cos(14*pi*t))/2', &
         & 'step(t - 0.41)*step(0.41000001 - t)', '16*t**2*(1 - t)**2', 'sin(pi*t)**3*(1 + 1e-3*y(m))']
      integer, parameter :: increments(5) = [1, 2, 3, 10, 14]
      character(:), allocatable :: report
      character(120) :: name
      real(wp), allocatable :: y(:)
      integer :: i, n, big
      do i = 1, size(pulses)
         do n = 1, size(increments)
            do big = 1, 2
               name = merge('15 ', '9.5', big == 1)//'*'//trim(pulses(i))//', increments: '//as_text(increments(n))
               call run(pulse_of(pulses(i))//truss()//'*FORCE, NAME=f, POINT=m'//nl//' 0, -'// &
                  & trim(merge('15 ', '9.5', big == 1))//'*('//trim(pulses(i))//')'//nl// &
                  & '*STATICS, INCREMENTS='//as_text(increments(n))//nl//'*OUTPUT'//nl//' c = y(m)'//nl, &
                  & name, report, y)
               if (.not. allocated(y)) cycle
               call check_close(y(size(y)), merge(-0.3_wp, 0.3_wp, big == 1), 1.0e-9_wp, trim(name))
               call check(index(report, 'warning') == 0, trim(name)//': '//report)
            end do
         end do
      end do
      call run(truss()//'*FORCE, NAME=f, POINT=m'//nl//' 0, -5*sin(1e5*t)'//nl//'*STATICS'//nl//'*OUTPUT'//nl//' c = y(m)'//nl, &
         & 'many turns', report, y)
      call check(index(report, "the law of 'f' turns back too often") > 0, 'more turns than are looked at are told: '//report)
   end subroutine check_pulses

   !> The table of a law, if the law asks for it.
   function pulse_of(law) result(text)
      character(*), intent(in) :: law
      character(:), allocatable :: text
      text = ''
      if (index(law, 'pulse(') > 0) text = '*TABLE, NAME=pulse'//nl//' 0, 0'//nl//' 0.42, 0'//nl//' 0.43, 1'//nl//' 0.44, 0'// &
         & nl//' 1, 0'//nl
   end function pulse_of

   function truss() result(text)
      character(:), allocatable :: text
      text = '*PARAMETER'//nl//' l0 = sqrt(1 + 0.3**2)'//nl//'*GROUND'//nl//' a, -1, 0'//nl//' b, 1, 0'//nl// &
         & '*POINT MASS, NAME=m, MASS=1, Y=0.3'//nl//'*JOINT, NAME=g, TYPE=POINT ON LINE, ANGLE=pi/2'//nl//' m, ground.origin'// &
         & nl//'*SPRING, NAME=s1, STIFFNESS=1000, LENGTH=l0'//nl//' m, ground.a'//nl// &
         & '*SPRING, NAME=s2, STIFFNESS=1000, LENGTH=l0'//nl//' m, ground.b'//nl
   end function truss

   !> Two loads that balance at the end, but not on the way; and a driver that pushes by way of a spring, and returns.
   subroutine check_two_pulses()
      character(:), allocatable :: report
      real(wp), allocatable :: y(:)
      call run(truss()//'*FORCE, NAME=f, POINT=m'//nl//' 0, -15*smoothstep(t/0.1)'//nl//'*FORCE, NAME=g2, POINT=m'//nl// &
         & ' 0, 15*smoothstep((t - 0.8)/0.1)'//nl//'*STATICS, INCREMENTS=1'//nl//'*OUTPUT'//nl//' c = y(m)'//nl, 'two loads', &
         & report, y)
      if (allocated(y)) call check_close(y(size(y)), -0.3_wp, 1.0e-9_wp, 'one load behind the other')
      call run(truss()//'*POINT MASS, NAME=n, MASS=1, Y=1.8'//nl//'*JOINT, NAME=j, TYPE=POINT ON LINE, ANGLE=pi/2'//nl// &
         & ' n, ground.origin'//nl//'*DRIVER, NAME=d, TYPE=DISPLACEMENT, JOINT=j'//nl//' 1.8 - 0.9*sin(pi*t)'//nl// &
         & '*SPRING, NAME=s3, STIFFNESS=15, LENGTH=1.5'//nl//' m, n'//nl//'*STATICS, INCREMENTS=1'//nl//'*OUTPUT'//nl// &
         & ' c = y(m)'//nl, 'a driver', report, y)
      if (.not. allocated(y)) return
      associate (last => y(size(y)), free => sqrt(1.09_wp))
         call check(last < -0.2_wp, 'a driver that returns leaves the truss snapped')
         call check_close(15*(0.3_wp - last) - 2000*last*(1 - free/sqrt(1 + last**2)), 0.0_wp, 1.0e-8_wp, 'forces at its end')
      end associate
   end subroutine check_two_pulses

   !> Three hinged bars with springs under their weight and a force that follows the last one: the moments at each hinge are in
   !> balance at the end, and the place does not depend on the increments, but for whole turns. No constraint is in the way.
   subroutine check_open_chain()
      real(wp), parameter :: k(3) = [5.785_wp, 7.184_wp, 13.843_wp], m(3) = [0.854_wp, 1.094_wp, 0.6_wp]
      character(:), allocatable :: report, deck
      character(120) :: name
      real(wp), allocatable :: a(:)
      real(wp) :: angle(3), first(3), start(2, 4), centre(2), force(2), moment
      integer :: i, j, n
      deck = '*GRAVITY'//nl
      do i = 1, 3
         deck = deck//'*RIGID BODY, NAME=b'//as_text(i)//', MASS='//as_text(m(i), 5)//', INERTIA=0.1, CENTRE X=0.4, X='// &
            & as_text(i - 1)//nl//' e, 1, 0'//nl//'*JOINT, NAME=j'//as_text(i)//', TYPE=REVOLUTE'//nl//' b'//as_text(i)//', '// &
            & before(i)//nl//'*SPRING, NAME=s'//as_text(i)//', TYPE=ROTATIONAL, STIFFNESS='//as_text(k(i), 6)//nl//' '// &
            & before(i)//', b'//as_text(i)//nl
      end do
      do n = 1, 11
         do j = 1, 3
            name = 'open chain, increments: '//as_text(n)
            call run(deck//'*FORCE, NAME=f, POINT=b3.e, FOLLOWER'//nl//' 24.036*t, 21.213*t'//nl//'*STATICS, INCREMENTS='// &
               & as_text(n)//nl//'*OUTPUT'//nl//' c = angle(b'//as_text(j)//')'//nl, name, report, a)
            if (.not. allocated(a)) return
            angle(j) = a(size(a))
         end do
         if (n == 1) first = angle
         call check_close(minval(cos(angle - first)), 1.0_wp, 1.0e-9_wp, trim(name)//': the same place')
         start(:, 1) = 0.0_wp
         do i = 1, 3
            start(:, i + 1) = start(:, i) + [cos(angle(i)), sin(angle(i))]
         end do
         force = [24.036_wp*cos(angle(3)) - 21.213_wp*sin(angle(3)), 24.036_wp*sin(angle(3)) + 21.213_wp*cos(angle(3))]
         do i = 1, 3
            moment = (start(1, 4) - start(1, i))*force(2) - (start(2, 4) - start(2, i))*force(1)
            do j = i, 3
               centre = start(:, j) + 0.4_wp*[cos(angle(j)), sin(angle(j))]
               moment = moment - 9.81_wp*m(j)*(centre(1) - start(1, i))
            end do
            moment = moment - k(i)*(angle(i) - merge(0.0_wp, angle(max(1, i - 1)), i == 1))
            ! A leap may count whole turns otherwise than the angle does
            moment = moment - 2*pi*k(i)*anint(moment/(2*pi*k(i)))
            call check_close(moment, 0.0_wp, 1.0e-6_wp, trim(name)//': moments at hinge '//as_text(i))
         end do
      end do

   end subroutine check_open_chain

   !> What a bar of the chain hangs on.
   function before(i) result(text)
      integer, intent(in) :: i
      character(:), allocatable :: text
      text = 'ground.origin'
      if (i > 1) text = 'b'//as_text(i - 1)//'.e'
   end function before

   !> A pinion under a torque of 40 pulls a rack on a spring of 0.5 by 80: it turns by 80 rad at once, without increments.
   subroutine check_far_rack()
      character(:), allocatable :: report
      real(wp), allocatable :: x(:)
      call run('*GROUND'//nl//' p, 3, -1'//nl//' o, 0, -1'//nl//'*RIGID BODY, NAME=b, MASS=1, INERTIA=0.1'//nl// &
         & '*RIGID BODY, NAME=k, MASS=1, INERTIA=0.1, Y=-1'//nl//'*JOINT, NAME=j, TYPE=REVOLUTE'//nl//' b, ground.origin'//nl// &
         & '*JOINT, NAME=l, TYPE=TRANSLATIONAL'//nl//' k, ground.o'//nl//'*JOINT, NAME=r, TYPE=RACK, RADIUS=1'//nl//' b, k'//nl// &
         & '*SPRING, NAME=s, STIFFNESS=0.5, LENGTH=3'//nl//' k, ground.p'//nl//'*TORQUE, NAME=t, BODY=b'//nl//' 40'//nl// &
         & '*STATICS, PERIOD=0, RAMP=NO'//nl//'*OUTPUT'//nl//' c = elongation(s)'//nl, 'a rack', report, x)
      if (allocated(x)) call check_close(x(size(x)), 80.0_wp, 1.0e-8_wp, 'a pinion pulls its rack far off')
   end subroutine check_far_rack

   !> In a steady rotation the weight turns with the frame, which is told; without weight nothing is.
   subroutine check_turning_weight()
      character(:), allocatable :: report
      real(wp), allocatable :: x(:)
      integer :: i
      do i = 1, 2
         call run(trim(merge('*GRAVITY', '**      ', i == 1))//nl//'*RIGID BODY, NAME=b, MASS=1, INERTIA=0.1, X=1'//nl// &
            & '*JOINT, NAME=j, TYPE=TRANSLATIONAL'//nl//' b, ground.origin'//nl//'*SPRING, NAME=s, STIFFNESS=100, LENGTH=1'//nl// &
            & ' b, ground.origin'//nl//'*STATICS, ROTATION=2, INCREMENTS=1'//nl//'*OUTPUT'//nl//' c = x(b)'//nl, 'rotation', &
            & report, x)
         if (.not. allocated(x)) return
         call check_close(x(size(x)), 100/96.0_wp, 1.0e-9_wp, 'a bar on a spring in rotation')
         call check((index(report, 'the weight turns with them') > 0) .eqv. i == 1, 'the weight that turns is told: '//report)
      end do
   end subroutine check_turning_weight

   !> A law x**3 alone holds a mass at x = 0, where its stiffness vanishes: it is there, or the message says what is the case.
   subroutine check_cubic()
      character(40), parameter :: options(4) = [character(40) :: 'INCREMENTS=10', 'RAMP=NO', 'RAMP=NO, PERIOD=0', 'INCREMENTS=2']
      character(6), parameter :: starts(3) = ['0.1   ', '0     ', '-0.2  ']
      character(:), allocatable :: report, message
      real(wp), allocatable :: x(:)
      integer :: i, k
      do i = 1, size(options)
         do k = 1, size(starts)
            call run('*POINT MASS, NAME=m, MASS=1, X='//trim(starts(k))//nl//'*JOINT, NAME=g, TYPE=POINT ON LINE'//nl// &
               & ' m, ground.origin'//nl//'*FORCE, NAME=f, POINT=m'//nl//' -100*x(m)**3, 0'//nl//'*STATICS, '//trim(options(i))// &
               & nl//'*OUTPUT'//nl//' c = x(m)'//nl, 'cubic', report, x, message=message)
            if (message /= '') then
               call check(index(message, 'without a stiffness against it') > 0, 'cubic: '//message)
            else
               call check(index(report, 'turns unstable') == 0, 'a cubic spring is not unstable: '//report)
            end if
         end do
      end do
   end subroutine check_cubic

end program test_static_branches
