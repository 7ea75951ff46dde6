!> Errors of a step, as its own dense output shows them: what the accelerations along it make of the velocities, and these of the
!> places, beside what the step has. Every integrator is judged by the same. Floor: analysis. Source: doc/theory, eq. (5.68).
module limber_analysis_step_defects
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_integrator_integrator, only: integrator_type
   use limber_multibody_equations_of_motion, only: linearise, accelerations
   use limber_multibody_layout, only: rates_of
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: defect_type, new_defect, begin_step, find_defect, find_response

   !> Start of a step, and its errors
   type :: defect_type
      !> Time, coordinates and velocities at the start (nq)
      real(wp) :: t = 0.0_wp
      real(wp), allocatable :: q(:), v(:)
      !> Length of the step [time]; errors of the rates, rates at its end (nw); errors of the coordinates (nq)
      real(wp) :: h = 0.0_wp
      real(wp), allocatable :: rates(:), w(:), places(:)
      !> Coordinates and accelerations at three places of the step (nq, 3)
      real(wp), allocatable :: path(:, :), push(:, :)
      !> Time of the last of these, and velocities there (nq)
      real(wp), private :: t_path = 0.0_wp
      real(wp), allocatable, private :: trial_v(:)
      !> Scratch: rates (nw), coordinates (nq)
      real(wp), allocatable, private :: part(:), trial_q(:)
   end type defect_type

contains

   !> Room.
   subroutine new_defect(self, system)
      type(defect_type), intent(out) :: self
      type(system_type), intent(in) :: system
      associate (nq => system%layout%nq, nw => system%layout%nw)
         allocate (self%q(nq), self%v(nq), self%places(nq), self%trial_v(nq), self%trial_q(nq), self%rates(nw), self%w(nw), &
            & self%part(nw), source=0.0_wp)
         allocate (self%path(nq, 3), self%push(nq, 3), source=0.0_wp)
      end associate
   end subroutine new_defect

   !> Takes a state for the start of the next step.
   pure subroutine begin_step(self, t, q, v)
      type(defect_type), intent(inout) :: self
      !> Time; coordinates and velocities (nq)
      real(wp), intent(in) :: t, q(:), v(:)
      self%t = t
      self%q = q
      self%v = v
   end subroutine begin_step

   !> Errors of a step up to a state, by the formula of Gauss of order 6, eq. (5.68).
   subroutine find_defect(self, system, work, integrator, t, q, v, found)
      type(defect_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      class(integrator_type), intent(inout) :: integrator
      !> Time; coordinates and velocities (nq)
      real(wp), intent(in) :: t, q(:), v(:)
      !> Whether there are accelerations
      logical, intent(out) :: found
      real(wp), parameter :: place(3) = 0.5_wp + sqrt(0.15_wp)*[-1.0_wp, 0.0_wp, 1.0_wp], weight(3) = [5, 8, 5]/18.0_wp
      type(error_type), allocatable :: error
      real(wp) :: put_in
      integer :: i
      self%h = t - self%t
      found = self%h > 0.0_wp
      if (.not. found) return
      call rates_of(system%layout, self%q, self%v, self%part)
      call rates_of(system%layout, q, v, self%w)
      self%rates = self%w - self%part
      self%places = q - self%q
      do i = 1, 3
         associate (at => self%t + place(i)*self%h)
            self%t_path = at
            call integrator%interpolate(at, self%path(:, i), self%trial_v, put_in)
            call integrator%complete(system, work, at, self%path(:, i), self%trial_v)
            call linearise(system, work, at, self%path(:, i), error)
         end associate
         found = .not. allocated(error)
         if (.not. found) return
         call accelerations(system, work, self%path(:, i), self%trial_v, self%push(:, i))
         call rates_of(system%layout, self%path(:, i), self%push(:, i), self%part)
         self%rates = self%rates - weight(i)*self%h*self%part
         self%places = self%places - weight(i)*self%h*self%trial_v
      end do
   end subroutine find_defect

   !> By how much accelerations change where places, or velocities, change at the last of the three places of the step: what is
   !> stiff, and what is damped. Behind `find_defect`.
   subroutine find_response(self, system, work, place, speed, of_place, of_speed, found)
      type(defect_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Changes of the coordinates and of the velocities (nq)
      real(wp), intent(in) :: place(:), speed(:)
      !> Changes of the accelerations by each (nq)
      real(wp), intent(out) :: of_place(:), of_speed(:)
      logical, intent(out) :: found
      type(error_type), allocatable :: error
      call linearise(system, work, self%t_path, self%path(:, 3), error)
      found = .not. allocated(error)
      if (.not. found) return
      self%trial_v = self%trial_v + speed
      call accelerations(system, work, self%path(:, 3), self%trial_v, of_speed)
      of_speed = of_speed - self%push(:, 3)
      self%trial_v = self%trial_v - speed
      self%trial_q = self%path(:, 3) + place
      call linearise(system, work, self%t_path, self%trial_q, error)
      found = .not. allocated(error)
      if (.not. found) return
      call accelerations(system, work, self%trial_q, self%trial_v, of_place)
      of_place = of_place - self%push(:, 3)
   end subroutine find_response

end module limber_analysis_step_defects
