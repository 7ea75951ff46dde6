!> limber diff: two results files compared. `limber diff`, and through it every regression test. Floor: commands; two results files
!> -> report and verdict.
module limber_commands_diff
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_is_nan
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, lowercase, newline
   use limber_output_history_reader, only: history_reader_type
   implicit none
   private
   public :: compare_histories, compare_values, tolerance_type, difference_type

   !> How far a value a may be from its reference b: |a - b| <= relative |b| + of_range (max b - min b) + absolute
   type :: tolerance_type
      !> Part of the reference's magnitude
      real(wp) :: relative = 1.0e-6_wp
      !> Part of the range of the reference over all samples and components of its channel
      real(wp) :: of_range = 1.0e-6_wp
      !> In the unit of the channel, the same for all: for channels that are zero but for rounding
      real(wp) :: absolute = 0.0_wp
      !> Whether a number that both lack counts as the same
      logical :: blank = .false.
   end type tolerance_type

   !> How a channel differs from its reference
   type :: difference_type
      !> Greatest |a - b| [unit of the channel]
      real(wp) :: greatest = 0.0_wp
      !> Range of the reference where it is finite [unit of the channel]
      real(wp) :: range = 0.0_wp
      !> Index of the sample with the greatest difference, or of the first that is no number; 0 without samples
      integer :: worst = 0
      !> Numbers beyond the tolerance, and those not finite in either
      integer :: beyond = 0, not_finite = 0
   end type difference_type

