!> Kinematic determinacy: whether drivers give all motions, as *KINEMATICS and *INVERSE DYNAMICS need. If not, these are refused
!> before anything runs, where that is known. Floor: scene. Source: doc/theory, eq. (6.1).
module limber_scene_kinematic_determinacy
   use limber_base_text, only: as_text
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_model_model, only: step_kinematics, step_inverse
   use limber_multibody_free_motions, only: free_motions_type, find_freedom, motion_text
   use limber_multibody_multiplier_system, only: place_constraints
   use limber_scene_scene, only: scene_type
   implicit none
   private
   public :: refuse_undriven, undriven_text

contains

   !> Reports the first analysis that lacks drivers. Behind other analyses the state is not known, and only the number of equations
   !> counts: if there are fewer than motions of frames, drivers are missing, unless a switch changes the equations.
   subroutine refuse_undriven(scene, diagnostics)
      !> With its first state
      type(scene_type), intent(inout) :: scene
      type(diagnostics_type), intent(inout) :: diagnostics
      type(free_motions_type) :: freedom
      integer :: i
      associate (system => scene%system, steps => scene%system%model%steps)
         do i = 1, size(steps)
            if (all(steps(i)%kind /= [step_kinematics, step_inverse])) cycle
            if (i > 1 .and. (size(system%model%switches) > 0 .or. system%layout%nw - sum(system%layout%n) <= system%nc)) cycle
            call place_constraints(system, scene%work, scene%begin, scene%q)
            call find_freedom(system, scene%work, .true., freedom)
            if (size(freedom%basis, 2) == 0) cycle
            call diagnostics%add(scene%deck%blocks(steps(i)%block)%origin, undriven_text(scene, freedom), &
               & 'drive as many motions as there are degrees of freedom, or use *DYNAMICS')
            return
         end do
      end associate
   end subroutine refuse_undriven

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
