!> All monitors of a run. Models that are used outside their range. Floor: monitor.
module limber_monitor_run_monitor
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_base_error, only: error_type, raise
   use limber_base_text, only: as_text
   use limber_integrator_fold_crossing, only: crossing_type, new_crossing, find_weakest, weak
   use limber_model_model, only: body_type, dynamics_type
   use limber_multibody_plane_vectors, only: cross
   use limber_multibody_equations_of_motion, only: linearise
   use limber_multibody_redundant_constraints, only: constraint_names
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: check_deflections, jump_watch_type, start_watch, watch_velocities, scale_warning, phase_warning, &
      & slip_warning, largest_speed, find_weak

   !> Velocities that change faster than a motion changes them
   type :: jump_watch_type
      !> Velocities at the beginning of a window in time (nq), and that time
      real(wp), allocatable :: v(:)
      real(wp) :: since = 0.0_wp
      !> Time of the last look
      real(wp) :: last = 0.0_wp
      !> Largest speed so far [length/time]
      real(wp) :: speed = 0.0_wp
      !> Way that could be made at that speed so far, relative to the scene
      real(wp) :: way = 0.0_wp
      !> Number of jumps that were reported
      integer :: reported = 0
      !> When the largest speed was; from when on the last part of the run counts, and the largest speed in that
      real(wp) :: peak = 0.0_wp, late = huge(1.0_wp), latest = 0.0_wp
   contains
      procedure :: exchange => exchange_jump_watch
   end type jump_watch_type

