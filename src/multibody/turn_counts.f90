!> Turns of all frames at the start of an analysis. Those of a driver's law, of the angles that joints follow, and of what is held
!> at an angle to such a frame; else those that the deck or the analysis before has left. Floor: multibody. Source: doc/theory, eqs.
!> (3.10), (3.12).
module limber_multibody_turn_counts
   use limber_base_kinds, only: wp
   use limber_deck_operations, only: jet_type
   use limber_model_driver_laws, only: driven_motion
   use limber_model_model, only: driver_angle, driver_joint_angle, coordinate_angle, coordinate_joint_angle, ground
   use limber_model_switches, only: acts
   use limber_multibody_kinematics, only: kinematics_type, place_frames
   use limber_multibody_layout, only: layout_type
   use limber_multibody_plane_vectors, only: cross
   use limber_multibody_system, only: system_type
   implicit none
   private
   public :: start_turns, unite_turns, count_turns, section_bend, driven_turn, angle_near

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
            angle(body) = own%value - own%own - section_bend(system, kinematics%markers(own%markers(2))%point, q)
            known(body) = .true.
         end associate
      end do
      do i = 1, size(system%model%drivers)
         if (system%model%drivers(i)%kind /= driver_angle .or. .not. acts(system%model%drivers(i)%switch, system%on)) cycle
         motion = driven_motion(system%model%drivers(i), t)
         angle(system%model%drivers(i)%body) = motion%value
         known(system%model%drivers(i)%body) = .true.
      end do
      call spread(system, left, q, .false., angle, known)
      do i = 1, size(angle)
         if (system%layout%framed(i)) angle(i) = angle_near(angle(i), q(system%layout%q(i) + 2:))
      end do
      call take_counts(system, q, angle, known, kinematics)
   end subroutine start_turns

   !> Turns of frames that welds and guides join, at the first state. What is joined to the ground has those that this tells, and
   !> else those of the first body, whatever the beams between are bent by.
   subroutine unite_turns(system, q, angle)
      type(system_type), intent(in) :: system
      !> Coordinates (nq)
      real(wp), intent(in) :: q(:)
      !> Angles of frames, as the deck gives them; replaced (bodies) [rad]
      real(wp), intent(inout) :: angle(:)
      real(wp) :: left(size(angle))
      logical :: known(size(angle))
      integer :: first
      left = angle
      known = .false.
      call spread(system, left, q, .true., angle, known)
      do first = 1, size(angle)
         if (known(first)) cycle
         known(first) = .true.
         if (is_joined(first)) call spread(system, left, q, .true., angle, known)
      end do

   contains

      !> Whether a weld or a guide joins a body to another one.
      logical function is_joined(body)
         integer, intent(in) :: body
         integer :: i
         is_joined = .false.
         do i = 1, size(system%model%joints)
            associate (joint => system%model%joints(i))
               if (.not. joint%keeps_angle .or. .not. acts(joint%switch, system%on)) cycle
               is_joined = is_joined .or. any(system%model%points(joint%points)%body == body)
            end associate
         end do
      end function is_joined

   end subroutine unite_turns

   !> Counts the turns of all frames from one place to another, less than half a turn each.
   pure subroutine count_turns(layout, before, behind, turned)
      type(layout_type), intent(in) :: layout
      !> Coordinates (nq)
      real(wp), intent(in) :: before(:), behind(:)
      !> So far (bodies) [rad]
      real(wp), intent(inout) :: turned(:)
      integer :: i, first
      do i = 1, size(turned)
         if (.not. layout%framed(i)) cycle
         first = layout%q(i) + 2
         associate (from => before(first:first + 1), to => behind(first:first + 1))
            turned(i) = turned(i) + atan2(cross(from, to), dot_product(from, to))
         end associate
      end do
   end subroutine count_turns

   !> By how much the section at a point is turned from its frame by the deflection of its body [rad].
   pure real(wp) function section_bend(system, point, q) result(angle)
      type(system_type), intent(in) :: system
      !> Index of the point
      integer, intent(in) :: point
      !> Coordinates (nq)
      real(wp), intent(in) :: q(:)
      integer :: first
      angle = 0.0_wp
      associate (own => system%model%points(point))
         if (size(own%psi) == 0 .or. own%body == ground) return
         first = system%layout%q(own%body) + 4
         angle = dot_product(own%psi, q(first:first + size(own%psi) - 1))
         if (.not. own%exact) angle = atan(angle)
      end associate
   end function section_bend

   !> What a weld or a guide holds at an angle to a frame of known turns has these too.
   subroutine spread(system, left, q, is_first, angle, known)
      type(system_type), intent(in) :: system
      !> Angles before (bodies) [rad]; coordinates now (nq)
      real(wp), intent(in) :: left(:), q(:)
      !> Whether those are of the deck, whose beams are straight, and the ground counts as known
      logical, intent(in) :: is_first
      real(wp), intent(inout) :: angle(:)
      logical, intent(inout) :: known(:)
      integer :: i, k, joints
      logical :: more
      joints = size(system%model%joints)
      more = any(known) .or. is_first
      do while (more)
         more = .false.
         ! To and fro: a chain is then passed at once, in whatever order the deck has its joints
         do i = 1, 2*joints
            k = merge(i, 2*joints + 1 - i, i <= joints)
            if (system%model%joints(k)%keeps_angle .and. acts(system%model%joints(k)%switch, system%on)) &
               & call pass_joint(system, left, q, is_first, k, angle, known, more)
         end do
      end do
   end subroutine spread

   !> From one side of a joint that keeps its angle to the other.
   subroutine pass_joint(system, left, q, is_first, joint, angle, known, more)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: left(:), q(:)
      logical, intent(in) :: is_first
      integer, intent(in) :: joint
      real(wp), intent(inout) :: angle(:)
      logical, intent(inout) :: known(:), more
      integer :: side, from, to, bodies(2)
      real(wp) :: relative, bend
      logical :: tells(2)
      associate (own => system%model%joints(joint), points => system%model%points)
         bodies = points(own%points)%body
         do side = 1, 2
            tells(side) = is_first
            if (bodies(side) == ground) cycle
            if (.not. system%layout%framed(bodies(side))) return
            tells(side) = known(bodies(side))
         end do
         if (tells(1) .eqv. tells(2)) return
         side = merge(2, 1, tells(1))
         to = bodies(side)
         if (to == ground) return
         from = bodies(3 - side)
         ! Angle of the first frame from the second, and how far the second section is bent more than the first
         bend = section_bend(system, own%points(2), q) - section_bend(system, own%points(1), q)
         relative = own%turn + points(own%points(1))%lean - points(own%points(2))%lean + bend
         if (.not. own%has_turn) then
            relative = merge(bend, 0.0_wp, is_first)
            if (bodies(1) /= ground) relative = relative + left(bodies(1))
            if (bodies(2) /= ground) relative = relative - left(bodies(2))
         end if
         angle(to) = merge(relative, -relative, side == 1)
         if (from /= ground) angle(to) = angle(to) + angle(from)
         known(to) = .true.
         more = .true.
      end associate
   end subroutine pass_joint

   !> Angles that only loads and laws follow take the counts.
   subroutine take_counts(system, q, angle, known, kinematics)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: q(:), angle(:)
      logical, intent(in) :: known(:)
      type(kinematics_type), intent(inout) :: kinematics
      integer :: i
      do i = system%held_angles + 1, size(kinematics%angles)
         associate (own => kinematics%angles(i), to => kinematics%markers(kinematics%angles(i)%markers(2)))
            if (own%markers(1) > 0 .or. to%body == ground) cycle
            if (.not. known(to%body)) cycle
            own%value = angle_near(angle(to%body) + own%own + section_bend(system, to%point, q), to%position)
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
