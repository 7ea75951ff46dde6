!> The index of names: every name is found, the latest of equal ones, and forgetting goes backwards.
program test_names
   use limber_base_names, only: name_index_type
   use limber_base_text, only: as_text
   use limber_deck_quantity_names, only: quantity_names
   use limber_model_quantities, only: quantities
   use testing, only: check, check_text, finish
   implicit none
   integer, parameter :: many = 20000

   call check(all(quantities%name == quantity_names), 'names that tables cannot have are those of quantities')
   call test_many()
   call test_shorten()
   call finish()

contains

   subroutine test_many()
      type(name_index_type) :: names
      integer :: i
      logical :: right
      call check(names%find('a') == 0, 'an empty index has no name')
      do i = 1, many
         call names%add('bar'//as_text(i), 2*i)
      end do
      right = names%count == many
      do i = 1, many
         right = right .and. names%find('bar'//as_text(i)) == 2*i
      end do
      call check(right, 'every name is found')
      call check_text(names%name(17), 'bar17', 'a name by its number')
      call check(names%find('bar0') == 0 .and. names%find('bar1 ') == 0 .and. names%find('Bar1') == 0 .and. names%find('') == 0, &
         & 'names that are not there, blanks and case counting')
   end subroutine test_many

   subroutine test_shorten()
      type(name_index_type) :: names
      integer :: i
      do i = 1, 50
         call names%add('i', i)
         call names%add('j'//as_text(i), i)
      end do
      call check(names%find('i') == 50, 'the latest of equal names')
      call names%shorten(3)
      call check(names%find('i') == 2 .and. names%find('j1') == 1 .and. names%find('j2') == 0 .and. names%count == 3, &
         & 'what is left when the latest are forgotten')
      call names%add('j2', 7)
      call check(names%find('j2') == 7, 'a name anew')
      call names%shorten(0)
      call check(names%find('i') == 0 .and. names%count == 0, 'all forgotten')
   end subroutine test_shorten

end program test_names
