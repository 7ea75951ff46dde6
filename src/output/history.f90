!> Writer of histories. Floor: output; an analysis fills it, `limber_output_history_reader` and any HDF5 tool read it. Sources: HDF5
!> 1.10 (Dimension Scales, H5DS), and the netCDF-4 conventions built on them, by which xarray knows `time` as the coordinate of
!> every channel.
!>
!>     /                  attributes format = "limber-history", format_version, limber_version
!>     /time              (time): scale of every channel; attributes units, long_name
!>     /component_<k>     1..k: scale of the second dimension of channels of width k, one for each width in use
!>     /channels/<name>   (time) or (time, k); attributes units, long_name, of displacements and angles of flexible bodies
!>                        measured_from; members in order of definition
!>     /step              (time): number of the analysis of each sample, if there are several
!>     /modes/<name>/...  frequencies and shapes of a modal analysis; scale /modes/<name>/mode
!>     /<group>/<name>    of the same shape, with the same scales: more about a channel, whose attribute <group> is the path
!>     /motion            what `limber_output_motion_record` describes, if the deck asks for it
!>     /bodies/<name>/... small datasets and attributes; of flexible bodies indicators: (indicators, 2), attributes names, meanings
!>     /run               texts (deck, ...), statistics, /run/steps/... if there are several analyses; attributes complete (0, then
!> 1) and status
!>
!> Samples are gathered in memory and go to the file whenever the buffer is full: those of a small run behind it, all at once. The
!> file is written under the name <name>.running (`limber_output_working_file`), and every few seconds a copy of it takes the name
!> proper: what stands there is whole at any moment, with `complete` 0, and can be looked at while the run goes on; a killed run
!> leaves it. An existing file is replaced, if that is allowed, by the first such copy.
module limber_output_history
   use hdf5, only: hid_t, h5fflush_f, h5f_scope_global_f, h5dclose_f
   use limber_base_error, only: error_type, raise
   use limber_base_kinds, only: wp, long
   use limber_base_text, only: as_text
   use limber_output_hdf5, only: create_file, check_unused, reopen_file, close_file, create_group, object_exists, write_attribute
   use limber_output_hdf5_error, only: hdf5_error, no_id
   use limber_output_hdf5_read, only: longest_name
   use limber_output_hdf5_scales, only: make_scale, open_components, attach_scale, attach_open_scale, detach_scale
   use limber_output_hdf5_series, only: series_type, create_series, reopen_series, append_rows, close_series
   use limber_output_results_file, only: results_type
   use limber_output_working_file, only: working_file_type, working_name
   implicit none
   private
   public :: history_type, history_format, history_format_version

   !> Value of the root attribute `format`
   character(*), parameter :: history_format = 'limber-history'
   !> Value of the root attribute `format_version`; counted up when a reader has to change
   integer, parameter :: history_format_version = 1
   !> Names that cannot be those of channels: they are dimensions
   character(*), parameter :: reserved_name = 'time'

   !> A results file that is being written: create, define_time, define_channel ..., append ..., finish
   type, extends(results_type) :: history_type
      !> Name of the file
      character(:), allocatable :: path
      !> Numbers in a sample: the widths of all channels, and of what else is sampled, added up
      integer :: width = 0
      !> Samples taken so far, written or not; and those that stand under the name of the file, of this run or of one that gave the
      !> same, and are replaced by no fewer
      integer(long) :: samples = 0, safe = 0
      !> Wall time after which the samples so far are to stand under the name of the file [s]
      real(wp) :: flush_interval = 2.0_wp
      !> Why they could not the last time, such as a full disk; empty if they could
      character(:), allocatable :: trouble
      type(series_type), private :: time
      type(series_type), allocatable, private :: channels(:)
      !> Times not yet written (capacity), and the samples, channel by channel as the file has them (width*capacity); allocated
      !> with the first of them
      real(wp), allocatable, private :: times(:), buffer(:)
      integer, private :: waiting = 0
      !> Clock at the last write, and when it was looked at last [ticks]
      integer(long), private :: last_write = 0, looked = 0
      !> Samples from one look at the clock to the next, and those that are left
      integer, private :: stride = 1, countdown = 1
      !> Its names; not used without a file
      type(working_file_type), private :: names
      !> Whether it was there already: then series are opened, not made
      logical, private :: resumed = .false.
      !> Whether it says that there is a checkpoint
      logical, private :: has_checkpoint = .false.
      !> Set by a write that failed; no sample is taken any more
      logical :: failed = .false.
   contains
      procedure :: create, resume, define_time, define_channel, define_series, append, write_samples, finish
      procedure :: flush => flush_samples, secure => secure_samples, note_checkpoint
      procedure :: put_beside, put_steps
      procedure, private :: attach_scales
   end type history_type

