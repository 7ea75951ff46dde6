!> Turns of all frames at the start of an analysis. Those of a driver's law, of the angles that joints follow, and of what is held
!> at an angle to such a frame; else those that the deck or the analysis before has left. Floor: multibody. Source: doc/theory, eqs.
!> (3.10), (3.12).
module limber_multibody_turn_counts
   use limber_base_kinds, only: wp
   use limber_deck_operations, only: jet_type
   use limber_model_driver_laws, only: driven_motion
   use limber_model_model, only: driver_angle, driver_joint_angle, coordinate_angle, coordinate_joint_angle, ground
   use limber_multibody_kinematics, only: kinematics_type, place_frames
   use limber_multibody_system, only: system_type
   implicit none
   private
   public :: start_turns, driven_turn, angle_near

contains

   !> Starts the counts at a state.
   subroutine start_turns(system, kinematics, t, q, angle)
      type(system_type), intent(in) :: system
      !> Receives the followed angles of directions
      type(kinematics_type), intent(inout) :: kinematics
      !> Time; coordinates (nq)
      real(wp), intent(in) :: t
      real(wp), contiguous, intent(in) :: q(:)
      !> Angles of frames, as the deck or the analysis before has left them; replaced (bodies) [rad]
      real(wp), intent(inout) :: angle(:)
      type(jet_type) :: motion
      real(wp) :: left(size(angle))
      logical :: known(size(angle))
      integer :: i
      left = angle
      known = .false.
      if (size(kinematics%angles) > 0) call place_frames(system%model, system%layout, t, q, kinematics)
      do i = 1, size(kinematics%angles)
         associate (own => kinematics%angles(i), body => kinematics%markers(kinematics%angles(i)%markers(2))%body)
            if (own%markers(1) > 0 .or. body == ground .or. i > system%held_angles) cycle
            if (known(body)) cycle
            angle(body) = own%value - own%own
            known(body) = .true.
         end associate
      end do
      do i = 1, size(system%model%drivers)
         if (system%model%drivers(i)%kind /= driver_angle) cycle
         motion = driven_motion(system%model%drivers(i), t)
         angle(system%model%drivers(i)%body) = motion%value
         known(system%model%drivers(i)%body) = .true.
      end do
      call spread(system, left, angle, known)
      do i = 1, size(angle)
         if (system%layout%framed(i)) angle(i) = angle_near(angle(i), q(system%layout%q(i) + 2:))
      end do
      call take_counts(system, angle, known, kinematics)
   end subroutine start_turns

   !> What a weld or a guide holds at an angle to a frame of known turns has these too.
   subroutine spread(system, left, angle, known)
      type(system_type), intent(in) :: system
      !> Angles before (bodies) [rad]
      real(wp), intent(in) :: left(:)
      real(wp), intent(inout) :: angle(:)
      logical, intent(inout) :: known(:)
      integer :: i, from, to, bodies(2)
      real(wp) :: relative
      logical :: more
      more = any(known)
      do while (more)
         more = .false.
         do i = 1, size(system%model%joints)
            associate (joint => system%model%joints(i))
               if (.not. joint%keeps_angle) cycle
               bodies = system%model%points(joint%points)%body
               if (any(bodies == ground)) cycle
               if (.not. all(system%layout%framed(bodies)) .or. (known(bodies(1)) .eqv. known(bodies(2)))) cycle
               from = merge(bodies(1), bodies(2), known(bodies(1)))
               to = sum(bodies) - from
               relative = left(to) - left(from)
               if (joint%has_turn) relative = merge(1, -1, to == bodies(1))*(joint%turn &
                  & + system%model%points(joint%points(1))%lean - system%model%points(joint%points(2))%lean)
               angle(to) = angle(from) + relative
               known(to) = .true.
               more = .true.
            end associate
         end do
      end do
   end subroutine spread

   !> Angles that only loads and laws follow take the counts.
   subroutine take_counts(system, angle, known, kinematics)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: angle(:)
      logical, intent(in) :: known(:)
      type(kinematics_type), intent(inout) :: kinematics
      integer :: i
      do i = system%held_angles + 1, size(kinematics%angles)
         associate (own => kinematics%angles(i), to => kinematics%markers(kinematics%angles(i)%markers(2)))
            if (own%markers(1) > 0 .or. to%body == ground) cycle
            if (.not. known(to%body)) cycle
            own%value = angle_near(angle(to%body) + own%own, to%position)
            own%anchor = own%value
            own%rate = 0.0_wp
         end associate
      end do
   end subroutine take_counts

   !> The most by which a driver or the law of a coupler turns a frame from one time to another [rad].
   pure real(wp) function driven_turn(system, from, to) result(most)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: from, to
      type(jet_type) :: before, behind
      integer :: i
      most = 0.0_wp
      do i = 1, size(system%model%drivers)
         if (.not. any(system%model%drivers(i)%kind == [driver_angle, driver_joint_angle])) cycle
         before = driven_motion(system%model%drivers(i), from)
         behind = driven_motion(system%model%drivers(i), to)
         most = max(most, abs(behind%value - before%value))
      end do
      do i = 1, size(system%model%joints)
         associate (joint => system%model%joints(i))
            if (.not. joint%has_law) cycle
            if (.not. all(joint%terms%kind == coordinate_angle .or. joint%terms%kind == coordinate_joint_angle)) cycle
            before = joint%law%evaluate_jet(from)
            behind = joint%law%evaluate_jet(to)
            most = max(most, abs(behind%value - before%value)/maxval(abs(joint%terms%coefficient)))
         end associate
      end do
   end function driven_turn

   !> The angle of a unit vector, with the turns that bring it nearest to a given angle.
   pure real(wp) function angle_near(before, u) result(angle)
      !> [rad]
      real(wp), intent(in) :: before, u(:)
      real(wp), parameter :: turn_once = 2*acos(-1.0_wp)
      angle = atan2(u(2), u(1))
      angle = angle + turn_once*anint((before - angle)/turn_once)
   end function angle_near

end module limber_multibody_turn_counts
