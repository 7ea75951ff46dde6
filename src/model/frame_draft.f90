!> Frames as described by the deck: nodes, elements, sets, supports. Floor: model.
module limber_model_frame_draft
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, lowercase, suggestion
   use limber_base_names, only: name_index_type
   use limber_deck_content, only: deck_type, block_type, line_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_origin, only: origin_type
   use limber_beam_plane_frame, only: member_type
   use limber_model_body_parts, only: is_part
   use limber_model_sections, only: read_section
   implicit none
   private
   public :: draft_type, read_draft, member_of, node_named

   !> Default number of finite elements of a member: most and least; of all members together. With 8 elements the lumped masses
   !> shift the frequencies of higher modes: after a sudden load, a moment was wrong by a sixth after thirty periods.
   integer, parameter :: most_divisions = 32, least_divisions = 8, elements_in_all = 256

   !> Number of the last degree of freedom of a node
   integer, parameter :: most_freedoms = 6

   !> A node or member in a set
   type :: draft_set_type
      character(64) :: name = ''
      integer :: item = 0
   end type draft_set_type

   !> A frame of the deck, with indices in place of the numbers of nodes and members
   type :: draft_type
      !> Numbers of the nodes in the deck; positions (2, nodes) [length]; false where fixed (3, nodes); masses and inertias (nodes)
      integer, allocatable :: node(:)
      real(wp), allocatable :: place(:, :)
      logical, allocatable :: free(:, :)
      real(wp), allocatable :: mass(:), inertia(:)
      !> Numbers of the members in the deck, and the members
      integer, allocatable :: number(:)
      type(member_type), allocatable :: members(:)
      !> Blocks of material and section; 0 if none (members)
      integer, allocatable :: material(:), section(:)
      !> Cross-sections (4, members), see `read_section`
      real(wp), allocatable :: strength(:, :)
      !> Places of the definitions of nodes and members in the deck
      type(origin_type), allocatable :: node_origin(:), member_origin(:)
      type(draft_set_type), allocatable :: node_sets(:), member_sets(:)
      !> Static functions: node and degree of freedom, 1 to 3 (2, number)
      integer, allocatable :: attachments(:, :)
      !> Whether errors leave it open which nodes there are, which members, and which sections these have
      logical :: open_nodes = .false., open_members = .false., open_sections = .false.
   end type draft_type

