!> From a setting that keeps a target to a cheaper one that keeps it as well: looser tolerances and lower rungs are tried against
!> the run that has verified the first. Floor: analysis. Equations: doc/theory.md, accuracy on request.
module limber_analysis_descent
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text, newline
   use limber_analysis_advice, only: expected_error, cost_of
   use limber_analysis_reached, only: reached_type
   use limber_analysis_rungs, only: rung_type, lower_rungs, bound_rung, better_rung, can_climb, rung_name, &
      & enough_derivatives, level_linear, &
      & level_kg, level_full, most_lower
   use limber_analysis_trial, only: trial_type, run_trial, take_trial, least_patience
   use limber_analysis_truth, only: truth_type, error_against
   use limber_analysis_verification, only: sharpen, rest_after_looks, least_verified
   use limber_deck_content, only: deck_type
   implicit none
   private
   public :: descend

   !> Tolerance that is the loosest, and ratios of two that are tried one after another
   real(wp), parameter :: loosest = 1.0e-2_wp, looser(2) = [3.0_wp, 1.75_wp], tighter(3) = [0.75_wp, 0.4_wp, 0.1_wp]
   !> Part of the work that a setting must save
   real(wp), parameter :: saved = 0.1_wp
   !> Most runs, and their work in units of the first setting's
   integer, parameter :: most_runs = 60
   real(wp), parameter :: most_effort = 16.0_wp

   !> What a setting that keeps the target must cost, in units of the cheapest, to be worth a second look at a truth that errs by
   !> too much to tell
   real(wp), parameter :: worth_a_look = 0.6_wp
   !> Most looks
   integer, parameter :: most_looks = 2

   !> A setting that was tried. If it has failed nothing looser of it is
   type :: tried_type
      character(:), allocatable :: name
      real(wp) :: tolerance = 0.0_wp
      !> Whether it has failed; whether it may keep the target, within the error of the truth; its error, and its work
      logical :: counts = .false., in_doubt = .false.
      real(wp) :: error = 0.0_wp, work = 0.0_wp
   end type tried_type

   !> A setting that keeps the target
   type :: kept_type
      type(rung_type), allocatable :: rungs(:)
      real(wp) :: tolerance = 0.0_wp
      character(5) :: integrator = ''
   end type kept_type

