!> Fidelity levels of a beam. Rigid, then exact with more and more functions; of a beam whose model the deck gives, more and more of
!> its coordinates. One table has all of it. Which rung the deck gives or leaves open, and a rung in the deck. Floor: accuracy.
!> Equations: doc/theory, part 7.
module limber_accuracy_fidelity_levels
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_deck_content, only: deck_type, block_type, line_type
   use limber_deck_families, only: options_of_exact
   use limber_model_body_parts, only: is_part
   implicit none
   private
   public :: level_type, find_rungs, given_rung, bare_deck, apply_rung, richer, poorer, verifying, can_climb, rung_name, names_of
   public :: functions_of, strains_of, same_rungs, with_one_strain

   !> Models of a beam that bends
   integer, parameter, public :: level_linear = 1, level_kg = 2, level_exact = 3
   character(6), parameter :: level_words(3) = ['LINEAR', 'K_G   ', 'EXACT ']
   !> The rungs above the rigid one: functions of the section angle, or bending modes; functions of the strain where it matters, or
   !> axial modes
   integer, parameter :: ladder(2, 10) = reshape([1, 1, 2, 1, 3, 2, 5, 2, 7, 3, 10, 4, 14, 5, 20, 6, 28, 8, 40, 12], [2, 10])
   !> Rungs from which on the next one verifies them, else the one after it; most coordinates of a beam that something slides along
   integer, parameter :: close_steps = 4, most_under_slider = 24
   !> Elements and their geometric parts of a beam whose modes are chosen: of no cost in the time loop
   integer, parameter :: elements = 200, geometric_elements = 12
   !> Axial modes of K_G: half as many leave out twice as much of the tension
   integer, parameter :: many_axial = 8

   !> A beam on its rung
   type :: level_type
      !> Its block in the deck
      integer :: block = 0
      !> Its model if it bends: level_linear, ...
      integer :: level = level_exact
      !> Place in the ladder; 0: rigid
      integer :: step = 1
      !> Whether its strain has functions of its own; functions that it has else: more than none where joints hold both ends
      logical :: stretches = .false.
      integer :: least = 0
      !> Whether limber chooses the model, the functions of the angle, and those of the strain
      logical :: open_level = .false., open_functions = .false., open_strains = .false.
      !> Functions that the deck gives; negative: none
      integer :: functions = -1, strains = -1
      !> Lowest and highest place in the ladder
      integer :: lowest = 0, highest = size(ladder, 2)
      !> Most functions of both; least functions of the angle of a run that verifies others: fewer may all lack the same shape
      integer :: most = huge(1), enough = 0
   end type level_type

