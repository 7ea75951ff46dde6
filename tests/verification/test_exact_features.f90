!> Exact beams with shear, with sections that change, with curvature of their own, heated and stretched at first, against values of
!> independent programs (Ritz and collocation of high degree) and closed forms. Usage, in tests/: test_exact_features RESULT_FILE
program test_exact_features
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_commands_run, only: run_deck
   use limber_output_history_reader, only: history_reader_type
   use runs, only: change_deck, channel
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   character(*), parameter :: nl = new_line('a')
   character(*), parameter :: wall = '*JOINT, NAME=wall, TYPE=WELD, TURN=0'//nl//' bar.start, ground.origin'//nl
   character(*), parameter :: pins = '*JOINT, NAME=pin, TYPE=REVOLUTE'//nl//' bar.start, ground.origin'//nl// &
      & '*JOINT, NAME=roller, TYPE=POINT ON LINE'//nl//' bar.end, ground.far'//nl
   character(*), parameter :: other_wall = '*JOINT, NAME=other, TYPE=WELD, TURN=0'//nl//' bar.end, ground.far'//nl
   character(*), parameter :: steel = '*MATERIAL, NAME=stuff, YOUNG=2.1e11, DENSITY=7850'//nl
   character(*), parameter :: aluminium = '*MATERIAL, NAME=stuff, YOUNG=7e10, DENSITY=2700, POISSON=0.33'//nl
   character(*), parameter :: modes = '*MODES, NAME=modes, NUMBER=3'//nl
   real(wp), parameter :: pi = acos(-1.0_wp)
   character(256) :: results

   call get_command_argument(1, results)
   call check_timoshenko()
   call check_short()
   call check_taper()
   call check_rotation()
   call check_step()
   call check_thick_and_thin()
   call check_arc()
   call check_hooks()
   call check_heat()
   call check_tension()
   call check_twins()
   call check_refusals()
   call finish()

