!> Blocks that belong to a body: nodes, elements, masses, attachments. Floor: model.
module limber_model_body_parts
   use limber_deck_content, only: deck_type, tell_block
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_keywords, only: contains_value
   implicit none
   private
   public :: is_part, check_parts, refuse_incomplete

   !> Keywords of blocks that belong to a body
   character(*), parameter :: part_keywords = 'NODE|ELEMENT|NSET|ELSET|BEAM SECTION|BOUNDARY|MASS|ATTACHMENT|PROFILE'

contains

   !> Whether a block is part of a body. The body is given by its block.
   pure logical function is_part(deck, block, body)
      type(deck_type), intent(in) :: deck
      !> Indices of blocks
      integer, intent(in) :: block, body
      is_part = contains_value(part_keywords, deck%blocks(block)%keyword)
      if (is_part) is_part = owner_of(deck, block) == body
   end function is_part

   !> Marks frames of which a part is in error or missing: what depends on them is no error of its own.
   subroutine refuse_incomplete(deck, diagnostics)
      type(deck_type), intent(inout) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i, owner
      if (diagnostics%count == 0) return
      do i = 1, size(deck%blocks)
         owner = 0
         if (deck%blocks(i)%keyword == 'FRAME') then
            if (diagnostics%is_told(deck%blocks(i)%name())) owner = i
         else if (contains_value(part_keywords, deck%blocks(i)%keyword)) then
            if (deck%blocks(i)%broken .or. follows_unknown(deck, i)) owner = owner_of(deck, i)
            ! A BODY that is no frame may be meant for that above
            if (owner == 0 .and. deck%blocks(i)%broken .and. deck%blocks(i)%given('BODY')) owner = last_frame(deck, i)
         end if
         if (owner == 0) cycle
         if (deck%blocks(owner)%keyword /= 'FRAME') cycle
         deck%blocks(owner)%broken = .true.
         call tell_block(deck%blocks(owner), diagnostics)
      end do
   end subroutine refuse_incomplete

   !> The last frame above a block; 0 if there is none.
   pure integer function last_frame(deck, block) result(frame)
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: block
      do frame = block - 1, 1, -1
         if (deck%blocks(frame)%keyword == 'FRAME') return
      end do
   end function last_frame

   !> Whether a block of an unknown keyword, perhaps that of its body, stands between a part and the last body above it.
   pure logical function follows_unknown(deck, block)
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: block
      follows_unknown = .false.
      if (.not. deck%blocks(block)%has('BODY')) follows_unknown = any(deck%blocks(owner_of(deck, block) + 1:block)%after_unknown)
   end function follows_unknown

   !> Block of the body to which a part belongs: the body named by BODY, else the last body above the part; 0 if there is none.
   pure integer function owner_of(deck, block) result(owner)
      type(deck_type), intent(in) :: deck
      integer, intent(in) :: block
      if (deck%blocks(block)%has('BODY')) then
         owner = deck%find_named('FRAME|BEAM', deck%blocks(block)%name('BODY'))
         return
      end if
      do owner = block - 1, 1, -1
         if (deck%blocks(owner)%keyword == 'FRAME' .and. deck%blocks(block)%keyword /= 'PROFILE') return
         if (deck%blocks(owner)%keyword == 'BEAM' .and. &
            & contains_value('MASS|ATTACHMENT|PROFILE', deck%blocks(block)%keyword)) return
      end do
   end function owner_of

   !> Reports parts that belong to no body.
   subroutine check_parts(deck, diagnostics)
      type(deck_type), intent(in) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i
      do i = 1, size(deck%blocks)
         if (.not. contains_value(part_keywords, deck%blocks(i)%keyword)) cycle
         if (follows_unknown(deck, i)) cycle
         if (owner_of(deck, i) == 0 .and. .not. deck%blocks(i)%has('BODY')) call diagnostics%add(deck%blocks(i)%origin, &
            & '*'//deck%blocks(i)%keyword//' belongs to no body', 'put it below the body that it belongs to, or add BODY=')
      end do
   end subroutine check_parts

end module limber_model_body_parts
