!> Quantities in the laws of loads, events and controls. Floor: model.
module limber_model_load_laws
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_expression, only: expression_type
   use limber_deck_origin, only: origin_type
   use limber_model_beam_segments, only: pieces_of, has_frame
   use limber_model_joint_coordinates, only: check_joint_quantity
   use limber_model_model, only: model_type, quantity_type, place_on_beam, own_elongation, own_rate, most_slots
   use limber_model_quantities, only: quantities, quantity_x, quantity_y, quantity_vx, quantity_vy, quantity_angle, &
      & quantity_spin, quantity_u1, quantity_u2, quantity_elongation, quantity_rate, quantity_joint_angle, &
      & quantity_joint_spin, quantity_displacement, quantity_sliding_speed, quantity_output, quantity_state
   use limber_model_requested_channels, only: find_quantity
   implicit none
   private
   public :: resolve_laws

contains

   !> Finds the quantities in the laws of all loads, events and controls. All bodies, joints and springs must be in the model, and
   !> outputs are replaced.
   subroutine resolve_laws(model, diagnostics)
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i, before
      before = diagnostics%count
      do i = 1, size(model%load_parts)
         associate (part => model%load_parts(i))
            if (part%driven) call resolve_law(model, part%law, trim(merge('a control', 'a load   ', part%control > 0)), &
               & part%quantities, diagnostics)
         end associate
      end do
      ! The input of a continuous control is in the laws of its states, where it has been complained of
      do i = 1, size(model%controls)
         if (diagnostics%count > before .and. .not. (model%controls(i)%period > 0.0_wp .or. model%controls(i)%switch > 0)) cycle
         call resolve_law(model, model%controls(i)%law, 'a control', model%controls(i)%quantities, diagnostics)
      end do
      do i = 1, size(model%events)
         if (diagnostics%count > before .and. model%events(i)%control > 0) cycle
         call resolve_law(model, model%events(i)%law, 'an event', model%events(i)%quantities, diagnostics)
      end do
   end subroutine resolve_laws

   !> Finds the quantities of one law.
   subroutine resolve_law(model, law, owner, quantities_of_law, diagnostics)
      type(model_type), intent(in) :: model
      type(expression_type), intent(in) :: law
      !> What depends on them, for messages: 'a load'
      character(*), intent(in) :: owner
      !> One for each variable (slots)
      type(quantity_type), allocatable, intent(inout) :: quantities_of_law(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      type(quantity_type) :: quantity
      integer :: k
      if (size(law%slots) > most_slots) call diagnostics%add(law%slots(1)%origin, 'a law depends on '// &
         & as_text(size(law%slots))//' things', 'at most '//as_text(most_slots))
      allocate (quantities_of_law(size(law%slots)))
      do k = 1, size(law%slots)
         quantity = quantity_type()
         associate (what => law%slots(k))
            if (what%argument == '' .and. what%name == 'x') then
               quantity%kind = own_elongation
            else if (what%argument == '' .and. what%name == 'v') then
               quantity%kind = own_rate
            else
               call find_quantity(what, model, quantity, diagnostics)
               if (quantity%of > 0) call check_quantity(quantity%kind, owner, what%origin, diagnostics)
               if (quantity%of > 0) call check_joint_quantity(model, quantity, what%origin, diagnostics)
               if (quantity%of > 0) call check_frame(model, quantity, owner, what%origin, diagnostics)
            end if
         end associate
         quantities_of_law(k) = quantity
      end do
   end subroutine resolve_law

   !> Reports a quantity that is neither a position nor a velocity.
   subroutine check_quantity(kind, owner, origin, diagnostics)
      integer, intent(in) :: kind
      character(*), intent(in) :: owner
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      integer, parameter :: usable(*) = [quantity_x, quantity_y, quantity_vx, quantity_vy, quantity_angle, quantity_spin, &
         & quantity_u1, quantity_u2, quantity_elongation, quantity_rate, quantity_joint_angle, quantity_joint_spin, &
         & quantity_displacement, quantity_sliding_speed, quantity_output, quantity_state]
      character(:), allocatable :: list
      integer :: i
      if (any(usable == kind)) return
      list = trim(quantities(usable(1))%name)
      do i = 2, size(usable)
         list = list//', '//trim(quantities(usable(i))%name)
      end do
      call diagnostics%add(origin, owner//" cannot depend on '"//trim(quantities(kind)%name)//"'", 'it may depend on '//list)
   end subroutine check_quantity

   !> Reports a coordinate along a beam, and quantities measured from the frame of a beam in segments. Exception: the first piece,
   !> if it carries the frame of the whole.
   subroutine check_frame(model, quantity, owner, origin, diagnostics)
      type(model_type), intent(in) :: model
      type(quantity_type), intent(in) :: quantity
      character(*), intent(in) :: owner
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: body, pieces(2)
      select case (quantity%kind)
      case (quantity_angle, quantity_spin); body = quantity%of
      case (quantity_u1, quantity_u2); body = model%points(quantity%of)%body
      case (quantity_displacement, quantity_sliding_speed)
         if (model%joints(quantity%of)%place == place_on_beam) call diagnostics%add(origin, owner//" cannot depend on '"// &
            & trim(quantities(quantity%kind)%name)//"' of a point that slides along a beam", &
            & 'let it depend on x, y, vx, vy of the point')
         return
      case default; return
      end select
      pieces = pieces_of(model, body)
      if (has_frame(model, body) .and. body == pieces(1)) return
      call diagnostics%add(origin, owner//" cannot depend on '"//trim(quantities(quantity%kind)%name)//"' of a beam in segments", &
         & 'let it depend on x, y, vx, vy of points')
   end subroutine check_frame

end module limber_model_load_laws
