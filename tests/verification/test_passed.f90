!> Forces at samples of RADAU within steps that pass over vibrations: a mast on a cart that a smooth law moves. The driving force
!> is the
!> rate of the momentum, and that of a stiff mast the mass times the acceleration of the law.
!> Usage, in tests/: test_passed RESULT_FILE
program test_passed
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_text, channel
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   character(*), parameter :: nl = new_line('a')
   character(256) :: results

   call get_command_argument(1, results)
   call check_mast('7', '1e-6', 9.0e-3_wp)
   call check_mast('14', '1e-6', 9.0e-3_wp)
   call check_mast('14', '1e-4', 9.0e-3_wp)
   call check_blocks('1e-4', 2.0e-3_wp)
   call finish()

contains

   !> A mast with a mass at its end, moved by 0.5 m in 5 s. The law begins with a jerk of 0.24 m/s^3: the first vibration, at 180
   !> rad/s, has 0.7 % of the force.
   subroutine check_mast(functions, tolerance, most)
      character(*), intent(in) :: functions, tolerance
      !> Error in parts of the largest force
      real(wp), intent(in) :: most
      real(wp), parameter :: pi = acos(-1.0_wp)
      real(wp), parameter :: mass = 1.0_wp + 3.0_wp + 7850.0_wp*0.7_wp*0.25_wp*pi*(0.04_wp**2 - 0.034_wp**2)
      call check_scene('*MATERIAL, NAME=steel, YOUNG=2.1e11, DENSITY=7850'//nl// &
         & '*SECTION, NAME=s, SHAPE=TUBE, DIAMETER=0.04, THICKNESS=0.003'//nl//'*RIGID BODY, NAME=base, MASS=1'//nl// &
         & '*BEAM, NAME=mast, MATERIAL=steel, SECTION=s, LENGTH=0.7, FUNCTIONS='//functions//nl//'*MASS'//nl//' end, 3'//nl// &
         & '*DAMPING, BODY=mast, RATIO=0.03'//nl//'*JOINT, NAME=guide, TYPE=TRANSLATIONAL, TURN=0, ANGLE=90 deg'//nl// &
         & ' base.origin, ground.origin'//nl//'*JOINT, NAME=foot, TYPE=WELD, TURN=0'//nl//' mast.start, base.origin'//nl, &
         & tolerance, mass, most, 'a mast with '//functions//' functions, '//tolerance)
   end subroutine check_mast

   !> Rigid blocks behind a spring of 1e9 N/m: the force in it is that of the motion, too.
   subroutine check_blocks(tolerance, most)
      character(*), intent(in) :: tolerance
      real(wp), intent(in) :: most
      call check_scene('*POINT MASS, NAME=base, MASS=1'//nl//'*POINT MASS, NAME=load, MASS=3, Y=0.5'//nl// &
         & '*JOINT, NAME=guide, TYPE=POINT ON LINE, ANGLE=90 deg'//nl//' base, ground'//nl// &
         & '*JOINT, NAME=rail, TYPE=POINT ON LINE, ANGLE=90 deg'//nl//' load, ground'//nl// &
         & '*SPRING, NAME=stiff, STIFFNESS=1e9, LENGTH=0.5, DAMPING=1e3'//nl//' base, load'//nl, tolerance, 4.0_wp, most, &
         & 'blocks behind a stiff spring, '//tolerance)
   end subroutine check_blocks

   !> The force of the driver of `base` against mass times acceleration; nothing is told of forces that are right.
   subroutine check_scene(scene, tolerance, mass, most, name)
      character(*), intent(in) :: scene, tolerance, name
      real(wp), intent(in) :: mass, most
      real(wp), allocatable :: force(:), t(:), expected(:)
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call run_text(scene//'*DRIVER, NAME=motor, TYPE=Y, POINT=base.origin'//nl//' 0.5*smoothstep(t/5)'//nl// &
         & '*DYNAMICS, END=6, OUTPUTS=600, INTEGRATOR=RADAU, TOLERANCE='//tolerance//nl// &
         & '*OUTPUT'//nl//' force(motor), clock = t'//nl, trim(results), report, error)
      call check_no_error(error, name)
      call check(index(report, 'force_motor') == 0, name//': no warning of the force')
      call reader%open(trim(results), error)
      call check_no_error(error, name)
      allocate (force, source=channel(reader, 'force_motor'))
      allocate (t, source=min(1.0_wp, channel(reader, 'clock')/5))
      call reader%close()
      ! smoothstep is 10 s^3 - 15 s^4 + 6 s^5
      allocate (expected, source=mass*0.5_wp/25*(60*t - 180*t**2 + 120*t**3))
      call check_close(maxval(abs(force - expected))/maxval(abs(expected)), 0.0_wp, most, name//': force of the driver')
   end subroutine check_scene

end program test_passed
