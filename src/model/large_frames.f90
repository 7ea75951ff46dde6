!> Frames with large bending as exact beams. Each member becomes an exact beam, welded to the others at the nodes. Beams, masses and
!> welds are appended to a copy of the deck before the model is built. Points of the frame become points of its members; the sign
!> `of_frame` before their names is known to `model/points_of_action` and `model/beams`. Floor: model. Source: doc/theory, part 2.
module limber_model_large_frames
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_deck_content, only: deck_type, block_type, line_type, resize_blocks, resize_lines
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_families, only: options_of_frame_modes
   use limber_deck_origin, only: origin_type
   use limber_deck_reader, only: read_deck_text
   use limber_model_frame_draft, only: draft_type, read_draft, member_of
   use limber_model_body_parts, only: is_part
   use limber_model_points, only: find_body, find_named, lies_outside
   use limber_model_model, only: model_type, whole_type
   use limber_model_beam_segments, only: append_whole
   use limber_model_short_beams, only: weigh_frame
   implicit none
   private
   public :: is_large, has_large_frames, expand_frames, unite_frame

   !> Sign before the name of a frame's point among the points of a member
   character(1), parameter, public :: of_frame = '@'
   !> Deck with the blocks to be copied: a beam with a point, a mass, a weld
   character(*), parameter :: nl = new_line('a'), pattern = '*MATERIAL, NAME=m, YOUNG=1, DENSITY=1'//nl// &
      & '*SECTION, NAME=s, SHAPE=CIRCLE, DIAMETER=1'//nl//'*BEAM, NAME=b, MATERIAL=m, SECTION=s, LENGTH=1'//nl//' p, 0'//nl// &
      & '*MASS'//nl//' 0, 1, 1'//nl//'*JOINT, NAME=j, TYPE=WELD'//nl//' b.start, b.end'//nl
   integer, parameter :: beam_pattern = 3, mass_pattern = 4, weld_pattern = 5

