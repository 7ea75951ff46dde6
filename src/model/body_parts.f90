!> Blocks that belong to a body: nodes, elements, masses, attachments. Floor: model.
module limber_model_body_parts
   use limber_deck_content, only: deck_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_keywords, only: contains_value
   implicit none
   private
   public :: is_part, check_parts

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
         if (owner_of(deck, i) == 0 .and. .not. deck%blocks(i)%has('BODY')) call diagnostics%add(deck%blocks(i)%origin, &
            & '*'//deck%blocks(i)%keyword//' belongs to no body', 'put it below the body that it belongs to, or add BODY=')
      end do
   end subroutine check_parts

end module limber_model_body_parts
