!> Scalar functions of joints: lengths and angles between points and directions. Each is at most quadratic in these vectors, or has
!> a gradient over a step that makes its change exactly; so a linear combination of measures needs nothing else to be a constraint
!> in all integrators. Floor: multibody. Source: doc/theory, eqs. (3.7), (3.9), (3.14), (3.15).
module limber_multibody_joint_functions
   use limber_base_kinds, only: wp
   use limber_multibody_plane_vectors, only: turn, cross
   use limber_multibody_markers, only: vector_angle_gradient, vector_angle_hessian
   implicit none
   private
   public :: joint_function_type, measure_value, measure_gradient, measure_hessian

   !> axis.(v1 - v2); (v1 - v2).v3; v1 x v2; |v1 - v2|; the angle of v1 - v2, followed over turns; (v1 x v2)(v2.v2 - v1.v1), the
   !> cube of the slope of a section whose direction is v2 in the frame of direction v1
   integer, parameter, public :: measure_component = 1, measure_along = 2, measure_cross = 3, measure_distance = 4, &
      & measure_angle = 5, measure_slope = 6

   !> One measure
   type :: joint_function_type
      integer :: kind = 0
      !> Its vectors v1, v2, v3, of the constraint's; 0: none, which counts as zero
      integer :: vectors(3) = 0
      !> Index of the followed angle
      integer :: angle = 0
      !> Unit vector in space
      real(wp) :: axis(2) = 0.0_wp
   end type joint_function_type

