!> Base type of elements: joints, couplers, drivers, motions and loads of the deck. Each keyword is one file of `src/elements`,
!> which extends this type: its rows of the keyword table, how its block becomes part of the model, and what it does to a beam
!> that is built before. Floor: model.
module limber_model_element
   use limber_deck_content, only: deck_type, block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_schema, only: keyword_rows_type
   use limber_model_held_ends, only: hold_type
   use limber_model_model, only: model_type
   use limber_model_points_of_action, only: acting_type
   implicit none
   private
   public :: element_type, element_item_type, add_element, find_element

   !> A keyword whose blocks act between bodies, or on one
   type, abstract :: element_type
      !> Its rows of the keyword table: keyword, options, fields, words and example
      type(keyword_rows_type) :: rows
      !> Round of the builder in which its blocks are read: 0 first; 1 behind all bodies; 2 behind joints and springs too
      integer :: round = 1
      !> Whether its blocks act, so that they may ask for a switch
      logical :: switchable = .true.
      !> Whether its blocks join the two points of their data line
      logical :: joins = .false.
   contains
      !> Reads a block into the model
      procedure(read_interface), deferred :: read
      !> What a block does to a beam, which is built before: points on which it acts, supports, points that it ties to each other
      procedure :: act => act_nowhere
      procedure :: hold => hold_nothing
      procedure :: tie => tie_nothing
      !> Whether a block drives, loads or couples the frame of a body
      procedure :: turns => turns_nothing
      !> Whether a block prescribes a motion of a body
      procedure :: drives => turns_nothing
   end type element_type

   !> One place of the list of elements
   type :: element_item_type
      class(element_type), allocatable :: item
   end type element_item_type

   abstract interface
      !> Reads a block. All bodies and points are in the model; in round 2 all joints and springs too.
      subroutine read_interface(self, deck, index, model, diagnostics)
         import :: element_type, deck_type, model_type, diagnostics_type
         class(element_type), intent(in) :: self
         type(deck_type), intent(in) :: deck
         !> Index of the block
         integer, intent(in) :: index
         type(model_type), intent(inout) :: model
         type(diagnostics_type), intent(inout) :: diagnostics
      end subroutine read_interface
   end interface

   !> All elements in the order of their registration
   type(element_item_type), allocatable, protected, public :: elements(:)

contains

   !> Adds an element to the list.
   subroutine add_element(element)
      class(element_type), intent(in) :: element
      if (.not. allocated(elements)) allocate (elements(0))
      elements = [elements, element_item_type(element)]
   end subroutine add_element

   !> Index of the element of a keyword; 0 if the keyword is none.
   pure integer function find_element(keyword) result(found)
      !> In upper case
      character(*), intent(in) :: keyword
      do found = size(elements), 1, -1
         if (elements(found)%item%rows%keyword%name == keyword) return
      end do
   end function find_element

   !> Adds the points of a body on which a block acts, for the functions of an exact beam: none.
   subroutine act_nowhere(self, deck, block, body, points)
      class(element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      !> Name of the body
      character(*), intent(in) :: body
      type(acting_type), allocatable, intent(inout) :: points(:)
   end subroutine act_nowhere

   !> Adds what supports a body: nothing.
   subroutine hold_nothing(self, deck, block, body, holds)
      class(element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      !> Name of the body
      character(*), intent(in) :: body
      type(hold_type), allocatable, intent(inout) :: holds(:)
   end subroutine hold_nothing

   !> Names of two points, `body.point`, whose distance along the x axis of a body in its first position a block may fix: none.
   subroutine tie_nothing(self, deck, block, body, names, tied)
      class(element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      !> Name of the body
      character(*), intent(in) :: body
      !> Set if it does
      character(64), intent(inout) :: names(2)
      logical, intent(out) :: tied
      tied = .false.
   end subroutine tie_nothing

   !> Whether a block acts on the frame of a body: no.
   pure logical function turns_nothing(self, block, body) result(turns)
      class(element_type), intent(in) :: self
      type(block_type), intent(in) :: block
      !> Name of the body
      character(*), intent(in) :: body
      turns = .false.
   end function turns_nothing

end module limber_model_element
