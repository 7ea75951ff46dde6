!> Scenes of textbooks, written with nothing of a beam but material, section and length: right to a hundredth without a warning.
!> References: closed forms, linear finite elements with consistent masses, and chains of segments with springs between them (20
!> and 10 to each beam, 16 and 8 of the arm and the belt, extrapolated). Usage, in tests/: test_textbook RESULT_FILE
program test_textbook
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_output_history_reader, only: history_reader_type
   use runs, only: channel, run_text, read_columns
   use testing, only: check, check_no_error, finish
   implicit none
   character(*), parameter :: nl = new_line('a')
   !> E I = 1, E A = 1e6, mass per length 1
   character(*), parameter :: unit_stuff = '*MATERIAL, NAME=stuff, YOUNG=1e6, DENSITY=1'//nl// &
      & '*SECTION, NAME=bar, SHAPE=GENERAL, AREA=1, INERTIA=1e-6'//nl
   character(*), parameter :: bar = '*BEAM, NAME=bar, MATERIAL=stuff, SECTION=bar, LENGTH=1'//nl
   character(*), parameter :: wall = '*JOINT, NAME=wall, TYPE=WELD, TURN=0'//nl//' bar.start, ground.origin'//nl
   character(*), parameter :: pin = '*JOINT, NAME=pin, TYPE=REVOLUTE'//nl//' bar.start, ground.origin'//nl
   character(*), parameter :: roller = '*GROUND'//nl//' far, 1, 0'//nl//'*JOINT, NAME=roller, TYPE=POINT ON LINE'//nl// &
      & ' bar.end, ground.far'//nl
   character(*), parameter :: guide = '*GROUND'//nl//' far, 1, 0'//nl//'*JOINT, NAME=guide, TYPE=WELD, TURN=0'//nl// &
      & ' bar.end, ground.far'//nl
   real(wp), parameter :: pi = acos(-1.0_wp)
   character(256) :: results

   call get_command_argument(1, results)
   call check_at_rest()
   call check_frequencies()
   call check_portal()
   call check_harmonic()
   call check_pendulum()
   call check_crank()
   call check_four_bar()
   call check_moving_mass()
   call check_arm()
   call check_belt()
   call finish()

