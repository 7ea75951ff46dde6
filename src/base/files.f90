!> Files and folders, as POSIX has them: names, lists. Floor: base.
module limber_base_files
   use, intrinsic :: iso_c_binding, only: c_char, c_f_pointer, c_int, c_null_char, c_null_funptr, c_null_ptr, c_funptr, c_ptr, &
      & c_size_t
   implicit none
   private
   public :: rename_file, make_folder, files_like, remove_file

   !> Longest path
   integer, parameter, public :: longest_path = 4096

   !> The beginning of POSIX's glob_t, and room for the rest
   type, bind(c) :: glob_type
      integer(c_size_t) :: count = 0
      type(c_ptr) :: paths = c_null_ptr
      integer(c_size_t) :: rest(32) = 0
   end type glob_type

   interface
      integer(c_int) function c_rename(old, new) bind(c, name='rename')
         import :: c_char, c_int
         character(kind=c_char), intent(in) :: old(*), new(*)
      end function c_rename
      integer(c_int) function c_unlink(path) bind(c, name='unlink')
         import :: c_char, c_int
         character(kind=c_char), intent(in) :: path(*)
      end function c_unlink
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
