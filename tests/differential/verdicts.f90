!> A scene run in several views, and whether all of them tell the same.
module verdicts
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, newline
   use chances, only: pick, between, likely, sow
   use couplings, only: places, angles, accelerations, forces, moments
   use drafts, only: draft_type
   use trials, only: trial_type, try, kinds_of_warnings, patience
   use views, only: view_type, channel_type, rendered, asked, seen_again, of_place, of_change
   implicit none
   private
   public :: verdict_type, plan_type, make_plan, judge, deck_of

   !> Multiple of the tolerance that channels may be off, relative to what they are and how they answer to changes of the scene
   real(wp), parameter :: allowed(5) = [300.0_wp, 300.0_wp, 300.0_wp, 1000.0_wp, 1000.0_wp]
   character(10), parameter :: integrators(5) = [character(10) :: 'ADAMS', 'RADAU', 'AUTO', 'ALPHA', 'CONSERVING']
   !> Relative change of the scene that tells how it answers, and the one beyond which a warning is of no threshold
   real(wp), parameter :: small_change = 1.0e-6_wp, large_change = 3.0e-2_wp
   !> What a channel of each group counts as at least
   real(wp), parameter :: floors(14) = [1.0e-3_wp, 1.0e-3_wp, 1.0e-2_wp, 1.0e-2_wp, 1.0e-3_wp, 1.0e-4_wp, 1.0e-3_wp, 1.0e-2_wp, &
      & 1.0e-6_wp, 1.0e-6_wp, 1.0e3_wp, 1.0e-3_wp, 1.0e-3_wp, 1.0e-3_wp]
   !> The same of accelerations and forces where bodies vibrate
   real(wp), parameter :: elastic_acceleration = 10.0_wp, elastic_force = 1.0_wp, elastic_moment = 0.1_wp
   !> Multiple of an estimated error that a channel may be off
   real(wp), parameter :: multiple_of_estimate = 5.0_wp
   !> Part of the largest of its group that a channel counts as at least
   real(wp), parameter :: part_of_group = 0.05_wp

   !> Views of a scene: the base, the reference at a tighter tolerance, the same of a scene that is changed a little, others
   type :: plan_type
      type(view_type) :: base, reference, changed
      type(view_type), allocatable :: others(:)
   end type plan_type

   !> What came out
   type :: verdict_type
      !> `same`, `refused`, `failed`, `warned` (different, but warned), `estimated` (as different as is
      !> estimated), or else a disagreement: `values`, `status`, `warnings`,
      !> `estimate`, `slow`
      character(10) :: kind = 'same'
      !> View that disagrees, and on what
      character(24) :: view = ''
      character(200) :: what = ''
      !> How far, in units of what is allowed
      real(wp) :: ratio = 0.0_wp
   end type verdict_type

