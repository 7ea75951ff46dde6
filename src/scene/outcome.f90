!> Outcome of a run beside its history. Floor: scene.
module limber_scene_outcome
   use limber_base_kinds, only: wp, long
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: newline
   use limber_integrator_bound_steps, only: bound_steps_type
   use limber_monitor_indicators, only: indicators_type
   use limber_scene_met_events, only: met_events_type
   use limber_output_internal_forces, only: section_forces_type
   implicit none
   private
   public :: outcome_type, warn, all_warnings, energy_scale, passing_scale

   !> Part of the scale of the energy by which its balance may be off
   real(wp), parameter, public :: allowed_imbalance = 1.0e-2_wp

   !> What a run leaves behind besides its history
   type :: outcome_type
      !> Time reached, and samples taken
      real(wp) :: reached = 0.0_wp
      integer(long) :: samples = 0
      !> Wall and CPU seconds of the time loop; of all parts of a run that was interrupted
      real(wp) :: wall = 0.0_wp, cpu = 0.0_wp
      !> Largest constraint residuals at a sample: position [length or 1], velocity [the same per time]
      real(wp) :: position_residual = 0.0_wp, velocity_residual = 0.0_wp
      !> Of each joint -1 behind a warning of what it takes for granted; of wheels, the distance of their centres at the first
      !> sample (joints)
      real(wp), allocatable :: centres(:)
      !> Of each constraint the largest velocity residual at a sample, its time, and the largest speed that a side of it makes, or
      !> its law [length/time or 1/time] (constraints); not allocated without any
      real(wp), allocatable :: slip(:), slip_time(:), slip_speed(:)
      !> Whether a sample could not be brought onto the constraints
      logical :: astray = .false.
      !> Whether the energy of a law has been told to be not known
      logical :: unsure = .false.
      !> Whether a channel had no value at a sample (channels); not allocated if all had one
      logical, allocatable :: undefined(:)
      !> Mechanical energy at the start and the end, and work put in
      real(wp) :: first_energy = 0.0_wp, last_energy = 0.0_wp, work = 0.0_wp
      !> Largest |energy - first energy - work| at the end of a step with samples, and the largest energy that it compares with
      real(wp) :: imbalance = 0.0_wp, largest_energy = 0.0_wp
      !> Integral over the time of the larger of the kinetic energy and the change of the potential one, that time, and the largest
      !> kinetic energy; zero in scenes with drivers. The potential energy at the start
      real(wp) :: first_potential = 0.0_wp, moved_time = 0.0_wp, duration = 0.0_wp, fastest = 0.0_wp
      !> Net work of each driver, load and body since the balance was off, eq. (7.1), the work put in before, the time up to which
      !> it is summed up, and the energy that counts as none: round-off, and a motion of almost nothing
      real(wp), allocatable :: net_work(:)
      !> Whether a channel has the work put in
      logical :: shows_work = .false.
      real(wp) :: work_before = 0.0_wp, summed = 0.0_wp, no_energy = 0.0_wp
      !> Time by which the motion is ahead for the energy that it has too much, eq. (7.3)
      real(wp) :: ahead = 0.0_wp
      !> Angle by which each body has turned, from its spin at the samples (bodies) [rad]
      real(wp), allocatable :: turned(:)
      !> Steps that the tolerance has not chosen, for companion runs
      type(bound_steps_type) :: bound
      !> Events met, and how one has ended the motion: event_stop or event_end_step; 0: none has
      type(met_events_type) :: events
      integer :: ended = 0
      !> What the user should know, one line after another; not allocated if there is nothing
      character(:), allocatable :: warnings
      !> A warning of vibrations that the integrator does not follow, which what finer runs have verified does not need
      character(:), allocatable :: unfollowed
      !> Envelopes of internal forces (bodies)
      type(section_forces_type), allocatable :: efforts(:)
      !> How far the flexible bodies are within the ranges of their models; allocated by analyses that look at it
      class(indicators_type), allocatable :: indicators
   contains
      procedure :: exchange => exchange_outcome
   end type outcome_type

