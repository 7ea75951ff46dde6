!> limber advise: fidelity levels for an accuracy. Which model a scene needs for a requested accuracy, from a probe, without running
!> it; and a deck with the choices written out. Floor: commands; deck -> advice -> report and deck.
module limber_commands_advise
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise, status_deck
   use limber_base_files, only: append_text, remove_file, rename_file, unused_name, kind_of_path, path_free
   use limber_base_signals, only: catch_signals, release_signals
   use limber_base_text, only: as_text, newline
   use limber_accuracy_advice, only: advice_type, make_advice, apply_advice, expected_error, cost_of
   use limber_accuracy_fixed_options, only: free_options, free_integration, find_fixed, unverified_words
   use limber_accuracy_pilot_run, only: forecast_type
   use limber_accuracy_fidelity_levels, only: level_type, rung_name, richer, can_climb
   use limber_scene_first_scene, only: build_scene
   use limber_scene_scene, only: scene_type
   use limber_deck_content, only: deck_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_effective, only: effective_deck
   use limber_deck_parameters, only: override_type
   use limber_deck_reader, only: read_deck
   use limber_model_analyses, only: kind_names
   use limber_output_write_permission, only: check_place
   implicit none
   private
   public :: advice_request_type, advise_deck, advice_table, target_of, read_whole_deck

   !> What is asked of an advice
   type :: advice_request_type
      !> Error that is aimed at; zero: that of the deck, else 1e-3
      real(wp) :: target = 0.0_wp
      !> Whether the choices that the deck gives are free as well
      logical :: all = .false.
      !> File for the deck with the choices; not allocated: none is written
      character(:), allocatable :: write
   end type advice_request_type

   !> Error that is aimed at if neither deck nor command say
   real(wp), parameter :: usual_target = 1.0e-3_wp

