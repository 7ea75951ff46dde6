!> Events: a scalar of the motion crosses zero: *EVENT. Floor: elements. Source: doc/theory, section 5.19.
module limber_elements_event
   use limber_deck_content, only: deck_type, block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_schema, only: keyword_type, option_spec_type, field_spec_type, word_spec_type, keyword_rows_type, many, needed, &
      & kind_name, kind_reference, kind_real, kind_counting, kind_word, kind_law, form_fields
   use limber_model_element, only: element_type
   use limber_model_switches, only: find_switch
   use limber_model_model, only: model_type, event_type, event_sample, event_stop, event_end_step, event_switch, &
      & turn_on, turn_off, toggle
   implicit none
   private
   public :: event_element_type, event_element

   type(keyword_type), parameter :: keyword = &
      & keyword_type('EVENT', many, form_fields, 1, 1, &
      &    'An instant of a *DYNAMICS at which a scalar of the motion crosses zero; noted in /events of the results')
   !> Options: kind, values, unit, default, meaning
   type(option_spec_type), parameter :: options(*) = [ &
      & option_spec_type('EVENT', 'NAME', kind_name, 'events', '', needed, 'name of the event'), &
      & option_spec_type('EVENT', 'DIRECTION', kind_word, 'UP|DOWN|BOTH', '', 'BOTH', &
      &    'crossings that count: from below zero to above, from above to below, or both'), &
      & option_spec_type('EVENT', 'ACTION', kind_word, 'SAMPLE|STOP|END STEP|SWITCH', '', 'SAMPLE', &
      &    'what happens there'), &
      & option_spec_type('EVENT', 'SWITCH', kind_reference, 'SWITCH', '', '', 'SWITCH: the switch that it turns', &
      &    only='ACTION=SWITCH'), &
      & option_spec_type('EVENT', 'TO', kind_word, 'ON|OFF|TOGGLE', '', 'ON', &
      &    'SWITCH: the new state; no crossing counts while the switch is in that state; TOGGLE: the other state', &
      &    only='ACTION=SWITCH'), &
      & option_spec_type('EVENT', 'NUMBER', kind_counting, '', '', '1', &
      &    'crossing that acts, of those that count, anew in each *DYNAMICS; SWITCH: that one and all behind it', &
      &    only='ACTION=STOP|END STEP|SWITCH'), &
      & option_spec_type('EVENT', 'AFTER', kind_real, '', 's', '', 'time before which no crossing counts; default: all count')]
   !> Fields of its data lines
   type(field_spec_type), parameter :: fields(*) = [ &
      & field_spec_type('EVENT', 'scalar', kind_law, '', &
      &    'expression of t, places, speeds, angles and joint coordinates, as in laws of loads')]
   !> Words that ACTION takes
   type(word_spec_type), parameter :: words(*) = [ &
      & word_spec_type('EVENT', 'SAMPLE', 'the channels are noted at every crossing; the motion goes on'), &
      & word_spec_type('EVENT', 'STOP', 'the run ends there: the last sample is at the event, and no analysis follows'), &
      & word_spec_type('EVENT', 'SWITCH', 'a switch is turned: the motion goes on with the loads, joints and drivers that act ' &
      &    //'then; velocities jump as by a plastic impact where a joint closes'), &
      & word_spec_type('EVENT', 'END STEP', 'the *DYNAMICS ends there; the next analysis begins with that state')]
   !> An example, as it stands in a deck of the tests
   character(*), parameter :: example(*) = [character(110) :: &
      & '*EVENT, NAME=passage, DIRECTION=UP, AFTER=0.05', &
      & ' y(left-cage) - 0.5*y(right-cage)']

   type, extends(element_type) :: event_element_type
   contains
      procedure :: read
   end type event_element_type

contains

   type(event_element_type) function event_element() result(element)
      element%rows = keyword_rows_type(keyword, options, fields, words, example)
      element%round = 2
      element%switchable = .false.
   end function event_element

   !> Adds an event. The quantities of its scalar are found when all bodies, joints and springs are there.
   subroutine read(self, deck, index, model, diagnostics)
      class(event_element_type), intent(in) :: self
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: index
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      type(event_type) :: event
      associate (block => deck%blocks(index))
         if (size(block%lines) /= 1) return
         event%name = block%name()
         event%text = trim(adjustl(block%lines(1)%fields(1)%text))
         event%law = block%lines(1)%fields(1)%expression
         if (event%law%is_constant()) call diagnostics%add(block%lines(1)%fields(1)%origin, &
            & "the scalar of event '"//event%name//"' is constant: it never crosses zero", &
            & 'write an expression of the time t or of the motion, such as y(ball) - 0.1')
         select case (block%word('DIRECTION'))
         case ('UP'); event%direction = 1
         case ('DOWN'); event%direction = -1
         end select
         select case (block%word('ACTION'))
         case ('STOP'); event%action = event_stop
         case ('END STEP'); event%action = event_end_step
         case ('SWITCH'); event%action = event_switch
         case default; event%action = event_sample
         end select
         call read_switch(block, model, event, diagnostics)
         event%number = block%integer('NUMBER')
         if (block%has('AFTER')) event%after = block%real('AFTER')
      end associate
      model%events = [model%events, event]
   end subroutine read

   !> The switch of an event, and what happens to it.
   subroutine read_switch(block, model, event, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(in) :: model
      type(event_type), intent(inout) :: event
      type(diagnostics_type), intent(inout) :: diagnostics
      if (event%action /= event_switch) return
      if (.not. block%has('SWITCH')) then
         call diagnostics%add(block%origin_of('ACTION'), "event '"//event%name//"' turns no switch", 'add SWITCH=')
         return
      end if
      event%switch = find_switch(model, block%name('SWITCH'))
      select case (block%word('TO'))
      case ('OFF'); event%to = turn_off
      case ('TOGGLE'); event%to = toggle
      case default; event%to = turn_on
      end select
   end subroutine read_switch

end module limber_elements_event
