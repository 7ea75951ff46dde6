!> Restarts of the integrator at jumps. Velocities that drivers or curves change abruptly change as by an impact. Floor: analysis.
!> Source: doc/theory, part 5.
module limber_analysis_fresh_start
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_base_text, only: as_text, newline
   use limber_monitor_indicators, only: looks_at_jumps
   use limber_monitor_function_sudden, only: in_motion, before_break, behind_break
   use limber_analysis_looks, only: observe_state
   use limber_scene_outcome, only: outcome_type, warn
   use limber_scene_sampling, only: sample_type
   use limber_scene_scene, only: scene_type
   use limber_model_quantities, only: quantity_force, quantity_power, quantity_torque
   use limber_scene_speed_jumps, only: demanded_jumps
   use limber_monitor_run_monitor, only: largest_speed
   use limber_integrator_integrator, only: integrator_type
   use limber_model_model, only: ground
   use limber_multibody_equations_of_motion, only: linearise, mechanical_energy, worst_constraint
   use limber_multibody_projection, only: settle
   use limber_multibody_redundant_constraints, only: constraint_names
   use limber_multibody_system, only: system_type
   implicit none
   private
   public :: pass_break, meet_drivers

   !> Part of the speed of the motion above which a change of velocities is told
   real(wp), parameter :: impact = 1.0e-6_wp

