!> Indicators of the model ranges: running maxima of dimensionless indicators, each with its time. An analysis lets a state be
!> observed now and then; nothing is allocated there. `limber_monitor_model_ranges` judges them.
!>
!>     call start_indicators(indicators, system)                    ! limber_monitor_indicator_start: before the first step
!>     call observe(indicators, system, work, t, q, v, a)           ! limber_monitor_observation: at a state
!>     value = indicator_value(indicators%bodies(i), indicator_slope)
!>     t = indicator_time(indicators%bodies(i), indicator_slope)
!>
!> Floor: monitor. Source: doc/theory, eqs. (7.8)-(7.11), (7.15)-(7.17), (7.21), (7.25)-(7.27), (7.32)-(7.35).
module limber_monitor_indicators
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_monitor_drawing_in, only: drawing_in_type
   use limber_monitor_drawn_channels, only: drawn_channels_type, join_drawn_channels, drawn_part
   use limber_monitor_false_damping, only: false_damping_type, join_false_damping, lost_amplitude
   use limber_monitor_function_watch, only: function_watch_type, join_functions
   use limber_monitor_membrane, only: membrane_type
   use limber_monitor_modal_sudden, only: modal_sudden_type, join_modal_sudden, lost_forces, sudden_kinds
   use limber_monitor_lumping_phase, only: phase_type, join_phases, phase_error
   use limber_monitor_body_surveys, only: surveys_type
   use limber_beam_quasistatic_deflection, only: quasistatic_type
   use limber_beam_monitored_sections, only: monitored_sections_type
   use limber_output_point_forces, only: pulls_type
   implicit none
   private
   public :: indicators_type, body_indicators_type, indicator_set_type, join_indicators, raise_peak, raise_recoil_force, &
      & add_vibration, add_geometric, indicator_value, indicator_time
   public :: indicator_names, indicator_meanings, layer_errors, sudden_errors, looks_at_jumps, tell_drawn

   !> Kinds of indicators, those of a body in this order
   integer, parameter, public :: indicator_deflection = 1, indicator_slope = 2, indicator_rotation = 3, indicator_compression = 4, &
      & indicator_tension = 5, indicator_pace = 6, indicator_last_mode = 7, indicator_residual = 8, indicator_geometric = 9, &
      & indicator_axial = 10, indicator_coarseness = 11, indicator_lumping = 12, indicator_shortening = 13, &
      & indicator_drift = 14, indicator_elongation = 15, indicator_recoil = 16, indicator_buckling = 17, indicator_layer = 18, &
      & indicator_phase = 19, indicator_false_damping = 20, indicator_membrane = 21, &
      & indicator_reaction = 22, indicator_recoil_force = 23, indicator_drawn = 24, indicator_strain = 25, &
      & indicator_sudden = 26, indicator_stiffening = 27, indicator_count = 27

   !> Their names in results, and what they are
   character(*), parameter :: indicator_names(indicator_count) = [character(16) :: 'deflection', 'slope', 'rotation', &
      & 'compression', 'tension', 'pace', 'last_mode', 'residual', 'geometric', 'axial', 'coarseness', 'lumping', &
      & 'shortening', 'drift', 'elongation', 'recoil', 'buckling', 'layer', 'phase', 'false_damping', &
      & 'membrane', 'membrane_force', 'recoil_force', 'drawn_in', 'strain', 'sudden', 'stiffening']
   character(*), parameter :: indicator_meanings(indicator_count) = [character(120) :: &
      & 'largest deflection in the frame / length', &
      & 'largest slope in the frame', &
      & 'largest rotation speed of the frame / first frequency', &
      & 'largest axial compression / Euler load', &
      & 'largest axial tension / Euler load', &
      & 'how dynamic the bending is: sqrt(largest kinetic / largest elastic energy of the coordinates)', &
      & 'part of the last bending coordinate in the energy of bending', &
      & 'part of the energy of bending that the coordinates cannot carry', &
      & 'largest work of the axial force on the bending / energy of bending', &
      & 'relative deflection that the axial force makes which the model lacks in the means of its k_G elements', &
      & 'relative deflection that the variation of the axial force within the k_G elements makes', &
      & 'error of frequencies and deflections by the lumped masses', &
      & 'work of the axial force on the shortening beyond half of the squared slope / energy of bending', &
      & 'shift of the vibrations / largest deflection, by what the model lacks of the shortening', &
      & 'elongation by the axial force that the axial functions lack / largest elongation or deflection', &
      & 'work on the bending of the inertia that the shortening has and the model lacks / energy of bending', &
      & 'relative change of the stiffness under compression by functions that do not fit how joints hold the beam', &
      & 'error of the internal forces that channels ask for, by bending near ends that tension makes too short', &
      & 'shift of the vibrations / largest deflection, or of a swing / its amplitude, by the lumped masses', &
      & 'amplitude that vibrations lose or gain in rotation, by what the model lacks of the shortening / largest deflection', &
      & 'relative change of the deflection of a frame by axial force where the ends of its members cannot approach each other', &
      & 'that axial force / largest axial force or load, where channels ask for axial forces, stresses or reactions', &
      & 'axial force by inertia that the shortening has and the model lacks / largest axial force or load, where it is asked for', &
      & 'error of a position, velocity, acceleration or momentum that bending draws in and a channel asks for / largest one', &
      & 'relative change of the deflection by the axial strain of what is compressed', &
      & 'section forces and reactions of vibrations under sudden loads outside the coordinates / largest ones, where asked for', &
      & 'shift of the vibrations / largest deflection, by the work of axial forces on the bending that the model lacks']

   !> Kinetic over elastic energy, as `indicator_pace`, below which a compression lasts long enough to buckle a beam
   real(wp), parameter, public :: slow = 0.3_wp

   !> Maxima that the indicators are made of
   integer, parameter, public :: peak_deflection = 1, peak_slope = 2, peak_rotation = 3, peak_compression = 4, peak_tension = 5, &
      & peak_energy = 6, peak_kinetic = 7, peak_left_out = 8, peak_geometric = 9, peak_axial = 10, peak_coarse = 11, &
      & peak_stiffness = 12, peak_lost = 13, peak_quartic = 14, peak_bent = 15, peak_stretch = 16, &
      & peak_unstretched = 17, peak_recoil = 18, peak_axial_grown = 19, &
      & peak_coarse_grown = 20, peak_layer = 21, peak_quartic_grown = 22, &
      & peak_membrane = 23, peak_membrane_force = 24, peak_pull = 25, peak_growth = 26, &
      & peak_recoil_force = 27, peak_recoil_kept = 28, peak_own_pull = 29, peak_drawn = 30, peak_strained = 31, peaks = 31

   !> Sums over the states that were observed: kinetic and elastic energy of bending, that of the shortening, accelerations,
   !> squared coordinates of bending, and work of the axial forces on the bending
   integer, parameter, public :: sum_kinetic = 1, sum_elastic = 2, sum_shortening = 3, sum_acceleration = 4, &
      & sum_bent = 5, sum_geometric = 6, sums = 6

   !> One flexible body, or one rigid beam
   type :: body_indicators_type
      !> Index of the body in the model, and whether it is a straight beam: a frame is watched by its survey instead
      integer :: body = 0
      logical :: is_beam = .false.
      !> Whether it is a rigid beam, which has its own constants, and a few of the indicators; deflections at three places when it
      !> was last observed [length], and when that was; forces at its places (3, places)
      logical :: is_rigid = .false.
      !> Deflection relative to the length that a rigid beam may have left out
      real(wp) :: allowed = 1.0e-2_wp
      type(quasistatic_type) :: quasistatic
      real(wp) :: seen(3) = 0.0_wp, seen_at = 0.0_wp
      real(wp), allocatable :: pressed(:, :)
      !> Which of the sets of constants are its own; its k_G elements, and whether joints hold its ends at a distance from each
      !> other of which its model knows nothing
      integer :: set = 0, elements = 0
      logical :: held = .false.
      !> By how much its functions take Euler's load too large, relative; L sqrt(P/E I) of the tension P of Euler's load, by the
      !> number of its bending coordinates; of a frame the number that each of its members has; whether channels ask for its shear
      !> force, for its bending moment or stresses, and for the moment of a joint that holds it
      real(wp) :: misfit = 0.0_wp, layer = 0.0_wp
      logical :: shows_shear = .false., shows_moment = .false., shows_reaction = .false.
      !> Whether they ask for its axial force or stresses, or for forces of a joint that holds it
      logical :: shows_axial = .false.
      !> The same without stresses
      logical :: shows_force = .false.
      !> Part of the length below which a deflection is one of the integrator's errors
      real(wp) :: noise = 0.0_wp
      !> First frequency, and length or size
      real(wp) :: first_frequency = 1.0_wp, length = 1.0_wp
      !> Maxima and their times; largest elastic energy of each bending coordinate, its time, and the largest kinetic energy
      real(wp) :: peak(peaks) = 0.0_wp, time(peaks) = 0.0_wp
      real(wp), allocatable :: modal(:), modal_time(:), moving(:)
      !> Sums, the first and the last time that they are of, and how many states
      real(wp) :: total(sums) = 0.0_wp, span(2) = [huge(1.0_wp), -huge(1.0_wp)]
      integer :: looks = 0
      !> Time of the last state, its compression in parts of Euler's load, by how much it is beyond that load, added up [time], and
      !> since when
      real(wp) :: pressed_at = huge(1.0_wp), compression = 0.0_wp, overload = 0.0_wp, since = huge(1.0_wp)
      !> Coordinates that bend it (bending)
      integer, allocatable :: bending(:)
      !> Masses that other bodies hang on its places, and which place of a beam does not follow the shortening; zero: the start
      !> (places)
      real(wp), allocatable :: carried(:)
      integer :: anchor = 0
      !> Relative error of each bending frequency by the lumped masses (bending)
      real(wp), allocatable :: lumping(:)
      !> Section forces under sudden loads
      type(modal_sudden_type) :: sudden
      !> Vibrations and swings that lumped masses delay; vibrations that the model damps in rotation
      type(phase_type) :: phase
      type(false_damping_type) :: false_damping
      !> Of a frame: motions that strain it as the joints with the ground hold it, u.K u = 1: rotation, coordinates that are
      !> watched (0:chosen, motions); made when it is first observed
      real(wp), allocatable :: strained(:, :)
      !> Scratch of a frame: work of the axial forces on slopes (0:chosen, 0:chosen), on the motions (motions, motions), eigenvalues
      !> of that and room for them, elastic force (n), products of coordinates and their tension (pairs), forces that are lacking
      !> (0:chosen)
      real(wp), allocatable :: slope_work(:, :), loaded(:, :), value(:), room(:), elastic(:), s(:), lacking(:)
      !> Of a frame: axial forces where the ends of its members cannot approach each other
      type(membrane_type) :: membrane
      !> Of a frame: inertia of the shortening of its members, and the displacements by that; of a beam only its axial force
      type(drawing_in_type) :: drawing_in
      !> Of the channels that its bending draws in the one that errs most: that error as a part of its largest value, when, and its
      !> name
      real(wp) :: drawn = 0.0_wp, drawn_at = 0.0_wp
      character(100) :: drawn_name = ''
      !> Scratch: slopes and axial forces at the stations, amplitudes along and across, and of the bending coordinates,
      !> forces on these
      real(wp), allocatable :: slope(:), force(:), along(:), across(:), own(:), push(:, :)
   end type body_indicators_type

   !> Constants of beams that are equal and held and loaded at the same places
   type :: indicator_set_type
      !> First of them in the model; what joints do at each place; whether two places are held by the same other body
      integer :: body = 0
      integer, allocatable :: hold(:)
      logical :: held = .false.
      type(monitored_sections_type) :: stations
   end type indicator_set_type

   !> All flexible bodies of a scene
   type :: indicators_type
      type(body_indicators_type), allocatable :: bodies(:)
      !> Only the first `count` are in use
      type(indicator_set_type), allocatable :: sets(:)
      integer :: count = 0
      !> Number of states that were observed
      integer :: observations = 0
      !> Sums of kinetic energies that swings are judged by, eq. (7.31)
      real(wp) :: swings(2) = 0.0_wp
      !> Index into `bodies` of each body of the model; 0: none
      integer, allocatable :: of(:)
      !> Place of each point among those of its beam; 0: none (points)
      integer, allocatable :: place(:)
      !> Whether the force of a side of a constraint acts at its point across the beam: not if something slides along it
      logical, allocatable :: fixed(:, :)
      !> Whether a driver holds the rotation of a body (bodies)
      logical, allocatable :: turned(:)
      !> Of the forces of a load
      real(wp), allocatable :: scratch(:)
      !> What acts on several points of a body
      type(pulls_type) :: pulls
      !> Axial forces in frames, and what these cannot carry
      type(surveys_type) :: surveys
      !> What the functions of exact beams leave out
      type(function_watch_type) :: functions
      !> Channels that bending draws in
      type(drawn_channels_type) :: drawn
   contains
      procedure :: exchange => exchange_indicators
   end type indicators_type