contains

   !> Value at given vectors; not of an angle, which is followed.
   pure real(wp) function measure_value(measure, y) result(value)
      type(joint_function_type), intent(in) :: measure
      !> Vectors of the constraint (2, vectors)
      real(wp), intent(in) :: y(:, :)
      real(wp) :: v(2, 3)
      v = own(measure, y)
      select case (measure%kind)
      case (measure_component); value = dot_product(measure%axis, v(:, 1) - v(:, 2))
      case (measure_along); value = dot_product(v(:, 1) - v(:, 2), v(:, 3))
      case (measure_cross); value = cross(v(:, 1), v(:, 2))
      case (measure_distance); value = norm2(v(:, 1) - v(:, 2))
      case (measure_slope); value = cross(v(:, 1), v(:, 2))*excess(v(:, 1), v(:, 2))
      case default; value = atan2(v(2, 1) - v(2, 2), v(1, 1) - v(1, 2))
      end select
   end function measure_value

   !> Derivatives by its own vectors (2,3). Over a step, with means of the vectors, those that give the change exactly.
   pure function measure_gradient(measure, y, rate, span) result(g)
      type(joint_function_type), intent(in) :: measure
      !> Vectors of the constraint, and their rates (2, vectors)
      real(wp), intent(in) :: y(:, :), rate(:, :)
      !> Length of the step; 0: an instant
      real(wp), intent(in) :: span
      real(wp) :: g(2, 3), v(2, 3), w(2, 3), gap(2), half(2), length, turned, longer
      v = own(measure, y)
      gap = v(:, 1) - v(:, 2)
      g = 0.0_wp
      select case (measure%kind)
      case (measure_component)
         g(:, 1) = measure%axis
      case (measure_along)
         g(:, 1) = v(:, 3)
         g(:, 3) = gap
      case (measure_cross)
         g(:, 1) = -turn(v(:, 2))
         g(:, 2) = turn(v(:, 1))
         return
      case (measure_slope)
         ! Of a product over a step: the mean of one factor times the change of the other, both ways
         turned = cross(v(:, 1), v(:, 2))
         longer = excess(v(:, 1), v(:, 2))
         if (span > 0.0_wp) then
            w = 0.5_wp*span*own(measure, rate)
            turned = 0.5_wp*(cross(v(:, 1) - w(:, 1), v(:, 2) - w(:, 2)) + cross(v(:, 1) + w(:, 1), v(:, 2) + w(:, 2)))
            longer = 0.5_wp*(excess(v(:, 1) - w(:, 1), v(:, 2) - w(:, 2)) + excess(v(:, 1) + w(:, 1), v(:, 2) + w(:, 2)))
         end if
         g(:, 1) = -longer*turn(v(:, 2)) - 2*turned*v(:, 1)
         g(:, 2) = longer*turn(v(:, 1)) + 2*turned*v(:, 2)
         return
      case (measure_distance)
         length = norm2(gap)
         if (span > 0.0_wp) then
            w = own(measure, rate)
            half = 0.5_wp*span*(w(:, 1) - w(:, 2))
            length = 0.5_wp*(norm2(gap - half) + norm2(gap + half))
         end if
         g(:, 1) = gap/length
      case default
         w = own(measure, rate)
         g(:, 1) = vector_angle_gradient(gap, w(:, 1) - w(:, 2), span)
      end select
      g(:, 2) = -g(:, 1)
   end function measure_gradient

   !> Second derivatives by its own vectors (6,6).
   pure function measure_hessian(measure, y) result(h)
      type(joint_function_type), intent(in) :: measure
      real(wp), intent(in) :: y(:, :)
      real(wp) :: h(6, 6), v(2, 3), gap(2), part(2, 2), length, turning(2, 2), lengthening(2, 2)
      integer :: i, j
      h = 0.0_wp
      v = own(measure, y)
      gap = v(:, 1) - v(:, 2)
      select case (measure%kind)
      case (measure_component)
      case (measure_along)
         do i = 1, 2
            h(i, 4 + i) = 1.0_wp
            h(4 + i, i) = 1.0_wp
            h(2 + i, 4 + i) = -1.0_wp
            h(4 + i, 2 + i) = -1.0_wp
         end do
      case (measure_cross)
         h(1, 4) = 1.0_wp
         h(4, 1) = 1.0_wp
         h(2, 3) = -1.0_wp
         h(3, 2) = -1.0_wp
      case (measure_slope)
         turning(:, 1) = -turn(v(:, 2))
         turning(:, 2) = turn(v(:, 1))
         lengthening(:, 1) = -2*v(:, 1)
         lengthening(:, 2) = 2*v(:, 2)
         do j = 1, 4
            do i = 1, 4
               h(i, j) = entry(turning, i)*entry(lengthening, j) + entry(lengthening, i)*entry(turning, j)
            end do
            h(j, j) = h(j, j) + merge(-2.0_wp, 2.0_wp, j <= 2)*cross(v(:, 1), v(:, 2))
         end do
         h(1, 4) = h(1, 4) + excess(v(:, 1), v(:, 2))
         h(4, 1) = h(4, 1) + excess(v(:, 1), v(:, 2))
         h(2, 3) = h(2, 3) - excess(v(:, 1), v(:, 2))
         h(3, 2) = h(3, 2) - excess(v(:, 1), v(:, 2))
      case default
         if (measure%kind == measure_distance) then
            length = norm2(gap)
            gap = gap/length
            do j = 1, 2
               part(:, j) = -gap*gap(j)/length
               part(j, j) = part(j, j) + 1/length
            end do
         else
            part = vector_angle_hessian(gap)
         end if
         h(1:2, 1:2) = part
         h(3:4, 3:4) = part
         h(1:2, 3:4) = -part
         h(3:4, 1:2) = -part
      end select
   end function measure_hessian

   !> Square of the second vector less that of the first.
   pure real(wp) function excess(a, b)
      real(wp), intent(in) :: a(2), b(2)
      excess = dot_product(b, b) - dot_product(a, a)
   end function excess

   !> Entry of two vectors, one after the other.
   pure real(wp) function entry(vectors, i)
      real(wp), intent(in) :: vectors(2, 2)
      integer, intent(in) :: i
      entry = vectors(modulo(i - 1, 2) + 1, (i + 1)/2)
   end function entry

   !> The vectors of a measure (2,3); zero where there is none.
   pure function own(measure, y) result(v)
      type(joint_function_type), intent(in) :: measure
      real(wp), intent(in) :: y(:, :)
      real(wp) :: v(2, 3)
      integer :: i
      v = 0.0_wp
      do i = 1, 3
         if (measure%vectors(i) > 0) v(:, i) = y(:, measure%vectors(i))
      end do
   end function own

end module limber_multibody_joint_functions
