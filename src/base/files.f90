!> Files and folders by POSIX. Names, lists. Floor: base.
module limber_base_files
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_pointer, c_int, c_int16_t, c_int32_t, c_int64_t, c_loc, &
      & c_null_char, c_null_funptr, c_null_ptr, c_funptr, c_ptr, c_size_t
   implicit none
   private
   public :: rename_file, copy_file, append_text, make_folder, files_like, remove_file, is_folder, may_write, is_locked
   public :: kind_of_path, same_file, unused_name, first_bytes

   !> Longest path
   integer, parameter, public :: longest_path = 4096
   !> What stands under a path: nothing, a file with content, a folder, anything else (a pipe, a device, a socket)
   integer, parameter, public :: path_free = 0, path_file = 1, path_folder = 2, path_other = 3
   !> Bytes that are copied at a time
   integer(c_size_t), parameter :: block_size = 1048576

   !> The beginning of POSIX's glob_t, and room for the rest
   type, bind(c) :: glob_type
      integer(c_size_t) :: count = 0
      type(c_ptr) :: paths = c_null_ptr
      integer(c_size_t) :: rest(32) = 0
   end type glob_type

   !> The beginning of Linux' struct statx, the same on all processors, and room for the rest
   type, bind(c) :: status_type
      integer(c_int32_t) :: mask = 0, block_size = 0
      integer(c_int64_t) :: attributes = 0
      integer(c_int32_t) :: links = 0, user = 0, group = 0
      !> The kind of the file in its high bits
      integer(c_int16_t) :: mode = 0, spare = 0
      integer(c_int64_t) :: number = 0, length = 0
      integer(c_int64_t) :: until_device(11) = 0
      integer(c_int32_t) :: device(2) = 0
      integer(c_int64_t) :: rest(16) = 0
   end type status_type

   interface
      integer(c_int) function c_statx(folder, path, flags, mask, status) bind(c, name='statx')
         import :: c_char, c_int, status_type
         integer(c_int), value :: folder
         character(kind=c_char), intent(in) :: path(*)
         integer(c_int), value :: flags, mask
         type(status_type), intent(inout) :: status
      end function c_statx
      integer(c_int) function c_rename(old, new) bind(c, name='rename')
         import :: c_char, c_int
         character(kind=c_char), intent(in) :: old(*), new(*)
      end function c_rename
      integer(c_int) function c_unlink(path) bind(c, name='unlink')
         import :: c_char, c_int
         character(kind=c_char), intent(in) :: path(*)
      end function c_unlink
      type(c_ptr) function c_fopen(path, mode) bind(c, name='fopen')
         import :: c_char, c_ptr
         character(kind=c_char), intent(in) :: path(*), mode(*)
      end function c_fopen
      integer(c_int) function c_fclose(stream) bind(c, name='fclose')
         import :: c_int, c_ptr
         type(c_ptr), value :: stream
      end function c_fclose
      integer(c_size_t) function c_fread(buffer, size, count, stream) bind(c, name='fread')
         import :: c_ptr, c_size_t
         type(c_ptr), value :: buffer, stream
         integer(c_size_t), value :: size, count
      end function c_fread
      integer(c_size_t) function c_fwrite(buffer, size, count, stream) bind(c, name='fwrite')
         import :: c_ptr, c_size_t
         type(c_ptr), value :: buffer, stream
         integer(c_size_t), value :: size, count
      end function c_fwrite
      integer(c_int) function c_ferror(stream) bind(c, name='ferror')
         import :: c_int, c_ptr
         type(c_ptr), value :: stream
      end function c_ferror
      type(c_ptr) function c_errno_location() bind(c, name='__errno_location')
         import :: c_ptr
      end function c_errno_location
      type(c_ptr) function c_strerror(number) bind(c, name='strerror')
         import :: c_int, c_ptr
         integer(c_int), value :: number
      end function c_strerror
      integer(c_int) function c_fileno(stream) bind(c, name='fileno')
         import :: c_int, c_ptr
         type(c_ptr), value :: stream
      end function c_fileno
      integer(c_int) function c_flock(descriptor, operation) bind(c, name='flock')
         import :: c_int
         integer(c_int), value :: descriptor, operation
      end function c_flock
      integer(c_int) function c_access(path, mode) bind(c, name='access')
         import :: c_char, c_int
         character(kind=c_char), intent(in) :: path(*)
         integer(c_int), value :: mode
      end function c_access
      integer(c_int) function c_mkdir(path, mode) bind(c, name='mkdir')
         import :: c_char, c_int
         character(kind=c_char), intent(in) :: path(*)
         integer(c_int), value :: mode
      end function c_mkdir
      integer(c_int) function c_glob(pattern, flags, complain, found) bind(c, name='glob')
         import :: c_char, c_int, c_funptr, glob_type
         character(kind=c_char), intent(in) :: pattern(*)
         integer(c_int), value :: flags
         type(c_funptr), value :: complain
         type(glob_type), intent(inout) :: found
      end function c_glob
      subroutine c_globfree(found) bind(c, name='globfree')
         import :: glob_type
         type(glob_type), intent(inout) :: found
      end subroutine c_globfree
      integer(c_size_t) function c_strlen(text) bind(c, name='strlen')
         import :: c_ptr, c_size_t
         type(c_ptr), value :: text
      end function c_strlen
   end interface

