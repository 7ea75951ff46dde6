!> Models of slender beams on short ones: what they lack for want of shear and rotary inertia, and the warnings of that, for beams and
!> frames of all models. Floor: model. Source: doc/theory, eqs. (X20), (U1).
module limber_model_short_beams
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_deck_content, only: deck_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_flex_exact_functions, only: exact_choice_type
   use limber_flex_mesh, only: support_type
   use limber_model_frame_draft, only: draft_type
   use limber_model_quantities, only: quantities
   use limber_model_scene, only: model_type, body_type
   use limber_model_sections, only: shear_factor
   implicit none
   private
   public :: unsheared_beam, unsheared_frame, warn_of_short

   !> Relative error for want of shear that is worth a warning
   real(wp), parameter :: noticed = 0.01_wp

contains

   !> Warns of beams and frames that are short, if anything is asked for that depends on it; of the members of a frame in one line.
   subroutine warn_of_short(deck, model, diagnostics)
      type(deck_type), intent(in) :: deck
      type(model_type), intent(in) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: which
      integer :: i, k
      if (all(model%bodies%unsheared <= noticed)) return
      if (.not. shows_deflections(deck, model)) return
      do i = 1, size(model%bodies)
         associate (body => model%bodies(i))
            if (body%whole > 0) cycle
            if (body%is_frame) call tell(deck, body%name, ' has short members', body%unsheared, diagnostics)
            if (.not. body%is_frame) call tell(deck, body%name, ' is short', body%unsheared, diagnostics)
         end associate
      end do
      do k = 1, size(model%wholes)
         associate (whole => model%wholes(k), part => model%bodies(model%wholes(k)%first:model%wholes(k)%last)%unsheared)
            which = ' is short'
            i = maxloc(part, dim=1)
            if (allocated(whole%lean)) which = ': '//as_text(count(part > noticed))//' of '//as_text(size(part))// &
               & ' members are short; of member '//as_text(whole%member_numbers(i))//', alone'
            call tell(deck, whole%name, which, part(i), diagnostics)
         end associate
      end do
   end subroutine warn_of_short

   !> Tells of one, unless it is slender enough.
   subroutine tell(deck, name, which, part, diagnostics)
      type(deck_type), intent(in) :: deck
      !> Of the beam or frame; what is short
      character(*), intent(in) :: name, which
      !> What it lacks
      real(wp), intent(in) :: part
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: error, remedy
      if (part <= noticed) return
      error = ': without shear its deflection is too small by about '//as_text(100*part, 2)//' %'
      if (vibrates(deck)) error = ': without shear and rotary inertia its first bending frequency is too high by about '// &
         & as_text(100*part, 2)//' %'
      remedy = 'where that counts, weld a *BEAM with SHEAR=YES in the place of such a member'
      associate (block => deck%blocks(deck%find_named('BEAM|FRAME', name)))
         if (block%keyword == 'BEAM') then
            remedy = 'use SHEAR=YES'
            if (block%word('GEOMETRIC') /= 'EXACT') remedy = 'use GEOMETRIC=EXACT, SHEAR=YES'
            call diagnostics%warn(block%origin_of('LENGTH'), "beam '"//name//"'"//which//error, remedy)
         else
            call diagnostics%warn(block%origin, "frame '"//name//"'"//which//error, remedy)
         end if
      end associate
   end subroutine tell

   !> Whether a motion or vibrations are asked for.
   pure logical function vibrates(deck)
      type(deck_type), intent(in) :: deck
      vibrates = deck%find('DYNAMICS') > 0 .or. deck%find('MODES') > 0
   end function vibrates

   !> Whether results depend on deflections: vibrations, and channels of all kinds but forces, moments and stresses at rest.
   pure logical function shows_deflections(deck, model)
      type(deck_type), intent(in) :: deck
      type(model_type), intent(in) :: model
      integer :: i, k
      shows_deflections = vibrates(deck) .or. model%motion
      do i = 1, size(model%channels)
         do k = 1, size(model%channels(i)%quantities)
            associate (kind => model%channels(i)%quantities(k)%kind)
               ! A parameter or the like has no kind
               if (kind == 0) cycle
               if (any(quantities(kind)%dimension(2:3) /= [-2, 1])) shows_deflections = .true.
            end associate
         end do
      end do
   end function shows_deflections

   !> What a beam lacks without shear, eq. (X20): of its frequencies where something may vibrate, else of its deflection, if anything
   !> bends it.
   real(wp) function unsheared_beam(deck, index, material, section, body) result(part)
      type(deck_type), intent(in) :: deck
      !> Blocks of the beam, of its material and of its section
      integer, intent(in) :: index, material, section
      !> With the choice of an exact beam
      type(body_type), intent(in) :: body
      real(wp) :: slender, softer
      associate (block => deck%blocks(index), beam => body%beam, choice => body%choice%exact)
         slender = (wave(choice%support)/block%real('LENGTH'))**2*beam%ei/beam%ea
         softer = softness(deck, material, section)
         if (vibrates(deck)) then
            part = 0.5_wp*slender*(1 + softer)
         else
            part = merge(slender*softer, 0.0_wp, is_bent(deck, choice))
         end if
      end associate
   end function unsheared_beam

   !> The same of a frame: energies of the shear forces and of the rotation of the sections in its slowest coordinate, eq. (U1).
   real(wp) function unsheared_frame(deck, draft, body) result(part)
      type(deck_type), intent(in) :: deck
      type(draft_type), intent(in) :: draft
      type(body_type), intent(in) :: body
      real(wp) :: shear, turning, ends(2, 2), bent
      integer :: e, k, side
      part = 0.0_wp
      if (body%reduced%n == 0) return
      k = minloc(body%reduced%omega2, dim=1)
      turning = 0.0_wp
      associate (mesh => body%mesh)
         do e = 1, size(mesh%length)
            do side = 1, 2
               associate (shape => body%shape(:, mesh%ends(side, e), k))
                  ! Displacement across the element, and rotation
                  ends(:, side) = [mesh%axis(1, e)*shape(2) - mesh%axis(2, e)*shape(1), shape(3)]
               end associate
            end do
            bent = ends(1, 2) - ends(1, 1)
            shear = 6*mesh%ei(e)/mesh%length(e)**2*(sum(ends(2, :)) - 2*bent/mesh%length(e))
            part = part + shear**2*mesh%length(e)/mesh%ea(e) &
               & *softness(deck, draft%material(mesh%member(e)), draft%section(mesh%member(e)))
            turning = turning + mesh%rho_a(e)*mesh%length(e)*mesh%ei(e)/mesh%ea(e)*(bent/mesh%length(e))**2
         end do
      end associate
      part = part/body%reduced%omega2(k)
      if (vibrates(deck)) part = 0.5_wp*(part + turning)
   end function unsheared_frame

   !> E A over the rigidity in shear of a section.
   real(wp) function softness(deck, material, section)
      type(deck_type), intent(in) :: deck
      !> Their blocks
      integer, intent(in) :: material, section
      real(wp) :: factor
      factor = shear_factor(deck%blocks(section), deck%blocks(section), 0.0_wp)
      if (.not. factor > 0.0_wp) factor = 5.0_wp/6
      softness = 2*(1 + deck%blocks(material)%real('POISSON'))/factor
   end function softness

   !> Whether anything bends a beam at rest: the links of a truss are only pulled.
   pure logical function is_bent(deck, choice)
      type(deck_type), intent(in) :: deck
      type(exact_choice_type), intent(in) :: choice
      integer :: i
      is_bent = any(choice%moment) .or. abs(choice%arc) + abs(choice%hot_curvature) > 0.0_wp &
         & .or. deck%find('GRAVITY') > 0 .or. deck%find('DISTRIBUTED LOAD') > 0
      if (allocated(choice%kinks)) is_bent = is_bent .or. size(choice%kinks) > 0
      if (allocated(choice%steps)) is_bent = is_bent .or. size(choice%steps) > 0
      do i = 1, size(deck%blocks)
         if (deck%blocks(i)%keyword == 'STATICS') is_bent = is_bent .or. deck%blocks(i)%has('ROTATION')
      end do
      if (allocated(choice%corners)) is_bent = is_bent .or. size(choice%corners) > 0
   end function is_bent

   !> Wave number of the first bending mode times the length.
   pure real(wp) function wave(support)
      type(support_type), intent(in) :: support
      integer :: held
      held = count([support%w_start, support%theta_start, support%w_end, support%theta_end])
      select case (held)
      case (4); wave = 4.730_wp
      case (3); wave = 3.927_wp
      case (2)
         wave = 3.1416_wp
         if (.not. (support%w_start .and. support%w_end)) wave = 1.875_wp
      case (1); wave = 3.927_wp
      case default; wave = 4.730_wp
      end select
   end function wave

end module limber_model_short_beams
