!> Runs across breaks: loads that change their formula, drivers that change their speed or jump, and a beam that diverges. Between
!> the breaks of its torque a rotor does what a polynomial says, which RADAU integrates exactly if its steps end there, however
!> loose the tolerance.
!> Usage, in tests/: test_events RESULT_FILE
program test_events
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_commands_run, only: run_deck
   use limber_output_history_reader, only: history_reader_type
   use limber_base_text, only: newline
   use runs, only: run_changed, run_text, change_deck, channel
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   character(256) :: results

   call get_command_argument(1, results)
   call check_rotor('RADAU', 1.0e-13_wp)
   call check_rotor('ADAMS', 1.0e-3_wp)
   call check_rotor('ALPHA', 1.0e-2_wp)
   call check_rotor('CONSERVING', 1.0e-2_wp)
   call check_trains()
   call check_impact('ADAMS')
   call check_impact('RADAU')
   call check_impact('CONSERVING')
   call check_refusal('verification/impact.inp', 'max(t - 1, 0)', 'step(t - 1)', [character(64) :: &
      & "driver 'motor' jumps by 0.841", 'at t = 1', 'smoothstep'])
   call check_refusal('../input/spin_up.inp', 'FUNCTIONS=7, STRAIN FUNCTIONS=2', &
      & 'GEOMETRIC=LINEAR, BENDING MODES=1, ELEMENTS=200, SUPPORT=CLAMPED-FREE', [character(64) :: "beam 'beam' deflects", &
      & 'it diverges', 'above its first frequency 3.8', 'Use GEOMETRIC=EXACT or K_G'])
   call finish()

