!> Base type of loads. Its forces on the one or two bodies it acts on, the energy that it stores, the power that it puts in, and its
!> derivatives; and the loads that are given as functions of time. Floor: multibody. Source: doc/theory.
module limber_multibody_load
   use limber_base_kinds, only: wp
   use limber_deck_expression, only: expression_type
   use limber_multibody_kinematics, only: kinematics_type
   use limber_multibody_markers, only: add_marker, marker_stiffness
   implicit none
   private
   public :: load_type, load_item_type, dead_force_type, body_torque_type

   !> A load. Its forces and derivatives are in the independent rates [r'; omega; eta'] of its bodies, stacked one body after the
   !> other; two of them may be the same body.
   type, abstract :: load_type
      !> The bodies it acts on, and those that its force depends on; `ground` where there is none
      integer, allocatable :: bodies(:)
      !> Numbers of their rates, none of the ground; and where those of each begin, less one, when they are stacked
      integer, allocatable :: rates(:), offsets(:)
      !> Points of the model where it acts on them (bodies); 0: none
      integer, allocatable :: points(:)
      !> False if all that it does is in the energy that it stores
      logical :: powered = .true.
      !> Whether it never changes, and may grow from zero in a static analysis; whether it may resist places of its points
      logical :: grows = .false., resists = .false.
      !> Whether it is multiplied at present by a share, as by a static analysis in which it grows, and that
      logical :: is_scaled = .false.
      real(wp) :: share = 1.0_wp
   contains
      !> Forces on the bodies
      procedure(force_interface), deferred :: add_force
      !> Derivatives of minus the forces
      procedure(tangent_interface), deferred :: add_tangent
      !> Power that it puts in beside what it takes from its store
      procedure(energy_interface), deferred :: add_power
      !> Power that its law has somewhere in a step, less that of the force that the step takes
      procedure(missed_interface), deferred :: add_missed_power
      !> The same of the force, of what has no energy
      procedure :: add_missed_force => miss_nothing
      !> The scalar that it acts along, its rate, and the force along it
      procedure(state_interface), deferred :: state_along
      !> Energy that it stores
      procedure :: add_energy => store_nothing
      !> What that may be off by
      procedure :: energy_doubt => doubt_nothing
      !> Stiffness that it has whatever its force is
      procedure :: add_elasticity => stiffen_nothing
      !> Settles from where that is counted
      procedure :: begin_energy => begin_nothing
   end type load_type

   !> One place of a list of loads
   type :: load_item_type
      class(load_type), allocatable :: item
   end type load_item_type

   abstract interface
      !> Adds to the forces (rates); kinematics are placed and moved.
      pure subroutine force_interface(self, kinematics, force)
         import :: load_type, kinematics_type, wp
         class(load_type), intent(in) :: self
         type(kinematics_type), intent(in) :: kinematics
         real(wp), intent(inout) :: force(:)
      end subroutine force_interface

      !> Adds minus the derivatives of the forces by the coordinates (r, rotation, eta) and by the rates, both (rates, rates);
      !> kinematics are placed and moved.
      pure subroutine tangent_interface(self, kinematics, stiffness, damping)
         import :: load_type, kinematics_type, wp
         class(load_type), intent(in) :: self
         type(kinematics_type), intent(in) :: kinematics
         real(wp), intent(inout) :: stiffness(:, :), damping(:, :)
      end subroutine tangent_interface

      !> Adds to an energy, for which kinematics are placed, or to a power, for which they are also moved.
      pure subroutine energy_interface(self, kinematics, sum)
         import :: load_type, kinematics_type, wp
         class(load_type), intent(in) :: self
         type(kinematics_type), intent(in) :: kinematics
         !> [force length], or per time
         real(wp), intent(inout) :: sum
      end subroutine energy_interface

      !> The scalar that a load acts along; kinematics are placed and moved.
      pure subroutine state_interface(self, kinematics, value, rate, push)
         import :: load_type, kinematics_type, wp
         class(load_type), intent(in) :: self
         type(kinematics_type), intent(in) :: kinematics
         !> [length or rad], [per time], [force or force length], positive where it makes the scalar grow; the value is zero where
         !> nobody may ask for it
         real(wp), intent(out) :: value, rate, push
      end subroutine state_interface

      !> Adds to a power. The integral over a step is the work that its forces do not do, whatever the way, if that ends where the
      !> step does.
      pure subroutine missed_interface(self, mean, now, sum)
         import :: load_type, kinematics_type, wp
         class(load_type), intent(in) :: self
         !> Of the step; at an instant of it, placed and moved
         type(kinematics_type), intent(in) :: mean, now
         !> [force length/time]
         real(wp), intent(inout) :: sum
      end subroutine missed_interface
   end interface

   !> A force at a marker along a fixed direction
   type, extends(load_type) :: dead_force_type
      !> Index of the marker
      integer :: marker = 0
      !> What the law is multiplied by (2)
      real(wp) :: direction(2) = 0.0_wp
      !> Function of t [force]
      type(expression_type) :: law
   contains
      procedure :: add_force => force_add_force
      procedure :: add_tangent => force_add_tangent
      procedure :: add_power => force_add_power
      procedure :: add_missed_power => force_add_missed_power
      procedure :: add_missed_force => force_add_missed_force
      procedure :: state_along => force_state
   end type dead_force_type

   !> A torque on the frame of a body
   type, extends(load_type) :: body_torque_type
      !> Function of t [force length], and what it is multiplied by
      type(expression_type) :: law
      real(wp) :: factor = 1.0_wp
   contains
      procedure :: add_force => torque_add_force
      procedure :: add_tangent => torque_add_tangent
      procedure :: add_power => torque_add_power
      procedure :: add_missed_power => torque_add_missed_power
      procedure :: add_missed_force => torque_add_missed_force
      procedure :: state_along => torque_state
   end type body_torque_type

