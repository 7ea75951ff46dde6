!> What lets a run be interrupted and go on later as if it had not been: checkpoints by wall time, and one more when a signal asks it
!> to end. Floor: analysis.
module limber_analysis_guard
   use limber_base_error, only: error_type, raise, status_deck, status_interrupted
   use limber_base_files, only: remove_file
   use limber_base_kinds, only: wp, long
   use limber_base_process, only: own_number
   use limber_base_signals, only: catch_signals, release_signals, signal_came, signal_name
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text
   use limber_base_version, only: version, commit, compiler, compiler_options
   use limber_output_checkpoint, only: checkpoint_type, write_checkpoint, read_checkpoint, checkpoint_name
   use limber_output_history_reader, only: history_reader_type
   use limber_output_sink, only: sink_type
   implicit none
   private
   public :: guard_type, request_type

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
   type :: guard_type
      type(request_type) :: request
      !> Name of the checkpoint; not allocated while nothing is guarded
      character(:), allocatable :: path
      !> What it says of the run
      type(checkpoint_type) :: checkpoint
      type(snapshot_type) :: snapshot
      !> Whether the run begins with the snapshot
      logical :: restarting = .false.
      !> Clock at the last checkpoint [ticks]; steps in this process
      integer(long), private :: last = 0, steps = 0
      !> Why no checkpoint could be written; empty if all is well
      character(:), allocatable :: trouble
   contains
      procedure :: find, start, asks, reason, write, finish
   end type guard_type

contains

   !> Looks for what an earlier run has left, if one is to go on.
   subroutine find(self, results, deck, request, done, error)
      class(guard_type), intent(inout) :: self
      !> Name of the results, and the deck that is to be run
      character(*), intent(in) :: results, deck
      type(request_type), intent(in) :: request
      !> True if the run has reached its end already
      logical, intent(out) :: done
      !> What was found, if it cannot go on from there; nothing has been changed
      type(error_type), allocatable, intent(out) :: error
      type(history_reader_type) :: reader
      type(checkpoint_type) :: found
      character(:), allocatable :: run
      logical :: has_results, has_checkpoint
      done = .false.
      self%request = request
      self%path = checkpoint_name(results)
      self%checkpoint%program = version//' '//commit//' '//compiler//' '//compiler_options
      self%checkpoint%deck = deck
      self%checkpoint%run = new_number()
      self%trouble = ''
      if (.not. request%restart) return
      inquire (file=results, exist=has_results)
      inquire (file=self%path, exist=has_checkpoint)
      if (.not. (has_results .or. has_checkpoint)) return
      if (.not. has_results) then
         call raise(error, self%path//' is there, but '//results//' that it goes on with is not; without --restart the run '// &
            & 'begins anew', status_deck)
         return
      end if
      call reader%open(results, error)
      if (allocated(error)) then
         error%message = results//' cannot be continued; it was left as it is: '//error%message
         return
      end if
      done = reader%complete
      if (done) then
         call reader%close()
         return
      end if
      run = ''
      if (.not. has_checkpoint) then
         call raise(error, results//' has '//as_text(reader%samples)//' samples of a run that did not finish ('//reader%status// &
            & '), but there is no '//self%path//' to continue it from; --force without --restart begins anew', status_deck)
      else
         call read_checkpoint(self%path, found, self%snapshot, error)
      end if
      if (.not. allocated(error)) call reader%read_label('/run', 'number', run, error)
      if (.not. allocated(error)) call compare(self%path, results, run, reader%samples, found, self%checkpoint, error)
      call reader%close()
      if (allocated(error)) return
      self%checkpoint = found
      self%restarting = .true.
   end subroutine find

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
      class(guard_type), intent(inout) :: self
      call system_clock(self%last)
      self%steps = 0
      call catch_signals()
   end subroutine start

   !> Whether a checkpoint is to be written behind this step, and whether the run is to end there.
   subroutine asks(self, save, stop)
      class(guard_type), intent(inout) :: self
      logical, intent(out) :: save, stop
      integer(long) :: clock, rate
      self%steps = self%steps + 1
      stop = signal_came() .or. self%steps >= self%request%stop_after
      save = stop
      if (save .or. .not. self%request%interval > 0.0_wp) return
      call system_clock(clock, rate)
      save = real(clock - self%last, wp) > self%request%interval*real(rate, wp)
      if (save) self%last = clock
   end subroutine asks

   !> What asks the run to end.
   function reason(self)
      class(guard_type), intent(in) :: self
      character(:), allocatable :: reason
      reason = signal_name()
      if (reason == '') reason = 'request after '//as_text(self%steps)//' steps'
   end function reason

   !> Writes the snapshot that has been saved; behind it the samples must be safe.
   subroutine write(self, samples, t, error)
      class(guard_type), intent(inout) :: self
      integer, intent(in) :: samples
      real(wp), intent(in) :: t
      !> Allocated if it could not be written; the run may go on
      type(error_type), allocatable, intent(out) :: error
      self%checkpoint%samples = samples
      self%checkpoint%time = t
      call write_checkpoint(self%path, self%checkpoint, self%snapshot, error)
      self%trouble = ''
      if (allocated(error)) self%trouble = error%message
   end subroutine write

   !> Ends the guard; a run that has reached its end needs no checkpoint.
   subroutine finish(self, done)
      class(guard_type), intent(inout) :: self
      logical, intent(in) :: done
      call release_signals()
      if (done) call remove_file(self%path)
   end subroutine finish

end module limber_analysis_guard
