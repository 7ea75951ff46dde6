!> *ACCURACY, ESTIMATE: the error of a result. How far the channels of a run are from those of a perfect integration of the same
!> equations. Two more runs tell, one with a smaller tolerance, whose difference is the error but for its own, and one with a
!> larger, which says how errors shrink. Equations: doc/theory, part 7. Floor: analysis; scene and samples of a run -> estimate.
module limber_analysis_error_estimate
   use limber_base_kinds, only: wp, long
   use limber_base_error, only: error_type
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: first_line
   use limber_analysis_chosen_integrator, only: new_integrator
   use limber_analysis_dynamic_analysis, only: run_dynamics
   use limber_scene_outcome, only: outcome_type
   use limber_scene_channel_errors, only: envelope, shrinkage, widening, unknown_ratio, no_shrinkage
   use limber_scene_scene, only: scene_type
   use limber_deck_operations, only: op_slot
   use limber_integrator_bound_steps, only: bound_steps_type
   use limber_integrator_integrator, only: integrator_type, constraint_tolerance
   use limber_model_quantities, only: quantities, quantity_work, partners_of
   use limber_model_model, only: channel_type, dynamics_type, model_type, quantity_type
   use limber_output_history, only: history_type
   use limber_output_progress, only: progress_type
   use limber_output_sample_sink, only: memory_type
   implicit none
   private
   public :: kept_type, estimate_type, make_estimate, varied, round_off, add_quantities

   !> Neighbours on each side that the envelope takes in
   integer, parameter :: reach = 2
   !> Ratio of the tolerances of two runs
   real(wp), parameter :: ladder = 10.0_wp
   !> Tolerances of a deck
   real(wp), parameter :: smallest_tolerance = 0.99e-13_wp, largest_tolerance = 0.1_wp
   !> Part of its terms below which an error that does not shrink is round-off; part of the tolerance, relative to the channel, that
   !> it may be without a warning; part of others of its unit that counts as the scale of a quantity's round-off
   real(wp), parameter :: no_more = 1.0e-9_wp, of_tolerance = 0.1_wp, unrelated = 1.0e-3_wp

   !> A results file whose samples stay in memory too
   type, extends(history_type) :: kept_type
      !> Whether they do
      logical :: keeps = .false.
      type(memory_type) :: memory
   contains
      procedure :: append => append_both
      procedure :: exchange => exchange_both
   end type kept_type

   !> Estimated errors of a run
   type :: estimate_type
      !> Why there are none; empty if there are
      character(:), allocatable :: reason
      !> Of each channel at each sample (channels, samples) [unit of the channel]
      real(wp), allocatable :: values(:, :)
      !> What they are judged relative to, where a target is asked for (channels): a channel that is the small difference of large
      !> terms has the scale of these
      real(wp), allocatable :: scale(:)
      !> Eq. (7.4) for each channel (channels), or `unknown_ratio`
      real(wp), allocatable :: ratio(:)
      !> Channels whose errors do not shrink with the tolerance although they are no round-off; those of them whose errors matter
      !> beside the tolerance; and channels that are zero within round-off (channels)
      logical, allocatable :: stuck(:), alarming(:), zero(:)
      !> Tolerance of the run itself, of the run that it is compared with, and of the one that gives the ratios; zero: there
      !> was none
      real(wp) :: tolerance = 0.0_wp, companion = 0.0_wp, check = 0.0_wp
      !> True if the runs that it comes of differ in the model too
      logical :: of_model = .false.
      !> Models whose error is not in them although it is in those of other models; empty: there are none
      character(:), allocatable :: without
      !> CPU seconds of the time loops of these runs, and that in units of the run itself
      real(wp) :: cpu = 0.0_wp, factor = 0.0_wp
   end type estimate_type