contains

   !> A rectangular section.
   function rectangle(name, width, height) result(text)
      character(*), intent(in) :: name, width, height
      character(:), allocatable :: text
      text = '*SECTION, NAME='//name//', SHAPE=RECTANGLE, WIDTH='//width//', HEIGHT='//height//nl
   end function rectangle

   !> Runs the bar in a scene.
   subroutine run_bar(sections, beam, scene, reader, report, error, model)
      character(*), intent(in) :: sections, beam, scene
      type(history_reader_type), intent(out) :: reader
      character(:), allocatable, intent(out) :: report
      type(error_type), allocatable, intent(out) :: error
      !> In place of EXACT
      character(*), intent(in), optional :: model
      character(1500) :: new(4)
      new(1) = sections
      new(2) = 'LENGTH='//beam
      new(3) = scene
      new(4) = 'GEOMETRIC=EXACT'
      if (present(model)) new(4) = 'GEOMETRIC='//model
      call change_deck('verification/exact_features.inp', trim(results)//'.inp', [character(15) :: '** sections', 'LENGTH=', &
         & '** scene', 'GEOMETRIC=EXACT'], new)
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
      if (.not. allocated(error)) call reader%open(trim(results), error)
   end subroutine run_bar

   !> First frequencies of the bar in a scene against others.
   subroutine check_modes(sections, beam, scene, omega, tolerance, what)
      character(*), intent(in) :: sections, beam, scene, what
      real(wp), intent(in) :: omega(:), tolerance
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp), allocatable :: frequency(:)
      call run_bar(sections, beam, scene//modes, reader, report, error)
      call check_no_error(error, what)
      if (allocated(error)) return
      call check(index(report, 'warning') == 0, what//': no warning: '//report)
      call reader%read_numbers('/modes/modes/frequency', frequency, error)
      call check_no_error(error, what//': frequencies')
      if (allocated(error)) return
      call check(maxval(abs(frequency(:size(omega))/omega - 1)) <= tolerance, what)
      call reader%close()
   end subroutine check_modes

   !> Last sample of a channel.
   real(wp) function last(reader, name)
      type(history_reader_type), intent(inout) :: reader
      character(*), intent(in) :: name
      real(wp), allocatable :: values(:)
      allocate (values, source=channel(reader, name))
      last = values(size(values))
   end function last

   !> Thick bars, L/h = 10 and 5: frequencies, and the deflection of the tip, F L^3/(3 E I) + F L/(kappa G A), with six functions of
   !> the angle and as many of the shear.
   subroutine check_timoshenko()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: section, report
      real(wp), parameter :: ei = 2.1e11_wp*0.05_wp*0.1_wp**3/12, ga = 5*2.1e11_wp*0.005_wp/(6*2.6_wp)
      character(3), parameter :: length(2) = ['1  ', '0.5']
      integer :: i
      section = steel//rectangle('bar', '0.05', '0.1')
      call check_modes(section, '1, FUNCTIONS=6, STRAIN FUNCTIONS=0, SHEAR=YES', wall, &
         & [520.84064172_wp, 3121.5777654_wp, 8210.2261331_wp], 1.0e-4_wp, 'Timoshenko cantilever, L/h = 10')
      call check_modes(section, '0.5, FUNCTIONS=6, STRAIN FUNCTIONS=0, SHEAR=YES', wall, &
         & [2036.4368536_wp, 10967.419355_wp], 1.0e-4_wp, 'Timoshenko cantilever, L/h = 5')
      call check_modes(section, '1, FUNCTIONS=6, STRAIN FUNCTIONS=0, SHEAR=YES', '*GROUND'//nl//' far, 1, 0'//nl//pins, &
         & [1449.4077418_wp, 5538.7675423_wp, 11669.157403_wp], 1.0e-4_wp, 'Timoshenko beam on pins, L/h = 10')
      call check_modes(section, '0.5, FUNCTIONS=6, STRAIN FUNCTIONS=0, SHEAR=YES', '*GROUND'//nl//' far, 0.5, 0'//nl//pins, &
         & [5538.7675423_wp, 19210.913148_wp, 36704.816543_wp], 1.0e-4_wp, 'Timoshenko beam on pins, L/h = 5')
      do i = 1, 2
         call run_bar(section, trim(length(i))//', FUNCTIONS=6, SHEAR=YES', wall//'*FORCE, NAME=load, POINT=bar.end'//nl// &
            & ' 0, 100'//nl//'*STATICS, INCREMENTS=1'//nl//'*OUTPUT'//nl//' y = y(bar.end), v = shear_force(bar.middle), '// &
            & 'm = bending_moment(bar.start), held = moment(wall)'//nl, reader, report, error)
         call check_no_error(error, 'deflection with shear')
         if (allocated(error)) return
         call check_close(last(reader, 'y')/(100*0.5_wp**(3*(i - 1))/(3*ei) + 100*0.5_wp**(i - 1)/ga), 1.0_wp, 1.0e-8_wp, &
            & 'deflection with shear')
         call check_close(last(reader, 'v'), 100.0_wp, 1.0e-4_wp, 'shear force')
         call check_close(abs(last(reader, 'm')), 100*0.5_wp**(i - 1), 1.0e-4_wp, 'bending moment with shear')
         call check_close(abs(last(reader, 'm')), abs(last(reader, 'held')), 1.0e-6_wp, 'moment at the wall with shear')
         call reader%close()
      end do
   end subroutine check_timoshenko

   !> A short bar without shear is warned of with the remedy, a slender one is not.
   subroutine check_short()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      character(3), parameter :: length(3) = ['0.6', '1  ', '3  ']
      integer :: i
      do i = 1, 3
         call run_bar(steel//rectangle('bar', '0.05', '0.1'), trim(length(i)), '*GROUND'//nl//' far, '//trim(length(i))//', 0'// &
            & nl//pins//modes, reader, report, error)
         call check_no_error(error, 'a bar without shear')
         if (allocated(error)) return
         call check((index(report, 'is short') > 0) .eqv. i < 3, 'a short bar is warned of: '//report)
         call check((index(report, 'SHEAR=YES') > 0) .eqv. i < 3, 'the remedy of a short bar')
         call reader%close()
      end do
   end subroutine check_short

   !> Cantilevers whose height is halved towards the tip, slender and thick; a blunt cone by statics.
   subroutine check_taper()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp), parameter :: force = 100.0_wp, young = 2.1e11_wp, d = 0.04_wp
      call check_modes(aluminium//rectangle('bar', '0.04', '0.03')//rectangle('tip', '0.04', '0.015'), &
         & '1, FUNCTIONS=8, STRAIN FUNCTIONS=0, END SECTION=tip', wall, [168.61306288_wp, 807.71528427_wp, 2084.1829672_wp], &
         & 1.0e-5_wp, 'tapered cantilever')
      call check_modes(aluminium//rectangle('bar', '0.04', '0.1')//rectangle('tip', '0.04', '0.05'), &
         & '0.6, FUNCTIONS=6, STRAIN FUNCTIONS=0, SHEAR=YES, END SECTION=tip', wall, &
         & [1533.3430458_wp, 6872.3518692_wp, 16200.879454_wp], 1.0e-4_wp, 'tapered Timoshenko cantilever')
      ! Diameter d (1 - s/2), L = 1: y = 64 F/(pi E d^4) times the integral of (1 - s)^2/(1 - s/2)^4, which is 2/3
      call run_bar(steel//'*SECTION, NAME=bar, SHAPE=CIRCLE, DIAMETER=0.04'//nl// &
         & '*SECTION, NAME=tip, SHAPE=CIRCLE, DIAMETER=0.02'//nl, '1, FUNCTIONS=8, STRAIN FUNCTIONS=0, END SECTION=tip', wall// &
         & '*FORCE, NAME=load, POINT=bar.end'//nl//' 0, 1e-3*100'//nl//'*STATICS, INCREMENTS=1'//nl//'*OUTPUT'//nl// &
         & ' y = y(bar.end), top = stress_top(bar.middle)'//nl, reader, report, error)
      call check_no_error(error, 'a cone')
      if (allocated(error)) return
      call check_close(last(reader, 'y')*pi*young*d**4/(64*1.0e-3_wp*force), 2.0_wp/3, 1.0e-6_wp, 'deflection of a cone')
      call check_close(abs(last(reader, 'top'))*pi*(0.75_wp*d)**3/(32*1.0e-3_wp*force*0.5_wp), 1.0_wp, 1.0e-6_wp, &
         & 'stress in the middle of a cone')
      call reader%close()
   end subroutine check_taper

   !> The tapered cantilever rotates: E I = rho A = 1 at the start, L = 1; frequencies in its plane.
   subroutine check_rotation()
      character(:), allocatable :: section
      section = '*MATERIAL, NAME=stuff, YOUNG=12e9, DENSITY=1000'//nl// &
         & rectangle('bar', '1', '0.001')//rectangle('tip', '1', '0.0005')
      call check_modes(section, '1, FUNCTIONS=8, STRAIN FUNCTIONS=0, END SECTION=tip', turning('1'), &
         & [3.8591605766_wp, 18.44692153_wp, 47.406737672_wp], 1.0e-4_wp, 'rotating taper, 1')
      call check_modes(section, '1, FUNCTIONS=12, STRAIN FUNCTIONS=0, END SECTION=tip', turning('12'), &
         & [6.1213839677_wp, 31.905635579_wp, 64.415442774_wp], 1.0e-4_wp, 'rotating taper, 12')
   end subroutine check_rotation

   !> A hub that turns steadily.
   function turning(speed) result(text)
      character(*), intent(in) :: speed
      character(:), allocatable :: text
      text = '*JOINT, NAME=pin, TYPE=REVOLUTE'//nl//' bar.start, ground.origin'//nl// &
         & '*DRIVER, NAME=hub, TYPE=ANGLE, BODY=bar'//nl//' 0'//nl//'*STATICS, ROTATION='//speed//', INCREMENTS=5'//nl
   end function turning

   !> A cantilever that is half as high from its middle on: zeros of the determinant of both halves.
   subroutine check_step()
      call check_modes(steel//rectangle('bar', '0.02', '0.02')//rectangle('thin', '0.02', '0.01'), &
         & '1, FUNCTIONS=10, STRAIN FUNCTIONS=0'//nl//'*PROFILE'//nl//' 0.5, thin', wall, &
         & [124.8560029_wp, 443.9817885_wp, 1316.76613_wp], 1.0e-4_wp, 'stepped cantilever')
   end subroutine check_step

   !> Three stretches, tapered and stepped, by statics: stretching F int ds/(E A), and bending; the middle lies in the taper.
   subroutine check_thick_and_thin()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp), parameter :: young = 2.1e11_wp, width = 0.02_wp
      ! Heights 0.04 to s = 0.25, from there to 0.75 from 0.04 to 0.02, then 0.01
      call run_bar(steel//rectangle('bar', '0.02', '0.04')//rectangle('thin', '0.02', '0.02')//rectangle('tip', '0.02', '0.01'), &
         & '1, FUNCTIONS=8, STRAIN FUNCTIONS=3'//nl//'*PROFILE'//nl//' 0.25, bar, thin'//nl//' 0.75, tip', wall// &
         & '*FORCE, NAME=load, POINT=bar.end'//nl//' 1000, 0'//nl//'*STATICS, INCREMENTS=1'//nl//'*OUTPUT'//nl// &
         & ' x = x(bar.end), top = stress_top(bar.middle), foot = stress_top(bar.start)'//nl, reader, report, error)
      call check_no_error(error, 'three stretches')
      if (allocated(error)) return
      call check_close((last(reader, 'x') - 1)*young*width/(1000*(0.25_wp/0.04_wp + 0.5_wp*log(2.0_wp)/0.02_wp &
         & + 0.25_wp/0.01_wp)), 1.0_wp, 1.0e-6_wp, 'stretching of three stretches')
      call check_close(last(reader, 'top')*width*0.03_wp/1000, 1.0_wp, 1.0e-6_wp, 'stress in the taper')
      call check_close(last(reader, 'foot')*width*0.04_wp/1000, 1.0_wp, 1.0e-6_wp, 'stress at the wall')
      call reader%close()
   end subroutine check_thick_and_thin

   !> Quarters of a circle of radius 0.5, clamped and free, and clamped at both ends, without the terms of (h/R)^2, which are 1e-4;
   !> with shear; its place, drawn and undeformed.
   subroutine check_arc()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: section, report
      section = steel//rectangle('bar', '0.01', '0.01')
      call check_modes(section, 'pi/4, CURVATURE=2, FUNCTIONS=8, STRAIN FUNCTIONS=3', wall, &
         & [89.474927286_wp, 431.40503524_wp, 1362.3558906_wp], 1.0e-4_wp, 'arc, clamped and free')
      call check_modes(section, 'pi/4, CURVATURE=-2, FUNCTIONS=9, STRAIN FUNCTIONS=3', '*GROUND'//nl//' far, 0.5, -0.5'//nl// &
         & wall//other_wall, [1350.8429193_wp, 2562.0682464_wp, 4668.2505443_wp], 1.5e-4_wp, 'arc, clamped at both ends')
      call check_modes(section, 'pi/4, CURVATURE=2, FUNCTIONS=6, STRAIN FUNCTIONS=2, SHEAR=YES', wall, &
         & [89.463495444_wp, 431.02139249_wp, 1359.4146969_wp], 1.0e-4_wp, 'arc with shear')
      ! A couple C unrolls it: curvature 2 - C/(E I_c), eq. (2.54), E I = 175
      call run_bar(section, 'pi/4, CURVATURE=2, FUNCTIONS=4, STRAIN FUNCTIONS=0', wall//'*TORQUE, NAME=load, POINT=bar.end'//nl// &
         & ' -350.0210015*t'//nl//'*STATICS, INCREMENTS=4'//nl//'*OUTPUT'//nl//' x = x(bar.end), y = y(bar.end), '// &
         & 'm = bending_moment(bar.middle), turn = rotation(bar.end), u = u1(bar.end)'//nl, reader, report, error)
      call check_no_error(error, 'an arc unrolls')
      if (allocated(error)) return
      call check_close(last(reader, 'x'), pi/4, 1.0e-8_wp, 'x of an arc that is straight')
      call check_close(last(reader, 'y'), 0.0_wp, 1.0e-8_wp, 'y of an arc that is straight')
      call check_close(last(reader, 'm'), -350.0210015_wp, 1.0e-5_wp, 'moment in an arc')
      call check_close(last(reader, 'turn'), -pi/2, 1.0e-8_wp, 'rotation of the end of an arc')
      call reader%close()
   end subroutine check_arc

   !> Stresses of crane hooks, half circles of the radius R whose force F goes through their centre, by Winkler and Bach: with the
   !> radius r_n of the neutral fibre, e = R - r_n, M = -F R, sigma = F/A + F R (r_n - r)/(A e r). Thick ones are told what their
   !> deflection lacks, and those whose shape is not known what their stresses do.
   subroutine check_hooks()
      real(wp), parameter :: h = 0.05_wp, b = 0.02_wp, r = 0.1_wp
      character(:), allocatable :: round, tube, general
      round = '*SECTION, NAME=bar, SHAPE=CIRCLE, DIAMETER=0.05'//nl
      tube = '*SECTION, NAME=bar, SHAPE=TUBE, DIAMETER=0.05, THICKNESS=0.005'//nl
      general = '*SECTION, NAME=bar, SHAPE=GENERAL, AREA=1e-3, INERTIA=2.0833333e-7, TOP=0.025'//nl
      call check_hook(rectangle('bar', '0.02', '0.05'), '10', h*b, h/log((r + h/2)/(r - h/2)), 1.0e-6_wp, 'rectangle')
      call check_hook(rectangle('bar', '0.02', '0.05'), '-10', h*b, h/log((r + h/2)/(r - h/2)), 1.0e-6_wp, &
         & 'rectangle, to the right')
      call check_hook(round, '10', pi*h**2/4, 0.5_wp*(r + sqrt(r**2 - h**2/4)), 1.0e-6_wp, 'circle')
      call check_hook(tube, '10', pi*(h**2 - 0.04_wp**2)/4, (h**2 - 0.04_wp**2)/8/(sqrt(r**2 - 0.02_wp**2) &
         & - sqrt(r**2 - h**2/4)), 1.0e-6_wp, 'tube')
      call check_hook(general, '10', h*b, h/log((r + h/2)/(r - h/2)), 0.05_wp, 'general', 'stresses by about 6.2 %')
   end subroutine check_hooks

   subroutine check_hook(section, curvature, area, neutral, tolerance, what, told)
      character(*), intent(in) :: section, curvature, what
      !> Area; radius of the neutral fibre; relative tolerance of stresses
      real(wp), intent(in) :: area, neutral, tolerance
      !> What is told beside the deflection
      character(*), intent(in), optional :: told
      real(wp), parameter :: r = 0.1_wp, half = 0.025_wp, force = 0.1_wp
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp) :: true(2), shown(2)
      call run_bar(steel//section, 'pi/10, CURVATURE='//curvature, wall//'*FORCE, NAME=load, POINT=bar.end'//nl// &
         & ' 0, '//trim(merge('0.1 ', '-0.1', curvature == '10'))//nl//'*STATICS, INCREMENTS=1'//nl//'*OUTPUT'//nl// &
         & ' top = stress_top(bar.middle), bottom = stress_bottom(bar.middle)'//nl, reader, report, error)
      call check_no_error(error, 'hook: '//what)
      if (allocated(error)) return
      ! Inner and outer fibre
      true = [r - half, r + half]
      true = force/area*(1 + r*(neutral - true)/((r - neutral)*true))
      shown = [last(reader, 'top'), last(reader, 'bottom')]
      if (curvature /= '10') shown = shown(2:1:-1)
      call check(maxval(abs(shown/true - 1)) < tolerance, 'stresses of a hook: '//what)
      call check(index(report, 'is thick beside its radius of curvature: deflections may err') > 0, 'a hook is thick: '//report)
      if (present(told)) call check(index(report, told) > 0, told//' is told: '//report)
      if (.not. present(told)) call check(index(report, 'stresses by') == 0, 'stresses of a known shape are right: '//report)
      call reader%close()
   end subroutine check_hook

   !> A heated bar between walls, below its buckling load; a bar that heat bends, without stress.
   subroutine check_heat()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: section, report
      character(14), parameter :: heat(4) = ['-1.7879718118 ', '1.7879718118  ', '3.2183492612  ', '3.5401841873  ']
      real(wp), parameter :: omega(2, 4) = reshape([250.02889788_wp, 630.39511887_wp, 146.53868089_wp, 493.8978575_wp, &
         & 66.064396894_wp, 426.29820067_wp, 20.934110266_wp, 409.46013948_wp], [2, 4])
      integer :: i
      section = aluminium//rectangle('bar', '0.02', '0.004')
      do i = 1, 4
         call check_modes(section, '0.8, FUNCTIONS=8, THERMAL STRAIN=2.3e-5*('//trim(heat(i))//')', '*GROUND'//nl// &
            & ' far, 0.8, 0'//nl//wall//other_wall//'*STATICS, INCREMENTS=1'//nl, omega(:, i), 1.0e-4_wp, 'heated bar')
      end do
      call run_bar(section, '0.8, FUNCTIONS=4, THERMAL CURVATURE=-0.115', wall//'*STATICS, INCREMENTS=1'//nl//'*OUTPUT'//nl// &
         & ' x = x(bar.end), y = y(bar.end), m = bending_moment(bar.start), energy = potential_energy(system)'//nl, reader, &
         & report, error)
      call check_no_error(error, 'a bar that heat bends')
      if (allocated(error)) return
      call check_close(last(reader, 'x'), 0.79887194417_wp, 1.0e-9_wp, 'x of a bar that heat bends')
      call check_close(last(reader, 'y'), -0.036774051055_wp, 1.0e-9_wp, 'y of a bar that heat bends')
      call check_close(last(reader, 'm'), 0.0_wp, 1.0e-7_wp, 'no moment in a bar that heat bends')
      call check_close(last(reader, 'energy'), 0.0_wp, 1.0e-9_wp, 'no strain energy in a bar that heat bends')
      call reader%close()
   end subroutine check_heat

   !> A string: pinned at both ends at its length, with a tension T = 1000 of its own: pi sqrt(T + pi^2), E I = rho A = L = 1.
   subroutine check_tension()
      call check_modes('*MATERIAL, NAME=stuff, YOUNG=1e8, DENSITY=1'//nl// &
         & '*SECTION, NAME=bar, SHAPE=GENERAL, AREA=1, INERTIA=1e-8'//nl, '1, FUNCTIONS=6, PRETENSION=1000', &
         & '*GROUND'//nl//' far, 1, 0'//nl//'*JOINT, NAME=a, TYPE=REVOLUTE'//nl//' bar.start, ground.origin'//nl// &
         & '*JOINT, NAME=b, TYPE=REVOLUTE'//nl//' bar.end, ground.far'//nl//'*STATICS, INCREMENTS=1'//nl, &
         & pi*[sqrt(1000 + pi**2), 2*sqrt(1000 + 4*pi**2)], 1.0e-4_wp, 'pretension')
   end subroutine check_tension

   !> Two beams that differ in what exact ones only have do not share their functions.
   subroutine check_twins()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp), allocatable :: frequency(:)
      call run_bar(steel//rectangle('bar', '0.02', '0.02'), '1, FUNCTIONS=2, STRAIN FUNCTIONS=0'//nl// &
         & '*BEAM, NAME=richer, MATERIAL=stuff, SECTION=bar, GEOMETRIC=EXACT, LENGTH=1, FUNCTIONS=5, '// &
         & 'STRAIN FUNCTIONS=0', wall//'*JOINT, NAME=second, TYPE=WELD, TURN=0'//nl//' richer.start, ground.origin'//nl// &
         & '*MODES, NAME=modes, NUMBER=7'//nl, reader, report, error)
      call check_no_error(error, 'two beams')
      if (allocated(error)) return
      call reader%read_numbers('/modes/modes/frequency', frequency, error)
      call check_no_error(error, 'frequencies of two beams')
      if (.not. allocated(error)) call check(size(frequency) == 7, 'each beam has its own functions')
      call reader%close()
   end subroutine check_twins

   !> What cannot be is refused where it stands.
   subroutine check_refusals()
      character(:), allocatable :: bar
      bar = steel//rectangle('bar', '0.02', '0.02')
      call refused(bar, '1, SHEAR=YES', 'K_G', 'SHEAR is for GEOMETRIC=EXACT only')
      call refused(bar, '1, CURVATURE=1', 'LINEAR', 'CURVATURE is for GEOMETRIC=EXACT only')
      call refused(bar, '1'//nl//'*PROFILE'//nl//' 0.5, bar', 'LINEAR', '*PROFILE is for GEOMETRIC=EXACT only')
      call refused(bar, '1, CURVATURE=120', 'EXACT', 'reaches over the centre of its curvature')
      call refused(bar, '1, CURVATURE=1, SEGMENTS=2', 'EXACT', 'CURVATURE is not for a beam in SEGMENTS')
      call refused(bar, '1'//nl//'*PROFILE'//nl//' 1.5, bar', 'EXACT', 'sections of a beam change within it')
      call refused(bar, '1'//nl//'*PROFILE'//nl//' 0.5, none', 'EXACT', "no *SECTION named 'none'")
      call refused(bar//'*SECTION, NAME=tip, SHAPE=CIRCLE, DIAMETER=0.01'//nl, '1, END SECTION=tip', 'EXACT', 'cannot taper')
      call refused(bar, '1, STRAIN FUNCTIONS=0'//nl//'*GROUND'//nl//' far, 1, 0'//nl//'*JOINT, NAME=pin, TYPE=REVOLUTE'//nl// &
         & ' bar.end, ground.far'//nl, 'EXACT', "let beam 'bar' stretch, with STRAIN FUNCTIONS=1")
      call refused(bar, '1, STRAIN FUNCTIONS=0, THERMAL STRAIN=1e-4', 'EXACT', 'has no STRAIN FUNCTIONS')
      call refused(steel//'*SECTION, NAME=bar, SHAPE=GENERAL, AREA=1e-4, INERTIA=1e-8'//nl, '1, SHEAR=YES', 'EXACT', &
         & 'needs SHEAR FACTOR')
      call refused('*MATERIAL, NAME=stuff, YOUNG=2.1e11, DENSITY=7850, POISSON=0.7'//nl//rectangle('bar', '0.02', '0.02'), &
         & '1, SHEAR=YES', 'EXACT', "Poisson's ratio")
   end subroutine check_refusals

   !> A deck that must be refused, with a place and a text.
   subroutine refused(sections, beam, model, text)
      character(*), intent(in) :: sections, beam, model, text
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call run_bar(sections, beam, wall//modes, reader, report, error, model)
      call check(allocated(error), text//': refused')
      if (.not. allocated(error)) return
      call check(index(error%message, text) > 0, text//' is told: '//error%message)
      call check(index(error%message, '.inp:') > 0, text//': where')
   end subroutine refused

end program test_exact_features
