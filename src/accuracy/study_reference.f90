!> Reference of a study and comparison with it. It is read from results of limber or from columns with names (CSV), or is a run of
!> the study's own. Floor: accuracy.
module limber_accuracy_study_reference
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise, status_deck
   use limber_base_files, only: kind_of_path, path_file
   use limber_base_text, only: as_text
   use limber_scene_channel_errors, only: magnitude
   use limber_accuracy_study_plan, only: plan_type
   use limber_output_history_reader, only: history_reader_type
   use limber_output_sample_sink, only: memory_type
   implicit none
   private
   public :: reference_type, read_reference, take_reference, compare, difference

   !> Samples to compare with
   type :: reference_type
      !> Times (samples), and the plan's channels (channels, samples)
      real(wp), allocatable :: times(:), values(:, :)
      !> Relative error that it may have itself; zero: not known
      real(wp) :: uncertainty = 0.0_wp
      !> What it is, for people
      character(:), allocatable :: source
      !> Whether it is the finest model of the study, and no more; then what its run warns of
      logical :: of_deck = .false.
      character(:), allocatable :: warnings
   end type reference_type

   !> Longest line of a file with columns
   integer, parameter :: longest_line = 65536

contains

   !> Reads the reference that the plan names.
   subroutine read_reference(plan, reference, error)
      type(plan_type), intent(in) :: plan
      type(reference_type), intent(out) :: reference
      type(error_type), allocatable, intent(out) :: error
      integer :: length
      length = len(plan%reference)
      if (plan%reference(max(1, length - 3):) == '.csv') then
         call read_columns(plan, reference, error)
      else
         call read_results(plan, reference, error)
      end if
      if (allocated(error)) return
      reference%source = plan%reference
      if (size(reference%times) < 4) call raise(error, plan%reference//': '//as_text(size(reference%times))// &
         & ' samples are too few to compare with', status_deck)
   end subroutine read_reference

   !> From a results file.
   subroutine read_results(plan, reference, error)
      type(plan_type), intent(in) :: plan
      type(reference_type), intent(inout) :: reference
      type(error_type), allocatable, intent(out) :: error
      type(history_reader_type) :: reader
      real(wp), allocatable :: values(:, :)
      integer :: i
      call reader%open(plan%reference, error)
      if (allocated(error)) return
      call reader%read_time(reference%times, error)
      if (.not. allocated(error)) then
         allocate (reference%values(size(plan%names), size(reference%times)))
         do i = 1, size(plan%names)
            call reader%read_channel(trim(plan%names(i)), values, error)
            if (allocated(error)) exit
            reference%values(i, :) = values(1, :)
         end do
      end if
      call reader%close()
   end subroutine read_results

   !> From a text whose first line names its columns, separated by commas: `time` (or `t`) and the channels. Lines that
   !> begin with # are comments.
   subroutine read_columns(plan, reference, error)
      type(plan_type), intent(in) :: plan
      type(reference_type), intent(inout) :: reference
      type(error_type), allocatable, intent(out) :: error
      character(longest_line) :: line
      character(64), allocatable :: names(:)
      integer :: place(size(plan%names) + 1)
      integer :: unit, status, pass, count
      allocate (names(0))
      place = 0
      if (kind_of_path(plan%reference) /= path_file) then
         call raise(error, plan%reference//': is no file', status_deck)
         return
      end if
      open (newunit=unit, file=plan%reference, status='old', action='read', iostat=status)
      if (status /= 0) then
         call raise(error, plan%reference//': cannot be read', status_deck)
         return
      end if
      do pass = 1, 2
         count = -1
         do while (.not. allocated(error))
            read (unit, '(a)', iostat=status) line
            if (status /= 0) exit
            if (line == '' .or. adjustl(line(1:1)) == '#') cycle
            count = count + 1
            if (count == 0 .and. pass == 1) then
               names = words_of(trim(line))
               call find_columns(plan, names, place, error)
            else if (count > 0 .and. pass == 2) then
               call read_row(trim(line), size(names), place, count, reference, error)
            end if
         end do
         if (allocated(error)) exit
         if (pass == 1) then
            rewind (unit)
            count = max(count, 0)
            allocate (reference%times(count), reference%values(size(plan%names), count))
            if (count == 0) exit
         end if
      end do
      close (unit)
      if (allocated(error)) error%message = plan%reference//': '//error%message
   end subroutine read_columns

   !> Which columns are the time and the channels.
   subroutine find_columns(plan, names, place, error)
      type(plan_type), intent(in) :: plan
      character(*), intent(in) :: names(:)
      !> Columns of the time and of each channel of the plan
      integer, intent(out) :: place(:)
      type(error_type), allocatable, intent(out) :: error
      integer :: i
      place(1) = column('time')
      if (place(1) == 0) place(1) = column('t')
      do i = 1, size(plan%names)
         place(i + 1) = column(trim(plan%names(i)))
         if (place(i + 1) == 0) call raise(error, "there is no column '"//trim(plan%names(i))// &
            & "'; name the channels that there are in the list 'channels' of *STUDY", status_deck)
      end do
      if (place(1) == 0) call raise(error, "there is no column 'time'", status_deck)

   contains

      pure integer function column(name)
         character(*), intent(in) :: name
         do column = size(names), 1, -1
            if (names(column) == name) return
         end do
      end function column

   end subroutine find_columns

   subroutine read_row(line, width, place, row, reference, error)
      character(*), intent(in) :: line
      !> Number of columns
      integer, intent(in) :: width
      integer, intent(in) :: place(:), row
      type(reference_type), intent(inout) :: reference
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: values(width)
      integer :: status
      read (line, *, iostat=status) values
      if (status /= 0) then
         call raise(error, 'row '//as_text(row)//' has no '//as_text(width)//' numbers', status_deck)
         return
      end if
      reference%times(row) = values(place(1))
      reference%values(:, row) = values(place(2:))
   end subroutine read_row

   !> The words between commas.
   pure function words_of(line) result(words)
      character(*), intent(in) :: line
      character(64), allocatable :: words(:)
      integer :: first, comma
      allocate (words(0))
      first = 1
      do while (first <= len(line) + 1)
         comma = index(line(first:), ',')
         if (comma == 0) comma = len(line) - first + 2
         words = [character(64) :: words, adjustl(line(first:first + comma - 2))]
         first = first + comma
      end do
   end function words_of

   !> Makes the samples of a run the reference.
   subroutine take_reference(plan, samples, reference)
      type(plan_type), intent(in) :: plan
      type(memory_type), intent(in) :: samples
      type(reference_type), intent(out) :: reference
      integer :: i, k
      reference%times = samples%times(:samples%samples)
      allocate (reference%values(size(plan%channels), samples%samples))
      do k = 1, samples%samples
         do i = 1, size(plan%channels)
            reference%values(i, k) = samples%values(plan%channels(i), k)
         end do
      end do
   end subroutine take_reference

   !> Error of each channel: greatest difference over the samples, and that of the last one, relative to the reference's
   !> greatest magnitude. Of two series with other times the closer one is interpolated at the times of the other.
   subroutine compare(plan, samples, reference, greatest, last)
      type(plan_type), intent(in) :: plan
      type(memory_type), intent(in) :: samples
      type(reference_type), intent(in) :: reference
      !> (channels); a channel that is zero in the reference has its absolute difference
      real(wp), intent(out) :: greatest(:), last(:)
      type(reference_type) :: run
      call take_reference(plan, samples, run)
      call difference(run, reference, greatest, last)
   end subroutine compare

   !> `compare` for two references.
   subroutine difference(run, reference, greatest, last)
      type(reference_type), intent(in) :: run, reference
      real(wp), intent(out) :: greatest(:), last(:)
      real(wp) :: scale, values(size(greatest)), duration
      logical :: at_run
      integer :: i, k
      greatest = 0.0_wp
      last = 0.0_wp
      at_run = size(run%times) <= size(reference%times)
      duration = maxval(abs(run%times)) + maxval(abs(reference%times))
      associate (times => run%times, others => reference%times)
         if (at_run) then
            do k = 1, size(times)
               if (times(k) < others(1) - 1.0e-9_wp*duration .or. times(k) > others(size(others)) + 1.0e-9_wp*duration) cycle
               call interpolate(reference, times(k), duration, values)
               last = abs(run%values(:, k) - values)
               greatest = max(greatest, last)
            end do
         else
            do k = 1, size(others)
               if (others(k) < times(1) - 1.0e-9_wp*duration .or. others(k) > times(size(times)) + 1.0e-9_wp*duration) cycle
               call interpolate(run, others(k), duration, values)
               last = abs(reference%values(:, k) - values)
               greatest = max(greatest, last)
            end do
         end if
      end associate
      do i = 1, size(greatest)
         scale = magnitude(reference%values(i, :))
         greatest(i) = greatest(i)/scale
         last(i) = last(i)/scale
      end do
   end subroutine difference

   !> Values at a time: those of a sample at that time, else the cubic through the four samples around it.
   pure subroutine interpolate(series, t, duration, values)
      type(reference_type), intent(in) :: series
      real(wp), intent(in) :: t, duration
      real(wp), intent(out) :: values(:)
      real(wp) :: weight
      integer :: first, i, j, near
      near = minloc(abs(series%times - t), 1)
      values = series%values(:, near)
      if (abs(series%times(near) - t) <= 1.0e-12_wp*duration) return
      first = near - 1
      if (series%times(near) > t) first = near - 2
      first = max(1, min(first, size(series%times) - 3))
      values = 0.0_wp
      do i = first, first + 3
         weight = 1.0_wp
         do j = first, first + 3
            if (j /= i) weight = weight*(t - series%times(j))/(series%times(i) - series%times(j))
         end do
         values = values + weight*series%values(:, i)
      end do
   end subroutine interpolate

end module limber_accuracy_study_reference
