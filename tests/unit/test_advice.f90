!> The parts of an advice: deflections that follow forces, against closed forms; rungs in a deck, of which given options stay;
!> what is chosen for scenes of which it is known.
program test_advice
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_accuracy_advice, only: advice_type, make_advice, expected_error, cost_of, rest_beyond, begin_bending
   use limber_commands_advise, only: read_whole_deck
   use limber_accuracy_fixed_options, only: free_options
   use limber_accuracy_pilot_run, only: forecast_type
   use limber_accuracy_fidelity_levels, only: level_type, find_rungs, apply_rung, richer, poorer, verifying, can_climb, rung_name, &
      & functions_of, strains_of, level_kg
   use limber_accuracy_modal_response, only: follow_forces, follow_first, vibration_modes, frequency_shifts
   use limber_deck_content, only: deck_type
   use testing, only: check, check_close, check_no_error, finish
   use limber_deck_parameters, only: override_type
   implicit none

   !> No value of a parameter in place of the deck's
   type(override_type) :: none(0)

   call test_following()
   call test_first()
   call test_shifts()
   call test_rungs()
   call test_given()
   call test_rests()
   call test_choices()
   call test_beginning()
   call finish()

contains

   !> A search begins with the tolerance that is expected to be needed, eq. (7.85), but with no less than the target. Deflections of
   !> w/L = 1e-6 that make all of a channel ask for 0.3*1e-3*1e-6/3e-3 = 1e-7, those of 0.1 for 5*0.3*1e-3.
   subroutine test_beginning()
      type(advice_type) :: advice
      advice%target = 1.0e-3_wp
      allocate (advice%rungs(1), advice%probe%beams(1))
      advice%tolerance = 3.0e-5_wp
      advice%rungs%step = 0
      advice%probe%beams(1)%effect = 1.0_wp
      advice%probe%beams(1)%deflection = 1.0e-6_wp
      call begin_bending(advice)
      call check_close(advice%tolerance, 3.0e-5_wp, 1.0e-18_wp, 'a rigid beam: as it was')
      call check(advice%integrator == '', 'and the integrator of AUTO')
      advice%rungs%step = 1
      call begin_bending(advice)
      call check_close(advice%tolerance, 1.0e-3_wp, 1.0e-16_wp, 'a stiff beam that bends: the target')
      call check(advice%integrator == 'RADAU', 'by RADAU')
      advice%probe%beams(1)%deflection = 0.1_wp
      call begin_bending(advice)
      call check_close(advice%tolerance, 1.5e-3_wp, 1.0e-16_wp, 'a soft one: what is expected')
      advice%target = 1.0e-1_wp
      call begin_bending(advice)
      call check_close(advice%tolerance, 1.0e-2_wp, 1.0e-16_wp, 'no more than 1e-2')
      advice%open_tolerance = .false.
      advice%tolerance = 1.0e-8_wp
      call begin_bending(advice)
      call check_close(advice%tolerance, 1.0e-8_wp, 1.0e-20_wp, 'what the deck gives stays')
   end subroutine test_beginning

   !> Bending and stretch with the masses [1 c; c 1] and the stiffness 4 and 10^4: with the stretch held w = 2, and with it free
   !> (1 - c^2) w^4 - (4 + 10^4) w^2 + 4 10^4 = 0. A third coordinate, without mobility, changes nothing.
   subroutine test_shifts()
      real(wp), parameter :: c = 0.6_wp, left = 1 - c**2, soft = 4.0_wp, stiff = 1.0e4_wp
      real(wp) :: mobility(3, 3), shifts(3), square
      mobility = 0.0_wp
      mobility(:2, :2) = reshape([1.0_wp, -c, -c, 1.0_wp], [2, 2])/left
      call frequency_shifts(mobility, [soft, stiff, 1.0_wp], [.true., .false., .false.], [.false., .true., .false.], shifts)
      square = 2*soft*stiff/(soft + stiff + sqrt((soft + stiff)**2 - 4*left*soft*stiff))
      call check_close(shifts(1), 2 - sqrt(square), 1.0e-10_wp, 'frequency that a soft support takes')
      call check_close(shifts(2), 0.0_wp, 1.0e-10_wp, 'coordinates that do not bend')
      call frequency_shifts(mobility, [soft, stiff, 1.0_wp], [.true., .false., .false.], [.false., .false., .true.], shifts)
      call check_close(shifts(1), 0.0_wp, 1.0e-9_wp, 'nothing follows')
   end subroutine test_shifts

   !> Two coupled coordinates under a ramp: each mode of the scene follows it exactly.
   subroutine test_following()
      integer, parameter :: samples = 40
      real(wp) :: mobility(2, 2), stiffness(2), square(2), vectors(2, 2), times(samples), forces(2, samples), eta(2, samples)
      real(wp) :: speed(2), swing(2), largest
      real(wp) :: mode(2, 2), lambda(2), t, x, part
      logical :: done
      integer :: i, k
      ! A K with A = [2 1; 1 2] and K = [4 4] has the squared frequencies 4 and 12, and the modes (1, -1) and (1, 1)
      mobility = reshape([2.0_wp, 1.0_wp, 1.0_wp, 2.0_wp], [2, 2])
      stiffness = 4.0_wp
      call vibration_modes(mobility, stiffness, square, vectors, done)
      call check(done, 'modes of the scene')
      call check_close(square(1), 4.0_wp, 1.0e-13_wp, 'first squared frequency')
      call check_close(square(2), 12.0_wp, 1.0e-13_wp, 'second squared frequency')
      mode = reshape([1.0_wp, -1.0_wp, 1.0_wp, 1.0_wp], [2, 2])
      lambda = [4.0_wp, 12.0_wp]
      times = [(0.3_wp*(k - 1), k=1, samples)]
      forces(1, :) = times
      forces(2, :) = 0.0_wp
      call follow_forces(times, forces, stiffness, square, vectors, eta, speed, swing=swing)
      do k = 1, samples
         t = times(k)
         do i = 1, 2
            ! Modal equation x'' = lambda (s t - x) with the static part s of the mode, from rest
            part = 0.5_wp/4.0_wp
            x = part*(t - sin(sqrt(lambda(i))*t)/sqrt(lambda(i)))
            call check(abs(dot_product(mode(:, i), eta(:, k))/2 - x) < 1.0e-12_wp, 'a mode follows a ramp')
         end do
      end do
      largest = maxval(abs(0.125_wp*(2 - cos(2*times) - cos(sqrt(12.0_wp)*times))))
      call check_close(speed(1), largest, 1.0e-12_wp, 'largest speed of the first coordinate')
      largest = maxval(abs(0.125_wp*(cos(2*times) - cos(sqrt(12.0_wp)*times))))
      call check_close(speed(2), largest, 1.0e-12_wp, 'largest speed of the second coordinate')
      largest = maxval(abs(0.125_wp*(sin(2*times)/2 + sin(sqrt(12.0_wp)*times)/sqrt(12.0_wp))))
      call check_close(swing(1), largest, 1.0e-12_wp, 'what vibrates of the first coordinate')
      ! Constant forces: vibrations about the rest, none if it begins there
      forces = 1.0_wp
      call follow_forces(times, forces, stiffness, square, vectors, eta, speed, swing=swing)
      call check_close(swing(1), 0.25_wp, 1.0e-12_wp, 'a sudden force makes it vibrate by what it makes at rest')
      call follow_forces(times, forces, stiffness, square, vectors, eta, speed, .true., swing)
      call check(all(swing < 1.0e-14_wp) .and. all(abs(eta - 0.25_wp) < 1.0e-14_wp), 'nothing vibrates that begins in balance')
   end subroutine test_following

   !> The first coordinate: a stiffness that the axial force doubles.
   subroutine test_first()
      integer, parameter :: samples = 400
      real(wp) :: times(samples), force(samples), extra(samples), softening(samples), largest, difference
      integer :: k
      times = [(0.05_wp*(k - 1), k=1, samples)]
      force = 1.0_wp
      extra = 0.0_wp
      softening = 0.0_wp
      call follow_first(times, force, 4.0_wp, extra, softening, largest, difference)
      call check_close(largest, 0.5_wp, 1.0e-3_wp, 'a suddenly applied force makes twice the deflection at rest')
      call check(difference < 1.0e-12_wp, 'no axial force, no difference')
      extra = 4.0_wp
      call follow_first(times, force, 4.0_wp, extra, softening, largest, difference)
      call check_close(largest, 0.25_wp, 1.0e-3_wp, 'twice the stiffness, half the deflection')
      ! Rotation above the first frequency lets the linear beam diverge, not the stiffened one
      softening = 5.0_wp
      call follow_first(times, force, 4.0_wp, extra, softening, largest, difference)
      call check(largest < 1.0_wp .and. difference > 10*largest, 'a linear beam diverges')
   end subroutine test_first

   !> Rungs in the deck.
   subroutine test_rungs()
      type(deck_type) :: deck
      type(level_type), allocatable :: rungs(:)
      type(level_type) :: rung, higher
      type(error_type), allocatable :: error
      integer :: climbs
      call read_whole_deck('accuracy/slider_crank.inp', none, deck, error)
      call check_no_error(error, 'deck with everything open')
      call find_rungs(deck, rungs)
      call check(size(rungs) == 1, 'one open beam')
      rung = rungs(1)
      call check(rung%open_level .and. rung%open_functions .and. rung%open_strains, 'what is open')
      rung = richer(rung, 3, .true.)
      call apply_rung(rung, deck)
      associate (block => deck%blocks(rung%block))
         call check(block%word('GEOMETRIC') == 'EXACT' .and. block%integer('FUNCTIONS') == 5, 'a rung in the deck')
         call check(block%integer('STRAIN FUNCTIONS') == 2 .and. block%given('STRAIN FUNCTIONS'), 'and its strain, as given')
      end associate
      call check(rung_name(rung) == 'EXACT 5 + 2', 'name of a rung: '//rung_name(rung))
      deallocate (rungs)
      call find_rungs(deck, rungs)
      call check(size(rungs) == 0, 'what is written out is no longer open')
      call free_options(deck)
      deallocate (rungs)
      call find_rungs(deck, rungs)
      call check(size(rungs) == 1, 'unless all is to be free')
      ! The whole ladder: each rung costs more; and it ends below the last, which verifies
      rung = rungs(1)
      rung%step = 0
      climbs = 0
      do while (can_climb(rung) .and. climbs < 100)
         higher = richer(rung, 1, rung%step > 5)
         call check(cost_of(higher) > cost_of(rung), rung_name(rung)//': the next costs more')
         call check(rung_name(poorer(higher)) == rung_name(rung) .or. higher%stretches, rung_name(higher)//': down again')
         call check(functions_of(verifying(higher, .true.)) > functions_of(higher), rung_name(higher)//': one above verifies')
         rung = higher
         climbs = climbs + 1
      end do
      call check(climbs > 5 .and. climbs < 30, 'the ladder ends')
   end subroutine test_rungs

   !> What the deck gives stays, and is no rung.
   subroutine test_given()
      type(level_type) :: rung
      rung = rung_of('EXACT', 'FUNCTIONS', 6)
      call check(.not. rung%open_functions .and. rung%open_strains .and. functions_of(rung) == 6, 'functions are given')
      rung = richer(rung, 2, .true.)
      call check(functions_of(rung) == 6 .and. strains_of(rung) > 0, 'the strain alone climbs: '//rung_name(rung))
      rung = rung_of('EXACT', 'STRAIN FUNCTIONS', 0)
      call check(rung%open_functions .and. .not. rung%open_level, 'the model is given')
      call check(strains_of(richer(rung, 2, .true.)) == 0, 'strain is given')
      rung = rung_of('K_G', '', 0)
      call check(rung%level == level_kg .and. rung%open_functions .and. .not. rung%open_strains, 'modes of K_G are open')
      call check(rung_name(richer(rung, 1, .false.)) == 'K_G 2 + 1', 'its rungs: '//rung_name(richer(rung, 1, .false.)))
      rung = rung_of('', 'CURVATURE', 1)
      call check(rung_name(poorer(rung)) /= 'RIGID', 'an arc is never rigid')
   end subroutine test_given

   !> The only beam of the slider-crank with an option more, and a model.
   type(level_type) function rung_of(model, option, value)
      !> Blank: not given
      character(*), intent(in) :: model, option
      integer, intent(in) :: value
      type(level_type), allocatable :: rungs(:)
      type(deck_type) :: deck
      type(error_type), allocatable :: error
      call read_whole_deck('accuracy/slider_crank.inp', none, deck, error)
      call check_no_error(error, 'deck')
      if (model /= '') call deck%set_option(deck%find('BEAM'), 'GEOMETRIC', model, given=.true.)
      if (option /= '') call deck%set_number(deck%find('BEAM'), option, real(value, wp), given=.true.)
      call find_rungs(deck, rungs)
      call check(size(rungs) == 1, model//option//': open in part')
      rung_of = rungs(1)
   end function rung_of

   !> What the finer of two runs errs, as a part of their difference, by parts c/n^4 of the bending coordinates.
   subroutine test_rests()
      type(level_type) :: rung, higher
      type(forecast_type) :: beam
      integer :: k
      beam%part = [(1/real(k, wp)**4, k=1, 6)]
      rung%open_functions = .true.
      rung%step = 5
      higher = richer(rung, 1, .false.)
      associate (low => expected_error(rung, beam), high => expected_error(higher, beam))
         call check_close(rest_beyond(rung, higher, beam), high/(low - high), 1.0e-12_wp, 'the difference is the rest of both')
      end associate
      call check_close(rest_beyond(rung, richer(rung, 4, .false.), beam), 0.1_wp, 1.0e-12_wp, 'at least a tenth')
      call check(rest_beyond(rung, rung, beam) > 0.9_wp, 'no higher rung tells nothing')
   end subroutine test_rests

   !> What is chosen: the right kind.
   subroutine test_choices()
      call check_choice('slider_crank_stiff', 1.0e-3_wp, 0, 0, 'a stiff slow rod is rigid')
      call check_choice('slider_crank', 1.0e-2_wp, 1, 3, 'the rod of the paper for two digits')
      call check_choice('slider_crank', 1.0e-3_wp, 2, 5, 'the rod of the paper for three digits')
      call check_choice('spin_up', 1.0e-2_wp, 1, 5, 'a beam that rotates above its first frequency')
      call check_choice('squeezer', 1.0e-3_wp, -1, -1, 'nothing is added to rigid bodies')
   end subroutine test_choices

   subroutine check_choice(name, target, least, most, what)
      character(*), intent(in) :: name, what
      real(wp), intent(in) :: target
      !> Functions of the angle within which the choice is to be; -1: no beam
      integer, intent(in) :: least, most
      type(deck_type) :: deck
      type(advice_type) :: advice
      type(error_type), allocatable :: error
      call read_whole_deck('accuracy/'//name//'.inp', none, deck, error)
      call check_no_error(error, name)
      call make_advice(deck, target, advice, error)
      call check_no_error(error, name)
      call check(size(advice%rungs) == merge(0, 1, least < 0), what//': number of beams')
      if (size(advice%rungs) == 0) return
      associate (rung => advice%rungs(1))
         call check(functions_of(rung) >= least .and. functions_of(rung) <= most, what//': '//rung_name(rung))
         call check_close(expected_error(rung, advice%probe%beams(1)), advice%expected(1), 1.0e-12_wp, what//': expected error')
         call check(advice%expected(1) <= target, what//': within the target')
      end associate
      if (name == 'slider_crank') then
         call check(abs(advice%probe%beams(1)%deflection - 0.0155_wp) < 0.002_wp, 'deflection that the probe expects')
         call check(abs(advice%probe%beams(1)%slope - 0.049_wp) < 0.006_wp, 'slope that the probe expects')
      else if (name == 'spin_up') then
         call check(abs(advice%probe%beams(1)%deflection - 0.0574_wp) < 0.006_wp, 'deflection of a stiffened beam')
         call check(advice%probe%beams(1)%rotation > 1.0_wp, 'rotation relative to the first frequency')
      end if
   end subroutine check_choice

end program test_advice
