!> Modal analysis against theory: rotating cantilever at many speeds, a damped oscillator, a free bar, a loaded column, shafts that
!> turn freely, see-saws.
!> Usage, in tests/: test_vibrations RESULT_FILE
program test_vibrations
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_changed, run_text
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   !> Speeds, and the first two frequencies of flapping [sqrt(EI/(rho A L^4))]
   integer, parameter :: speeds(10) = [0, 1, 2, 3, 4, 5, 6, 8, 10, 12]
   real(wp), parameter :: flap(2, 10) = reshape([3.5160152685_wp, 22.0344915647_wp, 3.6816468140_wp, 22.1810111506_wp, &
      & 4.1373195730_wp, 22.6149219565_wp, 4.7972785324_wp, 23.3202636743_wp, 5.5850014209_wp, 24.2733493944_wp, &
      & 6.4495447486_wp, 25.4460803580_wp, 7.3603730193_wp, 26.8090816785_wp, 9.2568376005_wp, 29.9953818916_wp, &
      & 11.2023277622_wp, 33.6403658542_wp, 13.1701504875_wp, 37.6031123312_wp], [2, 10])
   character(1), parameter :: nl = new_line('a')
   character(256) :: results

   call get_command_argument(1, results)
   call check_campbell()
   call check_oscillator()
   call check_column()
   call check_long()
   call check_free()
   call check_see_saw()
   call check_at_rest()
   call check_overdamped()
   call check_skew()
   call finish()