contains

   !> Gives a file another name, in place of the file that has it.
   subroutine rename_file(old, new, ok)
      character(*), intent(in) :: old, new
      logical, intent(out) :: ok
      ok = c_rename(old//c_null_char, new//c_null_char) == 0
   end subroutine rename_file

   !> Copies a file, in place of one that has the other name. Not by Fortran's own streams: those of gfortran 12 keep silent about a
   !> full disk.
   subroutine copy_file(from, to, trouble)
      character(*), intent(in) :: from, to
      !> Why it could not be copied, in the words of the system; empty if it was. What there is of the copy is then removed
      character(:), allocatable, intent(out) :: trouble
      character(kind=c_char), allocatable, target :: block(:)
      type(c_ptr) :: source, copy
      integer(c_size_t) :: length
      integer(c_int) :: failed, ignored
      trouble = ''
      source = c_fopen(from//c_null_char, 'r'//c_null_char)
      if (.not. c_associated(source)) then
         trouble = last_reason()
         return
      end if
      copy = c_fopen(to//c_null_char, 'w'//c_null_char)
      if (.not. c_associated(copy)) then
         trouble = last_reason()
         ignored = c_fclose(source)
         return
      end if
      allocate (block(block_size))
      do
         length = c_fread(c_loc(block), 1_c_size_t, block_size, source)
         if (length == 0) exit
         if (c_fwrite(c_loc(block), 1_c_size_t, length, copy) < length) trouble = last_reason()
         if (trouble /= '') exit
      end do
      failed = c_ferror(source)
      if (failed /= 0) trouble = 'it cannot be read'
      failed = c_fclose(copy)
      if (failed /= 0 .and. trouble == '') trouble = last_reason()
      ignored = c_fclose(source)
      if (trouble /= '') call remove_file(to)
   end subroutine copy_file

   !> Why the last call of the system failed.
   function last_reason() result(reason)
      character(:), allocatable :: reason
      character(256) :: text
      integer(c_int), pointer :: number
      call c_f_pointer(c_errno_location(), number)
      call copy_text(c_strerror(number), text)
      reason = trim(text)
   end function last_reason

   !> What the system says of a path; nothing is opened, for that would wait at a pipe.
   subroutine ask_status(path, status, ok)
      character(*), intent(in) :: path
      type(status_type), intent(out) :: status
      !> False if there is nothing
      logical, intent(out) :: ok
      integer(c_int), parameter :: working_folder = -100, basic = 2047
      ok = c_statx(working_folder, path//c_null_char, 0_c_int, basic, status) == 0
   end subroutine ask_status

   !> What stands under a path, links followed: one of path_free, path_file, path_folder, path_other.
   integer function kind_of_path(path) result(kind)
      character(*), intent(in) :: path
      type(status_type) :: status
      logical :: ok
      kind = path_free
      call ask_status(path, status, ok)
      if (.not. ok) return
      select case (iand(ishft(iand(int(status%mode), 65535), -12), 15))
      case (8); kind = path_file
      case (4); kind = path_folder
      case default; kind = path_other
      end select
   end function kind_of_path

   !> Whether two paths lead to the same file.
   logical function same_file(a, b)
      character(*), intent(in) :: a, b
      type(status_type) :: of_a, of_b
      logical :: ok(2)
      call ask_status(a, of_a, ok(1))
      call ask_status(b, of_b, ok(2))
      same_file = .false.
      if (all(ok)) same_file = of_a%number == of_b%number .and. all(of_a%device == of_b%device)
   end function same_file

   !> A name beside a path that nothing has: with the ending, or with a number behind that.
   function unused_name(path, ending) result(name)
      character(*), intent(in) :: path, ending
      character(:), allocatable :: name
      character(12) :: number
      integer :: i
      name = path//ending
      do i = 2, 1000000
         if (kind_of_path(name) == path_free) return
         write (number, '(i0)') i
         name = path//ending//trim(number)
      end do
   end function unused_name

   !> The first bytes of a file; fewer if it is shorter, none if it cannot be read.
   function first_bytes(path, count) result(bytes)
      character(*), intent(in) :: path
      integer, intent(in) :: count
      character(:), allocatable :: bytes
      character(kind=c_char), target :: buffer(count)
      type(c_ptr) :: stream
      integer(c_size_t) :: length
      integer(c_int) :: ignored
      integer :: i
      bytes = ''
      if (kind_of_path(path) /= path_file) return
      stream = c_fopen(path//c_null_char, 'r'//c_null_char)
      if (.not. c_associated(stream)) return
      length = c_fread(c_loc(buffer), 1_c_size_t, int(count, c_size_t), stream)
      ignored = c_fclose(stream)
      do i = 1, int(length)
         bytes = bytes//buffer(i)
      end do
   end function first_bytes

   !> Whether a path is that of a folder.
   logical function is_folder(path)
      character(*), intent(in) :: path
      is_folder = kind_of_path(path) == path_folder
   end function is_folder

   !> Whether this user may write a file that is there.
   logical function may_write(path)
      character(*), intent(in) :: path
      integer(c_int), parameter :: write_permission = 2
      may_write = c_access(path//c_null_char, write_permission) == 0
   end function may_write

   !> Whether another program writes a file and has locked it, as HDF5 does.
   logical function is_locked(path)
      character(*), intent(in) :: path
      integer(c_int), parameter :: shared_without_waiting = 1 + 4
      type(c_ptr) :: stream
      integer(c_int) :: ignored
      is_locked = .false.
      if (kind_of_path(path) /= path_file) return
      stream = c_fopen(path//c_null_char, 'r'//c_null_char)
      if (.not. c_associated(stream)) return
      is_locked = c_flock(c_fileno(stream), shared_without_waiting) /= 0
      ignored = c_fclose(stream)
   end function is_locked

   !> Adds a text to the end of a file, which is made if it is not there; the text is in the file, not in a buffer, when it returns.
   subroutine append_text(path, text, ok)
      character(*), intent(in) :: path, text
      !> False if not all of it could be written
      logical, intent(out) :: ok
      character(kind=c_char), allocatable, target :: buffer(:)
      type(c_ptr) :: file
      integer(c_size_t) :: length, written
      integer :: i
      file = c_fopen(path//c_null_char, 'a'//c_null_char)
      ok = c_associated(file)
      if (.not. ok) return
      length = len(text, c_size_t)
      allocate (buffer(max(1, len(text))))
      do i = 1, len(text)
         buffer(i) = text(i:i)
      end do
      written = c_fwrite(c_loc(buffer), 1_c_size_t, length, file)
      ok = written == length
      ! What a full disk does not take shows here
      ok = c_fclose(file) == 0 .and. ok
   end subroutine append_text

   !> Removes a file, if it is there.
   subroutine remove_file(path)
      character(*), intent(in) :: path
      integer(c_int) :: ignored
      ignored = c_unlink(path//c_null_char)
   end subroutine remove_file

   !> Makes a folder, unless it is there.
   subroutine make_folder(path)
      character(*), intent(in) :: path
      integer(c_int) :: ignored
      ignored = c_mkdir(path//c_null_char, int(o'777', c_int))
   end subroutine make_folder

   !> The files in a folder whose names end in a certain way, sorted.
   subroutine files_like(folder, ending, paths)
      character(*), intent(in) :: folder, ending
      character(longest_path), allocatable, intent(out) :: paths(:)
      type(glob_type) :: found
      type(c_ptr), pointer :: list(:)
      integer :: i
      if (c_glob(escaped(folder)//'/*'//ending//c_null_char, 0_c_int, c_null_funptr, found) /= 0) then
         allocate (paths(0))
         return
      end if
      allocate (paths(int(found%count)))
      call c_f_pointer(found%paths, list, [found%count])
      do i = 1, size(paths)
         call copy_text(list(i), paths(i))
      end do
      call c_globfree(found)
   end subroutine files_like

   !> A path in which no character stands for others.
   pure function escaped(path) result(pattern)
      character(*), intent(in) :: path
      character(:), allocatable :: pattern
      integer :: i
      pattern = ''
      do i = 1, len(path)
         if (scan(path(i:i), '*?[\') > 0) pattern = pattern//'\'
         pattern = pattern//path(i:i)
      end do
   end function escaped

   subroutine copy_text(pointer_to_text, text)
      type(c_ptr), intent(in) :: pointer_to_text
      character(*), intent(out) :: text
      character(kind=c_char), pointer :: letters(:)
      integer :: i
      call c_f_pointer(pointer_to_text, letters, [c_strlen(pointer_to_text)])
      text = ''
      do i = 1, min(size(letters), len(text))
         text(i:i) = letters(i)
      end do
   end subroutine copy_text

end module limber_base_files
