!> Layers and symbols of a drawing. Which symbol stands where. `limber_commands_drawing` says what is drawn,
!> `limber_commands_gnuplot_writer` makes the symbols. Floor: commands.
module limber_commands_drawing_layers
   use limber_base_kinds, only: wp
   use limber_output_motion_record, only: motion_record_type, deflections, frame_axis
   use limber_output_drawn_posture, only: place_all
   use limber_commands_gnuplot_writer, only: gnuplot_writer_type
   implicit none
   private
   public :: drawing_plan_type, draw_paths, draw_sample, is_line, direction

   !> What is worked out once
   type :: drawing_plan_type
      !> Samples that are drawn, counted from 1, and places whose paths are
      integer, allocatable :: samples(:), followed(:)
      !> Size of symbols [length]
      real(wp) :: symbol = 0.0_wp
      !> Mean over the samples of each place (2, places), and of each body (2, bodies)
      real(wp), allocatable :: places(:, :), bodies(:, :)
      !> Of points that move along lines, least and greatest coordinate along the line, from the second place (2, connections)
      real(wp), allocatable :: travel(:, :)
   end type drawing_plan_type

contains

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
      type(motion_record_type), intent(in) :: motion
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
      type(motion_record_type), intent(in) :: motion
      !> Of the deflections
      real(wp), intent(in) :: factor
      !> Places
      integer, intent(in) :: followed(:)
      type(gnuplot_writer_type), intent(inout) :: pen
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
      type(motion_record_type), intent(in) :: motion
      !> From 1
      integer, intent(in) :: sample
      !> Of the deflections
      real(wp), intent(in) :: factor
      type(drawing_plan_type), intent(in) :: plan
      type(gnuplot_writer_type), intent(inout) :: pen
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
      type(motion_record_type), intent(in) :: motion
      integer, intent(in) :: sample
      type(drawing_plan_type), intent(in) :: plan
      real(wp), intent(in) :: positions(:, :)
      type(gnuplot_writer_type), intent(inout) :: pen
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
      type(drawing_plan_type), intent(in) :: plan
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
      type(motion_record_type), intent(in) :: motion
      integer, intent(in) :: sample
      type(drawing_plan_type), intent(in) :: plan
      real(wp), intent(in) :: positions(:, :)
      type(gnuplot_writer_type), intent(inout) :: pen
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
      type(motion_record_type), intent(in) :: motion
      character(*), intent(in) :: layer
      real(wp), intent(in) :: positions(:, :)
      type(gnuplot_writer_type), intent(inout) :: pen
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
      type(motion_record_type), intent(in) :: motion
      integer, intent(in) :: sample
      real(wp), intent(in) :: positions(:, :)
      type(gnuplot_writer_type), intent(inout) :: pen
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
      type(motion_record_type), intent(in) :: motion
      real(wp), intent(in) :: size_of_symbols, positions(:, :)
      type(gnuplot_writer_type), intent(inout) :: pen
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
      type(motion_record_type), intent(in) :: motion
      integer, intent(in) :: sample
      real(wp), intent(in) :: size_of_symbols, positions(:, :)
      type(gnuplot_writer_type), intent(inout) :: pen
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
      type(motion_record_type), intent(in) :: motion
      real(wp), intent(in) :: size_of_symbols, positions(:, :)
      type(gnuplot_writer_type), intent(inout) :: pen
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
      type(motion_record_type), intent(in) :: motion
      real(wp), intent(in) :: size_of_symbols, positions(:, :)
      type(gnuplot_writer_type), intent(inout) :: pen
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

end module limber_commands_drawing_layers
