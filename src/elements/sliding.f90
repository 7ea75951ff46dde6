!> Point that slides along a beam: TYPE=SLIDING. Floor: elements. Source: doc/theory, eqs. (3.25)-(3.27).
module limber_elements_sliding
   use limber_base_text, only: as_text
   use limber_deck_content, only: block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_model_joint_kind, only: joint_kind_type
   use limber_model_model, only: model_type, joint_type, body_flexible, ground, most_bends, place_on_beam
   implicit none
   private
   public :: sliding_kind_type, sliding_kind

   type, extends(joint_kind_type) :: sliding_kind_type
   contains
      procedure :: check
      procedure :: describe
   end type sliding_kind_type

contains

   pure type(sliding_kind_type) function sliding_kind() result(kind)
      kind%word = 'SLIDING'
      kind%meaning = 'the first point slides along the line of the *BEAM that the second point names, as that bends; the beam ' &
         & //'has at most 24 coordinates: functions of the angle, the strain, one for each place where something acts along it'
      kind%place = place_on_beam
   end function sliding_kind

   !> The second body must be an undivided flexible beam of few coordinates.
   subroutine check(self, block, model, bodies, diagnostics)
      class(sliding_kind_type), intent(in) :: self
      type(block_type), intent(in) :: block
      type(model_type), intent(in) :: model
      integer, intent(in) :: bodies(2)
      type(diagnostics_type), intent(inout) :: diagnostics
      if (bodies(2) /= ground) then
         if (is_in_segments(bodies(2))) then
            call diagnostics%add(block%lines(1)%origin_of(2), "joint '"//block%name()//"' slides along a beam in segments", &
               & 'leave out SEGMENTS: a point slides along an undivided beam only')
            return
         end if
         if (model%bodies(bodies(2))%kind == body_flexible .and. model%bodies(bodies(2))%end_point > 0) then
            if (model%bodies(bodies(2))%reduced%n > most_bends) call diagnostics%add(block%lines(1)%origin_of(2), &
               & "the beam of joint '"//block%name()//"' has "//as_text(model%bodies(bodies(2))%reduced%n)//' coordinates', &
               & 'a point slides along a beam with at most '//as_text(most_bends)//': functions of the angle and the strain,'// &
               & ' one for each place between its ends where joints or loads act along it, and with SHEAR one for each of'// &
               & ' the angle; use fewer FUNCTIONS')
            return
         end if
      end if
      call diagnostics%add(block%lines(1)%origin_of(2), "joint '"//block%name()//"' slides along something that is no "// &
         & 'flexible beam', 'name a *BEAM second; along what is straight, use POINT ON LINE')

   contains

      !> Whether a body is a piece of a beam. Members of a frame are whole beams.
      pure logical function is_in_segments(body)
         integer, intent(in) :: body
         is_in_segments = model%bodies(body)%whole > 0
         if (is_in_segments) is_in_segments = .not. allocated(model%wholes(model%bodies(body)%whole)%lean)
      end function is_in_segments

   end subroutine check

   !> Its equation is that of the deformed axis, not a sum.
   pure subroutine describe(self, joint)
      class(sliding_kind_type), intent(in) :: self
      type(joint_type), intent(inout) :: joint
      allocate (joint%functions(0))
   end subroutine describe

end module limber_elements_sliding
