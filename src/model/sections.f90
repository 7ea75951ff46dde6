!> Cross-sections: *SECTION. Floor: model.
module limber_model_sections
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_deck_content, only: block_type
   use limber_deck_diagnostics, only: diagnostics_type
   implicit none
   private
   public :: read_section, section_between, shear_factor, curved_inertia, check_material, check_section

   real(wp), parameter :: pi = acos(-1.0_wp)

contains

   !> Reports a Poisson's ratio that no material has.
   subroutine check_material(block, diagnostics)
      type(block_type), intent(in) :: block
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp) :: ratio
      ratio = block%real('POISSON')
      if (.not. (ratio > -1.0_wp .and. ratio <= 0.5_wp)) call diagnostics%add(block%origin_of('POISSON'), &
         & 'no elastic material has POISSON='//as_text(ratio), 'give a number above -1 and at most 0.5')
   end subroutine check_material

   !> Reports what is wrong with a section, whether a beam uses it or not.
   subroutine check_section(block, diagnostics)
      type(block_type), intent(in) :: block
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp) :: strength(4)
      integer :: before
      before = diagnostics%count
      call read_section(block, strength, diagnostics)
      if (diagnostics%count > before) return
      if (block%has('SHEAR FACTOR')) then
         if (block%real('SHEAR FACTOR') > 1.0_wp) call diagnostics%warn(block%origin_of('SHEAR FACTOR'), "section '"// &
            & block%name()//"': SHEAR FACTOR="//as_text(block%real('SHEAR FACTOR'))//' is more shear area than area', &
            & 'a number up to 1, such as 5/6 of a rectangle')
      end if
      ! The variance of places between two bounds is the product of their distances at most
      if (block%word('SHAPE') == 'GENERAL' .and. all(strength(3:4) > 0.0_wp)) then
         if (strength(2) > (1 + 1.0e-3_wp)*product(strength([1, 3, 4]))) call diagnostics%warn(block%origin_of('INERTIA'), &
            & "section '"//block%name()//"': no section of this AREA between TOP and BOTTOM has INERTIA="// &
            & as_text(strength(2)), 'at most AREA*TOP*BOTTOM = '//as_text(product(strength([1, 3, 4])), 3))
      end if
   end subroutine check_section

   !> Area, second moment of area, and distances of the extreme fibres.
   subroutine read_section(block, strength, diagnostics)
      type(block_type), intent(in) :: block
      !> Area [length^2], second moment of area [length^4], distances to the left and right of the axis [length]; 0: unknown
      real(wp), intent(out) :: strength(4)
      type(diagnostics_type), intent(inout) :: diagnostics
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
               & "' is thicker than its radius", 'at most '//as_text(0.5_wp*d), object=block%name())
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

      !> Whether the block has all these options; adds an error for each missing one.
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

   !> Area, second moment of area, and distances of the extreme fibres (4), as in `read_section`, of a section between two sections
   !> of one shape. Dimensions change linearly between them.
   function section_between(first, second, part) result(strength)
      type(block_type), intent(in) :: first, second
      !> Position between both sections, from 0 to 1
      real(wp), intent(in) :: part
      real(wp) :: strength(4)
      type(diagnostics_type) :: unused
      real(wp) :: d, inner, width, height
      select case (first%word('SHAPE'))
      case ('CIRCLE', 'TUBE')
         d = between('DIAMETER')
         inner = 0.0_wp
         if (first%word('SHAPE') == 'TUBE') inner = d - 2*between('THICKNESS')
         strength = [pi*(d**2 - inner**2)/4, pi*(d**4 - inner**4)/64, d/2, d/2]
      case ('RECTANGLE')
         width = between('WIDTH')
         height = between('HEIGHT')
         strength = [width*height, width*height**3/12, height/2, height/2]
      case default
         call read_section(first, strength, unused)
      end select

   contains

      !> Dimension at this position.
      real(wp) function between(option)
         character(*), intent(in) :: option
         between = first%real(option) + part*(second%real(option) - first%real(option))
      end function between

   end function section_between

   !> Second moment of area of a curved beam [length^4]: integral of y^2/(1 - c y) over the section, with c the curvature of the
   !> axis. Fibres on the side of the centre of curvature are shorter than the axis. SHAPE=GENERAL: the plain second moment of area.
   !> Source: doc/theory, eq. (2.54).
   real(wp) function curved_inertia(block, strength, arc) result(moment)
      !> Block of the section
      type(block_type), intent(in) :: block
      !> As in `read_section`
      real(wp), intent(in) :: strength(4)
      !> Curvature c of the axis [1/length]; its radius must exceed the distance of the extreme fibres
      real(wp), intent(in) :: arc
      real(wp) :: inner
      moment = strength(2)
      select case (block%word('SHAPE'))
      case ('RECTANGLE')
         moment = strength(1)*strength(3)**2*slender_part(arc*strength(3))
      case ('CIRCLE', 'TUBE')
         ! Radius of the hole
         inner = sqrt(max(strength(3)**2 - strength(1)/pi, 0.0_wp))
         moment = of_disc(strength(3)) - of_disc(inner)
      end select

   contains

      !> The integral over a disc of this radius.
      real(wp) function of_disc(radius)
         real(wp), intent(in) :: radius
         of_disc = pi*radius**4/(1 + sqrt(1 - (arc*radius)**2))**2
      end function of_disc

   end function curved_inertia

   !> (artanh(x)/x - 1)/x^2, near zero by its series.
   pure real(wp) function slender_part(x) result(part)
      real(wp), intent(in) :: x
      real(wp), parameter :: small = 0.1_wp
      integer :: k
      if (abs(x) > small) then
         part = (atanh(x)/x - 1)/x**2
         return
      end if
      part = 0.0_wp
      do k = 8, 0, -1
         part = part*x**2 + 1.0_wp/(2*k + 3)
      end do
   end function slender_part

   !> Ratio of shear area to area. Default: Cowper's value for a Poisson's ratio of zero, for a rectangle that of the parabolic
   !> shear stress. 0 if unknown.
   pure real(wp) function shear_factor(first, second, part) result(factor)
      type(block_type), intent(in) :: first, second
      !> Position between both sections, from 0 to 1
      real(wp), intent(in) :: part
      real(wp) :: ratio
      factor = 0.0_wp
      if (first%has('SHEAR FACTOR')) then
         factor = first%real('SHEAR FACTOR')
         if (second%has('SHEAR FACTOR')) factor = factor + part*(second%real('SHEAR FACTOR') - factor)
         return
      end if
      select case (first%word('SHAPE'))
      case ('RECTANGLE'); factor = 5.0_wp/6
      case ('CIRCLE'); factor = 6.0_wp/7
      case ('TUBE')
         ! Ratio of inner to outer diameter
         ratio = 1 - 2*(first%real('THICKNESS') + part*(second%real('THICKNESS') - first%real('THICKNESS'))) &
            & /(first%real('DIAMETER') + part*(second%real('DIAMETER') - first%real('DIAMETER')))
         factor = 6*(1 + ratio**2)**2/(7*(1 + ratio**2)**2 + 20*ratio**2)
      end select
   end function shear_factor

end module limber_model_sections
