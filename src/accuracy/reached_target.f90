!> Result of a search. The setting that was reached, its samples, its verified errors and the way there. Floor: accuracy.
module limber_accuracy_reached_target
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, newline
   use limber_accuracy_advice, only: advice_type
   use limber_scene_channel_errors, only: envelope, unknown_ratio
   use limber_analysis_error_estimate, only: estimate_type
   use limber_scene_outcome, only: outcome_type
   use limber_accuracy_candidate, only: candidate_type
   use limber_accuracy_reference_run, only: reference_run_type, shown_type
   use limber_integrator_statistics, only: step_statistics_type
   use limber_output_sample_sink, only: memory_type
   implicit none
   private
   public :: reached_type, record_errors, say_why

   !> What a run towards a target leaves
   type :: reached_type
      !> As it was advised, with the rungs and the tolerance that were reached
      type(advice_type) :: advice
      !> Whether the verified error is within the target; if not, why
      logical :: done = .false.
      character(:), allocatable :: reason
      !> Where a signal has ended the search; not allocated if none came. If the target is kept all else is as it should be, only
      !> less might do; if not there are neither samples nor an outcome
      character(:), allocatable :: interruption
      !> Samples of the run that was verified, what it counted, and how it ended
      type(memory_type) :: samples
      type(step_statistics_type) :: statistics
      type(outcome_type), allocatable :: outcome
      !> Its estimated errors
      type(estimate_type) :: estimate
      !> Largest of them, and their parts by the integration and by the models, relative
      real(wp) :: error = 0.0_wp, of_time = 0.0_wp, of_model = 0.0_wp
      !> The channel and the time of each, for people: " in 'M0' at t = 0.013"; not allocated or empty: not known
      character(:), allocatable :: place, place_of_time, place_of_model
      !> What runs have shown of the integration
      type(shown_type) :: shown
      !> What the deck fixes of beams, and the error of that, relative; models that nothing verifies. Empty: there are none
      character(:), allocatable :: fixed, unverified
      !> Whether beams vibrate along themselves in ways that their functions of the strain do not follow; finer runs do not show it
      logical :: rings = .false.
      !> Whether a beam is rigid in the finest run too, as nothing is expected of its bending
      logical :: believed = .false.
      real(wp) :: of_fixed = 0.0_wp
      !> Number of runs, CPU seconds of all runs and their counted work
      integer :: runs = 0
      real(wp) :: cpu = 0.0_wp, work = 0.0_wp
      !> Whether the start without deflections sets off vibrations of its candidate
      logical :: is_struck = .false.
      !> Whether beams of it vibrate along themselves in ways that its functions do not follow
      logical :: is_ringing = .false.
      !> Whether a run was given up as the search had cost all that it may
      logical :: spent = .false.
      !> What was climbed, a line for each
      character(:), allocatable :: path
   end type reached_type

   !> Neighbours on each side that the envelope takes in
   integer, parameter :: reach = 2

