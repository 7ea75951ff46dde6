!> Decisions of the search for a target. From measured errors and costs to the next run; no run is made here. Floor: accuracy.
!> Equations: doc/theory, part 7.
module limber_accuracy_search_decisions
   use limber_base_kinds, only: wp
   use limber_accuracy_search_thresholds, only: clearly, coarse_enough, companion_bounds, companion_part, each_level, far, &
      & follows_strain, helped, largest_tolerance, least_verified, looser, most_effort, most_levels, room, saves_much, &
      & shows_strain, stale, stalled, time_little, time_matters, time_too_large, usual_power
   implicit none
   private
   public :: evidence_type, next_trial, is_complete, levels_up, looser_tolerance, coarser_tolerance, is_worth, strain_tolerance, &
      & smaller_tolerance

   !> What comes next: measurements of the candidate, four other candidates, two ends
   integer, parameter, public :: measure_time = 1, measure_model = 2, measure_strain = 3, tighten = 4, loosen = 5, refine = 6, &
      & add_strain = 7, keep = 8, give_up = 9, measure_finely = 10, measure_together = 11, &
      & measure_further = 12

   !> What is known of a candidate. Errors are relative to the channels
   type :: evidence_type
      real(wp) :: target = 0.0_wp, tolerance = 0.0_wp
      !> Whether beams are to be verified; whether their strain is
      logical :: has_beams = .false., asks_strain = .false.
      !> Whether the strain of beams without any is looked at that nothing is expected of
      logical :: looks_strain = .false.
      !> What was measured
      logical :: time_known = .false., model_known = .false., strain_known = .false.
      !> Errors of the integration, of the functions, by the strain, and of all that is known together
      real(wp) :: of_time = 0.0_wp, of_model = 0.0_wp, of_strain = 0.0_wp, error = 0.0_wp
      !> Tolerance at which the functions were measured; their error at the levels before, zero: there were none
      real(wp) :: model_tolerance = 0.0_wp, before = 0.0_wp
      !> Error of the integration before the tolerance was made smaller; zero: it was not
      real(wp) :: time_before = 0.0_wp
      !> Whether the functions can be measured at a smaller tolerance
      logical :: can_surer = .false.
      !> Whether functions and strain can be measured together at a moderate cost
      logical :: can_join = .false.
      !> How often they were: first at the tolerance of runs with strain, then at that of the companion run
      integer :: joined = 0
      !> Whether they can be measured by still higher levels, and were
      logical :: can_further = .false., furthered = .false.
      !> Largest difference from the reference, without the error of that
      real(wp) :: difference = 0.0_wp
      !> Counted work of the run with strain, and of the companion run
      real(wp) :: strain_work = 0.0_wp, companion_work = 0.0_wp
      !> What the deck leaves open and the levels allow
      logical :: can_tighten = .false., can_loosen = .false., can_refine = .false., can_strain = .false.
   end type evidence_type

