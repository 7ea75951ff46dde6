!> Scalar functions of the motion, each kind at random vectors: first and second derivatives against differences, the rate, and over
!> steps of any length values at the ends, their mean and the exact change.
program test_scalar_functions
   use limber_base_kinds, only: wp
   use limber_multibody_kinematics, only: kinematics_type
   use limber_multibody_scalar_functions, only: scalar_function_type, scalar_component, scalar_along, scalar_cross, &
      & scalar_distance, scalar_angle, scalar_turn, scalar_slope, function_value, read_function, read_gap, function_weights, &
      & function_ends, function_hessian, hessian_times, compare_functions
   use scenes, only: derivative, random
   use testing, only: check, check_close, finish
   implicit none

   !> Step of the stencils
   real(wp), parameter :: h = 1.0e-3_wp
   character(10), parameter :: names(11) = [character(10) :: 'component', 'along', 'unit along', 'cross', 'distance', 'softened', &
      & 'angle', 'turn', 'of one', 'slope', 'one point']
   type(scalar_function_type) :: functions(11)
   integer :: i, trial

   call choose_functions()
   do i = 1, size(functions)
      do trial = 1, 20
         call test_instant(functions(i), trim(names(i)))
         call test_step(functions(i), trim(names(i)))
      end do
   end do
   call test_comparison()
   call finish()