contains

   !> Errors of the run at each sample.
   subroutine record_errors(truth, candidate, reached)
      type(reference_run_type), intent(in) :: truth
      type(candidate_type), intent(in) :: candidate
      type(reached_type), intent(inout) :: reached
      integer :: i, n
      associate (estimate => reached%estimate)
         n = size(truth%values, 2)
         if (n /= candidate%samples%samples) return
         if (allocated(estimate%values)) deallocate (estimate%values, estimate%ratio, estimate%stuck, estimate%alarming, &
            & estimate%zero, estimate%scale)
         allocate (estimate%values(size(truth%scale), n), estimate%ratio(size(truth%scale)))
         allocate (estimate%stuck(size(truth%scale)), estimate%alarming(size(truth%scale)), estimate%zero(size(truth%scale)))
         allocate (estimate%scale, source=truth%scale)
         do i = 1, size(truth%scale)
            estimate%values(i, :) = envelope(candidate%samples%values(i, :n) - truth%values(i, :), reach) + truth%rest(i)
         end do
         estimate%ratio = unknown_ratio
         estimate%without = reached%unverified
         estimate%stuck = .false.
         estimate%alarming = .false.
         estimate%zero = .false.
         estimate%tolerance = reached%advice%tolerance
         estimate%companion = truth%tolerance
         estimate%cpu = reached%cpu
         estimate%factor = reached%work/max(candidate%work, tiny(1.0_wp))
      end associate
   end subroutine record_errors

   !> Why a target is not kept.
   subroutine say_why(target, reached)
      real(wp), intent(in) :: target
      type(reached_type), intent(inout) :: reached
      if (reached%spent) then
         reached%reason = 'the search for TARGET='//as_text(target, 2)//' was given up after '//as_text(reached%runs)//' runs, '// &
            & as_text(reached%cpu, 2)//' s of CPU time: what it needs costs too much to be verified'
         if (reached%error > 0.0_wp .and. reached%error < 1.0e3_wp) reached%reason = reached%reason// &
            & '; the best setting that was verified errs by '//as_text(reached%error, 2)//reached%place
         reached%reason = reached%reason//'. Ask for less, for a shorter time, or give FUNCTIONS, TOLERANCE and INTEGRATOR'
      else if (reached%reason == '' .and. is_of_time(target, reached)) then
         reached%reason = time_words(target, reached)
      else if (reached%reason == '') then
         reached%reason = 'no fidelity level keeps TARGET='//as_text(target, 2)//': '
         if (reached%error < 1.0e3_wp) then
            reached%reason = reached%reason//'the error that the verification shows is '//as_text(reached%error, 2)//reached%place
         else
            reached%reason = reached%reason//'the run one level higher that is to verify it fails'
         end if
      end if
      if (reached%is_ringing) reached%reason = reached%reason//newline//'   Beams vibrate along themselves under sudden or fast'// &
         & ' loads, and the forces and accelerations asked for have that in them, which functions of the strain follow slowly:'// &
         & ' ask for less or a shorter time, damp them (*DAMPING), or let loads begin slowly'
      if (reached%is_struck) reached%reason = reached%reason//newline//'   The start without deflections sets off vibrations:'// &
         & ' *ASSEMBLY, INITIAL DEFLECTIONS=STATIC begins in balance'
      if (reached%fixed /= '' .and. reached%of_fixed <= 0.0_wp) reached%reason = reached%reason//newline// &
         & '   The deck fixes '//reached%fixed//': leave it open'
   end subroutine say_why

   !> Whether the integration alone keeps a run from the target.
   pure logical function is_of_time(target, reached)
      real(wp), intent(in) :: target
      type(reached_type), intent(in) :: reached
      is_of_time = reached%shown%pairs > 0 .and. reached%of_time > 0.5_wp*target .and. reached%of_model <= 0.5_wp*target
   end function is_of_time

   !> Why the integration does not keep a target, and what can be tried.
   function time_words(target, reached) result(text)
      real(wp), intent(in) :: target
      type(reached_type), intent(in) :: reached
      character(:), allocatable :: text
      !> Part of the error that is left when it does not shrink
      real(wp), parameter :: stays = 0.5_wp
      associate (shown => reached%shown)
         if (.not. reached%advice%open_tolerance) then
            text = 'TOLERANCE='//as_text(reached%advice%tolerance, 2)//', which the deck fixes, does not keep TARGET='// &
               & as_text(target, 2)//': the integration has an error of '//as_text(reached%of_time, 2)//reached%place_of_time// &
               & '; leave TOLERANCE open'
            return
         end if
         text = 'no tolerance keeps TARGET='//as_text(target, 2)//': the error of the integration '
         if (shown%of_time(2) > stays*shown%of_time(1)) then
            text = text//'does not shrink with TOLERANCE'
         else
            text = text//'shrinks too little with TOLERANCE'
         end if
         text = text//' (from '//as_text(shown%of_time(1), 2)//' at '//as_text(shown%tolerance(1), 2)//' to '// &
            & as_text(shown%of_time(2), 2)//' at '//as_text(shown%tolerance(2), 2)//reached%place_of_time//'); use another'// &
            & ' INTEGRATOR (AUTO, RADAU or ADAMS), and look at the laws for jumps and for what chance decides'
      end associate
   end function time_words

end module limber_accuracy_reached_target