contains

   !> Takes a value into the maximum of its kind.
   pure subroutine raise_peak(self, kind, value, t)
      type(body_indicators_type), intent(inout) :: self
      !> One of peak_...
      integer, intent(in) :: kind
      real(wp), intent(in) :: value, t
      if (.not. value > self%peak(kind)) return
      self%peak(kind) = value
      self%time(kind) = t
   end subroutine raise_peak

   !> Axial force that the inertia of the shortening makes beside the largest axial force so far, or a part of the largest load,
   !> eq. (7.47): not of the whole run, in which it may feed an axial vibration without end. What was found of a much smaller force
   !> is left.
   pure subroutine raise_recoil_force(self, force, t)
      type(body_indicators_type), intent(inout) :: self
      real(wp), intent(in) :: force, t
      !> Part of the largest load that counts as axial force, and of the largest force that is kept
      real(wp), parameter :: aside = 0.05_wp, small = 0.1_wp
      if (.not. (self%shows_force .and. force > 0.0_wp)) return
      if (self%peak(peak_recoil_kept) < small*force) self%peak(peak_recoil_force) = 0.0_wp
      if (force < small*self%peak(peak_recoil_kept)) return
      associate (value => force/max(force, self%peak(peak_own_pull), aside*self%peak(peak_pull)))
         if (value > self%peak(peak_recoil_force)) self%peak(peak_recoil_kept) = force
         call raise_peak(self, peak_recoil_force, value, t)
      end associate
   end subroutine raise_recoil_force

   !> Energies and accelerations of the vibration.
   pure subroutine add_vibration(self, omega2, t, eta, rate, acceleration)
      type(body_indicators_type), intent(inout) :: self
      !> Squared frequencies (n); time; coordinates, their rates and accelerations (n)
      real(wp), intent(in) :: omega2(:), t, eta(:), rate(:), acceleration(:)
      integer :: i, k
      do i = 1, size(self%bending)
         k = self%bending(i)
         self%total(sum_kinetic) = self%total(sum_kinetic) + rate(k)**2
         self%total(sum_acceleration) = self%total(sum_acceleration) + acceleration(k)**2
         self%total(sum_bent) = self%total(sum_bent) + eta(k)**2
         self%total(sum_elastic) = self%total(sum_elastic) + omega2(k)*eta(k)**2
      end do
      self%looks = self%looks + 1
      self%span = [min(self%span(1), t), max(self%span(2), t)]
   end subroutine add_vibration

   !> Joins the maxima of an analysis to those of the ones before it.
   subroutine join_indicators(part, whole)
      !> Unallocated if the analysis has none; of the first analysis it moves
      class(indicators_type), allocatable, intent(inout) :: part
      class(indicators_type), allocatable, intent(inout) :: whole
      integer :: i, k
      if (.not. allocated(part)) return
      if (.not. allocated(whole)) then
         call move_alloc(part, whole)
         return
      end if
      whole%observations = whole%observations + part%observations
      do i = 1, size(part%bodies)
         do k = 1, peaks
            call raise_peak(whole%bodies(i), k, part%bodies(i)%peak(k), part%bodies(i)%time(k))
         end do
         whole%bodies(i)%noise = min(whole%bodies(i)%noise, part%bodies(i)%noise)
         whole%bodies(i)%total = whole%bodies(i)%total + part%bodies(i)%total
         whole%bodies(i)%looks = whole%bodies(i)%looks + part%bodies(i)%looks
         whole%bodies(i)%span = [min(whole%bodies(i)%span(1), part%bodies(i)%span(1)), &
            & max(whole%bodies(i)%span(2), part%bodies(i)%span(2))]
         do k = 1, size(part%bodies(i)%modal)
            if (.not. part%bodies(i)%modal(k) > whole%bodies(i)%modal(k)) cycle
            whole%bodies(i)%modal(k) = part%bodies(i)%modal(k)
            whole%bodies(i)%modal_time(k) = part%bodies(i)%modal_time(k)
         end do
         call join_modal_sudden(part%bodies(i)%sudden, whole%bodies(i)%sudden)
         call join_phases(part%bodies(i)%phase, whole%bodies(i)%phase)
         call join_false_damping(part%bodies(i)%false_damping, whole%bodies(i)%false_damping)
         whole%bodies(i)%moving = max(whole%bodies(i)%moving, part%bodies(i)%moving)
      end do
      call join_drawn_channels(part%drawn, whole%drawn)
      call tell_drawn(whole)
      call join_functions(part%functions, whole%functions)
   end subroutine join_indicators

   !> Value of an indicator so far; zero where a body has none of its kind.
   pure real(wp) function indicator_value(self, kind) result(value)
      type(body_indicators_type), intent(in) :: self
      !> One of indicator_...
      integer, intent(in) :: kind
      associate (peak => self%peak)
         select case (kind)
         case (indicator_pace); value = sqrt(ratio(peak(peak_kinetic), peak(peak_energy)))
         case (indicator_last_mode)
            value = 0.0_wp
            if (size(self%modal) > 0) value = ratio(self%modal(size(self%modal)), peak(peak_energy))
         case (indicator_residual); value = ratio(peak(peak_left_out), peak(peak_left_out) + peak(peak_energy))
         case (indicator_geometric); value = sqrt(ratio(peak(peak_geometric), peak(peak_stiffness)))
         case (indicator_axial)
            value = sqrt(ratio(peak(merge(peak_axial_grown, peak_axial, is_slow(self))), &
               & peak(peak_stiffness)))
         case (indicator_coarseness)
            value = sqrt(ratio(peak(merge(peak_coarse_grown, peak_coarse, is_slow(self))), peak(peak_stiffness)))
         case (indicator_lumping)
            value = 0.0_wp
            if (allocated(self%lumping)) value = max(ratio(maxval(min(self%modal, self%moving)*self%lumping), peak(peak_energy)), &
               & sqrt(ratio(peak(peak_lost), peak(peak_energy))))
         case (indicator_shortening)
            value = ratio(peak(merge(peak_quartic_grown, peak_quartic, is_slow(self))), peak(peak_stiffness))
         case (indicator_drift); value = vibration_shift(self, ratio(self%total(sum_shortening), self%total(sum_kinetic)))
         case (indicator_stiffening); value = vibration_shift(self, 0.5_wp*ratio(abs(self%total(sum_geometric)), &
            & self%total(sum_elastic)))
         case (indicator_recoil); value = ratio(peak(peak_recoil), peak(peak_stiffness))
         case (indicator_elongation); value = ratio(peak(peak_unstretched), max(peak(peak_stretch), peak(peak_deflection)))
         case (indicator_buckling); value = self%misfit*peak(peak_compression)/max(0.01_wp, abs(1 - peak(peak_compression)))
         case (indicator_layer); value = layer_error(self)
         case (indicator_phase); value = phase_error(self%phase, peak(peak_bent), peak(peak_deflection)*self%length)
         case (indicator_false_damping); value = lost_amplitude(self%false_damping, self%first_frequency)
         case (indicator_membrane); value = peak(peak_membrane)
         case (indicator_reaction)
            value = 0.0_wp
            if (self%shows_axial) value = ratio(peak(peak_membrane_force), max(peak(peak_pull), peak(peak_membrane_force)))
         case (indicator_recoil_force); value = peak(peak_recoil_force)
         case (indicator_drawn); value = self%drawn
         case (indicator_strain)
            value = 0.0_wp
            if (is_slow(self)) value = ratio(peak(peak_strained), peak(peak_stiffness))
         case (indicator_sudden); value = maxval(sudden_errors(self))
         case default; value = peak(kind)
         end select
      end associate
   end function indicator_value

   !> Gives each channel to its body, what shows several or none that bend to the one that is drawn in most.
   pure subroutine tell_drawn(self)
      type(indicators_type), intent(inout) :: self
      real(wp) :: part, most
      integer :: i, body, worst
      worst = 1
      most = 0.0_wp
      do i = 1, size(self%bodies)
         self%bodies(i)%drawn = 0.0_wp
         self%bodies(i)%drawn_at = 0.0_wp
         self%bodies(i)%drawn_name = ''
         if (.not. self%bodies(i)%length*self%bodies(i)%peak(peak_drawn) > most) cycle
         most = self%bodies(i)%length*self%bodies(i)%peak(peak_drawn)
         worst = i
      end do
      do i = 1, size(self%drawn%channels)
         part = drawn_part(self%drawn%channels(i))
         if (.not. part > 0.0_wp) cycle
         body = worst
         if (self%drawn%channels(i)%body > 0) body = self%of(self%drawn%channels(i)%body)
         if (.not. part > self%bodies(body)%drawn) cycle
         self%bodies(body)%drawn = part
         self%bodies(body)%drawn_at = self%drawn%channels(i)%time
         self%bodies(body)%drawn_name = self%drawn%channels(i)%name
      end do
   end subroutine tell_drawn

   !> Error of the internal forces that are asked for where bending near an end or a load dies out over sqrt(E I/P).
   pure real(wp) function layer_error(self) result(value)
      type(body_indicators_type), intent(in) :: self
      value = maxval(layer_errors(self))
   end function layer_error

   !> Errors there of shear forces, of bending moments, and of moments of joints, nought of what no channel asks for (3), as
   !> measured on cantilevers against the length that each coordinate has, eq. (7.19).
   pure function layer_errors(self) result(errors)
      type(body_indicators_type), intent(in) :: self
      real(wp) :: errors(3), share
      if (allocated(self%slope_work)) then
         ! A frame
         share = self%peak(peak_layer)
      else
         share = self%layer*sqrt(max(0.0_wp, self%peak(peak_tension)))
      end if
      errors = [8.0e-4_wp, 6.0e-4_wp, 6.0e-4_wp]*share**4
      errors = errors/(1 + errors)
      where (.not. [self%shows_shear, self%shows_moment, self%shows_reaction]) errors = 0.0_wp
   end function layer_errors

   !> Errors under sudden loads of axial forces, shear forces, bending moments, forces and moments of joints, nought of what no
   !> channel asks for (kinds).
   pure function sudden_errors(self) result(errors)
      type(body_indicators_type), intent(in) :: self
      real(wp) :: errors(sudden_kinds)
      errors = lost_forces(self%sudden)
      where (.not. [self%shows_force, self%shows_shear, self%shows_moment]) errors(:3) = 0.0_wp
   end function sudden_errors

   !> Whether anything is to be observed on both sides of an instant at which loads jump.
   pure logical function looks_at_jumps(self)
      type(indicators_type), intent(in) :: self
      looks_at_jumps = size(self%functions%beams) > 0 .or. any(self%bodies%sudden%body > 0)
   end function looks_at_jumps

   !> Phase by which the vibrations go wrong, as a part of the largest deflection, eq. (7.21).
   pure real(wp) function vibration_shift(self, detuning) result(shift)
      type(body_indicators_type), intent(in) :: self
      !> Relative error of the frequency
      real(wp), intent(in) :: detuning
      real(wp) :: frequency, vibrating, count
      shift = 0.0_wp
      if (self%held) return
      associate (total => self%total)
         if (.not. (total(sum_kinetic) > 0.0_wp .and. self%peak(peak_bent) > 0.0_wp .and. total(sum_elastic) > 0.0_wp)) return
         frequency = sqrt(total(sum_acceleration)/total(sum_kinetic))
         count = self%span(2) - self%span(1)
         if (.not. (frequency > 0.0_wp .and. count > 0.0_wp)) return
         ! Sums and the largest are of the same states: their quotient needs the number of these
         vibrating = min(1.0_wp, sqrt(2*total(sum_kinetic)/self%looks)/(frequency*sqrt(self%peak(peak_bent))))
         ! Of a deflection that follows its loads little vibrates freely
         shift = vibrating*frequency*count*detuning*min(1.0_wp, frequency*sqrt(total(sum_bent)/total(sum_elastic)))
      end associate
   end function vibration_shift

   !> Work of the axial forces on the bending: its share in the energy of bending, as an error of the deflection, and its sum,
   !> eq. (7.15).
   pure subroutine add_geometric(self, work, elastic, t)
      type(body_indicators_type), intent(inout) :: self
      !> Twice the work, and twice the elastic energy of bending, then; the time
      real(wp), intent(in) :: work, elastic, t
      real(wp) :: stiffness
      stiffness = elastic + max(work, 0.0_wp)
      call raise_peak(self, peak_stiffness, stiffness, t)
      if (stiffness > 0.0_wp) call raise_peak(self, peak_geometric, work**2/stiffness, t)
      self%total(sum_geometric) = self%total(sum_geometric) + work
   end subroutine add_geometric

   !> Time of that value: of a quotient that of its numerator.
   pure real(wp) function indicator_time(self, kind) result(t)
      type(body_indicators_type), intent(in) :: self
      integer, intent(in) :: kind
      select case (kind)
      case (indicator_pace); t = self%time(peak_kinetic)
      case (indicator_last_mode)
         t = 0.0_wp
         if (size(self%modal) > 0) t = self%modal_time(size(self%modal))
      case (indicator_residual); t = self%time(peak_left_out)
      case (indicator_geometric); t = self%time(peak_geometric)
      case (indicator_axial); t = self%time(peak_axial)
      case (indicator_coarseness); t = self%time(peak_coarse)
      case (indicator_lumping)
         t = 0.0_wp
         if (self%is_beam) t = self%time(peak_lost)
      case (indicator_shortening); t = self%time(peak_quartic)
      case (indicator_drift, indicator_stiffening); t = max(0.0_wp, self%span(2))
      case (indicator_recoil); t = self%time(peak_recoil)
      case (indicator_elongation); t = self%time(peak_unstretched)
      case (indicator_buckling); t = self%time(peak_compression)
      case (indicator_layer); t = self%time(merge(peak_layer, peak_tension, allocated(self%slope_work)))
      case (indicator_phase); t = max(0.0_wp, self%phase%span(2))
      case (indicator_false_damping); t = max(0.0_wp, self%false_damping%span(2))
      case (indicator_membrane); t = self%time(peak_membrane)
      case (indicator_reaction); t = self%time(peak_membrane_force)
      case (indicator_recoil_force); t = self%time(peak_recoil_force)
      case (indicator_drawn); t = self%drawn_at
      case (indicator_strain); t = self%time(peak_strained)
      case (indicator_sudden); t = 0.0_wp
         if (self%sudden%when > -huge(t)) t = self%sudden%when
      case default; t = self%time(kind)
      end select
   end function indicator_time

   !> Whether the bending follows its loads as at rest, so that a compression has the time to make it larger.
   pure logical function is_slow(self)
      type(body_indicators_type), intent(in) :: self
      is_slow = sqrt(ratio(self%peak(peak_kinetic), self%peak(peak_energy))) < slow
   end function is_slow

   pure real(wp) function ratio(part, whole)
      real(wp), intent(in) :: part, whole
      ratio = 0.0_wp
      if (whole > 0.0_wp) ratio = part/whole
   end function ratio

   !> Saves or restores its memory.
   subroutine exchange_indicators(self, snapshot)
      class(indicators_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      integer :: i
      do i = 1, size(self%bodies)
         call snapshot%exchange('peak', self%bodies(i)%peak)
         call snapshot%exchange('time', self%bodies(i)%time)
         call snapshot%exchange('total', self%bodies(i)%total)
         call snapshot%exchange('span', self%bodies(i)%span)
         call snapshot%exchange('pressed_at', self%bodies(i)%pressed_at)
         call snapshot%exchange('compression', self%bodies(i)%compression)
         call snapshot%exchange('overload', self%bodies(i)%overload)
         call snapshot%exchange('since', self%bodies(i)%since)
         call snapshot%exchange('looks', self%bodies(i)%looks)
         call snapshot%exchange('seen', self%bodies(i)%seen)
         call snapshot%exchange('seen_at', self%bodies(i)%seen_at)
         call snapshot%keep('modal', self%bodies(i)%modal)
         call snapshot%keep('modal_time', self%bodies(i)%modal_time)
         call snapshot%keep('moving', self%bodies(i)%moving)
         call self%bodies(i)%sudden%exchange(snapshot)
         call self%bodies(i)%phase%exchange(snapshot)
         call self%bodies(i)%false_damping%exchange(snapshot)
      end do
      call self%functions%exchange(snapshot)
      call self%drawn%exchange(snapshot)
      call tell_drawn(self)
      call snapshot%exchange('observations', self%observations)
      call snapshot%exchange('swings', self%swings)
      ! Not saved: sets, count, of, place, fixed, turned, scratch, pulls, surveys
   end subroutine exchange_indicators

end module limber_monitor_indicators
