!> Motion of the scene in a results file. The coordinates of all bodies at each sample, and what is drawn of them. With it a
!> mechanism can be drawn from the file alone. Floor: output; `limber_output_outline` makes the geometry of a model.
!>
!>     /motion/coordinates            (time, k): all bodies one after another; of a point mass x, y; of any other body x, y of
!>                                    its frame, cosine and sine of the frame's angle, then its n coordinates of deflection
!>     /motion/body_names             a text, one name in a line; /motion/body_widths: how many coordinates each has
!>     /motion/places                 (place, 2): undeformed, in the frame of its body
!>     /motion/place_bodies           (place): number of its body from 1, 0 for the ground
!>     /motion/place_names            a text, one name in a line: 'rod.middle', or none
!>     /motion/shapes                 x, y of the displacement for each coordinate of deflection, for each place on a body that
!>                                    has any, one after another
!>     /motion/stroke_places          numbers of places from 1: outlines of bodies, one stroke after another
!>     /motion/stroke_widths          how many places each stroke has; /motion/stroke_closed: 1 if its ends meet
!>     /motion/connection_names, /motion/connection_types   texts, one line for each joint and spring
!>     /motion/connection_places      pairs of numbers of places: what each connects
!>     /motion/connection_angles      (connection): direction of a line, in the frame of the second place's body [rad]
!>     /motion/connection_radii       pairs of radii of wheels around the two places, 0 where there is none
module limber_output_motion_record
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use limber_base_error, only: error_type, raise, status_deck
   use limber_base_kinds, only: wp
   use limber_base_text, only: newline
   use limber_output_hdf5_read, only: longest_name
   use limber_output_history, only: history_type
   use limber_output_history_reader, only: history_reader_type
   implicit none
   private
   public :: geometry_type, motion_record_type, prepare, define_motion, read_motion, find_place, deflections, frame_axis

   !> What is drawn, and which coordinates move it
   type :: geometry_type
      !> Names of bodies, of places, and of connections
      character(longest_name), allocatable :: bodies(:), place_names(:), connections(:)
      !> Number of coordinates of each body (bodies): 2, or 4 and those of its deflection
      integer, allocatable :: widths(:)
      !> Undeformed places in the frames of their bodies (2, places) [length], and those bodies, 0 the ground (places)
      real(wp), allocatable :: places(:, :)
      integer, allocatable :: place_bodies(:)
      !> Displacements of places for each coordinate of deflection
      real(wp), allocatable :: shapes(:)
      !> Strokes: places of all one after another, how many each has, and whether its ends meet (1) or not (0)
      integer, allocatable :: stroke_places(:), stroke_widths(:), stroke_closed(:)
      !> Types of connections as decks call them, their two places (2, connections), directions of lines [rad]
      character(longest_name), allocatable :: connection_types(:)
      integer, allocatable :: connection_places(:, :)
      real(wp), allocatable :: connection_angles(:)
      !> Radii of wheels around the two places (2, connections) [length]
      real(wp), allocatable :: connection_radii(:, :)
      !> Follows from the rest (`prepare`): first coordinate of each body, first entry in `shapes` of each place, first place of
      !> each stroke, and two places of each body that are connected to others, or 0: (2, bodies)
      integer, allocatable :: first(:), first_shape(:), first_place(:), anchors(:, :)
      !> Of a piece of a beam the first piece, which has the anchors of the whole; 0: it is none (bodies). Undeformed places in the
      !> frame of the first piece, or of the body (2, places)
      integer, allocatable :: root(:)
      real(wp), allocatable :: unbent(:, :)
   end type geometry_type

   !> A motion that was read
   type :: motion_record_type
      type(geometry_type) :: geometry
      !> Times (samples), and coordinates at them (k, samples)
      real(wp), allocatable :: time(:), coordinates(:, :)
      !> Heading of its deck, units of length and time
      character(:), allocatable :: heading, length_units, time_units
   end type motion_record_type

   !> What is farther than this is nowhere: its square would be no number
   real(wp), parameter :: far = 1.0e100_wp

