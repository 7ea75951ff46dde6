!> Cheapest fidelity levels for a requested accuracy. Of each beam the cheapest rung whose expected error is within its share, and
!> the tolerance of the integration. The expectations come from a probe. Floor: accuracy. Equations: doc/theory, part 7.
module limber_accuracy_advice
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_accuracy_pilot_run, only: pilot_type, forecast_type, make_probe
   use limber_accuracy_fidelity_levels, only: level_type, find_rungs, apply_rung, functions_of, strains_of, richer, &
      & verifying, level_exact
   use limber_accuracy_search_thresholds, only: largest_tolerance
   use limber_deck_content, only: deck_type
   implicit none
   private
   public :: advice_type, make_advice, apply_advice, expected_error, expected_stretch, cost_of, check_rung, strained_rung, &
      & is_forced, rest_beyond, note_surprise, begin_bending

   !> What is advised
   type :: advice_type
      !> Error asked for, relative to the largest value of each channel
      real(wp) :: target = 0.0_wp
      !> Beams that limber chooses for, and what the probe found of them
      type(level_type), allocatable :: rungs(:)
      type(pilot_type) :: probe
      !> Expected error of each beam's model, and its share of the target
      real(wp), allocatable :: expected(:)
      real(wp) :: share = 0.0_wp
      !> How many times larger than expected the errors of the models have turned out: the probe moves beams without their speeds,
      !> and what it says of the stretch is not better than what it says of the bending, eq. (7.91)
      real(wp) :: surprise = 1.0_wp
      !> Tolerance, and whether it is limber's to choose; whether the integrator is
      real(wp) :: tolerance = 0.0_wp
      logical :: open_tolerance = .true., open_integrator = .true.
      !> RADAU if that has turned out better than what AUTO chooses, or blank
      character(5) :: integrator = ''
   end type advice_type

   !> Parts of the target that the models and the integration may have; the rest is for the doubt about the verification
   real(wp), parameter, public :: part_model = 0.65_wp, part_time = 0.3_wp
   !> Part of the target below which the expected error of a beam does not matter, and part below which all that its deflection does
   !> to the channels does not
   real(wp), parameter :: no_matter = 0.02_wp, no_effect = 0.2_wp
   !> Part of a beam's share of the target that the stretch must be expected to make
   real(wp), parameter :: of_stretch = 0.1_wp
   !> Highest rung that a search begins with: an expectation may be far too large
   integer, parameter :: first_highest = 6

