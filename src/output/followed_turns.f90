!> Angles of all frames, accumulated over turns. From state to state of an analysis, and within a step of a motion. Which turn it is
!> the law of its driver says, or else the speeds at both ends of the step, so that none is lost however far a step turns; between
!> two equilibria the way of the search. Floor: output. Source: doc/theory, eqs. (3.10)-(3.12).
module limber_output_followed_turns
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_deck_operations, only: jet_type
   use limber_model_driver_laws, only: driven_motion
   use limber_model_model, only: driver_angle
   use limber_model_switches, only: acts
   use limber_multibody_plane_vectors, only: cross
   use limber_multibody_kinematics, only: kinematics_type
   use limber_multibody_system, only: system_type
   use limber_multibody_turn_counts, only: start_turns, unite_turns, angle_near
   implicit none
   private
   public :: turns_type, new_turns, follow_places, follow_motion, turned_angle

   !> What is remembered of the angles
   type :: turns_type
      !> Angle of each body's frame at the last state that counts, and at the one before (bodies) [rad]
      real(wp), allocatable :: angle(:), before(:)
      !> Speeds there (bodies) [rad/time], and their times; of states that follow no motion both times are the same
      real(wp), allocatable :: spin(:), spin_before(:)
      real(wp) :: time = 0.0_wp, time_before = 0.0_wp
      !> Whether they follow a motion
      logical :: moving = .false.
      !> Drivers that give them (bodies), 0: none
      integer, allocatable :: drivers(:)
   contains
      procedure :: exchange => exchange_turns
   end type turns_type

contains

   !> Angles at the first state, with the turns that the deck gives.
   function new_turns(system, q) result(turns)
      type(system_type), intent(in) :: system
      !> Coordinates (nq)
      real(wp), intent(in) :: q(:)
      type(turns_type) :: turns
      type(jet_type) :: motion
      integer :: i, n
      n = size(system%model%bodies)
      allocate (turns%angle(n), turns%spin(n), turns%drivers(n))
      turns%drivers = 0
      turns%spin = 0.0_wp
      turns%angle = system%model%bodies%angle
      do i = 1, size(system%model%drivers)
         associate (driver => system%model%drivers(i))
            if (driver%kind /= driver_angle) cycle
            if (driver%switch == 0) turns%drivers(driver%body) = i
            if (.not. acts(driver%switch, system%on)) cycle
            motion = driven_motion(driver, system%model%dynamics%start)
            turns%angle(driver%body) = motion%value
         end associate
      end do
      allocate (turns%before(n), source=turns%angle)
      allocate (turns%spin_before(n), source=turns%spin)
      call unite_turns(system, q, turns%angle)
      do i = 1, n
         if (system%layout%framed(i)) turns%angle(i) = angle_near(turns%angle(i), q(system%layout%q(i) + 2:))
      end do
   end function new_turns

   !> Carries the angles on to a state that is the start of an analysis, or follows no motion: less than half a turn away, but for
   !> what drivers and joints tell of them, and the way that led there.
   subroutine follow_places(turns, system, kinematics, t, q, turned)
      type(turns_type), intent(inout) :: turns
      type(system_type), intent(in) :: system
      !> Placed there; its angles agree with these behind
      type(kinematics_type), intent(inout) :: kinematics
      !> Time; coordinates (nq)
      real(wp), intent(in) :: t
      real(wp), contiguous, intent(in) :: q(:)
      !> By how much the frames have turned since the last state (bodies) [rad]
      real(wp), intent(in), optional :: turned(:)
      turns%moving = .false.
      if (present(turned)) turns%angle = turns%angle + turned
      call start_turns(system, kinematics, t, q, turns%angle)
   end subroutine follow_places

   !> Carries the angles on to the end of a step of a motion; the first call takes its start.
   subroutine follow_motion(turns, system, kinematics, t, q, v)
      type(turns_type), intent(inout) :: turns
      type(system_type), intent(in) :: system
      !> Placed at the time, or at another
      type(kinematics_type), intent(in) :: kinematics
      !> Time; coordinates and velocities (nq)
      real(wp), intent(in) :: t, q(:), v(:)
      real(wp) :: spin, expected
      integer :: body, first
      do body = 1, size(turns%angle)
         if (.not. system%layout%framed(body)) cycle
         first = system%layout%q(body) + 2
         spin = cross(q(first:first + 1), v(first:first + 1))
         expected = turns%angle(body)
         if (turns%moving) expected = expected + 0.5_wp*(t - turns%time)*(turns%spin(body) + spin)
         if (turns%drivers(body) > 0 .and. .not. abs(kinematics%time - t) > 0.0_wp) then
            expected = kinematics%drives(turns%drivers(body))%value
         else
            expected = driven_or(turns, system, body, t, expected)
         end if
         turns%before(body) = turns%angle(body)
         turns%spin_before(body) = turns%spin(body)
         turns%angle(body) = angle_near(expected, q(first:))
         turns%spin(body) = spin
      end do
      turns%time_before = merge(turns%time, t, turns%moving)
      turns%time = t
      turns%moving = .true.
   end subroutine follow_motion

   !> Angle of a unit vector of a body at a time within the last step, or in the last state.
   pure real(wp) function turned_angle(turns, system, body, t, u) result(angle)
      type(turns_type), intent(in) :: turns
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      real(wp), intent(in) :: t, u(:)
      real(wp) :: expected, h, s
      expected = turns%angle(body)
      h = turns%time - turns%time_before
      if (turns%moving .and. t < turns%time .and. h > 0.0_wp) then
         s = (t - turns%time_before)/h
         expected = turns%before(body) + (turns%angle(body) - turns%before(body))*s**2*(3 - 2*s) &
            & + h*s*(1 - s)*((1 - s)*turns%spin_before(body) - s*turns%spin(body))
      end if
      if (turns%moving) expected = driven_or(turns, system, body, t, expected)
      angle = angle_near(expected, u)
   end function turned_angle

   !> What its driver prescribes, or else the angle that is expected.
   pure real(wp) function driven_or(turns, system, body, t, expected) result(angle)
      type(turns_type), intent(in) :: turns
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      real(wp), intent(in) :: t, expected
      type(jet_type) :: motion
      angle = expected
      if (turns%drivers(body) == 0) return
      motion = driven_motion(system%model%drivers(turns%drivers(body)), t)
      angle = motion%value
   end function driven_or

   !> Saves or restores them.
   subroutine exchange_turns(self, snapshot)
      class(turns_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%keep('angle', self%angle)
      call snapshot%keep('angle_before', self%before)
      call snapshot%keep('spin', self%spin)
      call snapshot%keep('spin_before', self%spin_before)
      call snapshot%exchange('turns_time', self%time)
      call snapshot%exchange('turns_time_before', self%time_before)
      call snapshot%exchange('turns_moving', self%moving)
      ! Not saved: drivers
   end subroutine exchange_turns

end module limber_output_followed_turns
