!> Search of the setting for a target. One loop: what is known of the candidate decides the next run, until it keeps the target;
!> then coarser settings are tried. Floor: accuracy. Equations: doc/theory, part 7.
module limber_accuracy_target_search
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, status_interrupted
   use limber_base_text, only: as_text, newline
   use limber_accuracy_advice, only: advice_type, make_advice
   use limber_accuracy_candidate, only: candidate_type, take_samples
   use limber_accuracy_coarsening, only: coarsen
   use limber_accuracy_fidelity_levels, only: richer, can_climb, names_of
   use limber_accuracy_fixed_options, only: verify_fixed, find_fixed, unverified_words
   use limber_monitor_function_watch, only: starts_struck
   use limber_accuracy_reached_target, only: reached_type, record_errors, say_why
   use limber_accuracy_reference_run, only: reference_run_type
   use limber_accuracy_search_decisions, only: next_trial, measure_time, measure_model, measure_strain, tighten, loosen, refine, &
      & measure_finely, measure_together, &
      & measure_further, add_strain, keep, give_up, is_complete
   use limber_accuracy_search_steps, only: target_search_type, first_run, next_run, time_step, model_step, strain_step, &
      & joint_step, tighten_step, loosen_step, refine_step, add_strain_step, look_again, weigh
   use limber_accuracy_search_thresholds, only: least_patience, least_verified, most_looks, most_rounds, much_ringing, &
      & patience_next
   use limber_deck_content, only: deck_type
   implicit none
   private
   public :: reach_target

   !> The run that misses the target by the least, and what it was compared with
   type :: best_type
      type(advice_type) :: advice
      type(candidate_type) :: candidate
      type(reference_run_type) :: reference
      real(wp) :: error = huge(1.0_wp), of_time = 0.0_wp, of_model = 0.0_wp
      character(:), allocatable :: place
   end type best_type