contains

   !> Starts the integrator anew at an instant from which other formulas hold. Velocities that a driver changes abruptly change as
   !> by an impact; a position that it changes is an error.
   subroutine pass_break(scene, t, last, of_time, jumps, fastest, integrator, sample, outcome, error)
      type(scene_type), intent(inout) :: scene
      !> The instant, and the time of the last step right before it
      real(wp), intent(in) :: t, last
      !> Whether a law of time changes there; else constraints are left only by what dense output errs
      logical, intent(in) :: of_time
      !> Whether a load may jump there
      logical, intent(in) :: jumps
      !> Largest speed so far [length/time]: where a motion turns back, what is left of its velocities is round-off
      real(wp), intent(in) :: fastest
      class(integrator_type), intent(inout) :: integrator
      type(sample_type), intent(inout) :: sample
      type(outcome_type), intent(inout) :: outcome
      type(error_type), allocatable, intent(out) :: error
      !> Relative residual beyond which a position has jumped
      real(wp), parameter :: jump = 1.0e-8_wp
      !> Part of a step before its end at which a load has not jumped yet
      real(wp), parameter :: aside = 1.0e-4_wp
      real(wp) :: residual, energy(2), before, earlier
      real(wp) :: demanded(size(scene%system%constraints))
      integer :: culprit
      logical :: watched
      associate (system => scene%system, work => scene%work)
         watched = looks_at_jumps(outcome%indicators)
         if (watched .and. jumps) then
            earlier = last
            ! Where a law of the motion jumps, `last` is behind it
            if (.not. of_time) earlier = last - aside*(last - integrator%t_before)
            call integrator%interpolate(earlier, sample%q, sample%v, sample%w)
            call integrator%complete(system, work, earlier, sample%q, sample%v)
            call observe_state(scene, earlier, before_break, sample, outcome)
         end if
         call integrator%interpolate(last, sample%q, sample%v, sample%w)
         call integrator%complete(system, work, last, sample%q, sample%v)
         call demanded_jumps(system, work, nearest(t, -1.0_wp), t, sample%q, demanded)
         call linearise(system, work, t, sample%q, error)
         if (allocated(error)) return
         if (system%nc > 0) then
            call worst_constraint(system, work, culprit, residual)
            if (of_time .and. residual > jump*system%constraints(culprit)%item%scale) then
               call raise(error, system%constraints(culprit)%item%label//' jumps by '//as_text(residual, 3)//' at t = '// &
                  & as_text(t, 8)//'; a motion must be continuous: use smoothstep((t - t0)/duration) in place of a jump')
               return
            end if
         end if
         call mechanical_energy(system, work, sample%q, sample%v, energy(1), energy(2))
         before = sum(energy)
         sample%change = sample%v
         call settle(system, work, t, sample%q, sample%v, sample%a, .true., residual, error)
         if (allocated(error)) return
         call mechanical_energy(system, work, sample%q, sample%v, energy(1), energy(2))
         if (largest_speed(system, of_others(system, sample%v - sample%change)) > impact*max(fastest, largest_speed(system, &
            & sample%v)) .and. &
            & any(demanded > 0.0_wp)) call warn(outcome, impact_text(system, t, demanded > 0.0_wp, sum(energy) - before))
         if (watched) call observe_state(scene, t, merge(behind_break, in_motion, jumps), sample, outcome)
         integrator%work_at_start = sample%w + sum(energy) - before
         associate (dynamics => system%model%dynamics)
            call integrator%start(system, work, t, dynamics%end - dynamics%start, sample%q, sample%v, error)
         end associate
      end associate
   end subroutine pass_break

   !> Brings the state that an analysis before has left onto the drivers and joints, at the instant at which this one begins: its
   !> velocities change as by an impact where drivers change their speed right there.
   subroutine meet_drivers(scene, demanded, kept, error)
      !> With the state and the instant; receives the warning
      type(scene_type), intent(inout) :: scene
      !> Drivers and couplers that change their speed there (constraints)
      logical, intent(in) :: demanded(:)
      !> Whether the velocities are those of a motion
      logical, intent(in) :: kept
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: energy(2), before, residual, change(size(scene%q)), earlier(size(scene%q))
      associate (system => scene%system, work => scene%work)
         earlier = scene%v
         if (kept) call mechanical_energy(system, work, scene%q, scene%v, energy(1), energy(2))
         before = sum(energy, mask=kept)
         call settle(system, work, scene%begin, scene%q, scene%v, change, .true., residual, error)
         if (allocated(error) .or. .not. kept .or. .not. any(demanded)) return
         if (largest_speed(system, of_others(system, scene%v - earlier)) <= impact*max(largest_speed(system, earlier), &
            & largest_speed(system, scene%v))) return
         call mechanical_energy(system, work, scene%q, scene%v, energy(1), energy(2))
         scene%warnings = scene%warnings//'warning: '//impact_text(system, scene%begin, demanded, sum(energy) - before)//newline
      end associate
   end subroutine meet_drivers

   !> Changes of velocity, without those of rigid bodies that drivers move by themselves: a road that a table lifts has no impact,
   !> unless channels ask for the force of its driver.
   pure function of_others(system, change) result(others)
      type(system_type), intent(in) :: system
      !> (nq)
      real(wp), intent(in) :: change(:)
      real(wp) :: others(size(change))
      logical :: alone(size(system%layout%q)), moved(size(system%layout%q))
      integer :: i, side, body
      alone = .true.
      moved = .false.
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            do side = 1, size(item%bodies)
               body = item%bodies(side)
               if (body == ground) cycle
               moved(body) = .true.
               alone(body) = alone(body) .and. item%driven .and. count(item%bodies /= ground) == 1
               alone(body) = alone(body) .and. .not. shows_force(system, i)
            end do
         end associate
      end do
      others = change
      do i = 1, size(system%layout%q)
         if (.not. (alone(i) .and. moved(i)) .or. system%layout%n(i) > 0) cycle
         associate (first => system%layout%q(i))
            others(first:first + 1) = 0.0_wp
            if (system%layout%framed(i)) others(first + 2:first + 3) = 0.0_wp
         end associate
      end do
   end function of_others

   !> Whether a channel asks for the force, torque or power of a driver.
   pure logical function shows_force(system, constraint) result(shows)
      type(system_type), intent(in) :: system
      integer, intent(in) :: constraint
      integer :: i, j
      shows = .false.
      do i = 1, size(system%model%channels)
         associate (asked => system%model%channels(i)%quantities)
            do j = 1, size(asked)
               if (asked(j)%of_load .or. all(asked(j)%kind /= [quantity_force, quantity_torque, quantity_power])) cycle
               shows = shows .or. size(system%model%joints) + asked(j)%of == constraint
            end do
         end associate
      end do
   end function shows_force

   !> What is told of velocities that jump.
   function impact_text(system, t, demanded, energy) result(text)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: t
      !> Drivers and couplers that change their speed (constraints)
      logical, intent(in) :: demanded(:)
      !> Change of the energy
      real(wp), intent(in) :: energy
      character(:), allocatable :: text
      text = 'velocities jump at t = '//as_text(t, 8)//' as by an impact, for '//constraint_names(system, demanded)// &
         & ' changes speed abruptly there; the energy changes by '//as_text(energy, 3)
   end function impact_text

end module limber_analysis_fresh_start
