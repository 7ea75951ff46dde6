!> Scenes by chance that are run in many ways which must all tell the same: by two integrators and tolerances, with and without
!> elimination, mirrored, turned, moved, in other units, under other names, in another order, at another time. A scene follows
!> from its number alone.
!>
!>    differential [--show] [--talk] [--all] [--reduce] [--slow] [--quick] [--target] FIRST COUNT
!>
!> --show prints the decks of all views; --talk how each run ended, and its warnings; --all a line for each scene; --reduce leaves
!> out of a scene that disagrees whatever is not needed for it, and leaves its decks in the working folder, as NUMBER-a.inp and
!> NUMBER-b.inp; --slow has ten times the patience, --quick a third of it for each run, and all of it for what disagrees;
!> --target runs the same scenes with exact beams whose functions, integrator and tolerance limber chooses for a target of 1e-2:
!> what it says is kept must be kept.
program differential
   use, intrinsic :: iso_fortran_env, only: output_unit
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, newline
   use comparisons, only: verdict_type
   use drafts, only: draft_type
   use inventions, only: invent
   use couplings, only: places, angles, speeds, spins
   use plans, only: plan_type, make_plan, make_target_plan, deck_of
   use reductions, only: judge_apart, reduce, line_of, patience_for_all
   use trials, only: patience
   use verdicts, only: talks
   implicit none

   character(*), parameter :: kinds(*) = [character(10) :: 'same', 'warned', 'estimated', 'refused', 'failed', 'values', 'status', &
      & 'warnings', 'slow', 'crash', 'hang']
   integer, parameter :: peaceful = 5
   call main()

contains

   subroutine main()
      type(draft_type) :: draft
      type(plan_type) :: plan
      type(verdict_type) :: verdict
      character(64) :: word
      logical :: shows, lists, reduces, promised
      real(wp) :: haste
      integer :: arguments, first, count, seed, tally(size(kinds)), i
      shows = .false.
      reduces = .false.
      lists = .false.
      promised = .false.
      arguments = 0
      haste = 1.0_wp
      do
         call get_command_argument(arguments + 1, word)
         if (word == '--show') shows = .true.
         if (word == '--all') lists = .true.
         if (word == '--reduce') reduces = .true.
         if (word == '--talk') talks = .true.
         if (word == '--quick') haste = 0.3_wp
         if (word == '--target') then
            promised = .true.
            patience_for_all = 20
         end if
         if (word == '--slow') patience_for_all = 10*patience_for_all
         if (word(1:2) /= '--') exit
         arguments = arguments + 1
      end do
      read (word, *) first
      call get_command_argument(arguments + 2, word)
      read (word, *) count
      tally = 0
      do seed = first, first + count - 1
         call invent(seed, draft, promised)
         if (promised) then
            call keep_motion(draft)
            call make_target_plan(plan)
         else
            call make_plan(seed, draft, plan)
         end if
         if (shows) call show(draft, plan)
         patience = merge(5.0_wp, haste, promised)
         call judge_apart(draft, plan, verdict)
         ! What haste makes disagree is judged again: estimates of errors take their time
         patience = 1.0_wp
         if (haste < patience .and. .not. promised .and. number_of(verdict) > peaceful) call judge_apart(draft, plan, verdict)
         i = number_of(verdict)
         tally(i) = tally(i) + 1
         if (i <= peaceful .and. .not. lists) cycle
         write (output_unit, '(a)') line_of(seed, draft, plan, verdict)
         flush (output_unit)
         if (i <= peaceful) cycle
         if (reduces .and. all(verdict%kind /= [character(10) :: 'slow', 'hang'])) call reduce(seed, draft, plan, verdict)
      end do
      write (output_unit, '(a)', advance='no') as_text(count)//' scenes:'
      do i = 1, size(kinds)
         if (tally(i) > 0) write (output_unit, '(a)', advance='no') ' '//as_text(tally(i))//' '//trim(kinds(i))
      end do
      write (output_unit, '(a)') ''
      if (sum(tally(peaceful + 1:)) > 0) stop 1
   end subroutine main

   !> Leaves a scene the channels of motion: forces, deflections and accelerations of short beams that are struck make searches
   !> long.
   subroutine keep_motion(draft)
      type(draft_type), intent(inout) :: draft
      integer, parameter :: motion(4) = [places, angles, speeds, spins]
      integer :: i
      draft%channels = pack(draft%channels, [(any(motion == draft%channels(i)%group), i=1, size(draft%channels))])
   end subroutine keep_motion

   !> Number of the kind of a verdict.
   integer function number_of(verdict) result(number)
      type(verdict_type), intent(in) :: verdict
      do number = 1, size(kinds) - 1
         if (verdict%kind == kinds(number)) exit
      end do
   end function number_of

   subroutine show(draft, plan)
      type(draft_type), intent(in) :: draft
      type(plan_type), intent(in) :: plan
      integer :: i
      write (output_unit, '(a)') '** base'//newline//deck_of(draft, plan%base)
      write (output_unit, '(a)') '** reference'//newline//deck_of(draft, plan%reference)
      do i = 1, size(plan%others)
         write (output_unit, '(a)') '** '//trim(plan%others(i)%name)//newline//deck_of(draft, plan%others(i))
      end do
   end subroutine show

end program differential
