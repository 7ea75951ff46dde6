!> Every keyword has an example, which stands line for line in a deck that can be read; decks of input/ and tests/decks are run
!> by other tests. Usage, in tests/: test_examples <deck> ...
program test_examples
   use limber_base_error, only: error_type
   use limber_base_text, only: newline
   use limber_deck_examples, only: example_text
   use limber_deck_keyword_help, only: help_text, manual_text
   use limber_deck_keywords, only: keyword_table, load_language
   use limber_scene_first_scene, only: read_scene
   use limber_scene_scene, only: scene_type
   use testing, only: check, check_no_error, finish
   implicit none
   type :: file_type
      character(:), allocatable :: path
      !> Begins with a line feed, and whether the example of a keyword stands there
      character(:), allocatable :: text
      logical :: wanted = .false.
   end type file_type

   call test_all()
   call finish()

contains

   subroutine test_all()
      type(file_type), allocatable :: decks(:)
      character(512) :: path
      integer :: i
      call load_language()
      allocate (decks(command_argument_count()))
      do i = 1, size(decks)
         call get_command_argument(i, path)
         decks(i)%path = trim(path)
         decks(i)%text = newline//contents(trim(path))
      end do
      do i = 1, size(keyword_table)
         call search(trim(keyword_table(i)%name), decks)
      end do
      do i = 1, size(decks)
         if (decks(i)%wanted) call read_one(decks(i)%path)
      end do
   end subroutine test_all

   subroutine read_one(path)
      character(*), intent(in) :: path
      type(scene_type) :: scene
      type(error_type), allocatable :: error
      call read_scene(path, scene, error)
      call check_no_error(error, path)
   end subroutine read_one

   !> The example of a keyword shows it, is in the help and in the manual, and stands in a deck: the first one is wanted.
   subroutine search(keyword, decks)
      character(*), intent(in) :: keyword
      type(file_type), intent(inout) :: decks(:)
      character(:), allocatable :: example
      integer :: k
      example = newline//example_text(keyword)//newline
      call check(len(example) > 2, '*'//keyword//' has an example in src/deck/examples.f90')
      if (len(example) == 2) return
      call check(index(example, newline//'*'//keyword) > 0, 'the example of *'//keyword//' shows it')
      call check(index(help_text(keyword)//newline, newline//'Example:'//example) > 0, 'help on *'//keyword//' has the example')
      call check(index(manual_text(), '```'//example//'```') > 0, 'the manual has the example of *'//keyword)
      do k = 1, size(decks)
         if (index(decks(k)%text, example) == 0) cycle
         decks(k)%wanted = .true.
         return
      end do
      call check(.false., 'the example of *'//keyword//' stands in a deck')
   end subroutine search

   function contents(path) result(text)
      character(*), intent(in) :: path
      character(:), allocatable :: text
      integer :: unit, status, length
      inquire (file=path, size=length)
      allocate (character(max(0, length)) :: text)
      open (newunit=unit, file=path, access='stream', action='read', iostat=status)
      read (unit, iostat=status) text
      close (unit)
      call check(status == 0, path//' can be read')
   end function contents

end program test_examples
