!> Controls beside the analyses of the deck. Floor: model. Source: doc/theory, section 5.21.
module limber_model_control_checks
   use limber_base_kinds, only: wp
   use limber_deck_content, only: deck_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_model_analyses, only: kind_names
   use limber_model_model, only: model_type, step_dynamics
   implicit none
   private
   public :: check_controls

contains

   !> Reports controls with states beside analyses in which these have no rates, and those whose jumps cannot be compared.
   subroutine check_controls(deck, model, diagnostics)
      type(deck_type), intent(in) :: deck
      type(model_type), intent(in) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i, k
      if (.not. allocated(model%steps)) return
      do i = 1, size(model%controls)
         if (size(model%controls(i)%points) == 0) cycle
         if (model%controls(i)%switch > 0 .and. (model%accuracy%estimate .or. model%accuracy%target > 0.0_wp)) &
            & call diagnostics%add(deck%blocks(model%controls(i)%block)%origin, "control '"//model%controls(i)%name// &
            & "' jumps in a run whose errors are to be estimated: runs in which it jumps at different times cannot be compared"// &
            & ' between them', 'remove *ACCURACY and compare with a run at a tenth of TOLERANCE')
         do k = 1, size(model%steps)
            if (model%steps(k)%kind == step_dynamics) cycle
            call diagnostics%add(deck%blocks(model%steps(k)%block)%origin, '*'//trim(kind_names(model%steps(k)%kind))// &
               & " knows no states of controls, and control '"//model%controls(i)%name//"' has some", &
               & 'use *DYNAMICS, or a control without states in that analysis', deck%blocks(model%controls(i)%block)%origin, &
               & 'the control is here')
            exit
         end do
      end do
   end subroutine check_controls

end module limber_model_control_checks
