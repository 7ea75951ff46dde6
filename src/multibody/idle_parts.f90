!> Joints, drivers and loads whose switch does not let them act. One stands in the list in the place of its own, and keeps that one
!> until it acts again: a constraint without equations, a load without force and energy. Floor: multibody. Source: doc/theory,
!> section 5.20.
module limber_multibody_idle_parts
   use limber_base_kinds, only: wp
   use limber_multibody_constraint, only: constraint_type, jacobian_type
   use limber_multibody_kinematics, only: kinematics_type
   use limber_multibody_load, only: load_type
   implicit none
   private
   public :: idle_constraint_type, idle_load_type, set_constraint, set_load

   !> A constraint without equations
   type, extends(constraint_type) :: idle_constraint_type
      !> The one that acts when it is switched
      class(constraint_type), allocatable :: own
   contains
      procedure :: residual => no_residual
      procedure :: jacobian => no_jacobian
      procedure :: stiffness => no_stiffness
      procedure :: drift => no_drift
      procedure :: gamma => no_rate
   end type idle_constraint_type

   !> A load without force
   type, extends(load_type) :: idle_load_type
      !> The one that acts when it is switched
      class(load_type), allocatable :: own
   contains
      procedure :: add_force => no_force
      procedure :: add_tangent => no_tangent
      procedure :: add_power => no_power
      procedure :: add_missed_power => no_missed_power
      procedure :: state_along => idle_state
      procedure :: begin_energy => idle_begin_energy
   end type idle_load_type

contains

   !> Lets a constraint of a list act, or not.
   subroutine set_constraint(item, acts)
      class(constraint_type), allocatable, intent(inout) :: item
      logical, intent(in) :: acts
      class(constraint_type), allocatable :: own
      type(idle_constraint_type), allocatable :: idle
      select type (item)
      type is (idle_constraint_type)
         if (acts) call move_alloc(item%own, own)
      class default
         if (.not. acts) then
            allocate (idle)
            idle%label = item%label
            idle%bodies = item%bodies
            idle%points = item%points
            idle%scale = item%scale
            idle%part_of = item%part_of
         end if
      end select
      if (allocated(own)) call move_alloc(own, item)
      if (.not. allocated(idle)) return
      call move_alloc(item, idle%own)
      call move_alloc(idle, item)
   end subroutine set_constraint

   !> Lets a load of a list act, or not.
   subroutine set_load(item, acts)
      class(load_type), allocatable, intent(inout) :: item
      logical, intent(in) :: acts
      class(load_type), allocatable :: own
      type(idle_load_type), allocatable :: idle
      select type (item)
      type is (idle_load_type)
         if (acts) call move_alloc(item%own, own)
      class default
         if (.not. acts) then
            allocate (idle)
            allocate (idle%bodies, source=item%bodies)
            allocate (idle%rates, source=item%rates)
            allocate (idle%offsets, source=item%offsets)
            allocate (idle%points, source=item%points)
            idle%powered = .false.
         end if
      end select
      if (allocated(own)) call move_alloc(own, item)
      if (.not. allocated(idle)) return
      call move_alloc(item, idle%own)
      call move_alloc(idle, item)
   end subroutine set_load

   pure subroutine no_residual(self, kinematics, phi)
      class(idle_constraint_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: phi(:)
   end subroutine no_residual

   pure subroutine no_rate(self, kinematics, rate)
      class(idle_constraint_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: rate(:)
   end subroutine no_rate

   pure subroutine no_jacobian(self, kinematics, first, second)
      class(idle_constraint_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      type(jacobian_type), intent(inout) :: first, second
   end subroutine no_jacobian

   pure subroutine no_stiffness(self, kinematics, lambda, first, second, across)
      class(idle_constraint_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(in) :: lambda(:)
      real(wp), intent(inout) :: first(:, :), second(:, :), across(:, :)
   end subroutine no_stiffness

   pure subroutine no_drift(self, kinematics, first, second)
      class(idle_constraint_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: first(:, :), second(:, :)
   end subroutine no_drift

   pure subroutine no_force(self, kinematics, force)
      class(idle_load_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: force(:)
   end subroutine no_force

   pure subroutine no_tangent(self, kinematics, stiffness, damping)
      class(idle_load_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: stiffness(:, :), damping(:, :)
   end subroutine no_tangent

   pure subroutine no_power(self, kinematics, sum)
      class(idle_load_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: sum
   end subroutine no_power

   pure subroutine no_missed_power(self, mean, now, sum)
      class(idle_load_type), intent(in) :: self
      type(kinematics_type), intent(in) :: mean, now
      real(wp), intent(inout) :: sum
   end subroutine no_missed_power

   !> Settles from where the energy of the one that does not act yet is counted.
   pure subroutine idle_begin_energy(self, kinematics)
      class(idle_load_type), intent(inout) :: self
      type(kinematics_type), intent(in) :: kinematics
      call self%own%begin_energy(kinematics)
   end subroutine idle_begin_energy

   !> The scalar that it would act along, and no force.
   pure subroutine idle_state(self, kinematics, value, rate, push)
      class(idle_load_type), intent(in) :: self
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(out) :: value, rate, push
      call self%own%state_along(kinematics, value, rate, push)
      push = 0.0_wp
   end subroutine idle_state

end module limber_multibody_idle_parts