contains

   !> Compares a file with a reference: every channel of the reference, and the time, must be there, have the same
   !> shape and unit, be finite everywhere, and agree. Channels that the reference does not have are only mentioned.
   subroutine compare_histories(path, reference_path, tolerance, report, same, error)
      !> Name of the file to judge (A)
      character(*), intent(in) :: path
      !> Name of the reference (B)
      character(*), intent(in) :: reference_path
      !> What counts as the same
      type(tolerance_type), intent(in) :: tolerance
      !> A table with a line for each channel, and a last line with the verdict; no newline at its end
      character(:), allocatable, intent(out) :: report
      !> Whether everything agrees; two files without samples or channels do not
      logical, intent(out) :: same
      !> Allocated if a file cannot be read
      type(error_type), allocatable, intent(out) :: error
      type(history_reader_type) :: a, b
      report = ''
      same = .false.
      call a%open(path, error)
      if (.not. allocated(error)) call b%open(reference_path, error)
      if (.not. allocated(error)) call compare_open(a, b, tolerance, report, same, error)
      call a%close()
      call b%close()
   end subroutine compare_histories

   !> Compares two open files.
   subroutine compare_open(a, b, asked, report, same, error)
      type(history_reader_type), intent(in) :: a, b
      type(tolerance_type), intent(in) :: asked
      character(:), allocatable, intent(out) :: report
      logical, intent(out) :: same
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: time(:), time_a(:)
      integer :: i, failures, width
      logical :: agrees
      type(tolerance_type) :: tolerance
      tolerance = asked
      ! A row of a sweep, or a run of a study, that has not ended well has no numbers
      tolerance%blank = b%time_units == 'row' .or. b%time_units == 'run'
      width = max(8, maxval([(len(b%channels(i)%name), i=1, size(b%channels))]))
      report = cell('channel', width)//'   max |a-b|   of range     at time  verdict'
      failures = 0
      call a%read_time(time_a, error)
      if (.not. allocated(error)) call b%read_time(time, error)
      if (allocated(error)) return
      call judge('time', a%time_units, b%time_units, reshape(time_a, [1, size(time_a)]), &
         & reshape(time, [1, size(time)]), time, tolerance, width, report, agrees)
      if (.not. agrees) failures = failures + 1
      do i = 1, size(b%channels)
         call compare_channel(a, b, i, time, tolerance, width, report, agrees, error)
         if (allocated(error)) return
         if (.not. agrees) failures = failures + 1
      end do
      do i = 1, size(a%channels)
         if (index_of(b, a%channels(i)%name) > 0) cycle
         report = report//newline//cell(a%channels(i)%name, width)//repeat(' ', 38)//'not in the reference'
      end do
      if (.not. a%complete) report = report//newline//a%path//' is not of a complete run: '//a%status
      same = failures == 0 .and. size(b%channels) > 0 .and. b%samples > 0
      report = report//newline//verdict()

   contains

      !> The last line.
      function verdict() result(line)
         character(:), allocatable :: line
         if (size(b%channels) == 0 .or. b%samples == 0) then
            line = 'different: the reference has '//as_text(size(b%channels))//' channels and '// &
               & as_text(b%samples)//' samples, which is nothing to compare with'
         else if (failures > 0) then
            line = 'different: '//as_text(failures)//' of '//as_text(size(b%channels) + 1)//' (time and channels) fail'
         else
            line = 'the same: time and '//as_text(size(b%channels))//' channels, '//as_text(b%samples)//' samples'
         end if
         line = line//' (rtol '//as_text(tolerance%relative)//', atol '//as_text(tolerance%of_range)//' of range'
         if (tolerance%absolute > 0.0_wp) line = line//', '//as_text(tolerance%absolute)//' absolute'
         line = line//')'
      end function verdict

   end subroutine compare_open

   !> Compares channel `which` of the reference and adds its line to the report.
   subroutine compare_channel(a, b, which, time, tolerance, width, report, agrees, error)
      type(history_reader_type), intent(in) :: a, b
      integer, intent(in) :: which, width
      real(wp), intent(in) :: time(:)
      type(tolerance_type), intent(in) :: tolerance
      character(:), allocatable, intent(inout) :: report
      logical, intent(out) :: agrees
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: values(:, :), reference(:, :)
      integer :: in_a
      agrees = .false.
      associate (channel => b%channels(which))
         in_a = index_of(a, channel%name)
         if (in_a == 0) then
            report = report//newline//cell(channel%name, width)//repeat(' ', 38)//'FAILS: missing'
            return
         end if
         call a%read_channel(channel%name, values, error)
         if (.not. allocated(error)) call b%read_channel(channel%name, reference, error)
         if (allocated(error)) return
         call judge(channel%name, a%channels(in_a)%units, channel%units, values, reference, time, tolerance, width, &
            & report, agrees)
      end associate
   end subroutine compare_channel

   !> Judges one channel and adds its line to the report.
   subroutine judge(name, units, reference_units, values, reference, time, tolerance, width, report, agrees)
      character(*), intent(in) :: name, units, reference_units
      real(wp), intent(in) :: values(:, :), reference(:, :), time(:)
      type(tolerance_type), intent(in) :: tolerance
      integer, intent(in) :: width
      character(:), allocatable, intent(inout) :: report
      logical, intent(out) :: agrees
      type(difference_type) :: difference
      character(38) :: numbers
      character(:), allocatable :: reason
      numbers = ''
      reason = ''
      if (any(shape(values) /= shape(reference))) then
         reason = 'shape '//shape_text(values)//', not '//shape_text(reference)
      else if (units /= reference_units) then
         reason = 'unit '//units//', not '//reference_units
      else if (size(reference) > 0) then
         difference = compare_values(values, reference, tolerance)
         call write_numbers(difference, time(difference%worst), numbers)
         if (difference%not_finite > 0) then
            reason = as_text(difference%not_finite)//' of '//as_text(size(reference))//' not finite'
         else if (difference%beyond > 0) then
            reason = as_text(difference%beyond)//' of '//as_text(size(reference))//' beyond the tolerance'
         end if
      end if
      agrees = reason == ''
      if (agrees) then
         reason = 'same'
      else
         reason = 'FAILS: '//reason
      end if
      report = report//newline//cell(name, width)//numbers//reason
   end subroutine judge

   !> The greatest difference of two channels of one shape, and how many numbers are beyond the tolerance.
   pure function compare_values(values, reference, tolerance) result(difference)
      !> Channel to judge, (width, samples)
      real(wp), intent(in) :: values(:, :)
      !> Its reference, of the same shape
      real(wp), intent(in) :: reference(:, :)
      !> What counts as the same
      type(tolerance_type), intent(in) :: tolerance
      type(difference_type) :: difference
      real(wp) :: distance, lowest, highest
      logical :: usable
      integer :: i, sample
      if (size(reference) == 0) return
      lowest = minval(reference, mask=ieee_is_finite(reference))
      highest = maxval(reference, mask=ieee_is_finite(reference))
      if (highest > lowest) difference%range = highest - lowest
      difference%worst = 1
      do sample = 1, size(reference, 2)
         do i = 1, size(reference, 1)
            usable = ieee_is_finite(values(i, sample)) .and. ieee_is_finite(reference(i, sample))
            if (.not. usable) then
               if (tolerance%blank .and. ieee_is_nan(values(i, sample)) .and. ieee_is_nan(reference(i, sample))) cycle
               if (difference%not_finite == 0) difference%worst = sample
               difference%not_finite = difference%not_finite + 1
               cycle
            end if
            distance = abs(values(i, sample) - reference(i, sample))
            if (distance > difference%greatest) then
               difference%greatest = distance
               if (difference%not_finite == 0) difference%worst = sample
            end if
            if (distance > tolerance%relative*abs(reference(i, sample)) + tolerance%of_range*difference%range &
               & + tolerance%absolute) difference%beyond = difference%beyond + 1
         end do
      end do
   end function compare_values

   !> The columns of numbers of a line; '-' for the part of a range that is zero.
   subroutine write_numbers(difference, t, numbers)
      type(difference_type), intent(in) :: difference
      real(wp), intent(in) :: t
      character(38), intent(out) :: numbers
      write (numbers, '(es12.3e3,a11,es12.4,3x)') difference%greatest, '-', t
      if (difference%range > 0.0_wp) &
         & write (numbers(13:23), '(es11.2e3)') difference%greatest/difference%range
   end subroutine write_numbers

   !> Index of a channel by name; 0 if there is none.
   pure integer function index_of(reader, name)
      type(history_reader_type), intent(in) :: reader
      character(*), intent(in) :: name
      do index_of = 1, size(reader%channels)
         if (lowercase(reader%channels(index_of)%name) == lowercase(name)) return
      end do
      index_of = 0
   end function index_of

   !> A text padded to a column of the report.
   pure function cell(text, width)
      character(*), intent(in) :: text
      integer, intent(in) :: width
      character(width) :: cell
      cell = text
   end function cell

   !> Shape of a channel as h5py tells it: (samples, width).
   pure function shape_text(values) result(text)
      real(wp), intent(in) :: values(:, :)
      character(:), allocatable :: text
      text = '('//as_text(size(values, 2))//', '//as_text(size(values, 1))//')'
   end function shape_text

end module limber_commands_diff