contains

   !> Advises on a deck.
   subroutine advise_deck(path, overrides, request, force, report, error)
      !> The deck
      character(*), intent(in) :: path
      !> Values of parameters in place of those of the deck
      type(override_type), intent(in) :: overrides(:)
      type(advice_request_type), intent(in) :: request
      !> Whether the file with the choices may be replaced
      logical, intent(in) :: force
      character(:), allocatable, intent(out) :: report
      !> The deck cannot be used (status 2)
      type(error_type), allocatable, intent(out) :: error
      type(scene_type) :: scene
      type(advice_type) :: advice
      type(deck_type) :: deck
      type(diagnostics_type) :: diagnostics
      real(wp) :: aim
      report = ''
      call read_whole_deck(path, overrides, deck, error)
      if (.not. allocated(error) .and. allocated(request%write)) call check_write(request%write, deck%source%paths(), force, error)
      if (allocated(error)) return
      if (request%all) then
         call free_options(deck)
         call free_integration(deck)
      end if
      aim = target_of(deck)
      if (request%target > 0.0_wp) aim = request%target
      if (.not. aim > 0.0_wp) aim = usual_target
      call make_advice(deck, aim, advice, error, unverified=.true.)
      if (allocated(error)) return
      scene%deck = deck
      call apply_advice(advice, scene%deck)
      call build_scene(scene, diagnostics, error)
      if (allocated(error)) return
      report = scene%warnings//path//': '//scene%system%model%heading//newline//advice_table(advice, scene, .false.)// &
         & fixed_lines(deck)
      if (.not. allocated(request%write)) return
      call write_deck(scene, request%write, error)
      if (.not. allocated(error)) report = report//newline//'   The deck with these choices is '//request%write// &
         & ', without TARGET: nothing verifies them there'
   end subroutine advise_deck

   !> What is not in the expected errors.
   function fixed_lines(deck) result(text)
      type(deck_type), intent(in) :: deck
      character(:), allocatable :: text, fixed, unverified
      call find_fixed(deck, fixed)
      unverified = unverified_words(deck)
      text = ''
      if (fixed /= '') text = newline//'   fixed by the deck; what that costs a run aside of `limber run` shows: '//fixed
      if (unverified /= '') text = text//newline//'   not chosen and not verified: the model of '//unverified
   end function fixed_lines

   !> Reads a deck whose only analysis is a dynamic one.
   subroutine read_whole_deck(path, overrides, deck, error)
      character(*), intent(in) :: path
      type(override_type), intent(in) :: overrides(:)
      type(deck_type), intent(out) :: deck
      !> What is wrong with it, rendered; status 2
      type(error_type), allocatable, intent(out) :: error
      type(diagnostics_type) :: diagnostics
      integer :: i
      call read_deck(path, deck, diagnostics, overrides)
      if (diagnostics%count > 0) then
         call raise(error, diagnostics%render(deck%source), status_deck)
      else if (deck%find('DYNAMICS') == 0) then
         call raise(error, path//': nothing to advise on; add a *DYNAMICS block (limber help DYNAMICS)', status_deck)
      else if (any([(deck%find(trim(kind_names(i))) > 0, i=1, size(kind_names) - 1)]) .or. &
         & deck%find('DYNAMICS', deck%find('DYNAMICS')) > 0) then
         call raise(error, path//': an advice is on a single *DYNAMICS; remove the other analyses', status_deck)
      end if
   end subroutine read_whole_deck

   !> Error that a deck asks for, relative to the largest value of each channel; zero: none.
   pure real(wp) function target_of(deck) result(target)
      type(deck_type), intent(in) :: deck
      integer :: block
      target = 0.0_wp
      block = deck%find('ACCURACY')
      if (block > 0) target = deck%blocks(block)%real('TARGET')
   end function target_of

   !> Refuses a place for the deck with all choices, before they are made.
   subroutine check_write(path, sources, force, error)
      character(*), intent(in) :: path
      !> Files of the deck
      character(*), intent(in) :: sources(:)
      logical, intent(in) :: force
      type(error_type), allocatable, intent(out) :: error
      call check_place(path, sources, error)
      if (allocated(error) .or. force) return
      if (kind_of_path(path) == path_free) return
      call raise(error, path//': exists already; use --force to replace it', status_deck)
   end subroutine check_write

   !> Writes the deck with all choices, and no longer with the target that they were made for.
   subroutine write_deck(scene, path, error)
      type(scene_type), intent(in) :: scene
      character(*), intent(in) :: path
      type(error_type), allocatable, intent(out) :: error
      type(deck_type) :: deck
      character(:), allocatable :: new
      integer :: block
      logical :: ok
      deck = scene%deck
      deck%repeats = deck%repeats(:0)
      block = deck%find('ACCURACY')
      if (block > 0) where (deck%blocks(block)%options%name == 'TARGET') deck%blocks(block)%options%has_value = .false.
      call deck%set_option(deck%find('DYNAMICS'), 'INTEGRATOR', scene%system%model%dynamics%integrator)
      ! Beside what has the name already, until it is whole; no signal ends the process between
      new = unused_name(path, '.new')
      call catch_signals()
      call append_text(new, effective_deck(deck), ok)
      if (ok) call rename_file(new, path, ok)
      if (.not. ok) call remove_file(new)
      call release_signals()
      if (ok) return
      call raise(error, path//': cannot be written: is there room, and may you write there?', status_deck)
   end subroutine write_deck

   !> The choices, each with what the pilot run knows of it. Of choices that finer runs have judged no expectations are told: what
   !> those have shown counts.
   function advice_table(advice, scene, judged) result(text)
      type(advice_type), intent(in) :: advice
      !> As it will run
      type(scene_type), intent(in) :: scene
      !> Whether finer runs have
      logical, intent(in) :: judged
      character(:), allocatable :: text
      integer :: i, width
      text = '   for a relative error of '//as_text(advice%target, 2)//' in every channel:'
      width = 4
      do i = 1, size(advice%rungs)
         width = max(width, len(scene%deck%blocks(advice%rungs(i)%block)%name()))
      end do
      if (size(advice%rungs) > 0) then
         text = text//newline//'   '//left('beam', width)//left('rung', 12)
         if (judged) text = text//'of the rigid motion'
         if (.not. judged) text = text//left('expected', 9)//left('cost', 7)//left('the next', 30)//'decided by'
      end if
      do i = 1, size(advice%rungs)
         text = text//newline//'   '//left(scene%deck%blocks(advice%rungs(i)%block)%name(), width)
         if (judged) then
            text = text//left(rung_name(advice%rungs(i)), 12)//known_of(advice%rungs(i), advice%probe%beams(i))
         else
            text = text//beam_cells(advice%rungs(i), advice%probe%beams(i), advice%expected(i))
         end if
      end do
      if (size(advice%rungs) == 0) text = text//newline//'   no beam whose fidelity is open'
      associate (dynamics => scene%system%model%dynamics)
         text = text//newline//'   '//dynamics%integrator//' at TOLERANCE='//as_text(dynamics%tolerance, 2)
         if (dynamics%reason /= '') text = text//': '//dynamics%reason
      end associate
      if (.not. judged) text = text//doubts_of(advice, scene)
      text = text//newline//'   '//as_text(advice%probe%cpu, 2)//' s CPU for the probe: '//as_text(advice%probe%steps)// &
         & ' steps with rigid beams'
   end function advice_table

   !> What speaks against expectations, a line for each.
   function doubts_of(advice, scene) result(text)
      type(advice_type), intent(in) :: advice
      type(scene_type), intent(in) :: scene
      character(:), allocatable :: text
      !> Axial force relative to the Euler load beyond which modes of bending say little
      real(wp), parameter :: rope = 100.0_wp
      integer :: i
      text = ''
      do i = 1, size(advice%rungs)
         if (advice%expected(i) <= advice%target) cycle
         text = text//newline//"   beam '"//scene%deck%blocks(advice%rungs(i)%block)%name()//"': "// &
            & missing_words(advice%rungs(i), advice%probe%beams(i), advice%target)
      end do
      do i = 1, size(advice%rungs)
         if (advice%probe%beams(i)%force <= rope) cycle
         text = text//newline//"   beam '"//scene%deck%blocks(advice%rungs(i)%block)%name()//"': its axial force is "// &
            & as_text(advice%probe%beams(i)%force, 2)//' of the Euler load: it moves as a rope, and its expected error may'// &
            & ' be far too small; verify it by `limber run` with a TARGET'
      end do
      if (size(advice%rungs) > 0) text = text//newline//'   expected errors are estimates from the motion with rigid'// &
         & ' beams; where vibrations count, as of loads that are there at once,'//newline// &
         & '   they may be far too small: `limber run` with TARGET= verifies the choice, and takes another one then'
      if (advice%probe%blind) text = text//newline//'   with rigid beams the scene does not move: these are assumptions'
   end function doubts_of

   !> That a rung is not expected to keep the target, and which one is.
   function missing_words(rung, beam, target) result(text)
      type(level_type), intent(in) :: rung
      type(forecast_type), intent(in) :: beam
      real(wp), intent(in) :: target
      character(:), allocatable :: text
      type(level_type) :: other
      integer :: step, k
      text = rung_name(rung)//' is not expected to keep the target; '
      do step = rung%step, merge(rung%highest - 1, rung%step, rung%open_functions)
         do k = 0, merge(1, 0, rung%open_strains .and. .not. rung%stretches .and. step > 0)
            other = richer(rung, step - rung%step, k == 1)
            if (expected_error(other, beam) > target) cycle
            text = text//rung_name(other)//' is'
            return
         end do
      end do
      text = text//'no other one is'
   end function missing_words

   function beam_cells(rung, beam, expected) result(text)
      type(level_type), intent(in) :: rung
      type(forecast_type), intent(in) :: beam
      real(wp), intent(in) :: expected
      character(:), allocatable :: text, next
      type(level_type) :: higher
      next = 'none'
      if (can_climb(rung)) then
         higher = richer(rung, 1, .false.)
         next = rung_name(higher)//': '//as_text(expected_error(higher, beam), 2)//' at '// &
            & as_text(cost_of(higher)/cost_of(rung), 2)//' times'
      end if
      text = left(rung_name(rung), 12)//left(as_text(expected, 2), 9)//left(as_text(cost_of(rung), 2), 7)//left(next, 30)// &
         & reason_of(rung, beam)
   end function beam_cells

   !> The numbers that decided.
   function reason_of(rung, beam) result(text)
      type(level_type), intent(in) :: rung
      type(forecast_type), intent(in) :: beam
      character(:), allocatable :: text
      if (rung%open_level .and. rung%step == 0) then
         text = 'all that it bends and stretches makes '//as_text(expected_error(rung, beam), 2)//' of a channel'
      else
         text = known_of(rung, beam)
      end if
   end function reason_of

   !> What the motion with rigid beams shows of a beam.
   function known_of(rung, beam) result(text)
      type(level_type), intent(in) :: rung
      type(forecast_type), intent(in) :: beam
      character(:), allocatable :: text
      if (.not. rung%open_level) then
         text = 'the deck; it bends to '//as_text(beam%deflection, 2)//' of its length'
      else
         text = 'slope '//as_text(beam%slope, 2)//', deflection '//as_text(beam%deflection, 2)//' of the length; its stretch '// &
            & 'makes '//as_text(beam%stretch, 2)//' of a channel'//ringing_words(beam)//'; axial force '// &
            & as_text(beam%force, 2)//' of the Euler load'
      end if
   end function known_of

   !> What vibrations along a beam make of forces and accelerations that channels ask for; empty if that is next to nothing.
   function ringing_words(beam) result(text)
      type(forecast_type), intent(in) :: beam
      character(:), allocatable :: text
      real(wp), parameter :: least = 1.0e-3_wp
      text = ''
      if (beam%ringing >= least) text = ', its vibrations along itself '//as_text(beam%ringing, 2)
   end function ringing_words

   !> A text filled up to a length, with at least two blanks behind it.
   pure function left(cell, length) result(text)
      character(*), intent(in) :: cell
      integer, intent(in) :: length
      character(max(length, len(cell)) + 2) :: text
      text = cell
   end function left

end module limber_commands_advise
