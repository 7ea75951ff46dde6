!> Envelopes of internal forces: places where something acts lie between the elements, and the tops of smooth fields, too.
!> References: closed forms of the theory of beams. Usage, in tests/: test_envelopes RESULT_FILE
program test_envelopes
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_text
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   character(*), parameter :: nl = new_line('a')
   character(*), parameter :: stuff = '*MATERIAL, NAME=m, YOUNG=2e11, DENSITY=7800'//nl// &
      & '*SECTION, NAME=a, SHAPE=RECTANGLE, WIDTH=0.05, HEIGHT=0.02'//nl
   character(*), parameter :: ways(4) = [character(24) :: 'GEOMETRIC=EXACT', 'SEGMENTS=3', 'GEOMETRIC=K_G', &
      & 'GEOMETRIC=LINEAR']
   !> Second moment over the distance of the extreme fibres
   real(wp), parameter :: resistance = 0.05_wp*0.02_wp**2/6
   character(256) :: results

   call get_command_argument(1, results)
   call check_inner()
   call check_frame()
   call check_parabola()
   call check_spread()
   call check_step()
   call check_slide()
   call finish()

contains

   !> A beam that is held at 1.03 of 2, with a force at 1.17.
   subroutine check_inner()
      integer :: i
      do i = 1, size(ways)
         call run(stuff//'*GROUND'//nl//' p, 1.03, 0'//nl//'*BEAM, NAME=b, MATERIAL=m, SECTION=a, LENGTH=2, '//trim(ways(i))// &
            & nl//' p, 1.03'//nl//' q, 1.17'//nl//'*JOINT, NAME=j, TYPE=WELD'//nl//' b.p, ground.p'//nl// &
            & '*FORCE, NAME=f, POINT=b.q'//nl//' 0, -1000'//nl//'*STATICS'//nl//'*OUTPUT, ENVELOPE=b'//nl)
         call expect('bending_moment', [-140.0_wp, 0.0_wp], 1.0e-3_wp, trim(ways(i))//' held within')
         call expect('shear_force', [-1000.0_wp, 0.0_wp], 1.0e-3_wp, trim(ways(i))//' held within')
         call expect('stress_top', [0.0_wp, 140/resistance], 1.0e-3_wp, trim(ways(i))//' held within')
      end do
   end subroutine check_inner

   !> The same as members of a frame.
   subroutine check_frame()
      character(10), parameter :: large(2) = [character(10) :: 'LARGE=NO', 'LARGE=YES']
      integer :: i
      do i = 1, size(large)
         call run(stuff//'*GROUND'//nl//' p, 1.03, 0'//nl//'*FRAME, NAME=b, MATERIAL=m, SECTION=a, '//trim(large(i))//nl// &
            & ' p, 1, 1.03'//nl//' q, 1, 1.17'//nl//'*NODE'//nl//' 1, 0, 0'//nl//' 2, 2, 0'//nl//' 3, 2, 1'//nl//'*ELEMENT'//nl// &
            & ' 1, 1, 2'//nl//' 2, 2, 3'//nl//'*JOINT, NAME=j, TYPE=WELD'//nl//' b.p, ground.p'//nl//'*FORCE, NAME=f, POINT=b.q'// &
            & nl//' 0, -1000'//nl//'*STATICS'//nl//'*OUTPUT, ENVELOPE=b'//nl)
         call expect('bending_moment', [-140.0_wp, 0.0_wp], 1.0e-3_wp, 'frame '//trim(large(i))//' held within')
         call expect('stress_top', [0.0_wp, 140/resistance], 1.0e-3_wp, 'frame '//trim(large(i))//' held within')
      end do
   end subroutine check_frame

   !> A propped cantilever under an even load q on the length L: q L^2/8 at the root, 9 q L^2/128 at 5 L/8.
   subroutine check_parabola()
      integer :: i
      do i = 1, size(ways)
         call run(stuff//'*GROUND'//nl//' p, 0, 0'//nl//' o, 2, 0'//nl//'*BEAM, NAME=b, MATERIAL=m, SECTION=a, LENGTH=2, '// &
            & trim(ways(i))//trim(merge(', SUPPORT=CLAMPED-ROLLER', '                        ', i > 2))//nl// &
            & '*JOINT, NAME=j, TYPE=WELD'//nl//' b.start, ground.p'//nl// &
            & '*JOINT, NAME=k, TYPE=POINT ON LINE'//nl//' b.end, ground.o'//nl//'*DISTRIBUTED LOAD, NAME=d, BODY=b'//nl// &
            & ' 0, -50'//nl//'*STATICS'//nl//'*OUTPUT, ENVELOPE=b'//nl)
         call expect('bending_moment', 200.0_wp*[-1.0_wp/8, 9.0_wp/128], 3.0e-3_wp, trim(ways(i))//' propped')
         call expect('shear_force', [-5.0_wp/8, 3.0_wp/8]*100, 3.0e-3_wp, trim(ways(i))//' propped')
      end do
   end subroutine check_parabola

   !> A beam on two pins with a load of 500 for each length from 0.31 to 0.72 of 2: the moment is largest where no shear is left.
   subroutine check_spread()
      real(wp), parameter :: q = 500.0_wp, a = 0.31_wp, b = 0.72_wp, l = 2.0_wp, right = q*(b - a)*0.5_wp*(a + b)/l, &
         & left = q*(b - a) - right
      real(wp) :: top
      integer :: i
      top = left*(a + left/q) - 0.5_wp*left**2/q
      do i = 1, size(ways), 2
         call run(stuff//'*GROUND'//nl//' p, 0, 0'//nl//' o, 2, 0'//nl//'*BEAM, NAME=b, MATERIAL=m, SECTION=a, LENGTH=2, '// &
            & trim(ways(i))//nl//'*JOINT, NAME=j, TYPE=REVOLUTE'//nl//' b.start, ground.p'//nl// &
            & '*JOINT, NAME=k, TYPE=POINT ON LINE'//nl//' b.end, ground.o'//nl//'*DISTRIBUTED LOAD, NAME=d, BODY=b, '// &
            & 'START=0.31, END=0.72'//nl//' 0, -500'//nl//'*STATICS'//nl//'*OUTPUT, ENVELOPE=b'//nl)
         call expect('bending_moment', [0.0_wp, top], 2.0e-3_wp, trim(ways(i))//' with a load on a part')
         call expect('shear_force', [-left, right], 2.0e-3_wp, trim(ways(i))//' with a load on a part')
      end do
   end subroutine check_spread

   !> A cantilever that is half as high from 0.77 on: the stress is largest right behind the step.
   subroutine check_step()
      call run(stuff//'*SECTION, NAME=thin, SHAPE=RECTANGLE, WIDTH=0.05, HEIGHT=0.01'//nl//'*GROUND'//nl//' p, 0, 0'//nl// &
         & '*BEAM, NAME=b, MATERIAL=m, SECTION=a, LENGTH=2'//nl//'*PROFILE, BODY=b'//nl//' 0.77, thin'//nl// &
         & '*JOINT, NAME=j, TYPE=WELD'//nl//' b.start, ground.p'//nl//'*FORCE, NAME=f, POINT=b.end'//nl//' 0, -1'//nl// &
         & '*STATICS'//nl//'*OUTPUT, ENVELOPE=b'//nl)
      call expect('stress_top', [0.0_wp, 1.23_wp/(0.25_wp*resistance)], 1.0e-3_wp, 'a step of the section')
   end subroutine check_step

   !> A weight of 10 that rests on a slider at 0.7123 of a beam on two pins: F a b/L under it, to the distance of the sections.
   subroutine check_slide()
      call run(stuff//'*GRAVITY, Y=-10'//nl//'*GROUND'//nl//' p, 0, 0'//nl//' o, 2, 0'//nl//' r, 0.7123, 0'//nl// &
         & '*MATERIAL, NAME=light, YOUNG=2e11, DENSITY=1e-6'//nl//'*BEAM, NAME=b, MATERIAL=light, SECTION=a, LENGTH=2'//nl// &
         & '*JOINT, NAME=j, TYPE=REVOLUTE'//nl//' b.start, ground.p'//nl//'*JOINT, NAME=k, TYPE=POINT ON LINE'//nl// &
         & ' b.end, ground.o'//nl//'*POINT MASS, NAME=w, MASS=1, X=0.7123'//nl//'*JOINT, NAME=s, TYPE=SLIDING'//nl// &
         & ' w.origin, b'//nl//'*JOINT, NAME=v, TYPE=POINT ON LINE, ANGLE=pi/2'//nl//' w.origin, ground.r'//nl// &
         & '*STATICS'//nl//'*OUTPUT, ENVELOPE=b'//nl)
      call expect('bending_moment', [0.0_wp, 10*0.7123_wp*(2 - 0.7123_wp)/2], 7.0e-3_wp, 'under a slider')
   end subroutine check_slide

   !> Runs a scene.
   subroutine run(scene)
      character(*), intent(in) :: scene
      character(:), allocatable :: report
      type(error_type), allocatable :: error
      call run_text(scene, trim(results), report, error)
      call check_no_error(error, 'envelope: run')
      if (allocated(error)) call finish()
   end subroutine run

   !> Compares the least and the greatest value along the beam.
   subroutine expect(name, values, tolerance, what)
      character(*), intent(in) :: name, what
      !> Least and greatest, and what they may err by of the larger one
      real(wp), intent(in) :: values(2), tolerance
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: table(:, :)
      call reader%open(trim(results), error)
      if (.not. allocated(error)) call reader%read_table('/bodies/b/envelope/'//name, table, error)
      call check_no_error(error, what//': envelope')
      if (allocated(error)) return
      call check_close(minval(table), values(1), tolerance*maxval(abs(values)), what//', least '//name)
      call check_close(maxval(table), values(2), tolerance*maxval(abs(values)), what//', greatest '//name)
      call check(size(table, 2) >= 80, what//': sections')
      call reader%close()
   end subroutine expect

end program test_envelopes
