!> Pulses of drivers between two positions. A position follows from the one before and the drivers at its own time: what a driver
!> does between and takes back is not in it. Bounds of its law tell where that is, so that the way is followed there in small steps,
!> and what the joints cannot follow is met. Floor: analysis. Source: doc/theory, eq. (5.43), section 6.8.
module limber_analysis_driver_pulses
   use, intrinsic :: ieee_exceptions, only: ieee_status_type, ieee_get_status, ieee_set_status, ieee_set_halting_mode, ieee_all
   use limber_base_kinds, only: wp
   use limber_deck_expression, only: expression_type
   use limber_deck_operations, only: jet_type
   use limber_deck_range, only: range_type, law_range
   use limber_model_law_integrals, only: integral_type, integral_value
   use limber_model_model, only: model_type, driver_angle, driver_joint_angle
   implicit none
   private
   public :: shown_until

   !> A coordinate that is prescribed
   type :: course_type
      !> Derivative that its law gives
      integer :: level = 0
      !> Change of it that is nothing; values and rates at both ends
      real(wp) :: nothing = 0.0_wp
      type(jet_type) :: first, last
      !> Times of both ends, looks that are left
      real(wp) :: start = 0.0_wp, end = 0.0_wp
      integer :: looks = 0
   end type course_type

contains

   !> The last time up to which no driver or coupler does what its places and rates at both ends do not show.
   real(wp) function shown_until(model, from, to) result(t)
      type(model_type), intent(in) :: model
      real(wp), intent(in) :: from, to
      integer, parameter :: rounds = 200
      type(ieee_status_type) :: status
      type(integral_type) :: none
      real(wp) :: found
      integer :: round, i
      t = to
      call ieee_get_status(status)
      call ieee_set_halting_mode(ieee_all, .false.)
      do round = 1, rounds
         found = t
         do i = 1, size(model%drivers)
            associate (driver => model%drivers(i))
               call look(driver%law, driver%integral, driver%level, &
                  & merge(1.0_wp, model%length, any(driver%kind == [driver_angle, driver_joint_angle])), found)
            end associate
         end do
         do i = 1, size(model%joints)
            if (model%joints(i)%has_law) call look(model%joints(i)%law, none, 0, min(1.0_wp, model%length), found)
         end do
         if (.not. found < t .or. .not. found > from) exit
         t = found
      end do
      call ieee_set_status(status)

   contains

      !> Looks for the first pulse of one law.
      subroutine look(law, integral, level, scale, found)
         type(expression_type), intent(in) :: law
         !> Of the law, where it is a velocity or an acceleration (level 1, 2)
         type(integral_type), intent(in) :: integral
         integer, intent(in) :: level
         !> What its coordinate is relative to
         real(wp), intent(in) :: scale
         !> The time; the end, or earlier
         real(wp), intent(inout) :: found
         !> Pulse that matters, relative to the scale
         real(wp), parameter :: least = 1.0e-4_wp
         integer, parameter :: most_looks = 300
         type(course_type) :: course
         if (size(law%slots) == 0) return
         course%level = level
         course%nothing = least*scale
         course%start = from
         course%end = found
         course%first = place_at(law, integral, level, from)
         course%last = place_at(law, integral, level, found)
         course%looks = most_looks
         call search(course, law, integral, from, found, course%first%value, course%last%value, huge(scale), found)
      end subroutine look

   end function shown_until

   !> Halves an interval until bounds tell that nothing is in it, or a place is found that is not that of the cubic through both
   !> ends of the course. Bounds that are only wide shrink with the interval.
   recursive subroutine search(course, law, integral, a, b, of_a, of_b, excess_before, found)
      type(course_type), intent(inout) :: course
      type(expression_type), intent(in) :: law
      type(integral_type), intent(in) :: integral
      !> Ends of the interval, coordinate there, and excess of the bounds of the interval that it is half of
      real(wp), intent(in) :: a, b, of_a, of_b, excess_before
      !> Where such a place is; else unchanged
      real(wp), intent(inout) :: found
      real(wp), parameter :: shrinks = 0.6_wp
      type(jet_type) :: middle
      real(wp) :: excess, t, s, h, cubic
      excess = excess_within(law, course%level, a, b, of_a, of_b)
      if (excess <= course%nothing .or. course%looks == 0) return
      t = a + 0.5_wp*(b - a)
      if (t <= a .or. t >= b) return
      middle = place_at(law, integral, course%level, t)
      course%looks = course%looks - 1
      h = course%end - course%start
      s = (t - course%start)/h
      cubic = (1 - s)**2*((1 + 2*s)*course%first%value + s*h*course%first%first) + &
         & s**2*((3 - 2*s)*course%last%value - (1 - s)*h*course%last%first)
      if (.not. abs(middle%value - cubic) <= course%nothing) then
         found = t
         return
      end if
      ! Two intervals one in the other, both with the same excess: a pulse
      if (excess <= shrinks*excess_before .and. excess_before < huge(excess)) then
         if (max(excess_within(law, course%level, a, t, of_a, middle%value), &
            & excess_within(law, course%level, t, b, middle%value, of_b)) <= shrinks*excess) return
      end if
      call search(course, law, integral, a, t, of_a, middle%value, excess, found)
      if (found > a .and. found < b) return
      call search(course, law, integral, t, b, middle%value, of_b, excess, found)
   end subroutine search

   !> A coordinate and its rate, less what its start adds.
   pure type(jet_type) function place_at(law, integral, level, t) result(jet)
      type(expression_type), intent(in) :: law
      type(integral_type), intent(in) :: integral
      integer, intent(in) :: level
      real(wp), intent(in) :: t
      if (level == 0) then
         jet = law%evaluate_jet(t)
      else
         jet = integral_value(integral, law, level, t)
      end if
   end function place_at

   !> By how much the coordinate of a driver may lie beyond its values at both ends of an interval.
   real(wp) function excess_within(law, level, a, b, of_a, of_b) result(excess)
      type(expression_type), intent(in) :: law
      integer, intent(in) :: level
      real(wp), intent(in) :: a, b, of_a, of_b
      type(range_type) :: range
      excess = huge(excess)
      range = law_range(law, a, b)
      if (.not. range%defined) return
      select case (level)
      case (0)
         excess = max(0.0_wp, min(of_a, of_b) - range%low, range%high - max(of_a, of_b))
      case (1)
         excess = 0.0_wp
         if (range%low < 0.0_wp .and. range%high > 0.0_wp) excess = (b - a)*min(range%high, -range%low)
      case default
         excess = 0.125_wp*(b - a)**2*(range%high - range%low)
      end select
   end function excess_within

end module limber_analysis_driver_pulses
