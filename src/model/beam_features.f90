!> Features of exact beams: sections along the axis, shear, initial curvature, thermal strain and curvature, pretension. Floor:
!> model. Source: doc/theory, part 2, eqs. (2.47), (2.50)-(2.53).
module limber_model_beam_features
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_deck_content, only: deck_type, block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_beam_exact_profile, only: profile_type, profile_mean, profile_places, profile_values, of_ea, of_ei, of_ga, of_mass, &
      & of_rotary
   use limber_model_body_parts, only: is_part
   use limber_model_model, only: body_type
   use limber_model_sections, only: read_section, section_between, shear_factor, curved_inertia
   implicit none
   private
   public :: read_features, refuse_features

   !> Options of exact beams only; the first `whole_only` of them are not for beams in segments
   character(*), parameter :: features(*) = [character(17) :: 'END SECTION', 'CURVATURE', 'SHEAR', 'THERMAL STRAIN', &
      & 'THERMAL CURVATURE', 'PRETENSION']
   integer, parameter :: whole_only = 2

contains

   !> Reports features on a beam without them: in segments, or not exact.
   subroutine refuse_features(deck, index, is_exact, diagnostics)
      type(deck_type), intent(in) :: deck
      !> Block of the beam
      integer, intent(in) :: index
      logical, intent(in) :: is_exact
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: reason, remedy
      integer :: i
      associate (block => deck%blocks(index))
         if (is_exact) then
            reason = ' is not for a beam in SEGMENTS'
            remedy = 'leave SEGMENTS out and raise FUNCTIONS'
         else
            reason = ' is for GEOMETRIC=EXACT only, not for '//block%word('GEOMETRIC')
            remedy = 'use GEOMETRIC=EXACT'
         end if
         do i = 1, merge(whole_only, size(features), is_exact)
            if (.not. block%given(trim(features(i)))) cycle
            if (is_off(block, trim(features(i)))) cycle
            call diagnostics%add(block%origin_of(trim(features(i))), &
               & "beam '"//block%name()//"': "//trim(features(i))//reason, remedy)
         end do
         do i = 1, size(deck%blocks)
            if (deck%blocks(i)%keyword /= 'PROFILE') cycle
            if (is_part(deck, i, index)) call diagnostics%add(deck%blocks(i)%origin, "beam '"//block%name()//"': *PROFILE"// &
               & reason, remedy)
         end do
      end associate
   end subroutine refuse_features

   !> Whether the given value of a feature means none of it, as in an effective deck.
   pure logical function is_off(block, feature)
      type(block_type), intent(in) :: block
      character(*), intent(in) :: feature
      select case (feature)
      case ('END SECTION'); is_off = .false.
      case ('SHEAR'); is_off = .not. block%yes(feature)
      case default; is_off = .not. abs(block%real(feature)) > 0.0_wp
      end select
   end function is_off

   !> Reads all features into the options of an exact beam.
   subroutine read_features(deck, index, material, section, body, diagnostics)
      type(deck_type), intent(in) :: deck
      !> Blocks of the beam, of its material and of its section
      integer, intent(in) :: index, material, section
      type(body_type), intent(inout) :: body
      type(diagnostics_type), intent(inout) :: diagnostics
      integer, allocatable :: from(:), to(:)
      integer :: before
      before = diagnostics%count
      associate (block => deck%blocks(index), choice => body%choice%exact)
         choice%arc = block%real('CURVATURE')
         choice%hot_strain = block%real('THERMAL STRAIN')
         choice%hot_curvature = block%real('THERMAL CURVATURE')
         choice%pretension = block%real('PRETENSION')
         choice%shear = block%yes('SHEAR')
         if (choice%strains == 0) then
            call need_strain('THERMAL STRAIN')
            call need_strain('PRETENSION')
         end if
         allocate (from(0), to(0))
         call read_stretches(deck, index, section, body%beam%length, from, to, body%fibres, diagnostics)
         if (diagnostics%count > before) return
         call read_strengths(deck, index, from, to, body%fibres, diagnostics)
         if (block%yes('SHEAR')) call check_shear(deck, material, from, to, diagnostics)
         if (diagnostics%count > before) return
         call multiply(deck, material, from, to, block%yes('SHEAR'), body%fibres, choice%profile)
         call use_mean(body)
         call warn_of_arc(deck, block, from, body%fibres, diagnostics)
         call check_free_shape(block, body, diagnostics)
      end associate

   contains

      !> Reports a feature of the axial strain on a beam without strain functions.
      subroutine need_strain(option)
         character(*), intent(in) :: option
         associate (block => deck%blocks(index))
            if (abs(block%real(option)) > 0.0_wp) call diagnostics%add(block%origin_of(option), "beam '"//block%name()// &
               & "' has no STRAIN FUNCTIONS, which "//option//' acts on', 'ask for STRAIN FUNCTIONS=1 or more')
         end associate
      end subroutine need_strain

   end subroutine read_features

   !> Reports heat and tensions that no beam bears: without loads it would have no length, or another one altogether, or be bent
   !> over its own fibres.
   subroutine check_free_shape(block, body, diagnostics)
      type(block_type), intent(in) :: block
      type(body_type), intent(in) :: body
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: option
      real(wp) :: ea, strain, arc, reach
      integer :: i, j
      associate (choice => body%choice%exact)
         ea = minval(choice%profile%value(of_ea, :, :))
         ! Of a section or material in error there is nothing to say
         if (.not. ea > 0.0_wp) return
         strain = choice%hot_strain - choice%pretension/ea
         option = trim(merge('THERMAL STRAIN', 'PRETENSION    ', abs(choice%hot_strain) >= abs(choice%pretension/ea)))
         if (abs(strain) >= 1.0_wp) call diagnostics%add(block%origin_of(option), "beam '"//block%name()// &
            & trim(merge("' has no length without loads: its strain there is  ", &
            & "' has twice its LENGTH without loads: its strain is ", strain < 0.0_wp))//' '//as_text(strain, 3), &
            & 'THERMAL STRAIN less PRETENSION/(E A) must be above -1 and below 1')
         if (block%has('TENSION')) then
            if (block%real('TENSION') > ea) call diagnostics%add(block%origin_of('TENSION'), "beam '"//block%name()// &
               & "': TENSION="//as_text(block%real('TENSION'))//' is more than its axial stiffness E A = '//as_text(ea, 3), &
               & 'give the largest tension that is expected')
         end if
         if (.not. abs(choice%hot_curvature) > 0.0_wp) return
         arc = choice%arc + choice%hot_curvature
         reach = 0.0_wp
         do i = 1, size(body%fibres%value, 3)
            do j = 1, profile_places
               reach = max(reach, inner_reach(arc, body%fibres%value(3:4, j, i)))
            end do
         end do
         if (reach >= 1.0_wp) call diagnostics%add(block%origin_of('THERMAL CURVATURE'), "a section of beam '"//block%name()// &
            & "' reaches over the centre of its curvature without loads", 'CURVATURE and THERMAL CURVATURE together below '// &
            & as_text(abs(arc)/reach, 3))
      end associate
   end subroutine check_free_shape

   !> Reads the stretches of a beam: their ends into `fibres%at`, and the sections (blocks) at both ends of each (stretches).
   subroutine read_stretches(deck, index, section, length, from, to, fibres, diagnostics)
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: index, section
      !> Length of the beam or piece [length]
      real(wp), intent(in) :: length
      integer, allocatable, intent(inout) :: from(:), to(:)
      type(profile_type), intent(inout) :: fibres
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp), allocatable :: at(:)
      integer :: i, k
      allocate (at(1))
      at = 0.0_wp
      from = [section]
      to = [section]
      if (deck%blocks(index)%has('END SECTION')) to(1) = deck%find_named('SECTION', deck%blocks(index)%name('END SECTION'))
      do i = 1, size(deck%blocks)
         if (deck%blocks(i)%keyword /= 'PROFILE') cycle
         if (.not. is_part(deck, i, index)) cycle
         do k = 1, size(deck%blocks(i)%lines)
            associate (line => deck%blocks(i)%lines(k))
               if (line%number(1) <= at(size(at)) .or. line%number(1) >= length) then
                  call diagnostics%add(line%origin_of(1), 'sections of a beam change within it, one after another', &
                     & 'give a coordinate between '//as_text(at(size(at)))//' and '//as_text(length))
                  cycle
               end if
               at = [at, line%number(1)]
               from = [from, deck%find_named('SECTION', line%text(2))]
               to = [to, from(size(from))]
               if (line%count() > 2) to(size(to)) = deck%find_named('SECTION', line%text(3))
               if (from(size(from)) == 0) call complain(2)
               if (to(size(to)) == 0 .and. line%count() > 2) call complain(3)
            end associate
         end do
      end do
      allocate (fibres%at(0:size(at)))
      fibres%at(:) = [at, length]

   contains

      !> Reports an unknown section.
      subroutine complain(field)
         integer, intent(in) :: field
         associate (line => deck%blocks(i)%lines(k))
            call diagnostics%add(line%origin_of(field), "there is no *SECTION named '"//line%text(field)//"'", &
               & 'define it with *SECTION')
         end associate
      end subroutine complain

   end subroutine read_stretches

   !> Computes areas, second moments of area, extreme fibres, and second moments of the curved beam along the stretches.
   subroutine read_strengths(deck, index, from, to, fibres, diagnostics)
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: index, from(:), to(:)
      type(profile_type), intent(inout) :: fibres
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp) :: strength(4), arc
      integer :: i, j, before
      arc = deck%blocks(index)%real('CURVATURE')
      allocate (fibres%value(profile_values, profile_places, size(from)))
      fibres%value = 1.0_wp
      do i = 1, size(from)
         before = diagnostics%count
         ! The first section was read and checked before
         if (i > 1) call read_section(deck%blocks(from(i)), strength, diagnostics)
         if (to(i) /= from(i)) then
            call read_section(deck%blocks(to(i)), strength, diagnostics)
            associate (first => deck%blocks(from(i)), second => deck%blocks(to(i)))
               if (first%word('SHAPE') /= second%word('SHAPE') .or. first%word('SHAPE') == 'GENERAL') call diagnostics%add( &
                  & second%origin_of('SHAPE'), "a beam cannot taper from section '"//first%name()//"' to '"//second%name()//"'", &
                  & 'give both the same SHAPE, CIRCLE, TUBE or RECTANGLE')
            end associate
         end if
         if (diagnostics%count > before) cycle
         do j = 1, profile_places
            strength = section_between(deck%blocks(from(i)), deck%blocks(to(i)), (j - 1.0_wp)/(profile_places - 1))
            fibres%value(:4, j, i) = strength
            if (inner_reach(arc, strength(3:4)) < 1.0_wp) cycle
            call diagnostics%add(deck%blocks(index)%origin_of('CURVATURE'), "section '"//deck%blocks(from(i))%name()// &
               & "' of beam '"//deck%blocks(index)%name()//"' reaches over the centre of its curvature", &
               & 'a curvature below '//as_text(abs(arc)/inner_reach(arc, strength(3:4)), 3))
            exit
         end do
         if (diagnostics%count > before) cycle
         do j = 1, profile_places
            fibres%value(5, j, i) = curved_inertia(deck%blocks(from(i)), fibres%value(:4, j, i), arc)
         end do
      end do
   end subroutine read_strengths

   !> Distance of the inner extreme fibre from the axis, in radii of curvature.
   pure real(wp) function inner_reach(arc, extreme) result(reach)
      !> Curvature [1/length]; distances to the left and to the right [length]
      real(wp), intent(in) :: arc, extreme(2)
      reach = abs(arc)*merge(extreme(1), extreme(2), arc > 0.0_wp)
   end function inner_reach

   !> Warns of beams that are thick compared with their radius of curvature: the functions omit the coupling of axial force and
   !> bending. Also warns if the shape of a curved section is unknown, eq. (2.55).
   subroutine warn_of_arc(deck, block, from, fibres, diagnostics)
      type(deck_type), intent(in) :: deck
      !> Block of the beam
      type(block_type), intent(in) :: block
      !> Sections of the stretches (blocks)
      integer, intent(in) :: from(:)
      type(profile_type), intent(in) :: fibres
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Smallest relative error of stiffness or stress that gives a warning
      real(wp), parameter :: noticed = 0.01_wp
      !> For an unknown shape: factor on the error of the stiffness; bound of the third moment, relative to the second moment times
      !> the difference of the fibre distances
      real(wp), parameter :: plain = 3.0_wp, skew = 0.4_wp
      character(:), allocatable :: text
      real(wp) :: soft, stress
      logical :: unknown
      integer :: i, j
      soft = 0.0_wp
      stress = 0.0_wp
      associate (arc => block%real('CURVATURE'))
         do i = 1, size(from)
            unknown = deck%blocks(from(i))%word('SHAPE') == 'GENERAL'
            do j = 1, profile_places
               associate (value => fibres%value(:, j, i))
                  soft = max(soft, arc**2*value(5)/value(1)*merge(plain, 1.0_wp, unknown))
                  if (unknown) stress = max(stress, maxval(abs(arc*value(3:4)))**2 + skew*abs(arc*(value(3) - value(4))))
               end associate
            end do
         end do
         if (max(soft, stress) <= noticed) return
         text = ''
         if (soft > noticed) text = 'deflections may err by about '//as_text(100*soft, 2)//' %'
         if (soft > noticed .and. stress > noticed) text = text//' and '
         if (stress > noticed) text = text//'stresses by about '//as_text(100*stress, 2)//' %, as the shape of its section is'// &
            & ' not known'
         call diagnostics%warn(block%origin_of('CURVATURE'), "beam '"//block%name()//"' is thick beside its radius of"// &
            & ' curvature: '//text, trim(merge('use SHAPE=RECTANGLE, CIRCLE or TUBE if it is one             ', &
            & 'axial force and bending go together there; use solid elements', stress > noticed)))
      end associate
   end subroutine warn_of_arc

   !> Checks material and sections for shear: Poisson's ratio, shear factor.
   subroutine check_shear(deck, material, from, to, diagnostics)
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: material, from(:), to(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i, k
      associate (block => deck%blocks(material))
         if (block%real('POISSON') <= -1.0_wp .or. block%real('POISSON') > 0.5_wp) call diagnostics%add( &
            & block%origin_of('POISSON'), "Poisson's ratio of material '"//block%name()//"' is "//as_text(block%real('POISSON')), &
            & 'give a ratio above -1, at most 0.5')
      end associate
      do i = 1, size(from)
         do k = 1, 2
            associate (block => deck%blocks(merge(from(i), to(i), k == 1)))
               if (shear_factor(block, block, 0.0_wp) > 0.0_wp .or. (k == 2 .and. to(i) == from(i))) cycle
               call diagnostics%add(block%origin, "section '"//block%name()//"' of SHAPE=GENERAL needs SHEAR FACTOR for a beam"// &
                  & ' with SHEAR', 'add SHEAR FACTOR=, area in shear divided by area', object=block%name())
            end associate
         end do
      end do
   end subroutine check_shear

   !> Computes rigidities and masses along the beam.
   subroutine multiply(deck, material, from, to, shear, fibres, profile)
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: material, from(:), to(:)
      logical, intent(in) :: shear
      type(profile_type), intent(in) :: fibres
      type(profile_type), intent(inout) :: profile
      real(wp) :: factor
      integer :: i, j
      allocate (profile%at(0:size(from)), source=fibres%at)
      allocate (profile%value(profile_values, profile_places, size(from)))
      profile%value = 0.0_wp
      associate (young => deck%blocks(material)%real('YOUNG'), density => deck%blocks(material)%real('DENSITY'), &
         & poisson => deck%blocks(material)%real('POISSON'))
         profile%value(of_ea, :, :) = young*fibres%value(1, :, :)
         profile%value(of_ei, :, :) = young*fibres%value(5, :, :)
         profile%value(of_mass, :, :) = density*fibres%value(1, :, :)
         if (.not. shear) return
         profile%value(of_rotary, :, :) = density*fibres%value(2, :, :)
         do i = 1, size(from)
            do j = 1, profile_places
               factor = shear_factor(deck%blocks(from(i)), deck%blocks(to(i)), (j - 1.0_wp)/(profile_places - 1))
               profile%value(of_ga, j, i) = factor*young/(2*(1 + poisson))*fibres%value(1, j, i)
            end do
         end do
      end associate
   end subroutine multiply

   !> Sets the mean values of the beam for its modes, if it is not uniform and straight.
   subroutine use_mean(body)
      type(body_type), intent(inout) :: body
      real(wp) :: mean(profile_values)
      mean = profile_mean(body%choice%exact%profile)
      if (size(body%choice%exact%profile%value, 3) == 1 .and. &
         & all(abs(body%fibres%value(:4, 1, 1) - body%fibres%value(:4, profile_places, 1)) <= 0.0_wp) .and. &
         & .not. abs(body%choice%exact%arc) > 0.0_wp) return
      body%beam%ea = mean(of_ea)
      body%beam%ei = mean(of_ei)
      body%beam%rho_a = mean(of_mass)
   end subroutine use_mean

end module limber_model_beam_features
