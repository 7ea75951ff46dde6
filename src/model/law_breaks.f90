!> Breaks and stations of laws of time. Breaks: changes of formula by min, max, abs, step, smoothstep, atan2 and tables. An
!> integrator ends a step there and restarts. Stations: instants around short events, such as narrow pulses. A step ends there, so
!> that no step skips a pulse. Interval bounds of the law find both; samples alone could miss them. Floor: model. Source:
!> doc/theory, eqs. (5.43), (5.44).
module limber_model_law_breaks
   use, intrinsic :: ieee_exceptions, only: ieee_status_type, ieee_get_status, ieee_set_status, ieee_set_halting_mode, ieee_all
   use limber_base_kinds, only: wp
   use limber_deck_expression, only: expression_type
   use limber_deck_operations, only: op_constant, op_slot
   use limber_deck_range, only: range_type, law_range
   use limber_model_model, only: model_type, load_part_type
   implicit none
   private
   public :: find_breaks, changes_between, last_instant, round_off, law_breaks, find_stations, law_stations, undefined_at
   public :: law_of_time

   !> Number of equal parts of the time that are always examined; largest number for shorter pulses
   integer, parameter :: parts = 500, most_parts = 32000
   !> Two breaks closer than this fraction of the whole time count as one
   real(wp), parameter :: apart = 1.0e-12_wp
   !> Largest number of breaks, and of stations, of a model; a law with more is reported
   integer, parameter :: most_breaks = 5000, most_stations = 20000
   !> Largest number of divided intervals of a law, in all and for each break: a limit where the bounds stay too wide
   integer, parameter :: most_divided = 20000, divided_each = 100
   !> Change of a law within a part, relative to its total change: below `resting` it rests, above `steep` it needs stations. A law
   !> has stations only if it rests for at least the fraction `restful` of the time
   real(wp), parameter :: resting = 1.0e-4_wp, steep = 0.03_wp, restful = 0.2_wp
   !> Change of a law between two stations: relative to its total change, and to its distance from its value at rest; and for a law
   !> with many pulses, that is, more than `many` stations
   real(wp), parameter :: change = 0.02_wp, near_rest = 0.75_wp, coarse = 0.3_wp
   integer, parameter :: many = 2000
   !> For many pulses: a pulse that takes at least this fraction of the interval between two breaks needs no stations
   real(wp), parameter :: between = 0.25_wp