contains

   !> Creates the file with its groups.
   subroutine create(self, path, overwrite, version, error, unkept)
      !> History that is not open
      class(history_type), intent(inout) :: self
      !> Name of the file
      character(*), intent(in) :: path
      !> Whether an existing file may be replaced; it is lost with the first samples that are safe
      logical, intent(in) :: overwrite
      !> Version of limber
      character(*), intent(in) :: version
      !> Allocated if the file exists (without `overwrite`) or cannot be written
      type(error_type), allocatable, intent(out) :: error
      !> Whether no file is made: all is lost but for what the sink sums up; false if absent
      logical, intent(in), optional :: unkept
      type(error_type), allocatable :: close_error
      if (self%file /= no_id) then
         call raise(error, self%path//': the history is already open')
         return
      end if
      self%unkept = .false.
      if (present(unkept)) self%unkept = unkept
      if (self%unkept) then
         if (allocated(self%channels)) deallocate (self%channels)
         call begin_samples(self, path, 0)
         return
      end if
      call self%names%begin(trim(path), overwrite, error)
      if (.not. allocated(error)) call create_file(self%names%working, .true., self%file, error)
      if (allocated(error)) return
      call begin_samples(self, path, 0)
      call write_attribute(self%file, '/', 'format', history_format, error)
      if (.not. allocated(error)) call write_attribute(self%file, '/', 'format_version', history_format_version, error)
      if (.not. allocated(error)) call write_attribute(self%file, '/', 'limber_version', version, error)
      if (.not. allocated(error)) call create_group(self%file, '/channels', error)
      if (.not. allocated(error)) call create_group(self%file, '/bodies', error)
      if (.not. allocated(error)) call create_group(self%file, '/run', error)
      if (.not. allocated(error)) call write_attribute(self%file, '/run', 'complete', 0, error)
      if (.not. allocated(error)) call write_attribute(self%file, '/run', 'status', 'running', error)
      if (.not. allocated(error)) return
      call close_file(self%path, self%file, close_error)
      deallocate (self%channels)
      call self%names%drop()
   end subroutine create

   !> Begins to count samples.
   subroutine begin_samples(self, path, samples)
      class(history_type), intent(inout) :: self
      character(*), intent(in) :: path
      integer, intent(in) :: samples
      self%path = trim(path)
      self%samples = samples
      self%safe = samples
      self%failed = .false.
      self%resumed = .false.
      self%has_checkpoint = .false.
      self%trouble = ''
      allocate (self%channels(0))
      call system_clock(self%last_write)
      self%looked = self%last_write
      self%stride = 1
      self%countdown = 1
   end subroutine begin_samples

   !> Opens a copy of the file of a run that goes on; its series are then defined as they were.
   subroutine resume(self, path, samples, error)
      !> History that is not open
      class(history_type), intent(inout) :: self
      !> Name of the file
      character(*), intent(in) :: path
      !> Samples that are left; later ones are cut off
      integer, intent(in) :: samples
      !> Allocated if it cannot be copied; the file itself is left as it is
      type(error_type), allocatable, intent(out) :: error
      self%unkept = .false.
      call check_unused(working_name(trim(path)), error)
      if (.not. allocated(error)) call self%names%resume(trim(path), error)
      if (.not. allocated(error)) call reopen_file(self%names%working, self%file, error)
      if (allocated(error)) return
      call begin_samples(self, path, samples)
      self%resumed = .true.
      call write_attribute(self%file, '/run', 'status', 'running', error)
      if (.not. allocated(error)) call self%note_checkpoint(error)
   end subroutine resume

   !> Makes the time axis; before the channels.
   subroutine define_time(self, units, error)
      !> Open history
      class(history_type), intent(inout) :: self
      !> Unit of time, such as 's'
      character(*), intent(in) :: units
      !> Allocated if it cannot be written or is there already
      type(error_type), allocatable, intent(out) :: error
      if (self%unkept) return
      if (self%resumed) then
         call reopen_series(self%file, '/time', 1, int(self%samples), self%time, error)
         return
      end if
      call create_series(self%file, '/time', 1, chunk_rows(1), self%time, error)
      if (.not. allocated(error)) call make_scale(self%file, '/time', self%time%id, error)
      if (.not. allocated(error)) call write_attribute(self%file, '/time', 'units', units, error)
      if (.not. allocated(error)) call write_attribute(self%file, '/time', 'long_name', 'time', error)
   end subroutine define_time

   !> Adds a channel; before the first sample, after the time.
   subroutine define_channel(self, name, width, units, long_name, error)
      !> Open history
      class(history_type), intent(inout) :: self
      !> Name, without '/' or blanks
      character(*), intent(in) :: name
      !> Numbers in each sample, at least 1
      integer, intent(in) :: width
      !> Unit, '1' for a number without
      character(*), intent(in) :: units
      !> One line for people
      character(*), intent(in) :: long_name
      !> Allocated if the name is bad or taken, or the file cannot be written
      type(error_type), allocatable, intent(out) :: error
      if (.not. (self%resumed .or. self%unkept)) call check_definition(self, name, width, error)
      if (.not. allocated(error)) call self%define_series('/channels/'//name, width, units, long_name, error)
   end subroutine define_channel

   !> Adds a series that is no channel, with the same scales; its numbers stand in a sample in the order of definition too.
   subroutine define_series(self, path, width, units, long_name, error)
      !> Open history
      class(history_type), intent(inout) :: self
      !> Absolute path in a group that is there, not taken
      character(*), intent(in) :: path
      !> Numbers in each sample, at least 1
      integer, intent(in) :: width
      !> Unit, and one line for people
      character(*), intent(in) :: units, long_name
      !> Allocated if the file cannot be written
      type(error_type), allocatable, intent(out) :: error
      type(series_type) :: series
      if (self%unkept) then
         self%width = self%width + width
         return
      end if
      if (self%resumed) then
         call reopen_series(self%file, path, width, int(self%samples), series, error)
      else
         call create_series(self%file, path, width, chunk_rows(width), series, error)
      end if
      if (allocated(error)) return
      self%channels = [self%channels, series]
      self%width = self%width + width
      if (self%resumed) return
      call write_attribute(self%file, path, 'units', units, error)
      if (.not. allocated(error)) call write_attribute(self%file, path, 'long_name', long_name, error)
      if (.not. allocated(error)) call self%attach_scales(series, path, error)
   end subroutine define_series

   !> Gives a series the time and, if it is wide, the components as scales of its dimensions.
   subroutine attach_scales(self, series, path, error)
      class(history_type), intent(in) :: self
      type(series_type), intent(in) :: series
      !> For the error
      character(*), intent(in) :: path
      type(error_type), allocatable, intent(out) :: error
      integer(hid_t) :: components
      integer :: ignored
      call attach_open_scale(self%file, path, series%id, self%time%id, 1, error)
      if (allocated(error) .or. series%width == 1) return
      call open_components(self%file, series%width, components, error)
      if (.not. allocated(error)) call attach_open_scale(self%file, path, series%id, components, 2, error)
      call h5dclose_f(components, ignored)
   end subroutine attach_scales

   !> Whether a channel can be defined.
   subroutine check_definition(self, name, width, error)
      class(history_type), intent(in) :: self
      character(*), intent(in) :: name
      integer, intent(in) :: width
      type(error_type), allocatable, intent(out) :: error
      if (self%time%id == no_id .or. allocated(self%buffer)) then
         call raise(error, "channel '"//name//"': to be defined after the time and before the first sample")
      else if (name == '' .or. name == '.' .or. name == reserved_name .or. scan(name, '/ ') > 0 &
         & .or. len(name) > longest_name) then
         call raise(error, "channel '"//name//"': not a name of a channel")
      else if (width < 1) then
         call raise(error, "channel '"//name//"': width "//as_text(width)//' is not positive')
      else if (object_exists(self%file, '/channels/'//name)) then
         call raise(error, "channel '"//name//"': defined twice")
      end if
   end subroutine check_definition

   !> Takes a sample; it reaches the file at once or some seconds later.
   subroutine append(self, t, values, error)
      !> Open history with its channels
      class(history_type), intent(inout) :: self
      !> Time, in the unit of `define_time`
      real(wp), intent(in) :: t
      !> All channels and other series one after another in the order of definition, (width)
      real(wp), intent(in) :: values(:)
      !> Allocated if the file cannot be written
      type(error_type), allocatable, intent(out) :: error
      if (self%failed .or. (self%time%id == no_id .and. .not. self%unkept)) then
         call raise(error, 'results file: a sample for a history that is not open, or could not be written before')
         return
      else if (size(values) /= self%width) then
         call raise(error, self%path//': a sample of '//as_text(size(values))//' numbers for channels of '// &
            & as_text(self%width))
         return
      end if
      if (self%unkept) then
         self%samples = self%samples + 1
         return
      end if
      if (.not. allocated(self%buffer)) then
         allocate (self%times(held_rows(self%width)), self%buffer(self%width*held_rows(self%width)))
      end if
      call put_sample(self%channels, size(self%times), self%waiting, values, self%buffer)
      self%waiting = self%waiting + 1
      self%samples = self%samples + 1
      self%times(self%waiting) = t
      if (is_time(self)) then
         call self%flush(error)
      else if (self%waiting == size(self%times)) then
         call self%write_samples(error)
      end if
   end subroutine append

   !> Whether the samples so far are to stand under the name of the file now. Where samples come quickly only some of them look at
   !> the clock.
   logical function is_time(self)
      class(history_type), intent(inout) :: self
      !> Time between two looks below which there are fewer [s]; most samples between two
      real(wp), parameter :: quick = 1.0e-3_wp
      integer, parameter :: most_between = 16
      integer(long) :: clock, ticks_per_second
      real(wp) :: interval
      is_time = .false.
      self%countdown = self%countdown - 1
      if (self%countdown > 0) return
      call system_clock(clock, ticks_per_second)
      interval = max(self%flush_interval, self%names%pause)
      is_time = real(clock - self%last_write, wp) >= interval*real(ticks_per_second, wp)
      self%stride = min(2*self%stride, most_between)
      if (real(clock - self%looked, wp) > min(quick, interval)*real(ticks_per_second, wp)) self%stride = 1
      self%countdown = self%stride
      self%looked = clock
   end function is_time

   !> Puts a sample behind those that wait.
   pure subroutine put_sample(channels, capacity, waiting, values, buffer)
      !> Channels; samples that the buffer holds, and those in it
      type(series_type), intent(in) :: channels(:)
      integer, intent(in) :: capacity, waiting
      !> All channels one after another
      real(wp), intent(in) :: values(:)
      !> Channel by channel
      real(wp), intent(inout) :: buffer(:)
      integer :: i, k, first
      first = 0
      do i = 1, size(channels)
         do k = 1, channels(i)%width
            buffer(first*capacity + channels(i)%width*waiting + k) = values(first + k)
         end do
         first = first + channels(i)%width
      end do
   end subroutine put_sample

   !> Writes the samples that wait.
   subroutine write_samples(self, error)
      !> Open history
      class(history_type), intent(inout) :: self
      !> Allocated if the file cannot be written; the history then takes no more samples
      type(error_type), allocatable, intent(out) :: error
      integer :: i, first
      if (self%file == no_id .or. self%failed .or. self%waiting == 0) return
      first = 1
      do i = 1, size(self%channels)
         call append_rows(self%channels(i), self%waiting, self%buffer(first:), error)
         if (allocated(error)) exit
         first = first + self%channels(i)%width*size(self%times)
      end do
      if (.not. allocated(error)) call append_rows(self%time, self%waiting, self%times, error)
      self%failed = allocated(error)
      self%waiting = 0
   end subroutine write_samples

   !> Lets the samples so far, and all else, stand under the name of the file. If there is no room for a copy that is left for
   !> a later time, and `trouble` says so.
   subroutine flush_samples(self, error)
      !> Open history
      class(history_type), intent(inout) :: self
      !> Allocated if the file cannot be written; the history then takes no more samples
      type(error_type), allocatable, intent(out) :: error
      integer :: status
      if (self%file == no_id .or. self%failed) return
      call self%write_samples(error)
      if (.not. allocated(error)) then
         call h5fflush_f(self%file, h5f_scope_global_f, status)
         if (status < 0) call hdf5_error(error, self%file, 'cannot write')
      end if
      if (.not. allocated(error) .and. self%samples >= self%safe) then
         call self%names%publish(self%trouble, error)
         if (self%trouble == '' .and. .not. allocated(error)) self%safe = self%samples
      end if
      self%failed = allocated(error)
      call system_clock(self%last_write)
   end subroutine flush_samples

   !> The same, at the wish of somebody who has to know whether it was done.
   subroutine secure_samples(self, trouble, error)
      class(history_type), intent(inout) :: self
      character(:), allocatable, intent(out) :: trouble
      type(error_type), allocatable, intent(out) :: error
      call self%flush(error)
      trouble = self%trouble
   end subroutine secure_samples

   !> Takes note that there is a checkpoint: who finds the file without one will know that it was lost.
   subroutine note_checkpoint(self, error)
      class(history_type), intent(inout) :: self
      type(error_type), allocatable, intent(out) :: error
      if (self%unkept) return
      if (.not. self%has_checkpoint) call write_attribute(self%file, '/run', 'checkpoints', 1, error)
      self%has_checkpoint = .true.
      self%failed = self%failed .or. allocated(error)
   end subroutine note_checkpoint

   !> Writes what is left and how the run ended, and closes the file; a second call does nothing. Call it also after
   !> an error, with `complete` false: the file is closed in any case. One that could not be written is removed; what stands under
   !> its name, `safe` samples of it, stays.
   subroutine finish(self, complete, status, error)
      !> History
      class(history_type), intent(inout) :: self
      !> Whether the run reached its end
      logical, intent(in) :: complete
      !> How it ended, such as 'finished' or the message of its error
      character(*), intent(in) :: status
      !> Allocated if the file cannot be written
      type(error_type), allocatable, intent(out) :: error
      type(error_type), allocatable :: close_error
      integer :: i
      if (self%unkept .and. allocated(self%channels)) then
         deallocate (self%channels)
         self%width = 0
      end if
      if (self%file == no_id) return
      call self%write_samples(error)
      if (.not. (allocated(error) .or. self%failed)) then
         call write_attribute(self%file, '/run', 'status', status, error)
         if (complete .and. .not. allocated(error)) call write_attribute(self%file, '/run', 'complete', 1, error)
      end if
      do i = 1, size(self%channels)
         call close_series(self%channels(i))
      end do
      call close_series(self%time)
      call close_file(self%path, self%file, close_error)
      if (allocated(close_error) .and. .not. allocated(error)) call move_alloc(close_error, error)
      self%failed = self%failed .or. allocated(error)
      if (self%failed) call self%names%drop()
      if (.not. self%failed) call self%names%put_in_place(error)
      if (.not. (self%failed .or. allocated(error))) self%safe = self%samples
      deallocate (self%channels)
      if (allocated(self%buffer)) deallocate (self%buffer, self%times)
      self%width = 0
      self%waiting = 0
      self%resumed = .false.
   end subroutine finish

   !> Writes the dataset /<group>/<name> beside the channel of that name, whose attribute <group> becomes its path.
   subroutine put_beside(self, group, name, values, units, long_name, error)
      !> Open history; its samples should all be there
      class(history_type), intent(in) :: self
      !> Name of the group, which is made if need be, and of a channel
      character(*), intent(in) :: group, name
      !> (width, samples), of the shape of the channel
      real(wp), contiguous, intent(in) :: values(:, :)
      !> Unit, and one line for people
      character(*), intent(in) :: units, long_name
      !> Allocated if it cannot be written
      type(error_type), allocatable, intent(out) :: error
      type(series_type) :: series
      character(:), allocatable :: path
      if (self%unkept) return
      path = '/'//group//'/'//name
      call create_group(self%file, '/'//group, error)
      if (.not. allocated(error)) &
         & call create_series(self%file, path, size(values, 1), chunk_rows(size(values, 1)), series, error)
      if (allocated(error)) return
      call append_rows(series, size(values, 2), values, error)
      if (.not. allocated(error)) call self%attach_scales(series, path, error)
      if (.not. allocated(error)) call write_attribute(self%file, path, 'units', units, error)
      if (.not. allocated(error)) call write_attribute(self%file, path, 'long_name', long_name, error)
      if (.not. allocated(error)) call write_attribute(self%file, '/channels/'//name, group, path, error)
      call close_series(series)
   end subroutine put_beside

   !> Writes the number of the analysis that each sample belongs to, as /step beside the time.
   subroutine put_steps(self, steps, error)
      !> Open history; its samples should all be there
      class(history_type), intent(in) :: self
      !> Analysis of each sample
      integer, intent(in) :: steps(:)
      !> Allocated if it cannot be written
      type(error_type), allocatable, intent(out) :: error
      if (self%unkept) return
      ! Of a run that goes on: the time must not point to what is replaced
      if (object_exists(self%file, '/step')) call detach_scale(self%file, '/step', self%time%id)
      call self%put_integer('/step', steps, 'number of the analysis', error)
      if (.not. allocated(error)) call attach_scale(self%file, '/step', self%time%id, error)
   end subroutine put_steps

   !> Rows in a chunk of the file: 256, fewer if a row is long, at least 64.
   pure integer function chunk_rows(width) result(rows)
      !> Numbers in a row
      integer, intent(in) :: width
      integer, parameter :: numbers_at_once = 131072
      rows = max(64, min(256, numbers_at_once/max(1, width)))
   end function chunk_rows

   !> Rows that the buffer holds: as many chunks as make 4096 rows, fewer if a row is long. To open a chunk costs as much as to take
   !> a hundred samples.
   pure integer function held_rows(width) result(rows)
      !> Numbers in a row
      integer, intent(in) :: width
      integer, parameter :: most_rows = 4096, numbers_held = 131072
      rows = chunk_rows(width)*max(1, min(most_rows, numbers_held/max(1, width))/chunk_rows(width))
   end function held_rows

end module limber_output_history