contains

   !> The beams whose fidelity the deck leaves open, wholly or in part.
   subroutine find_rungs(deck, rungs)
      type(deck_type), intent(in) :: deck
      type(level_type), allocatable, intent(out) :: rungs(:)
      type(level_type) :: rung
      integer, allocatable :: beams(:)
      integer :: i
      allocate (rungs(0))
      allocate (beams, source=deck%indices('BEAM'))
      do i = 1, size(beams)
         rung = given_rung(deck, beams(i))
         if (rung%open_level .or. rung%open_functions .or. rung%open_strains) rungs = [rungs, rung]
      end do
   end subroutine find_rungs

   !> What the deck says of a beam.
   function given_rung(deck, place) result(rung)
      type(deck_type), intent(in) :: deck
      !> Index of its block
      integer, intent(in) :: place
      type(level_type) :: rung
      associate (block => deck%blocks(place))
         rung%block = place
         rung%level = level_of(block%word('GEOMETRIC'))
         rung%open_level = rung%level == level_exact .and. .not. block%given('GEOMETRIC')
         if (block%word('GEOMETRIC') == 'RIGID') rung%step = 0
         if (rung%level == level_exact) then
            rung%open_functions = .not. block%given('FUNCTIONS')
            rung%open_strains = .not. block%given('STRAIN FUNCTIONS')
            if (block%given('FUNCTIONS')) rung%functions = block%integer('FUNCTIONS')
            if (block%given('STRAIN FUNCTIONS')) rung%strains = block%integer('STRAIN FUNCTIONS')
         else
            rung%open_functions = .not. gives_any(block, [character(13) :: 'MODES', 'BENDING MODES', 'AXIAL MODES'])
         end if
         if (rung%step == 0) then
            rung%open_functions = .false.
            rung%open_strains = .false.
         end if
         if (.not. rung%open_level .or. block%integer('SEGMENTS') > 1 .or. has_features(deck, place)) rung%lowest = 1
      end associate
      if (carries_slider(deck, deck%blocks(place)%name())) then
         rung%most = most_under_slider
         rung%highest = count(ladder(1, :) < most_under_slider)
      end if
      ! As many steps as the functions that are given
      if (rung%functions > 0) rung%step = max(1, count(ladder(1, :rung%highest - 1) <= rung%functions))
      if (rung%functions > 0) rung%lowest = 1
   end function given_rung

   !> The model that a word names, of a beam that bends.
   pure integer function level_of(word) result(level)
      character(*), intent(in) :: word
      level = level_kg
      if (word == 'LINEAR') level = level_linear
      if (word == 'EXACT' .or. word == 'RIGID') level = level_exact
   end function level_of

   !> Whether a block gives one of these options.
   pure logical function gives_any(block, names)
      type(block_type), intent(in) :: block
      character(*), intent(in) :: names(:)
      integer :: i
      gives_any = .false.
      do i = 1, size(names)
         if (.not. block%knows(trim(names(i)))) cycle
         gives_any = gives_any .or. block%given(trim(names(i)))
      end do
   end function gives_any

   !> Whether a beam has what only an exact one can have: shear, a changing section, curvature, heat, tension.
   pure logical function has_features(deck, place)
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: place
      integer :: i
      has_features = gives_any(deck%blocks(place), options_of_exact(3:))
      i = deck%find('PROFILE')
      do while (i > 0)
         has_features = has_features .or. is_part(deck, i, place)
         i = deck%find('PROFILE', i)
      end do
   end function has_features

   !> Whether a joint slides along a beam.
   pure logical function carries_slider(deck, name)
      type(deck_type), intent(in) :: deck
      character(*), intent(in) :: name
      integer :: i
      carries_slider = .false.
      i = deck%find('JOINT')
      do while (i > 0)
         associate (block => deck%blocks(i))
            if (block%word('TYPE') == 'SLIDING' .and. size(block%lines) > 0) then
               if (block%lines(1)%count() > 1) carries_slider = carries_slider .or. block%lines(1)%text(2) == name
            end if
         end associate
         i = deck%find('JOINT', i)
      end do
   end function carries_slider

   !> Functions of the section angle, or bending modes, of a rung.
   elemental integer function functions_of(rung) result(functions)
      type(level_type), intent(in) :: rung
      functions = 0
      if (rung%step > 0) functions = ladder(1, rung%step)
      if (rung%functions >= 0) functions = rung%functions
   end function functions_of

   !> Functions of the strain, or axial modes, of a rung.
   elemental integer function strains_of(rung) result(strains)
      type(level_type), intent(in) :: rung
      strains = 0
      if (rung%step == 0) return
      if (rung%stretches .or. rung%level < level_exact) strains = ladder(2, rung%step)
      strains = max(min(strains, rung%most - functions_of(rung)), rung%least)
      if (rung%strains >= 0) strains = rung%strains
   end function strains_of

   !> A rung higher in the ladder, or with strain, as far as the deck leaves it open.
   elemental type(level_type) function richer(rung, steps, stretches)
      type(level_type), intent(in) :: rung
      integer, intent(in) :: steps
      logical, intent(in) :: stretches
      richer = rung
      if (rung%open_functions) richer%step = min(rung%highest, rung%step + steps)
      if (richer%step > 0 .and. rung%open_strains) richer%stretches = rung%stretches .or. stretches
   end function richer

   !> A beam that bends with one function of the strain, if it has none and the deck leaves it open.
   elemental type(level_type) function with_one_strain(rung)
      type(level_type), intent(in) :: rung
      with_one_strain = rung
      if (rung%step > 0 .and. rung%open_strains) with_one_strain%least = max(1, rung%least)
   end function with_one_strain

   !> The rung that verifies another.
   elemental type(level_type) function verifying(rung, stretches)
      type(level_type), intent(in) :: rung
      logical, intent(in) :: stretches
      verifying = richer(rung, merge(1, 2, rung%step >= close_steps), stretches)
      do while (verifying%open_functions .and. verifying%step < rung%highest .and. functions_of(verifying) < rung%enough)
         verifying%step = verifying%step + 1
      end do
   end function verifying

   !> The rung below; the same if there is none.
   elemental type(level_type) function poorer(rung)
      type(level_type), intent(in) :: rung
      poorer = rung
      if (rung%open_functions) poorer%step = max(rung%lowest, rung%step - 1)
      if (poorer%step == 0) poorer%stretches = .false.
   end function poorer

   !> Whether there is a rung above for a run that is to be verified.
   elemental logical function can_climb(rung)
      type(level_type), intent(in) :: rung
      can_climb = rung%open_functions .and. rung%step < rung%highest - 1 .or. rung%open_strains .and. .not. rung%stretches
   end function can_climb

   !> Whether two scenes have the same functions of all their beams.
   pure logical function same_rungs(a, b)
      type(level_type), intent(in) :: a(:), b(:)
      same_rungs = size(a) == size(b)
      if (same_rungs) same_rungs = all(a%block == b%block .and. a%level == b%level .and. (a%step > 0 .eqv. b%step > 0) .and. &
         & functions_of(a) == functions_of(b) .and. strains_of(a) == strains_of(b))
   end function same_rungs

   !> Leaves out the damping of modes that a rung does not have.
   subroutine keep_damping(rung, deck)
      type(level_type), intent(in) :: rung
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
                  if (nint(lines(j)%number(1)) > functions_of(rung)) cycle
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
         case ('OUTPUT', 'SCALAR', 'DAMPING', 'PROFILE'); bare%blocks(i)%keyword = 'STUDY'
         end select
      end do
   end subroutine bare_deck

   !> Writes a rung into the deck, as a user would; what the deck gives stays.
   subroutine apply_rung(rung, deck)
      type(level_type), intent(in) :: rung
      type(deck_type), intent(inout) :: deck
      if (rung%open_functions) call keep_damping(rung, deck)
      if (rung%step == 0) then
         if (rung%open_level) call deck%set_option(rung%block, 'GEOMETRIC', 'RIGID', given=.true.)
         return
      end if
      if (rung%open_level) call deck%set_option(rung%block, 'GEOMETRIC', trim(level_words(rung%level)), given=.true.)
      if (rung%level == level_exact) then
         if (rung%open_functions) call number('FUNCTIONS', functions_of(rung))
         if (rung%open_strains) call number('STRAIN FUNCTIONS', strains_of(rung))
      else if (rung%open_functions) then
         call number('BENDING MODES', functions_of(rung))
         call number('AXIAL MODES', merge(many_axial, strains_of(rung), rung%level == level_kg))
         call number('ELEMENTS', elements)
         if (rung%level == level_kg) call number('GEOMETRIC ELEMENTS', geometric_elements)
      end if

   contains

      !> Sets a number that the deck leaves open.
      subroutine number(name, value)
         character(*), intent(in) :: name
         integer, intent(in) :: value
         if (.not. deck%blocks(rung%block)%given(name)) call deck%set_number(rung%block, name, real(value, wp), given=.true.)
      end subroutine number

   end subroutine apply_rung

   !> A rung for people: 'EXACT 5 + 2', functions of the angle and of the strain.
   function rung_name(rung) result(text)
      type(level_type), intent(in) :: rung
      character(:), allocatable :: text
      text = 'RIGID'
      if (rung%step > 0) text = trim(level_words(rung%level))//' '//as_text(functions_of(rung))//' + '//as_text(strains_of(rung))
   end function rung_name

   !> Rungs for people: 'EXACT 5 + 2; RIGID'.
   function names_of(rungs) result(text)
      type(level_type), intent(in) :: rungs(:)
      character(:), allocatable :: text
      integer :: i
      text = ''
      do i = 1, size(rungs)
         if (i > 1) text = text//'; '
         text = text//rung_name(rungs(i))
      end do
   end function names_of

end module limber_accuracy_fidelity_levels
