!> Flexible bodies in decks: a portal against the exact theory of its members, a free beam in flight against momentum and the
!> frequency of its vibration, a flexible four-bar against finer and fuller models and, when it is stiff, against the statics of
!> its coupler under its inertia. Usage, in tests/: test_flexible RESULT_FILE
program test_flexible
   use exact_frames, only: dynamic_stiffness, exact_near, frame_stiffness, solved
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_scene_first_scene, only: read_scene
   use limber_scene_scene, only: scene_type
   use limber_deck_effective, only: effective_deck
   use limber_beam_plane_frame, only: member_type
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_changed, channel
   use testing, only: check, check_close, check_no_error, check_text, finish
   implicit none

   real(wp), parameter :: pi = acos(-1.0_wp)
   character(256) :: results
   character(1), parameter :: nothing(0) = [character(1) ::]

   call get_command_argument(1, results)
   call test_portal(.false.)
   call test_portal(.true.)
   call test_free_beam()
   call test_four_bar()
   call test_stiff_coupler()
   call finish()

contains

   !> The means over many periods are the static solution, and the period is that of the exact first frequency. As the deck has it
   !> the modes are those of the clamped portal; `welded`, those of one that is pinned and on a roller, and joints clamp both feet.
   subroutine test_portal(welded)
      logical, intent(in) :: welded
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      type(member_type) :: members(4)
      real(wp), allocatable :: t(:), sway(:), foot(:), shear(:), stress(:), balance(:), envelope(:, :)
      real(wp) :: corners(2, 5), mass(3, 5), force(9), u(9), inner(6), mean, omega, k(6, 6)
      logical :: free(3, 5)
      real(wp), parameter :: e = 2.1e11_wp, rho = 7850.0_wp, area = pi*(0.2_wp**2 - 0.18_wp**2)/4, &
         & inertia = pi*(0.2_wp**4 - 0.18_wp**4)/64, load = 2.0e3_wp
      character(120) :: old(3), new(3)
      integer :: m, last
      corners = reshape([0.0_wp, 0.0_wp, 0.0_wp, 4.0_wp, 2.0_wp, 4.0_wp, 6.0_wp, 4.0_wp, 6.0_wp, 0.0_wp], [2, 5])
      do m = 1, 4
         members(m) = member_type(ends=[m, m + 1], ea=e*area, ei=e*inertia, rho_a=rho*area)
         if (m == 2 .or. m == 3) members(m) = member_type(ends=[m, m + 1], ea=e*0.024_wp, ei=e*0.1_wp*0.24_wp**3/12, &
            & rho_a=rho*0.024_wp)
      end do
      free = .true.
      free(:, [1, 5]) = .false.
      mass = 0.0_wp
      mass(:, 3) = [800.0_wp, 800.0_wp, 150.0_wp]
      ! At rest: a vibration of almost no frequency
      force = 0.0_wp
      force(1) = load
      u = solved(frame_stiffness(corners, members, mass, free, 1.0e-2_wp), force)
      old = [character(120) :: 'base, 1, 6', ' 5, span, 0', '*FORCE, NAME=wind']
      new(1) = '1, 1, 2'//new_line('a')//' 5, 2'//new_line('a')//'*ATTACHMENT'//new_line('a')//' 1, 6'//new_line('a')//' 5, 6' &
         & //new_line('a')//' 5, 1'
      new(2) = ' 5, span, 0, toe'
      new(3) = '*GROUND'//new_line('a')//' base, span, 0'//new_line('a')//'*JOINT, NAME=second, TYPE=WELD'//new_line('a')// &
         & ' portal.toe, ground.base'//new_line('a')//'*FORCE, NAME=wind'
      m = merge(3, 0, welded)
      call run_changed('../input/portal_frame.inp', trim(results), old(:m), new(:m), reader)
      call reader%read_time(t, error)
      call check_no_error(error, 'portal: times')
      allocate (sway, source=channel(reader, 'u1_portal_knee'))
      allocate (foot, source=channel(reader, 'bending_moment_portal_left_foot'))
      allocate (shear, source=channel(reader, 'shear_force_portal_left_foot'))
      allocate (stress, source=channel(reader, 'stress_top_portal_left_foot'))
      allocate (balance, source=channel(reader, 'balance'))
      ! The envelope has two sections at each twelfth and fortieth of each member, the first at its start, the last at its end
      call reader%read_table('/bodies/portal/envelope/bending_moment', envelope, error)
      call check_no_error(error, 'portal: envelope')
      call check(size(envelope, 1) == 2 .and. size(envelope, 2) == 384, 'portal: sections of the envelope')
      call check(maxval(abs(envelope(:, 1) - [minval(foot), maxval(foot)])) <= 1.0e-9_wp*maxval(abs(foot)), &
         & 'portal: envelope of the moment at the foot')
      call check(all(envelope(1, :) <= envelope(2, :)) .and. maxval(abs(envelope(:, 2:94:2) - envelope(:, 3:95:2))) &
         & <= 1.0e-6_wp*maxval(abs(foot)), 'portal: the moment does not jump within a member')
      call reader%read_table('/bodies/portal/envelope/stress_top', envelope, error)
      call check_no_error(error, 'portal: envelope of the stress')
      call check(maxval(abs(envelope(:, 1) - [minval(stress), maxval(stress)])) <= 1.0e-9_wp*maxval(abs(stress)), &
         & 'portal: envelope of the stress at the foot')
      call read_again(reader)
      call reader%close()
      call check(maxval(abs(balance)) < 1.0e-5_wp*load*maxval(sway), 'portal: energy')
      omega = first_frequency(t, sway, mean, last)
      print '(a,2es14.6,a,2f12.6)', 'portal: sway ', mean, u(1), '; frequency ', omega, &
         & exact_near(corners, members, mass, free, omega)
      call check_close(mean/u(1), 1.0_wp, 3.0e-3_wp, 'portal: static sway')
      call check_close(omega/exact_near(corners, members, mass, free, omega), 1.0_wp, 2.0e-3_wp, 'portal: first frequency')
      ! Forces at the foot in the axes of the column, which goes up: y of the column is -x of space
      k = dynamic_stiffness(members(1), corners, 1.0e-2_wp)
      inner = matmul(k(:, 4:6), u(1:3))
      call check_close(average(t, foot, last)/(-inner(3)), 1.0_wp, 1.0e-2_wp, 'portal: moment at the foot')
      call check_close(average(t, shear, last)/inner(1), 1.0_wp, 1.0e-2_wp, 'portal: shear at the foot')
      ! The left fibre of the column that goes up, on the side of the wind
      call check_close(average(t, stress, last), inner(2)*(-1)/area + inner(3)*0.1_wp/inertia, &
         & 1.0e-2_wp*maxval(stress), 'portal: stress at the foot')
      if (.not. welded) call test_at_rest(-inner(3), inner(1), inner(3)*0.1_wp/inertia - inner(2)/area)
   end subroutine test_portal

   !> Damped, the portal comes to rest: there its internal forces are those of statics with only two modes.
   subroutine test_at_rest(moment, shear, stress)
      !> Exact values at the left foot
      real(wp), intent(in) :: moment, shear, stress
      type(history_reader_type) :: reader
      real(wp), allocatable :: values(:, :)
      character(80) :: old(2), new(2)
      real(wp) :: wrong(3)
      old = [character(80) :: '*FORCE, NAME=wind', 'MODES=6']
      new(1) = '*DAMPING, BODY=portal, RATIO=0.4'//new_line('a')//'*FORCE, NAME=wind'
      new(2) = 'MODES=2'
      call run_changed('../input/portal_frame.inp', trim(results), old, new, reader)
      allocate (values(1001, 3))
      values(:, 1) = channel(reader, 'bending_moment_portal_left_foot')
      values(:, 2) = channel(reader, 'shear_force_portal_left_foot')
      values(:, 3) = channel(reader, 'stress_top_portal_left_foot')
      call reader%close()
      wrong = values(1001, :)/[moment, shear, stress] - 1
      print '(a,3es10.2)', 'portal at rest with two modes: errors of moment, shear, stress ', wrong
      call check_close(maxval(abs(wrong)), 0.0_wp, 1.0e-6_wp, 'portal at rest: internal forces')
   end subroutine test_at_rest

   !> The effective deck of a run can be read again, and is its own effective deck.
   subroutine read_again(reader)
      type(history_reader_type), intent(in) :: reader
      type(error_type), allocatable :: error
      type(scene_type) :: scene
      character(:), allocatable :: deck
      integer :: unit
      call reader%read_text('/run/effective_deck', deck, error)
      call check_no_error(error, 'effective deck')
      open (newunit=unit, file=trim(results)//'.again.inp', access='stream', action='write', status='replace')
      write (unit) deck
      close (unit)
      call read_scene(trim(results)//'.again.inp', scene, error)
      call check_no_error(error, 'the effective deck, read again')
      if (.not. allocated(error)) call check_text(effective_deck(scene%deck), deck, 'the effective deck of the effective deck')
   end subroutine read_again

   !> Circular frequency from upward crossings of the mean, which is that over whole periods.
   real(wp) function first_frequency(t, y, mean, last) result(omega)
      real(wp), intent(in) :: t(:), y(:)
      real(wp), intent(out) :: mean
      !> Last sample of the whole periods
      integer, intent(out) :: last
      real(wp) :: first, cross, before
      integer :: i, crossings, round
      mean = sum(y)/size(y)
      last = size(y)
      do round = 1, 3
         crossings = 0
         first = 0.0_wp
         before = 0.0_wp
         do i = 2, size(y)
            if (.not. (y(i - 1) < mean .and. y(i) >= mean)) cycle
            cross = t(i - 1) + (t(i) - t(i - 1))*(mean - y(i - 1))/(y(i) - y(i - 1))
            if (crossings > 0 .and. cross - before < 0.5_wp*(before - first)/max(1, crossings - 1)) cycle
            crossings = crossings + 1
            if (crossings == 1) first = cross
            before = cross
            last = i - 1
         end do
         omega = 2*pi*(crossings - 1)/(before - first)
         mean = average(t, y, last, first)
      end do
   end function first_frequency

   !> Mean up to a sample, of whole periods if it starts at a crossing.
   real(wp) function average(t, y, last, from)
      real(wp), intent(in) :: t(:), y(:)
      integer, intent(in) :: last
      real(wp), intent(in), optional :: from
      integer :: first
      first = 1
      if (present(from)) first = count(t < from) + 1
      average = sum(y(first:last))/(last - first + 1)
   end function average

   !> After the blow momentum and energy stay; the centre flies straight; the beam vibrates with 22.3733 sqrt(EI/rho A)/L^2.
   subroutine test_free_beam()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: t(:), p(:), angular(:), energy(:), bent(:), balance(:)
      real(wp) :: omega, exact, mean, mass
      integer :: last
      call run_changed('../input/free_free_beam.inp', trim(results), nothing, nothing, reader)
      call reader%read_time(t, error)
      call check_no_error(error, 'free beam: times')
      allocate (p, source=channel(reader, 'momentum_y_system'))
      allocate (angular, source=channel(reader, 'angular_momentum_system'))
      allocate (energy, source=channel(reader, 'energy'))
      allocate (balance, source=channel(reader, 'balance'))
      allocate (bent, source=channel(reader, 'deflection_bar_middle'))
      call reader%close()
      mass = 2700*0.03_wp*0.006_wp*1.5_wp
      ! The force times its duration; its arm about the fixed origin is the length until the beam has turned and bent a little
      call check_close(p(size(p)), 5*0.02_wp, 1.0e-9_wp, 'free beam: momentum of the blow')
      call check_close(maxval(abs(p(61:) - p(61))), 0.0_wp, 1.0e-9_wp, 'free beam: momentum stays')
      call check_close(angular(61), 5*0.02_wp*1.5_wp, 1.0e-4_wp, 'free beam: angular momentum of the blow')
      call check_close(maxval(abs(angular(61:) - angular(61))), 0.0_wp, 1.0e-7_wp, 'free beam: angular momentum stays')
      call check_close(maxval(abs(energy(61:) - energy(61))), 0.0_wp, 1.0e-6_wp*energy(61), 'free beam: energy stays')
      call check(maxval(abs(balance)) < 1.0e-6_wp*energy(61), 'free beam: work of the blow')
      call check(energy(61) > 0.5_wp*p(61)**2/mass + 1.0e-3_wp, 'free beam: it turns and vibrates')
      omega = first_frequency(t(61:), bent(61:), mean, last)
      exact = 22.3732854_wp/1.5_wp**2*sqrt(70.0e9_wp*0.006_wp**2/12/2700)
      print '(a,2f12.6)', 'free beam: frequency ', omega, exact
      ! The stretch of the turning beam and its large deflection raise it a little
      call check_close(omega/exact, 1.0_wp, 1.0e-2_wp, 'free beam: frequency of its vibration')
   end subroutine test_free_beam

   !> The four-bar as the deck has it against one with more functions; at half the speed, where
   !> foreshortening matters less, against the model k_g, which is linear in the axial coordinates.
   subroutine test_four_bar()
      real(wp), allocatable :: own(:), fine(:), slow(:), linear(:), moment(:), other(:)
      character(90) :: old(4), new(4)
      call four_bar(old(:0), new(:0), own, moment)
      old = 'FUNCTIONS=6'
      new(1:2) = 'FUNCTIONS=10, STRAIN FUNCTIONS=3'
      call four_bar(old(1:2), new(1:2), fine, other)
      print '(a,2es12.4,a,2es12.4)', 'four-bar: deflection, error ', maxval(abs(fine)), maxval(abs(own - fine)), '; moment ', &
         & maxval(abs(other)), maxval(abs(moment - other))
      call check_close(maxval(abs(own - fine)), 0.0_wp, 0.02_wp*maxval(abs(fine)), 'four-bar: a finer model')
      call check_close(maxval(abs(moment - other)), 0.0_wp, 0.02_wp*maxval(abs(other)), 'four-bar: moment of a finer model')
      old(3) = 'speed = 340*pi/30'
      new(3) = 'speed = 170*pi/30'
      call four_bar(old(3:3), new(3:3), slow, moment)
      new(1:2) = 'BENDING MODES=3, AXIAL MODES=1, GEOMETRIC=K_G, GEOMETRIC ELEMENTS=4'
      call four_bar(old(:3), new(:3), linear, other)
      print '(a,2es12.4)', 'four-bar at half the speed: deflection, difference of k_g ', maxval(abs(slow)), &
         & maxval(abs(slow - linear))
      call check_close(maxval(abs(slow - linear)), 0.0_wp, 0.05_wp*maxval(abs(slow)), 'four-bar: the model k_g')
   end subroutine test_four_bar

   subroutine four_bar(old, new, deflection, moment)
      character(*), intent(in) :: old(:), new(:)
      real(wp), allocatable, intent(out) :: deflection(:), moment(:)
      type(history_reader_type) :: reader
      real(wp), allocatable :: balance(:)
      call run_changed('../input/flexible_four_bar.inp', trim(results), old, new, reader)
      allocate (deflection, source=channel(reader, 'deflection_coupler_middle'))
      allocate (moment, source=channel(reader, 'bending_moment_coupler_middle'))
      allocate (balance, source=channel(reader, 'balance'))
      call reader%close()
      call check(maxval(abs(balance - balance(1))) < 1.0e-5_wp, 'four-bar: energy')
   end subroutine four_bar

   !> A hundred times as stiff, and as rigid bodies move: the moment in the middle of the coupler is rho A L^2/16 (a_1 + a_2), with
   !> the accelerations of its ends across it, from the kinematics of the closed loop.
   subroutine test_stiff_coupler()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: t(:), moment(:), tension(:), angle(:)
      real(wp), parameter :: a = 0.108_wp, b = 0.2794_wp, c = 0.2705_wp, d = 0.254_wp, w = 340*pi/30, rho_a = 2770*4.06e-5_wp
      real(wp) :: x(2), u(2), v(2), first(2), second(2), alpha(2), rate(2), crank, expected, worst, det, turned(2)
      real(wp), parameter :: rise = 0.4_wp
      character(40), parameter :: old(5) = [character(40) :: 'YOUNG=7.1e10', 'OUTPUTS=400', 'FUNCTIONS=6', &
         & 'FUNCTIONS=6', 'TOLERANCE=1e-6']
      character(40), parameter :: new(5) = [character(40) :: 'YOUNG=7.1e12', 'OUTPUTS=50', 'BENDING MODES=3, GEOMETRIC=LINEAR', &
         & 'BENDING MODES=3, GEOMETRIC=LINEAR', 'TOLERANCE=1e-5']
      integer :: i
      call run_changed('../input/flexible_four_bar.inp', trim(results), old, new, reader)
      call reader%read_time(t, error)
      call check_no_error(error, 'stiff four-bar: times')
      allocate (moment, source=channel(reader, 'bending_moment_coupler_middle'))
      allocate (tension, source=channel(reader, 'axial_force_coupler_middle'))
      allocate (angle, source=channel(reader, 'angle_coupler'))
      call reader%close()
      worst = 0.0_wp
      do i = 1, size(t)
         if (t(i) < rise + 1.0e-9_wp) cycle
         crank = w*(t(i) - 0.5_wp*rise)
         ! Coupler at the angle of the history, rocker by closing the loop
         u = [cos(angle(i)), sin(angle(i))]
         x = a*[cos(crank), sin(crank)] + b*u
         v = (x - [d, 0.0_wp])/c
         call check(abs(norm2(v) - 1) < 1.0e-4_wp, 'stiff four-bar: the loop is closed')
         ! a w J e + b w2 J u = c w3 J v, and once more with the centripetal terms
         first = -a*w*[-sin(crank), cos(crank)]
         det = b*(-c)*(-u(2)*v(1) + u(1)*v(2))
         rate(1) = (first(1)*(-c)*v(1) - (-c)*(-v(2))*first(2))/det
         rate(2) = (b*(-u(2))*first(2) - b*u(1)*first(1))/det
         second = a*w**2*[cos(crank), sin(crank)] + b*rate(1)**2*u - c*rate(2)**2*v
         alpha(1) = (second(1)*(-c)*v(1) - (-c)*(-v(2))*second(2))/det
         turned = [-u(2), u(1)]
         first = -a*w**2*[cos(crank), sin(crank)]
         second = first + b*alpha(1)*turned - b*rate(1)**2*u
         expected = rho_a*b**2/16*dot_product(turned, first + second)
         worst = max(worst, abs(moment(i) - expected))
      end do
      print '(a,2es12.4)', 'stiff four-bar: moment, error ', maxval(abs(moment)), worst
      call check_close(worst, 0.0_wp, 2.0e-2_wp*maxval(abs(moment)), 'stiff four-bar: moment of the inertia')
   end subroutine test_stiff_coupler

end program test_flexible
