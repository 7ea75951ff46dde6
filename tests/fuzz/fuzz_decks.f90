!> Decks that try to break limber: decks of input/, changed by chance, are read, built and assembled, and with --run also run for a
!> moment. None may crash, hang, or be refused without a place in the deck. A case follows from its number and the decks alone, so
!> that one that fails can be looked at again: the number is in the file `fuzz.case` of the working folder.
!>
!>    fuzz_decks [--run] [--show] [--slow] FIRST COUNT DECK ...
!>
!> --show prints the decks; --slow has ten times the patience, for builds with all checks. The messages that were met, without
!> names and numbers, are left in the file `fuzz.messages`.
module fuzzing
   use, intrinsic :: iso_c_binding, only: c_int, c_long, c_ptr, c_null_ptr
   use limber_base_error, only: error_type, status_deck
   use limber_base_kinds, only: wp, long
   use limber_base_names, only: name_index_type
   use limber_base_text, only: as_text, newline
   use limber_commands_batch, only: batch_type
   use limber_commands_run, only: run_one
   use limber_scene_first_scene, only: build_scene
   use limber_scene_scene, only: scene_type
   use limber_deck_source, only: longest_file => max_file_bytes
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_keywords, only: keyword_table, option_table
   use limber_deck_reader, only: read_deck_text
   implicit none
   private
   public :: text_type, tally_type, mutant, try_deck, try_run, read_text, set_alarm

   !> Seconds of processor time that a deck may take
   integer, parameter, public :: patience = 2

   type :: text_type
      character(:), allocatable :: text
   end type text_type

   !> What came out
   type :: tally_type
      integer :: accepted = 0, refused = 0, finished = 0, stopped = 0, placeless = 0
      !> What was said without a place
      character(:), allocatable :: remark
      !> Messages without their names and numbers, each once
      type(name_index_type) :: messages
      !> File that they are written to
      integer :: unit = 0
      !> What runs share: reductions that have been made once
      type(batch_type) :: batch
   end type tally_type

   !> Of setitimer: processor time of the program; its two pairs of seconds and microseconds
   integer(c_int), parameter :: processor_time = 2

   interface
      integer(c_int) function c_set_timer(which, value, old) bind(c, name='setitimer')
         import :: c_int, c_long, c_ptr
         integer(c_int), value :: which
         integer(c_long), intent(in) :: value(4)
         type(c_ptr), value :: old
      end function c_set_timer
      integer(c_int) function c_alarm(seconds) bind(c, name='alarm')
         import :: c_int
         integer(c_int), value :: seconds
      end function c_alarm
   end interface

   !> Seconds of processor time after which a run ends
   real(wp), parameter :: moment = 0.25_wp

   !> Decks that are longer are changed no more
   integer, parameter :: longest = 200000

   integer(long) :: state = 1

   !> Values at which programs break
   character(*), parameter :: values(*) = [character(24) :: '0', '-1', '1', '2', '1e308', '-1e308', '1e-308', '5e-324', '1e999', &
      & 'nan', 'inf', '1/0', '2147483647', '2147483648', '-2147483648', '999999999999999999999', '0.5', '1e-12', '1e12', &
      & '((((((((1))))))))', '1e', '.', '-', '2**1024', 'sqrt(-1)', 'pi', 't', '<i>', '<', &
      & '''', '"', '""', '*', '**', ',', ',,', '=', 'x(rod)', 'ground', 'ground.origin', 'NAME=', 'YES', &
      & '../../etc/passwd', '/dev/null', '/', achar(9), achar(0), char(255), &
      & '1000000', '100000', '1e6', '7', '3', 'exp(1000)', '-0', '10000', '1000', '200', '20']
   character(*), parameter :: digits = '0123456789'

contains

   !> A whole number from 1 to n, by the minimal standard generator of Park and Miller.
   integer function chance(n)
      integer, intent(in) :: n
      state = mod(state*16807_long, 2147483647_long)
      chance = 1 + int(mod(state/7, int(n, long)))
   end function chance

   !> The deck of a case.
   function mutant(number, decks) result(text)
      integer, intent(in) :: number
      type(text_type), intent(in) :: decks(:)
      character(:), allocatable :: text
      integer :: i
      state = mod(48271_long*number + 11, 2147483646_long) + 1
      do i = 1, 5  ! neighbours part
         state = mod(state*16807_long, 2147483647_long)
      end do
      text = decks(chance(size(decks)))%text
      do
         call change(text, decks)
         if (len(text) == 0 .or. len(text) > longest) exit
         if (chance(2) == 1) exit
      end do
      ! Longer files are not read
      if (len(text) > longest_file) text = text(:min(len(text), longest_file))
      if (len(text) <= longest .and. index(text, '*REPEAT') > 0) call shorten_repeats(text)
   end function mutant

   !> Takes all digits but the first from whole numbers of two to six, unless they belong to a name or have a point: those would be
   !> allowed, but long, turns of a *REPEAT, and chains of a few links break like long ones.
   subroutine shorten_repeats(text)
      character(:), allocatable, intent(inout) :: text
      logical :: kept(len(text))
      character(len(text)) :: shorter
      integer :: first, last, i, n
      kept = .true.
      first = 1
      do while (first <= len(text))
         last = first
         if (scan(text(first:first), digits) == 1) then
            do while (last < len(text))
               if (scan(text(last + 1:last + 1), digits) == 0) exit
               last = last + 1
            end do
            if (first > 1 .and. last > first .and. last < first + 6) &
               & kept(first + 1:last) = index(' =,+-*/(', text(first - 1:first - 1)) == 0
         end if
         first = last + 1
      end do
      n = 0
      do i = 1, len(text)
         if (.not. kept(i)) cycle
         n = n + 1
         shorter(n:n) = text(i:i)
      end do
      text = shorter(:n)
   end subroutine shorten_repeats

   !> One change.
   subroutine change(text, decks)
      character(:), allocatable, intent(inout) :: text
      type(text_type), intent(in) :: decks(:)
      character(:), allocatable :: part
      integer :: a, b, c, i
      select case (chance(14))
      case (1)  ! a letter
         a = chance(len(text))
         text = text(:a - 1)//achar(chance(126))//text(a + 1:)
      case (2)  ! a line less
         call pick_line(text, a, b)
         text = text(:a - 1)//text(b + 1:)
      case (3)  ! a line twice
         call pick_line(text, a, b)
         text = text(:b)//text(a:b)//text(b + 1:)
      case (4)  ! a line elsewhere
         call pick_line(text, a, b)
         part = text(a:b)
         text = text(:a - 1)//text(b + 1:)
         if (len(text) == 0) return
         call pick_line(text, a, b)
         text = text(:b)//part//text(b + 1:)
      case (5, 6, 7)  ! a word or number replaced
         call pick_word(text, a, b)
         text = text(:a - 1)//trim(values(chance(size(values))))//text(b + 1:)
      case (8)  ! a word by another word of the decks
         associate (other => decks(chance(size(decks)))%text)
            call pick_word(other, a, b)
            part = other(a:b)
         end associate
         call pick_word(text, a, b)
         text = text(:a - 1)//part//text(b + 1:)
      case (9)  ! a line of another deck
         associate (other => decks(chance(size(decks)))%text)
            call pick_line(other, a, b)
            part = other(a:b)
         end associate
         call pick_line(text, a, b)
         text = text(:b)//part//text(b + 1:)
      case (10)  ! a keyword
         call pick_line(text, a, b)
         text = text(:b)//'*'//trim(keyword_table(chance(size(keyword_table)))%name)//newline//text(b + 1:)
      case (11)  ! an option with a value
         call pick_block(text, a, b)
         c = chance(size(option_table))
         do i = 1, 400  ! of this keyword, in most cases
            if (index(text(a:b)//' ', '*'//trim(option_table(c)%keyword)) == 1) exit
            c = chance(size(option_table))
         end do
         part = ', '//trim(option_table(c)%name)//'='//trim(values(chance(size(values))))
         text = text(:max(a, b - 1))//part//newline//text(b + 1:)
      case (12)  ! the end missing
         text = text(:chance(len(text)))
      case (13)  ! a block of another deck
         associate (other => decks(chance(size(decks)))%text)
            call pick_line(other, a, b)
            c = index(other(b:), newline//'*')
            if (c == 0) c = len(other) - b + 1
            part = other(a:b + c - 1)
         end associate
         call pick_line(text, a, b)
         text = text(:b)//part//text(b + 1:)
      case (14)  ! very much of something
         call pick_word(text, a, b)
         text = text(:b)//repeat(text(a:b), chance(30)**2)//text(b + 1:)
      end select
   end subroutine change

   !> First and last character of a line, its end included.
   subroutine pick_line(text, first, last)
      character(*), intent(in) :: text
      integer, intent(out) :: first, last
      integer :: at
      at = chance(len(text))
      first = index(text(:at - 1), newline, back=.true.) + 1
      last = index(text(at:), newline)
      last = merge(len(text), at + last - 1, last == 0)
   end subroutine pick_line

   !> First and last character of the keyword line before a place by chance, its end included; or of another line.
   subroutine pick_block(text, first, last)
      character(*), intent(in) :: text
      integer, intent(out) :: first, last
      call pick_line(text, first, last)
      first = max(1, index(text(:first), newline//'*', back=.true.) + 1)
      if (text(first:first) /= '*') call pick_line(text, first, last)
      last = index(text(first:), newline)
      last = merge(len(text), first + last - 1, last == 0)
   end subroutine pick_block

   !> First and last character of a word.
   subroutine pick_word(text, first, last)
      character(*), intent(in) :: text
      integer, intent(out) :: first, last
      character(*), parameter :: between = ' ,=()+*/'//achar(10)
      integer :: at
      at = chance(len(text))
      first = at
      do while (first > 1)
         if (scan(text(first - 1:first - 1), between) > 0) exit
         first = first - 1
      end do
      last = at
      do while (last < len(text))
         if (scan(text(last + 1:last + 1), between) > 0) exit
         last = last + 1
      end do
   end subroutine pick_word

   !> Reads, builds and assembles a deck.
   subroutine try_deck(text, tally, accepted)
      character(*), intent(in) :: text
      type(tally_type), intent(inout) :: tally
      logical, intent(out) :: accepted
      type(scene_type) :: scene
      type(diagnostics_type) :: diagnostics
      type(error_type), allocatable :: error
      integer :: i
      call read_deck_text('fuzz.inp', text, scene%deck, diagnostics)
      call build_scene(scene, diagnostics, error, tally%batch%library)
      accepted = .not. allocated(error)
      if (accepted) then
         tally%accepted = tally%accepted + 1
         if (diagnostics%count > 0) call remark(tally, 'accepted with errors')
      else
         tally%refused = tally%refused + 1
         if (.not. has_place(error%message)) call remark(tally, error%message)
         do i = 1, diagnostics%kept
            call note(tally, diagnostics%items(i)%message)
         end do
      end if
   end subroutine try_deck

   !> Takes note of a deck that was refused without a place.
   subroutine remark(tally, message)
      type(tally_type), intent(inout) :: tally
      character(*), intent(in) :: message
      tally%placeless = tally%placeless + 1
      tally%remark = message(:min(300, len(message)))
   end subroutine remark

   !> Whether each error has a line, or else is one of a whole file that lacks something.
   logical function has_place(message)
      !> Rendered errors
      character(*), intent(in) :: message
      character(*), parameter :: of_files(*) = [character(24) :: 'the deck is empty', 'this file is not a text', &
         & 'the deck has no']
      integer :: first, last, i
      first = 1
      has_place = .true.
      do while (has_place .and. first <= len(message))
         last = index(message(first:)//newline, newline) + first - 2
         if (index(message(first:last), 'error: ') > 0 .and. index(message(first:last), ' | ') == 0) then
            has_place = has_line(message(first:last))
            do i = 1, size(of_files)
               has_place = has_place .or. index(message(first:last), trim(of_files(i))) > 0
            end do
         end if
         first = last + 2
      end do
   end function has_place

   !> Whether a text has the name of a file with the number of a line.
   pure logical function has_line(text)
      character(*), intent(in) :: text
      integer :: at
      has_line = .false.
      at = max(index(text, '.inp:'), index(text, '.csv:'))
      if (at > 0 .and. at + 5 <= len(text)) has_line = scan(text(at + 5:at + 5), digits) == 1
   end function has_line

   !> Runs a deck for a moment.
   subroutine try_run(text, tally)
      character(*), intent(in) :: text
      type(tally_type), intent(inout) :: tally
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      integer :: unit
      open (newunit=unit, file='fuzz.inp', access='stream', form='unformatted', status='replace', action='write')
      write (unit) text
      close (unit)
      if (.not. allocated(tally%batch%overrides)) allocate (tally%batch%overrides(0))
      tally%batch%unkept = .true.
      tally%batch%limit = moment
      call run_one('fuzz.inp', 'fuzz.h5', .true., .true., tally%batch, report, error)
      if (.not. allocated(error)) then
         tally%finished = tally%finished + 1
      else
         if (error%status /= status_deck) tally%stopped = tally%stopped + 1
         call note(tally, error%message(:index(error%message//newline, newline) - 1))
      end if
   end subroutine try_run

   !> Counts a message, without names in quotes and without digits.
   subroutine note(tally, message)
      type(tally_type), intent(inout) :: tally
      character(*), intent(in) :: message
      character(:), allocatable :: plain
      logical :: quoted
      integer :: i
      plain = ''
      quoted = .false.
      do i = 1, min(len(message), 400)
         if (message(i:i) == "'") quoted = .not. quoted
         if (quoted .or. scan(message(i:i), '0123456789.-+') > 0) cycle
         plain = plain//message(i:i)
      end do
      if (tally%messages%find(plain) > 0) return
      call tally%messages%add(plain, tally%messages%count + 1)
      if (tally%unit == 0) return
      write (tally%unit, '(a)') plain
      flush (tally%unit)
   end subroutine note

   !> The text of a file.
   function read_text(path) result(text)
      character(*), intent(in) :: path
      character(:), allocatable :: text
      integer :: unit, bytes
      open (newunit=unit, file=path, access='stream', form='unformatted', status='old', action='read')
      inquire (unit=unit, size=bytes)
      allocate (character(bytes) :: text)
      read (unit) text
      close (unit)
   end function read_text

   !> Ends the program after some seconds of processor time, or of what it takes on a machine that is very busy, unless it is called
   !> again before; 0: never.
   subroutine set_alarm(seconds)
      integer, intent(in) :: seconds
      integer(c_int) :: ignored
      ignored = c_set_timer(processor_time, [0_c_long, 0_c_long, int(seconds, c_long), 0_c_long], c_null_ptr)
      ignored = c_alarm(int(300*seconds, c_int))
   end subroutine set_alarm

end module fuzzing

program fuzz_decks
   use, intrinsic :: iso_fortran_env, only: output_unit
   use limber_base_text, only: as_text
   use limber_deck_keywords, only: load_language
   use fuzzing, only: text_type, tally_type, mutant, try_deck, try_run, read_text, set_alarm, patience
   implicit none
   call load_language()
   call main()

contains

   subroutine main()
      type(text_type), allocatable :: decks(:)
      type(tally_type) :: tally
      character(:), allocatable :: text
      character(4096) :: word
      integer :: first, count, i, arguments, unit, seconds
      logical :: runs, shows, accepted
      seconds = patience
      runs = .false.
      shows = .false.
      arguments = 0
      do
         call get_command_argument(arguments + 1, word)
         if (word == '--run') runs = .true.
         if (word == '--show') shows = .true.
         if (word == '--slow') seconds = 10*patience
         if (word(1:2) /= '--') exit
         arguments = arguments + 1
      end do
      read (word, *) first
      call get_command_argument(arguments + 2, word)
      read (word, *) count
      allocate (decks(command_argument_count() - arguments - 2))
      do i = 1, size(decks)
         call get_command_argument(arguments + 2 + i, word)
         decks(i)%text = read_text(trim(word))
      end do
      open (newunit=unit, file='fuzz.case', access='stream', form='unformatted', status='replace', action='write')
      open (newunit=tally%unit, file='fuzz.messages', status='replace', action='write')
      do i = first, first + count - 1
         write (unit, pos=1) as_text(i)//' '
         flush (unit)
         call set_alarm(seconds)
         text = mutant(i, decks)
         if (shows) write (output_unit, '(a)') text
         call try_deck(text, tally, accepted)
         if (allocated(tally%remark)) then
            write (output_unit, '(a)') 'case '//as_text(i)//' without a place: '//tally%remark
            deallocate (tally%remark)
         end if
         if (runs .and. accepted) call try_run(text, tally)
      end do
      call set_alarm(0)
      close (unit, status='delete')
      close (tally%unit)
      write (output_unit, '(a)') as_text(count)//' decks: '//as_text(tally%accepted)//' accepted, '//as_text(tally%refused)// &
         & ' refused; '//as_text(tally%messages%count)//' distinct messages'
      if (runs) write (output_unit, '(a)') as_text(tally%finished)//' runs finished, '//as_text(tally%stopped)// &
         & ' stopped with a message'
      if (tally%placeless > 0) then
         write (output_unit, '(a)') as_text(tally%placeless)//' decks were refused without a place'
         error stop
      end if
   end subroutine main

end program fuzz_decks
