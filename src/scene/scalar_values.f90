!> Values of the scalars of a run. Floor: scene.
module limber_scene_scalar_values
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, newline
   use limber_model_model, only: model_type, summary_first, summary_last, summary_minimum, summary_maximum, &
      & summary_mean, summary_rms
   use limber_output_sample_sink, only: sink_type
   implicit none
   private
   public :: scalar_values, scalar_lines, scalar_warnings

contains

   !> Values of the scalars (scalars); of a run without a sample those of zeros.
   function scalar_values(model, sink) result(values)
      type(model_type), intent(in) :: model
      class(sink_type), intent(in) :: sink
      real(wp), allocatable :: values(:)
      real(wp), allocatable :: slots(:)
      integer :: i, k
      allocate (values(size(model%scalars)))
      do i = 1, size(values)
         associate (scalar => model%scalars(i))
            allocate (slots(size(scalar%channels)))
            do k = 1, size(slots)
               slots(k) = summary(sink, scalar%summaries(k), scalar%channels(k))
            end do
            values(i) = scalar%expression%evaluate(slots)
            deallocate (slots)
         end associate
      end do
   end function scalar_values

   !> One number of a channel over the samples.
   pure real(wp) function summary(sink, kind, channel) result(value)
      class(sink_type), intent(in) :: sink
      !> One of the kinds of summaries; index of the channel
      integer, intent(in) :: kind, channel
      value = 0.0_wp
      select case (kind)
      case (summary_first); value = sink%first(channel)
      case (summary_last); value = sink%last(channel)
      case (summary_minimum); value = sink%smallest(channel)
      case (summary_maximum); value = sink%largest(channel)
      case (summary_mean); value = sink%mean(channel)
      case (summary_rms); value = sqrt(sink%mean_square(channel))
      end select
   end function summary

   !> A warning for each scalar that has no value, though its channels have theirs.
   function scalar_warnings(model, sink) result(text)
      type(model_type), intent(in) :: model
      class(sink_type), intent(in) :: sink
      character(:), allocatable :: text
      text = each_scalar(model, sink, warning_of)
   end function scalar_warnings

   !> Lines of the report, each behind a line feed.
   function scalar_lines(model, sink) result(text)
      type(model_type), intent(in) :: model
      class(sink_type), intent(in) :: sink
      character(:), allocatable :: text
      text = each_scalar(model, sink, line_of)
   end function scalar_lines

   !> What is said of each scalar, one after another.
   function each_scalar(model, sink, said) result(text)
      type(model_type), intent(in) :: model
      class(sink_type), intent(in) :: sink
      interface
         function said(name, value) result(text)
            import :: wp
            character(*), intent(in) :: name
            real(wp), intent(in) :: value
            character(:), allocatable :: text
         end function said
      end interface
      character(:), allocatable :: text
      real(wp), allocatable :: values(:)
      integer :: i
      text = ''
      allocate (values, source=scalar_values(model, sink))
      do i = 1, size(values)
         text = text//said(model%scalars(i)%name, values(i))
      end do
   end function each_scalar

   function warning_of(name, value) result(text)
      character(*), intent(in) :: name
      real(wp), intent(in) :: value
      character(:), allocatable :: text
      text = ''
      if (abs(value) <= huge(value)) return
      text = "warning: scalar '"//name//"' has no value ("//as_text(value)// &
         & '): a logarithm, root or quotient in it is not defined'//newline
   end function warning_of

   function line_of(name, value) result(text)
      character(*), intent(in) :: name
      real(wp), intent(in) :: value
      character(:), allocatable :: text
      text = newline//'   '//name//' = '//as_text(value, 8)
   end function line_of

end module limber_scene_scalar_values
