!> Bodies whose own motion is small beside the scene. Errors are judged by lengths and speeds of all that is connected; what is
!> little there can be much of the motion of a body that loads alone connect with others. In some steps errors of the places of such
!> rigid bodies are found, and compared with how far these move. Floor: analysis. Source: doc/theory, eqs. (5.68), (5.70).
module limber_analysis_own_motions
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text
   use limber_analysis_step_defects, only: defect_type, find_response
   use limber_model_model, only: dynamics_type, ground
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: motions_type, start_motions, note_place, is_due, note_errors, motion_warning

   !> Own motion, in units of the scene, that is small; that is none, and the same in units of the tolerance
   real(wp), parameter :: small = 0.05_wp, none = 1.0e-9_wp, nothing = 0.3_wp
   !> The first steps are all looked at, then one of so many
   integer, parameter :: first = 16, every = 16

   !> What is known of each body
   type :: motions_type
      !> Steps so far
      integer :: steps = 0
      !> Whether a body is looked at: rigid, and loads alone connect it, or those that joints join it with, with others (bodies)
      logical, allocatable :: watched(:)
      !> Smallest and largest x and y [length] (2, bodies)
      real(wp), allocatable :: low(:, :), high(:, :)
      !> Errors of places that add up, at most and at the last look, and the time of that; the largest of those that what is stiff
      !> takes back [length] (bodies)
      real(wp), allocatable :: added(:), now(:), seen(:), stiff(:)
   contains
      procedure :: exchange => exchange_motions
   end type motions_type

