!> Numbers that try to break limber: the cases of a table, each by every integrator, against what the table expects of them.
!>
!>    hard TABLE FOLDER [--long] [CASE [INTEGRATOR]]
!>
!> TABLE stands beside the decks; FOLDER takes decks and results. --long: also the cases that take minutes. A line for each run, its
!> parts separated by tabs: case, integrator, 'as expected' or 'NOT AS EXPECTED', outcome, error, its bound, CPU seconds, warnings
!> or the message. The table has blocks of lines, a word and what belongs to it:
!>
!>    CASE name, LONG_CASE name     begins a case; one that takes minutes
!>    TITLE text, SOURCE text       for doc/hard-cases.md: what it is, where the expected values are from
!>    DECK file                     its deck, with INTEGRATOR=AUTO
!>    SET parameter value           a value of a parameter of the deck
!>    REPLACE old => new            a text of the deck, and what stands for it
!>    APPEND text                   a line behind the deck
!>    SCALE value                   what errors are relative to; 1 if not given
!>    VALUE channel sample value    an expected value; samples count from 0
!>    FILE file                     columns of expected values: sample, channels named in the first line
!>    LIKE case                     expected values: those of another case, at all samples of all channels
!>    integrators expectation       integrators: ALL, or some of them, joined by commas; the last line that names one counts
!>
!> Expectations: SOLVED bound: without a warning, the error at most the bound. WARNED bound text: the same with a warning that holds
!> the text, of any error if the bound is 'any'. REFUSED status text: an error with this status whose message holds the text.
!> SKIPPED text: why the case is not for an integrator.
module hard_cases
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_commands_batch, only: batch_type
   use limber_commands_run, only: run_one
   use limber_deck_parameters, only: override_type
   use limber_output_history_reader, only: history_reader_type
   implicit none
   private
   public :: case_type, read_cases, run_case, integrators

   character(*), parameter :: integrators(*) = [character(10) :: 'ADAMS', 'RADAU', 'ALPHA', 'CONSERVING', 'AUTO']
   integer, parameter :: width = 400

   !> An expected value
   type :: value_type
      character(64) :: channel = ''
      integer :: sample = 0
      real(wp) :: value = 0.0_wp
   end type value_type

   !> A case of the table
   type :: case_type
      character(64) :: name = '', deck = '', like = ''
      real(wp) :: scale = 1.0_wp
      type(override_type) :: set(20)
      character(width) :: replaced = '', replacement = '', appended = ''
      integer :: sets = 0, values = 0
      logical :: long = .false.
      type(value_type) :: value(200)
      !> What is expected of each integrator
      character(width) :: expected(size(integrators)) = ''
   end type case_type