contains

   !> Every kind, with all that it can have.
   subroutine choose_functions()
      functions(1) = scalar_function_type(kind=scalar_component, markers=[1, 2, 0], axis=[0.6_wp, -0.8_wp])
      functions(2) = scalar_function_type(kind=scalar_along, markers=[1, 2, 3])
      functions(3) = scalar_function_type(kind=scalar_along, markers=[1, 2, 3], unit=.true., origin=0.3_wp)
      functions(4) = scalar_function_type(kind=scalar_cross, markers=[1, 2, 0])
      functions(5) = scalar_function_type(kind=scalar_distance, markers=[1, 2, 0])
      functions(6) = scalar_function_type(kind=scalar_distance, markers=[2, 3, 0], softening=0.5_wp, origin=0.7_wp)
      functions(7) = scalar_function_type(kind=scalar_angle, markers=[2, 1, 0], angles=[1, 0])
      functions(8) = scalar_function_type(kind=scalar_turn, markers=[1, 3, 0], angles=[2, 3], origin=0.2_wp)
      functions(9) = scalar_function_type(kind=scalar_turn, markers=[0, 3, 0], angles=[0, 3])
      functions(10) = scalar_function_type(kind=scalar_slope, markers=[1, 2, 0])
      functions(11) = scalar_function_type(kind=scalar_distance, markers=[1, 0, 0])
   end subroutine choose_functions

   !> Derivatives at an instant.
   subroutine test_instant(scalar, name)
      type(scalar_function_type), intent(in) :: scalar
      character(*), intent(in) :: name
      type(kinematics_type) :: kinematics
      real(wp) :: v(2, 3), w(2, 3), moved(2, 3), value, rate, weights(2, 3), hessian(2, 3, 2, 3), values(-2:2), slopes(2, 3, -2:2)
      real(wp) :: gap(2), drift(2), ends(2), change(2)
      integer :: i, m, k, n
      call choose_vectors(v, w)
      call place(v, w, 0.0_wp, kinematics)
      call read_function(scalar, kinematics, value, rate, weights)
      call function_weights(scalar, kinematics, slopes(:, :, 0))
      call function_hessian(scalar, kinematics, hessian)
      call function_ends(scalar, kinematics, ends(1), ends(2))
      call check_close(function_value(scalar, kinematics), value, 1.0e-14_wp*(1 + abs(value)), name//': value')
      call check(all(abs(ends - value) <= 1.0e-14_wp*(1 + abs(value))), name//': an instant has no ends')
      call check(all(abs(slopes(:, :, 0) - weights) <= 1.0e-14_wp*maxval(abs(weights))), name//': weights')
      call check_close(rate, weighted(scalar, weights, w), 1.0e-13_wp*(1 + abs(rate)), name//': rate')
      call read_gap(scalar, kinematics, gap, drift)
      if (all(scalar%markers(1:2) > 0)) call check(all(abs(gap - (v(:, scalar%markers(1)) - v(:, scalar%markers(2)))) &
         & <= 1.0e-15_wp*maxval(abs(v))), name//': gap')
      do m = 1, 3
         if (scalar%markers(m) == 0) cycle
         do i = 1, 2
            do k = -2, 2
               moved = v
               moved(i, scalar%markers(m)) = moved(i, scalar%markers(m)) + k*h
               call place(moved, w, 0.0_wp, kinematics)
               values(k) = function_value(scalar, kinematics)
               call function_weights(scalar, kinematics, slopes(:, :, k))
            end do
            call check_close(weights(i, m), derivative(values(-2), values(-1), values(1), values(2), h), 1.0e-8_wp, &
               & name//': first derivative')
            do n = 1, 3
               if (scalar%markers(n) == 0) cycle
               change = derivative(slopes(:, n, -2), slopes(:, n, -1), slopes(:, n, 1), slopes(:, n, 2), h)
               call check(all(abs(hessian(:, n, i, m) - change) <= 1.0e-7_wp), name//': second derivative')
               call check(all(abs(hessian(:, n, i, m) - hessian(i, m, :, n)) <= 1.0e-12_wp), name//': symmetry')
               change = hessian_times(hessian, n, m, [2.0_wp, -3.0_wp])
               call check(all(abs(change - 2*hessian(:, n, 1, m) + 3*hessian(:, n, 2, m)) <= 1.0e-12_wp), name//': product')
            end do
         end do
      end do
   end subroutine test_instant

   !> Over a step of any length the weights make the change, and the value is the mean.
   subroutine test_step(scalar, name)
      type(scalar_function_type), intent(in) :: scalar
      character(*), intent(in) :: name
      type(kinematics_type) :: kinematics
      real(wp), parameter :: span = 0.4_wp
      real(wp) :: v(2, 3), w(2, 3), start, end, ends(2), value, rate, weights(2, 3), only(2, 3)
      call choose_vectors(v, w)
      call place(v - 0.5_wp*span*w, w, 0.0_wp, kinematics)
      start = function_value(scalar, kinematics)
      call place(v + 0.5_wp*span*w, w, 0.0_wp, kinematics)
      end = function_value(scalar, kinematics)
      call place(v, w, span, kinematics)
      call read_function(scalar, kinematics, value, rate, weights)
      call function_weights(scalar, kinematics, only)
      call function_ends(scalar, kinematics, ends(1), ends(2))
      call check_close(span*weighted(scalar, weights, w), end - start, 1.0e-13_wp, name//': change over a step')
      call check_close(span*rate, end - start, 1.0e-13_wp, name//': increment of a step')
      call check_close(value, 0.5_wp*(start + end), 1.0e-13_wp, name//': mean of a step')
      call check(all(abs(ends - [start, end]) <= 1.0e-13_wp), name//': ends of a step')
      call check(all(abs(only - weights) <= 1.0e-14_wp*(1 + abs(weights))), name//': weights over a step')
   end subroutine test_step

   !> Sum of weights and the velocities of the function's markers.
   pure real(wp) function weighted(scalar, weights, w) result(sum)
      type(scalar_function_type), intent(in) :: scalar
      real(wp), intent(in) :: weights(2, 3), w(2, 3)
      integer :: m
      sum = 0.0_wp
      do m = 1, 3
         if (scalar%markers(m) > 0) sum = sum + dot_product(weights(:, m), w(:, scalar%markers(m)))
      end do
   end function weighted

   !> Points and directions apart, and their velocities.
   subroutine choose_vectors(v, w)
      real(wp), intent(out) :: v(2, 3), w(2, 3)
      integer :: i, m
      do m = 1, 3
         do i = 1, 2
            v(i, m) = 0.2_wp*random()
            w(i, m) = random()
         end do
      end do
      v(:, 1) = v(:, 1) + [2.0_wp, 0.5_wp]
      v(:, 2) = v(:, 2) + [-1.0_wp, 1.5_wp]
      v(:, 3) = v(:, 3) + [0.4_wp, -1.2_wp]
   end subroutine choose_vectors

   !> Markers at vectors, and the followed angles of the second from the first, of the first, and of the third; over a step their
   !> means.
   subroutine place(v, w, span, kinematics)
      real(wp), intent(in) :: v(2, 3), w(2, 3), span
      type(kinematics_type), intent(inout) :: kinematics
      integer :: m
      if (.not. allocated(kinematics%markers)) allocate (kinematics%markers(3), kinematics%angles(3))
      kinematics%span = span
      do m = 1, 3
         kinematics%markers(m)%position = v(:, m)
         kinematics%markers(m)%velocity = w(:, m)
      end do
      kinematics%angles(1)%value = 0.5_wp*(angle(v(:, 2) - v(:, 1) - 0.5_wp*span*(w(:, 2) - w(:, 1))) &
         & + angle(v(:, 2) - v(:, 1) + 0.5_wp*span*(w(:, 2) - w(:, 1))))
      kinematics%angles(2)%value = 0.5_wp*(angle(v(:, 1) - 0.5_wp*span*w(:, 1)) + angle(v(:, 1) + 0.5_wp*span*w(:, 1)))
      kinematics%angles(3)%value = 0.5_wp*(angle(v(:, 3) - 0.5_wp*span*w(:, 3)) + angle(v(:, 3) + 0.5_wp*span*w(:, 3)))
   end subroutine place

   !> Counted from a direction that these vectors do not pass.
   pure real(wp) function angle(vector)
      real(wp), intent(in) :: vector(2)
      angle = atan2(vector(2), vector(1))
      if (angle < -0.75_wp*acos(-1.0_wp)) angle = angle + 2*acos(-1.0_wp)
   end function angle

   !> Functions that are one but for the sign and a constant.
   subroutine test_comparison()
      type(scalar_function_type) :: other
      real(wp) :: sign, shift
      logical :: alike
      other = functions(1)
      other%markers(1:2) = other%markers(2:1:-1)
      other%origin = 0.5_wp
      call compare_functions(functions(1), other, sign, shift, alike)
      call check(alike, 'the opposite component')
      call check_close(sign, -1.0_wp, 0.0_wp, 'its sign')
      call check_close(shift, -0.5_wp, 1.0e-15_wp, 'its shift')
      other = functions(8)
      other%angles = other%angles(2:1:-1)
      call compare_functions(functions(8), other, sign, shift, alike)
      call check(alike .and. sign < 0.0_wp, 'the opposite angle')
      other = functions(6)
      other%markers(1:2) = other%markers(2:1:-1)
      call compare_functions(functions(6), other, sign, shift, alike)
      call check(alike .and. sign > 0.0_wp, 'a distance has no direction')
      other%origin = 1.0_wp
      other%softening = 0.4_wp
      call compare_functions(functions(6), other, sign, shift, alike)
      call check(alike, 'springs of two free lengths between two points, whose softening follows from these')
      call check_close(shift, -0.3_wp, 1.0e-15_wp, 'what their elongations differ by')
      call compare_functions(functions(2), functions(3), sign, shift, alike)
      call check(.not. alike, 'a direction of unit length is another')
      call compare_functions(functions(5), functions(6), sign, shift, alike)
      call check(.not. alike, 'distances of other points')
   end subroutine test_comparison

end program test_scalar_functions
