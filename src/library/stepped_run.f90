!> A run that a program holds and steps: opens a deck, goes on to a time, gives channels and state there. Between two calls it is a
!> snapshot, the one that checkpoints hold: a run in pieces has the bits of `limber run`, and may go back to a saved state. What
!> shows a time within a step is not part of the motion. Floor: library; a program, or the C interface, calls it.
!>
!>     call run%open('pendulum.inp', error)
!>     if (.not. allocated(error)) call run%advance(0.5_wp, error)
!>     if (.not. allocated(error)) call run%show(values)
module limber_library_stepped_run
   use limber_base_error, only: error_type, raise, status_deck, status_interrupted, status_run
   use limber_base_fault, only: add_fault, forget_fault
   use limber_base_kinds, only: wp, long
   use limber_base_text, only: as_text, newline
   use limber_base_version, only: version, commit, compiler, compiler_options
   use limber_analysis_analysis_steps, only: run_steps, passed_type
   use limber_analysis_chosen_integrator, only: new_integrator
   use limber_analysis_dynamic_analysis, only: run_dynamics
   use limber_analysis_run_report, only: energy_warning
   use limber_commands_advise, only: target_of
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_effective, only: effective_deck
   use limber_deck_parameters, only: override_type
   use limber_deck_reader, only: read_deck, read_deck_text
   use limber_integrator_integrator, only: integrator_type
   use limber_integrator_statistics, only: step_statistics_type
   use limber_library_sample_store, only: store_type
   use limber_model_analyses, only: single_dynamics
   use limber_model_model, only: analysis_step_type, dynamics_type, step_dynamics
   use limber_monitor_model_ranges, only: range_warnings
   use limber_multibody_kinematics, only: angle_type
   use limber_output_progress, only: progress_type
   use limber_scene_first_scene, only: build_scene
   use limber_scene_outcome, only: outcome_type, all_warnings
   use limber_scene_pause, only: pause_type
   use limber_scene_scalar_values, only: scalar_values, scalar_warnings
   use limber_scene_scene, only: scene_type
   implicit none
   private
   public :: stepped_run_type, saved_type

   !> A place that a run can go on from
   type :: bookmark_type
      !> The snapshot
      real(wp), allocatable :: reals(:)
      integer, allocatable :: integers(:)
      !> Earliest time that can be shown from there; samples before it
      real(wp) :: from = 0.0_wp
      integer :: samples = 0
      !> Whether it is between two analyses, and the one before is a *DYNAMICS
      logical :: between = .false., follows_motion = .false.
      !> Inputs on the way to the time of the run: whether they are set, and their values (controls)
      logical, allocatable :: is_given(:)
      real(wp), allocatable :: given(:)
   end type bookmark_type

   !> State of a run that can be saved
   type :: saved_type
      type(bookmark_type) :: place
      !> Program and deck; only the same ones can go on from there
      character(:), allocatable :: label
      !> Time of the run; coordinates and velocities at it (nq)
      real(wp) :: time = 0.0_wp
      real(wp), allocatable :: q(:), v(:)
      !> Inputs from that time on (controls)
      logical, allocatable :: is_given(:)
      real(wp), allocatable :: given(:)
   end type saved_type

   !> What a run changes of its scene, as it was when it was opened
   type :: opened_type
      type(dynamics_type) :: dynamics
      type(analysis_step_type), allocatable :: steps(:)
      real(wp), allocatable :: q(:), v(:)
      type(angle_type), allocatable :: angles(:)
      character(:), allocatable :: warnings
      real(wp) :: begin = 0.0_wp
   end type opened_type

   !> A run
   type :: stepped_run_type
      type(scene_type) :: scene
      !> Samples so far; some may be behind the time of the run, for the integrator goes in steps of its own
      type(store_type) :: store
      !> Name of the deck, for messages
      character(:), allocatable :: path
      !> Time of the run, and its last time
      real(wp) :: time = 0.0_wp, end = 0.0_wp
      !> Whether it has come to its end, or has failed
      logical :: is_complete = .false., has_failed = .false.
      !> Warnings of the deck, and of the motion once it is complete; empty if there are none
      character(:), allocatable :: warnings
      !> Coordinates and velocities at the time (nq)
      real(wp), allocatable :: q(:), v(:)
      !> Channels there, if it is not that of a sample (channels)
      real(wp), allocatable, private :: values(:)
      type(opened_type), private :: opened
      !> Where it goes on, and the place before that; not allocated before the first pause
      type(bookmark_type), allocatable, private :: now, earlier
      !> Why it has failed; warnings of the deck
      character(:), allocatable, private :: failure, first_warnings
   contains
      procedure :: open => open_deck, open_text, advance => advance_run, samples => visible_samples, show => show_values
      procedure :: scalars => run_scalars, set_input, number_of_inputs, input_name
      procedure :: save => save_state, restore => restore_state
      procedure, private :: begin => begin_run, run_piece
   end type stepped_run_type

