!> The estimated error of every channel (*ACCURACY, ESTIMATE=YES) against the true one, for three scenes, two integrators and
!> three tolerances. The truth is a run of much smaller tolerance that one of the other integrator confirms; of the squeezer's
!> angles it is a solution in quadruple precision; and energy less work is what it was at the start.
!> Usage, in tests/: test_error_estimate RESULT_FILE
program test_error_estimate
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use limber_scene_channel_errors, only: magnitude
   use limber_accuracy_study_runs, only: median
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_changed, run_text, channel, read_columns
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   !> A scene
   type :: case_type
      !> Deck, its words on tolerance and integrator, and what stays of them
      character(60) :: path, old, outputs
      !> Channels to add
      character(240) :: more
   end type case_type

   character(1), parameter :: nl = new_line('a')
   character(5), parameter :: integrators(2) = ['ADAMS', 'RADAU'], tolerances(3) = [character(5) :: '1e-4', '1e-6', '1e-8']
   type(case_type) :: scene
   character(256) :: results
   !> Samples of a run, its estimated errors, and the truth (samples, channels)
   real(wp), allocatable :: values(:, :), estimated(:, :), truth(:, :)
   !> CPU time of the estimate in units of that of the run
   real(wp) :: cost

   call get_command_argument(1, results)
   print '(a)', 'Estimated over true error: median of all samples, median factor between them, least and greatest of the', &
      & 'largest of each channel that has an error; CPU time of the estimate over that of the run'
   scene = case_type('../input/slider_crank_exact.inp', 'TOLERANCE=1e-8, OUTPUTS=838', 'OUTPUTS=838', nl// &
      & ' energy = kinetic_energy(system) + potential_energy(system) - work(system)'//nl// &
      & ' speed = vy(rod.middle), acceleration = ax(slider), pin_force = force_x(crank-pin)')
   call make_truth('ADAMS', '1e-11', 'RADAU', '3e-12')
   call check_runs()
   scene = case_type('../input/spin_up.inp', 'TOLERANCE=1e-8, OUTPUTS=1000, INTEGRATOR=ADAMS', 'OUTPUTS=1000', '')
   call make_truth('RADAU', '1e-11', 'ADAMS', '1e-10')
   call check_runs()
   scene = case_type('../input/andrews_squeezer.inp', 'TOLERANCE=1e-8, OUTPUTS=300, INTEGRATOR=ADAMS', 'OUTPUTS=300', '')
   call make_truth('RADAU', '1e-11', 'ADAMS', '1e-12')
   call take_angles()
   call check_runs()
   deallocate (values, estimated, truth)
   call check_bound_steps()
   call finish()