contains

   !> Finds a setting that keeps a target, and its run.
   subroutine reach_target(deck, target, quiet, reached, error)
      !> As it was read
      type(deck_type), intent(in) :: deck
      real(wp), intent(in) :: target
      !> Whether the progress is not shown
      logical, intent(in) :: quiet
      type(reached_type), intent(out) :: reached
      !> The deck is wrong (status 2)
      type(error_type), allocatable, intent(out) :: error
      type(target_search_type) :: s
      s%target = target
      s%pool%deck = deck
      s%pool%quiet = quiet
      call search(s, error)
      reached = s%reached
      reached%runs = s%pool%runs
      reached%cpu = s%pool%cpu
      reached%work = s%pool%work
      reached%spent = s%pool%spent
      if (allocated(error)) then
         if (error%status /= status_interrupted) return
         call move_alloc(error%message, reached%interruption)
         deallocate (error)
         if (.not. allocated(s%candidate%outcome)) return
      end if
      if (reached%done .or. s%reference%known) call record_errors(s%reference, s%candidate, reached)
      if (.not. (reached%done .or. allocated(reached%interruption))) then
         reached%is_struck = is_struck(s%candidate)
         reached%is_ringing = s%candidate%ringing > much_ringing
         call say_why(target, reached)
      end if
      reached%statistics = s%candidate%statistics
      call move_alloc(s%candidate%outcome, reached%outcome)
      call take_samples(s%candidate%samples%memory_type, reached%samples)
   end subroutine reach_target

   !> Whether the start without deflections sets off vibrations of a candidate.
   pure logical function is_struck(candidate)
      type(candidate_type), intent(in) :: candidate
      is_struck = .false.
      if (.not. allocated(candidate%outcome)) return
      if (allocated(candidate%outcome%indicators)) is_struck = starts_struck(candidate%outcome%indicators%functions)
   end function is_struck

   !> The search itself.
   subroutine search(s, error)
      type(target_search_type), intent(inout) :: s
      !> The deck is wrong (status 2), or a signal asks for the end (status 4)
      type(error_type), allocatable, intent(out) :: error
      type(best_type) :: best
      integer :: round, trial
      associate (reached => s%reached)
         reached%reason = ''
         reached%estimate%reason = ''
         reached%path = ''
         reached%place = ''
         reached%place_of_time = ''
         reached%place_of_model = ''
         call find_fixed(s%pool%deck, reached%fixed)
         reached%unverified = unverified_words(s%pool%deck)
         call make_advice(s%pool%deck, s%target, reached%advice, error)
         if (allocated(error)) return
         call first_run(s, error)
         do round = 1, most_rounds
            if (allocated(error) .or. s%pool%spent .or. reached%reason /= '') exit
            if (s%candidate%reason /= '') then
               call replace_failed(s, error)
               cycle
            end if
            call weigh(s)
            call note_best()
            trial = next_trial(s%evidence)
            if (trial == keep .and. forgets(s)) then
               call look_again(s, error)
               cycle
            end if
            select case (trial)
            case (measure_time); call time_step(s, error)
            case (measure_model); call model_step(s, .false., 0, error)
            case (measure_finely); call model_step(s, .true., 0, error)
            case (measure_further); call model_step(s, s%evidence%model_tolerance < s%reached%advice%tolerance, 1, error)
            case (measure_together); call joint_step(s, error)
            case (measure_strain); call strain_step(s, error)
            case (tighten); call tighten_step(s, error)
            case (loosen); call loosen_step(s, error)
            case (refine); call refine_step(s, error)
            case (add_strain); call add_strain_step(s, error)
            case (give_up); exit
            case (keep)
               reached%done = .true.
               call verify_fixed(s%target, s%pool, s%candidate, reached, s%reference, error)
               if (.not. allocated(error) .and. reached%done) &
                  & call coarsen(s%target, s%pool, s%reference, reached, s%candidate, error)
               return
            end select
         end do
      end associate
      if (best%error < huge(1.0_wp)) call give_back()

   contains

      !> Keeps a run that misses the target by less than those before. Only what is measured in whole counts.
      subroutine note_best()
         associate (e => s%evidence, reached => s%reached)
            if (.not. is_complete(e) .or. e%error >= best%error) return
            best%advice = reached%advice
            best%candidate = s%candidate
            best%reference = s%reference
            best%error = e%error
            best%of_time = e%of_time
            best%of_model = e%of_model
            best%place = reached%place
            if (.not. s%pool%quiet) call s%pool%say('this one errs by '//as_text(e%error, 2)//reached%place)
         end associate
      end subroutine note_best

      !> Gives the best run back where the last one misses the target by more, or was not verified.
      subroutine give_back()
         associate (reached => s%reached)
            if (is_complete(s%evidence) .and. best%error >= s%evidence%error) return
            s%candidate = best%candidate
            s%reference = best%reference
            reached%advice = best%advice
            reached%error = best%error
            reached%of_time = best%of_time
            reached%of_model = best%of_model
            reached%place = best%place
            reached%path = reached%path//newline//'   the best of these runs is kept: TOLERANCE='// &
               & as_text(reached%advice%tolerance, 2)//', error '//as_text(reached%error, 2)
         end associate
      end subroutine give_back

   end subroutine search

   !> Whether a finer run had met what the last two miss, and a smaller tolerance is left.
   pure logical function forgets(s)
      type(target_search_type), intent(in) :: s
      associate (advice => s%reached%advice, shown => s%reached%shown)
         forgets = advice%open_tolerance .and. advice%tolerance > least_verified .and. shown%looks < most_looks
         if (forgets) forgets = shown%is_forgotten(advice%rungs, s%reference%values, s%reference%scale, s%target)
      end associate
   end function forgets

   !> Goes up with all beams in place of a run that has failed.
   subroutine replace_failed(s, error)
      type(target_search_type), intent(inout) :: s
      type(error_type), allocatable, intent(out) :: error
      type(advice_type) :: next
      next = s%reached%advice
      if (.not. any(can_climb(next%rungs))) then
         s%reached%reason = s%candidate%reason
         return
      end if
      next%rungs = merge(richer(next%rungs, 1, .true.), next%rungs, can_climb(next%rungs))
      s%reached%path = s%reached%path//newline//'   '//names_of(s%reached%advice%rungs)//' failed: '//names_of(next%rungs)
      call next_run(s, next, least_patience + patience_next*s%candidate%work, error)
      s%evidence%model_known = .false.
      s%evidence%strain_known = .false.
   end subroutine replace_failed

end module limber_accuracy_target_search
