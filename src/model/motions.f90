!> Prescribed motion of bodies: *MOTION. One driver for each coordinate of the frame's origin and one for its angle; the system
!> solves them without unknowns. Floor: model. Source: doc/theory, eqs. (4.9)-(4.12).
module limber_model_motions
   use limber_deck_content, only: block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_expression, only: expression_type
   use limber_model_points, only: find_named, enter_name
   use limber_model_model, only: model_type, driver_type, body_point, driver_x, driver_y, driver_angle
   use limber_model_beam_segments, only: find_frame
   implicit none
   private
   public :: add_motion

contains

   !> Adds the drivers of a *MOTION. The bodies must be in the model.
   subroutine add_motion(block, model, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: body, origin
      if (size(block%lines) /= 1) return
      body = find_frame(model, block%name('BODY'), block%origin_of('BODY'), diagnostics, &
         & 'weld it to a rigid body and move that, or drive a joint or points of it by *DRIVER')
      if (body == 0) return
      associate (line => block%lines(1), turns => model%bodies(body)%kind /= body_point)
         if (line%count() == 3 .and. .not. turns) then
            call diagnostics%add(line%origin_of(3), "'"//model%bodies(body)%name//"' is a point mass and has no angle", &
               & 'give x and y alone')
            return
         else if (line%count() < 3 .and. turns) then
            call diagnostics%add(line%origin, "motion '"//block%name()//"' gives no angle of body '"//block%name('BODY')// &
               & "'", 'add a third field; to leave it free, use *DRIVER of TYPE=X and TYPE=Y')
            return
         end if
         origin = find_named(model, 'point', block%name('BODY')//'.origin')
         call add('_x', driver_x, line%fields(1)%expression)
         call add('_y', driver_y, line%fields(2)%expression)
         if (turns) call add('_angle', driver_angle, line%fields(3)%expression)
      end associate

   contains

      !> Appends one driver.
      subroutine add(suffix, kind, law)
         character(*), intent(in) :: suffix
         integer, intent(in) :: kind
         type(expression_type), intent(in) :: law
         type(driver_type), allocatable :: longer(:)
         integer :: index
         index = size(model%drivers) + 1
         allocate (longer(index))
         longer(:index - 1) = model%drivers
         call move_alloc(longer, model%drivers)
         associate (driver => model%drivers(index))
            driver%name = block%name()//suffix
            driver%kind = kind
            driver%law = law
            if (kind == driver_angle) then
               driver%body = body
            else
               driver%points(1) = origin
            end if
         end associate
         if (find_named(model, 'driver', model%drivers(index)%name) > 0) call diagnostics%add(block%origin_of('NAME'), &
            & "there is a driver '"//model%drivers(index)%name//"' already", 'choose another name')
         call enter_name(model, 'driver', model%drivers(index)%name, index)
      end subroutine add

   end subroutine add_motion

end module limber_model_motions
