!> Contacts of rigid stops: each limit is a contact with a switch of its own, which is on while it is closed, and an event, its
!> touch. What cannot have rigid stops is refused. Floor: model. Source: doc/theory, section 5.22.
module limber_model_rigid_stops
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_deck_compile, only: compile
   use limber_deck_content, only: deck_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_expression, only: expression_type
   use limber_deck_parameters, only: parameter_list_type
   use limber_model_control_laws, only: append_event
   use limber_model_model, only: model_type, limit_contact_type, event_type, switch_type, event_switch, turn_on, step_kinematics, &
      & body_flexible, ground, step_inverse, step_statics, step_modes, step_dynamics
   implicit none
   private
   public :: append_contact, add_touches, check_contacts

contains

   !> Appends a contact at a limit of the last load. No array constructor: gfortran copies types with deep components badly there.
   subroutine append_contact(model, block, name, side, limit, restitution)
      type(model_type), intent(inout) :: model
      !> Index of the stop's block
      integer, intent(in) :: block
      character(*), intent(in) :: name
      !> As in `limit_contact_type`
      integer, intent(in) :: side
      real(wp), intent(in) :: limit, restitution
      type(limit_contact_type), allocatable :: longer(:)
      integer :: n
      n = size(model%contacts) + 1
      allocate (longer(n))
      longer(:n - 1) = model%contacts
      longer(n)%name = name
      longer(n)%load = size(model%loads)
      longer(n)%side = side
      longer(n)%limit = limit
      longer(n)%restitution = restitution
      longer(n)%block = block
      call move_alloc(longer, model%contacts)
   end subroutine append_contact

   !> Adds switch and event of each contact, behind all that the deck has: the gap, eq. (5.85), falls below zero.
   subroutine add_touches(deck, model, diagnostics)
      type(deck_type), intent(in) :: deck
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      type(event_type) :: event
      type(switch_type), allocatable :: longer(:)
      type(parameter_list_type) :: none
      integer :: i, n
      logical :: ok
      do i = 1, size(model%contacts)
         n = size(model%switches) + 1
         allocate (longer(n))
         longer(:n - 1) = model%switches
         longer(n)%name = model%contacts(i)%name
         longer(n)%on = .false.
         call move_alloc(longer, model%switches)
         event = event_type()
         event%name = model%contacts(i)%name
         event%text = gap_text(model, model%contacts(i))
         call compile(event%text, deck%blocks(model%contacts(i)%block)%origin, none, event%law, ok, diagnostics, &
            & quantities=.true.)
         event%direction = -1
         event%action = event_switch
         event%switch = n
         event%to = turn_on
         event%contact = i
         model%contacts(i)%switch = n
         model%contacts(i)%event = size(model%events) + 1
         call append_event(model, event)
      end do
   end subroutine add_touches

   !> The gap as an expression: the elongation of the stop counts from its first limit.
   function gap_text(model, contact) result(text)
      type(model_type), intent(in) :: model
      type(limit_contact_type), intent(in) :: contact
      character(:), allocatable :: text
      real(wp) :: shift
      shift = contact%limit - model%load_parts(model%loads(contact%load)%first)%origin
      text = 'elongation('//model%loads(contact%load)%name//')'
      if (abs(shift) > 0.0_wp) text = text//' - ('//as_text(shift, 17)//')'
      if (contact%side < 0) text = '-('//text//')'
   end function gap_text

   !> Reports rigid stops beside analyses that do not have them, and beside estimates of errors.
   subroutine check_contacts(deck, model, diagnostics)
      type(deck_type), intent(in) :: deck
      type(model_type), intent(in) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      character(17) :: refused
      integer :: i
      if (.not. allocated(model%steps)) return
      refused = refusing(model)
      do i = 1, size(model%contacts)
         if (i > 1) then
            if (model%contacts(i - 1)%block == model%contacts(i)%block) cycle
         end if
         associate (block => deck%blocks(model%contacts(i)%block))
            if (refused /= '') then
               call diagnostics%add(block%origin_of('LAW'), "stop '"//block%name()//"' is rigid, and "//trim(refused)// &
                  & ' has no rigid stops', 'give the stop a STIFFNESS instead of LAW=RIGID, or leave '//trim(refused)// &
                  & ' to a deck without it')
            else if (.not. any(model%steps%kind == step_dynamics)) then
               call diagnostics%add(block%origin_of('LAW'), "stop '"//block%name()//"' is rigid, and the deck has no *DYNAMICS", &
                  & 'rigid stops are those of a motion in time')
            else if (flexible_body(model, model%contacts(i)) > 0) then
               call diagnostics%add(block%origin_of('LAW'), "stop '"//block%name()//"' is rigid and acts on '"// &
                  & model%bodies(flexible_body(model, model%contacts(i)))%name//"', which bends: what an impact on it loses"// &
                  & ' depends on the number of its functions', 'give the stop a STIFFNESS instead of LAW=RIGID')
            else if (model%accuracy%estimate .or. model%accuracy%target > 0.0_wp) then
               call diagnostics%add(block%origin_of('LAW'), "stop '"//block%name()// &
                  & "' is rigid in a run whose errors are to be estimated: runs that strike it at different times cannot be"// &
                  & ' compared between them', 'remove *ACCURACY and compare with a run at a tenth of TOLERANCE')
            end if
         end associate
      end do
   end subroutine check_contacts

   !> Body with functions that a contact acts on; 0: none.
   pure integer function flexible_body(model, contact) result(body)
      type(model_type), intent(in) :: model
      type(limit_contact_type), intent(in) :: contact
      integer :: side
      associate (part => model%load_parts(model%loads(contact%load)%first))
         do side = 1, 2
            body = model%points(part%points(side))%body
            if (body == ground) cycle
            if (model%bodies(body)%kind == body_flexible) return
         end do
      end associate
      body = 0
   end function flexible_body

   !> Keyword of the first analysis that refuses rigid stops; empty if there is none.
   pure function refusing(model) result(keyword)
      type(model_type), intent(in) :: model
      character(17) :: keyword
      integer :: i
      keyword = ''
      do i = size(model%steps), 1, -1
         select case (model%steps(i)%kind)
         case (step_kinematics); keyword = '*KINEMATICS'
         case (step_inverse); keyword = '*INVERSE DYNAMICS'
         case (step_statics); keyword = '*STATICS'
         case (step_modes); keyword = '*MODES'
         end select
      end do
   end function refusing

end module limber_model_rigid_stops
