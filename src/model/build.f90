!> Builder of the model from the deck. It checks everything beyond the grammar of the deck. Each error gives its place in the deck.
!> Floor: model.
module limber_model_build
   use limber_base_kinds, only: wp
   use limber_deck_content, only: deck_type, block_type, tell_block
   use limber_deck_diagnostics, only: diagnostics_type, max_errors
   use limber_deck_origin, only: origin_type
   use limber_beam_reduction_cache, only: library_type
   use limber_model_analyses, only: add_analyses
   use limber_model_beams, only: add_beam
   use limber_model_bodies, only: add_rigid_body, add_point_mass, add_points
   use limber_model_requested_channels, only: add_channels, check_expressions, check_studied, flexible_instead
   use limber_model_first_state, only: read_assembly
   use limber_model_frames, only: add_frame
   use limber_model_gravity, only: read_gravity, warn_of_degrees
   use limber_model_large_frames, only: is_large, has_large_frames, expand_frames, unite_frame
   use limber_model_lists, only: trim_lists
   use limber_model_body_damping, only: add_damping
   use limber_model_event_checks, only: check_events
   use limber_model_element, only: elements, find_element
   use limber_model_rigid_stops, only: add_touches, check_contacts
   use limber_model_curve_block, only: check_curve
   use limber_model_control_checks, only: check_controls
   use limber_model_control_laws, only: insert_outputs
   use limber_model_load_laws, only: resolve_laws
   use limber_model_body_parts, only: check_parts, refuse_incomplete
   use limber_model_points, only: add_point, find_body
   use limber_model_ramps, only: warn_of_ramp
   use limber_model_run_scalars, only: add_scalars
   use limber_model_model, only: model_type, body_flexible, ground
   use limber_model_sections, only: check_material, check_section
   use limber_model_short_beams, only: warn_of_short
   use limber_model_switches, only: set_switch
   use limber_model_beam_segments, only: pieces_of
   use limber_model_force_sections, only: add_recoveries
   implicit none
   private
   public :: build_model

