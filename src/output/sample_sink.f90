!> Target of samples: a results file or memory. Floor: output.
module limber_output_sample_sink
   use limber_base_error, only: error_type, raise, status_interrupted
   use limber_base_kinds, only: wp, long
   use limber_base_signals, only: signal_came, signal_name
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text
   implicit none
   private
   public :: sink_type, memory_type

   !> What takes samples
   type, abstract :: sink_type
      !> CPU time after which the run is given up at its next step or sample, and CPU clock at its start [s]
      real(wp) :: limit = huge(1.0_wp), started = 0.0_wp
      !> Evaluations after which it is given up at its next step: the same on every machine
      integer(long) :: most_evaluations = huge(1_long)
      !> Whether the run ends at its next step, increment or sample when a signal asks for that: one that could not go on from there
      logical :: heeds_signals = .false.
      !> What channels were over the samples, where that is asked for: integrals over the time by the trapezoidal rule, of the
      !> channel and its square, and that time; sums of both where no time passes
      integer :: taken = 0
      real(wp), allocatable :: first(:), last(:), smallest(:), largest(:)
      real(wp), allocatable, private :: integral(:), square_integral(:), total(:), squares(:)
      real(wp), private :: at = 0.0_wp, span = 0.0_wp
   contains
      procedure(append_interface), deferred :: append
      procedure :: secure => secure_nothing, note_checkpoint => note_nothing
      procedure :: take, watch_limit, check_limit, summarise, mean, mean_square
      procedure :: exchange => exchange_sink
   end type sink_type

   abstract interface
      !> Stores a sample.
      subroutine append_interface(self, t, values, error)
         import :: sink_type, error_type, wp
         class(sink_type), intent(inout) :: self
         !> Time
         real(wp), intent(in) :: t
         !> All channels one after another in the order of definition; behind them the coordinates, if they are sampled
         real(wp), intent(in) :: values(:)
         !> Allocated if no more samples can be taken: the run is to end
         type(error_type), allocatable, intent(out) :: error
      end subroutine append_interface
   end interface

   !> Samples in memory
   type, extends(sink_type) :: memory_type
      !> Samples taken
      integer :: samples = 0
      !> Times (samples), and the first `width` numbers (width, samples); longer than that if a run ends early
      real(wp), allocatable :: times(:), values(:, :)
   contains
      procedure :: start => start_memory, append => append_memory
      procedure :: exchange => exchange_memory
   end type memory_type

