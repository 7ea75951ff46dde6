!> State of a run as two lists of numbers, for restarts. Every type with a memory has one procedure `exchange(self, snapshot)` that
!> names its components once, for both directions: a snapshot that is being saved takes their values, one that is being restored
!> gives them back, bit for bit. Each item carries a digest of its name and its size, so that a snapshot that belongs to something
!> else is found out. Floor: base.
!>
!>     call snapshot%begin(.false.)              ! or .true. to restore what `reals` and `integers` hold
!>     call snapshot%exchange('step', self%h)    ! numbers and arrays of fixed size
!>     call snapshot%keep('rates', self%v)       ! allocatable arrays and texts, whether they are allocated or not
!>     call snapshot%mark()                      ! what went through so far stays: `begin` now goes to here
module limber_base_snapshot
   use limber_base_kinds, only: wp, long
   implicit none
   private
   public :: snapshot_type

   !> A snapshot and how far it has been gone through
   type :: snapshot_type
      !> True while it gives values back
      logical :: restoring = .false.
      !> What it holds; of that the first `real_count` and `integer_count` numbers once it was saved
      real(wp), allocatable :: reals(:)
      integer, allocatable :: integers(:)
      integer :: real_count = 0, integer_count = 0
      !> Numbers before the mark
      integer, private :: marked_reals = 0, marked_integers = 0
      !> Name of the first item that was not found where it was looked for; not allocated while all is well
      character(:), allocatable :: missing
   contains
      procedure :: begin, mark
      generic :: exchange => exchange_real, exchange_reals, exchange_table, exchange_integer, exchange_integers, exchange_long, &
         & exchange_logical, exchange_complex
      generic :: keep => keep_reals, keep_table, keep_block, keep_logicals, keep_text
      procedure, private :: exchange_real, exchange_reals, exchange_table, exchange_integer, exchange_integers, exchange_long, &
         & exchange_logical, exchange_complex
      procedure, private :: keep_reals, keep_table, keep_block, keep_logicals, keep_text
      procedure, private :: announce, pass_reals, pass_integers
   end type snapshot_type

