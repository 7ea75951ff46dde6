!> Rigidities, mesh, masses, modes and functions of a beam. Floor: model.
module limber_model_beam_choice
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_deck_content, only: deck_type, block_type, line_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_beam_static_functions, only: attachment_type
   use limber_beam_beam_mesh, only: beam_type, new_support, concentrate, put_nodes
   use limber_beam_beam_reduction, only: reduction_type, available_modes, fidelity_linear, fidelity_kg, fidelity_exact
   use limber_model_element_effects, only: acting_points, find_shared, find_turning
   use limber_model_points_of_action, only: acting_type
   use limber_model_body_parts, only: is_part
   use limber_model_beam_layers, only: layer_lengths
   use limber_model_beam_features, only: read_features, refuse_features
   use limber_model_points, only: find_named, lies_outside
   use limber_model_model, only: body_type
   use limber_model_sections, only: read_section
   use limber_model_beam_segments, only: choose_frame, piece_at
   use limber_model_short_beams, only: unsheared_beam
   implicit none
   private
   public :: read_beam

contains

   !> Reads rigidities, mesh and reduction options of a piece of a beam.
   subroutine read_beam(deck, index, piece, pieces, body, rigid, diagnostics, usable)
      type(deck_type), intent(inout) :: deck
      integer, intent(in) :: index, piece, pieces
      type(body_type), intent(inout) :: body
      !> Rigid beam: mass, coordinate of the centre of mass, moment of inertia about it
      real(wp), intent(out) :: rigid(3)
      type(diagnostics_type), intent(inout) :: diagnostics
      !> False if the beam cannot be reduced
      logical, intent(out) :: usable
      integer :: material, section, before
      before = diagnostics%count
      material = deck%find_named('MATERIAL', deck%blocks(index)%name('MATERIAL'))
      section = deck%find_named('SECTION', deck%blocks(index)%name('SECTION'))
      allocate (body%strength(4, 1))
      body%strength(:, 1) = [1.0_wp, 1.0_wp, 0.0_wp, 0.0_wp]
      body%beam%rho_a = 1.0_wp
      if (section > 0) call read_section(deck%blocks(section), body%strength(:, 1), diagnostics)
      if (material > 0) then
         body%beam%ea = body%strength(1, 1)*deck%blocks(material)%real('YOUNG')
         body%beam%ei = body%strength(2, 1)*deck%blocks(material)%real('YOUNG')
         body%beam%rho_a = body%strength(1, 1)*deck%blocks(material)%real('DENSITY')
      end if
      body%beam%length = deck%blocks(index)%real('LENGTH')/pieces
      body%beam%elements = deck%blocks(index)%integer('ELEMENTS')
      rigid(1) = body%beam%rho_a*body%beam%length
      rigid(2:3) = [0.5_wp*body%beam%length, body%beam%rho_a*body%beam%length**3/12]
      call read_masses(deck, index, piece, pieces, body, rigid, diagnostics)
      associate (block => deck%blocks(index))
         body%choice = new_choice(block)
         call choose_attachments(deck, index, piece, pieces, body%beam, body%choice, diagnostics)
         if (piece == 1 .and. (body%choice%origin < 0.0_wp .or. body%choice%origin > block%real('LENGTH'))) call diagnostics%add( &
            & block%origin_of('ORIGIN'), "the origin of the frame lies outside beam '"//body%name//"'", &
            & 'give a coordinate from 0 to '//as_text(block%real('LENGTH')))
         if (pieces > 1) call choose_frame(block, piece, body%choice)
         if (body%choice%fidelity == fidelity_exact) call choose_exact(deck, index, piece, pieces, body)
         if (body%choice%fidelity /= fidelity_exact .or. (piece == 1 .and. pieces > 1)) &
            & call refuse_features(deck, index, body%choice%fidelity == fidelity_exact, diagnostics)
         if (body%choice%fidelity == fidelity_exact .and. section > 0 .and. material > 0 .and. diagnostics%count == before) &
            & call read_features(deck, index, material, section, body, diagnostics)
         usable = section > 0 .and. material > 0 .and. diagnostics%count == before .and. body%beam%length > 0.0_wp &
            & .and. body%beam%elements > 0 .and. body%choice%geometric_elements > 0
         if (usable) call check_modes(block, body, diagnostics)
         if (usable .and. pieces == 1 .and. body%choice%fidelity /= fidelity_exact) then
            call check_parts(deck, index, body, diagnostics)
            call check_chord(deck, block, diagnostics)
         end if
         ! Members of a large frame are checked with the frame
         if (usable .and. piece == 1 .and. scan(block%name(), '/') == 0 .and. block%word('GEOMETRIC') /= 'RIGID' .and. &
            & .not. block%yes('SHEAR')) call weigh_shear(deck, index, material, section, body)
         usable = usable .and. diagnostics%count == before
      end associate
   end subroutine read_beam

   !> Adds the masses of *MASS to a piece of a beam.
   subroutine read_masses(deck, index, piece, pieces, body, rigid, diagnostics)
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: index, piece, pieces
      type(body_type), intent(inout) :: body
      real(wp), intent(inout) :: rigid(3)
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i, k, before
      real(wp) :: x, inertia, centre
      if (.not. (body%beam%length > 0.0_wp .and. body%beam%elements > 0)) return
      do i = 1, size(deck%blocks)
         ! A quick test, for decks with thousands of beams
         if (len(deck%blocks(i)%keyword) /= len('MASS')) cycle
         if (deck%blocks(i)%keyword /= 'MASS') cycle
         if (.not. is_part(deck, i, index)) cycle
         do k = 1, size(deck%blocks(i)%lines)
            associate (line => deck%blocks(i)%lines(k))
               before = diagnostics%count
               x = beam_place(deck, deck%blocks(index), line, diagnostics)
               if (diagnostics%count == before .and. lies_outside(x, deck%blocks(index)%real('LENGTH'))) &
                  & call diagnostics%add(line%origin_of(1), 'the mass lies outside the beam', &
                  & 'give a coordinate from 0 to '//as_text(deck%blocks(index)%real('LENGTH')))
               if (diagnostics%count > before .or. piece_at(x, body%beam%length, pieces) /= piece) cycle
               x = min(max(x - (piece - 1)*body%beam%length, 0.0_wp), body%beam%length)
               inertia = 0.0_wp
               if (line%count() > 2) inertia = line%number(3)
               call concentrate(body%beam, x, line%number(2), inertia)
               centre = (rigid(1)*rigid(2) + line%number(2)*x)/(rigid(1) + line%number(2))
               rigid(3) = rigid(3) + inertia + rigid(1)*(rigid(2) - centre)**2 + line%number(2)*(x - centre)**2
               rigid(1:2) = [rigid(1) + line%number(2), centre]
            end associate
         end do
      end do
   end subroutine read_masses

   !> Coordinate along a beam in the first field of a line: a number, a point of the beam, or else a parameter.
   real(wp) function beam_place(deck, block, line, diagnostics) result(x)
      type(deck_type), intent(in) :: deck
      !> Block of the beam
      type(block_type), intent(in) :: block
      type(line_type), intent(in) :: line
      type(diagnostics_type), intent(inout) :: diagnostics
      logical :: found
      integer :: parameter
      x = line%number(1)
      if (line%text(1) == '') return
      call find_beam_point(block, line%text(1), x, found)
      if (found) return
      parameter = deck%parameters%find(line%text(1))
      found = parameter > 0
      if (found) x = deck%parameters%items(parameter)%value
      if (.not. found) call diagnostics%add(line%origin_of(1), "beam '"//block%name()//"' has no point '"//line%text(1)//"'", &
         & 'give a coordinate, or a point that the beam names')
   end function beam_place

   !> Coordinate of a named point along a beam [length].
   subroutine find_beam_point(block, name, x, found)
      !> Block of the beam
      type(block_type), intent(in) :: block
      character(*), intent(in) :: name
      !> Unchanged if there is no such point
      real(wp), intent(inout) :: x
      logical, intent(out) :: found
      integer :: i
      found = .true.
      select case (name)
      case ('start'); x = 0.0_wp
      case ('middle'); x = 0.5_wp*block%real('LENGTH')
      case ('end'); x = block%real('LENGTH')
      case ('origin'); x = block%real('ORIGIN')
      case default
         do i = 1, size(block%lines)
            if (block%lines(i)%text(1) /= name) cycle
            x = block%lines(i)%number(2)
            return
         end do
         found = .false.
      end select
   end subroutine find_beam_point

   !> Chooses static functions: those of *ATTACHMENT, and with CORRECTIONS=YES those of all points of action.
   subroutine choose_attachments(deck, index, piece, pieces, beam, choice, diagnostics)
      type(deck_type), intent(in) :: deck
      !> Block of the beam; number of the piece, number of pieces
      integer, intent(in) :: index, piece, pieces
      !> Receives nodes at the points of action
      type(beam_type), intent(inout) :: beam
      type(reduction_type), intent(inout) :: choice
      type(diagnostics_type), intent(inout) :: diagnostics
      type(attachment_type), allocatable :: named(:), acting(:)
      call read_attachments(deck, index, named, diagnostics)
      allocate (acting(0))
      if (choice%fidelity /= fidelity_exact) then
         call find_acting(deck, index, acting)
         if (pieces == 1 .and. beam%length > 0.0_wp .and. beam%elements > 0) call put_nodes(beam, within([named%x, acting%x]))
      end if
      if (.not. deck%blocks(index)%yes('CORRECTIONS')) acting = acting(:0)
      if (pieces > 1) then
         call keep_piece(named, piece, pieces, deck%blocks(index)%real('LENGTH')/pieces)
         call keep_piece(acting, piece, pieces, deck%blocks(index)%real('LENGTH')/pieces)
      end if
      allocate (choice%corrections, source=[named, others(acting, named)])

   contains

      !> Coordinates that lie on the beam.
      pure function within(x)
         real(wp), intent(in) :: x(:)
         real(wp), allocatable :: within(:)
         allocate (within, source=pack(x, x >= 0.0_wp .and. x <= beam%length))
      end function within

   end subroutine choose_attachments

   !> Keeps the attachments on one piece, with coordinates along this piece.
   subroutine keep_piece(attachments, piece, pieces, length)
      type(attachment_type), allocatable, intent(inout) :: attachments(:)
      integer, intent(in) :: piece, pieces
      !> Length of a piece [length]
      real(wp), intent(in) :: length
      type(attachment_type), allocatable :: kept(:)
      integer :: i
      allocate (kept, source=pack(attachments, [(piece_at(attachments(i)%x, length, pieces) == piece, i=1, size(attachments))]))
      kept%x = kept%x - (piece - 1)*length
      call move_alloc(kept, attachments)
   end subroutine keep_piece

   !> Attachments that are not in the second list.
   pure function others(attachments, among) result(rest)
      type(attachment_type), intent(in) :: attachments(:), among(:)
      type(attachment_type), allocatable :: rest(:)
      logical :: keep(size(attachments))
      integer :: i
      do i = 1, size(attachments)
         keep(i) = .not. any(among%part == attachments(i)%part .and. .not. abs(among%x - attachments(i)%x) > 0.0_wp)
      end do
      allocate (rest, source=pack(attachments, keep))
   end function others

   !> Reads the attachments of *ATTACHMENT on a beam.
   subroutine read_attachments(deck, index, named, diagnostics)
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: index
      type(attachment_type), allocatable, intent(out) :: named(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i, k, part, before
      real(wp) :: x
      allocate (named(0))
      do i = 1, size(deck%blocks)
         if (deck%blocks(i)%keyword /= 'ATTACHMENT') cycle
         if (.not. is_part(deck, i, index)) cycle
         do k = 1, size(deck%blocks(i)%lines)
            associate (line => deck%blocks(i)%lines(k), length => deck%blocks(index)%real('LENGTH'))
               before = diagnostics%count
               x = beam_place(deck, deck%blocks(index), line, diagnostics)
               if (diagnostics%count > before) cycle
               part = findloc([1, 2, 6], nint(line%number(2)), dim=1)
               if (lies_outside(x, length)) then
                  call diagnostics%add(line%origin_of(1), 'the attachment lies outside the beam', &
                     & 'give a coordinate from 0 to '//as_text(length))
               else if (part == 0) then
                  call diagnostics%add(line%origin_of(2), 'a beam has no degree of freedom '//as_text(nint(line%number(2))), &
                     & 'give 1 (along), 2 (across) or 6 (rotation)')
               else
                  named = [named, attachment_type(1, min(max(x, 0.0_wp), length), part)]
               end if
            end associate
         end do
      end do
   end subroutine read_attachments

   !> Attachments for all forces and couples of joints, drivers and loads on a beam.
   subroutine find_acting(deck, index, acting)
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: index
      type(attachment_type), allocatable, intent(inout) :: acting(:)
      type(acting_type), allocatable :: points(:)
      type(attachment_type) :: at(3)
      logical :: found
      integer :: i
      call acting_points(deck, deck%blocks(index)%name(), points)
      do i = 1, size(points)
         call find_beam_point(deck%blocks(index), trim(points(i)%name), at(1)%x, found)
         if (.not. found) cycle
         at%x = at(1)%x
         at%part = [1, 2, 3]
         acting = [acting, others(pack(at, [points(i)%force, points(i)%force, points(i)%couple]), acting)]
      end do
   end subroutine find_acting

   !> Chooses the functions of an exact beam: their numbers; the support of the modes, by default from the joints; points of action
   !> between the ends; moments and shear forces at the ends.
   subroutine choose_exact(deck, index, piece, pieces, body)
      type(deck_type), intent(in) :: deck
      !> Block of the beam; number of the piece, number of pieces
      integer, intent(in) :: index, piece, pieces
      type(body_type), intent(inout) :: body
      type(acting_type), allocatable :: points(:)
      real(wp), allocatable :: x(:)
      character(:), allocatable :: support
      logical :: found
      real(wp) :: length
      integer :: i
      associate (block => deck%blocks(index), choice => body%choice%exact)
         length = body%beam%length
         choice%angles = block%integer('FUNCTIONS')
         choice%strains = block%integer('STRAIN FUNCTIONS')
         choice%origin = body%choice%origin
         choice%support = body%choice%support
         call acting_points(deck, block%name(), points)
         allocate (x(size(points)))
         x = -1.0_wp
         do i = 1, size(points)
            call find_beam_point(block, trim(points(i)%name), x(i), found)
            ! A point on another piece gets the coordinate -1
            if (piece_at(x(i), length, pieces) /= piece) x(i) = -1.0_wp
            if (x(i) >= 0.0_wp) x(i) = max(x(i) - (piece - 1)*length, 0.0_wp)
         end do
         call find_shared(deck, block%name(), x > 0.0_wp .and. x < length, points)
         choice%kinks = [pack(x, points%force), attached(2)]
         choice%steps = [pack(x, points%couple), attached(3)]
         choice%pulls = [pack(x, points%shared), attached(1)]
         choice%corners = ends_of_spreads(deck, block, piece, pieces, length)
         if (allocated(body%beam%mass)) then
            choice%kinks = [choice%kinks, pack(body%beam%place, body%beam%mass > 0.0_wp)]
            choice%steps = [choice%steps, pack(body%beam%place, body%beam%inertia > 0.0_wp)]
         end if
         support = end_support(0.0_wp)//'-'//end_support(length)
         ! Pieces are welded to each other
         if (pieces > 1) support = 'CLAMPED-FREE'
         if (pieces > 1 .or. .not. block%given('SUPPORT')) choice%support = new_support(support)
         choice%moment = [acts(0.0_wp, points%couple .or. points%clamped), acts(length, points%couple .or. points%clamped)] &
            & .or. [choice%support%theta_start, choice%support%theta_end] .or. pieces > 1
         choice%shear_force = [acts(0.0_wp, points%force .or. points%held), acts(length, points%force .or. points%held)] &
            & .or. [choice%support%w_start, choice%support%w_end] .or. pieces > 1 .or. block%yes('SHEAR')
         choice%layered = [piece == 1 .and. spreads(0.0_wp), piece == pieces .and. spreads(length)] &
            & .or. [choice%support%theta_start, choice%support%theta_end] .and. pieces == 1
         if (any(choice%layered) .or. size(choice%kinks) + size(choice%steps) > 0) &
            & choice%layers = layer_lengths(deck, block, body%beam)
         if (allocated(body%beam%mass)) then
            i = body%beam%elements
            choice%moment = choice%moment .or. body%beam%inertia([0, i]) > 0.0_wp
            choice%shear_force = choice%shear_force .or. body%beam%mass([0, i]) + body%beam%inertia([0, i]) > 0.0_wp
         end if
      end associate

   contains

      !> Places with a static function of this part: 1 along the beam, 2 across, 3 couple.
      pure function attached(part) result(places)
         integer, intent(in) :: part
         real(wp), allocatable :: places(:)
         associate (named => body%choice%corrections)
            allocate (places, source=pack(named%x, named%part == part))
         end associate
      end function attached

      !> Whether one of these points is at an end.
      pure logical function acts(end, where)
         real(wp), intent(in) :: end
         logical, intent(in) :: where(:)
         acts = any(where .and. abs(x - end) < 1.0e-6_wp*length)
      end function acts

      !> Whether a bending boundary layer starts at an end. Weight makes a small one at a hinge: it counts if the deck gives a
      !> tension.
      pure logical function spreads(end)
         real(wp), intent(in) :: end
         spreads = acts(end, points%couple .or. points%clamped .or. (points%held .and. (deck%blocks(index)%given('TENSION') &
            & .or. abs(deck%blocks(index)%real('PRETENSION')) > 0.0_wp)))
      end function spreads

      !> Support of an end.
      pure function end_support(end) result(word)
         real(wp), intent(in) :: end
         character(:), allocatable :: word
         word = 'FREE'
         if (acts(end, points%held)) word = 'PINNED'
         if (acts(end, points%clamped)) word = 'CLAMPED'
      end function end_support

   end subroutine choose_exact

   !> Computes the relative error of a beam for want of shear, from an exact beam in one piece in its place.
   subroutine weigh_shear(deck, index, material, section, body)
      type(deck_type), intent(in) :: deck
      !> Blocks of the beam, of its material and of its section
      integer, intent(in) :: index, material, section
      type(body_type), intent(inout) :: body
      type(body_type) :: whole
      whole%beam = body%beam
      whole%beam%length = deck%blocks(index)%real('LENGTH')
      whole%choice = body%choice
      call choose_exact(deck, index, 1, 1, whole)
      body%unsheared = unsheared_beam(deck, index, material, section, whole)
   end subroutine weigh_shear

   !> Warns of joints at two points of a beam whose modes have no axial strain between them.
   subroutine check_parts(deck, index, body, diagnostics)
      type(deck_type), intent(in) :: deck
      !> Block of the beam
      integer, intent(in) :: index
      type(body_type), intent(in) :: body
      type(diagnostics_type), intent(inout) :: diagnostics
      type(acting_type), allocatable :: points(:)
      real(wp), allocatable :: x(:)
      logical :: found
      integer :: i
      associate (block => deck%blocks(index))
         call acting_points(deck, block%name(), points)
         allocate (x(size(points)), source=0.0_wp)
         do i = 1, size(points)
            call find_beam_point(block, trim(points(i)%name), x(i), found)
         end do
         call find_shared(deck, block%name(), x > 0.0_wp .and. x < body%beam%length, points)
         do i = 1, size(points)
            if (.not. points(i)%firm) cycle
            if (any(body%choice%corrections%part == 1 .and. .not. abs(body%choice%corrections%x - x(i)) > 0.0_wp)) cycle
            call diagnostics%warn(block%origin, "joints hold beam '"//block%name()//"' at '"//trim(points(i)%name)// &
               & "' and elsewhere: its modes do not follow how it stretches between them, so that forces of these joints and"// &
               & ' axial forces may be wrong', 'use GEOMETRIC=EXACT, or CORRECTIONS=YES')
            return
         end do
      end associate
   end subroutine check_parts

   !> Warns of drivers and torques on the frame of a modal beam without a given SUPPORT: the frame is then the line through its
   !> ends.
   subroutine check_chord(deck, block, diagnostics)
      type(deck_type), intent(in) :: deck
      !> Block of the beam
      type(block_type), intent(in) :: block
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i
      if (block%given('SUPPORT') .or. block%word('SUPPORT') /= 'PINNED-ROLLER' .or. block%word('GEOMETRIC') == 'RIGID') return
      i = find_turning(deck, block%name())
      if (i == 0) return
      call diagnostics%warn(deck%blocks(i)%origin, "'"//deck%blocks(i)%name()//"' acts on the floating frame of beam '"// &
         & block%name()//"', the line through its two ends (SUPPORT=PINNED-ROLLER): it holds or loads both ends, and the"// &
         & ' sections there turn freely', 'to act on its start, use SUPPORT=CLAMPED-FREE or GEOMETRIC=EXACT; if the line is'// &
         & ' meant, write SUPPORT=PINNED-ROLLER')
   end subroutine check_chord

   !> Start and end coordinates of distributed loads on a beam, along this piece [length].
   function ends_of_spreads(deck, block, piece, pieces, length) result(places)
      type(deck_type), intent(in) :: deck
      !> Block of the beam
      type(block_type), intent(in) :: block
      integer, intent(in) :: piece, pieces
      !> Length of the piece [length]
      real(wp), intent(in) :: length
      real(wp), allocatable :: places(:), ends(:)
      integer :: i, k
      allocate (places(0), ends(2))
      do i = 1, size(deck%blocks)
         if (deck%blocks(i)%keyword /= 'DISTRIBUTED LOAD') cycle
         if (deck%blocks(i)%name('BODY') /= block%name()) cycle
         ends = [deck%blocks(i)%real('START'), pieces*length]
         if (deck%blocks(i)%has('END')) ends(2) = deck%blocks(i)%real('END')
         do k = 1, 2
            if (piece_at(ends(k), length, pieces) == piece) places = [places, ends(k) - (piece - 1)*length]
         end do
      end do
   end function ends_of_spreads

   !> Reduction options of the block.
   function new_choice(block) result(choice)
      type(block_type), intent(in) :: block
      type(reduction_type) :: choice
      choice%support = new_support(block%word('SUPPORT'))
      if (block%given('BENDING MODES') .or. block%given('AXIAL MODES')) then
         choice%bending = block%integer('BENDING MODES')
         choice%axial = block%integer('AXIAL MODES')
         if (.not. block%given('BENDING MODES')) choice%bending = block%integer('MODES')
      else
         choice%modes = block%integer('MODES')
      end if
      select case (block%word('GEOMETRIC'))
      case ('LINEAR'); choice%fidelity = fidelity_linear
      case ('K_G'); choice%fidelity = fidelity_kg
      case ('EXACT'); choice%fidelity = fidelity_exact
      end select
      choice%geometric_elements = block%integer('GEOMETRIC ELEMENTS')
      choice%nodal = block%word('GEOMETRIC INTEGRAL') == 'NODAL'
      choice%linear = block%word('GEOMETRIC INTEGRAL') == 'LINEAR'
      choice%static_axial = block%word('AXIAL BASIS') == 'STATIC'
      choice%origin = block%real('ORIGIN')
   end function new_choice

   !> Reports more modes than the lumped mass provides.
   subroutine check_modes(block, body, diagnostics)
      type(block_type), intent(in) :: block
      type(body_type), intent(in) :: body
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: available(2)
      if (body%choice%fidelity == fidelity_exact) return
      available = available_modes(body%beam, body%choice)
      call check_count('MODES', body%choice%modes, sum(available), 'bending and axial')
      call check_count('BENDING MODES', body%choice%bending, available(1), 'bending')
      if (.not. body%choice%static_axial) call check_count('AXIAL MODES', body%choice%axial, available(2), 'axial')

   contains

      !> Reports one number of modes above the available number.
      subroutine check_count(option, wanted, most, kind)
         character(*), intent(in) :: option, kind
         integer, intent(in) :: wanted, most
         if (wanted <= most) return
         call diagnostics%add(block%origin_of(option), "beam '"//body%name//"': "//as_text(wanted)//' '//kind// &
            & ' modes are asked for, but the lumped mass of '//as_text(body%beam%elements)//' elements, '// &
            & block%word('SUPPORT')//', gives '//as_text(most), &
            & 'at most '//as_text(most)//', or raise ELEMENTS')
      end subroutine check_count

   end subroutine check_modes

end module limber_model_beam_choice
