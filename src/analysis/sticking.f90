!> Detection of sticking at laws that jump. Jumps to and fro, and steps that do not get on. Both are counted, so that no run goes on
!> for ever. Floor: analysis. Source: doc/theory, part 5.
module limber_analysis_sticking
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text
   use limber_multibody_motion_laws, only: describe_law
   use limber_multibody_system, only: system_type
   implicit none
   private
   public :: sticking_type, note_step, count_jump

   !> Jumps to and fro that count as sticking, and the part of the time before in which each comes
   integer, parameter :: most_returns = 12
   real(wp), parameter :: tight = 0.01_wp
   !> Steps in a row behind a jump that count as sticking, and anywhere; what part of the whole time each of these is at most
   integer, parameter :: most_crawls = 200, most_ever = 50000
   real(wp), parameter, public :: crawl = 1.0e-9_wp

   !> The last jumps: law, time, time before it that counts as long, and how often it has gone to and fro; steps in a row that
   !> are next to nothing
   type :: sticking_type
      integer :: law = 0, returns = 0, crawls = 0
      real(wp) :: jumped = 0.0_wp, long = 0.0_wp
   contains
      procedure :: exchange => exchange_sticking
   end type sticking_type

contains

   !> Counts steps in a row that are next to nothing. An error if there are too many of them.
   subroutine note_step(self, system, loads, t, h, duration, error)
      type(sticking_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Indices of the watched loads
      integer, intent(in) :: loads(:)
      !> Time at the end of the step, its length, and that of the whole analysis
      real(wp), intent(in) :: t, h, duration
      type(error_type), allocatable, intent(out) :: error
      self%crawls = merge(self%crawls + 1, 0, h < crawl*duration)
      if (self%crawls > most_crawls .and. self%law > 0) then
         call raise_sticking(self, system, loads, error)
      else if (self%crawls > most_ever) then
         call raise(error, 'the steps at t = '//as_text(t, 8)//' are below 1e-9 of the whole time, and do not get on; '// &
            & describe_law(system, loads(1))//' is one that may change abruptly there: write a smooth law, such as '// &
            & 'smoothstep(...) in place of step(...), or give a looser TOLERANCE')
      end if
   end subroutine note_step

   !> Counts a jump of a law. An error if it jumps to and fro ever faster: what it drives sticks.
   subroutine count_jump(self, system, loads, law, t, duration, error)
      type(sticking_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Indices of the watched loads; which of them
      integer, intent(in) :: loads(:), law
      !> Time of the jump; length of the whole analysis
      real(wp), intent(in) :: t, duration
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: since
      since = t - self%jumped
      if (self%law == law .and. since < tight*self%long) then
         self%returns = self%returns + 1
      else
         self%returns = 0
         self%long = max(since, 1.0e-3_wp*duration)
      end if
      self%law = law
      self%jumped = t
      if (self%returns < most_returns) return
      call raise_sticking(self, system, loads, error)
   end subroutine count_jump

   !> Which law, on which body, when, and what to write in its place.
   subroutine raise_sticking(self, system, loads, error)
      type(sticking_type), intent(in) :: self
      type(system_type), intent(in) :: system
      integer, intent(in) :: loads(:)
      type(error_type), allocatable, intent(out) :: error
      call raise(error, describe_law(system, loads(self%law))//' jumps to and fro at t = '//as_text(self%jumped, 8)// &
         & ', for what it drives sticks where it jumps; write a smooth law, such as tanh(v/eps) with a small speed eps in place'// &
         & ' of 2*step(v) - 1')
   end subroutine raise_sticking

   !> Saves or restores what is remembered between steps.
   subroutine exchange_sticking(self, snapshot)
      class(sticking_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%exchange('crossing_law', self%law)
      call snapshot%exchange('crossing_returns', self%returns)
      call snapshot%exchange('crossing_crawls', self%crawls)
      call snapshot%exchange('crossing_jumped', self%jumped)
      call snapshot%exchange('crossing_long', self%long)
   end subroutine exchange_sticking

end module limber_analysis_sticking
