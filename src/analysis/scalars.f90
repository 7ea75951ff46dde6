!> The scalars of a run, from what its sink has kept of the channels. Floor: analysis.
module limber_analysis_scalars
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, newline
   use limber_model_scene, only: model_type, summary_first, summary_last, summary_minimum, summary_maximum, &
      & summary_mean, summary_rms
   use limber_output_sink, only: sink_type
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
      case (summary_mean); value = sink%total(channel)/max(1, sink%taken)
      case (summary_rms); value = sqrt(sink%squares(channel)/max(1, sink%taken))
      end select
   end function summary

   !> A warning for each scalar that has no value, though its channels have theirs.
   function scalar_warnings(model, sink) result(text)
      type(model_type), intent(in) :: model
      class(sink_type), intent(in) :: sink
      character(:), allocatable :: text
      real(wp), allocatable :: values(:)
      integer :: i
      text = ''
      allocate (values, source=scalar_values(model, sink))
      do i = 1, size(values)
         if (abs(values(i)) <= huge(1.0_wp)) cycle
         text = text//"warning: scalar '"//model%scalars(i)%name//"' has no value ("//as_text(values(i))// &
            & '): a logarithm, root or quotient in it is not defined'//newline
      end do
   end function scalar_warnings

   !> Lines of the report, each behind a line feed.
   function scalar_lines(model, sink) result(text)
      type(model_type), intent(in) :: model
      class(sink_type), intent(in) :: sink
      character(:), allocatable :: text
      real(wp), allocatable :: values(:)
      integer :: i
      text = ''
      allocate (values, source=scalar_values(model, sink))
      do i = 1, size(values)
         text = text//newline//'   '//model%scalars(i)%name//' = '//as_text(values(i), 8)
      end do
   end function scalar_lines

end module limber_analysis_scalars
