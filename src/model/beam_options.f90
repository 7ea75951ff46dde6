!> Warnings of options without meaning for the model of a beam. Floor: model.
module limber_model_beam_options
   use limber_deck_content, only: block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_families, only: options_of_modes, options_of_exact
   implicit none
   private
   public :: check_options

contains

   !> Warns of options of modal beams on an exact beam, and of options of exact beams on another beam.
   subroutine check_options(block, diagnostics)
      !> Block of the beam
      type(block_type), intent(in) :: block
      type(diagnostics_type), intent(inout) :: diagnostics
      if (block%word('GEOMETRIC') == 'EXACT') then
         call look(options_of_modes, 'of an EXACT beam', 'leave it out: FUNCTIONS and STRAIN FUNCTIONS '// &
            & 'say how finely it bends and stretches')
      else
         call look([character(20) :: options_of_exact(:2), 'TENSION'], 'of a beam that is not EXACT', &
            & 'leave it out, or write GEOMETRIC=EXACT')
         if (block%integer('SEGMENTS') > 1 .and. block%word('GEOMETRIC') /= 'RIGID') call diagnostics%add( &
            & block%origin_of('SEGMENTS'), "beam '"//block%name()//"': SEGMENTS is for GEOMETRIC=EXACT only, not for "// &
            & block%word('GEOMETRIC'), 'leave it out, or write GEOMETRIC=EXACT in place of the options of modes')
      end if

   contains

      !> Warns of each given option of the list.
      subroutine look(options, kind, remedy)
         character(*), intent(in) :: options(:), kind, remedy
         integer :: i
         do i = 1, size(options)
            if (.not. block%knows(trim(options(i)))) cycle
            if (block%given(trim(options(i)))) call diagnostics%warn(block%origin_of(trim(options(i))), "beam '"// &
               & block%name()//"': "//trim(options(i))//' means nothing '//kind, remedy)
         end do
      end subroutine look

   end subroutine check_options

end module limber_model_beam_options
