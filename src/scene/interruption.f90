!> Interruption of a run: checkpoints and signals. Checkpoints by wall time, and one more when a signal asks it to end. A checkpoint
!> is worth something beside the results that it belongs to: these are brought to safety first, and hold at least the samples that
!> there were then. Floor: scene.
module limber_scene_interruption
   use limber_base_error, only: error_type, raise, status_deck, status_run, status_interrupted
   use limber_base_kinds, only: wp, long
   use limber_base_process, only: own_number
   use limber_base_signals, only: catch_signals, release_signals, signal_came, signal_name
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text, newline
   use limber_base_version, only: version, commit, compiler, compiler_options
   use limber_output_checkpoint, only: checkpoint_type, write_checkpoint, read_checkpoint, checkpoint_name, checkpoint_format
   use limber_output_history_reader, only: history_reader_type
   use limber_output_hdf5, only: check_unused
   use limber_output_own_files, only: remove_own
   use limber_output_write_permission, only: check_results_place
   use limber_output_sample_sink, only: sink_type
   use limber_output_working_file, only: working_name
   implicit none
   private
   public :: interruption_type, request_type

   !> What the user asks for
   type :: request_type
      !> Whether an interrupted run is to go on
      logical :: restart = .false.
      !> Wall time between checkpoints [s]; zero: none but that of an interruption
      real(wp) :: interval = 600.0_wp
      !> Steps after which the run is interrupted as by a signal: for tests
      integer(long) :: stop_after = huge(1_long)
   end type request_type

   !> The guard of one run
   type :: interruption_type
      type(request_type) :: request
      !> False if the run can be interrupted, but not go on: it is a search
      logical :: continuable = .true.
      !> Samples of the analyses before the one that is under way
      integer :: before = 0
      !> Whether the errors of the run are estimated behind its last step
      logical :: estimates = .false.
      !> Name of the checkpoint; not allocated while nothing is guarded
      character(:), allocatable :: path
      !> What it says of the run
      type(checkpoint_type) :: checkpoint
      type(snapshot_type) :: snapshot
      !> Whether the run begins with the snapshot; whether it begins anew, in place of one that left samples but no checkpoint
      logical :: restarting = .false., anew = .false.
      !> Samples that stand there then; they are replaced by no fewer
      integer :: samples = 0
      !> What was found, a line for the report; empty if there was nothing
      character(:), allocatable :: note
      !> Why the last checkpoint could not be written; empty if all is well
      character(:), allocatable :: trouble
      !> Clock at the last checkpoint [ticks]; steps in this process
      integer(long), private :: last = 0, steps = 0
      !> Whether there is a checkpoint of this run
      logical, private :: has_checkpoint = .false.
      !> Time at which the run pauses, to go on from its snapshot; whether it has been reached, and the channels, coordinates and
      !> velocities there, if it is within a *DYNAMICS (channels), (nq), (nq)
      real(wp) :: until = huge(1.0_wp)
      logical :: paused = .false.
      real(wp), allocatable :: values(:), q(:), v(:)
      !> Earliest time that can be shown from the snapshot
      real(wp) :: from = -huge(1.0_wp)
   contains
      procedure :: find, start, asks, asks_between, asks_at_end, write, interrupt, finish, warning, note_line
      procedure :: pauses, show
   end type interruption_type

   !> Wall time that is lost without a checkpoint before the errors are estimated [s]
   real(wp), parameter :: worthwhile = 2.0_wp

