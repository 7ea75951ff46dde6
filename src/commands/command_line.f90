!> Command line: verbs, files, options. Floor: commands.
module limber_commands_command_line
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use limber_base_error, only: error_type, raise, status_deck
   use limber_base_text, only: nearest_name, newline
   use limber_base_kinds, only: wp
   use limber_commands_advise, only: advice_request_type
   use limber_commands_diff, only: tolerance_type
   use limber_commands_drawing, only: drawing_request_type
   use limber_scene_interruption, only: request_type
   use limber_commands_sweep, only: sweep_request_type
   use limber_commands_sweep_plan, only: swept_type, read_setting
   use limber_deck_sweep_table, only: is_number
   use limber_deck_parameters, only: override_type
   implicit none
   private
   public :: command_type, read_command, usage

   !> Longest argument that is taken
   integer, parameter :: longest = 4096

   character(*), parameter :: verbs(*) = [character(9) :: 'run', 'check', 'advise', 'study', 'sweep', 'export', 'diff', 'help', &
      & '--version', '--help']

   !> What the user asked for
   type :: command_type
      !> run, check, advise, study, sweep, export, diff, help, --version
      character(:), allocatable :: verb
      !> Files, channels or keywords, in order
      character(longest), allocatable :: words(:)
      !> Name of the result file; empty: from the deck's name
      character(:), allocatable :: output
      logical :: force = .false., quiet = .false., manual = .false.
      !> Values of parameters; what a sweep is asked for
      type(override_type), allocatable :: overrides(:)
      type(sweep_request_type) :: sweep
      !> How a run may be interrupted
      type(request_type) :: request
      !> What an advice is asked for
      type(advice_request_type) :: advice
      !> Tolerances of `diff`
      type(tolerance_type) :: tolerance
      !> Whether `export` is to print what can be drawn, and of that what
      logical :: motion = .false.
      type(drawing_request_type) :: drawing
   end type command_type

