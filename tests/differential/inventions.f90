!> Scenes by chance: a number makes a scene.
module inventions
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, newline
   use additions, only: add_hoist, add_press, add_flywheel, settle_first
   use chances, only: sow, pick, between, decades, likely
   use couplings, only: add_joint, add_rod, add_spring, hold_by_spring, add_bushing, add_turning_spring, add_force, add_torque, &
      & add_spread_load, add_friction, drive_angle, add_gravity, ask_bodies, ask_system, places, moments, forces, others
   use structures, only: add_structure, add_rotor, add_column
   use drafts, only: draft_type, add, add_ground, add_rigid, add_point, add_beam, add_frame, add_channel, place_of, ref, t, &
      & new_name, exact_rungs, is_point, is_beam, is_frame
   use views, only: of_number, of_vector
   implicit none
   private
   public :: invent

   real(wp), parameter :: pi = acos(-1.0_wp)

contains

   !> The scene of a number.
   subroutine invent(seed, draft, exact)
      integer, intent(in) :: seed
      type(draft_type), intent(out) :: draft
      !> Whether all its beams are exact ones, whatever the number
      logical, intent(in) :: exact
      !> A point of the ground that many scenes stand on
      integer :: first
      call sow(seed)
      exact_rungs = has_exact(seed) .or. exact
      allocate (draft%blocks(0), draft%channels(0))
      first = add_ground(draft, [0.0_wp, 0.0_wp])
      call add(draft, '', '*ASSEMBLY, LARGEST TURN=3<H>', 1)
      call add(draft, '', '*ACCURACY, ESTIMATE=<I>', 1)
      if (mod(seed, 7) == 0) then
         call invent_more(draft)
      else
         call invent_usual(draft)
      end if
      call ask_bodies(draft)
      call ask_system(draft)
      if (mod(seed, 3) == 0) call ask_envelope(draft)
   end subroutine invent

   !> The envelope of the last body that bends.
   subroutine ask_envelope(draft)
      type(draft_type), intent(inout) :: draft
      integer :: i
      do i = draft%count, 1, -1
         if (.not. any(draft%bodies(i)%kind == [is_beam, is_frame]) .or. .not. draft%bodies(i)%bends) cycle
         draft%envelope = draft%bodies(i)%name
         return
      end do
   end subroutine ask_envelope

   !> Whether the beams of a scene are exact ones: every fifth from 10000 on.
   pure logical function has_exact(seed)
      integer, intent(in) :: seed
      has_exact = seed >= 10000 .and. mod(seed, 5) == 0
   end function has_exact

   !> Kinds that came later.
   subroutine invent_more(draft)
      type(draft_type), intent(inout) :: draft
      select case (pick(6))
      case (1); call add_hoist(draft)
      case (2); call add_press(draft)
      case (3); call add_flywheel(draft)
      case (4); call add_column(draft)
      case (5); call tree(draft)
      case default; call slider_crank(draft)
      end select
      if (any(draft%title == [character(24) :: 'tree', 'slider-crank'])) then
         call settle_first(draft)
      else if (.not. draft%timeless) then
         call run_in_time(draft, 1.0_wp)
      end if
   end subroutine invent_more

   !> Kinds that were there from the beginning.
   subroutine invent_usual(draft)
      type(draft_type), intent(inout) :: draft
      select case (pick(20))
      case (1:5); call tree(draft)
      case (6:8); call four_bar(draft)
      case (9, 10); call slider_crank(draft)
      case (11); call wheels(draft)
      case (12); call planets(draft)
      case (13); call cam(draft)
      case (14); call crossing(draft)
      case (15); call road(draft)
      case (16, 17); call add_structure(draft)
      case (18); call add_rotor(draft)
      case (19); call prescribed(draft)
      case default; call loose(draft)
      end select
   end subroutine invent_usual

   !> A motion in time at the end of a deck.
   subroutine run_in_time(draft, longest)
      type(draft_type), intent(inout) :: draft
      real(wp), intent(in) :: longest
      draft%end = between(0.3_wp*longest, longest)
      if (draft%elastic) draft%end = 0.2_wp*draft%end
      call add(draft, '', '*DYNAMICS, START=<Z|0>, END=<Z|'//t(draft%end)//'>, OUTPUTS='//as_text(draft%outputs)//'<O>', 3)
   end subroutine run_in_time

   !> A bar, rigid or not.
   integer function bar(draft, place, angle, length, support, beams) result(body)
      type(draft_type), intent(inout) :: draft
      real(wp), intent(in) :: place(2), angle, length
      character(*), intent(in) :: support
      !> One in so many is a beam
      integer, intent(in) :: beams
      if (likely(beams)) then
         body = add_beam(draft, place, angle, length, support)
         draft%elastic = .true.
      else
         body = add_rigid(draft, place, angle, length)
      end if
   end function bar

   real(wp) function direction(from, to)
      real(wp), intent(in) :: from(2), to(2)
      direction = atan2(to(2) - from(2), to(1) - from(1))
   end function direction

   !> Loads by chance.
   subroutine load(draft, most)
      type(draft_type), intent(inout) :: draft
      integer, intent(in) :: most
      integer :: i, a, b
      if (.not. likely(5)) call add_gravity(draft)
      do i = 1, pick(most + 1) - 1
         a = pick(draft%count)
         b = pick(draft%count + 1) - 1
         select case (pick(7))
         case (1, 2); call add_force(draft, a, pick(draft%bodies(a)%points))
         case (3); call add_torque(draft, a, merge(b, 0, b /= a))
         case (4); if (a /= b) call add_spring(draft, a, pick(draft%bodies(a)%points), b, pick(draft%bodies(b)%points))
         case (5); if (a /= b) call add_turning_spring(draft, a, 1, b, 1)
         case (6); call hold_by_spring(draft, a)
         case default
            if (any(draft%bodies(a)%kind == [is_beam, is_frame])) then
               call add_spread_load(draft, a)
            else
               call add_force(draft, a, 1)
            end if
         end select
      end do
   end subroutine load

   !> Bodies on one another.
   subroutine tree(draft)
      type(draft_type), intent(inout) :: draft
      character(:), allocatable :: joint
      integer :: i, parent, point, body
      logical :: driven
      draft%title = 'tree'
      driven = .false.
      do i = 1, 1 + pick(4)
         parent = pick(draft%count + 1) - 1
         if (draft%count > 0 .and. likely(2)) parent = draft%count
         if (draft%bodies(parent)%kind == is_point) parent = 0
         if (parent == 0) then
            point = add_ground(draft, [between(-0.5_wp, 0.5_wp), between(-0.5_wp, 0.5_wp)])
         else
            point = 1 + pick(draft%bodies(parent)%points - 1)
         end if
         call attach(draft, parent, point, body, joint)
         if (parent == 0 .and. joint /= '' .and. .not. driven .and. likely(4)) then
            call drive_angle(draft, body, joint)
            driven = .true.
         end if
      end do
      if (draft%count >= 3 .and. likely(3)) call add_rod(draft, 1, 2, draft%count, 1)
      call load(draft, 4)
      call run_in_time(draft, 1.0_wp)
   end subroutine tree

   !> One more body, by some joint.
   subroutine attach(draft, parent, point, body, joint)
      type(draft_type), intent(inout) :: draft
      integer, intent(in) :: parent, point
      integer, intent(out) :: body
      !> Of a pin on the ground that may be driven
      character(:), allocatable, intent(out) :: joint
      character(:), allocatable :: other
      integer :: there
      real(wp) :: place(2), angle, length
      joint = ''
      place = place_of(draft, parent, point)
      angle = between(-3.0_wp, 3.0_wp)
      length = between(0.2_wp, 0.8_wp)
      select case (pick(9))
      case (1:4)
         body = bar(draft, place, angle, length, 'PINNED', 4)
         call add_joint(joint, draft, 'REVOLUTE', body, 1, parent, point, plain=.true.)
         if (likely(4)) call add_friction(draft, joint, .true.)
      case (5)
         body = bar(draft, place, angle, length, 'CLAMPED', 2)
         call add_joint(other, draft, 'WELD', body, 1, parent, point)
      case (6)
         body = bar(draft, place, angle, length, 'CLAMPED', 5)
         call add_joint(other, draft, 'TRANSLATIONAL', body, 1, parent, point, between(-1.5_wp, 1.5_wp))
         if (likely(2)) call add_friction(draft, other, .false.)
         there = add_ground(draft, place + [between(0.2_wp, 1.0_wp), 0.3_wp])
         call add_spring(draft, body, 2, 0, there)
      case (7)
         body = bar(draft, place, angle, length, 'FREE', 3)
         call add_bushing(draft, body, 1, parent, point)
      case (8)
         body = add_point(draft, place + 0.3_wp*[cos(angle), sin(angle)])
         call add_rod(draft, body, 1, parent, point)
      case default
         body = bar(draft, place, angle, length, 'PINNED', 5)
         call add_joint(other, draft, 'POINT ON LINE', body, 1, parent, point, between(-1.5_wp, 1.5_wp))
      end select
   end subroutine attach

   !> Four bars, or more cranks than needed.
   subroutine four_bar(draft)
      type(draft_type), intent(inout) :: draft
      real(wp) :: o(2, 2), p(2), q(2), angle, length
      integer :: crank, coupler, rocker, g(2), more, there
      character(:), allocatable :: shaft, other
      logical :: parallel
      draft%title = 'four-bar'
      parallel = likely(4)
      o(:, 1) = [between(-0.3_wp, 0.3_wp), between(-0.3_wp, 0.3_wp)]
      o(:, 2) = o(:, 1) + [between(0.5_wp, 1.0_wp), between(-0.2_wp, 0.2_wp)]
      angle = between(0.8_wp, 2.2_wp)
      length = between(0.15_wp, 0.3_wp)
      p = o(:, 1) + length*[cos(angle), sin(angle)]
      q = o(:, 2) + between(0.4_wp, 0.7_wp)*[cos(1.3_wp), sin(1.3_wp)]
      if (parallel) q = o(:, 2) + p - o(:, 1)
      g(1) = add_ground(draft, o(:, 1))
      g(2) = add_ground(draft, o(:, 2))
      crank = bar(draft, o(:, 1), angle, length, 'PINNED', 8)
      coupler = bar(draft, p, direction(p, q), norm2(q - p), 'PINNED', 3)
      rocker = bar(draft, o(:, 2), direction(o(:, 2), q), norm2(q - o(:, 2)), 'PINNED', 5)
      call add_joint(shaft, draft, 'REVOLUTE', crank, 1, 0, g(1), plain=.true.)
      call add_joint(other, draft, 'REVOLUTE', coupler, 1, crank, 2)
      call add_joint(other, draft, 'REVOLUTE', coupler, 2, rocker, 2)
      call add_joint(other, draft, 'REVOLUTE', rocker, 1, 0, g(2))
      if (likely(4)) call add_friction(draft, other, .true.)
      if (parallel .and. likely(2) .and. .not. draft%elastic) then
         ! one crank more than needed
         p = place_of(draft, coupler, 3)
         more = add_rigid(draft, p - (q - o(:, 2)), direction(o(:, 2), q), norm2(q - o(:, 2)))
         there = add_ground(draft, p - (q - o(:, 2)))
         call add_joint(other, draft, 'REVOLUTE', more, 1, 0, there)
         call add_joint(other, draft, 'REVOLUTE', more, 2, coupler, 3)
      end if
      if (likely(2)) call drive_angle(draft, crank, shaft)
      call load(draft, 3)
      call run_in_time(draft, 0.8_wp)
   end subroutine four_bar

   !> Crank, rod and slider.
   subroutine slider_crank(draft)
      type(draft_type), intent(inout) :: draft
      real(wp) :: angle, r, l, p(2), s(2)
      integer :: crank, rod, slider
      character(:), allocatable :: shaft, other
      draft%title = 'slider-crank'
      angle = between(0.2_wp, 2.5_wp)
      r = between(0.1_wp, 0.2_wp)
      l = between(0.4_wp, 0.8_wp)
      p = r*[cos(angle), sin(angle)]
      s = [p(1) + sqrt(l**2 - p(2)**2), 0.0_wp]
      crank = add_rigid(draft, [0.0_wp, 0.0_wp], angle, r)
      rod = bar(draft, p, direction(p, s), l, 'PINNED', 2)
      call add_joint(shaft, draft, 'REVOLUTE', crank, 1, 0, 1, plain=.true.)
      call add_joint(other, draft, 'REVOLUTE', rod, 1, crank, 2)
      if (likely(2)) then
         slider = add_point(draft, s)
         call add_joint(other, draft, 'POINT ON LINE', slider, 1, 0, 1, 0.0_wp)
      else
         slider = add_rigid(draft, s, 0.0_wp, 0.1_wp)
         call add_joint(other, draft, 'TRANSLATIONAL', slider, 1, 0, 1, 0.0_wp)
         if (likely(3)) call add_friction(draft, other, .false.)
      end if
      call add_joint(other, draft, 'REVOLUTE', rod, 2, slider, 1)
      if (.not. likely(3)) call drive_angle(draft, crank, shaft)
      call load(draft, 2)
      call run_in_time(draft, 0.8_wp)
   end subroutine slider_crank

   !> Wheels on the ground, with teeth, belts and a rack.
   subroutine wheels(draft)
      type(draft_type), intent(inout) :: draft
      real(wp) :: radius, next, place(2), angle
      integer :: i, before, wheel, rack, there
      character(:), allocatable :: shaft, name, text, other
      draft%title = 'wheels'
      place = [between(-0.3_wp, 0.3_wp), between(-0.3_wp, 0.3_wp)]
      radius = between(0.05_wp, 0.15_wp)
      before = add_rigid(draft, place, between(-3.0_wp, 3.0_wp), radius)
      there = add_ground(draft, place)
      call add_joint(shaft, draft, 'REVOLUTE', before, 1, 0, there, plain=.true.)
      if (likely(2)) call drive_angle(draft, before, shaft)
      do i = 1, pick(3)
         next = between(0.05_wp, 0.2_wp)
         angle = between(-1.0_wp, 1.0_wp)
         name = new_name(draft, 'j')
         text = '*JOINT, NAME=<N|'//name//'>, TYPE='
         if (likely(2)) then
            place = place + (radius + next)*[cos(angle), sin(angle)]
            text = text//'GEAR, FIRST RADIUS='
         else
            place = place + (radius + next + 0.1_wp)*[cos(angle), sin(angle)]
            text = text//trim(merge('BELT, CROSSED, FIRST RADIUS=', 'BELT, FIRST RADIUS=         ', likely(2)))
         end if
         wheel = add_rigid(draft, place, between(-3.0_wp, 3.0_wp), next)
         there = add_ground(draft, place)
         call add_joint(other, draft, 'REVOLUTE', wheel, 1, 0, there)
         if (likely(3)) call add_friction(draft, other, .true.)
         call add(draft, name, text//'<D|0,1,0|+|'//t(radius)//'>, SECOND RADIUS=<D|0,1,0|+|'//t(next)//'>'//newline//' <N|'// &
            & trim(draft%bodies(before)%name)//'.origin>, <N|'//trim(draft%bodies(wheel)%name)//'.origin>')
         call add_channel(draft, name, of_number, moments, 'moment(<N|'//name//'>)', dimension=[1, 2, -2], sign=-1.0_wp)
         before = wheel
         radius = next
      end do
      if (likely(2)) then
         rack = add_rigid(draft, place + [0.0_wp, radius], 0.0_wp, 0.4_wp)
         there = add_ground(draft, place + [0.0_wp, radius])
         call add_joint(other, draft, 'TRANSLATIONAL', rack, 1, 0, there, 0.0_wp)
         name = new_name(draft, 'j')
         call add(draft, name, '*JOINT, NAME=<N|'//name//'>, TYPE=RACK, RADIUS=<D|0,1,0|+|'//t(radius)//'>'//newline//' <N|'// &
            & trim(draft%bodies(wheel)%name)//'.origin>, <N|'//trim(draft%bodies(rack)%name)//'.origin>')
         call add_channel(draft, name, of_vector, forces, 'force_x(<N|'//name//'>)', 'force_y(<N|'//name//'>)', [1, 1, -2])
         call hold_by_spring(draft, rack)
      end if
      call load(draft, 3)
      call run_in_time(draft, 1.0_wp)
   end subroutine wheels

   !> A carrier with a planet, coupled by numbers of teeth.
   subroutine planets(draft)
      type(draft_type), intent(inout) :: draft
      integer :: sun, carrier, planet
      real(wp) :: arm, angle
      character(:), allocatable :: shaft, pin, other, name
      draft%title = 'planetary gear'
      arm = between(0.1_wp, 0.3_wp)
      angle = between(-3.0_wp, 3.0_wp)
      sun = add_rigid(draft, [0.0_wp, 0.0_wp], between(-3.0_wp, 3.0_wp), 0.1_wp)
      carrier = bar(draft, [0.0_wp, 0.0_wp], angle, arm, 'PINNED', 4)
      planet = add_rigid(draft, arm*[cos(angle), sin(angle)], between(-3.0_wp, 3.0_wp), 0.05_wp)
      call add_joint(shaft, draft, 'REVOLUTE', sun, 1, 0, 1, plain=.true.)
      call add_joint(other, draft, 'REVOLUTE', carrier, 1, 0, 1)
      call add_joint(pin, draft, 'REVOLUTE', planet, 1, carrier, 2, plain=.true.)
      name = new_name(draft, 'j')
      call add(draft, name, '*COUPLER, NAME=<N|'//name//'>'//newline//' '//as_text(10 + pick(20))//', angle, <N|'// &
         & trim(draft%bodies(sun)%name)//'>'//newline//' '//as_text(10 + pick(20))//', joint_angle, <N|'//pin//'>')
      call add_channel(draft, name, of_number, moments, 'coupling(<N|'//name//'>)', dimension=[1, 2, -2], sign=-1.0_wp)
      if (likely(2)) call drive_angle(draft, sun, shaft)
      call load(draft, 3)
      call run_in_time(draft, 1.0_wp)
   end subroutine planets

   !> A cam and its follower; or a point on a curve of the ground.
   subroutine cam(draft)
      type(draft_type), intent(inout) :: draft
      character(:), allocatable :: name, curve, text, shaft, other
      integer :: wheel, follower, i
      real(wp) :: r, ecc, phi
      draft%title = 'cam'
      curve = new_name(draft, 'q')
      if (likely(2)) then
         r = between(0.05_wp, 0.1_wp)
         ecc = between(0.05_wp, 0.3_wp)*r
         text = '*CURVE, NAME=<N|'//curve//'>, CLOSED=YES'
         do i = 0, 23
            phi = 2*pi*i/24
            text = text//newline//' <D|0,1,0|+|'//t(r*cos(phi) + ecc*cos(2*phi))//'>, <D|0,1,0|-|'//t(r*sin(phi))//'>'
         end do
         call add(draft, curve, text, 1)
         wheel = add_rigid(draft, [0.0_wp, 0.0_wp], 0.0_wp, r)
         follower = add_rigid(draft, [0.0_wp, r], 0.0_wp, 0.1_wp)
         call add_joint(shaft, draft, 'REVOLUTE', wheel, 1, 0, 1, plain=.true.)
         call add_joint(other, draft, 'TRANSLATIONAL', follower, 1, 0, 1, pi/2)
         if (likely(2)) call drive_angle(draft, wheel, shaft)
      else
         ecc = between(0.5_wp, 3.0_wp)
         phi = between(0.5_wp, 5.0_wp)
         call add(draft, curve, '*CURVE, NAME=<N|'//curve//'>'//newline//' <R|0,1,0|-|'//t(1/ecc)//'*('//t(ecc)//'*{cx})**2 + '// &
            & '0.02*sin('//t(phi)//'*{cx})>', 1)
         r = between(-0.3_wp, 0.3_wp)
         follower = add_point(draft, [r, ecc*r**2 + 0.02_wp*sin(phi*r)])
         wheel = 0
      end if
      name = new_name(draft, 'j')
      call add(draft, name, '*JOINT, NAME=<N|'//name//'>, TYPE=POINT ON CURVE, CURVE=<N|'//curve//'>, ANGLE=<S|space|'// &
         & trim(draft%bodies(wheel)%name)//'|0>'//newline//' <N|'//ref(draft, follower, 1)// &
         & '>, <N|'//ref(draft, wheel, 1)//'>')
      call add_channel(draft, name, of_vector, forces, 'force_x(<N|'//name//'>)', 'force_y(<N|'//name//'>)', [1, 1, -2])
      call load(draft, 2)
      call run_in_time(draft, 0.8_wp)
   end subroutine cam

   !> A mass that slides along a beam.
   subroutine crossing(draft)
      type(draft_type), intent(inout) :: draft
      integer :: beam, mass, there
      real(wp) :: length, x, angle, along(2)
      character(:), allocatable :: other
      draft%title = 'crossing'
      draft%elastic = .true.
      length = between(0.6_wp, 1.2_wp)
      angle = between(-0.5_wp, 0.5_wp)
      along = [cos(angle), sin(angle)]
      beam = add_beam(draft, [0.0_wp, 0.0_wp], angle, length, 'PINNED', in_one_piece=.true.)
      x = length*between(0.2_wp, 0.5_wp)
      mass = add_point(draft, x*along, between(-0.5_wp, 1.0_wp)*along)
      call add_joint(other, draft, 'REVOLUTE', beam, 1, 0, 1)
      there = add_ground(draft, length*along)
      call add_joint(other, draft, 'POINT ON LINE', beam, 2, 0, there, angle)
      other = new_name(draft, 'j')
      call add(draft, other, '*JOINT, NAME=<N|'//other//'>, TYPE=SLIDING'//newline//' <N|'//trim(draft%bodies(mass)%name)// &
         & '>, <N|'//trim(draft%bodies(beam)%name)//'>')
      call add_channel(draft, other, of_vector, forces, 'force_x(<N|'//other//'>)', 'force_y(<N|'//other//'>)', [1, 1, -2])
      call load(draft, 2)
      call run_in_time(draft, 0.5_wp)
   end subroutine crossing

   !> A wheel pulled over a road with a bump, a mass on a spring above it.
   subroutine road(draft)
      type(draft_type), intent(inout) :: draft
      integer :: wheel, top
      real(wp) :: speed, at, wide, k
      character(:), allocatable :: name, table, w, pull, other
      draft%title = 'road'
      draft%by_quarters = .true.
      speed = decades(1.0_wp, 10.0_wp)
      at = between(0.2_wp, 0.8_wp)
      wide = decades(0.02_wp, 0.3_wp)
      wheel = add_point(draft, [0.0_wp, 0.3_wp])
      top = add_point(draft, [0.0_wp, 0.8_wp])
      w = trim(draft%bodies(wheel)%name)
      k = decades(2.0e3_wp, 5.0e4_wp)
      table = new_name(draft, 'road')
      call add(draft, table, '*TABLE, NAME=<N|'//table//'>'//newline//' 0, 0'//newline//' '//t(at)//', 0'//newline//' '// &
         & t(at + wide/2)//', 0.03'//newline//' '//t(at + wide)//', 0', 1)
      name = new_name(draft, 'w')
      pull = 'max(0, '//t(k)//'*('//table_law(table, '{x:'//w//'}')//' + 0.3 - {y:'//w//'}))'
      call add(draft, name, '*FORCE, NAME=<N|'//name//'>, POINT=<N|'//w//'>'//newline//' <F|1,1,-2|0|'//pull// &
         & '>, <G|1,1,-2|0|'//pull//'>')
      call add_spring(draft, wheel, 1, top, 1)
      call add_joint(other, draft, 'POINT ON LINE', top, 1, wheel, 1, pi/2)
      call add_gravity(draft)
      name = new_name(draft, 'd')
      call add(draft, name, '*DRIVER, NAME=<N|'//name//'>, TYPE=<L|X|Y>, POINT=<N|'//w//'>'//newline//' <W|'//t(speed)//'*{t}>')
      call run_in_time(draft, 2.0_wp/speed)
   end subroutine road

   !> A table by its name in the view: laws have it as `{tab:name}`.
   pure function table_law(table, argument) result(text)
      character(*), intent(in) :: table, argument
      character(:), allocatable :: text
      text = '{tab:'//table//'}('//argument//')'
   end function table_law

   !> A mechanism that is moved wholly.
   subroutine prescribed(draft)
      type(draft_type), intent(inout) :: draft
      integer :: crank, rod, slider
      real(wp) :: angle, r, l, p(2), s(2)
      character(:), allocatable :: shaft, other, name
      draft%title = 'prescribed'
      angle = between(0.2_wp, 2.5_wp)
      r = between(0.1_wp, 0.2_wp)
      l = between(0.4_wp, 0.8_wp)
      p = r*[cos(angle), sin(angle)]
      s = [p(1) + sqrt(l**2 - p(2)**2), 0.0_wp]
      crank = add_rigid(draft, [0.0_wp, 0.0_wp], angle, r)
      rod = bar(draft, p, direction(p, s), l, 'PINNED', 2)
      slider = add_point(draft, s)
      if (likely(3)) then
         name = new_name(draft, 'd')
         call add(draft, name, '*MOTION, NAME=<N|'//name//'>, BODY=<N|'//trim(draft%bodies(crank)%name)//'>'//newline// &
            & ' <P|0|0>, <Q|0|0>, <B|'//t(angle)//' + '//t(between(2.0_wp, 15.0_wp))//'*{t}>')
         call add_channel(draft, name, of_number, moments, 'torque(<N|'//name//'_angle>)', dimension=[1, 2, -2], sign=-1.0_wp)
      else
         call add_joint(shaft, draft, 'REVOLUTE', crank, 1, 0, 1, plain=.true.)
         call drive_angle(draft, crank, shaft)
      end if
      call add_joint(other, draft, 'REVOLUTE', rod, 1, crank, 2)
      call add_joint(other, draft, 'REVOLUTE', rod, 2, slider, 1)
      call add_joint(other, draft, 'POINT ON LINE', slider, 1, 0, 1, 0.0_wp)
      call load(draft, 2)
      select case (pick(4))
      case (1)
         call add(draft, '', '*KINEMATICS, START=<Z|0>, END=<Z|0.5>, OUTPUTS=20', 3)
      case (2)
         call add(draft, '', '*INVERSE DYNAMICS, START=<Z|0>, END=<Z|0.5>, OUTPUTS=20', 3)
      case default
         call run_in_time(draft, 1.0_wp)
      end select
   end subroutine prescribed

   !> Bodies without joints: thrown, on springs and bushings, against walls.
   subroutine loose(draft)
      type(draft_type), intent(inout) :: draft
      real(wp) :: place(2), velocity(2), angle
      integer :: i, body
      draft%title = 'loose'
      do i = 1, pick(3)
         place = [between(-0.5_wp, 0.5_wp), between(-0.5_wp, 0.5_wp)]
         velocity = [between(-1.0_wp, 1.0_wp), between(-1.0_wp, 1.0_wp)]
         angle = between(-3.0_wp, 3.0_wp)
         select case (pick(3))
         case (1); body = add_point(draft, place, velocity)
         case (2); body = add_rigid(draft, place, angle, between(0.2_wp, 0.6_wp), velocity, between(-5.0_wp, 5.0_wp))
         case default
            body = add_beam(draft, place, angle, between(0.4_wp, 0.8_wp), 'FREE', velocity, between(-3.0_wp, 3.0_wp))
            draft%elastic = .true.
         end select
         call hold_by_spring(draft, body)
         if (likely(2)) call add_force(draft, body, 1)
      end do
      call load(draft, 4)
      call run_in_time(draft, 1.0_wp)
   end subroutine loose

end module inventions
