!> limber: dynamics of planar flexible multibody systems.
!>
!>    deck -> model -> modes -> system -> integrator -> history
!>
!> The commands live in src/commands; the only places that print or stop are here.
program limber
   use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
   use limber_base_ending, only: guard_ending, leave
   use limber_base_error, only: error_type
   use limber_base_fault, only: add_fault
   use limber_base_libraries, only: keep_heap, use_one_thread
   use limber_base_signals, only: end_by_signals, let_writes_fail
   use limber_base_text, only: newline
   use limber_commands_advise, only: advise_deck
   use limber_commands_check, only: check_deck
   use limber_commands_command_line, only: command_type, read_command, usage
   use limber_commands_diff, only: compare_histories
   use limber_commands_drawing, only: export_motion
   use limber_commands_export, only: export_history
   use limber_commands_help, only: help_on, version_text
   use limber_commands_run, only: run_deck
   use limber_commands_study, only: study_deck
   use limber_commands_sweep, only: sweep_deck
   implicit none
   type(command_type) :: command
   type(error_type), allocatable :: error
   character(:), allocatable :: report
   logical :: same

   same = .true.
   report = ''
   call guard_ending()
   call let_writes_fail()
   call end_by_signals()
   call use_one_thread()
   call keep_heap()
   call read_command(command, error)
   if (.not. allocated(error)) then
      select case (command%verb)
      case ('run')
         call run_deck(trim(command%words(1)), command%output, command%force, command%quiet, report, error, command%overrides, &
            & command%request)
      case ('study'); call study_deck(trim(command%words(1)), command%output, command%force, command%quiet, report, error)
      case ('sweep')
         call sweep_deck(trim(command%words(1)), command%output, command%sweep, command%force, command%quiet, report, error)
      case ('advise')
         call advise_deck(trim(command%words(1)), command%overrides, command%advice, command%force, report, error)
      case ('check'); call check_deck(trim(command%words(1)), command%overrides, report, error)
      case ('export')
         if (command%motion) then
            call export_motion(trim(command%words(1)), command%drawing, output_unit, error)
         else
            call export_history(trim(command%words(1)), command%words(2:), output_unit, error)
         end if
      case ('diff'); call compare_histories(trim(command%words(1)), trim(command%words(2)), command%tolerance, report, same, error)
      case ('help'); call help_on(command%words, command%manual, report, error)
      case ('--version'); report = version_text()
      case default; report = usage()
      end select
   end if
   call add_fault(error)
   if (allocated(error)) then
      ! What is wrong of what was computed up to there
      if (.not. allocated(report)) report = ''
      if (report /= '') report = warnings_of(report)
      if (report /= '') write (output_unit, '(a)') report
      write (error_unit, '(a)') error%message
      flush (output_unit)
      call leave(error%status)
   end if
   if (command%quiet) report = warnings_of(report)
   if (len(report) > 0) write (output_unit, '(a)') report
   flush (output_unit)
   call leave(merge(0, 1, same))

contains

   !> What --quiet leaves of a report: the warnings of a run, which stand before the line of its deck.
   function warnings_of(report) result(text)
      character(*), intent(in) :: report
      character(:), allocatable :: text
      integer :: first
      text = ''
      if (command%verb /= 'run') return
      first = index(newline//report, newline//trim(command%words(1))//': ')
      ! Before the line feed that ends them
      if (first > 2) text = report(:first - 2)
   end function warnings_of

end program limber
