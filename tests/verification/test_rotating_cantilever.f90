!> Frequencies of a rotating cantilever in the plane of rotation against the table of a converged solution (flap frequencies; the
!> lag frequency is sqrt(flap^2 - speed^2)), from the deck's own beam in its steady rotation.
!> Usage, in tests/: test_rotating_cantilever RESULT_FILE
program test_rotating_cantilever
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_base_lapack, only: dsyev
   use limber_base_text, only: as_text
   use limber_scene_first_scene, only: read_scene
   use limber_scene_scene, only: scene_type
   use limber_beam_elastic_forces, only: elastic_tangent
   use limber_beam_reduced_body, only: reduced_type
   use limber_multibody_body, only: body_tangent
   use exact_frames, only: solved
   use runs, only: change_deck, channel, run_changed
   use limber_output_history_reader, only: history_reader_type
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   !> Speed, first and second flap frequency, both in units of sqrt(EI/(rho A L^4))
   real(wp), parameter :: table(3, 10) = reshape([0.0_wp, 3.5160152685_wp, 22.0344915647_wp, 1.0_wp, 3.6816468140_wp, &
      & 22.1810111506_wp, 2.0_wp, 4.1373195730_wp, 22.6149219565_wp, 3.0_wp, 4.7972785324_wp, 23.3202636743_wp, 4.0_wp, &
      & 5.5850014209_wp, 24.2733493944_wp, 5.0_wp, 6.4495447486_wp, 25.4460803580_wp, 6.0_wp, 7.3603730193_wp, 26.8090816785_wp, &
      & 8.0_wp, 9.2568376005_wp, 29.9953818916_wp, 10.0_wp, 11.2023277622_wp, 33.6403658542_wp, 12.0_wp, 13.1701504875_wp, &
      & 37.6031123312_wp], [3, 10])
   character(256) :: results

   call get_command_argument(1, results)
   call test_table('BENDING MODES=3, GEOMETRIC=K_G, GEOMETRIC ELEMENTS=8, GEOMETRIC INTEGRAL=LINEAR', 5.0e-3_wp)
   call test_table('BENDING MODES=6, GEOMETRIC=K_G, GEOMETRIC ELEMENTS=8, GEOMETRIC INTEGRAL=LINEAR', 5.0e-4_wp)
   call test_table('BENDING MODES=3, GEOMETRIC=K_G, GEOMETRIC ELEMENTS=16', 5.0e-3_wp)
   call test_table('BENDING MODES=6, GEOMETRIC=K_G, GEOMETRIC ELEMENTS=32', 5.0e-4_wp)
   call test_run()
   call finish()

