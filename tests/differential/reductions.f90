!> Scenes that are judged apart from this process, and made smaller as long as they disagree.
module reductions
   use, intrinsic :: iso_c_binding, only: c_int, c_long, c_ptr, c_null_ptr
   use, intrinsic :: iso_fortran_env, only: output_unit
   use limber_base_kinds, only: wp
   use limber_base_process, only: start_copy, end_copy
   use limber_base_text, only: as_text, newline
   use drafts, only: draft_type
   use comparisons, only: verdict_type
   use plans, only: plan_type, deck_of
   use promises, only: judge_promise
   use verdicts, only: judge
   use views, only: mentions, view_type
   implicit none
   private
   public :: judge_apart, reduce, line_of

   !> CPU seconds for all views of a scene
   integer, public :: patience_for_all = 90

   interface
      integer(c_int) function c_set_timer(which, value, old) bind(c, name='setitimer')
         import :: c_int, c_long, c_ptr
         integer(c_int), value :: which
         integer(c_long), intent(in) :: value(4)
         type(c_ptr), value :: old
      end function c_set_timer
      integer(c_int) function c_waitpid(number, status, options) bind(c, name='waitpid')
         import :: c_int
         integer(c_int), value :: number
         integer(c_int), intent(out) :: status
         integer(c_int), value :: options
      end function c_waitpid
   end interface

contains

   !> What a scene is about, in one line.
   function line_of(seed, draft, plan, verdict) result(line)
      integer, intent(in) :: seed
      type(draft_type), intent(in) :: draft
      type(plan_type), intent(in) :: plan
      type(verdict_type), intent(in) :: verdict
      character(:), allocatable :: line
      line = as_text(seed)//' '//trim(verdict%kind)//' '//trim(verdict%view)//' ['//trim(draft%title)//', '// &
         & trim(plan%base%integrator)//' '//as_text(plan%base%tolerance, 2)//' against '//trim(plan%reference%integrator)//'] '// &
         & as_text(verdict%ratio, 3)//' '//trim(verdict%what)
   end function line_of

   !> Judges a scene in a copy of this process, which may crash or be ended for its time.
   subroutine judge_apart(draft, plan, verdict)
      type(draft_type), intent(in) :: draft
      type(plan_type), intent(in) :: plan
      type(verdict_type), intent(out) :: verdict
      character(*), parameter :: file = 'differential.line'
      integer(c_int) :: status, ignored
      integer :: number, unit, signal
      logical :: is_copy
      call start_copy(number, is_copy)
      if (number < 0) error stop 'no copy of this process could be made'
      if (is_copy) then
         ignored = c_set_timer(2_c_int, [0_c_long, 0_c_long, int(patience_for_all, c_long), 0_c_long], c_null_ptr)
         if (plan%base%target > 0.0_wp) then
            call judge_promise(draft, plan, verdict)
         else
            call judge(draft, plan, verdict)
         end if
         open (newunit=unit, file=file, status='replace', action='write')
         write (unit, '(a)') verdict%kind, verdict%view, verdict%what
         write (unit, '(es12.4)') verdict%ratio
         close (unit)
         call end_copy(0)
      end if
      status = 0
      ignored = c_waitpid(int(number, c_int), status, 0_c_int)
      signal = iand(int(status), 127)
      if (status == 0) then
         open (newunit=unit, file=file, status='old', action='read')
         read (unit, '(a)') verdict%kind, verdict%view, verdict%what
         read (unit, *) verdict%ratio
         close (unit, status='delete')
      else
         verdict%kind = merge('hang ', 'crash', signal == 27)
         if (signal == 27 .and. plan%base%target > 0.0_wp) verdict%kind = 'failed'
         verdict%what = 'signal '//as_text(signal)//', status '//as_text(iand(ishft(int(status), -8), 255))
         open (newunit=unit, file='differential.view', status='old', action='read')
         read (unit, '(a)') verdict%view
         close (unit)
      end if
   end subroutine judge_apart

   !> Leaves out what is not needed for a disagreement, and writes two decks that disagree.
   subroutine reduce(seed, draft, plan, verdict)
      integer, intent(in) :: seed
      type(draft_type), intent(in) :: draft
      type(plan_type), intent(in) :: plan
      type(verdict_type), intent(in) :: verdict
      type(draft_type) :: now, tried
      type(plan_type) :: few
      type(verdict_type) :: found, last
      integer :: i
      logical :: shorter
      few = plan
      call keep_view(verdict%view, few)
      now = draft
      last = verdict
      shorter = .true.
      do while (shorter)
         shorter = .false.
         do i = size(now%blocks), 1, -1
            if (i > size(now%blocks)) cycle
            if (index(now%blocks(i)%text, '*ASSEMBLY') > 0) cycle
            call without(now, i, tried)
            if (size(tried%blocks) < 3) cycle
            call judge_apart(tried, few, found)
            if (found%kind /= verdict%kind .or. found%view /= verdict%view) cycle
            now = tried
            last = found
            shorter = .true.
         end do
      end do
      call write_deck(as_text(seed)//'-a.inp', few%base)
      if (size(few%others) > 0) then
         call write_deck(as_text(seed)//'-b.inp', few%others(1))
         call write_deck(as_text(seed)//'-c.inp', few%reference)
      else
         call write_deck(as_text(seed)//'-b.inp', few%reference)
      end if
      write (output_unit, '(a)') '   reduced: '//line_of(seed, now, few, last)

   contains

      subroutine write_deck(path, view)
         character(*), intent(in) :: path
         type(view_type), intent(in) :: view
         integer :: unit
         open (newunit=unit, file=path, access='stream', status='replace', action='write')
         write (unit) '** '//line_of(seed, now, few, last)//newline//deck_of(now, view)
         close (unit)
      end subroutine write_deck

   end subroutine reduce

   !> Keeps the view that disagrees alone.
   subroutine keep_view(name, plan)
      character(*), intent(in) :: name
      type(plan_type), intent(inout) :: plan
      integer :: i
      type(view_type) :: kept
      do i = 1, size(plan%others)
         if (plan%others(i)%name /= name) cycle
         kept = plan%others(i)
         plan%others = [kept]
         return
      end do
      deallocate (plan%others)
      allocate (plan%others(0))
   end subroutine keep_view

   !> A scene without one of its blocks, and without all that speaks of what that defines.
   recursive subroutine without(draft, number, less)
      type(draft_type), intent(in) :: draft
      integer, intent(in) :: number
      type(draft_type), intent(out) :: less
      type(draft_type) :: next
      character(:), allocatable :: name
      integer :: i
      less = draft
      name = trim(draft%blocks(number)%name)
      less%blocks = [draft%blocks(:number - 1), draft%blocks(number + 1:)]
      if (name == '') return
      less%channels = pack(draft%channels, draft%channels%of /= name)
      i = 1
      do while (i <= size(less%blocks))
         if (mentions(less%blocks(i)%text, name)) then
            call without(less, i, next)
            less = next
            i = 1
         else
            i = i + 1
         end if
      end do
   end subroutine without

end module reductions
