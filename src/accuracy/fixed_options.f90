!> Fidelity options that the deck fixes. Which options those are, the scene with all of them free, and the run aside that shows what
!> they cost, so that no target is kept by not looking. Floor: accuracy. Equations: doc/theory, part 7.
module limber_accuracy_fixed_options
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, status_interrupted
   use limber_base_text, only: as_text, first_line, newline
   use limber_accuracy_run_pool, only: pool_type
   use limber_accuracy_reached_target, only: reached_type
   use limber_accuracy_fidelity_levels, only: level_type, given_rung, richer, verifying, level_exact
   use limber_accuracy_candidate, only: candidate_type, run_request_type
   use limber_accuracy_reference_run, only: reference_run_type, error_against, largest_difference
   use limber_accuracy_search_thresholds, only: least_patience, patience_time
   use limber_deck_content, only: deck_type, block_type
   use limber_deck_families, only: options_of_modes
   implicit none
   private
   public :: free_options, free_integration, find_fixed, unverified_words, verify_fixed

   !> Options of the fidelity of beams beside those of modes; EXACT is the highest model and fixes nothing
   character(18), parameter :: options_of_fidelity(*) = [character(18) :: 'GEOMETRIC', 'FUNCTIONS', 'STRAIN FUNCTIONS', 'ELEMENTS']
   !> Options without a value where they are not given
   character(20), parameter :: valueless(*) = [character(20) :: 'AXIAL BASIS', 'BENDING MODES', 'AXIAL MODES']

