!> *MODES: small vibrations. Frequencies, damping and shapes of small vibrations about the present state, at rest or in steady
!> rotation, preloaded as a static analysis has left it. Floor: analysis. Source: doc/theory, eqs. (6.8), (6.10), (6.13), (6.14),
!> (6.18).
module limber_analysis_modal_analysis
   use limber_base_kinds, only: wp, long
   use limber_base_error, only: error_type
   use limber_base_signals, only: let_signals_end
   use limber_base_text, only: as_text, newline
   use limber_scene_damping_check, only: changed_damping
   use limber_monitor_function_checks, only: function_mode_warnings
   use limber_analysis_kinks, only: kink_warnings
   use limber_analysis_damped_aside, only: compare_damped
   use limber_analysis_mode_aside, only: compare_aside, compare_functions
   use limber_analysis_skew_forces, only: skew_warning
   use limber_monitor_mode_checks, only: mode_warnings
   use limber_scene_outcome, only: outcome_type, warn
   use limber_scene_sampling, only: check_residuals
   use limber_scene_scene, only: scene_type, seconds_since
   use limber_analysis_small_motions, only: linearise_state, lowest_vibrations, terms, undamped_terms
   use limber_model_model, only: ground, analysis_step_type, ground
   use limber_output_channel_values, only: recorder_type, new_recorder, channel_values, sample_width
   use limber_output_history, only: history_type
   use limber_output_sample_sink, only: sink_type
   use limber_output_followed_turns, only: follow_places
   use limber_monitor_run_monitor, only: find_weak
   use limber_multibody_plane_vectors, only: turn, along
   use limber_multibody_equilibrium, only: equilibrium_type, new_equilibrium
   use limber_multibody_kinematics, only: place_frames, move_frames
   use limber_multibody_multiplier_system, only: update_jacobians
   use limber_multibody_system, only: system_type
   use limber_multibody_small_vibrations, only: vibrations_type, kind_of_growth
   implicit none
   private
   public :: run_modes

   !> Modes behind those that are listed, which are looked at: one may be too fast by what a model lacks
   integer, parameter :: beside = 6
   !> A vibration that is at most so much faster without damping than the last of the list may be in it
   real(wp), parameter :: nearby = 1.3_wp
   !> Part of its limit from which on an estimate of what functions of exact beams lack is looked at more closely
   real(wp), parameter :: look_closer = 0.25_wp

