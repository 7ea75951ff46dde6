!> Limit of steps by turns. Where the deck fixes the step, a warning. Floor: analysis. Source: doc/theory, eq. (3.10).
module limber_analysis_turn_steps
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text
   use limber_multibody_plane_vectors, only: cross
   use limber_multibody_system, only: system_type
   implicit none
   private
   public :: turning_type, start_turning, turn_time, watch_turning

   !> Largest turn in a step [rad]; of a fixed one, above which there is a warning
   real(wp), parameter :: most = 2.0_wp, far = 3.0_wp

   !> The frames at the last state
   type :: turning_type
      !> Speeds (bodies) [rad/time], and how fast they have changed in the last step [rad/time^2]
      real(wp), allocatable :: spin(:), change(:)
      !> Unit vectors (2, bodies)
      real(wp), allocatable :: u(:, :)
      !> Whether speeds are those of steps as a whole, for at their ends they mean nothing
      logical :: means = .false.
      !> Time of the state
      real(wp) :: t = 0.0_wp
      !> Whether there was a warning
      logical :: told = .false.
   contains
      procedure :: exchange => exchange_turning
   end type turning_type

contains

   !> Begins at a state, also behind a jump.
   subroutine start_turning(self, system, t, q, v, means)
      type(turning_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Time; coordinates and velocities (nq)
      real(wp), intent(in) :: t, q(:), v(:)
      !> Whether velocities hold in the mean of a step only
      logical, intent(in) :: means
      integer :: i
      if (.not. allocated(self%spin)) then
         associate (n => size(system%layout%q))
            allocate (self%spin(n), self%change(n), self%u(2, n))
         end associate
      end if
      self%means = means
      self%t = t
      self%change = 0.0_wp
      do i = 1, size(self%spin)
         self%spin(i) = spin_of(system, i, q, v)
         self%u(:, i) = direction_of(system, i, q)
      end do
   end subroutine start_turning

   !> Speed of a frame; 0 of a point.
   pure real(wp) function spin_of(system, body, q, v) result(spin)
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      real(wp), intent(in) :: q(:), v(:)
      integer :: first
      spin = 0.0_wp
      if (.not. system%layout%framed(body)) return
      first = system%layout%q(body) + 2
      spin = cross(q(first:first + 1), v(first:first + 1))
   end function spin_of

   !> Unit vector of a frame; of a point that along x.
   pure function direction_of(system, body, q) result(u)
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      real(wp), intent(in) :: q(:)
      real(wp) :: u(2)
      u = [1.0_wp, 0.0_wp]
      if (system%layout%framed(body)) u = q(system%layout%q(body) + 2:system%layout%q(body) + 3)
   end function direction_of

   !> Time in which no frame turns by more than 2 rad, at its speed and with twice the acceleration of the last step.
   pure real(wp) function turn_time(self) result(longest)
      type(turning_type), intent(in) :: self
      real(wp) :: speed
      integer :: i
      longest = huge(longest)
      do i = 1, size(self%spin)
         speed = 0.5_wp*abs(self%spin(i)) + sqrt(0.25_wp*self%spin(i)**2 + most*self%change(i))
         if (speed > most/longest) longest = most/speed
      end do
   end function turn_time

   !> Takes the end of a step. A step of fixed length may turn a frame so far that it resolves no turn: a warning, once; or an
   !> error where the integrator knows no turn beyond a half.
   subroutine watch_turning(self, system, t, q, v, fixed, text, error)
      type(turning_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Time; coordinates and velocities (nq)
      real(wp), intent(in) :: t, q(:), v(:)
      !> Whether steps have a fixed length
      logical, intent(in) :: fixed
      !> What to tell the user; not allocated if there is nothing
      character(:), allocatable, intent(out) :: text
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: spin, h, u(2)
      integer :: i
      h = t - self%t
      do i = 1, size(self%spin)
         spin = spin_of(system, i, q, v)
         u = direction_of(system, i, q)
         if (self%means .and. h > 0.0_wp .and. .not. fixed) spin = atan2(cross(self%u(:, i), u), dot_product(self%u(:, i), u))/h
         self%u(:, i) = u
         if (fixed .and. .not. self%told .and. h*max(abs(spin), abs(self%spin(i))) > far) then
            self%told = .true.
            text = 'FIXED STEP='//as_text(h, 4)//" turns body '"//system%model%bodies(i)%name//"' by "// &
               & as_text(h*max(abs(spin), abs(self%spin(i))), 3)//' rad in a step at t = '//as_text(t, 6)//', '// &
               & trim(merge('more than half a turn, which CONSERVING cannot follow', &
               & 'and its turns are counted by its speed               ', self%means))// &
               & '; use a step in which it turns by less than 3 rad'
            if (self%means) call raise(error, text)
            if (self%means) deallocate (text)
         end if
         self%change(i) = 0.0_wp
         if (h > 0.0_wp .and. .not. self%means) self%change(i) = abs(spin - self%spin(i))/h
         self%spin(i) = spin
      end do
      self%t = t
   end subroutine watch_turning

   !> Saves or restores it.
   subroutine exchange_turning(self, snapshot)
      class(turning_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%keep('turning_spin', self%spin)
      call snapshot%keep('turning_change', self%change)
      call snapshot%keep('turning_u', self%u)
      call snapshot%exchange('turning_t', self%t)
      call snapshot%exchange('turning_told', self%told)
      ! Not saved: means
   end subroutine exchange_turning

end module limber_analysis_turn_steps