contains

   !> Opens a deck and finds its first state.
   subroutine open_deck(self, path, error, overrides)
      class(stepped_run_type), intent(inout) :: self
      !> The deck
      character(*), intent(in) :: path
      !> Everything that is wrong with the deck, each with file:line:column; status 2
      type(error_type), allocatable, intent(out) :: error
      !> Values of parameters in place of those of the deck
      type(override_type), intent(in), optional :: overrides(:)
      type(diagnostics_type) :: diagnostics
      self%path = path
      call read_deck(path, self%scene%deck, diagnostics, overrides)
      call self%begin(diagnostics, error)
   end subroutine open_deck

   !> The same of a deck that is a text.
   subroutine open_text(self, text, path, error, overrides)
      class(stepped_run_type), intent(inout) :: self
      !> The whole deck, lines separated by line feeds
      character(*), intent(in) :: text
      !> Its name in messages; files that it names are relative to the folder of this name
      character(*), intent(in) :: path
      !> Everything that is wrong with the deck; status 2
      type(error_type), allocatable, intent(out) :: error
      !> Values of parameters in place of those of the deck
      type(override_type), intent(in), optional :: overrides(:)
      type(diagnostics_type) :: diagnostics
      self%path = path
      call read_deck_text(path, text, self%scene%deck, diagnostics, overrides)
      call self%begin(diagnostics, error)
   end subroutine open_text

   !> Builds the scene of the deck that has been read.
   subroutine begin_run(self, diagnostics, error)
      class(stepped_run_type), intent(inout) :: self
      type(diagnostics_type), intent(inout) :: diagnostics
      type(error_type), allocatable, intent(out) :: error
      call forget_fault()
      if (diagnostics%count == 0 .and. target_of(self%scene%deck) > 0.0_wp) then
         call raise(error, self%path//': the library does not search for a TARGET; run the deck that `limber run` leaves in its'// &
            & ' results, which has the choices in place of it', status_deck)
         return
      end if
      call build_scene(self%scene, diagnostics, error)
      call add_fault(error)
      if (allocated(error)) return
      associate (model => self%scene%system%model)
         if (.not. model%dynamics%wanted) then
            call raise(error, self%path//': nothing to run; add an analysis, such as *DYNAMICS (limber help DYNAMICS)', status_deck)
            return
         end if
         self%warnings = self%scene%warnings
         if (model%accuracy%estimate) self%warnings = self%warnings//'warning: ESTIMATE=YES is for `limber run`; the library'// &
            & ' does not estimate errors'//newline
         self%first_warnings = self%warnings
         self%time = model%steps(1)%dynamics%start
         self%end = model%steps(size(model%steps))%dynamics%end
         call self%store%start(size(model%channels), model%dynamics%outputs + 1)
         if (size(model%scalars) > 0) call self%store%summarise(size(model%channels))
         self%opened%dynamics = model%dynamics
         allocate (self%opened%steps, source=model%steps)
      end associate
      self%opened%q = self%scene%q
      self%opened%v = self%scene%v
      self%q = self%scene%q
      self%v = self%scene%v
      if (allocated(self%scene%work%kinematics%angles)) allocate (self%opened%angles, source=self%scene%work%kinematics%angles)
      self%opened%warnings = self%scene%warnings
      self%opened%begin = self%scene%begin
   end subroutine begin_run

   !> Goes on to a time, or to the end of the run if that comes first. Within a *DYNAMICS channels and state are then those of that
   !> very time; another analysis is run as a whole, and shows its last sample up to the time.
   subroutine advance_run(self, t, error)
      class(stepped_run_type), intent(inout) :: self
      !> Not before the time of the run; huge(t): to the end
      real(wp), intent(in) :: t
      !> The run could not go on: why, and when. What it has computed up to there stays
      type(error_type), allocatable, intent(out) :: error
      type(bookmark_type), allocatable :: start
      real(wp) :: target
      if (self%has_failed) then
         call raise(error, self%failure, status_run)
         return
      end if
      if (.not. t >= self%time) then
         call raise(error, self%path//': the run is at t = '//as_text(self%time, 8)//' and cannot go back to '//as_text(t, 8)// &
            & '; it can by a state that was saved', status_deck)
         return
      end if
      ! Nothing is left to wait for at the end
      target = t
      if (t >= self%end) target = huge(t)
      if (target < huge(t)) call begin_motion(self, error)
      if (allocated(error)) return
      if (self%is_complete) then
         self%time = max(self%time, min(t, self%end))
         return
      end if
      if (.not. allocated(self%now)) then
         call self%run_piece(target, error=error)
         return
      end if
      if (self%now%between .and. .not. self%now%follows_motion .and. target <= self%now%from) then
         self%time = t
         return
      end if
      if (is_behind(self%now, target)) then
         allocate (start, source=self%earlier)
         call self%run_piece(target, start, error)
         return
      end if
      self%now%is_given = self%scene%system%is_given
      self%now%given = self%scene%system%given
      allocate (start, source=self%now)
      call self%run_piece(target, start, error)
      if (.not. allocated(error)) call move_alloc(start, self%earlier)
   end subroutine advance_run

   !> Whether the integrator has left a time behind it, which is then shown from the place before.
   pure logical function is_behind(place, t)
      type(bookmark_type), intent(in) :: place
      real(wp), intent(in) :: t
      is_behind = t < place%from .and. .not. place%between
      if (place%follows_motion) is_behind = t <= place%from
   end function is_behind

   !> Goes to the first pause, at the start, unless the run has begun.
   subroutine begin_motion(self, error)
      class(stepped_run_type), intent(inout) :: self
      !> The run could not begin
      type(error_type), allocatable, intent(out) :: error
      if (.not. (self%is_complete .or. self%has_failed .or. allocated(self%now))) call self%run_piece(self%time, error=error)
   end subroutine begin_motion

   !> Runs from a place to a time.
   subroutine run_piece(self, t, start, error)
      class(stepped_run_type), intent(inout) :: self
      real(wp), intent(in) :: t
      !> Absent: from the start
      type(bookmark_type), intent(in), optional :: start
      type(error_type), allocatable, intent(out) :: error
      type(pause_type) :: guard
      type(outcome_type) :: outcome
      type(passed_type) :: passed
      type(progress_type) :: progress
      type(step_statistics_type) :: statistics
      class(integrator_type), allocatable :: integrator
      character(:), allocatable :: lines
      logical, allocatable :: is_given(:)
      real(wp), allocatable :: given(:)
      logical :: moves
      real(wp) :: reached
      call restore_scene(self%scene, self%opened)
      guard%path = 'the saved state'
      guard%trouble = ''
      guard%until = t
      is_given = self%scene%system%is_given
      given = self%scene%system%given
      self%store%count = 0
      if (present(start)) then
         self%store%count = start%samples
         self%scene%system%is_given = start%is_given
         self%scene%system%given = start%given
         guard%snapshot%reals = start%reals
         guard%snapshot%integers = start%integers
         guard%restarting = .true.
      end if
      call forget_fault()
      associate (model => self%scene%system%model)
         if (single_dynamics(model)) then
            call new_integrator(model%dynamics, integrator)
            call run_dynamics(self%scene, integrator, self%store, progress, outcome, error, guard)
            reached = outcome%reached
            moves = .true.
         else
            call run_steps(self%scene, self%path, .true., self%store, passed, outcome, statistics, lines, error, guard)
            reached = outcome%reached
            moves = .false.
            if (passed%count > 0) moves = model%steps(passed%count)%kind == step_dynamics
         end if
      end associate
      call add_fault(error)
      self%scene%system%is_given = is_given
      self%scene%system%given = given
      if (allocated(error)) then
         if (error%status == status_interrupted .and. guard%paused) then
            deallocate (error)
            call note_pause()
         else
            self%has_failed = .true.
            self%failure = self%path//': '//error%message
            error%message = self%failure
            ! What is shown is the last sample
            if (allocated(self%values)) deallocate (self%values)
            if (allocated(self%scene%last%q)) then
               self%q = self%scene%last%q
               self%v = self%scene%last%v
            end if
            self%time = max(self%time, min(t, reached))
            if (self%store%count > 0) self%time = max(self%time, min(t, self%store%times(self%store%count)))
         end if
         return
      end if
      if (moves .and. t < reached .and. guard%paused) then
         ! It has come to its end within the step that shows the time, and does so again
         call take_shown()
         return
      end if
      self%is_complete = .true.
      self%end = reached
      self%time = min(t, reached)
      self%q = self%scene%last%q
      self%v = self%scene%last%v
      if (single_dynamics(self%scene%system%model)) then
         self%warnings = self%warnings//all_warnings(outcome)//energy_warning(outcome, self%scene%system%model%dynamics)
      else
         self%warnings = self%warnings//self%scene%warnings(len(self%opened%warnings) + 1:)
      end if
      if (allocated(outcome%indicators)) self%warnings = self%warnings//range_warnings(outcome%indicators, self%scene%system%model)
      if (size(self%scene%system%model%scalars) > 0) self%warnings = self%warnings// &
         & scalar_warnings(self%scene%system%model, self%store)

   contains

      !> Takes note of where the run goes on.
      subroutine note_pause()
         if (.not. allocated(self%now)) allocate (self%now)
         self%now%reals = guard%snapshot%reals
         self%now%integers = guard%snapshot%integers
         self%now%from = guard%from
         self%now%samples = self%store%count
         self%now%between = guard%is_between
         self%now%follows_motion = guard%is_between .and. moves
         self%now%is_given = is_given
         self%now%given = given
         call take_shown()
      end subroutine note_pause

      !> Takes what is shown at the time.
      subroutine take_shown()
         self%time = t
         if (allocated(guard%values)) then
            self%values = guard%values
            self%q = guard%q
            self%v = guard%v
         else
            if (allocated(self%values)) deallocate (self%values)
            self%q = self%scene%last%q
            self%v = self%scene%last%v
         end if
      end subroutine take_shown

   end subroutine run_piece

   !> Makes a scene what it was when it was opened; the rest of it comes from the snapshot.
   subroutine restore_scene(scene, opened)
      type(scene_type), intent(inout) :: scene
      type(opened_type), intent(in) :: opened
      scene%system%model%dynamics = opened%dynamics
      scene%system%model%steps = opened%steps
      scene%q = opened%q
      scene%v = opened%v
      scene%begin = opened%begin
      scene%warnings = opened%warnings
      if (allocated(scene%angle)) deallocate (scene%angle)
      if (allocated(opened%angles)) scene%work%kinematics%angles(:) = opened%angles
   end subroutine restore_scene

   !> Number of the samples up to the time of the run.
   pure integer function visible_samples(self) result(number)
      class(stepped_run_type), intent(in) :: self
      number = self%store%up_to(self%time)
   end function visible_samples

   !> Channels at the time of the run: those of the sample if there is one there, to the bit.
   subroutine show_values(self, values, error)
      class(stepped_run_type), intent(inout) :: self
      !> In the order of the channels (channels)
      real(wp), intent(out) :: values(:)
      !> The run could not begin
      type(error_type), allocatable, intent(out) :: error
      integer :: last
      values = 0.0_wp
      call begin_motion(self, error)
      if (allocated(error)) return
      last = self%samples()
      if (last > 0) values = self%store%channels(:, last)
      if (self%is_complete .or. .not. allocated(self%values)) return
      if (last > 0) then
         if (.not. self%store%times(last) < self%time) return
      end if
      values = self%values
   end subroutine show_values

   !> Values of the scalars over the samples that have been taken (scalars).
   function run_scalars(self) result(values)
      class(stepped_run_type), intent(in) :: self
      real(wp), allocatable :: values(:)
      values = scalar_values(self%scene%system%model, self%store)
   end function run_scalars

   !> Number of controls of TYPE=INPUT.
   pure integer function number_of_inputs(self) result(number)
      class(stepped_run_type), intent(in) :: self
      number = count(self%scene%system%model%controls%is_input)
   end function number_of_inputs

   !> Name of one of them.
   pure function input_name(self, number) result(name)
      class(stepped_run_type), intent(in) :: self
      !> From 1
      integer, intent(in) :: number
      character(:), allocatable :: name
      integer :: i, k
      name = ''
      k = 0
      do i = 1, size(self%scene%system%model%controls)
         if (.not. self%scene%system%model%controls(i)%is_input) cycle
         k = k + 1
         if (k == number) name = self%scene%system%model%controls(i)%name
      end do
   end function input_name

   !> Sets what a control of TYPE=INPUT takes at its next samples, from the one at the time of the run on.
   subroutine set_input(self, name, value, error)
      class(stepped_run_type), intent(inout) :: self
      character(*), intent(in) :: name
      real(wp), intent(in) :: value
      !> There is no such control
      type(error_type), allocatable, intent(out) :: error
      integer :: i
      associate (controls => self%scene%system%model%controls)
         do i = 1, size(controls)
            if (controls(i)%name /= name) cycle
            if (.not. controls(i)%is_input) exit
            self%scene%system%is_given(i) = .true.
            self%scene%system%given(i) = value
            return
         end do
      end associate
      call raise(error, self%path//": there is no *CONTROL, TYPE=INPUT with the name '"//name//"'", status_deck)
   end subroutine set_input

   !> The state at the time of the run, to go back to.
   subroutine save_state(self, saved, error)
      class(stepped_run_type), intent(inout) :: self
      type(saved_type), intent(out) :: saved
      !> The run has failed, or has come to its end without a pause
      type(error_type), allocatable, intent(out) :: error
      if (self%has_failed) call raise(error, self%failure, status_run)
      if (.not. allocated(error)) call begin_motion(self, error)
      if (allocated(error)) return
      if (.not. allocated(self%now)) then
         call raise(error, self%path//': the run has come to its end at once; advance it to a time before its end, and save the'// &
            & ' state there', status_deck)
         return
      end if
      if (is_behind(self%now, self%time)) then
         saved%place = self%earlier
      else
         saved%place = self%now
         saved%place%is_given = self%scene%system%is_given
         saved%place%given = self%scene%system%given
      end if
      saved%label = program_and_deck(self)
      saved%time = self%time
      saved%q = self%q
      saved%v = self%v
      saved%is_given = self%scene%system%is_given
      saved%given = self%scene%system%given
   end subroutine save_state

   !> Goes to a state that was saved, of this run or of another one of the same deck. Samples behind it are dropped.
   subroutine restore_state(self, saved, error)
      class(stepped_run_type), intent(inout) :: self
      type(saved_type), intent(in) :: saved
      !> It is of another program or deck; the run is left as it is
      type(error_type), allocatable, intent(out) :: error
      if (saved%label /= program_and_deck(self)) then
         call raise(error, self%path//': the state is of another deck, of other values of its parameters, or of another limber', &
            & status_deck)
         return
      end if
      self%has_failed = .false.
      self%is_complete = .false.
      self%warnings = self%first_warnings
      self%end = self%opened%steps(size(self%opened%steps))%dynamics%end
      self%now = saved%place
      self%now%samples = min(saved%place%samples, self%store%count)
      self%store%count = self%now%samples
      if (allocated(self%earlier)) deallocate (self%earlier)
      if (allocated(self%values)) deallocate (self%values)
      self%time = saved%time
      self%q = saved%q
      self%v = saved%v
      self%scene%system%is_given = saved%place%is_given
      self%scene%system%given = saved%place%given
      call self%advance(saved%time, error)
      self%scene%system%is_given = saved%is_given
      self%scene%system%given = saved%given
   end subroutine restore_state

   !> What a state belongs to.
   function program_and_deck(self) result(text)
      class(stepped_run_type), intent(in) :: self
      character(:), allocatable :: text
      text = version//' '//commit//' '//compiler//' '//compiler_options//newline//effective_deck(self%scene%deck)
   end function program_and_deck

end module limber_library_stepped_run