contains

   !> Looks for what an earlier run has left: whether this one is to go on from there, may begin, or must not. Nothing is changed.
   subroutine find(self, results, deck, sources, request, force, done, error)
      class(interruption_type), intent(inout) :: self
      !> Name of the results, the deck that is to be run, and its files
      character(*), intent(in) :: results, deck, sources(:)
      type(request_type), intent(in) :: request
      !> Whether results may be replaced
      logical, intent(in) :: force
      !> True if the run has reached its end already
      logical, intent(out) :: done
      !> What was found, if this one cannot begin, or not go on from there
      type(error_type), allocatable, intent(out) :: error
      type(history_reader_type) :: reader
      logical :: exists
      done = .false.
      self%request = request
      self%path = checkpoint_name(results)
      self%checkpoint%program = version//' '//commit//' '//compiler//' '//compiler_options
      self%checkpoint%deck = deck
      self%checkpoint%run = new_number()
      self%trouble = ''
      self%note = ''
      call check_results_place(results, sources, request%restart, error)
      if (allocated(error)) return
      inquire (file=results, exist=exists)
      if (.not. request%restart) then
         if (exists .and. .not. force) call refuse_unfinished(self%continuable, results, error)
         return
      end if
      call check_unused(working_name(results), error)
      if (allocated(error)) then
         error%message = 'the run goes on still: '//error%message
         return
      end if
      if (.not. exists) then
         inquire (file=self%path, exist=exists)
         if (exists) call raise(error, self%path//' is there, but '//results//' that it goes on with is not; without --restart '// &
            & 'the run begins anew', status_deck)
         return
      end if
      call reader%open(results, error)
      if (allocated(error)) then
         error%message = results//' cannot be continued; it was left as it is: '//error%message
         return
      end if
      done = reader%complete
      if (done) call clear_away(self%path, reader)
      if (.not. done) call weigh(self, results, reader, error)
      call reader%close()
   end subroutine find

   !> Removes the checkpoint of a run that has reached its end, if it was killed before it could do that itself.
   subroutine clear_away(path, reader)
      !> Name of the checkpoint
      character(*), intent(in) :: path
      !> Open; complete
      type(history_reader_type), intent(in) :: reader
      type(checkpoint_type) :: found
      type(snapshot_type) :: snapshot
      type(error_type), allocatable :: error
      character(:), allocatable :: run
      call read_checkpoint(path, found, snapshot, error)
      if (.not. allocated(error)) call reader%read_label('/run', 'number', run, error)
      if (allocated(error)) return
      if (found%run /= run) return
      call remove_own(path, checkpoint_format)
      call remove_own(path//'.new', '')
   end subroutine clear_away

   !> Says of results that are there what they are, if they are those of a run that did not finish.
   subroutine refuse_unfinished(continuable, results, error)
      logical, intent(in) :: continuable
      character(*), intent(in) :: results
      type(error_type), allocatable, intent(out) :: error
      type(history_reader_type) :: reader
      type(error_type), allocatable :: ignored
      character(:), allocatable :: restart
      call reader%open(results, ignored)
      if (allocated(ignored)) return
      restart = ''
      if (continuable) restart = '--restart to continue it, '
      if (.not. reader%complete) call raise(error, results//' exists, with '//as_text(reader%samples)// &
         & ' samples of a run that did not finish; give '//restart//'--force to overwrite it or -o for another name', status_deck)
      call reader%close()
   end subroutine refuse_unfinished

   !> Looks whether a run can go on from some results.
   subroutine weigh(self, results, reader, error)
      class(interruption_type), intent(inout) :: self
      character(*), intent(in) :: results
      !> Open; not complete
      type(history_reader_type), intent(in) :: reader
      type(error_type), allocatable, intent(out) :: error
      type(checkpoint_type) :: found
      type(error_type), allocatable :: absent
      character(:), allocatable :: run, samples
      real(wp) :: checkpoints
      logical :: exists
      self%samples = reader%samples
      samples = results//' has '//as_text(reader%samples)//' samples of a run that did not finish'
      if (.not. self%continuable) then
         call raise(error, samples//'; the search for a TARGET cannot go on, it can be run anew with --force', status_deck)
         return
      end if
      run = ''
      checkpoints = 1.0_wp
      call reader%read_label('/run', 'number', run, absent)
      if (.not. allocated(absent)) call reader%read_statistic('checkpoints', checkpoints, absent)
      inquire (file=self%path, exist=exists)
      if (exists) call read_checkpoint(self%path, found, self%snapshot, error)
      if (allocated(error)) return
      if (exists) exists = found%run == run .or. checkpoints > 0.0_wp
      if (.not. exists) then
         if (checkpoints > 0.0_wp) call raise(error, samples//', but there is no '//self%path//' to continue it from; '// &
            & '--force without --restart begins anew', status_deck)
         if (.not. allocated(error)) call compare_origin(results, reader, self%checkpoint, error)
         self%anew = .not. allocated(error)
         if (run /= '') self%checkpoint%run = run
         self%note = samples//' and had written no checkpoint yet: begun anew'
         return
      end if
      call compare(self%path, results, run, reader%samples, found, self%checkpoint, error)
      if (allocated(error)) return
      self%checkpoint = found
      self%restarting = .true.
      self%has_checkpoint = .true.
      self%note = 'continued at t = '//as_text(found%time, 8)//' with sample '//as_text(found%samples + 1)
   end subroutine weigh

   !> Refuses to begin anew in place of results of something else.
   subroutine compare_origin(results, reader, wanted, error)
      character(*), intent(in) :: results
      type(history_reader_type), intent(in) :: reader
      type(checkpoint_type), intent(in) :: wanted
      type(error_type), allocatable, intent(out) :: error
      character(*), parameter :: names(*) = [character(16) :: 'limber_version', 'commit', 'compiler', 'compiler_options']
      character(:), allocatable :: program, deck, part
      integer :: i
      program = ''
      do i = 1, size(names)
         call reader%read_label('/run', trim(names(i)), part, error)
         if (allocated(error)) return
         program = program//' '//part
      end do
      call reader%read_text('/run/effective_deck', deck, error)
      if (allocated(error)) return
      if (program(2:) /= wanted%program) call raise(error, results//' is of another limber ('//program(2:)// &
         & '); only that one would give the same bits', status_deck)
      if (deck /= wanted%deck .and. .not. allocated(error)) call raise(error, results// &
         & ' is of a run of another deck; an interrupted run goes on with the deck as it was', status_deck)
   end subroutine compare_origin

   !> Refuses a checkpoint of something else.
   subroutine compare(path, results, run, samples, found, wanted, error)
      !> Names of the checkpoint and of the results; number of the run and samples in the results
      character(*), intent(in) :: path, results, run
      integer, intent(in) :: samples
      !> What the checkpoint says, and what it should
      type(checkpoint_type), intent(in) :: found, wanted
      type(error_type), allocatable, intent(out) :: error
      if (found%run /= run) then
         call raise(error, path//' is of another run than '//results, status_deck)
      else if (found%program /= wanted%program) then
         call raise(error, path//' was written by another limber ('//found%program//'); only that one goes on to the bit', &
            & status_deck)
      else if (found%deck /= wanted%deck) then
         call raise(error, path//' is of a run of another deck; an interrupted run goes on with the deck as it was', status_deck)
      else if (samples < found%samples) then
         call raise(error, results//' has '//as_text(samples)//' samples, but there were '//as_text(found%samples)//' when '// &
            & path//' was written', status_deck)
      end if
   end subroutine compare

   !> A number that no other run has.
   function new_number() result(text)
      character(:), allocatable :: text
      character(8) :: date
      character(10) :: time
      call date_and_time(date, time)
      text = date//'-'//time//'-'//as_text(own_number())
   end function new_number

   !> Begins to guard.
   subroutine start(self)
      class(interruption_type), intent(inout) :: self
      call system_clock(self%last)
      self%steps = 0
      call catch_signals()
   end subroutine start

   !> Whether a run pauses at a time, or before it.
   pure logical function pauses(self, t)
      class(interruption_type), intent(in) :: self
      real(wp), intent(in) :: t
      pauses = self%until <= t
   end function pauses

   !> Takes what is shown where a run pauses.
   pure subroutine show(self, values, q, v)
      class(interruption_type), intent(inout) :: self
      !> Channels (channels); coordinates and velocities (nq)
      real(wp), intent(in) :: values(:), q(:), v(:)
      self%paused = .true.
      self%values = values
      self%q = q
      self%v = v
   end subroutine show

   !> Whether a checkpoint is to be written behind this step, and whether the run is to end there.
   subroutine asks(self, save, stop)
      class(interruption_type), intent(inout) :: self
      logical, intent(out) :: save, stop
      self%steps = self%steps + 1
      stop = self%paused .or. signal_came() .or. self%steps >= self%request%stop_after
      save = stop
      if (.not. save .and. self%request%interval > 0.0_wp) save = seconds_since_last(self) > self%request%interval
   end subroutine asks

   !> The same before the next analysis of a deck.
   subroutine asks_between(self, t, save, stop)
      class(interruption_type), intent(inout) :: self
      !> Time at which the one before has ended
      real(wp), intent(in) :: t
      logical, intent(out) :: save, stop
      self%paused = self%pauses(t)
      stop = self%paused .or. signal_came()
      save = stop
      if (.not. save .and. self%request%interval > 0.0_wp) save = seconds_since_last(self) > self%request%interval
   end subroutine asks_between

   !> Whether a checkpoint is to be written behind the last step, before the errors of the run are estimated.
   logical function asks_at_end(self) result(save)
      class(interruption_type), intent(in) :: self
      save = .false.
      if (self%estimates) save = seconds_since_last(self) > min(worthwhile, self%request%interval)
   end function asks_at_end

   !> Wall time since the last checkpoint [s].
   real(wp) function seconds_since_last(self) result(seconds)
      class(interruption_type), intent(in) :: self
      integer(long) :: clock, rate
      call system_clock(clock, rate)
      seconds = real(clock - self%last, wp)/real(rate, wp)
   end function seconds_since_last

   !> Brings the samples to safety and writes the snapshot that has been saved. Where there is no room for that the run goes on, and
   !> the checkpoint before stays.
   subroutine write(self, history, samples, t, error)
      class(interruption_type), intent(inout) :: self
      class(sink_type), intent(inout) :: history
      !> Samples taken in this analysis, and time reached
      integer, intent(in) :: samples
      real(wp), intent(in) :: t
      !> Allocated if no more samples can be taken: the run is to end
      type(error_type), allocatable, intent(out) :: error
      type(error_type), allocatable :: write_error
      type(checkpoint_type) :: checkpoint
      call history%secure(self%trouble, error)
      if (allocated(error)) return
      if (self%trouble == '') then
         checkpoint = self%checkpoint
         checkpoint%samples = self%before + samples
         checkpoint%time = t
         call write_checkpoint(self%path, checkpoint, self%snapshot, write_error)
         if (allocated(write_error)) then
            self%trouble = write_error%message
         else
            self%checkpoint = checkpoint
            self%has_checkpoint = .true.
            call history%note_checkpoint(error)
         end if
      end if
      call system_clock(self%last)
   end subroutine write

   !> Ends a run behind its checkpoint.
   subroutine interrupt(self, t, error, is_earlier)
      class(interruption_type), intent(in) :: self
      !> Time reached
      real(wp), intent(in) :: t
      !> Allocated on return
      type(error_type), allocatable, intent(out) :: error
      !> Whether the checkpoint stands at an earlier time, the start of this analysis; false if absent
      logical, intent(in), optional :: is_earlier
      character(:), allocatable :: text
      logical :: there
      there = .true.
      if (present(is_earlier)) there = .not. is_earlier
      text = signal_name()
      if (text == '') text = 'request after '//as_text(self%steps)//' steps'
      text = 'interrupted by '//text//' at t = '//as_text(t, 8)
      if (self%trouble == '' .and. there) then
         call raise(error, text//'; it goes on from there with --restart', status_interrupted)
      else if (self%trouble == '') then
         call raise(error, text//'; with --restart it goes on from the start of this analysis', status_interrupted)
      else if (self%has_checkpoint) then
         call raise(error, text//'; with --restart it goes on from t = '//as_text(self%checkpoint%time, 8)// &
            & ', for no checkpoint could be written since: '//self%trouble, status_interrupted)
      else
         call raise(error, text//'; it cannot go on from there, for no checkpoint could be written: '//self%trouble, status_run)
      end if
   end subroutine interrupt

   !> Ends the guard; a run that has reached its end needs no checkpoint.
   subroutine finish(self, done)
      class(interruption_type), intent(inout) :: self
      logical, intent(in) :: done
      call release_signals()
      if (.not. done) return
      call remove_own(self%path, checkpoint_format)
      ! What a kill has left while a checkpoint was written
      call remove_own(self%path//'.new', '')
   end subroutine finish

   !> A warning if the last checkpoint could not be written; empty if all is well.
   function warning(self)
      class(interruption_type), intent(in) :: self
      character(:), allocatable :: warning
      warning = ''
      if (self%trouble /= '') warning = 'warning: the last checkpoint could not be written: '//self%trouble//newline
   end function warning

   !> What was found at the start, as a line of the report; empty if there was nothing.
   function note_line(self, path) result(line)
      class(interruption_type), intent(in) :: self
      !> The deck
      character(*), intent(in) :: path
      character(:), allocatable :: line
      line = ''
      if (.not. allocated(self%note)) return
      if (self%note /= '') line = path//': '//self%note//newline
   end function note_line

end module limber_scene_interruption
