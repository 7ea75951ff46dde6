!> Detection of stiffness in runs of ADAMS. Friction that slows to sticking, a damper that comes into action, a vibration that dies
!> away. The step is bound then to a rate that the motion does not have. The linearised system tells: what INTEGRATOR=AUTO would not
!> begin with, it does not go on with either. Floor: analysis. Source: Shampine and Gordon 1975 (low orders as a sign of stiffness,
!> in their driver DE); doc/theory, eqs. (5.61), (5.62).
module limber_analysis_stiffening
   use limber_base_kinds, only: wp, long
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text
   use limber_scene_integrator_choice, only: choice_type, look_at_state, suits_adams
   use limber_integrator_adams, only: adams_type
   use limber_integrator_integrator, only: integrator_type
   use limber_model_model, only: dynamics_type
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: stiffening_type, watch_stiffness, stiffness_text, stiffness_warning

   !> What a run remembers of it
   type :: stiffening_type
      !> Steps before which there is no look; looks that found the run stiff, and others between them
      integer(long) :: next = 0
      integer :: hits = 0, misses = 0
      !> Whether the deck's choice of ADAMS has been questioned
      logical :: told = .false.
      !> When it was found, the step there [time], fastest vibration [rad/time] and decay [1/time]
      real(wp) :: since = 0.0_wp, step = 0.0_wp, fastest = 0.0_wp, decay = 0.0_wp
      !> Steps that lay ahead then
      real(wp) :: ahead = 0.0_wp
   contains
      procedure :: exchange => exchange_stiffening
   end type stiffening_type

contains

   !> Looks at the end of a step whether the run has turned stiff.
   subroutine watch_stiffness(self, system, work, dynamics, integrator, q, v, turns)
      type(stiffening_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(dynamics_type), intent(in) :: dynamics
      class(integrator_type), intent(in) :: integrator
      !> Coordinates and velocities at its time (nq)
      real(wp), intent(in) :: q(:), v(:)
      !> Whether it is to go over to RADAU
      logical, intent(out) :: turns
      !> Steps of low order in a row that raise a suspicion; steps after which there is a look without any; looks that confirm it,
      !> and others that may lie between; steps that must lie ahead for a change to be worth it, and for a warning
      integer, parameter :: suspicious = 50, many = 2000, enough = 3, others = 3, worth = 1000, dear = 10000
      real(wp) :: ahead
      integer(long) :: steps
      turns = .false.
      select type (integrator)
      type is (adams_type)
         steps = integrator%statistics%steps
         if (steps < self%next .or. self%told .or. dynamics%fixed_step > 0.0_wp) return
         if (integrator%low_orders < suspicious .and. steps < many) return
         ahead = (dynamics%end - integrator%t)/(integrator%t - integrator%t_before)
         if (.not. ahead > worth) return
         self%next = steps + suspicious
         if (is_bound(self, system, work, dynamics, integrator, integrator%low_orders >= suspicious, q, v)) then
            self%hits = self%hits + 1
            if (self%hits < enough) return
         else
            self%misses = self%misses + 1
            if (self%hits > 0 .and. self%misses <= others) return
            self%hits = 0
            self%misses = 0
            ! Looks that find nothing cost less than a hundredth of the run
            self%next = steps + max(1000_long, steps)
            return
         end if
         turns = dynamics%reason /= ''
         if (turns .or. ahead < dear) return
         self%told = .true.
         self%ahead = ahead
      end select
   end subroutine watch_stiffness

   !> A warning if the deck has chosen ADAMS, and its step is bound to what the motion no longer shows; empty if not.
   function stiffness_warning(self, unit) result(text)
      type(stiffening_type), intent(in) :: self
      !> Name of the unit of time
      character(*), intent(in) :: unit
      character(:), allocatable :: text
      text = ''
      if (.not. self%told) return
      text = 'ADAMS is bound to steps of '//as_text(self%step, 2)//' '//unit//' since t = '//as_text(self%since, 6)//' by '// &
         & words(self, unit)//', which the motion no longer shows: up to '//as_text(self%ahead, 2)//' steps lay ahead; use'// &
         & ' INTEGRATOR=AUTO or RADAU'
   end function stiffness_warning

   !> Whether the step is bound to a rate of the linearised system that the tolerance does not ask for, eq. (5.62).
   logical function is_bound(self, system, work, dynamics, integrator, low, q, v) result(bound)
      type(stiffening_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(dynamics_type), intent(in) :: dynamics
      type(adams_type), intent(in) :: integrator
      !> Whether its order is low: else a vibration that bounds it may be there, and only a decay is sure not to be. A hint to the
      !> user may be less sure
      logical, intent(in) :: low
      real(wp), intent(in) :: q(:), v(:)
      !> Step times rate above which the step is as long as the rate lets it be
      real(wp), parameter :: long_step = 0.05_wp
      type(choice_type) :: found
      integer :: before(2)
      before = [work%evaluations, work%matrix%factorisations]
      call look_at_state(system, work, integrator%t, q, v, found)
      work%evaluations = before(1)
      work%matrix%factorisations = before(2)
      self%step = integrator%t - integrator%t_before
      self%since = integrator%t
      self%fastest = found%fastest
      self%decay = found%decay
      if (.not. low .and. dynamics%reason /= '') found%fastest = min(found%fastest, found%motion)
      bound = found%rate()*self%step > long_step .and. .not. suits_adams(found, dynamics%tolerance)
   end function is_bound

   !> What bounds the step.
   pure function words(self, unit) result(text)
      type(stiffening_type), intent(in) :: self
      !> Name of the unit of time
      character(*), intent(in) :: unit
      character(:), allocatable :: text
      type(choice_type) :: found
      found%fastest = self%fastest
      found%decay = self%decay
      text = found%rate_words(unit)
   end function words

   !> Why a run has gone over to RADAU; follows the reason for its first integrator.
   pure function stiffness_text(self, unit) result(text)
      type(stiffening_type), intent(in) :: self
      !> Name of the unit of time
      character(*), intent(in) :: unit
      character(:), allocatable :: text
      text = 'ADAMS up to t = '//as_text(self%since, 8)//', where '//words(self, unit)//' bounds its steps to '// &
         & as_text(self%step, 2)//' '//unit//' and the motion does not show it'
   end function stiffness_text

   !> Saves or restores its memory.
   subroutine exchange_stiffening(self, snapshot)
      class(stiffening_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%exchange('next', self%next)
      call snapshot%exchange('hits', self%hits)
      call snapshot%exchange('misses', self%misses)
      call snapshot%exchange('told', self%told)
      call snapshot%exchange('since', self%since)
      call snapshot%exchange('ahead', self%ahead)
      call snapshot%exchange('step', self%step)
      call snapshot%exchange('fastest', self%fastest)
      call snapshot%exchange('decay', self%decay)
   end subroutine exchange_stiffening

end module limber_analysis_stiffening
