!> Points of bodies on which joints, drivers and loads act. Floor: model.
module limber_model_points_of_action
   use limber_base_kinds, only: wp
   use limber_deck_content, only: deck_type, block_type
   use limber_deck_joint_kinds, only: joint_kinds, joint_kind, place_on_line, place_on_curve, place_on_beam, place_rolling
   implicit none
   private
   public :: acting_type, acting_points, find_shared, find_turning, body_of, point_of, has_pair, line_angle, &
      & first_angle

   !> Smaller sines of the angle between line and axis count as zero; a right angle
   real(wp), parameter :: nearly = 0.05_wp, right_angle = acos(0.0_wp)

   !> A point of a body under joints, drivers or loads
   type :: acting_type
      !> Name of the point without the name of the body
      character(64) :: name = ''
      !> Whether forces and couples act there; whether joints or drivers fix the point, and the rotation of its section
      logical :: force = .false., couple = .false., held = .false., clamped = .false.
      !> True if joints or a driver fix the distance of this inner point from another point of the body: their forces there may
      !> depend on the axial strain between both points. `firm`: both points are joined to the same body, or the ground, so that
      !> they do
      logical :: shared = .false., firm = .false.
   end type acting_type

contains

   !> Points of a body under joints, drivers and loads, each once. Drivers of the frame act at the origin.
   subroutine acting_points(deck, body, points)
      type(deck_type), intent(in) :: deck
      !> Name of the body
      character(*), intent(in) :: body
      type(acting_type), allocatable, intent(out) :: points(:)
      integer :: i
      allocate (points(0))
      do i = 1, size(deck%blocks)
         associate (block => deck%blocks(i))
            select case (block%keyword)
            case ('JOINT'); call of_joint(block, body, points)
            case ('SPRING', 'BUSHING'); call of_spring(block, body, points)
            case ('FORCE'); call enter(block%text('POINT'), body, .true., .false., points)
            case ('TORQUE')
               if (block%has('POINT')) call enter(block%text('POINT'), body, .false., .true., points)
               if (block%has('REACTION')) call enter(block%text('REACTION'), body, .false., .true., points)
               if (block%has('BODY')) call enter(block%name('BODY'), body, .false., .true., points)
            case ('MOTION')
               if (block%has('BODY')) call enter(block%name('BODY'), body, .true., .true., points, .true., .true.)
            case ('DRIVER'); call of_driver(deck, block, body, points)
            case ('FRICTION'); call along_joint(deck, block%name('JOINT'), body, points)
            case ('COUPLER'); call of_coupler(deck, block, body, points)
            end select
         end associate
      end do
   end subroutine acting_points

   !> Index of the first block that drives, loads or couples the frame of a body; 0 if there is none.
   pure integer function find_turning(deck, body) result(found)
      type(deck_type), intent(in) :: deck
      !> Name of the body
      character(*), intent(in) :: body
      integer :: i
      do found = 1, size(deck%blocks)
         associate (block => deck%blocks(found))
            select case (block%keyword)
            case ('MOTION', 'DRIVER', 'TORQUE')
               if (.not. block%has('BODY')) cycle
               if (block%name('BODY') == body) return
            case ('COUPLER')
               do i = 1, size(block%lines)
                  if (block%lines(i)%count() < 3) cycle
                  if (block%lines(i)%text(2) == 'angle' .and. block%lines(i)%text(3) == body) return
               end do
            end select
         end associate
      end do
      found = 0
   end function find_turning

   !> Finds inner points with a fixed distance from another point of the body: by joints and bodies in a loop, by joints and drivers
   !> to the ground, or by a driver of their distance.
   subroutine find_shared(deck, body, inner, points)
      type(deck_type), intent(in) :: deck
      character(*), intent(in) :: body
      !> Whether a point lies within the body, not at its ends (points)
      logical, intent(in) :: inner(:)
      type(acting_type), intent(inout) :: points(:)
      !> Fixed points, and the node of the body at the other side of each
      character(64), allocatable :: own(:)
      integer, allocatable :: partner(:), first(:)
      !> Union-find: representative of each block, and of the ground (0), among all bodies that are joined
      integer :: node(0:size(deck%blocks))
      character(64) :: names(2)
      integer :: i, k
      logical :: mine(2)
      if (.not. any(inner .and. points%force)) return
      allocate (own(0), partner(0))
      node = [(i, i=0, size(deck%blocks))]
      do i = 1, size(deck%blocks)
         associate (block => deck%blocks(i))
            select case (block%keyword)
            case ('JOINT', 'BUSHING')
               if (.not. has_pair(block)) cycle
               if (block%keyword == 'JOINT') then
                  if (.not. holds_along(deck, block, body)) cycle
               end if
               names = [character(64) :: block%lines(1)%text(1), block%lines(1)%text(2)]
            case ('DRIVER')
               if (.not. block%has('POINT')) cycle
               if (.not. (block%has('TO') .or. drives_along(deck, block, body))) cycle
               names = [character(64) :: block%text('POINT'), 'ground.origin']
               if (block%has('TO')) names(2) = block%text('TO')
            case ('MOTION')
               if (.not. block%has('BODY')) cycle
               names = [character(64) :: block%name('BODY'), 'ground.origin']
            case default
               cycle
            end select
            mine = [(body_of(names(k)) == body, k=1, 2)]
            if (.not. any(mine)) call join(block_of(names(1)), block_of(names(2)))
            do k = 1, 2
               if (.not. mine(k)) cycle
               own = [own, point_of(names(k))]
               partner = [partner, block_of(names(3 - k))]
            end do
         end associate
      end do
      allocate (first, source=partner)
      do i = 1, size(own)
         partner(i) = last_of(partner(i))
      end do
      do i = 1, size(own)
         points%shared = points%shared .or. (inner .and. points%name == own(i) .and. &
            & any(partner == partner(i) .and. own /= own(i)))
         points%firm = points%firm .or. (inner .and. points%name == own(i) .and. any(first == first(i) .and. own /= own(i)))
      end do

   contains

      !> Block of the body of a point; 0 for the ground.
      integer function block_of(name)
         character(*), intent(in) :: name
         block_of = deck%find_named('RIGID BODY|BEAM|FRAME|POINT MASS', trim(body_of(name)))
      end function block_of

      !> Representative of a node.
      integer function last_of(from)
         integer, intent(in) :: from
         last_of = from
         do while (node(last_of) /= last_of)
            node(last_of) = node(node(last_of))
            last_of = node(last_of)
         end do
      end function last_of

      !> Joins the sets of two nodes.
      subroutine join(first, second)
         integer, intent(in) :: first, second
         node(last_of(first)) = last_of(second)
      end subroutine join

   end subroutine find_shared

   !> Whether a joint may fix a point along the x axis of a body in its initial position. Wheels do not, nor a line along this axis.
   logical function holds_along(deck, block, body) result(holds)
      type(deck_type), intent(in) :: deck
      !> Block of the joint
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      holds = .false.
      select case (place_of(block))
      case (place_rolling, place_on_beam)
         return
      case (place_on_line)
         holds = abs(sin(line_angle(deck, block, body))) > nearly
      case default
         holds = .true.
      end select
   end function holds_along

   !> Whether a driver of x or y may fix a point along the x axis of a body in its initial position.
   logical function drives_along(deck, block, body)
      type(deck_type), intent(in) :: deck
      !> Block of the driver
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      drives_along = abs(sin(first_angle(deck, body) + merge(right_angle, 0.0_wp, block%word('TYPE') == 'X'))) > nearly
   end function drives_along

   !> Initial angle of the line of a joint from the x axis of a body [rad].
   real(wp) function line_angle(deck, block, body) result(angle)
      type(deck_type), intent(in) :: deck
      !> Block of the joint
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      angle = block%real('ANGLE') + first_angle(deck, body_of(block%lines(1)%text(2))) - first_angle(deck, body)
   end function line_angle

   !> Initial angle of a body in the deck [rad]; 0 for the ground.
   real(wp) function first_angle(deck, body) result(angle)
      type(deck_type), intent(in) :: deck
      character(*), intent(in) :: body
      integer :: at
      angle = 0.0_wp
      at = deck%find_named('RIGID BODY|BEAM|FRAME', trim(body))
      if (at > 0) angle = deck%blocks(at)%real('ANGLE')
   end function first_angle

   !> Name of the body of a point `body.point`. A name without a point is that of the body.
   pure function body_of(text) result(name)
      character(*), intent(in) :: text
      character(64) :: name
      name = text
      if (index(text, '.') > 0) name = text(:index(text, '.') - 1)
   end function body_of

   !> Name of a point without its body; 'origin' if only the body is named.
   pure function point_of(text) result(name)
      character(*), intent(in) :: text
      character(64) :: name
      name = 'origin'
      if (index(text, '.') > 0) name = text(index(text, '.') + 1:)
   end function point_of

   !> Adds the points of a joint.
   subroutine of_joint(block, body, points)
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      type(acting_type), allocatable, intent(inout) :: points(:)
      logical :: couple(2), held, clamped
      if (.not. has_pair(block)) return
      associate (kind => joint_kinds(joint_kind(block%word('TYPE'))))
         couple = kind%keeps_angle .or. kind%place == place_rolling
         couple(2) = couple(2) .or. kind%place == place_on_line .or. kind%place == place_on_curve
         held = .not. any(kind%place == [place_rolling, place_on_beam])
         clamped = kind%keeps_angle
      end associate
      call enter(block%lines(1)%text(1), body, .true., couple(1), points, held, clamped)
      ! The force of a sliding point acts anywhere along the beam
      if (place_of(block) == place_on_beam) return
      call enter(block%lines(1)%text(2), body, .true., couple(2), points, held, clamped)
   end subroutine of_joint

   !> Adds the points of a spring or bushing.
   subroutine of_spring(block, body, points)
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      type(acting_type), allocatable, intent(inout) :: points(:)
      logical :: force, couple
      integer :: k
      if (.not. has_pair(block)) return
      if (block%keyword == 'BUSHING') then
         force = .true.
         couple = block%real('STIFFNESS ROTATION') + block%real('DAMPING ROTATION') > 0
      else
         couple = block%word('TYPE') == 'ROTATIONAL'
         force = .not. couple
      end if
      do k = 1, 2
         call enter(block%lines(1)%text(k), body, force, couple, points)
      end do
   end subroutine of_spring

   !> Adds the points of a driver.
   subroutine of_driver(deck, block, body, points)
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      type(acting_type), allocatable, intent(inout) :: points(:)
      if (block%has('JOINT')) call along_joint(deck, block%name('JOINT'), body, points)
      if (block%has('POINT')) call enter(block%text('POINT'), body, .true., .false., points, .true.)
      if (block%has('TO')) call enter(block%text('TO'), body, .true., .false., points, .true.)
      if (block%has('BODY')) call enter(block%name('BODY'), body, .false., .true., points, .false., .true.)
   end subroutine of_driver

   !> Adds the points of a coupler: those of its joints, and the origins of bodies whose angles it couples.
   subroutine of_coupler(deck, block, body, points)
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      type(acting_type), allocatable, intent(inout) :: points(:)
      integer :: i
      do i = 1, size(block%lines)
         if (block%lines(i)%count() < 3) cycle
         if (block%lines(i)%text(2) == 'angle') then
            call enter(block%lines(i)%text(3), body, .false., .true., points)
         else
            call along_joint(deck, block%lines(i)%text(3), body, points)
         end if
      end do
   end subroutine of_coupler

   !> Adds the points of a joint under a driver, friction or a coupler of its coordinate: couples for a revolute joint, else forces.
   subroutine along_joint(deck, name, body, points)
      type(deck_type), intent(in) :: deck
      character(*), intent(in) :: name, body
      type(acting_type), allocatable, intent(inout) :: points(:)
      integer :: joint, k
      logical :: turning
      joint = deck%find_named('JOINT', name)
      if (joint == 0) return
      if (.not. has_pair(deck%blocks(joint))) return
      associate (block => deck%blocks(joint))
         turning = block%word('TYPE') == 'REVOLUTE'
         ! The force of a sliding point acts anywhere along the beam
         do k = 1, merge(1, 2, place_of(block) == place_on_beam)
            call enter(block%lines(1)%text(k), body, .not. turning, turning, points)
         end do
      end associate
   end subroutine along_joint

   !> Position constraint of a joint: `place_...`.
   pure integer function place_of(block)
      !> Block of the joint
      type(block_type), intent(in) :: block
      place_of = joint_kinds(joint_kind(block%word('TYPE')))%place
   end function place_of

   !> Whether a block has exactly one line, with two points.
   pure logical function has_pair(block)
      type(block_type), intent(in) :: block
      has_pair = size(block%lines) == 1
      if (has_pair) has_pair = block%lines(1)%count() >= 2
   end function has_pair

   !> Adds a point `body.point`, or the origin for a name without a point, if it belongs to this body. For a member `frame/number`
   !> also points of its frame, with '@' before their names.
   subroutine enter(text, body, force, couple, points, held, clamped)
      character(*), intent(in) :: text, body
      logical, intent(in) :: force, couple
      type(acting_type), allocatable, intent(inout) :: points(:)
      !> Whether the point and its section are fixed; default false
      logical, intent(in), optional :: held, clamped
      type(acting_type) :: new
      integer :: dot, i
      character(:), allocatable :: sign
      dot = index(text, '.')
      sign = ''
      i = index(body, '/')
      new%name = 'origin'
      if (dot == 0) then
         if (text /= body .and. text /= body(:max(0, i - 1))) return
         if (text /= body) sign = '@'
         new%name = sign//'origin'
      else
         if (text(:dot - 1) /= body .and. text(:dot - 1) /= body(:max(0, i - 1))) return
         if (text(:dot - 1) /= body) sign = '@'
         new%name = sign//text(dot + 1:)
      end if
      new%force = force
      new%couple = couple
      if (present(held)) new%held = held
      if (present(clamped)) new%clamped = clamped
      do i = 1, size(points)
         if (points(i)%name /= new%name) cycle
         points(i)%force = points(i)%force .or. force
         points(i)%couple = points(i)%couple .or. couple
         points(i)%held = points(i)%held .or. new%held
         points(i)%clamped = points(i)%clamped .or. new%clamped
         return
      end do
      points = [points, new]
   end subroutine enter

end module limber_model_points_of_action
