!> A mechanism as lines to draw, from the motion in its results file alone: `limber export --motion`. Floor: analysis; results
!> file -> text for gnuplot. All symbols are made here, in the unit of length, so that a plot with equal axes is all that is left.
!>
!>     # heading TEXT
!>     # unit m              of length
!>     # symbol S            size of symbols
!>     # paths               a layer: its name, then its strokes with a blank line between; two blank lines behind it
!>     x y body              body: its number from 1, 0 for the ground
!>     # sample K, t = T     from 0; then its layers
!>
!> Layers, those without strokes left out: `ground`; `guides` (lines that points move on, rods, belts); `wheels` and `areas`
!> (closed outlines); `bars`; `undeformed` (beams without their deflection); `beams`; `springs`; `blocks` (closed: sliders,
!> welds); `masses` and `joints` (circles: x y body radius).
module limber_analysis_drawing
   use limber_base_error, only: error_type, raise, status_deck
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_output_history_reader, only: history_reader_type
   use limber_output_motion, only: motion_type, read_motion, find_place, deflections, frame_axis
   use limber_output_posture, only: place_all
   use limber_analysis_pen, only: pen_type
   implicit none
   private
   public :: choice_type, export_motion

   !> What is to be drawn
   type :: choice_type
      !> Number of one sample from 0, or negative: all; the sample nearest to a time, if that is wanted
      integer :: sample = -1
      logical :: at_time = .false.
      real(wp) :: time = 0.0_wp
      !> So many samples at equal distances, the first and the last among them; 0: all
      integer :: samples = 0
      !> Factor of the deflections
      real(wp) :: deflection = 1.0_wp
      !> Names of points whose paths are drawn, padded with blanks
      character(256), allocatable :: paths(:)
   end type choice_type

   !> What is worked out once
   type :: plan_type
      !> Samples that are drawn, counted from 1, and places whose paths are
      integer, allocatable :: samples(:), followed(:)
      !> Size of symbols [length]
      real(wp) :: symbol = 0.0_wp
      !> Mean over the samples of each place (2, places), and of each body (2, bodies)
      real(wp), allocatable :: places(:, :), bodies(:, :)
      !> Of points that move along lines, least and greatest coordinate along the line, from the second place (2, connections)
      real(wp), allocatable :: travel(:, :)
   end type plan_type

   !> Parts of the diagonal of all positions, and of the mean length of an outline, that a symbol has at most
   real(wp), parameter :: of_diagonal = 0.016_wp, of_outline = 0.12_wp

