!> Checks of *STUDY: lists that cannot be meant of the beams that it varies, before anything runs. Floor: deck.
module limber_deck_study_checks
   use limber_base_kinds, only: wp
   use limber_deck_content, only: deck_type
   use limber_deck_diagnostics, only: diagnostics_type
   implicit none
   private
   public :: check_study, study_beams, place_of, counts_by_kind

   !> Lists that mean something of beams with modes, and of exact ones
   character(*), parameter :: lists_of_modes(3) = [character(18) :: 'modes', 'bending modes', 'geometric elements'], &
      & lists_of_exact(2) = [character(18) :: 'functions', 'strain functions']

contains

   !> Reports lists that are given twice, or that mean nothing of the beams.
   subroutine check_study(deck, index, diagnostics)
      !> With the models of its beams
      type(deck_type), intent(in) :: deck
      !> Its block
      integer, intent(in) :: index
      type(diagnostics_type), intent(inout) :: diagnostics
      integer, allocatable :: beams(:)
      integer :: i, k
      allocate (beams, source=study_beams(deck, index))
      if (deck%blocks(index)%real('ERROR') >= 1.0_wp) call diagnostics%add(deck%blocks(index)%origin_of('ERROR'), &
         & 'no error that can be aimed at', 'give a relative error below 1')
      associate (lines => deck%blocks(index)%lines)
         do i = 1, size(lines)
            k = place_of(deck, index, lines(i)%text(1))
            if (k > i) call diagnostics%add(lines(k)%origin_of(1), "the list '"//lines(i)%text(1)//"' is given twice", &
               & 'remove one of the two', lines(i)%origin_of(1), 'the first one is here')
            select case (lines(i)%text(1))
            case ('modes'); call check_modes(i, .true., 'bending modes')
            case ('bending modes'); call check_modes(i, .false., 'modes')
            end select
            call check_model(i)
            if (any(lines(i)%text(1) == [character(18) :: lists_of_modes, lists_of_exact, 'fidelities']) &
               & .and. size(beams) == 0) call diagnostics%add(lines(i)%origin_of(1), 'the deck has no *BEAM to vary')
         end do
      end associate

   contains

      !> A list that means nothing of the model of a beam.
      subroutine check_model(line)
         integer, intent(in) :: line
         logical :: exact
         integer :: j
         exact = any(deck%blocks(index)%lines(line)%text(1) == lists_of_exact)
         if (.not. (exact .or. any(deck%blocks(index)%lines(line)%text(1) == lists_of_modes))) return
         do j = 1, size(beams)
            if ((deck%blocks(beams(j))%word('GEOMETRIC') == 'EXACT') .eqv. exact) cycle
            call diagnostics%add(deck%blocks(index)%lines(line)%origin_of(1), "beam '"//deck%blocks(beams(j))%name()// &
               & "' is "//deck%blocks(beams(j))%word('GEOMETRIC')//" and has no '"//deck%blocks(index)%lines(line)%text(1)//"'", &
               & 'choose the beam by BEAM=, or its model by GEOMETRIC=')
            return
         end do
      end subroutine check_model

      !> A number of modes that the beam does not look at.
      subroutine check_modes(line, by_kind, other)
         integer, intent(in) :: line
         logical, intent(in) :: by_kind
         character(*), intent(in) :: other
         integer :: j
         do j = 1, size(beams)
            if (counts_by_kind(deck, beams(j)) .neqv. by_kind) cycle
            call diagnostics%add(deck%blocks(index)%lines(line)%origin_of(1), "beam '"//deck%blocks(beams(j))%name()// &
               & "' has its modes counted "//trim(merge('by kind ', 'together', by_kind)), "give the list '"//other//"'")
         end do
      end subroutine check_modes

   end subroutine check_study

   !> The beams that are varied: their blocks.
   pure function study_beams(deck, block) result(beams)
      type(deck_type), intent(in) :: deck
      !> Index of *STUDY; 0 without
      integer, intent(in) :: block
      integer, allocatable :: beams(:)
      integer :: i
      allocate (beams, source=deck%indices('BEAM'))
      if (block == 0) return
      if (.not. deck%blocks(block)%has('BEAM')) return
      beams = pack(beams, [(deck%blocks(beams(i))%name() == deck%blocks(block)%name('BEAM'), i=1, size(beams))])
   end function study_beams

   !> Line of *STUDY with a list; 0: none.
   pure integer function place_of(deck, block, name) result(line)
      type(deck_type), intent(in) :: deck
      !> Index of *STUDY; 0 without
      integer, intent(in) :: block
      !> Name of the list
      character(*), intent(in) :: name
      line = 0
      if (block == 0) return
      do line = size(deck%blocks(block)%lines), 1, -1
         if (deck%blocks(block)%lines(line)%text(1) == name) return
      end do
   end function place_of

   !> Whether a beam has its modes counted by kind, bending and axial.
   pure logical function counts_by_kind(deck, beam)
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: beam
      counts_by_kind = deck%blocks(beam)%given('BENDING MODES') .or. deck%blocks(beam)%given('AXIAL MODES')
   end function counts_by_kind

end module limber_deck_study_checks
