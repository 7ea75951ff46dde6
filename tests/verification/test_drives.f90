!> Velocities of driven scenes, and what follows from them, by every integrator against closed forms: those of the laws of the
!> drivers; and a warning where an integrator does not keep them. Usage: test_drives RESULT_FILE
program test_drives
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_base_text, only: newline
   use limber_commands_run, only: run_deck
   use limber_output_history_reader, only: history_reader_type
   use runs, only: channel
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   character(*), parameter :: nl = newline
   character(10), parameter :: integrators(4) = [character(10) :: 'CONSERVING', 'ADAMS', 'RADAU', 'ALPHA']
   character(4), parameter :: tolerances(2) = ['1e-4', '1e-8']
   character(*), parameter :: wheels = '*RIGID BODY, NAME=w, MASS=1, INERTIA=1'//nl// &
      & '*RIGID BODY, NAME=g, MASS=1, INERTIA=1, X=0.3'//nl//'*GROUND'//nl//' p, 0.3, 0'//nl// &
      & '*JOINT, NAME=j, TYPE=REVOLUTE'//nl//' w.origin, ground.origin'//nl// &
      & '*JOINT, NAME=j2, TYPE=REVOLUTE'//nl//' g.origin, ground.p'//nl// &
      & '*JOINT, NAME=mesh, TYPE=GEAR, FIRST RADIUS=0.2, SECOND RADIUS=0.1'//nl//' w.origin, g.origin'//nl
   character(256) :: results
   character(:), allocatable :: report, name
   type(history_reader_type) :: reader
   integer :: i, k

   call get_command_argument(1, results)
   do i = 1, size(integrators)
      do k = 1, size(tolerances)
         name = trim(integrators(i))//' at '//tolerances(k)
         call check_slider_crank()
         call check_wheels()
         call check_crank()
      end do
   end do
   call check_target()
   call check_warning()
   call finish()

