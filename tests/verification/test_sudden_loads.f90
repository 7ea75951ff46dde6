!> Loads that come suddenly or fast on default beams: deflections and bending moments are right to a hundredth, or warned of with at
!> least a third of their error; loads that come slowly are not warned of. Truth: sums of the modes of straight beams in closed
!> form, on pins, clamped at one end, and on a foot that shakes. Reactions of other bodies, forces along a beam and laws that jump
!> at a place: told, with at least half of their error. Damped beams: told, with at least their error. Usage, in
!> tests/: test_sudden_loads RESULT_FILE
program test_sudden_loads
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_commands_run, only: run_deck
   use limber_output_history_reader, only: history_reader_type
   use runs, only: channel
   use testing, only: check, check_no_error, finish
   implicit none
   character(*), parameter :: nl = new_line('a')
   !> E I = 1, E A = 1e6, mass per length 1
   character(*), parameter :: bar = '*MATERIAL, NAME=stuff, YOUNG=1e6, DENSITY=1'//nl// &
      & '*SECTION, NAME=bar, SHAPE=GENERAL, AREA=1, INERTIA=1e-6'//nl// &
      & '*BEAM, NAME=bar, MATERIAL=stuff, SECTION=bar, LENGTH=1'//nl
   character(*), parameter :: pins = bar//'*JOINT, NAME=pin, TYPE=REVOLUTE'//nl//' bar.start, ground.origin'//nl//'*GROUND'//nl// &
      & ' far, 1, 0'//nl//'*JOINT, NAME=roller, TYPE=POINT ON LINE'//nl//' bar.end, ground.far'//nl
   character(*), parameter :: wall = bar//'*JOINT, NAME=wall, TYPE=WELD, TURN=0'//nl//' bar.start, ground.origin'//nl
   character(*), parameter :: foot = bar//'*RIGID BODY, NAME=foot, MASS=1, INERTIA=1'//nl//'*MOTION, NAME=shake, BODY=foot'//nl// &
      & ' 0, 1e-6*(1 - cos(199.859530*t)), 0'//nl//'*JOINT, NAME=wall, TYPE=WELD, TURN=0'//nl//' bar.start, foot.origin'//nl
   character(*), parameter :: at_middle = '*FORCE, NAME=load, POINT=bar.middle'//nl//' 0, '
   character(*), parameter :: at_tip = '*FORCE, NAME=load, POINT=bar.end'//nl//' 0, '
   !> Places where deflection and moment are asked for: the middle on pins; tip and start of a cantilever
   integer, parameter :: on_pins = 1, clamped = 2
   !> How loads depend on time: there at once; from t = 0.5 on; for 0.01; a sine; a cosine
   integer, parameter :: step = 1, late = 2, pulse = 3, harmonic = 4, shaken = 5
   integer, parameter :: modes = 300
   real(wp), parameter :: pi = acos(-1.0_wp), load = 1.0e-3_wp
   character(256) :: results

   call get_command_argument(1, results)
   call check_pins()
   call check_cantilever()
   call check_damped()
   call check_hub()
   call check_bob()
   call check_head()
   call check_rod()
   call check_place()
   call check_running_start()
   call check_trolley()
   call finish()

