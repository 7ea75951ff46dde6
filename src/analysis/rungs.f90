!> The ladder of fidelities of a beam, from rigid over linear and k_g to full, with more coordinates on the higher rungs and with
!> the beam divided on the last: what a rung asks of the deck, which rung comes next, and which options the deck leaves open.
!> Floor: analysis. Equations: doc/theory.md, accuracy on request.
module limber_analysis_rungs
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_deck_content, only: deck_type, line_type
   use limber_deck_keywords, only: keyword_options
   use limber_deck_schema, only: option_spec_type
   use limber_model_parts, only: is_part
   implicit none
   private
   public :: rung_type, find_rungs, bare_deck, apply_rung, next_rung, better_rung, can_climb, rung_name, has_option, functions_of
   public :: given_rung, enough_derivatives, all_derivatives, in_pieces, lower_rungs, bound_rung, rest_beyond

   !> Levels of the ladder
   integer, parameter, public :: level_rigid = 0, level_linear = 1, level_kg = 2, level_full = 3
   !> Most bending modes, and most pieces of a beam and modes in each
   integer, parameter, public :: most_modes = 12, most_segments = 16, most_elements = 480, most_piece_modes = 6
   !> Most rungs just below one
   integer, parameter, public :: most_lower = 4
   !> Pieces that a beam is divided into first
   integer, parameter, public :: first_pieces = 2
   !> Words of the option GEOMETRIC for the levels
   character(6), parameter :: level_words(0:3) = ['RIGID ', 'LINEAR', 'K_G   ', 'FULL  ']
   !> Elements of the geometric part: of no cost in the time loop
   integer, parameter :: geometric_elements = 12
   !> Elements of the geometric part of a piece for each of its bending modes, each with an axial function; and shapes of its ends
   integer, parameter :: of_piece = 2, of_ends = 2

   !> A beam on its rung
   type :: rung_type
      !> Its block in the deck
      integer :: block = 0
      !> level_rigid, ...
      integer :: level = level_kg
      !> Bending modes, modal derivatives of FULL, finite elements, pieces
      integer :: bending = 1, derivatives = 0, elements = 48, segments = 1
      !> Whether something pulls at its end, so that its axial functions have the response to an end force
      logical :: pulled = .false.
      !> Whether its axial functions have the response to the centrifugal load too although something pulls
      logical :: spun = .false.
      !> Whether a linear beam stretches
      logical :: stretched = .false.
      !> Whether it has the shapes of forces and moments at its ends beside its modes, of which none is loaded there
      logical :: shaped = .false.
      !> Whether its axial coordinates follow at rest
      logical :: at_rest = .false.
      !> Whether it is damped by its modes, which pieces of it do not have
      logical :: damped = .false.
      !> Whether the deck gives the number of elements; whether an end of the supports is free
      logical :: given_elements = .false., free_end = .false.
      !> Whether limber chooses the level, the modes, the number of pieces, whether axial coordinates follow at rest
      logical :: open_level = .false., open_modes = .false., open_segments = .false., open_axial = .false.
   end type rung_type

