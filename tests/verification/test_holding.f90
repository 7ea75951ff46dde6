!> What holds a beam: ratios of damping of beams on springs and bushings, with rigid bodies and other beams, are those asked
!> for or are told with the number obtained; Euler's load of a mast of each model is that of its real supports. Values: the ratio
!> itself, Euler's loads in closed form. Usage, in tests/: test_holding RESULT_FILE
program test_holding
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_text
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   character(*), parameter :: nl = new_line('a')
   character(*), parameter :: flat = '*MATERIAL, NAME=steel, YOUNG=2.1e11, DENSITY=7850'//nl// &
      & '*SECTION, NAME=flat, SHAPE=RECTANGLE, WIDTH=0.04, HEIGHT=0.01'//nl
   character(*), parameter :: bar = flat//'*BEAM, NAME=a, MATERIAL=steel, SECTION=flat, LENGTH=1'
   character(*), parameter :: damping = '*DAMPING, BODY=a, RATIO=0.02'//nl
   character(*), parameter :: wall = '*JOINT, NAME=clamp, TYPE=WELD'//nl//' a.start, ground.origin'//nl
   character(*), parameter :: ground = '*GROUND'//nl//' far, 1, 1'//nl//' right, 1, 0'//nl
   character(256) :: results

   call get_command_argument(1, results)
   call check_springs()
   call check_bodies()
   call check_pieces()
   call check_loads()
   call check_dampers()
   call check_masts()
   call check_bases()
   call finish()

