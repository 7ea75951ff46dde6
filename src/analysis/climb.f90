!> Up the ladder towards a target: where a run is outside the range of its models, where its verification shows too large an error,
!> and where it fails. Floor: analysis. Equations: doc/theory.md, accuracy on request.
module limber_analysis_climb
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, newline
   use limber_analysis_advice, only: find_floors, floor_of, expected_error, cost_of, take_measured, divide_beam
   use limber_analysis_indicators, only: indicator_names
   use limber_analysis_reached, only: reached_type
   use limber_analysis_rungs, only: rung_type, better_rung, in_pieces, can_climb, rung_name, rest_beyond, all_derivatives, &
      & level_full
   use limber_analysis_shares, only: part_model, part_time, no_matter
   use limber_analysis_trial, only: trial_type
   use limber_analysis_truth, only: truth_type
   use limber_analysis_verification, only: least_verified, widening, unseen
   use limber_deck_content, only: deck_type
   implicit none
   private
   public :: take_seen, climb, climb_all, look_back

   !> Part of an error that is left when a richer basis does not help
   real(wp), parameter :: stalled = 0.7_wp
   !> Expected error in units of the target beyond which a model is not verified, and error of deflections at the limit of a range
   real(wp), parameter :: hopeless = 5.0_wp, at_limit = 0.03_wp

