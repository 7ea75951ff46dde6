!> Monitor of curves within steps. What a curve does between the ends of a step, neither of which shows it, as a hill that is
!> narrower, is looked for, and the step is done again, shorter. Floor: monitor. Source: doc/theory, eq. (5.57).
module limber_monitor_curve_watch
   use limber_base_kinds, only: wp
   use limber_integrator_integrator, only: integrator_type
   use limber_model_hidden_curve, only: hides
   use limber_multibody_kinematics, only: place_frames, kinematics_type
   use limber_multibody_path_constraints, only: curve_joint_type
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: curve_watch_type, new_curve_watch, begin_curves, go_on_curves, find_hidden

   !> What is remembered of the watched curves
   type :: curve_watch_type
      !> Constraints that hold a point on a curve; none: nothing is done
      integer, allocatable :: joints(:)
      !> Places of the points in the frames of the curves at the start of the step and at its end (2, joints)
      real(wp), allocatable :: from(:, :), to(:, :)
      !> Start of the step: time, coordinates and velocities (nq), work put in before it
      real(wp) :: t = 0.0_wp, w = 0.0_wp
      real(wp), allocatable :: q(:), v(:)
      !> Distance from what is known of a curve that counts, length of the analysis
      real(wp) :: counts = 0.0_wp, duration = 0.0_wp
   end type curve_watch_type

contains

   !> Which curves are watched.
   subroutine new_curve_watch(self, system, duration, tolerance)
      type(curve_watch_type), intent(out) :: self
      type(system_type), intent(in) :: system
      !> Length of the analysis; local error allowed in a step, relative to the scales
      real(wp), intent(in) :: duration, tolerance
      !> Distances that count, in units of the tolerance
      real(wp), parameter :: several = 10.0_wp
      integer :: i
      logical :: watched(size(system%constraints))
      watched = .false.
      do i = 1, size(system%constraints)
         select type (item => system%constraints(i)%item)
         type is (curve_joint_type)
            watched(i) = item%part_of == 0
         end select
      end do
      self%joints = pack([(i, i=1, size(watched))], watched)
      allocate (self%from(2, size(self%joints)), self%to(2, size(self%joints)), source=0.0_wp)
      allocate (self%q(system%layout%nq), self%v(system%layout%nq), source=0.0_wp)
      self%counts = several*tolerance*system%model%length
      self%duration = duration
   end subroutine new_curve_watch

   !> Takes a state for the start of the next step.
   subroutine begin_curves(self, system, work, t, q, v, w)
      type(curve_watch_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Time; coordinates and velocities (nq), work put in
      real(wp), intent(in) :: t, q(:), v(:), w
      call place_frames(system%model, system%layout, t, q, work%kinematics)
      call read_places(self, system, work%kinematics, self%to)
      call go_on_curves(self, t, q, v, w)
   end subroutine begin_curves

   !> Takes the end of the last step for the start of the next one.
   subroutine go_on_curves(self, t, q, v, w)
      type(curve_watch_type), intent(inout) :: self
      !> State there
      real(wp), intent(in) :: t, q(:), v(:), w
      self%t = t
      self%q = q
      self%v = v
      self%w = w
      self%from = self%to
   end subroutine go_on_curves

   !> Where the points are in the frames of their curves.
   subroutine read_places(self, system, kinematics, places)
      type(curve_watch_type), intent(in) :: self
      type(system_type), intent(in) :: system
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(inout) :: places(:, :)
      integer :: i
      do i = 1, size(self%joints)
         select type (item => system%constraints(self%joints(i))%item)
         type is (curve_joint_type)
            call item%place(kinematics, places(:, i))
         end select
      end do
   end subroutine read_places

   !> Whether a curve does something in the last step that its ends do not show, and where the step must end then. A step that is
   !> next to nothing is taken as it is.
   subroutine find_hidden(self, system, work, integrator, hidden, stop)
      type(curve_watch_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      class(integrator_type), intent(inout) :: integrator
      logical, intent(out) :: hidden
      real(wp), intent(out) :: stop
      real(wp), parameter :: shorter = 0.25_wp, least = 1.0e-9_wp
      real(wp) :: q(size(self%q)), v(size(self%q)), w
      integer :: i
      call integrator%interpolate(integrator%t, q, v, w)
      call integrator%complete(system, work, integrator%t, q, v)
      call place_frames(system%model, system%layout, integrator%t, q, work%kinematics)
      call read_places(self, system, work%kinematics, self%to)
      hidden = .false.
      stop = self%t + shorter*(integrator%t - self%t)
      if (integrator%t - self%t <= least*self%duration) return
      do i = 1, size(self%joints)
         select type (item => system%constraints(self%joints(i))%item)
         type is (curve_joint_type)
            hidden = hidden .or. hides(item%curve, self%from(:, i), self%to(:, i), self%counts)
         end select
      end do
   end subroutine find_hidden

end module limber_monitor_curve_watch
