!> The C interface: what include/limber.h declares. Each run is behind an opaque pointer. Nothing here prints or stops; errors are
!> texts that the run keeps. Floor: library. What it means stands in limber.h and doc/library.md.
module limber_library_c_interface
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_f_pointer, c_int, c_int64_t, c_loc, c_null_char, &
      & c_ptr, c_size_t
   use limber_base_error, only: error_type, raise, status_deck
   use limber_base_kinds, only: wp
   use limber_base_lock, only: take_lock, release_lock
   use limber_base_text, only: as_text, newline
   use limber_base_version, only: version
   use limber_commands_sweep_plan, only: swept_type, read_setting
   use limber_deck_parameters, only: override_type
   use limber_library_state_words, only: pack_state, unpack_state
   use limber_library_stepped_run, only: stepped_run_type, saved_type
   implicit none
   private

   !> A text as C knows it, with a null character at its end
   type :: c_text_type
      character(kind=c_char), allocatable :: letters(:)
   end type c_text_type

   !> Names, units and meanings of a list of numbers
   type :: legend_type
      type(c_text_type), allocatable :: names(:), units(:), meanings(:)
   end type legend_type

   !> What is behind the pointer
   type :: handle_type
      type(stepped_run_type) :: run
      !> Status of the last call that can fail, and its message
      integer(c_int) :: status = 0
      type(c_text_type) :: message, warnings, time_unit
      type(legend_type) :: channels, scalars, coordinates, inputs
   end type handle_type

   !> The version, for as long as the process lives
   character(kind=c_char), target :: own_version(len(version) + 1) = ' '

   !> An empty list
   type(legend_type), target :: no_legend

   interface
      integer(c_size_t) function c_strlen(text) bind(c, name='strlen')
         import :: c_ptr, c_size_t
         type(c_ptr), value :: text
      end function c_strlen
      function c_memcpy(to, from, count) bind(c, name='memcpy') result(same)
         import :: c_ptr, c_size_t
         type(c_ptr), value :: to, from
         integer(c_size_t), value :: count
         type(c_ptr) :: same
      end function c_memcpy
   end interface