contains

   !> Begins.
   subroutine start_motions(self, system, q)
      type(motions_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Coordinates (nq)
      real(wp), intent(in) :: q(:)
      integer :: i, n
      n = size(system%layout%q)
      self%watched = tied_by_loads(system) .and. system%layout%n == 0
      allocate (self%low(2, n), self%high(2, n), self%added(n), self%now(n), self%seen(n), self%stiff(n), &
         & source=0.0_wp)
      do i = 1, n
         self%low(:, i) = q(system%layout%q(i):system%layout%q(i) + 1)
      end do
      self%high = self%low
   end subroutine start_motions

   !> Bodies of groups that joints and drivers make, and that loads connect with other groups (bodies).
   function tied_by_loads(system) result(tied)
      type(system_type), intent(in) :: system
      logical :: tied(size(system%layout%q))
      integer :: group(size(tied)), i, j
      group = [(i, i=1, size(group))]
      do i = 1, size(system%constraints)
         associate (bodies => system%constraints(i)%item%bodies)
            if (any(bodies == ground)) cycle
            where (group == group(bodies(2))) group = group(bodies(1))
         end associate
      end do
      tied = .false.
      do i = 1, size(system%loads)
         associate (bodies => system%loads(i)%item%bodies)
            do j = 2, size(bodies)
               if (any(bodies(j - 1:j) == ground)) cycle
               if (group(bodies(j)) == group(bodies(j - 1))) cycle
               tied = tied .or. group == group(bodies(j)) .or. group == group(bodies(j - 1))
            end do
         end associate
      end do
   end function tied_by_loads

   !> Takes the places at the end of a step.
   pure subroutine note_place(self, system, q)
      type(motions_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: q(:)
      integer :: i
      self%steps = self%steps + 1
      do i = 1, size(self%added)
         if (.not. self%watched(i)) cycle
         associate (at => system%layout%q(i))
            self%low(:, i) = min(self%low(:, i), q(at:at + 1))
            self%high(:, i) = max(self%high(:, i), q(at:at + 1))
         end associate
      end do
   end subroutine note_place

   !> Whether this step is to be looked at: a body moves, but little.
   pure logical function is_due(self, system) result(due)
      type(motions_type), intent(in) :: self
      type(system_type), intent(in) :: system
      integer :: i
      due = any(self%watched)
      if (.not. due) return
      due = .false.
      if (self%steps > first .and. mod(self%steps, every) /= 0) return
      do i = 1, size(self%added)
         due = due .or. moves_little(self, system, i)
      end do
   end function is_due

   !> Whether a rigid body moves, but little beside the scene.
   pure logical function moves_little(self, system, body) result(little)
      type(motions_type), intent(in) :: self
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      real(wp) :: own
      little = self%watched(body)
      if (.not. little) return
      own = own_motion(self, body)
      little = own > max(none, nothing*system%model%dynamics%tolerance)*system%model%length .and. &
         & own < small*system%model%length
   end function moves_little

   !> Half of the way between the places that a body has been at [length].
   pure real(wp) function own_motion(self, body) result(own)
      type(motions_type), intent(in) :: self
      integer, intent(in) :: body
      own = 0.5_wp*maxval(self%high(:, body) - self%low(:, body))
   end function own_motion

   !> Takes the errors of a step, eq. (5.70). Kinematics are left elsewhere.
   subroutine note_errors(self, system, work, defect, t, left)
      type(motions_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(defect_type), intent(inout) :: defect
      !> Time, and what is left of the run
      real(wp), intent(in) :: t, left
      !> Disturbance, in parts of the own motion
      real(wp), parameter :: part = 1.0e-3_wp
      real(wp), dimension(size(defect%q)) :: place, speed, of_place, of_speed
      real(wp) :: along(2), square, damping, disturbed
      integer :: i, at
      logical :: found
      place = 0.0_wp
      do i = 1, size(self%added)
         if (.not. moves_little(self, system, i)) cycle
         at = system%layout%q(i)
         place(at:at + 1) = part*own_motion(self, i)*direction(defect%rates(system%layout%w(i):system%layout%w(i) + 1))
      end do
      speed = place/defect%h
      call find_response(defect, system, work, place, speed, of_place, of_speed, found)
      if (.not. found) return
      do i = 1, size(self%added)
         if (.not. moves_little(self, system, i)) cycle
         at = system%layout%q(i)
         along = direction(place(at:at + 1))
         disturbed = norm2(place(at:at + 1))
         damping = max(0.0_wp, -dot_product(of_speed(at:at + 1), along)*defect%h/disturbed)
         square = max(-dot_product(of_place(at:at + 1), along)/disturbed, spread_of(defect%push(at:at + 1, :))/ &
            & max(spread_of(defect%path(at:at + 1, :)), tiny(square)))
         call add_error(self, i, norm2(defect%places(at:at + 1)), norm2(defect%rates(system%layout%w(i):system%layout%w(i) + 1)), &
            & defect%h, min(square, huge(square)), damping, t, left)
      end do
   end subroutine note_errors

   !> Direction of a vector; along x if it is none.
   pure function direction(vector) result(unit)
      real(wp), intent(in) :: vector(2)
      real(wp) :: unit(2)
      unit = [1.0_wp, 0.0_wp]
      if (norm2(vector) > 0.0_wp) unit = vector/norm2(vector)
   end function direction

   !> Adds what a step errs by, for all since the last look, to what is left of the errors before, eq. (5.70).
   pure subroutine add_error(self, body, place, speed, h, square, damping, t, left)
      type(motions_type), intent(inout) :: self
      integer, intent(in) :: body
      !> Errors of place and speed, length of the step
      real(wp), intent(in) :: place, speed, h
      !> Stiffness and damping by mass
      real(wp), intent(in) :: square, damping
      real(wp), intent(in) :: t, left
      !> Square of the angle by which what a step follows vibrates in it, at most
      real(wp), parameter :: followed = 16.0_wp
      real(wp) :: error, decay, since
      if (h**2*square > followed) then
         self%stiff(body) = max(self%stiff(body), place + speed/(h*square + damping))
         return
      end if
      error = place + speed/max(sqrt(square), damping, 1/max(left, h))
      decay = 0.5_wp*damping
      if (damping**2 > 4*square) decay = square/damping
      since = h
      if (self%steps > first) since = every*h
      if (decay*since > 1.0e-6_wp) then
         error = error*(1 - exp(-decay*since))/(decay*h)
      else
         error = error*since/h
      end if
      self%now(body) = self%now(body)*exp(-decay*(t - self%seen(body))) + error
      self%seen(body) = t
      self%added(body) = max(self%added(body), self%now(body))
   end subroutine add_error

   !> Largest distance of three points.
   pure real(wp) function spread_of(points) result(distance)
      real(wp), intent(in) :: points(2, 3)
      distance = max(norm2(points(:, 2) - points(:, 1)), norm2(points(:, 3) - points(:, 2)), norm2(points(:, 3) - points(:, 1)))
   end function spread_of

   !> A warning if errors are much of the own motion of a body.
   function motion_warning(self, system, dynamics) result(text)
      type(motions_type), intent(in) :: self
      type(system_type), intent(in) :: system
      type(dynamics_type), intent(in) :: dynamics
      !> Empty if all is well
      character(:), allocatable :: text
      !> Part of the own motion that may be off, and that is aimed at
      real(wp), parameter :: allowed = 3.0e-2_wp, aim = 1.0e-2_wp
      real(wp) :: share, most, power
      integer :: i, worst
      text = ''
      most = allowed
      worst = 0
      do i = 1, size(self%added)
         if (.not. moves_little(self, system, i)) cycle
         share = (self%added(i) + self%stiff(i))/own_motion(self, i)
         if (share <= most) cycle
         most = share
         worst = i
      end do
      if (worst == 0) return
      power = 1.0_wp
      if (any(dynamics%integrator == ['ALPHA     ', 'CONSERVING'])) power = 1.5_wp
      text = "body '"//system%model%bodies(worst)%name//"' moves by "//as_text(2*own_motion(self, worst), 2)//' '// &
         & system%model%units%length//' only, little beside the '//as_text(system%model%length, 2)//' '// &
         & system%model%units%length//' of the scene, on whose scale errors are judged: its place may be off by about '// &
         & as_text(100*min(most, 1.0_wp), 2)//' % of its own motion'//trim(merge(' or more', '        ', most > 1.0_wp))// &
         & '; use TOLERANCE='//as_text(max(1.0e-13_wp, dynamics%tolerance*(aim/most)**power), 1)
   end function motion_warning

   !> Saves or restores its memory.
   subroutine exchange_motions(self, snapshot)
      class(motions_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%exchange('own_steps', self%steps)
      call snapshot%keep('own_low', self%low)
      call snapshot%keep('own_high', self%high)
      call snapshot%keep('own_added', self%added)
      call snapshot%keep('own_now', self%now)
      call snapshot%keep('own_seen', self%seen)
      call snapshot%keep('own_stiff', self%stiff)
   end subroutine exchange_motions

end module limber_analysis_own_motions