contains

   !> A beam on pins: forces in its middle, a spread load.
   subroutine check_pins()
      real(wp) :: force(modes)
      integer :: n
      force = [(load*sqrt(2.0_wp)*sin(0.5_wp*n*pi), n=1, modes)]
      call judge('pins, step', pins//at_middle//'1e-3'//nl, 1.0_wp, on_pins, step, force, 0.0_wp, .true.)
      call judge('pins, later step', pins//at_middle//'1e-3*step(t - 0.5)'//nl, 1.5_wp, on_pins, late, force, 0.0_wp, .true.)
      call judge('pins, pulse', pins//at_middle//'1e-3*step(0.01 - t)'//nl, 1.0_wp, on_pins, pulse, force, 0.0_wp, .true.)
      call judge('pins, slow force', pins//at_middle//'1e-3*sin(5*t)'//nl, 2.0_wp, on_pins, harmonic, force, 5.0_wp, .false.)
      call judge('pins, fifth frequency', pins//at_middle//'1e-3*sin(246.74011*t)'//nl, 0.5_wp, on_pins, harmonic, force, &
         & 25*pi**2, .true.)
      force = [(load*sqrt(2.0_wp)*(1 - cos(n*pi))/(n*pi), n=1, modes)]
      call judge('pins, spread load', pins//'*DISTRIBUTED LOAD, NAME=load, BODY=bar'//nl//' 0, 1e-3'//nl, 1.0_wp, on_pins, step, &
         & force, 0.0_wp, .false.)
   end subroutine check_pins

   !> A cantilever: forces and a couple at its tip, its weight, a foot that shakes.
   subroutine check_cantilever()
      real(wp) :: force(modes), beta, sigma, tip(0:1)
      integer :: n
      do n = 1, modes
         call find_cantilever(n, beta, sigma)
         tip = cantilever_tip(beta, sigma)
         force(n) = load*tip(0)
      end do
      call judge('cantilever, step', wall//at_tip//'1e-3'//nl, 4.0_wp, clamped, step, force, 0.0_wp, .true.)
      call judge('cantilever, pulse', wall//at_tip//'1e-3*step(0.01 - t)'//nl, 2.0_wp, clamped, pulse, force, 0.0_wp, .true.)
      call judge('cantilever, slow force', wall//at_tip//'1e-3*sin(2*t)'//nl, 4.0_wp, clamped, harmonic, force, 2.0_wp, .false.)
      call judge('cantilever, fifth frequency', wall//at_tip//'1e-5*sin(199.859530*t)'//nl, 1.0_wp, clamped, harmonic, &
         & 0.01_wp*force, 199.859530_wp, .true.)
      do n = 1, modes
         call find_cantilever(n, beta, sigma)
         tip = cantilever_tip(beta, sigma)
         force(n) = load*tip(1)
      end do
      call judge('cantilever, couple', wall//'*TORQUE, NAME=load, POINT=bar.end'//nl//' 1e-3'//nl, 4.0_wp, clamped, step, force, &
         & 0.0_wp, .true., .false.)
      do n = 1, modes
         call find_cantilever(n, beta, sigma)
         force(n) = -2*load*sigma/beta
      end do
      call judge('cantilever, weight', wall//'*GRAVITY, Y=-1e-3'//nl, 4.0_wp, clamped, step, force, 0.0_wp, .false.)
      force = force/load*1.0e-6_wp*199.859530_wp**2
      call judge('cantilever, shaken foot', foot, 1.0_wp, clamped, shaken, force, 199.859530_wp, .true.)
   end subroutine check_cantilever

   !> Damped beams under loads that come at once: what lies beyond critical damping errs for an instant, by its moments, and hardly
   !> moves otherwise than it should; under a load of their fifth frequency.
   subroutine check_damped()
      character(*), parameter :: couple = '*TORQUE, NAME=load, POINT=bar.end'//nl//' 1e-3*step(t - 0.5)'//nl
      character(*), parameter :: push = at_middle//'1e-3*step(t - 0.5)'//nl
      real(wp) :: force(modes), beta, sigma, tip(0:1)
      integer :: n
      force = [(load*sqrt(2.0_wp)*sin(0.5_wp*n*pi), n=1, modes)]
      call judge_damped('damped pins, little', pins//push, on_pins, late, force, 0.0_wp, 2.0e-3_wp)
      call judge_damped('damped pins', pins//push, on_pins, late, force, 0.0_wp, 5.0e-2_wp)
      do n = 1, modes
         call find_cantilever(n, beta, sigma)
         tip = cantilever_tip(beta, sigma)
         force(n) = load*tip(1)
      end do
      call judge_damped('damped couple', wall//couple, clamped, late, force, 0.0_wp, 5.0e-2_wp)
      call judge_damped('couple with much damping', wall//couple, clamped, late, force, 0.0_wp, 0.25_wp)
      do n = 1, modes
         call find_cantilever(n, beta, sigma)
         tip = cantilever_tip(beta, sigma)
         force(n) = load*tip(0)
      end do
      call judge_damped('damped, fifth frequency', wall//at_tip//'1e-3*sin(199.859530*t)'//nl, clamped, harmonic, force, &
         & 199.859530_wp, 5.0e-4_wp)
   end subroutine check_damped

   !> Runs a scene with damping and compares it with the sum of its modes: what is told is not less than the error, nor more than
   !> six times it.
   subroutine judge_damped(name, text, held, kind, force, omega, beta)
      character(*), intent(in) :: name, text
      integer, intent(in) :: held, kind
      real(wp), intent(in) :: force(:), omega
      !> By the rate of the curvature, in units of the curvature [time]
      real(wp), intent(in) :: beta
      integer, parameter :: samples = 200
      character(*), parameter :: what(2) = [character(18) :: 'its deflection', 'its bending moment']
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp) :: truth(2, 0:samples), found(2, 0:samples), off(2), told(2)
      character(12) :: number
      integer :: i
      write (number, '(es12.4)') beta
      call run(text//'*DAMPING, BODY=bar, RAYLEIGH BETA='//trim(adjustl(number))//nl//'*DYNAMICS, END=1, OUTPUTS=200'//nl// &
         & '*OUTPUT'//nl//merge(' y = y(bar.middle), moment = bending_moment(bar.middle)', &
         & ' y = y(bar.end), moment = bending_moment(bar.start)    ', held == on_pins)//nl, report)
      call reader%open(trim(results), error)
      call check_no_error(error, name)
      if (allocated(error)) return
      found(1, :) = channel(reader, 'y')
      found(2, :) = channel(reader, 'moment')
      call reader%close()
      do i = 0, samples
         truth(:, i) = sum_of_damped(held, kind, force, omega, beta, i/real(samples, wp))
      end do
      off = maxval(abs(found - truth), dim=2)/maxval(abs(truth), dim=2)
      told = [told_of(report, 'its largest deflection'), told_of(report, 'bending moments')]
      print '(2a,4f10.5)', name, ': deflection off, told; moment off, told', off(1), told(1), off(2), told(2)
      do i = 1, 2
         call check(off(i) <= 5.0e-3_wp*i .or. told(i) >= off(i), name//': '//trim(what(i))//' is right, or told: '//report)
         call check(told(i) <= 6*off(i), name//': no more than it is: '//trim(what(i))//': '//report)
      end do
   end subroutine judge_damped

   !> Deflection and bending moment, that of the damping in it, of a beam at rest before (2).
   function sum_of_damped(held, kind, force, omega, beta, t) result(total)
      integer, intent(in) :: held, kind
      real(wp), intent(in) :: force(:), omega, beta, t
      real(wp) :: total(2), shape(2), frequency
      integer :: n
      total = 0.0_wp
      do n = 1, modes
         call find_mode(held, n, frequency, shape)
         total = total + shape*force(n)*damped_answer(kind, frequency, omega, beta, t)
      end do
   end function sum_of_damped

   !> What a unit force on a vibration of unit mass makes: its place q, and q + beta q'.
   pure function damped_answer(kind, frequency, omega, beta, t) result(q)
      integer, intent(in) :: kind
      real(wp), intent(in) :: frequency, omega, beta, t
      real(wp) :: q(2), time, place(2), rate(2), part(2), rest
      complex(wp) :: root(2), factor(2)
      time = t
      if (kind == late) time = t - 0.5_wp
      q = 0.0_wp
      if (.not. time > 0.0_wp) return
      ! What goes on, at the start and now: place and rate
      if (kind == late) then
         place = 1/frequency**2
         rate = 0.0_wp
      else
         rest = frequency**2 - omega**2
         part = [rest, -beta*frequency**2*omega]/(rest**2 + (beta*frequency**2*omega)**2)
         place = [part(2), part(1)*sin(omega*time) + part(2)*cos(omega*time)]
         rate = omega*[part(1), part(1)*cos(omega*time) - part(2)*sin(omega*time)]
      end if
      root(1) = -0.5_wp*beta*frequency**2 - frequency*sqrt(cmplx((0.5_wp*beta*frequency)**2 - 1, 0.0_wp, wp))
      root(2) = frequency**2/root(1)
      factor(1) = (root(2)*place(1) - rate(1))/(root(1) - root(2))
      factor(2) = -place(1) - factor(1)
      q(1) = place(2) + real(sum(factor*exp(root*time)), wp)
      q(2) = q(1) + beta*(rate(2) + real(sum(factor*root*exp(root*time)), wp))
   end function damped_answer

   !> A cantilever on a hub that a couple turns for 0.05: the force of the axle is that of the weld, for the hub rests. It is 25 %
   !> off (against 20 functions). Nothing but this is asked for.
   subroutine check_hub()
      character(:), allocatable :: report
      call run(bar//'*RIGID BODY, NAME=hub, MASS=1, INERTIA=0.05'//nl//'*JOINT, NAME=axle, TYPE=REVOLUTE'//nl// &
         & ' hub.origin, ground.origin'//nl//'*JOINT, NAME=weld, TYPE=WELD, TURN=0'//nl//' bar.start, hub.origin'//nl// &
         & '*TORQUE, NAME=load, POINT=hub.origin'//nl//' 0.1*step(0.05 - t)'//nl//'*DYNAMICS, END=2, OUTPUTS=100'//nl// &
         & '*OUTPUT'//nl//' force_y(axle)'//nl, report)
      call check(told_of(report, 'shear forces and reactions') > 0.1_wp, 'force of an axle behind a hub is told: '//report)
      call check(index(report, 'of its largest deflection') == 0, 'its deflection is not asked for: '//report)
   end subroutine check_hub

   !> A ball on the tip of a cantilever, pushed for 0.01: its place is that of the tip, and told as such.
   subroutine check_bob()
      character(:), allocatable :: report
      call run(wall//'*POINT MASS, NAME=bob, MASS=0.001, X=1'//nl//'*JOINT, NAME=eye, TYPE=REVOLUTE'//nl//' bar.end, bob'//nl// &
         & at_tip//'1e-3*step(0.01 - t)'//nl//'*DYNAMICS, END=2, OUTPUTS=100'//nl//'*OUTPUT'//nl//' y(bob)'//nl, report)
      call check(told_of(report, 'its largest deflection') > 0.02_wp, 'place of a ball on a tip is told: '//report)
   end subroutine check_bob

   !> A column with a heavy head on a carriage that a spring pulls along slowly: what the head bends is no vibration, whatever the
   !> functions, and the shear force of few is that of many.
   subroutine check_head()
      character(*), parameter :: functions(3) = [character(14) :: ', FUNCTIONS=20', ', FUNCTIONS=15', '']
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp), allocatable :: truth(:), force(:)
      integer :: i
      do i = 1, size(functions)
         call run('*MATERIAL, NAME=steel, YOUNG=2.1e11, DENSITY=7850'//nl//'*SECTION, NAME=col, SHAPE=RECTANGLE, WIDTH=0.04, '// &
            & 'HEIGHT=0.02'//nl//'*RIGID BODY, NAME=carriage, MASS=20, INERTIA=1'//nl//'*BEAM, NAME=column, MATERIAL=steel, '// &
            & 'SECTION=col, LENGTH=0.8, ANGLE=90 deg'//trim(functions(i))//nl//'*POINT MASS, NAME=top, MASS=5, Y=0.8'//nl// &
            & '*JOINT, NAME=guide, TYPE=TRANSLATIONAL'//nl//' carriage.origin, ground.origin'//nl// &
            & '*JOINT, NAME=foot, TYPE=WELD'//nl//' column.start, carriage.origin'//nl// &
            & '*JOINT, NAME=head, TYPE=REVOLUTE'//nl//' top, column.end'//nl//'*GROUND'//nl//' far, 10, 0'//nl// &
            & '*SPRING, NAME=servo, STIFFNESS=8e5, LENGTH=10, DAMPING=200'//nl// &
            & ' carriage.origin, ground.far, 8e5*0.4*cycloidal(t/0.5)'//nl// &
            & '*DYNAMICS, END=1, OUTPUTS=200, TOLERANCE=1e-8, INTEGRATOR=RADAU'//nl//'*OUTPUT'//nl// &
            & ' v = shear_force(column.start)'//nl, report)
         call check(index(report, 'too few functions') == 0, 'a head that moves slowly: '//report)
         call reader%open(trim(results), error)
         call check_no_error(error, 'results')
         force = channel(reader, 'v')
         call reader%close()
         if (i == 1) truth = force
         call check(maxval(abs(force - truth)) < 2.0e-3_wp*maxval(abs(truth)), 'its shear force'//functions(i))
      end do
   end subroutine check_head

   !> A rod that is clamped and pulled at once: the force at the wall jumps to twice the load when the wave arrives, a square wave
   !> between 0 and 2, and in the middle between 0, 1 and 2 (d'Alembert). With one function it is a cosine: half of it off.
   subroutine check_rod()
      character(*), parameter :: rod = '*MATERIAL, NAME=stuff, YOUNG=1e6, DENSITY=100'//nl// &
         & '*SECTION, NAME=bar, SHAPE=GENERAL, AREA=0.01, INERTIA=1e-6'//nl// &
         & '*BEAM, NAME=bar, MATERIAL=stuff, SECTION=bar, LENGTH=1'//nl//'*JOINT, NAME=wall, TYPE=WELD, TURN=0'//nl// &
         & ' bar.start, ground.origin'//nl//'*FORCE, NAME=load, POINT=bar.end'//nl//' 0.1, 0'//nl
      integer, parameter :: samples = 100
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp), allocatable :: force(:)
      real(wp) :: truth(0:samples), off
      integer :: i
      ! The wave runs through 1 in 0.01; samples lie beside its arrivals
      call run(rod//'*DYNAMICS, END=0.199, OUTPUTS=100, INTEGRATOR=ADAMS'//nl//'*OUTPUT'//nl//' force = force_x(wall)'//nl, report)
      call reader%open(trim(results), error)
      call check_no_error(error, 'rod')
      if (allocated(error)) return
      allocate (force, source=channel(reader, 'force'))
      call reader%close()
      truth = [(merge(-0.2_wp, 0.0_wp, modulo(0.199_wp*i/samples - 0.01_wp, 0.04_wp) < 0.02_wp), i=0, samples)]
      off = maxval(abs(abs(force) - abs(truth)))/0.2_wp
      print '(a,2f10.5)', 'rod: force off, told', off, told_of(report, 'axial forces and reactions')
      call check(told_of(report, 'axial forces and reactions') > 0.5_wp*min(off, 1.0_wp), 'rod: wall force is told: '//report)
      call check(index(report, 'STRAIN FUNCTIONS=') > 0, 'rod: with the remedy')
   end subroutine check_rod

   !> A force that comes at once where a falling beam passes a place: as one that comes at once in time.
   subroutine check_place()
      character(:), allocatable :: report
      call run(pins//'*POINT MASS, NAME=clock, MASS=1, VX=1'//nl//at_middle//'1e-3*step(x(clock) - 0.5)'//nl// &
         & '*DYNAMICS, END=1.5, OUTPUTS=100'//nl//'*OUTPUT'//nl//' bending_moment(bar.middle)'//nl, report)
      call check(told_of(report, 'bending moments') > 0.015_wp, 'a force that comes at a place is told: '//report)
      call run(pins//at_middle//'1e-3*step(t - 0.5)'//nl//'*DYNAMICS, END=1.5, OUTPUTS=100'//nl//'*OUTPUT'//nl// &
         & ' bending_moment(bar.middle)'//nl, report)
      call check(told_of(report, 'bending moments') > 0.015_wp, 'the same at a time: '//report)
   end subroutine check_place

   !> A crank that turns at full speed from the start: what rings is its rod and rocker without deflections, for which the remedy is
   !> to begin with them; then nothing is told.
   subroutine check_running_start()
      character(*), parameter :: linkage = '*MATERIAL, NAME=alu, YOUNG=7e10, DENSITY=2700'//nl//'*SECTION, NAME=flat, '// &
         & 'SHAPE=RECTANGLE, WIDTH=0.02, HEIGHT=0.004'//nl//'*RIGID BODY, NAME=crank, MASS=0.1, INERTIA=1e-4, CENTRE X=0.05'//nl// &
         & ' pin, 0.1, 0'//nl//'*GROUND'//nl//' pivot, 0.3, 0'//nl//'*BEAM, NAME=rod, MATERIAL=alu, SECTION=flat, LENGTH=0.3, '// &
         & 'X=0.1, ANGLE=0.9'//nl//'*BEAM, NAME=rocker, MATERIAL=alu, SECTION=flat, LENGTH=0.25, X=0.3, ANGLE=1.7'//nl// &
         & '*JOINT, NAME=a, TYPE=REVOLUTE'//nl//' crank.origin, ground.origin'//nl//'*JOINT, NAME=b, TYPE=REVOLUTE'//nl// &
         & ' rod.start, crank.pin'//nl//'*JOINT, NAME=c, TYPE=REVOLUTE'//nl//' rod.end, rocker.end'//nl// &
         & '*JOINT, NAME=d, TYPE=REVOLUTE'//nl//' rocker.start, ground.pivot'//nl//'*DRIVER, NAME=motor, TYPE=ANGLE, BODY=crank'// &
         & nl//' 30*t'//nl
      character(*), parameter :: analysis = '*DYNAMICS, END=0.03, OUTPUTS=100'//nl//'*OUTPUT'//nl// &
         & ' torque(motor), stress_top(rod.middle)'//nl
      character(:), allocatable :: report
      call run(linkage//analysis, report)
      call check(index(report, '*ASSEMBLY, INITIAL DEFLECTIONS=STATIC, for it is the start') > 0, &
         & 'the remedy of a running start: '//report)
      call run(linkage//'*ASSEMBLY, INITIAL DEFLECTIONS=STATIC'//nl//analysis, report)
      call check(index(report, 'do not follow') == 0, 'a running start with deflections: '//report)
   end subroutine check_running_start

   !> A heavy trolley that a driver draws over a bridge: forces across err by 3 to 4 % (against 24 modes of the bridge and the
   !> trolley), those that draw it no more, for it slides; forces along it by nothing. The remedy is one that the deck allows.
   subroutine check_trolley()
      character(*), parameter :: functions(3) = [character(14) :: '', ', FUNCTIONS=23', ', FUNCTIONS=40']
      character(:), allocatable :: report
      type(error_type), allocatable :: error
      real(wp) :: told
      integer :: i
      do i = 1, size(functions)
         call run('*MATERIAL, NAME=steel, YOUNG=2.1e11, DENSITY=7850'//nl// &
            & '*SECTION, NAME=s, SHAPE=RECTANGLE, WIDTH=0.2, HEIGHT=0.1'//nl//'*GROUND'//nl//' far, 8, 0'//nl// &
            & '*BEAM, NAME=bridge, MATERIAL=steel, SECTION=s, LENGTH=8'//trim(functions(i))//nl// &
            & '*POINT MASS, NAME=trolley, MASS=600, VX=20'//nl//'*JOINT, NAME=l, TYPE=REVOLUTE'//nl// &
            & ' bridge.start, ground.origin'//nl//'*JOINT, NAME=r, TYPE=POINT ON LINE'//nl//' bridge.end, ground.far'//nl// &
            & '*JOINT, NAME=contact, TYPE=SLIDING'//nl//' trolley, bridge'//nl//'*DRIVER, NAME=pull, TYPE=X, POINT=trolley'//nl// &
            & ' 20*t'//nl//'*FORCE, NAME=weight, POINT=trolley'//nl//' 0, -9.81*600'//nl//'*DYNAMICS, END='// &
            & merge('0.05', '0.4 ', i == 2)//nl// &
            & '*OUTPUT'//nl//' force_y(l), force_y(r), force_y(contact), force(pull)'//nl, report, error)
         call check(allocated(error) .eqv. i == 3, 'trolley'//functions(i))
         if (allocated(error) .and. i == 3) call check(index(error%message, 'at most 24') > 0, error%message)
         if (allocated(error)) return
         told = told_of(report, 'shear forces and reactions')
         if (i == 1) call check(told > 0.02_wp .and. told < 0.12_wp, 'errors across the bridge: '//report)
         call check(index(report, 'axial') == 0, 'nothing along the bridge: '//report)
         if (i == 1) call check(index(report, 'use FUNCTIONS=2') > 0, 'a remedy that the deck allows: '//report)
         if (i == 2) call check(index(report, 'use FUNCTIONS') == 0, 'no more functions than the deck allows: '//report)
      end do
   end subroutine check_trolley

   !> Runs a scene.
   subroutine run(text, report, refusal)
      character(*), intent(in) :: text
      character(:), allocatable, intent(out) :: report
      !> Where the deck may be refused
      type(error_type), allocatable, intent(out), optional :: refusal
      type(error_type), allocatable :: error
      integer :: unit
      open (newunit=unit, file=trim(results)//'.inp', access='stream', action='write', status='replace')
      write (unit) text
      close (unit)
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
      if (.not. present(refusal)) call check_no_error(error, text)
      if (present(refusal)) call move_alloc(error, refusal)
   end subroutine run

   !> Root and shape of a mode of a cantilever: cosh(b x) - cos(b x) - s (sinh(b x) - sin(b x)).
   subroutine find_cantilever(n, beta, sigma)
      integer, intent(in) :: n
      real(wp), intent(out) :: beta, sigma
      integer :: i
      beta = (n - 0.5_wp)*pi
      do i = 1, 30
         ! cos(b) = -1/cosh(b)
         if (beta < 30.0_wp) beta = beta - (cos(beta) + 1/cosh(beta))/(-sin(beta) - tanh(beta)/cosh(beta))
      end do
      sigma = 1.0_wp
      if (beta < 30.0_wp) sigma = (cosh(beta) + cos(beta))/(sinh(beta) + sin(beta))
   end subroutine find_cantilever

   !> The shape and its slope at the tip: 2 and -2 by turns for the first.
   function cantilever_tip(beta, sigma) result(tip)
      real(wp), intent(in) :: beta, sigma
      real(wp) :: tip(0:1), growing
      ! (1 - sigma) exp(beta), without the difference of large numbers
      growing = sin(beta) - cos(beta)
      if (beta < 30.0_wp) growing = (sin(beta) - cos(beta) - exp(-beta))/(sinh(beta) + sin(beta))*exp(beta)
      if (beta >= 30.0_wp) growing = 2*growing
      tip(0) = 0.5_wp*(growing + (1 + sigma)*exp(-beta)) - cos(beta) + sigma*sin(beta)
      tip(1) = beta*(0.5_wp*(growing - (1 + sigma)*exp(-beta)) + sin(beta) + sigma*cos(beta))
   end function cantilever_tip

   !> Runs a scene and compares it with the sum of its modes.
   subroutine judge(name, text, end, held, kind, force, omega, sudden, with_moment)
      character(*), intent(in) :: name, text
      real(wp), intent(in) :: end, force(:), omega
      integer, intent(in) :: held, kind
      !> Whether it must be warned of; whether the sum for the moment converges
      logical, intent(in) :: sudden
      logical, intent(in), optional :: with_moment
      integer, parameter :: samples = 200
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp), allocatable :: y(:), moment(:)
      real(wp) :: truth(2, 0:samples), off(2), told(2), t
      character(12) :: number
      integer :: unit, i
      open (newunit=unit, file=trim(results)//'.inp', access='stream', action='write', status='replace')
      write (number, '(f12.4)') end
      write (unit) text//'*DYNAMICS, END='//trim(adjustl(number))//', OUTPUTS=200'//nl//'*OUTPUT'//nl
      if (held == on_pins) write (unit) ' y = y(bar.middle), moment = bending_moment(bar.middle)'//nl
      if (held == clamped) write (unit) ' y = y(bar.end), moment = bending_moment(bar.start)'//nl
      close (unit)
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
      call check_no_error(error, name)
      if (allocated(error)) return
      call reader%open(trim(results), error)
      call check_no_error(error, name)
      allocate (y, source=channel(reader, 'y'))
      allocate (moment, source=channel(reader, 'moment'))
      call reader%close()
      do i = 0, samples
         t = end*i/samples
         truth(:, i) = sum_of_modes(held, kind, force, omega, t)
         if (kind == shaken) truth(1, i) = truth(1, i) + 1.0e-6_wp*(1 - cos(omega*t))
      end do
      off(1) = maxval(abs(y - truth(1, :)))/maxval(abs(truth(1, :)))
      off(2) = maxval(abs(moment - truth(2, :)))/maxval(abs(truth(2, :)))
      told = [told_of(report, 'its largest deflection'), told_of(report, 'bending moments')]
      print '(2a,4f10.5)', name, ': deflection off, told; moment off, told', off(1), told(1), off(2), told(2)
      call check(off(1) <= 1.0e-2_wp .or. told(1) > off(1)/3, name//': deflection is right, or its error is told: '//report)
      if (present(with_moment)) then
         call check(told(2) > 0.3_wp, name//': moments without a limit are told: '//report)
      else
         call check(off(2) <= 1.0e-2_wp .or. told(2) > off(2)/3, name//': moment is right, or its error is told: '//report)
      end if
      if (.not. sudden) call check(index(report, 'under sudden') == 0, name//': no alarm: '//report)
      if (.not. sudden) call check(all(off <= 1.0e-2_wp), name//': right')
   end subroutine judge

   !> What a report tells to be off: the number before a text.
   real(wp) function told_of(report, what) result(told)
      character(*), intent(in) :: report, what
      integer :: at, from
      told = 0.0_wp
      at = index(report, ' % of '//what)
      if (at == 0) at = index(report, ' % or more of '//what)
      if (at == 0) return
      from = index(report(:at - 1), ' ', back=.true.) + 1
      read (report(from:at - 1), *) told
      told = told/100
   end function told_of

   !> Frequency of a mode, its deflection and bending moment where they are asked for (2).
   subroutine find_mode(held, n, frequency, shape)
      integer, intent(in) :: held, n
      real(wp), intent(out) :: frequency, shape(2)
      real(wp) :: root, sigma, tip(0:1)
      if (held == on_pins) then
         frequency = (n*pi)**2
         shape = sqrt(2.0_wp)*sin(0.5_wp*n*pi)*[1.0_wp, -frequency]
      else
         call find_cantilever(n, root, sigma)
         frequency = root**2
         tip = cantilever_tip(root, sigma)
         shape = [tip(0), 2*frequency]
      end if
   end subroutine find_mode

   !> Deflection and bending moment of a beam at rest before, where they are asked for (2).
   function sum_of_modes(held, kind, force, omega, t) result(total)
      integer, intent(in) :: held, kind
      !> On the modes (modes); frequency of the force; time
      real(wp), intent(in) :: force(:), omega, t
      real(wp) :: total(2), shape(2), frequency
      integer :: n
      total = 0.0_wp
      do n = 1, modes
         call find_mode(held, n, frequency, shape)
         total = total + shape*force(n)*answer(kind, frequency, omega, t)
      end do
   end function sum_of_modes

   !> What a unit force on a vibration of unit mass makes.
   pure real(wp) function answer(kind, frequency, omega, t) result(q)
      integer, intent(in) :: kind
      real(wp), intent(in) :: frequency, omega, t
      q = 0.0_wp
      select case (kind)
      case (step)
         q = (1 - cos(frequency*t))/frequency**2
      case (late)
         if (t > 0.5_wp) q = (1 - cos(frequency*(t - 0.5_wp)))/frequency**2
      case (pulse)
         q = (1 - cos(frequency*t))/frequency**2
         if (t > 0.01_wp) q = q - (1 - cos(frequency*(t - 0.01_wp)))/frequency**2
      case (harmonic)
         if (abs(omega - frequency) < 1.0e-4_wp*omega) then
            q = (sin(omega*t) - omega*t*cos(omega*t))/(2*omega**2)
         else
            q = (sin(omega*t) - omega/frequency*sin(frequency*t))/(frequency**2 - omega**2)
         end if
      case (shaken)
         if (abs(omega - frequency) < 1.0e-4_wp*omega) then
            q = t*sin(omega*t)/(2*omega)
         else
            q = (cos(omega*t) - cos(frequency*t))/(frequency**2 - omega**2)
         end if
      end select
   end function answer

end program test_sudden_loads
