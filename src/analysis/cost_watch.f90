!> Change of the integrator during a run. What a unit of time costs is counted, and an integrator that costs more than another would
!> makes way for it. RADAU takes short steps where vibrations are to be followed, and ADAMS may take the same for a third of the
!> cost; ADAMS is bound to rates that the motion no longer shows (limber_analysis_stiffening). One that turns out dearer than what
!> it came for makes way again. Floor: analysis. Source: doc/theory, eqs. (5.62)-(5.64).
module limber_analysis_cost_watch
   use limber_base_kinds, only: wp, long
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text
   use limber_scene_integrator_choice, only: choice_type, look_at_state
   use limber_analysis_stiffening, only: stiffening_type, stiffness_text
   use limber_integrator_adams, only: adams_type
   use limber_integrator_integrator, only: integrator_type
   use limber_integrator_radau, only: radau_type
   use limber_model_model, only: dynamics_type
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: costs_type, watch_costs, stands_in

   !> What an integrator has just begun with says little of it; then it is tried; then it goes on
   integer, parameter :: beginning = 0, trying = 1, settled = 2
   !> Cost that must lie ahead for a change to be worth it [evaluations of ADAMS]; changes after which there are no more
   real(wp), parameter :: worth = 1500.0_wp
   integer, parameter :: most_changes = 20

   !> What a run remembers of its costs
   type :: costs_type
      !> Name of the integrator that runs now; what is to be said of those before, and what was to be said before the last change;
      !> not allocated before the first change
      character(:), allocatable :: now, text, text_before
      !> Changes, and those of them that were taken back
      integer :: changes = 0, returns = 0
      !> Whether the run began with RADAU
      logical :: was_implicit = .false.
      integer :: phase = beginning
      !> Steps before which nothing is done, and before which the other integrator is not tried
      integer(long) :: next = 0, rest = 0
      !> Steps, cost and time at the last look
      integer(long) :: steps = 0
      real(wp) :: cost = 0.0_wp, t = 0.0_wp
      !> Mean step since the look before [time]
      real(wp) :: step = 0.0_wp
      !> Cost of a unit of time by the integrator that runs, and by the other; zero: not known [evaluations of ADAMS/time]
      real(wp) :: rate = 0.0_wp, other = 0.0_wp
   contains
      procedure :: story, tolerance
      procedure :: exchange => exchange_costs
   end type costs_type

