!> Search of a cheaper setting that keeps the target. Less of one thing after another is tried against the run that has verified the
!> first. Floor: accuracy. Equations: doc/theory, part 7.
module limber_accuracy_coarsening
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text, newline
   use limber_accuracy_advice, only: expected_error, cost_of, deck_of
   use limber_accuracy_run_pool, only: pool_type
   use limber_accuracy_reached_target, only: reached_type
   use limber_accuracy_fidelity_levels, only: level_type, poorer, names_of
   use limber_accuracy_candidate, only: candidate_type, take_trial, least_patience
   use limber_accuracy_reference_run, only: reference_run_type, error_against
   use limber_deck_content, only: deck_type
   implicit none
   private
   public :: descend

   !> Tolerance that is the loosest, and what one is multiplied by at least and at most
   real(wp), parameter :: loosest = 1.0e-2_wp, looser(2) = [1.75_wp, 10.0_wp]
   !> Part of the work that a setting must save, and what a rung must be expected to save to be tried
   real(wp), parameter :: saved = 0.1_wp, worth = 0.05_wp
   !> Part of the target that what is left may err by: a step that is meant to come near to the target needs some room, as does what
   !> the finest run errs by beyond what is known of it
   real(wp), parameter :: near = 0.9_wp
   !> Work of the whole search in units of what is left after which nothing more is tried, and tries that there are all the same
   real(wp), parameter :: most_effort = 13.0_wp
   integer, parameter :: least_tries = 3

contains

   !> Descends as long as something can be left out. What has been too little once is not tried again.
   subroutine descend(deck, target, quiet, pool, truth, reached, best, error)
      type(deck_type), intent(in) :: deck
      real(wp), intent(in) :: target
      !> Whether the progress is not shown
      logical, intent(in) :: quiet
      type(pool_type), intent(inout) :: pool
      type(reference_run_type), intent(in) :: truth
      !> With the setting that keeps the target, on return the cheapest
      type(reached_type), intent(inout) :: reached
      !> Its run
      type(candidate_type), intent(inout) :: best
      !> The deck is wrong (status 2), or a signal asks for the end (status 4)
      type(error_type), allocatable, intent(out) :: error
      type(level_type), allocatable :: rungs(:)
      !> Whether it has failed to leave out the strain of a beam, to take a lower rung (rungs), another integrator
      logical :: unstrained(size(reached%advice%rungs)), lower(size(reached%advice%rungs)), implicit, loose
      !> Tolerances that may be tried and that is
      real(wp) :: ceiling, tolerance
      integer :: tries, i
      !> Whether the last one that failed has cost too much, not erred by too much
      logical :: down, dear
      !> Errors of the integration are taken to grow with this power of the tolerance
      real(wp), parameter :: growing = 0.6_wp
      if (any(truth%rest >= near*target*truth%scale)) return
      allocate (rungs, source=reached%advice%rungs)
      unstrained = .false.
      lower = .false.
      ceiling = loosest
      implicit = reached%advice%integrator /= ''
      tries = 0
      down = .true.
      do while (down .and. .not. allocated(error))
         down = .false.
         ! What saves much first
         do i = 1, size(rungs)
            if (down .or. allocated(error)) exit
            if (unstrained(i) .or. .not. (rungs(i)%open_strains .and. rungs(i)%stretches)) cycle
            rungs(i)%stretches = .false.
            call try(reached%advice%tolerance, unstrained(i))
         end do
         if (.not. down) call try_integrator()
         do i = 1, 2
            if (down .or. allocated(error) .or. .not. reached%advice%open_tolerance) exit
            tolerance = reached%advice%tolerance*min(looser(2), (1 + max(0.0_wp, near*target - reached%error)/max(reached%of_time, &
               & tiny(1.0_wp)))**(1/growing))
            tolerance = min(ceiling, tolerance)
            if (tolerance < looser(1)*reached%advice%tolerance .and. tolerance < 0.99_wp*loosest) exit
            if (tolerance < 1.01_wp*reached%advice%tolerance) exit
            call try(tolerance, loose)
            ! A little looser saves even less
            if (loose) ceiling = merge(0.0_wp, sqrt(tolerance*reached%advice%tolerance), dear)
         end do
         do i = 1, size(rungs)
            if (down .or. allocated(error)) exit
            if (lower(i)) cycle
            rungs(i) = poorer(reached%advice%rungs(i))
            if (sum(cost_of(rungs)) < (1 - worth)*sum(cost_of(reached%advice%rungs))) then
               call try(reached%advice%tolerance, lower(i))
            else
               rungs(i) = reached%advice%rungs(i)
            end if
         end do
      end do

   contains

      !> Where AUTO chooses ADAMS RADAU may be the better of the two, at a looser tolerance.
      subroutine try_integrator()
         real(wp), parameter :: looser = 10.0_wp
         if (implicit .or. best%integrator /= 'ADAMS' .or. .not. reached%advice%open_integrator .or. allocated(error)) return
         reached%advice%integrator = 'RADAU'
         call try(min(loosest, merge(looser, 1.0_wp, reached%advice%open_tolerance)*reached%advice%tolerance), implicit)
         if (.not. down) reached%advice%integrator = ''
      end subroutine try_integrator

      !> Runs a setting, and takes it if it keeps the target for less.
      subroutine try(tolerance, failed)
         real(wp), intent(in) :: tolerance
         logical, intent(out) :: failed
         type(candidate_type) :: trial
         real(wp) :: found
         integer :: k
         failed = .true.
         dear = .false.
         if (tries < least_tries .or. pool%work < (most_effort - 1)*best%work) then
            tries = tries + 1
            call run_less(deck_of(reached%advice, deck), tolerance, trial)
            if (allocated(error)) return
            failed = trial%reason /= '' .or. trial%work > (1 - saved)*best%work &
               & .or. size(truth%values, 2) /= trial%samples%samples
            dear = failed .and. .not. trial%leaves
            if (.not. failed) found = error_against(truth, trial%samples%values)
            if (.not. failed) failed = found > near*target
         end if
         if (failed) then
            rungs = reached%advice%rungs
            return
         end if
         down = .true.
         if (tolerance > reached%advice%tolerance) reached%of_time = (tolerance/reached%advice%tolerance)**growing*reached%of_time
         reached%error = found
         associate (advice => reached%advice)
            advice%rungs = rungs
            advice%tolerance = tolerance
            do k = 1, size(rungs)
               advice%expected(k) = expected_error(rungs(k), advice%probe%beams(k))
            end do
         end associate
         call take_trial(trial, best)
         reached%path = reached%path//newline//'   it keeps the target with less as well: '
         if (size(rungs) > 0) reached%path = reached%path//names_of(rungs)//', '
         reached%path = reached%path//'TOLERANCE='//as_text(tolerance, 2)//', error '//as_text(found, 2)
      end subroutine try

      !> One run, given up where it leaves the truth by too much or costs too much.
      subroutine run_less(deck, tolerance, trial)
         type(deck_type), intent(in) :: deck
         real(wp), intent(in) :: tolerance
         type(candidate_type), intent(inout) :: trial
         call pool%run(deck, rungs, tolerance, 1.0_wp, min(least_patience, 2*best%work), .false., quiet, &
            & 'less: '//names_of(rungs), trial, error, truth%values, near*target*truth%scale - truth%rest, (1 - saved)*best%work)
      end subroutine run_less

   end subroutine descend

end module limber_accuracy_coarsening