contains

   !> Angle and speed of the rotor against the integral of its torque.
   subroutine check_rotor(integrator, most)
      character(*), intent(in) :: integrator
      real(wp), intent(in) :: most
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: t(:), angle(:), spin(:), balance(:)
      real(wp), parameter :: inertia = 0.5_wp
      integer :: i
      call run_changed('verification/breaks.inp', trim(results), ['INTEGRATOR=ADAMS'], ['INTEGRATOR='//integrator], reader)
      call reader%read_time(t, error)
      allocate (angle, source=channel(reader, 'angle_rotor'))
      allocate (spin, source=channel(reader, 'spin_rotor'))
      allocate (balance, source=channel(reader, 'balance'))
      do i = 1, size(t)
         call check_close(spin(i), (after(t(i), 0.3_wp, 1) - 2*after(t(i), 0.7_wp, 1) + after(t(i), 1.1_wp, 2)/2)/inertia, most, &
            & integrator//': speed of the rotor')
         call check_close(angle(i), (after(t(i), 0.3_wp, 2)/2 - after(t(i), 0.7_wp, 2) + after(t(i), 1.1_wp, 3)/6)/inertia, most, &
            & integrator//': angle of the rotor')
      end do
      call check_close(maxval(abs(balance)), 0.0_wp, max(most, 1.0e-3_wp), integrator//': balance of energy and work')
      call reader%close()
   end subroutine check_rotor

   !> A free mass under trains of pulses that steps could go over: its speed is the integral of the law, by the rule of midpoints.
   subroutine check_trains()
      character(10), parameter :: integrators(4) = [character(10) :: 'AUTO', 'RADAU', 'ALPHA', 'CONSERVING']
      integer, parameter :: points = 2000000
      real(wp), parameter :: end = 10.0_wp
      real(wp) :: t, sums(4)
      integer :: i
      sums = 0.0_wp
      do i = 1, points
         t = (i - 0.5_wp)*end/points
         sums = sums + [exp(20*(sin(60*t) - 1)), max(0.0_wp, sin(400*t)), abs(sin(400*t)), merge(1.0_wp, 0.0_wp, sin(700*t) >= 0)]
      end do
      sums = sums*end/points
      do i = 1, size(integrators)
         call check_train(trim(integrators(i)), 'exp(20*(sin(60*t) - 1))', sums(1))
         call check_train(trim(integrators(i)), 'max(0, sin(400*t))', sums(2))
         call check_train(trim(integrators(i)), 'abs(sin(400*t))', sums(3))
         call check_train(trim(integrators(i)), 'step(sin(700*t))', sums(4))
      end do
      ! More breaks than are looked for
      call check_train('ADAMS', 'step(sin(3000*t))', -1.0_wp)
   end subroutine check_trains

   subroutine check_train(integrator, law, speed)
      character(*), intent(in) :: integrator, law
      !> At the end; below zero: a warning is wanted
      real(wp), intent(in) :: speed
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp), allocatable :: v(:)
      call run_text('*RIGID BODY, NAME=m, MASS=1, INERTIA=1'//newline//'*FORCE, NAME=f, POINT=m.origin'//newline//' '//law// &
         & ', 0'//newline//'*DYNAMICS, END=10, OUTPUTS=100, INTEGRATOR='//integrator//newline//'*OUTPUT'//newline// &
         & ' v = vx(m.origin)'//newline, trim(results), report, error)
      call check_no_error(error, law)
      if (speed < 0.0_wp) then
         call check(index(report, "the law of 'f' changes its formula too often") > 0, law//': told'//report)
         return
      end if
      call reader%open(trim(results), error)
      allocate (v, source=channel(reader, 'v'))
      call check_close(v(size(v)), speed, merge(5.0e-3_wp, 5.0e-4_wp, any(integrator == ['ALPHA     ', 'CONSERVING']))*speed, &
         & integrator//': '//law)
      call reader%close()
   end subroutine check_train

   !> (t - t0)^power from t0 on.
   pure real(wp) function after(t, t0, power)
      real(wp), intent(in) :: t, t0
      integer, intent(in) :: power
      after = max(t - t0, 0.0_wp)**power
   end function after

   !> The elbow is struck: the bob turns as if hit at its end, and the energy that this takes is work of the driver.
   subroutine check_impact(integrator)
      character(*), intent(in) :: integrator
      type(history_reader_type) :: reader
      real(wp), allocatable :: spin(:), balance(:)
      real(wp) :: expected
      call run_changed('verification/impact.inp', trim(results), ['INTEGRATOR=ADAMS'], ['INTEGRATOR='//integrator], reader)
      allocate (spin, source=channel(reader, 'spin_bob'))
      allocate (balance, source=channel(reader, 'balance'))
      ! Mass 1, centre at 0.5, inertia 0.1: (I + m c^2) w = -m c v, the elbow moving across the bob with v = 1
      expected = -0.5_wp/(0.1_wp + 0.25_wp)
      call check_close(spin(10), 0.0_wp, 1.0e-14_wp, integrator//': at rest before the impact')
      call check_close(spin(11), expected, 1.0e-12_wp, integrator//': speed right after the impact')
      call check_close(maxval(abs(balance)), 0.0_wp, 1.0e-5_wp, integrator//': balance of energy and work')
      call reader%close()
   end subroutine check_impact

   !> A run that is refused on its way, and what it says.
   subroutine check_refusal(path, old, new, said)
      character(*), intent(in) :: path, old, new, said(:)
      type(error_type), allocatable :: error
      type(history_reader_type) :: reader
      character(:), allocatable :: report
      real(wp), allocatable :: t(:)
      integer :: i
      call change_deck(path, trim(results)//'.inp', [old], [new])
      call run_deck(trim(results)//'.inp', trim(results), .true., .true., report, error)
      call check(allocated(error), path//' with '//new//' is refused')
      if (.not. allocated(error)) return
      do i = 1, size(said)
         call check(index(error%message, trim(said(i))) > 0, trim(said(i))//' in: '//error%message)
      end do
      deallocate (error)
      call reader%open(trim(results), error)
      call check(.not. allocated(error), path//': the results can be read')
      if (allocated(error)) return
      call check(.not. reader%complete, path//': the results are marked incomplete')
      call reader%read_time(t, error)
      call check(size(t) > 5, path//': what was computed is kept')
      call reader%close()
   end subroutine check_refusal

end program test_events