contains

   !> Takes a sample for the file and for the memory.
   subroutine append_both(self, t, values, error)
      class(kept_type), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), intent(in) :: values(:)
      type(error_type), allocatable, intent(out) :: error
      call self%history_type%append(t, values, error)
      if (self%keeps .and. .not. allocated(error)) call self%memory%append(t, values, error)
   end subroutine append_both

   !> Saves or restores what it knows of the samples, and those in memory.
   subroutine exchange_both(self, snapshot)
      class(kept_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call self%history_type%exchange(snapshot)
      if (self%keeps) call self%memory%exchange(snapshot)
   end subroutine exchange_both

   !> Estimates the errors of a run that has finished.
   subroutine make_estimate(scene, samples, taken, steps, evaluations, cpu, quiet, estimate)
      !> As it was run; the same again on return
      type(scene_type), intent(inout) :: scene
      !> Its samples
      type(memory_type), intent(in) :: samples
      !> Its steps that the tolerance has not chosen
      type(bound_steps_type), intent(in) :: taken
      !> Its steps and evaluations, and CPU seconds of its time loop
      integer(long), intent(in) :: steps, evaluations
      real(wp), intent(in) :: cpu
      !> Whether the progress is not shown
      logical, intent(in) :: quiet
      type(estimate_type), intent(out) :: estimate
      type(memory_type) :: companion, check
      character(:), allocatable :: no_check
      type(bound_steps_type) :: pace
      logical :: is_finer
      estimate%without = ''
      estimate%tolerance = scene%system%model%dynamics%tolerance
      is_finer = estimate%tolerance/ladder >= smallest_tolerance
      estimate%companion = merge(1/ladder, ladder, is_finer)*estimate%tolerance
      pace = taken
      pace%factor = merge(1/ladder, ladder, is_finer)
      call run_again(scene, pace, 1000000 + 50*evaluations, quiet, companion, estimate%cpu, estimate%reason)
      if (estimate%reason == '' .and. is_finer .and. estimate%tolerance*ladder <= largest_tolerance .and. &
         & .not. taken%prevail()) then
         pace%factor = ladder
         call run_again(scene, pace, 100000 + 4*evaluations, quiet, check, estimate%cpu, no_check)
         if (no_check == '') estimate%check = ladder*estimate%tolerance
      end if
      estimate%factor = estimate%cpu/max(cpu, tiny(cpu))
      if (estimate%reason == '') call compare_runs(scene%system%model, samples, companion, check, steps, estimate)
   end subroutine make_estimate

   !> Runs a scene once more at another tolerance. Besides the channels the run samples all quantities that are in them.
   subroutine run_again(scene, pace, limit, quiet, samples, cpu, reason)
      type(scene_type), intent(inout) :: scene
      !> Steps of the run, and the tolerance in units of its own
      type(bound_steps_type), intent(in) :: pace
      !> Evaluations after which the run is given up: the same on every machine
      integer(long), intent(in) :: limit
      logical, intent(in) :: quiet
      type(memory_type), intent(inout) :: samples
      !> Seconds so far; those of this run are added
      real(wp), intent(inout) :: cpu
      !> Why the run failed; empty if it did not
      character(:), allocatable, intent(out) :: reason
      class(integrator_type), allocatable :: integrator
      type(channel_type), allocatable :: channels(:)
      type(quantity_type), allocatable :: beside(:)
      type(dynamics_type) :: dynamics
      type(outcome_type) :: outcome
      type(progress_type) :: progress
      type(error_type), allocatable :: error
      reason = ''
      associate (model => scene%system%model)
         dynamics = model%dynamics
         call move_alloc(model%channels, channels)
         model%dynamics = varied(dynamics, pace%factor)
         call find_partners(channels, beside)
         call add_quantities(channels, model%channels, beside)
         call new_integrator(model%dynamics, integrator)
         call samples%start(size(model%channels), dynamics%outputs + 1, huge(1.0_wp))
         samples%most_evaluations = limit
         samples%heeds_signals = .true.
         if (allocated(scene%followed)) scene%work%kinematics%angles(:) = scene%followed
         if (.not. quiet) call progress%start(dynamics%start, dynamics%end, 'estimate of the errors')
         call run_dynamics(scene, integrator, samples, progress, outcome, error, pace=pace)
         if (.not. quiet) call progress%finish()
         model%dynamics = dynamics
         deallocate (model%channels)
         call move_alloc(channels, model%channels)
      end associate
      cpu = cpu + outcome%cpu
      if (allocated(error)) reason = first_line(error%message)
   end subroutine run_again

   !> The same analysis at another tolerance. Steps that the deck gives are changed as an integrator of order two would change
   !> its own, so that a deck that holds the step, not the tolerance, has an error too.
   pure function varied(dynamics, factor) result(other)
      type(dynamics_type), intent(in) :: dynamics
      real(wp), intent(in) :: factor
      type(dynamics_type) :: other
      other = dynamics
      other%tolerance = factor*dynamics%tolerance
      other%initial_step = factor**(1.0_wp/3)*dynamics%initial_step
      other%maximum_step = factor**(1.0_wp/3)*dynamics%maximum_step
      other%fixed_step = factor**(1.0_wp/3)*dynamics%fixed_step
      other%maximum_steps = 10*min(dynamics%maximum_steps, 200000000)
   end function varied

   !> Channels, and behind them each quantity in each of them, and others.
   subroutine add_quantities(channels, all_channels, others)
      type(channel_type), intent(in) :: channels(:)
      type(channel_type), allocatable, intent(out) :: all_channels(:)
      type(quantity_type), intent(in), optional :: others(:)
      integer :: i, j, k, count
      k = size(channels)
      count = k + sum([(size(channels(i)%quantities), i=1, k)])
      if (present(others)) count = count + size(others)
      allocate (all_channels(count))
      do i = 1, size(channels)
         all_channels(i) = channels(i)
         do j = 1, size(channels(i)%quantities)
            call add(channels(i)%quantities(j))
         end do
      end do
      if (.not. present(others)) return
      do j = 1, size(others)
         call add(others(j))
      end do

   contains

      subroutine add(quantity)
         type(quantity_type), intent(in) :: quantity
         k = k + 1
         all_channels(k)%quantities = [quantity]
         all_channels(k)%expression%codes = [op_slot]
         all_channels(k)%expression%operands = [1]
      end subroutine add

   end subroutine add_quantities

   !> What the quantities of channels are computed together with, and share the round-off of: the other component of a force, ...
   subroutine find_partners(channels, partners)
      type(channel_type), intent(in) :: channels(:)
      type(quantity_type), allocatable, intent(out) :: partners(:)
      type(quantity_type) :: partner
      integer, allocatable :: kinds(:)
      integer :: i, j, k
      allocate (partners(0))
      do i = 1, size(channels)
         do j = 1, size(channels(i)%quantities)
            kinds = partners_of(channels(i)%quantities(j)%kind)
            do k = 1, size(kinds)
               partner = channels(i)%quantities(j)
               partner%kind = kinds(k)
               partner%dimension = quantities(kinds(k))%dimension
               if (.not. any(is_same(partners, partner))) partners = [partners, partner]
            end do
         end do
      end do
   end subroutine find_partners

   !> Whether two quantities are the same one.
   elemental logical function is_same(a, b)
      type(quantity_type), intent(in) :: a, b
      is_same = a%kind == b%kind .and. a%of == b%of .and. (a%of_load .eqv. b%of_load) .and. (a%of_coupler .eqv. b%of_coupler)
   end function is_same

   !> Errors from the samples of the runs: eqs. (7.4)-(7.7).
   subroutine compare_runs(model, samples, companion, check, steps, estimate)
      type(model_type), intent(in) :: model
      !> Of the run, of the one to compare with, and, if there is one, of the check
      type(memory_type), intent(in) :: samples, companion, check
      integer(long), intent(in) :: steps
      type(estimate_type), intent(inout) :: estimate
      type(channel_type), allocatable :: sampled(:)
      type(quantity_type), allocatable :: beside(:)
      real(wp), allocatable :: difference(:), floors(:), sizes(:), largest(:)
      real(wp) :: factor
      integer :: i, j, first, n
      n = samples%samples
      first = size(model%channels)
      call find_partners(model%channels, beside)
      call add_quantities(model%channels, sampled, beside)
      allocate (largest, source=maxval(abs(companion%values(:, :n)), 2))
      allocate (estimate%values(first, n), estimate%ratio(first))
      allocate (estimate%stuck(first), estimate%alarming(first), estimate%zero(first))
      allocate (difference(n), floors(n), sizes(n))
      estimate%ratio = unknown_ratio
      do i = 1, size(model%channels)
         difference = samples%values(i, :n) - companion%values(i, :n)
         if (estimate%check > 0.0_wp) &
            & estimate%ratio(i) = shrinkage(difference, check%values(i, :n) - samples%values(i, :n))
         associate (asked => model%channels(i)%quantities)
            call round_off(model%channels(i), companion%values(first + 1:first + size(asked), :n), [(max(natural_scale(asked(j), &
               & model), scale_beside(asked(j), sampled(size(model%channels) + 1:), largest(size(model%channels) + 1:), &
               & model%length)), j=1, size(asked))], steps, floors, sizes)
            first = first + size(asked)
         end associate
         factor = widening(estimate%ratio(i))
         ! A coarser companion has the larger error of the two
         if (estimate%companion > estimate%tolerance) factor = 1.0_wp
         estimate%values(i, :) = max(factor*envelope(difference, reach), floors)
         estimate%stuck(i) = estimate%ratio(i) > no_shrinkage .and. maxval(estimate%values(i, :)) > no_more*maxval(sizes)
         estimate%alarming(i) = estimate%stuck(i) .and. &
            & maxval(estimate%values(i, :)) > of_tolerance*estimate%tolerance*largest(i)
         estimate%zero(i) = maxval(floors) > 0.0_wp .and. &
            & max(largest(i), maxval(abs(samples%values(i, :n)))) <= maxval(floors)
      end do
   end subroutine compare_runs

   !> What round-off alone can do to a channel: eq. (7.7).
   subroutine round_off(channel, slots_of, scales, steps, floors, sizes)
      type(channel_type), intent(in) :: channel
      !> Its quantities (quantities, samples), and what `natural_scale` says of them (quantities)
      real(wp), intent(in) :: slots_of(:, :), scales(:)
      !> Of the run
      integer(long), intent(in) :: steps
      !> Round-off (samples), and the largest magnitude of the channel and its terms [unit of the channel]
      real(wp), intent(out) :: floors(:), sizes(:)
      real(wp), parameter :: few = 4.0_wp
      real(wp) :: slots(size(scales)), value, slope, roundings, now, largest
      integer :: j, k
      largest = 0.0_wp
      do k = 1, size(floors)
         slots = slots_of(:, k)
         value = channel%expression%evaluate(slots)
         sizes(k) = abs(value)
         now = few*epsilon(1.0_wp)*abs(value)
         do j = 1, size(slots)
            slope = abs(derivative(channel, slots, j, max(abs(slots(j)), scales(j))))
            ! The work is summed up over all steps, and nothing holds it in place
            roundings = few
            if (channel%quantities(j)%kind == quantity_work) roundings = few + real(steps, wp)*(k - 1)/max(1, size(floors) - 1)
            now = now + slope*(roundings*epsilon(1.0_wp)*abs(slots(j)) + constraint_tolerance*scales(j))
            sizes(k) = max(sizes(k), slope*max(abs(slots(j)), scales(j)))
         end do
         largest = max(largest, now)
         floors(k) = largest
      end do
   end subroutine round_off

   !> Derivative of a channel with respect to one of its quantities, from values at the same side of zero.
   pure real(wp) function derivative(channel, slots, which, scale)
      type(channel_type), intent(in) :: channel
      real(wp), intent(in) :: slots(:), scale
      integer, intent(in) :: which
      real(wp), parameter :: part = 1.0e-6_wp
      real(wp) :: moved(size(slots)), step
      derivative = 0.0_wp
      step = part*scale
      if (.not. step > 0.0_wp) return
      if (abs(slots(which)) > step) step = -step
      moved = slots
      moved(which) = moved(which) + sign(1.0_wp, slots(which))*step
      derivative = (channel%expression%evaluate(moved) - channel%expression%evaluate(slots))/(moved(which) - slots(which))
   end function derivative

   !> What the round-off of a quantity with a mass is relative to: the largest of what it is computed together with, and a part of
   !> what has its dimension anywhere; zero for others.
   pure real(wp) function scale_beside(quantity, sampled, largest, length) result(scale)
      type(quantity_type), intent(in) :: quantity
      !> Quantities that are sampled, a channel each, and their largest magnitudes; length of the scene
      type(channel_type), intent(in) :: sampled(:)
      real(wp), intent(in) :: largest(:), length
      type(quantity_type) :: other
      integer :: i
      scale = 0.0_wp
      if (quantity%kind == 0) return
      if (quantity%dimension(3) == 0) return
      do i = 1, size(sampled)
         other = sampled(i)%quantities(1)
         if (other%kind == 0 .or. any(other%dimension(2:) /= quantity%dimension(2:))) cycle
         if (other%of == quantity%of .and. any(partners_of(quantity%kind) == other%kind) .and. &
            & (other%of_load .eqv. quantity%of_load)) then
            scale = max(scale, largest(i)*length**(quantity%dimension(1) - other%dimension(1)))
         else if (other%dimension(1) == quantity%dimension(1)) then
            scale = max(scale, unrelated*largest(i))
         end if
      end do
   end function scale_beside

   !> What the accuracy of the constraints of a quantity is relative to, from its dimension: the length of the scene, the
   !> duration, one radian; zero if it has a mass.
   pure real(wp) function natural_scale(quantity, model)
      type(quantity_type), intent(in) :: quantity
      type(model_type), intent(in) :: model
      natural_scale = 0.0_wp
      if (quantity%kind == 0) return
      associate (dimension => quantities(quantity%kind)%dimension)
         if (dimension(3) == 0) natural_scale = model%length**dimension(1)*(model%dynamics%end - model%dynamics%start)**dimension(2)
      end associate
   end function natural_scale

end module limber_analysis_error_estimate
