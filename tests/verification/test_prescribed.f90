!> Bodies of known motion and what they hold: their driving forces against Newton and Euler, all answers against those with all
!> unknowns and multipliers, and the slider-crank with what it needs against that of three whole bodies. Usage, in tests/:
!> test_prescribed RESULT_FILE
program test_prescribed
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, newline
   use limber_commands_run, only: run_deck
   use limber_scene_first_scene, only: read_scene
   use limber_scene_scene, only: scene_type
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_changed, channel
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   character(*), parameter :: held = 'verification/held_bodies.inp'
   character(256) :: results

   call get_command_argument(1, results)
   call check_held()
   call check_slider_crank('EXACT', ['FUNCTIONS=7, STRAIN FUNCTIONS=3'], ['FUNCTIONS=7, STRAIN FUNCTIONS=3'])
   call check_slider_crank('K_G', ['FUNCTIONS=7, STRAIN FUNCTIONS=3'], ['BENDING MODES=3, AXIAL MODES=1 '])
   call check_all_driven()
   call finish()

contains

   !> The driving forces of the hub and of the stud as free bodies, and everything with and without elimination.
   subroutine check_held()
      character(*), parameter :: integrators(4) = [character(10) :: 'ADAMS', 'RADAU', 'ALPHA', 'CONSERVING']
      character(*), parameter :: names(17) = [character(20) :: 'x_bob_origin', 'y_bob_origin', 'x_cart_origin', 'y_cart_origin', &
         & 'x_bead', 'bend', 'force_x_fix', 'moment_fix', 'force_y_pin', 'moment_rail', 'moment_track', &
         & 'force_x_wire', 'moment_root', 'force_push', 'fx', 'torque', 'work']
      character(24) :: old(3), new(3)
      type(history_reader_type) :: with, without
      real(wp), allocatable :: a(:), b(:)
      integer :: i, k
      do i = 1, size(integrators)
         old = [character(24) :: 'INTEGRATOR=ADAMS', 'TOLERANCE=1e-10', 'LARGEST TURN=9']
         new = [character(24) :: 'INTEGRATOR='//trim(integrators(i)), 'TOLERANCE=1e-10', 'LARGEST TURN=9']
         if (i > 1) new(2) = 'TOLERANCE=1e-6'
         call run_changed(held, trim(results), old, new, with)
         new(3) = 'ELIMINATION=NO'
         call run_changed(held, trim(results)//'.whole', old, new, without)
         do k = 1, size(names)
            a = channel(with, trim(names(k)))
            b = channel(without, trim(names(k)))
            call check_close(maxval(abs(a - b))/maxval(abs(b)), 0.0_wp, merge(1.0e-6_wp, 1.0e-4_wp, i == 1), &
               & trim(integrators(i))//': '//trim(names(k))//' without unknowns and with them')
         end do
         if (i == 1) call check_driving(with)
         call with%close()
         call without%close()
      end do
   end subroutine check_held

   subroutine check_driving(reader)
      type(history_reader_type), intent(inout) :: reader
      real(wp), parameter :: mass = 2.0_wp, inertia = 0.1_wp, gravity = 9.81_wp, stud = 0.5_wp
      real(wp), allocatable :: t(:), force(:, :), c(:, :), tip(:, :), joint(:, :), turning(:)
      t = channel(reader, 'clock')
      allocate (force(2, size(t)), c(2, size(t)), tip(2, size(t)), joint(2, size(t)), turning(size(t)))
      force(1, :) = mass*channel(reader, 'ax_hub_centre')
      force(2, :) = mass*(channel(reader, 'ay_hub_centre') + gravity)
      ! The weld pulls on the plate with `joint`, on the hub against it
      joint(1, :) = channel(reader, 'plate_x')
      joint(2, :) = channel(reader, 'plate_y')
      call check_close(maxval(abs(channel(reader, 'fx') - force(1, :) - joint(1, :))), 0.0_wp, 1.0e-10_wp, 'hub: force along x')
      call check_close(maxval(abs(channel(reader, 'fy') - force(2, :) - joint(2, :))), 0.0_wp, 1.0e-10_wp, 'hub: force along y')
      c(1, :) = channel(reader, 'centre_x')
      c(2, :) = channel(reader, 'centre_y')
      tip(1, :) = channel(reader, 'tip_x')
      tip(2, :) = channel(reader, 'tip_y')
      turning = -0.4_wp*sin(2*t)
      call check_close(maxval(abs(channel(reader, 'torque') - inertia*turning - cross(c, force) - cross(tip, joint) &
         & - channel(reader, 'plate_moment'))), 0.0_wp, 1.0e-10_wp, 'hub: torque')
      call check_close(maxval(abs(channel(reader, 'sx') + stud*4*cos(2*t))), 0.0_wp, 1.0e-11_wp, 'stud: force along x')
      call check_close(maxval(abs(channel(reader, 'sy') + stud*9*sin(3*t) - stud*gravity)), 0.0_wp, 1.0e-11_wp, &
         & 'stud: force along y')
      call check(maxval(abs(channel(reader, 'torque'))) > 1.0_wp, 'hub: there is a torque')
   end subroutine check_driving

   pure function cross(a, b) result(c)
      real(wp), intent(in) :: a(:, :), b(:, :)
      real(wp) :: c(size(a, 2))
      c = a(1, :)*b(2, :) - a(2, :)*b(1, :)
   end function cross

   !> Must agree to 1e-10 of the range, with many unknowns fewer.
   subroutine check_slider_crank(name, old, new)
      character(*), intent(in) :: name, old(:), new(:)
      character(*), parameter :: channels(3) = [character(22) :: 'deflection_over_length', 'slider_x', 'rod_angle']
      character(40) :: from(4), to(4)
      type(history_reader_type) :: few, all
      real(wp), allocatable :: a(:), b(:)
      integer :: k
      from = [character(40) :: 'turns = 2', 'OUTPUTS=838', 'TOLERANCE=1e-8', old(1)]
      to = [character(40) :: 'turns = 0.15', 'OUTPUTS=20', 'TOLERANCE=1e-11', new(1)]
      call run_changed('../input/slider_crank_prescribed.inp', trim(results), from, to, few)
      call run_changed('../input/slider_crank_three_bodies.inp', trim(results)//'.whole', from, to, all)
      do k = 1, size(channels)
         a = channel(few, trim(channels(k)))
         b = channel(all, trim(channels(k)))
         call check_close(maxval(abs(a - b))/(maxval(b) - minval(b)), 0.0_wp, 1.0e-10_wp, &
            & name//': '//trim(channels(k))//' with what is needed and with three whole bodies')
      end do
      call few%close()
      call all%close()
      call count_unknowns(trim(results)//'.inp', 4)
      call count_unknowns(trim(results)//'.whole.inp', 18)
   end subroutine check_slider_crank

   subroutine count_unknowns(path, expected)
      character(*), intent(in) :: path
      integer, intent(in) :: expected
      type(scene_type) :: scene
      type(error_type), allocatable :: error
      call read_scene(path, scene, error)
      call check_no_error(error, 'unknowns of '//path)
      if (allocated(error)) return
      call check(scene%system%tree%unknowns == expected, path//' has '//as_text(expected)//' unknowns, not '// &
         & as_text(scene%system%tree%unknowns))
   end subroutine count_unknowns

   !> A scene that is driven wholly: nothing is integrated but the work, which must be what the energy changes by.
   subroutine check_all_driven()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp), allocatable :: energy(:), work(:), t(:)
      integer :: unit
      open (newunit=unit, file=trim(results)//'.inp', action='write', status='replace')
      write (unit, '(a)') '*GRAVITY'//newline//'*RIGID BODY, NAME=arm, MASS=2, INERTIA=0.3, CENTRE X=0.4'//newline// &
         & '*MOTION, NAME=m, BODY=arm'//newline//' sin(3*t), 0, 2*sin(5*t)'//newline// &
         & '*DYNAMICS, END=4, TOLERANCE=1e-9, INTEGRATOR=ADAMS'//newline//'*OUTPUT'//newline// &
         & ' energy = kinetic_energy(system) + potential_energy(system), work = work(system), angle(arm), clock = t'
      close (unit)
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
      call check_no_error(error, 'all driven')
      if (allocated(error)) return
      call reader%open(trim(results), error)
      t = channel(reader, 'clock')
      energy = channel(reader, 'energy')
      work = channel(reader, 'work')
      call check_close(maxval(abs(energy - energy(1) - work))/maxval(abs(energy - energy(1))), 0.0_wp, 1.0e-7_wp, &
         & 'all driven: work and change of energy')
      call check_close(maxval(abs(channel(reader, 'angle_arm') - 2*sin(5*t))), 0.0_wp, 1.0e-13_wp, 'all driven: angle')
      call reader%close()
   end subroutine check_all_driven

end program test_prescribed
