!> From a setting that keeps a target to a cheaper one that keeps it as well: looser tolerances and lower rungs are tried against
!> the run that has verified the first. Floor: analysis. Equations: doc/theory.md, accuracy on request.
module limber_analysis_descent
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text, newline
   use limber_analysis_advice, only: advice_type, expected_error, cost_of
   use limber_analysis_rungs, only: rung_type, lower_rungs, bound_rung, better_rung, can_climb, rung_name, level_linear, &
      & level_kg, level_full
   use limber_analysis_trial, only: trial_type, truth_type, run_trial, take_trial, error_against
   use limber_deck_content, only: deck_type
   implicit none
   private
   public :: descend

   !> Tolerance that is the loosest, and ratios of two that are tried one after another
   real(wp), parameter :: loosest = 1.0e-2_wp, looser(2) = [3.0_wp, 1.75_wp]
   !> Part of the work that a setting must save
   real(wp), parameter :: saved = 0.1_wp
   !> Most runs, and their work in units of the first setting's
   integer, parameter :: most_runs = 60
   real(wp), parameter :: most_effort = 16.0_wp

   !> A setting that has failed: nothing looser of it is tried
   type :: failed_type
      character(:), allocatable :: name
      real(wp) :: tolerance = 0.0_wp
   end type failed_type

