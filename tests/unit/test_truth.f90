!> The truth of a search: what it may err itself counts against every setting.
program test_truth
   use limber_base_kinds, only: wp
   use limber_accuracy_fidelity_levels, only: level_type
   use limber_accuracy_reference_run, only: reference_run_type, error_against, largest_difference, rest_of
   use testing, only: check, check_close, finish
   implicit none
   type(level_type) :: rungs(1)
   call test_errors()
   call test_refinement()
   call test_parts()
   call finish()

contains

   !> The worst channel counts, relative to its own scale, with what the truth may err there.
   subroutine test_errors()
      type(reference_run_type) :: truth
      real(wp) :: values(3, 4)
      truth%scale = [10.0_wp, 1.0_wp]
      truth%of_terms = [.true., .true.]
      call truth%take(rungs, 1.0e-2_wp, reshape([0, 0, 1, 1, 2, 0, 3, 1]*1.0_wp, [2, 4]), [0.0_wp, 0.0_wp])
      call check(truth%known, 'it is known')
      call check_close(truth%tolerance, 1.0e-2_wp, 0.0_wp, 'tolerance')
      values = 7.0_wp
      values(:2, :) = truth%values
      call check_close(error_against(truth, values), 0.0_wp, 0.0_wp, 'no error: others do not count')
      values(1, 3) = values(1, 3) + 0.5_wp
      values(2, 2) = values(2, 2) - 0.03_wp
      call check_close(error_against(truth, values), 0.05_wp, 1.0e-14_wp, 'the first channel by 0.5 of 10')
      truth%rest = [0.0_wp, 0.04_wp]
      call check_close(error_against(truth, values), 0.07_wp, 1.0e-14_wp, 'the second by 0.03 and by what the truth errs')
      call check_close(sum(abs(largest_difference(values, truth%values) - [0.5_wp, 0.03_wp])), 0.0_wp, 1.0e-14_wp, 'differences')
   end subroutine test_errors

   !> A finer run takes its place.
   subroutine test_refinement()
      type(reference_run_type) :: truth
      real(wp) :: first(1, 2), second(1, 2)
      first = 1.0_wp
      second = reshape([2.0_wp, 3.0_wp], [1, 2])
      truth%scale = [1.0_wp]
      truth%of_terms = [.true.]
      call truth%take(rungs, 1.0e-2_wp, first, [0.1_wp])
      call truth%take(rungs, 1.0e-3_wp, second, [0.05_wp])
      call check_close(maxval(abs(truth%values - second)), 0.0_wp, 0.0_wp, 'it takes the place')
      call check_close(error_against(truth, first), 2.05_wp, 1.0e-15_wp, 'and its error')
   end subroutine test_refinement

   !> Its parts are measured one by one: a run of a smaller tolerance, what higher levels change, what the strain changes. Their
   !> errors
   !> add up, to 0.01 at least.
   subroutine test_parts()
      type(reference_run_type) :: truth
      truth%scale = [2.0_wp]
      truth%of_terms = [.true.]
      truth%finest = reshape([1.0_wp, 2.0_wp], [1, 2])
      truth%of_time = [0.001_wp]
      call truth%combine(rungs, 1.0e-3_wp, 0.01_wp)
      call check_close(truth%rest(1), 0.02_wp, 1.0e-15_wp, 'at least 0.01 of the scale')
      truth%change = reshape([0.1_wp, -0.1_wp], [1, 2])
      truth%of_model = [0.03_wp]
      truth%of_strain = [0.04_wp]
      call truth%combine(rungs, 1.0e-3_wp, 0.01_wp)
      call check_close(sum(abs(truth%values(1, :) - [1.1_wp, 1.9_wp])), 0.0_wp, 1.0e-14_wp, 'what higher levels change is added')
      call check_close(truth%rest(1), 0.071_wp, 1.0e-14_wp, 'and the errors')
      call check_close(rest_of(0.2_wp, 1.0_wp), 0.1875_wp, 1.0e-14_wp, 'a fifth of the tolerance leaves 0.75*0.2/0.8')
   end subroutine test_parts

end program test_truth
