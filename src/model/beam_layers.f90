!> Decay lengths of the bending of taut beams. Floor: model. Source: doc/theory, part 2, eq. (2.35).
module limber_model_beam_layers
   use limber_base_kinds, only: wp
   use limber_deck_content, only: deck_type, block_type
   use limber_deck_expression, only: expression_type
   use limber_deck_operations, only: jet_type
   use limber_beam_beam_mesh, only: beam_type
   implicit none
   private
   public :: layer_lengths

   !> Smallest tension that needs extra functions for boundary layers [E I/L^2]
   real(wp), parameter :: least_tension = 500.0_wp
   !> Ratio of the lengths of neighbouring layers: functions of both together cover the tensions between them
   real(wp), parameter :: ratio = 4.0_wp
   !> Largest number of layers, reached by ropes
   integer, parameter :: most = 8
   !> Number of instants at which laws of time are sampled
   integer, parameter :: instants = 50

contains

   !> Lengths of the boundary layers of a beam or piece, ascending [length]; empty if the tension is small.
   pure function layer_lengths(deck, block, beam) result(lengths)
      type(deck_type), intent(in) :: deck
      !> Block of the beam
      type(block_type), intent(in) :: block
      !> The beam, or the piece
      type(beam_type), intent(in) :: beam
      real(wp), allocatable :: lengths(:)
      real(wp) :: layer, tension
      allocate (lengths(0))
      tension = tension_of(deck, block, beam)
      if (.not. (beam%ei > 0.0_wp .and. tension*beam%length**2 > least_tension*beam%ei)) return
      layer = sqrt(beam%ei/tension)
      do while (least_tension*layer**2 < beam%length**2 .and. size(lengths) < most)
         lengths = [lengths, layer]
         layer = ratio*layer
      end do
   end function layer_lengths

   !> Largest tension expected from the deck: TENSION, or the sum of the contributions below [force].
   pure real(wp) function tension_of(deck, block, beam) result(tension)
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      type(beam_type), intent(in) :: beam
      real(wp) :: mass, moment
      if (block%given('TENSION')) then
         tension = max(block%real('TENSION'), 0.0_wp)
         return
      end if
      mass = beam%rho_a*block%real('LENGTH')
      moment = 0.5_wp*mass*block%real('LENGTH')
      if (allocated(beam%mass)) then
         mass = mass + sum(beam%mass)
         moment = moment + sum(beam%mass*beam%place)
      end if
      tension = max(block%real('PRETENSION'), 0.0_wp) + by_rotation(deck, block, mass, moment) + by_weight(deck, mass) &
         & + by_forces(deck, block)
   end function tension_of

   !> Tension by rotation: the fastest *STATICS with ROTATION, the initial spin, or a driver of the beam's angle.
   pure real(wp) function by_rotation(deck, block, mass, moment) result(tension)
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      !> Mass, and its first moment about the start
      real(wp), intent(in) :: mass, moment
      real(wp) :: radius, last, rate
      integer :: i, k
      tension = block%real('SPIN')**2*moment
      last = end_of(deck)
      associate (axis => [cos(block%real('ANGLE')), sin(block%real('ANGLE'))])
         do i = 1, size(deck%blocks)
            associate (own => deck%blocks(i))
               select case (own%keyword)
               case ('STATICS')
                  radius = dot_product(axis, [block%real('X') - own%real('CENTRE X'), block%real('Y') - own%real('CENTRE Y')])
                  tension = max(tension, own%real('ROTATION')**2*(mass*radius + moment))
               case ('DRIVER')
                  if (.not. own%has('BODY') .or. size(own%lines) /= 1) cycle
                  if (own%name('BODY') /= block%name() .or. own%word('LEVEL') /= 'POSITION') cycle
                  do k = 1, instants
                     rate = law_at(own%lines(1)%fields(1)%expression, last*k/instants, 1)
                     if (abs(rate) < sqrt(huge(rate))) tension = max(tension, rate**2*moment)
                  end do
               end select
            end associate
         end do
      end associate
   end function by_rotation

   !> Tension by the weight, for any direction of it: most clamped beams under axial weight hang.
   pure real(wp) function by_weight(deck, mass) result(tension)
      type(deck_type), intent(in) :: deck
      real(wp), intent(in) :: mass
      integer :: i
      tension = 0.0_wp
      do i = 1, size(deck%blocks)
         if (deck%blocks(i)%keyword == 'GRAVITY') tension = tension + mass*norm2([deck%blocks(i)%real('X'), &
            & deck%blocks(i)%real('Y')])
      end do
   end function by_weight

   !> Tension by forces on the end that depend on time alone; the component along the initial axis counts.
   pure real(wp) function by_forces(deck, block) result(tension)
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      real(wp) :: axis(2), pull(instants), last
      integer :: i, k
      pull = 0.0_wp
      last = end_of(deck)
      do i = 1, size(deck%blocks)
         if (deck%blocks(i)%keyword /= 'FORCE') cycle
         associate (own => deck%blocks(i))
            if (own%text('POINT') /= block%name()//'.end' .or. size(own%lines) /= 1) cycle
            if (.not. (of_time(own%lines(1)%fields(1)%expression) .and. of_time(own%lines(1)%fields(2)%expression))) cycle
            axis = [cos(block%real('ANGLE')), sin(block%real('ANGLE'))]
            if (own%yes('FOLLOWER')) axis = [1.0_wp, 0.0_wp]
            do k = 1, instants
               pull(k) = pull(k) + dot_product(axis, [law_at(own%lines(1)%fields(1)%expression, last*k/instants, 0), &
                  & law_at(own%lines(1)%fields(2)%expression, last*k/instants, 0)])
            end do
         end associate
      end do
      tension = max(0.0_wp, maxval(pull, pull < huge(1.0_wp)))
   end function by_forces

   !> A law, or its rate, at time t.
   pure real(wp) function law_at(law, t, order) result(value)
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: t
      !> 0: the law; 1: its rate
      integer, intent(in) :: order
      type(jet_type) :: jet
      jet = law%evaluate_jet(t)
      value = merge(jet%first, jet%value, order == 1)
   end function law_at

   !> Whether a law depends on time alone: each of its variables has no argument.
   pure logical function of_time(law)
      type(expression_type), intent(in) :: law
      integer :: i
      of_time = .true.
      do i = 1, size(law%slots)
         of_time = of_time .and. len(law%slots(i)%argument) == 0
      end do
   end function of_time

   !> Last time of the analyses, at least 1: in this time loads grow.
   pure real(wp) function end_of(deck) result(t)
      type(deck_type), intent(in) :: deck
      integer :: i
      t = 1.0_wp
      do i = 1, size(deck%blocks)
         if (deck%blocks(i)%keyword == 'DYNAMICS') t = max(t, deck%blocks(i)%real('END'))
      end do
   end function end_of

end module limber_model_beam_layers
