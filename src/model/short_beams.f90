!> Warnings of slender models on short beams. Estimates of the error without shear and rotary inertia, for beams and frames of all
!> models. Floor: model. Source: doc/theory, eqs. (2.47), (2.48).
module limber_model_short_beams
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use limber_deck_content, only: deck_type, block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_beam_exact_functions, only: exact_choice_type
   use limber_beam_plane_frame, only: frame_type, member_type, new_frame
   use limber_beam_frame_reduction, only: frame_choice_type, reduce_frame, available_frame_modes
   use limber_beam_beam_mesh, only: support_type, beam_type
   use limber_beam_reduced_body, only: reduced_type
   use limber_beam_beam_reduction, only: fidelity_linear
   use limber_model_element_effects, only: holds_of
   use limber_model_held_ends, only: hold_type
   use limber_model_frame_draft, only: draft_type, node_named
   use limber_model_model, only: model_type, body_type
   use limber_model_sections, only: shear_factor
   implicit none
   private
   public :: unsheared_beam, weigh_frame, warn_of_short

   !> Smallest relative error that gives a warning
   real(wp), parameter :: noticed = 0.01_wp
   !> Elements per member of a frame for its first modes
   integer, parameter :: divisions = 8
   !> Number of modes of a frame to be checked: the first may be axial
   integer, parameter :: looked_at = 3
   !> Upper bound of the values of `shear_and_turning` for all supports; spring stiffness that counts as a support of a frame,
   !> relative to the stiffness of a member
   real(wp), parameter :: largest = 50.0_wp, firm = 40.0_wp

