!> Integrals of a law of time as piecewise Chebyshev series between the breaks of the law, to round-off. For drivers of velocity or
!> acceleration. Floor: model. Source: doc/theory, eq. (3.29).
module limber_model_law_integrals
   use limber_base_kinds, only: wp
   use limber_deck_expression, only: expression_type
   use limber_deck_operations, only: jet_type
   implicit none
   private
   public :: integral_type, integrate, integral_value

   !> Terms of each series, and largest number of pieces
   integer, parameter :: terms = 24, most = 100000
   real(wp), parameter :: pi = acos(-1.0_wp)

   !> First and second integral of a law; both are zero at the first edge
   type :: integral_type
      !> Edges of the pieces (0:pieces)
      real(wp), allocatable :: edges(:)
      !> Coefficients of the first and second integral on each piece (0:terms, 2, pieces)
      real(wp), allocatable :: series(:, :, :)
   end type integral_type

contains

   !> Integrates a law from start to end.
   function integrate(law, start, end, breaks) result(integral)
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: start, end
      !> Breaks of the law in ascending order [time]
      real(wp), intent(in) :: breaks(:)
      type(integral_type) :: integral
      real(wp), allocatable :: edges(:), longer(:)
      real(wp) :: left, right, width, scale, basis(terms - 1, 0:terms - 2)
      integer :: i, count
      allocate (edges(64))
      edges(1) = start
      count = 1
      basis = cosines()
      scale = largest(law, start, end, breaks)
      do i = 1, size(breaks) + 1
         left = edges(count)
         right = end
         if (i <= size(breaks)) right = min(end, breaks(i))
         width = right - left
         do while (right - left > 4*epsilon(left)*max(abs(left), abs(right)) .and. count < most)
            width = min(width, right - left)
            if (.not. resolved(law, basis, left, left + width, scale) .and. width > 1.0e-9_wp*(end - start)) then
               width = 0.5_wp*width
               cycle
            end if
            left = merge(right, left + width, width >= right - left)
            if (count == size(edges)) then
               allocate (longer(2*count))
               longer(:count) = edges
               call move_alloc(longer, edges)
            end if
            count = count + 1
            edges(count) = left
            width = 2*width
         end do
      end do
      allocate (integral%edges(0:count - 1))
      integral%edges(:) = edges(:count)
      call fill(law, basis, integral)
   end function integrate

   !> Computes the series of all pieces; each starts at the end value of the piece before.
   subroutine fill(law, basis, integral)
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: basis(:, 0:)
      type(integral_type), intent(inout) :: integral
      real(wp) :: c(0:terms), first(0:terms), half, value(2)
      integer :: i
      allocate (integral%series(0:terms, 2, ubound(integral%edges, 1)))
      value = 0.0_wp
      do i = 1, ubound(integral%edges, 1)
         half = 0.5_wp*(integral%edges(i) - integral%edges(i - 1))
         c = chebyshev(law, basis, integral%edges(i - 1), integral%edges(i))
         first = antiderivative(c, half, value(1))
         integral%series(:, 1, i) = first
         integral%series(:, 2, i) = antiderivative(first, half, value(2))
         value = [clenshaw(integral%series(:, 1, i), 1.0_wp), clenshaw(integral%series(:, 2, i), 1.0_wp)]
      end do
   end subroutine fill

   !> Whether the last terms of a piece's series are round-off, of the law or of the time. Where the law is below a millionth of its
   !> largest value, the precision may be lower.
   logical function resolved(law, basis, left, right, scale)
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: basis(:, 0:), left, right
      !> Largest value of the law
      real(wp), intent(in) :: scale
      real(wp), parameter :: little = 1.0e-6_wp
      real(wp) :: c(0:terms), slope
      type(jet_type) :: jet
      integer :: i
      c = chebyshev(law, basis, left, right)
      ! Shorter pieces do not help where the law has no value
      resolved = .not. all(abs(c) <= huge(c))
      if (resolved) return
      slope = 0.0_wp
      do i = 0, 4
         jet = law%evaluate_jet(left + 0.25_wp*i*(right - left))
         slope = max(slope, abs(jet%first))
      end do
      resolved = maxval(abs(c(terms - 5:terms - 2))) <= max(2.0e-14_wp*max(maxval(abs(c)), little*scale, tiny(1.0_wp)), &
         & epsilon(slope)*max(abs(left), abs(right))*slope)
   end function resolved

   !> Largest absolute value of a law, sampled at equal intervals and at its breaks.
   real(wp) function largest(law, start, end, breaks)
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: start, end, breaks(:)
      integer, parameter :: parts = 100
      integer :: i
      largest = 0.0_wp
      do i = 0, parts
         largest = max(largest, abs(law%evaluate([start + (end - start)*(real(i, wp)/parts)])))
      end do
      do i = 1, size(breaks)
         largest = max(largest, abs(law%evaluate([breaks(i)])))
      end do
   end function largest

   !> Chebyshev polynomials at the Chebyshev points (points, degree from 0).
   pure function cosines() result(basis)
      real(wp) :: basis(terms - 1, 0:terms - 2)
      integer :: j, k
      do k = 0, terms - 2
         do j = 1, terms - 1
            basis(j, k) = cos(k*pi*(j - 0.5_wp)/(terms - 1))
         end do
      end do
   end function cosines

   !> Coefficients of the polynomial through a law at the inner Chebyshev points of a piece. The last two are zero: room for two
   !> integrations.
   function chebyshev(law, basis, left, right) result(c)
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: basis(:, 0:), left, right
      real(wp) :: c(0:terms), value(terms - 1)
      integer :: j, k
      do j = 1, terms - 1
         value(j) = law%evaluate([0.5_wp*(left + right) + 0.5_wp*(right - left)*basis(j, 1)])
      end do
      c = 0.0_wp
      do k = 0, terms - 2
         c(k) = merge(1.0_wp, 2.0_wp, k == 0)/(terms - 1)*dot_product(value, basis(:, k))
      end do
   end function chebyshev

   !> Series of the integral, with a given value at the left end.
   pure function antiderivative(c, half, start) result(b)
      real(wp), intent(in) :: c(0:terms)
      !> Half the length of the piece; value at its left end
      real(wp), intent(in) :: half, start
      real(wp) :: b(0:terms)
      integer :: k
      b = 0.0_wp
      b(1) = half*(c(0) - 0.5_wp*c(2))
      do k = 2, terms - 1
         b(k) = half*(c(k - 1) - c(k + 1))/(2*k)
      end do
      b(terms) = half*c(terms - 1)/(2*terms)
      b(0) = start - clenshaw(b, -1.0_wp)
   end function antiderivative

   !> Value of a series at x, -1 <= x <= 1, by Clenshaw's recurrence.
   pure real(wp) function clenshaw(c, x) result(value)
      real(wp), intent(in) :: c(0:terms), x
      real(wp) :: one, two, next
      integer :: k
      one = 0.0_wp
      two = 0.0_wp
      do k = terms, 1, -1
         next = 2*x*one - two + c(k)
         two = one
         one = next
      end do
      value = x*one - two + c(0)
   end function clenshaw

   !> First or second integral at time t, with its two derivatives.
   pure function integral_value(integral, law, level, t) result(jet)
      type(integral_type), intent(in) :: integral
      type(expression_type), intent(in) :: law
      !> 1: the law is the velocity, 2: the acceleration
      integer, intent(in) :: level
      real(wp), intent(in) :: t
      type(jet_type) :: jet, own
      real(wp) :: x
      integer :: low, high, middle
      low = 1
      high = ubound(integral%edges, 1)
      do while (high > low)
         middle = (low + high)/2
         if (t < integral%edges(middle)) then
            high = middle
         else
            low = middle + 1
         end if
      end do
      x = (2*t - integral%edges(low - 1) - integral%edges(low))/(integral%edges(low) - integral%edges(low - 1))
      own = law%evaluate_jet(t)
      jet%value = clenshaw(integral%series(:, level, low), x)
      if (level == 1) then
         jet%first = own%value
         jet%second = own%first
      else
         jet%first = clenshaw(integral%series(:, 1, low), x)
         jet%second = own%value
      end if
   end function integral_value

end module limber_model_law_integrals
