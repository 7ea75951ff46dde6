!> Envelopes of internal forces in a result file: /bodies/<name>/envelope. Floor: analysis.
module limber_analysis_envelope
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_model_channels, only: unit_text
   use limber_model_scene, only: body_type, units_type
   use limber_output_history, only: history_type
   use limber_output_internal_forces, only: effort_type
   implicit none
   private
   public :: record_envelope

contains

   !> Least and greatest values over all samples at the sections of a body, each (sections, 2) to h5py; a node has a section before
   !> it and one behind it.
   subroutine record_envelope(body, effort, units, history, error)
      type(body_type), intent(in) :: body
      type(effort_type), intent(in) :: effort
      type(units_type), intent(in) :: units
      type(history_type), intent(inout) :: history
      type(error_type), allocatable, intent(out) :: error
      character(:), allocatable :: group
      if (.not. allocated(effort%extremes)) return
      group = '/bodies/'//body%name//'/envelope'
      associate (sections => body%recovery%sections(body%point_sections + 1:))
         call history%put_real(group//'/member', real(sections%member, wp), '1', &
            & 'member of each section, counted in the order of the deck', error)
         if (.not. allocated(error)) call history%put_real(group//'/coordinate', sections%x, units%length, &
            & 'coordinate of each section along its beam or member', error)
      end associate
      call put(1, 'axial_force', unit_text([1, -2, 1], units), 'tension')
      call put(2, 'shear_force', unit_text([1, -2, 1], units), 'shear force')
      call put(3, 'bending_moment', unit_text([2, -2, 1], units), 'bending moment')
      if (.not. all(body%strength(3:4, :) > 0.0_wp)) return
      call put(4, 'stress_top', unit_text([-1, -2, 1], units), 'axial stress in the fibre to the left')
      call put(5, 'stress_bottom', unit_text([-1, -2, 1], units), 'axial stress in the fibre to the right')

   contains

      subroutine put(row, name, unit, meaning)
         integer, intent(in) :: row
         character(*), intent(in) :: name, unit, meaning
         if (.not. allocated(error)) call history%put_real(group//'/'//name, effort%extremes(row, :, :), unit, &
            & 'least and greatest '//meaning//' over all samples', error)
      end subroutine put

   end subroutine record_envelope

end module limber_analysis_envelope
