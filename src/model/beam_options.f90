!> Warnings of options and parts without meaning for the model of a beam or frame. Floor: model.
module limber_model_beam_options
   use limber_base_text, only: as_text
   use limber_deck_content, only: deck_type, block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_families, only: options_of_modes, options_of_exact, options_of_frame_modes, options_of_mesh
   use limber_deck_idle_options, only: gives_default
   use limber_deck_origin, only: origin_type
   use limber_beam_exact_functions, only: elements_of_a_function
   use limber_model_body_parts, only: is_part
   implicit none
   private
   public :: check_options, warn_of_rigid

contains

   !> Warns of options of modal beams on an exact beam, of options of exact beams on another beam, and of those of flexible beams
   !> on a rigid one.
   subroutine check_options(deck, index, diagnostics)
      type(deck_type), intent(in) :: deck
      !> Block of the beam
      integer, intent(in) :: index
      type(diagnostics_type), intent(inout) :: diagnostics
      associate (block => deck%blocks(index))
         if (block%word('GEOMETRIC') == 'EXACT') then
            call look(options_of_modes, 'of an EXACT beam', 'leave it out: FUNCTIONS and STRAIN FUNCTIONS '// &
               & 'say how finely it bends and stretches')
            call check_elements(deck, index, diagnostics)
            call check_support(block, diagnostics)
            return
         end if
         call look([character(20) :: options_of_exact(:2), 'TENSION'], 'of a beam that is not EXACT', &
            & 'leave it out, or write GEOMETRIC=EXACT')
         if (block%word('GEOMETRIC') == 'RIGID') then
            call warn_of_rigid(deck, index, diagnostics)
         else if (block%integer('SEGMENTS') > 1) then
            call diagnostics%add(block%origin_of('SEGMENTS'), "beam '"//block%name()// &
               & "': SEGMENTS is for GEOMETRIC=EXACT only, not for "//block%word('GEOMETRIC'), &
               & 'leave it out, or write GEOMETRIC=EXACT in place of the options of modes')
         else if (block%word('GEOMETRIC') == 'LINEAR' .and. block%word('GEOMETRIC INTEGRAL') == 'NODAL') then
            call diagnostics%warn(block%origin_of('GEOMETRIC INTEGRAL'), "beam '"//block%name()// &
               & "': GEOMETRIC INTEGRAL=NODAL means nothing with GEOMETRIC=LINEAR", 'leave it out, or write GEOMETRIC=K_G')
         end if
      end associate

   contains

      !> Warns of each given option of the list.
      subroutine look(options, kind, remedy)
         character(*), intent(in) :: options(:), kind, remedy
         integer :: i
         associate (block => deck%blocks(index))
            do i = 1, size(options)
               if (.not. block%knows(trim(options(i)))) cycle
               if (block%given(trim(options(i)))) call diagnostics%warn(block%origin_of(trim(options(i))), "beam '"// &
                  & block%name()//"': "//trim(options(i))//' means nothing '//kind, remedy)
            end do
         end associate
      end subroutine look

   end subroutine check_options

   !> Warns of a mesh that is too coarse to matter: an exact beam has its own, unless masses divide it.
   subroutine check_elements(deck, index, diagnostics)
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: index
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i, own
      associate (block => deck%blocks(index))
         own = elements_of_a_function*block%integer('FUNCTIONS')
         if (.not. block%given('ELEMENTS') .or. gives_default(block, 'ELEMENTS') .or. block%integer('ELEMENTS') > own) return
         do i = 1, size(deck%blocks)
            if (deck%blocks(i)%keyword /= 'MASS') cycle
            if (is_part(deck, i, index)) return
         end do
         call diagnostics%warn(block%origin_of('ELEMENTS'), "beam '"//block%name()//"': ELEMENTS="// &
            & as_text(block%integer('ELEMENTS'))//' means nothing of an EXACT beam: its functions are found with '//as_text(own)// &
            & ' elements or more', 'leave it out: FUNCTIONS and STRAIN FUNCTIONS say how finely it bends and stretches')
      end associate
   end subroutine check_elements

   !> Warns of a support of a beam in segments that means no more than another one: only a clamped start counts.
   subroutine check_support(block, diagnostics)
      type(block_type), intent(in) :: block
      type(diagnostics_type), intent(inout) :: diagnostics
      if (block%integer('SEGMENTS') < 2 .or. .not. block%given('SUPPORT')) return
      if (any(block%word('SUPPORT') == [character(13) :: 'PINNED-ROLLER', 'CLAMPED-FREE'])) return
      call diagnostics%warn(block%origin_of('SUPPORT'), "beam '"//block%name()//"': of SUPPORT="//block%word('SUPPORT')// &
         & ' nothing counts with SEGMENTS but whether it begins with CLAMPED', 'write CLAMPED-FREE if its frame is the section'// &
         & ' at its start; PINNED-ROLLER, the default, if that is the line through both ends')
   end subroutine check_support

   !> Warns of options and parts that a rigid beam or frame does not look at: one warning for all.
   subroutine warn_of_rigid(deck, index, diagnostics)
      type(deck_type), intent(in) :: deck
      !> Block of the beam or frame
      integer, intent(in) :: index
      type(diagnostics_type), intent(inout) :: diagnostics
      type(origin_type) :: origin
      character(:), allocatable :: names
      integer :: i
      names = ''
      associate (block => deck%blocks(index))
         ! A search has chosen it where the deck leaves it open
         origin = block%origin_of('GEOMETRIC')
         if (origin%line == block%origin%line .and. origin%first == block%origin%first) return
         if (block%keyword == 'BEAM') then
            call look(block, [character(20) :: options_of_mesh, options_of_modes])
         else
            call look(block, pack(options_of_frame_modes, options_of_frame_modes /= 'GEOMETRIC'))
         end if
         do i = 1, size(deck%blocks)
            if (.not. is_part(deck, i, index)) cycle
            select case (deck%blocks(i)%keyword)
            case ('ELEMENT'); call look(deck%blocks(i), [character(20) :: 'DIVISIONS'])
            case ('BOUNDARY', 'ATTACHMENT'); call add('*'//deck%blocks(i)%keyword, deck%blocks(i)%origin)
            end select
         end do
         if (names == '') return
         call diagnostics%warn(origin, trim(merge('beam ', 'frame', block%keyword == 'BEAM'))//" '"//block%name()//"': "//names// &
            & trim(merge(' mean ', ' means', scan(names, ',') > 0))//' nothing with GEOMETRIC=RIGID', &
            & 'leave out what is for its deflections, or give another GEOMETRIC')
      end associate

   contains

      !> Takes note of each given option of the list.
      subroutine look(block, options)
         type(block_type), intent(in) :: block
         character(*), intent(in) :: options(:)
         integer :: k
         do k = 1, size(options)
            if (.not. block%given(trim(options(k)))) cycle
            if (gives_default(block, trim(options(k)))) cycle
            call add(trim(options(k)), block%origin_of(trim(options(k))))
         end do
      end subroutine look

      !> Adds a name, unless it is there.
      subroutine add(name, place)
         character(*), intent(in) :: name
         type(origin_type), intent(in) :: place
         if (names == '') origin = place
         if (is_listed(name, names)) return
         if (names /= '') names = names//', '
         names = names//name
      end subroutine add

   end subroutine warn_of_rigid

   !> Whether a name stands in a list of names.
   pure logical function is_listed(name, names)
      character(*), intent(in) :: name, names
      is_listed = index(', '//names//',', ', '//name//',') > 0
   end function is_listed

end module limber_model_beam_options
