!> Flexible frames of the deck: mesh, modal reduction and named points. Floor: model.
module limber_model_frames
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use limber_deck_content, only: deck_type, block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_beam_plane_frame, only: frame_type, acted_type, new_frame, member_length
   use limber_beam_frame_reduction, only: frame_choice_type, reduce_frame, available_frame_modes, frame_point_shape
   use limber_beam_frame_solver, only: connected_nodes
   use limber_beam_static_functions, only: attachment_type, may_be_lost
   use limber_beam_reduced_body, only: reduced_type, rigid_reduced
   use limber_beam_beam_reduction, only: fidelity_linear, fidelity_kg
   use limber_model_element_effects, only: acting_points
   use limber_model_points_of_action, only: acting_type
   use limber_model_beam_options, only: warn_of_rigid
   use limber_model_bodies, only: new_body, append_body, is_new_point, warn_of_rounding
   use limber_model_frame_draft, only: draft_type, read_draft, member_of, node_named
   use limber_model_body_parts, only: is_part
   use limber_model_points, only: add_point, lies_outside
   use limber_model_model, only: model_type, body_type, body_flexible, body_rigid
   use limber_model_short_beams, only: weigh_frame
   implicit none
   private
   public :: add_frame

   !> Largest number of finite elements of a frame
   integer, parameter :: max_elements = 20000
   !> Default number of modes: for each member, at least, at most
   integer, parameter :: modes_of_member = 3, least_modes = 6, most_modes = 24

