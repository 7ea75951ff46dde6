!> Instants at which laws of time change their formula, found to the bit; and what has none.
program test_law_breaks
   use limber_base_kinds, only: wp
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_content, only: deck_type
   use limber_deck_reader, only: read_deck
   use limber_model_breaks, only: law_breaks
   use testing, only: check, check_close, finish
   implicit none
   real(wp), parameter :: pi = acos(-1.0_wp)
   integer :: k

   call expect('sin(3*t) + t**2', [real(wp) ::])
   call expect('7', [real(wp) ::])
   call expect('max(t - 1, 0)', [1.0_wp])
   call expect('step(t - 0.3) - 2*step(t - 0.7)', [0.3_wp, 0.7_wp])
   call expect('min(t, 1.25)**2 + max(t - 1.25, 0)', [1.25_wp])
   call expect('smoothstep((t - 0.5)/0.75)', [0.5_wp, 1.25_wp])
   call expect('abs(sin(10*t))', [(k*pi/10, k=1, 6)])
   ! A pulse a thousandth of the run long is seen if it lasts over one of the looks at it
   call expect('step(t - 0.9999) - step(t - 1.0019)', [0.9999_wp, 1.0019_wp])
   ! At the start and at the end there is nothing to break
   call expect('max(t, 0) + max(t - 2, 0)', [real(wp) ::])
   call finish()

contains

   !> Breaks of a torque between 0 and 2.
   subroutine expect(law, times)
      character(*), intent(in) :: law
      real(wp), intent(in) :: times(:)
      type(deck_type) :: deck
      type(diagnostics_type) :: diagnostics
      real(wp), allocatable :: found(:)
      integer :: i, unit, block
      open (newunit=unit, file='law.inp', action='write', status='replace')
      write (unit, '(a)') '*RIGID BODY, NAME=rotor, MASS=1, INERTIA=1', '*TORQUE, NAME=pull, BODY=rotor', ' '//law
      close (unit)
      call read_deck('law.inp', deck, diagnostics)
      open (newunit=unit, file='law.inp', status='old')
      close (unit, status='delete')
      call check(diagnostics%count == 0, law//' is a law')
      block = deck%find('TORQUE')
      allocate (found(0))
      call law_breaks(deck%blocks(block)%lines(1)%fields(1)%expression, 0.0_wp, 2.0_wp, found)
      call check(size(found) == size(times), law//': number of breaks')
      if (size(found) /= size(times)) return
      do i = 1, size(times)
         call check_close(found(i), times(i), 4*spacing(times(i)), law//': a break')
      end do
   end subroutine expect

end program test_law_breaks
