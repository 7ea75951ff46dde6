!> Points of bodies on which joints, drivers and loads act, from names in the deck. Floor: model.
module limber_model_points_of_action
   use limber_base_kinds, only: wp
   use limber_deck_content, only: deck_type, block_type
   use limber_model_joint_kind, only: joint_kinds, joint_kind
   use limber_model_model, only: place_on_beam, place_at_point
   implicit none
   private
   public :: acting_type, enter, enter_pair, along_joint, body_of, point_of, has_pair, line_angle, first_angle, nearly

   !> Smaller sines of the angle between line and axis count as zero
   real(wp), parameter :: nearly = 0.05_wp

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

   !> Adds the points of a joint under a driver, friction or a coupler of its coordinate: couples for a hinge, else forces.
   subroutine along_joint(deck, name, body, points)
      type(deck_type), intent(in) :: deck
      character(*), intent(in) :: name, body
      type(acting_type), allocatable, intent(inout) :: points(:)
      integer :: joint, k
      logical :: turning
      joint = deck%find_named('JOINT', name)
      if (joint == 0) return
      if (.not. has_pair(deck%blocks(joint))) return
      associate (block => deck%blocks(joint), kind => joint_kinds(joint_kind(deck%blocks(joint)%word('TYPE')))%item)
         turning = kind%place == place_at_point .and. .not. kind%keeps_angle
         ! The force of a sliding point acts anywhere along the beam
         do k = 1, merge(1, 2, kind%place == place_on_beam)
            call enter(block%lines(1)%text(k), body, .not. turning, turning, points)
         end do
      end associate
   end subroutine along_joint

   !> Whether a block has exactly one line, with two points.
   pure logical function has_pair(block)
      type(block_type), intent(in) :: block
      has_pair = size(block%lines) == 1
      if (has_pair) has_pair = block%lines(1)%count() >= 2
   end function has_pair

   !> Adds both points of a block with exactly one line of two points.
   subroutine enter_pair(block, body, force, couple, points)
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      logical, intent(in) :: force, couple
      type(acting_type), allocatable, intent(inout) :: points(:)
      integer :: k
      if (.not. has_pair(block)) return
      do k = 1, 2
         call enter(block%lines(1)%text(k), body, force, couple, points)
      end do
   end subroutine enter_pair

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