contains

   !> Adds a frame with its points to the model.
   subroutine add_frame(deck, index, model, diagnostics)
      type(deck_type), intent(inout) :: deck
      !> Index of its block
      integer, intent(in) :: index
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      type(draft_type) :: draft
      type(body_type), allocatable :: body
      type(error_type), allocatable :: error
      logical :: usable, sound, cut
      integer :: before, added
      before = diagnostics%count
      allocate (body)
      body = new_body(deck%blocks(index), body_flexible)
      body%is_frame = .true.
      call read_draft(deck, index, draft, diagnostics)
      if (diagnostics%count > before) return
      if (deck%blocks(index)%word('GEOMETRIC') == 'RIGID') call warn_of_rigid(deck, index, diagnostics)
      call settle_options(deck, index, draft)
      call mesh(deck, index, draft, body, diagnostics)
      usable = diagnostics%count == before
      cut = .false.
      ! An error of a material or section is told there
      sound = usable
      if (usable) sound = .not. (any(deck%blocks(pack(draft%material, draft%material > 0))%broken) .or. &
         & any(deck%blocks(pack(draft%section, draft%section > 0))%broken))
      if (sound .and. deck%blocks(index)%word('GEOMETRIC') /= 'RIGID') then
         call reduce_frame(body%mesh, body%frame_choice, body%reduced, body%shape, error, body%note, cut, body%lost)
         ! Without a number in the deck, all modes of equal frequency are kept
         if (cut .and. .not. (deck%blocks(index)%given('MODES') .or. deck%blocks(index)%given('FREQUENCY LIMIT'))) then
            body%frame_choice%modes = body%frame_choice%modes + 1
            deallocate (body%shape)
            call reduce_frame(body%mesh, body%frame_choice, body%reduced, body%shape, error, body%note, cut, body%lost)
            call deck%set_number(index, 'MODES', real(body%frame_choice%modes, wp))
         end if
         if (allocated(error)) call diagnostics%add(deck%blocks(index)%origin, "frame '"//body%name//"': "//error%message)
      end if
      if (.not. usable .or. diagnostics%count > before) then
         body%kind = body_rigid
         body%reduced = rigid_reduced(1.0_wp, 1.0_wp, [0.0_wp, 0.0_wp])
      else if (.not. allocated(body%shape)) then
         body%kind = body_rigid
         body%reduced = rigid_frame(draft)
      else if (body%reduced%n > 0) then
         body%largest_shape = maxval(abs(body%shape(1:2, :, :)))
         call weigh_frame(deck, index, draft, body%unsheared, body%shortest)
      end if
      if (usable .and. allocated(body%shape)) call warn_of_rounding(extent(draft%place(:, :size(draft%node)))/ &
         & minval(body%mesh%length), deck%blocks(index)%origin_of('DIVISIONS'), "frame '"//body%name//"'", diagnostics)
      if (body%lost > may_be_lost .and. diagnostics%count == before) call diagnostics%warn(deck%blocks(index)%origin_of( &
         & trim(merge('MODES    ', 'DIVISIONS', deck%blocks(index)%given('MODES')))), "frame '"//body%name//"': its "// &
         & as_text(body%frame_choice%modes)//' modes leave no mass in the nodes for responses to its joints and loads: '// &
         & as_text(100*body%lost, 2)//' % of the strain energy of one is missing, and the frame is too stiff by up to that', &
         & 'use fewer MODES, or more DIVISIONS')
      if (cut .and. diagnostics%count == before) call diagnostics%warn(deck%blocks(index)%origin_of('MODES'), "frame '"// &
         & body%name//"': modes of one frequency are divided: it is chance which of them are left out, and with them what the"// &
         & ' frame answers to', 'use more MODES=, or fewer, until all of that frequency are in or out')
      body%size = extent(draft%place(:, :size(draft%node)))
      call append_body(model, body, added)
      if (diagnostics%count == before) call add_frame_points(deck, index, draft, model, diagnostics)
   end subroutine add_frame

   !> Sets options that the deck leaves open. K_G needs CORRECTIONS: axial forces change the bending stiffness, so the coordinates
   !> must represent the axial forces of all loads. The number of modes grows with the number of members.
   subroutine settle_options(deck, index, draft)
      type(deck_type), intent(inout) :: deck
      integer, intent(in) :: index
      type(draft_type), intent(in) :: draft
      if (.not. deck%blocks(index)%has('CORRECTIONS')) call deck%set_option(index, 'CORRECTIONS', &
         & trim(merge('YES', 'NO ', deck%blocks(index)%word('GEOMETRIC') == 'K_G')))
      if (deck%blocks(index)%has('MODES')) return
      call deck%set_number(index, 'MODES', real(min(max(least_modes, modes_of_member*size(draft%number)), most_modes), wp))
   end subroutine settle_options

   !> Finds loaded points between the nodes of the mesh: they need nodes of their own.
   subroutine find_acted(deck, index, draft, acted)
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: index
      type(draft_type), intent(in) :: draft
      type(acted_type), allocatable, intent(out) :: acted(:)
      type(acting_type), allocatable :: points(:)
      real(wp) :: x, place
      integer :: i, member
      logical :: found
      allocate (acted(0))
      call acting_points(deck, deck%blocks(index)%name(), points)
      do i = 1, size(points)
         call find_frame_point(deck, index, draft, trim(points(i)%name), member, x, found)
         if (.not. found) cycle
         associate (own => draft%members(member))
            place = x/norm2(draft%place(:, own%ends(2)) - draft%place(:, own%ends(1)))*own%divisions
         end associate
         if (abs(place - nint(place)) > 1.0e-6_wp) acted = [acted, acted_type(member, x)]
      end do
   end subroutine find_acted

   !> Makes the mesh of a frame, and reads its reduction options.
   subroutine mesh(deck, index, draft, body, diagnostics)
      type(deck_type), intent(inout) :: deck
      !> Index of the block
      integer, intent(in) :: index
      type(draft_type), intent(in) :: draft
      type(body_type), intent(inout) :: body
      type(diagnostics_type), intent(inout) :: diagnostics
      type(acted_type), allocatable :: acted(:)
      logical, allocatable :: connected(:)
      integer :: i, available
      if (sum(real(draft%members(:)%divisions, wp)) > max_elements) then
         call diagnostics%add(deck%blocks(index)%origin, "frame '"//body%name//"' has more than "//as_text(max_elements)// &
            & ' finite elements', 'use fewer DIVISIONS')
         return
      end if
      call find_acted(deck, index, draft, acted)
      body%mesh = new_frame(draft%place, draft%members, acted)
      allocate (body%strength, source=draft%strength)
      allocate (body%member_numbers, source=draft%number)
      do i = 1, size(draft%node)
         body%mesh%free(:, i) = draft%free(:, i)
         body%mesh%mass(1:2, i) = body%mesh%mass(1:2, i) + draft%mass(i)
         body%mesh%mass(3, i) = body%mesh%mass(3, i) + draft%inertia(i)
      end do
      allocate (connected, source=connected_nodes(body%mesh))
      ! One missing member may leave several nodes alone: the first stands for all
      i = findloc(connected(:size(draft%node)), .false., dim=1)
      if (i > 0) then
         call diagnostics%add(draft%node_origin(i), 'node '//as_text(draft%node(i))//' is not joined to node '// &
            & as_text(draft%node(1))//' by members', 'a frame must hang together')
         return
      end if
      associate (choice => body%frame_choice, block => deck%blocks(index))
         choice%modes = block%integer('MODES')
         choice%frequency_limit = block%real('FREQUENCY LIMIT')
         if (choice%frequency_limit > 0.0_wp) choice%modes = huge(1)
         choice%craig_bampton = block%word('BASIS') == 'CRAIG-BAMPTON'
         select case (block%word('GEOMETRIC'))
         case ('LINEAR'); choice%fidelity = fidelity_linear
         case ('K_G'); choice%fidelity = fidelity_kg
         end select
         choice%accelerations = block%yes('CORRECTIONS')
         allocate (choice%attachments, source=draft%attachments)
         call choose_attachments(deck, index, draft, choice)
      end associate
      if (body%frame_choice%frequency_limit > 0.0_wp) return
      available = available_frame_modes(body%mesh, body%frame_choice)
      if (.not. deck%blocks(index)%given('MODES') .and. body%frame_choice%modes > available) then
         body%frame_choice%modes = available
         call deck%set_number(index, 'MODES', real(available, wp))
      end if
      associate (block => deck%blocks(index))
         if (block%integer('MODES') > available) call diagnostics%add(block%origin_of('MODES'), "frame '"//body%name//"': "// &
            & as_text(block%integer('MODES'))//' modes are asked for, but the lumped mass gives '//as_text(available), &
            & 'at most '//as_text(available)//', or raise DIVISIONS')
      end associate
   end subroutine mesh

   !> Chooses static functions as for beams. Craig-Bampton without *ATTACHMENT: the interface is all points of action. Otherwise
   !> CORRECTIONS=YES adds the responses to forces at all points of action.
   subroutine choose_attachments(deck, index, draft, choice)
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: index
      type(draft_type), intent(in) :: draft
      !> Contains the attachments of the deck
      type(frame_choice_type), intent(inout) :: choice
      type(acting_type), allocatable :: points(:)
      type(attachment_type), allocatable :: acting(:)
      type(attachment_type) :: at(3)
      logical :: found
      integer :: i
      if (.not. choice%craig_bampton .and. .not. deck%blocks(index)%yes('CORRECTIONS')) return
      call acting_points(deck, deck%blocks(index)%name(), points)
      allocate (acting(0))
      do i = 1, size(points)
         call find_frame_point(deck, index, draft, trim(points(i)%name), at(1)%member, at(1)%x, found)
         if (.not. found) cycle
         at%member = at(1)%member
         at%x = at(1)%x
         at%part = [1, 2, 3]
         acting = [acting, pack(at, [points(i)%force, points(i)%force, points(i)%couple])]
      end do
      if (choice%craig_bampton .and. size(choice%attachments, 2) == 0) then
         call move_alloc(acting, choice%interface)
      else if (deck%blocks(index)%yes('CORRECTIONS')) then
         call move_alloc(acting, choice%corrections)
      end if
   end subroutine choose_attachments

   !> Member of a point of a frame, and the coordinate along it [length]; false in `found` if there is no such point.
   subroutine find_frame_point(deck, index, draft, name, member, x, found)
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: index
      type(draft_type), intent(in) :: draft
      character(*), intent(in) :: name
      integer, intent(out) :: member
      real(wp), intent(out) :: x
      logical, intent(out) :: found
      integer :: i, node
      member = 0
      x = 0.0_wp
      found = .false.
      node = node_named(deck, index, draft, name)
      if (node > 0) then
         do member = 1, size(draft%members)
            if (any(draft%members(member)%ends == node)) exit
         end do
         ! A node on no member is an error, told later
         if (member > size(draft%members)) member = 0
         if (member == 0) return
         if (draft%members(member)%ends(2) == node) x = length_of(member)
      else
         associate (lines => deck%blocks(index)%lines)
            do i = 1, size(lines)
               if (lines(i)%text(1) /= name) cycle
               member = member_of(draft, nint(lines(i)%number(2)))
               x = lines(i)%number(3)
            end do
         end associate
      end if
      found = member > 0
      if (found) found = x >= 0.0_wp .and. x <= length_of(member)*(1 + 1.0e-12_wp)

   contains

      !> Length of a member.
      pure real(wp) function length_of(member)
         integer, intent(in) :: member
         length_of = norm2(draft%place(:, draft%members(member)%ends(2)) - draft%place(:, draft%members(member)%ends(1)))
      end function length_of

   end subroutine find_frame_point

   !> Mass properties of the frame as one rigid body.
   pure function rigid_frame(draft) result(reduced)
      type(draft_type), intent(in) :: draft
      type(reduced_type) :: reduced
      real(wp) :: mass, moment(2), second, line(2), middle(2), part
      integer :: i
      mass = sum(draft%mass)
      moment = matmul(draft%place, draft%mass)
      second = sum(draft%inertia) + sum(draft%mass*(draft%place(1, :)**2 + draft%place(2, :)**2))
      do i = 1, size(draft%members)
         associate (a => draft%place(:, draft%members(i)%ends(1)), b => draft%place(:, draft%members(i)%ends(2)))
            line = b - a
            middle = 0.5_wp*(a + b)
         end associate
         part = draft%members(i)%rho_a*norm2(line)
         mass = mass + part
         moment = moment + part*middle
         second = second + part*(dot_product(middle, middle) + dot_product(line, line)/12)
      end do
      reduced = rigid_reduced(mass, second - dot_product(moment, moment)/mass, moment/mass)
   end function rigid_frame

   !> Adds the points of the last frame: the origin of its axes if a node is there, named nodes, and named points of members.
   subroutine add_frame_points(deck, index, draft, model, diagnostics)
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: index
      type(draft_type), intent(in) :: draft
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i, k, owner, node
      real(wp) :: length
      owner = model%counts%bodies
      associate (block => deck%blocks(index))
         do node = 1, size(draft%node)
            if (all(abs(draft%place(:, node)) <= 0.0_wp)) call place_node('origin', node)
         end do
         do i = 1, size(deck%blocks)
            if (deck%blocks(i)%keyword /= 'NODE' .or. .not. is_part(deck, i, index)) cycle
            do k = 1, size(deck%blocks(i)%lines)
               associate (line => deck%blocks(i)%lines(k))
                  if (line%count() < 4) cycle
                  do node = size(draft%node), 1, -1
                     if (draft%node(node) == nint(line%number(1))) exit
                  end do
                  if (is_new_point(model, model%bodies(owner)%name//'.'//line%text(4), line%origin_of(4), diagnostics)) &
                     & call place_node(line%text(4), node)
               end associate
            end do
         end do
         do i = 1, size(block%lines)
            associate (line => block%lines(i), member => member_of(draft, nint(block%lines(i)%number(2))))
               if (member == 0) then
                  call diagnostics%add(line%origin_of(2), 'this frame has no member '//as_text(nint(line%number(2))), &
                     & 'members have the numbers that *ELEMENT gives')
                  cycle
               end if
               length = norm2(draft%place(:, draft%members(member)%ends(2)) - draft%place(:, draft%members(member)%ends(1)))
               if (lies_outside(line%number(3), length)) then
                  call diagnostics%add(line%origin_of(3), 'the point lies outside the member', &
                     & 'give a coordinate from 0 to '//as_text(length))
               else if (is_new_point(model, model%bodies(owner)%name//'.'//line%text(1), line%origin_of(1), diagnostics)) then
                  call place_point(line%text(1), member, min(max(line%number(3), 0.0_wp), length), 1)
               end if
            end associate
         end do
      end associate

   contains

      !> Adds a point at a node, on the last member there.
      subroutine place_node(name, node)
         character(*), intent(in) :: name
         integer, intent(in) :: node
         integer :: m, member, meeting
         meeting = 0
         member = 0
         do m = 1, size(draft%members)
            if (.not. any(draft%members(m)%ends == node)) cycle
            meeting = meeting + 1
            member = m
         end do
         if (draft%members(member)%ends(1) == node) then
            call place_point(name, member, 0.0_wp, meeting)
         else
            call place_point(name, member, member_length(model%bodies(owner)%mesh, member), meeting)
         end if
         model%points(model%counts%points)%p0 = draft%place(:, node)
      end subroutine place_node

      !> Adds a point at coordinate x of a member.
      subroutine place_point(name, member, x, meeting)
         character(*), intent(in) :: name
         integer, intent(in) :: member, meeting
         real(wp), intent(in) :: x
         character(:), allocatable :: whole
         real(wp), allocatable :: phi(:, :), psi(:)
         real(wp) :: p0(2)
         associate (body => model%bodies(owner))
            whole = body%name//'.'//name
            p0 = draft%place(:, draft%members(member)%ends(1)) + x*body%mesh%axis(:, body%mesh%first(member))
            if (body%kind == body_flexible) call frame_point_shape(body%mesh, body%shape, member, x, phi, psi)
         end associate
         call add_point(model, whole, owner, p0, phi, psi)
         associate (point => model%points(model%counts%points))
            point%member = member
            point%meeting = meeting
            point%along = x
         end associate
      end subroutine place_point

   end subroutine add_frame_points

   !> Largest distance between two nodes [length].
   pure real(wp) function extent(place)
      real(wp), intent(in) :: place(:, :)
      integer :: i, j
      extent = 0.0_wp
      do i = 1, size(place, 2)
         do j = 1, i - 1
            extent = max(extent, norm2(place(:, i) - place(:, j)))
         end do
      end do
   end function extent

end module limber_model_frames
