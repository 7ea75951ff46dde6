!> A scene while it is invented: its bodies as they stand at first, and the blocks of its deck. Blocks are texts of module `views`.
module drafts
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, newline
   use chances, only: pick, between, decades, likely
   use views, only: block_type, channel_type
   implicit none
   private
   public :: draft_type, body_type, add, add_ground, add_rigid, add_point, add_beam, add_frame, add_channel, place_of, ref, t, &
      & new_name
   public :: is_ground, is_rigid, is_point, is_beam, is_frame

   integer, parameter :: is_ground = 0, is_rigid = 1, is_point = 2, is_beam = 3, is_frame = 4

   type :: body_type
      character(12) :: name = 'ground'
      integer :: kind = is_ground
      !> Of its frame
      real(wp) :: place(2) = 0.0_wp, angle = 0.0_wp
      real(wp) :: length = 0.0_wp
      !> Named points in its frame
      integer :: points = 0
      character(12) :: point(40) = ''
      real(wp) :: local(2, 40) = 0.0_wp
      !> Of a beam: whether it bends, and is in one piece
      logical :: bends = .true., whole = .true.
   end type body_type

   type :: draft_type
      type(block_type), allocatable :: blocks(:)
      type(channel_type), allocatable :: channels(:)
      !> The first is the ground
      type(body_type) :: bodies(0:24)
      integer :: count = 0
      !> Number of the last name
      integer :: names = 0
      !> Simulated time, and samples
      real(wp) :: end = 1.0_wp
      integer :: outputs = 20
      !> Whether it may be turned by quarters only; moved in time; whether CONSERVING may run it
      logical :: by_quarters = .false., timeless = .false., elastic = .false.
      !> The beam or frame whose envelope is asked for; empty: none
      character(12) :: envelope = ''
      !> What it is, for the summary
      character(24) :: title = ''
   end type draft_type

   !> Whether beams are exact ones
   logical, public :: exact_rungs = .false.

