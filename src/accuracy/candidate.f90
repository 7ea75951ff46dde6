!> Run of a candidate setting. A search for a target tries it. Floor: accuracy; deck + rungs -> scene -> samples.
module limber_accuracy_candidate
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use limber_base_kinds, only: wp, long
   use limber_base_error, only: error_type, raise, status_interrupted
   use limber_base_signals, only: signal_came, signal_name
   use limber_base_text, only: as_text, first_line
   use limber_analysis_chosen_integrator, only: new_integrator
   use limber_analysis_dynamic_analysis, only: run_dynamics
   use limber_scene_channel_errors, only: magnitude
   use limber_analysis_error_estimate, only: add_quantities, round_off
   use limber_scene_outcome, only: outcome_type
   use limber_accuracy_fidelity_levels, only: level_type, apply_rung
   use limber_scene_first_scene, only: build_scene
   use limber_scene_scene, only: scene_type
   use limber_deck_content, only: deck_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_integrator_bound_steps, only: bound_steps_type
   use limber_integrator_integrator, only: integrator_type
   use limber_integrator_statistics, only: step_statistics_type
   use limber_model_model, only: channel_type
   use limber_monitor_function_channels, only: lost_along
   use limber_output_progress, only: progress_type
   use limber_output_channel_values, only: sample_width
   use limber_output_sample_sink, only: memory_type
   implicit none
   private
   public :: candidate_type, run_request_type, run_trial, take_samples, take_trial

   !> Samples in memory of a run that is given up when they leave those of another by too much
   type, extends(memory_type) :: watched_type
      !> Channels of the other run (channels, samples), and the largest differences; not allocated: nothing is watched
      real(wp), allocatable :: truth(:, :), allowed(:)
      logical :: leaves = .false.
   contains
      procedure :: append => append_watched
   end type watched_type

   !> Letters of a channel's name that messages show
   integer, parameter :: name_length = 40

   !> A run in memory
   type :: candidate_type
      type(watched_type) :: samples
      type(step_statistics_type) :: statistics
      type(outcome_type), allocatable :: outcome
      !> Why it failed; empty if it did not
      character(:), allocatable :: reason
      !> Whether it was given up as it left the samples of another by too much
      logical :: leaves = .false.
      !> What may be off of forces that channels ask for, as beams vibrate along themselves in ways that their functions of the
      !> strain do not follow, relative
      real(wp) :: ringing = 0.0_wp
      !> Counted work of its time loop, eq. (7.97); the same on every machine
      real(wp) :: work = 0.0_wp
      character(10) :: integrator = ''
      !> Magnitude that each channel's errors are relative to (channels), and whether it is that of its terms
      real(wp), allocatable :: scale(:)
      logical, allocatable :: of_terms(:)
      !> Names of the channels that the deck asks for, for people (channels)
      character(name_length), allocatable :: names(:)
   end type candidate_type

   !> A run that is asked for
   type :: run_request_type
      !> Fidelity levels of the open beams, tolerance, and the integrator in place of the deck's; blank: the deck's
      type(level_type), allocatable :: rungs(:)
      real(wp) :: tolerance = 0.0_wp
      character(5) :: integrator = ''
      !> Its tolerance over that of the run that it verifies: steps that the deck gives become shorter, as those of order two would
      real(wp) :: part = 1.0_wp
      !> Counted work after which it is given up
      real(wp) :: limit = huge(1.0_wp)
      !> Whether the quantities of the channels are sampled too, and their scales found
      logical :: wide = .false.
      !> The integrator that AUTO must choose, or nothing is run; blank: any
      character(5) :: only = ''
      !> Samples that it may leave only by so much, in each channel, or it is given up; and work of its steps after which it is
      real(wp), allocatable :: truth(:, :), allowed(:)
      real(wp) :: most = huge(1.0_wp)
      !> For the progress
      character(:), allocatable :: label
   end type run_request_type

