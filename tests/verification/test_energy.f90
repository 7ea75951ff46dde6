!> Whole runs by the conserving integrator: the energy less the work put in stays to round-off at every sample, whatever the
!> tolerance. Usage, in tests/: test_energy RESULT_FILE
program test_energy
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_changed, run_text, check_warning, channel
   use testing, only: check, check_close, finish
   implicit none
   character(256) :: results

   call get_command_argument(1, results)
   call check_squeezer('1e-3', 1.0e-2_wp)
   call check_squeezer('1e-6', 2.0e-3_wp)
   call check_slider_crank()
   call check_far('10')
   call check_far('300')
   call check_pole('1/x')
   call check_pole('0.5/x**1.2')
   call check_pole('2/x**2')
   call check_pole('x')
   call check_law_energy('KINEMATICS, END=1, OUTPUTS=100')
   call check_law_energy('STATICS, PERIOD=1, INCREMENTS=100')
   call check_unknown_energy()
   call check_fixed_step()
   call finish()

contains

   !> The energies of two springs along a driven slide, one with a narrow pulse, the other with a law that goes to and fro, against
   !> their integrals.
   subroutine check_law_energy(analysis)
      character(*), intent(in) :: analysis
      character(1), parameter :: nl = new_line('a')
      real(wp), parameter :: w = 0.01_wp, pi = acos(-1.0_wp)
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp), allocatable :: x(:), energy(:), work(:), pulse(:), wave(:)
      character(32) :: law(2)
      integer :: k
      law = [character(32) :: '-10/0.01*exp(-((x-5.3)/0.01)**2)', '10*sin(100*x)']
      do k = 1, 2
         call run_text('*POINT MASS, NAME=m, MASS=1, X=2'//nl//'*JOINT, NAME=j, TYPE=POINT ON LINE'//nl// &
            & ' m, ground.origin'//nl//'*DRIVER, NAME=dx, TYPE=X, POINT=m'//nl//' 2 + 10*t'//nl// &
            & '*SPRING, NAME=s, LENGTH=1'//nl//' m, ground.origin, '//trim(law(k))//nl//'*'//analysis//nl//'*OUTPUT'//nl// &
            & ' x(m), potential_energy(system), work(system)'//nl, trim(results), report, error)
         call check(.not. allocated(error), 'energy of a law: '//analysis)
         if (allocated(error)) return
         call reader%open(trim(results), error)
         x = channel(reader, 'x_m') - 1
         energy = channel(reader, 'potential_energy_system')
         work = channel(reader, 'work_system')
         call check_warning(reader, '', 'energy of a law: '//analysis)
         call reader%close()
         pulse = -5*sqrt(pi)*(erf((x - 5.3_wp)/w) - erf(-5.3_wp/w))
         wave = 0.1_wp*(1 - cos(100*x))
         if (k == 1) call check_close(maxval(abs(energy - pulse)), 0.0_wp, 1.0e-9_wp, 'energy of a pulse: '//analysis)
         if (k == 2) call check_close(maxval(abs(energy - wave)), 0.0_wp, 1.0e-9_wp, 'energy of a wave: '//analysis)
         if (index(analysis, 'KINEMATICS') > 0) call check_close(maxval(abs(work - (energy - energy(1)))), &
            & 0.0_wp, 1.0e-12_wp, 'work on a law: '//analysis)
      end do
   end subroutine check_law_energy

   !> A law that goes to and fro too often for its integral: that is told.
   subroutine check_unknown_energy()
      character(1), parameter :: nl = new_line('a')
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call run_text('*POINT MASS, NAME=m, MASS=1, X=2'//nl//'*JOINT, NAME=j, TYPE=POINT ON LINE'//nl// &
         & ' m, ground.origin'//nl//'*DRIVER, NAME=dx, TYPE=X, POINT=m'//nl//' 2 + 10*t'//nl// &
         & '*SPRING, NAME=s, LENGTH=1'//nl//' m, ground.origin, 10*sin(1e4*x)'//nl//'*KINEMATICS, END=1, OUTPUTS=10'//nl// &
         & '*OUTPUT'//nl//' potential_energy(system)'//nl, trim(results), report, error)
      call check(.not. allocated(error), 'an energy that is not known runs')
      if (allocated(error)) return
      call reader%open(trim(results), error)
      call check_warning(reader, "the law of 's' on body 'm' comes and goes too often for its integral", &
         & 'an energy that is not known')
      call reader%close()
   end subroutine check_unknown_energy

   !> Where the deck gives the step, a warning does not ask for another tolerance.
   subroutine check_fixed_step()
      character(1), parameter :: nl = new_line('a')
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call run_text('*POINT MASS, NAME=m, MASS=1, X=1'//nl//'*SPRING, NAME=s, STIFFNESS=10, LENGTH=0.5'//nl// &
         & ' m, ground.origin'//nl//'*DYNAMICS, END=1, FIXED STEP=0.3, OUTPUTS=4'//nl//'*OUTPUT'//nl//' x(m)'//nl, &
         & trim(results), report, error)
      call check(.not. allocated(error), 'steps that are too long run')
      if (allocated(error)) return
      call reader%open(trim(results), error)
      call check_warning(reader, 'compare with a run at a smaller FIXED STEP, or without it', 'a step that is too long')
      call reader%close()
   end subroutine check_fixed_step

   !> Spring and torque; the last angle against the published one.
   subroutine check_squeezer(tolerance, allowed)
      character(*), intent(in) :: tolerance
      real(wp), intent(in) :: allowed
      type(history_reader_type) :: reader
      real(wp), allocatable :: beta(:), energy(:)
      call run_changed('../input/andrews_squeezer.inp', trim(results), [character(32) :: 'INTEGRATOR=ADAMS', 'TOLERANCE=1e-8'], &
         & [character(32) :: 'INTEGRATOR=CONSERVING', 'TOLERANCE='//tolerance], reader)
      allocate (beta, source=channel(reader, 'beta'))
      allocate (energy, source=channel(reader, 'energy'))
      print '(3a,2es10.2)', 'squeezer at ', tolerance, ': error of angle, change of energy', &
         & abs(beta(size(beta))/15.810771195153707_wp - 1), maxval(abs(energy - energy(1)))
      call check_close(beta(size(beta))/15.810771195153707_wp, 1.0_wp, allowed, 'squeezer: angle at the end')
      call check_close(maxval(abs(energy - energy(1))), 0.0_wp, 1.0e-12_wp, 'squeezer: energy less work')
      call reader%close()
      deallocate (beta, energy)
   end subroutine check_squeezer

   !> A driver and a rod of the model FULL, with axial vibrations that are not resolved.
   subroutine check_slider_crank()
      type(history_reader_type) :: reader
      real(wp), allocatable :: energy(:), kinetic(:), deflection(:)
      call run_changed('../input/slider_crank_exact.inp', trim(results), [character(128) :: 'TOLERANCE=1e-8', &
         & 'slider_x = x(slider)'], [character(128) :: 'TOLERANCE=1e-4, INTEGRATOR=CONSERVING', &
         & 'kinetic = kinetic_energy(system), energy = kinetic_energy(system) + potential_energy(system) - work(system)'], reader)
      allocate (energy, source=channel(reader, 'energy'))
      allocate (kinetic, source=channel(reader, 'kinetic'))
      allocate (deflection, source=channel(reader, 'deflection_over_length'))
      print '(a,3es10.2)', 'slider-crank: change of energy, largest kinetic energy, deflection', &
         & maxval(abs(energy - energy(1))), maxval(kinetic), maxval(abs(deflection))
      call check_close(maxval(abs(energy - energy(1)))/maxval(kinetic), 0.0_wp, 1.0e-11_wp, 'slider-crank: energy less work')
      call check(maxval(kinetic) > 2*kinetic(1), 'slider-crank: there is work')
      call check(maxval(abs(deflection)) > 0.01_wp .and. maxval(abs(deflection)) < 0.3_wp, 'slider-crank: deflection '// &
         & as_text(maxval(abs(deflection)), 3))
      call reader%close()
      deallocate (energy, kinetic, deflection)
   end subroutine check_slider_crank

   !> A stiff beam on a slide far from the origin, whose stiffness multiplies the round-off of places: it moves as at the origin.
   subroutine check_far(far)
      !> Distance
      character(*), intent(in) :: far
      type(history_reader_type) :: reader
      real(wp), allocatable :: here(:), there(:), energy(:)
      call run_changed('verification/sliding_beam.inp', trim(results), ['far = 0'], ['far = 0'], reader)
      allocate (here, source=channel(reader, 'x'))
      call reader%close()
      call run_changed('verification/sliding_beam.inp', trim(results), ['far = 0'], ['far = '//far], reader)
      allocate (there, source=channel(reader, 'x'))
      allocate (energy, source=channel(reader, 'energy'))
      call reader%close()
      call check_close(maxval(abs(there - here)), 0.0_wp, 1.0e-9_wp, 'beam on a slide at '//far//': place')
      call check(maxval(here) > here(1) + 1.0e-4_wp, 'beam on a slide moves')
      call check_close(maxval(abs(energy - energy(1))), 0.0_wp, 1.0e-8_wp, 'beam on a slide at '//far//': energy')
   end subroutine check_far

   !> Laws of the elongation with a pole at zero: the energy counts from the first elongation; others count from zero.
   subroutine check_pole(law)
      character(*), intent(in) :: law
      type(history_reader_type) :: reader
      real(wp), allocatable :: x(:), kinetic(:), potential(:)
      real(wp), parameter :: first = 0.7_wp
      character(12) :: changed(1)
      ! A constructor of a dummy of assumed length copies beyond it (gfortran 12)
      changed(1) = law
      call run_changed('verification/pole_spring.inp', trim(results), ['1/x'], changed, reader)
      x = channel(reader, 'x_a') - 0.5_wp
      kinetic = channel(reader, 'kinetic_energy_system')
      potential = channel(reader, 'potential_energy_system')
      select case (law)
      case ('1/x')
         x = log(x/first)
      case ('0.5/x**1.2')
         x = 2.5_wp*(first**(-0.2_wp) - x**(-0.2_wp))
      case ('2/x**2')
         x = 2*(1/first - 1/x)
      case default
         x = 0.5_wp*x**2
      end select
      call check_close(maxval(abs(potential - x)), 0.0_wp, 1.0e-12_wp, 'potential energy of the law '//law)
      call check_close(maxval(abs(kinetic + potential - potential(1))), 0.0_wp, 1.0e-5_wp, 'energy with the law '//law)
      call reader%close()
   end subroutine check_pole

end program test_energy
