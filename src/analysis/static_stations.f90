!> Stations of a static analysis: times that no increment passes. Laws of time may come and go between two equilibria; what a load
!> does there may not be undone. So increments end where a law jumps, turns back, or leaves the straight way between two stations.
!> Interval bounds of the law find that; samples alone could miss it. Floor: analysis. Source: doc/theory, eq. (5.43), section 6.3.
module limber_analysis_static_stations
   use, intrinsic :: ieee_exceptions, only: ieee_status_type, ieee_get_status, ieee_set_status, ieee_set_halting_mode, ieee_all
   use limber_base_kinds, only: wp
   use limber_deck_expression, only: expression_type
   use limber_deck_range, only: range_type, law_range
   use limber_model_law_breaks, only: law_breaks, law_of_time
   use limber_model_model, only: model_type, analysis_step_type
   implicit none
   private
   public :: find_stations

   !> Most pieces that a law is divided into beside those between breaks and samples; most stations of all laws; most samples of the
   !> analysis that count as ends of pieces
   integer, parameter :: most_pieces = 20000, most_stations = 5000, most_samples = 1000
   !> Parts of the largest value of a law: turn that is none, the same in a short piece, and distance from the straight way
   real(wp), parameter :: little = 1.0e-4_wp, coarse = 0.02_wp, bent = 0.02_wp
   !> Parts of the time: a short piece, and the shortest
   real(wp), parameter :: short = 5.0e-4_wp, shortest = 1.0e-9_wp

   !> A law under search
   type :: search_type
      type(expression_type) :: law
      real(wp) :: start = 0.0_wp, end = 0.0_wp
      !> Largest value that was met
      real(wp) :: largest = 0.0_wp
      !> Times and values, in ascending order; their number
      real(wp), allocatable :: t(:), value(:)
      integer :: n = 0
      !> Pieces that may still be divided; whether they have sufficed
      integer :: pieces = most_pieces
      logical :: whole = .true.
   end type search_type

