!> Mass, damping and stiffness about a state. Mass, damping and stiffness there, and the lowest vibrations. Floor: analysis. Source:
!> doc/theory, eqs. (6.8), (6.10), (6.13), (6.15), (6.16), (6.18).
module limber_analysis_small_motions
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_scene_scene, only: scene_type
   use limber_model_model, only: ground, analysis_step_type
   use limber_multibody_equilibrium, only: equilibrium_type, linearise_balance
   use limber_multibody_free_motions, only: find_freedom, has_potential
   use limber_multibody_driven_motion, only: driven_motion_type, new_held, rest_multipliers
   use limber_multibody_kinematics, only: place_frames, move_frames
   use limber_multibody_motion_laws, only: no_slope_text
   use limber_multibody_sparse_eigenmodes, only: is_large, vectors_for
   use limber_multibody_system, only: system_type
   use limber_multibody_tangent, only: gather
   use limber_multibody_small_vibrations, only: vibrations_type, find_vibrations, find_large_vibrations, add_rotation_damping, &
      & no_damping, gyroscopic, all_damping
   implicit none
   private
   public :: linearise_state, lowest_vibrations, terms, undamped_terms

contains

   !> The lowest vibrations of a scene that is linearised.
   subroutine lowest_vibrations(scene, balance, damping, wanted, beside, vibrations, error)
      type(scene_type), intent(inout) :: scene
      type(equilibrium_type), intent(inout) :: balance
      !> Which velocity terms count
      integer, intent(in) :: damping
      !> How many vibrations, and how many beside them where they cost nothing
      integer, intent(in) :: wanted, beside
      type(vibrations_type), intent(out) :: vibrations
      type(error_type), allocatable, intent(out) :: error
      if (is_large(scene%system) .and. damping == no_damping .and. has_enough(scene%system, wanted) &
         & .and. has_potential(balance%tangent)) then
         call find_large_vibrations(scene%system, balance%tangent, wanted, vibrations, error)
      else
         call find_freedom(scene%system, scene%work, .false., balance%freedom)
         call find_vibrations(scene%system, balance%tangent, balance%freedom, damping, wanted + beside, vibrations, error)
      end if
   end subroutine lowest_vibrations

   !> Whether there are more free motions than ARPACK takes vectors for the wanted modes.
   pure logical function has_enough(system, wanted)
      type(system_type), intent(in) :: system
      integer, intent(in) :: wanted
      has_enough = system%layout%nw - system%nc > vectors_for(wanted)
   end function has_enough

   !> Velocity terms that count.
   pure integer function terms(step, balance)
      type(analysis_step_type), intent(in) :: step
      type(equilibrium_type), intent(in) :: balance
      terms = undamped_terms(balance)
      if (step%damped) terms = all_damping
   end function terms

   !> Those that count whatever damps: of a steady rotation.
   pure integer function undamped_terms(balance) result(terms)
      type(equilibrium_type), intent(in) :: balance
      terms = no_damping
      if (abs(balance%rotation) > 0.0_wp) terms = gyroscopic
   end function undamped_terms

   !> Mass, damping and stiffness at the state: that of a static analysis with its multipliers and rotation; any other at rest.
   subroutine linearise_state(scene, step, balance, balanced, error)
      type(scene_type), intent(inout) :: scene
      type(analysis_step_type), intent(in) :: step
      type(equilibrium_type), intent(inout) :: balance
      !> Whether the state is in equilibrium
      logical, intent(out) :: balanced
      type(error_type), allocatable, intent(out) :: error
      type(driven_motion_type) :: held
      character(:), allocatable :: cause
      logical :: done
      integer :: i
      balanced = .false.
      associate (system => scene%system, work => scene%work, t => step%dynamics%start)
         if (scene%last%balanced) then
            work%lambda = scene%last%lambda
            balance%rotation = scene%last%rotation
            balance%centre = scene%last%centre
         else
            call new_held(system, held)
            call rest_multipliers(system, work, held, t, scene%q, done)
            if (.not. done) then
               call place_frames(system%model, system%layout, t, scene%q, work%kinematics)
               call move_frames(system%model, system%layout, scene%q, 0*scene%q, work%kinematics)
               cause = no_slope_text(system, work%kinematics)
               if (cause == '') cause = ': a constraint is redundant, or a body without mass is free to move'
               call raise(error, 'mass and constraints make a singular system'//cause)
               return
            end if
            work%lambda = held%lambda
         end if
         call linearise_balance(system, work, balance, t, scene%q, work%lambda)
         balanced = .not. maxval(abs(balance%motion*balance%scale)) > 1.0e-6_wp*largest_force(scene, balance)
         if (.not. abs(balance%rotation) > 0.0_wp) return
         do i = 1, size(balance%tangent%bodies)
            call add_rotation_damping(balance%rotation, balance%tangent%bodies(i)%mass, balance%tangent%bodies(i)%damping)
         end do
         call gather(balance%tangent)
      end associate
   end subroutine linearise_state

   !> Largest single force in the scene, in scaled rates, of which a residual is a part: that of all on a body, of a load or of a
   !> constraint. Loads that cancel on a body leave their rounding.
   pure real(wp) function largest_force(scene, balance) result(largest)
      type(scene_type), intent(in) :: scene
      type(equilibrium_type), intent(in) :: balance
      !> Part of the length of the scene of which a millionth is round-off of places
      real(wp), parameter :: places = 1.0e-6_wp
      integer :: i, k, first, side, row, n
      largest = tiny(largest)
      associate (system => scene%system, work => scene%work, scale => balance%scale)
         do i = 1, size(work%bodies)
            first = system%layout%w(i)
            n = system%layout%rates(i)
            largest = max(largest, maxval(abs(work%bodies(i)%force(:n)*scale(first:first + n - 1))))
            ! The inertia of a steady rotation
            associate (mass => balance%tangent%bodies(i)%mass)
               largest = max(largest, maxval(abs(matmul(mass, balance%push(first:first + size(mass, 1) - 1)) &
                  & *scale(first:first + size(mass, 1) - 1))))
            end associate
            ! What round-off of the deflections makes of a stiff body that bears nothing
            associate (stiffness => balance%tangent%bodies(i)%stiffness)
               do k = 1, size(stiffness, 2)
                  largest = max(largest, places*scale(first + k - 1)*maxval(abs(stiffness(:, k)*scale(first:first &
                     & + size(stiffness, 1) - 1))))
               end do
            end associate
         end do
         do i = 1, size(work%loads)
            if (size(work%loads(i)%force) == 0) cycle
            associate (to => balance%tangent%loads(i)%unknowns)
               largest = max(largest, maxval(abs(work%loads(i)%force(:size(to))*scale(to))))
               ! What round-off of the places makes of a stiff load that bears nothing
               do k = 1, size(to)
                  largest = max(largest, places*system%model%length*maxval(abs(balance%tangent%loads(i)%stiffness(:size(to), k) &
                     & *scale(to))))
               end do
            end associate
         end do
         do i = 1, size(system%constraints)
            associate (item => system%constraints(i)%item)
               do side = 1, 2
                  if (item%bodies(side) == ground) cycle
                  first = system%layout%w(item%bodies(side))
                  n = min(3, system%layout%rates(item%bodies(side)))
                  do row = 1, item%rows
                     largest = max(largest, abs(work%lambda(item%first + row - 1)) &
                        & *maxval(abs(work%jacobians(side, i)%z(row, :n)*scale(first:first + n - 1))))
                  end do
               end do
            end associate
         end do
      end associate
   end function largest_force

end module limber_analysis_small_motions
