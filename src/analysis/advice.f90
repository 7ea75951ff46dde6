!> The choice of a model for a requested accuracy: of each beam the cheapest rung whose expected error is within its share, and the
!> tolerance of the integration. The expectations come from a probe and from formulas whose constants were measured.
!> Floor: analysis. Equations: doc/theory.md, accuracy on request.
module limber_analysis_advice
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_analysis_axial, only: axial_verdict_type, judge_axial
   use limber_analysis_probe, only: probe_type, prospect_type, make_probe
   use limber_analysis_rungs, only: rung_type, find_rungs, apply_rung, functions_of, enough_derivatives, &
      & level_rigid, level_linear, level_kg, level_full, most_modes, most_elements, most_segments, most_piece_modes, first_pieces, &
      & in_pieces
   use limber_analysis_scene, only: scene_type, build_scene
   use limber_analysis_shares, only: part_model, part_time, no_matter, no_effect
   use limber_deck_content, only: deck_type
   use limber_deck_diagnostics, only: diagnostics_type
   implicit none
   private
   public :: advice_type, make_advice, take_measured, find_floors, apply_advice, expected_error, cost_of, divide_beam, floor_of

   !> What is advised
   type :: advice_type
      !> Error asked for, relative to the largest value of each channel
      real(wp) :: target = 0.0_wp
      !> Beams that limber chooses for, and what the probe found of them
      type(rung_type), allocatable :: rungs(:)
      type(probe_type) :: probe
      !> Expected error of each beam's model, and its share of the target
      real(wp), allocatable :: expected(:)
      !> The part of it that no richer basis in one frame takes away, and no verification by one sees
      real(wp), allocatable :: floor(:)
      real(wp) :: share = 0.0_wp
      !> Tolerance, and whether it is limber's to choose; whether the integrator is
      real(wp) :: tolerance = 0.0_wp
      logical :: open_tolerance = .true., open_integrator = .true.
      !> RADAU if that has turned out better than what AUTO chooses, or blank
      character(5) :: integrator = ''
   end type advice_type

   !> Constants of eqs. (174) to (176), measured
   real(wp), parameter :: kg_static = 4.0_wp, kg_dynamic = 0.12_wp, full_floor = 50.0_wp, of_pieces = 15.0_wp
   !> Of the axial strain times the squared slope, measured on a pendulum of rubber with strains of 0.1
   real(wp), parameter :: of_strain = 20.0_wp
   !> Part of the elongation that one axial mode of a bar leaves out, 1 - 8/pi^2
   real(wp), parameter :: of_one_mode = 0.19_wp
   !> Slopes in the first of many pieces, in units of those of the whole beam by their number: between supports, with a free end
   real(wp), parameter :: piece_slope = 0.75_wp, free_piece_slope = 1.3_wp
   !> Ratio of errors that is worth a higher cost where no rung is good enough
   real(wp), parameter :: worth = 1.5_wp

