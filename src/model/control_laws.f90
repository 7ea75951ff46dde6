!> Outputs of controls in laws. Each is replaced by what it is of states and motion, so that a law has the derivatives by all that
!> it depends on; the rates of the states become laws of the bodies that carry them. Floor: model. Source: doc/theory, section
!> 5.21.
module limber_model_control_laws
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, suggestion
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_expression, only: expression_type
   use limber_deck_origin, only: origin_type
   use limber_deck_substitution, only: replacement_type, replace_slots, slot_alone
   use limber_model_controls, only: find_control
   use limber_model_load_parts, only: new_part, set_law, append_part
   use limber_model_model, only: model_type, event_type, along_axis, event_switch, turn_on, turn_off
   implicit none
   private
   public :: insert_outputs, insert_into, append_event

contains

   !> Replaces the outputs in the laws of all loads and events, and adds the laws of the states. All loads and events are in the
   !> model.
   subroutine insert_outputs(model, diagnostics)
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i, k
      integer :: visited(size(model%controls))
      if (size(model%controls) == 0) then
         call complain_without(model, diagnostics)
         return
      end if
      visited = 0
      do i = 1, size(model%controls)
         call find_output(model, i, visited, diagnostics)
      end do
      do i = 1, size(model%load_parts)
         if (model%load_parts(i)%driven) call insert_into(model, model%load_parts(i)%law, diagnostics)
      end do
      do i = 1, size(model%events)
         call insert_into(model, model%events(i)%law, diagnostics)
      end do
      do i = 1, size(model%controls)
         if (model%controls(i)%switch > 0) call add_limits(model, i, diagnostics)
      end do
      do i = 1, size(model%controls)
         do k = 1, size(model%controls(i)%points)
            call add_rate(model, i, k, diagnostics)
         end do
         model%controls(i)%law = model%controls(i)%inputs(1)
         call insert_into(model, model%controls(i)%law, diagnostics)
      end do
   end subroutine insert_outputs

   !> Reports outputs in a deck without controls.
   subroutine complain_without(model, diagnostics)
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i
      do i = 1, size(model%load_parts)
         if (model%load_parts(i)%driven) call insert_into(model, model%load_parts(i)%law, diagnostics)
      end do
      do i = 1, size(model%events)
         call insert_into(model, model%events(i)%law, diagnostics)
      end do
   end subroutine complain_without

   !> Finds the output of a control as a function of states and motion. Outputs that depend on each other at once are an error.
   recursive subroutine find_output(model, control, visited, diagnostics)
      type(model_type), intent(inout) :: model
      integer, intent(in) :: control
      !> Controls whose output is known: -1; that are on the way to this one: their place on it, from 1 (controls)
      integer, intent(inout) :: visited(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i, k, other
      if (visited(control) /= 0) return
      visited(control) = maxval(visited) + 1
      associate (own => model%controls(control))
         do i = 1, size(own%inputs)
            if (.not. depends_on(own%output, i)) cycle
            do k = 1, size(own%inputs(i)%slots)
               if (own%inputs(i)%slots(k)%name /= 'output') cycle
               other = find_control(model, own%inputs(i)%slots(k)%argument)
               if (other == 0) cycle
               if (visited(other) > 0) then
                  call diagnostics%add(own%inputs(i)%slots(k)%origin, 'an algebraic loop: '//way(model, visited, &
                     & visited(other)), 'put a state between, as that of a LAG or HOLD')
                  own%inputs(i)%slots(k)%name = 't'
                  own%inputs(i)%slots(k)%argument = ''
               else
                  call find_output(model, other, visited, diagnostics)
               end if
            end do
         end do
      end associate
      call insert_own(model, control, model%controls(control)%output, diagnostics)
      visited(control) = -1
   end subroutine find_output

   !> Whether the output depends on an input at once.
   pure logical function depends_on(output, input)
      type(expression_type), intent(in) :: output
      integer, intent(in) :: input
      integer :: k
      depends_on = .false.
      do k = 1, size(output%slots)
         if (output%slots(k)%name(1:1) == 'u') depends_on = depends_on .or. number_of(output%slots(k)%name) == input
      end do
   end function depends_on

   !> The number in a name such as u1.
   pure integer function number_of(name) result(number)
      character(*), intent(in) :: name
      read (name(2:), *) number
   end function number_of

   !> What the controls on the way do, from a place on it.
   function way(model, visited, first) result(text)
      type(model_type), intent(in) :: model
      integer, intent(in) :: visited(:), first
      character(:), allocatable :: text
      integer :: place, i
      text = ''
      do place = first, maxval(visited)
         i = findloc(visited, place, dim=1)
         if (text /= '') text = text//', '
         text = text//"'"//model%controls(i)%name//"'"
      end do
      text = text//trim(merge(' depends on itself at once      ', ' depend on each other at once   ', first == maxval(visited)))
   end function way

   !> Replaces inputs and states in a function of a control.
   subroutine insert_own(model, control, law, diagnostics)
      type(model_type), intent(in) :: model
      integer, intent(in) :: control
      type(expression_type), intent(inout) :: law
      type(diagnostics_type), intent(inout) :: diagnostics
      type(replacement_type) :: replacements(size(law%slots))
      type(origin_type) :: origin
      integer :: k, number
      origin = origin_type(file=1)
      do k = 1, size(law%slots)
         number = number_of(law%slots(k)%name)
         origin = law%slots(k)%origin
         if (law%slots(k)%name(1:1) == 's') then
            replacements(k)%by = slot_alone('state', model%controls(control)%name//'.x'//law%slots(k)%name(2:), origin)
         else
            replacements(k)%by = model%controls(control)%inputs(number)
            call insert_into(model, replacements(k)%by, diagnostics)
         end if
      end do
      call replace_all(law, replacements, origin, diagnostics)
   end subroutine insert_own

   !> Replaces the outputs in a law.
   subroutine insert_into(model, law, diagnostics)
      type(model_type), intent(in) :: model
      type(expression_type), intent(inout) :: law
      type(diagnostics_type), intent(inout) :: diagnostics
      type(replacement_type), allocatable :: replacements(:)
      integer :: k, control
      logical :: any_output
      if (.not. allocated(law%slots)) return
      any_output = .false.
      do k = 1, size(law%slots)
         any_output = any_output .or. law%slots(k)%name == 'output'
      end do
      if (.not. any_output) return
      allocate (replacements(size(law%slots)))
      do k = 1, size(law%slots)
         if (law%slots(k)%name /= 'output') cycle
         control = find_control(model, law%slots(k)%argument)
         if (control == 0) call complain_control(model, law%slots(k)%argument, law%slots(k)%origin, diagnostics)
         if (control > 0) replacements(k)%by = model%controls(control)%output
         if (control == 0) replacements(k)%by = slot_alone('t', '', law%slots(k)%origin)
      end do
      call replace_all(law, replacements, law%slots(1)%origin, diagnostics)
   end subroutine insert_into

   !> Replaces slots of a law, and reports what is too long for one.
   subroutine replace_all(law, replacements, origin, diagnostics)
      type(expression_type), intent(inout) :: law
      type(replacement_type), intent(in) :: replacements(:)
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      type(expression_type) :: replaced
      character(:), allocatable :: complaint
      call replace_slots(law, replacements, origin, replaced, complaint)
      if (complaint == '') then
         law = replaced
      else
         call diagnostics%add(origin, 'with the outputs of its controls: '//complaint, 'let a LAG or HOLD stand between them')
      end if
   end subroutine replace_all

   !> Reports an output of no control.
   subroutine complain_control(model, name, origin, diagnostics)
      type(model_type), intent(in) :: model
      character(*), intent(in) :: name
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      character(64) :: names(size(model%controls))
      integer :: i
      do i = 1, size(names)
         names(i) = model%controls(i)%name
      end do
      call diagnostics%add(origin, "there is no control '"//name//"'", suggestion(name, names, 'define it with *CONTROL'), &
         & object=name)
   end subroutine complain_control

   !> Adds the events at which a hysteresis turns on and off.
   subroutine add_limits(model, control, diagnostics)
      type(model_type), intent(inout) :: model
      integer, intent(in) :: control
      type(diagnostics_type), intent(inout) :: diagnostics
      type(event_type) :: event
      integer :: k
      do k = 1, 2
         event = event_type()
         event%name = model%controls(control)%name//trim(merge(' above', ' below', k == 1))
         event%text = 'input less '//as_text(merge(model%controls(control)%most, model%controls(control)%least, k == 1))
         event%law = model%controls(control)%above
         if (k == 2) event%law = model%controls(control)%below
         call insert_own(model, control, event%law, diagnostics)
         event%direction = merge(1, -1, k == 1)
         event%action = event_switch
         event%switch = model%controls(control)%switch
         event%to = merge(turn_on, turn_off, k == 1)
         event%control = control
         call append_event(model, event)
      end do
   end subroutine add_limits

   !> Appends an event. No array constructor: gfortran copies types with deep components badly there.
   subroutine append_event(model, event)
      type(model_type), intent(inout) :: model
      type(event_type), intent(in) :: event
      type(event_type), allocatable :: longer(:)
      integer :: n
      n = size(model%events) + 1
      allocate (longer(n))
      longer(:n - 1) = model%events
      longer(n) = event
      call move_alloc(longer, model%events)
   end subroutine append_event

   !> Adds the rate of a state as a law of the body that carries it, unless it has none.
   subroutine add_rate(model, control, state, diagnostics)
      type(model_type), intent(inout) :: model
      integer, intent(in) :: control, state
      type(diagnostics_type), intent(inout) :: diagnostics
      type(expression_type) :: law
      integer :: n
      if (model%controls(control)%period > 0.0_wp .or. model%controls(control)%switch > 0) return
      law = model%controls(control)%rates(state)
      call insert_own(model, control, law, diagnostics)
      n = size(model%load_parts) + 1
      call append_part(model, new_part(along_axis, model%controls(control)%points(state), 0))
      call set_law(model%load_parts(n), law, 1.0_wp)
      model%load_parts(n)%control = control
   end subroutine add_rate

end module limber_model_control_laws
