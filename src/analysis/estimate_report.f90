!> Report of an error estimate. Datasets beside the channels of the results file, a table for the user, and warnings. Floor:
!> analysis; estimate -> file and text.
module limber_analysis_estimate_report
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text, newline
   use limber_scene_channel_errors, only: magnitude, widening
   use limber_analysis_error_estimate, only: estimate_type
   use limber_model_model, only: channel_type
   use limber_output_history, only: history_type
   use limber_output_sample_sink, only: memory_type
   implicit none
   private
   public :: record_estimate, estimate_warning, estimate_table

   !> Group of the file that holds the estimates, and attribute of a channel with the path of its own
   character(*), parameter :: group = 'error_estimate'
   !> What the estimates are not
   character(*), parameter :: excluded = 'not in them: what modes, elements and k_G elements leave out, which limber study shows'
   !> Width of a column of the table
   integer, parameter :: width = 13

contains

   !> Writes the estimates beside the channels, and how they were made. If there are none, the group has no datasets, and its
   !> attribute status says why.
   subroutine record_estimate(estimate, channels, history, error)
      type(estimate_type), intent(in) :: estimate
      type(channel_type), intent(in) :: channels(:)
      !> With all samples
      type(history_type), intent(inout) :: history
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: row(:, :)
      integer :: i
      call history%put_group('/'//group, error)
      if (.not. allocated(error)) call put_method()
      if (allocated(error) .or. estimate%reason /= '') return
      allocate (row(1, size(estimate%values, 2)))
      do i = 1, size(channels)
         row(1, :) = estimate%values(i, :)
         call history%put_beside(group, channels(i)%name, row, channels(i)%units, &
            & trim(merge('verified absolute error of                         ', &
            & 'estimated absolute error of the time integration of', estimate%of_model))//' '//channels(i)%name, error)
         if (.not. allocated(error)) call history%put_attribute('/'//group//'/'//channels(i)%name, 'shrinkage', &
            & estimate%ratio(i), error)
         if (allocated(error)) return
      end do

   contains

      subroutine put_method()
         character(:), allocatable :: status
         status = estimate%reason
         if (status == '') status = 'made'
         call history%put_attribute('/'//group, 'status', status, error)
         if (estimate%of_model) then
            if (.not. allocated(error)) call history%put_attribute('/'//group, 'method', &
               & 'verified: difference from a finer run, of more functions and at companion_tolerance, over neighbouring'// &
               & ' samples, and the error that this run is taken to have', error)
         else if (.not. allocated(error)) then
            call history%put_attribute('/'//group, 'method', &
               & 'paired runs: difference to a run at companion_tolerance, enlarged by 1/(1 - shrinkage) and over neighbouring'// &
               & ' samples, not below round-off; shrinkage from a run at check_tolerance', error)
         end if
         if (.not. (allocated(error) .or. estimate%of_model)) call history%put_attribute('/'//group, 'excluded', excluded, error)
         if (.not. allocated(error) .and. leaves_out(estimate)) call history%put_attribute('/'//group, 'excluded', &
            & 'not in them: the model of '//estimate%without, error)
         if (.not. allocated(error)) call history%put_attribute('/'//group, 'companion_tolerance', estimate%companion, error)
         if (.not. allocated(error)) call history%put_attribute('/'//group, 'check_tolerance', estimate%check, error)
         if (.not. allocated(error)) call history%put_attribute('/'//group, 'cpu_seconds', estimate%cpu, error)
         if (.not. allocated(error)) call history%put_attribute('/'//group, 'cpu_factor', estimate%factor, error)
      end subroutine put_method

   end subroutine record_estimate

   !> Why there is no estimate, or which errors do not shrink; empty if all is well.
   function estimate_warning(estimate, channels) result(text)
      type(estimate_type), intent(in) :: estimate
      type(channel_type), intent(in) :: channels(:)
      character(:), allocatable :: text, names
      integer :: i
      text = ''
      if (estimate%reason /= '') then
         text = 'warning: no estimate of the errors: the run at TOLERANCE='//as_text(estimate%companion, 3)// &
            & ' that it takes has failed: '//estimate%reason//newline
         return
      end if
      if (.not. any(estimate%alarming)) return
      names = ''
      do i = 1, size(channels)
         if (.not. estimate%alarming(i)) cycle
         if (names /= '') names = names//', '
         names = names//channels(i)%name
      end do
      text = 'warning: the errors do not shrink from TOLERANCE='//as_text(estimate%check, 3)//' to '// &
         & as_text(estimate%companion, 3)//': '//names//'; their estimates are '//as_text(widening(1.0_wp), 2)// &
         & ' times the difference of two runs and may be too small; give a smaller TOLERANCE'//newline
   end function estimate_warning

   !> A line for each channel: largest value, value at the end, estimated error, and that relative to the largest value, unless it
   !> is zero within round-off.
   function estimate_table(estimate, channels, samples) result(text)
      type(estimate_type), intent(in) :: estimate
      type(channel_type), intent(in) :: channels(:)
      type(memory_type), intent(in) :: samples
      character(:), allocatable :: text
      !> Ratio from which a channel is the small difference of large terms
      real(wp), parameter :: terms = 10.0_wp
      real(wp) :: largest, worst, scale
      integer :: i, first
      text = ''
      if (estimate%reason /= '') return
      first = maxval([7, (len(channels(i)%name), i=1, size(channels))])
      text = '   estimated errors of the time integration, from runs at TOLERANCE='//as_text(estimate%companion, 3)
      if (estimate%of_model) text = '   verified errors, from finer runs, at TOLERANCE='//as_text(estimate%companion, 3)
      if (leaves_out(estimate)) text = '   errors without that of the model of '//estimate%without// &
         & ', from finer runs, at TOLERANCE='//as_text(estimate%companion, 3)
      if (estimate%check > 0.0_wp) text = text//' and '//as_text(estimate%check, 3)
      text = text//', '//as_text(estimate%cpu, 3)//' s CPU'
      if (estimate%of_model) then
         text = text//', '//as_text(estimate%factor, 2)//' times the counted work of the run itself:'
      else
         text = text//' or '//as_text(estimate%factor, 2)//' times the run itself:'
      end if
      text = text//newline//'      '//left('channel', first)//right('largest')//right('at the end')//right('error')// &
         & right('relative')
      do i = 1, size(channels)
         largest = maxval(abs(samples%values(i, :samples%samples)))
         worst = maxval(estimate%values(i, :))
         text = text//newline//'      '//left(channels(i)%name, first)//right(as_text(largest, 6))// &
            & right(as_text(samples%values(i, samples%samples), 6))//right(as_text(worst, 2))
         scale = magnitude(samples%values(i, :samples%samples))
         if (allocated(estimate%scale)) scale = max(scale, estimate%scale(i))
         if (estimate%zero(i)) then
            text = text//right('-')//'  zero within round-off'
            cycle
         end if
         text = text//right(as_text(worst/scale, 2))
         if (allocated(estimate%scale)) then
            if (scale > terms*largest) text = text//'  of its terms'
         end if
         if (estimate%stuck(i)) text = text//'  does not shrink'
      end do
      if (.not. estimate%of_model) text = text//newline//'      '//excluded
   end function estimate_table

   !> A text filled up to a length.
   pure function left(cell, length) result(text)
      character(*), intent(in) :: cell
      integer, intent(in) :: length
      character(length) :: text
      text = cell
   end function left

   !> A number at the right of its column.
   pure function right(cell) result(text)
      character(*), intent(in) :: cell
      character(:), allocatable :: text
      text = repeat(' ', max(1, width - len(cell)))//cell
   end function right

   !> Whether a model is left out of the verification.
   pure logical function leaves_out(estimate)
      type(estimate_type), intent(in) :: estimate
      leaves_out = .false.
      if (allocated(estimate%without)) leaves_out = len(estimate%without) > 0
   end function leaves_out

end module limber_analysis_estimate_report