contains

   !> Whether a block is a frame of exact beams.
   pure logical function is_large(block)
      type(block_type), intent(in) :: block
      is_large = block%keyword == 'FRAME'
      if (is_large) is_large = block%yes('LARGE')
   end function is_large

   !> Whether a deck has a frame of exact beams.
   pure logical function has_large_frames(deck)
      type(deck_type), intent(in) :: deck
      integer :: i
      has_large_frames = .false.
      do i = 1, size(deck%blocks)
         has_large_frames = has_large_frames .or. is_large(deck%blocks(i))
      end do
   end function has_large_frames

   !> Appends the members of all large frames as beams, and their welds, to the blocks of the deck.
   subroutine expand_frames(deck, diagnostics)
      !> Copy of the deck; the model is built from it
      type(deck_type), intent(inout) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      type(deck_type) :: patterns
      type(diagnostics_type) :: none
      type(draft_type) :: draft
      integer :: i, before, m
      call read_deck_text('', pattern, patterns, none)
      do i = 1, size(deck%blocks)
         if (.not. is_large(deck%blocks(i)) .or. deck%blocks(i)%broken) cycle
         before = diagnostics%count
         call read_draft(deck, i, draft, diagnostics)
         call check_frame(deck, i, draft, diagnostics)
         if (diagnostics%count > before) then
            deck%blocks(i)%broken = .true.
            call diagnostics%tell(deck%blocks(i)%name())
            cycle
         end if
         call warn_of_modes(deck, i, diagnostics)
         do m = 1, size(draft%number)
            call write_member(deck, i, draft, m, patterns)
         end do
         call write_welds(deck, i, draft, patterns)
      end do
      call deck%index_names()
   end subroutine expand_frames

   !> Warns of what is for frames with modes only.
   subroutine warn_of_modes(deck, index, diagnostics)
      type(deck_type), intent(in) :: deck
      !> Block of the frame
      integer, intent(in) :: index
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i
      do i = 1, size(options_of_frame_modes)
         call look(deck%blocks(index), trim(options_of_frame_modes(i)))
      end do
      do i = 1, size(deck%blocks)
         if (.not. is_part(deck, i, index)) cycle
         select case (deck%blocks(i)%keyword)
         case ('ELEMENT'); call look(deck%blocks(i), 'DIVISIONS')
         case ('ATTACHMENT', 'BOUNDARY'); call warn(deck%blocks(i)%origin, '*'//deck%blocks(i)%keyword)
         end select
      end do

   contains

      !> Warns of an option if it is given.
      subroutine look(block, option)
         type(block_type), intent(in) :: block
         character(*), intent(in) :: option
         if (block%given(option)) call warn(block%origin_of(option), option)
      end subroutine look

      subroutine warn(origin, what)
         type(origin_type), intent(in) :: origin
         character(*), intent(in) :: what
         call diagnostics%warn(origin, "frame '"//deck%blocks(index)%name()//"': "//what//' means nothing with LARGE=YES', &
            & 'leave it out')
      end subroutine warn

   end subroutine warn_of_modes

   !> Reports a *BOUNDARY on a large frame, and points beside its members.
   subroutine check_frame(deck, index, draft, diagnostics)
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: index
      type(draft_type), intent(in) :: draft
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp) :: length
      integer :: i, m
      if (count(.not. draft%free(:, :size(draft%node))) > 3) then
         do i = 1, size(deck%blocks)
            if (deck%blocks(i)%keyword /= 'BOUNDARY') cycle
            if (is_part(deck, i, index)) call diagnostics%add(deck%blocks(i)%origin, "frame '"//deck%blocks(index)%name()// &
               & "' is LARGE and has no floating frame that *BOUNDARY could hold its nodes in", &
               & 'hold them by *JOINT, at the ground or at another body')
         end do
      end if
      do i = 1, size(deck%blocks(index)%lines)
         associate (point => deck%blocks(index)%lines(i))
            m = member_of(draft, nint(point%number(2)))
            if (m == 0) then
               call diagnostics%add(point%origin_of(2), 'this frame has no member '//as_text(nint(point%number(2))), &
                  & 'members have the numbers that *ELEMENT gives')
               cycle
            end if
            length = norm2(draft%place(:, draft%members(m)%ends(2)) - draft%place(:, draft%members(m)%ends(1)))
            if (lies_outside(point%number(3), length)) call diagnostics%add(point%origin_of(3), &
               & 'the point lies outside the member', 'give a coordinate from 0 to '//as_text(length))
         end associate
      end do
   end subroutine check_frame

   !> Writes one member: a beam with named points and masses.
   subroutine write_member(deck, index, draft, m, patterns)
      type(deck_type), intent(inout) :: deck
      !> Block of the frame
      integer, intent(in) :: index
      type(draft_type), intent(in) :: draft
      !> Index of the member; deck with the blocks to be copied
      integer, intent(in) :: m
      type(deck_type), intent(in) :: patterns
      type(line_type), allocatable :: lines(:)
      character(:), allocatable :: name
      real(wp) :: line(2), length, lean, offset(2), turn(2), angle
      integer :: new, k, node, i, j
      line = draft%place(:, draft%members(m)%ends(2)) - draft%place(:, draft%members(m)%ends(1))
      length = norm2(line)
      lean = atan2(line(2), line(1))
      name = member_name(deck%blocks(index), draft, m)
      allocate (lines(0))
      do k = 1, 2
         node = draft%members(m)%ends(k)
         if (owner(draft, node) /= m) cycle
         if (all(abs(draft%place(:, node)) <= 0.0_wp)) call add_line('origin', (k - 1)*length)
         do i = 1, size(deck%blocks)
            if (deck%blocks(i)%keyword /= 'NODE') cycle
            if (.not. is_part(deck, i, index)) cycle
            do j = 1, size(deck%blocks(i)%lines)
               associate (point => deck%blocks(i)%lines(j))
                  if (point%count() < 4) cycle
                  if (nint(point%number(1)) == draft%node(node)) call add_line(point%text(4), (k - 1)*length)
               end associate
            end do
         end do
      end do
      do j = 1, size(deck%blocks(index)%lines)
         associate (point => deck%blocks(index)%lines(j))
            if (member_of(draft, nint(point%number(2))) == m) call add_line(point%text(1), point%number(3))
         end associate
      end do
      call append_block(deck, patterns%blocks(beam_pattern), draft%member_origin(m), new)
      angle = deck%blocks(index)%real('ANGLE')
      turn = [cos(angle), sin(angle)]
      offset = draft%place(1, draft%members(m)%ends(1))*turn + draft%place(2, draft%members(m)%ends(1))*[-turn(2), turn(1)]
      call deck%set_option(new, 'NAME', name)
      call deck%set_option(new, 'MATERIAL', deck%blocks(draft%material(m))%name())
      call deck%set_option(new, 'SECTION', deck%blocks(draft%section(m))%name())
      call deck%set_option(new, 'GEOMETRIC', 'EXACT', given=.true.)
      call deck%set_number(new, 'LENGTH', length)
      call deck%set_number(new, 'ANGLE', angle + lean, given=deck%blocks(index)%given('ANGLE'))
      associate (frame => deck%blocks(index), spin => deck%blocks(index)%real('SPIN'))
         call deck%set_number(new, 'X', frame%real('X') + offset(1), given=frame%given('X'))
         call deck%set_number(new, 'Y', frame%real('Y') + offset(2), given=frame%given('Y'))
         call deck%set_number(new, 'VX', frame%real('VX') - spin*offset(2), given=frame%given('VX'))
         call deck%set_number(new, 'VY', frame%real('VY') + spin*offset(1), given=frame%given('VY'))
         call deck%set_number(new, 'SPIN', spin, given=frame%given('SPIN'))
      end associate
      if (deck%blocks(index)%given('FUNCTIONS')) call deck%set_number(new, 'FUNCTIONS', deck%blocks(index)%real('FUNCTIONS'), &
         & given=.true.)
      if (deck%blocks(index)%given('STRAIN FUNCTIONS')) call deck%set_number(new, 'STRAIN FUNCTIONS', &
         & deck%blocks(index)%real('STRAIN FUNCTIONS'), given=.true.)
      call move_alloc(lines, deck%blocks(new)%lines)
      do k = 1, 2
         node = draft%members(m)%ends(k)
         if (owner(draft, node) /= m) cycle
         if (.not. draft%mass(node) + draft%inertia(node) > 0.0_wp) cycle
         call append_block(deck, patterns%blocks(mass_pattern), draft%node_origin(node), new)
         call deck%set_option(new, 'BODY', name)
         deck%blocks(new)%lines(1)%fields%value = [(k - 1)*length, draft%mass(node), draft%inertia(node)]
      end do

   contains

      !> Adds a point of the frame at coordinate x of the member.
      subroutine add_line(point, x)
         character(*), intent(in) :: point
         real(wp), intent(in) :: x
         integer :: n
         n = size(lines) + 1
         call resize_lines(lines, n)
         lines(n) = patterns%blocks(beam_pattern)%lines(1)
         lines(n)%fields(1)%text = of_frame//point
         lines(n)%fields(2)%value = x
      end subroutine add_line

   end subroutine write_member

   !> Writes the welds: at each node all members are welded to the first one.
   subroutine write_welds(deck, index, draft, patterns)
      type(deck_type), intent(inout) :: deck
      integer, intent(in) :: index
      type(draft_type), intent(in) :: draft
      type(deck_type), intent(in) :: patterns
      integer :: node, m, first, new
      do node = 1, size(draft%node)
         first = owner(draft, node)
         do m = first + 1, size(draft%number)
            if (.not. any(draft%members(m)%ends == node)) cycle
            call append_block(deck, patterns%blocks(weld_pattern), draft%member_origin(m), new)
            call deck%set_option(new, 'NAME', member_name(deck%blocks(index), draft, m)//'/'//as_text(draft%node(node)))
            call deck%set_number(new, 'TURN', lean(m) - lean(first), given=.true.)
            deck%blocks(new)%lines(1)%fields(1)%text = end_name(m)
            deck%blocks(new)%lines(1)%fields(2)%text = end_name(first)
         end do
      end do

   contains

      !> Direction of a member in the axes of the frame [rad].
      pure real(wp) function lean(m)
         integer, intent(in) :: m
         real(wp) :: line(2)
         line = draft%place(:, draft%members(m)%ends(2)) - draft%place(:, draft%members(m)%ends(1))
         lean = atan2(line(2), line(1))
      end function lean

      !> Name of the member's end at the node.
      function end_name(m) result(name)
         integer, intent(in) :: m
         character(:), allocatable :: name
         name = member_name(deck%blocks(index), draft, m)//'.end'
         if (draft%members(m)%ends(1) == node) name = member_name(deck%blocks(index), draft, m)//'.start'
      end function end_name

   end subroutine write_welds

   !> Appends a copy of a block. Origin of all its parts: one place in the deck, for messages.
   subroutine append_block(deck, like, origin, new)
      type(deck_type), intent(inout) :: deck
      type(block_type), intent(in) :: like
      type(origin_type), intent(in) :: origin
      !> Index of the copy
      integer, intent(out) :: new
      integer :: i, k
      new = size(deck%blocks) + 1
      call resize_blocks(deck%blocks, new)
      deck%blocks(new) = like
      associate (block => deck%blocks(new))
         block%origin = origin
         block%options%origin = origin
         do i = 1, size(block%lines)
            block%lines(i)%origin = origin
            do k = 1, size(block%lines(i)%fields)
               block%lines(i)%fields(k)%origin = origin
            end do
         end do
      end associate
   end subroutine append_block

   !> Index of the first member at a node.
   pure integer function owner(draft, node)
      type(draft_type), intent(in) :: draft
      integer, intent(in) :: node
      do owner = 1, size(draft%number)
         if (any(draft%members(owner)%ends == node)) return
      end do
   end function owner

   !> Name of the beam of a member.
   pure function member_name(block, draft, m) result(name)
      !> Block of the frame
      type(block_type), intent(in) :: block
      type(draft_type), intent(in) :: draft
      integer, intent(in) :: m
      character(:), allocatable :: name
      name = block%name()//'/'//as_text(draft%number(m))
   end function member_name

   !> Joins the members of a large frame to a whole. They must be in the model; its name refers to the first of them.
   subroutine unite_frame(deck, index, model)
      type(deck_type), intent(in) :: deck
      !> Block of the frame
      integer, intent(in) :: index
      type(model_type), intent(inout) :: model
      type(diagnostics_type) :: none
      type(draft_type) :: draft
      type(whole_type) :: whole
      integer :: i, m, node, members
      call read_draft(deck, index, draft, none)
      members = size(draft%number)
      if (none%count > 0 .or. members == 0) return
      whole%name = deck%blocks(index)%name()
      whole%first = find_body(model, member_name(deck%blocks(index), draft, 1))
      whole%last = whole%first + members - 1
      ! A refused member has no body
      if (whole%first == 0 .or. find_body(model, member_name(deck%blocks(index), draft, members)) /= whole%last) return
      allocate (whole%member_numbers, source=draft%number)
      allocate (whole%place(2, members), whole%lean(members))
      do m = 1, members
         associate (a => draft%place(:, draft%members(m)%ends(1)), b => draft%place(:, draft%members(m)%ends(2)))
            whole%place(:, m) = a
            whole%lean(m) = atan2(b(2) - a(2), b(1) - a(1))
            whole%length = whole%length + norm2(b - a)
         end associate
      end do
      do node = 1, size(draft%node)
         whole%inner = whole%inner + meeting(node) - 1
         if (all(abs(draft%place(:, node)) <= 0.0_wp)) call note('origin', meeting(node))
      end do
      do i = 1, size(deck%blocks)
         if (deck%blocks(i)%keyword /= 'NODE') cycle
         if (.not. is_part(deck, i, index)) cycle
         do m = 1, size(deck%blocks(i)%lines)
            associate (line => deck%blocks(i)%lines(m))
               if (line%count() > 3) call note(line%text(4), meeting(findloc(draft%node, nint(line%number(1)), dim=1)))
            end associate
         end do
      end do
      call lean_points(model, whole)
      call append_whole(model, whole)
      associate (body => model%bodies(whole%first))
         call weigh_frame(deck, index, draft, body%unsheared, body%shortest)
      end associate

   contains

      !> Number of members at a node.
      pure integer function meeting(node)
         integer, intent(in) :: node
         integer :: m
         meeting = count([(any(draft%members(m)%ends == node), m=1, members)])
      end function meeting

      !> Stores the number of members at a point.
      subroutine note(name, number)
         character(*), intent(in) :: name
         integer, intent(in) :: number
         integer :: point
         point = find_named(model, 'point', whole%name//'.'//name)
         if (point > 0) model%points(point)%meeting = number
      end subroutine note

   end subroutine unite_frame

   !> Directs the axes of frame points along the frame. Axes of the members' own points stay along the members.
   pure subroutine lean_points(model, whole)
      type(model_type), intent(inout) :: model
      type(whole_type), intent(in) :: whole
      integer :: i
      do i = 1, model%counts%points
         associate (point => model%points(i))
            if (point%body < whole%first .or. point%body > whole%last) cycle
            if (index(point%name, whole%name//'.') == 1) point%lean = whole%lean(point%body - whole%first + 1)
         end associate
      end do
   end subroutine lean_points

end module limber_model_large_frames
