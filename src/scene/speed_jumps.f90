!> Jumps of prescribed velocities. An impact. Analyses without dynamics in time pass them with finite forces, which is told. Floor:
!> scene. Source: doc/theory, parts 5 and 6.
module limber_scene_speed_jumps
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_base_text, only: as_text
   use limber_scene_outcome, only: outcome_type, warn
   use limber_model_law_breaks, only: find_breaks, changes_between, round_off
   use limber_model_model, only: driver_angle, driver_joint_angle
   use limber_multibody_equations_of_motion, only: position_residual, velocity_residual
   use limber_multibody_kinematics, only: place_frames
   use limber_multibody_multiplier_system, only: place_constraints
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: speed_jumps_type, new_speed_jumps, pass_speed_jumps, tell_speed_jumps, demanded_jumps, begin_behind, refused_speeds

   !> What is remembered
   type :: speed_jumps_type
      !> Instants at which laws of time change their formula, and how many of them are passed
      real(wp), allocatable :: breaks(:)
      integer :: passed = 0
      !> Of each constraint the number of jumps, the time of the first, and the largest (constraints)
      integer, allocatable :: count(:)
      real(wp), allocatable :: first(:), largest(:)
   end type speed_jumps_type

contains

   !> The instants of an analysis.
   subroutine new_speed_jumps(self, system)
      type(speed_jumps_type), intent(out) :: self
      type(system_type), intent(in) :: system
      character(:), allocatable :: restless
      call find_breaks(system%model, self%breaks, restless)
      allocate (self%count(size(system%constraints)), source=0)
      allocate (self%first(size(system%constraints)), self%largest(size(system%constraints)), source=0.0_wp)
   end subroutine new_speed_jumps

   !> Looks at the instants up to a time. Leaves the kinematics placed at one of them if there is any.
   subroutine pass_speed_jumps(self, system, work, t, q, error)
      type(speed_jumps_type), intent(inout) :: self
      type(system_type), intent(inout) :: system
      type(workspace_type), intent(inout) :: work
      !> Time; coordinates then (nq)
      real(wp), intent(in) :: t, q(:)
      !> A driver jumps itself
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: jumps(size(system%constraints))
      integer :: i
      do while (self%passed < size(self%breaks))
         if (self%breaks(self%passed + 1) > t) return
         self%passed = self%passed + 1
         associate (now => self%breaks(self%passed))
            call check_places(system, work, nearest(now, -1.0_wp), now, q, error)
            if (allocated(error)) return
            call demanded_jumps(system, work, nearest(now, -1.0_wp), now, q, jumps)
            do i = 1, size(jumps)
               if (.not. jumps(i) > 0.0_wp) cycle
               self%count(i) = self%count(i) + 1
               if (self%count(i) == 1) self%first(i) = now
               self%largest(i) = max(self%largest(i), jumps(i))
            end do
         end associate
      end do
   end subroutine pass_speed_jumps

   !> The instant at which the present analysis begins: its start, or right behind it where a law changes right there what it asks
   !> of the motion, so that the first state is one of the formulas that follow.
   subroutine begin_behind(system, work, q, follows, begin, jumps, error)
      type(system_type), intent(inout) :: system
      type(workspace_type), intent(inout) :: work
      !> Coordinates (nq)
      real(wp), intent(in) :: q(:)
      !> Whether a motion has come to this time by the formulas before
      logical, intent(in) :: follows
      real(wp), intent(out) :: begin
      !> By how much drivers and couplers ask for other velocities from there on (constraints) [length/time or 1/time]
      real(wp), intent(out) :: jumps(:)
      !> A driver jumps itself
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: width
      associate (dynamics => system%model%dynamics)
         begin = dynamics%start
         jumps = 0.0_wp
         width = round_off(dynamics%start, dynamics%end)
         if (.not. changes_between(system%model, merge(begin - width, begin, follows), begin + width)) return
         call check_places(system, work, merge(begin - width, begin, follows), begin + width, q, error)
         if (allocated(error) .and. follows) return
         call demanded_jumps(system, work, merge(begin - width, begin, follows), begin + width, q, jumps)
         if (allocated(error) .or. any(jumps > 0.0_wp)) begin = begin + width
         if (allocated(error)) deallocate (error)
      end associate
   end subroutine begin_behind

   !> What drivers, couplers and joints refuse of the velocities of a steady rotation.
   subroutine refused_speeds(system, work, t, q, v, rotation, refused)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Time; coordinates and velocities (nq); rate of the rotation [rad/time]
      real(wp), intent(in) :: t
      real(wp), contiguous, intent(in) :: q(:), v(:)
      real(wp), intent(in) :: rotation
      !> Zero where all is well (constraints) [length/time or 1/time]
      real(wp), intent(out) :: refused(:)
      real(wp), parameter :: little = 1.0e-5_wp
      real(wp) :: largest
      integer :: i
      refused = 0.0_wp
      if (system%nc == 0) return
      call place_constraints(system, work, t, q)
      largest = velocity_residual(system, work, v)
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            refused(i) = maxval(abs(work%gamma(item%first:item%first + item%rows - 1)))
            if (refused(i) <= little*item%scale*abs(rotation)) refused(i) = 0.0_wp
         end associate
      end do
   end subroutine refused_speeds

   !> A warning for each driver or coupler that has jumped.
   subroutine tell_speed_jumps(self, system, outcome)
      type(speed_jumps_type), intent(in) :: self
      type(system_type), intent(in) :: system
      type(outcome_type), intent(inout) :: outcome
      character(:), allocatable :: text, units
      integer :: i
      text = ''
      units = ''
      do i = 1, size(self%count)
         if (self%count(i) == 0) cycle
         call find_units(i)
         text = ' at t = '//as_text(self%first(i), 8)//', by '//as_text(self%largest(i), 3)
         if (self%count(i) > 1) text = ' '//as_text(self%count(i))//' times, first at t = '//as_text(self%first(i), 8)// &
            & ', by up to '//as_text(self%largest(i), 3)
         call warn(outcome, system%constraints(i)%item%label//' changes its speed abruptly'//text//units// &
            & ': velocities jump there, which takes an impact that accelerations, reactions, torques and powers lack; round its'// &
            & ' law (smoothstep, INTERPOLATION=SPLINE), or use *DYNAMICS')
      end do

   contains

      !> Of the speed of a driver; none of a coupler, whose terms have units of their own.
      subroutine find_units(i)
         integer, intent(in) :: i
         integer :: driver
         units = ''
         driver = i - size(system%model%joints)
         if (driver < 1 .or. driver > size(system%model%drivers)) return
         units = ' '//system%model%units%length//'/'//system%model%units%time
         if (any(system%model%drivers(driver)%kind == [driver_angle, driver_joint_angle])) units = ' rad/'//system%model%units%time
      end subroutine find_units

   end subroutine tell_speed_jumps

   !> An error where a driver asks for another place right behind an instant than right before it.
   subroutine check_places(system, work, earlier, t, q, error)
      type(system_type), intent(inout) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: earlier, t, q(:)
      type(error_type), allocatable, intent(out) :: error
      !> Relative to the scale of the constraint
      real(wp), parameter :: jump = 1.0e-8_wp
      real(wp) :: before(system%nc), residual
      integer :: i
      if (system%nc == 0) return
      call place_frames(system%model, system%layout, earlier, q, work%kinematics)
      residual = position_residual(system, work)
      before = work%phi(:system%nc)
      call place_frames(system%model, system%layout, t, q, work%kinematics)
      residual = position_residual(system, work)
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            residual = norm2(work%phi(item%first:item%first + item%rows - 1) - before(item%first:item%first + item%rows - 1))
            if (residual <= jump*item%scale) cycle
            call raise(error, item%label//' jumps by '//as_text(residual, 3)//' at t = '//as_text(t, 8)// &
               & '; a motion must be continuous: use smoothstep((t - t0)/duration) in place of a jump')
            return
         end associate
      end do
   end subroutine check_places

   !> By how much drivers and couplers ask for other velocities right behind an instant than right before it.
   subroutine demanded_jumps(system, work, earlier, t, q, jumps)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Time right before and behind; coordinates (nq)
      real(wp), intent(in) :: earlier, t, q(:)
      !> Zero where nothing jumps (constraints) [length/time or 1/time]
      real(wp), intent(out) :: jumps(:)
      real(wp), parameter :: little = 1.0e-7_wp
      real(wp) :: before(system%nc), rest(size(q)), slow, largest
      integer :: i
      jumps = 0.0_wp
      if (system%nc == 0) return
      rest = 0.0_wp
      call place_constraints(system, work, earlier, q)
      largest = velocity_residual(system, work, rest)
      before = work%gamma(:system%nc)
      call place_constraints(system, work, t, q)
      largest = velocity_residual(system, work, rest)
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            ! A driver that turns back has no speed to compare with: then the scale of the constraint, once in the whole run
            slow = item%scale/(system%model%dynamics%end - system%model%dynamics%start)
            associate (old => before(item%first:item%first + item%rows - 1), &
               & new => work%gamma(item%first:item%first + item%rows - 1))
               if (any(abs(new - old) > little*max(abs(new), abs(old), slow))) jumps(i) = maxval(abs(new - old))
            end associate
         end associate
      end do
   end subroutine demanded_jumps

end module limber_scene_speed_jumps
