!> Dense output of order 5. The quintic through coordinates, rates and accelerations at both ends of a step, its derivative for the
!> rates. Floor: integrator. Source: Hermite interpolation; rotations by `advance`; doc/theory, eq. (5.12).
module limber_integrator_quintic_output
   use limber_base_kinds, only: wp
   use limber_multibody_plane_vectors, only: cross
   use limber_multibody_layout, only: layout_type, velocities_of, advance
   implicit none
   private
   public :: quintic_state, quintic_place, quintic_accelerations, factors_of_rates, add_projection

contains

   !> Coordinates and velocities at a part of a step.
   pure subroutine quintic_state(layout, part, h, q_before, increment, w_before, w, a_before, a, change, rates, q, v)
      type(layout_type), intent(in) :: layout
      !> Part of the step that has gone, 0 to 1, and its length
      real(wp), intent(in) :: part, h
      !> Coordinates at its beginning (nq), its increment (nw); rates and accelerations at its beginning and its end (nw)
      real(wp), contiguous, intent(in) :: q_before(:), increment(:), w_before(:), w(:), a_before(:), a(:)
      !> Scratch (nw)
      real(wp), contiguous, intent(inout) :: change(:), rates(:)
      !> Coordinates and velocities (nq)
      real(wp), contiguous, intent(inout) :: q(:), v(:)
      real(wp) :: d(5)
      integer :: k
      call quintic_place(layout, part, h, q_before, increment, w_before, w, a_before, a, change, q)
      d = factors_of_rates(part)/h
      d(2:5) = d(2:5)*[h, h**2, h, h**2]
      do k = 1, size(w)
         rates(k) = d(1)*increment(k) + d(2)*w_before(k) + d(3)*a_before(k) + d(4)*w(k) + d(5)*a(k)
      end do
      call velocities_of(layout, q, rates, v)
   end subroutine quintic_state

   !> Factors of increment, h w0, h^2 a0, h w1 and h^2 a1 in the rates, times h.
   pure function factors_of_rates(s) result(d)
      !> Part of the step
      real(wp), intent(in) :: s
      real(wp) :: d(5)
      d = [30*s**2*(1 - s)**2, 1 - 18*s**2 + 32*s**3 - 15*s**4, s - 4.5_wp*s**2 + 6*s**3 - 2.5_wp*s**4, &
         & -12*s**2 + 28*s**3 - 15*s**4, 1.5_wp*s**2 - 4*s**3 + 2.5_wp*s**4]
   end function factors_of_rates

   !> Its second derivative (nw).
   pure subroutine quintic_accelerations(part, h, increment, w_before, w, a_before, a, accelerations)
      !> As in `quintic_state`
      real(wp), intent(in) :: part, h
      real(wp), contiguous, intent(in) :: increment(:), w_before(:), w(:), a_before(:), a(:)
      real(wp), contiguous, intent(inout) :: accelerations(:)
      real(wp) :: d(5)
      integer :: k
      associate (s => part)
         ! Factors of increment/h^2, w0/h, a0, w1/h, a1
         d = [60*s*(1 - s)*(1 - 2*s), -36*s + 96*s**2 - 60*s**3, 1 - 9*s + 18*s**2 - 10*s**3, -24*s + 84*s**2 - 60*s**3, &
            & 3*s - 12*s**2 + 10*s**3]
      end associate
      d = d/[h**2, h, 1.0_wp, h, 1.0_wp]
      do k = 1, size(accelerations)
         accelerations(k) = d(1)*increment(k) + d(2)*w_before(k) + d(3)*a_before(k) + d(4)*w(k) + d(5)*a(k)
      end do
   end subroutine quintic_accelerations

   !> The coordinates alone.
   pure subroutine quintic_place(layout, part, h, q_before, increment, w_before, w, a_before, a, change, q)
      type(layout_type), intent(in) :: layout
      !> As in `quintic_state`
      real(wp), intent(in) :: part, h
      real(wp), contiguous, intent(in) :: q_before(:), increment(:), w_before(:), w(:), a_before(:), a(:)
      !> Scratch (nw)
      real(wp), contiguous, intent(inout) :: change(:)
      !> (nq)
      real(wp), contiguous, intent(inout) :: q(:)
      real(wp) :: b(5)
      integer :: k
      associate (s => part)
         ! Factors of [increment, h w0, h^2 a0, h w1, h^2 a1]
         b = [s**3*(10 - 15*s + 6*s**2), s - 6*s**3 + 8*s**4 - 3*s**5, 0.5_wp*s**2*(1 - s)**3, -4*s**3 + 7*s**4 - 3*s**5, &
            & 0.5_wp*s**3*(1 - s)**2]
      end associate
      b(2:5) = b(2:5)*[h, h**2, h, h**2]
      do k = 1, size(w)
         change(k) = b(1)*increment(k) + b(2)*w_before(k) + b(3)*a_before(k) + b(4)*w(k) + b(5)*a(k)
      end do
      call advance(layout, q_before, change, q)
   end subroutine quintic_place

   !> Adds what a projection has changed to the increment of a step, where it is more than round-off. Differences of the coordinates
   !> over the step are not taken: divided by a step that is next to nothing, their round-off would be velocities.
   pure subroutine add_projection(layout, round_off, before, behind, scales, increment)
      type(layout_type), intent(in) :: layout
      !> Part of a coordinate that is none
      real(wp), intent(in) :: round_off
      !> Coordinates before the projection and behind it (nq); their scales, and the increment (nw)
      real(wp), contiguous, intent(in) :: before(:), behind(:), scales(:)
      real(wp), contiguous, intent(inout) :: increment(:)
      integer :: i, from, to, n
      do i = 1, size(layout%q)
         from = layout%q(i)
         to = layout%w(i)
         n = layout%n(i)
         call add(before(from:from + 1), behind(from:from + 1), scales(to:to + 1), increment(to:to + 1))
         if (.not. layout%framed(i)) cycle
         increment(to + 2) = increment(to + 2) + cross(before(from + 2:from + 3), behind(from + 2:from + 3))
         call add(before(from + 4:from + 3 + n), behind(from + 4:from + 3 + n), scales(to + 3:to + 2 + n), &
            & increment(to + 3:to + 2 + n))
      end do

   contains

      pure elemental subroutine add(x, y, scale, sum)
         real(wp), intent(in) :: x, y, scale
         real(wp), intent(inout) :: sum
         if (abs(y - x) > round_off*max(abs(x), scale)) sum = sum + (y - x)
      end subroutine add

   end subroutine add_projection

end module limber_integrator_quintic_output