contains

   !> Views for a scene, by chance, from the number of the scene.
   subroutine make_plan(seed, draft, plan)
      integer, intent(in) :: seed
      type(draft_type), intent(in) :: draft
      type(plan_type), intent(out) :: plan
      integer :: first, second, i, n
      type(view_type) :: view
      call sow(seed + 1000003)
      first = pick(5)
      second = 1 + mod(first + pick(2) - 1, 2)
      if (first <= 2) second = 3 - first
      plan%base%integrator = integrators(first)
      plan%base%tolerance = 10.0_wp**(-(5 + pick(3)))
      if (first >= 4) plan%base%tolerance = 10.0_wp**(-(3 + pick(2)))
      plan%reference = plan%base
      plan%reference%name = 'reference'
      plan%reference%integrator = integrators(second)
      plan%reference%tolerance = max(1.0e-10_wp, min(1.0e-8_wp, plan%base%tolerance/100))
      plan%changed = plan%reference
      plan%changed%name = 'changed'
      plan%changed%change = small_change
      allocate (plan%others(0))
      n = 0
      do while (n < 3)
         view = plan%base
         i = pick(9)
         call set_view(i, draft, view)
         if (view%name == 'base') cycle
         if (any(plan%others%name == view%name)) cycle
         plan%others = [plan%others, view]
         n = n + 1
      end do
   end subroutine make_plan

   !> One of the views; `base` if it is none for this scene.
   subroutine set_view(number, draft, view)
      integer, intent(in) :: number
      type(draft_type), intent(in) :: draft
      type(view_type), intent(inout) :: view
      real(wp), parameter :: pi = acos(-1.0_wp)
      real(wp), parameter :: systems(3, 4) = reshape([1.0e-3_wp, 1.0e3_wp, 1.0_wp, 1.0e3_wp, 1.0e3_wp, 1.0e3_wp, &
         & 1.0_wp, 3.28084_wp, 1.0_wp, 10.0_wp, 0.01_wp, 1.0_wp], [3, 4])
      select case (number)
      case (1)
         view%name = 'whole'
         view%eliminated = .false.
      case (2)
         view%name = 'mirror'
         view%side = -1.0_wp
         view%turn = pi
         view%cosine = -1.0_wp
      case (3)
         view%name = 'turn'
         view%turn = between(-3.0_wp, 3.0_wp)
         view%cosine = cos(view%turn)
         view%sine = sin(view%turn)
         if (draft%by_quarters .or. likely(4)) then
            view%turn = pi/2
            view%cosine = 0.0_wp
            view%sine = 1.0_wp
         end if
      case (4)
         view%name = 'move'
         view%moved = [between(-3.0_wp, 3.0_wp), between(-3.0_wp, 3.0_wp)]
         if (likely(4)) view%moved = 100*view%moved
      case (5)
         view%name = 'units'
         view%units = systems(:, pick(size(systems, 2)))
      case (6)
         view%name = 'names'
         view%renamed = .true.
      case (7)
         if (draft%timeless) return
         view%name = 'later'
         view%start = merge(100.0_wp, 3.0_wp, likely(2))
      case (8)
         view%name = 'exchange'
         view%exchanged = .true.
      case (9)
         view%name = 'order'
         view%order = pick(1000)
         view%renamed = likely(2)
      end select
   end subroutine set_view

   !> The deck of a scene in a view.
   function deck_of(draft, view) result(text)
      type(draft_type), intent(in) :: draft
      type(view_type), intent(in) :: view
      character(:), allocatable :: text
      type(view_type) :: now
      integer, allocatable :: order(:)
      integer :: i, k, part, swap
      now = view
      order = [(i, i=1, size(draft%blocks))]
      if (view%order > 0) then
         call sow(view%order)
         do i = size(order), 2, -1
            k = pick(i)
            swap = order(i)
            if (draft%blocks(order(i))%part /= 2 .or. draft%blocks(order(k))%part /= 2) cycle
            order(i) = order(k)
            order(k) = swap
         end do
      end if
      text = ''
      do part = 1, 3
         do i = 1, size(order)
            if (draft%blocks(order(i))%part == part) text = text//rendered(draft%blocks(order(i))%text, now)
         end do
      end do
      text = text//'*OUTPUT'//newline
      do i = 1, size(draft%channels)
         text = text//asked(draft%channels(i), now)
      end do
   end function deck_of

   !> Runs a scene in a view and brings its channels back.
   subroutine run_view(draft, view, trial)
      type(draft_type), intent(in) :: draft
      type(view_type), intent(in) :: view
      type(trial_type), intent(out) :: trial
      integer :: i, row, rows
      call note_view(view)
      call try(deck_of(draft, view), trial)
      row = 1
      if (.not. allocated(trial%values)) return
      if (size(trial%values) == 0) return
      do i = 1, size(draft%channels)
         rows = merge(2, 1, allocated(draft%channels(i)%second))
         call seen_again(draft%channels(i), view, trial%values(row:row + rows - 1, :))
         row = row + rows
      end do
      if (size(trial%modes) > 0) then
         trial%modes(1, :) = trial%modes(1, :)*view%units(3)
      end if
   end subroutine run_view

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
      type(trial_type) :: base, reference, changed, other
      real(wp), allocatable :: scale(:)
      integer :: i
      call run_view(draft, plan%base, base)
      call run_view(draft, plan%reference, reference)
      if (base%status == 2) then
         verdict%kind = 'refused'
         verdict%what = first_words(base%message)
         if (reference%status /= 2) call disagree('status', plan%reference%name, 'the base is refused: '//base%message)
      else if (is_slow(base)) then
         if (.not. is_slow(reference)) call disagree('slow', 'base', first_words(base%message))
         if (verdict%kind == 'same') verdict%kind = 'failed'
         return
      else if (is_slow(reference)) then
         verdict%kind = 'failed'
         verdict%what = 'the reference takes too long'
         return
      else if (base%status /= 0 .and. reference%status /= 0) then
         verdict%kind = 'failed'
         verdict%what = first_words(base%message)
      else if (base%status /= reference%status) then
         call disagree('status', plan%reference%name, trim(as_text(base%status))//', reference '//as_text(reference%status)// &
            & ': '//base%message//reference%message)
      end if
      if (verdict%kind == 'status') return
      if (base%status == 0) then
         call run_view(draft, plan%changed, changed)
         call find_scales(draft, reference, changed, scale)
         call compare(draft, plan%base, base, reference, scale, 'base', base, verdict)
         if (verdict%kind == 'values') call look_at_estimate(draft, plan%base, reference, scale, verdict)
         if (is_disagreement(verdict)) return
      end if
      do i = 1, size(plan%others)
         if (is_disagreement(verdict)) return
         call run_view(draft, plan%others(i), other)
         if (other%status /= base%status) then
            if (is_slow(other)) then
               call disagree('slow', plan%others(i)%name, first_words(other%message))
            else
               call disagree('status', plan%others(i)%name, as_text(other%status)//', base '//as_text(base%status)//': '// &
                  & other%message//base%message)
            end if
            return
         end if
         if (base%status /= 0) cycle
         call compare(draft, plan%others(i), other, reference, scale, plan%others(i)%name, base, verdict)
         if (verdict%kind == 'values') call look_at_estimate(draft, plan%others(i), reference, scale, verdict)
         if (is_disagreement(verdict)) return
         call compare_warnings(plan%others(i)%name)
      end do

   contains

      subroutine disagree(kind, view, what)
         character(*), intent(in) :: kind, view, what
         verdict%kind = kind
         verdict%view = view
         verdict%what = first_words(what)
         verdict%ratio = 1.0_wp
      end subroutine disagree

      !> Warnings of a view that the base has not, or the other way round, unless a changed scene is on the other side too.
      subroutine compare_warnings(name)
         character(*), intent(in) :: name
         type(trial_type) :: moved
         type(view_type) :: view
         if (kinds_of_warnings(other%warnings) == kinds_of_warnings(base%warnings)) return
         view = plan%base
         view%change = large_change
         call run_view(draft, view, moved)
         if (kinds_of_warnings(moved%warnings) /= kinds_of_warnings(base%warnings)) return
         call disagree('warnings', name, odd_line(kinds_of_warnings(other%warnings), kinds_of_warnings(base%warnings)))
      end subroutine compare_warnings

   end subroutine judge

   pure logical function is_slow(trial)
      type(trial_type), intent(in) :: trial
      is_slow = trial%status == 3 .and. index(trial%message, 'given up after') > 0
   end function is_slow

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

   !> The first line of one of two lists that the other has not.
   pure function odd_line(a, b) result(line)
      character(*), intent(in) :: a, b
      character(:), allocatable :: line
      integer :: first, last
      line = ''
      first = 2
      do while (first <= len(a))
         last = first + index(a(first:), newline) - 2
         if (index(b, newline//a(first:last)//newline) == 0) line = 'more: '//a(first:last)
         first = last + 2
      end do
      first = 2
      do while (first <= len(b) .and. line == '')
         last = first + index(b(first:), newline) - 2
         if (index(a, newline//b(first:last)//newline) == 0) line = 'fewer: '//b(first:last)
         first = last + 2
      end do
   end function odd_line

   !> What errors of each channel are relative to: its size, a part of that of its group, and its answer to a change.
   subroutine find_scales(draft, reference, changed, scale)
      type(draft_type), intent(in) :: draft
      type(trial_type), intent(in) :: reference, changed
      real(wp), allocatable, intent(out) :: scale(:)
      real(wp) :: largest(size(floors)), lowest(size(floors))
      integer, allocatable :: group(:)
      integer :: i, row, k
      logical :: answers
      allocate (scale(size(reference%values, 1)), group(size(reference%values, 1)))
      largest = 0.0_wp
      row = 0
      do i = 1, size(draft%channels)
         do k = 1, merge(2, 1, allocated(draft%channels(i)%second))
            row = row + 1
            group(row) = draft%channels(i)%group
            associate (values => reference%values(row, :))
               if (size(values) == 0) cycle
               scale(row) = maxval(abs(values))
               if (any(group(row) == [places, angles])) scale(row) = maxval(abs(values - values(1)))
            end associate
            largest(group(row)) = max(largest(group(row)), scale(row))
         end do
      end do
      lowest = floors
      if (draft%elastic) lowest(accelerations) = elastic_acceleration
      if (draft%elastic) lowest(forces) = elastic_force
      if (draft%elastic) lowest(moments) = elastic_moment
      answers = changed%status == 0 .and. all(shape(changed%values) == shape(reference%values))
      do row = 1, size(scale)
         scale(row) = max(scale(row), part_of_group*largest(group(row)), lowest(group(row)))
         if (answers) scale(row) = scale(row) + maxval(abs(changed%values(row, :) - reference%values(row, :)))/small_change
      end do
   end subroutine find_scales

   !> Compares a run with the reference.
   subroutine compare(draft, view, trial, reference, scale, name, base, verdict)
      type(draft_type), intent(in) :: draft
      type(view_type), intent(in) :: view
      type(trial_type), intent(in) :: trial, reference, base
      real(wp), intent(in) :: scale(:)
      character(*), intent(in) :: name
      type(verdict_type), intent(inout) :: verdict
      real(wp) :: ratio, error, limit
      integer :: i, k, row, at
      row = 0
      if (any(shape(trial%values) /= shape(reference%values))) then
         verdict%kind = 'values'
         verdict%view = name
         verdict%what = 'another number of samples'
         return
      end if
      limit = view%tolerance*allowed(findloc_of(view%integrator))
      do i = 1, size(draft%channels)
         do k = 1, merge(2, 1, allocated(draft%channels(i)%second))
            row = row + 1
            if (draft%channels(i)%placed .and. any(abs(view%moved) > 0.0_wp)) cycle
            error = maxval(abs(trial%values(row, :) - reference%values(row, :)))
            if (.not. scale(row) > 0.0_wp) cycle
            ratio = error/(scale(row)*limit)
            if (ratio > verdict%ratio) then
               verdict%ratio = ratio
               at = maxloc(abs(trial%values(row, :) - reference%values(row, :)), 1)
               if (ratio > 1.0_wp) then
                  verdict%kind = 'values'
                  verdict%view = name
                  verdict%what = trim(view%integrator)//' '//draft%channels(i)%first//' sample '//as_text(at)//': '// &
                     & as_text(trial%values(row, at), 6)//' for '//as_text(reference%values(row, at), 6)//', scale '// &
                     & as_text(scale(row), 3)
               end if
            end if
         end do
      end do
      call compare_modes()
      if (verdict%kind == 'values') then
         if (trial%warnings /= '' .and. (trial%warnings /= base%warnings .or. name == 'base')) verdict%kind = 'warned'
         if (index(trial%warnings, 'TOLERANCE') > 0 .or. index(trial%warnings, 'tolerance') > 0) verdict%kind = 'warned'
         if (verdict%kind == 'warned') verdict%ratio = 0.0_wp
      end if

   contains

      subroutine compare_modes()
         real(wp) :: largest
         integer :: m
         if (size(trial%modes, 2) /= size(reference%modes, 2)) then
            verdict%kind = 'values'
            verdict%view = name
            verdict%what = 'another number of modes'
            return
         end if
         if (size(trial%modes, 2) == 0) return
         largest = maxval(reference%modes(1, :)**2)
         do m = 1, size(trial%modes, 2)
            ratio = abs(trial%modes(1, m)**2 - reference%modes(1, m)**2)/(1.0e-5_wp*largest)
            if (ratio > max(1.0_wp, verdict%ratio)) then
               verdict%kind = 'values'
               verdict%view = name
               verdict%ratio = ratio
               verdict%what = 'frequency '//as_text(m)//': '//as_text(trial%modes(1, m), 8)//' for '// &
                  & as_text(reference%modes(1, m), 8)
            end if
         end do
      end subroutine compare_modes

   end subroutine compare

   !> Whether limber's own estimate of the errors says as much; the verdict is `estimated` then.
   subroutine look_at_estimate(draft, view, reference, scale, verdict)
      type(draft_type), intent(in) :: draft
      type(view_type), intent(in) :: view
      type(trial_type), intent(in) :: reference
      real(wp), intent(in) :: scale(:)
      type(verdict_type), intent(inout) :: verdict
      type(view_type) :: asking
      type(trial_type) :: trial
      integer :: row
      if (draft%timeless) return
      asking = view
      asking%estimated = .true.
      call run_view(draft, asking, trial)
      if (.not. allocated(trial%errors)) return
      do row = 1, size(scale)
         if (is_placed(row) .and. any(abs(view%moved) > 0.0_wp)) cycle
         if (maxval(abs(trial%values(row, :) - reference%values(row, :))) > view%tolerance*allowed(findloc_of(view%integrator)) &
            & *scale(row) + multiple_of_estimate*maxval(estimate_of(row))) return
      end do
      verdict%kind = 'estimated'
      verdict%ratio = 0.0_wp

   contains

      !> Whether a channel depends on the place of the origin.
      pure logical function is_placed(row)
         integer, intent(in) :: row
         integer :: i, at
         at = 0
         is_placed = .false.
         do i = 1, size(draft%channels)
            at = at + merge(2, 1, allocated(draft%channels(i)%second))
            if (row > at) cycle
            is_placed = draft%channels(i)%placed
            return
         end do
      end function is_placed

      !> Estimates are in the units of the view; those of places and vectors may be either component's.
      pure function estimate_of(row) result(errors)
         integer, intent(in) :: row
         real(wp) :: errors(size(trial%errors, 2))
         integer :: i, at
         at = 0
         errors = 0.0_wp
         do i = 1, size(draft%channels)
            if (allocated(draft%channels(i)%second)) then
               if (row <= at + 2) errors = max(trial%errors(at + 1, :), trial%errors(at + 2, :))
               at = at + 2
            else
               at = at + 1
               if (row <= at) errors = trial%errors(at, :)
            end if
            if (row <= at) exit
         end do
         errors = errors/product(view%units**draft%channels(i)%dimension)
      end function estimate_of

   end subroutine look_at_estimate

   pure integer function findloc_of(integrator) result(number)
      character(*), intent(in) :: integrator
      do number = 1, size(integrators) - 1
         if (integrators(number) == integrator) return
      end do
   end function findloc_of

end module verdicts
