!> Models of a beam and the options of each. The options that mean something for some of them only, and the model that a deck means
!> by what it gives. Floor: deck.
module limber_deck_families
   use limber_deck_content, only: deck_type, block_type
   use limber_deck_body_options, only: beam_options, frame_options
   implicit none
   private
   public :: is_void, settle_models

   !> Options of beams that mean something with modes only, and of exact beams only; of all flexible beams only; of frames, with
   !> modes only
   character(20), parameter, public :: options_of_modes(*) = pack(beam_options%name, beam_options%models == 'MODES')
   character(20), parameter, public :: options_of_exact(*) = pack(beam_options%name, beam_options%models == 'EXACT')
   character(20), parameter, public :: options_of_mesh(*) = [character(20) :: 'ELEMENTS', 'SUPPORT', 'SEGMENTS']
   character(20), parameter, public :: options_of_frame_modes(*) = pack(frame_options%name, frame_options%models == 'MODES')
   !> Where bodies are at first, and how fast: kept if the deck gives it, otherwise found by the assembly
   character(20), parameter :: bodies(*) = [character(20) :: 'POINT MASS', 'RIGID BODY', 'BEAM', 'FRAME']
   character(20), parameter :: options_of_first_state(*) = [character(20) :: 'X', 'Y', 'ANGLE', 'VX', 'VY', 'SPIN']

contains

   !> The model of each beam that the deck leaves open: EXACT, or K_G where the deck asks for modes of the beam, and its axial
   !> functions if
   !> it has modes.
   pure subroutine settle_models(deck)
      type(deck_type), intent(inout) :: deck
      logical :: studied
      integer :: i
      studied = studies_modes(deck)
      do i = 1, size(deck%blocks)
         if (deck%blocks(i)%keyword /= 'BEAM') cycle
         associate (block => deck%blocks(i))
            if (.not. block%given('GEOMETRIC') .and. (studied .or. gives_modes(block) .or. has_attachments(deck, i))) &
               & call deck%set_option(i, 'GEOMETRIC', 'K_G')
            if (any(block%word('GEOMETRIC') == ['LINEAR', 'K_G   ']) .and. .not. block%given('AXIAL BASIS')) &
               & call deck%set_option(i, 'AXIAL BASIS', merge('MODES ', 'STATIC', counts_modes(block)))
         end associate
      end do
   end subroutine settle_models

   !> Whether a beam says what modes it has; if not, its axial functions are static ones, which carry tension whatever their number.
   pure logical function counts_modes(block)
      type(block_type), intent(in) :: block
      counts_modes = block%given('MODES') .or. block%given('BENDING MODES') .or. block%given('AXIAL MODES') &
         & .or. block%yes('CORRECTIONS')
   end function counts_modes

   !> Whether a beam gives an option of modes.
   pure logical function gives_modes(block)
      type(block_type), intent(in) :: block
      integer :: i
      gives_modes = .false.
      do i = 1, size(options_of_modes)
         gives_modes = gives_modes .or. block%given(trim(options_of_modes(i)))
      end do
   end function gives_modes

   !> Whether *ATTACHMENT gives functions of a beam: by its name, or right below it.
   pure logical function has_attachments(deck, beam)
      type(deck_type), intent(in) :: deck
      !> Index of its block
      integer, intent(in) :: beam
      logical :: below
      integer :: i
      has_attachments = .false.
      below = .true.
      do i = 1, size(deck%blocks)
         if (i > beam) below = below .and. deck%blocks(i)%keyword /= 'BEAM' .and. deck%blocks(i)%keyword /= 'FRAME'
         if (deck%blocks(i)%keyword /= 'ATTACHMENT') cycle
         if (deck%blocks(i)%has('BODY')) then
            has_attachments = has_attachments .or. deck%blocks(i)%name('BODY') == deck%blocks(beam)%name()
         else
            has_attachments = has_attachments .or. (i > beam .and. below)
         end if
      end do
   end function has_attachments

   !> Whether a *STUDY compares numbers of modes or of geometric elements.
   pure logical function studies_modes(deck)
      type(deck_type), intent(in) :: deck
      integer :: i, k
      studies_modes = .false.
      i = deck%find('STUDY')
      if (i == 0) return
      do k = 1, size(deck%blocks(i)%lines)
         if (deck%blocks(i)%lines(k)%count() == 0) cycle
         studies_modes = studies_modes .or. any(deck%blocks(i)%lines(k)%text(1) == &
            & [character(18) :: 'modes', 'bending modes', 'geometric elements'])
      end do
   end function studies_modes

   !> Whether an option that the deck does not give means nothing of a body.
   pure logical function is_void(keyword, model, option)
      !> Of the block; its GEOMETRIC, of a frame LARGE or its GEOMETRIC; the option's name
      character(*), intent(in) :: keyword, model, option
      is_void = any(bodies == keyword) .and. any(options_of_first_state == option)
      if (is_void) return
      if (keyword == 'FRAME' .and. model == 'LARGE') is_void = any(options_of_frame_modes == option)
      if (keyword == 'FRAME' .and. model == 'RIGID') is_void = option /= 'GEOMETRIC' .and. any(options_of_frame_modes == option)
      if (keyword /= 'BEAM') return
      if (model == 'EXACT') then
         ! The functions of an exact beam are found from what holds it
         is_void = any(options_of_modes == option) .or. option == 'SUPPORT'
      else
         is_void = any(options_of_exact == option)
         if (model == 'RIGID') is_void = is_void .or. any(options_of_mesh == option) .or. any(options_of_modes == option)
      end if
   end function is_void

end module limber_deck_families
