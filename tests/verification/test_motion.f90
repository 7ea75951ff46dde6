!> The motion in a results file, and what is drawn of it: places against channels of the same run and against geometry, the exact
!> text of `limber export --motion`, strokes counted. Usage, in tests/: test_motion RESULT_FILE
program test_motion
   use limber_commands_drawing, only: drawing_request_type, export_motion
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_output_history_reader, only: history_reader_type
   use limber_output_motion_record, only: motion_record_type, read_motion, find_place
   use limber_output_outline, only: hull
   use limber_output_drawn_posture, only: place_all
   use runs, only: run_changed, channel
   use testing, only: check, check_close, check_text, check_no_error, finish
   implicit none
   character(*), parameter :: nl = new_line('a')
   !> Layers of a drawing
   character(*), parameter :: layers(*) = [character(10) :: 'paths', 'ground', 'guides', 'areas', 'bars', 'undeformed', 'beams', &
      & 'springs', 'blocks', 'masses', 'joints', 'wheels']
   character(256) :: results

   call get_command_argument(1, results)
   call test_hull()
   call test_slider_crank(trim(results))
   call test_squeezer(trim(results))
   call test_pendulum(trim(results))
   call test_quick_return(trim(results))
   call test_wheels(trim(results))
   call test_pieces(trim(results))
   call finish()

