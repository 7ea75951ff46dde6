!> Cross-sections from the deck. Floor: model.
module limber_model_sections
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_deck_content, only: block_type
   use limber_deck_diagnostics, only: diagnostics_type
   implicit none
   private
   public :: read_section

contains

   !> Area, second moment of area, and distances of the extreme fibres.
   subroutine read_section(block, strength, diagnostics)
      type(block_type), intent(in) :: block
      !> [length^2], [length^4], to the left and to the right of the beam [length]; zero where not known
      real(wp), intent(out) :: strength(4)
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp), parameter :: pi = acos(-1.0_wp)
      real(wp) :: d, inner
      strength = [1.0_wp, 1.0_wp, 0.0_wp, 0.0_wp]
      d = block%real('DIAMETER')
      select case (block%word('SHAPE'))
      case ('CIRCLE')
         if (.not. has_all(['DIAMETER'])) return
         strength = [pi*d**2/4, pi*d**4/64, d/2, d/2]
      case ('RECTANGLE')
         if (.not. has_all(['WIDTH ', 'HEIGHT'])) return
         associate (width => block%real('WIDTH'), height => block%real('HEIGHT'))
            strength = [width*height, width*height**3/12, height/2, height/2]
         end associate
      case ('TUBE')
         if (.not. has_all(['DIAMETER ', 'THICKNESS'])) return
         inner = d - 2*block%real('THICKNESS')
         if (inner < 0.0_wp) then
            call diagnostics%add(block%origin_of('THICKNESS'), "the wall of section '"//block%name()// &
               & "' is thicker than its radius", 'at most '//as_text(0.5_wp*d))
            return
         end if
         strength = [pi*(d**2 - inner**2)/4, pi*(d**4 - inner**4)/64, d/2, d/2]
      case ('GENERAL')
         if (.not. has_all(['AREA   ', 'INERTIA'])) return
         strength(1:2) = [block%real('AREA'), block%real('INERTIA')]
         if (block%has('TOP')) strength(3:4) = block%real('TOP')
         if (block%has('BOTTOM')) strength(4) = block%real('BOTTOM')
         if (block%has('BOTTOM') .and. .not. block%has('TOP')) strength(3) = strength(4)
      end select

   contains

      logical function has_all(options)
         character(*), intent(in) :: options(:)
         integer :: i
         has_all = .true.
         do i = 1, size(options)
            if (block%has(trim(options(i)))) cycle
            has_all = .false.
            call diagnostics%add(block%origin, "section '"//block%name()//"' of SHAPE="//block%word('SHAPE')//' needs '// &
               & trim(options(i)), 'add '//trim(options(i))//'=', object=block%name())
         end do
      end function has_all

   end subroutine read_section

end module limber_model_sections
