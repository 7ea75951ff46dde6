!> Instants at which laws of time change their formula, found to the bit; and what has none.
program test_law_breaks
   use limber_base_kinds, only: wp
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_content, only: deck_type
   use limber_deck_reader, only: read_deck
   use limber_deck_expression, only: expression_type
   use limber_model_law_breaks, only: law_breaks, law_stations, undefined_at
   use testing, only: check, check_close, finish
   implicit none
   real(wp), parameter :: pi = acos(-1.0_wp)
   !> Half the time for which a sine is within 1e-8 of 1
   real(wp), parameter :: half_width = acos(0.99999999_wp)/(2*pi)
   integer :: k

   call expect('sin(3*t) + t**2', [real(wp) ::])
   call expect('7', [real(wp) ::])
   call expect('max(t - 1, 0)', [1.0_wp])
   call expect('step(t - 0.3) - 2*step(t - 0.7)', [0.3_wp, 0.7_wp])
   call expect('min(t, 1.25)**2 + max(t - 1.25, 0)', [1.25_wp])
   call expect('smoothstep((t - 0.5)/0.75)', [0.5_wp, 1.25_wp])
   call expect('abs(sin(10*t))', [(k*pi/10, k=1, 6)])
   ! However short a pulse is, and whatever comes after it
   call expect('step(t - 0.9999) - step(t - 1.0019)', [0.9999_wp, 1.0019_wp])
   call expect('step(t - 0.3001) - step(t - 0.3001000001)', [0.3001_wp, 0.3001000001_wp])
   call expect('step(t - 0.3)*step(0.300001 - t) + max(t - 1.7, 0)', [0.3_wp, 0.300001_wp, 1.7_wp])
   call expect('step(sin(2*pi*t) - 0.99999999)', [0.25_wp - half_width, 0.25_wp + half_width, 1.25_wp - half_width, &
      & 1.25_wp + half_width], 1.0e-12_wp)
   ! An angle that is wrapped jumps by a turn; behind the second quarter of the other half another formula may hold
   call expect('atan2(sin(4*t), cos(4*t))', [pi/4, 3*pi/8])
   ! At the start and at the end there is nothing to break
   call expect('max(t, 0) + max(t - 2, 0)', [real(wp) ::])
   call test_stations()
   call test_undefined()
   call finish()

contains

   !> Steps end around a smooth pulse, however narrow, and nowhere else.
   subroutine test_stations()
      real(wp), allocatable :: found(:)
      integer :: k
      real(wp) :: width
      do k = 1, 9
         width = 0.1_wp**k
         found = stations('exp(-((t - 0.7003)/1e-'//achar(iachar('0') + k)//')**2)')
         if (k > 1) then
            call check(count(abs(found - 0.7003_wp) < width) > 20, 'steps end within a pulse')
            call check(all(found > 0.0_wp .and. found < 2.0_wp), 'and within the time')
            call check(minval(abs(found - (0.7003_wp - 3.5_wp*width))) < 2*max(width, 4.0e-3_wp), 'and before it')
         end if
      end do
      call check(size(stations('sin(9*t) + 2*t')) == 0, 'what is busy throughout needs no stations')
      call check(size(stations('3 + t')) == 0, 'nor does a ramp')
      call check(size(stations('step(t - 0.3)')) == 0, 'nor a jump')
      call check(size(stations('step(t - 1)*step(1.00001 - t)*sin(pi*(t - 1)/1e-5)')) > 20, 'half a sine')
      call check(size(stations('max(0, sin(3000*t))')) == 0, 'many halves of sines, between breaks')
      call check(size(stations('exp(20*(sin(300*t) - 1))')) > 95*3, 'a train of pulses: some for each of 95')
      call check(size(stations('exp(20*(sin(3000*t) - 1))')) > 955*3, 'pulses shorter than the parts of the time')
   end subroutine test_stations

   !> Laws without a value, and such whose bounds only are too wide.
   subroutine test_undefined()
      call check_close(first_hole('1/(t - 0.503)'), 0.503_wp, 1.0e-11_wp, 'a pole')
      call check_close(first_hole('tan(3*t)'), pi/6, 1.0e-11_wp, 'a pole of a tangent')
      call check_close(first_hole('sqrt(0.5 - t)'), 0.5_wp, 1.0e-11_wp, 'the end of a root')
      call check_close(first_hole('1/t'), 0.0_wp, 1.0e-11_wp, 'a pole at the start')
      call check_close(first_hole('log(1.25 - t)'), 1.25_wp, 1.0e-11_wp, 'the end of a logarithm')
      call check(first_hole('t/(t*t + 1) + (t - 1)**3 + t**0.5 + exp(-t)*cosh(t)') > 2.0_wp, 'a law with values throughout')
      call check(first_hole('sin(t - 1)/(t - 1 + 1e-30)') > 2.0_wp, 'a gap that is none')
      call check(first_hole('abs(t - 1)/max(t, 1e-3) + 1/(1 + sin(t)**2)') > 2.0_wp, 'a quotient with values throughout')
   end subroutine test_undefined

   !> Stations of a torque between 0 and 2.
   function stations(law) result(found)
      character(*), intent(in) :: law
      real(wp), allocatable :: found(:)
      allocate (found(0))
      call law_stations(compiled(law), 0.0_wp, 2.0_wp, found)
   end function stations

   real(wp) function first_hole(law)
      character(*), intent(in) :: law
      first_hole = undefined_at(compiled(law), 0.0_wp, 2.0_wp)
   end function first_hole

   !> Breaks of a torque between 0 and 2.
   subroutine expect(law, times, within)
      character(*), intent(in) :: law
      real(wp), intent(in) :: times(:)
      !> Error that rounding of the law makes
      real(wp), intent(in), optional :: within
      real(wp), allocatable :: found(:)
      real(wp) :: allowed
      integer :: i
      allowed = 0.0_wp
      if (present(within)) allowed = within
      allocate (found(0))
      call law_breaks(compiled(law), 0.0_wp, 2.0_wp, found)
      call check(size(found) == size(times), law//': number of breaks')
      if (size(found) /= size(times)) return
      do i = 1, size(times)
         call check_close(found(i), times(i), max(4*spacing(times(i)), allowed), law//': a break')
      end do
   end subroutine expect

   !> A law as a deck has it.
   function compiled(law) result(expression)
      character(*), intent(in) :: law
      type(expression_type) :: expression
      type(deck_type) :: deck
      type(diagnostics_type) :: diagnostics
      integer :: unit, block
      open (newunit=unit, file='law.inp', action='write', status='replace')
      write (unit, '(a)') '*RIGID BODY, NAME=rotor, MASS=1, INERTIA=1', '*TORQUE, NAME=pull, BODY=rotor', ' '//law
      close (unit)
      call read_deck('law.inp', deck, diagnostics)
      open (newunit=unit, file='law.inp', status='old')
      close (unit, status='delete')
      call check(diagnostics%count == 0, law//' is a law')
      block = deck%find('TORQUE')
      expression = deck%blocks(block)%lines(1)%fields(1)%expression
   end function compiled

end program test_law_breaks
