!> Runs whose integrator changes on its way. A run turns stiff: a block slides to rest under friction F tanh(v/eps) and a force P,
!> and then creeps with eps*atanh(P/F), its way being v0^2/(2 (F - P)). INTEGRATOR=AUTO begins with ADAMS and goes over to RADAU;
!> ADAMS as the deck's choice is told what it costs; a damper that is there from the start begins with RADAU. And a run is not stiff
!> after all: a vibration x = A cos(omega t), far faster than the motion beside it, that the tolerance asks for. AUTO begins with
!> RADAU and goes over to ADAMS, which costs less than a third at the same error.
!> Usage, in tests/: test_stiffening RESULT_FILE
program test_stiffening
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use limber_commands_run, only: run_deck
   use limber_output_history_reader, only: history_reader_type
   use pieces, only: compare_pieces
   use runs, only: change_deck, channel
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   character(512) :: argument
   integer :: i, j
   real(wp), parameter :: widths(4) = [1.0e-3_wp, 1.0e-4_wp, 1.0e-5_wp, 1.0e-6_wp]
   character(4), parameter :: tolerances(3) = ['1e-4', '1e-6', '1e-9']

   call get_command_argument(1, argument)
   do i = 1, size(widths)
      do j = 1, size(tolerances)
         call check_friction(trim(argument), widths(i), tolerances(j), '1')
      end do
   end do
   call check_friction(trim(argument), 1.0e-4_wp, '1e-6', '-1')
   call check_implicit(trim(argument), 'RADAU')
   call check_implicit(trim(argument), 'ALPHA')
   call check_told(trim(argument))
   call check_damper(trim(argument))
   call compare_pieces('../tests/verification/friction', trim(argument), 5, 'eps = 1e-4', 'eps = 1e-3', 'OUTPUTS=20', 'OUTPUTS=20')
   call check_vibration(trim(argument), '1e-4', '1000', 1.0e-4_wp, 12000)
   call check_vibration(trim(argument), '1e-4', '2000', 2.0e-4_wp, 24000)
   call check_vibration(trim(argument), '2e-4', '500', 2.0e-4_wp, 8000)
   call compare_pieces('../tests/verification/vibration', trim(argument), 5, 'amplitude = 1e-4', 'amplitude = 2e-4', &
      & 'OUTPUTS=20', 'OUTPUTS=20')
   call finish()