contains

   !> limber_version
   recursive type(c_ptr) function version_of_library() bind(c, name='limber_version') result(text)
      integer :: i
      call take_lock()
      do i = 1, len(version)
         own_version(i) = version(i:i)
      end do
      own_version(len(version) + 1) = c_null_char
      call release_lock()
      text = c_loc(own_version)
   end function version_of_library

   !> limber_open
   recursive type(c_ptr) function open_file(path, settings) bind(c, name='limber_open') result(pointer)
      type(c_ptr), value :: path, settings
      type(handle_type), pointer :: handle
      type(override_type), allocatable :: overrides(:)
      type(error_type), allocatable :: error
      call take_lock()
      allocate (handle)
      call read_settings(fortran_text(settings), overrides, error)
      if (.not. allocated(error)) call handle%run%open(fortran_text(path), error, overrides)
      call finish_opening(handle, error)
      call release_lock()
      pointer = c_loc(handle)
   end function open_file

   !> limber_open_text
   recursive type(c_ptr) function open_text(text, name, settings) bind(c, name='limber_open_text') result(pointer)
      type(c_ptr), value :: text, name, settings
      type(handle_type), pointer :: handle
      type(override_type), allocatable :: overrides(:)
      type(error_type), allocatable :: error
      call take_lock()
      allocate (handle)
      call read_settings(fortran_text(settings), overrides, error)
      if (.not. allocated(error)) call handle%run%open_text(fortran_text(text), fortran_text(name), error, overrides)
      call finish_opening(handle, error)
      call release_lock()
      pointer = c_loc(handle)
   end function open_text

   !> limber_close
   recursive subroutine close_run(pointer) bind(c, name='limber_close')
      type(c_ptr), value :: pointer
      type(handle_type), pointer :: handle
      if (.not. c_associated(pointer)) return
      call take_lock()
      call c_f_pointer(pointer, handle)
      deallocate (handle)
      call release_lock()
   end subroutine close_run

   !> limber_status
   recursive integer(c_int) function status_of(pointer) bind(c, name='limber_status') result(status)
      type(c_ptr), value :: pointer
      type(handle_type), pointer :: handle
      call c_f_pointer(pointer, handle)
      status = handle%status
   end function status_of

   !> limber_error
   recursive type(c_ptr) function error_of(pointer) bind(c, name='limber_error') result(text)
      type(c_ptr), value :: pointer
      type(handle_type), pointer :: handle
      call c_f_pointer(pointer, handle)
      text = c_loc(handle%message%letters)
   end function error_of

   !> limber_warnings
   recursive type(c_ptr) function warnings_of(pointer) bind(c, name='limber_warnings') result(text)
      type(c_ptr), value :: pointer
      type(handle_type), pointer :: handle
      call take_lock()
      call c_f_pointer(pointer, handle)
      if (allocated(handle%run%warnings)) call set_text(handle%warnings, handle%run%warnings)
      call release_lock()
      text = c_loc(handle%warnings%letters)
   end function warnings_of

   !> limber_advance
   recursive integer(c_int) function advance(pointer, t) bind(c, name='limber_advance') result(status)
      type(c_ptr), value :: pointer
      real(c_double), value :: t
      type(handle_type), pointer :: handle
      type(error_type), allocatable :: error
      call take_lock()
      call c_f_pointer(pointer, handle)
      if (is_open(handle)) then
         call handle%run%advance(real(t, wp), error)
         call note(handle, error)
      end if
      status = handle%status
      call release_lock()
   end function advance

   !> limber_finish
   recursive integer(c_int) function finish(pointer) bind(c, name='limber_finish') result(status)
      type(c_ptr), value :: pointer
      status = advance(pointer, huge(1.0_c_double))
   end function finish

   !> limber_time
   recursive real(c_double) function time_of(pointer) bind(c, name='limber_time') result(t)
      type(c_ptr), value :: pointer
      type(handle_type), pointer :: handle
      call c_f_pointer(pointer, handle)
      t = handle%run%time
   end function time_of

   !> limber_end_time
   recursive real(c_double) function end_of(pointer) bind(c, name='limber_end_time') result(t)
      type(c_ptr), value :: pointer
      type(handle_type), pointer :: handle
      call c_f_pointer(pointer, handle)
      t = handle%run%end
   end function end_of

   !> limber_is_complete
   recursive integer(c_int) function is_complete(pointer) bind(c, name='limber_is_complete') result(answer)
      type(c_ptr), value :: pointer
      type(handle_type), pointer :: handle
      call c_f_pointer(pointer, handle)
      answer = merge(1_c_int, 0_c_int, handle%run%is_complete .and. .not. handle%run%time < handle%run%end)
   end function is_complete

   !> limber_time_unit
   recursive type(c_ptr) function unit_of_time(pointer) bind(c, name='limber_time_unit') result(text)
      type(c_ptr), value :: pointer
      type(handle_type), pointer :: handle
      call c_f_pointer(pointer, handle)
      text = c_loc(handle%time_unit%letters)
   end function unit_of_time

   !> limber_count
   recursive integer(c_int) function count_of(pointer, list) bind(c, name='limber_count') result(number)
      type(c_ptr), value :: pointer
      integer(c_int), value :: list
      type(legend_type), pointer :: legend
      call find_legend(pointer, list, legend)
      number = 0
      if (allocated(legend%names)) number = size(legend%names, kind=c_int)
   end function count_of

   !> limber_name
   recursive type(c_ptr) function name_of(pointer, list, index) bind(c, name='limber_name') result(text)
      type(c_ptr), value :: pointer
      integer(c_int), value :: list, index
      type(legend_type), pointer :: legend
      call find_legend(pointer, list, legend)
      text = letters_of(pointer, legend%names, index)
   end function name_of

   !> limber_unit
   recursive type(c_ptr) function unit_of(pointer, list, index) bind(c, name='limber_unit') result(text)
      type(c_ptr), value :: pointer
      integer(c_int), value :: list, index
      type(legend_type), pointer :: legend
      call find_legend(pointer, list, legend)
      text = letters_of(pointer, legend%units, index)
   end function unit_of

   !> limber_meaning
   recursive type(c_ptr) function meaning_of(pointer, list, index) bind(c, name='limber_meaning') result(text)
      type(c_ptr), value :: pointer
      integer(c_int), value :: list, index
      type(legend_type), pointer :: legend
      call find_legend(pointer, list, legend)
      text = letters_of(pointer, legend%meanings, index)
   end function meaning_of

   !> limber_values
   recursive integer(c_int) function values_of(pointer, values) bind(c, name='limber_values') result(status)
      type(c_ptr), value :: pointer, values
      type(handle_type), pointer :: handle
      type(error_type), allocatable :: error
      real(c_double), pointer :: room(:)
      call take_lock()
      call c_f_pointer(pointer, handle)
      if (is_open(handle)) then
         call c_f_pointer(values, room, [size(handle%channels%names)])
         call handle%run%show(room, error)
         call note(handle, error)
      end if
      status = handle%status
      call release_lock()
   end function values_of

   !> limber_sample_count
   recursive integer(c_int) function number_of_samples(pointer) bind(c, name='limber_sample_count') result(number)
      type(c_ptr), value :: pointer
      type(handle_type), pointer :: handle
      call take_lock()
      call c_f_pointer(pointer, handle)
      number = 0
      if (allocated(handle%run%store%times)) number = int(handle%run%samples(), c_int)
      call release_lock()
   end function number_of_samples

   !> limber_samples
   recursive subroutine samples_of(pointer, times, values) bind(c, name='limber_samples')
      type(c_ptr), value :: pointer, times, values
      type(handle_type), pointer :: handle
      real(c_double), pointer :: room_for_times(:), room(:, :)
      integer :: count
      call take_lock()
      call c_f_pointer(pointer, handle)
      if (allocated(handle%run%store%times)) then
         count = handle%run%samples()
         call c_f_pointer(times, room_for_times, [count])
         call c_f_pointer(values, room, [size(handle%channels%names), count])
         room_for_times = handle%run%store%times(:count)
         room = handle%run%store%channels(:, :count)
      end if
      call release_lock()
   end subroutine samples_of

   !> limber_scalars
   recursive subroutine scalars_of(pointer, values) bind(c, name='limber_scalars')
      type(c_ptr), value :: pointer, values
      type(handle_type), pointer :: handle
      real(c_double), pointer :: room(:)
      call take_lock()
      call c_f_pointer(pointer, handle)
      if (allocated(handle%scalars%names)) then
         call c_f_pointer(values, room, [size(handle%scalars%names)])
         if (size(room) > 0) room = handle%run%scalars()
      end if
      call release_lock()
   end subroutine scalars_of

   !> limber_state
   recursive subroutine state_of(pointer, q, v) bind(c, name='limber_state')
      type(c_ptr), value :: pointer, q, v
      type(handle_type), pointer :: handle
      real(c_double), pointer :: room(:)
      call take_lock()
      call c_f_pointer(pointer, handle)
      if (allocated(handle%run%q)) then
         call c_f_pointer(q, room, [size(handle%run%q)])
         room = handle%run%q
         call c_f_pointer(v, room, [size(handle%run%v)])
         room = handle%run%v
      end if
      call release_lock()
   end subroutine state_of

   !> limber_set_input
   recursive integer(c_int) function set_input(pointer, name, value) bind(c, name='limber_set_input') result(status)
      type(c_ptr), value :: pointer, name
      real(c_double), value :: value
      type(handle_type), pointer :: handle
      type(error_type), allocatable :: error
      call take_lock()
      call c_f_pointer(pointer, handle)
      if (is_open(handle)) then
         call handle%run%set_input(fortran_text(name), real(value, wp), error)
         call note(handle, error)
      end if
      status = handle%status
      call release_lock()
   end function set_input

   !> limber_save
   recursive integer(c_size_t) function save_state(pointer, buffer, size_of_buffer) bind(c, name='limber_save') result(bytes)
      type(c_ptr), value :: pointer, buffer
      integer(c_size_t), value :: size_of_buffer
      type(handle_type), pointer :: handle
      type(error_type), allocatable :: error
      type(saved_type) :: saved
      integer(c_int64_t), allocatable, target :: words(:)
      type(c_ptr) :: ignored
      bytes = 0
      call take_lock()
      call c_f_pointer(pointer, handle)
      if (is_open(handle)) then
         call handle%run%save(saved, error)
         call note(handle, error)
         if (handle%status == 0) then
            call pack_state(saved, words)
            bytes = 8*size(words, kind=c_size_t)
            if (bytes <= size_of_buffer) ignored = c_memcpy(buffer, c_loc(words), bytes)
         end if
      end if
      call release_lock()
   end function save_state

   !> limber_restore
   recursive integer(c_int) function restore_state(pointer, buffer, bytes) bind(c, name='limber_restore') result(status)
      type(c_ptr), value :: pointer, buffer
      integer(c_size_t), value :: bytes
      type(handle_type), pointer :: handle
      type(error_type), allocatable :: error
      type(saved_type) :: saved
      integer(c_int64_t), allocatable, target :: words(:)
      type(c_ptr) :: ignored
      call take_lock()
      call c_f_pointer(pointer, handle)
      if (is_open(handle)) then
         allocate (words(bytes/8))
         if (size(words) > 0) ignored = c_memcpy(c_loc(words), buffer, 8*size(words, kind=c_size_t))
         call unpack_state(words, saved, error)
         if (.not. allocated(error)) call handle%run%restore(saved, error)
         call note(handle, error)
      end if
      status = handle%status
      call release_lock()
   end function restore_state

   !> Takes note of what came of opening a deck, and of the names that it has.
   recursive subroutine finish_opening(handle, error)
      type(handle_type), intent(inout) :: handle
      type(error_type), allocatable, intent(in) :: error
      integer :: i, n
      call set_text(handle%warnings, '')
      call set_text(handle%time_unit, '')
      call note(handle, error)
      if (allocated(error)) return
      associate (run => handle%run, model => handle%run%scene%system%model)
         call set_text(handle%time_unit, model%units%time)
         n = size(model%channels)
         call start_legend(handle%channels, n)
         do i = 1, n
            call set_text(handle%channels%names(i), model%channels(i)%name)
            call set_text(handle%channels%units(i), model%channels(i)%units)
            call set_text(handle%channels%meanings(i), model%channels(i)%long_name)
         end do
         n = size(model%scalars)
         call start_legend(handle%scalars, n)
         do i = 1, n
            call set_text(handle%scalars%names(i), model%scalars(i)%name)
            call set_text(handle%scalars%units(i), model%scalars(i)%units)
         end do
         n = run%number_of_inputs()
         call start_legend(handle%inputs, n)
         do i = 1, n
            call set_text(handle%inputs%names(i), run%input_name(i))
         end do
      end associate
      call name_coordinates(handle)
   end subroutine finish_opening

   !> Names of the coordinates: of a body NAME the place of its frame, its direction, and its deflections.
   recursive subroutine name_coordinates(handle)
      type(handle_type), intent(inout) :: handle
      character(*), parameter :: frame(4) = [character(4) :: '.x', '.y', '.cos', '.sin']
      integer :: i, k, n
      associate (system => handle%run%scene%system, list => handle%coordinates)
         call start_legend(list, system%layout%nq)
         do i = 1, size(system%layout%q)
            associate (name => system%model%bodies(i)%name, first => system%layout%q(i) - 1)
               n = merge(4, 2, system%layout%framed(i))
               do k = 1, n
                  call set_text(list%names(first + k), name//trim(frame(k)))
                  if (k <= 2) call set_text(list%units(first + k), system%model%units%length)
               end do
               do k = 1, system%layout%n(i)
                  call set_text(list%names(first + n + k), name//'.eta'//as_text(k))
               end do
            end associate
         end do
      end associate
   end subroutine name_coordinates

   !> Makes a list of empty texts.
   recursive subroutine start_legend(legend, count)
      type(legend_type), intent(inout) :: legend
      integer, intent(in) :: count
      integer :: i
      allocate (legend%names(count), legend%units(count), legend%meanings(count))
      do i = 1, count
         call set_text(legend%names(i), '')
         call set_text(legend%units(i), '')
         call set_text(legend%meanings(i), '')
      end do
   end subroutine start_legend

   !> The list that a number of limber.h stands for; an empty one if it stands for none.
   recursive subroutine find_legend(pointer, list, legend)
      type(c_ptr), intent(in) :: pointer
      integer(c_int), intent(in) :: list
      type(legend_type), pointer, intent(out) :: legend
      type(handle_type), pointer :: handle
      call c_f_pointer(pointer, handle)
      select case (list)
      case (0); legend => handle%channels
      case (1); legend => handle%scalars
      case (2); legend => handle%coordinates
      case (3); legend => handle%inputs
      case default; legend => no_legend
      end select
   end subroutine find_legend

   !> A text of a list; the empty text of the time where the index, from 0, is none.
   recursive type(c_ptr) function letters_of(pointer, texts, index) result(text)
      type(c_ptr), intent(in) :: pointer
      type(c_text_type), allocatable, target, intent(in) :: texts(:)
      integer(c_int), intent(in) :: index
      type(handle_type), pointer :: handle
      call c_f_pointer(pointer, handle)
      text = c_loc(handle%time_unit%letters(size(handle%time_unit%letters)))
      if (.not. allocated(texts)) return
      if (index >= 0 .and. index < size(texts)) text = c_loc(texts(index + 1)%letters)
   end function letters_of

   !> Whether a run can be used; else its status says so.
   recursive logical function is_open(handle)
      type(handle_type), intent(in) :: handle
      is_open = allocated(handle%channels%names)
   end function is_open

   !> Takes note of an error, or of none.
   recursive subroutine note(handle, error)
      type(handle_type), intent(inout) :: handle
      type(error_type), allocatable, intent(in) :: error
      handle%status = 0
      if (allocated(error)) then
         handle%status = int(error%status, c_int)
         call set_text(handle%message, error%message)
      else
         call set_text(handle%message, '')
      end if
   end subroutine note

   !> Values of parameters, `name=value`, one a line.
   recursive subroutine read_settings(text, overrides, error)
      character(*), intent(in) :: text
      type(override_type), allocatable, intent(out) :: overrides(:)
      type(error_type), allocatable, intent(out) :: error
      type(swept_type) :: axis
      type(override_type) :: override
      integer :: first, length
      logical :: ok
      allocate (overrides(0))
      first = 1
      do while (first <= len(text))
         length = index(text(first:)//newline, newline) - 1
         if (len_trim(text(first:first + length - 1)) > 0) then
            call read_setting(trim(text(first:first + length - 1)), axis, ok)
            if (ok) ok = size(axis%values) == 1
            if (.not. ok) then
               call raise(error, "'"//text(first:first + length - 1)//"' is not name=value", status_deck)
               return
            end if
            override%name = axis%names(1)
            override%value = axis%values(1, 1)
            overrides = [overrides, override]
         end if
         first = first + length + 1
      end do
   end subroutine read_settings

   !> A text of C; empty for a null pointer.
   recursive function fortran_text(pointer) result(text)
      type(c_ptr), intent(in) :: pointer
      character(:), allocatable :: text
      character(kind=c_char), pointer :: letters(:)
      integer :: i, length
      text = ''
      if (.not. c_associated(pointer)) return
      length = int(c_strlen(pointer))
      call c_f_pointer(pointer, letters, [length])
      deallocate (text)
      allocate (character(length) :: text)
      do i = 1, length
         text(i:i) = letters(i)
      end do
   end function fortran_text

   !> Makes a text one of C.
   recursive subroutine set_text(to, text)
      type(c_text_type), intent(inout) :: to
      character(*), intent(in) :: text
      integer :: i
      if (allocated(to%letters)) deallocate (to%letters)
      allocate (to%letters(len(text) + 1))
      do i = 1, len(text)
         to%letters(i) = text(i:i)
      end do
      to%letters(len(text) + 1) = c_null_char
   end subroutine set_text

end module limber_library_c_interface