contains

   !> Modes that strain the beam have the ratio, whatever springs hold; those on soft springs have next to none.
   subroutine check_springs()
      character(*), parameter :: spring = '*SPRING, NAME=sp, LENGTH=1, STIFFNESS='
      integer :: k
      call judge('a spring', bar//nl//damping//wall//ground//spring//'5e4'//nl//' a.end, ground.far'//nl, [0.02_wp, 0.02_wp, &
         & 0.02_wp], &
         & '')
      call judge('a spring, other order', bar//nl//wall//ground//spring//'5e4'//nl//' ground.far, a.end'//nl//damping, &
         & [0.02_wp, 0.02_wp, 0.02_wp], '')
      call judge('a spring, K_G', bar//', GEOMETRIC=K_G'//nl//damping//wall//ground//spring//'5e3'//nl//' a.end, ground.far'//nl, &
         & [0.02_wp, 0.02_wp, 0.02_wp], '')
      call judge('a law', bar//nl//damping//wall//ground//'*SPRING, NAME=sp, LENGTH=1'//nl//' a.end, ground.far, 5e4*x'// &
         & nl, &
         & [0.02_wp, 0.02_wp, 0.02_wp], '')
      call judge('a law with friction', bar//nl//damping//wall//ground//'*SPRING, NAME=sp, LENGTH=1'//nl// &
         & ' a.end, ground.far, 5e4*x + 1e-6*v'//nl, [0.02_wp, 0.02_wp, 0.02_wp], '', 1.0e-5_wp)
      call judge('a force', bar//nl//damping//wall//ground//'*FORCE, NAME=push, POINT=a.end'//nl//' 0, -5e4*y(a.end)'//nl, &
         & [0.02_wp, 0.02_wp, 0.02_wp], '')
      ! A law along (0.6, 0.8), that neither component is alone
      call judge('a force askew', bar//nl//damping//wall//ground//'*FORCE, NAME=push, POINT=a.end'//nl// &
         & ' -4.6875e4*(0.6*(x(a.end) - 1) + 0.8*y(a.end)), -6.25e4*(0.6*(x(a.end) - 1) + 0.8*y(a.end))'//nl, [0.02_wp, 0.02_wp, &
         & 0.02_wp], '', 1.0e-3_wp)
      ! What feeds a vibration is no lack of the ratio of the beam, which round-off makes larger or smaller
      do k = 1, 4
         call judge('a force that feeds', bar//nl//damping//wall//ground//'*FORCE, NAME=push, POINT=a.end'//nl//' 0, '// &
            & as_text(0.5_wp*10.0_wp**(k - 3))//'*vy(a.end) - 5e4*y(a.end)'//nl, [real(wp) ::], '')
      end do
      call judge('stiff bushings', bar//nl//damping//ground//bushings('1e9'), [0.02_wp, 0.02_wp, 0.02_wp], '')
      ! Of the three modes on the springs two hardly strain the beam, and the axial one does not
      call judge('soft bushings', bar//nl//damping//ground//bushings('100'), [0.0_wp, 0.0_wp, 0.0_wp, 0.02_wp, 0.02_wp], '')
      call judge('a ratio of the second mode', bar//nl//damping//' 2, 0.05'//nl//ground//bushings('1e9'), &
         & [0.02_wp, 0.05_wp, 0.02_wp], '')
   end subroutine check_springs

   pure function bushings(stiffness) result(text)
      character(*), intent(in) :: stiffness
      character(:), allocatable :: text
      text = '*BUSHING, NAME=l, STIFFNESS X='//stiffness//', STIFFNESS Y='//stiffness//nl//' a.start, ground.origin'//nl// &
         & '*BUSHING, NAME=r, STIFFNESS X='//stiffness//', STIFFNESS Y='//stiffness//nl//' a.end, ground.right'//nl
   end function bushings

   !> Rigid bodies move with the beam; another beam has a damping of its own, so that the modes of both have another ratio.
   subroutine check_bodies()
      character(*), parameter :: other = '*BEAM, NAME=b, MATERIAL=steel, SECTION=flat, LENGTH=1, X=1'//nl// &
         & '*JOINT, NAME=mid, TYPE=WELD'// &
         & nl//' b.start, a.end'//nl
      character(*), parameter :: carried = '*RIGID BODY, NAME=gear, MASS=2, INERTIA=0.02, X=1'//nl// &
         & '*JOINT, NAME=mid, TYPE=WELD'//nl// &
         & ' gear.origin, a.end'//nl
      call judge('a rigid body', bar//nl//damping//wall//carried, [0.02_wp, 0.02_wp, 0.02_wp], '')
      call judge('a rigid body on a bushing', bar//nl//damping//wall//carried//ground// &
         & '*BUSHING, NAME=r, STIFFNESS X=1e5, STIFFNESS Y=1e5'//nl//' gear.origin, ground.right'//nl, [0.02_wp, 0.02_wp, &
         & 0.02_wp], '')
      ! The ratios of two halves, each of which is damped by its own modes, are 0.0188, 0.0245, 0.0487
      call judge('two beams', bar//nl//damping//wall//other//'*DAMPING, BODY=b, RATIO=0.02'//nl, [real(wp) ::], &
         & 'with 0.0188 of the critical damping instead of 0.02, since other bodies have')
      call judge('two beams, stiffness', bar//nl//'*DAMPING, BODY=a, RAYLEIGH BETA=1e-4'//nl//wall//other// &
         & '*DAMPING, BODY=b, RAYLEIGH BETA=1e-4'//nl, [real(wp) ::], '')
   end subroutine check_bodies

   !> Pieces of a beam are damped each by itself.
   subroutine check_pieces()
      call judge('pieces', bar//', SEGMENTS=4'//nl//damping//wall, [real(wp) ::], &
         & 'with 9.63e-4 of the critical damping instead of 0.02, since each of its pieces is damped by itself')
      call judge('pieces, stiffness', bar//', SEGMENTS=4'//nl//'*DAMPING, BODY=a, RAYLEIGH BETA=1e-4'//nl//wall, [real(wp) ::], '')
   end subroutine check_pieces

   !> A column on pins at 0.75 of Euler's load vibrates at half its frequency: the damping that was 0.02 is 0.04 of the critical
   !> one.
   subroutine check_loads()
      character(*), parameter :: column = '*JOINT, NAME=foot, TYPE=REVOLUTE'//nl//' a.start, ground.origin'//nl// &
         & '*JOINT, NAME=roller, TYPE=POINT ON LINE'//nl//' a.end, ground.right'//nl//ground//'*FORCE, NAME=push, POINT=a.end'//nl
      real(wp), parameter :: euler = acos(-1.0_wp)**2*2.1e11_wp*0.04_wp*0.01_wp**3/12
      character(*), parameter :: told = 'rad/s has 0.04 of the critical damping instead of 0.02, since loads'
      character(:), allocatable :: text
      text = bar//', GEOMETRIC=K_G, SUPPORT=PINNED-ROLLER'//nl//damping//column//' '//as_text(-0.75_wp*euler)//', 0'//nl// &
         & '*STATICS'//nl
      call judge('a column', text, [0.04_wp], told, 1.0e-3_wp)
      call judge('a column, in time', text//'*DYNAMICS, END=2'//nl, [real(wp) ::], told)
      text = bar//nl//damping//column//' '//as_text(-0.001_wp*euler)//', 0'//nl//'*STATICS'//nl
      call judge('hardly loaded', text//'*DYNAMICS, END=2'//nl, [0.02_wp], '', 1.0e-3_wp)
   end subroutine check_loads

   !> A mass of 1000 kg that a light cantilever carries by a spring with a damper. The beam has ks/(ks + kb) of the energy: where
   !> that is little, or dampers do what its ratio does not, there is nothing to tell. Roots of M s^2 + 1/(1/kb + 1/(ks + c s)) = 0.
   subroutine check_dampers()
      character(*), parameter :: carried = bar//nl//damping//wall//'*POINT MASS, NAME=m, MASS=1000, X=1, Y=0.3'//nl// &
         & '*JOINT, NAME=guide, TYPE=POINT ON LINE, ANGLE=90 deg'//nl//' m, ground.right'//nl//ground
      character(*), parameter :: link = '*SPRING, NAME=sp, LENGTH=0.3'//nl//' m, a.end, '
      ! A spring that stiffens, to a fourth of the stiffness of the beam under the load, and twice as much
      real(wp), parameter :: beam = 2100, slack = 50, pressed = 0.01_wp, parts(2) = [0.25_wp, 2.0_wp]
      character(*), parameter :: told = 'of the critical damping instead of 0.02, since'
      character(:), allocatable :: law, text
      real(wp) :: cubic
      integer :: k
      law = ''
      text = ''
      call judge_first('a soft spring with a damper', carried//link//'525*x + 607*v'//nl, [0.25_wp*beam, 607.0_wp], '')
      call judge_first('a soft spring', carried//link//'525*x'//nl, [0.25_wp*beam, 0.0_wp], told//' springs hold 80 %')
      do k = 1, 2
         cubic = (parts(k)*beam - slack)/(3*pressed**2)
         law = as_text(slack)//'*x + '//as_text(cubic)//'*x**3'
         text = '*FORCE, NAME=push, POINT=m'//nl//' 0, '//as_text(-slack*pressed - cubic*pressed**3)//nl//'*STATICS'//nl
         call judge_first('a spring that stiffens, with a damper', carried//link//law//' + 607*v'//nl//text, &
            & [parts(k)*beam, 607.0_wp], '')
         call judge_first('a spring that stiffens', carried//link//law//nl//text, [parts(k)*beam, 0.0_wp], &
            & trim(merge(repeat(' ', len(told) + 6), told//' loads', k == 1)))
      end do
   end subroutine check_dampers

   !> The ratio of the first mode and a part of the warnings, as of `judge`.
   subroutine judge_first(name, deck, spring, warning)
      character(*), intent(in) :: name, deck, warning
      !> Stiffness at the state, and damping
      real(wp), intent(in) :: spring(2)
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: text
      real(wp), allocatable :: ratio(:)
      complex(wp) :: s
      call run_modes(name, deck, reader, text, 1)
      call reader%read_numbers('/modes/small/damping_ratio', ratio, error)
      call check_no_error(error, name)
      call reader%close()
      s = root(spring)
      print '(2a,2es12.4)', name, ': ratio, without that of the beam', ratio(1), -real(s)/abs(s)
      ! The ratio of the beam, which it has at 52 rad/s, is next to none
      call check_close(ratio(1), -real(s)/abs(s), 5.0e-4_wp, name//', ratio')
      if (warning == '') call check(index(text, 'damping of') == 0, name//' is not warned of: '//text)
      if (warning /= '') call check(index(text, warning) > 0, name//' is warned of: '//text)
   end subroutine judge_first

   !> M s^2 (kb + ks + c s) + kb (ks + c s) = 0 by Newton's method.
   pure complex(wp) function root(spring) result(s)
      real(wp), intent(in) :: spring(2)
      real(wp), parameter :: mass = 1000, beam = 2100
      complex(wp) :: hold
      integer :: k
      s = cmplx(0.0_wp, sqrt(beam*spring(1)/(beam + spring(1))/mass), wp)
      do k = 1, 50
         hold = spring(1) + spring(2)*s
         s = s - (mass*s**2*(beam + hold) + beam*hold)/(2*mass*s*(beam + hold) + (mass*s**2 + beam)*spring(2))
      end do
   end function root

   !> Ratios of the first modes, and a part of the warnings; empty: none.
   subroutine judge(name, deck, ratios, warning, tolerance)
      character(*), intent(in) :: name, deck, warning
      real(wp), intent(in) :: ratios(:)
      !> Of the ratios; else 1e-6, and 1e-4 where there is none
      real(wp), intent(in), optional :: tolerance
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: text
      real(wp), allocatable :: ratio(:)
      real(wp) :: allowed
      integer :: k
      call run_modes(name, deck, reader, text)
      if (size(ratios) > 0) then
         call reader%read_numbers('/modes/small/damping_ratio', ratio, error)
         call check_no_error(error, name)
         print '(2a,6es12.4)', name, ': ratios', ratio
         do k = 1, size(ratios)
            allowed = merge(1.0e-6_wp, 1.0e-4_wp, ratios(k) > 0.0_wp)
            if (present(tolerance)) allowed = tolerance
            call check_close(ratio(k), ratios(k), allowed, name//', ratio '//as_text(k))
         end do
      end if
      call reader%close()
      if (warning == '') call check(index(text, 'damping of') == 0, name//' is not warned of: '//text)
      if (warning /= '') call check(index(text, warning) > 0, name//' is warned of: '//text)
   end subroutine judge

   subroutine run_modes(name, deck, reader, text, number)
      character(*), intent(in) :: name, deck
      type(history_reader_type), intent(out) :: reader
      character(:), allocatable, intent(out) :: text
      !> Of modes, else 6
      integer, intent(in), optional :: number
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      integer :: wanted
      wanted = 6
      if (present(number)) wanted = number
      call run_text(deck//'*MODES, NAME=small, NUMBER='//as_text(wanted)//', DAMPED=YES'//nl, trim(results), report, error)
      call check_no_error(error, name)
      call reader%open(trim(results), error)
      call check_no_error(error, name//': results')
      call reader%read_text('/run/warnings', text, error)
      call check_no_error(error, name//': warnings')
   end subroutine run_modes

   !> A mast with a head, of 108 N where the head is free to go across, of 432 N and 883 N where it is guided or held.
   subroutine check_masts()
      character(*), parameter :: pin = '*JOINT, NAME=top, TYPE=REVOLUTE'//nl//' head.origin, mast.end'//nl, &
         & firm = '*JOINT, NAME=top, TYPE=WELD'//nl//' head.origin, mast.end'//nl, &
         & bob = '*POINT MASS, NAME=bob, MASS=0.01, Y=1'//nl//'*JOINT, NAME=swing, TYPE=REVOLUTE'//nl//' bob, head.origin'//nl, &
         & rail = '*GROUND'//nl//' rail, 0, 1'//nl//' far, 1, 1'//nl, &
         & up = '*JOINT, NAME=guide, TYPE=TRANSLATIONAL, ANGLE=90 deg'//nl//' head.origin, ground.rail'//nl, &
         & side = '*RIGID BODY, NAME=car, MASS=0.01, INERTIA=1e-4, Y=1'//nl// &
         & '*JOINT, NAME=lift, TYPE=TRANSLATIONAL, ANGLE=90 deg'//nl// &
         & ' head.origin, car.origin'//nl//'*JOINT, NAME=cross, TYPE=TRANSLATIONAL'//nl//' car.origin, ground.rail'//nl, &
         & strut = '*JOINT, NAME=strut, TYPE=ROD'//nl//' head.origin, ground.far'//nl
      character(*), parameter :: rigid = 'RIGID', linear = 'LINEAR, SUPPORT=CLAMPED-FREE'
      call judge_mast(rigid, 15, pin, '1.4 times its Euler load')
      call judge_mast(rigid, 40, firm, '3.7 times its Euler load')
      call judge_mast(rigid, 100, pin//bob, '9.1 times its Euler load')
      call judge_mast(rigid, 15, pin//rail//side, '1.4 times its Euler load')
      call judge_mast(rigid, 40, firm//rail//side, '0.92 times its Euler load')
      call judge_mast(rigid, 15, firm//rail//side, '')
      call judge_mast(rigid, 15, pin//rail//up, '')
      call judge_mast(rigid, 15, pin//rail//strut, '')
      call judge_mast(linear, 15, pin, '2.8 times its Euler load')
      call judge_mast(linear, 15, pin//rail//side, '2.8 times its Euler load')
      call judge_mast(linear, 15, pin//rail//up, '')
      call judge_mast('K_G', 40, pin, '7.3 times its Euler load')
      call judge_mast('K_G', 15, pin//rail//strut, '')
      call judge_mast('K_G', 100, pin//rail//up, 'times its Euler load')
      call judge_mast('EXACT', 100, pin//bob, 'times its Euler load')
      call judge_mast('EXACT', 100, pin//rail//side, 'times its Euler load')
      call judge_mast('EXACT', 15, pin//rail//up, '')
   end subroutine check_masts

   !> The same without weight, on a free base and on a hinge that a driver holds, under 600 and 30 N from both sides.
   subroutine check_bases()
      character(*), parameter :: free = '*RIGID BODY, NAME=base, MASS=100, INERTIA=10'//nl//'*JOINT, NAME=foot, TYPE=WELD'//nl// &
         & ' mast.start, base.origin'//nl//'*FORCE, NAME=up, POINT=base.origin'//nl//' 0, P*min(1, t/0.3)'//nl, &
         & driven = '*JOINT, NAME=foot, TYPE=REVOLUTE'//nl//' mast.start, ground.origin'//nl//'*DRIVER, NAME=turn, TYPE=ANGLE, '// &
         & 'BODY=mast'//nl//' pi/2'//nl
      character(20), parameter :: models(3) = [character(20) :: 'RIGID', 'K_G', 'EXACT']
      integer :: i
      do i = 1, size(models)
         call judge_base(trim(models(i)), '600', free, 'times its Euler load')
         call judge_base(trim(models(i)), '600', driven, 'times its Euler load')
         call judge_base(trim(models(i)), '30', free, '')
         call judge_base(trim(models(i)), '30', driven, '')
      end do
   end subroutine check_bases

   subroutine judge_base(model, force, foot, warning)
      character(*), intent(in) :: model, force, foot, warning
      type(error_type), allocatable :: error
      character(:), allocatable :: text
      call run_text('*PARAMETER'//nl//' P = '//force//nl//'*MATERIAL, NAME=steel, YOUNG=2.1e11, DENSITY=7850'//nl// &
         & '*SECTION, NAME=flat, SHAPE=RECTANGLE, WIDTH=0.02, HEIGHT=0.005'//nl// &
         & '*BEAM, NAME=mast, MATERIAL=steel, SECTION=flat, LENGTH=1, ANGLE=90 deg, GEOMETRIC='//model//nl//foot// &
         & '*RIGID BODY, NAME=head, MASS=100, INERTIA=10, Y=1'//nl//'*JOINT, NAME=top, TYPE=REVOLUTE'//nl// &
         & ' mast.end, head.origin'//nl//'*FORCE, NAME=down, POINT=head.origin'//nl//' 0, -P*min(1, t/0.3)'//nl// &
         & '*DYNAMICS, END=1'//nl//'*OUTPUT'//nl//' y = y(head.origin)'//nl, trim(results), text, error)
      if (allocated(error)) text = error%message
      if (warning == '') call check(index(text, 'Euler load') == 0, model//' is not warned of: '//foot//text)
      if (warning /= '') call check(index(text, warning) > 0, model//' is warned of: '//foot//text)
   end subroutine judge_base

   subroutine judge_mast(model, mass, top, warning)
      character(*), intent(in) :: model, top, warning
      !> Of the head [kg]
      integer, intent(in) :: mass
      type(error_type), allocatable :: error
      type(history_reader_type) :: reader
      character(:), allocatable :: report, text, name
      name = model//', '//as_text(mass)//' kg'
      call run_text('*GRAVITY'//nl//'*MATERIAL, NAME=steel, YOUNG=2.1e11, DENSITY=7850'//nl// &
         & '*SECTION, NAME=flat, SHAPE=RECTANGLE, WIDTH=0.02, HEIGHT=0.005'//nl// &
         & '*BEAM, NAME=mast, MATERIAL=steel, SECTION=flat, LENGTH=1, ANGLE=90 deg, GEOMETRIC='//model//nl// &
         & '*JOINT, NAME=foot, TYPE=WELD'//nl//' mast.start, ground.origin'//nl//'*RIGID BODY, NAME=head, MASS='//as_text(mass)// &
         & ', INERTIA=0.01, Y=1'//nl//top//'*DYNAMICS, END=0.5'//nl//'*OUTPUT'//nl//' y = y(head.origin)'//nl, trim(results), &
         & report, &
         & error)
      call check_no_error(error, name)
      call reader%open(trim(results), error)
      call check_no_error(error, name//': results')
      call reader%read_text('/run/warnings', text, error)
      call check_no_error(error, name//': warnings')
      call reader%close()
      if (warning == '') call check(index(text, 'Euler load') == 0, name//' is not warned of: '//top//text)
      if (warning /= '') call check(index(text, warning) > 0, name//' is warned of: '//top//text)
   end subroutine judge_mast

end program test_holding
