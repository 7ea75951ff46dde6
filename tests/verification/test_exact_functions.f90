!> What is told of too few functions of exact beams, against closed forms: deflections at rest, buckling loads and frequencies; and
!> functions for spread loads on a part of a beam. Usage, in tests/: test_exact_functions RESULT_FILE
program test_exact_functions
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use limber_output_history_reader, only: history_reader_type
   use bars, only: nl, wall, pin, roller, guide
   use runs, only: channel, run_text
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   character(*), parameter :: spring = '*BUSHING, NAME=spring, STIFFNESS Y=30'//nl//' bar.end, ground.far'//nl
   character(*), parameter :: snow = '*DISTRIBUTED LOAD, NAME=snow, BODY=bar'//nl//' 0, -0.1'//nl//'*STATICS'//nl
   real(wp), parameter :: pi = acos(-1.0_wp)
   character(256) :: results
   character(:), allocatable :: report

   call get_command_argument(1, results)
   call check_deflections()
   call check_loads()
   call check_frequencies()
   call check_spreads()
   call check_parts()
   call check_missing()
   call check_straight()
   call finish()

contains

   !> A uniform load of 0.1 in units of E I/L^3; the largest deflections between the ends are a little larger than those in the
   !> middle.
   subroutine check_deflections()
      call check_sag(wall, 1, 'y', 1.0_wp/8)
      call check_sag(pin//roller, 1, 'ym', 5.0_wp/384)
      call check_sag(pin//roller, 2, 'ym', 5.0_wp/384)
      call check_sag(wall//roller, 2, 'yq', 1.875_wp/768, 5.416e-3_wp)
      call check_sag(wall//roller, 3, 'ym', 1.0_wp/192)
      call check_sag(wall//guide, 3, 'ym', 1.0_wp/384)
      call check_sag(wall//guide, 4, 'ym', 1.0_wp/384)
      call check_sag(wall//spring, 2, 'ym', 17.0_wp/384 - 30.0_wp/88*5.0_wp/48)
      call check_sag(wall//spring, 3, 'ym', 17.0_wp/384 - 30.0_wp/88*5.0_wp/48)
      call check_sag(wall//guide, 7, 'ym', 1.0_wp/384)
   end subroutine check_deflections

   !> What is told is between a third and three times the error; nothing is told of errors below 7e-4, something of all above 6e-3.
   subroutine check_sag(held, functions, name, truth, largest)
      character(*), intent(in) :: held, name
      integer, intent(in) :: functions
      real(wp), intent(in) :: truth
      !> Deflection of the axis, if that is another place
      real(wp), intent(in), optional :: largest
      type(history_reader_type) :: reader
      real(wp), allocatable :: y(:)
      real(wp) :: error, told
      call run_scene(functions, held//snow, reader)
      allocate (y, source=channel(reader, name))
      error = abs(y(size(y))/(-0.1_wp*truth) - 1)
      if (present(largest)) error = error*truth/largest
      told = number_behind('; about ')/100
      call judge('deflection of '//held//as_text(functions), error, told)
      call reader%close()
   end subroutine check_sag

   !> Compares what is told with an error.
   subroutine judge(what, error, told)
      character(*), intent(in) :: what
      real(wp), intent(in) :: error, told
      print '(2a,2es10.2)', what, ': error, told', error, told
      if (error >= 6.0e-3_wp) call check(told > 0.0_wp, what//' is told')
      if (error <= 7.0e-4_wp) call check(.not. told > 0.0_wp, what//' is not told')
      if (told > 0.0_wp) call check(told > error/3 .and. told < 3*error, what//' is told within a factor of three')
   end subroutine judge

   !> Euler's loads, and a state at 0.986 of one that is past the true one with the functions' error.
   subroutine check_loads()
      integer :: n
      do n = 1, 5
         call check_load(wall, n, 3.0_wp, 0.25_wp*pi**2)
         if (n > 1) call check_load(wall//roller, n, 24.0_wp, 20.190728556426629_wp)
         if (n > 2) call check_load(wall//guide, n, 45.0_wp, 4*pi**2)
      end do
      call check_state(2, 20.5_wp, .true.)
      call check_state(7, 20.1_wp, .false.)
      call check_state(7, 10.0_wp, .false.)
   end subroutine check_loads

   subroutine check_load(held, functions, load, truth)
      character(*), intent(in) :: held
      integer, intent(in) :: functions
      real(wp), intent(in) :: load, truth
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: time(:)
      call run_scene(functions, held//push(load)//'*STATICS, INCREMENTS=10, INSTABILITY=STOP'//nl, reader)
      call reader%read_time(time, error)
      call check_no_error(error, 'times')
      if (allocated(error)) return
      call judge('load of '//held//as_text(functions), load*time(size(time))/truth - 1, number_behind('too high by about ')/100)
      call reader%close()
   end subroutine check_load

   !> A propped column that the functions think stable.
   subroutine check_state(functions, load, told)
      integer, intent(in) :: functions
      real(wp), intent(in) :: load
      logical, intent(in) :: told
      type(history_reader_type) :: reader
      call run_scene(functions, wall//roller//push(load)//'*STATICS, INCREMENTS=5'//nl, reader)
      call check((index(report, 'leave less stiffness') > 0) .eqv. told, 'the state at '//as_text(load)//': '//report)
      call reader%close()
   end subroutine check_state

   function push(load) result(text)
      real(wp), intent(in) :: load
      character(:), allocatable :: text
      text = '*FORCE, NAME=load, POINT=bar.end'//nl//' -'//as_text(load)//'*t, 0'//nl
   end function push

   !> The last mode that is asked for errs most.
   subroutine check_frequencies()
      real(wp), parameter :: free(3) = [1.8751040687120_wp, 4.6940911329742_wp, 7.8547574382376_wp]
      real(wp), parameter :: slot(3) = [3.9266023120479_wp, 7.0685827456287_wp, 10.210176122813_wp]
      real(wp), parameter :: walls(3) = [4.7300407448627_wp, 7.8532046240958_wp, 10.995607838002_wp]
      integer :: n
      do n = 3, 7
         call check_modes(wall, n, free)
         call check_modes(pin//roller, n, pi*[1, 2, 3])
         if (n > 3) call check_modes(wall//roller, n, slot)
         if (n > 4) call check_modes(wall//guide, n, walls)
      end do
   end subroutine check_frequencies

   subroutine check_modes(held, functions, waves)
      character(*), intent(in) :: held
      integer, intent(in) :: functions
      real(wp), intent(in) :: waves(3)
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: frequency(:)
      call run_scene(functions, held//'*MODES, NAME=modes, NUMBER=3'//nl, reader)
      call reader%read_numbers('/modes/modes/frequency', frequency, error)
      call check_no_error(error, 'frequencies')
      if (allocated(error)) return
      call judge('frequency of '//held//as_text(functions), maxval(abs(frequency(:3)/waves**2 - 1)), &
         & number_behind('errs in its frequency by about ')/100)
      call reader%close()
   end subroutine check_modes

   !> Frequencies of a beam on pins with a place where a force may act: each of its parts has stations enough, wherever that is.
   subroutine check_parts()
      character(8), parameter :: places(6) = [character(8) :: 'near', 'quarter', 'behind', 'third', 'off', 'middle']
      real(wp), parameter :: waves(6) = pi*[1, 2, 3, 4, 5, 6]
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: frequency(:)
      character(:), allocatable :: place
      integer :: i
      place = ''
      do i = 1, size(places)
         place = trim(places(i))
         call run_scene(7, pin//roller//'*FORCE, NAME=f, POINT=bar.'//place//nl//' 0, 0*t'//nl// &
            & '*MODES, NAME=modes, NUMBER=6'//nl, reader)
         call reader%read_numbers('/modes/modes/frequency', frequency, error)
         call check_no_error(error, 'frequencies with a force at '//place)
         if (allocated(error)) return
         print '(a,6es10.2)', 'errors of the frequencies with a force at '//place//':', frequency(:6)/waves**2 - 1
         call check(maxval(abs(frequency(:5)/waves(:5)**2 - 1)) < 1.0e-4_wp, 'five frequencies with a force at '//place)
         call reader%close()
         if (allocated(frequency)) deallocate (frequency)
      end do
   end subroutine check_parts

   !> A mass within a beam that one function of the strain holds too stiffly along the axis: the mode at 119.03 rad/s, c k of the
   !> least k with tan 0.63 k - cot 0.37 k = -k, is missing between the fourth and the fifth of the list.
   subroutine check_missing()
      call check_list(1, .true.)
      call check_list(6, .false.)
   end subroutine check_missing

   subroutine check_list(strains, missing)
      integer, intent(in) :: strains
      logical, intent(in) :: missing
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: frequency(:)
      call run_text('*MATERIAL, NAME=stuff, YOUNG=1e4, DENSITY=1'//nl//'*SECTION, NAME=bar, SHAPE=GENERAL, AREA=1, INERTIA=1e-4'// &
         & nl//'*BEAM, NAME=bar, MATERIAL=stuff, SECTION=bar, LENGTH=1, STRAIN FUNCTIONS='//as_text(strains)//nl//' off, 0.37'// &
         & nl//'*GROUND'//nl//' far, 1, 0'//nl//'*RIGID BODY, NAME=disc, MASS=1, INERTIA=0.1, X=0.37'//nl//pin//roller// &
         & '*JOINT, NAME=weld, TYPE=WELD'//nl//' bar.off, disc.origin'//nl//'*MODES, NAME=modes, NUMBER=5'//nl, trim(results), &
         & report, error)
      call check_no_error(error, 'missing mode')
      if (allocated(error)) return
      call reader%open(trim(results), error)
      call check_no_error(error, 'missing mode: results')
      call reader%read_numbers('/modes/modes/frequency', frequency, error)
      call check_no_error(error, 'missing mode: frequencies')
      if (allocated(error)) return
      call check((index(report, 'may lack a mode') > 0) .eqv. missing, 'missing mode: '//report)
      if (missing) call check(index(report, 'use STRAIN FUNCTIONS=2') > 0, 'missing mode, remedy: '//report)
      if (.not. missing) call check_close(frequency(5), 119.03_wp, 1.5_wp, 'the mode along the axis')
      call reader%close()
   end subroutine check_list

   !> A load from 0.3 to 0.55 by default: of a beam on pins by Simpson's rule, exact for the cubic influence of a force on the
   !> middle;
   !> of a cantilever at its tip.
   subroutine check_spreads()
      character(*), parameter :: part = '*DISTRIBUTED LOAD, NAME=snow, BODY=bar, START=0.3, END=0.55'//nl//' 0, -1e-2'//nl// &
         & '*STATICS'//nl
      type(history_reader_type) :: reader
      real(wp), allocatable :: y(:)
      real(wp) :: truth
      integer :: n
      do n = 3, 7, 4
         call run_scene(n, pin//roller//part, reader)
         if (allocated(y)) deallocate (y)
         allocate (y, source=channel(reader, 'ym'))
         truth = 0.2_wp/6*(influence(0.3_wp) + 4*influence(0.4_wp) + influence(0.5_wp)) &
            & + 0.05_wp/6*(influence(0.5_wp) + 4*influence(0.525_wp) + influence(0.55_wp))
         call check_close(y(size(y))/(-1.0e-2_wp*truth), 1.0_wp, 1.0e-4_wp, 'a load on a part between pins')
         call reader%close()
         call run_scene(n, wall//part, reader)
         deallocate (y)
         allocate (y, source=channel(reader, 'y'))
         ! The integral of s^2 (3 - s)/6
         truth = (0.55_wp**3 - 0.3_wp**3)/6 - (0.55_wp**4 - 0.3_wp**4)/24
         call check_close(y(size(y))/(-1.0e-2_wp*truth), 1.0_wp, 1.0e-4_wp, 'a load on a part of a cantilever')
         call reader%close()
      end do
   end subroutine check_spreads

   !> Deflection of the middle between pins under a unit force at a place.
   pure real(wp) function influence(a)
      real(wp), intent(in) :: a
      real(wp) :: b
      b = min(a, 1 - a)
      influence = b*(0.75_wp - b**2)/12
   end function influence

   !> A clamped bar with a mass on its end, under a weight of 3 and of 0.3 times Euler's load, which grow slowly: it stays straight,
   !> which is told where the bar would buckle; not of an end that moves up and down, and not of a bar that is curved.
   subroutine check_straight()
      call check_bar(3.0_wp, '', .true.)
      call check_bar(0.3_wp, '', .false.)
      call check_bar(3.0_wp, ', CURVATURE=1e-3', .false.)
   end subroutine check_straight

   subroutine check_bar(load, option, expected)
      !> In units of Euler's load
      real(wp), intent(in) :: load
      !> Of the beam; whether a warning is due
      character(*), intent(in) :: option
      logical, intent(in) :: expected
      type(error_type), allocatable :: error
      call run_text('*MATERIAL, NAME=stuff, YOUNG=1e6, DENSITY=1'//nl//'*SECTION, NAME=bar, SHAPE=GENERAL, AREA=1, INERTIA=1e-6'// &
         & nl//'*BEAM, NAME=bar, MATERIAL=stuff, SECTION=bar, LENGTH=1, STRAIN FUNCTIONS=0'//option//nl//wall// &
         & '*POINT MASS, NAME=head, MASS=1, X=1'//nl//'*JOINT, NAME=top, TYPE=REVOLUTE'//nl//' head, bar.end'//nl// &
         & '*FORCE, NAME=push, POINT=bar.end'//nl//' -'//as_text(load*0.25_wp*pi**2)//'*smoothstep(t), 0'//nl// &
         & '*DYNAMICS, END=4, OUTPUTS=4'//nl//'*OUTPUT'//nl//' y = y(bar.end)'//nl, trim(results), report, error)
      call check_no_error(error, 'a bar under a push')
      call check((index(report, 'times its Euler load') > 0) .eqv. expected, 'a bar under a push, straight: '//report)
   end subroutine check_bar

   !> Number in the report behind some words; 0 without them.
   real(wp) function number_behind(words) result(number)
      character(*), intent(in) :: words
      integer :: from, to
      number = 0.0_wp
      from = index(report, words)
      if (from == 0) return
      from = from + len(words)
      to = from + index(report(from:), ' ') - 2
      read (report(from:to), *) number
   end function number_behind

   subroutine run_scene(functions, scene, reader)
      integer, intent(in) :: functions
      character(*), intent(in) :: scene
      type(history_reader_type), intent(out) :: reader
      type(error_type), allocatable :: error
      call run_text('*MATERIAL, NAME=stuff, YOUNG=1e6, DENSITY=1'//nl//'*SECTION, NAME=bar, SHAPE=GENERAL, AREA=1, INERTIA=1e-6'// &
         & nl//'*BEAM, NAME=bar, MATERIAL=stuff, SECTION=bar, LENGTH=1, STRAIN FUNCTIONS=0, FUNCTIONS='//as_text(functions)//nl// &
         & ' near, 0.02'//nl//' quarter, 0.25'//nl//' behind, 0.26'//nl//' third, 0.3'//nl//' off, 0.4'//nl// &
         & '*GROUND'//nl//' far, 1, 0'//nl//scene//'*OUTPUT'//nl// ' y = y(bar.end), ym = y(bar.middle), yq = y(bar.quarter)'//nl, &
         & trim(results), report, error)
      call check_no_error(error, scene)
      if (allocated(error)) error stop 1
      call reader%open(trim(results), error)
      call check_no_error(error, scene)
   end subroutine run_scene

end program test_exact_functions