contains

   !> All speeds of the table.
   subroutine test_table(choice, most)
      character(*), intent(in) :: choice
      !> Largest relative error
      real(wp), intent(in) :: most
      type(scene_type) :: scene
      type(error_type), allocatable :: error
      character(90), parameter :: old(1) = [character(90) :: &
         & 'BENDING MODES=3, GEOMETRIC=K_G, GEOMETRIC ELEMENTS=8, GEOMETRIC INTEGRAL=LINEAR']
      character(90) :: new(1)
      real(wp) :: lag(2), flap(2), worst
      integer :: i
      new(1) = choice
      call change_deck('../input/rotating_cantilever.inp', trim(results)//'.inp', old, new)
      call read_scene(trim(results)//'.inp', scene, error)
      call check_no_error(error, choice)
      worst = 0.0_wp
      do i = 1, size(table, 2)
         lag = lag_frequencies(scene%system%model%bodies(1)%reduced, table(1, i))
         flap = sqrt(lag**2 + table(1, i)**2)
         worst = max(worst, maxval(abs(flap/table(2:, i) - 1)))
         call check(maxval(abs(flap/table(2:, i) - 1)) <= most, choice//' at speed '//as_text(table(1, i), 3)//': '// &
            & as_text(flap(1), 8)//', '//as_text(flap(2), 8))
      end do
      print '(2a,es10.2)', choice, ': largest error ', worst
   end subroutine test_table

   !> Lowest two frequencies of vibration about the steady rotation. The gyroscopic part i 2 nu omega E makes the matrix of
   !> K - nu^2 Hermitian: as a real one twice as large its negative eigenvalues are counted.
   function lag_frequencies(body, speed) result(nu)
      type(reduced_type), intent(in) :: body
      real(wp), intent(in) :: speed
      real(wp) :: nu(2)
      real(wp) :: stiffness(3 + body%n, 1 + body%n), damping(3 + body%n, 1 + body%n), eta(body%n), low, high
      integer :: k, round
      eta = 0.0_wp
      do round = 1, 20
         call tangent_of(body, speed, eta, stiffness, damping)
         eta = eta + solved(stiffness(4:, 2:), rest(body, speed, eta))
      end do
      call check(maxval(abs(rest(body, speed, eta))) < 1.0e-9_wp, 'steady rotation')
      call tangent_of(body, speed, eta, stiffness, damping)
      do k = 1, 2
         low = 0.0_wp
         high = 100.0_wp
         do round = 1, 60
            nu(k) = 0.5_wp*(low + high)
            if (negative(stiffness(4:, 2:), damping(4:, 2:), nu(k)) < k) then
               low = nu(k)
            else
               high = nu(k)
            end if
         end do
      end do
   end function lag_frequencies

   !> Derivative of all forces on the coordinates.
   subroutine tangent_of(body, speed, eta, stiffness, damping)
      type(reduced_type), intent(in) :: body
      real(wp), intent(in) :: speed, eta(:)
      real(wp), intent(out) :: stiffness(:, :), damping(:, :)
      real(wp), parameter :: nil(2) = [0.0_wp, 0.0_wp]
      real(wp) :: zero(body%n), z(size(body%cubic, 1)), s(size(z)), slope(size(z), 2)
      zero = 0.0_wp
      stiffness = 0.0_wp
      damping = 0.0_wp
      z = 0.0_wp
      s = 0.0_wp
      slope = 0.0_wp
      call body_tangent(body, nil, [1.0_wp, 0.0_wp], speed, eta, zero, nil, 0.0_wp, zero, stiffness, damping)
      call elastic_tangent(body, eta, stiffness(4:, 2:), s)
   end subroutine tangent_of

   !> What is left of the forces in a steady rotation; without deflection elastic forces are linear.
   function rest(body, speed, eta) result(force)
      type(reduced_type), intent(in) :: body
      real(wp), intent(in) :: speed, eta(:)
      real(wp) :: force(size(eta))
      force = speed**2*(body%d + eta) - body%omega2*eta
   end function rest

   !> Number of negative eigenvalues of K - nu^2 + i nu D, D skew, each counted once.
   integer function negative(k, d, nu)
      real(wp), intent(in) :: k(:, :), d(:, :), nu
      real(wp) :: whole(2*size(k, 1), 2*size(k, 1)), value(2*size(k, 1)), work(20*size(k, 1))
      integer :: n, i, info
      n = size(k, 1)
      whole(:n, :n) = k
      whole(n + 1:, n + 1:) = k
      whole(:n, n + 1:) = -nu*d
      whole(n + 1:, :n) = nu*d
      do i = 1, 2*n
         whole(i, i) = whole(i, i) - nu**2
      end do
      call check(maxval(abs(whole - transpose(whole))) < 1.0e-8_wp*maxval(abs(whole)), 'symmetric')
      call dsyev('N', 'L', 2*n, whole, 2*n, value, work, size(work), info)
      negative = count(value < 0.0_wp)/2
   end function negative

   !> The deck itself: after the gust the blade vibrates at its first lag frequency.
   subroutine test_run()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: t(:), u2(:), tension(:)
      character(1), parameter :: nothing(0) = [character(1) ::]
      real(wp) :: cross, first, lag
      integer :: i, crossings
      call run_changed('../input/rotating_cantilever.inp', trim(results), nothing, nothing, reader)
      call reader%read_time(t, error)
      call check_no_error(error, 'times')
      allocate (u2, source=channel(reader, 'u2_blade_end'))
      allocate (tension, source=channel(reader, 'axial_force_blade_start'))
      call reader%close()
      crossings = 0
      first = 0.0_wp
      cross = 0.0_wp
      do i = 2, size(t)
         if (t(i) < 12.2_wp .or. .not. (u2(i - 1) < 0.0_wp .and. u2(i) >= 0.0_wp)) cycle
         cross = t(i - 1) + (t(i) - t(i - 1))*u2(i - 1)/(u2(i - 1) - u2(i))
         crossings = crossings + 1
         if (crossings == 1) first = cross
      end do
      lag = 2*acos(-1.0_wp)*(crossings - 1)/(cross - first)
      print '(a,2f10.5)', 'run: lag frequency ', lag, sqrt(7.3603730193_wp**2 - 36)
      call check_close(lag, sqrt(7.3603730193_wp**2 - 36), 0.005_wp*lag, 'lag frequency of the run')
      ! The tension vibrates about that of the steady rotation, rho A omega^2 L^2/2
      call check_close(sum(tension(1301:))/size(tension(1301:)), 18.0_wp, 0.4_wp, 'mean tension')
   end subroutine test_run

end program test_rotating_cantilever