contains

   !> Stations of all laws of drivers, joints and loads, as parts of the step, in ascending order.
   subroutine find_stations(model, step, stations, restless)
      type(model_type), intent(in) :: model
      type(analysis_step_type), intent(in) :: step
      real(wp), allocatable, intent(out) :: stations(:)
      !> Name of a driver, joint or load whose law turns too often to find all of that; empty if there is none
      character(:), allocatable, intent(out) :: restless
      type(ieee_status_type) :: status
      integer :: i, j
      allocate (stations(0))
      restless = ''
      if (.not. step%dynamics%end > step%dynamics%start) return
      ! Values may be undefined, which is told elsewhere: floating-point exceptions must not stop the program
      call ieee_get_status(status)
      call ieee_set_halting_mode(ieee_all, .false.)
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
      call ieee_set_status(status)
      call sort(stations)

   contains

      subroutine visit(law, name)
         type(expression_type), intent(in) :: law
         character(*), intent(in) :: name
         logical :: whole
         if (size(law%slots) == 0) return
         if (size(stations) < most_stations) then
            call visit_law(law, step, stations, whole)
            if (whole) return
         end if
         restless = name
      end subroutine visit

   end subroutine find_stations

   !> Adds the stations of one law.
   subroutine visit_law(law, step, stations, whole)
      type(expression_type), intent(in) :: law
      type(analysis_step_type), intent(in) :: step
      real(wp), allocatable, intent(inout) :: stations(:)
      !> False if there are too many
      logical, intent(out) :: whole
      type(search_type) :: search
      real(wp), allocatable :: breaks(:), edges(:)
      integer :: i, samples
      search%law = law
      search%start = step%dynamics%start
      search%end = step%dynamics%end
      allocate (breaks(0))
      call law_breaks(law, search%start, search%end, breaks, search%whole)
      samples = 0
      if (step%dynamics%outputs <= most_samples) samples = step%dynamics%outputs - 1
      edges = [search%start, search%end, breaks, &
         & [(search%start + i*((search%end - search%start)/(samples + 1)), i=1, samples)]]
      call sort(edges)
      allocate (search%t(most_pieces + 2*size(edges)), search%value(most_pieces + 2*size(edges)))
      call find_largest(search)
      do i = 1, size(breaks)
         call add(stations, step, breaks(i), -1)
         call add(stations, step, breaks(i), 1)
      end do
      do i = 1, size(edges) - 1
         if (.not. edges(i) < edges(i + 1)) cycle
         call pass_piece(edges(i), edges(i + 1))
      end do
      call find_turns(search, step, stations)
      whole = search%whole .and. size(stations) <= most_stations

   contains

      !> Divides a piece between two edges; a break is no longer part of the piece before it.
      subroutine pass_piece(left, right)
         real(wp), intent(in) :: left, right
         real(wp) :: last, values(2)
         last = right
         if (any(.not. abs(breaks - right) > 0.0_wp)) last = nearest(right, -1.0_wp)
         values = [value_at(search, left), value_at(search, last)]
         call append(search, left, values(1))
         if (last > left) then
            call divide(search, step, left, last, values(1), values(2), stations)
            call append(search, last, values(2))
         end if
      end subroutine pass_piece

   end subroutine visit_law

   !> Looks for the largest value: at equal distances, and where bounds are largest.
   subroutine find_largest(search)
      type(search_type), intent(inout) :: search
      integer, parameter :: looks = 500, levels = 50
      type(range_type) :: range(2)
      real(wp) :: left, right, middle, value, high(2)
      integer :: i, k
      do i = 0, looks
         value = value_at(search, search%start + i*((search%end - search%start)/looks))
      end do
      left = search%start
      right = search%end
      do i = 1, levels
         middle = left + 0.5_wp*(right - left)
         value = value_at(search, middle)
         range = [law_range(search%law, left, middle), law_range(search%law, middle, right)]
         do k = 1, 2
            high(k) = max(abs(range(k)%low), abs(range(k)%high))
            if (.not. range(k)%defined) high(k) = huge(high)
         end do
         if (high(1) >= high(2)) then
            right = middle
         else
            left = middle
         end if
      end do
   end subroutine find_largest

   !> Value of the law at a time.
   real(wp) function value_at(search, t) result(value)
      type(search_type), intent(inout) :: search
      real(wp), intent(in) :: t
      value = search%law%evaluate([t])
      if (abs(value) <= huge(value)) search%largest = max(search%largest, abs(value))
   end function value_at

   subroutine append(search, t, value)
      type(search_type), intent(inout) :: search
      real(wp), intent(in) :: t, value
      if (.not. abs(value) <= huge(value)) return
      search%n = search%n + 1
      search%t(search%n) = t
      search%value(search%n) = value
   end subroutine append

   !> Divides a piece until the law is between its values at both ends, and near the straight way from one to the other.
   recursive subroutine divide(search, step, left, right, of_left, of_right, stations)
      type(search_type), intent(inout) :: search
      type(analysis_step_type), intent(in) :: step
      !> Ends of the piece, and values there
      real(wp), intent(in) :: left, right, of_left, of_right
      real(wp), allocatable, intent(inout) :: stations(:)
      type(range_type) :: range
      real(wp) :: middle, of_middle, beyond, between, width
      logical :: turns, bends
      integer :: i
      width = right - left
      middle = left + 0.5_wp*width
      if (width <= shortest*(search%end - search%start) .or. middle <= left .or. middle >= right) return
      range = law_range(search%law, left, right)
      beyond = huge(beyond)
      if (range%defined) beyond = max(min(of_left, of_right) - range%low, range%high - max(of_left, of_right))
      turns = beyond > merge(coarse, little, width < short*(search%end - search%start))*search%largest
      ! Bounds that stay undefined, though values are not, tell nothing
      if (.not. range%defined .and. width < short*(search%end - search%start)) turns = .false.
      bends = .false.
      do i = 1, 3
         between = value_at(search, left + 0.25_wp*i*width)
         bends = bends .or. abs(between - of_left - 0.25_wp*i*(of_right - of_left)) > bent*search%largest
      end do
      if (.not. (turns .or. bends)) return
      if (search%pieces == 0 .or. size(stations) >= most_stations) then
         search%whole = .false.
         return
      end if
      search%pieces = search%pieces - 1
      of_middle = value_at(search, middle)
      call divide(search, step, left, middle, of_left, of_middle, stations)
      call append(search, middle, of_middle)
      if (bends) call add(stations, step, middle, 0)
      call divide(search, step, middle, right, of_middle, of_right, stations)
   end subroutine divide

   !> Adds the times at which the law turns back.
   subroutine find_turns(search, step, stations)
      type(search_type), intent(inout) :: search
      type(analysis_step_type), intent(in) :: step
      real(wp), allocatable, intent(inout) :: stations(:)
      !> Up (1), down (-1); place of the last extreme value
      integer :: way, k, last
      real(wp) :: none
      none = little*search%largest
      way = 0
      last = 1
      do k = 2, search%n
         associate (change => search%value(k) - search%value(last))
            if (way == 0 .and. abs(change) > none) then
               way = merge(1, -1, change > 0.0_wp)
               ! Where it has rested until now
               call add(stations, step, search%t(last), 0)
               last = k
            else if (way*change >= 0.0_wp .and. way /= 0) then
               last = k
            else if (way /= 0 .and. abs(change) > none) then
               call add(stations, step, turn_near(search, last, way), 0)
               if (size(stations) > most_stations) return
               way = -way
               last = k
            end if
         end associate
      end do
   end subroutine find_turns

   !> Time of the extreme value near one of those that were found: golden section between its neighbours.
   real(wp) function turn_near(search, place, way) result(t)
      type(search_type), intent(inout) :: search
      !> Its index; 1 for the largest value, -1 for the least
      integer, intent(in) :: place, way
      real(wp), parameter :: golden = 0.6180339887498949_wp
      integer, parameter :: rounds = 60
      real(wp) :: left, right, inner(2), value(2)
      integer :: i
      t = search%t(place)
      left = search%t(max(1, place - 1))
      right = search%t(min(search%n, place + 1))
      do i = 1, rounds
         inner = [right - golden*(right - left), left + golden*(right - left)]
         value = [value_at(search, inner(1)), value_at(search, inner(2))]
         if (way*value(1) >= way*value(2)) then
            right = inner(2)
         else
            left = inner(1)
         end if
      end do
      if (way*value_at(search, left) > way*search%value(place)) t = left
   end function turn_near

   !> Adds the station of a time: a part of the step whose time is not before it, or the last one before it, or any.
   subroutine add(stations, step, t, side)
      real(wp), allocatable, intent(inout) :: stations(:)
      type(analysis_step_type), intent(in) :: step
      real(wp), intent(in) :: t
      !> 1, -1, 0
      integer, intent(in) :: side
      real(wp) :: part
      integer :: i
      associate (start => step%dynamics%start, length => step%dynamics%end - step%dynamics%start)
         part = (t - start)/length
         do i = 1, 100
            if (side < 0 .and. start + part*length >= t) part = nearest(part, -1.0_wp)
            if (side > 0 .and. start + part*length < t) part = nearest(part, 1.0_wp)
         end do
         if (part > 0.0_wp .and. part < 1.0_wp) stations = [stations, part]
      end associate
   end subroutine add

   !> Ascending order, by Shell's method.
   pure subroutine sort(list)
      real(wp), intent(inout) :: list(:)
      real(wp) :: item
      integer :: gap, i, k
      gap = size(list)/2
      do while (gap > 0)
         do i = gap + 1, size(list)
            item = list(i)
            k = i
            do while (k > gap)
               if (list(k - gap) <= item) exit
               list(k) = list(k - gap)
               k = k - gap
            end do
            list(k) = item
         end do
         gap = gap/2
      end do
   end subroutine sort

end module limber_analysis_static_stations