contains

   !> Warns of short beams and frames.
   subroutine warn_of_short(deck, model, diagnostics)
      type(deck_type), intent(in) :: deck
      type(model_type), intent(in) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: name, error
      integer :: i
      error = ': without shear its deflection is too small by about '
      if (vibrates(deck)) error = ': without shear and rotary inertia its first bending frequency is too high by about '
      do i = 1, size(model%bodies)
         associate (body => model%bodies(i))
            if (body%unsheared <= noticed) cycle
            name = body%name
            if (body%whole > 0) name = model%wholes(body%whole)%name
            associate (block => deck%blocks(deck%find_named('BEAM|FRAME', name)))
               if (block%keyword == 'FRAME') then
                  call diagnostics%warn(block%origin, "frame '"//name//"' has short members"//error// &
                     & as_text(100*body%unsheared, 2)//' %, most of it in member '//as_text(body%shortest), &
                     & 'where that counts, weld a *BEAM with SHEAR=YES in the place of such a member')
               else
                  call diagnostics%warn(block%origin_of('LENGTH'), "beam '"//name//"' is short"//error// &
                     & as_text(100*body%unsheared, 2)//' %', trim(merge('use SHEAR=YES                 ', &
                     & 'use GEOMETRIC=EXACT, SHEAR=YES', block%word('GEOMETRIC') == 'EXACT')))
               end if
            end associate
         end associate
      end do
   end subroutine warn_of_short

   !> Whether the deck has *DYNAMICS or *MODES.
   pure logical function vibrates(deck)
      type(deck_type), intent(in) :: deck
      vibrates = deck%find('DYNAMICS') > 0 .or. deck%find('MODES') > 0
   end function vibrates

   !> Relative error of the model without shear, eq. (2.48): first frequency too high, or static deflection too small.
   pure real(wp) function lacking(deck, shear, turning)
      type(deck_type), intent(in) :: deck
      !> Ratio of shear energy to bending energy; ratio of the kinetic energy of the sections' rotation to that of translation
      real(wp), intent(in) :: shear, turning
      lacking = shear/(1 + shear)
      if (vibrates(deck)) lacking = sqrt(1 + shear + turning) - 1
   end function lacking

   !> Relative error of a beam without shear, eqs. (2.47), (2.48): of its frequency if the deck has vibrations, else of its
   !> deflection; 0 if nothing bends it.
   real(wp) function unsheared_beam(deck, index, material, section, body) result(part)
      type(deck_type), intent(in) :: deck
      !> Blocks of the beam, of its material and of its section
      integer, intent(in) :: index, material, section
      !> Body with the options of the exact beam
      type(body_type), intent(in) :: body
      type(support_type) :: support
      real(wp) :: slender, of_mode(2), hung
      part = 0.0_wp
      if (.not. (vibrates(deck) .or. is_bent(deck, body%choice%exact))) return
      ! A section or a length in error has none
      if (.not. body%beam%ea*deck%blocks(index)%real('LENGTH') > 0.0_wp) return
      slender = body%beam%ei/body%beam%ea/deck%blocks(index)%real('LENGTH')**2
      ! First an upper bound for all supports
      part = lacking(deck, largest*slender*softness(deck, material, section), largest*slender)
      if (part <= noticed) return
      call find_support(deck, deck%blocks(index), body%beam, support, hung)
      of_mode = shear_and_turning(support, hung)
      part = lacking(deck, of_mode(1)*slender*softness(deck, material, section), of_mode(2)*slender)
   end function unsheared_beam

   !> Supports of the ends of a beam, stiff springs included, eq. (2.49), and the mass at its free ends.
   subroutine find_support(deck, block, beam, support, hung)
      type(deck_type), intent(in) :: deck
      !> Block of the beam
      type(block_type), intent(in) :: block
      type(beam_type), intent(in) :: beam
      type(support_type), intent(out) :: support
      !> Mass at free ends, in masses of the beam
      real(wp), intent(out) :: hung
      !> Smallest spring stiffness that counts as a support: transverse [E I/L^3] and rotational [E I/L]; first for a beam that is
      !> free without the springs, then for a supported beam
      real(wp), parameter :: across(2) = [10.0_wp, 40.0_wp], turning(2) = [0.5_wp, 5.0_wp]
      type(hold_type), allocatable :: holds(:)
      logical :: at(2), held(2), clamped(2)
      real(wp) :: spring(2, 2), mass(2)
      integer :: i, k
      held = .false.
      clamped = .false.
      spring = 0.0_wp
      mass = 0.0_wp
      call holds_of(deck, block%name(), holds)
      associate (length => block%real('LENGTH'))
         if (allocated(beam%mass)) mass = beam%mass([0, beam%elements])
         do i = 1, size(holds)
            at = abs(place_on(block, trim(holds(i)%name)) - [0.0_wp, length]) < 1.0e-6_wp*length
            where (at)
               held = held .or. holds(i)%held(2)
               clamped = clamped .or. holds(i)%clamped
               spring(:, 1) = spring(:, 1) + holds(i)%across*length**3/beam%ei
               spring(:, 2) = spring(:, 2) + holds(i)%turning*length/beam%ei
               mass = mass + holds(i)%mass
            end where
         end do
         do k = merge(1, 2, count([held, clamped]) < 2), 2
            where (spring(:, 1) > across(k)) held = .true.
            where (spring(:, 2) > turning(k)) clamped = .true.
         end do
         hung = sum(mass, mask=.not. held)/(beam%rho_a*length)
      end associate
      support%w_start = held(1)
      support%theta_start = clamped(1)
      support%w_end = held(2)
      support%theta_end = clamped(2)
   end subroutine find_support

   !> Relative error of a frame without shear, by its first modes with the nodes fixed at joints and *BOUNDARY, eq. (2.48); and the
   !> member with the largest contribution.
   subroutine weigh_frame(deck, index, draft, part, shortest)
      type(deck_type), intent(in) :: deck
      !> Block of the frame
      integer, intent(in) :: index
      type(draft_type), intent(in) :: draft
      real(wp), intent(out) :: part
      !> Number of the member in the deck
      integer, intent(out) :: shortest
      type(frame_type) :: mesh
      type(frame_choice_type) :: choice
      type(reduced_type) :: reduced
      type(error_type), allocatable :: error
      real(wp), allocatable :: shape(:, :, :)
      real(wp) :: shear(size(draft%number)), turning, own
      integer :: k
      part = 0.0_wp
      shortest = 0
      mesh = held_frame(deck, index, draft)
      choice%modes = min(looked_at, available_frame_modes(mesh))
      choice%fidelity = fidelity_linear
      allocate (choice%attachments(2, 0))
      if (choice%modes == 0) return
      call reduce_frame(mesh, choice, reduced, shape, error)
      if (allocated(error)) return
      do k = 1, reduced%n
         call find_energies(deck, draft, mesh, shape(:, :, k), shear, turning)
         own = lacking(deck, sum(shear)/reduced%omega2(k), turning)*reduced%omega2(1)/reduced%omega2(k)
         if (own > part) shortest = draft%number(maxloc(shear, dim=1))
         part = max(part, own)
      end do
   end subroutine weigh_frame

   !> Twice the energy of the shear forces of each member (members), and of the rotation of sections, in a mode with unit modal
   !> mass.
   subroutine find_energies(deck, draft, mesh, shape, shear, turning)
      type(deck_type), intent(in) :: deck
      type(draft_type), intent(in) :: draft
      type(frame_type), intent(in) :: mesh
      !> Displacements and rotation of each node (3, nodes)
      real(wp), intent(in) :: shape(:, :)
      real(wp), intent(out) :: shear(:), turning
      real(wp) :: force, bent, ends(2, 2)
      integer :: e, side
      shear = 0.0_wp
      turning = 0.0_wp
      do e = 1, size(mesh%length)
         do side = 1, 2
            ! Transverse displacement, and rotation
            associate (moved => shape(:, mesh%ends(side, e)))
               ends(:, side) = [mesh%axis(1, e)*moved(2) - mesh%axis(2, e)*moved(1), moved(3)]
            end associate
         end do
         bent = (ends(1, 2) - ends(1, 1))/mesh%length(e)
         force = 6*mesh%ei(e)/mesh%length(e)**2*(sum(ends(2, :)) - 2*bent)
         associate (m => mesh%member(e))
            shear(m) = shear(m) + force**2*mesh%length(e)/mesh%ea(e)*softness(deck, draft%material(m), draft%section(m))
         end associate
         turning = turning + mesh%rho_a(e)*mesh%length(e)*mesh%ei(e)/mesh%ea(e)*bent**2
      end do
   end subroutine find_energies

   !> Mesh of a frame with its supports and hanging masses in the scene.
   function held_frame(deck, index, draft) result(mesh)
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: index
      type(draft_type), intent(in) :: draft
      type(frame_type) :: mesh
      type(member_type) :: members(size(draft%members))
      type(hold_type), allocatable :: holds(:)
      real(wp) :: length, ei
      integer :: i, node
      members = draft%members
      members%divisions = divisions
      mesh = new_frame(draft%place, members)
      do i = 1, size(draft%node)
         mesh%free(:, i) = draft%free(:, i)
         mesh%mass(:, i) = mesh%mass(:, i) + [draft%mass(i), draft%mass(i), draft%inertia(i)]
      end do
      length = sum(mesh%length)/size(draft%members)
      ei = maxval(mesh%ei)
      call holds_of(deck, deck%blocks(index)%name(), holds)
      do i = 1, size(holds)
         node = node_named(deck, index, draft, trim(holds(i)%name))
         if (node == 0) cycle
         mesh%mass(1:2, node) = mesh%mass(1:2, node) + holds(i)%mass
         mesh%free(1:2, node) = mesh%free(1:2, node) .and. .not. (holds(i)%held .or. holds(i)%across > firm*ei/length**3)
         if (holds(i)%clamped .or. holds(i)%turning > firm*ei/length) mesh%free(3, node) = .false.
      end do
   end function held_frame

   !> Ratio of E A to the shear rigidity of a section.
   real(wp) function softness(deck, material, section)
      type(deck_type), intent(in) :: deck
      !> Blocks of the material and the section
      integer, intent(in) :: material, section
      real(wp) :: factor
      factor = shear_factor(deck%blocks(section), deck%blocks(section), 0.0_wp)
      if (.not. factor > 0.0_wp) factor = 5.0_wp/6
      softness = 2*(1 + deck%blocks(material)%real('POISSON'))/factor
   end function softness

   !> Whether anything bends a beam at rest: links of a truss are under tension only.
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

   !> Energies of shear and of the sections' rotation in the first mode, for a beam with length 1 and unit rigidities (2). A guided
   !> end counts as the middle of a beam with twice the length.
   pure function shear_and_turning(support, hung) result(parts)
      type(support_type), intent(in) :: support
      !> Mass at the free end of a cantilever, in masses of the beam
      real(wp), intent(in) :: hung
      real(wp) :: parts(2)
      integer :: across, turning
      logical :: same
      across = count([support%w_start, support%w_end])
      turning = count([support%theta_start, support%theta_end])
      same = support%w_start .eqv. support%theta_start
      select case (10*across + turning)
      case (22); parts = [49.48_wp, 12.30_wp]
      case (21); parts = [27.23_wp, 11.51_wp]
      case (20, 02); parts = 9.870_wp
      case (12); parts = [49.48_wp, 12.30_wp]/4
      case (11)
         parts = 9.870_wp/4
         if (same) parts = 4.648_wp*[(1 + 5.2_wp*hung)/(1 + 8*hung), 1/(1 + 4*hung)]
      case (10); parts = [11.51_wp, 27.23_wp]
      case (01); parts = [12.30_wp, 49.48_wp]/4
      case default; parts = [12.30_wp, 49.48_wp]
      end select
   end function shear_and_turning

   !> Coordinate of a point on a beam [length]; huge if there is no point with this name.
   pure real(wp) function place_on(block, name) result(x)
      !> Block of the beam
      type(block_type), intent(in) :: block
      character(*), intent(in) :: name
      integer :: i
      x = huge(x)
      select case (name)
      case ('start'); x = 0.0_wp
      case ('end'); x = block%real('LENGTH')
      case ('origin'); x = block%real('ORIGIN')
      case default
         do i = 1, size(block%lines)
            if (block%lines(i)%text(1) == name) x = block%lines(i)%number(2)
         end do
      end select
   end function place_on

end module limber_model_short_beams