contains

   !> All cases of a table.
   subroutine read_cases(path, cases)
      character(*), intent(in) :: path
      type(case_type), allocatable, intent(out) :: cases(:)
      character(width) :: line, word, rest
      integer :: unit, status, count
      allocate (cases(200))
      count = 0
      open (newunit=unit, file=path, action='read', status='old')
      do
         read (unit, '(a)', iostat=status) line
         if (status /= 0) exit
         call split(line, word, rest)
         select case (word)
         case ('', '#', 'TITLE', 'SOURCE')
         case ('CASE', 'LONG_CASE')
            count = count + 1
            cases(count)%name = trim(rest)
            cases(count)%long = word == 'LONG_CASE'
         case default
            call take(cases(count), path, trim(word), rest)
         end select
      end do
      close (unit)
      cases = cases(:count)
   end subroutine read_cases

   !> The first word of a line and the rest.
   subroutine split(line, word, rest)
      character(*), intent(in) :: line
      character(width), intent(out) :: word, rest
      character(width) :: text
      integer :: at
      text = adjustl(line)
      at = index(text, ' ')
      word = text(:at - 1)
      rest = adjustl(text(at:))
   end subroutine split

   !> A line of a case.
   subroutine take(item, path, word, rest)
      type(case_type), intent(inout) :: item
      character(*), intent(in) :: path, word, rest
      integer :: i
      logical :: known
      select case (word)
      case ('DECK'); item%deck = trim(rest)
      case ('LIKE'); item%like = trim(rest)
      case ('SCALE'); read (rest, *) item%scale
      case ('FILE'); call read_file(item, path(:index(path, '/', back=.true.))//trim(rest))
      case ('SET')
         item%sets = item%sets + 1
         read (rest, *) item%set(item%sets)%name, item%set(item%sets)%value
      case ('REPLACE')
         i = index(rest, ' => ')
         item%replaced = rest(:i - 1)
         item%replacement = rest(i + 4:)
      case ('APPEND'); item%appended = rest
      case ('VALUE')
         item%values = item%values + 1
         associate (value => item%value(item%values))
            read (rest, *) value%channel, value%sample, value%value
         end associate
      case default
         known = word == 'ALL'
         do i = 1, size(integrators)
            if (word /= 'ALL' .and. index(','//word//',', ','//trim(integrators(i))//',') == 0) cycle
            item%expected(i) = rest
            known = .true.
         end do
         if (.not. known) call stop_with('a word of the table is not known: '//word)
      end select
   end subroutine take

   !> Expected values from a file of columns.
   subroutine read_file(item, path)
      type(case_type), intent(inout) :: item
      character(*), intent(in) :: path
      character(64) :: names(9)
      character(width) :: line, word, rest
      real(wp) :: row(9)
      integer :: unit, status, columns, i, sample
      open (newunit=unit, file=path, action='read', status='old')
      read (unit, '(a)') line
      columns = -1
      rest = line
      do
         call split(rest, word, line)
         if (word == '') exit
         columns = columns + 1
         if (columns > 0) names(columns) = trim(word)
         rest = line
      end do
      do
         read (unit, *, iostat=status) sample, row(:columns)
         if (status /= 0) exit
         do i = 1, columns
            item%values = item%values + 1
            item%value(item%values) = value_type(names(i), sample, row(i))
         end do
      end do
      close (unit)
   end subroutine read_file

   !> Runs a case by one integrator and prints its line.
   subroutine run_case(cases, k, integrator, decks, folder, good)
      type(case_type), intent(in) :: cases(:)
      !> Which case, which integrator
      integer, intent(in) :: k, integrator
      !> Folder of the decks; folder of the results
      character(*), intent(in) :: decks, folder
      logical, intent(out) :: good
      type(error_type), allocatable :: error
      character(:), allocatable :: path, outcome, message
      character(width) :: kind, rest, word, bound_text
      real(wp) :: found, bound, seconds
      integer :: other
      good = .true.
      associate (item => cases(k))
         call split(item%expected(integrator), kind, rest)
         if (kind == 'SKIPPED') then
            call print_line(item, integrator, .true., 'skipped', '', '', '', trim(rest))
            return
         end if
         path = folder//trim(item%name)//'.'//trim(integrators(integrator))
         call run_deck(item, integrator, decks, path, message, seconds, error)
         found = -1.0_wp
         if (allocated(error)) then
            outcome = 'refused '//as_text(error%status)
            message = message//error%message
         else
            outcome = trim(merge('warned', 'solved', message /= ''))
            do other = 1, size(cases)
               if (cases(other)%name == item%like) call run_other(cases(other), integrator, decks, path//'.like')
            end do
            call compare(item, path//'.h5', path//'.like.h5', found)
         end if
         call split(rest, bound_text, word)
         bound = huge(1.0_wp)
         select case (kind)
         case ('SOLVED')
            read (bound_text, *) bound
            good = outcome == 'solved' .and. found <= bound
         case ('WARNED')
            if (bound_text /= 'any') read (bound_text, *) bound
            good = outcome == 'warned' .and. found <= bound .and. index(message, trim(word)) > 0
         case ('REFUSED')
            good = outcome == 'refused '//trim(bound_text) .and. index(message, trim(word)) > 0
            bound_text = ''
         case default
            good = .false.
         end select
         call print_line(item, integrator, good, outcome, number(found), trim(bound_text), as_text(seconds, 3), &
            & one_line(message))
      end associate
   end subroutine run_case

   !> Runs the deck of a case.
   subroutine run_deck(item, integrator, decks, path, message, seconds, error)
      type(case_type), intent(in) :: item
      integer, intent(in) :: integrator
      !> Folder of the decks; path of the results without its ending
      character(*), intent(in) :: decks, path
      !> Warnings, and CPU seconds
      character(:), allocatable, intent(out) :: message
      real(wp), intent(out) :: seconds
      type(error_type), allocatable, intent(out) :: error
      type(batch_type) :: batch
      character(:), allocatable :: report
      call write_deck(item, decks//trim(item%deck), path//'.inp', trim(integrators(integrator)))
      allocate (batch%overrides(item%sets), source=item%set(:item%sets))
      call run_one(path//'.inp', path//'.h5', .true., .true., batch, report, error)
      message = ''
      if (allocated(batch%warnings)) message = batch%warnings
      seconds = batch%cpu
   end subroutine run_deck

   !> Runs the case that another one is to be like.
   subroutine run_other(item, integrator, decks, path)
      type(case_type), intent(in) :: item
      integer, intent(in) :: integrator
      character(*), intent(in) :: decks, path
      type(error_type), allocatable :: error
      character(:), allocatable :: message
      real(wp) :: seconds
      call run_deck(item, integrator, decks, path, message, seconds, error)
      if (allocated(error)) call stop_with(error%message)
   end subroutine run_other

   !> The line of a run.
   subroutine print_line(item, integrator, good, outcome, found, bound, seconds, text)
      type(case_type), intent(in) :: item
      integer, intent(in) :: integrator
      logical, intent(in) :: good
      character(*), intent(in) :: outcome, found, bound, seconds, text
      print '(*(a))', trim(item%name), tab(), trim(integrators(integrator)), tab(), &
         & trim(merge('as expected    ', 'NOT AS EXPECTED', good)), tab(), outcome, tab(), found, tab(), bound, tab(), &
         & seconds, tab(), text
   end subroutine print_line

   !> Ends with a message.
   subroutine stop_with(text)
      character(*), intent(in) :: text
      print '(2a)', 'hard: ', text
      error stop 2
   end subroutine stop_with

   !> The deck with an integrator, and with what the case exchanges.
   subroutine write_deck(item, path, changed, integrator)
      type(case_type), intent(in) :: item
      character(*), intent(in) :: path, changed, integrator
      character(:), allocatable :: text
      integer :: unit, length
      inquire (file=path, size=length)
      if (length < 1) call stop_with('a deck is missing: '//path)
      allocate (character(length) :: text)
      open (newunit=unit, file=path, access='stream', action='read', status='old')
      read (unit) text
      close (unit)
      call exchange('INTEGRATOR=AUTO', 'INTEGRATOR='//integrator)
      if (item%replaced /= '') call exchange(trim(item%replaced), trim(item%replacement))
      if (item%appended /= '') text = text//trim(item%appended)//new_line('a')
      open (newunit=unit, file=changed, access='stream', action='write', status='replace')
      write (unit) text
      close (unit)

   contains

      subroutine exchange(old, new)
         character(*), intent(in) :: old, new
         integer :: at
         at = index(text, old)
         if (at == 0) call stop_with('no '//old//' in '//path)
         text = text(:at - 1)//new//text(at + len(old):)
      end subroutine exchange

   end subroutine write_deck

   !> Largest error of a result in units of the scale; infinite if a sample is missing or not a number, negative if nothing is
   !> expected.
   subroutine compare(item, results, other, found)
      type(case_type), intent(in) :: item
      character(*), intent(in) :: results
      !> Results of the case that it is to be like
      character(*), intent(in) :: other
      real(wp), intent(out) :: found
      type(history_reader_type) :: reader, like
      type(error_type), allocatable :: error
      real(wp), allocatable :: values(:, :), expected(:, :)
      integer :: i
      found = 0.0_wp
      call reader%open(results, error)
      if (.not. allocated(error) .and. item%like /= '') then
         call like%open(other, error)
         do i = 1, merge(0, size(reader%channels), allocated(error))
            call reader%read_channel(reader%channels(i)%name, values, error)
            if (.not. allocated(error)) call like%read_channel(reader%channels(i)%name, expected, error)
            if (allocated(error)) exit
            call worsen(maxval(abs(values - expected))/item%scale, found)
         end do
         call like%close()
      end if
      do i = 1, item%values
         if (allocated(error)) exit
         call reader%read_channel(trim(item%value(i)%channel), values, error)
         if (allocated(error)) exit
         call worsen(abs(values(1, item%value(i)%sample + 1) - item%value(i)%value)/item%scale, found)
      end do
      if (allocated(error)) then
         print '(2a)', 'hard: ', error%message
         found = huge(found)
      end if
      if (item%values == 0 .and. item%like == '' .and. .not. allocated(error)) found = -1.0_wp
      call reader%close()
   end subroutine compare

   subroutine worsen(error, found)
      real(wp), intent(in) :: error
      real(wp), intent(inout) :: found
      if (error > found) found = error
      if (.not. error <= huge(error)) found = huge(found)
   end subroutine worsen

   function number(value) result(text)
      real(wp), intent(in) :: value
      character(:), allocatable :: text
      text = ''
      if (value >= 0.0_wp) text = as_text(value, 2)
   end function number

   !> The text in one line.
   function one_line(text) result(line)
      character(*), intent(in) :: text
      character(:), allocatable :: line
      integer :: i
      line = text
      do i = 1, len(line)
         if (line(i:i) == new_line('a') .or. line(i:i) == tab()) line(i:i) = ' '
      end do
      line = trim(line)
   end function one_line

   pure character function tab()
      tab = achar(9)
   end function tab

end module hard_cases

program hard
   use, intrinsic :: ieee_exceptions, only: ieee_set_flag, ieee_set_halting_mode, ieee_all
   use hard_cases, only: case_type, read_cases, run_case, integrators
   implicit none
   ! Some cases end where a distance vanishes or a law has no value: they are to be refused, not stopped by a program that traps
   call ieee_set_halting_mode(ieee_all, .false.)
   call run()
   call ieee_set_flag(ieee_all, .false.)

contains

   subroutine run()
      type(case_type), allocatable :: cases(:)
      character(400) :: words(5), word
      integer :: i, j, count
      logical :: long, good, all_good
      long = .false.
      count = 0
      words = ''
      do i = 1, command_argument_count()
         call get_command_argument(i, word)
         if (word == '--long') then
            long = .true.
         else if (count < size(words)) then
            count = count + 1
            words(count) = word
         end if
      end do
      if (count < 2) error stop 'hard TABLE FOLDER [--long] [CASE [INTEGRATOR]]'
      call read_cases(trim(words(1)), cases)
      all_good = .true.
      count = 0
      do i = 1, size(cases)
         if (words(3) /= '' .and. words(3) /= cases(i)%name) cycle
         if (cases(i)%long .and. .not. long) cycle
         do j = 1, size(integrators)
            if (words(4) /= '' .and. words(4) /= integrators(j)) cycle
            call run_case(cases, i, j, words(1)(:index(words(1), '/', back=.true.)), trim(words(2))//'/', good)
            all_good = all_good .and. good
            count = count + 1
         end do
      end do
      if (count == 0) error stop 'hard: no such case'
      if (.not. all_good) error stop 1
   end subroutine run

end program hard
