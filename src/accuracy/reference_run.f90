!> Reference of a search. It is the companion run of a smaller tolerance, and what higher levels have changed. Floor: accuracy.
!> Equations: doc/theory, part 7.
module limber_accuracy_reference_run
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_scene_channel_errors, only: magnitude
   use limber_accuracy_fidelity_levels, only: level_type, same_rungs
   use limber_accuracy_search_thresholds, only: least_power, usual_power, usually
   use limber_deck_content, only: deck_type
   implicit none
   private
   public :: reference_run_type, shown_type, error_against, largest_difference, place_of, rest_of

   !> The reference
   type :: reference_run_type
      logical :: known = .false.
      !> Its highest rungs, and its tolerance
      type(level_type), allocatable :: rungs(:)
      real(wp) :: tolerance = 0.0_wp
      !> Its channels (channels, samples)
      real(wp), allocatable :: values(:, :)
      !> What errors of the channels are relative to (channels): the largest values of the reference, or those of its terms
      real(wp), allocatable :: scale(:)
      logical, allocatable :: of_terms(:)
      !> Its own error, estimated (channels)
      real(wp), allocatable :: rest(:)
      !> Its parts: the run of the smallest tolerance, what higher levels change (channels, samples); errors that both leave, and
      !> what the strain changes (channels)
      real(wp), allocatable :: finest(:, :), change(:, :), of_time(:), of_model(:), of_strain(:)
      !> The deck with all free that it fixes of the fidelity, and the beams that are open in it alone; allocated if the reference
      !> is
      !> a run of it
      type(deck_type), allocatable :: freed
      type(level_type), allocatable :: aside(:)
   contains
      procedure :: take
      procedure :: combine
   end type reference_run_type

   !> What pairs of runs have shown of the integration so far
   type :: shown_type
      !> Tolerances of the runs of the first and of the last pair, and their largest differences, relative
      real(wp) :: tolerance(2) = 0.0_wp, of_time(2) = 0.0_wp
      integer :: pairs = 0
      !> The power of the tolerance that errors of the integration fall with, as far as pairs show, and the rungs of the last pair
      real(wp) :: falling = usual_power
      type(level_type), allocatable :: last(:)
      !> The pair that differed most, and by more than the target: the run and the finer one (channels, samples), with these rungs,
      !> by so much, relative. Not allocated: none did
      real(wp), allocatable :: run(:, :), finer(:, :)
      type(level_type), allocatable :: rungs(:)
      real(wp) :: difference = 0.0_wp
      !> How often a target that was kept was looked at again for it
      integer :: looks = 0
   contains
      procedure :: take => take_pair
      procedure :: is_forgotten
      procedure, private :: learn
   end type shown_type