contains

   !> Runs a deck.
   subroutine run(deck)
      character(*), intent(in) :: deck
      type(error_type), allocatable :: error
      integer :: unit
      open (newunit=unit, file=trim(results)//'.inp', action='write', status='replace')
      write (unit, '(a)') '*HEADING'//nl//' drives'//nl//deck
      close (unit)
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
      call check_no_error(error, 'run')
      if (allocated(error)) error stop 1
      call reader%open(trim(results), error)
      call check_no_error(error, 'results')
   end subroutine run

   !> The block of an analysis of 1 s with 20 samples.
   function dynamics() result(text)
      character(:), allocatable :: text
      text = '*DYNAMICS, END=1, OUTPUTS=20, INTEGRATOR='//trim(integrators(i))//', TOLERANCE='//tolerances(k)//nl//'*OUTPUT'//nl
   end function dynamics

   !> A channel against a closed form at the samples.
   subroutine compare(what, truth, scale, allowed)
      character(*), intent(in) :: what
      !> Values at the samples, what the difference is relative to, and the largest
      real(wp), intent(in) :: truth(0:), scale, allowed
      call check_close(maxval(abs(channel(reader, what) - truth))/scale, 0.0_wp, allowed, name//': '//what)
   end subroutine compare

   !> Crank, rod and slider at 50 rad/s, without gravity: no degree of freedom is left, so that nothing but the law gives the
   !> velocities. With sin b = sin(a)/4 of the rod: x = 0.1 cos a + 0.4 cos b.
   subroutine check_slider_crank()
      real(wp), parameter :: omega = 50.0_wp, r = 0.1_wp, l = 0.4_wp
      real(wp), dimension(0:20) :: a, b, db, ddb, v, acceleration, energy
      integer :: n
      call run('*RIGID BODY, NAME=c, MASS=1, INERTIA=1'//nl//' e, 0.1, 0'//nl// &
         & '*RIGID BODY, NAME=r, MASS=1, INERTIA=0.1, X=0.1, CENTRE X=0.2'//nl//' e, 0.4, 0'//nl// &
         & '*POINT MASS, NAME=s, MASS=1, X=0.5'//nl//'*JOINT, NAME=j, TYPE=REVOLUTE'//nl//' c.origin, ground.origin'//nl// &
         & '*JOINT, NAME=j2, TYPE=REVOLUTE'//nl//' r.origin, c.e'//nl//'*JOINT, NAME=j3, TYPE=REVOLUTE'//nl//' r.e, s'//nl// &
         & '*JOINT, NAME=sl, TYPE=POINT ON LINE'//nl//' s, ground.origin'//nl//'*DRIVER, NAME=d, TYPE=ANGLE, BODY=c'//nl// &
         & ' 50*t'//nl//dynamics()//' vx = vx(s), ax = ax(s), work = work(system), energy = kinetic_energy(system)')
      a = [(omega*n/20, n=0, 20)]
      b = asin(r*sin(a)/l)
      db = r*omega*cos(a)/(l*cos(b))
      ddb = (-r*omega**2*sin(a)/l + sin(b)*db**2)/cos(b)
      v = -r*omega*sin(a) - l*sin(b)*db
      acceleration = -r*omega**2*cos(a) - l*(cos(b)*db**2 + sin(b)*ddb)
      ! Crank about its pin; rod with its centre in the middle between crank pin and slider; slider
      energy = 0.5_wp*omega**2 + 0.5_wp*0.1_wp*db**2 + 0.5_wp*v**2 &
         & + 0.5_wp*((-r*omega*sin(a) - 0.5_wp*l*sin(b)*db)**2 + (0.5_wp*r*omega*cos(a))**2)
      call compare('vx', v, 5.0_wp, 1.0e-9_wp)
      call compare('ax', acceleration, 300.0_wp, 1.0e-9_wp)
      call compare('energy', energy, 1262.0_wp, 1.0e-9_wp)
      if (integrators(i) == 'CONSERVING') call compare('work', energy - energy(0), 1262.0_wp, 1.0e-9_wp)
      call check(index(report, 'warning') == 0, name//': a slider-crank without a warning')
      call reader%close()
   end subroutine check_slider_crank

   !> Two wheels with a gear at 50 rad/s: the second at -100; no work.
   subroutine check_wheels()
      real(wp), parameter :: one(0:20) = 1.0_wp
      call run(wheels//'*DRIVER, NAME=d, TYPE=ANGLE, BODY=w'//nl//' 50*t'//nl//dynamics()// &
         & ' spin = spin(g), energy = kinetic_energy(system), work = work(system), force = force_y(mesh)')
      call compare('spin', -100*one, 100.0_wp, 1.0e-9_wp)
      call compare('energy', 6250*one, 6250.0_wp, 1.0e-9_wp)
      call compare('work', 0*one, 6250.0_wp, 1.0e-9_wp)
      call compare('force', 0*one, 1.0e4_wp, 1.0e-9_wp)
      call reader%close()
   end subroutine check_wheels

   !> An eccentric crank under gravity whose speed swings.
   subroutine check_crank()
      real(wp), parameter :: g = 9.81_wp, e = 0.1_wp, m = 2.0_wp, about_pin = 0.03_wp
      real(wp), dimension(0:20) :: t, spin, energy, torque, potential
      integer :: n
      call run('*RIGID BODY, NAME=c, MASS=2, INERTIA=0.01, CENTRE X=0.1'//nl//'*JOINT, NAME=pin, TYPE=REVOLUTE'//nl// &
         & ' c.origin, ground.origin'//nl//'*GRAVITY'//nl//'*DRIVER, NAME=d, TYPE=ANGLE, BODY=c'//nl//' 31.4*t + 0.5*sin(20*t)'// &
         & nl//dynamics()//' spin = spin(c), energy = kinetic_energy(system), work = work(system), torque = torque(d)')
      t = [(0.05_wp*n, n=0, 20)]
      spin = 31.4_wp + 10*cos(20*t)
      energy = 0.5_wp*about_pin*spin**2
      potential = m*g*e*sin(31.4_wp*t + 0.5_wp*sin(20*t))
      torque = -200*about_pin*sin(20*t) + m*g*e*cos(31.4_wp*t + 0.5_wp*sin(20*t))
      call compare('spin', spin, 40.0_wp, 1.0e-9_wp)
      call compare('energy', energy, 25.0_wp, 1.0e-9_wp)
      call compare('torque', torque, 6.0_wp, 1.0e-8_wp)
      if (integrators(i) == 'CONSERVING') call compare('work', energy - energy(0) + potential, 25.0_wp, 1.0e-9_wp)
      call reader%close()
   end subroutine check_crank

   !> The same shaft with a TARGET: what is said to be kept is.
   subroutine check_target()
      real(wp) :: truth(0:50)
      integer :: n
      name = 'TARGET'
      call run('*RIGID BODY, NAME=c, MASS=20, INERTIA=0.5'//nl//'*JOINT, NAME=pin, TYPE=REVOLUTE'//nl// &
         & ' c.origin, ground.origin'//nl//'*DRIVER, NAME=d, TYPE=ANGLE, BODY=c'//nl//' 31.4*t + 0.5*sin(20*t)'//nl// &
         & '*DYNAMICS, END=2, OUTPUTS=50, INTEGRATOR=CONSERVING'//nl//'*OUTPUT'//nl//' spin = spin(c), work = work(system)'//nl// &
         & '*ACCURACY, TARGET=1e-3')
      truth = [(31.4_wp + 10*cos(0.8_wp*n), n=0, 50)]
      call compare('spin', truth, 41.4_wp, 1.0e-3_wp)
      call compare('work', 0.25_wp*(truth**2 - truth(0)**2), 430.0_wp, 1.0e-3_wp)
      call reader%close()
   end subroutine check_target

   !> Free wheels, where CONSERVING keeps the energy and not the velocities of the gear: long steps of fixed length are told of,
   !> with the joint and a remedy; short ones have nothing to tell.
   subroutine check_warning()
      character(*), parameter :: free = '*TORQUE, NAME=brake, BODY=w'//nl//' -40*sin(5*t)'//nl
      character(5), parameter :: steps(2) = ['0.2  ', '0.001']
      logical :: told
      integer :: n
      call check_small_wheels()
      do n = 1, 2
         call run(wheels//free//'*DYNAMICS, END=4, OUTPUTS=20, INTEGRATOR=CONSERVING, FIXED STEP='//trim(steps(n))//nl// &
            & '*OUTPUT'//nl//' spin = spin(g), first = spin(w)')
         told = index(report, "CONSERVING does not keep the velocities that joint 'mesh'") > 0
         print '(2a,es10.2,l2)', 'free wheels at ', steps(n), maxval(abs(channel(reader, 'spin') + 2*channel(reader, 'first')))/ &
            & maxval(abs(channel(reader, 'spin'))), told
         call check(told .eqv. n == 1, 'free wheels at '//steps(n)//': a warning where velocities are off')
         call reader%close()
      end do
   end subroutine check_warning

   !> Wheels of a hundredth of that size beside a body that is fast: what is off by a third of their speed is not little.
   subroutine check_small_wheels()
      real(wp), allocatable :: off(:)
      call run('*RIGID BODY, NAME=w, MASS=2, INERTIA=1e-4'//nl//'*RIGID BODY, NAME=g, MASS=1, INERTIA=1e-5, X=0.015'//nl// &
         & '*GROUND'//nl//' p, 0.015, 0'//nl//'*JOINT, NAME=j, TYPE=REVOLUTE'//nl//' w.origin, ground.origin'//nl// &
         & '*JOINT, NAME=j2, TYPE=REVOLUTE'//nl//' g.origin, ground.p'//nl// &
         & '*JOINT, NAME=mesh, TYPE=GEAR, FIRST RADIUS=0.01, SECOND RADIUS=0.005'//nl//' w.origin, g.origin'//nl// &
         & '*POINT MASS, NAME=far, MASS=1, X=20, VY=50'//nl//'*TORQUE, NAME=brake, BODY=w'//nl//' -0.002*sin(5*t)'//nl// &
         & '*DYNAMICS, END=4, OUTPUTS=20, INTEGRATOR=CONSERVING, FIXED STEP=0.2'//nl//'*OUTPUT'//nl// &
         & ' spin = spin(g), first = spin(w)')
      off = abs(channel(reader, 'spin') + 2*channel(reader, 'first'))
      print '(a,es10.2)', 'small wheels', maxval(off)/maxval(abs(channel(reader, 'spin')))
      call check(maxval(off) > 0.1_wp*maxval(abs(channel(reader, 'spin'))), 'small wheels are off')
      call check(index(report, "CONSERVING does not keep the velocities that joint 'mesh'") > 0, 'small wheels are told of')
      call reader%close()
   end subroutine check_small_wheels

end program test_drives
