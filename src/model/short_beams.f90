!> Warnings of slender models on short beams. What they lack for want of shear and rotary inertia, and the warnings of that, for
!> beams and frames of all models. Floor: model. Source: doc/theory, eqs. (2.47), (2.48).
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
   use limber_model_held_ends, only: hold_type, holds_of
   use limber_model_frame_draft, only: draft_type, node_named
   use limber_model_model, only: model_type, body_type
   use limber_model_sections, only: shear_factor
   implicit none
   private
   public :: unsheared_beam, weigh_frame, warn_of_short

   !> Relative error for want of shear that is worth a warning
   real(wp), parameter :: noticed = 0.01_wp
   !> Finite elements of each member of a frame for its first vibrations
   integer, parameter :: divisions = 8
   !> Vibrations of a frame that are looked at: the first may be one along its members
   integer, parameter :: looked_at = 3
   !> More than what a beam lacks however it is held, as in `shear_and_turning`; stiffness of springs that hold frames, in that of a
   !> member
   real(wp), parameter :: largest = 50.0_wp, firm = 40.0_wp

contains

   !> Warns of beams and frames that are short.
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

   !> Whether a motion or vibrations are asked for.
   pure logical function vibrates(deck)
      type(deck_type), intent(in) :: deck
      vibrates = deck%find('DYNAMICS') > 0 .or. deck%find('MODES') > 0
   end function vibrates

   !> The error of a first frequency that is too high, or of a deflection at rest that is too small, beside the true one, eq.
   !> (2.48).
   pure real(wp) function lacking(deck, shear, turning)
      type(deck_type), intent(in) :: deck
      !> Elastic energy of shear beside that of the rest, kinetic energy of the sections' rotation beside that of the rest
      real(wp), intent(in) :: shear, turning
      lacking = shear/(1 + shear)
      if (vibrates(deck)) lacking = sqrt(1 + shear + turning) - 1
   end function lacking

   !> What a beam lacks without shear, eqs. (2.47), (2.48): of its frequencies where something may vibrate, else of its deflection,
   !> if anything bends it.
   real(wp) function unsheared_beam(deck, index, material, section, body) result(part)
      type(deck_type), intent(in) :: deck
      !> Blocks of the beam, of its material and of its section
      integer, intent(in) :: index, material, section
      !> With the choice of an exact beam
      type(body_type), intent(in) :: body
      type(support_type) :: support
      real(wp) :: slender, of_mode(2), hung
      part = 0.0_wp
      if (.not. (vibrates(deck) .or. is_bent(deck, body%choice%exact))) return
      slender = body%beam%ei/body%beam%ea/deck%blocks(index)%real('LENGTH')**2
      ! Nothing can be held so that a slender one lacks anything
      part = lacking(deck, largest*slender*softness(deck, material, section), largest*slender)
      if (part <= noticed) return
      call find_support(deck, deck%blocks(index), body%beam, support, hung)
      of_mode = shear_and_turning(support, hung)
      part = lacking(deck, of_mode(1)*slender*softness(deck, material, section), of_mode(2)*slender)
   end function unsheared_beam

   !> What holds the ends of a beam, springs too if they are stiff beside it, eq. (2.49), and the mass at its free end.
   subroutine find_support(deck, block, beam, support, hung)
      type(deck_type), intent(in) :: deck
      !> Of the beam
      type(block_type), intent(in) :: block
      type(beam_type), intent(in) :: beam
      type(support_type), intent(out) :: support
      !> In masses of the beam
      real(wp), intent(out) :: hung
      !> Stiffness of springs across, in E I/L^3, and against turning, in E I/L, that hold: of a beam that moves freely without
      !> them, and of one that is held
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

   !> The same of a frame by its first vibrations, held at the nodes that joints or *BOUNDARY hold, eq. (2.48); and the member with
   !> most of it.
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

   !> Twice the energies of the shear forces (members) and of the rotation of the sections in a vibration of a frame with unit mass.
   subroutine find_energies(deck, draft, mesh, shape, shear, turning)
      type(deck_type), intent(in) :: deck
      type(draft_type), intent(in) :: draft
      type(frame_type), intent(in) :: mesh
      !> Displacements and rotations of its nodes (3, nodes)
      real(wp), intent(in) :: shape(:, :)
      real(wp), intent(out) :: shear(:), turning
      real(wp) :: force, bent, ends(2, 2)
      integer :: e, side
      shear = 0.0_wp
      turning = 0.0_wp
      do e = 1, size(mesh%length)
         do side = 1, 2
            ! Displacement across the element, and rotation
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

   !> The mesh of a frame in the scene.
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

   !> Of the first vibration, for a beam of the length 1 with unit rigidities: energy of shear, and of the sections' rotation. A
   !> guided end is the middle of a beam of twice the length.
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

   !> Coordinate of a point of a beam; huge if it has none of that name.
   pure real(wp) function place_on(block, name) result(x)
      !> Of the beam
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