contains

   !> Puts what a run has shown in place of what the probe expected; climbs at once where the model of a beam is so far outside its
   !> range that there is no use in verifying it, eqs. (183), (184).
   subroutine take_seen(deck, target, trial, reached, climbed)
      type(deck_type), intent(in) :: deck
      real(wp), intent(in) :: target
      type(trial_type), intent(in) :: trial
      type(reached_type), intent(inout) :: reached
      logical, intent(out) :: climbed
      real(wp) :: outside
      integer :: i
      climbed = .false.
      associate (advice => reached%advice)
         do i = 1, size(advice%rungs)
            if (trial%slope(i) >= 0.0_wp) call take_measured(advice, i, trial%slope(i), trial%deflection(i), trial%at_rest(i))
         end do
         call find_floors(advice)
         do i = 1, size(advice%rungs)
            if (trial%slope(i) < 0.0_wp .or. .not. can_climb(advice%rungs(i))) cycle
            outside = 0.0_wp
            if (trial%excess(i) > 1.0_wp) outside = at_limit*advice%probe%beams(i)%effect*trial%excess(i)
            if (advice%rungs(i)%level == level_full .and. .not. (advice%rungs(i)%open_segments .or. advice%rungs(i)%at_rest)) cycle
            if (trial%at_rest(i) > target) then
               call go_up(i, 'left out axial vibrations that make an error of '//as_text(trial%at_rest(i), 2))
            else if (advice%expected(i) > hopeless*target) then
               call go_up(i, 'reached slopes of '//as_text(trial%slope(i), 2)//', where an error of '// &
                  & as_text(advice%expected(i), 2)//' is expected')
            else if (outside > hopeless*target) then
               call go_up(i, 'left its range ('//trim(indicator_names(trial%kind(i)))//', '//as_text(trial%excess(i), 2)// &
                  & ' times its limit)')
            end if
         end do
      end associate

   contains

      subroutine go_up(i, why)
         integer, intent(in) :: i
         character(*), intent(in) :: why
         associate (rung => reached%advice%rungs(i))
            reached%path = reached%path//newline//"   beam '"//deck%blocks(rung%block)%name()//"' as "//rung_name(rung)//' '//why
            if (rung%level == level_full .and. rung%open_segments) then
               call divide_beam(reached%advice, i)
            else
               rung = better_rung(rung, .false.)
            end if
         end associate
         call arrive(reached, i)
         climbed = .true.
      end subroutine go_up

   end subroutine take_seen

   !> Goes up where the verification shows too large a part.
   subroutine climb(deck, target, truth, reached, climbed)
      type(deck_type), intent(in) :: deck
      real(wp), intent(in) :: target
      !> What the run was compared with
      type(truth_type), intent(in) :: truth
      type(reached_type), intent(inout) :: reached
      logical, intent(out) :: climbed
      real(wp) :: share, worst
      integer :: i
      climbed = .false.
      associate (advice => reached%advice)
         ! One frame is not enough, and more than one is not limber's to choose: nothing helps
         if (any(advice%floor > target .and. .not. advice%rungs%open_segments)) return
         if (reached%reason == '' .and. widening*reached%of_time > part_time*target .and. advice%open_tolerance) &
            & call tighten(min(0.5_wp, max(0.02_wp, 0.5_wp*part_time*target/reached%of_time)))
         share = part_model*target/max(1, count(reached%of_beam > no_matter*target))
         worst = maxval([0.0_wp, reached%of_beam])
         do i = 1, size(advice%rungs)
            if (.not. can_climb(advice%rungs(i))) cycle
            ! More coordinates in one frame do not help
            if (one_frame_is_not_enough(i) .and. .not. advice%rungs(i)%open_segments) cycle
            if (widening*reached%of_beam(i) > share) then
               call raise_beam(i)
            else if (.not. climbed .and. reached%of_beam(i) >= worst .and. worst > 0.0_wp) then
               call raise_beam(i)
            end if
         end do
         if (.not. climbed .and. advice%open_tolerance .and. reached%of_time > 0.1_wp*target) call tighten(0.2_wp)
      end associate

   contains

      subroutine tighten(factor)
         real(wp), intent(in) :: factor
         if (reached%advice%tolerance <= least_verified) return
         reached%advice%tolerance = max(least_verified, factor*reached%advice%tolerance)
         reached%path = reached%path//newline//'   the integration had an error of '//as_text(reached%of_time, 2)// &
            & ': TOLERANCE='//as_text(reached%advice%tolerance, 2)
         climbed = .true.
      end subroutine tighten

      !> Whether what FULL leaves out in one frame takes too much of the target.
      pure logical function one_frame_is_not_enough(i)
         integer, intent(in) :: i
         one_frame_is_not_enough = reached%advice%floor(i) > 0.5_wp*target
      end function one_frame_is_not_enough

      subroutine raise_beam(i)
         integer, intent(in) :: i
         integer :: k, from
         logical :: may_lock
         reached%path = reached%path//newline//"   beam '"//deck%blocks(reached%advice%rungs(i)%block)%name()// &
            & "' as "//rung_name(reached%advice%rungs(i))
         if (reached%of_beam(i) < 1.0e3_wp) then
            reached%path = reached%path//' had an error of '//as_text(reached%of_beam(i), 2)
         else
            reached%path = reached%path//' could not be verified'
         end if
         associate (rung => reached%advice%rungs(i))
            if (rung%segments == 1 .and. rung%open_segments .and. (one_frame_is_not_enough(i) .or. stalls(i))) then
               call divide(i)
            else if (rung%segments > 1 .and. one_frame_is_not_enough(i)) then
               rung = better_rung(rung, .true.)
            else
               ! Errors fall with the third power of the modes at least, if nothing locks
               from = rung%bending
               may_lock = rung%level == level_full .and. rung%derivatives < all_derivatives(rung)
               do k = 1, 3
                  reached%before(i) = merge(reached%of_beam(i), 0.0_wp, rung%level == level_full)
                  rung = better_rung(rung, .false.)
                  if (may_lock .or. rung%level < level_full .or. .not. can_climb(rung) .or. rung%segments > 1) exit
                  if ((real(from, wp)/rung%bending)**3*reached%of_beam(i) < share) exit
               end do
            end if
            ! Elements cost nothing in the time loop, and part of the error may be that of the lumped masses
            if (.not. rung%given_elements .and. truth%rungs(i)%segments == 1) &
               & rung%elements = max(rung%elements, truth%rungs(i)%elements)
         end associate
         call arrive(reached, i)
         climbed = .true.
      end subroutine raise_beam

      !> Divides a beam: into the pieces of the check if these are known to do and cost not much more than those that are
      !> expected to.
      subroutine divide(i)
         integer, intent(in) :: i
         real(wp), parameter :: dearer = 3.0_wp
         type(rung_type) :: rung
         rung = reached%advice%rungs(i)
         call divide_beam(reached%advice, i)
         if (truth%rungs(i)%segments == 1 .or. reached%of_beam(i) > 1.0e3_wp) return
         if (cost_of(truth%rungs(i)) > dearer*cost_of(reached%advice%rungs(i))) return
         if (floor_of(truth%rungs(i), reached%advice%probe%beams(i)) > unseen*target) return
         if (rest_beyond(rung, truth%rungs(i))*reached%of_beam(i) > share) return
         rung%elements = reached%advice%rungs(i)%elements
         reached%advice%rungs(i) = in_pieces(rung, truth%rungs(i)%segments, truth%rungs(i)%bending)
      end subroutine divide

      !> Whether a richer basis has not helped the last time.
      pure logical function stalls(i)
         integer, intent(in) :: i
         stalls = reached%before(i) > 0.0_wp .and. reached%of_beam(i) > stalled*reached%before(i) .and. &
            & reached%advice%floor(i) > 0.1_wp*target
      end function stalls

   end subroutine climb

   !> Two runs that agree may both miss what a finer run of an earlier pair has met: then a smaller tolerance decides, eq. (T7).
   subroutine look_back(target, truth, reached, again)
      real(wp), intent(in) :: target
      type(truth_type), intent(in) :: truth
      !> With a target that is kept
      type(reached_type), intent(inout) :: reached
      !> Whether it is to be run at a smaller tolerance
      logical, intent(out) :: again
      !> Most of such looks, and what the tolerance is multiplied by
      integer, parameter :: most_looks = 2
      real(wp), parameter :: smaller = 0.1_wp
      associate (advice => reached%advice, shown => reached%shown)
         again = advice%open_tolerance .and. advice%tolerance > least_verified .and. shown%looks < most_looks
         if (again) again = shown%is_forgotten(advice%rungs, truth%finest, truth%scale, target)
         if (.not. again) return
         shown%looks = shown%looks + 1
         advice%tolerance = max(least_verified, smaller*advice%tolerance)
         reached%path = reached%path//newline//'   a finer run had shown a difference of '//as_text(shown%difference, 2)// &
            & ' that these two do not: TOLERANCE='//as_text(advice%tolerance, 2)
         reached%done = .false.
      end associate
   end subroutine look_back

   !> A beam is on its new rung, and is to be verified there in any case.
   subroutine arrive(reached, i)
      type(reached_type), intent(inout) :: reached
      integer, intent(in) :: i
      associate (advice => reached%advice)
         reached%path = reached%path//': '//rung_name(advice%rungs(i))
         advice%expected(i) = max(advice%share, expected_error(advice%rungs(i), advice%probe%beams(i), advice%probe%duration))
      end associate
   end subroutine arrive

   !> Goes up with all beams, for a run has failed.
   subroutine climb_all(deck, reached, climbed)
      type(deck_type), intent(in) :: deck
      type(reached_type), intent(inout) :: reached
      logical, intent(out) :: climbed
      integer :: i
      climbed = .false.
      do i = 1, size(reached%advice%rungs)
         if (.not. can_climb(reached%advice%rungs(i))) cycle
         reached%path = reached%path//newline//"   beam '"//deck%blocks(reached%advice%rungs(i)%block)%name()//"' as "// &
            & rung_name(reached%advice%rungs(i))//' failed: '
         reached%advice%rungs(i) = better_rung(reached%advice%rungs(i), reached%advice%rungs(i)%level == level_full)
         reached%path = reached%path//rung_name(reached%advice%rungs(i))
         climbed = .true.
      end do
   end subroutine climb_all

end module limber_analysis_climb
