!> Interrupted runs have the bits of whole ones with all that a run may remember: breaks of drivers and loads, envelopes, axial
!> coordinates at rest, elements of K_G, redundant constraints, estimates of errors, scalars, prescribed motions, curves, motions
!> for drawings, events, switches, controls, rigid stops.
program test_restart_features
   use pieces, only: compare_pieces
   use testing, only: finish
   implicit none
   character(*), parameter :: integrators(*) = [character(10) :: 'ADAMS', 'RADAU', 'ALPHA', 'CONSERVING']
   character(*), parameter :: nl = new_line('a')
   character(512) :: argument

   call get_command_argument(1, argument)
   call test_all(trim(argument))
   call finish()

contains

   subroutine test_all(results)
      character(*), intent(in) :: results
      integer :: i
      do i = 1, size(integrators)
         ! K_G; a driver with a break, a gust with two
         call compare_pieces('rotating_cantilever', results, 5, 'speed = 6, rise = 12', 'speed = 0.2, rise = 0.5', &
            & 'END=24, OUTPUTS=2400, TOLERANCE=1e-7', &
            & 'END=1, OUTPUTS=100, TOLERANCE=1e-4, INTEGRATOR='//integrators(i))
         ! An envelope
         call compare_pieces('portal_frame', results, 5, 'DIVISIONS=12', 'DIVISIONS=4', 'END=4, OUTPUTS=1000, TOLERANCE=1e-7', &
            & 'END=0.4, OUTPUTS=100, TOLERANCE=1e-4, INTEGRATOR='//integrators(i))
         ! Redundant constraints
         call compare_pieces('parallelogram_five_cranks', results, 5, '*OUTPUT', '*OUTPUT', &
            & 'END=10, TOLERANCE=1e-8, OUTPUTS=200, INTEGRATOR=ADAMS', &
            & 'END=2, TOLERANCE=1e-4, OUTPUTS=40, INTEGRATOR='//integrators(i))
      end do
      ! An exact beam
      do i = 1, 2
         call compare_pieces('spin_up', results, 5, 'STRAIN FUNCTIONS=2', 'STRAIN FUNCTIONS=0', &
            & 'END=20, TOLERANCE=1e-8, OUTPUTS=1000, INTEGRATOR=ADAMS', 'END=20, TOLERANCE=1e-4, OUTPUTS=100, INTEGRATOR='// &
            & integrators(i))
      end do
      ! An estimate of errors; a driver with a break
      call compare_pieces('flexible_four_bar', results, 5, 'rise = 0.4', 'rise = 0.02', &
         & 'END=rise + 2*pi/speed, OUTPUTS=400, TOLERANCE=1e-6', &
         & 'END=rise + 0.05, OUTPUTS=100, TOLERANCE=1e-4'//nl//'*ACCURACY, ESTIMATE=YES')
      ! Scalars; a deck of a sweep
      call compare_pieces('sweep_speed', results, 5, 'OUTPUTS=400', 'OUTPUTS=100', 'rms(deflection)', &
         & 'rms(deflection), mean(deflection)')
      ! A prescribed motion
      call compare_pieces('slider_crank_prescribed', results, 5, 'turns = 2', 'turns = 0.2', 'TOLERANCE=1e-8, OUTPUTS=838', &
         & 'TOLERANCE=1e-5, OUTPUTS=83')
      ! K_G of a slider-crank; a motion to be drawn
      call compare_pieces('slider_crank_fig5_kg', results, 5, 'turns = 2', 'turns = 0.2', &
         & 'TOLERANCE=1e-9, OUTPUTS=838'//nl//'*OUTPUT', &
         & 'TOLERANCE=1e-5, OUTPUTS=83'//nl//'*OUTPUT, MOTION=YES')
      ! A curve from a table; a point along a beam; bodies in segments; a load with a break; drivers by formulas
      call execute_command_line('cp ../input/cam_profile.csv '//results(:index(results, '/', back=.true.)))
      call compare_pieces('cam', results, 5, 'OUTPUTS=110', 'OUTPUTS=55', 'TOLERANCE=1e-8', 'TOLERANCE=1e-5')
      call compare_pieces('moving_mass_on_beam', results, 5, 'OUTPUTS=50', 'OUTPUTS=25', 'TOLERANCE=1e-9', 'TOLERANCE=1e-5')
      call compare_pieces('soft_pendulum', results, 5, 'END=1.1', 'END=0.2', 'TOLERANCE=1e-4, OUTPUTS=220', &
         & 'TOLERANCE=1e-3, OUTPUTS=20')
      call compare_pieces('struck_rod', results, 5, 'END=6*passage', 'END=3*passage', 'TOLERANCE=1e-8', 'TOLERANCE=1e-5')
      call compare_pieces('car_axis', results, 5, 'OUTPUTS=300', 'OUTPUTS=100', 'TOLERANCE=1e-9', 'TOLERANCE=1e-5')
      call compare_pieces('two_link_manipulator', results, 5, 'OUTPUTS=200', 'OUTPUTS=50', 'TOLERANCE=1e-8', 'TOLERANCE=1e-4')
      ! Events, one of which ends the run
      do i = 1, size(integrators)
         call compare_pieces('pendulum', results, 5, 'END=10, TOLERANCE=1e-11, OUTPUTS=200', &
            & 'END=10, TOLERANCE=1e-5, OUTPUTS=200,'// &
            & ' INTEGRATOR='//integrators(i), '*OUTPUT', '*EVENT, NAME=side'//nl//' x(bob)'//nl// &
            & '*EVENT, NAME=sixth, NUMBER=6, ACTION=STOP'//nl//' x(bob) + 0.3'//nl//'*OUTPUT')
      end do
      ! Switches: a joint that opens, one that closes, one that opens again; a load that acts in the second of two analyses
      do i = 1, size(integrators)
         call compare_pieces('latch', results, 5, 'END=1.2, TOLERANCE=1e-9, OUTPUTS=120, INTEGRATOR=ADAMS', &
            & 'END=0.9, TOLERANCE=1e-5, OUTPUTS=45, INTEGRATOR='//integrators(i)//nl//'*DYNAMICS, END=1.2, OUTPUTS=9, '// &
            & 'INTEGRATOR='//integrators(i), '*OUTPUT', '** '//integrators(i)//nl//'*FORCE, NAME=wind, POINT=ball, INACTIVE='// &
            & 'rest'//nl//' 0.5 - 0.02*vx(ball), 0'//nl//'*OUTPUT')
      end do
      ! Controls: states with rates, samples, a delay, limits; a second analysis
      do i = 1, size(integrators)
         call compare_pieces('pid_arm', results, 5, 'END=2.5, TOLERANCE=1e-8, OUTPUTS=250, INTEGRATOR=ADAMS', &
            & 'END=0.8, TOLERANCE=1e-5, OUTPUTS=80, INTEGRATOR='//integrators(i)//nl//'*DYNAMICS, END=1, OUTPUTS=9, '// &
            & 'INTEGRATOR='//integrators(i), '*TORQUE', '*CONTROL, NAME=i, TYPE=PID, KP=2, KI=4, KD=1, FILTER=0.1, MOST=1'//nl// &
            & ' output(motor)'//nl//'*CONTROL, NAME=h, TYPE=HYSTERESIS, LEAST=-1.5, MOST=-1.3'//nl//' angle(arm)'//nl//'*TORQUE')
      end do
      ! Rigid stops: impacts, rest, release; bounces that come to an end
      do i = 1, size(integrators)
         call compare_pieces('rocking_block', results, 5, 'END=3.5, OUTPUTS=350, TOLERANCE=1e-9, INTEGRATOR=RADAU', &
            & 'END=2, OUTPUTS=100, TOLERANCE=1e-5, INTEGRATOR='//integrators(i), '*OUTPUT', '** '//integrators(i)//nl//'*OUTPUT')
         call compare_pieces('pendulum', results, 5, 'END=10, TOLERANCE=1e-11, OUTPUTS=200', &
            & 'END=4, TOLERANCE=1e-5, OUTPUTS=100, INTEGRATOR='//integrators(i), '*OUTPUT', '*STOP, NAME=wall, AXIS=0, '// &
            & 'LEAST=0.2, LAW=RIGID, RESTITUTION=0.4'//nl//' bob, ground.origin'//nl//'*OUTPUT'//nl//' lost(wall), closed(wall)')
      end do
   end subroutine test_all

end program test_restart_features