contains

   !> Looks at the end of a step whether another integrator is to go on.
   subroutine watch_costs(self, system, work, dynamics, integrator, stiffening, stiff, q, v, changes)
      type(costs_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(dynamics_type), intent(in) :: dynamics
      class(integrator_type), intent(in) :: integrator
      !> What is known of ADAMS at the limit of its stability, and whether the run has been found stiff
      type(stiffening_type), intent(in) :: stiffening
      logical, intent(in) :: stiff
      !> Coordinates and velocities at its time (nq)
      real(wp), intent(in) :: q(:), v(:)
      !> Whether it is to make way for `now`
      logical, intent(out) :: changes
      !> Step in units of the mean one from which on steps grow
      real(wp), parameter :: growing = 1.3_wp
      logical :: returns
      changes = .false.
      if (dynamics%reason == '' .or. dynamics%fixed_step > 0.0_wp) return
      returns = .false.
      associate (unit => system%model%units%time, t => integrator%t, h => integrator%t - integrator%t_before)
         select type (integrator)
         type is (radau_type)
            if (integrator%statistics%steps < self%next) return
            call look_back(self, work, integrator, 15, 45)
            if (self%phase == beginning .or. .not. is_worth(self, dynamics%end - t)) return
            returns = self%phase == trying .and. self%other > 0.0_wp .and. self%rate > self%other
            if (returns .and. h > growing*self%step) then
               ! It damps what ADAMS has kept up
               self%phase = beginning
               return
            end if
            changes = returns
            if (.not. returns .and. integrator%statistics%steps >= self%rest .and. self%rate > self%other) &
               & changes = is_easy(self, system, work, t, q, v)
            if (changes) call make_way(self, integrator, returns, 'ADAMS', 'RADAU up to t = '//as_text(t, 8)// &
               & ', where its steps of '//as_text(h, 2)//' '//unit//' cost more than those of ADAMS at a smaller tolerance')
         type is (adams_type)
            if (stiff .and. integrator%statistics%steps >= self%rest) then
               changes = self%changes < most_changes
               if (changes) call make_way(self, integrator, .false., 'RADAU', stiffness_text(stiffening, unit))
               return
            end if
            if (integrator%statistics%steps < self%next) return
            call look_back(self, work, integrator, 30, 90)
            if (self%phase == beginning .or. .not. is_worth(self, dynamics%end - t)) return
            returns = self%phase == trying .and. self%other > 0.0_wp .and. self%rate > self%other
            changes = returns
            if (self%phase == settled) changes = may_be_dear(self, system, work, integrator, q, v)
            if (changes) call make_way(self, integrator, returns, 'RADAU', 'ADAMS up to t = '//as_text(t, 8)// &
               & ', where its steps of '//as_text(h, 2)//' '//unit//' cost more than those of RADAU')
         end select
      end associate
   end subroutine watch_costs

   !> Whether ADAMS fails where RADAU has made way for it; then RADAU goes on, to the end.
   logical function stands_in(self, integrator)
      type(costs_type), intent(inout) :: self
      class(integrator_type), intent(in) :: integrator
      stands_in = .false.
      if (self%changes == 0) return
      select type (integrator)
      type is (adams_type)
         stands_in = .true.
         call make_way(self, integrator, .false., 'RADAU', 'ADAMS up to t = '//as_text(integrator%t, 8)//', where it fails')
         self%changes = most_changes
      end select
   end function stands_in

   !> Cost of a unit of time since the last look, if there has been one.
   subroutine look_back(self, work, integrator, few, many)
      type(costs_type), intent(inout) :: self
      type(workspace_type), intent(in) :: work
      class(integrator_type), intent(in) :: integrator
      !> Steps of the beginning, and those between looks behind it; more the longer the run has been
      integer, intent(in) :: few, many
      real(wp) :: cost
      associate (steps => integrator%statistics%steps)
         cost = cost_of(integrator, work)
         if (self%next == 0) then
            self%next = steps + few
            return
         end if
         if (self%steps > 0 .and. integrator%t > self%t) then
            self%rate = (cost - self%cost)/(integrator%t - self%t)
            self%step = (integrator%t - self%t)/(steps - self%steps)
         end if
         if (self%steps > 0 .and. self%phase < settled) self%phase = self%phase + 1
         self%steps = steps
         self%cost = cost
         self%t = integrator%t
         self%next = steps + many
         if (self%phase == settled) self%next = steps + max(int(many, long), steps/4)
      end associate
   end subroutine look_back

   !> Counted cost so far in evaluations of ADAMS, each with its factorisation, eq. (5.63).
   pure real(wp) function cost_of(integrator, work)
      class(integrator_type), intent(in) :: integrator
      type(workspace_type), intent(in) :: work
      !> An evaluation without a factorisation
      real(wp), parameter :: residual = 0.4_wp
      cost_of = work%evaluations
      select type (integrator)
      type is (radau_type)
         cost_of = residual*work%evaluations + integrator%statistics%factorisations + integrator%statistics%jacobians
      end select
   end function cost_of

   !> Whether enough lies ahead.
   pure logical function is_worth(self, ahead)
      type(costs_type), intent(in) :: self
      !> Time up to the end
      real(wp), intent(in) :: ahead
      is_worth = self%rate*ahead > worth .and. self%changes < most_changes
   end function is_worth

   !> Whether the steps of RADAU are so short that ADAMS, at the limit of its stability, would cost less, eq. (5.64).
   logical function is_easy(self, system, work, t, q, v)
      type(costs_type), intent(in) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t, q(:), v(:)
      !> Evaluations in the time in which the fastest rate makes one radian, and half as many for doubt
      real(wp), parameter :: each = 3.0_wp
      type(choice_type) :: found
      call look(system, work, t, q, v, found)
      is_easy = each*found%rate() < self%rate
   end function is_easy

   !> Whether ADAMS goes near the limit of its stability, eq. (5.65), or costs much more than RADAU once did.
   logical function may_be_dear(self, system, work, integrator, q, v) result(may)
      type(costs_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(adams_type), intent(in) :: integrator
      real(wp), intent(in) :: q(:), v(:)
      !> Step times fastest rate that is long, and part of the rate of the motion that is much; steps that a run makes at least
      !> until RADAU is tried
      real(wp), parameter :: long_step = 0.2_wp, much = 5.0_wp
      integer(long), parameter :: least = 1000
      type(choice_type) :: found
      if (self%rest == 0) self%rest = least
      associate (steps => integrator%statistics%steps)
         may = self%other > 0.0_wp .and. self%rate > 2*self%other
         if (may .or. steps < self%rest) return
         call look(system, work, integrator%t, q, v, found)
         may = 2*found%rate() > long_step*self%rate .and. found%rate() > much*found%motion
         self%rest = 4*steps
      end associate
   end function may_be_dear

   !> The rates of the scene at a state; the look is not counted.
   subroutine look(system, work, t, q, v, found)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t, q(:), v(:)
      type(choice_type), intent(out) :: found
      integer :: before(2)
      before = [work%evaluations, work%matrix%factorisations]
      call look_at_state(system, work, t, q, v, found)
      work%evaluations = before(1)
      work%matrix%factorisations = before(2)
   end subroutine look

   !> Another integrator is to go on. Before this one is tried again, the steps made so far must be made four times.
   subroutine make_way(self, integrator, returns, name, text)
      type(costs_type), intent(inout) :: self
      class(integrator_type), intent(in) :: integrator
      !> Whether the change before is taken back
      logical, intent(in) :: returns
      !> Of the other; why
      character(*), intent(in) :: name, text
      if (.not. allocated(self%text)) self%text = ''
      if (returns) then
         self%text = self%text_before
         self%returns = self%returns + 1
      else
         self%text_before = self%text
         self%text = self%text//'; '//text
      end if
      self%rest = 4*integrator%statistics%steps
      if (self%changes == 0) self%was_implicit = name == 'ADAMS'
      self%now = name
      self%changes = self%changes + 1
      self%other = self%rate
      self%rate = 0.0_wp
      self%phase = beginning
      self%steps = 0
      self%next = 0
   end subroutine make_way

   !> What is to be said of the changes.
   pure function story(self) result(text)
      class(costs_type), intent(in) :: self
      character(:), allocatable :: text
      text = self%text
      if (self%returns == 1) text = text//'; one trial of the other cost more'
      if (self%returns > 1) text = text//'; '//as_text(self%returns)//' trials of the other cost more'
   end function story

   !> Local error that the integrator that runs now may make: ADAMS keeps with a smaller one what RADAU would have kept.
   pure real(wp) function tolerance(self, asked)
      class(costs_type), intent(in) :: self
      !> TOLERANCE of the deck
      real(wp), intent(in) :: asked
      !> Where the errors of both were alike in random scenes; least that eq. (5.5) knows
      real(wp), parameter :: of_adams = 0.03_wp, least = 1.0e-13_wp
      tolerance = asked
      if (self%was_implicit .and. self%now == 'ADAMS') tolerance = min(asked, max(least, of_adams*asked))
   end function tolerance

   !> Saves or restores its memory.
   subroutine exchange_costs(self, snapshot)
      class(costs_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%keep('integrator_now', self%now)
      call snapshot%keep('integrators_before', self%text)
      call snapshot%keep('integrators_before_that', self%text_before)
      call snapshot%exchange('changes', self%changes)
      call snapshot%exchange('returns', self%returns)
      call snapshot%exchange('was_implicit', self%was_implicit)
      call snapshot%exchange('phase', self%phase)
      call snapshot%exchange('next_look_at_costs', self%next)
      call snapshot%exchange('rest', self%rest)
      call snapshot%exchange('steps_at_look', self%steps)
      call snapshot%exchange('cost', self%cost)
      call snapshot%exchange('t_at_look', self%t)
      call snapshot%exchange('mean_step', self%step)
      call snapshot%exchange('cost_rate', self%rate)
      call snapshot%exchange('cost_before', self%other)
   end subroutine exchange_costs

end module limber_analysis_cost_watch
