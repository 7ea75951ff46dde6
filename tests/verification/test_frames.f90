!> Frames near their critical loads, with no option but material and section: deflections at rest and first frequencies against
!> finite elements with consistent masses and geometric stiffness, 40 for each member. Usage, in tests/: test_frames RESULT_FILE
program test_frames
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use limber_analysis_run, only: run_deck
   use limber_output_history_reader, only: history_reader_type
   use runs, only: channel
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   character(*), parameter :: nl = new_line('a')
   character(*), parameter :: stuff = '*MATERIAL, NAME=steel, YOUNG=2.1e11, DENSITY=7850'//nl// &
      & '*SECTION, NAME=tube, SHAPE=TUBE, DIAMETER=0.06, THICKNESS=0.004'//nl
   !> Two columns of 3 m and a girder of 4 m
   character(*), parameter :: portal = '*NODE'//nl//' 1, 0, 0, left'//nl//' 2, 0, 3, knee'//nl//' 3, 4, 3, other'//nl// &
      & ' 4, 4, 0, right'//nl//'*ELEMENT'//nl//' 1, 1, 2'//nl//' 2, 2, 3'//nl//' 3, 4, 3'//nl
   character(*), parameter :: storey = '*NODE'//nl//' 5, 0, 6, top'//nl//' 6, 4, 6, end'//nl//'*ELEMENT'//nl//' 4, 2, 5'//nl// &
      & ' 5, 5, 6'//nl//' 6, 3, 6'//nl
   character(*), parameter :: angle = '*NODE'//nl//' 1, 0, 0, left'//nl//' 2, 0, 3, knee'//nl//' 3, 2, 3, other'//nl// &
      & '*ELEMENT'//nl//' 1, 1, 2'//nl//' 2, 2, 3'//nl
   character(*), parameter :: hinges = '*GROUND'//nl//' far, 4, 0'//nl//'*JOINT, NAME=first, TYPE=REVOLUTE'//nl// &
      & ' frame.left, ground.origin'//nl//'*JOINT, NAME=second, TYPE=REVOLUTE'//nl//' frame.right, ground.far'//nl
   character(*), parameter :: wall = '*JOINT, NAME=first, TYPE=WELD'//nl//' frame.left, ground.origin'//nl
   character(*), parameter :: walls = '*GROUND'//nl//' far, 4, 0'//nl//wall//'*JOINT, NAME=second, TYPE=WELD'//nl// &
      & ' frame.right, ground.far'//nl
   character(256) :: results

   call get_command_argument(1, results)
   call check_critical()
   call finish()

contains

   !> Half and 0.9 of the critical load.
   subroutine check_critical()
      call judge('portal', portal//walls, ['knee ', 'other'], 'knee', 44240.0_wp, 1.0e-4_wp, [2.630258e-4_wp, 1.309565e-3_wp], &
         & [22.85546_wp, 10.26346_wp])
      call judge('portal on hinges', portal//hinges, ['knee ', 'other'], 'knee', 10790.0_wp, 1.0e-4_wp, &
         & [2.771080e-4_wp, 1.384523e-3_wp], [10.36357_wp, 4.630247_wp])
      call judge('braced portal', portal//'*ELEMENT'//nl//' 4, 1, 3'//nl//walls, ['knee ', 'other'], 'place', 166400.0_wp, &
         & 1.0e-4_wp, [6.055185e-4_wp, 1.279201e-3_wp], [70.32099_wp, 41.81769_wp])
      call judge('two storeys', portal//storey//walls, ['top', 'end'], 'top', 29010.0_wp, 1.0e-4_wp, &
         & [5.323976e-4_wp, 2.615616e-3_wp], [10.83003_wp, 5.017357_wp])
      call judge('L', angle//wall, ['knee'], 'knee', 15960.0_wp, 1.0e-3_wp, [4.89922e-3_wp, 2.431281e-2_wp], &
         & [13.12996_wp, 5.900609_wp])
   end subroutine check_critical

   !> A frame under loads on its corners and a small one across.
   subroutine judge(name, parts, loaded, pushed, critical, side, deflection, frequency)
      !> What stands below *FRAME; the corners that are loaded, and the one (or the middle of member 1) that is pushed
      character(*), intent(in) :: name, parts, loaded(:), pushed
      !> Critical load, and the part of it that pushes; answers at 0.5 and 0.9 of it [rad/s]
      real(wp), intent(in) :: critical, side, deflection(2), frequency(2)
      type(history_reader_type) :: reader
      real(wp), allocatable :: x(:)
      real(wp) :: found(1)
      character(:), allocatable :: scene, warnings
      integer :: i, k
      do i = 1, 2
         scene = stuff//'*FRAME, NAME=frame, MATERIAL=steel, SECTION=tube'//nl//' place, 1, 1.5'//nl//parts
         do k = 1, size(loaded)
            scene = scene//'*FORCE, NAME=load-'//as_text(k)//', POINT=frame.'//trim(loaded(k))//nl//' 0, '// &
               & as_text(-critical*merge(0.5_wp, 0.9_wp, i == 1), 17)//nl
         end do
         scene = scene//'*FORCE, NAME=push, POINT=frame.'//pushed//nl//' '//as_text(side*critical, 17)//', 0'//nl// &
            & '*STATICS, INCREMENTS=10'//nl//'*MODES, NUMBER=1'//nl//'*OUTPUT'//nl//' u = x(frame.'//pushed//')'//nl
         call run_scene(scene, reader, warnings)
         allocate (x, source=channel(reader, 'u'))
         call first_frequency(reader, found)
         print '(a,i2,2es10.2)', name, i, x(size(x))/deflection(i) - 1, found/frequency(i) - 1
         call check_close(x(size(x))/deflection(i), 1.0_wp, 1.0e-2_wp, name//': deflection')
         call check_close(found(1)/frequency(i), 1.0_wp, 1.0e-2_wp, name//': frequency')
         call check(warnings == '', name//': no warning: '//warnings)
         call reader%close()
         deallocate (x)
      end do
   end subroutine judge

   !> Runs a scene.
   subroutine run_scene(scene, reader, warnings)
      character(*), intent(in) :: scene
      type(history_reader_type), intent(out) :: reader
      character(:), allocatable, intent(out) :: warnings
      type(error_type), allocatable :: error
      integer :: unit
      open (newunit=unit, file=trim(results)//'.inp', access='stream', action='write', status='replace')
      write (unit) scene
      close (unit)
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., warnings, error)
      call check_no_error(error, scene)
      if (allocated(error)) error stop 1
      if (index(warnings, 'warning') == 0) warnings = ''
      call reader%open(trim(results), error)
      call check_no_error(error, scene)
   end subroutine run_scene

   !> Of *MODES [rad/s].
   subroutine first_frequency(reader, found)
      type(history_reader_type), intent(inout) :: reader
      real(wp), intent(out) :: found(1)
      real(wp), allocatable :: values(:)
      type(error_type), allocatable :: error
      call reader%read_numbers('/modes/modes/frequency', values, error)
      call check_no_error(error, 'frequencies')
      found = 0.0_wp
      if (.not. allocated(error)) found = values(1)
   end subroutine first_frequency

end program test_frames