contains

   !> Descends as long as something can be left out.
   subroutine descend(deck, target, quiet, truth, advice, best, worst, runs, cpu, path, error)
      type(deck_type), intent(in) :: deck
      real(wp), intent(in) :: target
      !> Whether the progress is not shown
      logical, intent(in) :: quiet
      type(truth_type), intent(in) :: truth
      !> Rungs and tolerance of the setting that keeps the target, on return of the cheapest
      type(advice_type), intent(inout) :: advice
      !> Its run, and its verified error
      type(trial_type), intent(inout) :: best
      real(wp), intent(inout) :: worst
      !> Number of runs and CPU seconds so far
      integer, intent(inout) :: runs
      real(wp), intent(inout) :: cpu
      !> Receives a line for each step down
      character(:), allocatable, intent(inout) :: path
      !> The deck is wrong (status 2)
      type(error_type), allocatable, intent(out) :: error
      type(failed_type) :: failed(most_runs)
      !> With RADAU
      type(deck_type) :: implicit_deck
      type(rung_type), allocatable :: rungs(:)
      type(rung_type) :: lower(3)
      real(wp) :: allowed(size(truth%scale)), budget
      !> Tolerance that has been too loose; part of the duration that the last setting reached before it was given up
      real(wp) :: too_loose, given_up
      integer :: i, j, k, count, tries
      logical :: down
      allowed = target*truth%scale - truth%rest
      if (any(allowed <= 0.0_wp)) return
      tries = 0
      implicit_deck = deck
      call implicit_deck%set_option(deck%find('DYNAMICS'), 'INTEGRATOR', 'RADAU', given=.true.)
      budget = most_effort*best%work
      ! Elements cost nothing in the time loop, and what the lumped masses do is left to the rungs
      where (.not. advice%rungs%given_elements) advice%rungs%elements = max(advice%rungs%elements, truth%rungs%elements)
      allocate (rungs, source=advice%rungs)
      too_loose = huge(too_loose)
      down = .false.
      call start_below()
      if (allocated(error)) return
      down = .true.
      do while (down)
         down = .false.
         ! What saves much first: less geometry, a looser tolerance, fewer modes
         do k = 1, 2
            do i = 1, size(rungs)
               call lower_rungs(advice%rungs(i), lower, count)
               do j = 1, count
                  if ((lower(j)%level < rungs(i)%level .or. lower(j)%segments < rungs(i)%segments) .neqv. k == 1) cycle
                  rungs(i) = lower(j)
                  call try(advice%tolerance)
                  if (allocated(error)) return
                  rungs(i) = advice%rungs(i)
                  if (down) exit
               end do
               if (down) exit
            end do
            if (down) exit
            if (k == 1 .and. advice%open_tolerance .and. advice%tolerance < loosest) call try_looser()
            if (down .or. allocated(error)) exit
         end do
         if (allocated(error)) return
      end do

   contains

      !> A looser tolerance, unless one has been too loose for a rung above already.
      subroutine try_looser()
         real(wp) :: tolerance
         integer :: l
         do l = 1, size(looser)
            tolerance = min(loosest, looser(l)*advice%tolerance)
            if (tolerance > 0.99_wp*too_loose) cycle
            call try(tolerance)
            if (down .or. allocated(error)) return
            too_loose = tolerance
         end do
      end subroutine try_looser

      !> The lowest rungs first, at a few tolerances, as far as they cost much less: they are soon given up where they do not do.
      !> One that is given up early and at the same place with a smaller tolerance errs by itself.
      subroutine start_below()
         integer, parameter :: levels(7) = [level_linear, level_kg, level_kg, level_full, level_full, level_full, level_full], &
            & modes(7) = [1, 1, 2, 1, 2, 3, 5]
         real(wp), parameter :: tolerances(4) = [1.0e-2_wp, 3.0e-3_wp, 1.0e-3_wp, 1.0e-4_wp], much = 0.9_wp
         !> How much looser tolerances of the same and of richer rungs are
         real(wp), parameter :: worth(2) = [looser(1), 2.0_wp]
         real(wp), parameter :: early = 0.3_wp, same = 1.2_wp
         real(wp) :: before
         type(rung_type), allocatable :: present(:)
         integer :: m, l
         allocate (present, source=advice%rungs)
         do m = 1, size(levels)
            do l = 1, size(rungs)
               call bound_rung(rungs(l), levels(m), modes(m))
            end do
            if (sum(cost_of(rungs)) <= much*sum(cost_of(present))) then
               given_up = 0.0_wp
               do l = 1, size(tolerances)
                  before = given_up
                  if (advice%open_tolerance) call try(tolerances(l))
                  if (.not. advice%open_tolerance .and. l == 1) call try(advice%tolerance)
                  if (allocated(error) .or. down) exit
                  if (given_up < min(early, same*before)) exit
               end do
            end if
            if (.not. allocated(error)) rungs = advice%rungs
            if (allocated(error) .or. down) return
         end do
         ! The same rungs: between two tolerances that do may be one that does not, of an explicit integrator at its limit. Then
         ! richer ones: where the tolerance binds, more modes are cheap
         if (.not. advice%open_tolerance) return
         do m = 1, 2
            do l = 1, size(tolerances)
               if (tolerances(l) <= worth(m)*advice%tolerance) exit
               call try(tolerances(l))
               if (allocated(error) .or. down) return
               if (m == 1) too_loose = tolerances(l)
            end do
            if (any(advice%rungs%segments > 1)) exit
            do l = 1, size(rungs)
               if (rungs(l)%level == level_full .and. can_climb(rungs(l))) rungs(l) = better_rung(rungs(l), .false.)
            end do
            if (any(rungs%segments > 1)) exit
            if (m == 1) too_loose = huge(too_loose)
         end do
         rungs = advice%rungs
      end subroutine start_below

      !> Runs a setting, and takes it if it keeps the target for less; where AUTO chooses ADAMS at a loose tolerance also with
      !> RADAU, which then is often the better of the two.
      subroutine try(tolerance)
         real(wp), intent(in) :: tolerance
         real(wp), parameter :: loose = 0.9e-3_wp
         character(10) :: integrator
         if (advice%integrator /= '') then
            call attempt(implicit_deck, tolerance, integrator)
            return
         end if
         call attempt(deck, tolerance, integrator)
         if (down .or. allocated(error) .or. integrator /= 'ADAMS' .or. .not. advice%open_integrator) return
         if (tolerance < loose) return
         advice%integrator = 'RADAU'
         call attempt(implicit_deck, tolerance, integrator)
         if (.not. down) advice%integrator = ''
      end subroutine try

      !> Runs a setting of a deck, and takes it if it keeps the target for less.
      subroutine attempt(deck, tolerance, integrator)
         type(deck_type), intent(in) :: deck
         real(wp), intent(in) :: tolerance
         !> That has run; blank: none
         character(10), intent(out) :: integrator
         type(trial_type) :: trial
         character(:), allocatable :: name
         real(wp) :: found
         integer :: j
         integrator = ''
         if (tries == most_runs .or. budget <= 0.0_wp) return
         name = trim(advice%integrator)//names()
         do j = 1, tries
            if (failed(j)%name == name .and. failed(j)%tolerance <= tolerance) return
         end do
         tries = tries + 1
         failed(tries)%name = name
         failed(tries)%tolerance = tolerance
         call run_trial(deck, rungs, tolerance, 1.0_wp, 2 + 4*best%outcome%cpu, .false., quiet, &
            & 'less: '//name, trial, error, truth%values, allowed, (1 - saved)*best%work)
         if (allocated(error)) return
         given_up = 1.0_wp
         if (trial%leaves) given_up = (trial%outcome%reached - best%samples%times(1))/advice%probe%duration
         integrator = trial%integrator
         runs = runs + 1
         cpu = cpu + trial%outcome%cpu
         budget = budget - trial%work
         if (trial%reason /= '' .or. trial%work > (1 - saved)*best%work) return
         if (size(truth%values, 2) /= trial%samples%samples) return
         found = error_against(truth, trial%samples%values)
         if (found > target) return
         failed(tries)%name = ''
         worst = found
         advice%rungs = rungs
         advice%tolerance = tolerance
         do j = 1, size(rungs)
            advice%expected(j) = expected_error(rungs(j), advice%probe%beams(j), advice%probe%duration)
         end do
         call take_trial(trial, best)
         path = path//newline//'   it keeps the target with less as well: '
         if (size(rungs) > 0) path = path//names()//', '
         path = path//'TOLERANCE='//as_text(tolerance, 2)//', error '//as_text(found, 2)
         down = .true.
      end subroutine attempt

      !> The rungs for people.
      function names() result(text)
         character(:), allocatable :: text
         integer :: j
         text = ''
         do j = 1, size(rungs)
            if (j > 1) text = text//'; '
            text = text//rung_name(rungs(j))
         end do
      end function names

   end subroutine descend

end module limber_analysis_descent
