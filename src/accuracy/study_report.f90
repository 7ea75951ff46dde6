!> Report of a study. The runs as a table, what each part of the error comes from, and a sentence of advice. Floor: accuracy; runs
!> -> text.
module limber_accuracy_study_report
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, newline
   use limber_accuracy_study_plan, only: plan_type, setting_type, control, axes, axis_integrator, axis_modes, &
      & axis_elements, axis_fidelity, finest
   use limber_accuracy_study_reference, only: reference_type
   use limber_accuracy_study_runs, only: run_type, median, slope
   implicit none
   private
   public :: heading, grid_table, time_table, family_table, advice, failures

   !> Width of a column of numbers; digits of a tolerance that is a tenth of another one
   integer, parameter :: width = 12, digits = 12

contains

   !> Deck, reference and how well it is known. The finest model has nothing finer to be compared with: only the warnings of its run
   !> tell of its errors.
   function heading(plan, reference) result(text)
      type(plan_type), intent(in) :: plan
      type(reference_type), intent(in) :: reference
      character(:), allocatable :: text, warnings
      integer :: i
      text = 'Study of '//plan%path//': '//plan%heading//newline//'Reference: '//reference%source
      if (reference%uncertainty > 0.0_wp) text = text//' to '//as_text(reference%uncertainty, 2)//', that is '// &
         & as_text(floor(-log10(reference%uncertainty)))//' digits'
      if (reference%of_deck) then
         text = text//newline//'The reference has the finest model of the study'//at_finest(plan, 0)//': errors of that model'// &
            & ' itself are in no table'
         warnings = ''
         if (allocated(reference%warnings)) warnings = warnings_of(reference%warnings)
         if (warnings == '') then
            text = text//'; its run warns of none'
         else
            text = text//'. Its run warns, so that it is no measure of the truth:'//warnings
         end if
      end if
      text = text//newline//'Errors are relative to the largest magnitude of each channel:'
      do i = 1, size(plan%names)
         if (i > 1) text = text//','
         text = text//' '//trim(plan%names(i))
      end do
   end function heading

   !> The warnings of a run, each from its word on to the end of the line, once, behind line feeds.
   function warnings_of(lines, told) result(text)
      character(*), intent(in) :: lines
      !> Text whose warnings are left out
      character(*), intent(in), optional :: told
      character(:), allocatable :: text, line
      character(*), parameter :: word = 'warning: '
      integer :: first, last, at
      text = ''
      first = 1
      do while (first <= len(lines))
         last = index(lines(first:), newline)
         if (last == 0) last = len(lines) - first + 2
         line = lines(first:first + last - 2)
         first = first + last
         at = index(line, word)
         if (at == 0) cycle
         line = newline//'  '//line(at:)
         if (index(text//newline, line//newline) > 0) cycle
         if (present(told)) then
            if (index(told//newline, line//newline) > 0) cycle
         end if
         text = text//line
      end do
   end function warnings_of

   !> All runs of the grid.
   function grid_table(plan, runs) result(text)
      type(plan_type), intent(in) :: plan
      type(run_type), intent(in) :: runs(:)
      character(:), allocatable :: text
      integer :: i
      text = '  '//setting_header(plan)//right('CPU ms')//right('whole ms')//right('steps')//right('evaluations')// &
         & right('error')//right('at the end')//right('constraints')//right('energy')//right('repeats')
      do i = 1, size(runs)
         text = text//newline//merge('* ', '  ', runs(i)%on_front)//setting_cells(plan, runs(i)%setting)
         if (runs(i)%reason == '') then
            text = text//milliseconds(median(runs(i)%cpu))//milliseconds(median(runs(i)%whole))// &
               & right(as_text(runs(i)%steps))//right(as_text(runs(i)%evaluations))// &
               & right(as_text(runs(i)%error, 2))//right(as_text(runs(i)%error_at_end, 2))// &
               & right(as_text(runs(i)%constraints, 2))//right(as_text(runs(i)%energy, 2))//right(as_text(size(runs(i)%cpu)))
         else
            text = text//'  failed: '//runs(i)%reason
         end if
      end do
      text = text//newline//'* no other run is both faster and more accurate; what another one beats at less than half its'// &
         & ' time is not repeated'
   end function grid_table

   !> Name of what controls the steps.
   pure function control_name(plan) result(name)
      type(plan_type), intent(in) :: plan
      character(:), allocatable :: name
      name = 'tolerance'
      if (plan%has_steps) name = 'step'
   end function control_name

   !> Word before it in the advice: tolerances need none.
   pure function step_word(plan) result(word)
      type(plan_type), intent(in) :: plan
      character(:), allocatable :: word
      word = ''
      if (plan%has_steps) word = 'steps of '
   end function step_word

   !> Names of the axes that are varied, and the integrator.
   function setting_header(plan) result(text)
      type(plan_type), intent(in) :: plan
      character(:), allocatable :: text
      text = left('integrator')//right(control_name(plan))
      if (size(plan%axis(axis_fidelity)%values) > 0) text = text//level_header(plan, axis_fidelity)
      if (size(plan%axis(axis_modes)%values) > 0) text = text//level_header(plan, axis_modes)
      if (size(plan%axis(axis_elements)%values) > 0) text = text//level_header(plan, axis_elements)
   end function setting_header

   function setting_cells(plan, setting) result(text)
      type(plan_type), intent(in) :: plan
      type(setting_type), intent(in) :: setting
      character(:), allocatable :: text
      text = left(trim(setting%integrator))//right(as_text(control(setting)))//level_cell(plan, setting, axis_fidelity)// &
         & level_cell(plan, setting, axis_modes)//level_cell(plan, setting, axis_elements)
   end function setting_cells

   !> Name of an axis of the model above its column: that of its list, but of fidelities one.
   function level_header(plan, which) result(text)
      type(plan_type), intent(in) :: plan
      integer, intent(in) :: which
      character(:), allocatable :: text
      text = plan%axis(which)%name
      if (which == axis_fidelity) text = 'fidelity'
      text = repeat(' ', max(0, width - 2 - len(text)))//'  '//text
   end function level_header

   !> Value of an axis of the model, below its name.
   function level_cell(plan, setting, which) result(text)
      type(plan_type), intent(in) :: plan
      type(setting_type), intent(in) :: setting
      integer, intent(in) :: which
      character(:), allocatable :: text
      text = ''
      if (setting%level(which) == 0) return
      text = trim(plan%axis(which)%texts(setting%level(which)))
      text = repeat(' ', max(1, len(level_header(plan, which)) - len(text)))//text
   end function level_cell

   !> Time discretisation alone: runs of the grid with the finest model, error of each channel, and observed order.
   function time_table(plan, reference, runs) result(text)
      type(plan_type), intent(in) :: plan
      type(reference_type), intent(in) :: reference
      type(run_type), intent(in) :: runs(:)
      character(:), allocatable :: text
      integer :: i, k
      logical :: of_model(size(runs))
      of_model = [(is_finest(plan, runs(i)%setting), i=1, size(runs))]
      text = 'Error of the time discretisation'//at_finest(plan, 0)//':'//newline//'  '//left('integrator')// &
         & right(control_name(plan))//right('CPU ms')//channel_header(plan)
      do i = 1, size(runs)
         if (.not. of_model(i)) cycle
         text = text//newline//'  '//left(trim(runs(i)%setting%integrator))//right(as_text(control(runs(i)%setting)))// &
            & error_cells(plan, runs(i))
      end do
      do k = 1, size(plan%axis(axis_integrator)%values)
         text = text//newline//'  '//order_line(plan, trim(plan%axis(axis_integrator)%texts(k)), reference, &
            & pack(runs, of_model .and. [(runs(i)%setting%level(axis_integrator) == k, i=1, size(runs))]))
      end do
   end function time_table

   !> How the error follows the tolerance, or the step: then it is the order.
   function order_line(plan, name, reference, runs) result(text)
      type(plan_type), intent(in) :: plan
      character(*), intent(in) :: name
      type(reference_type), intent(in) :: reference
      type(run_type), intent(in) :: runs(:)
      character(:), allocatable :: text
      logical :: fits(size(runs))
      integer :: i
      ! Neither too coarse to converge nor as good as the reference
      fits = [(runs(i)%reason == '' .and. runs(i)%error < 0.1_wp .and. runs(i)%error > 3*reference%uncertainty, &
         & i=1, size(runs))]
      if (count(fits) < 2) then
         text = name//': no two runs to see an order from'
      else
         text = name//': error ~ '//control_name(plan)//'^'//as_text(slope(pack(log(control(runs%setting)), fits), &
            & pack(log(max(runs%error, tiny(1.0_wp))), fits)), 2)//', from '//as_text(count(fits))//' runs'
      end if
   end function order_line

   !> Whether a setting has the finest model.
   pure logical function is_finest(plan, setting)
      type(plan_type), intent(in) :: plan
      type(setting_type), intent(in) :: setting
      integer :: i
      is_finest = .true.
      do i = axis_modes, axes
         is_finest = is_finest .and. setting%level(i) == finest(plan, i)
      end do
   end function is_finest

   !> One axis varied alone.
   function family_table(plan, which, fine, runs) result(text)
      type(plan_type), intent(in) :: plan
      integer, intent(in) :: which
      type(setting_type), intent(in) :: fine
      type(run_type), intent(in) :: runs(:)
      character(:), allocatable :: text
      integer :: i
      text = 'Error of the '//plan%axis(which)%name//at_finest(plan, which)//', '//trim(fine%integrator)//' at '// &
         & as_text(fine%tolerance, digits)//':'//newline//'  '//level_header(plan, which)//right('CPU ms')//channel_header(plan)
      do i = 1, size(runs)
         text = text//newline//'  '//level_cell(plan, runs(i)%setting, which)
         if (i == finest(plan, which) .and. runs(i)%reason == '') then
            text = text//milliseconds(median(runs(i)%cpu))//right('reference')
         else
            text = text//error_cells(plan, runs(i))
         end if
      end do
   end function family_table

   !> ' with 3 bending modes and 12 geometric elements': the finest values of all axes of the model but one.
   function at_finest(plan, but) result(text)
      type(plan_type), intent(in) :: plan
      integer, intent(in) :: but
      character(:), allocatable :: text
      type(setting_type) :: setting
      integer :: i
      do i = axis_modes, axes
         if (i /= but) setting%level(i) = finest(plan, i)
      end do
      text = model_text(plan, setting)
   end function at_finest

   !> ' with 5 bending modes and 2 geometric elements and K_G'
   function model_text(plan, setting) result(text)
      type(plan_type), intent(in) :: plan
      type(setting_type), intent(in) :: setting
      character(:), allocatable :: text, item
      integer :: i
      text = ''
      item = ''
      do i = axis_modes, axes
         if (setting%level(i) == 0) cycle
         item = trim(plan%axis(i)%texts(setting%level(i)))
         if (i /= axis_fidelity) item = item//' '//counted(plan%axis(i)%name, nint(plan%axis(i)%values(setting%level(i))))
         if (text == '') then
            text = ' with '//item
         else
            text = text//' and '//item
         end if
      end do
   end function model_text

   !> A plural, or its singular.
   pure function counted(name, number) result(text)
      character(*), intent(in) :: name
      integer, intent(in) :: number
      character(:), allocatable :: text
      text = name
      if (number == 1) text = name(:len(name) - 1)
   end function counted

   function channel_header(plan) result(text)
      type(plan_type), intent(in) :: plan
      character(:), allocatable :: text
      integer :: i
      text = ''
      do i = 1, size(plan%names)
         text = text//'  '//repeat(' ', max(0, width - 2 - len_trim(plan%names(i))))//trim(plan%names(i))
      end do
   end function channel_header

   !> CPU time and the error of each channel, below its name.
   function error_cells(plan, run) result(text)
      type(plan_type), intent(in) :: plan
      type(run_type), intent(in) :: run
      character(:), allocatable :: text, item
      integer :: i
      if (run%reason /= '') then
         text = '  failed: '//run%reason
         return
      end if
      item = ''
      text = milliseconds(median(run%cpu))
      do i = 1, size(plan%names)
         item = as_text(run%greatest(i), 2)
         text = text//repeat(' ', max(width, len_trim(plan%names(i)) + 2) - len(item))//item
      end do
   end function error_cells

   !> The cheapest run that is as accurate as wanted, and what one more digit costs.
   function advice(plan, runs, told) result(text)
      type(plan_type), intent(in) :: plan
      type(run_type), intent(in) :: runs(:)
      !> The report before it: warnings in it are not repeated
      character(*), intent(in) :: told
      character(:), allocatable :: text, warnings
      integer :: chosen, better
      chosen = cheapest(runs, plan%aim)
      text = ''
      if (chosen == 0) then
         chosen = most_accurate(runs)
         if (chosen > 0) text = 'No run has an error of '//per_cent(plan%aim)//' or less. The most accurate: '
      end if
      if (chosen == 0) then
         text = 'No run has finished.'
         return
      end if
      text = text//trim(runs(chosen)%setting%integrator)//' at '//step_word(plan)//as_text(control(runs(chosen)%setting))// &
         & model_text(plan, runs(chosen)%setting)//': '//per_cent(runs(chosen)%error)//' in '// &
         & as_text(1.0e3_wp*median(runs(chosen)%cpu), 2)//' ms; '
      better = cheapest(runs, 0.1_wp*runs(chosen)%error)
      if (better == 0 .or. better == chosen) then
         text = text//'no run here has one more digit'
      else
         text = text//'one more digit costs '//as_text(median(runs(better)%cpu)/median(runs(chosen)%cpu), 2)//' times: '// &
            & trim(runs(better)%setting%integrator)//' at '//step_word(plan)//as_text(control(runs(better)%setting))// &
            & model_text(plan, runs(better)%setting)
      end if
      if (.not. allocated(runs(chosen)%warnings)) return
      warnings = warnings_of(runs(chosen)%warnings, told)
      if (warnings /= '') then
         text = text//newline//'That run warns:'//warnings
      else if (warnings_of(runs(chosen)%warnings) /= '') then
         text = text//newline//'That run warns of the same as the reference, above'
      end if
   end function advice

   !> Fastest run with an error up to a bound; 0: none.
   pure integer function cheapest(runs, bound)
      type(run_type), intent(in) :: runs(:)
      real(wp), intent(in) :: bound
      real(wp) :: least
      integer :: i
      cheapest = 0
      least = huge(least)
      do i = 1, size(runs)
         if (.not. runs(i)%on_front .or. runs(i)%error > bound) cycle
         if (median(runs(i)%cpu) >= least) cycle
         least = median(runs(i)%cpu)
         cheapest = i
      end do
   end function cheapest

   pure integer function most_accurate(runs)
      type(run_type), intent(in) :: runs(:)
      integer :: i
      most_accurate = 0
      do i = 1, size(runs)
         if (.not. runs(i)%on_front) cycle
         if (most_accurate == 0) most_accurate = i
         if (runs(i)%error < runs(most_accurate)%error) most_accurate = i
      end do
   end function most_accurate

   !> Settings that failed and their reasons, a line for each.
   function failures(plan, runs) result(text)
      type(plan_type), intent(in) :: plan
      type(run_type), intent(in) :: runs(:)
      character(:), allocatable :: text
      integer :: i
      text = ''
      do i = 1, size(runs)
         if (runs(i)%reason /= '') text = text//setting_cells(plan, runs(i)%setting)//'  '//runs(i)%reason//newline
      end do
   end function failures

   pure function per_cent(value) result(text)
      real(wp), intent(in) :: value
      character(:), allocatable :: text
      text = as_text(100*value, 2)//' %'
   end function per_cent

   pure function milliseconds(seconds) result(text)
      real(wp), intent(in) :: seconds
      character(:), allocatable :: text
      text = right(as_text(1.0e3_wp*seconds, 3))
   end function milliseconds

   !> A text at the right of a column, at least one blank before it.
   pure function right(cell) result(text)
      character(*), intent(in) :: cell
      character(:), allocatable :: text
      text = repeat(' ', max(1, width - len(cell)))//cell
   end function right

   pure function left(cell) result(text)
      character(*), intent(in) :: cell
      character(:), allocatable :: text
      text = cell//repeat(' ', max(1, width - len(cell)))
   end function left

end module limber_accuracy_study_report
