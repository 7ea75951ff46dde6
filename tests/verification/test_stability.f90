!> Loss of stability in static analyses against closed forms: limit points of a toggle, bifurcation of a portal, flutter and
!> divergence under loads that follow what they push. Usage, in tests/: test_stability RESULT_FILE
program test_stability
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use limber_commands_run, only: run_deck
   use limber_output_history_reader, only: history_reader_type
   use runs, only: change_deck, channel
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   character(256) :: results

   call get_command_argument(1, results)
   call check_toggle()
   call check_click()
   call check_leap()
   call check_portal()
   call check_pendulum()
   call check_ziegler()
   call check_beck()
   call finish()

contains

   !> Runs a changed deck: the instant of its last sample, which is the load factor, and what the run says.
   subroutine last_instant(deck, old, new, last, report)
      character(*), intent(in) :: deck, old(:), new(:)
      real(wp), intent(out) :: last
      character(:), allocatable, intent(out) :: report
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: time(:)
      last = 0.0_wp
      call change_deck('verification/'//deck, trim(results)//'.inp', old, new)
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
      call check_no_error(error, deck)
      if (allocated(error)) return
      call reader%open(trim(results), error)
      call check_no_error(error, deck//': results')
      call reader%read_time(time, error)
      call check_no_error(error, deck//': time')
      last = time(size(time))
      call reader%close()
   end subroutine last_instant

   !> The load at the limit point of two springs k of the free length l at the half span b and the height h, which is passed at the
   !> height y with (b^2 + y^2)^(3/2) = l b^2: 2 k y (l/sqrt(b^2 + y^2) - 1). Any stiffness, unit, side, increment and excess of
   !> load.
   subroutine check_toggle()
      real(wp), parameter :: k(3) = [1000.0_wp, 1.0e9_wp, 0.2_wp], b(3) = [1.0_wp, 0.001_wp, 1000.0_wp]
      real(wp), parameter :: slope(2) = [0.3_wp, 0.02_wp], push(2) = [0.05_wp, 50.0_wp]
      integer, parameter :: increments(4) = [1, 3, 10, 37]
      character(80) :: changed(2)
      character(:), allocatable :: report
      real(wp) :: h, length, y, critical, last
      integer :: i, j, m
      do i = 1, size(k)
         do j = 1, size(slope)
            do m = 1, 4
               h = slope(j)*b(i)
               length = hypot(b(i), h)
               y = sqrt((length*b(i)**2)**(2/3.0_wp) - b(i)**2)
               critical = 2*k(i)*y*(length/hypot(b(i), y) - 1)/(push(1 + modulo(m, 2))*k(i)*h)
               changed(1) = 'k = '//as_text(k(i), 8)//', h = '//as_text(h, 8)//', b = '//as_text(b(i), 8)//', push = '// &
                  & as_text(push(1 + modulo(m, 2)), 8)//', side = '//merge('-1', ' 1', m > 2)
               changed(2) = 'INCREMENTS='//as_text(increments(m))
               call last_instant('toggle.inp', [character(45) :: 'k = 1000, h = 0.3, b = 1, push = 5, side = 1', &
                  & 'INCREMENTS=10'], changed, last, report)
               if (critical < 1.0_wp) then
                  call check_close(last/critical, 1.0_wp, 1.0e-7_wp, 'limit point of a toggle, '//trim(changed(1)))
                  call check(index(report, 'limit point, snap-through') > 0, 'it is named: '//report)
               else
                  call check_close(last, 1.0_wp, 0.0_wp, 'below its limit point a toggle is stable, '//trim(changed(1)))
               end if
            end do
         end do
      end do
   end subroutine check_toggle

   !> A click of 2 mm beside a crank of 2 m that turns by much more.
   subroutine check_click()
      integer, parameter :: increments(3) = [1, 4, 40]
      character(6), parameter :: load(2) = ['P = .1', 'P = 1 ']
      real(wp), parameter :: critical(2) = [0.03829878864504365_wp, 0.0038298788645043653_wp]
      character(13) :: changed(2)
      character(:), allocatable :: report
      real(wp) :: last
      integer :: i, j
      do i = 1, size(increments)
         do j = 1, size(load)
            changed(1) = load(j)
            changed(2) = 'INCREMENTS='//as_text(increments(i))
            call last_instant('click.inp', [character(13) :: 'P = 0.05', 'INCREMENTS=10'], changed, last, report)
            call check_close(last/critical(j), 1.0_wp, 1.0e-7_wp, 'a small click beside a large crank, '//trim(changed(2)))
            call check(index(report, 'limit point, snap-through') > 0, 'it is named: '//report)
         end do
      end do
   end subroutine check_click

   !> Without STOP the leap is told, and leads to equilibrium on the other side.
   subroutine check_leap()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp), allocatable :: y(:)
      real(wp) :: down
      call last_instant('toggle.inp', [character(17) :: 'INSTABILITY=STOP'], [character(17) :: 'INSTABILITY=LEAVE'], down, report)
      call check_close(down, 1.0_wp, 0.0_wp, 'a toggle that has leapt goes on')
      call check(index(report, 'limit point, snap-through') > 0, 'its leap is told: '//report)
      call reader%open(trim(results), error)
      allocate (y, source=channel(reader, 'y_middle'))
      down = -y(size(y))
      call check(down > 0.3_wp, 'it is on the other side')
      call check_close(2*1000*down*(1 - sqrt(1.09_wp)/hypot(1.0_wp, down)), 5*1000*0.3_wp, 1.0e-7_wp, 'in equilibrium')
      call reader%close()
   end subroutine check_leap

   !> A portal with clamped feet and three equal members sways at kL cot kL = -6, P = 7.3791 EI/L^2, whatever the increments.
   subroutine check_portal()
      integer, parameter :: increments(3) = [1, 7, 20]
      character(:), allocatable :: report
      real(wp) :: last, first
      integer :: i
      first = 0.0_wp
      do i = 1, size(increments)
         call last_instant('portal_sway.inp', ['INCREMENTS=10'], ['INCREMENTS='//as_text(increments(i))], last, report)
         if (i == 1) first = last
         call check_close(last/first, 1.0_wp, 1.0e-7_wp, 'sway of a portal, increments: '//as_text(increments(i)))
         call check_close(10*last, 7.3791_wp, 2.0e-3_wp, 'sway of a portal')
         call check(index(report, 'bifurcation') > 0, 'it is named: '//report)
      end do
   end subroutine check_portal

   !> An inverted pendulum on a rotational spring: k/l is a bifurcation, whether an increment ends there or not, and whichever way
   !> it stands.
   subroutine check_pendulum()
      character(*), parameter :: increments(4) = [character(13) :: 'INCREMENTS=3', 'INCREMENTS=4', 'INCREMENTS=10', 'INCREMENTS=37']
      character(*), parameter :: side(2) = [character(9) :: 'side = 1', 'side = -1']
      character(:), allocatable :: report
      real(wp) :: last
      integer :: i, j
      do i = 1, size(increments)
         do j = 1, size(side)
            call last_instant('inverted.inp', [character(13) :: 'INCREMENTS=10', 'side = 1'], [character(13) :: increments(i), &
               & side(j)], last, report)
            call check_close(last, 0.5_wp, 1.0e-7_wp, 'an inverted pendulum on a spring, '//increments(i))
            call check(index(report, 'bifurcation') > 0 .and. index(report, 'limit point') == 0, 'it is named: '//report)
         end do
      end do
   end subroutine check_pendulum

   !> Ziegler's double pendulum, masses 2 and 1: flutter at 7/2 - sqrt(2) without damping, 41/28 + c^2/2 with any, as little as it
   !> may be; far above it both motions diverge.
   subroutine check_ziegler()
      character(6), parameter :: damping(3) = ['c = 0 ', 'c = .1', 'c = 1 ']
      real(wp), parameter :: load(3) = [3.5_wp - sqrt(2.0_wp), 41/28.0_wp + 0.005_wp, 41/28.0_wp + 0.5_wp]
      integer, parameter :: increments(2) = [1, 10]
      character(13) :: changed(2)
      character(:), allocatable :: report
      real(wp) :: last
      integer :: i, j
      do i = 1, size(damping)
         do j = 1, size(increments)
            changed(1) = damping(i)
            changed(2) = 'INCREMENTS='//as_text(increments(j))
            call last_instant('ziegler_pendulum.inp', [character(13) :: 'c = 0', 'INCREMENTS=10'], changed, last, report)
            call check_close(3*last/load(i), 1.0_wp, 1.0e-6_wp, 'double pendulum with a follower force, '//damping(i))
            call check(index(report, 'flutter') > 0, 'it flutters: '//report)
         end do
      end do
      call last_instant('ziegler_pendulum.inp', [character(22) :: 'P = 3', ', INSTABILITY=STOP'], [character(5) :: 'P = 7', ''], &
         & last, report)
      call check(index(report, 'flutter') > 0 .and. index(report, 'divergence') > 0, 'far above it diverges: '//report)
   end subroutine check_ziegler

   !> Beck's column flutters at 20.05 EI/L^2; *MODES names the mode behind it.
   subroutine check_beck()
      integer, parameter :: increments(3) = [1, 7, 10]
      character(:), allocatable :: report
      real(wp) :: last
      integer :: i
      do i = 1, size(increments)
         call last_instant('beck_column.inp', [character(13) :: 'INCREMENTS=10'], ['INCREMENTS='//as_text(increments(i))], last, &
            & report)
         call check_close(30*last, 20.0509_wp, 5.0e-3_wp, 'column under a follower force')
         call check(index(report, 'flutter: vibrations at 11.0') > 0, 'it flutters: '//report)
      end do
      call last_instant('beck_column.inp', [', INSTABILITY=STOP'], [' '], last, report)
      call check_close(last, 1.0_wp, 0.0_wp, 'it goes on along the straight column')
      call check(index(report, '  flutter'//new_line('a')) > 0, 'a mode that flutters is named: '//report)
   end subroutine check_beck

end program test_stability