contains

   !> A load whose energy is counted from a state without force.
   pure subroutine begin_nothing(self, kinematics)
      class(load_type), intent(inout) :: self
      !> Placed at the first state
      type(kinematics_type), intent(in) :: kinematics
   end subroutine begin_nothing

   !> The stiffness of a load without material.
   pure subroutine stiffen_nothing(self, kinematics, stiffness)
      class(load_type), intent(in) :: self
      !> Placed
      type(kinematics_type), intent(in) :: kinematics
      !> As that of `add_tangent` (rates, rates)
      real(wp), intent(inout) :: stiffness(:, :)
   end subroutine stiffen_nothing

   !> The energy of a load that stores none.
   pure subroutine store_nothing(self, kinematics, sum)
      class(load_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: sum
   end subroutine store_nothing

   !> The missed force of a load whose force over a step is not that of a law at its mean.
   pure subroutine miss_nothing(self, mean, now, part, force)
      class(load_type), intent(in) :: self
      !> Of the step; at an instant of it, placed and moved
      type(kinematics_type), intent(in) :: mean, now
      !> What it is multiplied by
      real(wp), intent(in) :: part
      !> As that of `add_force` (rates)
      real(wp), intent(inout) :: force(:)
      if (size(force) > 0) force(1) = force(1) + 0*self%rates(1)*part*(now%time - mean%time)
   end subroutine miss_nothing

   !> Doubt of an energy in closed form.
   pure real(wp) function doubt_nothing(self, kinematics) result(doubt)
      class(load_type), intent(in) :: self
      !> Placed
      type(kinematics_type), intent(in) :: kinematics
      doubt = 0*self%share*kinematics%time
   end function doubt_nothing

   pure subroutine force_add_force(self, kinematics, force)
      class(dead_force_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: force(:)
      call add_marker(kinematics%markers(self%marker), force_at(self, kinematics%time), force)
   end subroutine force_add_force

   pure subroutine force_add_tangent(self, kinematics, stiffness, damping)
      class(dead_force_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: stiffness(:, :), damping(:, :)
      call marker_stiffness(kinematics, self%marker, -force_at(self, kinematics%time), stiffness)
   end subroutine force_add_tangent

   pure subroutine force_add_power(self, kinematics, sum)
      class(dead_force_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: sum
      sum = sum + dot_product(force_at(self, kinematics%time), kinematics%markers(self%marker)%velocity)
   end subroutine force_add_power

   pure subroutine force_add_missed_power(self, mean, now, sum)
      class(dead_force_type), intent(in) :: self
      type(kinematics_type), intent(in) :: mean, now
      real(wp), intent(inout) :: sum
      sum = sum + dot_product(force_at(self, now%time) - force_at(self, mean%time), now%markers(self%marker)%velocity)
   end subroutine force_add_missed_power

   pure subroutine force_add_missed_force(self, mean, now, part, force)
      class(dead_force_type), intent(in) :: self
      type(kinematics_type), intent(in) :: mean, now
      real(wp), intent(in) :: part
      real(wp), intent(inout) :: force(:)
      call add_marker(mean%markers(self%marker), part*(force_at(self, now%time) - force_at(self, mean%time)), force)
   end subroutine force_add_missed_force

   pure subroutine force_state(self, kinematics, value, rate, push)
      class(dead_force_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(out) :: value, rate, push
      real(wp) :: time(1)
      time = kinematics%time
      value = 0.0_wp
      rate = dot_product(self%direction, kinematics%markers(self%marker)%velocity)
      push = self%law%evaluate(time)
   end subroutine force_state

   !> Components at a time (2).
   pure function force_at(self, t) result(force)
      class(dead_force_type), intent(in) :: self
      real(wp), intent(in) :: t
      real(wp) :: force(2), time(1)
      time = t
      force = self%law%evaluate(time)*self%direction
   end function force_at

   pure subroutine torque_add_force(self, kinematics, force)
      class(body_torque_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: force(:)
      force(3) = force(3) + torque_at(self, kinematics%time)
   end subroutine torque_add_force

   !> A torque does not depend on the motion.
   pure subroutine torque_add_tangent(self, kinematics, stiffness, damping)
      class(body_torque_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: stiffness(:, :), damping(:, :)
   end subroutine torque_add_tangent

   pure subroutine torque_add_power(self, kinematics, sum)
      class(body_torque_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: sum
      sum = sum + torque_at(self, kinematics%time)*kinematics%frames(self%bodies(1))%omega
   end subroutine torque_add_power

   pure subroutine torque_add_missed_power(self, mean, now, sum)
      class(body_torque_type), intent(in) :: self
      type(kinematics_type), intent(in) :: mean, now
      real(wp), intent(inout) :: sum
      sum = sum + (torque_at(self, now%time) - torque_at(self, mean%time))*now%frames(self%bodies(1))%omega
   end subroutine torque_add_missed_power

   pure subroutine torque_add_missed_force(self, mean, now, part, force)
      class(body_torque_type), intent(in) :: self
      type(kinematics_type), intent(in) :: mean, now
      real(wp), intent(in) :: part
      real(wp), intent(inout) :: force(:)
      force(3) = force(3) + part*(torque_at(self, now%time) - torque_at(self, mean%time))
   end subroutine torque_add_missed_force

   pure subroutine torque_state(self, kinematics, value, rate, push)
      class(body_torque_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(out) :: value, rate, push
      value = 0.0_wp
      rate = kinematics%frames(self%bodies(1))%omega
      push = torque_at(self, kinematics%time)
   end subroutine torque_state

   !> The torque at a time.
   pure real(wp) function torque_at(self, t) result(torque)
      class(body_torque_type), intent(in) :: self
      real(wp), intent(in) :: t
      real(wp) :: time(1)
      time = t
      torque = self%factor*self%law%evaluate(time)
   end function torque_at

end module limber_multibody_load
