!> Convergence of exact beams: scenes with known answers by 6 and by 12 functions of the angle. With 12 the error is below 1e-4, and
!> it falls at least with the third power of their number, or below 1e-7. References: Ritz' method and collocation of high degree,
!> determinants, elliptic integrals, finite elements. Usage, in tests/: test_convergence RESULT_FILE
program test_convergence
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use limber_output_history_reader, only: history_reader_type
   use runs, only: channel, run_text, read_columns
   use testing, only: check, check_no_error, finish
   implicit none
   character(*), parameter :: nl = new_line('a')
   character(*), parameter :: unit_bar = '*MATERIAL, NAME=stuff, YOUNG=1e6, DENSITY=1'//nl// &
      & '*SECTION, NAME=bar, SHAPE=GENERAL, AREA=1, INERTIA=1e-6'//nl//'*BEAM, NAME=bar, MATERIAL=stuff, SECTION=bar, LENGTH=1'
   character(*), parameter :: steel = '*MATERIAL, NAME=stuff, YOUNG=2.1e11, DENSITY=7850, POISSON=0.3'//nl
   !> A square of 0.01 without the curvature of eq. (2.54), as the reference
   character(*), parameter :: thin = '*SECTION, NAME=bar, SHAPE=GENERAL, AREA=1e-4, INERTIA=8.33333333333333e-10'//nl
   character(*), parameter :: aluminium = '*MATERIAL, NAME=stuff, YOUNG=7e10, DENSITY=2700, POISSON=0.33'//nl
   character(*), parameter :: beam = '*BEAM, NAME=bar, MATERIAL=stuff, SECTION=bar, LENGTH='
   character(*), parameter :: wall = nl//'*JOINT, NAME=wall, TYPE=WELD, TURN=0'//nl//' bar.start, ground.origin'//nl
   character(*), parameter :: other = '*JOINT, NAME=other, TYPE=WELD, TURN=0'//nl//' bar.end, ground.far'//nl
   character(*), parameter :: no_stretch = ', STRAIN FUNCTIONS=0', thick = ', SHEAR=YES'//no_stretch
   character(*), parameter :: modes = '*MODES, NAME=modes, NUMBER=3'//nl//'*OUTPUT'//nl//' x(bar.end)'//nl
   character(*), parameter :: stop = '*STATICS, INCREMENTS=10, INSTABILITY=STOP'//nl//'*OUTPUT'//nl//' x = x(bar.end)'//nl
   !> Functions of the angle: few and many, and those of a bar on one hinge
   integer, parameter :: counts(5) = [6, 12, 1, 2, 40]
   real(wp), parameter :: enough = 1.0e-4_wp, rate = 3.0_wp, remains = 1.0e-7_wp
   character(256) :: results

   call get_command_argument(1, results)
   call check_modes()
   call check_hinged()
   call check_loads()
   call check_rods()
   call finish()

