!> Beams and frames that are short, of all models without shear: what they are told to lack against a Timoshenko beam (of 60
!> elements of its own, ratio of length to height 2, Poisson's ratio 0.3). Usage, in tests/: test_short_beams RESULT_FILE
program test_short_beams
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use runs, only: run_text
   use testing, only: check, check_no_error, finish
   implicit none
   character(*), parameter :: nl = new_line('a')
   character(*), parameter :: wall = '*JOINT, NAME=wall, TYPE=WELD'//nl//' bar.start, ground.origin'//nl
   character(*), parameter :: far = '*GROUND'//nl//' far, 1, 0'//nl
   character(*), parameter :: walls = wall//far//'*JOINT, NAME=other, TYPE=WELD'//nl//' bar.end, ground.far'//nl
   character(*), parameter :: pins = far//'*JOINT, NAME=pin, TYPE=REVOLUTE'//nl//' bar.start, ground.origin'//nl// &
      & '*JOINT, NAME=roller, TYPE=POINT ON LINE'//nl//' bar.end, ground.far'//nl
   !> An end that keeps its direction and moves across
   character(*), parameter :: guide = far//'*JOINT, NAME=guide, TYPE=TRANSLATIONAL, ANGLE=pi/2'//nl//' bar.end, ground.far'//nl
   !> Models of a beam; what a frame says of its members
   character(*), parameter :: beams(5) = [character(48) :: '', ', SEGMENTS=2', ', GEOMETRIC=K_G, SUPPORT=CLAMPED-FREE', &
      & ', GEOMETRIC=K_G, CORRECTIONS=YES', ', GEOMETRIC=LINEAR, SUPPORT=CLAMPED-CLAMPED']
   character(*), parameter :: frames(2) = ['LARGE=NO ', 'LARGE=YES']
   character(256) :: results

   call get_command_argument(1, results)
   ! First frequency, and deflection under the weight
   call check_scene(wall, 0.176_wp, 0.206_wp, 'clamped and free')
   call check_scene(pins, 0.331_wp, 0.384_wp, 'on pins')
   call check_scene(walls, 1.083_wp, 0.757_wp, 'between walls')
   call check_scene(wall//guide, 0.360_wp, 0.438_wp, 'clamped and guided')
   call check_holds()
   call check_truss()
   call finish()

contains

   !> All models in a scene, and that none of them is told of where it is slender, or has shear.
   subroutine check_scene(scene, frequency, deflection, what)
      character(*), intent(in) :: scene, what
      !> What is missing, relative
      real(wp), intent(in) :: frequency, deflection
      integer :: i
      do i = 1, size(beams)
         call check_told(beam('0.5', trim(beams(i))), scene, frequency, deflection, what//trim(beams(i)))
      end do
      do i = 1, size(frames)
         call check_told(frame('0.5', trim(frames(i))), scene, frequency, deflection, what//': frame, '//trim(frames(i)))
      end do
      call check_silent(beam('0.02', ', GEOMETRIC=K_G'), scene, what//': slender')
      call check_silent(frame('0.02', 'LARGE=NO'), scene, what//': slender frame')
      call check_silent(frame('0.02', 'LARGE=YES'), scene, what//': slender large frame')
      call check_silent(beam('0.5', ', SHEAR=YES'), scene, what//': with shear')
   end subroutine check_scene

   subroutine check_told(body, scene, frequency, deflection, what)
      character(*), intent(in) :: body, scene, what
      real(wp), intent(in) :: frequency, deflection
      call compare(told_of(body//scene//'*MODES, NUMBER=1'//nl, 'first bending frequency'), frequency, what//': frequency')
      call compare(told_of(body//scene//'*GRAVITY'//nl//'*STATICS, INCREMENTS=1'//nl, 'its deflection'), deflection, &
         & what//': deflection')
   end subroutine check_told

   subroutine compare(told, true, what)
      real(wp), intent(in) :: told, true
      character(*), intent(in) :: what
      call check(told > 0.9_wp*true .and. told < 1.2_wp*true, what//': told '//as_text(told)//', true '//as_text(true))
   end subroutine compare

   subroutine check_silent(body, scene, what)
      character(*), intent(in) :: body, scene, what
      call check(abs(told_of(body//scene//'*MODES, NUMBER=1'//nl, 'first bending frequency')) <= 0.0_wp, what)
   end subroutine check_silent

   !> What holds the ends beside joints with the ground: drivers of a hinge, wheels, springs, a hub on a hinge; and bodies that hang
   !> on the end, which hold nothing. E I = 41667e3, m = 78, of a length of 1; frequencies of Timoshenko elements with springs and
   !> masses.
   subroutine check_holds()
      character(*), parameter :: pin = '*JOINT, NAME=pin, TYPE=REVOLUTE'//nl//' bar.start, ground.origin'//nl
      character(*), parameter :: roller = far//'*JOINT, NAME=roller, TYPE=POINT ON LINE'//nl//' bar.end, ground.far'//nl
      character(*), parameter :: head = '*RIGID BODY, NAME=head, MASS=', hub = '*RIGID BODY, NAME=hub, MASS=1, INERTIA=23.4'//nl// &
         & '*JOINT, NAME=axle, TYPE=REVOLUTE'//nl//' hub.origin, ground.origin'//nl//'*JOINT, NAME=fixed, TYPE=WELD'//nl// &
         & ' bar.start, hub.origin'//nl
      character(*), parameter :: spring = '*SPRING, NAME=spring, TYPE=ROTATIONAL, STIFFNESS=833.3e6'//nl// &
         & ' bar.start, ground.origin'//nl
      call check_first(pin//'*DRIVER, NAME=motor, TYPE=ANGLE, JOINT=pin'//nl//' 0'//nl, 0.176_wp, 'a driven hinge')
      call check_first(pin//'*RIGID BODY, NAME=wheel, MASS=1, INERTIA=23.4, X=-1'//nl//'*GROUND'//nl//' axle, -1, 0'//nl// &
         & '*JOINT, NAME=axle, TYPE=REVOLUTE'//nl//' wheel.origin, ground.axle'//nl// &
         & '*JOINT, NAME=teeth, TYPE=GEAR, FIRST RADIUS=0.5, SECOND RADIUS=0.5'//nl//' bar.start, wheel.origin'//nl, 0.153_wp, &
         & 'a gear')
      call check_first(hub, 0.153_wp, 'a hub on a hinge')
      call check_first(pin//spring, 0.153_wp, 'a pin with a spring')
      call check_first(pin//spring//roller, 0.616_wp, 'pins with a spring')
      call check_first(wall//far//'*BUSHING, NAME=tip, STIFFNESS Y=8333e6'//nl//' bar.end, ground.far'//nl, 0.621_wp, &
         & 'a clamp and a bushing')
      call check_first(wall//far//'*BUSHING, NAME=tip, STIFFNESS Y=416.7e6'//nl//' bar.end, ground.far'//nl, 0.168_wp, &
         & 'a clamp and a soft bushing')
      call check_first(wall//head//'78, X=1'//nl//'*JOINT, NAME=neck, TYPE=WELD'//nl//' head.origin, bar.end'//nl, 0.107_wp, &
         & 'a head')
      call check_first(wall//'*POINT MASS, NAME=head, MASS=23.4, X=1'//nl//'*JOINT, NAME=neck, TYPE=REVOLUTE'//nl// &
         & ' head, bar.end'//nl, 0.127_wp, 'a point mass')
      call check_first(pin//guide, 0.098_wp, 'a pin and a guide')
      call check_first(wall//'*DRIVER, NAME=along, TYPE=X, POINT=bar.end'//nl//' 1'//nl, 0.176_wp, 'a driver along the beam')
      call compare(told_of(frame('0.5', 'LARGE=NO')//pin//'*DRIVER, NAME=motor, TYPE=ANGLE, JOINT=pin'//nl//' 0'//nl// &
         & '*MODES, NUMBER=1'//nl, 'first bending frequency'), 0.176_wp, 'a frame on a driven hinge')
   end subroutine check_holds

   subroutine check_first(scene, frequency, what)
      character(*), intent(in) :: scene, what
      real(wp), intent(in) :: frequency
      integer, parameter :: some(2) = [1, 3]
      integer :: i
      do i = 1, size(some)
         call compare(told_of(beam('0.5', trim(beams(some(i))))//scene//'*MODES, NUMBER=1'//nl, 'first bending frequency'), &
            & frequency, what//trim(beams(some(i))))
      end do
   end subroutine check_first

   !> The members of a truss of ties are short each, but it bends by their tension: nothing is told of its slow vibration.
   subroutine check_truss()
      integer :: i
      do i = 1, size(frames)
         call check(abs(told_of(sized('0.02')//'*FRAME, NAME=bar, '//trim(frames(i))//nl//'*NODE'//nl//' 1, 0, 0, start'//nl// &
            & ' 2, 0, 1, top'//nl//' 3, 1, 0'//nl//' 4, 1, 1'//nl//' 5, 2, 0'//nl//' 6, 2, 1'//nl//' 7, 3, 0, end'//nl// &
            & ' 8, 3, 1'//nl//'*ELEMENT, ELSET=all'//nl//' 1, 1, 3'//nl//' 2, 3, 5'//nl//' 3, 5, 7'//nl//' 4, 2, 4'//nl// &
            & ' 5, 4, 6'//nl//' 6, 6, 8'//nl//' 7, 1, 4'//nl//' 8, 3, 6'//nl//' 9, 5, 8'//nl//' 10, 3, 4'//nl//' 11, 5, 6'//nl// &
            & ' 12, 7, 8'//nl//'*BEAM SECTION, ELSET=all, MATERIAL=stuff, SECTION=bar'//nl//'*GROUND'//nl//' up, 0, 1'//nl// &
            & '*JOINT, NAME=low, TYPE=REVOLUTE'//nl//' bar.start, ground.origin'//nl//'*JOINT, NAME=high, TYPE=REVOLUTE'//nl// &
            & ' bar.top, ground.up'//nl//'*MODES, NUMBER=1'//nl, 'first bending frequency')) <= 0.0_wp, 'a truss: '//frames(i))
      end do
   end subroutine check_truss

   !> What the report of a deck tells of being short, relative; 0: nothing.
   real(wp) function told_of(deck, what) result(told)
      character(*), intent(in) :: deck, what
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      integer :: at, from
      told = 0.0_wp
      call run_text(deck//'*OUTPUT'//nl//' y(bar.end)'//nl, trim(results), report, error)
      call check_no_error(error, deck)
      if (allocated(error)) return
      at = index(report, 'without shear ')
      if (at == 0) return
      call check(index(report(at:), what) > 0, what//' is told: '//report)
      call check(index(report(at:), 'SHEAR=YES') > 0, 'the remedy is told: '//report)
      from = at + index(report(at:), ' by about ') + len(' by about ') - 1
      read (report(from:from + index(report(from:), ' %') - 2), *) told
      told = told/100
   end function told_of

   function sized(height) result(text)
      character(*), intent(in) :: height
      character(:), allocatable :: text
      text = '*MATERIAL, NAME=stuff, YOUNG=2e11, DENSITY=7800, POISSON=0.3'//nl// &
         & '*SECTION, NAME=bar, SHAPE=RECTANGLE, WIDTH=0.02, HEIGHT='//height//nl
   end function sized

   function beam(height, options) result(text)
      character(*), intent(in) :: height, options
      character(:), allocatable :: text
      text = sized(height)//'*BEAM, NAME=bar, MATERIAL=stuff, SECTION=bar, LENGTH=1'//options//nl
   end function beam

   !> A beam of two members.
   function frame(height, option) result(text)
      character(*), intent(in) :: height, option
      character(:), allocatable :: text
      text = sized(height)//'*FRAME, NAME=bar, '//option//nl//'*NODE'//nl//' 1, 0, 0, start'//nl//' 2, 0.5, 0'//nl// &
         & ' 3, 1, 0, end'//nl//'*ELEMENT, ELSET=all'//nl//' 1, 1, 2'//nl//' 2, 2, 3'//nl// &
         & '*BEAM SECTION, ELSET=all, MATERIAL=stuff, SECTION=bar'//nl
   end function frame

end program test_short_beams
