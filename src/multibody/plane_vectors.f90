!> Plane vector algebra of the floating frame. J turns a vector by a right angle, A(p) = p1 I + p2 J applied to the unit vector u
!> gives the vector whose components in the frame are p. Floor: multibody. Source: doc/theory, eqs. (1.2), (1.3).
module limber_multibody_plane_vectors
   use limber_base_kinds, only: wp
   implicit none
   private
   public :: axis_of, turn, along, into_frame, cross

contains

   !> J a: the vector turned by +90 degrees.
   pure function turn(a) result(b)
      real(wp), intent(in) :: a(2)
      real(wp) :: b(2)
      b(1) = -a(2)
      b(2) = a(1)
   end function turn

   !> A(p) u = p1 u + p2 J u: the vector with components p in the frame of u.
   pure function along(p, u) result(b)
      real(wp), intent(in) :: p(2), u(2)
      real(wp) :: b(2)
      b(1) = p(1)*u(1) - p(2)*u(2)
      b(2) = p(1)*u(2) + p(2)*u(1)
   end function along

   !> Components of a vector in the frame of u.
   pure function into_frame(a, u) result(p)
      real(wp), intent(in) :: a(2), u(2)
      real(wp) :: p(2)
      p(1) = u(1)*a(1) + u(2)*a(2)
      p(2) = cross(u, a)
   end function into_frame

   !> a x b = a1 b2 - a2 b1.
   pure real(wp) function cross(a, b)
      real(wp), intent(in) :: a(2), b(2)
      cross = a(1)*b(2) - a(2)*b(1)
   end function cross

   !> Unit vector at an angle; exactly that of an axis of the ground at a whole number of quarters of a turn.
   pure function axis_of(angle) result(axis)
      real(wp), intent(in) :: angle
      real(wp) :: axis(2)
      axis = [cos(angle), sin(angle)]
      if (any(abs(axis) < 4*epsilon(angle))) axis = anint(axis)
   end function axis_of

end module limber_multibody_plane_vectors
