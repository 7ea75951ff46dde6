!> Switches of the model: one by its name, and what asks for one. Floor: model. Source: doc/theory, section 5.20.
module limber_model_switches
   use limber_deck_content, only: block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_model_model, only: model_type
   implicit none
   private
   public :: find_switch, set_switch, first_states, acts

contains

   !> Index of a switch by its name; 0 if there is none.
   pure integer function find_switch(model, name) result(found)
      type(model_type), intent(in) :: model
      character(*), intent(in) :: name
      do found = size(model%switches), 1, -1
         if (model%switches(found)%name == name) return
      end do
   end function find_switch

   !> States of all switches at the start (switches): whether each is on.
   pure function first_states(model) result(on)
      type(model_type), intent(in) :: model
      logical, allocatable :: on(:)
      allocate (on(0))
      if (allocated(model%switches)) on = model%switches%on
   end function first_states

   !> Whether something acts that asks for a switch, or for none.
   pure logical function acts(switch, on)
      !> Its index, negative where it acts while that is off; 0: none
      integer, intent(in) :: switch
      !> States of all switches
      logical, intent(in) :: on(:)
      acts = .true.
      if (switch /= 0) acts = on(abs(switch)) .eqv. switch > 0
   end function acts

   !> Lets what a block has added to the model ask for its switch.
   subroutine set_switch(block, joints, drivers, parts, model, diagnostics)
      type(block_type), intent(in) :: block
      !> Numbers of joints, drivers and parts of loads before
      integer, intent(in) :: joints, drivers, parts
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: switch
      if (block%has('ACTIVE') .and. block%has('INACTIVE')) then
         call diagnostics%add(block%origin_of('INACTIVE'), "'"//block%name()//"' asks for two switches", &
            & 'remove ACTIVE or INACTIVE')
         return
      end if
      switch = 0
      if (block%has('ACTIVE')) switch = find_switch(model, block%name('ACTIVE'))
      if (block%has('INACTIVE')) switch = -find_switch(model, block%name('INACTIVE'))
      if (switch == 0) return
      model%joints(joints + 1:model%counts%joints)%switch = switch
      model%drivers(drivers + 1:)%switch = switch
      model%load_parts(parts + 1:)%switch = switch
   end subroutine set_switch

end module limber_model_switches
