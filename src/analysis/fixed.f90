!> What the deck fixes of the fidelity of its beams and frames: which options those are, the scene with all of them free, and the
!> run aside that shows what they cost, so that no target is kept by not looking. Floor: analysis.
!> Equations: doc/theory.md, accuracy on request.
module limber_analysis_fixed
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, status_interrupted
   use limber_base_text, only: as_text, first_line, newline
   use limber_analysis_reached, only: reached_type
   use limber_analysis_rungs, only: rung_type, given_rung, next_rung, rung_name, in_pieces, all_derivatives, level_rigid, &
      & level_full, first_pieces, most_piece_modes, most_elements
   use limber_analysis_trial, only: trial_type
   use limber_analysis_truth, only: truth_type, error_against, largest_difference
   use limber_analysis_verification, only: run_check, sum_up
   use limber_deck_content, only: deck_type, block_type
   implicit none
   private
   public :: free_options, free_integration, find_fixed, unverified_words, support_words, verify_fixed

   !> Options of the fidelity of beams; FULL is the highest and fixes nothing
   character(20), parameter :: options_of_beams(*) = [character(20) :: 'GEOMETRIC', 'MODES', 'BENDING MODES', 'AXIAL MODES', &
      & 'FREQUENCY LIMIT', 'AXIAL BASIS', 'END FORCE', 'CENTRIFUGAL', 'MODAL DERIVATIVES', 'ELEMENTS', 'GEOMETRIC ELEMENTS', &
      & 'GEOMETRIC INTEGRAL', 'SEGMENTS', 'AXIAL DYNAMICS']
   !> Options without a value where they are not given
   character(20), parameter :: valueless(*) = [character(20) :: 'AXIAL BASIS', 'BENDING MODES', 'AXIAL MODES', 'FREQUENCY LIMIT']

