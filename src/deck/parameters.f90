!> Named numbers of *PARAMETER and named expressions of *EXPRESSION. Floor: deck.
module limber_deck_parameters
   use limber_base_kinds, only: wp
   use limber_base_names, only: name_index_type
   use limber_base_text, only: lowercase
   use limber_deck_expression, only: expression_type
   use limber_deck_origin, only: origin_type
   implicit none
   private
   public :: parameter_type, parameter_list_type, override_type, name_length, max_parameters

   !> Longest name of anything in a deck
   integer, parameter :: name_length = 64
   !> Most parameters of a deck
   integer, parameter :: max_parameters = 10000

   !> One parameter, or a named expression
   type :: parameter_type
      !> Name in lower case
      character(name_length) :: name = ''
      !> Its value
      real(wp) :: value = 0.0_wp
      !> Of a named expression, which may depend on time and motion; else not allocated
      type(expression_type), allocatable :: law
      !> False if its expression was in error: uses of it are then not reported again
      logical :: valid = .true.
      !> Origin of the name where it is defined
      type(origin_type) :: origin
   end type parameter_type

   !> A value that takes the place of the one that a deck gives a parameter
   type :: override_type
      !> Name in lower case
      character(name_length) :: name = ''
      real(wp) :: value = 0.0_wp
      !> True once the deck has defined the parameter
      logical :: used = .false.
   end type override_type

   !> A table that a deck defines with *TABLE
   type :: named_table_type
      !> Name in lower case
      character(name_length) :: name = ''
      !> As limber_deck_tables packs it
      real(wp), allocatable :: data(:)
   end type named_table_type

   !> All parameters that are defined so far, and all tables
   type :: parameter_list_type
      !> Only the first `count` are in use
      type(parameter_type), allocatable :: items(:)
      integer :: count = 0
      type(name_index_type), private :: names
      type(named_table_type), allocatable :: tables(:)
      !> Values from outside the deck; set before it is read
      type(override_type), allocatable :: overrides(:)
   contains
      procedure :: override
      procedure :: find_table
      procedure :: define_table
      procedure :: find
      procedure :: define
      procedure :: shorten
   end type parameter_list_type

contains

   !> Index of a parameter; 0 if there is none of this name.
   pure integer function find(self, name) result(found)
      class(parameter_list_type), intent(in) :: self
      !> In any case
      character(*), intent(in) :: name
      found = self%names%find(lowercase(name))
   end function find

   !> Index of a table; 0 if there is none of this name.
   pure integer function find_table(self, name) result(found)
      class(parameter_list_type), intent(in) :: self
      !> In lower case
      character(*), intent(in) :: name
      found = 0
      if (.not. allocated(self%tables)) return
      do found = size(self%tables), 1, -1
         if (self%tables(found)%name == name) return
      end do
   end function find_table

   !> Adds a table behind the others.
   pure subroutine define_table(self, name, data)
      class(parameter_list_type), intent(inout) :: self
      character(*), intent(in) :: name
      real(wp), intent(in) :: data(:)
      type(named_table_type), allocatable :: longer(:)
      integer :: count
      if (.not. allocated(self%tables)) allocate (self%tables(0))
      count = size(self%tables)
      allocate (longer(count + 1))
      longer(:count) = self%tables
      longer(count + 1)%name = name
      allocate (longer(count + 1)%data(size(data)), source=data)
      call move_alloc(longer, self%tables)
   end subroutine define_table

   !> Adds a parameter behind the others; its name must be new.
   pure subroutine define(self, item)
      class(parameter_list_type), intent(inout) :: self
      type(parameter_type), intent(in) :: item
      type(parameter_type), allocatable :: longer(:)
      if (.not. allocated(self%items)) allocate (self%items(8))
      if (self%count == size(self%items)) then
         allocate (longer(2*self%count))
         longer(:self%count) = self%items
         call move_alloc(longer, self%items)
      end if
      self%count = self%count + 1
      self%items(self%count) = item
      call self%names%add(trim(item%name), self%count)
   end subroutine define

   !> Gives a parameter that the deck defines its value from outside, if there is one.
   pure subroutine override(self, name, value)
      class(parameter_list_type), intent(inout) :: self
      !> In lower case
      character(*), intent(in) :: name
      real(wp), intent(inout) :: value
      integer :: i
      if (.not. allocated(self%overrides)) return
      do i = 1, size(self%overrides)
         if (self%overrides(i)%name /= name) cycle
         value = self%overrides(i)%value
         self%overrides(i)%used = .true.
      end do
   end subroutine override

   !> Forgets all parameters but the first ones.
   pure subroutine shorten(self, count)
      class(parameter_list_type), intent(inout) :: self
      !> How many are left
      integer, intent(in) :: count
      self%count = min(self%count, count)
      call self%names%shorten(self%count)
   end subroutine shorten

end module limber_deck_parameters
