!> Internal forces under loads along beams and members of frames, and between two points of one body, against statics and free-body
!> diagrams; loads that bend, jump or are narrow, against their integrals. Usage, in tests/: test_spread_loads <file for results>
program test_spread_loads
   use limber_base_kinds, only: wp
   use limber_output_history_reader, only: history_reader_type
   use limber_base_error, only: error_type
   use limber_base_text, only: newline
   use runs, only: run_changed, run_text, channel
   use testing, only: check_close, check_no_error, finish
   implicit none
   character(512) :: results

   call get_command_argument(1, results)
   call check_statics()
   call check_free_bar()
   call check_self_loads()
   call check_narrow()
   call finish()

contains

   !> What is behind a section, at rest: polynomials, few modes, sections within elements, members at an angle.
   subroutine check_statics()
      real(wp), parameter :: l = 2.0_wp, q = 3.0e-8_wp, c = 0.6_wp, d = 0.8_wp, all = q*l
      type(history_reader_type) :: reader
      real(wp) :: pull(2), press
      call run_changed('verification/spread_loads.inp', trim(results), [character(4) :: 'l = '], [character(4) :: 'l = '], reader)
      call last(reader, 'bending_moment_cantilever_start', -q*(3*l**2/8 + l**2/5), all)
      call last(reader, 'shear_force_cantilever_start', -q*(l/2 + l/4), all)
      call last(reader, 'axial_force_cantilever_start', q*l/2, all)
      call last(reader, 'bending_moment_cantilever_quarter', &
         & q*l**2*cubic_moment(0.25_wp) - q*l**2*(0.75_wp**2 - 0.25_wp**2)/2, all)
      call last(reader, 'bending_moment_cantilever_inside', q*l**2*cubic_moment(0.57_wp) - q*l**2*0.43_wp**2/2, all)
      call last(reader, 'shear_force_cantilever_inside', -q*l*(0.43_wp + (1 - 0.57_wp**4)/4), all)
      call last(reader, 'axial_force_cantilever_inside', q*l*(1 - 0.57_wp**2)/2, all)
      call last(reader, 'bending_moment_cantilever_end', 0.0_wp, all)
      call last(reader, 'shear_force_cantilever_end', 0.0_wp, all)
      call last(reader, 'half', -q*0.55_wp**2, all)
      call last(reader, 'half_shear', -2*q*0.55_wp, all)
      call last(reader, 'half_axial', q*0.55_wp, all)
      pull = 0.8_wp*q*[1, -2]
      press = q*l**2*(1 - 0.9_wp**2)/2
      call last(reader, 'knee_axial', c*pull(1) + d*pull(2), all)
      call last(reader, 'knee_shear', c*pull(2) - d*pull(1) - press, all)
      call last(reader, 'knee', (0.1_wp*l*c + 0.6_wp)*pull(2) - 0.1_wp*l*d*pull(1) &
         & - q*l**3*((1 - 0.9_wp**3)/3 - 0.9_wp*(1 - 0.9_wp**2)/2), all)
      call last(reader, 'foot_axial', c*pull(1) + d*pull(2), all)
      call last(reader, 'foot_shear', c*pull(2) - d*pull(1) - q*l**2/2, all)
      call last(reader, 'foot', (l*c + 0.6_wp)*pull(2) - l*d*pull(1) - q*l**3/3, all)
      call last(reader, 'foot_x', -pull(1) - d*q*l**2/2, all)
      call last(reader, 'foot_y', -pull(2) + c*q*l**2/2, all)
      call reader%close()
   end subroutine check_statics

   !> Loads that jump within an element, are narrower than one, or wave many times in one: the force of a weld and the tip, the sums
   !> of forces q ds at a distance a, each of which bends the tip by a^2 (3 - a)/(6 E I) with the length 1.
   subroutine check_narrow()
      character(*), parameter :: laws(5) = [character(45) :: 'step(s - 0.37)', '10*exp(-((s - 0.2313)/1e-2)**2)', &
         & '10*step(s - 0.5)*step(0.503 - s)', 'sin(1000*s)**2', 'exp(-((s - 0.6)/1e-3)**2)']
      integer, parameter :: points = 1000000
      real(wp) :: s, q(size(laws)), sums(size(laws)), bent(size(laws))
      integer :: i
      sums = 0.0_wp
      bent = 0.0_wp
      do i = 1, points
         s = (i - 0.5_wp)/points
         q = [merge(1.0_wp, 0.0_wp, s >= 0.37_wp), 10*exp(-min(600.0_wp, ((s - 0.2313_wp)/1.0e-2_wp)**2)), &
            & merge(10.0_wp, 0.0_wp, s >= 0.5_wp .and. s <= 0.503_wp), sin(1000*s)**2, &
            & exp(-min(600.0_wp, ((s - 0.6_wp)/1.0e-3_wp)**2))]/points
         sums = sums + q
         bent = bent + q*s**2*(3 - s)
      end do
      do i = 1, size(laws)
         call check_load(trim(laws(i)), '', sums(i), bent(i))
         call check_load(trim(laws(i)), ', SEGMENTS=4', sums(i), bent(i))
         call check_load(trim(laws(i)), ', GEOMETRIC=LINEAR, SUPPORT=CLAMPED-FREE, BENDING MODES=6', sums(i), bent(i))
      end do
   end subroutine check_narrow

   subroutine check_load(law, options, force, bent)
      character(*), intent(in) :: law, options
      !> Integrals of the load, and of it times s^2 (3 - s)
      real(wp), intent(in) :: force, bent
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp), parameter :: ei = 2.0e11_wp*0.02_wp**4/12
      call run_text('*MATERIAL, NAME=m, YOUNG=2e11, DENSITY=7850'//newline//'*SECTION, NAME=s, SHAPE=RECTANGLE, WIDTH=0.02, '// &
         & 'HEIGHT=0.02'//newline//'*BEAM, NAME=b, MATERIAL=m, SECTION=s, LENGTH=1'//options//newline// &
         & '*JOINT, NAME=w, TYPE=WELD'//newline//' b.start, ground.origin'//newline//'*DISTRIBUTED LOAD, NAME=q, '// &
         & 'BODY=b'//newline//' 0, '//law//newline//'*STATICS'//newline//'*OUTPUT'//newline// &
         & ' f = force_y(w), y = y(b.end)'//newline, trim(results), report, error)
      call check_no_error(error, law)
      call reader%open(trim(results), error)
      call last(reader, 'f', -force, force, 2.0e-5_wp)
      call last(reader, 'y', bent/(6*ei), bent/(6*ei), 2.0e-3_wp)
      call reader%close()
   end subroutine check_load

   !> Springs, couples and a driver between two points of one body: what is between these carries them alone. A bow by its string's
   !> rise; -0.13557 from the elastica.
   subroutine check_self_loads()
      character(*), parameter :: pulled(*) = ['pulled', 'modal '], turned(*) = ['twisted', 'wrung  ']
      type(history_reader_type) :: reader
      real(wp), allocatable :: rise(:), push(:)
      integer :: i
      call run_changed('verification/self_loads.inp', trim(results), [character(4) :: 'YOUN'], [character(4) :: 'YOUN'], reader)
      do i = 1, 2
         call between(reader, trim(pulled(i)), [-1.0e-4_wp, 0.0_wp], 1.0e-4_wp)
         call between(reader, trim(turned(i)), [0.0_wp, 1.0e-4_wp], 1.0e-4_wp)
      end do
      call between(reader, 'sprung', [0.0_wp, -1.0e-4_wp], 1.0e-4_wp)
      allocate (push, source=channel(reader, 'stretching'))
      call between(reader, 'driven', [push(size(push)), 0.0_wp], push(size(push)))
      allocate (rise, source=channel(reader, 'bow_rise'))
      call last(reader, 'bow_N', -1.0_wp, 1.0_wp)
      call last(reader, 'bow_M', -rise(size(rise)), 1.0_wp)
      call check_close(rise(size(rise)), 0.13557_wp, 1.0e-4_wp, 'bow: rise')
      call check_close(last_of(reader, 'girder'), -sqrt(0.5_wp)*1.0e-3_wp, 1.0e-6_wp, 'portal: girder')
      call check_close(last_of(reader, 'column'), 0.0_wp, 1.0e-6_wp, 'portal: column')
      call reader%close()
   end subroutine check_self_loads

   !> Axial force, shear force and bending moment between the points of a load, and behind them.
   subroutine between(reader, beam, expected, scale)
      type(history_reader_type), intent(in) :: reader
      character(*), intent(in) :: beam
      !> Axial force and bending moment between; what errors are parts of
      real(wp), intent(in) :: expected(2), scale
      call last(reader, beam//'_N', expected(1), scale, 1.0e-8_wp)
      call last(reader, beam//'_M', expected(2), scale, 1.0e-8_wp)
      call last(reader, beam//'_Q', 0.0_wp, scale, 1.0e-8_wp)
      call last(reader, beam//'_N2', 0.0_wp, scale, 1.0e-8_wp)
      call last(reader, beam//'_M2', 0.0_wp, scale, 1.0e-8_wp)
   end subroutine between

   real(wp) function last_of(reader, name) result(value)
      type(history_reader_type), intent(in) :: reader
      character(*), intent(in) :: name
      real(wp), allocatable :: values(:)
      allocate (values, source=channel(reader, name))
      value = values(size(values))
   end function last_of

   !> Moment of a cubic load (s/l)^3 downward behind a part of the length, per q l^2.
   pure real(wp) function cubic_moment(x)
      real(wp), intent(in) :: x
      cubic_moment = -((1 - x**5)/5 - x*(1 - x**4)/4)
   end function cubic_moment

   !> The last value of a channel; errors are parts of a scale.
   subroutine last(reader, name, expected, scale, tolerance)
      type(history_reader_type), intent(in) :: reader
      character(*), intent(in) :: name
      real(wp), intent(in) :: expected, scale
      !> 1e-9 if absent
      real(wp), intent(in), optional :: tolerance
      real(wp) :: most
      most = 1.0e-9_wp
      if (present(tolerance)) most = tolerance
      call check_close(last_of(reader, name)/scale, expected/scale, most, 'at rest: '//name)
   end subroutine last

   !> A free bar: the load less the inertia of its rigid motion, the deflections being at rest; places from -1 to 1 along it.
   subroutine check_free_bar()
      real(wp), parameter :: q = 30.0_wp, place = 0.24_wp
      type(history_reader_type) :: reader
      call run_changed('verification/free_load.inp', trim(results), [character(4) :: 'l = '], [character(4) :: 'l = '], reader)
      call first(reader, 'zero', 0.0_wp, q)
      call first(reader, 'zero_shear', 0.0_wp, q)
      call first(reader, 'zero_axial', 0.0_wp, q)
      call first(reader, 'quarter', q*inertia_moment(-0.5_wp) - q, q)
      call first(reader, 'middle', q*inertia_moment(0.0_wp) - q/2, q)
      call first(reader, 'inside', q*inertia_moment(place) - q*(1 - place)**2/2, q)
      call first(reader, 'shear', -q/2*(1 - place) + 0.375_wp*q*(1 - place**2), q)
      call first(reader, 'axial', q/2*(1 - place), q)
      call reader%close()
   end subroutine check_free_bar

   !> Moment of the inertia 1/2 + 3/4 s behind a place.
   pure real(wp) function inertia_moment(x)
      real(wp), intent(in) :: x
      inertia_moment = (1 - x)**2/4 + 0.75_wp*(1.0_wp/3 - x/2 + x**3/6)
   end function inertia_moment

   !> The first value of a channel; the mass is lumped at nodes.
   subroutine first(reader, name, expected, scale)
      type(history_reader_type), intent(in) :: reader
      character(*), intent(in) :: name
      real(wp), intent(in) :: expected, scale
      real(wp), allocatable :: values(:)
      allocate (values, source=channel(reader, name))
      print '(3a,2es13.5)', 'free bar: ', name, ' ', values(1)/scale, expected/scale
      call check_close(values(1)/scale, expected/scale, 1.0e-3_wp, 'free bar: '//name)
      deallocate (values)
   end subroutine first

end program test_spread_loads
