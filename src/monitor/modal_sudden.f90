!> Monitor of bodies with modes under sudden loads. Section forces of vibrations that their coordinates do not have, as parts of the
!> largest ones: these bodies have a sudden load at once at rest, but for the vibrations of their coordinates. Floor: monitor.
!> Source: doc/theory, eqs. (7.26), (7.58)-(7.61).
!>
!>     call start_modal_sudden(self, system, body, lumping)              ! allocates
!>     call observe_modal_sudden(self, system, work, kind, t, q, v, a)   ! at a look, and on both sides of a jump
!>     lost = lost_sections(self)
module limber_monitor_modal_sudden
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_beam_force_recovery, only: internal_forces
   use limber_monitor_function_fading, only: fading_type, fading_of, faded, late_part
   use limber_monitor_function_sudden, only: at_rest, at_start, before_break, behind_break, left_over, opposite, share
   use limber_multibody_system, only: system_type, workspace_type
   use limber_output_internal_forces, only: section_forces_type, start_effort, gather_modal
   implicit none
   private
   public :: modal_sudden_type, start_modal_sudden, observe_modal_sudden, join_modal_sudden, lost_sections

   !> Coordinates from which on the trend of the last ones tells what is behind them
   integer, parameter :: a_trend = 5
   !> How far many vibrations behind the last coordinate go together, in parts of what they make at rest, where signs alternate, and
   !> of the trend; measured on cantilevers under a sudden force, section 7.14
   real(wp), parameter :: together = 2.5_wp

   !> One body with sections; none of its arrays are allocated otherwise
   type :: modal_sudden_type
      !> Index of the body; 0: not watched
      integer :: body = 0
      !> Whether it has coordinates along its axis
      logical :: stretches = .false.
      !> What acts on it
      type(section_forces_type) :: effort
      !> How damping ends the vibration of each coordinate (n), and those behind the last one
      type(fading_type), allocatable :: fading(:)
      type(fading_type) :: fading_behind
      !> Relative error of the frequency of each coordinate by the lumped masses (n)
      real(wp), allocatable :: error(:)
      !> Axial force, shear force and bending moment that a unit coordinate makes, the largest of all sections (3, n)
      real(wp), allocatable :: height(:, :)
      !> Largest amplitude of the vibration of each coordinate, and of what it is late by (n)
      real(wp), allocatable :: most(:), late(:)
      !> Forces by what the coordinates leave out, before a jump; squares of their jumps as far as they have not faded, and the
      !> largest of these (3, sections); the largest forces of all sections (3)
      real(wp), allocatable :: before(:, :), ringing(:, :), jump(:, :)
      real(wp) :: largest(3) = 0.0_wp
      !> Time of the first state, of the last jump, and of the one that left most
      real(wp) :: begun = -huge(1.0_wp), jumped = -huge(1.0_wp), when = -huge(1.0_wp)
   contains
      procedure :: exchange => exchange_modal_sudden
   end type modal_sudden_type