contains

   !> Brings the samples so far where nothing that happens to the run can harm them.
   subroutine secure_nothing(self, trouble, error)
      class(sink_type), intent(inout) :: self
      !> Why that cannot be done now, though the run may go on; empty if it was
      character(:), allocatable, intent(out) :: trouble
      !> Allocated if no more samples can be taken: the run is to end
      type(error_type), allocatable, intent(out) :: error
      trouble = ''
      if (self%taken < 0) call raise(error, 'no samples')
   end subroutine secure_nothing

   !> Takes note that there is a checkpoint behind its samples.
   subroutine note_nothing(self, error)
      class(sink_type), intent(inout) :: self
      !> Allocated if no more samples can be taken: the run is to end
      type(error_type), allocatable, intent(out) :: error
      if (self%taken < 0) call raise(error, 'no samples')
   end subroutine note_nothing

   !> Gives up the run that begins now after some CPU time.
   subroutine watch_limit(self, limit)
      class(sink_type), intent(inout) :: self
      !> [s]
      real(wp), intent(in) :: limit
      self%limit = limit
      call cpu_time(self%started)
   end subroutine watch_limit

   !> Gives up the run if its time or its evaluations are over, or a signal asks for that: asked at each step or increment.
   subroutine check_limit(self, t, error, evaluations)
      class(sink_type), intent(in) :: self
      !> Time reached
      real(wp), intent(in) :: t
      !> The time is over, or a signal came
      type(error_type), allocatable, intent(out) :: error
      !> So far
      integer(long), intent(in), optional :: evaluations
      real(wp) :: now
      if (self%heeds_signals) then
         if (signal_came()) then
            call raise(error, 'interrupted by '//signal_name()//' at t = '//as_text(t, 8), status_interrupted)
            return
         end if
      end if
      if (present(evaluations)) then
         if (evaluations > self%most_evaluations) call raise(error, 'given up after '//as_text(evaluations)// &
            & ' evaluations at t = '//as_text(t, 4))
      end if
      if (.not. self%limit < huge(now)) return
      call cpu_time(now)
      if (now - self%started > self%limit) call raise(error, 'given up after '//as_text(self%limit, 3)//' s at t = '// &
         & as_text(t, 4))
   end subroutine check_limit

   !> From now on keeps the extremes and sums of the first numbers of each sample.
   subroutine summarise(self, width)
      class(sink_type), intent(inout) :: self
      !> How many
      integer, intent(in) :: width
      allocate (self%first(width), self%last(width), self%smallest(width), self%largest(width), self%integral(width), &
         & self%square_integral(width), self%total(width), self%squares(width), source=0.0_wp)
   end subroutine summarise

   !> Mean of a channel over the time, from sample to sample along straight lines: the instant at which one analysis ends and the
   !> next begins counts once. Over the samples where no time passes.
   pure real(wp) function mean(self, channel)
      class(sink_type), intent(in) :: self
      integer, intent(in) :: channel
      if (self%span > 0.0_wp) then
         mean = self%integral(channel)/self%span
      else
         mean = self%total(channel)/max(1, self%taken)
      end if
   end function mean

   !> The same of its square.
   pure real(wp) function mean_square(self, channel)
      class(sink_type), intent(in) :: self
      integer, intent(in) :: channel
      if (self%span > 0.0_wp) then
         mean_square = self%square_integral(channel)/self%span
      else
         mean_square = self%squares(channel)/max(1, self%taken)
      end if
   end function mean_square

   !> Takes a sample, unless the time is over.
   subroutine take(self, t, values, error)
      class(sink_type), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), intent(in) :: values(:)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: step
      call self%check_limit(t, error)
      if (allocated(error)) return
      call self%append(t, values, error)
      if (allocated(error) .or. .not. allocated(self%first)) return
      associate (now => values(:size(self%first)))
         if (self%taken == 0) then
            self%first = now
            self%smallest = now
            self%largest = now
            self%last = now
            self%at = t
         end if
         step = abs(t - self%at)
         self%integral = self%integral + 0.5_wp*step*(self%last + now)
         self%square_integral = self%square_integral + 0.5_wp*step*(self%last**2 + now**2)
         self%span = self%span + step
         self%at = t
         self%taken = self%taken + 1
         self%last = now
         self%smallest = min(self%smallest, now)
         self%largest = max(self%largest, now)
         self%total = self%total + now
         self%squares = self%squares + now**2
      end associate
   end subroutine take

   !> Empties the memory for a run that begins now.
   subroutine start_memory(self, width, samples, limit)
      class(memory_type), intent(inout) :: self
      !> Numbers of a sample that are kept, and greatest number of samples
      integer, intent(in) :: width, samples
      !> CPU time after which the run is given up [s]
      real(wp), intent(in) :: limit
      if (allocated(self%times)) deallocate (self%times, self%values)
      allocate (self%times(samples), self%values(width, samples))
      self%samples = 0
      call self%watch_limit(limit)
   end subroutine start_memory

   !> Stores a sample.
   subroutine append_memory(self, t, values, error)
      class(memory_type), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), intent(in) :: values(:)
      type(error_type), allocatable, intent(out) :: error
      self%samples = self%samples + 1
      if (self%samples > size(self%times)) then
         call raise(error, 'more samples than the '//as_text(size(self%times))//' that memory was made for')
         return
      end if
      self%times(self%samples) = t
      self%values(:, self%samples) = values(:size(self%values, 1))
   end subroutine append_memory

   !> Saves or restores what it knows of the samples so far.
   subroutine exchange_sink(self, snapshot)
      class(sink_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%exchange('taken', self%taken)
      call snapshot%keep('first', self%first)
      call snapshot%keep('last', self%last)
      call snapshot%keep('smallest', self%smallest)
      call snapshot%keep('largest', self%largest)
      call snapshot%exchange('sample_time', self%at)
      call snapshot%exchange('span', self%span)
      call snapshot%keep('integral', self%integral)
      call snapshot%keep('square_integral', self%square_integral)
      call snapshot%keep('total', self%total)
      call snapshot%keep('squares', self%squares)
      ! Not saved: limit, started, most_evaluations, heeds_signals
   end subroutine exchange_sink

   !> The same with the samples themselves.
   subroutine exchange_memory(self, snapshot)
      class(memory_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call exchange_sink(self, snapshot)
      call snapshot%exchange('samples', self%samples)
      call snapshot%keep('times', self%times)
      call snapshot%keep('values', self%values)
   end subroutine exchange_memory

end module limber_output_sample_sink
