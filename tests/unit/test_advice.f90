!> The parts of an advice: deflections that follow forces, against closed forms; rungs in a deck, of which given options stay;
!> what is chosen for scenes of which it is known.
program test_advice
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_analysis_advice, only: advice_type, make_advice, apply_advice, expected_error, floor_of, cost_of
   use limber_analysis_advise, only: read_whole_deck
   use limber_analysis_fixed, only: free_options
   use limber_analysis_rungs, only: rung_type, find_rungs, apply_rung, next_rung, better_rung, can_climb, rung_name, &
      & lower_rungs, bound_rung, rest_beyond, most_lower, level_rigid, level_linear, level_kg, level_full
   use limber_analysis_scene, only: scene_type, build_scene
   use limber_analysis_shadow, only: follow_forces, follow_first, vibration_modes
   use limber_deck_content, only: deck_type
   use limber_deck_diagnostics, only: diagnostics_type
   use testing, only: check, check_close, check_no_error, finish
   use limber_deck_parameters, only: override_type
   implicit none

   !> No value of a parameter in place of the deck's
   type(override_type) :: none(0)

   call test_following()
   call test_first()
   call test_rungs()
   call test_lower()
   call test_rests()
   call test_choices()
   call test_divided()
   call test_loaded_end()
   call test_at_rest()
   call finish()