contains

   !> Leaves open what the deck says of the fidelity of its beams.
   pure subroutine free_options(deck)
      type(deck_type), intent(inout) :: deck
      integer :: i, j
      do i = 1, size(deck%blocks)
         if (deck%blocks(i)%keyword /= 'BEAM') cycle
         do j = 1, size(deck%blocks(i)%options)
            associate (option => deck%blocks(i)%options(j))
               if (.not. is_of_fidelity(option%name)) cycle
               option%given = .false.
               if (option%name == 'GEOMETRIC') option%text = 'EXACT'
               if (any(valueless == option%name)) then
                  option%has_value = .false.
                  option%text = ''
                  option%value = 0.0_wp
               end if
            end associate
         end do
      end do
   end subroutine free_options

   pure logical function is_of_fidelity(name)
      character(*), intent(in) :: name
      is_of_fidelity = any(options_of_fidelity == name) .or. any(options_of_modes == name)
   end function is_of_fidelity

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
      ! A model with modes that the deck means by what else it gives
      if (block%word('GEOMETRIC') /= 'EXACT' .and. .not. block%given('GEOMETRIC')) text = 'GEOMETRIC='//block%word('GEOMETRIC')
      do j = 1, size(block%options)
         associate (option => block%options(j))
            if (.not. (option%given .and. is_of_fidelity(option%name))) cycle
            if (option%name == 'GEOMETRIC' .and. option%text == 'EXACT') cycle
            if (option%name == 'ELEMENTS' .and. block%word('GEOMETRIC') == 'EXACT') cycle
            if (text /= '') text = text//', '
            text = text//trim(option%name)//'='//option%text
         end associate
      end do
   end function fixed_words

   !> Models that no finer run verifies: frames, which have no ladder, and beams in SEGMENTS that are damped by their modes, which
   !> are those of the pieces. 'frame 'portal'; beam 'rod', whose SEGMENTS are damped by modes of their own'; empty: there is none.
   function unverified_words(deck) result(text)
      type(deck_type), intent(in) :: deck
      character(:), allocatable :: text
      integer :: i
      text = ''
      do i = 1, size(deck%blocks)
         select case (deck%blocks(i)%keyword)
         case ('FRAME')
            call add("frame '"//deck%blocks(i)%name()//"'")
         case ('BEAM')
            if (deck%blocks(i)%integer('SEGMENTS') > 1 .and. damped_by_modes(deck, deck%blocks(i)%name())) &
               & call add("beam '"//deck%blocks(i)%name()//"', whose SEGMENTS are damped by modes of their own")
         end select
      end do

   contains

      subroutine add(words)
         character(*), intent(in) :: words
         if (text /= '') text = text//'; '
         text = text//words
      end subroutine add

   end function unverified_words

   !> Whether a beam is damped otherwise than in proportion to its stiffness, which means the same in one frame and in pieces.
   pure logical function damped_by_modes(deck, name)
      type(deck_type), intent(in) :: deck
      character(*), intent(in) :: name
      integer :: i
      damped_by_modes = .false.
      i = deck%find('DAMPING')
      do while (i > 0)
         associate (block => deck%blocks(i))
            if (block%name('BODY') == name) damped_by_modes = damped_by_modes .or. size(block%lines) > 0 .or. &
               & block%real('RATIO') > 0.0_wp .or. block%real('RAYLEIGH ALPHA') > 0.0_wp
         end associate
         i = deck%find('DAMPING', i)
      end do
   end function damped_by_modes

   !> Runs the scene aside with all free that the deck fixes, higher, and counts the difference: eq. (7.95). That run is the truth
   !> from then on.
   subroutine verify_fixed(target, pool, candidate, reached, truth, error)
      real(wp), intent(in) :: target
      type(pool_type), intent(inout) :: pool
      type(candidate_type), intent(in) :: candidate
      !> With a target that is kept but for what the deck fixes; on return it may not be
      type(reached_type), intent(inout) :: reached
      type(reference_run_type), intent(inout) :: truth
      !> A signal asks for the end (status 4)
      type(error_type), allocatable, intent(out) :: error
      !> Part of the difference that the run aside is taken to err by itself
      real(wp), parameter :: rest = 0.1_wp
      type(level_type), allocatable :: rungs(:), aside(:)
      type(candidate_type) :: check
      type(run_request_type) :: request
      type(deck_type) :: freed
      real(wp), allocatable :: away(:)
      character(:), allocatable :: failure
      integer :: channels, n
      if (allocated(truth%freed) .or. reached%fixed == '') return
      freed = pool%deck
      if (reached%advice%integrator /= '') &
         & call freed%set_option(freed%find('DYNAMICS'), 'INTEGRATOR', trim(reached%advice%integrator), given=.true.)
      call free_options(freed)
      if (freed%blocks(freed%find('DYNAMICS'))%word('INTEGRATOR') == 'ADAMS') &
         & call freed%set_option(freed%find('DYNAMICS'), 'INTEGRATOR', 'AUTO')
      call free_rungs(pool%deck, truth%rungs, rungs, aside)
      request%rungs = [rungs, aside]
      request%tolerance = truth%tolerance
      request%part = truth%tolerance/reached%advice%tolerance
      request%limit = least_patience + patience_time*candidate%work
      request%label = 'run aside, with all free that the deck fixes'
      call pool%run(request, check, error, freed)
      if (allocated(error)) then
         if (error%status == status_interrupted) return
         failure = first_line(error%message)
         deallocate (error)
      else
         failure = check%reason
      end if
      if (failure /= '') then
         if (reached%unverified /= '') reached%unverified = '; '//reached%unverified
         reached%unverified = reached%fixed//' (the run aside that would show its error failed: '//failure//')'//reached%unverified
         reached%fixed = ''
         return
      end if
      channels = size(truth%scale)
      n = size(truth%values, 2)
      allocate (away, source=largest_difference(check%samples%values, truth%values))
      reached%of_fixed = maxval(away/truth%scale)
      call truth%take(rungs, truth%tolerance, check%samples%values(:channels, :n), truth%rest + rest*away)
      call move_alloc(aside, truth%aside)
      truth%freed = freed
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

   !> Above what the deck fixes.
   subroutine free_rungs(deck, of_truth, rungs, aside)
      type(deck_type), intent(in) :: deck
      !> Those of the beams that limber chooses for, as they are in the truth
      type(level_type), intent(in) :: of_truth(:)
      !> The same with all free, and those of other beams
      type(level_type), allocatable, intent(out) :: rungs(:), aside(:)
      integer :: i, k
      allocate (rungs, source=of_truth)
      allocate (aside(0))
      do i = 1, size(deck%blocks)
         if (fixed_words(deck%blocks(i)) == '') cycle
         do k = 1, size(rungs)
            if (rungs(k)%block == i) exit
         end do
         if (k <= size(rungs)) then
            rungs(k) = free_rung(rungs(k))
         else
            aside = [aside, free_rung(given_rung(deck, i))]
         end if
      end do
   end subroutine free_rungs

   !> A rung with all open, higher, exact and with strain.
   type(level_type) function free_rung(rung) result(free)
      type(level_type), intent(in) :: rung
      free = rung
      free%level = level_exact
      free%open_level = .true.
      free%open_functions = .true.
      free%open_strains = .true.
      free%functions = -1
      free%strains = -1
      ! Of modes a few are as many functions
      free = verifying(richer(free, max(0, 3 - free%step), .true.), .true.)
   end function free_rung

end module limber_accuracy_fixed_options