contains

   !> Goes to the start of a snapshot, or to its mark, to save into it or to restore from it.
   subroutine begin(self, restoring)
      class(snapshot_type), intent(inout) :: self
      logical, intent(in) :: restoring
      self%restoring = restoring
      self%real_count = self%marked_reals
      self%integer_count = self%marked_integers
      if (allocated(self%missing)) deallocate (self%missing)
      if (.not. allocated(self%reals)) allocate (self%reals(0))
      if (.not. allocated(self%integers)) allocate (self%integers(0))
   end subroutine begin

   !> Lets what has gone through stand before all that is saved or restored from now on; or forgets an earlier mark.
   subroutine mark(self, forget)
      class(snapshot_type), intent(inout) :: self
      !> False if absent
      logical, intent(in), optional :: forget
      self%marked_reals = self%real_count
      self%marked_integers = self%integer_count
      if (.not. present(forget)) return
      if (.not. forget) return
      self%marked_reals = 0
      self%marked_integers = 0
   end subroutine mark

   !> Takes note of an item, or looks whether it is the next one.
   subroutine announce(self, name, count)
      class(snapshot_type), intent(inout) :: self
      character(*), intent(in) :: name
      !> Numbers that it consists of
      integer, intent(in) :: count
      integer :: head(2)
      if (allocated(self%missing)) return
      head = [digest(name), count]
      call self%pass_integers(head)
      if (allocated(self%missing)) self%missing = name
      if (head(1) /= digest(name) .or. head(2) /= count) self%missing = name
   end subroutine announce

   !> A number that stands for a name.
   pure integer function digest(name)
      character(*), intent(in) :: name
      integer :: i
      integer(long) :: sum
      sum = 0
      do i = 1, len(name)
         sum = modulo(31*sum + ichar(name(i:i)), 2147483647_long)
      end do
      digest = int(sum)
   end function digest

   !> Saves or restores reals without a head.
   subroutine pass_reals(self, values)
      class(snapshot_type), intent(inout) :: self
      real(wp), intent(inout) :: values(:)
      real(wp), allocatable :: longer(:)
      integer :: first, last
      if (allocated(self%missing)) return
      first = self%real_count + 1
      last = self%real_count + size(values)
      if (last > size(self%reals)) then
         if (self%restoring) then
            self%missing = ''
            return
         end if
         allocate (longer(max(last, 2*size(self%reals), 1024)))
         longer(:self%real_count) = self%reals(:self%real_count)
         longer(last + 1:) = 0.0_wp
         call move_alloc(longer, self%reals)
      end if
      if (self%restoring) then
         values = self%reals(first:last)
      else
         self%reals(first:last) = values
      end if
      self%real_count = last
   end subroutine pass_reals

   !> Saves or restores integers without a head.
   subroutine pass_integers(self, values)
      class(snapshot_type), intent(inout) :: self
      integer, intent(inout) :: values(:)
      integer, allocatable :: longer(:)
      integer :: first, last
      if (allocated(self%missing)) return
      first = self%integer_count + 1
      last = self%integer_count + size(values)
      if (last > size(self%integers)) then
         if (self%restoring) then
            self%missing = ''
            return
         end if
         allocate (longer(max(last, 2*size(self%integers), 1024)))
         longer(:self%integer_count) = self%integers(:self%integer_count)
         longer(last + 1:) = 0
         call move_alloc(longer, self%integers)
      end if
      if (self%restoring) then
         values = self%integers(first:last)
      else
         self%integers(first:last) = values
      end if
      self%integer_count = last
   end subroutine pass_integers

   subroutine exchange_real(self, name, value)
      class(snapshot_type), intent(inout) :: self
      character(*), intent(in) :: name
      real(wp), intent(inout) :: value
      real(wp) :: list(1)
      list = value
      call self%exchange(name, list)
      value = list(1)
   end subroutine exchange_real

   subroutine exchange_reals(self, name, value)
      class(snapshot_type), intent(inout) :: self
      character(*), intent(in) :: name
      real(wp), intent(inout) :: value(:)
      call self%announce(name, size(value))
      call self%pass_reals(value)
   end subroutine exchange_reals

   subroutine exchange_table(self, name, value)
      class(snapshot_type), intent(inout) :: self
      character(*), intent(in) :: name
      real(wp), intent(inout) :: value(:, :)
      integer :: j
      call self%announce(name, size(value))
      do j = 1, size(value, 2)
         call self%pass_reals(value(:, j))
      end do
   end subroutine exchange_table

   subroutine exchange_complex(self, name, value)
      class(snapshot_type), intent(inout) :: self
      character(*), intent(in) :: name
      complex(wp), intent(inout) :: value(:)
      real(wp), allocatable :: parts(:)
      integer :: i
      allocate (parts(2*size(value)))
      do i = 1, size(value)
         parts(2*i - 1) = real(value(i), wp)
         parts(2*i) = aimag(value(i))
      end do
      call self%exchange(name, parts)
      do i = 1, size(value)
         value(i) = cmplx(parts(2*i - 1), parts(2*i), wp)
      end do
   end subroutine exchange_complex

   subroutine exchange_integer(self, name, value)
      class(snapshot_type), intent(inout) :: self
      character(*), intent(in) :: name
      integer, intent(inout) :: value
      integer :: list(1)
      list = value
      call self%exchange(name, list)
      value = list(1)
   end subroutine exchange_integer

   subroutine exchange_integers(self, name, value)
      class(snapshot_type), intent(inout) :: self
      character(*), intent(in) :: name
      integer, intent(inout) :: value(:)
      call self%announce(name, size(value))
      call self%pass_integers(value)
   end subroutine exchange_integers

   subroutine exchange_long(self, name, value)
      class(snapshot_type), intent(inout) :: self
      character(*), intent(in) :: name
      integer(long), intent(inout) :: value
      integer :: halves(2)
      halves = transfer(value, halves)
      call self%exchange(name, halves)
      value = transfer(halves, value)
   end subroutine exchange_long

   subroutine exchange_logical(self, name, value)
      class(snapshot_type), intent(inout) :: self
      character(*), intent(in) :: name
      logical, intent(inout) :: value
      integer :: number
      number = merge(1, 0, value)
      call self%exchange(name, number)
      value = number == 1
   end subroutine exchange_logical

   subroutine keep_reals(self, name, value)
      class(snapshot_type), intent(inout) :: self
      character(*), intent(in) :: name
      real(wp), allocatable, intent(inout) :: value(:)
      integer :: extent(1)
      extent = -1
      if (allocated(value)) extent = shape(value)
      call self%exchange(name, extent)
      if (allocated(self%missing)) return
      if (self%restoring .and. allocated(value)) then
         if (any(shape(value) /= extent)) deallocate (value)
      end if
      if (extent(1) < 0) return
      if (.not. allocated(value)) allocate (value(extent(1)))
      call self%pass_reals(value)
   end subroutine keep_reals

   subroutine keep_table(self, name, value)
      class(snapshot_type), intent(inout) :: self
      character(*), intent(in) :: name
      real(wp), allocatable, intent(inout) :: value(:, :)
      integer :: extent(2), j
      extent = -1
      if (allocated(value)) extent = shape(value)
      call self%exchange(name, extent)
      if (allocated(self%missing)) return
      if (self%restoring .and. allocated(value)) then
         if (any(shape(value) /= extent)) deallocate (value)
      end if
      if (extent(1) < 0) return
      if (.not. allocated(value)) allocate (value(extent(1), extent(2)))
      do j = 1, extent(2)
         call self%pass_reals(value(:, j))
      end do
   end subroutine keep_table

   subroutine keep_block(self, name, value)
      class(snapshot_type), intent(inout) :: self
      character(*), intent(in) :: name
      real(wp), allocatable, intent(inout) :: value(:, :, :)
      integer :: extent(3), j, k
      extent = -1
      if (allocated(value)) extent = shape(value)
      call self%exchange(name, extent)
      if (allocated(self%missing)) return
      if (self%restoring .and. allocated(value)) then
         if (any(shape(value) /= extent)) deallocate (value)
      end if
      if (extent(1) < 0) return
      if (.not. allocated(value)) allocate (value(extent(1), extent(2), extent(3)))
      do k = 1, extent(3)
         do j = 1, extent(2)
            call self%pass_reals(value(:, j, k))
         end do
      end do
   end subroutine keep_block

   subroutine keep_logicals(self, name, value)
      class(snapshot_type), intent(inout) :: self
      character(*), intent(in) :: name
      logical, allocatable, intent(inout) :: value(:)
      integer :: extent, i
      extent = -1
      if (allocated(value)) extent = size(value)
      call self%exchange(name, extent)
      if (allocated(self%missing)) return
      if (self%restoring .and. allocated(value)) then
         if (size(value) /= extent) deallocate (value)
      end if
      if (extent < 0) return
      if (.not. allocated(value)) then
         allocate (value(extent))
         value = .false.
      end if
      do i = 1, extent
         call self%exchange(name, value(i))
      end do
   end subroutine keep_logicals

   subroutine keep_text(self, name, value)
      class(snapshot_type), intent(inout) :: self
      character(*), intent(in) :: name
      character(:), allocatable, intent(inout) :: value
      integer, allocatable :: letters(:)
      integer :: extent, i
      extent = -1
      if (allocated(value)) extent = len(value)
      call self%exchange(name, extent)
      if (allocated(self%missing)) return
      if (self%restoring .and. allocated(value)) deallocate (value)
      if (extent < 0) return
      allocate (letters(extent))
      if (.not. self%restoring) then
         do i = 1, extent
            letters(i) = ichar(value(i:i))
         end do
      end if
      call self%pass_integers(letters)
      if (.not. self%restoring .or. allocated(self%missing)) return
      allocate (character(extent) :: value)
      do i = 1, extent
         value(i:i) = achar(letters(i))
      end do
   end subroutine keep_text

end module limber_base_snapshot