contains

   !> Works out what follows from the rest.
   pure subroutine prepare(geometry)
      type(geometry_type), intent(inout) :: geometry
      integer :: i, k, body
      associate (g => geometry)
         allocate (g%first(size(g%bodies)), g%first_shape(size(g%place_bodies)), g%first_place(size(g%stroke_widths)), &
            & g%anchors(2, size(g%bodies)))
         k = 1
         do i = 1, size(g%bodies)
            g%first(i) = k
            k = k + g%widths(i)
         end do
         k = 1
         do i = 1, size(g%place_bodies)
            g%first_shape(i) = k
            k = k + 2*deflections(g, g%place_bodies(i))
         end do
         k = 1
         do i = 1, size(g%stroke_widths)
            g%first_place(i) = k
            k = k + g%stroke_widths(i)
         end do
         call join_pieces(g)
         g%anchors = 0
         do i = 1, size(g%connection_places, 2)
            if (g%connection_types(i) == 'SEGMENTS') cycle
            do k = 1, 2
               body = g%place_bodies(g%connection_places(k, i))
               if (body == 0) cycle
               if (g%root(body) > 0) body = g%root(body)
               call take_anchor(g%unbent, g%connection_places(k, i), g%anchors(:, body))
            end do
         end do
      end associate
   end subroutine prepare

   !> Lays the pieces of each beam in segments one after another, as they are joined.
   pure subroutine join_pieces(g)
      type(geometry_type), intent(inout) :: g
      real(wp) :: offset(2, size(g%bodies))
      integer :: i, k, places(2), bodies(2)
      allocate (g%root(size(g%bodies)), g%unbent(2, size(g%place_bodies)))
      g%root = 0
      offset = 0.0_wp
      do i = 1, size(g%connection_places, 2)
         if (g%connection_types(i) /= 'SEGMENTS') cycle
         places = g%connection_places(:, i)
         bodies = g%place_bodies(places)
         if (bodies(1) > bodies(2)) then
            places = places([2, 1])
            bodies = bodies([2, 1])
         end if
         if (g%root(bodies(1)) == 0) g%root(bodies(1)) = bodies(1)
         g%root(bodies(2)) = g%root(bodies(1))
         offset(:, bodies(2)) = offset(:, bodies(1)) + g%places(:, places(1)) - g%places(:, places(2))
      end do
      g%unbent = g%places
      do k = 1, size(g%place_bodies)
         if (g%place_bodies(k) > 0) g%unbent(:, k) = g%unbent(:, k) + offset(:, g%place_bodies(k))
      end do
   end subroutine join_pieces

   !> Keeps of the connected places of a body the first one and the one farthest from it.
   pure subroutine take_anchor(places, place, anchors)
      real(wp), intent(in) :: places(:, :)
      integer, intent(in) :: place
      integer, intent(inout) :: anchors(2)
      real(wp) :: distance, longest
      if (anchors(1) == 0) then
         anchors(1) = place
         return
      end if
      longest = 0.0_wp
      if (anchors(2) > 0) longest = norm2(places(:, anchors(2)) - places(:, anchors(1)))
      distance = norm2(places(:, place) - places(:, anchors(1)))
      if (distance > longest) anchors(2) = place
   end subroutine take_anchor

   !> Number of coordinates of deflection of a body, or of the ground.
   pure integer function deflections(geometry, body)
      type(geometry_type), intent(in) :: geometry
      integer, intent(in) :: body
      deflections = 0
      if (body > 0) deflections = max(0, geometry%widths(body) - 4)
   end function deflections

   !> Writes the geometry and makes the series of the coordinates; after the channels, before the first sample.
   subroutine define_motion(geometry, units, history, error)
      type(geometry_type), intent(in) :: geometry
      !> Unit of length
      character(*), intent(in) :: units
      !> Open history
      type(history_type), intent(inout) :: history
      !> Allocated if it cannot be written
      type(error_type), allocatable, intent(out) :: error
      call history%put_group('/motion', error)
      if (.not. allocated(error)) call history%define_series('/motion/coordinates', sum(geometry%widths), 'mixed', &
         & 'x, y, cosine and sine of the angle of each frame, coordinates of deflection; of point masses x, y', error)
      if (.not. allocated(error)) call history%put_text('/motion/body_names', lines_of(geometry%bodies), error)
      call put_integers('body_widths', geometry%widths, 'numbers of coordinates of bodies')
      if (.not. allocated(error)) call history%put_real('/motion/places', geometry%places, units, &
         & 'undeformed places in the frames of their bodies', error)
      call put_integers('place_bodies', geometry%place_bodies, 'bodies of places, 0 the ground')
      if (.not. allocated(error)) call history%put_text('/motion/place_names', lines_of(geometry%place_names), error)
      call put_reals('shapes', geometry%shapes, 'displacements x, y of places for each coordinate of deflection')
      call put_integers('stroke_places', geometry%stroke_places, 'places of outlines')
      call put_integers('stroke_widths', geometry%stroke_widths, 'numbers of places of outlines')
      call put_integers('stroke_closed', geometry%stroke_closed, '1 if the ends of an outline meet')
      if (.not. allocated(error)) call history%put_text('/motion/connection_names', lines_of(geometry%connections), error)
      if (.not. allocated(error)) call history%put_text('/motion/connection_types', lines_of(geometry%connection_types), error)
      call put_integers('connection_places', reshape(geometry%connection_places, [size(geometry%connection_places)]), &
         & 'pairs of places that joints and springs connect')
      call put_reals('connection_angles', geometry%connection_angles, 'directions of lines in the frame of the second body')
      call put_reals('connection_radii', reshape(geometry%connection_radii, [size(geometry%connection_radii)]), &
         & 'pairs of radii of wheels')

   contains

      !> Lists without members are not written.
      subroutine put_integers(name, values, long_name)
         character(*), intent(in) :: name, long_name
         integer, intent(in) :: values(:)
         if (.not. allocated(error) .and. size(values) > 0) call history%put_integer('/motion/'//name, values, long_name, error)
      end subroutine put_integers

      subroutine put_reals(name, values, long_name)
         character(*), intent(in) :: name, long_name
         real(wp), intent(in) :: values(:)
         if (.not. allocated(error) .and. size(values) > 0) &
            & call history%put_real('/motion/'//name, values, 'mixed', long_name, error)
      end subroutine put_reals

   end subroutine define_motion

   !> Reads the motion of a results file.
   subroutine read_motion(reader, motion, error)
      !> Open reader
      type(history_reader_type), intent(in) :: reader
      type(motion_record_type), intent(out) :: motion
      !> Allocated if the file has none, or it cannot be read
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: pairs(:), radii(:)
      if (.not. reader%has('/motion')) then
         call raise(error, reader%path//' has no motion to draw; run its deck with *OUTPUT, MOTION=YES', status_deck)
         return
      end if
      associate (g => motion%geometry)
         motion%time_units = reader%time_units
         call reader%read_label('/run', 'heading', motion%heading, error)
         if (.not. allocated(error)) call reader%read_label('/motion/places', 'units', motion%length_units, error)
         if (.not. allocated(error)) call reader%read_time(motion%time, error)
         if (.not. allocated(error)) call reader%read_table('/motion/coordinates', motion%coordinates, error)
         if (.not. allocated(error)) call read_lines('body_names', g%bodies)
         call read_integers('body_widths', g%widths)
         if (.not. allocated(error)) call reader%read_table('/motion/places', g%places, error)
         call read_integers('place_bodies', g%place_bodies)
         call read_lines('place_names', g%place_names)
         call read_reals('shapes', g%shapes)
         call read_integers('stroke_places', g%stroke_places)
         call read_integers('stroke_widths', g%stroke_widths)
         call read_integers('stroke_closed', g%stroke_closed)
         call read_lines('connection_names', g%connections)
         call read_lines('connection_types', g%connection_types)
         call read_reals('connection_places', pairs)
         call read_reals('connection_angles', g%connection_angles)
         call read_reals('connection_radii', radii)
         if (.not. allocated(error)) call check_motion(reader%path, motion, pairs, radii, error)
         if (allocated(error)) return
         if (size(motion%time) > size(motion%coordinates, 2)) motion%time = motion%time(:size(motion%coordinates, 2))
         allocate (g%connection_places(2, size(pairs)/2), g%connection_radii(2, size(pairs)/2))
         g%connection_radii = reshape(radii, shape(g%connection_radii))
         g%connection_places = reshape(nint(pairs), shape(g%connection_places))
         call prepare(g)
      end associate

   contains

      subroutine read_reals(name, values)
         character(*), intent(in) :: name
         real(wp), allocatable, intent(out) :: values(:)
         if (allocated(error)) return
         if (reader%has('/motion/'//name)) then
            call reader%read_numbers('/motion/'//name, values, error)
         else
            allocate (values(0))
         end if
      end subroutine read_reals

      subroutine read_integers(name, values)
         character(*), intent(in) :: name
         integer, allocatable, intent(out) :: values(:)
         real(wp), allocatable :: numbers(:)
         call read_reals(name, numbers)
         if (allocated(error)) return
         if (.not. are_whole(numbers)) then
            call raise(error, reader%path//': /motion/'//name//' has other numbers than whole ones: the file is damaged', &
               & status_deck)
            return
         end if
         allocate (values(size(numbers)))
         values = nint(numbers)
      end subroutine read_integers

      subroutine read_lines(name, lines)
         character(*), intent(in) :: name
         character(longest_name), allocatable, intent(out) :: lines(:)
         character(:), allocatable :: text
         if (allocated(error)) return
         call reader%read_text('/motion/'//name, text, error)
         if (.not. allocated(error)) call split_lines(text, lines)
      end subroutine read_lines

   end subroutine read_motion

   !> Whether all are whole numbers that an integer can be.
   pure logical function are_whole(numbers)
      real(wp), intent(in) :: numbers(:)
      are_whole = all(ieee_is_finite(numbers))
      if (are_whole) are_whole = all(abs(numbers) <= 1.0e9_wp)
      if (are_whole) are_whole = all(abs(numbers - anint(numbers)) <= 0.0_wp)
   end function are_whole

   !> Whether all are numbers that can be drawn.
   elemental logical function is_near(number)
      real(wp), intent(in) :: number
      is_near = ieee_is_finite(number)
      if (is_near) is_near = abs(number) < far
   end function is_near

   !> Refuses lists that do not fit together, numbers of places and bodies that there are not, and what is no number.
   subroutine check_motion(path, motion, pairs, radii, error)
      !> Name of the file
      character(*), intent(in) :: path
      type(motion_record_type), intent(in) :: motion
      !> Places and radii of connections, one after another
      real(wp), intent(in) :: pairs(:), radii(:)
      type(error_type), allocatable, intent(out) :: error
      integer :: bodies, places, connections
      associate (g => motion%geometry)
         bodies = size(g%bodies)
         places = size(g%place_names)
         connections = size(g%connections)
         call need(size(g%widths) == bodies .and. all(g%widths == 2 .or. g%widths >= 4), 'body_widths')
         call need(sum(real(g%widths, wp)) <= 1.0e9_wp, 'body_widths')
         if (.not. allocated(error)) call need(sum(g%widths) == size(motion%coordinates, 1), 'coordinates')
         call need(all(is_near(motion%coordinates)) .and. all(is_near(motion%time)), 'coordinates')
         call need(size(g%place_bodies) == places .and. all(g%place_bodies >= 0 .and. g%place_bodies <= bodies), 'place_bodies')
         call need(size(g%places, 1) == 2 .and. size(g%places, 2) == places .and. all(is_near(g%places)), 'places')
         if (.not. allocated(error)) call need(size(g%shapes) == 2*all_deflections(g) .and. all(is_near(g%shapes)), 'shapes')
         call need(size(g%stroke_closed) == size(g%stroke_widths) .and. all(g%stroke_widths >= 0), 'stroke_widths')
         call need(nint(min(sum(real(g%stroke_widths, wp)), 2.0e9_wp)) == size(g%stroke_places), 'stroke_widths')
         call need(all(g%stroke_places >= 1 .and. g%stroke_places <= places), 'stroke_places')
         call need(size(g%connection_types) == connections, 'connection_types')
         call need(size(pairs) == 2*connections .and. are_whole(pairs), 'connection_places')
         if (.not. allocated(error)) call need(all(pairs >= 1 .and. pairs <= places), 'connection_places')
         call need(size(g%connection_angles) == connections .and. all(is_near(g%connection_angles)), 'connection_angles')
         call need(size(radii) == 2*connections .and. all(is_near(radii)), 'connection_radii')
         if (.not. allocated(error)) call check_pieces(g)
      end associate

   contains

      subroutine need(fits, name)
         logical, intent(in) :: fits
         character(*), intent(in) :: name
         if (.not. (fits .or. allocated(error))) call raise(error, path//': /motion/'//name// &
            & ' does not fit the rest of the motion: the file is damaged', status_deck)
      end subroutine need

      !> Numbers of deflections of the bodies of all places.
      integer function all_deflections(g) result(count)
         type(geometry_type), intent(in) :: g
         integer :: i
         count = 0
         do i = 1, size(g%place_bodies)
            count = count + deflections(g, g%place_bodies(i))
         end do
      end function all_deflections

      !> Pieces of a beam are two bodies.
      subroutine check_pieces(g)
         type(geometry_type), intent(in) :: g
         integer :: i, pieces(2)
         do i = 1, connections
            if (g%connection_types(i) /= 'SEGMENTS') cycle
            pieces = g%place_bodies(nint(pairs(2*i - 1:2*i)))
            call need(all(pieces > 0) .and. pieces(1) /= pieces(2), 'connection_places')
         end do
      end subroutine check_pieces

   end subroutine check_motion

   !> First axis of a body's frame, in space (2); of the ground and of point masses along x.
   pure function frame_axis(geometry, coordinates, body) result(axis)
      type(geometry_type), intent(in) :: geometry
      real(wp), intent(in) :: coordinates(:)
      integer, intent(in) :: body
      real(wp) :: axis(2)
      axis = [1.0_wp, 0.0_wp]
      if (body == 0) return
      if (geometry%widths(body) > 2) axis = coordinates(geometry%first(body) + 2:geometry%first(body) + 3)
   end function frame_axis

   !> Index of a place by its name, `body.point`, or `body` for the origin of its frame; 0 if there is none.
   pure integer function find_place(geometry, name) result(found)
      type(geometry_type), intent(in) :: geometry
      character(*), intent(in) :: name
      do found = size(geometry%place_names), 1, -1
         if (geometry%place_names(found) == name .or. geometry%place_names(found) == trim(name)//'.origin') return
      end do
   end function find_place

   !> Names as the lines of one text.
   pure function lines_of(names) result(text)
      character(*), intent(in) :: names(:)
      character(:), allocatable :: text
      integer :: i, at
      allocate (character(sum(len_trim(names)) + size(names)) :: text)
      at = 0
      do i = 1, size(names)
         text(at + 1:) = trim(names(i))//newline
         at = at + len_trim(names(i)) + 1
      end do
   end function lines_of

   !> The lines of a text.
   pure subroutine split_lines(text, lines)
      character(*), intent(in) :: text
      character(longest_name), allocatable, intent(out) :: lines(:)
      integer :: i, from, count
      count = 0
      do i = 1, len(text)
         if (text(i:i) == newline) count = count + 1
      end do
      allocate (lines(count))
      from = 1
      do i = 1, count
         lines(i) = text(from:from + index(text(from:), newline) - 2)
         from = from + index(text(from:), newline)
      end do
   end subroutine split_lines

end module limber_output_motion_record