contains

   !> Leaves open what the deck says of the fidelity of its beams.
   pure subroutine free_options(deck)
      type(deck_type), intent(inout) :: deck
      integer :: i, j
      do i = 1, size(deck%blocks)
         if (deck%blocks(i)%keyword /= 'BEAM') cycle
         do j = 1, size(deck%blocks(i)%options)
            associate (option => deck%blocks(i)%options(j))
               if (.not. any(options_of_beams == option%name)) cycle
               option%given = .false.
               if (any(valueless == option%name)) then
                  option%has_value = .false.
                  option%text = ''
                  option%value = 0.0_wp
               end if
               select case (option%name)
               case ('GEOMETRIC INTEGRAL'); option%text = 'EXACT'
               case ('AXIAL DYNAMICS'); option%text = 'FULL'
               case ('SEGMENTS')
                  option%text = '1'
                  option%value = 1.0_wp
                  option%whole = 1
               end select
            end associate
         end do
      end do
   end subroutine free_options

   !> Leaves open the integrator and its tolerance.
   pure subroutine free_integration(deck)
      type(deck_type), intent(inout) :: deck
      integer :: i, j
      i = deck%find('DYNAMICS')
      if (i == 0) return
      do j = 1, size(deck%blocks(i)%options)
         associate (option => deck%blocks(i)%options(j))
            if (option%name == 'TOLERANCE' .or. option%name == 'INTEGRATOR') option%given = .false.
            if (option%name == 'INTEGRATOR') option%text = 'AUTO'
         end associate
      end do
   end subroutine free_integration

   !> What a block of a beam fixes: 'GEOMETRIC=LINEAR, ELEMENTS=2'; empty: nothing.
   function fixed_words(block) result(text)
      type(block_type), intent(in) :: block
      character(:), allocatable :: text
      integer :: j
      text = ''
      if (block%keyword /= 'BEAM') return
      if (block%word('GEOMETRIC') == 'EXACT') return
      do j = 1, size(block%options)
         associate (option => block%options(j))
            if (.not. (option%given .and. any(options_of_beams == option%name))) cycle
            if (option%name == 'GEOMETRIC' .and. option%text == 'FULL') cycle
            if (text /= '') text = text//', '
            text = text//trim(option%name)//'='//option%text
         end associate
      end do
   end function fixed_words

   !> Models that no finer run verifies: frames, which have no ladder, beams in SEGMENTS that are damped by their modes, which are
   !> those of the pieces, and such beams in FULL, whose axial modes are damped although the shortening by bending moves them.
   !> LINEAR and K_G beams in one frame are verified by more modes, for their damping belongs to the modes as they are held.
   !> 'frame 'portal'; beam 'rod', whose SEGMENTS are damped by modes of their own'; empty: there is none.
   function unverified_words(deck) result(text)
      type(deck_type), intent(in) :: deck
      character(:), allocatable :: text
      type(rung_type) :: rung
      integer :: i
      text = ''
      do i = 1, size(deck%blocks)
         select case (deck%blocks(i)%keyword)
         case ('FRAME')
            call add("frame '"//deck%blocks(i)%name()//"'")
         case ('BEAM')
            if (deck%blocks(i)%word('GEOMETRIC') == 'EXACT' .and. deck%blocks(i)%given('GEOMETRIC')) then
               call add("beam '"//deck%blocks(i)%name()//"', whose FUNCTIONS are not varied")
               cycle
            end if
            rung = given_rung(deck, i)
            if (rung%damped .and. rung%segments > 1) then
               call add("beam '"//deck%blocks(i)%name()//"', whose SEGMENTS are damped by modes of their own")
            else if (rung%damped .and. (rung%open_level .or. rung%level == level_full)) then
               call add("beam '"//deck%blocks(i)%name()//"', whose damping brakes the shortening as well in FULL")
            end if
         end select
      end do

   contains

      subroutine add(words)
         character(*), intent(in) :: words
         if (text /= '') text = text//'; '
         text = text//words
      end subroutine add

   end function unverified_words

   !> Beams that err by more than half of a target on a rung that has not the shapes of forces and moments at its ends: SUPPORT and
   !> END SHAPES are not chosen. Lines of a message; empty: there is none.
   function support_words(deck, target, reached) result(text)
      type(deck_type), intent(in) :: deck
      real(wp), intent(in) :: target
      type(reached_type), intent(in) :: reached
      character(:), allocatable :: text
      integer :: i
      text = ''
      if (.not. allocated(reached%of_beam)) return
      do i = 1, size(reached%of_beam)
         associate (rung => reached%advice%rungs(i))
            if (reached%of_beam(i) <= 0.5_wp*target .or. rung%level == level_rigid .or. rung%shaped) cycle
            associate (block => deck%blocks(rung%block))
               if (block%yes('END SHAPES')) cycle
               text = text//newline//"   beam '"//block%name()//"' as "//rung_name(rung)//' misses '
               if (reached%of_beam(i) < 1.0e3_wp) text = text//as_text(reached%of_beam(i), 2)//' that the next rung shows, or '
               text = text//'more: its functions are those of SUPPORT='//block%word('SUPPORT')// &
                  & '. TARGET chooses neither SUPPORT nor END SHAPES'
               if (rung%damped) text = text//', and cannot divide a beam that is damped by its modes'
               text = text//'; give a SUPPORT that is like its joints, or END SHAPES=YES'
            end associate
         end associate
      end do
   end function support_words

   !> Runs the scene aside with all free that the deck fixes, one rung higher, and counts the difference: eq. (T3). That run is the
   !> truth from then on.
   subroutine verify_fixed(deck, target, quiet, candidate, reached, truth, error)
      type(deck_type), intent(in) :: deck
      real(wp), intent(in) :: target
      logical, intent(in) :: quiet
      type(trial_type), intent(in) :: candidate
      !> With a target that is kept but for what the deck fixes; on return it may not be
      type(reached_type), intent(inout) :: reached
      type(truth_type), intent(inout) :: truth
      !> A signal asks for the end (status 4)
      type(error_type), allocatable, intent(out) :: error
      !> Part of the difference that the run aside is taken to err by itself
      real(wp), parameter :: rest = 0.25_wp
      type(rung_type), allocatable :: rungs(:), aside(:)
      type(trial_type) :: check
      type(deck_type) :: freed
      real(wp), allocatable :: away(:)
      character(:), allocatable :: failure
      integer :: attempt, channels, n
      if (allocated(truth%freed)) return
      if (reached%fixed == '') return
      freed = deck
      call free_options(freed)
      if (freed%blocks(freed%find('DYNAMICS'))%word('INTEGRATOR') == 'ADAMS') &
         & call freed%set_option(freed%find('DYNAMICS'), 'INTEGRATOR', 'AUTO')
      failure = ''
      ! Where a beam cannot be divided, as something slides along it, the run aside has it in one frame
      do attempt = 1, 2
         call free_rungs(deck, truth%rungs, attempt == 1, rungs, aside)
         call run_check(freed, [rungs, aside], reached%advice%tolerance, truth%tolerance/truth%verified_tolerance, &
            & 60*candidate%work, .false., quiet, 'run aside, with all free that the deck fixes', reached, check, error)
         if (.not. allocated(error)) exit
         if (error%status == status_interrupted) return
         failure = first_line(error%message)
         deallocate (error)
      end do
      if (attempt <= 2) failure = check%reason
      if (failure /= '') then
         if (reached%unverified /= '') reached%unverified = '; '//reached%unverified
         reached%unverified = reached%fixed//' (the run aside that would show its error failed: '//failure//')'//reached%unverified
         reached%fixed = ''
         return
      end if
      channels = size(truth%scale)
      n = size(truth%finest, 2)
      allocate (away, source=largest_difference(check%samples%values, truth%finest))
      reached%of_fixed = maxval(away/truth%scale)
      truth%of_model = truth%of_model + rest*away
      call truth%refine(check%samples%values(:channels, :n), check%work)
      truth%rungs = rungs
      call move_alloc(aside, truth%aside)
      truth%freed = freed
      call sum_up(target, reached, truth)
      reached%error = error_against(truth, candidate%samples%values)
      reached%done = reached%error <= target
      if (reached%done) return
      reached%reason = 'TARGET='//as_text(target, 2)//' is not kept: the error is '//as_text(reached%error, 2)// &
         & ', to which what the deck fixes of '//reached%fixed//' adds '//as_text(reached%of_fixed, 2)//', as a run aside with'// &
         & ' more shows; leave it open, or ask for the error of the integration alone by ESTIMATE=YES'
   end subroutine verify_fixed

   !> All that the deck fixes: 'beam 'rod' (GEOMETRIC=LINEAR)'.
   subroutine find_fixed(deck, text)
      type(deck_type), intent(in) :: deck
      character(:), allocatable, intent(out) :: text
      character(:), allocatable :: words
      integer :: i
      text = ''
      do i = 1, size(deck%blocks)
         words = fixed_words(deck%blocks(i))
         if (words == '') cycle
         if (text /= '') text = text//'; '
         text = text//"beam '"//deck%blocks(i)%name()//"' ("//words//')'
      end do
   end subroutine find_fixed

   !> One rung above what the deck fixes.
   subroutine free_rungs(deck, of_truth, divided, rungs, aside)
      type(deck_type), intent(in) :: deck
      !> Those of the beams that limber chooses for, as they are in the truth
      type(rung_type), intent(in) :: of_truth(:)
      !> Whether beams may be divided
      logical, intent(in) :: divided
      !> The same with all free, and those of other beams
      type(rung_type), allocatable, intent(out) :: rungs(:), aside(:)
      integer :: i, k
      allocate (rungs, source=of_truth)
      allocate (aside(0))
      do i = 1, size(deck%blocks)
         if (fixed_words(deck%blocks(i)) == '') cycle
         do k = 1, size(rungs)
            if (rungs(k)%block == i) exit
         end do
         if (k <= size(rungs)) then
            rungs(k) = free_rung(rungs(k), divided)
         else
            aside = [aside, free_rung(given_rung(deck, i), divided)]
         end if
      end do
   end subroutine free_rungs

   !> A rung with all open, and the next one above: in pieces where the deck fixes the level, for one frame does not show what
   !> another leaves out. A beam that was rigid is flexible.
   function free_rung(rung, divided) result(free)
      type(rung_type), intent(in) :: rung
      logical, intent(in) :: divided
      type(rung_type) :: free
      integer, parameter :: least = 3
      logical :: pieces
      pieces = divided .and. .not. rung%damped .and. .not. rung%open_level .and. rung%level > level_rigid
      free = rung
      free%open_level = .true.
      free%open_modes = .true.
      free%open_axial = .true.
      free%open_segments = .not. rung%damped
      free%given_elements = .false.
      free%elements = max(48, free%elements)
      if (rung%segments > 1) then
         free = in_pieces(free, 2*rung%segments, min(most_piece_modes, max(2, rung%bending)))
      else if (pieces) then
         free = in_pieces(free, first_pieces, min(most_piece_modes, max(least, rung%bending/2 + 1)))
      else
         free = next_rung(free)
         if (.not. rung%open_level) free%level = level_full
         free%bending = max(least, free%bending)
         free%spun = .true.
         free%derivatives = all_derivatives(free)
      end if
      free%elements = min(most_elements, max(2*rung%elements, free%elements))
   end function free_rung

end module limber_analysis_fixed
