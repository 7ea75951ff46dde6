!> Reference of the quantities of flexible bodies. Text of the attribute `measured_from` of their channels, and the warning of
!> quantities that are always zero. Floor: model.
module limber_model_references
   use limber_deck_content, only: field_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_model_quantities, only: quantity_deflection, quantity_u1, quantity_u2, quantity_rotation, quantity_angle, &
      & quantity_spin
   use limber_model_model, only: model_type, body_type, channel_type, quantity_type, body_flexible, ground
   implicit none
   private
   public :: find_reference, warn_of_zero

contains

   !> Sets the references of the quantities of a channel, with semicolons between them; empty if no quantity has one.
   subroutine find_reference(model, channel)
      type(model_type), intent(in) :: model
      type(channel_type), intent(inout) :: channel
      character(:), allocatable :: text
      integer :: i
      channel%reference = ''
      do i = 1, size(channel%quantities)
         call describe(model, channel%quantities(i), text)
         if (text == '' .or. index(channel%reference, text) > 0) cycle
         if (channel%reference /= '') channel%reference = channel%reference//'; '
         channel%reference = channel%reference//text
      end do
   end subroutine find_reference

   !> Text of the reference of one quantity; empty if it has none.
   subroutine describe(model, quantity, text)
      type(model_type), intent(in) :: model
      type(quantity_type), intent(in) :: quantity
      character(:), allocatable, intent(out) :: text
      integer :: body
      text = ''
      call find_flexible(model, quantity, body)
      if (body == ground) return
      associate (own => model%bodies(body))
         if (quantity%kind == quantity_deflection) then
            text = 'the line through both ends'
         else if (own%whole > 0) then
            text = 'the line through both ends'
            if (model%wholes(own%whole)%clamped) text = 'the section at the start'
            if (allocated(model%wholes(own%whole)%member_numbers)) text = 'the section at the start of member 1'
         else if (own%is_frame) then
            text = 'what *BOUNDARY holds'
            if (all(own%mesh%free)) text = 'the mean motion'
         else if (own%reduced%is_exact) then
            text = 'the section at the start'
            if (abs(own%choice%origin) > 0) text = 'the section at ORIGIN'
         else if (own%choice%support%theta_start) then
            text = 'the section at the start'
         else if (own%choice%support%w_start) then
            text = 'the line through both ends'
         else
            text = 'the mean motion'
         end if
         if (own%whole > 0) then
            text = text//" of '"//model%wholes(own%whole)%name//"'"
         else
            text = text//" of '"//own%name//"'"
         end if
      end associate
   end subroutine describe

   !> Flexible body of a quantity measured from its frame or chord; `ground` for all other quantities.
   subroutine find_flexible(model, quantity, body)
      type(model_type), intent(in) :: model
      type(quantity_type), intent(in) :: quantity
      integer, intent(out) :: body
      body = ground
      if (quantity%of <= 0) return
      if (any(quantity%kind == [quantity_deflection, quantity_u1, quantity_u2, quantity_rotation])) then
         body = model%points(quantity%of)%body
      else if (any(quantity%kind == [quantity_angle, quantity_spin])) then
         body = quantity%of
      end if
      if (body == ground) return
      if (model%bodies(body)%kind /= body_flexible) body = ground
   end subroutine find_flexible

   !> Warns of quantities that are always zero, because they are measured from their own place.
   subroutine warn_of_zero(model, field, channel, diagnostics)
      type(model_type), intent(in) :: model
      !> Field of the channel in the deck
      type(field_type), intent(in) :: field
      type(channel_type), intent(in) :: channel
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: text
      integer :: i
      do i = 1, size(channel%quantities)
         if (.not. is_zero(model, channel%quantities(i))) cycle
         call describe(model, channel%quantities(i), text)
         associate (slot => field%expression%slots(i))
            call diagnostics%warn(slot%origin, trim(slot%name)//'('//trim(slot%argument)//') is 0 whatever happens: it is'// &
               & ' measured from '//text, &
               & trim(merge('u2 is measured from the frame of the body: limber help OUTPUT', &
               & 'x and y are places in space: limber help OUTPUT              ', &
               & channel%quantities(i)%kind == quantity_deflection)))
         end associate
      end do
   end subroutine warn_of_zero

   !> Whether a quantity is measured from its own place.
   logical function is_zero(model, quantity)
      type(model_type), intent(in) :: model
      type(quantity_type), intent(in) :: quantity
      integer :: body
      is_zero = .false.
      call find_flexible(model, quantity, body)
      if (body == ground .or. any(quantity%kind == [quantity_angle, quantity_spin])) return
      associate (own => model%bodies(body))
         if (own%is_frame) return
         if (quantity%kind == quantity_deflection) then
            is_zero = any(quantity%of == [own%start_point, own%end_point])
         else if (own%whole > 0) then
            return
         else if (own%reduced%is_exact) then
            is_zero = .not. abs(model%points(quantity%of)%along - own%choice%origin) > 0
         else if (own%choice%support%theta_start) then
            is_zero = quantity%of == own%start_point
         else if (quantity%kind == quantity_u2 .and. own%choice%support%w_start) then
            is_zero = any(quantity%of == [own%start_point, own%end_point])
         end if
      end associate
   end function is_zero

end module limber_model_references