contains

   !> The next trial. The integration comes first: functions that are compared at a loose tolerance differ by its errors. Behind a
   !> refinement the functions come first. Strain costs most and comes last.
   pure integer function next_trial(e) result(trial)
      type(evidence_type), intent(in) :: e
      logical :: climbs
      climbs = e%has_beams .and. e%before > 0.0_wp .and. .not. e%time_known
      if (climbs .and. .not. e%model_known) then
         trial = measure_model
      else if (climbs .and. e%of_model > clearly*e%target .and. e%can_refine .and. .not. stalls(e)) then
         trial = refine
      else if (.not. e%time_known) then
         trial = measure_time
      else if (e%can_loosen .and. e%of_time < time_little*e%target) then
         trial = loosen
      else if (e%of_time > e%target .and. e%can_tighten .and. .not. hides_time(e)) then
         trial = tighten
      else if (e%has_beams .and. (.not. e%model_known .or. e%model_tolerance > stale*e%tolerance)) then
         trial = measure_model
      else if (e%error > e%target) then
         trial = mending(e)
      else if (e%of_time > time_too_large*e%target .and. e%can_tighten .and. .not. hides_time(e)) then
         trial = tighten
      else if (e%has_beams .and. (e%asks_strain .or. e%looks_strain) .and. .not. e%strain_known) then
         trial = measure_strain
      else
         trial = keep
      end if
   end function next_trial

   !> What mends the largest part of an error. An error of the functions may be one of the integration of the higher levels: the
   !> tolerance of the companion run shows it.
   pure integer function mending(e) result(trial)
      type(evidence_type), intent(in) :: e
      if (e%can_join .and. max(e%of_time, e%of_model, e%of_strain) <= e%target) then
         trial = measure_together
      else if (e%strain_known .and. e%can_strain .and. e%of_strain >= max(e%of_model, e%of_time)) then
         trial = add_strain
      else if (e%can_tighten .and. e%of_time > max(e%of_model, time_matters*e%target)) then
         trial = tighten
      else if (e%has_beams .and. e%model_tolerance > 1.1_wp*e%tolerance) then
         trial = measure_model
      else if (e%has_beams .and. e%can_surer .and. e%of_model < huge(1.0_wp) .and. &
         & (e%of_model <= clearly*e%target .or. stalls(e))) then
         trial = measure_finely
      else if (e%has_beams .and. e%can_further .and. e%difference <= room*e%target) then
         trial = measure_further
      else if (stalls(e) .and. e%can_strain .and. .not. e%strain_known) then
         trial = measure_strain
      else if (e%can_refine .and. e%has_beams) then
         trial = refine
      else if (e%can_strain .and. e%has_beams) then
         trial = add_strain
      else if (e%can_tighten .and. e%of_time > time_matters*e%target) then
         trial = tighten
      else
         trial = give_up
      end if
   end function mending

   !> Whether a smaller tolerance has not helped as the functions lack what a channel shows.
   pure logical function hides_time(e)
      type(evidence_type), intent(in) :: e
      hides_time = e%time_before > 0.0_wp .and. e%of_time > helped*e%time_before .and. e%can_refine .and. .not. &
         & (e%model_known .and. e%of_model < e%of_time)
   end function hides_time

   !> Whether more functions have not helped.
   pure logical function stalls(e)
      type(evidence_type), intent(in) :: e
      stalls = e%model_known .and. e%before > 0.0_wp .and. e%of_model > stalled*e%before
   end function stalls

   !> Whether integration and functions are measured.
   pure logical function is_complete(e)
      type(evidence_type), intent(in) :: e
      is_complete = e%time_known .and. (e%model_known .or. .not. e%has_beams)
   end function is_complete

   !> Levels by which the beams are refined.
   pure integer function levels_up(error, target) result(levels)
      !> Of the functions, and what is asked for
      real(wp), intent(in) :: error, target
      real(wp), parameter :: unknown = 1.0e3_wp
      levels = 1
      if (error > target .and. error < unknown) levels = min(most_levels, 1 + int(log(error/target)/log(each_level)))
   end function levels_up

   !> A larger tolerance where the integration errs by very little: that which the run verifies, or one far above.
   pure real(wp) function looser_tolerance(e) result(tolerance)
      type(evidence_type), intent(in) :: e
      real(wp) :: factor
      factor = (time_little*e%target/max(e%of_time, tiny(1.0_wp)**0.3_wp))**(1/usual_power)
      if (factor < far) factor = 1/companion_part
      tolerance = min(largest_tolerance, factor*e%tolerance)
   end function looser_tolerance

   !> A larger tolerance for a setting that keeps the target, by what the rest of the target allows, eq. (7.96); zero: none.
   pure real(wp) function coarser_tolerance(target, error, of_time, tolerance, ceiling) result(larger)
      !> What is asked for, error of the run, its part of the integration
      real(wp), intent(in) :: target, error, of_time
      !> Of the run; one that errs by too much
      real(wp), intent(in) :: tolerance, ceiling
      larger = tolerance*min(looser(2), (1 + max(0.0_wp, coarse_enough*target - error)/max(of_time, tiny(1.0_wp)))**(1/usual_power))
      larger = min(ceiling, larger)
      if (larger < looser(1)*tolerance .and. larger < 0.99_wp*largest_tolerance) larger = 0.0_wp
      if (larger < 1.01_wp*tolerance) larger = 0.0_wp
   end function coarser_tolerance

   !> Whether a coarser setting is worth a run: the whole search stays within its promise, or it saves much.
   pure logical function is_worth(spent, best, expected)
      !> Work of the search so far, of the run that it would leave, and of the coarser one as far as is known
      real(wp), intent(in) :: spent, best, expected
      is_worth = spent + expected <= most_effort*expected .or. expected <= saves_much*best
   end function is_worth

   !> Tolerance of a run with strain: a loose one steps over axial vibrations.
   pure real(wp) function strain_tolerance(tolerance, companion, forced) result(strained)
      !> Of the candidate, and of its companion run
      real(wp), intent(in) :: tolerance, companion
      !> Whether a beam has a large axial force
      logical, intent(in) :: forced
      strained = tolerance
      if (forced .and. tolerance > follows_strain) strained = min(companion, follows_strain)
      if (.not. forced .and. tolerance > shows_strain) strained = companion
   end function strain_tolerance

   !> The next smaller tolerance: that of the companion run, or one between.
   pure real(wp) function smaller_tolerance(tolerance, companion) result(smaller)
      real(wp), intent(in) :: tolerance, companion
      smaller = companion
      if (companion < 0.1_wp*tolerance .or. companion > companion_bounds(2)*tolerance) smaller = companion_part*tolerance
      smaller = max(least_verified, smaller)
   end function smaller_tolerance

end module limber_accuracy_search_decisions
