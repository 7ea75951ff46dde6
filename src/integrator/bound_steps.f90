!> Steps of a run that the tolerance has not chosen. Samples, turns, breaks of laws, curves have cut them. A companion run at
!> another tolerance, which tells the error, would take the same ones and err the same; where they prevail it takes steps that are
!> shorter as the tolerance would make them. Source: doc/theory, section 7.3. Floor: integrator.
module limber_integrator_bound_steps
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   implicit none
   private
   public :: bound_steps_type

   !> Parts of the time that are looked at, and part of a time in bound steps from which on these prevail in it
   integer, parameter :: parts = 1000
   real(wp), parameter :: prevailing = 0.4_wp

   !> What is known of the steps of a run
   type :: bound_steps_type
      !> Beginning and length of the whole time
      real(wp) :: begin = 0.0_wp, duration = 0.0_wp
      !> The companion's tolerance in units of that of the run
      real(wp) :: factor = 1.0_wp
      !> In each part of the time: the longest step, time in steps that were bound, in all, and the lowest order plus one (parts)
      real(wp), allocatable :: longest(:), bound(:), passed(:), power(:)
   contains
      procedure :: start => start_bound_steps
      procedure :: note => note_step
      procedure :: limit => limit_of_companion
      procedure :: prevail => bound_prevail
      procedure :: exchange => exchange_bound_steps
   end type bound_steps_type

contains

   !> Begins with nothing known.
   pure subroutine start_bound_steps(self, begin, duration)
      class(bound_steps_type), intent(inout) :: self
      !> Beginning and length of the whole time
      real(wp), intent(in) :: begin, duration
      self%begin = begin
      self%duration = duration
      if (.not. allocated(self%longest)) allocate (self%longest(parts), self%bound(parts), self%passed(parts), self%power(parts))
      self%longest = 0.0_wp
      self%bound = 0.0_wp
      self%passed = 0.0_wp
      self%power = huge(1.0_wp)
   end subroutine start_bound_steps

   !> Takes a step.
   pure subroutine note_step(self, from, to, order, bound)
      class(bound_steps_type), intent(inout) :: self
      !> Times of its ends
      real(wp), intent(in) :: from, to
      !> Of the formula
      integer, intent(in) :: order
      !> Whether it ended where it had to, or could have been more than twice as long for its error
      logical, intent(in) :: bound
      real(wp) :: width, inside
      integer :: i
      if (.not. to > from) return
      width = self%duration/parts
      do i = part_at(self, from), part_at(self, to)
         inside = max(0.0_wp, min(to, self%begin + i*width) - max(from, self%begin + (i - 1)*width))
         self%longest(i) = max(self%longest(i), to - from)
         self%passed(i) = self%passed(i) + inside
         if (bound) self%bound(i) = self%bound(i) + inside
         self%power(i) = min(self%power(i), real(order + 1, wp))
      end do
   end subroutine note_step

   !> The part of the time that a time is in.
   pure integer function part_at(self, t) result(i)
      class(bound_steps_type), intent(in) :: self
      real(wp), intent(in) :: t
      i = 1 + int(min(max((t - self%begin)/self%duration, 0.0_wp), 1.0_wp)*parts)
      i = min(i, parts)
   end function part_at

   !> Longest step that a companion may take, huge where bound steps do not prevail.
   pure real(wp) function limit_of_companion(self, t) result(longest)
      class(bound_steps_type), intent(in) :: self
      real(wp), intent(in) :: t
      integer :: i
      longest = huge(longest)
      if (.not. allocated(self%longest) .or. self%factor >= 1.0_wp) return
      i = part_at(self, t)
      if (.not. self%bound(i) > prevailing*self%passed(i)) return
      longest = self%factor**(1/self%power(i))*self%longest(i)
   end function limit_of_companion

   !> Whether steps that the tolerance has not chosen prevail in the whole run. A run of larger tolerance tells nothing then.
   pure logical function bound_prevail(self)
      class(bound_steps_type), intent(in) :: self
      bound_prevail = .false.
      if (allocated(self%bound)) bound_prevail = sum(self%bound) > prevailing*sum(self%passed)
   end function bound_prevail

   !> Saves or restores it.
   subroutine exchange_bound_steps(self, snapshot)
      class(bound_steps_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%exchange('bound_begin', self%begin)
      call snapshot%exchange('bound_duration', self%duration)
      call snapshot%keep('bound_longest', self%longest)
      call snapshot%keep('bound_time', self%bound)
      call snapshot%keep('bound_passed', self%passed)
      call snapshot%keep('bound_power', self%power)
      ! Not saved: factor
   end subroutine exchange_bound_steps

end module limber_integrator_bound_steps
