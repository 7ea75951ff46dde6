!> A program with an error in it: it asks a block for an option that no keyword has, which must end it. Usage: wrong_option
program wrong_option
   use limber_deck_content, only: block_type
   implicit none
   type(block_type) :: block
   allocate (block%options(1))
   block%options(1)%name = 'LENGTH'
   print '(l1)', block%knows('LENGTH'), block%knows('LENTGH'), block%given('LENGTH')
   print '(l1)', block%given('LENTGH')
   print '(a)', 'goes on'
end program wrong_option
