!> Steps of the search for a target. They run what was decided: measurements of a candidate by companion runs, and other candidates.
!> Floor: accuracy. Equations: doc/theory, part 7.
module limber_accuracy_search_steps
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text, newline
   use limber_accuracy_advice, only: advice_type, check_rung, strained_rung, is_forced, rest_beyond, note_surprise, begin_bending, &
      & expected_error, cost_of
   use limber_accuracy_candidate, only: candidate_type, run_request_type, take_trial
   use limber_accuracy_fidelity_levels, only: level_type, richer, can_climb, same_rungs, with_one_strain, names_of
   use limber_accuracy_reached_target, only: reached_type
   use limber_accuracy_reference_run, only: reference_run_type, error_against, largest_difference, place_of, rest_of
   use limber_accuracy_run_pool, only: pool_type
   use limber_accuracy_search_decisions, only: evidence_type, levels_up, looser_tolerance, strain_tolerance, &
      & smaller_tolerance
   use limber_accuracy_search_thresholds, only: cheaper, companion_bounds, companion_part, doubt, follows_strain, &
      & joint_rest, largest_tolerance, least_patience, least_verified, look_factor, look_enough, look_first, look_margin, &
      & much_ringing, noticed, of_adams, patience_model, patience_next, patience_strain, patience_time, together
   implicit none
   private
   public :: target_search_type, first_run, next_run, time_step, model_step, strain_step, tighten_step, loosen_step, refine_step, &
      & joint_step, add_strain_step, look_again, weigh

   !> A search
   type :: target_search_type
      real(wp) :: target = 0.0_wp
      type(pool_type) :: pool
      type(reached_type) :: reached
      !> The run that is verified, its reference, and what is known of it
      type(candidate_type) :: candidate
      type(reference_run_type) :: reference
      type(evidence_type) :: evidence
      !> Whether the tolerance was made smaller
      logical :: tightened = .false.
   end type target_search_type