contains

   !> Finds the modes and writes them to /modes/<name> of a results file.
   subroutine run_modes(scene, step, history, outcome, report, error, is_secured)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      class(sink_type), intent(inout) :: history
      type(outcome_type), intent(out) :: outcome
      !> A table
      character(:), allocatable, intent(out) :: report
      type(error_type), allocatable, intent(out) :: error
      !> Whether a checkpoint holds what is before it, so that a signal may end the run while LAPACK computes
      logical, intent(in) :: is_secured
      type(equilibrium_type) :: balance
      !> Those that are listed, and some more; and these without damping
      type(vibrations_type) :: vibrations, more, undamped
      type(error_type), allocatable :: interruption
      integer :: listed
      integer(long) :: tick
      real(wp) :: cpu
      logical :: balanced
      character(:), allocatable :: aside, damped
      call system_clock(tick)
      call cpu_time(cpu)
      outcome%cpu = -cpu
      outcome%reached = step%dynamics%start
      report = ''
      call new_equilibrium(scene%system, balance)
      call let_signals_end(is_secured)
      call linearise_state(scene, step, balance, balanced, error)
      if (.not. allocated(error)) call history%check_limit(step%dynamics%start, error)
      if (allocated(error)) return
      if (.not. balanced) outcome%warnings = "warning: the state of *MODES '"//step%name// &
         & "' is not in equilibrium; put *STATICS before it"//newline
      call lowest_vibrations(scene, balance, terms(step, balance), step%modes, beside, more, error)
      if (.not. allocated(error)) call leave_out_damping(scene, step, balance, more, undamped, listed)
      if (.not. allocated(error)) call compare_aside(scene, step, balance, undamped, listed, aside)
      if (.not. allocated(error) .and. step%damped) then
         call compare_damped(scene, step, balance, more, min(step%modes, size(more%frequency)), damped)
         aside = aside//damped
      end if
      if (.not. allocated(error)) aside = aside//skew_warning(scene, step, balance, undamped, beside)
      call let_signals_end(.false.)
      call history%check_limit(step%dynamics%start, interruption)
      if (allocated(interruption)) call move_alloc(interruption, error)
      if (allocated(error)) return
      call take_first(more, step%modes, vibrations)
      if (size(vibrations%frequency) == 0) call warn(outcome, "nothing can vibrate in *MODES '"//step%name// &
         & "': joints and drivers leave the scene no free motion; no modes are written. Remove *MODES, or a joint or driver")
      call sample(scene, step, balance, history, outcome, error)
      if (.not. allocated(error)) call check_frequencies(scene, step, balance, vibrations, undamped, listed, aside, &
         & outcome)
      if (allocated(error)) return
      select type (history)
      class is (history_type)
         call record_modes(scene, step, balance, vibrations, history, error)
      end select
      if (allocated(error)) return
      call check_grip(scene, step, outcome)
      report = table(scene, vibrations, step%damped)
      if (size(vibrations%frequency) < step%modes .and. report /= '') report = report//newline// &
         & '      these are all: nothing else in the scene can vibrate'
      call cpu_time(cpu)
      outcome%cpu = outcome%cpu + cpu
      outcome%wall = seconds_since(tick)
   end subroutine run_modes

   !> Warns at a singular position: there the linear equations hold more motions, or others, than the constraints do.
   subroutine check_grip(scene, step, outcome)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      type(outcome_type), intent(inout) :: outcome
      !> Grip that is none, relative to the inverse of the mean mass
      real(wp), parameter :: none = 1.0e-7_wp
      character(:), allocatable :: names
      real(wp) :: grip
      call find_weak(scene%system, scene%work, step%dynamics%start, scene%q, names, grip)
      if (names /= '' .and. grip < none) call warn(outcome, names//" have lost their grip on the motion in the state of *MODES '" &
         & //step%name//"', where branches of it meet: its frequencies may be wrong or too many; use a state a little aside of it")
   end subroutine check_grip

   !> The vibrations that the models of bodies are judged by: those without damping. Motions beyond critical damping have no
   !> frequency, and another |s| than the stiffness gives them.
   subroutine leave_out_damping(scene, step, balance, vibrations, undamped, listed)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      type(equilibrium_type), intent(inout) :: balance
      !> As the analysis finds them
      type(vibrations_type), intent(in) :: vibrations
      type(vibrations_type), intent(out) :: undamped
      !> The first ones of them that are listed, but those that are only there for their damping; 0: they are not found
      integer, intent(out) :: listed
      type(error_type), allocatable :: error
      listed = min(step%modes, size(vibrations%frequency))
      if (step%damped) then
         call lowest_vibrations(scene, balance, undamped_terms(balance), step%modes, beside, undamped, error)
         if (allocated(error)) listed = 0
         if (listed > 0) listed = min(listed, count(hypot(undamped%frequency, undamped%growth) &
            & <= nearby*hypot(vibrations%frequency(listed), vibrations%growth(listed))))
      else
         undamped = vibrations
      end if
   end subroutine leave_out_damping

   !> The first modes.
   subroutine take_first(more, wanted, vibrations)
      type(vibrations_type), intent(in) :: more
      integer, intent(in) :: wanted
      type(vibrations_type), intent(inout) :: vibrations
      integer :: count
      count = min(wanted, size(more%frequency))
      allocate (vibrations%frequency, source=more%frequency(:count))
      allocate (vibrations%growth, source=more%growth(:count))
      allocate (vibrations%shape, source=more%shape(:, :count))
   end subroutine take_first

   !> The channels at the state.
   subroutine sample(scene, step, balance, history, outcome, error)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      type(equilibrium_type), intent(inout) :: balance
      class(sink_type), intent(inout) :: history
      type(outcome_type), intent(inout) :: outcome
      type(error_type), allocatable, intent(out) :: error
      type(recorder_type) :: recorder
      real(wp), allocatable :: values(:)
      associate (system => scene%system, work => scene%work)
         recorder = new_recorder(system, scene%q)
         if (allocated(scene%angle)) recorder%turns%angle = scene%angle
         call follow_places(recorder%turns, system, work%kinematics, step%dynamics%start, scene%q)
         allocate (values(sample_width(system)))
         call place_frames(system%model, system%layout, step%dynamics%start, scene%q, work%kinematics)
         call move_frames(system%model, system%layout, scene%q, balance%v, work%kinematics)
         call check_residuals(system, work, step%dynamics%start, .false., balance%v, outcome)
         call channel_values(recorder, system, work, step%dynamics%start, scene%q, balance%v, balance%a, values)
         scene%last%q = scene%q
         scene%last%v = scene%v
         scene%last%angle = recorder%turns%angle
      end associate
      call history%take(step%dynamics%start, values, error)
      outcome%samples = 1
   end subroutine sample

   !> Warns of frequencies that the models of bodies make wrong.
   subroutine check_frequencies(scene, step, balance, vibrations, undamped, listed, aside, outcome)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      type(equilibrium_type), intent(inout) :: balance
      !> Those that are listed; as many and some more without damping, one of which may be among them in truth
      type(vibrations_type), intent(in) :: vibrations, undamped
      !> How many of these are in the list
      integer, intent(in) :: listed
      !> What comparisons with more coordinates, and with forces across the velocity, have shown
      character(*), intent(in) :: aside
      type(outcome_type), intent(inout) :: outcome
      real(wp), allocatable :: lambda(:), error(:)
      character(:), allocatable :: text
      logical :: known
      call update_jacobians(scene%system, scene%work)
      if (.not. allocated(outcome%warnings)) outcome%warnings = ''
      outcome%warnings = outcome%warnings//aside//mode_warnings(scene%system, scene%work, scene%q, balance%v, balance%a, &
         & balance%rotation, vibrations, step%name)//kink_warnings(scene%system, balance%tangent, &
         & scene%work%kinematics, step%dynamics%start, scene%q, balance%v, step%damped, vibrations, step%name)
      if (step%damped) outcome%warnings = outcome%warnings//changed_damping(scene%system, balance%tangent, vibrations, &
         & scene%warnings, "*MODES '"//step%name//"'")
      allocate (lambda, source=scene%work%lambda)
      ! An estimate first, which is quick and may be too large or too small; more functions tell where it is not small
      if (listed == 0) return
      text = function_mode_warnings(scene%system, scene%work, balance, step%dynamics%start, scene%q, lambda, undamped, &
         & listed, step%damped, step%name, look_closer)
      if (text == '') return
      call compare_functions(scene, step, balance, undamped, listed, error, known)
      if (.not. known) deallocate (error)
      scene%work%lambda = lambda
      call update_jacobians(scene%system, scene%work)
      outcome%warnings = outcome%warnings//function_mode_warnings(scene%system, scene%work, balance, step%dynamics%start, &
         & scene%q, lambda, undamped, listed, step%damped, step%name, 1.0_wp, error)
   end subroutine check_frequencies

   !> Writes frequencies, damping ratios and shapes.
   subroutine record_modes(scene, step, balance, vibrations, history, error)
      type(scene_type), intent(in) :: scene
      type(analysis_step_type), intent(in) :: step
      type(equilibrium_type), intent(in) :: balance
      type(vibrations_type), intent(in) :: vibrations
      class(history_type), intent(inout) :: history
      type(error_type), allocatable, intent(out) :: error
      character(:), allocatable :: group, names
      real(wp), allocatable :: ratio(:), places(:, :)
      complex(wp), allocatable :: moves(:, :)
      integer :: count
      group = '/modes/'//step%name
      call history%put_group(group, error)
      if (.not. allocated(error)) call history%put_attribute(group, 'rotation', balance%rotation, error)
      if (.not. allocated(error)) call history%put_attribute(group, 'time', step%dynamics%start, error)
      if (allocated(error) .or. size(vibrations%frequency) == 0) return
      allocate (ratio(size(vibrations%frequency)))
      ratio = damping_ratio(vibrations%frequency, vibrations%growth)
      call point_moves(scene%system, scene%q, vibrations%shape, names, places, moves, count)
      associate (units => scene%system%model%units)
         call history%put_real(group//'/frequency', vibrations%frequency, 'rad/'//units%time, &
            & 'circular frequency of each mode', error)
         if (.not. allocated(error)) call history%put_real(group//'/damping_ratio', ratio, '1', &
            & 'part of critical damping of each mode; negative: it grows', error)
         if (.not. allocated(error)) call history%put_real(group//'/growth', vibrations%growth, '1/'//units%time, &
            & 'rate at which each mode grows', error)
         if (.not. allocated(error)) call history%put_real(group//'/shape_real', real(vibrations%shape, wp), '1', &
            & 'shapes in the rates of all bodies: x, y, rotation, deflection coordinates', error)
         if (.not. allocated(error)) call history%put_real(group//'/shape_imaginary', aimag(vibrations%shape), '1', &
            & 'their imaginary parts', error)
         if (.not. allocated(error)) call history%put_text(group//'/points', names, error)
         if (.not. allocated(error)) call history%put_real(group//'/point_place', places, units%length, &
            & 'places of the named points: x and y of each', error)
         if (.not. allocated(error)) call history%put_real(group//'/point_real', real(moves, wp), '1', &
            & 'displacements of the named points in each mode: x and y of each', error)
         if (.not. allocated(error)) call history%put_real(group//'/point_imaginary', aimag(moves), '1', &
            & 'their imaginary parts', error)
         if (.not. allocated(error)) call history%put_axis(group//'/mode', size(ratio), 'number of the mode', &
            & [character(16) :: 'frequency', 'damping_ratio', 'growth', 'shape_real', 'shape_imaginary', 'point_real', &
            & 'point_imaginary'], error)
      end associate
   end subroutine record_modes

   !> Part of critical damping.
   elemental real(wp) function damping_ratio(frequency, growth) result(ratio)
      real(wp), intent(in) :: frequency, growth
      !> Part of |s| that is round-off
      real(wp), parameter :: nothing = 1.0e-15_wp
      ratio = 0.0_wp
      if (abs(growth) > nothing*abs(frequency)) ratio = -growth/sqrt(frequency**2 + growth**2)
   end function damping_ratio

   !> Displacements of all named points of bodies in the shapes.
   subroutine point_moves(system, q, shape, names, places, moves, count)
      type(system_type), intent(in) :: system
      !> Coordinates (nq); shapes (nw, modes)
      real(wp), intent(in) :: q(:)
      complex(wp), intent(in) :: shape(:, :)
      !> Names, one in a line; places (2, points); displacements x, y of one after the other (2 points, modes); their number
      character(:), allocatable, intent(out) :: names
      real(wp), allocatable, intent(out) :: places(:, :)
      complex(wp), allocatable, intent(out) :: moves(:, :)
      integer, intent(out) :: count
      real(wp) :: arm(2), u(2)
      integer :: i, k, j, first, at
      names = ''
      count = 0
      do i = 1, size(system%model%points)
         if (system%model%points(i)%body /= ground) count = count + 1
      end do
      allocate (places(2, count), moves(2*count, size(shape, 2)))
      count = 0
      do i = 1, size(system%model%points)
         associate (point => system%model%points(i))
            if (point%body == ground) cycle
            count = count + 1
            if (count > 1) names = names//newline
            names = names//point%name
            first = system%layout%q(point%body)
            at = system%layout%w(point%body)
            places(:, count) = q(first:first + 1)
            do j = 1, size(shape, 2)
               moves(2*count - 1:2*count, j) = shape(at:at + 1, j)
            end do
            if (.not. system%layout%framed(point%body)) cycle
            u = q(first + 2:first + 3)
            arm = along(point%p0, u)
            do k = 1, system%layout%n(point%body)
               arm = arm + along(point%phi(:, k), u)*q(first + 3 + k)
            end do
            places(:, count) = places(:, count) + arm
            do j = 1, size(shape, 2)
               moves(2*count - 1:2*count, j) = moves(2*count - 1:2*count, j) + turn(arm)*shape(at + 2, j)
               do k = 1, system%layout%n(point%body)
                  moves(2*count - 1:2*count, j) = moves(2*count - 1:2*count, j) + along(point%phi(:, k), u)*shape(at + 2 + k, j)
               end do
            end do
         end associate
      end do
   end subroutine point_moves

   !> Lines with the modes; those that grow are named.
   function table(scene, vibrations, is_damped) result(text)
      type(scene_type), intent(in) :: scene
      type(vibrations_type), intent(in) :: vibrations
      !> Whether dampers count
      logical, intent(in) :: is_damped
      character(:), allocatable :: text
      character(:), allocatable :: kind
      character(100) :: line
      integer :: i
      real(wp), parameter :: turn_once = 2*acos(-1.0_wp)
      text = ''
      if (size(vibrations%frequency) == 0) return
      associate (unit => scene%system%model%units%time)
         line = '      mode   frequency [rad/'//unit//']   [1/'//unit//']'
         write (line(46:), '(a)') 'damping ratio'
         text = newline//trim(line)
         kind = ''
         do i = 1, size(vibrations%frequency)
            write (line, '(i10,2es17.7,es16.4)') i, vibrations%frequency(i), vibrations%frequency(i)/turn_once, &
               & damping_ratio(vibrations%frequency(i), vibrations%growth(i))
            text = text//newline//trim(line)
            kind = kind_of_growth(vibrations%frequency(i), vibrations%growth(i), is_damped)
            if (kind /= '') text = text//'  '//kind
         end do
      end associate
   end function table

end module limber_analysis_modal_analysis
