!> Runs that are interrupted again and again and go on have the bits of those that are not: all that is in the file of results, with
!> every integrator.
program test_restart
   use pieces, only: compare_pieces
   use testing, only: finish
   implicit none
   character(*), parameter :: integrators(*) = [character(10) :: 'ADAMS', 'RADAU', 'ALPHA', 'CONSERVING']
   character(512) :: argument

   call get_command_argument(1, argument)
   call test_all(trim(argument))
   call finish()

contains

   subroutine test_all(results)
      character(*), intent(in) :: results
      character(80) :: old(2), new(2)
      character(21) :: chosen
      integer :: i
      do i = 1, size(integrators)
         chosen = 'INTEGRATOR='//integrators(i)
         old(1) = 'turns = 2'
         new(1) = 'turns = 0.2'
         old(2) = 'TOLERANCE=1e-8, OUTPUTS=838'
         new(2) = 'TOLERANCE=1e-5, OUTPUTS=83, '//chosen
         call compare_pieces('slider_crank_full', results, old, new, 7)
         old(1) = 'END=0.03, TOLERANCE=1e-8'
         new(1) = 'END=0.03, TOLERANCE=1e-5'
         old(2) = 'OUTPUTS=300, INTEGRATOR=ADAMS'
         new(2) = 'OUTPUTS=60, '//chosen
         call compare_pieces('andrews_squeezer', results, old, new, 7)
         old(1) = 'N = 40'
         new(1) = 'N = 4'
         old(2) = 'END=20, OUTPUTS=1000, TOLERANCE=1e-7'
         new(2) = 'END=2, OUTPUTS=100, TOLERANCE=1e-5, '//chosen
         call compare_pieces('four_bar_chain', results, old, new, 7)
         old(1) = 'N = 100'
         new(1) = 'N = 12'
         old(2) = 'OUTPUTS=100, FIXED STEP=1e-3, INTEGRATOR=ADAMS'
         new(2) = 'OUTPUTS=50, TOLERANCE=1e-4, '//chosen
         call compare_pieces('chain_rigid', results, old, new, 7)
         old(1) = 'N = 100'
         new(1) = 'N = 6'
         old(2) = 'END=1, OUTPUTS=100, FIXED STEP=1e-3, INTEGRATOR=ALPHA'
         new(2) = 'END=0.05, OUTPUTS=50, TOLERANCE=1e-4, '//chosen
         call compare_pieces('chain_flexible', results, old, new, 7)
      end do
   end subroutine test_all

end program test_restart
