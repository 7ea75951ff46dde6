!> Laws of the motion: values, branches, bounds. What they are at a moment of a motion, and what they can be between two. So a law
!> that changes its formula, or comes and goes, is not passed unseen. Floor: multibody. Source: doc/theory, eqs. (5.43), (5.45).
module limber_multibody_motion_laws
   use, intrinsic :: ieee_exceptions, only: ieee_status_type, ieee_get_status, ieee_set_status, ieee_set_halting_mode, ieee_all
   use limber_base_kinds, only: wp, long
   use limber_deck_operations, only: jet_type
   use limber_deck_range, only: range_type, law_range_over
   use limber_multibody_force_elements, only: force_element_type, max_slots
   use limber_multibody_bounds, only: bound_cubic, bound_length
   use limber_multibody_kinematics, only: kinematics_type
   use limber_multibody_scalar_functions, only: scalar_turn, scalar_distance
   use limber_multibody_system, only: system_type
   implicit none
   private
   public :: moment_type, new_moment, watched_loads, read_moment, read_law, law_between, range_between, law_noise, &
      & law_doubt, law_effect, law_turn, law_bend, law_rests, law_within, law_excess, law_is_steep, law_is_stored, quartic, &
      & describe_law, name_of_load, no_slope_text

   !> Watched laws at a moment
   type :: moment_type
      real(wp) :: t = 0.0_wp
      !> Slots, or the functions of slots that are rates, and their rates (slots, laws)
      real(wp), allocatable :: place(:, :), rate(:, :)
      !> Of those that are distances: the vector, and its rate (2, slots, laws)
      real(wp), allocatable :: gap(:, :, :), drift(:, :, :)
      !> Value of each law times its factor, and its rate along the motion (laws)
      real(wp), allocatable :: force(:), slope(:)
      !> Largest speed of the slots of each law that are places [length/time], angles times the length of the scene (laws)
      real(wp), allocatable :: speed(:)
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
         type is (force_element_type)
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
      allocate (moment%gap(2, max_slots, laws), moment%drift(2, max_slots, laws), source=0.0_wp)
      allocate (moment%force(laws), moment%slope(laws), moment%speed(laws), source=0.0_wp)
      allocate (moment%branches(laws), source=0_long)
   end subroutine new_moment

   !> The watched laws of a state.
   pure subroutine read_moment(system, loads, kinematics, moment)
      type(system_type), intent(in) :: system
      integer, intent(in) :: loads(:)
      !> Placed and moved
      type(kinematics_type), intent(in) :: kinematics
      type(moment_type), intent(inout) :: moment
      integer :: i
      moment%t = kinematics%time
      do i = 1, size(loads)
         select type (load => system%loads(loads(i))%item)
         type is (force_element_type)
            call read_law(load, system%model%length, kinematics, moment, i)
         end select
      end do
   end subroutine read_moment

   !> One law at a state.
   pure subroutine read_law(load, length, kinematics, moment, law)
      type(force_element_type), intent(in) :: load
      !> Of the scene
      real(wp), intent(in) :: length
      !> Placed and moved
      type(kinematics_type), intent(in) :: kinematics
      type(moment_type), intent(inout) :: moment
      !> Its place in the moment
      integer, intent(in) :: law
      type(jet_type) :: line(max_slots), jet
      integer :: k
      call load%read_motion(kinematics, moment%place(:, law), moment%rate(:, law), moment%gap(:, :, law), moment%drift(:, :, law))
      moment%speed(law) = 0.0_wp
      do k = 1, size(load%slots)
         if (load%slots(k) > 0) moment%speed(law) = max(moment%speed(law), abs(moment%rate(k, law))* &
            & merge(length, 1.0_wp, load%functions(max(1, load%slots(k)))%kind == scalar_turn))
         line(k) = jet_type(moment%place(k, law), moment%rate(k, law), 0.0_wp)
         if (load%by_rate(k)) line(k) = jet_type(moment%rate(k, law), 0.0_wp, 0.0_wp)
      end do
      jet = load%law%evaluate_along(line(:size(load%slots)))
      moment%force(law) = load%factor*jet%value
      moment%slope(law) = load%factor*jet%first
      moment%branches(law) = load%law%branches_along(line(:size(load%slots)))
   end subroutine read_law

   !> How much the slope of a watched law in time differs between two moments next to each other, before and behind a change of its
   !> formula [force/time].
   pure real(wp) function law_bend(system, loads, law, a, b, from, to) result(bend)
      type(system_type), intent(in) :: system
      integer, intent(in) :: loads(:), law
      type(moment_type), intent(in) :: a, b
      !> Moments around them, which tell how rates change
      type(moment_type), intent(in) :: from, to
      type(jet_type) :: line(max_slots), before, behind
      integer :: k
      bend = 0.0_wp
      select type (load => system%loads(loads(law))%item)
      type is (force_element_type)
         do k = 1, size(load%slots)
            line(k) = jet_type(a%place(k, law), a%rate(k, law), 0.0_wp)
            if (load%by_rate(k)) line(k) = jet_type(a%rate(k, law), (to%rate(k, law) - from%rate(k, law))/(to%t - from%t), 0.0_wp)
         end do
         before = load%law%evaluate_along(line(:size(load%slots)))
         do k = 1, size(load%slots)
            line(k)%value = merge(b%rate(k, law), b%place(k, law), load%by_rate(k))
         end do
         behind = load%law%evaluate_along(line(:size(load%slots)))
         bend = abs(load%factor)*abs(behind%first - before%first)
      end select
   end function law_bend

   !> Whether all that a watched law depends on but the time is the same at two moments, to round-off.
   pure logical function law_rests(system, loads, law, a, b) result(rests)
      type(system_type), intent(in) :: system
      integer, intent(in) :: loads(:), law
      type(moment_type), intent(in) :: a, b
      real(wp) :: from, to
      integer :: k
      rests = .true.
      select type (load => system%loads(loads(law))%item)
      type is (force_element_type)
         do k = 1, size(load%slots)
            if (load%slots(k) <= 0) cycle
            from = merge(a%rate(k, law), a%place(k, law), load%by_rate(k))
            to = merge(b%rate(k, law), b%place(k, law), load%by_rate(k))
            rests = rests .and. abs(to - from) <= 4*spacing(max(abs(from), abs(to)))
         end do
      end select
   end function law_rests

   !> Bounds of a watched law times its factor between two moments.
   function law_between(system, loads, law, a, b) result(range)
      type(system_type), intent(in) :: system
      integer, intent(in) :: loads(:), law
      type(moment_type), intent(in) :: a, b
      type(range_type) :: range
      select type (load => system%loads(loads(law))%item)
      type is (force_element_type)
         range = range_between(load, law, a, b)
      end select
   end function law_between

   !> Bounds of a law times its factor between two moments, while what its slots are made of moves as cubics, eqs. (5.45), (5.54).
   function range_between(load, law, a, b) result(range)
      type(force_element_type), intent(in) :: load
      !> Its place in the moments
      integer, intent(in) :: law
      type(moment_type), intent(in) :: a, b
      type(range_type) :: range
      real(wp) :: low(max_slots), high(max_slots)
      integer :: k
      do k = 1, size(load%slots)
         low(k) = a%t
         high(k) = b%t
         if (load%slots(k) == 0) cycle
         associate (scalar => load%functions(load%slots(k)), h => b%t - a%t)
            if (scalar%kind == scalar_distance) then
               call bound_length(h, a%gap(:, k, law), a%drift(:, k, law), b%gap(:, k, law), b%drift(:, k, law), scalar%origin, &
                  & load%by_rate(k), low(k), high(k))
            else
               call bound_cubic(h, a%place(k, law), a%rate(k, law), b%place(k, law), b%rate(k, law), load%by_rate(k), low(k), &
                  & high(k))
            end if
         end associate
      end do
      range = range_within(load, low, high)
   end function range_between

   !> Bounds of the law of a load times its factor while its slots are within intervals; where they overflow it is not defined.
   function range_within(load, low, high) result(range)
      type(force_element_type), intent(in) :: load
      !> Ends of the intervals (slots)
      real(wp), intent(in) :: low(:), high(:)
      type(range_type) :: range
      type(ieee_status_type) :: status
      real(wp) :: ends(2)
      call ieee_get_status(status)
      call ieee_set_halting_mode(ieee_all, .false.)
      range = law_range_over(load%law, low(:size(load%slots)), high(:size(load%slots)))
      if (range%defined) then
         ends = load%factor*[range%low, range%high]
         range%low = minval(ends)
         range%high = maxval(ends)
         range%defined = abs(range%low) <= huge(ends) .and. abs(range%high) <= huge(ends)
      end if
      call ieee_set_status(status)
   end function range_within

   !> Bounds of the law of a load, without its factor, while its slots are between two places.
   function law_within(load, first, second) result(range)
      type(force_element_type), intent(in) :: load
      !> Slots there
      real(wp), intent(in) :: first(:), second(:)
      type(range_type) :: range
      range = range_within(load, min(first, second), max(first, second))
      if (range%defined) range = range_type(min(range%low/load%factor, range%high/load%factor), max(range%low/load%factor, &
         & range%high/load%factor), range%whole)
   end function law_within

   !> What a watched law changes by, times its factor, for what its slots are not known to: a small part of the tolerance, and
   !> round-off.
   real(wp) function law_noise(system, loads, law, moment, tolerance, duration, h) result(noise)
      type(system_type), intent(in) :: system
      integer, intent(in) :: loads(:), law
      type(moment_type), intent(in) :: moment
      !> Of a step relative to the scales; length of the whole analysis, and of the step
      real(wp), intent(in) :: tolerance, duration, h
      real(wp), parameter :: share = 1.0e-3_wp, few = 8*epsilon(1.0_wp)
      type(range_type) :: range
      real(wp) :: low(max_slots), high(max_slots), scale, change
      integer :: k
      noise = 0.0_wp
      select type (load => system%loads(loads(law))%item)
      type is (force_element_type)
         do k = 1, size(load%slots)
            associate (place => moment%place(k, law), rate => moment%rate(k, law))
               low(k) = place
               change = few*abs(place)
               if (load%slots(k) > 0) then
                  scale = system%model%length
                  if (load%functions(load%slots(k))%kind == scalar_turn) scale = 1.0_wp
                  change = share*tolerance*scale + few*(abs(place) + scale)
                  if (load%by_rate(k)) then
                     low(k) = rate
                     change = share*tolerance*scale/duration + few*(abs(rate) + (abs(place) + scale)/h)
                  end if
               end if
               high(k) = low(k) + change
               low(k) = low(k) - change
            end associate
         end do
         range = range_within(load, low, high)
         if (range%defined) noise = 0.5_wp*range%high - 0.5_wp*range%low
      end select
   end function law_noise

   !> What a law changes by, times its factor, where places and rates are off by a part of their scales.
   real(wp) function law_doubt(load, length, moment, law, part) result(doubt)
      type(force_element_type), intent(in) :: load
      !> Of the scene
      real(wp), intent(in) :: length
      type(moment_type), intent(in) :: moment
      !> Its place in the moment
      integer, intent(in) :: law
      !> Of a place and the length of the scene, or a radian; of a rate
      real(wp), intent(in) :: part
      type(range_type) :: range
      real(wp) :: at(max_slots), change(max_slots)
      integer :: k
      doubt = 0.0_wp
      do k = 1, size(load%slots)
         at(k) = moment%place(k, law)
         change(k) = 0.0_wp
         if (load%slots(k) == 0) cycle
         change(k) = part*(abs(at(k)) + merge(1.0_wp, length, load%functions(load%slots(k))%kind == scalar_turn))
         if (.not. load%by_rate(k)) cycle
         at(k) = moment%rate(k, law)
         change(k) = part*abs(at(k))
      end do
      associate (n => size(load%slots))
         range = range_within(load, at(:n) - change(:n), at(:n) + change(:n))
      end associate
      if (range%defined) doubt = 0.5_wp*range%high - 0.5_wp*range%low
   end function law_doubt

   !> About the largest velocity that a load of unit force gives in a unit of time, rotations and deflections included
   !> [length/(time force time)]: that of the least mass, where it acts on bodies without mass.
   pure real(wp) function law_effect(system, load) result(effect)
      type(system_type), intent(in) :: system
      !> Index of the load
      integer, intent(in) :: load
      real(wp) :: inertia
      integer :: i
      effect = 0.0_wp
      select type (item => system%loads(load)%item)
      type is (force_element_type)
         do i = 1, size(item%bodies)
            associate (body => system%model%bodies(item%bodies(i)), own => system%inertia(:, item%bodies(i)), &
               & length => system%model%length)
               inertia = own(4)
               if (own(1) > 0.0_wp) inertia = inertia - dot_product(own(2:3), own(2:3))/own(1)
               if (own(1) > 0.0_wp .and. item%functions(1)%kind /= scalar_turn) effect = effect + 1/own(1)
               if (inertia > 1.0e-12_wp*own(4)) effect = effect + length*merge(1.0_wp, body%size, &
                  & item%functions(1)%kind == scalar_turn)/inertia
               if (allocated(body%reduced%omega2)) then
                  if (size(body%reduced%omega2) > 0) effect = effect + body%largest_shape**2
               end if
            end associate
         end do
      end select
      if (effect > 0.0_wp) return
      inertia = minval(system%inertia(1, :), mask=system%inertia(1, :) > 0.0_wp)
      if (any(system%inertia(1, :) > 0.0_wp)) effect = 1/inertia
   end function law_effect

   !> Whether a load is a law of the place alone that it acts along.
   pure logical function law_is_stored(system, load) result(stored)
      type(system_type), intent(in) :: system
      !> Index of the load
      integer, intent(in) :: load
      stored = .false.
      select type (item => system%loads(load)%item)
      type is (force_element_type)
         stored = item%potential
      end select
   end function law_is_stored

   !> Error of a place that a scheme of order 2 makes between two moments where a watched law of it changes: the twelfth of the time
   !> between times what the law changes of its rate, relative to the length of the scene, or a radian, eq. (5.52).
   real(wp) function law_turn(system, loads, law, a, b, effect, beyond) result(turn)
      type(system_type), intent(in) :: system
      integer, intent(in) :: loads(:), law
      type(moment_type), intent(in) :: a, b
      !> What a unit of force gives to velocities, and by how much the law may be beyond its values at both moments
      real(wp), intent(in) :: effect, beyond
      real(wp) :: h, change
      integer :: k
      turn = 0.0_wp
      h = b%t - a%t
      select type (load => system%loads(loads(law))%item)
      type is (force_element_type)
         do k = 1, size(load%slots)
            if (load%slots(k) == 0 .or. load%by_rate(k)) cycle
            change = abs(b%rate(k, law) - a%rate(k, law))
            if (load%functions(load%slots(k))%kind /= scalar_turn) change = change/system%model%length
            turn = max(turn, change)
         end do
         change = abs(b%force(law) - a%force(law)) + min(beyond, 1.0e30_wp*(1 + abs(b%force(law))))
         turn = h/12*min(turn, change*(h*effect/system%model%length))
      end select
   end function law_turn

   !> By how much bounds lie beyond two values.
   pure real(wp) function law_excess(range, first, second) result(excess)
      type(range_type), intent(in) :: range
      real(wp), intent(in) :: first, second
      excess = huge(excess)
      if (range%defined) excess = max(0.0_wp, min(first, second) - range%low, range%high - max(first, second))
   end function law_excess

   !> Whether a law is at one of two moments on its way up or down, in a small part of the time between, by more than is felt,
   !> eq. (5.51). An error estimate that damps what is stiff, or has no stage near there, does not see that.
   pure logical function law_is_steep(a, b, law, felt) result(steep)
      type(moment_type), intent(in) :: a, b
      integer, intent(in) :: law
      !> Force that is felt if it acts all the time between
      real(wp), intent(in) :: felt
      !> How many times as steep as its change such a law is
      real(wp), parameter :: steeply = 8.0_wp
      real(wp) :: change, slope, h
      h = b%t - a%t
      change = abs(b%force(law) - a%force(law))
      slope = max(abs(a%slope(law)), abs(b%slope(law)))
      steep = slope*h > steeply*change
      if (steep) steep = change*(change/slope) > felt*h
   end function law_is_steep

   !> Value at a time of the quartic through five moments.
   pure real(wp) function quartic(quarters, law, t) result(value)
      !> At equal distances
      type(moment_type), intent(in) :: quarters(0:4)
      integer, intent(in) :: law
      real(wp), intent(in) :: t
      real(wp) :: s, weight
      integer :: i, k
      s = 4*(t - quarters(0)%t)/(quarters(4)%t - quarters(0)%t)
      value = 0.0_wp
      do i = 0, 4
         weight = 1.0_wp
         do k = 0, 4
            if (k /= i) weight = weight*(s - k)/(i - k)
         end do
         value = value + weight*quarters(i)%force(law)
      end do
   end function quartic

   !> Which law has no derivative at a state, ": the law of 'x' on body 'y' ..."; empty if all have one.
   function no_slope_text(system, kinematics) result(text)
      type(system_type), intent(in) :: system
      !> Placed and moved
      type(kinematics_type), intent(in) :: kinematics
      character(:), allocatable :: text
      type(ieee_status_type) :: status
      type(jet_type) :: line(max_slots), jet
      real(wp) :: place(max_slots), rate(max_slots), gap(2, max_slots), drift(2, max_slots)
      integer :: i, k
      text = ''
      call ieee_get_status(status)
      call ieee_set_halting_mode(ieee_all, .false.)
      do i = 1, size(system%loads)
         select type (load => system%loads(i)%item)
         type is (force_element_type)
            if (.not. load%driven) cycle
            call load%read_motion(kinematics, place, rate, gap, drift)
            do k = 1, size(load%slots)
               line(k) = jet_type(merge(rate(k), place(k), load%by_rate(k)), 0.0_wp, 0.0_wp)
            end do
            do k = 1, size(load%slots)
               if (load%slots(k) == 0) cycle
               line(k)%first = 1.0_wp
               jet = load%law%evaluate_along(line(:size(load%slots)))
               line(k)%first = 0.0_wp
               if (abs(jet%first) <= huge(jet%first) .or. text /= '') cycle
               text = ': '//describe_law(system, i)//' has no derivative there by '//load%law%slots(k)%name
               if (load%law%slots(k)%argument /= '') text = text//'('//load%law%slots(k)%argument//')'
               text = text//', as acos(x) has none at x = 1; write a law that has one'
            end do
         end select
      end do
      call ieee_set_status(status)
   end function no_slope_text

   !> Name of a load and the first body that its law depends on or acts on: "the law of 'x' on body 'y'".
   pure function describe_law(system, load) result(text)
      type(system_type), intent(in) :: system
      !> Index of the load
      integer, intent(in) :: load
      character(:), allocatable :: text
      associate (control => system%model%load_parts(load)%control)
         if (control > 0) text = "the rate of a state of control '"//system%model%controls(max(1, control))%name//"'"
         if (control > 0) return
      end associate
      text = name_of_load(system, load)
      if (text == '') text = 'a load'
      text = 'the law of '//text
      if (size(system%loads(load)%item%bodies) > 0) text = text//" on body '"// &
         & system%model%bodies(system%loads(load)%item%bodies(1))%name//"'"
   end function describe_law

   !> Name of a load in quotes; empty if it has none.
   pure function name_of_load(system, load) result(text)
      type(system_type), intent(in) :: system
      !> Its index
      integer, intent(in) :: load
      character(:), allocatable :: text
      integer :: i
      text = ''
      do i = 1, size(system%model%loads)
         associate (named => system%model%loads(i))
            if (load >= named%first .and. load <= named%last) text = "'"//named%name//"'"
         end associate
      end do
   end function name_of_load

end module limber_multibody_motion_laws
