!> Supports of the ends of beams by joints, drivers and springs. A body that only hangs on the beam supports nothing.
!> Floor: model. Source: doc/theory, eq. (2.49).
module limber_model_held_ends
   use limber_base_kinds, only: wp
   use limber_deck_content, only: deck_type, block_type
   use limber_deck_joint_kinds, only: joint_rack, joint_kinds, joint_kind, place_on_line, place_on_beam, place_rolling
   use limber_model_points_of_action, only: body_of, point_of, has_pair, line_angle, first_angle
   implicit none
   private
   public :: hold_type, holds_of

   !> A smaller component of a direction along an axis counts as zero
   real(wp), parameter :: nearly = 0.05_wp
   logical, parameter :: all_ways(2) = .true.

   !> A point of a body with its support
   type :: hold_type
      !> Name of the point without the name of the body
      character(64) :: name = ''
      !> Whether joints and drivers fix the point along the initial x and y axes of the body (2), and the rotation of the section
      logical :: held(2) = .false., clamped = .false.
      !> Whether the other body hangs here alone, and its mass if it is rigid
      logical :: hangs = .false.
      real(wp) :: mass = 0.0_wp
      !> Transverse stiffness of springs [force/length], rotational stiffness [moment/rad]
      real(wp) :: across = 0.0_wp, turning = 0.0_wp
   end type hold_type

