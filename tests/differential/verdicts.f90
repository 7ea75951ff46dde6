!> A scene run in several views, and whether all of them tell the same.
module verdicts
   use limber_base_kinds, only: wp
   use, intrinsic :: iso_fortran_env, only: output_unit
   use limber_base_text, only: as_text, newline
   use comparisons, only: verdict_type, scales_type, find_scales, compare, allowed_by
   use drafts, only: draft_type
   use pardons, only: drawn_words, without_near_ones, is_of_run, tells_of_vibrations
   use plans, only: plan_type, deck_of, large_change
   use trials, only: candidate_type, try, kinds_of_warnings, patience
   use views, only: view_type, seen_again
   implicit none
   private
   public :: judge, run_view, note_view, bring_back, is_slow, first_words

   !> Whether each run says how it ended, and what it warns of
   logical, public :: talks = .false.

   !> Multiple of an estimated error that a channel may be off
   real(wp), parameter :: multiple_of_estimate = 5.0_wp
   !> Part of the patience that a run may take if its other views must not take longer
   real(wp), parameter :: nearly_slow = 0.3_wp
   !> Part of it that a run by another integrator at a tighter tolerance takes where the patience must be enough
   real(wp), parameter :: quick = 0.1_wp

contains

   !> Runs a scene in a view and brings its channels back.
   subroutine run_view(draft, view, trial)
      type(draft_type), intent(in) :: draft
      type(view_type), intent(in) :: view
      type(candidate_type), intent(out) :: trial
      call note_view(view)
      call try(deck_of(draft, view), trial)
      if (talks) then
         write (output_unit, '(a)') '-- '//trim(view%name)//', '//trim(view%integrator)//': status '//as_text(trial%status)// &
            & ', '//as_text(trial%cpu, 2)//' s '//trial%message//newline//trial%warnings
         flush (output_unit)
      end if
      call bring_back(draft, view, trial)
   end subroutine run_view

   !> Brings the channels of a run back from its view.
   subroutine bring_back(draft, view, trial)
      type(draft_type), intent(in) :: draft
      type(view_type), intent(in) :: view
      type(candidate_type), intent(inout) :: trial
      integer :: i, row, rows
      row = 1
      if (.not. allocated(trial%values)) return
      if (size(trial%values) == 0) return
      do i = 1, size(draft%channels)
         rows = merge(2, 1, allocated(draft%channels(i)%second))
         call seen_again(draft%channels(i), view, trial%values(row:row + rows - 1, :))
         row = row + rows
      end do
      trial%envelope(:2) = trial%envelope(:2)/product(view%units**[1, 1, -2])
      trial%envelope(3) = trial%envelope(3)/product(view%units**[1, 2, -2])
      if (size(trial%modes) > 0) then
         trial%modes(1, :) = trial%modes(1, :)*view%units(3)
      end if
   end subroutine bring_back

   !> Leaves the name of the view that runs in a file, for what ends without a word.
   subroutine note_view(view)
      type(view_type), intent(in) :: view
      integer :: unit
      open (newunit=unit, file='differential.view', status='replace', action='write')
      write (unit, '(a)') trim(view%name)
      close (unit)
   end subroutine note_view

   !> Runs all views of a plan.
   subroutine judge(draft, plan, verdict)
      type(draft_type), intent(in) :: draft
      type(plan_type), intent(in) :: plan
      type(verdict_type), intent(out) :: verdict
      type(candidate_type) :: base, reference, changed, other
      type(scales_type) :: scales
      integer :: i
      call run_view(draft, plan%base, base)
      call run_view(draft, plan%reference, reference)
      if (base%status == 2) then
         verdict%kind = 'refused'
         verdict%what = first_words(base%message)
         if (reference%status /= 2) call disagree('status', plan%reference%name, 'the base is refused: '//base%message)
      else if (is_slow(base)) then
         ! A run that says why it is slow, and what would be quick, has said enough
         verdict%kind = 'failed'
         verdict%what = 'the base takes too long'
         if (reference%cpu < quick*patience .and. index(base%warnings, 'is bound to steps of') == 0) &
            & call disagree('slow', 'base', first_words(base%message))
         return
      else if (is_slow(reference)) then
         verdict%kind = 'failed'
         verdict%what = 'the reference takes too long'
         return
      else if (base%status /= 0 .and. reference%status /= 0) then
         verdict%kind = 'failed'
         verdict%what = first_words(base%message)
      else if (base%status /= reference%status .and. (is_singular(base) .or. is_singular(reference))) then
         verdict%kind = 'failed'
         verdict%what = first_words(base%message//reference%message)
         return
      else if (base%status /= reference%status) then
         call disagree('status', plan%reference%name, trim(as_text(base%status))//', reference '//as_text(reference%status)// &
            & ': '//base%message//reference%message)
      end if
      if (verdict%kind == 'status') return
      if (base%status == 0) then
         call run_view(draft, plan%changed, changed)
         call find_scales(draft, reference, changed, scales)
         call compare(draft, plan%base, base, reference, scales, 'base', verdict)
         if (verdict%kind == 'values') call look_at_estimate(draft, plan, plan%base, reference, scales, verdict)
         if (is_disagreement(verdict)) return
      end if
      do i = 1, size(plan%others)
         if (is_disagreement(verdict)) return
         call run_view(draft, plan%others(i), other)
         if (other%status /= base%status) then
            if (is_slow(other)) then
               if (base%cpu > nearly_slow*patience) verdict%kind = 'failed'
               if (base%cpu <= nearly_slow*patience) call disagree('slow', plan%others(i)%name, first_words(other%message))
            else if (is_singular(other) .or. is_singular(base)) then
               verdict%kind = 'failed'
               verdict%what = first_words(other%message//base%message)
            else
               call disagree('status', plan%others(i)%name, as_text(other%status)//', base '//as_text(base%status)//': '// &
                  & other%message//base%message)
            end if
            return
         end if
         if (base%status /= 0) cycle
         call compare(draft, plan%others(i), other, reference, scales, plan%others(i)%name, verdict)
         if (verdict%kind == 'values') call look_at_estimate(draft, plan, plan%others(i), reference, scales, verdict)
         if (is_disagreement(verdict)) return
         ! A run that is as wrong as it says has warnings of its own
         if (verdict%kind == 'warned' .and. verdict%view == plan%others(i)%name) cycle
         call compare_warnings(plan%others(i))
      end do

   contains

      subroutine disagree(kind, view, what)
         character(*), intent(in) :: kind, view, what
         verdict%kind = kind
         verdict%view = view
         verdict%what = first_words(what)
         verdict%ratio = 1.0_wp
      end subroutine disagree

      !> Warnings of a view that the base has not, or the other way round, unless a changed scene is on the other side too. A
      !> warning of one run may be missing in another whose numbers are right without it, or which tells of vibrations in the words
      !> of another integrator: AUTO may choose one in a view and another in the next.
      subroutine compare_warnings(view)
         type(view_type), intent(in) :: view
         character(:), allocatable :: more, fewer
         type(candidate_type) :: moved
         type(view_type) :: near_by
         integer :: sign
         more = missing_line(scales%idle, other, base)
         fewer = missing_line(scales%idle, base, other)
         if (is_of_run(more, other%warnings)) then
            if (tells_of_vibrations(base%warnings)) more = ''
            if (more /= '') then
               if (is_right(plan%base, base)) more = ''
            end if
         end if
         if (is_of_run(fewer, base%warnings)) then
            if (tells_of_vibrations(other%warnings)) fewer = ''
            if (fewer /= '') then
               if (is_right(view, other)) fewer = ''
            end if
         end if
         ! What bending draws in is told of channels along the axes of space, which a turned scene has along others
         if (abs(view%turn) > 0.0_wp) then
            if (index(more, drawn_words) > 0) more = ''
            if (index(fewer, drawn_words) > 0) fewer = ''
         end if
         if (more == '' .and. fewer == '') return
         do sign = -1, 1, 2
            near_by = plan%base
            near_by%change = sign*large_change
            call run_view(draft, near_by, moved)
            if (more /= '' .and. missing_line(scales%idle, other, moved) == '') return
            if (fewer /= '' .and. missing_line(scales%idle, moved, other) == '') return
         end do
         if (more /= '') call disagree('warnings', view%name, 'more: '//more)
         if (more == '') call disagree('warnings', view%name, 'fewer: '//fewer)
      end subroutine compare_warnings

      !> Whether a run agrees with the reference with no warning of either to excuse it.
      logical function is_right(view, trial)
         type(view_type), intent(in) :: view
         type(candidate_type), intent(in) :: trial
         type(candidate_type) :: alone, exact
         type(verdict_type) :: own
         alone = trial
         alone%warnings = ''
         exact = reference
         exact%warnings = ''
         call compare(draft, view, alone, exact, scales, view%name, own)
         is_right = own%kind == 'same'
      end function is_right

   end subroutine judge

   pure logical function is_slow(trial)
      type(candidate_type), intent(in) :: trial
      is_slow = trial%status == 3 .and. index(trial%message, 'given up after') > 0
   end function is_slow

   !> Whether a run has failed at a place where constraints have no grip, and says so: others may pass it, by luck or by a fold.
   pure logical function is_singular(trial)
      type(candidate_type), intent(in) :: trial
      is_singular = trial%status == 3 .and. index(trial%message, 'lose their grip') > 0
   end function is_singular

   pure logical function is_disagreement(verdict)
      type(verdict_type), intent(in) :: verdict
      is_disagreement = all(verdict%kind /= [character(10) :: 'same', 'refused', 'failed', 'warned', 'estimated'])
   end function is_disagreement

   !> A message in one line.
   pure function first_words(text) result(out)
      character(*), intent(in) :: text
      character(:), allocatable :: out
      integer :: i
      out = text(:min(200, len(text)))
      do i = 1, len(out)
         if (out(i:i) == newline) out(i:i) = '/'
      end do
   end function first_words

   !> The first kind of warning that a run has, plainly, not near its threshold, and another one not at all; empty if there is none.
   function missing_line(idle, run, other) result(line)
      !> Whether nothing moves, or nothing is loaded
      logical, intent(in) :: idle
      type(candidate_type), intent(in) :: run, other
      character(:), allocatable :: line, kinds, others
      integer :: first, last
      kinds = kinds_of_warnings(without_near_ones(run%plain_warnings, idle))
      others = kinds_of_warnings(other%warnings)
      line = ''
      first = 2
      do while (first <= len(kinds))
         last = first + index(kinds(first:), newline) - 2
         if (index(others, newline//kinds(first:last)//newline) == 0) line = kinds(first:last)
         if (line /= '') return
         first = last + 2
      end do
   end function missing_line

   !> Whether limber's own estimates of the errors say as much, of the view and of the reference, whose tolerance may ask for more
   !> than round-off leaves; the verdict is `estimated` then.
   subroutine look_at_estimate(draft, plan, view, reference, scales, verdict)
      type(draft_type), intent(in) :: draft
      type(plan_type), intent(in) :: plan
      type(view_type), intent(in) :: view
      type(candidate_type), intent(in) :: reference
      type(scales_type), intent(in) :: scales
      type(verdict_type), intent(inout) :: verdict
      type(candidate_type) :: trial
      real(wp) :: estimate(size(scales%own)), doubt(size(scales%own)), difference
      integer :: i, row
      if (draft%timeless) return
      call find_estimates(draft, plan%reference, trial, doubt)
      call find_estimates(draft, view, trial, estimate)
      if (any(shape(trial%values) /= shape(reference%values))) return
      row = 0
      do i = 1, size(draft%channels)
         do row = row + 1, row + merge(2, 1, allocated(draft%channels(i)%second))
            if (draft%channels(i)%placed .and. any(abs(view%moved) > 0.0_wp)) cycle
            difference = maxval(abs(trial%values(row, :) - reference%values(row, :)))
            if (difference > allowed_by(view)*scales%own(row) + multiple_of_estimate*(estimate(row) + doubt(row))) return
         end do
         row = row - 1
      end do
      verdict%kind = 'estimated'
      verdict%ratio = 0.0_wp
   end subroutine look_at_estimate

   !> Runs a view with an estimate of its errors; the largest of each channel, in the units of the scene itself. Those of places and
   !> vectors may be either component's.
   subroutine find_estimates(draft, view, trial, errors)
      type(draft_type), intent(in) :: draft
      type(view_type), intent(in) :: view
      type(candidate_type), intent(out) :: trial
      !> (channels); 0 if there are none
      real(wp), intent(out) :: errors(:)
      type(view_type) :: asking
      integer :: i, row, rows
      asking = view
      asking%estimated = .true.
      call run_view(draft, asking, trial)
      errors = 0.0_wp
      if (.not. allocated(trial%errors)) return
      row = 1
      do i = 1, size(draft%channels)
         rows = merge(2, 1, allocated(draft%channels(i)%second))
         errors(row:row + rows - 1) = maxval(trial%errors(row:row + rows - 1, :))/product(view%units**draft%channels(i)%dimension)
         row = row + rows
      end do
   end subroutine find_estimates

end module verdicts
