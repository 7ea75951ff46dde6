!> Element matrices of the plane Euler-Bernoulli beam: k_E, k_G, lumped mass. Stiffness k_E, geometric stiffness k_G, lumped masses
!> and shape functions. Pure, on explicit-shape arrays; used before the time loop only.
!>
!> An element of length l carries at each end the axial displacement u, the deflection w and the
!> rotation theta = dw/ds, in that order: (u1, w1, theta1, u2, w2, theta2). The axial and the bending
!> part do not couple, so that they come as a 2 x 2 and a 4 x 4 matrix (`beam_stiffness` puts them together).
!> Floor: beam. Source: Przemieniecki, Theory of Matrix Structural Analysis, sections 5.6 and 15.4.
module limber_beam_element_matrices
   use limber_base_kinds, only: wp
   implicit none
   private
   public :: axial_stiffness, bending_stiffness, beam_stiffness, geometric_stiffness, lumped_mass
   public :: bending_shape, bending_slope, bending_curvature

   !> Positions of (u1, u2) and of (w1, theta1, w2, theta2) among the six element coordinates
   integer, parameter, public :: axial_dofs(2) = [1, 4], bending_dofs(4) = [2, 3, 5, 6]

contains

   !> Axial stiffness of an element on (u1, u2).
   pure function axial_stiffness(ea, l) result(k)
      !> Axial rigidity E A [force]
      real(wp), intent(in) :: ea
      !> Element length [length]
      real(wp), intent(in) :: l
      real(wp) :: k(2, 2)
      k = reshape([1.0_wp, -1.0_wp, -1.0_wp, 1.0_wp], [2, 2])*(ea/l)
   end function axial_stiffness

   !> Bending stiffness of an element on (w1, theta1, w2, theta2).
   pure function bending_stiffness(ei, l) result(k)
      !> Bending rigidity E I [force length^2]
      real(wp), intent(in) :: ei
      !> Element length [length]
      real(wp), intent(in) :: l
      real(wp) :: k(4, 4)
      k = reshape([ &
         & 12.0_wp, 6*l, -12.0_wp, 6*l, &
         & 6*l, 4*l**2, -6*l, 2*l**2, &
         & -12.0_wp, -6*l, 12.0_wp, -6*l, &
         & 6*l, 2*l**2, -6*l, 4*l**2], [4, 4])*(ei/l**3)
   end function bending_stiffness

   !> Linear stiffness k_E of an element on all six coordinates, eq. (2.1) of doc/theory.
   pure function beam_stiffness(ea, ei, l) result(k)
      !> Axial rigidity E A [force]
      real(wp), intent(in) :: ea
      !> Bending rigidity E I [force length^2]
      real(wp), intent(in) :: ei
      !> Element length [length]
      real(wp), intent(in) :: l
      real(wp) :: k(6, 6)
      k = 0.0_wp
      k(axial_dofs, axial_dofs) = axial_stiffness(ea, l)
      k(bending_dofs, bending_dofs) = bending_stiffness(ei, l)
   end function beam_stiffness

   !> Geometric stiffness k_G of an element on (w1, theta1, w2, theta2) per unit of its tension P:
   !> the matrix of the integral of w'^2 over the element, w cubic; eq. (2.2) of doc/theory.
   pure function geometric_stiffness(l) result(k)
      !> Element length [length]
      real(wp), intent(in) :: l
      real(wp) :: k(4, 4)
      k = reshape([ &
         & 36.0_wp, 3*l, -36.0_wp, 3*l, &
         & 3*l, 4*l**2, -3*l, -l**2, &
         & -36.0_wp, -3*l, 36.0_wp, -3*l, &
         & 3*l, -l**2, -3*l, 4*l**2], [4, 4])/(30.0_wp*l)
   end function geometric_stiffness

   !> Mass that an element puts on each of its two nodes (translation only; no rotary inertia).
   pure real(wp) function lumped_mass(rho_a, l)
      !> Mass per length [mass/length]
      real(wp), intent(in) :: rho_a
      !> Element length [length]
      real(wp), intent(in) :: l
      lumped_mass = rho_a*l/2
   end function lumped_mass

   !> Cubic shape functions of (w1, theta1, w2, theta2): the deflection at x.
   pure function bending_shape(x, l) result(shape)
      !> Place in the element, 0..l [length]
      real(wp), intent(in) :: x
      !> Element length [length]
      real(wp), intent(in) :: l
      real(wp) :: shape(4), s
      s = x/l
      shape = [1 - 3*s**2 + 2*s**3, l*(s - 2*s**2 + s**3), 3*s**2 - 2*s**3, l*(s**3 - s**2)]
   end function bending_shape

   !> First derivative of the shape functions: the slope w' at x.
   pure function bending_slope(x, l) result(slope)
      !> Place in the element, 0..l [length]
      real(wp), intent(in) :: x
      !> Element length [length]
      real(wp), intent(in) :: l
      real(wp) :: slope(4), s
      s = x/l
      slope = [(6*s**2 - 6*s)/l, 1 - 4*s + 3*s**2, (6*s - 6*s**2)/l, 3*s**2 - 2*s]
   end function bending_slope

   !> Second derivative of the shape functions: the linear curvature w'' at x.
   pure function bending_curvature(x, l) result(curvature)
      !> Place in the element, 0..l [length]
      real(wp), intent(in) :: x
      !> Element length [length]
      real(wp), intent(in) :: l
      real(wp) :: curvature(4), s
      s = x/l
      curvature = [(12*s - 6)/l**2, (6*s - 4)/l, (6 - 12*s)/l**2, (6*s - 2)/l]
   end function bending_curvature

end module limber_beam_element_matrices