contains

   !> Two coupled coordinates under a ramp: each mode of the scene follows it exactly.
   subroutine test_following()
      integer, parameter :: samples = 40
      real(wp) :: mobility(2, 2), stiffness(2), square(2), vectors(2, 2), times(samples), forces(2, samples), eta(2, samples)
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
      call follow_forces(times, forces, stiffness, square, vectors, eta)
      do k = 1, samples
         t = times(k)
         do i = 1, 2
            ! Modal equation x'' = lambda (s t - x) with the static part s of the mode, from rest
            part = 0.5_wp/4.0_wp
            x = part*(t - sin(sqrt(lambda(i))*t)/sqrt(lambda(i)))
            call check(abs(dot_product(mode(:, i), eta(:, k))/2 - x) < 1.0e-12_wp, 'a mode follows a ramp')
         end do
      end do
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
      type(rung_type), allocatable :: rungs(:)
      type(rung_type) :: rung, higher
      type(error_type), allocatable :: error
      integer :: climbs
      call read_whole_deck('accuracy/slider_crank.inp', none, deck, error)
      call check_no_error(error, 'deck with everything open')
      call find_rungs(deck, rungs)
      call check(size(rungs) == 1, 'one open beam')
      rung = rungs(1)
      call check(rung%open_level .and. rung%open_modes .and. rung%pulled .and. .not. rung%free_end, 'what is open')
      rung%level = level_full
      rung%bending = 3
      rung%derivatives = 3
      rung%spun = .true.
      call apply_rung(rung, deck)
      associate (block => deck%blocks(rung%block))
         call check(block%word('GEOMETRIC') == 'FULL' .and. block%integer('BENDING MODES') == 3, 'a rung in the deck')
         call check(block%word('AXIAL BASIS') == 'STATIC' .and. block%integer('MODAL DERIVATIVES') == 3, 'its functions')
         call check(block%given('BENDING MODES'), 'modes count as given')
      end associate
      call check(rung_name(rung) == 'FULL 3 + 5', 'name of a rung: '//rung_name(rung))
      deallocate (rungs)
      call find_rungs(deck, rungs)
      call check(size(rungs) == 0, 'what is written out is no longer open')
      call free_options(deck)
      deallocate (rungs)
      call find_rungs(deck, rungs)
      call check(size(rungs) == 1, 'unless all is to be free')
      call check(.not. deck%blocks(rungs(1)%block)%has('BENDING MODES'), 'then nothing is left of it')
      ! The whole ladder: each rung costs more, but few pieces may cost less than very many modes; and it ends
      rung = rungs(1)
      rung%level = level_rigid
      climbs = 0
      do while (can_climb(rung) .and. climbs < 100)
         higher = next_rung(rung)
         if (higher%segments == rung%segments .or. rung%segments > 1) call check(cost_of(higher) > cost_of(rung), &
            & rung_name(rung)//': the next costs more')
         rung = better_rung(rung, .false.)
         climbs = climbs + 1
      end do
      call check(climbs > 3 .and. climbs < 30, 'the ladder ends')
      ! An option that the deck gives stays
      call read_whole_deck('../input/slider_crank_full.inp', none, deck, error)
      call check_no_error(error, 'deck with everything given')
      call find_rungs(deck, rungs)
      call check(size(rungs) == 0, 'nothing is open where the deck gives level and modes')
   end subroutine test_rungs

   !> Rungs below: each leaves out one thing more and costs less, and never what the deck gives.
   subroutine test_lower()
      type(rung_type) :: rung, lower(most_lower)
      integer :: i, count
      rung = open_rung()
      rung%bending = 5
      rung%derivatives = 6
      call lower_rungs(rung, lower, count)
      call check(count == 2, 'fewer modes, or less geometry')
      call check(rung_name(lower(1)) == 'FULL 4 + 8' .and. rung_name(lower(2)) == 'K_G 5 + 2', 'below FULL 5 + 8: '// &
         & rung_name(lower(1))//', '//rung_name(lower(2)))
      rung%derivatives = 12
      call lower_rungs(rung, lower, count)
      call check(rung_name(rung) == 'FULL 5 + 12' .and. count == 4, 'all that k_G elements allow: '//rung_name(rung))
      call check(rung_name(lower(1)) == 'FULL 5 + 8' .and. rung_name(lower(2)) == 'FULL 4 + 8' .and. &
         & rung_name(lower(3)) == 'FULL 4 + 12', 'below FULL 5 + 12, which cannot lock: '//rung_name(lower(1))//', '// &
         & rung_name(lower(2))//', '//rung_name(lower(3)))
      rung%segments = 4
      rung%bending = 2
      call lower_rungs(rung, lower, count)
      call check(count == 3, 'fewer modes, or fewer pieces with as many modes in all or more')
      call check(rung_name(lower(3)) == 'FULL 5 + 10, 2 pieces', 'more modes in two pieces: '//rung_name(lower(3)))
      call check(rung_name(lower(1)) == 'FULL 1 + 2, 4 pieces' .and. rung_name(lower(2)) == 'FULL 4 + 8, 2 pieces', &
         & 'below 4 pieces')
      do i = 1, count
         call check(cost_of(lower(i)) < cost_of(rung) .or. lower(i)%segments < 4, 'lower rungs cost less')
      end do
      rung%segments = 2
      call lower_rungs(rung, lower, count)
      call check(lower(count)%segments == 1 .and. lower(count)%bending == 3, 'below two pieces one frame')
      rung%open_modes = .false.
      rung%open_segments = .false.
      call lower_rungs(rung, lower, count)
      call check(count == 0, 'what the deck gives stays')
      rung = open_rung()
      rung%bending = 2
      call bound_rung(rung, level_kg, 3)
      call check(rung_name(rung) == 'K_G 2 + 2', 'a bound on the level alone: '//rung_name(rung))
      call bound_rung(rung, level_full, 1)
      call check(rung_name(rung) == 'K_G 1 + 1', 'a bound never raises: '//rung_name(rung))
      rung = open_rung()
      rung%bending = 2
      rung%segments = 4
      call bound_rung(rung, level_full, 3)
      call check(rung_name(rung) == 'FULL 3 + 5', 'modes of pieces are not those of a beam: '//rung_name(rung))
   end subroutine test_lower

   !> What the finer of two runs errs, as a part of their difference: of errors c/n^3 that is what is left of the geometric rest.
   subroutine test_rests()
      type(rung_type) :: rung, higher
      rung = open_rung()
      rung%bending = 4
      higher = rung
      higher%bending = 8
      call check_close(rest_beyond(rung, higher), 1.0_wp/7, 1.0e-12_wp, 'twice the modes: c/8^3 of c/4^3 - c/8^3')
      higher%bending = 5
      call check_close(rest_beyond(rung, higher), 64.0_wp/61, 1.0e-12_wp, 'one mode more: the difference tells less than half')
      higher = rung
      rung%level = level_kg
      call check_close(rest_beyond(rung, higher), 0.25_wp, 1.0e-12_wp, 'the next order of the geometry')
   end subroutine test_rests

   !> A beam whose fidelity is wholly open, as FULL.
   type(rung_type) function open_rung()
      open_rung%level = level_full
      open_rung%derivatives = 3
      open_rung%pulled = .true.
      open_rung%spun = .true.
      open_rung%open_level = .true.
      open_rung%open_modes = .true.
      open_rung%open_segments = .true.
   end function open_rung

   !> Pieces: enough of them for the slopes, with modes and axial functions for the rest, and RADAU for their fast axial vibrations.
   subroutine test_divided()
      type(deck_type) :: deck
      type(advice_type) :: advice
      type(scene_type) :: scene
      type(diagnostics_type) :: diagnostics
      type(error_type), allocatable :: error
      call read_whole_deck('accuracy/spin_up.inp', none, deck, error)
      call check_no_error(error, 'spin-up')
      call make_advice(deck, 1.0e-4_wp, advice, error)
      call check_no_error(error, 'spin-up')
      call check(advice%rungs(1)%segments >= 4, 'slopes of 0.08 for four digits: '//rung_name(advice%rungs(1)))
      call check(advice%expected(1) <= advice%share, 'within the share')
      call check(floor_of(advice%rungs(1), advice%probe%beams(1)) < 1.0e-4_wp, 'and so is what pieces leave out')
      scene%deck = deck
      advice%tolerance = 1.5e-5_wp
      call apply_advice(advice, scene%deck)
      associate (rung => advice%rungs(1), block => scene%deck%blocks(advice%rungs(1)%block))
         call check(block%integer('SEGMENTS') == rung%segments, 'pieces in the deck')
         call check(block%integer('BENDING MODES') == rung%bending, 'modes of each in the deck')
         call check(block%integer('GEOMETRIC ELEMENTS') == 2*rung%bending, 'two axial functions for each mode')
      end associate
      call build_scene(scene, diagnostics, error)
      call check_no_error(error, 'the divided beam')
      call check(scene%system%model%dynamics%integrator == 'RADAU', 'short pieces do not make the motion fast: '// &
         & scene%system%model%dynamics%integrator)
   end subroutine test_divided

   !> Clamped-free modes carry no load at the free end: where a joint is, shapes of the end come with them.
   subroutine test_loaded_end()
      type(deck_type) :: deck
      type(advice_type) :: advice
      type(error_type), allocatable :: error
      call read_whole_deck('accuracy/two_link_arm.inp', none, deck, error)
      call check_no_error(error, 'arm')
      call make_advice(deck, 1.0e-2_wp, advice, error)
      call check_no_error(error, 'arm')
      call check(all(advice%rungs%shaped), 'both arms carry something at their ends')
      call apply_advice(advice, deck)
      call check(deck%blocks(advice%rungs(1)%block)%yes('END SHAPES'), 'the shapes in the deck')
      call read_whole_deck('accuracy/spin_up.inp', none, deck, error)
      call make_advice(deck, 1.0e-2_wp, advice, error)
      call check(.not. advice%rungs(1)%shaped, 'a free end needs none')
   end subroutine test_loaded_end

   !> What is chosen: the right kind.
   subroutine test_choices()
      call check_choice('slider_crank_stiff', 1.0e-3_wp, level_rigid, level_rigid, 'a stiff slow rod is rigid')
      call check_choice('slider_crank_slow', 1.0e-2_wp, level_linear, level_linear, 'a slow rod is linear')
      call check_choice('slider_crank', 1.0e-2_wp, level_kg, level_full, 'the rod of the paper needs its axial force')
      call check_choice('slider_crank', 1.0e-3_wp, level_full, level_full, 'the rod of the paper for three digits')
      call check_choice('spin_up', 1.0e-2_wp, level_full, level_full, 'a beam that rotates above its first frequency')
      call check_choice('squeezer', 1.0e-3_wp, -1, -1, 'nothing is added to rigid bodies')
   end subroutine test_choices

   subroutine check_choice(name, target, least, most, what)
      character(*), intent(in) :: name, what
      real(wp), intent(in) :: target
      !> Levels within which the choice is to be; -1: no beam
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
         call check(rung%level >= least .and. rung%level <= most, what//': '//rung_name(rung))
         call check_close(expected_error(rung, advice%probe%beams(1), advice%probe%duration), advice%expected(1), 1.0e-12_wp, &
            & what//': expected error')
         call check(advice%expected(1) <= advice%share, what//': within its share')
      end associate
      if (name == 'slider_crank') then
         call check(abs(advice%probe%beams(1)%deflection - 0.0155_wp) < 0.002_wp, 'deflection that the probe expects')
         call check(abs(advice%probe%beams(1)%slope - 0.049_wp) < 0.006_wp, 'slope that the probe expects')
      else if (name == 'spin_up') then
         call check(abs(advice%probe%beams(1)%deflection - 0.0574_wp) < 0.006_wp, 'deflection of a stiffened beam')
         call check(advice%probe%beams(1)%rotation > 1.0_wp, 'rotation relative to the first frequency')
      end if
   end subroutine check_choice

   !> Axial coordinates at rest: with ADAMS, where the error that they make is within a third of the target; the rung above has
   !> them.
   subroutine test_at_rest()
      call check_axial('spin_up', 'ADAMS', 1.0e-2_wp, .true., 'a smooth spin-up')
      call check_axial('spin_up', 'RADAU', 1.0e-2_wp, .false., 'with RADAU nothing is gained')
      call check_axial('slider_crank', 'ADAMS', 1.0e-2_wp, .false., 'a rod that errs by more than a third of the target')
      call check_axial('slider_crank', 'ADAMS', 3.0e-2_wp, .true., 'a rod that errs by less')
   end subroutine test_at_rest

   subroutine check_axial(name, integrator, target, at_rest, what)
      character(*), intent(in) :: name, integrator, what
      real(wp), intent(in) :: target
      logical, intent(in) :: at_rest
      type(deck_type) :: deck
      type(advice_type) :: advice
      type(rung_type) :: higher
      type(error_type), allocatable :: error
      call read_whole_deck('accuracy/'//name//'.inp', none, deck, error)
      call check_no_error(error, name)
      call deck%set_option(deck%find('DYNAMICS'), 'INTEGRATOR', integrator, given=.true.)
      call make_advice(deck, target, advice, error)
      call check_no_error(error, name)
      call check(advice%rungs(1)%at_rest .eqv. at_rest, what)
      call check(advice%expected(1) <= advice%share, what//': within its share')
      higher = next_rung(advice%rungs(1))
      call check(can_climb(advice%rungs(1)) .and. .not. higher%at_rest, what//': the rung above has axial vibrations')
      higher = better_rung(advice%rungs(1), .false.)
      call check(.not. higher%at_rest, what//': and so has the better one')
      call apply_rung(advice%rungs(1), deck)
      call check((deck%blocks(advice%rungs(1)%block)%word('AXIAL DYNAMICS') == 'STATIC') .eqv. at_rest, what//': in the deck')
      call check((index(rung_name(advice%rungs(1)), 'STATIC') > 0) .eqv. at_rest, what//': by name')
   end subroutine check_axial

end program test_advice
