!> Geometric stiffness k_G projected onto the coordinates.
!>
!> With eta_b the bending and eta_a the axial coordinates and z the products eta_i eta_j, i <= j, of the bending coordinates, the
!> work of the tension that the k_G elements get from eta_a is z.(cubic eta_a); its derivatives by eta_b act on the bending (model
!> k_g).
!> Floor: beam. Source: Han and Lee 1993, eq. (12); Przemieniecki, section 15.4; doc/theory, eqs. (2.6), (2.8).
module limber_beam_geometric_stiffness
   use limber_base_kinds, only: wp
   use limber_beam_element_matrices, only: geometric_stiffness, bending_slope, bending_curvature
   use limber_beam_beam_mesh, only: beam_type, displacement_field_type, deflection_at, slope_at, extension_at
   implicit none
   private
   public :: mean_slopes, slope_moments, mean_strains, strain_moments, joined_strains, element_ends, project_cubic
   public :: pair_index

contains

   !> Ends of the k_G elements (0:elements) [length].
   pure function element_ends(length, elements) result(x)
      real(wp), intent(in) :: length
      integer, intent(in) :: elements
      real(wp) :: x(0:elements)
      integer :: g
      x = [(length*g/elements, g=0, elements)]
   end function element_ends

   !> Place of the product eta_i eta_j, i <= j, in z.
   pure integer function pair_index(i, j)
      integer, intent(in) :: i, j
      pair_index = max(i, j)*(max(i, j) - 1)/2 + min(i, j)
   end function pair_index

   !> Matrices B_g of the k_G elements: the mean of w'^2 over element g is eta_b.B_g eta_b.
   pure function mean_slopes(field, x, nodal) result(b)
      type(displacement_field_type), intent(in) :: field
      !> Ends of the k_G elements (0:elements) [length]
      real(wp), intent(in) :: x(0:)
      !> True: a cubic through w and theta at the element's own ends (the paper's way);
      !> false: the exact integral over the fine elements inside
      logical, intent(in) :: nodal
      real(wp) :: b(size(field%w, 2), size(field%w, 2), size(x) - 1)
      real(wp) :: ends(4, size(field%w, 2)), l
      real(wp), allocatable :: place(:), weight(:)
      real(wp) :: slope(size(field%w, 2))
      integer :: g, k, j
      do g = 1, size(x) - 1
         l = x(g) - x(g - 1)
         if (nodal) then
            ends(1, :) = deflection_at(field, x(g - 1))
            ends(2, :) = slope_at(field, x(g - 1), bending_slope)
            ends(3, :) = deflection_at(field, x(g))
            ends(4, :) = slope_at(field, x(g), bending_slope)
            b(:, :, g) = matmul(transpose(ends), matmul(geometric_stiffness(l), ends))/l
         else
            call quadrature(field%s, x(g - 1), x(g), place, weight)
            b(:, :, g) = 0.0_wp
            do k = 1, size(place)
               slope = slope_at(field, place(k), bending_slope)
               do j = 1, size(slope)
                  b(:, j, g) = b(:, j, g) + slope*(slope(j)*weight(k)/l)
               end do
            end do
         end if
         b(:, :, g) = 0.5_wp*(b(:, :, g) + transpose(b(:, :, g)))
      end do
   end function mean_slopes

   !> First moments of w'^2 over the k_G elements: eta_b.B eta_b is the mean of xi w'^2 with xi from -1 to 1 within element g,
   !> eq. (2.10).
   pure function slope_moments(field, x) result(b)
      type(displacement_field_type), intent(in) :: field
      !> Ends of the k_G elements (0:elements) [length]
      real(wp), intent(in) :: x(0:)
      real(wp) :: b(size(field%w, 2), size(field%w, 2), size(x) - 1), l, xi
      real(wp), allocatable :: place(:), weight(:)
      real(wp) :: slope(size(field%w, 2))
      integer :: g, k, j
      b = 0.0_wp
      do g = 1, size(x) - 1
         l = x(g) - x(g - 1)
         call quadrature(field%s, x(g - 1), x(g), place, weight)
         do k = 1, size(place)
            slope = slope_at(field, place(k), bending_slope)
            xi = (2*place(k) - x(g) - x(g - 1))/l
            do j = 1, size(slope)
               b(:, j, g) = b(:, j, g) + slope*(slope(j)*xi*weight(k)/l)
            end do
         end do
      end do
   end function slope_moments

   !> Means over k_G elements of strains that are constant in each of so many equal pieces of them (elements, number).
   pure function joined_strains(strain, pieces) result(mean)
      !> (pieces of all elements, number)
      real(wp), intent(in) :: strain(:, :)
      integer, intent(in) :: pieces
      real(wp) :: mean(size(strain, 1)/pieces, size(strain, 2))
      integer :: g
      do g = 1, size(mean, 1)
         mean(g, :) = sum(strain((g - 1)*pieces + 1:g*pieces, :), dim=1)/pieces
      end do
   end function joined_strains

   !> Slopes e of the strains e xi that are nearest to them beside their means (elements, number).
   pure function strain_moments(strain, pieces) result(moment)
      real(wp), intent(in) :: strain(:, :)
      integer, intent(in) :: pieces
      real(wp) :: moment(size(strain, 1)/pieces, size(strain, 2))
      integer :: g, i
      moment = 0.0_wp
      do g = 1, size(moment, 1)
         do i = 1, pieces
            moment(g, :) = moment(g, :) + 3*((2*i - 1 - pieces)/real(pieces, wp))*strain((g - 1)*pieces + i, :)/pieces
         end do
      end do
   end function strain_moments

   !> Mean axial strain of each axial coordinate over each k_G element (elements, number).
   pure function mean_strains(field, x) result(a)
      type(displacement_field_type), intent(in) :: field
      !> Ends of the k_G elements (0:elements) [length]
      real(wp), intent(in) :: x(0:)
      real(wp) :: a(size(x) - 1, size(field%u, 2))
      integer :: g
      do g = 1, size(x) - 1
         a(g, :) = (extension_at(field, x(g)) - extension_at(field, x(g - 1)))/(x(g) - x(g - 1))
      end do
   end function mean_strains

   !> `cubic` (pairs, axial coordinates): z.(cubic eta_a) is the sum over g of E A l_g e_g b_g / 2.
   pure function project_cubic(ea, x, a, b) result(cubic)
      !> Axial rigidity [force]
      real(wp), intent(in) :: ea
      !> Ends of the k_G elements (0:elements) [length]
      real(wp), intent(in) :: x(0:)
      !> Mean strains (elements, axial), mean squared slopes (bending, bending, elements)
      real(wp), intent(in) :: a(:, :), b(:, :, :)
      real(wp) :: cubic(size(b, 1)*(size(b, 1) + 1)/2, size(a, 2)), pairs(size(cubic, 1))
      integer :: g, j
      cubic = 0.0_wp
      do g = 1, size(a, 1)
         pairs = as_pairs(b(:, :, g))
         do j = 1, size(a, 2)
            cubic(:, j) = cubic(:, j) + 0.5_wp*ea*(x(g) - x(g - 1))*a(g, j)*pairs
         end do
      end do
   end function project_cubic

   !> Coefficients p of a quadratic form with respect to z: eta.b eta = p.z.
   pure function as_pairs(b) result(pairs)
      real(wp), intent(in) :: b(:, :)
      real(wp) :: pairs(size(b, 1)*(size(b, 1) + 1)/2)
      integer :: i, j
      do j = 1, size(b, 1)
         do i = 1, j
            pairs(pair_index(i, j)) = merge(b(i, j), b(i, j) + b(j, i), i == j)
         end do
      end do
   end function as_pairs

   !> Gauss points and weights (four to a piece: exact to degree seven) between two places, piecewise over
   !> the fine elements between them.
   pure subroutine quadrature(s, from, to, place, weight)
      real(wp), intent(in) :: s(0:), from, to
      real(wp), allocatable, intent(out) :: place(:), weight(:)
      real(wp), parameter :: inner = sqrt(3.0_wp/7.0_wp - 2.0_wp/7.0_wp*sqrt(6.0_wp/5.0_wp))
      real(wp), parameter :: outside = sqrt(3.0_wp/7.0_wp + 2.0_wp/7.0_wp*sqrt(6.0_wp/5.0_wp))
      real(wp), parameter :: abscissa(4) = [-outside, -inner, inner, outside]
      real(wp), parameter :: heavy = (18.0_wp + sqrt(30.0_wp))/36.0_wp, light = (18.0_wp - sqrt(30.0_wp))/36.0_wp
      real(wp), parameter :: gauss(4) = [light, heavy, heavy, light]
      real(wp) :: left, right
      integer :: e, n
      allocate (place(4*ubound(s, 1)), weight(4*ubound(s, 1)))
      n = 0
      do e = 1, ubound(s, 1)
         left = max(from, s(e - 1))
         right = min(to, s(e))
         if (right - left <= 1.0e-12_wp*(s(e) - s(e - 1))) cycle
         place(n + 1:n + 4) = 0.5_wp*(left + right) + 0.5_wp*(right - left)*abscissa
         weight(n + 1:n + 4) = 0.5_wp*(right - left)*gauss
         n = n + 4
      end do
      place = place(:n)
      weight = weight(:n)
   end subroutine quadrature

end module limber_beam_geometric_stiffness
