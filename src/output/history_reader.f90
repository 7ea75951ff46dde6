!> Reader of histories. What channels it has, and their samples. Floor: output; export, diff and every analysis that starts from
!> results use it.
module limber_output_history_reader
   use hdf5, only: hid_t, hsize_t
   use limber_base_error, only: error_type, raise, status_deck
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, lowercase, nearest_name
   use limber_output_hdf5, only: open_file, close_file, object_exists
   use limber_output_hdf5_error, only: no_id
   use limber_output_hdf5_read, only: dataset_shape, list_members, read_attribute, read_dataset, longest_name
   use limber_output_history, only: history_format, history_format_version
   implicit none
   private
   public :: history_reader_type, stored_channel_type

   !> What a results file says of one channel
   type :: stored_channel_type
      !> Name in the deck
      character(:), allocatable :: name
      !> Numbers in each sample
      integer :: width = 1
      !> Unit and one line for people
      character(:), allocatable :: units, long_name
      !> Path of its dataset in the file
      character(:), allocatable :: path
   end type stored_channel_type

   !> Name of an estimate of error: that of the channel with this behind it
   character(*), parameter :: error_suffix = '_error'

   !> An open results file: open, read_time, read_channel ..., close
   type :: history_reader_type
      !> Name of the file
      character(:), allocatable :: path
      !> Version of limber that wrote it
      character(:), allocatable :: version
      !> Samples that time and all channels have
      integer :: samples = 0
      !> Whether the run reached its end
      logical :: complete = .false.
      !> How the run ended; 'running' if it was killed, or still runs
      character(:), allocatable :: status
      !> Unit of time
      character(:), allocatable :: time_units
      !> Channels in the order of their definition
      type(stored_channel_type), allocatable :: channels(:)
      !> Estimated errors of channels, as far as the file has any: NAME_error for the channel NAME, in the same order
      type(stored_channel_type), allocatable :: estimates(:)
      integer(hid_t), private :: file = no_id
   contains
      procedure :: open => open_history, close => close_history, read_time, read_channel, read_numbers, read_text, read_statistic, &
         & find_channel
      procedure :: has, read_table, read_label
   end type history_reader_type