contains

   !> The beams whose fidelity the deck leaves open, wholly or in part.
   subroutine find_rungs(deck, rungs)
      type(deck_type), intent(in) :: deck
      type(rung_type), allocatable, intent(out) :: rungs(:)
      type(rung_type) :: rung
      integer, allocatable :: beams(:)
      integer :: i
      allocate (rungs(0))
      allocate (beams, source=deck%indices('BEAM'))
      do i = 1, size(beams)
         if (deck%blocks(beams(i))%word('GEOMETRIC') == 'EXACT' .and. deck%blocks(beams(i))%given('GEOMETRIC')) cycle
         rung = given_rung(deck, beams(i))
         if (rung%segments == 1 .and. (rung%open_level .or. rung%open_modes)) rungs = [rungs, rung]
      end do
   end subroutine find_rungs

   !> What the deck says of a beam.
   function given_rung(deck, place) result(rung)
      type(deck_type), intent(in) :: deck
      !> Index of its block
      integer, intent(in) :: place
      type(rung_type) :: rung
      logical :: held
      integer :: level
      associate (block => deck%blocks(place))
         rung%block = place
         rung%open_level = .not. block%given('GEOMETRIC')
         rung%open_modes = .not. (block%given('MODES') .or. block%given('BENDING MODES') .or. block%given('AXIAL MODES'))
         rung%damped = damped_by_modes(deck, block%name())
         rung%open_segments = has_option('SEGMENTS') .and. .not. (block%given('SEGMENTS') .or. rung%damped)
         rung%open_axial = .not. block%given('AXIAL DYNAMICS')
         do level = level_rigid, level_full
            if (level_words(level) == block%word('GEOMETRIC')) rung%level = level
         end do
         if (.not. rung%open_level .and. rung%level == level_rigid) rung%open_modes = .false.
         rung%given_elements = block%given('ELEMENTS')
         rung%free_end = index(block%word('SUPPORT'), 'FREE') > 0
         if (rung%given_elements) rung%elements = block%integer('ELEMENTS')
         if (block%given('MODES')) rung%bending = max(1, block%integer('MODES') - 1)
         if (block%given('BENDING MODES')) rung%bending = block%integer('BENDING MODES')
         if (has_option('SEGMENTS') .and. block%given('SEGMENTS')) rung%segments = block%integer('SEGMENTS')
         held = holds_end(deck, block%name(), .false.)
         rung%pulled = holds_end(deck, block%name(), .true.) .or. block%word('SUPPORT') == 'FREE-FREE'
         rung%shaped = rung%open_modes .and. held .and. block%word('SUPPORT') == 'CLAMPED-FREE' .and. &
            & .not. (block%given('END SHAPES') .or. block%given('CORRECTIONS') .or. is_attached(deck, place))
      end associate
   end function given_rung

   !> Whether an *ATTACHMENT gives functions of a beam.
   pure logical function is_attached(deck, place)
      type(deck_type), intent(in) :: deck
      !> Index of its block
      integer, intent(in) :: place
      integer :: i
      is_attached = .false.
      i = deck%find('ATTACHMENT')
      do while (i > 0)
         is_attached = is_attached .or. is_part(deck, i, place)
         i = deck%find('ATTACHMENT', i)
      end do
   end function is_attached

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

   !> Whether a joint or spring acts on a beam anywhere but at its start.
   pure logical function holds_end(deck, name, loads)
      type(deck_type), intent(in) :: deck
      character(*), intent(in) :: name
      !> Whether forces and torques count as well
      logical, intent(in) :: loads
      integer :: i, j, k
      holds_end = .false.
      do i = 1, size(deck%blocks)
         select case (deck%blocks(i)%keyword)
         case ('FORCE', 'TORQUE')
            if (loads .and. beyond_start(deck%blocks(i)%text('POINT'))) holds_end = .true.
         case ('JOINT', 'SPRING', 'BUSHING')
            do j = 1, size(deck%blocks(i)%lines)
               do k = 1, min(2, deck%blocks(i)%lines(j)%count())
                  if (beyond_start(deck%blocks(i)%lines(j)%text(k))) holds_end = .true.
               end do
            end do
         end select
      end do

   contains

      !> Whether a point of the beam is not its start.
      pure logical function beyond_start(point)
         character(*), intent(in) :: point
         beyond_start = index(point, name//'.') == 1 .and. point /= name//'.start' .and. point /= name//'.origin'
      end function beyond_start

   end function holds_end

   !> Whether beams have an option at all.
   logical function has_option(name)
      character(*), intent(in) :: name
      type(option_spec_type), allocatable :: specs(:)
      allocate (specs, source=keyword_options('BEAM'))
      has_option = any(specs%name == name)
   end function has_option

   !> Leaves out the damping of modes that a rung does not have.
   subroutine keep_damping(rung, deck)
      type(rung_type), intent(in) :: rung
      type(deck_type), intent(inout) :: deck
      type(line_type), allocatable :: kept(:)
      integer :: i, j, count
      i = deck%find('DAMPING')
      do while (i > 0)
         associate (lines => deck%blocks(i)%lines)
            if (deck%blocks(i)%name('BODY') == deck%blocks(rung%block)%name() .and. size(lines) > 0) then
               allocate (kept(size(lines)))
               count = 0
               do j = 1, size(lines)
                  if (rung%level == level_rigid .or. nint(lines(j)%number(1)) > rung%bending) cycle
                  count = count + 1
                  kept(count) = lines(j)
               end do
               deck%blocks(i)%lines = kept(:count)
               deallocate (kept)
            end if
         end associate
         i = deck%find('DAMPING', i)
      end do
   end subroutine keep_damping

   !> The deck without outputs, damping and given deflections, which ask for coordinates that a rung need not have.
   subroutine bare_deck(deck, bare)
      type(deck_type), intent(in) :: deck
      type(deck_type), intent(out) :: bare
      integer :: i
      bare = deck
      do i = 1, size(bare%blocks)
         if (bare%blocks(i)%keyword == 'ASSEMBLY') bare%blocks(i)%lines = bare%blocks(i)%lines(:0)
         ! Blocks keep their places: this becomes one that no model is made of
         select case (bare%blocks(i)%keyword)
         case ('OUTPUT', 'SCALAR', 'DAMPING'); bare%blocks(i)%keyword = 'STUDY'
         end select
      end do
   end subroutine bare_deck

   !> Writes a rung into the deck, as a user would; what the deck gives stays.
   subroutine apply_rung(rung, deck)
      type(rung_type), intent(in) :: rung
      type(deck_type), intent(inout) :: deck
      logical :: statics
      statics = rung%level >= level_kg
      if (rung%open_modes .or. rung%open_level) call keep_damping(rung, deck)
      if (rung%open_level) call deck%set_option(rung%block, 'GEOMETRIC', trim(level_words(rung%level)), given=.true.)
      if (rung%level == level_rigid) return
      if (rung%segments > 1) then
         ! A piece has the shapes of its ends besides, and axial functions of its own
         call number('SEGMENTS', rung%segments)
         if (rung%open_modes) call number('BENDING MODES', rung%bending)
         call number('ELEMENTS', max(6, of_piece*rung%bending, rung%elements/rung%segments))
         call number('GEOMETRIC ELEMENTS', of_piece*rung%bending)
         return
      end if
      if (rung%open_modes) then
         call number('BENDING MODES', rung%bending)
         call number('AXIAL MODES', merge(0, merge(1, 0, rung%stretched), statics))
      end if
      call number('ELEMENTS', rung%elements)
      if (rung%shaped) call word('END SHAPES', 'YES')
      if (rung%at_rest) call word('AXIAL DYNAMICS', 'STATIC')
      if (.not. statics) return
      call number('GEOMETRIC ELEMENTS', min(geometric_elements, rung%elements))
      if (.not. rung%open_modes .and. rung%level == level_kg) return
      call word('AXIAL BASIS', 'STATIC')
      call word('END FORCE', merge('YES', 'NO ', rung%pulled))
      call word('CENTRIFUGAL', merge('YES', 'NO ', rung%spun .or. .not. rung%pulled))
      call number('MODAL DERIVATIVES', merge(rung%derivatives, 0, rung%level == level_full))

   contains

      !> Sets a number that the deck leaves open.
      subroutine number(name, value)
         character(*), intent(in) :: name
         integer, intent(in) :: value
         if (.not. deck%blocks(rung%block)%given(name)) call deck%set_number(rung%block, name, real(value, wp), given=.true.)
      end subroutine number

      !> Sets a word that the deck leaves open.
      subroutine word(name, value)
         character(*), intent(in) :: name, value
         if (.not. deck%blocks(rung%block)%given(name)) call deck%set_option(rung%block, name, trim(value), given=.true.)
      end subroutine word

   end subroutine apply_rung

   !> Number of axial functions of a rung.
   pure integer function functions_of(rung) result(functions)
      type(rung_type), intent(in) :: rung
      functions = 0
      if (rung%segments > 1) then
         functions = of_ends + of_piece*rung%bending
         return
      end if
      select case (rung%level)
      case (level_linear); functions = merge(1, 0, rung%stretched)
      case (level_kg, level_full)
         functions = merge(merge(2, 1, rung%spun), 1, rung%pulled)
         if (rung%level == level_full) functions = min(geometric_elements, functions + &
            & min(rung%derivatives, pairs_of(rung)))
      end select
   end function functions_of

   !> Whether there is a rung above.
   elemental logical function can_climb(rung)
      type(rung_type), intent(in) :: rung
      can_climb = rung%open_level .and. rung%level < level_full
      if (rung%segments > 1) then
         can_climb = rung%open_segments .and. rung%segments < most_segments
         if (rung%open_modes) can_climb = can_climb .or. rung%bending < most_piece_modes
         return
      end if
      if (rung%level > level_rigid) can_climb = can_climb .or. rung%at_rest .or. (rung%open_modes .and. rung%bending < most_modes) &
         & .or. (rung%open_segments .and. rung%segments < most_segments)
   end function can_climb

   !> The next rung: higher in fidelity and richer in coordinates, with axial vibrations, so that what both leave out shows; behind
   !> the richest in one frame the beam is divided.
   pure function next_rung(rung) result(next)
      type(rung_type), intent(in) :: rung
      type(rung_type) :: next
      next = rung
      next%at_rest = .false.
      if (.not. can_climb(next)) return
      if (rung%segments > 1) then
         if (rung%open_modes .and. rung%bending < most_piece_modes) then
            next%bending = rung%bending + 1
         else
            next%segments = 2*rung%segments
         end if
         if (.not. next%given_elements) next%elements = min(most_elements, 2*rung%elements)
         return
      end if
      if (rung%open_segments .and. rung%level > level_rigid .and. .not. (rung%open_level .and. rung%level < level_full .or. &
         & rung%open_modes .and. rung%bending < most_modes)) then
         next = in_pieces(next, first_pieces, most_piece_modes)
         return
      end if
      if (rung%level == level_rigid .and. rung%open_level) then
         next%level = level_linear
         if (next%open_modes) next%bending = 2
         return
      end if
      if (rung%open_level .and. rung%level < level_full) next%level = rung%level + 1
      if (rung%open_modes .and. rung%bending < most_modes) next%bending = min(most_modes, rung%bending &
         & + merge(1, 2, next%level == level_kg))
      ! So that it shows if too few lock
      if (next%open_modes .and. next%level == level_full) next%derivatives = all_derivatives(next)
      next%spun = next%bending > 1
      if (.not. next%given_elements) next%elements = min(most_elements, 2*rung%elements)
   end function next_rung

   !> Error of a higher rung as a part of the difference that it makes: of errors that fall with the third power of the modes, with
   !> the fourth of the pieces, and to a fifth by one order of the geometry.
   pure real(wp) function rest_beyond(rung, higher) result(part)
      type(rung_type), intent(in) :: rung, higher
      real(wp), parameter :: least = 0.1_wp, usual = 0.25_wp
      real(wp) :: ratio
      part = usual
      if (higher%level > rung%level .or. higher%segments > rung%segments .and. rung%segments == 1) return
      if (higher%segments > rung%segments) then
         ratio = (real(rung%segments, wp)/higher%segments)**4
      else if (higher%bending > rung%bending) then
         ratio = (real(rung%bending, wp)/higher%bending)**3
      else
         return
      end if
      part = max(least, ratio/(1 - ratio))
   end function rest_beyond

   !> A beam in pieces, full in each.
   pure function in_pieces(rung, pieces, bending) result(divided)
      type(rung_type), intent(in) :: rung
      !> Their number, and bending modes of each beside the shapes of its ends
      integer, intent(in) :: pieces, bending
      type(rung_type) :: divided
      divided = rung
      divided%at_rest = .false.
      divided%segments = pieces
      if (divided%open_level) divided%level = level_full
      if (divided%open_modes) divided%bending = bending
   end function in_pieces

   !> Lowers a rung to a level and a number of modes, in one frame, if it is above and the deck leaves that open; modes of a piece
   !> are not counted against those of a beam in one frame.
   subroutine bound_rung(rung, level, bending)
      type(rung_type), intent(inout) :: rung
      !> level_linear, ...
      integer, intent(in) :: level, bending
      if (rung%segments > 1 .and. .not. rung%open_segments .or. rung%level == level_rigid) return
      if (rung%segments > 1 .and. rung%open_modes) rung%bending = bending
      rung%segments = 1
      rung%at_rest = .false.
      if (rung%open_level) rung%level = min(rung%level, level)
      if (.not. rung%open_modes) return
      rung%bending = min(rung%bending, bending)
      rung%spun = rung%bending > 1
      if (rung%level == level_full) rung%derivatives = enough_derivatives(rung%bending)
   end subroutine bound_rung

   !> Rungs that leave out one thing more each: those that may do as well for less.
   subroutine lower_rungs(rung, lower, count)
      type(rung_type), intent(in) :: rung
      !> The first `count` of them
      type(rung_type), intent(out) :: lower(most_lower)
      integer, intent(out) :: count
      type(rung_type) :: less
      count = 0
      if (rung%segments > 1) then
         less = rung
         less%bending = rung%bending - 1
         if (rung%open_modes .and. rung%bending > 1) call add()
         less = in_pieces(rung, rung%segments/2, min(most_piece_modes, 2*rung%bending))
         if (rung%open_segments .and. rung%open_modes .and. rung%segments > first_pieces) then
            call add()
            less%bending = min(most_piece_modes, 2*rung%bending + 1)
            call add()
         end if
         less%bending = 3
         less%derivatives = enough_derivatives(less%bending)
         less%spun = .true.
         if (rung%open_segments .and. rung%open_modes .and. rung%segments == first_pieces) call add()
         return
      end if
      if (rung%level == level_full .and. rung%open_modes .and. rung%derivatives > enough_derivatives(rung%bending)) then
         less = rung
         less%derivatives = enough_derivatives(rung%bending)
         call add()
      end if
      if (rung%open_modes .and. rung%bending > 1 .and. rung%level > level_rigid) then
         less = rung
         less%bending = rung%bending - merge(2, 1, rung%bending > 5)
         less%spun = less%bending > 1
         less%derivatives = min(less%derivatives, enough_derivatives(less%bending))
         call add()
         less%derivatives = min(rung%derivatives, all_derivatives(less))
         if (rung%level == level_full .and. less%derivatives > enough_derivatives(less%bending)) call add()
      end if
      less = rung
      less%level = rung%level - 1
      if (rung%open_level .and. rung%level > level_linear) call add()

   contains

      subroutine add()
         count = count + 1
         lower(count) = less
      end subroutine add

   end subroutine lower_rungs

   !> The rung to go to from one that is not good enough: higher in fidelity, or where there is no higher one richer.
   pure function better_rung(rung, divided) result(better)
      type(rung_type), intent(in) :: rung
      !> Whether one frame is not enough, so that the beam is to be divided if limber may
      logical, intent(in) :: divided
      type(rung_type) :: better
      better = next_rung(rung)
      if (divided .and. rung%open_segments .and. rung%segments < most_segments) then
         better = in_pieces(rung, max(first_pieces, 2*rung%segments), merge(rung%bending, 2, rung%segments > 1))
         return
      end if
      if (better%segments > 1) better%elements = rung%elements
      if (better%segments > 1) return
      if (rung%at_rest) then
         better = rung
         better%at_rest = .false.
         return
      end if
      if (rung%level > level_rigid) better%elements = rung%elements
      if (.not. rung%open_modes) return
      if (better%level > rung%level .and. rung%level > level_rigid) better%bending = rung%bending
      if (rung%level == level_full .and. rung%bending < 3) better%bending = rung%bending + 1
      better%spun = better%bending > 1
      if (better%level == level_full .and. rung%level < level_full) better%derivatives = enough_derivatives(better%bending)
   end function better_rung

   !> Number of pairs of the bending coordinates, the shapes of the ends among them.
   pure integer function pairs_of(rung) result(pairs)
      type(rung_type), intent(in) :: rung
      integer :: n
      n = rung%bending + merge(of_ends, 0, rung%shaped)
      pairs = n*(n + 1)/2
   end function pairs_of

   !> Modal derivatives of all pairs of the bending coordinates of a beam in one frame, which never lock; more than there are
   !> geometric elements depend on each other.
   pure integer function all_derivatives(rung) result(derivatives)
      type(rung_type), intent(in) :: rung
      derivatives = min(pairs_of(rung), geometric_elements)
   end function all_derivatives

   !> Modal derivatives that so many bending modes are worth as a rule: those of the pairs of the first, as the others bend less.
   pure integer function enough_derivatives(bending) result(derivatives)
      integer, intent(in) :: bending
      integer, parameter :: numbers(*) = [1, 3, 3, 6, 6, 6, 6, 10]
      derivatives = numbers(min(bending, size(numbers)))
   end function enough_derivatives

   !> A rung for people: 'FULL 3 + 5', bending modes and axial functions; 'FULL 2 + 4, 2 pieces' of each piece.
   function rung_name(rung) result(text)
      type(rung_type), intent(in) :: rung
      character(:), allocatable :: text
      text = trim(level_words(rung%level))
      if (rung%level == level_rigid) return
      if (rung%segments > 1) then
         text = text//' '//as_text(rung%bending)//' + '//as_text(functions_of(rung) - of_ends)//', '// &
            & as_text(rung%segments)//' pieces'
         return
      end if
      text = text//' '//as_text(rung%bending)//' + '//as_text(functions_of(rung))
      if (rung%at_rest) text = text//', STATIC'
   end function rung_name

end module limber_analysis_rungs
