!> Columns and comparison of results files: the exact text of `limber export` and `limber diff`.
program test_export
   use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_quiet_nan, ieee_value
   use limber_commands_diff, only: compare_histories, compare_values, difference_type, tolerance_type
   use limber_commands_export, only: export_history
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_output_history, only: history_type
   use testing, only: check, check_close, check_no_error, check_text, finish, make_folder
   implicit none
   character(:), allocatable :: folder
   character(*), parameter :: nl = new_line('a')
   real(wp), parameter :: ramp(4) = [0.0_wp, 1.0_wp, 2.0_wp, 4.0_wp]

   call make_folder('export', folder)
   call test_columns()
   call test_export_errors()
   call test_kernel()
   call test_same()
   call test_different()
   call test_missing_and_extra()
   call test_shapes()
   call test_nothing()
   call execute_command_line('rm -rf '//folder)
   deallocate (folder)
   call finish()

contains

   !> A history with one channel of width 1 and perhaps a second of width 2.
   subroutine make(name, time, first_name, first, second, complete, units)
      character(*), intent(in) :: name, first_name
      real(wp), intent(in) :: time(:), first(:)
      real(wp), intent(in), optional :: second(:, :)
      logical, intent(in), optional :: complete
      character(*), intent(in), optional :: units
      type(history_type) :: history
      type(error_type), allocatable :: error
      character(8) :: unit_name
      logical :: whole
      integer :: i
      unit_name = 'rad'
      if (present(units)) unit_name = units
      whole = .true.
      if (present(complete)) whole = complete
      call history%create(folder//'/'//name, .true., '0.1.0', error)
      call history%define_time('s', error)
      call history%define_channel(first_name, 1, trim(unit_name), 'first', error)
      if (present(second)) call history%define_channel('tip', size(second, 1), 'm', 'second', error)
      do i = 1, size(time)
         if (present(second)) then
            call history%append(time(i), [first(i), second(:, i)], error)
         else
            call history%append(time(i), [first(i)], error)
         end if
      end do
      call history%finish(whole, trim(merge('finished', 'stopped ', whole)), error)
      call check_no_error(error, 'make '//name)
   end subroutine make

   !> What is exported, as one text.
   subroutine exported(name, names, text, error)
      character(*), intent(in) :: name, names(:)
      character(:), allocatable, intent(out) :: text
      type(error_type), allocatable, intent(out) :: error
      character(400) :: line
      integer :: unit, status
      open (newunit=unit, status='scratch')
      call export_history(folder//'/'//name, names, unit, error)
      rewind (unit)
      text = ''
      do
         read (unit, '(a)', iostat=status) line
         if (status /= 0) exit
         text = text//trim(line)//nl
      end do
      close (unit)
   end subroutine exported

   subroutine test_columns()
      character(:), allocatable :: text
      type(error_type), allocatable :: error
      character(8) :: none(0)
      call make('columns.h5', [0.0_wp, 0.1_wp], 'angle', [1.0e-100_wp, ieee_value(1.0_wp, ieee_quiet_nan)], &
         & reshape([1.0_wp, -2.0_wp, 3.0_wp, -4.0e100_wp], [2, 2]))
      call exported('columns.h5', none, text, error)
      call check_no_error(error, 'all columns')
      call check_text(text, '# time [s]  angle [rad]  tip[1] [m]  tip[2] [m]'//nl// &
         & ' 0.0000000000000000E+000  1.0000000000000000E-100  1.0000000000000000E+000 -2.0000000000000000E+000'//nl// &
         & ' 1.0000000000000001E-001                      NaN  3.0000000000000000E+000 -4.0000000000000001E+100'//nl, &
         & 'all columns')
      call exported('columns.h5', ['tip'], text, error)
      call check_no_error(error, 'one channel')
      call check_text(text, '# time [s]  tip[1] [m]  tip[2] [m]'//nl// &
         & ' 0.0000000000000000E+000  1.0000000000000000E+000 -2.0000000000000000E+000'//nl// &
         & ' 1.0000000000000001E-001  3.0000000000000000E+000 -4.0000000000000001E+100'//nl, 'one channel')
      call make('empty.h5', ramp(:0), 'angle', ramp(:0))
      call exported('empty.h5', none, text, error)
      call check_no_error(error, 'no sample')
      call check_text(text, '# time [s]  angle [rad]'//nl, 'no sample')
   end subroutine test_columns

   subroutine test_export_errors()
      character(:), allocatable :: text
      type(error_type), allocatable :: error
      character(8) :: none(0)
      call exported('columns.h5', ['tip  ', 'angel'], text, error)
      call check(allocated(error), 'unknown channel: error')
      if (allocated(error)) call check_text(error%message, folder//"/columns.h5 has no channel 'angel'; did you mean "// &
         & "'angle'?"//nl//'its channels: angle, tip', 'unknown channel')
      call check_text(text, '', 'unknown channel: nothing written')
      call exported('none.h5', none, text, error)
      call check(allocated(error), 'no file: error')
      if (allocated(error)) call check_text(error%message, folder//'/none.h5 does not exist', 'no file')
   end subroutine test_export_errors

   !> Tolerances, each at its edge.
   subroutine test_kernel()
      type(difference_type) :: difference
      real(wp) :: reference(1, 4), values(1, 4)
      reference(1, :) = ramp
      difference = compare_values(reference, reference, tolerance_type(0.0_wp, 0.0_wp, 0.0_wp))
      call check(difference%beyond == 0 .and. difference%not_finite == 0, 'equal to the bit, no tolerance')
      call check_close(difference%range, 4.0_wp, 0.0_wp, 'range')
      values = reference
      values(1, 3) = 2.25_wp
      difference = compare_values(values, reference, tolerance_type(0.125_wp, 0.0_wp, 0.0_wp))
      call check(difference%beyond == 0, 'relative tolerance, just within')
      difference = compare_values(values, reference, tolerance_type(0.124_wp, 0.0_wp, 0.0_wp))
      call check(difference%beyond == 1 .and. difference%worst == 3, 'relative tolerance, just beyond')
      difference = compare_values(values, reference, tolerance_type(0.0_wp, 0.0625_wp, 0.0_wp))
      call check(difference%beyond == 0, 'tolerance of range, just within')
      difference = compare_values(values, reference, tolerance_type(0.0_wp, 0.0624_wp, 0.0_wp))
      call check(difference%beyond == 1, 'tolerance of range, just beyond')
      difference = compare_values(values, reference, tolerance_type(0.0_wp, 0.0_wp, 0.25_wp))
      call check(difference%beyond == 0, 'absolute tolerance, just within')
      difference = compare_values(values, reference, tolerance_type(0.0_wp, 0.0_wp, 0.24_wp))
      call check(difference%beyond == 1, 'absolute tolerance, just beyond')
      values(1, 2) = ieee_value(1.0_wp, ieee_positive_inf)
      reference(1, 2) = ieee_value(1.0_wp, ieee_positive_inf)
      difference = compare_values(values, reference, tolerance_type(1.0_wp, 1.0_wp, 1.0_wp))
      call check(difference%not_finite == 1 .and. difference%worst == 2, 'the same infinity in both still fails')
   end subroutine test_kernel

   subroutine test_same()
      character(:), allocatable :: report
      type(error_type), allocatable :: error
      logical :: same
      call make('a.h5', ramp, 'angle', ramp, reshape([ramp, 2*ramp], [2, 4]))
      call make('b.h5', ramp, 'angle', ramp + [0.0_wp, 0.0_wp, 1.0e-6_wp, 0.0_wp], reshape([ramp, 2*ramp], [2, 4]))
      call compare_histories(folder//'/a.h5', folder//'/b.h5', tolerance_type(), report, same, error)
      call check_no_error(error, 'same')
      call check(same, 'same within the tolerance')
      call check_text(report, &
         & 'channel    max |a-b|   of range     at time  verdict'//nl// &
         & 'time      0.000E+000  0.00E+000  0.0000E+00   same'//nl// &
         & 'angle     1.000E-006  2.50E-007  2.0000E+00   same'//nl// &
         & 'tip       0.000E+000  0.00E+000  0.0000E+00   same'//nl// &
         & 'the same: time and 2 channels, 4 samples (rtol 1e-6, atol 1e-6 of range)', 'report of equal files')
      call compare_histories(folder//'/a.h5', folder//'/a.h5', tolerance_type(0.0_wp, 0.0_wp), report, same, error)
      call check_no_error(error, 'a file with itself')
      call check(same, 'a file with itself')
   end subroutine test_same

   subroutine test_different()
      character(:), allocatable :: report
      type(error_type), allocatable :: error
      real(wp) :: broken(4)
      logical :: same
      call compare_histories(folder//'/b.h5', folder//'/a.h5', tolerance_type(1.0e-9_wp, 1.0e-9_wp), report, same, error)
      call check_no_error(error, 'different')
      call check(.not. same, 'different beyond the tolerance')
      call check_text(report, &
         & 'channel    max |a-b|   of range     at time  verdict'//nl// &
         & 'time      0.000E+000  0.00E+000  0.0000E+00   same'//nl// &
         & 'angle     1.000E-006  2.50E-007  2.0000E+00   FAILS: 1 of 4 beyond the tolerance'//nl// &
         & 'tip       0.000E+000  0.00E+000  0.0000E+00   same'//nl// &
         & 'different: 1 of 3 (time and channels) fail (rtol 1e-9, atol 1e-9 of range)', 'report of different files')
      broken = ramp
      broken(2) = ieee_value(1.0_wp, ieee_quiet_nan)
      call make('nan.h5', ramp, 'angle', broken)
      call compare_histories(folder//'/nan.h5', folder//'/nan.h5', tolerance_type(1.0_wp, 1.0_wp), report, same, error)
      call check_no_error(error, 'NaN')
      call check(.not. same, 'NaN in both fails')
      call check(index(report, 'angle     0.000E+000  0.00E+000  1.0000E+00   FAILS: 1 of 4 not finite') > 0, &
         & 'NaN in the report'//nl//report)
      call make('plain.h5', ramp, 'angle', ramp)
      call compare_histories(folder//'/nan.h5', folder//'/plain.h5', tolerance_type(1.0_wp, 1.0_wp), report, same, error)
      call check(.not. same, 'NaN in A fails')
      call compare_histories(folder//'/plain.h5', folder//'/nan.h5', tolerance_type(1.0_wp, 1.0_wp), report, same, error)
      call check(.not. same, 'NaN in B fails')
      call make('late.h5', ramp + 1.0_wp, 'angle', ramp)
      call compare_histories(folder//'/late.h5', folder//'/plain.h5', tolerance_type(), report, same, error)
      call check(.not. same, 'other times fail')
      call check(index(report, nl//'time      1.000E+000  2.50E-001  0.0000E+00   FAILS: 4 of 4 beyond the tolerance') > 0, &
         & 'other times in the report'//nl//report)
   end subroutine test_different

   subroutine test_missing_and_extra()
      character(:), allocatable :: report
      type(error_type), allocatable :: error
      logical :: same
      call compare_histories(folder//'/plain.h5', folder//'/a.h5', tolerance_type(), report, same, error)
      call check_no_error(error, 'missing')
      call check(.not. same, 'a missing channel fails')
      call check(index(report, nl//'tip'//repeat(' ', 43)//'FAILS: missing'//nl) > 0, 'missing in the report'//nl//report)
      call compare_histories(folder//'/a.h5', folder//'/plain.h5', tolerance_type(), report, same, error)
      call check(same, 'an extra channel does not fail')
      call check(index(report, nl//'tip'//repeat(' ', 43)//'not in the reference'//nl) > 0, 'extra in the report'//nl//report)
      call compare_histories(folder//'/plain.h5', folder//'/gone.h5', tolerance_type(), report, same, error)
      call check(allocated(error) .and. .not. same, 'a missing reference is an error')
   end subroutine test_missing_and_extra

   subroutine test_shapes()
      character(:), allocatable :: report
      type(error_type), allocatable :: error
      logical :: same
      call make('short.h5', ramp(:3), 'angle', ramp(:3), complete=.false.)
      call compare_histories(folder//'/short.h5', folder//'/plain.h5', tolerance_type(), report, same, error)
      call check_no_error(error, 'short')
      call check(.not. same, 'fewer samples fail')
      call check(index(report, nl//'angle'//repeat(' ', 41)//'FAILS: shape (3, 1), not (4, 1)'//nl) > 0, &
         & 'shape in the report'//nl//report)
      call check(index(report, nl//folder//'/short.h5 is not of a complete run: stopped'//nl) > 0, &
         & 'incomplete run in the report'//nl//report)
      call make('wide.h5', ramp, 'angle', ramp, reshape([ramp, ramp, ramp], [3, 4]))
      call compare_histories(folder//'/wide.h5', folder//'/a.h5', tolerance_type(), report, same, error)
      call check(.not. same, 'another width fails')
      call check(index(report, nl//'tip'//repeat(' ', 43)//'FAILS: shape (4, 3), not (4, 2)'//nl) > 0, &
         & 'width in the report'//nl//report)
      call make('degrees.h5', ramp, 'angle', ramp, units='deg')
      call compare_histories(folder//'/degrees.h5', folder//'/plain.h5', tolerance_type(), report, same, error)
      call check(.not. same, 'another unit fails')
      call check(index(report, nl//'angle'//repeat(' ', 41)//'FAILS: unit deg, not rad'//nl) > 0, &
         & 'unit in the report'//nl//report)
   end subroutine test_shapes

   !> A comparison of nothing does not pass.
   subroutine test_nothing()
      character(:), allocatable :: report
      type(error_type), allocatable :: error
      logical :: same
      call compare_histories(folder//'/empty.h5', folder//'/empty.h5', tolerance_type(), report, same, error)
      call check_no_error(error, 'nothing')
      call check(.not. same, 'no samples fail')
      call check(index(report, 'different: the reference has 1 channels and 0 samples, which is nothing to compare with') &
         & > 0, 'no samples in the report'//nl//report)
   end subroutine test_nothing

end program test_export
