!> Decisions of a search for a target, without runs: from measured errors and costs to the next run.
program test_search
   use limber_base_kinds, only: wp
   use limber_accuracy_search_decisions, only: evidence_type, next_trial, is_complete, levels_up, looser_tolerance, &
      & coarser_tolerance, is_worth, strain_tolerance, smaller_tolerance, measure_time, measure_model, measure_strain, tighten, &
      & loosen, refine, add_strain, keep, give_up, measure_finely, measure_together, measure_further
   use testing, only: check, check_close, finish
   implicit none

   call test_order()
   call test_time()
   call test_model()
   call test_strain()
   call test_ends()
   call test_sizes()
   call test_cost()
   call finish()

contains

   !> A beam at a target of 1e-3 that leaves all open, with errors of the integration and of the functions.
   pure type(evidence_type) function known(of_time, of_model) result(e)
      !> Negative: not measured
      real(wp), intent(in) :: of_time, of_model
      e%target = 1.0e-3_wp
      e%tolerance = 1.0e-3_wp
      e%has_beams = .true.
      e%can_tighten = .true.
      e%can_refine = .true.
      e%can_strain = .true.
      e%time_known = of_time >= 0.0_wp
      e%model_known = of_model >= 0.0_wp
      e%of_time = max(0.0_wp, of_time)
      e%of_model = max(0.0_wp, of_model)
      e%model_tolerance = e%tolerance
      e%error = e%of_time + e%of_model
      e%difference = e%error
   end function known

   !> The cheap measurements come first.
   subroutine test_order()
      type(evidence_type) :: e
      call check(next_trial(known(-1.0_wp, -1.0_wp)) == measure_time, 'the integration first')
      call check(next_trial(known(3.0e-4_wp, -1.0_wp)) == measure_model, 'then the functions')
      e = known(3.0e-4_wp, 3.0e-4_wp)
      call check(next_trial(e) == keep .and. is_complete(e), 'that is all')
      e%asks_strain = .true.
      call check(next_trial(e) == measure_strain, 'strain is last')
      e%strain_known = .true.
      call check(next_trial(e) == keep, 'and only once')
      e = known(3.0e-4_wp, 3.0e-4_wp)
      e%looks_strain = .true.
      call check(next_trial(e) == measure_strain, 'nothing is kept without a look at it')
      e%strain_known = .true.
      call check(next_trial(e) == keep, 'once as well')
      e = known(3.0e-4_wp, -1.0_wp)
      e%has_beams = .false.
      call check(next_trial(e) == keep .and. is_complete(e), 'rigid bodies have no functions')
   end subroutine test_order

   !> Errors of the integration.
   subroutine test_time()
      type(evidence_type) :: e
      call check(next_trial(known(2.0e-3_wp, -1.0_wp)) == tighten, 'more than the target: before the functions')
      call check(next_trial(known(7.0e-4_wp, -1.0_wp)) == measure_model, 'less: after them')
      call check(next_trial(known(7.0e-4_wp, 1.0e-4_wp)) == tighten, 'but 0.6 of the target are too much')
      e = known(7.0e-4_wp, 1.0e-4_wp)
      e%can_tighten = .false.
      call check(next_trial(e) == keep, 'unless the deck gives the tolerance')
      e = known(2.0e-3_wp, -1.0_wp)
      e%time_before = 2.5e-3_wp
      call check(next_trial(e) == measure_model, 'a smaller tolerance has not helped: look at the functions')
      e = known(2.0e-5_wp, -1.0_wp)
      e%can_loosen = .true.
      call check(next_trial(e) == loosen, 'next to nothing: a larger tolerance')
   end subroutine test_time

   !> Errors of the functions.
   subroutine test_model()
      type(evidence_type) :: e
      call check(next_trial(known(1.0e-4_wp, 9.0e-3_wp)) == refine, 'far too large')
      e = known(1.0e-4_wp, 2.0e-3_wp)
      call check(next_trial(e) == refine, 'too large')
      e%can_surer = .true.
      call check(next_trial(e) == measure_finely, 'but that may be the integration of the higher levels')
      e%of_model = huge(1.0_wp)
      e%error = huge(1.0_wp)
      call check(next_trial(e) == refine, 'the run that was to verify has failed')
      e = known(3.0e-4_wp, 4.0e-4_wp)
      e%error = 1.1e-3_wp
      e%can_further = .true.
      call check(next_trial(e) == measure_further, 'only the doubt about the reference is too large')
      e = known(3.0e-4_wp, 3.0e-4_wp)
      e%model_tolerance = 30*e%tolerance
      call check(next_trial(e) == measure_model, 'measured at a tolerance that is far too loose')
      ! Behind a refinement
      e = known(-1.0_wp, -1.0_wp)
      e%before = 9.0e-3_wp
      call check(next_trial(e) == measure_model, 'behind a refinement the functions first')
      e = known(-1.0_wp, 5.0e-3_wp)
      e%before = 9.0e-3_wp
      call check(next_trial(e) == refine, 'and on, if they help')
      e%of_model = 8.0e-3_wp
      call check(next_trial(e) == measure_time, 'more functions have not helped: it may be the integration')
      e = known(1.0e-4_wp, 8.0e-3_wp)
      e%before = 9.0e-3_wp
      call check(next_trial(e) == measure_strain, 'or the strain')
   end subroutine test_model

   !> Errors by the strain.
   subroutine test_strain()
      type(evidence_type) :: e
      e = known(2.0e-4_wp, 2.0e-4_wp)
      e%asks_strain = .true.
      e%strain_known = .true.
      e%of_strain = 2.0e-3_wp
      e%error = 2.4e-3_wp
      call check(next_trial(e) == add_strain, 'the largest error is that of the strain')
      e%of_strain = 8.0e-4_wp
      e%error = 1.2e-3_wp
      e%can_join = .true.
      call check(next_trial(e) == measure_together, 'the sum of small errors may be too large')
      e%can_join = .false.
      call check(next_trial(e) == add_strain, 'if that costs too much: with strain')
   end subroutine test_strain

   !> Nothing is left.
   subroutine test_ends()
      type(evidence_type) :: e
      e = known(1.0e-5_wp, 2.0e-3_wp)
      e%can_refine = .false.
      call check(next_trial(e) == add_strain, 'no functions are left')
      e%can_strain = .false.
      call check(next_trial(e) == give_up, 'nothing is left that would help')
      e%of_time = 5.0e-4_wp
      call check(next_trial(e) == tighten, 'a smaller tolerance may')
      e%can_tighten = .false.
      call check(next_trial(e) == give_up, 'unless the deck gives it')
   end subroutine test_ends

   !> How far a step goes.
   subroutine test_sizes()
      type(evidence_type) :: e
      call check(levels_up(4.0e-3_wp, 1.0e-3_wp) == 1 .and. levels_up(9.0e-3_wp, 1.0e-3_wp) == 2 .and. &
         & levels_up(9.9e-1_wp, 1.0e-3_wp) == 3, 'a level divides an error by 8')
      call check(levels_up(huge(1.0_wp), 1.0e-3_wp) == 1, 'of an unknown error nothing is known')
      e = known(5.0e-5_wp, -1.0_wp)
      call check_close(looser_tolerance(e), 5.0e-3_wp, 1.0e-15_wp, 'five times larger, so that this run verifies the next')
      e%of_time = 1.0e-12_wp
      call check_close(looser_tolerance(e), 1.0e-2_wp, 1.0e-15_wp, 'at most 1e-2')
      call check_close(coarser_tolerance(1.0e-3_wp, 5.0e-4_wp, 4.0e-4_wp, 1.0e-4_wp, 1.0e-2_wp), 1.0e-4_wp*2**(1/0.6_wp), &
         & 1.0e-12_wp, 'the rest of 0.9 of the target is twice the error of the integration')
      call check(coarser_tolerance(1.0e-3_wp, 8.9e-4_wp, 4.0e-4_wp, 1.0e-4_wp, 1.0e-2_wp) <= 0.0_wp, 'no room')
      call check_close(coarser_tolerance(1.0e-3_wp, 1.0e-4_wp, 1.0e-6_wp, 1.0e-4_wp, 1.0e-2_wp), 1.0e-3_wp, 1.0e-12_wp, &
         & 'at most ten times')
      call check_close(smaller_tolerance(1.0e-3_wp, 2.0e-4_wp), 2.0e-4_wp, 1.0e-15_wp, 'the run that has verified')
      call check_close(smaller_tolerance(1.0e-2_wp, 1.0e-4_wp), 2.0e-3_wp, 1.0e-15_wp, 'not a hundredth at once')
      call check_close(strain_tolerance(1.0e-2_wp, 2.0e-3_wp, .false.), 2.0e-3_wp, 1.0e-15_wp, 'a loose run does not show strain')
      call check_close(strain_tolerance(1.0e-3_wp, 2.0e-4_wp, .false.), 1.0e-3_wp, 1.0e-15_wp, 'this one does')
      call check_close(strain_tolerance(1.0e-3_wp, 2.0e-4_wp, .true.), 1.0e-4_wp, 1.0e-15_wp, 'under a large axial force not')
   end subroutine test_sizes

   !> A coarser setting is tried if the search stays within 13 times the work of that, or it saves half.
   subroutine test_cost()
      call check(is_worth(100.0_wp, 10.0_wp, 9.0_wp), '109 for 9')
      call check(.not. is_worth(130.0_wp, 10.0_wp, 9.0_wp), '139 for 9')
      call check(is_worth(130.0_wp, 10.0_wp, 4.0_wp), 'less than half of 10')
   end subroutine test_cost

end program test_search
