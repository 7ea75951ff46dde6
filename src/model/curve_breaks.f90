!> Places at which the formula of a curve changes: jumps, kinks, jumps of the second derivative. Floor: model. Source: doc/theory,
!> eqs. (5.43), (5.58).
module limber_model_curve_breaks
   use, intrinsic :: ieee_exceptions, only: ieee_status_type, ieee_get_status, ieee_set_status, ieee_set_halting_mode, ieee_all
   use limber_base_kinds, only: wp
   use limber_deck_operations, only: jet_type
   use limber_deck_range, only: range_type, law_range
   use limber_model_law_breaks, only: law_breaks
   use limber_model_curve, only: curve_type
   implicit none
   private
   public :: curve_break_type, find_curve_breaks

   !> Kinds of breaks: none that matters, jump of y, of its slope, of its second derivative
   integer, parameter, public :: break_none = 0, break_jump = 1, break_kink = 2, break_bend = 3

   !> A break of a curve
   type :: curve_break_type
      integer :: kind = break_none
      !> x of the break, just before it and just behind it
      real(wp) :: place = 0.0_wp, before = 0.0_wp, behind = 0.0_wp
      !> y with its derivatives at `before` and `behind`
      type(jet_type) :: left, right
   end type curve_break_type

contains

   !> Breaks of a curve between two values of x, in ascending order. A spline has none.
   subroutine find_curve_breaks(curve, from, to, breaks)
      type(curve_type), intent(in) :: curve
      !> Range of x, from < to
      real(wp), intent(in) :: from, to
      type(curve_break_type), allocatable, intent(out) :: breaks(:)
      type(curve_break_type) :: found
      type(range_type) :: range
      real(wp), allocatable :: places(:)
      type(ieee_status_type) :: status
      integer :: i
      allocate (breaks(0))
      if (.not. curve%explicit) return
      if (size(curve%expression%slots) == 0) return
      range = law_range(curve%expression, from, to)
      if (range%whole) return
      ! The expression may have no value somewhere: floating-point exceptions must not stop the program
      call ieee_get_status(status)
      call ieee_set_halting_mode(ieee_all, .false.)
      allocate (places(0))
      call law_breaks(curve%expression, from, to, places)
      do i = 1, size(places)
         call classify(curve, places(i), to - from, found)
         if (found%kind /= break_none) breaks = [breaks, found]
      end do
      call ieee_set_status(status)
   end subroutine find_curve_breaks

   !> Finds the kind of a break and the values on both sides, eq. (5.58).
   subroutine classify(curve, place, width, found)
      type(curve_type), intent(in) :: curve
      real(wp), intent(in) :: place
      !> Width of the searched range of x
      real(wp), intent(in) :: width
      type(curve_break_type), intent(out) :: found
      !> Distance of both sides from the place, in units of the last digit; largest changes that count as round-off: of y relative
      !> to the width, of the angle [rad], of the second derivative relative to itself
      real(wp), parameter :: beside = 8.0_wp, level = 1.0e-9_wp, straight = 1.0e-6_wp, same = 1.0e-6_wp
      found%place = place
      found%before = place - beside*spacing(max(abs(place), width))
      found%behind = place + beside*spacing(max(abs(place), width))
      found%left = curve%expression%evaluate_jet(found%before)
      found%right = curve%expression%evaluate_jet(found%behind)
      associate (a => found%left, b => found%right)
         if (.not. (is_finite(a) .and. is_finite(b))) return
         if (abs(b%value - a%value) > level*width) then
            found%kind = break_jump
         else if (abs(atan(b%first) - atan(a%first)) > straight) then
            found%kind = break_kink
         else if (abs(b%second - a%second) > same*max(abs(a%second), abs(b%second))) then
            found%kind = break_bend
         end if
      end associate
   end subroutine classify

   pure logical function is_finite(jet)
      type(jet_type), intent(in) :: jet
      is_finite = max(abs(jet%value), abs(jet%first), abs(jet%second)) <= huge(1.0_wp) .and. abs(jet%value) >= 0.0_wp &
         & .and. abs(jet%first) >= 0.0_wp .and. abs(jet%second) >= 0.0_wp
   end function is_finite

end module limber_model_curve_breaks
