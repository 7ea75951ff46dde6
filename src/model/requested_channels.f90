!> Channels of *OUTPUT with their units. Finds the quantities of their expressions in the model. Floor: model.
module limber_model_requested_channels
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, lowercase, nearest_name, suggestion
   use limber_deck_content, only: block_type, field_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_expression, only: slot_type
   use limber_deck_operations, only: function_names
   use limber_model_control_laws, only: insert_into
   use limber_model_controls, only: find_control, find_state
   use limber_model_joint_coordinates, only: warn_of_kept
   use limber_model_lists, only: append
   use limber_model_points, only: find_point, find_body, find_named, enter_name
   use limber_model_quantities, only: quantities, of_point, of_body, of_beam_point, of_beam, of_joint, of_driver, of_spring, &
      & of_system, of_translational, of_turner, of_pusher, of_powered, quantity_elongation, quantity_rate, &
      & of_flexible_point, of_section, of_coupler, of_control, of_state, of_contact, quantity_output, &
      & quantity_stress_top, quantity_stress_bottom, &
      & quantity_kinetic, quantity_potential, quantity_work, quantity_lost
   use limber_model_unit_rules, only: expression_units
   use limber_model_references, only: find_reference, warn_of_zero
   use limber_model_model, only: model_type, body_type, channel_type, quantity_type, dimension_type, body_point, &
      & body_flexible, ground, coordinate_displacement, driver_angle, driver_joint_angle
   implicit none
   private
   public :: add_channels, check_expressions, check_studied, find_quantity, flexible_instead

   !> Dimension of an energy: exponents of length, time and mass
   integer, parameter :: energy(3) = [2, -2, 1]