contains

   !> The first run. Scenes with beams take RADAU, and try what AUTO takes: ADAMS at the tolerance of rigid bodies, which it needs,
   !> stays if it costs much less.
   subroutine first_run(s, error)
      type(target_search_type), intent(inout) :: s
      !> The deck is wrong (status 2), or a signal asks for the end (status 4)
      type(error_type), allocatable, intent(out) :: error
      type(candidate_type) :: adams
      type(run_request_type) :: request
      type(advice_type) :: begun
      real(wp) :: tolerance
      logical :: both, bends
      begun = s%reached%advice
      bends = any(begun%rungs%step > 0)
      both = bends .and. begun%open_integrator .and. begun%open_tolerance
      call begin_bending(begun)
      call next_run(s, begun, huge(1.0_wp), error)
      if (allocated(error) .or. .not. bends .or. .not. begun%open_tolerance) return
      tolerance = min(begun%tolerance, of_adams*s%target)
      if (.not. (both .or. s%candidate%integrator == 'ADAMS' .and. tolerance < begun%tolerance)) return
      request = request_of(s, begun%rungs, tolerance, 'run with ADAMS')
      request%integrator = ''
      request%only = 'ADAMS'
      if (both .and. s%candidate%reason == '') then
         ! What verifies it must be for ADAMS as well
         request%rungs = higher_rungs(begun, 0)
         request%limit = 0.0_wp
         call s%pool%run(request, adams, error)
         if (allocated(error) .or. adams%integrator /= 'ADAMS') return
         request%rungs = begun%rungs
         request%limit = cheaper*s%candidate%work
      end if
      call s%pool%run(request, adams, error)
      if (allocated(error)) return
      if (adams%integrator /= 'ADAMS' .or. (both .and. adams%reason /= '')) return
      s%reached%advice%integrator = ''
      s%reached%advice%tolerance = tolerance
      call take_trial(adams, s%candidate)
   end subroutine first_run

   !> Runs the next candidate. What a signal ends at the first run is what there is.
   subroutine next_run(s, advice, limit, error)
      type(target_search_type), intent(inout) :: s
      !> With its rungs and tolerance
      type(advice_type), intent(in) :: advice
      real(wp), intent(in) :: limit
      type(error_type), allocatable, intent(out) :: error
      type(candidate_type) :: next
      type(run_request_type) :: request
      logical :: first
      integer :: i
      first = s%pool%runs == 0
      request = request_of(s, advice%rungs, advice%tolerance, 'run')
      request%integrator = advice%integrator
      request%limit = limit
      call s%pool%run(request, next, error)
      if (allocated(error) .and. .not. first) return
      s%reached%advice = advice
      do i = 1, size(advice%rungs)
         s%reached%advice%expected(i) = expected_error(advice%rungs(i), advice%probe%beams(i))
      end do
      call take_trial(next, s%candidate)
      s%evidence%time_known = .false.
      ! Vibrations along beams that their functions do not follow take more and more of them
      if (.not. allocated(error) .and. s%candidate%reason == '' .and. s%candidate%ringing <= much_ringing) &
         & call s%pool%allow(s%candidate%work)
   end subroutine next_run

   !> A run of the present integrator.
   type(run_request_type) function request_of(s, rungs, tolerance, label) result(request)
      type(target_search_type), intent(in) :: s
      type(level_type), intent(in) :: rungs(:)
      real(wp), intent(in) :: tolerance
      character(*), intent(in) :: label
      allocate (request%rungs, source=rungs)
      request%tolerance = tolerance
      request%integrator = s%reached%advice%integrator
      request%label = label
   end function request_of

   !> Measures the error of the integration by a companion run of a smaller tolerance, eq. (7.87). Where no smaller one is left, a
   !> larger one shows how far errors fall.
   subroutine time_step(s, error)
      type(target_search_type), intent(inout) :: s
      type(error_type), allocatable, intent(out) :: error
      type(candidate_type) :: finer
      type(run_request_type) :: request
      real(wp), allocatable :: away(:)
      real(wp) :: part, rest
      integer :: n, i, channels
      associate (advice => s%reached%advice, reached => s%reached, reference => s%reference, e => s%evidence)
         request = request_of(s, advice%rungs, companion_part*advice%tolerance, 'check of the integration')
         if (advice%tolerance <= 1.01_wp*least_verified) request%tolerance = advice%tolerance/companion_part
         request%wide = .not. allocated(reference%scale)
         if (any([(is_forced(advice, i) .and. advice%rungs(i)%stretches, i=1, size(advice%rungs))])) &
            & request%tolerance = min(request%tolerance, max(follows_strain, 0.01_wp*advice%tolerance))
         if (request%tolerance < advice%tolerance .and. .not. request%wide) request%tolerance = s%pool%kept_tolerance(request, &
            & [companion_bounds(1)*advice%tolerance, min(companion_bounds(2)*advice%tolerance, 2.05_wp*request%tolerance)])
         part = request%tolerance/advice%tolerance
         request%part = part
         request%limit = least_patience + patience_time*s%candidate%work
         call s%pool%run(request, finer, error)
         if (allocated(error)) return
         reached%estimate%companion = request%tolerance
         reached%estimate%of_model = .true.
         reached%estimate%reason = ''
         if (finer%reason /= '') then
            reached%reason = 'the check at TOLERANCE='//as_text(request%tolerance, 2)//' failed: '//finer%reason
            reached%estimate%reason = reached%reason
            return
         end if
         if (request%wide) reference%scale = finer%scale
         if (request%wide) reference%of_terms = finer%of_terms
         channels = size(reference%scale)
         n = s%candidate%samples%samples
         associate (fine => finer%samples%values(:channels, :n), run => s%candidate%samples%values(:channels, :n))
            rest = rest_of(min(part, 1/part), reached%shown%falling)
            away = largest_difference(fine, run)
            reference%of_time = rest*away
            if (part < 1.0_wp) reference%finest = fine
            if (part > 1.0_wp) reference%finest = run
            reference%tolerance = min(part, 1.0_wp)*advice%tolerance
            reached%of_time = maxval([0.0_wp, away*(1 + rest)/(1 + rest_of(companion_part, reached%shown%falling))/reference%scale])
            reached%place_of_time = place_of(fine, run, reference%scale, s%candidate%samples%times, s%candidate%names)
            call reached%shown%take(advice%rungs, advice%tolerance, reached%of_time, s%target, run, fine)
         end associate
         e%time_known = .true.
         e%of_time = reached%of_time
         e%companion_work = finer%work
      end associate
   end subroutine time_step

   !> Measures the error of the functions by a run of higher levels, eq. (7.88).
   subroutine model_step(s, finely, beyond, error)
      type(target_search_type), intent(inout) :: s
      !> Whether at the tolerance of the companion run; so too if the run fails
      logical, intent(in) :: finely
      !> Levels above those that verify otherwise
      integer, intent(in) :: beyond
      type(error_type), allocatable, intent(out) :: error
      type(level_type) :: rungs(size(s%reached%advice%rungs))
      real(wp), allocatable :: change(:, :)
      real(wp) :: patience
      associate (advice => s%reached%advice, reached => s%reached, reference => s%reference, e => s%evidence)
         rungs = higher_rungs(advice, beyond)
         reached%believed = any(rungs%step == 0)
         e%model_known = .true.
         e%furthered = beyond > 0
         e%model_tolerance = merge(reference%tolerance, advice%tolerance, finely)
         e%of_model = 0.0_wp
         reached%of_model = 0.0_wp
         reference%rungs = rungs
         if (allocated(reference%change)) deallocate (reference%change)
         if (same_rungs(rungs, advice%rungs)) return
         patience = merge(patience_strain, patience_model, any(rungs%step > 0 .and. advice%rungs%step == 0))
         call find_change(s, rungs, e%model_tolerance, 'check of ', patience, change, error)
         if (allocated(error)) return
         if (.not. allocated(change) .and. e%can_surer .and. .not. finely) then
            e%model_tolerance = reference%tolerance
            call find_change(s, rungs, e%model_tolerance, 'check of ', patience, change, error)
            if (allocated(error)) return
         end if
         if (allocated(change)) then
            call take_change(s, rungs, change, 0.0_wp)
            e%of_model = maxval([0.0_wp, maxval(abs(change), 2)/reference%scale])
            if (e%of_model - e%of_time > noticed*s%target) call note_surprise(advice, e%of_model - e%of_time)
            reached%place_of_model = place_of(change, 0.0_wp*change, reference%scale, s%candidate%samples%times, s%candidate%names)
         else
            e%of_model = huge(1.0_wp)
         end if
         reached%of_model = e%of_model
      end associate
   end subroutine model_step

   !> Measures what the strain changes by a run of the same functions, eq. (7.89): with all functions of the strain where it is
   !> expected to matter, else with one.
   subroutine strain_step(s, error)
      type(target_search_type), intent(inout) :: s
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: change(:, :)
      real(wp) :: margin
      associate (e => s%evidence)
         margin = 1.0_wp
         if (e%asks_strain) then
            call find_change(s, strained_rungs(s%reached%advice), tolerance_of_strain(s), 'strain of ', patience_strain, change, &
               & error, e%strain_work)
         else
            margin = look_margin
            call look_at_strain(s, change, error)
         end if
         if (allocated(error)) return
         e%strain_known = .true.
         e%of_strain = huge(1.0_wp)
         if (.not. allocated(change)) return
         s%reference%of_strain = margin*maxval(abs(change), 2)
         e%of_strain = maxval([0.0_wp, s%reference%of_strain/s%reference%scale])
      end associate
   end subroutine strain_step

   !> What one function of the strain changes. Runs at the tolerance of the candidate also differ by their steps: they are enough if
   !> even that is little, and are tried first where the companion run costs much more.
   subroutine look_at_strain(s, change, error)
      type(target_search_type), intent(inout) :: s
      real(wp), allocatable, intent(out) :: change(:, :)
      type(error_type), allocatable, intent(out) :: error
      type(level_type) :: rungs(size(s%reached%advice%rungs))
      rungs = with_one_strain(s%reached%advice%rungs)
      if (s%evidence%companion_work > look_first*s%candidate%work) then
         call find_change(s, rungs, s%reached%advice%tolerance, 'strain of ', patience_strain, change, error, &
            & s%evidence%strain_work)
         if (allocated(error)) return
         if (allocated(change)) then
            if (all(maxval(abs(change), 2) <= look_enough*s%target*s%reference%scale)) return
            deallocate (change)
         end if
      end if
      call find_change(s, rungs, s%reference%tolerance, 'strain of ', patience_strain, change, error, s%evidence%strain_work)
   end subroutine look_at_strain

   !> Measures functions and strain by one run, where their sum is too large, eq. (7.90).
   subroutine joint_step(s, error)
      type(target_search_type), intent(inout) :: s
      type(error_type), allocatable, intent(out) :: error
      type(advice_type) :: strained
      real(wp), allocatable :: change(:, :)
      real(wp) :: tolerance
      strained = s%reached%advice
      strained%rungs = strained_rungs(strained)
      strained%rungs = higher_rungs(strained, 0)
      tolerance = tolerance_of_strain(s)
      if (s%evidence%joined > 0) tolerance = s%reference%tolerance
      s%evidence%joined = s%evidence%joined + 1
      call find_change(s, strained%rungs, tolerance, 'check of ', patience_strain, change, error)
      if (allocated(error) .or. .not. allocated(change)) return
      call take_change(s, strained%rungs, change, joint_rest)
      s%reference%of_strain = 0.0_wp*s%reference%of_strain
   end subroutine joint_step

   !> Runs other models, and gives what they change: against the candidate at its tolerance, else against the companion run.
   subroutine find_change(s, rungs, tolerance, label, patience, change, error, work)
      type(target_search_type), intent(inout) :: s
      type(level_type), intent(in) :: rungs(:)
      real(wp), intent(in) :: tolerance
      character(*), intent(in) :: label
      !> Work over that of the candidate after which it is given up
      real(wp), intent(in) :: patience
      !> Change of the channels (channels, samples); not allocated: the run has failed
      real(wp), allocatable, intent(out) :: change(:, :)
      type(error_type), allocatable, intent(out) :: error
      !> Counted work of the run
      real(wp), intent(inout), optional :: work
      type(candidate_type) :: check
      type(run_request_type) :: request
      integer :: channels, n
      channels = size(s%reference%scale)
      n = s%candidate%samples%samples
      request = request_of(s, rungs, tolerance, label//names_of(rungs))
      request%limit = least_patience + patience*s%candidate%work
      call s%pool%run(request, check, error)
      if (allocated(error)) return
      if (present(work)) work = check%work
      if (check%reason /= '') return
      if (tolerance < 0.99_wp*s%reached%advice%tolerance) then
         allocate (change, source=check%samples%values(:channels, :n) - s%reference%finest)
      else
         allocate (change, source=check%samples%values(:channels, :n) - s%candidate%samples%values(:channels, :n))
      end if
   end subroutine find_change

   !> Takes what higher levels change for a part of the reference.
   subroutine take_change(s, rungs, change, least)
      type(target_search_type), intent(inout) :: s
      type(level_type), intent(in) :: rungs(:)
      real(wp), intent(in) :: change(:, :)
      !> Part of it that the error left is at least
      real(wp), intent(in) :: least
      real(wp) :: rest
      integer :: i
      rest = least
      do i = 1, size(rungs)
         rest = max(rest, rest_beyond(s%reached%advice%rungs(i), rungs(i), s%reached%advice%probe%beams(i)))
      end do
      s%reference%change = change
      s%reference%of_model = rest*maxval(abs(change), 2)
      s%reference%rungs = rungs
   end subroutine take_change

   !> The levels that verify, or some above them.
   pure function higher_rungs(advice, beyond) result(rungs)
      type(advice_type), intent(in) :: advice
      integer, intent(in) :: beyond
      type(level_type) :: rungs(size(advice%rungs))
      integer :: i
      do i = 1, size(rungs)
         rungs(i) = check_rung(advice, i)
         if (rungs(i)%step > advice%rungs(i)%step) rungs(i) = richer(rungs(i), beyond, .false.)
      end do
   end function higher_rungs

   !> Tolerance of runs with strain.
   pure real(wp) function tolerance_of_strain(s) result(tolerance)
      type(target_search_type), intent(in) :: s
      integer :: i
      tolerance = strain_tolerance(s%reached%advice%tolerance, s%reference%tolerance, &
         & any([(is_forced(s%reached%advice, i), i=1, size(s%reached%advice%rungs))]))
   end function tolerance_of_strain

   !> The beams with strain where it may matter, or all of them where it is not expected to.
   function strained_rungs(advice) result(rungs)
      type(advice_type), intent(in) :: advice
      type(level_type) :: rungs(size(advice%rungs))
      integer :: i
      do i = 1, size(rungs)
         rungs(i) = strained_rung(advice, i)
      end do
      if (same_rungs(rungs, advice%rungs)) rungs = richer(advice%rungs, 0, .true.)
   end function strained_rungs

   !> The smaller tolerance that the companion run has.
   subroutine tighten_step(s, error)
      type(target_search_type), intent(inout) :: s
      type(error_type), allocatable, intent(out) :: error
      type(advice_type) :: next
      next = s%reached%advice
      next%tolerance = smaller_tolerance(next%tolerance, s%reference%tolerance)
      s%tightened = .true.
      s%evidence%time_before = s%evidence%of_time
      call tell(s, 'the integration had an error of '//as_text(s%reached%of_time, 2)//s%reached%place_of_time// &
         & ': TOLERANCE='//as_text(next%tolerance, 2))
      call next_run(s, next, patience_of(s), error)
   end subroutine tighten_step

   !> A larger tolerance; the run that was made verifies it.
   subroutine loosen_step(s, error)
      type(target_search_type), intent(inout) :: s
      type(error_type), allocatable, intent(out) :: error
      type(advice_type) :: next
      next = s%reached%advice
      next%tolerance = looser_tolerance(s%evidence)
      call next_run(s, next, patience_of(s), error)
   end subroutine loosen_step

   !> Higher levels: those that have verified, or more.
   subroutine refine_step(s, error)
      type(target_search_type), intent(inout) :: s
      type(error_type), allocatable, intent(out) :: error
      type(advice_type) :: next
      type(level_type) :: check
      integer :: i, levels
      next = s%reached%advice
      levels = levels_up(s%evidence%of_model, s%target)
      do i = 1, size(next%rungs)
         if (.not. can_climb(next%rungs(i))) cycle
         check = check_rung(next, i)
         associate (rung => next%rungs(i))
            if (check%step == rung%step) cycle
            rung%step = max(rung%step, min(max(check%step, rung%step + levels), rung%highest - 1))
         end associate
      end do
      call tell_model(s, next)
      if (.not. any(s%reached%advice%rungs%step > 0) .and. .not. s%tightened) call begin_bending(next)
      call new_models(s, next, s%evidence%of_model, error)
   end subroutine refine_step

   !> The beams with strain.
   subroutine add_strain_step(s, error)
      type(target_search_type), intent(inout) :: s
      type(error_type), allocatable, intent(out) :: error
      type(advice_type) :: next
      next = s%reached%advice
      next%rungs = strained_rungs(next)
      if (s%evidence%of_strain < huge(1.0_wp)) s%reached%of_model = max(s%reached%of_model, s%evidence%of_strain)
      call tell_model(s, next)
      call new_models(s, next, 0.0_wp, error)
   end subroutine add_strain_step

   !> Runs other models; nothing is known of them.
   subroutine new_models(s, next, before, error)
      type(target_search_type), intent(inout) :: s
      type(advice_type), intent(in) :: next
      !> Error of the functions so far, relative; zero: it says nothing of these
      real(wp), intent(in) :: before
      type(error_type), allocatable, intent(out) :: error
      call next_run(s, next, patience_of(s), error)
      s%evidence%model_known = .false.
      s%evidence%strain_known = .false.
      s%evidence%joined = 0
      s%evidence%before = before
      s%evidence%time_before = 0.0_wp
      if (allocated(s%reference%change)) deallocate (s%reference%change)
      if (allocated(s%reference%of_strain)) deallocate (s%reference%of_strain)
   end subroutine new_models

   !> Work that the next candidate may take.
   pure real(wp) function patience_of(s) result(work)
      type(target_search_type), intent(in) :: s
      work = least_patience + patience_next*s%candidate%work
   end function patience_of

   !> Two runs that agree may both miss what a finer run of an earlier pair has met: then a smaller tolerance decides, eq. (7.94).
   subroutine look_again(s, error)
      type(target_search_type), intent(inout) :: s
      type(error_type), allocatable, intent(out) :: error
      type(advice_type) :: next
      next = s%reached%advice
      next%tolerance = max(least_verified, look_factor*next%tolerance)
      s%reached%shown%looks = s%reached%shown%looks + 1
      s%tightened = .true.
      call tell(s, 'a finer run had shown a difference of '//as_text(s%reached%shown%difference, 2)// &
         & ' that these two do not: TOLERANCE='//as_text(next%tolerance, 2))
      call next_run(s, next, patience_of(s), error)
      s%evidence%model_known = .false.
      s%evidence%strain_known = .false.
      s%evidence%joined = 0
   end subroutine look_again

   !> What the measurements say together, and what can be changed.
   subroutine weigh(s)
      type(target_search_type), intent(inout) :: s
      type(level_type) :: check(size(s%reached%advice%rungs)), strained(size(s%reached%advice%rungs))
      integer :: i, n
      associate (advice => s%reached%advice, e => s%evidence, reached => s%reached, reference => s%reference)
         check = higher_rungs(advice, 0)
         do i = 1, size(check)
            strained(i) = strained_rung(advice, i)
         end do
         e%target = s%target
         e%tolerance = advice%tolerance
         e%has_beams = size(check) > 0
         e%asks_strain = any(strained%stretches .neqv. advice%rungs%stretches)
         e%can_tighten = advice%open_tolerance .and. advice%tolerance > 1.01_wp*least_verified
         e%can_loosen = advice%open_tolerance .and. advice%integrator == 'RADAU' .and. .not. s%tightened .and. &
            & advice%tolerance < 0.5_wp*largest_tolerance
         e%can_refine = any(check%step > advice%rungs%step .and. advice%rungs%open_functions .and. &
            & advice%rungs%step < advice%rungs%highest - 1)
         e%can_strain = any(advice%rungs%open_strains .and. .not. advice%rungs%stretches .and. advice%rungs%step > 0)
         e%looks_strain = e%can_strain
         e%can_join = e%strain_known .and. e%looks_strain .and. e%strain_work*cost_ratio(advice) < together*s%candidate%work
         if (e%joined > 0) e%can_join = e%joined == 1 .and. reference%tolerance < 0.9_wp*tolerance_of_strain(s)
         e%can_surer = e%time_known .and. reference%tolerance < 0.9_wp*e%model_tolerance
         e%can_further = any(check%step > advice%rungs%step .and. check%step < check%highest) .and. &
            & .not. e%furthered .and. e%joined == 0
         if (.not. e%time_known) return
         if (.not. e%model_known) reference%rungs = advice%rungs
         call reference%combine(reference%rungs, reference%tolerance, merge(doubt*s%target, 0.0_wp, e%has_beams))
         n = size(reference%values, 2)
         reached%error = error_against(reference, s%candidate%samples%values)
         if (e%model_known) reached%error = max(reached%error, merge(e%of_model, 0.0_wp, e%of_model >= huge(1.0_wp)))
         reached%place = place_of(s%candidate%samples%values(:size(reference%scale), :n), reference%values, reference%scale, &
            & s%candidate%samples%times, s%candidate%names)
         e%error = reached%error
         e%difference = maxval([0.0_wp, largest_difference(s%candidate%samples%values(:size(reference%scale), :n), &
            & reference%values)/reference%scale])
      end associate
   end subroutine weigh

   !> What the levels that verify cost more, as far as functions tell.
   pure real(wp) function cost_ratio(advice) result(ratio)
      type(advice_type), intent(in) :: advice
      ratio = sum(cost_of(higher_rungs(advice, 0)))/max(1.0_wp, sum(cost_of(advice%rungs)))
   end function cost_ratio

   !> A line of the way.
   subroutine tell(s, text)
      type(target_search_type), intent(inout) :: s
      character(*), intent(in) :: text
      s%reached%path = s%reached%path//newline//'   '//text
   end subroutine tell

   !> A line of other models.
   subroutine tell_model(s, next)
      type(target_search_type), intent(inout) :: s
      type(advice_type), intent(in) :: next
      if (s%reached%of_model < 1.0e3_wp) then
         call tell(s, 'the model had an error of '//as_text(s%reached%of_model, 2)//s%reached%place_of_model//': '// &
            & names_of(next%rungs))
      else
         call tell(s, 'the model had an error of unknown size: '//names_of(next%rungs))
      end if
   end subroutine tell_model

end module limber_accuracy_search_steps