contains

   subroutine test_hull()
      real(wp) :: places(2, 7)
      integer, allocatable :: corners(:)
      places = reshape([1.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 2.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 2.0_wp, 2.0_wp, 2.0_wp, &
         & 2.0_wp, 0.0_wp], [2, 7])
      call hull(places, [1, 2, 3, 4, 5, 6, 7], corners)
      call check(size(corners) == 4, 'a square with points inside, on an edge and twice has four corners')
      if (size(corners) == 4) call check(all(corners([1, 3, 4]) == [2, 6, 5]) .and. any(corners(2) == [3, 7]), &
         & 'corners against the clock')
      call hull(places, [4, 3, 2], corners)
      call check(size(corners) == 2, 'points in a line have two ends')
      if (size(corners) == 2) call check(all(corners == [2, 3]), 'ends of the line')
      call hull(places, [3, 7], corners)
      call check(size(corners) == 1, 'two points in one place')
      call hull(places, corners(:0), corners)
      call check(size(corners) == 0, 'no point')
   end subroutine test_hull

   !> Rod with large deflections: its places, magnified too; no channel changes by a bit when the motion is asked for.
   subroutine test_slider_crank(path)
      character(*), intent(in) :: path
      character(*), parameter :: deck = '../input/slider_crank_exact.inp'
      character(200) :: old(4), new(4)
      type(history_reader_type) :: reader
      type(motion_record_type) :: motion
      type(error_type), allocatable :: error
      real(wp), allocatable :: slider(:), other(:)
      old = [character(200) :: 'turns = 2', 'OUTPUTS=838', 'slider_x = x(slider)', '*OUTPUT']
      new = [character(200) :: 'turns = 0.4', 'OUTPUTS=40', 'slider_x = x(slider), x_m = x(rod.middle), y_m = y(rod.middle), '// &
         & 'x_e = x(rod.end), y_e = y(rod.end), x_t = x(crank.tip), y_t = y(crank.tip)', '*OUTPUT, MOTION=YES']
      call run_changed(deck, path, old(:3), new(:3), reader)
      allocate (slider, source=channel(reader, 'slider_x'))
      call check(.not. reader%has('/motion'), 'no motion unless it is asked for')
      call read_motion(reader, motion, error)
      call check(allocated(error), 'no motion: an error')
      if (allocated(error)) call check_text(error%message, path//' has no motion to draw; run its deck with *OUTPUT, MOTION=YES', &
         & 'no motion')
      call reader%close()
      call run_changed(deck, path, old, new, reader)
      allocate (other, source=channel(reader, 'slider_x'))
      call check(size(other) == 41 .and. all(.not. abs(other - slider) > 0.0_wp), 'the motion changes no channel')
      call read_motion(reader, motion, error)
      call check_no_error(error, 'slider-crank: motion')
      if (allocated(error)) return
      call check_places(reader, motion, 'rod.middle', 'x_m', 'y_m')
      call check_places(reader, motion, 'rod.end', 'x_e', 'y_e')
      call check_places(reader, motion, 'crank.tip', 'x_t', 'y_t')
      call reader%close()
      call check_rod(motion)
      call check_counts(path, drawing_request_type(sample=3), [0, 0, 0, 0, 1, 1, 1, 0, 1, 1, 4], 'slider-crank')
      call check_counts(path, path_of('rod.middle'), [1, 0, 0, 0, 1, 1, 1, 0, 1, 1, 4], 'slider-crank with a path')
      call check_choices(path)
   end subroutine test_slider_crank

   !> A rod in segments is magnified as one: its pieces stay together, undeformed it is the chord from pin to pin.
   subroutine test_pieces(path)
      character(*), intent(in) :: path
      type(history_reader_type) :: reader
      type(motion_record_type) :: motion
      type(error_type), allocatable :: error
      real(wp), allocatable, dimension(:, :) :: bent, straight, large
      real(wp) :: chord(2), way, largest
      integer :: i, k, start, end, inner
      call run_changed('../input/slider_crank_3mm.inp', path, [character(40) :: 'FUNCTIONS=9, STRAIN FUNCTIONS=3', &
         & 'END=2*pi/speed', 'OUTPUTS=419'], [character(40) :: 'FUNCTIONS=3, SEGMENTS=8', 'END=2e-3', 'OUTPUTS=3'], reader)
      call read_motion(reader, motion, error)
      call check_no_error(error, 'segments: motion')
      if (allocated(error)) return
      associate (g => motion%geometry)
         allocate (bent(2, size(g%place_bodies)))
         allocate (straight, large, mold=bent)
         call place_all(g, motion%coordinates(:, 4), 1.0_wp, bent)
         call place_all(g, motion%coordinates(:, 4), 0.0_wp, straight)
         call place_all(g, motion%coordinates(:, 4), 30.0_wp, large)
         start = find_place(g, 'rod.start')
         end = find_place(g, 'rod.end')
         chord = bent(:, end) - bent(:, start)
         largest = 0.0_wp
         inner = 0
         do i = 1, size(g%connections)
            if (g%connection_types(i) /= 'SEGMENTS') cycle
            inner = inner + 1
            do k = 1, 2
               associate (place => g%connection_places(k, i))
                  way = inner*norm2(chord)/(count(g%connection_types == 'SEGMENTS') + 1)
                  call check_close(norm2(straight(:, place) - bent(:, start) - way*chord/norm2(chord)), 0.0_wp, 1.0e-12_wp, &
                     & 'undeformed segments divide the chord')
                  call check_close(norm2(large(:, place) - straight(:, place) - 30*(bent(:, place) - straight(:, place))), &
                     & 0.0_wp, 1.0e-12_wp, 'magnified from it')
                  largest = max(largest, norm2(bent(:, place) - straight(:, place)))
               end associate
            end do
            call check_close(norm2(large(:, g%connection_places(1, i)) - large(:, g%connection_places(2, i))), 0.0_wp, 1.0e-10_wp, &
               & 'magnified segments stay together')
         end do
         call check(inner > 0 .and. largest > 1.0e-6_wp, 'segments that bend')
         call check_close(norm2(large(:, end) - bent(:, end)) + norm2(large(:, start) - bent(:, start)), 0.0_wp, 1.0e-13_wp, &
            & 'pins of the whole rod stay')
      end associate
      call reader%close()
   end subroutine test_pieces

   !> A place at all samples against channels of its coordinates.
   subroutine check_places(reader, motion, name, x, y)
      type(history_reader_type), intent(in) :: reader
      type(motion_record_type), intent(in) :: motion
      character(*), intent(in) :: name, x, y
      real(wp) :: positions(2, size(motion%geometry%place_bodies)), along(size(motion%time)), across(size(motion%time)), largest
      integer :: i, place
      place = find_place(motion%geometry, name)
      call check(place > 0, name//' is a place')
      along = channel(reader, x)
      across = channel(reader, y)
      largest = 0.0_wp
      do i = 1, size(motion%time)
         call place_all(motion%geometry, motion%coordinates(:, i), 1.0_wp, positions)
         largest = max(largest, maxval(abs(positions(:, place) - [along(i), across(i)])))
      end do
      call check_close(largest, 0.0_wp, 1.0e-15_wp, name//' is where its channels say')
   end subroutine check_places

   !> The rod as a line: its ends are pins, its middle station is the point there; undeformed it is the chord, of twice the
   !> deflection twice as far from it.
   subroutine check_rod(motion)
      type(motion_record_type), intent(in) :: motion
      real(wp), dimension(2, size(motion%geometry%place_bodies)) :: bent, straight, double
      real(wp) :: chord(2), distance, largest
      integer :: sample, i, start, end, middle, first, last, stretches
      associate (g => motion%geometry)
         start = find_place(g, 'rod.start')
         end = find_place(g, 'rod.end')
         middle = find_place(g, 'rod.middle')
         first = g%stroke_places(g%first_place(2))
         last = first + g%stroke_widths(2) - 1
         stretches = g%stroke_widths(2) - 1
         call check(stretches >= 24 .and. modulo(stretches, 2) == 0 .and. g%stroke_closed(2) == 0, 'stretches along the rod')
         largest = 0.0_wp
         do sample = 2, size(motion%time)
            call place_all(g, motion%coordinates(:, sample), 1.0_wp, bent)
            call place_all(g, motion%coordinates(:, sample), 0.0_wp, straight)
            call place_all(g, motion%coordinates(:, sample), 2.0_wp, double)
            call check_close(norm2(bent(:, first) - bent(:, find_place(g, 'crank.tip'))), 0.0_wp, 1.0e-12_wp, 'rod at the crank')
            call check_close(norm2(bent(:, last) - bent(:, find_place(g, 'slider'))), 0.0_wp, 1.0e-12_wp, 'rod at the slider')
            call check_close(norm2(bent(:, (first + last)/2) - bent(:, middle)), 0.0_wp, 1.0e-12_wp, 'middle of the rod')
            chord = bent(:, end) - bent(:, start)
            call check_close(norm2(double(:, end) - bent(:, end)) + norm2(double(:, start) - bent(:, start)), 0.0_wp, 1.0e-14_wp, &
               & 'connected ends stay')
            do i = first, last
               distance = (chord(1)*(straight(2, i) - bent(2, start)) - chord(2)*(straight(1, i) - bent(1, start)))/norm2(chord)
               call check_close(distance, 0.0_wp, 1.0e-14_wp, 'undeformed: on the chord')
               call check_close(norm2(straight(:, i) - bent(:, start) - chord*(i - first)/stretches), 0.0_wp, 1.0e-14_wp, &
                  & 'undeformed: equal distances')
               call check_close(norm2(double(:, i) - 2*bent(:, i) + straight(:, i)), 0.0_wp, 1.0e-14_wp, 'twice the deflection')
               largest = max(largest, norm2(bent(:, i) - straight(:, i)))
            end do
         end do
      end associate
      call check(largest > 1.0e-3_wp, 'the rod bends')
   end subroutine check_rod

   !> Samples by number and time, and complaints.
   subroutine check_choices(path)
      character(*), intent(in) :: path
      type(drawing_request_type) :: choice
      character(:), allocatable :: text
      type(error_type), allocatable :: error
      call drawn(path, drawing_request_type(sample=40), text, error)
      call check(index(text, nl//'# sample 40, t = 0.0168 s'//nl) > 0, 'the last sample')
      choice%at_time = .true.
      choice%time = 0.0043_wp
      call drawn(path, choice, text, error)
      call check(index(text, nl//'# sample 10, t = 0.0042 s'//nl) > 0 .and. count_of(text, '# sample') == 1, 'nearest sample')
      call drawn(path, drawing_request_type(samples=5), text, error)
      call check(count_of(text, '# sample') == 5 .and. index(text, '# sample 30,') > 0, 'five samples')
      call drawn(path, drawing_request_type(), text, error)
      call check(count_of(text, '# sample') == 41, 'all samples')
      call drawn(path, drawing_request_type(sample=41), text, error)
      call check(allocated(error), 'no such sample: an error')
      if (allocated(error)) call check_text(error%message, path//' has no sample 41; its samples are 0 to 40', 'no such sample')
      call drawn(path, path_of('rod.midle'), text, error)
      call check(allocated(error), 'no such point: an error')
      if (allocated(error)) call check_text(error%message, path//" has no point 'rod.midle'", 'no such point')
   end subroutine check_choices

   !> Six bars and a triangle, a spring, four feet: each pin of the ground once.
   subroutine test_squeezer(path)
      character(*), intent(in) :: path
      type(history_reader_type) :: reader
      type(motion_record_type) :: motion
      type(error_type), allocatable :: error
      character(120) :: old(3), new(3)
      character(:), allocatable :: text
      old = [character(120) :: 'END=0.03', 'OUTPUTS=300', '*OUTPUT']
      new = [character(120) :: 'END=0.003', 'OUTPUTS=10', '*OUTPUT, MOTION=YES'//nl//' x_h = x(k3.hook), y_h = y(k3.hook)']
      call run_changed('../input/andrews_squeezer.inp', path, old, new, reader)
      call read_motion(reader, motion, error)
      call check_no_error(error, 'squeezer: motion')
      if (.not. allocated(error)) call check_places(reader, motion, 'k3.hook', 'x_h', 'y_h')
      call reader%close()
      call check_counts(path, drawing_request_type(sample=10), [0, 0, 0, 1, 6, 0, 0, 1, 0, 0, 12], 'squeezer')
      call drawn(path, drawing_request_type(sample=10), text, error)
      call check(count_of(layer_of(text, 'ground'), nl//nl) == 4*7 - 1, 'four feet of seven strokes each')
   end subroutine test_squeezer

   !> All that is printed of a pendulum, whose positions are known.
   subroutine test_pendulum(path)
      character(*), intent(in) :: path
      type(history_reader_type) :: reader
      character(:), allocatable :: text
      type(error_type), allocatable :: error
      character(120) :: old(2), new(2)
      old = [character(120) :: 'END=10, TOLERANCE=1e-6, OUTPUTS=10', '*OUTPUT']
      new = [character(120) :: 'END=0.1, TOLERANCE=1e-6, OUTPUTS=1', '*OUTPUT, MOTION=YES']
      call run_changed('verification/pendulum.inp', path, old, new, reader)
      call reader%close()
      call drawn(path, drawing_request_type(sample=0), text, error)
      call check_no_error(error, 'pendulum')
      call check(index(text, nl//'# heading Pendulum of mass and length 1, let go from the horizontal'//nl//nl//nl// &
         & '# unit m'//nl//nl//nl//'# symbol 0.01602'//nl//nl//nl//'# sample 0, t = 0.0 s'//nl//'# ground'//nl) == 2, &
         & 'head of the text'//nl//text)
      call check_text(layer_of(text, 'bars'), ' 0.00000000E+000  0.00000000E+000 1'//nl// &
         & ' 1.00000000E+000  0.00000000E+000 1'//nl, 'a bar')
      call check(index(layer_of(text, 'joints'), ' 0.00000000E+000  0.00000000E+000 0 ') == 1, 'a pin')
      call check_counts(path, drawing_request_type(sample=0), [0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1], 'pendulum')
   end subroutine test_pendulum

   !> A line that moves reaches as far as its point travels; an end that the deck names belongs to the bar.
   subroutine test_quick_return(path)
      character(*), intent(in) :: path
      type(history_reader_type) :: reader
      type(motion_record_type) :: motion
      type(error_type), allocatable :: error
      character(:), allocatable :: text
      character(4) :: none(0)
      real(wp) :: ends(3, 2), symbol(4), shortest, longest
      integer :: i
      call run_changed('verification/quick_return.inp', path, none, none, reader)
      call read_motion(reader, motion, error)
      call check_no_error(error, 'quick return: motion')
      if (allocated(error)) return
      call check_places(reader, motion, 'arm.end', 'x_arm_end', 'y_arm_end')
      call check_places(reader, motion, 'bob', 'x_bob', 'y_bob')
      call reader%close()
      call check_counts(path, drawing_request_type(sample=7), [0, 0, 1, 0, 2, 0, 0, 1, 1, 1, 5], 'quick return')
      call drawn(path, drawing_request_type(sample=7), text, error)
      text = layer_of(text, 'bars')
      read (text(index(text, nl) + 1:), *) ends(:, 2)
      call check_close(norm2(ends(:2, 2)), 1.0_wp, 1.0e-7_wp, 'the end of the arm')
      call drawn(path, drawing_request_type(sample=7), text, error)
      read (text(index(text, '# masses'//nl) + 9:), *) symbol
      text = layer_of(text, 'guides')
      read (text, *) ends(:, 1)
      read (text(index(text, nl) + 1:), *) ends(:, 2)
      shortest = huge(1.0_wp)
      longest = 0.0_wp
      do i = 0, 20
         shortest = min(shortest, norm2([0.2_wp*cos(i*acos(-1.0_wp)/20), 0.5_wp + 0.2_wp*sin(i*acos(-1.0_wp)/20)]))
         longest = max(longest, norm2([0.2_wp*cos(i*acos(-1.0_wp)/20), 0.5_wp + 0.2_wp*sin(i*acos(-1.0_wp)/20)]))
      end do
      ! A disc's radius is 0.8 of the size of symbols
      call check_close(norm2(ends(:2, 1)), shortest - 2*symbol(4)/0.8_wp, 1.0e-7_wp, 'where the line begins')
      call check_close(norm2(ends(:2, 2)), longest + 2*symbol(4)/0.8_wp, 1.0e-7_wp, 'where the line ends')
   end subroutine test_quick_return

   !> Gears, a rack, a belt, a cam: strokes counted; the belt touches its wheels, and stands upright on their radii there.
   subroutine test_wheels(path)
      character(*), intent(in) :: path
      type(history_reader_type) :: reader
      character(:), allocatable :: text
      type(error_type), allocatable :: error
      character(4) :: none(0)
      real(wp) :: ends(3, 2), radius(2, 2)
      integer :: i
      call run_changed('verification/wheels.inp', path, none, none, reader)
      call reader%close()
      call check_counts(path, drawing_request_type(sample=4), [0, 0, 4, 1, 2, 0, 0, 0, 2, 5, 8, 5], 'wheels')
      call drawn(path, drawing_request_type(sample=4), text, error)
      ! The belt's two strokes are the first guides
      text = layer_of(text, 'guides')
      do i = 1, 2
         read (text, *) ends
         radius(:, 1) = ends(:2, 1) - [0.5_wp, 0.0_wp]
         radius(:, 2) = ends(:2, 2) - [1.6_wp, 0.0_wp]
         call check_close(norm2(radius(:, 1)), 0.1_wp, 1.0e-7_wp, 'belt on the first wheel')
         call check_close(norm2(radius(:, 2)), 0.25_wp, 1.0e-7_wp, 'belt on the second wheel')
         call check_close(dot_product(ends(:2, 2) - ends(:2, 1), radius(:, 1)), 0.0_wp, 1.0e-7_wp, 'belt along the first wheel')
         call check_close(dot_product(ends(:2, 2) - ends(:2, 1), radius(:, 2)), 0.0_wp, 1.0e-7_wp, 'belt along the second wheel')
         text = text(index(text, nl//nl) + 2:)
      end do
   end subroutine test_wheels

   !> Counts strokes, or circles, in each layer but the ground.
   subroutine check_counts(path, choice, expected, title)
      character(*), intent(in) :: path, title
      type(drawing_request_type), intent(in) :: choice
      integer, intent(in) :: expected(:)
      character(:), allocatable :: text
      type(error_type), allocatable :: error
      integer :: i, found
      call drawn(path, choice, text, error)
      call check_no_error(error, title)
      do i = 1, size(expected)
         if (layers(i) == 'ground') cycle
         found = strokes_of(layer_of(text, trim(layers(i))), layers(i) == 'masses' .or. layers(i) == 'joints')
         call check_close(real(found, wp), real(expected(i), wp), 0.0_wp, title//': strokes in '//trim(layers(i)))
      end do
   end subroutine check_counts

   !> Number of strokes, or of circles, which have a line each.
   integer function strokes_of(part, circles)
      character(*), intent(in) :: part
      logical, intent(in) :: circles
      strokes_of = count_of(part, nl)
      if (circles .or. len(part) == 0) return
      strokes_of = 1 + count_of(part, nl//nl)
   end function strokes_of

   !> What is printed, as one text.
   subroutine drawn(path, choice, text, error)
      character(*), intent(in) :: path
      type(drawing_request_type), intent(in) :: choice
      character(:), allocatable, intent(out) :: text
      type(error_type), allocatable, intent(out) :: error
      integer :: unit, length
      open (newunit=unit, file=path//'.txt', action='write', status='replace')
      call export_motion(path, choice, unit, error)
      close (unit)
      inquire (file=path//'.txt', size=length)
      allocate (character(length) :: text)
      open (newunit=unit, file=path//'.txt', access='stream', action='read', status='old')
      if (length > 0) read (unit) text
      close (unit)
   end subroutine drawn

   !> A choice of one path and the first sample.
   function path_of(point) result(choice)
      character(*), intent(in) :: point
      type(drawing_request_type) :: choice
      choice%sample = 0
      allocate (choice%paths(1))
      choice%paths(1) = point
   end function path_of

   !> The lines of a layer of one sample, without its name; empty if there is none.
   function layer_of(text, name) result(part)
      character(*), intent(in) :: text, name
      character(:), allocatable :: part
      integer :: from
      part = ''
      from = index(text, '# '//name//nl)
      if (from == 0) return
      part = text(from + len('# '//name//nl):)
      if (index(part, nl//nl//nl) > 0) part = part(:index(part, nl//nl//nl))
   end function layer_of

   integer function count_of(text, part)
      character(*), intent(in) :: text, part
      integer :: at, found
      count_of = 0
      at = 1
      do
         found = index(text(at:), part)
         if (found == 0) return
         count_of = count_of + 1
         at = at + found + len(part) - 1
      end do
   end function count_of

end program test_motion
