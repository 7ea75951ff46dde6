!> Checks of a whole deck: names, repetitions, required blocks. Names that are defined twice or not at all, blocks that may occur
!> once. Floor: deck.
module limber_deck_checks
   use limber_base_names, only: name_index_type
   use limber_base_text, only: nearest_name, suggestion, lowercase
   use limber_deck_origin, only: origin_type
   use limber_deck_diagnostics, only: diagnostics_type, max_shown, max_errors
   use limber_deck_parameters, only: name_length
   use limber_deck_schema, only: option_spec_type, field_spec_type, kind_name, kind_reference, form_channels
   use limber_deck_keywords, only: keyword_table, keyword_options, keyword_fields, find_keyword, contains_value, alternatives
   use limber_deck_content, only: deck_type, block_type, tell_block
   use limber_deck_idle_options, only: check_idle
   use limber_deck_study_checks, only: check_study
   use limber_deck_sweep_checks, only: check_sweep
   use limber_deck_unused_objects, only: warn_of_unused
   implicit none
   private
   public :: check_deck

   !> All names so far, each behind its scope, within which they must differ, and where they stand; only the first ones are in use
   type :: register_type
      type(name_index_type) :: names
      type(origin_type), allocatable :: origins(:)
   end type register_type

contains

   !> Adds the errors that only the whole deck shows.
   subroutine check_deck(deck, diagnostics)
      !> Blocks in error are marked
      type(deck_type), intent(inout) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      type(register_type) :: register
      integer :: i, before
      do i = 1, size(deck%blocks)
         if (diagnostics%count >= max_errors) return
         before = diagnostics%count
         call check_name(deck%blocks(i), register, diagnostics)
         if (diagnostics%count == before) cycle
         deck%blocks(i)%broken = .true.
         call tell_block(deck%blocks(i), diagnostics)
         ! The name that was meant is not known
         diagnostics%nameless = diagnostics%nameless + 1
      end do
      do i = 1, size(deck%blocks)
         if (diagnostics%count >= max_errors) return
         before = diagnostics%count
         call check_count(deck, i, diagnostics)
         call check_options(deck, i, diagnostics)
         call check_lines(deck, i, diagnostics)
         if (diagnostics%count == before) cycle
         deck%blocks(i)%broken = .true.
         call tell_block(deck%blocks(i), diagnostics)
      end do
      call check_ground(deck, diagnostics)
      call check_channels(deck, diagnostics)
      call explain_parameters(deck, diagnostics)
      if (diagnostics%count == 0) call warn_of_unused(deck, diagnostics)
   end subroutine check_deck

   !> Reports a second block of a keyword that may occur once.
   subroutine check_count(deck, i, diagnostics)
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: i
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: first
      associate (block => deck%blocks(i))
         if (keyword_table(find_keyword(block%keyword))%most > 1) return
         first = deck%find(block%keyword)
         if (first < i) call diagnostics%add(block%origin, 'a deck has only one *'//block%keyword, 'remove one of the two', &
            & deck%blocks(first)%origin, 'the first one is here')
      end associate
   end subroutine check_count

   !> Checks that the name of a block is its own.
   subroutine check_name(block, register, diagnostics)
      type(block_type), intent(in) :: block
      type(register_type), intent(inout) :: register
      type(diagnostics_type), intent(inout) :: diagnostics
      type(option_spec_type), allocatable :: specs(:)
      integer :: k
      if (.not. block%knows('NAME')) return
      allocate (specs, source=keyword_options(block%keyword))
      do k = 1, size(specs)
         if (specs(k)%kind /= kind_name .or. .not. block%options(k)%has_value) cycle
         call claim(register, trim(specs(k)%values), block%options(k)%text, block%options(k)%origin, diagnostics)
      end do
   end subroutine check_name

   !> Checks the names that a block refers to, and whether its options have an effect.
   subroutine check_options(deck, i, diagnostics)
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: i
      type(diagnostics_type), intent(inout) :: diagnostics
      type(option_spec_type), allocatable :: specs(:)
      integer :: k
      allocate (specs, source=keyword_options(deck%blocks(i)%keyword))
      do k = 1, size(specs)
         if (.not. deck%blocks(i)%options(k)%has_value) cycle
         if (specs(k)%kind == kind_reference) call check_reference(deck, specs(k), deck%blocks(i)%options(k)%text, &
            & deck%blocks(i)%options(k)%origin, diagnostics)
      end do
      call check_idle(deck%blocks(i), specs, diagnostics)
   end subroutine check_options

   !> Enters a name into a scope; reports one that is taken or reserved.
   subroutine claim(register, scope, name, origin, diagnostics)
      type(register_type), intent(inout) :: register
      character(*), intent(in) :: scope, name
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      type(origin_type), allocatable :: longer(:)
      integer :: i
      if (is_taken(scope, name)) then
         call diagnostics%add(origin, "the name '"//name//"' is reserved", 'give it another name')
         return
      end if
      i = register%names%find(scope//' '//name)
      if (i > 0) then
         call diagnostics%add(origin, "the name '"//name//"' is used twice among the "//scope, &
            & 'give it another name; capitals are not distinguished', register%origins(i), 'first defined here')
         return
      end if
      i = register%names%count + 1
      call register%names%add(scope//' '//name, i)
      if (.not. allocated(register%origins)) allocate (register%origins(16))
      if (i > size(register%origins)) then
         allocate (longer(2*size(register%origins)))
         longer(:i - 1) = register%origins
         call move_alloc(longer, register%origins)
      end if
      register%origins(i) = origin
   end subroutine claim

   !> Whether a name has a meaning of its own in a scope: the ground and its origin; the whole in work(system); the time of
   !> results; columns of a sweep's summary.
   pure logical function is_taken(scope, name)
      character(*), intent(in) :: scope, name
      character(*), parameter :: columns(*) = [character(14) :: 'row', 'state', 'error_estimate', 'seconds', 'warnings', &
         & 'history', 'message']
      select case (scope)
      case ('bodies'); is_taken = name == 'ground' .or. name == 'system'
      case ('joints, drivers and loads'); is_taken = name == 'system'
      case ('points of ground'); is_taken = name == 'origin'
      case ('channels'); is_taken = name == 'time'
      case ('scalars', 'parameters of the sweep'); is_taken = any(name == columns)
      case default; is_taken = .false.
      end select
   end function is_taken

   !> Reports a reference to an object that does not exist or is of another kind.
   subroutine check_reference(deck, spec, name, origin, diagnostics)
      type(deck_type), intent(in) :: deck
      type(option_spec_type), intent(in) :: spec
      character(*), intent(in) :: name
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      character(name_length), allocatable :: names(:)
      character(:), allocatable :: kinds, label
      integer :: i, count, other
      if (deck%find_named(trim(spec%values), name) > 0) return
      kinds = alternatives(trim(spec%values), '*')
      label = 'define it with '//kinds
      ! What is not shown need not be searched for
      if (diagnostics%count >= max_shown) then
         call diagnostics%add(origin, 'there is no '//kinds//" named '"//name//"'", label, object=name)
         return
      end if
      allocate (names(size(deck%blocks)))
      count = 0
      other = 0
      do i = 1, size(deck%blocks)
         if (contains_value(trim(spec%values), deck%blocks(i)%keyword)) then
            count = count + 1
            names(count) = deck%blocks(i)%name()
         else if (deck%blocks(i)%name() == name) then
            other = i
         end if
      end do
      i = nearest_name(name, names(:count))
      label = suggestion(name, names(:count), label)
      if (other > 0 .and. i == 0) then
         call diagnostics%add(origin, "'"//name//"' is no "//kinds, trim(spec%meaning), &
            & deck%blocks(other)%origin_of('NAME'), 'it is a *'//deck%blocks(other)%keyword)
      else
         call diagnostics%add(origin, 'there is no '//kinds//" named '"//name//"'", label, object=name)
      end if
   end subroutine check_reference

   !> Checks that the points of one object differ, the parameters of a sweep, and the lists of a study.
   subroutine check_lines(deck, i, diagnostics)
      type(deck_type), intent(inout) :: deck
      integer, intent(in) :: i
      type(diagnostics_type), intent(inout) :: diagnostics
      type(register_type) :: register
      if (deck%blocks(i)%keyword == 'STUDY' .and. diagnostics%count == 0) call check_study(deck, i, diagnostics)
      if (deck%blocks(i)%keyword == 'SWEEP' .and. .not. deck%blocks(i)%broken) call check_sweep(deck, i, diagnostics)
      if (deck%blocks(i)%keyword == 'GROUND' .or. size(deck%blocks(i)%lines) == 0) return
      if (deck%blocks(i)%keyword == 'SWEEP') then
         call claim_points(deck, i, 'parameters of the sweep', register, diagnostics)
      else
         call claim_points(deck, i, 'points of '//deck%blocks(i)%name(), register, diagnostics)
      end if
   end subroutine check_lines

   !> Checks that the points of all *GROUND blocks differ.
   subroutine check_ground(deck, diagnostics)
      type(deck_type), intent(inout) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      type(register_type) :: register
      integer :: i, before
      i = deck%find('GROUND')
      do while (i > 0)
         before = diagnostics%count
         call claim_points(deck, i, 'points of ground', register, diagnostics)
         if (diagnostics%count > before) then
            deck%blocks(i)%broken = .true.
            call diagnostics%tell('ground')
         end if
         i = deck%find('GROUND', i)
      end do
   end subroutine check_ground

   subroutine claim_points(deck, i, scope, register, diagnostics)
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: i
      character(*), intent(in) :: scope
      type(register_type), intent(inout) :: register
      type(diagnostics_type), intent(inout) :: diagnostics
      type(field_spec_type), allocatable :: specs(:)
      integer :: k
      allocate (specs, source=keyword_fields(deck%blocks(i)%keyword))
      if (size(specs) == 0) return
      if (specs(1)%name /= 'point' .and. specs(1)%name /= 'parameter') return
      do k = 1, size(deck%blocks(i)%lines)
         associate (field => deck%blocks(i)%lines(k)%fields(1))
            call claim(register, scope, field%text, field%origin, diagnostics)
         end associate
      end do
   end subroutine claim_points

   !> Checks that the channels of all *OUTPUT blocks differ, and the scalars of all *SCALAR blocks.
   subroutine check_channels(deck, diagnostics)
      type(deck_type), intent(in) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      type(register_type) :: register
      character(8) :: scope
      integer :: i, k, m
      do i = 1, size(deck%blocks)
         if (keyword_table(find_keyword(deck%blocks(i)%keyword))%form /= form_channels) cycle
         scope = merge('scalars ', 'channels', deck%blocks(i)%keyword == 'SCALAR')
         do k = 1, size(deck%blocks(i)%lines)
            do m = 1, deck%blocks(i)%lines(k)%count()
               associate (field => deck%blocks(i)%lines(k)%fields(m))
                  if (len(field%name) > 0) call claim(register, scope, lowercase(field%name), field%origin, diagnostics)
               end associate
            end do
         end do
      end do
   end subroutine check_channels

   !> Adds to the reports of unknown parameters that they are defined further down, if they are.
   subroutine explain_parameters(deck, diagnostics)
      type(deck_type), intent(in) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i, found
      do i = 1, diagnostics%kept
         if (.not. allocated(diagnostics%items(i)%about)) cycle
         found = deck%parameters%find(diagnostics%items(i)%about)
         if (found == 0) cycle
         diagnostics%items(i)%message = "the parameter '"//diagnostics%items(i)%about//"' is used before it is defined"
         diagnostics%items(i)%label = 'move the definition up'
         diagnostics%items(i)%second_origin = deck%parameters%items(found)%origin
         diagnostics%items(i)%second_label = 'defined here'
      end do
   end subroutine explain_parameters

end module limber_deck_checks