contains

   !> Prints what is to be drawn.
   subroutine export_motion(path, choice, unit, error)
      !> Name of the results file
      character(*), intent(in) :: path
      type(choice_type), intent(in) :: choice
      !> Open formatted unit
      integer, intent(in) :: unit
      !> Allocated if the file has no motion, or no such sample or point
      type(error_type), allocatable, intent(out) :: error
      type(history_reader_type) :: reader
      type(motion_type) :: motion
      type(plan_type) :: plan
      logical :: failed
      call reader%open(path, error)
      if (allocated(error)) return
      call read_motion(reader, motion, error)
      if (.not. allocated(error)) call choose_samples(path, choice, motion%time, plan%samples, error)
      if (.not. allocated(error)) call choose_paths(path, choice, motion, plan%followed, error)
      call reader%close()
      failed = .false.
      if (.not. allocated(error)) call draw_all(motion, choice%deflection, plan, unit, failed)
      if (failed) call raise(error, path//': cannot write what is to be drawn')
   end subroutine export_motion

   !> Prints some samples and paths.
   subroutine draw_all(motion, factor, plan, unit, failed)
      type(motion_type), intent(in) :: motion
      !> Of the deflections
      real(wp), intent(in) :: factor
      !> With its samples and places; the rest is worked out here
      type(plan_type), intent(inout) :: plan
      integer, intent(in) :: unit
      !> Whether a write failed
      logical, intent(out) :: failed
      type(pen_type) :: pen
      integer :: i
      call find_scale(motion, factor, plan)
      pen%unit = unit
      call pen%remark('heading '//motion%heading)
      call pen%remark('unit '//motion%length_units)
      call pen%remark('symbol '//as_text(plan%symbol, 4))
      call draw_paths(motion, factor, plan%followed, pen)
      do i = 1, size(plan%samples)
         call pen%remark('sample '//as_text(plan%samples(i) - 1)//', t = '//time_text(motion%time, plan%samples(i))//' '// &
            & motion%time_units)
         call draw_sample(motion, plan%samples(i), factor, plan, pen)
      end do
      failed = pen%failed
   end subroutine draw_all

   !> The time of a sample, with as many decimals as all samples of a film need to differ.
   pure function time_text(time, sample) result(text)
      real(wp), intent(in) :: time(:)
      integer, intent(in) :: sample
      character(:), allocatable :: text
      character(40) :: number
      character(8) :: form
      integer :: decimals
      decimals = 0
      if (size(time) > 1) then
         if (time(2) > time(1)) decimals = max(0, min(12, -floor(log10(time(2) - time(1)))))
      end if
      write (form, '(a,i0,a)') '(f40.', decimals, ')'
      write (number, form) time(sample)
      text = trim(adjustl(number))
   end function time_text

   !> Samples that are drawn, counted from 1.
   subroutine choose_samples(path, choice, time, chosen, error)
      character(*), intent(in) :: path
      type(choice_type), intent(in) :: choice
      real(wp), intent(in) :: time(:)
      integer, allocatable, intent(out) :: chosen(:)
      type(error_type), allocatable, intent(out) :: error
      integer :: i, n, first, wanted
      n = size(time)
      first = 1
      wanted = 1
      if (choice%at_time .and. n > 0) then
         first = minloc(abs(time - choice%time), 1)
      else if (choice%sample >= 0) then
         first = choice%sample + 1
      else
         wanted = n
         if (choice%samples > 0) wanted = min(n, choice%samples)
      end if
      allocate (chosen(wanted))
      do i = 1, wanted
         chosen(i) = first + nint(real(i - 1, wp)*(n - 1)/max(1, wanted - 1))
      end do
      if (n == 0) then
         call raise(error, path//' has no samples', status_deck)
      else if (first > n) then
         call raise(error, path//' has no sample '//as_text(choice%sample)//'; its samples are 0 to '//as_text(n - 1), status_deck)
      end if
   end subroutine choose_samples

   !> Places whose paths are drawn.
   subroutine choose_paths(path, choice, motion, followed, error)
      character(*), intent(in) :: path
      type(choice_type), intent(in) :: choice
      type(motion_type), intent(in) :: motion
      integer, allocatable, intent(out) :: followed(:)
      type(error_type), allocatable, intent(out) :: error
      integer :: i
      allocate (followed(0))
      if (.not. allocated(choice%paths)) return
      deallocate (followed)
      allocate (followed(size(choice%paths)))
      do i = 1, size(followed)
         followed(i) = find_place(motion%geometry, trim(choice%paths(i)))
         if (followed(i) > 0) cycle
         call raise(error, path//" has no point '"//trim(choice%paths(i))//"'", status_deck)
         return
      end do
   end subroutine choose_paths

   !> Size of symbols, means and travels.
   subroutine find_scale(motion, factor, plan)
      type(motion_type), intent(in) :: motion
      real(wp), intent(in) :: factor
      type(plan_type), intent(inout) :: plan
      real(wp), allocatable :: positions(:, :)
      real(wp) :: least(2), greatest(2), length
      integer :: sample, i
      associate (g => motion%geometry)
         allocate (positions(2, size(g%place_bodies)), plan%places(2, size(g%place_bodies)))
         plan%places = 0.0_wp
         allocate (plan%travel(2, size(g%connections)))
         plan%travel(1, :) = huge(1.0_wp)
         plan%travel(2, :) = -huge(1.0_wp)
         least = huge(1.0_wp)
         greatest = -huge(1.0_wp)
         do sample = 1, size(motion%time)
            call place_all(g, motion%coordinates(:, sample), factor, positions)
            plan%places = plan%places + positions/size(motion%time)
            do i = 1, size(g%place_bodies)
               if (g%place_bodies(i) == 0) cycle
               least = min(least, positions(:, i))
               greatest = max(greatest, positions(:, i))
            end do
            call extend_travel(motion, sample, positions, plan%travel)
         end do
         do i = 1, size(g%connections)
            least = min(least, plan%places(:, g%connection_places(1, i)), plan%places(:, g%connection_places(2, i)))
            greatest = max(greatest, plan%places(:, g%connection_places(1, i)), plan%places(:, g%connection_places(2, i)))
         end do
      end associate
      call find_middles(motion, plan%places, plan%bodies)
      plan%symbol = of_diagonal*norm2(greatest - least)
      length = mean_outline(motion)
      if (length > 0.0_wp) plan%symbol = min(plan%symbol, of_outline*length)
      if (.not. plan%symbol > 0.0_wp) plan%symbol = of_diagonal
   end subroutine find_scale

   !> Takes a sample into the travels.
   pure subroutine extend_travel(motion, sample, positions, travel)
      type(motion_type), intent(in) :: motion
      integer, intent(in) :: sample
      real(wp), intent(in) :: positions(:, :)
      real(wp), intent(inout) :: travel(:, :)
      real(wp) :: coordinate
      integer :: i
      do i = 1, size(travel, 2)
         associate (g => motion%geometry, places => motion%geometry%connection_places(:, i))
            if (.not. is_line(g%connection_types(i))) cycle
            coordinate = dot_product(positions(:, places(1)) - positions(:, places(2)), direction(motion, sample, i))
            travel(:, i) = [min(travel(1, i), coordinate), max(travel(2, i), coordinate)]
         end associate
      end do
   end subroutine extend_travel

   !> Means of the places of each body's first stroke; of a body without one, of its last named place.
   pure subroutine find_middles(motion, places, bodies)
      type(motion_type), intent(in) :: motion
      real(wp), intent(in) :: places(:, :)
      real(wp), allocatable, intent(out) :: bodies(:, :)
      integer :: i
      associate (g => motion%geometry)
         allocate (bodies(2, size(g%bodies)))
         do i = 1, size(g%place_bodies)
            if (g%place_bodies(i) > 0) bodies(:, g%place_bodies(i)) = places(:, i)
         end do
         do i = size(g%stroke_widths), 1, -1
            associate (own => g%stroke_places(g%first_place(i):g%first_place(i) + g%stroke_widths(i) - 1))
               if (size(own) == 0) cycle
               if (g%place_bodies(own(1)) > 0) bodies(:, g%place_bodies(own(1))) = sum(places(:, own), 2)/size(own)
            end associate
         end do
      end associate
   end subroutine find_middles

   !> Mean distance of the first place of an outline from the others, over all outlines with more than one.
   pure real(wp) function mean_outline(motion) result(length)
      type(motion_type), intent(in) :: motion
      integer :: i, k, n
      real(wp) :: longest
      length = 0.0_wp
      n = 0
      associate (g => motion%geometry)
         do i = 1, size(g%stroke_widths)
            associate (places => g%stroke_places(g%first_place(i):g%first_place(i) + g%stroke_widths(i) - 1))
               longest = 0.0_wp
               do k = 2, size(places)
                  longest = max(longest, norm2(g%places(:, places(k)) - g%places(:, places(1))))
               end do
            end associate
            if (.not. longest > 0.0_wp) cycle
            length = length + longest
            n = n + 1
         end do
      end associate
      if (n > 0) length = length/n
   end function mean_outline

   !> Whether a joint has a line on the second body, along which its first point, or its pinion, moves.
   elemental logical function is_line(type_name)
      character(*), intent(in) :: type_name
      is_line = type_name == 'POINT ON LINE' .or. type_name == 'TRANSLATIONAL' .or. type_name == 'RACK'
   end function is_line

   !> Whether a connection takes hold of its two points by pins.
   elemental logical function is_pinned(type_name)
      character(*), intent(in) :: type_name
      is_pinned = type_name == 'REVOLUTE' .or. type_name == 'ROD' .or. type_name == 'SPRING' .or. type_name == 'JOINT'
   end function is_pinned

   !> Direction of the line of a joint at a sample (2).
   pure function direction(motion, sample, connection) result(d)
      type(motion_type), intent(in) :: motion
      integer, intent(in) :: sample, connection
      real(wp) :: d(2), axis(2)
      associate (g => motion%geometry)
         axis = frame_axis(g, motion%coordinates(:, sample), g%place_bodies(g%connection_places(2, connection)))
         d = [cos(g%connection_angles(connection)), sin(g%connection_angles(connection))]
      end associate
      d = [axis(1)*d(1) - axis(2)*d(2), axis(2)*d(1) + axis(1)*d(2)]
   end function direction

   !> The paths of points over all samples.
   subroutine draw_paths(motion, factor, followed, pen)
      type(motion_type), intent(in) :: motion
      real(wp), intent(in) :: factor
      integer, intent(in) :: followed(:)
      type(pen_type), intent(inout) :: pen
      real(wp), allocatable :: positions(:, :), paths(:, :, :)
      integer :: sample, i
      associate (g => motion%geometry)
         if (size(followed) == 0) return
         allocate (positions(2, size(g%place_bodies)), paths(2, size(motion%time), size(followed)))
         do sample = 1, size(motion%time)
            call place_all(g, motion%coordinates(:, sample), factor, positions)
            paths(:, sample, :) = positions(:, followed)
         end do
         call pen%begin('paths')
         do i = 1, size(followed)
            call pen%stroke(paths(:, :, i), g%place_bodies(followed(i)))
         end do
      end associate
   end subroutine draw_paths

   !> All layers of a sample.
   subroutine draw_sample(motion, sample, factor, plan, pen)
      type(motion_type), intent(in) :: motion
      integer, intent(in) :: sample
      real(wp), intent(in) :: factor
      type(plan_type), intent(in) :: plan
      type(pen_type), intent(inout) :: pen
      real(wp), allocatable :: positions(:, :), straight(:, :)
      associate (g => motion%geometry)
         allocate (positions(2, size(g%place_bodies)), straight(2, size(g%place_bodies)))
         call place_all(g, motion%coordinates(:, sample), factor, positions)
         call place_all(g, motion%coordinates(:, sample), 0.0_wp, straight)
      end associate
      call draw_ground(motion, sample, plan, positions, pen)
      call draw_guides(motion, sample, plan, positions, pen)
      call draw_wheels(motion, sample, positions, pen)
      call draw_outlines(motion, 'areas', positions, pen)
      call draw_outlines(motion, 'bars', positions, pen)
      call draw_outlines(motion, 'undeformed', straight, pen)
      call draw_outlines(motion, 'beams', positions, pen)
      call draw_springs(motion, plan%symbol, positions, pen)
      call draw_blocks(motion, sample, plan%symbol, positions, pen)
      call draw_masses(motion, plan%symbol, positions, pen)
      call draw_joints(motion, plan%symbol, positions, pen)
   end subroutine draw_sample

   !> Supports: a hatched foot under each pin of the ground, a hatched edge along each line of it and behind each weld.
   subroutine draw_ground(motion, sample, plan, positions, pen)
      type(motion_type), intent(in) :: motion
      integer, intent(in) :: sample
      type(plan_type), intent(in) :: plan
      real(wp), intent(in) :: positions(:, :)
      type(pen_type), intent(inout) :: pen
      logical, allocatable :: done(:)
      real(wp) :: along(2), away(2)
      integer :: i, k, place
      call pen%begin('ground')
      associate (g => motion%geometry, h => plan%symbol)
         allocate (done(size(g%place_bodies)))
         done = .false.
         do i = 1, size(g%connections)
            do k = 1, 2
               place = g%connection_places(k, i)
               if (g%place_bodies(place) /= 0) cycle
               away = away_from(positions(:, place), g%place_bodies(g%connection_places(3 - k, i)), plan)
               if (k == 2 .and. is_line(g%connection_types(i))) then
                  along = direction(motion, sample, i)
                  away = [along(2), -along(1)]
                  if (away(2) > 0.0_wp) away = -away
                  call pen%hatched_edge(positions(:, place) + 0.5_wp*sum(plan%travel(:, i))*along + 0.75_wp*h*away, along, away, &
                     & 0.5_wp*(plan%travel(2, i) - plan%travel(1, i)) + 2.5_wp*h, h)
               else if (g%connection_types(i) == 'WELD') then
                  call pen%hatched_edge(positions(:, place), [-away(2), away(1)], away, 2.5_wp*h, h)
               else if (is_pinned(g%connection_types(i)) .and. .not. done(place)) then
                  ! On the ceiling if the body hangs
                  call pen%foot(positions(:, place), [0.0_wp, merge(1.0_wp, -1.0_wp, away(2) > 0.8_wp)], h)
                  done(place) = .true.
               end if
            end do
         end do
      end associate
   end subroutine draw_ground

   !> Unit vector from the mean place of a body to a point; down if they are the same.
   pure function away_from(point, body, plan) result(away)
      real(wp), intent(in) :: point(2)
      integer, intent(in) :: body
      type(plan_type), intent(in) :: plan
      real(wp) :: away(2)
      away = 0.0_wp
      if (body > 0) away = point - plan%bodies(:, body)
      if (norm2(away) > plan%symbol) then
         away = away/norm2(away)
      else
         away = [0.0_wp, -1.0_wp]
      end if
   end function away_from

   !> Lines of moving bodies that points move along, rods and belts.
   subroutine draw_guides(motion, sample, plan, positions, pen)
      type(motion_type), intent(in) :: motion
      integer, intent(in) :: sample
      type(plan_type), intent(in) :: plan
      real(wp), intent(in) :: positions(:, :)
      type(pen_type), intent(inout) :: pen
      real(wp) :: ends(2, 2)
      integer :: i
      call pen%begin('guides')
      associate (g => motion%geometry, h => plan%symbol)
         do i = 1, size(g%connections)
            ends = positions(:, g%connection_places(:, i))
            if (index(g%connection_types(i), 'BELT') > 0) then
               call pen%belt(ends, g%connection_radii(:, i), g%connection_types(i) == 'CROSSED BELT')
            else if (g%connection_types(i) == 'ROD') then
               call pen%stroke(ends, 0)
            else if (.not. is_line(g%connection_types(i))) then
               cycle
            else if (g%place_bodies(g%connection_places(2, i)) > 0) then
               ends(:, 1) = ends(:, 2) + (plan%travel(1, i) - 2*h)*direction(motion, sample, i)
               ends(:, 2) = ends(:, 2) + (plan%travel(2, i) + 2*h)*direction(motion, sample, i)
               call pen%stroke(ends, g%place_bodies(g%connection_places(2, i)))
            end if
         end do
      end associate
   end subroutine draw_guides

   !> Outlines of bodies: `areas` are closed ones, `bars` those of rigid bodies, `beams` and `undeformed` those of others.
   subroutine draw_outlines(motion, layer, positions, pen)
      type(motion_type), intent(in) :: motion
      character(*), intent(in) :: layer
      real(wp), intent(in) :: positions(:, :)
      type(pen_type), intent(inout) :: pen
      logical :: fits
      integer :: i, body
      call pen%begin(layer)
      associate (g => motion%geometry)
         do i = 1, size(g%stroke_widths)
            associate (own => g%stroke_places(g%first_place(i):g%first_place(i) + g%stroke_widths(i) - 1))
               if (size(own) < 2) cycle
               body = g%place_bodies(own(1))
               fits = layer == 'areas'
               if (g%stroke_closed(i) == 0) fits = layer == 'bars'
               if (deflections(g, body) > 0) fits = layer == 'beams' .or. layer == 'undeformed'
               if (.not. fits) cycle
               if (g%stroke_closed(i) == 0) then
                  call pen%stroke(positions(:, own), body)
               else
                  call pen%stroke(positions(:, [own, own(1)]), body)
               end if
            end associate
         end do
      end associate
   end subroutine draw_outlines

   !> Wheels of gears, racks and belts, each with a radius that shows how it turns.
   subroutine draw_wheels(motion, sample, positions, pen)
      type(motion_type), intent(in) :: motion
      integer, intent(in) :: sample
      real(wp), intent(in) :: positions(:, :)
      type(pen_type), intent(inout) :: pen
      integer :: i, k
      call pen%begin('wheels')
      associate (g => motion%geometry)
         do i = 1, size(g%connections)
            do k = 1, 2
               associate (place => g%connection_places(k, i))
                  if (g%connection_radii(k, i) > 0.0_wp) call pen%wheel(positions(:, place), frame_axis(g, &
                     & motion%coordinates(:, sample), g%place_bodies(place)), g%connection_radii(k, i), g%place_bodies(place))
               end associate
            end do
         end do
      end associate
   end subroutine draw_wheels

   subroutine draw_springs(motion, size_of_symbols, positions, pen)
      type(motion_type), intent(in) :: motion
      real(wp), intent(in) :: size_of_symbols, positions(:, :)
      type(pen_type), intent(inout) :: pen
      integer :: i
      call pen%begin('springs')
      associate (g => motion%geometry)
         do i = 1, size(g%connections)
            if (g%connection_types(i) == 'SPRING') call pen%zigzag(positions(:, g%connection_places(1, i)), &
               & positions(:, g%connection_places(2, i)), 0, size_of_symbols)
         end do
      end associate
   end subroutine draw_springs

   !> Sliders and welds.
   subroutine draw_blocks(motion, sample, size_of_symbols, positions, pen)
      type(motion_type), intent(in) :: motion
      integer, intent(in) :: sample
      real(wp), intent(in) :: size_of_symbols, positions(:, :)
      type(pen_type), intent(inout) :: pen
      integer :: i
      call pen%begin('blocks')
      associate (g => motion%geometry)
         do i = 1, size(g%connections)
            associate (place => g%connection_places(1, i))
               if (is_line(g%connection_types(i)) .and. g%connection_types(i) /= 'RACK' .or. g%connection_types(i) == 'SLIDING') &
                  & call pen%block(positions(:, place), direction(motion, sample, i), &
                  & [1.3_wp, 0.75_wp]*size_of_symbols, g%place_bodies(place))
               if (g%connection_types(i) == 'WELD') call pen%block(positions(:, place), direction(motion, sample, i), &
                  & [0.6_wp, 0.6_wp]*size_of_symbols, g%place_bodies(place))
            end associate
         end do
      end associate
   end subroutine draw_blocks

   !> Point masses, and bodies whose outline is a point.
   subroutine draw_masses(motion, size_of_symbols, positions, pen)
      type(motion_type), intent(in) :: motion
      real(wp), intent(in) :: size_of_symbols, positions(:, :)
      type(pen_type), intent(inout) :: pen
      integer :: i
      call pen%begin('masses')
      associate (g => motion%geometry)
         do i = 1, size(g%place_bodies)
            if (g%place_bodies(i) == 0) cycle
            if (g%widths(g%place_bodies(i)) == 2) call pen%circle(positions(:, i), g%place_bodies(i), 0.8_wp*size_of_symbols)
         end do
         do i = 1, size(g%stroke_widths)
            if (g%stroke_widths(i) /= 1) cycle
            associate (place => g%stroke_places(g%first_place(i)))
               call pen%circle(positions(:, place), g%place_bodies(place), 0.8_wp*size_of_symbols)
            end associate
         end do
      end associate
   end subroutine draw_masses

   !> Pins.
   subroutine draw_joints(motion, size_of_symbols, positions, pen)
      type(motion_type), intent(in) :: motion
      real(wp), intent(in) :: size_of_symbols, positions(:, :)
      type(pen_type), intent(inout) :: pen
      integer :: i
      call pen%begin('joints')
      associate (g => motion%geometry)
         do i = 1, size(g%connections)
            if (.not. is_pinned(g%connection_types(i)) .and. index('POINT ON LINE, POINT ON CURVE, SLIDING', &
               & trim(g%connection_types(i))) == 0) cycle
            call pen%circle(positions(:, g%connection_places(1, i)), 0, 0.45_wp*size_of_symbols)
            if (.not. is_pinned(g%connection_types(i)) .or. g%connection_types(i) == 'REVOLUTE') cycle
            call pen%circle(positions(:, g%connection_places(2, i)), 0, 0.45_wp*size_of_symbols)
         end do
      end associate
   end subroutine draw_joints

end module limber_analysis_drawing