contains

   !> Probes a deck and chooses.
   subroutine make_advice(deck, target, advice, error)
      type(deck_type), intent(in) :: deck
      !> Relative error that is aimed at
      real(wp), intent(in) :: target
      type(advice_type), intent(out) :: advice
      type(error_type), allocatable, intent(out) :: error
      integer :: i, matter
      advice%target = target
      call find_rungs(deck, advice%rungs)
      call make_probe(deck, advice%rungs, advice%probe, error)
      if (allocated(error)) return
      do i = 1, size(advice%rungs)
         if (advice%rungs(i)%open_segments) advice%rungs(i)%open_segments = divisible(deck, advice%rungs(i))
      end do
      allocate (advice%expected(size(advice%rungs)), advice%floor(size(advice%rungs)))
      advice%floor = 0.0_wp
      associate (beams => advice%probe%beams)
         matter = count(beams%effect + beams%stretch > no_effect*target)
         advice%share = part_model*target/max(1, matter)
         do i = 1, size(beams)
            call choose(advice, i)
         end do
      end associate
      associate (block => deck%blocks(deck%find('DYNAMICS')))
         advice%open_tolerance = .not. block%given('TOLERANCE')
         advice%open_integrator = .not. block%given('INTEGRATOR')
         advice%tolerance = block%real('TOLERANCE')
         if (advice%open_tolerance) advice%tolerance = wanted_tolerance(advice)
         ! The implicit integrators do not need it: there it costs as much as it saves
         if (block%given('INTEGRATOR') .and. block%word('INTEGRATOR') == 'ADAMS') call choose_axial(deck, advice)
      end associate
   end subroutine make_advice

   !> Lets axial coordinates follow at rest where they bind the steps of ADAMS, and where that is admissible for a third of the
   !> target and fits into the share: eq. (185).
   subroutine choose_axial(deck, advice)
      type(deck_type), intent(in) :: deck
      type(advice_type), intent(inout) :: advice
      !> Part of the target, and ratio of axial to bending frequencies from which they bind
      real(wp), parameter :: part = 1.0_wp/3, binding = 3.0_wp
      type(scene_type) :: scene
      type(diagnostics_type) :: diagnostics
      type(axial_verdict_type) :: verdict
      type(error_type), allocatable :: error
      integer :: i, body
      advice%rungs%at_rest = advice%rungs%open_axial .and. advice%rungs%segments == 1 .and. advice%rungs%level >= level_kg .and. &
         & advice%rungs%open_modes
      if (.not. any(advice%rungs%at_rest)) return
      scene%deck = deck
      call apply_advice(advice, scene%deck)
      call build_scene(scene, diagnostics, error)
      do i = 1, size(advice%rungs)
         if (.not. advice%rungs(i)%at_rest) cycle
         advice%rungs(i)%at_rest = .false.
         if (allocated(error)) cycle
         body = body_named(scene, deck%blocks(advice%rungs(i)%block)%name())
         if (body == 0) cycle
         associate (reduced => scene%system%model%bodies(body)%reduced)
            if (.not. reduced%condensed) cycle
            if (maxval(reduced%omega2(reduced%bending + 1:)) < binding**2*maxval(reduced%omega2(:reduced%bending))) cycle
         end associate
         call judge_axial(scene%system, scene%work, scene%q, scene%v, body, part*advice%target, verdict)
         if (.not. verdict%admissible .or. advice%expected(i) + verdict%error > advice%share) cycle
         advice%rungs(i)%at_rest = .true.
         advice%expected(i) = advice%expected(i) + verdict%error
      end do

   contains

      !> Index of a body; zero if there is none of this name.
      pure integer function body_named(scene, name) result(index)
         type(scene_type), intent(in) :: scene
         character(*), intent(in) :: name
         integer :: k
         index = 0
         do k = 1, size(scene%system%model%bodies)
            if (scene%system%model%bodies(k)%name == name) index = k
         end do
      end function body_named

   end subroutine choose_axial

   !> Puts what a run has measured of a beam in place of what the probe expected. A beam that bends far beyond what the probe
   !> foresaw does as much more to the channels; its error is taken for its share at least, so that it is verified: eq. (183).
   subroutine take_measured(advice, which, slope, deflection, at_rest)
      type(advice_type), intent(inout) :: advice
      integer, intent(in) :: which
      !> Largest slope, and deflection relative to the length; error that axial coordinates at rest make
      real(wp), intent(in) :: slope, deflection, at_rest
      !> Ratio of slopes beyond which the probe was misled, beyond which it knew nothing, and slope that is none
      real(wp), parameter :: misled = 2.0_wp, blind = 100.0_wp, nothing = 1.0e-6_wp
      logical :: surprise
      integer :: k
      associate (beam => advice%probe%beams(which))
         surprise = slope > nothing .and. slope > misled*beam%slope
         if (surprise) then
            if (slope > blind*beam%slope) then
               beam%effect = 1.0_wp
               beam%part = [(1/real(k, wp)**5, k=1, size(beam%part))]
            else
               beam%part = min(1.0_wp, slope/beam%slope*beam%part)
               beam%effect = min(1.0_wp, slope/beam%slope*beam%effect)
            end if
         end if
         beam%slope = slope
         beam%deflection = deflection
         advice%expected(which) = expected_error(advice%rungs(which), beam, advice%probe%duration) + at_rest
         if (surprise) advice%expected(which) = max(advice%expected(which), advice%share)
      end associate
   end subroutine take_measured

   !> Whether the deck can be built with a beam in pieces: a point that slides along it, say, wants it whole.
   logical function divisible(deck, rung)
      type(deck_type), intent(in) :: deck
      type(rung_type), intent(in) :: rung
      type(scene_type) :: scene
      type(rung_type) :: divided
      type(diagnostics_type) :: diagnostics
      type(error_type), allocatable :: error
      scene%deck = deck
      divided = in_pieces(rung, first_pieces, 1)
      call apply_rung(divided, scene%deck)
      call build_scene(scene, diagnostics, error)
      divisible = .not. allocated(error)
   end function divisible

   !> The cheapest rung of a beam whose expected error is within its share, or that of least error.
   subroutine choose(advice, which)
      type(advice_type), intent(inout) :: advice
      integer, intent(in) :: which
      type(rung_type) :: rung, best
      real(wp) :: least, error
      integer :: level, n
      associate (beam => advice%probe%beams(which), start => advice%rungs(which))
         best = start
         least = huge(least)
         advice%expected(which) = huge(least)
         do level = level_rigid, level_full
            if (.not. start%open_level .and. level /= start%level) cycle
            do n = 1, most_modes
               rung = start
               rung%level = level
               if (level == level_rigid .and. n > 1) exit
               if (rung%open_modes) then
                  rung%bending = n
                  rung%derivatives = enough_derivatives(n)
                  rung%spun = n > 1
               else if (n > 1) then
                  exit
               end if
               rung%stretched = beam%stretch > 0.1_wp*advice%share
               if (.not. start%given_elements) rung%elements = lumping_elements(rung, advice, beam)
               error = expected_error(rung, beam, advice%probe%duration)
               call consider()
            end do
         end do
         if (start%open_segments .and. .not. (start%level == level_rigid .and. .not. start%open_level)) then
            rung = divided_beam(advice, start, beam)
            error = expected_error(rung, beam, advice%probe%duration)
            call consider()
         end if
         start = best
      end associate

   contains

      !> Takes a rung if it is better than the best so far.
      subroutine consider()
         logical :: enough, had
         enough = error <= advice%share
         had = advice%expected(which) <= advice%share
         if (had .and. .not. enough) return
         if (enough .and. had) then
            if (cost_of(rung) >= least) return
         else if (.not. enough .and. worth*error >= advice%expected(which)) then
            return
         end if
         best = rung
         least = cost_of(rung)
         advice%expected(which) = error
      end subroutine consider

   end subroutine choose

   !> Divides a beam into the pieces that are expected to do for its share.
   subroutine divide_beam(advice, which)
      type(advice_type), intent(inout) :: advice
      integer, intent(in) :: which
      type(rung_type) :: divided
      divided = divided_beam(advice, advice%rungs(which), advice%probe%beams(which))
      advice%rungs(which) = divided
      advice%expected(which) = expected_error(divided, advice%probe%beams(which), advice%probe%duration)
   end subroutine divide_beam

   !> The cheapest pieces whose expected error is within the share, or those of least error.
   function divided_beam(advice, start, beam) result(best)
      type(advice_type), intent(in) :: advice
      type(rung_type), intent(in) :: start
      type(prospect_type), intent(in) :: beam
      type(rung_type) :: best, rung
      real(wp) :: error, least, cost
      logical :: better
      integer :: pieces, n
      least = huge(least)
      cost = huge(cost)
      pieces = first_pieces
      do while (pieces <= most_segments)
         do n = 1, most_piece_modes
            rung = in_pieces(start, pieces, n)
            if (.not. start%given_elements) rung%elements = lumping_elements(rung, advice, beam)
            error = expected_error(rung, beam, advice%probe%duration)
            if (least <= advice%share) then
               better = error <= advice%share .and. cost_of(rung) < cost
            else
               better = error <= advice%share .or. worth*error < least
            end if
            if (better) then
               best = rung
               least = error
               cost = cost_of(rung)
            end if
            if (.not. start%open_modes) exit
         end do
         pieces = 2*pieces
      end do
   end function divided_beam

   !> Expected error of a beam's model in the channels, relative to their largest values: eqs. (173) to (176).
   pure real(wp) function expected_error(rung, beam, duration) result(error)
      type(rung_type), intent(in) :: rung
      type(prospect_type), intent(in) :: beam
      !> Of the analysis [time]
      real(wp), intent(in) :: duration
      real(wp) :: slope, turns, effect, shorter
      integer :: modes
      ! The shapes of a loaded end are two more coordinates
      modes = rung%bending + merge(2, 0, rung%shaped)
      slope = beam%slope
      shorter = shortening(slope)
      effect = max(beam%effect, shorter)
      if (rung%segments > 1) then
         error = floor_of(rung, beam) + effect*min(0.2_wp, of_pieces*slope**2/(real(rung%segments, wp)**4*rung%bending**2))
         if (rung%level == level_linear) error = error + effect*min(1.0_wp, beam%geometric)
         return
      end if
      turns = beam%frequency*duration*beam%vibration
      error = norm2(beam%part(min(modes, size(beam%part)) + 1:))
      if (modes >= size(beam%part) .and. size(beam%part) > 0) error = beam%part(size(beam%part)) &
         & *(real(size(beam%part), wp)/modes)**4
      select case (rung%level)
      case (level_rigid)
         ! What a tension holds straight is slack where that is gone, or left out
         error = max(beam%effect + beam%stretch, shortening(max(beam%slope, beam%slack_slope)))
      case (level_linear)
         error = error + merge(of_one_mode, 1.0_wp, rung%stretched)*beam%stretch + max(shortening(beam%slack_slope), shorter, &
            & effect*min(1.0_wp, beam%geometric + (kg_static + kg_dynamic*turns)*slope**2))
      case (level_kg)
         error = error + max(shorter, effect*min(0.6_wp, (kg_static + kg_dynamic*turns)*slope**2))
      case (level_full)
         error = error + floor_of(rung, beam)
      end select
   end function expected_error

   !> What a beam that bends loses in length, however little its deflection itself does to the channels: eq. (T5).
   pure real(wp) function shortening(slope)
      real(wp), intent(in) :: slope
      shortening = min(1.0_wp, 0.25_wp*slope**2)
   end function shortening

   !> What FULL leaves out however rich its basis: the next order of the geometry, eqs. (176), (T6).
   pure real(wp) function floor_of(rung, beam) result(error)
      type(rung_type), intent(in) :: rung
      type(prospect_type), intent(in) :: beam
      real(wp) :: slope
      slope = beam%slope
      if (rung%segments > 1) slope = merge(free_piece_slope, piece_slope, rung%free_end)*slope/rung%segments
      error = max(beam%effect, shortening(beam%slope))*min(0.3_wp, full_floor*slope**4 + of_strain*beam%strain*slope**2)
   end function floor_of

   !> The floors of all beams on their rungs.
   subroutine find_floors(advice)
      type(advice_type), intent(inout) :: advice
      integer :: i
      advice%floor = 0.0_wp
      do i = 1, size(advice%rungs)
         if (advice%rungs(i)%level == level_full) &
            & advice%floor(i) = floor_of(advice%rungs(i), advice%probe%beams(i))
      end do
   end subroutine find_floors

   !> What a rung costs in an evaluation, in units of a rigid body: counted operations, eq. (177).
   elemental real(wp) function cost_of(rung) result(cost)
      type(rung_type), intent(in) :: rung
      real(wp), parameter :: of_division = 3.0_wp
      real(wp) :: n, axial, pairs
      cost = 1.0_wp
      if (rung%level == level_rigid) return
      n = rung%bending + merge(2, 0, rung%shaped .or. rung%segments > 1)
      axial = functions_of(rung) - merge(2, 0, rung%segments > 1)
      pairs = n*(n + 1)/2
      cost = 2.0_wp + 0.15_wp*(n + axial) + 0.02_wp*(n + axial)**2
      if (rung%level >= level_kg) cost = cost + 0.02_wp*pairs*axial
      if (rung%level == level_full) cost = cost + 0.02_wp*pairs*(axial + pairs)
      ! Short pieces stretch and shrink fast, which takes twice the steps; and they are held to each other
      if (rung%segments > 1) cost = of_division*cost*rung%segments
   end function cost_of

   !> Finite elements that keep the error of the lumped masses in a tenth of the share, closed form: eq. (178).
   pure integer function lumping_elements(rung, advice, beam) result(elements)
      type(rung_type), intent(in) :: rung
      type(advice_type), intent(in) :: advice
      type(prospect_type), intent(in) :: beam
      real(wp) :: allowed, phases, b
      ! Of a beam that hardly bends the inertia still counts
      allowed = 0.1_wp*advice%target/max(beam%effect, 0.2_wp)
      phases = 1.0_wp + beam%frequency*advice%probe%duration*beam%vibration
      do elements = 24, most_elements - 24, 24
         b = acos(-1.0_wp)/elements
         if (rung%free_end) then
            if (0.046_wp*b**2*phases <= allowed) exit
         else
            if (b**2/12 + (rung%bending*b**4 + b**4*phases)/1440 <= allowed) exit
         end if
      end do
   end function lumping_elements

   !> Tolerance whose error of the integration is its part of the target: eq. (179).
   pure real(wp) function wanted_tolerance(advice) result(tolerance)
      type(advice_type), intent(in) :: advice
      real(wp), parameter :: largest = 1.0e-2_wp, smallest = 1.0e-12_wp
      !> Error of the deflections by that of a step, relative to their scale; the same of rigid scenes
      real(wp), parameter :: of_deflections = 3.0e-3_wp, of_motion = 10.0_wp
      integer :: i
      tolerance = part_time*advice%target/of_motion
      if (any(advice%rungs%level > level_rigid)) tolerance = 5*part_time*advice%target
      do i = 1, size(advice%rungs)
         if (advice%rungs(i)%level == level_rigid) cycle
         associate (beam => advice%probe%beams(i))
            if (beam%effect > no_matter*advice%target) tolerance = min(tolerance, part_time*advice%target &
               & *beam%deflection/(of_deflections*beam%effect))
         end associate
      end do
      tolerance = max(smallest, min(largest, tolerance))
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

end module limber_analysis_advice
