!> Beams of the deck, in one piece or in segments: modal reduction, bodies and named points. Floor: model.
module limber_model_beams
   use limber_base_kinds, only: wp, long
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text
   use limber_deck_content, only: deck_type, block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_beam_exact_functions, only: exact_choice_type
   use limber_beam_static_functions, only: attachment_type
   use limber_beam_reduction_cache, only: library_type
   use limber_beam_reduced_body, only: rigid_reduced
   use limber_beam_beam_reduction, only: reduce_beam
   use limber_model_beam_options, only: check_options
   use limber_model_beam_choice, only: read_beam
   use limber_model_bodies, only: new_body, append_body, is_new_point, memory_of, warn_of_rounding
   use limber_model_points, only: enter_name, find_named, lies_outside
   use limber_model_model, only: model_type, body_type, body_rigid, body_flexible
   use limber_model_beam_segments, only: number_of_pieces, place_piece, piece_at, unite, weld_pieces, add_beam_point
   implicit none
   private
   public :: add_beam

   !> Memory limit for the constants and shapes of all bodies [bytes]
   integer(long), parameter :: max_bytes = 1024_long*1024**2

contains

   !> Adds a beam, in one piece or in SEGMENTS pieces.
   subroutine add_beam(deck, index, model, diagnostics, library)
      type(deck_type), intent(inout) :: deck
      !> Index of the block
      integer, intent(in) :: index
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Modal reductions for reuse
      type(library_type), intent(inout), optional :: library
      integer :: pieces, piece, before, first
      pieces = number_of_pieces(deck%blocks(index))
      before = diagnostics%count
      first = model%counts%bodies + 1
      do piece = 1, pieces
         call check_memory(deck%blocks(index), first, pieces - piece + 1, model, diagnostics)
         if (diagnostics%count > before .and. piece > 1) exit
         call add_piece(deck, index, piece, pieces, model, diagnostics, library)
         ! An error of the first piece holds for all pieces
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

   !> Reports too much memory before it is allocated: the model so far and the pieces that follow, which need as much as the first.
   subroutine check_memory(block, first, left, model, diagnostics)
      type(block_type), intent(in) :: block
      !> Index of the first piece, and number of pieces to be added
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

   !> Adds one piece of a beam as a body.
   subroutine add_piece(deck, index, piece, pieces, model, diagnostics, library)
      type(deck_type), intent(inout) :: deck
      !> Index of the block; number of the piece, number of pieces
      integer, intent(in) :: index, piece, pieces
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Modal reductions for reuse
      type(library_type), intent(inout), optional :: library
      type(body_type) :: body
      type(error_type), allocatable :: error
      real(wp) :: rigid(3)
      logical :: usable
      integer :: twin, added
      body = new_body(deck%blocks(index), body_flexible)
      if (piece == 1) call check_options(deck, index, diagnostics)
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
         if (allocated(error)) then
            ! Errors of a section or material were reported before
            if (diagnostics%is_told(deck%blocks(index)%name('SECTION')) .or. &
               & diagnostics%is_told(deck%blocks(index)%name('MATERIAL'))) then
               call diagnostics%follow()
            else
               call diagnostics%add(deck%blocks(index)%origin, "beam '"//body%name//"': "//error%message)
            end if
         end if
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

   !> Index of an identical beam that is reduced already (identical to the last bit); 0 if there is none.
   pure integer function find_twin(model, body) result(twin)
      type(model_type), intent(in) :: model
      type(body_type), intent(in) :: body
      twin = find_named(model, 'beam', fingerprint(body))
   end function find_twin

   !> All data that determine the reduction of a beam, as text. Beams with equal text have equal modes.
   pure function fingerprint(body) result(text)
      type(body_type), intent(in) :: body
      character(:), allocatable :: text
      character(200) :: buffer
      integer :: i
      associate (beam => body%beam, choice => body%choice)
         write (buffer, '(5(z16, 1x), 6(i0, 1x), 10l1)') beam%ea, beam%ei, beam%rho_a, beam%length, choice%origin, beam%elements, &
            & choice%modes, choice%bending, choice%axial, choice%fidelity, choice%geometric_elements, &
            & choice%support, choice%nodal, choice%linear, choice%static_axial
         text = trim(buffer)//exact_text(choice%exact)//attachments_text(choice%corrections)
         if (.not. allocated(beam%place)) return
         do i = 0, beam%elements
            write (buffer, '(3(1x, z16))') beam%place(i), beam%mass(i), beam%inertia(i)
            text = text//trim(buffer)
         end do
      end associate
   end function fingerprint

   !> The same for the data of an exact beam.
   pure function exact_text(choice) result(text)
      type(exact_choice_type), intent(in) :: choice
      character(:), allocatable :: text
      character(200) :: buffer
      integer :: i, j
      write (buffer, '(1x, 2(i0, 1x), 13l1, 5(1x, z16))') choice%angles, choice%strains, choice%shear, choice%support, &
         & choice%moment, choice%shear_force, choice%layered, choice%origin, choice%arc, choice%hot_curvature, choice%hot_strain, &
         & choice%pretension
      text = trim(buffer)
      if (allocated(choice%layers)) text = text//'l'//numbers_text(choice%layers)
      if (allocated(choice%kinks)) text = text//'k'//numbers_text(choice%kinks)
      if (allocated(choice%steps)) text = text//'s'//numbers_text(choice%steps)
      if (allocated(choice%corners)) text = text//'c'//numbers_text(choice%corners)
      if (allocated(choice%pulls)) text = text//'n'//numbers_text(choice%pulls)
      if (.not. allocated(choice%profile%value)) return
      text = text//'p'//numbers_text(choice%profile%at)
      do i = 1, size(choice%profile%value, 3)
         do j = 1, size(choice%profile%value, 2)
            text = text//numbers_text(choice%profile%value(:, j, i))
         end do
      end do
   end function exact_text

   !> Numbers in hexadecimal.
   pure function numbers_text(values) result(text)
      real(wp), intent(in) :: values(:)
      character(17*size(values)) :: text
      integer :: k
      do k = 1, size(values)
         write (text(17*k - 16:17*k), '(1x, z16)') values(k)
      end do
   end function numbers_text

   !> Attachments as text: places and parts.
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

   !> Warns of choices with known wrong results.
   subroutine warn_of_basis(block, body, diagnostics)
      type(block_type), intent(in) :: block
      type(body_type), intent(in) :: body
      type(diagnostics_type), intent(inout) :: diagnostics
      if (body%reduced%geometric .and. body%reduced%n == body%reduced%bending) call diagnostics%warn( &
         & block%origin_of('GEOMETRIC'), "beam '"//body%name//"' has no axial coordinate: no tension, so that its "// &
         & 'geometric stiffness is zero', 'ask for more MODES, or AXIAL MODES=1')
      call warn_of_rounding(real(body%beam%elements, wp), block%origin_of('ELEMENTS'), "beam '"//body%name//"'", diagnostics)
   end subroutine warn_of_basis

   !> Adds the points of the last beam: origin, start, middle, end, and the points of its data lines, `name, coordinate`.
   subroutine add_beam_points(block, first, model, diagnostics)
      type(block_type), intent(in) :: block
      !> Index of its body or first piece
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
            if (lies_outside(line%number(2), block%real('LENGTH'))) then
               call diagnostics%add(line%origin_of(2), 'the point lies outside the beam', &
                  & 'give a coordinate from 0 to '//as_text(length))
               cycle
            end if
            if (is_new_point(model, full_name(line%text(1)), line%origin_of(1), diagnostics)) &
               & call place(line%text(1), line%number(2))
         end associate
      end do

   contains

      !> Adds a point at coordinate s along the whole beam.
      subroutine place(name, s)
         character(*), intent(in) :: name
         real(wp), intent(in) :: s
         integer :: piece
         piece = piece_at(s, length/pieces, pieces)
         call add_beam_point(model, full_name(name), first + piece - 1, &
            & min(max(s - (piece - 1)*length/pieces, 0.0_wp), length/pieces))
      end subroutine place

      !> Name of a point in the model. A point of a large frame on this member has the frame's name.
      pure function full_name(name)
         character(*), intent(in) :: name
         character(:), allocatable :: full_name
         character(:), allocatable :: own
         own = block%name()
         full_name = own//'.'//name
         if (name(1:1) == '@') full_name = own(:index(own, '/') - 1)//'.'//name(2:)
      end function full_name

   end subroutine add_beam_points

end module limber_model_beams
