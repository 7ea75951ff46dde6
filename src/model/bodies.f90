!> Bodies and their named points from the deck: rigid bodies, point masses, and beams with their modes. Floor: model.
module limber_model_bodies
   use limber_base_kinds, only: wp, long
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use limber_deck_content, only: deck_type, block_type, line_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_origin, only: origin_type
   use limber_flex_functions, only: attachment_type
   use limber_flex_library, only: library_type
   use limber_flex_mesh, only: new_support, concentrate
   use limber_flex_reduced, only: rigid_reduced, bytes_of
   use limber_flex_reduction, only: reduction_type, reduce_beam, available_modes, fidelity_linear, fidelity_kg, &
      & fidelity_full, axial_by_modes, axial_by_elements, axial_static
   use limber_model_acting, only: acting_type, acting_points
   use limber_model_lists, only: append
   use limber_model_parts, only: is_part
   use limber_model_points, only: add_point, enter_name, find_named
   use limber_model_scene, only: model_type, body_type, body_point, body_rigid, body_flexible
   use limber_model_sections, only: read_section
   use limber_model_segments, only: number_of_pieces, choose_basis, choose_frame, place_piece, piece_at, unite, weld_pieces, &
      & add_beam_point
   implicit none
   private
   public :: add_rigid_body, add_point_mass, add_beam, add_points, new_body, append_body, is_new_point, warn_of_rounding

   !> Most memory of the constants and shapes of all bodies [bytes]
   integer(long), parameter :: max_bytes = 1024_long*1024**2