contains

   !> Descends as long as something can be left out.
   subroutine descend(deck, target, quiet, truth, reached, best, error)
      type(deck_type), intent(in) :: deck
      real(wp), intent(in) :: target
      !> Whether the progress is not shown
      logical, intent(in) :: quiet
      type(truth_type), intent(inout) :: truth
      !> With the setting that keeps the target, on return the cheapest. If a second look at the truth shows that it does not keep
      !> it, it is not done
      type(reached_type), intent(inout) :: reached
      !> Its run
      type(trial_type), intent(inout) :: best
      !> The deck is wrong (status 2), or a signal asks for the end (status 4)
      type(error_type), allocatable, intent(out) :: error
      type(tried_type) :: tried(most_runs)
      type(kept_type) :: kept(0:most_runs)
      !> With RADAU
      type(deck_type) :: implicit_deck
      type(rung_type), allocatable :: rungs(:)
      type(rung_type) :: lower(most_lower)
      real(wp) :: budget
      !> Tolerance that has been too loose; part of the duration that the last setting reached before it was given up
      real(wp) :: too_loose, given_up
      integer :: i, j, k, count, tries, last, look
      logical :: down, sharper
      if (any(truth%safety*truth%rest >= target*truth%scale)) return
      tries = 0
      implicit_deck = deck
      call implicit_deck%set_option(deck%find('DYNAMICS'), 'INTEGRATOR', 'RADAU', given=.true.)
      budget = most_effort*best%work
      ! Elements cost nothing in the time loop, and what the lumped masses do is left to the rungs
      associate (own => reached%advice%rungs)
         where (.not. own%given_elements) own%elements = max(own%elements, truth%rungs%elements)
         allocate (rungs, source=own)
      end associate
      last = -1
      call keep()
      do look = 0, most_looks
         call go_down()
         if (.not. allocated(error)) call try_tighter()
         if (allocated(error) .or. look == most_looks .or. .not. look_may_help()) exit
         call sharpen(deck, target, quiet, reached, truth, sharper, error)
         if (allocated(error) .or. .not. sharper) exit
         reached%path = reached%path//newline//'   a second look at the verification leaves it in doubt by '// &
            & as_text(maxval(truth%rest/truth%scale), 2)
         call judge_again()
         if (allocated(error) .or. .not. reached%done) exit
      end do

   contains

      !> As long as something helps.
      subroutine go_down()
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
                  call lower_rungs(reached%advice%rungs(i), lower, count)
                  do j = 1, count
                     if ((lower(j)%level < rungs(i)%level .or. lower(j)%segments < rungs(i)%segments) .neqv. k == 1) cycle
                     rungs(i) = lower(j)
                     call try(reached%advice%tolerance)
                     if (allocated(error)) return
                     rungs(i) = reached%advice%rungs(i)
                     if (down) exit
                  end do
                  if (down) exit
               end do
               if (down) exit
               if (k == 1 .and. reached%advice%open_tolerance .and. reached%advice%tolerance < loosest) call try_looser()
               if (down .or. allocated(error)) exit
            end do
            if (allocated(error)) return
         end do
      end subroutine go_down

      !> The setting that is advised keeps the target.
      subroutine keep()
         last = last + 1
         associate (advice => reached%advice)
            if (allocated(kept(last)%rungs)) deallocate (kept(last)%rungs)
            allocate (kept(last)%rungs, source=advice%rungs)
            kept(last)%tolerance = advice%tolerance
            kept(last)%integrator = advice%integrator
         end associate
      end subroutine keep

      !> Whether a second look at the truth may show that a setting that costs much less keeps the target.
      pure logical function look_may_help()
         real(wp) :: less
         less = truth%safety*(maxval(truth%rest/truth%scale) - rest_after_looks(target, truth))
         look_may_help = any(tried(:tries)%in_doubt .and. tried(:tries)%error - less <= target .and. &
            & tried(:tries)%work <= worth_a_look*best%work)
      end function look_may_help

      !> By a sharper truth: the last setting that keeps the target, and those that were in doubt are tried again.
      subroutine judge_again()
         integer :: l
         do l = 1, tries
            if (tried(l)%in_doubt) tried(l)%counts = .false.
            tried(l)%in_doubt = .false.
         end do
         do
            reached%error = error_against(truth, best%samples%values)
            reached%done = reached%error <= target
            if (reached%done .or. last == 0) return
            reached%path = reached%path//newline//'   it shows an error of '//as_text(reached%error, 2)// &
               & ': back to the setting before'
            last = last - 1
            call take_setting(kept(last)%rungs, kept(last)%tolerance, kept(last)%integrator)
            rungs = reached%advice%rungs
            if (reached%advice%integrator == '') then
               call run_again(deck)
            else
               call run_again(implicit_deck)
            end if
            if (allocated(error)) return
         end do
      end subroutine judge_again

      !> Runs the setting that is advised once more.
      subroutine run_again(deck)
         type(deck_type), intent(in) :: deck
         type(trial_type) :: trial
         call run_trial(deck, rungs, reached%advice%tolerance, 1.0_wp, huge(1.0_wp), .false., quiet, &
            & 'once more: '//names(), trial, error)
         if (allocated(error)) return
         call count_run(trial)
         call take_trial(trial, best)
      end subroutine run_again

      subroutine count_run(trial)
         type(trial_type), intent(in) :: trial
         reached%runs = reached%runs + 1
         reached%cpu = reached%cpu + trial%outcome%cpu
         reached%work = reached%work + trial%work
         budget = budget - trial%work
      end subroutine count_run

      !> Advises a setting.
      subroutine take_setting(rungs, tolerance, integrator)
         type(rung_type), intent(in) :: rungs(:)
         real(wp), intent(in) :: tolerance
         character(*), intent(in) :: integrator
         integer :: l
         associate (advice => reached%advice)
            advice%rungs = rungs
            advice%tolerance = tolerance
            advice%integrator = integrator
            do l = 1, size(rungs)
               advice%expected(l) = expected_error(rungs(l), advice%probe%beams(l), advice%probe%duration)
            end do
         end associate
      end subroutine take_setting

      !> A looser tolerance, unless one has been too loose for a rung above already.
      subroutine try_looser()
         real(wp) :: tolerance
         integer :: l
         do l = 1, size(looser)
            tolerance = min(loosest, looser(l)*reached%advice%tolerance)
            if (tolerance > 0.99_wp*too_loose) cycle
            call try(tolerance)
            if (down .or. allocated(error)) return
            too_loose = tolerance
         end do
      end subroutine try_looser

      !> A tighter tolerance: a loose one may excite vibrations that it must follow then, and cost more.
      subroutine try_tighter()
         integer :: l, tried_before
         if (.not. reached%advice%open_tolerance) return
         do l = 1, size(tighter)
            if (tighter(l)*reached%advice%tolerance < least_verified) cycle
            tried_before = tries
            call try(tighter(l)*reached%advice%tolerance)
            if (down .or. allocated(error)) return
            ! That it costs more says nothing of looser ones
            tried(tried_before + 1:tries)%counts = .false.
         end do
      end subroutine try_tighter

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
         allocate (present, source=reached%advice%rungs)
         do m = 1, size(levels)
            do l = 1, size(rungs)
               call bound_rung(rungs(l), levels(m), modes(m))
            end do
            if (sum(cost_of(rungs)) <= much*sum(cost_of(present))) then
               given_up = 0.0_wp
               do l = 1, size(tolerances)
                  before = given_up
                  if (reached%advice%open_tolerance) call try(tolerances(l))
                  if (.not. reached%advice%open_tolerance .and. l == 1) call try(reached%advice%tolerance)
                  if (allocated(error) .or. down) exit
                  if (given_up < min(early, same*before)) exit
               end do
            end if
            if (.not. allocated(error)) rungs = reached%advice%rungs
            if (allocated(error) .or. down) return
         end do
         ! The same rungs: between two tolerances that do may be one that does not, of an explicit integrator at its limit. Then
         ! richer ones: where the tolerance binds, more modes are cheap
         if (.not. reached%advice%open_tolerance) return
         do m = 1, 2
            do l = 1, size(tolerances)
               if (tolerances(l) <= worth(m)*reached%advice%tolerance) exit
               call try(tolerances(l))
               if (allocated(error) .or. down) return
               if (m == 1) too_loose = tolerances(l)
            end do
            if (any(reached%advice%rungs%segments > 1)) exit
            do l = 1, size(rungs)
               if (rungs(l)%level /= level_full .or. .not. can_climb(rungs(l))) cycle
               rungs(l) = better_rung(rungs(l), .false.)
               if (rungs(l)%open_modes) rungs(l)%derivatives = enough_derivatives(rungs(l)%bending)
            end do
            if (any(rungs%segments > 1)) exit
            if (m == 1) too_loose = huge(too_loose)
         end do
         rungs = reached%advice%rungs
      end subroutine start_below

      !> Runs a setting, and takes it if it keeps the target for less; where AUTO chooses ADAMS at a loose tolerance also with
      !> RADAU, which then is often the better of the two.
      subroutine try(tolerance)
         real(wp), intent(in) :: tolerance
         real(wp), parameter :: loose = 0.9e-3_wp
         character(10) :: integrator
         if (reached%advice%integrator /= '') then
            call attempt(implicit_deck, tolerance, integrator)
            return
         end if
         call attempt(deck, tolerance, integrator)
         if (down .or. allocated(error) .or. integrator /= 'ADAMS' .or. .not. reached%advice%open_integrator) return
         if (tolerance < loose) return
         reached%advice%integrator = 'RADAU'
         call attempt(implicit_deck, tolerance, integrator)
         if (.not. down) reached%advice%integrator = ''
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
         name = trim(reached%advice%integrator)//names()
         do j = 1, tries
            if (tried(j)%counts .and. tried(j)%name == name .and. tried(j)%tolerance <= tolerance) return
         end do
         tries = tries + 1
         tried(tries)%name = name
         tried(tries)%tolerance = tolerance
         tried(tries)%counts = .true.
         call run_trial(deck, rungs, tolerance, 1.0_wp, least_patience + 4*best%work, .false., quiet, &
            & 'less: '//name, trial, error, truth%values, target*truth%scale, (1 - saved)*best%work)
         if (allocated(error)) return
         given_up = 1.0_wp
         if (trial%leaves) given_up = (trial%outcome%reached - best%samples%times(1))/reached%advice%probe%duration
         integrator = trial%integrator
         call count_run(trial)
         if (trial%reason /= '' .or. trial%work > (1 - saved)*best%work) return
         if (size(truth%values, 2) /= trial%samples%samples) return
         found = error_against(truth, trial%samples%values)
         if (found > target) then
            tried(tries)%in_doubt = .true.
            tried(tries)%error = found
            tried(tries)%work = trial%work
            return
         end if
         tried(tries)%counts = .false.
         reached%error = found
         call take_setting(rungs, tolerance, reached%advice%integrator//'')
         call keep()
         call take_trial(trial, best)
         reached%path = reached%path//newline//'   it keeps the target with less as well: '
         if (size(rungs) > 0) reached%path = reached%path//names()//', '
         reached%path = reached%path//'TOLERANCE='//as_text(tolerance, 2)//', error '//as_text(found, 2)
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