contains

   !> An error if a beam deflects by more than its length: no frame can follow that, and mostly the motion diverges.
   subroutine check_deflections(system, t, q, v, error)
      type(system_type), intent(in) :: system
      !> Time; coordinates and velocities (nq)
      real(wp), intent(in) :: t, q(:), v(:)
      !> Which beam, when, why and what to do
      type(error_type), allocatable, intent(out) :: error
      character(:), allocatable :: kind, text
      integer :: i, first, n
      real(wp) :: spin, first_frequency
      do i = 1, size(system%layout%n)
         n = system%layout%n(i)
         if (n == 0 .or. system%model%bodies(i)%reduced%is_exact) cycle
         first = system%layout%q(i) + 4
         associate (body => system%model%bodies(i))
            if (maxval(abs(q(first:first + n - 1)))*body%largest_shape <= body%size) cycle
            if (largest_deflection(body, q(first:first + n - 1)) <= body%size) cycle
            spin = abs(cross(q(first - 2:first - 1), v(first - 2:first - 1)))
            first_frequency = sqrt(minval(body%reduced%omega2))
            kind = trim(merge('frame', 'beam ', body%is_frame))
            text = kind//" '"//body%name//"' deflects by more than its length at t = "//as_text(t, 8)
            if (.not. body%reduced%geometric .and. spin > first_frequency) then
               call raise(error, text//': it diverges, for it rotates at '//as_text(spin, 3)//' rad/'// &
                  & system%model%units%time//', above its first frequency '//as_text(first_frequency, 3)//', and a LINEAR '// &
                  & kind//' is not stiffened by the tension that rotation makes. Use GEOMETRIC='// &
                  & trim(merge('K_G         ', 'EXACT or K_G', body%is_frame)))
            else
               call raise(error, text//': that is outside what one floating frame can describe, or the motion diverges. Look'// &
                  & ' at the history up to there, or use '//trim(merge('LARGE=YES      ', 'GEOMETRIC=EXACT', body%is_frame)))
            end if
            return
         end associate
      end do
   end subroutine check_deflections

   !> Largest displacement of a node of a beam or frame with modes, across or along a beam. Only where the coordinates are so large
   !> that it may matter: it goes through the nodes.
   pure real(wp) function largest_deflection(body, eta) result(largest)
      type(body_type), intent(in) :: body
      !> (n)
      real(wp), intent(in) :: eta(:)
      integer :: i
      largest = 0.0_wp
      if (body%is_frame) then
         do i = 1, size(body%shape, 2)
            largest = max(largest, hypot(dot_product(body%shape(1, i, :), eta), dot_product(body%shape(2, i, :), eta)))
         end do
         return
      end if
      associate (b => body%reduced%bending, field => body%field)
         do i = lbound(field%w, 1), ubound(field%w, 1)
            largest = max(largest, abs(dot_product(field%w(i, :), eta(:b))), abs(dot_product(field%u(i, :), eta(b + 1:))))
         end do
      end associate
   end function largest_deflection

   !> Begins to watch velocities; again after they have been changed on purpose.
   subroutine start_watch(self, t, v)
      type(jump_watch_type), intent(inout) :: self
      !> Time, velocities (nq)
      real(wp), intent(in) :: t, v(:)
      if (.not. allocated(self%v)) allocate (self%v(size(v)))
      self%v = v
      self%since = t
      self%last = t
   end subroutine start_watch

   !> Largest speed of a point of a frame as far from its origin as the scene is long, of all bodies, or of a change of velocities.
   pure real(wp) function largest_speed(system, v) result(speed)
      type(system_type), intent(in) :: system
      !> Velocities (nq)
      real(wp), intent(in) :: v(:)
      integer :: i
      speed = 0.0_wp
      do i = 1, size(system%layout%q)
         if (system%layout%carries(i)) cycle
         associate (first => system%layout%q(i))
            speed = max(speed, abs(v(first)), abs(v(first + 1)))
            if (system%layout%framed(i)) speed = max(speed, system%model%length*norm2(v(first + 2:first + 3)))
         end associate
      end do
   end function largest_speed

   !> Looks whether velocities have changed by half of the largest speed while a body could move by a tenth of the scene only, or in
   !> a single step, and that where branches of the motion meet: then it may have gone over to another branch.
   subroutine watch_velocities(self, system, work, t, q, v, text)
      type(jump_watch_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Time; coordinates and velocities (nq) at the end of a step
      real(wp), intent(in) :: t, q(:), v(:)
      !> What to tell the user; not allocated if there is nothing
      character(:), allocatable, intent(out) :: text
      !> Relative ways: of the window, and before which a motion has hardly begun; relative change of the velocities
      real(wp), parameter :: window = 0.05_wp, begun = 0.2_wp, abrupt = 0.5_wp
      integer, parameter :: most = 3
      real(wp) :: change, largest, way, here
      logical :: seen
      integer :: i, first, body
      largest = 0.0_wp
      here = 0.0_wp
      body = 1
      do i = 1, size(system%layout%q)
         if (system%layout%carries(i)) cycle
         first = system%layout%q(i)
         here = max(here, abs(v(first)), abs(v(first + 1)))
         change = max(abs(v(first) - self%v(first)), abs(v(first + 1) - self%v(first + 1)))
         if (system%layout%framed(i)) then
            here = max(here, system%model%length*sqrt(v(first + 2)**2 + v(first + 3)**2))
            change = max(change, system%model%length*sqrt((v(first + 2) - self%v(first + 2))**2 &
               & + (v(first + 3) - self%v(first + 3))**2))
         end if
         if (change > largest) body = i
         largest = max(largest, change)
      end do
      if (here >= self%speed) self%peak = t
      self%speed = max(self%speed, here)
      if (t >= self%late) self%latest = max(self%latest, here)
      way = (t - self%since)*self%speed/system%model%length
      self%way = self%way + (t - self%last)*self%speed/system%model%length
      seen = way < 2*window .or. (self%since >= self%last .and. way < 10*window)
      if (seen .and. largest > abrupt*self%speed .and. self%reported < most .and. self%way > begun) then
         call explain(system, work, t, q, body, text)
         if (allocated(text)) self%reported = self%reported + 1
         call start_watch(self, t, v)
      else if (way > window) then
         call start_watch(self, t, v)
      end if
      self%last = t
   end subroutine watch_velocities

   !> A warning if the motion was so fast once that errors in units of that speed, which the tolerance is in, are no longer small
   !> beside what follows.
   function scale_warning(self, system, tolerance, t) result(text)
      type(jump_watch_type), intent(in) :: self
      type(system_type), intent(in) :: system
      !> Local error allowed, end of the run
      real(wp), intent(in) :: tolerance, t
      !> Empty if all is well
      character(:), allocatable :: text
      !> Part of the largest speed below which what follows is slow, and of the scene that an error may add up to
      real(wp), parameter :: slow = 1.0e-2_wp, part = 1.0e-2_wp
      text = ''
      if (self%latest >= slow*self%speed .or. tolerance*self%speed*(t - self%peak) <= part*system%model%length) return
      text = 'the largest speed, '//as_text(self%speed, 2)//' at t = '//as_text(self%peak, 8)// &
         & ', sets the scale of the errors: what follows is '//as_text(self%latest/self%speed, 1)//' as fast and is not known'// &
         & ' to the tolerance; use '//system%model%dynamics%finer()//', or two analyses, one for each'
   end function scale_warning

   !> A warning if what turns is no longer where it should be, for the energy that a run has gained or lost lets it turn too fast or
   !> too slowly, eq. (7.3). Where drivers set the pace there is none.
   function phase_warning(system, tolerance, turned, duration, ahead) result(text)
      type(system_type), intent(in) :: system
      !> Local error allowed; angle by which the body has turned that has turned most [rad]; time of the run; time by which the
      !> motion is ahead
      real(wp), intent(in) :: tolerance, turned, duration, ahead
      !> Empty if all is well
      character(:), allocatable :: text
      !> Angle that does not matter [rad]
      real(wp), parameter :: little = 0.02_wp, whole = 2*acos(-1.0_wp)
      real(wp) :: angle
      text = ''
      if (turned < whole .or. size(system%model%drivers) > 0) return
      angle = turned*abs(ahead)/duration
      if (angle <= max(little, tolerance*turned)) return
      text = 'errors of the energy have added up over '//as_text(turned/whole, 2)//' turns: at the end the motion is '// &
         & trim(merge('ahead ', 'behind', ahead > 0.0_wp))//' by about '//as_text(angle, 2)//' rad of its fastest body; use'// &
         & ' TOLERANCE='//as_text(max(1.0e-13_wp, 0.1_wp*tolerance), 1)//' or less'
   end function phase_warning

   !> A warning if velocities at samples are further off what joints and drivers prescribe than the tolerance lets them be, eq.
   !> (5.34). A scene that moves by less than the tolerance in the whole run is at rest: its velocities are round-off.
   function slip_warning(self, system, dynamics, slip, t, own) result(text)
      type(jump_watch_type), intent(in) :: self
      type(system_type), intent(in) :: system
      !> Integrator, tolerance and step
      type(dynamics_type), intent(in) :: dynamics
      !> Largest residuals, their times, and the largest speeds of their sides (constraints)
      real(wp), intent(in) :: slip(:), t(:), own(:)
      !> Empty if all is well
      character(:), allocatable :: text
      !> Number of times that a method of order 2 may have tolerance**(2/3), and the part that matters always
      !> Part of the largest speed that the speed of a side counts as at least
      real(wp), parameter :: many = 100.0_wp, much = 2.0e-2_wp, least = 1.0e-3_wp
      character(:), allocatable :: whose
      real(wp) :: part, allowed, speed, worst, rest
      integer :: i, culprit
      text = ''
      if (.not. self%speed > 0.0_wp) return
      rest = dynamics%tolerance*system%model%length/(dynamics%end - dynamics%start)
      part = 0.0_wp
      culprit = 0
      whose = ''
      do i = 1, size(slip)
         associate (item => system%constraints(i)%item)
            ! Of an angle a length of one
            speed = max(self%speed, rest)*item%scale/system%model%length
            worst = slip(i)/speed
            if (item%rows == 1) worst = slip(i)/max(own(i), least*speed, rest*item%scale/system%model%length)
            if (worst <= part) cycle
            part = worst
            culprit = i
            whose = ' of the largest velocity'
            if (item%rows == 1 .and. own(i) < speed) whose = ' of the largest velocity there'
         end associate
      end do
      if (culprit == 0) return
      allowed = min(many*dynamics%tolerance**(2.0_wp/3), much)
      if (dynamics%fixed_step > 0.0_wp) allowed = much
      if (part <= allowed) return
      text = dynamics%integrator//' does not keep the velocities that '//system%constraints(culprit)%item%label// &
         & ' prescribes: at t = '//as_text(t(culprit), 8)//' they are off by '//as_text(100*part, 2)//' %'//whose//', and'// &
         & ' kinetic energy, work, accelerations and forces with them; use '//dynamics%finer()//', or another INTEGRATOR'
   end function slip_warning

   !> Text about a jump, if constraints have lost their grip there.
   subroutine explain(system, work, t, q, body, text)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      real(wp), intent(in) :: t, q(:)
      !> The body with the largest jump
      integer, intent(in) :: body
      character(:), allocatable, intent(out) :: text
      character(:), allocatable :: names
      real(wp) :: grip
      call find_weak(system, work, t, q, names, grip)
      if (names == '') return
      text = "the velocities of body '"//system%model%bodies(body)%name//"' change abruptly at t = "//as_text(t, 8)// &
         & ', where branches of the motion meet ('//names//' have lost their grip but for '// &
         & as_text(100*grip, 2)//' %): it may have gone over to another branch; compare with INTEGRATOR=ADAMS or '// &
         & system%model%dynamics%finer()
   end subroutine explain

   !> Names of the constraints that have lost their grip at a state, as at a dead centre or a fold; empty if there are none.
   subroutine find_weak(system, work, t, q, names, grip)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Time; coordinates (nq)
      real(wp), intent(in) :: t, q(:)
      character(:), allocatable, intent(out) :: names
      !> How much is left of it; `weak` at most where there are names
      real(wp), intent(out), optional :: grip
      type(crossing_type) :: scratch
      type(error_type), allocatable :: error
      logical :: part(size(system%constraints))
      real(wp) :: strength
      integer :: i
      names = ''
      if (present(grip)) grip = huge(grip)
      if (maxval([0, system%tree%row]) == 0 .or. system%redundant) return
      call linearise(system, work, t, q, error)
      if (allocated(error)) return
      call new_crossing(system, scratch)
      call find_weakest(scratch, system, work, strength)
      if (present(grip)) grip = strength
      if (strength > weak) return
      scratch%weakest = scratch%unit*scratch%weakest
      do i = 1, size(part)
         associate (item => system%constraints(i)%item)
            part(i) = maxval(abs(scratch%weakest(item%first:item%first + item%rows - 1))) > 0.1_wp*maxval(abs(scratch%weakest))
         end associate
      end do
      names = constraint_names(system, part)
   end subroutine find_weak

   !> Saves or restores its memory.
   subroutine exchange_jump_watch(self, snapshot)
      class(jump_watch_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%keep('v', self%v)
      call snapshot%exchange('since', self%since)
      call snapshot%exchange('last', self%last)
      call snapshot%exchange('speed', self%speed)
      call snapshot%exchange('way', self%way)
      call snapshot%exchange('reported', self%reported)
      call snapshot%exchange('peak', self%peak)
      call snapshot%exchange('latest', self%latest)
      ! Not saved: late
   end subroutine exchange_jump_watch

end module limber_monitor_run_monitor