contains

   !> The guess of a body's place and motion, common to all kinds.
   function new_body(block, kind) result(body)
      type(block_type), intent(in) :: block
      integer, intent(in) :: kind
      type(body_type) :: body
      body%name = block%name()
      body%kind = kind
      body%position = [block%real('X'), block%real('Y')]
      body%velocity = [block%real('VX'), block%real('VY')]
      body%angle = block%real('ANGLE')
      body%spin = block%real('SPIN')
   end function new_body

   subroutine add_rigid_body(block, model, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      type(body_type) :: body
      real(wp) :: centre(2)
      integer :: index
      body = new_body(block, body_rigid)
      centre = [block%real('CENTRE X'), block%real('CENTRE Y')]
      body%reduced = rigid_reduced(block%real('MASS'), block%real('INERTIA'), centre)
      if (block%real('INERTIA') > 0.0_wp .and. .not. block%real('MASS') > 0.0_wp) call diagnostics%warn( &
         & block%origin_of('INERTIA'), "body '"//body%name//"' has an inertia but no mass")
      call append_body(model, body, index)
      call add_point(model, body%name//'.origin', index, [0.0_wp, 0.0_wp])
      call add_point(model, body%name//'.centre', index, centre)
      call add_points(block, body%name, index, model, diagnostics)
      model%bodies(index)%size = extent(model, index)
   end subroutine add_rigid_body

   subroutine add_point_mass(block, model)
      type(block_type), intent(in) :: block
      type(model_type), intent(inout) :: model
      type(body_type) :: body
      integer :: index
      body = new_body(block, body_point)
      body%reduced = rigid_reduced(block%real('MASS'), 0.0_wp, [0.0_wp, 0.0_wp])
      call append_body(model, body, index)
      call add_point(model, body%name//'.origin', index, [0.0_wp, 0.0_wp])
   end subroutine add_point_mass

   !> Appends a body.
   subroutine append_body(model, body, index)
      type(model_type), intent(inout) :: model
      type(body_type), intent(in) :: body
      !> Its index
      integer, intent(out) :: index
      call append(model%bodies, model%counts%bodies, body)
      index = model%counts%bodies
      model%bytes = model%bytes + memory_of(body)
      call enter_name(model, 'body', body%name, index)
   end subroutine append_body

   !> Memory of the constants and shapes of a body [bytes].
   pure integer(long) function memory_of(body) result(bytes)
      type(body_type), intent(in) :: body
      bytes = bytes_of(body%reduced)
      if (allocated(body%field%w)) bytes = bytes + 16*size(body%field%w, kind=long)
      if (allocated(body%field%u)) bytes = bytes + 8*size(body%field%u, kind=long)
      if (allocated(body%shape)) bytes = bytes + 8*size(body%shape, kind=long)
   end function memory_of

   !> Named points of the ground and of rigid bodies, `name, x, y` a line.
   subroutine add_points(block, owner, index, model, diagnostics)
      type(block_type), intent(in) :: block
      character(*), intent(in) :: owner
      integer, intent(in) :: index
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i
      do i = 1, size(block%lines)
         associate (line => block%lines(i))
            if (.not. is_new_point(model, owner//'.'//line%text(1), line%origin_of(1), diagnostics)) cycle
            call add_point(model, owner//'.'//line%text(1), index, [line%number(2), line%number(3)])
         end associate
      end do
   end subroutine add_points

   !> Complains of a point that has the name of one that every body of its kind has. (What the deck names twice, the reader
   !> has complained of.)
   logical function is_new_point(model, name, origin, diagnostics)
      type(model_type), intent(in) :: model
      character(*), intent(in) :: name
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      character(6), parameter :: own_names(5) = [character(6) :: 'origin', 'centre', 'start', 'middle', 'end']
      is_new_point = find_named(model, 'point', name) == 0
      if (is_new_point) return
      if (any(own_names == name(index(name, '.') + 1:))) call diagnostics%add(origin, &
         & "point '"//name//"' is there without being defined", 'choose another name')
   end function is_new_point

   !> A beam, in one piece or in SEGMENTS of them.
   subroutine add_beam(deck, index, model, diagnostics, library)
      type(deck_type), intent(inout) :: deck
      !> Index of the block
      integer, intent(in) :: index
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Reductions of other models
      type(library_type), intent(inout), optional :: library
      integer :: pieces, piece, before, first
      pieces = number_of_pieces(deck%blocks(index))
      if (pieces > 1) call choose_basis(deck, index)
      before = diagnostics%count
      first = model%counts%bodies + 1
      do piece = 1, pieces
         call check_memory(deck%blocks(index), first, pieces - piece + 1, model, diagnostics)
         if (diagnostics%count > before .and. piece > 1) exit
         call add_piece(deck, index, piece, pieces, model, diagnostics, library)
         ! what is wrong with the first piece is wrong with all
         if (piece == 1 .and. diagnostics%count > before) exit
      end do
      if (model%counts%bodies > first) then
         call unite(model, deck%blocks(index), first)
      else if (pieces > 1) then
         model%bodies(first)%name = deck%blocks(index)%name()
         model%bodies(first)%beam%length = deck%blocks(index)%real('LENGTH')
         call enter_name(model, 'body', model%bodies(first)%name, first)
      end if
      call add_beam_points(deck%blocks(index), first, model, diagnostics)
      if (model%counts%bodies > first) call weld_pieces(model, model%bodies(first)%whole)
   end subroutine add_beam

   !> Refuses a beam whose pieces, all like the first, or the scene, would take too much memory, before it is asked for.
   subroutine check_memory(block, first, left, model, diagnostics)
      type(block_type), intent(in) :: block
      !> Index of its first body, and number of pieces that are left
      integer, intent(in) :: first, left
      type(model_type), intent(in) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      integer(long) :: bytes
      bytes = model%bytes
      if (model%counts%bodies >= first) bytes = bytes + left*memory_of(model%bodies(first))
      if (bytes > max_bytes) call diagnostics%add(block%origin, "with beam '"//block%name()//"' the bodies would take "// &
         & as_text(bytes/1024**2)//' MB of memory, more than '//as_text(max_bytes/1024**2), &
         & 'ask for fewer modes, elements, segments or beams')
   end subroutine check_memory

   !> One piece of a beam: a body.
   subroutine add_piece(deck, index, piece, pieces, model, diagnostics, library)
      type(deck_type), intent(inout) :: deck
      !> Index of the block; which piece, of how many
      integer, intent(in) :: index, piece, pieces
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Reductions of other models
      type(library_type), intent(inout), optional :: library
      type(body_type) :: body
      type(error_type), allocatable :: error
      real(wp) :: rigid(3)
      logical :: usable
      integer :: twin, added
      body = new_body(deck%blocks(index), body_flexible)
      call read_beam(deck, index, piece, pieces, body, rigid, diagnostics, usable)
      if (usable .and. deck%blocks(index)%word('GEOMETRIC') /= 'RIGID') then
         twin = find_twin(model, body)
         usable = twin > 0
         body%twin = merge(twin, model%counts%bodies + 1, usable)
         if (usable) then
            body%reduced = model%bodies(twin)%reduced
            body%field = model%bodies(twin)%field
            body%note = model%bodies(twin)%note
         else if (present(library)) then
            call library%look_up(fingerprint(body), body%reduced, body%field, body%note, usable)
         end if
         if (.not. usable) call reduce_beam(body%beam, body%choice, body%reduced, body%field, error, body%note)
         if (present(library) .and. .not. (usable .or. allocated(error))) call library%put(fingerprint(body), body%reduced, &
            & body%field, body%note)
         if (allocated(error)) call diagnostics%add(deck%blocks(index)%origin, "beam '"//body%name//"': "//error%message)
         usable = .not. allocated(error)
      else
         usable = .false.
      end if
      if (.not. usable) then
         body%kind = body_rigid
         body%reduced = rigid_reduced(rigid(1), rigid(3), [rigid(2) - body%choice%origin, 0.0_wp])
      else
         if (piece == 1) call warn_of_basis(deck%blocks(index), body, diagnostics)
         if (body%reduced%n > 0) body%largest_shape = max(maxval(abs(body%field%w)), maxval(abs(body%field%u)))
      end if
      body%size = body%beam%length
      if (pieces > 1) call place_piece(deck%blocks(index), piece, pieces, body)
      call append_body(model, body, added)
      if (usable) call enter_name(model, 'beam', fingerprint(body), added)
   end subroutine add_piece

   !> Index of a beam that was reduced already and is the same to the bit; 0: none.
   pure integer function find_twin(model, body) result(twin)
      type(model_type), intent(in) :: model
      type(body_type), intent(in) :: body
      twin = find_named(model, 'beam', fingerprint(body))
   end function find_twin

   !> All that the reduction of a beam follows from, as one text: beams with the same one have the same modes.
   pure function fingerprint(body) result(text)
      type(body_type), intent(in) :: body
      character(:), allocatable :: text
      character(200) :: buffer
      integer :: i
      associate (beam => body%beam, choice => body%choice)
         write (buffer, '(5(z16, 1x), 8(i0, 1x), 12l1)') beam%ea, beam%ei, beam%rho_a, beam%length, choice%origin, beam%elements, &
            & choice%modes, choice%bending, choice%axial, choice%fidelity, choice%geometric_elements, choice%axial_basis, &
            & choice%derivatives, choice%support, choice%nodal, choice%end_force, choice%centrifugal, &
            & choice%end_shapes, choice%linear, choice%condensed
         text = trim(buffer)
         write (buffer, '(1x, l1, 1x, z16)') choice%craig_bampton, choice%frequency_limit
         text = text//trim(buffer)//attachments_text(choice%interface)//attachments_text(choice%corrections)
         if (.not. allocated(beam%place)) return
         do i = 0, beam%elements
            write (buffer, '(3(1x, z16))') beam%place(i), beam%mass(i), beam%inertia(i)
            text = text//trim(buffer)
         end do
      end associate
   end function fingerprint

   pure function attachments_text(attachments) result(text)
      type(attachment_type), allocatable, intent(in) :: attachments(:)
      character(:), allocatable :: text
      character(40) :: buffer
      integer :: i
      text = ' '
      if (.not. allocated(attachments)) return
      do i = 1, size(attachments)
         write (buffer, '(1x, z16, 1x, i0)') attachments(i)%x, attachments(i)%part
         text = text//trim(buffer)
      end do
   end function attachments_text

   !> Rigidities, mesh and choices of a piece of a beam.
   subroutine read_beam(deck, index, piece, pieces, body, rigid, diagnostics, usable)
      type(deck_type), intent(inout) :: deck
      integer, intent(in) :: index, piece, pieces
      type(body_type), intent(inout) :: body
      !> Mass, coordinate of the centre of mass, moment of inertia about it of the rigid beam
      real(wp), intent(out) :: rigid(3)
      type(diagnostics_type), intent(inout) :: diagnostics
      !> False if it cannot be reduced
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
      if (deck%blocks(index)%word('AXIAL BASIS') == '') call deck%set_option(index, 'AXIAL BASIS', &
         & merge('STATIC', 'MODES ', deck%blocks(index)%word('GEOMETRIC') == 'FULL'))
      associate (block => deck%blocks(index))
         body%choice = new_choice(block)
         call choose_attachments(deck, index, piece, pieces, body%choice, diagnostics)
         if (piece == 1 .and. (body%choice%origin < 0.0_wp .or. body%choice%origin > block%real('LENGTH'))) call diagnostics%add( &
            & block%origin_of('ORIGIN'), "the origin of the frame lies outside beam '"//body%name//"'", &
            & 'give a coordinate from 0 to '//as_text(block%real('LENGTH')))
         if (pieces > 1) call choose_frame(block, piece, body%choice)
         if (body%choice%linear .and. body%choice%fidelity == fidelity_full) call diagnostics%add( &
            & block%origin_of('GEOMETRIC INTEGRAL'), "beam '"//body%name//"': FULL needs a tension that is constant in each "// &
            & 'geometric element', 'use GEOMETRIC INTEGRAL=EXACT, or GEOMETRIC=K_G')
         usable = section > 0 .and. material > 0 .and. diagnostics%count == before .and. body%beam%length > 0.0_wp &
            & .and. body%beam%elements > 0 .and. body%choice%geometric_elements > 0
         if (usable) call check_modes(block, body, diagnostics)
         usable = usable .and. diagnostics%count == before
      end associate
   end subroutine read_beam

   !> Masses that *MASS puts on a piece of a beam.
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
         ! Quick, for decks of thousands of beams
         if (len(deck%blocks(i)%keyword) /= len('MASS')) cycle
         if (deck%blocks(i)%keyword /= 'MASS') cycle
         if (.not. is_part(deck, i, index)) cycle
         do k = 1, size(deck%blocks(i)%lines)
            associate (line => deck%blocks(i)%lines(k))
               before = diagnostics%count
               x = beam_place(deck%blocks(index), line, diagnostics)
               if (diagnostics%count == before .and. (x < 0.0_wp .or. x > pieces*body%beam%length)) call diagnostics%add( &
                  & line%origin_of(1), 'the mass lies outside the beam', &
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

   !> Coordinate along a beam that the first field of a line gives as a number or as the name of a point.
   real(wp) function beam_place(block, line, diagnostics) result(x)
      !> Of the beam
      type(block_type), intent(in) :: block
      type(line_type), intent(in) :: line
      type(diagnostics_type), intent(inout) :: diagnostics
      logical :: found
      x = line%number(1)
      if (line%text(1) == '') return
      call find_beam_point(block, line%text(1), x, found)
      if (.not. found) call diagnostics%add(line%origin_of(1), "beam '"//block%name()//"' has no point '"//line%text(1)//"'", &
         & 'give a coordinate, or a point that the beam names')
   end function beam_place

   !> Coordinate along a beam of one of its points.
   subroutine find_beam_point(block, name, x, found)
      !> Of the beam
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

   !> The interface of Craig and Bampton, which is what *ATTACHMENT names or else all that acts on the beam; and what responses
   !> are wanted to besides: what *ATTACHMENT names, and all that acts with CORRECTIONS=YES.
   subroutine choose_attachments(deck, index, piece, pieces, choice, diagnostics)
      type(deck_type), intent(in) :: deck
      !> Block of the beam; which piece, of how many
      integer, intent(in) :: index, piece, pieces
      type(reduction_type), intent(inout) :: choice
      type(diagnostics_type), intent(inout) :: diagnostics
      type(attachment_type), allocatable :: named(:), acting(:)
      call read_attachments(deck, index, named, diagnostics)
      allocate (acting(0))
      if (choice%craig_bampton .or. deck%blocks(index)%yes('CORRECTIONS')) call find_acting(deck, index, acting)
      if (.not. deck%blocks(index)%yes('CORRECTIONS') .and. size(named) > 0) acting = acting(:0)
      if (pieces > 1) then
         call keep_piece(named, piece, pieces, deck%blocks(index)%real('LENGTH')/pieces)
         call keep_piece(acting, piece, pieces, deck%blocks(index)%real('LENGTH')/pieces)
      end if
      if (choice%craig_bampton) then
         if (size(named) > 0) then
            call move_alloc(named, choice%interface)
            allocate (choice%corrections, source=others(acting, choice%interface))
         else
            call move_alloc(acting, choice%interface)
         end if
      else
         allocate (choice%corrections, source=[named, others(acting, named)])
      end if
   end subroutine choose_attachments

   !> Attachments that lie on a piece, with their coordinates along it.
   subroutine keep_piece(attachments, piece, pieces, length)
      type(attachment_type), allocatable, intent(inout) :: attachments(:)
      integer, intent(in) :: piece, pieces
      !> Of a piece [length]
      real(wp), intent(in) :: length
      type(attachment_type), allocatable :: kept(:)
      integer :: i
      allocate (kept, source=pack(attachments, [(piece_at(attachments(i)%x, length, pieces) == piece, i=1, size(attachments))]))
      kept%x = kept%x - (piece - 1)*length
      call move_alloc(kept, attachments)
   end subroutine keep_piece

   !> Attachments that are not among others.
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

   !> What *ATTACHMENT names on a beam.
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
               x = beam_place(deck%blocks(index), line, diagnostics)
               if (diagnostics%count > before) cycle
               part = findloc([1, 2, 6], nint(line%number(2)), dim=1)
               if (x < 0.0_wp .or. x > length) then
                  call diagnostics%add(line%origin_of(1), 'the attachment lies outside the beam', &
                     & 'give a coordinate from 0 to '//as_text(length))
               else if (part == 0) then
                  call diagnostics%add(line%origin_of(2), 'a beam has no degree of freedom '//as_text(nint(line%number(2))), &
                     & 'give 1 (along), 2 (across) or 6 (rotation)')
               else
                  named = [named, attachment_type(1, x, part)]
               end if
            end associate
         end do
      end do
   end subroutine read_attachments

   !> What joints, drivers and loads exert on a beam.
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

   !> What the block says of the reduction.
   function new_choice(block) result(choice)
      type(block_type), intent(in) :: block
      type(reduction_type) :: choice
      choice%support = new_support(block%word('SUPPORT'))
      choice%frequency_limit = block%real('FREQUENCY LIMIT')
      choice%craig_bampton = block%word('BASIS') == 'CRAIG-BAMPTON'
      if (block%given('BENDING MODES') .or. block%given('AXIAL MODES')) then
         choice%bending = block%integer('BENDING MODES')
         choice%axial = block%integer('AXIAL MODES')
         ! With a limit, those whose number is not given are all below it
         if (block%given('FREQUENCY LIMIT') .and. .not. block%given('BENDING MODES')) choice%bending = huge(1)
         if (block%given('FREQUENCY LIMIT') .and. .not. block%given('AXIAL MODES')) choice%axial = huge(1)
      else
         choice%modes = block%integer('MODES')
         if (block%given('FREQUENCY LIMIT')) choice%modes = huge(1)
      end if
      select case (block%word('GEOMETRIC'))
      case ('LINEAR'); choice%fidelity = fidelity_linear
      case ('K_G'); choice%fidelity = fidelity_kg
      case ('FULL'); choice%fidelity = fidelity_full
      end select
      choice%geometric_elements = block%integer('GEOMETRIC ELEMENTS')
      choice%nodal = block%word('GEOMETRIC INTEGRAL') == 'NODAL'
      choice%linear = block%word('GEOMETRIC INTEGRAL') == 'LINEAR'
      select case (block%word('AXIAL BASIS'))
      case ('MODES'); choice%axial_basis = axial_by_modes
      case ('ELEMENTS'); choice%axial_basis = axial_by_elements
      case ('STATIC'); choice%axial_basis = axial_static
      end select
      choice%end_shapes = block%yes('END SHAPES')
      choice%end_force = block%yes('END FORCE')
      choice%centrifugal = block%yes('CENTRIFUGAL')
      choice%derivatives = block%integer('MODAL DERIVATIVES')
      choice%origin = block%real('ORIGIN')
      choice%condensed = block%word('AXIAL DYNAMICS') == 'STATIC'
   end function new_choice

   !> More modes than the lumped mass gives.
   subroutine check_modes(block, body, diagnostics)
      type(block_type), intent(in) :: block
      type(body_type), intent(in) :: body
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: available(2)
      if (body%choice%frequency_limit > 0.0_wp) return
      available = available_modes(body%beam, body%choice)
      call check_count('MODES', body%choice%modes, sum(available), 'bending and axial')
      call check_count('BENDING MODES', body%choice%bending, available(1), 'bending')
      if (body%choice%axial_basis == axial_by_modes) &
         & call check_count('AXIAL MODES', body%choice%axial, available(2), 'axial')

   contains

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

   !> Choices that are known to give wrong answers.
   subroutine warn_of_basis(block, body, diagnostics)
      type(block_type), intent(in) :: block
      type(body_type), intent(in) :: body
      type(diagnostics_type), intent(inout) :: diagnostics
      if (body%reduced%geometric .and. body%reduced%n == body%reduced%bending) call diagnostics%warn( &
         & block%origin_of('GEOMETRIC'), "beam '"//body%name//"' has no axial coordinate: no tension, so that its "// &
         & 'geometric stiffness is zero', 'ask for more MODES, or AXIAL MODES=1')
      if (body%reduced%full .and. body%choice%axial_basis == axial_by_modes) call diagnostics%warn( &
         & block%origin_of('AXIAL BASIS'), "beam '"//body%name//"' locks: FULL with vibration modes alone deflects too little", &
         & 'use AXIAL BASIS=STATIC or ELEMENTS')
      call warn_of_rounding(real(body%beam%elements, wp), block%origin_of('ELEMENTS'), "beam '"//body%name//"'", diagnostics)
   end subroutine warn_of_basis

   !> Round-off of the stiffness of very short elements, against which the lowest modes bend by little, eq. (H4).
   subroutine warn_of_rounding(slenderness, origin, what, diagnostics)
      !> Length of the body over that of its shortest element
      real(wp), intent(in) :: slenderness
      type(origin_type), intent(in) :: origin
      !> 'beam ...'
      character(*), intent(in) :: what
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp), parameter :: clamped_free = 12.36_wp, allowed = 1.0e-4_wp
      real(wp) :: part
      part = 0.5_wp*epsilon(part)*slenderness**4/clamped_free
      if (part > allowed) call diagnostics%warn(origin, what//': round-off of elements that are so short makes its lowest'// &
         & ' frequency wrong by a part of about '//as_text(part, 1), 'a hundred elements along it are enough for most modes')
   end subroutine warn_of_rounding

   !> Points of the beam that was added last: start, middle, end, and the named ones, `name, coordinate` a line.
   subroutine add_beam_points(block, first, model, diagnostics)
      type(block_type), intent(in) :: block
      !> Index of its body, or of that of its first piece
      integer, intent(in) :: first
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i, pieces
      real(wp) :: length
      pieces = model%counts%bodies - first + 1
      length = pieces*model%bodies(first)%beam%length
      call place('origin', min(max(block%real('ORIGIN'), 0.0_wp), length))
      call place('start', 0.0_wp)
      model%bodies(first:first + pieces - 1)%start_point = model%counts%points
      call place('middle', 0.5_wp*length)
      call place('end', length)
      model%bodies(first:first + pieces - 1)%end_point = model%counts%points
      do i = 1, size(block%lines)
         associate (line => block%lines(i))
            if (line%number(2) < 0.0_wp .or. line%number(2) > length) then
               call diagnostics%add(line%origin_of(2), 'the point lies outside the beam', &
                  & 'give a coordinate from 0 to '//as_text(length))
               cycle
            end if
            if (is_new_point(model, block%name()//'.'//line%text(1), line%origin_of(1), diagnostics)) &
               & call place(line%text(1), line%number(2))
         end associate
      end do

   contains

      subroutine place(name, s)
         character(*), intent(in) :: name
         real(wp), intent(in) :: s
         integer :: piece
         piece = piece_at(s, length/pieces, pieces)
         call add_beam_point(model, block%name()//'.'//name, first + piece - 1, &
            & min(max(s - (piece - 1)*length/pieces, 0.0_wp), length/pieces))
      end subroutine place

   end subroutine add_beam_points

   !> Largest distance between two points of the body that was added last [length].
   pure real(wp) function extent(model, body)
      type(model_type), intent(in) :: model
      integer, intent(in) :: body
      integer :: i, j
      extent = 0.0_wp
      do i = model%counts%points, 1, -1
         if (model%points(i)%body /= body) exit
         do j = i - 1, 1, -1
            if (model%points(j)%body /= body) exit
            extent = max(extent, norm2(model%points(i)%p0 - model%points(j)%p0))
         end do
      end do
   end function extent

end module limber_model_bodies
