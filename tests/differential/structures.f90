!> Scenes by chance of structures: equilibrium, buckling, steady rotation, and small vibrations about them.
module structures
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, newline
   use chances, only: pick, between, decades, likely
   use couplings, only: add_joint, add_bushing, add_turning_spring, add_spread_load, add_gravity, hold_by_spring, forces, moments, &
      & deflections
   use drafts, only: draft_type, add, add_ground, add_rigid, add_point, add_beam, add_frame, add_channel, place_of, ref, t, &
      & new_name, is_beam, is_frame
   use views, only: of_number
   implicit none
   private
   public :: add_structure, add_rotor, add_column

   real(wp), parameter :: pi = acos(-1.0_wp)

contains

   !> A structure that stands still: equilibrium, vibrations, and what comes of it when it is let go.
   subroutine add_structure(draft)
      type(draft_type), intent(inout) :: draft
      integer :: body, mass, there
      real(wp) :: length, angle
      character(:), allocatable :: other
      draft%title = 'statics'
      draft%timeless = .true.
      draft%elastic = .true.
      length = between(0.4_wp, 1.0_wp)
      angle = between(-3.0_wp, 3.0_wp)
      select case (pick(5))
      case (1)
         body = add_frame(draft, [0.1_wp, 0.0_wp], angle, length)
         there = add_ground(draft, [0.1_wp, 0.0_wp])
         call add_joint(other, draft, 'WELD', body, 1, 0, there)
      case (2)
         body = add_beam(draft, [0.1_wp, 0.0_wp], angle, length, 'CLAMPED')
         there = add_ground(draft, [0.1_wp, 0.0_wp])
         call add_joint(other, draft, 'WELD', body, 1, 0, there)
         if (likely(3)) then
            mass = add_point(draft, place_of(draft, body, 2))
            call add_joint(other, draft, 'REVOLUTE', mass, 1, body, 2)
         end if
      case (3)
         body = add_beam(draft, [0.0_wp, 0.0_wp], angle, length, 'PINNED')
         call add_joint(other, draft, 'REVOLUTE', body, 1, 0, 1)
         there = add_ground(draft, place_of(draft, body, 2))
         call add_joint(other, draft, 'POINT ON LINE', body, 2, 0, there, angle)
      case (4)
         body = add_rigid(draft, [0.0_wp, 0.0_wp], angle, length)
         call add_joint(other, draft, 'REVOLUTE', body, 1, 0, 1)
         call hold_by_spring(draft, body)
         call add_turning_spring(draft, body, 1, 0, 1)
      case default
         body = add_rigid(draft, [0.0_wp, 0.0_wp], angle, length)
         call add_bushing(draft, body, 1, 0, 1)
         mass = add_point(draft, place_of(draft, body, 2))
         call add_joint(other, draft, 'REVOLUTE', mass, 1, body, 2)
      end select
      if (.not. likely(4)) call add_gravity(draft)
      if (likely(2)) call push(draft, body)
      if (likely(3)) call add_spread_load_safely(draft, body)
      call add(draft, '', '*STATICS, PERIOD=<D|0,0,1|+|1>, INCREMENTS='//as_text(pick(5)), 3)
      if (likely(2)) call add(draft, '', '*MODES, NUMBER=3'//trim(merge(', DAMPED', '        ', likely(3))), 3)
      if (likely(3)) then
         if (likely(2)) call push(draft, body)
         call add(draft, '', '*DYNAMICS, END=<D|0,0,1|+|1.1>, OUTPUTS=10<O>', 3)
      end if
   end subroutine add_structure

   !> A constant force.
   subroutine push(draft, body)
      type(draft_type), intent(inout) :: draft
      integer, intent(in) :: body
      character(:), allocatable :: name, both
      name = new_name(draft, 'w')
      both = t(between(-3.0_wp, 3.0_wp))//'|'//t(between(-3.0_wp, 3.0_wp))
      call add(draft, name, '*FORCE, NAME=<N|'//name//'>, POINT=<N|'//trim(draft%bodies(body)%name)//'.'// &
         & trim(draft%bodies(body)%point(2))//'>'//newline//' <F|1,1,-2|'//both//'>, <G|1,1,-2|'//both//'>')
   end subroutine push

   subroutine add_spread_load_safely(draft, body)
      type(draft_type), intent(inout) :: draft
      integer, intent(in) :: body
      if (any(draft%bodies(body)%kind == [is_beam, is_frame])) call add_spread_load(draft, body)
   end subroutine add_spread_load_safely

   !> A beam or a mass in steady rotation, and its vibrations.
   subroutine add_rotor(draft)
      type(draft_type), intent(inout) :: draft
      integer :: body, hub
      real(wp) :: angle, speed, length
      character(:), allocatable :: other
      draft%title = 'rotation'
      draft%timeless = .true.
      draft%elastic = .true.
      angle = between(-3.0_wp, 3.0_wp)
      length = between(0.3_wp, 0.8_wp)
      speed = between(1.0_wp, 10.0_wp)
      select case (pick(3))
      case (1)
         body = add_beam(draft, [0.0_wp, 0.0_wp], angle, length, 'CLAMPED')
         call add_joint(other, draft, 'WELD', body, 1, 0, 1)
      case (2)
         hub = add_ground(draft, 0.3_wp*[cos(angle), sin(angle)])
         body = add_frame(draft, 0.3_wp*[cos(angle), sin(angle)], angle, length)
         call add_joint(other, draft, 'WELD', body, 1, 0, hub)
      case default
         hub = add_ground(draft, 0.3_wp*[cos(angle), sin(angle)])
         body = add_rigid(draft, 0.3_wp*[cos(angle), sin(angle)], angle, length)
         call add_bushing(draft, body, 1, 0, hub)
      end select
      call add(draft, '', '*STATICS, PERIOD=<D|0,0,1|+|1>, INCREMENTS=2, ROTATION=<D|0,0,-1|-|'//t(speed)// &
         & '>, CENTRE X=<X|0|0>, CENTRE Y=<Y|0|0>', 3)
      call add(draft, '', '*MODES, NUMBER=3'//trim(merge(', DAMPED', '        ', likely(2))), 3)
   end subroutine add_rotor

   !> A column under a compression up to its buckling load and beyond, and a small force aside.
   subroutine add_column(draft)
      type(draft_type), intent(inout) :: draft
      integer :: there
      real(wp) :: length, angle, thick, critical, load, along(2)
      character(:), allocatable :: material, section, name, rung, other, both, beam
      logical :: clamped
      draft%title = 'column'
      draft%timeless = .true.
      draft%elastic = .true.
      length = between(0.5_wp, 1.0_wp)
      angle = between(-3.0_wp, 3.0_wp)
      along = [cos(angle), sin(angle)]
      thick = length*between(0.01_wp, 0.03_wp)
      clamped = likely(2)
      critical = 7.0e10_wp*pi**2/length**2*2*thick*thick**3/12*merge(0.25_wp, 1.0_wp, clamped)
      material = new_name(draft, 'm')
      section = new_name(draft, 's')
      call add(draft, material, '*MATERIAL, NAME=<N|'//material//'>, YOUNG=<D|1,-1,-2|+|7e10>, DENSITY=<D|1,-3,0|+|2700>', 1)
      call add(draft, section, '*SECTION, NAME=<N|'//section//'>, SHAPE=RECTANGLE, WIDTH=<D|0,1,0|+|'//t(2*thick)// &
         & '>, HEIGHT=<D|0,1,0|+|'//t(thick)//'>', 1)
      if (likely(2)) then
         rung = ', GEOMETRIC=EXACT, FUNCTIONS='//as_text(3 + pick(3))//', STRAIN FUNCTIONS=1'
         load = between(0.3_wp, 1.4_wp)*critical
      else
         rung = ', GEOMETRIC=K_G, BENDING MODES='//as_text(1 + pick(3))//', AXIAL MODES=1, SUPPORT='// &
            & trim(merge('CLAMPED-FREE ', 'PINNED-ROLLER', clamped))
         load = between(0.3_wp, 0.97_wp)*critical
      end if
      beam = new_name(draft, 'b')
      both = '0|0'
      call add(draft, beam, '*BEAM, NAME=<N|'//beam//'>, MATERIAL=<N|'//material//'>, SECTION=<N|'//section// &
         & '>, LENGTH=<D|0,1,0|+|'//t(length)//'>'//rung//', X=<X|'//both//'>, Y=<Y|'//both//'>, ANGLE=<A|'//t(angle)//'>')
      other = new_name(draft, 'j')
      if (clamped) then
         call add(draft, other, '*JOINT, NAME=<N|'//other//'>, TYPE=WELD, TURN=<S|'//beam//'|ground|'//t(angle)//'>'//newline// &
            & ' <N|'//beam//'.start>, <N|'//ref(draft, 0, 1)//'>')
      else
         call add(draft, other, '*JOINT, NAME=<N|'//other//'>, TYPE=REVOLUTE'//newline//' <N|'//beam//'.start>, <N|'// &
            & ref(draft, 0, 1)//'>')
         there = add_ground(draft, length*along)
         other = new_name(draft, 'j')
         call add(draft, other, '*JOINT, NAME=<N|'//other//'>, TYPE=POINT ON LINE, ANGLE=<S|space|ground|'//t(angle)//'>'// &
            & newline//' <N|'//beam//'.end>, <N|'//ref(draft, 0, there)//'>')
      end if
      call push(beam//'.end', -load*along)
      call push(beam//'.'//trim(merge('end   ', 'middle', clamped)), decades(1.0e-3_wp, 1.0e-2_wp)*load*[-along(2), along(1)])
      call add_channel(draft, beam, of_number, deflections, 'deflection(<N|'//beam//'.middle>)', dimension=[0, 1, 0], sign=-1.0_wp)
      call add_channel(draft, beam, of_number, moments, 'bending_moment(<N|'//beam//'.middle>)', dimension=[1, 2, -2], sign=-1.0_wp)
      call add_channel(draft, beam, of_number, forces, 'axial_force(<N|'//beam//'.middle>)', dimension=[1, 1, -2])
      name = ', INSTABILITY='//trim(merge('STAY ', 'LEAVE', likely(3)))
      call add(draft, '', '*STATICS, PERIOD=<D|0,0,1|+|1>, INCREMENTS='//as_text(2 + pick(8))//name, 3)
      if (likely(2)) call add(draft, '', '*MODES, NUMBER=2', 3)

   contains

      subroutine push(point, force)
         character(*), intent(in) :: point
         real(wp), intent(in) :: force(2)
         character(:), allocatable :: of, pair
         of = new_name(draft, 'w')
         pair = t(force(1))//'|'//t(force(2))
         call add(draft, of, '*FORCE, NAME=<N|'//of//'>, POINT=<N|'//point//'>'//newline//' <F|1,1,-2|'//pair//'>, <G|1,1,-2|'// &
            & pair//'>')
      end subroutine push

   end subroutine add_column

end module structures
