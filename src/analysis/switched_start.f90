!> Turns of switches in a motion: what acts from then on begins with the same positions. Where joints or drivers close, velocities
!> change as by a plastic impact. Floor: analysis. Source: doc/theory, section 5.20, eqs. (5.73)-(5.75).
module limber_analysis_switched_start
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_base_text, only: as_text
   use limber_multibody_control_states, only: follow_switches
   use limber_multibody_equations_of_motion, only: mechanical_energy
   use limber_multibody_projection, only: settle
   use limber_multibody_switching, only: set_switches, keep_values, missed_positions, find_redundant
   use limber_scene_outcome, only: outcome_type
   use limber_scene_sampling, only: sample_type
   use limber_scene_scene, only: scene_type
   implicit none
   private
   public :: set_states

   !> Part of the scene's length, or angle, by which a joint that closes may miss its position: in tolerances, and at least
   real(wp), parameter :: allowed = 100.0_wp, least = 1.0e-6_wp

contains

   !> Sets all switches at a state, changes its velocities to those that the constraints allow then, and counts the change of energy
   !> as work.
   subroutine set_states(scene, t, on, turning, tolerance, sample, renewed, outcome, error)
      type(scene_type), intent(inout) :: scene
      real(wp), intent(in) :: t
      !> New states (switches)
      logical, intent(in) :: on(:)
      !> Which events turn them (events)
      logical, intent(in) :: turning(:)
      !> Local error allowed in a step
      real(wp), intent(in) :: tolerance
      !> State, and work put in so far; in: right before, out: right behind
      type(sample_type), intent(inout) :: sample
      !> Whether the constraints are others than before
      logical, intent(out) :: renewed
      type(outcome_type), intent(inout) :: outcome
      type(error_type), allocatable, intent(out) :: error
      integer :: rows(size(scene%system%constraints)), i
      real(wp) :: before, residual
      logical :: was_redundant, closes
      associate (system => scene%system, work => scene%work)
         before = energy()
         rows = [(system%constraints(i)%item%rows, i=1, size(rows))]
         was_redundant = system%redundant
         call set_switches(system, work, on, renewed)
         call follow_switches(system, sample%v)
         if (renewed) then
            closes = any([(system%constraints(i)%item%rows > rows(i), i=1, size(rows))])
            if (closes) call keep_values(system, work, rows, t, sample%q)
            if (closes) call check_positions(scene, t, rows, findloc(turning, .true., dim=1), tolerance, sample%q, error)
            if (allocated(error)) return
            if (closes .or. was_redundant) call find_redundant(system, work, t, sample%q, error)
            if (allocated(error)) return
            call settle(system, work, t, sample%q, sample%v, sample%a, .true., residual, error)
            if (allocated(error)) return
         end if
         residual = energy() - before
         sample%w = sample%w + residual
         do i = 1, size(turning)
            if (.not. turning(i)) cycle
            ! The first one stands for all at this instant
            call outcome%events%turn(i, system%on(system%model%events(i)%switch), &
               & merge(residual, 0.0_wp, .not. any(turning(:i - 1))))
         end do
      end associate

   contains

      !> Kinetic and potential energy of all that acts.
      real(wp) function energy()
         real(wp) :: kinetic, potential
         call mechanical_energy(scene%system, scene%work, sample%q, sample%v, kinetic, potential)
         energy = kinetic + potential
      end function energy

   end subroutine set_states

   !> An error where a joint or driver that closes misses its position.
   subroutine check_positions(scene, t, rows, event, tolerance, q, error)
      type(scene_type), intent(inout) :: scene
      real(wp), intent(in) :: t
      !> Numbers of equations before (constraints), index of the first event
      integer, intent(in) :: rows(:), event
      real(wp), intent(in) :: tolerance
      !> Coordinates (nq)
      real(wp), intent(in) :: q(:)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: missed(size(rows)), share
      integer :: i
      share = max(least, allowed*tolerance)
      call missed_positions(scene%system, scene%work, rows, t, q, missed)
      do i = 1, size(missed)
         associate (item => scene%system%constraints(i)%item)
            if (missed(i) <= share*item%scale) cycle
            call raise(error, item%label//" does not close at t = "//as_text(t, 8)//", where event '"// &
               & scene%system%model%events(event)%name//"' lets it act: its position is missed by "// &
               & as_text(missed(i), 3)//', and '//as_text(share*item%scale, 3)//' is allowed; let the event be where the'// &
               & ' position fits')
            return
         end associate
      end do
   end subroutine check_positions

end module limber_analysis_switched_start
