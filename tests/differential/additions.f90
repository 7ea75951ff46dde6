!> Kinds of scenes that came later; every seventh number makes one, so that the others keep theirs.
module additions
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, newline
   use chances, only: pick, between, decades, likely
   use couplings, only: add_joint, add_spring, add_torque, add_gravity, forces, powers, moments
   use drafts, only: draft_type, add, add_ground, add_rigid, add_point, add_beam, add_channel, place_of, ref, t, new_name
   use views, only: of_number
   implicit none
   private
   public :: add_hoist, add_press, add_flywheel, settle_first

   real(wp), parameter :: pi = acos(-1.0_wp)

contains

   !> A bar on a pin, lifted by a driver of the distance of its tip from the ground; a mass that hangs on it.
   subroutine add_hoist(draft)
      type(draft_type), intent(inout) :: draft
      integer :: body, there, mass
      real(wp) :: angle, length, place(2), distance
      character(:), allocatable :: other, name
      draft%title = 'hoist'
      angle = between(-0.8_wp, 0.8_wp)
      length = between(0.3_wp, 0.8_wp)
      if (likely(3)) then
         body = add_beam(draft, [0.0_wp, 0.0_wp], angle, length, 'PINNED')
         draft%elastic = .true.
      else
         body = add_rigid(draft, [0.0_wp, 0.0_wp], angle, length)
      end if
      call add_joint(other, draft, 'REVOLUTE', body, 1, 0, 1)
      place = place_of(draft, body, 2) + [between(-0.2_wp, 0.2_wp), between(0.4_wp, 0.8_wp)]
      there = add_ground(draft, place)
      distance = norm2(place - place_of(draft, body, 2))
      name = new_name(draft, 'd')
      call add(draft, name, '*DRIVER, NAME=<N|'//name//'>, TYPE=DISTANCE, POINT=<N|'//ref(draft, body, 2)//'>, TO=<N|'// &
         & ref(draft, 0, there)//'>'//change_of(distance, between(0.03_wp, 0.2_wp)*distance))
      call ask_driver(draft, name)
      if (likely(2)) then
         mass = add_point(draft, place_of(draft, body, 2) - [0.0_wp, 0.3_wp])
         call add_spring(draft, mass, 1, body, 2)
      end if
      call add_gravity(draft)
   end subroutine add_hoist

   !> A body on a guide whose displacement is driven, and another that swings from it.
   subroutine add_press(draft)
      type(draft_type), intent(inout) :: draft
      integer :: ram, body
      real(wp) :: angle
      character(:), allocatable :: guide, pin, name
      draft%title = 'press'
      angle = between(-1.5_wp, 1.5_wp)
      ram = add_rigid(draft, [0.0_wp, 0.0_wp], between(-3.0_wp, 3.0_wp), between(0.2_wp, 0.5_wp))
      call add_joint(guide, draft, 'TRANSLATIONAL', ram, 1, 0, 1, angle)
      body = add_rigid(draft, place_of(draft, ram, 2), between(-3.0_wp, 3.0_wp), between(0.2_wp, 0.6_wp))
      call add_joint(pin, draft, 'REVOLUTE', body, 1, ram, 2)
      name = new_name(draft, 'd')
      call add(draft, name, '*DRIVER, NAME=<N|'//name//'>, TYPE=DISPLACEMENT, JOINT=<N|'//guide//'>'//change_of(0.0_wp, &
         & between(0.05_wp, 0.3_wp)))
      call ask_driver(draft, name)
      call add_gravity(draft)
   end subroutine add_press

   !> A law of a length about its first value: itself, its rate, or its second rate.
   function change_of(first, size) result(text)
      real(wp), intent(in) :: first, size
      character(:), allocatable :: text, turn
      real(wp) :: omega
      omega = between(3.0_wp, 12.0_wp)
      turn = t(omega)//'*{t}'
      select case (pick(3))
      case (1)
         text = newline//' <R|0,1,0|+|'//t(first)//' + '//t(size)//'*sin('//turn//')>'
      case (2)
         text = ', LEVEL=VELOCITY, INITIAL=<D|0,1,0|+|'//t(first)//'>'//newline//' <R|0,1,-1|+|'//t(size*omega)//'*cos('//turn// &
            & ')>'
      case default
         text = ', LEVEL=ACCELERATION, INITIAL=<D|0,1,0|+|'//t(first)//'>, INITIAL VELOCITY=<D|0,1,-1|+|'//t(size*omega)//'>'// &
            & newline//' <R|0,1,-2|+|-'//t(size*omega**2)//'*sin('//turn//')>'
      end select
   end function change_of

   subroutine ask_driver(draft, name)
      type(draft_type), intent(inout) :: draft
      character(*), intent(in) :: name
      call add_channel(draft, name, of_number, forces, 'force(<N|'//name//'>)', dimension=[1, 1, -2])
      call add_channel(draft, name, of_number, powers, 'power(<N|'//name//'>)', dimension=[1, 2, -3])
   end subroutine ask_driver

   !> What turns many times, freely or driven.
   subroutine add_flywheel(draft)
      type(draft_type), intent(inout) :: draft
      integer :: wheel
      real(wp) :: speed, angle
      character(:), allocatable :: shaft, name
      draft%title = 'flywheel'
      speed = decades(20.0_wp, 600.0_wp)
      angle = between(-3.0_wp, 3.0_wp)
      if (likely(2)) then
         wheel = add_rigid(draft, [0.0_wp, 0.0_wp], angle, 0.2_wp)
         call add_joint(shaft, draft, 'REVOLUTE', wheel, 1, 0, 1, plain=.true.)
         name = new_name(draft, 'd')
         call add(draft, name, '*DRIVER, NAME=<N|'//name//'>, TYPE=ANGLE, BODY=<N|'//trim(draft%bodies(wheel)%name)//'>'// &
            & newline//' <B|'//t(angle)//' + '//t(speed)//'*{t}>')
         call add_channel(draft, name, of_number, moments, 'torque(<N|'//name//'>)', dimension=[1, 2, -2], sign=-1.0_wp)
      else
         wheel = add_rigid(draft, [0.0_wp, 0.0_wp], angle, 0.2_wp, spin=speed)
         call add_joint(shaft, draft, 'REVOLUTE', wheel, 1, 0, 1, plain=.true.)
         call add_torque(draft, wheel, 0)
      end if
      if (likely(2)) call add_gravity(draft)
   end subroutine add_flywheel

   !> Deflections begin in balance.
   subroutine settle_first(draft)
      type(draft_type), intent(inout) :: draft
      integer :: i, at
      do i = 1, size(draft%blocks)
         at = index(draft%blocks(i)%text, '*ASSEMBLY')
         if (at == 0) cycle
         draft%blocks(i)%text = '*ASSEMBLY, INITIAL DEFLECTIONS=STATIC'//draft%blocks(i)%text(len('*ASSEMBLY') + 1:)
      end do
   end subroutine settle_first

end module additions
