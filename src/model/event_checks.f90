!> Events beside the analyses of the deck: what cannot be, and what has no effect. Floor: model.
module limber_model_event_checks
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_deck_content, only: deck_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_model_analyses, only: single_dynamics
   use limber_model_model, only: model_type, event_sample, event_end_step, event_switch, step_dynamics
   implicit none
   private
   public :: check_events

contains

   !> Reports events without a motion in time, and ends of runs at events whose errors are to be estimated. Events and analyses are
   !> in
   !> the model.
   subroutine check_events(deck, model, diagnostics)
      type(deck_type), intent(in) :: deck
      type(model_type), intent(in) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: block, i
      i = 0
      do block = 1, size(deck%blocks)
         if (deck%blocks(block)%keyword /= 'EVENT' .or. deck%blocks(block)%broken) cycle
         i = i + 1
         if (i > size(model%events)) return
         associate (event => model%events(i), origin => deck%blocks(block)%origin)
            if (.not. any(model%steps%kind == step_dynamics)) then
               call diagnostics%add(origin, "event '"//event%name//"' cannot be met: the deck has no *DYNAMICS", &
                  & 'events are those of a motion in time')
            else if (event%action == event_switch .and. (model%accuracy%estimate .or. model%accuracy%target > 0.0_wp)) then
               call diagnostics%add(deck%blocks(block)%origin_of('ACTION'), "event '"//event%name// &
                  & "' turns a switch in a run whose errors are to be estimated: runs that turn it at different times"// &
                  & ' cannot be compared between them', 'remove *ACCURACY and compare with a run at a tenth of TOLERANCE')
            else if (event%action /= event_sample .and. (model%accuracy%estimate .or. model%accuracy%target > 0.0_wp)) then
               call diagnostics%add(deck%blocks(block)%origin_of('ACTION'), "event '"//event%name// &
                  & "' ends a run whose errors are to be estimated: runs that end at different times cannot be compared", &
                  & 'use ACTION=SAMPLE, or remove *ACCURACY and compare with a run at a tenth of TOLERANCE')
            else if (event%action == event_end_step .and. single_dynamics(model)) then
               call diagnostics%warn(deck%blocks(block)%origin_of('ACTION'), "event '"//event%name//"' ends the only analysis", &
                  & 'ACTION=STOP means the same here')
            else if (event%after >= maxval(model%steps%dynamics%end, model%steps%kind == step_dynamics)) then
               call diagnostics%warn(deck%blocks(block)%origin_of('AFTER'), "event '"//event%name// &
                  & "' counts no crossing: AFTER is not before the end of the last *DYNAMICS, t = "// &
                  & as_text(maxval(model%steps%dynamics%end, model%steps%kind == step_dynamics)), 'give an earlier time')
            end if
         end associate
      end do
   end subroutine check_events

end module limber_model_event_checks