contains

   !> Saves or restores what a run has found so far.
   subroutine exchange_outcome(self, snapshot)
      class(outcome_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%exchange('samples', self%samples)
      call snapshot%exchange('wall', self%wall)
      call snapshot%exchange('cpu', self%cpu)
      call snapshot%exchange('position_residual', self%position_residual)
      call snapshot%exchange('velocity_residual', self%velocity_residual)
      call snapshot%keep('centres', self%centres)
      call snapshot%keep('slip', self%slip)
      call snapshot%keep('slip_time', self%slip_time)
      call snapshot%keep('slip_speed', self%slip_speed)
      call snapshot%exchange('astray', self%astray)
      call snapshot%exchange('unsure', self%unsure)
      call snapshot%keep('undefined', self%undefined)
      call snapshot%exchange('first_energy', self%first_energy)
      call snapshot%exchange('last_energy', self%last_energy)
      call snapshot%exchange('work', self%work)
      call snapshot%exchange('imbalance', self%imbalance)
      call snapshot%exchange('largest_energy', self%largest_energy)
      call snapshot%exchange('first_potential', self%first_potential)
      call snapshot%exchange('moved_time', self%moved_time)
      call snapshot%exchange('duration', self%duration)
      call snapshot%exchange('fastest', self%fastest)
      call snapshot%keep('net_work', self%net_work)
      call snapshot%exchange('work_before', self%work_before)
      call snapshot%exchange('summed', self%summed)
      call snapshot%exchange('ahead', self%ahead)
      call snapshot%keep('turned', self%turned)
      call snapshot%exchange('no_energy', self%no_energy)
      call snapshot%keep('warnings', self%warnings)
      call self%events%exchange(snapshot)
      call snapshot%exchange('ended', self%ended)
      call self%bound%exchange(snapshot)
      if (allocated(self%indicators)) call self%indicators%exchange(snapshot)
      ! Not saved: reached, shows_work, unfollowed, efforts
   end subroutine exchange_outcome

   !> What an imbalance of energy is relative to: the largest energy, what drivers, loads and damping have exchanged, eq. (7.1), or
   !> what counts as none.
   pure real(wp) function energy_scale(outcome) result(scale)
      type(outcome_type), intent(in) :: outcome
      scale = max(outcome%largest_energy, outcome%no_energy, exchanged(outcome, outcome%shows_work))
   end function energy_scale

   !> The same of a motion that is fast for a short time only, as near the pericentre of an orbit, and is not braked behind that:
   !> what is small beside its largest energy need not be so beside the energy it has in the mean. Without such a passage it is
   !> infinite.
   pure real(wp) function passing_scale(outcome) result(scale)
      type(outcome_type), intent(in) :: outcome
      !> Largest kinetic energy beside the mean from which on it is one of a short passage
      real(wp), parameter :: short = 5.0_wp
      scale = huge(scale)
      if (.not. (outcome%moved_time > 0.0_wp .and. outcome%fastest*outcome%duration > short*outcome%moved_time)) return
      scale = max(outcome%moved_time/outcome%duration, outcome%no_energy, exchanged(outcome, .true.))
   end function passing_scale

   !> What drivers, loads and damping have exchanged, eq. (7.1).
   pure real(wp) function exchanged(outcome, by_work)
      type(outcome_type), intent(in) :: outcome
      !> Whether what samples miss of powers that change faster is taken off
      logical, intent(in) :: by_work
      real(wp) :: missed
      exchanged = 0.0_wp
      if (.not. allocated(outcome%net_work)) return
      missed = 0.0_wp
      if (by_work) missed = abs(sum(outcome%net_work) - (outcome%work - outcome%work_before))
      exchanged = 0.5_wp*sum(abs(outcome%net_work)) - missed
   end function exchanged

   !> All warnings of a run, those of vibrations that are not followed among them.
   pure function all_warnings(outcome) result(text)
      type(outcome_type), intent(in) :: outcome
      character(:), allocatable :: text
      text = ''
      if (allocated(outcome%warnings)) text = outcome%warnings
      if (allocated(outcome%unfollowed)) text = text//outcome%unfollowed
   end function all_warnings

   !> Adds a line to the warnings of a run.
   pure subroutine warn(outcome, text)
      type(outcome_type), intent(inout) :: outcome
      character(*), intent(in) :: text
      if (.not. allocated(outcome%warnings)) outcome%warnings = ''
      outcome%warnings = outcome%warnings//'warning: '//text//newline
   end subroutine warn

end module limber_scene_outcome
