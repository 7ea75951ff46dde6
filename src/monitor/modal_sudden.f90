!> Monitor of bodies with modes under sudden and fast loads. Section forces and reactions of vibrations that their coordinates do
!> not have, as parts of the largest ones: these bodies have a load at once at rest, but for the vibrations of their coordinates.
!> Floor: monitor. Source: doc/theory, section 7.14, eqs. (7.26), (7.58)-(7.61).
!>
!>     call start_modal_sudden(self, system, body, lumping)              ! allocates
!>     call observe_modal_sudden(self, system, work, kind, t, q, v, a)   ! at a look, and on both sides of a jump
!>     lost = lost_forces(self)
module limber_monitor_modal_sudden
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_base_error, only: error_type
   use limber_beam_force_recovery, only: recovery_type, internal_forces
   use limber_model_force_sections, only: recover_points
   use limber_model_model, only: driver_angle, driver_joint_angle
   use limber_monitor_function_fading, only: fading_type, fading_of, faded, late_part
   use limber_monitor_function_sudden, only: at_rest, at_start, before_break, behind_break, opposite, share
   use limber_model_quantities, only: quantity_force_x, quantity_force_y, quantity_force_1, quantity_force_2, quantity_moment, &
      & quantity_force, quantity_torque, quantity_tension
   use limber_multibody_system, only: system_type, workspace_type
   use limber_output_internal_forces, only: section_forces_type, start_effort, gather_modal
   use limber_output_joint_forces, only: joint_force, joint_moment, driver_effort
   implicit none
   private
   public :: modal_sudden_type, start_modal_sudden, observe_modal_sudden, join_modal_sudden, lost_forces

   !> Kinds of forces: axial forces, shear forces and bending moments of sections, forces and moments of joints
   integer, parameter, public :: sudden_kinds = 5
   integer, parameter :: of_sections = 3
   !> How far many vibrations behind the last coordinate go together, in parts of what they make at rest, where signs alternate,
   !> and of the trend; measured on cantilevers under a sudden force, section 7.14
   real(wp), parameter :: together = 2.5_wp
   !> Most that the trend of the last coordinates tells of those behind them; by how much a vibration of a band is larger than the
   !> one two before it: one that is more vibrates by itself, as at a resonance
   real(wp), parameter :: most_left = 4.0_wp, alone = 1.5_wp

   !> One body with section forces or reactions that channels ask for; none of its arrays are allocated otherwise
   type :: modal_sudden_type
      !> Index of the body; 0: not watched
      integer :: body = 0
      !> Whether it has coordinates along its axis; number of its vibration modes
      logical :: stretches = .false.
      integer :: modes = 0
      !> What acts on it; joints and drivers whose reactions are asked for, whether forces or moments are; where channels ask for no
      !> section forces, sections at their points
      type(section_forces_type) :: effort
      integer, allocatable :: joints(:), drivers(:)
      logical :: asked(2) = .false.
      type(recovery_type), allocatable :: own
      !> How damping ends the vibration of each coordinate (n), and those behind the last one
      type(fading_type), allocatable :: fading(:)
      type(fading_type) :: fading_behind
      !> Relative error of the frequency of each coordinate: by the lumped masses; one of static functions (n)
      real(wp), allocatable :: error(:)
      !> Force of each kind that a unit coordinate makes, the largest of all sections (3, n)
      real(wp), allocatable :: height(:, :)
      !> Largest amplitude of the vibration of each coordinate, and of what it is late by (n); least and greatest of what it would
      !> be at rest (2, n)
      real(wp), allocatable :: most(:), late(:), range(:, :)
      !> Forces by what the coordinates leave out, before a jump; squares of their jumps as far as they have not faded, and the
      !> largest of these; their least and greatest (3, sections)
      real(wp), allocatable :: before(:, :), ringing(:, :), jump(:, :), least(:, :), greatest(:, :)
      !> The largest forces (kinds)
      real(wp) :: largest(sudden_kinds) = 0.0_wp
      !> Time of the first state, of the last jump, and of the one that left most
      real(wp) :: begun = -huge(1.0_wp), jumped = -huge(1.0_wp), when = -huge(1.0_wp)
   contains
      procedure :: exchange => exchange_modal_sudden
   end type modal_sudden_type