contains

   !> Lag is flap less the speed, in squares: frequencies of the plane of rotation.
   subroutine check_campbell()
      character(*), parameter :: static = 'AXIAL BASIS=STATIC, GEOMETRIC ELEMENTS='
      real(wp) :: worst(2)
      call campbell('LENGTH=length', worst)
      print '(a,2f8.4,a)', 'exact beam:', 100*worst, ' %'
      call check(all(worst < 0.0005_wp), 'both frequencies within 0.05 % by default')
      call campbell('LENGTH=length, SUPPORT=CLAMPED-FREE, ELEMENTS=100, BENDING MODES=3, '//static//'8', worst)
      print '(a,2f8.4,a)', 'three modes, 8 k_G elements:', 100*worst, ' %'
      call check(worst(1) < 0.005_wp, 'first frequency within 0.5 % with three modes and 8 k_G elements')
      call check(worst(2) < 0.0085_wp, 'second frequency within 0.85 % with three modes and 8 k_G elements')
      call campbell('LENGTH=length, SUPPORT=CLAMPED-FREE, ELEMENTS=128, BENDING MODES=8, '//static//'64', worst)
      print '(a,2f8.4,a)', 'eight modes, 64 k_G elements:', 100*worst, ' %'
      call check(all(worst < 0.0005_wp), 'both frequencies within 0.05 % with eight modes and 64 k_G elements')
   end subroutine check_campbell

   subroutine campbell(choice, worst)
      !> What the deck says of the beam
      character(*), intent(in) :: choice
      !> Largest relative errors of both frequencies over all speeds
      real(wp), intent(out) :: worst(2)
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: lag(:)
      character(120) :: changed(1)
      integer :: k
      changed(1) = choice
      call run_changed('../input/campbell.inp', trim(results), [character(120) :: 'LENGTH=length'], changed, reader)
      worst = 0.0_wp
      do k = 1, size(speeds)
         call reader%read_numbers('/modes/speed_'//as_text(speeds(k))//'/frequency', lag, error)
         call check_no_error(error, 'frequencies')
         worst = max(worst, abs(sqrt(lag(:2)**2 + speeds(k)**2)/flap(:, k) - 1))
      end do
      call reader%close()
   end subroutine campbell

   !> Shafts that turn freely: the motion as a whole is a mode of frequency zero, no divergence, and takes none of the others away.
   !> Rotors in a row: 2 sqrt(k/J) sin(i pi/(2 n)), by LAPACK and, where there are many, by ARPACK.
   subroutine check_free()
      real(wp), parameter :: pi = acos(-1.0_wp), unit = 2*sqrt(500/0.01_wp)
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: frequency(:), growth(:)
      integer, parameter :: counts(2) = [5, 190]
      integer :: i, k
      do i = 1, size(counts)
         call run_changed('verification/free_rotors.inp', trim(results), [character(8) :: 'n = 5'], &
            & [character(8) :: 'n = '//as_text(counts(i))], reader)
         call reader%read_numbers('/modes/plain/frequency', frequency, error)
         call reader%read_numbers('/modes/plain/growth', growth, error)
         call check_no_error(error, 'free rotors')
         call check(size(frequency) == 5, as_text(counts(i))//' rotors: five modes')
         call check(all(abs(growth) <= 0.0_wp), as_text(counts(i))//' rotors: none grows')
         call check_close(frequency(1), 0.0_wp, 0.0_wp, 'rotors: as a whole')
         do k = 2, size(frequency)
            call check_close(frequency(k), unit*sin((k - 1)*pi/(2*counts(i))), 1.0e-7_wp*unit, 'rotors: frequency '//as_text(k))
         end do
         call reader%read_numbers('/modes/damped/frequency', frequency, error)
         call reader%read_numbers('/modes/damped/growth', growth, error)
         call check(size(frequency) == min(counts(i), 6) .and. abs(frequency(1)) <= 0.0_wp, 'damped rotors: a zero')
         call check(all(growth <= 0.0_wp), 'damped rotors: none grows')
         call check_close(frequency(2), unit*sin(pi/(2*counts(i))), 1.0e-5_wp*unit, 'damped rotors: frequency 2')
         call reader%close()
      end do
      call run_changed('verification/free_gears.inp', trim(results), [character(1) ::], [character(1) ::], reader)
      call reader%read_numbers('/modes/modes/frequency', frequency, error)
      call check(size(frequency) == 3, 'gears: three modes')
      call check_close(frequency(2), 211.95522373_wp, 1.0e-6_wp, 'gears: second frequency')
      call check_close(frequency(3), 615.14901972_wp, 1.0e-6_wp, 'gears: third frequency')
      call reader%close()
   end subroutine check_free

   !> Derivatives at rest: a damper between points that coincide there, c/(2 sqrt(k m)), and the drag of the air, which is nothing.
   subroutine check_at_rest()
      character(*), parameter :: bushing = '*BUSHING, NAME=s, STIFFNESS X=200, STIFFNESS Y=200'//nl//' p, ground.origin'//nl// &
         & '*FORCE, NAME=f, POINT=p'//nl
      call vibrate('*JOINT, NAME=l, TYPE=POINT ON LINE'//nl//' p, ground.origin'//nl//'*SPRING, NAME=s, STIFFNESS=200, DAMPING=4'&
         & //nl//' p, ground.origin', 'a damper of no length', 10*sqrt(1 - 0.1_wp**2), 0.1_wp)
      call vibrate(bushing//' -5*vx(p)*sqrt(vx(p)**2 + vy(p)**2), -5*vy(p)*(vx(p)**2 + vy(p)**2)**0.5', 'drag', 10.0_wp, 0.0_wp)
      call vibrate(bushing//' -50*x(p)*sqrt(abs(x(p))), -800*max(0, -y(p) - 0.1)**0.25*vy(p)', 'roots', 10.0_wp, 0.0_wp)
   end subroutine check_at_rest

   !> A cantilever with a mass at 0.37 whose motions along the axis are beyond critical damping: they have no frequency, and none is
   !> missing in the list. omega sqrt(1 - (beta omega/2)^2) with the roots omega of the two parts of a beam that share the mass.
   subroutine check_overdamped()
      real(wp), parameter :: omega(3) = [3.2546574713763_wp, 13.7651514599895_wp, 49.9495444485434_wp], beta = 0.02_wp
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp), allocatable :: frequency(:), ratio(:)
      integer :: k
      call run_text('*MATERIAL, NAME=stuff, YOUNG=1e4, DENSITY=1'//nl//'*SECTION, NAME=bar, SHAPE=GENERAL, AREA=1, INERTIA=1e-4'// &
         & nl//'*BEAM, NAME=bar, MATERIAL=stuff, SECTION=bar, LENGTH=1, STRAIN FUNCTIONS=1'//nl//' off, 0.37'//nl// &
         & '*POINT MASS, NAME=p, MASS=1, X=0.37'//nl//'*DAMPING, BODY=bar, RAYLEIGH BETA=0.02'//nl//'*JOINT, NAME=clamp, '// &
         & 'TYPE=WELD'//nl//' bar.start, ground.origin'//nl//'*JOINT, NAME=pin, TYPE=REVOLUTE'//nl//' bar.off, p'//nl// &
         & '*MODES, NUMBER=3, DAMPED=YES'//nl, trim(results), report, error)
      call check_no_error(error, 'overdamped')
      if (allocated(error)) return
      call check(index(report, 'warning') == 0, 'overdamped: nothing is warned of: '//report)
      call reader%open(trim(results), error)
      call reader%read_numbers('/modes/modes/frequency', frequency, error)
      call reader%read_numbers('/modes/modes/damping_ratio', ratio, error)
      call check_no_error(error, 'overdamped: modes')
      call reader%close()
      do k = 1, 3
         call check_close(frequency(k), omega(k)*sqrt(1 - (0.5_wp*beta*omega(k))**2), 1.0e-5_wp*omega(k), 'overdamped: frequency')
         call check_close(ratio(k), 0.5_wp*beta*omega(k), 1.0e-5_wp, 'overdamped: ratio')
      end do
   end subroutine check_overdamped

   !> A mass on equal springs of omega = 10 and a force across its velocity, b = 5 times it: omega = sqrt(100 + b^2/4) -+ b/2, which
   !> is told where damping is left out; not where the force is weak, nor of dampers in any axes.
   subroutine check_skew()
      real(wp), parameter :: truth(2) = sqrt(106.25_wp) + [-2.5_wp, 2.5_wp]
      character(*), parameter :: springs = ' -100*x(m)', other = ' -100*y(m)', told = "leaves out a part of the law of 'f'"
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: frequency(:)
      call skew_deck(springs//' + 5*vy(m),'//other//' - 5*vx(m)', 'across', told, '10 rad/s in place of 7.808 rad/s (and 1 more)')
      call reader%open(trim(results), error)
      call reader%read_numbers('/modes/plain/frequency', frequency, error)
      call check_no_error(error, 'across: modes')
      call check_close(frequency(1), 10.0_wp, 1.0e-9_wp, 'across, without damping')
      call reader%read_numbers('/modes/damped/frequency', frequency, error)
      call check_no_error(error, 'across: modes')
      call check_close(frequency(1), truth(1), 1.0e-9_wp, 'across, first')
      call check_close(frequency(2), truth(2), 1.0e-9_wp, 'across, second')
      call reader%close()
      call skew_deck(' 5*vy(m), -5*vx(m)', 'across a free mass', told, 'no vibration in place of 5 rad/s')
      call skew_deck(springs//' + 1e-2*vy(m),'//other//' - 1e-2*vx(m)', 'weakly across', '', '')
      call skew_deck(springs//' - 2*vx(m) - 1*vy(m),'//other//' - 1*vx(m) - 3*vy(m)', 'dampers', '', '')
      call skew_deck(springs//' - 2*vx(m) + 4*vy(m),'//other//' - 4*vx(m) - 2*vy(m)', 'dampers across', told, 'use DAMPED=YES')
   end subroutine check_skew

   !> A mass of 1 under a force, with words that must be in the report; without the first: it must have no warning.
   subroutine skew_deck(force, name, told, number)
      character(*), intent(in) :: force, name, told, number
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call run_text('*POINT MASS, NAME=m, MASS=1'//nl//'*FORCE, NAME=f, POINT=m'//nl//force//nl//'*MODES, NAME=plain'//nl// &
         & '*MODES, NAME=damped, DAMPED=YES'//nl, trim(results), report, error)
      call check_no_error(error, name)
      if (allocated(error)) return
      if (told == '') call check(index(report, 'leaves out') == 0, name//' is not warned of: '//report)
      if (told /= '') call check(index(report, told) > 0 .and. index(report, number) > 0, name//' is warned of: '//report)
      call check(index(report, "*MODES 'damped' leaves out") == 0, name//', damped: '//report)
   end subroutine skew_deck

   !> The first mode of a mass of 2.
   subroutine vibrate(lines, name, expected, ratio)
      !> What holds it, and what that is called
      character(*), intent(in) :: lines, name
      real(wp), intent(in) :: expected, ratio
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp), allocatable :: frequency(:), growth(:)
      call run_text('*POINT MASS, NAME=p, MASS=2'//nl//lines//nl//'*MODES, DAMPED=YES'//nl//'*OUTPUT'//nl//' x(p)', &
         & trim(results), report, error)
      call check_no_error(error, name)
      if (allocated(error)) return
      call reader%open(trim(results), error)
      call reader%read_numbers('/modes/modes/frequency', frequency, error)
      call reader%read_numbers('/modes/modes/growth', growth, error)
      call check_no_error(error, name//': modes')
      call reader%close()
      call check_close(frequency(1), expected, 1.0e-7_wp*expected, name//': frequency')
      call check_close(growth(1), -10*ratio, 1.0e-7_wp, name//': decay')
   end subroutine vibrate

   !> Beams on a hinge between their ends, of lengths at which the stiffness of the free motion was round-off of either sign: the
   !> zero takes no other frequency away. They are roots of the equation of two beams that share the angle and the moment at the
   !> hinge.
   subroutine check_see_saw()
      real(wp), parameter :: lengths(6) = [1.3_wp, 1.9_wp, 2.0_wp, 2.2_wp, 2.6_wp, 2.7_wp], near = 2.0e-4_wp
      character(6), parameter :: kinds(2) = [character(6) :: 'plain', 'damped']
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: frequency(:)
      character(20) :: changed(1)
      integer :: i, j, k
      do i = 1, size(lengths)
         changed(1) = 'length = '//as_text(lengths(i), 3)
         call run_changed('verification/see_saw.inp', trim(results), [character(20) :: 'length = 2.2'], changed, reader)
         do j = 1, size(kinds)
            call reader%read_numbers('/modes/'//trim(kinds(j))//'/frequency', frequency, error)
            call check_no_error(error, 'see-saw')
            call check(size(frequency) == 5, 'see-saw: all modes that are wanted')
            call check_close(frequency(1), 0.0_wp, 0.0_wp, 'see-saw: it turns freely')
            do k = 2, size(frequency)
               call check(hinge(lengths(i), (1 - near)*frequency(k))*hinge(lengths(i), (1 + near)*frequency(k)) < 0.0_wp, &
                  & 'see-saw: frequency '//as_text(k))
            end do
            call check(signs(lengths(i), (1 + near)*frequency(5)) == 4, 'see-saw: none is left out')
         end do
         call reader%close()
      end do
   end subroutine check_see_saw

   !> Zero at a frequency of bending: the sum of what both parts oppose to an angle at the hinge, without the poles.
   pure real(wp) function hinge(length, omega)
      real(wp), intent(in) :: length, omega
      real(wp), parameter :: hole = 0.3_wp
      real(wp) :: part(2)
      ! sqrt(EI/(rho A)) of a rectangle of height 0.044
      part = sqrt(omega/(sqrt(2.0e11_wp/7800)*0.044_wp/sqrt(12.0_wp)))*[hole, length - hole]
      hinge = turning(part(1))*(1 + cos(part(2))*cosh(part(2))) + turning(part(2))*(1 + cos(part(1))*cosh(part(1)))
   end function hinge

   pure real(wp) function turning(x)
      real(wp), intent(in) :: x
      turning = cos(x)*sinh(x) - sin(x)*cosh(x)
   end function turning

   !> Changes of sign of `hinge` below a frequency.
   pure integer function signs(length, omega)
      real(wp), intent(in) :: length, omega
      integer, parameter :: parts = 2000
      integer :: k
      signs = 0
      do k = 1, parts - 1
         if (hinge(length, k*omega/parts)*hinge(length, (k + 1)*omega/parts) < 0.0_wp) signs = signs + 1
      end do
   end function signs

   !> Mass, spring and damper: s = -zeta omega + i omega sqrt(1 - zeta^2).
   subroutine check_oscillator()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: frequency(:), ratio(:), growth(:)
      real(wp), parameter :: omega = sqrt(100/2.0_wp), zeta = 3/(2*sqrt(100*2.0_wp))
      call run_changed('verification/oscillator.inp', trim(results), [character(1) ::], [character(1) ::], reader)
      call reader%read_numbers('/modes/undamped/frequency', frequency, error)
      call check_no_error(error, 'frequency')
      call check(size(frequency) == 1, 'an oscillator has one mode')
      call check_close(frequency(1), omega, 1.0e-11_wp, 'undamped frequency')
      call reader%read_numbers('/modes/damped/frequency', frequency, error)
      call reader%read_numbers('/modes/damped/damping_ratio', ratio, error)
      call reader%read_numbers('/modes/damped/growth', growth, error)
      call check_close(frequency(1), omega*sqrt(1 - zeta**2), 1.0e-11_wp, 'damped frequency')
      call check_close(ratio(1), zeta, 1.0e-11_wp, 'damping ratio')
      call check_close(growth(1), -zeta*omega, 1.0e-11_wp, 'decay')
      call reader%close()
   end subroutine check_oscillator

   !> A cantilever in a hundred segments, beyond the size of dense matrices: roots of cos x cosh x = -1.
   subroutine check_long()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: frequency(:)
      real(wp), parameter :: root(3) = [1.87510406871_wp, 4.69409113297_wp, 7.85475743824_wp]
      real(wp), parameter :: unit = sqrt(2.0e11_wp*0.005_wp**2/12/8000)
      integer :: k
      call run_changed('verification/long_cantilever.inp', trim(results), [character(1) ::], [character(1) ::], reader)
      call reader%read_numbers('/modes/modes/frequency', frequency, error)
      call check_no_error(error, 'frequency')
      call check(size(frequency) == 3, 'three modes')
      do k = 1, 3
         call check_close(frequency(k), root(k)**2*unit, 5.0e-5_wp*frequency(k), 'frequency '//as_text(k)//' of a cantilever')
      end do
      call reader%close()
   end subroutine check_long

   !> A compressed column: omega^2 falls with the load as 1 - P/P_E; EXACT and K_G.
   subroutine check_column()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: frequency(:)
      real(wp), parameter :: pi = acos(-1.0_wp)
      character(80) :: changed(2)
      integer :: k
      changed = [character(80) :: 'LENGTH=length', 'PERIOD=0.5']
      do k = 1, 2
         if (k == 2) changed(1) = 'LENGTH=length, ELEMENTS=40, BENDING MODES=3, AXIAL BASIS=STATIC'
         call run_changed('../input/euler_buckling.inp', trim(results), [character(40) :: &
            & 'LENGTH=length', 'PERIOD=1.2'], changed, reader)
         call reader%read_numbers('/modes/modes/frequency', frequency, error)
         call check_no_error(error, 'frequency')
         call check_close(frequency(1), pi**2*sqrt(1 - 5/pi**2), 1.0e-4_wp*frequency(1), 'frequency of a compressed column')
         call reader%close()
      end do
   end subroutine check_column

end program test_vibrations
