!> Laws of loads that depend on the motion and are more than polynomials: what they are at a moment of a motion, and what they can
!> be between two. So a law that changes its formula, or comes and goes, is not passed unseen. Floor: system.
!> Source: doc/theory, eqs. (190), (E3).
module limber_system_moments
   use limber_base_kinds, only: wp, long
   use limber_deck_operations, only: jet_type
   use limber_deck_range, only: range_type, law_range_over
   use limber_model_scene, only: in_efforts
   use limber_system_efforts, only: effort_load_type, max_slots
   use limber_system_kinematics, only: kinematics_type
   use limber_system_system, only: system_type
   implicit none
   private
   public :: moment_type, new_moment, watched_loads, read_moment, law_between, describe_law

   !> Watched laws at a moment
   type :: moment_type
      real(wp) :: t = 0.0_wp
      !> Slots, or the gauges of slots that are rates, and their rates (slots, laws)
      real(wp), allocatable :: place(:, :), rate(:, :)
      !> Value of each law times its factor (laws)
      real(wp), allocatable :: force(:)
      !> Numbers of the formulas that hold (laws)
      integer(long), allocatable :: branches(:)
   end type moment_type

contains

   !> Indices of the loads whose laws are watched.
   pure function watched_loads(system) result(loads)
      type(system_type), intent(in) :: system
      integer, allocatable :: loads(:)
      logical :: watched(size(system%loads))
      integer :: i
      watched = .false.
      do i = 1, size(system%loads)
         select type (load => system%loads(i)%item)
         type is (effort_load_type)
            if (.not. load%driven) cycle
            if (any(load%slots > 0)) watched(i) = load%law%may_bend()
         end select
      end do
      loads = pack([(i, i=1, size(system%loads))], watched)
   end function watched_loads

   !> Room.
   pure subroutine new_moment(laws, moment)
      !> Their number
      integer, intent(in) :: laws
      type(moment_type), intent(out) :: moment
      allocate (moment%place(max_slots, laws), moment%rate(max_slots, laws), source=0.0_wp)
      allocate (moment%force(laws), source=0.0_wp)
      allocate (moment%branches(laws), source=0_long)
   end subroutine new_moment

   !> The watched laws of a state.
   pure subroutine read_moment(system, loads, kinematics, moment)
      type(system_type), intent(in) :: system
      integer, intent(in) :: loads(:)
      !> Placed and moved
      type(kinematics_type), intent(in) :: kinematics
      type(moment_type), intent(inout) :: moment
      type(jet_type) :: line(max_slots), jet
      integer :: i, k
      moment%t = kinematics%time
      do i = 1, size(loads)
         select type (load => system%loads(loads(i))%item)
         type is (effort_load_type)
            call load%read_motion(kinematics, moment%place(:, i), moment%rate(:, i))
            do k = 1, size(load%slots)
               line(k) = jet_type(moment%place(k, i), moment%rate(k, i), 0.0_wp)
               if (load%by_rate(k)) line(k) = jet_type(moment%rate(k, i), 0.0_wp, 0.0_wp)
            end do
            jet = load%law%evaluate_along(line(:size(load%slots)))
            moment%force(i) = load%factor*jet%value
            moment%branches(i) = load%law%branches_along(line(:size(load%slots)))
         end select
      end do
   end subroutine read_moment

   !> Bounds of a watched law times its factor between two moments, while its slots move as cubics, eq. (E3).
   pure function law_between(system, loads, law, a, b) result(range)
      type(system_type), intent(in) :: system
      integer, intent(in) :: loads(:), law
      type(moment_type), intent(in) :: a, b
      type(range_type) :: range
      real(wp) :: low(max_slots), high(max_slots), first
      integer :: k
      select type (load => system%loads(loads(law))%item)
      type is (effort_load_type)
         do k = 1, size(load%slots)
            low(k) = a%t
            high(k) = b%t
            if (load%slots(k) > 0) call bound_slot(b%t - a%t, a%place(k, law), a%rate(k, law), b%place(k, law), b%rate(k, law), &
               & load%by_rate(k), low(k), high(k))
         end do
         range = law_range_over(load%law, low(:size(load%slots)), high(:size(load%slots)))
         first = load%factor*range%low
         if (.not. range%defined) return
         range%low = min(first, load%factor*range%high)
         range%high = max(first, load%factor*range%high)
      end select
   end function law_between

   !> Bounds of a slot by the control points of the cubic through both ends.
   pure subroutine bound_slot(h, place_a, rate_a, place_b, rate_b, by_rate, low, high)
      !> Time between; values and rates there
      real(wp), intent(in) :: h, place_a, rate_a, place_b, rate_b
      !> Whether the rate is meant
      logical, intent(in) :: by_rate
      real(wp), intent(out) :: low, high
      !> Part of what the control points lie beyond the ends, for what a cubic leaves out
      real(wp), parameter :: margin = 0.25_wp
      real(wp) :: ends(2), middle(2), noise
      if (by_rate) then
         ends = [rate_a, rate_b]
         noise = 16*spacing(max(abs(place_a), abs(place_b)))/h
         middle = 3*(place_b - place_a)/h - rate_a - rate_b
         middle = [min(maxval(ends), middle(1) + noise), max(minval(ends), middle(2) - noise)]
      else
         ends = [place_a, place_b]
         middle = [place_a + h*rate_a/3, place_b - h*rate_b/3]
      end if
      low = minval(ends)
      high = maxval(ends)
      low = low - (1 + margin)*max(0.0_wp, low - minval(middle))
      high = high + (1 + margin)*max(0.0_wp, maxval(middle) - high)
   end subroutine bound_slot

   !> Name of a load and the first body that its law depends on or acts on: "the law of 'x' on body 'y'".
   pure function describe_law(system, load) result(text)
      type(system_type), intent(in) :: system
      !> Index of the load
      integer, intent(in) :: load
      character(:), allocatable :: text
      integer :: i, effort
      effort = load - (size(system%loads) - size(system%model%efforts))
      text = 'the law of a load'
      do i = 1, size(system%model%loads)
         associate (named => system%model%loads(i))
            if (named%list == in_efforts .and. effort >= named%first .and. effort <= named%last) text = "the law of '"// &
               & named%name//"'"
         end associate
      end do
      if (size(system%loads(load)%item%bodies) > 0) text = text//" on body '"// &
         & system%model%bodies(system%loads(load)%item%bodies(1))%name//"'"
   end function describe_law

end module limber_system_moments