contains

   !> Breaks of all drivers, couplers and loads within the dynamic analysis, in ascending order, each once.
   subroutine find_breaks(model, times, restless)
      type(model_type), intent(in) :: model
      real(wp), allocatable, intent(out) :: times(:)
      !> Name of a driver, coupler or load with too many breaks; empty if there is none
      character(:), allocatable, intent(out) :: restless
      allocate (times(0))
      call visit_laws(model, .false., times, restless)
   end subroutine find_breaks

   !> Stations of the same laws, in ascending order. `restless`: as in `find_breaks`.
   subroutine find_stations(model, times, restless)
      type(model_type), intent(in) :: model
      real(wp), allocatable, intent(out) :: times(:)
      character(:), allocatable, intent(out) :: restless
      allocate (times(0))
      call visit_laws(model, .true., times, restless)
   end subroutine find_stations

   !> Largest distance of times with no step between them.
   pure real(wp) function round_off(start, end)
      real(wp), intent(in) :: start, end
      round_off = 4*spacing(max(abs(start), abs(end)))
   end function round_off

   !> Last instant of an analysis: its end, or just before it if a law changes its formula there.
   real(wp) function last_instant(model, start, end) result(last)
      type(model_type), intent(in) :: model
      real(wp), intent(in) :: start, end
      last = end
      if (changes_between(model, end - round_off(start, end), nearest(end, -1.0_wp))) then
         last = end - round_off(start, end)
      else if (changes_between(model, nearest(end, -1.0_wp), end)) then
         last = nearest(end, -1.0_wp)
      end if
   end function last_instant

   !> Whether a law of time has different formulas at two instants.
   logical function changes_between(model, from, to) result(changes)
      type(model_type), intent(in) :: model
      real(wp), intent(in) :: from, to
      integer :: i
      changes = .false.
      do i = 1, size(model%drivers)
         changes = changes .or. differs(model%drivers(i)%law)
      end do
      do i = 1, size(model%joints)
         if (model%joints(i)%has_law) changes = changes .or. differs(model%joints(i)%law)
      end do
      do i = 1, size(model%load_parts)
         if (model%load_parts(i)%driven) changes = changes .or. differs(law_of_time(model%load_parts(i)))
      end do

   contains

      !> Whether one law has different formulas.
      logical function differs(law)
         type(expression_type), intent(in) :: law
         differs = .false.
         if (size(law%slots) > 0) differs = law%branches(from) /= law%branches(to)
      end function differs

   end function changes_between

   !> Adds the breaks or stations of all laws.
   subroutine visit_laws(model, stations, times, restless)
      type(model_type), intent(in) :: model
      !> True for stations, false for breaks
      logical, intent(in) :: stations
      real(wp), allocatable, intent(inout) :: times(:)
      character(:), allocatable, intent(out) :: restless
      integer :: i, j
      restless = ''
      do i = 1, size(model%drivers)
         call visit(model%drivers(i)%law, model%drivers(i)%name)
      end do
      do i = 1, size(model%joints)
         if (model%joints(i)%has_law) call visit(model%joints(i)%law, model%joints(i)%name)
      end do
      do i = 1, size(model%loads)
         do j = model%loads(i)%first, model%loads(i)%last
            if (model%load_parts(j)%driven) call visit(law_of_time(model%load_parts(j)), model%loads(i)%name)
         end do
      end do
      do j = 1, size(model%load_parts)
         i = model%load_parts(j)%control
         if (i > 0) call visit(law_of_time(model%load_parts(j)), model%controls(i)%name)
      end do

   contains

      !> Adds the breaks or stations of one law.
      subroutine visit(law, name)
         type(expression_type), intent(in) :: law
         character(*), intent(in) :: name
         logical :: whole
         if (stations) then
            call law_stations(law, model%dynamics%start, model%dynamics%end, times, whole)
         else
            call law_breaks(law, model%dynamics%start, model%dynamics%end, times, whole)
         end if
         if (.not. whole) restless = name
      end subroutine visit

   end subroutine visit_laws

   !> Law of a load part as a function of time alone: all other variables are 1. Factors in time alone keep their breaks. Breaks
   !> that depend on other variables are known only during the motion.
   function law_of_time(part) result(law)
      type(load_part_type), intent(in) :: part
      type(expression_type) :: law
      integer :: i, n
      n = size(part%law%constants)
      allocate (law%codes(size(part%law%codes)), law%operands(size(part%law%codes)), law%constants(n + 1))
      law%codes = part%law%codes
      law%operands = part%law%operands
      law%constants(:n) = part%law%constants
      law%constants(n + 1) = 1.0_wp
      if (allocated(part%law%tables)) allocate (law%tables, source=part%law%tables)
      n = 0
      do i = 1, size(law%codes)
         if (law%codes(i) /= op_slot) cycle
         if (part%quantities(law%operands(i))%kind == 0) then
            law%operands(i) = 1
            n = 1
         else
            law%codes(i) = op_constant
            law%operands(i) = size(law%constants)
         end if
      end do
      allocate (law%slots(n))
   end function law_of_time

   !> Adds the breaks of one law to an ordered list.
   subroutine law_breaks(law, start, end, times, whole)
      type(expression_type), intent(in) :: law
      !> First and last time; breaks at these do not count
      real(wp), intent(in) :: start, end
      real(wp), allocatable, intent(inout) :: times(:)
      !> False if there are too many breaks
      logical, intent(out), optional :: whole
      integer :: divided
      if (present(whole)) whole = .true.
      if (size(law%slots) == 0) return
      if (law%branches(start) < 0) return
      divided = 0
      call search_parts(law, start, end, 0, parts, divided, times)
      if (present(whole)) whole = size(times) < most_breaks .and. divided < most_divided + divided_each*size(times)
   end subroutine law_breaks

   !> Searches a range of parts by bisection; leaves out ranges whose bounds exclude a change.
   recursive subroutine search_parts(law, start, end, from, to, divided, times)
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: start, end
      !> Indices of the first and last edge
      integer, intent(in) :: from, to
      integer, intent(inout) :: divided
      real(wp), allocatable, intent(inout) :: times(:)
      type(range_type) :: range
      real(wp) :: left, right
      integer :: middle
      left = part_end(start, end, from, parts)
      right = part_end(start, end, to, parts)
      if (to - from == 1) then
         call search_breaks(law, start, end, left, right, divided, times)
         return
      end if
      range = law_range(law, left, right)
      if (range%whole .and. law%branches(left) == law%branches(right)) return
      middle = (from + to)/2
      call search_parts(law, start, end, from, middle, divided, times)
      call search_parts(law, start, end, middle, to, divided, times)
   end subroutine search_parts

   !> End of one of the equal parts.
   pure real(wp) function part_end(start, end, part, parts)
      real(wp), intent(in) :: start, end
      integer, intent(in) :: part, parts
      part_end = start + (end - start)*(real(part, wp)/parts)
      if (part == parts) part_end = end
   end function part_end

   !> Finds all changes of formula between two times: by bisection if the formulas at both ends differ, else by division of the
   !> interval while its bounds allow a change.
   recursive subroutine search_breaks(law, start, end, left, right, divided, times)
      type(expression_type), intent(in) :: law
      !> Whole time, and the interval
      real(wp), intent(in) :: start, end, left, right
      !> Number of divided intervals so far
      integer, intent(inout) :: divided
      real(wp), allocatable, intent(inout) :: times(:)
      type(range_type) :: range
      real(wp) :: found, middle
      if (size(times) >= most_breaks) return
      if (law%branches(left) /= law%branches(right)) then
         found = first_change(law, left, right)
         if (min(found - start, end - found) > max(apart*(end - start), round_off(start, end))) &
            & call insert(found, apart*(end - start), times)
         if (nearest(found, -1.0_wp) > left) call search_breaks(law, start, end, left, nearest(found, -1.0_wp), divided, times)
         if (found < right .and. found > left) call search_breaks(law, start, end, found, right, divided, times)
      else
         if (right - left <= apart*(end - start) .or. divided >= most_divided + divided_each*size(times)) return
         range = law_range(law, left, right)
         if (range%whole) return
         divided = divided + 1
         middle = left + 0.5_wp*(right - left)
         call search_breaks(law, start, end, left, middle, divided, times)
         call search_breaks(law, start, end, middle, right, divided, times)
      end if
   end subroutine search_breaks

   !> First instant of the next formula after that of `left`, by bisection to the last bit.
   real(wp) function first_change(law, left, right) result(found)
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: left, right
      real(wp) :: before, middle
      before = left
      found = right
      do
         middle = before + 0.5_wp*(found - before)
         if (middle <= before .or. middle >= found) return
         if (law%branches(middle) == law%branches(left)) then
            before = middle
         else
            found = middle
         end if
      end do
   end function first_change

   !> Adds the stations of one law to an ordered list. Only a law that rests for much of the time has stations; otherwise error
   !> control is enough. They surround steep changes, over the whole time of each change.
   subroutine law_stations(law, start, end, times, whole)
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: start, end
      real(wp), allocatable, intent(inout) :: times(:)
      !> False if there are too many stations
      logical, intent(out), optional :: whole
      real(wp), allocatable :: breaks(:), edges(:), before_this(:)
      type(range_type), allocatable :: ranges(:)
      logical, allocatable :: moving(:)
      real(wp) :: span
      integer :: i, n, divided, cuts
      if (present(whole)) whole = .true.
      if (size(law%slots) == 0) return
      if (.not. often_rests(law, start, end)) return
      allocate (breaks(0))
      call law_breaks(law, start, end, breaks)
      cuts = parts
      do
         call cut(start, end, cuts, breaks, edges)
         n = size(edges) - 1
         if (allocated(ranges)) deallocate (ranges, moving)
         allocate (ranges(n), moving(n))
         do i = 1, n
            ranges(i) = law_range(law, edges(i), before(edges(i + 1), breaks))
         end do
         if (.not. all(ranges%defined)) return
         span = maxval(ranges%high) - minval(ranges%low)
         moving = ranges%high - ranges%low > resting*span
         if (sum(edges(2:) - edges(:n), mask=.not. moving) >= restful*(end - start)) exit
         ! Pulses in such quick succession that no part rests
         cuts = 4*cuts
         if (cuts <= most_parts) cycle
         if (present(whole)) whole = .false.
         return
      end do
      before_this = times
      call place_stations(change, near_rest, size(times) + many, .false.)
      if (size(times) - size(before_this) >= many) then
         times = before_this
         call place_stations(coarse, huge(coarse), most_stations, .true.)
      end if
      if (present(whole)) whole = divided < most_divided .and. size(times) < most_stations

   contains

      !> Places stations around each pulse.
      subroutine place_stations(change, near_rest, most, sparing)
         real(wp), intent(in) :: change, near_rest
         !> Limit of the number of stations
         integer, intent(in) :: most
         !> Whether pulses that fill much of an interval between breaks get none
         logical, intent(in) :: sparing
         logical :: spared
         real(wp) :: rest(2)
         integer :: i, first, last
         divided = 0
         last = 0
         do while (last < n)
            first = last + 1
            last = first
            if (.not. moving(first)) cycle
            do while (last < n)
               if (.not. moving(last + 1)) exit
               last = last + 1
            end do
            if (.not. any(ranges(first:last)%high - ranges(first:last)%low > steep*span*parts/cuts)) cycle
            rest = [law%evaluate([edges(first)]), law%evaluate([before(edges(last + 1), breaks)])]
            spared = .false.
            do i = first, last
               if (size(times) >= most) return
               spared = .false.
               if (sparing) spared = fills_piece(edges(i), edges(first), edges(last + 1))
               if (spared) cycle
               call insert(edges(i), 0.0_wp, times)
               call search_stations(law, end - start, edges(i), before(edges(i + 1), breaks), span, rest, change, near_rest, &
                  & most, divided, times)
            end do
            if (.not. spared) call insert(edges(last + 1), 0.0_wp, times)
         end do
      end subroutine place_stations

      !> Whether a pulse fills much of the interval between two breaks around a time.
      pure logical function fills_piece(t, first, last)
         !> Time; start and end of the pulse
         real(wp), intent(in) :: t, first, last
         real(wp) :: left, right
         left = start
         right = end
         if (any(breaks <= t)) left = maxval(breaks, mask=breaks <= t)
         if (any(breaks > t)) right = minval(breaks, mask=breaks > t)
         fills_piece = min(last, right) - max(first, left) >= between*(right - left)
      end function fills_piece

   end subroutine law_stations

   !> Whether the law has nearly the same value at many instants. The instants are irregular, unlike any periodic law.
   logical function often_rests(law, start, end)
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: start, end
      !> Fraction of the time between two instants, modulo 1
      real(wp), parameter :: golden = 0.6180339887498949_wp
      !> First sample of instants, and number of reference values from it: enough to exclude most moving laws
      integer, parameter :: first = parts/4, few = 40
      real(wp) :: value(parts), span
      type(range_type) :: range
      integer :: i, k, near
      often_rests = .false.
      range = law_range(law, start, end)
      do i = 1, parts
         value(i) = law%evaluate([start + modulo(i*golden, 1.0_wp)*(end - start)])
         if (.not. abs(value(i)) <= huge(span)) return
         if (i /= first) cycle
         call count_near(first)
         if (near <= restful*first/4) return
      end do
      call count_near(parts)
      often_rests = near > restful*parts

   contains

      !> Counts how many of the first n instants have nearly the value of one of them; the largest count over the reference values.
      subroutine count_near(n)
         integer, intent(in) :: n
         span = maxval(value(:n)) - minval(value(:n))
         if (range%defined) span = range%high - range%low
         near = 0
         do k = 1, merge(few, n, n < parts)
            near = max(near, count(abs(value(:n) - value(k)) <= resting*span))
            if (near > restful*n) exit
         end do
      end subroutine count_near

   end function often_rests

   !> Edges of the equal parts and breaks, in ascending order.
   subroutine cut(start, end, parts, breaks, edges)
      real(wp), intent(in) :: start, end
      !> Number of parts
      integer, intent(in) :: parts
      real(wp), intent(in) :: breaks(:)
      real(wp), allocatable, intent(out) :: edges(:)
      integer :: i, k, part
      allocate (edges(parts + 1 + size(breaks)))
      k = 0
      i = 1
      do part = 0, parts
         do while (i <= size(breaks))
            if (breaks(i) > part_end(start, end, part, parts)) exit
            if (breaks(i) < part_end(start, end, part, parts)) then
               k = k + 1
               edges(k) = breaks(i)
            end if
            i = i + 1
         end do
         k = k + 1
         edges(k) = part_end(start, end, part, parts)
      end do
      edges = edges(:k)
   end subroutine cut

   !> The time t, or the last number before it if t is a break.
   pure real(wp) function before(t, breaks)
      real(wp), intent(in) :: t, breaks(:)
      before = t
      if (any(.not. abs(breaks - t) > 0.0_wp)) before = nearest(t, -1.0_wp)
   end function before

   !> Divides an interval until the law changes little in each piece, eq. (5.44). The ends of the pieces become stations.
   recursive subroutine search_stations(law, duration, left, right, whole, rest, change, near_rest, most, divided, times)
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: duration, left, right
      !> Total change of the law, and its values at rest before and after
      real(wp), intent(in) :: whole, rest(2)
      !> Relative changes between two stations, as `change` and `near_rest` above
      real(wp), intent(in) :: change, near_rest
      !> Limit of the number of stations
      integer, intent(in) :: most
      integer, intent(inout) :: divided
      real(wp), allocatable, intent(inout) :: times(:)
      type(range_type) :: range
      real(wp) :: middle, way
      range = law_range(law, left, right)
      way = minval(max(0.0_wp, range%low - rest, rest - range%high))
      if (range%high - range%low <= max(resting*whole, min(change*whole, near_rest*min(way, whole)))) return
      if (right - left <= apart*duration .or. divided >= most_divided .or. size(times) >= most) return
      divided = divided + 1
      middle = left + 0.5_wp*(right - left)
      call search_stations(law, duration, left, middle, whole, rest, change, near_rest, most, divided, times)
      call insert(middle, 0.0_wp, times)
      call search_stations(law, duration, middle, right, whole, rest, change, near_rest, most, divided, times)
   end subroutine search_stations

   !> First instant at which a law is undefined or tends to infinity; beyond `end` if there is none.
   real(wp) function undefined_at(law, start, end) result(found)
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: start, end
      type(ieee_status_type) :: status
      type(range_type) :: range
      integer :: part, divided
      found = huge(found)
      if (size(law%slots) == 0) return
      range = law_range(law, start, end)
      if (range%defined) return
      ! The search evaluates undefined values: floating-point exceptions must not stop the program
      call ieee_get_status(status)
      call ieee_set_halting_mode(ieee_all, .false.)
      divided = 0
      do part = 1, parts
         call search_undefined(law, end - start, part_end(start, end, part - 1, parts), part_end(start, end, part, parts), &
            & divided, found)
         if (found <= end) exit
      end do
      call ieee_set_status(status)
   end function undefined_at

   !> Divides an interval where the bounds do not prove that the law is defined. The law is undefined if a value is not a number, or
   !> grows tenfold at a thousandth of the distance. Else the bounds were too wide.
   recursive subroutine search_undefined(law, duration, left, right, divided, found)
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: duration, left, right
      integer, intent(inout) :: divided
      real(wp), intent(inout) :: found
      type(range_type) :: range
      real(wp) :: middle
      range = law_range(law, left, right)
      if (range%defined) return
      middle = left + 0.5_wp*(right - left)
      if (right - left <= apart*duration) then
         if (largest(law, middle, right - left) > 10*largest(law, middle, 1000*(right - left))) found = middle
      else if (largest(law, middle, 0.5_wp*(right - left)) >= huge(found)) then
         found = first_undefined(law, left, right)
      else if (divided < most_divided) then
         divided = divided + 1
         call search_undefined(law, duration, left, middle, divided, found)
         if (found > right) call search_undefined(law, duration, middle, right, divided, found)
      end if
   end subroutine search_undefined

   !> Larger magnitude at a distance on both sides of a time; huge if a value is undefined.
   real(wp) function largest(law, t, distance)
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: t, distance
      real(wp) :: values(2)
      values = abs([law%evaluate([t - distance]), law%evaluate([t + distance])])
      largest = maxval(values)
      if (.not. all(values < huge(largest))) largest = huge(largest)
   end function largest

   !> First time without a value, in an interval with such a time at one end.
   real(wp) function first_undefined(law, left, right) result(found)
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: left, right
      real(wp) :: before, middle
      before = left
      found = left
      if (.not. abs(law%evaluate([left])) <= huge(found)) return
      found = right
      do
         middle = before + 0.5_wp*(found - before)
         if (middle <= before .or. middle >= found) return
         if (abs(law%evaluate([middle])) <= huge(found)) then
            before = middle
         else
            found = middle
         end if
      end do
   end function first_undefined

   !> Inserts a time into an ordered list, unless one within `width` is there.
   subroutine insert(t, width, times)
      real(wp), intent(in) :: t, width
      real(wp), allocatable, intent(inout) :: times(:)
      if (size(times) > 0) then
         ! Most times come in order
         if (t - times(size(times)) > width) then
            times = [times, t]
            return
         end if
      end if
      if (any(abs(times - t) <= width)) return
      times = [pack(times, times < t), t, pack(times, times > t)]
   end subroutine insert

end module limber_model_law_breaks
