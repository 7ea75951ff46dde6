!> Example of each keyword, for help and manual. Each stands like this in a deck that the tests run (unit/test_examples). Examples
!> of
!> joints, drivers and loads are in `src/elements`. Floor: deck.
module limber_deck_examples
   use limber_base_text, only: newline
   use limber_deck_keywords, only: keyword_example
   implicit none
   private
   public :: example_text

   !> A line of the example of a keyword
   type :: example_type
      !> In upper case, without the asterisk
      character(16) :: keyword
      character(110) :: text
   end type example_type

   !> Examples of what a scene is made of
   type(example_type), parameter :: scene_lines(*) = [ &
      & example_type('HEADING', '*HEADING'), &
      & example_type('HEADING', ' A mass that crosses a simply supported beam at constant speed and bends it'), &
      & example_type('EXPRESSION', '*EXPRESSION'), &
      & example_type('EXPRESSION', ' slip = vx(engine) - vx(bracket.seat), beat = sin(2*pi*t)'), &
      & example_type('PARAMETER', '*PARAMETER'), &
      & example_type('PARAMETER', ' sun = 0.03, planet = 0.02, ring = sun + 2*planet, torque = 4'), &
      & example_type('INCLUDE', '*INCLUDE, FILE=steel.inc'), &
      & example_type('REPEAT', '*REPEAT, COUNT=N - 1, INDEX=i, FROM=2'), &
      & example_type('REPEAT', '*JOINT, NAME=pin<i>, TYPE=REVOLUTE'), &
      & example_type('REPEAT', ' bar<i>.origin, bar<i - 1>.end'), &
      & example_type('REPEAT', '*END REPEAT'), &
      & example_type('END REPEAT', '*REPEAT, COUNT=N, INDEX=i'), &
      & example_type('END REPEAT', '*RIGID BODY, NAME=bar<i>, MASS=1, INERTIA=1/12, CENTRE X=0.5, X=i - 1'), &
      & example_type('END REPEAT', ' end, 1, 0'), &
      & example_type('END REPEAT', '*END REPEAT'), &
      & example_type('UNITS', '*UNITS, LENGTH=mm, MASS=t, TIME=s'), &
      & example_type('MATERIAL', '*MATERIAL, NAME=steel, YOUNG=2.1e11, DENSITY=7850'), &
      & example_type('SECTION', '*SECTION, NAME=column, SHAPE=TUBE, DIAMETER=0.2, THICKNESS=0.01'), &
      & example_type('SECTION', '*SECTION, NAME=girder, SHAPE=RECTANGLE, WIDTH=0.1, HEIGHT=0.24'), &
      & example_type('GRAVITY', '*GRAVITY, Y=-9806.65'), &
      & example_type('GROUND', '*GROUND'), &
      & example_type('GROUND', ' pivot, 0, -distance'), &
      & example_type('GROUND', ' guide, 0, height - distance'), &
      & example_type('RIGID BODY', '*RIGID BODY, NAME=rocker, MASS=1.2, INERTIA=5e-3, CENTRE X=rocker/2, X=base, ANGLE=2'), &
      & example_type('RIGID BODY', ' tip, rocker, 0'), &
      & example_type('POINT MASS', '*POINT MASS, NAME=slider, MASS=0.033375, X=crank + length'), &
      & example_type('BEAM', '*BEAM, NAME=boom, MATERIAL=steel, SECTION=flat, LENGTH=2, SUPPORT=CLAMPED-FREE, ' &
      &    //'BENDING MODES=3, AXIAL MODES=1'), &
      & example_type('BEAM', ' hook, 1.5')]
   !> Examples of frames
   type(example_type), parameter :: frame_lines(*) = [ &
      & example_type('FRAME', '*FRAME, NAME=portal, MATERIAL=steel, MODES=6, GEOMETRIC=LINEAR, DIVISIONS=12'), &
      & example_type('FRAME', ' left-foot, 1, 0'), &
      & example_type('FRAME', ' left-knee, 1, height'), &
      & example_type('FRAME', ' machine, 2, span/3'), &
      & example_type('NODE', '*NODE'), &
      & example_type('NODE', ' 1, 0, 0, foot'), &
      & example_type('NODE', ' 2, 0, height, knee'), &
      & example_type('NODE', ' 3, span/3, height'), &
      & example_type('NODE', ' 4, span, height'), &
      & example_type('NODE', '*NODE, NSET=base'), &
      & example_type('NODE', ' 5, span, 0'), &
      & example_type('ELEMENT', '*ELEMENT, ELSET=columns'), &
      & example_type('ELEMENT', ' 1, 1, 2'), &
      & example_type('ELEMENT', ' 4, 4, 5'), &
      & example_type('ELEMENT', '*ELEMENT, SECTION=girder'), &
      & example_type('ELEMENT', ' 2, 2, 3'), &
      & example_type('ELEMENT', ' 3, 3, 4'), &
      & example_type('NSET', '*NSET, NSET=base'), &
      & example_type('NSET', ' 1'), &
      & example_type('ELSET', '*ELSET, ELSET=post'), &
      & example_type('ELSET', ' 1'), &
      & example_type('BEAM SECTION', '*BEAM SECTION, ELSET=columns, SECTION=column'), &
      & example_type('BOUNDARY', '*BOUNDARY'), &
      & example_type('BOUNDARY', ' base, 1, 6'), &
      & example_type('MASS', '*MASS'), &
      & example_type('MASS', ' 3, 800, 150'), &
      & example_type('PROFILE', '*PROFILE, BODY=mast'), &
      & example_type('PROFILE', ' 0.5, wide, narrow'), &
      & example_type('PROFILE', ' 1.2, narrow'), &
      & example_type('ATTACHMENT', '*ATTACHMENT'), &
      & example_type('ATTACHMENT', ' 3, 2'), &
      & example_type('ATTACHMENT', ' 3, 6')]
   !> Examples of tables, curves and damping
   type(example_type), parameter :: function_lines(*) = [ &
      & example_type('TABLE', '*TABLE, NAME=thrust, INTERPOLATION=SPLINE'), &
      & example_type('TABLE', ' 0, 0'), &
      & example_type('TABLE', ' 0.1, 400'), &
      & example_type('TABLE', ' 0.3, 200'), &
      & example_type('TABLE', '*FORCE, NAME=winch, POINT=left-cage'), &
      & example_type('TABLE', ' 0, thrust(t)'), &
      & example_type('CURVE', '*CURVE, NAME=profile, CLOSED=YES, FILE=cam_profile.csv'), &
      & example_type('DAMPING', '*DAMPING, BODY=uniform, RATIO=0.9')]
   !> Examples of analyses and of what they give
   type(example_type), parameter :: analysis_lines(*) = [ &
      & example_type('ASSEMBLY', '*ASSEMBLY, LARGEST TURN=0.2, INITIAL DEFLECTIONS=STATIC'), &
      & example_type('KINEMATICS', '*KINEMATICS, END=2*pi/speed, OUTPUTS=90'), &
      & example_type('INVERSE DYNAMICS', '*INVERSE DYNAMICS, END=4*pi/speed, OUTPUTS=90'), &
      & example_type('STATICS', '*STATICS, PERIOD=1.2, INCREMENTS=12, INSTABILITY=LEAVE'), &
      & example_type('MODES', '*STATICS, NAME=s1, PERIOD=1, INCREMENTS=1, ROTATION=1'), &
      & example_type('MODES', '*MODES, NAME=speed_1, NUMBER=2'), &
      & example_type('DYNAMICS', '*DYNAMICS, END=1, OUTPUTS=2000, TOLERANCE=1e-8, INTEGRATOR=ADAMS'), &
      & example_type('ACCURACY', '*ACCURACY, ESTIMATE=YES'), &
      & example_type('STUDY', '*STUDY, BEAM=boom, ERROR=1e-3'), &
      & example_type('STUDY', ' tolerances, 1e-3, 1e-4, 1e-5'), &
      & example_type('STUDY', ' bending modes, 2, 3, 4'), &
      & example_type('STUDY', ' channels, hook, engine'), &
      & example_type('SWEEP', '*SWEEP'), &
      & example_type('SWEEP', ' speed, 10:105:20'), &
      & example_type('SWEEP', ' diameter, 6e-3, 8e-3, 10e-3, 12e-3'), &
      & example_type('SCALAR', '*SCALAR'), &
      & example_type('SCALAR', ' largest = max(maximum(deflection), -minimum(deflection)), rms(deflection)'), &
      & example_type('OUTPUT', '*OUTPUT'), &
      & example_type('OUTPUT', ' angle(bar), x(bar.middle), y(bar.middle), deflection(bar.middle), bending_moment(bar.middle)'), &
      & example_type('OUTPUT', ' momentum_x(system), momentum_y(system), angular_momentum(system)'), &
      & example_type('OUTPUT', ' energy = kinetic_energy(system) + potential_energy(system)')]
   type(example_type), parameter :: lines(*) = [scene_lines, frame_lines, function_lines, analysis_lines]

contains

   !> The example of a keyword: lines of a deck, each but the last ended by a line feed; empty if there is none.
   pure function example_text(keyword) result(text)
      !> In upper case, without the asterisk
      character(*), intent(in) :: keyword
      character(:), allocatable :: text
      character(110), allocatable :: found(:)
      integer :: i
      allocate (found, source=[keyword_example(keyword), pack(lines%text, lines%keyword == keyword)])
      text = ''
      do i = 1, size(found)
         if (i > 1) text = text//newline
         text = text//trim(found(i))
      end do
   end function example_text

end module limber_deck_examples
