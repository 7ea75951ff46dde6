!> Motions of bodies that are small beside the scene. Errors are judged by lengths and speeds of all that is connected; what is
!> little there can be much of the motion of a body that loads alone connect with others, or of its motion beside one of these. In
!> some steps errors of the places of such rigid bodies are found, and compared with how far these move. Floor: analysis.
!> Source: doc/theory, eqs. (5.68), (5.70).
module limber_analysis_own_motions
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text
   use limber_analysis_step_defects, only: defect_type, find_response
   use limber_integrator_error_scales, only: connected_lengths
   use limber_model_model, only: dynamics_type, ground, place_at_distance
   use limber_model_quantities, only: quantity_ax, quantity_ay, quantity_vx, quantity_vy, quantity_x, quantity_y
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: motions_type, start_motions, note_place, is_due, note_errors, motion_warning

   !> Own motion, in units of the length on which errors are judged, that is small, and of a body that is only tied to the ground,
   !> whose speeds are its own; that is none, and the same in units of the tolerance
   real(wp), parameter :: small = 0.05_wp, small_on_ground = 0.01_wp, none = 1.0e-9_wp, nothing = 0.3_wp
   !> Part of the travel of a body that its motion along an axis, or beside a body that hangs on it, is at most
   real(wp), parameter :: of_travel = 0.05_wp
   !> Steps that are looked at, and how many each look stands for; then one of so many
   integer, parameter :: first(8) = [1, 2, 3, 4, 6, 8, 12, 16], stands_for(8) = [1, 1, 1, 1, 2, 2, 4, 4], every = 16

   !> What is known of each motion
   type :: motions_type
      !> Steps so far
      integer :: steps = 0
      !> The motion last looked at by a disturbance of its own
      integer :: looked = 0
      !> Bodies, rigid, and loads alone connect them, or those that joints join them with, with others, or loads hold them on the
      !> ground; and what they are seen from, the ground or one of these others (motions)
      integer, allocatable :: body(:), beside(:)
      !> The axis along which it is looked at, 0: both; of these, and beside a body that a rod joins, only travelling bodies count
      !> (motions)
      integer, allocatable :: axis(:)
      logical, allocatable :: travels(:)
      !> First place of the body [length] (2, motions), and the farthest from there so far (motions)
      real(wp), allocatable :: start(:, :), travel(:)
      !> Length of what is connected with each, on which errors are judged [length] (motions)
      real(wp), allocatable :: length(:)
      !> Part of it that is small (motions)
      real(wp), allocatable :: small(:)
      !> Smallest and largest x and y [length] (2, motions)
      real(wp), allocatable :: low(:, :), high(:, :)
      !> Errors of places that add up, at most and at the last look, and the time of that; the largest of those that what is stiff
      !> takes back [length] (motions)
      real(wp), allocatable :: added(:), now(:), seen(:), stiff(:)
      !> Stiffness and damping by mass at the last look at each; negative: none yet (motions)
      real(wp), allocatable :: square(:), damping(:)
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
      real(wp) :: lengths(size(system%layout%q))
      integer :: i, n
      call find_motions(system, self%body, self%beside, self%small)
      allocate (self%axis(size(self%body)), source=0)
      allocate (self%travels(size(self%body)), source=.false.)
      call add_travelling(self, system)
      lengths = connected_lengths(system)
      self%length = lengths(self%body)
      n = size(self%body)
      allocate (self%low(2, n), self%high(2, n), self%added(n), self%now(n), self%seen(n), self%stiff(n), &
         & source=0.0_wp)
      allocate (self%square(n), self%damping(n), source=-1.0_wp)
      allocate (self%start(2, n), self%travel(n), source=0.0_wp)
      do i = 1, n
         self%start(:, i) = seen_by(system%layout%q, self%body(i), ground, q)
         self%low(:, i) = place_of_motion(self, system, i, q)
      end do
      self%high = self%low
   end subroutine start_motions

   !> Motions that are looked at: of rigid bodies of groups that joints and drivers make, and that loads connect with other groups
   !> or hold on the ground; and of each pair of these that a load connects.
   subroutine find_motions(system, body, beside, part)
      type(system_type), intent(in) :: system
      !> (motions)
      integer, allocatable, intent(out) :: body(:), beside(:)
      real(wp), allocatable, intent(out) :: part(:)
      logical :: tied(size(system%layout%q)), based(size(tied))
      integer :: group(size(tied)), i, j
      group = [(i, i=1, size(group))]
      do i = 1, size(system%constraints)
         associate (bodies => system%constraints(i)%item%bodies)
            if (any(bodies == ground)) cycle
            where (group == group(bodies(2))) group = group(bodies(1))
         end associate
      end do
      tied = .false.
      based = .false.
      allocate (body(0), beside(0))
      do i = 1, size(system%loads)
         associate (bodies => system%loads(i)%item%bodies)
            ! A state of a control is no motion
            if (any(system%layout%carries(pack(bodies, bodies /= ground)))) cycle
            if (system%loads(i)%item%resists .and. (size(bodies) == 1 .or. any(bodies == ground))) &
               & based = based .or. group == group(maxval(bodies))
            do j = 2, size(bodies)
               if (any(bodies(j - 1:j) == ground)) cycle
               if (group(bodies(j)) == group(bodies(j - 1))) cycle
               tied = tied .or. group == group(bodies(j)) .or. group == group(bodies(j - 1))
               if (any(system%layout%n(bodies(j - 1:j)) > 0)) cycle
               if (any(body == maxval(bodies(j - 1:j)) .and. beside == minval(bodies(j - 1:j)))) cycle
               body = [body, maxval(bodies(j - 1:j))]
               beside = [beside, minval(bodies(j - 1:j))]
            end do
         end associate
      end do
      part = [pack(merge(small, small_on_ground, tied), (tied .or. based) .and. system%layout%n == 0), [(small, i=1, size(body))]]
      tied = (tied .or. based) .and. system%layout%n == 0
      body = [pack([(i, i=1, size(tied))], tied), body]
      beside = [[(ground, i=1, count(tied))], beside]
   end subroutine find_motions

   !> Motions of rigid bodies that may travel: along the axis of a place, speed or acceleration that a channel asks for, of two
   !> bodies along the axis of which it asks for both, and of two bodies that a rod joins.
   subroutine add_travelling(self, system)
      type(motions_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      integer :: i, j, axis, found(2), count
      do i = 1, size(system%model%joints)
         if (system%model%joints(i)%place == place_at_distance) call add(system%constraints(i)%item%bodies(1), &
            & system%constraints(i)%item%bodies(2), 0)
      end do
      do i = 1, size(system%model%channels)
         do axis = 1, 2
            count = 0
            found = ground
            associate (asked => system%model%channels(i)%quantities)
               do j = 1, size(asked)
                  if (axis_of(asked(j)%kind) /= axis) cycle
                  if (count < 2) found(count + 1) = system%model%points(asked(j)%of)%body
                  count = count + 1
               end do
            end associate
            if (count == 1) call add(found(1), ground, axis)
            if (count == 2) call add(found(1), found(2), axis)
         end do
      end do

   contains

      subroutine add(one, other, axis)
         integer, intent(in) :: one, other, axis
         integer :: body, beside
         body = max(one, other)
         beside = min(one, other)
         if (body == ground .or. body == beside .or. (beside == ground .and. axis == 0)) return
         if (system%layout%n(body) > 0) return
         if (beside /= ground) then
            if (system%layout%n(beside) > 0) return
         end if
         if (any(self%body == body .and. self%beside == beside .and. (self%axis == axis .or. .not. self%travels))) then
            if (beside /= ground .or. any(self%body == body .and. self%beside == beside .and. self%axis == axis)) return
         end if
         self%body = [self%body, body]
         self%beside = [self%beside, beside]
         self%axis = [self%axis, axis]
         self%travels = [self%travels, .true.]
         self%small = [self%small, small]
      end subroutine add

   end subroutine add_travelling

   !> 1, 2 of a place, speed or acceleration along x, y; 0 of others.
   pure integer function axis_of(kind)
      integer, intent(in) :: kind
      select case (kind)
      case (quantity_x, quantity_vx, quantity_ax); axis_of = 1
      case (quantity_y, quantity_vy, quantity_ay); axis_of = 2
      case default; axis_of = 0
      end select
   end function axis_of

   !> The place of a body, as it is seen from the ground or from another one [length].
   pure function place_of_motion(self, system, motion, q) result(place)
      type(motions_type), intent(in) :: self
      type(system_type), intent(in) :: system
      integer, intent(in) :: motion
      !> Coordinates, or what is in their layout (nq)
      real(wp), intent(in) :: q(:)
      real(wp) :: place(2)
      place = along_axis(self, motion, seen_by(system%layout%q, self%body(motion), self%beside(motion), q))
   end function place_of_motion

   !> What a vector has along the axis of a motion.
   pure function along_axis(self, motion, vector) result(part)
      type(motions_type), intent(in) :: self
      integer, intent(in) :: motion
      real(wp), intent(in) :: vector(2)
      real(wp) :: part(2)
      part = vector
      if (self%axis(motion) > 0) part(3 - self%axis(motion)) = 0.0_wp
   end function along_axis

   !> Two components of a vector of all bodies, less those of the body beside.
   pure function seen_by(first, body, beside, vector) result(seen)
      !> Index of the first component of each body (bodies)
      integer, intent(in) :: first(:)
      integer, intent(in) :: body, beside
      real(wp), intent(in) :: vector(:)
      real(wp) :: seen(2)
      seen = vector(first(body):first(body) + 1)
      if (beside /= ground) seen = seen - vector(first(beside):first(beside) + 1)
   end function seen_by

   !> Takes the places at the end of a step.
   pure subroutine note_place(self, system, q)
      type(motions_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: q(:)
      real(wp) :: place(2)
      integer :: i
      self%steps = self%steps + 1
      do i = 1, size(self%body)
         place = place_of_motion(self, system, i, q)
         self%low(:, i) = min(self%low(:, i), place)
         self%high(:, i) = max(self%high(:, i), place)
         if (self%travels(i)) self%travel(i) = max(self%travel(i), &
            & norm2(seen_by(system%layout%q, self%body(i), ground, q) - self%start(:, i)))
      end do
   end subroutine note_place

   !> Whether this step is to be looked at: a body moves, but little.
   pure logical function is_due(self, system) result(due)
      type(motions_type), intent(in) :: self
      type(system_type), intent(in) :: system
      integer :: i
      due = .false.
      if (.not. any(first == self%steps) .and. mod(self%steps, every) /= 0) return
      do i = 1, size(self%body)
         due = due .or. moves_little(self, system, i)
      end do
   end function is_due

   !> Whether there is a motion, but a little one beside the scene.
   pure logical function moves_little(self, system, motion) result(little)
      type(motions_type), intent(in) :: self
      type(system_type), intent(in) :: system
      integer, intent(in) :: motion
      real(wp) :: own
      own = own_motion(self, motion)
      little = own > max(none, nothing*system%model%dynamics%tolerance)*self%length(motion) .and. &
         & own < self%small(motion)*self%length(motion)
      if (self%travels(motion)) little = own > none*self%length(motion) .and. own < of_travel*self%travel(motion)
   end function moves_little

   !> Half of the way between the places that a body has been at [length].
   pure real(wp) function own_motion(self, motion) result(own)
      type(motions_type), intent(in) :: self
      integer, intent(in) :: motion
      own = 0.5_wp*maxval(self%high(:, motion) - self%low(:, motion))
   end function own_motion

   !> Takes the errors of a step, eq. (5.70). Kinematics are left elsewhere.
   subroutine note_errors(self, system, work, defect, t, left)
      type(motions_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(defect_type), intent(inout) :: defect
      !> Time, and what is left of the run
      real(wp), intent(in) :: t, left
      !> Motions whose stiffness is found again at a look
      integer, parameter :: most = 2
      real(wp) :: rate(2), pushes(2, 3), path(2, 3)
      integer :: i, k, again, before
      logical :: found
      again = 0
      before = self%looked
      do i = 1, size(self%body)
         k = 1 + mod(before + i - 1, size(self%body))
         if (.not. moves_little(self, system, k)) cycle
         if (self%square(k) >= 0.0_wp) then
            if (again == most) cycle
            again = again + 1
            self%looked = k
         end if
         call find_stiffness(self, system, work, defect, k, found)
         if (.not. found) return
      end do
      do i = 1, size(self%body)
         if (.not. moves_little(self, system, i)) cycle
         rate = along_axis(self, i, seen_by(system%layout%w, self%body(i), self%beside(i), defect%rates))
         do k = 1, 3
            pushes(:, k) = place_of_motion(self, system, i, defect%push(:, k))
            path(:, k) = place_of_motion(self, system, i, defect%path(:, k))
         end do
         call add_error(self, i, norm2(place_of_motion(self, system, i, defect%places)), norm2(rate), defect%h, &
            & min(max(self%square(i), spread_of(pushes)/max(spread_of(path), tiny(left))), huge(left)), self%damping(i), t, left)
      end do
   end subroutine note_errors

   !> Stiffness and damping by mass of a motion, from accelerations with its body a little aside.
   subroutine find_stiffness(self, system, work, defect, motion, found)
      type(motions_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(defect_type), intent(inout) :: defect
      integer, intent(in) :: motion
      logical, intent(out) :: found
      !> Disturbance, in parts of the own motion
      real(wp), parameter :: part = 1.0e-3_wp
      real(wp), dimension(size(defect%q)) :: place, speed, of_place, of_speed
      real(wp) :: along(2), aside
      along = direction(along_axis(self, motion, seen_by(system%layout%w, self%body(motion), self%beside(motion), defect%rates)))
      if (self%axis(motion) > 0) along = [real(wp) :: 2 - self%axis(motion), self%axis(motion) - 1]
      aside = part*own_motion(self, motion)
      place = 0.0_wp
      associate (at => system%layout%q(self%body(motion)))
         place(at:at + 1) = aside*along
      end associate
      speed = place/defect%h
      call find_response(defect, system, work, place, speed, of_place, of_speed, found)
      if (.not. found) return
      self%square(motion) = max(0.0_wp, -dot_product(place_of_motion(self, system, motion, of_place), along)/aside)
      self%damping(motion) = max(0.0_wp, -dot_product(place_of_motion(self, system, motion, of_speed), along)*defect%h/aside)
   end subroutine find_stiffness

   !> Direction of a vector; along x if it is none.
   pure function direction(vector) result(unit)
      real(wp), intent(in) :: vector(2)
      real(wp) :: unit(2)
      unit = [1.0_wp, 0.0_wp]
      if (norm2(vector) > 0.0_wp) unit = vector/norm2(vector)
   end function direction

   !> Adds what a step errs by, for all since the last look, to what is left of the errors before, eq. (5.70).
   pure subroutine add_error(self, motion, place, speed, h, square, damping, t, left)
      type(motions_type), intent(inout) :: self
      integer, intent(in) :: motion
      !> Errors of place and speed, length of the step
      real(wp), intent(in) :: place, speed, h
      !> Stiffness and damping by mass
      real(wp), intent(in) :: square, damping
      real(wp), intent(in) :: t, left
      !> Square of the angle by which what a step follows vibrates in it, at most
      real(wp), parameter :: followed = 16.0_wp
      real(wp) :: error, decay, since
      if (h**2*square > followed) then
         self%stiff(motion) = max(self%stiff(motion), place + speed/(h*square + damping))
         return
      end if
      error = place + speed/max(sqrt(square), damping, 1/max(left, h))
      decay = 0.5_wp*damping
      if (damping**2 > 4*square) decay = square/damping
      since = every*h
      if (self%steps <= first(size(first))) since = stands_for(findloc(first, self%steps, dim=1))*h
      if (decay*since > 1.0e-6_wp) then
         error = error*(1 - exp(-decay*since))/(decay*h)
      else
         error = error*since/h
      end if
      self%now(motion) = self%now(motion)*exp(-decay*(t - self%seen(motion))) + error
      self%seen(motion) = t
      self%added(motion) = max(self%added(motion), self%now(motion))
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
      do i = 1, size(self%body)
         if (.not. moves_little(self, system, i)) cycle
         share = (self%added(i) + self%stiff(i))/own_motion(self, i)
         if (share <= most) cycle
         most = share
         worst = i
      end do
      if (worst == 0) return
      power = 1.0_wp
      if (any(dynamics%integrator == ['ALPHA     ', 'CONSERVING'])) power = 1.5_wp
      text = "body '"//system%model%bodies(self%body(worst))%name//"' moves by "//as_text(2*own_motion(self, worst), 2)//' '// &
         & system%model%units%length//' only'
      if (self%axis(worst) > 0) text = text//' along '//trim(merge('x', 'y', self%axis(worst) == 1))
      if (self%beside(worst) /= ground) text = text//" beside body '"//system%model%bodies(self%beside(worst))%name//"'"
      text = text//', little beside the '//as_text(max(self%length(worst), self%travel(worst)), 2)//' '// &
         & system%model%units%length//' and the speeds of the scene, on whose scale errors are judged: its place may be off by'// &
         & ' about '//as_text(100*min(most, 1.0_wp), 2)//' % of that motion'//trim(merge(' or more', '        ', most > 1.0_wp))// &
         & '; use TOLERANCE='//as_text(max(1.0e-13_wp, dynamics%tolerance*(aim/most)**power), 1)
   end function motion_warning

   !> Saves or restores its memory.
   subroutine exchange_motions(self, snapshot)
      class(motions_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%exchange('own_steps', self%steps)
      call snapshot%exchange('own_looked', self%looked)
      call snapshot%keep('own_start', self%start)
      call snapshot%keep('own_travel', self%travel)
      call snapshot%keep('own_low', self%low)
      call snapshot%keep('own_high', self%high)
      call snapshot%keep('own_added', self%added)
      call snapshot%keep('own_now', self%now)
      call snapshot%keep('own_seen', self%seen)
      call snapshot%keep('own_stiff', self%stiff)
      call snapshot%keep('own_square', self%square)
      call snapshot%keep('own_damping', self%damping)
      ! Not saved: body, beside, axis, travels, length, small
   end subroutine exchange_motions

end module limber_analysis_own_motions