contains

   !> A propped cantilever under a uniform load: reaction 3/8, moment 1/8, 1/192 in the middle. A column at 0.95 of Euler's load
   !> under a force across its middle. A cross of four arms of 1/2, one of them clamped, loaded at two others.
   subroutine check_at_rest()
      real(wp) :: u
      call run_scene('propped cantilever', unit_stuff//bar//wall//roller//'*DISTRIBUTED LOAD, NAME=snow, BODY=bar'//nl// &
         & ' 0, -1e-2'//nl//'*STATICS'//nl//'*OUTPUT'//nl//' prop = force_y(roller)'//nl// &
         & ' moment = bending_moment(bar.start), sag = y(bar.middle)'//nl)
      call judge('propped cantilever', 'prop', [3.75e-3_wp])
      call judge('propped cantilever', 'moment', [-1.25e-3_wp])
      call judge('propped cantilever', 'sag', [-1.0e-2_wp/192])
      u = 0.5_wp*pi*sqrt(0.95_wp)
      call run_scene('column', unit_stuff//bar//pin//roller//'*FORCE, NAME=load, POINT=bar.end'//nl//' -0.95*pi**2, 0'//nl// &
         & '*FORCE, NAME=push, POINT=bar.middle'//nl//' 0, 1e-3'//nl//'*STATICS, INCREMENTS=5'//nl//'*MODES, NUMBER=1'//nl// &
         & '*OUTPUT'//nl//' sag = y(bar.middle)'//nl)
      call judge('column', 'sag', [1.0e-3_wp/16*(tan(u) - u)/u**3])
      call judge_frequencies('column', [pi**2*sqrt(0.05_wp)])
      call run_scene('cross', unit_stuff//arm('one', 0, 0.0_wp)//arm('two', 5, 0.0_wp)//arm('up', 5, 90.0_wp)// &
         & arm('down', 5, -90.0_wp)//'*JOINT, NAME=wall, TYPE=WELD'//nl//' one.start, ground.origin'//nl//to_hub('two')// &
         & to_hub('up')//to_hub('down')//'*FORCE, NAME=tip, POINT=two.end'//nl//' 0, 1e-3'//nl// &
         & '*FORCE, NAME=top, POINT=up.end'//nl//' 1e-3, 0'//nl//'*STATICS'//nl//'*MODES, NUMBER=4'//nl//'*OUTPUT'//nl// &
         & ' tip = y(two.end), top = x(up.end) - 0.5'//nl)
      call judge('cross', 'tip', [1.458333e-4_wp])
      call judge('cross', 'top', [-2.0833e-5_wp])
      call judge_frequencies('cross', [2.517187_wp, 10.303244_wp, 14.063637_wp, 15.713015_wp])
   end subroutine check_at_rest

   !> An arm of the cross, and its weld.
   function arm(name, tenths, degrees) result(text)
      character(*), intent(in) :: name
      !> Where it starts, tenths of the unit, and its direction
      integer, intent(in) :: tenths
      real(wp), intent(in) :: degrees
      character(:), allocatable :: text
      character(8) :: number
      write (number, '(f8.1)') degrees
      text = '*BEAM, NAME='//name//', MATERIAL=stuff, SECTION=bar, LENGTH=0.5, X=0.'//achar(48 + tenths)//', ANGLE='// &
         & trim(adjustl(number))//' deg'//nl
   end function arm

   function to_hub(name) result(text)
      character(*), intent(in) :: name
      character(:), allocatable :: text
      text = '*JOINT, NAME=hub-'//name//', TYPE=WELD'//nl//' '//name//'.start, one.end'//nl
   end function to_hub

   !> A cantilever with half its mass at its tip that rotates in its plane with 4 sqrt(E I/(rho A L^4)); a bar on two springs of 50.
   subroutine check_frequencies()
      call run_scene('rotor', unit_stuff//bar//pin//'*MASS'//nl//' 1, 0.5'//nl//'*DRIVER, NAME=hub, TYPE=ANGLE, BODY=bar'//nl// &
         & ' 0'//nl//'*STATICS, ROTATION=4, INCREMENTS=5'//nl//'*MODES, NUMBER=3'//nl//'*OUTPUT'//nl//' x(bar.end)'//nl)
      call judge_frequencies('rotor', [2.556734_wp, 21.139887_wp, 56.938861_wp])
      call run_scene('springs', unit_stuff//bar//'*GROUND'//nl//' far, 1, 0'//nl// &
         & '*BUSHING, NAME=near, STIFFNESS X=1e4, STIFFNESS Y=50'//nl//' bar.start, ground.origin'//nl// &
         & '*BUSHING, NAME=other, STIFFNESS Y=50'//nl//' bar.end, ground.far'//nl//'*MODES, NUMBER=3'//nl//'*OUTPUT'//nl// &
         & ' x(bar.end)'//nl)
      call judge_frequencies('springs', [7.205783_wp, 16.315201_wp, 30.516286_wp])
   end subroutine check_frequencies

   !> A portal of three tubes welded at its knees and to the ground at half its critical load.
   subroutine check_portal()
      call run_scene('portal', '*MATERIAL, NAME=steel, YOUNG=2.1e11, DENSITY=7850'//nl// &
         & '*SECTION, NAME=tube, SHAPE=TUBE, DIAMETER=0.06, THICKNESS=0.004'//nl// &
         & '*BEAM, NAME=left, MATERIAL=steel, SECTION=tube, LENGTH=3, ANGLE=pi/2'//nl// &
         & '*BEAM, NAME=girder, MATERIAL=steel, SECTION=tube, LENGTH=4, Y=3'//nl// &
         & '*BEAM, NAME=right, MATERIAL=steel, SECTION=tube, LENGTH=3, X=4, ANGLE=pi/2'//nl//'*GROUND'//nl//' far, 4, 0'//nl// &
         & '*JOINT, NAME=a, TYPE=WELD'//nl//' left.start, ground.origin'//nl//'*JOINT, NAME=b, TYPE=WELD'//nl// &
         & ' right.start, ground.far'//nl//'*JOINT, NAME=c, TYPE=WELD'//nl//' girder.start, left.end'//nl// &
         & '*JOINT, NAME=d, TYPE=WELD'//nl//' girder.end, right.end'//nl//'*FORCE, NAME=p, POINT=left.end'//nl// &
         & ' 4.424, -22120'//nl//'*FORCE, NAME=q, POINT=right.end'//nl//' 0, -22120'//nl//'*STATICS, INCREMENTS=5'//nl// &
         & '*MODES, NUMBER=1'//nl//'*OUTPUT'//nl//' sway = x(left.end)'//nl)
      call judge('portal', 'sway', [2.630258e-4_wp])
      call judge_frequencies('portal', [22.85546_wp])
   end subroutine check_portal

   !> A bar clamped at both ends under a harmonic force in its middle, from rest: the sum of its modes.
   subroutine check_harmonic()
      call run_scene('harmonic', unit_stuff//bar//wall//guide//'*FORCE, NAME=load, POINT=bar.middle'//nl//' 0, 1e-3*sin(13.4*t)'// &
         & nl//'*DYNAMICS, END=0.5, OUTPUTS=10'//nl//'*OUTPUT'//nl//' sag = 1000*y(bar.middle)'//nl)
      call judge('harmonic', 'sag', [8.161799e-3_wp, -1.2715271e-2_wp, 7.882026e-3_wp], [5, 8, 11])
   end subroutine check_harmonic

   !> A steel strip of 20 x 2 mm hangs on a hinge and is let go from level.
   subroutine check_pendulum()
      call run_scene('pendulum', '*MATERIAL, NAME=steel, YOUNG=2.1e11, DENSITY=7850'//nl// &
         & '*SECTION, NAME=bar, SHAPE=RECTANGLE, WIDTH=0.02, HEIGHT=0.002'//nl// &
         & '*BEAM, NAME=bar, MATERIAL=steel, SECTION=bar, LENGTH=1'//nl//pin//'*GRAVITY, Y=-9.81'//nl// &
         & '*DYNAMICS, END=1.2, OUTPUTS=6'//nl//'*OUTPUT'//nl//' x = x(bar.end), y = y(bar.end)'//nl, .true.)
      call judge('pendulum', 'x', [0.9589743_wp, 0.4280631_wp, -0.5729016_wp, -0.9803678_wp, -0.9999669_wp, -0.9244137_wp], &
         & [2, 3, 4, 5, 6, 7])
      call judge('pendulum', 'y', [-0.28306_wp, -0.9037385_wp, -0.8196209_wp, -0.1965249_wp, -0.0085214_wp, -0.3810554_wp], &
         & [2, 3, 4, 5, 6, 7])
   end subroutine check_pendulum

   !> The slider-crank of the paper with the rod of 6 mm, two turns: the deflection, relative to the largest one.
   subroutine check_crank()
      real(wp) :: table(7, 839)
      integer :: i
      call read_columns('reference/slider_crank_6mm.csv', table)
      call run_scene('slider-crank', '*MATERIAL, NAME=steel, YOUNG=2.0e11, DENSITY=7870'//nl// &
         & '*SECTION, NAME=wire, SHAPE=CIRCLE, DIAMETER=6e-3'//nl//'*RIGID BODY, NAME=crank, MASS=0'//nl//' tip, 0.15, 0'//nl// &
         & '*BEAM, NAME=rod, MATERIAL=steel, SECTION=wire, LENGTH=0.3, X=0.15'//nl// &
         & '*POINT MASS, NAME=slider, MASS=0.033375, X=0.45'//nl//'*JOINT, NAME=bearing, TYPE=REVOLUTE'//nl// &
         & ' crank.origin, ground.origin'//nl//'*JOINT, NAME=crank-pin, TYPE=REVOLUTE'//nl//' crank.tip, rod.start'//nl// &
         & '*JOINT, NAME=slider-pin, TYPE=REVOLUTE'//nl//' rod.end, slider'//nl//'*JOINT, NAME=guide, TYPE=POINT ON LINE'//nl// &
         & ' slider, ground.origin'//nl//'*DRIVER, NAME=motor, TYPE=ANGLE, BODY=crank'//nl//' 150*t'//nl// &
         & '*DYNAMICS, END=2*2*pi/150, OUTPUTS=838'//nl//'*OUTPUT'//nl//' w = deflection(rod.middle)/length(rod)'//nl)
      call judge('slider-crank', 'w', table(3, :), [(i, i=1, 839)])
   end subroutine check_crank

   !> A crank that is run up drives a strip of aluminium, 1.6 mm thick, and a rocker.
   subroutine check_four_bar()
      call run_scene('four-bar', '*PARAMETER'//nl//' speed = 20, rise = 0.2'//nl// &
         & '*MATERIAL, NAME=aluminium, YOUNG=7.1e10, DENSITY=2770'//nl// &
         & '*SECTION, NAME=stout, SHAPE=RECTANGLE, WIDTH=0.02, HEIGHT=0.02'//nl// &
         & '*SECTION, NAME=strip, SHAPE=RECTANGLE, WIDTH=0.02, HEIGHT=0.0016'//nl//'*GROUND'//nl//' pivot, 0.254, 0'//nl// &
         & '*RIGID BODY, NAME=crank, MASS=0.1, INERTIA=1e-4, ANGLE=0'//nl//' tip, 0.108, 0'//nl// &
         & '*BEAM, NAME=coupler, MATERIAL=aluminium, SECTION=strip, LENGTH=0.2794, X=0.108, ANGLE=1.1'//nl// &
         & '*BEAM, NAME=rocker, MATERIAL=aluminium, SECTION=stout, LENGTH=0.2705, X=0.254, ANGLE=1.7'//nl// &
         & '*JOINT, NAME=main, TYPE=REVOLUTE'//nl//' crank.origin, ground.origin'//nl//'*JOINT, NAME=crank-pin, TYPE=REVOLUTE'// &
         & nl//' coupler.start, crank.tip'//nl//'*JOINT, NAME=rocker-pin, TYPE=REVOLUTE'//nl//' coupler.end, rocker.end'//nl// &
         & '*JOINT, NAME=pivot, TYPE=REVOLUTE'//nl//' rocker.start, ground.pivot'//nl// &
         & '*DRIVER, NAME=motor, TYPE=ANGLE, BODY=crank'//nl//' speed*(rise*(min(t/rise, 1)**6 - 3*min(t/rise, 1)**5'// &
         & ' + 2.5*min(t/rise, 1)**4) + max(t - rise, 0))'//nl//'*DYNAMICS, END=rise + 2*pi/speed, OUTPUTS=400'//nl// &
         & '*OUTPUT'//nl//' w = deflection(coupler.middle), x = x(rocker.end)'//nl)
      call judge('four-bar', 'w', [-2.0736905e-4_wp, 4.4992844e-4_wp, 3.3558291e-4_wp, 1.2406971e-4_wp, 1.5892878e-4_wp, &
         & -2.6255586e-4_wp, -2.1393482e-4_wp, 4.3378407e-4_wp], [81, 161, 201, 241, 281, 321, 361, 401])
      call judge('four-bar', 'x', [0.25393437_wp, 0.16998885_wp, 0.079758804_wp, 0.042759334_wp, 0.055581488_wp, 0.18657042_wp, &
         & 0.27412269_wp, 0.18226012_wp], [81, 161, 201, 241, 281, 321, 361, 401])
   end subroutine check_four_bar

   !> A mass of half that of the beam crosses it on pins at a constant speed, from rest under its weight: 24 modes of the straight
   !> beam with the inertia of the mass along its path.
   subroutine check_moving_mass()
      integer :: i
      call run_scene('moving mass', unit_stuff//bar//pin//roller//'*POINT MASS, NAME=car, MASS=0.5'//nl//'*GRAVITY, Y=-0.1'//nl// &
         & '*ASSEMBLY, INITIAL DEFLECTIONS=STATIC'//nl//'*JOINT, NAME=rail, TYPE=SLIDING'//nl//' car, bar.start'//nl// &
         & '*DRIVER, NAME=motor, TYPE=X, POINT=car'//nl//' t'//nl//'*DYNAMICS, END=0.96, OUTPUTS=12'//nl//'*OUTPUT'//nl// &
         & ' sag = 10*y(bar.middle), car = 10*y(car)'//nl, .true.)
      call judge('moving mass', 'sag', [-0.0130208_wp, -0.0131979_wp, -0.014613_wp, -0.0176332_wp, -0.0213355_wp, -0.0255182_wp, &
         & -0.0291915_wp, -0.0316336_wp, -0.0321937_wp, -0.0303233_wp, -0.0252535_wp, -0.0172552_wp, -0.0075547_wp], [(i, i=1, 13)])
      call judge('moving mass', 'car', [-0.0035932_wp, -0.0077836_wp, -0.012717_wp, -0.0187761_wp, -0.0245606_wp, -0.0291578_wp, &
         & -0.0312484_wp, -0.029885_wp, -0.0245368_wp, -0.0159864_wp, -0.0064505_wp, -0.0010242_wp], [(i, i=2, 13)])
   end subroutine check_moving_mass

   !> An arm of two slender links, moved by its shoulder and its elbow.
   subroutine check_arm()
      character(*), parameter :: smooth = '*(t - sin(2*pi*t)/(2*pi))'
      call run_scene('arm', unit_stuff//'*BEAM, NAME=one, MATERIAL=stuff, SECTION=bar, LENGTH=1'//nl// &
         & '*BEAM, NAME=two, MATERIAL=stuff, SECTION=bar, LENGTH=1, X=1'//nl//'*JOINT, NAME=shoulder, TYPE=REVOLUTE'//nl// &
         & ' one.start, ground.origin'//nl//'*JOINT, NAME=elbow, TYPE=REVOLUTE'//nl//' two.start, one.end'//nl// &
         & '*DRIVER, NAME=first, TYPE=ANGLE, JOINT=shoulder'//nl//' 0.8'//smooth//nl//'*DRIVER, NAME=second, TYPE=ANGLE, '// &
         & 'JOINT=elbow'//nl//' 1.2'//smooth//nl//'*DYNAMICS, END=1.2, OUTPUTS=12'//nl//'*OUTPUT'//nl// &
         & ' bend = y(one.end), x = x(two.end), y = y(two.end)'//nl)
      call judge('arm', 'bend', [-0.0167355_wp, -0.0688764_wp, -0.0651268_wp, 0.0472963_wp], [4, 7, 10, 13])
      call judge('arm', 'x', [1.9975497_wp, 1.9379633_wp, 1.8374178_wp, 1.7566795_wp], [4, 7, 10, 13])
      call judge('arm', 'y', [0.0028312_wp, 0.0657997_wp, 0.2752854_wp, 0.6222074_wp], [4, 7, 10, 13])
   end subroutine check_arm

   !> A motor turns a wheel with a beam on it by a belt, to and fro.
   subroutine check_belt()
      call run_scene('belt', unit_stuff//bar//'*GROUND'//nl//' motor, -0.5, 0'//nl// &
         & '*RIGID BODY, NAME=small, MASS=1, INERTIA=0.05, X=-0.5'//nl//'*RIGID BODY, NAME=large, MASS=1, INERTIA=0.2'//nl// &
         & '*JOINT, NAME=shaft, TYPE=REVOLUTE'//nl//' small.origin, ground.motor'//nl//'*JOINT, NAME=axle, TYPE=REVOLUTE'//nl// &
         & ' large.origin, ground.origin'//nl//'*JOINT, NAME=clamp, TYPE=WELD, TURN=0'//nl//' bar.start, large.origin'//nl// &
         & '*JOINT, NAME=belt, TYPE=BELT, FIRST RADIUS=0.1, SECOND RADIUS=0.2'//nl//' small.origin, large.origin'//nl// &
         & '*TORQUE, NAME=motor, POINT=small.origin'//nl//' 0.2*sin(2*pi*t/1.2)'//nl//'*DYNAMICS, END=1.2, OUTPUTS=12'//nl// &
         & '*OUTPUT'//nl//' y = y(bar.end), wheel = angle(large)'//nl)
      call judge('belt', 'y', [-0.0010821_wp, 0.0173377_wp, 0.1114306_wp, 0.2087472_wp], [4, 7, 10, 13])
      call judge('belt', 'wheel', [0.0194416_wp, 0.0909_wp, 0.1146037_wp, 0.071122_wp], [4, 7, 10, 13])
   end subroutine check_belt

   !> Runs a scene; none is warned of, but for functions whose lack is told as some thousandths where that is allowed.
   subroutine run_scene(name, text, told)
      character(*), intent(in) :: name, text
      logical, intent(in), optional :: told
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      logical :: quiet
      call run_text(text, trim(results), report, error)
      call check_no_error(error, name)
      if (allocated(error)) error stop 1
      quiet = index(report, 'warning') == 0
      if (present(told)) quiet = quiet .or. index(report, 'all of its shape') > 0 .and. index(report, '; about 0.') > 0
      call check(quiet, name//': no warning: '//report)
   end subroutine run_scene

   !> Samples of a channel against others, relative to the largest of these.
   subroutine judge(name, channel_name, truth, samples)
      character(*), intent(in) :: name, channel_name
      real(wp), intent(in) :: truth(:)
      !> Without these the last one
      integer, intent(in), optional :: samples(:)
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: values(:)
      real(wp) :: off
      call reader%open(trim(results), error)
      call check_no_error(error, name)
      allocate (values, source=channel(reader, channel_name))
      if (present(samples)) then
         off = maxval(abs(values(samples) - truth))/maxval(abs(truth))
      else
         off = abs(values(size(values)) - truth(1))/abs(truth(1))
      end if
      print '(4a,es10.2)', name, ', ', channel_name, ':', off
      call check(off <= 1.0e-2_wp, name//': '//channel_name//' is right')
      call reader%close()
   end subroutine judge

   !> Frequencies of *MODES [rad/s].
   subroutine judge_frequencies(name, truth)
      character(*), intent(in) :: name
      real(wp), intent(in) :: truth(:)
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: found(:)
      call reader%open(trim(results), error)
      call check_no_error(error, name)
      call reader%read_numbers('/modes/modes/frequency', found, error)
      call check_no_error(error, name//': frequencies')
      if (allocated(error)) return
      print '(2a,*(es10.2))', name, ', frequencies:', found(:size(truth))/truth - 1
      call check(maxval(abs(found(:size(truth))/truth - 1)) <= 1.0e-2_wp, name//': frequencies are right')
      call reader%close()
   end subroutine judge_frequencies

end program test_textbook
