!> Scenes of exact beams whose functions, integrator and tolerance limber chooses for a target: whether what it says is kept is
!> kept, against two references with many functions.
module promises
   use, intrinsic :: iso_fortran_env, only: output_unit
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text, newline
   use limber_accuracy_reached_target, only: reached_type
   use limber_accuracy_fidelity_levels, only: names_of
   use limber_scene_first_scene, only: build_scene
   use limber_scene_scene, only: scene_type
   use limber_accuracy_target_search, only: reach_target
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_reader, only: read_deck_text
   use comparisons, only: verdict_type
   use drafts, only: draft_type
   use plans, only: plan_type, deck_of
   use trials, only: candidate_type
   use verdicts, only: run_view, note_view, bring_back, is_slow, first_words, talks
   implicit none
   private
   public :: judge_promise

contains

   !> Searches, and runs the references of what is said to be kept.
   subroutine judge_promise(draft, plan, verdict)
      type(draft_type), intent(in) :: draft
      type(plan_type), intent(in) :: plan
      type(verdict_type), intent(out) :: verdict
      type(candidate_type) :: found, reference, other
      if (.not. has_open_beam(draft)) then
         verdict%kind = 'refused'
         verdict%what = 'no beam is left open'
         return
      end if
      call search(draft, plan, found)
      if (found%status /= 0) then
         verdict%kind = merge('refused', 'failed ', found%status == 2)
         verdict%what = first_words(found%message)
         return
      end if
      call run_view(draft, plan%reference, reference)
      call run_view(draft, plan%changed, other)
      if (reference%status /= 0 .or. other%status /= 0) then
         verdict%kind = 'failed'
         verdict%what = first_words('references: '//reference%message//other%message)
         return
      end if
      call compare_promise(draft, plan, found, reference, other, verdict)
   end subroutine judge_promise

   !> Whether a scene has an exact beam.
   pure logical function has_open_beam(draft)
      type(draft_type), intent(in) :: draft
      integer :: i
      has_open_beam = .false.
      do i = 1, size(draft%blocks)
         if (index(draft%blocks(i)%text, '<J|') > 0) has_open_beam = .true.
      end do
   end function has_open_beam

   !> Samples of what a search has found; the status is 3 where it does not say that all is kept.
   subroutine search(draft, plan, found)
      type(draft_type), intent(in) :: draft
      type(plan_type), intent(in) :: plan
      type(candidate_type), intent(out) :: found
      type(scene_type) :: scene
      type(diagnostics_type) :: diagnostics
      type(error_type), allocatable :: error
      type(reached_type) :: reached
      call note_view(plan%base)
      found%message = ''
      found%warnings = ''
      call read_deck_text('scene.inp', deck_of(draft, plan%base), scene%deck, diagnostics)
      call build_scene(scene, diagnostics, error)
      if (.not. allocated(error)) call reach_target(scene%deck, plan%base%target, .true., reached, error)
      if (allocated(error)) then
         found%status = 2
         found%message = error%message
         return
      end if
      if (talks) write (output_unit, '(a)') '-- '//names_of(reached%advice%rungs)//', '//reached%advice%integrator// &
         & as_text(reached%advice%tolerance, 2)//': error '//as_text(reached%error, 2)//', '//as_text(reached%runs)//' runs, '// &
         & as_text(reached%cpu, 3)//' s '//reached%reason//reached%path
      if (.not. reached%done .or. reached%unverified /= '') found%status = 3
      found%message = 'not kept: '//reached%reason
      if (reached%unverified /= '') found%message = 'not verified: '//reached%unverified
      if (found%status /= 0) return
      allocate (found%values, source=reached%samples%values(:size(scene%system%model%channels), :reached%samples%samples))
      allocate (found%modes(2, 0))
      call bring_back(draft, plan%base, found)
   end subroutine search

   !> A channel that is off by more than the target and the difference of the references, relative to its largest value, is a
   !> disagreement. What does not move is round-off.
   subroutine compare_promise(draft, plan, found, reference, other, verdict)
      type(draft_type), intent(in) :: draft
      type(plan_type), intent(in) :: plan
      type(candidate_type), intent(in) :: found, reference, other
      type(verdict_type), intent(inout) :: verdict
      !> Value below which a channel of motion is none, in the units of the deck
      real(wp), parameter :: nothing = 1.0e-12_wp
      real(wp) :: error, doubt, scale
      integer :: i, k, row, at
      verdict%kind = 'same'
      if (any(shape(found%values) /= shape(reference%values)) .or. any(shape(other%values) /= shape(reference%values))) then
         verdict%kind = 'values'
         verdict%what = 'another number of samples'
         return
      end if
      row = 0
      do i = 1, size(draft%channels)
         do k = 1, merge(2, 1, allocated(draft%channels(i)%second))
            row = row + 1
            associate (x => found%values(row, :), y => reference%values(row, :))
               scale = maxval(abs(y))
               if (.not. scale > nothing) cycle
               error = maxval(abs(x - y))
               doubt = maxval(abs(other%values(row, :) - y))
               at = maxloc(abs(x - y), 1)
               error = (error - doubt)/(plan%base%target*scale)
               if (error <= verdict%ratio) cycle
               verdict%ratio = error
               if (error > 1.0_wp) verdict%kind = 'values'
               verdict%what = draft%channels(i)%first//' sample '//as_text(at)//': '//as_text(x(at), 6)//' for '// &
                  & as_text(y(at), 6)//', '//as_text(other%values(row, at), 6)//', scale '//as_text(scale, 3)
            end associate
         end do
      end do
      verdict%view = 'base'
   end subroutine compare_promise

end module promises