contains

   !> Frequencies: thick, tapered, stepped and curved bars, a heated one near its buckling load.
   subroutine check_modes()
      call judge_modes('Timoshenko cantilever, L/h = 10', steel//rectangle('bar', '0.05', '0.1')//beam//'1'//thick, &
         & wall, [520.84064172_wp, 3121.5777654_wp, 8210.2261331_wp])
      call judge_modes('Timoshenko cantilever, L/h = 5', steel//rectangle('bar', '0.05', '0.1')//beam//'0.5'//thick, &
         & wall, [2036.4368536_wp, 10967.419355_wp])
      call judge_modes('tapered cantilever', aluminium//rectangle('bar', '0.04', '0.03')//rectangle('tip', '0.04', '0.015')// &
         & beam//'1, END SECTION=tip'//no_stretch, wall, [168.61306288_wp, 807.71528427_wp, 2084.1829672_wp])
      call judge_modes('tapered Timoshenko cantilever', aluminium//rectangle('bar', '0.04', '0.1')// &
         & rectangle('tip', '0.04', '0.05')//beam//'0.6, END SECTION=tip'//thick, wall, &
         & [1533.3430458_wp, 6872.3518692_wp, 16200.879454_wp])
      call judge_modes('stepped cantilever', steel//rectangle('bar', '0.02', '0.02')//rectangle('thin', '0.02', '0.01')//beam// &
         & '1'//no_stretch, nl//'*PROFILE'//nl//' 0.5, thin'//wall, [124.8560029_wp, 443.9817885_wp, 1316.76613_wp])
      call judge_modes('arc', steel//thin//beam//'pi/4, CURVATURE=2, STRAIN FUNCTIONS=8', wall, &
         & [89.474927286_wp, 431.40503524_wp, 1362.3558906_wp])
      call judge_modes('arc between walls', steel//rectangle('bar', '0.01', '0.01')//beam// &
         & 'pi/4, CURVATURE=-2, STRAIN FUNCTIONS=4', nl//'*GROUND'//nl//' far, 0.5, -0.5'//wall//other, &
         & [1350.8429193_wp, 2562.0682464_wp, 4668.2505443_wp])
      call judge_modes('heated bar at 0.99 of its buckling load', aluminium//rectangle('bar', '0.02', '0.004')//beam// &
         & '0.8, THERMAL STRAIN=2.3e-5*3.5401841873', nl//'*GROUND'//nl//' far, 0.8, 0'//wall//other// &
         & '*STATICS, INCREMENTS=1'//nl, [20.934110266_wp, 409.46013948_wp])
   end subroutine check_modes

   !> A bar on one hinge, tan x = tanh x: one function of the angle for its first vibration, two for two, and forty, whose finite
   !> elements are many, tell the same. Before, the first function was spoilt at the hinge: one gave 24.5 for 15.4.
   subroutine check_hinged()
      real(wp), parameter :: truth(2) = [3.926602312048_wp, 7.068582745629_wp]**2, errors(3) = [1.0e-5_wp, 2.0e-5_wp, 1.0e-6_wp]
      character(*), parameter :: hinges(2) = [character(80) :: 'bar.start', 'bar.end']
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: found(:)
      integer :: i, k, n
      do i = 1, size(hinges)
         do k = 1, size(errors)
            call run('bar on a hinge', unit_bar//no_stretch, k + 2, nl//'*JOINT, NAME=hinge, TYPE=REVOLUTE'//nl//' '// &
               & trim(hinges(i))//', ground.origin'//nl//modes, reader)
            call reader%read_numbers('/modes/modes/frequency', found, error)
            call check_no_error(error, 'bar on a hinge: frequencies')
            if (allocated(error)) return
            n = min(k, 2)
            print '(a,i3,2es10.2)', 'bar on a hinge', counts(k + 2), found(2:n + 1)/truth(:n) - 1
            call check(maxval(abs(found(2:n + 1)/truth(:n) - 1)) <= errors(k), 'bar on a hinge: '//as_text(counts(k + 2))// &
               & ' functions')
            deallocate (found)
            call reader%close()
         end do
      end do
   end subroutine check_hinged

   !> Critical loads of columns, on which the load follows or not; large deflections.
   subroutine check_loads()
      call judge_load("Beck's column", '*FORCE, NAME=load, POINT=bar.end, FOLLOWER=YES'//nl//' -21*t, 0'//nl, 21.0_wp, &
         & 20.0509536189_wp)
      call judge_load("Leipholz' column", '*DISTRIBUTED LOAD, NAME=load, BODY=bar, FOLLOWER=YES'//nl//' -42, 0, t'//nl, 42.0_wp, &
         & 40.0537365153_wp)
      call judge_load("Euler's column, clamped and pinned", '*GROUND'//nl//' far, 1, 0'//nl// &
         & '*JOINT, NAME=roller, TYPE=POINT ON LINE'//nl//' bar.end, ground.far'//nl//'*FORCE, NAME=load, POINT=bar.end'//nl// &
         & ' -24*t, 0'//nl, 24.0_wp, 20.190728556426629_wp)
      call judge_place('follower force of 30', '*FORCE, NAME=load, POINT=bar.end, FOLLOWER=YES'//nl//' 0, 30*t'//nl// &
         & '*STATICS, INCREMENTS=30'//nl, 0.47614123713_wp, -0.20169084011_wp)
      ! P L^2/(E I) = 10 across, by elliptic integrals
      call judge_place('force of 10 across the tip', '*FORCE, NAME=load, POINT=bar.end'//nl//' 0, 10*t'//nl// &
         & '*STATICS, INCREMENTS=10'//nl, 0.44500440224625_wp, 0.8106091024889_wp)
   end subroutine check_loads

   !> The slider-crank of the paper with rods of 6 mm (two turns) and 3 mm (as it begins to buckle), finite elements of high order.
   subroutine check_rods()
      real(wp) :: table(7, 839)
      integer :: i
      call read_columns('reference/slider_crank_6mm.csv', table)
      call judge_rod('rod of 6 mm', '6e-3', '2*2*pi/150, OUTPUTS=838', table(3, :), [(i, i=1, 839)])
      call judge_rod('rod of 3 mm', '3e-3', '200/419*2*pi/150, OUTPUTS=200', [0.0495140032_wp, 0.0691877472_wp, 0.1376714248_wp, &
         & 0.1983608541_wp], [101, 121, 161, 201])
   end subroutine check_rods

   function rectangle(name, width, height) result(text)
      character(*), intent(in) :: name, width, height
      character(:), allocatable :: text
      text = '*SECTION, NAME='//name//', SHAPE=RECTANGLE, WIDTH='//width//', HEIGHT='//height//nl
   end function rectangle

   subroutine judge_modes(name, before, behind, truth)
      character(*), intent(in) :: name, before, behind
      real(wp), intent(in) :: truth(:)
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: found(:)
      real(wp) :: off(2)
      integer :: k
      do k = 1, 2
         call run(name, before, k, behind//modes, reader)
         call reader%read_numbers('/modes/modes/frequency', found, error)
         call check_no_error(error, name//': frequencies')
         if (allocated(error)) return
         off(k) = maxval(abs(found(:size(truth))/truth - 1))
         deallocate (found)
         call reader%close()
      end do
      call judge(name, off)
   end subroutine judge_modes

   !> The load at which a cantilever turns unstable.
   subroutine judge_load(name, scene, factor, truth)
      character(*), intent(in) :: name, scene
      !> The load at time 1, and the critical one
      real(wp), intent(in) :: factor, truth
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: time(:)
      real(wp) :: off(2)
      integer :: k
      do k = 1, 2
         call run(name, unit_bar//no_stretch, k, wall//scene//stop, reader)
         call reader%read_time(time, error)
         call check_no_error(error, name)
         off(k) = abs(factor*time(size(time))/truth - 1)
         deallocate (time)
         call reader%close()
      end do
      call judge(name, off)
   end subroutine judge_load

   !> The tip of a cantilever.
   subroutine judge_place(name, scene, x, y)
      character(*), intent(in) :: name, scene
      real(wp), intent(in) :: x, y
      type(history_reader_type) :: reader
      real(wp) :: off(2)
      integer :: k
      do k = 1, 2
         call run(name, unit_bar//no_stretch, k, wall//scene//'*OUTPUT'//nl//' x = x(bar.end), y = y(bar.end)'//nl, reader)
         off(k) = hypot(last(channel(reader, 'x')) - x, last(channel(reader, 'y')) - y)
         call reader%close()
      end do
      call judge(name, off)
   end subroutine judge_place

   pure real(wp) function last(values)
      real(wp), intent(in) :: values(:)
      last = values(size(values))
   end function last

   !> A slider-crank: deflections at some samples, relative to the largest.
   subroutine judge_rod(name, diameter, end, truth, samples)
      character(*), intent(in) :: name, diameter, end
      real(wp), intent(in) :: truth(:)
      integer, intent(in) :: samples(:)
      type(history_reader_type) :: reader
      real(wp), allocatable :: w(:)
      real(wp) :: off(2)
      integer :: k
      do k = 1, 2
         call run(name, '*MATERIAL, NAME=steel, YOUNG=2.0e11, DENSITY=7870'//nl// &
            & '*SECTION, NAME=wire, SHAPE=CIRCLE, DIAMETER='//diameter//nl//'*RIGID BODY, NAME=crank, MASS=0'//nl// &
            & ' tip, 0.15, 0'//nl//'*BEAM, NAME=bar, MATERIAL=steel, SECTION=wire, LENGTH=0.3, X=0.15, STRAIN FUNCTIONS=3', k, &
            & nl//'*POINT MASS, NAME=slider, MASS=0.033375, X=0.45'//nl//'*JOINT, NAME=bearing, TYPE=REVOLUTE'//nl// &
            & ' crank.origin, ground.origin'//nl//'*JOINT, NAME=crank-pin, TYPE=REVOLUTE'//nl//' crank.tip, bar.start'//nl// &
            & '*JOINT, NAME=slider-pin, TYPE=REVOLUTE'//nl//' bar.end, slider'//nl//'*JOINT, NAME=guide, TYPE=POINT ON LINE'// &
            & nl//' slider, ground.origin'//nl//'*DRIVER, NAME=motor, TYPE=ANGLE, BODY=crank'//nl//' 150*t'//nl// &
            & '*DYNAMICS, END='//end//', TOLERANCE=1e-6, INTEGRATOR=RADAU'//nl//'*OUTPUT'//nl// &
            & ' w = deflection(bar.middle)/length(bar)'//nl, reader)
         allocate (w, source=channel(reader, 'w'))
         off(k) = maxval(abs(w(samples) - truth))/maxval(abs(truth))
         deallocate (w)
         call reader%close()
      end do
      call judge(name, off)
   end subroutine judge_rod

   !> Runs a scene with a number of functions.
   subroutine run(name, before, which, behind, reader)
      character(*), intent(in) :: name, before, behind
      integer, intent(in) :: which
      type(history_reader_type), intent(out) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call run_text(before//', FUNCTIONS='//as_text(counts(which))//behind, trim(results), report, error)
      call check_no_error(error, name)
      if (allocated(error)) error stop 1
      call reader%open(trim(results), error)
      call check_no_error(error, name)
   end subroutine run

   subroutine judge(name, off)
      character(*), intent(in) :: name
      !> Errors with few and with many functions
      real(wp), intent(in) :: off(2)
      real(wp) :: observed
      observed = log(off(1)/max(off(2), tiny(off)))/log(real(counts(2), wp)/counts(1))
      print '(a,2es10.2,f7.1)', name//': errors, rate', off, observed
      call check(off(2) <= enough, name//': right to 1e-4 with 12 functions')
      call check(off(2) <= remains .or. observed >= rate, name//': converges')
   end subroutine judge

end program test_convergence