contains

   !> Begins to watch a body with coordinates of its own, if channels ask for its section forces.
   subroutine start_modal_sudden(self, system, body, lumping)
      type(modal_sudden_type), intent(out) :: self
      type(system_type), intent(in) :: system
      !> Index of the body
      integer, intent(in) :: body
      !> Relative errors of the first frequencies by the lumped masses; unallocated if they are not known
      real(wp), allocatable, intent(in) :: lumping(:)
      real(wp) :: ratio(system%layout%n(body))
      integer :: i
      associate (recovery => system%model%bodies(body)%recovery, reduced => system%model%bodies(body)%reduced)
         if (.not. allocated(recovery%load)) return
         self%body = body
         self%stretches = system%model%bodies(body)%is_frame .or. reduced%n > reduced%bending
         call start_effort(self%effort, system, body, recovery)
         ! What geometric forces make is much the same on both sides of a jump
         if (allocated(self%effort%geometric)) deallocate (self%effort%geometric)
         allocate (self%height(3, recovery%n), self%most(recovery%n), self%late(recovery%n), self%error(recovery%n))
         do i = 1, recovery%n
            self%height(:, i) = maxval(abs(recovery%modal(:3, i, :)), dim=2)
         end do
         self%most = 0.0_wp
         self%late = 0.0_wp
         self%error = 0.0_wp
         if (allocated(lumping)) self%error(:size(lumping)) = abs(lumping)
         allocate (self%before(3, size(recovery%sections)), self%ringing(3, size(recovery%sections)), &
            & self%jump(3, size(recovery%sections)))
         self%before = 0.0_wp
         self%ringing = 0.0_wp
         self%jump = 0.0_wp
         ratio = 0.0_wp
         if (allocated(reduced%damping)) ratio = [(0.5_wp*reduced%damping(i, i)/sqrt(reduced%omega2(i)), i=1, reduced%n)]
         self%fading = fading_of(ratio, reduced%omega2)
         i = reduced%bending
         if (i > 0) self%fading_behind = fading_of(minval(ratio(max(1, i - 1):i)), reduced%omega2(i))
      end associate
   end subroutine start_modal_sudden

   !> Takes in a state. Kinematics are placed and moved there; Jacobians and multipliers are those of the state.
   subroutine observe_modal_sudden(self, system, work, kind, t, q, v, a)
      type(modal_sudden_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      !> One of at_rest, ... of limber_monitor_function_sudden
      integer, intent(in) :: kind
      !> Time; coordinates, velocities, accelerations (nq)
      real(wp), intent(in) :: t, q(:), v(:), a(:)
      real(wp), dimension(system%layout%n(self%body)) :: amplitude, none
      real(wp) :: left_out(3, size(self%jump, 2)), part(3)
      real(wp), allocatable :: nothing(:)
      integer :: k, j, first, n
      if (kind == at_rest) return
      call gather_modal(self%effort, system, work, self%body, q, v, a)
      first = system%layout%q(self%body) + 4
      n = size(amplitude)
      none = 0.0_wp
      left_out = 0.0_wp
      associate (recovery => system%model%bodies(self%body)%recovery, omega2 => system%model%bodies(self%body)%reduced%omega2, &
         & eta => q(first:first + n - 1), effort => self%effort)
         amplitude = abs(a(first:first + n - 1))/omega2
         self%most = max(self%most, amplitude)
         if (.not. self%begun > -huge(t)) self%begun = t
         self%late = max(self%late, amplitude*late_part(self%fading, omega2, self%error, t - self%begun, opposite))
         do k = 1, size(left_out, 2)
            self%largest = max(self%largest, abs(internal_forces(recovery, k, eta, effort%amplitude, effort%geometric, &
               & effort%lacking, .false.)))
            if (kind == at_start .or. kind == before_break .or. kind == behind_break) left_out(:, k) = &
               & internal_forces(recovery, k, none, effort%amplitude, effort%geometric, nothing, .false.)
         end do
         select case (kind)
         case (at_start)
            ! Of what is in balance nothing vibrates
            j = (n + 1)/2
            do k = 1, 3
               part(k) = share(dot_product(amplitude(j:), self%height(k, j:)), dot_product(abs(eta(j:)), self%height(k, j:)))
               left_out(k, :) = part(k)*left_out(k, :)
            end do
            call add_jump(self, t, left_out)
         case (before_break)
            self%before = left_out
         case (behind_break)
            call add_jump(self, t, left_out - self%before)
         end select
      end associate
   end subroutine observe_modal_sudden

   !> Adds a jump to what is left of those before.
   pure subroutine add_jump(self, t, jump)
      type(modal_sudden_type), intent(inout) :: self
      real(wp), intent(in) :: t
      !> (3, sections)
      real(wp), intent(in) :: jump(:, :)
      if (self%jumped > -huge(t)) self%ringing = self%ringing*faded(self%fading_behind%fast, t - self%jumped)
      self%ringing = self%ringing + jump**2
      if (maxval(self%ringing) > maxval(self%jump)) self%when = t
      self%jump = max(self%jump, self%ringing)
      self%jumped = t
   end subroutine add_jump

   !> Axial force, shear force and bending moment that are off at most, as parts of the largest (3).
   pure function lost_sections(self) result(lost)
      type(modal_sudden_type), intent(in) :: self
      real(wp) :: lost(3)
      !> Part of the largest force of a unit coordinate below which it has none
      real(wp), parameter :: little = 1.0e-3_wp
      real(wp), allocatable :: trend(:)
      integer :: k
      lost = 0.0_wp
      if (self%body == 0) return
      do k = 1, 3
         lost(k) = sqrt(maxval(self%jump(k, :)))
         ! Those that have such a force
         trend = pack(self%most*self%height(k, :), self%height(k, :) > little*maxval(self%height(k, :)))
         if (size(trend) >= a_trend) lost(k) = max(lost(k), left_over(trend))
         lost(k) = (1 + (together - 1)*self%fading_behind%overshoot)*lost(k) + dot_product(self%late, self%height(k, :))
         lost(k) = lost(k)/max(self%largest(k), lost(k), tiny(1.0_wp))
      end do
      if (.not. self%stretches) lost(1) = 0.0_wp
   end function lost_sections

   !> Joins what an analysis has seen to that of those before.
   subroutine join_modal_sudden(part, whole)
      type(modal_sudden_type), intent(in) :: part
      type(modal_sudden_type), intent(inout) :: whole
      if (part%body == 0) return
      whole%most = max(whole%most, part%most)
      whole%late = max(whole%late, part%late)
      if (maxval(part%jump) > maxval(whole%jump)) whole%when = part%when
      whole%jump = max(whole%jump, part%jump)
      whole%largest = max(whole%largest, part%largest)
   end subroutine join_modal_sudden

   !> Saves or restores it.
   subroutine exchange_modal_sudden(self, snapshot)
      class(modal_sudden_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      if (self%body == 0) return
      call snapshot%keep('most', self%most)
      call snapshot%keep('late', self%late)
      call snapshot%keep('before', self%before)
      call snapshot%keep('ringing', self%ringing)
      call snapshot%keep('jump', self%jump)
      call snapshot%exchange('largest', self%largest)
      call snapshot%exchange('begun', self%begun)
      call snapshot%exchange('jumped', self%jumped)
      call snapshot%exchange('when', self%when)
      ! Not saved: stretches, effort, fading, fading_behind, error, height
   end subroutine exchange_modal_sudden

end module limber_monitor_modal_sudden
