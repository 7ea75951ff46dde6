!> The results file: what is put comes back, nothing is lost to a kill or overwritten, and every failure is an error
!> value with its exact text. Files are made in the folder that the environment variable TMPDIR names, or in /tmp.
program test_history
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t, c_long, c_ptr
   use hdf5, only: hid_t, size_t, h5f_obj_all_f, h5fget_obj_count_f
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp, long
   use limber_output_hdf5, only: create_file, close_file, write_attribute
   use limber_output_history, only: history_type
   use limber_output_history_reader, only: history_reader_type
   use limber_output_progress, only: progress_type, progress_line
   use testing, only: check, check_close, check_no_error, check_text, finish, make_folder
   implicit none
   character(:), allocatable :: folder
   character(512) :: argument
   character(*), parameter :: nl = new_line('a')
   !> RLIMIT_FSIZE
   integer(c_int), parameter :: file_size = 1

   interface
      integer(c_int) function getrlimit(resource, limits) bind(c)
         import :: c_int, c_long
         integer(c_int), value :: resource
         integer(c_long), intent(out) :: limits(2)
      end function getrlimit

      integer(c_int) function setrlimit(resource, limits) bind(c)
         import :: c_int, c_long
         integer(c_int), value :: resource
         integer(c_long), intent(in) :: limits(2)
      end function setrlimit

      type(c_ptr) function signal(number, handler) bind(c)
         import :: c_int, c_intptr_t, c_ptr
         integer(c_int), value :: number
         integer(c_intptr_t), value :: handler
      end function signal
   end interface

   if (command_argument_count() == 2) then
      call get_command_argument(2, argument)
      folder = trim(argument)
      call get_command_argument(1, argument)
      if (argument == 'full-disk') call fill_disk()
      if (argument == 'in-use') call disturb()
      stop
   end if
   call make_folder('history', folder)
   call test_round_trip()
   call test_many_samples()
   call test_flush_without_close()
   call test_overwrite()
   call test_in_use()
   call test_bad_definitions()
   call test_bad_samples()
   call test_unwritable()
   call test_full_disk()
   call test_foreign_files()
   call test_truncated()
   call test_unknown_channel()
   call test_many_channels()
   call test_progress()
   call check_closed('at the end')
   call execute_command_line('rm -rf '//folder)
   deallocate (folder)
   call finish()

contains

   !> No identifier of HDF5 may stay open.
   subroutine check_closed(name)
      character(*), intent(in) :: name
      integer(size_t) :: count
      integer :: status
      ! HDF5 counts all open objects for this argument (H5F_OBJ_ALL of the C interface)
      call h5fget_obj_count_f(int(h5f_obj_all_f, hid_t), h5f_obj_all_f, count, status)
      call check(status == 0 .and. count == 0, name//': HDF5 objects left open')
   end subroutine check_closed

   !> Opens a history with channels 'angle' (1), 'tip' (3) and 'force' (2).
   subroutine begin(history, path, name)
      type(history_type), intent(inout) :: history
      character(*), intent(in) :: path, name
      type(error_type), allocatable :: error
      call history%create(path, .false., '0.1.0', error)
      call check_no_error(error, name//': create')
      call history%define_time('s', error)
      call check_no_error(error, name//': time')
      call history%define_channel('angle', 1, 'rad', 'crank angle', error)
      call check_no_error(error, name//': angle')
      call history%define_channel('tip', 3, 'm', 'position of the tip', error)
      call check_no_error(error, name//': tip')
      call history%define_channel('force', 2, 'N', 'reaction', error)
      call check_no_error(error, name//': force')
   end subroutine begin

   !> The sample at step i.
   pure function sample(i) result(values)
      integer, intent(in) :: i
      real(wp) :: values(6)
      integer :: k
      values = [(real(i, wp) + 0.1_wp*k, k=1, 6)]
   end function sample

   subroutine add(history, first, last, name)
      type(history_type), intent(inout) :: history
      integer, intent(in) :: first, last
      character(*), intent(in) :: name
      type(error_type), allocatable :: error
      integer :: i
      do i = first, last
         call history%append(0.5_wp*i, sample(i), error)
         if (allocated(error)) exit
      end do
      call check_no_error(error, name//': append')
   end subroutine add

   !> Whether a file holds samples 1 to count of `add`.
   subroutine check_samples(path, count, name)
      character(*), intent(in) :: path, name
      integer, intent(in) :: count
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: time(:), angle(:, :), tip(:, :), force(:, :)
      real(wp) :: values(6), worst
      integer :: i
      call reader%open(path, error)
      call check_no_error(error, name//': open')
      if (allocated(error)) return
      call check(reader%samples == count, name//': number of samples')
      call reader%read_time(time, error)
      call check_no_error(error, name//': read time')
      call reader%read_channel('angle', angle, error)
      call check_no_error(error, name//': read angle')
      call reader%read_channel('tip', tip, error)
      call check_no_error(error, name//': read tip')
      call reader%read_channel('force', force, error)
      call check_no_error(error, name//': read force')
      call check(all([size(time), shape(angle), shape(tip), shape(force)] == &
         & [count, 1, count, 3, count, 2, count]), name//': shapes')
      worst = 0.0_wp
      do i = 1, count
         values = sample(i)
         worst = max(worst, abs(time(i) - 0.5_wp*i), maxval(abs([angle(:, i), tip(:, i), force(:, i)] - values)))
      end do
      call check_close(worst, 0.0_wp, 0.0_wp, name//': samples')
      call reader%close()
   end subroutine check_samples

   subroutine test_round_trip()
      type(history_type) :: history
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(*), parameter :: deck = 'title "two ''quotes''"'//nl//nl//'  body rod  # 30°, indented'//nl
      character(:), allocatable :: text
      character(*), parameter :: name = 'round trip'
      call begin(history, folder//'/round.h5', name)
      call history%put_text('/run/deck', 'an older text', error)
      call history%put_text('/run/deck', deck, error)
      call check_no_error(error, name//': deck')
      call history%put_text('/run/warnings', '', error)
      call check_no_error(error, name//': empty text')
      call history%put_attribute('/run', 'steps', 12345678901_long, error)
      call check_no_error(error, name//': long attribute')
      call history%put_attribute('/run', 'seconds', 0.25_wp, error)
      call check_no_error(error, name//': real attribute')
      call history%put_real('/bodies/rod/frequency', [1.0_wp, 2.5_wp], 'Hz', 'natural frequency', error)
      call check_no_error(error, name//': body data')
      call history%put_real('/bodies/rod/shapes', reshape(sample(1), [2, 3]), 'm', 'modes', error)
      call check_no_error(error, name//': body table')
      call history%put_integer('/bodies/rod/nodes', [3, 4, 5], 'node numbers', error)
      call check_no_error(error, name//': body integers')
      call history%put_attribute('/bodies/rod', 'centre', [1.0_wp, 2.0_wp], error)
      call check_no_error(error, name//': real array attribute')
      call history%put_attribute('/bodies/rod', 'modes', 2, error)
      call check_no_error(error, name//': integer attribute')
      call add(history, 1, 10, name)
      call history%put_attribute('/bodies/nobody', 'modes', 2, error)
      call check(allocated(error), name//': attribute of what is not there')
      call history%finish(.true., 'finished', error)
      call check_no_error(error, name//': finish')
      call history%finish(.false., 'again', error)
      call check_no_error(error, name//': finish again')
      call check_closed(name)
      call check_samples(folder//'/round.h5', 10, name)

      call reader%open(folder//'/round.h5', error)
      call check_no_error(error, name//': open')
      call check(reader%complete, name//': complete')
      call check_text(reader%status, 'finished', name//': status')
      call check_text(reader%version, '0.1.0', name//': version')
      call check_text(reader%time_units, 's', name//': unit of time')
      call check(size(reader%channels) == 3, name//': number of channels')
      call check_text(reader%channels(1)%name//' '//reader%channels(2)%name//' '//reader%channels(3)%name, &
         & 'angle tip force', name//': channels in order of definition')
      call check(all(reader%channels%width == [1, 3, 2]), name//': widths')
      call check_text(reader%channels(2)%units, 'm', name//': units')
      call check_text(reader%channels(2)%long_name, 'position of the tip', name//': long_name')
      call reader%read_text('/run/deck', text, error)
      call check_no_error(error, name//': read deck')
      call check_text(text, deck, name//': deck, byte for byte')
      call reader%read_text('/run/warnings', text, error)
      call check_text(text, '', name//': empty text')
      call reader%read_text('/run/nothing', text, error)
      call check_error(error, folder//'/round.h5 has no /run/nothing', 2, name//': no such text')
      call reader%read_text('/bodies/rod/nodes', text, error)
      call check_error(error, '/bodies/rod/nodes is not a text', 2, name//': not a text')
      call reader%close()
      call check_closed(name//', reader')
   end subroutine test_round_trip

   !> Several full buffers, flushes in between, and a rest.
   subroutine test_many_samples()
      type(history_type) :: history
      type(error_type), allocatable :: error
      character(*), parameter :: name = 'many samples'
      call begin(history, folder//'/many.h5', name)
      call add(history, 1, 100, name)
      call history%flush(error)
      call check_no_error(error, name//': flush')
      call history%flush(error)
      call check_no_error(error, name//': flush of nothing')
      call add(history, 101, 9000, name)
      history%flush_interval = 0.0_wp
      call add(history, 9001, 9100, name)
      call history%finish(.true., 'finished', error)
      call check_no_error(error, name//': finish')
      call check(history%samples == 9100_long, name//': counted')
      call check_samples(folder//'/many.h5', 9100, name)
      call begin(history, folder//'/again.h5', name//', same variable')
      call history%finish(.true., 'finished', error)
      call check_samples(folder//'/again.h5', 0, 'no sample')
   end subroutine test_many_samples

   !> What a killed run leaves: nothing before the first flush, then the samples of the last one, whatever is written behind it.
   subroutine test_flush_without_close()
      type(history_type) :: history
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(*), parameter :: name = 'killed'
      logical :: exists
      call begin(history, folder//'/live.h5', name)
      history%flush_interval = 1.0e6_wp
      call add(history, 1, 300, name)
      inquire (file=folder//'/live.h5', exist=exists)
      call check(.not. exists, name//': nothing yet')
      call check(history%safe == 0, name//': nothing is safe yet')
      call history%flush(error)
      call check_no_error(error, name//': flush')
      call check(history%safe == 300, name//': safe')
      call check_samples(folder//'/live.h5', 300, name//', flushed')
      call add(history, 301, 700, name)
      call check_samples(folder//'/live.h5', 300, name//', not flushed')
      call history%flush(error)
      call check_samples(folder//'/live.h5', 700, name//', flushed again')
      call reader%open(folder//'/live.h5', error)
      call check_no_error(error, name//': open')
      call check(.not. reader%complete, name//': not complete')
      call check_text(reader%status, 'running', name//': status')
      call reader%close()
      call history%finish(.false., "joint 'pin': no solution", error)
      call check_no_error(error, name//': finish')
      call reader%open(folder//'/live.h5', error)
      call check(.not. reader%complete, name//': failed run not complete')
      call check_text(reader%status, "joint 'pin': no solution", name//': status of a failed run')
      call reader%close()
      inquire (file=folder//'/live.h5.running', exist=exists)
      call check(.not. exists, name//': one file is left')
   end subroutine test_flush_without_close

   subroutine test_overwrite()
      type(history_type) :: history
      type(error_type), allocatable :: error
      character(*), parameter :: name = 'overwrite'
      call history%create(folder//'/round.h5', .false., '0.1.0', error)
      call check_error(error, folder//'/round.h5 exists; give --force to overwrite it or -o for another name', 2, name)
      call check_samples(folder//'/round.h5', 10, name//': untouched')
      call execute_command_line('cp '//folder//'/round.h5 '//folder//'/old.h5')
      call history%create(folder//'/old.h5', .true., '0.1.0', error)
      call check_no_error(error, name//': forced')
      call history%create(folder//'/other.h5', .true., '0.1.0', error)
      call check_error(error, folder//'/old.h5: the history is already open', 3, name//': twice')
      call check_samples(folder//'/old.h5', 10, name//': the old file is there until there is a new one')
      call history%define_time('s', error)
      call history%finish(.true., 'finished', error)
      call check_no_error(error, name//': finish')
      call check_samples_gone(folder//'/old.h5', name)
      call history%create(folder//'/new.h5', .false., '0.1.0', error)
      call history%define_time('s', error)
      call execute_command_line('cp '//folder//'/round.h5 '//folder//'/new.h5')
      call history%flush(error)
      call check_error(error, folder//'/new.h5 was made by somebody else while '//folder//'/new.h5.running was written; '// &
         & 'it is left as it is', 3, name//': made meanwhile')
      call history%finish(.true., 'finished', error)
      call check_samples(folder//'/new.h5', 10, name//': made meanwhile, untouched')
   end subroutine test_overwrite

   !> Whether a file has no channels and no samples any more.
   subroutine check_samples_gone(path, name)
      character(*), intent(in) :: path, name
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      call reader%open(path, error)
      call check_no_error(error, name//': open')
      call check(reader%samples == 0 .and. size(reader%channels) == 0, name//': replaced')
      call reader%close()
   end subroutine check_samples_gone

   !> A file that another run still writes is not emptied; what it has flushed can be read.
   subroutine test_in_use()
      type(history_type) :: history
      type(error_type), allocatable :: error
      character(512) :: program_name
      integer :: status, length
      call get_environment_variable('HDF5_USE_FILE_LOCKING', length=length)
      if (length > 0) return
      call begin(history, folder//'/in_use.h5', 'in use')
      call add(history, 1, 10, 'in use')
      call history%flush(error)
      call check_no_error(error, 'in use: flush')
      call get_command_argument(0, program_name)
      status = 1
      call execute_command_line(trim(program_name)//' in-use '//folder, exitstat=status)
      call check(status == 0, 'in use: process of its own')
      call add(history, 11, 20, 'in use')
      call history%finish(.true., 'finished', error)
      call check_no_error(error, 'in use: finish')
      call check_samples(folder//'/in_use.h5', 20, 'in use')
   end subroutine test_in_use

   !> The process of `test_in_use`.
   subroutine disturb()
      type(history_type) :: history
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      call history%create(folder//'/in_use.h5', .true., '0.1.0', error)
      call check_error(error, 'cannot overwrite '//folder//'/in_use.h5.running: another program has it open', 2, 'in use: create')
      call history%resume(folder//'/in_use.h5', 5, error)
      call check_error(error, 'cannot overwrite '//folder//'/in_use.h5.running: another program has it open', 2, 'in use: resume')
      call reader%open(folder//'/in_use.h5.running', error)
      call check_error(error, 'cannot open '//folder//'/in_use.h5.running: another program has it open', 2, 'in use: open')
      call check_samples(folder//'/in_use.h5', 10, 'in use: flushed')
      call finish()
   end subroutine disturb

   subroutine test_bad_definitions()
      type(history_type) :: history
      type(error_type), allocatable :: error
      character(*), parameter :: name = 'bad definition'
      call history%create(folder//'/bad.h5', .true., '0.1.0', error)
      call history%define_channel('x', 1, 'm', 'x', error)
      call check_error(error, "channel 'x': to be defined after the time and before the first sample", 3, name)
      call history%define_time('s', error)
      call history%define_channel('x', 1, 'm', 'x', error)
      call check_no_error(error, name//': good one')
      call history%define_channel('x', 1, 'm', 'x', error)
      call check_error(error, "channel 'x': defined twice", 3, name)
      call history%define_channel('a/b', 1, 'm', 'x', error)
      call check_error(error, "channel 'a/b': not a name of a channel", 3, name)
      call history%define_channel('time', 1, 's', 'x', error)
      call check_error(error, "channel 'time': not a name of a channel", 3, name)
      call history%define_channel('y', 0, 'm', 'y', error)
      call check_error(error, "channel 'y': width 0 is not positive", 3, name)
      call history%append(0.0_wp, [1.0_wp], error)
      call check_no_error(error, name//': sample')
      call history%define_channel('y', 1, 'm', 'y', error)
      call check_error(error, "channel 'y': to be defined after the time and before the first sample", 3, name)
      call history%finish(.true., 'finished', error)
      call check_no_error(error, name//': finish')
      call check_closed(name)
   end subroutine test_bad_definitions

   subroutine test_bad_samples()
      type(history_type) :: history
      type(error_type), allocatable :: error
      character(*), parameter :: name = 'bad sample'
      call history%append(0.0_wp, [1.0_wp], error)
      call check_error(error, 'results file: a sample for a history that is not open, or could not be written before', &
         & 3, name//': not open')
      call begin(history, folder//'/samples.h5', name)
      call history%append(0.0_wp, [1.0_wp], error)
      call check_error(error, folder//'/samples.h5: a sample of 1 numbers for channels of 6', 3, name//': size')
      call add(history, 1, 1, name)
      call history%finish(.true., 'finished', error)
      call history%append(0.0_wp, sample(1), error)
      call check(allocated(error), name//': after the end')
   end subroutine test_bad_samples

   subroutine test_unwritable()
      type(history_type) :: history
      type(error_type), allocatable :: error
      logical :: locked
      integer :: status
      call history%create(folder//'/nowhere/a.h5', .false., '0.1.0', error)
      call check_error(error, 'cannot create '//folder//'/nowhere/a.h5.running: No such file or directory', 2, 'no folder')
      call execute_command_line('mkdir '//folder//'/sub.h5')
      call history%create(folder//'/sub.h5', .true., '0.1.0', error)
      call check_error(error, 'cannot create '//folder//'/sub.h5: Is a directory', 2, 'a folder of that name')
      call execute_command_line('mkdir '//folder//'/locked && chmod 500 '//folder//'/locked')
      status = 0
      call execute_command_line('touch '//folder//'/locked/probe 2>/dev/null', exitstat=status)
      locked = status /= 0
      if (locked) then
         call history%create(folder//'/locked/a.h5', .false., '0.1.0', error)
         call check_error(error, 'cannot create '//folder//'/locked/a.h5.running: Permission denied', 2, 'unwritable folder')
      else
         print '(a)', 'skipped: unwritable folder (this user may write anywhere)'
      end if
      call execute_command_line('chmod 700 '//folder//'/locked')
      call check_closed('unwritable')
   end subroutine test_unwritable

   !> A disk that fills up in the middle of a run, in a process of its own: HDF5 itself then keeps memory and
   !> identifiers for ever, and must not crash when the program ends.
   subroutine test_full_disk()
      character(512) :: program_name
      integer :: status
      call get_command_argument(0, program_name)
      status = 1
      call execute_command_line('ASAN_OPTIONS=detect_leaks=0 '//trim(program_name)//' full-disk '//folder, &
         & exitstat=status)
      call check(status == 0, 'full disk: process of its own')
   end subroutine test_full_disk

   !> The process of `test_full_disk`: a limit on the size of a file plays the full disk.
   subroutine fill_disk()
      type(history_type) :: history
      type(error_type), allocatable :: error
      integer(c_long) :: limits(2)
      character(:), allocatable :: message
      integer :: i
      logical :: exists
      call begin(history, folder//'/full.h5', 'full disk')
      call add(history, 1, 256, 'full disk')
      call history%flush(error)
      call check_no_error(error, 'full disk: flush')
      call check(getrlimit(file_size, limits) == 0, 'full disk: limit read')
      call ignore_signal()
      limits(1) = 32768
      call check(setrlimit(file_size, limits) == 0, 'full disk: limit set')
      message = ''
      do i = 257, 10000
         call history%append(0.5_wp*i, sample(i), error)
         if (modulo(i, 256) == 0 .and. .not. allocated(error)) call history%flush(error)
         if (.not. allocated(error)) cycle
         message = error%message
         exit
      end do
      call check_text(message, folder//'/full.h5.running: cannot write: File too large', 'full disk')
      call history%append(0.0_wp, sample(1), error)
      call check(allocated(error), 'full disk: no further sample')
      call history%finish(.false., 'failed', error)
      call check_samples(folder//'/full.h5', 256, 'full disk: what was flushed before')
      call check(history%safe == 256, 'full disk: safe')
      inquire (file=folder//'/full.h5.running', exist=exists)
      call check(.not. exists, 'full disk: no damaged file is left')
      call finish()
   end subroutine fill_disk

   !> Has a write beyond the limit fail instead of ending the program.
   subroutine ignore_signal()
      type(c_ptr) :: previous
      integer(c_int), parameter :: file_size_exceeded = 25
      integer(c_intptr_t), parameter :: ignore = 1
      previous = signal(file_size_exceeded, ignore)
   end subroutine ignore_signal

   subroutine test_foreign_files()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      integer(hid_t) :: file
      integer :: unit
      open (newunit=unit, file=folder//'/text.h5', action='write')
      write (unit, '(a)') 'a text, whatever its name says'
      close (unit)
      call reader%open(folder//'/text.h5', error)
      call check_error(error, folder//'/text.h5 is not an HDF5 file', 2, 'text file')
      open (newunit=unit, file=folder//'/empty.h5', action='write')
      close (unit)
      call reader%open(folder//'/empty.h5', error)
      call check_error(error, folder//'/empty.h5 is not an HDF5 file', 2, 'empty file')
      call reader%open(folder//'/none.h5', error)
      call check_error(error, folder//'/none.h5 does not exist', 2, 'missing file')
      call create_file(folder//'/foreign.h5', .false., file, error)
      call check_no_error(error, 'foreign: create')
      call close_file(folder//'/foreign.h5', file, error)
      call reader%open(folder//'/foreign.h5', error)
      call check_error(error, folder//'/foreign.h5 is not a results file of limber (its attribute format is not '// &
         & '"limber-history")', 2, 'foreign HDF5 file')
      call create_file(folder//'/newer.h5', .false., file, error)
      call write_attribute(file, '/', 'format', 'limber-history', error)
      call write_attribute(file, '/', 'format_version', 2, error)
      call close_file(folder//'/newer.h5', file, error)
      call reader%open(folder//'/newer.h5', error)
      call check_error(error, folder//'/newer.h5 has version 2 of the format; this limber reads version 1', 2, 'newer')
      call check_closed('foreign')
   end subroutine test_foreign_files

   subroutine test_truncated()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      call execute_command_line('head -c 5000 '//folder//'/many.h5 > '//folder//'/cut.h5')
      call reader%open(folder//'/cut.h5', error)
      call check(allocated(error), 'truncated: error')
      if (.not. allocated(error)) return
      call check(index(error%message, 'cannot open '//folder//'/cut.h5: truncated file: eof = 5000') == 1, &
         & 'truncated: '//error%message)
      call check_closed('truncated')
   end subroutine test_truncated

   subroutine test_unknown_channel()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: values(:, :)
      call reader%open(folder//'/round.h5', error)
      call reader%read_channel('fource', values, error)
      call check_error(error, folder//"/round.h5 has no channel 'fource'; did you mean 'force'?"//nl// &
         & 'its channels: angle, tip, force', 2, 'misspelt channel')
      call reader%read_channel('completely_else', values, error)
      call check_error(error, folder//"/round.h5 has no channel 'completely_else'"//nl// &
         & 'its channels: angle, tip, force', 2, 'unknown channel')
      call reader%close()
   end subroutine test_unknown_channel

   !> More channels than the list of a scale's users could hold in the old format (64 kB).
   subroutine test_many_channels()
      type(history_type) :: history
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      integer, parameter :: count = 4200
      character(6) :: label
      integer :: i
      call history%create(folder//'/wide.h5', .true., '0.1.0', error)
      call history%define_time('s', error)
      do i = 1, count
         write (label, '("c",i5.5)') i
         call history%define_channel(label, 1, 'm', 'one of many', error)
         if (allocated(error)) exit
      end do
      call check_no_error(error, 'many channels: define')
      call history%append(0.0_wp, [(real(i, wp), i=1, count)], error)
      call check_no_error(error, 'many channels: append')
      call history%finish(.true., 'finished', error)
      call check_no_error(error, 'many channels: finish')
      call reader%open(folder//'/wide.h5', error)
      call check_no_error(error, 'many channels: open')
      call check(size(reader%channels) == count, 'many channels: number')
      call reader%close()
   end subroutine test_many_channels

   subroutine test_progress()
      type(progress_type) :: bar
      call check_text(progress_line('swing', 0.5_wp, 61.0_wp, 40), &
         & 'swing [#####......]  50%  1:01 left     ', 'progress: half')
      call check_text(progress_line('swing', 0.0_wp, 0.0_wp, 40), &
         & 'swing [...........]   0%                ', 'progress: start')
      call check_text(progress_line('swing', ieee_value(1.0_wp, ieee_quiet_nan), 1.0_wp, 40), &
         & 'swing [...........]   0%                ', 'progress: not a number')
      call check_text(progress_line('swing', 2.0_wp, 5.0_wp, 40), &
         & 'swing [###########] 100%  0:00 left     ', 'progress: end')
      call check_text(progress_line('swing', 1.0e-9_wp, 5.0_wp, 40), &
         & 'swing [...........]   0%  99:59:59 left ', 'progress: long')
      call bar%update(0.5_wp)
      call bar%finish()
      call check(.not. bar%shown, 'progress: nothing without a start')
   end subroutine test_progress

   !> An error of exactly this text and status.
   subroutine check_error(error, message, status, name)
      type(error_type), allocatable, intent(in) :: error
      character(*), intent(in) :: message, name
      integer, intent(in) :: status
      call check(allocated(error), name//': no error')
      if (.not. allocated(error)) return
      call check_text(error%message, message, name)
      call check(error%status == status, name//': exit status')
   end subroutine check_error

end program test_history
