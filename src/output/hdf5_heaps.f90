!> Whether the heaps of an HDF5 file, where texts of variable length stand, are whole. HDF5 1.10 believes the lengths in them: of a
!> damaged one it looks for the next text without end, or outside of its memory. Floor: output.
!> Source: HDF5 File Format Specification 2.0, III.E "Global heap".
module limber_output_hdf5_heaps
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_int, c_intptr_t, c_loc, c_ptr, c_size_t
   use limber_base_error, only: error_type, raise, status_deck
   use limber_base_kinds, only: long
   implicit none
   private
   public :: check_heaps

   !> How a heap begins: a mark, a version, three bytes without use; and bytes of that and of its length, of the head of a text,
   !> and of a length
   character(*), parameter :: mark = 'GCOL'//achar(1)//repeat(achar(0), 3)
   integer, parameter :: head_length = 16, length_length = 8
   !> Bytes that are looked through at a time
   integer, parameter :: block_length = 1048576

   interface
      type(c_ptr) function c_memchr(bytes, byte, count) bind(c, name='memchr')
         import :: c_int, c_ptr, c_size_t
         type(c_ptr), value :: bytes
         integer(c_int), value :: byte
         integer(c_size_t), value :: count
      end function c_memchr
   end interface

contains

   !> Refuses a file with a heap whose lengths do not fit. HDF5 is not asked where heaps are: it would have to read them.
   subroutine check_heaps(path, error)
      !> An HDF5 file
      character(*), intent(in) :: path
      type(error_type), allocatable, intent(out) :: error
      character(kind=c_char, len=:), allocatable, target :: block
      integer(long) :: bytes, before
      integer :: unit, status, found, last
      logical :: sound
      open (newunit=unit, file=path, access='stream', form='unformatted', action='read', status='old', iostat=status)
      if (status /= 0) then
         call raise(error, path//' cannot be read', status_deck)
         return
      end if
      inquire (unit=unit, size=bytes)
      allocate (character(block_length) :: block)
      before = 0
      sound = .true.
      do while (before + head_length <= bytes .and. sound .and. status == 0)
         last = int(min(int(block_length, long), bytes - before))
         read (unit, pos=before + 1, iostat=status) block(:last)
         found = 0
         do while (sound .and. status == 0)
            found = next_mark(block, found, last)
            if (found == 0) exit
            sound = is_sound(unit, before + found, bytes)
         end do
         ! A mark may begin in one block and end in the next
         before = before + max(1, last - len(mark) + 1)
      end do
      close (unit, iostat=last)
      if (status /= 0) call raise(error, path//' cannot be read', status_deck)
      if (.not. sound) call raise(error, path//' is damaged: lengths of the texts in it do not fit', status_deck)
   end subroutine check_heaps

   !> Where the next mark stands, behind a place; zero: there is none.
   integer function next_mark(block, behind, last) result(found)
      character(kind=c_char, len=*), intent(in), target :: block
      integer, intent(in) :: behind, last
      type(c_ptr) :: place
      integer(c_intptr_t) :: start
      start = transfer(c_loc(block(1:1)), start)
      found = behind
      do while (found + len(mark) <= last)
         place = c_memchr(c_loc(block(found + 1:found + 1)), ichar(mark(1:1), c_int), int(last - found, c_size_t))
         if (.not. c_associated(place)) exit
         found = int(transfer(place, start) - start) + 1
         if (found + len(mark) - 1 > last) exit
         if (block(found:found + len(mark) - 1) == mark) return
      end do
      found = 0
   end function next_mark

   !> Whether the texts of a heap follow one another up to its end.
   logical function is_sound(unit, at, bytes) result(sound)
      integer, intent(in) :: unit
      !> First byte of the heap, and bytes of the file
      integer(long), intent(in) :: at, bytes
      character(head_length) :: head
      integer(long) :: length, place, step
      integer :: status
      sound = .false.
      read (unit, pos=at, iostat=status) head
      if (status /= 0) return
      length = length_in(head)
      if (length < head_length .or. length > bytes - at + 1) return
      place = head_length
      ! Less than the head of a text is left over
      do while (place + head_length <= length)
         read (unit, pos=at + place, iostat=status) head
         if (status /= 0) return
         step = length_in(head)
         if (step < 0 .or. step > length) return
         ! A text has a number above zero, and fills eights of bytes behind its head; what has the number zero is free
         if (head(1:2) /= repeat(achar(0), 2)) step = head_length + 8*((step + 7)/8)
         if (step < head_length .or. place + step > length) return
         place = place + step
      end do
      sound = .true.
   end function is_sound

   !> The length in the last bytes of a head.
   pure integer(long) function length_in(head) result(length)
      character(*), intent(in) :: head
      integer :: i
      length = 0
      do i = len(head), len(head) - length_length + 1, -1
         length = ior(ishft(length, 8), int(ichar(head(i:i)), long))
      end do
   end function length_in

end module limber_output_hdf5_heaps
