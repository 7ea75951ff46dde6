!> Reactions of joints and drivers. Reactions from the multipliers and the Jacobian, whatever the type of joint, and joint
!> coordinates from the places of the bodies. Floor: output. Source: doc/theory, eq. (3.30).
module limber_output_joint_forces
   use limber_base_kinds, only: wp
   use limber_model_model, only: ground, point_type, driver_angle
   use limber_output_segment_measures, only: whole_direction
   use limber_multibody_beam_path, only: beam_path_type
   use limber_multibody_plane_vectors, only: along, cross, turn
   use limber_multibody_point_motion, only: point_position, point_velocity
   use limber_multibody_system, only: system_type, workspace_type
   use limber_multibody_turn_counts, only: section_bend
   implicit none
   private
   public :: joint_force, joint_force_in_frame, joint_moment, joint_displacement, joint_sliding, section_rotation, joint_spin
   public :: frame_of, driver_effort, driver_power, coupler_effort, coupler_power

contains

   !> Force of a joint on its first body, along the fixed axes (2).
   pure function joint_force(system, work, joint) result(force)
      type(system_type), intent(in) :: system
      !> Multipliers and Jacobians are those of the state
      type(workspace_type), intent(in) :: work
      !> Index of the joint
      integer, intent(in) :: joint
      real(wp) :: force(2), pull(3)
      if (system%constraints(joint)%item%bodies(1) /= ground) then
         pull = reaction(system, work, joint, 1)
         force = pull(1:2)
      else
         pull = reaction(system, work, joint, 2)
         force = -pull(1:2)
      end if
   end function joint_force

   !> The same along the axes of the second body's frame (2).
   pure function joint_force_in_frame(system, work, joint, q) result(force)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      integer, intent(in) :: joint
      !> Coordinates (nq)
      real(wp), intent(in) :: q(:)
      real(wp) :: force(2), u(2), whole(2)
      u = frame_of(system, system%constraints(joint)%item%bodies(2), q)
      whole = joint_force(system, work, joint)
      force = [dot_product(u, whole), cross(u, whole)]
   end function joint_force_in_frame

   !> Moment of a joint on its first body, about its first point: from x to y.
   pure real(wp) function joint_moment(system, work, joint, q) result(moment)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      integer, intent(in) :: joint
      real(wp), intent(in) :: q(:)
      real(wp) :: pull(3), place(2)
      integer :: side
      side = merge(2, 1, system%constraints(joint)%item%bodies(1) == ground)
      associate (body => system%constraints(joint)%item%bodies(side))
         moment = 0.0_wp
         if (.not. system%layout%framed(body)) return
         pull = reaction(system, work, joint, side)
         place = q(system%layout%q(body):system%layout%q(body) + 1) &
            & - point_position(system%model, system%layout, system%model%points(system%model%joints(joint)%points(1)), q)
         moment = pull(3) + cross(place, pull(1:2))
         if (side == 2) moment = -moment
      end associate
   end function joint_moment

   !> Force and torque about the origin of its frame of a constraint on one of its bodies: -Jacobian^T lambda.
   pure function reaction(system, work, constraint, side) result(pull)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      integer, intent(in) :: constraint, side
      real(wp) :: pull(3)
      integer :: row
      pull = 0.0_wp
      associate (item => system%constraints(constraint)%item)
         do row = 1, item%rows
            pull = pull - work%lambda(item%first + row - 1)*work%jacobians(side, constraint)%z(row, :)
         end do
      end associate
   end function reaction

   !> Place of the first point of a joint along the axis at its angle in the second section, or along a beam from the second one.
   pure real(wp) function joint_displacement(system, joint, q) result(place)
      type(system_type), intent(in) :: system
      integer, intent(in) :: joint
      real(wp), intent(in) :: q(:)
      real(wp) :: axis(2), turning(2), speed
      select type (path => system%constraints(joint)%item)
      class is (beam_path_type)
         call find_coordinate(system, path, q, q, place, speed)
         return
      end select
      call find_axis(system, joint, q, q, axis, turning)
      associate (spec => system%model%joints(joint))
         place = dot_product(axis, point_position(system%model, system%layout, system%model%points(spec%points(1)), q) &
            & - point_position(system%model, system%layout, system%model%points(spec%points(2)), q))
      end associate
   end function joint_displacement

   !> Its rate.
   pure real(wp) function joint_sliding(system, joint, q, v) result(speed)
      type(system_type), intent(in) :: system
      integer, intent(in) :: joint
      real(wp), intent(in) :: q(:), v(:)
      real(wp) :: axis(2), turning(2), place
      select type (path => system%constraints(joint)%item)
      class is (beam_path_type)
         call find_coordinate(system, path, q, v, place, speed)
         return
      end select
      call find_axis(system, joint, q, v, axis, turning)
      associate (a => system%model%points(system%model%joints(joint)%points(1)), &
         & b => system%model%points(system%model%joints(joint)%points(2)))
         speed = dot_product(axis, point_velocity(system%model, system%layout, a, q, v) - point_velocity(system%model, &
            & system%layout, b, q, v)) &
            & + dot_product(turning, point_position(system%model, system%layout, a, q) - point_position(system%model, &
            & system%layout, b, q))
      end associate
   end function joint_sliding

   !> Coordinate along a beam from the second point to the first, and its rate.
   pure subroutine find_coordinate(system, path, q, v, place, speed)
      type(system_type), intent(in) :: system
      class(beam_path_type), intent(in) :: path
      real(wp), intent(in) :: q(:), v(:)
      real(wp), intent(out) :: place, speed
      real(wp) :: arm(2), drift(2), z(2 + system%layout%n(path%bodies(2))), rate(2 + system%layout%n(path%bodies(2)))
      integer :: first, last
      first = system%layout%q(path%bodies(2))
      last = first + 3 + system%layout%n(path%bodies(2))
      associate (point => system%model%points(path%points(1)), u => q(first + 2:first + 3), turning => v(first + 2:first + 3))
         arm = point_position(system%model, system%layout, point, q) - q(first:first + 1)
         drift = point_velocity(system%model, system%layout, point, q, v) - v(first:first + 1)
         z = [dot_product(u, arm), cross(u, arm), q(first + 4:last)]
         rate = [dot_product(u, drift) + dot_product(turning, arm), cross(u, drift) + cross(turning, arm), v(first + 4:last)]
      end associate
      call path%coordinate(z, rate, place, speed)
      place = place - path%start
   end subroutine find_coordinate

   !> The axis of a joint in its second section, and how it turns.
   pure subroutine find_axis(system, joint, q, v, axis, turning)
      type(system_type), intent(in) :: system
      integer, intent(in) :: joint
      real(wp), intent(in) :: q(:), v(:)
      real(wp), intent(out) :: axis(2), turning(2)
      real(wp) :: p(2), slope, rate
      integer :: first, last
      associate (spec => system%model%joints(joint), point => system%model%points(system%model%joints(joint)%points(2)))
         p = [cos(spec%angle - point%lean), sin(spec%angle - point%lean)]
         axis = p
         turning = 0.0_wp
         if (point%body == ground) return
         if (.not. system%layout%framed(point%body)) return
         first = system%layout%q(point%body) + 4
         last = first + size(point%psi) - 1
         slope = dot_product(point%psi, q(first:last))
         rate = dot_product(point%psi, v(first:last))
         if (point%exact) then
            p = along(p, [cos(slope), sin(slope)])
            axis = along(p, q(first - 2:first - 1))
            turning = along(p, v(first - 2:first - 1)) + along(rate*turn(p), q(first - 2:first - 1))
            return
         end if
         axis = along(p + slope*turn(p), q(first - 2:first - 1))
         turning = along(p + slope*turn(p), v(first - 2:first - 1)) + along(rate*turn(p), q(first - 2:first - 1))
      end associate
   end subroutine find_axis

   !> Angle of the section at a point within the frame of its body; of a point of a frame of exact beams less that of its member.
   pure real(wp) function section_rotation(system, point, q) result(angle)
      type(system_type), intent(in) :: system
      !> Index of the point
      integer, intent(in) :: point
      real(wp), intent(in) :: q(:)
      angle = section_bend(system, point, q) - system%model%points(point)%lean
   end function section_rotation

   !> Angular velocity of the first section of a joint relative to the second.
   pure real(wp) function joint_spin(system, joint, q, v) result(spin)
      type(system_type), intent(in) :: system
      integer, intent(in) :: joint
      real(wp), intent(in) :: q(:), v(:)
      associate (spec => system%model%joints(joint))
         spin = section_spin(system, system%model%points(spec%points(1)), q, v) &
            & - section_spin(system, system%model%points(spec%points(2)), q, v)
      end associate
   end function joint_spin

   pure real(wp) function section_spin(system, point, q, v) result(spin)
      type(system_type), intent(in) :: system
      type(point_type), intent(in) :: point
      real(wp), intent(in) :: q(:), v(:)
      integer :: first, last
      spin = 0.0_wp
      if (point%body == ground) return
      if (.not. system%layout%framed(point%body)) return
      first = system%layout%q(point%body) + 4
      last = first + size(point%psi) - 1
      spin = dot_product(point%psi, v(first:last))
      if (.not. point%exact) spin = spin/(1 + dot_product(point%psi, q(first:last))**2)
      spin = spin + cross(q(first - 2:first - 1), v(first - 2:first - 1))
   end function section_spin

   !> Force or torque of a driver, positive where it drives its coordinate forward.
   pure real(wp) function driver_effort(system, work, driver) result(effort)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      !> Index of the driver in the model
      integer, intent(in) :: driver
      integer :: constraint
      constraint = size(system%model%joints) + driver
      effort = 0.0_wp
      if (system%constraints(constraint)%item%rows == 0) return
      effort = -work%lambda(system%constraints(constraint)%item%first)
      if (system%model%drivers(driver)%kind == driver_angle) effort = effort*work%jacobians(1, constraint)%z(1, 3)
   end function driver_effort

   !> Power that a driver puts in.
   pure real(wp) function driver_power(system, work, driver) result(power)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      integer, intent(in) :: driver
      power = driver_effort(system, work, driver)*work%kinematics%drives(driver)%rate
   end function driver_power

   !> What a coupler exerts on a coordinate of coefficient one, positive where it drives the sum forward.
   pure real(wp) function coupler_effort(system, work, joint) result(effort)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      !> Index of the coupler among the joints of the model
      integer, intent(in) :: joint
      effort = 0.0_wp
      if (system%constraints(joint)%item%rows > 0) effort = -work%lambda(system%constraints(joint)%item%first)
   end function coupler_effort

   !> Power that a coupler puts in whose sum is given in time; none else.
   pure real(wp) function coupler_power(system, work, joint) result(power)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      integer, intent(in) :: joint
      integer :: i
      power = 0.0_wp
      do i = size(system%model%drivers) + 1, size(work%kinematics%drives)
         if (work%kinematics%drives(i)%joint == joint) power = coupler_effort(system, work, joint)*work%kinematics%drives(i)%rate
      end do
   end function coupler_power

   !> Unit vector of the frame of a body as the deck knows it, whose angle the channel `angle` tells: of a piece of a beam and of a
   !> member of a frame that of the whole; of the ground and of a point mass the x axis (2).
   pure function frame_of(system, body, q) result(u)
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      real(wp), intent(in) :: q(:)
      real(wp) :: u(2)
      u = [1.0_wp, 0.0_wp]
      if (body == ground) return
      if (system%model%bodies(body)%whole > 0) then
         u = whole_direction(system, system%model%bodies(body)%whole, q)
      else if (system%layout%framed(body)) then
         u = q(system%layout%q(body) + 2:system%layout%q(body) + 3)
      end if
   end function frame_of

end module limber_output_joint_forces
