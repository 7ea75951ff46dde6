!> Warning of loads that grow in the first *STATICS while a driver or another load changes by its own law. Then all samples before
!> the end belong to a scene with partial loads, which is rarely meant. A RAMP in the deck suppresses the warning. Floor: model.
module limber_model_ramps
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_deck_content, only: deck_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_expression, only: expression_type
   use limber_deck_operations, only: jet_type
   use limber_model_driver_laws, only: driven_motion
   use limber_model_model, only: model_type, step_statics
   implicit none
   private
   public :: warn_of_ramp

   !> Number of instants at which laws are sampled; largest relative change that counts as no change
   integer, parameter :: looks = 16
   real(wp), parameter :: none = 1.0e-9_wp

contains

   !> Warns if constant loads grow while something moves, and the deck gives no RAMP.
   subroutine warn_of_ramp(deck, model, diagnostics)
      type(deck_type), intent(in) :: deck
      !> Complete model
      type(model_type), intent(in) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: growing, moving
      if (.not. allocated(model%steps)) return
      if (size(model%steps) == 0) return
      associate (step => model%steps(1))
         if (step%kind /= step_statics .or. .not. step%ramp) return
         if (deck%blocks(step%block)%given('RAMP') .or. .not. step%dynamics%end > step%dynamics%start) return
         growing = what_grows(model)
         if (growing == '') return
         moving = what_moves(model, step%dynamics%start, step%dynamics%end)
         if (moving == '') return
         call diagnostics%warn(deck%blocks(step%block)%origin, moving//' by a law of time, while '//growing// &
            & ' from zero to its full size at t = '//as_text(step%dynamics%end, 6), &
            & 'add PERIOD=0, RAMP=NO for a balance at one instant; RAMP=NO for the full size from the start; RAMP=YES if this'// &
            & ' is meant')
      end associate
   end subroutine warn_of_ramp

   !> Text on the weight or the first constant load, as the start of a sentence; empty if there is none.
   function what_grows(model) result(text)
      type(model_type), intent(in) :: model
      character(:), allocatable :: text
      integer :: i, k
      text = ''
      if (norm2(model%gravity) > 0.0_wp) then
         text = 'the weight grows'
         return
      end if
      do i = 1, size(model%loads)
         associate (load => model%loads(i))
            do k = load%first, load%last
               associate (part => model%load_parts(k))
                  if (.not. part%is_constant()) cycle
                  if (abs(part%factor*part%law%constant_value()) > 0.0_wp) text = load%name
               end associate
            end do
         end associate
         if (text == '') cycle
         text = "the constant load '"//text//"' grows"
         return
      end do
   end function what_grows

   !> Text on the first driver, coupler or load that changes between two times; empty if there is none. A load that changes in
   !> proportion to the time since `start` does not count, because growing loads do the same.
   function what_moves(model, start, end) result(text)
      type(model_type), intent(in) :: model
      real(wp), intent(in) :: start, end
      character(:), allocatable :: text
      type(jet_type) :: jet
      real(wp) :: values(0:looks)
      integer :: i, k, n
      text = ''
      do i = 1, size(model%drivers)
         do n = 0, looks
            jet = driven_motion(model%drivers(i), start + (end - start)*n/looks)
            values(n) = jet%value
         end do
         if (maxval(values) - minval(values) <= none*maxval(abs(values))) cycle
         text = "driver '"//model%drivers(i)%name//"' moves the scene"
         return
      end do
      do i = 1, size(model%joints)
         if (.not. model%joints(i)%has_law) cycle
         if (law_moves(model%joints(i)%law, start, end, .false.)) text = "coupler '"//model%joints(i)%name//"' moves the scene"
         if (text /= '') return
      end do
      do i = 1, size(model%loads)
         associate (load => model%loads(i))
            do k = load%first, load%last
               if (.not. model%load_parts(k)%driven) cycle
               if (law_moves(model%load_parts(k)%law, start, end, .true.)) text = load%name
            end do
         end associate
         if (text == '') cycle
         text = "load '"//text//"' changes"
         return
      end do
   end function what_moves

   !> Whether a law of time alone changes between two times. A load that changes in proportion to the elapsed time does not count.
   pure logical function law_moves(law, start, end, of_load) result(moves)
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: start, end
      logical, intent(in) :: of_load
      real(wp) :: values(0:looks), parts(0:looks), t
      integer :: n
      moves = .false.
      if (size(law%slots) /= 1) return
      if (law%slots(1)%argument /= '' .or. law%slots(1)%name /= 't') return
      do n = 0, looks
         parts(n) = real(n, wp)/looks
         t = start + (end - start)*parts(n)
         values(n) = law%evaluate([t])
      end do
      moves = maxval(values) - minval(values) > none*maxval(abs(values))
      if (moves .and. of_load) moves = maxval(abs(values - parts*values(looks))) > none*maxval(abs(values))
   end function law_moves

end module limber_model_ramps