contains

   !> A vibration that RADAU begins and ADAMS follows for less, against its closed form; the deck's own choice is left alone.
   subroutine check_vibration(results, amplitude, omega, within, most)
      character(*), intent(in) :: results, amplitude, omega
      !> Error of the speed that is allowed, and evaluations
      real(wp), intent(in) :: within
      integer, intent(in) :: most
      character(:), allocatable :: report, label
      real(wp), allocatable :: x(:), v(:)
      real(wp) :: a, w
      character(60) :: old(2), new(2)
      read (amplitude, *) a
      read (omega, *) w
      label = 'vibration of '//amplitude//' at '//omega//': '
      old = [character(60) :: 'amplitude = 1e-4, omega = 1000', 'TOLERANCE=1e-6']
      new(1) = 'amplitude = '//amplitude//', omega = '//omega
      new(2) = old(2)
      call run_it(results, old, new, report, x, v, 'verification/vibration.inp')
      call check(index(report, 'ADAMS, chosen: ') > 0 .and. index(report, 'RADAU up to t = ') > 0, label//'goes over to ADAMS')
      call check_close(x(size(x)), a*cos(w), within/w, label//'place')
      call check_close(v(size(v)), -a*w*sin(w), within, label//'speed')
      call check(evaluations(report) < most, label//'costs little: '//as_text(evaluations(report)))
      new(2) = 'TOLERANCE=1e-6, INTEGRATOR=RADAU'
      call run_it(results, old, new, report, x, v, 'verification/vibration.inp')
      call check(index(report, 'chosen: ') == 0 .and. evaluations(report) > 3*most, label//'RADAU as the deck asks for it: '// &
         & as_text(evaluations(report)))
   end subroutine check_vibration

   !> The motion, and what the report says of the integrators.
   subroutine check_friction(results, width, tolerance, sense)
      character(*), intent(in) :: results, tolerance, sense
      real(wp), intent(in) :: width
      character(:), allocatable :: report, label
      real(wp), allocatable :: x(:), v(:)
      real(wp) :: accuracy
      character(40) :: new(3)
      new(1) = 'eps = '//as_text(width, 1)
      new(2) = 'TOLERANCE='//tolerance
      new(3) = 'sense = '//sense
      call run_it(results, [character(40) :: 'eps = 1e-4', 'TOLERANCE=1e-6', 'sense = 1'], new, report, x, v)
      label = 'friction with eps='//as_text(width, 1)//' at '//tolerance//': '
      read (tolerance, *) accuracy
      if (sense == '-1') then
         x = -x
         v = -v
      end if
      call check(index(report, 'RADAU, chosen: ') > 0 .and. index(report, 'ADAMS up to t = ') > 0, label//'goes over to RADAU')
      call check(evaluations(report) < 10000, label//'costs little: '//as_text(evaluations(report)))
      call check_close(x(size(x)), 1.0_wp + width*atanh(1/3.0_wp)*9, 20*accuracy + width**2, label//'way')
      call check_close(v(size(v)), width*atanh(1/3.0_wp), 1.0e-2_wp*width, label//'creep')
   end subroutine check_friction

   !> An implicit method keeps to the layer of the law at a tolerance that is much wider than that.
   subroutine check_implicit(results, integrator)
      character(*), intent(in) :: results, integrator
      character(:), allocatable :: report
      real(wp), allocatable :: x(:), v(:)
      character(40) :: new(2)
      new(1) = 'eps = 1e-6'
      new(2) = 'TOLERANCE=1e-4, INTEGRATOR='//integrator
      call run_it(results, [character(40) :: 'eps = 1e-4', 'TOLERANCE=1e-6'], new, report, x, v)
      call check(evaluations(report) < 20000, integrator//' costs little: '//as_text(evaluations(report)))
      call check_close(x(size(x)), 1.0_wp, 2.0e-3_wp, integrator//': way')
      call check_close(v(size(v)), 1.0e-6_wp*atanh(1/3.0_wp), 1.0e-8_wp, integrator//': creep')
   end subroutine check_implicit

   !> ADAMS as the deck asks for it, in a layer wide enough for a test: a tenth of it costs 15 times as much.
   subroutine check_told(results)
      character(*), intent(in) :: results
      character(:), allocatable :: report
      real(wp), allocatable :: x(:), v(:)
      call run_it(results, [character(40) :: 'OUTPUTS=20', 'eps = 1e-4'], [character(40) :: 'OUTPUTS=20, INTEGRATOR=ADAMS', &
         & 'eps = 1e-3'], report, x, v)
      call check(index(report, 'warning: ADAMS is bound to steps of ') > 0, 'ADAMS is questioned')
      call check(index(report, 'the fastest decay (') > 0 .and. index(report, 'use INTEGRATOR=AUTO or RADAU') > 0, &
         & 'cause and remedy')
      call check_close(x(size(x)), 1.0_wp + 1.0e-3_wp*atanh(1/3.0_wp)*9, 1.0e-4_wp, 'ADAMS: way')
   end subroutine check_told

   !> A damper without a mass that is worth it: x = exp(-k t/c).
   subroutine check_damper(results)
      character(*), intent(in) :: results
      character(:), allocatable :: report
      real(wp), allocatable :: x(:), v(:)
      call run_it(results, [character(60) :: 'VX=sense*speed', 'sense*force - friction*tanh(vx(block)/eps)'], &
         & [character(60) :: 'VX=-1e-1, X=1', '-1e5*x(block) - 1e6*vx(block)'], report, x, v)
      call check(index(report, 'RADAU, chosen: the fastest decay (1e6 1/s)') > 0, 'a damper begins with RADAU')
      call check_close(x(size(x)), exp(-1.0_wp), 1.0e-5_wp, 'damper: way')
   end subroutine check_damper

   !> Runs the deck with texts exchanged.
   subroutine run_it(results, old, new, report, x, v, deck)
      character(*), intent(in) :: results, old(:), new(:)
      character(:), allocatable, intent(out) :: report
      real(wp), allocatable, intent(out) :: x(:), v(:)
      !> That of friction if absent
      character(*), intent(in), optional :: deck
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      if (present(deck)) then
         call change_deck(deck, results//'.inp', old, new)
      else
         call change_deck('verification/friction.inp', results//'.inp', old, new)
      end if
      call run_deck(results//'.inp', results, .true., .true., report, error)
      call check_no_error(error, 'friction')
      call reader%open(results, error)
      call check_no_error(error, 'friction: results')
      x = channel(reader, 'x')
      v = channel(reader, 'vx')
      call reader%close()
   end subroutine run_it

   !> Their number in the report.
   integer function evaluations(report)
      character(*), intent(in) :: report
      integer :: last, first
      evaluations = huge(1)
      last = index(report, ' evaluations')
      if (last == 0) return
      first = index(report(:last - 1), ' ', back=.true.)
      read (report(first:last), *) evaluations
   end function evaluations

end program test_stiffening