contains

   !> A number as text, that reads back as it is.
   pure function t(x) result(text)
      real(wp), intent(in) :: x
      character(:), allocatable :: text
      character(26) :: line
      real(wp) :: back
      write (line, '(es10.2)') x
      read (line, *) back
      if (abs(back - x) > 0.0_wp) write (line, '(es24.16)') x
      text = trim(adjustl(line))
   end function t

   function new_name(draft, letter) result(name)
      type(draft_type), intent(inout) :: draft
      character(*), intent(in) :: letter
      character(:), allocatable :: name
      draft%names = draft%names + 1
      name = letter//as_text(draft%names)
   end function new_name

   !> Adds a block.
   subroutine add(draft, name, text, part)
      type(draft_type), intent(inout) :: draft
      !> Of what it defines, and the block
      character(*), intent(in) :: name, text
      integer, intent(in), optional :: part
      type(block_type) :: block
      if (.not. allocated(draft%blocks)) allocate (draft%blocks(0))
      block%name = name
      block%text = text//newline
      if (present(part)) block%part = part
      draft%blocks = [draft%blocks, block]
   end subroutine add

   !> Adds a channel.
   subroutine add_channel(draft, of, kind, group, first, second, dimension, sign, turned, swaps, placed)
      type(draft_type), intent(inout) :: draft
      character(*), intent(in) :: of, first
      integer, intent(in) :: kind, group
      character(*), intent(in), optional :: second
      integer, intent(in), optional :: dimension(3)
      real(wp), intent(in), optional :: sign, turned
      logical, intent(in), optional :: swaps, placed
      type(channel_type) :: channel
      if (.not. allocated(draft%channels)) allocate (draft%channels(0))
      channel%of = of
      channel%kind = kind
      channel%group = group
      channel%first = first
      if (present(second)) channel%second = second
      if (present(dimension)) channel%dimension = dimension
      if (present(sign)) channel%sign = sign
      if (present(turned)) channel%turned = turned
      if (present(swaps)) channel%swaps = swaps
      if (present(placed)) channel%placed = placed
      draft%channels = [draft%channels, channel]
   end subroutine add_channel

   !> A point of a body as decks call it.
   pure function ref(draft, body, point) result(text)
      type(draft_type), intent(in) :: draft
      integer, intent(in) :: body, point
      character(:), allocatable :: text
      text = trim(draft%bodies(body)%name)
      if (draft%bodies(body)%kind /= is_point) text = text//'.'//trim(draft%bodies(body)%point(point))
   end function ref

   !> Where a point stands.
   pure function place_of(draft, body, point) result(place)
      type(draft_type), intent(in) :: draft
      integer, intent(in) :: body, point
      real(wp) :: place(2)
      associate (b => draft%bodies(body))
         place = b%place + [cos(b%angle)*b%local(1, point) - sin(b%angle)*b%local(2, point), &
            & sin(b%angle)*b%local(1, point) + cos(b%angle)*b%local(2, point)]
      end associate
   end function place_of

   !> Adds a point of the ground; its number there.
   integer function add_ground(draft, place) result(point)
      type(draft_type), intent(inout) :: draft
      real(wp), intent(in) :: place(2)
      character(:), allocatable :: name
      name = new_name(draft, 'g')
      associate (b => draft%bodies(0))
         b%points = b%points + 1
         point = b%points
         b%point(point) = name
         b%local(:, point) = place
      end associate
      call add(draft, '', '*GROUND'//newline//' '//name//', <X|'//t(place(1))//'|'//t(place(2))//'>, <Y|'//t(place(1))//'|'// &
         & t(place(2))//'>')
   end function add_ground

   subroutine add_named(body, name, x, y)
      type(body_type), intent(inout) :: body
      character(*), intent(in) :: name
      real(wp), intent(in) :: x, y
      body%points = body%points + 1
      body%point(body%points) = name
      body%local(:, body%points) = [x, y]
   end subroutine add_named

   !> Where the frame of a body stands, as options.
   function stand(place, angle) result(text)
      real(wp), intent(in) :: place(2)
      real(wp), intent(in), optional :: angle
      character(:), allocatable :: text, both
      both = t(place(1))//'|'//t(place(2))
      text = ', X=<X|'//both//'>, Y=<Y|'//both//'>'
      if (present(angle)) text = text//', ANGLE=<A|'//t(angle)//'>'
   end function stand

   !> A rigid bar from a place along a direction: points origin, tip, side.
   integer function add_rigid(draft, place, angle, length, velocity, spin) result(index)
      type(draft_type), intent(inout) :: draft
      real(wp), intent(in) :: place(2), angle, length
      real(wp), intent(in), optional :: velocity(2), spin
      type(body_type) :: body
      character(:), allocatable :: text
      real(wp) :: mass, centre(2), side(2)
      body%name = new_name(draft, 'b')
      body%kind = is_rigid
      body%place = place
      body%angle = angle
      body%length = length
      mass = decades(0.2_wp, 5.0_wp)
      centre = [length*between(0.2_wp, 0.7_wp), length*between(-0.1_wp, 0.1_wp)]
      side = [length*between(0.3_wp, 0.8_wp), length*between(-0.3_wp, 0.3_wp)]
      call add_named(body, 'origin', 0.0_wp, 0.0_wp)
      call add_named(body, 'tip', length, 0.0_wp)
      call add_named(body, 'side', side(1), side(2))
      text = '*RIGID BODY, NAME=<N|'//trim(body%name)//'>, MASS=<D|1,0,0|+|'//t(mass)//'>, INERTIA=<D|1,2,0|+|'// &
         & t(mass*length**2*between(0.05_wp, 0.2_wp))//'>, CENTRE X=<D|0,1,0|+|'//t(centre(1))//'>, CENTRE Y=<D|0,1,0|-|'// &
         & t(centre(2))//'>'//stand(place, angle)
      text = text//motion_of(velocity, spin)
      text = text//newline//' tip, <D|0,1,0|+|'//t(length)//'>, 0'//newline//' side, <D|0,1,0|+|'//t(side(1))// &
         & '>, <D|0,1,0|-|'//t(side(2))//'>'
      call add(draft, body%name, text)
      index = kept(draft, body)
   end function add_rigid

   function motion_of(velocity, spin) result(text)
      real(wp), intent(in), optional :: velocity(2), spin
      character(:), allocatable :: text, both
      text = ''
      if (present(velocity)) then
         both = t(velocity(1))//'|'//t(velocity(2))
         text = ', VX=<U|0,1,-1|'//both//'>, VY=<V|0,1,-1|'//both//'>'
      end if
      if (present(spin)) text = text//', SPIN=<D|0,0,-1|-|'//t(spin)//'>'
   end function motion_of

   integer function kept(draft, body) result(index)
      type(draft_type), intent(inout) :: draft
      type(body_type), intent(in) :: body
      draft%count = draft%count + 1
      index = draft%count
      draft%bodies(index) = body
   end function kept

   !> A point mass.
   integer function add_point(draft, place, velocity) result(index)
      type(draft_type), intent(inout) :: draft
      real(wp), intent(in) :: place(2)
      real(wp), intent(in), optional :: velocity(2)
      type(body_type) :: body
      body%name = new_name(draft, 'p')
      body%kind = is_point
      body%place = place
      call add_named(body, 'origin', 0.0_wp, 0.0_wp)
      call add(draft, body%name, '*POINT MASS, NAME=<N|'//trim(body%name)//'>, MASS=<D|1,0,0|+|'//t(decades(0.1_wp, 5.0_wp))// &
         & '>'//stand(place)//motion_of(velocity))
      index = kept(draft, body)
   end function add_point

   !> A material and a section; what stands for them in a beam.
   function new_stuff(draft, length) result(text)
      type(draft_type), intent(inout) :: draft
      real(wp), intent(in) :: length
      character(:), allocatable :: text, material, section
      real(wp) :: thick
      material = new_name(draft, 'm')
      section = new_name(draft, 's')
      thick = length*between(0.015_wp, 0.05_wp)
      if (likely(2)) then
         call add(draft, material, '*MATERIAL, NAME=<N|'//material//'>, YOUNG=<D|1,-1,-2|+|'//t(decades(1.0e9_wp, 1.0e10_wp))// &
            & '>, DENSITY=<D|1,-3,0|+|1200>', 1)
      else
         call add(draft, material, '*MATERIAL, NAME=<N|'//material//'>, YOUNG=<D|1,-1,-2|+|7e10>, DENSITY=<D|1,-3,0|+|2700>', 1)
      end if
      select case (pick(3))
      case (1); text = 'CIRCLE, DIAMETER=<D|0,1,0|+|'//t(thick)//'>'
      case (2); text = 'RECTANGLE, WIDTH=<D|0,1,0|+|'//t(2*thick)//'>, HEIGHT=<D|0,1,0|+|'//t(thick)//'>'
      case default; text = 'TUBE, DIAMETER=<D|0,1,0|+|'//t(thick)//'>, THICKNESS=<D|0,1,0|+|'//t(thick/10)//'>'
      end select
      call add(draft, section, '*SECTION, NAME=<N|'//section//'>, SHAPE='//text, 1)
      text = ', MATERIAL=<N|'//material//'>, SECTION=<N|'//section//'>'
   end function new_stuff

   !> A beam: points start, end, middle and one at a third; how its ends are held decides its functions.
   integer function add_beam(draft, place, angle, length, support, velocity, spin, in_one_piece) result(index)
      type(draft_type), intent(inout) :: draft
      real(wp), intent(in) :: place(2), angle, length
      !> PINNED, CLAMPED or FREE
      character(*), intent(in) :: support
      real(wp), intent(in), optional :: velocity(2), spin
      logical, intent(in), optional :: in_one_piece
      type(body_type) :: body
      character(:), allocatable :: text, rung
      body%name = new_name(draft, 'b')
      body%kind = is_beam
      body%place = place
      body%angle = angle
      body%length = length
      call add_named(body, 'start', 0.0_wp, 0.0_wp)
      call add_named(body, 'end', length, 0.0_wp)
      call add_named(body, 'middle', length/2, 0.0_wp)
      call add_named(body, 'third', length/4, 0.0_wp)
      rung = rung_of(support)
      if (present(in_one_piece) .and. (has(rung, 'SEGMENTS') .or. has(rung, 'RIGID'))) &
         & rung = ', GEOMETRIC=LINEAR, BENDING MODES=3, AXIAL MODES=1'
      body%bends = .not. has(rung, 'RIGID')
      body%whole = .not. has(rung, 'SEGMENTS')
      text = '*BEAM, NAME=<N|'//trim(body%name)//'>'//new_stuff(draft, length)//', LENGTH=<D|0,1,0|+|'//t(length)//'>'// &
         & rung//stand(place, angle)//motion_of(velocity, spin)//newline//' third, <D|0,1,0|+|'//t(length/4)//'>'
      call add(draft, body%name, text)
      index = kept(draft, body)
      if (body%bends .and. likely(3)) call add(draft, '', '*DAMPING, BODY=<N|'//trim(body%name)//'>, '//trim(damping()))
   end function add_beam

   pure logical function has(text, word)
      character(*), intent(in) :: text, word
      has = index(text, word) > 0
   end function has

   function damping() result(text)
      character(:), allocatable :: text
      select case (pick(3))
      case (1); text = 'RATIO='//t(decades(1.0e-3_wp, 0.1_wp))
      case (2); text = 'RAYLEIGH BETA=<D|0,0,1|+|'//t(decades(1.0e-6_wp, 1.0e-4_wp))//'>'
      case default; text = 'RAYLEIGH ALPHA=<D|0,0,-1|+|'//t(between(0.1_wp, 3.0_wp))//'>'
      end select
   end function damping

   !> Fidelity of a beam, by chance.
   function rung_of(support) result(text)
      character(*), intent(in) :: support
      character(:), allocatable :: text
      select case (support)
      case ('CLAMPED'); text = ', SUPPORT=CLAMPED-FREE'
      case ('FREE'); text = ', SUPPORT=FREE-FREE'
      case default; text = ', SUPPORT=PINNED-ROLLER'
      end select
      if (exact_rungs) then
         text = exact_rung()
         return
      end if
      select case (pick(10))
      case (1); text = text//', GEOMETRIC=RIGID'
      case (2, 3); text = text//', GEOMETRIC=LINEAR, BENDING MODES='//as_text(pick(3))//', AXIAL MODES='//as_text(pick(3) - 1)
      case (4, 5); text = text//', GEOMETRIC=K_G, BENDING MODES='//as_text(pick(3))//', AXIAL MODES='//as_text(pick(2))
      case (6); text = ''
      case (7); text = exact_rung()
      case (8); text = ', GEOMETRIC=EXACT, FUNCTIONS='//as_text(2 + pick(3))//', SEGMENTS='//as_text(1 + pick(2))
      case (9); text = text//', GEOMETRIC=LINEAR, BENDING MODES=2, AXIAL MODES=1, CORRECTIONS=YES'
      case (10); text = text//', GEOMETRIC=K_G, BENDING MODES=2, AXIAL BASIS=STATIC'
      end select
      if (likely(4) .and. index(text, 'MODES') > 0 .and. support == 'CLAMPED') text = text//', CORRECTIONS=YES'
   end function rung_of

   !> An exact beam.
   function exact_rung() result(text)
      character(:), allocatable :: text
      text = '<J|'//as_text(2 + pick(4))//'|'//as_text(pick(3) - 1)//'>'
   end function exact_rung

   !> A frame of two legs and a girder, or of a leg and an arm: points foot, knee, far.
   integer function add_frame(draft, place, angle, length) result(index)
      type(draft_type), intent(inout) :: draft
      real(wp), intent(in) :: place(2), angle, length
      type(body_type) :: body
      character(:), allocatable :: text
      real(wp) :: far(2)
      body%name = new_name(draft, 'f')
      body%kind = is_frame
      body%place = place
      body%angle = angle
      body%length = length
      far = [length*between(0.7_wp, 1.0_wp), length*between(0.3_wp, 0.6_wp)]
      call add_named(body, 'foot', 0.0_wp, 0.0_wp)
      call add_named(body, 'far', far(1), far(2))
      call add_named(body, 'post', length*0.3_wp, 0.0_wp)
      call add_named(body, 'knee', length*0.5_wp, 0.0_wp)
      text = '*FRAME, NAME=<N|'//trim(body%name)//'>'//new_stuff(draft, length)//', DIVISIONS=4, MODES='//as_text(1 + pick(4))
      select case (pick(4))
      case (1); text = text//', GEOMETRIC=LINEAR'
      case (2); text = text//', GEOMETRIC=K_G, CORRECTIONS=NO'
      case default; text = text//', GEOMETRIC=K_G'
      end select
      text = text//stand(place, angle)//newline//' post, 1, <D|0,1,0|+|'//t(length*0.3_wp)//'>'//newline// &
         & '*NODE, BODY=<N|'//trim(body%name)//'>'//newline//' 1, 0, 0, foot'//newline// &
         & ' 2, <D|0,1,0|+|'//t(length*0.5_wp)//'>, 0, knee'//newline//' 3, <D|0,1,0|+|'//t(far(1))//'>, <D|0,1,0|-|'// &
         & t(far(2))//'>, far'//newline//'*ELEMENT, BODY=<N|'//trim(body%name)//'>'//newline//' 1, 1, 2'//newline//' 2, 2, 3'
      text = text//newline//'*BOUNDARY, BODY=<N|'//trim(body%name)//'>'//newline//' 1, 1, 6'
      if (likely(2)) text = text//newline//'*MASS, BODY=<N|'//trim(body%name)//'>'//newline//' 3, <D|1,0,0|+|'// &
         & t(between(0.05_wp, 0.5_wp))//'>, <D|1,2,0|+|1e-3>'
      call add(draft, body%name, text)
      index = kept(draft, body)
   end function add_frame

end module drafts
