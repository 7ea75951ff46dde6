!> States of controls that no rate changes: their first values, and samples of sampled controls. A state is the velocity along x of
!> the point that carries it. Floor: multibody. Source: doc/theory, section 5.21, eqs. (5.79), (5.81).
module limber_multibody_control_states
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use, intrinsic :: ieee_exceptions, only: ieee_status_type, ieee_get_status, ieee_set_status, ieee_set_halting_mode, ieee_all
   use limber_base_error, only: error_type, raise
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_model_model, only: control_type
   use limber_multibody_force_elements, only: max_slots
   use limber_multibody_kinematics, only: place_frames, move_frames
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: start_states, next_sample, take_samples, has_inputs, keep_states, follow_switches

   !> States of a sampled control: output; output that follows it; integral; last input; number of the last sample from 1, 0: none
   integer, parameter :: output = 1, following = 2, integral = 3, last_input = 4, number = 5

contains

   !> Adds what the first inputs give to the first values of states. One that depends on such a state of another control comes
   !> behind it.
   subroutine start_states(system, work, t, q, v)
      !> Receives the states of switches that are those of a hysteresis
      type(system_type), intent(inout) :: system
      type(workspace_type), intent(inout) :: work
      !> Time, coordinates (nq)
      real(wp), intent(in) :: t, q(:)
      !> Velocities (nq); receives the states
      real(wp), intent(inout) :: v(:)
      integer :: round, i, k
      real(wp) :: value
      do round = 1, size(system%inputs)
         do i = 1, size(system%inputs)
            associate (control => system%model%controls(i))
               if (.not. (any(abs(control%first_gain) > 0.0_wp) .or. control%switch > 0)) cycle
               value = input_value(system, work, i, t, q, v)
               if (.not. ieee_is_finite(value)) value = 0.0_wp
               if (control%switch > 0) then
                  if (value > control%most) system%on(control%switch) = .true.
                  if (value < control%least) system%on(control%switch) = .false.
                  call follow_switches(system, v)
               end if
               do k = 1, size(control%points)
                  if (abs(control%first_gain(k)) > 0.0_wp) v(place(system, control, k)) = control%first(k) &
                     & + control%first_gain(k)*value
               end do
            end associate
         end do
      end do
   end subroutine start_states

   !> Gives each hysteresis the output that its switch stands for.
   pure subroutine follow_switches(system, v)
      type(system_type), intent(in) :: system
      !> Velocities (nq); receives the states
      real(wp), intent(inout) :: v(:)
      integer :: i
      do i = 1, size(system%inputs)
         associate (control => system%model%controls(i))
            if (control%switch > 0) v(place(system, control, output)) = merge(control%gains(1), 0.0_wp, system%on(control%switch))
         end associate
      end do
   end subroutine follow_switches

   !> The next instant behind a time at which a sampled control takes a sample, or changes its output; huge if there is none.
   pure real(wp) function next_sample(system, t, near) result(next)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: t
      !> Times so near that there is no step between them
      real(wp), intent(in) :: near
      integer :: i
      next = huge(next)
      do i = 1, size(system%inputs)
         associate (control => system%model%controls(i))
            if (.not. control%period > 0.0_wp) cycle
            next = min(next, behind(t + near, control%period, 0.0_wp))
            if (control%delay > 0.0_wp) next = min(next, behind(t + near, control%period, control%delay))
         end associate
      end do
   end function next_sample

   !> Whether an input of the system may come from outside.
   pure logical function has_inputs(system)
      type(system_type), intent(in) :: system
      has_inputs = any(system%model%controls%is_input)
   end function has_inputs

   !> The first multiple of a period, and a delay, behind a time.
   pure real(wp) function behind(t, period, delay)
      real(wp), intent(in) :: t, period, delay
      real(wp) :: turns
      turns = real(floor((t - delay)/period), wp)
      behind = turns*period + delay
      do while (behind <= t)
         turns = turns + 1
         behind = turns*period + delay
      end do
   end function behind

   !> Takes the samples that fall to an instant, eq. (5.81), in the order of the controls: first outputs that follow an earlier
   !> sample. A sample that is taken already is not taken again.
   subroutine take_samples(system, work, t, near, q, v, changed, error)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> The instant, and times so near that they are one
      real(wp), intent(in) :: t, near
      !> Coordinates (nq)
      real(wp), intent(in) :: q(:)
      !> Velocities (nq); receives the states
      real(wp), intent(inout) :: v(:)
      !> Whether an output has changed
      logical, intent(out) :: changed
      !> An input has no value
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: value, before
      integer :: i, turn
      changed = .false.
      do i = 1, size(system%inputs)
         associate (control => system%model%controls(i))
            if (.not. control%period > 0.0_wp) cycle
            before = v(place(system, control, output))
            if (control%delay > 0.0_wp) then
               turn = nint((t - control%delay)/control%period)
               if (abs(turn*control%period + control%delay - t) <= near) v(place(system, control, output)) &
                  & = v(place(system, control, following))
            end if
            turn = nint(t/control%period)
            if (abs(turn*control%period - t) <= near .and. turn + 1 > nint(v(place(system, control, number)))) then
               if (system%is_given(i)) then
                  value = system%given(i)
               else
                  value = input_value(system, work, i, t, q, v)
               end if
               if (.not. ieee_is_finite(value)) then
                  call raise(error, "the input of control '"//control%name//"' has no value at t = "//as_text(t, 8))
                  return
               end if
               call take_sample(system, control, turn, value, v)
            end if
            changed = changed .or. abs(v(place(system, control, output)) - before) > 0.0_wp
         end associate
      end do
   end subroutine take_samples

   !> One sample, eq. (5.81). The integral stops where the output is at a limit and would go on beyond it.
   subroutine take_sample(system, control, turn, value, v)
      type(system_type), intent(in) :: system
      type(control_type), intent(in) :: control
      !> Its number from 0, and the input
      integer, intent(in) :: turn
      real(wp), intent(in) :: value
      real(wp), intent(inout) :: v(:)
      real(wp) :: sum, change, wanted, kept
      kept = v(place(system, control, integral))
      sum = kept + control%gains(2)*value
      change = 0.0_wp
      if (v(place(system, control, number)) > 0.5_wp) change = value - v(place(system, control, last_input))
      wanted = control%gains(1)*value + sum + control%gains(3)*change
      if ((wanted > control%most .and. sum > kept) .or. (wanted < control%least .and. sum < kept)) sum = kept
      wanted = control%gains(1)*value + sum + control%gains(3)*change
      v(place(system, control, integral)) = sum
      v(place(system, control, last_input)) = value
      v(place(system, control, number)) = turn + 1
      v(place(system, control, following)) = min(max(wanted, control%least), control%most)
      if (.not. control%delay > 0.0_wp) v(place(system, control, output)) = v(place(system, control, following))
   end subroutine take_sample

   !> Puts states back into velocities that have been set anew.
   pure subroutine keep_states(system, before, v)
      type(system_type), intent(in) :: system
      !> Velocities before, and those that are set (nq)
      real(wp), intent(in) :: before(:)
      real(wp), intent(inout) :: v(:)
      integer :: i
      do i = 1, size(system%layout%q)
         if (system%layout%carries(i)) v(system%layout%q(i)) = before(system%layout%q(i))
      end do
   end subroutine keep_states

   !> Index of a state among the velocities.
   pure integer function place(system, control, state)
      type(system_type), intent(in) :: system
      type(control_type), intent(in) :: control
      integer, intent(in) :: state
      place = system%layout%q(system%model%points(control%points(state))%body)
   end function place

   !> First input of a control at a state; not finite where it has no value.
   real(wp) function input_value(system, work, control, t, q, v) result(value)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      integer, intent(in) :: control
      !> Time; coordinates and velocities (nq)
      real(wp), intent(in) :: t, q(:), v(:)
      type(ieee_status_type) :: status
      real(wp) :: places(max_slots), rates(max_slots), gap(2, max_slots), drift(2, max_slots)
      integer :: k
      call place_frames(system%model, system%layout, t, q, work%kinematics)
      call move_frames(system%model, system%layout, q, v, work%kinematics)
      associate (input => system%inputs(control))
         call input%read_motion(work%kinematics, places, rates, gap, drift)
         do k = 1, size(input%slots)
            if (input%by_rate(k)) places(k) = rates(k)
         end do
         call ieee_get_status(status)
         call ieee_set_halting_mode(ieee_all, .false.)
         value = input%law%evaluate(places(:size(input%slots)))
         call ieee_set_status(status)
      end associate
   end function input_value

end module limber_multibody_control_states