contains

   !> Probes a deck and chooses.
   subroutine make_advice(deck, target, advice, error, unverified)
      type(deck_type), intent(in) :: deck
      !> Relative error that is aimed at
      real(wp), intent(in) :: target
      type(advice_type), intent(out) :: advice
      type(error_type), allocatable, intent(out) :: error
      !> Whether no run follows that verifies the choice: then it goes as high as its expectation asks
      logical, intent(in), optional :: unverified
      integer :: i, highest
      advice%target = target
      call find_rungs(deck, advice%rungs)
      call make_probe(deck, advice%rungs, advice%probe, error)
      if (allocated(error)) return
      allocate (advice%expected(size(advice%rungs)))
      associate (beams => advice%probe%beams)
         advice%share = part_model*target/max(1, count(beams%effect + beams%stretch + beams%ringing > no_effect*target))
         do i = 1, size(beams)
            highest = first_highest
            if (present(unverified)) highest = merge(advice%rungs(i)%highest, first_highest, unverified)
            call choose(target, advice%share, highest, beams(i), advice%rungs(i))
            advice%expected(i) = expected_error(advice%rungs(i), beams(i))
         end do
      end associate
      associate (block => deck%blocks(deck%find('DYNAMICS')))
         advice%open_tolerance = .not. block%given('TOLERANCE')
         advice%open_integrator = .not. block%given('INTEGRATOR')
         advice%tolerance = block%real('TOLERANCE')
         if (advice%open_tolerance) advice%tolerance = wanted_tolerance(advice)
      end associate
   end subroutine make_advice

   !> The cheapest rung of a beam whose expected error is within its share, or that of least error; what the stretch makes is known
   !> well enough to have nearly all of the target.
   pure subroutine choose(target, share, highest, beam, rung)
      real(wp), intent(in) :: target, share
      !> Highest rung that may be chosen
      integer, intent(in) :: highest
      type(forecast_type), intent(in) :: beam
      type(level_type), intent(inout) :: rung
      real(wp), parameter :: of_stretch = 0.9_wp
      type(level_type) :: other, best
      real(wp) :: least, error, stretch
      integer :: step, k
      logical :: enough, found
      best = rung
      found = .false.
      least = huge(least)
      do step = merge(rung%lowest, rung%step, rung%open_functions), merge(highest, rung%step, rung%open_functions)
         do k = 0, merge(1, 0, rung%open_strains .and. step > 0)
            other = rung
            other%step = step
            other%stretches = k == 1
            stretch = expected_stretch(other, beam)
            error = expected_error(other, beam)
            enough = error - stretch <= share .and. stretch <= of_stretch*target
            if (found .and. .not. enough) cycle
            if (found .eqv. enough) then
               if (merge(cost_of(other), error, enough) >= least) cycle
            end if
            best = other
            found = enough
            least = merge(cost_of(other), error, enough)
         end do
      end do
      rung = best
   end subroutine choose

   !> Expected error of a beam's model in the channels, relative to their largest values: eqs. (7.78), (7.79), (7.82).
   pure real(wp) function expected_error(rung, beam) result(error)
      type(level_type), intent(in) :: rung
      type(forecast_type), intent(in) :: beam
      integer :: n
      if (rung%step == 0) then
         ! What a tension holds straight is slack where that is gone
         error = max(beam%effect + beam%stretch + beam%ringing, &
            & min(1.0_wp, 0.25_wp*max(beam%slope, beam%slack_slope)**2))
         return
      end if
      n = functions_of(rung)
      if (.not. allocated(beam%part)) then
         error = 0.0_wp
      else if (n < size(beam%part)) then
         error = norm2(beam%part(n + 1:))
      else
         error = beam%part(size(beam%part))*(real(size(beam%part), wp)/n)**4
      end if
      error = error + expected_stretch(rung, beam)
      if (rung%level < level_exact) error = error + beam%effect*min(1.0_wp, 4*beam%slope**2)
   end function expected_error

   !> The part of it that functions of the strain would take away: what is left of vibrations along the beam only runs show.
   pure real(wp) function expected_stretch(rung, beam) result(error)
      type(level_type), intent(in) :: rung
      type(forecast_type), intent(in) :: beam
      error = 0.0_wp
      if (rung%step == 0) return
      error = whole_stretch(beam)
      if (strains_of(rung) > 0) then
         error = error*min(0.7_wp, 0.9_wp/strains_of(rung)**2)
      else
         error = error + beam%ringing
      end if
   end function expected_stretch

   !> What a beam that does not stretch leaves out: the stretch itself, and what a beam that is longer deflects more.
   pure real(wp) function whole_stretch(beam)
      type(forecast_type), intent(in) :: beam
      !> By how much a force that is there at once stretches more than one at rest
      real(wp), parameter :: sudden = 2.0_wp
      whole_stretch = sudden*(beam%stretch + beam%effect*beam%strain)
   end function whole_stretch

   !> What a rung costs in an evaluation, in units of a rigid body: counted operations, eq. (7.83).
   elemental real(wp) function cost_of(rung) result(cost)
      type(level_type), intent(in) :: rung
      real(wp) :: n
      n = functions_of(rung) + strains_of(rung)
      cost = 1.0_wp
      ! Axial vibrations are fast, and take more steps
      if (rung%step > 0) cost = 2.0_wp + 0.1_wp*n + 0.01_wp*n**2
      if (strains_of(rung) > 0) cost = 3*cost
   end function cost_of

   !> The rung of a beam in a run that is to verify another; the same if the beam is not to be verified.
   pure type(level_type) function check_rung(advice, i) result(check)
      type(advice_type), intent(in) :: advice
      integer, intent(in) :: i
      check = advice%rungs(i)
      if (matters(advice, i)) check = verifying(check, .false.)
   end function check_rung

   !> A beam with strain, if that is expected to matter, or may.
   pure type(level_type) function strained_rung(advice, i) result(check)
      type(advice_type), intent(in) :: advice
      integer, intent(in) :: i
      !> What an axial force in units of Euler's load makes of the bending by the stretch, which no channel of the rigid scene shows
      real(wp), parameter :: of_force = 4.0e-3_wp
      associate (beam => advice%probe%beams(i))
         check = advice%rungs(i)
         if (.not. matters(advice, i)) return
         check = richer(check, 0, advice%surprise*max(whole_stretch(beam), of_force*beam%force, beam%ringing) > &
            & of_stretch*advice%share/part_model .or. is_forced(advice, i) .or. advice%probe%blind)
      end associate
   end function strained_rung

   !> Whether forces or accelerations that channels ask for have so much of vibrations along a beam in them that no step may damp
   !> these.
   pure logical function rings_along(advice, i)
      type(advice_type), intent(in) :: advice
      integer, intent(in) :: i
      !> Part of the target
      real(wp), parameter :: much = 0.3_wp
      rings_along = advice%probe%beams(i)%ringing > much*advice%target
   end function rings_along

   !> Takes note of an error of the models that a verification has shown.
   pure subroutine note_surprise(advice, error)
      type(advice_type), intent(inout) :: advice
      !> Relative to the channels
      real(wp), intent(in) :: error
      real(wp), parameter :: most = 1.0e6_wp
      if (error < huge(error) .and. error > 0.0_wp) &
         & advice%surprise = max(advice%surprise, error/max(sum(advice%expected), error/most))
   end subroutine note_surprise

   !> Whether the axial force of a beam is so large that its axial vibrations matter to its bending, or channels show them.
   pure logical function is_forced(advice, i)
      type(advice_type), intent(in) :: advice
      integer, intent(in) :: i
      !> Axial force in units of Euler's load from which on they do
      real(wp), parameter :: forced = 0.3_wp
      is_forced = advice%probe%beams(i)%force > forced .or. rings_along(advice, i)
   end function is_forced

   !> Whether a beam is to be verified: always if it bends, for the probe moves it slowly and by loads that do not answer its
   !> motion;
   !> a rigid one if an error is expected.
   pure logical function matters(advice, i)
      type(advice_type), intent(in) :: advice
      integer, intent(in) :: i
      !> Part of the target from which on the expected error of a rigid beam counts, which nothing else shows
      real(wp), parameter :: of_rigid = 1.0e-3_wp
      matters = advice%rungs(i)%step > 0 .or. advice%surprise*advice%expected(i) >= of_rigid*advice%target
   end function matters

   !> Error of a higher rung as a part of the difference that it makes, as far as the probe tells: eq. (7.88).
   pure real(wp) function rest_beyond(rung, higher, beam) result(part)
      type(level_type), intent(in) :: rung, higher
      type(forecast_type), intent(in) :: beam
      real(wp), parameter :: least = 0.1_wp, most = 1.0_wp
      real(wp) :: low, high, common
      ! Stretch that both lack is verified by itself
      common = 0.0_wp
      if (strains_of(higher) == 0) common = expected_stretch(higher, beam)
      low = max(0.0_wp, expected_error(rung, beam) - common)
      high = max(0.0_wp, expected_error(higher, beam) - common)
      part = least
      if (low > 0.0_wp) part = max(least, min(most, high/max(low - high, 0.5_wp*high)))
   end function rest_beyond

   !> Integrator and tolerance that a search takes once beams bend: RADAU, for higher rungs have vibrations that bind ADAMS, and no
   !> less than the target, for a smaller tolerance costs little more once it is known to be needed.
   pure subroutine begin_bending(advice)
      type(advice_type), intent(inout) :: advice
      integer :: i
      if (.not. (advice%open_integrator .and. advice%open_tolerance .and. any(advice%rungs%step > 0))) return
      advice%integrator = 'RADAU'
      advice%tolerance = min(largest_tolerance, max(wanted_tolerance(advice), advice%target))
      do i = 1, size(advice%rungs)
         if (rings_along(advice, i)) advice%tolerance = wanted_tolerance(advice)
      end do
   end subroutine begin_bending

   !> Tolerance whose error of the integration is its part of the target: eq. (7.85).
   pure real(wp) function wanted_tolerance(advice) result(tolerance)
      type(advice_type), intent(in) :: advice
      !> The least where beams bend is a part of the target: what a probe expects of a stiff beam may be far too little
      real(wp), parameter :: smallest = 1.0e-12_wp, part_least = 1.0e-4_wp
      !> Error of the deflections by that of a step, relative to their scale; the same of rigid scenes
      real(wp), parameter :: of_deflections = 3.0e-3_wp, of_motion = 10.0_wp
      integer :: i
      if (advice%probe%blind) then
         ! A smaller one costs less once it is known to be needed
         tolerance = largest_tolerance
         return
      end if
      tolerance = part_time*advice%target/of_motion
      if (any(advice%rungs%step > 0)) tolerance = 5*part_time*advice%target
      do i = 1, size(advice%rungs)
         if (advice%rungs(i)%step == 0) cycle
         associate (beam => advice%probe%beams(i))
            if (beam%effect > no_matter*advice%target) tolerance = min(tolerance, part_time*advice%target &
               & *beam%deflection/(of_deflections*beam%effect))
            ! Steps over vibrations along it would damp them
            if (rings_along(advice, i)) tolerance = min(tolerance, part_time*advice%target &
               & *beam%ringing_size/(of_deflections*beam%ringing))
         end associate
      end do
      if (any(advice%rungs%step > 0)) tolerance = max(part_least*advice%target, tolerance)
      tolerance = max(smallest, min(largest_tolerance, tolerance))
   end function wanted_tolerance

   !> Writes the choices into a deck.
   subroutine apply_advice(advice, deck)
      type(advice_type), intent(in) :: advice
      type(deck_type), intent(inout) :: deck
      integer :: i
      do i = 1, size(advice%rungs)
         call apply_rung(advice%rungs(i), deck)
      end do
      if (advice%open_tolerance) call deck%set_number(deck%find('DYNAMICS'), 'TOLERANCE', advice%tolerance, given=.true.)
      if (advice%integrator /= '') call deck%set_option(deck%find('DYNAMICS'), 'INTEGRATOR', advice%integrator, given=.true.)
   end subroutine apply_advice

end module limber_accuracy_advice