contains

   !> Builds the model and collects errors in `diagnostics`. Choices that the deck leaves open are written into it, so that the
   !> effective deck shows them.
   subroutine build_model(deck, model, diagnostics, library)
      type(deck_type), intent(inout) :: deck
      type(model_type), intent(out) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Modal reductions of earlier models, for reuse; new ones are added
      type(library_type), intent(inout), optional :: library
      type(deck_type) :: expanded
      call refuse_incomplete(deck, diagnostics)
      if (has_large_frames(deck)) then
         expanded = deck
         call expand_frames(expanded, diagnostics)
         call build_blocks(expanded, model, diagnostics, library)
         deck%blocks = expanded%blocks(:size(deck%blocks))
      else
         call build_blocks(deck, model, diagnostics, library)
      end if
   end subroutine build_model

   !> The same for a deck whose large frames are expanded into beams.
   subroutine build_blocks(deck, model, diagnostics, library)
      type(deck_type), intent(inout) :: deck
      type(model_type), intent(out) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      type(library_type), intent(inout), optional :: library
      integer :: i, before, round
      logical :: whole
      allocate (model%bodies(0), model%wholes(0), model%points(0), model%joints(0), model%drivers(0), &
         & model%channels(0))
      allocate (model%load_parts(0), model%loads(0), model%assembly%deflections(0))
      allocate (model%scalars(0), model%spreads(0), model%events(0), model%switches(0), &
         & model%controls(0), model%contacts(0))
      call read_labels(deck, model)
      call add_point(model, 'ground.origin', ground, [0.0_wp, 0.0_wp])
      do i = 1, size(deck%blocks)
         if (diagnostics%count >= max_errors) return
         if (deck%blocks(i)%broken) cycle
         before = diagnostics%count
         select case (deck%blocks(i)%keyword)
         case ('GROUND'); call add_points(deck%blocks(i), 'ground', ground, model, diagnostics)
         case ('MATERIAL'); call check_material(deck%blocks(i), diagnostics)
         case ('SECTION'); call check_section(deck%blocks(i), diagnostics)
         case ('CURVE'); call check_curve(deck%blocks(i), diagnostics)
         case ('GRAVITY'); call read_gravity(deck, i, model, diagnostics)
         case ('RIGID BODY'); call add_rigid_body(deck%blocks(i), model, diagnostics)
         case ('POINT MASS'); call add_point_mass(deck%blocks(i), model)
         case ('BEAM'); call add_beam(deck, i, model, diagnostics, library)
         case ('FRAME'); if (.not. is_large(deck%blocks(i))) call add_frame(deck, i, model, diagnostics)
         case ('ACCURACY'); call read_accuracy(deck%blocks(i), model, diagnostics)
         end select
         if (has_angle(deck%blocks(i)%keyword)) call warn_of_degrees(deck, i, 'ANGLE', diagnostics)
         if (diagnostics%count > before) call tell_block(deck%blocks(i), diagnostics)
      end do
      call check_parts(deck, diagnostics)
      call trim_lists(model)
      do i = 1, size(deck%blocks)
         if (is_large(deck%blocks(i))) call unite_frame(deck, i, model)
      end do
      call add_analyses(deck, model, diagnostics)
      model%length = scene_length(model)
      do round = 0, 2
         do i = 1, size(deck%blocks)
            if (diagnostics%count >= max_errors) return
            if (deck%blocks(i)%broken) cycle
            before = diagnostics%count
            call read_block(deck, i, round, model, diagnostics)
            if (diagnostics%count > before) call tell_block(deck%blocks(i), diagnostics)
         end do
         call trim_lists(model)
      end do
      call insert_outputs(model, diagnostics)
      call add_touches(deck, model, diagnostics)
      call resolve_laws(model, diagnostics)
      call check_controls(deck, model, diagnostics)
      call check_events(deck, model, diagnostics)
      call check_contacts(deck, model, diagnostics)
      ! Again, with the points of the ground that joints and loads use
      model%length = scene_length(model)
      do i = 1, size(deck%blocks)
         if (deck%blocks(i)%broken) cycle
         if (deck%blocks(i)%keyword == 'OUTPUT') call add_channels(deck%blocks(i), model, diagnostics)
      end do
      call trim_lists(model)
      whole = .not. any(deck%blocks%broken)
      do i = 1, size(deck%blocks)
         if (deck%blocks(i)%broken) cycle
         if (deck%blocks(i)%keyword == 'OUTPUT') call want_envelope(deck%blocks(i), model, diagnostics)
         if (deck%blocks(i)%keyword == 'SCALAR' .and. whole) call add_scalars(deck%blocks(i), model, diagnostics)
      end do
      do i = 1, size(deck%blocks)
         if (deck%blocks(i)%broken) cycle
         if (deck%blocks(i)%keyword == 'STUDY' .and. whole) call check_studied(deck%blocks(i), model, diagnostics)
         ! Errors of those that are in use stand where they are used
         if (deck%blocks(i)%keyword == 'EXPRESSION' .and. diagnostics%count == 0) call check_expressions(deck%blocks(i), model, &
            & diagnostics)
      end do
      if (diagnostics%count == 0) call add_recoveries(model, diagnostics)
      if (diagnostics%count == 0) call warn_of_ramp(deck, model, diagnostics)
      if (diagnostics%count == 0) call warn_of_short(deck, model, diagnostics)
      if (all(model%bodies%control > 0) .and. diagnostics%count == 0) call diagnostics%add(origin_type(file=1), &
         & 'the deck has no body; it needs at least one *RIGID BODY, *POINT MASS, *BEAM or *FRAME')
   end subroutine build_blocks

   !> Reads a block of the assembly, of damping, or of a joint, driver or load, in its round.
   subroutine read_block(deck, index, round, model, diagnostics)
      type(deck_type), intent(in) :: deck
      !> Index of the block; 0: before all others, 1: behind all bodies, 2: behind joints and springs too
      integer, intent(in) :: index, round
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: element, joints, drivers, parts
      element = find_element(deck%blocks(index)%keyword)
      if (element > 0) then
         if (elements(element)%item%round /= round) return
         joints = model%counts%joints
         drivers = size(model%drivers)
         parts = size(model%load_parts)
         call elements(element)%item%read(deck, index, model, diagnostics)
         if (elements(element)%item%switchable) call set_switch(deck%blocks(index), joints, drivers, parts, model, diagnostics)
      else if (round == 1 .and. deck%blocks(index)%keyword == 'ASSEMBLY') then
         call read_assembly(deck%blocks(index), model, diagnostics)
      else if (round == 1 .and. deck%blocks(index)%keyword == 'DAMPING') then
         call add_damping(deck%blocks(index), model, diagnostics)
      end if
   end subroutine read_block

   !> Whether a keyword has an option ANGLE for an initial direction.
   pure logical function has_angle(keyword)
      character(*), intent(in) :: keyword
      has_angle = any([character(12) :: 'RIGID BODY', 'BEAM', 'FRAME', 'JOINT', 'BUSHING'] == keyword)
   end function has_angle

   !> Marks the body whose envelope of section forces the deck asks for.
   subroutine want_envelope(block, model, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: body, pieces(2)
      if (.not. block%has('ENVELOPE')) return
      body = find_body(model, block%name('ENVELOPE'))
      if (body == 0) return
      pieces = pieces_of(model, body)
      model%bodies(pieces(1):pieces(2))%envelope = .true.
      if (model%bodies(body)%kind /= body_flexible) call diagnostics%add(block%origin_of('ENVELOPE'), "'"// &
         & block%name('ENVELOPE')//"' is rigid: its internal forces are not computed", flexible_instead(model%bodies(body)), &
         & object=block%name('ENVELOPE'))
   end subroutine want_envelope

   !> Reads *ACCURACY.
   subroutine read_accuracy(block, model, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp), parameter :: largest = 0.1_wp, smallest = 1.0e-9_wp
      model%accuracy%estimate = block%yes('ESTIMATE')
      model%accuracy%target = block%real('TARGET')
      if (.not. (block%given('ESTIMATE') .or. block%given('TARGET'))) call diagnostics%warn(block%origin, &
         & '*ACCURACY asks for nothing', 'add ESTIMATE=YES, or TARGET=')
      if (.not. block%has('TARGET')) return
      if (model%accuracy%target > largest .or. model%accuracy%target < smallest) call diagnostics%add( &
         & block%origin_of('TARGET'), 'no error that can be aimed at', 'give a relative error from 1e-9 to 0.1')
   end subroutine read_accuracy

   !> Reads heading and units.
   subroutine read_labels(deck, model)
      type(deck_type), intent(in) :: deck
      type(model_type), intent(inout) :: model
      integer :: block, i
      model%heading = ''
      block = deck%find('HEADING')
      if (block > 0) then
         do i = 1, size(deck%blocks(block)%lines)
            if (i > 1) model%heading = model%heading//' '
            model%heading = model%heading//deck%blocks(block)%lines(i)%content
         end do
      end if
      model%units%length = 'm'
      model%units%time = 's'
      model%units%mass = 'kg'
      block = deck%find('UNITS')
      if (block == 0) return
      model%units%length = deck%blocks(block)%text('LENGTH')
      model%units%time = deck%blocks(block)%text('TIME')
      model%units%mass = deck%blocks(block)%text('MASS')
   end subroutine read_labels


   !> Characteristic length: size of the largest body; without any size the extent of the initial positions; else 1.
   pure real(wp) function scene_length(model) result(length)
      type(model_type), intent(in) :: model
      integer :: i
      length = 0.0_wp
      do i = 1, size(model%bodies)
         length = max(length, model%bodies(i)%size)
      end do
      do i = 1, size(model%wholes)
         length = max(length, model%wholes(i)%length)
      end do
      if (length > 0.0_wp) return
      length = extent(model)
      if (length > 0.0_wp) return
      do i = 1, size(model%bodies)
         length = max(length, norm2(model%bodies(i)%position))
      end do
      if (.not. length > 0.0_wp) length = 1.0_wp
   end function scene_length

   !> Twice the largest distance of the bodies and of the named ground points that joints and loads use from their mean position;
   !> independent of the origin. 0 if they are at one place.
   pure real(wp) function extent(model)
      type(model_type), intent(in) :: model
      !> Distances below this fraction of the distance to the origin count as zero
      real(wp), parameter :: together = 1.0e-9_wp
      real(wp) :: middle(2), farthest
      logical :: used(0:size(model%points))
      integer :: i, count
      used = used_points(model)
      middle = 0.0_wp
      count = 0
      do i = 1, size(model%bodies)
         if (model%bodies(i)%control > 0) cycle
         middle = middle + model%bodies(i)%position
         count = count + 1
      end do
      do i = 1, size(model%points)
         if (.not. is_place(i)) cycle
         middle = middle + model%points(i)%p0
         count = count + 1
      end do
      middle = middle/max(1, count)
      farthest = 0.0_wp
      do i = 1, size(model%bodies)
         if (model%bodies(i)%control == 0) farthest = max(farthest, norm2(model%bodies(i)%position - middle))
      end do
      do i = 1, size(model%points)
         if (is_place(i)) farthest = max(farthest, norm2(model%points(i)%p0 - middle))
      end do
      extent = 0.0_wp
      if (farthest > together*norm2(middle)) extent = 2*farthest

   contains

      !> Whether a point is a named point of the ground that something uses.
      pure logical function is_place(i)
         integer, intent(in) :: i
         is_place = used(i) .and. model%points(i)%body == ground .and. model%points(i)%name /= 'ground.origin'
      end function is_place

   end function extent

   !> Which points joints, drivers and loads use; the first place is for none.
   pure function used_points(model) result(used)
      type(model_type), intent(in) :: model
      logical :: used(0:size(model%points))
      integer :: i
      used = .false.
      do i = 1, size(model%joints)
         used(model%joints(i)%points) = .true.
      end do
      do i = 1, size(model%drivers)
         used(model%drivers(i)%points) = .true.
      end do
      do i = 1, size(model%load_parts)
         used(model%load_parts(i)%points) = .true.
      end do
   end function used_points

end module limber_model_build