contains

   !> Opens a results file and reads its list of channels.
   subroutine open_history(self, path, error)
      !> Reader; an older file is closed
      class(history_reader_type), intent(inout) :: self
      !> Name of the file
      character(*), intent(in) :: path
      !> Allocated if it is missing, damaged, or no history of this format
      type(error_type), allocatable, intent(out) :: error
      call self%close()
      self%path = trim(path)
      call open_file(self%path, self%file, error)
      if (allocated(error)) return
      call check_format(self, error)
      if (.not. allocated(error)) call read_header(self, error)
      if (.not. allocated(error)) call read_channel_list(self, error)
      if (.not. allocated(error)) call read_estimate_list(self, error)
      if (allocated(error)) call self%close()
   end subroutine open_history

   !> Refuses a file that is no history, or one of another version of the format.
   subroutine check_format(self, error)
      class(history_reader_type), intent(in) :: self
      type(error_type), allocatable, intent(out) :: error
      type(error_type), allocatable :: absent
      character(:), allocatable :: format
      integer :: format_version
      call read_attribute(self%file, '/', 'format', format, absent)
      if (allocated(absent) .or. format /= history_format) then
         call raise(error, self%path//' is not a results file of limber (its attribute format is not "'// &
            & history_format//'")', status_deck)
         return
      end if
      call read_attribute(self%file, '/', 'format_version', format_version, error)
      if (allocated(error)) return
      if (format_version /= history_format_version) then
         call raise(error, self%path//' has version '//as_text(format_version)//' of the format; this limber reads '// &
            & 'version '//as_text(history_format_version), status_deck)
      end if
   end subroutine check_format

   !> Reads what the file says of the run and of time.
   subroutine read_header(self, error)
      class(history_reader_type), intent(inout) :: self
      type(error_type), allocatable, intent(out) :: error
      integer(hsize_t), allocatable :: extent(:)
      integer :: complete
      call read_attribute(self%file, '/', 'limber_version', self%version, error)
      if (.not. allocated(error)) call read_attribute(self%file, '/run', 'status', self%status, error)
      if (.not. allocated(error)) call read_attribute(self%file, '/run', 'complete', complete, error)
      if (.not. allocated(error)) call read_attribute(self%file, '/time', 'units', self%time_units, error)
      if (.not. allocated(error)) call dataset_shape(self%file, '/time', extent, error)
      if (allocated(error)) return
      if (size(extent) /= 1) then
         call raise(error, self%path//': /time is not an axis of time', status_deck)
         return
      end if
      self%complete = complete /= 0
      self%samples = int(extent(size(extent)))
   end subroutine read_header

   !> Reads the list of channels. A kill can leave some channels a few rows longer than others: the shortest counts.
   subroutine read_channel_list(self, error)
      class(history_reader_type), intent(inout) :: self
      type(error_type), allocatable, intent(out) :: error
      character(longest_name), allocatable :: names(:)
      integer :: i, samples
      call list_members(self%file, '/channels', names, error)
      if (allocated(error)) return
      allocate (self%channels(size(names)))
      do i = 1, size(names)
         self%channels(i)%name = trim(names(i))
         self%channels(i)%path = '/channels/'//trim(names(i))
         call read_description(self, self%channels(i), samples, error)
         if (allocated(error)) return
         self%samples = min(self%samples, samples)
      end do
   end subroutine read_channel_list

   !> Reads the list of estimated errors. A channel that is called like one hides it, and one that a kill left short is none.
   subroutine read_estimate_list(self, error)
      class(history_reader_type), intent(inout) :: self
      type(error_type), allocatable, intent(out) :: error
      character(*), parameter :: group = '/error_estimate/'
      integer :: i, count, samples
      count = 0
      allocate (self%estimates(size(self%channels)))
      do i = 1, size(self%channels)
         if (.not. object_exists(self%file, group//self%channels(i)%name)) cycle
         if (has_channel(self%channels(i)%name//error_suffix)) cycle
         self%estimates(count + 1)%name = self%channels(i)%name//error_suffix
         self%estimates(count + 1)%path = group//self%channels(i)%name
         call read_description(self, self%estimates(count + 1), samples, error)
         if (allocated(error)) return
         if (samples >= self%samples) count = count + 1
      end do
      self%estimates = self%estimates(:count)

   contains

      logical function has_channel(name)
         character(*), intent(in) :: name
         integer :: k
         has_channel = .false.
         do k = 1, size(self%channels)
            if (self%channels(k)%name == name) has_channel = .true.
         end do
      end function has_channel

   end subroutine read_estimate_list

   !> Reads unit, meaning and width of a channel.
   subroutine read_description(self, channel, samples, error)
      class(history_reader_type), intent(in) :: self
      !> With its path
      type(stored_channel_type), intent(inout) :: channel
      !> Samples that it has
      integer, intent(out) :: samples
      type(error_type), allocatable, intent(out) :: error
      integer(hsize_t), allocatable :: extent(:)
      samples = 0
      call dataset_shape(self%file, channel%path, extent, error)
      if (.not. allocated(error)) call read_attribute(self%file, channel%path, 'units', channel%units, error)
      if (.not. allocated(error)) call read_attribute(self%file, channel%path, 'long_name', channel%long_name, error)
      if (allocated(error)) return
      if (size(extent) < 1 .or. size(extent) > 2) then
         call raise(error, self%path//': '//channel%path//' is not a channel', status_deck)
         return
      end if
      if (size(extent) == 2) channel%width = int(extent(1))
      samples = int(extent(size(extent)))
   end subroutine read_description

   !> Closes the file; does nothing if none is open.
   subroutine close_history(self)
      !> Reader
      class(history_reader_type), intent(inout) :: self
      type(error_type), allocatable :: ignored
      if (self%file /= no_id) call close_file(self%path, self%file, ignored)
      if (allocated(self%channels)) deallocate (self%channels)
      if (allocated(self%estimates)) deallocate (self%estimates)
      self%samples = 0
      self%complete = .false.
   end subroutine close_history

   !> Reads the times of all samples.
   subroutine read_time(self, time, error)
      !> Open reader
      class(history_reader_type), intent(in) :: self
      !> Times [time_units], (samples)
      real(wp), allocatable, intent(out) :: time(:)
      !> Allocated if they cannot be read
      type(error_type), allocatable, intent(out) :: error
      call read_dataset(self%file, '/time', time, error)
      if (allocated(error)) return
      if (size(time) > self%samples) time = time(:self%samples)
   end subroutine read_time

   !> Reads all samples of a channel, or of its estimated error.
   subroutine read_channel(self, name, values, error)
      !> Open reader
      class(history_reader_type), intent(in) :: self
      !> Name of the channel or estimate
      character(*), intent(in) :: name
      !> Values [units of the channel], (width, samples)
      real(wp), allocatable, intent(out) :: values(:, :)
      !> Allocated if there is no such channel or it cannot be read
      type(error_type), allocatable, intent(out) :: error
      type(stored_channel_type) :: channel
      call self%find_channel(name, channel, error)
      if (allocated(error)) return
      call read_dataset(self%file, channel%path, values, error)
      if (allocated(error)) return
      if (size(values, 2) > self%samples) values = values(:, :self%samples)
   end subroutine read_channel

   !> Reads a dataset of one dimension that is no channel, such as '/modes/<name>/frequency'.
   subroutine read_numbers(self, path, values, error)
      !> Open reader
      class(history_reader_type), intent(in) :: self
      !> Absolute path
      character(*), intent(in) :: path
      !> Numbers as they were put
      real(wp), allocatable, intent(out) :: values(:)
      !> Allocated if there are none
      type(error_type), allocatable, intent(out) :: error
      if (object_exists(self%file, path)) then
         call read_dataset(self%file, path, values, error)
      else
         call raise(error, self%path//' has no '//path, status_deck)
      end if
   end subroutine read_numbers

   !> Reads a text, such as '/run/deck'.
   subroutine read_text(self, path, text, error)
      !> Open reader
      class(history_reader_type), intent(in) :: self
      !> Absolute path
      character(*), intent(in) :: path
      !> Text as it was put
      character(:), allocatable, intent(out) :: text
      !> Allocated if there is no such text
      type(error_type), allocatable, intent(out) :: error
      if (object_exists(self%file, path)) then
         call read_dataset(self%file, path, text, error)
      else
         call raise(error, self%path//' has no '//path, status_deck)
      end if
   end subroutine read_text

   !> Whether the file has a group or dataset.
   logical function has(self, path)
      !> Open reader
      class(history_reader_type), intent(in) :: self
      !> Absolute path
      character(*), intent(in) :: path
      has = object_exists(self%file, path)
   end function has

   !> Reads a dataset of two dimensions, such as '/motion/places'.
   subroutine read_table(self, path, values, error)
      !> Open reader
      class(history_reader_type), intent(in) :: self
      !> Absolute path
      character(*), intent(in) :: path
      !> Numbers, in Fortran order
      real(wp), allocatable, intent(out) :: values(:, :)
      !> Allocated if there is no such dataset
      type(error_type), allocatable, intent(out) :: error
      call read_dataset(self%file, path, values, error)
   end subroutine read_table

   !> Reads a text that is an attribute, such as 'heading' of '/run'.
   subroutine read_label(self, path, name, text, error)
      !> Open reader
      class(history_reader_type), intent(in) :: self
      !> Absolute path of the group or dataset, and name of its attribute
      character(*), intent(in) :: path, name
      !> Text as it was put
      character(:), allocatable, intent(out) :: text
      !> Allocated if there is no such text
      type(error_type), allocatable, intent(out) :: error
      call read_attribute(self%file, path, name, text, error)
   end subroutine read_label

   !> Reads a number that the run left among its statistics, an attribute of /run or of another group.
   subroutine read_statistic(self, name, value, error, group)
      !> Open reader
      class(history_reader_type), intent(in) :: self
      !> Name of the attribute, such as 'steps'
      character(*), intent(in) :: name
      real(wp), intent(out) :: value
      !> Allocated if there is no such number
      type(error_type), allocatable, intent(out) :: error
      !> Absolute path of the other group
      character(*), intent(in), optional :: group
      if (present(group)) then
         call read_attribute(self%file, group, name, value, error)
      else
         call read_attribute(self%file, '/run', name, value, error)
      end if
      if (allocated(error)) error%message = self%path//': '//error%message
   end subroutine read_statistic

   !> Looks a channel, or an estimate, up by its name.
   subroutine find_channel(self, name, channel, error)
      !> Open reader
      class(history_reader_type), intent(in) :: self
      !> Name of the channel
      character(*), intent(in) :: name
      type(stored_channel_type), intent(out) :: channel
      !> Allocated if there is no such channel: names the nearest one and lists all
      type(error_type), allocatable, intent(out) :: error
      character(longest_name), allocatable :: names(:)
      character(:), allocatable :: message
      integer :: i, nearest
      do i = 1, size(self%channels)
         if (lowercase(self%channels(i)%name) == lowercase(name)) then
            channel = self%channels(i)
            return
         end if
      end do
      do i = 1, size(self%estimates)
         if (lowercase(self%estimates(i)%name) == lowercase(name)) then
            channel = self%estimates(i)
            return
         end if
      end do
      message = self%path//" has no channel '"//trim(name)//"'"
      allocate (names(size(self%channels)))
      do i = 1, size(names)
         names(i) = self%channels(i)%name
      end do
      nearest = nearest_name(name, names)
      if (nearest > 0) message = message//"; did you mean '"//trim(names(nearest))//"'?"
      do i = 1, size(names)
         if (i == 1) message = message//new_line('a')//'its channels: '
         if (i > 1) message = message//', '
         message = message//trim(names(i))
      end do
      call raise(error, message, status_deck)
   end subroutine find_channel

end module limber_output_history_reader