contains

   !> How limber is called.
   pure function usage() result(text)
      character(:), allocatable :: text
      text = join([character(120) :: &
         & 'limber: dynamics of planar flexible multibody systems', &
         & '', &
         & '   limber run DECK [--set NAME=VALUE ...] [-o FILE] [--force] [--quiet] [--restart] [--checkpoint S]', &
         & '                       run a deck; results in FILE (else its name with the ending .h5); --quiet: warnings alone;', &
         & '                       with other values of parameters. Each S seconds (600) and when a signal ends it (INT, TERM,', &
         & '                       USR1) it writes a checkpoint beside FILE, from which --restart goes on to the same bits;', &
         & '                       without results --restart begins, and complete ones it leaves as they are', &
         & '   limber check DECK [--set NAME=VALUE ...]', &
         & '                       read, build and assemble only', &
         & '   limber advise DECK [--set NAME=VALUE ...] [--target E] [--all] [--write FILE] [--force]', &
         & '                       say which model keeps the relative error E (else TARGET of the deck, else 1e-3)', &
         & '                       and what decided it; --all: also where the deck chooses; the deck with it in FILE', &
         & '   limber study DECK [-o FILE] [--force] [--quiet]', &
         & '                       weigh speed against error: integrators, tolerances and fineness of a deck;', &
         & '                       the table of the runs in FILE (else study.h5)', &
         & '   limber sweep DECK [--set NAME=FIRST:LAST:COUNT | NAME=VALUE,VALUE,... ...] [--jobs N] [--keep] [-o FILE]', &
         & '                       run a deck for many values of its parameters (*SWEEP), N runs at a time; summary in FILE', &
         & '                       (else the deck''s name with the ending .sweep.h5) and as .csv. Called again, it runs only', &
         & '                       what is missing or has failed; --force begins anew', &
         & '   limber sweep DECK --part K/N | --part auto', &
         & '                       only each N-th row from the K-th on (auto: as Slurm or MPI says), without a summary', &
         & '   limber sweep DECK --collect', &
         & '                       only the summary', &
         & '   limber export FILE [CHANNEL ...]', &
         & '                       print channels of a result as plain columns', &
         & '   limber export FILE --motion [--sample K | --time T | --samples N] [--deflection F] [--path POINT]', &
         & '                       print lines to draw the mechanism with: at sample K from 0, the one nearest to T,', &
         & '                       or N of all; deflections times F; paths of points (postproc/draw draws them)', &
         & '   limber diff A B [--rtol R] [--range R] [--atol A]', &
         & '                       compare result A with reference B, channel by channel: relative, as part of', &
         & '                       the reference''s range, absolute', &
         & '   limber help [KEYWORD]', &
         & '                       explain the deck''s keywords; --manual prints the reference chapter', &
         & '   limber --version    version, commit and compiler', &
         & '', &
         & 'Status: 0 done, 1 results differ, 2 deck or command cannot be used, 3 the run could not finish,', &
         & '4 a signal has ended the command; a run goes on with --restart, a sweep when it is called again.'])
   end function usage

   !> Lines put together.
   pure function join(lines) result(text)
      character(*), intent(in) :: lines(:)
      character(:), allocatable :: text
      integer :: i
      text = trim(lines(1))
      do i = 2, size(lines)
         text = text//newline//trim(lines(i))
      end do
   end function join

   !> Reads the command line.
   subroutine read_command(command, error)
      type(command_type), intent(out) :: command
      type(error_type), allocatable, intent(out) :: error
      character(longest) :: word
      integer :: i, length
      allocate (command%words(0), command%overrides(0), command%sweep%settings(0))
      command%output = ''
      command%verb = '--help'
      i = 1
      do while (i <= command_argument_count())
         call get_command_argument(i, word, length)
         if (length /= len_trim(word) .and. length <= longest) then
            call raise(error, "the argument '"//word(:length)//"' ends in a blank, which limber does not keep: give another name", &
               & status_deck)
            return
         end if
         if (length > longest) then
            call raise(error, 'an argument is longer than 4096 characters', status_deck)
            return
         end if
         if (i == 1) then
            command%verb = trim(word)
            if (.not. any(verbs == word)) call complain('command', word, error)
         else
            call take(command, i, word, error)
         end if
         if (allocated(error)) return
         i = i + 1
      end do
      call check_count(command, error)
   end subroutine read_command

   !> One option or word behind the verb.
   subroutine take(command, i, word, error)
      type(command_type), intent(inout) :: command
      !> Index of the argument; one further if it takes a value
      integer, intent(inout) :: i
      character(*), intent(in) :: word
      type(error_type), allocatable, intent(out) :: error
      character(longest) :: value
      character(*), parameter :: options(*) = [character(12) :: '-o', '--force', '--quiet', '--rtol', '--range', '--atol', &
         & '--manual', '--motion', '--sample', '--time', '--samples', '--deflection', '--path', '--set', '--jobs', '--part', &
         & '--collect', '--keep', '--target', '--write', '--all', '--restart', '--checkpoint']
      select case (word)
      case ('--collect'); command%sweep%collect = .true.
      case ('--keep'); command%sweep%keep = .true.
      case ('--restart'); command%request%restart = .true.
      case ('--all'); command%advice%all = .true.
      case ('--force'); command%force = .true.
      case ('--quiet'); command%quiet = .true.
      case ('--manual'); command%manual = .true.
      case ('--motion'); command%motion = .true.
      case ('-o', '--rtol', '--range', '--atol', '--sample', '--time', '--samples', '--deflection', '--path', '--set', '--jobs', &
         & '--part', '--target', '--write', '--checkpoint')
         if (i == command_argument_count()) then
            call raise(error, 'a value is missing behind '//trim(word), status_deck)
            return
         end if
         i = i + 1
         call get_command_argument(i, value)
         if (word == '-o') command%output = trim(value)
         if (word == '--write') command%advice%write = trim(value)
         if (word == '--checkpoint') call read_real(value, command%request%interval, error)
         if (word == '--target') call read_real(value, command%advice%target, error)
         if (word == '--rtol') call read_real(value, command%tolerance%relative, error)
         if (word == '--range') call read_real(value, command%tolerance%of_range, error)
         if (word == '--atol') call read_real(value, command%tolerance%absolute, error)
         if (word == '--set') call take_setting(command, value, error)
         if (word == '--jobs') call read_count(value, command%sweep%jobs, error)
         if (word == '--part') call read_part(value, command%sweep, error)
         call take_drawing(command%drawing, word, value, error)
      case default
         if (word(1:1) == '-' .and. len_trim(word) > 1) then
            call complain('option', word, error, options)
         else
            command%words = [character(longest) :: command%words, word]
         end if
      end select
   end subroutine take

   !> `--set name=value` of run and check, `--set name=values` of sweep.
   subroutine take_setting(command, value, error)
      type(command_type), intent(inout) :: command
      character(*), intent(in) :: value
      type(error_type), allocatable, intent(inout) :: error
      type(swept_type) :: axis
      type(swept_type), allocatable :: longer(:)
      type(override_type) :: override
      character(:), allocatable :: wanted
      logical :: ok
      integer :: count
      call read_setting(trim(value), axis, ok)
      if (ok .and. command%verb /= 'sweep') ok = size(axis%values) == 1
      if (.not. ok) then
         wanted = 'name=value'
         if (command%verb == 'sweep') wanted = 'name=value,value,... or name=first:last:count'
         call raise(error, "--set '"//trim(value)//"' is not "//wanted, status_deck)
         return
      end if
      if (command%verb == 'sweep') then
         count = size(command%sweep%settings)
         allocate (longer(count + 1))
         longer(:count) = command%sweep%settings
         longer(count + 1) = axis
         call move_alloc(longer, command%sweep%settings)
      else
         override%name = axis%names(1)
         override%value = axis%values(1, 1)
         command%overrides = [command%overrides, override]
      end if
   end subroutine take_setting

   !> `K/N`, or `auto`.
   subroutine read_part(value, request, error)
      character(*), intent(in) :: value
      type(sweep_request_type), intent(inout) :: request
      type(error_type), allocatable, intent(inout) :: error
      integer :: slash
      request%scheduled = value == 'auto'
      if (request%scheduled) return
      slash = index(value, '/')
      call read_count(value(:max(0, slash - 1)), request%part, error)
      if (.not. allocated(error)) call read_count(value(slash + 1:), request%parts, error)
      if (slash == 0 .or. allocated(error) .or. request%part < 1 .or. request%part > request%parts) then
         if (allocated(error)) deallocate (error)
         call raise(error, "--part '"//trim(value)//"' is not K/N with K from 1 to N, nor auto", status_deck)
      end if
   end subroutine read_part

   !> An option with a value of `export --motion`.
   subroutine take_drawing(drawing, word, value, error)
      type(drawing_request_type), intent(inout) :: drawing
      character(*), intent(in) :: word, value
      type(error_type), allocatable, intent(inout) :: error
      select case (word)
      case ('--sample'); call read_count(value, drawing%sample, error)
      case ('--samples'); call read_count(value, drawing%samples, error)
      case ('--deflection'); call read_real(value, drawing%deflection, error)
      case ('--time')
         drawing%at_time = .true.
         call read_real(value, drawing%time, error)
      case ('--path')
         if (.not. allocated(drawing%paths)) allocate (drawing%paths(0))
         drawing%paths = [character(len(drawing%paths)) :: drawing%paths, value]
      end select
   end subroutine take_drawing

   !> Too few or too many files.
   subroutine check_count(command, error)
      type(command_type), intent(in) :: command
      type(error_type), allocatable, intent(out) :: error
      integer :: least, most
      least = 0
      most = huge(most)
      select case (command%verb)
      case ('run', 'check', 'advise', 'study', 'sweep')
         least = 1
         most = 1
      case ('export')
         least = 1
         if (command%motion) most = 1
      case ('diff')
         least = 2
         most = 2
      end select
      if (size(command%words) < least) call raise(error, 'limber '//command%verb//': a file is missing'//newline//newline// &
         & usage(), status_deck)
      if (size(command%words) > most) call raise(error, 'limber '//command%verb//": '"//trim(command%words(most + 1))// &
         & "' is one file too many", status_deck)
   end subroutine check_count

   subroutine complain(kind, word, error, valid)
      character(*), intent(in) :: kind, word
      type(error_type), allocatable, intent(out) :: error
      character(*), intent(in), optional :: valid(:)
      character(:), allocatable :: hint
      integer :: near
      hint = ''
      if (present(valid)) then
         near = nearest_name(word, valid)
         if (near > 0) hint = "; did you mean '"//trim(valid(near))//"'?"
      else
         near = nearest_name(word, verbs)
         if (near > 0) hint = "; did you mean '"//trim(verbs(near))//"'?"
      end if
      call raise(error, 'there is no '//kind//" '"//trim(word)//"'"//hint//newline//newline//usage(), status_deck)
   end subroutine complain

   subroutine read_real(text, value, error)
      character(*), intent(in) :: text
      real(wp), intent(out) :: value
      type(error_type), allocatable, intent(out) :: error
      integer :: status
      value = 0.0_wp
      status = merge(0, 1, is_number(trim(text)))
      if (status == 0) read (text, *, iostat=status) value
      if (status == 0 .and. .not. ieee_is_finite(value)) status = 1
      if (status /= 0) call raise(error, "'"//trim(text)//"' is not a number", status_deck)
   end subroutine read_real

   subroutine read_count(text, value, error)
      character(*), intent(in) :: text
      integer, intent(out) :: value
      type(error_type), allocatable, intent(out) :: error
      integer :: status
      read (text, *, iostat=status) value
      if (status /= 0 .or. verify(trim(text), '0123456789') > 0) call raise(error, "'"//trim(text)//"' is not a whole number", &
         & status_deck)
   end subroutine read_count

end module limber_commands_command_line
