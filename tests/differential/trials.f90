!> A deck as text, run into memory as `limber run` does it, and what comes of it.
module trials
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: newline
   use limber_analysis_error_estimate, only: kept_type, estimate_type, make_estimate
   use limber_analysis_estimate_report, only: estimate_warning
   use limber_scene_outcome, only: outcome_type
   use limber_monitor_model_ranges, only: range_warnings
   use limber_analysis_provenance, only: open_history, record_outcome, record_steps
   use limber_scene_first_scene, only: build_scene
   use limber_scene_scene, only: scene_type
   use limber_analysis_analysis_steps, only: run_steps, passed_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_reader, only: read_deck_text
   use limber_beam_reduction_cache, only: library_type
   use limber_integrator_statistics, only: step_statistics_type
   use limber_model_analyses, only: single_dynamics
   implicit none
   private
   public :: candidate_type, try, kinds_of_warnings

   !> How many times beyond its limit an indicator of the model is told in every view
   real(wp), parameter :: beyond = 3.0_wp
   !> CPU seconds after which a run is given up
   real(wp), public :: patience = 1.0_wp

   !> A run
   type :: candidate_type
      !> As the command ends: 0, 2 for a deck that cannot be used, 3 for a run that could not finish
      integer :: status = 0
      !> Why, and what is warned of
      character(:), allocatable :: message, warnings
      !> The warnings, of the model those alone that are `beyond` times beyond their limits
      character(:), allocatable :: plain_warnings
      !> Channels (channels, samples); their estimated errors, if they were asked for
      real(wp), allocatable :: values(:, :), errors(:, :)
      !> Frequencies of *MODES, all analyses one after another, with damping ratios behind them (2, modes)
      real(wp), allocatable :: modes(:, :)
      !> Largest axial force, shear force and bending moment of the envelope, either sign; 0 without one
      real(wp) :: envelope(3) = 0.0_wp
      real(wp) :: cpu = 0.0_wp
   end type candidate_type

   !> Reductions of beams that earlier runs have made
   type(library_type) :: library

