!> Kinematic determinacy: whether drivers give all motions, as *KINEMATICS and *INVERSE DYNAMICS need. If not, these are refused
!> before anything runs, where that is known. Floor: scene. Source: doc/theory, eq. (6.1).
module limber_scene_kinematic_determinacy
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_model_model, only: step_kinematics, step_inverse
   use limber_multibody_assembly_newton, only: close_positions, move
   use limber_multibody_constraint_matrix, only: constraint_matrix_type, new_constraint_matrix
   use limber_multibody_free_motions, only: free_motions_type, find_freedom, rate_scales, motion_text
   use limber_multibody_multiplier_system, only: place_constraints
   use limber_scene_scene, only: scene_type
   implicit none
   private
   public :: refuse_undriven, undriven_text

contains

   !> Reports the first analysis that lacks drivers. Behind other analyses the state is not known, and with switches of joints or
   !> drivers neither are the equations: what is missing then is left to the run.
   subroutine refuse_undriven(scene, diagnostics)
      !> With its first state
      type(scene_type), intent(inout) :: scene
      type(diagnostics_type), intent(inout) :: diagnostics
      type(free_motions_type) :: freedom
      integer :: i
      associate (system => scene%system, steps => scene%system%model%steps)
         do i = 1, size(steps)
            if (all(steps(i)%kind /= [step_kinematics, step_inverse])) cycle
            if (i > 1 .and. (any(system%model%joints%switch /= 0) .or. any(system%model%drivers%switch /= 0))) cycle
            call place_constraints(system, scene%work, scene%begin, scene%q)
            call find_freedom(system, scene%work, .true., freedom)
            if (size(freedom%basis, 2) == 0) cycle
            if (i > 1) call look_aside(scene, freedom)
            if (size(freedom%basis, 2) == 0) cycle
            call diagnostics%add(scene%deck%blocks(steps(i)%block)%origin, undriven_text(scene, freedom), &
               & 'drive as many motions as there are degrees of freedom, or use *DYNAMICS')
            return
         end do
      end associate
   end subroutine refuse_undriven

   !> What is left free in other positions too, where the rank of the constraints may be less at the first one alone: the scene is
   !> moved a little along what is free there.
   subroutine look_aside(scene, freedom)
      type(scene_type), intent(inout) :: scene
      !> In, at the first position; out, aside; nothing if no other position is found
      type(free_motions_type), intent(inout) :: freedom
      !> How far: rotations [rad] and ways relative to the scene
      real(wp), parameter :: far = 0.02_wp
      type(constraint_matrix_type) :: frames
      real(wp), allocatable :: step(:), q(:)
      logical :: done
      integer :: i
      associate (system => scene%system)
         ! Fewer equations than rates of frames: so it is in every position
         if (system%layout%nw - sum(system%layout%n) > system%nc) return
         allocate (step(system%layout%nw), source=0.0_wp)
         do i = 1, size(freedom%basis, 2)
            step = step + (modulo(0.618034_wp*i, 1.0_wp) - 0.3_wp)*freedom%basis(:, i)
         end do
         step = far/norm2(step/rate_scales(system))*step
         allocate (q, source=scene%q)
         call move(system, step, q)
         call new_constraint_matrix(system, .false., frames)
         call close_positions(system, scene%work, frames, scene%begin, q, done)
         if (done) then
            call place_constraints(system, scene%work, scene%begin, q)
            call find_freedom(system, scene%work, .true., freedom)
         else
            freedom%basis = freedom%basis(:, :0)
         end if
         call place_constraints(system, scene%work, scene%begin, scene%q)
      end associate
   end subroutine look_aside

   !> What moves although no driver moves it.
   function undriven_text(scene, freedom) result(text)
      type(scene_type), intent(in) :: scene
      !> Its motions, one or more
      type(free_motions_type), intent(in) :: freedom
      character(:), allocatable :: text
      text = as_text(size(freedom%basis, 2))//' drivers are missing: '
      if (size(freedom%basis, 2) == 1) text = 'one driver is missing: '
      text = text//motion_text(scene%system, freedom%basis(:, 1))//' although no driver moves it'
   end function undriven_text

end module limber_scene_kinematic_determinacy
