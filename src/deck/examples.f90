!> An example of each keyword, for `limber help KEYWORD` and the manual. Each stands like this in a deck that the tests run
!> (unit/test_examples). Floor: deck.
module limber_deck_examples
   use limber_base_text, only: newline
   implicit none
   private
   public :: example_text

   !> A line of the example of a keyword
   type :: line_type
      !> In upper case, without the asterisk
      character(16) :: keyword
      character(110) :: text
   end type line_type

   !> Examples of what a scene is made of
   type(line_type), parameter :: scene_lines(*) = [ &
      & line_type('HEADING', '*HEADING'), &
      & line_type('HEADING', ' A mass that crosses a simply supported beam at constant speed and bends it'), &
      & line_type('PARAMETER', '*PARAMETER'), &
      & line_type('PARAMETER', ' sun = 0.03, planet = 0.02, ring = sun + 2*planet, torque = 4'), &
      & line_type('INCLUDE', '*INCLUDE, FILE=steel.inc'), &
      & line_type('REPEAT', '*REPEAT, COUNT=N - 1, INDEX=i, FROM=2'), &
      & line_type('REPEAT', '*JOINT, NAME=pin<i>, TYPE=REVOLUTE'), &
      & line_type('REPEAT', ' bar<i>.origin, bar<i - 1>.end'), &
      & line_type('REPEAT', '*END REPEAT'), &
      & line_type('END REPEAT', '*REPEAT, COUNT=N, INDEX=i'), &
      & line_type('END REPEAT', '*RIGID BODY, NAME=bar<i>, MASS=1, INERTIA=1/12, CENTRE X=0.5, X=i - 1'), &
      & line_type('END REPEAT', ' end, 1, 0'), &
      & line_type('END REPEAT', '*END REPEAT'), &
      & line_type('UNITS', '*UNITS, LENGTH=mm, MASS=t, TIME=s'), &
      & line_type('MATERIAL', '*MATERIAL, NAME=steel, YOUNG=2.1e11, DENSITY=7850'), &
      & line_type('SECTION', '*SECTION, NAME=column, SHAPE=TUBE, DIAMETER=0.2, THICKNESS=0.01'), &
      & line_type('SECTION', '*SECTION, NAME=girder, SHAPE=RECTANGLE, WIDTH=0.1, HEIGHT=0.24'), &
      & line_type('GRAVITY', '*GRAVITY, Y=-9806.65'), &
      & line_type('GROUND', '*GROUND'), &
      & line_type('GROUND', ' pivot, 0, -distance'), &
      & line_type('GROUND', ' guide, 0, height - distance'), &
      & line_type('RIGID BODY', '*RIGID BODY, NAME=rocker, MASS=1.2, INERTIA=5e-3, CENTRE X=rocker/2, X=base, ANGLE=2'), &
      & line_type('RIGID BODY', ' tip, rocker, 0'), &
      & line_type('POINT MASS', '*POINT MASS, NAME=slider, MASS=0.033375, X=crank + length'), &
      & line_type('BEAM', '*BEAM, NAME=boom, MATERIAL=steel, SECTION=flat, LENGTH=2, SUPPORT=CLAMPED-FREE, ' &
      &    //'BENDING MODES=3, AXIAL MODES=1'), &
      & line_type('BEAM', ' hook, 1.5')]
   !> Examples of frames
   type(line_type), parameter :: frame_lines(*) = [ &
      & line_type('FRAME', '*FRAME, NAME=portal, MATERIAL=steel, MODES=6, GEOMETRIC=LINEAR, DIVISIONS=12'), &
      & line_type('FRAME', ' left-foot, 1, 0'), &
      & line_type('FRAME', ' left-knee, 1, height'), &
      & line_type('FRAME', ' machine, 2, span/3'), &
      & line_type('NODE', '*NODE'), &
      & line_type('NODE', ' 1, 0, 0, foot'), &
      & line_type('NODE', ' 2, 0, height, knee'), &
      & line_type('NODE', ' 3, span/3, height'), &
      & line_type('NODE', ' 4, span, height'), &
      & line_type('NODE', '*NODE, NSET=base'), &
      & line_type('NODE', ' 5, span, 0'), &
      & line_type('ELEMENT', '*ELEMENT, ELSET=columns'), &
      & line_type('ELEMENT', ' 1, 1, 2'), &
      & line_type('ELEMENT', ' 4, 4, 5'), &
      & line_type('ELEMENT', '*ELEMENT, SECTION=girder'), &
      & line_type('ELEMENT', ' 2, 2, 3'), &
      & line_type('ELEMENT', ' 3, 3, 4'), &
      & line_type('NSET', '*NSET, NSET=base'), &
      & line_type('NSET', ' 1'), &
      & line_type('ELSET', '*ELSET, ELSET=post'), &
      & line_type('ELSET', ' 1'), &
      & line_type('BEAM SECTION', '*BEAM SECTION, ELSET=columns, SECTION=column'), &
      & line_type('BOUNDARY', '*BOUNDARY'), &
      & line_type('BOUNDARY', ' base, 1, 6'), &
      & line_type('MASS', '*MASS'), &
      & line_type('MASS', ' 3, 800, 150'), &
      & line_type('PROFILE', '*PROFILE, BODY=mast'), &
      & line_type('PROFILE', ' 0.5, wide, narrow'), &
      & line_type('PROFILE', ' 1.2, narrow'), &
      & line_type('ATTACHMENT', '*ATTACHMENT'), &
      & line_type('ATTACHMENT', ' 3, 2'), &
      & line_type('ATTACHMENT', ' 3, 6')]
   !> Examples of joints, drivers and loads
   type(line_type), parameter :: joint_lines(*) = [ &
      & line_type('JOINT', '*JOINT, NAME=slider-pin, TYPE=REVOLUTE'), &
      & line_type('JOINT', ' rod.end, slider'), &
      & line_type('JOINT', '*JOINT, NAME=guide, TYPE=POINT ON LINE'), &
      & line_type('JOINT', ' slider, ground.origin'), &
      & line_type('TABLE', '*TABLE, NAME=thrust, INTERPOLATION=SPLINE'), &
      & line_type('TABLE', ' 0, 0'), &
      & line_type('TABLE', ' 0.1, 400'), &
      & line_type('TABLE', ' 0.3, 200'), &
      & line_type('TABLE', '*FORCE, NAME=winch, POINT=left-cage'), &
      & line_type('TABLE', ' 0, thrust(t)'), &
      & line_type('CURVE', '*CURVE, NAME=profile, CLOSED=YES, FILE=cam_profile.csv'), &
      & line_type('COUPLER', '*COUPLER, NAME=ring-mesh'), &
      & line_type('COUPLER', ' ring, angle, ring'), &
      & line_type('COUPLER', ' -ring, angle, carrier'), &
      & line_type('COUPLER', ' -planet, joint_angle, planet-pin'), &
      & line_type('DRIVER', '*DRIVER, NAME=motor, TYPE=ANGLE, JOINT=motor-shaft, LEVEL=VELOCITY'), &
      & line_type('DRIVER', ' speed*cycloidal(5*t)'), &
      & line_type('MOTION', '*MOTION, NAME=motor, BODY=crank'), &
      & line_type('MOTION', ' 0, 0, speed*t'), &
      & line_type('FORCE', '*FORCE, NAME=hammer, POINT=bar.end'), &
      & line_type('FORCE', ' 0, blow*step(duration - t)'), &
      & line_type('TORQUE', '*TORQUE, NAME=elbow-motor, POINT=fore.start, REACTION=upper.end'), &
      & line_type('TORQUE', ' -0.4*cos(2*pi*t/stop)'), &
      & line_type('SPRING', '*SPRING, NAME=rope, STIFFNESS=2e4, LENGTH=0.6, DAMPING=50'), &
      & line_type('SPRING', ' load, boom.hook'), &
      & line_type('BUSHING', '*BUSHING, NAME=mount, STIFFNESS X=2e4, STIFFNESS Y=1e4, STIFFNESS ROTATION=500, DAMPING Y=30'), &
      & line_type('BUSHING', ' engine.origin, bracket.seat'), &
      & line_type('DISTRIBUTED LOAD', '*DISTRIBUTED LOAD, NAME=triangular, BODY=triangular'), &
      & line_type('DISTRIBUTED LOAD', ' 0, -q*s/length, smoothstep(t)'), &
      & line_type('DAMPING', '*DAMPING, BODY=uniform, RATIO=0.9'), &
      & line_type('FRICTION', '*FRICTION, NAME=rail, JOINT=left-guide, COEFFICIENT=25')]
   !> Examples of analyses and of what they give
   type(line_type), parameter :: analysis_lines(*) = [ &
      & line_type('ASSEMBLY', '*ASSEMBLY, LARGEST TURN=0.2, INITIAL DEFLECTIONS=STATIC'), &
      & line_type('KINEMATICS', '*KINEMATICS, END=2*pi/speed, OUTPUTS=90'), &
      & line_type('INVERSE DYNAMICS', '*INVERSE DYNAMICS, END=4*pi/speed, OUTPUTS=90'), &
      & line_type('STATICS', '*STATICS, PERIOD=1.2, INCREMENTS=12, INSTABILITY=LEAVE'), &
      & line_type('MODES', '*STATICS, NAME=s1, PERIOD=1, INCREMENTS=1, ROTATION=1'), &
      & line_type('MODES', '*MODES, NAME=speed_1, NUMBER=2'), &
      & line_type('DYNAMICS', '*DYNAMICS, END=1, OUTPUTS=2000, TOLERANCE=1e-8, INTEGRATOR=ADAMS'), &
      & line_type('ACCURACY', '*ACCURACY, ESTIMATE=YES'), &
      & line_type('STUDY', '*STUDY, BEAM=boom, ERROR=1e-3'), &
      & line_type('STUDY', ' tolerances, 1e-3, 1e-4, 1e-5'), &
      & line_type('STUDY', ' bending modes, 2, 3, 4'), &
      & line_type('STUDY', ' channels, hook, engine'), &
      & line_type('SWEEP', '*SWEEP'), &
      & line_type('SWEEP', ' speed, 10:105:20'), &
      & line_type('SWEEP', ' diameter, 6e-3, 8e-3, 10e-3, 12e-3'), &
      & line_type('SCALAR', '*SCALAR'), &
      & line_type('SCALAR', ' largest = max(maximum(deflection), -minimum(deflection)), rms(deflection)'), &
      & line_type('OUTPUT', '*OUTPUT'), &
      & line_type('OUTPUT', ' angle(bar), x(bar.middle), y(bar.middle), deflection(bar.middle), bending_moment(bar.middle)'), &
      & line_type('OUTPUT', ' momentum_x(system), momentum_y(system), angular_momentum(system)'), &
      & line_type('OUTPUT', ' energy = kinetic_energy(system) + potential_energy(system)')]
   type(line_type), parameter :: lines(*) = [scene_lines, frame_lines, joint_lines, analysis_lines]

contains

   !> The example of a keyword: lines of a deck, each but the last ended by a line feed; empty if there is none.
   pure function example_text(keyword) result(text)
      !> In upper case, without the asterisk
      character(*), intent(in) :: keyword
      character(:), allocatable :: text
      integer :: i
      text = ''
      do i = 1, size(lines)
         if (lines(i)%keyword /= keyword) cycle
         if (len(text) > 0) text = text//newline
         text = text//trim(lines(i)%text)
      end do
   end function example_text

end module limber_deck_examples