contains

   !> Adds the channels of an *OUTPUT block, and the request for motion records.
   subroutine add_channels(block, model, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i, j, before
      type(channel_type) :: channel
      model%motion = model%motion .or. block%yes('MOTION')
      if (size(block%lines) == 0 .and. .not. (block%yes('MOTION') .or. block%has('ENVELOPE'))) call diagnostics%add( &
         & block%origin, '*OUTPUT asks for nothing', 'add lines of channels below it, or MOTION=YES, or ENVELOPE=')
      do i = 1, size(block%lines)
         do j = 1, size(block%lines(i)%fields)
            before = diagnostics%count
            call new_channel(block%lines(i)%fields(j), model, channel, diagnostics)
            if (diagnostics%count > before) then
               call diagnostics%tell(channel%name)
               cycle
            end if
            call append(model%channels, model%counts%channels, channel)
            call enter_name(model, 'channel', lowercase(channel%name), model%counts%channels)
         end do
      end do
   end subroutine add_channels

   !> Reports unknown quantities and objects in named expressions, whether these are used or not.
   subroutine check_expressions(block, model, diagnostics)
      !> *EXPRESSION
      type(block_type), intent(in) :: block
      type(model_type), intent(in) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      type(quantity_type) :: unused
      integer :: i, j, k
      do i = 1, size(block%lines)
         do j = 1, size(block%lines(i)%fields)
            do k = 1, size(block%lines(i)%fields(j)%expression%slots)
               call find_quantity(block%lines(i)%fields(j)%expression%slots(k), model, unused, diagnostics)
            end do
         end do
      end do
   end subroutine check_expressions

   !> Reports channels of a study that *OUTPUT does not ask for.
   subroutine check_studied(block, model, diagnostics)
      !> *STUDY
      type(block_type), intent(in) :: block
      type(model_type), intent(in) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      character(64) :: names(model%counts%channels)
      integer :: i, k
      do i = 1, size(names)
         names(i) = model%channels(i)%name
      end do
      do i = 1, size(block%lines)
         if (block%lines(i)%text(1) /= 'channels') cycle
         do k = 2, block%lines(i)%count()
            if (find_named(model, 'channel', lowercase(block%lines(i)%text(k))) > 0) cycle
            call diagnostics%add(block%lines(i)%origin_of(k), "there is no channel '"//block%lines(i)%text(k)//"'", &
               & suggestion(block%lines(i)%text(k), names, 'channels are those of *OUTPUT'), object=block%lines(i)%text(k))
         end do
      end do
   end subroutine check_studied

   !> Makes a channel from a field of the deck.
   subroutine new_channel(field, model, channel, diagnostics)
      type(field_type), intent(in) :: field
      type(model_type), intent(in) :: model
      type(channel_type), intent(out) :: channel
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i
      channel%expression = field%expression
      channel%name = field%name
      channel%long_name = trim(adjustl(field%text))
      if (channel%name == '') channel%name = default_name(field)
      if (field%name == '' .and. find_named(model, 'channel', channel%name) > 0) call diagnostics%add(field%origin, &
         & "channel '"//channel%name//"' is asked for twice", 'give one of them another name: name = '//channel%long_name)
      allocate (channel%quantities(size(field%expression%slots)))
      do i = 1, size(channel%quantities)
         call find_quantity(field%expression%slots(i), model, channel%quantities(i), diagnostics)
      end do
      if (any(channel%quantities%of < 0)) return
      call expression_units(channel%expression, slot_dimensions(channel%quantities), model%units, channel%dimension, channel%units)
      call find_reference(model, channel)
      call warn_of_zero(model, field, channel, diagnostics)
      do i = 1, size(channel%quantities)
         call warn_of_kept(model, channel%quantities(i), field%expression%slots(i), diagnostics)
      end do
      if (.not. any(channel%quantities%kind == quantity_output)) return
      call insert_into(model, channel%expression, diagnostics)
      deallocate (channel%quantities)
      allocate (channel%quantities(size(channel%expression%slots)))
      do i = 1, size(channel%quantities)
         call find_quantity(channel%expression%slots(i), model, channel%quantities(i), diagnostics)
      end do
   end subroutine new_channel

   !> Name of a channel without a given name: x(rod.middle) becomes x_rod_middle.
   pure function default_name(field) result(name)
      type(field_type), intent(in) :: field
      character(:), allocatable :: name
      integer :: i
      if (size(field%expression%slots) > 0) then
         name = field%expression%slots(1)%name
         if (field%expression%slots(1)%argument /= '') name = name//'_'//field%expression%slots(1)%argument
      else
         name = 'constant'
      end if
      do i = 1, len(name)
         if (scan(name(i:i), '.-') > 0) name(i:i) = '_'
      end do
   end function default_name

   !> Reports an unknown quantity or function.
   subroutine complain_quantity(slot, diagnostics)
      type(slot_type), intent(in) :: slot
      type(diagnostics_type), intent(inout) :: diagnostics
      character(24) :: names(size(quantities) + size(function_names))
      character(:), allocatable :: label
      integer :: near, i
      names(:size(quantities)) = quantities%name
      names(size(quantities) + 1:) = function_names
      near = nearest_name(slot%name, names)
      if (near > 0) then
         label = "did you mean '"//trim(names(near))//"'?"
      else
         label = 'functions:'
         do i = 1, size(function_names)
            label = label//' '//trim(function_names(i))
         end do
         label = label//'; quantities: limber help OUTPUT'
      end if
      call diagnostics%add(slot%origin, "there is no quantity or function '"//slot%name//"'", label, object=slot%name)
   end subroutine complain_quantity

   !> Finds the quantity of a variable (slot) of an expression. Adds an error and leaves `of` -1 or 0 if there is none.
   subroutine find_quantity(slot, model, quantity, diagnostics)
      type(slot_type), intent(in) :: slot
      type(model_type), intent(in) :: model
      type(quantity_type), intent(out) :: quantity
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i
      quantity%of = -1
      if (slot%argument == '') then
         quantity%of = 0
         quantity%dimension = [0, 1, 0]
         return
      end if
      do i = size(quantities), 1, -1
         if (quantities(i)%name == slot%name) exit
      end do
      quantity%kind = i
      if (i > 0) quantity%dimension = quantities(i)%dimension
      if (i > 0) quantity%angular = quantities(i)%angular
      if (quantity%kind == 0) then
         call complain_quantity(slot, diagnostics)
         return
      end if
      select case (quantities(quantity%kind)%of)
      case (of_point)
         quantity%of = find_point(model, slot%argument, slot%origin, diagnostics)
      case (of_beam_point)
         quantity%of = find_point(model, slot%argument, slot%origin, diagnostics)
         if (quantity%of > 0) call need_beam(model, model%points(quantity%of)%body, slot, quantity, diagnostics)
      case (of_flexible_point, of_section)
         quantity%of = find_point(model, slot%argument, slot%origin, diagnostics)
         if (quantity%of > 0) call need_section(model, slot, quantity, diagnostics)
      case (of_body, of_beam)
         quantity%of = find_body(model, slot%argument)
         if (quantity%of == 0) then
            call diagnostics%add(slot%origin, "there is no body '"//slot%argument//"'", body_list(model), object=slot%argument)
         else if (quantities(quantity%kind)%of == of_beam) then
            call need_beam(model, quantity%of, slot, quantity, diagnostics)
         else if (model%bodies(quantity%of)%kind == body_point) then
            call diagnostics%add(slot%origin, "'"//slot%argument//"' is a point mass and has no angle")
         end if
      case (of_joint, of_pusher)
         i = find_named(model, 'joint', slot%argument)
         quantity%of = i
         if (i == 0 .and. quantities(quantity%kind)%of == of_pusher) call find_load(model, slot, model%loads%holds_sections, &
            & quantity)
         if (quantity%of == 0) then
            call diagnostics%add(slot%origin, "there is no joint '"//slot%argument//"'", of_section_instead(model, slot), &
               & object=slot%argument)
         else if (quantity%of_load) then
            return
         else if (model%joints(quantity%of)%is_coupler()) then
            call diagnostics%add(slot%origin, "'"//slot%argument//"' is a coupler, which has no "//slot%name, &
               & slot%name//' is a quantity of joints')
         end if
      case (of_driver, of_turner, of_powered)
         i = find_named(model, 'driver', slot%argument)
         quantity%of = i
         if (i == 0 .and. quantities(quantity%kind)%of == of_turner) call find_load(model, slot, model%loads%angular, quantity)
         if (i == 0 .and. quantities(quantity%kind)%of == of_powered) &
            & call find_load(model, slot, [(.true., i=1, size(model%loads))], quantity)
         if (quantity%of == 0 .and. quantities(quantity%kind)%of == of_powered) call find_coupler(model, slot, quantity)
         if (quantity%of_coupler) return
         if (quantity%of == 0) then
            call diagnostics%add(slot%origin, "there is no driver '"//slot%argument//"'", object=slot%argument)
         else if (.not. quantity%of_load) then
            call check_effort(model%drivers(quantity%of)%kind, slot, diagnostics)
         end if
      case (of_coupler)
         quantity%of = 0
         call find_coupler(model, slot, quantity)
         if (quantity%of == 0) then
            call diagnostics%add(slot%origin, "there is no coupler '"//slot%argument//"'", object=slot%argument)
         else if (size(model%joints(quantity%of)%terms) > 0) then
            if (model%joints(quantity%of)%terms(1)%kind == coordinate_displacement) quantity%dimension(1) = 1
         end if
      case (of_control)
         quantity%of = find_control(model, slot%argument)
         if (quantity%of == 0) call complain_control(model, slot, 'control', diagnostics)
      case (of_state)
         quantity%of = find_state(model, slot%argument)
         if (quantity%of == 0) call complain_control(model, slot, 'state', diagnostics)
      case (of_spring)
         call find_load(model, slot, model%loads%stretches, quantity)
         if (quantity%of == 0) call diagnostics%add(slot%origin, "there is no spring '"//slot%argument//"'", object=slot%argument)
      case (of_translational)
         call find_load(model, slot, model%loads%stretches .and. .not. model%loads%angular, quantity)
         if (quantity%of == 0) call diagnostics%add(slot%origin, "there is no spring '"//slot%argument//"'", object=slot%argument)
      case (of_contact)
         call find_load(model, slot, [(any(model%contacts%load == i), i=1, size(model%loads))], quantity)
         if (quantity%of == 0) call diagnostics%add(slot%origin, "there is no rigid stop '"//slot%argument//"'", &
            & object=slot%argument)
      case (of_system)
         quantity%of = 0
         if (slot%argument /= 'system') call diagnostics%add(slot%origin, "'"//slot%name//"' is asked of the whole", &
            & 'write '//slot%name//'(system)')
      end select
   end subroutine find_quantity

   !> Reports a control or state that is none, with the nearest name, or the states that there are.
   subroutine complain_control(model, slot, what, diagnostics)
      type(model_type), intent(in) :: model
      type(slot_type), intent(in) :: slot
      !> 'control' or 'state'
      character(*), intent(in) :: what
      type(diagnostics_type), intent(inout) :: diagnostics
      character(64) :: names(size(model%controls))
      character(:), allocatable :: label, name
      integer :: i, control
      do i = 1, size(names)
         names(i) = model%controls(i)%name
      end do
      name = slot%argument(:index(slot%argument//'.', '.') - 1)
      control = find_control(model, name)
      label = suggestion(name, names, 'controls are defined by *CONTROL')
      if (control > 0) label = "write the name of the control alone: output("//name//')'
      if (control > 0 .and. what == 'state') then
         label = "control '"//name//"' has no states"
         if (size(model%controls(control)%points) == 1) label = 'it has one state: write state('//name//'.x1)'
         if (size(model%controls(control)%points) > 1) label = 'its states are x1 to x'// &
            & as_text(size(model%controls(control)%points))//': write state('//name//'.x1)'
      end if
      call diagnostics%add(slot%origin, 'there is no '//what//" '"//slot%argument//"'", label, object=slot%argument)
   end subroutine complain_control

   !> Finds the coupler of this name. Without one, `quantity` is unchanged.
   subroutine find_coupler(model, slot, quantity)
      type(model_type), intent(in) :: model
      type(slot_type), intent(in) :: slot
      type(quantity_type), intent(inout) :: quantity
      integer :: i
      i = find_named(model, 'joint', slot%argument)
      if (i == 0) return
      if (.not. model%joints(i)%is_coupler()) return
      quantity%of = i
      quantity%of_coupler = .true.
   end subroutine find_coupler

   !> Reports the force of a driver of an angle, or the torque of a driver of a length.
   subroutine check_effort(kind, slot, diagnostics)
      !> Kind of the driver
      integer, intent(in) :: kind
      type(slot_type), intent(in) :: slot
      type(diagnostics_type), intent(inout) :: diagnostics
      logical :: angular
      angular = kind == driver_angle .or. kind == driver_joint_angle
      if (slot%name == 'force' .and. angular) call diagnostics%add(slot%origin, "driver '"//slot%argument//"' drives an angle", &
         & 'write torque('//slot%argument//')')
      if (slot%name == 'torque' .and. .not. angular) call diagnostics%add(slot%origin, "driver '"//slot%argument// &
         & "' drives a length", 'write force('//slot%argument//')')
   end subroutine check_effort

   !> Hint for a joint quantity that was asked of a point: the section force to ask instead; empty if there is none.
   pure function of_section_instead(model, slot) result(label)
      type(model_type), intent(in) :: model
      type(slot_type), intent(in) :: slot
      character(:), allocatable :: label
      character(*), parameter :: joints(4) = [character(7) :: 'moment', 'force_1', 'force_2', 'torque']
      character(*), parameter :: sections(4) = [character(14) :: 'bending_moment', 'axial_force', 'shear_force', 'bending_moment']
      integer :: dot, k
      label = ''
      dot = index(slot%argument, '.')
      k = findloc(joints == slot%name, .true., dim=1)
      if (dot == 0 .or. k == 0) return
      if (find_body(model, slot%argument(:dot - 1)) == 0) return
      label = 'that of a section of a beam or frame is '//trim(sections(k))//'('//slot%argument//')'
   end function of_section_instead

   !> Finds the load of this name among those that have the quantity; `of` is 0 if there is none. Elongation and rate of a
   !> rotational spring are
   !> angles.
   subroutine find_load(model, slot, suits, quantity)
      type(model_type), intent(in) :: model
      type(slot_type), intent(in) :: slot
      !> Whether it has the quantity (loads)
      logical, intent(in) :: suits(:)
      type(quantity_type), intent(inout) :: quantity
      integer :: i
      do i = size(model%loads), 1, -1
         if (model%loads(i)%name == slot%argument .and. suits(i)) exit
      end do
      quantity%of = i
      if (i == 0) return
      quantity%of_load = .true.
      if (.not. model%loads(i)%angular) return
      quantity%angular = quantity%kind == quantity_elongation .or. quantity%kind == quantity_rate
      if (quantity%angular) quantity%dimension(1) = 0
   end subroutine find_load

   !> Reports a body that is no beam.
   subroutine need_beam(model, body, slot, quantity, diagnostics)
      type(model_type), intent(in) :: model
      integer, intent(in) :: body
      type(slot_type), intent(in) :: slot
      type(quantity_type), intent(inout) :: quantity
      type(diagnostics_type), intent(inout) :: diagnostics
      if (body /= ground) then
         if (model%bodies(body)%end_point > 0) return
      end if
      quantity%of = -1
      call diagnostics%add(slot%origin, "'"//slot%argument//"' is not on a beam", slot%name//' is a quantity of beams')
   end subroutine need_beam

   !> Reports a point that is not on a beam or frame, or without section forces.
   subroutine need_section(model, slot, quantity, diagnostics)
      type(model_type), intent(in) :: model
      type(slot_type), intent(in) :: slot
      type(quantity_type), intent(inout) :: quantity
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: point
      point = quantity%of
      if (model%points(point)%member == 0) then
         quantity%of = -1
         call diagnostics%add(slot%origin, "'"//slot%argument//"' is not on a beam or frame", &
            & slot%name//' is a quantity of beams and frames')
         return
      end if
      if (quantities(quantity%kind)%of /= of_section) return
      associate (body => model%bodies(model%points(point)%body))
         if (body%kind /= body_flexible) then
            quantity%of = -1
            call diagnostics%add(slot%origin, "'"//body%name//"' is rigid: its internal forces are not computed", &
               & flexible_instead(body), object=body%name)
         else if (model%points(point)%meeting /= 1) then
            quantity%of = -1
            call diagnostics%add(slot%origin, as_text(model%points(point)%meeting)//" members meet at '"//slot%argument//"'", &
               & 'name a point of one of them in a data line of *FRAME: point, member, coordinate')
         else if (any(quantity%kind == [quantity_stress_top, quantity_stress_bottom]) .and. &
            & .not. all(body%strength(3:4, model%points(point)%member) > 0.0_wp)) then
            quantity%of = -1
            call diagnostics%add(slot%origin, "the section of '"//body%name//"' does not say where its extreme fibres are", &
               & 'add TOP= and BOTTOM= to its *SECTION')
         end if
      end associate
   end subroutine need_section

   !> Options of a rigid body for section forces.
   pure function flexible_instead(body) result(text)
      type(body_type), intent(in) :: body
      character(:), allocatable :: text
      text = 'use GEOMETRIC=EXACT, K_G or LINEAR'
      if (body%is_frame) text = 'use GEOMETRIC=K_G or LINEAR, or LARGE=YES'
   end function flexible_instead

   !> Names of the first bodies, for a message.
   pure function body_list(model) result(text)
      type(model_type), intent(in) :: model
      character(:), allocatable :: text
      integer, parameter :: most = 30
      integer :: i, named
      text = 'bodies:'
      named = 0
      do i = 1, size(model%bodies)
         if (model%bodies(i)%control > 0) cycle
         named = named + 1
         if (named <= most) text = text//' '//model%bodies(i)%name
      end do
      if (named > most) text = text//' ... '//as_text(named)//' in all'
   end function body_list

   !> Dimensions of quantities (quantities).
   pure function slot_dimensions(asked) result(slots)
      type(quantity_type), intent(in) :: asked(:)
      type(dimension_type) :: slots(size(asked))
      integer :: i
      do i = 1, size(asked)
         slots(i)%exponents = asked(i)%dimension
         slots(i)%turns = merge(1, 0, asked(i)%angular)
         ! The gains of a control may have any unit
         if (asked(i)%kind > 0) slots(i)%open = any(quantities(asked(i)%kind)%of == [of_control, of_state])
         slots(i)%moment = all(asked(i)%dimension == energy) .and. .not. asked(i)%angular .and. &
            & all(asked(i)%kind /= [quantity_kinetic, quantity_potential, quantity_work, quantity_lost])
      end do
   end function slot_dimensions

end module limber_model_requested_channels
