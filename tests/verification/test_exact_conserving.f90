!> The conserving step of exact beams: energy and momenta stay to round-off whatever the step, with joints, drivers, couplers, a
!> point that slides along the beam, springs, dead loads, shear and concentrated masses; it is of second order.
!> Usage, in tests/: test_exact_conserving RESULT_FILE
program test_exact_conserving
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use limber_commands_run, only: run_deck
   use limber_output_history_reader, only: history_reader_type
   use runs, only: change_deck, channel
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   character(*), parameter :: nl = new_line('a')
   character(*), parameter :: pin = '*JOINT, NAME=pin, TYPE=REVOLUTE'//nl//' bar.start, ground.origin'//nl
   character(*), parameter :: wall = '*JOINT, NAME=wall, TYPE=WELD, TURN=0'//nl//' bar.start, ground.origin'//nl
   character(*), parameter :: balance = '*OUTPUT'//nl// &
      & ' energy = kinetic_energy(system) + potential_energy(system) - work(system), kinetic = kinetic_energy(system)'//nl
   character(256) :: results

   call get_command_argument(1, results)
   call check_free()
   call check_pendulum()
   call check_order()
   call check_crank()
   call check_sliding()
   call check_start()
   call check_springs()
   call finish()

contains

   !> Runs the bar in a scene.
   subroutine run_bar(functions, scene, reader)
      character(*), intent(in) :: functions, scene
      type(history_reader_type), intent(out) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      character(4000) :: new(3)
      new(1) = functions
      new(2) = scene//balance
      new(3) = 'INERTIA=1e-6, SHEAR FACTOR=0.8'
      call change_deck('verification/exact_bar.inp', trim(results)//'.inp', [character(38) :: &
         & 'FUNCTIONS=8, STRAIN FUNCTIONS=0', '** scene', 'INERTIA=1e-6'], new)
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
      call check_no_error(error, scene)
      if (allocated(error)) error stop 1
      call reader%open(trim(results), error)
      call check_no_error(error, scene//': results')
   end subroutine run_bar

   !> The largest change of a channel from one of its samples on, and its largest value.
   subroutine look(reader, name, from, change, largest)
      type(history_reader_type), intent(inout) :: reader
      character(*), intent(in) :: name
      integer, intent(in) :: from
      real(wp), intent(out) :: change, largest
      real(wp), allocatable :: values(:)
      allocate (values, source=channel(reader, name))
      change = maxval(abs(values(from:) - values(from)))
      largest = maxval(abs(values))
   end subroutine look

   !> Energy less work, in parts of the largest kinetic energy.
   subroutine check_energy(reader, allowed, name)
      type(history_reader_type), intent(inout) :: reader
      real(wp), intent(in) :: allowed
      character(*), intent(in) :: name
      real(wp) :: change, most, none
      call look(reader, 'energy', 1, change, none)
      call look(reader, 'kinetic', 1, none, most)
      print '(2a,2es10.2)', name, ': change of energy less work, largest kinetic energy', change, most
      call check(most > 1.0e-3_wp, name//': it moves')
      call check_close(change/most, 0.0_wp, allowed, name//': energy less work')
   end subroutine check_energy

   !> A free arc with shear and a mass at its end, struck by a force and a couple that end at a sample: then all momenta stay.
   subroutine check_free()
      type(history_reader_type) :: reader
      character(16), parameter :: momenta(3) = [character(16) :: 'momentum_x', 'momentum_y', 'angular_momentum']
      real(wp) :: change, largest
      integer :: i
      call run_bar('FUNCTIONS=3, STRAIN FUNCTIONS=1, SHEAR=YES, ORIGIN=0.3, CURVATURE=1', '*MASS'//nl//' end, 0.3, 0.01'//nl// &
         & '*FORCE, NAME=hit, POINT=bar.end'//nl//' 20*step(0.1 - t), 200*step(0.1 - t)'//nl//'*TORQUE, NAME=twist, '// &
         & 'POINT=bar.middle'//nl//' 20*step(0.1 - t)'//nl//'*DYNAMICS, INTEGRATOR=CONSERVING, END=1, OUTPUTS=20, '// &
         & 'FIXED STEP=2e-3'//nl//'*OUTPUT'//nl//' momentum_x = momentum_x(system), momentum_y = momentum_y(system), '// &
         & 'angular_momentum = angular_momentum(system)'//nl, reader)
      call check_energy(reader, 1.0e-10_wp, 'free arc')
      do i = 1, 3
         call look(reader, trim(momenta(i)), 3, change, largest)
         print '(3a,2es10.2)', 'free arc: change of ', momenta(i), ', largest', change, largest
         call check(largest > 0.1_wp, 'free arc has '//momenta(i))
         call check_close(change/largest, 0.0_wp, 1.0e-10_wp, 'free arc: '//momenta(i))
      end do
      ! What the force gave: impulses 2 and 20
      call look(reader, 'momentum_x', 1, change, largest)
      call check_close(largest, 2.0_wp, 1.0e-10_wp, 'free arc: the impulse along x')
      call look(reader, 'momentum_y', 1, change, largest)
      call check_close(largest, 20.0_wp, 1.0e-10_wp, 'free arc: the impulse along y')
      call reader%close()
   end subroutine check_free

   !> A soft pendulum that folds, with steps that resolve little of it.
   subroutine check_pendulum()
      type(history_reader_type) :: reader
      call run_bar('FUNCTIONS=4, STRAIN FUNCTIONS=1', pin//'*GRAVITY, Y=-100'//nl//'*DYNAMICS, INTEGRATOR=CONSERVING, END=10, '// &
         & 'OUTPUTS=20, FIXED STEP=1e-3'//nl, reader)
      call check_energy(reader, 1.0e-10_wp, 'soft pendulum')
      call reader%close()
   end subroutine check_pendulum

   !> Half the step leaves a quarter of the error, against RADAU.
   subroutine check_order()
      character(*), parameter :: scene = pin//'*GRAVITY, Y=-30'//nl//'*DYNAMICS, END=0.2, OUTPUTS=10, INTEGRATOR='
      real(wp) :: path(22, 3), error(2)
      path(:, 1) = tip(scene//'RADAU, TOLERANCE=1e-10'//nl)
      path(:, 2) = tip(scene//'CONSERVING, FIXED STEP=2e-4'//nl)
      path(:, 3) = tip(scene//'CONSERVING, FIXED STEP=1e-4'//nl)
      error = [norm2(path(:, 2) - path(:, 1)), norm2(path(:, 3) - path(:, 1))]
      print '(a,2es10.2)', 'errors of two steps', error
      call check(error(1) < 1.0e-4_wp, 'small errors: '//as_text(error(1), 3))
      call check_close(error(1)/error(2), 4.0_wp, 0.2_wp, 'half the step')
   end subroutine check_order

   !> Where the end of the bar is at eleven samples.
   function tip(scene) result(path)
      character(*), intent(in) :: scene
      real(wp) :: path(22)
      type(history_reader_type) :: reader
      call run_bar('FUNCTIONS=2, STRAIN FUNCTIONS=0', scene, reader)
      path(:11) = channel(reader, 'x')
      path(12:) = channel(reader, 'y')
      call reader%close()
   end function tip

   !> A driven crank, the bar as its rod, a slider on a spring: a driver's work and round-off.
   subroutine check_crank()
      type(history_reader_type) :: reader
      call run_bar('FUNCTIONS=4, STRAIN FUNCTIONS=0, X=0.4', '*RIGID BODY, NAME=crank, MASS=1, INERTIA=0.1'//nl//' tip, 0.4, 0'// &
         & nl//'*POINT MASS, NAME=slider, MASS=0.5, X=1.4'//nl//'*JOINT, NAME=shaft, TYPE=REVOLUTE'//nl// &
         & ' crank.origin, ground.origin'//nl//'*JOINT, NAME=crank-pin, TYPE=REVOLUTE'//nl//' crank.tip, bar.start'//nl// &
         & '*JOINT, NAME=slider-pin, TYPE=REVOLUTE'//nl//' bar.end, slider'//nl//'*JOINT, NAME=guide, TYPE=POINT ON LINE'//nl// &
         & ' slider, ground.origin'//nl//'*DRIVER, NAME=motor, TYPE=ANGLE, BODY=crank'//nl//' 3*t'//nl// &
         & '*SPRING, NAME=hold, STIFFNESS=20, LENGTH=0.5'//nl//' slider, ground.far'//nl// &
         & '*DYNAMICS, INTEGRATOR=CONSERVING, END=2, OUTPUTS=20, TOLERANCE=1e-4'//nl, reader)
      call check_energy(reader, 1.0e-10_wp, 'slider-crank')
      call reader%close()
   end subroutine check_crank

   !> A bead that slides along a cantilever, two wheels that a coupler joins on it, a spring from the bead to its end.
   subroutine check_sliding()
      type(history_reader_type) :: reader
      call run_bar('FUNCTIONS=5, STRAIN FUNCTIONS=1', wall//'*POINT MASS, NAME=bead, MASS=0.5, X=0.3, VX=1'//nl// &
         & '*JOINT, NAME=slide, TYPE=SLIDING'//nl//' bead.origin, bar.end'//nl//'*SPRING, NAME=s, STIFFNESS=2, LENGTH=0.5'//nl// &
         & ' bead, bar.end'//nl//'*RIGID BODY, NAME=wheel, MASS=0.2, INERTIA=0.01, X=1'//nl//'*JOINT, NAME=hub, TYPE=REVOLUTE'// &
         & nl//' wheel, bar.end'//nl//'*RIGID BODY, NAME=other, MASS=0.2, INERTIA=0.01, X=0.5'//nl// &
         & '*JOINT, NAME=axle, TYPE=REVOLUTE'//nl//' other, bar.middle'//nl//'*COUPLER, NAME=mesh'//nl//' 1, joint_angle, hub'// &
         & nl//' 2, joint_angle, axle'//nl//'*GRAVITY, Y=-3'//nl// &
         & '*DYNAMICS, INTEGRATOR=CONSERVING, END=0.5, OUTPUTS=20, TOLERANCE=1e-4'//nl, reader)
      call check_energy(reader, 1.0e-10_wp, 'bead on a cantilever')
      call reader%close()
   end subroutine check_sliding

   !> A light bar that begins to fall: what is round-off of its first steps is no reason to give up.
   subroutine check_start()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call run_deck('verification/exact_start.inp', trim(results), .true., .true., report, error)
      call check_no_error(error, 'a light bar on a slope')
      if (allocated(error)) return
      call reader%open(trim(results), error)
      call check_no_error(error, 'results of the bar on a slope')
      call check_energy(reader, 1.0e-9_wp, 'a light bar on a slope')
      call reader%close()
   end subroutine check_start

   !> A light bar that springs set off, by steps of nanoseconds: what no correction makes smaller there is round-off of places. It
   !> neither ends the run nor costs energy.
   subroutine check_springs()
      character(6), parameter :: diameters(3) = ['0.0226', '0.0150', '0.0100']
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      integer :: i
      do i = 1, size(diameters)
         call change_deck('verification/exact_springs.inp', trim(results)//'.inp', ['DIAMETER=0.0226'], ['DIAMETER='//diameters(i)])
         call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
         call check_no_error(error, 'a bar that springs set off, '//diameters(i))
         if (allocated(error)) cycle
         call reader%open(trim(results), error)
         call check_no_error(error, 'results of the bar that springs set off')
         call check_energy(reader, 1.0e-10_wp, 'a bar that springs set off, '//diameters(i))
         call reader%close()
      end do
   end subroutine check_springs

end program test_exact_conserving
