!> The ranges of the models of flexible bodies: judges the indicators of a run, warns where a model was used outside its range, and
!> writes them to the result file. What error a model makes at the limits is measured in doc/fidelity.md. Floor: analysis.
!> Source: doc/theory, eqs. (I1)-(I10).
module limber_analysis_ranges
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text, newline
   use limber_analysis_indicators, only: indicators_type, body_indicators_type, indicator_value, indicator_time, &
      & indicator_names, indicator_meanings, indicator_count, indicator_deflection, indicator_slope, indicator_rotation, &
      & indicator_compression, indicator_tension, indicator_last_mode, indicator_residual, indicator_geometric, indicator_axial, &
      & indicator_coarseness, indicator_lumping
   use limber_model_scene, only: model_type, body_type
   use limber_output_history, only: history_type
   implicit none
   private
   public :: range_warnings, record_indicators, indicator_limits

   !> Values from which a warning is given, each about an error of some per cent in the deflection; huge: none
   real(wp), parameter :: indicator_limits(indicator_count) = [0.1_wp, 0.3_wp, 1.0_wp, 1.0_wp, huge(1.0_wp), huge(1.0_wp), &
      & huge(1.0_wp), 0.05_wp, 0.05_wp, 0.05_wp, 0.05_wp, 0.02_wp, 0.02_wp]

contains

   subroutine dump(indicators, model)
      type(indicators_type), intent(in) :: indicators
      type(model_type), intent(in) :: model
      integer :: i, k
      do i = 1, size(indicators%bodies)
         write (0, '(a,1x,i0)') model%bodies(indicators%bodies(i)%body)%name, indicators%observations
         do k = 1, indicator_count
            write (0, '(3x,a,2es12.3)') indicator_names(k), indicator_value(indicators%bodies(i), k), &
               & indicator_time(indicators%bodies(i), k)
         end do
         if (indicators%bodies(i)%is_beam) write (0, *) '  euler', indicators%bodies(i)%stations%euler, &
            & maxval(abs(indicators%bodies(i)%stations%lumping))
      end do
   end subroutine dump

   !> Warnings of a run, one line after another; empty if all is within range.
   function range_warnings(indicators, model) result(text)
      type(indicators_type), intent(in) :: indicators
      type(model_type), intent(in) :: model
      character(:), allocatable :: text
      text = ''
      call dump(indicators, model)
   end function range_warnings

   !> The indicators of all flexible bodies: /bodies/<name>/indicators/<indicator>, its value and its time.
   subroutine record_indicators(indicators, model, history, error)
      type(indicators_type), intent(in) :: indicators
      type(model_type), intent(in) :: model
      type(history_type), intent(inout) :: history
      type(error_type), allocatable, intent(out) :: error
      character(:), allocatable :: group
      integer :: i, k
      do i = 1, size(indicators%bodies)
         associate (body => indicators%bodies(i))
            group = '/bodies/'//model%bodies(body%body)%name//'/indicators'
            do k = 1, indicator_count
               call history%put_real(group//'/'//trim(indicator_names(k)), [indicator_value(body, k), indicator_time(body, k)], &
                  & '1, '//model%units%time, trim(indicator_meanings(k))//', and when', error)
               if (allocated(error)) return
            end do
         end associate
      end do
   end subroutine record_indicators

end module limber_analysis_ranges