contains

   !> Runs a deck.
   subroutine try(text, trial)
      character(*), intent(in) :: text
      type(candidate_type), intent(out) :: trial
      type(scene_type) :: scene
      type(diagnostics_type) :: diagnostics
      type(error_type), allocatable :: error
      type(kept_type) :: history
      type(passed_type) :: passed
      type(outcome_type) :: outcome
      type(step_statistics_type) :: statistics
      type(error_type), allocatable :: ignored
      character(:), allocatable :: lines, plain
      real(wp) :: before
      integer :: i, samples
      trial%message = ''
      trial%warnings = ''
      trial%plain_warnings = ''
      allocate (trial%modes(2, 0))
      call cpu_time(before)
      call read_deck_text('scene.inp', text, scene%deck, diagnostics)
      call build_scene(scene, diagnostics, error, library)
      if (allocated(error)) then
         trial%status = 2
         if (error%status > 0) trial%status = error%status
         trial%message = error%message
         allocate (trial%values(0, 0))
         return
      end if
      if (.not. scene%system%model%dynamics%wanted) then
         trial%status = 2
         trial%message = 'nothing to run'
         allocate (trial%values(0, 0))
         return
      end if
      history%keeps = .true.
      samples = 0
      do i = 1, size(scene%system%model%steps)
         samples = samples + scene%system%model%steps(i)%dynamics%outputs + 1
      end do
      call history%memory%start(size(scene%system%model%channels), samples + 100, huge(1.0_wp))
      call history%watch_limit(patience)
      call open_history(scene, 'scene.h5', .true., history%history_type, error, unkept=.true.)
      if (.not. allocated(error)) call run_steps(scene, 'scene.inp', .true., history, passed, outcome, statistics, lines, error)
      call record_steps(scene, passed, history%history_type, ignored)
      call cpu_time(trial%cpu)
      trial%cpu = trial%cpu - before
      plain = ''
      if (allocated(outcome%indicators)) plain = range_warnings(outcome%indicators, scene%system%model, beyond)
      trial%plain_warnings = scene%warnings//plain
      if (allocated(outcome%indicators)) scene%warnings = scene%warnings//range_warnings(outcome%indicators, scene%system%model)
      allocate (trial%values, source=history%memory%values(:, :history%memory%samples))
      if (allocated(lines)) call read_modes(lines, trial%modes)
      if (allocated(outcome%efforts)) then
         do i = 1, size(outcome%efforts)
            if (.not. allocated(outcome%efforts(i)%extremes)) cycle
            associate (extremes => outcome%efforts(i)%extremes)
               trial%envelope = max(trial%envelope, maxval(maxval(abs(extremes(:3, :, :)), 3), 2))
            end associate
         end do
      end if
      if (allocated(error)) then
         trial%status = 3
         trial%message = error%message
      else if (.not. all(ieee_is_finite(trial%values))) then
         trial%status = 99
         trial%message = 'a channel is not finite'
      else if (scene%system%model%accuracy%estimate .and. single_dynamics(scene%system%model)) then
         call estimate_errors()
      end if
      trial%warnings = scene%warnings
      call record_outcome(scene, outcome, statistics, 'in memory', history%history_type, ignored)

   contains

      subroutine estimate_errors()
         type(estimate_type) :: estimate
         call make_estimate(scene, history%memory, outcome%bound, statistics%steps, statistics%evaluations, outcome%cpu, &
            & .true., estimate)
         scene%warnings = scene%warnings//estimate_warning(estimate, scene%system%model%channels)
         if (estimate%reason == '') trial%errors = estimate%values
      end subroutine estimate_errors

   end subroutine try

   !> Frequencies and damping ratios from the tables of a report.
   subroutine read_modes(lines, modes)
      character(*), intent(in) :: lines
      real(wp), allocatable, intent(inout) :: modes(:, :)
      real(wp) :: row(4)
      integer :: first, last, status
      logical :: inside
      first = 1
      inside = .false.
      do while (first <= len(lines))
         last = first + index(lines(first:)//newline, newline) - 2
         if (inside) then
            read (lines(first:last), *, iostat=status) row
            if (status == 0) then
               modes = reshape([modes, row([2, 4])], [2, size(modes, 2) + 1])
            else
               inside = .false.
            end if
         end if
         if (index(lines(first:last), 'mode   frequency') > 0) inside = .true.
         first = last + 2
      end do
   end subroutine read_modes

   !> Warnings without names in quotes and without numbers, each once, one in a line.
   function kinds_of_warnings(warnings) result(kinds)
      character(*), intent(in) :: warnings
      character(:), allocatable :: kinds, plain
      integer :: first, last
      kinds = newline
      plain = ''
      first = 1
      do while (first <= len(warnings))
         last = first + index(warnings(first:)//newline, newline) - 2
         if (warnings(first:min(last, first + 7)) == 'warning:' .or. index(warnings(first:last), ': warning:') > 0) then
            plain = without_numbers(without_others(warnings(first + index(warnings(first:last), 'warning:') - 1:last)))
            if (index(kinds, newline//plain//newline) == 0) kinds = kinds//plain//newline
         end if
         first = last + 2
      end do
   end function kinds_of_warnings

   !> A message without the number of other bodies of which the same is told, and without the word that its number is a lower limit.
   pure function without_others(message) result(text)
      character(*), intent(in) :: message
      character(:), allocatable :: text
      character(*), parameter :: before = ' (and ', behind = ' more)', at_least = ' more than'
      integer :: first, last
      text = message
      first = index(text, at_least)
      if (first > 0) text = text(:first - 1)//text(first + len(at_least):)
      first = index(text, before)
      if (first == 0) return
      last = index(text(first:), behind)
      if (last > 0) text = text(:first - 1)//text(first + last - 1 + len(behind):)
   end function without_others

   !> The beginning of a message without names in quotes, numbers and what joins them.
   pure function without_numbers(message) result(plain)
      character(*), intent(in) :: message
      character(:), allocatable :: plain
      character(60) :: line
      logical :: quoted
      integer :: i, n
      quoted = .false.
      line = ''
      n = 0
      do i = 1, len(message)
         if (message(i:i) == "'") quoted = .not. quoted
         if (quoted .or. scan(message(i:i), '0123456789.-+') > 0) cycle
         if (is_exponent(message, i)) cycle
         n = n + 1
         line(n:n) = message(i:i)
         if (n == len(line)) exit
      end do
      plain = line(:n)
   end function without_numbers

   !> Whether a letter is the e of a number.
   pure logical function is_exponent(message, i)
      character(*), intent(in) :: message
      integer, intent(in) :: i
      is_exponent = i > 1 .and. i < len(message) .and. message(i:i) == 'e'
      if (is_exponent) is_exponent = scan(message(i - 1:i - 1), '0123456789') > 0 .and. &
         & scan(message(i + 1:i + 1), '0123456789-+') > 0
   end function is_exponent

end module trials
