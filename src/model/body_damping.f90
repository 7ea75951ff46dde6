!> Damping of beams and frames: *DAMPING. Floor: model. Source: doc/theory, eq. (3.39).
module limber_model_body_damping
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_deck_content, only: block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_model_beam_segments, only: pieces_of
   use limber_model_model, only: model_type
   use limber_model_points, only: find_body
   implicit none
   private
   public :: add_damping

contains

   !> Adds damping of a beam or frame; of a beam in segments for all pieces.
   subroutine add_damping(block, model, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: body, pieces(2), before
      body = find_body(model, block%name('BODY'))
      if (body == 0) return
      if (size(block%lines) == 0 .and. .not. (block%given('RATIO') .or. block%given('RAYLEIGH ALPHA') .or. &
         & block%given('RAYLEIGH BETA'))) call diagnostics%add(block%origin, '*DAMPING gives no damping', &
         & 'add RATIO=, RAYLEIGH ALPHA= or RAYLEIGH BETA=, or data lines: mode, ratio')
      call warn_of_ratios(block, diagnostics)
      pieces = pieces_of(model, body)
      before = diagnostics%count
      do body = pieces(1), pieces(2)
         call damp(block, body, before, model, diagnostics)
         if (diagnostics%count > before) return
      end do
   end subroutine add_damping

   !> Warns of modes that are damped more than critically: per cent may be meant.
   subroutine warn_of_ratios(block, diagnostics)
      type(block_type), intent(in) :: block
      type(diagnostics_type), intent(inout) :: diagnostics
      character(*), parameter :: remedy = 'RATIO is a part, not per cent: 2 % is 0.02'
      integer :: i
      if (block%real('RATIO') > 1.0_wp) call diagnostics%warn(block%origin_of('RATIO'), 'a damping ratio of '// &
         & as_text(block%real('RATIO'))//' is above critical: these modes do not vibrate', remedy)
      do i = 1, size(block%lines)
         if (block%lines(i)%number(2) > 1.0_wp) call diagnostics%warn(block%lines(i)%origin_of(2), 'a damping ratio of '// &
            & as_text(block%lines(i)%number(2))//' is above critical: this mode does not vibrate', remedy)
      end do
   end subroutine warn_of_ratios

   !> Adds the damping of the modes of a body, eq. (3.39).
   subroutine damp(block, body, before, model, diagnostics)
      type(block_type), intent(in) :: block
      !> Body, and number of errors before the block
      integer, intent(in) :: body, before
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp), allocatable :: ratio(:)
      integer :: i, mode
      associate (reduced => model%bodies(body)%reduced)
         if (reduced%damped) then
            call diagnostics%add(block%origin, "beam '"//model%bodies(body)%name//"' is damped twice", 'put both into one *DAMPING')
            return
         end if
         allocate (ratio(reduced%n))
         ratio = block%real('RATIO')
         do i = 1, size(block%lines)
            mode = nint(block%lines(i)%number(1))
            ! A beam in error has no modes
            if (reduced%n == 0 .and. before > 0) cycle
            if (mode > reduced%n) then
               call diagnostics%add(block%lines(i)%origin_of(1), "beam '"//model%bodies(body)%name//"' has "// &
                  & as_text(reduced%n)//' modes, '//as_text(reduced%bending)//' of them bending', 'give a mode that it has')
            else
               ratio(mode) = block%lines(i)%number(2)
            end if
         end do
         if (reduced%n == 0) return
         reduced%damped = .true.
         allocate (reduced%damping(reduced%n, reduced%n))
         reduced%damping = 0.0_wp
         do i = 1, reduced%n
            reduced%damping(i, i) = 2*ratio(i)*sqrt(reduced%omega2(i)) + block%real('RAYLEIGH ALPHA') &
               & + block%real('RAYLEIGH BETA')*reduced%omega2(i)
         end do
         ! Damping by the modes under the supports is computed after the assembly
         if (.not. (maxval(ratio) > 0.0_wp .or. block%real('RAYLEIGH ALPHA') > 0.0_wp)) return
         allocate (model%bodies(body)%ratio, source=ratio)
         model%bodies(body)%rayleigh = [block%real('RAYLEIGH ALPHA'), block%real('RAYLEIGH BETA')]
      end associate
   end subroutine damp

end module limber_model_body_damping
