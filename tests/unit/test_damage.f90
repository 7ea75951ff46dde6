!> Damaged and foreign files: of a checkpoint in which one bit has changed nothing is read, or what was written; files of which a
!> part is elsewhere are not read; of a motion whose lists do not fit nothing is drawn, and nothing crashes.
program test_damage
   use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_quiet_nan, ieee_value
   use hdf5, only: hid_t, hsize_t, h5dclose_f, h5dcreate_f, h5lcreate_external_f, h5lcreate_soft_f, h5p_dataset_create_f, &
      & h5pclose_f, h5pcreate_f, h5pset_external_f, h5pset_virtual_f, h5sclose_f, h5screate_simple_f, h5t_native_double
   use limber_commands_drawing, only: drawing_request_type, export_motion
   use limber_commands_run, only: run_deck
   use limber_base_error, only: error_type, status_deck
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text
   use limber_output_checkpoint, only: checkpoint_type, write_checkpoint, read_checkpoint
   use limber_output_hdf5, only: create_file, create_group, open_file, reopen_file, close_file, write_attribute, &
      & write_dataset
   use limber_output_hdf5_read, only: read_attribute
   use limber_output_history_reader, only: history_reader_type
   use testing, only: check, check_no_error, make_folder, finish
   implicit none
   character(:), allocatable :: folder
   real(wp), parameter :: reals(*) = [1.5_wp, -2.25_wp, 3.125e-7_wp, 4.0e9_wp, 5.5_wp, -6.5_wp]
   integer, parameter :: integers(*) = [7, -8, 9, 123456, 11]
   character(*), parameter :: nl = new_line('a')
   !> A spring, a joint, a beam in pieces, and one that bends
   character(*), parameter :: deck = '*MATERIAL, NAME=steel, YOUNG=2e11, DENSITY=7800'//nl// &
      & '*SECTION, NAME=round, SHAPE=CIRCLE, DIAMETER=0.01'//nl// &
      & '*BEAM, NAME=arm, MATERIAL=steel, SECTION=round, LENGTH=1, SUPPORT=CLAMPED-FREE, BENDING MODES=1, GEOMETRIC=LINEAR'//nl// &
      & '*BEAM, NAME=rope, MATERIAL=steel, SECTION=round, LENGTH=1, SEGMENTS=2, Y=-1'//nl// &
      & '*JOINT, NAME=hinge, TYPE=REVOLUTE'//nl//' arm.start, ground.origin'//nl// &
      & '*SPRING, NAME=spring, STIFFNESS=10'//nl//' arm.end, rope.end'//nl// &
      & '*POINT MASS, NAME=mass, MASS=1, X=3'//nl// &
      & '*DYNAMICS, END=1e-3, OUTPUTS=2'//nl//'*OUTPUT, MOTION=YES'//nl//' x(arm.end)'//nl
   character(*), parameter :: text_of_deck = '*GRAVITY'//nl//'*POINT MASS'
   !> Whether something was read
   logical :: is_read
   call make_folder('damage', folder)
   call test_flips()
   call test_elsewhere()
   call test_motion()
   call execute_command_line('rm -rf '//folder)
   call finish()

contains

   subroutine test_flips()
      type(snapshot_type) :: snapshot
      type(checkpoint_type) :: checkpoint
      type(error_type), allocatable :: error
      character(1), allocatable :: bytes(:)
      character(:), allocatable :: path
      character(1) :: kept
      integer :: i, refused, same
      logical :: unchanged
      path = folder//'/flipped.h5'
      checkpoint = checkpoint_type(program='limber 0', run='20260731-1', deck=text_of_deck, &
         & samples=17, time=0.125_wp)
      snapshot%reals = reals
      snapshot%integers = integers
      snapshot%real_count = size(reals)
      snapshot%integer_count = size(integers)
      call write_checkpoint(path, checkpoint, snapshot, error)
      call check_no_error(error, 'written')
      call check(is_same(path), 'what was written is read')
      call get_bytes(path, bytes)
      refused = 0
      same = 0
      ! Each third byte: an odd number meets all parts of all fields
      do i = 1, size(bytes), 3
         kept = bytes(i)
         bytes(i) = achar(ieor(iachar(kept), ishft(1, mod(i, 8))))
         call put_bytes(path, bytes)
         unchanged = is_same(path)
         if (unchanged) same = same + 1
         if (.not. is_read) refused = refused + 1
         if (is_read .neqv. unchanged) call check(.false., 'byte '//as_text(i)//' of '//as_text(size(bytes)))
         bytes(i) = kept
      end do
      print '(a)', as_text(size(bytes))//' bytes: '//as_text(refused)//' changes refused, '//as_text(same)//' without an effect'
      call check(refused > 100, 'changes are refused')
   end subroutine test_flips

   !> Whether what is read is what was written; whether anything is.
   logical function is_same(path)
      character(*), intent(in) :: path
      type(snapshot_type) :: snapshot
      type(checkpoint_type) :: found
      type(error_type), allocatable :: error
      call read_checkpoint(path, found, snapshot, error)
      is_read = .not. allocated(error)
      is_same = .false.
      if (.not. is_read) return
      if (size(snapshot%reals) /= size(reals) .or. size(snapshot%integers) /= size(integers)) return
      is_same = all(abs(snapshot%reals - reals) <= 0.0_wp) .and. all(snapshot%integers == integers) .and. found%samples == 17 &
         & .and. abs(found%time - 0.125_wp) <= 0.0_wp .and. found%program == 'limber 0' .and. found%run == '20260731-1' .and. &
         & found%deck == text_of_deck
   end function is_same

   subroutine get_bytes(path, bytes)
      character(*), intent(in) :: path
      character(1), allocatable, intent(out) :: bytes(:)
      integer :: unit, length
      open (newunit=unit, file=path, access='stream', form='unformatted', status='old', action='read')
      inquire (unit=unit, size=length)
      allocate (bytes(length))
      read (unit) bytes
      close (unit)
   end subroutine get_bytes

   subroutine put_bytes(path, bytes)
      character(*), intent(in) :: path
      character(1), intent(in) :: bytes(:)
      integer :: unit
      open (newunit=unit, file=path, access='stream', form='unformatted', status='replace', action='write')
      write (unit) bytes
      close (unit)
   end subroutine put_bytes

   !> Links to other files and within, external storage, virtual datasets: all are refused before anything of them is read.
   subroutine test_elsewhere()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      integer(hid_t) :: file, space, list, dataset
      character(:), allocatable :: path, report
      integer :: kind, status, unit
      open (newunit=unit, file=folder//'/motion.inp', access='stream', action='write', status='replace')
      write (unit) deck
      close (unit)
      call run_deck(folder//'/motion.inp', folder//'/motion.h5', .true., .true., report, error)
      call check_no_error(error, 'a run with a motion')
      path = folder//'/elsewhere.h5'
      do kind = 1, 4
         if (kind < 4) then
            call execute_command_line('cp '//folder//'/motion.h5 '//path)
            call reopen_file(path, file, error)
         else
            ! Not in a file of the format that limber writes
            call create_file(path, .true., file, error, checked=.true.)
            call create_group(file, '/channels', error)
         end if
         call check_no_error(error, 'reopened')
         call h5screate_simple_f(1, [3_hsize_t], space, status)
         call h5pcreate_f(h5p_dataset_create_f, list, status)
         select case (kind)
         case (1); call h5lcreate_external_f(folder//'/motion.h5', '/time', file, '/channels/stolen', status)
         case (2); call h5lcreate_soft_f('/time', file, '/channels/stolen', status)
         case (3); call h5pset_external_f(list, folder//'/motion.inp', 0_hsize_t, 24_hsize_t, status)
         case (4); call h5pset_virtual_f(list, space, folder//'/motion.h5', '/time', space, status)
         end select
         if (kind > 2) then
            call h5dcreate_f(file, '/channels/stolen', h5t_native_double, space, dataset, status, list)
            call h5dclose_f(dataset, status)
         end if
         call check(status >= 0, 'made '//as_text(kind))
         call h5pclose_f(list, status)
         call h5sclose_f(space, status)
         call close_file(path, file, error)
         call reader%open(path, error)
         call check(allocated(error), 'refused '//as_text(kind))
         if (allocated(error)) call check(error%status == status_deck .and. &
            & index(error%message, 'leads elsewhere') + index(error%message, 'in another file') > 0, error%message)
         call reader%close()
      end do
   end subroutine test_elsewhere

   !> Each list of the motion with other numbers, and with fewer and more of them.
   subroutine test_motion()
      character(*), parameter :: lists(*) = [character(20) :: 'body_widths', 'place_bodies', 'shapes', 'stroke_places', &
         & 'stroke_widths', 'stroke_closed', 'connection_places', 'connection_angles', 'connection_radii']
      character(*), parameter :: texts(*) = [character(20) :: 'body_names', 'place_names', 'connection_names', 'connection_types']
      character(*), parameter :: tables(*) = [character(20) :: 'coordinates', 'places']
      real(wp), allocatable :: values(:), wild(:), table(:, :), turned(:, :)
      character(:), allocatable :: text
      type(error_type), allocatable :: error
      type(history_reader_type) :: reader
      integer :: i, k, at, refused
      call check(drawn_with('', [real(wp) ::]) == 0, 'the motion as it is')
      wild = [-1.0_wp, 0.0_wp, 0.5_wp, 3.0_wp, 1.0e6_wp, 2147483647.0_wp, 1.0e19_wp, -1.0e300_wp, &
         & ieee_value(1.0_wp, ieee_quiet_nan), ieee_value(1.0_wp, ieee_positive_inf)]
      refused = 0
      do i = 1, size(lists)
         call reader%open(folder//'/motion.h5', error)
         call reader%read_numbers('/motion/'//trim(lists(i)), values, error)
         call check_no_error(error, lists(i))
         call reader%close()
         if (allocated(error)) cycle
         do at = 1, size(values), max(1, size(values) - 1)
            do k = 1, size(wild)
               refused = refused + drawn_with(trim(lists(i)), [values(:at - 1), wild(k), values(at + 1:)])
            end do
         end do
         call check(drawn_with(trim(lists(i)), values(2:)) == 1, trim(lists(i))//' too short')
         call check(drawn_with(trim(lists(i)), [values, 1.0_wp]) == 1, trim(lists(i))//' too long')
         call check(drawn_with(trim(lists(i)), [real(wp) ::]) == 1, trim(lists(i))//' empty')
      end do
      print '(a)', as_text(refused)//' lists with a wild number refused'
      call check(refused > 90, 'wild numbers are refused')
      do i = 1, size(texts)
         call reader%open(folder//'/motion.h5', error)
         call reader%read_text('/motion/'//trim(texts(i)), text, error)
         call reader%close()
         call check(drawn_with(trim(texts(i)), text='') == 1, trim(texts(i))//' empty')
         call check(drawn_with(trim(texts(i)), text=text//'more'//nl) == 1, trim(texts(i))//' too long')
         call check(drawn_with(trim(texts(i)), text=repeat('SEGMENTS'//nl, 1000)) == 1, trim(texts(i))//' far too long')
      end do
      do i = 1, size(tables)
         call reader%open(folder//'/motion.h5', error)
         call reader%read_table('/motion/'//trim(tables(i)), table, error)
         call reader%close()
         turned = transpose(table)
         call check(drawn_with(trim(tables(i)), table=turned) == 1, trim(tables(i))//' turned')
         call check(drawn_with(trim(tables(i)), table=table(:, 2:)) == merge(0, 1, i == 1), trim(tables(i))//' too short')
         table(1, 1) = ieee_value(1.0_wp, ieee_quiet_nan)
         call check(drawn_with(trim(tables(i)), table=table) == 1, trim(tables(i))//' without a number')
         table(1, 1) = 1.0e200_wp
         call check(drawn_with(trim(tables(i)), table=table) == 1, trim(tables(i))//' too far')
      end do
   end subroutine test_motion

   !> Draws the motion with another list in it: 0 if that is done, 1 if it is refused with status 2.
   integer function drawn_with(name, values, text, table) result(refused)
      character(*), intent(in) :: name
      real(wp), intent(in), optional :: values(:), table(:, :)
      character(*), intent(in), optional :: text
      type(error_type), allocatable :: error
      type(drawing_request_type) :: choice
      integer(hid_t) :: file
      character(:), allocatable :: path
      integer :: unit
      path = folder//'/other.h5'
      call execute_command_line('cp '//folder//'/motion.h5 '//path)
      if (name /= '') then
         call reopen_file(path, file, error)
         if (present(text)) then
            call write_dataset(file, '/motion/'//name, text, error)
         else if (present(table)) then
            call write_dataset(file, '/motion/'//name, table, error)
            if (name == 'places') call write_attribute(file, '/motion/places', 'units', 'm', error)
         else
            call write_dataset(file, '/motion/'//name, values, error)
         end if
         call close_file(path, file, error)
      end if
      open (newunit=unit, status='scratch')
      choice%deflection = 2.0_wp
      call export_motion(path, choice, unit, error)
      close (unit)
      refused = 0
      if (.not. allocated(error)) return
      refused = 1
      call check(error%status == status_deck .and. index(error%message, 'motion') > 0, name//': '//error%message)
   end function drawn_with

end program test_damage
