!> Lasting part of the errors of the rates. The rate of a coordinate on which a fast vibration of small amplitude rides is wrong at
!> once by as much as the vibration's own rate, however little that moves: measured as it is, it binds a method that could step over
!> the vibration to its period. Seen over the time tau of the motion the vibration does not move anything: what is left of the error
!> is the solution of the linearised equations with the step tau. The displacement that the rest makes is an error of the
!> coordinates, and measured there. Only what bends, and springs along themselves, stay stiff: a light body between rods or springs
!> in tension vibrates fast across them as long as these pull; where they let go, its speed is the motion. Floor: integrator.
!> Source: doc/theory, eqs. (5.14), (5.15).
module limber_integrator_lasting_errors
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_integrator_error_scales, only: scales_type
   use limber_model_model, only: ground
   use limber_multibody_force_elements, only: force_element_type
   use limber_multibody_motion_residual, only: place_motion
   use limber_multibody_sparse_matrix, only: sparse_type
   use limber_multibody_springs, only: point_spring_type
   use limber_multibody_system, only: system_type, workspace_type
   use limber_multibody_tangent, only: tangent_type, add_block, combine_values
   use limber_multibody_tangent_products, only: times_mass
   implicit none
   private
   public :: lasting_type, motion_time

   !> Factors for the time of the motion
   type :: lasting_type
      !> Whether what is stiff stays so: behind a stop that lets go a rate lasts that was fast in it
      logical :: usable = .false.
      type(sparse_type), private :: matrix
      !> The time of the factors; zero: there are none of the present derivatives
      real(wp), private :: tau = 0.0_wp
      !> Right-hand side and solution (nw + nc)
      real(wp), allocatable :: part(:)
   contains
      procedure :: prepare, forget, find, exchange => exchange_lasting
   end type lasting_type

contains

   !> Room; behind `new_tangent`, before the first factors.
   subroutine prepare(self, system, tangent)
      class(lasting_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(tangent_type), intent(in) :: tangent
      self%usable = stays_stiff(system)
      self%matrix = tangent%matrix
      allocate (self%part(tangent%matrix%n), source=0.0_wp)
   end subroutine prepare

   !> Whether something is stiff, and no law of places or speeds among the loads.
   pure logical function stays_stiff(system)
      type(system_type), intent(in) :: system
      integer :: i
      stays_stiff = any(system%layout%n > 0)
      do i = 1, size(system%loads)
         select type (item => system%loads(i)%item)
         type is (point_spring_type)
            stays_stiff = .true.
         type is (force_element_type)
            if (.not. item%driven) cycle
            if (.not. any(item%slots > 0)) cycle
            stays_stiff = .false.
            return
         end select
      end do
   end function stays_stiff

   !> The derivatives are others.
   pure subroutine forget(self)
      class(lasting_type), intent(inout) :: self
      self%tau = 0.0_wp
   end subroutine forget

   !> Time in which the motion changes a coordinate by its scale, eq. (5.15).
   pure real(wp) function motion_time(system, scales) result(tau)
      type(system_type), intent(in) :: system
      type(scales_type), intent(in) :: scales
      real(wp) :: rate
      integer :: i
      rate = scales%fastest()/system%model%length
      do i = 1, size(scales%rate)
         if (system%layout%n(i) > 0) rate = max(rate, scales%rate(i)/scales%deflection(i))
      end do
      tau = 1/rate
   end function motion_time

   !> Leaves in `part` what lasts of an error of the rates, eq. (5.14). Kinematics are left at the state where factors are made.
   subroutine find(self, system, work, tangent, t, q, v, tau, rates, found)
      class(lasting_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Derivatives, gathered
      type(tangent_type), intent(in) :: tangent
      !> State at the beginning of the step (nq); time of the motion; errors of the rates (nw)
      real(wp), intent(in) :: t
      real(wp), contiguous, intent(in) :: q(:), v(:)
      real(wp), intent(in) :: tau, rates(:)
      !> False if the equations have no solution: the error is as large as it is
      logical, intent(out) :: found
      !> Factor of the time from which on factors are made anew
      real(wp), parameter :: another = 2.0_wp
      logical :: singular
      found = .true.
      if (self%tau > another*tau .or. another*self%tau < tau) then
         call combine_values(tangent, 1/tau, 1.0_wp, 0.0_wp, tau, tau, self%matrix%values)
         if (size(system%loads) > 0) call place_motion(system, work, t, q, v)
         call add_elasticity(system, work, tangent, tau, self%matrix%values)
         call self%matrix%follow_pivots(tangent%matrix)
         call self%matrix%factor(singular)
         found = .not. singular
         self%tau = 0.0_wp
         if (.not. found) return
         self%tau = tau
      end if
      self%part = 0.0_wp
      call times_mass(system, tangent, 1/self%tau, rates, self%part(:size(rates)))
      call self%matrix%solve(self%part)
   end subroutine find

   !> Adds the stiffness that lasts: of bodies that bend, with what they are held by, and of springs along themselves.
   subroutine add_elasticity(system, work, tangent, factor, values)
      type(system_type), intent(in) :: system
      !> Placed and moved
      type(workspace_type), intent(in) :: work
      !> Derivatives
      type(tangent_type), intent(in) :: tangent
      real(wp), intent(in) :: factor
      !> Of the matrix (entries)
      real(wp), contiguous, intent(inout) :: values(:)
      real(wp), allocatable :: stiffness(:, :)
      integer :: i, m
      do i = 1, size(system%layout%n)
         if (system%layout%n(i) > 0) call add_block(tangent%bodies(i)%place, factor*tangent%bodies(i)%stiffness, values)
      end do
      do i = 1, size(tangent%constraints)
         associate (c => tangent%constraints(i))
            if (size(c%across) == 0 .or. .not. bends(system, system%constraints(i)%item%bodies)) cycle
            call add_block(c%across_place, factor*c%across, values)
            call add_block(c%across_transposed, factor*c%across, values)
         end associate
      end do
      do i = 1, size(system%loads)
         associate (place => tangent%loads(i)%place)
            m = size(place, 1)
            allocate (stiffness(m, m), source=0.0_wp)
            call system%loads(i)%item%add_elasticity(work%kinematics, stiffness)
            call add_block(place, factor*stiffness, values)
            deallocate (stiffness)
         end associate
      end do
   end subroutine add_elasticity

   !> Whether one of some bodies has elastic coordinates.
   pure logical function bends(system, bodies)
      type(system_type), intent(in) :: system
      integer, intent(in) :: bodies(:)
      integer :: i
      bends = .false.
      do i = 1, size(bodies)
         if (bodies(i) == ground) cycle
         if (system%layout%n(bodies(i)) > 0) bends = .true.
      end do
   end function bends

   !> Saves or restores its memory.
   subroutine exchange_lasting(self, snapshot)
      class(lasting_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call self%matrix%exchange(snapshot)
      call snapshot%exchange('lasting_time', self%tau)
      ! Not saved: usable, part
   end subroutine exchange_lasting

end module limber_integrator_lasting_errors