contains

   !> Runs the scene; takes its samples and their estimated errors.
   subroutine run_scene(integrator, tolerance, estimate)
      character(*), intent(in) :: integrator, tolerance, estimate
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(300) :: old(2), new(2)
      integer :: i
      old(1) = scene%old
      old(2) = '*OUTPUT'
      new(1) = trim(scene%outputs)//', TOLERANCE='//trim(tolerance)//', INTEGRATOR='//integrator
      new(2) = '*ACCURACY, ESTIMATE='//estimate//nl//'*OUTPUT'//scene%more
      call run_changed(trim(scene%path), trim(results), old, new, reader)
      if (allocated(values)) deallocate (values, estimated)
      allocate (values(reader%samples, size(reader%channels)), estimated(reader%samples, size(reader%estimates)))
      call check(size(estimated, 2) == merge(size(values, 2), 0, estimate == 'YES'), trim(scene%path)//': estimates')
      do i = 1, size(values, 2)
         values(:, i) = channel(reader, reader%channels(i)%name)
         if (size(estimated, 2) == size(values, 2)) estimated(:, i) = channel(reader, reader%estimates(i)%name)
         ! Energy less work: each run has its own constant
         if (allocated(truth) .and. index(reader%channels(i)%long_name, '- work') > 0) truth(:, i) = values(1, i)
      end do
      if (estimate == 'YES') call reader%read_statistic('cpu_factor', cost, error, '/error_estimate')
      call check_no_error(error, trim(scene%path)//': cost')
      call reader%close()
   end subroutine run_scene

   !> Takes a run for the truth, and sees how far another one is from it.
   subroutine make_truth(integrator, tolerance, other, other_tolerance)
      character(*), intent(in) :: integrator, tolerance, other, other_tolerance
      real(wp) :: apart
      integer :: i
      if (allocated(truth)) deallocate (truth)
      call run_scene(integrator, tolerance, 'NO')
      allocate (truth, source=values)
      call run_scene(other, other_tolerance, 'NO')
      apart = 0.0_wp
      do i = 1, size(truth, 2)
         apart = max(apart, maxval(abs(values(:, i) - truth(:, i)))/max(1.0e-3_wp, magnitude(truth(:, i))))
      end do
      print '(4a)', trim(scene%path), ': the truth is confirmed to ', as_text(apart, 2), ' of the largest value of each channel'
      call check_close(apart, 0.0_wp, 1.0e-5_wp, trim(scene%path)//': the truth is confirmed')
   end subroutine make_truth

   !> The squeezer's angles in quadruple precision.
   subroutine take_angles()
      real(wp) :: exact(8, 301)
      call read_columns('reference/andrews_squeezer.csv', exact)
      call check_close(maxval(abs(truth(:, 1:7) - transpose(exact(2:, :)))), 0.0_wp, 1.0e-9_wp, 'angles of the squeezer')
      truth(:, 1:7) = transpose(exact(2:, :))
   end subroutine take_angles

   subroutine check_runs()
      integer :: i, k
      do i = 1, size(integrators)
         do k = 1, size(tolerances)
            call run_scene(integrators(i), tolerances(k), 'YES')
            if (size(estimated, 2) == size(truth, 2)) &
               & call check_estimate(trim(scene%path)//' '//integrators(i)//' '//trim(tolerances(k)))
         end do
      end do
   end subroutine check_runs

   !> Compares estimated and true errors.
   subroutine check_estimate(title)
      character(*), intent(in) :: title
      real(wp), allocatable :: ratios(:), wrong(:)
      real(wp) :: largest(size(truth, 2)), middle
      integer :: i
      allocate (ratios(0), wrong(size(truth, 1)))
      do i = 1, size(truth, 2)
         wrong = abs(values(:, i) - truth(:, i))
         call check(all(estimated(2:, i) > 0.0_wp), title//': all estimates are positive')
         largest(i) = maxval(estimated(:, i))/max(maxval(wrong), 1.0e-300_wp)
         ratios = [ratios, pack(estimated(:, i), wrong > 0.0_wp)/pack(wrong, wrong > 0.0_wp)]
      end do
      middle = median(ratios)
      print '(2x,a,t48,4f8.2,f8.1)', title, middle, median(max(ratios, 1/max(ratios, tiny(cost)))), minval(largest), &
         & maxval(largest, mask=largest < 1.0e3_wp), cost
      call check(middle >= 0.2_wp .and. middle <= 5.0_wp, title//': median '//as_text(middle, 3)//' within a factor of 5')
      call check(minval(largest) >= 0.1_wp, title//': least ratio of largest errors '//as_text(minval(largest), 3))
   end subroutine check_estimate

   !> Steps that other than the tolerance binds are the same in runs of other tolerances: the samples of CONSERVING, the corners
   !> of a table that hardly pulls, the turns of a fast wheel beside. Under all of them x = cos(10 t).
   subroutine check_bound_steps()
      character(10), parameter :: names(4) = [character(10) :: 'ADAMS', 'RADAU', 'ALPHA', 'CONSERVING']
      character(:), allocatable :: corners
      integer :: i
      corners = '*TABLE, NAME=corners'//nl
      do i = 0, 250
         corners = corners//' '//as_text(0.02_wp*i)//', '//as_text(1.0e-6_wp*modulo(i, 2))//nl
      end do
      corners = corners//'*FORCE, NAME=f, POINT=m'//nl//' 0, corners(t)'//nl
      call check_bound('CONSERVING', 'samples', '', 'END=100, OUTPUTS=20000')
      do i = 1, size(names)
         call check_bound(trim(names(i)), 'corners', corners, 'END=5, OUTPUTS=100')
         call check_bound(trim(names(i)), 'longest steps', '', 'END=5, OUTPUTS=100, MAXIMUM STEP=4e-3')
         if (i > 1) call check_bound(trim(names(i)), 'turns', '*RIGID BODY, NAME=wheel, MASS=1, INERTIA=1, SPIN=300'//nl// &
            & '*JOINT, NAME=hub, TYPE=REVOLUTE'//nl//' wheel, ground.origin'//nl, 'END=5, OUTPUTS=100')
      end do
   end subroutine check_bound_steps

   !> The error that is told must be 0.5 to 3 times the true one.
   subroutine check_bound(integrator, by, blocks, options)
      character(*), intent(in) :: integrator
      !> What binds the steps: in words, what the deck has for it, and options of the step
      character(*), intent(in) :: by, blocks, options
      type(error_type), allocatable :: error
      type(history_reader_type) :: reader
      character(:), allocatable :: report, title
      real(wp), allocatable :: x(:), t(:), told(:)
      real(wp) :: off
      title = 'steps of '//integrator//' that '//by//' bind: '
      call run_text('*POINT MASS, NAME=m, MASS=1, X=1'//nl//'*BUSHING, NAME=b, STIFFNESS X=100, STIFFNESS Y=100'//nl// &
         & ' m, ground.origin'//nl//blocks//'*ACCURACY, ESTIMATE=YES'//nl//'*DYNAMICS, TOLERANCE=1e-2, INTEGRATOR='//integrator// &
         & ', '//options//nl//'*OUTPUT'//nl//' x = x(m)'//nl, trim(results), report, error)
      call check_no_error(error, title)
      if (allocated(error)) return
      call reader%open(trim(results), error)
      call reader%read_time(t, error)
      x = channel(reader, 'x')
      told = channel(reader, reader%estimates(1)%name)
      call reader%close()
      off = maxval(abs(x - cos(10*t)))
      call check(maxval(told) > 0.5_wp*off .and. maxval(told) < 3*off, title//'told '//as_text(maxval(told), 3)//' of '// &
         & as_text(off, 3)//': '//report)
   end subroutine check_bound

end program test_error_estimate
