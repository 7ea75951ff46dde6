!> The deck: what a good one becomes, the round trip of the effective deck, the exact text of the errors of
!> bad ones, and random damage that must neither crash nor hang.
program test_deck
   use limber_base_kinds, only: wp, long
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text, newline
   use limber_deck_content, only: deck_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_effective, only: effective_deck
   use limber_deck_operations, only: jet_type
   use limber_deck_origin, only: origin_type
   use limber_deck_reader, only: read_deck, read_deck_text
   use limber_deck_source, only: source_type
   use testing, only: check, check_close, check_text, finish
   implicit none
   !> decks/bad_<name>.inp with its errors in decks/bad_<name>.txt
   character(20), parameter :: bad_decks(*) = [character(20) :: 'binary', 'characters', 'comments_only', 'continuation', &
      & 'named_expressions', &
      & 'crlf', 'duplicate_names', 'empty', 'expressions', 'fields', 'include_cycle', 'include_duplicate', &
      & 'include_missing', 'long_line', 'many', 'missing_comma', 'names', 'nesting', 'no_keyword', 'once', &
      & 'option_value', 'output', 'parameters', 'power_comment', 'range', 'references', 'repeat', 'required', 'tables', &
      & 'unknown_keyword', &
      & 'unknown_option', 'values', 'words']
   call test_options()
   call test_data_lines()
   call test_round_trip()
   call test_set_option()
   call test_repeat()
   call test_tolerance()
   call test_bad_decks()
   call test_bad_paths()
   call test_nested_includes()
   call test_lines_behind_includes()
   call test_long_line()
   call test_second_file()
   call test_mutations()
   call finish()