contains

   !> Begins to watch a body with coordinates of its own, if channels ask for its section forces or for those of its joints.
   subroutine start_modal_sudden(self, system, body, lumping)
      type(modal_sudden_type), intent(out) :: self
      type(system_type), intent(in) :: system
      !> Index of the body
      integer, intent(in) :: body
      !> Relative errors of the first frequencies by the lumped masses; unallocated if they are not known
      real(wp), allocatable, intent(in) :: lumping(:)
      real(wp) :: ratio(system%layout%n(body))
      integer :: i, n
      call find_joints(self, system, body)
      if (allocated(system%model%bodies(body)%recovery%load)) then
         call start_sections(self, system, body, system%model%bodies(body)%recovery)
      else
         call start_own(self, system, body)
         if (.not. allocated(self%own)) return
         call start_sections(self, system, body, self%own)
      end if
      associate (reduced => system%model%bodies(body)%reduced)
         self%modes = reduced%modes
         self%stretches = system%model%bodies(body)%is_frame .or. reduced%n > reduced%bending
         n = reduced%n
         allocate (self%most(n), self%late(n), self%error(n), source=0.0_wp)
         allocate (self%range(2, n), source=0.0_wp)
         if (allocated(lumping)) self%error(:size(lumping)) = abs(lumping)
         self%error(reduced%modes + 1:reduced%bending) = 1.0_wp
         ratio = 0.0_wp
         if (allocated(reduced%damping)) ratio = [(0.5_wp*reduced%damping(i, i)/sqrt(reduced%omega2(i)), i=1, n)]
         self%fading = fading_of(ratio, reduced%omega2)
         i = min(max(1, reduced%modes), n)
         if (n > 0) self%fading_behind = fading_of(minval(ratio(max(1, i - 1):i)), reduced%omega2(i))
      end associate
   end subroutine start_modal_sudden

   !> Sections at the points of the joints and drivers whose reactions are asked for, if there are any.
   subroutine start_own(self, system, body)
      type(modal_sudden_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      type(error_type), allocatable :: error
      integer, allocatable :: points(:)
      integer :: i, side
      allocate (points(0))
      do i = 1, size(self%joints)
         associate (item => system%constraints(self%joints(i))%item)
            do side = 1, 2
               if (item%bodies(side) /= body .or. item%points(side) == 0) cycle
               if (item%points(side) > size(system%model%points)) cycle
               if (system%model%points(item%points(side))%member > 0) points = [points, item%points(side)]
            end do
         end associate
      end do
      do i = 1, size(self%drivers)
         associate (driver => system%model%drivers(self%drivers(i)))
            do side = 1, size(driver%points)
               if (driver%points(side) == 0) cycle
               if (system%model%points(driver%points(side))%body /= body) cycle
               if (system%model%points(driver%points(side))%member > 0) points = [points, driver%points(side)]
            end do
         end associate
      end do
      if (size(points) == 0) return
      allocate (self%own)
      call recover_points(system%model, body, points, self%own, error)
      if (allocated(error)) deallocate (self%own)
   end subroutine start_own

   !> Room for the sections.
   subroutine start_sections(self, system, body, recovery)
      type(modal_sudden_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      type(recovery_type), intent(in) :: recovery
      integer :: i
      self%body = body
      call start_effort(self%effort, system, body, recovery)
      ! What geometric forces make is much the same on both sides of a jump
      if (allocated(self%effort%geometric)) deallocate (self%effort%geometric)
      associate (sections => size(recovery%sections))
         allocate (self%height(of_sections, recovery%n))
         do i = 1, recovery%n
            self%height(:, i) = maxval(abs(recovery%modal(:of_sections, i, :)), dim=2)
         end do
         allocate (self%before(of_sections, sections), self%ringing(of_sections, sections), self%jump(of_sections, sections), &
            & self%least(of_sections, sections), self%greatest(of_sections, sections), source=0.0_wp)
      end associate
   end subroutine start_sections

   !> Joints and drivers of a body, if channels ask for what they pass on: reactions of these or other joints, what drivers exert,
   !> and forces of loads on the body.
   pure subroutine find_joints(self, system, body)
      type(modal_sudden_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      integer, parameter :: kinds(*) = [quantity_force_x, quantity_force_y, quantity_force_1, quantity_force_2, quantity_moment, &
         & quantity_force, quantity_torque, quantity_tension]
      integer :: i, j, k
      self%asked = .false.
      associate (model => system%model)
         do i = 1, size(model%channels)
            do j = 1, size(model%channels(i)%quantities)
               associate (quantity => model%channels(i)%quantities(j))
                  if (all(quantity%kind /= kinds)) cycle
                  if (quantity%of_load) then
                     ! A load of the deck may have several parts
                     do k = model%loads(quantity%of)%first, model%loads(quantity%of)%last
                        if (any(system%loads(k)%item%bodies == body)) self%asked(1) = .true.
                     end do
                  else if (quantity%kind /= quantity_moment .and. quantity%kind /= quantity_torque) then
                     self%asked(1) = .true.
                  else if (quantity%kind == quantity_torque .or. quantity%of > size(model%joints)) then
                     self%asked(2) = .true.
                  else if (model%joints(quantity%of)%keeps_angle) then
                     ! That of a hinge is zero
                     self%asked(2) = .true.
                  end if
               end associate
            end do
         end do
         self%joints = pack([(i, i=1, size(model%joints))], [(any(system%constraints(i)%item%bodies == body), &
            & i=1, size(model%joints))])
         j = size(model%joints)
         self%drivers = pack([(i, i=1, size(model%drivers))], [(any(system%constraints(j + i)%item%bodies == body), &
            & i=1, size(model%drivers))])
      end associate
      ! Joints and drivers that pass on no moment to it make moments elsewhere by their forces
      if (self%asked(2) .and. .not. (any(system%model%joints(self%joints)%keeps_angle) .or. &
         & any(system%model%drivers(self%drivers)%kind == driver_angle) .or. &
         & any(system%model%drivers(self%drivers)%kind == driver_joint_angle))) self%asked = [.true., .false.]
      if (any(self%asked)) return
      self%joints = self%joints(:0)
      self%drivers = self%drivers(:0)
   end subroutine find_joints

   !> Takes in a state. Kinematics are placed and moved there; Jacobians and multipliers are those of the state.
   subroutine observe_modal_sudden(self, system, work, kind, t, q, v, a)
      type(modal_sudden_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      !> One of at_rest, ... of limber_monitor_function_sudden
      integer, intent(in) :: kind
      !> Time; coordinates, velocities, accelerations (nq)
      real(wp), intent(in) :: t, q(:), v(:), a(:)
      real(wp), dimension(system%layout%n(self%body)) :: amplitude, still
      real(wp) :: left_out(of_sections, size(self%jump, 2))
      integer :: i, j, first, last
      if (kind == at_rest) return
      first = system%layout%q(self%body) + 4
      last = first - 1 + size(amplitude)
      associate (omega2 => system%model%bodies(self%body)%reduced%omega2, eta => q(first:last))
         still = eta + a(first:last)/omega2
         amplitude = abs(a(first:last))/omega2
         if (.not. self%begun > -huge(t)) then
            self%begun = t
            self%range(1, :) = still
            self%range(2, :) = still
            ! A load at the start has come at once
            if (kind == at_start) self%range = reshape([min(still, eta), max(still, eta)], [2, size(still)], order=[2, 1])
         end if
         self%range(1, :) = min(self%range(1, :), still)
         self%range(2, :) = max(self%range(2, :), still)
         self%most = max(self%most, amplitude)
         self%late = max(self%late, amplitude*late_part(self%fading, omega2, self%error, t - self%begun, opposite))
         do i = 1, size(self%joints)
            if (system%constraints(self%joints(i))%item%rows == 0) cycle
            self%largest(4) = max(self%largest(4), norm2(joint_force(system, work, self%joints(i))))
            self%largest(5) = max(self%largest(5), abs(joint_moment(system, work, self%joints(i), q)))
         end do
         do i = 1, size(self%drivers)
            j = merge(5, 4, any(system%model%drivers(self%drivers(i))%kind == [driver_angle, driver_joint_angle]))
            self%largest(j) = max(self%largest(j), abs(driver_effort(system, work, self%drivers(i))))
         end do
         call gather_modal(self%effort, system, work, self%body, q, v, a)
         if (allocated(self%own)) then
            call take_sections(self, self%own, eta, left_out)
         else
            call take_sections(self, system%model%bodies(self%body)%recovery, eta, left_out)
         end if
      end associate
      select case (kind)
      case (at_start)
         call take_start(self, amplitude, q(first:last), t, left_out)
      case (before_break)
         self%before = left_out
      case (behind_break)
         call add_jump(self, t, left_out - self%before)
      end select
      self%least = min(self%least, left_out)
      self%greatest = max(self%greatest, left_out)
   end subroutine observe_modal_sudden

   !> Section forces, and what the coordinates leave out of them.
   pure subroutine take_sections(self, recovery, eta, left_out)
      type(modal_sudden_type), intent(inout) :: self
      type(recovery_type), intent(in) :: recovery
      !> Coordinates (n); (3, sections)
      real(wp), intent(in) :: eta(:)
      real(wp), intent(out) :: left_out(:, :)
      real(wp), allocatable :: nothing(:)
      real(wp) :: none(size(eta))
      integer :: k
      none = 0.0_wp
      associate (effort => self%effort)
         do k = 1, size(left_out, 2)
            self%largest(:of_sections) = max(self%largest(:of_sections), abs(internal_forces(recovery, k, eta, effort%amplitude, &
               & effort%geometric, effort%lacking, .false.)))
            left_out(:, k) = internal_forces(recovery, k, none, effort%amplitude, effort%geometric, nothing, .false.)
         end do
      end associate
   end subroutine take_sections

   !> The start: of what is in balance nothing vibrates.
   pure subroutine take_start(self, amplitude, eta, t, left_out)
      type(modal_sudden_type), intent(inout) :: self
      !> Vibrations and coordinates (n), time, forces that are left out (3, sections)
      real(wp), intent(in) :: amplitude(:), eta(:), t, left_out(:, :)
      real(wp) :: jump(of_sections, size(left_out, 2))
      integer :: j, k
      j = (size(eta) + 1)/2
      do k = 1, of_sections
         jump(k, :) = share(dot_product(amplitude(j:), self%height(k, j:)), dot_product(abs(eta(j:)), self%height(k, j:))) &
            & *left_out(k, :)
      end do
      self%least = left_out
      self%greatest = left_out
      call add_jump(self, t, jump)
   end subroutine take_start

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

   !> Forces of each kind that are off at most, as parts of the largest (kinds).
   pure function lost_forces(self) result(lost)
      type(modal_sudden_type), intent(in) :: self
      real(wp) :: lost(sudden_kinds)
      integer :: k
      lost = 0.0_wp
      if (self%body == 0) return
      do k = 1, of_sections
         lost(k) = max(sqrt(maxval(self%jump(k, :))), quickness(self, k)*maxval(self%greatest(k, :) - self%least(k, :)), &
            & trend(self, k))
         lost(k) = (1 + (together - 1)*self%fading_behind%overshoot)*lost(k) + dot_product(self%late, self%height(k, :))
      end do
      if (.not. self%stretches) lost(1) = 0.0_wp
      if (self%asked(1)) lost(4) = maxval(lost(1:2))
      if (self%asked(2)) lost(5) = lost(3)
      lost = lost/max(self%largest, lost, tiny(1.0_wp))
   end function lost_forces

   !> How quickly loads change for the last two modes: what vibrates by what would be there at rest, one at most.
   pure real(wp) function quickness(self, kind) result(part)
      type(modal_sudden_type), intent(in) :: self
      integer, intent(in) :: kind
      real(wp) :: vibrating, still
      integer :: j, n
      n = merge(self%modes, size(self%most), self%modes > 0)
      j = max(1, n - 1)
      vibrating = dot_product(self%most(j:n), self%height(kind, j:n))
      still = dot_product(self%range(2, j:n) - self%range(1, j:n), self%height(kind, j:n))
      part = min(1.0_wp, vibrating/max(still, vibrating, tiny(1.0_wp)))
   end function quickness

   !> What vibrations behind the last mode have, if they go on as the last two do after the two before them; from three modes on.
   pure real(wp) function trend(self, kind) result(left)
      type(modal_sudden_type), intent(in) :: self
      integer, intent(in) :: kind
      !> Part of the largest force of a unit coordinate below which it has none
      real(wp), parameter :: little = 1.0e-3_wp
      real(wp), allocatable :: part(:)
      real(wp) :: last, before
      integer :: k, n
      left = 0.0_wp
      associate (height => self%height(kind, :self%modes))
         if (self%modes < 3) return
         part = pack(self%most(:self%modes)*height, height > little*maxval(height))
      end associate
      n = size(part)
      if (n < 3) return
      last = 0.0_wp
      before = 0.0_wp
      do k = max(3, n - 1), n
         last = max(last, min(part(k), alone*part(k - 2)))
         before = max(before, part(k - 2))
      end do
      if (last > 0.0_wp) left = last*min(most_left, last/max(before - last, last/most_left))
   end function trend

   !> Joins what an analysis has seen to that of those before.
   subroutine join_modal_sudden(part, whole)
      type(modal_sudden_type), intent(in) :: part
      type(modal_sudden_type), intent(inout) :: whole
      if (part%body == 0) return
      whole%most = max(whole%most, part%most)
      whole%late = max(whole%late, part%late)
      whole%range(1, :) = min(whole%range(1, :), part%range(1, :))
      whole%range(2, :) = max(whole%range(2, :), part%range(2, :))
      if (maxval(part%jump) > maxval(whole%jump)) whole%when = part%when
      whole%jump = max(whole%jump, part%jump)
      whole%least = min(whole%least, part%least)
      whole%greatest = max(whole%greatest, part%greatest)
      whole%largest = max(whole%largest, part%largest)
   end subroutine join_modal_sudden

   !> Saves or restores it.
   subroutine exchange_modal_sudden(self, snapshot)
      class(modal_sudden_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      if (self%body == 0) return
      call snapshot%keep('most', self%most)
      call snapshot%keep('late', self%late)
      call snapshot%keep('range', self%range)
      call snapshot%keep('before', self%before)
      call snapshot%keep('ringing', self%ringing)
      call snapshot%keep('jump', self%jump)
      call snapshot%keep('least', self%least)
      call snapshot%keep('greatest', self%greatest)
      call snapshot%exchange('largest', self%largest)
      call snapshot%exchange('begun', self%begun)
      call snapshot%exchange('jumped', self%jumped)
      call snapshot%exchange('when', self%when)
      ! Not saved: stretches, modes, effort, joints, drivers, asked, own, fading, fading_behind, error, height
   end subroutine exchange_modal_sudden

end module limber_monitor_modal_sudden