contains

   !> Reads all parts of a frame.
   subroutine read_draft(deck, frame, draft, diagnostics)
      type(deck_type), intent(in) :: deck
      !> Index of the block of the frame
      integer, intent(in) :: frame
      type(draft_type), intent(out) :: draft
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i, before
      call start_draft(deck, frame, draft)
      before = diagnostics%count
      do i = 1, size(deck%blocks)
         if (.not. is_part(deck, i, frame)) cycle
         if (deck%blocks(i)%keyword == 'NODE') call read_nodes(deck%blocks(i), draft, diagnostics)
      end do
      call check_point_names(deck, frame, diagnostics)
      draft%open_nodes = diagnostics%count > before
      do i = 1, size(deck%blocks)
         if (.not. is_part(deck, i, frame)) cycle
         if (deck%blocks(i)%keyword == 'ELEMENT') call read_members(deck, deck%blocks(frame), deck%blocks(i), draft, diagnostics)
      end do
      draft%open_members = diagnostics%count > before
      do i = 1, size(deck%blocks)
         if (.not. is_part(deck, i, frame)) cycle
         if (deck%blocks(i)%keyword == 'NSET') &
            & call read_set(deck%blocks(i), 'NSET', 'node', draft%node, draft%node_sets, draft%open_nodes, diagnostics)
         if (deck%blocks(i)%keyword == 'ELSET') &
            & call read_set(deck%blocks(i), 'ELSET', 'member', draft%number, draft%member_sets, draft%open_members, diagnostics)
      end do
      do i = 1, size(deck%blocks)
         if (.not. is_part(deck, i, frame)) cycle
         associate (block => deck%blocks(i))
            select case (block%keyword)
            case ('BEAM SECTION'); call read_beam_section(deck, block, draft, diagnostics)
            case ('BOUNDARY'); call read_boundary(block, draft, diagnostics)
            case ('MASS'); call read_masses(block, draft, diagnostics)
            case ('ATTACHMENT'); call read_attachments(block, draft, diagnostics)
            end select
         end associate
      end do
      call settle_members(deck, deck%blocks(frame), draft, diagnostics)
   end subroutine read_draft

   !> Allocates space for all nodes and members.
   subroutine start_draft(deck, frame, draft)
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: frame
      type(draft_type), intent(inout) :: draft
      integer :: i, nodes, members
      nodes = 0
      members = 0
      do i = 1, size(deck%blocks)
         if (.not. is_part(deck, i, frame)) cycle
         if (deck%blocks(i)%keyword == 'NODE') nodes = nodes + size(deck%blocks(i)%lines)
         if (deck%blocks(i)%keyword == 'ELEMENT') members = members + size(deck%blocks(i)%lines)
      end do
      allocate (draft%node(0), draft%node_origin(nodes), draft%place(2, nodes), draft%free(3, nodes), draft%mass(nodes))
      allocate (draft%inertia(nodes), draft%number(0), draft%member_origin(members), draft%members(members))
      allocate (draft%material(members), draft%section(members), draft%strength(4, members), draft%attachments(2, 0))
      allocate (draft%node_sets(0), draft%member_sets(0))
      draft%free = .true.
      draft%mass = 0.0_wp
      draft%inertia = 0.0_wp
   end subroutine start_draft

   !> Reads the nodes of a block.
   subroutine read_nodes(block, draft, diagnostics)
      type(block_type), intent(in) :: block
      type(draft_type), intent(inout) :: draft
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i, n
      do i = 1, size(block%lines)
         associate (line => block%lines(i))
            n = place_of(draft%node, nint(line%number(1)))
            if (n > 0) then
               call diagnostics%add(line%origin_of(1), 'node '//as_text(nint(line%number(1)))//' is defined twice', &
                  & 'give it another number', draft%node_origin(n), 'first defined here')
               cycle
            end if
            draft%node = [draft%node, nint(line%number(1))]
            n = size(draft%node)
            draft%place(:, n) = [line%number(2), line%number(3)]
            draft%node_origin(n) = line%origin_of(1)
            if (block%has('NSET')) call join_set(draft%node_sets, block%text('NSET'), n)
         end associate
      end do
   end subroutine read_nodes

   !> Reads the members of a block.
   subroutine read_members(deck, frame, block, draft, diagnostics)
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: frame, block
      type(draft_type), intent(inout) :: draft
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i, k, n, ends(2)
      do i = 1, size(block%lines)
         associate (line => block%lines(i))
            n = place_of(draft%number, nint(line%number(1)))
            if (n > 0) then
               call diagnostics%add(line%origin_of(1), 'member '//as_text(nint(line%number(1)))//' is defined twice', &
                  & 'give it another number', draft%member_origin(n), 'first defined here')
               cycle
            end if
            do k = 1, 2
               ends(k) = known(draft%node, line, 1 + k, 'node', draft%open_nodes, diagnostics)
            end do
            if (any(ends == 0)) cycle
            if (.not. norm2(draft%place(:, ends(1)) - draft%place(:, ends(2))) > 0.0_wp) then
               call diagnostics%add(line%origin_of(1), 'member '//as_text(nint(line%number(1)))//' has no length', &
                  & 'its two nodes must stand in different places')
               cycle
            end if
            draft%number = [draft%number, nint(line%number(1))]
            n = size(draft%number)
            draft%member_origin(n) = line%origin_of(1)
            draft%members(n)%ends = ends
            draft%members(n)%divisions = max(least_divisions, min(most_divisions, elements_in_all/size(draft%member_origin)))
            ! A refused count is 0
            if (frame%has('DIVISIONS')) draft%members(n)%divisions = max(1, frame%integer('DIVISIONS'))
            if (block%has('DIVISIONS')) draft%members(n)%divisions = max(1, block%integer('DIVISIONS'))
            draft%material(n) = named(deck, frame, block, 'MATERIAL')
            draft%section(n) = named(deck, frame, block, 'SECTION')
            if (line%count() > 3) then
               draft%section(n) = deck%find_named('SECTION', line%text(4))
               draft%open_sections = draft%open_sections .or. draft%section(n) == 0
               if (draft%section(n) == 0) call diagnostics%add(line%origin_of(4), "there is no *SECTION named '"// &
                  & line%text(4)//"'", section_remedy(deck, line%text(4)), object=line%text(4))
            end if
            if (block%has('ELSET')) call join_set(draft%member_sets, block%text('ELSET'), n)
         end associate
      end do
   end subroutine read_members

   !> Remedy for an unknown section.
   function section_remedy(deck, name) result(text)
      type(deck_type), intent(in) :: deck
      character(*), intent(in) :: name
      character(:), allocatable :: text
      character(64) :: names(size(deck%blocks))
      integer :: i
      names = ''
      do i = 1, size(deck%blocks)
         if (deck%blocks(i)%keyword == 'SECTION') names(i) = deck%blocks(i)%name()
      end do
      text = suggestion(name, names, 'define it with *SECTION')
   end function section_remedy

   !> Reports names that two points of a frame have.
   subroutine check_point_names(deck, frame, diagnostics)
      type(deck_type), intent(in) :: deck
      !> Index of the block of the frame
      integer, intent(in) :: frame
      type(diagnostics_type), intent(inout) :: diagnostics
      type(name_index_type) :: names
      type(origin_type), allocatable :: origins(:)
      integer :: i, k, field, count
      allocate (origins(sum([(size(deck%blocks(i)%lines), i=1, size(deck%blocks))])))
      count = 0
      do i = 1, size(deck%blocks)
         field = 0
         if (i == frame) field = 1
         if (deck%blocks(i)%keyword == 'NODE') field = merge(4, 0, is_part(deck, i, frame))
         if (field == 0) cycle
         do k = 1, size(deck%blocks(i)%lines)
            if (deck%blocks(i)%lines(k)%count() < field) cycle
            call claim(deck%blocks(i)%lines(k))
         end do
      end do

   contains

      !> Takes the name that a line gives a point.
      subroutine claim(line)
         type(line_type), intent(in) :: line
         integer :: first
         first = names%find(line%text(field))
         if (first > 0) then
            call diagnostics%add(line%origin_of(field), "the name '"//line%text(field)//"' is used twice among the points of "// &
               & deck%blocks(frame)%name(), 'give it another name; capitals are not distinguished', origins(first), &
               & 'first defined here')
            return
         end if
         count = count + 1
         origins(count) = line%origin_of(field)
         call names%add(line%text(field), count)
      end subroutine claim

   end subroutine check_point_names

   !> Block of the material or section of a block of members, else of the frame; 0 if none.
   integer function named(deck, frame, block, keyword)
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: frame, block
      character(*), intent(in) :: keyword
      named = 0
      if (frame%has(keyword)) named = deck%find_named(keyword, frame%name(keyword))
      if (block%has(keyword)) named = deck%find_named(keyword, block%name(keyword))
   end function named

   !> Reads a set of nodes or members.
   subroutine read_set(block, keyword, kind, numbers, sets, open, diagnostics)
      type(block_type), intent(in) :: block
      character(*), intent(in) :: keyword, kind
      !> Numbers of all nodes or members
      integer, intent(in) :: numbers(:)
      type(draft_set_type), allocatable, intent(inout) :: sets(:)
      !> Whether some of these numbers are in error
      logical, intent(in) :: open
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i, k, item
      do i = 1, size(block%lines)
         do k = 1, block%lines(i)%count()
            item = known(numbers, block%lines(i), k, kind, open, diagnostics)
            if (item > 0) call join_set(sets, block%text(keyword), item)
         end do
      end do
   end subroutine read_set

   !> Reads the sections of a set of members.
   subroutine read_beam_section(deck, block, draft, diagnostics)
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      type(draft_type), intent(inout) :: draft
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i
      logical :: found
      found = .false.
      do i = 1, size(draft%member_sets)
         if (draft%member_sets(i)%name /= lowercase(block%text('ELSET'))) cycle
         found = .true.
         draft%section(draft%member_sets(i)%item) = deck%find_named('SECTION', block%name('SECTION'))
         if (block%has('MATERIAL')) draft%material(draft%member_sets(i)%item) = deck%find_named('MATERIAL', block%name('MATERIAL'))
      end do
      if (found) return
      draft%open_sections = .true.
      if (draft%open_members) then
         call diagnostics%follow()
      else
         call diagnostics%add(block%origin_of('ELSET'), "there is no set of members '"//block%text('ELSET')//"'", &
            & listed_sets(draft%member_sets, block%text('ELSET')))
      end if
   end subroutine read_beam_section

   !> Reads the fixed degrees of freedom of nodes.
   subroutine read_boundary(block, draft, diagnostics)
      type(block_type), intent(in) :: block
      type(draft_type), intent(inout) :: draft
      type(diagnostics_type), intent(inout) :: diagnostics
      integer, allocatable :: nodes(:)
      integer :: i, first, last, k
      do i = 1, size(block%lines)
         associate (line => block%lines(i))
            call labelled(line, draft, nodes, diagnostics)
            first = nint(line%number(2))
            last = first
            if (line%count() > 2) last = nint(line%number(3))
            if (line%count() > 2 .and. last > most_freedoms) then
               call diagnostics%add(line%origin_of(3), 'a node has no degree of freedom '//as_text(last), &
                  & 'give 6 at most: 1 (x), 2 (y), 6 (rotation)')
               cycle
            end if
            if (.not. any(freedoms(first, last))) then
               call diagnostics%add(line%origin_of(2), 'a node in the plane has the degrees of freedom 1 (x), 2 (y) and 6 '// &
                  & '(rotation); nothing is held here', 'give 1, 2 or 6, or a first and a last one')
               cycle
            end if
            do k = 1, size(nodes)
               draft%free(:, nodes(k)) = draft%free(:, nodes(k)) .and. .not. freedoms(first, last)
            end do
         end associate
      end do
   end subroutine read_boundary

   !> Whether x, y and rotation are among the degrees of freedom first to last (3), in the numbering 1, 2, 6.
   pure function freedoms(first, last) result(which)
      integer, intent(in) :: first, last
      logical :: which(3)
      which = [1, 2, 6] >= first .and. [1, 2, 6] <= last
   end function freedoms

   !> Reads concentrated masses.
   subroutine read_masses(block, draft, diagnostics)
      type(block_type), intent(in) :: block
      type(draft_type), intent(inout) :: draft
      type(diagnostics_type), intent(inout) :: diagnostics
      integer, allocatable :: nodes(:)
      integer :: i
      do i = 1, size(block%lines)
         associate (line => block%lines(i))
            call labelled(line, draft, nodes, diagnostics)
            draft%mass(nodes) = draft%mass(nodes) + line%number(2)
            if (line%count() > 2) draft%inertia(nodes) = draft%inertia(nodes) + line%number(3)
         end associate
      end do
   end subroutine read_masses

   !> Reads the degrees of freedom with static functions.
   subroutine read_attachments(block, draft, diagnostics)
      type(block_type), intent(in) :: block
      type(draft_type), intent(inout) :: draft
      type(diagnostics_type), intent(inout) :: diagnostics
      integer, allocatable :: nodes(:), longer(:, :)
      integer :: i, k, old
      do i = 1, size(block%lines)
         associate (line => block%lines(i), freedom => nint(block%lines(i)%number(2)))
            call labelled(line, draft, nodes, diagnostics)
            if (count(freedoms(freedom, freedom)) /= 1) then
               call diagnostics%add(line%origin_of(2), 'a node in the plane has no degree of freedom '//as_text(freedom), &
                  & 'give 1 (x), 2 (y) or 6 (rotation)')
               cycle
            end if
            do k = 1, size(nodes)
               old = size(draft%attachments, 2)
               allocate (longer(2, old + 1))
               longer(:, :old) = draft%attachments
               longer(:, old + 1) = [nodes(k), min(freedom, 3)]
               call move_alloc(longer, draft%attachments)
            end do
         end associate
      end do
   end subroutine read_attachments

   !> Nodes by the first field of a line: a number or a set.
   subroutine labelled(line, draft, nodes, diagnostics)
      type(line_type), intent(in) :: line
      type(draft_type), intent(in) :: draft
      !> Indices of the nodes
      integer, allocatable, intent(out) :: nodes(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i
      if (line%text(1) == '') then
         i = known(draft%node, line, 1, 'node', draft%open_nodes, diagnostics)
         allocate (nodes(merge(1, 0, i > 0)))
         nodes = i
         return
      end if
      allocate (nodes(0))
      do i = 1, size(draft%node_sets)
         if (draft%node_sets(i)%name == line%text(1)) nodes = [nodes, draft%node_sets(i)%item]
      end do
      if (size(nodes) > 0) return
      if (draft%open_nodes) then
         call diagnostics%follow()
      else
         call diagnostics%add(line%origin_of(1), "there is no set of nodes '"//line%text(1)//"'", &
            & listed_sets(draft%node_sets, line%text(1)))
      end if
   end subroutine labelled

   !> The nearest name of existing sets, else all of them, for a message.
   pure function listed_sets(sets, name) result(text)
      type(draft_set_type), intent(in) :: sets(:)
      !> What the deck names
      character(*), intent(in) :: name
      character(:), allocatable :: text
      integer :: i
      text = 'this frame has no sets; make one with *NSET or *ELSET'
      do i = 1, size(sets)
         if (any(sets(:i - 1)%name == sets(i)%name)) cycle
         if (i == 1) text = 'valid: '//trim(sets(i)%name)
         if (i > 1) text = text//', '//trim(sets(i)%name)
      end do
      text = suggestion(name, sets%name, text)
   end function listed_sets

   !> Index of a number in the list; 0 and an error if it is not there.
   integer function known(numbers, line, i, kind, open, diagnostics)
      integer, intent(in) :: numbers(:)
      type(line_type), intent(in) :: line
      !> Field of the line
      integer, intent(in) :: i
      character(*), intent(in) :: kind
      !> Whether some of the numbers are in error: a missing one follows from that
      logical, intent(in) :: open
      type(diagnostics_type), intent(inout) :: diagnostics
      known = place_of(numbers, nint(line%number(i)))
      if (known > 0) return
      if (open) call diagnostics%follow()
      if (.not. open) call diagnostics%add(line%origin_of(i), 'this frame has no '//kind//' '//as_text(line%number(i)), &
         & 'define it first')
   end function known

   !> Index of a number in the list; 0 if it is not there.
   pure integer function place_of(numbers, number)
      integer, intent(in) :: numbers(:), number
      do place_of = size(numbers), 1, -1
         if (numbers(place_of) == number) return
      end do
   end function place_of

   !> Adds a node or member to a set.
   pure subroutine join_set(sets, name, item)
      type(draft_set_type), allocatable, intent(inout) :: sets(:)
      character(*), intent(in) :: name
      integer, intent(in) :: item
      type(draft_set_type), allocatable :: longer(:)
      integer :: n
      n = size(sets)
      allocate (longer(n + 1))
      longer(:n) = sets
      longer(n + 1)%name = lowercase(name)
      longer(n + 1)%item = item
      call move_alloc(longer, sets)
   end subroutine join_set

   !> Computes the rigidities of all members; reports members without material or section.
   subroutine settle_members(deck, frame, draft, diagnostics)
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: frame
      type(draft_type), intent(inout) :: draft
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: m
      if (size(draft%number) == 0 .and. .not. draft%open_members) call diagnostics%add(frame%origin, "frame '"// &
         & frame%name()//"' has no members", 'add *NODE and *ELEMENT below it')
      do m = 1, size(draft%number)
         if (draft%material(m) == 0 .or. draft%section(m) == 0) then
            ! The first stands for all
            if (.not. draft%open_sections) call diagnostics%add(draft%member_origin(m), 'member '//as_text(draft%number(m))// &
               & ' has no '//trim(merge('material', 'section ', draft%material(m) == 0)), &
               & 'name one at *FRAME, *ELEMENT or *BEAM SECTION')
            draft%open_sections = .true.
            cycle
         end if
         call read_section(deck%blocks(draft%section(m)), draft%strength(:, m), diagnostics)
         associate (member => draft%members(m), material => deck%blocks(draft%material(m)))
            member%ea = material%real('YOUNG')*draft%strength(1, m)
            member%ei = material%real('YOUNG')*draft%strength(2, m)
            member%rho_a = material%real('DENSITY')*draft%strength(1, m)
         end associate
      end do
   end subroutine settle_members

   !> Index of a member by its number; 0 if there is none.
   pure integer function member_of(draft, number) result(member)
      type(draft_type), intent(in) :: draft
      integer, intent(in) :: number
      member = place_of(draft%number, number)
   end function member_of

   !> Index of the node of a named point of a frame; 0 if there is none.
   integer function node_named(deck, frame, draft, name) result(node)
      type(deck_type), intent(in) :: deck
      !> Index of the block of the frame
      integer, intent(in) :: frame
      type(draft_type), intent(in) :: draft
      !> Name of the point without the name of the frame
      character(*), intent(in) :: name
      integer :: i, k
      node = 0
      do i = 1, size(draft%node)
         if (name == 'origin' .and. all(abs(draft%place(:, i)) <= 0.0_wp)) node = i
      end do
      do i = 1, size(deck%blocks)
         if (deck%blocks(i)%keyword /= 'NODE') cycle
         if (.not. is_part(deck, i, frame)) cycle
         do k = 1, size(deck%blocks(i)%lines)
            if (deck%blocks(i)%lines(k)%count() < 4) cycle
            if (deck%blocks(i)%lines(k)%text(4) == name) node = findloc(draft%node, nint(deck%blocks(i)%lines(k)%number(1)), dim=1)
         end do
      end do
   end function node_named

end module limber_model_frame_draft
