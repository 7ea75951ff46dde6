!> Options of *ASSEMBLY: largest turn without a warning, and initial deflections. Floor: model.
module limber_model_first_state
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_deck_content, only: block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_model_points, only: find_body
   use limber_model_model, only: model_type, deflection_type
   implicit none
   private
   public :: read_assembly

contains

   !> Reads *ASSEMBLY into `model%assembly`. Bodies and their coordinates must be in the model.
   subroutine read_assembly(block, model, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      type(deflection_type) :: deflection
      integer :: i
      model%assembly%largest_turn = block%real('LARGEST TURN')
      model%assembly%elimination = block%yes('ELIMINATION')
      model%assembly%following = block%word('INITIAL DEFLECTIONS') == 'FOLLOWING'
      model%assembly%static_deflections = block%word('INITIAL DEFLECTIONS') == 'STATIC' .or. model%assembly%following
      if (size(block%lines) > 0 .and. block%word('INITIAL DEFLECTIONS') /= 'GIVEN') then
         call diagnostics%add(block%lines(1)%origin, 'data lines give deflections, but INITIAL DEFLECTIONS='// &
            & block%word('INITIAL DEFLECTIONS'), &
            & 'write INITIAL DEFLECTIONS=GIVEN')
         return
      end if
      if (size(block%lines) == 0 .and. block%word('INITIAL DEFLECTIONS') == 'GIVEN') call diagnostics%add( &
         & block%origin_of('INITIAL DEFLECTIONS'), 'INITIAL DEFLECTIONS=GIVEN, but no deflection is given', &
         & 'add data lines: beam, coordinate, value, rate')
      do i = 1, size(block%lines)
         associate (line => block%lines(i))
            deflection%body = find_body(model, line%text(1))
            deflection%coordinate = nint(line%number(2))
            deflection%value = line%number(3)
            deflection%rate = line%number(4)
            if (deflection%body == 0) then
               call diagnostics%add(line%origin_of(1), "there is no body '"//line%text(1)//"'", object=line%text(1))
               cycle
            end if
            associate (body => model%bodies(deflection%body))
               if (body%whole > 0) then
                  call diagnostics%add(line%origin_of(1), "'"//line%text(1)// &
                     & "' is in segments: it has no coordinates of deflection", &
                     & 'let it start straight, or with INITIAL DEFLECTIONS=STATIC')
                  cycle
               end if
               if (deflection%coordinate > body%reduced%n) then
                  call diagnostics%add(line%origin_of(2), "'"//body%name//"' has "//as_text(body%reduced%n)//' coordinates of'// &
                     & ' deflection', 'the bending ones come first, then the axial ones')
                  cycle
               end if
            end associate
            model%assembly%deflections = [model%assembly%deflections, deflection]
         end associate
      end do
   end subroutine read_assembly

end module limber_model_first_state