contains

   !> Runs a setting into memory.
   subroutine run_trial(deck, request, quiet, trial, error, pace)
      type(deck_type), intent(in) :: deck
      type(run_request_type), intent(in) :: request
      !> Whether the progress is not shown
      logical, intent(in) :: quiet
      type(candidate_type), intent(out) :: trial
      !> The deck is wrong (status 2), or a signal asks for the end (status 4); of the run there is what it had come to then
      type(error_type), allocatable, intent(out) :: error
      !> Steps of the run that it verifies
      type(bound_steps_type), intent(in), optional :: pace
      type(scene_type) :: scene
      type(diagnostics_type) :: diagnostics
      type(progress_type) :: progress
      type(error_type), allocatable :: failure
      class(integrator_type), allocatable :: integrator
      type(channel_type), allocatable :: channels(:)
      integer :: i, width
      trial%reason = ''
      allocate (trial%outcome)
      scene%deck = deck
      if (request%integrator /= '') call scene%deck%set_option(deck%find('DYNAMICS'), 'INTEGRATOR', trim(request%integrator), &
         & given=.true.)
      do i = 1, size(request%rungs)
         call apply_rung(request%rungs(i), scene%deck)
      end do
      call scene%deck%set_number(deck%find('DYNAMICS'), 'TOLERANCE', request%tolerance)
      call build_scene(scene, diagnostics, error)
      if (allocated(error)) return
      trial%integrator = scene%system%model%dynamics%integrator
      if (request%only /= '' .and. trial%integrator /= request%only) then
         trial%reason = 'AUTO chooses another integrator'
         return
      end if
      associate (model => scene%system%model, part => request%part)
         width = size(model%channels)
         allocate (trial%names(width))
         do i = 1, width
            trial%names(i) = model%channels(i)%name
         end do
         if (request%wide) then
            call move_alloc(model%channels, channels)
            call add_quantities(channels, model%channels)
            model%motion = .false.
         end if
         width = sample_width(scene%system)
         model%dynamics%initial_step = part**(1.0_wp/3)*model%dynamics%initial_step
         model%dynamics%maximum_step = part**(1.0_wp/3)*model%dynamics%maximum_step
         model%dynamics%fixed_step = part**(1.0_wp/3)*model%dynamics%fixed_step
         call new_integrator(model%dynamics, integrator)
         call trial%samples%start(width, model%dynamics%outputs + 1, huge(1.0_wp))
         trial%samples%most_evaluations = int(min(request%limit/work_of(scene%system%layout%nw), 1.0e18_wp), long)
         trial%samples%heeds_signals = .true.
         if (allocated(request%truth)) then
            allocate (trial%samples%truth, source=request%truth)
            allocate (trial%samples%allowed, source=request%allowed)
         end if
         model%dynamics%maximum_steps = min(model%dynamics%maximum_steps, most_steps())
         if (.not. quiet) call progress%start(model%dynamics%start, model%dynamics%end, request%label)
         call run_dynamics(scene, integrator, trial%samples, progress, trial%outcome, failure, pace=pace)
         if (present(pace)) trial%outcome%bound%factor = merge(pace%factor, 1.0_wp, pace%prevail())
         if (.not. quiet) call progress%finish()
         trial%statistics = integrator%statistics
         if (signal_came()) then
            call raise(error, 'interrupted by '//signal_name()//" in the run '"//request%label//"' at t = "// &
               & as_text(trial%outcome%reached, 4), status_interrupted)
            return
         end if
         trial%work = trial%statistics%evaluations*work_of(scene%system%layout%nw)
         trial%integrator = model%dynamics%integrator
         if (allocated(trial%outcome%indicators)) trial%ringing = lost_along(trial%outcome%indicators%functions, model)
         if (allocated(trial%samples%truth)) deallocate (trial%samples%truth)
         if (allocated(failure)) then
            trial%reason = first_line(failure%message)
            trial%leaves = trial%samples%leaves
         else if (.not. all(ieee_is_finite(trial%samples%values))) then
            trial%reason = 'a channel is not finite'
         end if
         if (request%wide .and. trial%reason == '') call find_scales(channels, trial)
      end associate

   contains

      !> Steps after which it has cost too much, by the evaluations that each takes at least.
      pure integer function most_steps()
         integer :: each
         each = 1
         if (scene%system%model%dynamics%integrator == 'ALPHA') each = 2
         if (scene%system%model%dynamics%integrator == 'RADAU') each = 9
         most_steps = 1 + int(min(1.0e8_wp, request%most/(each*work_of(scene%system%layout%nw))))
      end function most_steps

   end subroutine run_trial

   !> What an evaluation costs with so many rates, its part of the factorisation of the Newton matrix included, eq. (7.97).
   pure real(wp) function work_of(rates) result(work)
      integer, intent(in) :: rates
      work = 1.0_wp + 0.005_wp*real(rates, wp)**2
   end function work_of

   !> Stores a sample; too far from the other run's it is the last.
   subroutine append_watched(self, t, values, error)
      class(watched_type), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), intent(in) :: values(:)
      type(error_type), allocatable, intent(out) :: error
      integer :: i
      call self%memory_type%append(t, values, error)
      if (allocated(error) .or. .not. allocated(self%truth)) return
      do i = 1, size(self%allowed)
         if (abs(values(i) - self%truth(i, self%samples)) > self%allowed(i)) then
            call raise(error, 'it errs by more than it may')
            self%leaves = .true.
            return
         end if
      end do
   end subroutine append_watched

   !> Moves a run.
   subroutine take_trial(from, to)
      type(candidate_type), intent(inout) :: from, to
      to%samples%samples = from%samples%samples
      to%statistics = from%statistics
      to%work = from%work
      to%ringing = from%ringing
      to%integrator = from%integrator
      call take_samples(from%samples%memory_type, to%samples%memory_type)
      call move_alloc(from%outcome, to%outcome)
      call move_alloc(from%reason, to%reason)
      call move_alloc(from%scale, to%scale)
      call move_alloc(from%of_terms, to%of_terms)
      call move_alloc(from%names, to%names)
   end subroutine take_trial

   !> Moves samples.
   subroutine take_samples(from, to)
      type(memory_type), intent(inout) :: from, to
      to%samples = from%samples
      call move_alloc(from%times, to%times)
      call move_alloc(from%values, to%values)
   end subroutine take_samples

   !> What errors of the channels are relative to: their largest magnitude; of one that is the small difference of large terms, such
   !> as an energy balance, that of its terms.
   subroutine find_scales(channels, trial)
      !> As the deck asks for them; behind them in the samples are their quantities
      type(channel_type), intent(in) :: channels(:)
      type(candidate_type), intent(inout) :: trial
      !> Part of its terms below which a channel counts as zero
      real(wp), parameter :: small = 1.0e-2_wp
      real(wp), allocatable :: floors(:), sizes(:)
      real(wp) :: largest
      integer :: i, j, first, n
      n = trial%samples%samples
      first = size(channels)
      allocate (trial%scale(size(channels)), trial%of_terms(size(channels)), floors(n), sizes(n))
      do i = 1, size(channels)
         associate (asked => channels(i)%quantities)
            call round_off(channels(i), trial%samples%values(first + 1:first + size(asked), :n), [(0.0_wp, j=1, size(asked))], &
               & trial%statistics%steps, floors, sizes)
            first = first + size(asked)
            largest = magnitude(trial%samples%values(i, :n))
            trial%scale(i) = largest
            trial%of_terms(i) = size(asked) > 1 .and. largest < small*maxval(sizes)
            if (trial%of_terms(i)) trial%scale(i) = maxval(sizes)
         end associate
      end do
   end subroutine find_scales

end module limber_accuracy_candidate