contains

   !> Points of a body with supports or hanging bodies, each once.
   subroutine holds_of(deck, body, holds)
      type(deck_type), intent(in) :: deck
      !> Name of the body
      character(*), intent(in) :: body
      type(hold_type), allocatable, intent(out) :: holds(:)
      integer :: i, k
      allocate (holds(0))
      do i = 1, size(deck%blocks)
         associate (block => deck%blocks(i))
            select case (block%keyword)
            case ('JOINT')
               if (.not. has_pair(block)) cycle
               do k = 1, 2
                  if (body_of(block%lines(1)%text(k)) == body) call of_joint(deck, block, k, holds)
               end do
            case ('DRIVER'); call of_driver(deck, block, body, holds)
            case ('MOTION')
               if (block%name('BODY') == body) call note(hold_type('origin', all_ways, .true.), holds)
            case ('BUSHING', 'SPRING')
               if (.not. has_pair(block)) cycle
               do k = 1, 2
                  if (body_of(block%lines(1)%text(k)) == body) call of_spring(block, point_of(block%lines(1)%text(k)), holds)
               end do
            end select
         end associate
      end do
      ! If nothing else supports the body, the hanging bodies serve as its supports
      if (any((holds%held(1) .or. holds%held(2) .or. holds%clamped .or. holds%across + holds%turning > 0.0_wp) .and. &
         & .not. holds%hangs)) then
         do i = 1, size(holds)
            if (.not. holds(i)%hangs) cycle
            holds(i)%held = .false.
            holds(i)%clamped = .false.
         end do
      else
         holds%mass = 0.0_wp
      end if
   end subroutine holds_of

   !> Adds the support of one side of a joint, or the body that hangs there.
   subroutine of_joint(deck, block, side, holds)
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      integer, intent(in) :: side
      type(hold_type), allocatable, intent(inout) :: holds(:)
      type(hold_type) :: new
      integer :: kind, other
      kind = joint_kind(block%word('TYPE'))
      if (joint_kinds(kind)%place == place_on_beam) return
      new%name = point_of(block%lines(1)%text(side))
      other = deck%find_named('RIGID BODY|BEAM|FRAME|POINT MASS', trim(body_of(block%lines(1)%text(3 - side))))
      if (other > 0) new%hangs = is_alone(deck, deck%blocks(other)%name(), body_of(block%lines(1)%text(side)))
      new%held = joint_kinds(kind)%place /= place_rolling
      ! A line fixes the direction across itself
      if (joint_kinds(kind)%place == place_on_line) then
         associate (angle => line_angle(deck, block, body_of(block%lines(1)%text(side))))
            new%held = abs([sin(angle), cos(angle)]) > nearly
         end associate
      end if
      new%clamped = joint_kinds(kind)%keeps_angle .or. joint_kinds(kind)%place == place_rolling
      if (kind == joint_rack) new%clamped = side == 1
      if (new%hangs) then
         if (any(deck%blocks(other)%keyword == [character(10) :: 'RIGID BODY', 'POINT MASS'])) &
            & new%mass = deck%blocks(other)%real('MASS')
      end if
      call note(new, holds)
   end subroutine of_joint

   !> Whether a body hangs on another one alone: joined to it only, by one joint, without a driver.
   logical function is_alone(deck, name, body)
      type(deck_type), intent(in) :: deck
      !> The hanging body, and the body that carries it
      character(*), intent(in) :: name, body
      character(64) :: ends(2)
      integer :: i, joints
      joints = 0
      is_alone = .false.
      do i = 1, size(deck%blocks)
         associate (block => deck%blocks(i))
            select case (block%keyword)
            case ('JOINT', 'BUSHING')
               if (.not. has_pair(block)) cycle
               ends = [body_of(block%lines(1)%text(1)), body_of(block%lines(1)%text(2))]
               if (all(ends /= name)) cycle
               if (all(ends /= body)) return
               joints = joints + 1
               if (joints > 1) return
            case ('MOTION', 'DRIVER')
               if (block%has('BODY')) then
                  if (block%name('BODY') == name) return
               end if
               if (block%keyword == 'MOTION') cycle
               if (block%has('POINT')) then
                  if (body_of(block%text('POINT')) == name) return
               end if
               if (block%has('TO')) then
                  if (body_of(block%text('TO')) == name) return
               end if
            end select
         end associate
      end do
      is_alone = .true.
   end function is_alone

   !> Adds the support by a driver: of a coordinate at its point, of an angle for the section, at both sides of a joint.
   subroutine of_driver(deck, block, body, holds)
      type(deck_type), intent(in) :: deck
      type(block_type), intent(in) :: block
      character(*), intent(in) :: body
      type(hold_type), allocatable, intent(inout) :: holds(:)
      integer :: joint, k
      if (block%has('BODY')) then
         if (block%name('BODY') == body) call note(hold_type('origin', clamped=.true.), holds)
      end if
      if (block%has('POINT')) then
         if (body_of(block%text('POINT')) == body) call note(hold_type(point_of(block%text('POINT')), ways()), holds)
      end if
      if (block%has('TO')) then
         if (body_of(block%text('TO')) == body) call note(hold_type(point_of(block%text('TO')), all_ways), holds)
      end if
      if (.not. block%has('JOINT') .or. block%word('TYPE') /= 'ANGLE') return
      joint = deck%find_named('JOINT', block%name('JOINT'))
      if (joint == 0) return
      if (.not. has_pair(deck%blocks(joint))) return
      do k = 1, 2
         if (body_of(deck%blocks(joint)%lines(1)%text(k)) == body) &
            & call note(hold_type(point_of(deck%blocks(joint)%lines(1)%text(k)), clamped=.true.), holds)
      end do

   contains

      !> Fixed directions of a driver of x or y, by the angle of the body.
      function ways()
         logical :: ways(2)
         ways = .true.
         if (all(block%word('TYPE') /= [character(1) :: 'X', 'Y'])) return
         associate (angle => first_angle(deck, body))
            ways = abs([cos(angle), sin(angle)]) > nearly
            if (block%word('TYPE') == 'Y') ways = abs([sin(angle), cos(angle)]) > nearly
         end associate
      end function ways
   end subroutine of_driver

   !> Adds the support by springs in known directions.
   subroutine of_spring(block, point, holds)
      type(block_type), intent(in) :: block
      character(*), intent(in) :: point
      type(hold_type), allocatable, intent(inout) :: holds(:)
      type(hold_type) :: new
      new%name = point
      if (block%keyword == 'BUSHING') then
         new%across = max(block%real('STIFFNESS X'), block%real('STIFFNESS Y'))
         new%turning = block%real('STIFFNESS ROTATION')
      else if (block%word('TYPE') == 'ROTATIONAL') then
         new%turning = block%real('STIFFNESS')
      end if
      call note(new, holds)
   end subroutine of_spring

   !> Adds a support to the list, or to the entry of the same point.
   subroutine note(new, holds)
      type(hold_type), intent(in) :: new
      type(hold_type), allocatable, intent(inout) :: holds(:)
      integer :: i
      do i = 1, size(holds)
         associate (old => holds(i))
            if (old%name /= new%name) cycle
            if (old%hangs .neqv. new%hangs) cycle
            old%held = old%held .or. new%held
            old%clamped = old%clamped .or. new%clamped
            old%across = old%across + new%across
            old%turning = old%turning + new%turning
            old%mass = old%mass + new%mass
         end associate
         return
      end do
      holds = [holds, new]
   end subroutine note

end module limber_model_held_ends
