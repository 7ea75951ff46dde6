!> Sines and cosines of several angles at once: those of the language, to round-off, small angles and large ones.
program test_sines
   use limber_base_kinds, only: wp
   use limber_base_sines, only: take_sines
   use testing, only: check, finish
   implicit none
   integer, parameter :: n = 8
   real(wp) :: angle(n), s(n), c(n), worst
   integer :: i, k

   worst = 0.0_wp
   do i = 0, 2000
      angle = [(0.3_wp*(2*modulo(0.618034_wp*i + 0.137_wp*k, 1.0_wp) - 1), k=1, n)]
      call take_sines(n, angle, s, c)
      worst = max(worst, maxval(abs(s - sin(angle))/abs(angle)), maxval(abs(c - cos(angle))))
   end do
   print '(a,es9.2)', 'small angles: largest difference', worst
   call check(worst <= 4*epsilon(worst), 'small angles')
   angle = [-1.0e3_wp, -3.0_wp, -0.31_wp, 0.0_wp, 0.3_wp, 0.300001_wp, 2.0_wp, 1.0e6_wp]
   call take_sines(n, angle, s, c)
   call check(all(abs(s - sin(angle)) <= epsilon(s)) .and. all(abs(c - cos(angle)) <= epsilon(c)), 'large angles')
   call take_sines(n, spread(0.3_wp, 1, n), s, c)
   call check(all(abs(s - sin(0.3_wp)) <= epsilon(s)) .and. all(abs(c - cos(0.3_wp)) <= epsilon(c)), 'the largest small angle')
   call finish()
end program test_sines