contains

   subroutine test_options()
      type(deck_type) :: deck
      integer :: beam
      call read_good(deck)
      call check(size(deck%blocks) == 17, 'number of blocks')
      call check_text(deck%blocks(4)%keyword, 'MATERIAL', 'an included block stands in order')
      beam = deck%find('BEAM')
      associate (block => deck%blocks(beam))
         call check_text(block%name(), 'rod', 'name')
         call check_text(block%name('MATERIAL'), 'steel', 'reference in lower case')
         call check_text(block%word('SUPPORT'), 'PINNED-ROLLER', 'word in upper case')
         call check_close(block%real('LENGTH'), 0.3_wp, 1.0e-16_wp, 'number from a parameter')
         call check(block%integer('MODES') == 4 .and. block%given('MODES'), 'whole number')
         call check(block%integer('ELEMENTS') == 10 .and. .not. block%given('ELEMENTS'), 'default')
         call check(block%has('ELEMENTS') .and. .not. block%has('BENDING MODES'), 'option without a value')
         call check(block%yes('CORRECTIONS'), 'an option without a word: YES')
         call check_text(block%word('GEOMETRIC'), 'K_G', 'the model that a number of modes asks for')
         call check_text(block%word('AXIAL BASIS'), 'MODES', 'and its axial functions')
         call check(same(block%origin_of('MODES'), origin_type(1, 18, 10, 10)), 'origin of an option in a continued line')
         call check(same(block%origin_of('ELEMENTS'), origin_type(1, 16, 1, 5)), 'origin of a default is the keyword')
      end associate
      call check_text(deck%blocks(deck%find('UNITS'))%text('MASS'), 'kg', 'text')
      call check_text(deck%blocks(deck%find_named('JOINT', 'GUIDE'))%word('TYPE'), 'POINT ON LINE', 'word with blanks')
      call check(size(deck%indices('JOINT')) == 3, 'three joints')
      call check(deck%find_named('RIGID BODY|BEAM', 'crank') == deck%find('RIGID BODY'), 'search by name')
      call check(deck%find_named('BEAM', 'crank') == 0 .and. deck%find('FROBNICATE') == 0, 'what there is not')
      call check(deck%parameters%count == 4, 'parameters')
   end subroutine test_options

   subroutine test_data_lines()
      type(deck_type) :: deck
      type(jet_type) :: jet
      real(wp) :: t
      call read_good(deck)
      call check_text(deck%blocks(1)%lines(1)%content, 'Slider-crank after Koppens, flexible rod; '// &
         & 'gr'//char(195)//char(182)//char(195)//char(159)//'te Biegung', 'heading')
      associate (line => deck%blocks(deck%find('BEAM'))%lines(2))
         call check_text(line%text(1), 'three-quarters', 'name of a point')
         call check_close(line%number(2), 0.225_wp, 1.0e-15_wp, 'number in a data line')
         call check(same(line%origin_of(2), origin_type(1, 21, 19, 26)), 'origin of a field')
         call check(line%count() == 2, 'a comma at the end adds no field')
      end associate
      t = 0.01_wp
      associate (line => deck%blocks(deck%find('DRIVER'))%lines(1))
         jet = line%fields(1)%expression%evaluate_jet(t)
      end associate
      call check_close(jet%value, 1.5_wp + 0.1_wp*sin(1.5_wp)**2, 1.0e-15_wp, 'driver')
      call check_close(jet%first, 150.0_wp + 15.0_wp*sin(3.0_wp), 1.0e-12_wp, 'speed of the driver')
      associate (line => deck%blocks(deck%find('OUTPUT'))%lines(1))
         call check(line%count() == 3, 'three channels in a line')
         call check_text(line%fields(1)%name//'|'//line%fields(3)%name, '|bend', 'bare and named channel')
         call check_text(line%fields(1)%expression%slots(1)%argument, 'slider', 'object of a quantity')
         call check_close(line%fields(3)%expression%evaluate([0.6_wp]), 2.0_wp, 1.0e-15_wp, 'value of a channel')
      end associate
   end subroutine test_data_lines

   !> The effective deck reads without errors, says the same and does not change any more.
   subroutine test_round_trip()
      type(deck_type) :: deck, again
      type(diagnostics_type) :: diagnostics
      character(:), allocatable :: first
      integer :: i, k
      logical :: equal
      call read_good(deck)
      first = effective_deck(deck)
      call read_deck_text('effective.inp', first, again, diagnostics)
      call check_text(diagnostics%render(again%source), '', 'the effective deck has no errors')
      call check_text(effective_deck(again), first, 'the effective deck of an effective deck')
      call check(size(again%blocks) == size(deck%blocks), 'as many blocks')
      equal = size(again%blocks) == size(deck%blocks)
      do i = 1, size(deck%blocks)
         if (.not. equal) exit
         do k = 1, size(deck%blocks(i)%options)
            equal = equal .and. deck%blocks(i)%options(k)%text == again%blocks(i)%options(k)%text &
               & .or. .not. abs(deck%blocks(i)%options(k)%value - again%blocks(i)%options(k)%value) > 0.0_wp
         end do
      end do
      call check(equal, 'all options are the same')
      call check_text(first, text_of('decks/slider-crank.txt'), 'the effective deck')
   end subroutine test_round_trip

   !> A word that the builder resolves shows in the effective deck.
   subroutine test_set_option()
      type(deck_type) :: deck
      call read_good(deck)
      call deck%set_option(deck%find('BEAM'), 'AXIAL BASIS', 'static ')
      call check_text(deck%blocks(deck%find('BEAM'))%word('AXIAL BASIS'), 'STATIC', 'option that was set')
      call check(.not. deck%blocks(deck%find('BEAM'))%given('AXIAL BASIS'), 'set is not given')
      call check(index(effective_deck(deck), 'AXIAL BASIS=STATIC') > 0, 'it is in the effective deck')
   end subroutine test_set_option

   !> Blocks that are repeated, one in the other, with parameters of their own and a file; they stand as written in the effective
   !> deck.
   subroutine test_repeat()
      type(deck_type) :: deck, again
      type(diagnostics_type) :: diagnostics
      character(:), allocatable :: first, text
      integer :: i
      call read_deck('decks/repeat.inp', deck, diagnostics)
      call check_text(diagnostics%render(deck%source), '', 'repetitions have no errors')
      call check(size(deck%indices('RIGID BODY')) == 6 .and. size(deck%indices('POINT MASS')) == 3, 'numbers of blocks')
      i = deck%find_named('RIGID BODY', 'bar2-3')
      call check(i > 0, 'a block by its name')
      if (i == 0) return
      call check_close(deck%blocks(i)%real('X'), 23.0_wp, 1.0e-14_wp, 'indices in a number')
      call check_close(deck%blocks(i)%real('MASS'), 2.5_wp, 1.0e-14_wp, 'a parameter of the turn')
      call check_text(deck%blocks(i)%lines(1)%text(1), 'p5', 'an index in a data line')
      call check_text(deck%blocks(deck%find('OUTPUT'))%lines(2)%fields(2)%name, 'y_6', 'name of a channel')
      text = ''
      do i = 1, size(deck%blocks)
         if (deck%blocks(i)%keyword == 'OUTPUT') text = text//' '//deck%blocks(i)%lines(1)%fields(1)%expression%slots(1)%argument
      end do
      call check_text(text, ' bar2-3 m0 m2 m4', 'objects of channels')
      call check(deck%parameters%find('i') == 0 .and. deck%parameters%find('half') == 0 .and. deck%parameters%find('n') == 1, &
         & 'parameters of turns end with them')
      first = effective_deck(deck)
      call read_deck_text('effective.inp', first, again, diagnostics)
      call check_text(diagnostics%render(again%source), '', 'the effective deck of repetitions has no errors')
      call check_text(effective_deck(again), first, 'the effective deck of an effective deck of repetitions')
      call check(size(again%blocks) == size(deck%blocks), 'as many blocks with repetitions')
      call check_text(first, text_of('decks/repeat.txt'), 'the effective deck of repetitions')
   end subroutine test_repeat

   !> Tabs, CR LF, byte-order mark, no line end, blanks around: all the same deck.
   subroutine test_tolerance()
      character(*), parameter :: plain = '*GRAVITY, X=1, Y=2'//newline//'*GROUND'//newline//'a, 1, 2'//newline
      character(1), parameter :: tab = achar(9)
      character(:), allocatable :: expected
      expected = effective_text(plain)
      call check_text(effective_text(plain(:len(plain) - 1)), expected, 'no line end')
      call check_text(effective_text('*gravity,x=1,y=2'//achar(13)//newline//'*Ground'//achar(13)//newline//'A,1,2'//achar(13)), &
         & expected, 'CR LF, no blanks, lower case')
      call check_text(effective_text(char(239)//char(187)//char(191)//plain), expected, 'byte-order mark')
      call check_text(effective_text(newline//tab//'*GRAVITY'//tab//','//tab//'X ='//tab//'1 , Y= 2'//newline// &
         & '  *GROUND ** the ground'//newline//newline//tab//'a,'//tab//'1, 2'//tab//'** comment'//newline//'**'), &
         & expected, 'tabs, blanks and comments')
      call check_text(effective_text('*GRAVITY, X=1,'//newline//'** comment'//newline//newline//'Y=2'//newline// &
         & '*GROUND'//newline//'a, 1, 2,'), expected, 'continuation')
      call check_text(effective_text('*UNITS, LENGTH="m, or ft", TIME = "s"'), '*UNITS, LENGTH="m, or ft", TIME="s", MASS="kg"' &
         & //newline, 'comma in quotes')
   end subroutine test_tolerance

   subroutine test_bad_decks()
      type(deck_type) :: deck
      type(diagnostics_type) :: diagnostics
      integer :: i
      do i = 1, size(bad_decks)
         diagnostics = diagnostics_type()
         call read_deck('decks/bad_'//trim(bad_decks(i))//'.inp', deck, diagnostics)
         call check(diagnostics%count > 0, 'errors in '//trim(bad_decks(i)))
         call check_text(diagnostics%render(deck%source)//newline, text_of('decks/bad_'//trim(bad_decks(i))//'.txt'), &
            & bad_decks(i))
      end do
   end subroutine test_bad_decks

   subroutine test_bad_paths()
      call path_error('decks/missing.inp', "error: there is no file 'decks/missing.inp'")
      call path_error('decks', "error: cannot read 'decks': it is a folder")
      call path_error('', "error: there is no file ''")
   end subroutine test_bad_paths

   subroutine path_error(path, expected)
      character(*), intent(in) :: path, expected
      type(deck_type) :: deck
      type(diagnostics_type) :: diagnostics
      call read_deck(path, deck, diagnostics)
      call check_text(diagnostics%render(deck%source), expected, 'path '//path)
      call check(size(deck%blocks) == 0, 'no blocks from '//path)
   end subroutine path_error

   !> A file that includes itself under ever other paths ends at the limit of nesting.
   subroutine test_nested_includes()
      type(deck_type) :: deck
      type(diagnostics_type) :: diagnostics
      call read_deck_text('deck.inp', '*INCLUDE, FILE=decks/endless.inc', deck, diagnostics)
      call check(diagnostics%count == 1, 'one error')
      call check(diagnostics%items(1)%message == '*INCLUDE is nested more than 20 deep', 'nesting is limited')
      call check(index(diagnostics%items(1)%label, 'deck.inp -> decks/endless.inc -> decks/../decks/endless.inc') == 1, &
         & 'the chain is shown')
   end subroutine test_nested_includes

   !> Every line behind an *INCLUDE in an included file is read, in order, in turns of a *REPEAT too.
   subroutine test_lines_behind_includes()
      character(*), parameter :: names(*) = [character(12) :: 'steel', 'first', 'second', 'deepest1-1', 'deep1-1', 'deepest1-2', &
         & 'deep1-2', 'outer1', 'deepest2-1', 'deep2-1', 'deepest2-2', 'deep2-2', 'outer2', 'third', 'fourth']
      type(deck_type) :: deck
      type(diagnostics_type) :: diagnostics
      integer :: i
      call read_deck_text('deck.inp', '*INCLUDE, FILE=decks/nest_1.inc'//newline//'*GRAVITY, Y=-1', deck, diagnostics)
      call check_text(diagnostics%render(deck%source), '', 'files that include files')
      call check(size(deck%blocks) == size(names) + 1, as_text(size(deck%blocks))//' blocks of nested files')
      if (size(deck%blocks) /= size(names) + 1) return
      do i = 1, size(names)
         call check_text(deck%blocks(i)%name(), trim(names(i)), 'blocks of nested files in order')
      end do
      call check_text(deck%blocks(size(names) + 1)%keyword, 'GRAVITY', 'the line behind all of them')
      call check_again(effective_deck(deck))
   end subroutine test_lines_behind_includes

   !> A line of 20 MB, or of as many words as the program is told, where the end of a *REPEAT is looked for: no words are taken from
   !> it, which the stack could not hold.
   subroutine test_long_line()
      type(deck_type) :: deck, open_deck
      type(diagnostics_type) :: diagnostics, open_diagnostics
      character(:), allocatable :: text
      character(16) :: argument
      integer :: words
      words = 6000000
      call get_command_argument(1, argument)
      if (argument /= '') read (argument, *) words
      allocate (character(30 + 3*words) :: text)
      text(:) = '*REPEAT, COUNT=2, INDEX=i'//newline//'*'//repeat('END', words)
      call read_deck_text('deck.inp', text, deck, diagnostics)
      call check(diagnostics%count > 0, 'a line that is too long ends no *REPEAT')
      call check(diagnostics%items(1)%message == 'this *REPEAT has no *END REPEAT', diagnostics%items(1)%message)
      ! One mistake, one message
      call read_deck_text('deck.inp', '*REPEAT, COUNT=3, INDEX=i'//newline//'*POINT MASS, NAME=a<i>, MASS=1'//newline// &
         & '*DYNAMICS, END=1'//newline//'*OUTPUT'//newline//' x(a1)'//newline, open_deck, open_diagnostics)
      call check(open_diagnostics%count == 1 .and. .not. open_deck%is_whole, 'an open *REPEAT is one error')
   end subroutine test_long_line

   !> Errors and warnings that a later module adds.
   subroutine test_second_file()
      type(deck_type) :: deck
      type(diagnostics_type) :: diagnostics
      call read_deck_text('deck.inp', '*GRAVITY'//newline//'*POINT MASS, NAME=m, MASS=1', deck, diagnostics)
      call diagnostics%warn(deck%blocks(2)%origin_of('MASS'), 'a light mass', 'heavier?')
      call diagnostics%add(deck%blocks(1)%origin, 'too heavy')
      call check(diagnostics%count == 1 .and. diagnostics%warnings == 1, 'counts')
      call check_text(diagnostics%render(deck%source), 'deck.inp:1:1: error: too heavy'//newline//'    1 | *GRAVITY'//newline// &
         & '      | ^^^^^^^^'//newline//'deck.inp:2:27: warning: a light mass'//newline// &
         & '    2 | *POINT MASS, NAME=m, MASS=1'//newline//'      |                           ^ heavier?', 'added by the builder')
   end subroutine test_second_file

   !> Thousands of damaged decks: bytes replaced, removed, doubled, cut off. Whatever comes out can be shown.
   subroutine test_mutations()
      integer, parameter :: rounds = 4000
      type(deck_type) :: deck
      type(diagnostics_type) :: diagnostics
      character(:), allocatable :: good, text, shown
      integer(long) :: seed
      integer :: round, i, refused
      good = text_of('decks/slider-crank.inp')
      seed = 20260731_long
      refused = 0
      shown = ''
      do round = 1, rounds
         text = good
         do i = 0, random(seed, 5)
            call damage(text, seed)
         end do
         diagnostics = diagnostics_type()
         call read_deck_text('decks/mutant.inp', text, deck, diagnostics)
         if (diagnostics%count > 0) then
            refused = refused + 1
            shown = diagnostics%render(deck%source)
         else
            shown = effective_deck(deck)
            call check_again(shown)
         end if
      end do
      call check(refused > rounds/2 .and. refused < rounds, &
         & 'damaged decks: '//as_text(refused)//' of '//as_text(rounds)//' refused')
   end subroutine test_mutations

   !> The effective deck of whatever is accepted is accepted, and its own effective deck.
   subroutine check_again(text)
      character(*), intent(in) :: text
      type(deck_type) :: deck
      type(diagnostics_type) :: diagnostics
      call read_deck_text('decks/again.inp', text, deck, diagnostics)
      if (diagnostics%count > 0) then
         call check_text(diagnostics%render(deck%source), '', 'effective deck of a mutant')
      else if (effective_deck(deck) /= text) then
         call check_text(effective_deck(deck), text, 'second effective deck of a mutant')
      end if
   end subroutine check_again

   subroutine damage(text, seed)
      character(:), allocatable, intent(inout) :: text
      integer(long), intent(inout) :: seed
      character(*), parameter :: likely = '*,=()."- '//achar(9)//newline//'t1ae+/^#'
      integer :: at, last
      if (len(text) < 2) return
      at = 1 + random(seed, len(text))
      last = min(len(text), at + random(seed, 20))
      select case (random(seed, 6))
      case (0); text = text(:at - 1)//char(random(seed, 256))//text(at + 1:)
      case (1); text = text(:at - 1)//text(at + 1:)
      case (2); text = text(:at - 1)//text(last + 1:)
      case (3); text = text(:last)//text(at:)
      case (4); at = min(at, len(text)); last = 1 + random(seed, len(likely)); text = text(:at - 1)//likely(last:last)//text(at:)
      case (5); if (random(seed, 20) == 0) text = text(:at)
      end select
   end subroutine damage

   !> A whole number from 0 to below a bound.
   integer function random(seed, bound)
      integer(long), intent(inout) :: seed
      integer, intent(in) :: bound
      seed = modulo(seed*16807_long, 2147483647_long)
      random = int(modulo(seed/7_long, int(bound, long)))
   end function random

   subroutine read_good(deck)
      type(deck_type), intent(out) :: deck
      type(diagnostics_type) :: diagnostics
      call read_deck('decks/slider-crank.inp', deck, diagnostics)
      call check_text(diagnostics%render(deck%source), '', 'the good deck has no errors')
   end subroutine read_good

   function effective_text(text) result(effective)
      character(*), intent(in) :: text
      character(:), allocatable :: effective
      type(deck_type) :: deck
      type(diagnostics_type) :: diagnostics
      call read_deck_text('deck.inp', text, deck, diagnostics)
      effective = diagnostics%render(deck%source)
      if (diagnostics%count == 0) effective = effective_deck(deck)
   end function effective_text

   !> The content of a file.
   function text_of(path) result(text)
      character(*), intent(in) :: path
      character(:), allocatable :: text
      type(source_type) :: source
      type(error_type), allocatable :: error
      integer :: i
      text = ''
      call source%read_file(path, origin_type(), error)
      call check(.not. allocated(error), 'read '//path)
      if (allocated(error)) return
      do i = 1, size(source%files(1)%lines)
         text = text//source%files(1)%lines(i)%text//newline
      end do
   end function text_of

   pure logical function same(a, b)
      type(origin_type), intent(in) :: a, b
      same = a%file == b%file .and. a%line == b%line .and. a%first == b%first .and. a%last == b%last
   end function same

end program test_deck