contains

   !> Takes what another pair has shown.
   pure subroutine take_pair(self, rungs, tolerance, of_time, target, run, finer)
      class(shown_type), intent(inout) :: self
      type(level_type), intent(in) :: rungs(:)
      !> Tolerance of the run; difference of the two and the target, relative
      real(wp), intent(in) :: tolerance, of_time, target
      !> Samples of the run and of the finer one (channels, samples)
      real(wp), intent(in) :: run(:, :), finer(:, :)
      call self%learn(rungs, tolerance, of_time, target)
      self%pairs = self%pairs + 1
      if (self%pairs == 1) self%tolerance(1) = tolerance
      if (self%pairs == 1) self%of_time(1) = of_time
      self%tolerance(2) = tolerance
      self%of_time(2) = of_time
      if (of_time <= max(target, self%difference)) return
      if (allocated(self%run)) deallocate (self%run, self%finer, self%rungs)
      self%difference = of_time
      allocate (self%run, source=run)
      allocate (self%finer, source=finer)
      allocate (self%rungs, source=rungs)
   end subroutine take_pair

   !> How errors of the integration fall, from two pairs of the same models: slowly where a sudden load makes vibrations that no
   !> step
   !> follows. What is next to nothing beside the target shows round-off only.
   pure subroutine learn(self, rungs, tolerance, of_time, target)
      class(shown_type), intent(inout) :: self
      !> As those of `take`, before the pair is taken
      type(level_type), intent(in) :: rungs(:)
      real(wp), intent(in) :: tolerance, of_time, target
      real(wp), parameter :: nothing = 0.1_wp, same = 0.01_wp
      real(wp) :: decades
      if (self%pairs > 0) then
         decades = log(tolerance/self%tolerance(2))
         if (same_rungs(rungs, self%last) .and. abs(decades) > same .and. min(of_time, self%of_time(2)) > nothing*target) &
            & self%falling = max(least_power, min(usual_power, log(of_time/self%of_time(2))/decades))
      end if
      self%last = rungs
   end subroutine learn

   !> Whether the finest run, of the same models, is near to a run that a finer one has contradicted, and not to that, eq. (7.94).
   pure logical function is_forgotten(self, rungs, finest, scale, target)
      class(shown_type), intent(in) :: self
      type(level_type), intent(in) :: rungs(:)
      !> Samples of the finest run (channels, samples), and what differences are relative to (channels)
      real(wp), intent(in) :: finest(:, :), scale(:), target
      real(wp) :: to_run, to_finer
      is_forgotten = .false.
      if (.not. allocated(self%run)) return
      if (any(shape(self%run) /= shape(finest)) .or. size(rungs) /= size(self%rungs)) return
      if (any(rungs%step /= self%rungs%step .or. (rungs%stretches .neqv. self%rungs%stretches))) return
      to_run = maxval(largest_difference(self%run, finest)/scale)
      to_finer = maxval(largest_difference(self%finer, finest)/scale)
      is_forgotten = to_finer > target .and. to_run < to_finer
   end function is_forgotten

   !> Takes a run for the reference.
   pure subroutine take(self, rungs, tolerance, values, rest)
      class(reference_run_type), intent(inout) :: self
      type(level_type), intent(in) :: rungs(:)
      real(wp), intent(in) :: tolerance
      !> Samples of the run (channels, samples); its own error, estimated (channels)
      real(wp), intent(in) :: values(:, :), rest(:)
      integer :: c
      self%rungs = rungs
      self%values = values
      self%rest = rest
      if (allocated(self%freed)) deallocate (self%freed)
      if (allocated(self%aside)) deallocate (self%aside)
      allocate (self%aside(0))
      do c = 1, size(self%scale)
         if (.not. self%of_terms(c)) self%scale(c) = magnitude(values(c, :))
      end do
      self%tolerance = tolerance
      self%known = .true.
   end subroutine take

   !> Puts the parts together that are known, eq. (7.90).
   pure subroutine combine(self, rungs, tolerance, least)
      class(reference_run_type), intent(inout) :: self
      type(level_type), intent(in) :: rungs(:)
      real(wp), intent(in) :: tolerance
      !> Least error of it, relative
      real(wp), intent(in) :: least
      real(wp), allocatable :: values(:, :), rest(:)
      allocate (values, source=self%finest)
      allocate (rest, source=self%of_time)
      if (allocated(self%change)) values = values + self%change
      if (allocated(self%change)) rest = rest + self%of_model
      if (allocated(self%of_strain)) rest = rest + self%of_strain
      call self%take(rungs, tolerance, values, rest)
      self%rest = max(rest, least*self%scale)
   end subroutine combine

   !> Largest error of a run over channels and samples, relative: its difference from the truth, and the error of that; eq. (7.92).
   pure real(wp) function error_against(truth, values) result(error)
      type(reference_run_type), intent(in) :: truth
      !> At least its channels (channels, samples)
      real(wp), intent(in) :: values(:, :)
      integer :: c, n
      n = size(truth%values, 2)
      error = 0.0_wp
      do c = 1, size(truth%scale)
         error = max(error, (maxval(abs(values(c, :n) - truth%values(c, :))) + truth%rest(c))/truth%scale(c))
      end do
   end function error_against

   !> Where two runs differ most, for people: " in 'M0' at t = 0.013".
   function place_of(a, b, scale, times, names) result(text)
      !> (channels, samples), of which b has no more; what differences are relative to (channels); times of the samples
      real(wp), intent(in) :: a(:, :), b(:, :), scale(:), times(:)
      !> Of the channels
      character(*), intent(in) :: names(:)
      character(:), allocatable :: text
      integer :: c, k(1)
      c = maxloc(largest_difference(a, b)/scale, 1)
      k = maxloc(abs(a(c, :size(b, 2)) - b(c, :)))
      text = " in '"//trim(names(c))//"' at t = "//as_text(times(k(1)), 3)
   end function place_of

   !> Error of a companion run as a part of its difference from the run, by the power that errors fall with; usually they fall
   !> faster, eq. (7.87).
   pure real(wp) function rest_of(part, falling)
      !> Tolerance of the companion over that of the run, below 1
      real(wp), intent(in) :: part, falling
      rest_of = usually*part**falling/(1 - part**falling)
   end function rest_of

   !> Largest difference of two runs in each channel.
   pure function largest_difference(a, b) result(away)
      !> (channels, samples), of which b has no more
      real(wp), intent(in) :: a(:, :), b(:, :)
      real(wp) :: away(size(b, 1))
      integer :: c
      do c = 1, size(b, 1)
         away(c) = maxval(abs(a(c, :size(b, 2)) - b(c, :)))
      end do
   end function largest_difference

end module limber_accuracy_reference_run
