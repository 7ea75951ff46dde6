!> Index of names: a number by its name. Finds a number by its name at a cost that does not grow with their count. Names are added
!> one after the other and can be taken away again in the opposite order. Floor: base.
module limber_base_names
   implicit none
   private
   public :: name_index_type

   !> Names with their numbers; a name that is added again hides the earlier one, `find` gives the latest
   type :: name_index_type
      !> Number of names
      integer :: count = 0
      !> All names one after the other, and where each ends in there
      character(:), allocatable, private :: text
      integer, allocatable, private :: last(:)
      !> Number that goes with each name, its hash, and the name before it that has the same place in the table
      integer, allocatable, private :: value(:), hash(:), next(:)
      !> Latest name of each place; their number is a power of two
      integer, allocatable, private :: table(:)
   contains
      procedure :: add, find, shorten, name
   end type name_index_type

contains

   !> Adds a name.
   pure subroutine add(self, name, value)
      class(name_index_type), intent(inout) :: self
      !> As it will be looked for, to the letter
      character(*), intent(in) :: name
      !> Number that `find` gives; not 0
      integer, intent(in) :: value
      integer :: n, first
      call reserve(self, len(name))
      n = self%count + 1
      first = 1
      if (n > 1) first = self%last(n - 1) + 1
      self%count = n
      self%last(n) = first + len(name) - 1
      self%text(first:self%last(n)) = name
      self%value(n) = value
      self%hash(n) = hash_of(name)
      call link(self, n)
   end subroutine add

   !> Number of a name; 0 if there is none.
   pure integer function find(self, name)
      class(name_index_type), intent(in) :: self
      character(*), intent(in) :: name
      integer :: hash, i
      find = 0
      if (self%count == 0) return
      hash = hash_of(name)
      i = self%table(place_of(self, hash))
      do while (i > 0)
         if (self%hash(i) == hash) then
            if (same(self%text(start(self, i):self%last(i)), name)) then
               find = self%value(i)
               return
            end if
         end if
         i = self%next(i)
      end do
   end function find

   !> The i-th name.
   pure function name(self, i)
      class(name_index_type), intent(in) :: self
      integer, intent(in) :: i
      character(:), allocatable :: name
      name = self%text(start(self, i):self%last(i))
   end function name

   !> Whether two texts are the same, blanks at their ends included.
   pure logical function same(a, b)
      character(*), intent(in) :: a, b
      same = len(a) == len(b)
      if (same) same = a == b
   end function same

   !> Takes the latest names away until so many are left.
   pure subroutine shorten(self, count)
      class(name_index_type), intent(inout) :: self
      integer, intent(in) :: count
      do while (self%count > count)
         self%table(place_of(self, self%hash(self%count))) = self%next(self%count)
         self%count = self%count - 1
      end do
   end subroutine shorten

   !> Room for one more name of a length.
   pure subroutine reserve(self, length)
      class(name_index_type), intent(inout) :: self
      integer, intent(in) :: length
      character(:), allocatable :: text
      integer :: i, used
      if (.not. allocated(self%table)) then
         allocate (self%last(16), self%value(16), self%hash(16), self%next(16), self%table(32))
         allocate (character(256) :: self%text)
         self%table = 0
      end if
      if (self%count == size(self%last)) then
         call lengthen(self%last)
         call lengthen(self%value)
         call lengthen(self%hash)
         call lengthen(self%next)
         deallocate (self%table)
         allocate (self%table(2*size(self%last)))
         self%table = 0
         do i = 1, self%count
            call link(self, i)
         end do
      end if
      used = 0
      if (self%count > 0) used = self%last(self%count)
      if (used + length <= len(self%text)) return
      allocate (character(2*len(self%text) + length) :: text)
      text(:used) = self%text(:used)
      call move_alloc(text, self%text)
   end subroutine reserve

   pure subroutine lengthen(list)
      integer, allocatable, intent(inout) :: list(:)
      integer, allocatable :: longer(:)
      allocate (longer(2*size(list)))
      longer(:size(list)) = list
      call move_alloc(longer, list)
   end subroutine lengthen

   !> Enters the i-th name into the table.
   pure subroutine link(self, i)
      class(name_index_type), intent(inout) :: self
      integer, intent(in) :: i
      integer :: place
      place = place_of(self, self%hash(i))
      self%next(i) = self%table(place)
      self%table(place) = i
   end subroutine link

   pure integer function start(self, i)
      class(name_index_type), intent(in) :: self
      integer, intent(in) :: i
      start = 1
      if (i > 1) start = self%last(i - 1) + 1
   end function start

   pure integer function place_of(self, hash)
      class(name_index_type), intent(in) :: self
      integer, intent(in) :: hash
      place_of = 1 + iand(ieor(hash, ishft(hash, -13)), size(self%table) - 1)
   end function place_of

   !> A number from 0 to 2^24 - 1 from the letters of a name.
   pure integer function hash_of(name)
      character(*), intent(in) :: name
      integer :: i
      hash_of = 5381
      do i = 1, len(name)
         hash_of = iand(33*hash_of + ichar(name(i:i)), 2**24 - 1)
      end do
   end function hash_of

end module limber_base_names
