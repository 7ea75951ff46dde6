!> Search of a coarser setting that keeps the target. Runs that are there come first; then less of one thing after another is tried
!> against the reference. Floor: accuracy. Equations: doc/theory, part 7.
module limber_accuracy_coarsening
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text, newline
   use limber_accuracy_advice, only: expected_error, cost_of
   use limber_accuracy_run_pool, only: pool_type
   use limber_accuracy_reached_target, only: reached_type
   use limber_accuracy_fidelity_levels, only: level_type, poorer, names_of
   use limber_accuracy_candidate, only: candidate_type, run_request_type, take_trial
   use limber_accuracy_reference_run, only: reference_run_type, error_against
   use limber_accuracy_search_decisions, only: coarser_tolerance, is_worth
   use limber_accuracy_search_thresholds, only: coarse_enough, largest_tolerance, least_patience, looser, saved, &
      & usual_power, work_power, worth
   implicit none
   private
   public :: coarsen

contains

   !> Makes a setting coarser as long as it keeps the target. What has been too little once is not tried again.
   subroutine coarsen(target, pool, reference, reached, best, error)
      real(wp), intent(in) :: target
      type(pool_type), intent(inout) :: pool
      type(reference_run_type), intent(in) :: reference
      !> With the setting that keeps the target, on return the cheapest
      type(reached_type), intent(inout) :: reached
      !> Its run
      type(candidate_type), intent(inout) :: best
      !> The deck is wrong (status 2), or a signal asks for the end (status 4)
      type(error_type), allocatable, intent(out) :: error
      type(run_request_type) :: next
      !> Whether it has failed to leave out the strain of a beam, to take a lower level (beams), another integrator, a larger
      !> tolerance
      logical :: unstrained(size(reached%advice%rungs)), lower(size(reached%advice%rungs)), implicit
      !> Tolerance that may be tried at most
      real(wp) :: ceiling
      integer :: i
      !> Whether a try was taken, and whether one that was not taken has cost too much
      logical :: taken, dear
      if (any(reference%rest >= coarse_enough*target*reference%scale)) return
      unstrained = .false.
      lower = .false.
      ceiling = largest_tolerance
      implicit = reached%advice%integrator /= ''
      call take_kept()
      taken = .true.
      do while (taken .and. .not. allocated(error))
         taken = .false.
         do i = 1, size(lower)
            if (taken .or. allocated(error)) exit
            if (unstrained(i) .or. .not. (reached%advice%rungs(i)%open_strains .and. reached%advice%rungs(i)%stretches)) cycle
            call start()
            next%rungs(i)%stretches = .false.
            call try(unstrained(i))
         end do
         call try_integrator()
         call try_tolerance()
         do i = 1, size(lower)
            if (taken .or. allocated(error)) exit
            if (lower(i)) cycle
            call start()
            next%rungs(i) = poorer(next%rungs(i))
            if (sum(cost_of(next%rungs)) < (1 - worth)*sum(cost_of(reached%advice%rungs))) call try(lower(i))
         end do
      end do

   contains

      !> The next try is the setting as it is.
      subroutine start()
         next%rungs = reached%advice%rungs
         next%tolerance = reached%advice%tolerance
         next%integrator = reached%advice%integrator
      end subroutine start

      !> Takes the cheapest run that is there.
      subroutine take_kept()
         integer :: place
         call pool%take_cheapest(reference, coarse_enough*target, best, place)
         if (place == 0) return
         next = pool%kept(place)%request
         call take(error_against(reference, best%samples%values))
      end subroutine take_kept

      !> Where AUTO chooses ADAMS RADAU may be the better of the two, at a larger tolerance.
      subroutine try_integrator()
         if (taken .or. implicit .or. best%integrator /= 'ADAMS' .or. .not. reached%advice%open_integrator .or. &
            & allocated(error)) return
         call start()
         next%integrator = 'RADAU'
         if (reached%advice%open_tolerance) next%tolerance = min(largest_tolerance, looser(2)*next%tolerance)
         call try(implicit)
      end subroutine try_integrator

      !> A larger tolerance, and a smaller step towards it if that errs by too much.
      subroutine try_tolerance()
         integer :: k
         logical :: failed
         do k = 1, 2
            if (taken .or. allocated(error) .or. .not. reached%advice%open_tolerance) return
            call start()
            next%tolerance = coarser_tolerance(target, reached%error, reached%of_time, reached%advice%tolerance, ceiling)
            if (next%tolerance <= 0.0_wp) return
            call try(failed)
            if (failed) ceiling = merge(0.0_wp, sqrt(next%tolerance*reached%advice%tolerance), dear)
         end do
      end subroutine try_tolerance

      !> Runs a setting, and takes it if it keeps the target for less. It is given up where it errs or costs too much.
      subroutine try(failed)
         logical, intent(out) :: failed
         type(candidate_type) :: trial
         real(wp) :: found
         failed = .true.
         dear = .true.
         if (.not. is_worth(pool%work, best%work, expected_work())) return
         next%label = 'less: '//names_of(next%rungs)
         next%limit = min(least_patience, 2*best%work)
         next%most = (1 - saved)*best%work
         next%truth = reference%values
         next%allowed = coarse_enough*target*reference%scale - reference%rest
         call pool%run(next, trial, error)
         if (allocated(error)) return
         dear = .not. trial%leaves
         if (trial%reason /= '' .or. trial%work > next%most .or. size(reference%values, 2) /= trial%samples%samples) return
         found = error_against(reference, trial%samples%values)
         dear = .false.
         if (found > coarse_enough*target) return
         failed = .false.
         taken = .true.
         call take_trial(trial, best)
         call take(found)
      end subroutine try

      !> Work of the next try, as far as levels and tolerance tell.
      real(wp) function expected_work()
         expected_work = min(1 - saved, (reached%advice%tolerance/next%tolerance)**work_power)*best%work
         if (size(next%rungs) > 0) expected_work = expected_work*min(1.0_wp, sum(cost_of(next%rungs))/ &
            & sum(cost_of(reached%advice%rungs)))
      end function expected_work

      !> The next try is the setting.
      subroutine take(found)
         !> Its error
         real(wp), intent(in) :: found
         integer :: k
         associate (advice => reached%advice)
            reached%of_time = max(1.0_wp, next%tolerance/advice%tolerance)**usual_power*reached%of_time
            reached%error = found
            advice%rungs = next%rungs
            advice%tolerance = next%tolerance
            if (advice%open_integrator) advice%integrator = next%integrator
            do k = 1, size(advice%rungs)
               advice%expected(k) = expected_error(advice%rungs(k), advice%probe%beams(k))
            end do
            reached%path = reached%path//newline//'   it keeps the target with less as well: '
            if (size(advice%rungs) > 0) reached%path = reached%path//names_of(advice%rungs)//', '
            reached%path = reached%path//'TOLERANCE='//as_text(advice%tolerance, 2)//', error '//as_text(found, 2)
         end associate
      end subroutine take

   end subroutine coarsen

end module limber_accuracy_coarsening
