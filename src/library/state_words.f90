!> A saved state of a run as a list of words of 64 bits, for programs that keep it. Floor: library.
module limber_library_state_words
   use, intrinsic :: iso_fortran_env, only: int64
   use limber_base_error, only: error_type, raise, status_deck
   use limber_base_kinds, only: wp
   use limber_library_stepped_run, only: saved_type
   implicit none
   private
   public :: pack_state, unpack_state

   !> What the list begins with, and letters in a word
   character(8), parameter :: mark = 'limber 1'
   integer, parameter :: letters = 8

   !> A list that is written or read
   type :: list_type
      integer(int64), allocatable :: words(:)
      !> Words so far
      integer :: at = 0
      !> Whether it is read; whether it has ended too early
      logical :: reading = .false., is_short = .false.
   contains
      generic :: pass => pass_integers, pass_reals, pass_logicals, pass_text
      procedure, private :: pass_integers, pass_reals, pass_logicals, pass_text, pass_words
   end type list_type

contains

   !> Words of a state.
   subroutine pack_state(saved, words)
      !> Left as it is
      type(saved_type), intent(inout) :: saved
      integer(int64), allocatable, intent(out) :: words(:)
      type(list_type) :: list
      allocate (list%words(1024))
      call exchange_state(list, saved)
      words = list%words(:list%at)
   end subroutine pack_state

   !> State of some words.
   subroutine unpack_state(words, saved, error)
      integer(int64), intent(in) :: words(:)
      type(saved_type), intent(out) :: saved
      !> They are not those of a state
      type(error_type), allocatable, intent(out) :: error
      type(list_type) :: list
      list%reading = .true.
      list%words = words
      call exchange_state(list, saved)
      if (list%is_short .or. list%at /= size(words)) call raise(error, 'this is not a state that limber has saved', status_deck)
   end subroutine unpack_state

   !> Writes or reads all of a state.
   subroutine exchange_state(list, saved)
      type(list_type), intent(inout) :: list
      type(saved_type), intent(inout) :: saved
      character(:), allocatable :: head
      integer, allocatable :: numbers(:)
      real(wp), allocatable :: times(:)
      logical, allocatable :: flags(:)
      head = mark
      call list%pass(head)
      if (head /= mark) list%is_short = .true.
      call list%pass(saved%label)
      numbers = [saved%place%samples]
      call list%pass(numbers)
      times = [saved%time, saved%place%from]
      call list%pass(times)
      flags = [saved%place%between, saved%place%follows_motion]
      call list%pass(flags)
      call list%pass(saved%place%reals)
      call list%pass(saved%place%integers)
      call list%pass(saved%place%is_given)
      call list%pass(saved%place%given)
      call list%pass(saved%q)
      call list%pass(saved%v)
      call list%pass(saved%is_given)
      call list%pass(saved%given)
      if (list%is_short) return
      if (size(numbers) /= 1 .or. size(times) /= 2 .or. size(flags) /= 2) then
         list%is_short = .true.
         return
      end if
      saved%place%samples = numbers(1)
      saved%time = times(1)
      saved%place%from = times(2)
      saved%place%between = flags(1)
      saved%place%follows_motion = flags(2)
   end subroutine exchange_state

   !> Passes the number of items, then room for them in the list; they begin behind `at` less that room.
   subroutine pass_words(self, count, room)
      class(list_type), intent(inout) :: self
      !> Items; read, if the list is
      integer, intent(inout) :: count
      !> Words for each, as a part: letters to a word
      integer, intent(in) :: room
      integer(int64), allocatable :: longer(:)
      integer :: need
      if (self%reading) then
         count = 0
         if (self%is_short) return
         self%is_short = self%at >= size(self%words)
         if (self%is_short) return
         self%is_short = self%words(self%at + 1) < 0 .or. self%words(self%at + 1) > room*int(size(self%words) - self%at, int64)
         if (self%is_short) return
         count = int(self%words(self%at + 1))
      end if
      need = 1 + (count + room - 1)/room
      if (self%at + need > size(self%words)) then
         self%is_short = self%reading
         if (self%reading) count = 0
         if (self%reading) return
         allocate (longer(2*size(self%words) + need))
         longer(:self%at) = self%words(:self%at)
         call move_alloc(longer, self%words)
      end if
      self%words(self%at + 1) = count
      self%at = self%at + need
   end subroutine pass_words

   subroutine pass_reals(self, values)
      class(list_type), intent(inout) :: self
      real(wp), allocatable, intent(inout) :: values(:)
      integer :: count
      count = 0
      if (.not. self%reading) count = size(values)
      call self%pass_words(count, 1)
      associate (words => self%words(self%at - count + 1:self%at))
         if (self%reading) values = transfer(words, 0.0_wp, count)
         if (.not. self%reading) words = transfer(values, 0_int64, count)
      end associate
   end subroutine pass_reals

   subroutine pass_integers(self, values)
      class(list_type), intent(inout) :: self
      integer, allocatable, intent(inout) :: values(:)
      integer :: count
      count = 0
      if (.not. self%reading) count = size(values)
      call self%pass_words(count, 1)
      associate (words => self%words(self%at - count + 1:self%at))
         if (self%reading) values = int(words)
         if (.not. self%reading) words = values
      end associate
   end subroutine pass_integers

   subroutine pass_logicals(self, values)
      class(list_type), intent(inout) :: self
      logical, allocatable, intent(inout) :: values(:)
      integer :: count
      count = 0
      if (.not. self%reading) count = size(values)
      call self%pass_words(count, 1)
      associate (words => self%words(self%at - count + 1:self%at))
         if (self%reading) values = words /= 0
         if (.not. self%reading) words = merge(1_int64, 0_int64, values)
      end associate
   end subroutine pass_logicals

   subroutine pass_text(self, text)
      class(list_type), intent(inout) :: self
      character(:), allocatable, intent(inout) :: text
      character(letters) :: part
      integer :: count, words, i
      count = 0
      if (.not. self%reading) count = len(text)
      call self%pass_words(count, letters)
      words = (count + letters - 1)/letters
      if (self%reading) then
         if (allocated(text)) deallocate (text)
         allocate (character(count) :: text)
      end if
      do i = 1, words
         associate (word => self%words(self%at - words + i), first => letters*(i - 1) + 1)
            if (self%reading) then
               part = transfer(word, part)
               text(first:min(count, first + letters - 1)) = part
            else
               part = text(first:min(count, first + letters - 1))
               word = transfer(part, word)
            end if
         end associate
      end do
   end subroutine pass_text

end module limber_library_state_words
