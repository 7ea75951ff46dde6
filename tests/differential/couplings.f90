!> Joints, drivers, loads and channels of a scene that is invented.
module couplings
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, newline
   use chances, only: pick, between, decades, likely
   use drafts, only: draft_type, add, add_channel, place_of, ref, t, new_name, add_ground, is_ground, is_rigid, is_point, &
      & is_beam, is_frame
   use views, only: of_place, of_vector, of_number, of_change
   implicit none
   private
   public :: add_joint, add_rod, add_spring, hold_by_spring, add_bushing, add_turning_spring, add_force, add_torque, &
      & add_spread_load, add_friction, drive_angle, add_gravity, ask_bodies, ask_system, law_of_time

   !> Groups of channels
   integer, parameter, public :: places = 1, speeds = 2, accelerations = 3, forces = 4, moments = 5, energies = 6, angles = 7, &
      & spins = 8, deflections = 9, rotations = 10, stresses = 11, powers = 12, others = 13

contains

   !> A joint of two points that stand together, or on a line.
   subroutine add_joint(name, draft, type, first, one, second, two, direction, plain)
      character(:), allocatable, intent(out) :: name
      type(draft_type), intent(inout) :: draft
      character(*), intent(in) :: type
      !> Bodies and their points
      integer, intent(in) :: first, one, second, two
      !> Of a line in space
      real(wp), intent(in), optional :: direction
      !> Whether the points have to stand in this order
      logical, intent(in), optional :: plain
      character(:), allocatable :: text
      logical :: swaps
      name = new_name(draft, 'j')
      associate (a => draft%bodies(first), b => draft%bodies(second))
         swaps = type == 'REVOLUTE' .or. type == 'WELD'
         if (present(plain)) swaps = swaps .and. .not. plain
         text = '*JOINT, NAME=<N|'//name//'>, TYPE='//type
         if (type == 'WELD') text = text//', TURN=<'//merge('K', 'S', swaps)//'|'//trim(a%name)//'|'//trim(b%name)//'|'// &
            & t(a%angle - b%angle)//'>'
         if (type == 'TRANSLATIONAL') text = text//', TURN=<S|'//trim(a%name)//'|'//trim(b%name)//'|'//t(a%angle - b%angle)//'>'
         if (present(direction)) text = text//', ANGLE=<S|space|'//trim(b%name)//'|'//t(direction - b%angle)//'>'
         if (swaps) then
            text = text//newline//' <C|'//ref(draft, first, one)//'|'//ref(draft, second, two)//'>'
         else
            text = text//newline//' <N|'//ref(draft, first, one)//'>, <N|'//ref(draft, second, two)//'>'
         end if
      end associate
      call add(draft, name, text)
      call ask_joint(draft, name, type, first, second, swaps)
   end subroutine add_joint

   !> Channels of a joint.
   subroutine ask_joint(draft, name, type, first, second, swaps)
      type(draft_type), intent(inout) :: draft
      character(*), intent(in) :: name, type
      integer, intent(in) :: first, second
      logical, intent(in) :: swaps
      real(wp) :: turned
      call add_channel(draft, name, of_vector, forces, 'force_x(<N|'//name//'>)', 'force_y(<N|'//name//'>)', [1, 1, -2], &
         & swaps=swaps)
      if (type == 'WELD' .or. type == 'TRANSLATIONAL') call add_channel(draft, name, of_number, moments, 'moment(<N|'//name// &
         & '>)', dimension=[1, 2, -2], sign=-1.0_wp, swaps=swaps)
      turned = 0.0_wp
      if (draft%bodies(first)%kind == is_ground) turned = -1.0_wp
      if (draft%bodies(second)%kind == is_ground) turned = 1.0_wp
      if (type == 'REVOLUTE' .and. all(draft%bodies([first, second])%kind /= is_point)) then
         call add_channel(draft, name, of_number, angles, 'joint_angle(<N|'//name//'>)', sign=-1.0_wp, turned=turned, swaps=swaps)
         call add_channel(draft, name, of_number, spins, 'joint_spin(<N|'//name//'>)', dimension=[0, 0, -1], sign=-1.0_wp, &
            & swaps=swaps)
      end if
      if (type == 'TRANSLATIONAL' .or. type == 'POINT ON LINE') then
         call add_channel(draft, name, of_number, places, 'displacement(<N|'//name//'>)', dimension=[0, 1, 0])
         call add_channel(draft, name, of_number, speeds, 'sliding_speed(<N|'//name//'>)', dimension=[0, 1, -1])
      end if
   end subroutine ask_joint

   real(wp) function distance(draft, first, one, second, two)
      type(draft_type), intent(in) :: draft
      integer, intent(in) :: first, one, second, two
      distance = norm2(place_of(draft, first, one) - place_of(draft, second, two))
   end function distance

   !> A rod between two points where they stand.
   subroutine add_rod(draft, first, one, second, two)
      type(draft_type), intent(inout) :: draft
      integer, intent(in) :: first, one, second, two
      character(:), allocatable :: name
      if (distance(draft, first, one, second, two) < 0.05_wp) return
      name = new_name(draft, 'j')
      call add(draft, name, '*JOINT, NAME=<N|'//name//'>, TYPE=ROD, LENGTH=<D|0,1,0|+|'//t(distance(draft, first, one, second, &
         & two))//'>'//newline//' <C|'//ref(draft, first, one)//'|'//ref(draft, second, two)//'>')
      call add_channel(draft, name, of_vector, forces, 'force_x(<N|'//name//'>)', 'force_y(<N|'//name//'>)', [1, 1, -2], &
         & swaps=.true.)
   end subroutine add_rod

   !> A spring along a line, linear or by a law.
   subroutine add_spring(draft, first, one, second, two)
      type(draft_type), intent(inout) :: draft
      integer, intent(in) :: first, one, second, two
      character(:), allocatable :: name, text
      real(wp) :: length, stiffness
      length = distance(draft, first, one, second, two)
      if (length < 0.05_wp) return
      stiffness = decades(20.0_wp, 3000.0_wp)
      name = new_name(draft, 'k')
      text = '*SPRING, NAME=<N|'//name//'>, STIFFNESS=<D|1,0,-2|+|'//t(stiffness)//'>, LENGTH=<D|0,1,0|+|'// &
         & t(length*between(0.6_wp, 1.2_wp))//'>'
      if (likely(2)) text = text//', DAMPING=<D|1,0,-1|+|'//t(decades(0.1_wp, 20.0_wp))//'>'
      text = text//newline//' <C|'//ref(draft, first, one)//'|'//ref(draft, second, two)//'>'
      select case (pick(6))
      case (1); text = text//', <E|1,1,-2|+|'//t(10*stiffness)//'*{el}^3>'
      case (2); text = text//', <E|1,1,-2|+|max(0, '//t(2*stiffness)//'*({el} - '//t(0.1_wp*length)//'))>'
      case (3)
         text = text//', <E|1,1,-2|+|'//t(between(0.2_wp, 5.0_wp))//'*tanh({rate}/'//t(decades(0.01_wp, 0.3_wp))//')>'
      case (4); text = text//', <E|1,1,-2|+|'//law_of_time(between(0.5_wp, 20.0_wp))//'>'
      end select
      call add(draft, name, power(text))
      call add_channel(draft, name, of_number, forces, 'tension(<N|'//name//'>)', dimension=[1, 1, -2])
      call add_channel(draft, name, of_number, places, 'elongation(<N|'//name//'>)', dimension=[0, 1, 0])
      if (likely(3)) call ask_power(draft, name)
   end subroutine add_spring

   !> A spring to a point of the ground nearby.
   subroutine hold_by_spring(draft, body)
      type(draft_type), intent(inout) :: draft
      integer, intent(in) :: body
      real(wp) :: place(2)
      integer :: point, there
      point = pick(draft%bodies(body)%points)
      place = place_of(draft, body, point) + [between(0.1_wp, 0.5_wp), between(0.1_wp, 0.5_wp)]
      there = add_ground(draft, place)
      call add_spring(draft, body, point, 0, there)
   end subroutine hold_by_spring

   !> Powers as decks write them.
   pure function power(text) result(out)
      character(*), intent(in) :: text
      character(:), allocatable :: out
      integer :: at
      out = text
      at = index(out, '^')
      if (at > 0) out = out(:at - 1)//'**'//out(at + 1:)
   end function power

   !> Some force that changes with time.
   function law_of_time(size) result(text)
      real(wp), intent(in) :: size
      character(:), allocatable :: text
      select case (pick(6))
      case (1); text = t(size)
      case (2); text = t(size)//'*sin('//t(between(3.0_wp, 30.0_wp))//'*{t})'
      case (3); text = t(size)//'*smoothstep({t}/'//t(between(0.1_wp, 0.4_wp))//')'
      case (4); text = t(size)//'*step('//t(between(0.05_wp, 0.5_wp))//' - {t})'
      case (5); text = t(size)//'*exp(-(('//'{t} - 0.2)/'//t(between(0.02_wp, 0.1_wp))//')**2)'
      case default; text = t(size)//'*max(0, cos('//t(between(5.0_wp, 20.0_wp))//'*{t}))'
      end select
   end function law_of_time

   subroutine ask_power(draft, name)
      type(draft_type), intent(inout) :: draft
      character(*), intent(in) :: name
      call add_channel(draft, name, of_number, powers, 'power(<N|'//name//'>)', dimension=[1, 2, -3])
   end subroutine ask_power

   !> A bushing between two points that stand near each other.
   subroutine add_bushing(draft, first, one, second, two)
      type(draft_type), intent(inout) :: draft
      integer, intent(in) :: first, one, second, two
      character(:), allocatable :: name, text
      name = new_name(draft, 'u')
      associate (a => draft%bodies(first), b => draft%bodies(second))
         text = '*BUSHING, NAME=<N|'//name//'>, AXES=<S|space|'//trim(b%name)//'|'//t(between(0.0_wp, 1.5_wp))// &
            & '>, STIFFNESS X=<D|1,0,-2|+|'//t(decades(500.0_wp, 2.0e4_wp))//'>, STIFFNESS Y=<D|1,0,-2|+|'// &
            & t(decades(500.0_wp, 2.0e4_wp))//'>'
         if (likely(2)) text = text//', DAMPING X=<D|1,0,-1|+|'//t(decades(0.5_wp, 50.0_wp))//'>'
         if (a%kind /= is_point .and. b%kind /= is_point) then
            text = text//', ANGLE=<S|'//trim(a%name)//'|'//trim(b%name)//'|'//t(a%angle - b%angle)// &
               & '>, STIFFNESS ROTATION=<D|1,2,-2|+|'//t(decades(5.0_wp, 200.0_wp))//'>'
            if (likely(2)) text = text//', DAMPING ROTATION=<D|1,2,-1|+|'//t(decades(0.01_wp, 1.0_wp))//'>'
         end if
         text = text//newline//' <N|'//ref(draft, first, one)//'>, <N|'//ref(draft, second, two)//'>'
      end associate
      call add(draft, name, text)
      call add_channel(draft, name, of_vector, forces, 'force_x(<N|'//name//'>)', 'force_y(<N|'//name//'>)', [1, 1, -2])
      if (all(draft%bodies([first, second])%kind /= is_point)) call add_channel(draft, name, of_number, moments, &
         & 'moment(<N|'//name//'>)', dimension=[1, 2, -2], sign=-1.0_wp)
   end subroutine add_bushing

   !> A rotational spring between two sections.
   subroutine add_turning_spring(draft, first, one, second, two)
      type(draft_type), intent(inout) :: draft
      integer, intent(in) :: first, one, second, two
      character(:), allocatable :: name, text
      real(wp) :: stiffness
      if (any(draft%bodies([first, second])%kind == is_point)) return
      name = new_name(draft, 'k')
      stiffness = decades(0.5_wp, 50.0_wp)
      associate (a => draft%bodies(first), b => draft%bodies(second))
         text = '*SPRING, NAME=<N|'//name//'>, TYPE=ROTATIONAL, STIFFNESS=<D|1,2,-2|+|'//t(stiffness)//'>, ANGLE=<S|'// &
            & trim(b%name)//'|'//trim(a%name)//'|'//t(b%angle - a%angle + between(-0.3_wp, 0.3_wp))//'>'
         if (likely(2)) text = text//', DAMPING=<D|1,2,-1|+|'//t(decades(0.01_wp, 1.0_wp))//'>'
         text = text//newline//' <N|'//ref(draft, first, one)//'>, <N|'//ref(draft, second, two)//'>'
         select case (pick(5))
         case (1); text = text//', <E|1,2,-2|-|'//t(stiffness)//'*{elr}^3>'
         case (2); text = text//', <E|1,2,-2|-|'//t(between(0.1_wp, 1.0_wp))//'*tanh({rater}/'//t(decades(0.05_wp, 1.0_wp))//')>'
         end select
      end associate
      call add(draft, name, power(text))
      call add_channel(draft, name, of_number, moments, 'torque(<N|'//name//'>)', dimension=[1, 2, -2], sign=-1.0_wp)
      call add_channel(draft, name, of_number, angles, 'elongation(<N|'//name//'>)', sign=-1.0_wp)
   end subroutine add_turning_spring

   !> A force on a point, by time, place or speed.
   subroutine add_force(draft, body, point)
      type(draft_type), intent(inout) :: draft
      integer, intent(in) :: body, point
      character(:), allocatable :: name, text, at
      real(wp) :: place(2), size
      name = new_name(draft, 'w')
      at = ref(draft, body, point)
      place = place_of(draft, body, point)
      size = decades(0.5_wp, 20.0_wp)
      text = '*FORCE, NAME=<N|'//name//'>, POINT=<N|'//at//'>'
      if (likely(6) .and. draft%bodies(body)%kind /= is_point) then
         text = text//', FOLLOWER=YES'//newline//' <E|1,1,-2|+|'//law_of_time(size)//'>, <E|1,1,-2|-|'//law_of_time(size)//'>'
      else
         text = text//newline//' '//vector(force_law('x', at, place(1), size), force_law('y', at, place(2), size))
      end if
      call add(draft, name, text)
      if (likely(3)) call ask_power(draft, name)
   end subroutine add_force

   function vector(x, y) result(text)
      character(*), intent(in) :: x, y
      character(:), allocatable :: text
      text = '<F|1,1,-2|'//x//'|'//y//'>, <G|1,1,-2|'//x//'|'//y//'>'
   end function vector

   !> A component of a force.
   function force_law(axis, at, here, size) result(text)
      character(*), intent(in) :: axis, at
      real(wp), intent(in) :: here, size
      character(:), allocatable :: text, x, v
      x = '{'//axis//':'//at//'}'
      v = '{v'//axis//':'//at//'}'
      select case (pick(12))
      case (1, 2); text = law_of_time(size)
      case (3); text = '-'//t(decades(10.0_wp, 500.0_wp))//'*('//x//' - '//t(here)//')'
      case (4); text = '-'//t(size)//'*tanh('//v//'/'//t(decades(0.01_wp, 0.3_wp))//')'
      case (5); text = '-'//t(decades(0.1_wp, 5.0_wp))//'*'//v
      case (6); text = 'max(0, '//t(decades(200.0_wp, 2.0e4_wp))//'*('//t(here - between(0.01_wp, 0.2_wp))//' - '//x//'))'
      case (7); text = '-'//t(decades(200.0_wp, 5.0e3_wp))//'*max(0, abs('//x//' - '//t(here)//') - '//t(between(0.01_wp, &
         & 0.1_wp))//')*sin(3*('//x//' - '//t(here)//'))'
      case (8); text = t(size)//'*step('//x//' - '//t(here + between(-0.05_wp, 0.05_wp))//')'
      case (9); text = t(size)//'*smoothstep(('//x//' - '//t(here - 0.05_wp)//')/0.1)'
      case (10); text = '-'//t(decades(0.1_wp, 3.0_wp))//'*'//v//'*abs('//v//')'
      case (11); text = t(size)//'*exp(-(('//x//' - '//t(here + between(-0.1_wp, 0.1_wp))//')/0.03)**2)'
      case default; text = '0'
      end select
   end function force_law

   !> A torque on a body, or between two.
   subroutine add_torque(draft, body, other)
      type(draft_type), intent(inout) :: draft
      !> Bodies with rotation; the other may be the ground
      integer, intent(in) :: body, other
      character(:), allocatable :: name, text, law
      real(wp) :: size
      if (draft%bodies(body)%kind == is_point .or. draft%bodies(other)%kind == is_point) return
      if (.not. draft%bodies(body)%whole) return
      name = new_name(draft, 'w')
      size = decades(0.05_wp, 3.0_wp)
      text = '*TORQUE, NAME=<N|'//name//'>, BODY=<N|'//trim(draft%bodies(body)%name)//'>'
      if (other > 0) text = text//', REACTION=<N|'//ref(draft, other, 1)//'>'
      associate (angle => '{ang:'//trim(draft%bodies(body)%name)//'}', spin => '{spin:'//trim(draft%bodies(body)%name)//'}')
         select case (pick(7))
         case (1); law = '-'//t(size)//'*tanh('//spin//'/'//t(decades(0.05_wp, 1.0_wp))//')'
         case (2); law = '-'//t(size/10)//'*'//spin
         case (3); law = t(size)//'*sin('//as_text(pick(3))//'*'//angle//')'
         case (4); law = '-'//t(size)//'*('//angle//' - '//t(draft%bodies(body)%angle)//')'
         case (5); law = t(size)//'*max(0, '//angle//' - '//t(draft%bodies(body)%angle + between(-0.3_wp, 0.3_wp))//')'
         case default; law = law_of_time(size)
         end select
      end associate
      call add(draft, name, text//newline//' <E|1,2,-2|-|'//law//'>')
      if (likely(3)) call ask_power(draft, name)
   end subroutine add_torque

   !> A load along a beam.
   subroutine add_spread_load(draft, body)
      type(draft_type), intent(inout) :: draft
      integer, intent(in) :: body
      character(:), allocatable :: name, x, y, text
      name = new_name(draft, 'w')
      x = t(between(-2.0_wp, 2.0_wp))
      y = t(between(-5.0_wp, 5.0_wp))//'*{s}/'//t(draft%bodies(body)%length)
      text = '*DISTRIBUTED LOAD, NAME=<N|'//name//'>, BODY=<N|'//trim(draft%bodies(body)%name)//'>'
      if (draft%bodies(body)%kind == is_frame) text = text//', MEMBER=1'
      if (likely(2)) then
         text = text//', FOLLOWER=YES'//newline//' <E|1,0,-2|+|'//x//'>, <E|1,0,-2|-|'//y//'>'
      else
         text = text//newline//' <F|1,0,-2|'//x//'|'//y//'>, <G|1,0,-2|'//x//'|'//y//'>'
      end if
      if (likely(2)) text = text//', <E|0,0,0|+|'//law_of_time(1.0_wp)//'>'
      call add(draft, name, text)
   end subroutine add_spread_load

   subroutine add_friction(draft, joint, turns)
      type(draft_type), intent(inout) :: draft
      character(*), intent(in) :: joint
      logical, intent(in) :: turns
      character(:), allocatable :: name
      name = new_name(draft, 'c')
      call add(draft, name, '*FRICTION, NAME=<N|'//name//'>, JOINT=<N|'//joint//'>, COEFFICIENT=<D|1,'//merge('2', '0', turns)// &
         & ',-1|+|'//t(decades(0.01_wp, 1.0_wp))//'>')
   end subroutine add_friction

   !> A driver of the angle of a body on the ground.
   subroutine drive_angle(draft, body, joint)
      type(draft_type), intent(inout) :: draft
      integer, intent(in) :: body
      !> Joint with the ground, in the order body, ground; empty: its angle is not to be driven
      character(*), intent(in) :: joint
      character(:), allocatable :: name, text, law, both
      integer :: level
      real(wp) :: speed
      name = new_name(draft, 'd')
      level = pick(4)
      speed = between(-12.0_wp, 12.0_wp)
      text = '*DRIVER, NAME=<N|'//name//'>, TYPE=ANGLE'
      associate (b => draft%bodies(body))
         both = trim(b%name)//'|ground'
         if (joint /= '' .and. likely(2)) then
            text = text//', JOINT=<N|'//joint//'>'
         else
            text = text//', BODY=<N|'//trim(b%name)//'>'
         end if
         select case (level)
         case (1)
            law = t(speed)//'*smoothstep({t}/'//t(between(0.2_wp, 0.5_wp))//')'
            text = text//', LEVEL=VELOCITY, INITIAL=<A|'//t(b%angle)//'>'//newline//' <E|0,0,-1|-|'//law//'>'
            text = unforced(text)
         case (2)
            law = t(3*speed)//'*cos('//t(between(2.0_wp, 10.0_wp))//'*{t})'
            text = text//', LEVEL=ACCELERATION, INITIAL=<A|'//t(b%angle)//'>, INITIAL VELOCITY=<D|0,0,-1|-|'//t(speed)//'>'// &
               & newline//' <E|0,0,-2|-|'//law//'>'
            text = unforced(text)
         case (3)
            text = text//newline//' <B|'//t(b%angle)//' + '//t(abs(speed) + 1.0_wp)//'*{t}>'
         case default
            text = text//newline//' <B|'//t(b%angle)//' + '//t(between(0.2_wp, 1.0_wp))//'*sin('//t(between(3.0_wp, 12.0_wp))// &
               & '*{t})>'
         end select
      end associate
      call add(draft, name, text)
      call add_channel(draft, name, of_number, moments, 'torque(<N|'//name//'>)', dimension=[1, 2, -2], sign=-1.0_wp)
      call ask_power(draft, name)
   end subroutine drive_angle

   !> Laws of motions are not changed where loads are: field E is R then.
   pure function unforced(text) result(out)
      character(*), intent(in) :: text
      character(:), allocatable :: out
      integer :: at
      at = index(text, '<E|', back=.true.)
      out = text
      out(at:at + 1) = '<R'
   end function unforced

   subroutine add_gravity(draft)
      type(draft_type), intent(inout) :: draft
      call add(draft, '', '*GRAVITY, X=<U|0,1,-2|0|-9.81>, Y=<V|0,1,-2|0|-9.81>')
   end subroutine add_gravity

   !> Channels of all bodies.
   subroutine ask_bodies(draft)
      type(draft_type), intent(inout) :: draft
      integer :: i, k
      character(:), allocatable :: name, at
      at = ''
      do i = 1, draft%count
         associate (b => draft%bodies(i))
            name = trim(b%name)
            k = min(2, b%points)
            at = '(<N|'//ref(draft, i, k)//'>)'
            call add_channel(draft, name, of_place, places, 'x'//at, 'y'//at, [0, 1, 0])
            call add_channel(draft, name, of_vector, speeds, 'vx'//at, 'vy'//at, [0, 1, -1])
            if (likely(2)) call add_channel(draft, name, of_vector, accelerations, 'ax'//at, 'ay'//at, [0, 1, -2])
            if (b%kind == is_point) cycle
            call add_channel(draft, name, of_number, angles, 'angle(<N|'//name//'>)', sign=-1.0_wp, turned=1.0_wp)
            call add_channel(draft, name, of_number, spins, 'spin(<N|'//name//'>)', dimension=[0, 0, -1], sign=-1.0_wp)
            if (b%kind == is_rigid .or. .not. b%bends) cycle
            if (b%kind == is_beam) then
               at = '(<N|'//ref(draft, i, 3)//'>)'
               call add_channel(draft, name, of_number, deflections, 'deflection'//at, dimension=[0, 1, 0], sign=-1.0_wp)
               at = '(<N|'//ref(draft, i, 4)//'>)'
            else
               at = '(<N|'//ref(draft, i, 3)//'>)'
            end if
            call add_channel(draft, name, of_number, deflections, 'u2'//at, dimension=[0, 1, 0], sign=-1.0_wp)
            call add_channel(draft, name, of_number, rotations, 'rotation'//at, sign=-1.0_wp)
            call add_channel(draft, name, of_number, forces, 'axial_force'//at, dimension=[1, 1, -2])
            call add_channel(draft, name, of_number, forces, 'shear_force'//at, dimension=[1, 1, -2], sign=-1.0_wp)
            call add_channel(draft, name, of_number, moments, 'bending_moment'//at, dimension=[1, 2, -2], sign=-1.0_wp)
            call add_channel(draft, name, of_number, stresses, '<M|stress_top|stress_bottom>'//at, dimension=[1, -1, -2])
         end associate
      end do
   end subroutine ask_bodies

   !> Channels of the whole.
   subroutine ask_system(draft)
      type(draft_type), intent(inout) :: draft
      call add_channel(draft, '', of_number, energies, 'kinetic_energy(system)', dimension=[1, 2, -2])
      call add_channel(draft, '', of_change, energies, 'potential_energy(system)', dimension=[1, 2, -2], &
         & placed=draft%timeless)
      call add_channel(draft, '', of_change, energies, 'work(system)', dimension=[1, 2, -2])
      call add_channel(draft, '', of_vector, others, 'momentum_x(system)', 'momentum_y(system)', [1, 1, -1])
      call add_channel(draft, '', of_number, others + 1, 'angular_momentum(system)', dimension=[1, 2, -1], sign=-1.0_wp, &
         & placed=.true.)
   end subroutine ask_system

end module couplings
