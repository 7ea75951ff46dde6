!> Scalars of a run: *SCALAR. Expressions of summaries of channels over all samples. Floor: model.
module limber_model_run_scalars
   use limber_base_text, only: lowercase, suggestion
   use limber_deck_content, only: block_type, field_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_expression, only: slot_type
   use limber_deck_operations, only: op_slot
   use limber_model_points, only: find_named
   use limber_model_unit_rules, only: expression_units
   use limber_model_model, only: model_type, scalar_type, dimension_type, summary_names, summary_minimum, summary_maximum, &
      & summary_last
   implicit none
   private
   public :: add_scalars, add_usual_scalars

contains

   !> Adds the scalars of a block. All channels must be in the model.
   subroutine add_scalars(block, model, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      type(scalar_type), allocatable :: longer(:)
      integer :: i, j, count, before
      do i = 1, size(block%lines)
         do j = 1, size(block%lines(i)%fields)
            before = diagnostics%count
            count = size(model%scalars)
            allocate (longer(count + 1))
            longer(:count) = model%scalars
            call fill_scalar(block%lines(i)%fields(j), model, longer(count + 1), diagnostics)
            if (diagnostics%count == before) then
               call move_alloc(longer, model%scalars)
            else
               deallocate (longer)
            end if
         end do
      end do
   end subroutine add_scalars

   !> Adds least, greatest and last value of each channel, if the deck asks for no scalars.
   subroutine add_usual_scalars(model)
      type(model_type), intent(inout) :: model
      integer, parameter :: usual(3) = [summary_minimum, summary_maximum, summary_last]
      integer :: i, k, n
      if (size(model%scalars) > 0) return
      deallocate (model%scalars)
      allocate (model%scalars(size(usual)*size(model%channels)))
      do i = 1, size(model%channels)
         do k = 1, size(usual)
            n = size(usual)*(i - 1) + k
            associate (scalar => model%scalars(n))
               scalar%name = trim(summary_names(usual(k)))//'_'//model%channels(i)%name
               scalar%long_name = trim(summary_names(usual(k)))//'('//model%channels(i)%name//')'
               scalar%units = model%channels(i)%units
               allocate (scalar%expression%codes(1), source=op_slot)
               allocate (scalar%expression%operands(1), source=1)
               allocate (scalar%expression%constants(0), scalar%expression%slots(1))
               allocate (scalar%summaries(1), source=usual(k))
               allocate (scalar%channels(1), source=i)
            end associate
         end do
      end do
   end subroutine add_usual_scalars

   !> Fills a scalar from a field of the deck; reports a repeated name and unknown channels.
   subroutine fill_scalar(field, model, scalar, diagnostics)
      type(field_type), intent(in) :: field
      type(model_type), intent(in) :: model
      type(scalar_type), intent(inout) :: scalar
      type(diagnostics_type), intent(inout) :: diagnostics
      type(dimension_type) :: dimension
      integer :: i
      scalar%expression = field%expression
      scalar%name = field%name
      scalar%long_name = trim(adjustl(field%text))
      associate (slots => field%expression%slots)
         if (scalar%name == '' .and. size(slots) > 0) scalar%name = trim(slots(1)%name)//'_'//trim(slots(1)%argument)
         do i = 1, size(model%scalars)
            if (model%scalars(i)%name == scalar%name) call diagnostics%add(field%origin, &
               & "scalar '"//scalar%name//"' is asked for twice", 'give one of them another name: name = '//scalar%long_name)
         end do
         allocate (scalar%summaries(size(slots)), scalar%channels(size(slots)))
         do i = 1, size(slots)
            call find_summary(slots(i), model, scalar%summaries(i), scalar%channels(i), diagnostics)
         end do
         scalar%units = ''
         if (all(scalar%summaries > 0 .and. scalar%channels > 0)) call expression_units(field%expression, &
            & [(model%channels(scalar%channels(i))%dimension, i=1, size(slots))], model%units, dimension, scalar%units)
      end associate
   end subroutine fill_scalar

   !> Finds kind and channel of a summary such as `max(channel)`; adds an error if there is none.
   subroutine find_summary(slot, model, summary, channel, diagnostics)
      type(slot_type), intent(in) :: slot
      type(model_type), intent(in) :: model
      !> Kind of summary, and index of the channel; 0 if not found
      integer, intent(out) :: summary, channel
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: label
      character(64), allocatable :: names(:)
      integer :: i
      channel = 0
      do summary = size(summary_names), 1, -1
         if (summary_names(summary) == slot%name) exit
      end do
      if (summary == 0) then
         label = 'write first, last, minimum, maximum, mean or rms of (channel)'
         if (slot%argument == '') label = 'a scalar does not depend on the time; '//label
         call diagnostics%add(slot%origin, "'"//trim(slot%name)//"' is no summary of a channel", label)
         return
      end if
      channel = find_named(model, 'channel', lowercase(trim(slot%argument)))
      if (channel > 0) return
      allocate (names(model%counts%channels))
      do i = 1, size(names)
         names(i) = model%channels(i)%name
      end do
      label = suggestion(trim(slot%argument), names, 'channels are those of *OUTPUT')
      call diagnostics%add(slot%origin, "there is no channel '"//trim(slot%argument)//"'", label, &
         & object=trim(slot%argument))
   end subroutine find_summary

end module limber_model_run_scalars
