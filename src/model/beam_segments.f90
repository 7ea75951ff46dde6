!> Beams in segments: pieces with a frame each. The pieces are equal, each has a floating frame, and they are welded end to end, for
!> deflections beyond the range of one frame. Each piece deflects little from its own frame; the sum approaches the geometrically
!> exact beam. The deck names the whole beam; this module finds the piece. Floor: model. Source: doc/theory, part 2.
module limber_model_beam_segments
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_deck_content, only: deck_type, block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_origin, only: origin_type
   use limber_beam_beam_mesh, only: new_support
   use limber_beam_exact_beam, only: undeformed_place
   use limber_beam_beam_reduction, only: reduction_type, point_shape, exact_shape
   use limber_model_joint_kind, only: describe_joint
   use limber_model_lists, only: append
   use limber_model_points, only: add_point, enter_name, find_body
   use limber_model_model, only: model_type, body_type, whole_type, joint_type, body_flexible
   implicit none
   private
   public :: number_of_pieces, choose_frame, place_piece, piece_at, unite, append_whole, weld_pieces, add_beam_point
   public :: pieces_of, piece_start, name_in_deck, find_frame, has_frame

contains

   !> Number of pieces of a beam; 1 for a rigid beam.
   pure integer function number_of_pieces(block) result(pieces)
      type(block_type), intent(in) :: block
      pieces = max(1, block%integer('SEGMENTS'))
      if (block%word('GEOMETRIC') == 'RIGID') pieces = 1
   end function number_of_pieces

   !> Chooses the frame of a piece: along its chord, from its start. Exception: for a clamped start, the frame of the first piece is
   !> the section at the start, the frame of the whole beam.
   subroutine choose_frame(block, piece, choice)
      type(block_type), intent(in) :: block
      integer, intent(in) :: piece
      type(reduction_type), intent(inout) :: choice
      choice%origin = 0.0_wp
      if (piece == 1 .and. is_clamped(block)) then
         choice%support = new_support('CLAMPED-FREE')
      else
         choice%support = new_support('PINNED-ROLLER')
      end if
   end subroutine choose_frame

   !> Whether the start of the beam is clamped.
   pure logical function is_clamped(block)
      type(block_type), intent(in) :: block
      is_clamped = index(block%word('SUPPORT'), 'CLAMPED-') == 1
   end function is_clamped

   !> Sets name and initial guess of a piece: the whole beam straight, in the motion of one rigid body.
   subroutine place_piece(block, piece, pieces, body)
      type(block_type), intent(in) :: block
      integer, intent(in) :: piece, pieces
      type(body_type), intent(inout) :: body
      real(wp) :: offset(2)
      offset = ((piece - 1)*block%real('LENGTH')/pieces - block%real('ORIGIN'))*[cos(body%angle), sin(body%angle)]
      body%name = block%name()//'/'//as_text(piece)
      body%position = body%position + offset
      body%velocity = body%velocity + body%spin*[-offset(2), offset(1)]
   end subroutine place_piece

   !> Piece that contains a coordinate along the whole beam, counted from 1; at a boundary the lower one.
   pure integer function piece_at(s, length, pieces) result(piece)
      !> Coordinate, and length of a piece [length]
      real(wp), intent(in) :: s, length
      integer, intent(in) :: pieces
      do piece = 1, pieces - 1
         if (s <= piece*length*(1 + 1.0e-12_wp)) return
      end do
      piece = pieces
   end function piece_at

   !> Joins pieces to a whole, from `first` to the last body of the model. The name of the whole refers to its first piece.
   subroutine unite(model, block, first)
      type(model_type), intent(inout) :: model
      type(block_type), intent(in) :: block
      integer, intent(in) :: first
      type(whole_type) :: whole
      whole%name = block%name()
      whole%first = first
      whole%last = model%counts%bodies
      whole%length = block%real('LENGTH')
      whole%origin = block%real('ORIGIN')
      whole%clamped = is_clamped(block)
      whole%inner = whole%last - whole%first
      call append_whole(model, whole)
   end subroutine unite

   !> Appends a whole. Its name refers to its first piece.
   subroutine append_whole(model, whole)
      type(model_type), intent(inout) :: model
      type(whole_type), intent(in) :: whole
      type(whole_type), allocatable :: longer(:)
      integer :: n
      n = size(model%wholes) + 1
      allocate (longer(n))
      longer(:n - 1) = model%wholes
      longer(n) = whole
      call move_alloc(longer, model%wholes)
      model%bodies(whole%first:whole%last)%whole = n
      call enter_name(model, 'body', whole%name, whole%first)
   end subroutine append_whole

   !> Welds each piece of a beam to the one before it.
   subroutine weld_pieces(model, index)
      type(model_type), intent(inout) :: model
      !> Index of the whole
      integer, intent(in) :: index
      type(joint_type) :: weld
      integer :: body
      call describe_joint('WELD', weld)
      weld%has_turn = .true.
      do body = model%wholes(index)%first + 1, model%wholes(index)%last
         weld%name = model%bodies(body)%name
         call add_beam_point(model, model%bodies(body)%name//'.start', body, 0.0_wp)
         weld%points(1) = model%counts%points
         call add_beam_point(model, model%bodies(body - 1)%name//'.end', body - 1, model%bodies(body - 1)%beam%length)
         weld%points(2) = model%counts%points
         call append(model%joints, model%counts%joints, weld)
      end do
   end subroutine weld_pieces

   !> Adds a point of a beam or piece.
   subroutine add_beam_point(model, name, body, s)
      type(model_type), intent(inout) :: model
      character(*), intent(in) :: name
      integer, intent(in) :: body
      !> Coordinate along the body [length]
      real(wp), intent(in) :: s
      real(wp), allocatable :: phi(:, :), psi(:), reach(:)
      real(wp) :: p0(2)
      p0 = [s - model%bodies(body)%choice%origin, 0.0_wp]
      if (model%bodies(body)%reduced%is_exact) then
         call exact_shape(model%bodies(body)%reduced%exact, s, phi, psi, reach)
         p0 = undeformed_place(model%bodies(body)%reduced%exact, s)
      else if (model%bodies(body)%kind == body_flexible) then
         call point_shape(model%bodies(body)%field, s, phi, psi)
      end if
      call add_point(model, name, body, p0, phi, psi, reach)
      model%points(model%counts%points)%member = 1
      model%points(model%counts%points)%along = s
   end subroutine add_beam_point

   !> First and last body of the whole beam of a piece (2); for any other body the body itself.
   pure function pieces_of(model, body) result(pieces)
      type(model_type), intent(in) :: model
      integer, intent(in) :: body
      integer :: pieces(2)
      pieces = body
      if (body <= 0) return
      if (model%bodies(body)%whole > 0) pieces = [model%wholes(model%bodies(body)%whole)%first, &
         & model%wholes(model%bodies(body)%whole)%last]
   end function pieces_of

   !> Coordinate of the start of a piece along the whole beam [length]; 0 for any other body and for members of a frame.
   pure real(wp) function piece_start(model, body) result(start)
      type(model_type), intent(in) :: model
      integer, intent(in) :: body
      start = 0.0_wp
      if (model%bodies(body)%whole == 0) return
      associate (whole => model%wholes(model%bodies(body)%whole))
         if (.not. allocated(whole%lean)) start = (body - whole%first)*model%bodies(body)%beam%length
      end associate
   end function piece_start

   !> Name of a body in the deck; for a piece the name of the whole beam.
   pure function name_in_deck(model, body) result(name)
      type(model_type), intent(in) :: model
      integer, intent(in) :: body
      character(:), allocatable :: name
      name = model%bodies(body)%name
      if (model%bodies(body)%whole > 0) name = model%wholes(model%bodies(body)%whole)%name
   end function name_in_deck

   !> Whether the deck can drive or load the frame of a body: not for a beam in segments, unless its start is clamped.
   pure logical function has_frame(model, body)
      type(model_type), intent(in) :: model
      integer, intent(in) :: body
      has_frame = .true.
      if (body <= 0) return
      if (model%bodies(body)%whole > 0) has_frame = model%wholes(model%bodies(body)%whole)%clamped
   end function has_frame

   !> Index of a body by name, for use of its frame; 0 if there is none. Adds an error for a beam in segments or a large frame,
   !> which have no single frame.
   integer function find_frame(model, name, origin, diagnostics, instead) result(body)
      type(model_type), intent(in) :: model
      character(*), intent(in) :: name
      !> Place of the name in the deck
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Suggestion of the message; default: a point or a joint
      character(*), intent(in), optional :: instead
      character(:), allocatable :: remedy
      body = find_body(model, name)
      if (has_frame(model, body)) return
      if (allocated(model%wholes(model%bodies(body)%whole)%lean)) then
         remedy = 'name a point of it, or a joint'
         if (present(instead)) remedy = instead
         call diagnostics%add(origin, "frame '"//name//"' is LARGE and has no floating frame", remedy)
      else
         remedy = 'name a point of it or a joint at its start'
         if (present(instead)) remedy = instead
         call diagnostics%add(origin, "beam '"//name//"' is in segments and has no frame of its own", &
            & remedy//', or give it SUPPORT=CLAMPED-FREE')
      end if
      body = 0
   end function find_frame

end module limber_model_beam_segments
