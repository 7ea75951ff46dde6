!> limber export --motion: a mechanism as lines. `limber export --motion`. Floor: commands; results file -> text for gnuplot. All
!> symbols are made here, in the unit of length, so that a plot with equal axes is all that is left.
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
module limber_commands_drawing
   use limber_base_error, only: error_type, raise, status_deck
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_output_history_reader, only: history_reader_type
   use limber_output_motion_record, only: motion_record_type, read_motion, find_place
   use limber_output_drawn_posture, only: place_all
   use limber_commands_drawing_layers, only: drawing_plan_type, draw_paths, draw_sample, is_line, direction
   use limber_commands_gnuplot_writer, only: gnuplot_writer_type
   implicit none
   private
   public :: drawing_request_type, export_motion

   !> What is to be drawn
   type :: drawing_request_type
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
   end type drawing_request_type

   !> Parts of the diagonal of all positions, and of the mean length of an outline, that a symbol has at most
   real(wp), parameter :: of_diagonal = 0.016_wp, of_outline = 0.12_wp

contains

   !> Prints what is to be drawn.
   subroutine export_motion(path, choice, unit, error)
      !> Name of the results file
      character(*), intent(in) :: path
      type(drawing_request_type), intent(in) :: choice
      !> Open formatted unit
      integer, intent(in) :: unit
      !> Allocated if the file has no motion, or no such sample or point
      type(error_type), allocatable, intent(out) :: error
      type(history_reader_type) :: reader
      type(motion_record_type) :: motion
      type(drawing_plan_type) :: plan
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
      type(motion_record_type), intent(in) :: motion
      !> Of the deflections
      real(wp), intent(in) :: factor
      !> With its samples and places; the rest is worked out here
      type(drawing_plan_type), intent(inout) :: plan
      integer, intent(in) :: unit
      !> Whether a write failed
      logical, intent(out) :: failed
      type(gnuplot_writer_type) :: pen
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
      type(drawing_request_type), intent(in) :: choice
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
         first = min(choice%sample, n) + 1
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
      type(drawing_request_type), intent(in) :: choice
      type(motion_record_type), intent(in) :: motion
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
      type(motion_record_type), intent(in) :: motion
      real(wp), intent(in) :: factor
      type(drawing_plan_type), intent(inout) :: plan
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
      type(motion_record_type), intent(in) :: motion
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
      type(motion_record_type), intent(in) :: motion
      real(wp), intent(in) :: places(:, :)
      real(wp), allocatable, intent(out) :: bodies(:, :)
      integer :: i
      associate (g => motion%geometry)
         allocate (bodies(2, size(g%bodies)), source=0.0_wp)
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
      type(motion_record_type), intent(in) :: motion
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

end module limber_commands_drawing
