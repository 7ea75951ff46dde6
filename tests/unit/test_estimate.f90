!> The estimate of errors: its arithmetic, its table and warnings, and a run with it. How far it is from true errors, the
!> verification error_estimate shows. Files are made in the folder that the environment variable TMPDIR names, or in /tmp.
program test_estimate
   use hdf5, only: hid_t, h5dopen_f, h5dclose_f
   use h5ds, only: h5dsget_num_scales_f, h5dsis_attached_f
   use limber_base_kinds, only: wp, long
   use limber_base_error, only: error_type
   use limber_base_text, only: newline
   use limber_commands_diff, only: compare_histories, tolerance_type
   use limber_scene_channel_errors, only: envelope, magnitude, shrinkage, widening, unknown_ratio
   use limber_analysis_error_estimate, only: estimate_type, make_estimate, round_off, varied
   use limber_analysis_estimate_report, only: estimate_table, estimate_warning, record_estimate
   use limber_commands_export, only: export_history
   use limber_analysis_provenance, only: open_history
   use limber_commands_run, only: run_deck
   use limber_scene_first_scene, only: read_scene
   use limber_scene_scene, only: scene_type
   use limber_integrator_bound_steps, only: bound_steps_type
   use limber_model_model, only: dynamics_type
   use limber_output_hdf5, only: close_file, open_file
   use limber_output_hdf5_read, only: read_attribute
   use limber_output_history, only: history_type
   use limber_output_history_reader, only: history_reader_type
   use limber_output_sample_sink, only: memory_type
   use testing, only: check, check_close, check_no_error, check_text, finish, make_folder
   implicit none
   character(:), allocatable :: folder

   call make_folder('estimate', folder)
   call test_arithmetic()
   call test_varied()
   call test_round_off()
   call test_texts()
   call test_run()
   call test_zero()
   call test_failed_companion()
   call test_tight()
   call execute_command_line('rm -rf '//folder)
   deallocate (folder)
   call finish()

contains

   !> Writes a pendulum with three channels, the last of which is constant but for errors.
   subroutine write_deck(name, dynamics, accuracy)
      character(*), intent(in) :: name, dynamics, accuracy
      integer :: unit
      open (newunit=unit, file=folder//'/'//name, action='write', status='replace')
      write (unit, '(a)') '*RIGID BODY, NAME=arm, MASS=1, INERTIA=0.1, CENTRE X=0.5', '*JOINT, NAME=hinge, TYPE=REVOLUTE', &
         & ' arm, ground.origin', '*TORQUE, NAME=motor, BODY=arm', ' 0.5*sin(t)', '*GRAVITY', '*DYNAMICS, END=2, OUTPUTS=40, '// &
         & dynamics, accuracy, '*OUTPUT', ' angle(arm), two = 2', &
         & ' energy = kinetic_energy(system) + potential_energy(system) - work(system)'
      close (unit)
   end subroutine write_deck

   subroutine test_arithmetic()
      real(wp) :: nothing(3)
      call check(all(abs(envelope([1.0_wp, 0.0_wp, 0.0_wp, -3.0_wp, 0.0_wp, 0.0_wp], 1) &
         & - [1.0_wp, 1.0_wp, 3.0_wp, 3.0_wp, 3.0_wp, 0.0_wp]) <= 0.0_wp), 'envelope')
      call check(size(envelope(nothing(:0), 2)) == 0, 'envelope of nothing')
      call check_close(magnitude([1.0_wp, -4.0_wp]), 4.0_wp, 0.0_wp, 'magnitude')
      call check_close(magnitude([0.0_wp, 0.0_wp]), 1.0_wp, 0.0_wp, 'magnitude of zero')
      call check_close(shrinkage([3.0_wp, -4.0_wp], [30.0_wp, 40.0_wp]), 0.1_wp, 1.0e-15_wp, 'shrinkage')
      nothing = 0.0_wp
      call check_close(shrinkage(nothing, nothing), 0.0_wp, 0.0_wp, 'shrinkage of nothing')
      call check(shrinkage([1.0_wp], nothing) > 1.0e100_wp, 'growth from nothing')
      call check_close(widening(0.0_wp), 1.0_wp, 0.0_wp, 'widening: a perfect companion')
      call check_close(widening(0.5_wp), 2.0_wp, 0.0_wp, 'widening: half the error')
      call check_close(widening(0.9_wp), 4.0_wp, 0.0_wp, 'widening: hardly better')
      call check_close(widening(30.0_wp), 4.0_wp, 0.0_wp, 'widening: worse')
      call check_close(widening(unknown_ratio), 2.0_wp, 0.0_wp, 'widening: not known')
   end subroutine test_arithmetic

   subroutine test_varied()
      type(dynamics_type) :: dynamics, other
      dynamics%integrator = 'RADAU'
      dynamics%end = 3.0_wp
      dynamics%maximum_step = 0.1_wp
      dynamics%maximum_steps = 300000000
      other = varied(dynamics, 0.125_wp)
      call check_text(other%integrator, 'RADAU', 'varied: integrator')
      call check_close(other%tolerance, 0.125e-6_wp, 1.0e-20_wp, 'varied: tolerance')
      call check_close(other%maximum_step, 0.05_wp, 1.0e-15_wp, 'varied: largest step')
      call check_close(other%initial_step, 0.0_wp, 0.0_wp, 'varied: first step is still chosen')
      call check_close(other%end, 3.0_wp, 0.0_wp, 'varied: end')
      call check(other%maximum_steps == 2000000000, 'varied: number of steps')
   end subroutine test_varied

   !> Energy less work: the terms count, not their sum, and the work once for each step.
   subroutine test_round_off()
      type(scene_type) :: scene
      type(error_type), allocatable :: error
      real(wp) :: quantities(3, 3), floors(3), sizes(3), none(3)
      call write_deck('plain.inp', 'TOLERANCE=1e-6', '*ACCURACY')
      call read_scene(folder//'/plain.inp', scene, error)
      call check_no_error(error, 'plain deck')
      quantities(:, 1) = [1.0_wp, -1.0_wp, 0.0_wp]
      quantities(:, 2) = [5.0_wp, -1.0_wp, 4.0_wp]
      quantities(:, 3) = [1.0_wp, -1.0_wp, 0.0_wp]
      none = 0.0_wp
      call round_off(scene%system%model%channels(3), quantities, none, 1000_long, floors, sizes)
      call check(all(abs(sizes - [1.0_wp, 5.0_wp, 1.0_wp]) <= 1.0e-8_wp), 'round-off: size of the terms')
      call check(all(abs(floors/epsilon(1.0_wp) - [8.0_wp, 2040.0_wp, 2040.0_wp]) <= 1.0e-5_wp), 'round-off: floors')
      call round_off(scene%system%model%channels(2), quantities(:0, :), none(:0), 1000_long, floors, sizes)
      call check(all(abs(floors/epsilon(1.0_wp) - 8.0_wp) <= 1.0e-12_wp), 'round-off of a constant')
      call round_off(scene%system%model%channels(1), quantities(3:3, :)/1000, [1.0_wp], 1000_long, floors, sizes)
      call check(all(abs(sizes - 1.0_wp) <= 1.0e-8_wp) .and. floors(1) > 0.9e-14_wp .and. floors(2) < 1.1e-14_wp, &
         & 'round-off of an angle near zero')
   end subroutine test_round_off

   subroutine test_texts()
      type(scene_type) :: scene
      type(estimate_type) :: estimate
      type(memory_type) :: samples
      type(error_type), allocatable :: error
      call read_scene(folder//'/plain.inp', scene, error)
      associate (channels => scene%system%model%channels)
         call samples%start(3, 2, 1.0e6_wp)
         call samples%append(0.0_wp, [-3.0_wp, 2.0_wp, 0.0_wp], error)
         call samples%append(1.0_wp, [1.0_wp/3, 2.0_wp, 0.0_wp], error)
         estimate%reason = ''
         allocate (estimate%values(3, 2), estimate%ratio(3), estimate%stuck(3), estimate%alarming(3), estimate%zero(3))
         estimate%values = 0.0_wp
         estimate%values(1, 2) = 0.00234_wp
         estimate%values(3, 1) = 1.0e-9_wp
         estimate%ratio = 0.1_wp
         estimate%stuck = .false.
         estimate%alarming = .false.
         estimate%zero = .false.
         estimate%tolerance = 1.0e-6_wp
         estimate%companion = 1.0e-7_wp
         estimate%check = 1.0e-5_wp
         estimate%cpu = 0.25_wp
         estimate%factor = 2.34_wp
         call check_text(estimate_warning(estimate, channels), '', 'no warning')
         estimate%stuck([1, 3]) = .true.
         call check_text(estimate_warning(estimate, channels), '', 'no warning of what is no matter beside the tolerance')
         estimate%alarming([1, 3]) = .true.
         call check_text(estimate_table(estimate, channels, samples), &
            & '   estimated errors of the time integration, from runs at TOLERANCE=1e-7 and 1e-5, 0.25 s CPU or 2.3 times the'// &
            & ' run itself:'//newline// &
            & '      channel        largest   at the end        error     relative'//newline// &
            & '      angle_arm            3     0.333333       0.0023       7.8e-4  does not shrink'//newline// &
            & '      two                  2            2            0            0'//newline// &
            & '      energy               0            0         1e-9         1e-9  does not shrink'//newline// &
            & '      not in them: what modes, elements and k_G elements leave out, which limber study shows', 'table')
         call check_text(estimate_warning(estimate, channels), 'warning: the errors do not shrink from TOLERANCE=1e-5 to 1e-7:'// &
            & ' angle_arm, energy; their estimates are 4 times the difference of two runs and may be too small; give a smaller'// &
            & ' TOLERANCE'//newline, 'warning')
         estimate%reason = 'given up'
         call check_text(estimate_table(estimate, channels, samples), '', 'no table')
         call check_text(estimate_warning(estimate, channels), 'warning: no estimate of the errors: the run at TOLERANCE=1e-7'// &
            & ' that it takes has failed: given up'//newline, 'warning of a failed companion')
      end associate
   end subroutine test_texts

   !> A run with estimates: the results are the same to the bit, and what the file says of them can be found.
   subroutine test_run()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp), allocatable :: values(:, :), wrong(:, :)
      real(wp) :: number
      logical :: same
      call write_deck('with.inp', 'TOLERANCE=1e-5', '*ACCURACY, ESTIMATE=YES')
      call write_deck('without.inp', 'TOLERANCE=1e-5', '*ACCURACY')
      call run_deck(folder//'/with.inp', folder//'/with.h5', .false., .true., report, error)
      call check_no_error(error, 'run with estimates')
      call check(index(report, 'estimated errors') > 0 .and. index(report, 'warning') == 0, 'report with estimates')
      call run_deck(folder//'/without.inp', folder//'/without.h5', .false., .true., report, error)
      call check_no_error(error, 'run without')
      call check(index(report, 'estimated') == 0, 'report without estimates')
      call compare_histories(folder//'/with.h5', folder//'/without.h5', tolerance_type(0.0_wp, 0.0_wp, 0.0_wp), report, same, error)
      call check(same .and. index(report, '3 channels, 41 samples') > 0, 'the same to the bit')
      call compare_histories(folder//'/without.h5', folder//'/with.h5', tolerance_type(0.0_wp, 0.0_wp, 0.0_wp), report, same, error)
      call check(same .and. index(report, 'not in the reference') == 0, 'the same to the bit, the other way')
      call reader%open(folder//'/without.h5', error)
      call check(size(reader%estimates) == 0, 'no estimates')
      call reader%close()
      call reader%open(folder//'/with.h5', error)
      call check_no_error(error, 'open with estimates')
      call check(reader%complete .and. reader%status == 'finished', 'complete with estimates')
      call check(size(reader%channels) == 3 .and. size(reader%estimates) == 3, 'an estimate for each channel')
      call check_text(reader%estimates(1)%name//' '//reader%estimates(1)%units, 'angle_arm_error rad', 'name and unit')
      call reader%read_channel('energy', values, error)
      call reader%read_channel('energy_error', wrong, error)
      call check(all(wrong > 0.0_wp) .and. maxval(wrong) < 1.0e-2_wp, 'estimates of the energy are positive')
      call check(maxval(wrong) > maxval(abs(values - values(1, 1))) .and. maxval(wrong) < 5*maxval(abs(values - values(1, 1))), &
         & 'the energy is as wrong as estimated')
      call reader%read_statistic('companion_tolerance', number, error, '/error_estimate')
      call check_close(number, 1.0e-6_wp, 1.0e-20_wp, 'tolerance of the companion')
      call reader%read_statistic('cpu_seconds', number, error, '/error_estimate')
      call check(.not. allocated(error) .and. number > 0.0_wp, 'cost')
      call reader%close()
      call check_file()
      call check_header('with.h5', '# time [s]  angle_arm [rad]  two [1]  energy [J]  angle_arm_error [rad]  two_error [1]'// &
         & '  energy_error [J]')
      call check_header('without.h5', '# time [s]  angle_arm [rad]  two [1]  energy [J]')
   end subroutine test_run

   !> A bead on a rod that a torque turns: the force of the joint along the rod is zero but for round-off of that across it,
   !> whatever it is multiplied by, and its errors do not shrink; no tolerance helps. One that is small beside it is no zero.
   subroutine test_zero()
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      integer :: unit
      open (newunit=unit, file=folder//'/zero.inp', action='write', status='replace')
      write (unit, '(a)') '*RIGID BODY, NAME=rod, MASS=1, INERTIA=0.3', '*POINT MASS, NAME=bead, MASS=0.5, X=0.5', &
         & '*JOINT, NAME=hinge, TYPE=REVOLUTE', ' rod.origin, ground.origin', '*JOINT, NAME=wire, TYPE=POINT ON LINE', &
         & ' bead, rod.origin', '*SPRING, NAME=s, STIFFNESS=60, LENGTH=0.5', ' bead, ground.origin', &
         & '*TORQUE, NAME=motor, BODY=rod', ' 0.5*sin(3*t)', '*GRAVITY', '*DYNAMICS, END=3, OUTPUTS=200, TOLERANCE=1e-6', &
         & '*ACCURACY, ESTIMATE=YES', '*OUTPUT', ' along = force_1(wire), tiny = 1e-6*force_1(wire), across = force_2(wire)', &
         & ' little = 1e-6*force_2(wire)'
      close (unit)
      call run_deck(folder//'/zero.inp', folder//'/zero.h5', .false., .true., report, error)
      call check_no_error(error, 'bead')
      call check(index(report, 'warning') == 0, 'no alarm about round-off: '//report)
      call check(is_zero(report, 'along') .and. is_zero(report, 'tiny'), 'zero within round-off: '//report)
      call check(.not. (is_zero(report, 'across') .or. is_zero(report, 'little')), 'no zero: '//report)
   end subroutine test_zero

   !> Whether the line of a channel in the table says that it is zero.
   pure logical function is_zero(report, name)
      character(*), intent(in) :: report, name
      integer :: first
      first = index(report, newline//'      '//name//' ') + 1
      is_zero = index(report(first:first + index(report(first:), newline)), 'zero within round-off') > 0
   end function is_zero

   !> Attributes and scales as other programs see them.
   subroutine check_file()
      type(error_type), allocatable :: error
      character(:), allocatable :: text
      integer(hid_t) :: file, estimate, time
      integer :: status, scales
      logical :: attached
      call open_file(folder//'/with.h5', file, error)
      call read_attribute(file, '/channels/energy', 'error_estimate', text, error)
      call check_no_error(error, 'attribute of the channel')
      call check_text(text, '/error_estimate/energy', 'path of the estimate')
      call read_attribute(file, '/error_estimate/energy', 'units', text, error)
      call check_text(text, 'J', 'unit of the estimate')
      call read_attribute(file, '/error_estimate/energy', 'long_name', text, error)
      call check_text(text, 'estimated absolute error of the time integration of energy', 'long name of the estimate')
      call read_attribute(file, '/error_estimate', 'status', text, error)
      call check_text(text, 'made', 'status of the estimates')
      call h5dopen_f(file, '/error_estimate/energy', estimate, status)
      call h5dopen_f(file, '/time', time, status)
      call h5dsget_num_scales_f(estimate, 1, scales, status)
      call h5dsis_attached_f(estimate, time, 1, attached, status)
      call check(scales == 1 .and. attached, 'time is the scale of the estimate')
      call h5dclose_f(estimate, status)
      call h5dclose_f(time, status)
      call close_file(folder//'/with.h5', file, error)
   end subroutine check_file

   !> First line of what is exported.
   subroutine check_header(name, expected)
      character(*), intent(in) :: name, expected
      type(error_type), allocatable :: error
      character(8) :: none(0)
      character(400) :: line
      integer :: unit
      open (newunit=unit, status='scratch', recl=1000)
      call export_history(folder//'/'//name, none, unit, error)
      call check_no_error(error, name//': export')
      rewind (unit)
      read (unit, '(a)') line
      close (unit)
      call check_text(trim(line), expected, name//': columns')
   end subroutine check_header

   !> A companion that is given up leaves a reason and no datasets.
   subroutine test_failed_companion()
      type(scene_type) :: scene
      type(estimate_type) :: estimate
      type(memory_type) :: samples
      type(bound_steps_type) :: taken
      type(history_type) :: history
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      call read_scene(folder//'/with.inp', scene, error)
      call check_no_error(error, 'deck with estimates')
      ! So that it may take less than no evaluation; counted work, for the result must not depend on the machine
      call make_estimate(scene, samples, taken, 100_long, -1000000_long, 1.0_wp, .true., estimate)
      call check(index(estimate%reason, 'given up after ') == 1 .and. index(estimate%reason, ' evaluations at t = ') > 0, &
         & 'companion that is given up: '//estimate%reason)
      call check(size(scene%system%model%channels) == 3, 'the scene has its channels again')
      call check_close(scene%system%model%dynamics%tolerance, 1.0e-5_wp, 0.0_wp, 'the scene has its tolerance again')
      call open_history(scene, folder//'/failed.h5', .false., history, error)
      call record_estimate(estimate, scene%system%model%channels, history, error)
      call check_no_error(error, 'record of a failed companion')
      call history%finish(.true., 'finished', error)
      call reader%open(folder//'/failed.h5', error)
      call check_no_error(error, 'file of a failed companion')
      call check(size(reader%estimates) == 0, 'file of a failed companion: no estimates')
      call reader%close()
   end subroutine test_failed_companion

   !> Where no smaller tolerance is left, the companion has a larger one.
   subroutine test_tight()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      real(wp), allocatable :: wrong(:, :)
      real(wp) :: number
      call write_deck('tight.inp', 'TOLERANCE=1e-13', '*ACCURACY, ESTIMATE=YES')
      call run_deck(folder//'/tight.inp', folder//'/tight.h5', .false., .true., report, error)
      call check_no_error(error, 'tight run')
      call reader%open(folder//'/tight.h5', error)
      call reader%read_statistic('companion_tolerance', number, error, '/error_estimate')
      call check_close(number, 1.0e-12_wp, 1.0e-20_wp, 'tight run: tolerance of the companion')
      call reader%read_channel('angle_arm_error', wrong, error)
      call check(maxval(wrong) > 1.0e-15_wp .and. maxval(wrong) < 1.0e-9_wp, 'tight run: estimate')
      call reader%close()
   end subroutine test_tight

end program test_estimate
